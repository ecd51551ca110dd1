// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which of many boxes overlap: a tree of boxes compared with itself.
//!
//! Any unit; planar users leave z at 0. Boxes are sorted by the cell that their middle lies in, in the order
//! of Morton (1966), in which all axes take turns. Long thin edges side by side, which defeat a sweep along
//! one axis, are told apart along the other. Nodes are halved where the highest bit of the cells' numbers
//! changes (Lauterbach et al., 2009, "Fast BVH construction on GPUs"). Boxes of one cell are halved at the
//! median of the longest axis, so that it does not matter how unevenly they lie. O(n log n) to build, and to compare O(n + pairs) where boxes are
//! not much larger than their distances.

use glam::DVec3;
use std::cell::Cell;
use std::ops::ControlFlow;

/// Boxes in a leaf: comparing this many pairwise costs about what one more level would.
const LEAF_SIZE: usize = 6;

/// Bits of a cell's number along each axis: three times as many fit into 64.
const CELL_BITS: u32 = 21;

/// A box along the axes; touching counts as overlapping.
#[derive(Debug, Clone, Copy)]
pub struct AxisBox {
    /// Least coordinates.
    pub low: DVec3,
    /// Greatest ones.
    pub high: DVec3,
}

impl AxisBox {
    /// Round planar places.
    pub fn of<const COUNT: usize>(places: [[f64; 2]; COUNT]) -> Self {
        let places = places.map(|[x, y]| DVec3::new(x, y, 0.0));
        Self {
            low: places.into_iter().fold(DVec3::INFINITY, DVec3::min),
            high: places.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max),
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    fn join(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
}

/// A tree over boxes.
pub struct BoxTree<'a> {
    boxes: &'a [AxisBox],
    /// Indices of boxes, leaf by leaf.
    order: Vec<usize>,
    nodes: Vec<Node>,
}

struct Node {
    bounds: AxisBox,
    /// Range of [`BoxTree::order`].
    first: usize,
    past: usize,
    /// The first child is the next node; this is the other one. `None` for a leaf.
    second_child: Option<usize>,
}

impl<'a> BoxTree<'a> {
    /// Over these boxes, which are found by their indices.
    #[must_use]
    pub fn new(boxes: &'a [AxisBox]) -> Self {
        let cells = cells_of(boxes);
        let mut tree = Self {
            boxes,
            order: cells.iter().map(|(_, index)| *index as usize).collect(),
            nodes: Vec::with_capacity(2 * boxes.len().div_ceil(LEAF_SIZE / 2)),
        };
        if !boxes.is_empty() {
            tree.add_node(&cells, 0, boxes.len());
        }
        tree
    }

    /// - `cells`: of each place of [`BoxTree::order`], as it was at first
    fn add_node(&mut self, cells: &[(u64, u32)], first: usize, past: usize) -> usize {
        let at = self.nodes.len();
        self.nodes.push(Node {
            bounds: self.boxes[self.order[first]],
            first,
            past,
            second_child: None,
        });
        if past - first > LEAF_SIZE {
            let middle = match halved_by_cell(&cells[first..past]) {
                Some(middle) => first + middle,
                None => self.halve(first, past),
            };
            self.add_node(cells, first, middle);
            let second = self.add_node(cells, middle, past);
            let [left, right] = [at + 1, second].map(|child| self.nodes[child].bounds);
            self.nodes[at].bounds = left.join(right);
            self.nodes[at].second_child = Some(second);
        } else {
            let others = &self.order[first + 1..past];
            let own = self.nodes[at].bounds;
            self.nodes[at].bounds = others
                .iter()
                .fold(own, |sum, &index| sum.join(self.boxes[index]));
        }
        at
    }

    /// Sorts boxes of one cell into two halves, by the median of the axis along which their middles differ
    /// most; returns where the second one begins.
    fn halve(&mut self, first: usize, past: usize) -> usize {
        let range = &mut self.order[first..past];
        let twice_center = |i: usize| self.boxes[i].low + self.boxes[i].high;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &i in range.iter() {
            low = low.min(twice_center(i));
            high = high.max(twice_center(i));
        }
        let axis = (high - low).max_position();
        let middle = range.len() / 2;
        range.select_nth_unstable_by(middle, |&a, &b| {
            twice_center(a)[axis].total_cmp(&twice_center(b)[axis])
        });
        first + middle
    }

    /// Calls `visit` once for every two boxes that overlap, until it breaks.
    pub fn overlapping_pairs(
        &self,
        visit: &mut impl FnMut(usize, usize) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut waiting = Vec::new();
        if !self.nodes.is_empty() {
            waiting.push((0, 0));
        }
        while let Some((a, b)) = waiting.pop() {
            let (left, right) = (&self.nodes[a], &self.nodes[b]);
            if a != b && !left.bounds.overlaps(&right.bounds) {
                continue;
            }
            let left_is_larger = left.past - left.first >= right.past - right.first;
            match (left.second_child, right.second_child) {
                (None, None) => self.compare_leaves(left, right, a == b, visit)?,
                (Some(second), _) if a == b => {
                    waiting.extend([(a + 1, a + 1), (second, second), (a + 1, second)]);
                }
                (Some(_), Some(second)) if !left_is_larger => {
                    waiting.extend([(a, b + 1), (a, second)]);
                }
                (Some(second), _) => waiting.extend([(a + 1, b), (second, b)]),
                (None, Some(second)) => waiting.extend([(a, b + 1), (a, second)]),
            }
        }
        ControlFlow::Continue(())
    }

    /// Calls `visit` with each box that `may_meet` holds for, as it does for those around it.
    pub fn visit(
        &self,
        may_meet: &mut impl FnMut(&AxisBox) -> bool,
        visit: &mut impl FnMut(usize),
    ) {
        let mut waiting = Vec::new();
        if !self.nodes.is_empty() {
            waiting.push(0);
        }
        while let Some(at) = waiting.pop() {
            let node = &self.nodes[at];
            if !may_meet(&node.bounds) {
                continue;
            }
            if let Some(second) = node.second_child {
                waiting.extend([at + 1, second]);
                continue;
            }
            for &index in &self.order[node.first..node.past] {
                if may_meet(&self.boxes[index]) {
                    visit(index);
                }
            }
        }
    }

    /// Whether any box overlaps another one.
    pub fn meets(&self, other: &AxisBox) -> bool {
        let found = Cell::new(false);
        self.visit(
            &mut |bounds| !found.get() && bounds.overlaps(other),
            &mut |_| found.set(true),
        );
        found.get()
    }

    fn compare_leaves(
        &self,
        left: &Node,
        right: &Node,
        same: bool,
        visit: &mut impl FnMut(usize, usize) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        for at in left.first..left.past {
            let i = self.order[at];
            let from = if same { at + 1 } else { right.first };
            for &j in &self.order[from..right.past] {
                if self.boxes[i].overlaps(&self.boxes[j]) {
                    visit(i.min(j), i.max(j))?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// Of each box the number of its cell, and its index; in this order.
#[allow(
    clippy::cast_possible_truncation,
    reason = "places are between 0 and 2²¹, and edges fewer than 2³²"
)]
fn cells_of(boxes: &[AxisBox]) -> Vec<(u64, u32)> {
    let twice_centers = || boxes.iter().map(|own| own.low + own.high);
    let (low, high) = twice_centers()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
    let last = f64::from((1_u32 << CELL_BITS) - 1);
    // Where an axis has no extent all lie in its first cell: what is not a number becomes 0.
    let scale = last / (high - low);
    let cell = |at: DVec3| {
        let place = ((at - low) * scale).clamp(DVec3::ZERO, DVec3::splat(last));
        place
            .to_array()
            .into_iter()
            .zip(0..)
            .fold(0, |cell, (along, axis)| cell | spread(along as u64) << axis)
    };
    let mut cells: Vec<(u64, u32)> = twice_centers().map(cell).zip(0..).collect();
    cells.sort_unstable();
    cells
}

/// Bits of a number with two zeros before each.
fn spread(number: u64) -> u64 {
    let doubled: [(u32, u64); 5] = [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ];
    let twice = |number: u64, (shift, mask)| (number | number << shift) & mask;
    doubled.into_iter().fold(number, twice)
}

/// Where the largest cell that holds all of these is halved; `None` where they lie in one cell.
fn halved_by_cell(cells: &[(u64, u32)]) -> Option<usize> {
    let [(first, _), .., (last, _)] = cells else {
        return None;
    };
    let highest = (first ^ last).checked_ilog2()?;
    Some(cells.partition_point(|(cell, _)| cell >> highest & 1 == 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(boxes: &[AxisBox]) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        let tree = BoxTree::new(boxes);
        let end = tree.overlapping_pairs(&mut |a, b| {
            found.push((a, b));
            ControlFlow::Continue(())
        });
        assert_eq!(end, ControlFlow::Continue(()));
        found.sort_unstable();
        found
    }

    fn slow_pairs(boxes: &[AxisBox]) -> Vec<(usize, usize)> {
        let all = (0..boxes.len()).flat_map(|a| (a + 1..boxes.len()).map(move |b| (a, b)));
        all.filter(|&(a, b)| boxes[a].overlaps(&boxes[b])).collect()
    }

    fn random_boxes(count: u32, size: DVec3) -> Vec<AxisBox> {
        let mut state = 3_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..count)
            .map(|_| {
                let low = DVec3::new(random(), random(), random());
                let high = low + size * DVec3::new(random(), random(), random());
                AxisBox { low, high }
            })
            .collect()
    }

    #[test]
    fn every_overlapping_pair_is_found_once() {
        for size in [
            DVec3::splat(0.1),
            DVec3::splat(0.9),
            DVec3::new(1.0, 1e-3, 1.0),
            DVec3::ZERO,
        ] {
            for count in [0, 1, 2, 6, 7, 50, 300] {
                let boxes = random_boxes(count, size);
                assert_eq!(pairs(&boxes), slow_pairs(&boxes), "{count} of {size}");
            }
        }
        // Next to one that is far away they share a cell.
        for far in [1e9, f64::INFINITY, f64::MAX] {
            let mut boxes = random_boxes(60, DVec3::splat(0.1));
            boxes[17].high = DVec3::splat(far);
            boxes[18].low.x = -far;
            assert_eq!(pairs(&boxes), slow_pairs(&boxes), "{far}");
        }
        // Equal boxes cannot be told apart by any axis.
        let equal = vec![random_boxes(1, DVec3::ONE)[0]; 40];
        assert_eq!(pairs(&equal).len(), 40 * 39 / 2);
    }

    #[test]
    fn cells_are_in_the_order_in_which_axes_take_turns() {
        let at = |x: f64, y: f64| AxisBox::of([[x, y]]);
        let boxes = [at(1.0, 1.0), at(0.0, 1.0), at(1.0, 0.0), at(0.0, 0.0)];
        let cells = cells_of(&boxes);
        let order: Vec<u32> = cells.iter().map(|(_, index)| *index).collect();
        assert_eq!(order, [3, 2, 1, 0]);
        assert_eq!(halved_by_cell(&cells), Some(2));
        assert_eq!(halved_by_cell(&cells[2..]), Some(1));
        assert_eq!(spread(0b1011), 0b1_000_001_001);
        // Negative control: boxes in one cell have no halves.
        assert_eq!(halved_by_cell(&cells_of(&[at(1.0, 1.0); 9])), None);
    }

    #[test]
    fn a_visitor_can_stop_early() {
        let boxes = random_boxes(100, DVec3::ONE);
        let mut count = 0;
        let end = BoxTree::new(&boxes).overlapping_pairs(&mut |_, _| {
            count += 1;
            if count == 10 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        assert_eq!((end, count), (ControlFlow::Break(()), 10));
    }

    #[test]
    fn thin_boxes_side_by_side_do_not_cost_their_square() {
        // Teeth of a comb, whatever way they lie: the square would run into the test's time limit.
        for axis in 0..2 {
            let boxes: Vec<AxisBox> = (0..300_000)
                .map(|k| {
                    let mut low = DVec3::ZERO;
                    low[axis] = f64::from(k);
                    let mut high = low + DVec3::new(1e6, 1e6, 0.0);
                    high[axis] = f64::from(k) + 0.5;
                    AxisBox { low, high }
                })
                .collect();
            assert!(pairs(&boxes).is_empty());
        }
    }
}
