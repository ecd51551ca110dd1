// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vertices made by a device, and the judge without one.

use super::*;
use terrafill_fixtures::on_device::{on_device, verdict};
use terrafill_results::Status;
use terrafill_spiral::SpiralKind;
use terrafill_study::Group as _;

/// Relief from a seed; without data no other.
fn fields() -> Vec<Arc<HeightCube>> {
    let (fields, skipped, inputs) = height_fields(&Opened::new(&[&SpiralKind]), None);
    assert_eq!((fields.len(), inputs.len()), (1, 0));
    assert!(skipped.len() == 1 && skipped[0].what.ends_with("etopo"));
    assert!(
        skipped[0].reason.contains("etopo20"),
        "{}",
        skipped[0].reason
    );
    fields
}

fn eye(name: &str) -> Eye {
    let list = List::shipped().expect("a list");
    list.view(name).expect("the view").eye(160)
}

#[test]
fn every_vertex_lies_on_the_body_and_every_edge_is_shared() {
    for view in VIEWS {
        let eye = eye(view);
        for law in [Law::Exponential, Law::Quadratic, Law::Published] {
            let spiral = Spiral::new(&eye, 36, law, None);
            let mut edges: BTreeMap<[u32; 2], u32> = BTreeMap::new();
            for [a, b, c] in spiral.triangles() {
                for [p, q] in [[a, b], [b, c], [c, a]] {
                    *edges.entry([p.min(q), p.max(q)]).or_default() += 1;
                }
            }
            let open = edges.values().filter(|count| **count == 1).count();
            assert!(open <= spiral.per_turn as usize && edges.values().all(|count| *count <= 2));
            for number in 0..spiral.count() {
                let ecef = eye.camera.eye_ecef + spiral.place(number);
                let height_m = eye.body.ecef_to_geodetic(ecef).height_m;
                assert!(height_m.abs() < 1e-6, "{view} {number} {height_m}");
            }
        }
    }
}

#[test]
fn over_terrain_every_vertex_is_as_high_as_the_field_says() {
    let made = MadeGlobes::planned(&List::shipped().expect("a list"), (160, 1), fields());
    let field = &made.work.fields[0];
    assert!(field.highest_m > 3000.0 && field.bytes() == 4 * 6 * 257 * 257);
    for work in made.work.work.iter().filter(|work| work.terrain.is_some()) {
        let eye = made.work.eye(work).expect("the view");
        let spiral = made.work.spiral(&eye, work);
        let mut highest_m: f64 = 0.0;
        for number in 0..spiral.count() {
            let place = eye
                .body
                .ecef_to_geodetic(eye.camera.eye_ecef + spiral.place(number));
            let foot = eye.below(place) / eye.body.radii_m();
            let off_m = place.height_m - field.height_m(foot);
            assert!(off_m.abs() < 1e-4, "{work:?} {number}: {off_m}");
            highest_m = highest_m.max(place.height_m);
        }
        // Negative control: it is no bare body.
        assert!(highest_m > 50.0, "{work:?}: {highest_m}");
    }
}

#[test]
fn devices_make_the_vertices_of_f64_and_both_stages_the_same() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let list = List::shipped().expect("a list");
        let made = MadeGlobes::planned(&list, (160, 1), fields());
        let mut session = made.open(context).expect("opens");
        for (case, work) in made.work.work.iter().enumerate() {
            let verdict = verdict(&mut *session, case, work);
            let looked_up = work.terrain.map(|(_, lookup)| lookup);
            if looked_up == Some(Lookup::Absolute) {
                // Half a metre at the Earth's radius is seen from 1.7 m.
                let is_near = work.view == "ground-1.7m";
                assert_eq!(verdict.status == Status::Wrong, is_near, "{work:?}");
            } else if work.has_series || work.source == Source::Sent {
                assert_eq!(verdict.status, Status::Ok, "{work:?}: {}", verdict.reason);
                assert!(session.time(case).is_ok());
            }
        }
    });
}

#[test]
fn a_vertex_that_was_moved_is_found() {
    let eye = eye("globe");
    let spiral = Spiral::new(&eye, 36, Law::Exponential, None);
    let mut vertices = spiral.vertices();
    assert!(against(&eye, &spiral, &vertices).px < 1e-4);
    // Negative control: radii that were not corrected.
    let corrected = Spiral::new(&eye, 36, Law::Published, None).vertices();
    assert!(against(&eye, &spiral, &corrected).beyond_px > 1.0);
    // Negative controls: 100 km off, and lost.
    vertices[7][0] += 1e5;
    assert!(against(&eye, &spiral, &vertices).beyond_px > 0.5);
    vertices[7][0] = f32::NAN;
    assert_eq!(against(&eye, &spiral, &vertices).lost, 1);
}
