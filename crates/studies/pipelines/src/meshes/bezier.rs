// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bicubic patches divided by every stage that can: the teapot that the paper shows, with a pot of our own.

mod division;
mod study;

pub(crate) use division::{Division, MAX_PATCH_CELLS};
pub(crate) use study::{groups, pot_mesh};
