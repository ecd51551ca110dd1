// SPDX-License-Identifier: MIT OR Apache-2.0
//! What each frame costs on a way of 300 frames from orbit to the ground, with levels of detail that change.
//!
//! `cargo run --release -p terrafill-filling --example camera_path -- [ROUNDS] [KEY=VALUE…] SCENE…`
//!
//! By each technique's full plan with levels, but for the switches given. `surface.KEY=VALUE` changes what lies under
//! the fill: with `surface.kind=tiles surface.base=flat` it has the triangles that the view needs, as the fill has.
//!
//! A frame is plan, what it uploads, surface and fill, by process CPU time, median over the rounds. What the surface
//! alone takes, which no fill can change, is printed beside it, and surface and fill by the GPU's clock, where there is
//! one. The first frame is drawn once beforehand, as a program does while it loads. A round flies twice: the first
//! flight makes what it draws, the other finds it made.

#![allow(clippy::print_stdout, reason = "printing is what an example is for")]

use std::collections::BTreeSet;
use std::rc::Rc;
use terrafill_compute::ComputeTechnique;
use terrafill_contract::{CpuStopwatch, Devices, FillInput, PreparedScene, Targets, Technique};
use terrafill_core::Geodetic;
use terrafill_grid::GridKind;
use terrafill_instanced::InstancedTechnique;
use terrafill_native::NativeTechnique;
use terrafill_plan::{LazyMesh, LeveledMeshes};
use terrafill_results::median;
use terrafill_scene::{CameraPose, ImageSize, Scene, View, data_dir_from_env};
use terrafill_spiral::SpiralKind;
use terrafill_surface::{EllipsoidKind, SurfaceKind, open_surface};
use terrafill_tiles::TilesKind;
use terrafill_variant::Variant;
use terrafill_vertex::VertexTechnique;

const SIZE: ImageSize = ImageSize::new(1024, 1024);
const FRAMES: u32 = 300;
const ROUNDS: u32 = 3;
/// Frames before and after one that show nearly the same.
const NEIGHBOURS: usize = 10;
const TECHNIQUES: [&dyn Technique; 4] = [
    &VertexTechnique,
    &ComputeTechnique,
    &InstancedTechnique,
    &NativeTechnique,
];

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1).peekable();
    let rounds = arguments.peek().and_then(|first| first.parse::<u32>().ok());
    if rounds.is_some() {
        arguments.next();
    }
    let (settings, scenes): (Vec<String>, Vec<String>) = arguments.partition(|of| of.contains('='));
    let (of_surface, settings): (Vec<String>, Vec<String>) = settings
        .into_iter()
        .partition(|setting| setting.starts_with("surface."));
    let targets = Targets::new(&Rc::new(Devices::new(None)), SIZE);
    for name in scenes {
        let mut scene = Scene::shipped(&name, data_dir_from_env().as_deref())?;
        choose_surface(&mut scene, &of_surface);
        let leveled = LeveledMeshes::build(&scene, &scene.mesh)
            .map_err(|errors| anyhow::anyhow!("{name}: {errors:?}"))?;
        // Beforehand, so that the times are those of drawing.
        LazyMesh::make_all(&leveled.meshes);
        let kinds: [&dyn SurfaceKind; 4] = [&EllipsoidKind, &GridKind, &SpiralKind, &TilesKind];
        let surface = open_surface(&kinds, &scene)?;
        let prepared = PreparedScene::leveled(&scene, leveled, surface);
        let views = path(prepared.meshes[0].vertices_deg[0]);
        for technique in TECHNIQUES {
            let Some(variant) = full_plan(technique, &scene, &settings)? else {
                continue;
            };
            let rounds = rounds.unwrap_or(ROUNDS);
            measure(
                (technique, &variant),
                &targets,
                (&scene, &prepared),
                &views,
                rounds,
            )?;
        }
    }
    Ok(())
}

/// Changes what lies under the fill by `surface.KEY=VALUE`, keys as in a scene file. Another kind has none of the keys
/// of the one that the scene names.
fn choose_surface(scene: &mut Scene, settings: &[String]) {
    for setting in settings {
        let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
        let key = key.trim_start_matches("surface.");
        if key == "kind" {
            value.clone_into(&mut scene.surface.kind);
            scene.surface.parameters.clear();
            continue;
        }
        let text = || toml::Value::String(value.to_owned());
        let value = value.parse().unwrap_or_else(|_| text());
        scene.surface.parameters.insert(key.to_owned(), value);
    }
}

/// A technique's full plan with levels, changed by `settings`; `None` where that has no such plan.
fn full_plan(
    technique: &dyn Technique,
    scene: &Scene,
    settings: &[String],
) -> anyhow::Result<Option<Variant>> {
    let Some(mut variant) = technique.full_plans(scene.overlap).pop() else {
        return Ok(None);
    };
    for setting in settings {
        let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
        let is_known = variant.set(key, value)?;
        anyhow::ensure!(
            is_known,
            "{setting}: {} has no such switch",
            technique.name()
        );
    }
    technique.check(&variant, scene.overlap)?;
    Ok(Some(variant))
}

/// From 20,000 km above a place down to 50 m, at first straight down, at last along the ground.
fn path([longitude_deg, latitude_deg]: [f64; 2]) -> Vec<View> {
    let seen = |frame: u32| {
        let share = f64::from(frame) / f64::from(FRAMES - 1);
        let height_m = 2e7 * (50.0_f64 / 2e7).powf(share);
        View {
            name: format!("frame {frame}"),
            pose: CameraPose {
                eye: Geodetic::from_degrees(longitude_deg, latitude_deg, height_m),
                heading_rad: (40.0 * share).to_radians(),
                pitch_rad: (-90.0 + 80.0 * share * share).to_radians(),
                fov_y_rad: 45_f64.to_radians(),
                near_m: height_m * 1e-3,
            },
            note: None,
        }
    };
    (0..FRAMES).map(seen).collect()
}

fn measure(
    (technique, variant): (&dyn Technique, &Variant),
    targets: &Targets,
    (scene, prepared): (&Scene, &PreparedScene),
    views: &[View],
    rounds: u32,
) -> anyhow::Result<()> {
    let input = |view: &View| FillInput::new(prepared, view, SIZE, variant.plan);
    let mut times = vec![vec![FrameRounds::default(); views.len()]; 2];
    for _ in 0..rounds {
        let mut backend = technique.open(targets, variant)?;
        if let Some(first) = views.first() {
            let input = input(first)?;
            backend.prepare(&input)?;
            backend.draw_surface(&input)?;
            backend.time_frame(&input)?;
        }
        for flight in &mut times {
            for (view, of_frame) in views.iter().zip(flight) {
                let watch = CpuStopwatch::start();
                let input = input(view)?;
                let of_prepare = CpuStopwatch::start();
                backend.prepare(&input)?;
                of_frame.prepare_cpu_ms.push(of_prepare.cpu_ms());
                let of_surface = CpuStopwatch::start();
                let surface_gpu_ms = backend.draw_surface(&input)?;
                of_frame.surface_cpu_ms.push(of_surface.cpu_ms());
                let fill_gpu_ms = backend.time_frame(&input)?.fill_gpu_ms;
                of_frame.cpu_ms.push(watch.cpu_ms());
                let gpu_ms = surface_gpu_ms.zip(fill_gpu_ms);
                of_frame
                    .gpu_ms
                    .extend(gpu_ms.map(|(surface, fill)| surface + fill));
            }
        }
    }
    let mut backend = technique.open(targets, variant)?;
    let (mut levels, mut changes, mut making) = (BTreeSet::new(), 0, 0);
    let mut made = vec![Vec::new(); 2];
    let mut changed = vec![Vec::new(); 2];
    for (made, changed) in made.iter_mut().zip(&mut changed) {
        for view in views {
            let input = input(view)?;
            let meshes: BTreeSet<usize> = input.plan.regions.iter().map(|of| of.mesh).collect();
            changed.push(meshes != levels);
            changes += usize::from(meshes != levels);
            levels = meshes;
            backend.prepare(&input)?;
            let counted = backend.render(&input)?.counters.unwrap_or_default();
            making += usize::from(counted.buffer_creations > 0);
            made.push(counted);
        }
    }
    println!(
        "{}, {}: of {} frames of two flights {changes} draw other meshes than the one before, {making} make \
         buffers",
        scene.name,
        technique.name(),
        2 * views.len()
    );
    let flights = ["first flight", "once more"].iter().zip(&times);
    for ((flight, frames), (made, changed)) in flights.zip(made.iter().zip(&changed)) {
        let of_all = |of: fn(&FrameRounds) -> &Vec<f64>| -> Vec<f64> {
            frames
                .iter()
                .filter_map(|frame| median(of(frame)))
                .collect()
        };
        let cpu_ms = of_all(|frame| &frame.cpu_ms);
        let surface_ms = of_all(|frame| &frame.surface_cpu_ms);
        let Some([worst, near]) = tell(flight, "process CPU", &cpu_ms) else {
            continue;
        };
        println!(
            "    the worst at {:.0} m made {} buffers and {} pipelines and uploaded {} times",
            views[worst].pose.eye.height_m,
            made[worst].buffer_creations,
            made[worst].pipeline_creations,
            made[worst].uploads,
        );
        let work = |frame: usize| {
            let of = &made[frame];
            let [vertices, fragments] = [of.vertex_shader_invocations, of.stencil_fragments]
                .map(|count| count.map_or_else(|| "–".to_owned(), |count| count.to_string()));
            format!(
                "{} draws, {vertices} vertex shaders, {fragments} stencil fragments",
                of.draws
            )
        };
        println!("    worst: {}; a median one: {}", work(worst), work(near));
        let both = cpu_ms.iter().zip(&surface_ms);
        let rest_ms: Vec<f64> = both.map(|(all, surface)| all - surface).collect();
        println!(
            "    surface alone: {:.2} ms in the worst frame, {:.2} in a median one; the rest {:.2} and {:.2}, at worst \
             {:.2} × its median",
            surface_ms[worst],
            surface_ms[near],
            rest_ms[worst],
            rest_ms[near],
            rest_ms.iter().copied().fold(0.0, f64::max) / median(&rest_ms).unwrap_or(f64::NAN)
        );
        let prepare_ms = of_all(|frame| &frame.prepare_cpu_ms);
        let [other, same] = [true, false].map(|is_other| {
            let both = prepare_ms.iter().zip(changed);
            let own = both.filter(|(_, changed)| **changed == is_other);
            let own: Vec<f64> = own.map(|(ms, _)| *ms).collect();
            let most = own.iter().copied().fold(0.0, f64::max);
            format!(
                "{:.2} ms, at most {most:.2}",
                median(&own).unwrap_or(f64::NAN)
            )
        });
        println!("    of it getting ready: where other meshes are drawn {other}; else {same}");
        tell(flight, "GPU's clock", &of_all(|frame| &frame.gpu_ms));
    }
    Ok(())
}

/// Of one frame a time a round, milliseconds.
#[derive(Clone, Default)]
struct FrameRounds {
    cpu_ms: Vec<f64>,
    prepare_cpu_ms: Vec<f64>,
    surface_cpu_ms: Vec<f64>,
    /// Surface and fill; empty where the device has no clock.
    gpu_ms: Vec<f64>,
}

/// Prints how far frames by one clock are from their median and from frames around them; which is the slowest, and
/// which is nearest to the median. `None` where nothing was measured.
fn tell(flight: &str, clock: &str, frames_ms: &[f64]) -> Option<[usize; 2]> {
    let middle = median(frames_ms)?;
    let by = |a: &f64, b: &f64| a.total_cmp(b);
    let frames = || frames_ms.iter().copied().enumerate();
    let (worst, worst_ms) = frames().max_by(|a, b| by(&a.1, &b.1))?;
    let (near, _) = frames().min_by(|a, b| by(&(a.1 - middle).abs(), &(b.1 - middle).abs()))?;
    let slow: Vec<usize> = frames()
        .filter(|(_, ms)| *ms > 2.0 * middle)
        .map(|(frame, _)| frame)
        .collect();
    println!(
        "  {flight}, {clock}: median frame {middle:.3} ms; worst {worst_ms:.3} ms = {:.2} ×, frame {worst}; over 2 ×: \
         {slow:?}",
        worst_ms / middle
    );
    // A change of level is a step between frames that show nearly the same.
    let around = |frame: usize| {
        let past = (frame + NEIGHBOURS + 1).min(frames_ms.len());
        median(&frames_ms[frame.saturating_sub(NEIGHBOURS)..past])
    };
    let steps: Vec<(usize, f64)> = frames()
        .filter_map(|(frame, ms)| Some((frame, ms / around(frame)?)))
        .collect();
    let above = steps.iter().filter(|(_, ratio)| *ratio > 2.0).count();
    let (frame, ratio) = steps.into_iter().max_by(|a, b| by(&a.1, &b.1))?;
    println!(
        "    against the {} frames around it: worst {ratio:.2} ×, frame {frame}; over 2 ×: {above}",
        2 * NEIGHBOURS
    );
    Some([worst, near])
}
