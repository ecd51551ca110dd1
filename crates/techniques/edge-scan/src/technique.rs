// SPDX-License-Identifier: MIT OR Apache-2.0
//! The technique as the contract knows it.

use crate::outline::{Format, OUTLINE, OUTLINES, outline_bytes};
use crate::scan::EdgeScan;
use terrafill_contract::{Api, GeometryBytes, OpenedBackend, Role, Targets, Technique, layouts};
use terrafill_core::RegionMesh;
use terrafill_gpu::{OverlayBackend, shared_targets};
use terrafill_scene::{Overlap, Scene};
use terrafill_variant::{Parameter, SwitchError, Variant};

/// Name in rows.
const NAME: &str = "edge-scan";

const PARAMETERS: &[Parameter] = &[Parameter::one_of(
    OUTLINE,
    OUTLINES,
    "how positions of outlines are kept, in degrees",
)];

/// Every pixel tests the edges of every region around it, on wgpu.
#[derive(Debug, Clone, Copy, Default)]
pub struct EdgeScanTechnique;

/// The format of one of its own variants.
fn format(variant: &Variant) -> Result<Format, SwitchError> {
    variant.check_technique(NAME)?;
    Format::of(variant)
}

impl Technique for EdgeScanTechnique {
    fn name(&self) -> &'static str {
        NAME
    }

    fn api(&self) -> Api {
        terrafill_gpu::API
    }

    fn terms(&self) -> &'static [(&'static str, &'static str)] {
        &[
            (
                NAME,
                "every pixel of the surface tests all edges of the regions whose box it is in: approximate",
            ),
            (
                "f32",
                "of edge-scan: outlines in degrees, two floats a vertex",
            ),
            (
                "f16",
                "of edge-scan: outlines in degrees, two half floats a vertex",
            ),
        ]
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    /// Places come from `f32` about the body's centre.
    fn is_approximate(&self, _variant: &Variant) -> bool {
        true
    }

    fn has_stencil_switches(&self) -> bool {
        false
    }

    fn variants(&self, scene: &Scene, role: Role) -> Vec<Variant> {
        match role {
            Role::Main => layouts(self, scene.overlap),
            Role::Quick => vec![self.main(scene.overlap)],
            Role::Layouts | Role::Sweep => Vec::new(),
        }
    }

    /// No switch of a stencil fill means anything here, and regions are scanned whole.
    fn check(&self, variant: &Variant, overlap: Overlap) -> Result<(), SwitchError> {
        format(variant)?;
        variant.check_without_stencil(overlap)
    }

    fn bytes(
        &self,
        variant: &Variant,
        mesh: &RegionMesh,
        _is_drawn: bool,
    ) -> Result<GeometryBytes, SwitchError> {
        Ok(outline_bytes(format(variant)?, mesh))
    }

    fn open(&self, targets: &Targets, variant: &Variant) -> OpenedBackend {
        format(variant)?;
        let targets = shared_targets(targets)?;
        let scan = EdgeScan::new(targets.borrow().gpu(), variant)?;
        Ok(Box::new(OverlayBackend::new(&targets, scan)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_switch_of_stencil_fills_is_refused() {
        for overlap in [Overlap::Disjoint, Overlap::Ordered] {
            for variant in layouts(&EdgeScanTechnique, overlap) {
                assert_eq!(EdgeScanTechnique.check(&variant, overlap), Ok(()));
                // Negative controls: a switch, parts, and a variant of another technique.
                let scissor = variant.clone();
                let scissor = scissor.with_switches(|switches| switches.scissor ^= true);
                assert!(EdgeScanTechnique.check(&scissor, overlap).is_err());
                let parts = variant.with("part-culling", "frustum");
                assert!(EdgeScanTechnique.check(&parts, overlap).is_err());
            }
            let other = Variant::new("other", PARAMETERS, overlap);
            assert!(EdgeScanTechnique.check(&other, overlap).is_err());
            assert!(
                EdgeScanTechnique
                    .bytes(&other, &RegionMesh::default(), true)
                    .is_err()
            );
        }
    }
}
