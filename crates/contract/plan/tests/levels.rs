// SPDX-License-Identifier: MIT OR Apache-2.0
//! Levels of a scene, and that a plan's choice keeps its word on the screen: boundaries as written
//! and as drawn are projected and held against each other, pixel by pixel.

use glam::DVec3;
use terrafill_core::{Geodetic, RegionMesh};
use terrafill_plan::{
    DrawnAs, FEWEST_VERTICES_FOR_LEVELS, FramePlan, LEVEL_VERTEX_SHARE, LeveledMeshes, PlanOptions,
    PlanView, PlannedRegion, RegionBounds, SceneBounds,
};
use terrafill_scene::{Camera, ImageSize, LevelChoice, Scene};
use terrafill_surface::HeightRange;

fn is_flat(planned: &&PlannedRegion) -> bool {
    planned.drawn_as == DrawnAs::FlatMesh
}

const SIZE: ImageSize = ImageSize::new(1024, 1024);
const TERRAIN: HeightRange = HeightRange {
    lowest_m: -500.0,
    highest_m: 0.0,
};

struct Prepared {
    scene: Scene,
    leveled: LeveledMeshes,
    bounds: SceneBounds,
}

impl Prepared {
    fn new(name: &str) -> Self {
        Self::of(Scene::shipped(name, None).expect("needs no data"))
    }

    fn of(scene: Scene) -> Self {
        let leveled = LeveledMeshes::build(&scene, &scene.mesh).expect("meshes");
        let bounds = leveled
            .meshes
            .iter()
            .map(|mesh| RegionBounds::new(&scene.body, mesh, TERRAIN))
            .collect();
        Self {
            scene,
            leveled,
            bounds,
        }
    }

    fn plan(&self, camera: &Camera, pixels: Option<f64>) -> FramePlan {
        let options = PlanOptions {
            boundary_lod_px: pixels,
            ..PlanOptions::default()
        };
        self.plan_with(camera, options)
    }

    fn plan_with(&self, camera: &Camera, options: PlanOptions) -> FramePlan {
        let view = PlanView {
            body: &self.scene.body,
            camera,
            size: SIZE,
            terrain: TERRAIN,
        };
        let levels = &self.leveled.table;
        FramePlan::new(view, &self.bounds, levels, |_| None, options)
    }

    fn camera(&self, view: &str) -> Camera {
        let view = self.scene.views.iter().find(|found| found.name == view);
        view.expect("such a view").camera(&self.scene.body)
    }

    /// Largest distance, pixels, of a boundary as written from that of the mesh drawn for it, over
    /// all that is in the image.
    fn largest_shift_px(&self, camera: &Camera, plan: &FramePlan) -> f64 {
        let mut worst = 0.0_f64;
        for planned in &plan.regions {
            if planned.mesh == planned.region {
                continue;
            }
            let drawn = self.segments_px(camera, &self.leveled.meshes[planned.mesh]);
            let region = &self.scene.regions[planned.region];
            for (start, end) in region.rings().flat_map(|ring| ring.edges_deg()) {
                for share in [0.0, 0.25, 0.5, 0.75] {
                    let at = [0, 1].map(|axis| start[axis] + (end[axis] - start[axis]) * share);
                    let Some(pixel) = self.pixel(camera, at) else {
                        continue;
                    };
                    let nearest = drawn
                        .iter()
                        .map(|segment| distance_px(pixel, *segment))
                        .fold(f64::INFINITY, f64::min);
                    worst = worst.max(nearest);
                }
            }
        }
        worst
    }

    /// Where a place is in the image, if it is.
    fn pixel(&self, camera: &Camera, [longitude, latitude]: [f64; 2]) -> Option<[f64; 2]> {
        let body = &self.scene.body;
        let ecef = body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, 0.0));
        let pixel = camera.project_px(SIZE, ecef)?;
        let is_inside = |at: f64, count: u32| (0.0..=f64::from(count)).contains(&at);
        (is_inside(pixel[0], SIZE.width) && is_inside(pixel[1], SIZE.height)).then_some(pixel)
    }

    fn segments_px(&self, camera: &Camera, mesh: &RegionMesh) -> Vec<[[f64; 2]; 2]> {
        let pixel = |vertex: u32| -> Option<[f64; 2]> {
            let ecef: DVec3 = mesh.vertices_ecef[vertex as usize];
            camera.project_px(SIZE, ecef)
        };
        let mut segments = Vec::new();
        for ring in &mesh.boundary_loops {
            for (from, to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                if let (Some(from), Some(to)) = (pixel(*from), pixel(*to)) {
                    segments.push([from, to]);
                }
            }
        }
        segments
    }
}

fn distance_px(point: [f64; 2], [from, to]: [[f64; 2]; 2]) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let beside = [point[0] - from[0], point[1] - from[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 {
        ((beside[0] * along[0] + beside[1] * along[1]) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (beside[0] - share * along[0]).hypot(beside[1] - share * along[1])
}

#[test]
fn automatic_levels_each_have_fewer_vertices_and_a_known_deviation() {
    let prepared = Prepared::new("planet-134");
    let Prepared { scene, leveled, .. } = &prepared;
    let count = scene.regions.len();
    assert_eq!(leveled.ended_by, None);
    assert!(leveled.table.coarser.len() >= 4);
    assert_eq!(
        leveled.meshes.len(),
        count * (1 + leveled.table.coarser.len())
    );
    let edges = |meshes: &mut dyn Iterator<Item = usize>| -> usize {
        meshes
            .map(|mesh| leveled.meshes[mesh].boundary_edge_count())
            .sum()
    };
    let mut finer = edges(&mut (0..count));
    for level in &leveled.table.coarser {
        let here = edges(&mut level.meshes.iter().copied());
        assert!(here as f64 <= LEVEL_VERTEX_SHARE * finer as f64);
        finer = here;
        for (region, (&mesh, deviation_m)) in
            level.meshes.iter().zip(&level.deviation_m).enumerate()
        {
            assert_eq!(
                leveled.meshes[mesh].region_index,
                scene.regions[region].index
            );
            let chords_m = scene
                .mesh
                .boundary_tolerance_m
                .max(level.tolerance_m / 16.0);
            assert!(*deviation_m > 0.0 && *deviation_m <= level.tolerance_m + chords_m);
        }
    }
}

#[test]
fn few_vertices_or_an_empty_list_leave_one_level() {
    let mut scene = Scene::shipped("california", None).expect("needs no data");
    assert!(scene.regions[0].vertex_count() < FEWEST_VERTICES_FOR_LEVELS);
    let meshes = |scene: &Scene| {
        let leveled = LeveledMeshes::build(scene, &scene.mesh).expect("meshes");
        (leveled.meshes.len(), leveled.table.coarser.len())
    };
    assert_eq!(meshes(&scene), (1, 0));
    scene.levels = LevelChoice::Given(vec![1e3, 1e4]);
    assert_eq!(meshes(&scene), (3, 2));
    scene.levels = LevelChoice::Given(Vec::new());
    assert_eq!(meshes(&scene), (1, 0));
}

#[test]
fn what_is_drawn_stays_within_the_stated_pixels() {
    let prepared = Prepared::new("planet-134");
    for view in ["globe", "top-down", "horizon"] {
        let camera = prepared.camera(view);
        let mut simplified = 0;
        for pixels in [0.5, 1.0, 4.0] {
            let plan = prepared.plan(&camera, Some(pixels));
            simplified += plan
                .regions
                .iter()
                .filter(|planned| planned.mesh != planned.region)
                .count();
            let shift_px = prepared.largest_shift_px(&camera, &plan);
            assert!(shift_px <= pixels, "{view}: {shift_px} of {pixels}");
            if view == "globe" {
                // The bound is of use, and a bound half as large would be broken: the negative control.
                assert!(shift_px > 0.5 * pixels / 2.0, "{shift_px} of {pixels}");
            }
        }
        assert!(simplified > 0, "{view}");
    }
}

#[test]
fn a_wrong_choice_is_noticed_on_the_screen() {
    let prepared = Prepared::new("planet-134");
    let camera = prepared.camera("globe");
    let mut plan = prepared.plan(&camera, Some(0.5));
    assert!(prepared.largest_shift_px(&camera, &plan) <= 0.5);
    let coarser = &prepared.leveled.table.coarser;
    let coarsest = &coarser[coarser.len() - 1];
    plan.regions[0].mesh = coarsest.meshes[plan.regions[0].region];
    assert!(prepared.largest_shift_px(&camera, &plan) > 0.5);
}

#[test]
fn off_draws_every_region_as_written_and_says_nothing() {
    let prepared = Prepared::new("planet-134");
    let camera = prepared.camera("globe");
    let off = prepared.plan(&camera, None);
    assert!(
        off.regions
            .iter()
            .all(|planned| planned.mesh == planned.region)
    );
    let meshes = &prepared.leveled.meshes;
    assert!(!off.left_out_summary(meshes).contains("boundary detail"));
    let on = prepared.plan(&camera, Some(0.5));
    let edges = |plan: &FramePlan, mesh_of: fn(&PlannedRegion) -> usize| {
        let planned = plan.regions.iter();
        planned
            .map(|planned| meshes[mesh_of(planned)].boundary_edge_count())
            .sum::<usize>()
    };
    let (before, after) = (edges(&on, |p| p.region), edges(&on, |p| p.mesh));
    assert!(after < before / 2);
    let phrase = format!(
        "boundary detail below 0.5 px: {} of {before} vertices",
        before - after
    );
    assert!(on.left_out_summary(meshes).ends_with(&phrase));
}

#[test]
fn a_region_around_the_eye_is_drawn_as_written() {
    let prepared = Prepared::new("planet-134");
    let camera = prepared.camera("horizon");
    let plan = prepared.plan(&camera, Some(1000.0));
    let (inside, outside): (Vec<PlannedRegion>, Vec<PlannedRegion>) =
        plan.regions.iter().copied().partition(|planned| {
            let bounds = &prepared.bounds[planned.region].bounds;
            let local = bounds.axes.transpose() * (camera.eye_ecef - bounds.center_ecef);
            local.abs().cmple(bounds.half_extents_m).all()
        });
    assert!(!inside.is_empty() && !outside.is_empty());
    assert!(inside.iter().all(|planned| planned.mesh == planned.region));
    assert!(outside.iter().all(|planned| planned.mesh != planned.region));
}

/// Regions of a plan that are drawn flat, of all.
fn flat(plan: &FramePlan) -> (usize, usize) {
    let is_flat = |planned: &&PlannedRegion| planned.drawn_as == DrawnAs::FlatMesh;
    let flat = plan.regions.iter().filter(is_flat);
    (flat.count(), plan.regions.len())
}

#[test]
fn only_volumes_lower_than_the_stated_pixels_and_before_the_horizon_are_flat() {
    let prepared = Prepared::new("planet-134");
    let plan = |view: &str, far_level_px| {
        let options = PlanOptions {
            far_level_px,
            ..PlanOptions::default()
        };
        prepared.plan_with(&prepared.camera(view), options)
    };
    assert_eq!(flat(&plan("globe", None)).0, 0);
    let meshes = &prepared.leveled.meshes;
    let mut before = 0;
    for pixels in [0.05, 0.5, 5.0] {
        let plan = plan("globe", Some(pixels));
        let camera = prepared.camera("globe");
        let (count, all) = flat(&plan);
        assert!(count >= before, "{count} of {all}");
        before = count;
        for planned in plan.regions.iter().filter(is_flat) {
            for place in &meshes[planned.mesh].vertices_ecef {
                let normal = place.normalize();
                let ends = [planned.heights.top_m, planned.heights.bottom_m].map(|height_m| {
                    let end = *place + normal * height_m;
                    // Before the horizon: its own tangent plane lies below the eye.
                    assert!((camera.eye_ecef - end).dot(normal) > 0.0);
                    camera.project_px(SIZE, end).expect("before the eye")
                });
                let [across, down] = [0, 1].map(|axis| ends[0][axis] - ends[1][axis]);
                let found_px = across.hypot(down);
                assert!(found_px <= pixels * 1.001, "{found_px} of {pixels}");
            }
        }
        let said = plan.left_out_summary(meshes);
        let phrase = format!(
            "stencil of {count} of {all} regions, whose volumes are lower than {pixels} px"
        );
        assert_eq!(said.contains(&phrase), count > 0, "{said}");
    }
    assert!(before > 10, "{before}");
    // Negative controls: nearer, the same volumes are higher; and from two kilometres nearly all lie behind the
    // horizon or around the eye.
    assert_eq!(flat(&plan("top-down", Some(0.5))).0, 0);
    let low = plan("horizon", Some(1e6));
    assert!(flat(&low).0 < flat(&low).1, "{:?}", flat(&low));
}

/// Land, and a square island of the same region that is `width_deg` wide.
fn land_and_island(width_deg: f64) -> Prepared {
    let text = format!(
        "name = \"islands\"\ndescription = \"land and an island\"\nbody = \"wgs84\"\n[regions]\n\
         inline = '''{{\"type\":\"FeatureCollection\",\"features\":[{{\"type\":\"Feature\",\
         \"geometry\":{{\"type\":\"MultiPolygon\",\"coordinates\":[\
         [[[0,0],[9,0],[9,9],[4,9.1],[0,9],[0,0]]],\
         [[[12,0],[{east},0],[{east},{width_deg}],[12,{width_deg}],[12,0]]]]}}}}]}}'''\n\
         [surface]\nkind = \"ellipsoid\"\n[[views]]\nname = \"above\"\nlongitude_deg = 8\n\
         latitude_deg = 4\nheight_m = 2e7\nheading_deg = 0\npitch_deg = -90\nnear_m = 1000\n",
        east = 12.0 + width_deg
    );
    let mut scene = Scene::from_toml(&text, "islands.toml", None).expect("a scene");
    scene.levels = LevelChoice::Given(vec![20_000.0]);
    Prepared::of(scene)
}

#[test]
fn islands_below_a_quarter_pixel_are_left_out_and_counted_with_their_pixels() {
    // Of a level of 20 km, 0.05 degrees are less than half, 0.1 degrees are not.
    for (width_deg, left_out) in [(0.05, 1), (0.1, 0)] {
        let prepared = land_and_island(width_deg);
        let camera = prepared.camera("above");
        let plan = prepared.plan(&camera, Some(1.0));
        let planned = plan.regions[0];
        assert_ne!(planned.mesh, planned.region, "no level is drawn");
        let loops = |mesh: usize| prepared.leveled.meshes[mesh].boundary_loops.len();
        assert_eq!(loops(planned.region) - loops(planned.mesh), left_out);
        assert_eq!(plan.small_rings.rings, left_out);
        let said = plan.left_out_summary(&prepared.leveled.meshes);
        assert_eq!(
            said.contains("islands and lakes below"),
            left_out > 0,
            "{said}"
        );
        // Its pixels as seen from above, at least.
        let corner = |x: f64, y: f64| prepared.pixel(&camera, [12.0 + x, y]).expect("in view");
        let [a, b, c] = [
            corner(0.0, 0.0),
            corner(width_deg, 0.0),
            corner(0.0, width_deg),
        ];
        let sides = [b, c].map(|end| (end[0] - a[0]).hypot(end[1] - a[1]));
        let area_px = plan.small_rings.area_px;
        match left_out {
            0 => assert_eq!(area_px, 0.0),
            _ => assert!(area_px >= sides[0] * sides[1], "{area_px} of {sides:?}"),
        }
    }
    // Negative control: as written nothing is left out.
    let prepared = land_and_island(0.05);
    let plan = prepared.plan(&prepared.camera("above"), None);
    assert_eq!(plan.small_rings.rings, 0);
}
