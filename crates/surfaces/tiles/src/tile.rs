// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which tile is where: at level 0, 8 × 4 squares of 45°; each level halves them. Degrees.
//!
//! Steps are 45° over powers of two, which `f64` holds without rounding: a vertex that tiles of several
//! levels share has the same bits in each.

use terrafill_core::Extent;

/// Cells of a tile's side. Fewer make more tiles for the same ground, more cannot follow its roughness.
pub(crate) const CELLS: u32 = 16;
/// Deepest level: cells of 0.3 m on the Earth, finer than any survey of a whole country.
pub(crate) const MAX_LEVEL: u32 = 20;
const ROOT_COLUMNS: u32 = 8;
const ROOT_ROWS: u32 = 4;
const ROOT_SIDE_DEG: f64 = 45.0;

/// Sides of a tile in the order in which its rim is walked, its inside to the left.
pub(crate) const SIDES: [Side; 4] = [Side::South, Side::East, Side::North, Side::West];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    South,
    East,
    North,
    West,
}

impl Side {
    pub(crate) fn opposite(self) -> Self {
        match self {
            Self::South => Self::North,
            Self::East => Self::West,
            Self::North => Self::South,
            Self::West => Self::East,
        }
    }

    /// Column and row of the `at`-th vertex of this side of a tile of `cells` a side.
    pub(crate) fn vertex(self, at: u32) -> [u32; 2] {
        match self {
            Self::South => [at, 0],
            Self::East => [CELLS, at],
            Self::North => [CELLS - at, CELLS],
            Self::West => [0, CELLS - at],
        }
    }
}

/// A tile: column from 180° west, row from the south pole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct TileId {
    pub(crate) level: u32,
    pub(crate) x: u32,
    pub(crate) y: u32,
}

impl TileId {
    /// Row by row from the south.
    pub(crate) fn roots() -> impl Iterator<Item = Self> {
        (0..ROOT_ROWS).flat_map(|y| (0..ROOT_COLUMNS).map(move |x| Self { level: 0, x, y }))
    }

    pub(crate) fn children(self) -> [Self; 4] {
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(east, north)| Self {
            level: self.level + 1,
            x: 2 * self.x + east,
            y: 2 * self.y + north,
        })
    }

    pub(crate) fn parent(self) -> Option<Self> {
        Some(Self {
            level: self.level.checked_sub(1)?,
            x: self.x / 2,
            y: self.y / 2,
        })
    }

    /// The tile of the same size on the other side; `None` beyond a pole.
    pub(crate) fn beside(self, side: Side) -> Option<Self> {
        let (columns, rows) = (ROOT_COLUMNS << self.level, ROOT_ROWS << self.level);
        let (x, y) = match side {
            Side::South => (self.x, self.y.checked_sub(1)?),
            Side::North => (self.x, self.y + 1),
            Side::East => ((self.x + 1) % columns, self.y),
            Side::West => ((self.x + columns - 1) % columns, self.y),
        };
        (y < rows).then_some(Self { x, y, ..self })
    }

    /// Side of a cell, degrees.
    pub(crate) fn step_deg(self) -> f64 {
        ROOT_SIDE_DEG / f64::from(CELLS) / f64::from(1_u32 << self.level)
    }

    /// Longitude and latitude of a vertex. ±180° is −180°, and a pole's longitude is −180° as well, so
    /// that each vertex has one name.
    ///
    /// - `parts`: cells of a side that `column` and `row` count, a power of two times [`CELLS`]
    pub(crate) fn place(self, [column, row]: [u32; 2], parts: u32) -> [f64; 2] {
        let scale = parts / CELLS;
        let step = self.step_deg() / f64::from(scale);
        let along = f64::from(self.x) * f64::from(parts) + f64::from(column);
        let up = f64::from(self.y) * f64::from(parts) + f64::from(row);
        let (longitude, latitude) = (along * step - 180.0, up * step - 90.0);
        let is_seam = longitude >= 180.0 || latitude.abs() >= 90.0;
        [if is_seam { -180.0 } else { longitude }, latitude]
    }

    /// What it covers; the eastern edge of the last column is 180°.
    pub(crate) fn extent(self) -> Extent {
        let side = self.step_deg() * f64::from(CELLS);
        let (west_deg, south_deg) = (
            f64::from(self.x) * side - 180.0,
            f64::from(self.y) * side - 90.0,
        );
        Extent {
            west_deg,
            south_deg,
            east_deg: west_deg + side,
            north_deg: south_deg + side,
        }
    }

    /// Whether a place lies in it, edges included.
    pub(crate) fn holds(self, longitude_deg: f64, latitude_deg: f64) -> bool {
        let extent = self.extent();
        let is_within = |longitude: f64| (extent.west_deg..=extent.east_deg).contains(&longitude);
        (extent.south_deg..=extent.north_deg).contains(&latitude_deg)
            && (is_within(longitude_deg) || (longitude_deg <= -180.0 && is_within(180.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_of_all_levels_share_vertices_and_neighbours_know_each_other() {
        let tile = TileId {
            level: 3,
            x: 63,
            y: 31,
        };
        let [_, east, ..] = tile.children();
        assert_eq!(
            tile.place([16, 0], CELLS),
            [-180.0, 45.0 * 31.0 / 8.0 - 90.0]
        );
        assert_eq!(tile.place([12, 4], CELLS), east.place([8, 8], CELLS));
        assert_eq!(tile.place([24, 8], 2 * CELLS), east.place([8, 8], CELLS));
        assert_eq!(tile.place([5, 16], CELLS), [-180.0, 90.0]);
        assert_eq!(tile.beside(Side::North), None);
        let over = tile.beside(Side::East).expect("across 180°");
        assert_eq!((over.x, over.beside(Side::West)), (0, Some(tile)));
        assert_eq!(east.parent(), Some(tile));
        assert!(tile.holds(-180.0, 89.0) && tile.holds(178.0, 90.0) && !tile.holds(170.0, 89.0));
        for side in SIDES {
            let [from, to] = [0, CELLS].map(|at| side.vertex(at));
            let next = SIDES[(SIDES.iter().position(|s| *s == side).expect("one") + 1) % 4];
            assert_eq!(to, next.vertex(0), "{side:?}");
            assert_ne!(from, to);
            assert_eq!(side.opposite().opposite(), side);
        }
    }
}
