// SPDX-License-Identifier: MIT OR Apache-2.0
//! What can be got, what of it is here, and which scenes need it.

use crate::catalogue::{Catalogue, DataSet, MissingFile};
use crate::state::{FileState, PinnedFile};
use serde::Serialize;
use std::path::{Path, PathBuf};
use terrafill_scene::{DataNeed, SceneNeeds};

/// Every data set and every file that cannot be had, in the catalogue's order.
#[derive(Debug, Serialize)]
pub struct Listing {
    /// The data folder that was looked in.
    pub folder: PathBuf,
    /// What can be got.
    pub sets: Vec<ListedSet>,
    /// What cannot.
    pub missing: Vec<ListedMissing>,
}

/// A data set as it is listed.
#[derive(Debug, Serialize)]
pub struct ListedSet {
    /// Its name.
    pub name: String,
    /// Its other name.
    pub short: Option<String>,
    /// A phrase.
    pub what: String,
    /// Under which terms it is published.
    pub licence: String,
    /// Where it is published.
    pub url: String,
    /// The published file.
    pub file: ListedFile,
    /// What is made of it.
    pub made: Vec<ListedFile>,
    /// Scenes that read one of its files.
    pub scenes: Vec<String>,
}

/// A file of a data set.
#[derive(Debug, Serialize)]
pub struct ListedFile {
    /// Path in the data folder.
    pub path: String,
    /// Size, bytes.
    pub bytes: u64,
    /// SHA-256, lower-case hexadecimal.
    pub sha256: String,
    /// What is in the data folder.
    #[serde(flatten)]
    pub state: FileState,
}

/// A file that cannot be had.
#[derive(Debug, Serialize)]
pub struct ListedMissing {
    /// Path in the data folder.
    pub path: String,
    /// SHA-256, lower-case hexadecimal.
    pub sha256: String,
    /// What is the matter.
    pub why: String,
    /// Scenes that read it.
    pub scenes: Vec<String>,
    /// What is in the data folder.
    #[serde(flatten)]
    pub state: FileState,
}

impl Listing {
    /// Looks into `folder`. Reads every file of the catalogue that is there.
    #[must_use]
    pub fn new(catalogue: &Catalogue, folder: &Path, needs: &[SceneNeeds]) -> Self {
        Self {
            folder: folder.to_owned(),
            sets: catalogue
                .sets
                .iter()
                .map(|set| ListedSet::new(set, folder, needs))
                .collect(),
            missing: catalogue
                .missing
                .iter()
                .map(|file| ListedMissing::new(file, folder, needs))
                .collect(),
        }
    }

    /// The list as a text for people.
    #[must_use]
    pub fn text(&self) -> String {
        let sets: String = self.sets.iter().map(ListedSet::text).collect();
        let missing: String = self.missing.iter().map(ListedMissing::text).collect();
        let folder = self.folder.display();
        format!("data folder: {folder}\n\n{sets}\nCannot be got yet:\n\n{missing}")
    }
}

impl ListedSet {
    fn new(set: &DataSet, folder: &Path, needs: &[SceneNeeds]) -> Self {
        let published = ListedFile::new(set.published(), folder, set.bytes);
        let made: Vec<ListedFile> = set
            .made
            .iter()
            .map(|made| ListedFile::new(made.pinned(), folder, made.bytes))
            .collect();
        let hashes: Vec<&str> = std::iter::once(&published)
            .chain(&made)
            .map(|file| file.sha256.as_str())
            .collect();
        Self {
            name: set.name.clone(),
            short: set.short.clone(),
            what: set.what.clone(),
            licence: set.licence.clone(),
            url: set.url.clone(),
            scenes: readers(&hashes, needs),
            file: published,
            made,
        }
    }

    fn text(&self) -> String {
        let short = self.short.as_ref();
        let short = short.map_or_else(String::new, |short| format!(" (or {short})"));
        let Self {
            name,
            what,
            licence,
            url,
            ..
        } = self;
        let files: String = std::iter::once(&self.file)
            .chain(&self.made)
            .map(ListedFile::text)
            .collect();
        let scenes = scenes_text(&self.scenes);
        format!("{name}{short}\n    {what}\n    {licence}\n    {url}\n{files}{scenes}")
    }
}

impl ListedFile {
    fn new(file: PinnedFile<'_>, folder: &Path, bytes: u64) -> Self {
        Self {
            path: file.path.to_owned(),
            bytes,
            sha256: file.sha256.to_owned(),
            state: file.state_in(folder),
        }
    }

    fn text(&self) -> String {
        let (path, bytes) = (&self.path, grouped(self.bytes));
        let state = state_text(&self.state);
        format!("    {path} · {bytes} bytes · {state}\n")
    }
}

impl ListedMissing {
    fn new(file: &MissingFile, folder: &Path, needs: &[SceneNeeds]) -> Self {
        Self {
            path: file.file.clone(),
            sha256: file.sha256.clone(),
            why: file.why.clone(),
            scenes: readers(&[&file.sha256], needs),
            state: file.pinned().state_in(folder),
        }
    }

    fn text(&self) -> String {
        let (path, why) = (&self.path, &self.why);
        let (state, scenes) = (state_text(&self.state), scenes_text(&self.scenes));
        format!("{path} · {state}\n    {why}\n{scenes}")
    }
}

/// Scenes that may read a file with one of these hashes.
fn readers(hashes: &[&str], needs: &[SceneNeeds]) -> Vec<String> {
    let reads = |scene: &&SceneNeeds| {
        scene.files.iter().any(|need| {
            let mut files = std::iter::once(&need.file).chain(&need.source);
            files.any(|file| hashes.contains(&file.sha256.as_str()))
        })
    };
    let scenes = needs.iter().filter(reads);
    scenes.map(|scene| scene.scene.clone()).collect()
}

/// Scenes that read one of the files of `sets`, and all of whose files are in `folder`.
#[must_use]
pub fn ready_scenes(sets: &[&DataSet], folder: &Path, needs: &[SceneNeeds]) -> Vec<String> {
    let hashes: Vec<&str> = sets
        .iter()
        .flat_map(|set| {
            let made = set.made.iter().map(|made| made.sha256.as_str());
            std::iter::once(set.sha256.as_str()).chain(made)
        })
        .collect();
    let readers = readers(&hashes, needs);
    let is_here = |need: &DataNeed| {
        let mut files = std::iter::once(&need.file).chain(&need.source);
        files.any(|file| {
            let pinned = PinnedFile {
                path: &file.path,
                sha256: &file.sha256,
                bytes: None,
            };
            pinned.state_in(folder) == FileState::Here
        })
    };
    let ready =
        |scene: &&SceneNeeds| readers.contains(&scene.scene) && scene.files.iter().all(is_here);
    let scenes = needs.iter().filter(ready);
    scenes.map(|scene| scene.scene.clone()).collect()
}

fn scenes_text(scenes: &[String]) -> String {
    match scenes {
        [] => "    read by no scene\n".to_owned(),
        some => format!("    read by {}\n", some.join(", ")),
    }
}

fn state_text(state: &FileState) -> String {
    match state {
        FileState::Here => "here".to_owned(),
        FileState::Missing => "not here".to_owned(),
        FileState::Begun { arrived_bytes } => {
            format!("begun, {} bytes are here", grouped(*arrived_bytes))
        }
        FileState::Different { found } => format!("another file is here, sha256 {found}"),
        FileState::Unreadable { why } => format!("cannot be read: {why}"),
    }
}

/// A number with its digits in groups of three: `1,461,877`.
#[must_use]
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_fixtures::data;
    use terrafill_scene::shipped_scene_needs;

    fn listing(folder: &Path) -> Listing {
        let catalogue = Catalogue::shipped().expect("the catalogue");
        Listing::new(&catalogue, folder, &shipped_scene_needs().expect("scenes"))
    }

    #[test]
    fn sets_are_listed_with_what_is_here_and_who_reads_them() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
            std::fs::write(path, "ab").expect("writable");
        };
        write("sources/us-10m.json.part");
        write("textures/color_blue_marble_4096.jpg");
        let listing = listing(folder.path());
        let set = |name: &str| {
            let found = listing.sets.iter().find(|set| set.name == name);
            found.expect(name)
        };
        let countries = set("natural-earth-110m-countries");
        assert_eq!(countries.file.state, FileState::Missing);
        let over_etopo = "terrain/countries-over-etopo";
        assert_eq!(
            countries.scenes,
            ["countries-110m", "blue-marble", over_etopo]
        );
        let states = set("us-10m");
        assert_eq!(states.file.state, FileState::Begun { arrived_bytes: 2 });
        let canyon = "terrain/grand-canyon";
        assert_eq!(states.scenes, ["us-states", canyon]);
        assert_eq!(states.made.len(), 2);
        let marble = set("blue-marble");
        assert!(matches!(marble.file.state, FileState::Different { .. }));
        assert_eq!(set("srtm-alps").scenes, [""; 0]);
        let text = listing.text();
        for phrase in [
            "natural-earth-110m-countries (or natural-earth-110m)\n",
            "    public domain\n    https://raw.githubusercontent.com/martynafford/",
            "    sources/us-10m.json · 656,701 bytes · begun, 2 bytes are here\n",
            "    vectors/us_states_10m.geojson · 180,766 bytes · not here\n",
            "another file is here, sha256 fb8e20fc",
            "    read by no scene\n",
            "terrain/N27E086.hgt · not here\n",
        ] {
            assert!(text.contains(phrase), "{phrase:?} is not in {text}");
        }
        let json = serde_json::to_value(&listing).expect("JSON");
        assert_eq!(json["sets"][2]["file"]["state"], "begun");
        assert_eq!(json["sets"][2]["file"]["bytes"], 656_701);
    }

    #[test]
    #[ignore = "needs data: all files"]
    fn files_of_the_data_folder_have_the_sizes_and_hashes_of_the_catalogue() {
        let data = data::folder();
        let listing = listing(&data);
        let files = listing
            .sets
            .iter()
            .flat_map(|set| std::iter::once(&set.file).chain(&set.made));
        for file in files {
            let ListedFile { path, state, .. } = file;
            assert!(
                matches!(state, FileState::Here | FileState::Missing),
                "{path}: {state:?}"
            );
            if *state == FileState::Here {
                let length = std::fs::metadata(data.join(path)).expect("there").len();
                assert_eq!(length, file.bytes, "{path}");
            }
        }
    }

    #[test]
    fn digits_stand_in_groups_of_three() {
        for (number, expected) in [
            (0, "0"),
            (999, "999"),
            (1_000, "1,000"),
            (12_345_678, "12,345,678"),
        ] {
            assert_eq!(grouped(number), expected);
        }
    }
}
