// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lower walls: volumes between the heights of the surface as each view draws it, beside volumes between
//! one range of heights for the whole Earth.
//!
//! The two differ in nothing else, the mesh included, so that what differs is what the walls' height costs.

use super::data::{Data, counter};
use super::rungs::{Ladder, SOURCE};
use crate::keys::{MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND, STENCIL_FRAGMENTS, WALL_HEIGHT_M};
use terrafill_plot::number::{count, significant};
use terrafill_results::{Block, Case, Cell, Heading, Row, Table};

/// The step of every ladder that measures global heights against the rung before it.
const STEP: &str = "walls-global";

/// A row for every ladder that has both.
pub(super) fn blocks(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Vec<Block> {
    let rows: Vec<Row> = ladders
        .iter()
        .filter_map(|ladder| row(data, ladder))
        .collect();
    if rows.is_empty() {
        return Vec::new();
    }
    vec![
        Block::section("Lower walls"),
        Block::Text(format!(
            "Volumes that reach as far as the surface does over each region in the view at hand, facets that \
             hang between their corners included (`wall-heights=region`), ÷ volumes from 12 km below the \
             ellipsoid to 12 km above it (`wall-heights=global`); below 1 lower walls are better. {SOURCE} \
             of walls: “Though you would think reducing their high would improve performance, I did not \
             observe any differences.” `terrafill bench hills --ladder hills --technique vertex` measures \
             both on terrain.",
        )),
        Block::Table(Table {
            headings: vec![
                Heading::plain("scene, view: technique"),
                Heading::explained(
                    "time [95\u{a0}%]",
                    "of the whole fill, paired by process; both pictures must be right",
                ),
                Heading::metric("fragments of volumes", STENCIL_FRAGMENTS),
                Heading::metric("tallest wall, m", WALL_HEIGHT_M),
                Heading::explained(
                    "px that differ in the band",
                    "mismatched_px − mismatched_px_outside_band",
                ),
            ],
            rows,
            is_main: true,
            ..Table::default()
        }),
    ]
}

fn row(data: &Data<'_>, ladder: &Ladder<'_>) -> Option<Row> {
    let rung = ladder.rungs.iter().find(|rung| rung.step == STEP)?;
    let (region, global) = (rung.before?, rung.case);
    let time = data.over(region, global);
    let of = |figure: fn(&Case) -> Option<u64>, why: &str| {
        let both = figure(region).zip(figure(global));
        Cell::or_absent(both.map(|(region, global)| over(region, global)), why)
    };
    Some(
        Row::new(vec![
            Cell::name(&ladder.title),
            data.ratio_cell(
                time.as_ref(),
                "one of the two is not right or was not timed",
            ),
            of(
                |case| counter(case, STENCIL_FRAGMENTS),
                "the device does not count them",
            ),
            of(
                |case| counter(case, WALL_HEIGHT_M),
                "not recorded by this run",
            ),
            of(wrong_in_band, "not compared with the reference"),
        ])
        .bad_if(!(region.counts() && global.counts())),
    )
}

/// Pixels that differ from the reference beside its boundaries.
fn wrong_in_band(case: &Case) -> Option<u64> {
    let outside = counter(case, MISMATCHED_PX_OUTSIDE_BAND)?;
    counter(case, MISMATCHED_PX)?.checked_sub(outside)
}

/// Both figures, and their ratio where there is one.
fn over(region: u64, global: u64) -> String {
    let both = format!("{} ÷ {}", count(region), count(global));
    match global {
        0 => both,
        _ => format!("{both} = {}", significant(region as f64 / global as f64)),
    }
}
