// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes of a scene's regions, and what tells one set of them from another.

use crate::{LazyMesh, MeshParts};
use std::collections::BTreeSet;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use terrafill_core::{Ellipsoid, RegionMesh};

/// Meshes of a scene's regions. What was uploaded for a set serves every set of its revision: clones,
/// and nothing else.
#[derive(Debug, Clone)]
pub struct RegionSet {
    revision: u64,
    /// Of the set that has all the geometry of which this one has some.
    whole: u64,
    origin: Option<Origin>,
    /// Of those that have no geometry here nothing.
    meshes: Arc<[LazyMesh]>,
}

/// Which set another one was made from, and where the two differ.
#[derive(Debug, Clone)]
struct Origin {
    revision: u64,
    /// Ascending, each once.
    changed: Arc<[usize]>,
}

/// A set has no region at this place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("region {found} of a set of {regions}")]
pub struct NoSuchRegion {
    /// The place.
    pub found: usize,
    /// How many regions there are.
    pub regions: usize,
}

impl RegionSet {
    /// Sets of one revision hold the same meshes.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Sets for which this is the same have the same mesh at a place, or one of them has none there: see
    /// [`RegionSet::with_geometry_of`].
    #[must_use]
    pub fn whole_revision(&self) -> u64 {
        self.whole
    }

    /// Whether all meshes of its whole are here.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.whole == self.revision
    }

    /// A set with other meshes at some places, which remembers what it was made from. Of two meshes
    /// for one place the last one counts.
    ///
    /// - cost: O(meshes); none is copied
    ///
    /// # Errors
    /// [`NoSuchRegion`] for a place that this set does not have.
    pub fn with_changed(
        &self,
        meshes: impl IntoIterator<Item = (usize, impl Into<LazyMesh>)>,
    ) -> Result<Self, NoSuchRegion> {
        let mut all = self.meshes.to_vec();
        let mut changed = BTreeSet::new();
        for (found, mesh) in meshes {
            let regions = all.len();
            let place = all.get_mut(found);
            *place.ok_or(NoSuchRegion { found, regions })? = mesh.into();
            changed.insert(found);
        }
        Ok(Self {
            origin: Some(Origin {
                revision: self.revision,
                changed: changed.into_iter().collect(),
            }),
            ..Self::from(all)
        })
    }

    /// A set of which some meshes have no geometry: for those who need the others only, at their places.
    ///
    /// - cost: O(meshes); none is copied, and of the others none is made that is not there yet
    #[must_use]
    pub fn with_geometry_of(&self, keeps: impl Fn(usize) -> bool) -> Self {
        let without = LazyMesh::from(RegionMesh::without_geometry());
        let meshes = self.meshes.iter().enumerate();
        let meshes = meshes.map(|(place, mesh)| {
            if keeps(place) {
                mesh.clone()
            } else {
                without.clone()
            }
        });
        Self {
            whole: self.whole,
            ..Self::from(meshes.collect::<Vec<_>>())
        }
    }

    /// Where this set differs from the one of `revision` that it was made from, ascending; `None` for
    /// any other set.
    #[must_use]
    pub fn changed_since(&self, revision: u64) -> Option<&[usize]> {
        let origin = self.origin.as_ref();
        let origin = origin.filter(|origin| origin.revision == revision)?;
        Some(&origin.changed)
    }
}

impl Default for RegionSet {
    fn default() -> Self {
        Self::from(Vec::<LazyMesh>::new())
    }
}

impl From<Vec<RegionMesh>> for RegionSet {
    fn from(meshes: Vec<RegionMesh>) -> Self {
        let meshes = meshes.into_iter().map(LazyMesh::from);
        Self::from(meshes.collect::<Vec<_>>())
    }
}

impl From<Vec<LazyMesh>> for RegionSet {
    fn from(meshes: Vec<LazyMesh>) -> Self {
        static GIVEN: AtomicU64 = AtomicU64::new(0);
        let revision = GIVEN.fetch_add(1, Ordering::Relaxed) + 1;
        Self {
            revision,
            whole: revision,
            origin: None,
            meshes: meshes.into(),
        }
    }
}

impl Deref for RegionSet {
    type Target = [LazyMesh];

    fn deref(&self) -> &[LazyMesh] {
        &self.meshes
    }
}

/// Parts of a scene's large meshes, each found when a view draws the mesh; shared by all who have the same
/// meshes.
#[derive(Debug, Clone, Default)]
pub struct LazyParts(Arc<OnceLock<PartsOfMeshes>>);

/// Of each mesh; `None` where it is so small that it is one part.
type PartsOfMeshes = Box<[OnceLock<Option<MeshParts>>]>;

impl LazyParts {
    /// Those of a mesh; `None` where it is so small that it is one part.
    ///
    /// - `meshes`: always the same
    #[must_use]
    pub fn of(&self, body: &Ellipsoid, meshes: &RegionSet, mesh: usize) -> Option<&MeshParts> {
        let all = self
            .0
            .get_or_init(|| meshes.iter().map(|_| OnceLock::new()).collect());
        let own = all[mesh].get_or_init(|| MeshParts::of(body, &meshes[mesh]));
        own.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::{EdgeRule, MeshOptions, parse_regions};

    #[test]
    fn clones_keep_their_identity_and_equal_contents_do_not_share_one() {
        let set = RegionSet::default();
        assert_eq!(set.revision(), set.clone().revision());
        assert_ne!(set.revision(), RegionSet::from(set.to_vec()).revision());
        // Of less geometry it is another set, of the same whole.
        let some = set.with_geometry_of(|_| false);
        assert_ne!(some.revision(), set.revision());
        assert_eq!(some.whole_revision(), set.revision());
        assert_ne!(RegionSet::default().whole_revision(), set.revision());
    }

    #[test]
    fn a_changed_set_knows_its_origin_and_no_other_set() {
        let triangle = r#"{"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1],[0,0]]]}"#;
        let regions = parse_regions(triangle.as_bytes(), "test").expect("valid");
        let options = MeshOptions::default();
        let (body, rule) = (Ellipsoid::WGS84, EdgeRule::Planar);
        let meshes = RegionMesh::build_all(&regions, &body, rule, &options).expect("it meshes");
        let mesh = || meshes[0].clone();
        let set = RegionSet::from(vec![mesh(), mesh(), mesh()]);
        let changed = set.with_changed([(2, mesh()), (0, mesh()), (2, mesh())]);
        let changed = changed.expect("three regions");
        assert_eq!(changed.changed_since(set.revision()), Some(&[0, 2][..]));
        assert_eq!(changed.len(), 3);
        // Negative controls: neither itself nor equal contents are its origin, nor is a grandparent.
        assert_eq!(changed.changed_since(changed.revision()), None);
        let equal = RegionSet::from(set.to_vec());
        assert_eq!(changed.changed_since(equal.revision()), None);
        let again = changed.with_changed([(1, mesh())]).expect("three regions");
        assert_eq!(again.changed_since(set.revision()), None);
        let (found, regions) = (3, 3);
        let error = set.with_changed([(3, mesh())]).expect_err("three regions");
        assert_eq!(error, NoSuchRegion { found, regions });
    }
}
