// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes as the passes of a fill draw them: caps, then walls, then those that are turned over.

use crate::layout::{RegionSlice, SceneGeometry};
use crate::pipeline::{Part, PipelineKey, Pipelines, draws_first_walls_twice, parts};
use crate::{Layout, VertexVariant};
use terrafill_fill::{DeviceError, FrameInput, GeometryBytes, RegionPlace, VolumeDraw};
use terrafill_gpu::{Gpu, RenderTargets, VolumeFill, VolumePass, Volumes};

/// Volumes of a scene, and the pipelines that draw them.
#[derive(Debug)]
pub(crate) struct VertexVolumes {
    variant: VertexVariant,
    pipelines: Pipelines,
    scene: Option<SceneBuffers>,
}

/// Geometry of every region of a scene, in view or not.
#[derive(Debug)]
struct SceneBuffers {
    regions: Vec<RegionSlice>,
    vertices: wgpu::Buffer,
    /// Layout `separate`: the flags that all regions share.
    flags: Option<wgpu::Buffer>,
    short_indices: wgpu::Buffer,
    long_indices: wgpu::Buffer,
    /// Layout `pulled`: the vertices with the short and with the long indices.
    pulled: Option<[wgpu::BindGroup; 2]>,
    bytes: GeometryBytes,
}

impl VertexVolumes {
    pub(crate) fn new(fill: &VolumeFill, variant: VertexVariant) -> Result<Self, DeviceError> {
        Ok(Self {
            variant,
            pipelines: Pipelines::new(fill, variant)?,
            scene: None,
        })
    }

    /// Bytes of the geometry, and how many buffers hold it.
    pub(crate) fn memory(&self) -> (GeometryBytes, u64) {
        let Some(scene) = &self.scene else {
            return Default::default();
        };
        // Vertices, and indices of both widths.
        (scene.bytes, 3 + u64::from(scene.flags.is_some()))
    }

    /// Where a mesh lies; `None` before anything is uploaded.
    pub(crate) fn places(&self) -> Option<impl Fn(usize) -> RegionPlace> {
        let scene = self.scene.as_ref()?;
        Some(|mesh: usize| scene.regions[mesh].place)
    }

    pub(crate) fn upload(
        &mut self,
        targets: &RenderTargets,
        input: &FrameInput,
    ) -> Result<(), DeviceError> {
        let layout = self.variant.layout;
        let geometry = SceneGeometry::build(&self.variant, &input.scene.meshes);
        let bytes = geometry.bytes();
        let (vertex_usage, index_usage) = match layout {
            Layout::Pulled => (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::STORAGE),
            _ => (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX),
        };
        let upload = |label, bytes, usage| targets.upload(label, bytes, usage);
        let vertices = upload(
            "volume vertices",
            bytemuck::cast_slice(&geometry.vertices),
            vertex_usage,
        )?;
        let flags = match layout {
            Layout::Separate => Some(upload(
                "shared flags",
                geometry.flags.as_flattened(),
                vertex_usage,
            )?),
            _ => None,
        };
        let short = bytemuck::cast_slice(&geometry.indices.short);
        let short_indices = upload("16-bit indices", short, index_usage)?;
        let long = bytemuck::cast_slice(&geometry.indices.long);
        let long_indices = upload("32-bit indices", long, index_usage)?;
        let bind = |indices: &wgpu::Buffer| {
            let layout = &self.pipelines.geometry_layout;
            let buffers = [&vertices, indices];
            targets
                .gpu()
                .bind_buffers("pulled geometry", layout, &buffers)
        };
        let pulled =
            (layout == Layout::Pulled).then(|| [bind(&short_indices), bind(&long_indices)]);
        self.scene = Some(SceneBuffers {
            regions: geometry.regions,
            vertices,
            flags,
            short_indices,
            long_indices,
            pulled,
            bytes,
        });
        Ok(())
    }
}

impl SceneBuffers {
    fn slice(&self, input: &FrameInput, planned: usize) -> &RegionSlice {
        &self.regions[input.plan.regions[planned].mesh]
    }

    /// Those of `regions` whose indices have this width.
    fn of_width(
        &self,
        input: &FrameInput,
        regions: &[usize],
        short_indices: bool,
    ) -> impl Iterator<Item = usize> {
        let is_of_width = move |planned: &usize| {
            self.slice(input, *planned).place.has_short_indices == short_indices
        };
        regions.iter().copied().filter(is_of_width)
    }

    fn bind_indices(&self, pass: &mut wgpu::RenderPass<'_>, short_indices: bool) {
        if let Some(pulled) = &self.pulled {
            pass.set_bind_group(1, &pulled[usize::from(!short_indices)], &[]);
        } else if short_indices {
            let indices = self.short_indices.slice(..);
            pass.set_index_buffer(indices, wgpu::IndexFormat::Uint16);
        } else {
            let indices = self.long_indices.slice(..);
            pass.set_index_buffer(indices, wgpu::IndexFormat::Uint32);
        }
    }
}

impl Volumes for VertexVolumes {
    fn ensure(&mut self, gpu: &Gpu, input: &FrameInput, draw: &VolumeDraw<'_>, blends: bool) {
        let Some(scene) = &self.scene else {
            return;
        };
        for short_indices in [true, false] {
            let mut drawn = scene.of_width(input, draw.regions, short_indices);
            if drawn.next().is_none() {
                continue;
            }
            for part in parts(self.variant.layout, draw.state, short_indices) {
                let key = PipelineKey {
                    part,
                    state: draw.state,
                    blends,
                };
                self.pipelines.ensure(gpu, key);
            }
        }
    }

    fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        let Some(scene) = &self.scene else {
            return;
        };
        if scene.pulled.is_none() {
            pass.set_vertex_buffer(0, scene.vertices.slice(..));
        }
        if let Some(flags) = &scene.flags {
            pass.set_vertex_buffer(1, flags.slice(..));
        }
    }

    /// Caps of all regions, then walls of all, so that pipelines change seldom.
    fn draw(&mut self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, blends: bool) {
        let Some(scene) = &self.scene else {
            return;
        };
        for short_indices in [true, false] {
            for part in parts(self.variant.layout, draw.state, short_indices) {
                let mut is_bound = false;
                for planned in scene.of_width(pass.input, draw.regions, short_indices) {
                    if !is_bound {
                        let key = PipelineKey {
                            part,
                            state: draw.state,
                            blends,
                        };
                        if let Some(pipeline) = self.pipelines.volume(key) {
                            pass.raw.set_pipeline(pipeline);
                        }
                        scene.bind_indices(&mut pass.raw, short_indices);
                        is_bound = true;
                    }
                    pass.cut(planned, draw.scissor);
                    self.draw_part(scene, pass, part, planned, draw);
                }
            }
        }
    }
}

impl VertexVolumes {
    fn draw_part(
        &self,
        scene: &SceneBuffers,
        pass: &mut VolumePass<'_>,
        part: Part,
        planned: usize,
        draw: &VolumeDraw<'_>,
    ) {
        let slice = scene.slice(pass.input, planned);
        let caps = if draw.without_bottom { 3 } else { 6 } * slice.place.triangle_count;
        if scene.pulled.is_some() {
            let count = match part {
                Part::Caps => caps,
                // Entry e needs entry e + 1; the last one is a separator.
                Part::Walls { .. } | Part::TurnedWalls => {
                    6 * slice.loop_index_count.saturating_sub(1)
                }
            };
            pass.draw(0..count, planned);
            return;
        }
        let (walls, turned) = (slice.loop_index_count, slice.turned_index_count);
        let first_wall = slice.place.first_loop_index;
        let (first, count) = match part {
            Part::Caps => (slice.place.first_triangle_index, caps),
            Part::Walls { .. } if draws_first_walls_twice(self.variant.layout, draw.state) => {
                (first_wall, walls - turned)
            }
            Part::Walls { .. } => (first_wall, walls),
            Part::TurnedWalls => (first_wall + walls - 2 * turned, turned),
        };
        let base_vertex = if scene.flags.is_some() {
            // Every region starts at the first flag, so its positions must start there too.
            let stride = 4 * self.variant.vertex_words() as u64;
            let first_byte = u64::from(slice.place.first_vertex) * stride;
            pass.raw
                .set_vertex_buffer(0, scene.vertices.slice(first_byte..));
            0
        } else {
            i32::try_from(slice.place.first_vertex).unwrap_or(i32::MAX)
        };
        pass.draw_indexed(first..first + count, base_vertex, planned);
    }
}
