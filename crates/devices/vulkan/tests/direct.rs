// SPDX-License-Identifier: MIT OR Apache-2.0
//! Passes by pipelines of the caller's own: what they draw, and what is refused.

use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, ids_of};
use terrafill_scene::ImageSize;
use terrafill_stencil::{RouteTexelFormat, RouteTexels};
use terrafill_vulkan::{
    Buffer, BufferUse, CapturePipeline, DirectDraw, DrawCall, DrawPipeline, GeometryOutput, Gpu,
    GpuOptions, Measured, PrimitiveStages, RenderTargets, Resource, Resources, SampledImage,
    Shader, StateStep, Topology, VertexFormat, open_for_test,
};

const GRID: &str = "pipelines/grid.wgsl";
const SIZE: ImageSize = ImageSize::new(64, 64);

/// Two by two cells over the whole picture, at one depth.
fn resources(gpu: &Arc<Gpu>) -> Arc<Resources> {
    let columns = [
        [1.0_f32, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0; 4],
        [-1.0, -1.0, 0.5, 1.0],
    ];
    let mut bytes = bytemuck::cast_slice(&columns).to_vec();
    bytes.extend_from_slice(bytemuck::cast_slice(&[2_u32, 0, 0, 0]));
    let constants = Buffer::upload(gpu, "constants", &bytes, BufferUse::Uniform).expect("fits");
    let texels = RouteTexels {
        format: RouteTexelFormat::R32Float,
        is_filtered: false,
        size: [3; 2],
        is_cube: false,
        bytes: vec![0; 36],
    };
    let heights = SampledImage::route(gpu, &texels).expect("an image");
    let resources = vec![
        Resource::Uniform(Arc::new(constants)),
        Resource::Image(Arc::new(heights)),
    ];
    Resources::new(gpu, resources).expect("bound")
}

fn wgsl(entry_point: &'static str) -> Shader {
    Shader::Wgsl {
        path: GRID,
        entry_point,
    }
}

fn stages(entry_point: &'static str, format: VertexFormat, topology: Topology) -> PrimitiveStages {
    PrimitiveStages::Vertices {
        vertex: wgsl(entry_point),
        geometry: None,
        format,
        topology,
    }
}

fn pipeline(gpu: &Arc<Gpu>, stages: PrimitiveStages) -> Result<DrawPipeline, DeviceError> {
    DrawPipeline::new(gpu, &resources(gpu), stages, wgsl("fragment_main"))
}

/// Numbers that the picture shows, and how many pixels show nothing.
fn shown(numbers: &[u32]) -> (Vec<u32>, usize) {
    let mut all: Vec<u32> = numbers
        .iter()
        .copied()
        .filter(|number| *number > 0)
        .collect();
    let nothing = numbers.len() - all.len();
    all.sort_unstable();
    all.dedup();
    (all, nothing)
}

#[test]
fn triangles_cover_what_they_cover_and_are_counted() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let triangles = stages("no_buffer", VertexFormat::Number, Topology::Triangles);
    let pipeline = pipeline(&gpu, triangles).expect("a pipeline");
    let mut targets = RenderTargets::new(&gpu, SIZE).expect("targets");
    let mut draw = |vertices: Range<u32>| {
        let draw = DirectDraw {
            pipeline: &pipeline,
            vertices: None,
            call: DrawCall::Vertices(std::slice::from_ref(&vertices)),
        };
        let drawn = targets.draw_directly(None, &draw, Measured::Statistics);
        let report = drawn.expect("drawn");
        (report, ids_of(&targets.read().expect("read")))
    };
    let (report, numbers) = draw(0..24);
    assert_eq!(shown(&numbers), ((1..=8).collect(), 0));
    if let Some(statistics) = report.statistics {
        assert_eq!(statistics.clipper_invocations, 8);
        assert!(statistics.vertex_shader_invocations <= 24);
    }
    // Negative control: half of them leave half of the picture.
    let (_, numbers) = draw(0..12);
    assert_eq!(shown(&numbers), ((1..=4).collect(), 32 * 64));
}

#[test]
fn points_have_a_pixel_each() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let points = stages("fetched_point", VertexFormat::Word, Topology::Points);
    let pipeline = pipeline(&gpu, points).expect("a pipeline");
    let numbers: [u32; 4] = [0, 1, 2, 3];
    let bytes = bytemuck::cast_slice(&numbers);
    let size = bytes.len() as u64;
    let streamed = Buffer::streamed(&gpu, "points", size, BufferUse::Vertex).expect("a buffer");
    streamed.stream(bytes).expect("written");
    let mut targets = RenderTargets::new(&gpu, SIZE).expect("targets");
    let range = 0..4;
    let draw = DirectDraw {
        pipeline: &pipeline,
        vertices: Some(&streamed),
        call: DrawCall::Vertices(std::slice::from_ref(&range)),
    };
    targets
        .draw_directly(None, &draw, Measured::Nothing)
        .expect("drawn");
    let numbers = ids_of(&targets.read().expect("read"));
    let (all, nothing) = shown(&numbers);
    // The middle of the picture is a corner of four pixels; the lower border's are outside or not.
    assert!(all.contains(&4) && all.len() <= 4, "{all:?}");
    assert!(nothing >= 64 * 64 - 4, "{nothing}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let points = stages("fetched_point", VertexFormat::Word, Topology::Points);
    let pipeline = pipeline(&gpu, points).expect("a pipeline");
    let mut targets = RenderTargets::new(&gpu, SIZE).expect("targets");
    let stored = Buffer::upload(&gpu, "points", &[0; 16], BufferUse::Vertex).expect("a buffer");
    let storage = Buffer::upload(&gpu, "storage", &[0; 16], BufferUse::Storage).expect("a buffer");
    let range = 0..4;
    let all = DrawCall::Vertices(std::slice::from_ref(&range));
    let mut draw = |vertices, call| {
        let draw = DirectDraw {
            pipeline: &pipeline,
            vertices,
            call,
        };
        targets
            .draw_directly(None, &draw, Measured::Nothing)
            .is_ok()
    };
    assert!(draw(Some(&stored), all));
    // Negative controls: no vertices, a buffer for something else, a mesh's call, arguments that are none.
    assert!(!draw(None, all));
    assert!(!draw(Some(&storage), all));
    assert!(!draw(Some(&stored), DrawCall::MeshGroups([1, 1])));
    assert!(!draw(Some(&stored), DrawCall::Indirect(&storage)));
    // A buffer in device memory is not mapped, and a streamed one takes no more than it has.
    assert!(stored.stream(&[0; 4]).is_err());
    let streamed = Buffer::streamed(&gpu, "points", 4, BufferUse::Vertex).expect("a buffer");
    assert!(streamed.stream(&[0; 4]).is_ok());
    let error = streamed.stream(&[0; 8]).expect_err("too many");
    assert!(matches!(
        error,
        DeviceError::OverCapacity {
            found: 8,
            allowed: 4,
            ..
        }
    ));
}

#[test]
fn what_is_captured_before_a_draw_is_kept_where_it_may_be() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    if !gpu.facts.features.transform_feedback {
        return;
    }
    let points = stages("fetched_point", VertexFormat::Word, Topology::Points);
    let pipeline = pipeline(&gpu, points).expect("a pipeline");
    let mut targets = RenderTargets::new(&gpu, SIZE).expect("targets");
    let stored = Buffer::upload(&gpu, "points", &[0; 16], BufferUse::Vertex).expect("a buffer");
    let numbers = |numbers: &[f32], use_for| {
        let bytes = bytemuck::cast_slice(numbers);
        Buffer::upload(&gpu, "numbers", bytes, use_for).expect("a buffer")
    };
    let storage = |of: &[f32]| Resource::Storage(Arc::new(numbers(of, BufferUse::Storage)));
    // A dent that moves its middle by 2 along x.
    let dent = [1.0, 1.0, 1.0, 0.5, 2.0, 0.0, 0.0, 0.0];
    let bound = vec![
        Resource::Uniform(Arc::new(numbers(&[0.0; 20], BufferUse::Uniform))),
        storage(&[1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 1.0]),
        storage(&dent),
    ];
    let bound = Resources::new(&gpu, bound).expect("bound");
    let capture = CapturePipeline::new(&gpu, &bound, "native/deform.spv").expect("a pipeline");
    let range = 0..4;
    let draw = DirectDraw {
        pipeline: &pipeline,
        vertices: Some(&stored),
        call: DrawCall::Vertices(std::slice::from_ref(&range)),
    };
    let mut captured = |into: &Buffer| {
        let step = StateStep::Capture {
            pipeline: &capture,
            into,
            vertices: 2,
        };
        targets.draw_after(&[step], &draw, Measured::Nothing)
    };
    let kept = numbers(&[0.0; 8], BufferUse::State);
    captured(&kept).expect("drawn");
    let bytes = kept.contents(&gpu).expect("readable");
    let found: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
    assert_eq!(found, [3.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 1.0]);
    // Negative control: a buffer for something else.
    assert!(captured(&numbers(&[0.0; 8], BufferUse::Storage)).is_err());
}

#[test]
fn a_geometry_shader_beyond_the_limits_is_refused_with_them() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    if !gpu.facts.features.geometry_shader {
        return;
    }
    let of = |vertices, components| {
        let stages = PrimitiveStages::Vertices {
            vertex: wgsl("numbered_point"),
            geometry: Some(GeometryOutput {
                name: "native/grid.cell1.spv",
                vertices,
                components,
            }),
            format: VertexFormat::Word,
            topology: Topology::Points,
        };
        pipeline(&gpu, stages)
    };
    of(4, 5).expect("within every limit");
    for (vertices, components, what) in [(1 << 20, 1, "vertices"), (64, 1 << 20, "components")] {
        let error = of(vertices, components).expect_err("beyond every limit");
        assert!(error.to_string().contains(what), "{error}");
    }
}
