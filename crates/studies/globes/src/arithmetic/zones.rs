// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which zones of [`crate::zones`] never rest, in closed form: a zone begins at the coarsest level, in a view that
//! stands still.

use crate::zones::rule::ZoneRule;

/// Levels frame by frame of a zone that begins at the coarsest, in a view that stands still.
///
/// - `pixels`: of a level
/// - `delay`: frames from drawing to using a count; a zone acts on counts of its own level alone
fn course(rule: &ZoneRule, pixels: impl Fn(u32) -> f64, delay: usize, frames: usize) -> Vec<u32> {
    let mut levels = vec![0];
    let mut since = 0;
    for frame in 0..frames {
        let now = levels[frame];
        let is_own = frame >= since + delay;
        let next = if is_own {
            rule.next(now, pixels(now))
        } else {
            now
        };
        if next != now {
            since = frame + 1;
        }
        levels.push(next);
    }
    levels
}

/// Whether a course changes in its last half.
fn changes_to_the_end(course: &[u32]) -> bool {
    let end = &course[course.len() / 2..];
    end.windows(2).any(|pair| pair[0] != pair[1])
}

/// How many numbers of pixels let a zone cycle whose finest level shows a spike that hides all but `1 / hides` of them.
/// The numbers lie evenly on a logarithm, from far too few to far too many.
///
/// - `hysteresis`: as [`ZoneRule::new`]
/// - `count`: of numbers of pixels
pub(super) fn cycling_zones(hysteresis: f64, hides: f64, delay: usize, count: u32) -> usize {
    const FINEST: u32 = 3;
    let rule = ZoneRule::new(8.0, FINEST, 1.0, hysteresis);
    let cycles = |number: &u32| {
        let share = (f64::from(*number) + 0.5) / f64::from(count);
        let most = rule.triangles(FINEST) * 1e2;
        let visible = most.powf(share);
        let pixels = |level| match level {
            FINEST => visible / hides,
            _ => visible,
        };
        changes_to_the_end(&course(&rule, pixels, delay, 64))
    };
    (0..count).filter(cycles).count()
}

#[test]
fn a_zone_takes_the_level_that_its_pixels_ask_for() {
    let rule = ZoneRule::new(8.0, 3, 4.0, 4.0);
    // 8, 32, 128, 512 triangles between 2 and 8 pixels each.
    for (pixels, level) in [(10.0, 0), (60.0, 0), (100.0, 1), (600.0, 2), (1e6, 3)] {
        let course = course(&rule, |_| pixels, 1, 40);
        assert_eq!(course.last(), Some(&level), "{pixels}: {course:?}");
        assert!(!changes_to_the_end(&course));
    }
    // One level a frame, and two frames where a count is a frame old.
    assert_eq!(course(&rule, |_| 1e6, 0, 4), [0, 1, 2, 3, 3]);
    assert_eq!(course(&rule, |_| 1e6, 1, 6), [0, 0, 1, 1, 2, 2, 3]);
}

#[test]
fn a_course_that_cycles_is_noticed() {
    assert!(changes_to_the_end(&[0, 1, 2, 3, 2, 3]));
}
