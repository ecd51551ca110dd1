// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes as the passes of a fill draw them: top caps, bottom caps, then walls.

use crate::layout::{RegionSlice, SceneGeometry};
use crate::pipeline::{Pipelines, VERTICES, VolumePart, WALL_CORNERS, WALLS};
use std::collections::BTreeMap;
use std::slice::from_ref;
use terrafill_contract::{DeviceError, Feature, FillInput, GeometryBytes};
use terrafill_gpu::{Gpu, VolumeFill, VolumePass, WgpuVolumes, index_format};
use terrafill_plan::{PartCulling, SeenParts};
use terrafill_stencil::{
    HeldMeshes, Holding, LaidOut, RegionVolumes, VolumeBackend, VolumeDraw, VolumeList, VolumePlace,
};
use terrafill_variant::Switches;

/// Shadow volumes whose walls are instances.
pub type InstancedBackend = VolumeBackend<InstancedVolumes>;

/// What a view sees of meshes of which it leaves parts out, by their number.
type SeenOfMeshes = BTreeMap<usize, SeenParts>;

/// Volumes of a scene, and the pipelines that draw them.
#[derive(Debug)]
pub struct InstancedVolumes {
    pipelines: Pipelines,
    scene: Option<SceneBuffers>,
    /// Meshes as they were laid out, part by part or not, where views bring them.
    laid_out: LaidOut<bool, SceneGeometry>,
    /// Triangles of large meshes lie part by part.
    by_part: bool,
    /// What the view sees of meshes of which it leaves parts out.
    seen: SeenOfMeshes,
}

/// Geometry of every region of a scene, in view or not.
#[derive(Debug)]
struct SceneBuffers {
    regions: Vec<RegionSlice>,
    vertices: wgpu::Buffer,
    /// Indices of 16 and of 32 bits; `None` where no region has such.
    short_indices: Option<wgpu::Buffer>,
    long_indices: Option<wgpu::Buffer>,
    walls: wgpu::Buffer,
    /// Of positions without walls.
    position_bytes: u64,
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
            laid_out: LaidOut::default(),
            by_part: false,
            seen: BTreeMap::new(),
        })
    }

    fn places(&self) -> Option<impl Fn(usize) -> VolumePlace> {
        let scene = self.scene.as_ref()?;
        Some(|mesh: usize| scene.regions[mesh].place)
    }

    fn holdings(&self) -> Vec<Holding> {
        let geometry = self.scene.iter().flat_map(SceneBuffers::holdings);
        geometry.chain(self.pipelines.holdings()).collect()
    }

    fn upload(
        &mut self,
        fill: &VolumeFill,
        input: &FillInput,
        _bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        let by_part = input.plan.options.part_culling != PartCulling::Off;
        let meshes = &input.scene.meshes;
        let geometry = self.laid_out.all(
            meshes,
            |_| by_part,
            |places| SceneGeometry::in_parts(&meshes[places], by_part),
            SceneGeometry::append,
        );
        self.by_part = by_part;
        self.upload_geometry(&fill.gpu(), geometry)
    }

    fn upload_view(
        &mut self,
        _fill: &VolumeFill,
        input: &FillInput,
        _bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        let seen = input.plan.seen_parts.iter();
        let some = seen.filter(|(_, seen)| self.by_part && seen.facets_left_out > 0);
        self.seen = some.map(|(&mesh, seen)| (mesh, seen.clone())).collect();
        Ok(())
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
        let indices = |label: &str, bytes: &[u8]| {
            let held = (!bytes.is_empty()).then(|| gpu.upload(label, bytes, index));
            held.transpose()
        };
        self.scene = Some(SceneBuffers {
            vertices: upload("volume vertices", vertices, vertex)?,
            short_indices: indices("16-bit indices", short)?,
            long_indices: indices("32-bit indices", long)?,
            position_bytes: vertices.len() as u64,
            walls: upload("walls", walls, vertex)?,
            bytes: geometry.bytes(),
            regions: geometry.regions,
        });
        Ok(())
    }
}

impl SceneBuffers {
    /// Bytes of its buffers by what they are for.
    fn holdings(&self) -> [Holding; 3] {
        let indices = [&self.short_indices, &self.long_indices]
            .into_iter()
            .flatten();
        let indices: Vec<u64> = indices.map(wgpu::Buffer::size).collect();
        let (positions, caps) = (self.position_bytes, self.bytes.index_bytes);
        let walls = self.bytes.vertex_bytes.saturating_sub(positions);
        [
            Holding::vertices(Feature::Positions, positions, &[self.vertices.size()]),
            Holding::indices(Feature::TopCaps, caps, &indices),
            Holding::vertices(Feature::Walls, walls, &[self.walls.size()]),
        ]
    }

    fn slice(&self, list: &VolumeList, volume: usize) -> &RegionSlice {
        &self.regions[list.volumes[volume].geometry]
    }

    fn bind_indices(&self, pass: &mut wgpu::RenderPass<'_>, is_short: bool) {
        let both = [&self.long_indices, &self.short_indices];
        if let Some(indices) = both[usize::from(is_short)] {
            pass.set_index_buffer(indices.slice(..), index_format(is_short));
        }
    }

    fn draw_caps(&self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, seen: &SeenOfMeshes) {
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
            let whole = 0..place.triangle_count;
            let parts = seen.get(&pass.list.volumes[volume].geometry);
            for range in parts.map_or(from_ref(&whole), |seen| &seen.caps) {
                let indices = first + 3 * range.start..first + 3 * range.end;
                pass.draw_indexed(indices, base_vertex, volume);
            }
        }
    }

    /// A whole body has no boundary, and so no walls to draw.
    fn draw_walls(&self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, seen: &SeenOfMeshes) {
        for &volume in draw.volumes {
            let walls = self.slice(pass.list, volume).walls.clone();
            if walls.is_empty() {
                continue;
            }
            pass.cut(volume, draw.scissor);
            let whole = 0..walls.end - walls.start;
            let parts = seen.get(&pass.list.volumes[volume].geometry);
            for range in parts.map_or(from_ref(&whole), |seen| &seen.walls) {
                let edges = walls.start + range.start..walls.start + range.end;
                pass.draw_instances(WALL_CORNERS, edges, volume);
            }
        }
    }
}

impl WgpuVolumes for InstancedVolumes {
    fn ensure(&mut self, gpu: &Gpu, _list: &VolumeList, draw: &VolumeDraw<'_>, _blends: bool) {
        for part in VolumePart::all(draw.without_bottom) {
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
        for part in VolumePart::all(draw.without_bottom) {
            if let Some(pipeline) = self.pipelines.volume(part, draw.state) {
                pass.raw.set_pipeline(pipeline);
            }
            match part {
                VolumePart::TopCap | VolumePart::BottomCap => {
                    scene.draw_caps(pass, draw, &self.seen);
                }
                VolumePart::Walls => scene.draw_walls(pass, draw, &self.seen),
            }
        }
    }
}
