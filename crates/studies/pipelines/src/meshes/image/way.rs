// SPDX-License-Identifier: MIT OR Apache-2.0
//! The stages that make triangles of a geometry image, on Vulkan, which has all of them.

use crate::on_vulkan::{Call, OnVulkan, numbered, uniform, wgsl};
use crate::way::MESH_CELLS;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_scene::ImageSize;
use terrafill_shapes::mesh::{Mesh, MeshConstants};
use terrafill_shapes::rabbit::rabbit_view;
use terrafill_shapes::square::CellCut;
use terrafill_stencil::{RouteTexelFormat, RouteTexels};
use terrafill_vulkan::{
    Buffer, BufferUse, ComputePipeline, DrawPipeline, GeometryOutput, Gpu, PrimitiveStages,
    Resource, Resources, SampledImage, Shader, Topology,
};

const IMAGE: &str = "pipelines/image.wgsl";
/// Of a vertex: a position, and a number, whose location counts as a whole of four.
const COMPONENTS: u32 = 8;
/// Invocations of a workgroup of `image_place.wgsl`.
const GROUP: u32 = 64;
/// Bytes of a texel, of a placed vertex and of an index.
const TEXEL_BYTES: u64 = 16;
const CLIP_BYTES: u64 = 16;
const INDEX_BYTES: u64 = 4;

terrafill_results::named! {
    /// Which stage makes triangles, or points.
    all pub(crate) enum ImageWay {
        /// Points, whose vertex shader fetches their texel, as published.
        Points = "fetched-points",
        /// A geometry shader makes the cell of each texel, as published.
        Geometry = "geometry-shader",
        /// The vertex shader fetches six texels a cell by their numbers.
        NoBuffer = "no-vertex-buffer",
        /// Indices of all triangles, whose vertex shader fetches.
        Indexed = "indexed",
        /// Compute places every vertex once.
        Placed = "compute-buffer",
        /// A mesh shader makes 8 × 8 cells.
        Mesh = "mesh-shader",
    }
}

impl ImageWay {
    /// Primitives of a frame.
    pub(crate) fn primitives(self, cells: u32) -> u64 {
        match self {
            Self::Points => u64::from(cells + 1).pow(2),
            _ => 2 * u64::from(cells).pow(2),
        }
    }

    /// Vertices that the last stage before rasterisation gives, by the way's definition; of indices each once.
    pub(crate) fn emitted_vertices(self, cells: u32) -> u64 {
        let of_cells = u64::from(cells).pow(2);
        match self {
            Self::Points | Self::Indexed => u64::from(cells + 1).pow(2),
            Self::Geometry => 4 * of_cells,
            Self::NoBuffer | Self::Placed => 6 * of_cells,
            Self::Mesh => {
                of_cells / u64::from(MESH_CELLS).pow(2) * u64::from(MESH_CELLS + 1).pow(2)
            }
        }
    }

    /// Everything that the device holds for it, bytes.
    pub(crate) fn held_bytes(self, cells: u32) -> u64 {
        let texels = u64::from(cells + 1).pow(2);
        let own = match self {
            Self::Placed => texels * CLIP_BYTES,
            Self::Indexed => 3 * self.primitives(cells) * INDEX_BYTES,
            _ => 0,
        };
        texels * TEXEL_BYTES + own
    }

    /// Opens it.
    pub(crate) fn open(
        self,
        gpu: &Arc<Gpu>,
        mesh: &Mesh,
        (cells, cut): (u32, CellCut),
        size: ImageSize,
    ) -> Result<OnVulkan, DeviceError> {
        let is_folded = cut == CellCut::Fold;
        let cuts_freely = matches!(
            self,
            Self::Points | Self::NoBuffer | Self::Indexed | Self::Placed
        );
        gpu.require(cuts_freely || !is_folded, "a strip cut along folds")?;
        let constants = MeshConstants::new(&rabbit_view(), cells).folded(is_folded);
        let mut resources = vec![
            uniform(gpu, "mesh constants", bytemuck::bytes_of(&constants))?,
            Resource::Image(places(gpu, mesh, cells)?),
        ];
        let texels = (cells + 1).pow(2);
        if self == Self::Placed {
            let bytes = u64::from(texels) * CLIP_BYTES;
            let kept = Buffer::unwritten(gpu, "placed vertices", bytes, BufferUse::Storage)?;
            resources.push(Resource::Storage(Arc::new(kept)));
        }
        let resources = Resources::new(gpu, resources)?;
        let (stages, fragment) = self.stages();
        let pipeline = DrawPipeline::new(gpu, &resources, stages, fragment)?;
        let drawn = |vertices: u32| std::iter::once(0..vertices).collect();
        let call = match self {
            Self::Points => Call::Ranges(drawn(texels)),
            Self::Geometry => Call::Ranges(drawn(cells * cells)),
            Self::NoBuffer => Call::Ranges(drawn(6 * cells * cells)),
            Self::Indexed => Call::indexed(gpu, &mesh.triangles, 1)?,
            Self::Placed => {
                let shader = wgsl("pipelines/image_place.wgsl", "compute_main");
                let compute = ComputePipeline::new(gpu, &resources, shader)?;
                Call::Placed(drawn(6 * cells * cells), compute, texels.div_ceil(GROUP))
            }
            Self::Mesh => Call::Groups(cells / MESH_CELLS),
        };
        OnVulkan::with(gpu, pipeline, call, size)
    }

    fn stages(self) -> (PrimitiveStages, Shader) {
        let vertex = |entry_point, topology| numbered(wgsl(IMAGE, entry_point), None, topology);
        let stages = match self {
            Self::Points => vertex("fetched", Topology::Points),
            Self::Indexed => vertex("indexed", Topology::Triangles),
            Self::NoBuffer => vertex("no_buffer", Topology::Triangles),
            Self::Placed => vertex("placed_before", Topology::Triangles),
            Self::Geometry => {
                let output = GeometryOutput {
                    name: "native/image.cell1.spv",
                    vertices: 4,
                    components: COMPONENTS,
                };
                numbered(wgsl(IMAGE, "numbered"), Some(output), Topology::Points)
            }
            Self::Mesh => PrimitiveStages::Mesh {
                task: None,
                mesh: "native/image.mesh.spv",
            },
        };
        let fragment = match self {
            Self::Indexed => wgsl(IMAGE, "indexed_main"),
            Self::Mesh => Shader::Compiled("native/grid.frag.spv"),
            _ => wgsl(IMAGE, "fragment_main"),
        };
        (stages, fragment)
    }
}

/// Vertices of a mesh of one square as texels.
fn places(gpu: &Arc<Gpu>, mesh: &Mesh, cells: u32) -> Result<Arc<SampledImage>, DeviceError> {
    let places: Vec<[f32; 4]> = mesh
        .vertices
        .iter()
        .map(|place| place.as_vec3().extend(1.0).to_array())
        .collect();
    let texels = RouteTexels {
        format: RouteTexelFormat::Rgba32Float,
        is_filtered: false,
        size: [cells + 1; 2],
        is_cube: false,
        bytes: bytemuck::cast_slice(&places).to_vec(),
    };
    Ok(Arc::new(SampledImage::route(gpu, &texels)?))
}
