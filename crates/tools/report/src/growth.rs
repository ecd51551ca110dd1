// SPDX-License-Identifier: MIT OR Apache-2.0
//! `growth.csv` as curves: what a mesh costs by the vertices of its outline, one curve per shape.

use terrafill_results::legacy::{GrowthRow, Spread, spread};

/// The ratio's sizes, vertices.
pub(crate) const RATIO_FROM: f64 = 1e5;
/// See [`RATIO_FROM`].
pub(crate) const RATIO_TO: f64 = 1e6;
/// Largest ratio allowed: n log n comes to 12 between the two sizes.
pub(crate) const STEEPEST_RATIO: f64 = 12.0;
/// A shape has about the vertices asked for; within this share it is that size.
const SAME_SIZE: f64 = 0.01;

/// One shape.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GrowthCurve {
    pub(crate) shape: String,
    /// Vertices and milliseconds, by rising vertices.
    pub(crate) points: Vec<(f64, Spread)>,
}

impl GrowthCurve {
    /// Cost at about so many vertices.
    pub(crate) fn near(&self, vertices: f64) -> Option<Spread> {
        let at = |point: &&(f64, Spread)| (point.0 / vertices - 1.0).abs() <= SAME_SIZE;
        self.points.iter().find(at).map(|point| point.1)
    }

    /// How many times as much [`RATIO_TO`] vertices cost as [`RATIO_FROM`].
    pub(crate) fn ratio(&self) -> Option<f64> {
        Some(self.near(RATIO_TO)?.median / self.near(RATIO_FROM)?.median)
    }
}

/// Curves in the order in which their shapes first appear.
pub(crate) fn curves(rows: &[GrowthRow]) -> Vec<GrowthCurve> {
    let mut shapes: Vec<&str> = Vec::new();
    for row in rows {
        if !shapes.contains(&row.shape.as_str()) {
            shapes.push(&row.shape);
        }
    }
    shapes
        .into_iter()
        .map(|shape| GrowthCurve {
            shape: shape.to_owned(),
            points: points(rows.iter().filter(|row| row.shape == shape)),
        })
        .collect()
}

fn points<'a>(rows: impl Iterator<Item = &'a GrowthRow>) -> Vec<(f64, Spread)> {
    let mut rows: Vec<&GrowthRow> = rows.collect();
    rows.sort_by_key(|row| row.outline_vertices);
    rows.chunk_by(|a, b| a.outline_vertices == b.outline_vertices)
        .filter_map(|same| {
            let times: Vec<f64> = same.iter().map(|row| row.mesh_cpu_ms).collect();
            Some((same[0].outline_vertices as f64, spread(&times)?))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(shape: &str, outline_vertices: u64, mesh_cpu_ms: f64) -> GrowthRow {
        GrowthRow {
            shape: shape.to_owned(),
            outline_vertices,
            repetition: 0,
            mesh_cpu_ms,
        }
    }

    #[test]
    fn the_ratio_is_of_medians_at_about_the_two_sizes() {
        let rows = [
            row("holes", 1_000_004, 700.0),
            row("holes", 100_004, 70.0),
            row("holes", 1_000_004, 600.0),
            row("holes", 100_004, 50.0),
            row("comb", 100_000, 50.0),
            row("holes", 1_000_004, 9_000.0),
            row("holes", 100_004, 60.0),
        ];
        let curves = curves(&rows);
        assert_eq!(curves[0].shape, "holes");
        assert_eq!(curves[0].points.len(), 2);
        assert_eq!(curves[0].ratio(), Some(700.0 / 60.0));
        // Twin: without the larger size there is no ratio, rather than one of something else.
        assert_eq!(curves[1].ratio(), None);
        let rows = [row("comb", 100_000, 5.0), row("comb", 900_000, 50.0)];
        assert_eq!(super::curves(&rows)[0].ratio(), None);
    }
}
