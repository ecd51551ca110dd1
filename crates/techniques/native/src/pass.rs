// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes as the passes of a fill draw them: buffers of a scene, and the pipelines that read them.

use crate::NativeVariant;
use crate::extrusion::{Extrusion, VolumePart};
use crate::layout::{RegionSlice, SceneGeometry, words_per_vertex};
use crate::listed::{DrawLists, Wanted};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Feature, FillInput, GeometryBytes};
use terrafill_stencil::{
    DrawnOfMeshes, DrawnParts, FillProgram, HeldMeshes, Holding, IndexBytes, IndexLists, LaidOut,
    RegionVolumes, VolumeBackend, VolumeDraw, VolumeList, VolumePlace, VolumeState,
};
use terrafill_variant::Switches;
use terrafill_vulkan::{
    Buffer, BufferUse, DrawCommand, Geometry, Gpu, IndexWidth, Pipeline, PipelineDescriptor,
    VolumeFill, VolumePass, VulkanVolumes,
};

/// Shadow volumes extruded in geometry shaders, or by `vs-control` in the vertex shader.
pub type NativeBackend = VolumeBackend<NativeVolumes>;

/// Widths of indices, short ones first.
const WIDTHS: [IndexWidth; 2] = [IndexWidth::Short, IndexWidth::Long];

/// Vertices whose numbers a 32-bit float tells apart: geometry shaders know corners by number.
const MAX_VERTICES: usize = 1 << 24;

/// Volumes of a scene, and the pipelines that draw them, made when first asked for.
#[derive(Debug)]
pub struct NativeVolumes {
    variant: NativeVariant,
    pipelines: HashMap<PipelineDescriptor, (Pipeline, Feature)>,
    scene: Option<SceneBuffers>,
    /// Meshes as they were laid out, with their bottoms or without, where views bring them.
    laid_out: LaidOut<bool, SceneGeometry>,
    /// Commands of merged draws, where draws are merged and the device has them.
    lists: Option<DrawLists>,
    /// What the view draws of meshes of which it leaves parts out.
    drawn_parts: DrawnOfMeshes,
}

/// Geometry of every mesh of a scene, in view or not.
#[derive(Debug)]
struct SceneBuffers {
    regions: Vec<RegionSlice>,
    vertices: Buffer,
    /// Indices of 16 and of 32 bits; `None` where no region has such.
    short_indices: Option<Buffer>,
    long_indices: Option<Buffer>,
    /// What the two hold.
    indices: IndexLists,
    bytes: GeometryBytes,
}

impl RegionVolumes for NativeVolumes {
    const TECHNIQUE: &'static str = "native";
    type Executor = VolumeFill;
    type Variant = NativeVariant;

    fn switches(variant: NativeVariant) -> Result<Switches, DeviceError> {
        Ok(variant.switches)
    }

    fn new(fill: &VolumeFill, variant: NativeVariant) -> Result<Self, DeviceError> {
        let gpu = fill.gpu();
        let features = gpu.facts.features;
        let has_stages = features.geometry_shader || !variant.technique.needs_geometry_shader();
        gpu.require(has_stages, "geometryShader")?;
        Ok(Self {
            variant,
            pipelines: HashMap::new(),
            scene: None,
            laid_out: LaidOut::default(),
            lists: (variant.switches.merges_draws && features.draws_listed)
                .then(DrawLists::default),
            drawn_parts: DrawnOfMeshes::new(),
        })
    }

    fn places(&self) -> Option<impl Fn(usize) -> VolumePlace> {
        let scene = self.scene.as_ref()?;
        Some(|mesh: usize| scene.regions[mesh].place)
    }

    fn holdings(&self) -> Vec<Holding> {
        let technique = self.variant.technique;
        let scene = self.scene.iter();
        let geometry = scene.flat_map(|scene| scene.holdings(technique));
        let features = self.pipelines.values().map(|(_, feature)| *feature);
        let lists = self.lists.iter().filter_map(DrawLists::holding);
        let buffers = geometry.chain(lists);
        buffers.chain(Holding::pipelines(features)).collect()
    }

    fn stores_bottom_caps(&self) -> bool {
        !self.variant.technique.needs_geometry_shader()
    }

    fn upload(
        &mut self,
        fill: &VolumeFill,
        input: &FillInput,
        bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        let has_bottom = |mesh| bottoms.has(mesh);
        let (variant, meshes) = (&self.variant, &input.scene.meshes);
        let lay_out = |places: Range<usize>| {
            let first = places.start;
            SceneGeometry::build(variant, &meshes[places], |place| has_bottom(first + place))
        };
        let append = |all: &mut SceneGeometry, part: &_| all.append(variant.technique, part);
        let geometry = self.laid_out.all(meshes, has_bottom, lay_out, append);
        self.upload_geometry(&fill.gpu(), geometry)
    }

    fn upload_view(
        &mut self,
        _fill: &VolumeFill,
        input: &FillInput,
        _bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        let walls = self.variant.wall_indices().filter(|_| self.variant.parts);
        let drawn_parts = walls.map(|walls| DrawnParts::of_view(input, walls));
        let drawn_parts = drawn_parts.unwrap_or_default();
        if self.drawn_parts != drawn_parts {
            self.drawn_parts = drawn_parts;
            if let Some(lists) = &mut self.lists {
                lists.forget();
            }
        }
        Ok(())
    }

    fn rewrite(
        &mut self,
        _fill: &VolumeFill,
        input: &FillInput,
        changed: &[usize],
    ) -> Result<bool, DeviceError> {
        let technique = self.variant.technique;
        let Some(scene) = &mut self.scene else {
            return Ok(false);
        };
        let mut rewritten = Vec::with_capacity(changed.len());
        for &mesh in changed {
            let mesh_alone = std::slice::from_ref(&input.scene.meshes[mesh]);
            let has_bottom = scene.regions[mesh].has_bottom;
            let geometry = SceneGeometry::build(&self.variant, mesh_alone, |_| has_bottom);
            let Some(slice) = scene.regions[mesh].replaced_by(&geometry.regions[0]) else {
                return Ok(false);
            };
            rewritten.push((mesh, slice, geometry));
        }
        let vertex_bytes = 4 * words_per_vertex(technique) as u64;
        let mut vertices: Vec<(u64, &[u8])> = Vec::new();
        let (mut short, mut long) = (vertices.clone(), vertices.clone());
        for (mesh, slice, geometry) in &rewritten {
            let first_byte = u64::from(slice.place.first_vertex) * vertex_bytes;
            vertices.push((first_byte, bytemuck::cast_slice(&geometry.vertices)));
            let (first, indices) = (slice.place.first_triangle_index as usize, &geometry.indices);
            // Where triangles stay as they are, so do their indices.
            if replace(&mut scene.indices.short, first, &indices.short) {
                short.push((2 * first as u64, bytemuck::cast_slice(&indices.short)));
            }
            if replace(&mut scene.indices.long, first, &indices.long) {
                long.push((4 * first as u64, bytemuck::cast_slice(&indices.long)));
            }
            scene.regions[*mesh] = *slice;
        }
        scene.vertices.rewrite_parts(&vertices)?;
        for (buffer, parts) in [(&scene.short_indices, short), (&scene.long_indices, long)] {
            if let Some(buffer) = buffer {
                buffer.rewrite_parts(&parts)?;
            }
        }
        Ok(true)
    }
}

impl NativeVolumes {
    pub(crate) fn upload_geometry(
        &mut self,
        gpu: &Arc<Gpu>,
        geometry: SceneGeometry,
    ) -> Result<(), DeviceError> {
        let technique = self.variant.technique;
        check_numbers(technique, geometry.vertex_count(technique))?;
        let bytes = geometry.bytes();
        let upload =
            |label: &str, bytes: &[u8], use_for| Buffer::upload(gpu, label, bytes, use_for);
        let indices = |label: &str, bytes: &[u8]| {
            let held = (!bytes.is_empty()).then(|| upload(label, bytes, BufferUse::Index));
            held.transpose()
        };
        if let Some(lists) = &mut self.lists {
            lists.forget();
        }
        self.scene = Some(SceneBuffers {
            vertices: upload(
                "volume vertices",
                bytemuck::cast_slice(&geometry.vertices),
                BufferUse::Vertex,
            )?,
            short_indices: indices(
                "16-bit indices",
                bytemuck::cast_slice(&geometry.indices.short),
            )?,
            long_indices: indices(
                "32-bit indices",
                bytemuck::cast_slice(&geometry.indices.long),
            )?,
            regions: geometry.regions,
            indices: geometry.indices,
            bytes,
        });
        Ok(())
    }

    /// What draws of a part of a region read.
    ///
    /// - `mesh`: its number
    fn indices_of(
        &self,
        slice: &RegionSlice,
        mesh: usize,
        part: VolumePart,
        without_bottom: bool,
    ) -> Vec<Range<u32>> {
        let is_control = self.variant.technique == Extrusion::VsControl;
        // The bottom's triangles are the second half; geometry shaders leave theirs out.
        let halves = if is_control && slice.has_bottom { 2 } else { 1 };
        let cap = slice.index_count / halves;
        let has_second = halves == 2 && !without_bottom;
        let parts = self.drawn_parts.get(&mesh);
        let (first, whole) = match part {
            VolumePart::Walls => (slice.place.first_loop_index, slice.wall_index_count),
            VolumePart::Caps if !has_second => (slice.place.first_triangle_index, cap),
            VolumePart::Caps | VolumePart::Whole | VolumePart::Turned => {
                (slice.place.first_triangle_index, slice.index_count)
            }
        };
        let ranges = match (part, parts) {
            (VolumePart::Walls, Some(parts)) => parts.walls.clone(),
            (VolumePart::Caps, Some(parts)) => parts.both_caps(cap, has_second),
            _ => std::iter::once(0..whole).collect(),
        };
        let moved = ranges.into_iter();
        moved
            .map(|range| first + range.start..first + range.end)
            .collect()
    }

    /// The pipelines that draw volumes in one state.
    fn pipelines_of(
        &self,
        state: VolumeState,
        without_bottom: bool,
    ) -> impl Iterator<Item = (VolumePart, PipelineDescriptor)> + use<> {
        let variant = self.variant;
        variant.technique.parts().iter().map(move |&part| {
            let technique = variant.technique;
            let mut pipeline =
                technique.volume_pipeline(part, variant.indices(), state, without_bottom);
            pipeline.vertex.bends_footprints = variant.switches.bends_footprints;
            (part, pipeline)
        })
    }
}

impl SceneBuffers {
    fn slice(&self, list: &VolumeList, volume: usize) -> &RegionSlice {
        &self.regions[list.volumes[volume].geometry]
    }

    fn width(&self, list: &VolumeList, volume: usize) -> IndexWidth {
        if self.slice(list, volume).place.has_short_indices {
            IndexWidth::Short
        } else {
            IndexWidth::Long
        }
    }

    /// `None` where no region has indices of this width.
    fn geometry(&self, width: IndexWidth) -> Option<Geometry<'_>> {
        let indices = match width {
            IndexWidth::Short => &self.short_indices,
            IndexWidth::Long => &self.long_indices,
        };
        Some(Geometry {
            vertices: &self.vertices,
            indices: indices.as_ref()?,
            width,
        })
    }

    /// Bytes of its buffers by what they are for. One list makes tops, bottoms and walls in a geometry
    /// shader; it counts as that of the tops.
    fn holdings(&self, technique: Extrusion) -> Vec<Holding> {
        let mut bytes = IndexBytes::default();
        for slice in &self.regions {
            let index_size = if slice.place.has_short_indices { 2 } else { 4 };
            let caps = u64::from(slice.index_count) * index_size;
            bytes.walls += u64::from(slice.wall_index_count) * index_size;
            match (technique.needs_geometry_shader(), slice.has_bottom) {
                (true, _) => bytes.top_caps += caps,
                (false, true) => {
                    bytes.top_caps += caps / 2;
                    bytes.bottom_caps += caps / 2;
                }
                (false, false) => {
                    bytes.top_caps += caps;
                    bytes.spared += caps;
                }
            }
        }
        let vertices = [self.vertices.size()];
        let positions = Holding::vertices(Feature::Positions, self.bytes.vertex_bytes, &vertices);
        let indices = [&self.short_indices, &self.long_indices]
            .into_iter()
            .flatten();
        let indices: Vec<u64> = indices.map(Buffer::size).collect();
        std::iter::once(positions)
            .chain(bytes.holdings(&indices))
            .collect()
    }
}

impl VulkanVolumes for NativeVolumes {
    fn ensure(&mut self, gpu: &Arc<Gpu>, draw: &VolumeDraw<'_>) -> Result<(), DeviceError> {
        for (_, descriptor) in self.pipelines_of(draw.state, draw.without_bottom) {
            if let Entry::Vacant(place) = self.pipelines.entry(descriptor) {
                let feature = draw.state.feature();
                place.insert((Pipeline::new(gpu, descriptor)?, feature));
            }
        }
        Ok(())
    }

    fn merge(
        &mut self,
        gpu: &Arc<Gpu>,
        list: &VolumeList,
        program: &FillProgram,
    ) -> Result<(), DeviceError> {
        let (Some(mut lists), Some(scene)) = (self.lists.take(), &self.scene) else {
            return Ok(());
        };
        let command = |wanted: Wanted| {
            let slice = scene.slice(list, wanted.volume);
            let is_of_width = scene.width(list, wanted.volume) == wanted.width;
            let mesh = list.volumes[wanted.volume].geometry;
            let ranges = self.indices_of(slice, mesh, wanted.part, wanted.without_bottom);
            let command = |indices: Range<u32>| DrawCommand {
                index_count: indices.end - indices.start,
                first_index: indices.start,
                vertex_offset: i32::try_from(slice.place.first_vertex).unwrap_or(i32::MAX),
                first_instance: u32::try_from(wanted.volume).unwrap_or(u32::MAX),
                ..DrawCommand::ONE
            };
            let own = ranges.into_iter().filter(|_| is_of_width);
            own.map(command).collect()
        };
        let parts = self.variant.technique.parts();
        let loaded = lists.load(gpu, (list, program), parts, command);
        self.lists = Some(lists);
        loaded
    }

    fn draw<'a>(&'a self, pass: &mut VolumePass<'a, '_, '_>, draw: &VolumeDraw<'_>) {
        let Some(scene) = &self.scene else {
            return;
        };
        let list = pass.list;
        for width in WIDTHS {
            let Some(geometry) = scene.geometry(width) else {
                continue;
            };
            for (part, key) in self.pipelines_of(draw.state, draw.without_bottom) {
                let Some((pipeline, _)) = self.pipelines.get(&key) else {
                    continue;
                };
                if let Some(lists) = &self.lists {
                    if let Some((buffer, listed)) = lists.find(draw, part, width) {
                        pass.cut(0, false);
                        let commands = (listed.commands.clone(), listed.vertices);
                        pass.draw_listed(pipeline, geometry, buffer, commands);
                    }
                    continue;
                }
                let drawn = draw.volumes.iter().copied();
                for volume in drawn.filter(|&volume| scene.width(list, volume) == width) {
                    pass.cut(volume, draw.scissor);
                    let slice = scene.slice(list, volume);
                    let mesh = list.volumes[volume].geometry;
                    let base_vertex = i32::try_from(slice.place.first_vertex).unwrap_or(i32::MAX);
                    for indices in self.indices_of(slice, mesh, part, draw.without_bottom) {
                        pass.draw_indexed(pipeline, geometry, indices, base_vertex, volume);
                    }
                }
            }
        }
    }
}

/// Writes a part of a list; whether that changes it.
fn replace<T: Copy + PartialEq>(list: &mut [T], first: usize, part: &[T]) -> bool {
    if part.is_empty() {
        // Of the other width, where `first` counts in another list.
        return false;
    }
    let held = &mut list[first..][..part.len()];
    let differs = held != part;
    held.copy_from_slice(part);
    differs
}

/// Whether every vertex has a number of its own in the geometry shader.
fn check_numbers(technique: Extrusion, vertices: usize) -> Result<(), DeviceError> {
    if !technique.needs_geometry_shader() {
        return Ok(());
    }
    let what = "vertices that geometry shaders tell apart";
    DeviceError::check_capacity(what, vertices as u64, MAX_VERTICES as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Indices, strip_counts};
    use terrafill_contract::{FillBackend as _, PreparedScene};
    use terrafill_core::RegionMesh;
    use terrafill_plan::PlanOptions;
    use terrafill_scene::{ImageSize, Scene};
    use terrafill_surface::{EllipsoidKind, open_surface};
    use terrafill_variant::ColourWay;
    use terrafill_vulkan::Measured;

    #[test]
    fn vertices_whose_numbers_a_float_would_round_are_refused() {
        let all = Extrusion::ALL.into_iter();
        for technique in all.filter(|technique| technique.needs_geometry_shader()) {
            assert!(check_numbers(technique, MAX_VERTICES).is_ok());
            let error = check_numbers(technique, MAX_VERTICES + 1).expect_err("one more");
            assert!(error.to_string().contains("16777217"), "{error}");
        }
        assert!(check_numbers(Extrusion::VsControl, MAX_VERTICES + 1).is_ok());
        // The largest number is one less than the count, and the next float up from it is the next.
        let largest = (MAX_VERTICES - 1) as f32;
        assert_eq!(largest.next_up(), MAX_VERTICES as f32);
    }
    /// California from the side: from above, walls turned against caps are hardly seen.
    fn california() -> FillInput {
        let scene = Scene::shipped("california", None).expect("it ships");
        let meshes =
            RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh);
        let surface = open_surface(&[&EllipsoidKind], &scene).expect("a surface");
        let prepared = PreparedScene::new(&scene, meshes.expect("meshes").into(), surface);
        let mut views = scene.views.iter();
        let view = views.find(|view| view.name == "horizon").expect("a view");
        let size = ImageSize::new(256, 256);
        FillInput::new(&prepared, view, size, PlanOptions::default()).expect("a surface")
    }

    /// Takes the strips of the only region apart and puts them together again, changed.
    fn change_strips(geometry: &mut SceneGeometry, change: impl FnOnce(&mut Vec<Vec<u16>>)) {
        let indices = std::mem::take(&mut geometry.indices.short);
        let strips = indices.split(|&index| index == u16::MAX);
        let mut strips: Vec<Vec<u16>> = strips.map(<[u16]>::to_vec).collect();
        change(&mut strips);
        geometry.indices.short = strips.join(&u16::MAX);
        let region = geometry.regions.first_mut().expect("one region");
        region.index_count = geometry.indices.count(true);
    }

    /// Of whole strips a device makes what it makes of lists, and of broken ones it does not.
    #[test]
    fn broken_strips_are_seen() {
        let Some(gpu) = terrafill_vulkan::open_for_test(&Default::default()) else {
            return;
        };
        // Regions that are counted: to bits that flip, all faces are alike.
        let switches = Switches {
            colour: ColourWay::Rectangle,
            ..Switches::default()
        };
        let input = california();
        let targets =
            terrafill_vulkan::RenderTargets::shared(&gpu, input.size).expect("small targets");
        // How many indices stand for a corner.
        for (technique, step) in [(Extrusion::GsDegenerate, 1), (Extrusion::GsAdjacency, 2)] {
            let drawn = |indices, change: &dyn Fn(&mut SceneGeometry)| {
                let variant = NativeVariant {
                    technique,
                    indices: Some(indices),
                    parts: false,
                    switches,
                };
                let mut backend = NativeBackend::new(&targets, variant).expect("has the features");
                backend.prepare(&input).expect("fits");
                let mut geometry = SceneGeometry::build(&variant, &input.scene.meshes, |_| true);
                change(&mut geometry);
                let uploaded = backend.volumes_mut().upload_geometry(&gpu, geometry);
                uploaded.expect("fits");
                backend.render(&input).expect("draws").ids
            };
            let list = drawn(Indices::List, &|_| {});
            let filled = list.iter().filter(|id| **id > 0).count();
            assert!(filled > 1000, "{filled}");
            let differing = |change: &dyn Fn(&mut Vec<Vec<u16>>)| {
                let ids = drawn(Indices::Strip, &|geometry| change_strips(geometry, change));
                let both = ids.iter().zip(&list);
                both.filter(|(found, expected)| found != expected).count()
            };
            let name = technique.name();
            assert_eq!(differing(&|_| {}), 0, "{name}");
            let turned_over = differing(&|strips| {
                for strip in strips.iter_mut().filter(|strip| !strip.is_empty()) {
                    strip.splice(0..0, strip[..step].to_vec());
                }
            });
            assert!(turned_over > 100, "{name}, parity: {turned_over}");
            let joined = differing(&|strips| *strips = vec![strips.concat()]);
            assert!(joined > 100, "{name}, restarts missing: {joined}");
            if technique == Extrusion::GsAdjacency {
                let swapped = differing(&|strips| {
                    for strip in strips.iter_mut().filter(|strip| !strip.is_empty()) {
                        strip.swap(1, 3);
                    }
                });
                assert!(swapped > 100, "neighbours swapped: {swapped}");
            }
        }
    }

    /// A device that took a restart for a vertex, or turned a strip otherwise, would be given more.
    #[test]
    fn geometry_shaders_are_given_what_the_strips_hold() {
        let Some(gpu) = terrafill_vulkan::open_for_test(&Default::default()) else {
            return;
        };
        if !gpu.facts.features.pipeline_statistics {
            eprintln!("skipped: no pipeline statistics");
            return;
        }
        let input = california();
        let mesh = &input.scene.meshes[0];
        let (triangles, edges) = (mesh.triangle_count(), mesh.boundary_edge_count());
        let in_strips = triangles + strip_counts(mesh).repeated;
        let between = edges - mesh.boundary_loops.len();
        let targets =
            terrafill_vulkan::RenderTargets::shared(&gpu, input.size).expect("small targets");
        let (list, strip) = (Indices::List, Indices::Strip);
        for (technique, indices, expected) in [
            (Extrusion::GsDegenerate, list, triangles + edges),
            (Extrusion::GsDegenerate, strip, in_strips + edges + between),
            (Extrusion::GsAdjacency, list, triangles),
            (Extrusion::GsAdjacency, strip, in_strips),
        ] {
            let variant = NativeVariant {
                technique,
                indices: Some(indices),
                ..NativeVariant::default()
            };
            let mut backend = NativeBackend::new(&targets, variant).expect("has the features");
            backend.prepare(&input).expect("fits");
            backend.render(&input).expect("draws");
            let statistics = Measured::Statistics;
            let measured = backend.executor().measure(backend.volumes(), statistics);
            let (report, _) = measured.expect("draws");
            let given = report.statistics.expect("has the feature");
            let what = (technique.name(), indices.name());
            let found = given.geometry_shader_invocations;
            assert_eq!(found, Some(expected as u64), "{what:?}");
            let made = 2 * (triangles + edges) as u64;
            assert_eq!(given.geometry_shader_primitives, Some(made), "{what:?}");
        }
        // Negative control: some corners are said again, and some edges are not the first of their loop.
        assert!(in_strips > triangles && between > 0);
    }
}
