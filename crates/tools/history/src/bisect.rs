// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which commit to build to find the one that changed a case.
//!
//! A machine's series has no value between the last commit before a change and the first one with it. Runs
//! of other machines may have one: where their figure changed too, it tells on which side a commit lies, and
//! fewer are left to build. A drift has no such commit, and no bisection finds one.

use crate::change::{Change, ChangeKind};
use crate::page::plural;
use crate::record::Machine;
use crate::series::Series;
use crate::threshold::FLOOR_PERCENT;
use crate::{HistoryError, Repository};
use std::collections::BTreeMap;
use terrafill_plot::number::significant;
use terrafill_results::condition::{SCENE, TECHNIQUE};

/// Options of a run that the gate's own options stand for, or that choose cases alone.
const CARRIED: [&str; 5] = ["studies=", "scenes=", "techniques=", "size=", "depth="];

/// On which side of a change a stored commit lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Before,
    After,
}

/// A stored figure between the two commits of a change.
#[derive(Debug, Clone, PartialEq)]
struct Stored {
    /// Of the commit among all of the store.
    place: usize,
    machine: i64,
    commit: String,
    value: f64,
    /// `None` where it is between both levels, or its machine does not show the change.
    side: Option<Side>,
}

/// The commits between the last good one and the first bad one that a store knows.
#[derive(Debug, Clone, PartialEq)]
pub struct Bisection {
    /// The change that is looked for.
    pub change: Change,
    /// Last commit that no stored run shows the change at, and the first one that one does.
    pub ends: [String; 2],
    /// Commits after the good one up to and with the bad one, the oldest first, with their subjects;
    /// `None` where no repository was there to name them.
    pub between: Option<Vec<(String, String)>>,
    stored: Vec<Stored>,
    /// Whether the stored runs between contradict each other.
    is_contradicted: bool,
}

impl Bisection {
    /// Names the commits of a change. Of a drift there are none to name.
    ///
    /// - `all`: every series of the store
    ///
    /// # Errors
    /// As [`Repository::between`].
    pub fn of(
        change: Change,
        all: &[Series],
        repository: Option<&Repository>,
    ) -> Result<Self, HistoryError> {
        let mut found = Self {
            ends: [change.good.clone(), change.bad.clone()],
            between: None,
            stored: Vec::new(),
            is_contradicted: false,
            change,
        };
        if found.change.kind == ChangeKind::Drift {
            return Ok(found);
        }
        let between = |ends: &[String; 2]| {
            let between = repository.map(|at| at.between(&ends[0], &ends[1]));
            between.transpose()
        };
        let path = between(&found.ends)?;
        let is_on_path = |commit: &str| {
            let path = path.as_ref();
            path.is_none_or(|path| path.iter().any(|(known, _)| known.starts_with(commit)))
        };
        let stored = stored(&found.change, all).into_iter();
        found.stored = stored.filter(|of| is_on_path(&of.commit)).collect();
        found.narrow();
        found.between = between(&found.ends)?;
        Ok(found)
    }

    /// Moves both ends to the stored commits that are known to lie before and after the change.
    fn narrow(&mut self) {
        self.stored.sort_by_key(|of| (of.place, of.machine));
        let of_side = |side: Side| self.stored.iter().filter(move |of| of.side == Some(side));
        let (before, after) = (
            of_side(Side::Before).next_back(),
            of_side(Side::After).next(),
        );
        let is_reversed = |(before, after): (&Stored, &Stored)| before.place >= after.place;
        self.is_contradicted = before.zip(after).is_some_and(is_reversed);
        if self.is_contradicted {
            return;
        }
        for (end, stored) in self.ends.iter_mut().zip([before, after]) {
            if let Some(stored) = stored {
                end.clone_from(&stored.commit);
            }
        }
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
    /// - `machine`: that the change was seen on
    #[must_use]
    pub fn lines(&self, conditions: &BTreeMap<String, String>, machine: &Machine) -> Vec<String> {
        let Change { case, metric, .. } = &self.change;
        let unit = match self.change.unit.as_str() {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let size = self
            .change
            .percent()
            .map_or(String::new(), |p| format!(" ({p:+.1} %)"));
        let [from, to] =
            [self.change.from, self.change.to].map(|value| figure(&self.change, value));
        let mut lines = vec![format!("{case}, {metric}: {from} → {to}{unit}{size}")];
        if self.change.kind == ChangeKind::Drift {
            let [first, last] = &self.ends;
            lines.push(format!(
                "a drift, from {first} on to {last}: many commits add to it, and no bisection finds one"
            ));
            lines.push("both ends in one job, to see whether it is the program's:".to_owned());
            lines.extend(self.gate(conditions, machine, last));
            return lines;
        }
        for stored in &self.stored {
            let side = match stored.side {
                Some(Side::Before) => "before the change",
                Some(Side::After) => "after the change",
                None => "does not tell",
            };
            lines.push(format!(
                "stored between: {} machine {}: {}{unit}, {side}",
                stored.commit,
                stored.machine,
                figure(&self.change, stored.value)
            ));
        }
        if self.is_contradicted {
            lines.push("these contradict each other and are left alone".to_owned());
        }
        let [good, bad] = &self.ends;
        lines.push(format!("last good commit in the store: {good}"));
        lines.push(format!("first bad commit in the store: {bad}"));
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
        lines.push(format!(
            "{next} ({subject}) against the good commit, in one job:"
        ));
        lines.extend(self.gate(conditions, machine, next));
        lines.push("a difference there: look before it; none: look after it".to_owned());
        lines
    }

    /// The gate of a commit against the last good one, measured as the stored runs were; and what of their
    /// options a gate has not.
    fn gate(
        &self,
        conditions: &BTreeMap<String, String>,
        machine: &Machine,
        new: &str,
    ) -> Vec<String> {
        let mut words = vec!["terrafill".to_owned(), "gate".to_owned()];
        let condition = |key: &str| conditions.get(key).filter(|value| !value.is_empty());
        words.extend(condition(SCENE.name()).map(|scene| quoted(scene)));
        let study = self.change.case.split('/').next().unwrap_or_default();
        words.extend(["--study".to_owned(), study.to_owned()]);
        if let Some(technique) = condition(TECHNIQUE.name()) {
            words.extend(["--technique".to_owned(), quoted(technique)]);
        }
        // A gate's own plan is the quick one.
        let is_quick = machine.options.iter().any(|option| option == "depth=quick");
        words.extend((!is_quick).then(|| "--main".to_owned()));
        if machine.width > 0 {
            let size = format!("{}x{}", machine.width, machine.height);
            words.extend(["--size".to_owned(), size]);
        }
        if !machine.gpu.is_empty() {
            words.extend(["--adapter".to_owned(), quoted(&machine.gpu)]);
        }
        let is_exact = self.change.kind == ChangeKind::Exact;
        words.extend(is_exact.then(|| "--no-time".to_owned()));
        words.extend(["--base", &self.ends[0], "--new", new].map(str::to_owned));
        let mut lines = vec![format!("  {}", words.join(" "))];
        let is_carried = |option: &&String| CARRIED.iter().any(|key| option.starts_with(key));
        let others: Vec<&str> = machine
            .options
            .iter()
            .filter(|option| !is_carried(option))
            .map(String::as_str)
            .collect();
        if !others.is_empty() {
            lines.push(format!(
                "  the stored runs had {} too, for which gate has no option: a case of these is \
                 measured by bench, once for each commit",
                others.join(", ")
            ));
        }
        lines
    }
}

/// Figures of a change's case at commits between its two, on any machine.
fn stored(change: &Change, all: &[Series]) -> Vec<Stored> {
    let is_same = |of: &&Series| of.case == change.case && of.metric.name == change.metric;
    let of_case: Vec<&Series> = all.iter().filter(is_same).collect();
    let place = |commit: &str| {
        let points = of_case.iter().flat_map(|series| &series.points);
        points
            .into_iter()
            .find(|p| p.commit == commit)
            .map(|p| p.place)
    };
    let Some((good, bad)) = place(&change.good).zip(place(&change.bad)) else {
        return Vec::new();
    };
    let between = |series: &&&Series| {
        let points = series.points.iter();
        let before = points.clone().rfind(|p| p.place <= good);
        let after = points.clone().find(|p| p.place >= bad);
        let levels = before.zip(after).map(|(a, b)| [a.value, b.value]);
        let within = points.filter(|p| p.place > good && p.place < bad);
        let stored = within.map(|point| Stored {
            place: point.place,
            machine: series.machine,
            commit: point.commit.clone(),
            value: point.value,
            side: levels.and_then(|levels| side(change.kind, levels, point.value)),
        });
        stored.collect::<Vec<_>>()
    };
    of_case.iter().flat_map(|series| between(&series)).collect()
}

/// On which side of a change a figure lies, by its machine's figures before and after.
fn side(kind: ChangeKind, [before, after]: [f64; 2], value: f64) -> Option<Side> {
    if kind == ChangeKind::Exact {
        let is = |other: f64| value.to_bits() == other.to_bits();
        return match (is(before), is(after)) {
            (true, false) => Some(Side::Before),
            (false, true) => Some(Side::After),
            _ => None,
        };
    }
    let size = (after / before).ln();
    // The middle third is neither's.
    let way = (value / before).ln() / size;
    if size.is_nan() || size.abs() < (FLOOR_PERCENT / 100.0).ln_1p() {
        None
    } else if way <= 1.0 / 3.0 {
        Some(Side::Before)
    } else if way >= 2.0 / 3.0 {
        Some(Side::After)
    } else {
        None
    }
}

fn figure(change: &Change, value: f64) -> String {
    match change.kind {
        ChangeKind::Exact => value.to_string(),
        ChangeKind::Step | ChangeKind::Drift => significant(value),
    }
}

/// A word as a shell reads it back.
#[must_use]
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,=+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_lies_on_the_side_of_its_own_machine() {
        let exact = |value| side(ChangeKind::Exact, [134.0, 135.0], value);
        assert_eq!(exact(134.0), Some(Side::Before));
        assert_eq!(exact(135.0), Some(Side::After));
        assert_eq!(exact(136.0), None);
        let step = |value| side(ChangeKind::Step, [10.0, 12.0], value);
        assert_eq!(step(10.3), Some(Side::Before));
        assert_eq!(step(11.8), Some(Side::After));
        assert_eq!(step(11.0), None);
        // A machine that does not show the change tells nothing.
        assert_eq!(side(ChangeKind::Step, [10.0, 10.1], 10.1), None);
        assert_eq!(side(ChangeKind::Exact, [7.0, 7.0], 7.0), None);
    }

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("scenes/moon.json"), "scenes/moon.json");
        assert_eq!(quoted("llvmpipe (256 bits)"), "'llvmpipe (256 bits)'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }
}
