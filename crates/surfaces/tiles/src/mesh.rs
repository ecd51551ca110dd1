// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles of the chosen tiles, with skirts where tiles of different sizes meet.
//!
//! Where a small tile meets a large one, each of its vertices between two of the large tile's stands over
//! or below the large one's edge, and the ground is open there. A skirt hangs from the rim of either, as
//! deep as the two errors allow the gap to be (Ulrich, 2002, §4), and faces away from its tile, as it is
//! seen from there. Tiles of one size share vertices to the bit and need none.

use crate::bounds::TileView;
use crate::select::Chosen;
use crate::tile::{CELLS, SIDES, Side, TileId};
use glam::DVec3;
use std::collections::HashMap;
use std::sync::Arc;
use terrafill_core::{Ellipsoid, Extent, Geodetic, index_u32};
use terrafill_elevation::Elevation;
use terrafill_surface::{HeightRange, SurfaceBlocks, SurfaceMesh, SurfacePart};

/// Vertices of a tile's side.
const SIDE: u32 = CELLS + 1;
/// A gap may be wider by the rounding of vertices to f32, by this share of their distance from the eye.
const ROUNDING: f64 = 4.0 / (1 << 24) as f64;

/// Depth of the skirts of each side of each chosen tile, metres; 0 where it needs none.
pub(crate) fn skirts(chosen: &[Chosen]) -> Vec<[f64; 4]> {
    let places: HashMap<TileId, usize> = chosen
        .iter()
        .enumerate()
        .map(|(i, tile)| (tile.id, i))
        .collect();
    let mut depths = vec![[0.0_f64; 4]; chosen.len()];
    for (small, tile) in chosen.iter().enumerate() {
        for (at, side) in SIDES.into_iter().enumerate() {
            let beside = tile.id.beside(side);
            if beside.is_none_or(|id| places.contains_key(&id)) {
                continue;
            }
            // A larger neighbour holds the place of an equal one; a smaller one finds this tile itself.
            let mut above = beside.and_then(TileId::parent);
            while let Some(id) = above {
                if let Some(&large) = places.get(&id) {
                    let gap_m = tile.error_m + chosen[large].error_m;
                    let opposite = SIDES
                        .iter()
                        .position(|s| *s == side.opposite())
                        .unwrap_or(at);
                    depths[small][at] = depths[small][at].max(gap_m);
                    depths[large][opposite] = depths[large][opposite].max(gap_m);
                    break;
                }
                above = id.parent();
            }
        }
    }
    depths
}

/// What one view draws.
pub(crate) struct DrawnTiles {
    pub(crate) mesh: SurfaceMesh,
    pub(crate) parts: Vec<SurfacePart>,
}

/// Vertices of a tile without its skirts, row by row from the south west.
#[derive(Debug, Default)]
pub(crate) struct TileVertices {
    heights_m: Vec<f64>,
    ecef: Vec<DVec3>,
}

impl TileVertices {
    /// What one takes.
    pub(crate) const BYTES: u64 =
        (SIDE * SIDE) as u64 * (size_of::<f64>() + size_of::<DVec3>()) as u64;

    pub(crate) fn new(body: &Ellipsoid, elevation: &Elevation, id: TileId) -> Self {
        let mut vertices = Self::default();
        for row in 0..SIDE {
            for column in 0..SIDE {
                let [longitude, latitude] = id.place([column, row], CELLS);
                let height_m = elevation.height_m(longitude, latitude);
                vertices.heights_m.push(height_m);
                let at = position(body, longitude, latitude, height_m);
                vertices.ecef.push(at);
            }
        }
        vertices
    }
}

/// Triangles of all tiles that may be seen, and of the one over the eye.
///
/// - `vertices`: of a tile
pub(crate) fn draw(
    body: &Ellipsoid,
    vertices: &mut dyn FnMut(TileId) -> Arc<TileVertices>,
    sight: &TileView,
    chosen: &[Chosen],
    skirts: &[[f64; 4]],
) -> DrawnTiles {
    let mut mesh = SurfaceMesh {
        body: *body,
        vertices_ecef: Vec::new(),
        heights_m: Vec::new(),
        triangles: Arc::default(),
        heights: HeightRange {
            lowest_m: f64::INFINITY,
            highest_m: f64::NEG_INFINITY,
        },
        blocks: SurfaceBlocks::default(),
    };
    let eye = body.ecef_to_geodetic(sight.eye_ecef);
    let eye_deg = [eye.longitude_rad, eye.latitude_rad].map(f64::to_degrees);
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut ranges = Vec::new();
    for (tile, depths) in chosen.iter().zip(skirts) {
        let is_near = tile.id.holds(eye_deg[0], eye_deg[1]);
        if tile.error_px <= 0.0 && !is_near {
            continue;
        }
        let before = (mesh.vertices_ecef.len(), triangles.len());
        add_tile(&mut mesh, &mut triangles, &vertices(tile.id), tile.id);
        for (side, &depth_m) in SIDES.into_iter().zip(depths) {
            if depth_m > 0.0 {
                add_skirt(
                    &mut mesh,
                    &mut triangles,
                    sight,
                    tile.id,
                    before.0,
                    side,
                    depth_m,
                );
            }
        }
        if !is_near && !sight.may_see_between(&mesh.vertices_ecef[before.0..]) {
            mesh.vertices_ecef.truncate(before.0);
            mesh.heights_m.truncate(before.0);
            triangles.truncate(before.1);
            continue;
        }
        ranges.push((tile.id, before.1..triangles.len()));
    }
    mesh.triangles = triangles.into();
    let parts: Vec<SurfacePart> = ranges
        .into_iter()
        .map(|(id, range)| {
            let facets = mesh.triangles[range]
                .iter()
                .map(|facet| mesh.facet_heights(facet));
            SurfacePart {
                extent: reached(id),
                heights: facets.fold(mesh.heights, HeightRange::union),
            }
        })
        .collect();
    let all = parts.iter().map(|part| part.heights);
    mesh.heights = all.fold(mesh.heights, HeightRange::union);
    DrawnTiles { mesh, parts }
}

fn add_tile(
    mesh: &mut SurfaceMesh,
    triangles: &mut Vec<[u32; 3]>,
    vertices: &TileVertices,
    id: TileId,
) {
    let first = index_u32(mesh.vertices_ecef.len());
    mesh.heights_m.extend_from_slice(&vertices.heights_m);
    mesh.vertices_ecef.extend_from_slice(&vertices.ecef);
    let extent = id.extent();
    for row in 0..CELLS {
        for column in 0..CELLS {
            let south_west = first + row * SIDE + column;
            let (south_east, north_west) = (south_west + 1, south_west + SIDE);
            let north_east = north_west + 1;
            // In the row at a pole a cell is a triangle.
            if row > 0 || extent.south_deg > -90.0 {
                triangles.push([south_west, south_east, north_east]);
            }
            if row + 1 < CELLS || extent.north_deg < 90.0 {
                triangles.push([south_west, north_east, north_west]);
            }
        }
    }
}

fn add_skirt(
    mesh: &mut SurfaceMesh,
    triangles: &mut Vec<[u32; 3]>,
    sight: &TileView,
    id: TileId,
    first: usize,
    side: Side,
    depth_m: f64,
) {
    let below = index_u32(mesh.vertices_ecef.len());
    let rim = |at: u32| {
        let [column, row] = side.vertex(at);
        index_u32(first) + row * SIDE + column
    };
    for at in 0..SIDE {
        let top = rim(at) as usize;
        let far_m = 10.0 * mesh.body.equatorial_radius_m();
        let distance_m = (mesh.vertices_ecef[top] - sight.eye_ecef)
            .length()
            .min(far_m);
        let height_m = mesh.heights_m[top] - depth_m - ROUNDING * distance_m;
        let [longitude, latitude] = id.place(side.vertex(at), CELLS);
        mesh.heights_m.push(height_m);
        mesh.vertices_ecef
            .push(position(&mesh.body, longitude, latitude, height_m));
    }
    for at in 0..CELLS {
        let (top, next) = (rim(at), rim(at + 1));
        let (low, low_next) = (below + at, below + at + 1);
        triangles.push([top, low, low_next]);
        triangles.push([top, low_next, next]);
    }
}

fn position(body: &Ellipsoid, longitude: f64, latitude: f64, height_m: f64) -> DVec3 {
    // The same point from every meridian.
    if latitude.abs() >= 90.0 {
        let z = body.polar_radius_m() + height_m;
        return DVec3::new(0.0, 0.0, z.copysign(latitude));
    }
    body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, height_m))
}

/// No triangle of the tile leaves this: their edges are straight in space, and leave a cell by up to a
/// sixteenth of it.
fn reached(id: TileId) -> Extent {
    let extent = id.extent();
    let margin = id.step_deg() / 8.0;
    let (mut west_deg, mut east_deg) = (extent.west_deg - margin, extent.east_deg + margin);
    if west_deg < -180.0 {
        west_deg += 360.0;
    }
    if east_deg > 180.0 {
        east_deg -= 360.0;
    }
    Extent {
        west_deg,
        south_deg: (extent.south_deg - margin).max(-90.0),
        east_deg,
        north_deg: (extent.north_deg + margin).min(90.0),
    }
}
