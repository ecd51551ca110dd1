// SPDX-License-Identifier: MIT OR Apache-2.0
//! The technique as the contract knows it.

use crate::{ComputeBackend, ComputeVariant, Expansion, GpuCulling, compute_bytes, placed_bytes};
use terrafill_contract::{
    Api, GeometryBytes, OpenedBackend, PlannedStep, Role, Targets, Technique, layouts,
};
use terrafill_core::RegionMesh;
use terrafill_gpu::shared_targets;
use terrafill_scene::{Overlap, Scene};
use terrafill_stencil::AblationBuilder;
use terrafill_variant::{Parameter, SwitchError, Variant};

/// The geometry shader emulated in compute, on wgpu.
#[derive(Debug)]
pub struct ComputeTechnique;

const PARAMETERS: &[Parameter] = &[
    Parameter::one_of(
        "expansion",
        &["per-frame", "cached"],
        "make volumes in every frame, or keep them",
    ),
    Parameter::one_of(
        "gpu-culling",
        &["off", "regions", "triangles"],
        "what the device leaves out itself",
    ),
    Parameter::one_of(
        "transform",
        &["vertex", "compute"],
        "which stage puts corners where they are seen",
    ),
];

impl Technique for ComputeTechnique {
    fn name(&self) -> &'static str {
        "compute"
    }

    fn api(&self) -> Api {
        terrafill_gpu::API
    }

    fn terms(&self) -> &'static [(&'static str, &'static str)] {
        &[
            (
                "compute",
                "shadow volumes on wgpu, which compute shaders expand from regions' stored meshes",
            ),
            ("per-frame", "volumes are made anew in every frame"),
            ("cached", "volumes are made once and kept on the device"),
        ]
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    /// Both expansions and, beside the first, corners that the compute stage puts where they are
    /// seen.
    fn variants(&self, scene: &Scene, role: Role) -> Vec<Variant> {
        let both = layouts(self, scene.overlap).into_iter();
        match role {
            Role::Main => {
                let placed = self.main(scene.overlap).with("transform", "compute");
                both.chain([placed]).collect()
            }
            Role::Quick | Role::Layouts => both.collect(),
            Role::Sweep => Vec::new(),
        }
    }

    fn ablation(&self, overlap: Overlap) -> Vec<PlannedStep> {
        AblationBuilder::start(
            self.main(overlap),
            "a volume for each region, made every frame; two passes, fragments behind the surface \
             count, nothing culled, colour by drawing the volumes again",
        )
        .own(
            "kept",
            "volumes are made once and kept",
            &[("expansion", "cached")],
        )
        .culling()
        .caps()
        .mesh_lod()
        .rest_of_the_way(overlap)
        .top_of_the_way(overlap)
        .steps()
    }

    fn matrix_row(&self, base: &Variant) -> Vec<Variant> {
        [
            ("gpu-culling", "regions"),
            ("gpu-culling", "triangles"),
            ("transform", "compute"),
        ]
        .map(|(key, value)| base.clone().with(key, value))
        .into()
    }

    fn check(&self, variant: &Variant, overlap: Overlap) -> Result<(), SwitchError> {
        let compute = ComputeVariant::of(variant)?;
        compute.check()?;
        // What the device leaves out, it leaves out of whole volumes.
        variant.check_parts(compute.culling == GpuCulling::Off)?;
        variant.switches.check(overlap)
    }

    /// Volumes that are made per frame are made for the regions drawn only.
    fn bytes(
        &self,
        variant: &Variant,
        mesh: &RegionMesh,
        is_drawn: bool,
    ) -> Result<GeometryBytes, SwitchError> {
        let bytes = compute_bytes(mesh);
        let output = match ComputeVariant::of(variant)?.expansion {
            Expansion::PerFrame if !is_drawn => 0,
            _ => bytes.output_index_bytes,
        };
        Ok(GeometryBytes {
            vertex_bytes: bytes.input_vertex_bytes,
            index_bytes: bytes.input_index_bytes + output,
        })
    }

    /// What is read, and with it what is written.
    fn layout_bytes(&self, mesh: &RegionMesh) -> Vec<(String, u64)> {
        let bytes = compute_bytes(mesh);
        let total = bytes.total();
        vec![
            ("input".to_owned(), bytes.input()),
            ("total".to_owned(), total),
            (
                "total,transform=compute".to_owned(),
                total + placed_bytes(mesh),
            ),
        ]
    }

    fn open(&self, targets: &Targets, variant: &Variant) -> OpenedBackend {
        let compute = ComputeVariant::of(variant)?;
        let targets = shared_targets(targets)?;
        Ok(Box::new(ComputeBackend::new(&targets, compute)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GpuCulling, Transform};
    use terrafill_stencil::matrix_row;

    #[test]
    fn a_variant_is_read_as_it_was_set() {
        let plain = ComputeTechnique.main(Overlap::Disjoint);
        assert_eq!(ComputeVariant::of(&plain), Ok(ComputeVariant::default()));
        let name = "cached,faces=two-pass,gpu-culling=regions,transform=compute";
        let changed = plain
            .with("expansion", "cached")
            .with("gpu-culling", "regions")
            .with("transform", "compute")
            .with("faces", "two-pass");
        assert_eq!(changed.name(), name);
        let expected = ComputeVariant {
            expansion: Expansion::Cached,
            culling: GpuCulling::Regions,
            transform: Transform::ComputeStage,
            parts: false,
            switches: changed.switches,
        };
        assert_eq!(ComputeVariant::of(&changed), Ok(expected));
        // Negative control: what another technique was asked for is none of this one's.
        let other = Variant::new("other", &[], Overlap::Disjoint);
        assert!(ComputeVariant::of(&other).is_err());
    }

    #[test]
    fn own_switches_are_in_the_matrix_where_they_go_together() {
        let bases = layouts(&ComputeTechnique, Overlap::Disjoint);
        for (base, count) in bases.iter().zip([3, 2]) {
            let row = matrix_row(&ComputeTechnique, base, Overlap::Disjoint);
            let names: Vec<String> = row.iter().map(Variant::name).collect();
            let own = [
                "gpu-culling=regions",
                "gpu-culling=triangles",
                "transform=compute",
            ];
            let own = own.map(|switch| format!("{},{switch}", base.layout()));
            let found = own.iter().filter(|name| names.contains(name)).count();
            assert_eq!(found, count, "{names:?}");
            assert!(names.contains(&own[2]), "{names:?}");
        }
    }
}
