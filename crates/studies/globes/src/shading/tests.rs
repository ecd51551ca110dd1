// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers on a device, and the judge without one.

use super::judge::ShadingErrors;
use super::layers::colour;
use super::*;
use crate::on_device::{figure, on_device, verdict};
use terrafill_reference::SurfaceTriangles;
use terrafill_results::Status;
use terrafill_spiral::SpiralKind;
use terrafill_study::Group as _;
use terrafill_surface::SurfaceKind;

const KINDS: &[&dyn SurfaceKind] = &[&SpiralKind];

#[test]
fn layers_are_their_functions_and_the_printed_faults_show() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let list = List::shipped().expect("a list");
        let opened = Rc::new(Opened::new(KINDS));
        let shadings = Shadings::planned(&list, (120, 1), true, &opened);
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
                3 => {
                    let off = figure(&verdict, "globe_shade_max");
                    assert!(off > 0.2, "{off}");
                }
                _ => {}
            }
        }
    });
}

#[test]
fn a_lost_colour_is_counted_and_another_layer_is_seen() {
    let list = List::shipped().expect("a list");
    let opened = Rc::new(Opened::new(KINDS));
    let shadings = Shadings::planned(&list, (40, 1), true, &opened);
    let eye = shadings.work.eye(&shadings.work.work[0]).expect("the view");
    let surface = opened.get(KIND, [("n", ABLATION_N)]).expect("a surface");
    let frame = surface.frame(&eye.camera, eye.size).expect("a frame");
    let triangles = SurfaceTriangles::new(&frame);
    let picture = |removed: u32| {
        eye.by_pixel(|_, _, direction| {
            let Some((depth, _)) = triangles.hit_facet(direction, eye.camera.near_m) else {
                return [0.0; 4];
            };
            let at = direction * depth;
            let shown = colour(&lights(&eye), removed, normal(&eye, at), -at);
            shown.extend(1.0).as_vec4().to_array()
        })
    };
    let right = judge(&eye, &frame, Shading::default(), &picture(0));
    let worst = |found: &ShadingErrors| quantile(&found.all, 0.99).expect("pixels");
    assert!(
        worst(&right) < 0.02 && right.non_finite == 0,
        "{}",
        worst(&right)
    );
    // Negative controls: without clouds, and with a colour that is no number.
    assert!(worst(&judge(&eye, &frame, Shading::default(), &picture(1))) > ALLOWED);
    let mut lost = picture(0);
    lost[40 * 20 + 20][1] = f32::NAN;
    assert_eq!(judge(&eye, &frame, Shading::default(), &lost).non_finite, 1);
}
