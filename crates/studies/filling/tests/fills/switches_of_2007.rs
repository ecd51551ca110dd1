// SPDX-License-Identifier: MIT OR Apache-2.0
//! What repeats an experiment of 2007 shows the same picture as everything else, and does what it says:
//! its counters differ from its control's where they must, and nowhere else.

use crate::drawing;

use drawing::{
    AllTargets, Devices, SIZE, Technique, checks, counters, draw, figures, input, judge, polygon,
    sights::square_from,
};
use terrafill_conformance::{filled_only, verdict};
use terrafill_contract::{Counters, FillInput, Technique as _};
use terrafill_core::Ellipsoid;
use terrafill_native::{NativeBackend, NativeTechnique, NativeVariant};
use terrafill_plan::{NearRectangle, PlanOptions, WallHeights};
use terrafill_scene::Overlap;
use terrafill_variant::Variant;
use terrafill_vertex::{VertexTechnique, VertexVariant};

/// The document's way of colouring, with `settings` of one layout.
fn variant(settings: &[(&str, &str)]) -> Variant {
    let volumes = VertexTechnique.main(Overlap::Disjoint);
    let volumes = volumes.with("colour", "one-colour-volumes");
    let set = |variant: Variant, (key, value): &(&str, &str)| variant.with(key, value);
    settings.iter().fold(volumes, set)
}

fn technique(settings: &[(&str, &str)]) -> Technique {
    Technique::Vertex(VertexVariant::of(&variant(settings)).expect("known names"))
}

/// Every value that is not the default, and what it goes with.
const SETTINGS: [&[(&str, &str)]; 19] = [
    &[("buffers", "streamed")],
    &[("buffers", "streamed"), ("layout", "per-triangle")],
    &[("buffers", "streamed"), ("layout", "pulled")],
    &[("vertex-order", "first-use")],
    &[("vertex-order", "first-use"), ("index-order", "cache")],
    &[("vertex-order", "first-use"), ("layout", "pulled")],
    &[("vertex-order", "first-use"), ("layout", "per-triangle")],
    &[("bottom-cap", "first-pass")],
    &[("bottom-cap", "first-pass"), ("cover-faces", "culled")],
    &[("bottom-cap", "first-pass"), ("colour", "volume")],
    &[("first-pass", "colour")],
    &[("first-pass", "program"), ("faces", "two-pass")],
    &[
        ("first-pass", "program-colour"),
        ("depth-rule", "automatic"),
    ],
    &[("bottom", "pixels"), ("layout", "separate")],
    &[("normals", "stored")],
    &[("normals", "stored"), ("layout", "separate")],
    &[("normals", "stored"), ("layout", "per-triangle")],
    &[("normals", "stored"), ("layout", "pulled")],
    &[("normals", "stored"), ("bottom", "pixels")],
];

#[test]
fn no_experiment_changes_a_pixel() {
    checks::assert_no_switch_changes_a_pixel(&SETTINGS.map(technique));
}

/// Counters of the second frame: what is done once is done.
fn drawn(devices: &Devices, input: &FillInput, settings: &[(&str, &str)]) -> Counters {
    let targets = AllTargets::new(devices, SIZE);
    let mut backend = targets.open(technique(settings));
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws");
    counters(&backend.render(input).expect("draws"))
}

#[test]
fn geometry_is_handed_over_in_every_frame_where_it_is_streamed_and_never_where_it_is_kept() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let input = square_from((5.0, 5.0, 2e6, 0.0, -90.0));
    let kept = drawn(&devices, &input, &[]);
    let streamed = drawn(&devices, &input, &[("buffers", "streamed")]);
    let mesh = &input.scene.meshes[0];
    let vertices = VertexTechnique
        .bytes(&variant(&[]), mesh, true)
        .expect("its own");
    // The device is written to in words, and a list of 16-bit indices may end in half of one.
    let total = vertices.total().next_multiple_of(4);
    assert_eq!((kept.upload_bytes, kept.uploads), (0, 0));
    assert_eq!((streamed.upload_bytes, streamed.uploads), (total, 2));
    assert_eq!(streamed.vertices, kept.vertices);
}

#[test]
fn walls_reach_as_far_as_they_are_said_to() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let input = square_from((5.0, -20.0, 2e6, 0.0, -30.0));
    let region = drawn(&devices, &input, &[]);
    let pixels = drawn(&devices, &input, &[("bottom", "pixels")]);
    let plan = PlanOptions {
        wall_heights: WallHeights::Global,
        ..PlanOptions::default()
    };
    let taller = input.remeshed(&input.scene, plan);
    let heights = taller.plan.regions[0].heights;
    assert!(
        heights.top_m > 12_000.0 && heights.bottom_m < -12_000.0,
        "{heights:?}"
    );
    let global = drawn(&devices, &taller, &[]);
    assert_eq!([pixels.vertices, global.vertices], [region.vertices; 2]);
    // Seen from the side, a taller wall has more fragments, where the device counts them.
    if let Some(least) = region.stencil_fragments {
        assert!(pixels.stencil_fragments > Some(least), "{pixels:?}");
        assert!(global.stencil_fragments > Some(least), "{global:?}");
    }
}

#[test]
fn the_bottom_cap_is_left_out_of_colouring_alone_and_not_from_inside() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let vertices = |input: &FillInput, bottom_cap| {
        drawn(&devices, input, &[("bottom-cap", bottom_cap)]).vertices
    };
    let outside = square_from((5.0, 5.0, 2e6, 0.0, -90.0));
    let cap = 3 * outside.scene.meshes[0].triangle_count() as u64;
    let always = vertices(&outside, "always");
    assert_eq!(vertices(&outside, "first-pass"), always - cap);
    // Behind the surface every cap counts.
    assert_eq!(vertices(&outside, "where-needed"), always - cap);
    let inside = square_from((5.0, 9.0, 300.0, 0.0, -5.0));
    assert_eq!(inside.plan.regions[0].near_rectangle, NearRectangle::Within);
    let always = vertices(&inside, "always");
    assert_eq!(vertices(&inside, "first-pass"), always);
}

#[test]
fn fragments_of_the_first_pass_need_an_interface_that_can_leave_them_out() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    let open = |first_pass: &str| {
        let plain = NativeTechnique.main(Overlap::Disjoint);
        let plain = plain
            .with("colour", "one-colour")
            .with("first-pass", first_pass);
        let native = NativeVariant::of(&plain).expect("known names");
        NativeBackend::new(targets.vulkan(), native)
    };
    assert!(open("stencil").is_ok());
    let error = open("colour").expect_err("refused").to_string();
    assert!(
        error.contains("lacks fragment programs in the first pass"),
        "{error}"
    );
}

/// A square far from equator and poles, where both normals differ most, along its southern edge, between
/// the rows of the surface, where that hangs lowest.
fn tilted(body: Ellipsoid) -> FillInput {
    let text = polygon("square", "[[0,45.5],[10,45.5],[10,55.5],[0,55.5],[0,45.5]]");
    input(&text, body, 180, (5.5, 45.5, 2e4, 0.0, -90.0))
}

#[test]
fn centric_walls_are_right_on_the_earth_as_drawn_and_wrong_where_pixels_are_smaller_than_their_shift()
 {
    let Some(devices) = Devices::open() else {
        return;
    };
    let shift_m = |input: &FillInput, normals: &str| {
        let variant = variant(&[("normals", normals)]);
        let mut figures = VertexTechnique.figures(&variant, input).into_iter();
        figures
            .find(|(name, _)| *name == "wall_shift_m")
            .and_then(|(_, shift_m)| shift_m)
    };
    // 20 km above, a pixel is 60 m wide.
    for (body, right, px) in [
        (Ellipsoid::WGS84, true, 0.0..0.5),
        (Ellipsoid::SATURN_LIKE, false, 4.0..20.0),
    ] {
        let input = tilted(body);
        let judged = filled_only(&judge(&input));
        for normals in ["geodetic", "stored", "centric"] {
            let is_centric = normals == "centric";
            let frame = draw(&devices, &input, technique(&[("normals", normals)]));
            let found = figures(&judged, &filled_only(&frame));
            let is_right = verdict(&found).is_pass();
            assert_eq!(is_right, right || !is_centric, "{normals}: {found:?}");
            let shift_px = shift_m(&input, normals).map(|shift_m| shift_m / 60.0);
            assert_eq!(shift_px.is_some(), is_centric);
            assert!(
                shift_px.is_none_or(|shift_px| px.contains(&shift_px)),
                "{shift_px:?}"
            );
            // What was found is no more than what was said, but for the pixel's own width.
            let distance_px = found.hausdorff_px.unwrap_or(0.0);
            assert!(!is_centric || distance_px <= px.end + 1.5, "{distance_px}");
        }
    }
}
