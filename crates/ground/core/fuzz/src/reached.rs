// SPDX-License-Identifier: MIT OR Apache-2.0
//! Counts of how often a target came to each place that makes it worth running.
//!
//! A fuzzer that never gets past the first refusal finds nothing and looks healthy. A run in which
//! one of the listed branches was not reached therefore fails.

use std::fmt::{self, Write};
use std::path::Path;

/// Counters of one target.
#[derive(Debug, Clone)]
pub struct Reached {
    branches: &'static [&'static str],
    counts: Vec<u64>,
    executions: u64,
}

impl Reached {
    /// All zero.
    pub fn new(branches: &'static [&'static str]) -> Self {
        Self {
            branches,
            counts: vec![0; branches.len()],
            executions: 0,
        }
    }

    /// Counts an input.
    pub fn execution(&mut self) {
        self.executions += 1;
    }

    /// Inputs so far.
    pub fn executions(&self) -> u64 {
        self.executions
    }

    /// Puts a file of the counts in the place of the last one, whole: a fuzzer's time is up at any
    /// moment, and counts cut short then would be missing from the sum.
    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        let name = path.file_name().unwrap_or_default();
        let next = path.with_file_name(format!("next-{}", name.display()));
        std::fs::write(&next, self.to_string())?;
        std::fs::rename(&next, path)
    }

    /// Counts a branch.
    ///
    /// # Panics
    /// If it is not listed: it would be missing from the check that all were reached.
    pub fn hit(&mut self, branch: &str) {
        let index = self.branches.iter().position(|name| *name == branch);
        match index {
            Some(index) => self.counts[index] += 1,
            None => panic!("branch {branch} is not listed"),
        }
    }

    /// Branches that some input came to.
    pub fn found(&self) -> Vec<&'static str> {
        let missing = self.missing();
        let all = self.branches.iter().copied();
        all.filter(|branch| !missing.contains(branch)).collect()
    }

    /// Branches that no input came to.
    pub fn missing(&self) -> Vec<&'static str> {
        let counted = self.branches.iter().zip(&self.counts);
        counted
            .filter(|(_, count)| **count == 0)
            .map(|(branch, _)| *branch)
            .collect()
    }
}

/// One `name count` a line, executions first: what `ci/fuzz.sh` reads.
impl fmt::Display for Reached {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = format!("executions {}\n", self.executions);
        for (branch, count) in self.branches.iter().zip(&self.counts) {
            writeln!(lines, "{branch} {count}")?;
        }
        f.write_str(&lines)
    }
}
