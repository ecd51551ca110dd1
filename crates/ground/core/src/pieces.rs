// SPDX-License-Identifier: MIT OR Apache-2.0
//! Parts of ring edges: pieces between cuts at the antimeridian, and edges short enough to draw.
//!
//! Degrees, longitudes within ±180. A place has the same bits whichever turn it was written in and
//! whichever way its edge runs.

use crate::edge::{Degrees, POLE_APPROACH_END_DEG, along_pole, great_circle_latitude, normal};
use crate::{EdgePlace, EdgeRule, Ring};

/// An edge short enough to draw.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OutlineEdge {
    pub(crate) start: Degrees,
    pub(crate) end: Degrees,
    /// Edge of the file that it is a part of.
    pub(crate) place: EdgePlace,
}

/// Longitudes and latitudes of edges, `[west, south, east, north]`; of none, west is east of east.
pub(crate) fn bounds(edges: &[OutlineEdge]) -> [f64; 4] {
    let mut bounds = [180.0_f64, 90.0_f64, -180.0_f64, -90.0_f64];
    for [longitude, latitude] in edges.iter().flat_map(|edge| [edge.start, edge.end]) {
        bounds[0] = bounds[0].min(longitude);
        bounds[1] = bounds[1].min(latitude);
        bounds[2] = bounds[2].max(longitude);
        bounds[3] = bounds[3].max(latitude);
    }
    bounds
}

/// Part of a ring edge between two cuts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece {
    pub(crate) start: Degrees,
    pub(crate) end: Degrees,
    /// Vertex that the edge starts at.
    pub(crate) vertex: usize,
    /// Whole turns between the longitudes here and those of the file; 0 for great ellipses, which
    /// have none of their own.
    pub(crate) turns: f64,
}

/// Pieces of a ring within ±180, in order; where one ends at ±180 and the next starts at ∓180 the
/// ring crosses the antimeridian.
///
/// # Errors
/// The vertices whose edges join two opposite points of the body (great ellipses only).
pub(crate) fn ring_pieces(rule: EdgeRule, ring: &Ring) -> Result<Vec<Piece>, Vec<usize>> {
    match rule {
        EdgeRule::Planar => Ok(planar_pieces(ring)),
        EdgeRule::GreatEllipse => great_ellipse_pieces(ring),
    }
}

/// Whether planar edges of a ring have nothing to do with the antimeridian.
pub(crate) fn is_uncut(ring: &Ring) -> bool {
    let mut vertices = ring.vertices_deg().iter();
    let stays = |[longitude, latitude]: &Degrees| {
        is_off_antimeridian(*longitude) && or_at_pole(*latitude) == *latitude
    };
    ring.winding_deg() == 0.0 && vertices.all(stays)
}

/// See [`ring_pieces`].
pub(crate) fn planar_pieces(ring: &Ring) -> Vec<Piece> {
    let vertices = ring.vertices_deg();
    let within = |[longitude, latitude]: &Degrees| {
        (longitude.abs() == 180.0 || is_off_antimeridian(*longitude))
            && or_at_pole(*latitude) == *latitude
    };
    let mut pieces = Vec::with_capacity(vertices.len());
    if ring.winding_deg() == 0.0 && vertices.iter().all(within) {
        for (vertex, (start, end)) in ring.edges_deg().enumerate() {
            pieces.push(Piece {
                start,
                end,
                vertex,
                turns: 0.0,
            });
        }
        return pieces;
    }
    let turns = (ring.winding_deg() / 360.0).round();
    for vertex in 0..vertices.len() {
        let start = Turned::of_vertex(ring, vertex, 0.0);
        let end = if vertex + 1 < vertices.len() {
            Turned::of_vertex(ring, vertex + 1, 0.0)
        } else {
            Turned::of_vertex(ring, 0, turns)
        };
        let first = pieces.len();
        if end.degrees == start.degrees && end.turns == start.turns {
            // Both within rounding of a pole.
            continue;
        }
        if end.is_west_of(&start) {
            cut_planar(end, start, vertex, &mut pieces);
            pieces[first..].reverse();
            for piece in &mut pieces[first..] {
                (piece.start, piece.end) = (piece.end, piece.start);
            }
        } else {
            cut_planar(start, end, vertex, &mut pieces);
        }
    }
    pieces
}

/// Ends of a great-ellipse edge that are opposite but for less than this angle of their normals are
/// refused, radians: 6 mm on the Earth.
///
/// A rounding of either end turns the edge by its share of this angle: at 1 µm from opposite, two right
/// programs draw hemispheres that differ.
pub const NEARLY_OPPOSITE_RAD: f64 = 1e-9;

/// Longitudes closer than this to ±180 mean ±180, degrees (a micrometre on the Earth): Natural
/// Earth's land at 1:110m has 180.00000000000014, and pieces that far apart are not stitched.
pub(crate) const ANTIMERIDIAN_SNAP_DEG: f64 = 1e-11;

fn is_off_antimeridian(longitude_deg: f64) -> bool {
    longitude_deg.abs() < 180.0 - ANTIMERIDIAN_SNAP_DEG
}

/// The latitude that is meant by one a rounding away from a pole: ±90.
///
/// All of a pole's longitudes are one place, so edges that go to it at different ones are kept apart
/// by parallels down to [`POLE_APPROACH_END_DEG`]. Nothing can keep them apart if one of them ends
/// above that and not at the pole: they are drawn as one.
pub(crate) fn or_at_pole(latitude_deg: f64) -> f64 {
    if (0.0..POLE_APPROACH_END_DEG).contains(&(90.0 - latitude_deg.abs())) {
        90.0_f64.copysign(latitude_deg)
    } else {
        latitude_deg
    }
}

/// A position as longitude within ±180 and whole turns, so that the same place has the same bits
/// whichever turn it was written in.
#[derive(Clone, Copy)]
struct Turned {
    degrees: Degrees,
    turns: f64,
}

impl Turned {
    fn new(position: Degrees, extra_turns: f64) -> Self {
        let turns = (position[0] / 360.0).round();
        let mut longitude = position[0] - 360.0 * turns;
        if !is_off_antimeridian(longitude) {
            longitude = 180.0_f64.copysign(longitude);
        }
        Self {
            degrees: [longitude, or_at_pole(position[1])],
            turns: turns + extra_turns,
        }
    }

    fn of_vertex(ring: &Ring, vertex: usize, extra_turns: f64) -> Self {
        let [longitude, latitude] = ring.vertices_deg()[vertex];
        let written = ring.written_longitude_deg(vertex);
        let shifted_by = ((longitude - written) / 360.0).round();
        Self::new([written, latitude], extra_turns + shifted_by)
    }

    fn is_west_of(&self, other: &Self) -> bool {
        let turns = self.turns - other.turns;
        360.0 * turns + self.degrees[0] - other.degrees[0] < 0.0
    }
}

/// Cuts an eastward (or meridional) edge at every ±180 it crosses.
fn cut_planar(mut west: Turned, mut east: Turned, vertex: usize, pieces: &mut Vec<Piece>) {
    // On the antimeridian itself an edge starts on the side it goes to and ends on the one it
    // comes from; a meridional edge stays on one side.
    let meridional = west.degrees[0] - east.degrees[0] == 360.0 * (east.turns - west.turns);
    if east.degrees[0] == -180.0 {
        east.degrees[0] = 180.0;
        east.turns -= 1.0;
    }
    if meridional {
        if west.degrees[0] == -180.0 {
            west.degrees[0] = 180.0;
            west.turns -= 1.0;
        }
    } else if west.degrees[0] == 180.0 {
        west.degrees[0] = -180.0;
        west.turns += 1.0;
    }
    let mut start = west.degrees;
    let mut turn = west.turns;
    while turn < east.turns {
        let to_west = (180.0 - west.degrees[0]) + 360.0 * (turn - west.turns);
        let to_east = (180.0 + east.degrees[0]) + 360.0 * (east.turns - turn - 1.0);
        let share = to_west / (to_west + to_east);
        let latitude = or_at_pole(west.degrees[1] + (east.degrees[1] - west.degrees[1]) * share);
        pieces.push(Piece {
            start,
            end: [180.0, latitude],
            vertex,
            turns: turn,
        });
        start = [-180.0, latitude];
        turn += 1.0;
    }
    pieces.push(Piece {
        start,
        end: east.degrees,
        vertex,
        turns: turn,
    });
}

fn great_ellipse_pieces(ring: &Ring) -> Result<Vec<Piece>, Vec<usize>> {
    // ±180 is one meridian, and in which turn it was written says nothing about an arc. A ring there
    // and back over a pole, half of it from −180 and half from +180, went all the way round there.
    let on_one_side = |[longitude, latitude]: Degrees| {
        let on_antimeridian = longitude.abs() == 180.0;
        [if on_antimeridian { -180.0 } else { longitude }, latitude]
    };
    let vertices: Vec<Degrees> = (0..ring.vertices_deg().len())
        .map(|vertex| on_one_side(Turned::of_vertex(ring, vertex, 0.0).degrees))
        .collect();
    let mut pieces: Vec<Piece> = Vec::with_capacity(vertices.len());
    let mut opposite = Vec::new();
    for (vertex, start) in vertices.iter().enumerate() {
        let end = vertices[(vertex + 1) % vertices.len()];
        opposite.extend(cut_great_ellipse(*start, end, vertex, &mut pieces).err());
    }
    if !opposite.is_empty() {
        return Err(opposite);
    }
    join_at_poles(&mut pieces);
    Ok(pieces)
}

/// Pieces of the shorter arc; where it meets a pole they end and start at their own longitudes.
///
/// # Errors
/// `vertex`, where the ends are opposite.
fn cut_great_ellipse(
    mut start: Degrees,
    mut end: Degrees,
    vertex: usize,
    pieces: &mut Vec<Piece>,
) -> Result<(), usize> {
    let mut push = |start, end| {
        pieces.push(Piece {
            start,
            end,
            vertex,
            turns: 0.0,
        });
    };
    match (start[1].abs() == 90.0, end[1].abs() == 90.0) {
        (true, true) if start[1] == end[1] => return Ok(()),
        (true, true) => return Err(vertex),
        // A pole has no longitude of its own: the edge is a meridian.
        (true, false) => {
            push([end[0], start[1]], end);
            return Ok(());
        }
        (false, true) => {
            push(start, [start[0], end[1]]);
            return Ok(());
        }
        (false, false) => {}
    }
    if (end[0] - start[0]).abs() > 180.0 {
        // ±180 is one meridian, written as suits the other end.
        if start[0].abs() == 180.0 {
            start[0] = -start[0];
        } else if end[0].abs() == 180.0 {
            end[0] = -end[0];
        }
    }
    if (normal(start) + normal(end)).length() < NEARLY_OPPOSITE_RAD {
        return Err(vertex);
    }
    let span = (end[0] - start[0]).abs();
    if span < 180.0 {
        push(start, end);
        return Ok(());
    }
    let latitude = if span == 180.0 {
        // Over the nearer pole.
        90.0_f64.copysign(start[1] + end[1])
    } else {
        let (west, east) = if start[0] > 0.0 {
            (start, end)
        } else {
            (end, start)
        };
        great_circle_latitude(west, [east[0] + 360.0, east[1]], 180.0)
    };
    // Where it passes a pole by less than rounding it is a meridian on either side as well.
    let sides = if latitude.abs() == 90.0 {
        [start[0], end[0]]
    } else {
        [start, end].map(|[longitude, _]| 180.0_f64.copysign(longitude))
    };
    push(start, [sides[0], latitude]);
    push([sides[1], latitude], end);
    Ok(())
}

/// Fills the gaps that arcs through a pole left between their longitudes there, the shorter way.
///
/// The way does not matter: the two ways differ by the pole's whole parallel, which
/// the outline adds or not by the number of crossings.
fn join_at_poles(pieces: &mut Vec<Piece>) {
    let mut joined = Vec::with_capacity(pieces.len());
    let next = pieces.iter().cycle().skip(1);
    for (piece, next) in pieces.iter().zip(next) {
        joined.push(*piece);
        let (from, to) = (piece.end, next.start);
        let Some(pole) = along_pole(from, to) else {
            continue;
        };
        let step = to[0] - from[0];
        let mut push = |start: Degrees, end: Degrees| {
            if start != end {
                joined.push(Piece {
                    start,
                    end,
                    ..*piece
                });
            }
        };
        if step.abs() <= 180.0 {
            push(from, to);
        } else if step.abs() < 360.0 {
            let side = 180.0_f64.copysign(from[0]);
            push(from, [side, pole]);
            push([-side, pole], to);
        }
    }
    *pieces = joined;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces_of(
        rule: EdgeRule,
        vertices: &[Degrees],
        winding_deg: f64,
    ) -> Vec<(Degrees, Degrees)> {
        let ring = Ring::from_checked(vertices.to_vec(), winding_deg);
        let pieces = ring_pieces(rule, &ring).expect("no opposite ends");
        pieces
            .iter()
            .map(|piece| (piece.start, piece.end))
            .collect()
    }

    #[test]
    fn an_edge_over_the_antimeridian_is_cut_at_the_same_bits_in_every_spelling() {
        let east = [[170.3, 10.1], [189.9, 20.7], [180.0, 0.0]];
        let west = east.map(|[longitude, latitude]| [longitude - 360.0, latitude]);
        let a = pieces_of(EdgeRule::Planar, &east, 0.0);
        let b = pieces_of(EdgeRule::Planar, &west, 0.0);
        assert_eq!(a, b);
        assert_eq!(a[0].1[0], 180.0);
        assert_eq!(a[1].0, [-180.0, a[0].1[1]]);
        // The vertex on the antimeridian belongs to the side that each of its edges lies on.
        assert_eq!(a[2].1, [-180.0, 0.0]);
        assert_eq!(a[3].0, [180.0, 0.0]);
    }

    #[test]
    fn a_great_ellipse_is_cut_at_the_same_bits_both_ways() {
        let ring = [[170.3, 10.1], [-169.9, 20.7], [175.0, -30.0]];
        let mut reversed = ring;
        reversed.reverse();
        let a = pieces_of(EdgeRule::GreatEllipse, &ring, 0.0);
        let b = pieces_of(EdgeRule::GreatEllipse, &reversed, 0.0);
        let cuts = |pieces: &[(Degrees, Degrees)]| {
            let mut cuts: Vec<f64> = pieces
                .iter()
                .filter(|piece| piece.1[0] == 180.0)
                .map(|piece| piece.1[1])
                .chain(pieces.iter().filter(|p| p.0[0] == 180.0).map(|p| p.0[1]))
                .collect();
            cuts.sort_by(f64::total_cmp);
            cuts
        };
        assert_eq!(cuts(&a).len(), 2);
        assert_eq!(cuts(&a), cuts(&b));
    }

    #[test]
    fn which_vertices_are_turned_moves_none_by_a_bit() {
        let ring = [
            [-180.0, 10.1],
            [-0.3, 20.7],
            [8e-5, 15.0],
            [77.7, -3.0],
            [180.0, 10.1],
        ];
        let mut reversed = ring;
        reversed.reverse();
        let mut rotated = ring;
        rotated.rotate_left(2);
        let read = |ring: [Degrees; 5]| {
            let text = format!(r#"{{"type":"Polygon","coordinates":[{ring:?}]}}"#);
            let mut regions = crate::parse_regions(text.as_bytes(), "ring").expect("valid");
            regions.remove(0).polygons.remove(0).shell
        };
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let longitudes = |ring: &Ring| {
                let pieces = ring_pieces(rule, ring).expect("no opposite ends");
                let ends = pieces.iter().flat_map(|piece| [piece.start, piece.end]);
                let mut off: Vec<f64> = ends.map(|[x, _]| x).filter(|x| x.abs() < 180.0).collect();
                off.sort_by(f64::total_cmp);
                off
            };
            let expected = [-0.3, -0.3, 8e-5, 8e-5, 77.7, 77.7];
            for ring in [ring, reversed, rotated] {
                let ring = read(ring);
                assert_eq!(ring.winding_deg().abs(), 360.0);
                assert_eq!(longitudes(&ring), expected, "{rule:?}");
            }
            // Negative control: without their longitudes in the file they are moved.
            let forgotten = Ring::from_checked(read(rotated).vertices_deg().to_vec(), 360.0);
            assert_ne!(longitudes(&forgotten), expected);
        }
    }

    #[test]
    fn opposite_ends_are_refused() {
        let ring = Ring::from_checked(vec![[0.0, 10.0], [180.0, -10.0], [90.0, 0.0]], 0.0);
        assert_eq!(
            ring_pieces(EdgeRule::GreatEllipse, &ring).err(),
            Some(vec![0])
        );
        // Within the bound and, as negative controls, beyond it: over a pole and beside it.
        let pieces = |end: Degrees| {
            let ring = Ring::from_checked(vec![[0.0, 10.0], end, [90.0, 0.0]], 0.0);
            ring_pieces(EdgeRule::GreatEllipse, &ring).is_ok()
        };
        let bound_deg = NEARLY_OPPOSITE_RAD.to_degrees();
        for (share, is_ok) in [(0.9, false), (1.1, true)] {
            assert_eq!(pieces([180.0, -10.0 + share * bound_deg]), is_ok);
            assert_eq!(pieces([180.0 - 1.02 * share * bound_deg, -10.0]), is_ok);
        }
        assert!(pieces([180.0, -9.0]));
    }
}
