// SPDX-License-Identifier: MIT OR Apache-2.0
//! `render`: one picture.

use crate::arguments::{RenderArguments, RenderBackend};
use crate::output::{check_paths, write_all};
use crate::{Failure, Outcome};
use image::{ExtendedColorType, ImageFormat};
use serde_json::json;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::Arc;
use terrafill_bench::open_scene;
use terrafill_core::{MeshOptions, RegionMesh};
use terrafill_frame::{
    Backend as _, BackendError, Frame, FrameInput, MemoryUse, PositionFormat, PreparedScene,
    SwitchError, Switches, VolumeBackend as _, paint,
};
use terrafill_gpu::{Gpu, GpuOptions, Stage};
use terrafill_reference::ReferenceBackend;
use terrafill_scene::{ImageSize, PlanOptions, Scene, SurfaceMesh, View, data_dir_from_env};
use terrafill_vertex::{Layout, VertexBackend, VertexVariant};

/// What one backend drew.
struct Drawn {
    rgb: Vec<u8>,
    frame: Frame,
    memory: Option<MemoryUse>,
    variant: String,
}

pub(crate) fn run(arguments: &RenderArguments) -> Result<Outcome, Failure> {
    let out = arguments.out.as_path();
    let others = [&arguments.ids, &arguments.stats];
    check_paths(std::iter::once(out).chain(others.into_iter().flatten().map(PathBuf::as_path)))?;
    let data = arguments.data.clone().or_else(data_dir_from_env);
    let scene = open_scene(&arguments.scene, data.as_deref()).map_err(Failure::bad_input)?;
    let view = find_view(&scene, &arguments.view)?;
    let (variant, mesh) = switches(&scene, arguments)?;
    let input = input(&scene, view, &mesh, arguments)?;
    let drawn = match arguments.backend {
        RenderBackend::Reference => draw_reference(&input)?,
        RenderBackend::Vertex => draw_vertex(&input, variant, arguments)?,
    };
    let colour = ExtendedColorType::Rgb8;
    let mut files = vec![(out, png(&drawn.rgb, input.size, colour)?)];
    if let Some(path) = &arguments.ids {
        files.push((path, ids_png(&drawn.frame)?));
    }
    if let Some(path) = &arguments.stats {
        let text = serde_json::to_string_pretty(&statistics(arguments, &input, &drawn))
            .map_err(Failure::bad_input)?;
        files.push((path, (text + "\n").into_bytes()));
    }
    write_all(&files)?;
    Ok(Outcome::Done)
}

fn find_view<'a>(scene: &'a Scene, name: &str) -> Result<&'a View, Failure> {
    let found = scene.views.iter().find(|view| view.name == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = scene.views.iter().map(|view| view.name.as_str()).collect();
        let allowed = names.join(", ");
        Failure::bad_input(format!("--view: found {name:?}, allowed: {allowed}"))
    })
}

fn switches(
    scene: &Scene,
    arguments: &RenderArguments,
) -> Result<(VertexVariant, MeshOptions), Failure> {
    let mut variant = VertexVariant {
        switches: Switches::for_overlap(scene.overlap),
        ..VertexVariant::default()
    };
    let mut mesh = scene.mesh;
    for switch in &arguments.variant {
        let refuse = |allowed: &str| {
            let message = format!("--variant: found {switch:?}, allowed: {allowed}");
            Err(Failure::bad_input(message))
        };
        if arguments.backend == RenderBackend::Reference {
            return refuse("none with --backend reference, which has one way only");
        }
        match switch.split_once('=').unwrap_or((switch, "")) {
            ("layout", "doubled") => variant.layout = Layout::Doubled,
            ("layout", "pulled") => variant.layout = Layout::Pulled,
            ("positions", "fixed") => variant.positions = PositionFormat::Fixed,
            ("positions", "local-f32") => variant.positions = PositionFormat::LocalF32,
            ("boundary-tolerance-m", value) => match value.parse() {
                Ok(metres) if metres > 0.0 && f64::is_finite(metres) => {
                    mesh.boundary_tolerance_m = metres;
                }
                _ => return refuse("boundary-tolerance-m=METRES, a number above 0"),
            },
            (key, value) => match variant.switches.set(key, value) {
                Ok(true) => {}
                Ok(false) => return refuse(ALLOWED_SWITCHES),
                Err(error) => return refuse(&format!("{key}={}", error.allowed)),
            },
        }
    }
    let conflict = |error: SwitchError| Failure::bad_input(format!("--variant: {error}"));
    variant.switches.check(scene.overlap).map_err(conflict)?;
    Ok((variant, mesh))
}

/// Switches of `render`, for a message.
const ALLOWED_SWITCHES: &str = "layout=doubled|pulled, positions=fixed|local-f32, \
    boundary-tolerance-m=METRES, bottom-cap=always|where-needed, \
    colour=xor|rectangle|volume|bit-planes|one-colour|one-colour-volumes, \
    cover-faces=both|culled, depth-rule=zfail|zpass|automatic, faces=two-sided|two-pass, \
    scissor=covers|volumes, stencil-clear=at-start|by-colour";

fn input(
    scene: &Scene,
    view: &View,
    mesh: &MeshOptions,
    arguments: &RenderArguments,
) -> Result<FrameInput, Failure> {
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, mesh)
        .map_err(|errors| {
            let lines: Vec<String> = errors
                .iter()
                .map(|error| format!("{}: {error}", arguments.scene))
                .collect();
            Failure::bad_input(lines.join("\n"))
        })?;
    let surface = Arc::new(SurfaceMesh::ellipsoid(&scene.body, scene.surface_rows));
    let prepared = PreparedScene::new(scene, meshes.into(), surface);
    let size = ImageSize {
        width: arguments.size.0,
        height: arguments.size.1,
    };
    Ok(FrameInput::new(
        &prepared,
        view,
        size,
        PlanOptions::default(),
    ))
}

fn draw_reference(input: &FrameInput) -> Result<Drawn, Failure> {
    let mut reference = ReferenceBackend::new();
    reference.prepare(input).map_err(Failure::bad_input)?;
    let frame = reference.render(input).map_err(Failure::bad_input)?;
    Ok(Drawn {
        rgb: paint(&frame),
        frame,
        memory: None,
        variant: String::new(),
    })
}

fn draw_vertex(
    input: &FrameInput,
    variant: VertexVariant,
    arguments: &RenderArguments,
) -> Result<Drawn, Failure> {
    let options = GpuOptions {
        adapter: arguments.adapter.clone(),
        ..GpuOptions::default()
    };
    let gpu = Gpu::open(&options).map_err(Failure::no_device)?;
    let draw = || -> Result<Drawn, BackendError> {
        let stage = Stage::shared(&gpu, input.size)?;
        let mut backend = VertexBackend::new(&stage, variant)?;
        let memory = backend.prepare(input)?;
        let frame = backend.render(input)?;
        let picture = backend.picture(input)?;
        let rgb = picture.rgba.chunks_exact(4).flat_map(|p| &p[..3]).copied();
        Ok(Drawn {
            rgb: rgb.collect(),
            frame,
            memory: Some(memory),
            variant: variant.name(),
        })
    };
    draw().map_err(|error| match error {
        BackendError::Unsupported { .. } | BackendError::DeviceLost(_) => Failure::no_device(error),
        _ => Failure::bad_input(error),
    })
}

fn statistics(arguments: &RenderArguments, input: &FrameInput, drawn: &Drawn) -> serde_json::Value {
    let left_out: Vec<_> = input
        .plan
        .left_out
        .iter()
        .map(|region| {
            let mesh = &input.scene.meshes[region.mesh];
            json!({ "index": mesh.region_index, "name": mesh.name, "reason": region.reason.name() })
        })
        .collect();
    let counters = drawn.frame.counters.map(|counters| {
        json!({
            "draws": counters.draws,
            "vertices": counters.vertices,
            "upload_bytes": counters.upload_bytes,
            "vertex_shader_invocations": counters.vertex_shader_invocations,
            "clipper_invocations": counters.clipper_invocations,
            "clipper_primitives_out": counters.clipper_primitives_out,
            "fragment_shader_invocations": counters.fragment_shader_invocations,
        })
    });
    let memory = drawn.memory.map(|memory| {
        json!({
            "buffers": memory.buffers,
            "vertex_bytes": memory.vertex_bytes,
            "index_bytes": memory.index_bytes,
            "constant_bytes": memory.constant_bytes,
            "geometry_bytes": memory.geometry_bytes(),
        })
    });
    json!({
        "scene": input.scene.name,
        "view": input.view,
        "backend": match arguments.backend {
            RenderBackend::Vertex => "vertex",
            RenderBackend::Reference => "reference",
        },
        "variant": drawn.variant,
        "width": input.size.width,
        "height": input.size.height,
        "filled_px": drawn.frame.filled_px(),
        "non_finite": drawn.frame.non_finite,
        "counters": counters,
        "memory": memory,
        "regions_drawn": input.plan.regions.len(),
        "left_out": left_out,
    })
}

fn ids_png(frame: &Frame) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    for &id in &frame.ids {
        let short = u16::try_from(id).map_err(|_| {
            Failure::bad_input(format!(
                "--ids: found region id {id}, allowed: up to 65535, as a 16-bit PNG holds"
            ))
        })?;
        bytes.extend(short.to_ne_bytes());
    }
    png(&bytes, frame.size, ExtendedColorType::L16)
}

fn png(bytes: &[u8], size: ImageSize, colour: ExtendedColorType) -> Result<Vec<u8>, Failure> {
    let mut encoded = Cursor::new(Vec::new());
    let (width, height) = (size.width, size.height);
    image::write_buffer_with_format(&mut encoded, bytes, width, height, colour, ImageFormat::Png)
        .map_err(Failure::bad_input)?;
    Ok(encoded.into_inner())
}
