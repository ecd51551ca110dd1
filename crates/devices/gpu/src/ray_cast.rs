// SPDX-License-Identifier: MIT OR Apache-2.0
//! The bare body without triangles: a pass over the screen that meets each pixel's ray with the body and
//! writes the depth of the hit.

use crate::attachments::COLOUR_FORMAT;
use crate::covers::full_screen;
use crate::render_pipeline::nearest;
use crate::{RenderTargets, TimedPass};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use terrafill_contract::DeviceError;
use terrafill_core::{Ellipsoid, nearest_f32};
use terrafill_scene::{Camera, ImageSize};

/// Twin of `RayConstants` in `surface/ray_cast.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct RayConstants {
    corner: [f32; 4],
    column: [f32; 4],
    row: [f32; 4],
    eye: [f32; 3],
    height: f32,
    normal_scale: [f32; 3],
    near: f32,
    unscale: [f32; 3],
    padding: f32,
}

impl RayConstants {
    fn new(body: &Ellipsoid, camera: &Camera, size: ImageSize) -> Self {
        let radii = body.radii_m();
        let unit_m = body.equatorial_radius_m();
        let eye = camera.eye_ecef / radii;
        let at = |x: f64, y: f64| camera.direction_ecef(size, [x, y]);
        let scaled = |ray: DVec3| {
            let ray = ray * unit_m / radii;
            ray.extend(ray.dot(eye)).as_vec4().to_array()
        };
        Self {
            corner: scaled(at(0.0, 0.0)),
            column: scaled(at(1.0, 0.0) - at(0.0, 0.0)),
            row: scaled(at(0.0, 1.0) - at(0.0, 0.0)),
            eye: eye.as_vec3().to_array(),
            height: nearest_f32(eye.length_squared() - 1.0),
            normal_scale: radii
                .recip()
                .as_vec3()
                .map(|share| share * nearest_f32(unit_m))
                .to_array(),
            near: nearest_f32(camera.near_m / unit_m),
            unscale: (radii / unit_m).as_vec3().to_array(),
            padding: 0.0,
        }
    }
}

/// Draws the body by a ray for each pixel.
#[derive(Debug)]
pub struct RayCast {
    pipeline: wgpu::RenderPipeline,
    constants: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
}

impl RayCast {
    /// Bytes that a view needs.
    pub const CONSTANT_BYTES: u64 = size_of::<RayConstants>() as u64;

    /// Builds the pass on the device of `targets`.
    ///
    /// # Errors
    /// [`DeviceError::Shader`].
    pub fn new(targets: &RenderTargets) -> Result<Self, DeviceError> {
        let gpu = targets.gpu();
        let layout = gpu.buffer_layout(
            "ray cast",
            wgpu::ShaderStages::FRAGMENT,
            &[wgpu::BufferBindingType::Uniform],
        );
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let constants = gpu.unwritten("ray constants", Self::CONSTANT_BYTES, uniform);
        let shader = gpu.shader("surface/ray_cast.wgsl")?;
        let pipeline_layout = gpu.pipeline_layout("ray cast", &[Some(&layout)]);
        let target = COLOUR_FORMAT.into();
        let (label, state) = ("ray cast", Some(nearest()));
        Ok(Self {
            pipeline: full_screen(gpu, label, &pipeline_layout, &shader, state, target),
            bind_group: gpu.bind_buffers(label, &layout, &[&constants]),
            constants,
        })
    }

    /// Uploads a view.
    pub fn prepare(&self, targets: &RenderTargets, body: &Ellipsoid, camera: &Camera) {
        let constants = RayConstants::new(body, camera, targets.size());
        let bytes = bytemuck::bytes_of(&constants);
        targets.gpu().write_buffer(&self.constants, 0, bytes);
    }

    /// Clears the targets, draws the view uploaded last, waits, and gives the pass's GPU time.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn draw(&self, targets: &RenderTargets) -> Result<Option<f64>, DeviceError> {
        let gpu = targets.gpu();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let around = targets.timer().map(|t| t.around(TimedPass::Surface));
        let mut pass = targets.begin_cleared(&mut encoder, "ray cast", around);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        targets.direct_ms()
    }
}
