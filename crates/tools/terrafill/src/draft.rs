// SPDX-License-Identifier: MIT OR Apache-2.0
//! A file of regions as a scene file: what it lies on, whether its regions overlap, and cameras made from it.

use crate::arguments::{Edges, InitArguments, OwnArguments, SceneArguments, SceneVerb};
use crate::fit::{FOV_RAD, Fitted, fit, surface_rows};
use crate::input::is_standard;
use crate::outcome::{Failure, Outcome, print};
use crate::output::write_all;
use crate::registry::SURFACES;
use glam::DVec3;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use terrafill_core::{EdgeRule, Ellipsoid, Extent, Reading, Region, RegionMesh, Repair, Unwrap};
use terrafill_reference::Locator;
use terrafill_results::RunFolder;
use terrafill_scene::{CameraPose, ImageSize, Overlap, Scene};
use terrafill_surface::{Surface, open_surface};

/// Endings of files with regions.
const REGION_FILES: [&str; 6] = ["geojson", "json", "geojsonl", "geojsons", "ndjson", "gz"];
/// Endings of files with heights, as a folder of terrain has them.
const HEIGHT_FILES: [&str; 7] = ["tif", "tiff", "hgt", "dt0", "dt1", "dt2", "png"];

/// Facets of all regions together that are looked at for overlaps: enough to meet any that is seen at a glance,
/// and one that is missed makes pictures wrong, which the reference says.
const OVERLAP_PROBES: usize = 20_000;

/// From so many regions on, with none that dominates, the view from above looks at where they are densest.
const MANY_REGIONS: usize = 8;
/// Share of all area from which on a region dominates.
const DOMINANT_SHARE: f64 = 0.25;
/// As many regions as the densest part shows.
const SHOWN_OF_MANY: usize = 6;
/// Regions between which distances are looked at.
const MAX_NEIGHBOURS: usize = 2_000;
/// Largest facets of a region among which the middle is looked for.
const MIDDLE_PROBES: usize = 128;

/// Share of the distance to the boundary that a corner of a filled picture is away from its middle.
const FILLED_REACH: f64 = 0.9;
/// Lowest eye above the ground, metres.
const MIN_HEIGHT_M: f64 = 20.0;
/// Eye of the view along the horizon above the ground, share of the region's radius, and at most, metres.
const HORIZON_HEIGHT: (f64, f64) = (0.05, 2_000.0);
const HORIZON_PITCH_DEG: f64 = -4.0;

/// Whether a name on the command line is that of a file of regions rather than of a scene.
pub(crate) fn is_region_file(name: &str) -> bool {
    has_ending(Path::new(name), &REGION_FILES)
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| endings.contains(&ending.to_ascii_lowercase().as_str()))
}

/// A name for scenes made of a file: its own, in the letters that scenes may have.
pub(crate) fn name_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| match c.to_ascii_lowercase() {
        c @ ('a'..='z' | '0'..='9') => c,
        _ => '-',
    };
    let name: String = stem.chars().map(plain).collect();
    let name = name.trim_matches('-');
    if name.is_empty() { "regions" } else { name }.to_owned()
}

#[derive(Serialize)]
struct DraftScene {
    name: String,
    description: String,
    body: &'static str,
    edges: &'static str,
    overlap: &'static str,
    regions: DraftRegions,
    surface: DraftSurface,
    views: Vec<DraftView>,
}

#[derive(Serialize)]
struct DraftRegions {
    file: PathBuf,
    repair: &'static str,
    unwrap: &'static str,
    inside: &'static str,
}

#[derive(Serialize, Clone)]
struct DraftSurface {
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    rows: Option<i64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    files: Vec<DraftFile>,
}

#[derive(Serialize, Clone)]
struct DraftFile {
    path: PathBuf,
}

#[derive(Serialize)]
struct DraftView {
    name: &'static str,
    longitude_deg: f64,
    latitude_deg: f64,
    height_m: f64,
    heading_deg: f64,
    pitch_deg: f64,
    near_m: f64,
}

pub(crate) fn run(arguments: &SceneArguments) -> Result<Outcome, Failure> {
    let SceneVerb::Init(InitArguments {
        regions,
        own,
        out,
        size: (width, height),
    }) = &arguments.verb;
    let size = ImageSize::new(*width, *height);
    let text = scene_text(regions, own, size)?;
    if is_standard(out) {
        print(text)?;
    } else {
        write_all(&[(out.as_path(), text.into_bytes())])?;
    }
    Ok(Outcome::Done)
}

/// Refuses what is only for files of regions: a scene says the same itself.
pub(crate) fn refuse_for_scenes(own: &OwnArguments) -> Result<(), Failure> {
    let reading = own.reading();
    let usual = Reading::default();
    let given = [
        ("--terrain", !own.terrain.is_empty()),
        ("--edges", own.edges != Edges::Planar),
        ("--unwrap", reading.unwrap != Unwrap::Auto),
        ("--inside", reading.inside != usual.inside),
        ("--name", own.name.is_some()),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        None => Ok(()),
        Some((option, _)) => Err(Failure::bad_input(format!(
            "{option}: found with a scene, which says that itself, allowed: with a file of regions (.geojson or .json)"
        ))),
    }
}

/// Scenes as studies open them: a file of regions becomes a scene file in the run's folder, which further
/// processes find there.
///
/// - `out`: the run's folder
/// - `is_first`: this process begins the run, in a folder without one
pub(crate) fn written(
    scenes: &[String],
    own: &OwnArguments,
    size: ImageSize,
    out: &Path,
    is_first: bool,
) -> Result<Vec<String>, Failure> {
    if !scenes.iter().any(|scene| is_region_file(scene)) {
        refuse_for_scenes(own)?;
    }
    let written = |scene: &String| {
        if !is_region_file(scene) {
            return Ok(scene.clone());
        }
        let file = Path::new(scene);
        let name = own.name.clone().unwrap_or_else(|| name_of(file));
        let path = out.join("scenes").join(format!("{name}.toml"));
        if is_first {
            RunFolder::refuse_occupied(out).map_err(Failure::bad_input)?;
            let text = scene_text(file, own, size)?;
            std::fs::create_dir_all(out.join("scenes")).map_err(Failure::bad_input)?;
            std::fs::write(&path, text).map_err(Failure::bad_input)?;
        }
        Ok(path.display().to_string())
    };
    scenes.iter().map(written).collect()
}

/// The text of a scene file for the regions of `file`.
///
/// # Errors
/// As `mesh`, and for terrain that cannot be read.
pub(crate) fn scene_text(
    file: &Path,
    own: &OwnArguments,
    size: ImageSize,
) -> Result<String, Failure> {
    let body = Ellipsoid::WGS84;
    let edge_rule: EdgeRule = own.edges.into();
    let reading = own.reading();
    let Fitted {
        regions,
        meshes,
        pose: overview,
    } = fit(file, own, size)?;
    let absolute = |path: &Path| std::path::absolute(path).map_err(Failure::bad_input);
    let files = own.terrain.iter().map(|path| height_files(path));
    let files: Vec<PathBuf> = files.collect::<Result<Vec<_>, _>>()?.concat();
    let files = files.iter().map(|path| {
        Ok(DraftFile {
            path: absolute(path)?,
        })
    });
    let mut surface = DraftSurface {
        kind: if own.terrain.is_empty() {
            "ellipsoid"
        } else {
            "tiles"
        },
        rows: None,
        files: files.collect::<Result<Vec<_>, Failure>>()?,
    };
    let mut draft = DraftScene {
        name: own.name.clone().unwrap_or_else(|| name_of(file)),
        description: format!("{} regions of {}", regions.len(), file_name(file)),
        body: body.name(),
        edges: edge_rule.name(),
        overlap: overlap(&regions, &meshes, edge_rule, &body)?.name(),
        regions: DraftRegions {
            file: absolute(file)?,
            repair: Repair::from(own.repair).name(),
            unwrap: reading.unwrap.name(),
            inside: reading.inside.name(),
        },
        surface: surface.clone(),
        views: vec![view("all", &overview)],
    };
    // The surface is opened once with what is known, since heights of eyes are above it.
    let ground = if own.terrain.is_empty() {
        None
    } else {
        Some(opened(&draft, file)?)
    };
    let ground = Ground {
        body: &body,
        surface: ground.as_deref(),
    };
    let subject = Subject::of(&meshes);
    let poses = [
        ("all", ground.above(overview)),
        subject.looking_down(&ground, size),
        ("horizon", subject.horizon(&ground)),
    ];
    if own.terrain.is_empty() {
        let heights = poses.iter().map(|(_, pose)| pose.eye.height_m);
        surface.rows = Some(surface_rows(&body, heights.fold(f64::INFINITY, f64::min)));
    }
    draft.surface = surface;
    draft.views = poses.iter().map(|(name, pose)| view(name, pose)).collect();
    let text = toml::to_string_pretty(&draft).map_err(Failure::bad_input)?;
    Ok(format!(
        "# Made by terrafill from {}.\n{text}",
        file_name(file)
    ))
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// A file of heights, or all of a folder by name.
fn height_files(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let fail = |what: String| Failure::bad_input(format!("--terrain: {}: {what}", path.display()));
    let entries = std::fs::read_dir(path).map_err(|error| fail(error.to_string()))?;
    let entries = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<PathBuf> = entries
        .filter(|path| has_ending(path, &HEIGHT_FILES))
        .collect();
    files.sort();
    if files.is_empty() {
        let allowed = HEIGHT_FILES.join(", ");
        return Err(fail(format!(
            "found no file of heights, allowed: {allowed}"
        )));
    }
    Ok(files)
}

/// Whether some facet of a region lies in another region too.
fn overlap(
    regions: &[Region],
    meshes: &[RegionMesh],
    edge_rule: EdgeRule,
    body: &Ellipsoid,
) -> Result<Overlap, Failure> {
    let locator = Locator::new(regions, edge_rule, body).map_err(Failure::bad_input)?;
    let all: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let step = all.div_ceil(OVERLAP_PROBES).max(1);
    let mut facets = meshes.iter().flat_map(|mesh| {
        let middles = mesh.triangles.iter().map(|triangle| middle(mesh, triangle));
        middles.step_by(step)
    });
    let is_in_two = |middle: DVec3| {
        let place = body.ecef_to_geodetic(middle);
        let at = locator.locate(
            place.longitude_rad.to_degrees(),
            place.latitude_rad.to_degrees(),
        );
        at.regions.len() > 1 && at.disagree.is_empty()
    };
    Ok(if facets.any(is_in_two) {
        Overlap::Ordered
    } else {
        Overlap::Disjoint
    })
}

fn middle(mesh: &RegionMesh, triangle: &[u32; 3]) -> DVec3 {
    let corners = triangle.map(|corner| mesh.vertices_ecef[corner as usize]);
    corners.iter().sum::<DVec3>() / 3.0
}

/// The surface of a draft.
fn opened(draft: &DraftScene, file: &Path) -> Result<Arc<dyn Surface>, Failure> {
    let text = toml::to_string(draft).map_err(Failure::bad_input)?;
    let scene = Scene::from_toml(&text, &file_name(file), None).map_err(Failure::bad_input)?;
    open_surface(SURFACES, &scene).map_err(Failure::bad_input)
}

fn view(name: &'static str, pose: &CameraPose) -> DraftView {
    // Digits that a reader can change by hand, and far below a pixel.
    let round = |value: f64, digits: f64| (value * digits).round() / digits;
    DraftView {
        name,
        longitude_deg: round(pose.eye.longitude_rad.to_degrees(), 1e7),
        latitude_deg: round(pose.eye.latitude_rad.to_degrees(), 1e7),
        height_m: round(pose.eye.height_m, 1e2),
        heading_deg: round(pose.heading_rad.to_degrees(), 1e2),
        pitch_deg: round(pose.pitch_rad.to_degrees(), 1e2),
        near_m: round(pose.near_m, 1e3),
    }
}

/// What eyes must stay above.
struct Ground<'a> {
    body: &'a Ellipsoid,
    /// `None` of the bare body.
    surface: Option<&'a dyn Surface>,
}

impl Ground<'_> {
    /// Highest ground around a place, metres.
    fn highest_m(&self, at: DVec3, radius_m: f64) -> f64 {
        let Some(surface) = self.surface else {
            return 0.0;
        };
        let place = self.body.ecef_to_geodetic(at);
        let latitude_deg = place.latitude_rad.to_degrees();
        let longitude_deg = place.longitude_rad.to_degrees();
        let reach_deg = (radius_m / self.body.equatorial_radius_m()).to_degrees();
        let along_deg = reach_deg / place.latitude_rad.cos().max(1e-3);
        let extent = Extent {
            west_deg: (longitude_deg - along_deg).max(-180.0),
            south_deg: (latitude_deg - reach_deg).max(-90.0),
            east_deg: (longitude_deg + along_deg).min(180.0),
            north_deg: (latitude_deg + reach_deg).min(90.0),
        };
        surface.heights(&extent).highest_m
    }

    /// The same pose as high above the ground as it was above the body.
    fn above(&self, mut pose: CameraPose) -> CameraPose {
        let eye = self.body.geodetic_to_ecef(pose.eye);
        pose.eye.height_m += self.highest_m(eye, pose.eye.height_m).max(0.0);
        pose
    }

    /// An eye above a place.
    fn pose(&self, at: DVec3, height_m: f64, [heading_rad, pitch_rad]: [f64; 2]) -> CameraPose {
        let mut eye = self.body.ecef_to_geodetic(at);
        eye.height_m = height_m + self.highest_m(at, 2.0 * height_m).max(0.0);
        CameraPose {
            eye,
            heading_rad,
            pitch_rad,
            fov_y_rad: FOV_RAD,
            near_m: height_m * 1e-3,
        }
    }
}

/// What the two nearer cameras look at.
struct Subject<'a> {
    /// The region: that of the densest part, or the largest.
    mesh: &'a RegionMesh,
    /// Its place farthest from its boundary, ECEF.
    middle: DVec3,
    /// Distance from there to the boundary, metres.
    to_boundary_m: f64,
    /// Where many regions are dense: how far the sixth neighbour is, metres.
    neighbours_m: Option<f64>,
}

impl<'a> Subject<'a> {
    fn of(meshes: &'a [RegionMesh]) -> Self {
        let meshes: Vec<&RegionMesh> = meshes
            .iter()
            .filter(|mesh| !mesh.triangles.is_empty())
            .collect();
        let area: f64 = meshes.iter().map(|mesh| mesh.area_m2).sum();
        let largest = meshes.iter().max_by(|a, b| a.area_m2.total_cmp(&b.area_m2));
        // A file without regions was refused.
        let largest = *largest.unwrap_or(&meshes[0]);
        let is_one_of_many =
            meshes.len() >= MANY_REGIONS && largest.area_m2 < DOMINANT_SHARE * area;
        let densest = is_one_of_many.then(|| densest(&meshes));
        let (mesh, neighbours_m) = match densest {
            Some((mesh, distance_m)) => (mesh, Some(distance_m)),
            None => (largest, None),
        };
        let (middle, to_boundary_m) = innermost(mesh);
        Self {
            mesh,
            middle,
            to_boundary_m,
            neighbours_m,
        }
    }

    /// From straight above: the picture filled by the region, or where many are dense, some of them.
    fn looking_down(&self, ground: &Ground<'_>, size: ImageSize) -> (&'static str, CameraPose) {
        let half_fov = (0.5 * FOV_RAD).tan();
        let down = [0.0, -std::f64::consts::FRAC_PI_2];
        let (name, height_m) = if let Some(distance_m) = self.neighbours_m {
            ("dense", distance_m / (half_fov * size.aspect().min(1.0)))
        } else {
            let to_corner = half_fov * (1.0 + size.aspect().powi(2)).sqrt();
            ("filled", FILLED_REACH * self.to_boundary_m / to_corner)
        };
        let height_m = height_m.max(MIN_HEIGHT_M);
        (name, ground.pose(self.middle, height_m, down))
    }

    /// Along the ground, from above the boundary towards the middle.
    fn horizon(&self, ground: &Ground<'_>) -> CameraPose {
        let vertices = self.mesh.boundary_loops.iter().flatten();
        let vertices = vertices.map(|vertex| self.mesh.vertices_ecef[*vertex as usize]);
        let distance = |at: &DVec3| at.distance_squared(self.middle);
        let nearest = vertices.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let at = nearest.unwrap_or(self.middle);
        let place = ground.body.ecef_to_geodetic(at);
        let up = ground
            .body
            .geodetic_surface_normal(place.longitude_rad, place.latitude_rad);
        let (sin, cos) = place.longitude_rad.sin_cos();
        let east = DVec3::new(-sin, cos, 0.0);
        let ahead = self.middle - at;
        let heading_rad = ahead.dot(east).atan2(ahead.dot(up.cross(east)));
        let (share, most_m) = HORIZON_HEIGHT;
        let height_m = (share * self.to_boundary_m).clamp(MIN_HEIGHT_M, most_m);
        ground.pose(at, height_m, [heading_rad, HORIZON_PITCH_DEG.to_radians()])
    }
}

/// The region round which others are nearest, and how far the last of those that are to be shown is, metres.
fn densest<'a>(meshes: &[&'a RegionMesh]) -> (&'a RegionMesh, f64) {
    let step = meshes.len().div_ceil(MAX_NEIGHBOURS);
    let places: Vec<(&RegionMesh, DVec3)> = meshes
        .iter()
        .step_by(step)
        .map(|mesh| {
            let sum: DVec3 = mesh.vertices_ecef.iter().sum();
            (*mesh, sum / mesh.vertices_ecef.len() as f64)
        })
        .collect();
    let reach = |at: DVec3| {
        let mut distances: Vec<f64> = places
            .iter()
            .map(|(_, other)| at.distance(*other))
            .collect();
        distances.sort_by(f64::total_cmp);
        distances[SHOWN_OF_MANY.min(distances.len() - 1)]
    };
    let all = places.iter().map(|(mesh, at)| (*mesh, reach(*at)));
    let least = all.min_by(|a, b| a.1.total_cmp(&b.1));
    least.unwrap_or((meshes[0], 0.0))
}

/// The middle of a facet that is farthest from the boundary, and how far, metres.
fn innermost(mesh: &RegionMesh) -> (DVec3, f64) {
    let corners = |triangle: &[u32; 3]| triangle.map(|at| mesh.vertices_ecef[at as usize]);
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = corners(triangle);
        (b - a).cross(c - a).length_squared()
    };
    let mut triangles: Vec<&[u32; 3]> = mesh.triangles.iter().collect();
    triangles.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let edges: Vec<[DVec3; 2]> = mesh
        .boundary_loops
        .iter()
        .flat_map(|of| {
            let ends = of.iter().cycle().skip(1);
            let edges = of.iter().zip(ends);
            edges.map(|(a, b)| [*a, *b].map(|at| mesh.vertices_ecef[at as usize]))
        })
        .collect();
    let to_boundary = |at: DVec3| {
        let distances = edges.iter().map(|[a, b]| {
            let along = (*b - *a).length_squared();
            let share = if along > 0.0 {
                (at - *a).dot(*b - *a) / along
            } else {
                0.0
            };
            at.distance(a.lerp(*b, share.clamp(0.0, 1.0)))
        });
        distances.fold(f64::INFINITY, f64::min)
    };
    let middles = triangles.iter().take(MIDDLE_PROBES).map(|triangle| {
        let at = middle(mesh, triangle);
        // A region without a boundary is the whole body.
        (at, to_boundary(at).min(at.length()))
    });
    let farthest = middles.max_by(|a, b| a.1.total_cmp(&b.1));
    farthest.unwrap_or((mesh.vertices_ecef[0], 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::Geodetic;
    use terrafill_scene::Camera;

    const SIZE: ImageSize = ImageSize::new(100, 100);

    fn square(west: f64, south: f64, side: f64) -> String {
        let (east, north) = (west + side, south + side);
        format!(
            "[[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]]"
        )
    }

    /// A scene of these squares: west, south and side, degrees.
    fn scene(squares: &[[f64; 3]]) -> Scene {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("My Squares.geojson");
        let squares = squares
            .iter()
            .map(|[west, south, side]| square(*west, *south, *side));
        let squares: Vec<String> = squares.collect();
        let features = squares.iter().map(|square| {
            format!(
                r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":{square}}}}}"#
            )
        });
        let features: Vec<String> = features.collect();
        let text = format!(
            r#"{{"type":"FeatureCollection","features":[{}]}}"#,
            features.join(",")
        );
        std::fs::write(&file, text).expect("written");
        let line = ["terrafill", "scene", "init", "x.geojson"];
        let arguments = <crate::arguments::Arguments as clap::Parser>::try_parse_from(line);
        let crate::arguments::Verb::Scene(SceneArguments { verb }) =
            arguments.expect("a command").verb
        else {
            panic!("another verb");
        };
        let SceneVerb::Init(InitArguments { own, .. }) = verb;
        let text =
            scene_text(&file, &own, SIZE).unwrap_or_else(|failure| panic!("{}", failure.message));
        Scene::from_toml(&text, "draft.toml", None).expect("a scene")
    }

    fn camera(scene: &Scene, view: &str) -> Camera {
        let found = scene.views.iter().find(|own| own.name == view);
        let names: Vec<&str> = scene.views.iter().map(|own| own.name.as_str()).collect();
        let found = found.unwrap_or_else(|| panic!("{view}: {names:?}"));
        found.camera(&scene.body)
    }

    #[test]
    fn cameras_see_everything_one_region_alone_and_the_horizon() {
        let scene = scene(&[[10.0, 50.0, 0.5], [11.0, 50.0, 0.1]]);
        assert_eq!(
            (scene.name.as_str(), scene.overlap),
            ("my-squares", Overlap::Disjoint)
        );
        let at = |longitude, latitude| {
            let place = Geodetic::from_degrees(longitude, latitude, 0.0);
            scene.body.geodetic_to_ecef(place)
        };
        let is_inside = |[x, y]: [f64; 2]| (0.0..=100.0).contains(&x) && (0.0..=100.0).contains(&y);
        let all = camera(&scene, "all");
        for corner in [at(10.0, 50.0), at(10.5, 50.5), at(11.1, 50.1)] {
            assert!(all.project_px(SIZE, corner).is_some_and(is_inside));
        }
        // The larger square fills the picture to its corners, which nothing outside it is in.
        let filled = camera(&scene, "filled");
        for corner in [at(10.0, 50.0), at(10.5, 50.5), at(10.25, 50.5)] {
            assert!(!filled.project_px(SIZE, corner).is_some_and(is_inside));
        }
        let horizon = camera(&scene, "horizon");
        assert!(
            horizon
                .project_px(SIZE, at(10.25, 50.25))
                .is_some_and(is_inside)
        );
    }

    #[test]
    fn among_many_regions_the_view_looking_down_is_where_they_are_dense() {
        let sparse = (0..6).map(|i| [f64::from(i) * 5.0, 0.0, 0.5]);
        let dense = (0..9).map(|i| [40.0 + f64::from(i % 3), 20.0 + f64::from(i / 3), 0.5]);
        let squares: Vec<[f64; 3]> = sparse.chain(dense).collect();
        let scene = scene(&squares);
        let eye = scene
            .body
            .ecef_to_geodetic(camera(&scene, "dense").eye_ecef);
        assert!(
            (40.0..43.0).contains(&eye.longitude_rad.to_degrees()),
            "{eye:?}"
        );
        assert!(scene.views.iter().all(|view| view.name != "filled"));
    }

    #[test]
    fn overlaps_are_found_and_shared_borders_are_none() {
        let disjoint = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
        assert_eq!(scene(&disjoint).overlap, Overlap::Disjoint);
        assert_eq!(
            scene(&[[0.0, 0.0, 1.0], [0.2, 0.2, 0.4]]).overlap,
            Overlap::Ordered
        );
    }

    #[test]
    fn what_is_no_scene_name_becomes_one() {
        let names = ["My Squares.geojson", "a/42.json", "-.geojson"];
        assert_eq!(
            names.map(|name| name_of(Path::new(name))),
            ["my-squares", "42", "regions"]
        );
        assert!(is_region_file("x/Y.GeoJSON") && !is_region_file("california"));
    }
}
