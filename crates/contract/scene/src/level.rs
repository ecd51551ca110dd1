// SPDX-License-Identifier: MIT OR Apache-2.0
//! Boundary levels of detail: a scene's regions meshed several times, each time with fewer boundary
//! vertices and a larger deviation, and for each view the coarsest that cannot be told apart.
//!
//! Regions that share a border always take the same level, or their borders would part. Level 0 is
//! every region as written; its meshes come first, in the order of the regions.

use crate::boundary_pieces::{SeenPiece, boundary_pieces};
use crate::{LevelChoice, Scene};
use rayon::prelude::*;
use std::cell::OnceCell;
use terrafill_core::{
    Ellipsoid, LeftOutRings, MeshError, MeshOptions, OrientedBox, Region, RegionMesh,
    SharedBoundaries, SimplifiedRegions,
};

/// Scenes of fewer vertices than this have one level unless they ask for more: below it a fill
/// spends its time on pixels.
pub const FEWEST_VERTICES_FOR_LEVELS: usize = 5_000;
/// Growth of the deviation from one automatic level to the next. A view takes a level between half
/// of what it may deviate and all of it; four times as large, between a quarter and all.
pub const LEVEL_GROWTH: f64 = 2.0;
/// An automatic level must have at most this share of the vertices of the one before, or it is left
/// out: all levels together then hold at most four times the vertices of level 0.
pub const LEVEL_VERTEX_SHARE: f64 = 0.75;
/// Share of a level's deviation that the chords of its meshes may add: as fine as those of level 0,
/// they would split the few long edges again, and as coarse as the deviation itself, neighbours
/// that come close without sharing a border would overlap.
const CHORD_SHARE: f64 = 1.0 / 16.0;
/// Deviation of the coarsest automatic level, share of the body's radius: 100 km on the Earth, four
/// pixels of an image of 1,024 rows that holds all of it.
const COARSEST_LEVEL_SHARE: f64 = 1.0 / 64.0;

/// A coarser level.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Deviation that simplifying was allowed, metres.
    pub tolerance_m: f64,
    /// Of each region, the index of its mesh; ascending.
    pub meshes: Vec<usize>,
    /// Of each region, how far its boundary as drawn is from the region's own, metres: what
    /// simplifying moved it, and what the mesh's chords do beyond that.
    pub deviation_m: Vec<f64>,
    /// Of each region, islands and lakes that the level leaves out.
    pub left_out: Vec<LeftOutRings>,
}

/// Which mesh is which region at which level.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LevelTable {
    /// The levels beyond level 0, finest first.
    pub coarser: Vec<Level>,
    /// Regions that must have the same level, the lower index first.
    pub neighbours: Vec<[usize; 2]>,
    /// Of each region, boxes that together hold its boundary on the ellipsoid.
    pub boundaries: Vec<Vec<OrientedBox>>,
}

/// A scene's regions meshed at every level.
#[derive(Debug, Clone, Default)]
pub struct LeveledMeshes {
    /// Level 0 in the order of the regions, then the others'.
    pub meshes: Vec<RegionMesh>,
    /// Which is which.
    pub table: LevelTable,
    /// Why there is no coarser level than the last, where that is not because none would help.
    pub ended_by: Option<String>,
}

impl LeveledMeshes {
    /// Meshes `scene` at its levels.
    ///
    /// # Errors
    /// What keeps a region from being meshed as written.
    pub fn build(scene: &Scene, options: &MeshOptions) -> Result<Self, Vec<MeshError>> {
        let (body, rule) = (&scene.body, scene.edge_rule);
        let tolerances_m = scene.levels.tolerances_m(&scene.regions, body, options);
        let (meshes, shared) = rayon::join(
            || RegionMesh::build_all(&scene.regions, body, rule, options),
            || {
                let has_levels = !tolerances_m.is_empty();
                has_levels.then(|| SharedBoundaries::new(&scene.regions, body, rule))
            },
        );
        let mut leveled = Self {
            meshes: meshes?,
            ..Self::default()
        };
        let Some(shared) = shared else {
            return Ok(leveled);
        };
        leveled.table.neighbours = shared.neighbours();
        let meshes = leveled.meshes.par_iter();
        leveled.table.boundaries = meshes.map(|mesh| boundary_pieces(body, mesh)).collect();
        let share = match scene.levels {
            LevelChoice::Automatic => LEVEL_VERTEX_SHARE,
            LevelChoice::Given(_) => f64::INFINITY,
        };
        let meshed = shared.simplify_each(&tolerances_m, share, |level| {
            (meshes_of(scene, options, &level), level)
        });
        let meshed = match meshed {
            Ok(meshed) => meshed,
            Err(error) => {
                leveled.ended_by = Some(error.to_string());
                return Ok(leveled);
            }
        };
        for (built, level) in meshed {
            match built {
                Ok(built) => leveled.add(scene, &level, built),
                Err(errors) => {
                    let first = errors.first().map(ToString::to_string).unwrap_or_default();
                    leveled.ended_by = Some(format!("at {} m: {first}", level.tolerance_m));
                    break;
                }
            }
        }
        Ok(leveled)
    }

    /// One more level; an automatic one is left out where what is drawn would not be less.
    fn add(&mut self, scene: &Scene, level: &SimplifiedRegions, built: Vec<RegionMesh>) {
        let finer = &self.meshes[self.meshes.len() - built.len()..];
        let share = boundary_edge_count(&built) as f64 / boundary_edge_count(finer) as f64;
        if scene.levels == LevelChoice::Automatic && share > LEVEL_VERTEX_SHARE {
            return;
        }
        let first = self.meshes.len();
        let deviations = built.iter().zip(&level.reports);
        self.table.coarser.push(Level {
            tolerance_m: level.tolerance_m,
            meshes: (first..first + built.len()).collect(),
            deviation_m: deviations
                .map(|(mesh, report)| mesh.boundary_deviation_m + report.deviation_m)
                .collect(),
            left_out: level.left_out.clone(),
        });
        self.meshes.extend(built);
    }
}

fn meshes_of(
    scene: &Scene,
    options: &MeshOptions,
    level: &SimplifiedRegions,
) -> Result<Vec<RegionMesh>, Vec<MeshError>> {
    let chords_m = level.tolerance_m * CHORD_SHARE;
    let options = MeshOptions {
        boundary_tolerance_m: options.boundary_tolerance_m.max(chords_m),
        ..*options
    };
    RegionMesh::build_all(&level.regions, &scene.body, scene.edge_rule, &options)
}

impl LevelChoice {
    fn tolerances_m(
        &self,
        regions: &[Region],
        body: &Ellipsoid,
        options: &MeshOptions,
    ) -> Vec<f64> {
        match self {
            Self::Given(tolerances_m) => tolerances_m.clone(),
            Self::Automatic if vertex_count(regions) < FEWEST_VERTICES_FOR_LEVELS => Vec::new(),
            Self::Automatic => {
                let coarsest_m = body.equatorial_radius_m() * COARSEST_LEVEL_SHARE;
                let first = Some(options.boundary_tolerance_m);
                std::iter::successors(first, |tolerance_m| Some(tolerance_m * LEVEL_GROWTH))
                    .take_while(|tolerance_m| *tolerance_m <= coarsest_m)
                    .collect()
            }
        }
    }
}

fn boundary_edge_count(meshes: &[RegionMesh]) -> usize {
    meshes.iter().map(RegionMesh::boundary_edge_count).sum()
}

fn vertex_count(regions: &[Region]) -> usize {
    regions.iter().map(Region::vertex_count).sum()
}

/// A region that a view draws, and how it sees its boundary.
#[derive(Debug, Clone)]
pub(crate) struct DrawnRegion {
    pub(crate) region: usize,
    /// All of it as one.
    pub(crate) whole: SeenPiece,
    /// Asked for where that is not enough to decide.
    pub(crate) pieces: OnceCell<Vec<SeenPiece>>,
}

impl DrawnRegion {
    pub(crate) fn new(region: usize, whole: SeenPiece) -> Self {
        Self {
            region,
            whole,
            pieces: OnceCell::new(),
        }
    }

    /// What a pixel is worth, metres, where it is worth least of all places of the boundary that the image may
    /// show when it moves by `deviation_m`; infinite where it shows none. Never more than it is.
    fn pixel_m(&self, deviation_m: f64) -> f64 {
        let of = |pieces: &[SeenPiece]| {
            let shown = pieces.iter().filter(|piece| piece.outside_m <= deviation_m);
            shown.fold(f64::INFINITY, |least, piece| least.min(piece.pixel_m))
        };
        let pieces = self.pieces.get().map_or(0.0, |pieces| of(pieces));
        pieces.max(of(&[self.whole]))
    }

    /// Whether its boundary may be `deviation_m` off and no more than `pixels` on the screen.
    ///
    /// - `look`: at the pieces of a region
    fn may_move(
        &self,
        deviation_m: f64,
        pixels: f64,
        look: impl FnOnce(usize) -> Vec<SeenPiece>,
    ) -> bool {
        let is_enough = || deviation_m <= pixels * self.pixel_m(deviation_m);
        is_enough() || {
            self.pieces.get_or_init(|| look(self.region));
            is_enough()
        }
    }
}

impl LevelTable {
    /// Of each region its meshes, the coarsest first and that of level 0 last.
    ///
    /// - `meshes`: how many there are of all levels
    #[must_use]
    pub fn meshes_of_regions(&self, meshes: usize) -> Vec<Vec<usize>> {
        let of_region = |region: usize| {
            let coarser = self.coarser.iter().rev();
            let coarser = coarser.map(|level| level.meshes[region]);
            coarser.chain([region]).collect()
        };
        (0..self.region_count(meshes)).map(of_region).collect()
    }

    /// Of which region a mesh is.
    ///
    /// - `meshes`: how many there are of all levels
    #[must_use]
    pub fn region_of(&self, mesh: usize, meshes: usize) -> usize {
        if mesh < self.region_count(meshes) {
            return mesh;
        }
        let mut places = self.coarser.iter();
        let place = places.find_map(|level| level.meshes.binary_search(&mesh).ok());
        place.unwrap_or(mesh)
    }

    /// - `meshes`: how many there are of all levels
    pub(crate) fn region_count(&self, meshes: usize) -> usize {
        let coarser = self.coarser.first();
        coarser.map_or(meshes, |level| level.meshes.len())
    }

    /// What the mesh of a drawn region leaves out, and how many pixels of it the image may show at most;
    /// nothing at level 0.
    pub(crate) fn left_out(&self, drawn: &DrawnRegion, mesh: usize) -> (LeftOutRings, f64) {
        let region = drawn.region;
        let mut own = self.coarser.iter();
        let own = own.find(|level| level.meshes[region] == mesh);
        own.map_or_else(Default::default, |level| {
            let left_out = level.left_out[region];
            let pixel_m = drawn.pixel_m(level.deviation_m[region]);
            (left_out, left_out.area_m2 / pixel_m.powi(2))
        })
    }

    /// Of each drawn region, the mesh of the coarsest level whose deviation stays within `pixels`
    /// on the screen for it and for everything it is connected to by borders that are drawn too.
    ///
    /// - `look`: at the pieces of a region's boundary
    pub(crate) fn pick(
        &self,
        drawn: &[DrawnRegion],
        pixels: f64,
        look: impl Fn(usize) -> Vec<SeenPiece>,
    ) -> Vec<usize> {
        let groups = self.groups(drawn);
        let mut meshes: Vec<usize> = drawn.iter().map(|drawn| drawn.region).collect();
        let mut is_open = vec![true; drawn.len()];
        for level in self.coarser.iter().rev() {
            let mut fits = is_open.clone();
            for (drawn, &group) in drawn.iter().zip(&groups) {
                let deviation_m = level.deviation_m[drawn.region];
                fits[group] = fits[group] && drawn.may_move(deviation_m, pixels, &look);
            }
            for (k, (drawn, &group)) in drawn.iter().zip(&groups).enumerate() {
                if fits[group] {
                    meshes[k] = level.meshes[drawn.region];
                }
            }
            for (group, fits) in fits.into_iter().enumerate() {
                is_open[group] &= !fits;
            }
        }
        meshes
    }

    /// Of each drawn region, the first of those it is connected to.
    fn groups(&self, drawn: &[DrawnRegion]) -> Vec<usize> {
        let mut parent: Vec<usize> = (0..drawn.len()).collect();
        let place = |region: usize| drawn.binary_search_by_key(&region, |drawn| drawn.region);
        for [a, b] in &self.neighbours {
            if let (Ok(a), Ok(b)) = (place(*a), place(*b)) {
                let (a, b) = (root(&mut parent, a), root(&mut parent, b));
                parent[a.max(b)] = a.min(b);
            }
        }
        (0..drawn.len()).map(|k| root(&mut parent, k)).collect()
    }
}

/// Root of a tree in a forest of parents, whose paths it halves on the way.
fn root(parent: &mut [usize], mut at: usize) -> usize {
    while parent[at] != at {
        parent[at] = parent[parent[at]];
        at = parent[at];
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two coarser levels of four regions, of which 0 – 1 – 2 are a chain and 3 is alone.
    fn table() -> LevelTable {
        let level = |first: usize, deviation_m: f64| Level {
            tolerance_m: deviation_m,
            meshes: (first..first + 4).collect(),
            deviation_m: vec![deviation_m; 4],
            left_out: vec![LeftOutRings::default(); 4],
        };
        LevelTable {
            coarser: vec![level(4, 10.0), level(8, 40.0)],
            neighbours: vec![[0, 1], [1, 2]],
            boundaries: Vec::new(),
        }
    }

    fn drawn(regions: &[(usize, f64)]) -> Vec<DrawnRegion> {
        let of = |&(region, pixel_m)| DrawnRegion::new(region, piece(pixel_m, 0.0));
        regions.iter().map(of).collect()
    }

    fn piece(pixel_m: f64, outside_m: f64) -> SeenPiece {
        SeenPiece { pixel_m, outside_m }
    }

    /// As if regions had no pieces but the whole.
    fn pick(table: &LevelTable, drawn: &[DrawnRegion], pixels: f64) -> Vec<usize> {
        table.pick(drawn, pixels, |_| Vec::from([piece(0.0, 0.0)]))
    }

    #[test]
    fn what_the_image_does_not_show_may_move_unless_it_moves_into_it() {
        // 10 m and 40 m are the deviations.
        for (outside_m, mesh) in [(0.0, 3), (10.0, 3), (20.0, 7), (50.0, 11)] {
            let pieces = vec![piece(100.0, 0.0), piece(1.0, outside_m)];
            let drawn = drawn(&[(3, 1.0)]);
            let picked = table().pick(&drawn, 0.5, |_| pieces.clone());
            assert_eq!(picked, [mesh], "{outside_m}");
        }
        // Twin: where the whole is enough nobody looks.
        let looked = |_| -> Vec<SeenPiece> { panic!("looked") };
        assert_eq!(table().pick(&drawn(&[(3, 80.0)]), 0.5, looked), [11]);
        let out_of_view = [DrawnRegion::new(3, piece(1.0, 50.0))];
        assert_eq!(table().pick(&out_of_view, 0.5, looked), [11]);
    }

    #[test]
    fn neighbours_take_the_level_of_the_nearest_of_them() {
        let near_0 = drawn(&[(0, 20.0), (1, 100.0), (2, 100.0), (3, 100.0)]);
        assert_eq!(pick(&table(), &near_0, 0.5), [4, 5, 6, 11]);
        assert_eq!(pick(&table(), &near_0, 0.4), [0, 1, 2, 11]);
        // Twin: without their borders each goes its own way.
        let apart = LevelTable {
            neighbours: Vec::new(),
            ..table()
        };
        assert_eq!(pick(&apart, &near_0, 0.5), [4, 9, 10, 11]);
    }

    #[test]
    fn every_mesh_is_one_of_one_region() {
        let of_regions = table().meshes_of_regions(12);
        assert_eq!(of_regions, [[8, 4, 0], [9, 5, 1], [10, 6, 2], [11, 7, 3]]);
        let regions: Vec<usize> = (0..12).map(|mesh| table().region_of(mesh, 12)).collect();
        assert_eq!(regions, [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3]);
        // Twin: without levels each region has its one.
        assert_eq!(LevelTable::default().meshes_of_regions(2), [[0], [1]]);
    }

    #[test]
    fn only_borders_that_are_drawn_connect() {
        let without_1 = drawn(&[(0, 0.0), (2, 100.0)]);
        assert_eq!(pick(&table(), &without_1, 1.0), [0, 10]);
    }

    #[test]
    fn a_level_that_one_of_them_cannot_take_is_taken_by_none() {
        let mut table = table();
        table.coarser[1].deviation_m[2] = 60.0;
        let all = drawn(&[(0, 100.0), (1, 100.0), (2, 100.0)]);
        assert_eq!(pick(&table, &all, 0.5), [4, 5, 6]);
    }
}
