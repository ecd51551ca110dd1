// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which pages lie in which slots, and which are read next. The page that was wanted longest ago makes room; what a
//! frame shows stays, and the whole texture's page always does.

use crate::texture::{Page, Texture};
use terrafill_maps::{Placed, Slots};

/// Of an entry of the page table: the tree ends at this page.
pub(crate) const LEAF: u32 = 1 << 31;
/// Of an entry: the number of its slot, from 1; 0 for none.
pub(crate) const SLOT: u32 = 0xFFFF;

/// A page that is to be read into a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Load {
    pub(crate) page: Page,
    pub(crate) slot: usize,
}

/// What a frame reads.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Loads {
    pub(crate) loads: Vec<Load>,
    /// Pages for which every slot was taken by what the frame shows.
    pub(crate) without_slot: usize,
}

/// Slots and the page table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Residency {
    slots: Slots<Page>,
    table: Vec<u32>,
}

impl Residency {
    /// Nothing is in a slot.
    pub(crate) fn new(texture: &Texture, slots: usize) -> Self {
        Self {
            slots: Slots::new(slots),
            table: vec![0; texture.page_count() as usize],
        }
    }

    /// An entry for each page of each level, in the order of their numbers.
    pub(crate) fn table(&self) -> &[u32] {
        &self.table
    }

    /// Sets the leaves of the tree; none where each pixel finds its level itself.
    pub(crate) fn set_leaves(&mut self, leaves: impl Iterator<Item = Page>) {
        for entry in &mut self.table {
            *entry &= SLOT;
        }
        for page in leaves {
            self.table[page.number()] |= LEAF;
        }
    }

    fn shown(&self, page: Page) -> Option<Page> {
        self.slots.shown(page, |page| page.parent())
    }

    /// Chooses what a frame reads, and takes it for read.
    ///
    /// - `wanted`: the most urgent first
    /// - `budget`: at most so many pages
    pub(crate) fn request(&mut self, wanted: &[Page], frame: usize, budget: usize) -> Loads {
        for page in wanted.iter().copied().chain([Page::ROOT]) {
            if let Some(shown) = self.shown(page) {
                self.slots.uses(shown, frame);
            }
        }
        let mut found = Loads::default();
        // The whole texture comes first: with it every pixel shows something.
        let all = std::iter::once(Page::ROOT).chain(wanted.iter().copied());
        for page in all {
            if self.slots.holds(page) || found.loads.len() == budget {
                continue;
            }
            match self.slots.place(page, frame) {
                Some(Placed { slot, evicted }) => {
                    if let Some(evicted) = evicted {
                        self.table[evicted.number()] &= !SLOT;
                    }
                    self.table[page.number()] |= u32::try_from(slot + 1).unwrap_or(SLOT);
                    found.loads.push(Load { page, slot });
                }
                None => found.without_slot += 1,
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Source;

    #[test]
    fn what_is_shown_stays_and_the_oldest_makes_room() {
        let texture = Texture {
            source: Source::Addresses,
            finest: 2,
        };
        let mut held = Residency::new(&texture, 3);
        let four = Page::ROOT.children();
        let any = usize::MAX;
        let pages = |found: &Loads| found.loads.iter().map(|load| load.page).collect::<Vec<_>>();
        let first = held.request(&four[..1], 0, any);
        assert_eq!(pages(&first), [Page::ROOT, four[0]]);
        assert_eq!(pages(&held.request(&four[1..2], 1, any)), [four[1]]);
        // The first quarter was wanted longest ago.
        let third = held.request(&four[2..3], 2, any);
        assert_eq!(
            third.loads,
            [Load {
                page: four[2],
                slot: 1
            }]
        );
        assert_eq!(held.table()[four[0].number()], 0);
        assert_eq!(held.table()[four[2].number()], 2);
        // A quarter that is shown in place of its own quarter stays, as does the whole.
        let below = four[2].children()[3];
        let fourth = held.request(&[below, four[3]], 3, any);
        assert_eq!(pages(&fourth), [below]);
        assert_eq!(fourth.without_slot, 1);
        assert_eq!(held.shown(four[3].children()[0]), Some(Page::ROOT));
        // Negative controls: a budget of none, and leaves that went.
        assert_eq!(held.request(&four, 9, 0), Loads::default());
        held.set_leaves(four.into_iter());
        assert_eq!(held.table()[four[3].number()], LEAF);
        held.set_leaves(std::iter::once(Page::ROOT));
        assert_eq!(held.table()[four[3].number()], 0);
        assert_eq!(held.table()[0], LEAF | 1);
    }
}
