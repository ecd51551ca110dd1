// SPDX-License-Identifier: MIT OR Apache-2.0
//! What tells one view from another: a number, given once in a process.

use std::sync::atomic::{AtomicU64, Ordering};

/// Identity of a view: the eye, the image and the surface as drawn. What was uploaded for a view
/// serves every input that has its id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ViewId(u64);

impl ViewId {
    /// An id that no other view has.
    #[must_use]
    pub fn unique() -> Self {
        static GIVEN: AtomicU64 = AtomicU64::new(0);
        Self(GIVEN.fetch_add(1, Ordering::Relaxed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_views_share_an_id() {
        let id = ViewId::unique();
        assert_ne!(id, ViewId::unique());
    }
}
