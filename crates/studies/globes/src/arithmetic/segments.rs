// SPDX-License-Identifier: MIT OR Apache-2.0
//! Segments that a straight path needs in each projection.

use super::table;
use crate::projection::{K, dome, hyperbolic_cartesian, hyperbolic_polar};
use glam::DVec3;
use terrafill_plot::number::significant;

/// Half a picture's rows, of which segments are counted.
const RIM_PX: f64 = 540.0;
/// What no one sees, pixels.
const FINE_PX: f64 = 0.25;

/// Fewest segments of a straight path with which no point is off by more than a quarter of a pixel.
///
/// - `place`: along the path, 0 … 1, to pixels
fn segments(place: impl Fn(f64) -> [f64; 2]) -> u32 {
    (1..1000)
        .find(|count| off_px(&place, *count) <= FINE_PX)
        .unwrap_or(1000)
}

/// Largest distance between a path and its segments at the same share of the way.
fn off_px(place: &impl Fn(f64) -> [f64; 2], count: u32) -> f64 {
    const PARTS: u32 = 32;
    let count_ = f64::from(count);
    let mut worst = 0.0_f64;
    for segment in 0..count {
        let [from, to] = [segment, segment + 1].map(|at| f64::from(at) / count_);
        let [a, b] = [place(from), place(to)];
        for part in 1..PARTS {
            let share = f64::from(part) / f64::from(PARTS);
            let at = place(from + share * (to - from));
            let off = [0, 1].map(|i| a[i] + share * (b[i] - a[i]) - at[i]);
            worst = worst.max(off[0].hypot(off[1]));
        }
    }
    worst
}

pub(super) fn page() -> String {
    let rows = paths().map(|(name, place)| {
        let figures = [
            segments(&place).to_string(),
            significant(off_px(&place, 10)),
        ];
        std::iter::once(name.to_owned()).chain(figures).collect()
    });
    let rows = table(&["path", "segments for ¼ px", "off with 10, px"], rows);
    format!(
        "## Segments that a projection bends

Gebbie & Bailey draw a decal as 10 × 10 sub-quads, whose edges a projection bends. Paths as long as K, or as the eye's
distance in the dome, at a rim of 540 px.
{rows}"
    )
}

type Path = Box<dyn Fn(f64) -> [f64; 2]>;

fn paths() -> [(&'static str, Path); 4] {
    let px = |at: [f64; 2]| at.map(|at| RIM_PX * at);
    [
        (
            "hyperbolic, from the focus outwards",
            Box::new(move |share| px(hyperbolic_polar([share * K, 0.0], K))),
        ),
        (
            "hyperbolic, past the focus",
            Box::new(move |share| px(hyperbolic_polar([(share - 0.5) * K, 0.25 * K], K))),
        ),
        (
            "hyperbolic by Cartesian coordinates, past the focus",
            Box::new(move |share| {
                px([(share - 0.5) * K, 0.25 * K].map(|at| hyperbolic_cartesian(at, K)))
            }),
        ),
        (
            "dome, across the view",
            Box::new(move |share| px(dome(DVec3::new(share, 0.0, -1.0)))),
        ),
    ]
}

#[test]
fn segments_are_as_many_as_the_second_derivative_says() {
    let [(_, outwards), _, _, (_, across)] = paths();
    // f'' = 1080 / K² at the focus: k = √540 = 23.2 for a quarter of a pixel.
    assert!(
        (22..=24).contains(&segments(&outwards)),
        "{}",
        segments(&outwards)
    );
    assert!(
        (off_px(&outwards, 10) - 1.17).abs() < 0.02,
        "{}",
        off_px(&outwards, 10)
    );
    assert!(
        (9..=12).contains(&segments(&across)),
        "{}",
        segments(&across)
    );
    assert!(
        (off_px(&across, 10) - 0.27).abs() < 0.02,
        "{}",
        off_px(&across, 10)
    );
    // Negative control: a straight map needs one.
    assert_eq!(segments(|share| [RIM_PX * share, 0.0]), 1);
}
