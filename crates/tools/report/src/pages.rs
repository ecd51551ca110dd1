// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pages of a report: which there are, and how they refer to each other.

use crate::ReportError;
use crate::contents::{Part, Report};
use crate::front::front;
use crate::glossary::{Glossary, collect};
use crate::verdict::plural;
use crate::view::{File, Form, INDEX, PAGES, Renderer, slug};
use askama::Template;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use terrafill_results::{Block, Chapter, MetricRow, Run, RunEnvironment, RunPlan, Skipped};

const STYLE: &str = include_str!("../templates/report.css");
const SCRIPT: &str = include_str!("../templates/report.js");
const TITLE: &str = "Measurement report";
const GLOSSARY: &str = "Glossary";
const WORDS: &str = "Words on this page";
const CASES: &str = "Missing, wrong and skipped cases";

/// As many names as the first page shows: about a screen of them.
const MAX_NAMES: usize = 24;

impl Report<'_> {
    /// What the words of its chapters and its first page mean, and every metric of the run.
    fn all_words(&self) -> Result<String, askama::Error> {
        let metrics = self.run.metrics.iter();
        let mut texts = metrics
            .map(|metric| metric.name.replace('_', " "))
            .collect();
        for (_, blocks, answers) in self.parts {
            collect(blocks, &mut texts);
            collect(&answers.blocks, &mut texts);
        }
        self.glossary.of(&texts).render()
    }
}

/// A page to be, beside the first one.
struct Leaf<'a> {
    /// Within the run's folder.
    file: String,
    title: String,
    /// Names its figures' files.
    stem: String,
    /// The study's, on the chapter's own page; else empty.
    question: &'static str,
    blocks: &'a [Block],
}

/// A chapter's line of links: title, address, and its sections' titles and addresses. Addresses are
/// from the run's folder.
struct NavGroup {
    title: String,
    href: String,
    entries: Vec<(String, String)>,
}

impl NavGroup {
    fn from(&self, root: &str) -> Self {
        let href = |href: &String| {
            if href.starts_with('#') {
                href.clone()
            } else {
                format!("{root}{href}")
            }
        };
        let entries = self.entries.iter();
        Self {
            title: self.title.clone(),
            href: href(&self.href),
            entries: entries
                .map(|(title, to)| (title.clone(), href(to)))
                .collect(),
        }
    }
}

enum Assets {
    Inline { style: String, script: &'static str },
    Beside,
}

#[derive(Template)]
#[template(path = "page.html")]
struct Page<'a> {
    title: &'a str,
    /// From the page to the run's folder.
    root: &'a str,
    assets: Assets,
    nav: Vec<NavGroup>,
    /// Its own address as the links to it are written.
    here: &'a str,
    body: String,
}

#[derive(Template)]
#[template(path = "lists.html")]
struct Lists<'a> {
    missing: &'a [String],
    wrong: &'a [String],
    skipped: &'a [Skipped],
    skipped_cases: &'a [(&'a str, Vec<String>)],
    contradictions: &'a [String],
}

/// Every page of the report with the files beside it, the first page last.
///
/// # Errors
/// When a template cannot be rendered.
pub(crate) fn pages(report: &Report<'_>) -> Result<Vec<File>, ReportError> {
    match report.form {
        Form::Pages => several(report),
        Form::SingleFile => single(report),
    }
}

fn several(report: &Report<'_>) -> Result<Vec<File>, ReportError> {
    const ROOT: &str = "../";
    let leaves: Vec<Leaf<'_>> = report.parts.iter().flat_map(leaves).collect();
    let links = links(&leaves);
    let mut nav: Vec<NavGroup> = vec![NavGroup {
        title: TITLE.to_owned(),
        href: INDEX.to_owned(),
        entries: Vec::new(),
    }];
    nav.extend(report.parts.iter().map(|part| nav_group(part, &links)));
    let glossary = format!("{PAGES}/glossary.html");
    let mut appendix = NavGroup {
        title: GLOSSARY.to_owned(),
        href: glossary.clone(),
        entries: Vec::new(),
    };
    let cases = format!("{PAGES}/cases.html");
    if is_long(report) {
        appendix.entries.push((CASES.to_owned(), cases.clone()));
    }
    nav.push(appendix);

    let page = |title: &str, file: &str, root: &'static str, body: String| {
        let here = format!("{root}{file}");
        let page = Page {
            title,
            root,
            assets: Assets::Beside,
            nav: nav.iter().map(|group| group.from(root)).collect(),
            here: &here,
            body,
        };
        Ok::<File, ReportError>((file.to_owned(), once(&page.render()?).into_bytes()))
    };
    let mut files: Vec<File> = vec![
        (format!("{PAGES}/report.css"), style().into_bytes()),
        (format!("{PAGES}/report.js"), SCRIPT.as_bytes().to_vec()),
    ];
    let mut absent = BTreeSet::new();
    for leaf in &leaves {
        let mut renderer = Renderer::new(report.run, report.form, &leaf.stem, ROOT, &links);
        let mut body = asked(leaf.question) + &renderer.html(leaf.blocks)?;
        body.push_str(&words(&report.glossary, [leaf.blocks])?);
        absent.append(&mut renderer.take_absent());
        files.extend(renderer.into_files());
        files.push(page(&leaf.title, &leaf.file, ROOT, body)?);
    }
    files.push(page(GLOSSARY, &glossary, ROOT, report.all_words()?)?);
    let lists = if is_long(report) {
        files.push(page(CASES, &cases, ROOT, lists(report)?)?);
        shortened(report, &cases)
    } else {
        lists(report)?
    };
    let mut renderer = Renderer::new(report.run, report.form, "index", "", &links);
    let mut body = front(report, &mut renderer, lists, absent)?;
    let answers = report.parts.iter();
    let answers = answers.map(|(_, _, answers)| answers.blocks.as_slice());
    body.push_str(&words(&report.glossary, answers)?);
    files.extend(renderer.into_files());
    files.push(page(TITLE, INDEX, "", body)?);
    Ok(files)
}

fn single(report: &Report<'_>) -> Result<Vec<File>, ReportError> {
    let links: BTreeMap<String, String> = report
        .parts
        .iter()
        .flat_map(|(_, blocks, _)| links_within(blocks))
        .collect();
    let mut renderer = Renderer::new(report.run, report.form, "report", "", &links);
    let mut chapters = String::new();
    // The only one is open: there is nothing to choose.
    let is_open = report.parts.len() == 1;
    for (chapter, blocks, _) in report.parts {
        let heading = format!(
            "<h2 id=\"{}\">{}</h2> <span class=\"question\">{}</span>",
            part_id(*chapter),
            chapter.title(),
            chapter.question()
        );
        let (head, sections) = split(blocks);
        let mut html = renderer.html(head)?;
        for (heading, blocks) in sections {
            let heading = renderer.html(std::slice::from_ref(heading))?;
            html.push_str(&folded(false, heading.trim(), &renderer.html(blocks)?));
        }
        chapters.push_str(&folded(is_open, &heading, &html));
    }
    let mut body = front(report, &mut renderer, lists(report)?, BTreeSet::new())?;
    let glossary = report.all_words()?;
    body.push_str(&chapters);
    let heading = format!("<h2 id=\"glossary\">{GLOSSARY}</h2>");
    body.push_str(&folded(false, &heading, &glossary));
    let mut nav: Vec<NavGroup> = Vec::new();
    for (chapter, blocks, _) in report.parts {
        nav.push(NavGroup {
            title: chapter.title().to_owned(),
            href: format!("#{}", part_id(*chapter)),
            entries: links_within(blocks).collect(),
        });
    }
    nav.push(NavGroup {
        title: GLOSSARY.to_owned(),
        href: "#glossary".to_owned(),
        entries: vec![("Environment".to_owned(), "#environment".to_owned())],
    });
    let page = inline_page(TITLE, nav, body)?;
    Ok(vec![(INDEX.to_owned(), page.into_bytes())])
}

/// A part of the page that a reader opens by its heading.
fn folded(is_open: bool, heading: &str, html: &str) -> String {
    let open = if is_open { " open" } else { "" };
    format!("<details class=\"part\"{open}><summary>{heading}</summary>\n{html}</details>\n")
}

/// A study's question; nothing where there is none.
fn asked(question: &str) -> String {
    match question {
        "" => String::new(),
        question => format!("<p class=\"question\">{question}</p>\n"),
    }
}

/// What the words of a page mean, folded at its end: its script says each where it stands.
fn words<'a>(
    glossary: &Glossary,
    parts: impl IntoIterator<Item = &'a [Block]>,
) -> Result<String, askama::Error> {
    let mut texts = BTreeSet::new();
    for blocks in parts {
        collect(blocks, &mut texts);
    }
    let entries = glossary.of(&texts).render()?;
    Ok(format!(
        "<details class=\"words\"><summary>{WORDS}</summary>\n{entries}</details>\n"
    ))
}

/// A page that needs no other file.
fn inline_page(title: &str, nav: Vec<NavGroup>, body: String) -> Result<String, askama::Error> {
    let page = Page {
        title,
        root: "",
        assets: Assets::Inline {
            style: style(),
            script: SCRIPT,
        },
        nav,
        here: "",
        body,
    };
    Ok(once(&page.render()?))
}

/// One page of these blocks that needs no other file.
///
/// - `metrics`: declarations that headings refer to
///
/// # Errors
/// When a template cannot be rendered.
pub(crate) fn alone(
    title: &str,
    blocks: &[Block],
    metrics: Vec<MetricRow>,
) -> Result<String, askama::Error> {
    let run = Run {
        path: PathBuf::new(),
        environment: RunEnvironment::default(),
        plan: RunPlan::default(),
        metrics,
        primary: BTreeMap::new(),
        cases: Vec::new(),
    };
    let links = links_within(blocks).collect();
    let mut body = Renderer::new(&run, Form::SingleFile, "page", "", &links).html(blocks)?;
    body.push_str(&words(&Glossary::new([], &run.metrics), [blocks])?);
    let nav = NavGroup {
        title: title.to_owned(),
        href: "#".to_owned(),
        entries: links_within(blocks).collect(),
    };
    inline_page(title, vec![nav], body)
}

fn part_id(chapter: &dyn Chapter) -> String {
    format!("chapter-{}", slug(chapter.study()))
}

fn style() -> String {
    let dark = terrafill_plot::dark_rules();
    format!("{STYLE}@media screen and (prefers-color-scheme: dark) {{ {dark} }}\n")
}

/// Titles of the sections among the blocks, and their addresses on the same page.
fn links_within(blocks: &[Block]) -> impl Iterator<Item = (String, String)> {
    sections(blocks).map(|title| (title.to_owned(), format!("#{}", slug(title))))
}

/// Titles of the sections among the blocks.
fn sections(blocks: &[Block]) -> impl Iterator<Item = &str> {
    blocks.iter().filter_map(section_title)
}

fn section_title(block: &Block) -> Option<&str> {
    match block {
        Block::Heading { level: 3, text } => Some(text),
        _ => None,
    }
}

/// What comes before the first section, and each section's heading with its blocks.
fn split(blocks: &[Block]) -> (&[Block], Vec<(&Block, &[Block])>) {
    let starts = |block: &Block| section_title(block).is_some();
    let first = blocks.iter().position(starts).unwrap_or(blocks.len());
    let (head, mut rest) = blocks.split_at(first);
    let mut sections = Vec::new();
    while let Some((heading, after)) = rest.split_first() {
        let length = after.iter().position(starts).unwrap_or(after.len());
        sections.push((heading, &after[..length]));
        rest = &after[length..];
    }
    (head, sections)
}

/// The chapter's pages: one, or one for what comes before its sections and one for each of them.
fn leaves<'a>((chapter, blocks, _): &'a Part<'a>) -> Vec<Leaf<'a>> {
    let study = slug(chapter.study());
    let whole = |blocks| Leaf {
        file: format!("{PAGES}/{study}.html"),
        title: chapter.title().to_owned(),
        stem: study.clone(),
        question: chapter.question(),
        blocks,
    };
    if !chapter.has_long_sections() {
        return vec![whole(blocks.as_slice())];
    }
    let (head, sections) = split(blocks);
    let mut leaves = vec![whole(head)];
    leaves.extend(sections.into_iter().map(|(heading, blocks)| {
        let title = section_title(heading).unwrap_or_default();
        let stem = format!("{study}-{}", slug(title));
        Leaf {
            file: format!("{PAGES}/{stem}.html"),
            title: title.to_owned(),
            stem,
            question: "",
            blocks,
        }
    }));
    leaves
}

/// Addresses of chapters and sections by title.
fn links(leaves: &[Leaf<'_>]) -> BTreeMap<String, String> {
    let mut links = BTreeMap::new();
    for leaf in leaves {
        links.insert(leaf.title.clone(), leaf.file.clone());
        for title in sections(leaf.blocks) {
            links.insert(title.to_owned(), format!("{}#{}", leaf.file, slug(title)));
        }
    }
    links
}

fn nav_group((chapter, blocks, _): &Part<'_>, links: &BTreeMap<String, String>) -> NavGroup {
    let entry = |title: &str| Some((title.to_owned(), links.get(title)?.clone()));
    NavGroup {
        title: chapter.title().to_owned(),
        href: links.get(chapter.title()).cloned().unwrap_or_default(),
        entries: sections(blocks).filter_map(entry).collect(),
    }
}

/// Whether the lists of cases need a page of their own.
fn is_long(report: &Report<'_>) -> bool {
    let skipped: usize = report.skipped_cases.iter().map(|(_, c)| c.len()).sum();
    report.missing.len() + report.wrong.len() + report.contradictions.len() + skipped > MAX_NAMES
}

fn lists(report: &Report<'_>) -> Result<String, askama::Error> {
    Lists {
        missing: report.missing,
        wrong: &report.wrong,
        skipped: &report.run.plan.skipped,
        skipped_cases: &report.skipped_cases,
        contradictions: &report.contradictions,
    }
    .render()
}

/// How many there are, and where they are named.
fn shortened(report: &Report<'_>, cases: &str) -> String {
    let skipped: usize = report.skipped_cases.iter().map(|(_, c)| c.len()).sum();
    let counts = [
        (report.missing.len(), "missing case"),
        (report.wrong.len(), "wrong or failed case"),
        (skipped, "skipped case"),
        (report.contradictions.len(), "contradiction"),
    ];
    let some = counts.iter().filter(|(count, _)| *count > 0);
    let some: Vec<String> = some.map(|(count, noun)| plural(*count, noun)).collect();
    format!(
        "<section><h2>Cases without a right result</h2><p>{}: <a href=\"{cases}\">all by \
         name</a>.</p></section>",
        some.join(", ")
    )
}

/// The page with each command written out once: an element that repeats one has the first one's number among the
/// elements with commands, which the page's script reads.
fn once(page: &str) -> String {
    const BEGIN: &str = "data-command=\"";
    let mut pieces = page.split(BEGIN);
    let mut shortened = pieces.next().unwrap_or_default().to_owned();
    let mut first: BTreeMap<&str, usize> = BTreeMap::new();
    for (number, piece) in pieces.enumerate() {
        let (command, rest) = piece.split_once('"').unwrap_or((piece, ""));
        shortened.push_str(BEGIN);
        if let Some(first) = first.get(command) {
            shortened.push_str(&format!("@{first}"));
        } else {
            first.insert(command, number);
            shortened.push_str(command);
        }
        shortened.push('"');
        shortened.push_str(rest);
    }
    shortened
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_written_once_and_found_again_by_its_number() {
        let page = "<td data-command=\"a\">1</td><td data-command=\"b\">2</td><td data-command=\"a\">3</td>";
        let shortened = once(page);
        assert_eq!(
            shortened,
            "<td data-command=\"a\">1</td><td data-command=\"b\">2</td><td data-command=\"@0\">3</td>"
        );
        // Control: commands that differ stay as they are.
        let others = page.replacen("\"a\"", "\"c\"", 1);
        assert_eq!(once(&others), others);
    }
}
