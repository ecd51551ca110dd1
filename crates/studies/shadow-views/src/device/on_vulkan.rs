// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes on Vulkan: from buffers, or from a geometry shader that finds the silhouette.

use crate::source::{Adjacency, EyeVolumes, HandedOver, SHADER, VolumeSource};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_stencil::{VolumeDraw, VolumeState};
use terrafill_vulkan::{
    Buffer, BufferUse, Fragments, Geometry, GeometryStage, Gpu, HandsOn, IndexWidth, Pipeline,
    PipelineDescriptor, Topology, VertexFormat, VolumePass, VulkanVolumes,
};

/// Hands corners and facing bits to a geometry shader.
const ADJACENT_SHADER: &str = "casters/adjacent.wgsl";

/// What draws read.
enum Feed {
    Buffers {
        vertices: Buffer,
        indices: Buffer,
        ranges: Vec<Range<u32>>,
    },
    /// Vertices of each caster, by [`VolumePart`].
    Adjacent(Adjacency, Vec<[u32; 2]>),
}

/// What a caster's volume is drawn as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum VolumePart {
    /// The volume, or what a geometry shader makes of it.
    Volume,
    /// Caps beside it, as a geometry shader may begin a triangle with another corner than the surface does. Depths
    /// then differ in the last bit: on llvmpipe 106 pixels of lit casters were in their own shadow.
    Caps,
}

/// Buffers and pipelines on Vulkan.
pub(super) struct OnVulkan {
    gpu: Arc<Gpu>,
    feed: Feed,
    /// The surface's depth is tested against each volume's range.
    has_bounds: bool,
    pipelines: HashMap<(VolumeState, VolumePart), Pipeline>,
}

impl OnVulkan {
    pub(super) fn new(
        gpu: &Arc<Gpu>,
        source: VolumeSource,
        has_bounds: bool,
    ) -> Result<Self, DeviceError> {
        let feed = match source {
            VolumeSource::Volumes(volumes) => buffers(gpu, &volumes)?,
            // What it reads lies behind the volumes' constants.
            VolumeSource::Adjacent(own) => Feed::Adjacent(own.by, own.vertices),
            VolumeSource::Pulled(_) | VolumeSource::Computed(_) => {
                let what = "storage buffers and compute passes of the study";
                return Err(DeviceError::unsupported(what, terrafill_vulkan::API.name));
            }
        };
        Ok(Self {
            gpu: Arc::clone(gpu),
            feed,
            has_bounds,
            pipelines: HashMap::new(),
        })
    }

    fn parts(&self) -> &'static [VolumePart] {
        match self.feed {
            Feed::Adjacent(..) => &[VolumePart::Volume, VolumePart::Caps],
            Feed::Buffers { .. } => &[VolumePart::Volume],
        }
    }

    fn descriptor(&self, state: VolumeState, part: VolumePart) -> PipelineDescriptor {
        let (path, format) = match self.feed {
            Feed::Buffers { .. } => (SHADER, VertexFormat::FixedAndFlag),
            Feed::Adjacent(..) => (ADJACENT_SHADER, VertexFormat::Number),
        };
        let mut described = PipelineDescriptor {
            fragments: match state {
                VolumeState::Mark {
                    has_colour: true, ..
                } => Fragments::Shader {
                    path: SHADER,
                    entry_point: "no_colour",
                },
                _ => Fragments::None,
            },
            // Counting fragments tests nothing.
            depth_bounds: self.has_bounds && !matches!(state, VolumeState::Count { .. }),
            ..PipelineDescriptor::of_shader(path, format, state.into())
        };
        if let Feed::Adjacent(by, _) = &self.feed {
            let (volume, caps, path) = match by {
                Adjacency::Triangles => ("triangles", "triangle_caps", "casters/triangles.geom"),
                Adjacency::Corners => ("triangles", "corner_caps", "casters/corners.geom"),
                Adjacency::Lines => ("lines", "caps", "casters/lines.geom"),
            };
            described.vertex.entry_point = caps;
            if part == VolumePart::Volume {
                described.vertex.entry_point = volume;
                described.geometry = Some(GeometryStage {
                    path,
                    hands_on: HandsOn::Nothing,
                    draws_bottom: false,
                    is_turned: false,
                });
                described.topology = match by {
                    Adjacency::Lines => Topology::LinesWithAdjacency,
                    _ => Topology::TrianglesWithAdjacency,
                };
            }
        }
        described
    }
}

fn buffers(gpu: &Arc<Gpu>, volumes: &EyeVolumes) -> Result<Feed, DeviceError> {
    let upload = |label, bytes, use_for| Buffer::upload(gpu, label, bytes, use_for);
    let vertices = bytemuck::cast_slice(&volumes.vertices);
    let indices = bytemuck::cast_slice(&volumes.indices);
    Ok(Feed::Buffers {
        vertices: upload("shadow vertices", vertices, BufferUse::Vertex)?,
        indices: upload("shadow indices", indices, BufferUse::Index)?,
        ranges: volumes.ranges.clone(),
    })
}

impl HandedOver for OnVulkan {
    fn hand_over(&mut self, volumes: &EyeVolumes) -> Result<(), DeviceError> {
        self.feed = buffers(&self.gpu, volumes)?;
        Ok(())
    }
}

impl VulkanVolumes for OnVulkan {
    fn ensure(&mut self, gpu: &Arc<Gpu>, draw: &VolumeDraw<'_>) -> Result<(), DeviceError> {
        for &part in self.parts() {
            let descriptor = self.descriptor(draw.state, part);
            if let Entry::Vacant(place) = self.pipelines.entry((draw.state, part)) {
                place.insert(Pipeline::new(gpu, descriptor)?);
            }
        }
        Ok(())
    }

    fn draw<'a>(&'a self, pass: &mut VolumePass<'a, '_, '_>, draw: &VolumeDraw<'_>) {
        for &part in self.parts() {
            let Some(pipeline) = self.pipelines.get(&(draw.state, part)) else {
                return;
            };
            for &volume in draw.volumes {
                let caster = pass.list.volumes[volume].geometry;
                pass.cut(volume, draw.scissor);
                if self.has_bounds && !matches!(draw.state, VolumeState::Count { .. }) {
                    let range = pass.list.volumes[volume].depth;
                    pass.depth_bounds(range.low, range.high);
                }
                match &self.feed {
                    Feed::Buffers {
                        vertices,
                        indices,
                        ranges,
                    } => {
                        let geometry = Geometry {
                            vertices,
                            indices,
                            width: IndexWidth::Long,
                        };
                        pass.draw_indexed(pipeline, geometry, ranges[caster].clone(), 0, volume);
                    }
                    Feed::Adjacent(_, vertices) => {
                        pass.draw(pipeline, vertices[caster][part as usize], volume);
                    }
                }
            }
        }
    }
}
