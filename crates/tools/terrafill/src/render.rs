// SPDX-License-Identifier: MIT OR Apache-2.0
//! `render`: one picture, of a scene or of a study's case.

mod case;

use crate::arguments::{RenderArguments, Style};
use crate::data::data_dirs;
use crate::draft;
use crate::fit;
use crate::input::is_standard;
use crate::outcome::{Failure, Outcome, complain, print};
use crate::output::{check_paths, check_pictures, write_all};
use crate::registry::{SURFACES, technique};
use crate::techniques::{self, BOUNDARY_TOLERANCE, allowed_switches};
use image::{ExtendedColorType, ImageFormat};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Instant;
use terrafill_contract::{
    DeviceError, Devices, FillInput, Frame, MemoryUse, PreparedScene, Targets, Technique, paint,
};
use terrafill_core::{MeshError, MeshOptions, RegionMesh};
use terrafill_filling::PictureCheck;
use terrafill_plan::{LeveledMeshes, PlanOptions};
use terrafill_reference::{MapPicture, ReferenceBackend};
use terrafill_scene::{ImageSize, Scene, View, choices};
use terrafill_surface::open_surface;
use terrafill_variant::{Variant, is_gone};

/// What one backend drew.
struct RenderedPicture {
    rgb: Vec<u8>,
    frame: Frame,
    /// Whether its ids are of regions, and not of any region.
    tells_regions_apart: bool,
    memory: Option<MemoryUse>,
    variant: String,
    /// What the backend settled that people should know.
    note: Option<String>,
    /// Figures that the technique has of its own, by name.
    figures: BTreeMap<&'static str, Option<f64>>,
}

pub(crate) fn run(arguments: &RenderArguments) -> Result<Outcome, Failure> {
    let started = Instant::now();
    let (false, Some(name), Some(out)) =
        (arguments.list_switches, &arguments.scene, &arguments.out)
    else {
        // Only `--list-switches` goes without: the parser asks for both.
        print(techniques::text())?;
        return Ok(Outcome::Done);
    };
    let others = [&arguments.ids, &arguments.stats];
    check_paths(
        std::iter::once(out)
            .chain(others.into_iter().flatten())
            .map(PathBuf::as_path),
    )?;
    check_pictures(arguments.ids.iter().map(PathBuf::as_path), &["png"])?;
    check_pictures([out.as_path()], arguments.style.formats())?;
    if let Some(asked) = case::Asked::of(name) {
        return case(&asked, arguments, out);
    }
    if arguments.picture.is_some() {
        let message = "--picture: found with a scene, allowed: with STUDY/VALUE… of a case";
        return Err(Failure::bad_input(message));
    }
    let scene = scene(name, arguments)?;
    let view = find_view(&scene, arguments.view.as_deref())?;
    let wanted = wanted(&scene, arguments)?;
    if arguments.style == Style::Map && (wanted.subject.is_some() || wanted.is_textured) {
        let message = "--style: found map with a technique or a texture, allowed: map with the reference, plain";
        return Err(Failure::bad_input(message));
    }
    if arguments.check && wanted.subject.is_none() {
        let message = "--check: found --technique reference, allowed: one that is compared with it";
        return Err(Failure::bad_input(message));
    }
    let input = input(&scene, view, &wanted, arguments)?;
    let map = (arguments.style == Style::Map).then(|| MapPicture::of(&input));
    let map = map.transpose().map_err(Failure::bad_input)?;
    let drawn = match &wanted.subject {
        None => draw_reference(&input, wanted.is_textured)?,
        Some((technique, variant)) => draw(&input, *technique, variant, arguments)?,
    };
    if arguments.fit && drawn.frame.ids.iter().all(|id| *id == 0) {
        let ImageSize { width, height } = input.size;
        return Err(Failure::bad_input(format!(
            "{name}: found no pixel of {width} × {height} whose middle lies in a region, allowed: at \
             least one; a larger --size has more"
        )));
    }
    let colour = ExtendedColorType::Rgb8;
    let rgb = map.as_ref().map_or(&drawn.rgb, |map| &map.rgb);
    let format = ImageFormat::from_path(out).unwrap_or(ImageFormat::Png);
    let picture = encoded(rgb, input.size, colour, format)?;
    let mut files = vec![(out.as_path(), picture)];
    if let Some(path) = &arguments.ids {
        files.push((path, ids_png(&drawn.frame)?));
    }
    if let Some(path) = &arguments.stats {
        let text = serde_json::to_string_pretty(&statistics(arguments, &input, &drawn))
            .map_err(Failure::bad_input)?;
        files.push((path, (text + "\n").into_bytes()));
    }
    write_all(&files)?;
    let mut said = Vec::new();
    if is_file(out) {
        let seconds = started.elapsed().as_secs_f64();
        said.push(format!("wrote {}, {seconds:.1} s", out.display()));
    }
    said.extend(map.map(|map| map.inset));
    let subject = wanted.subject.as_ref().filter(|_| arguments.check);
    let check = subject.map(|(technique, variant)| {
        let as_mask = !drawn.tells_regions_apart;
        PictureCheck::new(*technique, variant, &input, &drawn.frame, as_mask)
    });
    let check = check.transpose().map_err(Failure::bad_input)?;
    let differs = check.as_ref().map(|check| check.mismatched_px);
    said.extend(differs.map(|px| format!("{px} px differ from the reference")));
    for line in said {
        // Beside a picture or figures nothing else belongs on standard output.
        if files.iter().all(|(path, _)| is_file(path)) {
            print(line + "\n")?;
        } else {
            complain(line);
        }
    }
    match check {
        Some(check) if !check.objections.is_empty() => Err(Failure {
            outcome: Outcome::Regression,
            message: check.objections.join("\n"),
        }),
        _ => Ok(Outcome::Done),
    }
}

/// Writes the picture of a study's case.
fn case(
    asked: &case::Asked<'_>,
    arguments: &RenderArguments,
    out: &Path,
) -> Result<Outcome, Failure> {
    let format = ImageFormat::from_path(out).unwrap_or(ImageFormat::Png);
    let drawn = asked.draw(arguments, format)?;
    write_all(&[(out, drawn.bytes)])?;
    for line in drawn.said {
        complain(line);
    }
    match drawn.objection {
        Some(message) if arguments.check => Err(Failure {
            outcome: Outcome::Regression,
            message,
        }),
        Some(message) => {
            complain(format!("warning: the picture is not right: {message}"));
            Ok(Outcome::Done)
        }
        None => Ok(Outcome::Done),
    }
}

/// Whether it is neither standard output nor a pipe or a device.
fn is_file(path: &Path) -> bool {
    !is_standard(path) && path.is_file()
}

/// The scene called `name`, or that of the regions in the file `name`.
fn scene(name: &str, arguments: &RenderArguments) -> Result<Scene, Failure> {
    let own = &arguments.own;
    if arguments.fit {
        if !own.terrain.is_empty() {
            let message =
                "--terrain: found with --fit, allowed: with --view all of a .geojson file";
            return Err(Failure::bad_input(message));
        }
        return fit::scene_of(Path::new(name), own, size(arguments));
    }
    let data = data_dirs(&arguments.data)?;
    if draft::is_region_file(name) {
        let text = draft::scene_text(Path::new(name), own, size(arguments))?;
        return Scene::from_toml(&text, name, data.as_deref()).map_err(Failure::bad_input);
    }
    draft::refuse_for_scenes(own)?;
    Scene::open(name, data.as_deref()).map_err(Failure::bad_input)
}

/// The scene as it was named, for messages.
fn scene_argument(arguments: &RenderArguments) -> &str {
    arguments.scene.as_deref().unwrap_or_default()
}

fn size(arguments: &RenderArguments) -> ImageSize {
    ImageSize::new(arguments.size.0, arguments.size.1)
}

/// The view called `name`, or without a name the only one.
fn find_view<'a>(scene: &'a Scene, name: Option<&str>) -> Result<&'a View, Failure> {
    let found = match (name, scene.views.as_slice()) {
        (None, [only]) => Some(only),
        (name, views) => views.iter().find(|view| Some(&*view.name) == name),
    };
    found.ok_or_else(|| {
        let views = scene.views.iter().map(|view| view.name.as_str());
        let allowed = choices(name.unwrap_or_default(), views);
        let name = name.map_or_else(|| "none".to_owned(), |name| format!("{name:?}"));
        Failure::bad_input(format!("--view: found {name}, allowed: {allowed}"))
    })
}

/// Word for all that the top of a technique's ablation sets, in place of what was set before.
const FULL_PLAN: &str = "full-plan";

/// What `--technique` and `--set` ask for: without switches a technique's full plan, with them the variant that they
/// name, as reports do.
struct Wanted {
    /// `None`: the reference.
    subject: Option<(&'static dyn Technique, Variant)>,
    mesh: MeshOptions,
    /// Whether the reference fills with the scene's texture.
    is_textured: bool,
}

fn wanted(scene: &Scene, arguments: &RenderArguments) -> Result<Wanted, Failure> {
    let technique = technique(arguments.technique());
    let full_plan = |technique: &dyn Technique| technique.full_plans(scene.overlap).pop();
    let subject = technique.map(|technique| {
        let unset = arguments.set.is_empty();
        let variant = Some(technique).filter(|_| unset).and_then(full_plan);
        (
            technique,
            variant.unwrap_or_else(|| technique.main(scene.overlap)),
        )
    });
    let mut wanted = Wanted {
        subject,
        mesh: scene.mesh,
        is_textured: false,
    };
    for switch in arguments.set.iter().flat_map(|all| all.split(',')) {
        let refuse = |allowed: &str| {
            let message = format!("--set: found {switch:?}, allowed: {allowed}");
            Failure::bad_input(message)
        };
        let (key, value) = switch.split_once('=').unwrap_or((switch, ""));
        if wanted.subject.is_none() {
            wanted
                .set_reference(scene, key, value)
                .map_err(|allowed| refuse(&allowed))?;
            continue;
        }
        if wanted.set_mesh(key, value).map_err(refuse)? {
            continue;
        }
        let Some((_, variant)) = &mut wanted.subject else {
            continue;
        };
        if let Some(technique) = technique.filter(|_| switch == FULL_PLAN) {
            let Some(top) = full_plan(technique) else {
                return Err(refuse(&allowed_switches(variant, key)));
            };
            *variant = top;
            continue;
        }
        // Reports name a layout by its value alone.
        let layout = technique.and_then(|technique| technique.parameters().first());
        if let Some(layout) = layout.filter(|_| !switch.contains('='))
            && variant.set(layout.key, switch).is_ok()
        {
            continue;
        }
        match variant.set(key, value) {
            Ok(true) => {}
            Ok(false) => return Err(refuse(&allowed_switches(variant, key))),
            Err(error) if is_gone(key) => return Err(refuse(&error.allowed)),
            Err(error) => return Err(refuse(&format!("{key}={}", error.allowed))),
        }
    }
    if let Some((technique, variant)) = &wanted.subject {
        let checked = technique.check(variant, scene.overlap);
        checked.map_err(|error| Failure::bad_input(format!("--set: {error}")))?;
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
            _ if has_texture => return Err("texture=on|off with --technique reference".to_owned()),
            _ => {
                let scene = &scene.name;
                return Err(format!(
                    "none with --technique reference and scene {scene}, which has no texture"
                ));
            }
        };
        Ok(())
    }

    /// Sets an option of the meshes that go into every backend; `Ok(false)` when there is no such
    /// option, and what is allowed when the value is none of the option's.
    fn set_mesh(&mut self, key: &str, value: &str) -> Result<bool, &'static str> {
        if key != BOUNDARY_TOLERANCE {
            return Ok(false);
        }
        let above_zero = value.parse().ok().filter(|&v| v > 0.0 && f64::is_finite(v));
        let allowed = "boundary-tolerance-m=METRES, a number above 0";
        self.mesh.boundary_tolerance_m = above_zero.ok_or(allowed)?;
        Ok(true)
    }

    fn plan(&self) -> PlanOptions {
        let variant = self.subject.as_ref().map(|(_, variant)| variant);
        variant.map_or_else(PlanOptions::default, |variant| variant.plan)
    }
}

fn input(
    scene: &Scene,
    view: &View,
    wanted: &Wanted,
    arguments: &RenderArguments,
) -> Result<FillInput, Failure> {
    let refused = |errors: Vec<MeshError>| {
        let lines: Vec<String> = errors
            .iter()
            .map(|error| format!("{}: {error}", scene_argument(arguments)))
            .collect();
        Failure::bad_input(lines.join("\n"))
    };
    let surface = open_surface(SURFACES, scene).map_err(Failure::bad_input)?;
    for warning in surface.warnings() {
        complain(format!("warning: {warning}"));
    }
    let prepared = if wanted.plan().boundary_lod_px.is_some() {
        let leveled = LeveledMeshes::build(scene, &wanted.mesh).map_err(refused)?;
        PreparedScene::leveled(scene, leveled, surface)
    } else {
        let (body, rule) = (&scene.body, scene.edge_rule);
        let meshes = RegionMesh::build_all(&scene.regions, body, rule, &wanted.mesh);
        PreparedScene::new(scene, meshes.map_err(refused)?.into(), surface)
    };
    FillInput::new(&prepared, view, size(arguments), wanted.plan()).map_err(|error| {
        let (scene, view) = (scene_argument(arguments), &view.name);
        Failure::bad_input(format!("{scene}: view {view}: {error}"))
    })
}

fn draw_reference(input: &FillInput, is_textured: bool) -> Result<RenderedPicture, Failure> {
    let reference = if is_textured {
        ReferenceBackend::textured()
    } else {
        ReferenceBackend::new()
    };
    let judged = reference.judge(input).map_err(Failure::bad_input)?;
    let frame = judged.frame;
    Ok(RenderedPicture {
        rgb: judged.picture.unwrap_or_else(|| paint(&frame)),
        variant: if is_textured { "texture=on" } else { "" }.to_owned(),
        frame,
        tells_regions_apart: true,
        memory: None,
        note: None,
        figures: BTreeMap::new(),
    })
}

fn draw(
    input: &FillInput,
    technique: &dyn Technique,
    variant: &Variant,
    arguments: &RenderArguments,
) -> Result<RenderedPicture, Failure> {
    let draw = || -> Result<RenderedPicture, DeviceError> {
        let devices = Rc::new(Devices::new(arguments.adapter.clone()));
        let targets = Targets::new(&devices, input.size);
        let mut backend = technique.open(&targets, variant)?;
        let memory = backend.prepare(input)?;
        let frame = backend.render(input)?;
        let picture = backend.picture(input)?;
        let rgb = picture.rgba.chunks_exact(4).flat_map(|p| &p[..3]).copied();
        // What is left out is listed by itself.
        let mut named = variant.clone();
        named.plan = PlanOptions::default();
        Ok(RenderedPicture {
            rgb: rgb.collect(),
            frame,
            tells_regions_apart: backend.tells_regions_apart(),
            memory: Some(memory),
            variant: named.name(),
            note: backend.note(),
            figures: technique.figures(variant, input).into_iter().collect(),
        })
    };
    draw().map_err(|error| match error {
        DeviceError::Unsupported { .. } | DeviceError::DeviceLost(_) => Failure::no_device(error),
        _ => Failure::bad_input(error),
    })
}

fn statistics(
    arguments: &RenderArguments,
    input: &FillInput,
    drawn: &RenderedPicture,
) -> serde_json::Value {
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
    let mut statistics = json!({
        "scene": input.scene.name,
        "view": input.view,
        "backend": arguments.technique(),
        "variant": drawn.variant,
        "width": input.size.width,
        "height": input.size.height,
        "filled_px": drawn.frame.filled_px(),
        "non_finite": drawn.frame.non_finite,
        "counters": counters,
        "memory": memory,
        "regions_drawn": input.plan.regions.len(),
        "left_out": left_out,
        "note": drawn.note,
    });
    for (name, figure) in &drawn.figures {
        statistics[*name] = json!(figure);
    }
    statistics
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
    encoded(&bytes, frame.size, ExtendedColorType::L16, ImageFormat::Png)
}

fn encoded(
    bytes: &[u8],
    size: ImageSize,
    colour: ExtendedColorType,
    format: ImageFormat,
) -> Result<Vec<u8>, Failure> {
    let mut encoded = Cursor::new(Vec::new());
    let (width, height) = (size.width, size.height);
    image::write_buffer_with_format(&mut encoded, bytes, width, height, colour, format)
        .map_err(Failure::bad_input)?;
    Ok(encoded.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::{Arguments, Verb};
    use crate::registry::TECHNIQUES;
    use clap::Parser as _;
    use terrafill_contract::Role;
    use terrafill_scene::Overlap;

    /// What `render` draws with these switches.
    fn set(
        scene: &Scene,
        technique: &dyn Technique,
        switches: &str,
    ) -> Vec<(&'static str, String)> {
        let set = if switches.is_empty() {
            String::new()
        } else {
            format!(" --set {switches}")
        };
        let line = format!(
            "terrafill render {} --view globe --technique {}{set} --out a.png",
            scene.name,
            technique.name()
        );
        let arguments = Arguments::try_parse_from(line.split(' ')).expect("a command");
        let Verb::Render(arguments) = arguments.verb else {
            panic!("{line}");
        };
        let wanted = wanted(scene, &arguments);
        let wanted = wanted.unwrap_or_else(|_| panic!("refused: {line}"));
        wanted.subject.expect("a technique").1.settings()
    }

    #[test]
    fn a_measured_variant_is_drawn_again_by_its_name() {
        let mut scene = Scene::open("california", None).expect("ships");
        for overlap in [Overlap::Disjoint, Overlap::Ordered] {
            scene.overlap = overlap;
            for technique in TECHNIQUES {
                let steps = technique.ablation(overlap).into_iter();
                let measured = steps.map(|step| step.variant);
                let measured = measured.chain(technique.full_plans(overlap));
                let measured = measured.chain(technique.variants(&scene, Role::Main));
                let is_drawn = |variant: &Variant| technique.check(variant, overlap).is_ok();
                for variant in measured.filter(is_drawn) {
                    let drawn = set(&scene, *technique, &variant.name());
                    assert_eq!(drawn, variant.settings(), "{}", variant.name());
                }
            }
        }
        // Control: a switch that is left out is another variant.
        for technique in TECHNIQUES {
            let layout = technique.parameters()[0].key;
            for full_plan in technique.full_plans(Overlap::Disjoint) {
                let name = full_plan.name();
                let switches: Vec<&str> = name.split(',').collect();
                for left_out in 1..switches.len() {
                    let mut fewer = switches.clone();
                    fewer.remove(left_out);
                    let mut variant = technique.main(Overlap::Disjoint);
                    for switch in &fewer {
                        let (key, value) = switch.split_once('=').unwrap_or((layout, switch));
                        assert_eq!(variant.set(key, value), Ok(true), "{switch}");
                    }
                    assert_ne!(variant.settings(), full_plan.settings(), "{fewer:?}");
                }
            }
        }
    }

    #[test]
    fn without_switches_a_technique_draws_its_full_plan() {
        let mut scene = Scene::open("california", None).expect("ships");
        for overlap in [Overlap::Disjoint, Overlap::Ordered] {
            scene.overlap = overlap;
            for technique in TECHNIQUES {
                let bare = technique.main(overlap);
                let drawn = set(&scene, *technique, "");
                let Some(top) = technique.full_plans(overlap).pop() else {
                    assert_eq!(drawn, bare.settings(), "{}", technique.name());
                    continue;
                };
                assert_eq!(drawn, top.settings(), "{}", technique.name());
                assert_eq!(set(&scene, *technique, FULL_PLAN), drawn);
                // Negative control: by its name the bare variant is another one.
                assert_eq!(set(&scene, *technique, &bare.name()), bare.settings());
                assert_ne!(bare.settings(), drawn, "{}", technique.name());
            }
        }
    }
}
