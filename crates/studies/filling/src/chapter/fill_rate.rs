// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fill rate or vertices: how time grows with each while the other stays.
//!
//! Within a view, two fills of a ladder that differ in one step give an exponent: ln of their times'
//! ratio over ln of their work's ratio, 0 where that work costs nothing and 1 where it costs everything.
//! For vertices the fragments must be equal, for fragments the vertices. Only steps after culling count
//! that change nothing else, and of these the one that changes the work most.

use super::rungs::Rung;
use crate::keys::{FRAGMENT_SHADER_INVOCATIONS, STENCIL_FRAGMENTS, VERTICES};
use terrafill_results::{Case, Estimate};

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

type Work = fn(&Case) -> Option<f64>;

/// Exponents of time over vertices and over fragments, where a view's steps give both.
pub(super) fn exponents(rungs: &[Rung<'_>]) -> Option<[Estimate; 2]> {
    let vertices: Work = |case| case.value(VERTICES);
    // Of both passes.
    let fragments: Work =
        |case| Some(case.value(STENCIL_FRAGMENTS)? + case.value(FRAGMENT_SHADER_INVOCATIONS)?);
    let over_vertices = exponent(rungs, vertices, fragments)?;
    Some([over_vertices, exponent(rungs, fragments, vertices)?])
}

fn exponent(rungs: &[Rung<'_>], varied: Work, kept: Work) -> Option<Estimate> {
    let from = rungs.iter().position(|rung| rung.step == "culling")?;
    let usable = rungs[from + 1..].iter();
    let usable = usable.filter(|rung| STEPS.contains(&rung.step));
    let levers = usable.filter_map(|rung| {
        let (before, gain) = (rung.before?, rung.gain?);
        let lever = |work: Work| {
            let ratio = work(before)? / work(rung.case)?;
            (ratio.is_finite() && ratio > 0.0).then(|| ratio.ln())
        };
        let is_same = lever(kept)?.abs() <= SAME_WORK.ln();
        let lever = lever(varied)?;
        (is_same && lever.abs() >= MIN_LEVER.ln()).then_some((lever, gain))
    });
    let (lever, gain) = levers.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    let of = |ratio: f64| ratio.ln() / lever;
    Some(Estimate {
        middle: of(gain.middle),
        interval: gain.interval.map(|[low, high]| {
            let (a, b) = (of(low), of(high));
            [a.min(b), a.max(b)]
        }),
        processes: gain.processes,
    })
}
