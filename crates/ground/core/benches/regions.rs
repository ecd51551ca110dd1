// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reading and meshing: CPU time of the process, all threads together, per vertex of the file.
//!
//! `cargo bench -p terrafill-core --bench regions`. CPU time rather than the clock, since it is the
//! steadier one on a busy machine. Real outlines are taken from where `TERRAFILL_DATA` says;
//! without them only the made-up shapes are measured.

#![allow(clippy::print_stdout, reason = "a bench that is skipped says why")]
// The macros of criterion make functions without documentation.
#![allow(missing_docs, reason = "what criterion's macros expand to has none")]

use criterion::measurement::{Measurement, ValueFormatter};
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group};
use rustix::time::{ClockId, clock_gettime};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::Command;
use terrafill_core::{
    EdgeRule, Ellipsoid, MeshOptions, Region, RegionMesh, ShapeFamily, parse_regions,
};

const FILES: [&str; 5] = [
    "ne_110m_admin_0_countries.geojson",
    "ne_50m_admin_0_countries.geojson",
    "ne_10m_admin_0_countries.geojson",
    "us_counties_10m.geojson",
    "san_francisco_neighborhoods.geojson",
];

/// CPU time of the process, nanoseconds.
struct CpuTime;

impl Measurement for CpuTime {
    type Intermediate = i64;
    type Value = i64;

    fn start(&self) -> i64 {
        let now = clock_gettime(ClockId::ProcessCPUTime);
        now.tv_sec * 1_000_000_000 + now.tv_nsec
    }

    fn end(&self, start: i64) -> i64 {
        self.start() - start
    }

    fn add(&self, a: &i64, b: &i64) -> i64 {
        a + b
    }

    fn zero(&self) -> i64 {
        0
    }

    fn to_f64(&self, value: &i64) -> f64 {
        *value as f64
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        &PerVertex
    }
}

/// Milliseconds, and nanoseconds per vertex where criterion speaks of throughput.
struct PerVertex;

impl ValueFormatter for PerVertex {
    fn scale_values(&self, _: f64, values: &mut [f64]) -> &'static str {
        for value in values.iter_mut() {
            *value *= 1e-6;
        }
        "ms CPU"
    }

    fn scale_throughputs(&self, _: f64, unit: &Throughput, values: &mut [f64]) -> &'static str {
        if let Throughput::Elements(vertices) = unit {
            let vertices = *vertices as f64;
            for value in values.iter_mut() {
                *value /= vertices;
            }
        }
        "ns/vertex"
    }

    fn scale_for_machines(&self, _: &mut [f64]) -> &'static str {
        "ns"
    }
}

fn read(bytes: &[u8], name: &str) -> Vec<Region> {
    let mut regions = parse_regions(bytes, name).expect("valid");
    for region in &mut regions {
        region.split_at_crossings(EdgeRule::Planar);
    }
    regions
}

fn mesh(regions: &[Region], rule: EdgeRule) -> Vec<RegionMesh> {
    let body = Ellipsoid::WGS84;
    RegionMesh::build_all(regions, &body, rule, &MeshOptions::default()).expect("meshes")
}

fn vertices(regions: &[Region]) -> u64 {
    regions
        .iter()
        .map(|region| region.vertex_count() as u64)
        .sum()
}

/// One row each for reading, repairing and meshing.
fn stages(group: &mut BenchmarkGroup<'_, CpuTime>, name: &str, bytes: &[u8]) {
    let regions = read(bytes, name);
    group.throughput(Throughput::Elements(vertices(&regions)));
    group.sample_size(10);
    group.bench_function(format!("{name}/parse"), |bencher| {
        bencher.iter(|| parse_regions(black_box(bytes), name));
    });
    group.bench_function(format!("{name}/repair"), |bencher| {
        bencher.iter_batched(
            || regions.clone(),
            |mut regions| {
                for region in &mut regions {
                    region.split_at_crossings(EdgeRule::Planar);
                }
                regions
            },
            criterion::BatchSize::PerIteration,
        );
    });
    group.bench_function(format!("{name}/mesh planar"), |bencher| {
        bencher.iter(|| mesh(black_box(&regions), EdgeRule::Planar));
    });
    group.bench_function(format!("{name}/check"), |bencher| {
        let meshes = mesh(&regions, EdgeRule::Planar);
        bencher.iter(|| {
            for mesh in &meshes {
                mesh.check_invariants(&Ellipsoid::WGS84).expect("sound");
            }
        });
    });
}

fn real_files(criterion: &mut Criterion<CpuTime>) {
    let Some(root) = std::env::var_os("TERRAFILL_DATA").map(PathBuf::from) else {
        println!("real files skipped: TERRAFILL_DATA is not set");
        return;
    };
    // Benches run in the crate's folder; a relative path is meant from the workspace.
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let folder = workspace.join(root).join("vectors");
    let mut group = criterion.benchmark_group("files");
    for name in FILES {
        match std::fs::read(folder.join(name)) {
            Ok(bytes) => {
                let peak = peak_bytes_of(&folder.join(name));
                let peak = peak.map_or("not known".to_owned(), |bytes| bytes.to_string());
                println!("{name}: peak bytes of reading and meshing: {peak}");
                stages(&mut group, name, &bytes);
            }
            Err(error) => println!("{name} skipped: {error}"),
        }
    }
    group.finish();
}

fn made_up_shapes(criterion: &mut Criterion<CpuTime>) {
    let mut group = criterion.benchmark_group("shapes");
    for shape in ShapeFamily::ALL {
        for size in [10_000, 100_000] {
            let text = shape.geojson(size);
            stages(
                &mut group,
                &format!("{} {size}", shape.name()),
                text.as_bytes(),
            );
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().with_measurement(CpuTime);
    targets = real_files, made_up_shapes
}
/// Names the file whose reading and meshing a process of this program is for.
const PEAK_OF: &str = "TERRAFILL_PEAK_OF";

/// Peak of memory of a process of its own that reads and meshes one file, where `/proc` tells.
fn peak_bytes_of(file: &Path) -> Option<u64> {
    let this = std::env::current_exe().ok()?;
    let output = Command::new(this).env(PEAK_OF, file).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

fn print_own_peak(file: &Path) {
    let bytes = std::fs::read(file).expect("readable");
    black_box(mesh(&read(&bytes, "peak"), EdgeRule::Planar));
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    if let Some(kibibytes) = kibibytes {
        println!("{}", kibibytes * 1024);
    }
}

fn main() {
    if let Some(file) = std::env::var_os(PEAK_OF) {
        return print_own_peak(Path::new(&file));
    }
    benches();
    Criterion::default().configure_from_args().final_summary();
}
