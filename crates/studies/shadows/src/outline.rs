// SPDX-License-Identifier: MIT OR Apache-2.0
//! Outlines of many models by a stencil value instead of clears (McGuire & Hughes, 2004), as a stencil of
//! 8 bits along one line of pixels.
//!
//! A model covers an interval and its contour is drawn over the interval's rim, a pixel in and a pixel
//! out. What lies inside the model is to be suppressed.

use terrafill_results::SplitMix64;

/// Pixels of the line.
const WIDTH: usize = 512;
/// A stencil without a model.
const NONE: u8 = 255;

terrafill_results::named! {
    /// How inner contours are suppressed.
    all pub(crate) enum Way {
        /// The stencil is cleared for each model.
        Clear = "clear",
        /// A value for each model; contours pass where the stencil differs from it.
        Value = "value",
        /// As printed: they pass where it is equal.
        ValueAsPrinted = "value as printed",
        /// Values that run over without a clear: the failing twin.
        ValueNeverCleared = "value, never cleared",
    }
}

/// Clears, and contour pixels drawn or left out wrongly.
pub(crate) fn outlines(models: u32, way: Way) -> (u64, u64) {
    let mut random = SplitMix64::new(u64::from(models));
    let (mut stencil, mut clears, mut wrong) = ([NONE; WIDTH], 1, 0);
    let mut value = 0_u32;
    for model in 0..models {
        let first = 1 + random.below(WIDTH - 12);
        let past = first + 2 + random.below(8);
        let clear_now = if way == Way::Clear {
            model > 0
        } else {
            value = (value + 1) % 255;
            value == 0 && way != Way::ValueNeverCleared
        };
        if clear_now {
            stencil = [NONE; WIDTH];
            clears += 1;
        }
        let own = u8::try_from(value).unwrap_or(NONE);
        stencil[first..past].fill(own);
        for contour in [first - 1, first, past - 1, past] {
            let is_drawn = (stencil[contour] == own) == (way == Way::ValueAsPrinted);
            wrong += u64::from(is_drawn == (first..past).contains(&contour));
        }
    }
    (clears, wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clears_grow_by_one_in_255_models_and_twins_are_wrong() {
        for models in [1, 254, 255, 509, 510, 1_000, 5_000] {
            let by_value = outlines(models, Way::Value);
            assert_eq!(by_value, (1 + u64::from(models / 255), 0), "{models}");
            assert_eq!(outlines(models, Way::Clear), (u64::from(models), 0));
            let (_, printed) = outlines(models, Way::ValueAsPrinted);
            assert_eq!(printed, 4 * u64::from(models), "every contour pixel");
        }
        assert_eq!(outlines(254, Way::ValueNeverCleared), (1, 0));
        let (clears, wrong) = outlines(1_000, Way::ValueNeverCleared);
        assert!(clears == 1 && wrong > 0, "{wrong}");
    }
}
