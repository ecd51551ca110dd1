// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes the surface of a field that is above 0 inside: marching tetrahedra (Doi and Koide, 1991).
//!
//! A box is divided into cubes, each into six tetrahedra along its diagonal. In a tetrahedron one or two triangles
//! separate the corners inside from those outside.

use glam::{DVec3, UVec3};
use std::collections::BTreeMap;

/// Triangles without an order of their own, corners counter-clockwise from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct IrregularMesh {
    /// Metres.
    pub vertices: Vec<DVec3>,
    /// Corners by their index.
    pub triangles: Vec<[u32; 3]>,
}

/// Orders in which a path along the axes reaches a cube's far corner: a tetrahedron each.
const PATHS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

/// Meshes the surface in a box.
///
/// - `step`: a side of a cube, metres
/// - `field`: above 0 inside
/// - `onto`: moves a place near the surface onto it
pub fn mesh(
    [low, high]: [DVec3; 2],
    step: f64,
    field: impl Fn(DVec3) -> f64,
    onto: impl Fn(DVec3) -> DVec3,
) -> IrregularMesh {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a box is some steps wide"
    )]
    let counts = ((high - low) / step).ceil().as_uvec3();
    let corners = counts + 1;
    let number = |at: UVec3| (at.z * corners.y + at.y) * corners.x + at.x;
    let place = |at: UVec3| low + at.as_dvec3() * step;
    let all = |counts: UVec3| {
        (0..counts.z).flat_map(move |z| {
            (0..counts.y).flat_map(move |y| (0..counts.x).map(move |x| UVec3::new(x, y, z)))
        })
    };
    let values: Vec<f64> = all(corners).map(|at| field(place(at))).collect();
    let value = |at: UVec3| values[number(at) as usize];
    let mut made = IrregularMesh {
        vertices: Vec::new(),
        triangles: Vec::new(),
    };
    let mut known = BTreeMap::new();
    for cube in all(counts) {
        for path in PATHS {
            let mut corner = cube;
            let mut tetrahedron = [cube; 4];
            for (index, axis) in path.into_iter().enumerate() {
                corner[axis] += 1;
                tetrahedron[index + 1] = corner;
            }
            let is_inside = tetrahedron.map(|at| value(at) > 0.0);
            let inside: Vec<UVec3> = chosen(tetrahedron, is_inside, true);
            let outside: Vec<UVec3> = chosen(tetrahedron, is_inside, false);
            let mut cut = |from: UVec3, to: UVec3| {
                let (first, second) = (number(from).min(number(to)), number(from).max(number(to)));
                *known.entry((first, second)).or_insert_with(|| {
                    let share = value(from) / (value(from) - value(to));
                    made.vertices.push(onto(place(from).lerp(place(to), share)));
                    u32::try_from(made.vertices.len() - 1).unwrap_or(u32::MAX)
                })
            };
            let found: Vec<[u32; 3]> = match (inside.as_slice(), outside.as_slice()) {
                ([one], [a, b, c]) | ([a, b, c], [one]) => {
                    vec![[cut(*one, *a), cut(*one, *b), cut(*one, *c)]]
                }
                ([a, b], [c, d]) => {
                    let around = [cut(*a, *c), cut(*a, *d), cut(*b, *d), cut(*b, *c)];
                    let [first, second, third, fourth] = around;
                    vec![[first, second, third], [first, third, fourth]]
                }
                _ => continue,
            };
            let middle =
                |of: &[UVec3]| of.iter().map(|at| place(*at)).sum::<DVec3>() / of.len() as f64;
            let outward = middle(&outside) - middle(&inside);
            for mut triangle in found {
                let [a, b, c] = triangle.map(|corner| made.vertices[corner as usize]);
                if (b - a).cross(c - a).dot(outward) < 0.0 {
                    triangle.swap(1, 2);
                }
                made.triangles.push(triangle);
            }
        }
    }
    made
}

fn chosen(corners: [UVec3; 4], is_inside: [bool; 4], wanted: bool) -> Vec<UVec3> {
    let both = corners.into_iter().zip(is_inside);
    both.filter(|(_, is)| *is == wanted)
        .map(|(at, _)| at)
        .collect()
}
