// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a technique laid out for its buffers, mesh by mesh or region by region. A view that brings other levels of
//! some regions has these laid out; the others stand as they are.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use terrafill_plan::RegionSet;

/// Parts of a scene's geometry as they were laid out last.
///
/// - `K`: by what a part was laid out
/// - `G`: a part
#[derive(Debug)]
pub struct LaidOut<K, G> {
    /// Of which scene.
    whole: Option<u64>,
    parts: HashMap<usize, (K, G)>,
}

impl<K, G> Default for LaidOut<K, G> {
    fn default() -> Self {
        Self {
            whole: None,
            parts: HashMap::new(),
        }
    }
}

impl<K: PartialEq, G> LaidOut<K, G> {
    /// Forgets those of another scene than that of `meshes`, and those that are not wanted.
    pub fn keep(&mut self, meshes: &RegionSet, is_wanted: impl Fn(usize) -> bool) {
        let whole = Some(meshes.whole_revision());
        if self.whole != whole {
            self.parts.clear();
            self.whole = whole;
        }
        self.parts.retain(|place, _| is_wanted(*place));
    }

    /// The part at a place, laid out anew unless it was by this.
    pub fn part(&mut self, place: usize, by: K, lay_out: impl FnOnce() -> G) -> &G {
        match self.parts.entry(place) {
            Entry::Occupied(mut known) => {
                if known.get().0 != by {
                    known.insert((by, lay_out()));
                }
                &known.into_mut().1
            }
            Entry::Vacant(free) => &free.insert((by, lay_out())).1,
        }
    }

    /// All meshes of a set as laid out. Of those of which a view brings some, those that a set before held are not laid
    /// out again.
    ///
    /// - `by`: what a mesh is laid out by
    /// - `lay_out`: those at these places
    pub fn all(
        &mut self,
        meshes: &RegionSet,
        by: impl Fn(usize) -> K,
        lay_out: impl Fn(Range<usize>) -> G,
        append: impl Fn(&mut G, &G),
    ) -> G
    where
        G: Default,
    {
        if meshes.is_whole() {
            return lay_out(0..meshes.len());
        }
        let mut all = G::default();
        let one = |place| lay_out(place..place + 1);
        self.append_all(meshes, by, one, |part| append(&mut all, part));
        all
    }

    /// Hands every mesh of a set as laid out to `append`, in order. Those that a set before held are not laid out
    /// again, and of those that are not held there is nothing to keep.
    ///
    /// - `by`: what a mesh is laid out by
    pub fn append_all(
        &mut self,
        meshes: &RegionSet,
        by: impl Fn(usize) -> K,
        lay_out: impl Fn(usize) -> G,
        mut append: impl FnMut(&G),
    ) {
        let is_held = |place: usize| meshes[place].vertex_count() > 0;
        self.keep(meshes, is_held);
        for place in 0..meshes.len() {
            if is_held(place) {
                append(self.part(place, by(place), || lay_out(place)));
            } else {
                append(&lay_out(place));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::RegionMesh;

    #[test]
    fn a_part_is_laid_out_when_it_is_new_or_asked_for_otherwise() {
        let set = || RegionSet::from(vec![RegionMesh::without_geometry(); 3]);
        let (own, other) = (set(), set());
        let mut laid_out = LaidOut::default();
        let mut count = 0;
        let mut ask = |meshes: &RegionSet, wanted: &[(usize, bool)]| {
            laid_out.keep(meshes, |place| wanted.iter().any(|of| of.0 == place));
            let before = count;
            for &(place, by) in wanted {
                let part = laid_out.part(place, by, || {
                    count += 1;
                    (place, by)
                });
                assert_eq!(*part, (place, by));
            }
            count - before
        };
        assert_eq!(ask(&own, &[(0, true), (2, true)]), 2);
        assert_eq!(ask(&own, &[(0, true), (1, true), (2, true)]), 1);
        assert_eq!(ask(&own.with_geometry_of(|_| false), &[(0, true)]), 0);
        // Negative controls: one that was not wanted is forgotten, another key is another part, and so is
        // another scene's.
        assert_eq!(ask(&own, &[(0, true), (2, true)]), 1);
        assert_eq!(ask(&own, &[(0, false), (2, true)]), 1);
        assert_eq!(ask(&other, &[(0, false), (2, true)]), 2);
    }
}
