// SPDX-License-Identifier: MIT OR Apache-2.0
//! Room on the disk that the data folder is on, bytes.

use crate::DataError;
use rustix::fs::statvfs;
use std::path::Path;

/// Refuses to write `needed` bytes into `folder` where its disk has fewer free.
///
/// # Errors
/// [`DataError::NoRoom`]. A disk that does not say how much room it has is tried.
pub(crate) fn check_room(folder: &Path, needed: u64) -> Result<(), DataError> {
    match free_bytes(folder) {
        Some(found) if found < needed => Err(DataError::NoRoom {
            folder: folder.to_owned(),
            found,
            needed,
        }),
        _ => Ok(()),
    }
}

/// What this user may still write; of the nearest folder above where `folder` is not there yet. `None`
/// where the system does not say, and of file systems without blocks, such as `/proc`.
fn free_bytes(folder: &Path) -> Option<u64> {
    let here = |path: &Path| {
        if path.as_os_str().is_empty() {
            statvfs(".")
        } else {
            statvfs(path)
        }
    };
    let disk = folder.ancestors().find_map(|path| here(path).ok())?;
    (disk.f_blocks > 0).then(|| disk.f_bavail.saturating_mul(disk.f_frsize))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_that_of_the_nearest_folder_that_is_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let below = folder.path().join("not/yet");
        let free = free_bytes(&below).expect("a disk");
        assert!(free > 0);
        assert!(check_room(&below, 1).is_ok());
        assert!(free_bytes(Path::new("not-yet")).is_some(), "a relative one");
        // Negative control: no disk has an exbibyte.
        let error = check_room(&below, 1 << 60)
            .expect_err("refused")
            .to_string();
        let folder = format!("{}: found ", below.display());
        let needed =
            " bytes free on its disk, needs 1152921504606846976 bytes; nothing was fetched";
        assert!(
            error.starts_with(&folder) && error.ends_with(needed),
            "{error}"
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn file_systems_without_blocks_say_nothing_of_room() {
        assert_eq!(free_bytes(Path::new("/proc/self")), None);
        assert!(check_room(Path::new("/proc/self"), 1 << 60).is_ok());
    }
}
