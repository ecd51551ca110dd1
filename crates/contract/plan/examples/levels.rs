// SPDX-License-Identifier: MIT OR Apache-2.0
//! Boundary levels of detail of scenes: what they cost to make and what they leave.
//!
//! `cargo run --release -p terrafill-plan --example levels -- planet-134 countries-50m`

#![allow(clippy::print_stdout, reason = "printing is what an example is for")]

use std::time::Instant;
use terrafill_plan::{LazyMesh, LeveledMeshes};
use terrafill_scene::{Scene, data_dir_from_env};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in std::env::args().skip(1) {
        let scene = Scene::shipped(&name, data_dir_from_env().as_deref())?;
        let start = Instant::now();
        let leveled = LeveledMeshes::build(&scene, &scene.mesh)
            .map_err(|errors| errors.first().map(ToString::to_string).unwrap_or_default())?;
        println!(
            "{name}: ready in {:.0} ms: {} regions meshed as written, {} coarser levels known; ended by {:?}",
            ms_since(start),
            scene.regions.len(),
            leveled.table.coarser.len(),
            leveled.ended_by,
        );
        for level in leveled.table.coarser.iter().rev() {
            let start = Instant::now();
            LazyMesh::make_all(level.meshes.iter().map(|&mesh| &leveled.meshes[mesh]));
            println!(
                "  {:>9.0} m: all meshes made in {:.0} ms",
                level.tolerance_m,
                ms_since(start)
            );
        }
        println!(
            "  {} meshes of all levels after {:.0} ms",
            leveled.meshes.len(),
            ms_since(start)
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

fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
