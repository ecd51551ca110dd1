// SPDX-License-Identifier: MIT OR Apache-2.0
//! What controllers of level of detail do that count pixels some frames late: computed, not measured.

use crate::published::{cells, headed};
use terrafill_control::{
    QuadtreeView, constant_step, cycle, gain_without_overshoot, logarithmic, settle, stable_gain,
};
use terrafill_results::{Block, Cell, Table};

/// Frames from drawing to using a count; 1 is the paper's, 2 or 3 are what mapping a buffer back takes.
const DELAYS: [usize; 4] = [0, 1, 2, 3];
/// Upper threshold of a quadtree's pixels for each texel over the lower one.
const HYSTERESES: [f64; 6] = [1.0, 1.5, 2.0, 3.0, 3.9, 4.0];
/// Views of a quadtree.
const VIEWS: u32 = 300;
/// Texels of a node.
const TEXELS: f64 = 4096.0;

/// A few hundred frames are enough for each of these loops to come to rest or to repeat.
const FRAMES: usize = 400;

pub(crate) fn blocks() -> Vec<Block> {
    vec![
        Block::section("Controllers of level of detail"),
        Block::Text(
            "Gebbie & Bailey hold a fan of triangles at a number of pixels, and split a picture's quadtree by \
             counted pixels. A count is some frames old when it is used. These are computed, not measured."
                .to_owned(),
        ),
        Block::Table(radius()),
        Block::Table(quadtree()),
    ]
}

fn radius() -> Table {
    let rows = DELAYS.map(|delay| {
        // Off by a share of a step, or a count would be neither too high nor too low.
        let swing = cycle(&constant_step(delay, 1.0, 0.3, FRAMES), 1e-9);
        let gain = gain_without_overshoot(delay);
        let series = logarithmic(delay, gain, 1.0, FRAMES);
        let settled = series.iter().position(|off| off.abs() <= 0.01);
        let mut row = vec![Cell::plain(delay.to_string())];
        let never = "it does not repeat";
        row.push(Cell::or_absent(
            swing.map(|swing| swing.period.to_string()),
            never,
        ));
        row.push(Cell::or_absent(
            swing.map(|swing| format!("{:.0}", swing.peak_to_peak)),
            never,
        ));
        row.extend(cells([stable_gain(delay), gain]));
        row.push(Cell::or_absent(
            settled.map(|frames| frames.to_string()),
            "it does not settle",
        ));
        row
    });
    headed(
        "Radius of the fan by the delay of its count",
        &[
            "delay, frames",
            "constant steps: period, frames",
            "swing, steps",
            "logarithmic: stable below the gain",
            "largest gain without overshoot",
            "frames to 1 % with it",
        ],
        rows.into_iter(),
    )
}

fn quadtree() -> Table {
    let views: Vec<QuadtreeView> = (0..VIEWS).map(QuadtreeView::numbered).collect();
    let rows = HYSTERESES.map(|hysteresis| {
        let ends = views
            .iter()
            .map(|view| settle(view, TEXELS, hysteresis, 64).frames);
        let ends: Vec<Option<usize>> = ends.collect();
        let never = ends.iter().filter(|frames| frames.is_none()).count();
        let longest = ends.iter().flatten().max();
        vec![
            Cell::plain(hysteresis.to_string()),
            Cell::plain(format!("{never} of {VIEWS}")),
            Cell::or_absent(longest.map(ToString::to_string), "none settles"),
        ]
    });
    headed(
        "Quadtree by the share of its two thresholds, in views that stand still",
        &[
            "hysteresis",
            "views that never settle",
            "frames of the others, at most",
        ],
        rows.into_iter(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_what_the_loops_do() {
        let text = |table: &Table, row: usize, column: usize| -> String {
            table.rows[row].cells[column].text.clone()
        };
        let radius = radius();
        let periods = [0, 1, 2, 3].map(|row| text(&radius, row, 1));
        assert_eq!(periods, ["2", "6", "10", "14"]);
        assert_eq!(
            [0, 1, 2, 3].map(|row| text(&radius, row, 2)),
            ["1", "3", "5", "7"]
        );
        assert_eq!(
            [0, 1, 2, 3].map(|row| text(&radius, row, 5)),
            ["1", "10", "16", "23"]
        );
        let quadtree = quadtree();
        assert_eq!(text(&quadtree, 5, 1), "0 of 300");
        // Twin: with less than 4 some never settle.
        assert_ne!(text(&quadtree, 4, 1), "0 of 300");
    }
}
