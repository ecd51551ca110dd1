// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the cost of a mesh grows with the vertices of its outline, family by family.
//!
//! CPU time of the process, which is this thread's here: nothing else of the run is at work. Families
//! and sizes take turns, so that whatever else the machine does falls on all of them alike.

use crate::BenchError;
use std::collections::BTreeSet;
use terrafill_core::{EdgeRule, Ellipsoid, MeshOptions, Region, RegionMesh, parse_regions};
use terrafill_gpu::CpuStopwatch;
use terrafill_results::{GrowthRow, RunFolder};
use terrafill_scene::ShapeFamily;

/// Vertices asked for; a quick run measures the first three.
const SIZES: [u32; 5] = [1_000, 10_000, 100_000, 300_000, 1_000_000];
const QUICK_SIZES: usize = 3;
/// Builds of each shape and size.
const REPETITIONS: u32 = 3;

/// Measures what the run's folder does not have yet and appends row by row.
///
/// # Errors
/// [`BenchError::Growth`] where a shape does not mesh, a fault of this program; else a folder that
/// cannot be read or written.
pub(crate) fn measure(folder: &RunFolder, quick: bool) -> Result<(), BenchError> {
    let sizes = &SIZES[..if quick { QUICK_SIZES } else { SIZES.len() }];
    let done: BTreeSet<(String, u64, u32)> = folder
        .growth()?
        .into_iter()
        .map(|row| (row.shape, row.outline_vertices, row.repetition))
        .collect();
    // Size by size, so that no more than one size's shapes are in memory.
    for &size in sizes {
        let regions = ShapeFamily::ALL.map(|family| outline(family, size));
        for repetition in 0..REPETITIONS {
            for (family, region) in ShapeFamily::ALL.iter().zip(&regions) {
                let region = region
                    .as_ref()
                    .map_err(|what| growth_error(*family, what))?;
                let vertices = region.vertex_count() as u64;
                if done.contains(&(family.name().to_owned(), vertices, repetition)) {
                    continue;
                }
                folder.append_growth(&GrowthRow {
                    shape: family.name().to_owned(),
                    outline_vertices: vertices,
                    repetition,
                    mesh_cpu_ms: build_cpu_ms(region)
                        .map_err(|what| growth_error(*family, &what))?,
                })?;
            }
        }
    }
    Ok(())
}

fn growth_error(family: ShapeFamily, what: &str) -> BenchError {
    BenchError::Growth {
        shape: family.name(),
        message: what.to_owned(),
    }
}

fn outline(family: ShapeFamily, size: u32) -> Result<Region, String> {
    let text = family.geojson(size);
    let regions = parse_regions(text.as_bytes(), family.name()).map_err(|e| e.to_string())?;
    regions.into_iter().next().ok_or("no region".to_owned())
}

fn build_cpu_ms(region: &Region) -> Result<f64, String> {
    let (body, options) = (Ellipsoid::WGS84, MeshOptions::default());
    let watch = CpuStopwatch::start();
    let mesh = RegionMesh::build(region, &body, EdgeRule::Planar, &options);
    let cpu_ms = watch.cpu_ms();
    let mesh = mesh.map_err(|error| error.to_string())?;
    if mesh.boundary_edge_count() < region.vertex_count() {
        return Err("the mesh lost edges".to_owned());
    }
    Ok(cpu_ms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::{RunEnvironment, RunPlan};

    #[test]
    fn every_family_and_size_is_measured_once_and_again_only_where_missing() {
        let folder = tempfile::tempdir().expect("a folder");
        let run = RunFolder::create(
            folder.path(),
            &RunEnvironment::default(),
            &RunPlan::default(),
        )
        .expect("an empty folder");
        measure(&run, true).expect("measures");
        let rows = run.growth().expect("rows");
        assert_eq!(rows.len(), ShapeFamily::ALL.len() * QUICK_SIZES * 3);
        assert!(rows.iter().all(|row| row.mesh_cpu_ms > 0.0));
        let file = folder.path().join("growth.csv");
        let whole = std::fs::read_to_string(&file).expect("text");
        measure(&run, true).expect("nothing to do");
        assert_eq!(std::fs::read_to_string(&file).expect("text"), whole);
        // Twin: without its last row, that one is measured.
        let end = whole.trim_end().rfind('\n').expect("rows") + 1;
        std::fs::write(&file, &whole[..end]).expect("writable");
        measure(&run, true).expect("measures");
        assert_eq!(run.growth().expect("rows").len(), rows.len());
        let again = std::fs::read_to_string(&file).expect("text");
        assert!(again.starts_with(&whole[..end]));
    }
}
