// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ways in which CesiumJS fills.

use terrafill_variant::{SwitchError, Variant};

/// Of the technique.
pub(crate) const NAME: &str = "cesium";

/// How CesiumJS fills.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CesiumFill {
    Volumes,
    Lookup,
}

impl CesiumFill {
    const ALL: [(&'static str, Self); 2] = [("volumes", Self::Volumes), ("lookup", Self::Lookup)];

    pub(crate) fn of(variant: &Variant) -> Result<Self, SwitchError> {
        variant.choice("path", &Self::ALL)
    }

    /// Name in rows, and of the page's function.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Volumes => "volumes",
            Self::Lookup => "lookup",
        }
    }
}
