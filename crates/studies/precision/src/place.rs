// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions at which coordinate routes are measured: extent × latitude × heights.

use glam::DVec3;
use std::f64::consts::FRAC_PI_2;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_texture::{
    Demand, MapExtent, MapRegion, SUITE_EXTENTS_DEG, SUITE_LATITUDES_DEG, Sample,
};

/// Heights and widths of the regions that a quick run measures, degrees.
const QUICK_EXTENTS_DEG: [f64; 4] = [1e-2, 1.0, 10.0, 360.0];

/// Latitudes of their middles, degrees. At 90 they are caps round the pole. What touches a pole is
/// anchored there.
const QUICK_LATITUDES_DEG: [f64; 3] = [0.0, 45.0, 90.0];

/// Heights: on the surface, to the deepest sea, to the highest mountain, both ten times exaggerated.
const HEIGHTS_M: [(&str, f64, f64); 4] = [
    ("0", 0.0, 0.0),
    ("-11km", -11_000.0, 0.0),
    ("+9km", 0.0, 9_000.0),
    ("x10", -110_000.0, 90_000.0),
];

/// Texels along each side of a region's picture: what is common for a region, and for a globe.
const REGION_TEXTURE_PX: u32 = 4096;
const GLOBE_TEXTURE_PX: u32 = 16_384;
/// Extent from which a region's picture is a globe's.
const GLOBE_FROM_DEG: f64 = 90.0;

/// Rows of the view that a region's height just fills.
pub(crate) const VIEW_ROWS: f64 = 1080.0;

/// A region, its picture and its view.
#[derive(Debug, Clone)]
pub(crate) struct RegionPicture {
    pub(crate) extent_deg: f64,
    pub(crate) latitude_deg: f64,
    pub(crate) heights: (&'static str, f64, f64),
    pub(crate) region: MapRegion,
}

/// Every region once: those that would reach over a pole are moved to end there, and fall together.
pub(crate) fn places(quick: bool) -> Vec<RegionPicture> {
    let (extents, latitudes, heights) = if quick {
        (
            &QUICK_EXTENTS_DEG[..],
            &QUICK_LATITUDES_DEG[..],
            &HEIGHTS_M[2..],
        )
    } else {
        (
            &SUITE_EXTENTS_DEG[..],
            &SUITE_LATITUDES_DEG[..],
            &HEIGHTS_M[..],
        )
    };
    let mut places: Vec<RegionPicture> = Vec::new();
    for &extent_deg in extents {
        for &latitude_deg in latitudes {
            for &heights in heights {
                let Some(place) = RegionPicture::new(extent_deg, latitude_deg, heights) else {
                    continue;
                };
                let same = |other: &RegionPicture| {
                    other.heights == place.heights && other.region.extent() == place.region.extent()
                };
                if !places.iter().any(same) {
                    places.push(place);
                }
            }
        }
    }
    places
}

impl RegionPicture {
    /// `None` for bounds that are none, and for a cap that is the globe.
    pub(crate) fn new(
        extent_deg: f64,
        latitude_deg: f64,
        heights: (&'static str, f64, f64),
    ) -> Option<Self> {
        let half = 0.5 * extent_deg.min(180.0);
        let is_cap = latitude_deg >= 90.0;
        if is_cap && half >= 90.0 {
            // The globe, which is there already.
            return None;
        }
        let middle = latitude_deg.clamp(half - 90.0, 90.0 - half);
        // Away from longitude 0, so that the anchor's longitude matters.
        let extent = if is_cap {
            MapExtent::from_degrees(-160.0, 90.0 - half, 200.0, 90.0)
        } else {
            let (west, east) = (20.0 - 0.5 * extent_deg, 20.0 + 0.5 * extent_deg);
            MapExtent::from_degrees(west, middle - half, east, middle + half)
        };
        let region = MapRegion::anchored(Ellipsoid::WGS84, extent, (heights.1, heights.2));
        Some(Self {
            extent_deg,
            latitude_deg,
            heights,
            region: region.ok()?,
        })
    }

    /// As in the `condition` column.
    pub(crate) fn name(&self) -> String {
        format!(
            "extent={};latitude={};heights={}",
            self.extent_deg, self.latitude_deg, self.heights.0
        )
    }

    /// Texels along each side of its picture.
    pub(crate) fn texture_px(&self) -> u32 {
        if self.extent_deg < GLOBE_FROM_DEG {
            REGION_TEXTURE_PX
        } else {
            GLOBE_TEXTURE_PX
        }
    }

    /// Size on the ground of a pixel of the view that the region's height fills, metres.
    pub(crate) fn pixel_m(&self) -> f64 {
        let [_, height] = self.region.extent().size_rad();
        height * self.region.body().equatorial_radius_m() / VIEW_ROWS
    }

    /// What the chooser gets.
    pub(crate) fn demand(&self) -> Demand {
        Demand {
            region: self.region,
            texture_size: [self.texture_px(); 2],
            pixel_m: self.pixel_m(),
        }
    }

    /// `count` places within, spread evenly, after the corners of extent and heights.
    pub(crate) fn points(&self, count: u32) -> Vec<Sample> {
        let corner = |i: u32, bit: u32| f64::from((i >> bit) & 1);
        let corners = (0..8).map(|i| [corner(i, 0), corner(i, 1), corner(i, 2)]);
        let spread = (1..=count).map(|index| halton(index).to_array());
        corners.chain(spread).map(|at| self.point(at)).collect()
    }

    fn point(&self, [u, v, w]: [f64; 3]) -> Sample {
        let extent = self.region.extent();
        let [width, height] = extent.size_rad();
        let (_, low, high) = self.heights;
        self.region.sample(Geodetic {
            longitude_rad: extent.west_rad + u * width,
            latitude_rad: (extent.south_rad + v * height).clamp(-FRAC_PI_2, FRAC_PI_2),
            height_m: low + w * (high - low),
        })
    }
}

/// Places spread evenly from 0 to 1 along each axis: Halton's sequence (1960).
pub(crate) fn halton(index: u32) -> DVec3 {
    DVec3::from_array([2, 3, 5].map(|base| radical_inverse(index, base)))
}

/// Digits of `index` in `base`, mirrored at the point.
fn radical_inverse(mut index: u32, base: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(index % base);
        index /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_condition_of_the_grid_is_there_once() {
        let places = places(false);
        let names: BTreeSet<String> = places.iter().map(RegionPicture::name).collect();
        assert_eq!(names.len(), places.len());
        // Five extents on five latitudes; of 90° three distinct ones; the globe; four heights each.
        assert_eq!(places.len(), (5 * 5 + 3 + 1) * 4);
        assert!(names.contains("extent=0.001;latitude=85;heights=x10"));
        assert!(names.contains("extent=10;latitude=90;heights=-11km"));
    }

    #[test]
    fn points_lie_within_and_reach_the_corners() {
        let place = RegionPicture::new(10.0, 45.0, HEIGHTS_M[3]).expect("bounds");
        let half = 5.0_f64.to_radians();
        let points = place.points(500);
        assert_eq!(points.len(), 508);
        // An offset rounded to f32 is a quarter of a metre off at most.
        let slack = 1e-6;
        for point in &points {
            assert!(
                point
                    .angles_rad
                    .iter()
                    .all(|angle| angle.abs() <= half + slack)
            );
        }
        let at_corner = |point: &&Sample| point.angles_rad.iter().all(|a| a.abs() > half - slack);
        assert_eq!(points.iter().filter(at_corner).count(), 8);
        // Negative control: places of a wider region do not.
        let wide = RegionPicture::new(11.0, 45.0, HEIGHTS_M[3]).expect("bounds");
        let beyond = |point: &Sample| point.angles_rad.iter().any(|a| a.abs() > half + slack);
        assert!(wide.points(500).iter().any(beyond));
    }

    #[test]
    fn the_sequence_is_haltons() {
        let first: Vec<f64> = (1..=4).map(|i| radical_inverse(i, 2)).collect();
        assert_eq!(first, [0.5, 0.25, 0.75, 0.125]);
        assert!((radical_inverse(5, 3) - 7.0 / 9.0).abs() < 1e-15);
    }
}
