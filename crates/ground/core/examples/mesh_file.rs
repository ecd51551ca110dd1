// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reads and meshes a GeoJSON file and prints what each stage took.
//!
//! `mesh_file FILE [TOLERANCE_M] [great-ellipse] [even-odd]`; set `RAYON_NUM_THREADS=1` to time one core.

#![allow(clippy::print_stdout, reason = "printing is what an example is for")]

use std::process::ExitCode;
use std::time::Instant;
use terrafill_core::{EdgeRule, Ellipsoid, MeshOptions, RegionMesh, parse_regions};

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(file) = arguments.next() else {
        println!("usage: mesh_file FILE [TOLERANCE_M] [great-ellipse] [even-odd]");
        return ExitCode::from(2);
    };
    let rest: Vec<String> = arguments.collect();
    let rule = if rest
        .iter()
        .any(|word| word == EdgeRule::GreatEllipse.name())
    {
        EdgeRule::GreatEllipse
    } else {
        EdgeRule::Planar
    };
    let mut options = MeshOptions::default();
    if let Some(tolerance_m) = rest.iter().find_map(|word| word.parse().ok()) {
        options.boundary_tolerance_m = tolerance_m;
    }
    let start = Instant::now();
    let bytes = match std::fs::read(&file) {
        Ok(bytes) => bytes,
        Err(error) => {
            println!("{file}: {error}");
            return ExitCode::from(2);
        }
    };
    let read = Instant::now();
    let regions = match parse_regions(&bytes, &file) {
        Ok(regions) => regions,
        Err(error) => {
            println!("{error}");
            return ExitCode::from(2);
        }
    };
    let parsed = Instant::now();
    let mut regions = regions;
    if rest.iter().any(|word| word == "even-odd") {
        let crossings: usize = regions
            .iter_mut()
            .map(|region| region.split_at_crossings(rule))
            .sum();
        println!("crossings       {crossings}");
    }
    let repaired = Instant::now();
    let body = Ellipsoid::WGS84;
    let meshes = match RegionMesh::build_all(&regions, &body, rule, &options) {
        Ok(meshes) => meshes,
        Err(errors) => {
            for error in errors {
                println!("{file}: {error}");
            }
            return ExitCode::from(2);
        }
    };
    let meshed = Instant::now();
    let mut broken = 0;
    for mesh in &meshes {
        if let Err(violation) = mesh.check_invariants(&body) {
            println!("{} ({}): {violation}", mesh.region_index, mesh.name);
            broken += 1;
        }
    }
    let checked = Instant::now();
    let total = |count: fn(&RegionMesh) -> usize| meshes.iter().map(count).sum::<usize>();
    println!("regions         {}", regions.len());
    println!(
        "file vertices   {}",
        regions.iter().map(|r| r.vertex_count()).sum::<usize>()
    );
    println!("mesh vertices   {}", total(RegionMesh::vertex_count));
    println!("triangles       {}", total(RegionMesh::triangle_count));
    println!("boundary edges  {}", total(RegionMesh::boundary_edge_count));
    println!(
        "area            {:.6e} m2",
        meshes.iter().map(|m| m.area_m2).sum::<f64>()
    );
    let largest = |value: fn(&RegionMesh) -> f64| meshes.iter().map(value).fold(0.0, f64::max);
    println!(
        "deviation       {:.3} m",
        largest(|m| m.boundary_deviation_m)
    );
    println!("cap sagitta     {:.1} m", largest(|m| m.cap_sagitta_m));
    println!("broken          {broken}");
    println!("read   {:8.1} ms", (read - start).as_secs_f64() * 1e3);
    println!("parse  {:8.1} ms", (parsed - read).as_secs_f64() * 1e3);
    println!("repair {:8.1} ms", (repaired - parsed).as_secs_f64() * 1e3);
    println!("mesh   {:8.1} ms", (meshed - repaired).as_secs_f64() * 1e3);
    println!("check  {:8.1} ms", (checked - meshed).as_secs_f64() * 1e3);
    if broken == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
