// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pages for people: links lead somewhere, quoted code is the code, commands have verbs and options that there are, and
//! two pages stay short.
//!
//! A quotation is a block of code under a comment that names a file and how the quoted item begins:
//! `<!-- quoted: crates/a/src/b.rs: fn c( -->`. So a guide's example is compiled and tested as part of the
//! program, and cannot fall behind it. `cargo xtask quote-docs` writes the blocks anew.
//!
//! A link whose text is a name in code and whose target is a source file says that the file has that name:
//! ``[`parse_regions`](../crates/ground/core/src/geojson.rs)``.

use crate::source::is_name as is_word;
use anyhow::{Context as _, Result, bail};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Folders whose Markdown files are pages; files of folders below them are not.
const FOLDERS: [&str; 6] = ["", "docs", "bench-scenes", "papers", "reports", "shaders"];

/// Pages that are read to the end, with the bytes that they may have.
const MAX_BYTES: [(&str, usize); 2] = [("ARCHITECTURE.md", 8_000), ("CHANGELOG.md", 6_000)];

/// Where verbs and options of the program are declared.
const ARGUMENTS: &str = "crates/tools/terrafill/src/arguments.rs";

/// How a comment that announces a quotation begins and ends.
const QUOTED: [&str; 2] = ["<!-- quoted: ", " -->"];

/// What is said of a page whose quotations are not the code.
const RENEW: &str = "code is quoted that has changed, `cargo xtask quote-docs` renews it";

/// A Markdown file.
struct Page {
    /// Relative to the repository.
    name: String,
    path: PathBuf,
    text: String,
}

/// A link outside of blocks of code.
struct Link<'a> {
    text: &'a str,
    target: &'a str,
}

pub(crate) fn check(root: &Path) -> Result<String> {
    let pages = pages(root)?;
    let mut arguments = std::fs::read_to_string(root.join(ARGUMENTS)).context(ARGUMENTS)?;
    // Verbs with many options have files of their own beside it.
    let parts = std::fs::read_dir(root.join(ARGUMENTS).with_extension(""));
    for part in parts.into_iter().flatten().flatten() {
        arguments += &std::fs::read_to_string(part.path()).context(ARGUMENTS)?;
    }
    let (mut wrong, mut links, mut quotations, mut commands) = (Vec::new(), 0, 0, 0);
    for page in &pages {
        let found = links_of(&page.text);
        links += found.len();
        let refused = found.iter().filter_map(|link| objection(&page.path, link));
        wrong.extend(refused.map(|why| format!("{}: {why}", page.name)));
        match with_quotations(root, page) {
            Err(error) => wrong.push(format!("{error:#}")),
            Ok((renewed, count)) => {
                quotations += count;
                let is_old = (renewed != page.text).then_some(&page.name);
                wrong.extend(is_old.map(|name| format!("{name}: {RENEW}")));
            }
        }
        for command in commands_of(&page.text) {
            commands += 1;
            let unknown = unknown_words(command, &arguments).into_iter();
            wrong.extend(
                unknown.map(|word| format!("{}: {word} of `{command}` is not declared", page.name)),
            );
        }
        wrong.extend(too_long(page));
    }
    if !wrong.is_empty() {
        bail!("{} faults in pages\n{}", wrong.len(), wrong.join("\n"));
    }
    if links == 0 || quotations == 0 {
        bail!("{links} links and {quotations} quotations found: the pages were not read");
    }
    Ok(format!(
        "{} pages: {links} links lead somewhere, {quotations} quotations are the code, {commands} commands have verbs and \
         options that there are",
        pages.len()
    ))
}

/// Writes the quotations of every page as the code is now.
pub(crate) fn quote(root: &Path) -> Result<String> {
    let (mut changed, mut all) = (0, 0);
    for page in pages(root)? {
        let (renewed, count) = with_quotations(root, &page)?;
        all += count;
        if renewed != page.text {
            std::fs::write(&page.path, renewed).with_context(|| page.name.clone())?;
            changed += 1;
        }
    }
    Ok(format!("{all} quotations, {changed} pages changed"))
}

fn pages(root: &Path) -> Result<Vec<Page>> {
    let mut pages = Vec::new();
    for folder in FOLDERS {
        let Ok(entries) = std::fs::read_dir(root.join(folder)) else {
            continue;
        };
        for entry in entries {
            let path = entry?.path();
            if path.extension().is_some_and(|ending| ending == "md") {
                let name = path.strip_prefix(root)?.display().to_string();
                let text = std::fs::read_to_string(&path).with_context(|| name.clone())?;
                pages.push(Page { name, path, text });
            }
        }
    }
    pages.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(pages)
}

fn too_long(page: &Page) -> Option<String> {
    let (name, max) = MAX_BYTES.into_iter().find(|(name, _)| *name == page.name)?;
    let bytes = page.text.len();
    (bytes > max).then(|| format!("{name}: {bytes} bytes, allowed: {max}"))
}

/// Lines outside of blocks of code.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    })
}

/// Commands of the program in blocks of shell, each from its verb on.
fn commands_of(text: &str) -> Vec<&str> {
    let blocks = text.split("\n```sh\n").skip(1);
    let lines = blocks.flat_map(|block| block.split("\n```").next().unwrap_or_default().lines());
    let parts = lines.flat_map(|line| line.split(" # ").next().unwrap_or_default().split("&&"));
    let verbs = parts.filter_map(|part| {
        let part = part.trim();
        let by_cargo = part
            .strip_prefix("cargo run")
            .and_then(|run| run.split_once(" -p terrafill -- "));
        part.strip_prefix("terrafill ")
            .or(by_cargo.map(|(_, command)| command))
    });
    verbs.collect()
}

/// The verb and the options of a command that `arguments` does not declare.
fn unknown_words<'a>(command: &'a str, arguments: &str) -> Vec<&'a str> {
    let declared: BTreeSet<&str> = arguments.split(|c| !is_word(c)).collect();
    let words = command.split_whitespace().enumerate();
    let named = words.filter(|(at, word)| *at == 0 || word.starts_with("--"));
    let unknown = named.filter(|(_, word)| !declared.contains(declared_as(word).as_str()));
    unknown.map(|(_, word)| word).collect()
}

/// The field of an option, the variant of a verb: `in_suite` of `--in-suite=1`, `GrowthSample` of `growth-sample`.
fn declared_as(word: &str) -> String {
    if let Some(option) = word.strip_prefix("--") {
        let (name, _) = option.split_once('=').unwrap_or((option, ""));
        return name.replace('-', "_");
    }
    let capitalised = word.split('-').flat_map(|part| {
        let mut letters = part.chars();
        let first = letters.next();
        first
            .into_iter()
            .flat_map(char::to_uppercase)
            .chain(letters)
    });
    capitalised.collect()
}

/// Links and pictures, each in a line of its own page.
fn links_of(text: &str) -> Vec<Link<'_>> {
    let mut links = Vec::new();
    for line in prose(text) {
        let mut rest = line;
        while let Some((before, after)) = rest.split_once("](") {
            let (target, next) = after.split_once(')').unwrap_or((after, ""));
            let text = before.rsplit_once('[').map_or("", |(_, text)| text);
            links.push(Link { text, target });
            rest = next;
        }
    }
    links
}

/// Why a link leads nowhere, if it does.
fn objection(page: &Path, Link { text, target }: &Link<'_>) -> Option<String> {
    if target.contains("://") {
        return None;
    }
    let (file, heading) = target.split_once('#').unwrap_or((target, ""));
    let folder = page.parent().unwrap_or(page);
    let path = if file.is_empty() {
        page.to_path_buf()
    } else {
        folder.join(file)
    };
    if !path.exists() {
        return Some(format!("{target}: there is no such file"));
    }
    let content = || std::fs::read_to_string(&path).unwrap_or_default();
    if !heading.is_empty() && !headings(&content()).any(|found| found == heading) {
        return Some(format!("{target}: there is no such heading"));
    }
    let name = text.strip_prefix('`')?.strip_suffix('`')?;
    // `Type::function`, `function()` and `macro!` by their last name.
    let name = name.trim_end_matches(['(', ')', '!']).rsplit("::").next()?;
    let is_name =
        path.extension().is_some_and(|ending| ending == "rs") && name.chars().all(is_word);
    let has_it = || content().split(|c| !is_word(c)).any(|word| word == name);
    (is_name && !has_it()).then(|| format!("{target}: {name} is not in it"))
}

/// Headings as links name them: lower case, hyphens for spaces, no marks.
fn headings(text: &str) -> impl Iterator<Item = String> {
    let lines = prose(text).filter(|line| line.starts_with('#'));
    lines.map(|line| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    })
}

/// A page with its quotations as the code is now, and their number.
fn with_quotations(root: &Path, page: &Page) -> Result<(String, usize)> {
    let (mut renewed, mut count) = (String::new(), 0);
    let mut lines = page.text.lines();
    while let Some(line) = lines.next() {
        renewed += line;
        renewed.push('\n');
        let Some(named) = line.strip_prefix(QUOTED[0]) else {
            continue;
        };
        let place = || format!("{}: {line}", page.name);
        let named = named.strip_suffix(QUOTED[1]).with_context(place)?;
        let (file, begins) = named.split_once(": ").with_context(place)?;
        let source = std::fs::read_to_string(root.join(file)).with_context(place)?;
        let fence = lines.next().filter(|line| line.starts_with("```"));
        let fence = fence.with_context(|| format!("{}: no block of code follows", place()))?;
        if !lines.by_ref().any(|line| line == "```") {
            bail!("{}: its block does not end", place());
        }
        let item = item(&source, begins).with_context(place)?;
        renewed += &format!("{fence}\n{item}```\n");
        count += 1;
    }
    Ok((renewed, count))
}

/// The item of `source` whose first line begins with `begins`, with what is said above it, as far left as it goes.
///
/// It ends where its brackets are closed and a line ends with `;`, `,` or `}`.
fn item(source: &str, begins: &str) -> Result<String> {
    let lines: Vec<&str> = source.lines().collect();
    let mut places = (0..lines.len()).filter(|&at| lines[at].trim_start().starts_with(begins));
    let (Some(at), None) = (places.next(), places.next()) else {
        bail!("not exactly one line of the file begins with {begins:?}");
    };
    let indent = lines[at].len() - lines[at].trim_start().len();
    let is_above = |line: &&&str| {
        let text = line.trim_start();
        line.len() - text.len() == indent && (text.starts_with("//") || text.starts_with("#["))
    };
    let above = lines[..at].iter().rev().take_while(is_above).count();
    let mut open = 0;
    for (end, line) in lines.iter().enumerate().skip(at) {
        let count = |brackets: [char; 3]| line.matches(brackets).count();
        open += count(['(', '[', '{']);
        open = open.saturating_sub(count([')', ']', '}']));
        if open == 0 && line.ends_with([';', ',', '}']) {
            let kept = lines[at - above..=end].iter();
            let kept = kept.map(|line| format!("{}\n", line.get(indent..).unwrap_or_default()));
            return Ok(kept.collect());
        }
    }
    bail!("what begins with {begins:?} does not end");
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "\
mod tests {
    /// Two lines.
    #[must_use]
    fn first(
        a: u32,
    ) -> u32 {
        [a][0]
    }

    const SECOND: &str =
        \"b\";
    fn endless() {
";

    /// A repository of one page and one source file.
    fn repository(page: &str) -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a folder");
        std::fs::write(root.path().join("PAGE.md"), page).expect("writable");
        std::fs::write(root.path().join("source.rs"), SOURCE).expect("writable");
        let arguments = root.path().join(ARGUMENTS);
        std::fs::create_dir_all(arguments.parent().expect("a folder")).expect("writable");
        std::fs::write(
            arguments,
            "enum Verb { Bench, GrowthSample }\nmatrix_of: u32\n",
        )
        .expect("writable");
        root
    }

    fn quoting(begins: &str, block: &str) -> String {
        format!(
            "# A page\n\n[`first`](source.rs)\n\n<!-- quoted: source.rs: {begins} -->\n```rust\n{block}```\n"
        )
    }

    #[test]
    fn an_item_is_quoted_whole_with_what_is_said_above_it() {
        let first = item(SOURCE, "fn first").expect("it ends");
        let expected =
            "/// Two lines.\n#[must_use]\nfn first(\n    a: u32,\n) -> u32 {\n    [a][0]\n}\n";
        assert_eq!(first, expected);
        let second = item(SOURCE, "const SECOND").expect("it ends");
        assert_eq!(second, "const SECOND: &str =\n    \"b\";\n");
        for begins in ["fn third", "fn ", "fn endless"] {
            assert!(item(SOURCE, begins).is_err(), "{begins}");
        }
    }

    #[test]
    fn a_quotation_that_is_not_the_code_is_refused_until_it_is_renewed() {
        let root = repository(&quoting("const SECOND", "const SECOND: &str = \"c\";\n"));
        let error = check(root.path()).expect_err("another value");
        assert!(
            error.to_string().contains("PAGE.md: code is quoted"),
            "{error}"
        );
        assert_eq!(
            quote(root.path()).expect("written"),
            "1 quotations, 1 pages changed"
        );
        let said = check(root.path()).expect("renewed");
        let expected = "1 pages: 1 links lead somewhere, 1 quotations are the code, 0 commands";
        assert!(said.starts_with(expected), "{said}");
        assert_eq!(
            quote(root.path()).expect("read"),
            "1 quotations, 0 pages changed"
        );
        // Controls: a source that is gone, a name that is, and a comment without a block.
        let renamed = quoting("const THIRD", "");
        let elsewhere = quoting("fn first", "").replace("quoted: source.rs", "quoted: other.rs");
        let bare = "<!-- quoted: source.rs: fn first -->\ntext\n".to_owned();
        for page in [renamed, elsewhere, bare] {
            assert!(quote(repository(&page).path()).is_err(), "{page}");
        }
    }

    #[test]
    fn a_link_that_leads_nowhere_is_refused() {
        let page = Path::new("PAGE.md");
        let judged = |text: &str| -> Vec<String> {
            let root = repository("# First heading: a, b\n\n```sh\n# none\n```\n");
            let page = root.path().join(page);
            let links = links_of(text);
            links
                .iter()
                .filter_map(|link| objection(&page, link))
                .collect()
        };
        for right in [
            "[a](PAGE.md), ![b](source.rs) and [c](https://example.org/none)",
            "[a](#first-heading-a-b) and [b](PAGE.md#first-heading-a-b)",
            "[`first`](source.rs), [`tests::first()`](source.rs), [`source.rs`](source.rs)",
            "```\n[a](none.md)\n```",
        ] {
            assert_eq!(judged(right), Vec::<String>::new(), "{right}");
        }
        for (wrong, why) in [
            (
                "[a](PAGE.md) [b](none.md)",
                "none.md: there is no such file",
            ),
            ("[a](#none)", "#none: there is no such heading"),
            ("[`second`](source.rs)", "source.rs: second is not in it"),
        ] {
            assert_eq!(judged(wrong), [why]);
        }
        // A repository without links has not been read.
        assert!(check(repository("# A page\n").path()).is_err());
    }

    #[test]
    fn a_command_that_the_program_does_not_have_is_refused() {
        let block =
            |lines: &str| format!("terrafill none\n\n```sh\n{lines}\n```\n\nterrafill none\n");
        let arguments = "enum Verb { Bench, GrowthSample }\nmatrix_of: u32\n";
        let unknown = |lines: &str| -> Vec<String> {
            let text = block(lines);
            let commands = commands_of(&text).into_iter();
            let unknown = commands.flat_map(|command| unknown_words(command, arguments));
            unknown.map(str::to_owned).collect()
        };
        let right = "terrafill bench a --matrix-of=b && cargo run --release -p terrafill -- growth-sample # --none\nls --none";
        assert_eq!(unknown(right), Vec::<String>::new());
        assert_eq!(commands_of(&block(right)).len(), 2);
        let wrong = "terrafill render --matrix-of a\ncargo run -p terrafill -- bench --none 1";
        assert_eq!(unknown(wrong), ["render", "--none"]);
        let page = quoting("const SECOND", "const SECOND: &str =\n    \"b\";\n") + &block(wrong);
        let error = check(repository(&page).path())
            .expect_err("unknown words")
            .to_string();
        assert!(
            error.starts_with("2 faults") && error.contains("--none of `bench --none 1`"),
            "{error}"
        );
    }

    #[test]
    fn a_page_beyond_its_bytes_is_refused() {
        let (name, max) = MAX_BYTES[0];
        let page = |bytes: usize| Page {
            name: name.to_owned(),
            path: PathBuf::from(name),
            text: "a".repeat(bytes),
        };
        assert_eq!(too_long(&page(max)), None);
        assert!(too_long(&page(max + 1)).is_some());
    }
}
