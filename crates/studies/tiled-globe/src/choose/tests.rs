// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles that corners of made-up triangles ask for.

use super::*;

fn corner(u: f64, mercator_v: f64) -> Corner {
    Corner {
        u,
        mercator_v,
        level: 2,
    }
}

#[test]
fn a_triangle_asks_for_the_tiles_between_its_corners_and_no_others() {
    let mut tiles = BTreeSet::new();
    let triangle = [corner(0.3, 0.3), corner(0.45, 0.3), corner(0.3, 0.6)];
    add(&mut tiles, &triangle, 2);
    let expected = [1, 2].map(|row| Tile::Map {
        level: 2,
        row,
        column: 1,
    });
    assert_eq!(tiles, BTreeSet::from(expected));
    // Beyond the map's end there are none, and beside ±180° those of both sides.
    let mut tiles = BTreeSet::new();
    let triangle = [corner(0.95, -0.5), corner(1.0, 0.1), corner(0.95, 0.1)];
    add(&mut tiles, &triangle, 2);
    let columns: BTreeSet<u32> = tiles.iter().map(|tile| tile.key()[2]).collect();
    let rows: BTreeSet<u32> = tiles.iter().map(|tile| tile.key()[1]).collect();
    assert_eq!(
        (columns, rows),
        (BTreeSet::from([0, 3]), BTreeSet::from([0]))
    );
}
