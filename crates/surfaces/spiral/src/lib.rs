// SPDX-License-Identifier: MIT OR Apache-2.0
//! One mesh for the whole globe: a spiral around the point below the eye, fine where the eye is near and
//! wide as the horizon. (Gebbie and Bailey, "Fast Realistic Rendering of Global Worlds using Programmable
//! Graphics Hardware".)

mod law;
mod layout;
mod limits;
mod parts;
mod position;
mod spiral;

pub use spiral::SpiralKind;
