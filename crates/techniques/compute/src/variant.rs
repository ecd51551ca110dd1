// SPDX-License-Identifier: MIT OR Apache-2.0
//! The switches of this backend.

use terrafill_plan::PartCulling;
use terrafill_variant::{SwitchError, Switches, Variant};

/// When volumes are made from meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub enum Expansion {
    /// Every frame, for the regions in the frame's plan: what a geometry shader does.
    #[default]
    PerFrame,
    /// Once, for all regions of the scene.
    Cached,
}

/// What the device leaves out, on top of what the frame plan did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub enum GpuCulling {
    /// Nothing.
    #[default]
    Off,
    /// Regions whose box lies outside the frustum or in the body's shadow.
    Regions,
    /// Those, and of the others the cap triangles and walls that lie outside the frustum. Not
    /// those in the body's shadow: where fragments behind the surface count, a ray through the
    /// body may enter a volume by one piece and leave it by another.
    Triangles,
}

/// Which stage puts corners where they are seen. On lavapipe the compute stage takes 6 to 10 % off
/// a globe made every frame (its workgroups run on all cores, vertex shaders on one) and adds up to
/// 7 % close up, where the dispatch costs more than the few corners; numbers take a third less room
/// than corners with numbers and hold for every view, so they are the default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub enum Transform {
    /// The vertex shader, corner by corner as draws ask for them: what is expanded are numbers
    /// only.
    #[default]
    VertexStage,
    /// The compute pass, every corner of the regions in the plan once a frame: 32 more bytes a
    /// vertex, and a vertex shader that hands them on.
    ComputeStage,
}

/// A variant: when volumes are made, what the device leaves out, and the switches of the fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ComputeVariant {
    /// When volumes are made.
    pub expansion: Expansion,
    /// What the device leaves out.
    pub culling: GpuCulling,
    /// What puts corners where they are seen.
    pub transform: Transform,
    /// Triangles of large meshes lie part by part, so that plans may leave parts out.
    pub parts: bool,
    /// What the fill does.
    pub switches: Switches,
}

impl ComputeVariant {
    /// What `variant` says.
    ///
    /// # Errors
    /// [`SwitchError`] when it is one of another technique.
    pub fn of(variant: &Variant) -> Result<Self, SwitchError> {
        let expansions = [
            ("per-frame", Expansion::PerFrame),
            ("cached", Expansion::Cached),
        ];
        let cullings = [
            ("off", GpuCulling::Off),
            ("regions", GpuCulling::Regions),
            ("triangles", GpuCulling::Triangles),
        ];
        let transforms = [
            ("vertex", Transform::VertexStage),
            ("compute", Transform::ComputeStage),
        ];
        Ok(Self {
            expansion: variant.choice("expansion", &expansions)?,
            culling: variant.choice("gpu-culling", &cullings)?,
            transform: variant.choice("transform", &transforms)?,
            parts: variant.plan.part_culling != PartCulling::Off,
            switches: variant.switches,
        })
    }

    /// Whether expansion and culling go together.
    ///
    /// # Errors
    /// [`SwitchError`]: volumes that are made once cannot leave out what one view does not show.
    pub fn check(&self) -> Result<(), SwitchError> {
        if self.expansion == Expansion::Cached && self.culling == GpuCulling::Triangles {
            return Err(SwitchError {
                switch: "gpu-culling",
                found: "triangles with volumes that are cached for every view".to_owned(),
                allowed: "off, regions, or triangles with per-frame".to_owned(),
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cached_volumes_know_no_view() {
        for expansion in [Expansion::PerFrame, Expansion::Cached] {
            for culling in [GpuCulling::Off, GpuCulling::Regions, GpuCulling::Triangles] {
                let variant = ComputeVariant {
                    expansion,
                    culling,
                    ..ComputeVariant::default()
                };
                let is_refused = expansion == Expansion::Cached && culling == GpuCulling::Triangles;
                assert_eq!(variant.check().is_err(), is_refused, "{variant:?}");
            }
        }
    }
}
