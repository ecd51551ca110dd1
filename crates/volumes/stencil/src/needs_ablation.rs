// SPDX-License-Identifier: MIT OR Apache-2.0
//! From everything that a fill can hold to what the view at hand needs, one thing left out at a time.
//!
//! Every step shows the same picture. What comes last decides by itself what each view needs.

use crate::ablation::without_culling;
use terrafill_contract::{PlannedStep, Technique};
use terrafill_scene::Overlap;
use terrafill_variant::{BottomCap, ColourWay, CoverArea, DepthRuleChoice, Switches, Variant};

/// The steps that `technique` can draw on scenes of this kind; none for a technique without these switches.
///
/// - `has_picture`: the scene has one, so that a plain fill can hold what a textured one needs
#[must_use]
pub fn needs_ablation(
    technique: &dyn Technique,
    overlap: Overlap,
    has_picture: bool,
) -> Vec<PlannedStep> {
    if !technique.has_stencil_switches() {
        return Vec::new();
    }
    let mut steps: Vec<PlannedStep> = Vec::new();
    let mut variant = everything(technique.main(overlap), has_picture);
    for (name, change, leave_out) in STEPS {
        leave_out(&mut variant, overlap);
        let is_new = steps.iter().all(|step| step.variant != variant);
        if is_new && technique.check(&variant, overlap).is_ok() {
            steps.push(PlannedStep {
                name,
                change,
                variant: variant.clone(),
                is_aside: false,
            });
        }
    }
    steps
}

/// All that a switch can turn on and that changes no pixel.
fn everything(mut variant: Variant, has_picture: bool) -> Variant {
    variant.plan = without_culling();
    variant.switches = Switches {
        colour: ColourWay::Rectangle,
        cover_area: CoverArea::Screen,
        copies_depth: true,
        loads_texture: has_picture,
        ..Switches::default()
    };
    variant
}

type Step = (&'static str, &'static str, fn(&mut Variant, Overlap));

const STEPS: [Step; 11] = [
    (
        "everything",
        "all regions of the scene, one at a time, each with its bottom cap and counted behind the surface; \
         covers over the whole screen; depth copied in every frame; picture, constants and pipelines of a \
         textured fill held beside, where the scene has a picture",
        |_, _| {},
    ),
    ("depth-copy", "depth is not copied", |variant, _| {
        variant.switches.copies_depth = false;
    }),
    (
        "texture",
        "nothing of a textured fill is held",
        |variant, _| variant.switches.loads_texture = false,
    ),
    (
        "frustum",
        "regions outside the view frustum are left out",
        |variant, _| variant.plan.frustum_culling = true,
    ),
    (
        "horizon",
        "regions that the body hides are left out",
        |variant, _| variant.plan.horizon_culling = true,
    ),
    (
        "too-small",
        "regions that reach the centre of no pixel are left out",
        |variant, _| variant.plan.too_small_culling = true,
    ),
    (
        "rectangles",
        "covers and volumes are cut to their region's screen rectangle",
        |variant, _| {
            variant.switches.cover_area = CoverArea::Rectangle;
            variant.switches.scissor = true;
        },
    ),
    (
        "count-behind",
        "fragments in front of the surface count, except for regions that the near plane cuts",
        |variant, _| variant.switches.depth_rule = DepthRuleChoice::Automatic,
    ),
    (
        "bottom-caps",
        "bottom caps are held and drawn for regions that the near plane cuts only",
        |variant, _| variant.switches.bottom_cap = BottomCap::WhereNeeded,
    ),
    (
        "order",
        "disjoint regions are marked together, each by a number of its own",
        |variant, overlap| variant.switches.colour = Switches::for_overlap(overlap).colour,
    ),
    (
        "held-meshes",
        "on the device are the meshes that the view draws",
        |variant, _| variant.switches.holds_drawn_meshes = true,
    ),
];
