// SPDX-License-Identifier: MIT OR Apache-2.0
//! `mesh`: what becomes of a file's regions.

use crate::arguments::MeshArguments;
use crate::{Failure, Outcome, print};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Instant;
use terrafill_core::{EdgeRule, Ellipsoid, MeshOptions, Region, RegionMesh};
use terrafill_scene::load_regions;
use terrafill_vertex::{Layout, layout_bytes};

#[derive(Serialize)]
struct MeshOutput {
    file: String,
    edges: &'static str,
    body: &'static str,
    regions: Vec<MeshedRegion>,
    errors: Vec<serde_json::Value>,
    totals: Totals,
    elapsed_ms: f64,
}

#[derive(Serialize)]
struct MeshedRegion {
    index: usize,
    name: String,
    vertices: usize,
    triangles: usize,
    boundary_edges: usize,
    holes: usize,
    area_m2: f64,
    /// West, south, east, north.
    extent_deg: [f64; 4],
    boundary_deviation_m: f64,
    bytes: BTreeMap<String, u64>,
    warnings: Vec<String>,
}

#[derive(Serialize, Default)]
struct Totals {
    regions: usize,
    input_vertices: usize,
    vertices: usize,
    triangles: usize,
    boundary_edges: usize,
    holes: usize,
    area_m2: f64,
    bytes: BTreeMap<String, u64>,
}

pub(crate) fn run(arguments: &MeshArguments) -> Result<Outcome, Failure> {
    let body = Ellipsoid::by_name(&arguments.body).ok_or_else(|| {
        let names = Ellipsoid::ALL.map(|body| body.name());
        let (found, allowed) = (&arguments.body, names.join(", "));
        Failure::bad_input(format!("--body: found {found:?}, allowed: {allowed}"))
    })?;
    let options = MeshOptions {
        boundary_tolerance_m: positive(
            "--boundary-tolerance-m",
            arguments.boundary_tolerance_m,
            f64::MAX,
        )?,
        cap_step_deg: positive("--cap-step-deg", arguments.cap_step_deg, 90.0)?,
    };
    let edges: EdgeRule = arguments.edges.into();
    let start = Instant::now();
    let regions = load_regions(&arguments.regions).map_err(Failure::bad_input)?;
    let file = arguments.regions.display().to_string();
    let meshes = RegionMesh::build_all(&regions, &body, edges, &options).map_err(|errors| {
        let lines: Vec<String> = errors
            .iter()
            .map(|error| format!("{file}: {error}"))
            .collect();
        Failure::bad_input(lines.join("\n"))
    })?;
    let elapsed_ms = start.elapsed().as_secs_f64() * 1e3;
    let output = MeshOutput {
        file,
        edges: edges.name(),
        body: body.name(),
        totals: totals(&regions, &meshes),
        regions: meshes.iter().map(describe).collect(),
        errors: Vec::new(),
        elapsed_ms,
    };
    if arguments.json {
        let text = serde_json::to_string_pretty(&output).map_err(Failure::bad_input)?;
        print(&(text + "\n"));
    } else {
        print(&table(&output));
    }
    Ok(Outcome::Done)
}

fn positive(name: &str, value: f64, largest: f64) -> Result<f64, Failure> {
    if value > 0.0 && value <= largest {
        return Ok(value);
    }
    let allowed = if largest < f64::MAX {
        format!("above 0 and up to {largest}")
    } else {
        "a number above 0".to_owned()
    };
    Err(Failure::bad_input(format!(
        "{name}: found {value}, allowed: {allowed}"
    )))
}

fn bytes(meshes: &[RegionMesh]) -> BTreeMap<String, u64> {
    let layouts = [Layout::Doubled, Layout::Pulled];
    layouts
        .map(|layout| {
            let total = meshes.iter().map(|mesh| layout_bytes(layout, mesh).total());
            (format!("vertex/{}", layout.name()), total.sum())
        })
        .into()
}

fn describe(mesh: &RegionMesh) -> MeshedRegion {
    let extent = mesh.extent;
    MeshedRegion {
        index: mesh.region_index,
        name: mesh.name.clone(),
        vertices: mesh.vertices_ecef.len(),
        triangles: mesh.triangles.len(),
        boundary_edges: mesh.boundary_edge_count(),
        holes: mesh.holes,
        area_m2: mesh.area_m2,
        extent_deg: [
            extent.west_deg,
            extent.south_deg,
            extent.east_deg,
            extent.north_deg,
        ],
        boundary_deviation_m: mesh.boundary_deviation_m,
        bytes: bytes(std::slice::from_ref(mesh)),
        warnings: mesh.warnings.clone(),
    }
}

fn totals(regions: &[Region], meshes: &[RegionMesh]) -> Totals {
    let sum = |count: fn(&RegionMesh) -> usize| meshes.iter().map(count).sum();
    Totals {
        regions: meshes.len(),
        input_vertices: regions.iter().map(Region::vertex_count).sum(),
        vertices: sum(|mesh| mesh.vertices_ecef.len()),
        triangles: sum(|mesh| mesh.triangles.len()),
        boundary_edges: sum(RegionMesh::boundary_edge_count),
        holes: sum(|mesh| mesh.holes),
        area_m2: meshes.iter().map(|mesh| mesh.area_m2).sum(),
        bytes: bytes(meshes),
    }
}

fn table(output: &MeshOutput) -> String {
    let mut text = format!(
        "{:>5}  {:<32} {:>9} {:>9} {:>9} {:>14}\n",
        "index", "name", "vertices", "triangles", "boundary", "area km²"
    );
    for region in &output.regions {
        let name: String = region.name.chars().take(32).collect();
        text += &format!(
            "{:>5}  {name:<32} {:>9} {:>9} {:>9} {:>14.1}\n",
            region.index,
            region.vertices,
            region.triangles,
            region.boundary_edges,
            region.area_m2 * 1e-6
        );
        for warning in &region.warnings {
            text += &format!("       {warning}\n");
        }
    }
    let totals = &output.totals;
    text += &format!(
        "{} regions, {} input vertices, {} vertices, {} triangles, {:.1} km² in {:.0} ms\n",
        totals.regions,
        totals.input_vertices,
        totals.vertices,
        totals.triangles,
        totals.area_m2 * 1e-6,
        output.elapsed_ms
    );
    for (layout, bytes) in &totals.bytes {
        text += &format!("{layout}: {bytes} bytes\n");
    }
    text
}
