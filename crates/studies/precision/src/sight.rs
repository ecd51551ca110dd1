// SPDX-License-Identifier: MIT OR Apache-2.0
//! What position routes are measured on: distance, depth format and distance of the anchor; and what
//! they are timed on.

use crate::place::{RegionPicture, halton};
use glam::{DVec3, Vec3};
use terrafill_core::Geodetic;
use terrafill_gpu::EVALUATIONS_PER_DISPATCH;
use terrafill_texture::{
    DepthFormat, DepthMapping, DepthStorage, MapRegion, PerspectiveView, PositionRoute,
};

/// From the eye to what is seen, metres, with the near plane that a camera would have there.
const DISTANCES_M: [(f64, f64); 6] = [
    (10.0, 0.1),
    (20.0, 0.1),
    (1e3, 1.0),
    (1e5, 1.0),
    (1e6, 1.0),
    (3e7, 1.0),
];

/// Far plane of the formats that need one, and of those that may have one: beyond every distance.
const FAR_M: f64 = 1e8;

/// Extents of the region, degrees: its middle close by, and so far that an offset from there weighs.
const EXTENTS_DEG: [f64; 2] = [1e-3, 1.0];

/// Where they are, degrees.
const LATITUDE_DEG: f64 = 45.0;

/// Extents and latitudes that the depth which is drawn with is measured at as well: what a plan takes
/// has to hold everywhere, caps round the pole and the globe included.
const DEFAULT_EXTENTS_DEG: [f64; 5] = [1e-3, 0.1, 1.0, 10.0, 360.0];
const DEFAULT_LATITUDES_DEG: [f64; 4] = [0.0, 45.0, 85.0, 90.0];

pub(crate) const IMAGE: [u32; 2] = [1920, 1080];
pub(crate) const FIELD_OF_VIEW_DEG: f64 = 60.0;
/// The view looks down by this much, turned away from north by that.
const PITCH_DEG: f64 = 40.0;
const HEADING_DEG: f64 = 30.0;

/// How far pixel and depth move between two timed evaluations.
pub(crate) const TIMED_STEP: [f32; 4] = [1e-3, 1e-3, 1e-7, 0.0];
pub(crate) const TIMED_DISTANCE_M: f64 = 1e3;
/// Where nothing was drawn: off the middle, so that no term is 0.
pub(crate) const CLEARED_PIXEL: [f32; 2] = [1200.5, 300.5];

/// A distance is spread by this much, so that its depth meets every rounding.
pub(crate) const DISTANCE_SPREAD: f64 = 0.02;

terrafill_results::named! {
    /// Where the region's anchor stands.
    all pub(crate) enum Anchor {
        /// Where a frame plan puts it.
        Plan = "plan",
        /// In the middle of the region, at the pole that it touches: what the plan's is worth is read
        /// beside it.
        Middle = "middle",
    }
}

/// What is seen, how its depth is kept, and from where offsets are counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ProbeView {
    /// `None`: nothing was drawn, and the depth is as it was cleared.
    pub(crate) distance_m: Option<f64>,
    pub(crate) extent_deg: f64,
    pub(crate) latitude_deg: f64,
    pub(crate) anchor: Anchor,
    pub(crate) format: DepthFormat,
}

/// Near plane of the views in which nothing was drawn, metres.
const CLEARED_NEAR_M: f64 = 1.0;

/// Distance × depth format × extent × anchor, with the default format more extents × latitudes, then
/// cleared depth in every format.
pub(crate) fn sights(quick: bool) -> Vec<ProbeView> {
    let mut sights = Vec::new();
    for (distance_m, near_m) in DISTANCES_M {
        for format in formats(near_m) {
            let is_default = DepthFormat::reversed(near_m) == Ok(format);
            if quick && !is_default {
                continue;
            }
            for (extent_deg, latitude_deg) in regions(is_default, quick) {
                sights.extend(Anchor::ALL.map(|anchor| ProbeView {
                    distance_m: Some(distance_m),
                    extent_deg,
                    latitude_deg,
                    anchor,
                    format,
                }));
            }
        }
    }
    let cleared = formats(CLEARED_NEAR_M).into_iter().map(|format| ProbeView {
        distance_m: None,
        extent_deg: EXTENTS_DEG[0],
        latitude_deg: LATITUDE_DEG,
        anchor: Anchor::Middle,
        format,
    });
    sights.extend(cleared);
    sights
}

/// Extents and latitudes of the regions that are looked at, each region once: some that would reach over
/// a pole are moved to end there.
fn regions(is_default: bool, quick: bool) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = EXTENTS_DEG.map(|extent| (extent, LATITUDE_DEG)).to_vec();
    if is_default && !quick {
        let all = DEFAULT_EXTENTS_DEG.iter();
        found.extend(all.flat_map(|extent| DEFAULT_LATITUDES_DEG.map(|at| (*extent, at))));
    }
    let mut extents = Vec::new();
    found.retain(|(extent_deg, latitude_deg)| {
        let place = RegionPicture::new(*extent_deg, *latitude_deg, ON_THE_SURFACE);
        let extent = place.map(|place| *place.region.extent());
        let is_new = extent.is_some_and(|extent| !extents.contains(&extent));
        extents.extend(extent);
        is_new
    });
    found
}

/// Heights of what is seen.
const ON_THE_SURFACE: (&str, f64, f64) = ("0", 0.0, 0.0);

fn formats(near_m: f64) -> Vec<DepthFormat> {
    let mut formats = Vec::new();
    for mapping in DepthMapping::ALL {
        for storage in [DepthStorage::Float32, DepthStorage::Unorm24] {
            for far_m in [f64::INFINITY, FAR_M] {
                // A logarithm has no end to be divided by: no such format.
                formats.extend(DepthFormat::new(mapping, storage, near_m, far_m).ok());
            }
        }
    }
    formats
}

impl ProbeView {
    /// As in the `condition` column.
    pub(crate) fn name(&self) -> String {
        let (depth, anchor) = (self.format.name(), self.anchor.name());
        let seen = match self.distance_m {
            Some(distance_m) => format!("distance={distance_m}"),
            None => "cleared".to_owned(),
        };
        format!(
            "{seen};depth={depth};extent={};latitude={};anchor={anchor}",
            self.extent_deg, self.latitude_deg
        )
    }

    /// What the depth buffer is cleared to: as far as it goes.
    pub(crate) fn cleared_depth(&self) -> f32 {
        match self.format.mapping() {
            DepthMapping::Reversed => 0.0,
            DepthMapping::Standard | DepthMapping::Logarithmic => 1.0,
        }
    }

    /// What the formula takes for worse than it is.
    pub(crate) fn why_less_than_expected(&self, route: PositionRoute) -> &'static str {
        if route == PositionRoute::InverseEcef {
            "a rounding on the way to the depth is in numerator and divisor alike and cancels; the formula \
             takes them for independent"
        } else if self
            .distance_m
            .is_some_and(|distance| self.format.residual_m(distance) > DISTANCE_SPREAD * distance)
        {
            "a step of the depth is longer than the range of distances measured"
        } else if self.format.mapping() == DepthMapping::Logarithmic {
            "WGSL grants exp2 and log2 some units in the last place more than this device takes"
        } else if self.format.storage() == DepthStorage::Unorm24 {
            "a 24-bit depth is rounded when it is stored and when it is read as a float; near 1 both \
             grids fall together, and the second rounding changes nothing"
        } else {
            "no reason known"
        }
    }

    /// Whether it is seen from here by the depth that is drawn with.
    #[cfg(test)]
    pub(crate) fn is_default(&self, distance_m: f64, anchor: Anchor) -> bool {
        self.distance_m == Some(distance_m)
            && self.anchor == anchor
            && DepthFormat::reversed(self.format.near_m()) == Ok(self.format)
    }

    pub(crate) fn place(&self) -> Option<RegionPicture> {
        RegionPicture::new(self.extent_deg, self.latitude_deg, ON_THE_SURFACE)
    }

    /// The region with its anchor; a plan's stands where the very function puts it that a plan calls.
    pub(crate) fn region(
        &self,
        place: &RegionPicture,
        view: &PerspectiveView,
    ) -> Option<MapRegion> {
        if self.anchor == Anchor::Middle {
            return Some(place.region);
        }
        let region = &place.region;
        let height_m = region.body().ecef_to_geodetic(view.eye_ecef).height_m;
        let (_, highest_m) = region.height_range_m();
        // As near as the ground can be, as the plan takes it.
        let nearest_m = (height_m - highest_m).max(self.format.near_m());
        let pixel_m = view.pixel_size_m(nearest_m);
        let heights = region.height_range_m();
        MapRegion::seen_from(
            *region.body(),
            *region.extent(),
            heights,
            view.eye_ecef,
            pixel_m,
        )
        .ok()
    }

    /// Looks at a point of the region half way from its middle to its corner.
    pub(crate) fn view(&self, place: &RegionPicture) -> PerspectiveView {
        view_of(
            place,
            self.distance_m.unwrap_or(TIMED_DISTANCE_M),
            self.format,
        )
    }
}

fn view_of(place: &RegionPicture, distance_m: f64, depth: DepthFormat) -> PerspectiveView {
    let extent = place.region.extent();
    let [width, height] = extent.size_rad();
    let target = Geodetic {
        longitude_rad: extent.west_rad + 0.75 * width,
        latitude_rad: extent.south_rad + 0.75 * height,
        height_m: 0.0,
    };
    let (sin_lon, cos_lon) = target.longitude_rad.sin_cos();
    let (sin_lat, cos_lat) = target.latitude_rad.sin_cos();
    let east = DVec3::new(-sin_lon, cos_lon, 0.0);
    let north = DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
    let up = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
    let (sin_heading, cos_heading) = HEADING_DEG.to_radians().sin_cos();
    let (sin_pitch, cos_pitch) = PITCH_DEG.to_radians().sin_cos();
    let ahead = east * sin_heading + north * cos_heading;
    let forward = ahead * cos_pitch - up * sin_pitch;
    let right = forward.cross(up).normalize();
    let half = 0.5 * FIELD_OF_VIEW_DEG.to_radians();
    let focal_y = 1.0 / half.tan();
    let aspect = f64::from(IMAGE[0]) / f64::from(IMAGE[1]);
    PerspectiveView {
        eye_ecef: place.region.body().geodetic_to_ecef(target) - forward * distance_m,
        right,
        up: right.cross(forward),
        backward: -forward,
        focal_x: focal_y / aspect,
        focal_y,
        size: IMAGE,
        depth,
    }
}

/// What a route of a mapping is called among the times.
pub(crate) fn timed_name(route: PositionRoute, mapping: DepthMapping) -> String {
    format!("{}+{}", route.name(), mapping.name())
}

/// A format of the mapping: storage and planes are no part of a route's text.
pub(crate) fn timed_format(mapping: DepthMapping) -> DepthFormat {
    let of = |far_m| DepthFormat::new(mapping, DepthStorage::Float32, 1.0, far_m);
    of(FAR_M).expect("a far plane beyond the near plane")
}

/// Constants under which it is timed.
pub(crate) fn timed_constants(route: PositionRoute, mapping: DepthMapping) -> Vec<[f32; 4]> {
    let place = RegionPicture::new(1.0, LATITUDE_DEG, ON_THE_SURFACE);
    let of = |place: &RegionPicture| {
        let view = view_of(place, TIMED_DISTANCE_M, timed_format(mapping));
        route.constants(&view, &place.region)
    };
    place.as_ref().map_or_else(Vec::new, of)
}

/// Pixels and depths that are timed.
pub(crate) fn timed_inputs() -> Vec<[f32; 4]> {
    let places = (1..).map(halton).take(EVALUATIONS_PER_DISPATCH);
    let (nearest, size) = (Vec3::Z * 0.1, Vec3::new(1920.0, 1080.0, 0.8));
    let inputs = places.map(|at| at.as_vec3() * size + nearest);
    inputs.map(|at| at.extend(0.0).to_array()).collect()
}
