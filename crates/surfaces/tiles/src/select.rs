// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which tiles a view draws: the one that its rule finds farthest above what is allowed is split first, until none
//! is above it or the triangles are used up.

use crate::bounds::{Ball, TileView};
use crate::tile::{CELLS, MAX_LEVEL, TileId};
use crate::tree::{Node, Tree};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use terrafill_core::Ellipsoid;
use terrafill_surface::Refinement;

/// What makes a tile too coarse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rule {
    /// Its distance from the full resolution on the screen, pixels.
    Error { allowed_px: f64 },
    /// The side of its cells over its distance from the eye, whatever its ground is like.
    Size { allowed: f64 },
}

impl Rule {
    /// Times what is allowed; more than 1 is too coarse.
    fn excess(self, sight: &TileView, ball: &Ball, id: TileId, error_px: f64) -> f64 {
        match self {
            Self::Error { allowed_px } => error_px / allowed_px,
            Self::Size { allowed } => sight.cell_m(id) / (sight.distance_m(ball) * allowed),
        }
    }
}

/// A tile that is drawn unless it turns out to be out of sight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chosen {
    pub(crate) id: TileId,
    /// Distance of its triangles from the full resolution, metres; the bend of the body included.
    pub(crate) error_m: f64,
    /// The same on the screen where it is nearest, pixels; 0 out of sight.
    pub(crate) error_px: f64,
    /// How often its rule's limit it is; 0 out of sight.
    excess: f64,
    root: usize,
    node: Node,
}

impl Chosen {
    fn new(
        body: &Ellipsoid,
        (sight, rule): (&TileView, Rule),
        id: TileId,
        root: usize,
        node: Node,
    ) -> Self {
        let error_m = node.error_m + bend_m(body, id);
        let ball = Ball::around(body, &id.extent(), node.heights);
        let (error_px, excess) = if sight.may_see(&ball) {
            let error_px = sight.pixels(&ball, error_m);
            (error_px, rule.excess(sight, &ball, id, error_px))
        } else {
            (0.0, 0.0)
        };
        Self {
            id,
            error_m,
            error_px,
            excess,
            root,
            node,
        }
    }
}

/// How far a tile's flat triangles hang below a level ground, metres. A circle's arc over an edge `c` long is
/// `c² / 8R` high, and over a triangle with edges of that length 4/3 as much.
pub(crate) fn bend_m(body: &Ellipsoid, id: TileId) -> f64 {
    let extent = id.extent();
    // The longest parallel of the tile is the nearest to the equator.
    let latitude = if extent.south_deg >= 0.0 {
        extent.south_deg
    } else {
        extent.north_deg.min(0.0)
    };
    let step_m = id.step_deg().to_radians() * body.equatorial_radius_m();
    let east_m = step_m * latitude.to_radians().cos();
    (step_m * step_m + east_m * east_m) / (6.0 * body.smallest_curvature_radius_m())
}

/// In a heap: the tile farthest above what is allowed first, then the first one.
#[derive(Debug, Clone, Copy)]
struct Candidate(Chosen);

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_excess = self.0.excess.total_cmp(&other.0.excess);
        by_excess.then_with(|| other.0.id.cmp(&self.0.id))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// What a view draws of the tiles that are there.
pub(crate) struct Choice {
    /// Tiles that cover the body, sorted.
    pub(crate) tiles: Vec<Chosen>,
    /// Those that would be drawn instead if they were there, the largest error first.
    pub(crate) missing: Vec<TileId>,
}

impl Choice {
    pub(crate) fn refinement(&self) -> Refinement {
        let errors = self.tiles.iter().map(|tile| tile.error_px);
        Refinement {
            waiting: self.missing.len(),
            error_px: errors.fold(0.0, f64::max),
        }
    }
}

/// - `rule`: what makes a tile too coarse
/// - `max_triangles`: of tiles that may be seen, skirts not counted
/// - `is_there`: whether a tile that may be seen can be drawn; roots always can
pub(crate) fn choose(
    body: &Ellipsoid,
    tree: &Tree,
    sight: &TileView,
    rule: Rule,
    max_triangles: u32,
    is_there: &mut dyn FnMut(TileId) -> bool,
) -> Choice {
    let roots = TileId::roots().enumerate();
    let mut heap: BinaryHeap<Candidate> = roots
        .map(|(root, id)| Candidate(Chosen::new(body, (sight, rule), id, root, tree.root(root))))
        .collect();
    let mut seen = heap.iter().filter(|c| c.0.error_px > 0.0).count();
    let most = (max_triangles / (2 * CELLS * CELLS)) as usize;
    let mut done = Vec::new();
    let mut missing = Vec::new();
    while let Some(Candidate(tile)) = heap.pop() {
        let is_good = tile.excess <= 1.0 || seen + 3 > most;
        if is_good || tile.id.level >= MAX_LEVEL {
            done.push(tile);
            continue;
        }
        // Below the full resolution only kinks between samples are left, which halve with the cells.
        let halved = Node {
            error_m: 0.5 * tile.node.error_m,
            ..tile.node
        };
        let nodes = tree.children(tile.root, tile.node);
        let nodes = nodes.unwrap_or([halved; 4]);
        let children = tile.id.children().into_iter().zip(nodes);
        let children: Vec<Chosen> = children
            .map(|(id, node)| Chosen::new(body, (sight, rule), id, tile.root, node))
            .collect();
        let before = missing.len();
        let drawn = children.iter().filter(|child| child.error_px > 0.0);
        missing.extend(drawn.map(|child| child.id).filter(|id| !is_there(*id)));
        if missing.len() > before {
            done.push(tile);
            continue;
        }
        seen -= 1;
        for child in children {
            seen += usize::from(child.error_px > 0.0);
            heap.push(Candidate(child));
        }
    }
    done.sort_unstable_by_key(|tile| tile.id);
    Choice {
        tiles: done,
        missing,
    }
}
