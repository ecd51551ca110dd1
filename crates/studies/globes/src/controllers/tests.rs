// SPDX-License-Identifier: MIT OR Apache-2.0
//! Controllers on devices, with counts that are wrong and counts of another case.

use super::*;
use crate::on_device::on_device;

fn work(way: PixelCount, rises: bool, (rule, step): (Rule, f64), delay: usize) -> Work {
    Work {
        way,
        rises,
        rule,
        step,
        delay,
    }
}

/// What is measured of a case that was run, by name.
fn figure(part: &ControllerPart<'_>, work: Work, course: &Course, name: &str) -> Option<f64> {
    let (mut figures, reason) = part.judged(work, course).expect("judged");
    assert_eq!(reason, "", "{work:?}");
    figures.extend(part.figures(work, course));
    let found = figures.iter().find(|(known, _)| *known == name);
    found.map(|(_, value)| *value)
}

#[test]
fn loops_on_devices_swing_rest_and_fall_behind() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let group = Controllers { work: Vec::new() };
        let mut part = ControllerPart::new(&group, context);
        for way in PixelCount::ALL {
            let mut of = |rises, rule, delay, name: &str| {
                let work = work(way, rises, rule, delay);
                match part.run(work, None) {
                    Ok(course) => figure(&part, work, &course, name),
                    // A device without such queries.
                    Err(Failure::Unable(_)) => None,
                    Err(error) => unreachable!("{error:?}"),
                }
            };
            let [steps, calm, wild, slow, _] = STEPS;
            let Some(period) = of(false, steps, 2, "globe_controller_period") else {
                continue;
            };
            assert_eq!(period, 6.0);
            assert_eq!(of(false, steps, 1, "globe_controller_rest_frames"), None);
            let rest = of(false, calm, 2, "globe_controller_rest_frames");
            assert!(rest.is_some_and(|frames| frames > 1.0), "{rest:?}");
            // Negative control: a gain beyond the limit.
            assert_eq!(of(false, wild, 2, "globe_controller_rest_frames"), None);
            assert!(of(false, wild, 2, "globe_fan_growth") > Some(1.0));
            let bare = [false, true].map(|rises| of(rises, slow, 1, "globe_bare_px"));
            assert!(
                bare[0] > Some(0.0) && bare[1] > bare[0].map(|px| 2.0 * px),
                "{bare:?}"
            );
            let closed = (Rule::Closed, 0.0);
            assert_eq!(of(true, closed, 1, "globe_bare_px"), Some(0.0));
            // What an eye at rest needs is there; one that rises sends constants.
            let sent = [false, true].map(|rises| of(rises, closed, 1, "globe_upload_bytes"));
            assert!(sent[0] == Some(0.0) && sent[1] > Some(0.0), "{sent:?}");
        }
    });
}

#[test]
fn a_wrong_count_and_counts_of_another_case_are_noticed() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let group = Controllers { work: Vec::new() };
        let mut part = ControllerPart::new(&group, context);
        let [late, early] = [3, 1].map(|delay| work(PixelCount::Histogram, false, STEPS[3], delay));
        let course = part.run(late, None).expect("counted");
        let reason = |part: &ControllerPart<'_>, work, course: &Course| {
            let (_, reason) = part.judged(work, course).expect("judged");
            reason
        };
        assert_eq!(reason(&part, late, &course), "");
        // A pixel in the last frame, which nothing follows: at no rim of this frame does rounding decide.
        let seen = part.views.0[0].seen(&part.stored, course.drawn[REST_FRAMES - 1]);
        assert_eq!(seen.band_px(), 0);
        for off in [-1, 1] {
            let mut wrong = course.clone();
            let last = &mut wrong.counts[REST_FRAMES - 1];
            last.fan = last.fan.wrapping_add_signed(off);
            let reason = reason(&part, late, &wrong);
            assert!(reason.starts_with("in 1 frames"), "{reason}");
        }
        let fed = part.run(early, Some(&course.counts)).expect("counted");
        let found = reason(&part, early, &fed);
        assert!(found.contains("makes of its own counts"), "{found}");
        // Not by chance: fed by its own it is right.
        let own = part.run(early, None).expect("counted");
        let again = part.run(early, Some(&own.counts)).expect("counted");
        assert_eq!(reason(&part, early, &again), "");
    });
}

#[test]
fn a_series_repeats_or_does_not() {
    assert_eq!(period(&[5; 12]), Some(1));
    let turns: Vec<u32> = (0..24).map(|frame| frame % 6).collect();
    assert_eq!(period(&turns), Some(6));
    // Negative controls: one that grows, and one that is off in a single frame.
    assert_eq!(period(&(0..24).collect::<Vec<u32>>()), None);
    let mut off = turns;
    off[23] = 9;
    assert_eq!(period(&off), None);
}
