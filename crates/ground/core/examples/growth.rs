// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the cost of reading and meshing grows from 1,000 to 1,000,000 vertices, family by family.
//!
//! `growth [OUT.csv] [RUNS]` prints a table, writes `shape,vertices,cpu_ms,ns_per_vertex,peak_bytes`
//! (medians of RUNS runs, 5 by default) and fails when any family costs more than 16 times as much
//! at 10⁶ vertices as at 10⁵. CPU time of the process, all threads together, since it is steadier than
//! the clock on a busy machine. Every run is a process of its own, so that its peak of memory is its
//! own too. It includes the text of the shape, and is left empty where the system does not say. The
//! text comes from a file, as a user's does. A process that has made it itself has memory to hand out
//! again, enough for a hundred thousand vertices and not for a million.

#![allow(clippy::print_stdout, reason = "printing is what an example is for")]

use rustix::time::{ClockId, clock_gettime};
use std::path::Path;
use std::process::{Command, ExitCode};
use terrafill_core::{EdgeRule, Ellipsoid, MeshOptions, RegionMesh, ShapeFamily, parse_regions};

const SIZES: [u32; 7] = [1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000];
/// From 10⁵ to 10⁶ vertices: n log n is 12, and a third more is left for memory beyond the caches.
const STEEPEST_GROWTH: f64 = 16.0;
/// First argument of the process that makes one run.
const ONE_RUN: &str = "--one";

/// One row of the table.
struct Row {
    shape: ShapeFamily,
    vertices: u32,
    cpu_ms: f64,
    peak_bytes: Option<u64>,
}

impl Row {
    fn ns_per_vertex(&self) -> f64 {
        self.cpu_ms * 1e6 / f64::from(self.vertices)
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words[..] {
        [ONE_RUN, file] => one_run(Path::new(file)),
        [] => table(None, 5),
        [out] => table(Some(out), 5),
        [out, runs, ..] => match runs.parse() {
            Ok(runs) if runs > 0 => table(Some(out), runs),
            _ => Err(format!("{runs} is no number of runs")),
        },
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            println!("{message}");
            ExitCode::from(2)
        }
    }
}

/// Makes every run, prints and writes; whether growth is within its bound.
fn table(out: Option<&str>, runs: usize) -> Result<bool, String> {
    let mut rows = Vec::new();
    println!("shape         vertices      cpu ms  ns/vertex   peak MB");
    for shape in ShapeFamily::ALL {
        for vertices in SIZES {
            let row = median_of_runs(shape, vertices, runs)?;
            let peak = row
                .peak_bytes
                .map_or(String::new(), |bytes| format!("{:.1}", bytes as f64 / 1e6));
            println!(
                "{:<11} {:>10} {:>11.2} {:>10.0} {peak:>9}",
                shape.name(),
                vertices,
                row.cpu_ms,
                row.ns_per_vertex()
            );
            rows.push(row);
        }
    }
    if let Some(out) = out {
        std::fs::write(out, csv(&rows)).map_err(|error| format!("{out}: {error}"))?;
    }
    let mut within = true;
    for shape in ShapeFamily::ALL {
        let cpu_ms = |vertices: u32| {
            let row = rows
                .iter()
                .find(|row| row.shape == shape && row.vertices == vertices);
            row.map_or(f64::NAN, |row| row.cpu_ms)
        };
        let growth = cpu_ms(1_000_000) / cpu_ms(100_000);
        // A missing row makes it NaN, which is not within.
        within &= growth <= STEEPEST_GROWTH;
        println!("{:<11} 10⁵ → 10⁶: {growth:.1} ×", shape.name());
    }
    Ok(within)
}

fn csv(rows: &[Row]) -> String {
    let mut text = "shape,vertices,cpu_ms,ns_per_vertex,peak_bytes\n".to_owned();
    for row in rows {
        let peak = row
            .peak_bytes
            .map_or(String::new(), |bytes| bytes.to_string());
        text += &format!(
            "{},{},{:.4},{:.2},{peak}\n",
            row.shape.name(),
            row.vertices,
            row.cpu_ms,
            row.ns_per_vertex()
        );
    }
    text
}

fn median_of_runs(shape: ShapeFamily, vertices: u32, runs: usize) -> Result<Row, String> {
    let this = std::env::current_exe().map_err(|error| error.to_string())?;
    let file = tempfile::NamedTempFile::new().map_err(|error| error.to_string())?;
    std::fs::write(&file, shape.geojson(vertices)).map_err(|error| error.to_string())?;
    let mut cpu_ms = Vec::with_capacity(runs);
    let mut peak_bytes = Vec::with_capacity(runs);
    for _ in 0..runs {
        let output = Command::new(&this)
            .arg(ONE_RUN)
            .arg(file.path())
            .output()
            .map_err(|error| error.to_string())?;
        let text = String::from_utf8_lossy(&output.stdout);
        let mut words = text.split_whitespace();
        let cpu = words.next().and_then(|word| word.parse::<f64>().ok());
        let Some(cpu) = cpu.filter(|_| output.status.success()) else {
            return Err(format!("{} of {vertices}: {text}", shape.name()));
        };
        cpu_ms.push(cpu);
        peak_bytes.extend(words.next().and_then(|word| word.parse::<u64>().ok()));
    }
    cpu_ms.sort_by(f64::total_cmp);
    peak_bytes.sort_unstable();
    Ok(Row {
        shape,
        vertices,
        cpu_ms: cpu_ms[cpu_ms.len() / 2],
        peak_bytes: peak_bytes.get(peak_bytes.len() / 2).copied(),
    })
}

/// Prints CPU time in milliseconds and the peak of memory in bytes.
fn one_run(file: &Path) -> Result<bool, String> {
    let text = std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let start = clock_gettime(ClockId::ProcessCPUTime);
    let regions = parse_regions(&text, "shape").map_err(|e| e.to_string())?;
    let mesh = RegionMesh::build(
        &regions[0],
        &Ellipsoid::WGS84,
        EdgeRule::Planar,
        &MeshOptions::default(),
    )
    .map_err(|error| error.to_string())?;
    let end = clock_gettime(ClockId::ProcessCPUTime);
    let cpu_ms =
        (end.tv_sec - start.tv_sec) as f64 * 1e3 + (end.tv_nsec - start.tv_nsec) as f64 / 1e6;
    if mesh.boundary_edge_count() < regions[0].vertex_count() {
        return Err("the mesh lost edges".to_owned());
    }
    let peak = peak_bytes().map_or(String::new(), |bytes| bytes.to_string());
    println!("{cpu_ms} {peak}");
    Ok(true)
}

/// Peak of resident memory of this process, where `/proc` tells.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}
