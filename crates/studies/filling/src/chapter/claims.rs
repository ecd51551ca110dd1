// SPDX-License-Identifier: MIT OR Apache-2.0
//! The table of every claim of Cozzi (2007): what it says, what was measured here, and whether they agree.
//!
//! Steps are those of the vertex shader's ladder, which is the version that the document timed. What is
//! no difference is taken from the run: how far intervals of identical work reach in the ladder's scene. A claim whose rows are not in the run has an empty cell.

use super::data::{
    Data, Timed, counter, distinct, has_role, is_approximate, is_baseline, is_compared,
};
use super::rungs::{Ladder, Rung, SOURCE, counters};
use super::{fill_rate, memory, subdivision, textured};
use crate::claims::{Basis, CLAIMS, Claimed, EVERY_VIEW, Rival, Test};
use terrafill_plot::number::{count, significant, times};
use terrafill_results::{
    Block, Case, Cell, CellClass, ChapterError, Claim, DerivedTable, Estimate, Finding, Heading,
    Outcome, Row, Standing, Table, TableLayout, ratio, share,
};

/// The technique whose ladder the document climbed.
const TECHNIQUE: &str = "vertex";

/// Scenes whose surface is terrain, which is made by another crate than the bare ellipsoid.
const ON_TERRAIN: [&str; 1] = ["hills"];

/// Half of the document's smallest gain, 5.4 %: a wider band of no difference would hide it.
const MAX_BAND: f64 = 1.027;

/// What the document expects of the coarsest mesh's time over the finest's.
const SUBDIVISION: Claim = Claim::NotFaster;

/// What came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Verdict {
    Agrees,
    Disagrees,
    Undecided,
    NotMeasured,
    CannotBeTested,
}

impl Verdict {
    const ALL: [Self; 5] = [
        Self::Agrees,
        Self::Disagrees,
        Self::Undecided,
        Self::NotMeasured,
        Self::CannotBeTested,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Disagrees => "disagrees",
            Self::Undecided => "undecided",
            Self::NotMeasured => "not measured",
            Self::CannotBeTested => "cannot be tested",
        }
    }

    /// Of several standings: one that disagrees is enough, and one that cannot tell leaves it open.
    fn of(standings: &[Standing]) -> Self {
        let has = |wanted| standings.contains(&wanted);
        if standings.is_empty()
            || standings
                .iter()
                .all(|found| *found == Standing::NotMeasured)
        {
            Self::NotMeasured
        } else if has(Standing::DoesNotHold) {
            Self::Disagrees
        } else if has(Standing::CannotTell) || has(Standing::NotMeasured) {
            Self::Undecided
        } else {
            Self::Agrees
        }
    }
}

/// What the run says of a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Judged {
    /// With intervals; empty where nothing was measured.
    ours: String,
    pub(super) verdict: Verdict,
    /// From counters where there are any, else why there is no verdict.
    reason: String,
}

impl Judged {
    fn new(parts: Vec<(String, Standing)>, reason: String) -> Self {
        let standings: Vec<Standing> = parts.iter().map(|(_, standing)| *standing).collect();
        let ours: Vec<String> = parts.into_iter().map(|(text, _)| text).collect();
        let verdict = Verdict::of(&standings);
        Self {
            ours: ours.join("; "),
            verdict,
            reason: match verdict {
                Verdict::NotMeasured => "its rows are not in this run".to_owned(),
                _ => reason,
            },
        }
    }

    fn not_measured(why: &str) -> Self {
        Self {
            ours: String::new(),
            verdict: Verdict::NotMeasured,
            reason: why.to_owned(),
        }
    }
}

/// The ladders that speak of the document: of one technique, on the first scene that has them.
pub(super) fn documents<'l, 'a>(ladders: &'l [Ladder<'a>]) -> Vec<&'l Ladder<'a>> {
    let own = || {
        ladders
            .iter()
            .filter(|ladder| ladder.technique == TECHNIQUE)
    };
    let scene = own().next().map(|ladder| ladder.scene);
    own().filter(|ladder| Some(ladder.scene) == scene).collect()
}

/// Rungs of a step, each with its ladder.
fn steps<'l, 'a>(
    ladders: &[&'l Ladder<'a>],
    step: &str,
    views: &[&str],
) -> Vec<(&'l Ladder<'a>, &'l Rung<'a>)> {
    let of_views = ladders.iter().filter(|ladder| views.contains(&ladder.view));
    let found = of_views.filter_map(|ladder| {
        let rung = ladder.rungs.iter().find(|rung| rung.step == step)?;
        Some((*ladder, rung))
    });
    found.collect()
}

/// The same where the frustum holds every region.
fn steps_with_all_in_sight<'l, 'a>(
    ladders: &[&'l Ladder<'a>],
    step: &str,
) -> Vec<(&'l Ladder<'a>, &'l Rung<'a>)> {
    let mut found = steps(ladders, step, EVERY_VIEW);
    found.retain(|(_, rung)| counter(rung.case, "regions_left_out") == Some(0));
    found
}

/// The same where the step changes how many vertices are drawn.
fn steps_that_act<'l, 'a>(
    ladders: &[&'l Ladder<'a>],
    step: &str,
    views: &[&str],
) -> Vec<(&'l Ladder<'a>, &'l Rung<'a>)> {
    let vertices = |case: &Case| counter(case, "vertices");
    let mut found = steps(ladders, step, views);
    found.retain(|(_, rung)| {
        let before = rung.before.and_then(vertices);
        before != vertices(rung.case)
    });
    found
}

/// What the run says of `claimed`.
pub(super) fn judge(data: &Data<'_>, ladders: &[Ladder<'_>], claimed: &Claimed) -> Judged {
    let own = documents(ladders);
    match claimed.test {
        Test::Step(step, claim, views) => of_step(data, &steps(&own, step, views), claim),
        Test::StepWithAllInSight(step, claim) => {
            of_step(data, &steps_with_all_in_sight(&own, step), claim)
        }
        Test::StepWhereItActs(step, claim, views) => {
            let acting = steps_that_act(&own, step, views);
            match acting.is_empty() && !steps(&own, step, views).is_empty() {
                true => Judged::not_measured(
                    "in these views the eye is inside every volume, or so near that the step changes nothing",
                ),
                false => of_step(data, &acting, claim),
            }
        }
        Test::Counter(step, metric, claim, views) => {
            of_counter(&steps(&own, step, views), metric, claim)
        }
        Test::LargestGain(step, views) => largest(data, &own, step, views),
        Test::RightPicture(step, views) => {
            let found = steps(&own, step, views);
            let parts = found
                .iter()
                .map(|(ladder, rung)| picture(ladder.view, rung.case));
            Judged::new(parts.collect(), String::new())
        }
        Test::SecondPass(views) => second_pass(&steps(&own, "bottom-cap", views)),
        Test::FillRate => of_fill_rate(&own),
        Test::Textured(index, claim) => of_ratios(
            data,
            &textured::compared(data, index),
            claim,
            textured::heading(index).to_owned(),
        ),
        Test::FlatMesh => flat_mesh(data),
        Test::TexturedWorstAtHorizon => worst_at_horizon(data),
        Test::Sum {
            formula,
            gives,
            says,
        } => Judged {
            ours: format!("{} B", count(gives)),
            verdict: match gives == says {
                true => Verdict::Agrees,
                false => Verdict::Disagrees,
            },
            reason: formula.to_owned(),
        },
        Test::GeometryShaderBytes(claim) => of_geometry_shader(data, claim),
        Test::CentricNormals => centric_normals(data),
        Test::SurfaceIndependence => surface_independence(data),
        Test::Subdivision => of_ratios(
            data,
            &subdivision::coarsest_over_finest(data),
            SUBDIVISION,
            "time of the coarsest ÷ that of the finest".to_owned(),
        ),
        Test::CostsMore(rival, metrics) => costs_more(data, rival, metrics),
        Test::TimeOverVolumes(rival, claim) => of_ratios(
            data,
            &over_volumes(data, rival),
            claim,
            format!("{} ÷ {TECHNIQUE}/doubled", rival.0),
        ),
        Test::WrongPixels(rival) => wrong_pixels(data, rival),
        Test::No(why) => Judged {
            ours: String::new(),
            verdict: Verdict::CannotBeTested,
            reason: why.to_owned(),
        },
    }
}

fn of_step(data: &Data<'_>, found: &[(&Ladder<'_>, &Rung<'_>)], claim: Claim) -> Judged {
    let parts = found.iter().map(|(ladder, rung)| {
        let standing = standing(data, ladder, rung, claim);
        let ours = rung.gain.as_ref().map_or("–".to_owned(), times);
        (format!("{} {ours}", ladder.view), standing)
    });
    Judged::new(parts.collect(), reason(found))
}

/// What a rung's gain says of a claim, by the noise of its scene.
pub(super) fn standing(
    data: &Data<'_>,
    ladder: &Ladder<'_>,
    rung: &Rung<'_>,
    claim: Claim,
) -> Standing {
    let band = data.band(ladder.scene);
    let gain = rung.gain.as_ref();
    gain.map_or(Standing::NotMeasured, |gain| {
        claim.standing_beyond(gain, band)
    })
}

/// What the step that moved most changed in counters.
fn reason(found: &[(&Ladder<'_>, &Rung<'_>)]) -> String {
    let moved = |rung: &Rung<'_>| rung.gain.map_or(0.0, |gain| gain.middle.ln().abs());
    let most = found
        .iter()
        .max_by(|a, b| moved(a.1).total_cmp(&moved(b.1)));
    let of = |(ladder, rung): &(&Ladder<'_>, &Rung<'_>)| {
        Some(format!(
            "{}: {}",
            ladder.view,
            counters(rung.before?, rung.case)
        ))
    };
    most.and_then(of).unwrap_or_default()
}

fn exactly(value: f64) -> Estimate {
    Estimate {
        middle: value,
        interval: Some([value; 2]),
        processes: 0,
    }
}

fn of_counter(found: &[(&Ladder<'_>, &Rung<'_>)], metric: &str, claim: Claim) -> Judged {
    let parts = found.iter().filter_map(|(ladder, rung)| {
        let ratio = rung.before?.value(metric)? / rung.case.value(metric)?;
        let standing = claim.standing_beyond(&exactly(ratio), 1.0);
        Some((
            format!("{} {} ×", ladder.view, significant(ratio)),
            standing,
        ))
    });
    Judged::new(parts.collect(), reason(found))
}

fn picture(view: &str, case: &Case) -> (String, Standing) {
    let standing = match case.outcome {
        Outcome::Ok => Standing::Holds,
        Outcome::Wrong => Standing::DoesNotHold,
        _ => Standing::NotMeasured,
    };
    let outside = counter(case, "mismatched_px_outside_band");
    let px = outside.map_or("–".to_owned(), count);
    (format!("{view}: {px} px outside the band"), standing)
}

/// The document's own steps, up to what it was at work on.
fn own_steps<'l, 'a>(ladder: &'l Ladder<'a>) -> impl Iterator<Item = &'l Rung<'a>> {
    let last = ladder.rungs.iter().position(|rung| rung.step == "z-pass");
    let own = ladder.rungs.iter().take(last.map_or(0, |last| last + 1));
    own.filter(|rung| !rung.is_aside)
}

fn largest(data: &Data<'_>, ladders: &[&Ladder<'_>], step: &str, views: &[&str]) -> Judged {
    let found = steps(ladders, step, views);
    let parts = found.iter().filter_map(|(ladder, rung)| {
        let gain = rung.gain.as_ref()?;
        let others = own_steps(ladder).filter(|other| other.step != step);
        let others = others.filter_map(|other| Some((other.step, other.gain?)));
        let (next, next_gain) = others.max_by(|a, b| a.1.middle.total_cmp(&b.1.middle))?;
        let standing = match (gain.interval, next_gain.interval) {
            (Some([low, _]), Some([_, high])) if low > high => Standing::Holds,
            (Some([_, high]), Some([low, _])) if high < low => Standing::DoesNotHold,
            _ => Standing::CannotTell,
        };
        let (gain, next_gain) = (data.ratio_text(gain), data.ratio_text(&next_gain));
        Some((
            format!("{} {gain}, next {next} {next_gain}", ladder.view),
            standing,
        ))
    });
    Judged::new(parts.collect(), reason(&found))
}

fn second_pass(found: &[(&Ladder<'_>, &Rung<'_>)]) -> Judged {
    let parts = found.iter().filter_map(|(ladder, rung)| {
        let share = share(rung.case, "colour_gpu_ms", "stencil_gpu_ms")?;
        let standing = Claim::AtLeast(0.5).standing(&share);
        let text = terrafill_plot::number::figure(&share);
        Some((format!("{} {text}", ladder.view), standing))
    });
    let fragments = found.first().map(|(ladder, rung)| {
        let of = |metric| counter(rung.case, metric).map_or("–".to_owned(), count);
        format!(
            "{}: {} fragments in the first pass, {} shaded in the second",
            ladder.view,
            of("stencil_fragments"),
            of("fragment_shader_invocations")
        )
    });
    Judged::new(parts.collect(), fragments.unwrap_or_default())
}

fn of_fill_rate(ladders: &[&Ladder<'_>]) -> Judged {
    let all = ladders
        .iter()
        .flat_map(|ladder| fill_rate::slopes(std::slice::from_ref(*ladder)));
    let parts = all.filter_map(|slopes| {
        let (vertices, fragments) = (slopes.vertices.as_ref()?, slopes.fragments.as_ref()?);
        let figure = terrafill_plot::number::figure;
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
    Judged::new(
        parts.collect(),
        "exponents of time, on every view after culling".to_owned(),
    )
}

fn of_ratios(data: &Data<'_>, found: &[Timed<'_>], claim: Claim, reason: String) -> Judged {
    let parts = found.iter().map(|timed| {
        let text = format!("{} {}", timed.title, times(&timed.ratio));
        (text, timed.standing(data, claim))
    });
    Judged::new(parts.collect(), reason)
}

/// Barycentric coordinates have no more error than angles in f32 where a region is flat enough.
fn flat_mesh(data: &Data<'_>) -> Judged {
    let found = super::textured::flat_mesh_errors(data).into_iter();
    let parts = found.map(|(view, [angles, barycentric])| {
        let standing = match barycentric <= angles {
            true => Standing::Holds,
            false => Standing::DoesNotHold,
        };
        let [angles, barycentric] = [angles, barycentric].map(significant);
        (format!("{view} {angles} ÷ {barycentric}"), standing)
    });
    Judged::new(
        parts.collect(),
        "in a flat triangle a meridian is its chord: that error grows with the square of a region's size, and \
         the study precision measures it from 10 m up"
            .to_owned(),
    )
}

fn worst_at_horizon(data: &Data<'_>) -> Judged {
    let all = textured::compared(data, 0);
    let scenes = distinct(all.iter().map(|timed| timed.scene));
    let parts = scenes.into_iter().filter_map(|scene| {
        let own = || all.iter().filter(|timed| timed.scene == scene);
        let at_horizon = |timed: &&Timed<'_>| timed.title.ends_with("horizon");
        let horizon = &own().find(at_horizon)?.ratio;
        let others = own().filter(|timed| !at_horizon(timed));
        let others = others.map(|timed| &timed.ratio);
        let next = others.max_by(|a, b| a.middle.total_cmp(&b.middle))?;
        let standing = match (horizon.interval, next.interval) {
            (Some([low, _]), Some([_, high])) if low > high => Standing::Holds,
            (Some([_, high]), Some([low, _])) if high < low => Standing::DoesNotHold,
            _ => Standing::CannotTell,
        };
        let text = format!(
            "{scene}: {}, elsewhere at most {}",
            times(horizon),
            times(next)
        );
        Some((text, standing))
    });
    Judged::new(parts.collect(), textured::heading(0).to_owned())
}

fn of_geometry_shader(data: &Data<'_>, claim: Claim) -> Judged {
    let found = memory::geometry_shader_ratios(data);
    let parts = found.iter().map(|(name, ratio)| {
        let standing = claim.standing_beyond(&exactly(*ratio), 1.0);
        // The document's own layout decides; the others are named beside it.
        let standing = match memory::is_documents_layout(name) {
            true => standing,
            false => Standing::Holds,
        };
        (format!("{name} {} ×", significant(*ratio)), standing)
    });
    let parts: Vec<_> = match found
        .iter()
        .any(|(name, _)| memory::is_documents_layout(name))
    {
        true => parts.collect(),
        false => Vec::new(),
    };
    Judged::new(parts, memory::why_strips_are_smaller())
}

fn centric_normals(data: &Data<'_>) -> Judged {
    let own = data
        .cases
        .iter()
        .filter(|case| case.condition("normals") == "centric" && is_compared(case));
    let parts = own.map(|case| {
        let (pixels, standing) = picture(case.condition("view"), case);
        let shift = case
            .value("wall_shift_m")
            .map_or("–".to_owned(), significant);
        let scene = case.condition("scene");
        (
            format!("{scene} {pixels}, walls off by up to {shift} m"),
            standing,
        )
    });
    Judged::new(
        parts.collect(),
        "walls through the same vertices are |h| sin δ apart at height h, δ the angle between both normals: \
         on the Earth 0.34 % of the height at most"
            .to_owned(),
    )
}

/// Each case of a rival with that of volumes of the same view, and what to call the two.
fn beside_volumes<'a>(
    data: &Data<'a>,
    (technique, (knob, value)): Rival,
) -> Vec<(String, &'a Case, &'a Case)> {
    let cases = || data.cases.iter().copied();
    let is_own =
        |case: &&Case| case.condition("technique") == technique && case.condition(knob) == value;
    let pairs = cases().filter(is_own).filter_map(|own| {
        let of = ["scene", "view"].map(|key| own.condition(key));
        let is_volumes = |case: &&Case| {
            ["scene", "view"].map(|key| case.condition(key)) == of
                && case.condition("technique") == TECHNIQUE
                && case.condition("variant") == "doubled"
        };
        Some((of.join(" "), own, cases().find(is_volumes)?))
    });
    pairs.collect()
}

/// Time of a rival over that of volumes.
fn over_volumes<'a>(data: &Data<'a>, rival: Rival) -> Vec<Timed<'a>> {
    let found = beside_volumes(data, rival).into_iter();
    let timed = found.filter_map(|(title, own, volumes)| {
        Some(Timed {
            title,
            scene: own.condition("scene"),
            cases: [own, volumes],
            ratio: ratio(own, volumes, data.metric)?,
        })
    });
    timed.collect()
}

fn costs_more(data: &Data<'_>, rival: Rival, metrics: &[&str]) -> Judged {
    let found = beside_volumes(data, rival);
    let parts = found.iter().flat_map(|(title, own, volumes)| {
        metrics.iter().filter_map(move |metric| {
            let (over, standing) = match metric.ends_with("_ms") {
                true => {
                    let over = ratio(own, volumes, metric)?;
                    (
                        over.middle,
                        Standing::of_times(&over, data.noise_of(metric)).0,
                    )
                }
                false => {
                    let over = own.value(metric)? / volumes.value(metric)?;
                    (over, Standing::holds_if(over > 1.0))
                }
            };
            let text = format!("{title}, {metric} {} ×", significant(over));
            Some((text, standing))
        })
    });
    Judged::new(
        parts.collect(),
        format!("{} ÷ {TECHNIQUE}/doubled", rival.0),
    )
}

fn wrong_pixels(data: &Data<'_>, rival: Rival) -> Judged {
    let found = beside_volumes(data, rival);
    let outside = |case: &Case| counter(case, "mismatched_px_outside_band");
    let parts = found.iter().filter_map(|(title, own, _)| {
        let pixels = outside(own)?;
        Some((format!("{title} {} px", count(pixels)), pixels))
    });
    let parts: Vec<(String, u64)> = parts.collect();
    // The document says of the view from close by what no other view need show.
    let standing = Standing::holds_if(parts.iter().any(|(_, pixels)| *pixels > 0));
    let parts = parts.into_iter().map(|(text, _)| (text, standing));
    let volumes = found.iter().filter_map(|(_, _, volumes)| outside(volumes));
    let most = volumes.max().map_or("–".to_owned(), count);
    Judged::new(
        parts.collect(),
        format!("outside the boundary band; of volumes at most {most}"),
    )
}

fn surface_independence(data: &Data<'_>) -> Judged {
    let plain = |case: &&&Case| {
        !is_baseline(case)
            && !textured::is_textured(case)
            && !has_role(case, "sweep")
            && !is_approximate(case)
            // An experiment whose error is its answer says nothing of surfaces.
            && !case.planned.may_be_wrong
    };
    let cases = || data.cases.iter().filter(plain);
    let tally = |on_terrain: bool| {
        let own = || {
            cases().filter(move |case| ON_TERRAIN.contains(&case.condition("scene")) == on_terrain)
        };
        let ended = |outcome| own().filter(|case| case.outcome == outcome).count();
        (ended(Outcome::Ok), ended(Outcome::Wrong))
    };
    let [(ok_bare, wrong_bare), (ok_terrain, wrong_terrain)] = [tally(false), tally(true)];
    if ok_bare + wrong_bare == 0 || ok_terrain + wrong_terrain == 0 {
        return Judged::not_measured("the run has surfaces of one kind only");
    }
    let text = |what: &str, ok: usize, wrong: usize| {
        let standing = Standing::holds_if(wrong == 0);
        (
            format!("{what}: {ok} of {} pictures right", ok + wrong),
            standing,
        )
    };
    Judged::new(
        vec![
            text("bare ellipsoid", ok_bare, wrong_bare),
            text("terrain", ok_terrain, wrong_terrain),
        ],
        "fills read the surface's depth and nothing else of it".to_owned(),
    )
}

/// Every claim with what the run says of it.
fn all(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Vec<(&'static Claimed, Judged)> {
    let judged = |claimed: &'static Claimed| (claimed, judge(data, ladders, claimed));
    CLAIMS.iter().map(judged).collect()
}

/// The table, and how many claims ended how; nothing for a run that measured none of it.
pub(super) fn blocks(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Vec<Block> {
    let all = all(data, ladders);
    let is_measured = |(claimed, judged): &(&Claimed, Judged)| {
        !matches!(claimed.test, Test::Sum { .. })
            && !matches!(
                judged.verdict,
                Verdict::NotMeasured | Verdict::CannotBeTested
            )
    };
    if !all.iter().any(is_measured) {
        return Vec::new();
    }
    let rows = all.iter().map(|(claimed, judged)| row(claimed, judged));
    vec![
        Block::section("The claims of 2007"),
        Block::Text(format!(
            "Every claim of {SOURCE}, quoted to the letter, in the document's order. Gain = time without ÷ \
             time with, with its 95 % interval; above 1 is faster. The document timed a vertex shader \
             on a GeForce 6800 Ultra; its tables are pictures and not handed down, so many of its \
             figures are missing. {} {}",
            data.band_sentence(ladders.first().map(|ladder| ladder.scene)),
            tally(&all)
        )),
        Block::Table(Table {
            headings: [
                "claim",
                "basis",
                "its figure",
                "experiment here",
                "our figure",
                "verdict",
                "reason",
            ]
            .map(Heading::plain)
            .into(),
            rows: rows.collect(),
            layout: TableLayout::Cards,
            ..Table::default()
        }),
    ]
}

fn row(claimed: &Claimed, judged: &Judged) -> Row {
    let or_absent = |text: &str, why: &str| match text {
        "" => Cell::absent(why),
        text => Cell::name(text),
    };
    let no_figure = "the document's text has none";
    let cannot = match judged.verdict {
        Verdict::CannotBeTested | Verdict::NotMeasured => judged.reason.as_str(),
        _ => "none",
    };
    Row::new(vec![
        Cell {
            detail: claimed.place.to_owned(),
            ..Cell::name(format!("“{}”", claimed.words))
        },
        Cell::plain(claimed.basis.name()),
        or_absent(claimed.figure, no_figure),
        or_absent(claimed.experiment, cannot),
        or_absent(&judged.ours, cannot),
        Cell {
            class: match judged.verdict {
                Verdict::Agrees => CellClass::Good,
                Verdict::Disagrees => CellClass::Bad,
                _ => CellClass::Plain,
            },
            ..Cell::plain(judged.verdict.name())
        },
        Cell::name(&judged.reason),
    ])
}

fn tally(all: &[(&'static Claimed, Judged)]) -> String {
    let bases = Basis::ALL.map(|basis| {
        let of_basis = all.iter().filter(|(claimed, _)| claimed.basis == basis);
        format!("{} {}", of_basis.count(), basis.name())
    });
    let verdicts = Verdict::ALL.map(|verdict| {
        let ended = all.iter().filter(|(_, judged)| judged.verdict == verdict);
        format!("{}: {}", verdict.name(), ended.count())
    });
    format!(
        "{} claims: {}. Verdicts: {}.",
        all.len(),
        bases.join(", "),
        verdicts.join(", ")
    )
}

/// What the document says of the steps of a ladder that it climbed.
pub(super) fn of_ladder(data: &Data<'_>, ladder: &Ladder<'_>) -> Vec<Finding> {
    if ladder.technique != TECHNIQUE {
        return Vec::new();
    }
    let findings = CLAIMS.iter().filter_map(|claimed| {
        let (found, claim) = match claimed.test {
            Test::Step(step, claim, views) => (steps(&[ladder], step, views), claim),
            Test::StepWhereItActs(step, claim, views) => {
                (steps_that_act(&[ladder], step, views), claim)
            }
            _ => return None,
        };
        let (_, rung) = found.first()?;
        let gain = rung.gain.as_ref().map(|gain| data.ratio_text(gain));
        let figure = match claimed.figure {
            "" => String::new(),
            figure => format!(" ({figure})"),
        };
        Some(Finding {
            claim: format!(
                "{SOURCE}, {}, {}{figure}: “{}”",
                claimed.place,
                claimed.basis.name(),
                claimed.words
            ),
            standing: standing(data, ladder, rung, claim),
            because: gain.map_or(String::new(), |gain| format!("{}: {gain}", rung.step)),
        })
    });
    findings.collect()
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
    for claimed in &CLAIMS {
        let (rungs, timed, claim) = match claimed.test {
            Test::Step(step, claim, views) => (steps(&own, step, views), Vec::new(), claim),
            Test::StepWithAllInSight(step, claim) => {
                (steps_with_all_in_sight(&own, step), Vec::new(), claim)
            }
            Test::StepWhereItActs(step, claim, views) => {
                (steps_that_act(&own, step, views), Vec::new(), claim)
            }
            Test::Textured(index, claim) => (Vec::new(), textured::compared(data, index), claim),
            Test::Subdivision => {
                let timed = subdivision::coarsest_over_finest(data);
                (Vec::new(), timed, SUBDIVISION)
            }
            Test::TimeOverVolumes(rival, claim) => (Vec::new(), over_volumes(data, rival), claim),
            _ => continue,
        };
        let rungs = rungs.into_iter().filter(|(ladder, rung)| {
            standing(data, ladder, rung, claim) == Standing::CannotTell
                || (is_noisy && rung.gain.is_some())
        });
        let of_rungs = rungs.flat_map(|(_, rung)| rung.before.into_iter().chain([rung.case]));
        let timed = timed.iter();
        let open = timed.filter(|timed| timed.standing(data, claim) == Standing::CannotTell);
        let cases = of_rungs.chain(open.flat_map(|timed| timed.cases));
        keys.extend(cases.map(|case| case.id().key()));
    }
    keys.sort_unstable();
    keys.dedup();
    let twins = data.ladder_twins(&keys);
    keys.extend(twins);
    keys
}

/// `claims.csv`: the table as data.
pub(super) fn table(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Result<DerivedTable, ChapterError> {
    let header = [
        "words",
        "place",
        "basis",
        "figure",
        "experiment",
        "ours",
        "verdict",
        "reason",
    ];
    let rows = all(data, ladders).into_iter().map(|(claimed, judged)| {
        vec![
            claimed.words.to_owned(),
            claimed.place.to_owned(),
            claimed.basis.name().to_owned(),
            claimed.figure.to_owned(),
            claimed.experiment.to_owned(),
            judged.ours,
            judged.verdict.name().to_owned(),
            judged.reason,
        ]
    });
    DerivedTable::new("claims.csv", &header, rows)
}
