// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles that were made, kept within a budget of memory: those that no frame has drawn for longest leave first.

use crate::mesh::TileVertices;
use crate::tile::TileId;
use std::collections::HashMap;
use std::sync::Arc;
use terrafill_surface::PieceMemory;

#[derive(Debug)]
struct Kept {
    vertices: Arc<TileVertices>,
    /// Frame that drew it last.
    used: u64,
}

#[derive(Debug)]
pub(crate) struct Store {
    budget_bytes: u64,
    tiles: HashMap<TileId, Kept>,
    frame: u64,
    made: u64,
    evicted: u64,
    /// What the last frame asked for, the largest error last.
    wanted: Vec<TileId>,
}

impl Store {
    pub(crate) fn new(budget_bytes: u64) -> Self {
        Self {
            budget_bytes,
            tiles: HashMap::new(),
            frame: 0,
            made: 0,
            evicted: 0,
            wanted: Vec::new(),
        }
    }

    /// From now on tiles are used by a further frame, whose wishes replace those of the one before.
    pub(crate) fn begin_frame(&mut self) {
        self.frame += 1;
        self.wanted.clear();
    }

    /// - `wanted`: tiles to make, the largest error first
    pub(crate) fn ask(&mut self, wanted: Vec<TileId>) {
        self.wanted = wanted;
        self.wanted.reverse();
    }

    /// The next tile to make, if there is room for it or can be.
    pub(crate) fn next_wanted(&self) -> Option<TileId> {
        let is_room = self.bytes_with_one_more() <= self.budget_bytes || self.oldest().is_some();
        self.wanted.last().copied().filter(|_| is_room)
    }

    /// Marks a tile as used by this frame, and says whether it is there.
    pub(crate) fn touch(&mut self, id: TileId) -> bool {
        let frame = self.frame;
        let kept = self.tiles.get_mut(&id).map(|kept| kept.used = frame);
        kept.is_some()
    }

    /// A tile that is there.
    pub(crate) fn get(&self, id: TileId) -> Option<Arc<TileVertices>> {
        self.tiles.get(&id).map(|kept| Arc::clone(&kept.vertices))
    }

    /// Keeps a tile for this frame. Others leave for it; where all others are in use it is not kept.
    pub(crate) fn keep(&mut self, id: TileId, vertices: Arc<TileVertices>) {
        self.wanted.retain(|wanted| *wanted != id);
        self.made += 1;
        while self.bytes_with_one_more() > self.budget_bytes {
            let Some(oldest) = self.oldest() else {
                self.evicted += 1;
                return;
            };
            self.tiles.remove(&oldest);
            self.evicted += 1;
        }
        let used = self.frame;
        self.tiles.insert(id, Kept { vertices, used });
    }

    pub(crate) fn forget(&mut self) {
        self.tiles.clear();
        self.wanted.clear();
    }

    pub(crate) fn set_budget(&mut self, bytes: u64) {
        self.forget();
        self.budget_bytes = bytes;
    }

    pub(crate) fn memory(&self) -> PieceMemory {
        PieceMemory {
            bytes: self.tiles.len() as u64 * TileVertices::BYTES,
            budget_bytes: self.budget_bytes,
            pieces: self.tiles.len(),
            made: self.made,
            evicted: self.evicted,
        }
    }

    fn bytes_with_one_more(&self) -> u64 {
        (self.tiles.len() as u64 + 1) * TileVertices::BYTES
    }

    /// Of those that this frame does not use; the first of several, so that every run lets go of the same ones.
    fn oldest(&self) -> Option<TileId> {
        let idle = self.tiles.iter().filter(|(_, kept)| kept.used < self.frame);
        idle.min_by_key(|(id, kept)| (kept.used, **id))
            .map(|(id, _)| *id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(x: u32) -> TileId {
        TileId { level: 5, x, y: 0 }
    }

    #[test]
    fn the_tile_that_was_drawn_longest_ago_leaves_and_none_that_is_drawn() {
        let mut store = Store::new(3 * TileVertices::BYTES + 1);
        let vertices = Arc::new(TileVertices::default());
        for x in 0..3 {
            store.begin_frame();
            store.keep(id(x), Arc::clone(&vertices));
        }
        store.begin_frame();
        assert!(store.touch(id(0)) && !store.touch(id(9)));
        store.ask(vec![id(9)]);
        assert_eq!(store.next_wanted(), Some(id(9)));
        store.keep(id(9), Arc::clone(&vertices));
        assert!(store.get(id(1)).is_none() && store.get(id(0)).is_some());
        assert_eq!(store.next_wanted(), None);
        let full = PieceMemory {
            bytes: 3 * TileVertices::BYTES,
            budget_bytes: 3 * TileVertices::BYTES + 1,
            pieces: 3,
            made: 4,
            evicted: 1,
        };
        assert_eq!(store.memory(), full);
        // Negative control: where all are in use a further one is neither asked for nor kept.
        assert!(store.touch(id(2)));
        store.ask(vec![id(10)]);
        assert_eq!(store.next_wanted(), None);
        store.keep(id(10), vertices);
        assert!(store.get(id(10)).is_none() && store.memory().pieces == 3);
        store.forget();
        assert_eq!(store.memory().bytes, 0);
    }
}
