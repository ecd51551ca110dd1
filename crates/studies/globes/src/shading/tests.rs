// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers on a device, and the judge without one.

use super::judge::ShadingErrors;
use super::layers::colour;
use super::*;
use terrafill_contract::{Devices, device_for_test};
use terrafill_reference::SurfaceTriangles;
use terrafill_results::Status;
use terrafill_spiral::SpiralKind;
use terrafill_study::Group as _;
use terrafill_surface::SurfaceKind;

const KINDS: &[&dyn SurfaceKind] = &[&SpiralKind];

fn figure(verdict: &Verdict, name: &str) -> f64 {
    let mut figures = verdict.figures.iter();
    let found = figures.find(|(known, _)| *known == name);
    found.map_or(f64::NAN, |(_, value)| *value)
}

#[test]
fn layers_are_their_functions_and_the_printed_faults_show() {
    let devices = Rc::new(Devices::default());
    if device_for_test(terrafill_gpu::shared_gpu(&devices)).is_none() {
        return;
    }
    let list = List::shipped().expect("a list");
    let opened = Rc::new(Opened::new(KINDS));
    let shadings = Shadings::planned(&list, (120, 1), true, &opened);
    let folder = tempfile::tempdir().expect("a folder");
    let context = Context {
        devices: &devices,
        folder: folder.path(),
    };
    let mut session = shadings.open(context).expect("opens");
    for (case, work) in shadings.work.work.iter().enumerate() {
        let verdict = session.verify(case).expect("a verdict");
        let figures: Vec<String> = verdict
            .figures
            .iter()
            .map(|(name, value)| format!("{name} {value:.3}"))
            .collect();
        eprintln!(
            "{} {}: {:?} {} {}",
            work.what,
            shadings.cases[case].id.key(),
            verdict.status,
            verdict.reason,
            figures.join(", ")
        );
        match work.shading.fault {
            0 => {
                assert_eq!(verdict.status, Status::Ok, "{work:?}: {}", verdict.reason);
                assert!(figure(&verdict, "globe_shade_px") > 500.0);
                assert!(session.sample(case).is_ok());
            }
            // Negative control: night by the negated light is not night by the ramp.
            3 => {
                let off = figure(&verdict, "globe_shade_max");
                assert!(off > 0.2, "{off}");
            }
            _ => {}
        }
    }
}

#[test]
fn a_lost_colour_is_counted_and_another_layer_is_seen() {
    let list = List::shipped().expect("a list");
    let opened = Rc::new(Opened::new(KINDS));
    let shadings = Shadings::planned(&list, (40, 1), true, &opened);
    let eye = shadings.work.eye(&shadings.work.work[0]).expect("the view");
    let surface = opened.get(KIND, &Table::new()).expect("a surface");
    let frame = surface.frame(&eye.camera, eye.size).expect("a frame");
    let triangles = SurfaceTriangles::new(&frame);
    let picture = |removed: u32| -> Vec<[f32; 4]> {
        (0..eye.size.pixel_count())
            .map(|pixel| {
                let centre = [pixel % 40, pixel / 40].map(|at| at as f64 + 0.5);
                let direction = eye.camera.direction_ecef(eye.size, centre);
                let Some((depth, _)) = triangles.hit_facet(direction, eye.camera.near_m) else {
                    return [0.0; 4];
                };
                let at = direction * depth;
                let shown = colour(&lights(&eye), removed, normal(&eye, at), -at);
                shown.extend(1.0).as_vec4().to_array()
            })
            .collect()
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
