// SPDX-License-Identifier: MIT OR Apache-2.0
//! What git knows of commits: their order, and which lie between two of them.

use crate::HistoryError;
use std::collections::BTreeMap;
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

/// What a reader knows a commit by.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CommitFacts {
    /// First line of its message.
    pub subject: String,
    /// Committed at, seconds since 1970.
    pub unix_s: u64,
    /// Its page at the host of the repository; empty where that is no web host.
    pub link: String,
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

    /// Subjects, times and pages of those of these commits that the repository has.
    #[must_use]
    pub fn facts(&self, commits: &[String]) -> BTreeMap<String, CommitFacts> {
        let remote = self.git(&["remote", "get-url", "origin"]).ok();
        let host = remote.and_then(|remote| web_address(&remote));
        let options = [
            "log",
            "--no-walk=unsorted",
            "--ignore-missing",
            "--format=%H %ct %s",
        ];
        let names = commits.iter().map(String::as_str);
        let words: Vec<&str> = options.into_iter().chain(names).chain(["--"]).collect();
        // Without a commit git would take its newest.
        let log = match commits {
            [] => String::new(),
            _ => self.git(&words).unwrap_or_default(),
        };
        let fact = |line: &str| {
            let mut words = line.splitn(3, ' ');
            let (hash, time) = (words.next()?, words.next()?);
            let commit = commits.iter().find(|commit| hash.starts_with(*commit))?;
            let page = |host: &String| format!("{host}/commit/{hash}");
            let facts = CommitFacts {
                subject: words.next().unwrap_or_default().to_owned(),
                unix_s: time.parse().ok()?,
                link: host.as_ref().map(page).unwrap_or_default(),
            };
            Some((commit.clone(), facts))
        };
        log.lines().filter_map(fact).collect()
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

/// Where a remote's pages are: `https` without a name or a secret in it. `None` for a folder.
fn web_address(remote: &str) -> Option<String> {
    let without_scheme = ["https://", "http://", "ssh://", "git://"]
        .iter()
        .find_map(|scheme| remote.strip_prefix(scheme));
    let (host, path) = match without_scheme {
        Some(rest) => rest.split_once('/')?,
        // git@host:owner/name
        None => remote
            .split_once(':')
            .filter(|(host, _)| host.contains('@'))?,
    };
    let host = host.rsplit('@').next()?;
    // A port is of the other protocol.
    let host = host.split(':').next()?;
    let path = path.trim_matches('/');
    let path = path.strip_suffix(".git").unwrap_or(path);
    (host.contains('.') && !path.is_empty()).then(|| format!("https://{host}/{path}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_where_the_remote_is_and_hold_no_secret() {
        let page = Some("https://example.org/owner/name".to_owned());
        for remote in [
            "https://example.org/owner/name.git",
            "https://user:secret@example.org/owner/name",
            "git@example.org:owner/name.git",
            "ssh://git@example.org:22/owner/name.git/",
        ] {
            assert_eq!(web_address(remote), page, "{remote}");
        }
        for remote in ["/srv/name.git", "../name", "C:\\name", "file:///srv/name"] {
            assert_eq!(web_address(remote), None, "{remote}");
        }
    }
}
