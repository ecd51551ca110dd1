// SPDX-License-Identifier: MIT OR Apache-2.0
//! Many balls dropped at rest, in one arithmetic and state, against the closed form.

use crate::arithmetic::{Compensated, Real, Sum};
use crate::closed_form::{GRAVITY, height_m};
use crate::integrator::{Ball, Forces, Integrator, step};

/// A ball is blown up above this height or below this depth, metres …
const BLOWN_M: f64 = 1e3;
/// … or with this many times the energy it began with.
const BLOWN_ENERGY: f64 = 10.0;
/// A run is blown up where more than this share of its balls is.
pub(crate) const MOSTLY: f64 = 0.5;
/// Steps of a contact's `ω·dt` up to which every integrator but the explicit one keeps its balls.
const STEADY: f64 = 0.5;
/// Steps of a timed sample at most, or those of one ball: they take milliseconds, a thousand times what a clock resolves.
const TIMED_STEPS: u32 = 1 << 20;
/// Height of the ground above the ellipsoid where heights are above the ellipsoid, metres.
pub(crate) const GROUND_M: f64 = 1_000.0;

terrafill_results::named! {
    /// Numbers of a ball's state.
    #[derive(PartialOrd, Ord)]
    all pub(crate) enum Arithmetic {
        F64 = "f64",
        F32 = "f32",
        /// `f32` with what sums round off kept in a second one.
        CompensatedF32 = "compensated-f32",
    }
}

/// An experiment with many balls.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drop {
    pub(crate) integrator: Integrator,
    /// k/m, 1/s²; `None` reflects.
    pub(crate) stiffness: Option<f64>,
    pub(crate) arithmetic: Arithmetic,
    /// Height of the ground that a ball's stored height includes: 0 where the gap is stored.
    pub(crate) datum_m: f64,
    pub(crate) steps_per_second: u32,
    /// Share of the speed that a reflection leaves.
    pub(crate) restitution: f64,
    pub(crate) balls: u32,
    pub(crate) seconds: u32,
}

/// What became of the balls.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Landed {
    /// Root mean square error of height over balls that did not blow up; `None` if all did.
    pub(crate) rms_m: Option<f64>,
    pub(crate) blown_share: f64,
    /// Mean of energy at the end over energy at the start, less 1, of balls that did not blow up.
    pub(crate) energy_change: Option<f64>,
    pub(crate) deepest_m: f64,
}

/// How one ball ended.
pub(crate) struct End {
    pub(crate) height_m: f64,
    energy: f64,
    is_blown: bool,
    deepest_m: f64,
}

impl Drop {
    /// Heights at which balls are dropped: evenly from 1 to 3 m.
    pub(crate) fn heights_m(self) -> impl Iterator<Item = f64> {
        (0..self.balls).map(move |i| 1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(self.balls))
    }

    /// Whether it is expected that balls blow up: by an integrator that gains energy at every step, or in steps
    /// as long as a contact.
    pub(crate) fn may_blow_up(&self) -> bool {
        let frequency = self.stiffness.unwrap_or(0.0).sqrt();
        self.integrator == Integrator::ExplicitEuler
            || frequency / f64::from(self.steps_per_second) > STEADY
    }

    /// Runs all balls and compares them with the closed form.
    pub(crate) fn land(&self) -> Landed {
        let (mut squares, mut blown) = (0.0, 0_u32);
        let (mut energy_changes, mut kept, mut deepest_m) = (0.0, 0_u32, 0.0_f64);
        for height in self.heights_m() {
            let end = self.run::<true>(height);
            if end.is_blown {
                blown += 1;
                continue;
            }
            let exact_m = height_m(height, self.stiffness, f64::from(self.seconds));
            squares += (end.height_m - exact_m).powi(2);
            deepest_m = deepest_m.max(end.deepest_m);
            energy_changes += end.energy / (GRAVITY * height) - 1.0;
            kept += 1;
        }
        let mean = |sum: f64| (kept > 0).then(|| sum / f64::from(kept));
        Landed {
            rms_m: mean(squares).map(f64::sqrt),
            blown_share: f64::from(blown) / f64::from(self.balls),
            energy_change: mean(energy_changes),
            deepest_m,
        }
    }

    /// The same with as many balls as take [`TIMED_STEPS`] together: of more, each second of a ball takes as long.
    pub(crate) fn timed(&self) -> Self {
        let steps = self.seconds * self.steps_per_second;
        Self {
            balls: self.balls.min((TIMED_STEPS / steps).max(1)),
            ..*self
        }
    }

    /// Runs all balls without looking at them; returns the sum of their last heights, so that no run is
    /// left out.
    pub(crate) fn work(&self) -> f64 {
        let ends = self.heights_m().map(|height| self.run::<false>(height));
        ends.map(|end| end.height_m).sum()
    }

    pub(crate) fn run<const WATCHED: bool>(&self, height: f64) -> End {
        match self.arithmetic {
            Arithmetic::F64 => self.run_in::<f64, f64, WATCHED>(height),
            Arithmetic::F32 => self.run_in::<f32, f32, WATCHED>(height),
            Arithmetic::CompensatedF32 => self.run_in::<f32, Compensated<f32>, WATCHED>(height),
        }
    }

    /// - `WATCHED`: looks at height and energy after every step
    fn run_in<R: Real, S: Sum<R>, const WATCHED: bool>(&self, height: f64) -> End {
        let forces = Forces {
            gravity: R::of(GRAVITY),
            stiffness: R::of(self.stiffness.unwrap_or(0.0)),
            damping: R::of(0.0),
            restitution: R::of(self.restitution),
            datum: R::of(self.datum_m),
        };
        let mut ball = Ball {
            height: S::start(forces.datum),
            speed: S::start(R::of(0.0)),
        };
        ball.height.add(R::of(height));
        let dt = R::of(1.0 / f64::from(self.steps_per_second));
        let first_energy = GRAVITY * height;
        let stiffness = self.stiffness.unwrap_or(0.0);
        let (mut is_blown, mut deepest_m) = (false, 0.0_f64);
        for _ in 0..self.seconds * self.steps_per_second {
            step(self.integrator, &forces, &mut ball, dt);
            if WATCHED {
                let (gap, energy) = energy(&ball, &forces, stiffness);
                deepest_m = deepest_m.max(-gap);
                // Not below the limits: what is no number is blown up too.
                let is_sound = gap.abs() <= BLOWN_M && energy <= BLOWN_ENERGY * first_energy;
                is_blown |= !is_sound;
                if is_blown {
                    break;
                }
            }
        }
        let (height_m, energy) = energy(&ball, &forces, stiffness);
        End {
            height_m,
            energy,
            is_blown,
            deepest_m,
        }
    }
}

/// Gap and energy over mass, with the ground's height as zero.
fn energy<R: Real, S: Sum<R>>(ball: &Ball<S>, forces: &Forces<R>, stiffness: f64) -> (f64, f64) {
    let gap = ball.height.total() - forces.datum.as_f64();
    let speed = ball.speed.total();
    let spring = stiffness * gap.min(0.0).powi(2);
    (gap, GRAVITY * gap + (speed * speed + spring) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(integrator: Integrator, stiffness: Option<f64>, arithmetic: Arithmetic) -> Drop {
        Drop {
            integrator,
            stiffness,
            arithmetic,
            datum_m: 0.0,
            steps_per_second: 480,
            restitution: 1.0,
            balls: 64,
            seconds: 5,
        }
    }

    fn rms(drop: Drop, steps_per_second: u32) -> f64 {
        let drop = Drop {
            steps_per_second,
            ..drop
        };
        drop.land().rms_m.unwrap_or(f64::INFINITY)
    }

    /// From 1/480 to 1/7680 s: 16 times.
    fn order(drop: Drop) -> f64 {
        (rms(drop, 480) / rms(drop, 7_680)).ln() / 16.0_f64.ln()
    }

    #[test]
    fn the_error_falls_by_the_order_once_contact_is_resolved() {
        for integrator in [
            Integrator::SymplecticEuler,
            Integrator::VelocityVerlet,
            Integrator::SplitVerlet,
            Integrator::Rk4,
            Integrator::ImplicitMidpoint,
        ] {
            let order = order(of(integrator, Some(1e3), Arithmetic::F64));
            eprintln!("{}: {order:.3}", integrator.name());
            let expected = integrator.order().expect("has one");
            assert!((order - expected).abs() < 0.25, "{integrator:?}: {order}");
        }
        // Negative control: RK4 has order 4 where the force has no kink, and in f32 there is none at all.
        let flat = order(of(Integrator::Rk4, Some(1e3), Arithmetic::F32));
        assert!(flat < 1.0, "{flat}");
    }

    #[test]
    fn the_kink_and_nothing_else_caps_rk4() {
        // One oscillation that stays below the surface: the force is smooth.
        let error = |steps: u32| {
            let forces = Forces {
                gravity: 0.0,
                stiffness: 1e3,
                damping: 0.0,
                restitution: 0.0,
                datum: 0.0,
            };
            let frequency = 1e3_f64.sqrt();
            let mut ball = Ball {
                height: -0.1_f64,
                speed: 0.0_f64,
            };
            let dt = 1.0 / frequency / f64::from(steps);
            for _ in 0..steps {
                step(Integrator::Rk4, &forces, &mut ball, dt);
            }
            (ball.height + 0.1 * 1.0_f64.cos()).abs()
        };
        let order = (error(8) / error(32)).ln() / 4.0_f64.ln();
        eprintln!("rk4 without a kink: {order:.3}");
        assert!((order - 4.0).abs() < 0.1, "{order}");
    }

    #[test]
    fn splitting_at_contact_pays() {
        let drop = |integrator| of(integrator, Some(1e3), Arithmetic::F64);
        let whole = rms(drop(Integrator::VelocityVerlet), 1_920);
        let split = rms(drop(Integrator::SplitVerlet), 1_920);
        eprintln!("whole {whole:.2e}, split {split:.2e}");
        assert!(whole / split > 10.0, "{whole} {split}");
    }

    #[test]
    fn f32_stops_following_f64_and_compensated_sums_go_on() {
        let error = |arithmetic| {
            let drop = of(Integrator::VelocityVerlet, Some(1e3), arithmetic);
            rms(Drop { balls: 16, ..drop }, 7_680)
        };
        let double = error(Arithmetic::F64);
        // Negative control: what plain sums lose is far above the tolerance of compensated ones.
        let plain = error(Arithmetic::F32);
        assert!(plain > 5.0 * double, "{plain} {double}");
        let compensated = error(Arithmetic::CompensatedF32);
        assert!(
            (compensated / double - 1.0).abs() < 0.2,
            "{compensated} {double}"
        );
    }

    #[test]
    fn the_error_of_f32_is_least_at_a_step_of_1_1920_s() {
        let bottom = |arithmetic| {
            let drop = Drop {
                balls: 16,
                ..of(Integrator::SplitVerlet, Some(1e3), arithmetic)
            };
            let errors = [480, 1_920, 7_680].map(|steps| (steps, rms(drop, steps)));
            let least = errors.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            least.expect("three").0
        };
        assert_eq!(bottom(Arithmetic::F32), 1_920);
        // Negative control: in f64 the finest step is the best.
        assert_eq!(bottom(Arithmetic::F64), 7_680);
    }

    #[test]
    fn exact_events_in_compensated_sums_are_right_to_micrometres_at_every_step() {
        let drop = |arithmetic| of(Integrator::ExactEvent, None, arithmetic);
        for steps in [30, 120, 480, 1_920, 7_680, 30_720] {
            let error = |arithmetic| {
                let drop = Drop {
                    balls: 32,
                    ..drop(arithmetic)
                };
                rms(drop, steps)
            };
            let compensated = error(Arithmetic::CompensatedF32);
            let (plain, double) = (error(Arithmetic::F32), error(Arithmetic::F64));
            eprintln!("1/{steps}: {compensated:.2e}, f32 {plain:.2e}, f64 {double:.2e}");
            assert!(compensated <= 2e-6, "1/{steps}: {compensated}");
            assert!(double < 1e-10, "1/{steps}: {double}");
        }
        // Negative control: without compensation it is not.
        assert!(rms(drop(Arithmetic::F32), 7_680) > 1e-4);
    }

    #[test]
    fn what_is_timed_has_enough_steps_and_balls_of_all_heights() {
        let drop = |steps_per_second| Drop {
            steps_per_second,
            ..of(Integrator::Rk4, Some(1e3), Arithmetic::F32)
        };
        let balls = [30, 7_680, 30_720].map(|steps| drop(steps).timed().balls);
        assert_eq!(balls, [64, 27, 6]);
        // From near the least height to near the greatest.
        let heights: Vec<f64> = drop(30_720).timed().heights_m().collect();
        assert!(heights[0] < 1.2 && heights[5] > 2.8, "{heights:?}");
        // Negative control: a ball alone takes more steps than that.
        assert_eq!(drop(u32::MAX / 5).timed().balls, 1);
    }

    #[test]
    fn a_run_that_is_watched_ends_where_one_that_is_timed_does() {
        let drop = of(Integrator::Rk4, Some(1e3), Arithmetic::F32);
        let watched: f64 = drop
            .heights_m()
            .map(|height| drop.run::<true>(height).height_m)
            .sum();
        assert_eq!(watched.to_bits(), drop.work().to_bits());
        let other = Drop { balls: 63, ..drop };
        assert_ne!(watched.to_bits(), other.work().to_bits());
    }
}
