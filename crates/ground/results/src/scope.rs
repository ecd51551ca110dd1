// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a time covers of a frame's work: a comparison may use only times that cover what it compares.

/// A set of parts of a frame's work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Scope(u8);

impl Scope {
    /// No part: of figures that are no times.
    pub const NOTHING: Self = Self(0);
    /// What the CPU works out: planning, meshing, culling, steps of its own.
    pub const PLAN: Self = Self(1);
    /// What the CPU sends, from its writing to the copy's end.
    pub const UPLOAD: Self = Self(1 << 1);
    /// Compute dispatches, and copies and clears between them.
    pub const DISPATCH: Self = Self(1 << 2);
    /// Render passes.
    pub const DRAW: Self = Self(1 << 3);
    /// Passes that turn what was drawn into the image.
    pub const RESOLVE: Self = Self(1 << 4);
    /// What the device gives back to the CPU.
    pub const READ_BACK: Self = Self(1 << 5);
    /// All that a device does of a frame.
    pub const DEVICE: Self = Self::DISPATCH.and(Self::DRAW).and(Self::RESOLVE);
    /// A frame from its upload until the device is done.
    pub const FRAME: Self = Self::UPLOAD.and(Self::DEVICE);

    /// Both sets.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all of `needed` is in it.
    #[must_use]
    pub const fn covers(self, needed: Self) -> bool {
        self.0 & needed.0 == needed.0
    }

    /// Whether they have a part in common.
    #[must_use]
    pub const fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Whether it holds no part.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// As in `metrics.csv`: `upload+draw`, nothing for no part.
impl std::fmt::Display for Scope {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        const NAMES: [&str; 6] = ["plan", "upload", "dispatch", "draw", "resolve", "read-back"];
        let parts = NAMES
            .iter()
            .enumerate()
            .filter(|(bit, _)| self.0 >> bit & 1 == 1);
        let parts: Vec<&str> = parts.map(|(_, name)| *name).collect();
        f.write_str(&parts.join("+"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scope_covers_its_parts_and_no_others() {
        assert!(Scope::FRAME.covers(Scope::UPLOAD.and(Scope::DRAW)));
        assert!(Scope::DRAW.covers(Scope::NOTHING));
        // Negative controls: a device's clock knows of no upload, a part is not the whole.
        assert!(!Scope::DEVICE.covers(Scope::UPLOAD.and(Scope::DRAW)));
        assert!(!Scope::DRAW.covers(Scope::DEVICE));
        assert_eq!(Scope::FRAME.to_string(), "upload+dispatch+draw+resolve");
        assert_eq!(Scope::READ_BACK.to_string(), "read-back");
        assert!(Scope::NOTHING.to_string().is_empty());
        assert!(Scope::NOTHING.is_empty() && !Scope::PLAN.is_empty());
        assert!(Scope::FRAME.meets(Scope::DEVICE) && !Scope::PLAN.meets(Scope::DEVICE));
    }
}
