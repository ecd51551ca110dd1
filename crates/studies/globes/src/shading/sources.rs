// SPDX-License-Identifier: MIT OR Apache-2.0
//! The five layers as they are published, by longitude and latitude, and what lies between their texels: bicubic, as
//! the paper's preprocessing has it. Directions are geodetic normals along ECEF axes.

use super::way::{KIND, Layer};
use glam::DVec3;
use image::DynamicImage;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use terrafill_globe_views::Opened;
use terrafill_results::RunInput;
use terrafill_scene::Scene;
use terrafill_study::files_read;

const LAYERS: &str = include_str!("../../layers.toml");

/// Full white of the elevation, in radii of the body: about 20 times the height of its highest summits. Slopes as they
/// are turn no normal by a step of 8 bits.
const EXAGGERATED: f64 = 0.02;

/// Texels of `N` bytes, rows from the north, columns from −180°.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Picture<const N: usize> {
    pub(crate) size: [u32; 2],
    pub(crate) texels: Vec<[u8; N]>,
}

/// The layers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Sources {
    pub(crate) colour: Picture<3>,
    pub(crate) elevation: Picture<1>,
    pub(crate) clouds: Picture<3>,
    pub(crate) night: Picture<3>,
    pub(crate) water: Picture<1>,
}

/// U and V of a direction, 0 … 1; V from the north.
pub(crate) fn uv(direction: DVec3) -> [f64; 2] {
    let across = direction.x.hypot(direction.y);
    [
        0.5 + direction.y.atan2(direction.x) / TAU,
        0.5 - direction.z.atan2(across) / PI,
    ]
}

/// The direction of U and V.
pub(crate) fn of_uv([u, v]: [f64; 2]) -> DVec3 {
    let (sin, cos) = (TAU * (u - 0.5)).sin_cos();
    let (up, across) = (PI * (0.5 - v)).sin_cos();
    DVec3::new(across * cos, across * sin, up)
}

/// Weights of the four texels about a place, by Catmull and Rom; `t` is 0 at the second and 1 at the third.
fn weights(t: f64) -> [f64; 4] {
    let (s, square) = (1.0 - t, t * t);
    [
        -0.5 * t * s * s,
        1.0 + square * (1.5 * t - 2.5),
        0.5 * t * (1.0 + t * (4.0 - 3.0 * t)),
        -0.5 * square * s,
    ]
}

impl<const N: usize> Picture<N> {
    /// What `of` gives in each texel's middle, by its direction and its U and V.
    pub(crate) fn of(size: [u32; 2], of: impl Fn(DVec3, [f64; 2]) -> [f64; N] + Sync) -> Self {
        use rayon::prelude::*;
        let [width, height] = size;
        let texels = (0..width * height).into_par_iter().map(|at| {
            let place = [(at % width, width), (at / width, height)];
            let place = place.map(|(at, of)| (f64::from(at) + 0.5) / f64::from(of));
            of(of_uv(place), place).map(byte)
        });
        Self {
            size,
            texels: texels.collect(),
        }
    }

    /// Texels of a row that four columns have; rows beyond a pole are those before it, half a turn on.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "some thousands of columns and rows"
    )]
    fn texels(&self, row: i64, columns: [i64; 4]) -> [[u8; N]; 4] {
        let [width, height] = self.size.map(i64::from);
        let (row, turn) = match row {
            row if row < 0 => (-1 - row, width / 2),
            row if row >= height => (2 * height - 1 - row, width / 2),
            row => (row, 0),
        };
        let row = &self.texels[(row * width) as usize..][..width as usize];
        columns.map(|column| {
            let column = column + turn;
            let column = if column < width {
                column
            } else {
                column - width
            };
            row[column as usize]
        })
    }

    /// Bicubic, 0 … 1.
    pub(crate) fn bicubic(&self, direction: DVec3) -> [f64; N] {
        self.bicubic_at(uv(direction))
    }

    /// The same by U and V.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "some thousands of columns and rows"
    )]
    pub(crate) fn bicubic_at(&self, place: [f64; 2]) -> [f64; N] {
        let at = [0, 1].map(|axis| place[axis] * f64::from(self.size[axis]) - 0.5);
        let first = at.map(|at| at.floor() as i64 - 1);
        let [across, down] = at.map(|at| weights(at - at.floor()));
        let columns = [0, 1, 2, 3].map(|i| (first[0] + i).rem_euclid(i64::from(self.size[0])));
        let mut sum = [0.0; N];
        for (row, down) in (first[1]..).zip(down) {
            for (texel, across) in self.texels(row, columns).into_iter().zip(across) {
                for (sum, value) in sum.iter_mut().zip(texel) {
                    *sum += down * across * f64::from(value);
                }
            }
        }
        sum.map(|value| (value / 255.0).clamp(0.0, 1.0))
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "a share of 255 after clamping"
)]
pub(crate) fn byte(value: f64) -> u8 {
    (255.0 * value.clamp(0.0, 1.0)).round() as u8
}

/// East along the parallel, and any direction across at a pole, as the shader takes it.
pub(crate) fn tangent(n: DVec3) -> DVec3 {
    let across = n.x.hypot(n.y);
    if across > 1e-6 {
        DVec3::new(-n.y, n.x, 0.0) / across
    } else {
        DVec3::Y
    }
}

impl Sources {
    /// Those of the data folder, and the files that were read.
    ///
    /// # Errors
    /// What is missing, with how to get it, or is no picture.
    pub(crate) fn read(data_dir: Option<&Path>) -> Result<(Self, Vec<RunInput>), String> {
        let scene = Scene::from_toml(LAYERS, "layers.toml of study globes", data_dir);
        let scene = scene.map_err(|error| error.to_string())?;
        let files = scene.surface.files.iter().map(|file| {
            let picture = image::load_from_memory(&file.bytes);
            picture.map_err(|error| format!("{}: {error}", file.path))
        });
        let pictures: Vec<DynamicImage> = files.collect::<Result<_, String>>()?;
        let [colour, elevation, clouds, night, water] = &pictures[..] else {
            return Err(format!("{} layers, allowed: 5", pictures.len()));
        };
        let sources = Self {
            colour: coloured(colour),
            elevation: grey(elevation),
            clouds: coloured(clouds),
            night: coloured(night),
            water: grey(water),
        };
        Ok((sources, files_read(&scene)))
    }

    /// Elevation in radii of the body, exaggerated.
    fn height(&self, direction: DVec3) -> f64 {
        let [share] = self.elevation.bicubic(direction);
        EXAGGERATED * share
    }

    /// The normal that bumps bend, of length 1. Slopes are taken over two texels of the equator everywhere, so that a
    /// pole is like any other place.
    pub(crate) fn bent(&self, n: DVec3) -> DVec3 {
        let step = TAU / f64::from(self.elevation.size[0]);
        let t = tangent(n);
        let by = step.tan();
        let slope = |along: DVec3| {
            let [there, back] = [by, -by].map(|by| self.height(n + along * by));
            along * ((there - back) / (2.0 * step))
        };
        (n - slope(t) - slope(n.cross(t))).normalize()
    }

    /// A layer between its texels, 0 … 1.
    pub(crate) fn value(&self, layer: Layer, n: DVec3) -> [f64; 4] {
        self.value_at(layer, n, uv(n))
    }

    /// The same where U and V of the direction are known.
    pub(crate) fn value_at(&self, layer: Layer, n: DVec3, place: [f64; 2]) -> [f64; 4] {
        let of_colour = |[r, g, b]: [f64; 3]| [r, g, b, 1.0];
        match layer {
            Layer::Base => {
                let [r, g, b] = self.colour.bicubic_at(place);
                let [water] = self.water.bicubic_at(place);
                [r, g, b, water]
            }
            Layer::Clouds => of_colour(self.clouds.bicubic_at(place)),
            Layer::Night => of_colour(self.night.bicubic_at(place)),
            Layer::Bent => of_colour((0.5 * self.bent(n) + 0.5).to_array()),
            Layer::Bumps => {
                let (t, bent) = (tangent(n), self.bent(n));
                let [x, y, z] = [n, t, n.cross(t)].map(|axis| 0.5 + 0.5 * bent.dot(axis));
                let [elevation] = self.elevation.bicubic_at(place);
                [x, y, z, elevation]
            }
        }
    }

    /// The paper's bump map: shares of normal, tangent and binormal, ½ more than half of each, and the elevation.
    pub(crate) fn bumps(&self) -> Picture<4> {
        Picture::of(self.elevation.size, |n, place| {
            self.value_at(Layer::Bumps, n, place)
        })
    }
}

fn coloured(picture: &DynamicImage) -> Picture<3> {
    let picture = picture.to_rgb8();
    Picture {
        size: picture.dimensions().into(),
        texels: picture.pixels().map(|pixel| pixel.0).collect(),
    }
}

fn grey(picture: &DynamicImage) -> Picture<1> {
    let picture = picture.to_luma8();
    Picture {
        size: picture.dimensions().into(),
        texels: picture.pixels().map(|pixel| pixel.0).collect(),
    }
}

/// Whether there is a surface to shade, and layers for it.
///
/// # Errors
/// What is missing.
pub(crate) fn layers(
    opened: &Opened,
    data_dir: Option<&Path>,
) -> Result<(Sources, Vec<RunInput>), String> {
    if !opened.has(KIND) {
        return Err(format!("there is no surface of the kind {KIND:?}"));
    }
    Sources::read(data_dir)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_texels_is_a_cubic_and_poles_go_over_to_the_other_side() {
        for t in [0.0, 0.25, 0.5, 1.0] {
            let w = weights(t);
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // Exact for squares, as Catmull and Rom's is.
            let square: f64 = (-1..3_i32)
                .zip(w)
                .map(|(at, w)| w * f64::from(at * at))
                .sum();
            assert!((square - t * t).abs() < 1e-12, "{t}");
        }
        let wave = |n: DVec3| [0.5 + 0.3 * n.x * n.y + 0.2 * n.z];
        let picture = Picture::of([256, 128], |n, _| wave(n));
        for i in 0..200_u32 {
            let at = f64::from(i);
            let n = DVec3::new(at.sin(), (1.7 * at).cos(), (0.9 * at).sin()).normalize();
            let off = (picture.bicubic(n)[0] - wave(n)[0]).abs();
            assert!(off < 0.004, "{n} {off}");
            assert!((of_uv(uv(n)) - n).length() < 1e-12);
        }
        for pole in [DVec3::Z, -DVec3::Z] {
            assert!((picture.bicubic(pole)[0] - wave(pole)[0]).abs() < 0.004);
        }
    }

    #[test]
    fn bumps_lean_away_from_what_rises() {
        let flat = Picture::<3>::of([8, 4], |_, _| [0.0; 3]);
        let sources = Sources {
            elevation: Picture::of([256, 128], |n, _| [0.5 + 0.5 * n.x]),
            water: Picture::of([8, 4], |_, _| [0.0]),
            colour: flat.clone(),
            clouds: flat.clone(),
            night: flat,
        };
        for n in [DVec3::Y, DVec3::Z, -DVec3::Z, DVec3::new(0.0, 0.6, 0.8)] {
            let slope = 0.5 * EXAGGERATED;
            let expected = (n - slope * DVec3::X).normalize();
            let off = (sources.bent(n) - expected).length();
            assert!(off < 0.1 * slope, "{n} {off}");
        }
        // Negative control: on the summit nothing leans.
        assert!((sources.bent(DVec3::X) - DVec3::X).length() < 0.1 * EXAGGERATED);
    }
}
