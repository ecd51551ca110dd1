// SPDX-License-Identifier: MIT OR Apache-2.0
//! Figures of one comparison.

/// Difference of one frame from the reference.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErrorFigures {
    /// Pixels filled by the backend.
    pub filled_px: u64,
    /// Pixels whose id differs.
    pub mismatched_px: u64,
    /// Of those, farther than one pixel from every boundary of the reference.
    pub mismatched_px_outside_band: u64,
    /// Symmetric boundary Hausdorff distance, pixels; `None` when either picture lacks a boundary.
    pub hausdorff_px: Option<f64>,
    /// The farthest that a mismatched pixel's centre is from where the reference shows the id that the
    /// frame shows there, pixels. `None` unless boundaries are moved on purpose or their Hausdorff distance is
    /// beyond its limit, and where too many pixels mismatch to be searched for.
    pub boundary_moved_px: Option<f64>,
    /// Mismatched pixels that show an id which the reference shows nowhere near them; `None` as above.
    pub foreign_px: Option<u64>,
    /// Filled pixels over the reference's, minus 1; `None` when the reference fills nothing.
    pub area_error: Option<f64>,
    /// Pieces of fewer than 4 pixels in the reference, or shown by it between the centres of its pixels,
    /// left out of the Hausdorff distance.
    pub tiny_regions: u64,
    /// NaN or infinite results.
    pub non_finite: u64,
}
