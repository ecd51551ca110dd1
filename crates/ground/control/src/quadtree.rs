// SPDX-License-Identifier: MIT OR Apache-2.0
//! A quadtree over one large picture whose nodes split and merge by their counted pixels.
//!
//! A node draws its whole area with one texture of a fixed size. It splits where its pixels over its texels are
//! more than the upper threshold, and four leaves merge where all of them are below the lower one. A node acts on
//! counts taken since it exists only.

use std::collections::BTreeSet;

/// Cells of a side in which pixels are counted: leaves of the deepest level.
const SIDE: usize = 1 << MAX_LEVEL;
/// Splits end here.
const MAX_LEVEL: u32 = 7;

/// Level, column, row.
pub type Node = (u32, usize, usize);

/// How many pixels each part of a square of side 1 has in a view.
#[derive(Debug, Clone)]
pub struct QuadtreeView {
    /// Pixels of all cells left of and below a corner, row by row.
    sums: Vec<f64>,
}

/// What a quadtree does while the view stands still.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Settling {
    /// Leaves, frame by frame: the step response.
    pub leaves: Vec<usize>,
    /// Frames until nothing changes any more; `None` where it never ends.
    pub frames: Option<usize>,
}

impl QuadtreeView {
    /// Seen from a place over the square, whose pixels at a point are as many as its solid angle has.
    ///
    /// - `eye`: place over the square, and height over it, in its sides
    /// - `ahead`: horizontal part of the direction of view over its downward part
    /// - `pixels`: that an angle of 1 spans in the middle of a picture with a field of view of 60°
    #[must_use]
    pub fn new(eye: [f64; 3], ahead: [f64; 2], pixels: f64) -> Self {
        let side = SIDE + 1;
        let mut sums = vec![0.0; side * side];
        let length = (1.0 + ahead[0] * ahead[0] + ahead[1] * ahead[1]).sqrt();
        for row in 0..SIDE {
            for column in 0..SIDE {
                let [x, y] = [column, row].map(|at| (at as f64 + 0.5) / SIDE as f64);
                let (dx, dy) = (x - eye[0], y - eye[1]);
                let squared = dx * dx + dy * dy + eye[2] * eye[2];
                let along = (dx * ahead[0] + dy * ahead[1] + eye[2]) / length;
                let is_in_view = along > squared.sqrt() * 30_f64.to_radians().cos();
                let share = eye[2] / squared.powf(1.5) / (SIDE * SIDE) as f64;
                let here = if is_in_view {
                    pixels * pixels * share
                } else {
                    0.0
                };
                let at = (row + 1) * side + column + 1;
                sums[at] = here + sums[at - 1] + sums[at - side] - sums[at - side - 1];
            }
        }
        Self { sums }
    }

    /// One of many views that lie evenly among all, by multiples of powers of an irrational number (Roberts,
    /// 2018, "The unreasonable effectiveness of quasirandom sequences").
    #[must_use]
    pub fn numbered(number: u32) -> Self {
        // The root of x⁶ = x + 1.
        const ROOT: f64 = 1.134_724_138_401_519_4;
        let at = |power: i32| (f64::from(number + 1) * ROOT.powi(-power)).fract();
        let height = 0.05 * 100_f64.powf(at(3));
        let eye = [at(1), at(2), height];
        // Up to 60° from straight down; half of all views look straight down.
        let tilt = (2.0 * at(4) - 1.0).max(0.0) * 3_f64.sqrt();
        let (sine, cosine) = (at(5) * std::f64::consts::TAU).sin_cos();
        Self::new(eye, [tilt * cosine, tilt * sine], 1000.0)
    }

    fn pixels(&self, (level, column, row): Node) -> f64 {
        let side = SIDE + 1;
        let size = SIDE >> level;
        let at = |column: usize, row: usize| self.sums[row * side + column];
        let (west, south) = (column * size, row * size);
        let (east, north) = (west + size, south + size);
        at(east, north) - at(west, north) - at(east, south) + at(west, south)
    }
}

/// A quadtree that splits and merges by counts.
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
    #[must_use]
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
    #[must_use]
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
    #[must_use]
    pub fn count(&self) -> usize {
        self.leaves.len()
    }

    /// Splits and merges once.
    ///
    /// - `pixels`: counted of a leaf; `None` where none was counted since it exists, so that it may not act
    /// - `max_changes`: at most so many splits and merges, those with the most pixels first among the splits
    /// - returns: nodes that are new, which need their picture
    pub fn update(
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

/// Lets a quadtree that begins as one node come to rest in a view that stands still.
///
/// - `texels`: of a node's texture
/// - `hysteresis`: as [`Thresholds::new`]
#[must_use]
pub fn settle(view: &QuadtreeView, texels: f64, hysteresis: f64, frames: usize) -> Settling {
    let thresholds = Thresholds::new(texels, hysteresis);
    let mut tree = Quadtree::new(MAX_LEVEL);
    let mut counts = vec![1];
    let mut settled = None;
    for frame in 0..frames {
        let new = tree.update(|node| Some(view.pixels(node)), thresholds, usize::MAX);
        settled = match (new.is_empty(), settled) {
            (false, _) => None,
            (true, None) => Some(frame),
            (true, known) => known,
        };
        counts.push(tree.count());
    }
    Settling {
        leaves: counts,
        frames: settled,
    }
}

fn children((level, column, row): Node) -> [Node; 4] {
    [(0, 0), (1, 0), (0, 1), (1, 1)]
        .map(|(east, north)| (level + 1, 2 * column + east, 2 * row + north))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_has_the_pixels_of_its_children() {
        let view = QuadtreeView::new([0.3, 0.6, 0.4], [0.2, -0.1], 1000.0);
        let whole = view.pixels((0, 0, 0));
        let parts: f64 = children((0, 0, 0))
            .map(|node| view.pixels(node))
            .iter()
            .sum();
        assert!(
            (whole / parts - 1.0).abs() < 1e-12 && whole > 1e5,
            "{whole}"
        );
        // From far above, its solid angle is its side over the distance, squared.
        let far = QuadtreeView::new([0.5, 0.5, 50.0], [0.0; 2], 1000.0).pixels((0, 0, 0));
        assert!((far / 400.0 - 1.0).abs() < 1e-3, "{far}");
    }

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
        // Twin: with nothing allowed nothing changes; below the lower threshold four merge.
        assert!(tree.update(|_| Some(201.0), thresholds, 0).is_empty());
        assert_eq!(tree.update(|_| Some(49.0), thresholds, 9), [(1, 1, 1)]);
        assert_eq!(tree.update(|_| Some(49.0), thresholds, 9), [(0, 0, 0)]);
    }

    #[test]
    fn a_hysteresis_of_four_never_cycles_and_less_does() {
        let views: Vec<QuadtreeView> = (0..300).map(QuadtreeView::numbered).collect();
        let cycling = |hysteresis: f64| {
            let found: Vec<Option<usize>> = views
                .iter()
                .map(|view| settle(view, 4096.0, hysteresis, 64).frames)
                .collect();
            let longest = found.iter().flatten().max().copied();
            let never = found.iter().filter(|frames| frames.is_none()).count();
            eprintln!(
                "hysteresis {hysteresis}: {never} of 300 never settle, others within {longest:?} frames"
            );
            never
        };
        let found = [1.0, 1.5, 2.0, 3.0, 3.9, 4.0, 8.0].map(cycling);
        assert_eq!(found[5..], [0, 0]);
        assert!(found[4] > 0, "{found:?}");
        assert!(
            found[..5].is_sorted_by(|a, b| a >= b) && found[0] > 100,
            "{found:?}"
        );
    }
}
