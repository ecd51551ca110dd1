// SPDX-License-Identifier: MIT OR Apache-2.0
//! The Pareto front of error against cost, kept only where it is not luck.
//!
//! Replicates are resampled within each case, the front is found anew for each resample, and a case
//! stays on it when it belongs to at least [`FRONT_SURVIVAL`](crate::threshold::FRONT_SURVIVAL) of
//! those fronts. Errors are exact counts and are not resampled.

use crate::resample::{generator, resampled_median};
use crate::threshold::{BOOTSTRAP_RESAMPLES, MIN_REPLICATES};

/// One case that competes for the front.
#[derive(Debug, Clone, Copy)]
pub struct Candidate<'a> {
    /// Its cost, one number per process.
    pub costs: &'a [f64],
    /// Its error; less is better.
    pub error: f64,
}

/// Which points no other one beats: at most equal in both coordinates and better in one.
#[must_use]
pub fn front(points: &[[f64; 2]]) -> Vec<bool> {
    let beats =
        |a: &[f64; 2], b: &[f64; 2]| a[0] <= b[0] && a[1] <= b[1] && (a[0] < b[0] || a[1] < b[1]);
    points
        .iter()
        .map(|point| !points.iter().any(|other| beats(other, point)))
        .collect()
}

/// Share of the resamples in which each candidate lies on the front; 0 for those with fewer than
/// [`MIN_REPLICATES`] replicates.
#[must_use]
pub fn front_survival(candidates: &[Candidate<'_>]) -> Vec<f64> {
    let mut random = generator();
    let mut hits = vec![0_u32; candidates.len()];
    for _ in 0..BOOTSTRAP_RESAMPLES {
        let points: Vec<[f64; 2]> = candidates
            .iter()
            .map(|candidate| {
                [
                    resampled_median(&mut random, candidate.costs),
                    candidate.error,
                ]
            })
            .collect();
        for (hit, on_front) in hits.iter_mut().zip(front(&points)) {
            *hit += u32::from(on_front);
        }
    }
    candidates
        .iter()
        .zip(hits)
        .map(|(candidate, hits)| {
            if candidate.costs.len() < MIN_REPLICATES {
                0.0
            } else {
                f64::from(hits) / f64::from(BOOTSTRAP_RESAMPLES)
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threshold::FRONT_SURVIVAL;

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
        let candidate = |costs, error| Candidate { costs, error };
        let survival = front_survival(&[
            candidate(&fast, 100.0),
            candidate(&slow, 0.0),
            candidate(&slow, 200.0),
            candidate(&noisy_a, 10.0),
            candidate(&noisy_b, 10.0),
        ]);
        assert!(survival[0] >= 1.0 && survival[1] >= 1.0, "{survival:?}");
        assert!(survival[2] <= 0.0, "beaten in both coordinates");
        // Negative control: two methods that only noise tells apart must not both be called best.
        for unsure in &survival[3..] {
            assert!(*unsure < FRONT_SURVIVAL, "{survival:?}");
        }
    }

    #[test]
    fn too_few_replicates_prove_nothing() {
        let survival = |costs| front_survival(&[Candidate { costs, error: 0.0 }]);
        assert_eq!(survival(&[1.0; MIN_REPLICATES - 1]), [0.0]);
        assert_eq!(survival(&[1.0; MIN_REPLICATES]), [1.0]);
    }

    #[test]
    fn the_same_samples_give_the_same_answer() {
        let costs = [3.0, 1.0, 2.0, 5.0, 4.0];
        let one = Candidate {
            costs: &costs,
            error: 1.0,
        };
        assert_eq!(front_survival(&[one, one]), front_survival(&[one, one]));
    }
}
