// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which tiles lie in which of a fixed number of slots. The tile that was used longest ago makes room; what a frame uses
//! stays.

use std::collections::BTreeMap;

/// Slots, and the tiles in them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slots<K> {
    /// Of each slot, its tile and the frame that used it last.
    slots: Vec<Option<(K, usize)>>,
    by_tile: BTreeMap<K, usize>,
}

/// Where a tile was placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Placed<K> {
    /// Number of its slot.
    pub slot: usize,
    /// The tile that made room.
    pub evicted: Option<K>,
}

impl<K: Copy + Ord> Slots<K> {
    /// Nothing is in a slot.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self {
            slots: vec![None; count],
            by_tile: BTreeMap::new(),
        }
    }

    /// Whether a tile is in a slot.
    #[must_use]
    pub fn holds(&self, tile: K) -> bool {
        self.by_tile.contains_key(&tile)
    }

    /// Tiles in the order of their keys, with their slots.
    pub fn held(&self) -> impl Iterator<Item = (K, usize)> {
        self.by_tile.iter().map(|(tile, slot)| (*tile, *slot))
    }

    /// The tile that is shown where `tile` is wanted: itself, or the nearest that it is a part of.
    #[must_use]
    pub fn shown(&self, tile: K, parent: impl Fn(&K) -> Option<K>) -> Option<K> {
        let mut tiles = std::iter::successors(Some(tile), parent);
        tiles.find(|tile| self.holds(*tile))
    }

    /// Says that a frame uses a tile.
    pub fn uses(&mut self, tile: K, frame: usize) {
        let slot = self.by_tile.get(&tile);
        if let Some((_, last)) = slot.and_then(|slot| self.slots[*slot].as_mut()) {
            *last = frame;
        }
    }

    /// Places a tile that is in no slot, for this frame.
    ///
    /// - returns: `None` where the frame uses every slot
    pub fn place(&mut self, tile: K, frame: usize) -> Option<Placed<K>> {
        let slot = self.room(frame)?;
        let evicted = self.slots[slot].map(|(evicted, _)| evicted);
        if let Some(evicted) = evicted {
            self.by_tile.remove(&evicted);
        }
        self.slots[slot] = Some((tile, frame));
        self.by_tile.insert(tile, slot);
        Some(Placed { slot, evicted })
    }

    /// A slot that is empty, or the one that was used longest ago before this frame.
    fn room(&self, frame: usize) -> Option<usize> {
        if let Some(empty) = self.slots.iter().position(Option::is_none) {
            return Some(empty);
        }
        let slots = self.slots.iter().enumerate();
        let taken = slots.filter_map(|(slot, held)| Some((held.as_ref()?.1, slot)));
        let old = taken.filter(|(last, _)| *last < frame);
        old.min().map(|(_, slot)| slot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_used_longest_ago_makes_room_and_what_a_frame_uses_does_not() {
        let mut slots = Slots::new(2);
        let placed = |slot, evicted| Some(Placed { slot, evicted });
        assert_eq!(slots.place(8, 0), placed(0, None));
        assert_eq!(slots.place(4, 1), placed(1, None));
        slots.uses(8, 2);
        assert_eq!(slots.place(5, 3), placed(1, Some(4)));
        assert_eq!(slots.held().collect::<Vec<_>>(), [(5, 1), (8, 0)]);
        let half = |tile: &i32| (*tile > 1).then_some(tile / 2);
        assert_eq!(slots.shown(17, half), Some(8));
        assert_eq!(slots.shown(4, half), None);
        // Negative controls: both are used, and what is in no slot cannot be.
        slots.uses(8, 3);
        slots.uses(4, 9);
        assert_eq!(slots.place(6, 3), None);
        assert!(slots.holds(5) && !slots.holds(4));
    }
}
