// SPDX-License-Identifier: MIT OR Apache-2.0
//! A flight from orbit to the ground with levels of detail that change on the way: the device is handed
//! constants, and nothing else that the view before had; what is made is made for more than there was.

use crate::drawing;

use drawing::{AllTargets, Devices, Technique, counters, draw_with, native, square, vertex};
use std::collections::HashSet;
use terrafill_contract::{Counters, FillInput, PreparedScene};
use terrafill_core::Geodetic;
use terrafill_native::Extrusion;
use terrafill_plan::PlanOptions;
use terrafill_scene::{CameraPose, ImageSize, Scene, View};
use terrafill_stencil::{FillPass, FillProgram, FillStep, StencilTest, VolumeList, VolumeState};
use terrafill_variant::{BottomCap, CoverArea, DepthRuleChoice, Switches};

pub(crate) const SIZE: ImageSize = square(96);

const FRAMES: u32 = 300;

pub(crate) fn leveled() -> PreparedScene {
    let scene = Scene::shipped("planet-134", None).expect("ships");
    let prepared = drawing::leveled(&scene);
    assert!(prepared.meshes.len() > scene.regions.len(), "one level");
    prepared
}

/// From 20,000 km above a coast down to 50 m, at first straight down, at last along the ground.
pub(crate) fn path(scene: &PreparedScene) -> Vec<FillInput> {
    let [longitude_deg, latitude_deg] = scene.meshes[0].vertices_deg[0];
    let plan = PlanOptions {
        boundary_lod_px: Some(0.5),
        sky_culling: true,
        interior: true,
        ..PlanOptions::default()
    };
    let seen = |frame: u32| {
        let share = f64::from(frame) / f64::from(FRAMES - 1);
        let height_m = 2e7 * (50.0_f64 / 2e7).powf(share);
        let view = View {
            name: format!("frame {frame}"),
            pose: CameraPose {
                eye: Geodetic::from_degrees(longitude_deg, latitude_deg, height_m),
                heading_rad: (40.0 * share).to_radians(),
                pitch_rad: (-90.0 + 80.0 * share * share).to_radians(),
                fov_y_rad: 45_f64.to_radians(),
                near_m: height_m * 1e-3,
            },
            note: None,
        };
        FillInput::new(scene, &view, SIZE, plan).expect("a surface")
    };
    (0..FRAMES).map(seen).collect()
}

fn switches(merges_draws: bool) -> Switches {
    Switches {
        merges_draws,
        cover_area: if merges_draws {
            CoverArea::Tiles
        } else {
            CoverArea::Rectangle
        },
        depth_rule: DepthRuleChoice::Automatic,
        bottom_cap: BottomCap::WhereNeeded,
        ..Switches::default()
    }
}

/// What a view's program draws, and in how many states.
#[derive(Clone, PartialEq)]
struct Work {
    /// Step by step the meshes of its volumes, and whether with their bottoms.
    drawn: Vec<(Vec<usize>, bool)>,
    /// Mesh of each volume: which level.
    meshes: Vec<usize>,
    states: HashSet<VolumeState>,
    tests: HashSet<StencilTest>,
    /// Rectangles of merged covers.
    covers: usize,
}

impl Work {
    fn of(input: &FillInput, technique: &Technique) -> Self {
        let switches = technique.switches();
        let list = VolumeList::of(input, &switches);
        let program = FillProgram::new(&list.volumes, &switches, input.scene.overlap);
        let program = program.expect("allowed");
        let mesh = |&volume: &usize| list.volumes[volume].geometry;
        let mut work = Self {
            drawn: Vec::new(),
            meshes: list.volumes.iter().map(|volume| volume.geometry).collect(),
            states: HashSet::new(),
            tests: HashSet::new(),
            covers: program.cover_instances(&list).len(),
        };
        for step in program.passes.iter().flat_map(FillPass::steps) {
            match step {
                FillStep::Volumes(draw) => {
                    let meshes = draw.volumes.iter().map(mesh).collect();
                    work.drawn.push((meshes, draw.without_bottom));
                    work.states.insert(draw.state);
                    // The pass that counts fragments.
                    work.states.insert(VolumeState::Count {
                        faces: draw.state.faces(),
                    });
                }
                FillStep::Cover(cover) => {
                    let test = cover.test;
                    // On Vulkan pipelines of covers differ in the number that they are of.
                    let is_native = matches!(technique, Technique::Native(_));
                    let reference = if is_native { test.reference } else { 0 };
                    work.tests.insert(StencilTest { reference, ..test });
                }
                FillStep::Resolve => {}
            }
        }
        work
    }

    fn volumes(&self) -> usize {
        self.meshes.len()
    }

    /// Caps and walls of each volume of a step.
    fn commands(&self) -> usize {
        self.drawn.iter().map(|(meshes, _)| 2 * meshes.len()).sum()
    }

    fn bottoms(&self) -> HashSet<usize> {
        let with = self
            .drawn
            .iter()
            .filter(|(_, without_bottom)| !without_bottom);
        with.flat_map(|(meshes, _)| meshes.iter().copied())
            .collect()
    }

    fn indices(&self, input: &FillInput) -> usize {
        let of_mesh = |without_bottom: bool, mesh: usize| {
            let mesh = &input.scene.meshes[mesh];
            let caps = if without_bottom { 1 } else { 2 };
            let loops = mesh.boundary_loops.len();
            3 * caps * mesh.triangles.len() + 2 * (mesh.boundary_edge_count() + loops) + loops
        };
        let steps = self.drawn.iter();
        let of_step = |(meshes, without_bottom): &(Vec<usize>, bool)| -> usize {
            meshes
                .iter()
                .map(|&mesh| of_mesh(*without_bottom, mesh))
                .sum()
        };
        steps.map(of_step).sum()
    }
}

/// What earlier frames made.
#[derive(Default)]
struct Seen {
    volumes: usize,
    indices: usize,
    commands: usize,
    covers: usize,
    bottoms: HashSet<usize>,
    states: HashSet<VolumeState>,
    tests: HashSet<StencilTest>,
}

/// What of a frame's work no change explains.
fn unexplained(
    technique: &Technique,
    before: &Work,
    (input, work): (&FillInput, &Work),
    seen: &Seen,
    found: &Counters,
) -> Option<String> {
    let merges = technique.switches().merges_draws;
    let merges_volumes = merges && matches!(technique, Technique::Vertex(_));
    // Constants, and with merged draws covers: the eye moved.
    let (mut uploads, mut buffers) = (1, 0);
    if merges {
        uploads += 1;
    }
    buffers += u64::from(work.volumes() > seen.volumes);
    // Those of covers have room for as many as a power of two.
    buffers += u64::from(merges && work.covers > seen.covers.next_power_of_two());
    if merges_volumes && work.drawn != before.drawn {
        uploads += 1;
    }
    if merges_volumes && work.meshes != before.meshes {
        uploads += 1;
    }
    if merges_volumes && work.indices(input) > seen.indices {
        buffers += 1;
    }
    if merges && !merges_volumes {
        uploads += u64::from(work.drawn != before.drawn || work.meshes != before.meshes);
        buffers += u64::from(work.commands() > seen.commands);
    }
    // Bottoms that no view needed before: all meshes once more, three buffers at most.
    if !merges_volumes && !work.bottoms().is_subset(&seen.bottoms) {
        uploads += 3;
        buffers += 3;
    }
    let states = work.states.difference(&seen.states).count() as u64;
    let tests = work.tests.difference(&seen.tests).count() as u64;
    // Caps, and walls of either width of indices.
    let pipelines = 4 * states + tests;
    let within = found.uploads <= uploads
        && found.buffer_creations <= buffers
        && found.pipeline_creations <= pipelines;
    (!within).then(|| {
        format!(
            "{} uploads of {uploads} explained, {} buffers of {buffers}, {} pipelines of {pipelines}",
            found.uploads, found.buffer_creations, found.pipeline_creations
        )
    })
}

#[test]
fn nothing_is_made_on_the_way_that_no_change_explains() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = leveled();
    let inputs = path(&scene);
    let targets = AllTargets::new(&devices, SIZE);
    for technique in [
        vertex(switches(false)),
        vertex(switches(true)),
        native(Extrusion::VsControl, switches(true)),
    ] {
        let mut backend = targets.open(technique);
        let (mut seen, mut before) = (Seen::default(), None::<Work>);
        let (mut level_changes, mut same_work, mut forgotten) = (0, 0, 0);
        for (frame, input) in inputs.iter().enumerate() {
            let work = Work::of(input, &technique);
            let found = counters(&draw_with(&mut *backend, input));
            if let Some(before) = &before {
                let why = unexplained(&technique, before, (input, &work), &seen, &found);
                assert_eq!(why, None, "frame {frame}: {technique:?}");
                let regions = |work: &Work| -> Vec<usize> {
                    let region = |&mesh: &usize| scene.meshes[mesh].region_index;
                    work.meshes.iter().map(region).collect()
                };
                let is_other_level =
                    work.meshes != before.meshes && regions(&work) == regions(before);
                level_changes += usize::from(is_other_level);
                same_work += usize::from(work.drawn == before.drawn);
                // Negative control: one that has forgotten everything makes what nothing explains.
                if frame % 100 == 50 {
                    let found = counters(&draw_with(&mut *targets.open(technique), input));
                    let why = unexplained(&technique, before, (input, &work), &seen, &found);
                    forgotten += usize::from(why.is_some());
                }
            }
            seen.volumes = seen.volumes.max(work.volumes());
            seen.indices = seen.indices.max(work.indices(input));
            seen.commands = seen.commands.max(work.commands());
            seen.covers = seen.covers.max(work.covers);
            seen.bottoms.extend(work.bottoms());
            seen.states.extend(&work.states);
            seen.tests.extend(&work.tests);
            before = Some(work);
        }
        eprintln!(
            "{technique:?}: {level_changes} level changes, {same_work} frames like the one before"
        );
        assert!(
            level_changes > 3 && same_work > 10,
            "{level_changes} {same_work}"
        );
        assert_eq!(forgotten, 3);
    }
}
