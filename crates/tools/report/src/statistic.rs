// SPDX-License-Identifier: MIT OR Apache-2.0
//! The statistics and thresholds that only the report uses; shared ones are in `terrafill-results`.
//!
//! The Pareto front of error against time is drawn only where it is not luck: frames are resampled
//! within each case (Efron, 1979, "Bootstrap methods"), the front is found anew for each resample,
//! and a case stays on it when it belongs to nearly all of those fronts. Errors are exact counts and
//! are not resampled. The seed is fixed, so the same CSV gives the same report, byte for byte.

use terrafill_results::legacy::{Spread, median};

/// Resamples of the bootstrap: at 95 % the standard error of a survival rate is 0.7 %.
pub(crate) const BOOTSTRAP_RESAMPLES: u32 = 1000;

/// Any number will do; a fixed one makes reports repeatable.
pub(crate) const BOOTSTRAP_SEED: u64 = 0x7465_7272_6166_696c;

/// Share of resamples in which a case must lie on the front to be drawn on it.
pub(crate) const FRONT_SURVIVAL: f64 = 0.95;

/// Fewest frames of a case from which its place on the front can be judged. The median of fewer
/// repeats hardly moves under resampling, which would look like certainty.
pub(crate) const FRONT_MIN_FRAMES: usize = 5;

/// Largest relative difference between a median in `summary.csv` and the one of its samples: both
/// come from the same numbers by the same formula, so only rounding in the text may part them.
pub(crate) const SUMMARY_AGREEMENT: f64 = 1e-9;

/// One case that competes for the front.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate<'a> {
    /// Time of each frame.
    pub(crate) times: &'a [f64],
    /// Its error; less is better.
    pub(crate) error: f64,
}

/// Which points no other one beats: at most equal in both coordinates and better in one.
pub(crate) fn front(points: &[[f64; 2]]) -> Vec<bool> {
    let beats =
        |a: &[f64; 2], b: &[f64; 2]| a[0] <= b[0] && a[1] <= b[1] && (a[0] < b[0] || a[1] < b[1]);
    points
        .iter()
        .map(|point| !points.iter().any(|other| beats(other, point)))
        .collect()
}

/// Share of the resamples in which each candidate lies on the front; 0 for those with fewer than
/// [`FRONT_MIN_FRAMES`] frames.
pub(crate) fn front_survival(candidates: &[Candidate<'_>]) -> Vec<f64> {
    let mut random = SplitMix64(BOOTSTRAP_SEED);
    let mut hits = vec![0_u32; candidates.len()];
    for _ in 0..BOOTSTRAP_RESAMPLES {
        let points: Vec<[f64; 2]> = candidates
            .iter()
            .map(|candidate| [random.resampled_median(candidate.times), candidate.error])
            .collect();
        for (hit, on_front) in hits.iter_mut().zip(front(&points)) {
            *hit += u32::from(on_front);
        }
    }
    candidates
        .iter()
        .zip(hits)
        .map(|(candidate, hits)| {
            if candidate.times.len() < FRONT_MIN_FRAMES {
                0.0
            } else {
                f64::from(hits) / f64::from(BOOTSTRAP_RESAMPLES)
            }
        })
        .collect()
}

/// A spread of times divided by the median of a baseline.
pub(crate) fn over(spread: Spread, baseline: f64) -> Spread {
    Spread {
        p5: spread.p5 / baseline,
        median: spread.median / baseline,
        p95: spread.p95 / baseline,
    }
}

/// Whether a median from the summary is the one of its samples.
pub(crate) fn agrees(summary: f64, samples: f64) -> bool {
    (summary - samples).abs() <= SUMMARY_AGREEMENT * samples.abs()
}

/// The generator of Steele, Lea and Flood (2014), "Fast splittable pseudorandom number generators".
pub(crate) struct SplitMix64(pub(crate) u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `limit`, by multiplication (Lemire, 2019); its bias of `limit` / 2⁶⁴ is nothing here.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the high half of the product is below `limit`"
    )]
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        ((u128::from(self.next()) * limit as u128) >> 64) as usize
    }

    /// Infinite for no samples, so that a case without times is never on a front.
    pub(crate) fn resampled_median(&mut self, times: &[f64]) -> f64 {
        let resample: Vec<f64> = times
            .iter()
            .map(|_| times[self.below(times.len())])
            .collect();
        median(&resample).unwrap_or(f64::INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_by_hand() {
        let points = [[1.0, 9.0], [2.0, 4.0], [3.0, 5.0], [4.0, 0.0], [4.0, 0.0]];
        assert_eq!(front(&points), [true, true, false, true, true]);
        assert_eq!(front(&[]), [false; 0]);
    }

    #[test]
    fn clear_winners_survive_and_ties_do_not() {
        let fast = [1.0, 1.1, 1.2, 1.05, 1.15, 1.08];
        let slow = [9.0, 9.1, 9.2, 9.05, 9.15, 9.08];
        let noisy_a = [5.0, 6.0, 5.5, 6.5, 5.2, 6.2, 5.7, 6.1];
        let noisy_b = [5.1, 5.9, 5.6, 6.4, 5.3, 6.3, 5.6, 6.2];
        let candidate = |times, error| Candidate { times, error };
        let survival = front_survival(&[
            candidate(&fast, 100.0),
            candidate(&slow, 0.0),
            candidate(&slow, 200.0),
            candidate(&noisy_a, 10.0),
            candidate(&noisy_b, 10.0),
        ]);
        assert!(survival[0] >= 1.0 && survival[1] >= 1.0, "{survival:?}");
        assert!(survival[2] <= 0.0, "beaten in both coordinates");
        // Twin: two methods that only noise tells apart must not both be called best.
        for unsure in &survival[3..] {
            assert!(*unsure < FRONT_SURVIVAL, "{survival:?}");
        }
    }

    #[test]
    fn too_few_frames_prove_nothing() {
        let survival = front_survival(&[Candidate {
            times: &[1.0; FRONT_MIN_FRAMES - 1],
            error: 0.0,
        }]);
        assert_eq!(survival, [0.0]);
        let enough = front_survival(&[Candidate {
            times: &[1.0; FRONT_MIN_FRAMES],
            error: 0.0,
        }]);
        assert_eq!(enough, [1.0]);
    }

    #[test]
    fn the_same_samples_give_the_same_answer() {
        let times = [3.0, 1.0, 2.0, 5.0, 4.0];
        let candidates = [
            Candidate {
                times: &times,
                error: 1.0,
            },
            Candidate {
                times: &times,
                error: 1.0,
            },
        ];
        assert_eq!(front_survival(&candidates), front_survival(&candidates));
    }

    #[test]
    fn resampling_draws_every_frame_about_equally_often() {
        let mut random = SplitMix64(BOOTSTRAP_SEED);
        let mut drawn = [0_u32; 7];
        for _ in 0..70_000 {
            drawn[random.below(7)] += 1;
        }
        // Five standard deviations of a count with mean 10,000 are 463.
        assert!(drawn.iter().all(|&n| n.abs_diff(10_000) < 463), "{drawn:?}");
    }

    #[test]
    fn agreement_is_about_rounding_only() {
        assert!(agrees(10.0, 10.0 + 1e-12));
        assert!(!agrees(10.0, 10.001));
        assert!(!agrees(f64::NAN, 10.0));
    }
}
