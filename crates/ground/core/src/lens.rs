// SPDX-License-Identifier: MIT OR Apache-2.0
//! Great-ellipse edges split until the triangulation sees each vertex on the side that it lies on.
//!
//! Degrees. The triangulation sees an arc's chord, straight in longitude and latitude, and sees a vertex in
//! the *lens* between the two beyond the arc when it is not. For most regions that is a matter of the
//! boundary's tolerance. A sliver that lies in a lens as a whole comes out turned over, though. Finer
//! chords everywhere cost as many vertices as the sliver is long and thin: arcs of 10° a rounding apart
//! took 600,000.
//!
//! So arcs are split at the feet of the vertices in their lenses: there chord and arc meet, and the vertex
//! is in neither half's lens. Where no lens holds a vertex, chords lie to one another and to all vertices
//! as their arcs do. For let the ends of two arcs lie outside of each other's lenses. An arc enters and
//! leaves the other's lens an even number of times. So it crosses chord and arc equally often but for
//! pairs, and the same goes for the two chords in turn. Cost is a vertex for each vertex in a lens,
//! whatever the arcs' distance.

use crate::EdgeRule;
use crate::crossings::{find_crossings, split_at};
use crate::edge::{
    Degrees, ROUNDING, arc_rad, great_ellipse_crossing, in_order, normal, point_on_edge,
};
use crate::pieces::OutlineEdge;
use glam::DVec3;
use std::cell::{Cell, RefCell};
use std::cmp::Ordering;
use std::collections::BTreeSet;
use terrafill_planar::box_tree::{AxisBox, BoxTree};
use terrafill_planar::intersection::{Crossing, orient};

/// Edges that one edge of a group may become on average.
const MAX_PARTS: usize = 32;
/// Edges that a smaller group is taken for: in it every arc may be beside every other.
const SMALL_GROUP: usize = 64;
/// Vertices of which it is asked where their feet are, for each edge that may be made.
const MAX_ASKED: usize = 8;
/// Rounds of splitting: places made in one may lie in the lens of another arc.
const MAX_ROUNDS: usize = 8;
/// Crossings to those of an earlier round from which on there is no end of them.
const MAX_GROWTH: usize = 4;
/// Steps in which an arc's distance from its chord is measured.
const STEPS: u32 = 8;
/// Roundings by which a place on one of two arcs may be off the other and be one on both: either arc
/// has been split at places that were rounded.
const SAME_ARC_ROUNDINGS: f64 = 4.0;
/// Cells of vertices that are one, degrees: a power of two, so that ±180 and ±90 are in the middle
/// of theirs, and smaller than [`ROUNDING`].
const CELL_DEG: f64 = 1.0 / (1_u64 << 41) as f64;

/// Latitude up to which a lens is not measured where its height is bounded, and a bound on its tangent.
const STEEP_DEG: f64 = 80.0;
const STEEP_TANGENT: f64 = 5.7;
/// How much farther than a lens's height boxes are looked for: what rounds the distance of a corner from
/// a chord, 2e-13°, is less than a quarter of the lowest lens.
const SLACK: f64 = 1.25;
/// Cosine of the latitude beyond which cells are no wider.
const NARROWEST: f64 = 1e-6;

/// What becomes of vertices that are within rounding of an arc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WithinRounding {
    /// Nothing.
    Kept,
    /// The arc is led through them, and what lies in one cell is one vertex.
    Merged,
}

/// Splits arcs until their chords lie to one another as they do: at the feet of vertices in their lenses,
/// and where chords cross all the same. Those are arcs within rounding of one another, and the place is one
/// on them. A vertex where the *chords* cross is off the arcs by as much as a lens is high, and in the
/// lenses of all arcs beside these two. Arcs that do cross are split where they do; whether they are
/// refused is decided by the edges of the file, of which these may be parts a rounding off.
///
/// Arcs that are one to the last bit can cross more of one another with every place that they are split
/// at. Where there is no end of that, what is within rounding is merged although `near` is to keep it.
///
/// - returns: at most [`MAX_PARTS`] times as many edges, or as a group of [`SMALL_GROUP`] may have;
///   what cancels modulo 2 may be left out
/// - cost: O(n log n), with n edges returned
pub(crate) fn follow_arcs(edges: Vec<OutlineEdge>, near: WithinRounding) -> Vec<OutlineEdge> {
    if near == WithinRounding::Merged {
        return follow_once(edges, near).unwrap_or_else(|crossing| crossing);
    }
    follow_once(edges.clone(), near).unwrap_or_else(|crossing| {
        let merged = follow_once(edges, WithinRounding::Merged);
        merged.unwrap_or(crossing)
    })
}

/// # Errors
/// The arcs as far as they could be split, if chords go on to cross.
fn follow_once(
    edges: Vec<OutlineEdge>,
    near: WithinRounding,
) -> Result<Vec<OutlineEdge>, Vec<OutlineEdge>> {
    let most = MAX_PARTS * edges.len().max(SMALL_GROUP);
    let at_feet = split_at_feet(without_pairs(edges), near, most);
    let mut edges = without_pairs(at_feet.clone());
    let mut fewest = usize::MAX;
    for _ in 0..MAX_ROUNDS {
        let ends: Vec<[Degrees; 2]> = edges.iter().map(|edge| [edge.start, edge.end]).collect();
        let (mut found, _) = find_crossings(EdgeRule::Planar, &ends, most);
        for ([a, b], at) in &mut found {
            *at = great_ellipse_crossing(ends[*a], ends[*b]).unwrap_or(*at);
        }
        if found.is_empty() {
            return Ok(edges);
        }
        // Between arcs that are one to rounding every place makes two crossings more.
        if found.len() > fewest.saturating_mul(MAX_GROWTH) {
            return Err(at_feet);
        }
        if edges.len() + 2 * found.len() > most {
            break;
        }
        fewest = fewest.min(found.len());
        edges = split_at_feet(split_on_arcs(&edges, &found, near), near, most);
        edges = without_pairs(edges);
    }
    Err(edges)
}

/// Edges that occur an odd number of times, whichever way they run: the others bound nothing.
fn without_pairs(edges: Vec<OutlineEdge>) -> Vec<OutlineEdge> {
    let key = |index: &usize| in_order(edges[*index].start, edges[*index].end);
    let mut order: Vec<usize> = (0..edges.len()).collect();
    // Coordinates are numbers.
    order.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal));
    let mut is_odd = vec![false; edges.len()];
    for same in order.chunk_by(|a, b| key(a) == key(b)) {
        is_odd[same[0]] = same.len() % 2 == 1;
    }
    let odd = edges.into_iter().zip(is_odd);
    odd.filter_map(|(edge, is_odd)| is_odd.then_some(edge))
        .collect()
}

/// What a corner of a triangle beside a chord tells of the places in the lens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LensCorner {
    /// The corner is in the lens, and the arc is off its chord there by more than rounding.
    InLens,
    /// The lens is within the triangle, so no other vertex is in it.
    Clear,
    /// The lens may reach beyond the triangle.
    Hidden,
}

/// Of the triangle between an arc's chord and a place. In its narrow corners the lens may be wider than
/// it.
pub(crate) fn sight_of([start, end]: [Degrees; 2], place: Degrees) -> LensCorner {
    let chord = [0, 1].map(|k| end[k] - start[k]);
    let length_deg = chord[0].hypot(chord[1]);
    let off_deg = off_chord([start, end], place).abs();
    // A straight line in longitude and latitude leaves the arc by an eighth of the acceleration (2 tan φ Δλ
    // Δφ, sin φ cos φ Δλ²). It sets out from its ends at half of it; half as much again covers its change
    // on the way. Most places are a thousand times as far away.
    let mut lens = None;
    let (bow_deg, steepest) = if start[1].abs().max(end[1].abs()) < STEEP_DEG {
        let [width, height] = chord.map(f64::abs);
        let bow_deg = 0.19 * width.to_radians() * (0.5 * width).hypot(2.0 * STEEP_TANGENT * height);
        (bow_deg, 4.0 * bow_deg / length_deg)
    } else {
        lens = Lens::of(start, end);
        let bow_deg = lens.as_ref().map_or(0.0, |lens| lens.height_deg);
        // Measured, and not where it is steepest.
        (bow_deg, 8.0 * bow_deg / length_deg)
    };
    if off_deg <= bow_deg {
        let lens = lens.or_else(|| Lens::of(start, end));
        let Some(lens) = lens else {
            return LensCorner::Clear;
        };
        if lens.foot_of(place, WithinRounding::Kept).is_some() {
            return LensCorner::InLens;
        }
    }
    let along = |from: Degrees, towards: f64| {
        let by = [0, 1].map(|k| (place[k] - from[k]) * chord[k] * towards);
        (by[0] + by[1]) / length_deg
    };
    if off_deg >= steepest * along(start, 1.0).max(along(end, -1.0)) {
        LensCorner::Clear
    } else {
        LensCorner::Hidden
    }
}

/// Whether any of the places is in the lens of one of the arcs.
///
/// - cost: O(n log n) for n places, and for each arc log n and the places beside its chord
pub(crate) fn any_in_lens(arcs: &[[Degrees; 2]], places: &[Degrees]) -> bool {
    let boxes: Vec<AxisBox> = places
        .iter()
        .copied()
        .map(|place| AxisBox::of([place]))
        .collect();
    let tree = BoxTree::new(&boxes);
    let arcs = arcs.iter();
    let mut lenses = arcs.filter_map(|[start, end]| Lens::of(*start, *end));
    let holds = |lens: Lens| {
        let found = Cell::new(false);
        tree.visit(
            &mut |bounds| !found.get() && lens.may_hold(bounds),
            &mut |index| {
                let foot = lens.foot_of(places[index], WithinRounding::Kept);
                found.set(found.get() || foot.is_some());
            },
        );
        found.get()
    };
    lenses.any(holds)
}

/// Splits arcs beside the places where their chords cross: at one place if it is on both to rounding.
fn split_on_arcs(
    edges: &[OutlineEdge],
    crossings: &[Crossing],
    near: WithinRounding,
) -> Vec<OutlineEdge> {
    let mut insertions: Vec<(usize, f64, Degrees)> = Vec::with_capacity(2 * crossings.len());
    for &([a, b], at) in crossings {
        // In an order of their own, so that rings the other way round are split at the same bits.
        let key = |index: usize| in_order(edges[index].start, edges[index].end);
        let [a, b] = if key(b) < key(a) { [b, a] } else { [a, b] };
        let [first, second] = [a, b].map(|index| Arc::of(&edges[index]));
        let on_first = first.nearest(at);
        let on_second = second.nearest(on_first);
        let is_one = arc_rad(on_first, on_second) <= SAME_ARC_ROUNDINGS * ROUNDING;
        let places = if is_one && second.may_pass(on_first) {
            [on_first; 2]
        } else if is_one && first.may_pass(on_second) {
            [on_second; 2]
        } else {
            [on_first, on_second]
        };
        for (index, arc, place) in [(a, first, places[0]), (b, second, places[1])] {
            let may_move = ![a, b].iter().any(|index| ends_at_pole(&edges[*index]));
            let place = match near {
                WithinRounding::Merged if may_move => middle_of_cell(place),
                _ => place,
            };
            if place != arc.ends[0] && place != arc.ends[1] {
                insertions.push((index, arc.along(place, edges[index].start), place));
            }
        }
    }
    split_at(edges, insertions)
}

/// An edge as places lie beside it.
struct Arc {
    /// In the order of [`in_order`].
    ends: [Degrees; 2],
    /// `None` for what is straight in degrees as well.
    lens: Option<Lens>,
}

impl Arc {
    fn of(edge: &OutlineEdge) -> Self {
        let (start, end) = in_order(edge.start, edge.end);
        Self {
            ends: [start, end],
            lens: Lens::of(edge.start, edge.end),
        }
    }

    /// Place of the edge next to another one; an end of it where that is nearest.
    fn nearest(&self, place: Degrees) -> Degrees {
        let [start, end] = self.ends;
        if let Some(lens) = &self.lens {
            match lens.share_of(place) {
                Some(share) => lens.place(share),
                None if arc_rad(start, place) < arc_rad(end, place) => start,
                None => end,
            }
        } else {
            let along = [end[0] - start[0], end[1] - start[1]];
            let by = [place[0] - start[0], place[1] - start[1]];
            let share =
                (along[0] * by[0] + along[1] * by[1]) / (along[0] * along[0] + along[1] * along[1]);
            match share {
                share if share <= 0.0 => start,
                share if share >= 1.0 => end,
                share => point_on_edge(EdgeRule::Planar, start, end, share),
            }
        }
    }

    /// Whether the edge may be led through a place that is one with it on the body. What ends at a pole
    /// keeps its longitude: beside the pole all of them are one.
    fn may_pass(&self, place: Degrees) -> bool {
        let [start, end] = self.ends;
        match [start, end].map(|end| end[1].abs() == 90.0) {
            [true, false] => place[0] == end[0],
            [false, true] => place[0] == start[0],
            _ => true,
        }
    }

    /// Distance from an end, to order places on the edge by.
    fn along(&self, place: Degrees, from: Degrees) -> f64 {
        match self.lens {
            Some(_) => arc_rad(from, place),
            None => (place[0] - from[0]).hypot(place[1] - from[1]),
        }
    }
}

/// Splits arcs at the feet of vertices in their lenses, into no more than `most` edges in all.
fn split_at_feet(edges: Vec<OutlineEdge>, near: WithinRounding, most: usize) -> Vec<OutlineEdge> {
    let mut edges = match near {
        WithinRounding::Kept => edges,
        WithinRounding::Merged => merged(edges),
    };
    let asked_left = Cell::new(MAX_ASKED * most);
    for _ in 0..MAX_ROUNDS {
        // Either end: without what cancels no edge need start where another ends.
        let ends = edges.iter().flat_map(|edge| [edge.start, edge.end]);
        let mut places: Vec<Degrees> = ends.collect();
        places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        places.dedup();
        let boxes: Vec<AxisBox> = places
            .iter()
            .copied()
            .map(|place| AxisBox::of([place]))
            .collect();
        let vertices = Vertices {
            tree: BoxTree::new(&boxes),
            places: &places,
            near,
            asked_left: &asked_left,
        };
        let mut split = Vec::with_capacity(edges.len());
        for (index, edge) in edges.iter().enumerate() {
            let room = most.saturating_sub(split.len() + edges.len() - index);
            let mut from = edge.start;
            for place in vertices.feet(edge, room) {
                split.push(OutlineEdge {
                    start: from,
                    end: place,
                    ..*edge
                });
                from = place;
            }
            split.push(OutlineEdge {
                start: from,
                ..*edge
            });
        }
        let done = split.len() == edges.len();
        edges = split;
        if done {
            break;
        }
    }
    edges
}

/// Of what ends at a pole nothing is moved: it would leave its meridian.
fn merged(edges: Vec<OutlineEdge>) -> Vec<OutlineEdge> {
    let bits = |place: Degrees| place.map(f64::to_bits);
    let polar = edges.iter().filter(|edge| ends_at_pole(edge));
    let kept: BTreeSet<[u64; 2]> = polar
        .flat_map(|edge| [bits(edge.start), bits(edge.end)])
        .collect();
    let merge = |place: Degrees| {
        if kept.contains(&bits(place)) {
            place
        } else {
            middle_of_cell(place)
        }
    };
    let merge = |edge: OutlineEdge| OutlineEdge {
        start: merge(edge.start),
        end: merge(edge.end),
        ..edge
    };
    let edges = edges.into_iter().map(merge);
    edges.filter(|edge| edge.start != edge.end).collect()
}

/// And does not run along it.
fn ends_at_pole(edge: &OutlineEdge) -> bool {
    (edge.start[1].abs() == 90.0) != (edge.end[1].abs() == 90.0)
}

/// Nothing is moved onto the antimeridian or a pole, nor along them.
fn middle_of_cell(place: Degrees) -> Degrees {
    // As wide as high on the body.
    let cosine = place[1].to_radians().cos().max(NARROWEST);
    let sides = [CELL_DEG / cosine.log2().floor().exp2(), CELL_DEG];
    let middle = [0, 1].map(|k| (place[k] / sides[k]).round() * sides[k]);
    if middle[0].abs() == 180.0 || middle[1].abs() == 90.0 {
        place
    } else {
        middle
    }
}

/// Vertices that may lie in lenses.
struct Vertices<'a> {
    tree: BoxTree<'a>,
    places: &'a [Degrees],
    near: WithinRounding,
    asked_left: &'a Cell<usize>,
}

impl Vertices<'_> {
    /// At most `room` places that split an edge, in order from its start to its end.
    fn feet(&self, edge: &OutlineEdge, room: usize) -> Vec<Degrees> {
        let Some(lens) = Lens::of(edge.start, edge.end) else {
            return Vec::new();
        };
        let found = RefCell::new(Vec::new());
        let has_room = || found.borrow().len() < room && self.asked_left.get() > 0;
        self.tree.visit(
            &mut |bounds| has_room() && lens.may_hold(bounds),
            &mut |index| {
                self.asked_left.set(self.asked_left.get().saturating_sub(1));
                let foot = lens.foot_of(self.places[index], self.near);
                found.borrow_mut().extend(foot);
            },
        );
        let mut found = found.into_inner();
        found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let mut feet: Vec<Degrees> = found.into_iter().map(|(_, place)| place).collect();
        feet.dedup();
        if lens.ends[0] != edge.start {
            feet.reverse();
        }
        feet
    }
}

/// What lies between an arc and its chord.
struct Lens {
    /// In the order of [`in_order`], so that an edge and its reverse are split at the same bits.
    ends: [Degrees; 2],
    /// Unit vectors towards the start, and at right angles to it along the arc.
    axes: [DVec3; 2],
    /// Between the ends, radians.
    angle: f64,
    /// Bound on how far from the chord the lens reaches, degrees.
    height_deg: f64,
}

impl Lens {
    /// `None` where arc and chord are the same to rounding.
    fn of(start: Degrees, end: Degrees) -> Option<Self> {
        let (start, end) = in_order(start, end);
        let is_meridian = start[0] == end[0] || start[1].abs() == 90.0 || end[1].abs() == 90.0;
        if is_meridian {
            return None;
        }
        let (from, to) = (normal(start), normal(end));
        let along = (to - from * from.dot(to)).try_normalize()?;
        let mut lens = Self {
            ends: [start, end],
            axes: [from, along],
            angle: arc_rad(start, end),
            height_deg: 0.0,
        };
        let heights = (1..STEPS).map(|step| {
            let share = f64::from(step) / f64::from(STEPS);
            lens.off_chord(lens.place(share)).abs()
        });
        // Between the steps it reaches a little further.
        lens.height_deg = 2.0 * heights.fold(0.0, f64::max);
        (lens.height_deg > rounding_deg()).then_some(lens)
    }

    fn place(&self, share: f64) -> Degrees {
        point_on_edge(EdgeRule::GreatEllipse, self.ends[0], self.ends[1], share)
    }

    /// Signed distance from the chord, degrees; its sign is exact.
    fn off_chord(&self, place: Degrees) -> f64 {
        off_chord(self.ends, place)
    }

    /// Whether a box may come within the lens's height of the chord; at times it does not.
    fn may_hold(&self, bounds: &AxisBox) -> bool {
        let [start, end] = self.ends;
        let (low, high) = (bounds.low, bounds.high);
        // An arc's longitudes are those between its ends.
        if high.x < start[0] || end[0] < low.x {
            return false;
        }
        // Twice the area between the chord and the box's corners farthest to its left and right; the
        // chord leads east.
        let [width, height] = [0, 1].map(|k| end[k] - start[k]);
        let twice_area = |x: f64, y: f64| width * (y - start[1]) - height * (x - start[0]);
        let (left_x, right_x) = if height > 0.0 {
            (low.x, high.x)
        } else {
            (high.x, low.x)
        };
        let reach = self.height_deg * (width * width + height * height).sqrt() * SLACK;
        twice_area(left_x, high.y) >= -reach && twice_area(right_x, low.y) <= reach
    }

    /// How far along the arc its nearest place to another lies; `None` for its ends and beyond.
    fn share_of(&self, place: Degrees) -> Option<f64> {
        let up = normal(place);
        // The axes of a short arc are at right angles to 1e-14 only, so not `up` along the arc.
        let along = (up - self.axes[0]).dot(self.axes[1]);
        let share = along.atan2(up.dot(self.axes[0])) / self.angle;
        (share > 0.0 && share < 1.0).then_some(share)
    }

    /// Where a vertex in the lens splits the arc, and as which share of it; `None` for other vertices,
    /// and where the lens is not as high as rounding.
    fn foot_of(&self, vertex: Degrees, near: WithinRounding) -> Option<(f64, Degrees)> {
        if self.ends.contains(&vertex) || vertex[0].abs() == 180.0 || vertex[1].abs() == 90.0 {
            return None;
        }
        let share = self.share_of(vertex)?;
        let foot = self.place(share);
        // Of two vertices side by side each would come next to the other without end.
        let ahead = || share.min(1.0 - share) * self.angle > 0.25 * CELL_DEG.to_radians();
        if near == WithinRounding::Merged && arc_rad(foot, vertex) <= ROUNDING && ahead() {
            return Some((share, vertex));
        }
        let (arc, off) = (self.off_chord(foot), self.off_chord(vertex));
        if off * arc < 0.0 || off.abs() >= arc.abs() || arc.abs() <= rounding_deg() {
            return None;
        }
        let foot = match near {
            WithinRounding::Kept => foot,
            WithinRounding::Merged => middle_of_cell(foot),
        };
        // Beside a pole an arc runs along one longitude to the last bit. On the antimeridian the other side
        // would have to be split as well.
        let [west, east] = self.ends.map(|end| end[0]);
        let is_within = (west..=east).contains(&foot[0]) && foot[0].abs() != 180.0;
        (is_within && !self.ends.contains(&foot)).then_some((share, foot))
    }
}

/// See [`Lens::off_chord`].
fn off_chord([start, end]: [Degrees; 2], place: Degrees) -> f64 {
    orient(start, end, place) / (end[0] - start[0]).hypot(end[1] - start[1])
}

fn rounding_deg() -> f64 {
    ROUNDING.to_degrees()
}

#[cfg(test)]
mod tests;
