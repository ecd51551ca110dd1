// SPDX-License-Identifier: MIT OR Apache-2.0
//! A closed surface as a square of places (Gu, Gortler and Hoppe, 2002). A mesh is laid on a sphere. The sphere is
//! folded onto an octahedron, whose faces are unfolded onto the square (Praun and Hoppe, 2003).
//!
//! The square's diagonals from middle to middle of its sides are edges of the octahedron, so the cut of a cell there
//! matters.

use crate::distance::{Distances, PLACES};
use crate::mesh::{Cut, Mesh};
use crate::rabbit;
use crate::sphere::Sphere;
use crate::tetrahedra;
use glam::{DVec2, DVec3};

/// A side of the cubes that the mesh is made in, metres.
const STEP_M: f64 = 0.06;
/// Cells around a sample's own that are looked at for the triangle nearest to it.
const AROUND: i64 = 2;

terrafill_results::named! {
    /// How cells are cut.
    #[derive(PartialOrd, Ord)]
    pub enum CellCut {
        /// From (x + 1, y) to (x, y + 1) everywhere, as a strip of the published order cuts.
        Published = "published",
        /// Along the fold of the octahedron in every quarter.
        Fold = "fold",
    }
}

impl CellCut {
    /// - `cells`: a side of the image
    pub fn of(self, cells: u32, column: u32, row: u32) -> Cut {
        let folds_that_way = (column < cells / 2) == (row < cells / 2);
        if self == Self::Published || folds_that_way {
            Cut::Published
        } else {
            Cut::Other
        }
    }
}

/// How places are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stored {
    /// As 32-bit floats.
    Float,
    /// As whole numbers of so many bits over the box of the shape, read as 32-bit floats.
    Bits(u32),
}

impl Stored {
    /// As a condition says it.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Float => "f32".to_owned(),
            Self::Bits(bits) => format!("{bits} bits"),
        }
    }

    fn round(self, places: &mut [DVec3]) {
        let all = || places.iter().copied();
        let low = all().fold(DVec3::INFINITY, DVec3::min);
        let span = all().fold(DVec3::NEG_INFINITY, DVec3::max) - low;
        for place in places {
            if let Self::Bits(bits) = self {
                let steps = f64::from(bits).exp2() - 1.0;
                *place = low + span * ((*place - low) / span * steps).round() / steps;
            }
            *place = place.as_vec3().as_dvec3();
        }
    }
}

/// The irregular mesh that images are made of, on its sphere.
pub fn sphere() -> Sphere {
    let field = |place| rabbit::field(place).0;
    let mesh = tetrahedra::mesh(rabbit::BOX, STEP_M, field, rabbit::onto);
    Sphere::new(mesh, rabbit::direction)
}

/// Direction at a place of the square, both from −1 to 1.
fn direction(at: DVec2) -> DVec3 {
    let z = 1.0 - at.x.abs() - at.y.abs();
    let folded = if z < 0.0 { folded(at) } else { at };
    folded.extend(z).normalize()
}

/// From one half of the octahedron to the other, and back.
fn folded(at: DVec2) -> DVec2 {
    let away = |a: f64, b: f64| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
    DVec2::new(away(at.x, at.y), away(at.y, at.x))
}

/// Place of the square at a direction.
fn place_of(direction: DVec3) -> DVec2 {
    let at = direction / direction.abs().element_sum();
    if at.z < 0.0 {
        folded(at.truncate())
    } else {
        at.truncate()
    }
}

/// Places of an image, metres, row by row, as a device gets them: those of the mesh, moved onto the surface.
///
/// - `cells`: a side of the image, one less than texels
pub fn image(sphere: &Sphere, cells: u32, stored: Stored) -> Vec<DVec3> {
    let at = |index: u32| 2.0 * f64::from(index) / f64::from(cells) - 1.0;
    let all = (0..=cells).flat_map(|row| (0..=cells).map(move |column| (column, row)));
    let place = |(column, row)| {
        let place = sphere.place(direction(DVec2::new(at(column), at(row))));
        rabbit::onto(place)
    };
    let mut places: Vec<DVec3> = all.map(place).collect();
    stored.round(&mut places);
    places
}

/// The surface as triangles of an image cut along its folds.
pub fn rabbit_mesh(cells: u32) -> Mesh {
    let places = image(&sphere(), cells, Stored::Float);
    Mesh::new(places, cells, |column, row| {
        CellCut::Fold.of(cells, column, row)
    })
}

/// Texels of the sides that are not where the one is that they are folded onto: cracks.
pub fn open_texels(places: &[DVec3], cells: u32) -> usize {
    let (last, side) = (cells as usize, cells as usize + 1);
    let at = |column: usize, row: usize| places[row * side + column];
    let is_open = |index: usize, edge: usize| {
        let other = last - index;
        [
            at(index, edge) != at(other, edge),
            at(edge, index) != at(edge, other),
        ]
    };
    let all = (0..side).flat_map(|index| [0, last].map(|edge| is_open(index, edge)));
    all.flatten().filter(|is_open| *is_open).count()
}

/// How far triangles and surface are apart, both ways: places of each triangle from the surface, and vertices of the
/// irregular mesh, which lie on the surface, from the triangles near their direction.
pub fn distances(mesh: &Mesh, cells: u32, sphere: &Sphere) -> Distances {
    let view = rabbit::rabbit_view();
    let mut distances = Distances::default();
    for index in 0..mesh.triangles.len() {
        let corners = mesh.corners(index);
        for weights in PLACES {
            let place: DVec3 = corners.iter().zip(weights).map(|(c, w)| *c * w).sum();
            distances.add(place, rabbit::distance_m(place), &view);
        }
    }
    for (sample, direction) in sphere.mesh.vertices.iter().zip(&sphere.directions) {
        let at = (place_of(*direction) + 1.0) * (0.5 * f64::from(cells));
        let last = i64::from(cells) - 1;
        #[allow(clippy::cast_possible_truncation, reason = "held inside the image")]
        let cell = |along: f64| (along as i64).clamp(0, last);
        let around = |cell: i64| (cell - AROUND).max(0)..=(cell + AROUND).min(last);
        let (columns, rows) = (around(cell(at.x)), around(cell(at.y)));
        let near =
            rows.flat_map(|row| columns.clone().map(move |column| row * (last + 1) + column));
        let least = near
            .flat_map(|cell| [2 * cell, 2 * cell + 1])
            .filter_map(|index| usize::try_from(index).ok())
            .map(|index| from_triangle(*sample, mesh.corners(index)))
            .fold(f64::INFINITY, f64::min);
        distances.add(*sample, least, &view);
    }
    distances
}

/// Distance of a place from a triangle.
fn from_triangle(place: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let is_over = [(a, b), (b, c), (c, a)]
        .into_iter()
        .all(|(from, to)| normal.cross(to - from).dot(place - from) >= 0.0);
    if is_over && normal.length_squared() > 0.0 {
        return (place - a).dot(normal.normalize()).abs();
    }
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| {
        let side = to - from;
        let share = (place - from).dot(side) / side.length_squared();
        // A side without length has no share.
        let share = if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        };
        (place - from - side * share).length()
    });
    sides.into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mesh_is_a_sphere_and_every_triangle_lies_the_right_way_round() {
        let sphere = sphere();
        let [corners, triangles] = [sphere.mesh.vertices.len(), sphere.mesh.triangles.len()];
        // A triangle has three sides, each shared by two.
        assert_eq!(corners + triangles, triangles * 3 / 2 + 2);
        assert_eq!(sphere.turned(), 0);
        let place = sphere.directions[100];
        let found = sphere.place(place);
        assert!(
            (found - sphere.mesh.vertices[100]).length() < 1e-9,
            "{found}"
        );
        // Negative control: two directions exchanged turn triangles.
        let mut wrong = sphere;
        wrong.directions.swap(100, 5_000);
        assert!(wrong.turned() > 0);
    }

    #[test]
    fn an_image_is_closed_and_comes_nearer_with_its_texels() {
        let sphere = sphere();
        let error = |cells, cut: CellCut, stored| {
            let places = image(&sphere, cells, stored);
            assert_eq!(open_texels(&places, cells), 0, "{cells}");
            let mesh = Mesh::new(places, cells, |column, row| cut.of(cells, column, row));
            distances(&mesh, cells, &sphere).figures(1)[1].1
        };
        let [coarse, fine] = [32, 64].map(|cells| error(cells, CellCut::Published, Stored::Float));
        assert!((2.0..4.0).contains(&(coarse / fine)), "{coarse} {fine}");
        assert!(error(64, CellCut::Fold, Stored::Float) < 0.8 * fine);
        assert!(error(64, CellCut::Published, Stored::Bits(6)) > 1.5 * fine);
        // Negative control: a texel of a side that is moved is a crack.
        let mut places = image(&sphere, 32, Stored::Float);
        places[3] += 1e-6;
        assert!(open_texels(&places, 32) > 0);
    }

    #[test]
    fn distances_from_a_triangle_are_those_of_its_nearest_place() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let from = |x, y, z| from_triangle(DVec3::new(x, y, z), triangle);
        assert_eq!(from(0.25, 0.25, 0.5), 0.5);
        assert_eq!(from(-3.0, 0.0, 4.0), 5.0);
        assert!((from(1.0, 1.0, 0.0) - 0.5_f64.sqrt()).abs() < 1e-12);
        // A triangle without area is its sides.
        assert_eq!(from_triangle(DVec3::Z, [DVec3::ZERO; 3]), 1.0);
    }
}
