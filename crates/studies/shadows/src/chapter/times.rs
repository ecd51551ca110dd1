// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is faster than what: ways of a device, steps of the ablation, rivals, shadow maps.

use self::Timed::{Drawing, Whole};
use super::Own;
use super::findings::{joined, number};
use super::plots::is_plain;
use super::sections::DEVICE_KEYS;
use crate::lamps::Limit;
use crate::metrics::*;
use std::collections::BTreeSet;
use terrafill_lab::{Answer, Bound, Comparison, Follows, grouped, measured, overall, range};
use terrafill_plot::number::figure;
use terrafill_results::{
    Case, Claim, Clock, ConditionKey, Finding, Metric, Outcome, Scope, Standing, typical,
};

/// Two ways of a device that differ in one condition: its key, the way said to be faster, the other one.
type Two = (ConditionKey, &'static str, &'static str);

/// What a comparison's time covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Timed {
    /// What the device draws.
    Drawing,
    /// What the CPU does first in each frame as well.
    Whole,
}

/// What Yang & Jin (2006) anticipated.
const ANTICIPATED: [(&str, Two, Timed); 5] = [
    (
        "z-pass is faster than z-fail on a device",
        (RULE, "z-pass", "z-fail"),
        Drawing,
    ),
    (
        "Where the eye's test chooses one rule for a view, shadows are faster than by z-fail",
        (RULE, "automatic by view, eye", "z-fail"),
        Whole,
    ),
    (
        "Two-sided stencil is faster than two passes",
        (FACES, "two-sided", "two-pass"),
        Drawing,
    ),
    (
        "A scissor above the sea level is faster than none",
        (SCISSOR, "sea-level", "off"),
        Drawing,
    ),
    (
        "A vertex shader that finds silhouettes is faster than the CPU that does in each frame",
        (SILHOUETTE, "pulled", "adjacency, each frame"),
        Whole,
    ),
];

/// What takes its place today, of which they say nothing.
const INSTEAD: [(&str, Two, Timed); 5] = [
    (
        "Where an exact test chooses one rule for a view, shadows are faster than by z-fail.",
        (RULE, "automatic by view, near-exact", "z-fail"),
        Whole,
    ),
    (
        "Where the eye's test chooses the rule of each caster, shadows are faster than by z-fail.",
        (RULE, "automatic, eye-model", "z-fail"),
        Whole,
    ),
    (
        "Where an exact test chooses the rule of each caster, shadows are faster than by z-fail.",
        (RULE, "automatic, near-exact", "z-fail"),
        Whole,
    ),
    (
        "A compute shader that finds silhouettes is faster than the CPU that does in each frame.",
        (SILHOUETTE, "compute", "adjacency, each frame"),
        Whole,
    ),
    (
        "A geometry shader that finds silhouettes of triangles is faster than the CPU that does in each frame.",
        (SILHOUETTE, "gs-adjacency", "adjacency, each frame"),
        Whole,
    ),
];

/// The same where neither light nor casters move: the CPU's volumes are kept, so that it has nothing to do first. Nobody
/// anticipated it.
const FASTER_THAN_KEPT: [(&str, Two, Timed); 3] = [
    (
        "A vertex shader that finds silhouettes is faster than volumes that are kept.",
        (SILHOUETTE, "pulled", "adjacency"),
        Drawing,
    ),
    (
        "A compute shader that finds silhouettes is faster than volumes that are kept.",
        (SILHOUETTE, "compute", "adjacency"),
        Drawing,
    ),
    (
        "A geometry shader that finds silhouettes of triangles is faster than volumes that are kept.",
        (SILHOUETTE, "gs-adjacency", "adjacency"),
        Drawing,
    ),
];

/// Frames a second that the paper has, and that it says a simulator must have, with the budget of each, ms.
const FRAMES: [(&str, f64); 2] = [
    ("as 35 a second leave (Yang & Jin, 2006, measured)", 28.6),
    ("as 24 a second leave (Yang & Jin, 2006: demanded)", 41.7),
];

/// Depth bounds of casters, of their parts, and of the whole scene.
const BOUNDS: [&str; 9] = [
    "native",
    "native, by part",
    "native, one range",
    "discard",
    "discard, by part",
    "discard, one range",
    "tiles",
    "tiles, by part",
    "tiles, one range",
];

/// What changes with a condition and is no second change.
type Beside = (&'static [Follows<'static>], Option<&'static str>);

const NOTHING: Beside = (&[], None);
const OF_SCISSORS: [Follows<'static>; 1] = [Follows {
    key: COUNTED.name(),
    because: "above the sea the scissor is exact, and below it the paper considers no shadow",
}];
const OF_BOUNDS: [Follows<'static>; 1] = [Follows {
    key: COUNTED.name(),
    because: "in the range the test is exact, and beyond it the paper considers no shadow",
}];
const OF_STEPS: [Follows<'static>; 1] = [Follows {
    key: PAPER.name(),
    because: "it is what the paper says of the step",
}];
const OF_RIVALS: [Follows<'static>; 1] = [Follows {
    key: QUESTION.name(),
    because: "each question has its own rows",
}];
const OF_VOLUMES: &str = "volumes are drawn in a way of their own, and others have none";

fn is_ok(case: &&Case) -> bool {
    case.outcome == Outcome::Ok
}

/// Whether two cases have the same conditions of a device, but for some.
pub(super) fn is_same_but(keys: &[ConditionKey], a: &Case, b: &Case) -> bool {
    let mut others = DEVICE_KEYS.iter().filter(|key| !keys.contains(key));
    others.all(|key| a.condition(*key) == b.condition(*key))
}

/// How many times as fast the second of each pair is.
fn gains<'a>(answers: impl IntoIterator<Item = &'a Answer>) -> Option<String> {
    let answers = answers.into_iter();
    let figures = answers.filter_map(|answer| answer.figure.as_ref());
    range(&figures.map(|figure| figure.middle).collect::<Vec<_>>())
}

fn count(answers: &[Answer], wanted: Standing) -> usize {
    let all = answers.iter();
    all.filter(|answer| answer.standing == wanted).count()
}

/// - `because`: in figures; what would settle an open question is added
fn finding(claim: String, answers: &[Answer], because: String) -> Finding {
    let standings: Vec<Standing> = answers.iter().map(|answer| answer.standing).collect();
    let standing = overall(&standings);
    let mut open = answers.iter();
    let open = open.find(|answer| answer.standing == standing && !answer.because.is_empty());
    let open = open.map(|answer| format!(". {}", answer.because));
    Finding {
        claim,
        standing,
        because: because + &open.unwrap_or_default(),
    }
}

impl<'a> Own<'a> {
    /// Whether the second of each pair takes less time to draw.
    fn judge(&self, changed: ConditionKey, beside: Beside, pairs: &[[&Case; 2]]) -> Vec<Answer> {
        self.judge_by(Drawing, changed, beside, pairs)
    }

    /// The same by a time that covers what is compared.
    fn judge_by(
        &self,
        timed: Timed,
        changed: ConditionKey,
        (follows, one_sided): Beside,
        pairs: &[[&Case; 2]],
    ) -> Vec<Answer> {
        let metric = self.time_of(timed);
        let drawing = Scope::DISPATCH.and(Scope::DRAW);
        let comparison = Comparison {
            changed: changed.name(),
            follows,
            one_sided,
            metric,
            needs: match timed {
                Drawing => drawing,
                Whole => drawing.and(Scope::PLAN),
            },
        };
        let (run, noise) = (self.0.run(), self.0.noise(metric));
        let judge = |pair: &[&Case; 2]| {
            let judged = comparison.judge(run, *pair, Claim::Faster, noise);
            judged.unwrap_or_else(Answer::from)
        };
        pairs.iter().map(judge).collect()
    }

    /// No clock of a GPU covers what the CPU does, so that there it is the wall clock.
    fn time_of(&self, timed: Timed) -> &'static Metric {
        match timed {
            Drawing => self.0.clock().pick(FILL_GPU, FILL_CPU),
            Whole => self.0.clock().pick(WHOLE_WALL, WHOLE_CPU),
        }
    }

    /// Cases of devices that are right, timed, and differ in one condition: first those of the way said to be slower.
    fn pairs(&self, (key, fast, slow): Two) -> Vec<[&'a Case; 2]> {
        let drawing = self.time_of(Drawing);
        let of = |way: &'static str| {
            let all = self.of_question("devices").filter(is_ok);
            all.filter(move |case| typical(case, drawing).is_some() && case.condition(key) == way)
        };
        let pair = |case| {
            let mut others = of(slow);
            let other = others.find(|other| is_same_but(&[key], case, other))?;
            Some([other, case])
        };
        of(fast).filter_map(pair).collect()
    }

    /// What is said to be faster, in order.
    pub(super) fn times(&self) -> Vec<Option<Finding>> {
        let anticipated = |(claim, two, timed): (&str, Two, Timed)| {
            self.faster(
                &format!("{claim} (Yang & Jin, 2006, anticipated)."),
                two,
                timed,
            )
        };
        let faster = ANTICIPATED.map(anticipated);
        let own = |(claim, two, timed): (&str, Two, Timed)| self.faster(claim, two, timed);
        let others_faster = INSTEAD
            .map(own)
            .into_iter()
            .chain(FASTER_THAN_KEPT.map(own));
        let others = [self.bounded(), self.ablation(), self.rivals()];
        let frames = FRAMES.map(|frames| self.frames(frames));
        let fitting = FRAMES.map(|(_, budget_ms)| self.fitting(budget_ms));
        let all = frames.into_iter().chain(fitting).chain(faster);
        let all = all.chain(others_faster);
        all.chain(others).collect()
    }

    /// Whether every frame of all channels is within a budget, by wall clock: that is what somebody waits for.
    fn frames(&self, (claim, budget_ms): (&str, f64)) -> Option<Finding> {
        let all = self.of_question("harbour").filter(is_ok);
        let of_bridge =
            all.filter(|case| case.condition(VIEW) == "bridge" && case.condition(MESH).is_empty());
        let mut standings = Vec::new();
        let text = of_bridge.filter_map(|case| {
            let frame = typical(case, FRAME_WALL)?;
            standings.push(Bound::AtMost(budget_ms).standing(frame.interval));
            let [sun, api, size] = [SUN, API, SIZE_PX].map(|key| case.condition(key));
            Some(format!("{} ms, sun {sun}, {api}, {size}", figure(&frame)))
        });
        let text: Vec<String> = text.collect();
        (!text.is_empty()).then(|| Finding {
            claim: format!("A frame of seven channels takes at most {budget_ms} ms, {claim}."),
            standing: overall(&standings),
            because: format!("Wall clock: {}", text.join("; ")),
        })
    }

    /// The largest of a run's sizes at which seven channels are drawn within a budget.
    fn fitting(&self, budget_ms: f64) -> Option<Finding> {
        let own = self.of_question("fits").filter(is_ok);
        let timed = own.filter_map(|case| {
            let frame = typical(case, FRAME_WALL)?;
            let standing = Bound::AtMost(budget_ms).standing(frame.interval);
            Some((case, figure(&frame), standing))
        });
        let timed: Vec<_> = timed.collect();
        let of_port = timed
            .iter()
            .filter(|(case, ..)| case.condition(MESH).is_empty());
        let standings: Vec<Standing> = of_port.map(|(.., standing)| *standing).collect();
        let told = |(case, ms, standing): &(&Case, String, Standing)| {
            let [api, size] = [API, SIZE_PX].map(|key| case.condition(key));
            let casters = match case.condition(MESH) {
                "" => "",
                _ => ", ten times the casters",
            };
            format!("{size} by {api}{casters}: {ms} ms, {}", standing.name())
        };
        let told: Vec<String> = timed.iter().map(told).collect();
        // One size that fits is enough.
        let standing = if standings.contains(&Standing::Holds) {
            Standing::Holds
        } else {
            overall(&standings)
        };
        (!timed.is_empty()).then(|| Finding {
            claim: format!(
                "Some size of seven channels fits {budget_ms} ms a frame on this device."
            ),
            standing,
            because: format!("Wall clock, sun 10° from -60°: {}", told.join("; ")),
        })
    }

    /// Whether one way takes less time than another, under each sun and by each interface.
    fn faster(&self, claim: &str, two: Two, timed: Timed) -> Option<Finding> {
        let beside: Beside = match two.0 {
            SCISSOR => (&OF_SCISSORS, None),
            _ => NOTHING,
        };
        let answers = self.judge_by(timed, two.0, beside, &self.pairs(two));
        let count = |wanted| count(&answers, wanted);
        let because = format!(
            "{} times as fast by {}. Of {} pairs {} are faster, {} not, {} alike, {} undecided",
            gains(&answers)?,
            self.time_of(timed).name,
            answers.len(),
            count(Standing::Holds),
            count(Standing::DoesNotHold),
            count(Standing::NoDifference),
            count(Standing::CannotTell),
        );
        Some(finding(claim.to_owned(), &answers, because))
    }

    /// Whether each limit of a lamp's reach takes less time than none.
    pub(super) fn limited(&self) -> Option<Finding> {
        let of = |limit: Limit| {
            let all = self.of_question("device-lights").filter(is_ok);
            all.filter(move |case| case.condition(LIMIT) == limit.name())
        };
        let limits = Limit::ALL.into_iter();
        let limits = limits.filter(|limit| !limit.may_be_wrong() && *limit != Limit::Off);
        let mut answers = Vec::new();
        let texts = limits.filter_map(|limit| {
            let pair = |case: &'a Case| {
                typical(case, self.0.clock().pick(FILL_GPU, FILL_CPU))?;
                let keys = [LIGHT, VIEW, API, RULE, SIZE_PX];
                let is_same = |other: &&Case| {
                    keys.iter()
                        .all(|key| other.condition(*key) == case.condition(*key))
                };
                Some([of(Limit::Off).find(is_same)?, case])
            };
            let own = self.judge(
                LIMIT,
                NOTHING,
                &of(limit).filter_map(pair).collect::<Vec<_>>(),
            );
            let gains = gains(&own)?;
            answers.extend(own);
            Some(format!("{}: {gains} times", limit.name()))
        });
        let texts: Vec<String> = texts.collect();
        let told = joined(texts, "; ")?;
        let claim = "Limits of reach make a lamp's shadows faster on a device.";
        let because = format!("As fast as without, by {}: {told}", self.0.clock().name());
        Some(finding(claim.to_owned(), &answers, because))
    }

    /// Depth bounds by the device, by discarding and by tiles, against none.
    fn bounded(&self) -> Option<Finding> {
        let mut texts = Vec::new();
        let mut answers = Vec::new();
        for how in BOUNDS {
            // The CPU reads depths back and chooses tiles, which a device's clock leaves out.
            if how.starts_with("tiles") && self.0.clock() == Clock::Gpu {
                texts.push(format!(
                    "{how}: not compared by a clock without their read-back"
                ));
                continue;
            }
            let own = self.judge(
                DEPTH_BOUNDS,
                (&OF_BOUNDS, None),
                &self.pairs((DEPTH_BOUNDS, how, "off")),
            );
            texts.extend(gains(&own).map(|gains| format!("{how}: {gains}")));
            answers.extend(own);
        }
        let because = format!(
            "Times as fast as without, by {}: {}",
            self.0.clock().name(),
            texts.join("; ")
        );
        let claim = "Depth bounds are faster, by the device's test or emulated.".to_owned();
        (!answers.is_empty()).then(|| finding(claim, &answers, because))
    }

    /// What each step of the ablation gains over the last one that could be drawn.
    fn ablation(&self) -> Option<Finding> {
        let drawn: Vec<&Case> = self.of_question("ladder").filter(is_ok).collect();
        let is_next = |pair: &[&Case; 2]| {
            let [before, case] = pair;
            [SUN, API]
                .iter()
                .all(|key| before.condition(*key) == case.condition(*key))
        };
        let pairs = drawn.windows(2).map(|pair| [pair[0], pair[1]]);
        let pairs: Vec<[&Case; 2]> = pairs.filter(is_next).collect();
        let answers = self.judge(STEP, (&OF_STEPS, None), &pairs);
        let judged = pairs.iter().zip(&answers);
        let of_steps = grouped(judged.clone(), |([_, case], _)| case.condition(STEP));
        let text = of_steps.iter().filter_map(|(step, own)| {
            let gains = gains(own.iter().map(|(_, answer)| *answer))?;
            Some(format!("{step}: {gains}"))
        });
        let because = format!(
            "Times as fast to draw as the step before, by {}: {}",
            self.0.clock().name(),
            text.collect::<Vec<_>>().join("; ")
        );
        let is_anticipated = |case: &Case| case.condition(PAPER).contains("anticipated");
        let anticipated = judged.filter(|([_, case], _)| is_anticipated(case));
        let anticipated: Vec<Answer> = anticipated.map(|(_, answer)| answer.clone()).collect();
        let claim = "Each step of the ablation that was anticipated to be faster is (Yang & Jin, 2006, anticipated).";
        (!anticipated.is_empty()).then(|| finding(claim.to_owned(), &anticipated, because))
    }

    /// Volumes as the rows of an interface begin with them, under a sun; the bridge's view has no name.
    fn plain(&self, [sun, view]: [&str; 2], api: &str) -> Option<&'a Case> {
        let mut all = self.of_question("devices");
        all.find(|case| {
            let is_own = case.condition(SUN) == sun && case.condition(VIEW) == view;
            is_own && case.condition(API) == api && is_plain(case)
        })
    }

    /// Rivals' pixels, and their times beside those of volumes by the same interface.
    fn rivals(&self) -> Option<Finding> {
        let known = |case: &&Case| matches!(case.outcome, Outcome::Ok | Outcome::Wrong);
        let all: Vec<&Case> = self.of_question("rivals").filter(known).collect();
        let wrong: Option<Vec<f64>> = all.iter().map(|case| Self::wrong_px(case)).collect();
        let wrong: f64 = wrong?.iter().sum();
        let drawing = self.time_of(Drawing);
        let names: BTreeSet<&str> = all.iter().map(|case| case.condition(RIVAL)).collect();
        let mut texts = Vec::new();
        let mut answers = Vec::new();
        for name in names {
            let own = all.iter();
            let own = own
                .filter(|case| typical(case, drawing).is_some() && case.condition(RIVAL) == name);
            let pair = |case: &&'a Case| {
                let volumes = self.plain(
                    [SUN, VIEW].map(|key| case.condition(key)),
                    case.condition(API),
                )?;
                Some([*case, volumes])
            };
            let pairs: Vec<[&Case; 2]> = own.filter_map(pair).collect();
            let own = self.judge(RIVAL, (&OF_RIVALS, Some(OF_VOLUMES)), &pairs);
            texts.extend(gains(&own).map(|gains| format!("{name}: {gains}")));
            answers.extend(own);
        }
        let because = format!(
            "{} pixels of rivals are wrong outside the band. Times of rivals over those of volumes, by {}: {}",
            number(wrong),
            self.0.clock().name(),
            texts.join("; ")
        );
        let claim = "Volumes closed at the sea are faster than rivals that are as exact.";
        let found = || {
            let found = finding(claim.to_owned(), &answers, because);
            let are_exact = Standing::holds_if(wrong == 0.0);
            Finding {
                standing: overall(&[found.standing, are_exact]),
                ..found
            }
        };
        (!all.is_empty()).then(found)
    }

    /// Maps of a device that are timed, each with the volumes of its sun, and the wrong pixels of both, the band included.
    fn maps_with_volumes(&self) -> Vec<([f64; 2], [&'a Case; 2])> {
        let metric = self.time_of(Drawing);
        let all_wrong = |case: &Case| {
            measured(case, metric)?;
            Some(Self::wrong_px(case)? + measured(case, SHADOW_BAND_PX)?)
        };
        let pair = |case: &'a Case| {
            let volumes = self.plain([case.condition(SUN), ""], "wgpu")?;
            Some(([all_wrong(case)?, all_wrong(volumes)?], [volumes, case]))
        };
        self.of_question("device-maps").filter_map(pair).collect()
    }

    /// Whether any map is as exact as volumes are, and what the most exact one of each sun takes.
    pub(super) fn equal_error(&self) -> Option<Finding> {
        let pairs = self.maps_with_volumes();
        let by_sun = grouped(pairs, |(_, [_, map])| map.condition(SUN));
        let mut is_reached = false;
        let texts = by_sun.iter().filter_map(|(sun, own)| {
            let ([of_map, of_volumes], [volumes, map]) =
                own.iter().min_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]))?;
            is_reached |= of_map <= of_volumes;
            let answers = self.judge(
                QUESTION,
                (&OF_RIVALS, Some(OF_VOLUMES)),
                &[[*map, *volumes]],
            );
            Some(format!(
                "sun {sun}: {} wrong pixels at {} m in {} × the time of volumes, which have {}",
                number(*of_map),
                map.condition(TEXEL_M),
                gains(&answers)?,
                number(*of_volumes)
            ))
        });
        let texts = joined(texts, "; ")?;
        let claim = "No shadow map is as exact as volumes, so that at equal error there is no other time to compare.";
        Some(Finding {
            claim: claim.to_owned(),
            standing: Standing::holds_if(!is_reached),
            because: format!(
                "The most exact map, the band included, by {}, {texts}",
                self.0.clock().name()
            ),
        })
    }

    /// Time and wrong pixels of a device's maps beside those of volumes, by sun.
    pub(super) fn volumes_or_maps(&self) -> Option<Finding> {
        let pairs = self.maps_with_volumes();
        let fewer = pairs
            .iter()
            .filter(|([of_map, of_volumes], _)| of_map < of_volumes);
        let fewer: Vec<[&Case; 2]> = fewer.map(|(_, pair)| *pair).collect();
        let answers = self.judge(QUESTION, (&OF_RIVALS, Some(OF_VOLUMES)), &fewer);
        let names = |wanted: &[Standing]| {
            let all = fewer.iter().zip(&answers);
            let own = all.filter(|(_, answer)| wanted.contains(&answer.standing));
            let names = own.map(|([_, case], _)| case.id().name.as_str());
            names.collect::<Vec<_>>().join(", ")
        };
        let better = names(&[Standing::Holds]);
        let open = names(&[
            Standing::CannotTell,
            Standing::NotMeasured,
            Standing::CannotBeTested,
        ]);
        let mut said = answers.iter().filter(|answer| !answer.because.is_empty());
        let said = said.next().map_or("", |answer| answer.because.as_str());
        let (by, all) = (self.0.clock().name(), pairs.len());
        let (standing, because) = match (better.as_str(), open.as_str()) {
            ("", "") => (Standing::Holds, format!("None of {all} maps does, by {by}")),
            ("", open) => (
                Standing::CannotTell,
                format!(
                    "Of {all} maps these have fewer wrong pixels, and whether they take less {by} cannot be told: {open}. {said}"
                ),
            ),
            (better, _) => (
                Standing::DoesNotHold,
                format!("These do, by {by}: {better}"),
            ),
        };
        let claim = "No shadow map takes less time than volumes and has fewer wrong pixels, those in the band included.";
        (all > 0).then(|| Finding {
            claim: claim.to_owned(),
            standing,
            because,
        })
    }
}
