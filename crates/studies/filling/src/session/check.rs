// SPDX-License-Identifier: MIT OR Apache-2.0
//! One picture held against the reference, without a run around it.

use super::judging::{moved_px, reasons_of};
use super::references::{Against, compare_through};
use terrafill_conformance::{filled_only, verdict_of_moved};
use terrafill_contract::{FillInput, Frame, Technique};
use terrafill_reference::CloseLook;
use terrafill_variant::Variant;

/// How a picture differs from the reference's.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PictureCheck {
    /// Pixels that differ; boundaries may, by rounding.
    pub mismatched_px: u64,
    /// What is beyond its tolerance; nothing of a picture that is approximate by nature.
    pub objections: Vec<String>,
}

impl PictureCheck {
    /// Draws the reference of `input`, and compares as a run does.
    ///
    /// - `frame`: what the variant drew of `input`
    /// - `as_mask`: it tells no regions apart
    ///
    /// # Errors
    /// Why the reference cannot be drawn, or the two cannot be compared.
    pub fn new(
        technique: &dyn Technique,
        variant: &Variant,
        input: &FillInput,
        frame: &Frame,
        as_mask: bool,
    ) -> Result<Self, String> {
        let against = Against::of(technique, variant, input.scene.edge_rule);
        let mut input = input.clone();
        input.scene.edge_rule = against.edges;
        let reference = against.reference();
        let rays = reference.scene(&input).map_err(|error| error.to_string())?;
        let mut expected = reference.judge_in(&input, &rays).frame;
        let mut frame = frame.clone();
        if as_mask {
            (expected, frame) = (filled_only(&expected), filled_only(&frame));
        }
        let is_approximate = technique.is_approximate(variant);
        let options = &input.plan.options;
        let may_move = options.boundary_lod_px.is_some() || options.far_level_px.is_some();
        let look = CloseLook::new(&input, &rays);
        let is_moved = may_move && !is_approximate;
        let figures = compare_through(&look, &expected, &frame, as_mask, is_moved)?;
        let objections = if is_approximate || technique.may_be_wrong(variant) {
            Vec::new()
        } else {
            reasons_of(verdict_of_moved(&figures, moved_px(&input.plan)))
        };
        Ok(Self {
            mismatched_px: figures.mismatched_px,
            objections,
        })
    }
}
