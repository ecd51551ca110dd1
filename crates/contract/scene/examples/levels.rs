// SPDX-License-Identifier: MIT OR Apache-2.0
//! Boundary levels of detail of scenes: what they cost to make and what they leave.
//!
//! `cargo run --release -p terrafill-scene --example levels -- planet-134 countries-50m`

#![allow(clippy::print_stdout, reason = "printing is what an example is for")]

use std::time::Instant;
use terrafill_core::SharedBoundaries;
use terrafill_scene::{LEVEL_GROWTH, LEVEL_VERTEX_SHARE, LeveledMeshes, Scene, data_dir_from_env};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in std::env::args().skip(1) {
        let scene = Scene::shipped(&name, data_dir_from_env().as_deref())?;
        let base_m = scene.mesh.boundary_tolerance_m;
        let tolerances: Vec<f64> = (0..11).map(|k| base_m * LEVEL_GROWTH.powi(k)).collect();
        let start = Instant::now();
        let shared = SharedBoundaries::new(&scene.regions, &scene.body, scene.edge_rule);
        let found_ms = start.elapsed().as_secs_f64() * 1e3;
        let simplified = shared.simplify_by_share(&tolerances, LEVEL_VERTEX_SHARE)?;
        let all_ms = start.elapsed().as_secs_f64() * 1e3;
        println!("{name}: shared borders found in {found_ms:.0} ms, simplified in {all_ms:.0} ms");
        for level in &simplified {
            let deviations = level.reports.iter().map(|report| report.deviation_m);
            println!(
                "  {:>9.0} m: {:>7} vertices, deviation {:.1} m, {} put back",
                level.tolerance_m,
                level.vertex_count(),
                deviations.fold(0.0, f64::max),
                level.restored_vertices,
            );
        }
        let start = Instant::now();
        let leveled = LeveledMeshes::build(&scene, &scene.mesh)
            .map_err(|errors| errors.first().map(ToString::to_string).unwrap_or_default())?;
        println!(
            "  {} meshes of {} regions in {:.0} ms; ended by {:?}",
            leveled.meshes.len(),
            scene.regions.len(),
            start.elapsed().as_secs_f64() * 1e3,
            leveled.ended_by,
        );
        let sum = |meshes: &mut dyn Iterator<Item = usize>| {
            meshes.fold((0, 0), |(edges, triangles), mesh| {
                let mesh = &leveled.meshes[mesh];
                (
                    edges + mesh.boundary_edge_count(),
                    triangles + mesh.triangle_count(),
                )
            })
        };
        let (edges, triangles) = sum(&mut (0..scene.regions.len()));
        println!("  level 0: {edges} boundary edges, {triangles} triangles");
        for level in &leveled.table.coarser {
            let (edges, triangles) = sum(&mut level.meshes.iter().copied());
            println!(
                "  {:.0} m: {edges} boundary edges, {triangles} triangles, drawn within {:.0} m",
                level.tolerance_m,
                level.deviation_m.iter().copied().fold(0.0, f64::max),
            );
        }
    }
    Ok(())
}
