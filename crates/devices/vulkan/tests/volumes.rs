// SPDX-License-Identifier: MIT OR Apache-2.0
//! The executor of stencil programs on a volume that is no region's. Without a Vulkan device these
//! tests are skipped with the reason printed, unless `TERRAFILL_REQUIRE_DEVICE` is set, as
//! `ci/test.sh` does.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Picture};
use terrafill_fixtures::BoxOverGround;
use terrafill_fixtures::globe::SIZE;
use terrafill_plan::PixelRect;
use terrafill_stencil::{StencilExecutor, VolumeDraw, VolumeState};
use terrafill_variant::Switches;
use terrafill_vulkan::{
    Buffer, BufferUse, Geometry, Gpu, IndexWidth, Pipeline, PipelineDescriptor, RenderTargets,
    VertexFormat, VolumeFill, VolumePass, VulkanVolumes, open_for_test,
};

/// A box, closed or not.
struct Boxes {
    vertices: Buffer,
    indices: Buffer,
    index_count: u32,
    pipelines: HashMap<VolumeState, Pipeline>,
}

impl Boxes {
    fn new(gpu: &Arc<Gpu>, scene: &BoxOverGround, faces: usize) -> Result<Self, DeviceError> {
        let (vertices, indices) = (scene.vertices(), BoxOverGround::indices(faces));
        let upload = |label, bytes, use_for| Buffer::upload(gpu, label, bytes, use_for);
        Ok(Self {
            vertices: upload(
                "corners",
                bytemuck::cast_slice(&vertices),
                BufferUse::Vertex,
            )?,
            indices: upload("faces", bytemuck::cast_slice(&indices), BufferUse::Index)?,
            index_count: 6 * u32::try_from(faces).expect("six at most"),
            pipelines: HashMap::new(),
        })
    }
}

impl VulkanVolumes for Boxes {
    fn ensure(&mut self, gpu: &Arc<Gpu>, draw: &VolumeDraw<'_>) -> Result<(), DeviceError> {
        if let Entry::Vacant(place) = self.pipelines.entry(draw.state) {
            let (path, format) = ("vertex/doubled.wgsl", VertexFormat::FixedAndFlag);
            let descriptor = PipelineDescriptor::of_volumes(path, format, draw.state);
            place.insert(Pipeline::new(gpu, descriptor)?);
        }
        Ok(())
    }

    fn draw<'a>(&'a self, pass: &mut VolumePass<'a, '_, '_>, draw: &VolumeDraw<'_>) {
        let geometry = Geometry {
            vertices: &self.vertices,
            indices: &self.indices,
            width: IndexWidth::Short,
        };
        let pipeline = &self.pipelines[&draw.state];
        for &volume in draw.volumes {
            pass.cut(volume, draw.scissor);
            pass.draw_indexed(pipeline, geometry, 0..self.index_count, 0, volume);
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
    let mut fill = made.expect("has the features");
    let mut boxes = Boxes::new(gpu, scene, faces).expect("fits");
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
