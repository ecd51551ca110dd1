// SPDX-License-Identifier: MIT OR Apache-2.0
//! What controllers of level of detail do that count pixels some frames late.

use super::probe::{OuterProbe, PROBED};
use super::quadtree::{QuadtreeView, settle};
use super::radius::{constant_step, cycle, gain_without_overshoot, logarithmic, stable_gain};
use super::zones::cycling_zones;
use super::{numbers, table};

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

/// Gains on either side of the limit, as shares of it.
const BESIDE_LIMIT: [f64; 2] = [0.99, 1.01];

pub(super) fn page() -> String {
    let [radius, outer, quadtree, zones] = [
        table(
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
            radius(),
        ),
        table(
            &[
                "delay, frames",
                "period, frames",
                "eye at rest",
                "p (d + 1) of the corner's distance",
                "height doubles each second",
            ],
            outer_radius(),
        ),
        table(
            &[
                "hysteresis",
                "views that never settle",
                "frames of the others, at most",
            ],
            quadtree(),
        ),
        table(&["m", "4 m", "at 0.5 of it", "at 0.9", "at 4 m"], zones()),
    ];
    format!(
        "## Controllers of level of detail

Gebbie & Bailey hold a fan of triangles at a number of pixels, let the mesh shrink until pixels are missing at the edge of
the screen, and split a picture's quadtree by counted pixels. A count is some frames old when it is used. In closed form a
view gives both radii without a count: nothing swings and no corner goes bare. Here a delay of 0 uses a count in the next
frame. A run of `globes` draws and counts such frames on a device, and calls that a delay of 1: “Radii of the spiral by
counted pixels” of its chapter says where they differ from this page.

Radius of the fan by the delay of its count:
{radius}
Outer radius by trying, 1 % a frame, at 1920 × 1080: pixels of a corner's diagonal that go bare. By the closed form none do.
{outer}
Quadtree by the share of its two thresholds, in views that stand still:
{quadtree}
Height zones whose finest level hides all but 1/m of their pixels, by the share of the hysteresis 4 m: numbers of pixels
with which a zone never rests.
{zones}"
    )
}

/// Whether the logarithmic loop ends nearer to the wanted radius than it began.
fn settles(delay: usize, gain: f64) -> bool {
    // A hundredth below the limit a loop loses a few hundredths in a turn of its cycle.
    let series = logarithmic(delay, gain, 1.0, 20 * FRAMES);
    series.last().is_some_and(|off| off.abs() < 1e-3)
}

/// What a series repeats: its frames, and its swing.
fn repeats(series: &[f64]) -> [String; 2] {
    let swing = cycle(series, 1e-9).expect("it repeats");
    [
        swing.period.to_string(),
        format!("{:.0}", swing.peak_to_peak),
    ]
}

fn radius() -> Vec<Vec<String>> {
    let rows = DELAYS.map(|delay| {
        let gain = gain_without_overshoot(delay);
        let series = logarithmic(delay, gain, 1.0, FRAMES);
        let settled = series.iter().position(|off| off.abs() <= 0.01);
        let mut row = vec![delay.to_string()];
        // Off by a share of a step, or a count would be neither too high nor too low.
        row.extend(repeats(&constant_step(delay, 1.0, 0.3, FRAMES)));
        row.extend(numbers([stable_gain(delay)]));
        row.extend(BESIDE_LIMIT.map(|share| {
            let settles = settles(delay, share * stable_gain(delay));
            if settles { "settles" } else { "does not" }.to_owned()
        }));
        row.extend(numbers([gain]));
        row.push(settled.expect("it settles").to_string());
        row
    });
    rows.into()
}

/// Heights that double each second at 60 frames a second.
const DOUBLING: f64 = 0.011_486;

/// Pixels that go bare: at rest, by `p (d + 1)`, and where the height doubles each second.
fn bare_px(delay: usize) -> [f64; 3] {
    let still = OuterProbe { delay, ..PROBED };
    let rising = OuterProbe {
        rising: DOUBLING,
        ..still
    };
    [
        still.bare_px(FRAMES),
        still.step * (delay as f64 + 1.0) * PROBED.corner_px(),
        rising.bare_px(FRAMES),
    ]
}

fn outer_radius() -> Vec<Vec<String>> {
    let rows = DELAYS.map(|delay| {
        let [period, _] = repeats(&OuterProbe { delay, ..PROBED }.course(FRAMES));
        let figures = numbers(bare_px(delay));
        [delay.to_string(), period]
            .into_iter()
            .chain(figures)
            .collect()
    });
    rows.into()
}

/// Frames after which each view settles, if it does.
fn ends(hysteresis: f64) -> Vec<Option<usize>> {
    let views = (0..VIEWS).map(QuadtreeView::numbered);
    views
        .map(|view| settle(&view, TEXELS, hysteresis, 64))
        .collect()
}

fn quadtree() -> Vec<Vec<String>> {
    let rows = HYSTERESES.map(|hysteresis| {
        let ends = ends(hysteresis);
        let never = ends.iter().filter(|frames| frames.is_none()).count();
        let longest = ends.iter().flatten().max().expect("one settles");
        vec![
            hysteresis.to_string(),
            format!("{never} of {VIEWS}"),
            longest.to_string(),
        ]
    });
    rows.into()
}

/// Shares of the hysteresis at which no zone cycles.
const ZONE_SHARES: [f64; 3] = [0.5, 0.9, 1.0];
/// What the finest level of a zone hides all but this share of.
const HIDES: [f64; 3] = [1.0, 2.0, 4.0];
/// Numbers of pixels of a zone.
const ZONE_VIEWS: u32 = 400;

fn cycling(hides: f64, share: f64) -> usize {
    cycling_zones(share * 4.0 * hides, hides, 1, ZONE_VIEWS)
}

fn zones() -> Vec<Vec<String>> {
    let rows = HIDES.map(|hides| {
        let counts = ZONE_SHARES.map(|share| format!("{} of {ZONE_VIEWS}", cycling(hides, share)));
        numbers([hides, 4.0 * hides])
            .into_iter()
            .chain(counts)
            .collect()
    });
    rows.into()
}

#[test]
fn loops_settle_below_their_limits_and_not_above() {
    for (delay, row) in DELAYS.into_iter().zip(radius()) {
        let expected = [
            ["2", "1", "1"],
            ["6", "3", "10"],
            ["10", "5", "16"],
            ["14", "7", "23"],
        ];
        assert_eq!([&row[1], &row[2], &row[7]], expected[delay]);
        assert!(settles(delay, BESIDE_LIMIT[0] * stable_gain(delay)));
        // Negative control: a hundredth more.
        assert!(!settles(delay, BESIDE_LIMIT[1] * stable_gain(delay)));
        let [bare, computed, rising] = bare_px(delay);
        assert!(bare <= computed + 2.0 && bare > 0.5 * computed, "{bare}");
        assert!(rising > 2.0 * bare, "{delay}: {rising}");
    }
    // With the wider thresholds all settle; negative controls: with narrower ones some never do.
    assert!(ends(4.0).iter().all(Option::is_some));
    assert!(ends(3.9).iter().any(Option::is_none));
    for hides in HIDES {
        assert_eq!(cycling(hides, 1.0), 0);
        assert!(cycling(hides, 0.9) > 0);
    }
}
