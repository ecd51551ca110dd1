// SPDX-License-Identifier: MIT OR Apache-2.0
//! A quadtree of pages that splits and merges by pixels of its leaves: counted ones, or what distance predicts.
//!
//! A leaf splits where it has more pixels than texels by √hysteresis, and four merge where all have fewer by as much.
//! The paper has both thresholds and prints neither.

use crate::texture::{PAGE, Page};
use std::collections::BTreeSet;

/// A tree over a texture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Quadtree {
    leaves: BTreeSet<Page>,
    finest: u32,
}

impl Quadtree {
    /// One leaf.
    ///
    /// - `finest`: splits end at this level
    pub(crate) fn new(finest: u32) -> Self {
        Self {
            leaves: BTreeSet::from([Page::ROOT]),
            finest,
        }
    }

    /// Its leaves, level by level.
    pub(crate) fn leaves(&self) -> impl Iterator<Item = Page> + Clone {
        self.leaves.iter().copied()
    }

    /// Splits and merges once.
    ///
    /// - `pixels`: of a leaf; `None` where it may not act yet
    /// - `hysteresis`: pixels at which a leaf splits over those at which it merges
    /// - returns: whether anything changed
    pub(crate) fn update(&mut self, pixels: impl Fn(Page) -> Option<f64>, hysteresis: f64) -> bool {
        let texels = f64::from(PAGE * PAGE);
        let [low, high] = [texels / hysteresis.sqrt(), texels * hysteresis.sqrt()];
        let mut splits = Vec::new();
        let mut merges = Vec::new();
        for &page in &self.leaves {
            let Some(own) = pixels(page) else { continue };
            if own > high && page.level < self.finest {
                splits.push(page);
            } else if page.x % 2 == 0
                && page.y % 2 == 0
                && let Some(parent) = page.parent()
            {
                let is_low = |one| pixels(one).is_some_and(|pixels| pixels < low);
                let mut four = parent.children().into_iter();
                if four.all(|one| self.leaves.contains(&one) && is_low(one)) {
                    merges.push(parent);
                }
            }
        }
        let changes = !(splits.is_empty() && merges.is_empty());
        for page in splits {
            self.leaves.remove(&page);
            self.leaves.extend(page.children());
        }
        for parent in merges {
            for one in parent.children() {
                self.leaves.remove(&one);
            }
            self.leaves.insert(parent);
        }
        changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_split_above_the_upper_threshold_and_merge_below_the_lower_one() {
        let texels = f64::from(PAGE * PAGE);
        let mut tree = Quadtree::new(2);
        let mut all = |pixels: f64| {
            let changes = tree.update(|_| Some(pixels), 4.0);
            (changes, tree.leaves().count())
        };
        assert_eq!(all(1.9 * texels), (false, 1));
        assert_eq!(all(2.1 * texels), (true, 4));
        assert_eq!(all(2.1 * texels), (true, 16));
        assert_eq!(all(2.1 * texels), (false, 16), "the finest level");
        assert_eq!(all(0.6 * texels), (false, 16));
        assert_eq!(all(0.4 * texels), (true, 4));
        // A leaf that has no count of its own keeps its parent's quarters.
        let known = |page: Page| (page.x == 0).then_some(0.0);
        assert!(!tree.update(known, 4.0));
        // Negative control: at a hysteresis of 1 the same pixels split and merge.
        let mut tree = Quadtree::new(2);
        let shared = |page: Page| Some(1.5 * texels / f64::from(1_u32 << (2 * page.level)));
        assert!(tree.update(shared, 1.0) && tree.update(shared, 1.0));
        assert_eq!(tree.leaves().count(), 1);
        assert!(!Quadtree::new(2).update(shared, 4.0));
    }
}
