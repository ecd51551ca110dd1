// SPDX-License-Identifier: MIT OR Apache-2.0
//! A model's triangles, parted where they hang together no longer.
//!
//! First by the file's own indices: a body whose indices close it is a part, even where it touches another
//! with equal bits. Whatever is left is welded by equal bits, since files often repeat a corner for each face.

use crate::mesh::index;
use crate::verdict::{edges, welded};
use glam::DVec3;
use std::collections::BTreeMap;

/// Triangles by part, in the order of their first ones.
pub(crate) fn pieces(places: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 3]>> {
    let all: Vec<usize> = (0..triangles.len()).collect();
    let own = |at: usize| triangles[at];
    let (mut parts, open): (Vec<_>, Vec<_>) = connected(places.len(), &all, own)
        .into_iter()
        .partition(|part| is_closed(part.iter().map(|at| own(*at))));
    let mut rest: Vec<usize> = open.into_iter().flatten().collect();
    rest.sort_unstable();
    let equals = welded(places);
    let welded = |at: usize| triangles[at].map(|corner| equals[corner as usize]);
    parts.extend(connected(places.len(), &rest, welded));
    parts.sort_by_key(|part| part.first().copied());
    let triangles = |part: Vec<usize>| part.into_iter().map(own).collect();
    parts.into_iter().map(triangles).collect()
}

fn is_closed(triangles: impl Iterator<Item = [u32; 3]>) -> bool {
    edges(triangles).values().all(|met| *met == [1, 1])
}

/// Groups of triangles that share vertices.
fn connected(
    vertices: usize,
    triangles: &[usize],
    corners: impl Fn(usize) -> [u32; 3],
) -> Vec<Vec<usize>> {
    let mut parent: Vec<u32> = (0..index(vertices)).collect();
    fn root(parent: &mut [u32], mut at: u32) -> u32 {
        while parent[at as usize] != at {
            // Halves the way for those who come after.
            parent[at as usize] = parent[parent[at as usize] as usize];
            at = parent[at as usize];
        }
        at
    }
    for &triangle in triangles {
        let [a, b, c] = corners(triangle);
        for other in [b, c] {
            let (own, other) = (root(&mut parent, a), root(&mut parent, other));
            parent[own.max(other) as usize] = own.min(other);
        }
    }
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for &triangle in triangles {
        let [a, ..] = corners(triangle);
        groups
            .entry(root(&mut parent, a))
            .or_default()
            .push(triangle);
    }
    groups.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::tests::tetrahedron;

    #[test]
    fn a_soup_is_welded_and_closed_bodies_are_not() {
        let (places, triangles) = tetrahedron();
        assert_eq!(
            pieces(&places, &triangles),
            std::slice::from_ref(&triangles)
        );
        // Twice the same body, under numbers of its own: two parts although every bit is equal.
        let both: Vec<DVec3> = places.iter().chain(&places).copied().collect();
        let moved = triangles.iter().map(|own| own.map(|corner| corner + 4));
        let twice: Vec<[u32; 3]> = triangles.iter().copied().chain(moved).collect();
        assert_eq!(pieces(&both, &twice).len(), 2);
        // A corner for each face: one part, and as many as faces if a bit differs everywhere.
        let soup = triangles.iter().flatten().map(|at| places[*at as usize]);
        let mut soup: Vec<DVec3> = soup.collect();
        let faces: Vec<[u32; 3]> = (0..4).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        assert_eq!(pieces(&soup, &faces).len(), 1);
        for (place, face) in soup.iter_mut().zip((0..12).map(|at| f64::from(at / 3))) {
            place.x += 1e-12 * face;
        }
        assert_eq!(pieces(&soup, &faces).len(), 4);
    }
}
