// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an opened way of culling does, on whichever interface.

use super::frustum::Frustum;
use super::ground::{Ground, GroundConstants, PATCH_TRIANGLES};
use super::way::{CullStage, Test};
use crate::draws::{Counted, Times, count};
use terrafill_contract::{DeviceError, Picture};
use terrafill_shapes::grid::GridCamera;

/// Vertices of a patch, six a cell.
const PATCH_VERTICES: u32 = 3 * PATCH_TRIANGLES;

/// What was kept of the patches.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kept {
    /// Which, in any order.
    List(Vec<u32>),
    /// How many, where a stage hands them on within the pipeline.
    Count(u64),
}

impl Kept {
    pub(crate) fn count(&self) -> u64 {
        match self {
            Self::List(patches) => patches.len() as u64,
            Self::Count(count) => *count,
        }
    }
}

/// What a frame showed.
#[derive(Debug)]
pub(crate) struct Shown {
    pub(crate) picture: Picture,
    pub(crate) kept: Kept,
    pub(crate) counted: Counted,
    pub(crate) sent_bytes: u64,
}

/// Ground by one way, ready to be culled and drawn.
pub(crate) trait Culls {
    /// Draws it and reads back what it kept.
    fn draw(&mut self) -> Result<Shown, DeviceError>;

    /// Culls tiles, sends what is sent each frame, tests patches, draws, and waits.
    fn time(&mut self) -> Result<Times, DeviceError>;
}

/// What the CPU finds and sends for a frame.
#[derive(Debug)]
pub(super) struct Sent {
    pub(super) tiles: Vec<u32>,
    /// Patches in those tiles.
    pub(super) in_tiles: u32,
    /// That the CPU kept, where it tests them.
    pub(super) patches: Option<Vec<u32>>,
    /// Of an indirect draw; stages that drop patches need none.
    pub(super) arguments: Option<[u32; 4]>,
}

impl Sent {
    /// Culls tiles, and patches where the CPU tests them.
    pub(super) fn new(ground: &Ground, view: &GridCamera, place: CullStage) -> Self {
        let frustum = Frustum::new(view);
        let tiles = frustum.tiles(ground);
        let in_tiles = count(&tiles) * ground.patches_a_tile();
        let patches = (place == CullStage::Cpu).then(|| frustum.patches(ground, &tiles));
        let instances = match place {
            CullStage::TilesAlone => Some(in_tiles),
            CullStage::Cpu => patches.as_deref().map(count),
            CullStage::Compute => Some(0),
            CullStage::Geometry | CullStage::Task => None,
        };
        Self {
            tiles,
            in_tiles,
            patches,
            arguments: instances.map(|instances| [PATCH_VERTICES, instances, 0, 0]),
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        let words = [
            self.tiles.len(),
            self.patches.as_ref().map_or(0, Vec::len),
            self.arguments.map_or(0, |arguments| arguments.len()),
        ];
        4 * words.into_iter().sum::<usize>() as u64
    }

    /// All patches of the tiles.
    pub(super) fn of_tiles(&self, ground: &Ground) -> Vec<u32> {
        let tiles = self.tiles.iter();
        tiles.flat_map(|tile| ground.patches_of(*tile)).collect()
    }
}

/// The list that compute made.
///
/// - `arguments`: of its draw
pub(super) fn listed(arguments: &[u32], mut patches: Vec<u32>) -> Kept {
    patches.truncate(arguments[1] as usize);
    Kept::List(patches)
}

/// What shaders read of a view.
pub(super) fn constants(ground: &Ground, view: &GridCamera, test: Test) -> GroundConstants {
    let tiles = Frustum::new(view).tiles(ground);
    GroundConstants::new(ground, view, count(&tiles), test)
}
