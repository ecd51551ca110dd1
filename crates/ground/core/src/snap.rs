// SPDX-License-Identifier: MIT OR Apache-2.0
//! Straight edges → edges that meet at their ends only: snap rounding.
//!
//! Degrees. A place where two edges cross is rounded to the nearest numbers, which bends both of
//! them, possibly over a third a rounding away. Split again and again, two rings a rounding apart
//! never come to an end. Snap rounding does: every vertex and every crossing is moved to the middle
//! of its cell of a grid, and every edge is led through the middles of those *hot* cells that it
//! meets. Seen as cells that shrink to their middles, no edge moves over another or over a vertex
//! (Hobby 1999, "Practical segment intersection with finite precision output"; Guibas & Marimont
//! 1998). That holds as long as cells and crossings are exact, so both are found in integers.
//!
//! The cells are as wide as the last bit of the largest longitude and as high as that of the largest
//! latitude. So nothing is moved further than its file could have rounded it, and nothing that was
//! not there is moved onto the antimeridian.

use crate::EdgeRule;
use crate::edge::Degrees;
use crate::pieces::{OutlineEdge, or_at_pole};
use glam::DVec3;
use std::ops::ControlFlow;
use terrafill_planar::box_tree::{AxisBox, BoxTree};
use terrafill_planar::intersection::{SMALLEST_COORDINATE_DEG, orient};

/// Middle of a cell, in halves of its sides: even numbers, below 2⁵⁴.
type Cell = [i64; 2];

/// Times that places beside a pole are moved there, each of which may make new ones.
const MAX_MOVES_TO_POLES: u32 = 4;

/// Cells round the multiples of two powers of two.
#[derive(Debug, Clone, Copy)]
struct Grid {
    /// Half a cell's sides, degrees.
    half_deg: [f64; 2],
}

impl Grid {
    fn of(places: impl Iterator<Item = Degrees>) -> Self {
        let mut largest = [SMALLEST_COORDINATE_DEG; 2];
        for place in places {
            largest = [0, 1].map(|k| largest[k].max(place[k].abs()));
        }
        Self {
            half_deg: largest.map(|largest| 0.5 * (largest - largest.next_down())),
        }
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "whole, and below 2⁵³ by the choice of the grid"
    )]
    fn cell(&self, place: Degrees) -> Cell {
        [0, 1].map(|k| 2 * (place[k] / (2.0 * self.half_deg[k])).round() as i64)
    }

    fn place(&self, cell: Cell) -> Degrees {
        [0, 1].map(|k| cell[k] as f64 * self.half_deg[k])
    }
}

/// Edges that cross nowhere, close to `groups`; what lies within one cell vanishes.
///
/// Of planar edges cells beside a pole are moved to it ([`or_at_pole`]), which may move an edge over
/// another one. An arc to a pole would be a meridian, and not go where its chord does.
pub(crate) fn snap_rounded(rule: EdgeRule, groups: &[Vec<OutlineEdge>]) -> Vec<Vec<OutlineEdge>> {
    let mut snapped = snapped_once(groups);
    let rounds = match rule {
        EdgeRule::Planar => MAX_MOVES_TO_POLES,
        EdgeRule::GreatEllipse => 0,
    };
    for _ in 0..rounds {
        if !move_to_poles(&mut snapped) {
            break;
        }
        snapped = snapped_once(&snapped);
    }
    snapped
}

/// Moves ends that are a rounding away from a pole there; whether there were any.
fn move_to_poles(groups: &mut [Vec<OutlineEdge>]) -> bool {
    let mut has_moved = false;
    for edges in groups {
        for edge in &mut *edges {
            for end in [&mut edge.start, &mut edge.end] {
                let latitude = or_at_pole(end[1]);
                has_moved |= latitude != end[1];
                end[1] = latitude;
            }
        }
        edges.retain(|edge| edge.start != edge.end);
    }
    has_moved
}

fn snapped_once(groups: &[Vec<OutlineEdge>]) -> Vec<Vec<OutlineEdge>> {
    let edges = || groups.iter().flatten();
    // One grid for all: along the antimeridian the sides of two groups have to cancel.
    let grid = Grid::of(edges().flat_map(|edge| [edge.start, edge.end]));
    groups
        .iter()
        .map(|group| {
            let segments: Vec<[Cell; 2]> = group
                .iter()
                .map(|edge| [edge.start, edge.end].map(|end| grid.cell(end)))
                .collect();
            let mut snapped = Vec::with_capacity(group.len());
            for (edge, route) in group.iter().zip(routes(&grid, &segments)) {
                snapped.extend(route.windows(2).map(|ends| OutlineEdge {
                    start: grid.place(ends[0]),
                    end: grid.place(ends[1]),
                    place: edge.place,
                }));
            }
            snapped
        })
        .collect()
}

/// The hot cells that each segment meets, in order.
fn routes(grid: &Grid, segments: &[[Cell; 2]]) -> Vec<Vec<Cell>> {
    let hot = hot_cells(grid, segments);
    let boxes: Vec<AxisBox> = hot.iter().map(|cell| box_round(grid, *cell)).collect();
    let tree = BoxTree::new(&boxes);
    let route = |segment: &[Cell; 2]| {
        let ends = segment.map(|end| grid.place(end));
        let mut met = Vec::new();
        tree.visit(&mut |bounds| may_meet(ends, bounds), &mut |index| {
            if meets(*segment, hot[index]) {
                met.push(hot[index]);
            }
        });
        // A segment goes from column to column and from row to row, never back.
        let [from, to] = *segment;
        let signs = [0, 1].map(|k| (to[k] - from[k]).signum());
        met.sort_unstable_by_key(|cell| signs[0] * cell[0] + signs[1] * cell[1]);
        met
    };
    segments.iter().map(route).collect()
}

/// Cells in which segments end or cross, sorted.
fn hot_cells(grid: &Grid, segments: &[[Cell; 2]]) -> Vec<Cell> {
    let mut hot: Vec<Cell> = segments.iter().flatten().copied().collect();
    let own_box = |ends: &[Cell; 2]| AxisBox::of(ends.map(|cell| grid.place(cell)));
    let boxes: Vec<AxisBox> = segments.iter().map(own_box).collect();
    let _ = BoxTree::new(&boxes).overlapping_pairs(&mut |a, b| {
        hot.extend(crossing_cell(segments[a], segments[b]));
        ControlFlow::Continue(())
    });
    hot.sort_unstable();
    hot.dedup();
    hot
}

fn point([x, y]: Degrees) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

fn box_round(grid: &Grid, cell: Cell) -> AxisBox {
    let (middle, half) = (point(grid.place(cell)), point(grid.half_deg));
    AxisBox {
        low: middle - half,
        high: middle + half,
    }
}

/// Whether a segment may come into a box; at times it does not.
fn may_meet([from, to]: [Degrees; 2], bounds: &AxisBox) -> bool {
    let (a, b) = (point(from), point(to));
    if a.max(b).cmplt(bounds.low).any() || a.min(b).cmpgt(bounds.high).any() {
        return false;
    }
    // A box's sides are rounded where they lie between two numbers: twice as far out they are not.
    let margin = 1e-15 * bounds.low.abs().max(bounds.high.abs());
    let (low, high) = (bounds.low - margin, bounds.high + margin);
    let corners = [
        [low.x, low.y],
        [high.x, low.y],
        [high.x, high.y],
        [low.x, high.y],
    ];
    let sides = corners.map(|corner| orient(from, to, corner));
    !(sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0))
}

/// Twice the area of a triangle, positive if it turns left: below 2¹¹² in size.
fn turn(a: Cell, b: Cell, c: Cell) -> i128 {
    let [[bx, by], [cx, cy]] = [b, c].map(|end| [0, 1].map(|k| i128::from(end[k] - a[k])));
    bx * cy - by * cx
}

/// Whether a segment meets a cell; of its sides the western and the southern one are its own, and of
/// its corners the one between them.
fn meets(segment: [Cell; 2], [x, y]: Cell) -> bool {
    let [low, high] = [
        [0, 1].map(|k| segment[0][k].min(segment[1][k])),
        [0, 1].map(|k| segment[0][k].max(segment[1][k])),
    ];
    // Ends are middles of cells: beyond their columns and rows it comes to no other.
    if x < low[0] || high[0] < x || y < low[1] || high[1] < y {
        return false;
    }
    if low[0] == high[0] || low[1] == high[1] {
        return true;
    }
    // Northwards, so that left is west.
    let [from, to] = if segment[0][1] < segment[1][1] {
        segment
    } else {
        [segment[1], segment[0]]
    };
    let side = |dx: i64, dy: i64| turn(from, to, [x + dx, y + dy]);
    let (south_west, south_east) = (side(-1, -1), side(1, -1));
    let (north_west, north_east) = (side(-1, 1), side(1, 1));
    if from[0] < to[0] {
        // To the north-east: between the corners in the north-west and the south-east, which are not
        // the cell's.
        north_west > 0 && south_east < 0
    } else {
        // To the north-west: the corner in the south-west is, the one in the north-east is not.
        south_west >= 0 && north_east < 0
    }
}

/// The cell in which two segments cross, each between its ends.
fn crossing_cell(a: [Cell; 2], b: [Cell; 2]) -> Option<Cell> {
    let (a0, a1) = (turn(b[0], b[1], a[0]), turn(b[0], b[1], a[1]));
    let (b0, b1) = (turn(a[0], a[1], b[0]), turn(a[0], a[1], b[1]));
    let apart = |p: i128, q: i128| p != 0 && q != 0 && (p < 0) != (q < 0);
    if !(apart(a0, a1) && apart(b0, b1)) {
        return None;
    }
    let share = a0.unsigned_abs();
    let whole = share + a1.unsigned_abs();
    Some([0, 1].map(|k| {
        let along = floor_of_share(a[1][k] - a[0][k], share, whole);
        // A cell reaches from one odd number up to the next one.
        2 * (a[0][k] + along + 1).div_euclid(2)
    }))
}

/// `⌊length · share / whole⌋`, bit by bit: the product has up to 167 bits.
///
/// - `length`: below 2⁵⁶ in size; `share` ≤ `whole` < 2¹¹³
fn floor_of_share(length: i64, share: u128, whole: u128) -> i64 {
    let (mut quotient, mut rest) = (0_i64, 0_u128);
    let size = length.unsigned_abs();
    for bit in (0..64 - size.leading_zeros()).rev() {
        rest = 2 * rest + if size >> bit & 1 == 1 { share } else { 0 };
        quotient *= 2;
        while rest >= whole {
            rest -= whole;
            quotient += 1;
        }
    }
    if length < 0 {
        -quotient - i64::from(rest > 0)
    } else {
        quotient
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crossings::find_crossings;
    use crate::{EdgePlace, EdgeRule};

    /// Uniform on 0 … 1, the same every time.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn choose<T: Copy>(&mut self, from: &[T]) -> T {
            self.next();
            let index = usize::try_from(self.0 >> 33).expect("31 bits");
            from[index % from.len()]
        }
    }

    fn outline(ends: &[[Degrees; 2]]) -> Vec<OutlineEdge> {
        let edge = |(vertex, &[start, end]): (usize, &[Degrees; 2])| OutlineEdge {
            start,
            end,
            place: EdgePlace {
                vertex,
                ..EdgePlace::default()
            },
        };
        ends.iter().enumerate().map(edge).collect()
    }

    fn crossings(edges: &[OutlineEdge]) -> usize {
        let ends: Vec<[Degrees; 2]> = edges.iter().map(|edge| [edge.start, edge.end]).collect();
        find_crossings(EdgeRule::Planar, &ends, usize::MAX).0.len()
    }

    /// Edges a few roundings beside one line, so that they cross anywhere.
    fn bundle(random: &mut Random, count: usize) -> Vec<[Degrees; 2]> {
        let corner = |random: &mut Random| [random.next() - 0.5, random.next() - 0.5];
        let size = random.choose(&[300.0, 20.0, 1e-9]);
        let (a, b) = (corner(random), corner(random));
        let mut place = |share: f64| {
            [0, 1].map(|k| {
                let exact = size * (a[k] + (b[k] - a[k]) * share) + if k == 0 { 0.0 } else { 5.0 };
                let bits = (7.0 * random.next()).floor() - 3.0;
                exact + bits * 2.0 * (exact.abs().next_up() - exact.abs())
            })
        };
        (0..count)
            .map(|index| {
                let k = index as f64 / count as f64;
                [place(0.3 * k), place(1.0 - 0.2 * k)]
            })
            .collect()
    }

    /// From the line through both ends.
    fn distance([from, to]: [Degrees; 2], place: Degrees) -> f64 {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        orient(from, to, place).abs() / length
    }

    #[test]
    fn edges_a_rounding_apart_cross_no_more_once_they_are_snapped() {
        let mut random = Random(3);
        let (mut before, mut once_split, mut moved_bits) = (0, 0, 0.0_f64);
        for _ in 0..300 {
            let ends = bundle(&mut random, 12);
            let edges = outline(&ends);
            before += crossings(&edges);
            let snapped =
                snap_rounded(EdgeRule::Planar, std::slice::from_ref(&edges)).swap_remove(0);
            assert_eq!(crossings(&snapped), 0, "{ends:?}");
            // Negative control: vertices made where they cross, rounded, leave crossings.
            let (found, _) = find_crossings(EdgeRule::Planar, &ends, usize::MAX);
            once_split += crossings(&crate::crossings::split_outline(&edges, &found));
            let largest = ends.as_flattened().as_flattened().iter();
            let bit = largest.fold(0.0_f64, |sum, x| sum.max(x.abs())) * f64::EPSILON;
            for edge in &snapped {
                let source = ends[edge.place.vertex];
                let away = [edge.start, edge.end].map(|place| distance(source, place));
                moved_bits = moved_bits.max(away[0].max(away[1]) / bit);
            }
        }
        assert!(before > 1_000 && once_split > 100, "{before}, {once_split}");
        // An end to the middle of its cell, and the route to the middles of others.
        assert!((0.5..1.5).contains(&moved_bits), "{moved_bits}");
    }

    #[test]
    fn every_place_on_a_segment_is_in_one_cell_that_it_meets() {
        // In thirds of half a cell: corners and middles of cells, and between them.
        let mut on_corners = 0;
        for to in [
            [6, 2],
            [4, 4],
            [2, 6],
            [-4, 4],
            [-6, 2],
            [6, 0],
            [0, -6],
            [-2, -6],
            [2, -4],
        ] {
            let segment = [[0, 0], to];
            let cells = || {
                (-8..=8)
                    .step_by(2)
                    .flat_map(|x| (-8..=8).step_by(2).map(move |y| [x, y]))
            };
            let met: Vec<Cell> = cells().filter(|cell| meets(segment, *cell)).collect();
            let mut came_to = Vec::new();
            for share in 0..=840 {
                // Half-open towards the east and the north, as in `meets`.
                let column = |k: usize| 2 * (to[k] * share + 840).div_euclid(2 * 840);
                came_to.push([column(0), column(1)]);
                on_corners += usize::from((0..2).all(|k| (to[k] * share + 840) % 1680 == 0));
            }
            came_to.sort_unstable();
            came_to.dedup();
            assert_eq!(met, came_to, "{to:?}");
        }
        assert!(on_corners > 5, "{on_corners}");
    }

    #[test]
    fn a_crossing_is_in_the_cell_that_exact_fractions_say() {
        let mut random = Random(8);
        let even: Vec<i64> = (-20..20).map(|half| 2 * half).collect();
        let (mut crossings, mut negative) = (0, 0);
        for _ in 0..2_000 {
            let mut cell = || [0, 1].map(|_| random.choose(&even));
            let (a, b) = ([cell(), cell()], [cell(), cell()]);
            let Some(found) = crossing_cell(a, b) else {
                continue;
            };
            crossings += 1;
            negative += usize::from(found[0] < 0);
            let [share, rest] = [0, 1].map(|end| turn(b[0], b[1], a[end]).abs());
            for k in 0..2 {
                let step = i128::from(a[1][k] - a[0][k]) * share;
                // The place less the cell's middle, times the common denominator.
                let off = step + i128::from(a[0][k] - found[k]) * (share + rest);
                assert!(-(share + rest) <= off && off < share + rest, "{a:?} {b:?}");
            }
        }
        assert!(crossings > 300 && negative > 100, "{crossings}, {negative}");
        // Near the largest numbers that a grid has.
        let far = 1_i64 << 54;
        let diagonals = ([[-far, -far], [far, far]], [[-far, far], [far, -far + 2]]);
        assert_eq!(crossing_cell(diagonals.0, diagonals.1), Some([0, 0]));
        let off = ([[-far, -far], [far, far]], [[-far, far], [far, -far + 6]]);
        assert_eq!(crossing_cell(off.0, off.1), Some([2, 2]));
    }

    #[test]
    fn what_is_on_the_grid_and_crosses_nowhere_stays() {
        let square = outline(&[
            [[180.0, 89.999_999_999_999_99], [-180.0, 90.0]],
            [[-180.0, 90.0], [-180.0, -90.0]],
            [
                [179.999_999_999_999_97, -90.0],
                [180.0, 89.999_999_999_999_99],
            ],
        ]);
        let snapped = |rule| snap_rounded(rule, std::slice::from_ref(&square)).swap_remove(0);
        let ends = |edges: &[OutlineEdge]| -> Vec<[Degrees; 2]> {
            edges.iter().map(|edge| [edge.start, edge.end]).collect()
        };
        assert_eq!(ends(&snapped(EdgeRule::GreatEllipse)), ends(&square));
        // Negative control: where all of a pole's longitudes are ends of edges, what is beside it is moved there.
        let at_pole = ends(&snapped(EdgeRule::Planar));
        assert_eq!(at_pole[0], [[180.0, 90.0], [-180.0, 90.0]]);
        assert_eq!(at_pole[1], ends(&square)[1]);
        // Negative control: an edge through the cell of one of these vertices is led through it.
        let beside = outline(&[[[180.0, 0.0], [-180.0, 0.0]], [[0.0, 1e-30], [3.0, 80.0]]]);
        let snapped = snap_rounded(EdgeRule::Planar, &[beside]).swap_remove(0);
        assert_eq!(
            ends(&snapped)[..2],
            [[[180.0, 0.0], [0.0; 2]], [[0.0; 2], [-180.0, 0.0]]]
        );
    }
}
