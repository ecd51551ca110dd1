// SPDX-License-Identifier: MIT OR Apache-2.0
//! What boundary levels of detail bring and cost: vertices, fill time over the bound, wrong pixels.
//!
//! `cargo run --release -p terrafill-filling --example level_of_detail -- [ROUNDS] SCENE…`
//!
//! Process CPU time, all settings and the bound in turn, medians.

#![allow(clippy::print_stdout, reason = "printing is what an example is for")]

use std::sync::Arc;
use terrafill_conformance::compare;
use terrafill_contract::{FillBackend as _, FillInput, PreparedScene};
use terrafill_gpu::{Baseline, BaselineKind, Gpu, GpuOptions, RenderTargets};
use terrafill_plan::{LazyMesh, LeveledMeshes, PlanOptions};
use terrafill_reference::ReferenceBackend;
use terrafill_results::median;
use terrafill_scene::{ImageSize, Scene, data_dir_from_env};
use terrafill_surface::{EllipsoidKind, open_surface};
use terrafill_vertex::{VertexBackend, VertexVariant, layout_bytes};

const SIZE: ImageSize = ImageSize::new(1024, 1024);

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1).peekable();
    let rounds = match arguments.peek().and_then(|first| first.parse::<u32>().ok()) {
        Some(rounds) => {
            arguments.next();
            rounds
        }
        None => 15,
    };
    let gpu = Gpu::open(&GpuOptions::default())?;
    for name in arguments {
        let scene = Scene::shipped(&name, data_dir_from_env().as_deref())?;
        let leveled = LeveledMeshes::build(&scene, &scene.mesh)
            .map_err(|errors| anyhow::anyhow!("{name}: {errors:?}"))?;
        let surface = open_surface(&[&EllipsoidKind], &scene)?;
        let prepared = PreparedScene::leveled(&scene, leveled, surface);
        let as_written = geometry_bytes(&prepared.meshes[..scene.regions.len()]);
        let all = geometry_bytes(&prepared.meshes);
        println!("{name}: {as_written} bytes as written, {all} with all levels");
        for view in &scene.views {
            measure(&gpu, &prepared, view, rounds)?;
        }
    }
    Ok(())
}

/// Of the layout that is measured.
fn geometry_bytes(meshes: &[LazyMesh]) -> u64 {
    let layout = VertexVariant::default().layout;
    let bytes = meshes.iter().map(|mesh| layout_bytes(layout, mesh).total());
    bytes.sum()
}

fn measure(
    gpu: &Arc<Gpu>,
    scene: &PreparedScene,
    view: &terrafill_scene::View,
    rounds: u32,
) -> anyhow::Result<()> {
    let targets = RenderTargets::shared(gpu, SIZE)?;
    let mut bound = Baseline::new(BaselineKind::DepthPass, &targets)?;
    let full = FillInput::new(scene, view, SIZE, PlanOptions::default())?;
    let reference = ReferenceBackend::new().judge(&full)?.frame;
    let mut settings = Vec::new();
    for pixels in [None, Some(0.25), Some(0.5), Some(1.0)] {
        let options = PlanOptions {
            boundary_lod_px: pixels,
            ..PlanOptions::default()
        };
        let input = full.remeshed(scene, options);
        let mut backend = VertexBackend::new(&targets, VertexVariant::default())?;
        let memory = backend.prepare(&input)?;
        let frame = backend.render(&input)?;
        let figures = compare(&reference, &frame)?;
        let vertices: usize = input
            .plan
            .regions
            .iter()
            .map(|planned| scene.meshes[planned.mesh].boundary_edge_count())
            .sum();
        settings.push((
            pixels,
            input,
            backend,
            memory,
            figures,
            vertices,
            Vec::new(),
        ));
    }
    let mut bound_ms = Vec::new();
    for round in 0..rounds + 2 {
        targets.borrow_mut().prepare(&full)?;
        targets.borrow_mut().draw_surface()?;
        let of_bound = bound.time_frame()?.fill_cpu_ms;
        if round >= 2 {
            bound_ms.push(of_bound);
        }
        for (_, input, backend, _, _, _, times) in &mut settings {
            let of_fill = backend.time_frame(input)?.fill_cpu_ms;
            if round >= 2 {
                times.push(of_fill);
            }
        }
    }
    let bound_ms = median(&bound_ms).unwrap_or(f64::NAN);
    println!("{}/{}: bound {bound_ms:.1} ms", scene.name, view.name);
    for (pixels, input, _, memory, figures, vertices, times) in &settings {
        let fill_ms = median(times).unwrap_or(f64::NAN);
        let setting = pixels.map_or("off".to_owned(), |pixels| format!("{pixels} px"));
        println!(
            "  {setting:>7}: {} regions, {vertices:>6} boundary vertices, fill {fill_ms:6.1} ms = \
             {:.2} × bound, {} wrong px, {} outside the band, {} bytes of geometry",
            input.plan.regions.len(),
            fill_ms / bound_ms,
            figures.mismatched_px,
            figures.mismatched_px_outside_band,
            memory.geometry_bytes(),
        );
    }
    Ok(())
}
