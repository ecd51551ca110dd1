// SPDX-License-Identifier: MIT OR Apache-2.0
//! The two full-screen passes that fills are measured against, in the same run on the same targets.

use crate::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, SharedStage, TimedPass};
use terrafill_frame::{BackendError, CpuStopwatch, FrameTimes};

/// Which pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaselineKind {
    /// Reads depth, writes a constant colour: what any technique must pay that looks at depth in a
    /// shader.
    Bound,
    /// Clears the stencil and writes a stencil-tested constant colour: what any stencil technique
    /// must pay.
    Floor,
}

impl BaselineKind {
    /// Name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bound => "bound",
            Self::Floor => "floor",
        }
    }
}

/// A full-screen pass on a stage.
#[derive(Debug)]
pub struct Baseline {
    kind: BaselineKind,
    stage: SharedStage,
    pipeline: wgpu::RenderPipeline,
    bind_group: Option<wgpu::BindGroup>,
}

impl Baseline {
    /// Builds the pass.
    ///
    /// # Errors
    /// [`BackendError::Shader`].
    pub fn new(kind: BaselineKind, stage: &SharedStage) -> Result<Self, BackendError> {
        let borrowed = stage.borrow();
        let device = &borrowed.gpu().device;
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("depth"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Depth,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            }],
        });
        let reads_depth = kind == BaselineKind::Bound;
        let bind_group = reads_depth.then(|| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("depth"),
                layout: &layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&borrowed.depth_view()),
                }],
            })
        });
        let path = match kind {
            BaselineKind::Bound => "baseline/bound.wgsl",
            BaselineKind::Floor => "baseline/floor.wgsl",
        };
        let shader = borrowed.gpu().shader(path)?;
        let layouts: &[Option<&wgpu::BindGroupLayout>] =
            if reads_depth { &[Some(&layout)] } else { &[] };
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(kind.name()),
            bind_group_layouts: layouts,
            immediate_size: 0,
        });
        let face = wgpu::StencilFaceState {
            compare: wgpu::CompareFunction::Equal,
            ..wgpu::StencilFaceState::IGNORE
        };
        let depth_stencil = (kind == BaselineKind::Floor).then(|| wgpu::DepthStencilState {
            format: DEPTH_STENCIL_FORMAT,
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: wgpu::StencilState {
                front: face,
                back: face,
                read_mask: 0xff,
                write_mask: 0,
            },
            bias: Default::default(),
        });
        let pipeline = borrowed
            .gpu()
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(kind.name()),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &shader,
                    entry_point: Some("vertex_main"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &shader,
                    entry_point: Some("fragment_main"),
                    compilation_options: Default::default(),
                    targets: &[Some(COLOUR_FORMAT.into())],
                }),
                multiview_mask: None,
                cache: None,
            });
        drop(borrowed);
        Ok(Self {
            kind,
            stage: SharedStage::clone(stage),
            pipeline,
            bind_group,
        })
    }

    /// Which pass this is.
    #[must_use]
    pub fn kind(&self) -> BaselineKind {
        self.kind
    }

    /// Draws it once over whatever the stage holds and waits.
    ///
    /// # Errors
    /// [`BackendError::DeviceLost`].
    pub fn time_frame(&mut self) -> Result<FrameTimes, BackendError> {
        let stage = self.stage.borrow();
        let gpu = stage.gpu();
        let (colour, depth_stencil) = (stage.colour_view(), stage.depth_stencil_view());
        let watch = CpuStopwatch::start();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(self.kind.name()),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &colour,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: (self.kind == BaselineKind::Floor).then_some(
                wgpu::RenderPassDepthStencilAttachment {
                    view: &depth_stencil,
                    depth_ops: None,
                    stencil_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0),
                        store: wgpu::StoreOp::Store,
                    }),
                },
            ),
            timestamp_writes: stage.timer().map(|t| t.around(TimedPass::Baseline)),
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
        let fill_gpu_ms = match stage.timer() {
            Some(timer) => timer
                .read(gpu, TimedPass::Baseline, TimedPass::Baseline)?
                .pass_ms(TimedPass::Baseline),
            None => None,
        };
        Ok(FrameTimes {
            fill_gpu_ms,
            fill_cpu_ms,
            fill_wall_ms,
            ..FrameTimes::default()
        })
    }
}
