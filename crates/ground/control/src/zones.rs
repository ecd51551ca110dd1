// SPDX-License-Identifier: MIT OR Apache-2.0
//! A zone of a height field whose level of detail follows its counted pixels.
//!
//! A level has four times the triangles of the one below it: every second row and column is dropped (geomipmaps). A
//! zone becomes finer where it has more pixels a triangle than the upper threshold, and coarser where it has fewer than
//! the lower one. Where a finer level shows a spike that hides all but 1/m of the zone's own pixels, it has fewer pixels
//! the finer it is, which no loop expects. (Gebbie and Bailey saw such oscillations "bypass even large buffer
//! thresholds".)

/// When a zone changes its level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoneRule {
    /// Triangles of level 0, the coarsest.
    triangles: f64,
    /// The finest level.
    finest: u32,
    /// Pixels a triangle: fewer make it coarser, more make it finer.
    low: f64,
    high: f64,
}

impl ZoneRule {
    /// - `triangles`: of level 0
    /// - `wanted`: pixels a triangle
    /// - `hysteresis`: the upper threshold over the lower one, which is `wanted / √hysteresis`
    #[must_use]
    pub fn new(triangles: f64, finest: u32, wanted: f64, hysteresis: f64) -> Self {
        Self {
            triangles,
            finest,
            low: wanted / hysteresis.sqrt(),
            high: wanted * hysteresis.sqrt(),
        }
    }

    /// Triangles of a level.
    #[must_use]
    pub fn triangles(&self, level: u32) -> f64 {
        self.triangles * 4_f64.powi(i32::try_from(level).unwrap_or(i32::MAX))
    }

    /// The level after one that was drawn with so many pixels.
    #[must_use]
    pub fn next(&self, level: u32, pixels: f64) -> u32 {
        let each = pixels / self.triangles(level);
        match level {
            level if each > self.high && level < self.finest => level + 1,
            level if each < self.low && level > 0 => level - 1,
            level => level,
        }
    }

    /// Levels frame by frame of a zone that begins at the coarsest, in a view that stands still.
    ///
    /// - `pixels`: of a level
    /// - `delay`: frames from drawing to using a count; a zone acts on counts of its own level alone
    #[must_use]
    pub fn course(&self, pixels: impl Fn(u32) -> f64, delay: usize, frames: usize) -> Vec<u32> {
        let mut levels = vec![0];
        let mut since = 0;
        for frame in 0..frames {
            let now = levels[frame];
            let is_own = frame >= since + delay;
            let next = if is_own {
                self.next(now, pixels(now))
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
}

/// Whether a course changes in its last half.
#[must_use]
pub fn changes_to_the_end(course: &[u32]) -> bool {
    let end = &course[course.len() / 2..];
    end.windows(2).any(|pair| pair[0] != pair[1])
}

/// How many numbers of pixels let a zone cycle whose finest level shows a spike that hides all but `1 / hides` of them.
/// The numbers lie evenly on a logarithm, from far too few to far too many.
///
/// - `hysteresis`: as [`ZoneRule::new`]
/// - `count`: of numbers of pixels
#[must_use]
pub fn cycling_zones(hysteresis: f64, hides: f64, delay: usize, count: u32) -> usize {
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
        changes_to_the_end(&rule.course(pixels, delay, 64))
    };
    (0..count).filter(cycles).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zone_takes_the_level_that_its_pixels_ask_for() {
        let rule = ZoneRule::new(8.0, 3, 4.0, 4.0);
        // 8, 32, 128, 512 triangles between 2 and 8 pixels each.
        for (pixels, level) in [(10.0, 0), (60.0, 0), (100.0, 1), (600.0, 2), (1e6, 3)] {
            let course = rule.course(|_| pixels, 1, 40);
            assert_eq!(course.last(), Some(&level), "{pixels}: {course:?}");
            assert!(!changes_to_the_end(&course));
        }
        // One level a frame, and two frames where a count is a frame old.
        assert_eq!(rule.course(|_| 1e6, 0, 4), [0, 1, 2, 3, 3]);
        assert_eq!(rule.course(|_| 1e6, 1, 6), [0, 0, 1, 1, 2, 2, 3]);
    }

    #[test]
    fn a_hysteresis_of_four_times_what_a_spike_hides_never_cycles_and_less_does() {
        for delay in 0..4 {
            for hides in [1.0, 2.0, 4.0] {
                let enough = cycling_zones(4.0 * hides, hides, delay, 400);
                let less = cycling_zones(0.9 * 4.0 * hides, hides, delay, 400);
                eprintln!(
                    "delay {delay}, hides all but 1/{hides}: {enough} at 4 m, {less} at 3.6 m"
                );
                assert_eq!(enough, 0, "{delay} {hides}");
                // Twin.
                assert!(less > 0, "{delay} {hides}");
            }
        }
        assert!(changes_to_the_end(&[0, 1, 2, 3, 2, 3]));
    }
}
