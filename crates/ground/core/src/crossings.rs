// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rings that cross themselves or one another: finding the crossings, and making them vertices.
//!
//! Degrees for planar edges, unit normals for great ellipses. A crossing that is a vertex of both
//! edges is no crossing any more but a touch, which the even-odd rule fills without ambiguity.
//! Real files need this: at 1:110m a vertex of Sudan's outline that was meant to lie on another of
//! its edges lies 5.7e-14° (6 nm) beyond it, and by exact arithmetic that is a crossing.
//!
//! Candidates come from a tree over the edges' boxes: O(n log n + pairs whose boxes overlap).

use crate::box_tree::{AxisBox, BoxTree};
use crate::edge::{Degrees, normal};
use crate::outline::{OutlineEdge, Piece, edges_cross, or_at_pole, planar_pieces};
use crate::triangulate::without_underflow;
use crate::{EdgePlace, EdgeRule, Polygon, Region, Ring};
use glam::DVec3;
use std::ops::ControlFlow;

/// Rounds after which the search gives up: a crossing is rounded to the nearest number, which can
/// bend an edge over another one close by, but only by the last bit. What is left of them then is
/// taken away by `snap` where the region is meshed.
pub(crate) const MOST_ROUNDS: usize = 8;

/// Crossings to those of an earlier round from which on there is no end of them.
const MOST_GROWTH: usize = 2;

impl Region {
    /// Makes a vertex of every place where two edges cross, so that the region can be meshed and is
    /// filled by the even-odd rule; returns how many there were and notes them in
    /// [`Region::warnings`]. Parts that overlap without crossing are filled by that rule as well:
    /// the mesh notes them, which finds them.
    ///
    /// Edges are compared where they lie on the body, whichever turn they were written in.
    pub fn split_at_crossings(&mut self, rule: EdgeRule) -> usize {
        let mut total = 0;
        self.repaired = true;
        let mut fewest = usize::MAX;
        for _ in 0..MOST_ROUNDS {
            let found = self.split_once(rule);
            total += found;
            // Edges that are one to rounding cross more often with every place that they are split at.
            if found == 0 || found > fewest.saturating_mul(MOST_GROWTH) {
                break;
            }
            fewest = fewest.min(found);
        }
        if total > 0 {
            let plural = if total == 1 { "" } else { "s" };
            self.warnings.push(format!(
                "{total} crossing{plural} of edges: filled by the even-odd rule"
            ));
        }
        total
    }

    fn split_once(&mut self, rule: EdgeRule) -> usize {
        let FoundCrossings {
            pieces,
            crossings,
            edges,
            at_cuts,
        } = self.find_crossings(rule, usize::MAX);
        if crossings.is_empty() && at_cuts.is_empty() {
            return 0;
        }
        let several_turns = pieces.iter().any(|piece| piece.piece.turns != 0.0);
        let mut inserted: Vec<Vec<Insertion>> = self.rings().map(|_| Vec::new()).collect();
        for (pair, at) in &crossings {
            let at = if several_turns {
                [round_for_turning(at[0]), at[1]]
            } else {
                *at
            };
            for &index in pair {
                let RingPiece { ring, piece } = &pieces[index];
                let start = piece_as_written(piece, piece.start);
                let along = Along {
                    piece: index,
                    distance: distance(rule, start, piece_as_written(piece, at)),
                };
                inserted[*ring].push((piece.vertex, along, piece_as_written(piece, at)));
            }
        }
        for &(pair, [_, latitude]) in &at_cuts {
            for index in pair.map(|index| edges[index]) {
                let RingPiece { ring, piece } = &pieces[index];
                // The end of a piece that is cut there; a place on one that runs along it.
                let at = [piece.end[0], latitude];
                let along = Along {
                    piece: index,
                    distance: distance(rule, piece.start, at),
                };
                inserted[*ring].push((piece.vertex, along, piece_as_written(piece, at)));
            }
        }
        keep_cuts(&pieces, &mut inserted);
        let rings = self
            .polygons
            .iter_mut()
            .flat_map(|polygon| std::iter::once(&mut polygon.shell).chain(&mut polygon.holes));
        for (ring, mut insertions) in rings.zip(inserted) {
            if !insertions.is_empty() {
                insertions.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.cmp(&b.1)));
                *ring = with_insertions(ring, &insertions);
            }
        }
        crossings.len() + at_cuts.len()
    }

    /// Whether any two edges cross, compared where they lie on the body.
    pub(crate) fn has_crossings(&self, rule: EdgeRule) -> bool {
        let found = self.find_crossings(rule, 1);
        !(found.crossings.is_empty() && found.at_cuts.is_empty())
    }

    /// Up to `most` places where arcs cross, as the file has its edges.
    pub(crate) fn arc_crossings(&self, most: usize) -> Vec<CrossingPlaces> {
        let rings_of = |(index, polygon): (usize, &Polygon)| {
            (0..polygon.rings().count()).map(move |ring| (index, ring))
        };
        let rings: Vec<(usize, usize)> = self
            .polygons
            .iter()
            .enumerate()
            .flat_map(rings_of)
            .collect();
        let found = self.find_crossings(EdgeRule::GreatEllipse, most);
        let place = |index: usize| {
            let RingPiece { ring, piece } = &found.pieces[index];
            let (polygon, ring) = rings[*ring];
            let vertex = piece.vertex;
            EdgePlace {
                polygon,
                ring,
                vertex,
            }
        };
        let places = found.crossings.iter().map(|(pair, at)| {
            let [a, b] = pair.map(place);
            CrossingPlaces::of([a, b], *at)
        });
        places.collect()
    }

    /// Up to `most` of those between cuts and as many of those on the antimeridian.
    fn find_crossings(&self, rule: EdgeRule, most: usize) -> FoundCrossings {
        let pieces: Vec<RingPiece> = self
            .rings()
            .enumerate()
            .flat_map(|(ring, found)| {
                let pieces = pieces_as_compared(rule, found);
                pieces
                    .into_iter()
                    .map(move |piece| RingPiece { ring, piece })
            })
            .collect();
        let ends: Vec<[Degrees; 2]> = pieces.iter().map(RingPiece::ends).collect();
        let (crossings, _) = find_crossings(rule, &ends, most);
        let (edges, at_antimeridian) = self.at_antimeridian(rule, &pieces);
        let at_cuts = crossings_at_antimeridian(rule, &at_antimeridian, most);
        FoundCrossings {
            pieces,
            crossings,
            edges,
            at_cuts,
        }
    }

    /// Pieces that end in a cut at the antimeridian or run along it, by their position too.
    fn at_antimeridian(
        &self,
        rule: EdgeRule,
        pieces: &[RingPiece],
    ) -> (Vec<usize>, Vec<AtAntimeridian>) {
        if rule == EdgeRule::GreatEllipse {
            // Whole arcs are compared.
            return (Vec::new(), Vec::new());
        }
        let rings: Vec<&Ring> = self.rings().collect();
        let of_piece = |index: usize| {
            let RingPiece { ring, piece } = &pieces[index];
            let next = pieces.get(index + 1).filter(|next| next.ring == *ring);
            let next = next.map_or(*piece, |next| next.piece);
            AtAntimeridian::of(rings[*ring], &[*piece, next]).map(|found| (index, found))
        };
        (0..pieces.len()).filter_map(of_piece).unzip()
    }
}

/// Crossings of a region's edges.
struct FoundCrossings {
    pieces: Vec<RingPiece>,
    /// Of two pieces.
    crossings: Vec<Crossing>,
    /// Pieces that are cut at the antimeridian or run along it.
    edges: Vec<usize>,
    /// Of two of those, on the antimeridian.
    at_cuts: Vec<Crossing>,
}

/// Part of a ring between two cuts at the antimeridian.
struct RingPiece {
    ring: usize,
    piece: Piece,
}

impl RingPiece {
    fn ends(&self) -> [Degrees; 2] {
        [self.piece.start, self.piece.end]
    }
}

/// Pieces of a ring as they lie on the body, in order.
pub(crate) fn pieces_as_compared(rule: EdgeRule, ring: &Ring) -> Vec<Piece> {
    match rule {
        EdgeRule::Planar => planar_pieces(ring),
        // Arcs are compared by their normals, for which all turns are one.
        EdgeRule::GreatEllipse => (0..ring.vertices_deg().len())
            .map(|vertex| Piece {
                start: as_written(ring, vertex),
                end: as_written(ring, (vertex + 1) % ring.vertices_deg().len()),
                vertex,
                turns: 0.0,
            })
            .collect(),
    }
}

fn as_written(ring: &Ring, vertex: usize) -> Degrees {
    let [_, latitude] = ring.vertices_deg()[vertex];
    [ring.written_longitude_deg(vertex), or_at_pole(latitude)]
}

/// A place on a piece as its file would write it.
fn piece_as_written(piece: &Piece, [longitude, latitude]: Degrees) -> Degrees {
    [longitude + 360.0 * piece.turns, latitude]
}

/// To the nearest multiple of 2⁻⁴³ degrees (12 nm on the Earth): the last place of numbers up to
/// 1,024, so that whole turns can be added and taken away without rounding.
fn round_for_turning(longitude_deg: f64) -> f64 {
    let unit = 1.0 / (1_u64 << 43) as f64;
    (longitude_deg / unit).round() * unit
}

/// Makes vertices of the places where edges that get new vertices were cut at the antimeridian: cut
/// again from a new vertex, they would be cut a rounding away, and could cross again.
fn keep_cuts(pieces: &[RingPiece], inserted: &mut [Vec<Insertion>]) {
    let mut split: Vec<(usize, usize)> = inserted
        .iter()
        .enumerate()
        .flat_map(|(ring, new)| new.iter().map(move |insertion| (ring, insertion.0)))
        .collect();
    split.sort_unstable();
    for (index, pair) in pieces.windows(2).enumerate() {
        let [before, after] = pair else { continue };
        let edge = (before.ring, before.piece.vertex);
        let is_cut = edge == (after.ring, after.piece.vertex);
        if is_cut && split.binary_search(&edge).is_ok() {
            let along = Along {
                piece: index,
                distance: f64::INFINITY,
            };
            let at = piece_as_written(&before.piece, before.piece.end);
            inserted[edge.0].push((edge.1, along, at));
        }
    }
}

/// How far along its edge a new vertex lies.
#[derive(Debug, Clone, Copy)]
struct Along {
    /// Pieces of an edge have growing numbers.
    piece: usize,
    /// From the piece's start.
    distance: f64,
}

impl Along {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let by_piece = self.piece.cmp(&other.piece);
        by_piece.then(self.distance.total_cmp(&other.distance))
    }
}

/// Vertex that the edge starts at, how far along it, position.
type Insertion = (usize, Along, Degrees);

fn with_insertions(ring: &Ring, insertions: &[Insertion]) -> Ring {
    let mut waiting = insertions.iter().peekable();
    // With their longitudes as the file has them.
    let mut vertices: Vec<(Degrees, f64)> =
        Vec::with_capacity(ring.vertices_deg().len() + insertions.len());
    for (vertex, start) in ring.vertices_deg().iter().enumerate() {
        vertices.push((*start, ring.written_longitude_deg(vertex)));
        while let Some((_, _, at)) = waiting.next_if(|insertion| insertion.0 == vertex) {
            vertices.push((*at, at[0]));
        }
    }
    // Rounding may put a crossing on the end of its edge.
    vertices.dedup_by_key(|(position, _)| *position);
    let winding_deg = ring.winding_deg();
    let ([west, first_latitude], _) = vertices[0];
    while vertices.len() > 1
        && vertices[vertices.len() - 1].0 == [west + winding_deg, first_latitude]
    {
        vertices.pop();
    }
    let (vertices, written) = vertices.into_iter().unzip();
    Ring::from_checked(vertices, winding_deg).with_written_longitudes(written)
}

/// A box that holds the edge, in degrees or in unit normals.
fn box_of(rule: EdgeRule, [start, end]: [Degrees; 2]) -> AxisBox {
    let (a, b, bulge) = match rule {
        EdgeRule::Planar => {
            let point = |[x, y]: Degrees| DVec3::new(x, y, 0.0);
            (point(start), point(end), 0.0)
        }
        EdgeRule::GreatEllipse => {
            let (a, b) = (normal(start), normal(end));
            // An arc of chord c rises 1 − √(1 − c²/4) ≤ c²/4 above it.
            (a, b, 0.25 * (b - a).length_squared())
        }
    };
    AxisBox {
        low: a.min(b) - bulge,
        high: a.max(b) + bulge,
    }
}

/// Two edges, by index, the lower first, and where they cross.
pub(crate) type Crossing = ([usize; 2], Degrees);

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

/// Crossings in order of their edges, and whether these are all: the search ends at `most`.
pub(crate) fn find_crossings(
    rule: EdgeRule,
    edges: &[[Degrees; 2]],
    most: usize,
) -> (Vec<Crossing>, bool) {
    let boxes: Vec<AxisBox> = edges.iter().map(|ends| box_of(rule, *ends)).collect();
    let mut found: Vec<Crossing> = Vec::new();
    let end = BoxTree::new(&boxes).overlapping_pairs(&mut |a, b| {
        let crossing = match rule {
            EdgeRule::Planar => planar_crossing(edges[a], edges[b]),
            EdgeRule::GreatEllipse => great_ellipse_crossing(edges[a], edges[b]),
        };
        let Some(at) = crossing else {
            return ControlFlow::Continue(());
        };
        if found.len() == most {
            return ControlFlow::Break(());
        }
        found.push(([a, b], at));
        ControlFlow::Continue(())
    });
    found.sort_unstable_by_key(|crossing| crossing.0);
    (found, end.is_continue())
}

/// Splits straight edges where they cross.
///
/// Rounding can leave new crossings, so the caller tries again until there are none.
pub(crate) fn split_outline(edges: &[OutlineEdge], crossings: &[Crossing]) -> Vec<OutlineEdge> {
    let mut insertions: Vec<(usize, f64, Degrees)> = Vec::with_capacity(2 * crossings.len());
    for &(pair, at) in crossings {
        for index in pair {
            let along = distance(EdgeRule::Planar, edges[index].start, at);
            insertions.push((index, along, at));
        }
    }
    split_at(edges, insertions)
}

/// Splits edges at places: index of the edge, how far along it, place.
pub(crate) fn split_at(
    edges: &[OutlineEdge],
    mut insertions: Vec<(usize, f64, Degrees)>,
) -> Vec<OutlineEdge> {
    insertions.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    insertions.dedup();
    let mut waiting = insertions.iter().peekable();
    let mut split = Vec::with_capacity(edges.len() + insertions.len());
    for (index, edge) in edges.iter().enumerate() {
        let mut rest = *edge;
        while let Some((_, _, at)) = waiting.next_if(|insertion| insertion.0 == index) {
            split.push(OutlineEdge { end: *at, ..rest });
            rest.start = *at;
        }
        split.push(rest);
    }
    split
}

/// Two ring edges that cross, the first of them in the file first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CrossingPlaces {
    pub(crate) first: EdgePlace,
    pub(crate) second: EdgePlace,
    pub(crate) at: Degrees,
}

impl CrossingPlaces {
    pub(crate) fn of([a, b]: [EdgePlace; 2], at: Degrees) -> Self {
        Self {
            first: a.min(b),
            second: a.max(b),
            at,
        }
    }
}

/// Crossings of ring edges, by those of the outline's edges that are parts of them.
pub(crate) fn crossing_places(
    edges: &[OutlineEdge],
    crossings: &[Crossing],
) -> Vec<CrossingPlaces> {
    let mut places: Vec<CrossingPlaces> = crossings
        .iter()
        .map(|&(pair, at)| {
            let [a, b] = pair.map(|index| edges[index].place);
            CrossingPlaces::of([a, b], at)
        })
        .collect();
    places.sort_by_key(|crossing| (crossing.first, crossing.second));
    // Rounding can bend neighbouring parts of one edge over the same other edge.
    places.dedup_by_key(|crossing| (crossing.first, crossing.second));
    places
}

/// Where two straight edges cross, each strictly between its ends. The decision is exact.
///
/// Rounded, but into the box of either edge: a repair makes a vertex of it, which must not lie
/// beyond a pole.
pub(crate) fn planar_crossing(a: [Degrees; 2], b: [Degrees; 2]) -> Option<Degrees> {
    let [a, b] = [a, b].map(|ends| ends.map(|end| end.map(without_underflow)));
    let coord = |[x, y]: Degrees| robust::Coord { x, y };
    // Only the signs are exact. Their sizes, which say where, have the rounding of differences from the
    // third place: from an end of the edge itself they are as good as the edge is short.
    let side = |[p, q]: [Degrees; 2], r| robust::orient2d(coord(q), coord(r), coord(p));
    let (a0, a1) = (side(b, a[0]), side(b, a[1]));
    let (b0, b1) = (side(a, b[0]), side(a, b[1]));
    (opposite(a0, a1) && opposite(b0, b1)).then(|| {
        let along = a0 / (a0 - a1);
        [0, 1].map(|i| {
            let low = a[0][i].min(a[1][i]).max(b[0][i].min(b[1][i]));
            let high = a[0][i].max(a[1][i]).min(b[0][i].max(b[1][i]));
            (a[0][i] + (a[1][i] - a[0][i]) * along).max(low).min(high)
        })
    })
}

/// Where two arcs cross, each strictly between its ends and by more than rounding can feign.
pub(crate) fn great_ellipse_crossing(a: [Degrees; 2], b: [Degrees; 2]) -> Option<Degrees> {
    let (a, b) = (a.map(normal), b.map(normal));
    let off_b = a.map(|end| certain_side(b, end));
    let apart =
        opposite(off_b[0], off_b[1]) && opposite(certain_side(a, b[0]), certain_side(a, b[1]));
    if !apart {
        return None;
    }
    // Between the ends of one arc as they lie off the other. The line in which the planes meet is the
    // same, but the product of normals that hardly differ is off both planes by its rounding: metres
    // on the Earth.
    let point = a[0] * off_b[1].abs() + a[1] * off_b[0].abs();
    // The planes also meet on the far side of the body.
    (point.dot(b[0] + b[1]) > 0.0).then(|| {
        [
            point.y.atan2(point.x).to_degrees(),
            point.z.atan2(point.x.hypot(point.y)).to_degrees(),
        ]
    })
}

/// Side of the plane through the centre and an arc that a point lies on: positive to the left, 0
/// where moving the three unit vectors by their rounding could change the answer.
fn certain_side([from, to]: [DVec3; 2], point: DVec3) -> f64 {
    // Differences before products: the products of the unit vectors themselves would lose what
    // tells neighbours apart.
    let (along, beside) = (to - from, point - from);
    let volume = from.cross(along).dot(beside);
    let uncertain = 8.0 * f64::EPSILON * (along.length() + beside.length());
    if volume.abs() > uncertain {
        volume
    } else {
        0.0
    }
}

fn opposite(a: f64, b: f64) -> bool {
    a > 0.0 && b < 0.0 || a < 0.0 && b > 0.0
}

fn distance(rule: EdgeRule, a: Degrees, b: Degrees) -> f64 {
    match rule {
        EdgeRule::Planar => (b[0] - a[0]).hypot(b[1] - a[1]),
        EdgeRule::GreatEllipse => (normal(b) - normal(a)).length(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ellipsoid, MeshError, MeshOptions, RegionMesh};

    fn region(rings: &[&[Degrees]]) -> Region {
        let polygons = rings
            .iter()
            .map(|ring| Polygon {
                shell: Ring::from_checked(ring.to_vec(), 0.0),
                holes: Vec::new(),
            })
            .collect();
        Region {
            index: 0,
            name: "test".to_owned(),
            polygons,
            warnings: Vec::new(),
            repaired: false,
        }
    }

    fn build(region: &Region, rule: EdgeRule) -> Result<RegionMesh, MeshError> {
        let body = Ellipsoid::WGS84;
        let mesh = RegionMesh::build(region, &body, rule, &MeshOptions::default())?;
        assert_eq!(mesh.check_invariants(&body), Ok(()));
        Ok(mesh)
    }

    /// From 0 up to 1, the same for the same seed.
    fn random_numbers(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// Sine of the angle at which a place is off the plane of an arc.
    fn off(arc: [Degrees; 2], place: Degrees) -> f64 {
        let [from, to] = arc.map(normal);
        let plane = from.cross(to - from).normalize();
        plane.dot(normal(place) - from).abs()
    }

    #[test]
    fn a_crossing_of_arcs_that_hardly_differ_is_on_both() {
        let mut off_by_planes = 0.0_f64;
        for apart_deg in [1e-1, 1e-5, 1e-9, 1e-11] {
            let a = [[10.0, -33.0], [100.0, 41.0]];
            let b = [[10.0, -33.0 - apart_deg], [100.0, 41.0 + apart_deg]];
            let at = great_ellipse_crossing(a, b).expect("cross");
            for arc in [a, b] {
                assert!(off(arc, at) < 1e-15, "{apart_deg}: {}", off(arc, at));
            }
            // Twin: as the line in which the planes meet.
            let [m, n] = [a, b]
                .map(|arc| arc.map(normal))
                .map(|[p, q]| p.cross(q - p));
            let line = m.cross(n).normalize();
            let place = [line.y.atan2(line.x), line.z.atan2(line.x.hypot(line.y))];
            off_by_planes = off_by_planes.max(off(a, place.map(f64::to_degrees)));
        }
        assert!(off_by_planes > 1e-8, "{off_by_planes}");
    }

    /// From the find `a_crossing_told_half_a_millimetre_off_its_edge`: a long edge, the tiny edge of a
    /// sliver over it, and the ends of another. Coordinates are those of the file.
    #[test]
    fn a_crossing_of_a_long_edge_and_a_tiny_one_is_on_both() {
        let long = [
            [-132.40000055, 51.07631785420905],
            [-179.95000065, 60.1000007],
        ];
        let tiny = [
            [-156.175000575, 55.58815932710453],
            [-156.1750006, 55.58815927710452],
        ];
        let off = |[from, to]: [Degrees; 2], [x, y]: Degrees| {
            let along = [to[0] - from[0], to[1] - from[1]];
            let product = along[0] * (y - from[1]) - along[1] * (x - from[0]);
            (product / along[0].hypot(along[1])).abs()
        };
        for (a, b) in [(long, tiny), (tiny, long)] {
            let at = planar_crossing(a, b).expect("cross");
            assert!(off(long, at) < 5e-14 && off(tiny, at) < 5e-14, "{at:?}");
        }
        // Twin: the sides of the long edge's ends as seen from these ends.
        let coord = |[x, y]: Degrees| robust::Coord { x, y };
        let side = |r| robust::orient2d(coord(tiny[0]), coord(tiny[1]), coord(r));
        let (from, to) = (side(long[0]), side(long[1]));
        let share = from / (from - to);
        let at = [0, 1].map(|i| long[0][i] + (long[1][i] - long[0][i]) * share);
        assert!(off(tiny, at) > 1e-8, "{at:?}");
    }

    #[test]
    fn a_pentagram_is_refused_and_repaired_to_its_five_points() {
        let star: Vec<Degrees> = (0..5)
            .map(|k| {
                let angle = std::f64::consts::TAU * f64::from(2 * k) / 5.0;
                [10.0 + angle.cos(), 5.0 + angle.sin()]
            })
            .collect();
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let mut region = region(&[&star]);
            assert!(matches!(
                build(&region, rule),
                Err(MeshError::SelfCrossing { .. })
            ));
            assert_eq!(region.split_at_crossings(rule), 5);
            assert_eq!(
                region.warnings,
                ["5 crossings of edges: filled by the even-odd rule"]
            );
            let mesh = build(&region, rule).expect("repaired");
            // Even-odd leaves the pentagon in the middle empty: one loop of ten would fill it.
            assert_eq!(mesh.triangle_count(), 5, "{}", rule.name());
            assert_eq!(mesh.boundary_edge_count(), 15);
        }
    }

    #[test]
    fn arcs_that_cross_are_refused_whatever_the_tolerance() {
        // The northern edges meet at this latitude; the southern one rises to 50.43° there.
        let ring = |latitude: f64| {
            let vertices = [
                [0.0, 50.0],
                [20.0, 50.0],
                [20.0, 51.0],
                [10.0, latitude],
                [0.0, 51.0],
            ];
            region(&[&vertices])
        };
        let body = Ellipsoid::WGS84;
        for boundary_tolerance_m in [1.0, 1_000.0, 100_000.0] {
            let options = MeshOptions {
                boundary_tolerance_m,
                ..MeshOptions::default()
            };
            let build = |region: &Region, rule| RegionMesh::build(region, &body, rule, &options);
            let error = build(&ring(50.2), EdgeRule::GreatEllipse).expect_err("crosses");
            let MeshError::SelfCrossing {
                first,
                second,
                longitude_deg,
                latitude_deg,
                ..
            } = error
            else {
                panic!("{error}");
            };
            assert_eq!([first.vertex, second.vertex], [0, 2]);
            assert!((10.0..20.0).contains(&longitude_deg), "{longitude_deg}");
            assert!((50.2..50.43).contains(&latitude_deg), "{latitude_deg}");
            let mut repaired = ring(50.2);
            assert_eq!(repaired.split_at_crossings(EdgeRule::GreatEllipse), 2);
            assert!(build(&repaired, EdgeRule::GreatEllipse).is_ok());
            // Twins: north of the arc, and as straight lines.
            assert!(build(&ring(50.5), EdgeRule::GreatEllipse).is_ok());
            assert!(build(&ring(50.2), EdgeRule::Planar).is_ok());
        }
    }

    #[test]
    fn a_coast_beside_an_arc_is_refused_if_and_only_if_it_crosses() {
        let body = Ellipsoid::WGS84;
        let options = MeshOptions {
            boundary_tolerance_m: 1e6,
            ..MeshOptions::default()
        };
        let refused = |region: &Region| {
            let mesh = RegionMesh::build(region, &body, EdgeRule::GreatEllipse, &options);
            matches!(mesh, Err(MeshError::SelfCrossing { .. }))
        };
        let crosses = |region: &Region| {
            let mut repaired = region.clone();
            repaired.split_at_crossings(EdgeRule::GreatEllipse) > 0
        };
        // The vertex in the lens, the ninth, is no corner of the flat triangle beside the arc.
        let mut coast = [
            [0.0, 43.277497375078475],
            [20.0, 46.21451845788132],
            [20.4, 48.391826798273875],
            [18.980727227641424, 46.245925428100115],
            [18.565376967027948, 46.12708654088134],
            [17.631383745950796, 46.23916743601111],
            [10.50224075214462, 45.47812084202469],
            [7.454906021571159, 45.02616318057405],
            [6.267840171578126, 44.75601674820085],
            [5.262381147082305, 44.432816572977956],
            [1.669926304579843, 43.76847933253629],
            [-0.4, 45.45480571547103],
        ];
        assert!(refused(&region(&[&coast])) && crosses(&region(&[&coast])));
        for vertex in &mut coast[3..11] {
            vertex[1] += 0.2;
        }
        assert!(!refused(&region(&[&coast])) && !crosses(&region(&[&coast])));

        let mut random = random_numbers(11);
        let mut crossing = 0;
        for round in 0..2_000 {
            let width = [1.0, 5.0, 20.0, 60.0][round % 4];
            let (south, slope) = (10.0 + 50.0 * random(), 0.3 * (random() - 0.5));
            let bow = width * width * 0.001 * (2.0 * south.to_radians()).sin();
            let mut eastings: Vec<f64> = (0..3 + round % 9).map(|_| random()).collect();
            eastings.sort_by(|a, b| b.total_cmp(a));
            let mut ring = vec![[0.0, south], [width, south + slope * width]];
            ring.push([1.02 * width, south + slope * width + 6.0 * bow]);
            for share in eastings {
                let height = bow * (4.5 * share * (1.0 - share) + 0.3 * random());
                ring.push([share * width, south + slope * share * width + height]);
            }
            ring.push([-0.02 * width, south + 6.0 * bow]);
            let region = region(&[&ring]);
            assert_eq!(refused(&region), crosses(&region), "{ring:?}");
            crossing += u32::from(crosses(&region));
        }
        // Twin: there were both.
        assert!((200..1_800).contains(&crossing), "{crossing}");
    }

    #[test]
    fn polygons_that_overlap_are_filled_where_an_odd_number_of_them_is() {
        let a = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let b = a.map(|[x, y]| [x + 1.0, y + 1.0]);
        let mut region = region(&[&a, &b]);
        assert_eq!(region.split_at_crossings(EdgeRule::Planar), 2);
        let mesh = build(&region, EdgeRule::Planar).expect("repaired");
        let square = |south: f64, width: f64| {
            Ellipsoid::WGS84.quadrangle_area_m2(
                width.to_radians(),
                south.to_radians(),
                (south + 1.0).to_radians(),
            )
        };
        let exact = square(0.0, 2.0) + 2.0 * square(1.0, 1.0) + square(2.0, 2.0);
        assert!((mesh.area_m2 / exact - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rings_written_a_turn_apart_cross_all_the_same() {
        let a = [[170.0, 0.0], [190.3, 0.1], [190.1, 10.0], [170.0, 10.0]];
        let b = [[175.0, 5.0], [195.0, 5.7], [195.2, 15.0], [175.0, 15.3]];
        let shifted = |ring: &[Degrees; 4], turn: f64| ring.map(|[x, y]| [x + 360.0 * turn, y]);
        let mut areas = Vec::new();
        for turn in [0.0, -1.0] {
            let mut region = region(&[&a, &shifted(&b, turn)]);
            assert!(matches!(
                build(&region, EdgeRule::Planar),
                Err(MeshError::SelfCrossing { .. })
            ));
            assert_eq!(region.split_at_crossings(EdgeRule::Planar), 2, "{turn}");
            // Where the edges were cut stays a vertex of those that were split.
            let mesh = build(&region, EdgeRule::Planar).expect("repaired");
            areas.push(mesh.area_m2);
        }
        assert!((areas[0] / areas[1] - 1.0).abs() < 1e-12, "{areas:?}");
        // Twin: apart on the body, they do not cross, though their longitudes overlap modulo a
        // smaller angle than a turn.
        let mut apart = region(&[&a, &shifted(&b, -0.5)]);
        assert_eq!(apart.split_at_crossings(EdgeRule::Planar), 0);
    }

    #[test]
    fn random_rings_a_turn_apart_mesh_once_they_are_split() {
        let mut random = random_numbers(5);
        let mut crossings = 0;
        for _ in 0..200 {
            let mut ring = |west: f64| -> Vec<Degrees> {
                let vertex = |_| [west + 20.0 * random(), 30.0 * random()];
                (0..6).map(vertex).collect()
            };
            let mut region = region(&[&ring(170.0), &ring(-190.0), &ring(170.0)]);
            crossings += region.split_at_crossings(EdgeRule::Planar);
            build(&region, EdgeRule::Planar).expect("repaired");
        }
        assert!(crossings > 2_000, "{crossings}");
    }

    #[test]
    fn every_crossing_of_a_region_is_listed_up_to_a_bound() {
        let zigzag = |count: u32, turned: bool| -> Vec<Degrees> {
            // Long teeth, closed by a way round that touches nothing; each of them crosses each of
            // those turned by 90°.
            let tooth = |k: u32| {
                [
                    f64::from(k) * 0.1 + 1.0,
                    if k.is_multiple_of(2) { 0.25 } else { 44.5 },
                ]
            };
            let mut ring: Vec<Degrees> = (0..2 * count).map(tooth).collect();
            ring.push([f64::from(2 * count) * 0.1 + 2.0, 0.0]);
            ring.push([0.0, 0.0]);
            if turned {
                ring.iter_mut().for_each(|vertex| vertex.swap(0, 1));
            }
            ring
        };
        for (count, listed, more, counted_all) in [
            (3, 36, 0, true),
            (20, 100, 1_500, true),
            (80, 100, 9_900, false),
        ] {
            let region = region(&[&zigzag(count, false), &zigzag(count, true)]);
            let errors = RegionMesh::build_all(
                std::slice::from_ref(&region),
                &Ellipsoid::WGS84,
                EdgeRule::Planar,
                &MeshOptions::default(),
            )
            .expect_err("teeth cross");
            let crossings: Vec<_> = errors.iter().filter_map(MeshError::place).collect();
            assert_eq!(crossings.len(), listed, "{errors:?}");
            assert!(crossings.is_sorted());
            let found = errors.iter().find_map(|error| match error {
                MeshError::MoreCrossings {
                    more, counted_all, ..
                } => Some((*more, *counted_all)),
                _ => None,
            });
            let expected = (more > 0).then_some((more, counted_all));
            assert_eq!(found, expected, "{count}");
            // The repair finds as many.
            if counted_all {
                let mut repaired = region.clone();
                assert_eq!(repaired.split_at_crossings(EdgeRule::Planar), listed + more);
            }
        }
    }

    #[test]
    fn what_does_not_cross_is_left_alone() {
        let touching = [
            [0.0, 0.0],
            [1.0, 1.0],
            [2.0, 2.0],
            [2.0, 0.0],
            [1.0, 1.0],
            [0.0, 2.0],
        ];
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let mut region = region(&[&touching]);
            let mut before = region.clone();
            assert_eq!(region.split_at_crossings(rule), 0);
            before.repaired = true;
            assert_eq!(region, before);
        }
    }
}
