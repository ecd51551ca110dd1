// SPDX-License-Identifier: MIT OR Apache-2.0
//! The two full-screen passes that fills are measured against, in the same run on the same targets.

use crate::attachments::{attached, read_only_depth};
use crate::covers::full_screen;
use crate::volume_pipeline::{colour_state, colour_target};
use crate::{SharedTargets, TimedPass};
use terrafill_contract::{CpuStopwatch, DeviceError, FrameTimes};
use terrafill_stencil::StencilTest;

/// Which pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaselineKind {
    /// Reads depth, writes a constant colour: what any technique must pay that looks at depth in a
    /// shader.
    DepthPass,
    /// Clears the stencil and writes a stencil-tested constant colour: what any stencil technique
    /// must pay.
    StencilPass,
}

impl BaselineKind {
    /// Every kind.
    pub const ALL: [Self; 2] = [Self::DepthPass, Self::StencilPass];

    /// Name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DepthPass => "depth-pass",
            Self::StencilPass => "stencil-pass",
        }
    }
}

/// A full-screen pass on the targets.
#[derive(Debug)]
pub struct Baseline {
    kind: BaselineKind,
    targets: SharedTargets,
    pipeline: wgpu::RenderPipeline,
    bind_group: Option<wgpu::BindGroup>,
}

impl Baseline {
    /// Builds the pass.
    ///
    /// # Errors
    /// [`DeviceError::Shader`].
    pub fn new(kind: BaselineKind, targets: &SharedTargets) -> Result<Self, DeviceError> {
        let borrowed = targets.borrow();
        let gpu = borrowed.gpu();
        let layout = gpu.texture_layout("depth", wgpu::TextureSampleType::Depth);
        let reads_depth = kind == BaselineKind::DepthPass;
        let bind_group =
            reads_depth.then(|| gpu.bind_texture("depth", &layout, &borrowed.depth_view()));
        let path = match kind {
            BaselineKind::DepthPass => "baseline/bound.wgsl",
            BaselineKind::StencilPass => "baseline/floor.wgsl",
        };
        let shader = gpu.shader(path)?;
        let layouts: &[Option<&wgpu::BindGroupLayout>] =
            if reads_depth { &[Some(&layout)] } else { &[] };
        let pipeline_layout = gpu.pipeline_layout(kind.name(), layouts);
        let unmarked = StencilTest {
            read_mask: 0xff,
            ..StencilTest::ANYWHERE
        };
        let depth_stencil = (kind == BaselineKind::StencilPass).then(|| colour_state(unmarked));
        let (label, target) = (kind.name(), colour_target(false));
        let pipeline = full_screen(gpu, label, &pipeline_layout, &shader, depth_stencil, target);
        drop(borrowed);
        Ok(Self {
            kind,
            targets: SharedTargets::clone(targets),
            pipeline,
            bind_group,
        })
    }

    /// Which pass this is.
    #[must_use]
    pub fn kind(&self) -> BaselineKind {
        self.kind
    }

    /// Draws it once over whatever the targets hold and waits.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn time_frame(&mut self) -> Result<FrameTimes, DeviceError> {
        let targets = self.targets.borrow();
        let gpu = targets.gpu();
        let (colour, depth_stencil) = (targets.colour_view(), targets.depth_stencil_view());
        let watch = CpuStopwatch::start();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(self.kind.name()),
            color_attachments: &[Some(attached(&colour, wgpu::LoadOp::Load))],
            depth_stencil_attachment: (self.kind == BaselineKind::StencilPass)
                .then(|| read_only_depth(&depth_stencil, Some(wgpu::LoadOp::Clear(0)))),
            timestamp_writes: targets.timer().map(|t| t.around(TimedPass::Baseline)),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        if let Some(bind_group) = &self.bind_group {
            pass.set_bind_group(0, bind_group, &[]);
        }
        pass.draw(0..3, 0..1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let (fill_cpu_ms, fill_wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        Ok(FrameTimes {
            fill_gpu_ms: targets.pass_ms(TimedPass::Baseline)?,
            fill_cpu_ms,
            fill_wall_ms,
            ..FrameTimes::default()
        })
    }
}
