// SPDX-License-Identifier: MIT OR Apache-2.0
//! Data divided into cells or segments: how finely by formula, what is sent to the device, and its vertices in `f64`.

use crate::place::{Data, Path, RADIUS_M, Shape, axes, direction};
use crate::view::{Eye, Projection, REACH};
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, DVec4};
use terrafill_core::nearest_f32;

/// What no one sees, pixels.
pub(crate) const FINE_PX: f64 = 0.25;
/// Texels along a side of a decal's picture, and parts of a line that pictures tell apart.
pub(crate) const TEXELS: u32 = 1_024;
/// Most cells along a side.
pub(crate) const MAX_CELLS: u32 = 256;
/// How wide lines are drawn, pixels.
pub(crate) const WIDTH_PX: f64 = 2.0;
/// Half a step of `f32` at 1.
const SINGLE: f64 = 1.0 / 16_777_216.0;
/// Bytes of a vertex.
pub(crate) const VERTEX_BYTES: usize = 12;
/// By how much of the eye's height data is lifted where depth is tested.
const LIFT_SHARE: f64 = 1e-3;
/// Places along a side at which formulas are evaluated.
const SAMPLES: u32 = 32;

terrafill_results::named! {
    /// What vertices are about.
    all pub(crate) enum Origin {
        Corner = "corner",
        Centre = "centre",
    }
}

terrafill_results::named! {
    /// Order of the series that stand for sine and cosine.
    all pub(crate) enum Series {
        First = "1",
        Second = "2",
        Full = "14",
    }
}

impl Series {
    /// Sine, and one less cosine.
    fn of(self, x: f64) -> [f64; 2] {
        match self {
            Self::First => [x, 0.0],
            Self::Second => [x, 0.5 * x * x],
            Self::Full => [x.sin(), 1.0 - x.cos()],
        }
    }
}

/// What is drawn, and how.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Divided {
    pub(crate) data: Data,
    pub(crate) eye: Eye,
    /// Along a side, or of a line.
    pub(crate) cells: u32,
    pub(crate) origin: Origin,
    pub(crate) series: Series,
    /// Whether it is drawn behind the depth of the body, lifted by [`lift_m`].
    pub(crate) is_tested: bool,
}

/// A corner of a triangle as drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Corner {
    pub(crate) clip: DVec4,
    /// Of both sides, or of the way.
    pub(crate) share: DVec2,
    /// As of [`Eye::horizon`].
    pub(crate) before: f64,
}

/// Shares of a side at which formulas are evaluated.
fn samples(shape: Shape) -> impl Iterator<Item = DVec2> {
    let rows = if matches!(shape, Shape::Line(_)) {
        0
    } else {
        SAMPLES
    };
    let share = |at: u32| f64::from(at) / f64::from(SAMPLES);
    (0..=rows).flat_map(move |y| (0..=SAMPLES).map(move |x| DVec2::new(share(x), share(y))))
}

/// Pixels that a metre is at most, wherever data is seen.
fn px_per_metre(eye: &Eye, data: &Data) -> f64 {
    let seen = samples(data.shape).filter_map(|share| eye.px_per_metre(data.angles(share)));
    seen.fold(0.0, f64::max)
}

/// By how much data is lifted off the body where depth is tested, metres: the same for every rule of division and every
/// size of the picture.
pub(crate) fn lift_m(eye: &Eye) -> f64 {
    LIFT_SHARE * eye.height_m
}

/// Fewest cells along a side with which nothing is off by more than a quarter of a pixel.
///
/// Linear interpolation of a quadratic is off by half of the sum of λᵢ λⱼ Dᵢⱼ. The weights λ are a place's in its
/// triangle; Dᵢⱼ is the second derivative over the edge between two corners. That is an eighth of D in the middle of an
/// edge, and a sixth in the middle of a triangle whose edges all bend alike. On the globe D is that of places on the body,
/// times the pixels that a metre has at most. In maps it is that of the map, in pixels.
pub(crate) fn cells_by_formula(eye: &Eye, data: &Data) -> u32 {
    let bend_px = match eye.projection {
        Projection::Globe => data.bend() * RADIUS_M * px_per_metre(eye, data),
        _ => samples(data.shape)
            .filter(|share| {
                let place = data.direction(*share) * RADIUS_M;
                eye.horizon().dot(place.extend(1.0)) >= 0.0
            })
            .map(|share| map_bend_px(eye, data, share))
            .fold(0.0, f64::max),
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "held between 1 and the most"
    )]
    let cells = (bend_px / (8.0 * FINE_PX))
        .sqrt()
        .ceil()
        .clamp(1.0, f64::from(MAX_CELLS)) as u32;
    cells
}

/// Eight times the error of interpolating the map at a place, over cells that span all of the data; pixels.
fn map_bend_px(eye: &Eye, data: &Data, share: DVec2) -> f64 {
    const STEP: f64 = 1.0 / 256.0;
    let px = |share: DVec2| {
        let at = data.angles(share);
        eye.pixel(eye.clip(data.direction(share) * RADIUS_M, at))
    };
    let inner = share.clamp(DVec2::splat(STEP), DVec2::splat(1.0 - STEP));
    let second =
        |step: DVec2| (px(inner + step) - 2.0 * px(inner) + px(inner - step)) / (STEP * STEP);
    let [x, y] = [DVec2::X * STEP, DVec2::Y * STEP];
    if matches!(data.shape, Shape::Line(_)) {
        return second(x).length();
    }
    // Edges along both sides and along the diagonal of cells, which may all bend alike.
    let edges = [x, y, x - y].map(|step| second(step).length());
    8.0 / 6.0 * edges.into_iter().fold(0.0, f64::max)
}

/// Twin of `DecalConstants` in `shared/decal.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct DecalConstants {
    columns: [[f32; 4]; 4],
    horizon: [f32; 4],
    right: [f32; 3],
    height: f32,
    up: [f32; 3],
    near: f32,
    forward: [f32; 3],
    radius_m: f32,
    eye: [f32; 3],
    half_px: f32,
    toward: [f32; 3],
    angle: f32,
    focus: [f32; 2],
    size: [f32; 2],
    sin_lat: f32,
    cos_lat: f32,
    tan_half: f32,
    reach: f32,
    half_width_px: f32,
    cells: u32,
    texels: u32,
    projection: u32,
    form: u32,
    series: u32,
    path: u32,
    padding: u32,
}

/// Corners of a quad's two triangles, by column and row.
const CORNERS: [[u32; 2]; 6] = [[0, 0], [1, 0], [0, 1], [1, 1], [0, 1], [1, 0]];

impl Divided {
    /// Of the sphere that data lies on.
    fn radius_m(&self) -> f64 {
        let lift = self.is_tested.then(|| lift_m(&self.eye));
        RADIUS_M + lift.unwrap_or_default()
    }

    /// Where vertices are from, and along which axes.
    fn frame(&self) -> (DVec3, [DVec3; 3]) {
        match self.origin {
            Origin::Corner => {
                let axes = axes(self.data.corner);
                (axes[2] * self.radius_m(), axes)
            }
            Origin::Centre => (DVec3::ZERO, [DVec3::X, DVec3::Y, DVec3::Z]),
        }
    }

    pub(crate) fn constants(&self) -> DecalConstants {
        let Self { data, eye, .. } = self;
        let camera = &eye.camera;
        let (origin, axes) = self.frame();
        let scale = camera.tan_half.recip();
        let clip = |of: DVec3| {
            let aside = [camera.right, camera.up].map(|axis| axis.dot(of) * scale);
            DVec4::new(aside[0], aside[1], 0.0, camera.forward.dot(of))
        };
        let start = clip(origin - camera.eye) + DVec4::Z * eye.near_m();
        let single = |of: DVec4| of.as_vec4().to_array();
        let horizon = eye.horizon();
        let along = axes.map(|axis| horizon.truncate().dot(axis));
        let horizon = DVec3::from(along).extend(horizon.dot(origin.extend(1.0)));
        let vector = |of: DVec3| of.as_vec3().to_array();
        let pair = |of: DVec2| of.as_vec2().to_array();
        let (toward, angle, size, path) = match data.shape {
            Shape::Decal(size) | Shape::Line(Path::Straight(size)) => (DVec2::X, 0.0, size, 0),
            Shape::Line(Path::GreatCircle { toward, angle }) => (toward, angle, DVec2::ZERO, 1),
        };
        let (sin_lat, cos_lat) = data.corner.y.sin_cos();
        let in_radii = camera.eye / RADIUS_M;
        DecalConstants {
            columns: [
                single(clip(axes[0])),
                single(clip(axes[1])),
                single(clip(axes[2])),
                single(start),
            ],
            horizon: single(horizon),
            right: vector(camera.right * camera.tan_half),
            height: nearest_f32(in_radii.length_squared() - 1.0),
            up: vector(camera.up * camera.tan_half),
            near: nearest_f32(eye.near_m() / RADIUS_M),
            forward: vector(camera.forward),
            radius_m: nearest_f32(self.radius_m()),
            eye: vector(in_radii),
            half_px: nearest_f32(eye.half_px()),
            toward: vector(toward.extend(0.0)),
            angle: nearest_f32(angle),
            focus: pair(data.corner - eye.focus),
            size: pair(size),
            sin_lat: nearest_f32(sin_lat),
            cos_lat: nearest_f32(cos_lat),
            tan_half: nearest_f32(camera.tan_half),
            reach: nearest_f32(REACH),
            half_width_px: nearest_f32(0.5 * WIDTH_PX),
            cells: self.cells,
            texels: TEXELS,
            projection: eye.projection as u32,
            form: u32::from(self.origin == Origin::Centre),
            series: match self.series {
                Series::First => 1,
                Series::Second => 2,
                Series::Full => 14,
            },
            path,
            padding: 0,
        }
    }

    /// Triangles of a decal's grid by columns and rows of their corners, from the lower left, cut from (1, 0) to (0, 1).
    fn grid(&self) -> impl Iterator<Item = [u32; 2]> {
        let cells = self.cells;
        let all = (0..cells).flat_map(move |y| (0..cells).map(move |x| [x, y]));
        all.flat_map(move |[x, y]| CORNERS.map(|[right, up]| [x + right, y + up]))
    }

    /// Vertices as they are sent; before them a triangle over all of the picture where depth is tested.
    pub(crate) fn vertices(&self) -> Vec<[f32; 3]> {
        let mut vertices = Vec::new();
        if self.is_tested {
            vertices.extend([[-1.0, -1.0, -1.0], [3.0, -1.0, -1.0], [-1.0, 3.0, -1.0]]);
        }
        let part = |at: u32| nearest_f32(f64::from(at) / f64::from(self.cells));
        match self.data.shape {
            Shape::Decal(_) => {
                let vertex = |[x, y]: [u32; 2]| {
                    let at =
                        self.sent(DVec2::new(f64::from(x), f64::from(y)) / f64::from(self.cells));
                    [at[0], at[1], (y * (self.cells + 1) + x) as f32]
                };
                vertices.extend(self.grid().map(vertex));
            }
            Shape::Line(_) => {
                let segment =
                    |at| (0..6).map(move |corner| [part(at), part(at + 1), corner as f32]);
                vertices.extend((0..self.cells).flat_map(segment));
            }
        }
        vertices
    }

    /// Offsets from the corner, or longitude and latitude, as they are sent.
    fn sent(&self, share: DVec2) -> [f32; 2] {
        let from = match self.origin {
            Origin::Corner => self.data.corner,
            Origin::Centre => DVec2::ZERO,
        };
        (self.data.angles(share) - from).as_vec2().to_array()
    }

    /// A vertex in `f64`, of what was sent.
    fn corner_at(&self, share: DVec2) -> Corner {
        let (place, at) = match self.data.shape {
            Shape::Decal(_) => {
                let sent = DVec2::from(self.sent(share).map(f64::from));
                let from = match self.origin {
                    Origin::Corner => self.data.corner,
                    Origin::Centre => DVec2::ZERO,
                };
                (self.place(sent) * self.radius_m(), from + sent)
            }
            Shape::Line(_) => (
                self.data.direction(share) * self.radius_m(),
                self.data.angles(share),
            ),
        };
        Corner {
            clip: self.eye.clip(place, at),
            share,
            before: self.eye.horizon().dot(place.extend(1.0)),
        }
    }

    /// From the centre, in radii, by the series.
    fn place(&self, sent: DVec2) -> DVec3 {
        if self.origin == Origin::Centre {
            return direction(sent);
        }
        if self.series == Series::Full {
            return direction(self.data.corner + sent);
        }
        let [[sin_lon, off_lon], [sin_lat, off_lat]] = [sent.x, sent.y].map(|x| self.series.of(x));
        let (sin, cos) = self.data.corner.y.sin_cos();
        let level = cos * (1.0 - off_lat) - sin * sin_lat;
        let local = DVec3::new(
            level * sin_lon,
            sin_lat + sin * level * off_lon,
            1.0 - off_lat - cos * level * off_lon,
        );
        let [east, north, up] = axes(self.data.corner);
        east * local.x + north * local.y + up * local.z
    }

    /// Corners of all triangles as drawn, three each.
    pub(crate) fn corners(&self) -> Vec<Corner> {
        let cells = f64::from(self.cells);
        match self.data.shape {
            Shape::Decal(_) => {
                let corner = |[x, y]: [u32; 2]| {
                    self.corner_at(DVec2::new(f64::from(x), f64::from(y)) / cells)
                };
                self.grid().map(corner).collect()
            }
            Shape::Line(_) => {
                let segment = |at: u32| {
                    let ends =
                        [at, at + 1].map(|at| self.corner_at(DVec2::X * f64::from(at) / cells));
                    let along = ends[1].clip.truncate().truncate() / ends[1].clip.w
                        - ends[0].clip.truncate().truncate() / ends[0].clip.w;
                    let aside = along.perp().normalize() * (0.5 * WIDTH_PX / self.eye.half_px());
                    CORNERS.map(|[end, side]| {
                        let mut of = ends[end as usize];
                        let side = 2.0 * f64::from(side) - 1.0;
                        let moved = aside * (side * of.clip.w);
                        of.clip += moved.extend(0.0).extend(0.0);
                        of
                    })
                };
                (0..self.cells).flat_map(segment).collect()
            }
        }
    }

    /// How far the vertices of a decal that are seen are off their exact places, which nothing has rounded: the largest
    /// distance, and the most that rounding explains; pixels. None where no vertex is seen.
    ///
    /// - `clips`: as the device has them, three a triangle
    pub(crate) fn vertices_off(&self, clips: &[DVec4]) -> Option<[f64; 2]> {
        let eye = &self.eye;
        let side = f64::from(eye.side);
        let (from, _) = self.frame();
        let off = |([x, y], own): ([u32; 2], &DVec4)| {
            let share = DVec2::new(f64::from(x), f64::from(y)) / f64::from(self.cells);
            let (place, at) = (
                self.data.direction(share) * self.radius_m(),
                self.data.angles(share),
            );
            let exact = eye.pixel(eye.clip(place, at));
            let scale = eye.px_per_metre(at)?;
            // What is added up: from the origin, and from there to the eye. A few roundings of each.
            let added_m = place.distance(from) + from.distance(eye.camera.eye);
            let bound = 16.0 * SINGLE * (added_m * scale + side);
            Some([exact.distance(eye.pixel(*own)), bound])
        };
        let all = self.grid().zip(clips).filter_map(off);
        all.reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])
    }

    /// Triangles of the data.
    pub(crate) fn triangles(&self) -> u64 {
        match self.data.shape {
            Shape::Decal(_) => 2 * u64::from(self.cells).pow(2),
            Shape::Line(_) => 2 * u64::from(self.cells),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_lie_as_the_shader_reads_them() {
        let layout = terrafill_shaders::struct_layout("decals/decal.wgsl", "DecalConstants");
        let layout = layout.expect("a struct");
        let offset = |name: &str| layout.offset(name).expect(name);
        macro_rules! same {
            ($($ours:ident $theirs:literal),* $(,)?) => {
                $(assert_eq!(offset($theirs), std::mem::offset_of!(DecalConstants, $ours), $theirs);)*
            };
        }
        same!(
            columns "x", horizon "horizon", right "right", height "height", up "up", near "near", forward "forward",
            radius_m "radius_m", eye "eye", half_px "half_px", toward "toward", angle "angle", focus "focus",
            size "size", sin_lat "sin_lat", cos_lat "cos_lat", tan_half "tan_half", reach "reach",
            half_width_px "half_width_px", cells "cells", texels "texels", projection "projection", form "form",
            series "series", path "path",
        );
        for (number, column) in ["x", "y", "z", "origin"].iter().enumerate() {
            assert_eq!(offset(column), 16 * number, "{column}");
        }
        assert_eq!(layout.stride as usize, size_of::<DecalConstants>());
        // Negative control: two members lie apart.
        assert_ne!(
            offset("sin_lat"),
            std::mem::offset_of!(DecalConstants, cos_lat)
        );
    }

    #[test]
    fn a_decal_needs_more_cells_the_nearer_and_the_larger_it_is() {
        let middle = DVec2::new(0.26, 0.785);
        let of = |height: f64, above: f64| {
            let eye = Eye::new(middle, 0.0, above, 1024);
            cells_by_formula(&eye, &Data::square(middle, height))
        };
        assert_eq!(of(1e-4, 1e4), 1);
        assert!(of(0.7, 5e6) > of(0.14, 5e6));
        assert!(of(0.14, 1e6) > of(0.14, 5e6));
        // A flat map is straight.
        let flat = Eye {
            projection: Projection::Flat,
            ..Eye::new(middle, 0.0, 5e6, 1024)
        };
        assert_eq!(cells_by_formula(&flat, &Data::square(middle, 0.7)), 1);
    }

    #[test]
    fn low_orders_are_off_by_their_next_terms() {
        let middle = DVec2::new(0.26, 0.785);
        let of = |series| Divided {
            data: Data::square(middle, 1e-3),
            eye: Eye::new(middle, 0.0, 1e4, 64),
            cells: 1,
            origin: Origin::Corner,
            series,
            is_tested: false,
        };
        let off = |series| {
            let sent = DVec2::new(0.0, 1e-3);
            of(series)
                .place(sent)
                .distance(of(Series::Full).place(sent))
        };
        assert!(
            (off(Series::First) / 5e-7 - 1.0).abs() < 1e-3,
            "{}",
            off(Series::First)
        );
        assert!((off(Series::Second) / (1e-9 / 6.0) - 1.0).abs() < 1e-3);
    }
}
