// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a region's boundary lies, piece by piece: a level of detail is chosen by what of it a view shows.
//!
//! One box around a large region reaches from its nearest place to the farthest from the image's centre. A
//! pixel there would seem worth less than it is anywhere. And a boundary that lies outside the image may
//! move as it likes, as long as it does not move into it.

use crate::parts::{box_on_body, grown};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use terrafill_core::{Ellipsoid, OrientedBox, RegionMesh};

/// Pieces of a region at most, so that planning stays cheap.
const MOST_PIECES: usize = 32;
/// Edges of a piece on average at least.
const FEWEST_EDGES: usize = 16;

/// Boxes that together hold a mesh's boundary on the ellipsoid, and what its chords leave out.
pub(crate) fn boundary_pieces(body: &Ellipsoid, mesh: &RegionMesh) -> Vec<OrientedBox> {
    let places = &mesh.vertices_ecef;
    let whole = Piece::new(mesh.boundary_edges().collect(), places);
    let most = (whole.edges.len() / FEWEST_EDGES).clamp(1, MOST_PIECES);
    let mut pieces = BinaryHeap::from([whole]);
    while pieces.len() < most
        && let Some(widest) = pieces.pop()
    {
        let Some(halves) = widest.halves(places) else {
            pieces.push(widest);
            break;
        };
        pieces.extend(halves);
    }
    let around = |piece: Piece| {
        let own = box_on_body(body, mesh, piece.edges.into_flattened());
        grown(&own, mesh.boundary_deviation_m)
    };
    let pieces = pieces.into_sorted_vec().into_iter();
    let some = pieces.filter(|piece| !piece.edges.is_empty());
    some.map(around).collect()
}

/// Edges, by how wide the box of their starts is: the widest is the greatest.
#[derive(Debug)]
struct Piece {
    edges: Vec<[u32; 2]>,
    low: DVec3,
    high: DVec3,
}

impl Piece {
    fn new(edges: Vec<[u32; 2]>, places: &[DVec3]) -> Self {
        let starts = edges.iter().map(|edge| places[edge[0] as usize]);
        let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = starts.fold(nowhere, |(low, high), at| (low.min(at), high.max(at)));
        Self { edges, low, high }
    }

    fn width_m(&self) -> f64 {
        (self.high - self.low).max_element()
    }

    /// In the middle of where it is widest; `None` where all edges start at one place.
    fn halves(&self, places: &[DVec3]) -> Option<[Self; 2]> {
        let axis = (self.high - self.low).max_position();
        let middle = 0.5 * (self.low + self.high)[axis];
        let is_below = |edge: &[u32; 2]| places[edge[0] as usize][axis] < middle;
        let (below, above): (Vec<_>, Vec<_>) = self.edges.iter().partition(|edge| is_below(edge));
        (!below.is_empty() && !above.is_empty())
            .then(|| [below, above].map(|edges| Self::new(edges, places)))
    }
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Piece {}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Piece {
    /// Pieces of one mesh never have an edge in common, so that there is one order only.
    fn cmp(&self, other: &Self) -> Ordering {
        let by_width = self.width_m().total_cmp(&other.width_m());
        by_width.then_with(|| other.edges.cmp(&self.edges))
    }
}

/// A piece of a boundary, as a view sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SeenPiece {
    /// Nothing there that moves by this much on the body moves by more than a pixel on the screen, metres; 0
    /// where it may be at the eye.
    pub(crate) pixel_m: f64,
    /// Nothing there that moves by less than this comes into the image, metres; 0 where it may be in it.
    pub(crate) outside_m: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parts::tests::strip;

    #[test]
    fn every_edge_lies_in_a_piece_and_pieces_are_few() {
        for squares in [3, 30, 5_000] {
            let mesh = strip(squares);
            let pieces = boundary_pieces(&Ellipsoid::WGS84, &mesh);
            assert!(pieces.len() <= MOST_PIECES, "{}", pieces.len());
            assert_eq!(pieces.len() > 1, squares > 10, "{squares}");
            let is_in = |piece: &OrientedBox, vertex: u32| {
                let place = mesh.vertices_ecef[vertex as usize] - piece.center_ecef;
                let local = piece.axes.transpose() * place;
                local.abs().cmple(piece.half_extents_m + 1e-3).all()
            };
            let all_held = |pieces: &[OrientedBox]| {
                let mut rings = mesh.boundary_loops.iter();
                rings.all(|ring| {
                    let mut edges = ring.iter().zip(ring.iter().cycle().skip(1));
                    edges.all(|(&from, &to)| {
                        pieces
                            .iter()
                            .any(|piece| is_in(piece, from) && is_in(piece, to))
                    })
                })
            };
            assert!(all_held(&pieces), "{squares}");
            // Negative control: without one of them some edge is in none.
            assert!(!all_held(&pieces[1..]), "{squares}");
            let largest = pieces
                .iter()
                .map(|piece| piece.half_extents_m.max_element());
            let largest_m = largest.fold(0.0, f64::max);
            assert!(squares < 5_000 || largest_m < 1e6, "{largest_m}");
        }
    }
}
