// SPDX-License-Identifier: MIT OR Apache-2.0
//! The stages that divide patches into cells, on Vulkan, which has all of them.

use crate::draws::count;
use crate::on_vulkan::{Call, OnVulkan, numbered, uniform, wgsl};
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_scene::ImageSize;
use terrafill_shapes::mesh::MeshConstants;
use terrafill_shapes::patch::Patch;
use terrafill_shapes::pot::pot_view;
use terrafill_vulkan::{
    Buffer, BufferUse, ComputePipeline, DrawPipeline, GeometryOutput, Gpu, PrimitiveStages,
    Resource, Resources, Topology,
};

const BEZIER: &str = "pipelines/bezier.wgsl";
/// Most cells a side of a patch that one invocation of a geometry shader makes within 128 vertices.
pub(crate) const MAX_PATCH_CELLS: u32 = 7;
/// Vertices that the geometry shaders declare, of a patch and of a row of one.
const DECLARED: [u32; 2] = [112, 22];
/// Of a vertex: a position, and a number, whose location counts as a whole of four.
const COMPONENTS: u32 = 8;
/// Invocations of a workgroup of `bezier_place.wgsl`.
const GROUP: u32 = 64;
const CLIP_BYTES: u64 = 16;

terrafill_results::named! {
    /// Which stage divides patches.
    all pub(crate) enum Division {
        /// The vertex shader places six vertices a cell by their numbers.
        NoBuffer = "no-vertex-buffer",
        /// An invocation of a geometry shader a patch, as published.
        Patch = "geometry-patch",
        /// An invocation of a geometry shader a row of a patch.
        Row = "geometry-row",
        /// Compute places every vertex once.
        Placed = "compute-buffer",
        /// The stages that are made for it.
        Tessellation = "tessellation",
    }
}

impl Division {
    /// Whether pictures show cells, not halves of them.
    pub(crate) fn shows_cells(self) -> bool {
        self == Self::Tessellation
    }

    /// Vertices that the last stage before rasterisation gives, by the way's definition; of tessellation each of a
    /// patch's once.
    pub(crate) fn emitted_vertices(self, patches: u32, cells: u32) -> u64 {
        let [patches, cells] = [patches, cells].map(u64::from);
        patches
            * match self {
                Self::NoBuffer | Self::Placed => 6 * cells * cells,
                Self::Patch | Self::Row => 2 * cells * (cells + 1),
                Self::Tessellation => (cells + 1).pow(2),
            }
    }

    /// Everything that the device holds for it, bytes.
    pub(crate) fn held_bytes(self, patches: u32, cells: u32) -> u64 {
        let control = u64::from(patches) * size_of::<[[f32; 4]; 16]>() as u64;
        match self {
            Self::Placed => control + vertices(patches, cells) * CLIP_BYTES,
            _ => control,
        }
    }

    /// Opens it.
    pub(crate) fn open(
        self,
        gpu: &Arc<Gpu>,
        patches: &[Patch],
        cells: u32,
        size: ImageSize,
    ) -> Result<OnVulkan, DeviceError> {
        if self == Self::Patch {
            let what = "cells a side of a patch in 128 vertices of a geometry shader";
            DeviceError::check_capacity(what, cells, MAX_PATCH_CELLS)?;
        }
        let constants = MeshConstants::new(&pot_view(), cells);
        let control: Vec<[f32; 4]> = patches.iter().flat_map(Patch::sent).collect();
        let control = bytemuck::cast_slice(&control);
        let control = Buffer::upload(gpu, "control points", control, BufferUse::Storage)?;
        let mut resources = vec![
            uniform(gpu, "mesh constants", bytemuck::bytes_of(&constants))?,
            Resource::Storage(Arc::new(control)),
        ];
        let patches = count(patches);
        let placed = vertices(patches, cells);
        if self == Self::Placed {
            let bytes = placed * CLIP_BYTES;
            let kept = Buffer::unwritten(gpu, "placed vertices", bytes, BufferUse::Storage)?;
            resources.push(Resource::Storage(Arc::new(kept)));
        }
        let resources = Resources::new(gpu, resources)?;
        let fragment = if self.shows_cells() {
            "cell_main"
        } else {
            "fragment_main"
        };
        let fragment = wgsl(BEZIER, fragment);
        let pipeline = DrawPipeline::new(gpu, &resources, self.stages(), fragment)?;
        let drawn = |vertices: u32| std::iter::once(0..vertices).collect();
        let corners = 6 * cells * cells * patches;
        let call = match self {
            Self::NoBuffer => Call::Ranges(drawn(corners)),
            Self::Placed => {
                let shader = wgsl("pipelines/bezier_place.wgsl", "compute_main");
                let compute = ComputePipeline::new(gpu, &resources, shader)?;
                let groups = u32::try_from(placed).unwrap_or(u32::MAX).div_ceil(GROUP);
                Call::Placed(drawn(corners), compute, groups)
            }
            Self::Row => Call::Ranges(drawn(patches * cells)),
            Self::Patch | Self::Tessellation => Call::Ranges(drawn(patches)),
        };
        OnVulkan::with(gpu, pipeline, call, size)
    }

    fn stages(self) -> PrimitiveStages {
        let vertex = |entry_point| wgsl(BEZIER, entry_point);
        let geometry = |name, vertices| {
            let output = GeometryOutput {
                name,
                vertices,
                components: COMPONENTS,
            };
            numbered(vertex("numbered"), Some(output), Topology::Points)
        };
        match self {
            Self::NoBuffer => numbered(vertex("no_buffer"), None, Topology::Triangles),
            Self::Placed => numbered(vertex("placed_before"), None, Topology::Triangles),
            Self::Patch => geometry("native/bezier.patch.spv", DECLARED[0]),
            Self::Row => geometry("native/bezier.row.spv", DECLARED[1]),
            Self::Tessellation => PrimitiveStages::Divided {
                vertex: vertex("numbered"),
                control: "native/bezier.tesc.spv",
                evaluation: "native/bezier.tese.spv",
            },
        }
    }
}

/// Vertices of all patches, those on a side of two counted twice.
fn vertices(patches: u32, cells: u32) -> u64 {
    u64::from(patches) * u64::from(cells + 1).pow(2)
}
