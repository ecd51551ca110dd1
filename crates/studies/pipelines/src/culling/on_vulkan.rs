// SPDX-License-Identifier: MIT OR Apache-2.0
//! Culling on Vulkan itself: by compute, in a geometry shader, in a task shader, or on the CPU.

use super::culls::{Culls, Kept, Sent, Shown, constants, listed};
use super::ground::{Ground, PATCH_TRIANGLES};
use super::way::{CullStage, CullWay};
use crate::draws::{Counted, Times};
use crate::on_vulkan::{heights, numbered, uniform, wgsl};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError};
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::GridCamera;
use terrafill_vulkan::{
    Buffer, BufferUse, ComputePipeline, DirectDraw, DirectReport, Dispatch, DrawCall, DrawPipeline,
    GeometryOutput, Gpu, Measured, PrimitiveStages, RenderTargets, Resource, Resources,
    SampledImage, Shader, Topology,
};

const CULLED: &str = "pipelines/culled.wgsl";
/// Patches that a workgroup of compute tests, and one of the task shader.
const GROUP: u32 = 64;
const TASK_GROUP: u32 = 32;

/// What all ways read of the ground.
pub(crate) struct VulkanGround {
    gpu: Arc<Gpu>,
    heights: Arc<SampledImage>,
    boxes: Arc<Buffer>,
    ground: Rc<Ground>,
}

impl VulkanGround {
    pub(crate) fn new(gpu: &Arc<Gpu>, ground: &Rc<Ground>) -> Result<Self, DeviceError> {
        let boxes = bytemuck::cast_slice(&ground.patch_boxes);
        let boxes = Buffer::upload(gpu, "patches' boxes", boxes, BufferUse::Storage)?;
        Ok(Self {
            gpu: Arc::clone(gpu),
            heights: heights(gpu, &ground.grid)?,
            boxes: Arc::new(boxes),
            ground: Rc::clone(ground),
        })
    }
}

/// Ground by one way.
pub(crate) struct OnVulkan {
    shared: Rc<VulkanGround>,
    way: CullWay,
    view: GridCamera,
    targets: RenderTargets,
    pipeline: DrawPipeline,
    compute: Option<ComputePipeline>,
    tiles: Arc<Buffer>,
    /// A list of patches, or how many a task shader kept.
    kept: Arc<Buffer>,
    arguments: Arc<Buffer>,
}

impl OnVulkan {
    pub(crate) fn new(
        shared: &Rc<VulkanGround>,
        way: CullWay,
        view: &GridCamera,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let (gpu, ground) = (&shared.gpu, &shared.ground);
        let constants = constants(ground, view, way.test);
        let words = |count: usize| 4 * count.max(1) as u64;
        let all = words(ground.patch_boxes.len());
        let storage = BufferUse::Storage;
        let kept = match way.place {
            CullStage::Cpu => Buffer::streamed(gpu, "patches", all, storage)?,
            CullStage::Compute => Buffer::unwritten(gpu, "patches", all, BufferUse::State)?,
            _ => Buffer::upload(gpu, "count of patches", &[0; 4], BufferUse::State)?,
        };
        let tile_bytes = words(ground.tile_boxes.len());
        let tiles = Arc::new(Buffer::streamed(gpu, "tiles", tile_bytes, storage)?);
        let arguments = Buffer::streamed(gpu, "draw arguments", 16, BufferUse::Arguments)?;
        let (kept, arguments) = (Arc::new(kept), Arc::new(arguments));
        let resources = vec![
            uniform(gpu, "ground", bytemuck::bytes_of(&constants))?,
            Resource::Image(Arc::clone(&shared.heights)),
            Resource::Storage(Arc::clone(&shared.boxes)),
            Resource::Storage(Arc::clone(&tiles)),
            Resource::Storage(Arc::clone(&kept)),
            Resource::Storage(Arc::clone(&arguments)),
        ];
        let resources = Resources::new(gpu, resources)?;
        let (stages, fragment) = stages(way.place);
        let compute = match way.place {
            CullStage::Compute => {
                let shader = wgsl("pipelines/cull.wgsl", "compute_main");
                Some(ComputePipeline::new(gpu, &resources, shader)?)
            }
            _ => None,
        };
        Ok(Self {
            pipeline: DrawPipeline::new(gpu, &resources, stages, fragment)?,
            shared: Rc::clone(shared),
            way,
            view: *view,
            targets: RenderTargets::new(gpu, size)?,
            compute,
            tiles,
            kept,
            arguments,
        })
    }

    /// Culls tiles, sends what is sent, tests and draws.
    fn frame(&mut self, measured: Measured) -> Result<(DirectReport, Sent), DeviceError> {
        let sent = Sent::new(&self.shared.ground, &self.view, self.way.place);
        self.tiles.stream(bytemuck::cast_slice(&sent.tiles))?;
        if let Some(arguments) = &sent.arguments {
            self.arguments.stream(bytemuck::cast_slice(arguments))?;
        }
        if let Some(patches) = &sent.patches {
            self.kept.stream(bytemuck::cast_slice(patches))?;
        }
        let ranges: Vec<_> = std::iter::once(0..sent.in_tiles).collect();
        let call = match self.way.place {
            CullStage::TilesAlone | CullStage::Cpu | CullStage::Compute => {
                DrawCall::Indirect(&self.arguments)
            }
            CullStage::Geometry => DrawCall::Vertices(&ranges),
            CullStage::Task => DrawCall::MeshGroups([sent.in_tiles.div_ceil(TASK_GROUP), 1]),
        };
        let dispatch = self.compute.as_ref().map(|pipeline| Dispatch {
            pipeline,
            groups: [sent.in_tiles.div_ceil(GROUP), 1, 1],
        });
        let draw = DirectDraw {
            pipeline: &self.pipeline,
            vertices: None,
            call,
        };
        let report = self.targets.draw_directly(dispatch, &draw, measured)?;
        Ok((report, sent))
    }

    /// What was kept, as each place says it.
    fn kept(&self, sent: Sent, counted: &Counted) -> Result<Kept, DeviceError> {
        let gpu = &self.shared.gpu;
        let words = |buffer: &Buffer| -> Result<Vec<u32>, DeviceError> {
            Ok(bytemuck::pod_collect_to_vec(&buffer.contents(gpu)?))
        };
        Ok(match self.way.place {
            CullStage::TilesAlone => Kept::List(sent.of_tiles(&self.shared.ground)),
            CullStage::Cpu => Kept::List(sent.patches.unwrap_or_default()),
            CullStage::Compute => listed(&words(&self.arguments)?, words(&self.kept)?),
            CullStage::Geometry => {
                let primitives = counted.primitives.ok_or_else(|| {
                    DeviceError::unsupported("pipeline statistics", &gpu.facts.name)
                })?;
                Kept::Count(primitives / u64::from(PATCH_TRIANGLES))
            }
            CullStage::Task => Kept::Count(u64::from(words(&self.kept)?[0])),
        })
    }
}

fn stages(place: CullStage) -> (PrimitiveStages, Shader) {
    let vertices =
        |entry_point, geometry, topology| numbered(wgsl(CULLED, entry_point), geometry, topology);
    let triangles = Topology::Triangles;
    let stages = match place {
        CullStage::TilesAlone => vertices("of_tiles", None, triangles),
        CullStage::Cpu | CullStage::Compute => vertices("of_list", None, triangles),
        CullStage::Geometry => {
            let output = GeometryOutput {
                name: "native/ground.geom.spv",
                vertices: 72,
                // Of a vertex: a position, and a number, whose location counts as a whole of four.
                components: 8,
            };
            vertices("labelled_point", Some(output), Topology::Points)
        }
        CullStage::Task => PrimitiveStages::Mesh {
            task: Some("native/ground.task.spv"),
            mesh: "native/ground.mesh.spv",
        },
    };
    let fragment = match place {
        CullStage::Task => Shader::Compiled("native/grid.frag.spv"),
        _ => wgsl(CULLED, "fragment_main"),
    };
    (stages, fragment)
}

impl Culls for OnVulkan {
    fn draw(&mut self) -> Result<Shown, DeviceError> {
        if self.way.place == CullStage::Task {
            self.kept.rewrite(0, &[0; 4])?;
        }
        let (report, sent) = self.frame(Measured::Statistics)?;
        let counted = Counted::from(report.statistics);
        Ok(Shown {
            picture: self.targets.read()?,
            sent_bytes: sent.bytes(),
            kept: self.kept(sent, &counted)?,
            counted,
        })
    }

    fn time(&mut self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        let (report, _) = self.frame(Measured::Times)?;
        Ok(Times::since(&watch, report.gpu_ms))
    }
}
