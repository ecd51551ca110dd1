// SPDX-License-Identifier: MIT OR Apache-2.0
//! One pass over cleared targets by a pipeline of the caller's own, after steps where there are some.

use crate::capture::{let_all_see, record_step};
use crate::queries::{Queries, QueryKind, Span};
use crate::render_targets::SURFACE_STAMPS;
use crate::{
    Buffer, BufferUse, Dispatch, DrawPipeline, IndexWidth, Measured, PassStatistics, RenderTargets,
    Resources, StateStep,
};
use ash::vk;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// What is drawn.
#[derive(Debug, Clone, Copy)]
pub enum DrawCall<'a> {
    /// Ranges of vertices, a draw each.
    Vertices(&'a [Range<u32>]),
    /// The same, with resources of its own bound before each; they are like the pipeline's.
    Rebound(&'a [(Arc<Resources>, Range<u32>)]),
    /// All of a range of indices.
    Indexed {
        /// Indices.
        indices: &'a Buffer,
        /// Their width.
        width: IndexWidth,
        /// How many of them.
        count: u32,
        /// How often.
        instances: u32,
    },
    /// As many vertices as the buffer's first four numbers say.
    Indirect(&'a Buffer),
    /// Workgroups of a mesh shader.
    MeshGroups([u32; 2]),
}

/// A draw and what it uses.
#[derive(Debug, Clone, Copy)]
pub struct DirectDraw<'a> {
    /// Shaders and their resources.
    pub pipeline: &'a DrawPipeline,
    /// Vertices, where shaders read any.
    pub vertices: Option<&'a Buffer>,
    /// What is drawn.
    pub call: DrawCall<'a>,
}

/// What was measured; absent where the device cannot, or it was not asked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DirectReport {
    /// GPU time of what was before the draw, and of the draw, milliseconds.
    pub gpu_ms: Option<f64>,
    /// Pipeline statistics of the draw.
    pub statistics: Option<PassStatistics>,
    /// Samples of each range of vertices that passed the depth test when it was drawn, exactly: precise occlusion
    /// queries.
    pub samples: Option<Vec<u64>>,
}

impl RenderTargets {
    /// Clears the targets, dispatches, draws and waits.
    ///
    /// - `measured`: times, statistics or samples; the statistics of mesh shaders are never counted, and samples of
    ///   ranges of vertices alone
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when what is drawn does not fit together or is of another device,
    /// [`DeviceError::DeviceLost`].
    pub fn draw_directly(
        &mut self,
        dispatch: Option<Dispatch<'_>>,
        draw: &DirectDraw<'_>,
        measured: Measured,
    ) -> Result<DirectReport, DeviceError> {
        let step = dispatch.map(StateStep::Dispatch);
        self.draw_after(step.as_slice(), draw, measured)
    }

    /// As [`RenderTargets::draw_directly`], after steps each of which sees what the one before wrote.
    ///
    /// # Errors
    /// As [`RenderTargets::draw_directly`].
    pub fn draw_after(
        &mut self,
        steps: &[StateStep<'_>],
        draw: &DirectDraw<'_>,
        measured: Measured,
    ) -> Result<DirectReport, DeviceError> {
        self.check(steps, draw)?;
        let gpu = self.gpu();
        let counts = measured == Measured::Statistics && !draw.pipeline.is_mesh();
        let queries = Queries::new(gpu, QueryKind::Statistics, u32::from(counts))?;
        let ranges = match draw.call {
            DrawCall::Vertices(ranges) if measured == Measured::Samples => ranges.len(),
            _ => 0,
        };
        let ranges = u32::try_from(ranges).unwrap_or(u32::MAX);
        let samples = Queries::new(gpu, QueryKind::Samples, ranges)?;
        let stamps = self.stamps.as_ref().filter(|_| measured == Measured::Times);
        let span = Span::new(stamps, SURFACE_STAMPS);
        // SAFETY: everything is of this device and fits, as checked above; it lives until the submission
        // is done.
        unsafe {
            gpu.submit(|device, commands| {
                span.begin(commands);
                for queries in queries.iter().chain(&samples) {
                    queries.reset(commands);
                }
                for step in steps {
                    record_step(gpu, commands, step);
                    if matches!(step, StateStep::Capture { .. }) {
                        let_all_see(device, commands);
                    }
                }
                self.begin_surface(commands);
                if let Some(queries) = &queries {
                    queries.begin(commands, 0);
                }
                record_draw(device, gpu.mesh.as_ref(), commands, draw, samples.as_ref());
                if let Some(queries) = &queries {
                    queries.end(commands, 0);
                }
                device.cmd_end_render_pass(commands);
                span.end(commands);
            })?;
        }
        let gpu_ms = span.ms()?;
        let statistics = queries.map(|queries| queries.read_statistics(1));
        let statistics = statistics.transpose()?;
        let samples = samples.map(|samples| samples.read(0, ranges)).transpose()?;
        self.set_drawn();
        Ok(DirectReport {
            gpu_ms,
            statistics,
            samples,
        })
    }

    fn check(&self, steps: &[StateStep<'_>], draw: &DirectDraw<'_>) -> Result<(), DeviceError> {
        let gpu = self.gpu();
        let is = |buffer: &Buffer, use_for| buffer.is_for(gpu, use_for);
        let vertices_fit = match draw.vertices {
            Some(vertices) => is(vertices, BufferUse::Vertex),
            None => !draw.pipeline.needs_vertices(),
        };
        let is_mesh = matches!(draw.call, DrawCall::MeshGroups(_));
        let call_fits = match draw.call {
            DrawCall::Vertices(_) | DrawCall::MeshGroups(_) => true,
            DrawCall::Rebound(draws) => draws
                .iter()
                .all(|(resources, _)| draw.pipeline.resources.is_like(resources)),
            DrawCall::Indexed {
                indices,
                width,
                count,
                ..
            } => {
                let needed = u64::from(count) * width.bytes();
                is(indices, BufferUse::Index) && indices.size() >= needed
            }
            DrawCall::Indirect(arguments) => {
                is(arguments, BufferUse::Arguments) && arguments.size() >= 16
            }
        };
        let devices_fit = draw.pipeline.owned.is_on(gpu) && steps.iter().all(|step| step.fits(gpu));
        let fits = vertices_fit && call_fits && devices_fit && is_mesh == draw.pipeline.is_mesh();
        gpu.require(fits, "drawing what does not fit its pipeline")
    }
}

/// # Safety
/// Recording is under way, in the surface's pass, on the device of the draw, which fits together; `samples` has a query
/// for each range, reset before.
unsafe fn record_draw(
    device: &ash::Device,
    mesh: Option<&ash::ext::mesh_shader::Device>,
    commands: vk::CommandBuffer,
    draw: &DirectDraw<'_>,
    samples: Option<&Queries>,
) {
    let graphics = vk::PipelineBindPoint::GRAPHICS;
    // SAFETY: the caller's promise.
    unsafe {
        device.cmd_bind_pipeline(commands, graphics, draw.pipeline.owned.raw);
        draw.pipeline.resources.bind(commands, graphics);
        if let Some(vertices) = draw.vertices {
            device.cmd_bind_vertex_buffers(commands, 0, &[vertices.raw], &[0]);
        }
        match draw.call {
            DrawCall::Vertices(ranges) => {
                for (query, range) in (0..).zip(ranges) {
                    if let Some(samples) = samples {
                        samples.begin(commands, query);
                    }
                    let count = range.end - range.start;
                    device.cmd_draw(commands, count, 1, range.start, 0);
                    if let Some(samples) = samples {
                        samples.end(commands, query);
                    }
                }
            }
            DrawCall::Rebound(draws) => {
                for (resources, range) in draws {
                    resources.bind(commands, graphics);
                    device.cmd_draw(commands, range.end - range.start, 1, range.start, 0);
                }
            }
            DrawCall::Indexed {
                indices,
                width,
                count,
                instances,
            } => {
                device.cmd_bind_index_buffer(commands, indices.raw, 0, width.vulkan());
                device.cmd_draw_indexed(commands, count, instances, 0, 0, 0);
            }
            DrawCall::Indirect(arguments) => {
                device.cmd_draw_indirect(commands, arguments.raw, 0, 1, 16);
            }
            DrawCall::MeshGroups([x, y]) => {
                if let Some(mesh) = mesh {
                    mesh.cmd_draw_mesh_tasks(commands, x, y, 1);
                }
            }
        }
    }
}
