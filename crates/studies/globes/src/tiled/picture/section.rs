// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on a picture in tiles of the map.

use super::PART;
use crate::keys::{
    GLOBE_TILE_COLOUR_OFF_MEDIAN, GLOBE_TILE_COLOUR_OFF_P99, GLOBE_TILE_COLOUR_WRONG_PX,
    GLOBE_TILE_COUNT, GLOBE_TILE_PX, VIEW,
};
use crate::table::{by_case, cases, conditions};
use terrafill_results::{
    Block, Case, Clock, Finding, Metric, Picture, PictureFigure, Pictures, Run, Standing,
};

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run, clock: Clock) -> Vec<Block> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Vec::new();
    }
    let columns = [
        ("px with a texel", GLOBE_TILE_PX),
        ("of another colour", GLOBE_TILE_COLOUR_WRONG_PX),
        (
            "off the whole picture, median",
            GLOBE_TILE_COLOUR_OFF_MEDIAN,
        ),
        ("99 %", GLOBE_TILE_COLOUR_OFF_P99),
        ("tiles", GLOBE_TILE_COUNT),
        ("draw, ms", crate::clock::draw(clock)),
    ];
    let table = by_case(
        "A picture of the Earth in tiles of the map",
        &cases,
        (&["view"], &conditions(&[VIEW])),
        &columns,
        &|_| "not measured",
    );
    let mut blocks = vec![
        Block::section("The Blue Marble in tiles of a map"),
        Block::Text(
            "NASA's picture, by longitude and latitude, is cut into Web Mercator tiles and two caps, and drawn from an array \
             over 40 × 40 cells. Each pixel must have the colour of the texel that tiles with addresses say it shows. The \
             difference from the whole picture at the pixel's place on the body, in bytes of 255, is that of resampling \
             and of the grid."
                .to_owned(),
        ),
        Block::Table(table),
        Block::Finding(finding(&cases)),
    ];
    blocks.extend(pictures(&cases));
    blocks
}

fn finding(cases: &[&Case]) -> Finding {
    let sum = |metric: &Metric| {
        cases
            .iter()
            .filter_map(|case| case.value(metric))
            .sum::<f64>()
    };
    let (wrong, of) = (sum(GLOBE_TILE_COLOUR_WRONG_PX), sum(GLOBE_TILE_PX));
    Finding {
        claim: "Tiles of colours show the texels that tiles of addresses name".to_owned(),
        standing: match of > 0.0 {
            true => Standing::holds_if(wrong == 0.0),
            false => Standing::CannotTell,
        },
        because: format!("{wrong} of {of} pixels have another colour."),
    }
}

fn pictures(cases: &[&Case]) -> Option<Block> {
    let shown = cases.iter().filter(|case| !case.note("picture").is_empty());
    let figures: Vec<PictureFigure> = shown
        .map(|case| PictureFigure {
            pictures: vec![Picture {
                path: case.note("picture").to_owned(),
                caption: case.condition(VIEW).to_owned(),
            }],
            notes: Vec::new(),
        })
        .collect();
    (!figures.is_empty()).then(|| {
        Block::Pictures(Pictures {
            caption: "The Blue Marble in tiles of a map.".to_owned(),
            reference: String::new(),
            figures,
        })
    })
}
