// SPDX-License-Identifier: MIT OR Apache-2.0
//! The techniques as the contract knows them.

use crate::draped::{self, DrapedMesh};
use crate::flat::{self, FlatMesh, flat_bytes};
use crate::mask::{self, MaskTexture};
use terrafill_contract::{Api, GeometryBytes, OpenedBackend, Role, Targets, Technique};
use terrafill_core::RegionMesh;
use terrafill_gpu::{OverlayBackend, SharedTargets, shared_targets};
use terrafill_scene::{Overlap, Scene};
use terrafill_variant::{Parameter, SwitchError, Variant};

type Open = fn(&SharedTargets, &Variant) -> OpenedBackend;

/// A technique that draws one kind of overlay, on wgpu.
#[derive(Debug)]
pub struct OverlayTechnique {
    name: &'static str,
    /// What it is and what its kind is, in a line each.
    terms: &'static [(&'static str, &'static str)],
    /// The first is the kind, the second the knob.
    parameters: &'static [Parameter; 2],
    /// Values of the knob that are compared everywhere.
    main: &'static [&'static str],
    /// The same in a run that is not full.
    quick: &'static [&'static str],
    /// Bytes of a region by formula, where there is one.
    bytes: Option<fn(&RegionMesh) -> GeometryBytes>,
    open: Open,
}

/// Regions' triangles at a stated height.
pub static FLAT_MESH: OverlayTechnique = OverlayTechnique {
    name: "flat-mesh",
    terms: &[
        (
            "flat-mesh",
            "regions' own triangles at one height, without volumes: approximate on terrain",
        ),
        ("flat", "regions' triangles at one height"),
    ],
    parameters: &[
        Parameter::one_of("mesh", &["flat"], "regions' triangles at one height"),
        Parameter::one_of(flat::HEIGHT, flat::HEIGHTS, "at which height"),
    ],
    main: flat::HEIGHTS,
    quick: &["top"],
    bytes: Some(flat_bytes),
    open: |targets, variant| {
        let overlay = FlatMesh::new(targets.borrow().gpu(), variant)?;
        Ok(Box::new(OverlayBackend::new(targets, overlay)))
    },
};

/// Regions cut along the surface's triangles.
pub static DRAPED_MESH: OverlayTechnique = OverlayTechnique {
    name: "draped-mesh",
    terms: &[
        (
            "draped-mesh",
            "regions cut along the surface's triangles on the CPU, drawn a little nearer than these",
        ),
        ("draped", "regions' triangles lie on the surface's"),
    ],
    parameters: &[
        Parameter::one_of(
            "mesh",
            &["draped"],
            "regions cut along the surface's triangles",
        ),
        Parameter::one_of(
            draped::OFFSET,
            draped::OFFSETS,
            "how far their depth is drawn towards the eye",
        ),
    ],
    main: draped::OFFSETS,
    quick: &["2^-10"],
    bytes: None,
    open: |targets, variant| {
        let overlay = DrapedMesh::new(targets.borrow().gpu(), variant)?;
        Ok(Box::new(OverlayBackend::new(targets, overlay)))
    },
};

/// Regions drawn into a texture that is looked up by depth.
pub static MASK_TEXTURE: OverlayTechnique = OverlayTechnique {
    name: "mask-texture",
    terms: &[
        (
            "mask-texture",
            "regions drawn into a texture, which every pixel of the surface looks itself up in",
        ),
        ("texture", "of mask-texture: its only layout"),
    ],
    parameters: &[
        Parameter::one_of(
            "mask",
            &["texture"],
            "regions in a texture that is looked up by depth",
        ),
        Parameter::one_of(mask::SIZE, mask::SIZES, "texels along a side"),
    ],
    main: mask::SIZES,
    quick: mask::SIZES,
    bytes: None,
    open: |targets, variant| {
        let overlay = MaskTexture::new(targets.borrow().gpu(), variant)?;
        Ok(Box::new(OverlayBackend::new(targets, overlay)))
    },
};

impl Technique for OverlayTechnique {
    fn name(&self) -> &'static str {
        self.name
    }

    fn api(&self) -> Api {
        terrafill_gpu::API
    }

    fn terms(&self) -> &'static [(&'static str, &'static str)] {
        self.terms
    }

    fn parameters(&self) -> &'static [Parameter] {
        self.parameters
    }

    fn is_approximate(&self, _variant: &Variant) -> bool {
        true
    }

    fn has_stencil_switches(&self) -> bool {
        false
    }

    fn variants(&self, scene: &Scene, role: Role) -> Vec<Variant> {
        let values = match role {
            Role::Main => self.main,
            Role::Quick => self.quick,
            Role::Layouts | Role::Sweep => &[],
        };
        let key = self.parameters[1].key;
        let main = self.main(scene.overlap);
        values
            .iter()
            .map(|value| main.clone().with(key, value))
            .collect()
    }

    /// No switch of a stencil fill means anything here.
    fn check(&self, variant: &Variant, overlap: Overlap) -> Result<(), SwitchError> {
        variant.check_technique(self.name)?;
        variant.check_without_stencil(overlap)
    }

    fn bytes(
        &self,
        variant: &Variant,
        mesh: &RegionMesh,
        _is_drawn: bool,
    ) -> Result<GeometryBytes, SwitchError> {
        variant.check_technique(self.name)?;
        let bytes = self.bytes.ok_or_else(|| SwitchError {
            switch: "technique",
            found: format!("{}, whose bytes follow from the view", self.name),
            allowed: "one whose bytes a region has by itself".to_owned(),
        })?;
        Ok(bytes(mesh))
    }

    fn open(&self, targets: &Targets, variant: &Variant) -> OpenedBackend {
        variant.check_technique(self.name)?;
        (self.open)(&shared_targets(targets)?, variant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_switch_of_stencil_fills_is_refused() {
        for technique in [&FLAT_MESH, &DRAPED_MESH, &MASK_TEXTURE] {
            for overlap in [Overlap::Disjoint, Overlap::Ordered] {
                let main = technique.main(overlap);
                assert_eq!(technique.check(&main, overlap), Ok(()));
                assert!(technique.is_approximate(&main));
                // Negative controls: a switch, and a variant of another technique.
                let scissor = main.with_switches(|switches| switches.scissor ^= true);
                assert!(technique.check(&scissor, overlap).is_err());
                let other = Variant::new("other", technique.parameters(), overlap);
                assert!(technique.check(&other, overlap).is_err());
            }
        }
    }
}
