// SPDX-License-Identifier: MIT OR Apache-2.0
//! The preprocessing: layers by longitude and latitude become faces of cubes, bicubic, or pictures by angles of the same
//! density. And what a device makes of their texels: bilinear, in `f64`, with how far a device may be off that.

use super::sources::{Picture, Sources, byte, uv};
use super::way::{Layer, Shading};
use crate::cube::{along_face, face_of, on_cube};
use glam::DVec3;
use rayon::prelude::*;

/// How far a device may be off a texel's place: WebGPU's backends have 8 bits between texels along each axis.
const PLACE_TEXELS: f64 = 2.0 / 256.0;
/// A device that filters in bytes rounds after each of three steps.
const ROUNDED: f64 = 1.5 / 255.0;
/// By which WGSL allows `atan2` to be off, of its value.
const ATAN2: f64 = 4096.0 / 16_777_216.0;
/// How far over an edge of a face: any share of a texel.
const BEYOND: f64 = 1e-6;

/// Texels of one layer: of six faces, or of one picture twice as wide as high.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Texels {
    pub(crate) is_cube: bool,
    /// Columns, and rows of a face or of the picture.
    pub(crate) size: [u32; 2],
    pub(crate) texels: Vec<[u8; 4]>,
}

/// A value, 0 … 1, and how far a device's may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Looked {
    pub(crate) value: [f64; 4],
    pub(crate) doubt: [f64; 4],
}

/// All layers as shaders read them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Pictures {
    cubes: Vec<Texels>,
    maps: Vec<Texels>,
}

impl Pictures {
    /// - `face`: texels along a side of a cube's face; pictures by angles have four times as many across, which is as
    ///   dense along the equator
    pub(crate) fn new(sources: &Sources, face: u32) -> Self {
        let bumps = sources.bumps();
        let of = |layer: Layer, n: DVec3, place: [f64; 2]| match layer {
            // Made before it becomes a cube, so that its tangents are along parallels.
            Layer::Bumps => bumps.bicubic_at(place),
            _ => sources.value_at(layer, n, place),
        };
        // The same for all layers.
        let texels = (0..6 * face * face).into_par_iter();
        let places: Vec<[f64; 2]> = texels.map(|at| uv(of_texel(face, at))).collect();
        let cube = |layer| Texels::cube(face, |at, n| of(layer, n, places[at as usize]));
        let map = |layer| Texels {
            is_cube: false,
            size: [4 * face, 2 * face],
            texels: Picture::of([4 * face, 2 * face], |n, at| of(layer, n, at)).texels,
        };
        Self {
            cubes: Layer::ALL.map(cube).to_vec(),
            maps: Layer::ALL[..4].iter().map(|layer| map(*layer)).collect(),
        }
    }

    /// Those that a way to shade reads, in the order of [`Layer`] to the lights of night.
    pub(crate) fn read_by(&self, shading: Shading) -> [&Texels; 4] {
        let all = if shading.by_angles {
            &self.maps
        } else {
            &self.cubes
        };
        let bumps = if shading.is_object_space {
            Layer::Bent
        } else {
            Layer::Bumps
        };
        [Layer::Base, bumps, Layer::Clouds, Layer::Night].map(|layer| &all[layer as usize])
    }
}

/// The middle of a texel of a face, −1 … 1.
fn middle(at: u32, side: u32) -> f64 {
    (2.0 * f64::from(at) + 1.0) / f64::from(side) - 1.0
}

/// Direction of a texel of a cube, of length 1: face by face, row by row.
fn of_texel(side: u32, at: u32) -> DVec3 {
    let (face, at) = (at / (side * side), at % (side * side));
    let place = [at % side, at / side].map(|at| middle(at, side));
    on_cube(face, place).normalize()
}

impl Texels {
    /// - `of`: from a texel's number and direction
    fn cube(side: u32, of: impl Fn(u32, DVec3) -> [f64; 4] + Sync) -> Self {
        let texels = (0..6 * side * side).into_par_iter();
        let texels = texels.map(|at| of(at, of_texel(side, at)).map(byte));
        Self {
            is_cube: true,
            size: [side; 2],
            texels: texels.collect(),
        }
    }

    /// As a sampler filters it: bilinear, over edges of faces and round in longitude.
    pub(crate) fn bilinear(&self, n: DVec3) -> Looked {
        if self.is_cube {
            self.of_cube(n)
        } else {
            self.of_map(n)
        }
    }

    fn of_cube(&self, n: DVec3) -> Looked {
        let face = face_of(n);
        let [s, t, out] = along_face(face, n);
        let (place, [at, below]) = self.place([s / out, t / out].map(|at| 0.5 * at + 0.5));
        let last = i64::from(self.size[0]) - 1;
        if (0..last).contains(&at) && (0..last).contains(&below) {
            let first = (i64::from(face) * (last + 1) + below) * (last + 1) + at;
            let row = |first: i64| usize::try_from(first).map_or(&[][..], |at| &self.texels[at..]);
            let (row, next) = (row(first), row(first + last + 1));
            return among([row[0], row[1], next[0], next[1]], place, PLACE_TEXELS);
        }
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| [at + x, below + y]);
        let texels = corners.map(|[column, row]| self.of_face(face, column, row));
        mixed(texels, place, PLACE_TEXELS)
    }

    fn of_map(&self, n: DVec3) -> Looked {
        let [u, v] = uv(n);
        let (place, [at, below]) = self.place([u, v]);
        let [width, height] = self.size.map(i64::from);
        let texel = |column: i64, row: i64| {
            let at = row.clamp(0, height - 1) * width + column.rem_euclid(width);
            self.texels[usize::try_from(at).unwrap_or(0)]
        };
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]];
        let texels = corners.map(|[x, y]| texel(at + x, below + y));
        // What `atan2` may be off, in texels of either axis.
        let angles = [(u - 0.5).abs(), (v - 0.5).abs()];
        let off = angles[0] * f64::from(self.size[0]) + angles[1] * f64::from(self.size[1]);
        among(texels, place, PLACE_TEXELS + ATAN2 * off)
    }

    /// Where between the four texels about a place, 0 … 1, and the first of them.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "some thousands of columns and rows"
    )]
    fn place(&self, uv: [f64; 2]) -> ([f64; 2], [i64; 2]) {
        let at = [0, 1].map(|axis| uv[axis] * f64::from(self.size[axis]) - 0.5);
        (at.map(|at| at - at.floor()), at.map(|at| at.floor() as i64))
    }

    /// A texel of a face, or of its neighbour beside an edge; `None` beyond a corner, where no texel is.
    fn of_face(&self, face: u32, column: i64, row: i64) -> Option<[u8; 4]> {
        let side = self.size[0];
        let is_in = [column, row].map(|at| (0..i64::from(side)).contains(&at));
        let [column_, row_] = [column, row].map(|at| {
            let within = at.clamp(0, i64::from(side) - 1);
            u32::try_from(within).unwrap_or(0)
        });
        let number = |face: u32, column: u32, row: u32| {
            self.texels[((face * side + row) * side + column) as usize]
        };
        match is_in {
            [true, true] => Some(number(face, column_, row_)),
            [false, false] => None,
            _ => {
                // Just over the edge, level with the texel's middle.
                let over = |at: i64, within: u32| {
                    if at < 0 {
                        -1.0 - BEYOND
                    } else if at >= i64::from(side) {
                        1.0 + BEYOND
                    } else {
                        middle(within, side)
                    }
                };
                let d = on_cube(face, [over(column, column_), over(row, row_)]);
                let other = face_of(d);
                let [s, t, out] = along_face(other, d);
                #[allow(clippy::cast_possible_truncation, reason = "0 … side")]
                let [column, row] = [s / out, t / out].map(|at| {
                    let at = (0.5 * at + 0.5) * f64::from(side);
                    (at.max(0.0) as u32).min(side - 1)
                });
                Some(number(other, column, row))
            }
        }
    }
}

/// Bilinear between four texels.
///
/// - `off`: by how many texels the place may be off, both axes together
fn among(texels: [[u8; 4]; 4], [x, y]: [f64; 2], off: f64) -> Looked {
    let mut looked = Looked {
        value: [0.0; 4],
        doubt: [0.0; 4],
    };
    let [first, second, third, fourth] = texels;
    for channel in 0..4 {
        let bytes = (
            first[channel],
            second[channel],
            third[channel],
            fourth[channel],
        );
        let highest = bytes.0.max(bytes.1).max(bytes.2.max(bytes.3));
        let lowest = bytes.0.min(bytes.1).min(bytes.2.min(bytes.3));
        let share = |byte: u8| f64::from(byte) / 255.0;
        let (a, b, c, d) = (
            share(bytes.0),
            share(bytes.1),
            share(bytes.2),
            share(bytes.3),
        );
        let spread = share(highest) - share(lowest);
        let row = a + x * (b - a);
        looked.value[channel] = row + y * (c + x * (d - c) - row);
        looked.doubt[channel] = spread * off + spread.min(ROUNDED);
    }
    looked
}

/// The same where one may be beyond a corner: the others' mean then.
///
/// - `off`: by how many texels the place may be off, both axes together
fn mixed(texels: [Option<[u8; 4]>; 4], [x, y]: [f64; 2], off: f64) -> Looked {
    let mut looked = Looked {
        value: [0.0; 4],
        doubt: [0.0; 4],
    };
    let has_corner = texels.contains(&None);
    for channel in 0..4 {
        let of = texels.map(|texel| texel.map(|texel| f64::from(texel[channel]) / 255.0));
        let known = of.iter().flatten();
        let mean = known.clone().sum::<f64>() / known.clone().count() as f64;
        let [a, b, c, d] = of.map(|value| value.unwrap_or(mean));
        let highest = known.clone().copied().fold(f64::NEG_INFINITY, f64::max);
        let spread = highest - known.copied().fold(f64::INFINITY, f64::min);
        let row = a + x * (b - a);
        looked.value[channel] = row + y * (c + x * (d - c) - row);
        // Beyond a corner a device may weigh three as it likes.
        let all = if has_corner { spread } else { 0.0 };
        looked.doubt[channel] = spread * off + spread.min(ROUNDED) + all;
    }
    looked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_texels_of_a_cube_is_what_it_was_made_from_over_edges_and_corners() {
        let wave = |n: DVec3| {
            [
                0.5 + 0.4 * n.x,
                0.5 + 0.4 * n.y * n.z,
                0.5 - 0.4 * n.z,
                0.25,
            ]
        };
        let mut cube = Texels::cube(64, |_, n| wave(n));
        let map = Texels {
            is_cube: false,
            size: [256, 128],
            texels: Picture::of([256, 128], |n, _| wave(n)).texels,
        };
        let places = (0..400_u32).map(|i| {
            let at = f64::from(i);
            DVec3::new(at.sin(), (1.7 * at).cos(), (0.9 * at).sin())
        });
        // Along an edge, and in a corner, as well.
        let edges = [[1.0, 0.3], [-0.999, 0.7], [1.0, 1.0], [0.2, -1.0]];
        let edges = (0..6).flat_map(|face| edges.map(|place| on_cube(face, place)));
        for n in places.chain(edges).map(DVec3::normalize) {
            for texels in [&cube, &map] {
                let looked = texels.bilinear(n);
                for (value, exact) in looked.value.iter().zip(wave(n)) {
                    assert!((value - exact).abs() < 0.006, "{n} {value} {exact}");
                }
                assert!(
                    looked.doubt[3] == 0.0,
                    "where all are the same nothing is in doubt"
                );
            }
        }
        // Negative control: a face that is turned is found.
        let texels = cube.texels.len() / 6;
        cube.texels[..texels].reverse();
        let n = on_cube(0, [0.5, 0.1]).normalize();
        assert!((cube.bilinear(n).value[2] - wave(n)[2]).abs() > 0.05);
    }
}
