// SPDX-License-Identifier: MIT OR Apache-2.0
//! The surface: tiles chosen for each view anew, from nothing but the view, so that whatever way a
//! camera came, it sees the same triangles.

use crate::bounds::TileView;
use crate::mesh::{TileVertices, draw, skirts};
use crate::select::{Choice, Rule, bend_m, choose};
use crate::store::Store;
use crate::tile::TileId;
use crate::tree::Tree;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use terrafill_core::{Ellipsoid, Extent, wrapped_deg};
use terrafill_elevation::Elevation;
use terrafill_scene::{Camera, ImageSize};
use terrafill_surface::{
    HeightRange, Parameters, PieceMemory, Refinement, Refining, Surface, SurfaceError,
    SurfaceFrame, SurfaceKind, read_elevation,
};

/// Name in scene files.
const KIND: &str = "tiles";

/// Error on the screen where a scene names none, pixels: what CesiumJS draws terrain with.
const DEFAULT_ERROR_PX: f64 = 2.0;
/// Side of a cell over its distance where a scene takes that rule and names no share. On a smooth Earth seen from 2 km
/// it is a quarter of a pixel at the horizon.
const DEFAULT_CELL_PER_DISTANCE: f64 = 0.2;
/// Triangles of a view where a scene names no limit: 12 MB of indices and vertices.
const DEFAULT_MAX_TRIANGLES: u32 = 600_000;
/// Memory for tiles where a scene names none: six times what the largest view draws.
const DEFAULT_MEMORY_MB: u32 = 64;
const MEGABYTE: u64 = 1_000_000;

/// Scenes over height tiles: `kind = "tiles"`, the elevation as [`read_elevation`] knows it, and
///
/// - `rule`: what makes a tile too coarse: `error`, its error on the screen, or `size`, that of its cells alone
/// - `error_px`: how far from the full resolution the surface may be on the screen, by rule `error`
/// - `cell_per_distance`: side of a cell over its distance from the eye, by rule `size`
/// - `max_triangles`: of a view, skirts not counted; beyond it the error grows
/// - `skirts`: whether gaps between tiles of different sizes are closed; without them there are cracks
/// - `memory_mb`: of tiles kept for further views
#[derive(Debug, Clone, Copy)]
pub struct TilesKind;

impl SurfaceKind for TilesKind {
    fn name(&self) -> &'static str {
        KIND
    }

    fn open(
        &self,
        body: &Ellipsoid,
        parameters: &mut Parameters<'_>,
    ) -> Result<Arc<dyn Surface>, SurfaceError> {
        let by_size = parameters.word("rule", "error", &["error", "size"])? == "size";
        let error_px = parameters.number("error_px", DEFAULT_ERROR_PX, 0.1..=1000.0)?;
        let share = DEFAULT_CELL_PER_DISTANCE;
        let share = parameters.number("cell_per_distance", share, 1e-3..=10.0)?;
        // The roots alone are 16,384.
        let limit = 32_768..=8_000_000;
        let max_triangles = parameters.count("max_triangles", DEFAULT_MAX_TRIANGLES, limit)?;
        let skirts = parameters.flag("skirts", true)?;
        let memory_mb = parameters.count("memory_mb", DEFAULT_MEMORY_MB, 1..=65_536)?;
        let elevation = read_elevation(body, parameters)?;
        Ok(Arc::new(Tiles {
            error_px,
            cell_per_distance: by_size.then_some(share),
            max_triangles,
            skirts,
            store: Mutex::new(Store::new(u64::from(memory_mb) * MEGABYTE)),
            ..Tiles::new(body, elevation)
        }))
    }
}

#[derive(Debug)]
pub(crate) struct Tiles {
    body: Ellipsoid,
    elevation: Elevation,
    /// Measured when it is first asked for: a plan of what to measure opens surfaces that nothing looks at.
    tree: OnceLock<Tree>,
    error_px: f64,
    /// Where tiles are split by their size alone.
    cell_per_distance: Option<f64>,
    max_triangles: u32,
    skirts: bool,
    store: Mutex<Store>,
}

impl Tiles {
    pub(crate) fn new(body: &Ellipsoid, elevation: Elevation) -> Self {
        Self {
            tree: OnceLock::new(),
            elevation,
            body: *body,
            error_px: DEFAULT_ERROR_PX,
            cell_per_distance: None,
            max_triangles: DEFAULT_MAX_TRIANGLES,
            skirts: true,
            store: Mutex::new(Store::new(u64::from(DEFAULT_MEMORY_MB) * MEGABYTE)),
        }
    }

    pub(crate) fn tree(&self) -> &Tree {
        self.tree.get_or_init(|| Tree::new(&self.elevation))
    }

    /// How far triangles of any tile, skirts included, may hang below the heights around them, metres.
    fn hang_m(&self) -> f64 {
        let bends = TileId::roots().map(|id| bend_m(&self.body, id));
        let bend_m = bends.fold(0.0, f64::max);
        // A facet hangs by its own bend; a skirt by two errors, each with its bend, and the rounding.
        let skirt_m = 2.0 * (self.tree().max_error_m() + bend_m);
        bend_m + skirt_m + 3e-6 * self.body.equatorial_radius_m()
    }

    fn sight(&self, camera: &Camera, size: ImageSize) -> TileView {
        let lowest_m = self.heights(&Extent::WHOLE).lowest_m;
        TileView::new(&self.body, camera, size, lowest_m)
    }

    fn rule(&self) -> Rule {
        match self.cell_per_distance {
            Some(allowed) => Rule::Size { allowed },
            None => Rule::Error {
                allowed_px: self.error_px,
            },
        }
    }

    fn choice(&self, sight: &TileView, is_there: &mut dyn FnMut(TileId) -> bool) -> Choice {
        choose(
            &self.body,
            self.tree(),
            sight,
            self.rule(),
            self.max_triangles,
            is_there,
        )
    }

    fn store(&self) -> MutexGuard<'_, Store> {
        // What a thread that panicked left is whole: tiles are put in and taken out one by one.
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A tile from the store, or else made and put there.
    fn vertices(&self, id: TileId) -> Arc<TileVertices> {
        let mut store = self.store();
        if store.touch(id)
            && let Some(vertices) = store.get(id)
        {
            return vertices;
        }
        drop(store);
        let vertices = Arc::new(TileVertices::new(&self.body, &self.elevation, id));
        self.store().keep(id, Arc::clone(&vertices));
        vertices
    }

    fn drawn(
        &self,
        camera: &Camera,
        sight: &TileView,
        choice: &Choice,
    ) -> Result<SurfaceFrame, SurfaceError> {
        let chosen = &choice.tiles;
        let depths = if self.skirts {
            skirts(chosen)
        } else {
            vec![[0.0; 4]; chosen.len()]
        };
        let drawn = draw(
            &self.body,
            &mut |id| self.vertices(id),
            sight,
            chosen,
            &depths,
        );
        Ok(SurfaceFrame {
            parts: drawn.parts.into(),
            ..drawn.mesh.frame(KIND, camera)?
        })
    }
}

impl Surface for Tiles {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn warnings(&self) -> &[String] {
        self.elevation.warnings()
    }

    /// Of the coarsest tiles and of the finest, whichever a view draws.
    fn heights(&self, extent: &Extent) -> HeightRange {
        // A triangle of the coarsest tiles reaches a cell beyond the place that it is over.
        let cell = TileId {
            level: 0,
            x: 0,
            y: 0,
        }
        .step_deg()
            * 1.25;
        let (south_deg, north_deg) = (extent.south_deg - cell, extent.north_deg + cell);
        let mut east = extent.east_deg;
        if east < extent.west_deg {
            east += 360.0;
        }
        let is_round = east - extent.west_deg + 2.0 * cell >= 360.0;
        let wide = if is_round || south_deg <= -90.0 || north_deg >= 90.0 {
            (-180.0, 180.0)
        } else {
            (
                wrapped_deg(extent.west_deg - cell),
                wrapped_deg(east + cell),
            )
        };
        let range = self.elevation.range(&Extent {
            west_deg: wide.0,
            south_deg: south_deg.max(-90.0),
            east_deg: wide.1,
            north_deg: north_deg.min(90.0),
        });
        HeightRange {
            lowest_m: range.lowest_m - self.hang_m(),
            highest_m: range.highest_m,
        }
    }

    fn true_height_m(&self, longitude_deg: f64, latitude_deg: f64) -> Option<f64> {
        Some(self.elevation.height_m(longitude_deg, latitude_deg))
    }

    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError> {
        let sight = self.sight(camera, size);
        self.store().begin_frame();
        let choice = self.choice(&sight, &mut |_| true);
        self.drawn(camera, &sight, &choice)
    }

    fn refining(&self) -> Option<&dyn Refining> {
        Some(self)
    }
}

impl Refining for Tiles {
    fn frame_now(
        &self,
        camera: &Camera,
        size: ImageSize,
    ) -> Result<(SurfaceFrame, Refinement), SurfaceError> {
        let sight = self.sight(camera, size);
        let choice = {
            let mut store = self.store();
            store.begin_frame();
            let choice = self.choice(&sight, &mut |id| store.touch(id));
            store.ask(choice.missing.clone());
            choice
        };
        let refinement = choice.refinement();
        Ok((self.drawn(camera, &sight, &choice)?, refinement))
    }

    fn refine(&self, most: usize) -> usize {
        let mut made = 0;
        while made < most {
            let Some(id) = self.store().next_wanted() else {
                break;
            };
            let vertices = Arc::new(TileVertices::new(&self.body, &self.elevation, id));
            self.store().keep(id, vertices);
            made += 1;
        }
        made
    }

    fn forget(&self) {
        self.store().forget();
    }

    fn set_budget(&self, bytes: u64) {
        self.store().set_budget(bytes);
    }

    fn memory(&self) -> PieceMemory {
        self.store().memory()
    }
}

#[cfg(test)]
mod tests;
