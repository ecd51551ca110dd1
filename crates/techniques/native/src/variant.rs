// SPDX-License-Identifier: MIT OR Apache-2.0
//! A variant of the native backend: how volumes come about, and the switches of the fill.

use crate::{Extrusion, Indices};
use terrafill_plan::PartCulling;
use terrafill_scene::Overlap;
use terrafill_stencil::WallIndices;
use terrafill_variant::{SwitchError, Switches, Variant};

/// A variant: how volumes come about, and the switches of the fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct NativeVariant {
    /// How volumes come about.
    pub technique: Extrusion,
    /// How triangles are indexed; `None`: as [`Extrusion::default_indices`] says.
    pub indices: Option<Indices>,
    /// Triangles of large meshes lie part by part, so that plans may leave parts out.
    pub parts: bool,
    /// What the fill does.
    pub switches: Switches,
}

impl NativeVariant {
    /// What `variant` says.
    ///
    /// # Errors
    /// [`SwitchError`] when it is one of another technique.
    pub fn of(variant: &Variant) -> Result<Self, SwitchError> {
        let techniques = Extrusion::ALL.map(|technique| (technique.name(), technique));
        let kinds = Indices::ALL.map(|indices| (indices.name(), indices));
        Ok(Self {
            technique: variant.choice("technique", &techniques)?,
            indices: Some(variant.choice("indices", &kinds)?),
            parts: variant.plan.part_culling != PartCulling::Off,
            switches: variant.switches,
        })
    }

    /// How many indices walls take where parts of regions may be drawn alone: where caps and walls are draws of
    /// their own, and a facet needs no indices but its own.
    pub(crate) fn wall_indices(&self) -> Option<WallIndices> {
        match self.technique {
            Extrusion::VsControl => Some(WallIndices::STRIP),
            Extrusion::GsLine => Some(WallIndices::LINE_STRIP),
            Extrusion::GsDegenerate
            | Extrusion::GsTwoEdges
            | Extrusion::GsAdjacency
            | Extrusion::GsPerTriangle => None,
        }
    }

    /// Whether technique and switches go together, and with a scene of this kind.
    ///
    /// # Errors
    /// [`SwitchError`].
    pub fn check(&self, overlap: Overlap) -> Result<(), SwitchError> {
        self.check_indices()?;
        self.switches.check(overlap)
    }

    /// How triangles are indexed.
    #[must_use]
    pub fn indices(&self) -> Indices {
        self.indices.unwrap_or(self.technique.default_indices())
    }

    pub(crate) fn check_indices(&self) -> Result<(), SwitchError> {
        if self.indices() == Indices::List || self.technique.has_index_choice() {
            return Ok(());
        }
        Err(SwitchError {
            switch: "indices",
            found: format!(
                "{} with technique={}, whose triangles are never strips",
                self.indices().name(),
                self.technique.name()
            ),
            allowed: "none, or technique=gs-degenerate or gs-adjacency".to_owned(),
        })
    }
}
