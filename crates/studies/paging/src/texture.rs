// SPDX-License-Identifier: MIT OR Apache-2.0
//! A large texture in pages: every level is cut into squares of 128 texels, each stored with a border of one texel, so
//! that a page alone is enough to filter by.
//!
//! Level 0 is one page of the whole texture; each level has twice the texels along a side of the one before.

use std::sync::Arc;
use terrafill_maps::Node;
use terrafill_scene::MipChain;

/// Texels along a side of a page.
pub(crate) const PAGE: u32 = 128;
/// The same with the border on both sides.
pub(crate) const STORED: u32 = PAGE + 2;
/// Bytes of a stored page, four a texel.
pub(crate) const PAGE_BYTES: usize = 4 * (STORED * STORED) as usize;
/// Set in every address, so that what was cleared is none.
const IS_ADDRESS: u32 = 1 << 29;

/// A page of a texture: its level, and its column from the west and row from the north.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Page {
    pub(crate) level: u32,
    pub(crate) x: u32,
    pub(crate) y: u32,
}

impl Page {
    /// The whole texture.
    pub(crate) const ROOT: Self = Self {
        level: 0,
        x: 0,
        y: 0,
    };

    /// The page of a level at a place of the texture.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "held within the level's pages"
    )]
    pub(crate) fn at(level: u32, uv: [f64; 2]) -> Self {
        let side = f64::from(1_u32 << level);
        let [x, y] = uv.map(|at| (at * side).clamp(0.0, side - 1.0).floor() as u32);
        Self { level, x, y }
    }

    /// Its number among the pages of all levels.
    pub(crate) fn number(self) -> usize {
        (pages_above(self.level) + (self.y << self.level) + self.x) as usize
    }

    /// The page of a number.
    pub(crate) fn numbered(number: usize) -> Self {
        let number = u32::try_from(number).unwrap_or(u32::MAX);
        let mut level = 0;
        while pages_above(level + 1) <= number {
            level += 1;
        }
        let within = number - pages_above(level);
        Self {
            level,
            x: within & ((1 << level) - 1),
            y: within >> level,
        }
    }

    /// What it is a quarter of; the whole texture is in none.
    pub(crate) fn parent(self) -> Option<Self> {
        let level = self.level.checked_sub(1)?;
        Some(Self {
            level,
            x: self.x / 2,
            y: self.y / 2,
        })
    }

    /// Its four quarters.
    #[cfg(test)]
    pub(crate) fn children(self) -> [Self; 4] {
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(east, south)| Self {
            level: self.level + 1,
            x: 2 * self.x + east,
            y: 2 * self.y + south,
        })
    }
}

impl From<Node> for Page {
    #[allow(clippy::cast_possible_truncation, reason = "a level has few pages")]
    fn from((level, column, row): Node) -> Self {
        let [x, y] = [column, row].map(|at| at as u32);
        Self { level, x, y }
    }
}

/// Pages of all levels before this one.
pub(crate) const fn pages_above(level: u32) -> u32 {
    ((1 << (2 * level)) - 1) / 3
}

/// The address that a texel of the pattern says: level, column and row.
pub(crate) const fn address(level: u32, x: u32, y: u32) -> u32 {
    IS_ADDRESS | level << 26 | y << 13 | x
}

/// The level that an address says; `None` for no address.
pub(crate) const fn level_of(address: u32) -> Option<u32> {
    if address & IS_ADDRESS == 0 {
        return None;
    }
    Some(address >> 26 & 7)
}

/// What its texels are made of.
#[derive(Debug, Clone)]
pub(crate) enum Source {
    /// Each texel says its own address.
    Addresses,
    /// A picture of the whole Earth, enlarged.
    Picture(Arc<MipChain>),
}

/// A texture of the whole Earth.
#[derive(Debug, Clone)]
pub(crate) struct Texture {
    pub(crate) source: Source,
    /// The level with all texels.
    pub(crate) finest: u32,
}

impl Texture {
    /// Texels along a side of a level.
    pub(crate) const fn side(level: u32) -> u32 {
        PAGE << level
    }

    /// How many pages all levels have.
    pub(crate) const fn page_count(&self) -> u32 {
        pages_above(self.finest + 1)
    }

    /// Texels of a page with its border: those beyond a side of the page are its neighbour's. Around the Earth the
    /// last column is the first one's neighbour; rows end at the poles.
    pub(crate) fn page(&self, page: Page) -> Vec<u8> {
        let side = Self::side(page.level);
        let [west, north] = [page.x, page.y].map(|at| i64::from(at * PAGE) - 1);
        let mut bytes = Vec::with_capacity(PAGE_BYTES);
        for row in 0..i64::from(STORED) {
            let y = clamped(north + row, side);
            for column in 0..i64::from(STORED) {
                let x = wrapped(west + column, side);
                bytes.extend(self.texel(page.level, x, y));
            }
        }
        bytes
    }

    fn texel(&self, level: u32, x: u32, y: u32) -> [u8; 4] {
        match &self.source {
            Source::Addresses => address(level, x, y).to_le_bytes(),
            Source::Picture(picture) => {
                let side = Self::side(level);
                // The picture's own level that has no more columns, or its finest one.
                let levels = picture.levels().iter();
                let picked = levels.rev().find(|own| own.width >= side);
                let picked = picked.unwrap_or(&picture.levels()[0]);
                let uv = [x, y].map(|at| (f64::from(at) + 0.5) / f64::from(side));
                let size = [picked.width, picked.height];
                bilinear(&picked.rgba, size, uv)
            }
        }
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "held within the rows"
)]
pub(crate) fn clamped(at: i64, count: u32) -> u32 {
    at.clamp(0, i64::from(count) - 1) as u32
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "held within the columns"
)]
pub(crate) fn wrapped(at: i64, count: u32) -> u32 {
    at.rem_euclid(i64::from(count)) as u32
}

/// Between the four texels of a picture about a place.
#[allow(clippy::cast_possible_truncation, reason = "columns, rows and bytes")]
fn bilinear(rgba: &[u8], [width, height]: [u32; 2], [u, v]: [f64; 2]) -> [u8; 4] {
    let [across, down] = [u * f64::from(width) - 0.5, v * f64::from(height) - 0.5];
    let [column, row] = [across.floor(), down.floor()];
    let texel = |east: i64, south: i64, channel: usize| {
        let x = wrapped(column as i64 + east, width);
        let y = clamped(row as i64 + south, height);
        f64::from(rgba[4 * (y * width + x) as usize + channel])
    };
    [0, 1, 2, 3].map(|channel| {
        let along = |south| {
            let [west, east] = [0, 1].map(|at| texel(at, south, channel));
            west + (across - column) * (east - west)
        };
        let [north, south] = [along(0), along(1)];
        byte(north + (down - row) * (south - north))
    })
}

/// The nearest one.
#[allow(clippy::cast_possible_truncation, reason = "of a mean of bytes")]
pub(crate) fn byte(value: f64) -> u8 {
    value.round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATTERN: Texture = Texture {
        source: Source::Addresses,
        finest: 3,
    };

    fn texel(bytes: &[u8], column: usize, row: usize) -> u32 {
        let at = 4 * (row * STORED as usize + column);
        u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    }

    #[test]
    fn pages_are_numbered_level_by_level_and_found_at_places() {
        for (number, page) in [
            (0, Page::ROOT),
            (1, Page::ROOT.children()[0]),
            (4, Page::ROOT.children()[3]),
            (
                5,
                Page {
                    level: 2,
                    x: 0,
                    y: 0,
                },
            ),
        ] {
            assert_eq!(page.number(), number);
        }
        for number in 0..PATTERN.page_count() as usize {
            let page = Page::numbered(number);
            assert_eq!(page.number(), number);
            for child in page.children() {
                assert_eq!(child.parent(), Some(page));
            }
            let middle =
                [page.x, page.y].map(|at| (f64::from(at) + 0.5) / f64::from(1_u32 << page.level));
            assert_eq!(Page::at(page.level, middle), page);
        }
        assert_eq!(
            Page::at(2, [1.0, -1e-9]),
            Page {
                level: 2,
                x: 3,
                y: 0
            }
        );
    }

    #[test]
    fn borders_are_texels_of_the_neighbours_round_the_earth_and_up_to_the_poles() {
        let page = Page {
            level: 2,
            x: 0,
            y: 0,
        };
        let bytes = PATTERN.page(page);
        assert_eq!(bytes.len(), PAGE_BYTES);
        assert_eq!(texel(&bytes, 1, 1), address(2, 0, 0));
        assert_eq!(texel(&bytes, 0, 5), address(2, 511, 4), "round the Earth");
        assert_eq!(texel(&bytes, 129, 129), address(2, 128, 128));
        assert_eq!(texel(&bytes, 7, 0), address(2, 6, 0), "at the pole");
        assert_eq!(level_of(texel(&bytes, 3, 3)), Some(2));
        // Negative control: what was cleared.
        assert_eq!(level_of(0), None);
    }

    #[test]
    fn an_enlarged_picture_lies_between_its_texels() {
        let rgba = [0, 100, 200, 255].iter().flat_map(|grey| [*grey; 4]);
        let chain = MipChain::new(4, 1, rgba.collect()).expect("a picture");
        let texture = Texture {
            source: Source::Picture(Arc::new(chain)),
            finest: 1,
        };
        let bytes = texture.page(Page::ROOT);
        let grey = |column: usize| bytes[4 * (5 * STORED as usize + column)];
        // Middles of the second and third texel are at 48 and 80 of 128; half a texel beside them.
        assert!(grey(49).abs_diff(100) <= 2 && grey(81).abs_diff(200) <= 2);
        assert!(grey(65).abs_diff(150) <= 2, "{}", grey(65));
        // Beyond the eastern edge the western one goes on.
        assert!(grey(129) < 255 && grey(129) > 100, "{}", grey(129));
    }
}
