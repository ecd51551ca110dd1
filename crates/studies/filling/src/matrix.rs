// SPDX-License-Identifier: MIT OR Apache-2.0
//! The matrix: every backend in every layout, with each switch turned away from its default alone.
//!
//! All these fills must show the same mask to the pixel: they ask the same question of the same
//! surface, in another way. They are drawn once and not timed. Where a way of storing positions rounds
//! by so much that it may be seen, by its formula, it is not asked (`rounding.rs`): what it shows there
//! is for the sweep through the formats, in which it may be wrong.

use crate::technique::{Setting, Technique};
use terrafill_compute::{ComputeVariant, GpuCulling, Transform};
use terrafill_fill::{
    BottomCap, ColourWay, DepthRuleChoice, FacePasses, PositionFormat, StencilClear, Switches,
};
use terrafill_native::{Indices, NativeVariant};
use terrafill_scene::Overlap;
use terrafill_vertex::{IndexOrder, VertexSize, VertexVariant, Walls};

/// Deviation that boundaries may be drawn with where levels of detail are on: half a pixel stays
/// within the band in which rounding decides as well.
pub(crate) const LOD_PX: f64 = 0.5;

/// Switches that only this technique has, one at a time.
fn own_switches(base: Setting) -> Vec<Setting> {
    match base.technique {
        Technique::Baseline(_) => Vec::new(),
        Technique::Native(variant) => vec![Setting {
            technique: Technique::Native(NativeVariant {
                indices: Some(Indices::List),
                ..variant
            }),
            ..base
        }],
        Technique::Vertex(variant) => [
            VertexVariant {
                walls: Walls::List,
                ..variant
            },
            VertexVariant {
                index_order: IndexOrder::Cache,
                ..variant
            },
            VertexVariant {
                vertex_size: VertexSize::Bytes20,
                ..variant
            },
            VertexVariant {
                positions: PositionFormat::LocalF32,
                ..variant
            },
            VertexVariant {
                positions: PositionFormat::EcefF32,
                ..variant
            },
            VertexVariant {
                positions: PositionFormat::TwoFloat,
                ..variant
            },
        ]
        .map(|variant| Setting {
            technique: Technique::Vertex(variant),
            ..base
        })
        .into(),
        Technique::Compute(variant) => [
            ComputeVariant {
                culling: GpuCulling::Regions,
                ..variant
            },
            ComputeVariant {
                culling: GpuCulling::Triangles,
                ..variant
            },
            ComputeVariant {
                transform: Transform::ComputeStage,
                ..variant
            },
        ]
        .map(|variant| Setting {
            technique: Technique::Compute(variant),
            ..base
        })
        .into(),
    }
}

/// `base` and, one at a time, every switch away from its default; with it, where a switch has no
/// effect or no right of its own, the one that it needs.
pub(crate) fn matrix_row(base: Setting, overlap: Overlap) -> Vec<Setting> {
    let changes: [fn(&mut Switches); 9] = [
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
        |s| {
            s.colour = ColourWay::Rectangle;
            s.stencil_clear = StencilClear::ByColour;
        },
        |s| {
            s.colour = ColourWay::OneColour;
            s.stencil_clear = StencilClear::ByColour;
        },
        |s| s.depth_bounds = true,
    ];
    let mut row = vec![base];
    row.extend(ColourWay::ALL.map(|way| base.with(|switches| switches.colour = way)));
    row.extend(changes.map(|change| base.with(change)));
    row.extend(own_switches(base));
    row.push({
        let mut setting = base;
        setting.plan.boundary_lod_px = Some(LOD_PX);
        setting
    });
    for culling in 0..3 {
        let mut setting = base;
        let switches = [
            &mut setting.plan.frustum_culling,
            &mut setting.plan.horizon_culling,
            &mut setting.plan.too_small_culling,
        ];
        for (index, switch) in switches.into_iter().enumerate() {
            *switch = index != culling;
        }
        row.push(setting);
    }
    let mut kept: Vec<Setting> = Vec::new();
    for setting in row {
        if setting.technique.is_allowed(overlap) && !kept.contains(&setting) {
            kept.push(setting);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use terrafill_compute::Expansion;
    use terrafill_native::Technique as Native;

    fn names_of(technique: Technique, overlap: Overlap) -> Vec<String> {
        let row = matrix_row(Setting::new(technique), overlap);
        row.iter().map(Setting::variant_name).collect()
    }

    fn names(overlap: Overlap) -> Vec<String> {
        let variant = VertexVariant {
            switches: Switches::for_overlap(overlap),
            ..VertexVariant::default()
        };
        names_of(Technique::Vertex(variant), overlap)
    }

    #[test]
    fn what_only_the_compute_backend_has_is_asked_where_it_goes_together() {
        for (expansion, count) in [(Expansion::PerFrame, 3), (Expansion::Cached, 2)] {
            let variant = ComputeVariant {
                expansion,
                ..ComputeVariant::default()
            };
            let names = names_of(Technique::Compute(variant), Overlap::Disjoint);
            let own = [
                "gpu-culling=regions",
                "gpu-culling=triangles",
                "transform=compute",
            ];
            let own = own.map(|switch| format!("{},{switch}", expansion.name()));
            let found = own.iter().filter(|name| names.contains(name)).count();
            assert_eq!(found, count, "{names:?}");
            assert!(names.contains(&own[2]), "{names:?}");
        }
    }

    #[test]
    fn lists_are_asked_of_the_techniques_that_have_strips() {
        for technique in Native::ALL {
            let variant = NativeVariant {
                technique,
                ..NativeVariant::default()
            };
            let names = names_of(Technique::Native(variant), Overlap::Disjoint);
            let lists = format!("{},indices=list", technique.name());
            let has_choice = technique.has_index_choice();
            assert_eq!(names.contains(&lists), has_choice, "{names:?}");
        }
        let chosen = Native::ALL.into_iter().filter(|t| t.has_index_choice());
        assert_eq!(chosen.count(), 2);
    }

    #[test]
    fn every_switch_has_its_cell_and_no_cell_stands_twice() {
        let names = names(Overlap::Disjoint);
        assert_eq!(names[0], "doubled");
        let distinct: BTreeSet<&String> = names.iter().collect();
        assert_eq!(distinct.len(), names.len(), "{names:?}");
        for switch in [
            "bottom-cap=where-needed",
            "boundary-lod-px=0.5",
            "colour=id-accumulation",
            "colour=bit-planes",
            "colour=one-colour",
            "colour=one-colour-volumes",
            "colour=rectangle",
            "colour=volume",
            "cover-faces=culled",
            "depth-bounds=on",
            "depth-rule=automatic",
            "faces=two-pass",
            "frustum-culling=off",
            "horizon-culling=off",
            "index-order=cache",
            "positions=ecef-f32",
            "positions=local-f32",
            "positions=two-float",
            "scissor=volumes",
            "stencil-clear=by-colour",
            "too-small-culling=off",
            "vertex-bytes=20",
            "walls=list",
        ] {
            assert!(names.iter().any(|name| name.contains(switch)), "{switch}");
        }
        // Counting in front of the surface wherever the eye is, is wrong by design.
        assert!(!names.iter().any(|name| name.contains("zpass")));
    }

    #[test]
    fn where_regions_may_overlap_nothing_is_asked_that_cannot_be_right() {
        let names = names(Overlap::Ordered);
        assert_eq!(names[0], "doubled,colour=rectangle");
        assert!(names.len() >= 14, "{names:?}");
        assert!(!names.contains(&"doubled".to_owned()), "XOR mixes numbers");
    }
}
