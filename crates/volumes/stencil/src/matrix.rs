// SPDX-License-Identifier: MIT OR Apache-2.0
//! The matrix: a technique in one layout, with each switch turned away from its default alone.
//!
//! All these fills must show the same mask to the pixel: they answer the same question about the
//! same surface in another way.

use crate::LOD_PX;
use terrafill_contract::Technique;
use terrafill_plan::PartCulling;
use terrafill_scene::Overlap;
use terrafill_variant::{
    BottomCap, ColourWay, DepthRuleChoice, FacePasses, StencilClear, Switches, Variant,
};

/// `base` and, one at a time, every switch away from its default; with it, where a switch has no
/// effect or is not allowed alone, the one that it needs.
#[must_use]
pub fn matrix_row(technique: &dyn Technique, base: &Variant, overlap: Overlap) -> Vec<Variant> {
    let changes: &[fn(&mut Switches)] = &[
        |s| {
            s.colour = ColourWay::Volume;
            s.cover_culls_faces = true;
        },
        |s| {
            s.colour = ColourWay::OneColourVolumes;
            s.cover_culls_faces = true;
        },
        |s| s.faces = FacePasses::TwoPass,
        |s| s.depth_rule = DepthRuleChoice::Automatic,
        |s| {
            s.depth_rule = DepthRuleChoice::Automatic;
            s.bottom_cap = BottomCap::WhereNeeded;
        },
        |s| s.scissor = true,
        |s| s.kept_stencil_bits = 6,
        |s| {
            s.colour = ColourWay::Rectangle;
            s.stencil_clear = StencilClear::ByColour;
        },
        |s| {
            s.colour = ColourWay::OneColour;
            s.stencil_clear = StencilClear::ByColour;
        },
    ];
    let mut row = vec![base.clone()];
    let colours = ColourWay::ALL.map(|way| base.clone().with_switches(|s| s.colour = way));
    row.extend(colours);
    row.extend(
        changes
            .iter()
            .map(|change| base.clone().with_switches(change)),
    );
    row.extend(technique.matrix_row(base));
    let mut coarse = base.clone();
    coarse.plan.boundary_lod_px = Some(LOD_PX);
    row.push(coarse);
    let mut in_parts = base.clone();
    in_parts.plan.part_culling = PartCulling::Frustum;
    row.push(in_parts);
    let cullings = ["frustum-culling", "horizon-culling", "too-small-culling"];
    row.extend(cullings.map(|culling| base.clone().with(culling, "off")));
    let mut kept: Vec<Variant> = Vec::new();
    for variant in row {
        if technique.check(&variant, overlap).is_ok() && !kept.contains(&variant) {
            kept.push(variant);
        }
    }
    kept
}
