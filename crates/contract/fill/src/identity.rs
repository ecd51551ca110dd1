// SPDX-License-Identifier: MIT OR Apache-2.0
//! What tells one view and one set of regions from another: numbers, given once in a process.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use terrafill_core::RegionMesh;

/// Last number given.
static GIVEN: AtomicU64 = AtomicU64::new(0);

fn next() -> u64 {
    GIVEN.fetch_add(1, Ordering::Relaxed) + 1
}

/// Identity of a view: the eye, the image and the surface as drawn. What was uploaded for a view
/// serves every input that has its id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ViewId(u64);

impl ViewId {
    /// An id that no other view has.
    #[must_use]
    pub fn unique() -> Self {
        Self(next())
    }
}

/// Meshes of a scene's regions. What was uploaded for a set serves every set of its revision: clones,
/// and nothing else.
#[derive(Debug, Clone)]
pub struct RegionSet {
    revision: u64,
    meshes: Arc<[RegionMesh]>,
}

impl RegionSet {
    /// Sets of one revision hold the same meshes.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.revision
    }
}

impl Default for RegionSet {
    fn default() -> Self {
        Self::from(Vec::new())
    }
}

impl From<Vec<RegionMesh>> for RegionSet {
    fn from(meshes: Vec<RegionMesh>) -> Self {
        Self {
            revision: next(),
            meshes: meshes.into(),
        }
    }
}

impl Deref for RegionSet {
    type Target = [RegionMesh];

    fn deref(&self) -> &[RegionMesh] {
        &self.meshes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_keep_their_identity_and_equal_contents_do_not_share_one() {
        let set = RegionSet::default();
        assert_eq!(set.revision(), set.clone().revision());
        assert_ne!(set.revision(), RegionSet::from(set.to_vec()).revision());
        assert_ne!(ViewId::unique(), ViewId::unique());
    }
}
