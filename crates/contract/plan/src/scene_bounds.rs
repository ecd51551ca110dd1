// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bounds of a scene's meshes over its surface, each found when a plan first asks for it. A view draws one level
//! of a region, and needs no bounds of the others.

use crate::parts::grown;
use crate::{LazyMesh, RegionSet};
use rayon::prelude::*;
use std::ops::Index;
use std::sync::{Arc, OnceLock};
use terrafill_core::{Ellipsoid, MovingFootprint, OrientedBox, RegionMesh, VolumeHeights};
use terrafill_surface::{HeightRange, Surface, SurfaceFrame};

/// A region's volume and a box around it before any view is known: what a plan looks at, so that
/// planning a frame costs time per region, not per vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionBounds {
    /// Caps that contain the terrain.
    pub heights: VolumeHeights,
    /// Holds the volume between them.
    pub bounds: OrientedBox,
}

impl RegionBounds {
    /// Bounds of `mesh` over `terrain`.
    #[must_use]
    pub fn new(body: &Ellipsoid, mesh: &RegionMesh, terrain: HeightRange) -> Self {
        let heights = mesh.volume_heights(terrain.lowest_m, terrain.highest_m);
        Self {
            heights,
            bounds: mesh.oriented_box(body, heights),
        }
    }

    /// Bounds of a cone's footprint over `terrain`.
    #[must_use]
    pub fn of_footprint(
        body: &Ellipsoid,
        footprint: &MovingFootprint,
        terrain: HeightRange,
    ) -> Self {
        let heights = footprint.volume_heights(terrain.lowest_m, terrain.highest_m);
        Self {
            heights,
            bounds: footprint.oriented_box(body, heights),
        }
    }

    /// The same with its caps so much farther from the terrain, the top one `up_m` and the bottom one
    /// `down_m`. No vertex moves by more, so a box grown by as much on all sides holds them.
    pub(crate) fn grown(self, up_m: f64, down_m: f64) -> Self {
        Self {
            heights: VolumeHeights {
                top_m: self.heights.top_m + up_m,
                bottom_m: self.heights.bottom_m - down_m,
            },
            bounds: grown(&self.bounds, up_m.max(down_m)),
        }
    }
}

/// Bounds of each mesh over the heights of its own extent. Clones are the same bounds.
#[derive(Debug, Clone, Default)]
pub struct SceneBounds(Arc<[Cell]>);

#[derive(Debug, Clone)]
enum Cell {
    Known(RegionBounds),
    Later {
        found: OnceLock<RegionBounds>,
        source: Arc<Source>,
    },
}

/// What bounds are found from.
#[derive(Debug)]
struct Source {
    body: Ellipsoid,
    meshes: RegionSet,
    surface: Arc<dyn Surface>,
    /// A view that draws the surface between closer heights.
    drawn: Option<SurfaceFrame>,
}

impl SceneBounds {
    /// - `drawn`: the surface in the view that these are for, where that does not draw all of it
    #[must_use]
    pub fn new(
        body: &Ellipsoid,
        meshes: &RegionSet,
        surface: &Arc<dyn Surface>,
        drawn: Option<&SurfaceFrame>,
    ) -> Self {
        let source = Source::new(body, meshes, surface, drawn);
        Self(meshes.iter().map(|_| Cell::later(&source)).collect())
    }

    /// The same with others at some places, which must be there.
    #[must_use]
    pub fn with(&self, others: impl IntoIterator<Item = (usize, RegionBounds)>) -> Self {
        let mut cells = self.0.to_vec();
        for (place, bounds) in others {
            cells[place] = Cell::Known(bounds);
        }
        Self(cells.into())
    }

    /// The same for other meshes at some places, which must be there.
    #[must_use]
    pub fn with_changed(
        &self,
        body: &Ellipsoid,
        meshes: &RegionSet,
        surface: &Arc<dyn Surface>,
        changed: &[usize],
    ) -> Self {
        let source = Source::new(body, meshes, surface, None);
        let mut cells = self.0.to_vec();
        for &place in changed {
            cells[place] = Cell::later(&source);
        }
        Self(cells.into())
    }

    /// How many meshes there are.
    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// Those of a mesh; `None` where there is no such mesh.
    #[must_use]
    pub fn get(&self, mesh: usize) -> Option<&RegionBounds> {
        (mesh < self.0.len()).then(|| &self[mesh])
    }

    /// Finds those of these meshes that nobody asked for yet, together: a plan is about to.
    pub(crate) fn expect(&self, meshes: impl IntoIterator<Item = usize>) {
        let missing = |&mesh: &usize| match &self.0[mesh] {
            Cell::Later { found, source } if found.get().is_none() => Some((mesh, source)),
            _ => None,
        };
        let missing: Vec<_> = meshes
            .into_iter()
            .filter_map(|mesh| missing(&mesh))
            .collect();
        LazyMesh::make_all(missing.iter().map(|(mesh, source)| &source.meshes[*mesh]));
        missing.par_iter().for_each(|(mesh, _)| {
            let _: &RegionBounds = &self[*mesh];
        });
    }
}

impl FromIterator<RegionBounds> for SceneBounds {
    fn from_iter<I: IntoIterator<Item = RegionBounds>>(bounds: I) -> Self {
        Self(bounds.into_iter().map(Cell::Known).collect())
    }
}

impl Cell {
    fn later(source: &Arc<Source>) -> Self {
        Self::Later {
            found: OnceLock::new(),
            source: Arc::clone(source),
        }
    }
}

impl Source {
    fn new(
        body: &Ellipsoid,
        meshes: &RegionSet,
        surface: &Arc<dyn Surface>,
        drawn: Option<&SurfaceFrame>,
    ) -> Arc<Self> {
        Arc::new(Self {
            body: *body,
            meshes: meshes.clone(),
            surface: Arc::clone(surface),
            drawn: drawn.cloned(),
        })
    }

    fn find(&self, mesh: usize) -> RegionBounds {
        let mesh = &self.meshes[mesh];
        let stated = self.surface.heights(&mesh.extent);
        let drawn = self.drawn.as_ref();
        let drawn = drawn.map(|frame| frame.heights_over(&mesh.extent, stated));
        RegionBounds::new(&self.body, mesh, drawn.unwrap_or(stated))
    }
}

impl Index<usize> for SceneBounds {
    type Output = RegionBounds;

    fn index(&self, mesh: usize) -> &RegionBounds {
        match &self.0[mesh] {
            Cell::Known(bounds) => bounds,
            Cell::Later { found, source } => found.get().unwrap_or_else(|| {
                // Not while the cell is locked: a mesh may have to be made, by the pool's threads.
                let bounds = source.find(mesh);
                found.get_or_init(|| bounds)
            }),
        }
    }
}
