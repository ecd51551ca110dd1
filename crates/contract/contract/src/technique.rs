// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a technique promises to those who measure it.
//!
//! A technique is one way to fill regions on one graphics interface. It says which variants of it
//! are worth measuring and for what, what they take in bytes by formula, and opens a backend for any
//! of them. Nobody else names its parameters, so that a new technique is a crate and one line in a
//! list.

use crate::{Api, DeviceError, FillBackend, FillInput, GeometryBytes, Targets};
use std::fmt::Debug;
use terrafill_core::{EdgeRule, RegionMesh};
use terrafill_scene::{Overlap, Scene};
use terrafill_variant::{Parameter, SwitchError, Values, Variant};

/// What variants are wanted for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// To be compared everywhere: layouts as they should be used and, one at a time, what is worth
    /// comparing beside them.
    Main,
    /// The same in a quick run: fewer.
    Quick,
    /// Every layout as it should be used, from which the matrix turns one switch at a time.
    Layouts,
    /// Layouts and other choices whose error is drawn against their time.
    Sweep,
}

/// One step of an ablation, to be measured.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedStep {
    /// What is changed against the step before, in one word.
    pub name: &'static str,
    /// The same in a sentence.
    pub change: &'static str,
    /// What is drawn.
    pub variant: Variant,
    /// A side step: the next one starts from the step before this one.
    pub is_aside: bool,
}

/// A backend, or why there is none.
pub type OpenedBackend = Result<Box<dyn FillBackend>, DeviceError>;

/// One way to fill regions, with all its variants.
pub trait Technique: Sync + Debug {
    /// Name in rows: `vertex`, `compute` …
    fn name(&self) -> &'static str;

    /// The graphics interface. Techniques of one share a device and a set of render targets.
    fn api(&self) -> Api;

    /// What it is, in a line, by its name, and the same of each of its layouts.
    fn terms(&self) -> &'static [(&'static str, &'static str)];

    /// What this machine lacks for any of its variants; `None` where nothing is known to be missing.
    fn missing(&self) -> Option<String> {
        None
    }

    /// What a ring edge is to `variant` where the scene says `scene`: its picture is compared with a
    /// reference that takes edges for the same.
    fn edge_rule(&self, _variant: &Variant, scene: EdgeRule) -> EdgeRule {
        scene
    }

    /// Whether it draws a surface of its own and not the input's: its picture is then compared with the body
    /// itself.
    fn draws_own_surface(&self) -> bool {
        false
    }

    /// Parameters of its own; the first one is the layout.
    fn parameters(&self) -> &'static [Parameter];

    /// Whether the pictures of `variant` differ from the reference by its nature, such as from a mask of
    /// coarse texels. How far is a result then: such a case is timed, its rows say "approximate", it
    /// never counts as right and is no failure.
    fn is_approximate(&self, _variant: &Variant) -> bool {
        false
    }

    /// Whether the picture of `variant` may differ from the reference although its other pictures must not:
    /// an experiment of which the error is part of the answer. Where its picture is right it counts.
    fn may_be_wrong(&self, _variant: &Variant) -> bool {
        false
    }

    /// Whether [`terrafill_variant::Switches`] mean anything to it; otherwise they are none of its conditions.
    fn has_stencil_switches(&self) -> bool {
        true
    }

    /// The variant to start from on scenes of this kind.
    fn main(&self, overlap: Overlap) -> Variant {
        Variant::new(self.name(), self.parameters(), overlap)
    }

    /// Variants for this role on `scene`.
    fn variants(&self, scene: &Scene, role: Role) -> Vec<Variant>;

    /// From the un-optimised method to the full plan, one switch at a time; empty for a technique that does
    /// not come from it.
    fn ablation(&self, _overlap: Overlap) -> Vec<PlannedStep> {
        Vec::new()
    }

    /// As it should be used: the top of its ablation with boundaries as they are, then with levels of detail, the
    /// same picture but for half a pixel. None for a technique without an ablation.
    fn full_plans(&self, overlap: Overlap) -> Vec<Variant> {
        let mut steps = self.ablation(overlap);
        steps.retain(|step| !step.is_aside);
        let Some(PlannedStep { variant: top, .. }) = steps.pop() else {
            return Vec::new();
        };
        let mut exact = top.clone();
        exact.plan.boundary_lod_px = None;
        if exact == top {
            vec![exact]
        } else {
            vec![exact, top]
        }
    }

    /// `base` with each parameter of its own away from its default, alone. What is not allowed may
    /// be among them. None for a technique without parameters that it may turn.
    fn matrix_row(&self, _base: &Variant) -> Vec<Variant> {
        Vec::new()
    }

    /// Whether parameters and switches go together, and with a scene of this kind. What only the
    /// device or its interface may lack is [`Technique::open`]'s to refuse.
    ///
    /// # Errors
    /// [`SwitchError`].
    fn check(&self, variant: &Variant, overlap: Overlap) -> Result<(), SwitchError>;

    /// How `variant` stores geometry, in rows about memory.
    fn layout(&self, variant: &Variant) -> String {
        variant.layout().to_owned()
    }

    /// Bytes of one region by the layout's formula.
    ///
    /// - `is_drawn`: whether the view draws it, since some layouts hold parts for those only
    ///
    /// # Errors
    /// [`SwitchError`] when `variant` is none of this technique's.
    fn bytes(
        &self,
        variant: &Variant,
        mesh: &RegionMesh,
        is_drawn: bool,
    ) -> Result<GeometryBytes, SwitchError>;

    /// Bytes that all regions share and that are held once, by the layout's formula.
    ///
    /// # Errors
    /// As [`Technique::bytes`].
    fn shared_bytes(
        &self,
        _variant: &Variant,
        _meshes: &[&RegionMesh],
    ) -> Result<GeometryBytes, SwitchError> {
        Ok(GeometryBytes::default())
    }

    /// Bytes of one region in every layout, by the layout's name.
    fn layout_bytes(&self, mesh: &RegionMesh) -> Vec<(String, u64)> {
        let layouts = layouts(self, Overlap::Disjoint).into_iter();
        let bytes = layouts.filter_map(|variant| {
            let bytes = self.bytes(&variant, mesh, true).ok()?;
            Some((self.layout(&variant), bytes.total()))
        });
        bytes.collect()
    }

    /// Figures of its own about a frame, by name; an absent value where the frame has none.
    fn figures(&self, _variant: &Variant, _input: &FillInput) -> Vec<(&'static str, Option<f64>)> {
        Vec::new()
    }

    /// A backend that draws `variant` into `targets`.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when there is no device, or device or interface lack something;
    /// else whatever the device reports.
    fn open(&self, targets: &Targets, variant: &Variant) -> OpenedBackend;
}

/// Every layout of `technique`, with nothing else changed.
#[must_use]
pub fn layouts<T: Technique + ?Sized>(technique: &T, overlap: Overlap) -> Vec<Variant> {
    let main = technique.main(overlap);
    let Some(Parameter {
        key,
        values: Values::OneOf(names),
        ..
    }) = technique.parameters().first()
    else {
        return vec![main];
    };
    names
        .iter()
        .map(|name| main.clone().with(key, name))
        .collect()
}
