// SPDX-License-Identifier: MIT OR Apache-2.0
//! Balls in free flight that are reflected about the terrain's normal: a step in `f64`, by which devices are judged.
//!
//! Flight itself is exact, since gravity is constant. What a ball does that is below the ground at the end of a step is a
//! [`Law`]. Metres, seconds, z up.

use crate::closed_form::GRAVITY;
use crate::terrain::{CELL_M, State, Terrain};
use glam::{DVec2, DVec3};

terrafill_results::named! {
    /// What happens to a ball that is below the ground at the end of a step.
    #[derive(PartialOrd, Ord)]
    all pub(crate) enum Law {
        /// Its velocity is reflected, as published: also where it leads out of the ground, and the ball stays there.
        Published = "as-published",
        /// The same, only where its velocity leads into the ground.
        Guarded = "inwards-only",
        /// It is taken back to where it met the ground, is reflected there and flies on for the rest of the step.
        Event = "at-event",
    }
}

impl Law {
    /// As shaders have it.
    pub(crate) fn number(self) -> u32 {
        match self {
            Self::Published => 0,
            Self::Guarded => 1,
            Self::Event => 2,
        }
    }
}

/// Share of the speed along the normal that a reflection leaves.
pub(crate) const RESTITUTION: f64 = 0.8;

/// Radius of a crater over the speed of the ball that strikes, seconds, and depth over radius; exact in `f32`. A ball that
/// falls 1 m digs a crater 2.2 m wide and 28 cm deep.
pub(crate) const CRATER_S: f64 = 0.25;
pub(crate) const CRATER_DEPTH: f64 = 0.25;

/// A ball in `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FlyingBall {
    /// Place and velocity.
    pub(crate) state: [DVec3; 2],
    /// Steps taken.
    pub(crate) steps: f64,
    /// Time of the first impact, steps; 0 before it.
    pub(crate) first_impact: f64,
}

impl FlyingBall {
    pub(crate) fn of(state: &State) -> Self {
        Self {
            state: state.map(|of| DVec3::from_slice(&of.map(f64::from))),
            steps: f64::from(state[0][3]),
            first_impact: f64::from(state[1][3]),
        }
    }

    /// Height and speed as energy a kilogramme, J.
    pub(crate) fn energy(&self) -> f64 {
        GRAVITY * self.state[0].z + 0.5 * self.state[1].length_squared()
    }
}

/// Place and velocity after free flight.
pub(crate) fn flown([place, velocity]: [DVec3; 2], time_s: f64) -> [DVec3; 2] {
    let faster = DVec3::Z * (GRAVITY * time_s);
    [
        place + time_s * (velocity - 0.5 * faster),
        velocity - faster,
    ]
}

/// A velocity after a reflection that leaves a share of the speed along the normal.
pub(crate) fn reflected(velocity: DVec3, normal: DVec3, restitution: f64) -> DVec3 {
    velocity - (1.0 + restitution) * velocity.dot(normal) * normal
}

/// Upwards from ground with these slopes.
pub(crate) fn normal_of(slopes: DVec2) -> DVec3 {
    (-slopes).extend(1.0).normalize()
}

/// How balls step over a terrain.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flight<'a> {
    pub(crate) terrain: &'a Terrain,
    pub(crate) law: Law,
    pub(crate) restitution: f64,
    pub(crate) step_s: f64,
}

/// What rounding may decide otherwise in a step.
#[derive(Debug, Clone, Copy, Default)]
struct Decided {
    /// Whether the ball is below the ground at the end of the step; `None` for what `f64` finds.
    is_below: Option<bool>,
    /// From the place whose cell has the slopes to the place itself.
    lean: DVec2,
}

/// Within this of a cell's border `f32` may find either cell, and within this of the ground either side, metres.
const BAND_M: f64 = 1e-4;
/// Within this of 0, a speed along the normal may have either sign.
const BAND_SPEED: f64 = 1e-4;
/// What a place may differ by in one step, metres along an axis. Places up to 256 m are rounded by 7.6 µm, and twice
/// where there is an impact. The impact's time errs by as much over the speed.
pub(crate) const ALLOWED_STEP_M: f64 = 6e-5;
/// What a velocity may, metres a second.
pub(crate) const ALLOWED_STEP_SPEED: f64 = 2e-4;

/// How a step differs from that of `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepError {
    /// Along an axis, metres and metres a second.
    pub(crate) place_m: f64,
    pub(crate) speed: f64,
    /// Whether rounding decided otherwise than `f64`.
    pub(crate) is_in_band: bool,
}

impl StepError {
    fn is_allowed(&self) -> bool {
        self.place_m <= ALLOWED_STEP_M && self.speed <= ALLOWED_STEP_SPEED
    }
}

impl Flight<'_> {
    /// A step of a ball.
    pub(crate) fn step(&self, ball: &FlyingBall) -> FlyingBall {
        self.decided(ball, Decided::default())
    }

    fn decided(&self, ball: &FlyingBall, decided: Decided) -> FlyingBall {
        let mut after = *ball;
        after.steps += 1.0;
        after.state = flown(ball.state, self.step_s);
        let [end, _] = after.state;
        let is_below = end.z < self.terrain.at(end.truncate()).0;
        if !decided.is_below.unwrap_or(is_below) {
            return after;
        }
        let is_event = self.law == Law::Event;
        let met = self.terrain.meets(&ball.state, self.step_s);
        let time_s = met.filter(|_| is_event).unwrap_or(self.step_s);
        let [place, velocity] = flown(ball.state, time_s);
        let cell = Terrain::cell_of(place.truncate() + decided.lean);
        let (height, slopes) = self.terrain.at_in(cell, place.truncate());
        let normal = normal_of(slopes);
        let is_reflected = velocity.dot(normal) < 0.0 || self.law == Law::Published;
        let onward = if is_reflected {
            reflected(velocity, normal, self.restitution)
        } else {
            velocity
        };
        if is_reflected && ball.first_impact <= 0.0 {
            after.first_impact = ball.steps + time_s / self.step_s;
        }
        let from = if is_event {
            place.truncate().extend(height)
        } else {
            place
        };
        after.state = flown([from, onward], self.step_s - time_s);
        after
    }

    /// Compares a device's step with that of `f64` from the same state; with what rounding may decide otherwise, only
    /// where it may.
    pub(crate) fn judge(&self, before: &State, after: &State) -> StepError {
        let (before, after) = (FlyingBall::of(before), FlyingBall::of(after));
        let error = |decided: Decided, is_in_band: bool| {
            let expected = self.decided(&before, decided).state;
            let [place_m, speed] =
                [0, 1].map(|of| (expected[of] - after.state[of]).abs().max_element());
            StepError {
                place_m,
                speed,
                is_in_band,
            }
        };
        let own = error(Decided::default(), false);
        if own.is_allowed() || after.steps - before.steps != 1.0 {
            return own;
        }
        let [end, velocity] = flown(before.state, self.step_s);
        let (height, slopes) = self.terrain.at(end.truncate());
        let is_close = (end.z - height).abs() <= BAND_M;
        let is_along = velocity.dot(normal_of(slopes)).abs() <= BAND_SPEED;
        let below: &[Option<bool>] = if is_close || is_along {
            &[None, Some(false), Some(true)]
        } else {
            &[None]
        };
        let leans = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
        let other = below.iter().flat_map(|&is_below| {
            leans.map(|lean| Decided {
                is_below,
                lean: lean * BAND_M,
            })
        });
        let errors = other.map(|decided| error(decided, true));
        let least = errors.min_by(|a, b| a.speed.total_cmp(&b.speed));
        least.filter(StepError::is_allowed).unwrap_or(own)
    }

    /// The first impact of a ball within so many steps, exactly: its time in steps, and place and velocity as it comes.
    pub(crate) fn first_impact(&self, ball: &FlyingBall, steps: u32) -> Option<(f64, [DVec3; 2])> {
        let time_s = self
            .terrain
            .meets(&ball.state, f64::from(steps) * self.step_s)?;
        Some((time_s / self.step_s, flown(ball.state, time_s)))
    }
}

/// Whether a cell is wider than the band, so that at most one border is near along an axis.
const _: () = assert!(CELL_M > 2.0 * BAND_M);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Real as _;

    fn flight(terrain: &Terrain, law: Law, restitution: f64) -> Flight<'_> {
        Flight {
            terrain,
            law,
            restitution,
            step_s: 1.0 / 240.0,
        }
    }

    /// The state of a ball after so many steps of `f64`.
    fn narrow(ball: &FlyingBall) -> State {
        let rounded = |of: DVec3, last: f64| of.extend(last).to_array().map(f32::of);
        [
            rounded(ball.state[0], ball.steps),
            rounded(ball.state[1], ball.first_impact),
        ]
    }

    #[test]
    fn exact_events_keep_energy_and_lose_what_the_restitution_says() {
        let terrain = Terrain::new();
        for state in terrain.balls(200) {
            let first = FlyingBall::of(&state);
            for restitution in [1.0, 0.8] {
                let flight = flight(&terrain, Law::Event, restitution);
                let (time, [place, velocity]) = flight.first_impact(&first, 240).expect("it falls");
                let mut ball = first;
                while ball.first_impact <= 0.0 {
                    ball = flight.step(&ball);
                }
                assert!((ball.first_impact - time).abs() < 1e-9, "{state:?}");
                let normal = normal_of(terrain.at(place.truncate()).1);
                let lost = 0.5 * (1.0 - restitution * restitution) * velocity.dot(normal).powi(2);
                let found = first.energy() - ball.energy();
                assert!(
                    (found - lost).abs() < 1e-9 * first.energy().abs().max(1.0),
                    "{found} {lost}"
                );
                // Negative control: another restitution loses something else.
                let other = 0.5 * (1.0 - 0.5 * 0.5) * velocity.dot(normal).powi(2);
                assert!((found - other).abs() > 1e-3, "{found} {other}");
            }
        }
    }

    #[test]
    fn a_flipped_normal_a_wrong_block_and_a_reflection_left_out_are_noticed() {
        let terrain = Terrain::new();
        for law in Law::ALL {
            let flight = flight(&terrain, law, RESTITUTION);
            let [mut right, mut wrong, mut hits] = [0; 3];
            for state in terrain.balls(300) {
                let mut ball = FlyingBall::of(&state);
                for _ in 0..144 {
                    let before = narrow(&ball);
                    let from = FlyingBall::of(&before);
                    let after = flight.step(&from);
                    let error = flight.judge(&before, &narrow(&after));
                    assert!(error.is_allowed() && !error.is_in_band, "{error:?}");
                    if after.first_impact > from.first_impact {
                        hits += 1;
                        // Slopes of the other sign; the block beside; no reflection at all.
                        let (_, slopes) = terrain.at(after.state[0].truncate());
                        let [place, velocity] = flown(from.state, flight.step_s);
                        let reflect = |slopes| FlyingBall {
                            state: [place, reflected(velocity, normal_of(slopes), RESTITUTION)],
                            ..after
                        };
                        let beside = place.truncate() + DVec2::new(64.0, 0.0);
                        let others = [
                            reflect(-slopes),
                            reflect(terrain.at(beside).1),
                            FlyingBall {
                                state: [place, velocity],
                                ..after
                            },
                        ];
                        for other in others {
                            let is_noticed = !flight.judge(&before, &narrow(&other)).is_allowed();
                            wrong += u32::from(is_noticed);
                        }
                        right += 1;
                    }
                    ball = after;
                }
            }
            assert!(right == hits && hits > 250, "{law:?}: {hits}");
            // A ball that ends within the band of the ground may go on without a reflection.
            assert!(
                100 * wrong >= 98 * 3 * hits,
                "{law:?}: {wrong} of {}",
                3 * hits
            );
        }
    }
}
