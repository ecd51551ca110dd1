// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes on Vulkan: from buffers, or from a geometry shader that finds the silhouette.

use crate::source::{Adjacency, SHADER, VolumeSource};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_stencil::{VolumeDraw, VolumeState};
use terrafill_vulkan::{
    Buffer, BufferUse, Fragments, Geometry, GeometryStage, Gpu, HandsOn, IndexWidth, Pipeline,
    PipelineDescriptor, Topology, VertexFormat, VertexStage, VolumePass, VulkanVolumes,
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
            VolumeSource::Volumes(volumes) => {
                let upload = |label, bytes, use_for| Buffer::upload(gpu, label, bytes, use_for);
                let vertices = bytemuck::cast_slice(&volumes.vertices);
                let indices = bytemuck::cast_slice(&volumes.indices);
                Feed::Buffers {
                    vertices: upload("shadow vertices", vertices, BufferUse::Vertex)?,
                    indices: upload("shadow indices", indices, BufferUse::Index)?,
                    ranges: volumes.ranges,
                }
            }
            // What it reads lies behind the volumes' constants.
            VolumeSource::Adjacent(own) => Feed::Adjacent(own.by, own.vertices),
            VolumeSource::Pulled(_) | VolumeSource::Corners(_) | VolumeSource::Computed(_) => {
                let what = "storage buffers and compute passes of the study";
                return Err(DeviceError::unsupported(what, terrafill_vulkan::API.name));
            }
        };
        Ok(Self {
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
        let fragments = match state {
            VolumeState::Mark {
                has_colour: true, ..
            } => Fragments::Shader {
                path: SHADER,
                entry_point: "no_colour",
            },
            _ => Fragments::None,
        };
        let geometry = |path| {
            Some(GeometryStage {
                path,
                hands_on: HandsOn::Nothing,
                draws_bottom: false,
                is_turned: false,
            })
        };
        let (entry_point, geometry, topology) = match (&self.feed, part) {
            (Feed::Buffers { .. }, _) => ("vertex_main", None, Topology::Triangles),
            (Feed::Adjacent(by, _), VolumePart::Caps) => {
                let entry_point = match by {
                    Adjacency::Triangles => "triangle_caps",
                    Adjacency::Corners => "corner_caps",
                    Adjacency::Lines => "caps",
                };
                (entry_point, None, Topology::Triangles)
            }
            (Feed::Adjacent(by, _), VolumePart::Volume) => match by {
                Adjacency::Triangles => (
                    "triangles",
                    geometry("casters/triangles.geom"),
                    Topology::TrianglesWithAdjacency,
                ),
                Adjacency::Corners => (
                    "triangles",
                    geometry("casters/corners.geom"),
                    Topology::TrianglesWithAdjacency,
                ),
                Adjacency::Lines => (
                    "lines",
                    geometry("casters/lines.geom"),
                    Topology::LinesWithAdjacency,
                ),
            },
        };
        let (path, format) = match self.feed {
            Feed::Buffers { .. } => (SHADER, VertexFormat::FixedAndFlag),
            Feed::Adjacent(..) => (ADJACENT_SHADER, VertexFormat::Number),
        };
        PipelineDescriptor {
            vertex: VertexStage {
                path,
                entry_point,
                bends_footprints: false,
            },
            geometry,
            fragments,
            format,
            topology,
            state: state.into(),
            // Counting fragments tests nothing.
            depth_bounds: self.has_bounds && !matches!(state, VolumeState::Count { .. }),
        }
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
                        let [of_volume, of_caps] = vertices[caster];
                        let count = if part == VolumePart::Caps {
                            of_caps
                        } else {
                            of_volume
                        };
                        pass.draw(pipeline, count, volume);
                    }
                }
            }
        }
    }
}
