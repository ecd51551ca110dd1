// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run as the report sees it: every planned case with its row, its samples, or neither.
//!
//! Reading is also where a run is held against itself: medians against their samples, statuses
//! against their error figures. What does not fit becomes a note in the report.

use crate::ReportError;
use crate::growth::{GrowthCurve, curves};
use crate::interval::Frames;
use crate::precision::PrecisionData;
use crate::statistic::agrees;
use crate::textured::is_textured;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use terrafill_results::legacy::{
    CaseKey, LadderRung, MemoryRow, RunEnvironment, RunFolder, RunPlan, Sample, Spread, Status,
    Summary, spread,
};

/// Backend names of the full-screen passes that techniques are held against.
const BASELINE_BACKENDS: [&str; 2] = ["bound", "floor"];

/// The switch whose values are the knob of the error-against-time plots.
const KNOB: &str = "boundary-tolerance-m=";

/// How a case ended, including that it has not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Ok,
    Wrong,
    Skipped,
    Failed,
    /// Planned, and the run says nothing of it.
    Missing,
}

impl Outcome {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Wrong => "wrong",
            Self::Skipped => "skipped",
            Self::Failed => "failed",
            Self::Missing => "missing",
        }
    }
}

/// One case.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) key: CaseKey,
    pub(crate) outcome: Outcome,
    /// `None` for a missing case.
    pub(crate) summary: Option<Summary>,
    /// Usable frame times, CPU clock, milliseconds.
    pub(crate) fill_cpu_ms: Vec<f64>,
    /// Of those frames, or from the summary where the samples are gone.
    pub(crate) fill_cpu: Option<Spread>,
}

impl Case {
    /// Backend and variant.
    pub(crate) fn name(&self) -> String {
        format!("{}/{}", self.key.backend, self.key.variant)
    }

    /// Backend and variant without the knob: what is one curve, and one colour, in the plots.
    pub(crate) fn series(&self) -> String {
        let switches: Vec<&str> = self
            .key
            .variant
            .split(',')
            .filter(|switch| !switch.starts_with(KNOB))
            .collect();
        format!("{}/{}", self.key.backend, switches.join(","))
    }

    /// Value of the knob as the variant names it, metres.
    pub(crate) fn named_knob_m(&self) -> Option<f64> {
        self.key
            .variant
            .split(',')
            .find_map(|switch| switch.strip_prefix(KNOB)?.parse().ok())
    }

    /// Value of the knob, metres: as the variant names it, else as the mesh was built.
    pub(crate) fn knob_m(&self) -> Option<f64> {
        self.named_knob_m()
            .or(self.value(|row| row.boundary_tolerance_m))
    }

    /// A cell of the summary row.
    pub(crate) fn value<T>(&self, cell: impl Fn(&Summary) -> Option<T>) -> Option<T> {
        self.summary.as_ref().and_then(cell)
    }

    /// Whether it is a full-screen pass to hold techniques against, and no technique.
    pub(crate) fn is_baseline(&self) -> bool {
        is_baseline(&self.key)
    }

    /// Whether it belongs to the sweep through the knob: its error is what is asked for, so a wrong
    /// picture is a result there and no defect.
    pub(crate) fn is_sweep(&self) -> bool {
        self.named_knob_m().is_some()
    }

    /// Why the case has no result, or the remark of its row; empty when there is nothing to say.
    pub(crate) fn reason(&self) -> &str {
        match &self.summary {
            Some(row) => &row.reason,
            None => "the run ended before this case",
        }
    }

    /// Whether its times may be compared: the picture is right.
    pub(crate) fn counts(&self) -> bool {
        self.outcome == Outcome::Ok
    }
}

/// A run, read and checked.
#[derive(Debug)]
pub(crate) struct RunData {
    pub(crate) folder: PathBuf,
    pub(crate) environment: RunEnvironment,
    pub(crate) plan: RunPlan,
    /// In the plan's order; cases that nobody planned at the end.
    pub(crate) cases: Vec<Case>,
    /// What does not fit together in the run's files.
    pub(crate) notes: Vec<String>,
    /// Cost of a mesh by the size of its outline; empty where it was not measured.
    pub(crate) growth: Vec<GrowthCurve>,
    /// Usable times of each case by frame, CPU clock, milliseconds.
    pub(crate) frames: BTreeMap<CaseKey, Frames>,
    /// Rungs of every ladder, in order.
    pub(crate) ladder: Vec<LadderRung>,
    /// Bytes of layouts.
    pub(crate) memory: Vec<MemoryRow>,
    /// The numerical suite; empty where it was not measured.
    pub(crate) precision: PrecisionData,
}

impl RunData {
    /// Reads `folder`.
    ///
    /// # Errors
    /// [`ReportError::Run`].
    pub(crate) fn load(folder: &Path) -> Result<Self, ReportError> {
        let run = RunFolder::open(folder)?;
        let plan = run.plan()?;
        let environment = run.environment()?;
        let mut rows: BTreeMap<CaseKey, Summary> = run
            .summaries()?
            .into_iter()
            .map(|row| (row.key(), row))
            .collect();
        let mut times: BTreeMap<CaseKey, Vec<f64>> = BTreeMap::new();
        let mut frames: BTreeMap<CaseKey, Frames> = BTreeMap::new();
        for sample in run.samples()? {
            if sample.fill_cpu_ms.is_finite() && sample.fill_cpu_ms > 0.0 {
                let of_case = frames.entry(Sample::key(&sample)).or_default();
                of_case.insert(sample.frame, sample.fill_cpu_ms);
            }
            times
                .entry(Sample::key(&sample))
                .or_default()
                .push(sample.fill_cpu_ms);
        }
        let mut notes = Vec::new();
        let mut cases = Vec::new();
        for key in &plan.cases {
            let (row, times) = (rows.remove(key), times.remove(key).unwrap_or_default());
            cases.push(Case::new(key.clone(), row, &times, &mut notes));
        }
        for (key, row) in rows {
            notes.push(format!("{key}: measured, but not in the plan"));
            let times = times.remove(&key).unwrap_or_default();
            cases.push(Case::new(key, Some(row), &times, &mut notes));
        }
        let precision = PrecisionData::new(
            run.precision_plan()?.as_ref(),
            run.precision()?,
            &run.precision_times()?,
            &mut notes,
        );
        Ok(Self {
            folder: folder.to_owned(),
            environment,
            plan,
            cases,
            notes,
            growth: curves(&run.growth()?),
            frames,
            ladder: run.ladder()?,
            memory: run.memory()?,
            precision,
        })
    }

    /// Cases that ended so.
    pub(crate) fn count(&self, outcome: Outcome) -> usize {
        self.cases
            .iter()
            .filter(|case| case.outcome == outcome)
            .count()
    }

    /// Cases of the sweep whose pictures are wrong.
    pub(crate) fn wrong_in_sweep(&self) -> usize {
        self.cases
            .iter()
            .filter(|case| case.outcome == Outcome::Wrong && case.is_sweep())
            .count()
    }

    /// The case with this name.
    pub(crate) fn case(&self, key: &CaseKey) -> Option<&Case> {
        self.cases.iter().find(|case| case.key == *key)
    }

    /// Whether a case has its place in the tables and plots of its scene: all but those that are
    /// only a rung of a ladder, a cell of the matrix, a cap step or a textured fill, which have
    /// chapters of their own.
    fn is_listed(&self, case: &Case) -> bool {
        match &case.summary {
            Some(row) => row
                .role
                .split('+')
                .any(|role| !["ladder", "matrix", "subdivision", "texture"].contains(&role)),
            None => {
                let is_rung = self.ladder.iter().any(|rung| rung.key() == case.key);
                !is_rung && !is_textured(&case.key) && !self.plan.drawn_only.contains(&case.key)
            }
        }
    }

    /// Scenes in order of appearance, each with its views, each with its listed cases.
    pub(crate) fn scenes(&self) -> Vec<SceneCases<'_>> {
        let mut scenes: Vec<SceneCases<'_>> = Vec::new();
        for case in self.cases.iter().filter(|case| self.is_listed(case)) {
            let scene = find_or_push(
                &mut scenes,
                |s| s.name == case.key.scene,
                || SceneCases {
                    name: &case.key.scene,
                    views: Vec::new(),
                },
            );
            let view = find_or_push(
                &mut scene.views,
                |v| v.name == case.key.view,
                || ViewCases {
                    name: &case.key.view,
                    baselines: Vec::new(),
                    cases: Vec::new(),
                },
            );
            if case.is_baseline() {
                view.baselines.push(case);
            } else {
                view.cases.push(case);
            }
        }
        scenes
    }

    /// Every curve name of the run, sorted: a curve's place here is its colour in every plot.
    pub(crate) fn series(&self) -> Vec<String> {
        let listed = self.cases.iter().filter(|case| self.is_listed(case));
        let techniques = listed.filter(|case| !case.is_baseline());
        let mut series: Vec<String> = techniques.map(Case::series).collect();
        series.sort_unstable();
        series.dedup();
        series
    }
}

/// The cases of one scene.
#[derive(Debug)]
pub(crate) struct SceneCases<'a> {
    pub(crate) name: &'a str,
    pub(crate) views: Vec<ViewCases<'a>>,
}

/// The cases of one view of a scene.
#[derive(Debug)]
pub(crate) struct ViewCases<'a> {
    pub(crate) name: &'a str,
    /// Full-screen passes.
    pub(crate) baselines: Vec<&'a Case>,
    /// Techniques.
    pub(crate) cases: Vec<&'a Case>,
}

impl Case {
    fn new(key: CaseKey, row: Option<Summary>, times: &[f64], notes: &mut Vec<String>) -> Self {
        let usable: Vec<f64> = times
            .iter()
            .copied()
            .filter(|time| time.is_finite() && *time > 0.0)
            .collect();
        if usable.len() < times.len() {
            let lost = times.len() - usable.len();
            notes.push(format!(
                "{key}: {lost} of {} frame times are 0, negative or not finite; left out",
                times.len()
            ));
        }
        let Some(row) = row else {
            return Self {
                key,
                outcome: Outcome::Missing,
                summary: None,
                fill_cpu_ms: Vec::new(),
                fill_cpu: None,
            };
        };
        check_row(&key, &row, &usable, times.len(), notes);
        Self {
            key,
            outcome: match row.status {
                Status::Ok => Outcome::Ok,
                Status::Wrong => Outcome::Wrong,
                Status::Skipped => Outcome::Skipped,
                Status::Failed => Outcome::Failed,
            },
            fill_cpu: spread(&usable).or(spread_of_summary(&row)),
            fill_cpu_ms: usable,
            summary: Some(row),
        }
    }
}

fn is_baseline(key: &CaseKey) -> bool {
    BASELINE_BACKENDS.contains(&key.backend.as_str())
}

/// Notes what in a row contradicts its samples or itself.
fn check_row(key: &CaseKey, row: &Summary, usable: &[f64], frames: usize, notes: &mut Vec<String>) {
    if row.samples as usize != frames {
        notes.push(format!(
            "{key}: summary.csv counts {} frames, samples.csv holds {frames}",
            row.samples
        ));
    }
    if let (Some(summary), Some(samples)) = (row.fill_cpu_ms, spread(usable))
        && !agrees(summary, samples.median)
    {
        notes.push(format!(
            "{key}: summary.csv gives {summary} ms as median, its samples give {} ms",
            samples.median
        ));
    }
    if row.status == Status::Ok && !is_baseline(key) {
        match row.mismatched_px_outside_band {
            None => notes.push(format!("{key}: ok, but never compared with the reference")),
            Some(0) => {}
            Some(px) => notes.push(format!(
                "{key}: ok, though {px} pixels outside the boundary band are wrong"
            )),
        }
    }
}

fn spread_of_summary(row: &Summary) -> Option<Spread> {
    let median = row
        .fill_cpu_ms
        .filter(|time| time.is_finite() && *time > 0.0)?;
    Some(Spread {
        p5: row.fill_cpu_ms_p5.unwrap_or(median),
        median,
        p95: row.fill_cpu_ms_p95.unwrap_or(median),
    })
}

fn find_or_push<T>(
    items: &mut Vec<T>,
    is_it: impl Fn(&T) -> bool,
    make: impl FnOnce() -> T,
) -> &mut T {
    let index = items.iter().position(is_it).unwrap_or_else(|| {
        items.push(make());
        items.len() - 1
    });
    &mut items[index]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(variant: &str) -> Case {
        let key = CaseKey {
            scene: "s".to_owned(),
            view: "v".to_owned(),
            backend: "vertex".to_owned(),
            variant: variant.to_owned(),
        };
        Case::new(key, None, &[], &mut Vec::new())
    }

    #[test]
    fn the_knob_is_not_part_of_the_series() {
        let coarse = case("pulled,boundary-tolerance-m=5000,positions=local-f32");
        assert_eq!(coarse.series(), "vertex/pulled,positions=local-f32");
        assert_eq!(coarse.knob_m(), Some(5000.0));
        assert_eq!(case("pulled").series(), "vertex/pulled");
        assert_eq!(case("pulled").knob_m(), None);
        // Twin: another switch of a similar name is no knob.
        assert_eq!(case("pulled,interior-tolerance-m=5").knob_m(), None);
    }

    fn notes_of(row: Summary, times: &[f64]) -> Vec<String> {
        let mut notes = Vec::new();
        Case::new(row.key(), Some(row), times, &mut notes);
        notes
    }

    fn honest_row() -> Summary {
        Summary {
            samples: 3,
            fill_cpu_ms: Some(2.0),
            mismatched_px_outside_band: Some(0),
            ..Summary::new(case("doubled").key, Status::Ok)
        }
    }

    #[test]
    fn a_full_screen_pass_needs_no_error_figures() {
        let mut row = honest_row();
        row.backend = "bound".to_owned();
        row.mismatched_px_outside_band = None;
        assert_eq!(notes_of(row, &[1.0, 2.0, 3.0]), [""; 0]);
    }

    #[test]
    fn an_honest_row_gives_no_note() {
        assert_eq!(notes_of(honest_row(), &[1.0, 2.0, 3.0]), [""; 0]);
    }

    #[test]
    fn each_contradiction_is_noted() {
        let times = [1.0, 2.0, 3.0];
        let mut row = honest_row();
        row.fill_cpu_ms = Some(2.1);
        assert!(notes_of(row, &times)[0].contains("2.1 ms as median"));
        let mut row = honest_row();
        row.samples = 4;
        assert!(notes_of(row, &times)[0].contains("counts 4 frames"));
        let mut row = honest_row();
        row.mismatched_px_outside_band = Some(7);
        assert!(notes_of(row, &times)[0].contains("7 pixels outside"));
        let mut row = honest_row();
        row.mismatched_px_outside_band = None;
        assert!(notes_of(row, &times)[0].contains("never compared"));
        let mut row = honest_row();
        row.fill_cpu_ms = Some(2.5);
        assert!(notes_of(row, &[0.0, 2.0, 3.0])[0].contains("1 of 3 frame times"));
    }
}
