// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles chosen anew in each frame by what the corners of the grid ask for. The rule of StuCoSReC 2018, section 2.1, is
//! not handed down: this one is ours.
//!
//! A triangle asks for each level from the coarsest to the finest that its corners' rays ask for, and on each for the
//! tiles that its corners enclose on the map. A pixel between corners may lie nearer than all of them, and then asks for
//! a finer level than any: what that leaves out is counted.

mod section;

pub(crate) use section::SECTION;

use super::mesh::{MapMesh, MapVertex};
use super::truth::{Tile, wanted_level};
use glam::DVec3;
use std::collections::BTreeSet;
use terrafill_globe_views::Eye;
use terrafill_maps::{MapPoint, MapTile, TILE_TEXELS};

/// Name of this part in cases.
pub(crate) const PART: &str = "chosen";

/// More than a frame may ask for: as many layers have the arrays of most devices.
const MAX_CHOSEN: usize = 2048;

/// A vertex as sent: where it is on the map, and the level that its ray asks for.
#[derive(Debug, Clone, Copy)]
struct Corner {
    u: f64,
    mercator_v: f64,
    level: u32,
}

/// Tiles that a mesh's corners ask for, and both caps, sorted.
///
/// - `mesh`: whose U is absolute, so split at the seam or not
/// - cost: O(triangles + tiles)
///
/// # Errors
/// Where they are more than [`MAX_CHOSEN`]: towards the horizon corners of one cell may be many levels apart.
pub(crate) fn chosen(eye: &Eye, mesh: &MapMesh) -> Result<BTreeSet<Tile>, String> {
    let corner = |vertex: &MapVertex| {
        let relative_m = DVec3::from(vertex.relative_m.map(f64::from));
        let ecef = eye.camera.eye_ecef + relative_m;
        Corner {
            u: f64::from(vertex.us[0]),
            mercator_v: MapPoint::new(&eye.body, ecef).mercator_v,
            level: wanted_level(eye, ecef, relative_m.length()),
        }
    };
    let corners: Vec<Corner> = mesh.vertices.iter().map(corner).collect();
    let mut tiles = BTreeSet::from([false, true].map(|is_south| Tile::Cap { is_south }));
    for triangle in corners.as_chunks::<3>().0 {
        let [from, to] = ends(triangle.map(|corner| corner.level));
        for level in from..=to {
            add(&mut tiles, triangle, level);
            if tiles.len() > MAX_CHOSEN {
                return Err(format!("corners ask for more than {MAX_CHOSEN} tiles"));
            }
        }
    }
    Ok(tiles)
}

/// The least and the greatest of a triangle.
fn ends<T: PartialOrd + Copy>([a, b, c]: [T; 3]) -> [T; 2] {
    let less = |a: T, b: T| if b < a { b } else { a };
    let more = |a: T, b: T| if b > a { b } else { a };
    [less(less(a, b), c), more(more(a, b), c)]
}

/// Adds the tiles of a level between a triangle's corners, with a texel beyond, since a fragment's place is rounded.
fn add(tiles: &mut BTreeSet<Tile>, triangle: &[Corner; 3], level: u32) {
    let side = f64::from(level).exp2();
    let texel = 1.0 / TILE_TEXELS;
    let from_to = |of: fn(&Corner) -> f64| {
        let [from, to] = ends(triangle.each_ref().map(|corner| of(corner) * side));
        [(from - texel).floor(), (to + texel).floor()]
    };
    let [columns, rows] = [
        from_to(|corner| corner.u),
        from_to(|corner| corner.mercator_v),
    ];
    let rows = [rows[0].max(0.0), rows[1].min(side - 1.0)];
    let along = |[from, to]: [f64; 2]| {
        std::iter::successors(Some(from), |at| Some(at + 1.0)).take_while(move |at| *at <= to)
    };
    // One more than is allowed says as much as all of them.
    let all = along(rows).flat_map(|row| along(columns).map(move |column| [column, row]));
    for [column, row] in all.take(MAX_CHOSEN + 1) {
        let tile = MapTile::at(level, (column + 0.5) / side, (row + 0.5) / side);
        tiles.extend(tile.map(Tile::of));
    }
}

#[cfg(test)]
mod tests;
