// SPDX-License-Identifier: MIT OR Apache-2.0
//! Holes that have no width: they cut nothing out, and are left out with a warning.
//!
//! Degrees. Found are holes that only go there and back, and those whose vertices lie on one line,
//! exactly: whether a hole a rounding wide is one is for the triangulation to say.

use crate::edge::Degrees;
use crate::intersection::{orient, without_underflow};
use crate::{EdgeRule, Polygon, Region, Ring};

impl Region {
    /// The region without holes that have no width; `None` where it has none.
    pub(crate) fn without_collapsed_holes(&self, rule: EdgeRule) -> Option<Self> {
        let is_collapsed = |ring: &Ring| is_collapsed(rule, ring);
        let holes = |polygon: &Polygon| {
            polygon
                .holes
                .iter()
                .filter(|hole| is_collapsed(hole))
                .count()
        };
        let count: usize = self.polygons.iter().map(holes).sum();
        if count == 0 {
            return None;
        }
        let mut region = self.clone();
        for polygon in &mut region.polygons {
            let mut dropped = 0;
            let mut kept = Vec::with_capacity(polygon.holes.len());
            for hole in polygon.holes.drain(..) {
                if is_collapsed(&hole) {
                    dropped += 1;
                } else {
                    kept.push(hole.after_dropped(dropped));
                }
            }
            polygon.holes = kept;
        }
        let holes = if count == 1 {
            "1 hole without area was"
        } else {
            &format!("{count} holes without area were")
        };
        region.warnings.push(format!("{holes} left out"));
        Some(region)
    }
}

fn is_collapsed(rule: EdgeRule, ring: &Ring) -> bool {
    if ring.winding_deg() != 0.0 {
        return false;
    }
    let vertices = ring.vertices_deg();
    let count = vertices.len();
    let is_tip = |i: usize| vertices[i] == vertices[(i + 2) % count];
    if (0..count).any(is_tip) {
        let left = without_tips(vertices);
        left.len() < 3 || is_on_one_line(rule, &left)
    } else {
        is_on_one_line(rule, vertices)
    }
}

/// What is left of a ring when every edge that leads straight back along the one before goes with it.
fn without_tips(vertices: &[Degrees]) -> Vec<Degrees> {
    let mut left: Vec<Degrees> = Vec::with_capacity(vertices.len());
    for vertex in vertices {
        if left.len() > 1 && left[left.len() - 2] == *vertex {
            left.pop();
        } else if left.last() != Some(vertex) {
            left.push(*vertex);
        }
    }
    // The end goes on at the start.
    let mut start = 0;
    while left.len() - start > 2 {
        let (first, last) = (left[start], left[left.len() - 1]);
        if first == last || left[start + 1] == last {
            left.pop();
        } else if left[left.len() - 2] == first {
            start += 1;
        } else {
            break;
        }
    }
    left.split_off(start)
}

fn is_on_one_line(rule: EdgeRule, vertices: &[Degrees]) -> bool {
    let [first, second, rest @ ..] = vertices else {
        return true;
    };
    match rule {
        EdgeRule::Planar => {
            let [first, second] = [first, second].map(|place| place.map(without_underflow));
            let side = |third: &Degrees| orient(first, second, third.map(without_underflow));
            rest.iter().all(|third| side(third) == 0.0)
        }
        // Of other great circles no three places are known to lie on one.
        EdgeRule::GreatEllipse => vertices.iter().all(|vertex| vertex[0] == first[0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_dropped(rule: EdgeRule, vertices: &[Degrees]) -> bool {
        is_collapsed(rule, &Ring::from_checked(vertices.to_vec(), 0.0))
    }

    #[test]
    fn holes_without_width_are_found_and_others_are_not() {
        const BOTH: [EdgeRule; 2] = [EdgeRule::Planar, EdgeRule::GreatEllipse];
        // There and back, with a branch, from any vertex.
        let mut branched = [
            [2.0, 2.0],
            [4.0, 2.0],
            [4.0, 3.0],
            [4.0, 2.0],
            [5.0, 1.0],
            [4.0, 2.0],
        ];
        for _ in 0..branched.len() {
            for rule in BOTH {
                assert!(is_dropped(rule, &branched), "{branched:?}");
            }
            branched.rotate_left(1);
        }
        let meridian = [[2.0, 2.0], [2.0, 4.0], [2.0, 6.0]];
        assert!(BOTH.iter().all(|rule| is_dropped(*rule, &meridian)));
        // On a line of the plane, which is none of great ellipses.
        let parallel = [[2.0, 2.0], [4.0, 2.0], [6.0, 2.0]];
        assert!(is_dropped(EdgeRule::Planar, &parallel));
        assert!(!is_dropped(EdgeRule::GreatEllipse, &parallel));
        // Negative controls: a last bit wide; with a tip, and something else.
        let hair = [[2.0, 2.0], [4.0, 2.0_f64.next_up()], [6.0, 2.0]];
        let tipped = [
            [2.0, 2.0],
            [4.0, 2.0],
            [4.0, 3.0],
            [2.0, 3.0],
            [2.0, 4.0],
            [2.0, 3.0],
        ];
        for rule in BOTH {
            assert!(!is_dropped(rule, &hair));
            assert!(!is_dropped(rule, &tipped));
        }
    }
}
