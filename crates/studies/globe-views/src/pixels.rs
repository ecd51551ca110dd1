// SPDX-License-Identifier: MIT OR Apache-2.0
//! Figures of a picture's pixels, and of what a pixel's ray meets.

use glam::DVec3;
use terrafill_results::quantile;
use terrafill_study::Figures;

/// How far a triangle's corner may be from where it is, along each axis: a device keeps them in steps of 1/256 px.
pub const SNAPPED_PX: f64 = 1.0 / 256.0;

/// Figures of a picture's pixels; none of those that nothing has.
///
/// - `of`: name, values, share of the pixels that does not exceed it
pub fn quantiles(of: &[(&'static str, &Vec<f64>, f64)]) -> Figures {
    let figures = of.iter();
    figures
        .filter_map(|(name, values, share)| Some((*name, quantile(values, *share)?)))
        .collect()
}

/// Shares of a triangle's corners at a point of it, which add up to 1.
pub fn shares([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let share = |from: DVec3, to: DVec3| {
        (from - point).cross(to - point).dot(normal) / normal.length_squared()
    };
    [share(b, c), share(c, a), share(a, b)]
}

/// A pixel and those beside it, by their numbers row by row.
///
/// - `count`: pixels of the image, rows of `width`
pub fn around(pixel: usize, width: usize, count: usize) -> impl Iterator<Item = usize> {
    let (row, column) = (pixel / width, pixel % width);
    let rows = row.saturating_sub(1)..(row + 2).min(count / width);
    rows.flat_map(move |row| {
        let columns = column.saturating_sub(1)..(column + 2).min(width);
        columns.map(move |column| row * width + column)
    })
}
