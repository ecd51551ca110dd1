// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes that are made when they are first looked at: a program that draws some levels of detail of some
//! regions makes the meshes of these.

use rayon::prelude::*;
use std::borrow::Borrow;
use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use terrafill_core::RegionMesh;

/// A mesh that is there, or is made when it is first looked at. Clones are the same mesh.
#[derive(Clone)]
pub struct LazyMesh(Arc<Inner>);

enum Inner {
    Made(RegionMesh),
    Later {
        made: OnceLock<RegionMesh>,
        /// Let go of once it is made: what all meshes of a scene are made from takes more than they do.
        source: Mutex<Option<Arc<dyn MeshSource>>>,
        place: usize,
    },
}

/// What meshes are made from that are not there yet.
pub(crate) trait MeshSource: Send + Sync {
    /// Makes what its meshes have in common, unless it is there.
    fn make_common(&self);

    /// Makes one of them.
    fn make(&self, place: usize) -> RegionMesh;
}

impl LazyMesh {
    /// Of threads that look at it at once each may make it; all see the same one.
    ///
    /// - `place`: which mesh of `source` it is
    pub(crate) fn new(source: Arc<dyn MeshSource>, place: usize) -> Self {
        Self(Arc::new(Inner::Later {
            made: OnceLock::new(),
            source: Mutex::new(Some(source)),
            place,
        }))
    }

    /// Whether it is there.
    #[must_use]
    pub fn is_made(&self) -> bool {
        match &*self.0 {
            Inner::Made(_) => true,
            Inner::Later { made, .. } => made.get().is_some(),
        }
    }

    /// Makes those that are not there yet, several at a time.
    pub fn make_all<'a>(meshes: impl IntoIterator<Item = &'a Self>) {
        let meshes = meshes.into_iter();
        let missing: Vec<&Self> = meshes.filter(|mesh| !mesh.is_made()).collect();
        let mut sources: Vec<Arc<dyn MeshSource>> = Vec::new();
        for source in missing.iter().filter_map(|mesh| mesh.source()) {
            if !sources.iter().any(|known| Arc::ptr_eq(known, &source)) {
                sources.push(source);
            }
        }
        // First, or several threads would each make it.
        sources.par_iter().for_each(|source| source.make_common());
        missing.par_iter().for_each(|mesh| {
            let _: &RegionMesh = mesh;
        });
    }

    /// What it is still to be made from.
    fn source(&self) -> Option<Arc<dyn MeshSource>> {
        match &*self.0 {
            Inner::Made(_) => None,
            Inner::Later { source, .. } => locked(source).clone(),
        }
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What is in `cell`, or what `make` makes for it.
///
/// The cell isn't locked meanwhile. Making uses the thread pool, and a thread that waits there may be given work
/// that looks into the same cell.
pub(crate) fn made<T>(cell: &OnceLock<T>, make: impl FnOnce() -> T) -> &T {
    cell.get().unwrap_or_else(|| {
        let value = make();
        cell.get_or_init(|| value)
    })
}

impl Deref for LazyMesh {
    type Target = RegionMesh;

    fn deref(&self) -> &RegionMesh {
        match &*self.0 {
            Inner::Made(mesh) => mesh,
            Inner::Later {
                made: cell,
                source,
                place,
            } => cell.get().unwrap_or_else(|| {
                let of = locked(source).clone();
                // Another thread has made it where there is none any more.
                let mesh = of.map(|of| of.make(*place));
                let mesh = cell.get_or_init(|| mesh.unwrap_or_else(RegionMesh::without_geometry));
                *locked(source) = None;
                mesh
            }),
        }
    }
}

impl Borrow<RegionMesh> for LazyMesh {
    fn borrow(&self) -> &RegionMesh {
        self
    }
}

impl From<RegionMesh> for LazyMesh {
    fn from(mesh: RegionMesh) -> Self {
        Self(Arc::new(Inner::Made(mesh)))
    }
}

impl fmt::Debug for LazyMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mesh = self.is_made().then(|| &**self);
        f.debug_tuple("LazyMesh").field(&mesh).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parts::tests::strip;
    use std::sync::atomic::{AtomicUsize, Ordering};

    struct Strips {
        common: AtomicUsize,
        made: AtomicUsize,
    }

    impl MeshSource for Strips {
        fn make_common(&self) {
            self.common.fetch_add(1, Ordering::Relaxed);
        }

        fn make(&self, place: usize) -> RegionMesh {
            self.made.fetch_add(1, Ordering::Relaxed);
            strip(u32::try_from(place).expect("few"))
        }
    }

    #[test]
    fn a_mesh_is_made_once_and_only_when_it_is_looked_at() {
        let source = Arc::new(Strips {
            common: AtomicUsize::new(0),
            made: AtomicUsize::new(0),
        });
        let lazy = |squares| LazyMesh::new(Arc::clone(&source) as _, squares);
        let meshes = [lazy(3), lazy(4), lazy(5), strip(6).into()];
        let clone = meshes[0].clone();
        let are_made = || [0, 1, 2, 3].map(|mesh: usize| meshes[mesh].is_made());
        assert_eq!(are_made(), [false, false, false, true]);
        assert_eq!(meshes[0].triangle_count(), strip(3).triangle_count());
        assert_eq!(are_made(), [true, false, false, true]);
        assert!(clone.is_made() && std::ptr::eq(&*clone, &*meshes[0]));
        LazyMesh::make_all(&meshes);
        assert_eq!(are_made(), [true; 4]);
        LazyMesh::make_all(&meshes);
        // Negative control: what another one makes is not the same mesh, and was counted.
        assert!(!std::ptr::eq(&*meshes[0], &*meshes[1]));
        let counted = [&source.common, &source.made].map(|count| count.load(Ordering::Relaxed));
        assert_eq!(counted, [1, 3]);
        // What they were made from nobody has any more.
        assert_eq!(Arc::strong_count(&source), 1);
    }
}
