// SPDX-License-Identifier: MIT OR Apache-2.0
//! The study's cases as its chapter reads them, in scenes and views, with the run's clock.

use crate::keys::*;
use crate::purpose::{
    BOOKKEEPING, Purpose, is_approximate, is_control, is_listed, is_point, switches,
};
use crate::request::STUDY;
use std::cell::OnceCell;
use terrafill_lab::{Answer, Cases, Comparison, Follows, Timings, band_sentence, scene_argument};
pub(super) use terrafill_lab::{distinct, grouped};
use terrafill_plot::Palette;
use terrafill_plot::number::significant;
use terrafill_results::{
    Case, Cell, Claim, ConditionKey, Metric, Noise, Outcome, REPEATS, Run, Scope, Spread,
};

/// Full-screen pass that reads depth in a shader and writes a constant.
pub(super) const DEPTH_PASS: &str = "depth-pass";
/// Full-screen pass that clears the stencil and writes a constant where it passes.
pub(super) const STENCIL_PASS: &str = "stencil-pass";

/// Pixels of a picture that `render` draws unless it is given a size.
const DEFAULT_SIZE: (u32, u32) = (1024, 1024);

/// Fills that ship, in the order of reports: volumes, then what is approximate, then what others do. The first ones
/// differ most in colour and marker.
const SHIPPED: [&str; 16] = [
    "vertex/doubled",
    "instanced/instanced",
    "compute/per-frame",
    "compute/cached",
    "native/gs-degenerate",
    "native/gs-line",
    "native/vs-control",
    "vertex/pulled",
    "native/gs-two-edges",
    "native/gs-adjacency",
    "native/gs-per-triangle",
    "vertex/separate",
    "vertex/per-triangle",
    "flat-mesh/flat",
    "draped-mesh/draped",
    "mask-texture/texture",
];

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

/// The study in a run.
pub(super) struct Data<'a> {
    pub(super) run: &'a Run,
    pub(super) study: Cases<'a>,
    /// Every case that draws, repeats left out, in the plan's order.
    pub(super) cases: Vec<&'a Case>,
    /// The views of a scene follow each other.
    pub(super) views: Vec<ViewCases<'a>>,
    /// By the fill's time.
    pub(super) timings: Timings,
    palette: OnceCell<Palette>,
}

/// The cases of one view.
pub(super) struct ViewCases<'a> {
    pub(super) scene: &'a str,
    pub(super) name: &'a str,
    /// Every one, those that have a section of their own too. The others are in the lists below.
    pub(super) all: Vec<&'a Case>,
    /// Full-screen passes.
    pub(super) baselines: Vec<&'a Case>,
    /// Techniques, those in their full plans before those that these are compared with.
    pub(super) cases: Vec<&'a Case>,
    /// What users would pick instead; they compete with nothing.
    pub(super) rivals: Vec<&'a Case>,
}

impl<'a> ViewCases<'a> {
    fn new(scene: &'a str, name: &'a str, all: Vec<&'a Case>) -> Self {
        let listed = all.iter().copied().filter(|case| is_listed(case));
        let (baselines, others) = listed.partition(|case| is_baseline(case));
        let others: Vec<&Case> = others;
        let (rivals, mut cases): (Vec<&Case>, Vec<&Case>) = others
            .into_iter()
            .partition(|case| Purpose::Rival.is_of(case));
        cases.sort_by_key(|case| is_control(case));
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

    /// Those in its table: techniques, full-screen passes, rivals.
    pub(super) fn listed(&self) -> impl Iterator<Item = &'a Case> + Clone + '_ {
        let lists = [&self.cases, &self.baselines, &self.rivals];
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
        let cases = study.iter().filter(|case| !Purpose::Memory.is_of(case));
        let cases: Vec<&Case> = cases.collect();
        let of_scenes = grouped(cases.iter().copied(), |case| case.condition(SCENE)).into_iter();
        let views = of_scenes.flat_map(|(scene, cases)| {
            let views = grouped(cases, |case| case.condition(VIEW)).into_iter();
            views.map(move |(name, all)| ViewCases::new(scene, name, all))
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
    pub(super) fn scenes(&self) -> Vec<(&'a str, Vec<&ViewCases<'a>>)> {
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
                self.palette().marker(&self.marked(case))
            },
            command: self.command(case),
            ..Cell::name(text)
        }
    }

    /// As [`label`]; a point of a full plan's sweep is named after the plan, too.
    pub(super) fn label(&self, case: &Case) -> String {
        match swept_m(case).filter(|_| !Purpose::FullPlan.is_of(case)) {
            Some(knob) => format!("{} · {}", self.curve(case), terrafill_plot::length(knob)),
            None => label(case),
        }
    }

    /// What is one curve, by the name of the full plan that lies on it, if one does.
    pub(super) fn curve(&self, case: &Case) -> String {
        let plan = self.plan_of(case);
        plan.map_or_else(|| series(case), label)
    }

    /// The full plan on whose curve a case lies.
    pub(super) fn plan_of(&self, case: &Case) -> Option<&'a Case> {
        let own = series(case);
        let mut beside = self.beside(case).iter().copied();
        beside.find(|other| Purpose::FullPlan.is_of(other) && series(other) == own)
    }

    /// The series whose colour and marker a case has on every page: a full plan those of its layout.
    pub(super) fn marked(&self, case: &Case) -> String {
        if Purpose::FullPlan.is_of(case) {
            layout_name(case)
        } else {
            self.curve(case)
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

    /// What two cases say of a claim, by the noise of their scene's ablation.
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

    /// The case's times over the median of its depth-pass, or why there is no such ratio.
    pub(super) fn spread_over_depth_pass(&self, case: &Case) -> Result<Spread, String> {
        let time = |case| {
            let time = self.timings.samples(case);
            time.filter(|_| case.counts())
        };
        let pass = self.baseline(case, DEPTH_PASS).and_then(time);
        let over = time(case).zip(pass);
        over.map(|(own, pass)| own.over(pass.median))
            .ok_or_else(|| self.no_ratio(case))
    }

    /// Why a case has no ratio to another's time.
    pub(super) fn no_ratio(&self, case: &Case) -> String {
        let why = match case.outcome {
            Outcome::Ok if self.timings.samples(case).is_none() => "no fill time",
            Outcome::Ok => "no depth-pass measured",
            _ => standing(case),
        };
        why.to_owned()
    }

    /// By how much identical work differed on a scene's ablation; anywhere in the scene where none of the
    /// ablation was measured twice.
    pub(super) fn noise_on(&self, scene: &str, metric: &Metric) -> Option<Noise> {
        let own = self.run.of_study(STUDY);
        let of_scene = own.filter(|case| case.condition(SCENE) == scene);
        let of_ablation = of_scene
            .clone()
            .filter(|case| Purpose::Ablation.is_of(case));
        Noise::of(of_ablation, metric).or_else(|| Noise::of(of_scene, metric))
    }

    /// What is taken as no difference in a scene's ablation, in a sentence.
    pub(super) fn band_sentence(&self, scene: Option<&str>) -> String {
        let noise = |scene| self.noise_on(scene, self.timings.metric);
        scene.map_or_else(String::new, |scene| band_sentence(noise(scene)))
    }

    /// Repeats of the cases with these keys, and of what else stands on their ablation.
    pub(super) fn ablation_repeats(&self, keys: &[String]) -> Vec<String> {
        let own = self.cases.iter();
        let own = own.filter(|case| keys.contains(&case.id().key()));
        let scenes = distinct(own.map(|case| case.condition(SCENE)));
        let repeats = self.run.of_study(STUDY).filter(|case| {
            case.is_repeat()
                && Purpose::Ablation.is_of(case)
                && scenes.contains(&case.condition(SCENE))
        });
        let both =
            repeats.flat_map(|repeat| [repeat.id().key(), repeat.condition(REPEATS).to_owned()]);
        distinct(both.filter(|key| !keys.contains(key)))
    }

    /// Names of all curves: a curve's place here is its colour and marker in every plot, and where it stands among
    /// others. Those that ship have the same place in every report.
    fn all_series(&self) -> Vec<String> {
        let of_view = |view: &ViewCases<'a>| {
            let cases = view.cases.iter().chain(&view.rivals);
            distinct(cases.map(|case| self.marked(case)))
        };
        let mut series: Vec<String> = SHIPPED.map(str::to_owned).to_vec();
        let mut others = distinct(self.views.iter().flat_map(of_view));
        // A full plan has the place of its layout.
        others.retain(|name| {
            name.split(", ")
                .all(|part| !series.iter().any(|own| own == part))
        });
        others.sort();
        series.extend(others);
        series
    }

    /// What a reader types to see a case; empty for what `render` does not draw.
    pub(super) fn command(&self, case: &Case) -> String {
        let is_drawn = !is_baseline(case)
            && !Purpose::Subdivision.is_of(case)
            && !Purpose::Rival.is_of(case)
            && ["", "scene"].contains(&case.condition(PICTURE))
            && !sets_what_is_gone(case.condition(VARIANT));
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
        let scene = scene_argument(environment, scene);
        format!(
            "terrafill render {scene} --view {view} --technique {technique} --set {variant}{size} --out picture.png"
        )
    }
}

/// Whether today's program refuses a variant of an older one.
fn sets_what_is_gone(variant: &str) -> bool {
    let keys = variant.split(',').map(|part| part.split('=').next());
    keys.flatten().any(terrafill_variant::is_gone)
}

/// A case's name as a plot has room for it: the knob, in short, after the rest.
pub(super) fn label(case: &Case) -> String {
    if Purpose::FullPlan.is_of(case) {
        let levels = match case.condition(BOUNDARY_LOD_PX) {
            "" | "off" => String::new(),
            px => format!(", moved ≤ {px} px"),
        };
        return format!("{}, full plan{levels}", layout_name(case));
    }
    match swept_m(case) {
        Some(knob) => format!("{} · {}", series(case), terrafill_plot::length(knob)),
        None => name(case),
    }
}

/// The value of the knob that a sweep turns; nothing of other cases.
fn swept_m(case: &Case) -> Option<f64> {
    knob_m(case).filter(|_| Purpose::Sweep.is_of(case))
}

/// What is one curve: technique and variant without the knob. Whatever is chosen of an approximate fill is one: it says
/// how far it is off.
fn series(case: &Case) -> String {
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

/// The value by which an approximate case differs from the others of its technique in a view.
pub(super) fn setting<'a>(case: &'a Case, view: &ViewCases<'_>) -> Option<&'a str> {
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

/// Value of the knob of the error-against-time plots, the boundary tolerance in metres: as the switch names it, else
/// as the mesh was built.
pub(super) fn knob_m(case: &Case) -> Option<f64> {
    let set = case.condition(TOLERANCE_M).parse().ok();
    set.or(case.value(BOUNDARY_TOLERANCE_M))
}
