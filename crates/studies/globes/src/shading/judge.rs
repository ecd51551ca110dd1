// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture's colours in `f64`. Against the same texels, filtered alike, they decide. Against the layers as they are
//! published they say what cube maps, bumps in 8 bits and filters cost.

use super::layers::{Fragment, Lights, Reads, Sampled, Shade, shade};
use super::sources::Sources;
use super::texels::Looked;
use super::way::{Layer, Shading};
use crate::projection::{K, Projection};
use crate::sight::drawn_otherwise;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::FRAC_PI_2;
use terrafill_globe_views::{Eye, SNAPPED_PX, quantiles, shares};
use terrafill_reference::SurfaceTriangles;
use terrafill_study::Figures;
use terrafill_surface::SurfaceFrame;

/// By which WGSL allows an angle of a quarter turn by `atan2` to be off, radians: 4,096 units in the last place.
const ATAN2_RAD: f64 = 4096.0 / 16_777_216.0;

/// Sine of 85°.
const POLAR_SINE: f64 = 0.996_194_698_091_745_5;

/// How far a shaded picture is off, channels as numbers, 1 being white.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ShadingErrors {
    /// Of each compared pixel, the largest channel's difference from the same texels.
    pub(super) from_texels: Vec<f64>,
    /// Pixels farther from them than they may be.
    pub(super) beyond: usize,
    /// The same where a layer is exchanged for another, clouds stand still, or it is day at night.
    pub(super) controls: Option<[usize; 3]>,
    /// Of each compared pixel, the largest channel's difference from the layers as published.
    pub(super) all: Vec<f64>,
    /// Within 5° of a pole.
    pub(super) polar: Vec<f64>,
    pub(super) non_finite: usize,
    pub(super) shown: usize,
    /// Pixels that the device draws and rays do not meet, or the other way round, but beside the outline.
    pub(super) otherwise: usize,
}

impl ShadingErrors {
    /// Largest differences, and those that 99 % of the pixels do not exceed.
    pub(super) fn quantiles(&self) -> Figures {
        let [from_texels, all, polar] = [&self.from_texels, &self.all, &self.polar];
        let figures = [
            ("globe_shade_texels_max", from_texels, 1.0),
            ("globe_shade_max", all, 1.0),
            ("globe_shade_p99", all, 0.99),
            ("globe_shade_polar_max", polar, 1.0),
            ("globe_shade_polar_p99", polar, 0.99),
        ];
        quantiles(&figures)
    }
}

/// The triangles that pixels show.
pub(super) struct Met {
    /// Of each pixel, relative to the eye.
    facets: Vec<Option<Facet>>,
    /// How far corners may be from where they are, pixels.
    off_px: f64,
    /// In perspective, for rays beside a pixel's middle.
    triangles: Option<SurfaceTriangles>,
}

/// A triangle as a pixel shows it.
#[derive(Debug, Clone, Copy)]
enum Facet {
    /// Met by the pixel's ray; corners from the eye.
    Seen([DVec3; 3]),
    /// Drawn flat: where the corners are in the picture, pixels, beside the same.
    OnMap([DVec2; 3], [DVec3; 3]),
}

impl Met {
    /// Triangles in perspective.
    pub(super) fn new(eye: &Eye, frame: &SurfaceFrame) -> Self {
        let triangles = SurfaceTriangles::new(frame);
        let facets = eye.by_pixel(|_, _, direction| {
            let hit = triangles.hit_facet(direction, eye.camera.near_m);
            hit.map(|(_, facet)| Facet::Seen(facet))
        });
        Self {
            facets,
            off_px: SNAPPED_PX,
            triangles: Some(triangles),
        }
    }

    /// Triangles of places from the eye, projected in `f64`.
    pub(super) fn projected(
        eye: &Eye,
        places: &[DVec3],
        triangles: &[[u32; 3]],
        projection: Projection,
    ) -> Self {
        let size = DVec2::new(eye.size.width.into(), eye.size.height.into());
        let [width, height] = [eye.size.width, eye.size.height].map(|side| side as usize);
        let drawn = places.iter().map(|place| {
            let clip = projection.clip(eye, *place);
            let clip = clip / clip.w;
            let at = 0.5 + 0.5 * DVec2::new(clip.x, -clip.y);
            (at * size, clip.z)
        });
        let drawn: Vec<(DVec2, f64)> = drawn.collect();
        let mut facets = vec![None; width * height];
        let mut nearest = vec![0.0; width * height];
        for triangle in triangles {
            let corners = triangle.map(|k| drawn[k as usize]);
            let at = corners.map(|(at, _)| at);
            let facet = Facet::OnMap(at, triangle.map(|k| places[k as usize]));
            let [least, most] = [at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2])];
            for row in pixels(least.y, most.y, height) {
                for column in pixels(least.x, most.x, width) {
                    let centre = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                    let shares = on_map(at, centre);
                    let depth: f64 = (0..3).map(|i| shares[i] * corners[i].1).sum();
                    let pixel = row * width + column;
                    if shares.iter().all(|share| *share >= 0.0) && depth > nearest[pixel] {
                        nearest[pixel] = depth;
                        facets[pixel] = Some(facet);
                    }
                }
            }
        }
        Self {
            facets,
            off_px: SNAPPED_PX + ATAN2_RAD * 0.5 * size.y * steepest(projection),
            triangles: None,
        }
    }

    /// The triangle beyond an edge that a ray meets where it leaves `facet`. At the outline it may be far steeper.
    ///
    /// - `place`, `direction`: in the picture, pixels, and of the ray
    fn beyond(&self, eye: &Eye, facet: Facet, place: [f64; 2], direction: DVec3) -> Option<Facet> {
        let triangles = self.triangles.as_ref()?;
        let mut shares = facet.shares(place, direction).into_iter();
        if shares.all(|share| share >= 0.0) {
            return None;
        }
        let (_, corners) = triangles.hit_facet(direction, eye.camera.near_m)?;
        Some(Facet::Seen(corners))
    }

    /// How far from its centre, in pixels, `f64` puts what a pixel shows: triangles are flat, and projections are not.
    pub(super) fn off_formula(&self, eye: &Eye, projection: Projection) -> Vec<f64> {
        let half = 0.5 * DVec2::new(eye.size.width.into(), eye.size.height.into());
        let off = eye.by_pixel(|pixel, centre, direction| {
            let facet = self.facets[pixel]?;
            let normals = facet.corners().map(|corner| normal(eye, corner));
            let shown = facet.fragment(normals, centre, direction);
            let clip = projection.clip(eye, foot(eye, shown.n));
            let at = half + half * DVec2::new(clip.x, -clip.y) / clip.w;
            Some(at.distance(centre.into()))
        });
        off.into_iter().flatten().collect()
    }
}

/// How far, of half a picture, a map moves for a radian where it moves most.
fn steepest(projection: Projection) -> f64 {
    match projection {
        Projection::Globe => 0.0,
        Projection::Flat | Projection::Dome => 1.0 / FRAC_PI_2,
        Projection::HyperbolicPolar | Projection::HyperbolicCartesian => 1.0 / K,
    }
}

/// Columns or rows whose middles lie between two places.
#[allow(clippy::cast_possible_truncation, reason = "within the picture")]
fn pixels(least: f64, most: f64, count: usize) -> std::ops::Range<usize> {
    let [first, end] = [(least - 0.5).ceil(), (most - 0.5).floor() + 1.0];
    let within = |at: f64| at.clamp(0.0, count as f64) as usize;
    within(first)..within(end)
}

/// Shares of corners at a place in the picture; NaN in a triangle without area.
fn on_map([a, b, c]: [DVec2; 3], at: DVec2) -> [f64; 3] {
    let whole = (b - a).perp_dot(c - a);
    let share = |from: DVec2, to: DVec2| (from - at).perp_dot(to - at) / whole;
    [share(b, c), share(c, a), share(a, b)]
}

/// The place on the body whose geodetic normal this is, from the eye.
pub(super) fn foot(eye: &Eye, n: DVec3) -> DVec3 {
    let radii = eye.body.radii_m();
    let scaled = n * radii;
    scaled * radii / scaled.length() - eye.camera.eye_ecef
}

impl Facet {
    fn corners(self) -> [DVec3; 3] {
        match self {
            Self::Seen(corners) | Self::OnMap(_, corners) => corners,
        }
    }

    /// Shares of corners at a place in the picture, negative ones beyond an edge.
    ///
    /// - `place`, `direction`: in the picture, pixels, and of the ray
    fn shares(self, place: [f64; 2], direction: DVec3) -> [f64; 3] {
        match self {
            Self::Seen(corners) => {
                let [a, b, c] = corners;
                let out = (b - a).cross(c - a);
                shares(corners, direction * (a.dot(out) / direction.dot(out)))
            }
            Self::OnMap(at, _) => on_map(at, place.into()),
        }
    }

    /// What a place in the picture shows of it: normal and direction to the eye are interpolated as the device does.
    ///
    /// - `centre`, `direction`: of the place, pixels, and of its ray
    fn fragment(self, normals: [DVec3; 3], centre: [f64; 2], direction: DVec3) -> Fragment {
        let (corners, shares) = (self.corners(), self.shares(centre, direction));
        let mixed = |of: [DVec3; 3]| {
            let terms = of.iter().zip(shares);
            terms.fold(DVec3::ZERO, |sum, (of, share)| sum + *of * share)
        };
        Fragment {
            n: mixed(normals).normalize(),
            to_eye: mixed(corners.map(|corner| -corner)),
        }
    }
}

/// Clouds for lights of night, and the other way round.
struct Exchanged<'a>(&'a Sampled<'a>);

impl Reads for Exchanged<'_> {
    fn read(&self, layer: Layer, n: DVec3) -> Looked {
        let layer = match layer {
            Layer::Clouds => Layer::Night,
            Layer::Night => Layer::Clouds,
            other => other,
        };
        self.0.read(layer, n)
    }

    fn bent(&self, shading: Shading, n: DVec3) -> (DVec3, f64) {
        self.0.bent(shading, n)
    }
}

/// What a pixel must be like, each channel.
struct Allowed {
    least: DVec3,
    most: DVec3,
}

impl Allowed {
    fn has(&self, shown: DVec3) -> bool {
        // What is no number is in no range.
        shown.cmpge(self.least).all() && shown.cmple(self.most).all()
    }

    /// The same width about another colour.
    fn about(&self, colour: DVec3) -> Self {
        let half = 0.5 * (self.most - self.least);
        Self {
            least: colour - half,
            most: colour + half,
        }
    }
}

/// What one pixel is like.
struct Pixel {
    from_texels: f64,
    is_beyond: bool,
    controls: [bool; 3],
    from_sources: Option<f64>,
    is_polar: bool,
}

/// The largest channel's difference; NaN if any is.
fn largest(difference: DVec3) -> f64 {
    let off = difference.abs().to_array();
    off.into_iter()
        .fold(0.0, |worst, off| if off <= worst { worst } else { off })
}

/// Compares a picture, by the place that each pixel's ray meets.
///
/// - `sampled`, `sources`: the texels, and the layers as published where the difference from them is asked for
/// - `controls`: whether wrong layers are tried as well, which must be found
pub(super) fn judge(
    eye: &Eye,
    met: &Met,
    lights: &Lights,
    (sampled, sources): (&Sampled<'_>, Option<&Sources>),
    picture: &[[f32; 4]],
    controls: bool,
) -> ShadingErrors {
    let shading = sampled.shading;
    let still = Lights {
        clouds: DMat3::IDENTITY,
        ..*lights
    };
    let antipodal = Lights {
        sun: -lights.sun,
        ..*lights
    };
    let judged = eye.by_pixel(|pixel, centre, direction| {
        let facet = met.facets[pixel]?;
        let [r, g, b, alpha] = picture[pixel].map(f64::from);
        if alpha == 0.0 {
            return None;
        }
        let shown = DVec3::new(r, g, b);
        let normals = facet.corners().map(|corner| normal(eye, corner));
        let here = facet.fragment(normals, centre, direction);
        let Shade { colour, mut doubt } = shade(lights, shading, here, sampled);
        let (mut least, mut most) = (colour, colour);
        let of_middle = Allowed {
            least: colour - doubt,
            most: colour + doubt,
        };
        let is_clear = of_middle.has(shown) && !controls;
        // Places beside the middle allow more: not asked where it is enough, and no width is.
        let ways = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
        for way in ways.into_iter().filter(|_| !is_clear) {
            let beside = [0, 1].map(|axis| centre[axis] + met.off_px * way[axis]);
            let direction = eye.camera.direction_ecef(eye.size, beside);
            let beyond = met.beyond(eye, facet, beside, direction);
            for facet in std::iter::once(facet).chain(beyond) {
                let normals = facet.corners().map(|corner| normal(eye, corner));
                let fragment = facet.fragment(normals, beside, direction);
                let beside = shade(lights, shading, fragment, sampled);
                doubt = doubt.max(beside.doubt);
                (least, most) = (least.min(beside.colour), most.max(beside.colour));
            }
        }
        let allowed = Allowed {
            least: least - doubt,
            most: most + doubt,
        };
        let controls = if controls {
            let wrong = [
                shade(lights, shading, here, &Exchanged(sampled)),
                shade(&still, shading, here, sampled),
                shade(&antipodal, shading, here, sampled),
            ];
            wrong.map(|wrong| !allowed.about(wrong.colour).has(shown))
        } else {
            [false; 3]
        };
        Some(Pixel {
            from_texels: largest(shown - colour),
            is_beyond: !allowed.has(shown),
            controls,
            from_sources: sources.map(|sources| {
                let published = shade(lights, shading, here, sources);
                largest(shown - published.colour)
            }),
            is_polar: here.n.z.abs() > POLAR_SINE,
        })
    });
    let is_shown: Vec<bool> = picture.iter().map(|colour| colour[3] != 0.0).collect();
    let is_met: Vec<bool> = met.facets.iter().map(Option::is_some).collect();
    let mut found = ShadingErrors {
        non_finite: picture.iter().filter(|colour| is_lost(colour)).count(),
        shown: is_shown.iter().filter(|is_shown| **is_shown).count(),
        otherwise: drawn_otherwise(eye.size.width as usize, &is_met, &is_shown),
        controls: controls.then_some([0; 3]),
        ..ShadingErrors::default()
    };
    for pixel in judged.into_iter().flatten() {
        found.beyond += usize::from(pixel.is_beyond);
        for (count, is_beyond) in found.controls.iter_mut().flatten().zip(pixel.controls) {
            *count += usize::from(is_beyond);
        }
        if !pixel.from_texels.is_finite() {
            continue;
        }
        found.from_texels.push(pixel.from_texels);
        found.all.extend(pixel.from_sources);
        let polar = pixel.from_sources.filter(|_| pixel.is_polar);
        found.polar.extend(polar);
    }
    found
}

/// Geodetic normal of a place relative to the eye.
pub(super) fn normal(eye: &Eye, relative_m: DVec3) -> DVec3 {
    let radii = eye.body.radii_m();
    ((eye.camera.eye_ecef + relative_m) / (radii * radii)).normalize()
}

/// Whether a colour is no number.
pub(super) fn is_lost(colour: &[f32; 4]) -> bool {
    colour.iter().any(|channel| !channel.is_finite())
}

/// As pictures show it: what is not finite is magenta.
#[allow(
    clippy::cast_possible_truncation,
    reason = "a share of 255 after clamping"
)]
pub(super) fn bytes(colour: [f32; 4]) -> [u8; 3] {
    if is_lost(&colour) {
        [255, 0, 255]
    } else {
        [0, 1, 2].map(|i| (255.0 * colour[i].clamp(0.0, 1.0)).round() as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::list::List;
    use terrafill_globe_views::no_triangles;

    #[test]
    fn beyond_an_edge_a_ray_meets_the_next_triangle() {
        let list = List::shipped().expect("a list");
        let eye = list.view("globe").expect("a view").eye(64);
        let ray = |place| eye.camera.direction_ecef(eye.size, place);
        let corner = |place, by: f64| (ray(place) * by).as_vec3().to_array();
        let [above, below] = [[10.0, 10.0], [10.0, 50.0]].map(|at| corner(at, 2e6));
        let (flat, steep) = (corner([40.0, 30.0], 2e6), corner([2.0, 30.0], 8e6));
        let met = Met::new(
            &eye,
            &SurfaceFrame {
                vertices_rte: [above, below, flat, steep].into(),
                triangles: [[0, 1, 2], [0, 3, 1]].into(),
                ..no_triangles()
            },
        );
        let facet = |at: [f64; 2]| {
            let triangles = met.triangles.as_ref().expect("in perspective");
            let (_, corners) = triangles.hit_facet(ray(at), 1.0).expect("met");
            Facet::Seen(corners)
        };
        let beyond = |at: [f64; 2]| {
            let facet = met.beyond(&eye, facet([10.001, 30.0]), at, ray(at))?;
            Some(facet.corners())
        };
        let left = [10.001 - SNAPPED_PX, 30.0];
        assert_eq!(beyond(left), Some(facet(left).corners()));
        assert_ne!(beyond(left), Some(facet([10.001, 30.0]).corners()));
        // Negative controls: on its own side, and where nothing is met.
        assert_eq!(beyond([10.001 + SNAPPED_PX, 30.0]), None);
        assert_eq!(beyond([60.0, 30.0]), None);
    }
}
