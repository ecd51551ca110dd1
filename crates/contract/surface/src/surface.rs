// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a surface promises, what it draws in a view, and what may fail.

use std::fmt::Debug;
use std::sync::Arc;
use terrafill_core::Extent;
use terrafill_scene::{Camera, HeightRange, ImageSize};

/// A planet's surface: closed around the body, so that every ray that enters it meets a triangle.
pub trait Surface: Debug + Send + Sync {
    /// Name in scene files.
    fn kind(&self) -> &'static str;

    /// Heights of everything that may be drawn over `extent`, in whatever view. The range of a volume
    /// over that extent.
    fn heights(&self, extent: &Extent) -> HeightRange;

    /// What is drawn in a view.
    ///
    /// # Errors
    /// [`SurfaceError::EyeBelow`], or whatever the surface cannot provide for this view.
    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError>;
}

/// A surface as one view draws it.
#[derive(Debug, Clone)]
pub struct SurfaceFrame {
    /// Metres relative to the eye, ECEF axes: subtracted in `f64`, then rounded. Every renderer and the
    /// reference read these numbers, so the tessellation is no source of error.
    pub vertices_rte: Arc<[[f32; 3]]>,
    /// Counter-clockwise seen from outside.
    pub triangles: Arc<[[u32; 3]]>,
    /// Heights of the triangles as drawn in this view, metres above the ellipsoid.
    pub heights: HeightRange,
}

/// Draws surfaces through one API.
pub trait SurfaceRenderer {
    /// A pass that draws can be recorded in; constants of the view are bound.
    type Pass<'p>;
    /// Why a surface cannot be uploaded.
    type Error;

    /// Uploads a frame in place of the one before.
    ///
    /// # Errors
    /// The device cannot hold it.
    fn prepare(&mut self, frame: &SurfaceFrame) -> Result<(), Self::Error>;

    /// Records the draws of the frame that was prepared last; nothing before there is one.
    fn draw(&self, pass: &mut Self::Pass<'_>);
}

/// Why a surface cannot be opened or drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A value in a scene's `[surface]` that is not allowed.
    #[error("{file}: surface.{key}: found {found}, allowed: {allowed}")]
    Value {
        /// The scene file.
        file: String,
        /// Key in `[surface]`.
        key: String,
        /// The value.
        found: String,
        /// What it may be.
        allowed: String,
    },
    /// Seen from inside, a surface hides nothing, and there is nothing to fill.
    #[error(
        "the eye is {eye_height_m:.1} m above the ellipsoid, allowed: above the {kind} surface, \
         which is higher there"
    )]
    EyeBelow {
        /// The surface.
        kind: &'static str,
        /// Height of the eye above the ellipsoid, metres.
        eye_height_m: f64,
    },
}
