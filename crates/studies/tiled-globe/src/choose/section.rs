// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on tiles chosen in each frame.

use super::PART;
use crate::metrics::{self, *};
use crate::tiles::section::{MISSING, WRONG};
use terrafill_globe_views::{DRAW, FRAME, MAKE};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_results::Finding;

pub(crate) const SECTION: Section<'static> = Section {
    title: "Tiles chosen in each frame",
    text: "A frame makes the grid, chooses tiles, sends and draws. The rule of StuCoSReC 2018 is lost, so this one is \
           ours. A triangle asks for every level from the coarsest to the finest of its three corners, and there for \
           the tiles between them. A pixel within may be nearer to the eye than all corners, and then has no tile. \
           Spare tiles are chosen and shown by no pixel. Wrong pixels are \
           allowed nowhere but in views with a limb, where a few are left whose cause is not separated. The list of tiles is sent with the grid. All are at hand: loading is not timed here.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[("view", VIEW), ("N", CELLS)]),
    columns: &[
        Column::metric("tiles chosen", GLOBE_TILE_COUNT),
        Column::metric("spare", GLOBE_TILE_SPARE),
        MISSING,
        WRONG,
        Column::metric("choose, CPU ms", GLOBE_CHOOSE_CPU_MS),
        MAKE,
        FRAME,
        DRAW,
    ],
    findings: &[enough],
    ..Section::EMPTY
};

fn enough(cases: &Cases<'_>) -> Finding {
    let missing = |own: &Cases<'_>| own.sum(GLOBE_TILE_MISSING_PX);
    let words = cases.by(CELLS).into_iter().filter_map(|(n, own)| {
        let [missing, spare, chosen] = [GLOBE_TILE_MISSING_PX, GLOBE_TILE_SPARE, GLOBE_TILE_COUNT]
            .map(|metric| own.sum(metric));
        Some(format!(
            "N = {n}: {} px without a tile, {} of {} tiles spare",
            missing?, spare?, chosen?
        ))
    });
    let words: Vec<String> = words.collect();
    finding(
        "Every pixel has its tile where tiles are those that corners ask for",
        missing(cases).map(|px| px == 0.0),
        format!("{}.", words.join("; ")),
    )
}
