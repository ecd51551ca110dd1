// SPDX-License-Identifier: MIT OR Apache-2.0
//! An eye over a surface: all that render targets need to know before anything is filled.

use crate::{AddressMode, DeviceError, FillInput, ViewId};
use std::sync::Arc;
use terrafill_core::Ellipsoid;
use terrafill_scene::{Camera, ImageSize, MipChain};
use terrafill_surface::SurfaceFrame;

/// A view of a surface.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceView<'a> {
    /// Identity of everything below.
    pub id: ViewId,
    /// What the surface lies on.
    pub body: &'a Ellipsoid,
    /// The eye.
    pub camera: &'a Camera,
    /// The image.
    pub size: ImageSize,
    /// The surface as drawn in this view.
    pub surface: &'a SurfaceFrame,
    /// What colours it, of the whole body.
    pub picture: Option<&'a Arc<MipChain>>,
    /// Back faces are drawn too: a surface of closed bodies whose other side counts beside a rim.
    pub draws_back_faces: bool,
}

impl<'a> From<&'a FillInput> for SurfaceView<'a> {
    fn from(input: &'a FillInput) -> Self {
        Self {
            id: input.view_id,
            body: &input.scene.body,
            camera: &input.camera,
            size: input.size,
            surface: &input.surface,
            picture: input.scene.picture.as_ref(),
            draws_back_faces: false,
        }
    }
}

impl SurfaceView<'_> {
    /// Whether targets of this size are the view's.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`].
    pub fn check_size(&self, targets: ImageSize) -> Result<(), DeviceError> {
        if self.size == targets {
            return Ok(());
        }
        Err(DeviceError::OverCapacity {
            what: "image size differs from the targets', pixels".to_owned(),
            found: self.size.pixel_count() as u64,
            allowed: targets.pixel_count() as u64,
        })
    }
}

/// What decides by which pipeline the triangles of a surface are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct SurfaceLook {
    /// A picture of the whole body colours them.
    pub has_picture: bool,
    /// As [`SurfaceView::draws_back_faces`].
    pub draws_back_faces: bool,
}

impl SurfaceLook {
    /// How the picture is continued beyond its edges: it meets itself at ±180°.
    pub const PICTURE_ADDRESS: [AddressMode; 2] = [AddressMode::Repeat, AddressMode::ClampToEdge];

    /// Shader of both stages, `vertex_main` and `fragment_main`, relative to `shaders/`.
    #[must_use]
    pub fn shader(self) -> &'static str {
        match self.has_picture {
            true => "surface/picture.wgsl",
            false => "surface/surface.wgsl",
        }
    }
}
