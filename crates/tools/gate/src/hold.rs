// SPDX-License-Identifier: MIT OR Apache-2.0
//! A gate holds its folder by a lock that ends with its process. So the folder of a gate that was killed differs from
//! that of one at work, and from that of one with a verdict.

use crate::{GateError, PICTURES};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// File that is locked.
const LOCK: &str = "gate.lock";

/// What names of the folders of single processes begin with.
pub(crate) const PROCESS: &str = "process-";
pub(crate) const VERIFY: &str = "verify-";

/// Names of what a gate makes before its verdict; all else is somebody else's.
fn is_of_gate(name: &str) -> bool {
    ["base", "new", PICTURES, LOCK].contains(&name) || is_of_process(name)
}

fn is_of_process(name: &str) -> bool {
    [PROCESS, VERIFY]
        .iter()
        .any(|start| name.starts_with(start))
}

/// Names in a folder; none where there is no such folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let names =
        entries.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()));
    names.collect()
}

fn remove(path: &Path) -> Result<(), GateError> {
    let removed = if path.is_dir() {
        std::fs::remove_dir_all(path)
    } else {
        std::fs::remove_file(path)
    };
    removed.map_err(GateError::io(path))
}

/// Takes away the folders of single processes, for a gate that is told to stop. They hold copies of its programs, which
/// take more room than all else.
pub fn clear_processes(out: &Path) {
    // A process that is still at work may write between two steps. What stays all the same takes room, and the next
    // gate in this folder takes it away.
    for _ in 0..20 {
        let names = names(out);
        let left = names.iter().filter(|name| is_of_process(name));
        if left.filter(|name| remove(&out.join(name)).is_err()).count() == 0 {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A folder that is held.
pub(crate) struct Hold {
    path: PathBuf,
    _file: File,
}

impl Hold {
    /// Holds a folder that is new, empty, or of a gate that was killed: what that one left is taken away.
    ///
    /// # Errors
    /// [`GateError::BadInput`] where the folder holds something else, or another gate works in it;
    /// [`GateError::Io`].
    pub(crate) fn take(out: &Path, say: &mut dyn FnMut(&str)) -> Result<Self, GateError> {
        let path = out.join(LOCK);
        let names = names(out);
        if !names.is_empty() {
            let refused = |why: &str| {
                let out = out.display();
                Err(GateError::BadInput(format!(
                    "{out} {why}: give another --out"
                )))
            };
            if !names.iter().any(|name| name == LOCK) || !names.iter().all(|name| is_of_gate(name))
            {
                return refused("holds something already");
            }
            let left = File::open(&path).map_err(GateError::io(&path))?;
            if left.try_lock().is_err() {
                return refused("is where another gate is at work");
            }
            say("what a gate that was killed left is taken away");
            for name in &names {
                remove(&out.join(name))?;
            }
        }
        std::fs::create_dir_all(out).map_err(GateError::io(out))?;
        let file = File::create(&path).map_err(GateError::io(&path))?;
        file.lock().map_err(GateError::io(&path))?;
        Ok(Self { path, _file: file })
    }
}

impl Drop for Hold {
    fn drop(&mut self) {
        // Where it stays, the next gate takes it for one of a gate that was killed.
        drop(std::fs::remove_file(&self.path));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn take(out: &Path) -> Result<Hold, String> {
        Hold::take(out, &mut |_| {}).map_err(|error| error.to_string())
    }

    #[test]
    fn what_a_killed_gate_left_is_taken_away_and_nothing_else_is() {
        let place = tempfile::tempdir().expect("a folder");
        let out = place.path().join("gate");
        let write = |name: &str| {
            std::fs::create_dir_all(out.join(name)).expect("a folder");
            std::fs::write(out.join(name).join("file"), "x").expect("written");
        };
        let hold = take(&out).expect("new");
        let error = take(&out).err().expect("held");
        assert!(error.contains("another gate is at work"), "{error}");
        write("base");
        write("process-00003");
        // What is left of a process that was killed: the file, and no lock.
        std::fs::rename(out.join(LOCK), out.join("kept")).expect("renamed");
        drop(hold);
        std::fs::rename(out.join("kept"), out.join(LOCK)).expect("renamed");
        drop(take(&out).expect("of a killed gate"));
        assert_eq!(names(&out), [""; 0]);
        // Negative controls: another folder beside it, and a gate that has ended.
        write("base");
        let error = take(&out).err().expect("no lock");
        assert!(error.contains("holds something already"), "{error}");
        std::fs::write(out.join(LOCK), "").expect("written");
        write("mine");
        assert!(take(&out).is_err());
        assert!(out.join("mine/file").exists() && out.join("base/file").exists());
    }

    #[test]
    fn a_gate_that_is_told_to_stop_leaves_no_copy_of_a_program() {
        let place = tempfile::tempdir().expect("a folder");
        for name in ["base", "process-00001", "verify-00002", "processes"] {
            std::fs::create_dir(place.path().join(name)).expect("a folder");
        }
        clear_processes(place.path());
        let mut left = names(place.path());
        left.sort();
        assert_eq!(left, ["base", "processes"]);
    }
}
