// SPDX-License-Identifier: MIT OR Apache-2.0
//! The native backend held against the reference and, to the pixel, against the vertex backend:
//! every technique, way of colouring and depth rule on extreme regions and views; its bytes; its
//! steady state; and the controls that must be noticed.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use crate::drawing;

use drawing::sights::{self, square_from, three_regions_from};
use drawing::{
    AllTargets, Devices, SIZE, Technique, checks, counters, differing, draw, shipped, shown,
    square, storages, stored, vertex,
};
use terrafill_contract::{Counters, DeviceError, FillBackend as _};
use terrafill_native::{
    Extrusion as Native, Indices, NativeBackend, NativeVariant, native_bytes,
    walls_with_other_diagonal,
};
use terrafill_variant::{
    BottomCap, ColourWay, DepthRuleChoice, FacePasses, FirstPass, StencilClear, Switches,
};
use terrafill_vertex::{Layout, layout_bytes};

#[test]
fn both_ways_open_the_same_adapter() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (a, b) = (&devices.wgpu.facts, &devices.vulkan().facts);
    assert_eq!((&a.name, a.device_type), (&b.name, b.device_type));
    assert_eq!((a.vendor_id, a.device_id), (b.vendor_id, b.device_id));
    assert_eq!((&a.driver, &a.driver_info), (&b.driver, &b.driver_info));
    assert_eq!(a.features.timestamps, b.features.timestamps);
    assert_eq!(
        a.features.pipeline_statistics,
        b.features.pipeline_statistics
    );
}

/// Every technique with every kind of indices, drawn so.
fn techniques(switches: Switches) -> Vec<Technique> {
    let of = |(technique, indices)| stored(technique, indices, switches);
    storages().into_iter().map(of).collect()
}

/// With default switches, on these targets.
fn backend_of(targets: &AllTargets<'_>, technique: Native, indices: Indices) -> NativeBackend {
    let variant = NativeVariant {
        technique,
        indices: Some(indices),
        ..NativeVariant::default()
    };
    NativeBackend::new(targets.vulkan(), variant).expect("has the features")
}

/// Every way of colouring with every depth rule that is right everywhere.
fn ways_and_rules() -> Vec<Switches> {
    let mut all = Vec::new();
    for colour in ColourWay::ALL {
        for depth_rule in [DepthRuleChoice::Fail, DepthRuleChoice::Automatic] {
            all.push(Switches {
                colour,
                depth_rule,
                ..Switches::default()
            });
        }
    }
    all
}

/// Every technique with every other one of them, so that any two of technique, way and rule meet.
fn all_variants() -> Vec<Technique> {
    let all = ways_and_rules().into_iter().map(techniques).enumerate();
    let met = all.flat_map(|(way, techniques)| {
        let all = techniques.into_iter().enumerate();
        // The rule changes from way to way, that of colouring from two ways to the next.
        all.filter(move |(technique, _)| (way / 2 + way + technique) % 2 == 0)
    });
    met.map(|(_, technique)| technique).collect()
}

#[test]
fn a_hole_an_island_in_it_and_a_neighbour() {
    checks::assert_all_right(&sights::hole_island_and_neighbour(), &all_variants());
}

#[test]
fn across_the_antimeridian_and_over_the_poles() {
    checks::assert_all_right(&sights::seam_and_poles(), &all_variants());
}

#[test]
fn a_ten_metre_square_from_fifty_metres() {
    checks::assert_all_right(&sights::ten_metres(), &all_variants());
}

#[test]
fn other_bodies() {
    checks::assert_all_right(&sights::other_bodies(), &all_variants());
}

#[test]
fn shipped_scenes() {
    checks::assert_scenes_right(&checks::SHIPPED, techniques);
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn real_countries() {
    checks::assert_scenes_right(&checks::COUNTRIES, techniques);
}

#[test]
fn no_switch_changes_a_pixel() {
    let all: Vec<Technique> = some_switches().into_iter().flat_map(techniques).collect();
    checks::assert_no_switch_changes_a_pixel(&all);
}

#[test]
fn counting_in_front_is_wrong_from_inside_and_the_automatic_rule_knows() {
    checks::assert_forced_in_front_is_wrong_from_inside(&techniques(Switches::default()));
}

#[test]
fn broken_volumes_are_noticed() {
    checks::assert_broken_volumes_are_noticed(&techniques(Switches::default()));
}

/// Thousands of borders that two countries share, with numbers that descend along many of them. What
/// makes it pass is how vertices are numbered; that numbers as they come fail is shown where they
/// are given.
#[test]
fn volumes_of_single_triangles_leave_no_sliver_between_neighbours() {
    assert_no_sliver_between_neighbours(&["planet-134"]);
}

#[test]
#[ignore = "needs data: us-10m, natural-earth-110m, natural-earth-50m"]
fn volumes_of_single_triangles_leave_no_sliver_between_countries() {
    assert_no_sliver_between_neighbours(&["us-states", "countries-110m", "countries-50m"]);
}

fn assert_no_sliver_between_neighbours(names: &[&str]) {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    for &name in names {
        let (prepared, views) = shipped(name);
        for mesh in &*prepared.meshes {
            assert_eq!(walls_with_other_diagonal(mesh), 0, "{name}, {}", mesh.name);
        }
        let Some(view) = views.iter().find(|view| view.name == "globe") else {
            continue;
        };
        let input = shown(&prepared, view, square(512));
        let switches = Switches::for_overlap(prepared.overlap);
        let by_vertex = draw(&devices, &input, vertex(switches));
        let split = stored(Native::GsPerTriangle, Indices::List, switches);
        let frame = draw(&devices, &input, split);
        assert!(frame.filled_px() > 1000, "{name}");
        assert_eq!(differing(&frame, &by_vertex), 0, "{name}");
    }
}

/// Every switch that changes what a program does, each on its own and all that go together.
fn some_switches() -> Vec<Switches> {
    let base = Switches::default();
    let rectangle = Switches {
        colour: ColourWay::Rectangle,
        ..base
    };
    let accumulated = Switches {
        colour: ColourWay::IdAccumulation,
        ..base
    };
    let by_volume = Switches {
        colour: ColourWay::Volume,
        ..base
    };
    let where_needed = Switches {
        bottom_cap: BottomCap::WhereNeeded,
        depth_rule: DepthRuleChoice::Automatic,
        ..base
    };
    vec![
        Switches {
            faces: FacePasses::TwoPass,
            ..base
        },
        Switches {
            scissor: true,
            ..base
        },
        Switches {
            faces: FacePasses::TwoPass,
            scissor: true,
            ..accumulated
        },
        Switches {
            bottom_cap: BottomCap::WhereNeeded,
            depth_rule: DepthRuleChoice::Automatic,
            ..accumulated
        },
        where_needed,
        Switches {
            colour: ColourWay::Rectangle,
            ..where_needed
        },
        Switches {
            stencil_clear: StencilClear::ByColour,
            ..rectangle
        },
        Switches {
            cover_culls_faces: true,
            ..by_volume
        },
        Switches {
            cover_culls_faces: true,
            stencil_clear: StencilClear::ByColour,
            faces: FacePasses::TwoPass,
            scissor: true,
            colour: ColourWay::Volume,
            ..where_needed
        },
    ]
}

#[test]
fn bytes_are_what_the_formula_says_and_in_strips_less_than_half_of_doubled_vertices() {
    assert_bytes_are_what_the_formula_says(&["planet-134"]);
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-50m"]
fn bytes_of_the_countries_are_what_the_formula_says() {
    assert_bytes_are_what_the_formula_says(&["countries-110m", "countries-50m"]);
}

fn assert_bytes_are_what_the_formula_says(names: &[&str]) {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    for &name in names {
        let (prepared, views) = shipped(name);
        let input = shown(&prepared, &views[0], SIZE);
        let doubled: u64 = prepared
            .meshes
            .iter()
            .map(|mesh| layout_bytes(Layout::Doubled, mesh).total())
            .sum();
        for (technique, indices) in storages() {
            let targets = AllTargets::new(&devices, SIZE);
            let switches = Switches::for_overlap(prepared.overlap);
            let mut backend = targets.open(stored(technique, indices, switches));
            let memory = backend.prepare(&input).expect("fits");
            let formula: u64 = prepared
                .meshes
                .iter()
                .map(|mesh| native_bytes(technique, indices, mesh).total())
                .sum();
            let what = format!("{name}, {}/{}", technique.name(), indices.name());
            assert_eq!(memory.geometry_bytes(), formula, "{what}");
            assert_eq!(
                memory.upload_bytes,
                formula + memory.constant_bytes,
                "{what}"
            );
            let share = formula as f64 / doubled as f64;
            eprintln!("{what}: {formula} bytes, {share:.3} of vertex/doubled");
            match (technique, indices) {
                (Native::VsControl, _) => assert_eq!(formula, doubled, "{what}"),
                // Three indices an edge, or six a triangle: half, where a region has hardly a
                // vertex inside. It is the control of the strips, which do with less.
                (Native::GsDegenerate | Native::GsAdjacency, Indices::List) => {
                    assert!(share <= 0.51, "{what}: {share}");
                    assert!(share > 0.45, "{what}: {share}");
                }
                _ => assert!(share <= 0.45, "{what}: {share}"),
            }
        }
    }
}

#[test]
fn a_frame_needs_preparing_and_a_second_unchanged_one_makes_nothing() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let pose = (5.0, 5.0, 2e6, 0.0, -90.0);
    let [first, other] = [square_from(pose), square_from(pose)];
    for (technique, indices) in storages() {
        let targets = AllTargets::new(&devices, SIZE);
        let mut backend = backend_of(&targets, technique, indices);
        let error = backend.render(&first).expect_err("not prepared");
        assert_eq!(
            error.to_string(),
            "backend native is not prepared for view test of scene test"
        );
        assert!(backend.time_frame(&first).is_err());
        backend.prepare(&first).expect("fits");
        let frame = backend.render(&first).expect("draws");
        let start = counters(&frame);
        let draws = match technique {
            Native::VsControl | Native::GsLine | Native::GsPerTriangle => 3,
            _ => 2,
        };
        assert_eq!((start.draws, start.upload_bytes), (draws, 0));
        // Constants, vertices, and indices of the one width that the regions have.
        assert_eq!((start.buffer_creations, start.uploads > 0), (3, true));
        assert_eq!(start.pipeline_creations, draws);
        // The same again, prepared once more.
        let made = devices.vulkan().work_done();
        let memory = backend.prepare(&first).expect("fits");
        assert_eq!(memory.upload_bytes, 0);
        let twice = backend.render(&first).expect("draws");
        let again = counters(&twice);
        assert_eq!(devices.vulkan().work_done() - made, Default::default());
        assert_eq!(twice.ids, frame.ids);
        let nothing = Counters {
            buffer_creations: 0,
            pipeline_creations: 0,
            uploads: 0,
            ..start
        };
        assert_eq!(again, nothing, "{}", technique.name());
        assert!(backend.render(&other).is_err(), "another input");
        backend
            .time_frame(&first)
            .expect("the targets hold its surface");
        let mut second = backend_of(&targets, technique, indices);
        second.prepare(&other).expect("fits");
        second.draw_surface(&other).expect("draws");
        assert!(backend.time_frame(&first).is_err(), "over another surface");
        // Negative control: a changed input makes something.
        backend.prepare(&other).expect("fits");
        assert!((devices.vulkan().work_done() - made).uploads > 0);
    }
}

#[test]
fn geometry_shaders_make_the_triangles_that_the_vertex_shader_is_given() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    if !devices.vulkan().facts.features.pipeline_statistics {
        eprintln!("skipped: no pipeline statistics");
        return;
    }
    let pose = (5.0, 5.0, 2e6, 0.0, -90.0);
    let input = three_regions_from(pose);
    let meshes = input
        .plan
        .regions
        .iter()
        .map(|planned| &input.scene.meshes[planned.mesh]);
    let (mut caps, mut walls) = (0, 0);
    for mesh in meshes {
        caps += 2 * mesh.triangle_count() as u64;
        walls += 2 * mesh.boundary_edge_count() as u64;
    }
    let plain = Switches::default();
    for (technique, indices) in storages() {
        let frame = draw(&devices, &input, stored(technique, indices, plain));
        let counted = counters(&frame);
        let expected = match technique {
            // No geometry shader runs: nothing was counted.
            Native::VsControl => None,
            Native::GsPerTriangle => Some(4 * caps),
            _ => Some(caps + walls),
        };
        let made = counted.geometry_shader_primitives;
        assert_eq!(made, expected, "{}", technique.name());
        let control = stored(Native::VsControl, Indices::List, plain);
        let fragments = counters(&draw(&devices, &input, control)).stencil_fragments;
        assert!(fragments.is_some_and(|fragments| fragments > 0));
        if technique != Native::GsPerTriangle {
            assert_eq!(counted.stencil_fragments, fragments, "{}", technique.name());
        }
    }
}

#[test]
fn times_are_measured_and_pictures_in_the_regions_colours() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let pose = (5.0, 5.0, 2e6, 0.0, -90.0);
    let input = three_regions_from(pose);
    let targets = AllTargets::new(&devices, SIZE);
    let mut backend = backend_of(&targets, Native::default(), Indices::Strip);
    backend.prepare(&input).expect("fits");
    let surface = backend.draw_surface(&input).expect("draws");
    let times = backend.time_frame(&input).expect("draws");
    assert!(times.fill_cpu_ms > 0.0 && times.fill_wall_ms > 0.0);
    let parts = [times.stencil_gpu_ms, times.colour_gpu_ms, times.fill_gpu_ms];
    let timestamps = devices.vulkan().facts.features.timestamps;
    assert!(parts.iter().all(|part| part.is_some() == timestamps));
    assert_eq!(surface.is_some(), timestamps);
    let frame = backend.render(&input).expect("draws");
    let picture = backend.picture(&input).expect("draws");
    let again = backend.render(&input).expect("draws");
    assert_eq!(frame.ids, again.ids, "the picture's colours are taken back");
    let filled = |alpha: &[u8]| alpha[3] == 255;
    let count = picture.rgba.chunks_exact(4).filter(|p| filled(p)).count() as u64;
    assert_eq!(count, frame.filled_px());
}

#[test]
fn what_the_device_lacks_is_refused_by_name() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let with_fragments = NativeVariant {
        switches: Switches {
            first_pass: FirstPass::Colour,
            ..Switches::default()
        },
        ..NativeVariant::default()
    };
    match NativeBackend::new(targets.vulkan(), with_fragments) {
        Err(DeviceError::Unsupported { capability, .. }) => {
            assert_eq!(capability, "fragment programs in the first pass");
        }
        other => panic!("{:?}", other.err()),
    }
    // Negative control.
    assert!(NativeBackend::new(targets.vulkan(), NativeVariant::default()).is_ok());
}
