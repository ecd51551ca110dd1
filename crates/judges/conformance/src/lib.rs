// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far a backend's picture is from the reference's, and whether that is too far.
//!
//! Pictures are of region ids and of texture coordinates, and nothing knows how they were made. The first
//! operand is always the reference: band, tiny pieces and relative area come from it, so swapping
//! the operands gives other figures (a test holds that down). One picture needs no other: that of a bare globe.

mod boundary;
mod compare;
mod difference;
mod distance;
mod figures;
mod globe;
mod moved;
mod tally;
mod texture;
mod tolerance;
mod verdict;

pub use boundary::{boundary_band, boundary_pixels, checks_nothing};
pub use compare::{CompareError, MAX_PROBED, compare, compare_closely, filled_only};
pub use difference::{difference_rgb, worst_pixel};
pub use figures::ErrorFigures;
pub use globe::{GlobeError, globe_mismatch, rolled_globe};
pub use moved::{
    MAX_MEASURED, MAX_PICTURE_SEARCH_PX, Movement, boundary_movement, boundary_rounding,
    movement_in_picture, with_movement,
};
pub use tally::Tally;
pub use texture::{TextureErrors, compare_texture, silhouette_band};
pub use tolerance::{
    BAND_RADIUS_PX, BORDER_ROUNDING, DEPTH_JUMP, MAX_FOREIGN_PX, MAX_HAUSDORFF_PX,
    MAX_MISMATCHED_OUTSIDE_BAND_PX, MAX_NON_FINITE, MAX_ROUNDED_PX, MAX_TEXELS, MAX_TEXELS_RMS,
    MOVED_SEARCH_PX, MOVED_STEP_PX, RASTERISER_PX, SMALLEST_PIECE_PX, allowed_moved_px,
};
pub use verdict::{Verdict, texture_verdict, verdict, verdict_of_moved};
