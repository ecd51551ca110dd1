// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a view holds and what it leaves out, as the device counted it: nothing is held that no feature
//! accounts for, a plain fill from outside holds none of what it never uses, and a view that needs it has
//! it. The pictures are the same whatever is held beside.

use crate::drawing;

use drawing::{
    AllTargets, Devices, SIZE, TECHNIQUES, Technique, collection, counters, differing, draw,
    draw_with, look, named, native, polygon, scene, shipped, shown, with_switches,
};
use terrafill_compute::{ComputeVariant, Expansion, GpuCulling};
use terrafill_contract::{Feature, FillBackend, FillInput, Need, Needs, PreparedScene, WorkDone};
use terrafill_core::Ellipsoid;
use terrafill_native::Extrusion;
use terrafill_plan::NearRectangle;
use terrafill_scene::Overlap;
use terrafill_stencil::needs_ablation;
use terrafill_variant::{BottomCap, ColourWay, CoverArea, DepthRuleChoice, Switches};
use terrafill_vertex::Layout;

fn two_squares(overlap: Overlap) -> PreparedScene {
    let text = collection(&[
        polygon("west", "[[0,0],[4,0],[4,4],[0,4],[0,0]]"),
        polygon("east", "[[5,0],[9,0],[9,4],[5,4],[5,0]]"),
    ]);
    scene(&text, Ellipsoid::WGS84, 90, overlap)
}

fn from_outside(scene: &PreparedScene) -> FillInput {
    look(scene, (4.5, 2.0, 2e6, 0.0, -90.0), 100.0, SIZE)
}

/// One metre above the ground of the west square, inside its volume.
fn from_inside(scene: &PreparedScene) -> FillInput {
    let input = look(scene, (2.0, 2.0, 1.0, 90.0, -20.0), 0.1, SIZE);
    let met = input.plan.regions.iter();
    assert!(
        met.clone()
            .any(|region| region.near_rectangle == NearRectangle::Within)
    );
    input
}

fn from_the_other_side(scene: &PreparedScene) -> FillInput {
    look(scene, (-170.0, 0.0, 2e6, 0.0, -90.0), 100.0, SIZE)
}

/// What decides by itself what a view needs.
fn needed(colour: ColourWay) -> Switches {
    Switches {
        colour,
        depth_rule: DepthRuleChoice::Automatic,
        bottom_cap: BottomCap::WhereNeeded,
        scissor: true,
        ..Switches::default()
    }
}

/// Layouts of three techniques on both interfaces.
fn layouts(switches: Switches) -> Vec<Technique> {
    let compute = [
        (Expansion::PerFrame, GpuCulling::Off),
        (Expansion::PerFrame, GpuCulling::Regions),
        (Expansion::PerFrame, GpuCulling::Triangles),
        (Expansion::Cached, GpuCulling::Off),
    ];
    let compute = compute.map(|(expansion, culling)| {
        Technique::Compute(ComputeVariant {
            expansion,
            culling,
            switches,
            ..ComputeVariant::default()
        })
    });
    let native = [Extrusion::VsControl, Extrusion::GsDegenerate]
        .map(|technique| native(technique, switches));
    let vertex = drawing::layouts(switches).into_iter();
    vertex.chain(compute).chain(native).collect()
}

/// Whether bottom caps are stored, so that leaving them out spares bytes.
fn stores_bottoms(technique: &Technique) -> bool {
    match technique {
        Technique::Vertex(variant) => variant.layout != Layout::Pulled,
        Technique::Compute(_) => true,
        Technique::Native(variant) => variant.technique == Extrusion::VsControl,
    }
}

fn needs_of(backend: &dyn FillBackend, input: &FillInput) -> Needs {
    let needs = backend.needs(input).expect("prepared");
    needs.expect("volumes say what they hold")
}

fn need(needs: &Needs, feature: Feature) -> &Need {
    needs.of(feature).expect("every feature is listed")
}

/// A record, and what the device itself counted while the backend was opened, prepared and drawn.
fn record(
    targets: &AllTargets<'_>,
    devices: &Devices,
    input: &FillInput,
    technique: Technique,
) -> (Needs, WorkDone) {
    let done = || match technique {
        Technique::Native(_) => devices.vulkan().work_done(),
        _ => devices.wgpu.work_done(),
    };
    // The surface is the targets' and comes first.
    match technique {
        Technique::Native(_) => targets.vulkan().borrow_mut().prepare(input),
        _ => targets.wgpu().borrow_mut().prepare(input),
    }
    .expect("fits");
    let before = done();
    let mut backend = targets.open(technique);
    backend.prepare(input).expect("fits");
    let needs = needs_of(&*backend, input);
    (needs, done() - before)
}

#[test]
fn every_byte_and_every_pipeline_belongs_to_a_feature() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = two_squares(Overlap::Disjoint);
    let targets = AllTargets::new(&devices, SIZE);
    let all_at_once = Switches {
        colour: ColourWay::Rectangle,
        cover_area: CoverArea::Screen,
        copies_depth: true,
        ..Switches::default()
    };
    let switches = [
        Switches::default(),
        all_at_once,
        needed(ColourWay::Xor),
        needed(ColourWay::Rectangle),
        needed(ColourWay::Volume),
        needed(ColourWay::BitPlanes),
        needed(ColourWay::IdAccumulation),
    ];
    let views = [
        from_outside(&scene),
        from_inside(&scene),
        from_the_other_side(&scene),
    ];
    let mut checked = 0;
    for input in &views {
        for technique in switches.into_iter().flat_map(layouts) {
            let (needs, made) = record(&targets, &devices, input, technique);
            assert_eq!(needs.made, made, "{technique:?}");
            assert_eq!(needs.undeclared(), None, "{technique:?}");
            assert!(needs.list.iter().all(|need| !need.reason.is_empty()));
            // Negative control: whatever is not declared is missed.
            let mut forged = needs.clone();
            forged
                .list
                .retain(|need| need.feature != Feature::Positions);
            assert!(forged.undeclared().is_some(), "{technique:?}");
            checked += 1;
        }
    }
    assert_eq!(checked, 3 * 7 * 10);
}

#[test]
fn a_plain_fill_from_outside_holds_nothing_that_it_never_uses() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = two_squares(Overlap::Disjoint);
    let (outside, inside) = (from_outside(&scene), from_inside(&scene));
    let targets = AllTargets::new(&devices, SIZE);
    for technique in layouts(needed(ColourWay::Xor)) {
        let name = format!("{technique:?}");
        let (needs, made) = record(&targets, &devices, &outside, technique);
        for feature in [
            Feature::BottomCaps,
            Feature::CountBehind,
            Feature::Picture,
            Feature::TextureCode,
            Feature::TextureConstants,
            Feature::ReadableDepth,
            Feature::DepthCopy,
            Feature::NumberTarget,
            Feature::FlatMeshes,
            Feature::Order,
        ] {
            let need = need(&needs, feature);
            let held = (need.is_held, need.bytes, need.pipelines);
            assert_eq!(held, (false, 0, 0), "{name} {feature:?}: {}", need.reason);
        }
        let bottoms = need(&needs, Feature::BottomCaps);
        assert!(
            bottoms.reason.contains("meets none of 2 volumes"),
            "{}",
            bottoms.reason
        );
        assert!(bottoms.reason.contains(" km from "), "{}", bottoms.reason);
        assert_eq!(
            bottoms.spared_bytes > 0,
            stores_bottoms(&technique),
            "{name}"
        );
        // Two disjoint regions share the stencil by one bit each at most.
        let bits = &need(&needs, Feature::StencilBits).reason;
        assert!(
            bits.starts_with("1 of the 8") || bits.starts_with("2 of the 8"),
            "{bits}"
        );
        assert!(need(&needs, Feature::CountBefore).pipelines > 0, "{name}");
        // Negative control: bottom caps, pipelines and bytes come with a variant that asks for them.
        let whole = with_switches(technique, Switches::default());
        let (with_bottoms, with_bottoms_made) = record(&targets, &devices, &outside, whole);
        let held = need(&with_bottoms, Feature::BottomCaps);
        assert!(held.is_held, "{name}");
        assert_eq!(held.bytes, bottoms.spared_bytes, "{name}");
        let more = with_bottoms_made.made_bytes.saturating_sub(made.made_bytes);
        assert!(
            more.abs_diff(held.bytes) < 4,
            "{name}: {more} {}",
            held.bytes
        );
        assert!(
            need(&with_bottoms, Feature::CountBehind).pipelines > 0,
            "{name}"
        );
        // Negative control: and with a view from inside a volume.
        let (from_inside, _) = record(&targets, &devices, &inside, technique);
        let held = need(&from_inside, Feature::BottomCaps);
        assert!(held.is_held, "{name}: {}", held.reason);
        assert_eq!(held.bytes > 0, stores_bottoms(&technique), "{name}");
        let behind = need(&from_inside, Feature::CountBehind);
        assert!(behind.is_held && behind.pipelines > 0, "{name}");
        assert!(behind.reason.contains("meets 1 of "), "{}", behind.reason);
    }
}

#[test]
fn overlaps_copies_and_pictures_are_held_where_they_are_asked_for() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let ordered = two_squares(Overlap::Ordered);
    let input = from_outside(&ordered);
    let targets = AllTargets::new(&devices, SIZE);
    let pixels = SIZE.pixel_count() as u64;
    for technique in layouts(needed(ColourWay::Rectangle)) {
        let name = format!("{technique:?}");
        let (needs, made) = record(&targets, &devices, &input, technique);
        let order = need(&needs, Feature::Order);
        assert!(
            order.is_held && order.reason.contains("overlap=ordered"),
            "{}",
            order.reason
        );
        let bits = &need(&needs, Feature::StencilBits).reason;
        assert!(bits.starts_with("8 of the 8"), "{bits}");
        let copied = Switches {
            copies_depth: true,
            ..technique.switches()
        };
        let copied = with_switches(technique, copied);
        let (with_copy, with_copy_made) = record(&targets, &devices, &input, copied);
        let copy = need(&with_copy, Feature::DepthCopy);
        assert!(copy.is_held, "{name}");
        assert_eq!(
            copy.bytes,
            need(&needs, Feature::DepthCopy).spared_bytes,
            "{name}"
        );
        assert_eq!(copy.bytes, 5 * pixels, "{name}");
        assert_eq!(
            with_copy_made.made_bytes - made.made_bytes,
            copy.bytes,
            "{name}"
        );
        // Nothing reads the copy.
        let frames = [technique, copied].map(|technique| draw(&devices, &input, technique));
        assert_eq!(differing(&frames[0], &frames[1]), 0, "{name}");
        assert!(frames[0].filled_px() > 1_000, "{name}");
    }
}

#[test]
fn a_textured_fill_holds_what_a_plain_one_of_the_same_scene_does_not() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (california, views) = shipped("california");
    let input = shown(&california, named(&views, "top-down"), SIZE);
    let targets = AllTargets::new(&devices, SIZE);
    let plain = needed(ColourWay::Xor);
    let mut shown = plain;
    assert_eq!(shown.set("texture", "chosen"), Ok(true));
    let loaded = Switches {
        loads_texture: true,
        ..plain
    };
    let texture = california.texture.as_ref().expect("a picture");
    let of_texture = [
        Feature::Picture,
        Feature::TextureCode,
        Feature::TextureConstants,
    ];
    for technique in layouts(plain) {
        let name = format!("{technique:?}");
        let (needs, made) = record(&targets, &devices, &input, technique);
        for feature in of_texture {
            let need = need(&needs, feature);
            assert_eq!(
                (need.is_held, need.bytes, need.pipelines),
                (false, 0, 0),
                "{name}"
            );
        }
        let picture = need(&needs, Feature::Picture);
        assert_eq!(picture.spared_bytes, texture.image.bytes(), "{name}");
        for (switches, is_shown) in [(shown, true), (loaded, false)] {
            let other = with_switches(technique, switches);
            let (with, with_made) = record(&targets, &devices, &input, other);
            assert_eq!(with.undeclared(), None, "{name}");
            assert_eq!(
                need(&with, Feature::Picture).bytes,
                picture.spared_bytes,
                "{name}"
            );
            assert!(need(&with, Feature::TextureCode).pipelines > 0, "{name}");
            assert!(need(&with, Feature::TextureConstants).bytes > 0, "{name}");
            assert_eq!(
                need(&with, Feature::ReadableDepth).is_held,
                is_shown,
                "{name}"
            );
            assert_eq!(need(&with, Feature::Covers).is_held, !is_shown, "{name}");
            assert!(
                with_made.made_bytes > made.made_bytes + picture.spared_bytes,
                "{name}"
            );
        }
        // What is loaded beside changes no pixel, and gives no places of texels.
        let frames = [technique, with_switches(technique, loaded)];
        let [bare, beside] = frames.map(|technique| draw(&devices, &input, technique));
        assert_eq!(differing(&bare, &beside), 0, "{name}");
        assert!(
            beside.texture.is_none() && bare.filled_px() > 1_000,
            "{name}"
        );
    }
}

/// A backend draws views in turn: bottoms come when they are needed, and stay.
#[test]
fn views_in_turn_show_what_a_backend_of_their_own_shows() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = two_squares(Overlap::Disjoint);
    let views = [
        from_outside(&scene),
        from_inside(&scene),
        from_the_other_side(&scene),
        from_outside(&scene),
    ];
    let targets = AllTargets::new(&devices, SIZE);
    for technique in layouts(needed(ColourWay::Rectangle)) {
        let name = format!("{technique:?}");
        let mut backend = targets.open(technique);
        for (index, input) in views.iter().enumerate() {
            let frame = draw_with(&mut *backend, input);
            let whole = Switches {
                colour: ColourWay::Rectangle,
                ..Switches::default()
            };
            let alone = draw(&devices, input, with_switches(technique, whole));
            assert_eq!(differing(&frame, &alone), 0, "{name}, view {index}");
            let is_filled = frame.filled_px() > 100;
            assert_eq!(is_filled, index != 2, "{name}, view {index}");
            let needs = needs_of(&*backend, input);
            let bottoms = need(&needs, Feature::BottomCaps);
            let drawn = counters(&frame);
            match index {
                0 => assert!(!bottoms.is_held, "{name}: {}", bottoms.reason),
                1 => assert!(bottoms.is_held && drawn.draws > 0, "{name}"),
                _ => {}
            }
            // What an earlier view needed is told as that.
            if index == 3 && bottoms.is_held {
                assert!(
                    bottoms.reason.contains("made for another view"),
                    "{}",
                    bottoms.reason
                );
            }
        }
        // Negative control: once more from inside, nothing is made that was not there.
        backend.prepare(&views[1]).expect("fits");
        let again = counters(&backend.render(&views[1]).expect("draws"));
        if !matches!(technique, Technique::Compute(_)) {
            assert_eq!(again.pipeline_creations, 0, "{name}");
        }
    }
}

#[test]
fn every_step_from_everything_to_what_is_needed_shows_the_same() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (california, views) = shipped("california");
    drop(devices);
    let shared = std::rc::Rc::new(terrafill_contract::Devices::default());
    let targets = terrafill_contract::Targets::new(&shared, SIZE);
    for technique in TECHNIQUES {
        let steps = needs_ablation(*technique, california.overlap, true);
        assert!(steps.len() >= 9, "{}: {}", technique.name(), steps.len());
        for view in &views {
            let (mut first, mut bytes) = (None, Vec::new());
            for step in &steps {
                let input = FillInput::new(&california, view, SIZE, step.variant.plan);
                let input = input.expect("a surface");
                let mut backend = technique.open(&targets, &step.variant).expect("opens");
                let frame = draw_with(&mut *backend, &input);
                let needs = needs_of(&*backend, &input);
                assert_eq!(
                    needs.undeclared(),
                    None,
                    "{} {}",
                    technique.name(),
                    step.name
                );
                bytes.push(needs.held_bytes());
                let first = first.get_or_insert_with(|| frame.clone());
                assert_eq!(
                    differing(first, &frame),
                    0,
                    "{} {}",
                    technique.name(),
                    step.name
                );
            }
            // Negative control: what is left out on the way was there.
            let (first, last) = (bytes[0], bytes[bytes.len() - 1]);
            assert!(last < first / 2, "{}: {bytes:?}", technique.name());
        }
    }
}
