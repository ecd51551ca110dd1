// SPDX-License-Identifier: MIT OR Apache-2.0
//! A frame that does not differ from the one before it asks the device for nothing: no buffer, no
//! pipeline, no upload, whatever the layout and the way of colouring; and what is counted is what
//! the work really was.

use crate::drawing;

use drawing::{
    AllTargets, Devices, SIZE, Technique, collection, counters, draw, draw_with, in_layout, look,
    made, polygon, scene, vertex, with_colour,
};
use terrafill_contract::{FillInput, GeometryBytes, PreparedScene, Technique as _};
use terrafill_core::Ellipsoid;
use terrafill_gpu::WorkDone;
use terrafill_scene::{ImageSize, Overlap};
use terrafill_surface::EllipsoidKind;
use terrafill_variant::{ColourWay, Switches};
use terrafill_vertex::{Layout, VertexTechnique, VertexVariant, shared_flag_bytes, variant_bytes};

fn two_squares() -> PreparedScene {
    let text = collection(&[
        polygon("west", "[[0,0],[4,0],[4,4],[0,4],[0,0]]"),
        polygon("east", "[[4,0],[9,0],[9,4],[4,4],[4,0]]"),
    ]);
    scene(&text, Ellipsoid::WGS84, 90, Overlap::Disjoint)
}

fn seen_from(scene: &PreparedScene, height_m: f64) -> FillInput {
    look(scene, (4.0, 2.0, height_m, 0.0, -90.0), 100.0, SIZE)
}

#[test]
fn the_second_unchanged_frame_makes_and_uploads_nothing() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let scene = two_squares();
    let (input, nearer) = (seen_from(&scene, 2e6), seen_from(&scene, 1e6));
    let targets = AllTargets::new(&devices, SIZE);
    for layout in Layout::ALL {
        for colour in ColourWay::ALL {
            let technique = in_layout(layout, with_colour(colour));
            let name = format!("{technique:?}");
            let mut backend = targets.open(technique);
            let mut frame = |input: &FillInput| made(&draw_with(&mut *backend, input));
            let [buffers, pipelines, uploads] = frame(&input);
            assert!(buffers >= 3 && pipelines >= 2 && uploads >= 2, "{name}");
            assert_eq!(frame(&input), [0, 0, 0], "{name}");
            // Negative control: another view writes its constants, into the buffer there is.
            assert_eq!(frame(&nearer), [0, 0, 1], "{name}");
            assert_eq!(frame(&nearer), [0, 0, 0], "{name}");
            // Nor does anything beside the fill: the device saw no work at all, surface included.
            let before = devices.wgpu.work_done();
            backend.prepare(&nearer).expect("fits");
            backend.time_frame(&nearer).expect("draws");
            assert_eq!(
                devices.wgpu.work_done() - before,
                WorkDone::default(),
                "{name}"
            );
        }
    }
}

#[test]
fn another_view_of_a_surface_writes_its_vertices_and_makes_nothing() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = two_squares();
    let finer = PreparedScene {
        surface: EllipsoidKind::surface(&scene.body, 120),
        ..scene.clone()
    };
    let [first, nearer] = [2e6, 1e6].map(|height_m| seen_from(&scene, height_m));
    let vertex_bytes = size_of_val(&*nearer.surface.vertices_rte) as u64;
    let done = |from: &FillInput, to: &FillInput| {
        // Of both interfaces what they did, and what they drew then.
        let targets = AllTargets::new(&devices, SIZE);
        let (mut wgpu, mut vulkan) = (targets.wgpu().borrow_mut(), targets.vulkan().borrow_mut());
        wgpu.prepare(from).expect("fits");
        vulkan.prepare(from).expect("fits");
        let before = [devices.wgpu.work_done(), devices.vulkan().work_done()];
        wgpu.prepare(to).expect("fits");
        vulkan.prepare(to).expect("fits");
        let after = [devices.wgpu.work_done(), devices.vulkan().work_done()];
        wgpu.draw_surface().expect("draws");
        vulkan.draw_surface().expect("draws");
        let pictures = [wgpu.read(), vulkan.read()].map(|read| read.expect("reads").depth);
        ([after[0] - before[0], after[1] - before[1]], pictures)
    };
    let (work, pictures) = done(&first, &nearer);
    // On Vulkan a view has a buffer of constants of its own.
    for (work, own) in work.into_iter().zip([0, 1]) {
        assert_eq!((work.buffer_creations, work.uploads), (own, 2));
        assert!((1..=1024).contains(&(work.upload_bytes - vertex_bytes)));
    }
    // Negative controls: another surface is handed over whole, and what is drawn does not depend on what was there.
    let (work, afresh) = done(&seen_from(&finer, 2e6), &nearer);
    let made = work.map(|work| (work.buffer_creations, work.uploads));
    assert_eq!(made, [(2, 3), (3, 3)]);
    assert!(pictures == afresh);
    assert!(done(&nearer, &first).1 != afresh);
}

#[test]
fn blocks_of_the_surface_that_a_view_leaves_out_change_no_pixel() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = two_squares();
    let drawn = |input: &FillInput| {
        let targets = AllTargets::new(&devices, SIZE);
        let (mut wgpu, mut vulkan) = (targets.wgpu().borrow_mut(), targets.vulkan().borrow_mut());
        wgpu.prepare(input).expect("fits");
        vulkan.prepare(input).expect("fits");
        wgpu.draw_surface().expect("draws");
        vulkan.draw_surface().expect("draws");
        let pictures = [wgpu.read(), vulkan.read()].map(|read| read.expect("reads"));
        pictures.map(|picture| (picture.rgba, picture.depth))
    };
    for (place, least_left_out) in [
        ((4.0, 2.0, 2e6, 0.0, -90.0), 0.8),
        ((4.0, 2.0, 3e3, 30.0, -8.0), 0.9),
        ((4.0, 2.0, 5e7, 0.0, -90.0), 0.4),
        ((100.0, 89.5, 1e5, 10.0, -30.0), 0.7),
    ] {
        let mut input = look(&scene, place, 100.0, SIZE);
        let by_blocks = drawn(&input);
        let shown = input.surface.shown.take().expect("has blocks");
        let all = input.surface.triangles.len();
        let left_out =
            1.0 - shown.iter().map(|range| range.len()).sum::<usize>() as f64 / all as f64;
        assert!(left_out > least_left_out, "{place:?}: {left_out}");
        let whole = drawn(&input);
        assert!(by_blocks == whole, "{place:?}");
        // Negative control: without some of what it shows it differs.
        let mut lacking = shown.to_vec();
        lacking.remove(shown.len() / 2);
        input.surface.shown = Some(lacking.into());
        let found = drawn(&input);
        let [wgpu, vulkan] = [0, 1].map(|device| found[device] != whole[device]);
        assert!(wgpu && vulkan, "{place:?}");
    }
}

#[test]
fn bytes_by_formula_are_the_bytes_handed_to_the_device() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let scene = two_squares();
    let input = seen_from(&scene, 2e6);
    let targets = AllTargets::new(&devices, SIZE);
    targets.wgpu().borrow_mut().prepare(&input).expect("fits");
    let mut totals = Vec::new();
    for name in [
        "doubled",
        "doubled,walls=list",
        "doubled,vertex-bytes=20",
        "doubled,index-order=cache",
        "separate",
        "separate,walls=list",
        "per-triangle",
        "pulled",
    ] {
        let mut variant = VertexTechnique.main(Overlap::Disjoint);
        let (layout, switches) = name.split_once(',').unwrap_or((name, ""));
        assert_eq!(variant.set("layout", layout), Ok(true));
        if let Some((key, value)) = switches.split_once('=') {
            assert_eq!(variant.set(key, value), Ok(true));
        }
        let variant = VertexVariant::of(&variant).expect("known names");
        let meshes = &scene.meshes;
        let regions: GeometryBytes = meshes
            .iter()
            .map(|mesh| variant_bytes(&variant, mesh))
            .sum();
        let formula = regions.total() + shared_flag_bytes(variant.layout, meshes);
        let before = devices.wgpu.work_done();
        let mut backend = targets.open(Technique::Vertex(variant));
        let memory = backend.prepare(&input).expect("fits");
        let done = devices.wgpu.work_done() - before;
        assert_eq!(memory.geometry_bytes(), formula, "{name}");
        assert_eq!(done.upload_bytes, formula + memory.constant_bytes, "{name}");
        assert_eq!(done.buffer_creations, memory.buffers, "{name}");
        totals.push(formula);
    }
    let [
        doubled,
        list,
        padded,
        ordered,
        separate,
        _,
        per_triangle,
        pulled,
    ] = totals[..]
    else {
        panic!("eight layouts");
    };
    assert_eq!(doubled, ordered);
    assert!(pulled < separate && separate < doubled && doubled < list);
    assert!(list < per_triangle && doubled < padded);
}

#[test]
fn pictures_for_people_leave_no_trace_in_the_next_frame() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let input = seen_from(&two_squares(), 2e6);
    let targets = AllTargets::new(&devices, SIZE);
    let mut backend = targets.open(vertex(Switches::default()));
    backend.prepare(&input).expect("fits");
    let first = backend.render(&input).expect("draws");
    backend.picture(&input).expect("draws");
    backend.prepare(&input).expect("fits");
    let again = backend.render(&input).expect("draws");
    assert_eq!(first.ids, again.ids);
}

/// Pixels of the widest region's rectangle, filled from above, count twice: top and bottom. The rest
/// of a volume seen from above is thin.
#[test]
fn every_fragment_of_the_stencil_work_is_counted() {
    let Some(devices) = Devices::open() else {
        return;
    };
    if !devices.wgpu.facts.features.pipeline_statistics {
        eprintln!("skipped: no pipeline statistics");
        return;
    }
    let input = seen_from(&two_squares(), 2e6);
    let targets = AllTargets::new(&devices, SIZE);
    let count = |input: &FillInput, switches: Switches, layout: Layout| {
        let frame = targets.draw(input, in_layout(layout, switches));
        let fragments = counters(&frame).stencil_fragments.expect("counted");
        (fragments, frame.filled_px())
    };
    for colour in ColourWay::ALL {
        let (fragments, filled) = count(&input, with_colour(colour), Layout::Doubled);
        let per_pixel = fragments as f64 / filled as f64;
        // Two caps, both larger than the filled area by the walls' height, and the walls.
        assert!((2.0..2.3).contains(&per_pixel), "{colour:?}: {per_pixel}");
    }
    // Negative controls: inner walls add fragments, and without the bottom about half are left.
    let (all, _) = count(&input, Switches::default(), Layout::Doubled);
    let (per_triangle, _) = count(&input, Switches::default(), Layout::PerTriangle);
    assert!(per_triangle > all, "{per_triangle} {all}");
    let mut front = Switches::default();
    assert_eq!(front.set("depth-rule", "automatic"), Ok(true));
    assert_eq!(front.set("bottom-cap", "where-needed"), Ok(true));
    let (without_bottom, _) = count(&input, front, Layout::Doubled);
    let share = without_bottom as f64 / all as f64;
    assert!((0.4..0.6).contains(&share), "{share}");
    // Nothing in view is no fragment.
    let away = look(&two_squares(), (120.0, 0.0, 1e5, 0.0, -90.0), 100.0, SIZE);
    assert_eq!(count(&away, Switches::default(), Layout::Doubled), (0, 0));
}

/// Whatever the fill needs is made through the counting functions of the device: a call past them
/// would make the counters lie.
#[test]
fn nothing_is_made_past_the_counters() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut checked = 0;
    let mut folders = ["devices/gpu/src", "techniques/vertex/src"]
        .map(|folder| root.join(folder))
        .to_vec();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("readable") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("readable");
            let name = path
                .file_name()
                .and_then(|name| name.to_str())
                .unwrap_or("");
            // Measuring: queries and read-back, which no fill needs; the deliberate error; and the counters
            // themselves.
            let exempt = [
                "work.rs",
                "readback.rs",
                "queries.rs",
                "statistics.rs",
                "deliberate_error.rs",
            ];
            let past = past_the_counters(&text);
            if exempt.contains(&name) {
                checked += usize::from(past);
            } else {
                assert!(!past, "{}", path.display());
            }
        }
    }
    // Negative control: where such calls are allowed they are found.
    assert!(checked >= 4, "{checked}");
}

fn past_the_counters(text: &str) -> bool {
    let joined: String = text.split_whitespace().collect();
    [
        "device.create_buffer(",
        "device.create_render_pipeline(",
        "raw.create_buffer(",
        "queue.write_buffer(",
    ]
    .iter()
    .any(|call| joined.contains(call))
}

#[test]
fn a_target_of_another_size_is_made_anew() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let scene = two_squares();
    let small = ImageSize::new(96, 64);
    let accumulated = vertex(with_colour(ColourWay::IdAccumulation));
    for size in [SIZE, small] {
        let input = look(&scene, (4.0, 2.0, 2e6, 0.0, -90.0), 100.0, size);
        let frame = draw(&devices, &input, accumulated);
        let plain = draw(&devices, &input, vertex(Switches::default()));
        assert_eq!(frame.ids, plain.ids);
        assert!(frame.filled_px() > 100);
    }
}
