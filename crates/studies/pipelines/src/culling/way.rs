// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where patches are tested and how, and from where they are seen.

use crate::way::Interface;
use glam::DVec2;

terrafill_results::named! {
    /// Where level 2 takes place.
    all pub(crate) enum CullStage {
        /// Nowhere: all patches of the tiles in view are drawn.
        TilesAlone = "tiles-alone",
        /// On the CPU, which sends a list each frame.
        Cpu = "cpu",
        /// In compute, which makes a list and says how many are drawn.
        Compute = "compute",
        /// The vertex shader labels a point, the geometry shader drops it, as published.
        Geometry = "geometry-shader",
        /// A task shader starts a workgroup of the mesh shader for each patch.
        Task = "task-shader",
    }
}

/// How a patch is tested.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Test {
    /// Not at all.
    Nothing,
    /// Its first corner, projected, against a range of |x/w| and |y/w|.
    Point(f32),
    /// Its box of least and greatest height, against the planes of the frustum.
    Box,
}

/// Ranges of the point test, since the published one is not stated: the view, a quarter more, and twice the view.
pub(crate) const RANGES: [f32; 3] = [1.0, 1.25, 2.0];

impl Test {
    pub(crate) fn name(self) -> String {
        match self {
            Self::Nothing => "none".to_owned(),
            Self::Point(range) => format!("point-{range}"),
            Self::Box => "box".to_owned(),
        }
    }
}

/// An interface, a place and a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CullWay {
    pub(crate) interface: Interface,
    pub(crate) place: CullStage,
    pub(crate) test: Test,
}

impl CullWay {
    /// Every one; the first of each interface culls no patches.
    pub(crate) fn all() -> Vec<Self> {
        let (none, boxes) = (Test::Nothing, Test::Box);
        let points = RANGES.map(Test::Point);
        let mut ways = Vec::new();
        let mut add = |interface, place, tests: &[Test]| {
            ways.extend(tests.iter().map(|&test| Self {
                interface,
                place,
                test,
            }));
        };
        for interface in Interface::ALL {
            add(interface, CullStage::TilesAlone, &[none]);
            add(interface, CullStage::Cpu, &[boxes]);
            add(interface, CullStage::Compute, &[boxes]);
        }
        add(Interface::Vulkan, CullStage::Compute, &points);
        add(Interface::Vulkan, CullStage::Geometry, &[none, boxes]);
        add(Interface::Vulkan, CullStage::Geometry, &points);
        add(Interface::Vulkan, CullStage::Task, &[none, boxes]);
        ways
    }

    /// Whether it is one of those with and without level 2, for a flight.
    pub(crate) fn is_of_flight(&self) -> bool {
        self.interface == Interface::Vulkan
            && !matches!(self.test, Test::Point(_))
            && !matches!(self.place, CullStage::Cpu | CullStage::Task)
    }
}

/// A view of the ground.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ViewKind {
    pub(crate) name: &'static str,
    /// Of the ground's side.
    pub(crate) share: DVec2,
    /// Above the highest corner of the cell there, metres.
    pub(crate) above_m: f64,
    /// Below the horizon, from the x axis to the y axis, and across; degrees.
    pub(crate) angles_deg: [f64; 3],
}

/// Near the middle, inside a tile and a patch.
const NEAR_THE_MIDDLE: DVec2 = DVec2::new(0.471, 0.487);

const fn seen(name: &'static str, above_m: f64, down_deg: f64, wide_deg: f64) -> ViewKind {
    ViewKind {
        name,
        share: NEAR_THE_MIDDLE,
        above_m,
        // No side of any view runs at 45°, along the corners of patches: such ties say nothing.
        angles_deg: [down_deg, 33.0, wide_deg],
    }
}

/// Along the ground through a narrow field, from above, and straight down.
pub(crate) const VIEWS: [ViewKind; 3] = [
    seen("2-m-20-wide", 2.0, 0.0, 20.0),
    seen("2-km-30-down", 2_000.0, 30.0, 60.0),
    seen("10-km-nadir", 10_000.0, 90.0, 60.0),
];

/// Seconds of the flight, as long as the published one.
pub(crate) const FLIGHT_S: u32 = 25;

/// Where the flight is after so many seconds: along the ground's diagonal, from 2 km down to 100 m and up again. It turns
/// by 10° a second. The published path is not stated.
pub(crate) fn flight(second: u32) -> ViewKind {
    let done = f64::from(second) / f64::from(FLIGHT_S);
    let low = (2.0 * done - 1.0).abs();
    ViewKind {
        name: "flight",
        share: DVec2::splat(0.2) + DVec2::new(0.6, 0.55) * done,
        above_m: 100.0 + 1_900.0 * low,
        angles_deg: [5.0 + 20.0 * low, 10.0 * f64::from(second), 60.0],
    }
}
