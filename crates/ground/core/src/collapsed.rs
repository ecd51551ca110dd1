// SPDX-License-Identifier: MIT OR Apache-2.0
//! Holes and parts that have no width: they cut nothing out or cover nothing, and are left out with a
//! warning.
//!
//! Degrees. Found are rings that only go there and back, and those whose vertices lie on one line,
//! exactly: whether a ring a rounding wide is one is for the triangulation to say.

use crate::edge::Degrees;
use crate::{EdgeRule, Polygon, Region, Ring, WarningSubject};
use terrafill_planar::intersection::{orient, without_underflow};

impl Region {
    /// The region without holes that have no width, and without parts of which the shell has none beside
    /// others that have one; `None` where it has neither.
    pub(crate) fn without_collapsed(&self, rule: EdgeRule) -> Option<Self> {
        let is_collapsed = |ring: &Ring| is_collapsed(rule, ring);
        let has_area: Vec<bool> = self
            .polygons
            .iter()
            .map(|p| !is_collapsed(&p.shell))
            .collect();
        let any_area = has_area.contains(&true);
        let is_kept = |polygon: usize| has_area[polygon] || !any_area;
        let parts = (0..has_area.len()).filter(|i| !is_kept(*i)).count();
        let kept = || (0..).zip(&self.polygons).filter(|(i, _)| is_kept(*i));
        let of_kept = kept().flat_map(|(_, polygon)| &polygon.holes);
        let holes = of_kept.filter(|hole| is_collapsed(hole)).count();
        if holes + parts == 0 {
            return None;
        }
        let mut polygons = Vec::with_capacity(has_area.len());
        for (index, polygon) in kept() {
            let parts_before = index - polygons.len();
            let placed = |ring: &Ring| ring.clone().after_dropped_parts(parts_before);
            let mut dropped = 0;
            let mut kept_holes = Vec::with_capacity(polygon.holes.len());
            for hole in &polygon.holes {
                if is_collapsed(hole) {
                    dropped += 1;
                } else {
                    kept_holes.push(placed(hole).after_dropped(dropped));
                }
            }
            polygons.push(Polygon {
                shell: placed(&polygon.shell),
                holes: kept_holes,
            });
        }
        let mut region = Self {
            polygons,
            ..self.clone()
        };
        for (count, kind) in [(holes, "hole"), (parts, "part")] {
            let note = match count {
                0 => continue,
                1 => format!("1 {kind} without area was left out"),
                many => format!("{many} {kind}s without area were left out"),
            };
            region.warnings.push(WarningSubject::Reading.warn(note));
        }
        Some(region)
    }
}

fn is_collapsed(rule: EdgeRule, ring: &Ring) -> bool {
    if ring.winding_deg() != 0.0 {
        return false;
    }
    let vertices = ring.vertices_deg();
    let count = vertices.len();
    let at = |i: usize| vertices[i % count].map(without_underflow);
    let is_repeat_or_tip = |i: usize| at(i) == at(i + 1) || at(i) == at(i + 2);
    if (0..count).any(is_repeat_or_tip) {
        let left = without_tips((0..count).map(at));
        left.len() < 3 || is_on_one_line(rule, &left)
    } else {
        is_on_one_line(rule, vertices)
    }
}

/// What is left of a ring when repeats go, and every edge that leads straight back along the one before.
fn without_tips(vertices: impl Iterator<Item = Degrees>) -> Vec<Degrees> {
    let mut left: Vec<Degrees> = Vec::new();
    for vertex in vertices {
        if left.len() > 1 && left[left.len() - 2] == vertex {
            left.pop();
        } else if left.last() != Some(&vertex) {
            left.push(vertex);
        }
    }
    // The end goes on at the start.
    let mut start = 0;
    while left.len() - start > 2 {
        let (first, last) = (left[start], left[left.len() - 1]);
        if first == last || left[left.len() - 2] == first {
            left.pop();
        } else if left[start + 1] == last {
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
        // Two branches from one place, the second where the ring closes.
        let mut forked = [[0.0, 0.0], [4.0, -5.0], [0.0, 0.0], [-8.0, -8.0]];
        for _ in 0..forked.len() {
            assert!(
                BOTH.iter().all(|rule| is_dropped(*rule, &forked)),
                "{forked:?}"
            );
            forked.rotate_left(1);
        }
        let meridian = [[2.0, 2.0], [2.0, 4.0], [2.0, 6.0]];
        assert!(BOTH.iter().all(|rule| is_dropped(*rule, &meridian)));
        // On a line of the plane, which is none of great ellipses.
        let parallel = [[2.0, 2.0], [4.0, 2.0], [6.0, 2.0]];
        assert!(is_dropped(EdgeRule::Planar, &parallel));
        assert!(!is_dropped(EdgeRule::GreatEllipse, &parallel));
        // There and back by way of a place that is the same but for underflow.
        let underflown = [[0.0, 0.0], [4.0, -5.0], [-2.5e-323, 3.5e-323], [-8.0, -8.0]];
        assert!(is_dropped(EdgeRule::Planar, &underflown));
        // Negative controls: a last bit wide; with a tip, and something else; wide, and its first two
        // places the same but for underflow.
        let wide = [[0.0, 0.0], [1e-323, 0.0], [4.0, 0.0], [4.0, 3.0]];
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
            assert!(!is_dropped(rule, &wide));
        }
    }
}
