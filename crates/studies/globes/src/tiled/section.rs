// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on tiles of a map over the grid on the screen.

use super::PART;
use crate::keys::{
    CELLS, GLOBE_TILE_BYTES, GLOBE_TILE_COUNT, GLOBE_TILE_CROSSING, GLOBE_TILE_DRAWS,
    GLOBE_TILE_MISSED, GLOBE_TILE_MISSING_PX, GLOBE_TILE_POLE_PX, GLOBE_TILE_SEAM_PX,
    GLOBE_TILE_SEAM_WRONG_PX, GLOBE_TILE_TEXELS_MAX, GLOBE_TILE_TEXELS_P99,
    GLOBE_TILE_TRUE_TEXELS_MAX, GLOBE_TILE_TRUE_TEXELS_MEDIAN, GLOBE_TILE_TRUE_TEXELS_P99, LEVEL,
    MERCATOR, SEAM, TILES, VIEW,
};
use crate::table::{by_case, cases, with};
use terrafill_results::{Block, Case, Clock, Finding, Run, Standing, Table};

/// What is measured.
const WHAT_IS_COMPARED: &str = "A Web Mercator map in tiles of 256 × 256 texels lies over the grid on the screen, with a stereographic \
     cap about each pole. Every texel holds its own address, so the picture says which texel a pixel shows. \
     “Texels” is how far outside it the pixel's place lies: by the triangles as drawn, with longitude in one \
     piece, which leaves seam and f32 as causes; and by the body itself. Triangles that hold a pole are left out \
     of the first: longitude is no function on them. A case of the base is a grid of 10 × 10 cells, split by the \
     CPU at ½, V' by the vertex, one draw from an array, a level for each pixel. Others differ in what is named.";

/// What differs from the base.
fn name(case: &Case) -> String {
    let base = super::Options::BASE;
    let all = [
        (CELLS, base.n.to_string()),
        (SEAM, base.seam.name()),
        (TILES, base.drawing.name().to_owned()),
        (MERCATOR, base.mercator().to_owned()),
        (LEVEL, base.level().to_owned()),
    ];
    let other: Vec<String> = all
        .iter()
        .filter(|(key, value)| case.condition(*key) != value)
        .map(|(key, _)| format!("{key}={}", case.condition(*key)))
        .collect();
    match other.is_empty() {
        true => "base".to_owned(),
        false => other.join(" "),
    }
}

fn views<'a>(cases: &[&'a Case]) -> Vec<&'a str> {
    let mut views: Vec<&str> = Vec::new();
    for case in cases {
        if !views.contains(&case.condition(VIEW)) {
            views.push(case.condition(VIEW));
        }
    }
    views
}

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run, clock: Clock) -> Vec<Block> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![
        Block::section("Tiles of a map over the grid on the screen"),
        Block::Text(WHAT_IS_COMPARED.to_owned()),
        Block::Finding(seam_finding(&cases)),
    ];
    for view in views(&cases) {
        let own = with(&cases, VIEW, view);
        blocks.push(Block::Table(table(view, &own, clock)));
    }
    blocks
}

fn table(view: &str, cases: &[&Case], clock: Clock) -> Table {
    let columns = [
        ("crossing triangles", GLOBE_TILE_CROSSING),
        ("missed", GLOBE_TILE_MISSED),
        ("px at the seam", GLOBE_TILE_SEAM_PX),
        ("off by > ½ texel", GLOBE_TILE_SEAM_WRONG_PX),
        ("texels, largest", GLOBE_TILE_TEXELS_MAX),
        ("texels, 99 %", GLOBE_TILE_TEXELS_P99),
        ("of the body, median", GLOBE_TILE_TRUE_TEXELS_MEDIAN),
        ("of the body, 99 %", GLOBE_TILE_TRUE_TEXELS_P99),
        ("of the body, largest", GLOBE_TILE_TRUE_TEXELS_MAX),
        ("px without a tile", GLOBE_TILE_MISSING_PX),
        ("px in triangles with a pole", GLOBE_TILE_POLE_PX),
        ("tiles", GLOBE_TILE_COUNT),
        ("draws", GLOBE_TILE_DRAWS),
        ("frame, ms", crate::clock::whole(clock)),
        ("draw, ms", crate::clock::draw(clock)),
        ("tiles, bytes", GLOBE_TILE_BYTES),
    ];
    by_case(
        &format!("Tiles in view {view}"),
        cases,
        (&["way"], &|case| vec![name(case)]),
        &columns,
        &|_| "not measured",
    )
}

/// Triangles across the seam and those that a rule misses, and pixels beside it and those that are wrong.
fn seam_sums(cases: &[&Case], seam: &str) -> [f64; 4] {
    let metrics = [
        GLOBE_TILE_CROSSING,
        GLOBE_TILE_MISSED,
        GLOBE_TILE_SEAM_PX,
        GLOBE_TILE_SEAM_WRONG_PX,
    ];
    let of_rule = with(cases, SEAM, seam);
    metrics.map(|metric| of_rule.iter().filter_map(|case| case.value(metric)).sum())
}

fn seam_finding(cases: &[&Case]) -> Finding {
    let rules = [
        "none",
        "split-0.7",
        "split-0.5",
        "derivative",
        "rotated",
        "local",
    ];
    let sums: Vec<(&str, [f64; 4])> = rules.map(|rule| (rule, seam_sums(cases, rule))).into();
    let [crossing, _, px, wrong] = seam_sums(cases, "split-0.5");
    let words = sums.iter().map(|(rule, [crossing, missed, px, wrong])| {
        format!("{rule}: {missed} of {crossing} triangles missed, {wrong} of {px} px wrong")
    });
    Finding {
        claim: "Split at half a turn, no texel is off by more than ½ within two pixels of ±180°"
            .to_owned(),
        standing: match crossing > 0.0 && px > 0.0 {
            true => Standing::holds_if(wrong == 0.0),
            false => Standing::CannotTell,
        },
        because: format!("{}.", words.collect::<Vec<_>>().join("; ")),
    }
}

/// Cells a side and time of a frame drawn as published, by view, for views that go through the published numbers of
/// cells.
pub(crate) fn frame_times_by_cells(run: &Run, clock: Clock) -> Vec<(String, Vec<[f64; 2]>)> {
    let cases = cases(run, PART);
    let times = |view: &&str| {
        let own = cases.iter().filter(|case| {
            case.condition(VIEW) == *view && case.condition(TILES) == "draw-each" && case.counts()
        });
        let mut times: Vec<[f64; 2]> = own
            .filter_map(|case| {
                let n: f64 = case.condition(CELLS).parse().ok()?;
                Some([n, case.value(crate::clock::whole(clock))?])
            })
            .collect();
        times.sort_by(|a, b| a[0].total_cmp(&b[0]));
        ((*view).to_owned(), times)
    };
    let all = views(&cases);
    let with = all.iter().map(times);
    with.filter(|(_, times)| times.len() >= 3).collect()
}
