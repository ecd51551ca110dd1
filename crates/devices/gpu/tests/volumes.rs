// SPDX-License-Identifier: MIT OR Apache-2.0
//! The executor of stencil programs on a volume that is no region's. Without a Vulkan device these
//! tests are skipped with the reason printed, unless `TERRAFILL_REQUIRE_DEVICE` is set, as
//! `ci/test.sh` does.

use std::collections::HashMap;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Picture};
use terrafill_fixtures::BoxOverGround;
use terrafill_fixtures::globe::SIZE;
use terrafill_gpu::{
    Gpu, HandedOn, RenderTargets, VolumeFill, VolumePass, VolumeShader, WgpuVolumes, open_for_test,
    vertex_layout,
};
use terrafill_plan::PixelRect;
use terrafill_stencil::{StencilExecutor, VolumeDraw, VolumeList, VolumeState};
use terrafill_variant::Switches;

/// A box, closed or not.
struct Boxes {
    shader: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    pipelines: HashMap<VolumeState, wgpu::RenderPipeline>,
}

impl Boxes {
    fn new(fill: &VolumeFill, scene: &BoxOverGround, faces: usize) -> Result<Self, DeviceError> {
        let gpu = fill.gpu();
        let (vertices, indices) = (scene.vertices(), BoxOverGround::indices(faces));
        let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
        Ok(Self {
            shader: gpu.shader("vertex/doubled.wgsl")?,
            layout: gpu.pipeline_layout("box", &[Some(fill.frame_layout())]),
            vertices: gpu.upload("corners", bytemuck::cast_slice(&vertices), vertex)?,
            indices: gpu.upload("faces", bytemuck::cast_slice(&indices), index)?,
            index_count: 6 * u32::try_from(faces).expect("six at most"),
            pipelines: HashMap::new(),
        })
    }
}

impl WgpuVolumes for Boxes {
    fn ensure(&mut self, gpu: &Gpu, _list: &VolumeList, draw: &VolumeDraw<'_>, blends: bool) {
        let attributes = wgpu::vertex_attr_array![0 => Sint32x3, 1 => Uint32];
        let shader = VolumeShader {
            module: &self.shader,
            layout: &self.layout,
            vertex_entry: match HandedOn::of(draw.state) {
                HandedOn::Nothing => "vertex_main",
                HandedOn::Colour => "coloured_main",
                HandedOn::Number => "numbered_main",
            },
            constants: &[],
            buffers: &[vertex_layout(&attributes)],
            strip_index_format: None,
            front_face: wgpu::FrontFace::Ccw,
            discards: false,
        };
        let pipeline = || shader.pipeline(gpu, draw.state, blends);
        self.pipelines.entry(draw.state).or_insert_with(pipeline);
    }

    fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
    }

    fn draw(&mut self, pass: &mut VolumePass<'_>, draw: &VolumeDraw<'_>, _blends: bool) {
        pass.raw.set_pipeline(&self.pipelines[&draw.state]);
        for &volume in draw.volumes {
            pass.cut(volume, draw.scissor);
            pass.draw_indexed(0..self.index_count, 0, volume);
        }
    }
}

fn drawn(
    gpu: &Arc<Gpu>,
    scene: &BoxOverGround,
    faces: usize,
    switches: &Switches,
    rect: PixelRect,
) -> Picture {
    let targets = RenderTargets::shared(gpu, SIZE).expect("small targets");
    let made: Result<VolumeFill, _> = StencilExecutor::<Boxes>::new(&targets, switches);
    let mut fill = made.expect("valid shaders");
    let mut boxes = Boxes::new(&fill, scene, faces).expect("fits");
    let early = fill.draw(&mut boxes).expect_err("nothing is loaded");
    assert_eq!(early.to_string(), "there is no stencil program yet");
    scene.draw(&mut fill, &mut boxes, switches, rect)
}

#[test]
fn a_box_marks_the_ground_inside_it_and_a_wrong_one_is_noticed() {
    let Some(gpu) = open_for_test(&Default::default()) else {
        return;
    };
    let scene = BoxOverGround::default();
    scene.check(|faces, switches, rect| drawn(&gpu, &scene, faces, switches, rect));
}
