// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter's section on craters that balls make.

use crate::craters::{ALLOWED_CRATER_M, CraterWay};
use crate::metrics::*;
use terrafill_lab::{Cases, Column, Comparison, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Claim, Finding, Outcome, Scope};

const WHY_ONCE: &str = "Each ball digs once. Depths of craters of one step are added, so their order matters only by \
     rounding. A ball must meet the ground first in the same step as in f64, unless rounding decides. The reference begins each step from the balls and heights that the device had: \
     slopes jump from cell to cell, so that a difference of micrometres is one of metres some bounces later.";

pub(super) const SECTION: Section<'static> = Section {
    title: "Craters where balls strike",
    caption: "A step of balls over terrain, with the craters of its first impacts, on wgpu",
    text: "Balls fly over the terrain of the section before, and are reflected where they meet it. Where a ball does so for \
           the first time, it digs a crater into the layers of the array texture that all balls read heights from: \
           0.25 s × its speed in radius, a quarter of that deep. Layers are drawn into: a pass a layer, in which blending \
           takes craters off heights. Or the CPU reads the balls and writes the struck layers. Each step is held \
           against f64 from the same balls and heights: places, velocities, first impacts, and all heights. Pictures \
           show the terrain's triangles and a disc of half a metre for each ball. Of each picture some 13,000 pixels \
           or more, evenly spread, are held against rays in f64. A time is the mean over all steps.",
    cases: Select::With(PART, "craters"),
    named_by: Names::Columns(&[("craters", CRATER_WAY), ("balls", BALLS)]),
    columns: &[
        Column::metric("CPU µs a step", BALL_FRAME_CPU_US),
        Column::metric("wall µs a step", BALL_FRAME_WALL_US),
        Column::metric("uploaded", BALL_UPLOAD_BYTES),
        Column::metric("first impacts", BALL_STRIKES),
        Column::metric("in another step than f64", BALL_STRIKES_DIFFERING),
        Column::metric("bounces on craters", BALL_BOUNCES_ON_CRATERS),
        Column::metric("a height's error, m", BALL_CRATER_M),
        Column::metric("torn heights", BALL_CRATER_TORN),
        Column::metric("a step's error, m", BALL_TERRAIN_STEP_M),
        Column::metric("wrong pixels of those looked at", BALL_MISMATCHED_PX),
    ],
    findings: &[drawn_is_faster],
    pictures: &[("picture", "")],
    more: &[|_| Ok(Some(terrafill_results::Block::Remark(WHY_ONCE.to_owned())))],
    ..Section::EMPTY
};

fn drawn_is_faster(cases: &Cases<'_>) -> Finding {
    let comparison = Comparison {
        changed: CRATER_WAY.name(),
        follows: &[],
        one_sided: None,
        metric: cases.clock().pick(BALL_FRAME_WALL_US, BALL_FRAME_CPU_US),
        needs: Scope::DISPATCH.and(Scope::DRAW),
    };
    let ways = [CraterWay::Written, CraterWay::Drawn].map(CraterWay::name);
    let pairs = cases
        .with(&[(PART, "craters")])
        .pairs(CRATER_WAY, ways, &[]);
    let claim = "A step whose craters are drawn into layers is faster than one whose struck layers the CPU writes:";
    cases.compared(&comparison, &pairs, Claim::Faster, claim.to_owned())
}

/// What is required: heights, balls and pictures are those of `f64`.
pub(super) fn findings(cases: &Cases<'_>) -> Vec<Finding> {
    let own = cases.with(&[(PART, "craters")]);
    let is_wrong = |outcome: &Outcome| ![Outcome::Ok, Outcome::Skipped].contains(outcome);
    let wrong = own.iter().filter(|case| is_wrong(&case.outcome)).count();
    let far = own.greatest(BALL_CRATER_M);
    let pixels = own.greatest(BALL_MISMATCHED_PX);
    let said = far.zip(pixels).map_or_else(String::new, |(far, pixels)| {
        format!(
            "at most {} m and {pixels} pixels off, {wrong} cases wrong",
            significant(far)
        )
    });
    let claim = format!(
        "Craters where balls strike are within {ALLOWED_CRATER_M} m of f64 after every step, and balls and ground are drawn \
         as rays see them:"
    );
    let holds = far.map(|far| wrong == 0 && far <= ALLOWED_CRATER_M);
    (!own.is_empty())
        .then(|| finding(claim, holds, said))
        .into_iter()
        .collect()
}
