// SPDX-License-Identifier: MIT OR Apache-2.0
//! The technique as the contract knows it.

use crate::{InstancedBackend, instanced_bytes};
use terrafill_contract::{
    Api, GeometryBytes, OpenedBackend, PlannedStep, Role, Targets, Technique, layouts,
};
use terrafill_core::RegionMesh;
use terrafill_gpu::shared_targets;
use terrafill_scene::{Overlap, Scene};
use terrafill_stencil::AblationBuilder;
use terrafill_variant::{Parameter, SwitchError, Variant};

/// Walls as instances, on wgpu.
#[derive(Debug)]
pub struct InstancedTechnique;

const PARAMETERS: &[Parameter] = &[Parameter::one_of(
    "walls",
    &["instanced"],
    "how walls are drawn: an instance each",
)];

/// Whether `variant` is one of this technique's.
fn check_layout(variant: &Variant) -> Result<(), SwitchError> {
    variant.choice("walls", &[("instanced", ())])
}

impl Technique for InstancedTechnique {
    fn name(&self) -> &'static str {
        "instanced"
    }

    fn api(&self) -> Api {
        terrafill_gpu::API
    }

    fn terms(&self) -> &'static [(&'static str, &'static str)] {
        &[(
            "instanced",
            "shadow volumes on wgpu whose walls are instances, one for each edge of a boundary",
        )]
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    /// There is one way to store walls, whatever it is wanted for.
    fn variants(&self, scene: &Scene, _role: Role) -> Vec<Variant> {
        layouts(self, scene.overlap)
    }

    fn ablation(&self, overlap: Overlap) -> Vec<PlannedStep> {
        AblationBuilder::start(
            self.main(overlap),
            "a volume for each region, an instance for each wall; two passes, fragments behind the \
             surface count, nothing culled, colour by drawing the volumes again",
        )
        .culling()
        .caps()
        .mesh_lod()
        .rest_of_the_way(overlap)
        .top_of_the_way(overlap)
        .steps()
    }

    fn check(&self, variant: &Variant, overlap: Overlap) -> Result<(), SwitchError> {
        check_layout(variant)?;
        variant.check_parts(true)?;
        variant.switches.check(overlap)
    }

    fn bytes(
        &self,
        variant: &Variant,
        mesh: &RegionMesh,
        _is_drawn: bool,
    ) -> Result<GeometryBytes, SwitchError> {
        check_layout(variant)?;
        Ok(instanced_bytes(mesh))
    }

    fn open(&self, targets: &Targets, variant: &Variant) -> OpenedBackend {
        check_layout(variant)?;
        let targets = shared_targets(targets)?;
        Ok(Box::new(InstancedBackend::new(&targets, variant.switches)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variant_of_another_technique_is_refused() {
        let own = InstancedTechnique.main(Overlap::Disjoint);
        assert_eq!(own.name(), "instanced");
        assert_eq!(InstancedTechnique.check(&own, Overlap::Disjoint), Ok(()));
        let other = Variant::new("other", &[], Overlap::Disjoint);
        assert!(InstancedTechnique.check(&other, Overlap::Disjoint).is_err());
    }
}
