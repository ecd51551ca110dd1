// SPDX-License-Identifier: MIT OR Apache-2.0
//! What draws a case: a full-screen pass, or a variant of a technique.

use crate::keys::{LAYOUT, POSITIONS};
use terrafill_core::RegionMesh;
use terrafill_fill::{Api, FillInput, GeometryBytes, PositionFormat, Switches, Technique, Variant};
use terrafill_gpu::BaselineKind;
use terrafill_results::ConditionKey;
use terrafill_scene::{LazyMesh, PlanOptions};
use terrafill_surface::SurfaceKind;

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

    fn variant(&self) -> Option<&Variant> {
        match self {
            Self::Baseline(_) => None,
            Self::Fill(_, variant) => Some(variant),
        }
    }

    /// Whether its pictures differ from the reference by nature, so that how far is the question.
    pub(crate) fn is_approximate(&self) -> bool {
        match self {
            Self::Baseline(_) => false,
            Self::Fill(technique, variant) => technique.is_approximate(variant),
        }
    }

    /// Whether its error is part of the answer.
    pub(crate) fn may_be_wrong(&self) -> bool {
        match self {
            Self::Baseline(_) => false,
            Self::Fill(technique, variant) => technique.may_be_wrong(variant),
        }
    }

    /// One of the technique's own figures about a frame.
    pub(crate) fn figure(&self, name: &str, input: &FillInput) -> Option<f64> {
        let Self::Fill(technique, variant) = self else {
            return None;
        };
        let mut figures = technique.figures(variant, input).into_iter();
        figures.find(|(found, _)| *found == name)?.1
    }

    /// Every choice with its value, defaults included, but for switches that mean nothing to the
    /// technique. The first of its own parameters is called `layout`, whatever it is called there, so
    /// that it is one column for all.
    pub(crate) fn settings(&self) -> Vec<(ConditionKey, String)> {
        let Self::Fill(technique, variant) = self else {
            return Vec::new();
        };
        let first = technique
            .parameters()
            .first()
            .map(|parameter| parameter.key);
        let layout = (LAYOUT, variant.layout().to_owned());
        let others = variant.settings().into_iter();
        let others = others.filter(|(key, _)| Some(*key) != first);
        let of_stencil = match technique.has_stencil_switches() {
            true => Vec::new(),
            false => variant.switches.settings().to_vec(),
        };
        let others = others.filter(|(key, _)| of_stencil.iter().all(|(own, _)| own != key));
        let others = others.map(|(key, value)| (ConditionKey::declare(key), value));
        [layout].into_iter().chain(others).collect()
    }

    /// The fill's switches; a full-screen pass has none.
    pub(crate) fn switches(&self) -> Option<&Switches> {
        self.variant().map(|variant| &variant.switches)
    }

    /// How its frames are planned.
    pub(crate) fn plan(&self) -> PlanOptions {
        let plan = self.variant().map(|variant| variant.plan);
        plan.unwrap_or_default()
    }

    /// The interface that it draws by.
    pub(crate) fn api(&self) -> Api {
        match self {
            Self::Baseline(_) => terrafill_gpu::API,
            Self::Fill(technique, _) => technique.api(),
        }
    }

    /// How it stores positions, where that is a choice.
    pub(crate) fn positions(&self) -> Option<PositionFormat> {
        let value = self.variant()?.value(POSITIONS.name())?;
        let mut formats = PositionFormat::ALL.into_iter();
        formats.find(|format| format.name() == value)
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
    pub(crate) fn formula(&self, mesh: &RegionMesh, is_drawn: bool) -> Option<GeometryBytes> {
        match self {
            Self::Baseline(_) => None,
            Self::Fill(technique, variant) => technique.bytes(variant, mesh, is_drawn).ok(),
        }
    }

    /// Bytes that all regions share, by the layout's formula.
    pub(crate) fn shared_formula(&self, meshes: &[LazyMesh]) -> GeometryBytes {
        match self {
            Self::Baseline(_) => GeometryBytes::default(),
            Self::Fill(technique, variant) => {
                let meshes: Vec<&RegionMesh> = meshes.iter().map(|mesh| &**mesh).collect();
                technique.shared_bytes(variant, &meshes).unwrap_or_default()
            }
        }
    }
}
