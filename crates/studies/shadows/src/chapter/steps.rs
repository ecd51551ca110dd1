// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured of the ladder, of emulated depth bounds and of rivals.

use super::findings::{is_same_but, of_all, range};
use super::{Own, is_plain, number};
use crate::keys::{API, DEPTH_BOUNDS, FILL_CPU, FILL_GPU, PAPER, RIVAL, STEP, SUN};
use terrafill_results::{Case, Clock, Estimate, Finding, Metric, Outcome, Standing, ratio};

/// Depth bounds of casters and of their parts.
const EMULATED: [&str; 6] = [
    "native",
    "native, by part",
    "discard",
    "discard, by part",
    "tiles",
    "tiles, by part",
];

impl<'a> Own<'a> {
    /// Depth bounds by discarding and by tiles, against none.
    pub(super) fn emulated(&self, clock: Clock) -> Option<Finding> {
        let metric = clock.pick(FILL_GPU, FILL_CPU);
        let noise = self.noise(metric);
        let mut texts = Vec::new();
        let mut standings = Vec::new();
        for how in EMULATED {
            let mut gains = Vec::new();
            let of_devices = || self.of_question("devices");
            let is_ok = |case: &&Case| case.outcome == Outcome::Ok;
            let all = of_devices().filter(is_ok);
            for case in all.filter(|case| case.condition(DEPTH_BOUNDS) == how) {
                let mut plain = of_devices().filter(is_ok);
                let plain = plain.find(|other| {
                    other.condition(DEPTH_BOUNDS) == "off"
                        && is_same_but(&[DEPTH_BOUNDS], case, other)
                });
                if let Some(gain) = plain.and_then(|plain| ratio(plain, case, metric)) {
                    gains.push(gain.middle);
                    standings.push(Standing::of_times(&gain, noise).0);
                }
            }
            texts.extend(range(&gains).map(|gains| format!("{how}: {gains}")));
        }
        (!texts.is_empty()).then(|| Finding {
            claim: "Depth bounds are faster, by the device's test or emulated.".to_owned(),
            standing: of_all(&standings),
            because: format!(
                "Times as fast as without, by {}: {}",
                clock.name(),
                texts.join("; ")
            ),
        })
    }

    /// Steps of the ladder with what each gains over the last one that could be drawn.
    fn gains(&self, metric: &Metric) -> Vec<(&'a Case, f64, Standing)> {
        let noise = self.noise(metric);
        let mut gains = Vec::new();
        let mut last: Option<&Case> = None;
        let done = |case: &&Case| case.outcome == Outcome::Ok;
        for case in self.of_question("ladder").filter(done) {
            let is_next = |before: &&Case| {
                [SUN, API]
                    .iter()
                    .all(|key| before.condition(*key) == case.condition(*key))
            };
            let gain = last
                .filter(is_next)
                .and_then(|before| ratio(before, case, metric));
            let judged = |gain: Estimate| (case, gain.middle, Standing::of_times(&gain, noise).0);
            gains.extend(gain.map(judged));
            last = Some(case);
        }
        gains
    }

    pub(super) fn ladder(&self, clock: Clock) -> Option<Finding> {
        let metric = clock.pick(FILL_GPU, FILL_CPU);
        let gains = self.gains(metric);
        let mut steps: Vec<&str> = Vec::new();
        for (case, ..) in &gains {
            if !steps.contains(&case.condition(STEP)) {
                steps.push(case.condition(STEP));
            }
        }
        let text = steps.iter().filter_map(|step| {
            let own = gains
                .iter()
                .filter(|(case, ..)| case.condition(STEP) == *step);
            let own: Vec<f64> = own.map(|(_, gain, _)| *gain).collect();
            Some(format!("{step}: {}", range(&own)?))
        });
        let text: Vec<String> = text.collect();
        let anticipated = gains
            .iter()
            .filter(|(case, ..)| case.condition(PAPER).contains("anticipated"));
        let standings: Vec<Standing> = anticipated.map(|(.., standing)| *standing).collect();
        (!standings.is_empty()).then(|| Finding {
            claim: "Each step of the ladder that was anticipated to be faster is (Yang & Jin, 2006, anticipated).".to_owned(),
            standing: of_all(&standings),
            because: format!(
                "Times as fast to draw as the step before, by {}: {}",
                clock.name(),
                text.join("; ")
            ),
        })
    }

    /// Rivals' pixels, and their times beside those of volumes by the same interface.
    pub(super) fn rivals(&self, clock: Clock) -> Option<Finding> {
        let metric = clock.pick(FILL_GPU, FILL_CPU);
        let noise = self.noise(metric);
        let known = |case: &&Case| matches!(case.outcome, Outcome::Ok | Outcome::Wrong);
        let all: Vec<&Case> = self.of_question("rivals").filter(known).collect();
        let wrong: Option<Vec<f64>> = all.iter().map(|case| Self::wrong_px(case)).collect();
        let wrong: f64 = wrong?.iter().sum();
        let mut names: Vec<&str> = all.iter().map(|case| case.condition(RIVAL)).collect();
        names.dedup();
        names.sort_unstable();
        names.dedup();
        let mut standings = vec![Standing::holds_if(wrong == 0.0)];
        let mut texts = Vec::new();
        for name in names {
            let own = all.iter().filter(|case| case.condition(RIVAL) == name);
            let gains = own.filter_map(|case| {
                let mut volumes = self
                    .of_question("devices")
                    .filter(|other| is_volumes(other, case));
                ratio(case, volumes.next()?, metric)
            });
            let gains: Vec<_> = gains.collect();
            standings.extend(gains.iter().map(|gain| Standing::of_times(gain, noise).0));
            let middles: Vec<f64> = gains.iter().map(|gain| gain.middle).collect();
            texts.extend(range(&middles).map(|range| format!("{name}: {range}")));
        }
        (!all.is_empty()).then(|| Finding {
            claim: "Volumes closed at the sea are faster than rivals that are as exact.".to_owned(),
            standing: of_all(&standings),
            because: format!(
                "{} pixels of rivals are wrong outside the band. Times of rivals over those of volumes, by {}: {}",
                number(wrong),
                clock.name(),
                texts.join("; ")
            ),
        })
    }
}

/// Volumes as the rows of an interface begin with them, under a rival's sun.
fn is_volumes(case: &Case, rival: &Case) -> bool {
    let same = [SUN, API]
        .iter()
        .all(|key| case.condition(*key) == rival.condition(*key));
    same && is_plain(case)
}
