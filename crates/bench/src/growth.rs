// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the cost of a mesh, from the text of its outline on, grows with its vertices.
//!
//! CPU time of the process, which is this thread's here: nothing else of the run is at work. Families
//! and sizes take turns, so that whatever else the machine does falls on all of them alike.

use crate::BenchError;
use std::collections::BTreeSet;
use terrafill_core::{EdgeRule, Ellipsoid, MeshOptions, RegionMesh, parse_regions};
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
    // A shape has about the vertices asked for, so rows are known by the nearest size.
    let nearest = |vertices: u64| {
        SIZES
            .into_iter()
            .min_by_key(|s| u64::from(*s).abs_diff(vertices))
    };
    let done: BTreeSet<(String, Option<u32>, u32)> = folder
        .growth()?
        .into_iter()
        .map(|row| (row.shape, nearest(row.outline_vertices), row.repetition))
        .collect();
    let shapes: Vec<(ShapeFamily, u32, String)> = sizes
        .iter()
        .flat_map(|size| ShapeFamily::ALL.map(|family| (family, *size, family.geojson(*size))))
        .collect();
    for repetition in 0..REPETITIONS {
        for (family, asked, text) in &shapes {
            if done.contains(&(family.name().to_owned(), Some(*asked), repetition)) {
                continue;
            }
            let measured = mesh_ready(text, family.name()).map_err(|message| BenchError::Growth {
                shape: family.name(),
                message,
            });
            let (vertices, cpu_ms) = measured?;
            folder.append_growth(&GrowthRow {
                shape: family.name().to_owned(),
                outline_vertices: vertices,
                repetition,
                mesh_cpu_ms: cpu_ms,
            })?;
        }
    }
    Ok(())
}

/// Vertices of the outline and CPU time from its text to its mesh.
fn mesh_ready(text: &str, name: &str) -> Result<(u64, f64), String> {
    let watch = CpuStopwatch::start();
    let regions = parse_regions(text.as_bytes(), name).map_err(|error| error.to_string())?;
    let region = regions.first().ok_or("no region")?;
    let (body, options) = (Ellipsoid::WGS84, MeshOptions::default());
    let mesh = RegionMesh::build(region, &body, EdgeRule::Planar, &options);
    let cpu_ms = watch.cpu_ms();
    let mesh = mesh.map_err(|error| error.to_string())?;
    if mesh.boundary_edge_count() < region.vertex_count() {
        return Err("the mesh lost edges".to_owned());
    }
    Ok((region.vertex_count() as u64, cpu_ms))
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
