// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a picture that is off is told by, and what is not drawn at all.

use super::judging::{moved_px, shows_chosen};
use super::*;
use crate::cases::view_group;
use crate::request::Wishes;
use crate::tests::TECHNIQUES;
use std::sync::Arc;
use terrafill_contract::{Devices, Frame};
use terrafill_core::VolumeHeights;
use terrafill_plan::{DrawnAs, FramePlan, NearRectangle, PixelRect, PlannedRegion};
use terrafill_scene::{ImageSize, Scene};
use terrafill_study::Request;
use terrafill_surface::EllipsoidKind;

#[test]
fn only_what_is_drawn_coarser_or_flat_may_be_moved() {
    let drawn = |region, mesh, drawn_as| PlannedRegion {
        region,
        mesh,
        heights: VolumeHeights {
            top_m: 1.0,
            bottom_m: -1.0,
        },
        screen_rect: PixelRect::full(ImageSize::new(8, 8)),
        near_rectangle: NearRectangle::Outside,
        drawn_as,
    };
    let plan = |regions: Vec<PlannedRegion>| FramePlan {
        regions,
        options: PlanOptions {
            boundary_lod_px: Some(0.5),
            far_level_px: Some(0.25),
            ..PlanOptions::default()
        },
        ..FramePlan::default()
    };
    let as_written = drawn(3, 3, DrawnAs::Volume);
    assert_eq!(moved_px(&plan(vec![as_written])), 0.0);
    let coarser = drawn(4, 20, DrawnAs::Volume);
    assert_eq!(moved_px(&plan(vec![as_written, coarser])), 0.5);
    let flat = drawn(5, 5, DrawnAs::FlatMesh);
    assert_eq!(moved_px(&plan(vec![as_written, flat])), 0.25);
    assert_eq!(moved_px(&plan(vec![coarser, flat])), 0.75);
}

/// The first technique's cases of a view, matrix included.
fn group(scene: &str, view: &str, size: u32) -> ViewGroup {
    let request = Request {
        techniques: vec!["vertex".to_owned()],
        samples: Some(1),
        size: [size, size],
        settings: BTreeMap::from([("matrix".to_owned(), vec![scene.to_owned()])]),
        ..Request::default()
    };
    let wishes = Wishes::new(&request, [TECHNIQUES, &[]], &[&EllipsoidKind]).expect("wishes");
    let scene = Arc::new(Scene::shipped(scene, None).expect("it ships"));
    let view = scene.views.iter().find(|known| known.name == view);
    view_group(&scene, view.expect("a view"), None, &wishes)
}

/// Calls `check` with a session of the group; skipped, said aloud, where there is no device.
fn with_session(group: &ViewGroup, check: impl FnOnce(&mut ViewSession<'_>)) {
    if terrafill_gpu::open_for_test(&Default::default()).is_none() {
        return;
    }
    let place = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(place.path().join("images")).expect("a folder");
    let devices = Rc::new(Devices::default());
    let context = Context {
        devices: &devices,
        folder: place.path(),
    };
    let ready = ReadyScene::new(&group.scene, &[&EllipsoidKind]).expect("it meshes");
    check(&mut ViewSession::new(group, &ready, context).expect("a session"));
}

fn figure(verdict: &Verdict, metric: &str) -> Option<f64> {
    let mut figures = verdict.figures.iter();
    figures
        .find(|(name, _)| *name == metric)
        .map(|(_, value)| *value)
}

#[test]
fn coordinates_that_are_shifted_make_the_row_wrong() {
    let mut group = group("california", "top-down", 96);
    // In full depth, or in the view that quick runs show textured.
    let plain = TECHNIQUES[0].main(group.scene.overlap);
    let (textured, shown) =
        crate::textured::textured_variants(&plain, true, &group.scene, &group.view, true).remove(0);
    group.cases[0].subject = Subject::Fill(TECHNIQUES[0], textured);
    group.cases[0].shown = shown;
    group.cases[0].purposes = vec![Purpose::Texture];
    let case = &group.cases[0];
    assert!(shows_chosen(case), "{}", case.variant_name());
    with_session(&group, |session| {
        let mut compared = |shift_texels: f64| {
            let drawn = session.draw(case, rounding_px, ProbeFrame::Counted);
            let mut drawn = drawn.unwrap_or_else(|why| panic!("not drawn: {why:?}"));
            let texture = drawn.frame.texture.as_mut().expect("textured");
            let columns = f64::from(texture.texels[0]);
            for pixel in texture.pixels.iter_mut().flatten() {
                pixel.uv[0] += shift_texels / columns;
            }
            session.compare(case, &mut drawn).expect("compared")
        };
        let right = compared(0.0);
        assert_eq!((right.status, right.reason.as_str()), (Status::Ok, ""));
        let wrong = compared(1.0);
        assert_eq!(wrong.status, Status::Wrong);
        assert!(
            wrong.reason.contains("texels, allowed 0.25"),
            "{}",
            wrong.reason
        );
        let rms = figure(&wrong, "texel_rms").expect("compared");
        assert!((rms - 1.0).abs() < 0.1, "{rms}");
    });
}

#[test]
fn what_rounds_too_much_to_be_right_is_left_out_of_the_matrix_by_its_bound_alone() {
    let group = group("square-200km", "edge-1m5", 512);
    let cell = |name: &str| {
        let mut cases = group.cases.iter();
        let place = cases.position(|case| case.variant_name() == name);
        place.expect("a cell of the matrix")
    };
    with_session(&group, |session| {
        let naive = &group.cases[cell("doubled,positions=ecef-f32")];
        let Err(Failure::Unable(reason)) = session.draw(naive, rounding_px, ProbeFrame::Counted)
        else {
            panic!("skipped");
        };
        assert!(
            reason.starts_with("ecef-f32 rounds by up to ")
                && reason.ends_with(" px here, allowed 0.25"),
            "{reason}"
        );
        // Negative control: were its bound nothing, it would be drawn, and wrong.
        let drawn = session.draw(naive, |_, _| 0.0, ProbeFrame::Counted);
        let mut drawn = drawn.unwrap_or_else(|why| panic!("not drawn: {why:?}"));
        let found = session.compare(naive, &mut drawn).expect("compared");
        assert_eq!(found.status, Status::Wrong, "{}", found.reason);
        assert!(figure(&found, "mismatched_px") > Some(100.0));
        // What is right by its bound is drawn, and so is everything that is not about positions.
        for name in [
            "doubled,positions=two-float",
            "doubled",
            "doubled,walls=list",
        ] {
            let found = session.verify(cell(name)).expect("verified");
            assert_eq!(found.status, Status::Ok, "{name}: {}", found.reason);
        }
    });
}

#[test]
fn a_frame_that_is_drawn_again_holds_nothing_of_the_fill_before_it() {
    let group = group("square-200km", "edge-1m5", 512);
    let case = |name: &str| {
        let mut cases = group.cases.iter();
        let found = cases.find(|case| case.variant_name() == name);
        found.expect("a cell of the matrix")
    };
    with_session(&group, |session| {
        let mut drawn = |name: &str, probe| {
            let drawn = session.draw(case(name), |_, _| 0.0, probe);
            drawn
                .unwrap_or_else(|why| panic!("not drawn: {why:?}"))
                .frame
        };
        let first = drawn("doubled", ProbeFrame::Counted);
        // Rounded so much that it fills where nothing is to be filled.
        let other = drawn("doubled,positions=ecef-f32", ProbeFrame::Counted);
        let again = drawn("doubled", ProbeFrame::PictureOnly);
        assert_eq!(again.ids, first.ids);
        // Negative control: over what was there, these pixels would have stayed.
        let pixels = first.ids.iter().zip(&other.ids);
        let left_over = pixels.filter(|(own, other)| **own == 0 && **other > 0);
        assert!(left_over.count() > 0);
        let fragments = |frame: &Frame| frame.counters.as_ref()?.stencil_fragments;
        assert_eq!(fragments(&again), None, "nothing was drawn to be counted");
    });
}
