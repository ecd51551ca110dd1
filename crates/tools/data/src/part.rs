// SPDX-License-Identifier: MIT OR Apache-2.0
//! The file of a transfer: it grows beside its place, and gets its name once it is right.

use crate::DataError;
use crate::state::part_path;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use terrafill_scene::sha256_hex;

/// A transfer's file, this process's alone.
#[derive(Debug)]
pub(crate) struct PartialFile {
    file: File,
    path: PathBuf,
    bytes: u64,
}

impl PartialFile {
    /// The file of a transfer to `target`, with what an earlier one left in it.
    ///
    /// # Errors
    /// [`DataError::Unwritable`], [`DataError::Busy`]
    pub(crate) fn open(target: &Path) -> Result<Self, DataError> {
        let path = part_path(target);
        let folder = target.parent().unwrap_or(Path::new(""));
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, error))?;
        let file = OpenOptions::new()
            .create(true)
            .append(true)
            .read(true)
            .open(&path);
        let file = file.map_err(|error| unwritable(&path, error))?;
        // Two processes that append to one file would mix their bytes. Where a file system knows no
        // locks, the hash still tells.
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            return Err(DataError::Busy { path });
        }
        let bytes = file.metadata().map_err(|error| unwritable(&path, error))?;
        Ok(Self {
            file,
            path,
            bytes: bytes.len(),
        })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(crate) fn append(&mut self, bytes: &[u8]) -> Result<(), DataError> {
        let written = self.file.write_all(bytes);
        written.map_err(|error| unwritable(&self.path, error))?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// Begins again.
    pub(crate) fn clear(&mut self) -> Result<(), DataError> {
        let cleared = self.file.set_len(0);
        cleared.map_err(|error| unwritable(&self.path, error))?;
        self.bytes = 0;
        Ok(())
    }

    /// Hash of what is on the disk.
    pub(crate) fn sha256(&self) -> Result<String, DataError> {
        let mut bytes = Vec::new();
        let mut file = &self.file;
        let read = file.seek(SeekFrom::Start(0));
        match read.and_then(|_| file.read_to_end(&mut bytes)) {
            Ok(_) => Ok(sha256_hex(&bytes)),
            Err(error) => Err(DataError::Unreadable {
                path: self.path.clone(),
                why: error.to_string(),
            }),
        }
    }

    /// Gives it its name, once its bytes are on the disk.
    pub(crate) fn finish(self, target: &Path) -> Result<(), DataError> {
        let synced = self.file.sync_all();
        synced.map_err(|error| unwritable(&self.path, error))?;
        std::fs::rename(&self.path, target).map_err(|error| unwritable(target, error))
    }

    /// Takes it away.
    pub(crate) fn discard(self) {
        // One that is not there any more is gone as well.
        drop(std::fs::remove_file(&self.path));
    }
}

/// Writes a file whole or not at all.
pub(crate) fn write_whole(target: &Path, bytes: &[u8]) -> Result<(), DataError> {
    let mut part = PartialFile::open(target)?;
    let written = part.clear().and_then(|()| part.append(bytes));
    match written {
        Ok(()) => part.finish(target),
        Err(error) => {
            part.discard();
            Err(error)
        }
    }
}

fn unwritable(path: &Path, source: io::Error) -> DataError {
    DataError::Unwritable {
        path: path.to_owned(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_transfer_of_the_same_file_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("a/f");
        let mut first = PartialFile::open(&target).expect("writable");
        first.append(b"ab").expect("writable");
        let error = PartialFile::open(&target).expect_err("taken").to_string();
        assert!(error.ends_with("another process is fetching it"), "{error}");
        // Negative control: after it has ended the next one goes on.
        drop(first);
        let mut second = PartialFile::open(&target).expect("free");
        assert_eq!(second.bytes(), 2);
        second.append(b"c").expect("writable");
        assert_eq!(second.sha256().expect("readable"), sha256_hex(b"abc"));
        second.finish(&target).expect("writable");
        assert_eq!(std::fs::read(&target).expect("there"), b"abc");
        assert!(!part_path(&target).exists());
    }
}
