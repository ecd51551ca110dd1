// SPDX-License-Identifier: MIT OR Apache-2.0
//! Outlines of a scene on the device, and the pass in which every pixel scans them.

use crate::outline::{Format, OutlinePlace, SceneOutlines};
use terrafill_contract::{Colours, Counters, DeviceError, FillInput, GeometryBytes, MemoryUse};
use terrafill_core::nearest_f32;
use terrafill_gpu::{COLOUR_FORMAT, Gpu, HeldBuffer, Overlay, RenderTargets, described};
use terrafill_variant::Variant;

/// What the shader reads of a region of the view: twin of `ScannedRegion` in `edge-scan/fill.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct ScannedRegion {
    /// West, south, east, north, degrees.
    box_deg: [f32; 4],
    colour: [f32; 4],
    /// Of its lines.
    first_line: u32,
    end_line: u32,
    /// 1: what no edge is south of is inside.
    is_inside_in_the_south: u32,
    padding: u32,
}

/// Outlines of all meshes of a scene.
#[derive(Debug)]
struct HeldOutlines {
    revision: u64,
    places: Vec<OutlinePlace>,
    bytes: GeometryBytes,
    positions: wgpu::Buffer,
    ends: wgpu::Buffer,
}

/// Outlines, and the pipeline that scans them.
#[derive(Debug)]
pub(crate) struct EdgeScan {
    format: Format,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    scene: Option<HeldOutlines>,
    radii: HeldBuffer,
    regions: HeldBuffer,
    bind_group: Option<wgpu::BindGroup>,
}

impl EdgeScan {
    pub(crate) fn new(gpu: &Gpu, variant: &Variant) -> Result<Self, DeviceError> {
        let format = Format::of(variant)?;
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let uniform = buffer(wgpu::BufferBindingType::Uniform);
        let storage = buffer(wgpu::BufferBindingType::Storage { read_only: true });
        let depth = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let types = [uniform, uniform, storage, storage, storage, depth];
        let layout = gpu.fragment_layout("edge scan", &types);
        let shader = gpu.shader("edge-scan/fill.wgsl")?;
        let pipeline_layout = gpu.pipeline_layout("edge scan", &[Some(&layout)]);
        let targets = [Some(COLOUR_FORMAT.into())];
        let constants = [("HALVES", f64::from(u8::from(format == Format::F16)))];
        let mut pipeline = described("edge scan", &pipeline_layout, &shader, &targets);
        if let Some(fragment) = &mut pipeline.fragment {
            fragment.compilation_options.constants = &constants;
        }
        Ok(Self {
            format,
            pipeline: gpu.create_render_pipeline(&pipeline),
            layout,
            scene: None,
            radii: HeldBuffer::default(),
            regions: HeldBuffer::default(),
            bind_group: None,
        })
    }

    /// Outlines of every mesh of the input, those of coarser levels among them.
    pub(crate) fn outlines(&self, input: &FillInput) -> Result<SceneOutlines, DeviceError> {
        let meshes = input.scene.meshes.iter().map(|mesh| &**mesh);
        SceneOutlines::new(self.format, &input.scene.body, meshes)
    }

    /// Uploads outlines in place of those of the input's meshes.
    pub(crate) fn upload(
        &mut self,
        gpu: &Gpu,
        input: &FillInput,
        outlines: SceneOutlines,
    ) -> Result<(), DeviceError> {
        let storage = wgpu::BufferUsages::STORAGE;
        let upload = |label, words: &[u32]| gpu.upload(label, bytemuck::cast_slice(words), storage);
        self.bind_group = None;
        self.scene = Some(HeldOutlines {
            revision: input.scene.meshes.revision(),
            positions: upload("positions of outlines", &outlines.words)?,
            ends: upload("ends of lines", &outlines.ends)?,
            bytes: outlines.bytes(),
            places: outlines.places,
        });
        Ok(())
    }
}

/// Constants of the view's regions, in the order of the scene, of which the last that a place is in counts.
fn regions(input: &FillInput, colours: Colours, places: &[OutlinePlace]) -> Vec<ScannedRegion> {
    let planned = input.plan.regions.iter().map(|planned| {
        let place = &places[planned.mesh];
        ScannedRegion {
            box_deg: place.box_deg,
            colour: colours.of(planned.region),
            first_line: place.lines.start,
            end_line: place.lines.end,
            is_inside_in_the_south: u32::from(place.is_inside_in_the_south),
            padding: 0,
        }
    });
    let mut regions: Vec<ScannedRegion> = planned.collect();
    if regions.is_empty() {
        // A storage binding may not be empty. This one has no lines, and its outside is everywhere.
        regions.push(bytemuck::Zeroable::zeroed());
    }
    regions
}

impl Overlay for EdgeScan {
    const TECHNIQUE: &'static str = "edge-scan";
    const READS_DEPTH: bool = true;

    /// # Errors
    /// [`DeviceError::Unsupported`] for regions that the vertex stage moves, whose outlines are nowhere stored,
    /// and for edges of half a turn.
    fn load(
        &mut self,
        targets: &RenderTargets,
        input: &FillInput,
        colours: Colours,
    ) -> Result<(), DeviceError> {
        if !input.scene.footprints.is_empty() {
            let moving = "outlines of footprints that the vertex stage moves";
            return Err(DeviceError::unsupported(moving, Self::TECHNIQUE));
        }
        let gpu = targets.gpu();
        let revision = input.scene.meshes.revision();
        if self.scene.as_ref().map(|scene| scene.revision) != Some(revision) {
            self.scene = None;
            let outlines = self.outlines(input)?;
            self.upload(gpu, input, outlines)?;
        }
        let Some(scene) = &self.scene else {
            return Err(DeviceError::Missing("outline"));
        };
        let body = &input.scene.body;
        let radii = [body.equatorial_radius_m(), body.polar_radius_m()].map(nearest_f32);
        let bytes = bytemuck::cast_slice(&radii).to_vec();
        let uniform = wgpu::BufferUsages::UNIFORM;
        let mut is_new = self.radii.hold(gpu, "radii", bytes, uniform)?;
        let bytes = bytemuck::cast_slice(&regions(input, colours, &scene.places)).to_vec();
        let storage = wgpu::BufferUsages::STORAGE;
        is_new |= self.regions.hold(gpu, "scanned regions", bytes, storage)?;
        if let (Some(radii), Some(regions)) = (self.radii.buffer(), self.regions.buffer())
            && (is_new || self.bind_group.is_none())
        {
            let depth = targets.depth_view();
            let resources = [
                targets.view_constants().as_entire_binding(),
                radii.as_entire_binding(),
                regions.as_entire_binding(),
                scene.ends.as_entire_binding(),
                scene.positions.as_entire_binding(),
                wgpu::BindingResource::TextureView(&depth),
            ];
            self.bind_group = Some(gpu.bind("edge scan", &self.layout, resources));
        }
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, counters: &mut Counters) {
        if self.bind_group.is_none() {
            return;
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.draw(0..3, 0..1);
        counters.draws += 1;
        counters.vertices += 3;
    }

    fn memory(&self) -> MemoryUse {
        let Some(scene) = &self.scene else {
            return MemoryUse::default();
        };
        let held = scene.positions.size() + scene.ends.size();
        MemoryUse {
            constant_bytes: self.radii.size() + self.regions.size(),
            padding_bytes: held - scene.bytes.total(),
            buffers: 4,
            ..scene.bytes.into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    #[test]
    fn regions_lie_as_the_shader_reads_them() {
        macro_rules! offsets {
            ($($field:ident),*) => {
                [$((stringify!($field), offset_of!(ScannedRegion, $field))),*]
            };
        }
        let rust = offsets!(
            box_deg,
            colour,
            first_line,
            end_line,
            is_inside_in_the_south,
            padding
        );
        let layout = struct_layout("edge-scan/fill.wgsl", "ScannedRegion").expect("in the shader");
        let members = layout.members.iter();
        let shader: Vec<(&str, usize)> = members
            .map(|(name, offset, _)| (name.as_str(), *offset as usize))
            .collect();
        assert_eq!(shader, rust);
        assert_eq!(layout.stride as usize, size_of::<ScannedRegion>());
        // Negative control: two that are exchanged are noticed.
        let mut exchanged = rust;
        exchanged.swap(2, 3);
        assert_ne!(shader, exchanged);
    }
}
