// SPDX-License-Identifier: MIT OR Apache-2.0
//! The table of every claim of Cozzi (2007): what it says, what was measured here, and whether they agree.
//!
//! Steps are those of the vertex shader's ladder, which is the version that the document timed. What is
//! no difference is taken from the run: how far intervals of identical work reach in the ladder's scene. A
//! claim whose rows are not in the run has an empty cell.

use super::data::{
    Data, Timed, counter, declared, grouped, has_role, is_approximate, is_baseline, is_compared,
    is_more, one_change,
};
use super::rungs::{Ladder, Rung, SOURCE, counters};
use super::table::{or_dash, sentences};
use super::textured::AS_IN_2007_OVER_PLAIN;
use super::{fill_rate, memory, subdivision, textured};
use crate::claims::{self, Gain, Only, PAPER, Rival, Test};
use crate::keys::*;
use crate::request::STUDY;
use terrafill_lab::{
    Answer, Claimed, Comparison, Follows, Told, claims_blocks, claims_table, full_command, overall,
};
use terrafill_plot::number::{count, figure, significant, times};
use terrafill_results::{
    Block, Case, ChapterError, Claim, DerivedTable, Estimate, Finding, Outcome, Scope, Standing,
    ratio, share,
};

/// The technique whose ladder the document climbed.
const VOLUMES: &str = "vertex";

/// Scenes whose surface is terrain, which is made by another crate than the bare ellipsoid.
const ON_TERRAIN: [&str; 1] = ["hills"];

/// Half of the document's smallest gain, 5.4 %: a wider band of no difference would hide it.
const MAX_BAND: f64 = 1.027;

/// The condition that says whether a frame hands over what it draws.
const UPLOADS: &str = "buffers";

/// What the document expects of the coarsest mesh's time over the finest's.
const SUBDIVISION: Claim = Claim::NotFaster;

/// Parts of an answer, each with its words.
///
/// - `reason`: from counters where there are any
fn told(parts: impl IntoIterator<Item = (String, Standing)>, reason: impl Into<String>) -> Told {
    let (ours, standings): (Vec<String>, Vec<Standing>) = parts.into_iter().unzip();
    let standing = overall(&standings);
    Told {
        ours: ours.join("; "),
        standing,
        reason: match standing {
            Standing::NotMeasured => "its rows are not in this run".to_owned(),
            _ => reason.into(),
        },
    }
}

/// Why there is no answer.
fn unanswered(standing: Standing, why: &str) -> Told {
    Told {
        ours: String::new(),
        standing,
        reason: why.to_owned(),
    }
}

/// Ratios with what each says of a claim, and what would settle the first that is open.
fn of_answers(answers: Vec<(&str, Answer)>, reason: String) -> Told {
    let mut open = answers.iter().map(|(_, answer)| answer);
    let open =
        open.find(|answer| answer.standing == Standing::CannotTell && !answer.because.is_empty());
    let because = open.map_or("", |answer| &answer.because);
    let reason = sentences([reason.as_str(), because]);
    let parts = answers.iter().map(|(title, answer)| {
        let ours = or_dash(answer.figure.as_ref().map(times));
        (format!("{title} {ours}"), answer.standing)
    });
    told(parts, reason)
}

/// The ladders that speak of the document: of one technique, on the first scene that has them.
fn documents<'l, 'a>(ladders: &'l [Ladder<'a>]) -> Vec<&'l Ladder<'a>> {
    let own = || ladders.iter().filter(|ladder| ladder.technique == VOLUMES);
    let scene = own().next().map(|ladder| ladder.scene);
    own().filter(|ladder| Some(ladder.scene) == scene).collect()
}

/// Ladders of these views.
fn of_views<'l, 'a>(
    ladders: &[&'l Ladder<'a>],
    views: &[String],
) -> impl Iterator<Item = &'l Ladder<'a>> {
    let is_of = |ladder: &&'l Ladder<'a>| views.iter().any(|view| view == ladder.view);
    ladders.iter().copied().filter(is_of)
}

/// Rungs of a step in these views.
fn steps<'l, 'a>(ladders: &[&'l Ladder<'a>], step: &str, views: &[String]) -> Vec<&'l Rung<'a>> {
    let own = of_views(ladders, views);
    own.filter_map(|ladder| ladder.step(step)).collect()
}

/// The same, those that say something of the claim.
fn telling_steps<'l, 'a>(ladders: &[&'l Ladder<'a>], of: &Gain) -> Vec<&'l Rung<'a>> {
    let vertices = |case: &Case| counter(case, VERTICES);
    let mut found = steps(ladders, &of.name, &of.views);
    found.retain(|rung| match of.only {
        Only::Any => true,
        Only::AllInSight => counter(rung.case, REGIONS_LEFT_OUT) == Some(0),
        Only::WhereItActs => rung.before.and_then(vertices) != vertices(rung.case),
    });
    found
}

/// What the run says of a claim.
fn judge(data: &Data<'_>, ladders: &[Ladder<'_>], claimed: &Claimed<Test>) -> Told {
    let own = documents(ladders);
    let in_views = |of: &claims::Step| steps(&own, &of.step, &of.views);
    match &claimed.test {
        Test::Step(of) => {
            let found = telling_steps(&own, of);
            let acts_nowhere = of.only == Only::WhereItActs && found.is_empty();
            if acts_nowhere && !steps(&own, &of.name, &of.views).is_empty() {
                return unanswered(
                    Standing::NotMeasured,
                    "in these views the eye is inside every volume, or so near that the step changes nothing",
                );
            }
            let answers = found.iter();
            let answers = answers.map(|rung| (rung.view(), answer(data, rung, of.expects)));
            of_answers(answers.collect(), reason(&found))
        }
        Test::Counter {
            step,
            metric,
            expects,
            views,
        } => of_counter(&steps(&own, step, views), metric, *expects),
        Test::LargestGain(of) => largest(data, &of.step, of_views(&own, &of.views)),
        Test::RightPicture(step) => {
            let found = in_views(step).into_iter();
            told(found.map(|rung| picture(rung.view(), rung.case)), "")
        }
        Test::SecondPass(step) => second_pass(&in_views(step)),
        Test::FillRate => of_fill_rate(&own),
        Test::Textured { ratio, expects } => of_ratios(
            data,
            &textured::compared(data, ratio),
            *expects,
            ratio.to_owned(),
        ),
        Test::FlatMesh => flat_mesh(data),
        Test::TexturedWorstAtHorizon => worst_at_horizon(data),
        Test::Sum {
            formula,
            terms,
            says,
        } => {
            let gives: u64 = terms
                .iter()
                .map(|factors| factors.iter().product::<u64>())
                .sum();
            Told {
                ours: format!("{} B", count(gives)),
                standing: Standing::holds_if(gives == *says),
                reason: formula.clone(),
            }
        }
        Test::GeometryShaderBytes(claim) => of_geometry_shader(data, *claim),
        Test::CentricNormals => centric_normals(data),
        Test::SurfaceIndependence => surface_independence(data),
        Test::Subdivision => of_ratios(
            data,
            &subdivision::coarsest_over_finest(data),
            SUBDIVISION,
            "time of the coarsest ÷ that of the finest".to_owned(),
        ),
        Test::CostsMore { rival, metrics } => costs_more(data, rival, metrics),
        Test::TimeOverVolumes { rival, expects } => of_ratios(
            data,
            &over_volumes(data, rival),
            *expects,
            format!("{} ÷ {VOLUMES}/doubled", rival.technique),
        ),
        Test::WrongPixels { rival } => wrong_pixels(data, rival),
        Test::No(why) => unanswered(Standing::CannotBeTested, why),
    }
}

/// What a rung's gain says of a claim, by the noise of its scene.
fn answer(data: &Data<'_>, rung: &Rung<'_>, claim: Claim) -> Answer {
    let Some(before) = rung.before else {
        return Answer::not_measured("no kept step comes before it");
    };
    if let Some(skipped) = rung.skipped {
        let why = format!("a step that is not right, {skipped}, comes before it");
        return Answer::not_measured(&why);
    }
    // What a step sets is the ladder's to say; a test holds this list against it.
    let set = PAPER.steps.get(rung.step).into_iter().flatten();
    let follows = set.map(|key| Follows {
        key,
        because: "the step sets it",
    });
    let follows: Vec<Follows<'_>> = follows.collect();
    // A step that changes what is handed over in a frame is compared by a clock that covers it.
    let needs = match follows.iter().any(|follows| follows.key == UPLOADS) {
        true => Scope::UPLOAD.and(Scope::DRAW),
        false => Scope::DRAW,
    };
    let comparison = Comparison {
        follows: &follows,
        metric: data.time_covering(needs),
        needs,
        ..one_change(STEP)
    };
    data.judge(comparison, [before, rung.case], claim)
}

/// What the step that moved most changed in counters.
fn reason(found: &[&Rung<'_>]) -> String {
    let moved = |rung: &Rung<'_>| rung.gain.map_or(0.0, |gain| gain.middle.ln().abs());
    let most = found.iter().max_by(|a, b| moved(a).total_cmp(&moved(b)));
    let of = |rung: &&Rung<'_>| {
        let changed = counters(rung.before?, rung.case);
        Some(format!("{}: {changed}", rung.view()))
    };
    most.and_then(of).unwrap_or_default()
}

fn of_counter(found: &[&Rung<'_>], metric: &str, claim: Claim) -> Told {
    let parts = found.iter().filter_map(|rung| {
        let ratio = rung.before?.value(metric)? / rung.case.value(metric)?;
        let standing = claim.standing_beyond(&Estimate::exact(ratio), 1.0);
        Some((
            format!("{} {} ×", rung.view(), significant(ratio)),
            standing,
        ))
    });
    told(parts, reason(found))
}

fn picture(view: &str, case: &Case) -> (String, Standing) {
    let standing = match case.outcome {
        Outcome::Ok => Standing::Holds,
        Outcome::Wrong => Standing::DoesNotHold,
        _ => Standing::NotMeasured,
    };
    let outside = counter(case, MISMATCHED_PX_OUTSIDE_BAND);
    let px = or_dash(outside.map(count));
    (format!("{view}: {px} px outside the band"), standing)
}

/// The document's own steps, up to what it was at work on.
fn own_steps<'l, 'a>(ladder: &'l Ladder<'a>) -> impl Iterator<Item = &'l Rung<'a>> {
    let last = ladder.rungs.iter().position(|rung| rung.step == "z-pass");
    let own = ladder.rungs.iter().take(last.map_or(0, |last| last + 1));
    own.filter(|rung| !rung.is_aside)
}

fn largest<'l, 'a: 'l>(
    data: &Data<'_>,
    step: &str,
    ladders: impl Iterator<Item = &'l Ladder<'a>>,
) -> Told {
    let mut found = Vec::new();
    let parts = ladders.filter_map(|ladder| {
        let rung = ladder.step(step)?;
        found.push(rung);
        let others = own_steps(ladder).filter(|other| other.step != step);
        let others = others.filter_map(|other| Some((other.step, other.gain?)));
        let (next, next_gain) = others.max_by(|a, b| a.1.middle.total_cmp(&b.1.middle))?;
        let standing = is_more(rung.gain.as_ref()?, &next_gain);
        let [gain, next_gain] = [rung.gain?, next_gain].map(|gain| data.ratio_text(&gain));
        Some((
            format!("{} {gain}, next {next} {next_gain}", ladder.view),
            standing,
        ))
    });
    let parts: Vec<(String, Standing)> = parts.collect();
    told(parts, reason(&found))
}

fn second_pass(found: &[&Rung<'_>]) -> Told {
    let parts = found.iter().filter_map(|rung| {
        let share = share(rung.case, COLOUR_GPU_MS, STENCIL_GPU_MS)?;
        let standing = Claim::AtLeast(0.5).standing(&share);
        Some((format!("{} {}", rung.view(), figure(&share)), standing))
    });
    let fragments = found.first().map(|rung| {
        let of = |metric| or_dash(counter(rung.case, metric).map(count));
        format!(
            "{}: {} fragments in the first pass, {} shaded in the second",
            rung.view(),
            of(STENCIL_FRAGMENTS),
            of(FRAGMENT_SHADER_INVOCATIONS)
        )
    });
    told(parts, fragments.unwrap_or_default())
}

fn of_fill_rate(ladders: &[&Ladder<'_>]) -> Told {
    let all = ladders
        .iter()
        .flat_map(|ladder| fill_rate::slopes(std::slice::from_ref(*ladder)));
    let parts = all.filter_map(|slopes| {
        let (vertices, fragments) = (slopes.vertices.as_ref()?, slopes.fragments.as_ref()?);
        Some((
            format!(
                "{}: fragments {}, vertices {}",
                slopes.view,
                figure(&fragments.exponent),
                figure(&vertices.exponent)
            ),
            slopes.standing(),
        ))
    });
    told(parts, "exponents of time, on every view after culling")
}

fn of_ratios(data: &Data<'_>, found: &[Timed<'_>], claim: Claim, reason: String) -> Told {
    let answers = found.iter();
    let answers = answers.map(|timed| (timed.title.as_str(), timed.answer(data, claim)));
    of_answers(answers.collect(), reason)
}

/// Barycentric coordinates have no more error than angles in f32 where a region is flat enough.
fn flat_mesh(data: &Data<'_>) -> Told {
    let found = super::textured::flat_mesh_errors(data).into_iter();
    let parts = found.map(|(view, [angles, barycentric])| {
        let standing = Standing::holds_if(barycentric <= angles);
        let [angles, barycentric] = [angles, barycentric].map(significant);
        (format!("{view} {angles} ÷ {barycentric}"), standing)
    });
    told(
        parts,
        "in a flat triangle a meridian is its chord: that error grows with the square of a region's size, and \
         the study precision measures it from 10 m up",
    )
}

fn worst_at_horizon(data: &Data<'_>) -> Told {
    let all = textured::compared(data, AS_IN_2007_OVER_PLAIN);
    let over = |timed: &&Timed<'_>| ratio(timed.cases[0], timed.cases[1], data.metric);
    let scenes = grouped(&all, |timed| timed.cases[0].condition(SCENE)).into_iter();
    let parts = scenes.filter_map(|(scene, own)| {
        let at_horizon = |timed: &&&Timed<'_>| timed.title.ends_with("horizon");
        let horizon = own.iter().copied().find(|timed| at_horizon(&timed));
        let horizon = horizon.as_ref().and_then(over)?;
        let others = own.iter().filter(|timed| !at_horizon(timed));
        let others = others.filter_map(over);
        let next = others.max_by(|a, b| a.middle.total_cmp(&b.middle))?;
        let most = times(&next);
        let text = format!("{scene}: {}, elsewhere at most {most}", times(&horizon));
        Some((text, is_more(&horizon, &next)))
    });
    told(parts, AS_IN_2007_OVER_PLAIN)
}

fn of_geometry_shader(data: &Data<'_>, claim: Claim) -> Told {
    let found = memory::geometry_shader_ratios(data);
    let has_documents = found
        .iter()
        .any(|(name, _)| memory::is_documents_layout(name));
    let parts = found.iter().filter(|_| has_documents).map(|(name, ratio)| {
        // The document's own layout decides; the others are named beside it.
        let standing = match memory::is_documents_layout(name) {
            true => claim.standing_beyond(&Estimate::exact(*ratio), 1.0),
            false => Standing::Holds,
        };
        (format!("{name} {} ×", significant(*ratio)), standing)
    });
    told(parts, memory::why_strips_are_smaller())
}

fn centric_normals(data: &Data<'_>) -> Told {
    let own = data
        .cases
        .iter()
        .filter(|case| case.condition(NORMALS) == "centric" && is_compared(case));
    let parts = own.map(|case| {
        let (pixels, standing) = picture(case.condition(VIEW), case);
        let shift = or_dash(case.value(WALL_SHIFT_M).map(significant));
        let scene = case.condition(SCENE);
        (
            format!("{scene} {pixels}, walls off by up to {shift} m"),
            standing,
        )
    });
    told(
        parts,
        "walls through the same vertices are |h| sin δ apart at height h, δ the angle between both normals: \
         on the Earth 0.34 % of the height at most",
    )
}

/// Each case of a rival with that of volumes of the same view, and what to call the two.
fn beside_volumes<'a>(data: &Data<'a>, rival: &Rival) -> Vec<(String, [&'a Case; 2])> {
    let cases = data.cases.iter().copied();
    let own = cases.filter(|case| {
        case.condition(TECHNIQUE) == rival.technique
            && case.condition_named(&rival.key) == rival.value
    });
    let is_volumes =
        |case: &&Case| case.condition(TECHNIQUE) == VOLUMES && case.condition(VARIANT) == "doubled";
    let pairs = own.filter_map(|own| {
        let volumes = data.beside(own).iter().copied().find(is_volumes)?;
        let title = [SCENE, VIEW].map(|key| own.condition(key)).join(" ");
        Some((title, [own, volumes]))
    });
    pairs.collect()
}

/// A technique and volumes.
const RIVALS: Comparison<'static> = Comparison {
    follows: &[Follows {
        key: LAYOUT.name(),
        because: "each technique calls the first of its own parameters so",
    }],
    one_sided: Some("a switch that only one of the two techniques has"),
    ..one_change(TECHNIQUE)
};

/// A rival and volumes, view by view.
fn over_volumes<'a>(data: &Data<'a>, rival: &Rival) -> Vec<Timed<'a>> {
    let found = beside_volumes(data, rival).into_iter();
    let timed = found.map(|(title, cases)| Timed {
        title,
        pairing: RIVALS,
        cases,
    });
    timed.collect()
}

fn costs_more(data: &Data<'_>, rival: &Rival, metrics: &[String]) -> Told {
    let mut parts = Vec::new();
    for timed in over_volumes(data, rival) {
        for name in metrics {
            let metric = declared(name);
            let answer = timed.answer_in(data, metric, metric.scope, Claim::Faster);
            let Some(figure) = answer.figure else {
                continue;
            };
            let over = significant(figure.middle);
            parts.push((format!("{}, {name} {over} ×", timed.title), answer.standing));
        }
    }
    told(parts, format!("{} ÷ {VOLUMES}/doubled", rival.technique))
}

fn wrong_pixels(data: &Data<'_>, rival: &Rival) -> Told {
    let found = beside_volumes(data, rival);
    let outside = |case: &Case| counter(case, MISMATCHED_PX_OUTSIDE_BAND);
    let parts = found.iter().filter_map(|(title, [own, _])| {
        let pixels = outside(own)?;
        Some((format!("{title} {} px", count(pixels)), pixels))
    });
    let parts: Vec<(String, u64)> = parts.collect();
    // The document says of the view from close by what no other view need show.
    let standing = Standing::holds_if(parts.iter().any(|(_, pixels)| *pixels > 0));
    let parts = parts.into_iter().map(|(text, _)| (text, standing));
    let volumes = found
        .iter()
        .filter_map(|(_, [_, volumes])| outside(volumes));
    let most = or_dash(volumes.max().map(count));
    told(
        parts,
        format!("outside the boundary band; of volumes at most {most}"),
    )
}

fn surface_independence(data: &Data<'_>) -> Told {
    let plain = |case: &&&Case| {
        !is_baseline(case)
            && !textured::is_textured(case)
            && !has_role(case, "sweep")
            && !is_approximate(case)
            // An experiment whose error is its answer says nothing of surfaces.
            && !case.planned.may_be_wrong
    };
    let tally = |what: &str, on_terrain: bool| {
        let own = data.cases.iter().filter(plain);
        let own = own.filter(|case| ON_TERRAIN.contains(&case.condition(SCENE)) == on_terrain);
        let ended = |outcome| own.clone().filter(|case| case.outcome == outcome).count();
        let (right, wrong) = (ended(Outcome::Ok), ended(Outcome::Wrong));
        let text = format!("{what}: {right} of {} pictures right", right + wrong);
        (right + wrong > 0).then(|| (text, Standing::holds_if(wrong == 0)))
    };
    let tallies = [tally("bare ellipsoid", false), tally("terrain", true)];
    let [Some(bare), Some(terrain)] = tallies else {
        return unanswered(
            Standing::NotMeasured,
            "the run has surfaces of one kind only",
        );
    };
    told(
        vec![bare, terrain],
        "fills read the surface's depth and nothing else of it",
    )
}

/// What the run says of each claim, in order.
fn all(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Vec<Told> {
    let command = full_command(&data.run.environment, STUDY);
    let claims = PAPER.claims.iter();
    let judged = claims.map(|claimed| {
        let mut told = judge(data, ladders, claimed);
        if told.standing == Standing::NotMeasured {
            told.reason = sentences([told.reason.as_str(), &format!("To measure it: {command}")]);
        }
        told
    });
    judged.collect()
}

/// The table, and how many claims ended how; nothing for a run that measured none of it.
pub(super) fn blocks(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Vec<Block> {
    let all = all(data, ladders);
    let is_measured = |(claimed, told): (&Claimed<Test>, &Told)| {
        !matches!(claimed.test, Test::Sum { .. })
            && !matches!(
                told.standing,
                Standing::NotMeasured | Standing::CannotBeTested
            )
    };
    if !PAPER.claims.iter().zip(&all).any(is_measured) {
        return Vec::new();
    }
    let bound = data.band_sentence(ladders.first().map(|ladder| ladder.scene));
    claims_blocks("The claims of 2007", &PAPER, &all, &bound)
}

/// `claims.csv`: the table as data.
pub(super) fn table(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Result<DerivedTable, ChapterError> {
    claims_table(&PAPER, &all(data, ladders))
}

/// What the document says of the steps of a ladder that it climbed.
pub(super) fn of_ladder(data: &Data<'_>, ladder: &Ladder<'_>) -> Vec<Finding> {
    if ladder.technique != VOLUMES {
        return Vec::new();
    }
    let finding = |claimed: &Claimed<Test>| {
        let Test::Step(of) = &claimed.test else {
            return None;
        };
        let found = telling_steps(&[ladder], of);
        let rung = found.first()?;
        let answer = answer(data, rung, of.expects);
        let said = match claimed.figure.as_str() {
            "" => String::new(),
            figure => format!(" ({figure})"),
        };
        let gain = answer.figure.as_ref().map(|gain| data.ratio_text(gain));
        let gain = gain.map(|gain| format!("{}: {gain}", rung.step));
        Some(Finding {
            claim: format!(
                "{SOURCE}, {}, {}{said}: “{}”",
                claimed.place,
                claimed.basis.name(),
                claimed.words
            ),
            standing: answer.standing,
            because: sentences([gain.unwrap_or_default(), answer.because]),
        })
    };
    PAPER.claims.iter().filter_map(finding).collect()
}

/// Keys of the cases that further processes may decide a claim by: what is undecided, or all steps while
/// noise is larger than [`MAX_BAND`].
pub(super) fn undecided(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Vec<String> {
    let own = documents(ladders);
    let Some(scene) = own.first().map(|ladder| ladder.scene) else {
        return Vec::new();
    };
    let noise = data.ladder_noise(scene);
    let is_noisy = noise.is_some_and(|noise| noise.reach_factor() > MAX_BAND);
    let mut keys = textured::undecided(data);
    for claimed in &PAPER.claims {
        let (timed, claim) = match &claimed.test {
            Test::Step(of) => {
                for rung in telling_steps(&own, of) {
                    let is_open = answer(data, rung, of.expects).standing == Standing::CannotTell;
                    if is_open || (is_noisy && rung.gain.is_some()) {
                        let cases = rung.before.into_iter().chain([rung.case]);
                        keys.extend(cases.map(|case| case.id().key()));
                    }
                }
                continue;
            }
            Test::Textured { ratio, expects } => (textured::compared(data, ratio), *expects),
            Test::Subdivision => (subdivision::coarsest_over_finest(data), SUBDIVISION),
            Test::TimeOverVolumes { rival, expects } => (over_volumes(data, rival), *expects),
            _ => continue,
        };
        for timed in &timed {
            if timed.answer(data, claim).standing == Standing::CannotTell {
                keys.extend(timed.cases.map(|case| case.id().key()));
            }
        }
    }
    keys.sort_unstable();
    keys.dedup();
    let twins = data.ladder_twins(&keys);
    keys.extend(twins);
    keys
}
