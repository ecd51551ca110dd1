// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reference: which triangle of a mesh a pixel's ray meets first, in `f64`.
//!
//! Each ray is intersected with the triangles whose box on the picture holds its place. A pixel may show another
//! triangle than its ray meets, if that triangle has a border within [`BAND_PX`] and nothing hides it there. Every
//! other difference is an error.

use crate::grid::GridCamera;
use crate::mesh::Mesh;
use crate::rays::{
    BAND_PX, EQUAL_DEPTH, Judged, around, centres, distance_to_triangle, judge_points,
};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A side of a tile of the picture, whose triangles are listed.
const TILE_PX: u32 = 8;
/// Beyond every place that a judged pixel looks at.
const MARGIN_PX: f64 = 2.0 * BAND_PX;

/// What a ray meets.
#[derive(Debug, Clone, Copy)]
struct Hit {
    /// From 1, as it is drawn.
    number: u32,
    /// Distance along the view's axis, metres.
    away_m: f64,
}

/// A mesh and its view, for rays.
pub struct MeshRays<'a> {
    mesh: &'a Mesh,
    view: GridCamera,
    size: [u32; 2],
    /// On the picture, and away from the eye, of each vertex.
    places: Vec<(DVec2, f64)>,
    /// Indices of triangles by tile, row by row.
    tiles: Vec<Vec<u32>>,
}

impl<'a> MeshRays<'a> {
    /// - `side`: of the square picture, pixels
    pub fn new(mesh: &'a Mesh, view: GridCamera, side: u32) -> Self {
        let size = [side; 2];
        let project = |place: &DVec3| view.project(*place, size);
        let mut rays = Self {
            places: mesh.vertices.iter().map(project).collect(),
            tiles: vec![Vec::new(); (side.div_ceil(TILE_PX) as usize).pow(2)],
            mesh,
            view,
            size,
        };
        for (index, corners) in (0..).zip(&mesh.triangles) {
            let at = corners.map(|corner| rays.places[corner as usize].0);
            let low = at[0].min(at[1]).min(at[2]) - MARGIN_PX;
            let high = at[0].max(at[1]).max(at[2]) + MARGIN_PX;
            let ([left, top], [right, bottom]) = (rays.tile_of(low), rays.tile_of(high));
            for row in top..=bottom {
                for column in left..=right {
                    let tile = rays.tile(column, row);
                    rays.tiles[tile].push(index);
                }
            }
        }
        rays
    }

    fn tile(&self, column: u32, row: u32) -> usize {
        (row * self.size[0].div_ceil(TILE_PX) + column) as usize
    }

    /// Column and row of the tile of a place, or of the next one to it.
    fn tile_of(&self, at: DVec2) -> [u32; 2] {
        let last = self.size[0].div_ceil(TILE_PX) - 1;
        #[allow(
            clippy::cast_possible_truncation,
            reason = "held between 0 and the last tile"
        )]
        let tile = |along: f64| (along / f64::from(TILE_PX)).clamp(0.0, f64::from(last)) as u32;
        [tile(at.x), tile(at.y)]
    }

    /// The first triangle on the ray through a place of the picture.
    fn meet(&self, at_px: DVec2) -> Option<Hit> {
        let along = self.view.direction(at_px, self.size);
        let [column, row] = self.tile_of(at_px);
        let listed = &self.tiles[self.tile(column, row)];
        let hits = listed.iter().filter_map(|&index| {
            let corners = self.mesh.corners(index as usize);
            let away_m = meet(self.view.eye, along, corners)?;
            Some(Hit {
                number: index + 1,
                away_m,
            })
        });
        hits.min_by(|a, b| a.away_m.total_cmp(&b.away_m))
    }

    /// How far what a place of the picture shows is along the view's axis, metres.
    pub fn away_m(&self, at_px: DVec2) -> Option<f64> {
        Some(self.meet(at_px)?.away_m)
    }

    /// Numbers at the middles of all pixels, 0 for none.
    pub fn picture(&self) -> Vec<u32> {
        let places: Vec<DVec2> = centres(self.size).collect();
        let number = |at: &DVec2| self.meet(*at).map_or(0, |hit| hit.number);
        places.par_iter().map(number).collect()
    }

    /// Holds a picture of triangles' numbers against the rays.
    ///
    /// - `truth`: [`MeshRays::picture`]
    pub fn judge(&self, numbers: &[u32], truth: &[u32]) -> Judged {
        let mut judged = Judged::default();
        let pixels = centres(self.size).zip(numbers.iter().zip(truth));
        for (at, (&shown, &met)) in pixels {
            judged.add(shown, met, || {
                self.may_show(at, shown..shown.saturating_add(1))
            });
        }
        judged
    }

    /// Holds a picture of vertices' numbers against their projections.
    pub fn judge_points(&self, numbers: &[u32]) -> Judged {
        judge_points(numbers, self.size, &self.places)
    }

    /// Whether the border of one of these triangles passes within the band of a place, and nothing hides it there.
    fn may_show(&self, at: DVec2, shown: std::ops::Range<u32>) -> bool {
        let hits: Vec<Option<Hit>> = around(BAND_PX).map(|off| self.meet(at + off)).collect();
        let number = |hit: &Option<Hit>| hit.map_or(0, |hit| hit.number);
        if hits.iter().any(|hit| shown.contains(&number(hit))) {
            return true;
        }
        let farthest = hits
            .iter()
            .map(|hit| hit.map_or(f64::INFINITY, |hit| hit.away_m))
            .fold(0.0, f64::max);
        shown.into_iter().any(|number| {
            let index = number.checked_sub(1).map(|index| index as usize);
            let corners = index.and_then(|index| self.mesh.triangles.get(index));
            corners.is_some_and(|corners| {
                let places = corners.map(|corner| self.places[corner as usize]);
                let nearest = places.iter().map(|of| of.1).fold(f64::INFINITY, f64::min);
                let is_seen = nearest <= farthest * (1.0 + EQUAL_DEPTH);
                is_seen && distance_to_triangle(at, places.map(|of| of.0)) <= BAND_PX
            })
        })
    }
}

/// Number of a triangle's cell, from 1 on; 0 for none.
fn cell_of(number: u32) -> u32 {
    number.div_ceil(2)
}

/// Holds a picture of cells, each by the number of its first triangle, against the rays of both cuts: which one it
/// is, is the driver's choice.
///
/// - `truths`: [`MeshRays::picture`] of either
pub fn judge_cells(cuts: [&MeshRays<'_>; 2], numbers: &[u32], truths: [&[u32]; 2]) -> Judged {
    let mut judged = Judged::default();
    for (pixel, at) in centres(cuts[0].size).enumerate() {
        let shown = cell_of(numbers[pixel]);
        let mets = truths.map(|truth| cell_of(truth[pixel]));
        let met = if mets[1] == shown { mets[1] } else { mets[0] };
        let halves = match shown {
            0 => 0..1,
            _ => 2 * shown - 1..2 * shown + 1,
        };
        judged.add(shown, met, || {
            cuts.iter().any(|cut| cut.may_show(at, halves.clone()))
        });
    }
    judged
}

/// How far along a ray from `eye` it meets a triangle.
fn meet(eye: DVec3, along: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    // Rounding must not open a crack between neighbours: the band has a pixel's share anyway.
    const SLACK: f64 = 1e-9;
    let (first, second) = (b - a, c - a);
    let across = along.cross(second);
    let scale = first.dot(across).recip();
    let from = eye - a;
    let u = from.dot(across) * scale;
    let turned = from.cross(first);
    let v = along.dot(turned) * scale;
    let away = second.dot(turned) * scale;
    // What is seen edge on, or is no triangle, has no number that is finite here.
    let is_met = u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK && away > 0.0;
    (is_met && away.is_finite()).then_some(away)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Cut;

    /// A square of 2 m of 4 × 4 cells, straight in front of the eye.
    fn square(cut: Cut) -> (Mesh, GridCamera) {
        let place = |index: u32| 0.5 * f64::from(index) - 1.0;
        let all = (0..5).flat_map(|row| (0..5).map(move |column| (column, row)));
        let vertices = all.map(|(x, y)| DVec3::new(place(x), 0.0, place(y)));
        let mesh = Mesh::new(vertices.collect(), 4, |_, _| cut);
        let eye = DVec3::new(0.0, -4.0, 0.0);
        (mesh, GridCamera::looking(eye, DVec3::ZERO, 0.5))
    }

    #[test]
    fn a_square_is_seen_where_it_is_and_a_wrong_pixel_is_noticed() {
        let (mesh, view) = square(Cut::Published);
        let rays = MeshRays::new(&mesh, view, 64);
        let truth = rays.picture();
        // 2 m of the 4 that are seen.
        assert_eq!(truth.iter().filter(|number| **number > 0).count(), 32 * 32);
        // Rows go up: the first cell is at the lower left.
        assert_eq!(cell_of(truth[47 * 64 + 16]), 1);
        assert_eq!(rays.judge(&truth, &truth).mismatched, 0);
        for (pixel, wrong) in [(47 * 64 + 16, 0), (47 * 64 + 20, 32), (0, 1)] {
            let mut numbers = truth.clone();
            numbers[pixel] = wrong;
            let judged = rays.judge(&numbers, &truth);
            assert_eq!(judged.mismatched, 1, "{pixel} {wrong}");
        }
    }

    #[test]
    fn cells_may_be_cut_either_way_and_another_cell_is_noticed() {
        let [(one, view), (other, _)] = [Cut::Published, Cut::Other].map(square);
        let cuts = [&one, &other].map(|mesh| MeshRays::new(mesh, view, 64));
        let truths = cuts.each_ref().map(MeshRays::picture);
        let judge =
            |numbers: &[u32]| judge_cells([&cuts[0], &cuts[1]], numbers, [&truths[0], &truths[1]]);
        assert_ne!(truths[0], truths[1]);
        let mut numbers = truths[1].clone();
        assert_eq!(judge(&numbers).mismatched, 0);
        numbers[47 * 64 + 20] += 2;
        assert_eq!(judge(&numbers).mismatched, 1);
    }
}
