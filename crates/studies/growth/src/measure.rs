// SPDX-License-Identifier: MIT OR Apache-2.0
//! One build of a mesh, from the text of its outline on, by process CPU time.
//!
//! Every build is a process of its own where there is a program to start ([`GrowthProgram`]), as a
//! user's build is. In a process that has already loaded scenes and meshed shapes, the allocator has
//! memory to hand out again. That is enough for a hundred thousand vertices and not for a million:
//! arrays above 32 MiB glibc requests from the system every time. That alone made the growth from one
//! to the other a tenth steeper than it is. Nor does that process make the shape: it reads it from a
//! file, as a user's build does.

use std::path::{Path, PathBuf};
use std::process::Command;
use terrafill_contract::CpuStopwatch;
use terrafill_core::{EdgeRule, Ellipsoid, MeshOptions, RegionMesh, parse_regions};

/// What measures one build in a process of its own.
#[derive(Debug, Clone)]
pub struct GrowthProgram {
    /// Executable.
    pub path: PathBuf,
    /// First argument; a file of GeoJSON follows. It prints what [`growth_sample`] returns.
    pub verb: &'static str,
}

impl GrowthProgram {
    /// Vertices of the outline in `file` and milliseconds of one build.
    ///
    /// # Errors
    /// What the program said, or why it could not be started.
    pub(crate) fn measure(&self, file: &Path) -> Result<(u64, f64), String> {
        let output = Command::new(&self.path)
            .arg(self.verb)
            .arg(file)
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
/// A message with the file's name where it cannot be read or its region does not mesh.
pub fn growth_sample(file: &Path) -> Result<String, String> {
    let sample = measure_here(file);
    let (vertices, cpu_ms) = sample.map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(format!("{vertices} {cpu_ms}\n"))
}

/// The same in this process: vertices of the outline and CPU time from its text to its mesh.
pub(crate) fn measure_here(file: &Path) -> Result<(u64, f64), String> {
    let text = std::fs::read(file).map_err(|error| error.to_string())?;
    let watch = CpuStopwatch::start();
    let regions = parse_regions(&text, "shape").map_err(|error| error.to_string())?;
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
    use terrafill_core::ShapeFamily;

    #[test]
    fn a_program_that_says_nothing_or_fails_is_no_measurement() {
        let program = |path: &str, verb| GrowthProgram {
            path: PathBuf::from(path),
            verb,
        };
        let measure = |program: GrowthProgram| program.measure(Path::new(""));
        for wrong in [
            program("true", ""),
            program("echo", "1000"),
            program("echo", "1000 -1"),
        ] {
            assert!(measure(wrong).is_err());
        }
        let error = measure(program("no such program", ""));
        assert!(error.is_err_and(|error| error.contains("no such program")));
        // Negative control: two numbers are a measurement, and what a build prints are such.
        assert_eq!(measure(program("echo", "1000 0.5")), Ok((1000, 0.5)));
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("circle.geojson");
        std::fs::write(&file, ShapeFamily::Circle.geojson(1_000)).expect("writable");
        let sample = growth_sample(&file).expect("meshes");
        let mut words = sample.split_whitespace();
        assert_eq!(words.next(), Some("1000"));
        let cpu_ms: f64 = words.next().expect("a time").parse().expect("a number");
        assert!(cpu_ms > 0.0 && words.next().is_none());
        let missing = growth_sample(&folder.path().join("none.geojson"));
        assert!(missing.is_err_and(|error| error.contains("none.geojson")));
    }
}
