// SPDX-License-Identifier: MIT OR Apache-2.0
//! Edges that must stay: lines between two vertices. They are put in by flipping what they cross out of the way (Sloan
//! 1993, "A fast algorithm for generating constrained Delaunay triangulations").

use super::{Blocked, CONSTRAINT, Delaunay, NONE, ODD, Point, orient};
use std::collections::VecDeque;

impl Delaunay {
    /// Makes a constraint of the line between two vertices, or one more of those that run there.
    /// Where the line passes exactly through vertices it becomes several edges.
    ///
    /// # Errors
    /// [`Blocked::Crossing`] if it crosses another constraint; some of it may be in place then.
    pub fn constrain(&mut self, from: u32, to: u32) -> Result<(), Blocked> {
        let (mut from, mut to) = (from, to);
        while from != to {
            let next = match self.edge_between(from, to) {
                Ok((triangle, i)) => {
                    self.toggle(triangle, i);
                    return Ok(());
                }
                Err(end) if end == from => self.clear_way(from, to)?,
                Err(_) => {
                    std::mem::swap(&mut from, &mut to);
                    self.clear_way(from, to)?
                }
            };
            let edge = self.edge_between(from, next);
            let (triangle, i) = edge.or(Err(Blocked::Endless))?;
            self.toggle(triangle, i);
            self.touches |= next != to;
            from = next;
        }
        Ok(())
    }

    fn toggle(&mut self, triangle: u32, i: usize) {
        let across = self.triangles[triangle as usize].neighbours[i];
        let sides = [(triangle, across), (across, triangle)];
        for (side, other) in sides.into_iter().filter(|(side, _)| *side != NONE) {
            let side = &mut self.triangles[side as usize];
            let i = side.index_of_neighbour(other);
            side.marks[i] = (side.marks[i] ^ ODD) | CONSTRAINT;
        }
    }

    /// First vertex on the line from `from` to `to`, and the edges crossed on the way to it.
    fn first_vertex_along(&self, from: u32, to: u32) -> Result<(u32, Vec<[u32; 2]>), Blocked> {
        let [start, end] = [from, to].map(|end| self.point(end));
        let side = |vertex: u32| orient(start, end, self.point(vertex));
        let mut found = None;
        for (triangle, i) in self.edges_at(from) {
            // The edge runs between `from` and the corner after it; opposite `from` is the next.
            let [_, right] = self.ends(triangle, i);
            let left = self.corners(triangle)[i];
            let right_side = side(right);
            if right_side == 0.0 && is_ahead(start, end, self.point(right)) {
                return Ok((right, Vec::new()));
            }
            if right_side < 0.0 && side(left) > 0.0 {
                found = Some((triangle, (i + 1) % 3, right, left));
                break;
            }
        }
        let (mut triangle, mut i, mut right, mut left) = found.ok_or(Blocked::Endless)?;
        let mut crossed = Vec::new();
        loop {
            if self.is_constraint(triangle, i) {
                return Err(Blocked::Crossing);
            }
            crossed.push([right, left]);
            let across = self.neighbour(triangle, i).ok_or(Blocked::Endless)?;
            let there = &self.triangles[across as usize];
            let j = there.index_of_neighbour(triangle);
            let apex = there.corners[j];
            let apex_side = if apex == to { 0.0 } else { side(apex) };
            if apex_side == 0.0 {
                return Ok((apex, crossed));
            }
            // `there` is apex, left, right from `j` on.
            triangle = across;
            if apex_side > 0.0 {
                left = apex;
                i = (j + 1) % 3;
            } else {
                right = apex;
                i = (j + 2) % 3;
            }
        }
    }

    /// Flips what is between `from` and the first vertex on the way to `to` out of the way (Sloan
    /// 1993), then makes the new edges Delaunay; returns that vertex.
    fn clear_way(&mut self, from: u32, to: u32) -> Result<u32, Blocked> {
        let (to, crossed) = self.first_vertex_along(from, to)?;
        let [start, end] = [from, to].map(|end| self.point(end));
        // Every edge is looked at again at most once for each of the others.
        let mut left = 64 + 8 * crossed.len() * crossed.len();
        let mut waiting: VecDeque<[u32; 2]> = crossed.into();
        let mut fresh = Vec::with_capacity(waiting.len());
        while let Some([u, v]) = waiting.pop_front() {
            left = left.checked_sub(1).ok_or(Blocked::Endless)?;
            let (triangle, i) = self.edge_between(u, v).or(Err(Blocked::Endless))?;
            let [p, d] = self.opposite(triangle, i).ok_or(Blocked::Endless)?;
            let [b, c] = self.ends(triangle, i);
            let [pp, pb, pc, pd] = [p, b, c, d].map(|k| self.point(k));
            if orient(pp, pb, pd) <= 0.0 || orient(pp, pd, pc) <= 0.0 {
                waiting.push_back([u, v]);
                continue;
            }
            self.flip(triangle, i);
            let ends = [p, d];
            let touches = ends.contains(&from) || ends.contains(&to);
            if !touches && (orient(start, end, pp) < 0.0) != (orient(start, end, pd) < 0.0) {
                waiting.push_back(ends);
            } else {
                fresh.push(ends);
            }
        }
        while let Some([u, v]) = fresh.pop() {
            if [u, v] == [from, to] || [u, v] == [to, from] {
                continue;
            }
            let Ok((triangle, i)) = self.edge_between(u, v) else {
                continue;
            };
            if self.is_certainly_illegal(triangle, i) {
                let [p, d] = self.opposite(triangle, i).ok_or(Blocked::Endless)?;
                self.flip(triangle, i);
                fresh.extend([[p, u], [u, d], [d, v], [v, p]]);
            }
        }
        Ok(to)
    }
}

/// Whether `point`, on the line from `start` to `end`, is on the far side of `start`.
fn is_ahead(start: Point, end: Point, point: Point) -> bool {
    let axis = usize::from(start[0] == end[0]);
    (point[axis] > start[axis]) == (end[axis] > start[axis])
}
