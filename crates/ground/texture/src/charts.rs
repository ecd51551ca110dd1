// SPDX-License-Identifier: MIT OR Apache-2.0
//! Charts: routes by a map of the region's own, fitted in `f64` on the CPU.
//!
//! Near an anchor no trigonometry is needed. A fragment is projected onto the plane through the anchor,
//! from the point where the anchor's normal meets the polar axis, `(0, 0, −e² N sin φ₀)`. Along the normal
//! that projection does not depend on height. From the body's centre it would: 37 m at latitude 45° and
//! −11 km. What then is left between the two plane coordinates and longitude and latitude is smooth, and a
//! polynomial of low degree fits it. Everything that is large cancels in the anchor's frame before `f32`
//! sees it.
//!
//! Offsets in meridian axes, metres; angles minus the anchor's, radians. Sources: `planes` is how
//! CesiumJS places materials on small ground primitives (`ShadowVolumeAppearance`); gnomonic and
//! azimuthal maps: Snyder (1987), USGS PP 1395, ch. 22.

mod fit;

use crate::cube::CubeTexture;
use crate::operations::{Program, ProgramBuilder, Value};
use crate::rounding::vectors;
use crate::{AngleCore, MapRegion, Weight};
use fit::{chebyshev_nodes, near_minimax};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;
use terrafill_core::Geodetic;

/// Degree of a chart's polynomial, 1 to 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ChartDegree(u8);

impl ChartDegree {
    /// Every degree, ascending.
    pub const ALL: [Self; 5] = [Self(1), Self(2), Self(3), Self(4), Self(5)];

    /// 1 to 5.
    #[must_use]
    pub fn get(self) -> u8 {
        self.0
    }

    /// 1 to 5, as a length.
    fn as_usize(self) -> usize {
        usize::from(self.0)
    }
}

/// A map of a region's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Chart {
    /// Distances from two planes, linear between the region's extents.
    Planes,
    /// Barycentric coordinates in the triangle of a flat mesh that holds the fragment.
    ///
    /// The mesh is the extent's rectangle, cut from south-west to north-east; its corners have the
    /// texture coordinates. A fragment is projected as for a gnomonic chart. Exact at the corners;
    /// in between a meridian or parallel is its chord, so the error is that of a flat region and
    /// grows with the square of its size. What Cozzi (2007), 2.1.6, considered and did not build.
    Barycentric,
    /// Gnomonic projection on the anchor's normal and a polynomial in its two coordinates.
    Gnomonic(ChartDegree),
    /// Gnomonic projection on the pole, colatitude by an odd polynomial with that many terms,
    /// longitude by an arctangent.
    ///
    /// For regions near or over a pole, where longitude and latitude are no smooth functions of anything
    /// local. What holds there: the colatitude is smooth and exact in the pole's neighbourhood. The
    /// longitude is that of the offset from the axis. So its relative error is that of the offset as long
    /// as the anchor is the pole ([`MapRegion::anchored`]). At the pole itself, where there is none, it is
    /// 0. With another anchor, the distance of the anchor from the axis is added in `f32`, and closer to
    /// the pole than some millimetres per kilometre of that distance the longitude is noise.
    Azimuthal(ChartDegree),
    /// Both angles from a cube texture of that size.
    Cube(CubeSize),
}

/// Texels along an edge of a cube texture: a power of two from 128 to 4096.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CubeSize(u32);

impl CubeSize {
    /// Every size, ascending.
    pub const ALL: [Self; 6] = [
        Self(128),
        Self(256),
        Self(512),
        Self(1024),
        Self(2048),
        Self(4096),
    ];

    /// Texels.
    #[must_use]
    pub fn get(self) -> u32 {
        self.0
    }
}

/// Rounds of reweighting after which the largest error of a fit hardly moves any more.
const FIT_ROUNDS: usize = 12;

/// Chebyshev nodes along each axis of the extent for a fit: twice the most coefficients of a row.
const FIT_NODES: usize = 13;

/// Chebyshev nodes along the height: the dependence on height is close to linear.
const FIT_HEIGHTS: usize = 3;

/// The projection reaches to where the view from its centre is this close to the horizon
/// (cosine): beyond, the coordinates grow without end, and behind they come back mirrored.
const HORIZON_COSINE: f64 = 0.05;

/// The arctangent that makes an azimuthal chart's longitude: degree 15 is where an
/// absolute `f32` angle has its floor.
const LONGITUDE_CORE: AngleCore = AngleCore::Odd {
    degree: 15,
    weight: Weight::Absolute,
};

impl Chart {
    /// Every chart.
    pub fn all() -> impl Iterator<Item = Self> {
        let gnomonic = ChartDegree::ALL.into_iter().map(Self::Gnomonic);
        let azimuthal = ChartDegree::ALL.into_iter().map(Self::Azimuthal);
        [Self::Planes, Self::Barycentric]
            .into_iter()
            .chain(gnomonic)
            .chain(azimuthal)
            .chain(CubeSize::ALL.into_iter().map(Self::Cube))
    }

    /// Stable name, such as `gnomonic-3`.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Planes => "planes".to_owned(),
            Self::Barycentric => "barycentric".to_owned(),
            Self::Gnomonic(degree) => format!("gnomonic-{}", degree.get()),
            Self::Azimuthal(degree) => format!("azimuthal-{}", degree.get()),
            Self::Cube(size) => format!("cube-{}", size.get()),
        }
    }

    /// The steps from offset to angles.
    #[must_use]
    pub fn program(&self) -> Program {
        let mut b = match self {
            Self::Cube(size) => ProgramBuilder::with_cube(CubeTexture::new(size.get())),
            _ => ProgramBuilder::new(),
        };
        let d = b.offset();
        let [longitude, latitude] = match self {
            Self::Planes => [affine(&mut b, 0, d), affine(&mut b, 4, d)],
            Self::Barycentric => barycentric_steps(&mut b, d),
            Self::Gnomonic(degree) => gnomonic_steps(&mut b, d, *degree),
            Self::Azimuthal(terms) => azimuthal_steps(&mut b, d, *terms),
            Self::Cube(_) => cube_steps(&mut b, d),
        };
        b.finish(longitude, latitude)
    }

    /// The region's constants, computed in `f64`: as many vectors as the program reads.
    ///
    /// A region that the chart cannot hold (wider than a hemisphere for a gnomonic chart) has
    /// finite constants as well; its residual says that they are of no use.
    #[must_use]
    pub fn constants(&self, region: &MapRegion) -> Vec<[f32; 4]> {
        vectors(&match self {
            Self::Planes => planes_constants(region),
            Self::Barycentric => barycentric_constants(region),
            Self::Gnomonic(degree) => gnomonic_constants(region, *degree),
            Self::Azimuthal(terms) => azimuthal_constants(region, *terms),
            Self::Cube(_) => cube_constants(region),
        })
    }
}

/// `row · (vector, 1)`, the row being the four constants from `first`.
pub(crate) fn affine(b: &mut ProgramBuilder, first: usize, vector: [Value; 3]) -> Value {
    let mut sum = b.constant(first + 3);
    for (lane, component) in vector.into_iter().enumerate().rev() {
        let factor = b.constant(first + lane);
        sum = b.fma(component, factor, sum);
    }
    sum
}

/// Horner's rule over constants from `first`, ascending.
fn constant_polynomial(b: &mut ProgramBuilder, x: Value, first: usize, count: usize) -> Value {
    let mut sum = b.constant(first + count - 1);
    for index in (first..first + count - 1).rev() {
        let next = b.constant(index);
        sum = b.fma(sum, x, next);
    }
    sum
}

/// Unit vectors east, north and up at a latitude of the anchor's meridian.
fn local_axes(latitude_rad: f64) -> [DVec3; 3] {
    let (sin, cos) = latitude_rad.sin_cos();
    [
        DVec3::Y,
        DVec3::new(-sin, 0.0, cos),
        DVec3::new(cos, 0.0, sin),
    ]
}

/// Rows of longitude and latitude.
///
/// The extent's edges are projected along the normal of its centre, and between the extremes of
/// east and north both angles are linear: what a texture does that is stretched over that box.
fn planes_constants(region: &MapRegion) -> Vec<f64> {
    let extent = region.extent();
    let centre = Geodetic {
        longitude_rad: 0.5 * (extent.west_rad + extent.east_rad),
        latitude_rad: 0.5 * (extent.south_rad + extent.north_rad),
        height_m: 0.0,
    };
    let (sin, cos) = (centre.longitude_rad - region.anchor_longitude_rad()).sin_cos();
    let turn = |v: DVec3| DVec3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z);
    let [east, north, _] = local_axes(centre.latitude_rad).map(turn);
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for u in chebyshev_nodes(extent.west_rad, extent.east_rad, 9) {
        for v in chebyshev_nodes(extent.south_rad, extent.north_rad, 9) {
            let offset = region.offset_m(Geodetic {
                longitude_rad: u,
                latitude_rad: v,
                height_m: 0.0,
            });
            for (axis, direction) in [east, north].into_iter().enumerate() {
                low[axis] = low[axis].min(offset.dot(direction));
                high[axis] = high[axis].max(offset.dot(direction));
            }
        }
    }
    let size = extent.size_rad();
    let start = [
        extent.west_rad - region.anchor_longitude_rad(),
        extent.south_rad - region.anchor_latitude_rad(),
    ];
    let row = |axis: usize, direction: DVec3| {
        let slope = size[axis] / (high[axis] - low[axis]);
        let row = direction * slope;
        [row.x, row.y, row.z, start[axis] - slope * low[axis]]
    };
    [row(0, east), row(1, north)].concat()
}

/// The weights of two corners in each triangle, and from them the angles.
///
/// The third weight is what is left of 1. In a triangle an angle is that of corner A plus the weights of B
/// and C times how much more it is there. The sides of the rectangle are meridians and parallels: every
/// difference is 0 or its size. The triangles share the diagonal and agree on it.
fn barycentric_steps(b: &mut ProgramBuilder, d: [Value; 3]) -> [Value; 2] {
    let [east, north] = projected(b, d);
    let row = |b: &mut ProgramBuilder, first: usize| {
        let [of_east, of_north, rest] = [0, 1, 2].map(|i| b.constant(first + i));
        let sum = b.fma(north, of_north, rest);
        b.fma(east, of_east, sum)
    };
    // South-east and north-east of the lower triangle; north-east and north-west of the upper one.
    let [lower_se, lower_ne, upper_ne, upper_nw] =
        [0, 3, 6, 9].map(|first| row(b, PROJECTION + first));
    let [west, south, width, height] = [12, 13, 14, 15].map(|i| b.constant(PROJECTION + i));
    let lower = [b.add(lower_se, lower_ne), lower_ne];
    let upper = [upper_ne, b.add(upper_ne, upper_nw)];
    // Left of the diagonal the lower triangle's south-east weight is negative.
    let zero = b.literal(0.0);
    let [u, v] = [0, 1].map(|axis: usize| b.select_less(lower_se, zero, upper[axis], lower[axis]));
    [b.fma(u, width, west), b.fma(v, height, south)]
}

/// Projection, rows of the weights and the rectangle, in the order that [`barycentric_steps`] reads.
///
/// A weight is the signed area that the point spans with the opposite side, over the triangle's. A
/// rectangle without area, as a whole parallel's in projection, has weights of 0.
fn barycentric_constants(region: &MapRegion) -> Vec<f64> {
    let [_, north, up] = local_axes(region.anchor_latitude_rad());
    let to_centre = region
        .body()
        .curvature_radii_m(region.anchor_latitude_rad())[0];
    let extent = region.extent();
    let corner = |longitude_rad: f64, latitude_rad: f64| {
        let offset = region.offset_m(Geodetic {
            longitude_rad,
            latitude_rad,
            height_m: 0.0,
        });
        let w = 1.0 + offset.dot(up) / to_centre;
        [offset.y / w, offset.dot(north) / w]
    };
    let sw = corner(extent.west_rad, extent.south_rad);
    let se = corner(extent.east_rad, extent.south_rad);
    let ne = corner(extent.east_rad, extent.north_rad);
    let nw = corner(extent.west_rad, extent.north_rad);
    let mut constants = projection(up, north, to_centre, [to_centre.recip(); 2]);
    for [weighed, from, to] in [[se, ne, sw], [ne, sw, se], [ne, nw, sw], [nw, sw, ne]] {
        constants.extend(weight_row(weighed, from, to));
    }
    let size = extent.size_rad();
    constants.extend([
        extent.west_rad - region.anchor_longitude_rad(),
        extent.south_rad - region.anchor_latitude_rad(),
        size[0],
        size[1],
    ]);
    constants
}

/// Factors of east and north and the rest of the weight of a corner: 1 there, 0 on the line through
/// the other two.
fn weight_row(weighed: [f64; 2], from: [f64; 2], to: [f64; 2]) -> [f64; 3] {
    let normal = [from[1] - to[1], to[0] - from[0]];
    let height = |p: [f64; 2]| (p[0] - from[0]) * normal[0] + (p[1] - from[1]) * normal[1];
    let area = height(weighed);
    if area.abs() < f64::MIN_POSITIVE {
        return [0.0; 3];
    }
    let rest = -(from[0] * normal[0] + from[1] * normal[1]);
    [normal[0] / area, normal[1] / area, rest / area]
}

/// Powers (i, j) of u² and v in longitude / u, and in latitude, row by row for Horner's rule.
///
/// The exact map is symmetric about the anchor's meridian: longitude is odd in u, latitude even.
fn gnomonic_rows(degree: ChartDegree) -> [Vec<usize>; 2] {
    let degree = degree.as_usize();
    // Entry i is the number of powers of v beside u^(2i).
    let longitude = (0..degree.div_ceil(2)).map(|i| degree - 2 * i).collect();
    let latitude = (0..=degree / 2).map(|i| degree - 2 * i + 1).collect();
    [longitude, latitude]
}

/// Constants of a projection: the two rows of w and v without their y, and the scale of u.
const PROJECTION: usize = 6;

/// Scaled coordinates to the east and to the north in the plane through the anchor.
fn projected(b: &mut ProgramBuilder, [x, y, z]: [Value; 3]) -> [Value; 2] {
    let [wx, wz, w0, vx, vz, us] = [0, 1, 2, 3, 4, 5].map(|i| b.constant(i));
    let w = b.fma(z, wz, w0);
    let w = b.fma(x, wx, w);
    let v = b.multiply(z, vz);
    let v = b.fma(x, vx, v);
    let u = b.multiply(y, us);
    let one = b.literal(1.0);
    let inverse = b.divide(one, w);
    [b.multiply(u, inverse), b.multiply(v, inverse)]
}

/// Constants of [`projected`]: w is 1 at the anchor, and a plane coordinate of 1 becomes 1 over its scale.
///
/// - `scale`: of east and of north, as a share of `to_centre`, the distance from the anchor to the axis
fn projection(up: DVec3, north: DVec3, to_centre: f64, scale: [f64; 2]) -> Vec<f64> {
    vec![
        up.x / to_centre,
        up.z / to_centre,
        1.0,
        north.x / (scale[1] * to_centre),
        north.z / (scale[1] * to_centre),
        1.0 / (scale[0] * to_centre),
    ]
}

fn gnomonic_steps(b: &mut ProgramBuilder, d: [Value; 3], degree: ChartDegree) -> [Value; 2] {
    let [u, v] = projected(b, d);
    let uu = b.multiply(u, u);
    let mut first = PROJECTION;
    let [odd, even] = gnomonic_rows(degree).map(|rows| {
        let mut inner = Vec::new();
        for count in rows {
            inner.push(constant_polynomial(b, v, first, count));
            first += count;
        }
        let mut sum = inner[inner.len() - 1];
        for next in inner.iter().rev().skip(1) {
            sum = b.fma(sum, uu, *next);
        }
        sum
    });
    [b.multiply(u, odd), even]
}

/// Frame and coefficients of a gnomonic chart, in the order that [`gnomonic_steps`] reads.
fn gnomonic_constants(region: &MapRegion, degree: ChartDegree) -> Vec<f64> {
    let [_, north, up] = local_axes(region.anchor_latitude_rad());
    let to_centre = region
        .body()
        .curvature_radii_m(region.anchor_latitude_rad())[0];
    let nodes = fit_nodes(region);
    // u and v are scaled to ±1 over the nodes, so that coefficients are angles.
    let project = |offset: DVec3| {
        let w = to_centre + offset.dot(up);
        [offset.y / w, offset.dot(north) / w]
    };
    let mut usable = Vec::new();
    let mut scale = [f64::MIN_POSITIVE; 2];
    for (offset, angles) in &nodes {
        if to_centre + offset.dot(up) > HORIZON_COSINE * to_centre {
            let plane = project(*offset);
            scale = [0, 1].map(|axis: usize| scale[axis].max(plane[axis].abs()));
            usable.push((plane, *angles));
        }
    }
    let rows = gnomonic_rows(degree);
    let mut constants = projection(up, north, to_centre, scale);
    for (axis, counts) in rows.iter().enumerate() {
        let basis = |plane: [f64; 2]| -> Vec<f64> {
            let (u, v) = (plane[0] / scale[0], plane[1] / scale[1]);
            let factor = if axis == 0 { u } else { 1.0 };
            let mut row = Vec::new();
            let mut power = factor;
            for count in counts {
                let mut term = power;
                for _ in 0..*count {
                    row.push(term);
                    term *= v;
                }
                power *= u * u;
            }
            row
        };
        let matrix: Vec<Vec<f64>> = usable.iter().map(|(plane, _)| basis(*plane)).collect();
        let target: Vec<f64> = usable.iter().map(|(_, angles)| angles[axis]).collect();
        let fitted = near_minimax(&matrix, &target, FIT_ROUNDS);
        let count: usize = counts.iter().sum();
        constants.extend((0..count).map(|i| fitted.get(i).copied().unwrap_or(0.0)));
    }
    constants
}

/// Constants before the polynomial: the anchor's distance from the axis, sign and height of the
/// pole's frame, the anchor's colatitude.
const AZIMUTHAL_FRAME: usize = 4;

fn azimuthal_steps(b: &mut ProgramBuilder, d: [Value; 3], terms: ChartDegree) -> [Value; 2] {
    let [anchor_rho, sign, height, colatitude] = [0, 1, 2, 3].map(|i| b.constant(i));
    let x = b.add(d[0], anchor_rho);
    let y = d[1];
    let longitude = LONGITUDE_CORE.full(b, y, x);
    let w = b.fma(d[2], sign, height);
    let square = b.multiply(x, x);
    let square = b.fma(y, y, square);
    let rho = b.square_root(square);
    let tangent = b.divide(rho, w);
    let tangent_squared = b.multiply(tangent, tangent);
    let series = constant_polynomial(b, tangent_squared, AZIMUTHAL_FRAME, terms.as_usize());
    [longitude, b.fma(tangent, series, colatitude)]
}

/// Frame of the nearer pole and the coefficients of the colatitude.
fn azimuthal_constants(region: &MapRegion, terms: ChartDegree) -> Vec<f64> {
    let anchor = region.anchor_meridian();
    let extent = region.extent();
    let sign = if extent.south_rad + extent.north_rad < 0.0 {
        -1.0
    } else {
        1.0
    };
    // Where the normals of the pole's neighbourhood meet the axis.
    let below_equator =
        region.body().eccentricity_squared() * region.body().curvature_radii_m(FRAC_PI_2)[0];
    let height = sign * anchor.z + below_equator;
    let (low, high) = region.height_range_m();
    let mut samples = Vec::new();
    for latitude_rad in chebyshev_nodes(extent.south_rad, extent.north_rad, 33) {
        for height_m in chebyshev_nodes(low, high, FIT_HEIGHTS) {
            let p = region.body().geodetic_to_ecef(Geodetic {
                longitude_rad: 0.0,
                latitude_rad,
                height_m,
            });
            let w = sign * p.z + below_equator;
            if w > HORIZON_COSINE * (height.abs() + p.x) {
                samples.push((p.x / w, FRAC_PI_2 - sign * latitude_rad));
            }
        }
    }
    let matrix: Vec<Vec<f64>> = samples
        .iter()
        .map(|(t, _)| {
            (0..terms.as_usize())
                .map(|k| t * (t * t).powi(power(k)))
                .collect()
        })
        .collect();
    let target: Vec<f64> = samples.iter().map(|(_, colatitude)| *colatitude).collect();
    let fitted = near_minimax(&matrix, &target, FIT_ROUNDS);
    let anchor_colatitude = FRAC_PI_2 - sign * region.anchor_latitude_rad();
    let mut constants = vec![anchor.x, sign, height, sign * anchor_colatitude];
    // Latitude grows where colatitude falls, in the north.
    let coefficient = |k: usize| fitted.get(k).map_or(0.0, |c| -sign * c);
    constants.extend((0..terms.as_usize()).map(coefficient));
    constants
}

/// The anchor's offset is added back, so this has the floor of positions about the body's centre.
fn cube_steps(b: &mut ProgramBuilder, d: [Value; 3]) -> [Value; 2] {
    let [anchor_rho, squash, height, latitude] = [0, 1, 2, 3].map(|i| b.constant(i));
    let x = b.add(d[0], anchor_rho);
    let z = b.fma(d[2], squash, height);
    let texel = b.cube_texel([x, d[1], z]);
    [texel[0], b.subtract(texel[1], latitude)]
}

/// Anchor, a² / b² and the anchor's latitude.
fn cube_constants(region: &MapRegion) -> Vec<f64> {
    let anchor = region.anchor_meridian();
    let body = region.body();
    let squash = (body.equatorial_radius_m() / body.polar_radius_m()).powi(2);
    let latitude = region.anchor_latitude_rad();
    vec![anchor.x, squash, squash * anchor.z, latitude]
}

/// A power as `powi` wants it; degrees are below ten.
fn power(k: usize) -> i32 {
    i32::try_from(k).unwrap_or(i32::MAX)
}

/// Offsets and angles at Chebyshev nodes over extent and heights.
fn fit_nodes(region: &MapRegion) -> Vec<(DVec3, [f64; 2])> {
    let extent = region.extent();
    let (low, high) = region.height_range_m();
    let mut nodes = Vec::with_capacity(FIT_NODES * FIT_NODES * FIT_HEIGHTS);
    for longitude_rad in chebyshev_nodes(extent.west_rad, extent.east_rad, FIT_NODES) {
        for latitude_rad in chebyshev_nodes(extent.south_rad, extent.north_rad, FIT_NODES) {
            for height_m in chebyshev_nodes(low, high, FIT_HEIGHTS) {
                let offset = region.offset_m(Geodetic {
                    longitude_rad,
                    latitude_rad,
                    height_m,
                });
                let angles = [
                    longitude_rad - region.anchor_longitude_rad(),
                    latitude_rad - region.anchor_latitude_rad(),
                ];
                nodes.push((offset, angles));
            }
        }
    }
    nodes
}

#[cfg(test)]
mod tests;
