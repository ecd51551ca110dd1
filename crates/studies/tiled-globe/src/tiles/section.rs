// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on tiles of a map over the grid on the screen.

use super::PART;
use crate::metrics::{self, *};
use crate::options::Options;
use crate::steps::may_lose_texels;
use terrafill_globe_views::{DRAW, FRAME};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding, measured};
use terrafill_results::{Case, Finding};

/// Columns that all parts on tiles have.
pub(crate) const MISSING: Column = Column::metric("px without a tile", GLOBE_TILE_MISSING_PX);
pub(crate) const WRONG: Column = Column::metric("wrong px", GLOBE_TILE_WRONG_PX);
pub(crate) const COUNT: Column = Column::metric("tiles", GLOBE_TILE_COUNT);
pub(crate) const AT_SEAM: Column = Column::metric("px at the seam", GLOBE_TILE_SEAM_PX);
pub(crate) const OFF_AT_SEAM: Column = Column::metric("off by > ½ texel", GLOBE_TILE_SEAM_WRONG_PX);
pub(crate) const STEP: Column = Column::metric("step of f32, texels", GLOBE_TILE_STEP_TEXELS);
pub(crate) const LARGEST: Column = Column::metric("texels, largest", GLOBE_TILE_TEXELS_MAX);

pub(crate) const SECTION: Section<'static> = Section {
    title: "Tiles of a map over the grid on the screen",
    text: "A Web Mercator map in tiles of 256 × 256 texels lies over the grid on the screen, with a stereographic cap \
           about each pole. Every texel holds its own address, so the picture says which texel a pixel shows. \
           “Texels” is how far outside it the pixel's place lies: by the triangles as drawn, with longitude in one \
           piece, which leaves seam and f32 as causes; and by the body itself. Triangles that hold a pole are left \
           out of the first: longitude is no function on them. Near the ground, roundings of what `f32` counts from the \
           map's edge may be more than ½ texel: ways but “local” may be wrong there. A case of the base is a grid of \
           10 × 10 cells, split by the CPU at ½, with V' by the vertex. It has one draw from an array, and a level for \
           each pixel. Others differ in what is named.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Of("way", name),
    columns: &[
        Column::metric("crossing triangles", GLOBE_TILE_CROSSING),
        Column::metric("missed", GLOBE_TILE_MISSED),
        AT_SEAM,
        OFF_AT_SEAM,
        STEP,
        LARGEST,
        Column::metric("texels, 99 %", GLOBE_TILE_TEXELS_P99),
        Column::metric("of the body, median", GLOBE_TILE_TRUE_TEXELS_MEDIAN),
        Column::metric("of the body, 99 %", GLOBE_TILE_TRUE_TEXELS_P99),
        Column::metric("of the body, largest", GLOBE_TILE_TRUE_TEXELS_MAX),
        MISSING,
        Column::metric("px in triangles with a pole", GLOBE_TILE_POLE_PX),
        COUNT,
        Column::metric("draws", GLOBE_TILE_DRAWS),
        FRAME,
        DRAW,
        Column::metric("tiles, bytes", GLOBE_TILE_BYTES),
    ],
    per: Some(VIEW),
    findings: &[seam_finding],
    ..Section::EMPTY
};

/// What differs from the base.
fn name(case: &Case) -> String {
    let all = Options::BASE.conditions();
    let other: Vec<String> = all
        .iter()
        .filter(|(key, value)| case.condition(*key) != value)
        .map(|(key, _)| format!("{key}={}", case.condition(*key)))
        .collect();
    if other.is_empty() {
        "base".to_owned()
    } else {
        other.join(" ")
    }
}

fn seam_finding(cases: &Cases<'_>) -> Finding {
    // Triangles across the seam and those that a rule misses, and pixels beside it and those that are wrong.
    let keeps = |case: &Case| {
        let step = measured(case, GLOBE_TILE_STEP_TEXELS);
        !step.is_some_and(may_lose_texels)
    };
    let sums = |seam: &str, is_kept: bool| {
        let own = cases.with(&[(SEAM, seam)]);
        let own = own.fitting(|case| keeps(case) == is_kept);
        [
            GLOBE_TILE_CROSSING,
            GLOBE_TILE_MISSED,
            GLOBE_TILE_SEAM_PX,
            GLOBE_TILE_SEAM_WRONG_PX,
        ]
        .map(|metric| own.sum(metric).unwrap_or(0.0))
    };
    let [crossing, _, px, wrong] = sums("split-0.5", true);
    let rules = [
        "none",
        "split-0.7",
        "split-0.5",
        "derivative",
        "rotated",
        "local",
    ];
    let words = rules.map(|rule| {
        let [crossing, missed, px, wrong] = sums(rule, true);
        let [.., px_near, wrong_near] = sums(rule, false);
        let near = (px_near > 0.0)
            .then(|| format!(", and {wrong_near} of {px_near} where f32 loses texels"));
        format!(
            "{rule}: {missed} of {crossing} triangles missed, {wrong} of {px} px wrong{}",
            near.unwrap_or_default()
        )
    });
    finding(
        "Split at half a turn, no texel is off by more than ½ within two pixels of ±180°, where f32 keeps texels",
        (crossing > 0.0 && px > 0.0).then_some(wrong == 0.0),
        format!("{}.", words.join("; ")),
    )
}
