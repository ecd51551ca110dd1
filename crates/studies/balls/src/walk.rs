// SPDX-License-Identifier: MIT OR Apache-2.0
//! Balls over terrain followed on their way, beside `f64`.
//!
//! After an impact no arithmetic of `f32` can hold a place to `f64`'s for long: slopes jump from cell to cell. So each
//! step is compared with that of `f64` from the state that the device had. The first impact is compared with the exact
//! event of the flight from the first state: its time, its place, and the energy that it takes.

use crate::flight::{
    ALLOWED_STEP_M, ALLOWED_STEP_SPEED, Flight, FlyingBall, Law, flown, normal_of,
};
use crate::on_devices::take;
use crate::steps::Steps;
use crate::terrain::State;
use terrafill_contract::DeviceError;

/// Steps that are taken: 0.6 s at 240 a second, in which balls that fall from up to 1.3 m meet the ground.
const FLIGHT_STEPS: u32 = 144;
/// The same for more balls than this: a step of a million takes a software device a tenth of a second. The lowest tenth
/// of them meet the ground.
const MANY: usize = 100_000;
const STEPS_OF_MANY: u32 = 48;
pub(crate) const FLIGHT_STEPS_PER_SECOND: u32 = 240;
/// Numbers of balls up to which every step is looked at. Of more, a step in so many is: reading them all takes longer
/// than stepping.
const EVERY_STEP: usize = 10_000;
const STRIDE: u32 = 24;
/// Balls that are followed at most: evenly spread over all.
const FOLLOWED: usize = 5_000;
/// What the time of the first impact of an exact event may differ by, seconds. A place is rounded by up to 7.6 µm in
/// each of 144 steps, which steep ground and a slow fall make 1e-4. The margin is about 3.
pub(crate) const ALLOWED_EVENT_S: f64 = 3e-4;
/// What the energy that such an impact takes may differ by, as a share of it. Where a ball falls slowly on steep ground,
/// its place is off by 1.5 mm. The slope changes over that, and the energy by a fiftieth. The margin is 2.5.
pub(crate) const ALLOWED_ENERGY: f64 = 0.05;
/// Steps after the exact event up to which an impact is that one: a step, and rounding.
const LATE: f64 = 1.25;
/// Share of the balls whose first impact may be missed: they dip into a crest between two steps.
const ALLOWED_MISSED: f64 = 0.01;
/// Deeper than this a ball has sunk, metres.
const SUNK_M: f64 = 0.25;

/// Steps that so many balls take.
pub(crate) fn flight_steps(balls: usize) -> u32 {
    if balls > MANY {
        STEPS_OF_MANY
    } else {
        FLIGHT_STEPS
    }
}

/// How balls were compared with `f64`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Walk {
    /// Largest difference of one step from the same state, along an axis.
    pub(crate) step_m: f64,
    pub(crate) step_speed: f64,
    /// Steps that were looked at, and those that rounding decided otherwise than `f64`.
    pub(crate) steps: usize,
    pub(crate) in_band: usize,
    pub(crate) followed: usize,
    /// Balls whose first impact was compared, and the largest and the root mean square difference of its time.
    pub(crate) impacts: usize,
    pub(crate) impact_max_s: f64,
    pub(crate) impact_rms_s: f64,
    /// Share of balls that impact within the steps and had none, or a step later than they should.
    pub(crate) missed_share: f64,
    /// Largest distance of the places of first impacts, metres, and largest difference of the energy lost, as a share of
    /// it; where every step was looked at.
    pub(crate) impact_place_m: Option<f64>,
    pub(crate) impact_energy: Option<f64>,
    /// Share of the balls that have sunk at the end.
    pub(crate) sunk_share: f64,
    /// That the CPU wrote for the device meanwhile.
    pub(crate) uploaded: u64,
    pub(crate) law: Option<Law>,
}

/// What is larger; what is no number stays.
pub(crate) fn most(one: f64, other: f64) -> f64 {
    if one.is_nan() || one > other {
        one
    } else {
        other
    }
}

/// Takes all steps beside `f64`.
///
/// - `first`: what the device has
pub(crate) fn walk(
    steps: &mut dyn Steps,
    flight: &Flight<'_>,
    first: &[State],
) -> Result<Walk, DeviceError> {
    let stride = first.len().div_ceil(FOLLOWED).max(1);
    let is_every = first.len() <= EVERY_STEP;
    let all_steps = flight_steps(first.len());
    let mut walk = Walk {
        followed: first.len().div_ceil(stride),
        law: Some(flight.law),
        ..Walk::default()
    };
    let between = if is_every { 0 } else { STRIDE - 1 };
    let mut before = first.to_vec();
    let mut taken = 0;
    let exact = |ball: &State| flight.first_impact(&FlyingBall::of(ball), all_steps);
    let exact: Vec<_> = first.iter().step_by(stride).map(exact).collect();
    let [mut place_m, mut energy] = [0.0_f64; 2];
    while taken < all_steps {
        if between > 0 {
            walk.uploaded += take(steps, between)?;
            before = steps.read()?;
        }
        walk.uploaded += take(steps, 1)?;
        taken += between + 1;
        let after = steps.read()?;
        if after.len() != first.len() {
            walk.step_m = f64::INFINITY;
            return Ok(walk);
        }
        let pairs = before.iter().zip(&after).step_by(stride);
        for ((before, after), exact) in pairs.zip(&exact) {
            let error = flight.judge(before, after);
            walk.step_m = most(error.place_m, walk.step_m);
            walk.step_speed = most(error.speed, walk.step_speed);
            walk.steps += 1;
            walk.in_band += usize::from(error.is_in_band);
            let [was, is] = [before, after].map(FlyingBall::of);
            let Some((time, [place, velocity])) = exact else {
                continue;
            };
            // A missed impact is counted below.
            let is_first = was.first_impact <= 0.0 && is.first_impact > 0.0;
            if is_first && (is.first_impact - time).abs() <= LATE {
                let time_s = (is.first_impact - was.steps) * flight.step_s;
                let [there, _] = flown(was.state, time_s);
                place_m = most(there.distance(*place), place_m);
                let (_, slopes) = flight.terrain.at(place.truncate());
                let inwards = velocity.dot(normal_of(slopes));
                let lost = 0.5 * (1.0 - flight.restitution.powi(2)) * inwards.powi(2);
                // Flight keeps energy: what is missing the impact took.
                let found = was.energy() - is.energy();
                energy = most((found - lost).abs() / lost, energy);
            }
        }
        before = after;
    }
    (walk.impact_place_m, walk.impact_energy) =
        (is_every.then_some(place_m), is_every.then_some(energy));
    walk.end(
        flight,
        exact.iter().map(|of| of.map(|(time, _)| time)),
        before.iter().step_by(stride),
    );
    Ok(walk)
}

impl Walk {
    /// Compares times of first impacts, and looks how deep balls are.
    fn end<'b>(
        &mut self,
        flight: &Flight<'_>,
        exact: impl Iterator<Item = Option<f64>>,
        last: impl Iterator<Item = &'b State>,
    ) {
        let (mut squares, mut missed, mut sunk) = (0.0, 0, 0);
        for (exact, last) in exact.zip(last) {
            let ball = FlyingBall::of(last);
            let (height, _) = flight.terrain.at(ball.state[0].truncate());
            sunk += usize::from(ball.state[0].z < height - SUNK_M);
            let found = (ball.first_impact > 0.0).then_some(ball.first_impact);
            let all_steps = ball.steps;
            match (exact, found) {
                (Some(exact), Some(found)) if found <= exact + LATE => {
                    let error_s = (found - exact).abs() * flight.step_s;
                    self.impact_max_s = most(error_s, self.impact_max_s);
                    squares += error_s * error_s;
                    self.impacts += 1;
                }
                // Within a step of the end an impact need not be seen.
                (Some(exact), None) if exact > all_steps - LATE => {}
                (None, None) => {}
                _ => missed += 1,
            }
        }
        self.impact_rms_s = (squares / self.impacts.max(1) as f64).sqrt();
        self.missed_share = missed as f64 / self.followed.max(1) as f64;
        self.sunk_share = sunk as f64 / self.followed.max(1) as f64;
    }

    /// What is wrong; empty where nothing is.
    pub(crate) fn reason(&self) -> String {
        let holds = |found: f64, allowed: f64| found <= allowed;
        let allowed_s = match self.law {
            Some(Law::Event) => ALLOWED_EVENT_S,
            // They are seen at the end of a step.
            _ => ALLOWED_EVENT_S + 1.0 / f64::from(FLIGHT_STEPS_PER_SECOND),
        };
        if !holds(self.step_m, ALLOWED_STEP_M) {
            format!(
                "a step is {} m from f64, allowed {ALLOWED_STEP_M} m",
                self.step_m
            )
        } else if !holds(self.step_speed, ALLOWED_STEP_SPEED) {
            format!(
                "a step is {} m/s from f64, allowed {ALLOWED_STEP_SPEED} m/s",
                self.step_speed
            )
        } else if !holds(self.impact_max_s, allowed_s) {
            format!(
                "a first impact is {} s from the exact event, allowed {allowed_s} s",
                self.impact_max_s
            )
        } else if self.law == Some(Law::Event)
            && !holds(self.impact_energy.unwrap_or(0.0), ALLOWED_ENERGY)
        {
            format!(
                "a first impact takes energy that is {} of it from what the restitution says, allowed {ALLOWED_ENERGY}",
                self.impact_energy.unwrap_or(0.0)
            )
        } else if !holds(self.missed_share, ALLOWED_MISSED) {
            format!(
                "{} of the balls have missed their first impact",
                self.missed_share
            )
        } else if self.impacts == 0 {
            "no ball meets the ground".to_owned()
        } else {
            String::new()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_is_wrong_is_said() {
        let right = Walk {
            impacts: 1,
            law: Some(Law::Event),
            ..Walk::default()
        };
        assert_eq!(right.reason(), "");
        let said = |change: fn(&mut Walk)| {
            let mut wrong = right;
            change(&mut wrong);
            wrong.reason()
        };
        assert!(said(|walk| walk.step_m = f64::NAN).contains("m from f64"));
        assert!(said(|walk| walk.step_speed = 1e-2).contains("m/s from f64"));
        assert!(said(|walk| walk.impact_max_s = 4e-3).contains("exact event"));
        assert!(said(|walk| walk.impact_energy = Some(0.1)).contains("restitution"));
        assert!(said(|walk| walk.missed_share = 0.5).contains("missed"));
        assert!(said(|walk| walk.impacts = 0).contains("no ball"));
        // A law that looks at the end of a step only may be a step late.
        let late = Walk {
            law: Some(Law::Guarded),
            impact_max_s: 4e-3,
            ..right
        };
        assert_eq!(late.reason(), "");
    }
}
