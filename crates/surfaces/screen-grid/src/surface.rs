// SPDX-License-Identifier: MIT OR Apache-2.0
//! The surface: what scenes say of it, and the heights and parts of a view's triangles.

use crate::facet::{extent, heights, united};
use crate::mesh::{GridOptions, Limb, ScreenMesh};
use crate::rays::Rays;
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;
use terrafill_core::{Ellipsoid, Extent};
use terrafill_scene::{Camera, HeightRange, ImageSize};
use terrafill_surface::{
    Parameters, Surface, SurfaceError, SurfaceFrame, SurfaceKind, SurfacePart,
};

/// Name in scene files.
const KIND: &str = "screen-grid";

/// Cells along a side where a scene names none: the paper's normal use.
const DEFAULT_CELLS: u32 = 10;
/// The finest grid: 12,800 triangles.
const MAX_CELLS: u32 = 80;
/// Parts along a side of the screen: a region asks each part of a view whether it lies there.
const MAX_PARTS: u32 = 20;
/// How deep triangles may reach, of the smallest curvature radius: there normals begin to cross, and a
/// volume's bottom is lower than the surface by a thousandth and a clearance.
const DEEPEST: f64 = 0.99;
/// How high rounded vertices may lie in any view, of the radius: `f32` rounds an eye's distance to 2⁻²⁴ of it,
/// so this is enough from 16,000 radii away.
const HIGHEST: f64 = 1e-3;

/// Scenes over a grid on the screen: `kind = "screen-grid"` and
///
/// - `n`: cells along each side of the screen
/// - `limb`: what becomes of corners that miss the body, [`Limb`]
/// - `rays`: in what arithmetic vertices are found, [`Rays`]
#[derive(Debug, Clone, Copy)]
pub struct ScreenGridKind;

impl SurfaceKind for ScreenGridKind {
    fn name(&self) -> &'static str {
        KIND
    }

    fn open(
        &self,
        body: &Ellipsoid,
        parameters: &mut Parameters<'_>,
    ) -> Result<Arc<dyn Surface>, SurfaceError> {
        let cells = parameters.count("n", DEFAULT_CELLS, 1..=MAX_CELLS)?;
        let limb = parameters.word("limb", Limb::Snap.name(), &Limb::ALL.map(Limb::name))?;
        let rays = parameters.word("rays", Rays::F64.name(), &Rays::ALL.map(Rays::name))?;
        let mut limbs = Limb::ALL.into_iter();
        let mut arithmetics = Rays::ALL.into_iter();
        Ok(Arc::new(ScreenGrid {
            body: *body,
            options: GridOptions {
                cells,
                limb: limbs.find(|known| known.name() == limb).unwrap_or_default(),
                rays: arithmetics
                    .find(|known| known.name() == rays)
                    .unwrap_or_default(),
            },
        }))
    }
}

#[derive(Debug)]
struct ScreenGrid {
    body: Ellipsoid,
    options: GridOptions,
}

impl ScreenGrid {
    fn deepest_m(&self) -> f64 {
        -DEEPEST * self.body.smallest_curvature_radius_m()
    }

    /// Part of the screen that a cell belongs to.
    fn part_of(&self, cell: u32) -> u32 {
        let n = self.options.cells;
        let side = n.div_ceil(MAX_PARTS);
        cell / n / side * MAX_PARTS + cell % n / side
    }
}

impl Surface for ScreenGrid {
    fn kind(&self) -> &'static str {
        KIND
    }

    /// A cell as large as the body hangs nearly to its centre, wherever it is: what a view draws, its frame
    /// says.
    fn heights(&self, _extent: &Extent) -> HeightRange {
        HeightRange {
            lowest_m: self.deepest_m(),
            highest_m: HIGHEST * self.body.equatorial_radius_m(),
        }
    }

    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError> {
        let body = &self.body;
        let mesh = ScreenMesh::new(body, camera, size, self.options);
        let mesh = mesh.ok_or_else(|| SurfaceError::EyeBelow {
            kind: KIND,
            eye_height_m: body.ecef_to_geodetic(camera.eye_ecef).height_m,
        })?;
        let vertices_rte = mesh.rounded();
        let corner =
            |index: u32| DVec3::from(vertices_rte[index as usize].map(f64::from)) + camera.eye_ecef;
        let mut parts: BTreeMap<u32, SurfacePart> = BTreeMap::new();
        for (triangle, &cell) in mesh.triangles.iter().zip(&mesh.cells) {
            let corners = triangle.map(corner);
            let facet = SurfacePart {
                extent: extent(body, corners),
                heights: heights(body, corners),
            };
            let part = parts.entry(self.part_of(cell)).or_insert(facet);
            part.extent = united(part.extent, facet.extent);
            part.heights = part.heights.union(facet.heights);
        }
        let parts: Vec<SurfacePart> = parts.into_values().collect();
        let all = parts.iter().map(|part| part.heights);
        let heights = all.reduce(HeightRange::union).unwrap_or(HeightRange {
            lowest_m: 0.0,
            highest_m: 0.0,
        });
        if heights.lowest_m < self.deepest_m() {
            return Err(SurfaceError::TooDeep {
                kind: KIND,
                lowest_m: heights.lowest_m,
                allowed_m: self.deepest_m(),
            });
        }
        Ok(SurfaceFrame {
            vertices_rte: vertices_rte.into(),
            triangles: mesh.triangles.into(),
            heights,
            parts: parts.into(),
        })
    }
}
