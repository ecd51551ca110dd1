// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions that change after they were prepared. The device gets the changed ones alone, the picture
//! is that of a backend which never saw the old ones, and wrong claims are refused.

use crate::drawing;

use drawing::{
    AllTargets, Devices, SIZE, Technique, collection, draw_with, layouts, look, native, polygon,
    scene, storages, stored, vertex,
};
use terrafill_compute::{ComputeVariant, Expansion};
use terrafill_contract::{DeviceError, FillInput, PreparedScene};
use terrafill_core::Ellipsoid;
use terrafill_native::{Extrusion, Indices};
use terrafill_plan::PlanOptions;
use terrafill_scene::Overlap;
use terrafill_variant::Switches;

const WEST: &str = "[[0,0],[3,0],[3,4],[0,4],[0,0]]";
const MIDDLE: &str = "[[4,0],[7,0],[7,4],[4,4],[4,0]]";
const EAST: &str = "[[8,0],[11,0],[11,4],[8,4],[8,0]]";

/// The middle one moved: as many vertices and triangles.
const MOVED: &str = "[[4.5,0],[7.5,0],[7.5,4],[4.5,4],[4.5,0]]";
/// The middle one with a notch: more vertices.
const NOTCHED: &str = "[[4,0],[7,0],[7,4],[5.5,2],[4,4],[4,0]]";

/// Squares small enough, and close enough to the equator, that their edges need no more vertices.
const SMALL_WEST: &str = "[[4,-0.1],[4.2,-0.1],[4.2,0.1],[4,0.1],[4,-0.1]]";
const SMALL_EAST: &str = "[[4.6,-0.1],[4.8,-0.1],[4.8,0.1],[4.6,0.1],[4.6,-0.1]]";

/// A square with a square hole, and a pentagon with a triangular one: eight vertices, eight edges and
/// two loops each, of other lengths. A cap shows the same by any triangulation of the same loops, so
/// that only other loops tell indices apart.
const SQUARE_HOLE: &str = "[[4.3,-0.1],[4.5,-0.1],[4.5,0.1],[4.3,0.1],[4.3,-0.1]],
    [[4.35,-0.05],[4.35,0.05],[4.45,0.05],[4.45,-0.05],[4.35,-0.05]]";
const TRIANGLE_HOLE: &str = "[[4.3,-0.1],[4.5,-0.1],[4.5,0.1],[4.4,0.15],[4.3,0.1],[4.3,-0.1]],
    [[4.35,-0.05],[4.4,0.05],[4.45,-0.05],[4.35,-0.05]]";

fn regions(rings: [&str; 3]) -> PreparedScene {
    let features = rings.map(|ring| polygon("region", ring));
    scene(
        &collection(&features),
        Ellipsoid::WGS84,
        90,
        Overlap::Disjoint,
    )
}

/// `before` with the region at `place` as it is in `after`.
fn changed(before: &FillInput, after: &PreparedScene, place: usize) -> FillInput {
    let mesh = after.meshes[place].clone();
    let meshes = before.scene.meshes.with_changed([(place, mesh)]);
    let scene = PreparedScene {
        regions: after.regions.clone(),
        ..before.scene.with_meshes(meshes.expect("a region"))
    };
    before.remeshed(&scene, PlanOptions::default())
}

fn seen(scene: &PreparedScene) -> FillInput {
    look(scene, (5.5, 2.0, 2e6, 0.0, -90.0), 100.0, SIZE)
}

fn all_layouts() -> Vec<Technique> {
    let plain = Switches::default();
    let merged = vertex(Switches {
        merges_draws: true,
        ..Switches::default()
    });
    let compute = [Expansion::PerFrame, Expansion::Cached].map(|expansion| {
        Technique::Compute(ComputeVariant {
            expansion,
            ..ComputeVariant::default()
        })
    });
    let native = storages().into_iter();
    let native = native.map(|(technique, indices)| stored(technique, indices, plain));
    let layouts = layouts(plain).into_iter().chain([merged]);
    layouts.chain(compute).chain(native).collect()
}

/// Replaces the middle region and puts it back, and compares with backends of their own.
fn check_updates(
    techniques: &[Technique],
    [west, middle, east]: [&str; 3],
    replaced: &str,
    see: impl Fn(&PreparedScene) -> FillInput,
    is_partial: bool,
) {
    let Some(devices) = Devices::open_for(techniques) else {
        return;
    };
    let before = see(&regions([west, middle, east]));
    let after = regions([west, replaced, east]);
    let (input, fresh_input) = (changed(&before, &after, 1), see(&after));
    let targets = AllTargets::new(&devices, SIZE);
    for &technique in techniques {
        let name = format!("{technique:?}");
        let mut other = targets.open(technique);
        let memory = other.prepare(&fresh_input).expect("fits");
        let everything = memory.upload_bytes;
        let fresh = other.render(&fresh_input).expect("draws");
        let mut backend = targets.open(technique);
        let old = draw_with(&mut *backend, &before);
        assert_ne!(old.ids, fresh.ids, "{name}");
        let uploaded = backend.update(&input, &[1]).expect("fits");
        let updated = backend.render(&input).expect("updated");
        assert_eq!(updated.ids, fresh.ids, "{name}");
        if is_partial {
            assert_eq!(uploaded.regions, [1], "{name}");
            assert!((1..everything).contains(&uploaded.bytes), "{name}");
        } else {
            assert_eq!(uploaded.regions, [0, 1, 2], "{name}");
            // Of the constants only what changed.
            let all = everything - memory.constant_bytes..=everything;
            assert!(all.contains(&uploaded.bytes), "{name}: {}", uploaded.bytes);
        }
        // What is held now is what the input says: preparing it uploads no geometry.
        let held = backend.prepare(&input).expect("held");
        assert!(held.upload_bytes < everything, "{name}");
        let again = backend.render(&input).expect("held");
        assert_eq!(again.ids, fresh.ids, "{name}");
        // And back again, from what was updated.
        let back = changed(&input, &before.scene, 1);
        let uploaded = backend.update(&back, &[1]).expect("fits");
        assert_eq!(uploaded.regions.len() == 1, is_partial, "{name}");
        let restored = backend.render(&back).expect("updated");
        assert_eq!(restored.ids, old.ids, "{name}");
    }
}

#[test]
fn a_moved_region_is_rewritten_where_it_lies() {
    check_updates(&all_layouts(), [WEST, MIDDLE, EAST], MOVED, seen, true);
}

#[test]
fn indices_are_rewritten_with_the_vertices() {
    let near = |scene: &PreparedScene| look(scene, (4.4, 0.0, 1e5, 0.0, -90.0), 100.0, SIZE);
    let before = [SMALL_WEST, SQUARE_HOLE, SMALL_EAST];
    // Strips of the two are not equally many, nor are pairs of edges.
    let is_list = |technique: &Technique| match technique {
        Technique::Native(variant) => {
            variant.indices() == Indices::List && variant.technique != Extrusion::GsTwoEdges
        }
        _ => true,
    };
    let lists: Vec<_> = all_layouts().into_iter().filter(is_list).collect();
    check_updates(&lists, before, TRIANGLE_HOLE, near, true);
}

#[test]
fn a_region_of_another_size_has_everything_uploaded() {
    check_updates(&all_layouts(), [WEST, MIDDLE, EAST], NOTCHED, seen, false);
}

/// A ring of more vertices than 16 bits tell apart when they are doubled.
fn fine_ring(first_deg: f64) -> String {
    let corner = |k: u32| {
        let turn = f64::from(k % 33_000) / 33_000.0 * std::f64::consts::TAU;
        let (sin, cos) = turn.sin_cos();
        format!("[{},{}]", first_deg + 1.5 * cos, 2.0 + 2.0 * sin)
    };
    let corners: Vec<String> = (0..=33_000).map(corner).collect();
    format!("[{}]", corners.join(","))
}

#[test]
fn long_indices_are_rewritten_too() {
    let techniques = [
        vertex(Switches::default()),
        vertex(Switches {
            merges_draws: true,
            ..Switches::default()
        }),
        native(Extrusion::VsControl, Switches::default()),
    ];
    let Some(devices) = Devices::open_for(&techniques) else {
        return;
    };
    let [before, after] = [5.5, 5.9].map(|deg| regions([WEST, &fine_ring(deg), EAST]));
    let (before, fresh) = (seen(&before), seen(&after));
    assert!(before.scene.meshes[1].vertex_count() > 1 << 15);
    let input = changed(&before, &after, 1);
    let targets = AllTargets::new(&devices, SIZE);
    for technique in techniques {
        let mut backend = targets.open(technique);
        let old = draw_with(&mut *backend, &before);
        let uploaded = backend.update(&input, &[1]).expect("fits");
        assert_eq!(uploaded.regions, [1], "{technique:?}");
        let updated = backend.render(&input).expect("updated");
        assert_eq!(updated.ids, targets.draw(&fresh, technique).ids);
        assert_ne!(updated.ids, old.ids);
    }
}

#[test]
fn wrong_claims_are_refused_and_leave_what_is_prepared() {
    let techniques = all_layouts();
    let Some(devices) = Devices::open_for(&techniques) else {
        return;
    };
    let before = seen(&regions([WEST, MIDDLE, EAST]));
    let after = regions([WEST, MOVED, EAST]);
    let input = changed(&before, &after, 1);
    let targets = AllTargets::new(&devices, SIZE);
    for technique in techniques {
        let mut backend = targets.open(technique);
        let error = backend.update(&input, &[1]).expect_err("nothing prepared");
        assert!(matches!(error, DeviceError::NotPrepared { .. }), "{error}");
        let old = draw_with(&mut *backend, &before);
        for claim in [&[][..], &[0], &[0, 1], &[3]] {
            let error = backend.update(&input, claim).expect_err("a wrong claim");
            let text = format!("changed regions: found {claim:?}, allowed [1]");
            assert_eq!(error.to_string(), text, "{technique:?}");
        }
        // Another set with the same contents was not made from what is held.
        let unrelated = backend.update(&seen(&after), &[1]);
        let error = unrelated.expect_err("another origin");
        assert!(matches!(error, DeviceError::NotPrepared { .. }), "{error}");
        // Without the update the changed input is refused, and the old one still drawn.
        assert!(backend.render(&input).is_err(), "{technique:?}");
        assert!(backend.time_frame(&input).is_err(), "{technique:?}");
        let frame = backend.render(&before).expect("still prepared");
        assert_eq!(frame.ids, old.ids, "{technique:?}");
        // Negative control: the right claim is taken, in any words.
        backend.update(&input, &[1, 1]).expect("as it is");
        assert!(backend.render(&before).is_err(), "{technique:?}");
        assert_ne!(backend.render(&input).expect("updated").ids, old.ids);
    }
}
