// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which cases a scene gives.

use crate::BenchOptions;
use std::sync::Arc;
use terrafill_frame::{ColourWay, PositionFormat, Switches};
use terrafill_gpu::BaselineKind;
use terrafill_results::CaseKey;
use terrafill_scene::{Overlap, Scene, View};
use terrafill_vertex::{Layout, VertexVariant};

/// What draws a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Technique {
    /// A full-screen pass.
    Baseline(BaselineKind),
    /// The vertex backend.
    Vertex(VertexVariant),
}

/// One case: a row to be.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchCase {
    /// Its name.
    pub key: CaseKey,
    /// What draws it.
    pub technique: Technique,
    /// Boundary tolerance of its meshes, metres; `None` for baselines.
    pub boundary_tolerance_m: Option<f64>,
    /// Part of a sweep: allowed to be wrong, since its error is what the sweep is about.
    pub is_sweep: bool,
}

/// All cases of one scene and view: measured together, interleaved.
#[derive(Debug, Clone)]
pub struct SceneGroup {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its view.
    pub view: View,
    /// Baselines first.
    pub cases: Vec<BenchCase>,
}

/// The cases of `scene` seen by `view`.
#[must_use]
pub fn group_cases(scene: &Arc<Scene>, view: &View, options: &BenchOptions) -> SceneGroup {
    let key = |backend: &str, variant: String| CaseKey {
        scene: scene.name.clone(),
        view: view.name.clone(),
        backend: backend.to_owned(),
        variant,
    };
    let mut cases: Vec<BenchCase> = [BaselineKind::Bound, BaselineKind::Floor]
        .map(|kind| BenchCase {
            key: key(kind.name(), "full-screen".to_owned()),
            technique: Technique::Baseline(kind),
            boundary_tolerance_m: None,
            is_sweep: false,
        })
        .into();
    if options.backends.is_empty() || options.backends.iter().any(|name| name == "vertex") {
        for variant in vertex_variants(scene.overlap, options.quick) {
            cases.push(BenchCase {
                key: key("vertex", variant.name()),
                technique: Technique::Vertex(variant),
                boundary_tolerance_m: Some(scene.mesh.boundary_tolerance_m),
                is_sweep: false,
            });
        }
        if !options.quick {
            for layout in [Layout::Doubled, Layout::Pulled] {
                for &tolerance in &scene.sweep_boundary_tolerance_m {
                    let variant = main_variant(scene.overlap, layout);
                    let name = format!("{},boundary-tolerance-m={tolerance}", variant.name());
                    cases.push(BenchCase {
                        key: key("vertex", name),
                        technique: Technique::Vertex(variant),
                        boundary_tolerance_m: Some(tolerance),
                        is_sweep: true,
                    });
                }
            }
        }
    }
    SceneGroup {
        scene: Arc::clone(scene),
        view: view.clone(),
        cases,
    }
}

/// The colouring that is right for the scene: XOR holds for disjoint regions only.
fn main_variant(overlap: Overlap, layout: Layout) -> VertexVariant {
    VertexVariant {
        layout,
        switches: Switches::for_overlap(overlap),
        ..VertexVariant::default()
    }
}

/// Both layouts as they should be used; beside them, one switch at a time, what is compared.
fn vertex_variants(overlap: Overlap, quick: bool) -> Vec<VertexVariant> {
    let main = main_variant(overlap, Layout::Doubled);
    let mut variants = vec![main, main_variant(overlap, Layout::Pulled)];
    if !quick {
        if main.switches.colour != ColourWay::Rectangle {
            variants.push(VertexVariant {
                switches: Switches {
                    colour: ColourWay::Rectangle,
                    ..main.switches
                },
                ..main
            });
        }
        variants.push(VertexVariant {
            positions: PositionFormat::LocalF32,
            ..main
        });
    }
    variants
}
