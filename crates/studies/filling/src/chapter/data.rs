// SPDX-License-Identifier: MIT OR Apache-2.0
//! The study's cases as its chapter reads them, in scenes and views, with the run's clock.

use crate::keys::*;
use crate::metrics::METRICS;
use crate::request::STUDY;
use std::cell::OnceCell;
use std::cmp::Reverse;
use terrafill_lab::{Answer, Cases, Comparison, Follows, Timings};
pub(super) use terrafill_lab::{distinct, grouped};
use terrafill_plot::Palette;
use terrafill_plot::number::significant;
use terrafill_results::{
    Case, Cell, Claim, ConditionKey, Estimate, Metric, Noise, Outcome, REPEATS, Run, Scope, Spread,
    Standing,
};

/// Full-screen pass that reads depth in a shader and writes a constant.
pub(super) const DEPTH_PASS: &str = "depth-pass";
/// Full-screen pass that clears the stencil and writes a constant where it passes.
pub(super) const STENCIL_PASS: &str = "stencil-pass";

/// Pixels of a picture that `render` draws unless it is given a size.
const DEFAULT_SIZE: (u32, u32) = (1024, 1024);

/// Conditions that say what a case is for, or name the switches that it has anyway.
const BOOKKEEPING: [ConditionKey; 7] = [ASIDE, NEEDS_RUNG, NEEDS_STEP, ROLE, RUNG, STEP, VARIANT];

/// Conditions besides those that say which case it is and not how its technique is set.
const NO_SWITCHES: [ConditionKey; 6] = [APPROXIMATE, SCENE, VIEW, TECHNIQUE, LAYOUT, REPEATS];

/// Roles of cases that have a section of their own and no place in their scene's tables.
const UNLISTED_ROLES: [&str; 5] = ["ladder", "matrix", "needs", "subdivision", "texture"];

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
        let comparison = Comparison {
            metric: data.time_covering(self.pairing.needs),
            ..self.pairing
        };
        data.judge(comparison, self.cases, claim)
    }
}

/// The study in a run.
pub(super) struct Data<'a> {
    pub(super) run: &'a Run,
    pub(super) study: Cases<'a>,
    /// Every case that draws, repeats left out, in the plan's order.
    pub(super) cases: Vec<&'a Case>,
    /// The views of a scene follow each other.
    pub(super) views: Vec<View<'a>>,
    /// By the fill's time.
    pub(super) timings: Timings,
    palette: OnceCell<Palette>,
}

/// The cases of one view.
pub(super) struct View<'a> {
    pub(super) scene: &'a str,
    pub(super) name: &'a str,
    /// Every one, those that have a section of their own too. The others are in the lists below.
    pub(super) all: Vec<&'a Case>,
    /// Full-screen passes.
    pub(super) baselines: Vec<&'a Case>,
    /// Techniques.
    pub(super) cases: Vec<&'a Case>,
    /// What users would pick instead; they compete with nothing.
    pub(super) rivals: Vec<&'a Case>,
}

impl<'a> View<'a> {
    fn new(scene: &'a str, name: &'a str, all: Vec<&'a Case>) -> Self {
        let listed = all.iter().copied().filter(|case| is_listed(case));
        let (baselines, others) = listed.partition(|case| is_baseline(case));
        let others: Vec<&Case> = others;
        let (rivals, cases) = others.into_iter().partition(|case| is_rival(case));
        Self {
            scene,
            name,
            all,
            baselines,
            cases,
            rivals,
        }
    }

    pub(super) fn title(&self) -> String {
        format!("{}, {}", self.scene, self.name)
    }

    /// Those in its table: full-screen passes, techniques, rivals.
    pub(super) fn listed(&self) -> impl Iterator<Item = &'a Case> + Clone + '_ {
        let lists = [&self.baselines, &self.cases, &self.rivals];
        lists.into_iter().flatten().copied()
    }

    /// Those that are there to be the best of the view: no points of sweeps, which draw coarser boundaries on
    /// purpose, and no approximate fills.
    pub(super) fn competing(&self) -> impl Iterator<Item = &'a Case> + Clone + '_ {
        let cases = self.cases.iter().copied();
        cases.filter(|case| !is_point(case) && !is_approximate(case))
    }
}

impl<'a> Data<'a> {
    pub(super) fn new(run: &'a Run) -> Self {
        let metric = run.clock().pick(FILL_GPU_MS, FILL_CPU_MS);
        let study = Cases::of_study(run, STUDY);
        let cases = study.iter().filter(|case| !has_role(case, "memory"));
        let cases: Vec<&Case> = cases.collect();
        let of_scenes = grouped(cases.iter().copied(), |case| case.condition(SCENE)).into_iter();
        let views = of_scenes.flat_map(|(scene, cases)| {
            let views = grouped(cases, |case| case.condition(VIEW)).into_iter();
            views.map(move |(name, all)| View::new(scene, name, all))
        });
        Self {
            views: views.collect(),
            run,
            study,
            cases,
            timings: Timings {
                metric,
                noise: Noise::of(run.of_study(STUDY), metric),
            },
            palette: OnceCell::new(),
        }
    }

    /// Views that list cases, those of one scene together.
    pub(super) fn scenes(&self) -> Vec<(&'a str, Vec<&View<'a>>)> {
        let listed = self.views.iter();
        let listed = listed.filter(|view| view.listed().next().is_some());
        grouped(listed, |view| view.scene)
    }

    /// Every case of the view of this one.
    pub(super) fn beside<'s>(&'s self, case: &Case) -> &'s [&'a Case] {
        let of = [SCENE, VIEW].map(|key| case.condition(key));
        let mut views = self.views.iter();
        let view = views.find(|view| [view.scene, view.name] == of);
        view.map_or(&[], |view| view.all.as_slice())
    }

    /// Colour and marker of each series.
    pub(super) fn palette(&self) -> &Palette {
        self.palette.get_or_init(|| Palette::new(self.all_series()))
    }

    /// A case's name with its marker and the command that draws it.
    pub(super) fn name_cell(&self, case: &Case, text: String) -> Cell {
        Cell {
            marker: if is_baseline(case) {
                String::new()
            } else {
                self.palette().marker(&marked(case))
            },
            command: self.command(case),
            ..Cell::name(text)
        }
    }

    /// The fill's time by the run's clock, or by the wall clock where that one does not cover what is compared.
    pub(super) fn time_covering(&self, needs: Scope) -> &'static Metric {
        if self.timings.metric.scope.covers(needs) {
            self.timings.metric
        } else {
            FILL_WALL_MS
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

    /// The full-screen pass of the case's scene and view.
    pub(super) fn baseline(&self, case: &Case, technique: &str) -> Option<&'a Case> {
        let mut cases = self.beside(case).iter().copied();
        cases.find(|pass| pass.condition(TECHNIQUE) == technique)
    }

    /// Time of `case` over that of a full-screen pass.
    pub(super) fn over_pass_cell(&self, case: &Case, pass: &str) -> Cell {
        let pass = self.baseline(case, pass);
        let over = pass.and_then(|pass| self.timings.over(case, pass));
        let why = reason_or(case, "this pass was not measured in this run");
        Cell::or_absent(over.map(|over| significant(over.middle)), why)
    }

    /// The case's times over the median of its depth-pass, for plots.
    pub(super) fn spread_over_depth_pass(&self, case: &Case) -> Option<Spread> {
        let both = [case, self.baseline(case, DEPTH_PASS)?];
        let [own, pass] = both.map(|case| self.timings.samples(case).filter(|_| case.counts()));
        Some(own?.over(pass?.median))
    }

    /// By how much identical work differed on a scene's ladder; anywhere in the scene where none of the
    /// ladder was measured twice.
    pub(super) fn noise_on(&self, scene: &str, metric: &Metric) -> Option<Noise> {
        let own = self.run.of_study(STUDY);
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
        let noise = self.noise_on(scene, self.timings.metric);
        let percent = significant(100.0 * (Noise::band(noise) - 1.0));
        let because = noise.map_or_else(
            || "this run measured no identical work twice".to_owned(),
            |noise| {
                format!(
                    "so far the intervals of identical work reached in this run, measured twice under {} names",
                    noise.pairs
                )
            },
        );
        format!("Less than {percent} % either way is no difference: {because}.")
    }

    /// Repeats of the cases with these keys, and of what else stands on their ladder.
    pub(super) fn ladder_repeats(&self, keys: &[String]) -> Vec<String> {
        let own = self.cases.iter();
        let own = own.filter(|case| keys.contains(&case.id().key()));
        let scenes = distinct(own.map(|case| case.condition(SCENE)));
        let repeats = self.run.of_study(STUDY).filter(|case| {
            case.is_repeat() && has_role(case, "ladder") && scenes.contains(&case.condition(SCENE))
        });
        let both =
            repeats.flat_map(|repeat| [repeat.id().key(), repeat.condition(REPEATS).to_owned()]);
        distinct(both.filter(|key| !keys.contains(key)))
    }

    /// Names of all curves: a curve's place here is its colour and marker in every plot. Those that
    /// most views have come first, as the first ones differ most.
    fn all_series(&self) -> Vec<String> {
        let of_view = |view: &View<'a>| {
            let cases = view.cases.iter().chain(&view.rivals);
            distinct(cases.map(|case| marked(case)))
        };
        let mut series = grouped(self.views.iter().flat_map(of_view), String::clone);
        series.sort_by_key(|(name, views)| (Reverse(views.len()), name.clone()));
        series.into_iter().map(|(series, _)| series).collect()
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
        let [scene, view, technique, variant] =
            [SCENE, VIEW, TECHNIQUE, VARIANT].map(|key| case.condition(key));
        format!(
            "terrafill render {scene} --view {view} --technique {technique} --set {variant}{size} --out picture.png"
        )
    }
}

/// A case's name as a plot has room for it: the knob, in short, after the rest.
pub(super) fn label(case: &Case) -> String {
    if has_role(case, "full-plan") {
        let levels = match case.condition(BOUNDARY_LOD_PX) {
            "" | "off" => String::new(),
            px => format!(", boundary ≤ {px} px"),
        };
        return format!("{}, full plan{levels}", layout_name(case));
    }
    match knob_m(case).filter(|_| has_role(case, "sweep")) {
        Some(knob) => format!("{} · {}", series(case), terrafill_plot::length(knob)),
        None => name(case),
    }
}

/// The series whose colour and marker a case has on every page: a full plan those of its layout.
pub(super) fn marked(case: &Case) -> String {
    if has_role(case, "full-plan") {
        layout_name(case)
    } else {
        series(case)
    }
}

/// What is one curve: technique and variant without the knob. Whatever is chosen of an approximate fill is one: it says
/// how far it is off.
pub(super) fn series(case: &Case) -> String {
    if is_approximate(case) {
        return layout_name(case);
    }
    let is_knob = |set: &&str| set.split('=').next() == Some(TOLERANCE_M.name());
    let sets = case.condition(VARIANT).split(',');
    let sets: Vec<&str> = sets.filter(|set| !is_knob(set)).collect();
    format!("{}/{}", case.condition(TECHNIQUE), sets.join(","))
}

/// Technique and layout.
pub(super) fn layout_name(case: &Case) -> String {
    let of = |key| case.condition(key);
    format!("{}/{}", of(TECHNIQUE), of(LAYOUT))
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

/// Whether a case stands on the curve of a sweep alone.
pub(super) fn is_point(case: &Case) -> bool {
    has_role(case, "sweep") && !is_compared(case)
}

/// Fills that each of these views has, by their names in order of appearance, each with its case of every view.
///
/// - `cases`: of each view those that may be one
pub(super) fn in_every_view<'a>(cases: &[Vec<&'a Case>]) -> Vec<(String, Vec<&'a Case>)> {
    let names = distinct(cases.iter().flatten().map(|case| label(case))).into_iter();
    let fills = names.filter_map(|name| {
        let of_view = |own: &Vec<&'a Case>| own.iter().copied().find(|case| label(case) == name);
        let of_views: Option<Vec<&Case>> = cases.iter().map(of_view).collect();
        Some((name, of_views?))
    });
    fills.collect()
}

/// Whether a case's picture differs from the reference by the nature of its technique.
pub(super) fn is_approximate(case: &Case) -> bool {
    case.condition(APPROXIMATE) == "yes"
}

/// The value by which an approximate case differs from the others of its technique in a view.
pub(super) fn setting<'a>(case: &'a Case, view: &View<'_>) -> Option<&'a str> {
    let differs = |(key, value): &(&str, &str)| {
        let mut others = view.cases.iter();
        others.any(|other| {
            let is_same = other.condition(TECHNIQUE) == case.condition(TECHNIQUE);
            is_same && other.condition_named(key) != *value
        })
    };
    let chosen = switches(case).into_iter().find(differs);
    let chosen = chosen.filter(|_| is_approximate(case));
    chosen.map(|(_, value)| value)
}

/// How a case ended, as a reader is to see it: an approximate fill is not right, and is no failure.
pub(super) fn standing(case: &Case) -> &'static str {
    match case.outcome {
        Outcome::Wrong if is_approximate(case) => "approximate",
        outcome => outcome.name(),
    }
}

/// Why a case has no figure: its own reason where it has one.
pub(super) fn reason_or<'c>(case: &'c Case, why: &'c str) -> &'c str {
    match case.reason.as_str() {
        "" => why,
        reason => reason,
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
    let mut roles = case.condition(ROLE).split('+');
    roles.any(|role| !UNLISTED_ROLES.contains(&role))
}

/// Switches of technique and plan, each with its value, by name.
pub(super) fn switches(case: &Case) -> Vec<(&str, &str)> {
    let conditions = case.id().conditions.iter();
    let conditions = conditions.map(|(key, value)| (key.as_str(), value.as_str()));
    let is_switch = |(key, value): &(&str, &str)| {
        let mut others = NO_SWITCHES.iter().chain(&BOOKKEEPING);
        others.all(|own| own.name() != *key) && !value.is_empty()
    };
    conditions.filter(is_switch).collect()
}

/// Value of the knob of the error-against-time plots, the boundary tolerance in metres: as the switch names it, else
/// as the mesh was built.
pub(super) fn knob_m(case: &Case) -> Option<f64> {
    let set = case.condition(TOLERANCE_M).parse().ok();
    set.or(case.value(BOUNDARY_TOLERANCE_M))
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
