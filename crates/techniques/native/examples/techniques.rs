// SPDX-License-Identifier: MIT OR Apache-2.0
//! Process CPU time of every technique's fill on the views of a shipped scene, interleaved, against
//! `vs-control`; its bytes, and what its strips are like.
//!
//! usage: cargo run --release -p terrafill-native --example techniques [SCENE [ROUNDS [SIZE]]]

use std::error::Error;
use std::time::Instant;
use terrafill_contract::{FillBackend as _, FillInput, PreparedScene};
use terrafill_core::RegionMesh;
use terrafill_native::{
    Extrusion, Indices, NativeBackend, NativeVariant, StripCounts, native_bytes, strip_counts,
};
use terrafill_plan::{LazyMesh, PlanOptions};
use terrafill_scene::{ImageSize, Scene, data_dir_from_env};
use terrafill_surface::{EllipsoidKind, open_surface};
use terrafill_variant::Switches;
use terrafill_vulkan::{Gpu, GpuOptions, RenderTargets};

#[allow(
    clippy::print_stdout,
    reason = "an example's results go to standard output"
)]
fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let name = arguments.first().map_or("planet-134", String::as_str);
    let rounds: usize = arguments.get(1).map_or(Ok(21), |text| text.parse())?;
    let side: u32 = arguments.get(2).map_or(Ok(1024), |text| text.parse())?;
    let size = ImageSize::new(side, side);
    let scene = Scene::shipped(name, data_dir_from_env().as_deref())?;
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh)
        .map_err(|errors| format!("{errors:?}"))?;
    let surface = open_surface(&[&EllipsoidKind], &scene)?;
    let prepared = PreparedScene::new(&scene, meshes.into(), surface);
    let gpu = Gpu::open(&GpuOptions::default())?;
    println!(
        "{name}, {side} × {side}, {rounds} rounds, {}",
        gpu.facts.name
    );
    let variants = variants(Switches::for_overlap(scene.overlap));
    let mut control = None;
    for variant in &variants {
        let of = (variant.technique, variant.indices());
        let bytes = |mesh: &LazyMesh| native_bytes(of.0, of.1, mesh).total();
        let bytes: u64 = prepared.meshes.iter().map(bytes).sum();
        let share = bytes as f64 / *control.get_or_insert(bytes as f64);
        println!("{:>28}: {bytes} bytes, {share:.3}", name_of(*variant));
    }
    println!("{}", strips_of(&prepared.meshes));
    for view in &scene.views {
        let input = FillInput::new(&prepared, view, size, PlanOptions::default())?;
        let targets = RenderTargets::shared(&gpu, size)?;
        let mut backends = Vec::new();
        for &variant in &variants {
            let mut backend = NativeBackend::new(&targets, variant)?;
            backend.prepare(&input)?;
            let counted = backend.render(&input)?.counters.unwrap_or_default();
            println!(
                "{:>10} {:>28}: {} indices, {:?} vertices shaded, {:?} inputs and {:?} primitives \
                 of geometry shaders",
                view.name,
                name_of(variant),
                counted.vertices,
                counted.vertex_shader_invocations,
                inputs(variant, &input),
                counted.geometry_shader_primitives,
            );
            backends.push((backend, Vec::new()));
        }
        targets.borrow_mut().draw_surface()?;
        for round in 0..rounds + 2 {
            let count = backends.len();
            for place in 0..count {
                let (backend, times) = &mut backends[(place + round) % count];
                let frame = backend.time_frame(&input)?;
                if round >= 2 {
                    times.push(frame.fill_cpu_ms);
                }
            }
        }
        let mut control = None;
        for (backend, times) in &mut backends {
            times.sort_by(f64::total_cmp);
            let median = times[times.len() / 2];
            let against = median / *control.get_or_insert(median);
            let name = name_of(backend.variant());
            println!(
                "{:>10} {name:>28}: {median:8.2} ms CPU, {against:.3} × vs-control, \
                 quartiles {:.2} … {:.2}",
                view.name,
                times[times.len() / 4],
                times[times.len() * 3 / 4]
            );
        }
    }
    Ok(())
}

/// Inputs of the geometry shaders of the regions in view, as a test holds them to be; `None` for
/// techniques without strips.
fn inputs(variant: NativeVariant, input: &FillInput) -> Option<usize> {
    let of = |mesh: &RegionMesh| {
        let (triangles, edges) = (mesh.triangle_count(), mesh.boundary_edge_count());
        let in_strips = triangles + strip_counts(mesh).repeated;
        match (variant.technique, variant.indices()) {
            (Extrusion::GsDegenerate, Indices::List) => Some(triangles + edges),
            (Extrusion::GsDegenerate, Indices::Strip) => {
                Some(in_strips + 2 * edges - mesh.boundary_loops.len())
            }
            (Extrusion::GsAdjacency, Indices::List) => Some(triangles),
            (Extrusion::GsAdjacency, Indices::Strip) => Some(in_strips),
            _ => None,
        }
    };
    let planned = input.plan.regions.iter();
    planned
        .map(|region| of(&input.scene.meshes[region.mesh]))
        .sum()
}

/// Technique and indices.
fn name_of(variant: NativeVariant) -> String {
    format!("{} {}", variant.technique.name(), variant.indices().name())
}

/// Every technique in lists, and in strips where it has them.
fn variants(switches: Switches) -> Vec<NativeVariant> {
    let of = |technique, indices| NativeVariant {
        technique,
        indices: Some(indices),
        switches,
        ..NativeVariant::default()
    };
    let lists = Extrusion::ALL.map(|technique| of(technique, Indices::List));
    let own = Extrusion::ALL.into_iter();
    let own = own.filter(|technique| technique.has_index_choice());
    let strips = own.map(|technique| of(technique, Indices::Strip));
    lists.into_iter().chain(strips).collect()
}

/// The strips of all meshes, and how long it takes to find them.
fn strips_of(meshes: &[LazyMesh]) -> String {
    let start = Instant::now();
    let counts = meshes.iter().map(|mesh| strip_counts(mesh));
    let total = counts.fold(StripCounts::default(), |a, b| StripCounts {
        triangles: a.triangles + b.triangles,
        strips: a.strips + b.strips,
        repeated: a.repeated + b.repeated,
    });
    let elapsed_ms = start.elapsed().as_secs_f64() * 1e3;
    let StripCounts {
        triangles,
        strips,
        repeated,
    } = total;
    let indices = triangles + 3 * strips + repeated;
    format!(
        "{triangles} triangles in {strips} strips of {:.2}, {repeated} corners repeated, \
         {:.3} indices a triangle with restarts, found in {elapsed_ms:.1} ms",
        triangles as f64 / strips as f64,
        indices as f64 / triangles as f64,
    )
}
