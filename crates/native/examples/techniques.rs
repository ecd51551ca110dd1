// SPDX-License-Identifier: MIT OR Apache-2.0
//! Process CPU time of every technique's fill on the views of a shipped scene, interleaved, against
//! `vs-control`; and its bytes.
//!
//! usage: cargo run --release -p terrafill-native --example techniques [SCENE [ROUNDS [SIZE]]]

use std::error::Error;
use std::sync::Arc;
use terrafill_core::RegionMesh;
use terrafill_frame::{Backend as _, FrameInput, PreparedScene, Switches, TimedBackend as _};
use terrafill_native::{NativeBackend, NativeVariant, Technique, native_bytes};
use terrafill_scene::{ImageSize, PlanOptions, Scene, SurfaceMesh, data_dir_from_env};
use terrafill_vulkan::{Gpu, GpuOptions, Stage};

#[allow(
    clippy::print_stdout,
    reason = "an example's results go to standard output"
)]
fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let name = arguments.first().map_or("planet-134", String::as_str);
    let rounds: usize = arguments.get(1).map_or(Ok(21), |text| text.parse())?;
    let side: u32 = arguments.get(2).map_or(Ok(1024), |text| text.parse())?;
    let size = ImageSize {
        width: side,
        height: side,
    };
    let scene = Scene::shipped(name, data_dir_from_env().as_deref())?;
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh)
        .map_err(|errors| format!("{errors:?}"))?;
    let surface = Arc::new(SurfaceMesh::ellipsoid(&scene.body, scene.surface_rows));
    let prepared = PreparedScene::new(&scene, meshes.into(), surface);
    let gpu = Gpu::open(&GpuOptions::default())?;
    println!(
        "{name}, {side} × {side}, {rounds} rounds, {}",
        gpu.facts.name
    );
    for technique in Technique::ALL {
        let bytes: u64 = prepared
            .meshes
            .iter()
            .map(|mesh| native_bytes(technique, mesh).total())
            .sum();
        println!("{:>16}: {bytes} bytes", technique.name());
    }
    for view in &scene.views {
        let input = FrameInput::new(&prepared, view, size, PlanOptions::default());
        let stage = Stage::shared(&gpu, size)?;
        let mut backends = Vec::new();
        for technique in Technique::ALL {
            let variant = NativeVariant {
                technique,
                switches: Switches::for_overlap(scene.overlap),
            };
            let mut backend = NativeBackend::new(&stage, variant)?;
            backend.prepare(&input)?;
            backends.push((backend, Vec::new()));
        }
        stage.borrow_mut().draw_surface()?;
        for round in 0..rounds + 2 {
            let count = backends.len();
            for place in 0..count {
                let (backend, times) = &mut backends[(place + round) % count];
                let frame = backend.time_frame(&input)?;
                if round >= 2 {
                    times.push(frame.fill_cpu_ms);
                }
            }
        }
        let mut control = None;
        for (backend, times) in &mut backends {
            times.sort_by(f64::total_cmp);
            let median = times[times.len() / 2];
            let against = median / *control.get_or_insert(median);
            let technique = backend.variant().technique.name();
            println!(
                "{:>10} {technique:>16}: {median:8.2} ms CPU, {against:.3} × vs-control, \
                 quartiles {:.2} … {:.2}",
                view.name,
                times[times.len() / 4],
                times[times.len() * 3 / 4]
            );
        }
    }
    Ok(())
}
