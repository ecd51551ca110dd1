// SPDX-License-Identifier: MIT OR Apache-2.0
//! Top caps without the facets that face away: the same picture to the pixel wherever the plan leaves some
//! out, and both kinds where it does not know that to be right.

use crate::drawing;

use drawing::by_main::prepared;
use drawing::{
    AllTargets, Devices, Technique, counters, differing, draw_with, figures, judge, shipped,
};
use terrafill_conformance::verdict;
use terrafill_core::Geodetic;
use terrafill_fill::{
    BottomCap, BottomCaps, CapFaces, Colours, DepthRule, DepthRuleChoice, Feature, FillCommand,
    FillInput, FillProgram, PreparedScene, RegionVolumes as _, StencilExecutor, StencilWork,
    Switches, VolumeConstants, VolumeList,
};
use terrafill_gpu::VolumeFill;
use terrafill_grid::GridKind;
use terrafill_native::{Extrusion, NativeVariant};
use terrafill_scene::{CameraPose, ImageSize, PlanOptions, Scene, View};
use terrafill_surface::{EllipsoidKind, SurfaceKind};
use terrafill_tiles::TilesKind;
use terrafill_vertex::{Layout, VertexVariant, VertexVolumes};

const KINDS: [&dyn SurfaceKind; 3] = [&EllipsoidKind, &GridKind, &TilesKind];

const SIZE: ImageSize = ImageSize {
    width: 256,
    height: 256,
};

pub(crate) fn cap_faces(front: bool) -> CapFaces {
    match front {
        true => CapFaces::Front,
        false => CapFaces::Both,
    }
}

fn switches(front_caps: bool) -> Switches {
    Switches {
        cap_faces: cap_faces(front_caps),
        depth_rule: DepthRuleChoice::Automatic,
        bottom_cap: BottomCap::WhereNeeded,
        scissor: true,
        ..Switches::default()
    }
}

/// Every way to draw caps apart from walls, on both interfaces.
fn techniques(switches: Switches) -> Vec<Technique> {
    let vertex = Layout::ALL.map(|layout| {
        Technique::Vertex(VertexVariant {
            layout,
            switches,
            ..VertexVariant::default()
        })
    });
    let native = [Extrusion::VsControl, Extrusion::GsLine].map(|technique| {
        Technique::Native(NativeVariant {
            technique,
            switches,
            ..NativeVariant::default()
        })
    });
    vertex.into_iter().chain(native).collect()
}

/// How many tops leave out facets, and of how many, as `needs` tells it.
fn freed(told: &str) -> (usize, usize) {
    let told = told.split("left out of ").nth(1).expect(told);
    let mut numbers = told.split(' ').filter_map(|word| word.parse().ok());
    let mut next = || numbers.next().expect(told);
    (next(), next())
}

/// What was seen so far.
#[derive(Default, Debug)]
struct Tally {
    views: usize,
    tops: usize,
    freed: usize,
    fewer_fragments: usize,
}

impl Tally {
    /// Draws with all facets and without some; the reference judges where it is asked.
    fn look(&mut self, targets: &AllTargets<'_>, input: &FillInput, is_judged: bool, what: &str) {
        let both = techniques(switches(false));
        let front = techniques(switches(true));
        let judged = is_judged.then(|| judge(input));
        for (index, (both, front)) in both.into_iter().zip(front).enumerate() {
            let all = draw_with(&mut *targets.open(both), input);
            let mut backend = targets.open(front);
            let some = draw_with(&mut *backend, input);
            assert_eq!(differing(&all, &some), 0, "{what}, {index}");
            if let Some(judged) = &judged {
                let found = figures(judged, &some);
                assert!(verdict(&found).is_pass(), "{what}, {index}: {found:?}");
                assert_eq!(found.mismatched_px_outside_band, 0, "{what}, {index}");
            }
            if index == 0 {
                let needs = backend.needs(input).expect("prepared").expect("told");
                let (freed, tops) = freed(&needs.of(Feature::TopCaps).expect("told").reason);
                self.tops += tops;
                self.freed += freed;
                let fragments = [&all, &some].map(|frame| counters(frame).stencil_fragments);
                self.fewer_fragments += usize::from(fragments[1] < fragments[0]);
            }
        }
        self.views += 1;
    }
}

/// Places and directions by a linear congruential generator.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        low + (high - low) * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// A view from `lowest_m` to 20,000 km up, mostly towards the horizon.
    fn view(&mut self, lowest_m: f64) -> View {
        let height_m = lowest_m * (2e7 / lowest_m).powf(self.between(0.0, 1.0));
        let horizon = (6_371e3 / (6_371e3 + height_m)).acos().to_degrees();
        View {
            name: "random".to_owned(),
            pose: CameraPose {
                eye: Geodetic::from_degrees(
                    self.between(-180.0, 180.0),
                    self.between(-80.0, 80.0),
                    height_m,
                ),
                heading_rad: self.between(0.0, 360.0).to_radians(),
                pitch_rad: (-horizon + self.between(-25.0, 10.0)).to_radians(),
                fov_y_rad: 45_f64.to_radians(),
                near_m: height_m * 1e-3,
            },
            note: None,
        }
    }
}

fn seen(scene: &PreparedScene, view: &View) -> FillInput {
    FillInput::new(scene, view, SIZE, PlanOptions::default()).expect("a surface")
}

#[test]
fn shipped_scenes_look_the_same_without_facets_that_face_away() {
    assert_front_caps_show_the_same(&["california", "planet-134"]);
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn countries_look_the_same_without_facets_that_face_away() {
    assert_front_caps_show_the_same(&["countries-110m"]);
}

fn assert_front_caps_show_the_same(names: &[&str]) {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    for &name in names {
        let (scene, views) = shipped(name);
        let mut tally = Tally::default();
        for view in &views {
            let input = seen(&scene, view);
            tally.look(&targets, &input, true, &format!("{name}/{}", view.name));
        }
        eprintln!("{name}: {tally:?}");
        assert!(tally.views > 0 && tally.freed > 0, "{name}: {tally:?}");
    }
}

#[test]
fn random_cameras_see_the_same_without_facets_that_face_away() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, _) = shipped("planet-134");
    let targets = AllTargets::new(&devices, SIZE);
    let (mut random, mut tally) = (Random(2007), Tally::default());
    for index in 0..40 {
        let input = seen(&scene, &random.view(2e4));
        let what = format!("{index}: {:?}", input.camera);
        tally.look(&targets, &input, index % 8 == 0, &what);
    }
    eprintln!("{tally:?}");
    // A check of nothing would pass: some tops leave facets out, and in some views that saves fragments.
    assert!(5 * tally.freed > tally.tops, "{tally:?}");
    assert!(tally.fewer_fragments > 5, "{tally:?}");
}

#[test]
fn terrain_looks_the_same_without_facets_that_face_away() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    for (name, surface) in [
        (
            "grid",
            "kind = \"grid\"\nrows = 240\nseed = 2007\namplitude_m = 9_000\n",
        ),
        (
            "tiles",
            "kind = \"tiles\"\nerror_px = 8\nbase = \"relief\"\nseed = 2007\namplitude_m = 9_000\n",
        ),
    ] {
        let text = format!(
            "name = \"terrain\"\ndescription = \"heights\"\nbody = \"wgs84\"\n[regions]\ninline = '''{}'''\n\
             [surface]\n{surface}[[views]]\nname = \"ridge\"\nlongitude_deg = 10\nlatitude_deg = 10\n\
             height_m = 1120\nheading_deg = 60\npitch_deg = -3\nnear_m = 0.5\n",
            drawing::collection(&[
                drawing::polygon(
                    "here",
                    "[[9.9,9.9],[10.05,9.9],[10.05,10.05],[9.9,10.05],[9.9,9.9]]"
                ),
                drawing::polygon("beyond", "[[11,8],[16,8],[16,14],[11,14],[11,8]]"),
                drawing::polygon("far", "[[20,-25],[60,-25],[60,35],[20,35],[20,-25]]"),
            ])
        );
        let scene = Scene::from_toml(&text, "terrain.toml", None).expect("a scene");
        let prepared = prepared(&KINDS, &scene);
        let (mut random, mut tally) = (Random(1862), Tally::default());
        let mut views = scene.views.clone();
        for _ in 0..6 {
            let mut view = random.view(1.2e4);
            view.pose.eye.longitude_rad = random.between(0.0, 1.0);
            view.pose.eye.latitude_rad = random.between(-0.4, 0.5);
            views.push(view);
        }
        for (index, view) in views.iter().enumerate() {
            let input = seen(&prepared, view);
            tally.look(
                &targets,
                &input,
                index == 0,
                &format!("{name} {index}: {view:?}"),
            );
        }
        eprintln!("{name}: {tally:?}");
        // The guard holds: ground rises behind some of them.
        assert!(tally.freed < tally.tops, "{name}: {tally:?}");
    }
}

/// Pixels that change where the program of the switch is changed, drawn by `vertex`.
fn differing_when(
    targets: &AllTargets<'_>,
    input: &FillInput,
    change: impl Fn(&mut FillCommand),
) -> usize {
    let switches = switches(true);
    let variant = VertexVariant {
        switches,
        ..VertexVariant::default()
    };
    let mut fill = <VolumeFill as StencilExecutor<VertexVolumes>>::new(targets.wgpu(), &switches);
    let fill = fill.as_mut().expect("opens");
    let mut volumes = VertexVolumes::new(fill, variant).expect("opens");
    let list = VolumeList::of(input, &switches);
    let mut program =
        FillProgram::new(&list.volumes, &switches, input.scene.overlap).expect("allowed");
    program
        .passes
        .iter_mut()
        .flat_map(|pass| &mut pass.commands)
        .for_each(change);
    StencilExecutor::<VertexVolumes>::set_view(fill, input.into()).expect("fits");
    volumes.upload(fill, input, &BottomCaps::All).expect("fits");
    let places = volumes.places().expect("uploaded");
    let constants = VolumeConstants::bytes_of_all(input, volumes.positions(), Colours::Ids, places);
    let work = StencilWork {
        list,
        program,
        constants,
        blends: false,
    };
    StencilExecutor::<VertexVolumes>::load(fill, work).expect("fits");
    fill.ensure(&mut volumes).expect("makes");
    StencilExecutor::<VertexVolumes>::draw_surface(fill).expect("draws");
    fill.draw(&mut volumes).expect("draws");
    let picture = StencilExecutor::<VertexVolumes>::read(fill).expect("reads");
    let all = draw_with(
        &mut *targets.open(drawing::vertex(self::switches(false))),
        input,
    );
    let changed = terrafill_fill::ids_of(&picture);
    all.ids.iter().zip(changed).filter(|(a, b)| *a != b).count()
}

/// What no check would notice, if these were right as well.
#[test]
fn what_the_switch_leaves_out_is_wrong_elsewhere() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, views) = shipped("planet-134");
    let targets = AllTargets::new(&devices, SIZE);
    let (mut over_the_sky, mut behind) = (0, 0);
    // Where tops stand before the sky: cameras at random as well.
    let mut random = Random(2007);
    let more = (0..40).map(|_| random.view(2e4));
    for view in views.into_iter().chain(more) {
        let input = seen(&scene, &view);
        assert_eq!(differing_when(&targets, &input, |_| ()), 0, "{}", view.name);
        // Covers that colour the sky too.
        over_the_sky += differing_when(&targets, &input, |command| {
            if let FillCommand::Cover { test, .. } = command {
                test.skips_sky = false;
            }
        });
        // Facets that face away count behind the surface.
        behind += differing_when(&targets, &input, |command| {
            if let FillCommand::Volumes {
                rule,
                without_bottom,
                ..
            } = command
            {
                rule.depth = DepthRule::Fail;
                *without_bottom = false;
            }
        });
    }
    eprintln!("{over_the_sky} pixels of sky, {behind} behind the surface");
    assert!(over_the_sky > 0 && behind > 0, "{over_the_sky} {behind}");
}
