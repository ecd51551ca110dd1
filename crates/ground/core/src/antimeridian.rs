// SPDX-License-Identifier: MIT OR Apache-2.0
//! Crossings that lie on the antimeridian, where pieces of the crossing edges end.

use crate::edge::{Degrees, great_ellipse_crossing};
use crate::pieces::Piece;
use crate::{EdgeRule, Ring};
use terrafill_planar::intersection::{Crossing, edges_cross};

/// An edge where it is cut at the antimeridian, or one that runs along it.
///
/// Two edges that are cut at the same latitude are no longer seen to cross there, as their pieces
/// have that place for an end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AtAntimeridian {
    /// Where it is cut; of one that runs along the antimeridian, its ends from south to north.
    latitudes: [f64; 2],
    /// Of the whole edge as its file has it.
    ends: [Degrees; 2],
}

impl AtAntimeridian {
    /// Of the first of `pieces`, which may be cut from the second.
    pub(crate) fn of(ring: &Ring, pieces: &[Piece]) -> Option<Self> {
        let piece = pieces.first()?;
        if piece.end[0].abs() != 180.0 {
            return None;
        }
        let is_cut = |next: &Piece| {
            next.vertex == piece.vertex && next.start == [-piece.end[0], piece.end[1]]
        };
        // Poles are no longitude's.
        let latitudes = if piece.start[0] == piece.end[0] {
            let [a, b] = [piece.start[1], piece.end[1]];
            [a.min(b), a.max(b)]
        } else if pieces.get(1).is_some_and(is_cut) && piece.end[1].abs() < 90.0 {
            [piece.end[1]; 2]
        } else {
            return None;
        };
        let vertices = ring.vertices_deg();
        let end = vertices.get(piece.vertex + 1).copied().unwrap_or_else(|| {
            let first = vertices[0];
            [first[0] + ring.winding_deg(), first[1]]
        });
        Some(Self {
            // Adding zero turns −0 into 0, which sorts apart from it.
            latitudes: latitudes.map(|latitude| latitude + 0.0),
            ends: [vertices[piece.vertex], end],
        })
    }

    fn is_cut(&self) -> bool {
        self.latitudes[0] == self.latitudes[1]
    }
}

/// Crossings on the antimeridian, up to `most` of them: of two edges that are cut at one latitude,
/// or of one that is cut with one that runs along the antimeridian there.
pub(crate) fn crossings_at_antimeridian(
    rule: EdgeRule,
    edges: &[AtAntimeridian],
    most: usize,
) -> Vec<Crossing> {
    let mut cuts: Vec<(f64, usize)> = edges
        .iter()
        .enumerate()
        .filter(|(_, edge)| edge.is_cut())
        .map(|(index, edge)| (edge.latitudes[0], index))
        .collect();
    cuts.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let of_one_latitude = cuts.chunk_by(|a, b| a.0 == b.0).flat_map(|group| {
        let later = move |first: usize| {
            group[first + 1..]
                .iter()
                .map(move |cut| (group[first], *cut))
        };
        (0..group.len()).flat_map(later)
    });
    let cuts_from = |latitude: f64| cuts.partition_point(|cut| cut.0 < latitude);
    let along = || edges.iter().enumerate().filter(|(_, edge)| !edge.is_cut());
    // Both sides of a seam cancel: it is no border, and is crossed freely. Southern ends count.
    let mut is_border = vec![false; cuts.len() + 1];
    for (_, edge) in along() {
        for latitude in edge.latitudes {
            is_border[cuts_from(latitude)] ^= true;
        }
    }
    for cut in 1..is_border.len() {
        is_border[cut] ^= is_border[cut - 1];
    }
    let is_border = &is_border;
    let cuts = &cuts;
    let with_along = along().flat_map(|(index, edge)| {
        let [south, north] = edge.latitudes;
        let first = cuts.partition_point(|cut| cut.0 <= south);
        let within = (first..cuts_from(north)).filter(|cut| is_border[*cut]);
        within.map(move |cut| (cuts[cut], (cuts[cut].0, index)))
    });
    let crosses = |a: [Degrees; 2], b: [Degrees; 2]| match rule {
        EdgeRule::Planar => edges_cross(a, b),
        EdgeRule::GreatEllipse => great_ellipse_crossing(a, b).is_some(),
    };
    of_one_latitude
        .chain(with_along)
        .filter(|((_, a), (_, b))| crosses(edges[*a].ends, edges[*b].ends))
        .map(|((latitude, a), (_, b))| ([a.min(b), a.max(b)], [180.0, latitude]))
        .take(most)
        .collect()
}
