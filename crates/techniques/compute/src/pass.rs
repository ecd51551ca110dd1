// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes as a frame makes and draws them: the compute pass, then one draw a volume.

use crate::culling::DRAW_ARGUMENTS_BYTES;
use crate::expansion::WORKGROUP_SIZE;
use crate::volumes::ComputeVolumes;
use terrafill_gpu::{Gpu, VolumePass, WgpuVolumes};
use terrafill_stencil::{VolumeDraw, VolumeList};

impl WgpuVolumes for ComputeVolumes {
    fn ensure(&mut self, gpu: &Gpu, _list: &VolumeList, draw: &VolumeDraw<'_>, _blends: bool) {
        self.pipelines.ensure(gpu, draw.state);
    }

    /// Decides what is drawn, then makes it.
    fn make(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        list: &VolumeList,
        constants: &wgpu::BindGroup,
    ) {
        let view = &self.view;
        if view.expanded.is_none() && view.culling.is_none() && view.placed.is_none() {
            return;
        }
        self.decided_draws.clear();
        let Some(scene) = &self.scene else {
            return;
        };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("expansion"),
            ..Default::default()
        });
        let (pipelines, view) = (&self.pipelines, &self.view);
        pass.set_bind_group(0, constants, &[]);
        pass.set_bind_group(1, &scene.bind_group, &[]);
        if let (Some(placed), Some(pipeline)) = (&view.placed, &pipelines.place) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(2, &placed.corners.bind_group, &[]);
            placed.corners.dispatch(&mut pass);
        }
        if let Some(expanded) = self.expanded() {
            pass.set_bind_group(2, &expanded.indices.bind_group, &[]);
        }
        if let (Some(culling), Some(pipeline)) = (&view.culling, &pipelines.cull) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(3, &culling.bind_group, &[]);
            let groups = list.volumes.len().div_ceil(WORKGROUP_SIZE);
            pass.dispatch_workgroups(u32::try_from(groups).unwrap_or(u32::MAX), 1, 1);
        }
        if let Some(expanded) = &view.expanded {
            pass.set_pipeline(&pipelines.expand);
            expanded.indices.dispatch(&mut pass);
        }
    }

    fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(scene) = &self.scene {
            pass.set_bind_group(1, &scene.bind_group, &[]);
        }
        if let Some(placed) = &self.view.placed {
            pass.set_vertex_buffer(0, placed.corners.buffer.slice(..));
        }
        if let Some(expanded) = self.expanded() {
            let indices = expanded.indices.buffer.slice(..);
            pass.set_index_buffer(indices, wgpu::IndexFormat::Uint32);
        }
    }

    fn draw(&mut self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, _blends: bool) {
        if let Some(pipeline) = self.pipelines.volume(draw.state) {
            pass.raw.set_pipeline(pipeline);
        }
        for &volume in draw.volumes {
            pass.cut(volume, draw.scissor);
            self.draw_volume(pass, volume, draw.without_bottom);
        }
    }
}

impl ComputeVolumes {
    /// One draw a volume, whose triangles lie in one piece, or one for each run of its parts. Where the device decided what is drawn,
    /// it is asked how much that is.
    fn draw_volume(&mut self, pass: &mut VolumePass<'_>, volume: usize, without_bottom: bool) {
        if let Some(culling) = &self.view.culling {
            let draw = 2 * volume + usize::from(without_bottom);
            pass.draw_as_decided(&culling.draws, draw as u64 * DRAW_ARGUMENTS_BYTES);
            self.decided_draws.push(draw);
            return;
        }
        let mesh = pass.list.volumes[volume].geometry;
        let Some(output) = self.output(volume, mesh) else {
            return;
        };
        for indices in output.drawn(self.drawn_parts.get(&mesh), without_bottom) {
            pass.draw_indexed(indices, self.base_vertex(volume), volume);
        }
    }
}
