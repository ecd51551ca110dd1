// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why something is not drawn.

/// Why a region is not drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeftOutReason {
    /// Wholly outside the view frustum.
    OutsideFrustum,
    /// Wholly hidden by the body.
    BeyondHorizon,
    /// Reaches the centre of no pixel.
    TooSmall,
}

impl LeftOutReason {
    /// Every reason.
    pub const ALL: [Self; 3] = [Self::OutsideFrustum, Self::BeyondHorizon, Self::TooSmall];

    /// Name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::OutsideFrustum => "outside-frustum",
            Self::BeyondHorizon => "beyond-horizon",
            Self::TooSmall => "too-small",
        }
    }
}
