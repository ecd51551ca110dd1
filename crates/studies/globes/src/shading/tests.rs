// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers on a device, and the judge without one. The layers are waves, which need no data, in all tests but the last.

use super::judge::{ShadingErrors, normal};
use super::layers::{Fragment, shade};
use super::way::Shading;
use super::*;
use terrafill_fixtures::data;
use terrafill_fixtures::on_device::{figure, on_device, verdict};
use terrafill_results::{RunInput, Status};
use terrafill_spiral::SpiralKind;
use terrafill_study::Group as _;
use terrafill_surface::SurfaceKind;

const KINDS: &[&dyn SurfaceKind] = &[&SpiralKind];

fn shadings(side_px: u32) -> CaseGroup<Shadings> {
    let list = List::shipped().expect("a list");
    let opened = Rc::new(Opened::new(KINDS));
    Shadings::planned(
        &list,
        (side_px, 1),
        true,
        Rc::new(synthetic::sources()),
        &opened,
    )
}

#[test]
fn without_data_layers_are_missed_by_name() {
    let opened = Opened::new(KINDS);
    let missing = layers(&opened, None).expect_err("no data");
    assert!(missing.contains("textures/color_blue_marble"), "{missing}");
    let missing = layers(&Opened::new(&[]), None).expect_err("no surface");
    assert!(missing.contains(KIND), "{missing}");
}

#[test]
fn layers_are_their_texels_and_the_printed_faults_show() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let shadings = shadings(120);
        let mut session = shadings.open(context).expect("opens");
        for (case, work) in shadings.work.work.iter().enumerate() {
            let verdict = verdict(&mut *session, case, work);
            match work.shading.fault {
                0 => {
                    assert_eq!(verdict.status, Status::Ok, "{work:?}: {}", verdict.reason);
                    assert!(figure(&verdict, "globe_shade_px") > 500.0);
                    assert!(session.time(case).is_ok());
                }
                // Negative control: night by the negated light is not night by the ramp.
                3 if work.view == "day" => {
                    assert_eq!(verdict.status, Status::Wrong);
                    assert!(figure(&verdict, "globe_shade_beyond_px") > 100.0);
                }
                _ => {}
            }
        }
    });
}

#[test]
fn a_lost_colour_is_counted_and_another_layer_is_seen() {
    let shadings = shadings(64);
    let work = &shadings.work;
    let eye = work.eye(&work.work[0]).expect("the view");
    let lights = work.lights(&work.work[0]).expect("the view");
    let surface = work.opened.get(KIND, [("n", ABLATION_N)]);
    let surface = surface.expect("a surface");
    let frame = surface.frame(&eye.camera, eye.size).expect("a frame");
    let pictures = Pictures::new(&work.sources, 64);
    let triangles = terrafill_reference::SurfaceTriangles::new(&frame);
    let picture = |lights: &Lights, shading: Shading| {
        let sampled = Sampled {
            pictures: &pictures,
            shading,
        };
        eye.by_pixel(|_, _, direction| {
            let Some((depth, _)) = triangles.hit_facet(direction, eye.camera.near_m) else {
                return [0.0; 4];
            };
            let at = direction * depth;
            let fragment = Fragment {
                n: normal(&eye, at),
                to_eye: -at,
            };
            let shade = shade(lights, shading, fragment, &sampled);
            shade.colour.extend(1.0).as_vec4().to_array()
        })
    };
    let met = Met::new(&eye, &frame);
    let sampled = Sampled {
        pictures: &pictures,
        shading: Shading::default(),
    };
    let judged = |picture: &[[f32; 4]]| -> ShadingErrors {
        judge(
            &eye,
            &met,
            &lights,
            (&sampled, Some(&work.sources)),
            picture,
            true,
        )
    };
    let all = picture(&lights, Shading::default());
    // Facets are flat, so that a ray's own normal is not quite the interpolated one.
    let right = judged(&all);
    assert!(
        right.beyond < right.shown / 20 && right.non_finite == 0,
        "{right:?}"
    );
    assert!(
        right
            .controls
            .is_some_and(|found| found.iter().all(|px| px * 10 > right.shown))
    );
    // Negative controls: without clouds, clouds that stood still, night and day exchanged, a colour that is no number.
    let without = Shading {
        removed: 1,
        ..Shading::default()
    };
    let still = Lights {
        clouds: glam::DMat3::IDENTITY,
        ..lights
    };
    let night = Lights {
        sun: -lights.sun,
        ..lights
    };
    for wrong in [
        picture(&lights, without),
        picture(&still, Shading::default()),
        picture(&night, Shading::default()),
    ] {
        assert!(judged(&wrong).beyond > right.shown / 4);
    }
    let mut lost = all;
    lost[64 * 32 + 32][1] = f32::NAN;
    let found = judged(&lost);
    assert_eq!((found.non_finite, found.beyond), (1, right.beyond + 1));
}

#[test]
fn triangles_on_a_map_are_off_another_formula() {
    let list = List::shipped().expect("a list");
    let eye = list.shaded("day").expect("the view").eye(128);
    let spiral = Spiral::new(&eye, ABLATION_N, Law::Published, None);
    let mesh = Mesh::Stored(spiral);
    for projection in Projection::ALL {
        let met = mesh.met(&eye, projection);
        let off = |formula| quantile(&met.off_formula(&eye, formula), 0.5).expect("pixels");
        assert!(off(projection) < 0.5, "{projection:?}: {}", off(projection));
        // Of triangles half as long the distance is about a quarter: it is their tessellation's.
        let finer = mesh
            .met_finer(&eye, projection)
            .off_formula(&eye, projection);
        let [coarse, fine] = [met.off_formula(&eye, projection), finer]
            .map(|off| quantile(&off, 0.99).expect("pixels"));
        assert!(fine < 0.5 * coarse, "{projection:?}: {fine} of {coarse}");
        // Negative control.
        let others = Projection::ALL.iter().filter(|other| **other != projection);
        for other in others {
            assert!(
                off(*other) > 3.0,
                "{projection:?} by {other:?}: {}",
                off(*other)
            );
        }
    }
}

#[test]
#[ignore = "needs data: textures"]
fn the_earth_s_layers_are_right_from_all_sides() {
    let opened = Rc::new(Opened::new(KINDS));
    let (sources, files) = layers(&opened, Some(&data::folder())).expect("layers");
    let is_texture = |file: &&RunInput| file.file.starts_with("textures/");
    assert_eq!(files.iter().filter(is_texture).count(), 5);
    on_device(terrafill_gpu::shared_gpu, |context| {
        let list = List::shipped().expect("a list");
        let shadings = Shadings::planned(&list, (160, 1), true, Rc::new(sources), &opened);
        let mut session = shadings.open(context).expect("opens");
        let work = shadings.work.work.iter().enumerate();
        for (case, work) in work.filter(|(_, work)| matches!(work.what, "layers" | "projections")) {
            let verdict = verdict(&mut *session, case, work);
            assert_eq!(verdict.status, Status::Ok, "{work:?}: {}", verdict.reason);
        }
    });
}
