// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines that draw volumes.

use std::collections::HashMap;
use terrafill_contract::{DeviceError, Feature};
use terrafill_gpu::{Gpu, HandedOn, VolumeFill, VolumeShader, vertex_layout};
use terrafill_stencil::{Holding, VolumeState};

/// Which part of a volume a pipeline draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum VolumePart {
    TopCap,
    /// The top's triangles, whose front is their back.
    BottomCap,
    Walls,
}

impl VolumePart {
    /// The parts of volumes, with their bottoms or without.
    pub(crate) fn all(without_bottom: bool) -> impl Iterator<Item = Self> {
        let all = [Self::TopCap, Self::BottomCap, Self::Walls].into_iter();
        all.filter(move |part| !(without_bottom && *part == Self::BottomCap))
    }

    fn entry_point(self, handed_on: HandedOn) -> &'static str {
        match (self, handed_on) {
            (Self::TopCap | Self::BottomCap, HandedOn::Nothing) => "caps_main",
            (Self::TopCap | Self::BottomCap, HandedOn::Colour) => "coloured_caps",
            (Self::TopCap | Self::BottomCap, HandedOn::Number) => "numbered_caps",
            (Self::Walls, HandedOn::Nothing) => "walls_main",
            (Self::Walls, HandedOn::Colour) => "coloured_walls",
            (Self::Walls, HandedOn::Number) => "numbered_walls",
        }
    }
}

/// Slot of the vertices' buffer.
pub(crate) const VERTICES: u32 = 0;

/// Slot of the walls' buffer. Each has its own, so that both stay bound for a whole pass.
pub(crate) const WALLS: u32 = 1;

/// Vertices of a wall: a strip of top start, bottom start, top end, bottom end.
pub(crate) const WALL_CORNERS: u32 = 4;

/// Pipelines on one device, made when first asked for.
#[derive(Debug)]
pub(crate) struct Pipelines {
    shader: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    volumes: HashMap<(VolumePart, VolumeState), wgpu::RenderPipeline>,
}

impl Pipelines {
    pub(crate) fn new(fill: &VolumeFill) -> Result<Self, DeviceError> {
        let gpu = fill.gpu();
        Ok(Self {
            shader: fill.shader("instanced/fill.wgsl")?,
            layout: gpu.pipeline_layout("instanced", &[Some(fill.frame_layout())]),
            volumes: HashMap::new(),
        })
    }

    /// Makes a pipeline unless it is there.
    pub(crate) fn ensure(&mut self, gpu: &Gpu, part: VolumePart, state: VolumeState) {
        if !self.volumes.contains_key(&(part, state)) {
            let pipeline = self.volume_pipeline(gpu, part, state);
            self.volumes.insert((part, state), pipeline);
        }
    }

    /// What they are for: those of bottoms have no bytes, since tops' triangles do for both.
    pub(crate) fn holdings(&self) -> impl Iterator<Item = Holding> {
        let features = self.volumes.keys().map(|(part, state)| match part {
            VolumePart::BottomCap if !matches!(state, VolumeState::Count { .. }) => {
                Feature::BottomCaps
            }
            _ => state.feature(),
        });
        Holding::pipelines(features)
    }

    /// A pipeline that [`Pipelines::ensure`] made.
    pub(crate) fn volume(
        &self,
        part: VolumePart,
        state: VolumeState,
    ) -> Option<&wgpu::RenderPipeline> {
        self.volumes.get(&(part, state))
    }

    fn volume_pipeline(
        &self,
        gpu: &Gpu,
        part: VolumePart,
        state: VolumeState,
    ) -> wgpu::RenderPipeline {
        let position = wgpu::vertex_attr_array![0 => Sint32x3];
        let ends = wgpu::vertex_attr_array![0 => Sint32x3, 1 => Sint32x3];
        let walls = vertex_layout(&ends).map(|ends| wgpu::VertexBufferLayout {
            step_mode: wgpu::VertexStepMode::Instance,
            ..ends
        });
        let (buffers, strip_index_format) = match part {
            VolumePart::TopCap | VolumePart::BottomCap => (vec![vertex_layout(&position)], None),
            // Nothing is indexed and nothing restarts; a strip must name a width nonetheless.
            VolumePart::Walls => (vec![None, walls], Some(wgpu::IndexFormat::Uint16)),
        };
        let is_bottom = part == VolumePart::BottomCap;
        let shader = VolumeShader {
            module: &self.shader,
            layout: &self.layout,
            vertex_entry: part.entry_point(HandedOn::of(state)),
            constants: &[("IS_BOTTOM", f64::from(u8::from(is_bottom)))],
            buffers: &buffers,
            strip_index_format,
            discards: false,
            front_face: if is_bottom {
                wgpu::FrontFace::Cw
            } else {
                wgpu::FrontFace::Ccw
            },
        };
        shader.pipeline(gpu, state, false)
    }
}
