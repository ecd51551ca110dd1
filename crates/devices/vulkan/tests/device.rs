// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tests that need a Vulkan device. Without one they are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use std::sync::Arc;
use terrafill_contract::{AddressMode, DeviceError};
use terrafill_fixtures::globe::{SIZE, assert_depth_of_the_ellipsoid, globe_from};
use terrafill_plan::PixelRect;
use terrafill_scene::{ImageSize, MipChain};
use terrafill_stencil::{
    CoverLook, CoverOverrides, CoverPurpose, DepthRule, FaceSet, RouteTexelFormat, RouteTexels,
    StencilOperation, StencilRule, StencilTest, TexturedRegion, VolumeConstants, VolumeState,
};
use terrafill_variant::FirstPass;
use terrafill_vulkan::{
    BindGroup, Buffer, BufferUse, CoverState, DepthBindings, DrawState, Geometry, Gpu, GpuOptions,
    ImageBindings, IndexWidth, Measured, POSITIVE_CONTROL, Pipeline, PipelineDescriptor,
    PipelineState, RenderTargets, RouteText, SampledImage, TexturedDescriptor, TexturedParts,
    TexturedPipeline, TexturedPlacement, VertexFormat, list_adapters, make_deliberate_error,
    open_for_test, validation_log,
};

/// A targets with the globe drawn on it.
fn drawn(gpu: &Arc<Gpu>) -> RenderTargets {
    let mut targets = RenderTargets::new(gpu, SIZE).expect("small targets");
    targets.prepare(&globe_from(8e6)).expect("fits");
    targets.draw_surface().expect("draws");
    targets
}

#[test]
fn a_deliberate_error_is_reported_when_validation_is_on() {
    let options = GpuOptions {
        validation: true,
        ..GpuOptions::default()
    };
    let Some(gpu) = open_for_test(&options) else {
        return;
    };
    let log = validation_log();
    assert!(!log.has(POSITIVE_CONTROL));
    make_deliberate_error(&gpu);
    assert!(
        log.has(POSITIVE_CONTROL),
        "the validation layer is not at work: {:?}",
        log.after(0)
    );
}

#[test]
fn an_adapter_is_opened_by_part_of_its_name_and_an_unknown_one_refused() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let all = list_adapters().expect("there is a loader");
    assert_eq!(all.first(), Some(&gpu.facts), "the first is the default");
    let part = gpu.facts.name.to_uppercase();
    let by_name = GpuOptions {
        adapter: Some(part),
        ..GpuOptions::default()
    };
    assert_eq!(Gpu::open(&by_name).expect("the same").facts, gpu.facts);
    let unknown = GpuOptions {
        adapter: Some("no such adapter".to_owned()),
        ..GpuOptions::default()
    };
    let error = Gpu::open(&unknown).expect_err("unknown");
    assert!(error.to_string().contains(&gpu.facts.name), "{error}");
}

#[test]
fn the_surface_has_the_depth_of_the_ellipsoid() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let mut targets = RenderTargets::new(&gpu, SIZE).expect("small targets");
    assert!(targets.read().is_err(), "nothing is drawn yet");
    assert!(targets.draw_surface().is_err(), "nothing is prepared yet");
    targets.prepare(&globe_from(8e6)).expect("fits");
    let time = targets.draw_surface().expect("draws");
    assert_eq!(time.is_some(), gpu.facts.features.timestamps);
    let picture = targets.read().expect("reads");
    assert_depth_of_the_ellipsoid(&picture);
}

#[test]
fn a_stage_refuses_an_input_of_another_size_and_a_size_no_device_has() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let small = ImageSize::new(10, 10);
    let mut targets = RenderTargets::new(&gpu, small).expect("small targets");
    let error = targets.prepare(&globe_from(8e6)).expect_err("another size");
    assert!(error.to_string().contains("image size differs"), "{error}");
    for (width, height) in [(1 << 20, 10), (0, 1)] {
        let error =
            RenderTargets::new(&gpu, ImageSize { width, height }).expect_err("no such size");
        let size = format!("{width} × {height} pixels");
        assert!(error.to_string().contains(&size), "{error}");
    }
}

#[test]
fn buffers_have_the_size_asked_for_and_give_their_memory_back() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let (made, allocated) = (gpu.work_done(), gpu.allocated_bytes());
    let upload = |bytes: &[u8]| Buffer::upload(&gpu, "test", bytes, BufferUse::Vertex);
    let buffers = [upload(&[]), upload(&[1, 2, 3]), upload(&[7; 1001])].map(|b| b.expect("fits"));
    assert_eq!(buffers.each_ref().map(Buffer::size), [4, 4, 1001]);
    let sum: u64 = buffers.iter().map(Buffer::allocated_bytes).sum();
    assert_eq!(gpu.allocated_bytes() - allocated, sum);
    let now = gpu.work_done() - made;
    assert_eq!(
        (now.buffer_creations, now.uploads, now.upload_bytes),
        (3, 2, 1004)
    );
    let too_much = buffers[2].rewrite(0, &[0; 1004]).expect_err("larger");
    assert!(too_much.to_string().contains("found 1004, allowed 1001"));
    assert!(buffers[2].rewrite(0, &[0; 3]).is_err(), "no whole word");
    assert!(buffers[2].rewrite(2, &[0; 4]).is_err(), "no whole word");
    assert!(
        buffers[2].rewrite(4, &[0; 1000]).is_err(),
        "one word behind"
    );
    buffers[2].rewrite(0, &[0; 1000]).expect("fits");
    let parts: [(u64, &[u8]); 3] = [(1, &[7; 5]), (4, &[]), (998, &[8; 2])];
    buffers[2].rewrite_parts(&parts).expect("they fit");
    let beyond: [(u64, &[u8]); 2] = [(0, &[7; 4]), (998, &[8; 4])];
    assert!(buffers[2].rewrite_parts(&beyond).is_err(), "a byte behind");
    drop(buffers);
    assert_eq!(gpu.allocated_bytes(), allocated);
}

/// Everything a cover of the whole screen needs.
struct Cover {
    pipeline: Pipeline,
    bindings: BindGroup,
}

const EVERYWHERE: StencilTest = StencilTest {
    read_mask: 0xff,
    ..StencilTest::ANYWHERE
};

fn cover_descriptor(test: StencilTest) -> PipelineDescriptor {
    let state = PipelineState::Volumes(VolumeState::Colour {
        is_before_surface: false,
        test,
        faces: FaceSet::Both,
    });
    PipelineDescriptor::of_shader("vertex/cover.wgsl", VertexFormat::Number, state)
}

fn cover(gpu: &Arc<Gpu>, targets: &RenderTargets) -> Cover {
    let mut constants: VolumeConstants = bytemuck::Zeroable::zeroed();
    constants.colour = [1.0, 0.0, 0.0, 1.0];
    let bytes = bytemuck::bytes_of(&constants);
    let regions = Buffer::upload(gpu, "regions", bytes, BufferUse::Storage).expect("fits");
    let view = targets.view_constants().expect("prepared");
    Cover {
        pipeline: Pipeline::new(gpu, cover_descriptor(EVERYWHERE)).expect("valid"),
        bindings: BindGroup::new(gpu, view, Some(&Arc::new(regions))).expect("fits"),
    }
}

#[test]
fn a_cover_stays_inside_its_scissor_and_is_counted() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let targets = drawn(&gpu);
    let cover = cover(&gpu, &targets);
    let state = DrawState {
        pipeline: &cover.pipeline,
        bindings: &cover.bindings,
        geometry: None,
    };
    // Reaches past the image, which is 101 × 67.
    let rect = PixelRect {
        left: 90,
        top: 60,
        right: 200,
        bottom: 100,
    };
    for measured in [
        Measured::Nothing,
        Measured::Times,
        Measured::Statistics,
        Measured::Samples,
    ] {
        let report = targets
            .fill(1, measured, |recorder| {
                recorder.pass(true, true, |pass| {
                    pass.scissor(rect);
                    pass.draw(&state, 3, 0);
                });
            })
            .expect("draws");
        let features = gpu.facts.features;
        let is_timed = measured == Measured::Times && features.timestamps;
        assert_eq!(report.times.fill_gpu_ms.is_some(), is_timed, "{measured:?}");
        assert_eq!(report.times.colour_gpu_ms, None, "one pass alone");
        let counts = measured == Measured::Statistics && features.pipeline_statistics;
        assert_eq!(report.statistics.is_some(), counts);
        if let Some(statistics) = report.statistics {
            assert_eq!(statistics.vertex_shader_invocations, 3);
            assert!(statistics.fragment_shader_invocations >= 77);
        }
        let samples = (measured == Measured::Samples).then_some(11 * 7);
        assert_eq!(report.samples, samples);
    }
    let picture = targets.read().expect("reads");
    let red = picture
        .rgba
        .chunks_exact(4)
        .enumerate()
        .filter(|(_, pixel)| *pixel == [255, 0, 0, 255]);
    let inside = |index: usize| {
        let (column, row) = (index % SIZE.width as usize, index / SIZE.width as usize);
        column >= 90 && row >= 60
    };
    let indices: Vec<usize> = red.map(|(index, _)| index).collect();
    assert_eq!(indices.len(), 11 * 7);
    assert!(indices.into_iter().all(inside), "row 0 is at the top");
    assert!(
        picture.depth.iter().any(|&depth| depth > 0.0),
        "depth survives"
    );
}

#[test]
fn a_draw_that_does_not_fit_is_refused_and_nothing_is_drawn() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let targets = drawn(&gpu);
    let before = targets.read().expect("reads").rgba;
    let cover = cover(&gpu, &targets);
    let mark = StencilRule {
        depth: DepthRule::Fail,
        operation: StencilOperation::Count,
        faces: FaceSet::Both,
    };
    let marked = VolumeState::Mark {
        rule: mark,
        has_colour: false,
        first_pass: FirstPass::Stencil,
    };
    let (path, format) = ("vertex/doubled.wgsl", VertexFormat::FixedAndFlag);
    let volumes = PipelineDescriptor::of_volumes(path, format, marked);
    let volumes = Pipeline::new(&gpu, volumes).expect("valid");
    let buffer = |use_for| Buffer::upload(&gpu, "test", &[0; 64], use_for).expect("fits");
    let (vertices, indices) = (buffer(BufferUse::Vertex), buffer(BufferUse::Index));
    let state = |pipeline, geometry| DrawState {
        pipeline,
        bindings: &cover.bindings,
        geometry,
    };
    let geometry = |vertices, indices| {
        Some(Geometry {
            vertices,
            indices,
            width: IndexWidth::Short,
        })
    };
    let right = state(&volumes, geometry(&vertices, &indices));
    // What is drawn, in a pass with or without colour, with how many indices, and what it says.
    let cases = [
        (right, false, 32, ""),
        (right, false, 33, "bytes of indices"),
        (right, true, 3, "another kind of pass"),
        (state(&volumes, None), false, 3, "without indices"),
        (
            state(&volumes, geometry(&indices, &indices)),
            false,
            3,
            "vertices of another device or made for another use",
        ),
        (
            state(&volumes, geometry(&vertices, &vertices)),
            false,
            3,
            "indices of another device or made for another use",
        ),
        (
            state(&cover.pipeline, geometry(&vertices, &indices)),
            false,
            3,
            "another kind of pass",
        ),
    ];
    for (state, has_colour, count, words) in cases {
        let outcome = targets.fill(1, Measured::Nothing, |recorder| {
            recorder.pass(true, has_colour, |pass| {
                pass.draw_indexed(&state, 0, count, 0, 0);
            });
        });
        match outcome {
            Ok(_) => assert_eq!(words, "", "{words} was not noticed"),
            Err(error) => {
                assert!(!words.is_empty(), "{error}");
                assert!(error.to_string().contains(words), "{error}");
            }
        }
    }
    let without_vertices = targets.fill(1, Measured::Nothing, |recorder| {
        recorder.pass(true, false, |pass| {
            pass.draw(&state(&volumes, None), 3, 0);
        });
    });
    assert!(without_vertices.is_err());
    let other = drawn(&gpu);
    if let Ok(numbers) = other.numbers() {
        let refused = targets.fill(1, Measured::Nothing, |recorder| {
            recorder.accumulate(&numbers, |_| {});
        });
        let error = refused.expect_err("numbers beside other targets");
        assert!(error.to_string().contains("numbers"), "{error}");
    }
    let copy = other.depth_copy().expect("small");
    let refused = targets.fill(1, Measured::Nothing, |recorder| recorder.copy_depth(&copy));
    let error = refused.expect_err("a copy of other targets' depth");
    assert!(error.to_string().contains("depth"), "{error}");
    // Negative control: beside its own targets it is recorded.
    let copied = other.fill(1, Measured::Nothing, |recorder| recorder.copy_depth(&copy));
    copied.expect("its own depth");
    let (path, format) = ("vertex/resolve.wgsl", VertexFormat::Number);
    let resolve = PipelineDescriptor::of_shader(path, format, PipelineState::Resolve);
    let resolve = Pipeline::new(&gpu, resolve).expect("valid");
    let unwritten = targets.fill(1, Measured::Nothing, |recorder| {
        recorder.pass(false, true, |pass| pass.draw(&state(&resolve, None), 3, 0));
    });
    assert!(unwritten.is_err(), "numbers that no pass has written");
    let bounds = targets.fill(1, Measured::Nothing, |recorder| {
        recorder.pass(true, false, |pass| pass.depth_bounds(0.5, 0.25));
    });
    assert!(bounds.is_err());
    assert_eq!(targets.read().expect("reads").rgba, before);
}

#[test]
fn what_the_device_lacks_is_named() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let bounded = PipelineDescriptor {
        depth_bounds: true,
        ..cover_descriptor(EVERYWHERE)
    };
    match Pipeline::new(&gpu, bounded) {
        Ok(_) => assert!(gpu.facts.features.depth_bounds),
        Err(DeviceError::Unsupported {
            capability,
            adapter,
        }) => {
            assert!(!gpu.facts.features.depth_bounds);
            assert_eq!(
                (capability.as_str(), &adapter),
                ("depthBounds", &gpu.facts.name)
            );
        }
        Err(other) => panic!("{other}"),
    }
    let mut missing = cover_descriptor(EVERYWHERE);
    missing.vertex.path = "vertex/nothing.wgsl";
    let error = Pipeline::new(&gpu, missing).expect_err("no such shader");
    assert!(matches!(error, DeviceError::Shader { .. }), "{error}");
}

#[test]
fn two_devices_do_not_mix() {
    let (Some(gpu), Some(other)) = (
        open_for_test(&GpuOptions::default()),
        open_for_test(&GpuOptions::default()),
    ) else {
        return;
    };
    let (targets, foreign) = (drawn(&gpu), drawn(&other));
    let view = foreign.view_constants().expect("prepared");
    assert!(BindGroup::new(&gpu, view, None).is_err());
    let cover = cover(&other, &foreign);
    let state = DrawState {
        pipeline: &cover.pipeline,
        bindings: &cover.bindings,
        geometry: None,
    };
    let outcome = targets.fill(1, Measured::Nothing, |recorder| {
        recorder.pass(false, true, |pass| pass.draw(&state, 3, 0));
    });
    assert!(outcome.is_err());
}

/// A textured cover whose place in the picture is the pixel's own, times the constants' u and v.
fn pixel_parts() -> TexturedParts {
    TexturedParts {
        position: RouteText {
            wgsl: "struct PositionConstants { c0: vec4f }\n\
                   fn fragment_offset(pixel: vec2f, depth: f32, constants: PositionConstants) -> \
                   vec3f { return vec3f(depth, pixel); }"
                .to_owned(),
            constants: 1,
        },
        route: RouteText {
            wgsl: "struct RouteConstants { c0: vec4f }\n\
                   fn route_angles(d: vec3f, constants: RouteConstants) -> vec2f { return d.yz; }"
                .to_owned(),
            constants: 0,
        },
        placement: TexturedPlacement::Affine,
    }
}

/// Constants of regions with these ids, and how far one is from the next.
fn textured_regions(gpu: &Gpu, ids: &[f32]) -> (Vec<u8>, usize) {
    let needed = size_of::<TexturedRegion>() + 32;
    let stride = needed.next_multiple_of(DepthBindings::alignment(gpu));
    let mut bytes = Vec::new();
    for &id in ids {
        let mut region: TexturedRegion = bytemuck::Zeroable::zeroed();
        region.id = id;
        region.u = [0.25, 0.0, 3.0];
        region.v = [0.0, 0.5, 0.0];
        bytes.extend_from_slice(bytemuck::bytes_of(&region));
        bytes.resize(bytes.len().next_multiple_of(stride), 0);
    }
    (bytes, stride)
}

#[test]
fn the_probe_finds_every_pixel_of_the_surface_and_none_of_the_sky() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let allocated = gpu.allocated_bytes();
    let targets = drawn(&gpu);
    let plain = cover(&gpu, &targets);
    let (bytes, stride) = textured_regions(&gpu, &[7.0, 9.0]);
    let upload = |use_for| Buffer::upload(&gpu, "regions", &bytes, use_for).map(Arc::new);
    let regions = upload(BufferUse::Constants).expect("fits");
    let depth = targets.bind_depth(&regions, stride).expect("fits");
    let out_of_step = targets.bind_depth(&regions, stride + 4);
    assert!(out_of_step.is_err(), "constants out of step");
    let wrong_use = upload(BufferUse::Storage).expect("fits");
    assert!(targets.bind_depth(&wrong_use, stride).is_err());
    let picture = MipChain::new(2, 2, vec![255; 16]).expect("four texels");
    let image = Arc::new(SampledImage::picture(&gpu, &picture).expect("fits"));
    assert_eq!(image.bytes(), picture.bytes());
    let repeat = [AddressMode::Repeat; 2];
    let picture = ImageBindings::picture(&image, repeat).expect("fits");
    let parts = pixel_parts();
    let pipeline = |test, look| {
        let descriptor = TexturedDescriptor {
            parts: &parts,
            table_is_sampled: None,
            test,
            look,
        };
        TexturedPipeline::new(&gpu, &descriptor)
    };
    let probe = CoverLook {
        purpose: CoverPurpose::Probe,
        overrides: CoverOverrides::default(),
        blends: false,
    };
    let probing = pipeline(EVERYWHERE, probe).expect("valid");
    let zeroing = StencilTest {
        zeroes: true,
        ..EVERYWHERE
    };
    let error = pipeline(zeroing, probe).expect_err("depth and stencil are read");
    assert!(error.to_string().contains("writes the stencil"), "{error}");
    let state = CoverState {
        pipeline: &probing,
        bindings: &plain.bindings,
        depth: &depth,
        picture: &picture,
        table: None,
    };
    let probe = targets.probe().expect("fits");
    assert_eq!(probe.read().expect("reads"), None, "nothing is drawn yet");
    let right = PixelRect {
        left: 50,
        top: 0,
        right: SIZE.width,
        bottom: SIZE.height,
    };
    // The second pass adds to what the first has cleared.
    let drawn_into = targets.fill(2, Measured::Nothing, |recorder| {
        recorder.probe(&probe, |pass| pass.cover(&state, 0));
        recorder.probe(&probe, |pass| {
            pass.scissor(right);
            pass.cover(&state, 1);
        });
    });
    drawn_into.expect("draws");
    let [places, sizes] = probe.read().expect("reads").expect("drawn");
    let depths = targets.read().expect("reads").depth;
    let (mut on_surface, mut in_sky) = (0, 0);
    for (index, (place, depth)) in places.iter().zip(&depths).enumerate() {
        let (x, y) = (index % SIZE.width as usize, index / SIZE.width as usize);
        if *depth > 0.0 {
            on_surface += 1;
            let id = if x < 50 { 7.0 } else { 9.0 };
            let uv = [x, y].map(|at| at as f32 + 0.5);
            assert_eq!((place[0], place[1]), (0.25 * uv[0] + 3.0, 0.5 * uv[1]));
            assert_eq!(place[3], id, "{x} {y}");
            assert!(sizes[index][2] > 0.0, "a distance");
        } else {
            in_sky += 1;
            assert_eq!(*place, [0.0; 4], "{x} {y}");
        }
    }
    assert!(on_surface > 500 && in_sky > 500, "{on_surface} {in_sky}");

    // What does not fit is refused.
    let other_stage = drawn(&gpu);
    let other_probe = other_stage.probe().expect("fits");
    let error = targets.fill(1, Measured::Nothing, |recorder| {
        recorder.probe(&other_probe, |_| {});
    });
    assert!(error.is_err(), "a probe of other targets");
    let error = targets.fill(1, Measured::Nothing, |recorder| {
        recorder.textured(|pass| pass.cover(&state, 0));
    });
    assert!(error.is_err(), "a probing cover in a pass for colours");
    let error = targets.fill(1, Measured::Nothing, |recorder| {
        recorder.probe(&probe, |pass| pass.cover(&state, 2));
    });
    assert!(error.is_err(), "a region beyond the last");
    let error = other_stage.fill(1, Measured::Nothing, |recorder| {
        recorder.probe(&other_probe, |pass| pass.cover(&state, 0));
    });
    assert!(error.is_err(), "the depth of other targets");
    let with_table = CoverState {
        table: Some(&picture),
        ..state
    };
    let error = targets.fill(1, Measured::Nothing, |recorder| {
        recorder.probe(&probe, |pass| pass.cover(&with_table, 0));
    });
    assert!(error.is_err(), "a table that the route does not read");
    drop((probe, other_probe, other_stage, depth, regions, wrong_use));
    drop((picture, image, probing, plain, targets));
    assert_eq!(gpu.allocated_bytes(), allocated);
}

#[test]
fn a_picture_that_no_device_holds_is_refused() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let route = |width| RouteTexels {
        format: RouteTexelFormat::R8Unorm,
        is_filtered: false,
        size: [width, 1],
        is_cube: false,
        bytes: vec![7; width as usize],
    };
    assert_eq!(
        SampledImage::route(&gpu, &route(64)).expect("fits").bytes(),
        64
    );
    let error = SampledImage::route(&gpu, &route(1 << 20)).expect_err("too wide");
    assert!(error.to_string().contains("found 1048576"), "{error}");
}
