// SPDX-License-Identifier: MIT OR Apache-2.0
//! One formula under one condition: what is measured of it, and under which names it is written.

use crate::metrics::*;
use std::collections::BTreeMap;
use terrafill_results::{CaseId, ConditionKey, Metric, Status, Verdict};

terrafill_results::named! {
    /// Which question a row answers.
    #[derive(Hash, PartialOrd, Ord, Default)]
    pub enum PrecisionPart {
        /// From a fragment's offset to longitude and latitude.
        #[default]
        Coordinate = "coordinate",
        /// From a fragment's pixel and depth to its offset.
        Position = "position",
        /// From a stored vertex to its position relative to the eye.
        Vertex = "vertex",
        /// A coordinate route at an input where formulas break.
        Special = "special",
    }
}

/// One formula under one condition.
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
    /// Lowest and highest point, metres above the body's surface.
    pub heights_m: Option<[f64; 2]>,
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
    /// Why measured and expected error differ by more than twice, where they do.
    pub residual_reason: String,
    /// The device's answer to a special input.
    pub device_answer: String,
    /// The emulation's.
    pub emulated_answer: String,
    /// By metric; one that was not measured is absent, and `reason` says why.
    pub(crate) figures: BTreeMap<&'static str, f64>,
}

impl PrecisionRow {
    pub(crate) fn new(part: PrecisionPart, route: &str, condition: String) -> Self {
        let mut row = Self {
            part,
            route: route.to_owned(),
            family: route.to_owned(),
            condition,
            ..Self::default()
        };
        row.put(CHOSEN, 0.0);
        row
    }

    /// A figure, where it was measured.
    #[must_use]
    pub fn figure(&self, metric: &Metric) -> Option<f64> {
        self.figures.get(metric.name).copied()
    }

    /// Sets a figure; an absent one leaves what is there.
    pub(crate) fn put(&mut self, metric: &'static Metric, value: impl Into<Option<f64>>) {
        let figure = value.into().map(|value| (metric.name, value));
        self.figures.extend(figure);
    }

    /// Sets two figures, or neither.
    pub(crate) fn put_both(&mut self, metrics: [&'static Metric; 2], values: Option<[f64; 2]>) {
        for (metric, value) in metrics.into_iter().zip(values.into_iter().flatten()) {
            self.put(metric, value);
        }
    }

    /// Sets the size of a pixel, and the largest and root mean square error in pixels, of these in metres.
    pub(crate) fn put_pixels(&mut self, pixel_m: f64, errors_m: [&'static Metric; 2]) {
        self.put(PIXEL_M, pixel_m);
        for (metric, metres) in [MAX_PX, RMS_PX].into_iter().zip(errors_m) {
            self.put(metric, self.figure(metres).map(|metres| metres / pixel_m));
        }
    }

    /// Answers that are not finite, emulated or on the device.
    #[must_use]
    pub fn non_finite(&self) -> u64 {
        let counts = [NON_FINITE_EMULATED, NON_FINITE_DEVICE];
        let counts = counts.map(|metric| self.figure(metric).and_then(whole));
        counts.into_iter().flatten().sum()
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
            number(LOWEST_M, self.heights_m.map(|[lowest, _]| lowest)),
            number(HIGHEST_M, self.heights_m.map(|[_, highest]| highest)),
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
            figures: self
                .figures
                .iter()
                .map(|(name, value)| (*name, *value))
                .collect(),
            notes: vec![
                ("residual_reason", self.residual_reason.clone()),
                ("device_answer", self.device_answer.clone()),
                ("emulated_answer", self.emulated_answer.clone()),
            ],
            ..Verdict::default()
        }
    }
}

/// A figure that counts something.
#[allow(
    clippy::cast_possible_truncation,
    reason = "counts are whole, not negative and far below 2^53"
)]
pub(crate) fn whole(value: f64) -> Option<u64> {
    (value.is_finite() && value >= 0.0).then(|| value.round() as u64)
}
