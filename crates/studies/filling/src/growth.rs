// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the cost of a mesh, from the text of its outline on, grows with its vertices.
//!
//! CPU time of the process, which is this thread's here: nothing else of the run is at work. Families
//! and sizes take turns, so that whatever else the machine does falls on all of them alike.
//!
//! Every build is a process of its own where there is a program to start ([`GrowthProgram`]), as a
//! user's build is. In a process that has scenes loaded and shapes meshed already the allocator has
//! memory to hand out again, whose pages are there: enough for a hundred thousand vertices and not for
//! a million, whose arrays are above the 32 MiB from which on glibc asks the system every time. That
//! alone made the growth from one to the other a tenth steeper than it is. Nor does that process make
//! the shape: it reads it from a file, as a user's build does.

use crate::BenchError;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use terrafill_core::{EdgeRule, Ellipsoid, MeshOptions, RegionMesh, parse_regions};
use terrafill_gpu::CpuStopwatch;
use terrafill_results::legacy::{GrowthRow, RunFolder};
use terrafill_scene::ShapeFamily;

/// Vertices asked for; a quick run measures the first three.
const SIZES: [u32; 5] = [1_000, 10_000, 100_000, 300_000, 1_000_000];
const QUICK_SIZES: usize = 3;
/// Builds of each shape and size.
const REPETITIONS: u32 = 5;

/// What measures one build in a process of its own.
#[derive(Debug, Clone)]
pub struct GrowthProgram {
    /// Executable.
    pub path: PathBuf,
    /// First argument; a file of GeoJSON follows. It is to print what [`growth_sample`] returns.
    pub verb: &'static str,
}

impl GrowthProgram {
    fn measure(&self, shape: &str) -> Result<(u64, f64), String> {
        let file = tempfile::NamedTempFile::new()
            .map_err(|error| format!("{}: {error}", std::env::temp_dir().display()))?;
        std::fs::write(&file, shape)
            .map_err(|error| format!("{}: {error}", file.path().display()))?;
        let output = Command::new(&self.path)
            .arg(self.verb)
            .arg(file.path())
            .output()
            .map_err(|error| format!("{}: {error}", self.path.display()))?;
        let text = String::from_utf8_lossy(&output.stdout);
        let mut words = text.split_whitespace();
        let vertices = words.next().and_then(|word| word.parse().ok());
        let cpu_ms = words.next().and_then(|word| word.parse().ok());
        vertices
            .zip(cpu_ms)
            .filter(|(_, cpu_ms)| output.status.success() && *cpu_ms > 0.0)
            .ok_or_else(|| {
                let said = String::from_utf8_lossy(&output.stderr);
                format!("{} {}: {text}{said}", self.path.display(), self.verb)
            })
    }
}

/// Meshes the first region of a file and says, in a line, how many vertices its outline has and what
/// CPU time its mesh took from its text on, milliseconds.
///
/// # Errors
/// [`BenchError::Growth`] where the file cannot be read or its region does not mesh.
pub fn growth_sample(file: &Path) -> Result<String, BenchError> {
    let shape = file.display().to_string();
    let sample = std::fs::read(file)
        .map_err(|error| error.to_string())
        .and_then(|text| mesh_ready(&text));
    match sample {
        Ok((vertices, cpu_ms)) => Ok(format!("{vertices} {cpu_ms}\n")),
        Err(message) => Err(BenchError::Growth { shape, message }),
    }
}

/// Measures what the run's folder does not have yet and appends row by row; in this process without
/// a program.
///
/// # Errors
/// [`BenchError::Growth`] where a shape does not mesh, a fault of this program; else a folder that
/// cannot be read or written.
pub(crate) fn measure(
    folder: &RunFolder,
    quick: bool,
    program: Option<&GrowthProgram>,
) -> Result<(), BenchError> {
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
    let shapes = || {
        let families = |size| ShapeFamily::ALL.map(|family| (family, size));
        sizes.iter().copied().flat_map(families)
    };
    for (repetition, (family, asked)) in
        (0..REPETITIONS).flat_map(|i| shapes().map(move |s| (i, s)))
    {
        if done.contains(&(family.name().to_owned(), Some(asked), repetition)) {
            continue;
        }
        let text = family.geojson(asked);
        let measured = match program {
            Some(program) => program.measure(&text),
            None => mesh_ready(text.as_bytes()),
        };
        let (vertices, cpu_ms) = measured.map_err(|message| BenchError::Growth {
            shape: family.name().to_owned(),
            message,
        })?;
        folder.append_growth(&GrowthRow {
            shape: family.name().to_owned(),
            outline_vertices: vertices,
            repetition,
            mesh_cpu_ms: cpu_ms,
        })?;
    }
    Ok(())
}

/// Vertices of the outline and CPU time from its text to its mesh.
fn mesh_ready(text: &[u8]) -> Result<(u64, f64), String> {
    let watch = CpuStopwatch::start();
    let regions = parse_regions(text, "shape").map_err(|error| error.to_string())?;
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
    use terrafill_results::legacy::{RunEnvironment, RunPlan};

    #[test]
    fn every_family_and_size_is_measured_once_and_again_only_where_missing() {
        let folder = tempfile::tempdir().expect("a folder");
        let run = RunFolder::create(
            folder.path(),
            &RunEnvironment::default(),
            &RunPlan::default(),
        )
        .expect("an empty folder");
        measure(&run, true, None).expect("measures");
        let rows = run.growth().expect("rows");
        assert_eq!(
            rows.len(),
            ShapeFamily::ALL.len() * QUICK_SIZES * REPETITIONS as usize
        );
        assert!(rows.iter().all(|row| row.mesh_cpu_ms > 0.0));
        let file = folder.path().join("growth.csv");
        let whole = std::fs::read_to_string(&file).expect("text");
        measure(&run, true, None).expect("nothing to do");
        assert_eq!(std::fs::read_to_string(&file).expect("text"), whole);
        // Twin: without its last row, that one is measured.
        let end = whole.trim_end().rfind('\n').expect("rows") + 1;
        std::fs::write(&file, &whole[..end]).expect("writable");
        measure(&run, true, None).expect("measures");
        assert_eq!(run.growth().expect("rows").len(), rows.len());
        let again = std::fs::read_to_string(&file).expect("text");
        assert!(again.starts_with(&whole[..end]));
    }

    #[test]
    fn a_program_that_says_nothing_or_fails_is_no_measurement() {
        let folder = tempfile::tempdir().expect("a folder");
        let run = RunFolder::create(
            folder.path(),
            &RunEnvironment::default(),
            &RunPlan::default(),
        )
        .expect("an empty folder");
        let program = |path: &str, verb| GrowthProgram {
            path: PathBuf::from(path),
            verb,
        };
        for wrong in [
            program("true", ""),
            program("echo", "1000"),
            program("echo", "1000 -1"),
        ] {
            let error = measure(&run, true, Some(&wrong)).expect_err("nothing was measured");
            assert!(matches!(error, BenchError::Growth { .. }), "{error}");
        }
        let error = measure(&run, true, Some(&program("no such program", "")));
        assert!(error.is_err_and(|error| error.to_string().contains("no such program")));
        assert_eq!(run.growth().expect("no rows").len(), 0);
        // Twin: two numbers are one, and what a build says of itself are such.
        measure(&run, true, Some(&program("echo", "1000 0.5"))).expect("measured");
        assert!(
            run.growth()
                .expect("rows")
                .iter()
                .all(|row| row.mesh_cpu_ms == 0.5)
        );
        let file = folder.path().join("circle.geojson");
        std::fs::write(&file, ShapeFamily::Circle.geojson(1_000)).expect("writable");
        let sample = growth_sample(&file).expect("meshes");
        let mut words = sample.split_whitespace();
        assert_eq!(words.next(), Some("1000"));
        let cpu_ms: f64 = words.next().expect("a time").parse().expect("a number");
        assert!(cpu_ms > 0.0 && words.next().is_none());
    }
}
