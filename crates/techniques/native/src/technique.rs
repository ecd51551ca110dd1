// SPDX-License-Identifier: MIT OR Apache-2.0
//! The technique as the contract knows it.

use crate::{NativeBackend, NativeVariant, native_bytes, native_layouts};
use terrafill_contract::{
    Api, DeviceError, GeometryBytes, OpenedBackend, PlannedStep, Role, THIS_MACHINE, Targets,
    Technique, layouts,
};
use terrafill_core::RegionMesh;
use terrafill_scene::{Overlap, Scene};
use terrafill_stencil::AblationBuilder;
use terrafill_variant::{Parameter, SwitchError, Variant};
use terrafill_vulkan::shared_targets;

/// Geometry shaders, and the vertex shader as their control, on Vulkan itself.
#[derive(Debug)]
pub struct NativeTechnique;

/// The layout says how volumes come about.
const PARAMETERS: &[Parameter] = &[
    Parameter {
        default: "gs-degenerate",
        ..Parameter::one_of(
            "technique",
            &[
                "vs-control",
                "gs-degenerate",
                "gs-two-edges",
                "gs-line",
                "gs-adjacency",
                "gs-per-triangle",
            ],
            "what makes walls: the vertex shader, or a geometry shader, and of which primitives",
        )
    },
    // As `Extrusion::default_indices`.
    Parameter {
        default_in: &[("gs-degenerate", "strip"), ("gs-adjacency", "strip")],
        ..Parameter::one_of(
            "indices",
            &["list", "strip"],
            "triangles as lists or as strips",
        )
    },
];

impl Technique for NativeTechnique {
    fn name(&self) -> &'static str {
        "native"
    }

    fn api(&self) -> Api {
        terrafill_vulkan::API
    }

    fn terms(&self) -> &'static [(&'static str, &'static str)] {
        &[
            (
                "native",
                "shadow volumes that geometry shaders make, by Vulkan itself: wgpu, Metal and browsers have no such stage",
            ),
            (
                "vs-control",
                "for comparison: the vertex shader makes walls, with the bytes and the shader of vertex/doubled",
            ),
            (
                "gs-degenerate",
                "a geometry shader makes walls of boundary edges that are stored as degenerate triangles: one draw for caps and walls",
            ),
            (
                "gs-two-edges",
                "as gs-degenerate; a triangle of boundary vertices stands for two edges in a row, which halves their indices",
            ),
            (
                "gs-line",
                "geometry shaders make caps of triangles, and walls of line strips along the boundary: two draws",
            ),
            (
                "gs-adjacency",
                "a geometry shader finds walls by the neighbours of each triangle: one draw",
            ),
            (
                "gs-per-triangle",
                "a geometry shader makes a closed volume of each triangle of a mesh",
            ),
        ]
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn variants(&self, scene: &Scene, role: Role) -> Vec<Variant> {
        let main = self.main(scene.overlap);
        let some = ["vs-control", "gs-degenerate", "gs-line"];
        let some = some.map(|technique| main.clone().with("technique", technique));
        match role {
            Role::Main => {
                let in_lists = main.with("indices", "list");
                some.into_iter().chain([in_lists]).collect()
            }
            Role::Quick => some.into(),
            Role::Layouts => layouts(self, scene.overlap),
            Role::Sweep => Vec::new(),
        }
    }

    fn ablation(&self, overlap: Overlap) -> Vec<PlannedStep> {
        AblationBuilder::start(
            self.main(overlap).with("technique", "gs-per-triangle"),
            "the geometry shader makes a closed volume of every triangle; two passes, fragments \
             behind the surface count, nothing culled, colour by drawing the volumes again",
        )
        .own(
            "one-volume",
            "one volume for each region: two caps of each triangle, a wall of each boundary edge",
            &[("technique", "gs-degenerate"), ("indices", "list")],
        )
        .culling()
        .own(
            "strips",
            "triangles and boundary edges in strips instead of lists",
            &[("indices", "strip")],
        )
        .own(
            "two-edges",
            "lists again, with two boundary edges in each index triangle",
            &[("technique", "gs-two-edges"), ("indices", "list")],
        )
        .own(
            "lines",
            "boundary edges as line strips in a draw of their own instead of among the triangles",
            &[("technique", "gs-line")],
        )
        .caps()
        .mesh_lod()
        .rest_of_the_way(overlap)
        .top_of_the_way(overlap)
        .steps()
    }

    fn matrix_row(&self, base: &Variant) -> Vec<Variant> {
        vec![base.clone().with("indices", "list")]
    }

    fn check(&self, variant: &Variant, overlap: Overlap) -> Result<(), SwitchError> {
        let native = NativeVariant::of(variant)?;
        variant.check_parts(native.wall_indices().is_some())?;
        native.check(overlap)
    }

    /// With `/list` after the name where lists are a choice that is not the default.
    fn layout(&self, variant: &Variant) -> String {
        let layout = variant.layout().to_owned();
        match NativeVariant::of(variant) {
            Ok(native) if native.indices() != native.technique.default_indices() => {
                format!("{layout}/{}", native.indices().name())
            }
            _ => layout,
        }
    }

    fn bytes(
        &self,
        variant: &Variant,
        mesh: &RegionMesh,
        _is_drawn: bool,
    ) -> Result<GeometryBytes, SwitchError> {
        let native = NativeVariant::of(variant)?;
        Ok(native_bytes(native.technique, native.indices(), mesh))
    }

    /// Strips are found once for all of them.
    fn layout_bytes(&self, mesh: &RegionMesh) -> Vec<(String, u64)> {
        let all = native_layouts(mesh).into_iter();
        all.map(|(name, bytes)| (name, bytes.total())).collect()
    }

    fn open(&self, targets: &Targets, variant: &Variant) -> OpenedBackend {
        let native = NativeVariant::of(variant)?;
        // The rest of a run goes on without Vulkan itself.
        let targets = shared_targets(targets).map_err(|why| {
            let what = format!("a device for the native backend: {why}");
            DeviceError::unsupported(&what, THIS_MACHINE)
        })?;
        Ok(Box::new(NativeBackend::new(&targets, native)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Extrusion;
    use std::rc::Rc;
    use terrafill_contract::Devices;
    use terrafill_scene::ImageSize;
    use terrafill_stencil::matrix_row;

    fn main() -> Variant {
        NativeTechnique.main(Overlap::Disjoint)
    }

    #[test]
    fn every_extrusion_is_a_layout_with_its_own_default_indices() {
        let all = layouts(&NativeTechnique, Overlap::Disjoint);
        assert_eq!(all.len(), Extrusion::ALL.len());
        for (extrusion, variant) in Extrusion::ALL.into_iter().zip(&all) {
            let native = NativeVariant::of(variant).expect("known names");
            assert_eq!(native.technique, extrusion);
            assert_eq!(native.indices(), extrusion.default_indices());
            assert_eq!(variant.name(), extrusion.name());
            let strips = variant.clone().with("indices", "strip");
            let strips = NativeTechnique.check(&strips, Overlap::Disjoint);
            assert_eq!(strips.is_ok(), extrusion.has_index_choice());
            let lists = variant.clone().with("indices", "list");
            assert_eq!(NativeTechnique.check(&lists, Overlap::Disjoint), Ok(()));
        }
        assert_eq!(
            NativeVariant::of(&main()).map(|v| v.technique),
            Ok(Extrusion::default())
        );
    }

    #[test]
    fn lists_are_in_the_matrix_of_the_techniques_that_have_strips() {
        for base in layouts(&NativeTechnique, Overlap::Disjoint) {
            let row = matrix_row(&NativeTechnique, &base, Overlap::Disjoint);
            let lists = format!("{},indices=list", base.layout());
            let native = NativeVariant::of(&base).expect("known names");
            let found = row.iter().any(|variant| variant.name() == lists);
            assert_eq!(found, native.technique.has_index_choice(), "{lists}");
        }
    }

    #[test]
    fn lists_that_are_a_choice_are_a_layout_of_their_own() {
        let lists = main().with("indices", "list");
        assert_eq!(NativeTechnique.layout(&lists), "gs-degenerate/list");
        assert_eq!(NativeTechnique.layout(&main()), "gs-degenerate");
        let lines = lists.with("technique", "gs-line");
        assert_eq!(NativeTechnique.layout(&lines), "gs-line");
    }

    #[test]
    fn a_machine_without_the_device_lacks_it() {
        let devices = Rc::new(Devices::new(Some("no adapter is called so".to_owned())));
        let size = ImageSize::new(1, 1);
        let targets = Targets::new(&devices, size);
        for _ in 0..2 {
            let opened = NativeTechnique.open(&targets, &main()).map(|_| ());
            let error = opened.expect_err("no such adapter").to_string();
            let words = "this machine lacks a device for the native backend: ";
            assert!(error.starts_with(words), "{error}");
        }
    }
}
