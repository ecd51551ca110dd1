// SPDX-License-Identifier: MIT OR Apache-2.0
//! A series as a drawing that fits a table's cell: its course, its marked changes, its newest value.

use crate::canvas::escaped;
use crate::palette::{FASTER, SLOWER, hex};

/// Size, CSS pixels: six rows of text wide, two lines high.
const WIDTH_PX: f64 = 220.0;
const HEIGHT_PX: f64 = 32.0;
/// Room for marks and for half a stroke.
const MARGIN_PX: f64 = 6.0;

/// Smallest relative range that fills the height: less would show noise as mountains.
const MIN_RANGE: f64 = 0.02;

/// A course of values, the oldest first.
#[derive(Debug, Clone, Copy)]
pub struct Sparkline<'a> {
    /// What it shows, for readers who do not see it.
    pub title: &'a str,
    /// Finite values.
    pub values: &'a [f64],
    /// Places of changes with whether each is for the better; `None` where it is neither.
    pub marks: &'a [(usize, Option<bool>)],
}

impl Sparkline<'_> {
    /// The drawing. Worse is a triangle that points up, better one that points down: nothing rests on
    /// colour alone.
    #[must_use]
    pub fn svg(&self) -> String {
        let low = self.values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self
            .values
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let middle = f64::midpoint(low, high);
        let range = (high - low)
            .max(middle.abs() * MIN_RANGE)
            .max(f64::MIN_POSITIVE);
        let steps = self.values.len().saturating_sub(1).max(1) as f64;
        let x = |place: usize| MARGIN_PX + (WIDTH_PX - 2.0 * MARGIN_PX) * place as f64 / steps;
        let y =
            |value: f64| HEIGHT_PX / 2.0 - (value - middle) / range * (HEIGHT_PX - 2.0 * MARGIN_PX);
        let mut course = String::new();
        for (place, value) in self.values.iter().enumerate() {
            let word = if place == 0 { 'M' } else { 'L' };
            course += &format!("{word}{:.0} {:.0}", x(place), y(*value));
        }
        let mut marks = String::new();
        for &(place, is_better) in self.marks {
            let Some(value) = self.values.get(place) else {
                continue;
            };
            let (x, y) = (x(place), y(*value).clamp(MARGIN_PX, HEIGHT_PX - MARGIN_PX));
            let (colour, path) = match is_better {
                Some(false) => (hex(SLOWER.colour), "l5 9h-10z"),
                Some(true) => (hex(FASTER.colour), "m0 9l5-9h-10z"),
                None => ("currentColor".to_owned(), "l4 4.5l-4 4.5l-4-4.5z"),
            };
            marks += &format!(
                "<path fill=\"{colour}\" d=\"M{x:.0} {:.1}{path}\"/>",
                y - 4.5
            );
        }
        let last = match self.values.last() {
            Some(value) => format!(
                "<circle cx=\"{:.0}\" cy=\"{:.0}\" r=\"2\" fill=\"currentColor\"/>",
                x(self.values.len() - 1),
                y(*value)
            ),
            None => String::new(),
        };
        format!(
            "<svg role=\"img\" aria-label=\"{}\" width=\"{WIDTH_PX}\" height=\"{HEIGHT_PX}\" \
             viewBox=\"0 0 {WIDTH_PX} {HEIGHT_PX}\"><path fill=\"none\" stroke=\"currentColor\" \
             d=\"{course}\"/>{last}{marks}</svg>",
            escaped(self.title)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(values: &[f64], marks: &[(usize, Option<bool>)]) -> String {
        Sparkline {
            title: "a <b>",
            values,
            marks,
        }
        .svg()
    }

    #[test]
    fn marks_differ_in_shape_and_stand_at_their_values() {
        let values = [1.0, 1.0, 2.0, 2.0];
        let worse = drawn(&values, &[(2, Some(false))]);
        let better = drawn(&values, &[(2, Some(true))]);
        assert!(worse.contains("l5 9h-10z") && !better.contains("l5 9h-10z"));
        assert!(worse.contains(&hex(SLOWER.colour)) && better.contains(&hex(FASTER.colour)));
        assert!(worse.contains("a &lt;b>"));
        // Negative controls: no mark, and one beside the series.
        for marks in [&[][..], &[(9, None)]] {
            assert_eq!(drawn(&values, marks).matches("<path").count(), 1);
        }
    }

    #[test]
    fn noise_is_flat_and_nothing_is_an_empty_drawing() {
        let flat = drawn(&[10.0, 10.01, 10.0], &[]);
        assert!(
            flat.contains("M6 17L110 15L214 17") || flat.contains("L110 1"),
            "{flat}"
        );
        let heights: Vec<f64> = flat
            .split(['L', 'M', '"'])
            .filter_map(|part| part.split_once(' ')?.1.parse().ok())
            .filter(|height| *height < HEIGHT_PX)
            .collect();
        assert!(
            heights.iter().all(|height| (13.0..=19.0).contains(height)),
            "{flat}"
        );
        assert!(!drawn(&[], &[]).contains("<circle"));
        assert!(!drawn(&[0.0, 0.0], &[]).contains("NaN"));
    }
}
