// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fill rate or vertices: how time grows with each while the other stays.
//!
//! Within a view, two fills of a ladder that differ in one step give an exponent: ln of their times'
//! ratio over ln of their work's ratio, 0 where that work costs nothing and 1 where it costs everything.
//! For vertices the fragments must be equal, for fragments the vertices. Only steps after culling count
//! that change nothing else, and of these the one that changes the work most.

use super::data::{Data, is_more};
use super::rungs::{Ladder, Rung};
use super::table::{figures, part, row};
use crate::keys::{FRAGMENT_SHADER_INVOCATIONS, STENCIL_FRAGMENTS, VERTICES};
use terrafill_plot::number::{figure, significant};
use terrafill_results::{Block, Cell, Estimate, Finding, Standing};

/// Steps that change how many vertices or fragments there are and nothing that costs anything beside.
const STEPS: [&str; 9] = [
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

/// Work that differs by less than this factor is equal.
const SAME_WORK: f64 = 1.05;

/// How many times more work must differ to show what it costs.
const MIN_LEVER: f64 = 1.2;

/// An exponent, and where it comes from.
pub(super) struct Slope<'a> {
    step: &'a str,
    /// How many times more work the costlier of the two fills does.
    lever: f64,
    pub(super) exponent: Estimate,
}

/// What a view says.
pub(super) struct Slopes<'a> {
    pub(super) view: &'a str,
    title: &'a str,
    pub(super) vertices: Option<Slope<'a>>,
    pub(super) fragments: Option<Slope<'a>>,
}

impl Slopes<'_> {
    /// Whether time grows faster with fragments than with vertices.
    pub(super) fn standing(&self) -> Standing {
        match (&self.vertices, &self.fragments) {
            (Some(vertices), Some(fragments)) => is_more(&fragments.exponent, &vertices.exponent),
            _ => Standing::NotMeasured,
        }
    }
}

/// The slopes of every view of these ladders.
pub(super) fn slopes<'a>(ladders: &'a [Ladder<'_>]) -> Vec<Slopes<'a>> {
    let of = |ladder: &'a Ladder<'_>| Slopes {
        view: ladder.view,
        title: &ladder.title,
        vertices: slope(&ladder.rungs, vertices, fragments),
        fragments: slope(&ladder.rungs, fragments, vertices),
    };
    ladders.iter().map(of).collect()
}

fn vertices(case: &terrafill_results::Case) -> Option<f64> {
    case.value(VERTICES)
}

/// Of both passes.
fn fragments(case: &terrafill_results::Case) -> Option<f64> {
    Some(case.value(STENCIL_FRAGMENTS)? + case.value(FRAGMENT_SHADER_INVOCATIONS)?)
}

type Work = fn(&terrafill_results::Case) -> Option<f64>;

fn slope<'a>(rungs: &'a [Rung<'_>], varied: Work, kept: Work) -> Option<Slope<'a>> {
    let from = rungs.iter().position(|rung| rung.step == "culling")?;
    let of = |rung: &'a Rung<'_>| {
        let (before, gain) = (rung.before?, rung.gain?);
        let ratio = |work: Work| {
            let ratio = work(before)? / work(rung.case)?;
            (ratio.is_finite() && ratio > 0.0).then_some(ratio)
        };
        let is_same = ratio(kept)?.ln().abs() <= SAME_WORK.ln();
        let lever = ratio(varied)?.ln();
        (is_same && lever.abs() >= MIN_LEVER.ln()).then(|| Slope {
            step: rung.step,
            lever: lever.abs().exp(),
            exponent: exponent(&gain, lever),
        })
    };
    let usable = rungs[from + 1..]
        .iter()
        .filter(|rung| STEPS.contains(&rung.step));
    usable
        .filter_map(of)
        .max_by(|a, b| a.lever.total_cmp(&b.lever))
}

/// - `gain`: ratio of times
/// - `lever`: ln of the ratio of work
fn exponent(gain: &Estimate, lever: f64) -> Estimate {
    let of = |ratio: f64| ratio.ln() / lever;
    Estimate {
        middle: of(gain.middle),
        interval: gain.interval.map(|[low, high]| {
            let (a, b) = (of(low), of(high));
            [a.min(b), a.max(b)]
        }),
        processes: gain.processes,
    }
}

/// A table of all views, and what it says of each.
pub(super) fn blocks(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Vec<Block> {
    let slopes = slopes(ladders);
    let has_any = |slopes: &Slopes<'_>| slopes.vertices.is_some() || slopes.fragments.is_some();
    if !slopes.iter().any(has_any) {
        return Vec::new();
    }
    let of = |slope: &Option<Slope<'_>>, same: &str| match slope {
        Some(slope) => Cell {
            detail: format!("{}: {} × the work", slope.step, significant(slope.lever)),
            ..Cell::plain(figure(&slope.exponent))
        },
        None => Cell::absent(format!(
            "no step after culling changes it by a fifth or more and leaves {same} alone"
        )),
    };
    let rows = slopes.iter().map(|slopes| {
        let cells = [
            of(&slopes.vertices, "fragments"),
            of(&slopes.fragments, "vertices"),
        ];
        row(Cell::name(slopes.title), cells)
    });
    let headings = [
        ("scene, view: technique", ""),
        (
            "over vertices",
            "both fills have the same fragments, within 5 %",
        ),
        (
            "over fragments",
            "both fills have the same vertices, within 5 %",
        ),
    ];
    let mut blocks = vec![
        part("Fill rate or vertices".to_owned()),
        Block::Text(format!(
            "Exponent b of {} = c · workᵇ between two fills that differ in one step after culling, with \
             its 95 % interval: 0 where that work costs nothing, 1 where it costs everything.",
            data.run.clock().name()
        )),
        Block::Table(figures(&headings, rows.collect())),
    ];
    blocks.extend(slopes.iter().map(|slopes| {
        Block::Finding(Finding {
            claim: format!(
                "{}: time grows faster with fragments than with vertices.",
                slopes.title
            ),
            standing: slopes.standing(),
            because: String::new(),
        })
    }));
    blocks
}
