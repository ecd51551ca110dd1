// SPDX-License-Identifier: MIT OR Apache-2.0
//! The technique as the contract knows it.

use crate::parts::ordered_by_part;
use crate::{
    CACHE_SIZE, IndexOrder, Normals, VertexBackend, VertexVariant, acmr, cache_ordered,
    centric_shift_m, shared_flag_bytes, variant_bytes,
};
use terrafill_contract::{
    Api, FillInput, GeometryBytes, OpenedBackend, PlannedStep, Role, Targets, Technique, layouts,
};
use terrafill_core::RegionMesh;
use terrafill_gpu::shared_targets;
use terrafill_plan::PlannedRegion;
use terrafill_scene::{Overlap, Scene};
use terrafill_stencil::{AblationBuilder, PositionFormat};
use terrafill_variant::{ColourWay, Parameter, SwitchError, Switches, Values, Variant};

/// Volumes extruded in the vertex shader, on wgpu.
#[derive(Debug)]
pub struct VertexTechnique;

const PARAMETERS: &[Parameter] = &[
    Parameter::one_of(
        "layout",
        &["doubled", "separate", "per-triangle", "pulled"],
        "how the two ends of a vertex are stored",
    ),
    Parameter::one_of(
        "positions",
        &["fixed", "local-f32", "ecef-f32", "two-float"],
        "format of positions",
    ),
    Parameter::one_of(
        "walls",
        &["strip", "list"],
        "walls as strips or as single triangles",
    ),
    Parameter::one_of(
        "index-order",
        &["mesh", "cache"],
        "cap triangles as the mesh has them, or as a post-transform cache likes them",
    ),
    Parameter::one_of("vertex-bytes", &["16", "20"], "bytes of a stored vertex"),
    Parameter::one_of(
        "vertex-order",
        &["mesh", "first-use"],
        "vertices as the mesh has them, or in the order of their first use",
    ),
    Parameter::one_of(
        "buffers",
        &["kept", "streamed"],
        "keep buffers on the device, or send them in every frame",
    ),
    Parameter::one_of(
        "bottom",
        &["planned", "pixels"],
        "where walls end: as planned, or by what a pixel needs",
    ),
    Parameter::one_of(
        "normals",
        &["geodetic", "stored", "centric"],
        "walls along the ellipsoid's normal, along a stored one, or from the centre",
    ),
    Parameter {
        key: "opacity",
        values: Values::Percent,
        meaning: "how much of what lies below a fill hides",
        default: "100",
        default_in: &[],
    },
];

impl VertexTechnique {
    /// The layouts that are compared everywhere.
    fn both_layouts(&self, overlap: Overlap) -> [Variant; 2] {
        ["doubled", "pulled"].map(|layout| self.main(overlap).with("layout", layout))
    }
}

impl Technique for VertexTechnique {
    fn name(&self) -> &'static str {
        "vertex"
    }

    fn api(&self) -> Api {
        terrafill_gpu::API
    }

    fn terms(&self) -> &'static [(&'static str, &'static str)] {
        &[
            (
                "vertex",
                "shadow volumes on wgpu, which the vertex shader extrudes from regions' stored meshes",
            ),
            (
                "doubled",
                "vertices are stored twice, for the top and the bottom cap, 16 bytes each",
            ),
            (
                "separate",
                "positions are stored twice, 12 bytes each; which cap they belong to lies in a buffer that regions share",
            ),
            (
                "per-triangle",
                "every triangle of a mesh is a closed volume of its own: the first version of 2007",
            ),
            (
                "pulled",
                "vertices are stored once, 12 bytes each; the shader works out the rest from their number",
            ),
        ]
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn variants(&self, scene: &Scene, role: Role) -> Vec<Variant> {
        let main = self.main(scene.overlap);
        match role {
            Role::Quick => self.both_layouts(scene.overlap).into(),
            Role::Main => {
                let mut variants = Vec::from(self.both_layouts(scene.overlap));
                if Switches::for_overlap(scene.overlap).colour != ColourWay::Rectangle {
                    let rectangle = main.clone();
                    variants.push(rectangle.with_switches(|s| s.colour = ColourWay::Rectangle));
                }
                // Where the surface is the ellipsoid, walls through its vertices meet it at these, whatever
                // their direction.
                if !scene.surface.is_bare() {
                    variants.push(main.clone().with("normals", "stored"));
                    variants.push(main.clone().with("normals", "centric"));
                }
                // A scene that sweeps through the formats has it there, where it may be wrong.
                if !scene.sweep_positions {
                    variants.push(main.with("positions", "local-f32"));
                }
                variants
            }
            Role::Layouts => layouts(self, scene.overlap),
            Role::Sweep => {
                let mut variants = Vec::from(self.both_layouts(scene.overlap));
                // Where a scene asks for it, every other way to store positions; all but the
                // default may be wrong.
                let others = PositionFormat::ALL.into_iter();
                let others = others
                    .filter(|format| scene.sweep_positions && *format != PositionFormat::default());
                variants.extend(others.map(|format| main.clone().with("positions", format.name())));
                variants
            }
        }
    }

    fn ablation(&self, overlap: Overlap) -> Vec<PlannedStep> {
        AblationBuilder::start(
            self.main(overlap)
                .with("layout", "per-triangle")
                .with("buffers", "streamed"),
            "a closed volume for every triangle; two passes, fragments behind the surface count, \
             nothing culled, colour by drawing the volumes again, vertices and indices handed over in \
             every frame",
        )
        .own(
            "one-volume",
            "one volume for each region: caps, and walls along the boundary only; 20 bytes a vertex",
            &[
                ("layout", "doubled"),
                ("walls", "list"),
                ("vertex-bytes", "20"),
            ],
        )
        .culling()
        .own(
            "buffers",
            "vertices and indices are kept on the device instead of handed over in every frame",
            &[("buffers", "kept")],
        )
        .own(
            "strips",
            "walls as strips instead of lists",
            &[("walls", "strip")],
        )
        .own_aside(
            "vertex-order",
            "vertices stored in the order of their first use, for the cache before the vertex shader",
            &[("vertex-order", "first-use")],
        )
        .own(
            "vertex-size",
            "16 bytes a vertex instead of 20",
            &[("vertex-bytes", "16")],
        )
        .own_aside(
            "shared-flags",
            "flags in a buffer that all regions share instead of beside each position",
            &[("layout", "separate")],
        )
        .own_aside(
            "normals-stored",
            "a normal of 12 bytes stored with each vertex instead of one made in the shader",
            &[("normals", "stored")],
        )
        .own_aside(
            "normals-centric",
            "vertices moved away from the body's centre instead of along the geodetic normal",
            &[("normals", "centric")],
        )
        .caps()
        .experiments()
        .own_aside(
            "walls-pixels",
            "the bottom of each vertex goes down by 2 pixels at its distance, where that is lower",
            &[("bottom", "pixels")],
        )
        .own(
            "cache-order",
            "cap triangles in the order of a post-transform vertex cache",
            &[("index-order", "cache")],
        )
        .mesh_lod()
        .rest_of_the_way(overlap)
        .top_of_the_way(overlap)
        .steps()
    }

    fn matrix_row(&self, base: &Variant) -> Vec<Variant> {
        [
            ("walls", "list"),
            ("index-order", "cache"),
            ("vertex-bytes", "20"),
            ("positions", "local-f32"),
            ("positions", "ecef-f32"),
            ("positions", "two-float"),
            ("normals", "stored"),
            ("normals", "centric"),
        ]
        .map(|(key, value)| base.clone().with(key, value))
        .into()
    }

    fn check(&self, variant: &Variant, overlap: Overlap) -> Result<(), SwitchError> {
        let vertex = VertexVariant::of(variant)?;
        variant.check_parts(vertex.can_draw_parts())?;
        vertex.check(overlap)
    }

    fn bytes(
        &self,
        variant: &Variant,
        mesh: &RegionMesh,
        _is_drawn: bool,
    ) -> Result<GeometryBytes, SwitchError> {
        Ok(variant_bytes(&VertexVariant::of(variant)?, mesh))
    }

    /// The flags of layout `separate`.
    fn shared_bytes(
        &self,
        variant: &Variant,
        meshes: &[&RegionMesh],
    ) -> Result<GeometryBytes, SwitchError> {
        Ok(GeometryBytes {
            vertex_bytes: shared_flag_bytes(VertexVariant::of(variant)?.layout, meshes),
            index_bytes: 0,
        })
    }

    /// Centric normals: how far off they are is the question.
    fn may_be_wrong(&self, variant: &Variant) -> bool {
        VertexVariant::of(variant).is_ok_and(|variant| variant.normals == Normals::Centric)
    }

    /// - `cap_acmr`: transformed vertices per triangle of all caps drawn, through a cache of
    ///   [`CACHE_SIZE`]
    /// - `wall_shift_m`: how far walls are from those along geodetic normals where they meet the
    ///   surface as drawn, at most; only of centric normals
    fn figures(&self, variant: &Variant, input: &FillInput) -> Vec<(&'static str, Option<f64>)> {
        let variant = VertexVariant::of(variant).ok();
        let ratio = variant.and_then(|variant| cap_acmr(input, &variant));
        let is_centric = variant.is_some_and(|variant| variant.normals == Normals::Centric);
        let shift_m = is_centric.then(|| ("wall_shift_m", wall_shift_m(input)));
        std::iter::once(("cap_acmr", ratio))
            .chain(shift_m)
            .collect()
    }

    fn open(&self, targets: &Targets, variant: &Variant) -> OpenedBackend {
        let vertex = VertexVariant::of(variant)?;
        let targets = shared_targets(targets)?;
        Ok(Box::new(VertexBackend::new(&targets, vertex)?))
    }
}

/// Over all vertices of the regions drawn, at the heights of the surface over each.
fn wall_shift_m(input: &FillInput) -> Option<f64> {
    let of_region = |planned: &PlannedRegion| {
        let mesh = &input.scene.meshes[planned.mesh];
        let stated = input.scene.surface.heights(&mesh.extent);
        let drawn = input.surface.heights_over(&mesh.extent, stated);
        centric_shift_m(mesh, drawn.highest_m.abs().max(drawn.lowest_m.abs()))
    };
    input.plan.regions.iter().map(of_region).reduce(f64::max)
}

/// Over all triangles of the regions drawn.
fn cap_acmr(input: &FillInput, variant: &VertexVariant) -> Option<f64> {
    let (mut misses, mut triangles) = (0.0, 0.0);
    for planned in &input.plan.regions {
        let mesh = &input.scene.meshes[planned.mesh];
        let ratio = match (ordered_by_part(variant, mesh), variant.index_order) {
            (Some(ordered), _) => acmr(&ordered, CACHE_SIZE),
            (None, IndexOrder::Mesh) => acmr(&mesh.triangles, CACHE_SIZE),
            (None, IndexOrder::Cache) => {
                let ordered = cache_ordered(&mesh.triangles, mesh.vertices_ecef.len());
                acmr(&ordered, CACHE_SIZE)
            }
        };
        misses += ratio.unwrap_or(0.0) * mesh.triangles.len() as f64;
        triangles += mesh.triangles.len() as f64;
    }
    (triangles > 0.0).then(|| misses / triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layout;
    use std::collections::BTreeSet;
    use terrafill_stencil::matrix_row;

    fn names(overlap: Overlap) -> Vec<String> {
        let row = matrix_row(&VertexTechnique, &VertexTechnique.main(overlap), overlap);
        row.iter().map(Variant::name).collect()
    }

    #[test]
    fn a_variant_is_read_as_it_was_set() {
        let plain = VertexTechnique.main(Overlap::Disjoint);
        assert_eq!(VertexVariant::of(&plain), Ok(VertexVariant::default()));
        let all = layouts(&VertexTechnique, Overlap::Disjoint);
        let read: Vec<_> = all
            .iter()
            .flat_map(VertexVariant::of)
            .map(|v| v.layout)
            .collect();
        assert_eq!(read, Layout::ALL);
        for format in PositionFormat::ALL {
            let read = VertexVariant::of(&plain.clone().with("positions", format.name()));
            assert_eq!(read.map(|variant| variant.positions), Ok(format));
        }
        let faint = VertexVariant::of(&plain.with("opacity", "40"));
        assert_eq!(faint.map(|variant| variant.opacity_percent), Ok(40));
        // Negative control: what another technique was asked for is none of this one's.
        let other = Variant::new("other", &[], Overlap::Disjoint);
        assert!(VertexVariant::of(&other).is_err());
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
            "depth-rule=automatic",
            "faces=two-pass",
            "frustum-culling=off",
            "horizon-culling=off",
            "index-order=cache",
            "normals=centric",
            "normals=stored",
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
    fn where_regions_may_overlap_nothing_is_drawn_that_cannot_be_right() {
        let names = names(Overlap::Ordered);
        assert_eq!(names[0], "doubled,colour=rectangle");
        assert!(names.len() >= 14, "{names:?}");
        assert!(!names.contains(&"doubled".to_owned()), "XOR mixes numbers");
    }
}
