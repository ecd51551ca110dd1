// SPDX-License-Identifier: MIT OR Apache-2.0
//! What plots with two logarithmic axes have in common: the grid with its ticks and titles, whiskers,
//! and the names of curves below the panel or beside the curves' ends.

use crate::PlotError;
use crate::WIDTH_PX;
use crate::canvas::{Anchor, Canvas, TEXT_PX, text_width};
use crate::number::elided;
use crate::palette::{Palette, Stroke};
use crate::scale::{LogScale, tick_label};
use plotters::prelude::Color as _;

/// Height of a line of names.
pub(crate) const NAME_PX: f64 = 19.0;
/// From a name's marker to its text.
const NAME_INDENT_PX: f64 = 12.0;
/// Between a name and the next one's marker.
const NAME_GAP_PX: f64 = 28.0;
/// From the panel to the names at its right.
const NAMES_ASIDE_PX: f64 = 16.0;
/// Longest name of a curve before its middle is left out.
const NAME_CHARS: usize = 80;

/// Opacity of a curve's line.
pub(crate) const LINE_OPACITY: f64 = 0.7;

/// Where a panel stands on the drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

/// Lines upwards at the ticks of the horizontal axis, their labels and the axis' title below.
///
/// # Errors
/// [`PlotError`].
pub(crate) fn draw_across(
    canvas: &Canvas<'_>,
    frame: Frame,
    scale: &LogScale,
    title: &str,
) -> Result<(), PlotError> {
    for tick in scale.ticks() {
        let x = scale.px(tick);
        canvas.rule([x, frame.top], [x, frame.bottom], 0.12)?;
        canvas.text(&tick_label(tick), [x, frame.bottom + 12.0], Anchor::Middle)?;
    }
    let middle = f64::midpoint(frame.left, frame.right);
    canvas.text(title, [middle, frame.bottom + 34.0], Anchor::Middle)
}

/// Lines across at the ticks of the vertical axis, their labels and the axis' title at the left.
///
/// - `scale`: `None` leaves the axis empty
/// - `[top, bottom]`: as far as the axis reaches
///
/// # Errors
/// [`PlotError`].
pub(crate) fn draw_up(
    canvas: &Canvas<'_>,
    frame: Frame,
    scale: Option<&LogScale>,
    [top, bottom]: [f64; 2],
    title: &str,
) -> Result<(), PlotError> {
    let ticks = scale.map_or(Vec::new(), LogScale::ticks);
    for (tick, scale) in ticks.into_iter().zip(scale.into_iter().cycle()) {
        let y = scale.px(tick);
        canvas.rule([frame.left, y], [frame.right, y], 0.12)?;
        canvas.text(&tick_label(tick), [frame.left - 8.0, y], Anchor::Right)?;
    }
    canvas.rule([frame.left, top], [frame.left, bottom], 0.6)?;
    let middle = f64::midpoint(top, bottom);
    canvas.upright_text(title, [frame.left - 62.0, middle])
}

/// A Pareto front as dashed stairs between its corners, left to right.
///
/// # Errors
/// [`PlotError`].
pub(crate) fn draw_stairs(canvas: &Canvas<'_>, corners: &[[f64; 2]]) -> Result<(), PlotError> {
    for pair in corners.windows(2) {
        let corner = [pair[1][0], pair[0][1]];
        canvas.dashes(pair[0], corner)?;
        canvas.dashes(corner, pair[1])?;
    }
    Ok(())
}

/// Each name once, in order of appearance.
pub(crate) fn distinct<'a>(names: impl Iterator<Item = &'a String>) -> Vec<String> {
    let mut distinct: Vec<String> = Vec::new();
    for name in names {
        if !distinct.contains(name) {
            distinct.push(name.clone());
        }
    }
    distinct
}

/// Where names stand below the panels: side by side from `at`, a new line where the next would run out
/// of the drawing.
pub(crate) fn names_below(names: &[String], at: [f64; 2]) -> Vec<([f64; 2], String)> {
    let start = at[0];
    let mut at = at;
    let mut places = Vec::new();
    for name in names {
        let name = elided(name, NAME_CHARS);
        let width = NAME_INDENT_PX + text_width(&name, TEXT_PX);
        if at[0] > start && at[0] + width > WIDTH_PX {
            at = [start, at[1] + NAME_PX];
        }
        places.push((at, name));
        at[0] += width + NAME_GAP_PX;
    }
    places
}

/// Room that names take at the right of a panel.
pub(crate) fn names_width<'a>(names: impl IntoIterator<Item = &'a str>) -> f64 {
    let widths = names.into_iter().map(|name| text_width(name, TEXT_PX));
    widths.fold(0.0, f64::max) + NAMES_ASIDE_PX + NAME_INDENT_PX
}

/// A name with its curve's marker.
///
/// # Errors
/// [`PlotError`].
pub(crate) fn draw_name(
    canvas: &Canvas<'_>,
    name: &str,
    at: [f64; 2],
    stroke: Stroke,
) -> Result<(), PlotError> {
    let reach = NAME_INDENT_PX * 0.75;
    let line = [[at[0] - reach, at[1]], [at[0] + reach, at[1]]];
    canvas.path(&line, stroke.colour.mix(LINE_OPACITY), 2)?;
    canvas.marker(at, stroke)?;
    canvas.text(name, [at[0] + NAME_INDENT_PX, at[1]], Anchor::Left)
}

/// A name with the vertical line of its method, the marker at the foot.
///
/// # Errors
/// [`PlotError`].
pub(crate) fn draw_line_name(
    canvas: &Canvas<'_>,
    name: &str,
    at: [f64; 2],
    stroke: Stroke,
) -> Result<(), PlotError> {
    let [x, y] = at;
    let foot = [x, y + 0.25 * NAME_PX];
    let line = [[x, y - 0.45 * NAME_PX], foot];
    canvas.path(&line, stroke.colour.mix(LINE_OPACITY), 2)?;
    canvas.marker(foot, stroke)?;
    canvas.text(name, [x + NAME_INDENT_PX, y], Anchor::Left)
}

/// Names at the right of a panel, each as near to the height that it wants as the others let it.
///
/// - `names`: height of the curve's end, name as in `palette`, and text
///
/// # Errors
/// [`PlotError`].
pub(crate) fn draw_names_aside(
    canvas: &Canvas<'_>,
    frame: Frame,
    mut names: Vec<(f64, &str, String)>,
    palette: &Palette,
) -> Result<(), PlotError> {
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted: Vec<f64> = names.iter().map(|(y, ..)| *y).collect();
    let x = frame.right + NAMES_ASIDE_PX;
    for (y, (_, name, text)) in apart(&wanted, [frame.top, frame.bottom]).iter().zip(names) {
        draw_name(canvas, &text, [x, *y], palette.stroke(name))?;
    }
    Ok(())
}

/// Rising heights, moved so that any two are [`NAME_PX`] apart: down first, and up again where they
/// would pass the lower end.
pub(crate) fn apart(wanted: &[f64], [top, bottom]: [f64; 2]) -> Vec<f64> {
    let mut free = top;
    let mut places: Vec<f64> = wanted
        .iter()
        .map(|wanted| {
            let at = wanted.max(free);
            free = at + NAME_PX;
            at
        })
        .collect();
    let mut limit = bottom;
    for at in places.iter_mut().rev() {
        *at = at.min(limit);
        limit = *at - NAME_PX;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legend_entries_do_not_run_out_of_the_drawing() {
        let names: Vec<String> = (0..20).map(|i| format!("vertex/variant-{i:02}")).collect();
        let places = names_below(&names, [70.0, 430.0]);
        assert_eq!(places.len(), 20);
        for (at, name) in &places {
            assert!(at[0] + NAME_INDENT_PX + text_width(name, TEXT_PX) <= WIDTH_PX);
        }
        assert!(places[19].0[1] > places[0].0[1], "they wrap");
    }

    #[test]
    fn names_at_one_height_are_spread_and_stay_beside_the_panel() {
        let gaps = |places: &[f64]| places.windows(2).all(|p| p[1] - p[0] >= NAME_PX - 1e-9);
        for wanted in [[200.0, 201.0, 202.0, 300.0], [395.0, 396.0, 399.0, 400.0]] {
            let places = apart(&wanted, [30.0, 400.0]);
            assert!(gaps(&places), "{places:?}");
            assert!(places[0] >= 30.0 && places[3] <= 400.0, "{places:?}");
            // Negative control: where they want to stand they would lie over one another.
            assert!(!gaps(&wanted));
        }
        assert_eq!(apart(&[50.0, 300.0], [30.0, 400.0]), [50.0, 300.0]);
    }
}
