// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the quadtree of [`crate::counts`] does in many views that stand still, in closed form.

use terrafill_maps::{Node, Quadtree, Thresholds, children};

/// Cells of a side in which pixels are counted: leaves of the deepest level.
const SIDE: usize = 1 << MAX_LEVEL;
/// Splits end here.
const MAX_LEVEL: u32 = 7;

/// How many pixels each part of a square of side 1 has in a view.
#[derive(Debug, Clone)]
pub(super) struct QuadtreeView {
    /// Pixels of all cells left of and below a corner, row by row.
    sums: Vec<f64>,
}

impl QuadtreeView {
    /// Seen from a place over the square, whose pixels at a point are as many as its solid angle has.
    ///
    /// - `eye`: place over the square, and height over it, in its sides
    /// - `ahead`: horizontal part of the direction of view over its downward part
    /// - `pixels`: that an angle of 1 spans in the middle of a picture with a field of view of 60°
    pub(super) fn new(eye: [f64; 3], ahead: [f64; 2], pixels: f64) -> Self {
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
    pub(super) fn numbered(number: u32) -> Self {
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

/// Frames until a quadtree that begins as one node comes to rest in a view that stands still; `None` where it
/// does not within `frames`.
///
/// - `texels`: of a node's texture
/// - `hysteresis`: as [`Thresholds::new`]
pub(super) fn settle(
    view: &QuadtreeView,
    texels: f64,
    hysteresis: f64,
    frames: usize,
) -> Option<usize> {
    let thresholds = Thresholds::new(texels, hysteresis);
    let mut tree = Quadtree::new(MAX_LEVEL);
    let has_changed = |_: &usize| tree.update(|node| Some(view.pixels(node)), thresholds);
    let last_change = (0..frames).filter(has_changed).max();
    let rest = last_change.map_or(0, |last| last + 1);
    (rest < frames).then_some(rest)
}

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
