// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files with regions: opened, read, and for scenes held against their SHA-256.
//!
//! A scene names its data by a path, absolute or from the scene file or the data folder, and may give the
//! hash of the bytes. A file that is not there, or has other bytes, is no wrong input then: the scene is
//! skipped, with a line on how to get the file. A measurement on other data would carry the same name and
//! mean something else. Without a hash any bytes will do, and a file that is not there is an error.
//!
//! A scene may name the published file beside a trimmed one: either will do, as both hold the same regions.

use sha2::{Digest, Sha256};
use std::io;
use std::path::{Path, PathBuf};
use terrafill_core::{Reading, RegionFile, RegionFileError, read_region_file};

/// Environment variable with the data folder, or several as `PATH` has them.
pub const DATA_DIR_VARIABLE: &str = "TERRAFILL_DATA";

/// The data folder named by [`DATA_DIR_VARIABLE`], if it is set to anything.
#[must_use]
pub fn data_dir_from_env() -> Option<PathBuf> {
    std::env::var_os(DATA_DIR_VARIABLE)
        .filter(|value| !value.is_empty())
        .map(PathBuf::from)
}

/// The data folder where [`DATA_DIR_VARIABLE`] is not set: in the current folder, as runs are.
pub const DEFAULT_DATA_DIR: &str = "data";

/// The data folder: the `given` one, else that of [`DATA_DIR_VARIABLE`], else [`DEFAULT_DATA_DIR`]
/// where that is a folder.
#[must_use]
pub fn data_dir(given: Option<&Path>) -> Option<PathBuf> {
    let default = || Some(PathBuf::from(DEFAULT_DATA_DIR)).filter(|folder| folder.is_dir());
    given
        .map(Path::to_owned)
        .or_else(data_dir_from_env)
        .or_else(default)
}

/// Several folders as one path, as `PATH` has them, of which the first goes first; `None` for none.
///
/// # Errors
/// Where there are several and the name of one has what separates them.
pub fn joined_data_dirs(folders: &[PathBuf]) -> Result<Option<PathBuf>, std::env::JoinPathsError> {
    Ok(match folders {
        [] => None,
        [only] => Some(only.clone()),
        several => Some(std::env::join_paths(several)?.into()),
    })
}

/// The folders of such a path, at least one.
#[must_use]
pub fn split_data_dirs(data: &Path) -> Vec<PathBuf> {
    let folders: Vec<PathBuf> = std::env::split_paths(data).collect();
    // One folder may have any name.
    if folders.len() > 1 && !data.is_dir() {
        folders
    } else {
        vec![data.to_owned()]
    }
}

/// A file of the data folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DataFile {
    /// Path in the data folder.
    pub path: String,
    /// SHA-256 of its bytes, lower-case hexadecimal.
    pub sha256: String,
}

/// A file that a scene reads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DataNeed {
    /// Looked for first.
    pub file: DataFile,
    /// The published file with the same regions, which will do as well.
    pub source: Option<DataFile>,
}

/// What a scene reads from the data folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneNeeds {
    /// Name of a shipped scene.
    pub scene: String,
    /// In the order of the scene file; none where the scene needs no data.
    pub files: Vec<DataNeed>,
}

/// Why a file gave no regions.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RegionLoadError {
    /// Nothing is at the path.
    #[error("{}: no such file", path.display())]
    Missing {
        /// The path.
        path: PathBuf,
    },
    /// None of the data folders has it.
    #[error("{file}: no such file in any of {folders}")]
    MissingEverywhere {
        /// Its path in a data folder.
        file: String,
        /// The folders.
        folders: String,
    },
    /// A directory is at the path.
    #[error("{}: is a directory, allowed: a GeoJSON file", path.display())]
    Directory {
        /// The path.
        path: PathBuf,
    },
    /// The system refused to read it.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The path.
        path: PathBuf,
        /// The system's words.
        source: io::Error,
    },
    /// It was read, and is not a file of regions.
    #[error(transparent)]
    Invalid(#[from] RegionFileError),
}

/// Reads every region of a GeoJSON file.
///
/// # Errors
/// [`RegionLoadError`], with the path as given.
pub fn load_regions(path: &Path, reading: Reading) -> Result<RegionFile, RegionLoadError> {
    let bytes = read(path)?;
    let file = path.display().to_string();
    Ok(read_region_file(&bytes, &file, reading)?)
}

fn read(path: &Path) -> Result<Vec<u8>, RegionLoadError> {
    let path_buf = || path.to_path_buf();
    // Asked for first: what opening a directory says differs between systems.
    if path.is_dir() {
        return Err(RegionLoadError::Directory { path: path_buf() });
    }
    std::fs::read(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => RegionLoadError::Missing { path: path_buf() },
        _ => RegionLoadError::Unreadable {
            path: path_buf(),
            source,
        },
    })
}

/// What became of a scene's data file.
pub(crate) enum Verified {
    /// Its bytes with their hash, which is the one that was asked for, if any.
    Bytes(Vec<u8>, String),
    /// It is not there or not the same, and why.
    Absent(String),
}

/// Where files that a scene names are looked for.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Folders<'a> {
    /// Of the scene file, which goes first; `None` of a scene that ships.
    pub(crate) scene: Option<&'a Path>,
    /// Of the data: one, or several as `PATH` has them.
    pub(crate) data: Option<&'a Path>,
}

impl Folders<'_> {
    /// Reads `file` and compares its hash.
    ///
    /// - `sha256`: empty where any bytes will do; then the file must be there
    ///
    /// # Errors
    /// [`RegionLoadError`] if it is there but cannot be read.
    pub(crate) fn read(self, file: &str, sha256: &str) -> Result<Verified, RegionLoadError> {
        let places = self.places(file);
        let there = places.iter().find(|path| path.exists());
        let Some(path) = there.or(places.first()) else {
            return Ok(Verified::Absent(format!(
                "no data folder is given ({DATA_DIR_VARIABLE} is not set, and there is no folder \
                 {DEFAULT_DATA_DIR})"
            )));
        };
        let nowhere = || {
            let places: Vec<String> = places
                .iter()
                .map(|path| path.display().to_string())
                .collect();
            format!("{} is not there", places.join(", nor "))
        };
        match read(path) {
            Ok(bytes) => {
                let found = sha256_hex(&bytes);
                Ok(if sha256.is_empty() || found == sha256 {
                    Verified::Bytes(bytes, found)
                } else {
                    Verified::Absent(format!("{} has sha256 {found}", path.display()))
                })
            }
            Err(RegionLoadError::Missing { .. }) if !sha256.is_empty() => {
                Ok(Verified::Absent(nowhere()))
            }
            Err(RegionLoadError::Missing { .. }) if places.len() > 1 => {
                let folders = places.iter().filter_map(|path| path.parent());
                let folders: Vec<String> = folders.map(|of| of.display().to_string()).collect();
                Err(RegionLoadError::MissingEverywhere {
                    file: file.to_owned(),
                    folders: folders.join(", "),
                })
            }
            Err(other) => Err(other),
        }
    }

    /// Where a file may be, the first place first; none where no folder is known.
    fn places(self, file: &str) -> Vec<PathBuf> {
        if Path::new(file).is_absolute() {
            return vec![file.into()];
        }
        let beside = self.scene.map(|folder| folder.join(file));
        if let Some(beside) = beside.filter(|path| path.exists() || self.data.is_none()) {
            vec![beside]
        } else {
            let folders = self.data.map(split_data_dirs).into_iter().flatten();
            folders.map(|folder| folder.join(file)).collect()
        }
    }
}

/// SHA-256 in lower-case hexadecimal.
#[must_use]
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const EMPTY_SHA256: &str = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

    #[test]
    fn the_hash_is_the_standards() {
        // FIPS 180-2, appendix B.1.
        assert_eq!(
            sha256_hex(b"abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert_eq!(sha256_hex(b""), EMPTY_SHA256);
    }

    #[test]
    fn a_path_without_a_readable_file_says_what_is_there() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let missing = folder.path().join("none.geojson");
        assert_eq!(
            load_regions(&missing, Reading::default())
                .expect_err("missing")
                .to_string(),
            format!("{}: no such file", missing.display())
        );
        assert_eq!(
            load_regions(folder.path(), Reading::default())
                .expect_err("directory")
                .to_string(),
            format!(
                "{}: is a directory, allowed: a GeoJSON file",
                folder.path().display()
            )
        );
    }

    #[test]
    fn an_empty_file_is_invalid_and_a_good_one_is_read() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("r.geojson");
        std::fs::write(&path, "").expect("writable");
        let error = load_regions(&path, Reading::default()).expect_err("empty");
        assert!(matches!(error, RegionLoadError::Invalid(_)), "{error:?}");
        assert!(error.to_string().contains("r.geojson"), "{error}");
        let square = r#"{"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1],[0,1],[0,0]]]}"#;
        std::fs::write(&path, square).expect("writable");
        let regions = load_regions(&path, Reading::default())
            .expect("a square")
            .regions;
        assert_eq!((regions.len(), regions[0].vertex_count()), (1, 4));
    }

    #[test]
    fn one_changed_byte_makes_a_data_file_absent() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let folders = Folders {
            data: Some(folder.path()),
            ..Folders::default()
        };
        std::fs::write(folder.path().join("d"), "abc").expect("writable");
        let hash = sha256_hex(b"abc");
        let verified = folders.read("d", &hash).expect("readable");
        assert!(
            matches!(verified, Verified::Bytes(bytes, found) if bytes == b"abc" && found == hash)
        );
        std::fs::write(folder.path().join("d"), "ab").expect("writable");
        let verified = folders.read("d", &hash).expect("readable");
        let Verified::Absent(why) = verified else {
            panic!("other bytes were taken for the scene's");
        };
        assert!(why.contains(&sha256_hex(b"ab")), "{why}");
    }

    #[test]
    fn a_file_without_a_hash_is_read_where_it_is_and_missing_is_an_error() {
        let [beside, data] = [(); 2].map(|()| tempfile::tempdir().expect("temporary folder"));
        std::fs::write(beside.path().join("d"), "beside").expect("writable");
        std::fs::write(data.path().join("d"), "data").expect("writable");
        let folders = Folders {
            scene: Some(beside.path()),
            data: Some(data.path()),
        };
        let bytes = |folders: Folders<'_>, file: &str| match folders.read(file, "") {
            Ok(Verified::Bytes(bytes, _)) => bytes,
            Ok(Verified::Absent(why)) => panic!("{why}"),
            Err(error) => panic!("{error}"),
        };
        assert_eq!(bytes(folders, "d"), b"beside");
        let absolute = data.path().join("d").display().to_string();
        assert_eq!(bytes(Folders::default(), &absolute), b"data");
        std::fs::remove_file(beside.path().join("d")).expect("removable");
        assert_eq!(bytes(folders, "d"), b"data");
        // Negative control: no bytes are taken for those that are not there.
        assert!(matches!(
            folders.read("e", ""),
            Err(RegionLoadError::Missing { .. })
        ));
    }

    #[test]
    fn the_first_of_several_folders_that_has_the_file_wins_and_all_are_named_where_none_has() {
        let [first, second] = [(); 2].map(|()| tempfile::tempdir().expect("temporary folder"));
        let both = [&first, &second].map(|folder| folder.path().to_owned());
        let joined = joined_data_dirs(&both).expect("plain names");
        let read = |file: &str, sha256: &str| {
            let folders = Folders {
                data: joined.as_deref(),
                ..Folders::default()
            };
            folders.read(file, sha256)
        };
        let is = |expected: &[u8]| match read("d", "").expect("readable") {
            Verified::Bytes(bytes, _) => bytes == expected,
            Verified::Absent(why) => panic!("{why}"),
        };
        let named = |text: &str| {
            for folder in &both {
                assert!(text.contains(&folder.display().to_string()), "{text}");
            }
        };
        named(&read("d", "").err().expect("none has it").to_string());
        let Ok(Verified::Absent(why)) = read("d", EMPTY_SHA256) else {
            panic!("nothing was taken for something");
        };
        named(&why);
        std::fs::write(second.path().join("d"), "second").expect("writable");
        assert!(is(b"second"));
        std::fs::write(first.path().join("d"), "first").expect("writable");
        assert!(is(b"first"));
        // A lone folder may have any name.
        let odd = first.path().join("a:b");
        std::fs::create_dir(&odd).expect("writable");
        assert_eq!(split_data_dirs(&odd), std::slice::from_ref(&odd));
        assert!(joined_data_dirs(&[odd, both[1].clone()]).is_err());
    }

    #[test]
    fn the_given_data_folder_goes_before_the_default_one() {
        let given = Path::new("there");
        assert_eq!(data_dir(Some(given)).as_deref(), Some(given));
        // Negative control: tests run in the crate's folder, which has no data.
        assert_eq!(data_dir(None), data_dir_from_env());
    }

    #[test]
    fn absent_data_says_whether_folder_or_file_is_missing() {
        let folder = tempfile::tempdir().expect("temporary folder");
        for (dir, phrase) in [
            (None, "TERRAFILL_DATA is not set"),
            (Some(folder.path()), "is not there"),
        ] {
            let folders = Folders {
                data: dir,
                ..Folders::default()
            };
            let Ok(Verified::Absent(why)) = folders.read("d", EMPTY_SHA256) else {
                panic!("nothing was taken for something");
            };
            assert!(why.contains(phrase), "{why}");
        }
    }
}
