// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes of one step as one draw for each part: one index list for a view, in the order in which its
//! program draws.
//!
//! Volumes share a draw where nothing but their data differs: those that flip the same number, which do not
//! overlap on the screen, or all that are counted together. Such volumes are neighbours neither on the
//! ground nor in the scene's buffers, so that ranges of one list hardly ever join. Their indices are few,
//! though: the CPU keeps those of all regions and hands over what a view draws. Vertices stay on the
//! device. Each says of which region it is, and a table where that region's constants are in the view.

use crate::layout::RegionSlice;
use std::collections::HashMap;
use std::ops::Range;
use terrafill_contract::{DeviceError, Feature};
use terrafill_core::index_u32;
use terrafill_gpu::{Gpu, index_format};
use terrafill_stencil::{
    DrawnOfMeshes, FillPass, FillProgram, FillStep, Holding, IndexBytes, IndexLists, VolumeDraw,
    VolumeList,
};

/// Restarts strips, in either width.
const RESTART: u32 = u32::MAX;

/// Largest number of stored vertices whose indices fit 16 bits.
const MAX_SHORT_VERTICES: usize = 0xffff;

/// Where the volumes of a draw lie in the list, in indices.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct MergedRanges {
    /// Top caps, and bottom caps where they are drawn.
    pub(crate) caps: Range<u32>,
    pub(crate) walls: Range<u32>,
}

/// The index list of a view.
#[derive(Debug, Default, PartialEq, Eq)]
struct MergedLists {
    /// Into the scene's vertices.
    indices: Vec<u32>,
    /// By the volumes that are drawn together, first with their bottoms, then without.
    ranges: HashMap<Vec<usize>, [Option<MergedRanges>; 2]>,
    /// How many of the indices are for what.
    top_caps: usize,
    bottom_caps: usize,
    walls: usize,
}

impl MergedLists {
    /// The volumes of all draws of `program`; what two of them draw alike lies there once.
    fn new(list: &VolumeList, program: &FillProgram, held: &Held<'_>) -> Self {
        let mut merged = Self::default();
        for step in program.passes.iter().flat_map(FillPass::steps) {
            if let FillStep::Volumes(draw) = step {
                merged.push(list, &draw, held);
            }
        }
        merged
    }

    fn push(&mut self, list: &VolumeList, draw: &VolumeDraw<'_>, held: &Held<'_>) {
        let ranges = self.ranges.entry(draw.volumes.to_vec()).or_default();
        let own = &mut ranges[usize::from(draw.without_bottom)];
        if own.is_some() {
            return;
        }
        let meshes = || draw.volumes.iter().map(|&v| list.volumes[v].geometry);
        let first_cap = self.indices.len();
        for mesh in meshes() {
            let slice = &held.regions[mesh];
            let cap = 3 * slice.place.triangle_count;
            let has_bottom = !draw.without_bottom && slice.has_bottom;
            debug_assert!(slice.has_bottom || draw.without_bottom, "no bottom is held");
            let before = self.indices.len();
            let first = slice.place.first_triangle_index;
            if let Some(parts) = held.drawn_parts.get(&mesh) {
                for range in parts.both_caps(cap, has_bottom) {
                    held.copy(slice, first, range, &mut self.indices);
                }
            } else {
                let both = if has_bottom { 2 * cap } else { cap };
                held.copy(slice, first, 0..both, &mut self.indices);
            }
            let both = self.indices.len() - before;
            let bottom = if has_bottom { both / 2 } else { 0 };
            self.top_caps += both - bottom;
            self.bottom_caps += bottom;
        }
        let first_wall = self.indices.len();
        for mesh in meshes() {
            let slice = &held.regions[mesh];
            let first = slice.place.first_loop_index;
            let Some(parts) = held.drawn_parts.get(&mesh) else {
                held.copy(slice, first, 0..slice.loop_index_count, &mut self.indices);
                continue;
            };
            for range in &parts.walls {
                held.copy(slice, first, range.clone(), &mut self.indices);
                if held.has_strips {
                    self.indices.push(RESTART);
                }
            }
        }
        self.walls += self.indices.len() - first_wall;
        *own = Some(MergedRanges {
            caps: index_u32(first_cap)..index_u32(first_wall),
            walls: index_u32(first_wall)..index_u32(self.indices.len()),
        });
    }

    /// As the device reads them.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "short indices are below 2^16 by choice of width, or the restart value"
    )]
    fn bytes(&self, is_short: bool) -> Vec<u8> {
        if !is_short {
            return bytemuck::cast_slice(&self.indices).to_vec();
        }
        let mut short: Vec<u16> = self.indices.iter().map(|&index| index as u16).collect();
        // Buffers are written in words.
        if !short.len().is_multiple_of(2) {
            short.push(0);
        }
        bytemuck::cast_slice(&short).to_vec()
    }
}

/// What lists of a view are made from.
struct Held<'a> {
    regions: &'a [RegionSlice],
    stored: &'a IndexLists,
    /// Walls are strips.
    has_strips: bool,
    drawn_parts: &'a DrawnOfMeshes,
}

impl Held<'_> {
    /// Appends indices of a region, as they count in the vertices of all.
    ///
    /// - `range`: after the index `first`
    fn copy(&self, slice: &RegionSlice, first: u32, range: Range<u32>, to: &mut Vec<u32>) {
        let range = (first + range.start) as usize..(first + range.end) as usize;
        let first_vertex = slice.place.first_vertex;
        if slice.place.has_short_indices {
            to.extend(self.stored.short[range].iter().map(|&index| match index {
                u16::MAX => RESTART,
                index => first_vertex + u32::from(index),
            }));
        } else {
            to.extend(self.stored.long[range].iter().map(|&index| match index {
                RESTART => RESTART,
                index => first_vertex + index,
            }));
        }
    }
}

/// What the lists of a view depend on: a program, the geometry of each of its volumes, and what is drawn of
/// those that are not drawn whole.
#[derive(Debug, PartialEq)]
struct Listed {
    program: FillProgram,
    geometries: Vec<usize>,
    drawn_parts: DrawnOfMeshes,
}

/// What merged draws hold beside the scene's vertices.
#[derive(Debug)]
pub(crate) struct Merged {
    /// Indices of all regions.
    stored: IndexLists,
    /// Walls are strips.
    has_strips: bool,
    is_short: bool,
    /// What `lists` are of.
    listed: Option<Listed>,
    lists: MergedLists,
    indices: Option<wgpu::Buffer>,
    /// What that holds.
    written: Vec<u8>,
    volume_of_region: wgpu::Buffer,
    volumes_written: Vec<u32>,
    bind_group: wgpu::BindGroup,
}

impl Merged {
    /// - `layout`: of one storage buffer
    /// - `regions`: how many there are at most
    /// - `vertices`: as stored, of all of them
    /// - `stored`: indices of all of them, and whether walls are strips
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`].
    pub(crate) fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        regions: usize,
        vertices: usize,
        (stored, has_strips): (IndexLists, bool),
    ) -> Result<Self, DeviceError> {
        let volumes = vec![0_u32; regions.max(1)];
        let volume_of_region = gpu.upload(
            "volumes of regions",
            bytemuck::cast_slice(&volumes),
            wgpu::BufferUsages::STORAGE,
        )?;
        Ok(Self {
            stored,
            has_strips,
            is_short: vertices <= MAX_SHORT_VERTICES,
            listed: None,
            lists: MergedLists::default(),
            indices: None,
            written: Vec::new(),
            bind_group: gpu.bind_buffers("volumes of regions", layout, &[&volume_of_region]),
            volume_of_region,
            volumes_written: volumes,
        })
    }

    /// Indices of a region that took another one's place.
    pub(crate) fn replace(&mut self, range: Range<usize>, new: &IndexLists) {
        self.listed = None;
        if !new.short.is_empty() {
            self.stored.short[range.clone()].copy_from_slice(&new.short);
        }
        if !new.long.is_empty() {
            self.stored.long[range].copy_from_slice(&new.long);
        }
    }

    /// Hands over the list of a program and where its volumes' constants lie, where they changed.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`].
    pub(crate) fn load(
        &mut self,
        gpu: &Gpu,
        list: &VolumeList,
        program: &FillProgram,
        regions: &[RegionSlice],
        drawn_parts: &DrawnOfMeshes,
    ) -> Result<(), DeviceError> {
        let listed = Listed {
            program: program.clone(),
            geometries: list.volumes.iter().map(|volume| volume.geometry).collect(),
            drawn_parts: drawn_parts.clone(),
        };
        if self.listed.as_ref() == Some(&listed) {
            return Ok(());
        }
        self.listed = None;
        let mut volumes = vec![0_u32; self.volumes_written.len()];
        for (number, volume) in (0..).zip(&list.volumes) {
            volumes[volume.geometry] = number;
        }
        let [before, after] = [&self.volumes_written, &volumes].map(|v| bytemuck::cast_slice(v));
        gpu.write_changed(&self.volume_of_region, before, after);
        self.volumes_written = volumes;
        let held = Held {
            regions,
            stored: &self.stored,
            has_strips: self.has_strips,
            drawn_parts,
        };
        self.lists = MergedLists::new(list, program, &held);
        let bytes = self.lists.bytes(self.is_short);
        let has_room = |buffer: &wgpu::Buffer| buffer.size() >= bytes.len() as u64;
        if let Some(buffer) = self.indices.take().filter(has_room) {
            gpu.write_changed(&buffer, &self.written, &bytes);
            self.indices = Some(buffer);
        } else {
            let usage = wgpu::BufferUsages::INDEX;
            self.indices = Some(gpu.upload("merged indices", &bytes, usage)?);
        }
        self.written = bytes;
        self.listed = Some(listed);
        Ok(())
    }

    /// Where a draw's volumes lie; `None` of a draw that the program has not.
    pub(crate) fn ranges(&self, draw: &VolumeDraw<'_>) -> Option<&MergedRanges> {
        let both = self.lists.ranges.get(draw.volumes)?;
        both[usize::from(draw.without_bottom)].as_ref()
    }

    /// Whether indices have 16 bits.
    pub(crate) fn has_short_indices(&self) -> bool {
        self.is_short
    }

    pub(crate) fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(1, &self.bind_group, &[]);
        if let Some(indices) = &self.indices {
            pass.set_index_buffer(indices.slice(..), index_format(self.is_short));
        }
    }

    /// Bytes of its buffers by what they are for.
    pub(crate) fn holdings(&self) -> Vec<Holding> {
        let index_size = if self.is_short { 2 } else { 4 };
        let bytes = |indices: usize| (indices * index_size) as u64;
        let indices = IndexBytes {
            top_caps: bytes(self.lists.top_caps),
            bottom_caps: bytes(self.lists.bottom_caps),
            walls: bytes(self.lists.walls),
            spared: bytes(self.lists.top_caps - self.lists.bottom_caps),
        };
        let buffers: Vec<u64> = self.indices.iter().map(wgpu::Buffer::size).collect();
        let volumes = self.volume_of_region.size();
        let volumes = Holding::constants(Feature::RegionConstants, volumes, volumes);
        let indices = indices.holdings(&buffers).into_iter();
        indices.chain([volumes]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VertexVariant;
    use crate::layout::SceneGeometry;
    use std::collections::BTreeSet;
    use terrafill_contract::ViewId;
    use terrafill_fixtures::by_hand::{circle_deg, mesh};
    use terrafill_plan::{DrawnAs, NearRectangle, PixelRect};
    use terrafill_scene::{ImageSize, Overlap};
    use terrafill_stencil::{DepthRange, Volume};
    use terrafill_variant::Switches;

    /// Rings of 3, 5 and 40,000 vertices: the last one has indices of 32 bits.
    fn geometry() -> SceneGeometry {
        let ring = |count: u32| {
            let fan = (1..count - 1).map(|i| [0, i, i + 1]).collect();
            mesh(circle_deg(count, 1.0), fan, vec![(0..count).collect()])
        };
        let meshes = [ring(3), ring(5), ring(40_000)];
        SceneGeometry::build(&VertexVariant::default(), &meshes, |_| true)
    }

    /// Volumes of the meshes 2, 0 and 1, the first and the last beside each other.
    fn list() -> VolumeList {
        let volume = |geometry: usize, left: u32| Volume {
            screen_rect: PixelRect {
                left,
                top: 0,
                right: left + 10,
                bottom: 10,
            },
            depth: DepthRange::ANY,
            near_rectangle: NearRectangle::Outside,
            drawn_as: DrawnAs::Volume,
            geometry,
        };
        let size = ImageSize::new(64, 64);
        let volumes = vec![volume(2, 0), volume(0, 5), volume(1, 20)];
        VolumeList::new(ViewId::unique(), size, volumes)
    }

    #[test]
    fn a_draw_finds_the_triangles_of_its_volumes_and_no_others() {
        let (geometry, list) = (geometry(), list());
        let switches = Switches::default();
        let program = FillProgram::new(&list.volumes, &switches, Overlap::Disjoint);
        let program = program.expect("allowed");
        let held = Held {
            regions: &geometry.regions,
            stored: &geometry.indices,
            has_strips: true,
            drawn_parts: &DrawnOfMeshes::new(),
        };
        let merged = MergedLists::new(&list, &program, &held);
        let mut draws = 0;
        for step in program.passes.iter().flat_map(FillPass::steps) {
            let FillStep::Volumes(draw) = step else {
                continue;
            };
            draws += 1;
            let ranges = &merged.ranges[draw.volumes][usize::from(draw.without_bottom)];
            let ranges = ranges.as_ref().expect("listed");
            let drawn = |range: &Range<u32>| -> BTreeSet<u32> {
                let range = range.start as usize..range.end as usize;
                let indices = merged.indices[range].iter().copied();
                indices.filter(|&index| index != RESTART).collect()
            };
            let own = draw.volumes.iter().flat_map(|&volume| {
                let slice = &geometry.regions[list.volumes[volume].geometry];
                let first = slice.place.first_vertex;
                first..first + slice.vertex_count
            });
            let own: BTreeSet<u32> = own.collect();
            assert_eq!(drawn(&ranges.walls), own, "{draw:?}");
            assert_eq!(drawn(&ranges.caps), own, "{draw:?}");
        }
        // Two numbers: one for the first and the last, one for the second.
        assert_eq!(draws, 2);
        let parts = merged.top_caps + merged.bottom_caps + merged.walls;
        assert_eq!(parts, merged.indices.len());
        assert_eq!(merged.top_caps, merged.bottom_caps);
        // Negative control: volumes that no step draws together have no ranges.
        assert!(!merged.ranges.contains_key(&[0, 1, 2][..]));
    }

    #[test]
    fn short_lists_keep_restarts_and_whole_words() {
        let mut merged = MergedLists {
            indices: vec![1, 70_000 - 65_536, RESTART],
            ..MergedLists::default()
        };
        let short = merged.bytes(true);
        assert_eq!(short.len(), 8);
        let short: &[u16] = bytemuck::cast_slice(&short);
        assert_eq!(short, [1, 4_464, u16::MAX, 0]);
        let long = merged.bytes(false);
        let long: &[u32] = bytemuck::cast_slice(&long);
        assert_eq!(long, merged.indices);
        merged.indices.push(2);
        assert_eq!(merged.bytes(true).len(), 8);
    }

    #[test]
    fn every_stored_vertex_says_whose_it_is() {
        let variant = VertexVariant {
            switches: Switches {
                merges_draws: true,
                ..Switches::default()
            },
            ..VertexVariant::default()
        };
        let ring = |count: u32| {
            let fan = (1..count - 1).map(|i| [0, i, i + 1]).collect();
            mesh(circle_deg(count, 1.0), fan, vec![(0..count).collect()])
        };
        let meshes = [ring(3), ring(4)];
        let geometry = SceneGeometry::build(&variant, &meshes, |_| true);
        let words: Vec<i32> = geometry.vertices.chunks(4).map(|v| v[3]).collect();
        assert_eq!(words, [[0, 1].repeat(3), [2, 3].repeat(4)].concat());
        // Negative control: drawn one by one, vertices are the same for whichever mesh.
        let each = SceneGeometry::build(&VertexVariant::default(), &meshes, |_| true);
        let words: Vec<i32> = each.vertices.chunks(4).map(|v| v[3]).collect();
        assert_eq!(words, [0, 1].repeat(7));
        // One mesh alone, built to take its old place, keeps its number.
        let again = SceneGeometry::build_from(&variant, &meshes[1..], |_| true, 1);
        assert_eq!(again.vertices, geometry.vertices[4 * 6..]);
    }
}
