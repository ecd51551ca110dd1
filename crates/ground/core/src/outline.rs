// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rings → edges that the triangulation can take: within ±180° of longitude, closed there, split to
//! follow their rule, and grouped into parts that have nothing to do with one another.
//!
//! Degrees. A region is treated as a *chain modulo 2* on the strip −180 … 180 × −90 … 90. That is a
//! set of edges in which every point is met by an even number of ends. Its inside is what an odd
//! number of edges separates from the outside. Cutting at the antimeridian then needs no case
//! distinction. Wherever a ring passes from one side to the other it leaves an odd end at the same
//! latitude on both sides. Joining those ends in pairs along +180 and again along −180 closes the
//! chain on each side. A ring with one pole on either side passes an odd number of times. The whole
//! parallel of each pole that lies inside a ring ([`Polygon::sides`]) belongs to the chain; it is one
//! point of the body.

use crate::antimeridian::{AtAntimeridian, crossings_at_antimeridian};
use crate::crossings::{CrossingPlaces, crossing_places, find_crossings};
use crate::edge::{Degrees, EdgeSplitter};
use crate::inside::SideChoice;
use crate::mesh::Extent;
use crate::pieces::{OutlineEdge, Piece, is_uncut, ring_pieces};
use crate::{EdgePlace, EdgeRule, Inside, Polygon, Region, Repair, Ring};
use std::collections::BTreeMap;
use terrafill_planar::box_tree::{AxisBox, BoxTree};

/// A region's edges, ready to triangulate.
pub(crate) struct Outline {
    /// Parts whose bounding boxes do not touch: each is triangulated for itself.
    pub(crate) groups: Vec<Vec<OutlineEdge>>,
    pub(crate) extent: Extent,
    /// Rings of which another side could be meant; vertex 0.
    pub(crate) choices: Vec<(EdgePlace, SideChoice)>,
    splits: Splits,
}

/// What was split.
#[derive(Default)]
struct Splits {
    /// Edges as they were, within ±180°.
    whole: Vec<OutlineEdge>,
    points: Vec<Degrees>,
    /// Edges of the file that are cut at the antimeridian or run along it.
    at_antimeridian: Vec<AtAntimeridian>,
    /// Their places.
    at_antimeridian_places: Vec<EdgePlace>,
}

/// The great ellipse between two opposite points is not determined.
pub(crate) struct OppositeEnds {
    pub(crate) place: EdgePlace,
    pub(crate) start: Degrees,
    pub(crate) end: Degrees,
}

/// Longitudes and latitudes covered, `[west, south, east, north]`.
#[derive(Debug, Clone, Copy)]
struct Bounds([f64; 4]);

impl Bounds {
    const EMPTY: Self = Self([
        f64::INFINITY,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NEG_INFINITY,
    ]);

    fn add(&mut self, [longitude, latitude]: Degrees) {
        let [west, south, east, north] = &mut self.0;
        *west = west.min(longitude);
        *south = south.min(latitude);
        *east = east.max(longitude);
        *north = north.max(latitude);
    }

    fn join(&mut self, other: &Self) {
        if other.0[0] > other.0[2] {
            // Nothing is left of a polygon whose vertices are all at one pole.
            return;
        }
        self.add([other.0[0], other.0[1]]);
        self.add([other.0[2], other.0[3]]);
    }
}

/// One polygon's edges.
struct PolygonEdges {
    edges: Vec<OutlineEdge>,
    bounds: Bounds,
}

impl Outline {
    /// Cuts, closes, splits and groups the rings of `region`.
    ///
    /// # Errors
    /// Every edge that joins opposite points.
    pub(crate) fn new(
        region: &Region,
        rule: EdgeRule,
        splitter: &mut EdgeSplitter<'_>,
    ) -> Result<Self, Vec<OppositeEnds>> {
        let mut builder = Builder {
            rule,
            splitter,
            parts: Vec::with_capacity(region.polygons.len()),
            longitudes: Vec::new(),
            crossings: Vec::new(),
            splits: Splits::default(),
            opposite: Vec::new(),
            inside: region.inside,
            choices: Vec::new(),
            is_joined: matches!(region.repaired, Some(Repair::Union | Repair::KeepShells)),
        };
        for (index, polygon) in region.polygons.iter().enumerate() {
            builder.add_polygon(index, polygon);
        }
        if !builder.opposite.is_empty() {
            return Err(builder.opposite);
        }
        builder.close_along_antimeridian();
        let edges = builder.parts.iter_mut().map(|part| &mut part.edges);
        share_breakpoints(&mut edges.collect::<Vec<_>>());
        let mut whole = Bounds::EMPTY;
        for part in &builder.parts {
            whole.join(&part.bounds);
        }
        let [west_deg, east_deg] = shortest_interval(builder.longitudes);
        Ok(Self {
            groups: group(builder.parts),
            extent: Extent {
                west_deg,
                south_deg: whole.0[1],
                east_deg,
                north_deg: whole.0[3],
            },
            choices: builder.choices,
            splits: builder.splits,
        })
    }

    /// Crossings of whole edges where one of them is split or cut: its parts only touch the other
    /// there, as in the middle of a bow-tie.
    ///
    /// Of the others those are compared with them whose boxes meet that of a whole edge, or of arcs
    /// hold a point that splits one. Those that come near a part only are no fewer by much, and a part
    /// may be bent over a vertex that the whole edge has on its other side.
    pub(crate) fn crossings_at_splits(&self, rule: EdgeRule, most: usize) -> Vec<CrossingPlaces> {
        let Splits { whole, points, .. } = &self.splits;
        let mut places = self.crossings_at_cuts(rule, most);
        if whole.is_empty() {
            return places;
        }
        let mut split: Vec<EdgePlace> = whole.iter().map(|edge| edge.place).collect();
        split.sort_unstable();
        let others = self.groups.iter().flatten();
        let mut others: Vec<OutlineEdge> = others
            .filter(|edge| split.binary_search(&edge.place).is_err())
            .copied()
            .collect();
        let edge_box = |edge: &OutlineEdge| AxisBox::of([edge.start, edge.end]);
        let mut boxes: Vec<AxisBox> = whole.iter().map(edge_box).collect();
        if rule == EdgeRule::GreatEllipse {
            boxes.extend(points.iter().map(|point| AxisBox::of([*point])));
        }
        let tree = BoxTree::new(&boxes);
        others.retain(|edge| tree.meets(&edge_box(edge)));
        let mut edges = whole.clone();
        edges.append(&mut others);
        let ends: Vec<[Degrees; 2]> = edges.iter().map(|edge| [edge.start, edge.end]).collect();
        let (found, _) = find_crossings(rule, &ends, most);
        places.extend(crossing_places(&edges, &found));
        places
    }

    /// Crossings on the antimeridian itself.
    fn crossings_at_cuts(&self, rule: EdgeRule, most: usize) -> Vec<CrossingPlaces> {
        let found = crossings_at_antimeridian(rule, &self.splits.at_antimeridian, most);
        let place = |(pair, at): ([usize; 2], Degrees)| {
            let [a, b] = pair.map(|index| self.splits.at_antimeridian_places[index]);
            CrossingPlaces::of([a, b], at)
        };
        found.into_iter().map(place).collect()
    }
}

fn in_order(a: f64, b: f64) -> [f64; 2] {
    [a.min(b), a.max(b)]
}

struct Builder<'a, 'b> {
    rule: EdgeRule,
    splitter: &'a mut EdgeSplitter<'b>,
    parts: Vec<PolygonEdges>,
    /// West and east ends of every run of a ring between two crossings of the antimeridian.
    longitudes: Vec<[f64; 2]>,
    /// Latitudes where rings pass from one side of the antimeridian to the other, and the part.
    crossings: Vec<(f64, usize)>,
    splits: Splits,
    opposite: Vec<OppositeEnds>,
    inside: Inside,
    choices: Vec<(EdgePlace, SideChoice)>,
    /// Whether parts are going to be joined, which takes the antimeridian as far as any of them goes.
    is_joined: bool,
}

impl Builder<'_, '_> {
    fn add_polygon(&mut self, index: usize, polygon: &Polygon) {
        let part_index = self.parts.len();
        let mut part = PolygonEdges {
            edges: Vec::with_capacity(polygon.rings().map(|ring| ring.vertices_deg().len()).sum()),
            bounds: Bounds::EMPTY,
        };
        let sides = polygon.sides(self.rule, self.splitter.body(), self.inside);
        for ((ring_index, ring), side) in polygon.rings().enumerate().zip(sides) {
            let place = |vertex: usize| EdgePlace {
                polygon: index,
                ring: ring_index,
                vertex,
            };
            if self.rule == EdgeRule::Planar && is_uncut(ring) {
                self.add_uncut(&mut part, ring, place);
                continue;
            }
            let mut pieces = match ring_pieces(self.rule, ring) {
                Ok(pieces) => pieces,
                Err(vertices) => {
                    let corners = ring.vertices_deg();
                    let opposite = vertices.into_iter().map(|vertex| OppositeEnds {
                        place: place(vertex),
                        start: corners[vertex],
                        end: corners[(vertex + 1) % corners.len()],
                    });
                    self.opposite.extend(opposite);
                    continue;
                }
            };
            self.record_cuts(ring, &pieces, place);
            let crossings = self.record_runs(&pieces, part_index);
            let [holds_south, holds_north] = side.holds_poles;
            debug_assert_eq!(crossings % 2 == 1, holds_south != holds_north);
            let along_poles = parallels_of(side.holds_poles, &pieces);
            for piece in &along_poles {
                self.crossings.push((piece.end[1], part_index));
                self.longitudes.push([-180.0, 180.0]);
            }
            pieces.extend(along_poles);
            self.choices
                .extend(side.choice.map(|choice| (place(0), choice)));
            for piece in pieces {
                self.add_split(&mut part, piece.start, piece.end, place(piece.vertex));
            }
        }
        self.parts.push(part);
    }

    /// Edges as they stand: most rings are far from the antimeridian, and a list of pieces of a
    /// million edges is memory to fill and to go through again.
    fn add_uncut(
        &mut self,
        part: &mut PolygonEdges,
        ring: &Ring,
        place: impl Fn(usize) -> EdgePlace,
    ) {
        let mut run = Bounds::EMPTY;
        for (vertex, (start, end)) in ring.edges_deg().enumerate() {
            run.add(start);
            self.add_split(part, start, end, place(vertex));
        }
        self.longitudes.push([run.0[0], run.0[2]]);
    }

    /// Notes the edges that are cut at the antimeridian or run along it.
    fn record_cuts(&mut self, ring: &Ring, pieces: &[Piece], place: impl Fn(usize) -> EdgePlace) {
        for (index, piece) in pieces.iter().enumerate() {
            if let Some(found) = AtAntimeridian::of(ring, &pieces[index..]) {
                self.splits.at_antimeridian.push(found);
                let places = &mut self.splits.at_antimeridian_places;
                places.push(place(piece.vertex));
            }
        }
    }

    /// Notes longitude intervals and crossings of a closed sequence of pieces; returns the number
    /// of crossings.
    fn record_runs(&mut self, pieces: &[Piece], part: usize) -> usize {
        let before = self.crossings.len();
        let mut run = Bounds::EMPTY;
        let next = pieces.iter().cycle().skip(1);
        for (piece, next) in pieces.iter().zip(next) {
            run.add(piece.start);
            run.add(piece.end);
            if piece.end != next.start {
                self.crossings.push((piece.end[1], part));
                self.longitudes.push([run.0[0], run.0[2]]);
                run = Bounds::EMPTY;
            }
        }
        if run.0[0] <= run.0[2] {
            self.longitudes.push([run.0[0], run.0[2]]);
        }
        self.crossings.len() - before
    }

    fn add_split(
        &mut self,
        part: &mut PolygonEdges,
        start: Degrees,
        end: Degrees,
        place: EdgePlace,
    ) {
        let mut from = start;
        part.bounds.add(start);
        part.bounds.add(end);
        let PolygonEdges { edges, bounds } = part;
        let Splits { whole, points, .. } = &mut self.splits;
        let points_before = points.len();
        self.splitter.split(start, end, &mut |point| {
            bounds.add(point);
            points.push(point);
            edges.push(OutlineEdge {
                start: from,
                end: point,
                place,
            });
            from = point;
        });
        if points.len() > points_before {
            whole.push(OutlineEdge { start, end, place });
        }
        edges.push(OutlineEdge {
            start: from,
            end,
            place,
        });
    }

    /// Joins the parts that cross the antimeridian into one and closes it on both sides.
    fn close_along_antimeridian(&mut self) {
        if self.crossings.is_empty() {
            return;
        }
        let mut crossings = std::mem::take(&mut self.crossings);
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut crossing_parts: Vec<usize> = crossings.iter().map(|crossing| crossing.1).collect();
        crossing_parts.sort_unstable();
        crossing_parts.dedup();
        let mut joined = PolygonEdges {
            edges: Vec::new(),
            bounds: Bounds::EMPTY,
        };
        for index in crossing_parts.iter().rev() {
            let part = self.parts.swap_remove(*index);
            joined.bounds.join(&part.bounds);
            joined.edges.extend(part.edges);
        }
        let place = joined.edges[0].place;
        for (index, pair) in crossings.windows(2).enumerate() {
            let (south, north) = (pair[0].0, pair[1].0);
            // Where an even number of rings passes, an edge on either side twice is none to parity.
            let times = match index % 2 {
                0 => 1,
                _ if self.is_joined => 2,
                _ => 0,
            };
            if south == north || times == 0 {
                continue;
            }
            for side in [-180.0, 180.0] {
                for _ in 0..times {
                    self.add_split(&mut joined, [side, south], [side, north], place);
                }
            }
            // No edge of the file, and nothing goes beyond it.
            let added = |edge: &OutlineEdge| edge.place == place && is_along_antimeridian(edge);
            self.splits.whole.retain(|edge| !added(edge));
        }
        self.parts.push(joined);
    }
}

/// Whole parallels of the poles that a ring of these pieces holds, directed as its border.
fn parallels_of(holds_poles: [bool; 2], pieces: &[Piece]) -> Vec<Piece> {
    // Only against one another does their direction count.
    let westwards = holds_poles == [true; 2] && {
        let under =
            |piece: &Piece| 0.5 * (piece.start[1] + piece.end[1]) * (piece.end[0] - piece.start[0]);
        pieces.iter().map(under).sum::<f64>() < 0.0
    };
    let parallel = |latitude: f64, [from, to]: [f64; 2]| Piece {
        start: [from, latitude],
        end: [to, latitude],
        vertex: pieces.last().map_or(0, |piece| piece.vertex),
        turns: 0.0,
    };
    let eastward = [-180.0, 180.0];
    let south = if westwards { [180.0, -180.0] } else { eastward };
    let both = [parallel(-90.0, south), parallel(90.0, eastward)];
    let held = both.into_iter().zip(holds_poles);
    held.filter(|(_, held)| *held)
        .map(|(piece, _)| piece)
        .collect()
}

/// Splits edges along the antimeridian wherever either side has a vertex, so that the two sides
/// cancel edge by edge when they are stitched: a file may have vertices on one side only.
pub(crate) fn share_breakpoints(lists: &mut [&mut Vec<OutlineEdge>]) {
    let mut latitudes: Vec<f64> = Vec::new();
    for edge in lists.iter().flat_map(|edges| edges.iter()) {
        for end in [edge.start, edge.end] {
            if end[0].abs() == 180.0 {
                latitudes.push(end[1]);
            }
        }
    }
    if latitudes.is_empty() {
        return;
    }
    latitudes.sort_by(f64::total_cmp);
    latitudes.dedup();
    for list in lists {
        if !list.iter().any(is_along_antimeridian) {
            continue;
        }
        let mut edges = Vec::with_capacity(list.len());
        for edge in list.drain(..) {
            if !is_along_antimeridian(&edge) {
                edges.push(edge);
                continue;
            }
            let [low, high] = in_order(edge.start[1], edge.end[1]);
            let first = latitudes.partition_point(|latitude| *latitude <= low);
            let past = latitudes.partition_point(|latitude| *latitude < high);
            // The direction does not matter to a chain modulo 2.
            let mut from = [edge.start[0], low];
            for latitude in latitudes[first..past.max(first)].iter().chain([&high]) {
                let to = [edge.start[0], *latitude];
                edges.push(OutlineEdge {
                    start: from,
                    end: to,
                    place: edge.place,
                });
                from = to;
            }
        }
        **list = edges;
    }
}

/// Whether the edge runs along the antimeridian.
fn is_along_antimeridian(edge: &OutlineEdge) -> bool {
    edge.start[0].abs() == 180.0 && edge.start[0] == edge.end[0]
}

/// Parts with touching bounding boxes, joined; parts and their edges keep their order.
///
/// A sweep from west to east over groups whose intervals of latitude are apart. A group's interval
/// is compared rather than its parts': it may join more than needed, never less.
fn group(mut parts: Vec<PolygonEdges>) -> Vec<Vec<OutlineEdge>> {
    parts.retain(|part| !part.edges.is_empty());
    let mut from_west: Vec<usize> = (0..parts.len()).collect();
    from_west.sort_by(|&a, &b| parts[a].bounds.0[0].total_cmp(&parts[b].bounds.0[0]));
    // By their southern ends.
    let mut open: BTreeMap<i64, OpenGroup> = BTreeMap::new();
    let mut done: Vec<Vec<usize>> = Vec::new();
    for index in from_west {
        // Adding zero turns −0 into 0, which sorts apart from it.
        let [west, south, east, north] = parts[index].bounds.0.map(|side| side + 0.0);
        let mut joined = OpenGroup {
            north,
            east,
            members: vec![index],
        };
        // Those apart from one another lie in order of both ends, and those that reach into the
        // interval are the last ones that start in it or south of it.
        let mut lowest = order_key(south);
        while let Some((&start, group)) = open.range(..=order_key(joined.north)).next_back() {
            if group.north < south {
                break;
            }
            let Some(mut group) = open.remove(&start) else {
                break;
            };
            if group.east < west {
                done.push(group.members);
                continue;
            }
            lowest = lowest.min(start);
            joined.north = joined.north.max(group.north);
            joined.east = joined.east.max(group.east);
            if group.members.len() > joined.members.len() {
                std::mem::swap(&mut group.members, &mut joined.members);
            }
            joined.members.append(&mut group.members);
        }
        open.insert(lowest, joined);
    }
    done.extend(open.into_values().map(|group| group.members));
    for members in &mut done {
        members.sort_unstable();
    }
    done.sort_unstable();
    done.into_iter()
        .map(|members| {
            // Most groups are one part, and a million edges are memory to fill once more.
            if let [only] = members[..] {
                return std::mem::take(&mut parts[only].edges);
            }
            let count = members.iter().map(|&i| parts[i].edges.len()).sum();
            let mut edges = Vec::with_capacity(count);
            for i in members {
                edges.append(&mut parts[i].edges);
            }
            edges
        })
        .collect()
}

/// A group that parts further east may touch.
struct OpenGroup {
    north: f64,
    east: f64,
    members: Vec<usize>,
}

/// A number's bits as an integer in the same order ([`f64::total_cmp`]), for keys.
#[allow(clippy::cast_possible_wrap, reason = "bits are what is meant")]
fn order_key(number: f64) -> i64 {
    let bits = number.to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

/// The shortest interval of longitude that holds all of them, `[west, east]`; west of the
/// antimeridian to east of it when west > east.
fn shortest_interval(mut intervals: Vec<[f64; 2]>) -> [f64; 2] {
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let Some(&[west, mut east]) = intervals.first() else {
        return [-180.0, 180.0];
    };
    let mut widest_gap = 0.0;
    let mut gap_ends = [west, west];
    for &[next_west, next_east] in &intervals {
        if next_west - east > widest_gap {
            widest_gap = next_west - east;
            gap_ends = [east, next_west];
        }
        east = east.max(next_east);
    }
    // The gap over the antimeridian; it wins a draw, which leaves west < east.
    if west + 360.0 - east >= widest_gap {
        [west, east]
    } else {
        [gap_ends[1], gap_ends[0]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shortest_interval_goes_over_the_antimeridian_where_that_is_shorter() {
        assert_eq!(
            shortest_interval(vec![[10.0, 20.0], [-5.0, 12.0]]),
            [-5.0, 20.0]
        );
        assert_eq!(
            shortest_interval(vec![[20.0, 180.0], [-180.0, -169.0]]),
            [20.0, -169.0]
        );
        assert_eq!(shortest_interval(vec![[-180.0, 180.0]]), [-180.0, 180.0]);
        assert_eq!(shortest_interval(vec![[170.0, 180.0]]), [170.0, 180.0]);
    }

    #[test]
    fn parts_that_touch_are_never_apart_and_order_does_not_matter() {
        let mut random = terrafill_fixtures::random_numbers(9);
        let mut most_groups = 0;
        for round in 0..200 {
            let size = 0.3 / f64::from(round % 20 + 1);
            let corners: Vec<[f64; 4]> = (0..60)
                .map(|_| {
                    let (w, s) = (random(), random() - 0.5);
                    [w, s, w + size * random(), s + size * random()]
                })
                .collect();
            let parts = corners.iter().map(|&[w, s, e, n]| {
                let edge = OutlineEdge {
                    start: [w, s],
                    end: [e, n],
                    place: EdgePlace::default(),
                };
                PolygonEdges {
                    edges: vec![edge],
                    bounds: Bounds([w, s, e, n]),
                }
            });
            let groups = group(parts.collect());
            let sides =
                |edge: &OutlineEdge| [edge.start[0], edge.start[1], edge.end[0], edge.end[1]];
            assert_eq!(groups.iter().map(Vec::len).sum::<usize>(), corners.len());
            for (i, a) in groups.iter().enumerate() {
                for b in &groups[..i] {
                    for ([w, s, e, n], [w2, s2, e2, n2]) in a
                        .iter()
                        .flat_map(|a| b.iter().map(move |b| (sides(a), sides(b))))
                    {
                        assert!(w > e2 || w2 > e || s > n2 || s2 > n, "touching, yet apart");
                    }
                }
            }
            most_groups = most_groups.max(groups.len());
        }
        // Negative control: putting everything in one group would pass the above.
        assert!(most_groups > 30, "{most_groups}");
    }

    #[test]
    fn only_parts_that_touch_are_grouped() {
        let part = |west: f64, east: f64| {
            let mut bounds = Bounds::EMPTY;
            bounds.add([west, 0.0]);
            bounds.add([east, 1.0]);
            let edge = OutlineEdge {
                start: [west, 0.0],
                end: [east, 1.0],
                place: EdgePlace::default(),
            };
            PolygonEdges {
                edges: vec![edge],
                bounds,
            }
        };
        let groups = group(vec![part(0.0, 1.0), part(5.0, 6.0), part(1.0, 2.0)]);
        let mut sizes: Vec<usize> = groups.iter().map(Vec::len).collect();
        sizes.sort_unstable();
        assert_eq!(sizes, [1, 2]);
    }
}
