// SPDX-License-Identifier: MIT OR Apache-2.0
//! Everything that a gate found, and the gate itself: counters, errors and limits first, times after.

use crate::job::conditions;
use crate::pictures::copy_pictures;
use crate::{
    Blessing, CaseTime, Exact, Finding, Floors, Gate, GateError, GateShard, GatedTimes, Job, Limit,
    Severity, ShownCase, Side, Sides as _, Span, TimeGate, TimeOptions, Verdict, apply,
    compare_exactly, compare_setups, compare_times, same_driver, verdict, watched,
};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;
use terrafill_results::{Clock, Run, RunEnvironment};

/// Version of `gate.json`.
pub const GATE_SCHEMA: u32 = 3;

/// What a gate found: `gate.json`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct GateReport {
    /// Version of this file.
    pub schema: u32,
    /// What it comes to.
    pub verdict: Verdict,
    /// The exit code that goes with it.
    pub exit_code: u8,
    /// What was compared with.
    pub base: String,
    /// What was decided about.
    pub new: String,
    /// Commits that both were built from, as their runs have them.
    pub commits: [String; 2],
    /// Options of the new run, those that change no figure left out.
    pub options: Vec<String>,
    /// Which part of a gate it is; `None`: the whole.
    pub part: Option<GateShard>,
    /// Device and driver of the new run.
    pub device: String,
    /// The clock of the times.
    pub clock: String,
    /// Cases of which counters, bytes or errors were compared.
    pub compared: Vec<String>,
    /// Figures compared over all of them.
    pub figures: usize,
    /// Cases that neither side could run, with the reason.
    pub skipped: Vec<(String, String)>,
    /// Everything that differs, the worst first.
    pub findings: Vec<Finding>,
    /// Times; `None` where none were to be compared.
    pub time: Option<TimeGate>,
    /// Pictures of the first cases that are wrong; files in the gate's folder.
    #[serde(default)]
    pub pictures: Vec<ShownCase>,
    /// Blessings that covered nothing.
    pub idle_blessings: Vec<String>,
    /// Limits that were about nothing: of a part of a gate alone, where another part may have their cases.
    pub unmatched_limits: Vec<String>,
    /// Seconds that it took, builds not counted.
    pub elapsed_s: f64,
    /// How to see more.
    pub see: String,
}

/// What the gate compares by.
pub struct Rules<'a> {
    /// Committed limits.
    pub limits: &'a [Limit],
    /// Accepted differences.
    pub blessings: &'a [Blessing],
}

impl GateReport {
    /// Counters, errors and limits of two run folders. No time is compared: they are of two jobs.
    ///
    /// # Errors
    /// As [`compare_exactly`].
    pub fn of_runs(
        names: [String; 2],
        base: &Run,
        new: &Run,
        rules: &Rules<'_>,
    ) -> Result<Self, GateError> {
        let exact = compare_exactly(base, new, rules.limits)?;
        refuse_unmatched(&exact.unmatched_limits)?;
        Ok(Self::build(
            names,
            [base, new],
            exact,
            None,
            Vec::new(),
            rules,
        ))
    }

    fn build(
        [base, new]: [String; 2],
        [run_of_base, run]: [&Run; 2],
        exact: Exact,
        time: Option<TimeGate>,
        of_time: Vec<Finding>,
        rules: &Rules<'_>,
    ) -> Self {
        let RunEnvironment {
            gpu, driver_info, ..
        } = &run.environment;
        let mut findings = exact.findings;
        findings.extend(of_time);
        let commits = [run_of_base, run].map(|run| run.environment.commit.clone());
        let idle_blessings = apply(rules.blessings, &mut findings, told_apart_by(&commits));
        let mut compared = exact.compared;
        if let Some(time) = &time {
            compared.extend(time.cases.iter().map(|case| case.case.clone()));
        }
        sort(&mut findings);
        let verdict = verdict(&findings, compared.len());
        Self {
            schema: GATE_SCHEMA,
            verdict,
            exit_code: verdict.exit_code(),
            base,
            new,
            commits,
            options: run
                .environment
                .options
                .iter()
                .filter(|option| !option.starts_with("scenes="))
                .cloned()
                .collect(),
            part: None,
            device: format!("{gpu}, {driver_info}"),
            clock: run.clock().name().to_owned(),
            compared: compared.into_iter().collect(),
            figures: exact.figures,
            skipped: exact.skipped,
            findings,
            time,
            pictures: Vec::new(),
            idle_blessings,
            unmatched_limits: exact.unmatched_limits,
            elapsed_s: 0.0,
            see: String::new(),
        }
    }

    /// The base's commit where it tells the base from the new program: blessings of times are bound to it.
    #[must_use]
    pub fn base_commit(&self) -> Option<&str> {
        told_apart_by(&self.commits)
    }

    /// What parts of one gate have in common.
    pub(crate) fn identity(&self) -> Vec<String> {
        let timed = if self.time.is_some() {
            "timed"
        } else {
            "not timed"
        };
        let words = [&self.device, &self.clock, timed].map(|text| (*text).to_owned());
        let options = self.options.iter().cloned();
        self.commits
            .iter()
            .cloned()
            .chain(words)
            .chain(options)
            .collect()
    }

    /// Findings of one severity that no blessing covers.
    pub fn of(&self, severity: Severity) -> impl Iterator<Item = &Finding> {
        let findings = self.findings.iter();
        findings.filter(move |finding| finding.severity == severity && finding.blessed.is_none())
    }

    /// Largest difference of base against base in percent, over the cases that were decided.
    #[must_use]
    pub fn null_percent(&self) -> Option<f64> {
        let cases = self.time.iter().flat_map(|time| &time.cases);
        let nulls = cases.filter_map(|case| Some(case.null_percent?.abs()));
        nulls.reduce(f64::max)
    }
}

/// The worst first; of times the largest change first.
pub(crate) fn sort(findings: &mut [Finding]) {
    findings.sort_by(|a, b| {
        let order = (a.severity, a.gate).cmp(&(b.severity, b.gate));
        let size = |of: &Finding| of.percent.map_or(0.0, f64::abs);
        order
            .then(size(b).total_cmp(&size(a)))
            .then_with(|| (&a.case, &a.metric).cmp(&(&b.case, &b.metric)))
    });
}

/// What to do in a gate over two programs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GateOptions {
    /// Whether times are compared.
    pub times: bool,
    /// Whether times are reported and decide nothing: where other work shares the machine, most are within
    /// its noise.
    pub advisory: bool,
    /// Smallest changes of times that fail, percent: of the frame, its wall clock, preparation and planning.
    pub floors_percent: [f64; 4],
    /// Time for verifying and measuring.
    pub budget: Duration,
    /// Whether other parts of the gate measure other scenes.
    pub is_part: bool,
}

impl GateOptions {
    fn by(&self, clock: Clock) -> TimeOptions {
        let mut by = TimeOptions::new(clock, self.budget);
        let Floors {
            frame,
            wall,
            preparation,
            planning,
        } = &mut by.floors;
        let floors = [frame, wall, preparation, planning].into_iter();
        for (floor, percent) in floors.zip(self.floors_percent) {
            floor.percent = percent;
        }
        by
    }
}

/// Verifies both programs, compares what they count, and then their times.
///
/// # Errors
/// [`GateError`], which is never a pass.
pub fn gate(
    job: &mut Job<'_>,
    names: [String; 2],
    options: &GateOptions,
    rules: &Rules<'_>,
    gated: GatedTimes<'_>,
) -> Result<GateReport, GateError> {
    let (base, new) = (job.verify(Side::Base)?, job.verify(Side::New)?);
    refuse_two_devices(&base, &new)?;
    let exact = compare_exactly(&base, &new, rules.limits)?;
    if !options.is_part {
        refuse_unmatched(&exact.unmatched_limits)?;
    }
    let [of_frames, of_setups] = watched(&base, &new, gated);
    let frames = of_frames.iter().filter(|of| of.span == Span::Frame);
    let cases: BTreeSet<String> = frames.flat_map(|of| of.cases.clone()).collect();
    let mut time = None;
    let mut of_time = Vec::new();
    if options.times && cases.is_empty() {
        of_time.push(untimed());
    } else if options.times {
        let by = options.by(new.clock());
        // First, in half of the time at most: frames that stay undecided take all that is left.
        let spent = job.elapsed();
        let half = TimeOptions {
            budget: spent + by.budget.saturating_sub(spent) / 2,
            ..by
        };
        let setups = compare_setups(job, &of_setups, &half)?;
        let mut measured = compare_times(job, &of_frames, &by)?;
        measured.cases.extend(setups);
        measured.measure_by(&by.floors);
        of_time = time_findings(&measured, &new);
        if options.advisory {
            advise(&mut of_time);
        }
        of_time.extend(broken_since(
            &[job.load(Side::Base)?, job.load(Side::New)?],
            &cases,
        ));
        time = Some(measured);
    }
    let mut report = GateReport::build(names, [&base, &new], exact, time, of_time, rules);
    report.pictures = copy_pictures(&report.findings, &new, job.out());
    report.elapsed_s = job.elapsed().as_secs_f64();
    let [base, new] = [Side::Base, Side::New].map(|side| job.folder(side).display().to_string());
    report.see = format!("terrafill compare {base} {new}");
    Ok(report)
}

/// The commit of the base, unless both programs may be of it.
fn told_apart_by([base, new]: &[String; 2]) -> Option<&str> {
    let is_own =
        !base.is_empty() && !base.ends_with("+dirty") && base != new.trim_end_matches("+dirty");
    is_own.then_some(base.as_str())
}

/// Refuses limits that guard nothing.
pub(crate) fn refuse_unmatched(limits: &[String]) -> Result<(), GateError> {
    if limits.is_empty() {
        return Ok(());
    }
    Err(GateError::BadInput(format!(
        "limits: found no figure in either run for {}, allowed: limits that are about one; correct them or take them out",
        limits.join("; ")
    )))
}

fn refuse_two_devices(base: &Run, new: &Run) -> Result<(), GateError> {
    let [a, b] = [&base.environment, &new.environment];
    if same_driver(a, b) && base.clock() == new.clock() {
        return Ok(());
    }
    Err(GateError::BadInput(format!(
        "base ran on {}, {} and new on {}, {}: give --adapter",
        a.gpu, a.driver_info, b.gpu, b.driver_info
    )))
}

/// Makes notes of findings.
fn advise(findings: &mut [Finding]) {
    for finding in findings {
        finding.severity = Severity::Note;
    }
}

/// Times were to be compared, and there are none.
fn untimed() -> Finding {
    Finding {
        metric: "time".to_owned(),
        ..Finding::of_all_cases(
            Gate::Time,
            "no case is right and timed on both sides; --no-time compares the rest",
        )
    }
}

fn time_findings(time: &TimeGate, run: &Run) -> Vec<Finding> {
    let conditions = conditions(run);
    let none = BTreeMap::new();
    let of = |case: &CaseTime| case.finding(conditions.get(&case.case).unwrap_or(&none));
    time.cases.iter().filter_map(of).collect()
}

/// Cases whose picture changed, or that broke off, in a later process.
fn broken_since(runs: &[Run; 2], cases: &BTreeSet<String>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (side, run) in [Side::Base, Side::New].into_iter().zip(runs) {
        let broken = run.cases.iter().filter(|case| {
            cases.contains(&case.id().key()) && case.status() != Some(terrafill_results::Status::Ok)
        });
        findings.extend(broken.map(|case| Finding {
            case: case.id().key(),
            conditions: case.id().conditions.clone(),
            metric: "status".to_owned(),
            gate: Gate::Status,
            severity: Severity::Worse,
            from: "ok".to_owned(),
            to: case.outcome.name().to_owned(),
            words: format!("in a later process of {}: {}", side.name(), case.reason),
            ..Finding::default()
        }));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_decides_nothing_and_times_that_are_missing_do() {
        let mut findings = [untimed()];
        assert_eq!(verdict(&findings, 3), Verdict::Inconclusive);
        advise(&mut findings);
        assert_eq!(verdict(&findings, 3), Verdict::Pass);
        // Negative control: advice alone is nothing measured.
        assert_eq!(verdict(&findings, 0), Verdict::NothingMeasured);
    }

    #[test]
    fn the_worst_and_the_largest_come_first() {
        let finding = |severity, gate, percent| Finding {
            severity,
            gate,
            percent,
            ..untimed()
        };
        let mut findings = [
            finding(Severity::Note, Gate::Time, Some(9.0)),
            finding(Severity::Worse, Gate::Time, Some(4.0)),
            finding(Severity::Worse, Gate::Time, Some(-8.0)),
            finding(Severity::Worse, Gate::Counters, None),
            finding(Severity::Unknown, Gate::Time, None),
        ];
        sort(&mut findings);
        let order: Vec<_> = findings.iter().map(|f| (f.severity, f.percent)).collect();
        assert_eq!(
            order,
            [
                (Severity::Worse, None),
                (Severity::Worse, Some(-8.0)),
                (Severity::Worse, Some(4.0)),
                (Severity::Unknown, None),
                (Severity::Note, Some(9.0)),
            ]
        );
    }
}
