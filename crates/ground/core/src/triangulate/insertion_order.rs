// SPDX-License-Identifier: MIT OR Apache-2.0
//! In which order an outline's corners and edges are inserted.

use crate::edge::Degrees;
use crate::pieces::OutlineEdge;
use terrafill_planar::index_u32;
use terrafill_planar::intersection::without_underflow;

/// Edges below which they are put in order by comparing them.
const COUNTED_FROM: usize = 64;
/// Vertices to an edge above which edges are put in order by comparing them.
const COUNTED_FROM_SHARE: usize = 16;

/// The corners of an outline, and when each is to be inserted.
///
/// First a random one in 4¹⁵, then four times as many, and so on, in every round in the order of the
/// outline, and edges as soon as both their ends are there. Random rounds keep the number of flips
/// proportional to the number of corners, whatever the shape. The outline's order makes the next
/// corner a neighbour of the last one, where the search for its place starts (Amenta, Choi & Rote
/// 2003, "Incremental constructions con BRIO"). Loading all at once from the middle outwards takes
/// the square of the number for a comb. A line of many corners is there long before the next one,
/// and each corner of that takes its neighbours from all those before it. So do edges that are
/// inserted last, where they cross many triangles.
pub(super) struct Corners {
    /// An outline's neighbours once, so a corner that several rings share occurs several times.
    pub(super) positions: Vec<Degrees>,
    /// By number of the corner.
    ends: Vec<[u32; 2]>,
    /// Round of each corner.
    round: Vec<u8>,
}

/// Rounds of insertion; each has about four times as many corners as the one before.
const ROUNDS: u8 = 16;

impl Corners {
    pub(super) fn new(edges: &[OutlineEdge]) -> Self {
        let mut positions: Vec<Degrees> = Vec::with_capacity(edges.len());
        let mut ends = Vec::with_capacity(edges.len());
        // Where the run of edges that follow one another began, and where it has come to.
        let (mut first, mut last) = (0, 0);
        for edge in edges {
            let [start, end] = [edge.start, edge.end].map(|end| end.map(without_underflow));
            if positions.is_empty() || positions[last] != start {
                first = positions.len();
                last = first;
                positions.push(start);
            }
            let from = last;
            if positions[first] == end {
                last = first;
            } else {
                last = positions.len();
                positions.push(end);
            }
            ends.push([from, last].map(index_u32));
        }
        let round = positions.iter().map(|position| round(*position)).collect();
        Self {
            positions,
            ends,
            round,
        }
    }

    /// For each round the corners that are new in it, and the edges that then have both ends.
    pub(super) fn rounds(
        &self,
    ) -> impl Iterator<Item = (Vec<u32>, impl Iterator<Item = [u32; 2]> + '_)> + '_ {
        let mut corners: [Vec<u32>; ROUNDS as usize] = Default::default();
        for (corner, round) in (0..).zip(&self.round) {
            corners[usize::from(*round)].push(corner);
        }
        let mut edges: [Vec<u32>; ROUNDS as usize] = Default::default();
        for (edge, ends) in (0..).zip(&self.ends) {
            let [from, to] = ends.map(|i| self.round[i as usize]);
            edges[usize::from(from.max(to))].push(edge);
        }
        corners.into_iter().zip(edges).map(|(corners, edges)| {
            let ends = edges.into_iter().map(|edge| self.ends[edge as usize]);
            (corners, ends)
        })
    }
}

/// The same for equal positions, so that edges with the same ends are inserted in the same round.
fn round(position: Degrees) -> u8 {
    // Two rounds of multiply and shift: enough to make the last bits depend on all.
    let [x, y] = position.map(f64::to_bits);
    let mut mixed = x.rotate_left(32) ^ y;
    for _ in 0..2 {
        mixed = mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^= mixed >> 32;
    }
    let earlier = mixed.trailing_zeros() / 2;
    (ROUNDS - 1).saturating_sub(u8::try_from(earlier).unwrap_or(u8::MAX))
}

/// Edges that occur an odd number of times, whichever way they run, in order.
pub(super) fn odd_edges(ends: impl Iterator<Item = [u32; 2]>, vertices: usize) -> Vec<[u32; 2]> {
    let lower_first: Vec<[u32; 2]> = ends
        .filter(|[a, b]| a != b)
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    let mut odd = in_order(lower_first, vertices);
    // Hardly any edge occurs twice: what stays is moved within the list.
    let (mut kept, mut next) = (0, 0);
    while let Some(edge) = odd.get(next).copied() {
        let same = odd[next..]
            .iter()
            .take_while(|other| **other == edge)
            .count();
        if same % 2 == 1 {
            odd[kept] = edge;
            kept += 1;
        }
        next += same;
    }
    odd.truncate(kept);
    odd
}

/// Edges in order of their first ends, of which there are so many, and then of their second ones.
///
/// By counting: few edges start at the same vertex, and comparing takes n log n, the growth of which
/// is seen from a hundred thousand to a million.
pub(super) fn in_order(mut edges: Vec<[u32; 2]>, vertices: usize) -> Vec<[u32; 2]> {
    // To count what hardly occurs costs more than to compare, and a list of a few edges, of which
    // islands have one for each round, is not worth its memory.
    if edges.len() < COUNTED_FROM.max(vertices / COUNTED_FROM_SHARE) {
        edges.sort_unstable();
        return edges;
    }
    // Of each vertex, where its next edge goes; at first where those of the one before end.
    let mut places = vec![0_u32; vertices + 1];
    for [from, _] in &edges {
        places[*from as usize + 1] += 1;
    }
    let mut total = 0;
    for place in &mut places {
        total += *place;
        *place = total;
    }
    let mut sorted = vec![[0; 2]; edges.len()];
    for edge in edges {
        let place = &mut places[edge[0] as usize];
        sorted[*place as usize] = edge;
        *place += 1;
    }
    for same_start in sorted.chunk_by_mut(|a, b| a[0] == b[0]) {
        if same_start.len() > 1 {
            same_start.sort_unstable();
        }
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_put_in_order_as_by_comparing_them() {
        let mut state = 5_u64;
        let mut random = |below: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            u32::try_from((state >> 33) % below).expect("small")
        };
        for (count, vertices) in [
            (0, 1_usize),
            (1, 1),
            (5, 900),
            (300, 900),
            (2_000, 40),
            (900, 900),
        ] {
            let edges: Vec<[u32; 2]> = (0..count)
                .map(|_| [random(vertices as u64), random(7)])
                .collect();
            let mut expected = edges.clone();
            expected.sort_unstable();
            let found = in_order(edges.clone(), vertices);
            assert_eq!(found, expected, "{count} of {vertices}");
            // Negative control: as they come they are not in order.
            assert!(count < 5 || edges != expected);
            let parity = |edge: &&[u32; 2]| expected.iter().filter(|e| e == edge).count() % 2 == 1;
            let mut once: Vec<[u32; 2]> = expected.iter().filter(parity).copied().collect();
            once.retain(|[a, b]| a < b);
            once.dedup();
            let forward = edges.into_iter().filter(|[a, b]| a < b);
            assert_eq!(odd_edges(forward, vertices), once);
        }
        assert_eq!(
            odd_edges([[1, 0], [0, 1], [2, 2], [0, 2]].into_iter(), 3),
            [[0, 2]]
        );
    }
}
