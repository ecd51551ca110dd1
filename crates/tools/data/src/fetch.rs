// SPDX-License-Identifier: MIT OR Apache-2.0
//! A data set into the data folder: what it takes, the transfer, what is made of it.

use crate::catalogue::path_of;
use crate::curl::{self, Ended, Stopped};
use crate::make::make;
use crate::part::{PartialFile, write_whole};
use crate::room::check_room;
use crate::state::{FileState, PinnedFile};
use crate::{DataError, DataSet, MadeFile};
use std::path::{Path, PathBuf};
use terrafill_scene::sha256_hex;

/// Tries of one call, each of which goes on where the last one ended. One that brings nothing is the
/// last: what does not answer now is asked again by the user.
const MAX_TRIES: u32 = 5;

/// What is no address of a mirror.
#[derive(Debug, thiserror::Error)]
#[error("http://HOST or https://HOST, with or without a path")]
pub struct WrongMirror;

/// Another host that has the same files under the same paths.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mirror {
    base: String,
}

impl std::str::FromStr for Mirror {
    type Err = WrongMirror;

    fn from_str(text: &str) -> Result<Self, WrongMirror> {
        let rest = text
            .strip_prefix("http://")
            .or_else(|| text.strip_prefix("https://"));
        let is_plain = |c: char| !c.is_whitespace() && !c.is_control();
        match rest {
            Some(rest)
                if !rest.is_empty() && !rest.starts_with('/') && rest.chars().all(is_plain) =>
            {
                let base = text.trim_end_matches('/').to_owned();
                Ok(Self { base })
            }
            _ => Err(WrongMirror),
        }
    }
}

impl Mirror {
    /// The address of `url` here: its path behind the mirror's address.
    fn address(&self, url: &str) -> String {
        format!("{}{}", self.base, path_of(url).unwrap_or_default())
    }
}

/// What getting a data set takes.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    set: &'a DataSet,
    folder: PathBuf,
    url: String,
    is_here: bool,
    begun_bytes: u64,
    to_make: Vec<&'a MadeFile>,
}

impl<'a> Plan<'a> {
    /// Looks what is in `folder` already.
    ///
    /// # Errors
    /// [`DataError::Occupied`] where a file with other bytes has a name of the set,
    /// [`DataError::Unreadable`] where something else has.
    pub fn new(
        set: &'a DataSet,
        folder: &Path,
        mirror: Option<&Mirror>,
    ) -> Result<Self, DataError> {
        let published = set.published();
        let is_here = is_here(published, folder)?;
        let mut to_make = Vec::new();
        for made in &set.made {
            if !self::is_here(made.pinned(), folder)? {
                to_make.push(made);
            }
        }
        let begun_bytes = match published.state_in(folder) {
            FileState::Begun { arrived_bytes } if arrived_bytes <= set.bytes => arrived_bytes,
            _ => 0,
        };
        Ok(Self {
            set,
            folder: folder.to_owned(),
            url: mirror.map_or_else(|| set.url.clone(), |mirror| mirror.address(&set.url)),
            is_here,
            begun_bytes,
            to_make,
        })
    }

    /// The set.
    #[must_use]
    pub fn set(&self) -> &'a DataSet {
        self.set
    }

    /// Where its bytes come from.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Bytes to fetch, without those that an earlier try brought.
    #[must_use]
    pub fn fetch_bytes(&self) -> u64 {
        if self.is_here {
            0
        } else {
            self.set.bytes - self.begun_bytes
        }
    }

    /// Bytes to write, what is made of the published file included.
    #[must_use]
    pub fn write_bytes(&self) -> u64 {
        let made: u64 = self.to_make.iter().map(|made| made.bytes).sum();
        self.fetch_bytes() + made
    }

    /// Files of the set, the published one first.
    #[must_use]
    pub fn paths(&self) -> Vec<PathBuf> {
        let made = self.set.made.iter().map(|made| &made.file);
        std::iter::once(&self.set.file)
            .chain(made)
            .map(|file| self.folder.join(file))
            .collect()
    }

    /// Fetches what is not here, verifies it, and makes what is made of it. Files get their names when
    /// they are whole and right.
    ///
    /// - `progress`: called with the bytes of the published file that have arrived
    ///
    /// # Errors
    /// [`DataError`]. A transfer that was broken off leaves `NAME.part`, from which the next goes on.
    pub fn carry_out(&self, progress: &mut dyn FnMut(u64)) -> Result<(), DataError> {
        check_room(&self.folder, self.write_bytes())?;
        let path = self.folder.join(&self.set.file);
        if !self.is_here {
            self.fetch(&path, progress)?;
        }
        if self.to_make.is_empty() {
            return Ok(());
        }
        let source = std::fs::read(&path).map_err(|error| DataError::Unreadable {
            path: path.clone(),
            why: error.to_string(),
        })?;
        for made in &self.to_make {
            // The catalogue names no conversion that there is not.
            let Some(text) = make(&made.by, &source) else {
                continue;
            };
            let text = text.map_err(|source| DataError::Conversion {
                path: path.clone(),
                by: made.by.clone(),
                source,
            })?;
            let target = self.folder.join(&made.file);
            let found = sha256_hex(text.as_bytes());
            if found != made.sha256 {
                return Err(DataError::MadeOtherwise {
                    path: target,
                    found,
                    expected: made.sha256.clone(),
                });
            }
            write_whole(&target, text.as_bytes())?;
        }
        Ok(())
    }

    fn fetch(&self, target: &Path, progress: &mut dyn FnMut(u64)) -> Result<(), DataError> {
        let mut part = PartialFile::open(target)?;
        // Another process may have finished between the plan and the lock.
        if is_here(self.set.published(), &self.folder)? {
            return Ok(());
        }
        if part.bytes() > self.set.bytes {
            part.clear()?;
        }
        let mut has_old_bytes = part.bytes() > 0;
        loop {
            match self.fill(&mut part, progress) {
                Ok(()) => {}
                Err(error) => {
                    let keeps = matches!(
                        error,
                        DataError::Transfer { .. } | DataError::Unwritable { .. }
                    );
                    if part.bytes() == 0 || !keeps {
                        part.discard();
                    }
                    return Err(error);
                }
            }
            let found = part.sha256()?;
            if found == self.set.sha256 {
                return part.finish(target);
            }
            if !has_old_bytes {
                part.discard();
                let expected = format!("sha256 {}", self.set.sha256);
                return Err(self.altered(format!("sha256 {found}"), expected));
            }
            // What an earlier try left may be to blame: once more, from nothing.
            has_old_bytes = false;
            part.clear()?;
        }
    }

    /// Fetches what `part` lacks.
    fn fill(&self, part: &mut PartialFile, progress: &mut dyn FnMut(u64)) -> Result<(), DataError> {
        let expected = self.set.bytes;
        let mut tries = 0;
        while part.bytes() < expected {
            tries += 1;
            let before = part.bytes();
            let ended = curl::read(&self.url, before, |bytes| {
                if part.bytes() + bytes.len() as u64 > expected {
                    let found = format!("more than {expected} bytes");
                    return Err(self.altered(found, format!("{expected} bytes")));
                }
                part.append(bytes)?;
                progress(part.bytes());
                Ok(())
            });
            match ended {
                Ok(Ended::Complete) if part.bytes() < expected => {
                    let found = format!("{} bytes", part.bytes());
                    return Err(self.altered(found, format!("{expected} bytes")));
                }
                Ok(Ended::Complete) => {}
                Ok(Ended::NoRanges) if tries < MAX_TRIES => part.clear()?,
                Ok(Ended::NoRanges) => {
                    return Err(self.transfer(part, "it does not send parts of files".to_owned()));
                }
                Ok(Ended::Broken(why)) if part.bytes() == before || tries == MAX_TRIES => {
                    return Err(self.transfer(part, why));
                }
                Ok(Ended::Broken(_)) => {}
                Err(Stopped::Refused(error)) => return Err(error),
                Err(Stopped::NotStarted(source)) => {
                    return Err(DataError::NoCurl {
                        source,
                        url: self.url.clone(),
                        path: self.folder.join(&self.set.file),
                        bytes: expected,
                        sha256: self.set.sha256.clone(),
                    });
                }
            }
        }
        Ok(())
    }

    fn altered(&self, found: String, expected: String) -> DataError {
        DataError::Altered {
            url: self.url.clone(),
            found,
            expected,
        }
    }

    fn transfer(&self, part: &PartialFile, why: String) -> DataError {
        DataError::Transfer {
            url: self.url.clone(),
            why,
            part: part.path().to_owned(),
            found: part.bytes(),
            expected: self.set.bytes,
        }
    }
}

/// Whether a file is there with its hash.
fn is_here(file: PinnedFile<'_>, folder: &Path) -> Result<bool, DataError> {
    let path = folder.join(file.path);
    match file.state_in(folder) {
        FileState::Here => Ok(true),
        FileState::Missing | FileState::Begun { .. } => Ok(false),
        FileState::Different { found } => Err(DataError::Occupied {
            path,
            found,
            expected: file.sha256.to_owned(),
        }),
        FileState::Unreadable { why } => Err(DataError::Unreadable { path, why }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_has_the_paths_of_the_source() {
        let at = |base: &str| {
            let mirror: Mirror = base.parse().expect("a mirror");
            mirror.address("https://host.example/a/b.json")
        };
        assert_eq!(at("http://127.0.0.1:80"), "http://127.0.0.1:80/a/b.json");
        assert_eq!(
            at("https://m.example/copy/"),
            "https://m.example/copy/a/b.json"
        );
        for wrong in [
            "",
            "m.example",
            "ftp://m",
            "http://",
            "https:///a",
            "http://a b",
            "-o",
        ] {
            assert!(wrong.parse::<Mirror>().is_err(), "{wrong}");
        }
    }
}
