// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangle strips over a mesh.
//!
//! A strip is a path from triangle to neighbour. Three corners begin it, each further triangle takes
//! one more while the path turns left and right in turn, and where it turns the same way twice a
//! corner is said again: the triangle that comes of it has two equal corners, and shaders pass it
//! over. A new strip costs two corners and a restart, as many indices as it can spare repeated
//! corners, so the fewest indices are those of the fewest paths and, among them, of the fewest
//! repeated corners.
//!
//! Greedy strips (Akeley, Haeberli and Burns, 1990; Evans, Skiena and Varshney, 1996) leave triangles
//! alone that later strips have to collect one by one. The general problem is NP-complete, but hardly
//! a vertex of a country lies inside, so the triangles' neighbourhood is nearly a tree, and over a
//! tree the best paths are found exactly, from the leaves to the root. Of what is no tree a
//! depth-first search keeps one whose paths are long.

use crate::neighbours::{Neighbours, Side};
use terrafill_core::{RegionMesh, index_u32};

/// What a strip costs, a repeated corner being 1. Ending a path between two triangles takes away their
/// turns, and with them three repeated corners at most: before, between and after. Two corners and a
/// restart are as many; more than that, and the fewer of two equal numbers of strips are taken, since
/// drivers may draw each restart on its own. With adjacency the three are six indices and the new
/// strip five; for that one the paths are not ended.
const STRIP_COST: u32 = 4;

/// A corner of a strip, as index of a vertex, and what a geometry shader with adjacency is told
/// after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct StripCorner {
    pub(crate) vertex: u32,
    pub(crate) beside: u32,
}

/// What the strips over a mesh come to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StripCounts {
    /// Triangles, each in one strip.
    pub triangles: usize,
    /// Strips, each with two corners more than triangles.
    pub strips: usize,
    /// Corners said again, where a strip turns the same way twice.
    pub repeated: usize,
}

impl StripCounts {
    /// Corners of all strips.
    pub(crate) fn corners(self) -> usize {
        self.triangles + 2 * self.strips + self.repeated
    }
}

/// Finds the strips over `mesh` and counts.
///
/// - cost: O(triangles)
#[must_use]
pub fn strip_counts(mesh: &RegionMesh) -> StripCounts {
    let neighbours = Neighbours::of(mesh);
    Paths::over(&neighbours).count(&neighbours)
}

/// Strips that hold every triangle of a mesh once, winding kept.
#[derive(Debug, Default)]
pub(crate) struct Strips {
    corners: Vec<StripCorner>,
    /// Where each strip ends in `corners`.
    ends: Vec<usize>,
}

impl Strips {
    /// - cost: O(triangles)
    pub(crate) fn over(neighbours: &Neighbours<'_>) -> Self {
        let mut strips = Self::default();
        let mut path = Vec::new();
        let paths = Paths::over(neighbours);
        let mut is_walked = vec![false; neighbours.triangles.len()];
        for triangle in 0..neighbours.triangles.len() {
            if !is_walked[triangle] && paths.ends_at(triangle) {
                paths.walk(neighbours, triangle, &mut path);
                for step in &path {
                    is_walked[step.triangle] = true;
                }
                strips.push(neighbours, &mut path);
            }
        }
        strips
    }

    /// One after the other.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[StripCorner]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts
            .zip(&self.ends)
            .map(|(&start, &end)| &self.corners[start..end])
    }

    /// Writes a path as a strip, from the end at which its first turn costs nothing, if there is one.
    fn push(&mut self, neighbours: &Neighbours<'_>, path: &mut [Step]) {
        let turn_after = |step: Option<&Step>| step.and_then(Step::turn);
        let backwards = turn_after(path.iter().rev().nth(1)).map(|turn| 3 - turn);
        if turn_after(path.get(1)) != Some(ODD_TURN) && backwards == Some(ODD_TURN) {
            path.reverse();
            for step in path.iter_mut() {
                std::mem::swap(&mut step.enters, &mut step.leaves);
            }
        }
        let Some((first, others)) = path.split_first() else {
            return;
        };
        let side = |step: &Step, number: usize| Side {
            triangle: step.triangle,
            number: number % 3,
        };
        let told = |step: &Step, number: usize| neighbours.told_across(side(step, number));
        let start = self.corners.len();
        let leaves = first.leaves.unwrap_or(1);
        for (number, beside) in [(2, 2), (0, 1), (1, 0)] {
            self.corners.push(StripCorner {
                vertex: neighbours.corner(first.triangle, leaves + number),
                beside: told(first, leaves + beside),
            });
        }
        for step in others {
            let Some(enters) = step.enters else { continue };
            if step
                .turn()
                .is_some_and(|turn| turn != self.free_turn(start))
            {
                let again = self.corners[self.corners.len() - 2].vertex;
                self.push_corner(again, again, again);
            }
            // The side by which a strip goes on, and the one that it passes by.
            let leaves = enters + self.free_turn(start);
            let passed = enters + 3 - self.free_turn(start);
            let vertex = neighbours.corner(step.triangle, enters + 2);
            self.push_corner(vertex, told(step, passed), told(step, leaves));
        }
        self.ends.push(self.corners.len());
    }

    /// - `passed`: what is told across the side that the new triangle has beside the strip
    /// - `ahead`: and across the one by which the strip would go on
    fn push_corner(&mut self, vertex: u32, passed: u32, ahead: u32) {
        if let Some(last) = self.corners.last_mut() {
            last.beside = passed;
        }
        self.corners.push(StripCorner {
            vertex,
            beside: ahead,
        });
    }

    /// Which turn the next triangle of the strip that begins at `start` makes by itself.
    fn free_turn(&self, start: usize) -> usize {
        if (self.corners.len() - start).is_multiple_of(2) {
            EVEN_TURN
        } else {
            ODD_TURN
        }
    }
}

/// Sides from the one a path comes in by to the one it leaves by, in the first, third, … triangle of
/// a strip.
const EVEN_TURN: usize = 1;

/// The same in the second, fourth, …
const ODD_TURN: usize = 2;

/// A triangle of a path.
#[derive(Debug, Clone, Copy)]
struct Step {
    triangle: usize,
    enters: Option<usize>,
    leaves: Option<usize>,
}

impl Step {
    fn turn(&self) -> Option<usize> {
        Some((self.leaves? + 3 - self.enters?) % 3)
    }
}

/// How the path through a triangle goes on towards the root of its tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Upward {
    /// The triangle is the path's end.
    Ends,
    /// The path comes from a child, with this turn.
    Turns(u8),
    /// It does not.
    Closed,
}

impl Upward {
    const OPEN: [Self; 3] = [Self::Ends, Self::Turns(1), Self::Turns(2)];

    fn place(self) -> usize {
        match self {
            Self::Ends => 0,
            Self::Turns(turn) => usize::from(turn),
            Self::Closed => 3,
        }
    }
}

/// Children that a triangle's path goes to: across which side, and how their paths come up to it.
type Joined = [Option<(usize, Upward)>; 2];

/// No child lies across a side.
const NO_CHILD: u32 = u32::MAX;

/// A triangle has no side towards the root: it is one.
const ROOT: u8 = 3;

/// Numbers of sides in a byte.
const SIDES: [u8; 3] = [0, 1, 2];

/// More than any mesh costs.
const NEVER: u32 = u32::MAX / 2;

/// A tree over the triangles that a mesh's neighbourhood joins, or several.
#[derive(Debug)]
struct Forest {
    /// Parents before children.
    order: Vec<u32>,
    /// By triangle, the side towards the root; 3 of a root.
    parent_side: Vec<u8>,
    /// By triangle and side, the child across, or [`NO_CHILD`].
    children: Vec<[u32; 3]>,
    /// By triangle and [`Upward::place`], the cost of the paths from there on downwards. One that
    /// goes on upwards is counted where it ends.
    costs: Vec<[u32; 4]>,
}

impl Forest {
    fn over(neighbours: &Neighbours<'_>) -> Self {
        let count = neighbours.triangles.len();
        let mut forest = Self {
            order: Vec::with_capacity(count),
            parent_side: vec![ROOT; count],
            children: vec![[NO_CHILD; 3]; count],
            costs: vec![[0; 4]; count],
        };
        let mut is_reached = vec![false; count];
        // A triangle that was reached, its side, and that of the triangle before it.
        let mut waiting: Vec<(Side, Side)> = Vec::new();
        for root in 0..count {
            if is_reached[root] {
                continue;
            }
            let mut next = Some(root);
            while let Some(triangle) = next {
                is_reached[triangle] = true;
                forest.order.push(index_u32(triangle));
                for number in 0..3 {
                    let side = Side { triangle, number };
                    let back = neighbours.beyond(side);
                    waiting.extend(
                        back.filter(|back| !is_reached[back.triangle])
                            .map(|back| (back, side)),
                    );
                }
                next = None;
                while let Some((back, side)) = waiting.pop() {
                    if !is_reached[back.triangle] {
                        forest.parent_side[back.triangle] = SIDES[back.number];
                        forest.children[side.triangle][side.number] = index_u32(back.triangle);
                        next = Some(back.triangle);
                        break;
                    }
                }
            }
        }
        forest.settle_costs();
        forest
    }

    fn settle_costs(&mut self) {
        for place in (0..self.order.len()).rev() {
            let triangle = self.order[place] as usize;
            self.costs[triangle] = self.least_costs(triangle);
        }
    }

    /// Costs of [`Links::best`] by [`Upward::place`], without the ways to come by them: most triangles are
    /// asked for one way only, and all for their costs.
    fn least_costs(&self, triangle: usize) -> [u32; 4] {
        let mut apart = 0;
        // By side: what the child's path costs less its own when closed, whatever this triangle's turn,
        // with a turn of 1, and with one of 2.
        let mut joined: [Option<[i64; 3]>; 3] = [None; 3];
        for (side, joined) in joined.iter_mut().enumerate() {
            let Some(child) = self.child(triangle, side) else {
                continue;
            };
            let [ends, first, second, closed] = self.costs[child];
            apart += closed;
            *joined = Some(
                [
                    ends.min(first).min(second),
                    ends.min(first + 1).min(second),
                    ends.min(first).min(second + 1),
                ]
                .map(|cost| i64::from(cost) - i64::from(closed)),
            );
        }
        let with = |gain: i64| u32::try_from(i64::from(apart) + gain).unwrap_or(NEVER);
        let mut closed = 0;
        for side in 0..3 {
            let Some([alone, turns, _]) = joined[side] else {
                continue;
            };
            closed = closed.min(alone);
            if let Some([_, _, back]) = joined[(side + 1) % 3] {
                closed = closed.min(turns + back);
            }
        }
        let turned = |turn: usize| {
            let parent = self.parent_side(triangle)?;
            Some(with(joined[(parent + 3 - turn) % 3]?[turn]))
        };
        [
            apart,
            turned(1).unwrap_or(NEVER),
            turned(2).unwrap_or(NEVER),
            with(closed) + STRIP_COST,
        ]
    }

    fn child(&self, triangle: usize, number: usize) -> Option<usize> {
        let child = self.children[triangle][number];
        (child != NO_CHILD).then_some(child as usize)
    }

    fn parent_side(&self, triangle: usize) -> Option<usize> {
        let side = self.parent_side[triangle];
        (side != ROOT).then_some(usize::from(side))
    }

    /// What lies below a triangle.
    fn links(&self, triangle: usize) -> Links {
        let link = |side: usize| {
            let costs = self.costs[self.child(triangle, side)?];
            Some(Link { side, costs })
        };
        Links {
            parent_side: self.parent_side(triangle),
            links: [link(0), link(1), link(2)],
        }
    }
}

/// A child of a triangle.
#[derive(Debug, Clone, Copy)]
struct Link {
    /// Of the triangle, which the child lies across.
    side: usize,
    /// See [`Forest::costs`].
    costs: [u32; 4],
}

impl Link {
    fn closed(&self) -> u32 {
        self.costs[Upward::Closed.place()]
    }

    /// Its path, going on with this turn of the triangle's own, if that is a turn.
    fn joined(&self, turn: Option<u8>) -> (u32, Upward) {
        let cost = |way: Upward| {
            let repeats = turn.is_some_and(|turn| way == Upward::Turns(turn));
            (self.costs[way.place()] + u32::from(repeats), way)
        };
        let [first, others @ ..] = Upward::OPEN.map(cost);
        let lower =
            |best: (u32, Upward), other: (u32, Upward)| if other.0 < best.0 { other } else { best };
        others.into_iter().fold(first, lower)
    }
}

/// A triangle's children, by side.
struct Links {
    parent_side: Option<usize>,
    links: [Option<Link>; 3],
}

impl Links {
    /// The cheapest way to join the triangle with its children, and what it costs.
    fn best(&self, upward: Upward) -> (u32, Joined) {
        let apart: u32 = self.links.iter().flatten().map(Link::closed).sum();
        match (upward, self.parent_side) {
            (Upward::Ends, _) => (apart, [None, None]),
            (Upward::Turns(turn), Some(parent)) => {
                let Some(link) = &self.links[(parent + 3 - usize::from(turn)) % 3] else {
                    return (NEVER, [None, None]);
                };
                let (cost, way) = link.joined(Some(turn));
                (apart - link.closed() + cost, [Some((link.side, way)), None])
            }
            (Upward::Turns(_), None) => (NEVER, [None, None]),
            (Upward::Closed, _) => {
                let mut best = (apart, [None, None]);
                for link in self.links.iter().flatten() {
                    let (cost, way) = link.joined(None);
                    let alone = apart - link.closed() + cost;
                    if alone < best.0 {
                        best = (alone, [Some((link.side, way)), None]);
                    }
                    let Some(next) = &self.links[(link.side + 1) % 3] else {
                        continue;
                    };
                    // From this side to the next is a turn of 1, and back one of 2.
                    let [one, other] = [link.joined(Some(1)), next.joined(Some(2))];
                    let both = apart - link.closed() - next.closed() + one.0 + other.0;
                    if both < best.0 {
                        best = (both, [Some((link.side, one.1)), Some((next.side, other.1))]);
                    }
                }
                (best.0 + STRIP_COST, best.1)
            }
        }
    }
}

/// The paths.
#[derive(Debug)]
struct Paths {
    /// By triangle and side, whether the path goes on across it.
    goes_on: Vec<[bool; 3]>,
    /// By triangle, the one of its path that is nearest to the root.
    top: Vec<u32>,
    /// Of all paths together, as [`Forest::costs`] count.
    cost: u32,
}

impl Paths {
    fn over(neighbours: &Neighbours<'_>) -> Self {
        let forest = Forest::over(neighbours);
        let mut paths = Self {
            goes_on: vec![[false; 3]; neighbours.triangles.len()],
            top: (0..neighbours.triangles.len()).map(index_u32).collect(),
            cost: 0,
        };
        let mut upward = vec![Upward::Closed; neighbours.triangles.len()];
        for triangle in forest.order.iter().map(|triangle| *triangle as usize) {
            if forest.parent_side(triangle).is_none() {
                paths.cost += forest.costs[triangle][Upward::Closed.place()];
            }
            if upward[triangle] == Upward::Ends {
                continue;
            }
            let (_, joined) = forest.links(triangle).best(upward[triangle]);
            for (side, way) in joined.into_iter().flatten() {
                paths.goes_on[triangle][side] = true;
                if let Some(child) = forest.child(triangle, side) {
                    upward[child] = way;
                    paths.top[child] = paths.top[triangle];
                    if let Some(back) = forest.parent_side(child) {
                        paths.goes_on[child][back] = true;
                    }
                }
            }
        }
        paths
    }

    /// What their strips come to without writing them. A corner is said again where a path turns the
    /// same way twice, which the cost counts, and where its first turn is free from neither end
    /// ([`Strips::push`]).
    fn count(&self, neighbours: &Neighbours<'_>) -> StripCounts {
        let triangles = self.goes_on.len();
        // By the top of a path, whether its first turn is free from either end; none without turns.
        let mut is_free: Vec<Option<bool>> = vec![None; triangles];
        for triangle in (0..triangles).filter(|&triangle| self.ends_at(triangle)) {
            let Some(number) = (0..3).find(|&side| self.goes_on[triangle][side]) else {
                continue;
            };
            let second = neighbours.beyond(Side { triangle, number });
            let turn = second.and_then(|enters| {
                let goes_on = self.goes_on[enters.triangle];
                let mut turns = [EVEN_TURN, ODD_TURN].into_iter();
                turns.find(|turn| goes_on[(enters.number + turn) % 3])
            });
            let path = &mut is_free[self.top[triangle] as usize];
            if let Some(turn) = turn {
                *path = Some(turn == ODD_TURN || *path == Some(true));
            }
        }
        let is_top = |&triangle: &usize| self.top[triangle] as usize == triangle;
        let strips = (0..triangles).filter(is_top).count();
        let not_free = is_free.iter().filter(|path| **path == Some(false)).count();
        StripCounts {
            triangles,
            strips,
            repeated: self.cost as usize - STRIP_COST as usize * strips + not_free,
        }
    }

    fn ends_at(&self, triangle: usize) -> bool {
        self.goes_on[triangle].iter().filter(|&&on| on).count() < 2
    }

    /// The path with an end at `triangle`, from there on.
    fn walk(&self, neighbours: &Neighbours<'_>, triangle: usize, path: &mut Vec<Step>) {
        path.clear();
        let mut next = Some((triangle, None));
        while let Some((triangle, enters)) = next {
            let mut sides = (0..3).filter(|&side| self.goes_on[triangle][side]);
            let leaves = sides.find(|&side| Some(side) != enters);
            path.push(Step {
                triangle,
                enters,
                leaves,
            });
            next = leaves.and_then(|number| {
                let back = neighbours.beyond(Side { triangle, number })?;
                Some((back.triangle, Some(back.number)))
            });
        }
    }
}

#[cfg(test)]
mod tests;
