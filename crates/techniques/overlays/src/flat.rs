// SPDX-License-Identifier: MIT OR Apache-2.0
//! The flat mesh: a region's triangles at a stated height above the ellipsoid, tested against the
//! surface's depth. It does not follow the terrain. An eye below it sees nothing of it.
//!
//! 12 bytes a vertex in fixed point as the volumes' (`FixedPoint`), each stored once, and one list of
//! indices, 16 bits where a region's vertices fit. Source: the "original fill" of Cozzi (2007, 2.1.1).

use terrafill_contract::{Colours, Counters, DeviceError, FillInput, GeometryBytes, MemoryUse};
use terrafill_core::{RegionMesh, VolumeHeights, index_u32};
use terrafill_gpu::{
    COLOUR_FORMAT, Gpu, HeldBuffer, Overlay, RenderTargets, described, index_format, tested,
    vertex_layout,
};
use terrafill_plan::PlannedRegion;
use terrafill_stencil::{FixedPoint, IndexLists, PositionFormat, VolumeConstants, VolumePlace};
use terrafill_variant::{SwitchError, Variant};

/// Key of the height at which meshes lie.
pub(crate) const HEIGHT: &str = "height-m";

/// Its values: the top that the frame plan gives a region's volume, so that nothing drawn is higher;
/// or metres above the ellipsoid.
pub(crate) const HEIGHTS: &[&str] = &["top", "0", "100", "1000", "10000"];

/// Where meshes lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Height {
    /// At the top of the region's volume.
    Top,
    /// Metres above the ellipsoid, at the vertices; between them triangles hang through.
    Metres(f64),
}

impl Height {
    pub(crate) fn of(variant: &Variant) -> Result<Self, SwitchError> {
        let choices = [
            ("top", Self::Top),
            ("0", Self::Metres(0.0)),
            ("100", Self::Metres(100.0)),
            ("1000", Self::Metres(1000.0)),
            ("10000", Self::Metres(10_000.0)),
        ];
        variant.choice(HEIGHT, &choices)
    }
}

/// Bytes that `mesh` takes, by formula: 12 a vertex, and 3 indices of 2 or 4 bytes a triangle.
pub(crate) fn flat_bytes(mesh: &RegionMesh) -> GeometryBytes {
    let vertices = mesh.vertices_ecef.len();
    let is_short = IndexLists::are_short(vertices);
    let index_size = if is_short { 2 } else { 4 };
    GeometryBytes {
        vertex_bytes: 12 * vertices as u64,
        index_bytes: index_size * 3 * mesh.triangles.len() as u64,
    }
}

/// Meshes of a scene on the device.
#[derive(Debug)]
struct SceneMeshes {
    revision: u64,
    places: Vec<VolumePlace>,
    vertices: wgpu::Buffer,
    short_indices: wgpu::Buffer,
    long_indices: wgpu::Buffer,
    bytes: GeometryBytes,
}

impl SceneMeshes {
    fn upload(gpu: &Gpu, input: &FillInput) -> Result<Self, DeviceError> {
        let mut vertices: Vec<[i32; 3]> = Vec::new();
        let mut indices = IndexLists::default();
        let mut places = Vec::new();
        for mesh in input.scene.meshes.iter() {
            let fixed = FixedPoint::for_mesh(mesh);
            let is_short = IndexLists::are_short(mesh.vertices_ecef.len());
            places.push(VolumePlace {
                fixed,
                first_vertex: index_u32(vertices.len()),
                first_triangle_index: indices.count(is_short),
                first_loop_index: 0,
                triangle_count: index_u32(mesh.triangles.len()),
                has_short_indices: is_short,
            });
            let stored = mesh.vertices_ecef.iter();
            vertices.extend(stored.map(|&ecef| fixed.quantize(ecef).to_array()));
            let corners = mesh.triangles.as_flattened().iter();
            indices.extend(is_short, corners.copied());
        }
        let bytes = GeometryBytes {
            vertex_bytes: size_of_val(vertices.as_slice()) as u64,
            index_bytes: indices.bytes(),
        };
        let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
        let upload = |label, bytes, usage| gpu.upload(label, bytes, usage);
        let vertices = bytemuck::cast_slice(&vertices);
        let short = bytemuck::cast_slice(&indices.short);
        let long = bytemuck::cast_slice(&indices.long);
        Ok(Self {
            revision: input.scene.meshes.revision(),
            places,
            vertices: upload("flat meshes", vertices, vertex)?,
            short_indices: upload("16-bit indices", short, index)?,
            long_indices: upload("32-bit indices", long, index)?,
            bytes,
        })
    }
}

/// Flat meshes of a scene, and the pipeline that draws them.
#[derive(Debug)]
pub(crate) struct FlatMesh {
    height: Height,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    scene: Option<SceneMeshes>,
    constants: HeldBuffer,
    bind_group: Option<wgpu::BindGroup>,
    /// Meshes to be drawn, in the plan's order.
    planned: Vec<usize>,
}

impl FlatMesh {
    pub(crate) fn new(gpu: &Gpu, variant: &Variant) -> Result<Self, DeviceError> {
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let layout = gpu.buffer_layout(
            "view and regions",
            wgpu::ShaderStages::VERTEX_FRAGMENT,
            &[wgpu::BufferBindingType::Uniform, storage, storage],
        );
        let shader = gpu.shader("overlays/flat.wgsl")?;
        let pipeline_layout = gpu.pipeline_layout("flat mesh", &[Some(&layout)]);
        let targets = [Some(COLOUR_FORMAT.into())];
        let attributes = wgpu::vertex_attr_array![0 => Sint32x3];
        let vertices = [vertex_layout(&attributes)];
        let mut pipeline = described("flat mesh", &pipeline_layout, &shader, &targets);
        pipeline.vertex.buffers = &vertices;
        // Seen from below, a mesh is behind the surface, or the eye under it.
        pipeline.primitive.cull_mode = Some(wgpu::Face::Back);
        let nearer = wgpu::CompareFunction::Greater;
        pipeline.depth_stencil = Some(tested(nearer, Default::default()));
        if let Some(fragment) = &mut pipeline.fragment {
            fragment.entry_point = Some("region_colour");
        }
        Ok(Self {
            height: Height::of(variant)?,
            pipeline: gpu.create_render_pipeline(&pipeline),
            layout,
            scene: None,
            constants: HeldBuffer::default(),
            bind_group: None,
            planned: Vec::new(),
        })
    }

    fn heights(&self, planned: &PlannedRegion) -> VolumeHeights {
        match self.height {
            Height::Top => planned.heights,
            Height::Metres(height_m) => VolumeHeights {
                top_m: height_m,
                bottom_m: height_m,
            },
        }
    }
}

impl Overlay for FlatMesh {
    const TECHNIQUE: &'static str = "flat-mesh";
    const READS_DEPTH: bool = false;

    fn load(
        &mut self,
        targets: &RenderTargets,
        input: &FillInput,
        colours: Colours,
    ) -> Result<(), DeviceError> {
        let gpu = targets.gpu();
        let revision = input.scene.meshes.revision();
        let held = self.scene.take().filter(|held| held.revision == revision);
        let scene = match held {
            Some(scene) => scene,
            None => SceneMeshes::upload(gpu, input)?,
        };
        let eye = input.camera.eye_ecef;
        let constants = input.plan.regions.iter().map(|planned| {
            let (place, colour) = (&scene.places[planned.mesh], colours.of(planned.region));
            let heights = self.heights(planned);
            VolumeConstants::new(eye, place, heights, PositionFormat::Fixed, colour)
        });
        let mut constants: Vec<VolumeConstants> = constants.collect();
        self.planned = input.plan.regions.iter().map(|p| p.mesh).collect();
        if constants.is_empty() {
            // A storage binding may not be empty.
            constants.push(bytemuck::Zeroable::zeroed());
        }
        let bytes = bytemuck::cast_slice(&constants).to_vec();
        let storage = wgpu::BufferUsages::STORAGE;
        let is_new = self
            .constants
            .hold(gpu, "region constants", bytes, storage)?;
        if let Some(buffer) = self.constants.buffer().filter(|_| is_new) {
            // The footprints of those that move lie behind the constants; a flat mesh bends none.
            let buffers = [targets.view_constants(), buffer, buffer];
            let bound = gpu.bind_buffers("view and regions", &self.layout, &buffers);
            self.bind_group = Some(bound);
        }
        self.scene = Some(scene);
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, counters: &mut Counters) {
        let Some(scene) = &self.scene else {
            return;
        };
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.set_vertex_buffer(0, scene.vertices.slice(..));
        let mut bound = None;
        for (instance, &mesh) in (0..).zip(&self.planned) {
            let place = &scene.places[mesh];
            let is_short = place.has_short_indices;
            if bound != Some(is_short) {
                let both = [&scene.long_indices, &scene.short_indices];
                let indices = both[usize::from(is_short)].slice(..);
                pass.set_index_buffer(indices, index_format(is_short));
                bound = Some(is_short);
            }
            let first = place.first_triangle_index;
            let count = 3 * place.triangle_count;
            let base_vertex = i32::try_from(place.first_vertex).unwrap_or(i32::MAX);
            pass.draw_indexed(first..first + count, base_vertex, instance..instance + 1);
            counters.draws += 1;
            counters.vertices += u64::from(count);
        }
    }

    fn memory(&self) -> MemoryUse {
        let Some(scene) = &self.scene else {
            return MemoryUse::default();
        };
        MemoryUse {
            constant_bytes: (self.planned.len() * size_of::<VolumeConstants>()) as u64,
            buffers: 4,
            ..scene.bytes.into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_fixtures::by_hand::disc;

    #[test]
    fn a_vertex_more_is_twelve_bytes_and_a_triangle() {
        let [five, six, many] = [5, 6, 65_536].map(|count| flat_bytes(&disc(count)));
        assert_eq!((five.vertex_bytes, five.index_bytes), (72, 30));
        assert_eq!(six.vertex_bytes - five.vertex_bytes, 12);
        assert_eq!(six.index_bytes - five.index_bytes, 6);
        // Negative control: beyond 16 bits indices are twice as long.
        assert_eq!(many.index_bytes, 65_536 * 12);
    }
}
