// SPDX-License-Identifier: MIT OR Apache-2.0
//! One formula under one condition: what is measured of it, and under which names it is written.

use crate::conditions::{
    ANCHOR, CONDITION, DEPTH_FORMAT, DISTANCE_M, EXTENT_DEG, FAMILY, HIGHEST_M, KNOB, LATITUDE_DEG,
    LOWEST_M, PART, ROUTE,
};
use terrafill_results::{CaseId, ConditionKey, Kind, Metric, Primary, Scope, Status, Verdict};

/// Which question a row answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
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

/// One formula under one condition. An empty cell was not measured, and `reason` says why.
#[derive(Debug, Clone, PartialEq, Default)]
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
    pub depth_format: String,
    /// Of a position: where the region's anchor stands: `plan`, where a frame plan puts it, or `middle`.
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
    pub residual_reason: String,
    /// The device's answer to a special input.
    pub device_answer: String,
    /// The emulation's.
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
    /// Whether a frame plan would take this route here.
    pub chosen: bool,
}

impl PrecisionRow {
    /// Answers that are not finite, emulated or on the device.
    #[must_use]
    pub fn non_finite(&self) -> u64 {
        self.non_finite_emulated.unwrap_or(0) + self.non_finite_device.unwrap_or(0)
    }

    /// What this row is in the tables.
    pub(crate) fn id(&self) -> CaseId {
        let name = format!("{}/{}/{}", self.part.name(), self.route, self.condition);
        let number =
            |key: ConditionKey, value: Option<f64>| value.map(|value| (key, value.to_string()));
        let text =
            |key: ConditionKey, value: &str| (!value.is_empty()).then(|| (key, value.to_owned()));
        let conditions = [
            text(PART, self.part.name()),
            text(ROUTE, &self.route),
            text(FAMILY, &self.family),
            number(KNOB, self.knob),
            text(CONDITION, &self.condition),
            number(EXTENT_DEG, self.extent_deg),
            number(LATITUDE_DEG, self.latitude_deg),
            number(LOWEST_M, self.lowest_m),
            number(HIGHEST_M, self.highest_m),
            number(DISTANCE_M, self.distance_m),
            text(DEPTH_FORMAT, &self.depth_format),
            text(ANCHOR, &self.anchor),
        ];
        CaseId::new(crate::STUDY, name, conditions.into_iter().flatten())
    }

    /// What the runner writes of it.
    pub(crate) fn verdict(&self) -> Verdict {
        Verdict {
            status: self.status,
            reason: self.reason.clone(),
            figures: FIGURES
                .iter()
                .filter_map(|(metric, value)| Some((metric.name, value(self)?)))
                .collect(),
            notes: vec![
                ("residual_reason", self.residual_reason.clone()),
                ("device_answer", self.device_answer.clone()),
                ("emulated_answer", self.emulated_answer.clone()),
            ],
        }
    }
}

/// A figure of a row.
type Figure = (Metric, fn(&PrecisionRow) -> Option<f64>);

/// Every figure of a row with its declaration.
const FIGURES: [Figure; 31] = [
    (
        Metric::neither(
            "points",
            "",
            Kind::Counter,
            "Places at which the error was measured.",
        ),
        |row| Some(f64::from(row.points)),
    ),
    (
        Metric::less(
            "non_finite_emulated",
            "",
            Kind::Error,
            "Answers of the emulation that are NaN or infinite.",
        ),
        |row| row.non_finite_emulated.map(|count| count as f64),
    ),
    (
        Metric::less(
            "non_finite_device",
            "",
            Kind::Error,
            "Answers of the device that are NaN or infinite.",
        ),
        |row| row.non_finite_device.map(|count| count as f64),
    ),
    (
        Metric::less(
            "emulated_max_m",
            "m",
            Kind::Error,
            "Largest error of the shader's steps run in `f32` on the CPU, metres on the ground or in space.",
        ),
        |row| row.emulated_max_m,
    ),
    (
        Metric::less(
            "emulated_rms_m",
            "m",
            Kind::Error,
            "Root mean square of those errors.",
        ),
        |row| row.emulated_rms_m,
    ),
    (
        Metric::less(
            "device_max_m",
            "m",
            Kind::Error,
            "Largest error of the shader's text run on the device, metres.",
        ),
        |row| row.device_max_m,
    ),
    (
        Metric::less(
            "device_rms_m",
            "m",
            Kind::Error,
            "Root mean square of those errors.",
        ),
        |row| row.device_rms_m,
    ),
    (
        Metric::less(
            "device_max_rad",
            "rad",
            Kind::Error,
            "Largest error on the device of longitude or latitude, radians.",
        ),
        |row| row.device_max_rad,
    ),
    (
        Metric::less(
            "device_rms_rad",
            "rad",
            Kind::Error,
            "Root mean square error on the device, the larger of longitude's and latitude's, radians.",
        ),
        |row| row.device_rms_rad,
    ),
    (
        Metric::neither(
            "texture_px",
            "texels",
            Kind::Counter,
            "Texels along each side of the picture over the extent, in which `max_texels` counts.",
        ),
        |row| row.texture_px.map(f64::from),
    ),
    (
        Metric::less(
            "max_texels",
            "texels",
            Kind::Error,
            "Largest error on the device along one axis of the picture, texels. Places nearer to a pole than a texel do not count: there a row of texels is one place.",
        ),
        |row| row.max_texels,
    ),
    (
        Metric::less(
            "rms_texels",
            "texels",
            Kind::Error,
            "Root mean square error on the device along one axis, texels, as above.",
        ),
        |row| row.rms_texels,
    ),
    (
        Metric::neither(
            "pixel_m",
            "m",
            Kind::Counter,
            "Size on the ground of the pixels in which `max_px` counts: the region's height over 1,080 rows, or a view of 60° over as many at the row's distance.",
        ),
        |row| row.pixel_m,
    ),
    (
        Metric::less(
            "max_px",
            "px",
            Kind::Error,
            "Largest error on the device, pixels.",
        ),
        |row| row.max_px,
    ),
    (
        Metric::less(
            "rms_px",
            "px",
            Kind::Error,
            "Root mean square error on the device, pixels.",
        ),
        |row| row.rms_px,
    ),
    (
        Metric::neither(
            "residual_max_m",
            "m",
            Kind::Error,
            "Largest error by formula, metres: what the steps leave out in exact arithmetic, sampled densely, and the bound of what a device that keeps to the specification may round. It is computed for every region anew.",
        ),
        |row| row.residual_max_m,
    ),
    (
        Metric::neither(
            "residual_rms_m",
            "m",
            Kind::Error,
            "Root mean square error by formula, metres: roundings taken as independent.",
        ),
        |row| row.residual_rms_m,
    ),
    (
        Metric::neither(
            "residual_max_rad",
            "rad",
            Kind::Error,
            "Largest error by formula, radians of longitude or latitude.",
        ),
        |row| row.residual_max_rad,
    ),
    (
        Metric::neither(
            "residual_rms_rad",
            "rad",
            Kind::Error,
            "Root mean square error by formula, radians, the larger of the two.",
        ),
        |row| row.residual_rms_rad,
    ),
    (
        Metric::neither(
            "expected_max_rad",
            "rad",
            Kind::Error,
            "Largest error by formula on a device that rounds every step correctly: 2.5 standard deviations of independent roundings in the bound's place, radians. A texture is read as this device's sampler weighs it, which is asked first.",
        ),
        |row| row.expected_max_rad,
    ),
    (
        Metric::less(
            "max_over_residual",
            "",
            Kind::Error,
            "`device_max_m` over `residual_max_m`. Above 1.02, what sampling may miss of a peak, the bound does not hold and the row is wrong.",
        ),
        |row| row.max_over_residual,
    ),
    (
        Metric::less(
            "rms_over_residual",
            "",
            Kind::Error,
            "The same of the root mean squares.",
        ),
        |row| row.rms_over_residual,
    ),
    (
        Metric::less(
            "measured_over_expected",
            "",
            Kind::Error,
            "`device_max_rad` over `expected_max_rad`; of positions and vertices, `rms_over_residual`.",
        ),
        |row| row.measured_over_expected,
    ),
    (
        Metric::less(
            "add_mul_fma",
            "",
            Kind::Counter,
            "Sums, differences, products and fused ones of a formula.",
        ),
        |row| row.add_mul_fma.map(f64::from),
    ),
    (
        Metric::less("divisions", "", Kind::Counter, "Divisions."),
        |row| row.divisions.map(f64::from),
    ),
    (
        Metric::less(
            "compares_selects",
            "",
            Kind::Counter,
            "Comparisons, selects, minima and maxima.",
        ),
        |row| row.compares_selects.map(f64::from),
    ),
    (
        Metric::less("sqrt", "", Kind::Counter, "Square roots and inverse ones."),
        |row| row.sqrt.map(f64::from),
    ),
    (
        Metric::less(
            "transcendental",
            "",
            Kind::Counter,
            "Calls of the device's own `atan`, `atan2` and powers.",
        ),
        |row| row.transcendental.map(f64::from),
    ),
    (
        Metric::less(
            "texture_fetches",
            "",
            Kind::Counter,
            "Texels loaded and samples taken.",
        ),
        |row| row.texture_fetches.map(f64::from),
    ),
    (
        Metric::less(
            "operations_cost",
            "",
            Kind::Counter,
            "All of them in fused multiply-adds, weighted as the chooser of a route does: a division 5, a square root 4, a transcendental 30, a fetch 100.",
        ),
        |row| row.operations_cost,
    ),
    (
        Metric::neither(
            "chosen",
            "",
            Kind::Counter,
            "Whether a frame plan takes this route in the row's region: the cheapest whose residual is within ¼ texel and ¼ pixel RMS and ½ texel at most.",
        ),
        |row| Some(f64::from(u8::from(row.chosen))),
    ),
];

/// Time of an evaluation beyond the empty formula, by the two clocks.
pub(crate) const TIMES: [Metric; 2] = [
    Metric::less(
        "cpu_ns",
        "ns",
        Kind::Time,
        "CPU time of the process for one evaluation of a formula beyond that of the empty one in the \
         same block. On a software device this is the device's time. It may be negative where the \
         formula costs less than the clock's noise.",
    ).covering(Scope::DISPATCH).ranking(Primary::Cpu),
    Metric::less("gpu_ns", "ns", Kind::Time, "The same by the GPU's clock.").covering(Scope::DISPATCH).ranking(Primary::Gpu),
];

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; FIGURES.len() + TIMES.len()] = {
    let mut all = [TIMES[0]; FIGURES.len() + TIMES.len()];
    let mut index = 0;
    while index < FIGURES.len() {
        all[index] = FIGURES[index].0;
        index += 1;
    }
    all[index] = TIMES[0];
    all[index + 1] = TIMES[1];
    all
};
