// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines that draw volumes.

use crate::{BOTTOM_PX, Bottom, FLAG_BYTES, Layout, Normals, VertexVariant};
use std::collections::HashMap;
use terrafill_contract::DeviceError;
use terrafill_gpu::{Gpu, HandedOn, VolumeFill, VolumeShader, index_format};
use terrafill_stencil::{Holding, PositionFormat, VolumeState};

/// Which part of a volume a pipeline draws. Doubled walls may be strips, and a strip's restart value
/// belongs to the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum VolumePart {
    Caps,
    Walls {
        short_indices: bool,
    },
    /// Walls whose front is their back.
    TurnedWalls,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct PipelineKey {
    pub(crate) part: VolumePart,
    pub(crate) state: VolumeState,
    /// Colours are blended over what lies under them.
    pub(crate) blends: bool,
}

/// A pipeline for each part of volumes in a layout whose indices have this width.
pub(crate) fn keys(
    layout: Layout,
    short_indices: bool,
    state: VolumeState,
    blends: bool,
) -> impl Iterator<Item = PipelineKey> {
    // The first wall on an inner edge is drawn for the second one too.
    let turned = (layout == Layout::PerTriangle).then_some(VolumePart::TurnedWalls);
    let both = [VolumePart::Caps, VolumePart::Walls { short_indices }];
    let parts = both.into_iter().chain(turned);
    parts.map(move |part| PipelineKey {
        part,
        state,
        blends,
    })
}

/// Pipelines of one variant on one device, made when first asked for.
#[derive(Debug)]
pub(crate) struct Pipelines {
    variant: VertexVariant,
    shader: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    volumes: HashMap<PipelineKey, wgpu::RenderPipeline>,
    /// Group 1 of layout `pulled`: vertices and indices. Of merged volumes: where their constants lie.
    pub(crate) geometry_layout: wgpu::BindGroupLayout,
}

impl Pipelines {
    pub(crate) fn new(fill: &VolumeFill, variant: VertexVariant) -> Result<Self, DeviceError> {
        let gpu = fill.gpu();
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let geometry_layout = if variant.merges_volumes() {
            gpu.buffer_layout("volumes of regions", wgpu::ShaderStages::VERTEX, &[storage])
        } else {
            gpu.buffer_layout("pulled geometry", stages, &[storage, storage])
        };
        let frame = Some(fill.frame_layout());
        let with_geometry = || gpu.pipeline_layout("vertex", &[frame, Some(&geometry_layout)]);
        let (path, layout) = match variant.layout {
            Layout::Pulled => ("vertex/pulled.wgsl", with_geometry()),
            _ if variant.merges_volumes() => ("vertex/merged.wgsl", with_geometry()),
            _ => (
                "vertex/doubled.wgsl",
                gpu.pipeline_layout("vertex", &[frame]),
            ),
        };
        Ok(Self {
            variant,
            shader: fill.shader(path)?,
            layout,
            volumes: HashMap::new(),
            geometry_layout,
        })
    }

    /// Makes a pipeline unless it is there.
    pub(crate) fn ensure(&mut self, gpu: &Gpu, key: PipelineKey) {
        if !self.volumes.contains_key(&key) {
            let pipeline = self.volume_pipeline(gpu, key);
            self.volumes.insert(key, pipeline);
        }
    }

    /// What they are for.
    pub(crate) fn holdings(&self) -> impl Iterator<Item = Holding> {
        let states = self.volumes.keys().map(|key| key.state);
        Holding::pipelines(states.map(VolumeState::feature))
    }

    /// A pipeline that [`Pipelines::ensure`] made.
    pub(crate) fn volume(&self, key: PipelineKey) -> Option<&wgpu::RenderPipeline> {
        self.volumes.get(&key)
    }

    fn strip_format(&self, part: VolumePart) -> Option<wgpu::IndexFormat> {
        match part {
            VolumePart::Walls { short_indices } if self.variant.has_strips() => {
                Some(index_format(short_indices))
            }
            _ => None,
        }
    }

    fn volume_pipeline(&self, gpu: &Gpu, key: PipelineKey) -> wgpu::RenderPipeline {
        let has_low_part = self.variant.positions == PositionFormat::TwoFloat;
        let short = wgpu::vertex_attr_array![0 => Sint32x3, 1 => Uint32];
        let long = wgpu::vertex_attr_array![0 => Sint32x3, 2 => Sint32x3, 1 => Uint32];
        let with_normal = wgpu::vertex_attr_array![0 => Sint32x3, 3 => Float32x3, 1 => Uint32];
        let has_normal = self.variant.normals == Normals::Stored;
        let attributes: &[wgpu::VertexAttribute] = match (has_low_part, has_normal) {
            (true, _) => &long,
            (false, true) => &with_normal,
            (false, false) => &short,
        };
        // Without the flag, which comes last.
        let position = &attributes[..attributes.len() - 1];
        let buffer = |stride: usize, attributes| {
            Some(wgpu::VertexBufferLayout {
                array_stride: stride as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes,
            })
        };
        let stride = 4 * self.variant.vertex_words();
        let flags = wgpu::vertex_attr_array![1 => Uint32];
        let buffers = match self.variant.layout {
            Layout::Pulled => vec![],
            Layout::Separate => vec![buffer(stride, position), buffer(FLAG_BYTES, &flags)],
            Layout::Doubled | Layout::PerTriangle => vec![buffer(stride, attributes)],
        };
        let vertices = match self.variant.layout.is_doubled() {
            false => Vertices::Pulled,
            true if has_low_part => Vertices::StoredTwoFloat,
            true if has_normal => Vertices::StoredNormal,
            true => Vertices::Stored,
        };
        let positions = ("POSITIONS", positions_number(self.variant.positions));
        let bottom = match self.variant.bottom {
            Bottom::Planned => 0.0,
            Bottom::Pixels => BOTTOM_PX,
        };
        let normals = ("NORMALS", normals_number(self.variant.normals));
        let constants = [positions, normals, ("BOTTOM_PX", bottom)];
        let has_bottom_px = vertices != Vertices::Pulled && !self.variant.merges_volumes();
        let of_layout = usize::from(has_bottom_px);
        let shader = VolumeShader {
            module: &self.shader,
            layout: &self.layout,
            vertex_entry: entry_point(vertices, key.part, HandedOn::of(key.state)),
            constants: &constants[..2 + of_layout],
            buffers: &buffers,
            strip_index_format: self.strip_format(key.part),
            discards: false,
            front_face: match key.part {
                VolumePart::Caps | VolumePart::Walls { .. } => wgpu::FrontFace::Ccw,
                VolumePart::TurnedWalls => wgpu::FrontFace::Cw,
            },
        };
        shader.pipeline(gpu, key.state, key.blends)
    }
}

/// `POSITIONS` of `shared/region.wgsl`.
fn positions_number(positions: PositionFormat) -> f64 {
    match positions {
        PositionFormat::Fixed => 0.0,
        PositionFormat::LocalF32 => 1.0,
        PositionFormat::EcefF32 => 2.0,
        PositionFormat::TwoFloat => 3.0,
    }
}

/// `NORMALS` of `shared/region.wgsl`.
fn normals_number(normals: Normals) -> f64 {
    match normals {
        Normals::Geodetic => 0.0,
        Normals::Centric => 1.0,
        Normals::Stored => 2.0,
    }
}

/// What hands vertices to the shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Vertices {
    /// Attributes.
    Stored,
    /// Attributes, one more of them.
    StoredTwoFloat,
    /// Another one more.
    StoredNormal,
    /// The shader takes them from buffers.
    Pulled,
}

fn entry_point(vertices: Vertices, part: VolumePart, handed_on: HandedOn) -> &'static str {
    use Vertices::{Pulled, Stored, StoredNormal, StoredTwoFloat};
    match (vertices, part, handed_on) {
        (Stored, _, HandedOn::Nothing) => "vertex_main",
        (Stored, _, HandedOn::Colour) => "coloured_main",
        (Stored, _, HandedOn::Number) => "numbered_main",
        (StoredTwoFloat, _, HandedOn::Nothing) => "two_float_main",
        (StoredTwoFloat, _, HandedOn::Colour) => "coloured_two_float",
        (StoredTwoFloat, _, HandedOn::Number) => "numbered_two_float",
        (StoredNormal, _, HandedOn::Nothing) => "normal_main",
        (StoredNormal, _, HandedOn::Colour) => "coloured_normal",
        (StoredNormal, _, HandedOn::Number) => "numbered_normal",
        (Pulled, VolumePart::Caps, HandedOn::Nothing) => "caps_main",
        (Pulled, VolumePart::Caps, HandedOn::Colour) => "coloured_caps",
        (Pulled, VolumePart::Caps, HandedOn::Number) => "numbered_caps",
        (Pulled, VolumePart::Walls { .. } | VolumePart::TurnedWalls, HandedOn::Nothing) => {
            "walls_main"
        }
        (Pulled, VolumePart::Walls { .. } | VolumePart::TurnedWalls, HandedOn::Colour) => {
            "coloured_walls"
        }
        (Pulled, VolumePart::Walls { .. } | VolumePart::TurnedWalls, HandedOn::Number) => {
            "numbered_walls"
        }
    }
}
