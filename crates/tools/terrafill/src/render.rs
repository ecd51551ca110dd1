// SPDX-License-Identifier: MIT OR Apache-2.0
//! `render`: one picture.

use crate::arguments::RenderArguments;
use crate::output::{check_paths, write_all};
use crate::registry::SURFACES;
use crate::{Failure, Outcome};
use image::{ExtendedColorType, ImageFormat};
use serde_json::json;
use std::io::Cursor;
use std::path::PathBuf;
use terrafill_core::{MeshError, MeshOptions, RegionMesh};
use terrafill_fill::{
    DeviceError, Frame, FrameInput, MemoryUse, PreparedScene, SwitchError, paint,
};
use terrafill_filling::{Technique, open_scene};
use terrafill_reference::ReferenceBackend;
use terrafill_scene::{ImageSize, LeveledMeshes, PlanOptions, Scene, View, data_dir_from_env};
use terrafill_surface::open_surface;
use terrafill_vertex::{CACHE_SIZE, IndexOrder, acmr, cache_ordered};

/// What one backend drew.
struct Drawn {
    rgb: Vec<u8>,
    frame: Frame,
    memory: Option<MemoryUse>,
    variant: String,
    /// What the backend settled that people should know.
    note: Option<String>,
    /// Transformed vertices per triangle of the caps, through a cache of [`CACHE_SIZE`]; of the
    /// vertex backend, the only one that orders triangles for it.
    cap_acmr: Option<f64>,
}

pub(crate) fn run(arguments: &RenderArguments) -> Result<Outcome, Failure> {
    let out = arguments.out.as_path();
    let others = [&arguments.ids, &arguments.stats];
    check_paths(std::iter::once(out).chain(others.into_iter().flatten().map(PathBuf::as_path)))?;
    let data = arguments.data.clone().or_else(data_dir_from_env);
    let scene = open_scene(&arguments.scene, data.as_deref()).map_err(Failure::bad_input)?;
    let view = find_view(&scene, &arguments.view)?;
    let wanted = wanted(&scene, arguments)?;
    let input = input(&scene, view, &wanted, arguments)?;
    let drawn = match &wanted.technique {
        None => draw_reference(&input, wanted.is_textured)?,
        Some(technique) => draw(&input, technique, arguments)?,
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

/// What `--backend` and `--variant` ask for.
struct Wanted {
    /// `None`: the reference.
    technique: Option<Technique>,
    mesh: MeshOptions,
    plan: PlanOptions,
    /// Whether the reference fills with the scene's texture.
    is_textured: bool,
}

fn wanted(scene: &Scene, arguments: &RenderArguments) -> Result<Wanted, Failure> {
    let mut wanted = Wanted {
        technique: Technique::main(arguments.backend.name(), scene.overlap),
        mesh: scene.mesh,
        plan: PlanOptions::default(),
        is_textured: false,
    };
    for switch in &arguments.variant {
        let refuse = |allowed: &str| {
            let message = format!("--variant: found {switch:?}, allowed: {allowed}");
            Failure::bad_input(message)
        };
        let (key, value) = switch.split_once('=').unwrap_or((switch, ""));
        if wanted.technique.is_none() {
            wanted
                .set_reference(scene, key, value)
                .map_err(|allowed| refuse(&allowed))?;
            continue;
        }
        if wanted.set_input(key, value).map_err(refuse)? {
            continue;
        }
        let Some(technique) = &mut wanted.technique else {
            continue;
        };
        match technique.set(key, value) {
            Ok(true) => {}
            Ok(false) => return Err(refuse(&allowed_switches(technique))),
            Err(error) => return Err(refuse(&format!("{key}={}", error.allowed))),
        }
    }
    let conflict = |error: SwitchError| Failure::bad_input(format!("--variant: {error}"));
    if let Some(technique) = &wanted.technique {
        technique.check(scene.overlap).map_err(conflict)?;
    }
    Ok(wanted)
}

impl Wanted {
    /// Sets a switch of the reference, which fills with or without texture and has no other.
    fn set_reference(&mut self, scene: &Scene, key: &str, value: &str) -> Result<(), String> {
        let has_texture = scene.texture.is_some();
        self.is_textured = match (key, value) {
            ("texture", "on") if has_texture => true,
            ("texture", "off") => false,
            _ if has_texture => return Err("texture=on|off with --backend reference".to_owned()),
            _ => {
                let scene = &scene.name;
                return Err(format!(
                    "none with --backend reference and scene {scene}, which has no texture"
                ));
            }
        };
        Ok(())
    }

    /// Sets a switch of what goes into every backend; `Ok(false)` when there is no such switch, and
    /// what is allowed when the value is none of the switch's.
    fn set_input(&mut self, key: &str, value: &str) -> Result<bool, &'static str> {
        let above_zero = || value.parse().ok().filter(|&v| v > 0.0 && f64::is_finite(v));
        let plan = &mut self.plan;
        match key {
            "boundary-tolerance-m" => {
                let allowed = "boundary-tolerance-m=METRES, a number above 0";
                self.mesh.boundary_tolerance_m = above_zero().ok_or(allowed)?;
            }
            "boundary-lod-px" => {
                let allowed = "boundary-lod-px=PIXELS, a number above 0";
                plan.boundary_lod_px = Some(above_zero().ok_or(allowed)?);
            }
            "frustum-culling" => plan.frustum_culling = on_or_off(value)?,
            "horizon-culling" => plan.horizon_culling = on_or_off(value)?,
            "too-small-culling" => plan.too_small_culling = on_or_off(value)?,
            _ => return Ok(false),
        }
        Ok(true)
    }
}

fn on_or_off(value: &str) -> Result<bool, &'static str> {
    match value {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("on, off"),
    }
}

/// Switches of `render`, for a message.
fn allowed_switches(technique: &Technique) -> String {
    format!(
        "{}, boundary-tolerance-m=METRES, boundary-lod-px=PIXELS, frustum-culling=on|off, \
         horizon-culling=on|off, too-small-culling=on|off",
        technique.keys()
    )
}

fn input(
    scene: &Scene,
    view: &View,
    wanted: &Wanted,
    arguments: &RenderArguments,
) -> Result<FrameInput, Failure> {
    let refused = |errors: Vec<MeshError>| {
        let lines: Vec<String> = errors
            .iter()
            .map(|error| format!("{}: {error}", arguments.scene))
            .collect();
        Failure::bad_input(lines.join("\n"))
    };
    let surface = open_surface(SURFACES, scene).map_err(Failure::bad_input)?;
    let prepared = if wanted.plan.boundary_lod_px.is_some() {
        let leveled = LeveledMeshes::build(scene, &wanted.mesh).map_err(refused)?;
        PreparedScene::leveled(scene, leveled, surface)
    } else {
        let (body, rule) = (&scene.body, scene.edge_rule);
        let meshes = RegionMesh::build_all(&scene.regions, body, rule, &wanted.mesh);
        PreparedScene::new(scene, meshes.map_err(refused)?.into(), surface)
    };
    let size = ImageSize {
        width: arguments.size.0,
        height: arguments.size.1,
    };
    FrameInput::new(&prepared, view, size, wanted.plan).map_err(|error| {
        let (scene, view) = (&arguments.scene, &view.name);
        Failure::bad_input(format!("{scene}: view {view}: {error}"))
    })
}

fn draw_reference(input: &FrameInput, is_textured: bool) -> Result<Drawn, Failure> {
    let reference = if is_textured {
        ReferenceBackend::textured()
    } else {
        ReferenceBackend::new()
    };
    let judged = reference.judge(input).map_err(Failure::bad_input)?;
    let frame = judged.frame;
    Ok(Drawn {
        rgb: judged.picture.unwrap_or_else(|| paint(&frame)),
        variant: if is_textured { "texture=on" } else { "" }.to_owned(),
        frame,
        memory: None,
        note: None,
        cap_acmr: None,
    })
}

fn draw(
    input: &FrameInput,
    technique: &Technique,
    arguments: &RenderArguments,
) -> Result<Drawn, Failure> {
    let draw = || -> Result<Drawn, DeviceError> {
        let mut backend = technique.open_alone(arguments.adapter.as_deref(), input.size)?;
        let memory = backend.prepare(input)?;
        let frame = backend.render(input)?;
        let picture = backend.picture(input)?;
        let rgb = picture.rgba.chunks_exact(4).flat_map(|p| &p[..3]).copied();
        Ok(Drawn {
            rgb: rgb.collect(),
            frame,
            memory: Some(memory),
            variant: backend.variant_name(),
            note: backend.note(),
            cap_acmr: match technique {
                Technique::Vertex(variant) => cap_acmr(input, variant.index_order),
                _ => None,
            },
        })
    };
    draw().map_err(|error| match error {
        DeviceError::Unsupported { .. } | DeviceError::DeviceLost(_) => Failure::no_device(error),
        _ => Failure::bad_input(error),
    })
}

/// Over all triangles of the regions drawn.
fn cap_acmr(input: &FrameInput, order: IndexOrder) -> Option<f64> {
    let (mut misses, mut triangles) = (0.0, 0.0);
    for planned in &input.plan.regions {
        let mesh = &input.scene.meshes[planned.mesh];
        let ratio = match order {
            IndexOrder::Mesh => acmr(&mesh.triangles, CACHE_SIZE),
            IndexOrder::Cache => {
                let ordered = cache_ordered(&mesh.triangles, mesh.vertices_ecef.len());
                acmr(&ordered, CACHE_SIZE)
            }
        };
        misses += ratio.unwrap_or(0.0) * mesh.triangles.len() as f64;
        triangles += mesh.triangles.len() as f64;
    }
    (triangles > 0.0).then(|| misses / triangles)
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
            "geometry_shader_primitives": counters.geometry_shader_primitives,
            "clipper_invocations": counters.clipper_invocations,
            "clipper_primitives_out": counters.clipper_primitives_out,
            "fragment_shader_invocations": counters.fragment_shader_invocations,
            "stencil_fragments": counters.stencil_fragments,
            "buffer_creations": counters.buffer_creations,
            "pipeline_creations": counters.pipeline_creations,
            "uploads": counters.uploads,
        })
    });
    let memory = drawn.memory.map(|memory| {
        json!({
            "buffers": memory.buffers,
            "vertex_bytes": memory.vertex_bytes,
            "index_bytes": memory.index_bytes,
            "constant_bytes": memory.constant_bytes,
            "target_bytes": memory.target_bytes,
            "texture_bytes": memory.texture_bytes,
            "geometry_bytes": memory.geometry_bytes(),
        })
    });
    json!({
        "scene": input.scene.name,
        "view": input.view,
        "backend": arguments.backend.name(),
        "variant": drawn.variant,
        "width": input.size.width,
        "height": input.size.height,
        "filled_px": drawn.frame.filled_px(),
        "non_finite": drawn.frame.non_finite,
        "counters": counters,
        "memory": memory,
        "cap_acmr": drawn.cap_acmr,
        "regions_drawn": input.plan.regions.len(),
        "left_out": left_out,
        "note": drawn.note,
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
