// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fills over a surface that belongs to the view: a spiral that ends at the horizon. Seen from far its facets
//! hang kilometres below the body. Where no facet is, the sky is seen and no region.

use crate::drawing::by_main::{Open, TECHNIQUES, prepared};
use crate::drawing::{self, Pose, figures, judge, square, without_sagitta};
use terrafill_conformance::verdict;
use terrafill_contract::{FillInput, Frame, PreparedScene};
use terrafill_overlays::DRAPED_MESH;
use terrafill_scene::{ImageSize, Scene};
use terrafill_spiral::SpiralKind;
use terrafill_surface::{EllipsoidKind, SurfaceKind};
use terrafill_vertex::VertexTechnique;

const KINDS: [&dyn SurfaceKind; 2] = [&EllipsoidKind, &SpiralKind];

const SIZE: ImageSize = square(192);

/// Longitude, latitude, height, heading and pitch: the globe, four times, at ±180° and over a pole; obliquely
/// from less and less; and down.
const POSES: [Pose; 11] = [
    (15.0, 20.0, 8e6, 0.0, -90.0),
    (180.0, 20.0, 8e6, 0.0, -90.0),
    (0.0, 90.0, 8e6, 0.0, -90.0),
    (180.0, 70.0, 8e6, 30.0, -90.0),
    (15.0, 20.0, 1.161e6, 0.0, -90.0),
    (15.0, 20.0, 1e4, 0.0, -90.0),
    (15.0, 20.0, 1e5, 225.0, -20.0),
    (15.0, 20.0, 2e3, 45.0, -2.0),
    (15.0, 20.0, 1.7, 45.0, -10.0),
    (15.0, 20.0, 1.7, 315.0, -2.0),
    (180.0, 90.0, 2e3, 45.0, -2.0),
];
const GLOBE: Pose = POSES[0];

/// The shipped scene over such a surface.
fn over(surface: &str) -> PreparedScene {
    let text = include_str!("../../../../../bench-scenes/spiral.toml");
    let shipped = "kind = \"spiral\"\n";
    assert!(text.contains(shipped));
    let text = text.replacen(shipped, surface, 1);
    let scene = Scene::from_toml(&text, "spiral.toml", None).expect("a scene");
    prepared(&KINDS, &scene)
}

fn look(scene: &PreparedScene, pose: Pose) -> FillInput {
    drawing::look(scene, pose, (5e-4 * pose.2).max(0.1), SIZE)
}

#[test]
fn every_technique_fills_rightly_over_a_spiral_in_every_view() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    let spiral = over("kind = \"spiral\"\n");
    let bare = over("kind = \"ellipsoid\"\nrows = 360\n");
    let mut elsewhere = 0;
    for pose in POSES {
        let input = look(&spiral, pose);
        let reference = judge(&input);
        assert!(reference.filled_px() > 50, "{pose:?}: nothing to see");
        // From afar facets hang kilometres deep.
        let on_the_body = (pose.2 >= 8e6).then(|| judge(&look(&bare, pose)));
        for technique in TECHNIQUES {
            let frame = open.draw(technique, &input);
            let found = figures(&reference, &frame);
            assert!(
                verdict(&found).is_pass(),
                "{} {pose:?}: {found:?}",
                technique.name()
            );
            assert_eq!(found.mismatched_px_outside_band, 0);
            // Negative control: over the body itself, the same regions cover other pixels.
            let differs = |body: &Frame| figures(body, &frame).mismatched_px > 0;
            elsewhere += usize::from(on_the_body.as_ref().is_some_and(differs));
        }
    }
    assert_eq!(elsewhere, 4 * TECHNIQUES.len());
}

#[test]
fn coarse_uneven_hilly_and_wrong_spirals_are_filled_as_they_are_drawn() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    for (surface, poses) in [
        ("n = 12\n", &[GLOBE, POSES[2], POSES[7]][..]),
        (
            "n = 24\nlaw = \"quadratic\"\nstep_deg = 13\n",
            &[POSES[1], POSES[6]],
        ),
        ("base = \"relief\"\nseed = 7\n", &[GLOBE, POSES[6]]),
        (
            "n = 12\nrim = \"horizon\"\nlaw = \"equal-area\"\n",
            &[POSES[3]],
        ),
        ("frame = \"lonlat\"\nprecision = \"f32\"\n", &[POSES[4]]),
        ("trig = \"1/2\"\n", &[GLOBE]),
    ] {
        let scene = over(&format!("kind = \"spiral\"\n{surface}"));
        for &pose in poses {
            let what = format!("{surface} {pose:?}");
            let judged = open.assert_right(&what, &look(&scene, pose));
            assert!(judged.filled_px() > 50, "{what}: nothing to see");
        }
    }
}

#[test]
fn volumes_that_end_at_the_corners_heights_lose_facets() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    let right = over("kind = \"spiral\"\nn = 12\n");
    let input = look(&right, GLOBE);
    let reference = judge(&input);
    let found = figures(&reference, &open.draw(&VertexTechnique, &input));
    assert!(verdict(&found).is_pass(), "{found:?}");
    let hanging = look(&without_sagitta(&right), GLOBE);
    let wrong = figures(&reference, &open.draw(&VertexTechnique, &hanging));
    assert!(wrong.mismatched_px_outside_band > 100, "{wrong:?}");
}

#[test]
fn a_mesh_draped_over_a_spiral_follows_its_facets() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    let scene = over("kind = \"spiral\"\n");
    for pose in [GLOBE, POSES[7]] {
        let input = look(&scene, pose);
        let found = figures(&judge(&input), &open.draw(&DRAPED_MESH, &input));
        // What its offset may hide or let through at silhouettes.
        let allowed = found.filled_px / 1000;
        assert!(
            found.mismatched_px_outside_band <= allowed,
            "{pose:?} {found:?}"
        );
    }
}

/// Pixels that show the body where the true one is bare between a rim's chords, and those of them that are
/// filled.
#[test]
fn beyond_the_rim_is_sky_for_the_reference_and_for_every_technique() {
    let Some(open) = Open::new(SIZE) else {
        return;
    };
    // Over the pole the far squares reach the rim.
    let pose = POSES[2];
    let spiral = look(&over("kind = \"spiral\"\nn = 8\n"), pose);
    let body = judge(&look(&over("kind = \"ellipsoid\"\nrows = 360\n"), pose));
    let reference = judge(&spiral);
    let bare: Vec<usize> = (0..SIZE.pixel_count())
        .filter(|&pixel| body.ids[pixel] > 0 && !reference.surface[pixel])
        .collect();
    assert!(bare.len() > 5, "{}", bare.len());
    for technique in TECHNIQUES {
        let frame = open.draw(technique, &spiral);
        assert!(
            bare.iter().all(|&pixel| frame.ids[pixel] == 0),
            "{}",
            technique.name()
        );
        assert!(verdict(&figures(&reference, &frame)).is_pass());
    }
}
