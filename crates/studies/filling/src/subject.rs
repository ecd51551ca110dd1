// SPDX-License-Identifier: MIT OR Apache-2.0
//! What draws a case: a full-screen pass, or a variant of a technique.

use terrafill_fill::{GeometryBytes, PositionFormat, Switches, Technique, Variant};
use terrafill_gpu::BaselineKind;
use terrafill_scene::PlanOptions;

/// Techniques of a run, in the order in which they are measured. The first is the one whose pictures
/// the others' are laid beside.
pub type Techniques = &'static [&'static dyn Technique];

/// What draws a case.
#[derive(Debug, Clone)]
pub enum Subject {
    /// A full-screen pass.
    Baseline(BaselineKind),
    /// A variant of a technique.
    Fill(&'static dyn Technique, Variant),
}

impl Subject {
    /// Name of the backend in rows.
    #[must_use]
    pub fn backend(&self) -> &'static str {
        match self {
            Self::Baseline(kind) => kind.name(),
            Self::Fill(technique, _) => technique.name(),
        }
    }

    /// Layout first, then what differs from the default, `key=value`, sorted.
    #[must_use]
    pub fn variant_name(&self) -> String {
        match self {
            Self::Baseline(_) => "full-screen".to_owned(),
            Self::Fill(_, variant) => variant.name(),
        }
    }

    fn variant(&self) -> Option<&Variant> {
        match self {
            Self::Baseline(_) => None,
            Self::Fill(_, variant) => Some(variant),
        }
    }

    /// The fill's switches; a full-screen pass has none.
    #[must_use]
    pub fn switches(&self) -> Option<&Switches> {
        self.variant().map(|variant| &variant.switches)
    }

    /// How its frames are planned.
    #[must_use]
    pub fn plan(&self) -> PlanOptions {
        self.variant()
            .map_or_else(PlanOptions::default, |variant| variant.plan)
    }

    /// How it stores positions, where that is a choice.
    pub(crate) fn positions(&self) -> Option<PositionFormat> {
        let value = self.variant()?.value("positions")?;
        PositionFormat::ALL
            .into_iter()
            .find(|format| format.name() == value)
    }

    /// How geometry is stored; empty where there is none.
    pub(crate) fn layout(&self) -> String {
        match self {
            Self::Baseline(_) => String::new(),
            Self::Fill(technique, variant) => technique.layout(variant),
        }
    }

    /// Bytes of one region by the layout's formula; `None` where there is no geometry.
    ///
    /// - `is_drawn`: whether the view draws it, since some layouts hold parts for those only
    pub(crate) fn formula(
        &self,
        mesh: &terrafill_core::RegionMesh,
        is_drawn: bool,
    ) -> Option<GeometryBytes> {
        match self {
            Self::Baseline(_) => None,
            Self::Fill(technique, variant) => technique.bytes(variant, mesh, is_drawn).ok(),
        }
    }

    /// Bytes that all regions share, by the layout's formula.
    pub(crate) fn shared_formula(&self, meshes: &[terrafill_core::RegionMesh]) -> GeometryBytes {
        match self {
            Self::Baseline(_) => GeometryBytes::default(),
            Self::Fill(technique, variant) => {
                technique.shared_bytes(variant, meshes).unwrap_or_default()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::TECHNIQUES;
    use std::rc::Rc;
    use std::sync::Arc;
    use terrafill_core::RegionMesh;
    use terrafill_fill::{Devices, FrameInput, PreparedScene, Targets};
    use terrafill_scene::{ImageSize, Overlap, Scene, SurfaceMesh};

    #[test]
    fn a_full_screen_pass_has_neither_switches_nor_geometry() {
        let bound = Subject::Baseline(BaselineKind::Bound);
        assert!(bound.switches().is_none() && bound.positions().is_none());
        assert_eq!(
            (bound.variant_name().as_str(), bound.layout().as_str()),
            ("full-screen", "")
        );
        assert_eq!(bound.plan(), PlanOptions::default());
    }

    #[test]
    fn a_target_of_numbers_is_counted_where_there_is_one() {
        if terrafill_gpu::open_for_test(&Default::default()).is_none()
            || terrafill_vulkan::open_for_test(&Default::default()).is_none()
        {
            return;
        }
        let scene = Scene::shipped("california", None).expect("it ships");
        let (body, rule) = (&scene.body, scene.edge_rule);
        let meshes = RegionMesh::build_all(&scene.regions, body, rule, &scene.mesh);
        let meshes = meshes.expect("it meshes").into();
        let surface = Arc::new(SurfaceMesh::ellipsoid(body, scene.surface_rows));
        let prepared = PreparedScene::new(&scene, meshes, surface);
        let size = ImageSize {
            width: 40,
            height: 30,
        };
        let input = FrameInput::new(&prepared, &scene.views[0], size, PlanOptions::default());
        let targets = Targets::new(&Rc::new(Devices::default()), size);
        for technique in TECHNIQUES {
            let bytes = |colour: &str| {
                let variant = technique.main(Overlap::Disjoint).with("colour", colour);
                let mut backend = technique.open(&targets, &variant).expect("opens");
                let memory = backend.prepare(&input).expect("fits");
                // Preparing again holds the same.
                assert_eq!(
                    backend.prepare(&input).expect("fits").target_bytes,
                    memory.target_bytes
                );
                memory.target_bytes
            };
            let name = technique.name();
            assert_eq!(bytes("id-accumulation"), 4 * 40 * 30, "{name}");
            // Twin: without such a target nothing is counted.
            assert_eq!(bytes("xor"), 0, "{name}");
        }
    }
}
