// SPDX-License-Identifier: MIT OR Apache-2.0
//! An eye over a surface: all that render targets need to know before anything is filled.

use crate::{AddressMode, DeviceError, FillInput, ViewId};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;
use terrafill_core::{Ellipsoid, nearest_f32};
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

/// Twin of `ViewConstants` in `shared/view.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ViewConstants {
    /// Columns of the rotation, each padded to 16 bytes.
    pub view_from_ecef: [[f32; 4]; 3],
    /// Eye, ECEF metres, rounded: the high part of two floats.
    pub eye_ecef: [f32; 3],
    /// Near plane, metres.
    pub near_m: f32,
    /// `(1, 1, a²/b²)`.
    pub normal_scale: [f32; 3],
    /// `1 / (tan(fov/2) · aspect)`.
    pub clip_scale_x: f32,
    /// `1 / tan(fov/2)`.
    pub clip_scale_y: f32,
    /// Height of a pixel at distance 1, `2 tan(fov/2) / rows`.
    pub pixel_per_distance: f32,
    /// Uniform blocks are multiples of 16 bytes.
    pub padding: [f32; 2],
}

impl ViewConstants {
    /// Constants of a view's camera and body.
    #[must_use]
    pub fn new(view: &SurfaceView<'_>) -> Self {
        let camera = view.camera;
        let column = |i: usize| {
            let c = camera.view_from_ecef.col(i).as_vec3();
            [c.x, c.y, c.z, 0.0]
        };
        let body = view.body;
        let flattening_squared = (body.equatorial_radius_m() / body.polar_radius_m()).powi(2);
        let clip_scale_y = camera.tan_half_fov().recip();
        Self {
            view_from_ecef: [column(0), column(1), column(2)],
            eye_ecef: camera.eye_ecef.as_vec3().to_array(),
            near_m: nearest_f32(camera.near_m),
            normal_scale: [1.0, 1.0, nearest_f32(flattening_squared)],
            clip_scale_x: nearest_f32(clip_scale_y / view.size.aspect()),
            clip_scale_y: nearest_f32(clip_scale_y),
            pixel_per_distance: nearest_f32(
                2.0 * camera.tan_half_fov() / f64::from(view.size.height),
            ),
            padding: [0.0; 2],
        }
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
        if self.has_picture {
            "surface/picture.wgsl"
        } else {
            "surface/surface.wgsl"
        }
    }
}
