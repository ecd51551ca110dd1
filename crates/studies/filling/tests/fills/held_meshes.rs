// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes that are on the device because a view drew them. Pictures are the same as with all of the scene's, from
//! fewer bytes. Nothing is handed over before a view needs it.

use crate::{camera_path, drawing, merged_draws};

use camera_path::{leveled, path};
use drawing::{AllTargets, Devices, counters, differing, draw_with, with_switches};
use merged_draws::{switches, techniques};
use std::collections::BTreeMap;
use terrafill_contract::{Feature, FillInput, Needs};
use terrafill_variant::Switches;

fn holding(drawn: bool, merges_draws: bool) -> Switches {
    Switches {
        holds_drawn_meshes: drawn,
        ..switches(merges_draws)
    }
}

/// Regions with the meshes that a view draws of them.
fn drawn(input: &FillInput) -> impl Iterator<Item = (usize, usize)> {
    let meshes = &input.scene.meshes;
    let planned = input.plan.regions.iter();
    planned.map(|planned| (meshes[planned.mesh].region_index, planned.mesh))
}

#[test]
fn a_flight_looks_the_same_and_hands_over_what_it_has_not_drawn_yet() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = leveled();
    let inputs = path(&scene);
    let targets = AllTargets::new(&devices, camera_path::SIZE);
    for technique in techniques() {
        for merges in [false, true] {
            let what = format!("{technique:?}, merged: {merges}");
            let open = |drawn| targets.open(with_switches(technique, holding(drawn, merges)));
            let [mut whole, mut partial] = [false, true].map(open);
            let mut held: BTreeMap<usize, usize> = BTreeMap::new();
            let (mut brought, mut unchanged) = (0, 0);
            for input in inputs.iter().step_by(12) {
                let [all, some] = [&mut whole, &mut partial].map(|backend| {
                    let frame = draw_with(&mut **backend, input);
                    let bytes = backend.prepare(input).expect("fits").held_bytes();
                    (frame, bytes)
                });
                assert_eq!(differing(&all.0, &some.0), 0, "{what}: {}", input.view);
                assert!(some.1 < all.1, "{what}: {} of {} bytes", some.1, all.1);
                let [all, some] = [&all.0, &some.0].map(|frame| counters(frame).uploads);
                if drawn(input).all(|(region, mesh)| held.get(&region) == Some(&mesh)) {
                    assert!(
                        some <= all,
                        "{what}: {some} uploads for {all}, {}",
                        input.view
                    );
                    unchanged += 1;
                } else {
                    // Negative control: a view that draws something new brings more than constants.
                    brought += usize::from(some > all);
                }
                held.extend(drawn(input));
            }
            assert!(
                brought > 3 && unchanged > 0,
                "{what}: {brought} {unchanged}"
            );
        }
    }
}

#[test]
fn a_view_holds_less_than_half_of_all_levels() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = leveled();
    let input = &path(&scene)[0];
    let targets = AllTargets::new(&devices, camera_path::SIZE);
    for technique in techniques() {
        let [all, some] = [false, true].map(|drawn| {
            let mut backend = targets.open(with_switches(technique, holding(drawn, true)));
            backend.prepare(input).expect("fits");
            let needs = backend.needs(input).expect("prepared").expect("told");
            assert_eq!(needs.undeclared(), None, "{technique:?}");
            needs
        });
        let bytes = |needs: &Needs| {
            let features = [Feature::Positions, Feature::TopCaps];
            let of = |feature| needs.of(feature).map_or(0, |need| need.bytes);
            features.map(of).iter().sum::<u64>()
        };
        let (all_bytes, some_bytes) = (bytes(&all), bytes(&some));
        assert!(
            2 * some_bytes < all_bytes,
            "{technique:?}: {some_bytes} of {all_bytes}"
        );
        let positions = some.of(Feature::Positions).expect("listed");
        assert!(
            positions.reason.starts_with("held-meshes=drawn: of "),
            "{}",
            positions.reason
        );
    }
}

#[test]
fn a_mesh_that_is_not_there_is_seen() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let scene = leveled();
    let input = &path(&scene)[0];
    let targets = AllTargets::new(&devices, camera_path::SIZE);
    let largest = input.plan.regions.iter().max_by_key(|planned| {
        let rect = planned.screen_rect;
        rect.area()
    });
    let largest = largest.expect("something is drawn").mesh;
    for technique in techniques() {
        let technique = with_switches(technique, holding(true, true));
        let mut lacking = input.clone();
        lacking.scene.meshes = input.scene.meshes.with_geometry_of(|mesh| mesh != largest);
        let [whole, lacking] = [input, &lacking].map(|input| targets.draw(input, technique));
        assert!(differing(&whole, &lacking) > 0, "{technique:?}");
    }
}
