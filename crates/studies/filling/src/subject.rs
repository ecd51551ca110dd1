// SPDX-License-Identifier: MIT OR Apache-2.0
//! What draws a case: a full-screen pass, or a variant of a technique.

use crate::keys::{LAYOUT, POSITIONS};
use terrafill_contract::{Api, FillInput, GeometryBytes, Technique};
use terrafill_core::RegionMesh;
use terrafill_gpu::BaselineKind;
use terrafill_plan::{LazyMesh, PlanOptions};
use terrafill_results::ConditionKey;
use terrafill_stencil::PositionFormat;
use terrafill_surface::SurfaceKind;
use terrafill_variant::{Switches, Variant};

/// Techniques of a study, in the order in which they are measured. The first is the one whose
/// pictures the others' are laid beside.
pub type Techniques = &'static [&'static dyn Technique];

/// Surfaces that scenes may name.
pub type Surfaces = &'static [&'static dyn SurfaceKind];

/// What draws a case.
#[derive(Debug, Clone)]
pub(crate) enum Subject {
    /// A full-screen pass.
    Baseline(BaselineKind),
    /// A variant of a technique.
    Fill(&'static dyn Technique, Variant),
}

impl Subject {
    /// Name of the technique, or of the pass, in rows.
    pub(crate) fn backend(&self) -> &'static str {
        match self {
            Self::Baseline(kind) => kind.name(),
            Self::Fill(technique, _) => technique.name(),
        }
    }

    /// Layout first, then what differs from the default, `key=value`, sorted.
    pub(crate) fn variant_name(&self) -> String {
        match self {
            Self::Baseline(_) => "full-screen".to_owned(),
            Self::Fill(_, variant) => variant.name(),
        }
    }

    /// `None` of a full-screen pass.
    fn fill(&self) -> Option<(&'static dyn Technique, &Variant)> {
        match self {
            Self::Baseline(_) => None,
            Self::Fill(technique, variant) => Some((*technique, variant)),
        }
    }

    /// Whether its pictures differ from the reference by nature, so that how far is the question.
    pub(crate) fn is_approximate(&self) -> bool {
        let fill = self.fill();
        fill.is_some_and(|(technique, variant)| technique.is_approximate(variant))
    }

    /// Whether its error is part of the answer.
    pub(crate) fn may_be_wrong(&self) -> bool {
        let fill = self.fill();
        fill.is_some_and(|(technique, variant)| technique.may_be_wrong(variant))
    }

    /// One of the technique's own figures about a frame.
    pub(crate) fn figure(&self, name: &str, input: &FillInput) -> Option<f64> {
        let (technique, variant) = self.fill()?;
        let mut figures = technique.figures(variant, input).into_iter();
        figures.find(|(found, _)| *found == name)?.1
    }

    /// Every choice with its value, defaults included, but for switches that mean nothing to the
    /// technique. The first of its own parameters is called `layout`, whatever it is called there, so
    /// that it is one column for all.
    pub(crate) fn settings(&self) -> Vec<(ConditionKey, String)> {
        let Some((technique, variant)) = self.fill() else {
            return Vec::new();
        };
        let first = technique
            .parameters()
            .first()
            .map(|parameter| parameter.key);
        let layout = (LAYOUT, variant.layout().to_owned());
        let others = variant.settings().into_iter();
        let others = others.filter(|(key, _)| Some(*key) != first);
        let of_stencil = if technique.has_stencil_switches() {
            Vec::new()
        } else {
            variant.switches.settings().clone()
        };
        let others = others.filter(|(key, _)| of_stencil.iter().all(|(own, _)| own != key));
        let others = others.map(|(key, value)| (ConditionKey::declare(key), value));
        std::iter::once(layout).chain(others).collect()
    }

    /// The fill's switches; a full-screen pass has none.
    pub(crate) fn switches(&self) -> Option<&Switches> {
        self.fill().map(|(_, variant)| &variant.switches)
    }

    /// How its frames are planned.
    pub(crate) fn plan(&self) -> PlanOptions {
        let plan = self.fill().map(|(_, variant)| variant.plan);
        plan.unwrap_or_default()
    }

    /// The interface that it draws by.
    pub(crate) fn api(&self) -> Api {
        let api = self.fill().map(|(technique, _)| technique.api());
        api.unwrap_or(terrafill_gpu::API)
    }

    /// How it stores positions, where that is a choice.
    pub(crate) fn positions(&self) -> Option<PositionFormat> {
        let value = self.fill()?.1.value(POSITIONS.name())?;
        let mut formats = PositionFormat::ALL.into_iter();
        formats.find(|format| format.name() == value)
    }

    /// How geometry is stored; empty where there is none.
    pub(crate) fn layout(&self) -> String {
        let layout = self
            .fill()
            .map(|(technique, variant)| technique.layout(variant));
        layout.unwrap_or_default()
    }

    /// Bytes of one region by the layout's formula; `None` where there is no geometry.
    ///
    /// - `is_drawn`: whether the view draws it, since some layouts hold parts for those only
    pub(crate) fn formula(&self, mesh: &RegionMesh, is_drawn: bool) -> Option<GeometryBytes> {
        let (technique, variant) = self.fill()?;
        technique.bytes(variant, mesh, is_drawn).ok()
    }

    /// Bytes that all regions share, by the layout's formula.
    pub(crate) fn shared_formula(&self, meshes: &[LazyMesh]) -> GeometryBytes {
        let meshes: Vec<&RegionMesh> = meshes.iter().map(|mesh| &**mesh).collect();
        let bytes = self
            .fill()
            .and_then(|(technique, variant)| technique.shared_bytes(variant, &meshes).ok());
        bytes.unwrap_or_default()
    }
}
