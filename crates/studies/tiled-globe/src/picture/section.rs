// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on a picture in tiles of the map.

use super::PART;
use crate::metrics::{self, *};
use crate::tiles::section::COUNT;
use terrafill_globe_views::DRAW;
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_results::Finding;

pub(crate) const SECTION: Section<'static> = Section {
    title: "The Blue Marble in tiles of a map",
    text: "NASA's picture, by longitude and latitude, is cut into Web Mercator tiles and two caps, and drawn from an \
           array over 40 × 40 cells. Each pixel must have the colour of the texel that tiles with addresses say it \
           shows. The difference from the whole picture at the pixel's place on the body, in bytes of 255, is that \
           of resampling and of the grid. One area is drawn in three levels, as in Figure 1 of StuCoSReC 2018: by the \
           finest that a pixel asks for (“frame”), and by two and four below it.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[("view", VIEW), ("level by", LEVEL)]),
    columns: &[
        Column::metric("px with a texel", GLOBE_TILE_PX),
        Column::metric("of another colour", GLOBE_TILE_COLOUR_WRONG_PX),
        Column::metric(
            "off the whole picture, median",
            GLOBE_TILE_COLOUR_OFF_MEDIAN,
        ),
        Column::metric("99 %", GLOBE_TILE_COLOUR_OFF_P99),
        COUNT,
        DRAW,
    ],
    findings: &[same_colours],
    pictures: &[("picture", "as drawn")],
    ..Section::EMPTY
};

fn same_colours(cases: &Cases<'_>) -> Finding {
    let pair = cases
        .sum(GLOBE_TILE_COLOUR_WRONG_PX)
        .zip(cases.sum(GLOBE_TILE_PX));
    finding(
        "Tiles of colours show the texels that tiles of addresses name",
        pair.map(|(wrong, _)| wrong == 0.0),
        pair.map_or_else(String::new, |(wrong, of)| {
            format!("{wrong} of {of} pixels have another colour.")
        }),
    )
}
