// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes as the passes of a fill draw them: top caps, bottom caps, then walls.

use crate::layout::{RegionSlice, SceneGeometry};
use crate::pipeline::{Part, Pipelines, VERTICES, WALL_CORNERS, WALLS};
use terrafill_fill::{
    DeviceError, FillInput, GeometryBytes, MemoryUse, RegionVolumes, Switches, VolumeBackend,
    VolumeDraw, VolumeList, VolumePlace,
};
use terrafill_gpu::{Gpu, VolumeFill, VolumePass, Volumes};

/// Shadow volumes whose walls are instances.
pub type InstancedBackend = VolumeBackend<InstancedVolumes>;

/// Volumes of a scene, and the pipelines that draw them.
#[derive(Debug)]
pub struct InstancedVolumes {
    pipelines: Pipelines,
    scene: Option<SceneBuffers>,
}

/// Geometry of every region of a scene, in view or not.
#[derive(Debug)]
struct SceneBuffers {
    regions: Vec<RegionSlice>,
    vertices: wgpu::Buffer,
    short_indices: wgpu::Buffer,
    long_indices: wgpu::Buffer,
    walls: wgpu::Buffer,
    bytes: GeometryBytes,
}

/// An update re-uploads every region: walls and caps of one region lie in four buffers, and none of
/// them is rewritten in part yet.
impl RegionVolumes for InstancedVolumes {
    const TECHNIQUE: &'static str = "instanced";
    type Executor = VolumeFill;
    type Variant = Switches;

    fn switches(variant: Switches) -> Result<Switches, DeviceError> {
        Ok(variant)
    }

    fn new(fill: &VolumeFill, _variant: Switches) -> Result<Self, DeviceError> {
        Ok(Self {
            pipelines: Pipelines::new(fill)?,
            scene: None,
        })
    }

    fn places(&self) -> Option<impl Fn(usize) -> VolumePlace> {
        let scene = self.scene.as_ref()?;
        Some(|mesh: usize| scene.regions[mesh].place)
    }

    fn memory(&self) -> MemoryUse {
        let held = self.scene.as_ref().map(|scene| MemoryUse {
            // Vertices, indices of both widths, and walls.
            buffers: 4,
            ..scene.bytes.into()
        });
        held.unwrap_or_default()
    }

    fn upload(&mut self, fill: &VolumeFill, input: &FillInput) -> Result<(), DeviceError> {
        self.upload_geometry(&fill.gpu(), SceneGeometry::build(&input.scene.meshes))
    }
}

impl InstancedVolumes {
    pub(crate) fn upload_geometry(
        &mut self,
        gpu: &Gpu,
        geometry: SceneGeometry,
    ) -> Result<(), DeviceError> {
        let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
        let upload = |label, bytes, usage| gpu.upload(label, bytes, usage);
        let vertices = bytemuck::cast_slice(&geometry.vertices);
        let short = bytemuck::cast_slice(&geometry.indices.short);
        let long = bytemuck::cast_slice(&geometry.indices.long);
        let walls = bytemuck::cast_slice(&geometry.walls);
        self.scene = Some(SceneBuffers {
            vertices: upload("volume vertices", vertices, vertex)?,
            short_indices: upload("16-bit indices", short, index)?,
            long_indices: upload("32-bit indices", long, index)?,
            walls: upload("walls", walls, vertex)?,
            bytes: geometry.bytes(),
            regions: geometry.regions,
        });
        Ok(())
    }
}

impl SceneBuffers {
    fn slice(&self, list: &VolumeList, volume: usize) -> &RegionSlice {
        &self.regions[list.volumes[volume].geometry]
    }

    fn bind_indices(&self, pass: &mut wgpu::RenderPass<'_>, is_short: bool) {
        if is_short {
            let indices = self.short_indices.slice(..);
            pass.set_index_buffer(indices, wgpu::IndexFormat::Uint16);
        } else {
            let indices = self.long_indices.slice(..);
            pass.set_index_buffer(indices, wgpu::IndexFormat::Uint32);
        }
    }

    fn draw_caps(&self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>) {
        let mut bound = None;
        for &volume in draw.volumes {
            let place = &self.slice(pass.list, volume).place;
            let is_short = place.has_short_indices;
            if bound != Some(is_short) {
                self.bind_indices(&mut pass.raw, is_short);
                bound = Some(is_short);
            }
            let first = place.first_triangle_index;
            let base_vertex = i32::try_from(place.first_vertex).unwrap_or(i32::MAX);
            pass.cut(volume, draw.scissor);
            pass.draw_indexed(first..first + 3 * place.triangle_count, base_vertex, volume);
        }
    }

    /// A whole body has no boundary, and so no walls to draw.
    fn draw_walls(&self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>) {
        for &volume in draw.volumes {
            let walls = self.slice(pass.list, volume).walls.clone();
            if !walls.is_empty() {
                pass.cut(volume, draw.scissor);
                pass.draw_instances(WALL_CORNERS, walls, volume);
            }
        }
    }
}

impl Volumes for InstancedVolumes {
    fn ensure(&mut self, gpu: &Gpu, _list: &VolumeList, draw: &VolumeDraw<'_>, _blends: bool) {
        for part in Part::all(draw.without_bottom) {
            self.pipelines.ensure(gpu, part, draw.state);
        }
    }

    fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(scene) = &self.scene {
            pass.set_vertex_buffer(VERTICES, scene.vertices.slice(..));
            pass.set_vertex_buffer(WALLS, scene.walls.slice(..));
        }
    }

    /// A part of all volumes, then the next one, so that pipelines change seldom.
    fn draw(&mut self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, _blends: bool) {
        let Some(scene) = &self.scene else {
            return;
        };
        for part in Part::all(draw.without_bottom) {
            if let Some(pipeline) = self.pipelines.volume(part, draw.state) {
                pass.raw.set_pipeline(pipeline);
            }
            match part {
                Part::TopCap | Part::BottomCap => scene.draw_caps(pass, draw),
                Part::Walls => scene.draw_walls(pass, draw),
            }
        }
    }
}
