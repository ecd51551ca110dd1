// SPDX-License-Identifier: MIT OR Apache-2.0
//! Boundary levels of detail: a scene's regions meshed several times, each time with fewer boundary
//! vertices and a larger deviation, and for each view the coarsest that cannot be told apart.
//!
//! Regions that share a border always take the same level, or their borders would part. Level 0 is
//! every region as written; its meshes come first, in the order of the regions.

use crate::LazyMesh;
use crate::boundary_pieces::{SeenPiece, boundary_pieces};
use crate::lazy_mesh::{MeshSource, made};
use rayon::prelude::*;
use std::cell::OnceCell;
use std::sync::{Arc, OnceLock};
use terrafill_core::{
    EdgeRule, Ellipsoid, LeftOutRings, MeshError, MeshOptions, OrientedBox, Region, RegionMesh,
    SharedBoundaries, SimplifiedRegions, SimplifyError, ThinnedLevel, WarningSubject,
};
use terrafill_scene::{LevelChoice, Scene};

/// Scenes of fewer vertices than this have one level unless they ask for more: below it a fill
/// spends its time on pixels.
pub const FEWEST_VERTICES_FOR_LEVELS: usize = 5_000;
/// Growth of the deviation from one automatic level to the next. A view takes a level between half
/// of what it may deviate and all of it; four times as large, between a quarter and all.
pub const LEVEL_GROWTH: f64 = 2.0;
/// An automatic level must be drawn with at most this share of the boundary edges of the one before, or it is left
/// out. All levels together then hold at most four times the edges of level 0.
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
    /// Of each region, a bound on how far its boundary as drawn is from the region's own, metres: on what
    /// simplifying moved it, and on what the mesh's chords do beyond that.
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

/// A scene's regions at every level. Those of level 0 are meshed, which finds out what is wrong with them; a mesh
/// of another level is made when it is first looked at.
///
/// A program that wants none to be made between two frames gives a clone of [`LeveledMeshes::meshes`] to a thread that
/// calls [`LazyMesh::make_all`]. Clones are the same meshes.
#[derive(Debug, Clone, Default)]
pub struct LeveledMeshes {
    /// Level 0 in the order of the regions, then the others'.
    pub meshes: Vec<LazyMesh>,
    /// Which is which.
    pub table: LevelTable,
    /// Why there is no coarser level, where that is not because none would help.
    pub ended_by: Option<SimplifyError>,
}

impl LeveledMeshes {
    /// Meshes `scene` as it is written, and finds what is left of it at its levels.
    ///
    /// # Errors
    /// What keeps a region from being meshed as written.
    pub fn build(scene: &Scene, options: &MeshOptions) -> Result<Self, Vec<MeshError>> {
        let tolerances_m = tolerances_m(scene, options);
        let as_written = || -> Result<_, Vec<MeshError>> {
            let (body, rule) = (&scene.body, scene.edge_rule);
            let meshes = RegionMesh::build_all(&scene.regions, body, rule, options)?;
            let pieces = meshes.par_iter().map(|mesh| boundary_pieces(body, mesh));
            let boundaries = if tolerances_m.is_empty() {
                Vec::new()
            } else {
                pieces.collect()
            };
            Ok((meshes, boundaries))
        };
        let coarser =
            || (!tolerances_m.is_empty()).then(|| Levels::new(scene, options, &tolerances_m));
        let (as_written, coarser) = rayon::join(as_written, coarser);
        let (meshes, boundaries) = as_written?;
        let mut leveled = Self {
            meshes: meshes.into_iter().map(LazyMesh::from).collect(),
            ..Self::default()
        };
        match coarser {
            None => {}
            Some(Err(error)) => leveled.ended_by = Some(error),
            Some(Ok(levels)) => {
                leveled.table.neighbours = levels.shared.neighbours();
                leveled.table.boundaries = boundaries;
                leveled.add(levels);
            }
        }
        Ok(leveled)
    }

    fn add(&mut self, levels: Levels) {
        let regions = self.meshes.len();
        for source in levels.list {
            let first = self.meshes.len();
            let thinned = &source.thinned;
            self.table.coarser.push(Level {
                tolerance_m: thinned.tolerance_m,
                meshes: (first..first + regions).collect(),
                deviation_m: source.deviation_m.clone(),
                left_out: thinned.left_out.clone(),
            });
            let source = Arc::new(LevelSource {
                finer: self.meshes[first - regions..].to_vec(),
                ..source
            });
            let mesh = |region| LazyMesh::new(Arc::clone(&source) as _, region);
            self.meshes.extend((0..regions).map(mesh));
        }
    }
}

/// Coarser levels of a scene's regions.
struct Levels {
    shared: Arc<SharedBoundaries>,
    list: Vec<LevelSource>,
}

impl Levels {
    fn new(
        scene: &Scene,
        options: &MeshOptions,
        tolerances_m: &[f64],
    ) -> Result<Self, SimplifyError> {
        let (body, rule) = (scene.body, scene.edge_rule);
        let regions = Arc::clone(&scene.regions);
        let shared = Arc::new(SharedBoundaries::new(regions, &body, rule));
        let source = |thinned: ThinnedLevel| {
            let chords_m = thinned.tolerance_m * CHORD_SHARE;
            let chords_m = options.boundary_tolerance_m.max(chords_m);
            let options = MeshOptions {
                boundary_tolerance_m: chords_m,
                ..*options
            };
            let edges = shared.edge_count_of(&thinned, &options);
            let deviation_m = thinned.deviation_m.iter().map(|moved_m| moved_m + chords_m);
            let source = LevelSource {
                deviation_m: deviation_m.collect(),
                thinned,
                options,
                shared: Arc::clone(&shared),
                body,
                rule,
                finer: Vec::new(),
                regions: OnceLock::new(),
            };
            (edges, source)
        };
        let thinned = shared.thin(tolerances_m)?.into_par_iter();
        let counted: Vec<_> = thinned.map(source).collect();
        let mut fewest = shared.edge_count(options);
        let mut list = Vec::with_capacity(counted.len());
        for (edges, source) in counted {
            let is_much_less = edges as f64 <= LEVEL_VERTEX_SHARE * fewest as f64;
            if is_much_less || scene.levels != LevelChoice::Automatic {
                fewest = edges;
                list.push(source);
            }
        }
        Ok(Self { shared, list })
    }
}

/// What the meshes of a level are made from.
struct LevelSource {
    shared: Arc<SharedBoundaries>,
    body: Ellipsoid,
    rule: EdgeRule,
    options: MeshOptions,
    thinned: ThinnedLevel,
    /// Of each region, what its mesh may deviate by, metres.
    deviation_m: Vec<f64>,
    /// Of each region, its mesh at the next finer level.
    finer: Vec<LazyMesh>,
    /// Made before the first of its meshes.
    regions: OnceLock<SimplifiedRegions>,
}

impl LevelSource {
    fn regions(&self) -> &SimplifiedRegions {
        made(&self.regions, || self.shared.finish(&self.thinned))
    }

    fn mesh_of(&self, region: usize) -> Result<RegionMesh, String> {
        let regions = self.regions();
        let own = &regions.regions[region];
        let mesh = RegionMesh::build(own, &self.body, self.rule, &self.options);
        let moved_m = regions.deviation_m[region];
        mesh_within(mesh, moved_m, self.deviation_m[region])
    }
}

impl MeshSource for LevelSource {
    fn make_common(&self) {
        self.regions();
    }

    /// The mesh of a region at the level; that of the next finer one, with a warning, where there is none or it
    /// deviates by more than was said.
    fn make(&self, region: usize) -> RegionMesh {
        self.mesh_of(region).unwrap_or_else(|problem| {
            let mut instead = RegionMesh::clone(&self.finer[region]);
            let tolerance_m = self.thinned.tolerance_m;
            let warning =
                format!("level of {tolerance_m} m: {problem}; the next finer one stands for it");
            instead.warnings.push(WarningSubject::Mesh.warn(warning));
            instead
        })
    }
}

/// A mesh of a simplified region, or what is wrong with it.
///
/// - `moved_m`: what simplifying moved
/// - `allowed_m`: what simplifying and chords may move together
fn mesh_within(
    mesh: Result<RegionMesh, MeshError>,
    moved_m: f64,
    allowed_m: f64,
) -> Result<RegionMesh, String> {
    let mesh = mesh.map_err(|error| error.to_string())?;
    let found_m = mesh.boundary_deviation_m + moved_m;
    if found_m <= allowed_m {
        Ok(mesh)
    } else {
        Err(format!("off by {found_m} m, allowed: {allowed_m} m"))
    }
}

/// Deviations of the levels that `scene` has beside the one as written.
fn tolerances_m(scene: &Scene, options: &MeshOptions) -> Vec<f64> {
    match &scene.levels {
        LevelChoice::Given(tolerances_m) => tolerances_m.clone(),
        LevelChoice::Automatic if vertex_count(&scene.regions) < FEWEST_VERTICES_FOR_LEVELS => {
            Vec::new()
        }
        LevelChoice::Automatic => {
            let coarsest_m = scene.body.equatorial_radius_m() * COARSEST_LEVEL_SHARE;
            let first = Some(options.boundary_tolerance_m);
            std::iter::successors(first, |tolerance_m| Some(tolerance_m * LEVEL_GROWTH))
                .take_while(|tolerance_m| *tolerance_m <= coarsest_m)
                .collect()
        }
    }
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
    fn coarser_meshes_are_made_when_they_are_looked_at() {
        let scene = Scene::shipped("planet-134", None).expect("needs no data");
        let leveled = LeveledMeshes::build(&scene, &scene.mesh).expect("meshes");
        let count = scene.regions.len();
        let made = || leveled.meshes.iter().filter(|mesh| mesh.is_made()).count();
        assert_eq!(made(), count);
        let level = &leveled.table.coarser[2];
        let mesh = &leveled.meshes[level.meshes[5]];
        assert_eq!(mesh.region_index, scene.regions[5].index);
        assert!(mesh.warnings.is_empty() && mesh.boundary_deviation_m > 0.0);
        assert_eq!(made(), count + 1);
        LazyMesh::make_all(&leveled.meshes);
        assert_eq!(made(), leveled.meshes.len());
    }

    #[test]
    fn a_mesh_that_cannot_be_had_is_the_next_finer_one_and_says_so() {
        let scene = Scene::shipped("planet-134", None).expect("needs no data");
        let mut levels = Levels::new(&scene, &scene.mesh, &[1e3, 8e3]).expect("growing");
        let written =
            RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh);
        let level = &mut levels.list[1];
        level.finer = written
            .expect("meshes")
            .into_iter()
            .map(LazyMesh::from)
            .collect();
        let own = level.make(3);
        let as_written = level.finer[3].boundary_edge_count();
        assert!(own.boundary_edge_count() < as_written);
        assert!(own.warnings.is_empty());
        // Negative control: it moves by more than this.
        level.deviation_m[3] = 1e3;
        let instead = level.make(3);
        assert_eq!(instead.boundary_edge_count(), as_written);
        let [warning] = &instead.warnings[..] else {
            panic!("{:?}", instead.warnings);
        };
        assert!(
            warning.text.starts_with("level of 8000 m: off by "),
            "{warning}"
        );
        let refused = MeshError::NoArea {
            feature: 3,
            name: String::new(),
            long_edges: 0,
        };
        assert!(mesh_within(Err(refused), 0.0, f64::INFINITY).is_err());
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
        // Negative control: where the whole is enough nobody looks.
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
        // Negative control: without their borders each goes its own way.
        let apart = LevelTable {
            neighbours: Vec::new(),
            ..table()
        };
        assert_eq!(pick(&apart, &near_0, 0.5), [4, 9, 10, 11]);
    }

    #[test]
    fn every_mesh_is_one_of_one_region() {
        let regions: Vec<usize> = (0..12).map(|mesh| table().region_of(mesh, 12)).collect();
        assert_eq!(regions, [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3]);
        // Negative control: without levels each region has its one.
        let alone = LevelTable::default();
        assert_eq!([0, 1].map(|mesh| alone.region_of(mesh, 2)), [0, 1]);
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
