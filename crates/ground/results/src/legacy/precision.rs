// SPDX-License-Identifier: MIT OR Apache-2.0
//! The numerical suite's rows: what a formula's error is, on the CPU by emulation and on the device,
//! beside what it was computed to be and what it costs.
//!
//! Beside `precision.csv` (a row per formula and condition) stand `precision_times.csv` (a row per
//! formula and round) and `precision.json`, the plan, so that a missing row is known to be missing.

use crate::Status;
use serde::{Deserialize, Serialize};

/// Which question a row answers.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, Default,
)]
#[serde(rename_all = "lowercase")]
pub enum PrecisionPart {
    /// From a fragment's offset to longitude and latitude.
    #[default]
    Coordinate,
    /// From a fragment's pixel and depth to its offset.
    Position,
    /// From a stored vertex to its position relative to the eye.
    Vertex,
    /// A coordinate route at an input where formulas break.
    Special,
}

impl PrecisionPart {
    /// As in the `part` column.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Coordinate => "coordinate",
            Self::Position => "position",
            Self::Vertex => "vertex",
            Self::Special => "special",
        }
    }
}

/// What tells one row from all others.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PrecisionKey {
    /// Which question.
    pub part: PrecisionPart,
    /// Formula.
    pub route: String,
    /// Under which condition, as in the `condition` column.
    pub condition: String,
}

impl std::fmt::Display for PrecisionKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}/{}", self.part.name(), self.route, self.condition)
    }
}

/// One formula under one condition. An empty cell was not measured, and `reason` says why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Default)]
pub struct PrecisionRow {
    /// Which question.
    pub part: PrecisionPart,
    /// Formula.
    pub route: String,
    /// What is one curve: the route without its knob.
    pub family: String,
    /// The knob's value: degree, texels; empty where there is none.
    pub knob: Option<f64>,
    /// Extent, latitude and heights, or distance and depth, or the special input.
    pub condition: String,
    /// Height of the region, degrees; its width too, but for caps.
    pub extent_deg: Option<f64>,
    /// Latitude of its middle, degrees; a region that would reach over a pole is moved to end there.
    pub latitude_deg: Option<f64>,
    /// Lowest point, metres above the body's surface.
    pub lowest_m: Option<f64>,
    /// Highest point.
    pub highest_m: Option<f64>,
    /// From the eye to the fragment or vertex, metres.
    pub distance_m: Option<f64>,
    /// Depth format.
    #[serde(default)]
    pub depth_format: String,
    /// Of a position: where the region's anchor stands: `plan`, where a frame plan puts it, or `middle`.
    #[serde(default)]
    pub anchor: String,
    /// How it ended; `wrong`: an answer that is not finite, or an error above the residual.
    pub status: Status,
    /// Why, unless `ok`.
    pub reason: String,
    /// Places at which the error was measured.
    pub points: u32,
    /// Emulated answers that are not finite.
    pub non_finite_emulated: Option<u64>,
    /// The device's answers that are not finite.
    pub non_finite_device: Option<u64>,
    /// Largest error of the emulation, metres on the ground or in space.
    pub emulated_max_m: Option<f64>,
    /// Root mean square error of the emulation, metres.
    pub emulated_rms_m: Option<f64>,
    /// Largest error on the device, metres.
    pub device_max_m: Option<f64>,
    /// Root mean square error on the device, metres.
    pub device_rms_m: Option<f64>,
    /// The same in radians of longitude or latitude, the larger of the two.
    pub device_max_rad: Option<f64>,
    /// Root mean square, radians, the larger of the two.
    pub device_rms_rad: Option<f64>,
    /// Texels of the texture that `max_texels` counts in, along each side of the extent.
    pub texture_px: Option<u32>,
    /// Largest error on the device, texels along one axis.
    pub max_texels: Option<f64>,
    /// Root mean square error on the device, texels along one axis.
    pub rms_texels: Option<f64>,
    /// Size on the ground of a pixel that `max_px` counts in, metres.
    pub pixel_m: Option<f64>,
    /// Largest error on the device, pixels.
    pub max_px: Option<f64>,
    /// Root mean square error on the device, pixels.
    pub rms_px: Option<f64>,
    /// Largest error by formula, metres.
    pub residual_max_m: Option<f64>,
    /// Root mean square error by formula, metres.
    pub residual_rms_m: Option<f64>,
    /// Largest error by formula, radians.
    pub residual_max_rad: Option<f64>,
    /// Root mean square error by formula, radians.
    pub residual_rms_rad: Option<f64>,
    /// Largest error to be expected of a device that rounds every step correctly and samples textures as
    /// this one does, radians.
    pub expected_max_rad: Option<f64>,
    /// Largest error on the device over its bound by formula.
    pub max_over_residual: Option<f64>,
    /// Root mean square error on the device over that by formula.
    pub rms_over_residual: Option<f64>,
    /// Measured over expected: largest errors of angles, root mean squares of lengths.
    pub measured_over_expected: Option<f64>,
    /// Why these differ by more than twice, where they do.
    #[serde(default)]
    pub residual_reason: String,
    /// The device's answer to a special input.
    #[serde(default)]
    pub device_answer: String,
    /// The emulation's.
    #[serde(default)]
    pub emulated_answer: String,
    /// Sums, products, fused ones.
    pub add_mul_fma: Option<u32>,
    /// Divisions.
    pub divisions: Option<u32>,
    /// Comparisons, selects, minima, maxima.
    pub compares_selects: Option<u32>,
    /// Square roots.
    pub sqrt: Option<u32>,
    /// The device's own transcendental functions.
    pub transcendental: Option<u32>,
    /// Texel loads and samples.
    pub texture_fetches: Option<u32>,
    /// All of them, weighted as the chooser does, in fused multiply-adds.
    pub operations_cost: Option<f64>,
    /// An evaluation beyond the empty one, CPU time of the process, nanoseconds: median over rounds.
    pub cpu_ns: Option<f64>,
    /// 5th percentile.
    pub cpu_ns_p5: Option<f64>,
    /// 95th percentile.
    pub cpu_ns_p95: Option<f64>,
    /// The same by the GPU's clock, median.
    pub gpu_ns: Option<f64>,
    /// Rounds behind the medians.
    pub rounds: u32,
    /// Whether a frame plan would take this route here.
    #[serde(default)]
    pub chosen: bool,
}

impl PrecisionRow {
    /// What tells this row from all others.
    #[must_use]
    pub fn key(&self) -> PrecisionKey {
        PrecisionKey {
            part: self.part,
            route: self.route.clone(),
            condition: self.condition.clone(),
        }
    }

    /// Answers that are not finite, emulated or on the device.
    #[must_use]
    pub fn non_finite(&self) -> u64 {
        self.non_finite_emulated.unwrap_or(0) + self.non_finite_device.unwrap_or(0)
    }
}

/// One timed pass of a formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PrecisionTime {
    /// Which question the formula belongs to.
    pub part: PrecisionPart,
    /// Formula.
    pub route: String,
    /// Counts rounds from 0; in each, every formula and the empty one take a turn.
    pub round: u32,
    /// Evaluations in the pass.
    pub evaluations: u64,
    /// CPU time of the process, milliseconds.
    pub cpu_ms: f64,
    /// That of the empty formula in the same round.
    pub empty_cpu_ms: f64,
    /// By the GPU's clock; empty where it gave none.
    pub gpu_ms: Option<f64>,
    /// The empty formula's.
    pub empty_gpu_ms: Option<f64>,
}

impl PrecisionTime {
    /// An evaluation beyond the empty one, CPU time of the process, nanoseconds. It may come out
    /// negative where the formula costs less than the clock's noise.
    #[must_use]
    pub fn cpu_ns(&self) -> f64 {
        (self.cpu_ms - self.empty_cpu_ms) * 1e6 / self.evaluations as f64
    }

    /// The same by the GPU's clock.
    #[must_use]
    pub fn gpu_ns(&self) -> Option<f64> {
        Some((self.gpu_ms? - self.empty_gpu_ms?) * 1e6 / self.evaluations as f64)
    }
}

/// Formulas of a part, each under each condition.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PrecisionGrid {
    /// Which question.
    pub part: PrecisionPart,
    /// Formulas.
    pub routes: Vec<String>,
    /// Conditions.
    pub conditions: Vec<String>,
}

/// What the suite set out to measure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, Default)]
pub struct PrecisionPlan {
    /// Its grids.
    pub grids: Vec<PrecisionGrid>,
    /// Timed rounds of each coordinate and position formula.
    pub rounds: u32,
}

impl PrecisionPlan {
    /// Every row that is to be.
    pub fn keys(&self) -> impl Iterator<Item = PrecisionKey> + '_ {
        self.grids.iter().flat_map(|grid| {
            grid.conditions.iter().flat_map(|condition| {
                grid.routes.iter().map(|route| PrecisionKey {
                    part: grid.part,
                    route: route.clone(),
                    condition: condition.clone(),
                })
            })
        })
    }
}
