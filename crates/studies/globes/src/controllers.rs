// SPDX-License-Identifier: MIT OR Apache-2.0
//! What controllers of level of detail do that count pixels some frames late: computed, not measured.

use crate::published::{cells, headed};
use terrafill_control::{
    OuterProbe, QuadtreeView, ZoneRule, constant_step, cycle, cycling_zones,
    gain_without_overshoot, logarithmic, settle, stable_gain,
};
use terrafill_plot::{Course, Courses};
use terrafill_results::{Block, Cell, ChapterError, Plot, Table};

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

/// Frames of a step response as drawn.
const SHOWN: usize = 48;
/// Gains on either side of the limit, as shares of it.
const BESIDE_LIMIT: [f64; 2] = [0.99, 1.01];

pub(crate) fn blocks() -> Result<Vec<Block>, ChapterError> {
    let mut blocks = vec![
        Block::section("Controllers of level of detail"),
        Block::Text(
            "Gebbie & Bailey hold a fan of triangles at a number of pixels, let the mesh shrink until pixels are missing \
             at the edge of the screen, and split a picture's quadtree by counted pixels. A count is some frames old when \
             it is used. These are computed, not measured. In closed form a view gives both radii without a count: \
             nothing swings and no corner goes bare."
                .to_owned(),
        ),
        Block::Table(radius()),
        Block::Table(outer_radius()),
        Block::Table(quadtree()),
        Block::Table(zones()),
    ];
    let svg = step_responses().draw()?;
    blocks.extend(svg.map(|svg| {
        Block::Plot(Plot {
            caption: "Answers to a step: constant steps and the logarithmic loop, radius less the wanted one; leaves \
                      of a quadtree in the first view that does not settle without hysteresis; levels of a height zone \
                      whose spike hides three quarters of it."
                .to_owned(),
            svg,
        })
    }));
    Ok(blocks)
}

/// Whether the logarithmic loop ends nearer to the wanted radius than it began.
fn settles(delay: usize, gain: f64) -> bool {
    // A hundredth below the limit a loop loses a few hundredths in a turn of its cycle.
    let series = logarithmic(delay, gain, 1.0, 20 * FRAMES);
    series.last().is_some_and(|off| off.abs() < 1e-3)
}

fn step_responses() -> Courses<'static> {
    let mut panels = Vec::new();
    let course = |name: String, mut values: Vec<f64>, wanted| {
        values.truncate(SHOWN);
        Course {
            name,
            values,
            wanted,
        }
    };
    for delay in DELAYS {
        let values = constant_step(delay, 1.0, 6.3, SHOWN);
        panels.push(course(
            format!("constant steps, d = {delay}"),
            values,
            Some(0.0),
        ));
    }
    for delay in DELAYS {
        let values = logarithmic(delay, gain_without_overshoot(delay), 1.0, SHOWN);
        panels.push(course(
            format!("ln r, no overshoot, d = {delay}"),
            values,
            Some(0.0),
        ));
    }
    for share in BESIDE_LIMIT {
        let values = logarithmic(1, share * stable_gain(1), 1.0, SHOWN);
        panels.push(course(
            format!("ln r, {share} of the limit, d = 1"),
            values,
            Some(0.0),
        ));
    }
    let mut views = (0..VIEWS).map(QuadtreeView::numbered);
    let cycling = views.find(|view| settle(view, TEXELS, 1.0, 64).frames.is_none());
    if let Some(view) = cycling {
        for hysteresis in [1.0, 4.0] {
            let leaves = settle(&view, TEXELS, hysteresis, SHOWN).leaves;
            let values = leaves.into_iter().map(|count| count as f64).collect();
            panels.push(course(
                format!("leaves, hysteresis {hysteresis}"),
                values,
                None,
            ));
        }
    }
    for hysteresis in [8.0, 16.0] {
        // As many pixels as the finest level wants, of which the spike there leaves a quarter.
        let rule = ZoneRule::new(8.0, 3, 1.0, hysteresis);
        let pixels = |level| match level {
            3 => 512.0 / 4.0,
            _ => 512.0,
        };
        let levels = rule.course(pixels, 1, SHOWN);
        let values = levels.into_iter().map(f64::from).collect();
        panels.push(course(
            format!("zone, m = 4, hysteresis {hysteresis}"),
            values,
            None,
        ));
    }
    Courses {
        title: "answers of controllers to a step".to_owned(),
        across: "frames",
        panels,
    }
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
        row.extend(cells([stable_gain(delay)]));
        row.extend(BESIDE_LIMIT.map(|share| {
            let name = if settles(delay, share * stable_gain(delay)) {
                "settles"
            } else {
                "does not"
            };
            Cell::plain(name)
        }));
        row.extend(cells([gain]));
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
            "at 0.99 of it",
            "at 1.01 of it",
            "largest gain without overshoot",
            "frames to 1 % with it",
        ],
        rows.into_iter(),
    )
}

/// The picture of the facts' figure, and the share of the radius that a mesh gives up in a frame.
const PROBED: OuterProbe = OuterProbe {
    half_px: [960.0, 540.0],
    delay: 1,
    step: 0.01,
    rising: 0.0,
};
/// Heights that double each second at 60 frames a second.
const DOUBLING: f64 = 0.011_486;

fn outer_radius() -> Table {
    let corner_px = PROBED.corner_px();
    let rows = DELAYS.map(|delay| {
        let still = OuterProbe { delay, ..PROBED };
        let rising = OuterProbe {
            rising: DOUBLING,
            ..still
        };
        let swing = cycle(&still.course(FRAMES), 1e-9);
        let mut row = vec![Cell::plain(delay.to_string())];
        row.push(Cell::or_absent(
            swing.map(|swing| swing.period.to_string()),
            "it does not repeat",
        ));
        row.extend(cells([
            still.bare_px(FRAMES),
            still.step * (delay as f64 + 1.0) * corner_px,
            rising.bare_px(FRAMES),
            0.0,
        ]));
        row
    });
    headed(
        "Outer radius by trying, 1 % a frame, at 1920 × 1080: pixels of a corner's diagonal that go bare",
        &[
            "delay, frames",
            "period, frames",
            "eye at rest",
            "p (d + 1) of the corner's distance",
            "height doubles each second",
            "closed form",
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

/// Shares of the hysteresis at which no zone cycles.
const ZONE_SHARES: [f64; 3] = [0.5, 0.9, 1.0];
/// Numbers of pixels of a zone.
const ZONE_VIEWS: u32 = 400;

fn zones() -> Table {
    let rows = [1.0, 2.0, 4.0].map(|hides| {
        let mut row = cells([hides, 4.0 * hides]);
        row.extend(ZONE_SHARES.map(|share| {
            let cycling = cycling_zones(share * 4.0 * hides, hides, 1, ZONE_VIEWS);
            Cell::plain(format!("{cycling} of {ZONE_VIEWS}"))
        }));
        row
    });
    headed(
        "Height zones whose finest level hides all but 1/m of their pixels, by the share of the hysteresis 4 m: numbers of \
         pixels with which a zone never rests",
        &["m", "4 m", "at 0.5 of it", "at 0.9", "at 4 m"],
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
            [0, 1, 2, 3].map(|row| text(&radius, row, 7)),
            ["1", "10", "16", "23"]
        );
        for row in 0..4 {
            assert_eq!(text(&radius, row, 4), "settles");
            // Twin: a hundredth more.
            assert_eq!(text(&radius, row, 5), "does not");
        }
        let outer = outer_radius();
        for (row, delay) in (0..4).zip(DELAYS) {
            let [bare, computed, rising] =
                [2, 3, 4].map(|at| text(&outer, row, at).parse::<f64>().expect("a number"));
            assert!(
                bare <= computed + 2.0 && bare > 0.5 * computed,
                "{delay}: {bare}"
            );
            assert!(rising > 2.0 * bare, "{delay}: {rising}");
        }
        let quadtree = quadtree();
        assert_eq!(text(&quadtree, 5, 1), "0 of 300");
        // Twin: with less than 4 some never settle.
        assert_ne!(text(&quadtree, 4, 1), "0 of 300");
        let zones = zones();
        for row in 0..3 {
            assert_eq!(text(&zones, row, 4), "0 of 400");
            assert_ne!(text(&zones, row, 3), "0 of 400");
        }
    }

    #[test]
    fn answers_are_drawn_for_every_loop() {
        let plot = step_responses();
        assert_eq!(plot.panels.len(), 14);
        let last = |at: usize| plot.panels[at].values.last().copied().expect("values");
        // A zone whose spike hides more than its hysteresis bears.
        let end = |at: usize| plot.panels[at].values[SHOWN - 8..].to_vec();
        assert!(end(12).windows(2).any(|pair| pair[0] != pair[1]));
        assert!(end(13).windows(2).all(|pair| pair[0] == pair[1]));
        // The logarithmic loops come to rest, the constant steps do not.
        assert!(last(5).abs() < 1e-3 && last(1).abs() > 0.2);
        assert!(plot.draw().expect("a plot").is_some());
    }
}
