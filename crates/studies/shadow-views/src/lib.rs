// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the parts of study `shadows` share: cameras in the port, and rays as the reference. Volumes are counted as a
//! stencil counts them, within rectangles and near planes, or drawn by devices.
//!
//! Metres, `f64`, ENU axes from the sea at the origin, as `terrafill-casters` has them.

mod count;
mod device;
mod images;
mod lamp;
mod near;
mod positions;
mod reference;
mod rounding;
mod scissor;
mod sea;
mod seen;
mod source;
mod view;

pub use count::{Pass, Rule, Stencil, Wrong, slivers};
pub use device::{Channel, Draws, Interface, Retile, sum_of};
pub use images::{picture, write};
pub use lamp::{Beam, Lamp, LampReference};
pub use near::{Boxes, EyeTest, chosen, is_shadowed_at_corners, near_caps, shadowed_share};
pub use positions::{Positions, count, eye_vertices};
pub use reference::{Light, Reference, SEA_RADIUS_M, Seen, Truth};
pub use rounding::{ROUNDING_PX, SeenPlace, is_joint, is_within_rounding};
pub use scissor::{
    NONE, above_horizon, around, around_pixels, cut, depths_of_parts, joined, of_parts,
};
pub use sea::surface;
pub use seen::{constants, listed, seen_by};
pub use source::{Adjacency, Adjacent, Computed, EyeMesh, EyeVolumes, IS_CAP, VolumeSource};
pub use view::{DeckCamera, EYE_SIZE, box_of, bridge, deck_eyes, eyes_within, sun, whole};
