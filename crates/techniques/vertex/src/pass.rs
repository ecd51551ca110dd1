// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes as the passes of a fill draw them: caps, then walls, then those that are turned over.

use crate::layout::{LaidOutMeshes, RegionSlice, SceneGeometry, index_bytes};
use crate::merged::Merged;
use crate::pipeline::{Pipelines, VolumePart, keys};
use crate::{Buffers, Layout, VertexVariant};
use std::ops::Range;
use terrafill_contract::{DeviceError, Feature, FillInput, GeometryBytes};
use terrafill_gpu::{Gpu, VolumeFill, VolumePass, WgpuVolumes, index_format};
use terrafill_scene::Overlap;
use terrafill_stencil::{
    DrawnOfMeshes, DrawnParts, FaceSet, FillProgram, HeldMeshes, Holding, IndexLists,
    PositionFormat, RegionVolumes, VolumeBackend, VolumeDraw, VolumeList, VolumePlace,
};
use terrafill_variant::Switches;

/// Shadow volumes extruded in the vertex shader.
pub type VertexBackend = VolumeBackend<VertexVolumes>;

/// Volumes of a scene, and the pipelines that draw them.
#[derive(Debug)]
pub struct VertexVolumes {
    variant: VertexVariant,
    pipelines: Pipelines,
    scene: Option<SceneBuffers>,
    /// What the view draws of meshes that it does not draw whole.
    drawn_parts: DrawnOfMeshes,
    /// Meshes as they were laid out, where views bring them.
    laid_out: LaidOutMeshes,
}

/// Geometry of every region of a scene, in view or not.
#[derive(Debug)]
struct SceneBuffers {
    regions: Vec<RegionSlice>,
    vertices: wgpu::Buffer,
    /// Layout `separate`: the flags that all regions share.
    flags: Option<wgpu::Buffer>,
    /// Indices of 16 and of 32 bits; `None` where no region has such.
    short_indices: Option<wgpu::Buffer>,
    long_indices: Option<wgpu::Buffer>,
    /// What `short_indices` holds: a device is written to in words, which two regions may share.
    short: Vec<u16>,
    /// Layout `pulled`: the vertices with the short and with the long indices.
    pulled: Option<[Option<wgpu::BindGroup>; 2]>,
    /// Volumes of one step are one draw: the lists of a view, which stand for those of the regions.
    merged: Option<Merged>,
    /// What is handed over anew in every frame, if it is.
    streamed: Option<Streamed>,
    bytes: GeometryBytes,
}

/// What is handed over in every frame, beside [`SceneBuffers::short`].
#[derive(Debug)]
struct Streamed {
    vertices: Vec<i32>,
    long: Vec<u32>,
}

impl RegionVolumes for VertexVolumes {
    const TECHNIQUE: &'static str = "vertex";
    type Executor = VolumeFill;
    type Variant = VertexVariant;

    fn switches(variant: VertexVariant) -> Result<Switches, DeviceError> {
        variant.check_layout()?;
        Ok(variant.switches)
    }

    fn new(fill: &VolumeFill, variant: VertexVariant) -> Result<Self, DeviceError> {
        Ok(Self {
            variant,
            pipelines: Pipelines::new(fill, variant)?,
            scene: None,
            drawn_parts: DrawnOfMeshes::new(),
            laid_out: LaidOutMeshes::default(),
        })
    }

    fn places(&self) -> Option<impl Fn(usize) -> VolumePlace> {
        let scene = self.scene.as_ref()?;
        Some(|mesh: usize| scene.regions[mesh].place)
    }

    fn positions(&self) -> PositionFormat {
        self.variant.positions
    }

    fn opacity(&self, overlap: Overlap) -> Result<f32, DeviceError> {
        self.variant.check(overlap)?;
        Ok(f32::from(self.variant.opacity_percent) / 100.0)
    }

    fn holdings(&self) -> Vec<Holding> {
        let scene = self.scene.iter();
        let geometry = scene.flat_map(|scene| scene.holdings(self.variant.layout));
        geometry.chain(self.pipelines.holdings()).collect()
    }

    fn stores_bottom_caps(&self) -> bool {
        self.variant.layout.is_doubled() && !self.variant.merges_volumes()
    }

    fn upload(
        &mut self,
        fill: &VolumeFill,
        input: &FillInput,
        bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        let gpu = fill.gpu();
        let layout = self.variant.layout;
        // The CPU keeps those of merged draws, and hands over what a view draws.
        let has_bottom = |mesh| self.variant.merges_volumes() || bottoms.has(mesh);
        let (variant, meshes) = (&self.variant, &input.scene.meshes);
        // Those of a scene that is held whole are laid out once.
        let mut geometry = if meshes.is_whole() {
            SceneGeometry::build(variant, meshes, has_bottom)
        } else {
            SceneGeometry::of_held(variant, meshes, has_bottom, &mut self.laid_out)
        };
        let bytes = geometry.bytes();
        let (vertex_usage, index_usage) = match layout {
            Layout::Pulled => (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::STORAGE),
            _ => (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX),
        };
        let upload = |label, bytes, usage| gpu.upload(label, bytes, usage);
        let vertices = upload(
            "volume vertices",
            bytemuck::cast_slice(&geometry.vertices),
            vertex_usage,
        )?;
        let flags = match layout {
            Layout::Separate => Some(upload(
                "shared flags",
                geometry.flags.as_flattened(),
                vertex_usage,
            )?),
            _ => None,
        };
        let indices = |label: &str, bytes: &[u8]| {
            let held = (!bytes.is_empty()).then(|| gpu.upload(label, bytes, index_usage));
            held.transpose()
        };
        let merged = if self.variant.merges_volumes() {
            let stored = std::mem::take(&mut geometry.indices);
            let layout = &self.pipelines.geometry_layout;
            let vertices = geometry.vertices.len() / self.variant.vertex_words();
            Some(Merged::new(
                &gpu,
                layout,
                meshes.len(),
                vertices,
                (stored, self.variant.has_strips()),
            )?)
        } else {
            None
        };
        let short = bytemuck::cast_slice(&geometry.indices.short);
        let short_indices = indices("16-bit indices", short)?;
        let long = bytemuck::cast_slice(&geometry.indices.long);
        let long_indices = indices("32-bit indices", long)?;
        let bind = |indices: &Option<wgpu::Buffer>| {
            let layout = &self.pipelines.geometry_layout;
            let bind = |indices| gpu.bind_buffers("pulled geometry", layout, &[&vertices, indices]);
            indices.as_ref().map(bind)
        };
        let pulled =
            (layout == Layout::Pulled).then(|| [bind(&short_indices), bind(&long_indices)]);
        let streamed = (self.variant.buffers == Buffers::Streamed).then_some(Streamed {
            vertices: geometry.vertices,
            long: geometry.indices.long,
        });
        self.scene = Some(SceneBuffers {
            regions: geometry.regions,
            vertices,
            flags,
            short_indices,
            long_indices,
            short: geometry.indices.short,
            pulled,
            merged,
            streamed,
            bytes,
        });
        Ok(())
    }

    fn upload_view(
        &mut self,
        _fill: &VolumeFill,
        input: &FillInput,
        _bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        self.drawn_parts = if self.variant.parts {
            DrawnParts::of_view(input, self.variant.wall_indices())
        } else {
            DrawnOfMeshes::new()
        };
        Ok(())
    }

    fn rewrite(
        &mut self,
        fill: &VolumeFill,
        input: &FillInput,
        changed: &[usize],
    ) -> Result<bool, DeviceError> {
        let Some(scene) = &mut self.scene else {
            return Ok(false);
        };
        if !input.scene.levels.coarser.is_empty() {
            return Ok(false);
        }
        let gpu = fill.gpu();
        let mut rewritten = Vec::with_capacity(changed.len());
        for &mesh in changed {
            let mesh_alone = std::slice::from_ref(&input.scene.meshes[mesh]);
            let has_bottom = scene.regions[mesh].has_bottom;
            let geometry =
                SceneGeometry::build_from(&self.variant, mesh_alone, |_| has_bottom, mesh);
            let Some(slice) = scene.regions[mesh].replaced_by(&geometry.regions[0]) else {
                return Ok(false);
            };
            rewritten.push((mesh, slice, geometry));
        }
        let vertex_bytes = 4 * self.variant.vertex_words() as u64;
        for (mesh, slice, geometry) in rewritten {
            let first_byte = u64::from(slice.place.first_vertex) * vertex_bytes;
            let vertices = bytemuck::cast_slice(&geometry.vertices);
            gpu.write_buffer(&scene.vertices, first_byte, vertices);
            scene.keep_streamed(&slice, &geometry, self.variant.vertex_words());
            match &mut scene.merged {
                // What changed of them is handed over with the view.
                Some(merged) => merged.replace(slice.indices(), &geometry.indices),
                None => scene.write_indices(&gpu, slice.indices(), &geometry.indices),
            }
            scene.regions[mesh] = slice;
        }
        Ok(true)
    }
}

/// Writes into a buffer that is there wherever something is to be written.
fn write(gpu: &Gpu, buffer: Option<&wgpu::Buffer>, first_byte: u64, bytes: &[u8]) {
    if let Some(buffer) = buffer {
        gpu.write_buffer(buffer, first_byte, bytes);
    }
}

impl SceneBuffers {
    /// Bytes of its buffers by what they are for; what all regions' indices share is the top caps'.
    fn holdings(&self, layout: Layout) -> Vec<Holding> {
        let sizes = |buffers: [Option<&wgpu::Buffer>; 2]| -> Vec<u64> {
            buffers
                .into_iter()
                .flatten()
                .map(wgpu::Buffer::size)
                .collect()
        };
        let vertices = sizes([Some(&self.vertices), self.flags.as_ref()]);
        let positions = Holding::vertices(Feature::Positions, self.bytes.vertex_bytes, &vertices);
        let mut all = vec![positions];
        if let Some(merged) = &self.merged {
            all.extend(merged.holdings());
        } else {
            let indices = sizes([self.short_indices.as_ref(), self.long_indices.as_ref()]);
            all.extend(index_bytes(layout, &self.regions).holdings(&indices));
        }
        all
    }

    /// Holds a region's new geometry for the frames to come, where they are handed it.
    fn keep_streamed(&mut self, slice: &RegionSlice, new: &SceneGeometry, words: usize) {
        if let Some(streamed) = &mut self.streamed {
            let first = slice.place.first_vertex as usize * words;
            streamed.vertices[first..first + new.vertices.len()].copy_from_slice(&new.vertices);
            if !new.indices.long.is_empty() {
                streamed.long[slice.indices()].copy_from_slice(&new.indices.long);
            }
        }
    }

    /// Hands over the regions of `list` anew.
    fn stream(&self, gpu: &Gpu, list: &VolumeList, words: usize) {
        let Some(streamed) = &self.streamed else {
            return;
        };
        for volume in 0..list.volumes.len() {
            let slice = self.slice(list, volume);
            let first = slice.place.first_vertex as usize * words;
            let vertices = &streamed.vertices[first..][..slice.vertex_count as usize * words];
            let first_byte = 4 * first as u64;
            gpu.write_buffer(&self.vertices, first_byte, bytemuck::cast_slice(vertices));
            if slice.place.has_short_indices {
                let (first_byte, pairs) = whole_words(&self.short, slice.indices());
                let pairs = bytemuck::cast_slice(&pairs);
                write(gpu, self.short_indices.as_ref(), first_byte, pairs);
            } else {
                let first_byte = 4 * slice.indices().start as u64;
                let long = bytemuck::cast_slice(&streamed.long[slice.indices()]);
                write(gpu, self.long_indices.as_ref(), first_byte, long);
            }
        }
    }

    /// Writes the indices of a region, which are all of one width.
    fn write_indices(&mut self, gpu: &Gpu, range: Range<usize>, indices: &IndexLists) {
        if !indices.long.is_empty() {
            let first_byte = 4 * range.start as u64;
            let long = bytemuck::cast_slice(&indices.long);
            write(gpu, self.long_indices.as_ref(), first_byte, long);
        }
        // Where triangles stay as they are, so do their indices.
        if !indices.short.is_empty() && self.short[range.clone()] != indices.short {
            self.short[range.clone()].copy_from_slice(&indices.short);
            let (first_byte, words) = whole_words(&self.short, range);
            let words = bytemuck::cast_slice(&words);
            write(gpu, self.short_indices.as_ref(), first_byte, words);
        }
    }

    fn slice(&self, list: &VolumeList, volume: usize) -> &RegionSlice {
        &self.regions[list.volumes[volume].geometry]
    }

    /// Those of `volumes` whose indices have this width.
    fn of_width(
        &self,
        list: &VolumeList,
        volumes: &[usize],
        short_indices: bool,
    ) -> impl Iterator<Item = usize> {
        let is_of_width = move |volume: &usize| {
            self.slice(list, *volume).place.has_short_indices == short_indices
        };
        volumes.iter().copied().filter(is_of_width)
    }

    fn bind_indices(&self, pass: &mut wgpu::RenderPass<'_>, short_indices: bool) {
        if let Some(pulled) = &self.pulled {
            pass.set_bind_group(1, pulled[usize::from(!short_indices)].as_ref(), &[]);
            return;
        }
        let both = [&self.long_indices, &self.short_indices];
        if let Some(indices) = both[usize::from(short_indices)] {
            pass.set_index_buffer(indices.slice(..), index_format(short_indices));
        }
    }
}

/// The pairs of indices that hold those of `range`, and where they begin, in bytes. A buffer with an
/// odd number of indices ends with zeros.
fn whole_words(list: &[u16], range: Range<usize>) -> (u64, Vec<[u16; 2]>) {
    let first = range.start / 2 * 2;
    let end = range.end.next_multiple_of(2).min(list.len());
    let pairs = list[first..end].chunks(2);
    let words = pairs.map(|pair| [pair[0], pair.get(1).copied().unwrap_or(0)]);
    (2 * first as u64, words.collect())
}

impl WgpuVolumes for VertexVolumes {
    fn ensure(&mut self, gpu: &Gpu, list: &VolumeList, draw: &VolumeDraw<'_>, blends: bool) {
        let Some(scene) = &self.scene else {
            return;
        };
        for short_indices in [true, false] {
            let is_drawn = if let Some(merged) = &scene.merged {
                merged.has_short_indices() == short_indices
            } else {
                let mut drawn = scene.of_width(list, draw.volumes, short_indices);
                drawn.next().is_some()
            };
            if is_drawn {
                for key in keys(self.variant.layout, short_indices, draw.state, blends) {
                    self.pipelines.ensure(gpu, key);
                }
            }
        }
    }

    fn merge(
        &mut self,
        gpu: &Gpu,
        list: &VolumeList,
        program: &FillProgram,
    ) -> Result<(), DeviceError> {
        match &mut self.scene {
            Some(SceneBuffers {
                merged: Some(merged),
                regions,
                ..
            }) => merged.load(gpu, list, program, regions, &self.drawn_parts),
            _ => Ok(()),
        }
    }

    fn are_streamed(&self) -> bool {
        let scene = self.scene.as_ref();
        scene.is_some_and(|scene| scene.streamed.is_some())
    }

    fn stream(&mut self, gpu: &Gpu, list: &VolumeList) {
        if let Some(scene) = &self.scene {
            scene.stream(gpu, list, self.variant.vertex_words());
        }
    }

    fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        let Some(scene) = &self.scene else {
            return;
        };
        if scene.pulled.is_none() {
            pass.set_vertex_buffer(0, scene.vertices.slice(..));
        }
        if let Some(flags) = &scene.flags {
            pass.set_vertex_buffer(1, flags.slice(..));
        }
        if let Some(merged) = &scene.merged {
            merged.bind(pass);
        }
    }

    /// Caps of all volumes, then walls of all, so that pipelines change seldom.
    fn draw(&mut self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, blends: bool) {
        let Some(scene) = &self.scene else {
            return;
        };
        if let Some(merged) = &scene.merged {
            self.draw_merged(merged, pass, draw, blends);
            return;
        }
        for short_indices in [true, false] {
            for key in keys(self.variant.layout, short_indices, draw.state, blends) {
                let mut is_bound = false;
                for volume in scene.of_width(pass.list, draw.volumes, short_indices) {
                    if !is_bound {
                        if let Some(pipeline) = self.pipelines.volume(key) {
                            pass.raw.set_pipeline(pipeline);
                        }
                        scene.bind_indices(&mut pass.raw, short_indices);
                        is_bound = true;
                    }
                    pass.cut(volume, draw.scissor);
                    self.draw_part(scene, pass, key.part, volume, draw);
                }
            }
        }
    }
}

impl VertexVolumes {
    /// All volumes of the step, caps and then walls.
    fn draw_merged(
        &self,
        merged: &Merged,
        pass: &mut VolumePass<'_>,
        draw: &VolumeDraw<'_>,
        blends: bool,
    ) {
        let (Some(ranges), Some(&first)) = (merged.ranges(draw), draw.volumes.first()) else {
            return;
        };
        pass.cut(first, false);
        let short_indices = merged.has_short_indices();
        for key in keys(self.variant.layout, short_indices, draw.state, blends) {
            let range = match key.part {
                VolumePart::Caps => &ranges.caps,
                VolumePart::Walls { .. } | VolumePart::TurnedWalls => &ranges.walls,
            };
            if let Some(pipeline) = self.pipelines.volume(key).filter(|_| !range.is_empty()) {
                pass.raw.set_pipeline(pipeline);
                pass.draw_indexed(range.clone(), 0, first);
            }
        }
    }

    fn draw_part(
        &self,
        scene: &SceneBuffers,
        pass: &mut VolumePass<'_>,
        part: VolumePart,
        volume: usize,
        draw: &VolumeDraw<'_>,
    ) {
        let slice = scene.slice(pass.list, volume);
        let VolumeDraw {
            state,
            without_bottom,
            ..
        } = *draw;
        let with_bottom = !without_bottom && slice.has_bottom;
        debug_assert!(slice.has_bottom || without_bottom, "no bottom is held");
        let cap = 3 * slice.place.triangle_count;
        let caps = if with_bottom { 2 * cap } else { cap };
        let parts = self.drawn_parts.get(&pass.list.volumes[volume].geometry);
        let is_pulled = scene.pulled.is_some();
        let (walls, turned) = (slice.loop_index_count, slice.turned_index_count);
        let inner_wall = walls - 2 * turned;
        let base_vertex = if scene.flags.is_some() {
            // Every region starts at the first flag, so its positions must start there too.
            let stride = 4 * self.variant.vertex_words() as u64;
            let first_byte = u64::from(slice.place.first_vertex) * stride;
            pass.raw
                .set_vertex_buffer(0, scene.vertices.slice(first_byte..));
            0
        } else {
            i32::try_from(slice.place.first_vertex).unwrap_or(i32::MAX)
        };
        let first = match part {
            VolumePart::Caps => slice.place.first_triangle_index,
            VolumePart::Walls { .. } | VolumePart::TurnedWalls => slice.place.first_loop_index,
        };
        let mut draw = |range: Range<u32>| {
            if is_pulled {
                pass.draw(range, volume);
            } else if !range.is_empty() {
                let indices = first + range.start..first + range.end;
                pass.draw_indexed(indices, base_vertex, volume);
            }
        };
        match (part, parts) {
            (VolumePart::Caps, Some(parts)) => {
                parts.both_caps(cap, with_bottom).into_iter().for_each(draw);
            }
            (VolumePart::Caps, None) => draw(0..caps),
            (VolumePart::Walls { .. }, Some(parts)) => parts.walls.iter().cloned().for_each(draw),
            // Entry e needs entry e + 1; the last one is a separator.
            (VolumePart::Walls { .. }, None) if is_pulled => draw(0..6 * walls.saturating_sub(1)),
            // See `push_inner_walls`.
            (VolumePart::Walls { .. }, None) if turned > 0 && state.faces() != FaceSet::Both => {
                draw(0..inner_wall);
                draw(inner_wall..inner_wall + turned);
            }
            (VolumePart::Walls { .. }, None) => draw(0..inner_wall + turned),
            (VolumePart::TurnedWalls, _) => draw(inner_wall..inner_wall + turned),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_hold_a_range_and_what_shares_a_word_with_it() {
        let list = [1, 2, 3, 4, 5];
        assert_eq!(whole_words(&list, 0..2), (0, vec![[1, 2]]));
        assert_eq!(whole_words(&list, 1..2), (0, vec![[1, 2]]));
        assert_eq!(whole_words(&list, 1..3), (0, vec![[1, 2], [3, 4]]));
        assert_eq!(whole_words(&list, 3..5), (4, vec![[3, 4], [5, 0]]));
        assert_eq!(whole_words(&list, 4..5), (8, vec![[5, 0]]));
    }
}
