// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vertices numbered and triangles turned so that `gs-per-triangle` knows its outer walls.
//!
//! Its shader sees a triangle, not which of the sides lie on the boundary. A wall on the boundary
//! has to have the diagonal that every technique gives it, from the bottom of the edge's start to the
//! top of its end; one between two triangles has to have the same from both, and gets that of its
//! lower number. Both are one rule where every boundary edge ascends: so numbers run along the loops,
//! and a side that descends all the same, as one does where a loop closes, is put first in its
//! triangle. There the shader asks for no numbers. No side between two triangles gets there
//! descending, so that both still agree. All of it costs no byte.

use std::collections::HashSet;
use terrafill_core::{RegionMesh, index_u32};

/// Numberings tried until every wall is right: each mends one triangle at least, and meshes of files
/// hardly ever need a second.
const TRIES: usize = 16;

/// A mesh as `gs-per-triangle` stores it.
#[derive(Debug)]
pub(crate) struct RingOrder {
    /// The mesh's vertices in the order in which they are stored.
    pub(crate) vertices: Vec<u32>,
    /// By their places in that order; winding kept.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// A boundary edge, in the mesh's numbers, of each triangle in which two descend.
    unmended: Vec<[u32; 2]>,
}

impl RingOrder {
    pub(crate) fn new(mesh: &RegionMesh) -> Self {
        let outer = mesh
            .boundary_loops
            .iter()
            .flat_map(|ring| edges(ring))
            .collect();
        let mut loops = mesh.boundary_loops.clone();
        let mut best = Self::along(&loops, mesh, &outer);
        for _ in 0..TRIES {
            let Some(&edge) = best.unmended.first() else {
                break;
            };
            begin_with(&mut loops, edge);
            let found = Self::along(&loops, mesh, &outer);
            if found.unmended.len() >= best.unmended.len() {
                break;
            }
            best = found;
        }
        best
    }

    /// Numbers along `loops`, then inside. Vertices in several places keep their first number.
    fn along(loops: &[Vec<u32>], mesh: &RegionMesh, outer: &HashSet<[u32; 2]>) -> Self {
        let count = mesh.vertex_count();
        let mut is_stored = vec![false; count];
        let all = loops.iter().flatten().copied().chain(0..index_u32(count));
        let vertices: Vec<u32> = all
            .filter(|&vertex| !std::mem::replace(&mut is_stored[vertex as usize], true))
            .collect();
        let mut numbers = vec![0; count];
        for (number, &vertex) in (0..).zip(&vertices) {
            numbers[vertex as usize] = number;
        }
        let number = |vertex: u32| -> u32 { numbers[vertex as usize] };
        let mut unmended = Vec::new();
        let turned = mesh.triangles.iter().map(|&[a, b, c]| {
            let turns = [[a, b, c], [b, c, a], [c, a, b]];
            let ascends = |turn: &&[u32; 3]| number(turn[0]) < number(turn[1]);
            let needs_mending =
                |turn: &&[u32; 3]| !ascends(turn) && outer.contains(&[turn[0], turn[1]]);
            let mut descending = turns.iter().filter(needs_mending);
            let first = descending.next().or_else(|| turns.iter().find(ascends));
            // Sides in turn around a triangle: of two that descend, the one that the other leads to
            // is the one to begin a numbering with.
            unmended.extend(descending.next().map(|second| {
                let edge = first.filter(|first| first[0] == second[1]);
                let edge = edge.unwrap_or(second);
                [edge[0], edge[1]]
            }));
            first.copied().unwrap_or([a, b, c]).map(number)
        });
        let triangles = turned.collect();
        Self {
            vertices,
            triangles,
            unmended,
        }
    }
}

/// Walls of `mesh` that `gs-per-triangle` splits along the other diagonal than every technique does:
/// one for each triangle that has two boundary edges against the order of its vertices' numbers,
/// which takes loops that touch themselves or each other more than once at one triangle.
#[must_use]
pub fn walls_with_other_diagonal(mesh: &RegionMesh) -> usize {
    RingOrder::new(mesh).unmended.len()
}

/// Puts the loop with `edge` first and begins it there, so that the edge gets numbers 0 and 1.
fn begin_with(loops: &mut [Vec<u32>], edge: [u32; 2]) {
    let place_in = |ring: &Vec<u32>| edges(ring).position(|found| found == edge);
    let found = (0..)
        .zip(&*loops)
        .find_map(|(i, r)| Some((i, place_in(r)?)));
    if let Some((index, place)) = found {
        loops[index].rotate_left(place);
        loops[..=index].rotate_right(1);
    }
}

/// Directed edges of a loop.
fn edges(ring: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    let ends = ring.iter().skip(1).chain(ring.first());
    ring.iter().zip(ends).map(|(&a, &b)| [a, b])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};
    use terrafill_fixtures::by_hand;

    /// A mesh of which only the numbers matter.
    fn mesh(count: u32, boundary_loops: &[&[u32]], triangles: &[[u32; 3]]) -> RegionMesh {
        let loops = boundary_loops.iter().map(|ring| ring.to_vec()).collect();
        by_hand::mesh(by_hand::circle_deg(count, 1.0), triangles.to_vec(), loops)
    }

    /// Two rings of `count` vertices and the triangles between them, one more vertex in the first
    /// triangle, and numbers that descend along the first ring.
    fn annulus(count: u32) -> RegionMesh {
        let next = |i: u32| (i + 1) % count;
        let total = 2 * count + 1;
        // The total is odd, so that steps of two meet every number; they go down.
        let shuffled = |i: u32| (2 * (total - i) + 3) % total;
        let inside = 2 * count;
        let (a, b, c) = (0, 1, count);
        let mut triangles = vec![[a, b, inside], [b, c, inside], [c, a, inside]];
        for i in 0..count {
            if i > 0 {
                triangles.push([i, next(i), count + i]);
            }
            triangles.push([next(i), count + next(i), count + i]);
        }
        let outside: Vec<u32> = (0..count).map(shuffled).collect();
        let hole: Vec<u32> = (count..2 * count).rev().map(shuffled).collect();
        let triangles: Vec<_> = triangles.iter().map(|t| t.map(shuffled)).collect();
        mesh(total, &[&outside, &hole], &triangles)
    }

    fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
        [[a, b], [b, c], [c, a]]
    }

    /// Diagonals that `per_triangle.geom` gives each side of triangles by their stored numbers: from
    /// the bottom of the first to the top of the second.
    fn diagonals(triangles: &[[u32; 3]]) -> BTreeMap<[u32; 2], [u32; 2]> {
        let mut found = BTreeMap::new();
        for &triangle in triangles {
            for (place, [a, b]) in (0..).zip(sides(triangle)) {
                let is_forwards = place == 0 || a < b;
                let diagonal = if is_forwards { [a, b] } else { [b, a] };
                assert_eq!(found.insert([a, b], diagonal), None, "a side twice");
            }
        }
        found
    }

    /// Boundary edges not split from start to end, and inner ones on which two triangles disagree.
    fn wrong_walls(outer: &[[u32; 2]], triangles: &[[u32; 3]]) -> (usize, usize) {
        let found = diagonals(triangles);
        let is_wrong = |edge: &&[u32; 2]| found.get(*edge) != Some(*edge);
        let disagree = |(edge, diagonal): &(&[u32; 2], &[u32; 2])| {
            let other = found.get(&[edge[1], edge[0]]);
            !outer.contains(edge) && other != Some(diagonal)
        };
        let disagreeing = found.iter().filter(disagree).count();
        (outer.iter().filter(is_wrong).count(), disagreeing)
    }

    /// Boundary edges by stored numbers.
    fn stored_edges(mesh: &RegionMesh, order: &RingOrder) -> Vec<[u32; 2]> {
        let number = |vertex: u32| {
            let place = order.vertices.iter().position(|&found| found == vertex);
            u32::try_from(place.expect("stored")).expect("few vertices")
        };
        let rings = mesh.boundary_loops.iter();
        rings
            .flat_map(|ring| edges(ring))
            .map(|e| e.map(number))
            .collect()
    }

    #[test]
    fn outer_walls_run_along_the_boundary_and_inner_ones_agree() {
        for count in [3, 4, 5, 11, 40] {
            let mesh = annulus(count);
            let order = RingOrder::new(&mesh);
            let outer = stored_edges(&mesh, &order);
            assert_eq!(outer.len(), 2 * count as usize);
            assert_eq!(wrong_walls(&outer, &order.triangles), (0, 0), "{count}");
            assert_eq!(walls_with_other_diagonal(&mesh), 0, "{count}");
        }
        // Negative controls: numbers as they were, and triangles as they were.
        let mesh = annulus(11);
        let outer: Vec<_> = mesh.boundary_loops.iter().flat_map(|r| edges(r)).collect();
        assert!(wrong_walls(&outer, &mesh.triangles).0 > 0);
        let order = RingOrder::new(&mesh);
        let outer = stored_edges(&mesh, &order);
        let mut turned_on = order.triangles;
        for triangle in &mut turned_on {
            triangle.rotate_left(1);
        }
        let (boundary, inside) = wrong_walls(&outer, &turned_on);
        assert!(boundary > 0 && inside > 0, "{boundary} {inside}");
    }

    #[test]
    fn every_vertex_is_stored_once_and_every_triangle_turned_at_most() {
        let mesh = annulus(7);
        let order = RingOrder::new(&mesh);
        let stored: BTreeSet<u32> = order.vertices.iter().copied().collect();
        assert_eq!(stored, (0..15).collect());
        assert_eq!(order.vertices.len(), 15);
        for (stored, &triangle) in order.triangles.iter().zip(&mesh.triangles) {
            let found = stored.map(|number| order.vertices[number as usize]);
            let sides_of = |triangle| BTreeSet::from(sides(triangle));
            assert_eq!(sides_of(found), sides_of(triangle));
        }
    }

    #[test]
    fn a_loop_that_touches_itself_is_numbered_from_another_start() {
        // A hole y b x that touches the triangle z a y in y, both walked as one: in the ear
        // x → y → z two edges lead back.
        let (z, a, y, b, x) = (0, 1, 2, 3, 4);
        let ring = [z, a, y, b, x, y];
        let triangles = [[x, y, z], [z, a, x], [a, b, x], [a, y, b]];
        let mesh = mesh(5, &[&ring], &triangles);
        let outer: HashSet<_> = edges(&ring).collect();
        let first = RingOrder::along(&mesh.boundary_loops, &mesh, &outer);
        assert_eq!(first.unmended, [[y, z]]);
        assert_eq!(walls_with_other_diagonal(&mesh), 0);
        let order = RingOrder::new(&mesh);
        assert_eq!(order.vertices[..2], [y, z]);
        let outer = stored_edges(&mesh, &order);
        assert_eq!(wrong_walls(&outer, &order.triangles), (0, 0));
        // Negative control: as numbered at first.
        let outer = stored_edges(&mesh, &first);
        assert_eq!(wrong_walls(&outer, &first.triangles), (1, 0));
    }

    #[test]
    fn what_no_numbering_mends_is_counted() {
        // One triangle and the same from behind: whichever the numbers, two edges of one descend.
        let mesh = mesh(3, &[&[0, 1, 2, 0, 2, 1]], &[[0, 1, 2], [0, 2, 1]]);
        assert_eq!(walls_with_other_diagonal(&mesh), 1);
    }
}
