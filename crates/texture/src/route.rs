// SPDX-License-Identifier: MIT OR Apache-2.0
//! Coordinate routes: every way from an offset to longitude and latitude, under a stable name.

use crate::angle::AngleCore;
use crate::latitude::LatitudeForm;
use crate::operations::{Arithmetic, Operations, Program};
use crate::region::MapRegion;
use crate::residual::{RESIDUAL_SAMPLES, Residual, residual_of};

/// Which quantities the angles are taken of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleForm {
    /// Position in `f32`, longitude and latitude of it, the anchor's latitude subtracted: what every
    /// globe does first, and off by metres, since an `f32` longitude of π has a step of 1.5 m.
    Absolute,
    /// Angles between the anchor's directions and the position's, of differences alone: nothing
    /// cancels, so the error shrinks with the region.
    Recentred,
    /// The recentred form without octants: for points less than 45° from the anchor in both angles.
    Near,
}

impl AngleForm {
    /// Every form.
    pub const ALL: [Self; 3] = [Self::Absolute, Self::Recentred, Self::Near];

    /// Prefix of a route's name.
    #[must_use]
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Absolute => "",
            Self::Recentred => "recentred-",
            Self::Near => "near-",
        }
    }
}

/// A way from a fragment's offset to longitude and latitude, both relative to the anchor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum CoordinateRoute {
    /// Two arctangents.
    Angles {
        /// Of absolute positions or of differences.
        form: AngleForm,
        /// How an arctangent is computed.
        core: AngleCore,
        /// Which latitude.
        latitude: LatitudeForm,
    },
}

impl CoordinateRoute {
    /// Every route.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for form in AngleForm::ALL {
            for core in AngleCore::all() {
                all.extend(LatitudeForm::ALL.map(|latitude| Self::Angles {
                    form,
                    core,
                    latitude,
                }));
            }
        }
        all
    }

    /// Stable name: form, core and latitude, as in `recentred-odd-7+bowring-1`.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Angles {
                form,
                core,
                latitude,
            } => format!("{}{}+{}", form.prefix(), core.name(), latitude.name()),
        }
    }

    /// The route called `name`; without a latitude it is one step of Bowring's.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        let full = if name.contains('+') {
            name.to_owned()
        } else {
            format!("{name}+{}", LatitudeForm::Bowring1.name())
        };
        Self::all()
            .into_iter()
            .find(|route| route.name() == full || route.name() == name)
    }
}
