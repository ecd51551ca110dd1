// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which commits to build to find the one that changed a case.

use crate::change::{Change, ChangeKind};
use crate::page::plural;
use crate::{HistoryError, Repository};
use std::collections::BTreeMap;

/// The commits between the last good one and the first bad one that a store knows.
#[derive(Debug, Clone, PartialEq)]
pub struct Bisection {
    /// The change that is looked for.
    pub change: Change,
    /// Commits after the good one up to and with the bad one, the oldest first, with their subjects;
    /// `None` where no repository was there to name them.
    pub between: Option<Vec<(String, String)>>,
}

impl Bisection {
    /// Names the commits of a change.
    ///
    /// # Errors
    /// As [`Repository::between`].
    pub fn of(change: Change, repository: Option<&Repository>) -> Result<Self, HistoryError> {
        let between = repository
            .map(|at| at.between(&change.good, &change.bad))
            .transpose()?;
        Ok(Self { change, between })
    }

    /// The commit in the middle, which halves the others; `None` where nothing is left to build.
    #[must_use]
    pub fn next(&self) -> Option<&(String, String)> {
        let between = self.between.as_ref()?;
        let undecided = &between[..between.len() - 1];
        undecided.get(undecided.len().checked_sub(1)? / 2)
    }

    /// Builds until one commit is left.
    #[must_use]
    pub fn builds(&self) -> u32 {
        let left = self.between.as_ref().map_or(1, Vec::len);
        usize::BITS - (left.max(1) - 1).leading_zeros()
    }

    /// What it comes to and what to type, a line each.
    ///
    /// - `conditions`: of the case
    #[must_use]
    pub fn lines(&self, conditions: &BTreeMap<String, String>) -> Vec<String> {
        let Change {
            case,
            metric,
            good,
            bad,
            ..
        } = &self.change;
        let size = self
            .change
            .percent()
            .map_or(String::new(), |p| format!(" ({p:+.1} %)"));
        let mut lines = vec![
            format!(
                "{case}, {metric}: {} → {}{size}",
                self.change.from, self.change.to
            ),
            format!("last good commit in the store: {good}"),
            format!("first bad commit in the store: {bad}"),
        ];
        let Some(between) = &self.between else {
            lines.push(format!(
                "to name the commits between them, give the repository that has both: --repository \
                 DIR, or type: git rev-list --reverse --ancestry-path {good}..{bad}"
            ));
            return lines;
        };
        let Some((next, subject)) = self.next() else {
            lines.push(format!("nothing lies between them: {bad} made the change"));
            return lines;
        };
        lines.push(format!(
            "{} between them, {} to find the one:",
            plural(between.len() - 1, "commit"),
            plural(self.builds() as usize, "build")
        ));
        for (commit, subject) in between {
            let mark = match commit {
                commit if commit == next => "build first",
                commit if commit == bad => "bad",
                _ => "",
            };
            lines.push(
                format!("  {commit} {mark:<11} {subject}")
                    .trim_end()
                    .to_owned(),
            );
        }
        let condition = |key: &str| conditions.get(key).filter(|value| !value.is_empty());
        let scene = condition("scene").map_or(String::new(), |scene| format!(" {scene}"));
        let technique =
            condition("technique").map_or(String::new(), |t| format!(" --technique {t}"));
        let study = case.split('/').next().unwrap_or_default();
        let is_exact = self.change.kind == ChangeKind::Exact;
        lines.push(format!(
            "{next} ({subject}) against the good commit, in one job:"
        ));
        lines.push(format!(
            "  terrafill gate{scene} --study {study}{technique}{} --base {good} --new {next}",
            if is_exact { " --no-time" } else { "" }
        ));
        lines.push("a difference there: look before it; none: look after it".to_owned());
        lines
    }
}
