// SPDX-License-Identifier: MIT OR Apache-2.0
//! The graphics interfaces that are measured, and what the study needs of each.

use terrafill_fill::{Api, DeviceError, Devices, FillInput, Picture};
use terrafill_scene::ImageSize;

/// Render targets that can be drawn into and read back.
pub(crate) trait Readable {
    /// Draws the surface of `input` and waits for it.
    fn draw(&mut self, input: &FillInput) -> Result<(), DeviceError>;

    /// Copies colour and depth to the CPU, rows tightly packed.
    fn read(&self) -> Result<Picture, DeviceError>;
}

impl Readable for terrafill_gpu::RenderTargets {
    fn draw(&mut self, input: &FillInput) -> Result<(), DeviceError> {
        self.prepare(input)?;
        self.draw_surface().map(drop)
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.read()
    }
}

impl Readable for terrafill_vulkan::RenderTargets {
    fn draw(&mut self, input: &FillInput) -> Result<(), DeviceError> {
        self.prepare(input)?;
        self.draw_surface().map(drop)
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.read()
    }
}

type Opened = Result<Box<dyn Readable>, DeviceError>;

/// An interface and how targets are made on it.
#[derive(Clone, Copy)]
pub(crate) struct Interface {
    pub(crate) api: Api,
    pub(crate) open: fn(&Devices, ImageSize) -> Opened,
}

/// In the order in which they are reported.
pub(crate) const INTERFACES: [Interface; 2] = [
    Interface {
        api: terrafill_gpu::API,
        open: |devices, size| {
            let gpu = terrafill_gpu::shared_gpu(devices)?;
            Ok(Box::new(terrafill_gpu::RenderTargets::new(&gpu, size)?))
        },
    },
    Interface {
        api: terrafill_vulkan::API,
        open: |devices, size| {
            let gpu = terrafill_vulkan::shared_gpu(devices)?;
            Ok(Box::new(terrafill_vulkan::RenderTargets::new(&gpu, size)?))
        },
    },
];
