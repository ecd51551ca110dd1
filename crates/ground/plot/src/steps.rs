// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ratios as a waterfall, one row a step, from the first to the last.
//!
//! A row's bar goes from where its gain begins, the last step that is kept, to its own ratio, which has a
//! dot: its length on the logarithmic axis is the gain. The bar of a step that is not kept is pale and
//! outlined. No bar stands on the axis' edge, which is no zero.

use crate::canvas::{Anchor, Canvas, Spot, TEXT_PX, svg, text_width};
use crate::palette::{FASTER, INK, SLOWER, Stroke};
use crate::ratio::{AxisFrame, RatioAxis};
use crate::{PlotError, WIDTH_PX};
use plotters::prelude::Color as _;
use terrafill_results::Spread;

const ROW_PX: f64 = 21.0;
const TOP_PX: f64 = 30.0;
const VALUE_COLUMN_PX: f64 = 210.0;
/// Half the height of a bar.
const BAR_PX: f64 = 6.0;
/// Room for the legend below the axis' title.
const LEGEND_PX: f64 = 20.0;
/// Width of a sample in the legend.
const SAMPLE_PX: f64 = 22.0;
/// Opacity of a bar: of a step that is kept, and of one that is not.
const OPACITY: [f64; 2] = [0.55, 0.15];

/// Heading of the ratio at which a bar begins.
const BEGINS: &str = "bar begins";
/// What the legend calls a pale bar.
const NOT_KEPT: &str = "not kept: the next step does not start from it";

/// A plot to be.
#[derive(Debug, Clone)]
pub struct Steps<'a> {
    /// For readers who do not see it.
    pub title: String,
    /// What the axis says.
    pub axis: RatioAxis<'a>,
    /// Top to bottom.
    pub rows: Vec<Step>,
}

/// A row.
#[derive(Debug, Clone)]
pub struct Step {
    /// Left of the axis.
    pub label: String,
    /// The ratio, or why there is none.
    pub ratio: Result<Spread, String>,
    /// Ratio at which the bar begins; `None` for no bar.
    pub begins: Option<f64>,
    /// Whether the steps after it begin where it ends.
    pub is_kept: bool,
    /// At the right of a row with a ratio.
    pub value: String,
    /// What a reader types to see it; empty for nothing.
    pub command: String,
}

impl Steps<'_> {
    /// Draws the plot; `None` when no row has a ratio.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn draw(&self) -> Result<Option<String>, PlotError> {
        let frame = AxisFrame::new(
            self.axis,
            self.rows
                .iter()
                .filter_map(|row| row.ratio.as_ref().ok().copied()),
            self.rows.iter().filter_map(|row| row.begins),
            self.rows.iter().map(|row| row.label.as_str()),
            VALUE_COLUMN_PX,
            [TOP_PX, TOP_PX + ROW_PX * self.rows.len() as f64],
        );
        let Some(frame) = frame else {
            return Ok(None);
        };
        let height = frame.height() + LEGEND_PX;
        svg(&self.title, WIDTH_PX, height, |canvas| {
            frame.draw(canvas)?;
            let mut kept: Option<[f64; 2]> = None;
            for (row, number) in self.rows.iter().zip(0_u32..) {
                let y = TOP_PX + ROW_PX * (f64::from(number) + 0.5);
                kept = row.draw(canvas, &frame, y, kept)?;
            }
            legend(canvas, [frame.left, height - 0.5 * LEGEND_PX])
        })
        .map(Some)
    }
}

impl Step {
    /// Draws the row and returns the dot of the last step that is kept.
    fn draw(
        &self,
        canvas: &Canvas<'_>,
        frame: &AxisFrame<'_>,
        y: f64,
        kept: Option<[f64; 2]>,
    ) -> Result<Option<[f64; 2]>, PlotError> {
        frame.draw_label(canvas, &self.label, y)?;
        let ratio = match &self.ratio {
            Ok(ratio) => *ratio,
            Err(why) => {
                frame.draw_absent(canvas, why, y)?;
                return Ok(kept);
            }
        };
        let end = frame.scale.px(ratio.median);
        let begin = self.begins.map(|ratio| frame.scale.px(ratio));
        let is_slower = self.begins.is_some_and(|begins| ratio.median > begins);
        let stroke = if is_slower { SLOWER } else { FASTER };
        if let Some(begin) = begin {
            bar(
                canvas,
                [[begin, y - BAR_PX], [end, y + BAR_PX]],
                stroke,
                self.is_kept,
            )?;
        }
        // Slanted where pairing by process moves the begin away from the dot.
        if let (Some(begin), Some([x, above])) = (begin, kept) {
            canvas.path(
                &[
                    [x, above + BAR_PX],
                    [begin, y - BAR_PX],
                    [begin, y + BAR_PX],
                ],
                INK.mix(0.5),
                1,
            )?;
        }
        frame.draw_whisker(canvas, ratio, y, INK)?;
        let at = [end, y];
        canvas.marker(at, stroke)?;
        let mut values = frame.values(ratio);
        values.extend(self.begins.map(|begins| (BEGINS, begins)));
        canvas.spot(&Spot {
            at,
            group: "",
            name: &self.label,
            values: &values,
            command: &self.command,
        });
        frame.draw_value(canvas, &self.value, y)?;
        Ok(if self.is_kept { Some(at) } else { kept })
    }
}

/// Between two corners; pale and outlined where the step is not kept.
fn bar(
    canvas: &Canvas<'_>,
    [[left, top], [right, bottom]]: [[f64; 2]; 2],
    stroke: Stroke,
    is_kept: bool,
) -> Result<(), PlotError> {
    let opacity = OPACITY[usize::from(!is_kept)];
    canvas.bar([left, top], [right, bottom], stroke.colour.mix(opacity))?;
    if is_kept {
        return Ok(());
    }
    let outline = [
        [left, top],
        [right, top],
        [right, bottom],
        [left, bottom],
        [left, top],
    ];
    canvas.path(&outline, stroke.colour.mix(1.0), 1)
}

/// What the bars are, in a line.
fn legend(canvas: &Canvas<'_>, [mut x, y]: [f64; 2]) -> Result<(), PlotError> {
    let samples = [
        (FASTER, true, "faster than the last kept step"),
        (SLOWER, true, "slower"),
        (FASTER, false, NOT_KEPT),
    ];
    for (stroke, is_kept, text) in samples {
        let end = x + SAMPLE_PX;
        let corners = [[x, y - BAR_PX], [end, y + BAR_PX]];
        bar(canvas, corners, stroke, is_kept)?;
        canvas.text(text, [end + 6.0, y], Anchor::Left)?;
        x = end + 6.0 + text_width(text, TEXT_PX) + 18.0;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: RatioAxis<'static> = RatioAxis {
        title: "time over baseline",
        one: "baseline = 1",
    };

    fn drawn(is_kept: bool) -> String {
        let step = |label: &str, ratio: f64, begins, is_kept| Step {
            label: label.to_owned(),
            ratio: Ok(Spread {
                p5: ratio,
                median: ratio,
                p95: ratio,
            }),
            begins,
            is_kept,
            value: String::new(),
            command: String::new(),
        };
        let steps = Steps {
            title: "steps".to_owned(),
            axis: AXIS,
            rows: vec![
                step("start", 20.0, None, true),
                step("tried", 5.0, Some(20.0), is_kept),
                step("taken", 10.0, Some(20.0), true),
            ],
        };
        steps.draw().expect("draws").expect("ratios")
    }

    #[test]
    fn bars_say_where_they_begin_and_which_steps_are_not_kept() {
        let tried = drawn(false);
        for row in ["start,20,\n", "tried,5,20\n", "taken,10,20\n"] {
            assert!(tried.contains(row), "{row} {tried}");
        }
        assert!(tried.contains(NOT_KEPT), "the legend says what is pale");
        // Negative control: the same step, kept, has one pale bar less, that of the legend aside.
        let pale = |text: &str| text.matches("opacity=\"0.15\"").count();
        assert_eq!((pale(&tried), pale(&drawn(true))), (2, 1));
    }
}
