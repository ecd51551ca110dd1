// SPDX-License-Identifier: MIT OR Apache-2.0
//! What git knows of commits: their order, and which lie between two of them.

use crate::HistoryError;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where a commit stands among others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Position {
    /// Commits that it contains, itself counted: more than any of its ancestors.
    pub ordinal: i64,
    /// Committed at, seconds since 1970.
    pub unix_s: i64,
}

/// A git repository.
#[derive(Debug, Clone)]
pub struct Repository {
    folder: PathBuf,
}

impl Repository {
    /// The repository that `folder` is in; `None` where it is in none, or git is not there.
    #[must_use]
    pub fn at(folder: &Path) -> Option<Self> {
        let repository = Self {
            folder: folder.to_owned(),
        };
        repository.git(&["rev-parse", "--git-dir"]).ok()?;
        Some(repository)
    }

    fn git(&self, arguments: &[&str]) -> Result<String, String> {
        let output = Command::new("git")
            .arg("-C")
            .arg(&self.folder)
            .args(arguments)
            .output()
            .map_err(|error| format!("git: {error}"))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned());
        }
        Err(String::from_utf8_lossy(&output.stderr).trim().to_owned())
    }

    /// Where a commit stands; `None` where the repository does not have it, or is a shallow clone,
    /// whose commits cannot be counted.
    #[must_use]
    pub fn position(&self, commit: &str) -> Option<Position> {
        if self.git(&["rev-parse", "--is-shallow-repository"]).ok()? != "false" {
            return None;
        }
        let of = |arguments: &[&str]| self.git(arguments).ok()?.parse().ok();
        Some(Position {
            ordinal: of(&["rev-list", "--count", commit, "--"])?,
            unix_s: of(&["show", "--no-patch", "--format=%ct", commit, "--"])?,
        })
    }

    /// Hash of the commit that git knows by this name.
    ///
    /// # Errors
    /// [`HistoryError::NotFound`] where there is none.
    pub fn commit(&self, name: &str) -> Result<String, HistoryError> {
        let revision = format!("{name}^{{commit}}");
        let options = ["rev-parse", "--verify", "--quiet", "--end-of-options"];
        self.git(&[&options[..], &[&revision]].concat())
            .map_err(|_| {
                let place = self.folder.display();
                HistoryError::NotFound(format!(
                    "{place}: found no commit {name:?}, allowed: what git knows as one"
                ))
            })
    }

    /// Commits after `good` up to and with `bad`, the oldest first, each with its subject.
    ///
    /// # Errors
    /// [`HistoryError::NotFound`] where git has one of them not, or the one does not contain the other.
    pub fn between(&self, good: &str, bad: &str) -> Result<Vec<(String, String)>, HistoryError> {
        let place = self.folder.display();
        let range = format!("{good}..{bad}");
        let list = [
            "log",
            "--reverse",
            "--topo-order",
            "--ancestry-path",
            "--format=%H %s",
        ];
        let list = self.git(&[&list[..], &[&range, "--"]].concat());
        let list = list.map_err(|message| {
            HistoryError::NotFound(format!("{place}: git log {range}: {message}"))
        })?;
        let commits: Vec<(String, String)> = list
            .lines()
            .map(|line| line.split_once(' ').unwrap_or((line, "")))
            .map(|(commit, subject)| (commit.to_owned(), subject.to_owned()))
            .collect();
        if commits.is_empty() {
            let message =
                format!("{place}: found no commit in {range}; {bad} does not contain {good}");
            return Err(HistoryError::NotFound(message));
        }
        Ok(commits)
    }
}
