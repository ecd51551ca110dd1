// SPDX-License-Identifier: MIT OR Apache-2.0
//! The study's cases as its chapter reads them, in scenes and views, with the run's clock.

use crate::keys::{
    APPROXIMATE, ASIDE, BOUNDARY_LOD_PX, BOUNDARY_TOLERANCE_M, FILL_WALL_MS, LAYOUT, NEEDS_RUNG,
    NEEDS_STEP, PICTURE, ROLE, RUNG, SCENE, STEP, TECHNIQUE, TOLERANCE_M, VARIANT, VIEW,
};
use crate::metrics::METRICS;
use crate::request::STUDY;
use std::collections::{BTreeMap, BTreeSet};
use terrafill_lab::{Answer, Comparison, Follows};
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Case, Cell, Claim, ConditionKey, Estimate, Heading, Metric, Noise, Outcome, REPEATS, Run,
    Scope, Spread, over_typical, process_medians, ratio, sample_spread, typical,
};

/// Full-screen pass that reads depth in a shader and writes a constant.
pub(super) const DEPTH_PASS: &str = "depth-pass";
/// Full-screen pass that clears the stencil and writes a constant where it passes.
pub(super) const STENCIL_PASS: &str = "stencil-pass";

/// The condition whose values are the knob of the error-against-time plots, metres.
const KNOB: ConditionKey = TOLERANCE_M;

/// Pixels of a picture that `render` draws unless it is given a size.
const DEFAULT_SIZE: (u32, u32) = (1024, 1024);

/// By how many pixels levels of detail may move a boundary.
const LEVELS: ConditionKey = BOUNDARY_LOD_PX;

/// Conditions that say which case it is and not how its technique is set.
const NO_SWITCHES: [ConditionKey; 13] = [
    ASIDE,
    NEEDS_RUNG,
    NEEDS_STEP,
    APPROXIMATE,
    SCENE,
    VIEW,
    TECHNIQUE,
    VARIANT,
    LAYOUT,
    ROLE,
    RUNG,
    STEP,
    REPEATS,
];

/// Conditions that say what a case is for, or name the switches that it has anyway.
const BOOKKEEPING: [ConditionKey; 7] = [ASIDE, NEEDS_RUNG, NEEDS_STEP, ROLE, RUNG, STEP, VARIANT];

/// What a pair of cases may differ in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pairing {
    pub(super) changed: ConditionKey,
    pub(super) follows: &'static [Follows<'static>],
    pub(super) one_sided: Option<&'static str>,
}

/// Two times that a claim compares.
pub(super) struct Timed<'a> {
    pub(super) title: String,
    pub(super) pairing: Pairing,
    pub(super) cases: [&'a Case; 2],
}

impl Timed<'_> {
    pub(super) fn scene(&self) -> &str {
        self.cases[0].condition(SCENE)
    }

    /// What the time of the first over that of the second says of a claim, by the noise of its scene.
    pub(super) fn answer(&self, data: &Data<'_>, claim: Claim) -> Answer {
        self.answer_in(data, data.time_covering(Scope::DRAW), Scope::DRAW, claim)
    }

    /// The same of another figure.
    pub(super) fn answer_in(
        &self,
        data: &Data<'_>,
        metric: &'static Metric,
        needs: Scope,
        claim: Claim,
    ) -> Answer {
        let Pairing {
            changed,
            follows,
            one_sided,
        } = self.pairing;
        let comparison = Comparison {
            changed: changed.name(),
            follows,
            one_sided,
            metric,
            needs,
        };
        data.judge(comparison, self.cases, claim)
    }
}

/// Roles of cases that have a chapter of their own and no place in their scene's tables.
const UNLISTED_ROLES: [&str; 5] = ["ladder", "matrix", "needs", "subdivision", "texture"];

/// The study in a run.
pub(super) struct Data<'a> {
    pub(super) run: &'a Run,
    /// Every case that draws, A/A twins left out, in the plan's order.
    pub(super) cases: Vec<&'a Case>,
    /// Bytes of layouts.
    pub(super) memory: Vec<&'a Case>,
    /// The fill's time by the run's clock.
    pub(super) metric: &'static Metric,
    pub(super) noise: Option<Noise>,
    /// Full-screen passes by scene, view and technique.
    passes: BTreeMap<[&'a str; 3], &'a Case>,
    /// The shortest variant on each curve.
    shortest: BTreeMap<Curve, &'a str>,
}

/// The cases of one scene.
pub(super) struct Scene<'a> {
    pub(super) name: &'a str,
    pub(super) views: Vec<View<'a>>,
}

/// The cases of one view.
pub(super) struct View<'a> {
    pub(super) name: &'a str,
    /// Full-screen passes.
    pub(super) baselines: Vec<&'a Case>,
    /// Techniques.
    pub(super) cases: Vec<&'a Case>,
    /// What users would pick instead; they compete with nothing.
    pub(super) rivals: Vec<&'a Case>,
}

impl<'a> Data<'a> {
    pub(super) fn new(run: &'a Run, metric: &'static Metric) -> Self {
        let own = || run.cases.iter().filter(|case| case.id().study == STUDY);
        let (memory, cases): (Vec<&Case>, Vec<&Case>) = own()
            .filter(|case| !case.is_twin())
            .partition(|case| has_role(case, "memory"));
        let key = |case: &'a Case| [SCENE, VIEW, TECHNIQUE].map(|key| case.condition(key));
        // Backwards, so that of several the first one stays.
        let passes = cases.iter().rev().filter(|case| is_baseline(case));
        let passes = passes.map(|case| (key(case), *case)).collect();
        let mut shortest: BTreeMap<Curve, &str> = BTreeMap::new();
        for case in &cases {
            let variant = case.condition(VARIANT);
            let known = shortest.entry(Curve::of(case)).or_insert(variant);
            if (variant.len(), variant) < (known.len(), *known) {
                *known = variant;
            }
        }
        Self {
            passes,
            shortest,
            run,
            cases,
            memory,
            metric,
            noise: Noise::of(own(), metric),
        }
    }

    /// The fill's time by the run's clock, or by the wall clock where that one does not cover what is compared.
    pub(super) fn time_covering(&self, needs: Scope) -> &'static Metric {
        match self.metric.scope.covers(needs) {
            true => self.metric,
            false => FILL_WALL_MS,
        }
    }

    /// What two cases say of a claim, by the noise of their scene's ladder.
    pub(super) fn judge(
        &self,
        comparison: Comparison<'_>,
        cases: [&Case; 2],
        claim: Claim,
    ) -> Answer {
        let own = BOOKKEEPING.map(|key| Follows {
            key: key.name(),
            because: "says what the case is for, or names what it has anyway",
        });
        let follows: Vec<Follows<'_>> = comparison.follows.iter().copied().chain(own).collect();
        let comparison = Comparison {
            follows: &follows,
            ..comparison
        };
        let noise = self.noise_on(cases[0].condition(SCENE), comparison.metric);
        let judged = comparison.judge(self.run, cases, claim, noise);
        judged.unwrap_or_else(Answer::from)
    }

    /// `process CPU ms`, for headings and axes.
    pub(super) fn unit(&self) -> &'static str {
        self.run.clock().pick("GPU ms", "process CPU ms")
    }

    /// Times of a case over all its samples.
    pub(super) fn time(&self, case: &Case) -> Option<Spread> {
        sample_spread(case, self.metric)
    }

    /// The same, only if the picture is right.
    pub(super) fn right_time(&self, case: &Case) -> Option<Spread> {
        self.time(case).filter(|_| case.counts())
    }

    /// Its typical time over processes, only if the picture is right: what ranks fills.
    pub(super) fn typical(&self, case: &Case) -> Option<Estimate> {
        typical(case, self.metric).filter(|_| case.counts())
    }

    /// The fill of these that takes least typically; none of them is less than 1 over it.
    pub(super) fn fastest(&self, cases: impl Iterator<Item = &'a Case>) -> Option<&'a Case> {
        let timed = cases.filter_map(|case| Some((case, self.typical(case)?.middle)));
        let fastest = timed.min_by(|a, b| a.1.total_cmp(&b.1));
        fastest.map(|(case, _)| case)
    }

    /// Typical time of `case` over that of the fastest, both right.
    pub(super) fn over_fastest(&self, case: &Case, fastest: &Case) -> Option<Estimate> {
        let is_right = case.counts() && fastest.counts();
        over_typical(case, fastest, self.metric).filter(|_| is_right)
    }

    /// Whether it differs from the fastest by no more than identical work did.
    pub(super) fn ties_with(&self, case: &Case, fastest: &Case) -> bool {
        let ratio = self.over_fastest(case, fastest).zip(self.noise);
        ratio.is_some_and(|(ratio, noise)| noise.is_tie(ratio.middle))
    }

    /// One number for each process.
    pub(super) fn replicates(&self, case: &Case) -> Vec<f64> {
        process_medians(case, self.metric).into_values().collect()
    }

    /// Time of `case` over time of `other`, both right.
    pub(super) fn over(&self, case: &Case, other: &Case) -> Option<Estimate> {
        if !case.counts() || !other.counts() {
            return None;
        }
        ratio(case, other, self.metric)
    }

    /// The full-screen pass of the case's scene and view.
    pub(super) fn baseline(&self, case: &Case, technique: &str) -> Option<&'a Case> {
        let [scene, view] = [SCENE, VIEW].map(|key| case.condition(key));
        self.passes.get(&[scene, view, technique]).copied()
    }

    /// Time of `case` over that of a full-screen pass.
    pub(super) fn over_baseline(&self, case: &Case, technique: &str) -> Option<Estimate> {
        self.over(case, self.baseline(case, technique)?)
    }

    /// The case's times over the median of its depth-pass, for plots.
    pub(super) fn spread_over_depth_pass(&self, case: &Case) -> Option<Spread> {
        let baseline = self.right_time(self.baseline(case, DEPTH_PASS)?)?;
        Some(self.right_time(case)?.over(baseline.median))
    }

    /// A ratio with its interval, and whether it is a tie.
    pub(super) fn ratio_text(&self, ratio: &Estimate) -> String {
        let is_tie = self.noise.is_some_and(|noise| noise.is_tie(ratio.middle));
        format!("{}{}", times(ratio), if is_tie { " (tie)" } else { "" })
    }

    /// Ratios closer to 1 than this factor are no difference in a scene's ladder: so far reach the intervals
    /// of identical work there. A narrower band could not call identical work no difference.
    pub(super) fn band(&self, scene: &str) -> f64 {
        Noise::band(self.ladder_noise(scene))
    }

    /// By how much identical work differed on a scene's ladder; anywhere in the scene where none of the
    /// ladder was measured twice.
    pub(super) fn ladder_noise(&self, scene: &str) -> Option<Noise> {
        self.noise_on(scene, self.metric)
    }

    fn noise_on(&self, scene: &str, metric: &Metric) -> Option<Noise> {
        let own = || {
            self.run
                .cases
                .iter()
                .filter(|case| case.id().study == STUDY)
        };
        let of_scene = || own().filter(|case| case.condition(SCENE) == scene);
        let of_ladder = of_scene().filter(|case| has_role(case, "ladder"));
        Noise::of(of_ladder, metric).or_else(|| Noise::of(of_scene(), metric))
    }

    /// What is taken as no difference, in a sentence.
    pub(super) fn band_sentence(&self, scene: Option<&str>) -> String {
        let Some(scene) = scene else {
            return String::new();
        };
        let percent = significant(100.0 * (self.band(scene) - 1.0));
        match self.ladder_noise(scene) {
            Some(noise) => format!(
                "Less than {percent} % either way is no difference: so far the intervals of identical work \
                 reached in this run, measured twice under {} names.",
                noise.pairs
            ),
            None => format!(
                "Less than {percent} % either way is taken as no difference: this run measured no identical \
                 work twice."
            ),
        }
    }

    /// Twins of the cases with these keys, and of what else stands on their ladder.
    pub(super) fn ladder_twins(&self, keys: &[String]) -> Vec<String> {
        let scenes = self
            .cases
            .iter()
            .filter(|case| keys.contains(&case.id().key()));
        let scenes = distinct(scenes.map(|case| case.condition(SCENE)));
        let twins = self.run.cases.iter().filter(|case| {
            case.is_twin() && has_role(case, "ladder") && scenes.contains(&case.condition(SCENE))
        });
        let both = twins.flat_map(|twin| [twin.id().key(), twin.condition(REPEATS).to_owned()]);
        let new = both.filter(|key| !keys.contains(key));
        distinct(new)
    }

    /// The same as a cell.
    pub(super) fn ratio_cell(&self, ratio: Option<&Estimate>, why: &str) -> Cell {
        Cell::or_absent(ratio.map(|ratio| self.ratio_text(ratio)), why)
    }

    /// Scenes in order of appearance with the cases that have no chapter of their own.
    pub(super) fn scenes(&self) -> Vec<Scene<'a>> {
        let mut scenes: Vec<Scene<'a>> = Vec::new();
        for &case in self.cases.iter().filter(|case| is_listed(case)) {
            let (scene, view) = (case.condition(SCENE), case.condition(VIEW));
            let scene = find_or_push(
                &mut scenes,
                |known| known.name == scene,
                || Scene {
                    name: scene,
                    views: Vec::new(),
                },
            );
            let view = find_or_push(
                &mut scene.views,
                |known| known.name == view,
                || View {
                    name: view,
                    baselines: Vec::new(),
                    cases: Vec::new(),
                    rivals: Vec::new(),
                },
            );
            if is_baseline(case) {
                view.baselines.push(case);
            } else if is_rival(case) {
                view.rivals.push(case);
            } else {
                view.cases.push(case);
            }
        }
        scenes
    }

    /// Names of all curves: a curve's place here is its colour and marker in every plot. Those that
    /// most views have come first, as the first ones differ most.
    pub(super) fn all_series(&self) -> Vec<String> {
        let listed = self
            .cases
            .iter()
            .filter(|case| is_listed(case) && !is_baseline(case));
        let mut views: BTreeMap<String, BTreeSet<[&str; 2]>> = BTreeMap::new();
        for case in listed {
            let view = [SCENE, VIEW].map(|key| case.condition(key));
            views.entry(self.marked(case)).or_default().insert(view);
        }
        for case in &self.memory {
            views.entry(layout_name(case)).or_default();
        }
        let mut series: Vec<(String, usize)> = views
            .into_iter()
            .map(|(series, views)| (series, views.len()))
            .collect();
        series.sort_by_key(|(_, views)| std::cmp::Reverse(*views));
        series.into_iter().map(|(series, _)| series).collect()
    }

    /// The series whose colour and marker a case has on every page: a full plan those of its layout.
    pub(super) fn marked(&self, case: &Case) -> String {
        if is_full_plan(case) {
            return layout_name(case);
        }
        self.series(case)
    }

    /// What a reader types to see a case; empty for what `render` does not draw.
    pub(super) fn command(&self, case: &Case) -> String {
        let is_drawn = !is_baseline(case)
            && !has_role(case, "subdivision")
            && !is_rival(case)
            && ["", "scene"].contains(&case.condition(PICTURE));
        if !is_drawn {
            return String::new();
        }
        let environment = &self.run.environment;
        let size = match (environment.width, environment.height) {
            (0, _) | (_, 0) | DEFAULT_SIZE => String::new(),
            (width, height) => format!(" --size {width}x{height}"),
        };
        // Every switch by name and value: what a word sets changes from commit to commit.
        let variant = case.condition(VARIANT);
        format!(
            "terrafill render {} --view {} --technique {} --set {variant}{size} --out picture.png",
            case.condition(SCENE),
            case.condition(VIEW),
            case.condition(TECHNIQUE),
        )
    }

    /// What is one curve: technique and switches without the knob. Named by the shortest variant on it,
    /// which is the one that leaves the knob alone where there is one.
    pub(super) fn series(&self, case: &Case) -> String {
        let shortest = self.shortest.get(&Curve::of(case)).copied();
        let variant = shortest.unwrap_or_else(|| case.condition(VARIANT));
        format!("{}/{variant}", case.condition(TECHNIQUE))
    }

    /// A case's name as a plot has room for it: the knob, in short, after the rest.
    pub(super) fn label(&self, case: &Case) -> String {
        if is_full_plan(case) {
            let levels = match case.condition(LEVELS) {
                "" | "off" => String::new(),
                px => format!(", boundary ≤ {px} px"),
            };
            return format!("{}, full plan{levels}", layout_name(case));
        }
        match knob_m(case).filter(|_| has_role(case, "sweep")) {
            Some(knob) => format!("{} · {}", self.series(case), terrafill_plot::length(knob)),
            None => name(case),
        }
    }
}

/// Whether a case is the top of its technique's ladder.
fn is_full_plan(case: &Case) -> bool {
    has_role(case, "full-plan")
}

/// Technique and layout.
fn layout_name(case: &Case) -> String {
    let of = |key| case.condition(key);
    format!("{}/{}", of(TECHNIQUE), of(LAYOUT))
}

/// Technique, layout and switches without the knob.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Curve {
    technique: String,
    layout: String,
    set: Vec<(String, String)>,
}

impl Curve {
    fn of(case: &Case) -> Self {
        // Whatever is chosen of an approximate fill says how far it is off.
        let is_knob = |key: &str| key == KNOB.name() || is_approximate(case);
        let set = switches(case).into_iter();
        let set = set.filter(|(key, _)| !is_knob(key));
        Self {
            technique: case.condition(TECHNIQUE).to_owned(),
            layout: case.condition(LAYOUT).to_owned(),
            set: set
                .map(|(key, value)| (key.to_owned(), value.to_owned()))
                .collect(),
        }
    }
}

/// Technique and variant.
pub(super) fn name(case: &Case) -> String {
    format!("{}/{}", case.condition(TECHNIQUE), case.condition(VARIANT))
}

/// `scene, view`.
pub(super) fn title(case: &Case) -> String {
    format!("{}, {}", case.condition(SCENE), case.condition(VIEW))
}

pub(super) fn has_role(case: &Case, role: &str) -> bool {
    case.condition(ROLE).split('+').any(|own| own == role)
}

/// Whether a case stands in every view's comparison: as it should be used, or a layout without its plan.
pub(super) fn is_compared(case: &Case) -> bool {
    has_role(case, "main") || has_role(case, "layout")
}

/// Whether a case's picture differs from the reference by the nature of its technique.
pub(super) fn is_approximate(case: &Case) -> bool {
    case.condition(APPROXIMATE) == "yes"
}

/// Whether a case is there to be the best of its view: not a point of a sweep, which draws coarser
/// boundaries on purpose, nor an approximate fill.
pub(super) fn competes(case: &Case) -> bool {
    let is_point = has_role(case, "sweep") && !is_compared(case);
    !is_point && !is_approximate(case)
}

/// The value by which an approximate case differs from the others of its technique in a view.
pub(super) fn setting<'a>(case: &'a Case, view: &View<'_>) -> Option<&'a str> {
    let technique = case.condition(TECHNIQUE);
    let differs = |(key, value): &(&str, &str)| {
        let mut others = view.cases.iter();
        others.any(|other| {
            other.condition(TECHNIQUE) == technique && other.condition_named(key) != *value
        })
    };
    let chosen = switches(case).into_iter().find(differs);
    chosen.map(|(_, value)| value)
}

/// How a case ended, as a reader is to see it: an approximate fill is not right, and is no failure.
pub(super) fn standing(case: &Case) -> &'static str {
    match case.outcome {
        Outcome::Wrong if is_approximate(case) => "approximate",
        outcome => outcome.name(),
    }
}

pub(super) fn is_baseline(case: &Case) -> bool {
    [DEPTH_PASS, STENCIL_PASS].contains(&case.condition(TECHNIQUE))
}

/// Whether it is what users would pick instead.
pub(super) fn is_rival(case: &Case) -> bool {
    has_role(case, "rival")
}

fn is_listed(case: &Case) -> bool {
    let roles = case.condition(ROLE).split('+');
    roles
        .into_iter()
        .any(|role| !UNLISTED_ROLES.contains(&role))
}

/// Switches of technique and plan, each with its value, by name.
pub(super) fn switches(case: &Case) -> Vec<(&str, &str)> {
    let conditions = case.id().conditions.iter();
    conditions
        .map(|(key, value)| (key.as_str(), value.as_str()))
        .filter(|(key, value)| {
            NO_SWITCHES.iter().all(|own| own.name() != *key) && !value.is_empty()
        })
        .collect()
}

/// Whether two cases have these conditions in common.
pub(super) fn is_same(a: &Case, b: &Case, conditions: &[ConditionKey]) -> bool {
    conditions
        .iter()
        .all(|key| a.condition(*key) == b.condition(*key))
}

/// Value of the knob, metres: as the switch names it, else as the mesh was built.
pub(super) fn knob_m(case: &Case) -> Option<f64> {
    case.condition(KNOB)
        .parse()
        .ok()
        .or(case.value(BOUNDARY_TOLERANCE_M))
}

/// The declaration of a metric that the study has.
pub(super) fn declared(name: &str) -> &'static Metric {
    Metric::of(&METRICS, name)
}

/// A counter.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counters are whole, not negative and far below 2^53"
)]
pub(super) fn counter(case: &Case, metric: impl AsRef<str>) -> Option<u64> {
    let value = case
        .value(metric)
        .filter(|value| value.is_finite() && *value >= 0.0)?;
    Some(value.round() as u64)
}

/// Columns of tables whose first one holds names.
pub(super) fn headings(first: &str, metrics: &[(&str, &Metric)]) -> Vec<Heading> {
    let columns = metrics
        .iter()
        .map(|(text, metric)| Heading::metric(*text, *metric));
    std::iter::once(Heading::plain(first))
        .chain(columns)
        .collect()
}

/// Items without repetitions, in order of appearance.
pub(super) fn distinct<T: PartialEq>(items: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut seen = Vec::new();
    for item in items {
        if !seen.contains(&item) {
            seen.push(item);
        }
    }
    seen
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
