// SPDX-License-Identifier: MIT OR Apache-2.0
//! Between which heights a surface lies.

/// Heights above the ellipsoid between which a surface lies, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightRange {
    /// No point lies lower.
    pub lowest_m: f64,
    /// No point lies higher.
    pub highest_m: f64,
}

impl HeightRange {
    /// What lies in both ranges, or `None` where they have nothing in common.
    #[must_use]
    pub fn intersection(self, other: Self) -> Option<Self> {
        let both = Self {
            lowest_m: self.lowest_m.max(other.lowest_m),
            highest_m: self.highest_m.min(other.highest_m),
        };
        (both.lowest_m <= both.highest_m).then_some(both)
    }

    /// The smallest range that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            lowest_m: self.lowest_m.min(other.lowest_m),
            highest_m: self.highest_m.max(other.highest_m),
        }
    }
}
