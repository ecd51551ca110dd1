// SPDX-License-Identifier: MIT OR Apache-2.0
//! The draped mesh: regions cut along the surface's triangles on the CPU ([`crate::clip`]), drawn
//! nearer to the eye than the surface by a stated share of their distance.
//!
//! It depends on the surface as drawn: another view of a surface with levels of detail, or another
//! eye, has to be cut anew. Corners are three floats from the eye and the region's place, 16 bytes.

use crate::clip::Pieces;
use terrafill_contract::{
    Colours, Counters, DeviceError, FillInput, GeometryBytes, MemoryUse, ViewId, count_u32,
};
use terrafill_core::nearest_f32;
use terrafill_gpu::{
    COLOUR_FORMAT, Gpu, HeldBuffer, Overlay, RenderTargets, described, tested, vertex_layout,
};
use terrafill_variant::{SwitchError, Variant};

/// Key of the share by which depth is greater than the surface's.
pub(crate) const OFFSET: &str = "depth-offset";

/// Its values. Corners snap to 1/256 pixel, and two kilometres over the ground distance grows by 5 %
/// a pixel near the horizon: by 2⁻¹² of it within the snap.
pub(crate) const OFFSETS: &[&str] = &["2^-10", "2^-14", "2^-18", "0"];

fn offset(variant: &Variant) -> Result<f64, SwitchError> {
    let choices = [("2^-10", -10), ("2^-14", -14), ("2^-18", -18)];
    match variant.value(OFFSET) {
        Some("0") => Ok(0.0),
        _ => Ok(f64::from(variant.choice(OFFSET, &choices)?).exp2()),
    }
}

/// A corner as the shader reads it.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Corner {
    /// Metres, ECEF axes.
    from_eye: [f32; 3],
    /// Place of the region in the plan.
    region: u32,
}

/// What the pieces on the device were cut from.
#[derive(Debug, PartialEq, Eq)]
struct Cut {
    revision: u64,
    view: ViewId,
    /// Meshes and regions of the plan.
    planned: Vec<[usize; 2]>,
}

#[derive(Debug)]
struct Uploaded {
    cut: Cut,
    corners: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    bytes: GeometryBytes,
}

impl Uploaded {
    fn new(gpu: &Gpu, input: &FillInput, cut: Cut) -> Result<Self, DeviceError> {
        let pieces = Pieces::cut(input);
        let corner = |&(from_eye, region): &(glam::DVec3, u32)| Corner {
            from_eye: from_eye.as_vec3().to_array(),
            region,
        };
        let corners: Vec<Corner> = pieces.corners.iter().map(corner).collect();
        let corners: &[u8] = bytemuck::cast_slice(&corners);
        let indices = pieces.triangles.as_flattened();
        let index_count = count_u32("indices of draped meshes", indices.len())?;
        let indices: &[u8] = bytemuck::cast_slice(indices);
        Ok(Self {
            cut,
            bytes: GeometryBytes {
                vertex_bytes: corners.len() as u64,
                index_bytes: indices.len() as u64,
            },
            corners: gpu.upload("draped corners", corners, wgpu::BufferUsages::VERTEX)?,
            indices: gpu.upload("draped indices", indices, wgpu::BufferUsages::INDEX)?,
            index_count,
        })
    }
}

/// Draped meshes of a view, and the pipeline that draws them.
#[derive(Debug)]
pub(crate) struct DrapedMesh {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    uploaded: Option<Uploaded>,
    colours: HeldBuffer,
    offset: wgpu::Buffer,
    bind_group: Option<wgpu::BindGroup>,
}

impl DrapedMesh {
    pub(crate) fn new(gpu: &Gpu, variant: &Variant) -> Result<Self, DeviceError> {
        let uniform = wgpu::BufferBindingType::Uniform;
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let layout = gpu.buffer_layout(
            "view and draped regions",
            wgpu::ShaderStages::VERTEX_FRAGMENT,
            &[uniform, storage, uniform],
        );
        let shader = gpu.shader("overlays/draped.wgsl")?;
        let pipeline_layout = gpu.pipeline_layout("draped mesh", &[Some(&layout)]);
        let targets = [Some(COLOUR_FORMAT.into())];
        let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32];
        let corners = [vertex_layout(&attributes)];
        let mut pipeline = described("draped mesh", &pipeline_layout, &shader, &targets);
        pipeline.vertex.buffers = &corners;
        let nearest = wgpu::CompareFunction::GreaterEqual;
        pipeline.depth_stencil = Some(tested(nearest, Default::default()));
        let nearer = [1.0 + nearest_f32(offset(variant)?), 0.0, 0.0, 0.0];
        Ok(Self {
            pipeline: gpu.create_render_pipeline(&pipeline),
            layout,
            uploaded: None,
            colours: HeldBuffer::default(),
            offset: gpu.upload("depth offset", bytemuck::bytes_of(&nearer), {
                wgpu::BufferUsages::UNIFORM
            })?,
            bind_group: None,
        })
    }
}

impl Overlay for DrapedMesh {
    const TECHNIQUE: &'static str = "draped-mesh";
    const READS_DEPTH: bool = false;

    fn load(
        &mut self,
        targets: &RenderTargets,
        input: &FillInput,
        colours: Colours,
    ) -> Result<(), DeviceError> {
        let gpu = targets.gpu();
        let planned = input.plan.regions.iter();
        let cut = Cut {
            revision: input.scene.meshes.revision(),
            view: input.view_id,
            planned: planned.clone().map(|p| [p.mesh, p.region]).collect(),
        };
        if self.uploaded.as_ref().is_none_or(|held| held.cut != cut) {
            self.uploaded = None;
            self.uploaded = Some(Uploaded::new(gpu, input, cut)?);
        }
        let mut of_regions: Vec<[f32; 4]> = planned.map(|p| colours.of(p.region)).collect();
        if of_regions.is_empty() {
            // A storage binding may not be empty.
            of_regions.push([0.0; 4]);
        }
        let bytes = bytemuck::cast_slice(&of_regions).to_vec();
        let storage = wgpu::BufferUsages::STORAGE;
        let is_new = self.colours.hold(gpu, "region colours", bytes, storage)?;
        if let Some(buffer) = self.colours.buffer().filter(|_| is_new) {
            let buffers = [targets.view_constants(), buffer, &self.offset];
            let bound = gpu.bind_buffers("view and draped regions", &self.layout, &buffers);
            self.bind_group = Some(bound);
        }
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, counters: &mut Counters) {
        let uploaded = self.uploaded.as_ref().filter(|held| held.index_count > 0);
        let Some(uploaded) = uploaded else {
            return;
        };
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.set_vertex_buffer(0, uploaded.corners.slice(..));
        pass.set_index_buffer(uploaded.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..uploaded.index_count, 0, 0..1);
        counters.draws += 1;
        counters.vertices += u64::from(uploaded.index_count);
    }

    fn memory(&self) -> MemoryUse {
        let bytes = self.uploaded.as_ref().map(|held| held.bytes);
        MemoryUse {
            constant_bytes: self.colours.size() + self.offset.size(),
            buffers: 4,
            ..bytes.unwrap_or_default().into()
        }
    }
}
