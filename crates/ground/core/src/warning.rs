// SPDX-License-Identifier: MIT OR Apache-2.0
//! What has to be said of a region that was read and meshed all the same.

use std::fmt;

/// What a [`RegionWarning`] is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WarningSubject {
    /// What reading put right or left out: open rings, repeated positions, what has no area.
    Reading,
    /// Which places the region holds, where its numbers can be read in two ways.
    Inside,
    /// What a repair made of rings that cross or lie over one another.
    Repair,
    /// How the mesh was made: boundaries that fell away, tolerances that were not reached.
    Mesh,
}

/// Something that a region's owner should know and that does not keep the region from being meshed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RegionWarning {
    /// What it is about.
    pub subject: WarningSubject,
    /// The warning in words. Names polygon and ring where it is about one, and never the feature.
    pub text: String,
}

impl WarningSubject {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Reading, Self::Inside, Self::Repair, Self::Mesh];

    /// A warning about it.
    #[must_use]
    pub fn warn(self, text: impl Into<String>) -> RegionWarning {
        RegionWarning {
            subject: self,
            text: text.into(),
        }
    }
}

impl fmt::Display for RegionWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl PartialEq<&str> for RegionWarning {
    fn eq(&self, text: &&str) -> bool {
        self.text == *text
    }
}
