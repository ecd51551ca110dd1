// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every exact technique as the command line opens it: by its main variant, over any surface.

use super::{Devices, figures, judge};
use std::rc::Rc;
use terrafill_compute::ComputeTechnique;
use terrafill_conformance::{ErrorFigures, verdict};
use terrafill_contract::{FillInput, Frame, Picture, PreparedScene, Targets, Technique};
use terrafill_core::RegionMesh;
use terrafill_instanced::InstancedTechnique;
use terrafill_native::NativeTechnique;
use terrafill_scene::{ImageSize, Scene};
use terrafill_surface::{SurfaceKind, open_surface};
use terrafill_vertex::VertexTechnique;

pub(crate) const TECHNIQUES: [&dyn Technique; 4] = [
    &VertexTechnique,
    &ComputeTechnique,
    &InstancedTechnique,
    &NativeTechnique,
];

/// Targets of one size on the devices here.
pub(crate) struct Open {
    targets: Targets,
}

impl Open {
    /// `None`, said aloud, where a device is missing.
    pub(crate) fn new(size: ImageSize) -> Option<Self> {
        Devices::open_both()?;
        Some(Self {
            targets: Targets::new(&Rc::default(), size),
        })
    }

    pub(crate) fn draw(&self, technique: &dyn Technique, input: &FillInput) -> Frame {
        let variant = technique.main(input.scene.overlap);
        let mut backend = technique.open(&self.targets, &variant).expect("opens");
        backend.prepare(input).expect("fits");
        backend.render(input).expect("draws")
    }

    /// The picture in the regions' colours.
    pub(crate) fn drawn(&self, technique: &dyn Technique, input: &FillInput) -> Picture {
        let variant = technique.main(input.scene.overlap);
        let mut backend = technique.open(&self.targets, &variant).expect("opens");
        backend.prepare(input).expect("fits");
        backend.picture(input).expect("draws")
    }

    /// Every technique is right; what the reference says.
    pub(crate) fn assert_right(&self, what: &str, input: &FillInput) -> Frame {
        let judged = judge(input);
        assert!(judged.filled_px() > 20, "{what}: nothing to see");
        for technique in TECHNIQUES {
            let found = self.found(technique, input, &judged);
            let name = technique.name();
            assert!(verdict(&found).is_pass(), "{what}, {name}: {found:?}");
            assert_eq!(found.mismatched_px_outside_band, 0, "{what}, {name}");
        }
        judged
    }

    /// What a technique's picture is beside `judged`.
    pub(crate) fn found(
        &self,
        technique: &dyn Technique,
        input: &FillInput,
        judged: &Frame,
    ) -> ErrorFigures {
        figures(judged, &self.draw(technique, input))
    }
}

/// The scene over its surface, one of `kinds`.
pub(crate) fn prepared(kinds: &[&dyn SurfaceKind], scene: &Scene) -> PreparedScene {
    let (body, rule) = (&scene.body, scene.edge_rule);
    let meshes = RegionMesh::build_all(&scene.regions, body, rule, &scene.mesh);
    let surface = open_surface(kinds, scene).expect("a surface");
    PreparedScene::new(scene, meshes.expect("it meshes").into(), surface)
}
