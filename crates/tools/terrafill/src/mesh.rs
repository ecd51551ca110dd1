// SPDX-License-Identifier: MIT OR Apache-2.0
//! `mesh`: what becomes of a file's regions.

use crate::arguments::MeshArguments;
use crate::outcome::{Failure, Outcome, complain, print, print_json};
use crate::regions::{FeatureProblem, Leniency, Meshed, read_and_mesh, report_skipped};
use crate::registry::TECHNIQUES;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Instant;
use terrafill_contract::layouts;
use terrafill_core::{EdgeRule, MeshOptions, Region, RegionMesh, printable};
use terrafill_scene::Overlap;

#[derive(Serialize)]
struct MeshOutput {
    file: String,
    edges: &'static str,
    body: &'static str,
    regions: Vec<MeshedRegion>,
    /// Features left out by `--skip-invalid`.
    errors: Vec<FeatureProblem>,
    /// About the file as a whole.
    warnings: Vec<String>,
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
    /// The region's own, by layout.
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
    /// Sums of the regions' own.
    bytes: BTreeMap<String, u64>,
    /// What all regions share and is held once; layouts that share nothing are not listed.
    shared_bytes: BTreeMap<String, u64>,
}

pub(crate) fn run(arguments: &MeshArguments) -> Result<Outcome, Failure> {
    for warning in arguments.unused.warnings() {
        complain(warning);
    }
    let options = MeshOptions {
        boundary_tolerance_m: arguments.boundary_tolerance_m,
        cap_step_deg: arguments.cap_step_deg,
    };
    let (path, body) = (&arguments.regions, &arguments.body);
    let edges: EdgeRule = arguments.edges.into();
    let start = Instant::now();
    let leniency = Leniency {
        repair: arguments.repair.map(Into::into),
        skip_invalid: arguments.skip_invalid,
    };
    let Meshed {
        regions,
        meshes,
        skipped,
        warnings,
    } = read_and_mesh(
        path,
        arguments.reading.into(),
        leniency,
        body,
        edges,
        &options,
    )?;
    report_skipped(&skipped);
    let meshed: Vec<MeshedRegion> = meshes.par_iter().map(describe).collect();
    let output = MeshOutput {
        file: path.display().to_string(),
        edges: edges.name(),
        body: body.name(),
        totals: totals(&regions, &meshes, &meshed),
        regions: meshed,
        errors: skipped,
        warnings,
        elapsed_ms: start.elapsed().as_secs_f64() * 1e3,
    };
    if arguments.json {
        print_json(&output)?;
    } else {
        print(table(&output))?;
    }
    Ok(Outcome::Done)
}

/// By the formulas that the techniques' own tests hold to the buffers as built.
fn bytes(mesh: &RegionMesh) -> BTreeMap<String, u64> {
    let all = TECHNIQUES.iter().flat_map(|technique| {
        let layouts = technique.layout_bytes(mesh).into_iter();
        layouts.map(|(layout, bytes)| (format!("{}/{layout}", technique.name()), bytes))
    });
    all.collect()
}

fn total_bytes(meshed: &[MeshedRegion]) -> BTreeMap<String, u64> {
    let mut totals = BTreeMap::new();
    for (layout, bytes) in meshed.iter().flat_map(|region| &region.bytes) {
        *totals.entry(layout.clone()).or_default() += bytes;
    }
    totals
}

fn shared_bytes(meshes: &[RegionMesh]) -> BTreeMap<String, u64> {
    let meshes: Vec<&RegionMesh> = meshes.iter().collect();
    let all = TECHNIQUES.iter().flat_map(|technique| {
        let variants = layouts(*technique, Overlap::Disjoint).into_iter();
        variants.filter_map(|variant| {
            let bytes = technique.shared_bytes(&variant, &meshes).ok()?.total();
            let name = format!("{}/{}", technique.name(), technique.layout(&variant));
            (bytes > 0).then_some((name, bytes))
        })
    });
    all.collect()
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
        bytes: bytes(mesh),
        warnings: mesh.warnings.iter().map(ToString::to_string).collect(),
    }
}

fn totals(regions: &[Region], meshes: &[RegionMesh], meshed: &[MeshedRegion]) -> Totals {
    let sum = |count: fn(&RegionMesh) -> usize| meshes.iter().map(count).sum();
    Totals {
        regions: meshes.len(),
        input_vertices: regions.iter().map(Region::vertex_count).sum(),
        vertices: sum(|mesh| mesh.vertices_ecef.len()),
        triangles: sum(|mesh| mesh.triangles.len()),
        boundary_edges: sum(RegionMesh::boundary_edge_count),
        holes: sum(|mesh| mesh.holes),
        // Of no region the sum is −0.
        area_m2: meshes.iter().map(|mesh| mesh.area_m2).sum::<f64>() + 0.0,
        bytes: total_bytes(meshed),
        shared_bytes: shared_bytes(meshes),
    }
}

/// Characters of a name that the table shows.
const NAME_WIDTH: usize = 30;

fn table(output: &MeshOutput) -> String {
    let totals = &output.totals;
    let largest = output.regions.iter().map(|region| region.area_m2);
    let unit = AreaUnit::fitting(largest.fold(0.0, f64::max));
    let warnings: String = output
        .warnings
        .iter()
        .map(|text| warning_line(0, text))
        .collect();
    let mut text = format!(
        "{} · {} edges · {}\n{}\n{:>5}  {:<NAME_WIDTH$} {:>9} {:>9} {:>9} {:>6} {:>16}\n",
        output.file,
        output.edges,
        output.body,
        warnings,
        "index",
        "name",
        "vertices",
        "triangles",
        "boundary",
        "holes",
        unit.heading
    );
    for region in &output.regions {
        text += &format!(
            "{:>5}  {:<NAME_WIDTH$} {:>9} {:>9} {:>9} {:>6} {:>16}\n",
            region.index,
            shortened(&region.name),
            region.vertices,
            region.triangles,
            region.boundary_edges,
            region.holes,
            unit.show(region.area_m2)
        );
        for warning in &region.warnings {
            text += &warning_line(7, warning);
        }
    }
    text += &format!(
        "{:>5}  {:<NAME_WIDTH$} {:>9} {:>9} {:>9} {:>6} {:>16}\n\n",
        "",
        format!("{} regions", totals.regions),
        totals.vertices,
        totals.triangles,
        totals.boundary_edges,
        totals.holes,
        unit.show(totals.area_m2)
    );
    for (layout, bytes) in &totals.bytes {
        text += &match totals.shared_bytes.get(layout) {
            Some(shared) => format!("{layout}: {bytes} bytes and {shared} that all share\n"),
            None => format!("{layout}: {bytes} bytes\n"),
        };
    }
    text += &format!(
        "{} vertices read, meshed in {:.0} ms\n",
        totals.input_vertices, output.elapsed_ms
    );
    text
}

fn warning_line(indent: usize, warning: &str) -> String {
    format!("{:indent$}{}\n", "", printable(warning))
}

fn shortened(name: &str) -> String {
    let name = printable(name);
    if name.chars().count() <= NAME_WIDTH {
        return name.into_owned();
    }
    name.chars().take(NAME_WIDTH - 1).chain(['…']).collect()
}

/// One unit for a whole table, so that its rows can be compared at a glance.
struct AreaUnit {
    heading: &'static str,
    square_metres: f64,
    decimals: usize,
}

impl AreaUnit {
    /// Keeps the largest area above 0.1 of its unit, from countries down to a body of 1 m.
    fn fitting(largest_m2: f64) -> Self {
        let (heading, square_metres, decimals) = if largest_m2 >= 1e5 {
            ("area km²", 1e6, 3)
        } else {
            ("area m²", 1.0, 6)
        };
        Self {
            heading,
            square_metres,
            decimals,
        }
    }

    fn show(&self, area_m2: f64) -> String {
        format!("{:.*}", self.decimals, area_m2 / self.square_metres)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_of_a_country_and_of_a_pebble_keep_their_digits() {
        assert_eq!(AreaUnit::fitting(4e11).show(4.093e11), "409300.000");
        assert_eq!(AreaUnit::fitting(12.5).show(12.566_370_6), "12.566371");
    }

    #[test]
    fn long_names_are_cut_between_characters() {
        let long = "São Tomé and Príncipe and many others";
        assert_eq!(shortened(long), "São Tomé and Príncipe and man…");
        assert_eq!(shortened("Perú"), "Perú");
        assert_eq!(shortened("\u{1b}[2J"), "\\u{1b}[2J");
    }
}
