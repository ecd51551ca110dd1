// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sensors that fly and sweep: cones by frame, from a seed, and their footprints.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};
use terrafill_core::{
    EdgeRule, Ellipsoid, Footprint, FootprintMesher, Geodetic, MovingFootprint, Region, RegionMesh,
    SensorCone,
};
use terrafill_study::{Failure, SplitMix64};

/// Frames after which the sweep begins again: two seconds at 30 a second.
pub(crate) const FRAMES: u32 = 60;
/// Vertices of each footprint: at 8,000 km above ground its chords are within 0.1 px of the curve.
pub(crate) const VERTICES: u32 = 256;

/// Middle of the area that sensors fly over, and its half widths, degrees: all of it is in view of the
/// globe's camera.
const MIDDLE_DEG: [f64; 2] = [15.0, 20.0];
const HALF_WIDTH_DEG: [f64; 2] = [48.0, 38.0];
/// Of apexes above the ground, metres: low orbits of the Earth.
const HEIGHTS_M: [f64; 2] = [500_000.0, 900_000.0];
/// Between a cone's axis and the vertical, degrees.
const TILTS_DEG: [f64; 2] = [5.0, 22.0];
/// Between a cone's axis and its edge, degrees. With the largest tilt the edge stays 19° off the
/// horizon of the highest apex.
const HALF_ANGLES_DEG: [f64; 2] = [5.0, 18.0];
/// Along the ground, degrees of arc a frame: 30 times as fast as a satellite, to be seen.
const SPEED_DEG: f64 = 0.06;
const SEED: u64 = 2007;

/// One sensor at the first frame.
#[derive(Debug, Clone, Copy)]
struct Sensor {
    start_deg: [f64; 2],
    heading_rad: f64,
    height_m: f64,
    tilt_rad: f64,
    half_angle_rad: f64,
    /// Of the axis at the first frame; a sweep is a whole turn.
    azimuth_rad: f64,
}

/// All sensors of a case.
#[derive(Debug, Clone)]
pub(crate) struct Sensors {
    mesher: FootprintMesher,
    sensors: Vec<Sensor>,
}

impl Sensors {
    /// The first `count` sensors over `body`; more of them are the same and further ones.
    pub(crate) fn new(body: Ellipsoid, count: usize) -> Result<Self, Failure> {
        let mut random = SplitMix64::new(SEED);
        let mut between = |[low, high]: [f64; 2]| low + (high - low) * random.unit();
        let sensors = (0..count).map(|_| Sensor {
            start_deg: [0, 1].map(|axis| {
                MIDDLE_DEG[axis] + between([-HALF_WIDTH_DEG[axis], HALF_WIDTH_DEG[axis]])
            }),
            heading_rad: between([0.0, TAU]),
            height_m: between(HEIGHTS_M),
            tilt_rad: between(TILTS_DEG).to_radians(),
            half_angle_rad: between(HALF_ANGLES_DEG).to_radians(),
            azimuth_rad: between([0.0, TAU]),
        });
        Ok(Self {
            mesher: FootprintMesher::new(body, VERTICES).map_err(Failure::broken)?,
            sensors: sensors.collect(),
        })
    }

    fn cone(sensor: &Sensor, frame: u32) -> SensorCone {
        let done = f64::from(frame % FRAMES);
        let along_deg = SPEED_DEG * done;
        let (east, north) = sensor.heading_rad.sin_cos();
        let [longitude_deg, latitude_deg] = sensor.start_deg;
        let stretched = latitude_deg.to_radians().cos();
        SensorCone {
            apex: Geodetic::from_degrees(
                longitude_deg + along_deg * east / stretched,
                latitude_deg + along_deg * north,
                sensor.height_m,
            ),
            azimuth_rad: (sensor.azimuth_rad + TAU * done / f64::from(FRAMES)) % TAU,
            elevation_rad: sensor.tilt_rad - FRAC_PI_2,
            half_angle_rad: sensor.half_angle_rad,
        }
    }

    fn footprints(&self, frame: u32) -> impl Iterator<Item = Result<(usize, Footprint), Failure>> {
        let sensors = self.sensors.iter().enumerate();
        sensors.map(move |(index, sensor)| {
            let footprint = self.mesher.footprint(&Self::cone(sensor, frame));
            Ok((index, footprint.map_err(Failure::broken)?))
        })
    }

    /// Rings at `frame`, for the reference and the general mesher.
    ///
    /// - `first`: index of the first one among the scene's regions
    pub(crate) fn regions(&self, frame: u32, first: usize) -> Result<Vec<Region>, Failure> {
        let region = |(index, footprint): (usize, Footprint)| Region {
            index: first + index,
            ..self.mesher.region(name(index), &footprint)
        };
        self.footprints(frame).map(|at| at.map(region)).collect()
    }

    /// The discs that a device bends into the footprints.
    ///
    /// - `first`: as in [`Sensors::regions`]
    pub(crate) fn discs(&self, first: usize) -> Vec<RegionMesh> {
        let disc = |index| self.mesher.disc(name(index), first + index);
        (0..self.sensors.len()).map(disc).collect()
    }

    /// What a device bends them by at `frame`, by place in the scene.
    ///
    /// - `first`: as in [`Sensors::regions`]
    pub(crate) fn bent(
        &self,
        frame: u32,
        first: usize,
    ) -> Result<BTreeMap<usize, MovingFootprint>, Failure> {
        let sensors = (first..).zip(&self.sensors);
        let bent = sensors.map(|(place, sensor)| {
            let bent = self.mesher.moving(&Self::cone(sensor, frame));
            Ok((place, bent.map_err(Failure::broken)?))
        });
        bent.collect()
    }

    /// How far a device may be off in f32 for any of these, metres from the apex.
    pub(crate) fn rounding_bound_m(&self, bent: &BTreeMap<usize, MovingFootprint>) -> f64 {
        let steps = self.mesher.steps();
        let bounds = bent.values().map(|bent| bent.edge.rounding_bound_m(steps));
        bounds.fold(0.0, f64::max)
    }

    /// Strips at `frame`.
    ///
    /// - `first`: as in [`Sensors::regions`]
    pub(crate) fn strips(
        &self,
        frame: u32,
        first: usize,
        rule: EdgeRule,
    ) -> Result<Vec<RegionMesh>, Failure> {
        let meshes = self.footprints(frame).map(|at| {
            let (index, footprint) = at?;
            let place = first + index;
            let mesh = self.mesher.mesh(name(index), place, footprint, rule);
            mesh.map_err(Failure::broken)
        });
        meshes.collect()
    }
}

fn name(index: usize) -> String {
    format!("sensor {index}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_footprint_of_every_frame_can_be_followed_and_moves() {
        let sensors = Sensors::new(Ellipsoid::WGS84, 200).expect("vertices");
        for frame in 0..FRAMES {
            let [strips, next] = [frame, frame + 1].map(|frame| {
                let strips = sensors.strips(frame, 10, EdgeRule::Planar);
                strips.expect("all round")
            });
            for (index, (strip, next)) in strips.iter().zip(&next).enumerate() {
                assert_eq!(strip.region_index, 10 + index);
                assert_eq!(strip.vertex_count(), 256);
                assert_ne!(strip.vertices_ecef, next.vertices_ecef);
                // Chords, of which a reference that reads the ring's edges knows nothing.
                let deviation_m = strip.boundary_deviation_m;
                assert!(deviation_m < 2_000.0, "{deviation_m}");
            }
        }
    }

    #[test]
    fn the_sweep_begins_again_and_more_sensors_are_further_ones() {
        let of = |count| Sensors::new(Ellipsoid::WGS84, count).expect("vertices");
        let vertices = |sensors: &Sensors, frame| -> Vec<_> {
            let strips = sensors.strips(frame, 0, EdgeRule::Planar);
            let strips = strips.expect("all round").into_iter();
            strips.map(|strip| strip.vertices_ecef).collect()
        };
        assert_eq!(vertices(&of(3), 0), vertices(&of(3), FRAMES));
        assert_eq!(vertices(&of(3), 5)[..], vertices(&of(5), 5)[..3]);
        assert_ne!(vertices(&of(3), 0), vertices(&of(3), 1));
    }
}
