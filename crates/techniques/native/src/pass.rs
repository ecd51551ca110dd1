// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes as the passes of a fill draw them: buffers of a scene, and the pipelines that read them.

use crate::extrusion::{Extrusion, Part};
use crate::layout::{RegionSlice, SceneGeometry, words_per_vertex};
use crate::{NativeVariant, depth_range};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use terrafill_core::RegionMesh;
use terrafill_fill::{DeviceError, FillInput, GeometryBytes, RegionPlace, VolumeDraw, VolumeState};
use terrafill_vulkan::{
    Buffer, BufferUse, Geometry, Gpu, IndexWidth, Pipeline, PipelineDescriptor, VolumePass, Volumes,
};

/// Widths of indices, short ones first.
const WIDTHS: [IndexWidth; 2] = [IndexWidth::Short, IndexWidth::Long];

/// Vertices whose numbers a 32-bit float tells apart: geometry shaders know corners by number.
const MAX_VERTICES: usize = 1 << 24;

/// Volumes of a scene, and the pipelines that draw them, made when first asked for.
#[derive(Debug)]
pub(crate) struct NativeVolumes {
    variant: NativeVariant,
    pipelines: HashMap<PipelineDescriptor, Pipeline>,
    scene: Option<SceneBuffers>,
}

/// Geometry of every mesh of a scene, in view or not.
#[derive(Debug)]
struct SceneBuffers {
    regions: Vec<RegionSlice>,
    vertices: Buffer,
    short_indices: Buffer,
    long_indices: Buffer,
    bytes: GeometryBytes,
}

impl NativeVolumes {
    pub(crate) fn new(variant: NativeVariant) -> Self {
        Self {
            variant,
            pipelines: HashMap::new(),
            scene: None,
        }
    }

    /// Bytes of the geometry, and how many buffers hold it.
    pub(crate) fn memory(&self) -> (GeometryBytes, u64) {
        // Vertices, and indices of both widths.
        let scene = self.scene.as_ref();
        scene.map_or_else(Default::default, |scene| (scene.bytes, 3))
    }

    /// Where a mesh lies; `None` before anything is uploaded.
    pub(crate) fn places(&self) -> Option<impl Fn(usize) -> RegionPlace> {
        let scene = self.scene.as_ref()?;
        Some(|mesh: usize| scene.regions[mesh].place())
    }

    pub(crate) fn upload(
        &mut self,
        gpu: &Arc<Gpu>,
        meshes: &[RegionMesh],
    ) -> Result<(), DeviceError> {
        let (technique, indices) = (self.variant.technique, self.variant.indices());
        self.upload_geometry(gpu, SceneGeometry::build(technique, indices, meshes))
    }

    /// Writes the geometry of the changed meshes over what they were. False, with nothing written,
    /// where one of them does not fit into its old place.
    pub(crate) fn rewrite(
        &mut self,
        meshes: &[RegionMesh],
        changed: &[usize],
    ) -> Result<bool, DeviceError> {
        let (technique, indices) = (self.variant.technique, self.variant.indices());
        let Some(scene) = &mut self.scene else {
            return Ok(false);
        };
        let mut rewritten = Vec::with_capacity(changed.len());
        for &mesh in changed {
            let mesh_alone = std::slice::from_ref(&meshes[mesh]);
            let geometry = SceneGeometry::build(technique, indices, mesh_alone);
            let Some(slice) = scene.regions[mesh].replaced_by(&geometry.regions[0]) else {
                return Ok(false);
            };
            rewritten.push((mesh, slice, geometry));
        }
        for (mesh, slice, geometry) in rewritten {
            let vertex_bytes = 4 * words_per_vertex(technique) as u64;
            let first_byte = u64::from(slice.first_vertex) * vertex_bytes;
            let vertices = bytemuck::cast_slice(&geometry.vertices);
            scene.vertices.rewrite_part(first_byte, vertices)?;
            let first_index = u64::from(slice.first_index);
            let short = bytemuck::cast_slice(&geometry.indices.short);
            scene.short_indices.rewrite_part(2 * first_index, short)?;
            let long = bytemuck::cast_slice(&geometry.indices.long);
            scene.long_indices.rewrite_part(4 * first_index, long)?;
            scene.regions[mesh] = slice;
        }
        Ok(true)
    }

    pub(crate) fn upload_geometry(
        &mut self,
        gpu: &Arc<Gpu>,
        geometry: SceneGeometry,
    ) -> Result<(), DeviceError> {
        let technique = self.variant.technique;
        check_numbers(technique, geometry.vertex_count(technique))?;
        let bytes = geometry.bytes();
        let upload = |label, bytes, use_for| Buffer::upload(gpu, label, bytes, use_for);
        self.scene = Some(SceneBuffers {
            vertices: upload(
                "volume vertices",
                bytemuck::cast_slice(&geometry.vertices),
                BufferUse::Vertex,
            )?,
            short_indices: upload(
                "16-bit indices",
                bytemuck::cast_slice(&geometry.indices.short),
                BufferUse::Index,
            )?,
            long_indices: upload(
                "32-bit indices",
                bytemuck::cast_slice(&geometry.indices.long),
                BufferUse::Index,
            )?,
            regions: geometry.regions,
            bytes,
        });
        Ok(())
    }

    /// The pipelines that draw volumes in one state.
    fn pipelines_of(
        &self,
        state: VolumeState,
        without_bottom: bool,
    ) -> impl Iterator<Item = (Part, PipelineDescriptor)> + use<> {
        let variant = self.variant;
        variant.technique.parts().iter().map(move |&part| {
            let (indices, depth_bounds) = (variant.indices(), variant.switches.depth_bounds);
            let technique = variant.technique;
            let pipeline =
                technique.volume_pipeline(part, indices, state, without_bottom, depth_bounds);
            (part, pipeline)
        })
    }
}

impl SceneBuffers {
    fn slice(&self, input: &FillInput, planned: usize) -> &RegionSlice {
        &self.regions[input.plan.regions[planned].mesh]
    }

    fn width(&self, input: &FillInput, planned: usize) -> IndexWidth {
        if self.slice(input, planned).short_indices {
            IndexWidth::Short
        } else {
            IndexWidth::Long
        }
    }

    fn geometry(&self, width: IndexWidth) -> Geometry<'_> {
        Geometry {
            vertices: &self.vertices,
            indices: match width {
                IndexWidth::Short => &self.short_indices,
                IndexWidth::Long => &self.long_indices,
            },
            width,
        }
    }
}

impl Volumes for NativeVolumes {
    fn ensure(&mut self, gpu: &Arc<Gpu>, draw: &VolumeDraw<'_>) -> Result<(), DeviceError> {
        for (_, descriptor) in self.pipelines_of(draw.state, draw.without_bottom) {
            if let Entry::Vacant(place) = self.pipelines.entry(descriptor) {
                place.insert(Pipeline::new(gpu, descriptor)?);
            }
        }
        Ok(())
    }

    fn draw<'a>(&'a self, pass: &mut VolumePass<'a, '_, '_>, draw: &VolumeDraw<'_>) {
        let Some(scene) = &self.scene else {
            return;
        };
        let input = pass.input;
        for width in WIDTHS {
            for (part, key) in self.pipelines_of(draw.state, draw.without_bottom) {
                let Some(pipeline) = self.pipelines.get(&key) else {
                    continue;
                };
                let drawn = draw.regions.iter().copied();
                for planned in drawn.filter(|&planned| scene.width(input, planned) == width) {
                    pass.cut(planned, draw.scissor);
                    if key.depth_bounds {
                        let range = depth_range(input, &input.plan.regions[planned]);
                        pass.depth_bounds(range.low, range.high);
                    }
                    let slice = scene.slice(input, planned);
                    let (first, count) = match part {
                        Part::Walls => (slice.first_wall_index, slice.wall_index_count),
                        // The bottom's triangles are the second half; geometry shaders leave
                        // theirs out.
                        Part::Caps
                            if draw.without_bottom
                                && self.variant.technique == Extrusion::VsControl =>
                        {
                            (slice.first_index, slice.index_count / 2)
                        }
                        Part::Caps | Part::Whole | Part::Turned => {
                            (slice.first_index, slice.index_count)
                        }
                    };
                    let base_vertex = i32::try_from(slice.first_vertex).unwrap_or(i32::MAX);
                    let geometry = scene.geometry(width);
                    let indices = first..first + count;
                    pass.draw_indexed(pipeline, geometry, indices, base_vertex, planned);
                }
            }
        }
    }
}

/// Whether every vertex has a number of its own in the geometry shader.
fn check_numbers(technique: Extrusion, vertices: usize) -> Result<(), DeviceError> {
    if vertices <= MAX_VERTICES || !technique.needs_geometry_shader() {
        return Ok(());
    }
    Err(DeviceError::OverCapacity {
        what: "vertices that geometry shaders tell apart".to_owned(),
        found: vertices as u64,
        allowed: MAX_VERTICES as u64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
