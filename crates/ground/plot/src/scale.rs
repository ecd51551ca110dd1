// SPDX-License-Identifier: MIT OR Apache-2.0
//! Axes: where a value stands on the drawing, and which values deserve a tick.

use crate::number::significant;

/// Tick values per decade, from coarse to fine.
const MANTISSAS: [&[f64]; 4] = [
    &[1.0],
    &[1.0, 3.0],
    &[1.0, 2.0, 5.0],
    &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
];

/// Fewest ticks from which an axis can be read.
const MIN_TICKS: usize = 3;

/// The most decades that are all labelled; of more, every second or third.
const MAX_DECADES: usize = 10;

/// Steps of a linear axis that people read without reckoning.
const LINEAR_STEPS: [f64; 3] = [1.0, 2.0, 5.0];

/// A logarithmic axis from `low` to `high`, drawn from `start_px` to `end_px`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LogScale {
    low: f64,
    high: f64,
    start_px: f64,
    end_px: f64,
}

impl LogScale {
    /// An axis that holds all `values` with a margin, at least the factor `min_margin` each way,
    /// so that one point stands in the middle of an axis and not on both of its ends; `None` when no
    /// value is positive and finite.
    pub(crate) fn around(
        values: impl IntoIterator<Item = f64>,
        min_margin: f64,
        start_px: f64,
        end_px: f64,
    ) -> Option<Self> {
        let (low, high) = values
            .into_iter()
            .filter(|value| value.is_finite() && *value > 0.0)
            .fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        if low > high {
            return None;
        }
        let margin = (high / low).powf(0.08).max(min_margin);
        Some(Self {
            low: low / margin,
            high: high * margin,
            start_px,
            end_px,
        })
    }

    /// Where `value` stands, clamped to the axis.
    pub(crate) fn px(&self, value: f64) -> f64 {
        let at = (value / self.low).ln() / (self.high / self.low).ln();
        self.start_px + at.clamp(0.0, 1.0) * (self.end_px - self.start_px)
    }

    /// Its lower end.
    pub(crate) fn low(&self) -> f64 {
        self.low
    }

    /// Its upper end.
    pub(crate) fn high(&self) -> f64 {
        self.high
    }

    /// Ticks in rising order.
    pub(crate) fn ticks(&self) -> Vec<f64> {
        for mantissas in MANTISSAS {
            let ticks = self.decade_ticks(mantissas);
            if ticks.len() >= MIN_TICKS {
                let step = ticks.len().div_ceil(MAX_DECADES);
                return match mantissas {
                    [_] => ticks.into_iter().step_by(step).collect(),
                    _ => ticks,
                };
            }
        }
        linear_ticks(self.low, self.high)
    }

    fn decade_ticks(&self, mantissas: &[f64]) -> Vec<f64> {
        let mut ticks = Vec::new();
        let mut decade = 10_f64.powf(self.low.log10().floor());
        while decade <= self.high {
            ticks.extend(
                mantissas
                    .iter()
                    .map(|mantissa| mantissa * decade)
                    .filter(|tick| (self.low..=self.high).contains(tick)),
            );
            decade *= 10.0;
        }
        ticks
    }
}

/// About five round values between `low` and `high`.
pub(crate) fn linear_ticks(low: f64, high: f64) -> Vec<f64> {
    let span = high - low;
    if !(span > 0.0 && span.is_finite()) {
        return Vec::new();
    }
    let decade = 10_f64.powf((span / 5.0).log10().floor());
    let step = LINEAR_STEPS
        .iter()
        .chain(&[10.0])
        .map(|step| step * decade)
        .find(|step| span / step <= 6.0)
        .unwrap_or(decade * 10.0);
    let mut tick = (low / step).ceil() * step;
    let mut ticks = Vec::new();
    while tick <= high {
        ticks.push(tick);
        tick += step;
    }
    ticks
}

/// A tick's label: as short as it can be said.
pub(crate) fn tick_label(value: f64) -> String {
    let text = significant(value);
    let (mantissa, exponent) = match text.split_once('e') {
        Some((mantissa, exponent)) => (mantissa, format!("e{exponent}")),
        None => (text.as_str(), String::new()),
    };
    let mantissa = match mantissa.split_once('.') {
        Some(_) => mantissa.trim_end_matches('0').trim_end_matches('.'),
        None => mantissa,
    };
    format!("{mantissa}{exponent}")
}

/// A tick of an axis of counts.
#[allow(
    clippy::cast_possible_truncation,
    reason = "ticks are not negative and far below 2^53"
)]
pub(crate) fn whole(tick: f64) -> u64 {
    tick.round() as u64
}

/// A length as a label.
#[must_use]
pub fn length(metres: f64) -> String {
    if metres >= 1000.0 {
        format!("{} km", tick_label(metres / 1000.0))
    } else {
        format!("{} m", tick_label(metres))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_ratios_are_equal_distances() {
        let scale = LogScale::around([1.0, 100.0], 1.2, 0.0, 1000.0).expect("positive values");
        let step = scale.px(10.0) - scale.px(1.0);
        assert!((scale.px(100.0) - scale.px(10.0) - step).abs() < 1e-9);
        assert!(scale.px(1e-9) >= 0.0 && scale.px(1e9) <= 1000.0);
        // Negative control: a linear axis would fail the first line.
        assert!((scale.px(55.0) - (scale.px(10.0) + scale.px(100.0)) / 2.0).abs() > 10.0);
    }

    #[test]
    fn nothing_positive_is_no_axis() {
        assert_eq!(
            LogScale::around([0.0, -1.0, f64::NAN, f64::INFINITY], 1.2, 0.0, 1.0),
            None
        );
    }

    #[test]
    fn every_range_gets_a_few_ticks_inside_it() {
        for (low, high) in [
            (1.0, 1.0),
            (0.97, 1.04),
            (3.0, 8.0),
            (0.3, 30.0),
            (1e-3, 1e6),
            (1e-12, 1e15),
        ] {
            let scale = LogScale::around([low, high], 1.2, 0.0, 1.0).expect("positive values");
            let ticks = scale.ticks();
            assert!((3..=14).contains(&ticks.len()), "{low} … {high}: {ticks:?}");
            assert!(ticks.iter().all(|t| (scale.low..=scale.high).contains(t)));
        }
    }

    #[test]
    fn tick_labels_are_short() {
        assert_eq!(tick_label(1.0), "1");
        assert_eq!(tick_label(0.5), "0.5");
        assert_eq!(tick_label(200.0), "200");
        assert_eq!(tick_label(0.05), "0.05");
        assert_eq!(tick_label(1e-9), "1e-9");
        assert_eq!(tick_label(1.5e8), "1.5e8");
    }

    #[test]
    fn the_knob_reads_as_a_length() {
        assert_eq!(length(100.0), "100 m");
        assert_eq!(length(5000.0), "5 km");
        assert_eq!(length(0.5), "0.5 m");
    }
}
