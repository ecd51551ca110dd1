// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bytes each variant holds for a scene: one bar per variant, stacked by purpose.
//!
//! A variant keeps its colour from the other plots; the purposes are shades of it. Bytes are the
//! largest over the scene's views: geometry is the same in all of them, per-view constants vary.

use super::canvas::{Anchor, Canvas, svg};
use super::palette::{INK, Palette};
use super::scale::{linear_ticks, whole};
use super::{WIDTH_PX, label, label_column};
use crate::ReportError;
use crate::number;
use crate::run_data::{Case, SceneCases};
use plotters::prelude::Color as _;

/// The variant whose bytes the others' are divided by.
const BASE: &str = "vertex/doubled";

const ROW_PX: f64 = 24.0;
const TOP_PX: f64 = 34.0;
const AXIS_PX: f64 = 48.0;
const VALUE_COLUMN_PX: f64 = 190.0;

/// Purposes from the axis outwards, and the opacity of each.
const PARTS: [(&str, f64); 3] = [
    ("positions and flags", 1.0),
    ("indices", 0.6),
    ("constants per view", 0.3),
];

/// What one variant holds.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Bytes {
    /// As in [`PARTS`].
    parts: [u64; 3],
    /// Positions, flags and indices.
    geometry: u64,
    label: String,
    series: String,
}

impl Bytes {
    /// `None` when the row holds no byte counts.
    fn of(case: &Case) -> Option<Self> {
        let geometry = case.value(|row| row.geometry_bytes)?;
        let index = case.value(|row| row.index_bytes).unwrap_or(0);
        let vertex = case.value(|row| row.vertex_bytes);
        Some(Self {
            parts: [
                vertex.unwrap_or(geometry.saturating_sub(index)),
                index,
                case.value(|row| row.constant_bytes).unwrap_or(0),
            ],
            geometry,
            label: label(case),
            series: case.series(),
        })
    }

    fn total(&self) -> u64 {
        self.parts.iter().sum()
    }
}

/// Draws the plot; `None` when no case of the scene holds byte counts.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn geometry_bytes(
    scene: &SceneCases<'_>,
    palette: &Palette,
) -> Result<Option<String>, ReportError> {
    let variants = largest_by_variant(scene);
    let most = variants
        .iter()
        .map(|(_, bytes)| bytes.total())
        .max()
        .unwrap_or(0);
    if most == 0 {
        return Ok(None);
    }
    let base = variants
        .iter()
        .find_map(|(name, bytes)| (name == BASE).then_some(bytes.geometry));
    let left = label_column(variants.iter().map(|(_, bytes)| bytes.label.clone()));
    let right = WIDTH_PX - VALUE_COLUMN_PX;
    let bottom = TOP_PX + variants.len() as f64 * ROW_PX;
    let title = format!("{}: bytes per variant", scene.name);
    svg(&title, WIDTH_PX, bottom + AXIS_PX, |canvas| {
        let scale = (right - left - 6.0) / most as f64;
        draw_legend(canvas, left)?;
        for tick in linear_ticks(0.0, most as f64) {
            let x = left + tick * scale;
            canvas.rule([x, TOP_PX], [x, bottom], 0.12)?;
            let label = number::bytes(whole(tick));
            canvas.text(&label, [x, bottom + 12.0], Anchor::Middle)?;
        }
        canvas.rule([left, TOP_PX], [left, bottom], 0.6)?;
        canvas.text(
            "bytes on the device, largest over the views",
            [left, bottom + 34.0],
            Anchor::Left,
        )?;
        let mut y = TOP_PX + ROW_PX * 0.5;
        for (_, bytes) in &variants {
            canvas.text(&bytes.label, [left - 10.0, y], Anchor::Right)?;
            let colour = palette.stroke(&bytes.series).colour;
            let mut x = left;
            for (part, (_, opacity)) in bytes.parts.iter().zip(PARTS) {
                let end = x + *part as f64 * scale;
                canvas.bar([x, y - 7.0], [end, y + 7.0], colour.mix(opacity))?;
                x = end;
            }
            canvas.text(&value_label(bytes, base), [right + 10.0, y], Anchor::Left)?;
            y += ROW_PX;
        }
        Ok(())
    })
    .map(Some)
}

/// In the order in which the variants first appear.
fn largest_by_variant(scene: &SceneCases<'_>) -> Vec<(String, Bytes)> {
    let mut variants: Vec<(String, Bytes)> = Vec::new();
    for case in scene.views.iter().flat_map(|view| &view.cases) {
        let Some(bytes) = Bytes::of(case) else {
            continue;
        };
        let name = case.name();
        match variants.iter_mut().find(|(known, _)| *known == name) {
            Some((_, most)) if bytes.total() > most.total() => *most = bytes,
            Some(_) => {}
            None => variants.push((name, bytes)),
        }
    }
    variants
}

fn draw_legend(canvas: &Canvas<'_>, left: f64) -> Result<(), ReportError> {
    let mut x = left;
    for (name, opacity) in PARTS {
        canvas.bar([x, 8.0], [x + 14.0, 20.0], INK.mix(opacity))?;
        canvas.text(name, [x + 20.0, 14.0], Anchor::Left)?;
        x += 60.0 + super::canvas::text_width(name, super::canvas::TEXT_PX);
    }
    Ok(())
}

/// Geometry bytes, and their ratio to the base variant's.
fn value_label(bytes: &Bytes, base: Option<u64>) -> String {
    let geometry = number::bytes(bytes.geometry);
    match base.filter(|base| *base > 0) {
        Some(base) => format!(
            "{geometry} · {} ×",
            number::significant(bytes.geometry as f64 / base as f64)
        ),
        None => geometry,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ratio_is_to_the_base_and_absent_without_it() {
        let bytes = Bytes {
            parts: [300, 160, 999],
            geometry: 460,
            label: String::new(),
            series: String::new(),
        };
        assert_eq!(value_label(&bytes, Some(1000)), "460 B · 0.460 ×");
        assert_eq!(value_label(&bytes, None), "460 B");
        assert_eq!(value_label(&bytes, Some(0)), "460 B");
    }
}
