// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ladders: from the un-optimised method to the full plan, one switch at a time.
//!
//! The order is that of Cozzi (2007): one volume for each region, culling, back faces, buffer layout,
//! strips, cache order, vertex size, then depth-pass counting and the bottom cap; then what came
//! later. His last two stand the other way round here: behind the surface every cap counts, so a
//! bottom cap can be left out only where fragments in front of the surface count.
//!
//! All rungs before the last two fill every region in one colour, as his did. A technique puts its
//! own rungs between those that all techniques share.

use crate::{BottomCap, ColourWay, DepthRuleChoice, FacePasses, Switches, Variant};
use terrafill_scene::{Overlap, PlanOptions};

/// Deviation that boundaries may be drawn with where levels of detail are on: half a pixel stays
/// within the band in which rounding decides as well.
pub const LOD_PX: f64 = 0.5;

/// One rung.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// What is changed against the rung before, in one word.
    pub step: &'static str,
    /// The same in a sentence.
    pub change: &'static str,
    /// What is drawn.
    pub variant: Variant,
}

/// A ladder being climbed.
#[derive(Debug)]
pub struct Climb {
    rungs: Vec<Rung>,
    variant: Variant,
}

impl Climb {
    /// The first rung: `variant` with every optimisation of fill and plan switched off.
    #[must_use]
    pub fn start(mut variant: Variant, change: &'static str) -> Self {
        variant.plan = PlanOptions {
            frustum_culling: false,
            horizon_culling: false,
            too_small_culling: false,
            ..PlanOptions::default()
        };
        variant.switches = Switches {
            colour: ColourWay::OneColourVolumes,
            faces: FacePasses::TwoPass,
            ..Switches::default()
        };
        Self {
            rungs: vec![Rung {
                step: "start",
                change,
                variant: variant.clone(),
            }],
            variant,
        }
    }

    /// One rung up.
    #[must_use]
    pub fn step(
        mut self,
        step: &'static str,
        change: &'static str,
        set: impl FnOnce(&mut Variant),
    ) -> Self {
        set(&mut self.variant);
        let variant = self.variant.clone();
        self.rungs.push(Rung {
            step,
            change,
            variant,
        });
        self
    }

    /// One rung up by parameters of the technique's own, `(key, value)`.
    #[must_use]
    pub fn own(
        self,
        step: &'static str,
        change: &'static str,
        values: &[(&'static str, &'static str)],
    ) -> Self {
        self.step(step, change, |variant| {
            *variant = values
                .iter()
                .fold(variant.clone(), |variant, (key, value)| {
                    variant.with(key, value)
                });
        })
    }

    /// One rung up by a switch of the fill.
    #[must_use]
    pub fn switch(
        self,
        step: &'static str,
        change: &'static str,
        set: impl FnOnce(&mut Switches),
    ) -> Self {
        self.step(step, change, |variant| set(&mut variant.switches))
    }

    /// The two rungs that follow the first volumes of whole regions.
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

    /// What every technique has in common from there on.
    #[must_use]
    pub fn rest_of_the_way(self, overlap: Overlap) -> Self {
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
        .step(
            "boundary-lod",
            "boundaries at the coarsest level that moves none by more than half a pixel",
            |variant| variant.plan.boundary_lod_px = Some(LOD_PX),
        )
    }

    /// All rungs, the first one first.
    #[must_use]
    pub fn rungs(self) -> Vec<Rung> {
        self.rungs
    }
}
