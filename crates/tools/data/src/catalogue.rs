// SPDX-License-Identifier: MIT OR Apache-2.0
//! The catalogue: TOML in, checked data sets out.

use crate::make::makers;
use crate::state::PinnedFile;
use serde::Deserialize;
use std::path::{Component, Path};
use terrafill_scene::choices;

/// The catalogue that ships.
const SHIPPED: &str = include_str!("../catalogue.toml");

/// Why a text is no catalogue.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CatalogueError {
    /// Not TOML, or keys that mean nothing.
    #[error("{file}: {message}")]
    Syntax {
        /// The catalogue.
        file: String,
        /// The parser's words.
        message: String,
    },
    /// A value outside what is allowed.
    #[error("{file}: {key}: found {found:?}, allowed: {allowed}")]
    Value {
        /// The catalogue.
        file: String,
        /// Path of the key, such as `sets[2].bytes`.
        key: String,
        /// The value.
        found: String,
        /// What it may be.
        allowed: String,
    },
}

/// A name that is none of a data set.
#[derive(Debug, thiserror::Error)]
#[error("data set: found {found}, allowed: {allowed}")]
pub struct UnknownSet {
    /// The name, and whether it begins several.
    found: String,
    /// Names there are, or those that begin so.
    allowed: String,
}

/// What can be fetched, and what cannot.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Catalogue {
    /// In the order in which they are listed.
    pub sets: Vec<DataSet>,
    /// Files that scenes read and that no set gives.
    #[serde(default)]
    pub missing: Vec<MissingFile>,
}

/// A published file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataSet {
    /// Lower-case letters, digits and `-`.
    pub name: String,
    /// Another, shorter name.
    pub short: Option<String>,
    /// A phrase.
    pub what: String,
    /// Under which terms it is published.
    pub licence: String,
    /// Where it is published.
    pub url: String,
    /// Size, bytes.
    pub bytes: u64,
    /// SHA-256, lower-case hexadecimal.
    pub sha256: String,
    /// Path in the data folder.
    pub file: String,
    /// Files that are made from it.
    #[serde(default)]
    pub made: Vec<MadeFile>,
}

/// A file that is made from a data set, the same bytes each time.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MadeFile {
    /// Name of the conversion.
    pub by: String,
    /// Size, bytes.
    pub bytes: u64,
    /// SHA-256, lower-case hexadecimal.
    pub sha256: String,
    /// Path in the data folder.
    pub file: String,
}

/// A file that scenes read and that cannot be fetched.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MissingFile {
    /// Path in the data folder.
    pub file: String,
    /// SHA-256, lower-case hexadecimal.
    pub sha256: String,
    /// What is the matter.
    pub why: String,
}

impl DataSet {
    /// The published file.
    #[must_use]
    pub fn published(&self) -> PinnedFile<'_> {
        PinnedFile {
            path: &self.file,
            sha256: &self.sha256,
            bytes: Some(self.bytes),
        }
    }
}

impl MadeFile {
    /// The file as it is checked.
    #[must_use]
    pub fn pinned(&self) -> PinnedFile<'_> {
        PinnedFile {
            path: &self.file,
            sha256: &self.sha256,
            bytes: Some(self.bytes),
        }
    }
}

impl MissingFile {
    /// The file as it is checked.
    #[must_use]
    pub fn pinned(&self) -> PinnedFile<'_> {
        PinnedFile {
            path: &self.file,
            sha256: &self.sha256,
            bytes: None,
        }
    }
}

impl Catalogue {
    /// The catalogue that ships with the program.
    ///
    /// # Errors
    /// [`CatalogueError`], which a test rules out.
    pub fn shipped() -> Result<Self, CatalogueError> {
        Self::from_toml(SHIPPED, "catalogue.toml")
    }

    /// A catalogue from its text; `file` is for messages.
    ///
    /// # Errors
    /// [`CatalogueError`]
    pub fn from_toml(text: &str, file: &str) -> Result<Self, CatalogueError> {
        let catalogue: Self = toml::from_str(text).map_err(|error| CatalogueError::Syntax {
            file: file.to_owned(),
            message: error.to_string().trim_end().replace('\n', " "),
        })?;
        catalogue
            .first_fault()
            .map_or(Ok(()), |(key, found, allowed)| {
                Err(CatalogueError::Value {
                    file: file.to_owned(),
                    key,
                    found,
                    allowed,
                })
            })?;
        Ok(catalogue)
    }

    /// The set called `name`, or the only one whose name begins so.
    ///
    /// # Errors
    /// [`UnknownSet`]
    pub fn find(&self, name: &str) -> Result<&DataSet, UnknownSet> {
        let is_it = |set: &&DataSet| set.name == name || set.short.as_deref() == Some(name);
        if let Some(set) = self.sets.iter().find(is_it) {
            return Ok(set);
        }
        let begins = |set: &&DataSet| !name.is_empty() && set.name.starts_with(name);
        let found: Vec<&DataSet> = self.sets.iter().filter(begins).collect();
        let names =
            |sets: &[&DataSet], like| choices(like, sets.iter().map(|set| set.name.as_str()));
        match found.as_slice() {
            [set] => Ok(set),
            [] => Err(UnknownSet {
                found: format!("{name:?}"),
                allowed: names(&self.sets.iter().collect::<Vec<_>>(), name),
            }),
            several => Err(UnknownSet {
                found: format!("{name:?}, which begins several names"),
                allowed: format!("one of {}", names(several, "")),
            }),
        }
    }

    /// Key, value and what is allowed of the first value that may not be.
    fn first_fault(&self) -> Option<(String, String, String)> {
        let fault = |key: String, found: &str, allowed: &str| {
            Some((key, found.to_owned(), allowed.to_owned()))
        };
        let mut names: Vec<&str> = Vec::new();
        let mut files: Vec<&str> = Vec::new();
        for (i, set) in self.sets.iter().enumerate() {
            let key = |name: &str| format!("sets[{i}].{name}");
            let set_names = [("name", Some(&set.name)), ("short", set.short.as_ref())];
            for (what, name) in set_names {
                let Some(name) = name else { continue };
                if !is_name(name) {
                    return fault(key(what), name, "lower-case letters, digits and -");
                }
                if names.contains(&name.as_str()) {
                    return fault(key(what), name, "a name of its own");
                }
                names.push(name);
            }
            if !(set.url.starts_with("https://") && path_of(&set.url).is_some()) {
                return fault(key("url"), &set.url, "https://HOST/PATH");
            }
            let made = set.made.iter().enumerate();
            let made = made.map(|(j, made)| (format!("made[{j}]."), made.pinned()));
            for (prefix, file) in std::iter::once((String::new(), set.published())).chain(made) {
                let key = |name: &str| key(&format!("{prefix}{name}"));
                if let Some((name, found, allowed)) = file_fault(&file, &files) {
                    return fault(key(name), &found, allowed);
                }
                files.push(file.path);
            }
            for (j, made) in set.made.iter().enumerate() {
                if !makers().any(|maker| maker == made.by) {
                    let allowed: Vec<&str> = makers().collect();
                    return fault(key(&format!("made[{j}].by")), &made.by, &allowed.join(", "));
                }
            }
        }
        for (i, missing) in self.missing.iter().enumerate() {
            if let Some((name, found, allowed)) = file_fault(&missing.pinned(), &files) {
                return fault(format!("missing[{i}].{name}"), &found, allowed);
            }
            files.push(&missing.file);
        }
        None
    }
}

fn is_name(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    !name.is_empty() && !name.starts_with('-') && name.chars().all(plain)
}

fn file_fault(
    file: &PinnedFile<'_>,
    others: &[&str],
) -> Option<(&'static str, String, &'static str)> {
    let is_inside = |part: Component<'_>| matches!(part, Component::Normal(_));
    let path = Path::new(file.path);
    if file.path.is_empty() || !path.components().all(is_inside) {
        let allowed = "a path inside the data folder";
        return Some(("file", file.path.to_owned(), allowed));
    }
    if others.contains(&file.path) {
        return Some(("file", file.path.to_owned(), "a path of its own"));
    }
    let is_digit = |c: char| matches!(c, '0'..='9' | 'a'..='f');
    if file.sha256.len() != 64 || !file.sha256.chars().all(is_digit) {
        let allowed = "64 lower-case hexadecimal digits";
        return Some(("sha256", file.sha256.to_owned(), allowed));
    }
    (file.bytes == Some(0)).then(|| ("bytes", "0".to_owned(), "1 or more"))
}

/// What follows the host in an address, from its `/` on.
pub(crate) fn path_of(url: &str) -> Option<&str> {
    let (_, rest) = url.split_once("://")?;
    let path = &rest[rest.find('/')?..];
    (path.len() > 1 && rest.len() > path.len()).then_some(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_scene::{DataFile, shipped_scene_needs};

    const GOOD: &str = "[[sets]]\nname = \"a\"\nshort = \"b\"\nwhat = \"w\"\nlicence = \"l\"\n\
        url = \"https://h/p\"\nbytes = 1\n\
        sha256 = \"e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855\"\n\
        file = \"f\"\n";

    #[test]
    fn a_wrong_value_is_named_with_what_is_allowed() {
        assert!(Catalogue::from_toml(GOOD, "c").is_ok());
        let made = |by: &str, file: &str| {
            let sha256 = "0".repeat(64);
            format!(
                "[[sets.made]]\nby = \"{by}\"\nbytes = 2\nsha256 = \"{sha256}\"\nfile = \"{file}\"\n"
            )
        };
        assert!(Catalogue::from_toml(&(GOOD.to_owned() + &made("us-states", "g")), "c").is_ok());
        let replaced = |from: &str, to: &str| {
            assert!(GOOD.contains(from), "{from}");
            GOOD.replacen(from, to, 1)
        };
        for (text, expected) in [
            (replaced("\"a\"", "\"A\""), "c: sets[0].name: found \"A\""),
            (
                replaced("\"b\"", "\"a\""),
                "c: sets[0].short: found \"a\", allowed: a name of its own",
            ),
            (
                replaced("https", "ftp"),
                "c: sets[0].url: found \"ftp://h/p\"",
            ),
            (replaced("h/p", "h"), "c: sets[0].url: found \"https://h\""),
            (
                replaced("\"f\"", "\"../f\""),
                "c: sets[0].file: found \"../f\"",
            ),
            (
                replaced("= 1", "= 0"),
                "c: sets[0].bytes: found \"0\", allowed: 1 or more",
            ),
            (
                replaced("e3b0", "E3B0"),
                "c: sets[0].sha256: found \"E3B0c4",
            ),
            (replaced("bytes", "size"), "c: TOML parse error"),
            (
                GOOD.repeat(2),
                "c: sets[1].name: found \"a\", allowed: a name of its own",
            ),
            (
                GOOD.to_owned() + &made("us-states", "f"),
                "c: sets[0].made[0].file: found \"f\", allowed: a path of its own",
            ),
            (
                GOOD.to_owned() + &made("magic", "g"),
                "c: sets[0].made[0].by: found \"magic\", allowed: us-states, us-counties",
            ),
            (
                format!("{GOOD}[[missing]]\nfile = \"g\"\nsha256 = \"0\"\nwhy = \"w\"\n"),
                "c: missing[0].sha256: found \"0\"",
            ),
        ] {
            let error = Catalogue::from_toml(&text, "c").expect_err(expected);
            assert!(error.to_string().starts_with(expected), "{error}");
        }
    }

    #[test]
    fn sets_are_found_by_name_short_name_and_what_begins_one_name_alone() {
        let catalogue = Catalogue::shipped().expect("the catalogue");
        for (name, expected) in [
            ("natural-earth-110m", "natural-earth-110m-countries"),
            ("natural-earth-110m-land", "natural-earth-110m-land"),
            ("natural-earth-50m", "natural-earth-50m-countries"),
            ("us-10m", "us-10m"),
            ("blue", "blue-marble"),
        ] {
            let found = catalogue.find(name).expect(name);
            assert_eq!(found.name, expected);
        }
        for (name, expected) in [
            (
                "srtm",
                "found \"srtm\", which begins several names, allowed: one of srtm-alps, srtm-a",
            ),
            ("", "found \"\", allowed: natural-earth-110m-countries, "),
            ("countries-110m", "found \"countries-110m\", allowed: "),
        ] {
            let error = catalogue.find(name).expect_err(name).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    /// Files that a scene may read and that the catalogue neither gives nor calls missing.
    fn unknown_files(catalogue: &Catalogue) -> Vec<String> {
        let mut known: Vec<PinnedFile<'_>> = Vec::new();
        for set in &catalogue.sets {
            known.push(set.published());
            known.extend(set.made.iter().map(MadeFile::pinned));
        }
        known.extend(catalogue.missing.iter().map(MissingFile::pinned));
        let is_known = |file: &DataFile| {
            let is_it = |k: &PinnedFile<'_>| k.path == file.path && k.sha256 == file.sha256;
            known.iter().any(is_it)
        };
        let mut unknown = Vec::new();
        for needs in shipped_scene_needs().expect("scenes") {
            for need in needs.files {
                // One of the two is enough, and a source that is named must be published.
                let wanted = need.source.as_ref().unwrap_or(&need.file);
                if !is_known(wanted) {
                    unknown.push(format!("{}: {}", needs.scene, wanted.path));
                }
            }
        }
        unknown
    }

    #[test]
    fn every_file_that_a_scene_reads_is_in_the_catalogue_with_its_path_and_hash() {
        let mut catalogue = Catalogue::shipped().expect("the catalogue");
        assert_eq!(unknown_files(&catalogue), [""; 0]);
        // Negative controls: a set's hash, a made file's path and a missing file.
        catalogue.sets[0].sha256 = "0".repeat(64);
        assert_eq!(unknown_files(&catalogue).len(), 3);
        catalogue.sets[2].made[0].file = "elsewhere".to_owned();
        assert_eq!(unknown_files(&catalogue).len(), 4);
        catalogue
            .missing
            .retain(|missing| missing.file != "terrain/N27E086.hgt");
        assert_eq!(unknown_files(&catalogue).len(), 5);
    }

    #[test]
    fn addresses_have_a_host_and_a_path() {
        assert_eq!(path_of("https://h/a/b"), Some("/a/b"));
        for wrong in ["https://h", "https://h/", "https:///a", "h/a", ""] {
            assert_eq!(path_of(wrong), None, "{wrong}");
        }
    }
}
