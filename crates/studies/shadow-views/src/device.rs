// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadow volumes on devices, through the executors of stencil programs that fill regions too.

mod on_vulkan;
mod on_wgpu;

use self::on_vulkan::OnVulkan;
use self::on_wgpu::OnWgpu;
use crate::source::{EyeVolumes, HandedOver, VolumeSource};
use terrafill_contract::{
    Counters, CpuStopwatch, DeviceError, Devices, FrameTimes, Picture, SurfaceView,
};
use terrafill_stencil::{StencilExecutor, StencilWork};
use terrafill_variant::Switches;

terrafill_results::named! {
    /// An interface that draws.
    all pub enum Interface {
        /// By wgpu.
        Wgpu = terrafill_gpu::API.name,
        /// By the project's own layer over Vulkan.
        Vulkan = terrafill_vulkan::API.name,
    }
}

impl Interface {
    /// What is seen, and the program over its volumes, ready to be drawn into targets of its own.
    ///
    /// - `has_bounds`: the device tests the surface's depth against the range of each volume
    pub fn open(
        self,
        devices: &Devices,
        (switches, has_bounds): (&Switches, bool),
        view: SurfaceView<'_>,
        source: VolumeSource,
        work: (StencilWork, Option<Retile>),
    ) -> Result<Box<dyn Draws>, DeviceError> {
        match self {
            // Whatever the device has; silence would look like a test that changes nothing.
            Self::Wgpu if has_bounds => Err(DeviceError::unsupported(
                "a depth-bounds test",
                terrafill_gpu::API.name,
            )),
            Self::Wgpu => {
                let gpu = terrafill_gpu::shared_gpu(devices)?;
                let targets = terrafill_gpu::RenderTargets::shared(&gpu, view.size)?;
                let make = |fill: &terrafill_gpu::VolumeFill| {
                    OnWgpu::new(fill, source, switches.copies_depth)
                };
                loaded(&targets, switches, make, view, work)
            }
            Self::Vulkan => {
                let gpu = terrafill_vulkan::shared_gpu(devices)?;
                let targets = terrafill_vulkan::RenderTargets::shared(&gpu, view.size)?;
                let make =
                    |_: &terrafill_vulkan::VolumeFill| OnVulkan::new(&gpu, source, has_bounds);
                loaded(&targets, switches, make, view, work)
            }
        }
    }
}

/// Another program for what is seen, by its depths.
pub type Retile = Box<dyn Fn(&Picture) -> Result<StencilWork, DeviceError>>;

/// Draws one view.
pub trait Draws {
    /// Counts, and which pixels are in shadow.
    fn draw(&mut self) -> Result<(Counters, Vec<bool>), DeviceError>;

    /// Fragments of its volumes, which are drawn once more; `None` where nobody counts them.
    fn fragments(&mut self) -> Result<Option<u64>, DeviceError> {
        Ok(None)
    }

    /// Other volumes in place of those that it draws, as many and as large.
    fn hand_over(&mut self, _volumes: &EyeVolumes) -> Result<(), DeviceError> {
        Err(DeviceError::unsupported(
            "volumes of the CPU",
            "this way of drawing",
        ))
    }

    /// The shadows alone.
    fn time(&mut self) -> Result<FrameTimes, DeviceError>;
}

/// What draws a channel.
pub struct Channel {
    /// Draws it.
    pub draws: Box<dyn Draws>,
    /// Of what it holds, and of it what another sun changes.
    pub bytes: [u64; 2],
    /// GPU time of what is built once for casters that rest.
    pub build_ms: Option<f64>,
    /// Casters that are not drawn.
    pub left_out: usize,
}

struct Loaded<E, V> {
    executor: E,
    volumes: V,
    retile: Option<Retile>,
}

impl<V, E: StencilExecutor<V>> Loaded<E, V> {
    /// Leaves out tiles by the depths that lie in the targets.
    fn retile(&mut self) -> Result<(), DeviceError> {
        if let Some(retile) = &self.retile {
            let picture = self.executor.targets().borrow().read()?;
            let work = retile(&picture)?;
            self.executor.load(work)?;
            self.executor.ensure(&mut self.volumes)?;
        }
        Ok(())
    }
}

impl<V: HandedOver, E: StencilExecutor<V>> Draws for Loaded<E, V> {
    fn draw(&mut self) -> Result<(Counters, Vec<bool>), DeviceError> {
        self.executor.targets().borrow_mut().draw_surface()?;
        self.retile()?;
        let counters = self.executor.draw(&mut self.volumes)?;
        let picture = self.executor.targets().borrow().read()?;
        // The cover coloured what is in shadow.
        let pixels = picture.rgba.chunks_exact(4);
        Ok((counters, pixels.map(|pixel| pixel[3] != 0).collect()))
    }

    fn hand_over(&mut self, volumes: &EyeVolumes) -> Result<(), DeviceError> {
        self.volumes.hand_over(volumes)
    }

    fn fragments(&mut self) -> Result<Option<u64>, DeviceError> {
        // Other views may have drawn into the targets since.
        self.executor.targets().borrow_mut().draw_surface()?;
        self.executor.count_fragments(&mut self.volumes)
    }

    fn time(&mut self) -> Result<FrameTimes, DeviceError> {
        let surface_gpu_ms = self.executor.targets().borrow_mut().draw_surface()?;
        let watch = CpuStopwatch::start();
        self.retile()?;
        let (cpu_ms, wall_ms) = match self.retile {
            Some(_) => (watch.cpu_ms(), watch.wall_ms()),
            None => (0.0, 0.0),
        };
        let mut times = FrameTimes {
            surface_gpu_ms,
            ..self.executor.time(&mut self.volumes)?
        };
        times.fill_cpu_ms += cpu_ms;
        times.fill_wall_ms += wall_ms;
        Ok(times)
    }
}

/// Times of one view after another; what was not measured of both is not of the sum.
#[must_use]
pub fn sum_of(one: &FrameTimes, other: &FrameTimes) -> FrameTimes {
    let both = |of: fn(&FrameTimes) -> Option<f64>| Some(of(one)? + of(other)?);
    FrameTimes {
        surface_gpu_ms: both(|times| times.surface_gpu_ms),
        stencil_gpu_ms: both(|times| times.stencil_gpu_ms),
        colour_gpu_ms: both(|times| times.colour_gpu_ms),
        fill_gpu_ms: both(|times| times.fill_gpu_ms),
        fill_cpu_ms: one.fill_cpu_ms + other.fill_cpu_ms,
        fill_wall_ms: one.fill_wall_ms + other.fill_wall_ms,
    }
}

fn loaded<V: HandedOver + 'static, E: StencilExecutor<V> + 'static>(
    targets: &E::Targets,
    switches: &Switches,
    make: impl FnOnce(&E) -> Result<V, DeviceError>,
    view: SurfaceView<'_>,
    (work, retile): (StencilWork, Option<Retile>),
) -> Result<Box<dyn Draws>, DeviceError> {
    let mut executor = E::new(targets, switches)?;
    let mut volumes = make(&executor)?;
    executor.targets().borrow_mut().prepare(view)?;
    executor.load(work)?;
    executor.ensure(&mut volumes)?;
    Ok(Box::new(Loaded {
        executor,
        volumes,
        retile,
    }))
}
