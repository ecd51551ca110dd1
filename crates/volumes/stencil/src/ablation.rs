// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ablations: from the un-optimised method to the full plan, one switch at a time.
//!
//! Order and means are those of Cozzi (2007, 4.5): one volume for each region, frustum culling, back
//! faces culled in the colouring pass, buffers kept on the device, wall strips, vertex order, vertex size,
//! no bottom cap in the colouring pass; then what the document left for later, counting in front of the
//! surface and the order of triangles; then this project's own steps. What it tried and did not keep, what
//! it tried to learn something, and what only lies beside the way stands *aside*: measured against the
//! step before it, which is the one that the next step is measured against as well.
//!
//! All steps before the last two fill every region in one colour, as the document's did. A technique puts
//! its own steps between those that all techniques share.

use terrafill_contract::PlannedStep;
use terrafill_plan::{PartCulling, PlanOptions, WallHeights};
use terrafill_scene::Overlap;
use terrafill_variant::{
    BottomCap, ColourWay, CoverArea, DepthRuleChoice, FacePasses, FirstPass, Switches, Variant,
};

/// Deviation that boundaries may be drawn with where levels of detail are on: half a pixel stays
/// within the band in which rounding decides as well.
pub const LOD_PX: f64 = 0.5;

/// An ablation in the making.
#[derive(Debug)]
pub struct AblationBuilder {
    steps: Vec<PlannedStep>,
    variant: Variant,
}

impl AblationBuilder {
    /// The first step: `variant` with every optimisation of fill and plan switched off.
    #[must_use]
    pub fn start(mut variant: Variant, change: &'static str) -> Self {
        variant.plan = without_culling();
        variant.switches = Switches {
            colour: ColourWay::OneColourVolumes,
            faces: FacePasses::TwoPass,
            ..Switches::default()
        };
        let steps = Vec::new();
        Self { steps, variant }.step("start", change, |_| ())
    }

    /// A side step: the next one does not keep it.
    #[must_use]
    pub fn aside(
        self,
        name: &'static str,
        change: &'static str,
        set: impl FnOnce(&mut Variant),
    ) -> Self {
        let kept = self.variant.clone();
        let mut builder = self.step(name, change, set);
        builder.variant = kept;
        if let Some(step) = builder.steps.last_mut() {
            step.is_aside = true;
        }
        builder
    }

    /// The same by parameters of the technique's own, `(key, value)`.
    #[must_use]
    pub fn own_aside(
        self,
        name: &'static str,
        change: &'static str,
        values: &[(&'static str, &'static str)],
    ) -> Self {
        self.aside(name, change, |variant| *variant = set_all(variant, values))
    }

    /// One step further.
    #[must_use]
    pub fn step(
        mut self,
        name: &'static str,
        change: &'static str,
        set: impl FnOnce(&mut Variant),
    ) -> Self {
        set(&mut self.variant);
        let variant = self.variant.clone();
        self.steps.push(PlannedStep {
            name,
            change,
            variant,
            is_aside: false,
        });
        self
    }

    /// One step further by parameters of the technique's own, `(key, value)`.
    #[must_use]
    pub fn own(
        self,
        name: &'static str,
        change: &'static str,
        values: &[(&'static str, &'static str)],
    ) -> Self {
        self.step(name, change, |variant| *variant = set_all(variant, values))
    }

    /// One step further by a switch of the fill.
    #[must_use]
    pub fn switch(
        self,
        name: &'static str,
        change: &'static str,
        set: impl FnOnce(&mut Switches),
    ) -> Self {
        self.step(name, change, |variant| set(&mut variant.switches))
    }

    /// The two steps that follow the first volumes of whole regions.
    #[must_use]
    pub fn culling(self) -> Self {
        self.step(
            "culling",
            "regions outside the view frustum are left out",
            |variant| variant.plan.frustum_culling = true,
        )
        .switch(
            "back-faces",
            "covers draw front faces only, back faces where the near plane cuts the volume",
            |switches| switches.cover_culls_faces = true,
        )
    }

    /// The last of the document's own steps, and the one that it was at work on.
    #[must_use]
    pub fn caps(self) -> Self {
        self.switch(
            "bottom-cap",
            "no bottom cap in the colouring pass, except for regions that the near plane cuts",
            |switches| switches.bottom_cap = BottomCap::FirstPass,
        )
        .switch(
            "z-pass",
            "fragments in front of the surface count, and no bottom cap is drawn in either pass, except \
             for regions that the near plane cuts",
            |switches| {
                switches.depth_rule = DepthRuleChoice::Automatic;
                switches.bottom_cap = BottomCap::WhereNeeded;
            },
        )
    }

    /// What the document found out about the first pass, and which ends of walls it thought of. On
    /// wgpu, whose first pass may have fragments.
    #[must_use]
    pub fn experiments(self) -> Self {
        let first_pass = |first_pass: FirstPass| {
            move |variant: &mut Variant| variant.switches.first_pass = first_pass
        };
        self.aside(
            "first-pass-colour",
            "the first pass writes colours too, into a target that nobody reads",
            first_pass(FirstPass::Colour),
        )
        .aside(
            "first-pass-program",
            "a costly fragment program is bound in the first pass, where writing colours is disabled",
            first_pass(FirstPass::Program),
        )
        .aside(
            "first-pass-program-colour",
            "the costly program is bound in the first pass, and its colours are written",
            first_pass(FirstPass::ProgramColour),
        )
        .aside(
            "walls-global",
            "walls from 12 km below the ellipsoid to 12 km above it, by the same mesh",
            |variant| variant.plan.wall_heights = WallHeights::Global,
        )
    }

    /// What every technique has in common from there on.
    #[must_use]
    pub fn rest_of_the_way(self, overlap: Overlap) -> Self {
        self.switch(
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
            |variant| variant.plan.horizon_culling = true,
        )
        .step(
            "too-small",
            "regions that reach the centre of no pixel are left out",
            |variant| variant.plan.too_small_culling = true,
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
        .merged_draws(overlap)
        .step(
            "boundary-lod",
            "boundaries at the coarsest level that moves none by more than half a pixel",
            |variant| variant.plan.boundary_lod_px = Some(LOD_PX),
        )
        .switch(
            "held-meshes",
            "on the device are the meshes that views draw, each region's at the level it was last drawn at",
            |switches| switches.holds_drawn_meshes = true,
        )
    }

    /// One draw for many. Where regions keep an order, they are drawn one at a time.
    fn merged_draws(self, overlap: Overlap) -> Self {
        if overlap == Overlap::Ordered {
            return self;
        }
        self.switch(
            "one-draw",
            "what one step draws in one state is one draw instead of one for each region: covers, and where \
             vertices say whose they are volumes, which are no longer cut to rectangles",
            |switches| {
                switches.merges_draws = true;
                switches.scissor = false;
            },
        )
    }

    /// Each loses on some devices or in some views, so no full plan has it (`docs/volume-cost.md`). Where regions keep
    /// an order, none of them can be drawn.
    fn experiments_at_the_top(self) -> Self {
        self.aside(
            "far-level",
            "regions whose volumes are lower than half a pixel as flat meshes, without stencil",
            |variant| variant.plan.far_level_px = Some(LOD_PX),
        )
    }

    /// What the view at hand does not need, for a technique that draws regions in parts. Then experiments with
    /// everything that gains.
    #[must_use]
    pub fn top_of_the_way(self, overlap: Overlap) -> Self {
        let way = self
            .step(
                "parts",
                "of large regions, parts outside the view or hidden by the body are left out, and rectangles \
                 shrink to those of the others",
                |variant| variant.plan.part_culling = PartCulling::All,
            )
            .step(
                "sky",
                "volumes and rectangles end where the image shows sky only",
                |variant| variant.plan.sky_culling = true,
            );
        // Where regions keep an order they are covered one at a time, and one may lie over another.
        if overlap == Overlap::Ordered {
            return way;
        }
        way.step(
            "interior",
            "where all ground in view is one region's it is covered without a volume",
            |variant| variant.plan.interior = true,
        )
        .switch(
            "from-within",
            "fragments in front of the surface count for regions around the eye too, and mark what lies outside",
            |switches| switches.depth_rule = DepthRuleChoice::Uncut,
        )
        .switch(
            "cover-tiles",
            "covers of regions with many pixels for each facet are cut to the tiles that the facets touch",
            |switches| switches.cover_area = CoverArea::Tiles,
        )
        .experiments_at_the_top()
    }

    /// A mesh of fewer vertices, beside the way; the document considered it.
    #[must_use]
    pub fn mesh_lod(self) -> Self {
        self.aside(
            "mesh-lod",
            "boundaries at the coarsest level that moves none by more than half a pixel",
            |variant| variant.plan.boundary_lod_px = Some(LOD_PX),
        )
    }

    /// All steps, the first one first.
    #[must_use]
    pub fn steps(self) -> Vec<PlannedStep> {
        self.steps
    }
}

/// A plan that draws every region.
pub(crate) fn without_culling() -> PlanOptions {
    PlanOptions {
        frustum_culling: false,
        horizon_culling: false,
        too_small_culling: false,
        ..PlanOptions::default()
    }
}

fn set_all(variant: &Variant, values: &[(&'static str, &'static str)]) -> Variant {
    let set =
        |variant: Variant, (key, value): &(&'static str, &'static str)| variant.with(key, value);
    values.iter().fold(variant.clone(), set)
}
