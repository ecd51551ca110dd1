// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a model is deformed, on Vulkan, which has transform feedback.

use crate::draws::{Counted, Draws, Times, count};
use crate::on_vulkan::{numbered, uniform, wgsl};
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError, Picture};
use terrafill_scene::ImageSize;
use terrafill_shapes::dents::Dent;
use terrafill_shapes::grid::GridCamera;
use terrafill_shapes::mesh::{Mesh, MeshConstants};
use terrafill_vulkan::{
    Buffer, BufferUse, CapturePipeline, ComputePipeline, DirectDraw, DirectReport, Dispatch,
    DrawCall, DrawPipeline, Gpu, IndexWidth, Measured, RenderTargets, Resource, Resources,
    StateStep, Topology,
};

const DEFORMED: &str = "pipelines/deformed.wgsl";
/// Invocations of a workgroup of `deform.wgsl`.
const GROUP: u32 = 64;
/// Bytes of a vertex, at rest or kept, and of an index.
const VERTEX_BYTES: u64 = 16;
const INDEX_BYTES: u64 = 4;

terrafill_results::named! {
    /// Where vertices are deformed.
    all pub(crate) enum DeformWay {
        /// In the vertex shader, in each drawing anew.
        Anew = "deformed-anew",
        /// Once by vertices, which transform feedback keeps, as published.
        Streamed = "stream-output",
        /// Once by compute.
        Computed = "compute-buffer",
    }
}

impl DeformWay {
    /// Vertices deformed in a frame, by the way's definition; of those of a drawing each once.
    pub(crate) fn deformed(self, vertices: u64, drawings: u32) -> u64 {
        match self {
            Self::Anew => vertices * u64::from(drawings),
            Self::Streamed | Self::Computed => vertices,
        }
    }

    /// Everything that the device holds for it, bytes.
    pub(crate) fn held_bytes(self, vertices: u64, triangles: u64) -> u64 {
        let kept = match self {
            Self::Anew => 0,
            Self::Streamed | Self::Computed => VERTEX_BYTES * vertices,
        };
        VERTEX_BYTES * vertices + 3 * INDEX_BYTES * triangles + kept
    }
}

/// What deforms vertices before they are drawn.
enum Before {
    Nothing,
    Capture(CapturePipeline),
    Compute(ComputePipeline),
}

/// A model that is deformed one way and drawn so often.
pub(crate) struct Deforming {
    gpu: Arc<Gpu>,
    targets: RenderTargets,
    pipeline: DrawPipeline,
    before: Before,
    kept: Arc<Buffer>,
    indices: Buffer,
    /// Of the model.
    vertices: u32,
    corners: u32,
    drawings: u32,
}

impl Deforming {
    /// - `mesh`: at rest
    /// - `views`: of even and of odd drawings
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        way: DeformWay,
        (mesh, dents): (&Mesh, &[Dent]),
        views: [GridCamera; 2],
        drawings: u32,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let storage = |label, bytes: &[u8]| {
            let buffer = Buffer::upload(gpu, label, bytes, BufferUse::Storage)?;
            Ok::<_, DeviceError>(Resource::Storage(Arc::new(buffer)))
        };
        let rest = mesh.vertices.iter();
        let rest: Vec<[f32; 4]> = rest.map(|at| at.as_vec3().extend(1.0).to_array()).collect();
        let [left, right] = views.map(|view| MeshConstants::new(&view, 0));
        let bytes = VERTEX_BYTES * rest.len() as u64;
        let kept = Arc::new(Buffer::unwritten(
            gpu,
            "deformed vertices",
            bytes,
            BufferUse::State,
        )?);
        let resources = vec![
            uniform(gpu, "view on the left", bytemuck::bytes_of(&left))?,
            storage("vertices at rest", bytemuck::cast_slice(&rest))?,
            storage("dents", bytemuck::cast_slice(dents))?,
            uniform(gpu, "view on the right", bytemuck::bytes_of(&right))?,
            Resource::Storage(Arc::clone(&kept)),
        ];
        let resources = Resources::new(gpu, resources)?;
        let entry_point = match way {
            DeformWay::Anew => "deforming",
            DeformWay::Streamed | DeformWay::Computed => "deformed_before",
        };
        let stages = numbered(wgsl(DEFORMED, entry_point), None, Topology::Triangles);
        let fragment = wgsl(DEFORMED, "fragment_main");
        let before = match way {
            DeformWay::Anew => Before::Nothing,
            DeformWay::Streamed => {
                Before::Capture(CapturePipeline::new(gpu, &resources, "native/deform.spv")?)
            }
            DeformWay::Computed => {
                let shader = wgsl("pipelines/deform.wgsl", "compute_main");
                Before::Compute(ComputePipeline::new(gpu, &resources, shader)?)
            }
        };
        let indices = bytemuck::cast_slice(&mesh.triangles);
        Ok(Self {
            gpu: Arc::clone(gpu),
            targets: RenderTargets::new(gpu, size)?,
            pipeline: DrawPipeline::new(gpu, &resources, stages, fragment)?,
            before,
            kept,
            indices: Buffer::upload(gpu, "indices", indices, BufferUse::Index)?,
            vertices: count(&rest),
            corners: 3 * count(&mesh.triangles),
            drawings,
        })
    }

    /// Vertices that were kept by the last frame, metres; `None` where none are.
    pub(crate) fn kept(&self) -> Result<Option<Vec<[f32; 4]>>, DeviceError> {
        if matches!(self.before, Before::Nothing) {
            return Ok(None);
        }
        let bytes = self.kept.contents(&self.gpu)?;
        Ok(Some(bytemuck::pod_collect_to_vec(&bytes)))
    }

    fn frame(&mut self, measured: Measured) -> Result<DirectReport, DeviceError> {
        let step = match &self.before {
            Before::Nothing => None,
            Before::Capture(pipeline) => Some(StateStep::Capture {
                pipeline,
                into: &self.kept,
                vertices: self.vertices,
            }),
            Before::Compute(pipeline) => Some(StateStep::Dispatch(Dispatch {
                pipeline,
                groups: [self.vertices.div_ceil(GROUP), 1, 1],
            })),
        };
        let draw = DirectDraw {
            pipeline: &self.pipeline,
            vertices: None,
            call: DrawCall::Indexed {
                indices: &self.indices,
                width: IndexWidth::Long,
                count: self.corners,
                instances: self.drawings,
            },
        };
        self.targets.draw_after(step.as_slice(), &draw, measured)
    }
}

impl Draws for Deforming {
    fn draw(&mut self) -> Result<(Picture, Counted), DeviceError> {
        let report = self.frame(Measured::Statistics)?;
        Ok((self.targets.read()?, Counted::from(report.statistics)))
    }

    fn time(&mut self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        let report = self.frame(Measured::Times)?;
        Ok(Times::since(&watch, report.gpu_ms))
    }
}
