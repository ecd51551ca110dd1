// SPDX-License-Identifier: MIT OR Apache-2.0
//! The body drawn by rays, in the form of an interface that draws surfaces.

use terrafill_contract::{DeviceError, Picture, SurfaceInterface, SurfaceTargets, SurfaceView};
use terrafill_gpu::RayCast;

/// The body met by a ray for each pixel. Of what it is given it reads the camera alone.
struct ByRays {
    targets: terrafill_gpu::RenderTargets,
    rays: RayCast,
}

impl SurfaceTargets for ByRays {
    fn prepare(&mut self, view: SurfaceView<'_>) -> Result<(), DeviceError> {
        self.rays.prepare(&self.targets, view.body, view.camera);
        Ok(())
    }

    fn draw_surface(&mut self) -> Result<Option<f64>, DeviceError> {
        self.rays.draw(&self.targets)
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.targets.read()
    }
}

pub(crate) const RAYS: SurfaceInterface = SurfaceInterface {
    api: terrafill_gpu::API,
    open: |devices, size| {
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        let targets = terrafill_gpu::RenderTargets::new(&gpu, size)?;
        let rays = RayCast::new(&targets)?;
        Ok(Box::new(ByRays { targets, rays }))
    },
};
