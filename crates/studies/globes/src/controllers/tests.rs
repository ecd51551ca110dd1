// SPDX-License-Identifier: MIT OR Apache-2.0
//! Controllers on devices, with counts that are wrong and counts of another case.

use super::*;
use terrafill_fixtures::on_device::on_device;

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
            let [steps, calm, wild, slow, fast] = STEPS;
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
            assert!(of(false, steps, 2, "globe_fan_growth") < Some(1.0));
            // Each step jumps past by 1.4 of what it was off, until the picture cuts the fan off; a calm one halves it.
            let growth = [wild, calm].map(|rule| of(false, rule, 1, "globe_fan_growth_least"));
            assert!(
                growth[0] > Some(1.3) && growth[0] < Some(1.5) && growth[1] < Some(0.6),
                "{growth:?}"
            );
            let cut = [wild, calm].map(|rule| of(false, rule, 1, "globe_fan_cut_frame"));
            assert!(cut[0] > Some(3.0) && cut[1].is_none(), "{cut:?}");
            // Corners go bare in turn; while the eye rises they grow with slow steps, and hover with fast ones.
            let share = of(false, slow, 1, "globe_bare_share");
            assert!(share > Some(0.0) && share < Some(1.0), "{share:?}");
            for delay in DELAYS {
                let growth = [slow, fast].map(|rule| of(true, rule, delay, "globe_bare_growth"));
                assert!(growth[0] > Some(2.0) && growth[1] < Some(1.5), "{growth:?}");
            }
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
fn growth_is_of_frames_before_the_fan_is_cut_off() {
    let drawn = [Drawn {
        first: 10 * PER_TURN,
        last: 20 * PER_TURN,
    }; 6];
    let found = |pixels: [u64; 6]| {
        let counts = pixels.map(|fan| Counted { fan, all: ALL_PX });
        growth_by_frame(&drawn, &counts)
    };
    // The error doubles twice; what the picture cuts off is no growth, nor what follows.
    let figures = found([
        WANTED_PX / 2,
        4 * WANTED_PX,
        WANTED_PX / 16,
        ALL_PX,
        9,
        ALL_PX,
    ]);
    assert_eq!(figures[1], ("globe_fan_cut_frame", 3.0));
    assert!((figures[0].1 - 2.0).abs() < 0.01, "{figures:?}");
    // Negative controls: one frame that grows less, and a fan that is cut off before it has grown twice.
    let calm = found([
        WANTED_PX / 2,
        4 * WANTED_PX,
        2 * WANTED_PX,
        ALL_PX,
        9,
        ALL_PX,
    ]);
    assert!((calm[0].1 - 0.5).abs() < 0.01, "{calm:?}");
    assert_eq!(
        found([WANTED_PX / 2, 4 * WANTED_PX, ALL_PX, 9, 9, 9]),
        [("globe_fan_cut_frame", 2.0)]
    );
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
