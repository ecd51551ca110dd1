// SPDX-License-Identifier: MIT OR Apache-2.0
//! The table of every claim of Cozzi (2007): what it says, what was measured here, and whether they agree.
//!
//! Most claims are of a ratio: two cases in each view, which the document's file selects, by their time or by
//! counters. The others are a figure or a picture in each view. Steps are those of the vertex shader's ablation,
//! which is the version that the document timed. What is no difference is taken from the run: how far intervals
//! of identical work reach in the ablation's scene. A claim whose rows are not in the run has an empty cell.

use super::ablations::{Ablation, counters};
use super::data::{Data, Timed, grouped, is_baseline, one_change, title};
use super::table::or_dash;
use super::{memory, subdivision, textured};
use crate::claims::{Conditions, Only, PAPER, Pair, Pictured, Ratio, Step, Test};
use crate::keys::*;
use crate::metrics::METRICS;
use crate::purpose::{Purpose, is_approximate, is_compared};
use crate::request::STUDY;
use terrafill_lab::{
    AblationStep, Answer, ClaimAnswer, Claimed, Comparison, Follows, claims_blocks, claims_table,
    is_more, sentences, work_exponent,
};
use terrafill_plot::number::{count, digits, figure, significant, times};
use terrafill_results::{
    Block, Case, ChapterError, Claim, DerivedTable, Estimate, Metric, Outcome, Scope, Standing,
    ratio, share,
};

/// The technique whose ablation the document climbed.
const VOLUMES: &str = "vertex";

/// Scenes whose surface is terrain, which is made by another crate than the bare ellipsoid.
const ON_TERRAIN: [&str; 1] = ["hills"];

/// Half of the document's smallest gain, 5.4 %: a wider band of no difference would hide it.
const MAX_BAND: f64 = 1.027;

/// The condition that says whether a frame hands over what it draws.
const UPLOADS: &str = "buffers";

/// The layout that the document describes: triangles, and a degenerate one for each boundary edge, in a
/// list.
const LAYOUT_2007: &str = "native/gs-degenerate/list";

/// Steps that change how many vertices or fragments there are and nothing that costs anything beside.
const STEPS_OF_WORK: [&str; 9] = [
    "back-faces",
    "bottom-cap",
    "z-pass",
    "walls-global",
    "walls-pixels",
    "mesh-lod",
    "scissor",
    "horizon",
    "boundary-lod",
];

/// A technique and volumes.
const RIVALS: Comparison<'static> = Comparison {
    follows: &[Follows {
        key: LAYOUT.name(),
        because: "each technique calls the first of its own parameters so",
    }],
    one_sided: Some("a switch that only one of the two techniques has"),
    ..one_change(TECHNIQUE)
};

/// Views, or whatever else a claim is of, with what each says of it.
type Views = Vec<(String, Standing)>;

/// A ratio in one view, and what it says of its claim.
struct Judged<'a> {
    title: String,
    /// Both, where there are two.
    cases: Vec<&'a Case>,
    answer: Answer,
}

/// What a run has of the document's experiments.
struct Evidence<'r, 'a> {
    data: &'r Data<'a>,
    /// Of the document's technique, on the first scene that has them.
    ablations: Vec<&'r Ablation<'a>>,
}

impl<'r, 'a> Evidence<'r, 'a> {
    fn new(data: &'r Data<'a>, ablations: &'r [Ablation<'a>]) -> Self {
        let own = || {
            ablations
                .iter()
                .filter(|ablation| ablation.technique == VOLUMES)
        };
        let scene = own().next().map(|ablation| ablation.scene);
        Self {
            data,
            ablations: own()
                .filter(|ablation| Some(ablation.scene) == scene)
                .collect(),
        }
    }

    /// Ablations of a step's views.
    fn of_views(&self, step: &Step) -> impl Iterator<Item = &'r Ablation<'a>> {
        let is_of = |ablation: &&Ablation<'_>| step.views.iter().any(|view| view == ablation.view);
        self.ablations.iter().copied().filter(is_of)
    }

    /// A step in those of its views that say something of the claim.
    fn steps(&self, step: &Step) -> Vec<&'r AblationStep<'a>> {
        let vertices = |case: &Case| case.value(VERTICES);
        let own = self.of_views(step);
        let own = own.filter_map(|ablation| ablation.step(&step.name));
        let left = own.filter(|measured| match step.only {
            Only::Any => true,
            Only::AllInSight => measured.case.value(REGIONS_LEFT_OUT) == Some(0.0),
            Only::WhereItActs => measured.before.and_then(vertices) != vertices(measured.case),
        });
        left.collect()
    }

    /// Each case of a rival with that of volumes of the same view.
    fn beside_volumes(&self, rival: &Conditions) -> Vec<Timed<'a>> {
        let is_volumes = |case: &&Case| {
            case.condition(TECHNIQUE) == VOLUMES && case.condition(VARIANT) == "doubled"
        };
        let cases = self.data.cases.iter().copied();
        let pairs = cases.filter(|case| has_all(case, rival)).filter_map(|own| {
            let volumes = self.data.beside(own).iter().copied().find(is_volumes)?;
            Some(Timed {
                title: title(own),
                pairing: RIVALS,
                cases: [own, volumes],
            })
        });
        pairs.collect()
    }

    /// Every ratio of a claim.
    fn judged(&self, ratio: &Ratio) -> Vec<Judged<'a>> {
        let pairs = match &ratio.of {
            Pair::Step(step) => {
                let steps = self.steps(step).into_iter();
                return steps
                    .flat_map(|measured| self.judge_step(measured, ratio))
                    .collect();
            }
            Pair::Fills([first, second]) => textured::compared(self.data, [first, second]),
            Pair::Rival(rival) => self.beside_volumes(rival),
            Pair::CapSteps => subdivision::coarsest_over_finest(self.data),
        };
        let pairs = pairs.into_iter();
        let judged = pairs.flat_map(|of| self.judge(&of.title, of.pairing, of.cases, ratio));
        judged.collect()
    }

    /// A step and the last kept one before it, unless a step that is not right comes between both.
    fn judge_step(&self, measured: &AblationStep<'a>, ratio: &Ratio) -> Vec<Judged<'a>> {
        let title = measured.case.condition(VIEW);
        let (Some(before), None) = (measured.before, measured.skipped) else {
            return vec![Judged {
                title: title.to_owned(),
                cases: Vec::new(),
                answer: Answer::not_measured("what comes before it is not right"),
            }];
        };
        // What a step sets is the ablation's to say; a test holds this list against it.
        let set = PAPER.steps.get(measured.name).into_iter().flatten();
        let follows = set.map(|key| Follows {
            key,
            because: "the step sets it",
        });
        let follows: Vec<Follows<'_>> = follows.collect();
        // A step that changes what is handed over in a frame is compared by a clock that covers it.
        let needs = if follows.iter().any(|follows| follows.key == UPLOADS) {
            Scope::UPLOAD.and(Scope::DRAW)
        } else {
            Scope::DRAW
        };
        let comparison = Comparison {
            follows: &follows,
            needs,
            ..one_change(STEP)
        };
        self.judge(title, comparison, [before, measured.case], ratio)
    }

    /// By the time of the fill, or by each metric that the claim names.
    fn judge(
        &self,
        title: &str,
        comparison: Comparison<'_>,
        cases: [&'a Case; 2],
        ratio: &Ratio,
    ) -> Vec<Judged<'a>> {
        let time = self.data.time_covering(comparison.needs);
        let mut metrics = vec![(time, comparison.needs)];
        if !ratio.metrics.is_empty() {
            let named = ratio.metrics.iter().map(|name| Metric::of(&METRICS, name));
            metrics = named.map(|metric| (metric, metric.scope)).collect();
        }
        let judged = metrics.iter().map(|&(metric, needs)| {
            let comparison = Comparison {
                metric,
                needs,
                ..comparison
            };
            Judged {
                title: match metrics.len() {
                    1 => title.to_owned(),
                    _ => format!("{title}, {}", metric.name),
                },
                cases: cases.to_vec(),
                answer: self.data.judge(comparison, cases, ratio.expects),
            }
        });
        judged.collect()
    }

    /// All ratios of a claim, and what would settle the first that is open.
    fn ratio(&self, ratio: &Ratio) -> ClaimAnswer {
        let mut judged = self.judged(ratio);
        if let Pair::Step(step) = &ratio.of
            && step.only == Only::WhereItActs
            && judged.is_empty()
            && self
                .of_views(step)
                .any(|ablation| ablation.step(&step.name).is_some())
        {
            return ClaimAnswer::unanswered(
                Standing::NotMeasured,
                "in these views the eye is inside every volume, or so near that the step changes nothing",
            );
        }
        let is_time = ratio.metrics.is_empty();
        // What a device does not count is no row.
        judged.retain(|of| is_time || of.answer.standing != Standing::NotMeasured);
        let text = |figure: &Estimate| {
            if is_time {
                times(figure)
            } else {
                format!("{} ×", significant(figure.middle))
            }
        };
        let views = judged.iter().map(|Judged { title, answer, .. }| {
            let ours = or_dash(answer.figure.as_ref().map(text));
            (format!("{title} {ours}"), answer.standing)
        });
        let reason = match &ratio.of {
            Pair::Step(step) => changes(&self.steps(step)),
            Pair::Fills(names) => names.join(" ÷ "),
            Pair::Rival(_) | Pair::CapSteps => String::new(),
        };
        let mut because = judged.iter().map(|of| match of.answer.standing {
            Standing::CannotTell | Standing::CannotBeTested => of.answer.because.as_str(),
            _ => "",
        });
        let because = because.find(|because| !because.is_empty());
        let reason = sentences([reason.as_str(), because.unwrap_or_default()]);
        ClaimAnswer::of_views(views.collect(), reason)
    }

    /// What the run says of a claim.
    fn answer(&self, test: &Test) -> ClaimAnswer {
        let views = match test {
            Test::Ratio(ratio) => return self.ratio(ratio),
            Test::SecondPass(step) => return second_pass(&self.steps(step)),
            Test::LargestGain(step) => {
                return ClaimAnswer::of_views(self.largest_gain(step), changes(&self.steps(step)));
            }
            Test::No(why) => return ClaimAnswer::unanswered(Standing::CannotBeTested, why),
            Test::Sum { terms, says } => {
                let products = terms.iter().map(|factors| factors.iter().product::<u64>());
                let gives: u64 = products.sum();
                let standing = Standing::holds_if(gives == *says);
                vec![(format!("{} B", count(gives)), standing)]
            }
            Test::RightPictures(of) => {
                let pictured = self.pictured(of).into_iter();
                let judged = pictured.map(|(text, case)| match case.outcome {
                    Outcome::Ok => (text, Standing::Holds),
                    Outcome::Wrong => (text, Standing::DoesNotHold),
                    _ => (text, Standing::NotMeasured),
                });
                judged.collect()
            }
            Test::WrongPictures(of) => {
                let mut pictured = self.pictured(of);
                pictured.retain(|(_, case)| outside_band(case).is_some());
                // The document says of the view from close by what no other view need show.
                let is_wrong = pictured
                    .iter()
                    .any(|(_, case)| outside_band(case) > Some(0.0));
                let judged = pictured.into_iter();
                let judged = judged.map(|(text, _)| (text, Standing::holds_if(is_wrong)));
                judged.collect()
            }
            Test::FillRate => self.fill_rate(),
            Test::TexturedWorstAtHorizon => self.worst_at_horizon(),
            Test::GeometryShaderBytes(claim) => self.geometry_shader_bytes(*claim),
            Test::SurfaceIndependence => self.surface_independence(),
        };
        ClaimAnswer::of_views(views, String::new())
    }

    /// Cases with their wrong pixels in words.
    fn pictured(&self, of: &Pictured) -> Vec<(String, &'a Case)> {
        let all = self.data.cases.iter().copied();
        let pictured: Vec<(String, &Case)> = match of {
            Pictured::Step(step) => {
                let steps = self.steps(step).into_iter();
                let named =
                    steps.map(|measured| (measured.case.condition(VIEW).to_owned(), measured.case));
                named.collect()
            }
            Pictured::With(conditions) => {
                let own = all.filter(|case| is_compared(case) && has_all(case, conditions));
                own.map(|case| (title(case), case)).collect()
            }
        };
        let picture = |(title, case): (String, &'a Case)| {
            let px = or_dash(outside_band(case).map(digits));
            let shift = case.value(WALL_SHIFT_M).map(significant);
            let shift = shift.map(|shift| format!(", walls off by up to {shift} m"));
            let shift = shift.unwrap_or_default();
            (format!("{title}: {px} px outside the band{shift}"), case)
        };
        pictured.into_iter().map(picture).collect()
    }

    fn largest_gain(&self, step: &Step) -> Views {
        let views = self.of_views(step).filter_map(|ablation| {
            let measured = ablation.step(&step.name)?;
            // The document's own steps, up to what it was at work on.
            let last = ablation
                .steps
                .iter()
                .position(|measured| measured.name == "z-pass")?;
            let own = ablation.steps[..=last].iter();
            let others = own.filter(|other| !other.is_aside && other.name != step.name);
            let others = others.filter_map(|other| Some((other.name, other.gain?)));
            let (next, next_gain) = others.max_by(|a, b| a.1.middle.total_cmp(&b.1.middle))?;
            let standing = is_more(measured.gain.as_ref()?, &next_gain);
            let [gain, next_gain] =
                [measured.gain?, next_gain].map(|gain| self.data.timings.ratio_text(&gain));
            let text = format!("{} {gain}, next {next} {next_gain}", ablation.view);
            Some((text, standing))
        });
        views.collect()
    }

    fn fill_rate(&self) -> Views {
        let views = self.ablations.iter().filter_map(|ablation| {
            let [vertices, fragments] = exponents(&ablation.steps)?;
            let standing = is_more(&fragments, &vertices);
            let [vertices, fragments] = [vertices, fragments].map(|exponent| figure(&exponent));
            let text = format!(
                "{}: fragments {fragments}, vertices {vertices}",
                ablation.view
            );
            Some((text, standing))
        });
        views.collect()
    }

    fn worst_at_horizon(&self) -> Views {
        let fills = [textured::AS_IN_2007, textured::PLAIN];
        let all = textured::compared(self.data, fills);
        let over =
            |timed: &&Timed<'_>| ratio(timed.cases[0], timed.cases[1], self.data.timings.metric);
        let scenes = grouped(&all, |timed| timed.cases[0].condition(SCENE)).into_iter();
        let views = scenes.filter_map(|(scene, own)| {
            let (at_horizon, others): (Vec<&Timed<'_>>, Vec<&Timed<'_>>) = own
                .into_iter()
                .partition(|timed| timed.title.ends_with("horizon"));
            let horizon = at_horizon.first().and_then(over)?;
            let others = others.iter().filter_map(over);
            let next = others.max_by(|a, b| a.middle.total_cmp(&b.middle))?;
            let [at_horizon, most] = [horizon, next].map(|ratio| times(&ratio));
            let text = format!("{scene}: {at_horizon}, elsewhere at most {most}");
            Some((text, is_more(&horizon, &next)))
        });
        views.collect()
    }

    fn geometry_shader_bytes(&self, claim: Claim) -> Views {
        let mut found = memory::geometry_shader_ratios(self.data);
        if !found.iter().any(|(name, _)| name == LAYOUT_2007) {
            found.clear();
        }
        let views = found.iter().map(|(name, ratio)| {
            // The document's own layout decides; the others are named beside it.
            let standing = if name == LAYOUT_2007 {
                claim.standing_beyond(&Estimate::exact(*ratio), 1.0)
            } else {
                Standing::Holds
            };
            (format!("{name} {} ×", significant(*ratio)), standing)
        });
        views.collect()
    }

    fn surface_independence(&self) -> Views {
        let is_plain = |case: &&&Case| {
            !is_baseline(case)
                && !textured::is_textured(case)
                && !Purpose::Sweep.is_of(case)
                && !is_approximate(case)
                // An experiment whose error is its answer says nothing of surfaces.
                && !case.planned.may_be_wrong
        };
        let tally = |(what, on_terrain): (&str, bool)| {
            let own = self.data.cases.iter().filter(is_plain);
            let own = own.filter(|case| ON_TERRAIN.contains(&case.condition(SCENE)) == on_terrain);
            let ended = |outcome| own.clone().filter(|case| case.outcome == outcome).count();
            let (right, wrong) = (ended(Outcome::Ok), ended(Outcome::Wrong));
            let text = format!("{what}: {right} of {} pictures right", right + wrong);
            (right + wrong > 0).then(|| (text, Standing::holds_if(wrong == 0)))
        };
        let kinds = [("bare ellipsoid", false), ("terrain", true)];
        // Surfaces of one kind say nothing of two.
        let both: Option<Vec<_>> = kinds.into_iter().map(tally).collect();
        both.unwrap_or_default()
    }
}

fn has_all(case: &Case, conditions: &Conditions) -> bool {
    let mut conditions = conditions.iter();
    conditions.all(|[key, value]| case.condition_named(key) == value)
}

fn outside_band(case: &Case) -> Option<f64> {
    case.value(MISMATCHED_PX_OUTSIDE_BAND)
}

/// Exponents of time over vertices and over fragments, where a view's steps give both.
///
/// For vertices the fragments must be equal, for fragments the vertices. Only steps after culling count that change
/// nothing else.
fn exponents(steps: &[AblationStep<'_>]) -> Option<[Estimate; 2]> {
    let from = steps
        .iter()
        .position(|measured| measured.name == "culling")?;
    let usable = steps[from + 1..].iter();
    let usable = usable.filter(|measured| STEPS_OF_WORK.contains(&measured.name));
    let vertices = |case: &Case| case.value(VERTICES);
    // Of both passes.
    let fragments = |case: &Case| {
        Some(case.value(STENCIL_FRAGMENTS)? + case.value(FRAGMENT_SHADER_INVOCATIONS)?)
    };
    let over_vertices = work_exponent(usable.clone(), vertices, fragments)?;
    Some([over_vertices, work_exponent(usable, fragments, vertices)?])
}

/// What the step that moved most changed in counters.
fn changes(steps: &[&AblationStep<'_>]) -> String {
    let moved =
        |measured: &AblationStep<'_>| measured.gain.map_or(0.0, |gain| gain.middle.ln().abs());
    let most = steps.iter().max_by(|a, b| moved(a).total_cmp(&moved(b)));
    let of = |measured: &&AblationStep<'_>| {
        let changed = counters(measured.before?, measured.case);
        Some(format!("{}: {changed}", measured.case.condition(VIEW)))
    };
    most.and_then(of).unwrap_or_default()
}

fn second_pass(steps: &[&AblationStep<'_>]) -> ClaimAnswer {
    let views = steps.iter().filter_map(|measured| {
        let share = share(measured.case, COLOUR_GPU_MS, STENCIL_GPU_MS)?;
        let standing = Claim::AtLeast(0.5).standing(&share);
        Some((
            format!("{} {}", measured.case.condition(VIEW), figure(&share)),
            standing,
        ))
    });
    let fragments = steps.first().map(|measured| {
        let of = |metric| or_dash(measured.case.value(metric).map(digits));
        format!(
            "{}: {} fragments in the first pass, {} shaded in the second",
            measured.case.condition(VIEW),
            of(STENCIL_FRAGMENTS),
            of(FRAGMENT_SHADER_INVOCATIONS)
        )
    });
    ClaimAnswer::of_views(views.collect(), fragments.unwrap_or_default())
}

/// What the run says of each claim, in order.
fn all(data: &Data<'_>, ablations: &[Ablation<'_>]) -> Vec<ClaimAnswer> {
    let evidence = Evidence::new(data, ablations);
    PAPER.answers(&data.run.environment, STUDY, |test| evidence.answer(test))
}

/// The table, and how many claims ended how; nothing for a run that measured none of it.
pub(super) fn blocks(data: &Data<'_>, ablations: &[Ablation<'_>]) -> Vec<Block> {
    let all = all(data, ablations);
    let is_measured = |(claimed, answer): (&Claimed<Test>, &ClaimAnswer)| {
        answer.standing != Standing::NotMeasured
            && !matches!(claimed.test, Test::Sum { .. } | Test::No(_))
    };
    if !PAPER.claims.iter().zip(&all).any(is_measured) {
        return Vec::new();
    }
    let bound = data.band_sentence(ablations.first().map(|ablation| ablation.scene));
    claims_blocks("The claims of 2007", &PAPER, &all, &bound)
}

/// `claims.csv`: the table as data.
pub(super) fn table(
    data: &Data<'_>,
    ablations: &[Ablation<'_>],
) -> Result<DerivedTable, ChapterError> {
    claims_table("claims.csv", &PAPER, &all(data, ablations))
}

/// Keys of the cases that further processes may decide a claim by: what is undecided, or all steps while
/// noise is larger than [`MAX_BAND`].
pub(super) fn undecided(data: &Data<'_>, ablations: &[Ablation<'_>]) -> Vec<String> {
    let evidence = Evidence::new(data, ablations);
    let Some(ablation) = evidence.ablations.first() else {
        return Vec::new();
    };
    let noise = data.noise_on(ablation.scene, data.timings.metric);
    let is_noisy = noise.is_some_and(|noise| noise.reach_factor() > MAX_BAND);
    let mut keys = Vec::new();
    for claimed in &PAPER.claims {
        let Test::Ratio(ratio) = &claimed.test else {
            continue;
        };
        let is_step = matches!(ratio.of, Pair::Step(_)) && ratio.metrics.is_empty();
        for judged in evidence.judged(ratio) {
            let is_hidden = is_noisy && is_step && judged.answer.figure.is_some();
            if judged.answer.standing == Standing::CannotTell || is_hidden {
                keys.extend(judged.cases.iter().map(|case| case.id().key()));
            }
        }
    }
    keys.sort_unstable();
    keys.dedup();
    let repeats = data.ablation_repeats(&keys);
    keys.extend(repeats);
    keys
}
