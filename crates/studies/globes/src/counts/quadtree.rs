// SPDX-License-Identifier: MIT OR Apache-2.0
//! A quadtree over one large picture whose nodes split and merge by their counted pixels.
//!
//! A node draws its whole area with one texture of a fixed size. It splits where its pixels over its texels are
//! more than the upper threshold, and four leaves merge where all of them are below the lower one. A node acts on
//! counts taken since it exists only. (Gebbie and Bailey, "Fast Realistic Rendering of Global Worlds using
//! Programmable Graphics Hardware", print neither thresholds nor gains.)

use std::collections::BTreeSet;

/// Level, column, row.
pub(crate) type Node = (u32, usize, usize);

/// A quadtree that splits and merges by counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Quadtree {
    leaves: BTreeSet<Node>,
    max_level: u32,
}

/// When a quadtree splits and merges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Thresholds {
    /// Four leaves merge where all have fewer pixels.
    pub(crate) low: f64,
    /// A leaf splits where it has more.
    pub(crate) high: f64,
}

impl Thresholds {
    /// About the texels of a node.
    ///
    /// - `hysteresis`: the upper threshold of pixels per texel over the lower one, which is 1/√hysteresis
    pub(crate) fn new(texels: f64, hysteresis: f64) -> Self {
        Self {
            low: texels / hysteresis.sqrt(),
            high: texels * hysteresis.sqrt(),
        }
    }
}

impl Quadtree {
    /// One node.
    ///
    /// - `max_level`: splits end there
    pub(crate) fn new(max_level: u32) -> Self {
        Self {
            leaves: BTreeSet::from([(0, 0, 0)]),
            max_level,
        }
    }

    /// Its leaves, sorted.
    pub(crate) fn leaves(&self) -> impl Iterator<Item = Node> {
        self.leaves.iter().copied()
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.leaves.len()
    }

    /// Splits and merges once.
    ///
    /// - `pixels`: counted of a leaf; `None` where none was counted since it exists, so that it may not act
    /// - `max_changes`: at most so many splits and merges, those with the most pixels first among the splits
    /// - returns: nodes that are new, which need their picture
    pub(crate) fn update(
        &mut self,
        pixels: impl Fn(Node) -> Option<f64>,
        thresholds: Thresholds,
        max_changes: usize,
    ) -> Vec<Node> {
        let mut splits: Vec<(f64, Node)> = Vec::new();
        let mut merges: Vec<Node> = Vec::new();
        for &node in &self.leaves {
            let (level, column, row) = node;
            let Some(own) = pixels(node) else { continue };
            if own > thresholds.high && level < self.max_level {
                splits.push((own, node));
            } else if level > 0 && column % 2 == 0 && row % 2 == 0 {
                let parent = (level - 1, column / 2, row / 2);
                let is_low = |one| pixels(one).is_some_and(|pixels| pixels < thresholds.low);
                let mut siblings = children(parent).into_iter();
                if siblings.all(|one| self.leaves.contains(&one) && is_low(one)) {
                    merges.push(parent);
                }
            }
        }
        splits.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut new = Vec::new();
        for (_, node) in splits.into_iter().take(max_changes) {
            self.leaves.remove(&node);
            new.extend(children(node));
        }
        let left = max_changes - (new.len() / 4).min(max_changes);
        for parent in merges.into_iter().take(left) {
            for one in children(parent) {
                self.leaves.remove(&one);
            }
            new.push(parent);
        }
        self.leaves.extend(&new);
        new
    }
}

/// The four parts of a node.
pub(crate) fn children((level, column, row): Node) -> [Node; 4] {
    [(0, 0), (1, 0), (0, 1), (1, 1)]
        .map(|(east, north)| (level + 1, 2 * column + east, 2 * row + north))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leaf_acts_on_its_own_count_alone_and_changes_are_capped() {
        let thresholds = Thresholds::new(100.0, 4.0);
        let mut tree = Quadtree::new(3);
        assert!(tree.update(|_| None, thresholds, 9).is_empty());
        assert_eq!(tree.update(|_| Some(201.0), thresholds, 9).len(), 4);
        // Two of the four want to split, one may: that with the most pixels.
        let counted = |node: Node| {
            Some(if node.1 == 1 {
                300.0 + node.2 as f64
            } else {
                150.0
            })
        };
        let new = tree.update(counted, thresholds, 1);
        assert!(new.len() == 4 && new.iter().all(|node| node.1 / 2 == 1 && node.2 / 2 == 1));
        assert_eq!(tree.count(), 7);
        // Negative control: with nothing allowed nothing changes; below the lower threshold four merge.
        assert!(tree.update(|_| Some(201.0), thresholds, 0).is_empty());
        assert_eq!(tree.update(|_| Some(49.0), thresholds, 9), [(1, 1, 1)]);
        assert_eq!(tree.update(|_| Some(49.0), thresholds, 9), [(0, 0, 0)]);
    }
}
