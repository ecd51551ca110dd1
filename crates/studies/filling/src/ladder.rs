// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ladder: from the un-optimised method to the full plan, one switch at a time.
//!
//! The order is that of Cozzi (2007): one volume for each region, culling, back faces, buffer layout,
//! strips, cache order, vertex size, then depth-pass counting and the bottom cap; then what came
//! later. His last two stand the other way round here: behind the surface every cap counts, so a
//! bottom cap can be left out only where fragments in front of the surface count.
//!
//! All rungs before the last two fill every region in one colour, as his did.

use crate::matrix::LOD_PX;
use crate::technique::{Setting, Technique};
use terrafill_compute::{ComputeVariant, Expansion};
use terrafill_fill::{BottomCap, ColourWay, DepthRuleChoice, FacePasses, Switches};
use terrafill_native::{Indices, NativeVariant, Technique as Native};
use terrafill_scene::{Overlap, PlanOptions};
use terrafill_vertex::{IndexOrder, Layout, VertexSize, VertexVariant, Walls};

/// One rung.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rung {
    /// What is changed against the rung before, in one word.
    pub(crate) step: &'static str,
    /// The same in a sentence.
    pub(crate) change: &'static str,
    /// What is drawn.
    pub(crate) setting: Setting,
}

/// The ladder of `backend` on scenes of this kind; empty for a backend that has none.
pub(crate) fn ladder(backend: &str, overlap: Overlap) -> Vec<Rung> {
    match backend {
        "vertex" => vertex_ladder(overlap),
        "compute" => compute_ladder(overlap),
        "native" => native_ladder(overlap),
        _ => Vec::new(),
    }
}

/// A ladder being climbed.
struct Climb {
    rungs: Vec<Rung>,
    setting: Setting,
}

impl Climb {
    fn from(technique: Technique, change: &'static str) -> Self {
        let mut setting = Setting {
            technique,
            plan: PlanOptions {
                frustum_culling: false,
                horizon_culling: false,
                too_small_culling: false,
                ..PlanOptions::default()
            },
        };
        if let Some(switches) = setting.technique.switches_mut() {
            *switches = Switches {
                colour: ColourWay::OneColourVolumes,
                faces: FacePasses::TwoPass,
                ..Switches::default()
            };
        }
        Self {
            rungs: vec![Rung {
                step: "start",
                change,
                setting,
            }],
            setting,
        }
    }

    fn step(
        &mut self,
        step: &'static str,
        change: &'static str,
        set: impl FnOnce(&mut Setting),
    ) -> &mut Self {
        set(&mut self.setting);
        self.rungs.push(Rung {
            step,
            change,
            setting: self.setting,
        });
        self
    }

    fn switch(
        &mut self,
        step: &'static str,
        change: &'static str,
        set: impl FnOnce(&mut Switches),
    ) -> &mut Self {
        self.step(step, change, |setting| {
            if let Some(switches) = setting.technique.switches_mut() {
                set(switches);
            }
        })
    }

    fn vertex(
        &mut self,
        step: &'static str,
        change: &'static str,
        set: impl FnOnce(&mut VertexVariant),
    ) -> &mut Self {
        self.step(step, change, |setting| {
            if let Technique::Vertex(variant) = &mut setting.technique {
                set(variant);
            }
        })
    }

    fn native(
        &mut self,
        step: &'static str,
        change: &'static str,
        technique: Native,
        indices: Indices,
    ) -> &mut Self {
        self.step(step, change, |setting| {
            if let Technique::Native(variant) = &mut setting.technique {
                variant.technique = technique;
                variant.indices = Some(indices);
            }
        })
    }

    fn culling(&mut self) -> &mut Self {
        self.step(
            "culling",
            "regions outside the view frustum are left out",
            |setting| setting.plan.frustum_culling = true,
        )
        .switch(
            "back-faces",
            "covers draw front faces only, back faces where the near plane cuts the volume",
            |switches| switches.cover_culls_faces = true,
        )
    }

    /// What every backend has in common from there on.
    fn rest_of_the_way(&mut self, overlap: Overlap) -> &mut Self {
        self.switch(
            "z-pass",
            "fragments in front of the surface count, except for regions that the near plane cuts",
            |switches| switches.depth_rule = DepthRuleChoice::Automatic,
        )
        .switch(
            "bottom-cap",
            "no bottom cap where fragments in front of the surface count",
            |switches| switches.bottom_cap = BottomCap::WhereNeeded,
        )
        .switch(
            "two-sided",
            "one draw with two-sided stencil instead of one for each face",
            |switches| switches.faces = FacePasses::TwoSided,
        )
        .switch(
            "screen-cover",
            "colour by one full-screen stencil-tested triangle instead of the volumes again",
            |switches| {
                switches.colour = ColourWay::OneColour;
                switches.cover_culls_faces = false;
            },
        )
        .switch(
            "scissor",
            "each volume is cut to its region's screen rectangle",
            |switches| switches.scissor = true,
        )
        .step(
            "horizon",
            "regions that the body hides are left out",
            |setting| setting.plan.horizon_culling = true,
        )
        .step(
            "too-small",
            "regions that reach the centre of no pixel are left out",
            |setting| setting.plan.too_small_culling = true,
        )
        .switch(
            "colours",
            match overlap {
                Overlap::Disjoint => {
                    "each region in its own colour, by XOR batches and screen rectangles"
                }
                Overlap::Ordered => "each region in its own colour, one at a time",
            },
            |switches| switches.colour = Switches::for_overlap(overlap).colour,
        )
        .step(
            "boundary-lod",
            "boundaries at the coarsest level that moves none by more than half a pixel",
            |setting| setting.plan.boundary_lod_px = Some(LOD_PX),
        )
    }
}

fn vertex_ladder(overlap: Overlap) -> Vec<Rung> {
    let mut climb = Climb::from(
        Technique::Vertex(VertexVariant {
            layout: Layout::PerTriangle,
            ..VertexVariant::default()
        }),
        "a closed volume for every triangle; two passes, fragments behind the surface count, \
         nothing culled, colour by drawing the volumes again",
    );
    climb
        .vertex(
            "one-volume",
            "one volume for each region: caps, and walls along the boundary only",
            |variant| {
                variant.layout = Layout::Separate;
                variant.walls = Walls::List;
            },
        )
        .culling()
        .vertex(
            "buffer-layout",
            "flag and position in one buffer, 20 bytes a vertex, instead of the flags in their own",
            |variant| {
                variant.layout = Layout::Doubled;
                variant.vertex_size = VertexSize::Bytes20;
            },
        )
        .vertex("strips", "walls as strips instead of lists", |variant| {
            variant.walls = Walls::Strip
        })
        .vertex(
            "cache-order",
            "cap triangles in the order of a post-transform vertex cache",
            |variant| variant.index_order = IndexOrder::Cache,
        )
        .vertex(
            "vertex-size",
            "16 bytes a vertex instead of 20",
            |variant| variant.vertex_size = VertexSize::Bytes16,
        )
        .rest_of_the_way(overlap);
    climb.rungs
}

fn compute_ladder(overlap: Overlap) -> Vec<Rung> {
    let mut climb = Climb::from(
        Technique::Compute(ComputeVariant::default()),
        "a volume for each region, made every frame; two passes, fragments behind the surface \
         count, nothing culled, colour by drawing the volumes again",
    );
    climb
        .step("kept", "volumes are made once and kept", |setting| {
            if let Technique::Compute(variant) = &mut setting.technique {
                variant.expansion = Expansion::Cached;
            }
        })
        .culling()
        .rest_of_the_way(overlap);
    climb.rungs
}

fn native_ladder(overlap: Overlap) -> Vec<Rung> {
    let mut climb = Climb::from(
        Technique::Native(NativeVariant {
            technique: Native::GsPerTriangle,
            ..NativeVariant::default()
        }),
        "the geometry shader makes a closed volume of every triangle; two passes, fragments \
         behind the surface count, nothing culled, colour by drawing the volumes again",
    );
    climb
        .native(
            "one-volume",
            "one volume for each region: two caps of each triangle, a wall of each boundary edge",
            Native::GsDegenerate,
            Indices::List,
        )
        .culling()
        .native(
            "strips",
            "triangles and boundary edges in strips instead of lists",
            Native::GsDegenerate,
            Indices::Strip,
        )
        .native(
            "two-edges",
            "lists again, with two boundary edges in each index triangle",
            Native::GsTwoEdges,
            Indices::List,
        )
        .native(
            "lines",
            "boundary edges as line strips in a draw of their own instead of among the triangles",
            Native::GsLine,
            Indices::List,
        )
        .rest_of_the_way(overlap)
        // Last, since where the device has none the rungs after it would have no result either.
        .switch(
            "depth-bounds",
            "fragments over surface outside the region's depth range are dropped",
            |switches| switches.depth_bounds = true,
        );
    climb.rungs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::BACKENDS;
    use std::collections::BTreeSet;

    /// Parts of the name that one rung has and the other has not.
    fn differences(a: &Rung, b: &Rung) -> usize {
        let parts = |rung: &Rung| -> BTreeSet<String> {
            let name = rung.setting.variant_name();
            name.split(',').map(str::to_owned).collect()
        };
        parts(a).symmetric_difference(&parts(b)).count()
    }

    #[test]
    fn every_rung_changes_one_thing() {
        for backend in BACKENDS {
            for overlap in [Overlap::Disjoint, Overlap::Ordered] {
                let rungs = ladder(backend, overlap);
                assert!(rungs.len() > 10, "{backend}: {}", rungs.len());
                let names: BTreeSet<String> = rungs
                    .iter()
                    .map(|rung| rung.setting.variant_name())
                    .collect();
                assert_eq!(
                    names.len(),
                    rungs.len(),
                    "{backend}: two rungs are the same"
                );
                for pair in rungs.windows(2) {
                    // A value that becomes another one is two parts. Three: walls of single
                    // triangles are lists always, flags of their own have no vertex size, two edges
                    // in a triangle are never strips, and which faces are drawn as covers has no
                    // meaning where none are.
                    let allowed = match pair[1].step {
                        "one-volume" | "buffer-layout" | "two-edges" | "screen-cover" => 3,
                        _ => 2,
                    };
                    let found = differences(&pair[0], &pair[1]);
                    assert!(
                        (1..=allowed).contains(&found),
                        "{backend}, {}: {} → {}",
                        pair[1].step,
                        pair[0].setting.variant_name(),
                        pair[1].setting.variant_name()
                    );
                }
                // Twin: rungs that lie far apart differ in more than one switch.
                let far = differences(&rungs[0], &rungs[rungs.len() - 1]);
                assert!(far > 3, "{backend}: {far}");
            }
        }
    }

    #[test]
    fn every_rung_is_allowed_for_its_scene() {
        for backend in BACKENDS {
            for overlap in [Overlap::Disjoint, Overlap::Ordered] {
                for rung in ladder(backend, overlap) {
                    assert!(rung.setting.technique.is_allowed(overlap), "{}", rung.step);
                }
            }
        }
        assert_eq!(ladder("bound", Overlap::Disjoint), []);
    }
}
