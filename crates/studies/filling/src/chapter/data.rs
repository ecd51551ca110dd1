// SPDX-License-Identifier: MIT OR Apache-2.0
//! The study's cases as its chapter reads them, in scenes and views, with the run's clock.

use crate::keys::*;
use crate::metrics::METRICS;
use crate::request::STUDY;
use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use terrafill_lab::{Answer, Comparison, Follows};
use terrafill_plot::Palette;
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Case, Cell, Claim, ConditionKey, Estimate, Metric, Noise, Outcome, REPEATS, Run, Scope, Spread,
    Standing, over_typical, process_medians, ratio, sample_spread, typical,
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

/// Conditions that say what a case is for, or name the switches that it has anyway.
const BOOKKEEPING: [ConditionKey; 7] = [ASIDE, NEEDS_RUNG, NEEDS_STEP, ROLE, RUNG, STEP, VARIANT];

/// Conditions besides those that say which case it is and not how its technique is set.
const NO_SWITCHES: [ConditionKey; 6] = [APPROXIMATE, SCENE, VIEW, TECHNIQUE, LAYOUT, REPEATS];

/// Two cases that differ in one condition; which of their figures is compared is chosen with the claim.
pub(super) const fn one_change(changed: ConditionKey) -> Comparison<'static> {
    Comparison {
        changed: changed.name(),
        follows: &[],
        one_sided: None,
        metric: FILL_WALL_MS,
        needs: Scope::DRAW,
    }
}

/// Two times that a claim compares.
pub(super) struct Timed<'a> {
    pub(super) title: String,
    pub(super) pairing: Comparison<'static>,
    pub(super) cases: [&'a Case; 2],
}

impl Timed<'_> {
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
        let comparison = Comparison {
            metric,
            needs,
            ..self.pairing
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
    /// The same by scene and view.
    of_views: BTreeMap<[&'a str; 2], Vec<&'a Case>>,
    /// The views of a scene follow each other. Cases that have a section of their own are in none.
    pub(super) views: Vec<View<'a>>,
    /// The fill's time by the run's clock.
    pub(super) metric: &'static Metric,
    pub(super) noise: Option<Noise>,
    /// The shortest variant on each curve.
    shortest: BTreeMap<String, &'a str>,
    palette: OnceCell<Palette>,
}

/// The cases of one view.
pub(super) struct View<'a> {
    pub(super) scene: &'a str,
    pub(super) name: &'a str,
    /// Full-screen passes.
    pub(super) baselines: Vec<&'a Case>,
    /// Techniques.
    pub(super) cases: Vec<&'a Case>,
    /// What users would pick instead; they compete with nothing.
    pub(super) rivals: Vec<&'a Case>,
}

impl<'a> View<'a> {
    pub(super) fn title(&self) -> String {
        format!("{}, {}", self.scene, self.name)
    }

    /// Those that compete.
    pub(super) fn competing(&self) -> impl Iterator<Item = &'a Case> + Clone + '_ {
        let cases = self.cases.iter().copied();
        cases.filter(|case| competes(case))
    }
}

impl<'a> Data<'a> {
    pub(super) fn new(run: &'a Run, metric: &'static Metric) -> Self {
        let own = || run.cases.iter().filter(|case| case.id().study == STUDY);
        let cases = own().filter(|case| !case.is_twin() && !has_role(case, "memory"));
        let cases: Vec<&Case> = cases.collect();
        let scene_of = |case: &&'a Case| case.condition(SCENE);
        let view_of = |case: &&'a Case| [SCENE, VIEW].map(|key| case.condition(key));
        let mut shortest: BTreeMap<String, &str> = BTreeMap::new();
        for case in &cases {
            let variant = case.condition(VARIANT);
            let known = shortest.entry(curve(case)).or_insert(variant);
            if (variant.len(), variant) < (known.len(), *known) {
                *known = variant;
            }
        }
        let listed = cases.iter().copied().filter(|case| is_listed(case));
        let of_scenes = grouped(listed, scene_of).into_iter();
        let views = of_scenes.flat_map(|(scene, cases)| {
            let views = grouped(cases, view_of).into_iter();
            views.map(move |([_, name], cases)| {
                let (baselines, cases) = cases.into_iter().partition(|case| is_baseline(case));
                let cases: Vec<&Case> = cases;
                let (rivals, cases) = cases.into_iter().partition(|case| is_rival(case));
                View {
                    scene,
                    name,
                    baselines,
                    cases,
                    rivals,
                }
            })
        });
        Self {
            views: views.collect(),
            of_views: grouped(cases.iter().copied(), view_of)
                .into_iter()
                .collect(),
            shortest,
            run,
            cases,
            metric,
            noise: Noise::of(own(), metric),
            palette: OnceCell::new(),
        }
    }

    /// Views of one scene after the other.
    pub(super) fn scenes(&self) -> impl Iterator<Item = &[View<'a>]> {
        self.views.chunk_by(|a, b| a.scene == b.scene)
    }

    /// Every case of a view that draws.
    pub(super) fn of_view<'s>(&'s self, of: [&'s str; 2]) -> &'s [&'a Case] {
        self.of_views.get(&of).map_or(&[], Vec::as_slice)
    }

    /// Every case of the view of this one.
    pub(super) fn beside<'s>(&'s self, case: &'s Case) -> &'s [&'a Case] {
        self.of_view([SCENE, VIEW].map(|key| case.condition(key)))
    }

    /// Colour and marker of each series.
    pub(super) fn palette(&self) -> &Palette {
        self.palette.get_or_init(|| Palette::new(self.all_series()))
    }

    /// A case's name with its marker and the command that draws it.
    pub(super) fn name_cell(&self, case: &Case, text: String) -> Cell {
        Cell {
            marker: match is_baseline(case) {
                true => String::new(),
                false => self.palette().marker(&self.marked(case)),
            },
            command: self.command(case),
            ..Cell::name(text)
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
        let mut cases = self.beside(case).iter().copied();
        cases.find(|pass| pass.condition(TECHNIQUE) == technique)
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

    /// By how much identical work differed on a scene's ladder; anywhere in the scene where none of the
    /// ladder was measured twice.
    pub(super) fn ladder_noise(&self, scene: &str) -> Option<Noise> {
        self.noise_on(scene, self.metric)
    }

    fn noise_on(&self, scene: &str, metric: &Metric) -> Option<Noise> {
        let own = self
            .run
            .cases
            .iter()
            .filter(|case| case.id().study == STUDY);
        let of_scene = own.filter(|case| case.condition(SCENE) == scene);
        let of_ladder = of_scene.clone().filter(|case| has_role(case, "ladder"));
        Noise::of(of_ladder, metric).or_else(|| Noise::of(of_scene, metric))
    }

    /// What is taken as no difference in a scene's ladder, in a sentence. A band narrower than the intervals of
    /// identical work reach could not call identical work no difference.
    pub(super) fn band_sentence(&self, scene: Option<&str>) -> String {
        let Some(scene) = scene else {
            return String::new();
        };
        let noise = self.ladder_noise(scene);
        let percent = significant(100.0 * (Noise::band(noise) - 1.0));
        match noise {
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
        let own = self
            .cases
            .iter()
            .filter(|case| keys.contains(&case.id().key()));
        let scenes = distinct(own.map(|case| case.condition(SCENE)));
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

    /// Names of all curves: a curve's place here is its colour and marker in every plot. Those that
    /// most views have come first, as the first ones differ most.
    fn all_series(&self) -> Vec<String> {
        let mut views: BTreeMap<String, BTreeSet<usize>> = BTreeMap::new();
        for (place, view) in self.views.iter().enumerate() {
            for case in view.cases.iter().chain(&view.rivals) {
                views.entry(self.marked(case)).or_default().insert(place);
            }
        }
        let mut series: Vec<(String, BTreeSet<usize>)> = views.into_iter().collect();
        series.sort_by_key(|(_, views)| std::cmp::Reverse(views.len()));
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
        let shortest = self.shortest.get(&curve(case)).copied();
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
pub(super) fn layout_name(case: &Case) -> String {
    let of = |key| case.condition(key);
    format!("{}/{}", of(TECHNIQUE), of(LAYOUT))
}

/// Technique, layout and switches without the knob. Whatever is chosen of an approximate fill is one: it says how
/// far it is off.
fn curve(case: &Case) -> String {
    let set = switches(case).into_iter();
    let set = set.filter(|(key, _)| *key != KNOB.name() && !is_approximate(case));
    set.fold(layout_name(case), |curve, (key, value)| {
        format!("{curve},{key}={value}")
    })
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
            let mut others = NO_SWITCHES.iter().chain(&BOOKKEEPING);
            others.all(|own| own.name() != *key) && !value.is_empty()
        })
        .collect()
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

/// Whether one figure is more than another, by their intervals.
pub(super) fn is_more(one: &Estimate, other: &Estimate) -> Standing {
    match (one.interval, other.interval) {
        (Some([low, _]), Some([_, high])) if low > high => Standing::Holds,
        (Some([_, high]), Some([low, _])) if high < low => Standing::DoesNotHold,
        _ => Standing::CannotTell,
    }
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

/// Items without repetitions, in order of appearance.
pub(super) fn distinct<T: Ord + Clone>(items: impl IntoIterator<Item = T>) -> Vec<T> {
    let groups = grouped(items, T::clone).into_iter();
    groups.map(|(item, _)| item).collect()
}

/// Items of the same key together, in order of appearance.
pub(crate) fn grouped<T, K: Ord + Clone>(
    items: impl IntoIterator<Item = T>,
    key: impl Fn(&T) -> K,
) -> Vec<(K, Vec<T>)> {
    let mut places: BTreeMap<K, usize> = BTreeMap::new();
    let mut groups: Vec<(K, Vec<T>)> = Vec::new();
    for item in items {
        let key = key(&item);
        let place = *places.entry(key.clone()).or_insert(groups.len());
        if place == groups.len() {
            groups.push((key, Vec::new()));
        }
        groups[place].1.push(item);
    }
    groups
}
