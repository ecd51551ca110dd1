// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every tolerance, with its cause.
//!
//! | tolerance | value | cause |
//! |---|---|---|
//! | [`BAND_RADIUS_PX`] | 1 | rasterisers snap vertices to 1/256 pixel and round depth, so the pixel that a boundary crosses may fall to either side. No other pixel may. Boundaries between the centres of the reference's pixels count ([`crate::compare_closely`]; where moved on purpose, [`crate::boundary_movement`]) |
//! | [`BORDER_ROUNDING`] | 2⁻²⁴ of the distance | positions relative to the eye are rounded to f32; a facet in the plane of a wall, such as a skirt, then shows either side of it or none; a quarter of it is enough for the extreme suite |
//! | [`MAX_MISMATCHED_OUTSIDE_BAND_PX`] | 0 | beyond the band no rounding reaches; what is wrong there is a leak, a missing wall or another region's colour |
//! | [`MAX_HAUSDORFF_PX`] | 1 | a boundary that moved by less than a pixel moves its pixels by one at most; what stays in the band but goes missing over a length, such as a strip two pixels wide, shows up here only |
//! | [`allowed_moved_px`] | what is stated, 1/16 and 1/256 | a boundary drawn aside on purpose moves by as much as was stated for it; it is looked for in steps of [`MOVED_STEP_PX`], and then snapped to [`RASTERISER_PX`] |
//! | [`MAX_ROUNDED_PX`] | 1/32 | of what nobody moved two corners snap and depth rounds, each by up to [`RASTERISER_PX`]. The tip of a tooth may lie between the places that are asked. At most 1/64 was seen. Asked only beyond [`MAX_HAUSDORFF_PX`] ([`crate::boundary_rounding`]) |
//! | [`MAX_FOREIGN_PX`] | 4 | two neighbours' positions round each by themselves, to a ten-thousandth of a pixel from afar, and ten thousand pixels lie on borders: one of them belongs to both or to none; 1 is the most that was seen |
//! | [`SMALLEST_PIECE_PX`] | 4 | a piece of 1 to 3 pixels exists by the luck of where pixel centres fall; rounding may take it whole, or give it whole where the reference shows it between its pixels, and the distance to the next boundary is then anything |
//! | [`MAX_NON_FINITE`] | 0 | NaN compares false with everything, so it would hide in any other figure |
//! | [`MAX_TEXELS_RMS`] | ¼ | filtering with 8-bit weights blends neighbours in steps of 1/256 texel and eyes tell a quarter of one at best; a route to coordinates is chosen by that |
//! | [`MAX_TEXELS`] | ½ | twice the mean: a pixel that is off by more shows a neighbour's texel |
//! | [`COARSEST_SNAP_PX`] | 1/16 | the coarsest steps that rasterisers may snap vertices to |
//! | [`DEPTH_ROUNDING_M`] | 100 | positions and depths in `f32` are rounded to 1 m at the distance of a whole globe; interpolation of depth loses a few bits more |
//! | [`DEPTH_JUMP`] | 5 % | seen from 2 km the reciprocal distance of neighbouring rows bends by 2 % of itself two pixels below the horizon, and by less everywhere else on a smooth surface |

/// How far from a boundary pixel of the reference a mismatch is put down to rounding; counted in
/// steps to the eight neighbours.
pub const BAND_RADIUS_PX: u32 = 1;

/// How close to a wall a point of the surface may lie to be on either side of it, as a share of its
/// distance from the eye.
pub const BORDER_ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Mismatched pixels allowed outside the band.
pub const MAX_MISMATCHED_OUTSIDE_BAND_PX: u64 = 0;

/// Largest symmetric Hausdorff distance between the boundaries, pixels.
pub const MAX_HAUSDORFF_PX: f64 = 1.0;

/// Steps in which [`crate::boundary_movement`] looks for a boundary, pixels: what it finds may be as much
/// farther than the truth.
pub const MOVED_STEP_PX: f64 = 1.0 / 16.0;

/// How far it looks, pixels: twice the band, in which all that moved on purpose stays.
pub const MOVED_SEARCH_PX: f64 = 2.0;

/// Pixels allowed on borders that were moved on purpose that show neither side ([`crate::Movement`]).
pub const MAX_FOREIGN_PX: u64 = 4;

/// Rasterisers snap corners to this part of a pixel (Vulkan 1.3, `subPixelPrecisionBits` of 8).
pub const RASTERISER_PX: f64 = 1.0 / 256.0;

/// How far from the centre of a mismatched pixel the reference shows the pixel's id at most, where no boundary
/// was moved on purpose, pixels.
pub const MAX_ROUNDED_PX: f64 = 8.0 * RASTERISER_PX;

/// How far boundaries may be found to have moved that were drawn up to `moved_px` pixels aside.
#[must_use]
pub fn allowed_moved_px(moved_px: f64) -> f64 {
    moved_px + MOVED_STEP_PX + RASTERISER_PX
}

/// Pieces of the reference with fewer pixels are left out of the Hausdorff distance.
pub const SMALLEST_PIECE_PX: u64 = 4;

/// NaN or infinite results allowed.
pub const MAX_NON_FINITE: u64 = 0;

/// Root of the mean square of the texture coordinates' errors allowed, texels, of `u` and of `v`.
pub const MAX_TEXELS_RMS: f64 = 0.25;

/// Largest error of a texture coordinate allowed, texels.
pub const MAX_TEXELS: f64 = 0.5;

/// Vertices are snapped to steps of at most this part of a pixel (Vulkan 1.3, `subPixelPrecisionBits` of 4).
pub(crate) const COARSEST_SNAP_PX: f64 = 1.0 / 16.0;

/// What a depth of a globe seen as a whole may be off by rounding, metres.
pub(crate) const DEPTH_ROUNDING_M: f64 = 100.0;

/// Between two pixels is a silhouette where the reciprocal distance foretold from either side is
/// off by more than this share.
pub const DEPTH_JUMP: f64 = 0.05;
