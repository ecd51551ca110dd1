// SPDX-License-Identifier: MIT OR Apache-2.0
//! A quadtree over one large picture whose nodes split and merge by their pixels.
//!
//! A node has its whole area as one texture of a fixed size. It splits where it has more pixels than the upper
//! threshold, and four leaves merge where all of them have fewer than the lower one. (Gebbie and Bailey, "Fast Realistic
//! Rendering of Global Worlds using Programmable Graphics Hardware", print neither thresholds nor gains.)

use std::collections::BTreeSet;

/// Level, column, row.
pub type Node = (u32, usize, usize);

/// A quadtree that splits and merges by pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quadtree {
    leaves: BTreeSet<Node>,
    max_level: u32,
}

/// When a quadtree splits and merges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thresholds {
    /// Four leaves merge where all have fewer pixels.
    pub low: f64,
    /// A leaf splits where it has more.
    pub high: f64,
}

impl Thresholds {
    /// About the texels of a node.
    ///
    /// - `hysteresis`: the upper threshold of pixels per texel over the lower one, which is 1/√hysteresis
    pub fn new(texels: f64, hysteresis: f64) -> Self {
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
    pub fn new(max_level: u32) -> Self {
        Self {
            leaves: BTreeSet::from([(0, 0, 0)]),
            max_level,
        }
    }

    /// Its leaves, sorted.
    pub fn leaves(&self) -> impl Iterator<Item = Node> {
        self.leaves.iter().copied()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.leaves.len()
    }

    /// Splits and merges once.
    ///
    /// - `pixels`: of a leaf; `None` where they are not known yet, so that it may not act
    /// - returns: whether anything changed
    pub fn update(&mut self, pixels: impl Fn(Node) -> Option<f64>, thresholds: Thresholds) -> bool {
        let mut splits: Vec<Node> = Vec::new();
        let mut merges: Vec<Node> = Vec::new();
        for &node in &self.leaves {
            let (level, column, row) = node;
            let Some(own) = pixels(node) else { continue };
            if own > thresholds.high && level < self.max_level {
                splits.push(node);
            } else if level > 0 && column % 2 == 0 && row % 2 == 0 {
                let parent = (level - 1, column / 2, row / 2);
                let is_low = |one| pixels(one).is_some_and(|pixels| pixels < thresholds.low);
                let mut siblings = children(parent).into_iter();
                if siblings.all(|one| self.leaves.contains(&one) && is_low(one)) {
                    merges.push(parent);
                }
            }
        }
        let changes = !(splits.is_empty() && merges.is_empty());
        for node in splits {
            self.leaves.remove(&node);
            self.leaves.extend(children(node));
        }
        for parent in merges {
            for one in children(parent) {
                self.leaves.remove(&one);
            }
            self.leaves.insert(parent);
        }
        changes
    }
}

/// The four parts of a node.
pub fn children((level, column, row): Node) -> [Node; 4] {
    [(0, 0), (1, 0), (0, 1), (1, 1)]
        .map(|(across, along)| (level + 1, 2 * column + across, 2 * row + along))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_split_above_the_upper_threshold_and_merge_below_the_lower_one() {
        let thresholds = Thresholds::new(100.0, 4.0);
        let mut tree = Quadtree::new(2);
        let mut all = |pixels: f64| {
            let changes = tree.update(|_| Some(pixels), thresholds);
            (changes, tree.count())
        };
        assert_eq!(all(199.0), (false, 1));
        assert_eq!(all(201.0), (true, 4));
        assert_eq!(all(201.0), (true, 16));
        assert_eq!(all(201.0), (false, 16), "the finest level");
        assert_eq!(all(51.0), (false, 16));
        assert_eq!(all(49.0), (true, 4));
        // A leaf without pixels of its own keeps its parent's quarters.
        let known = |node: Node| (node.1 == 0).then_some(0.0);
        assert!(!tree.update(known, thresholds));
        // Negative control: at a hysteresis of 1 the same pixels split and merge.
        let mut tree = Quadtree::new(2);
        let narrow = Thresholds::new(100.0, 1.0);
        let shared = |node: Node| Some(150.0 / f64::from(node.0).exp2().powi(2));
        assert!(tree.update(shared, narrow) && tree.update(shared, narrow));
        assert_eq!(tree.count(), 1);
        assert!(!Quadtree::new(2).update(shared, thresholds));
    }

    #[test]
    fn leaves_split_where_their_own_pixels_are() {
        let thresholds = Thresholds::new(100.0, 4.0);
        let mut tree = Quadtree::new(3);
        assert!(!tree.update(|_| None, thresholds));
        assert!(tree.update(|_| Some(201.0), thresholds));
        let one = |node: Node| {
            Some(if node.1 == 1 && node.2 == 1 {
                300.0
            } else {
                150.0
            })
        };
        assert!(tree.update(one, thresholds));
        let found: Vec<Node> = tree.leaves().collect();
        assert_eq!(found.len(), 7);
        assert!(
            found[3..]
                .iter()
                .all(|node| node.1 / 2 == 1 && node.2 / 2 == 1)
        );
    }
}
