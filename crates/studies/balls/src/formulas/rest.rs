// SPDX-License-Identifier: MIT OR Apache-2.0
//! A ball at rest on a damped spring, by a state that holds its height above the ellipsoid or above the ground.

use super::{or, table};
use crate::arithmetic::{Compensated, Real, Sum};
use crate::closed_form::GRAVITY;
use crate::drop::{Arithmetic, GROUND_M};
use crate::integrator::{Ball, Forces, Integrator, step};

/// Damping ratio.
const REST_DAMPING: f64 = 0.2;
/// ω·dt.
const REST_STEP: f64 = 0.2;
/// Steps until nothing but rounding moves it, and as many over which the largest speed is taken.
const REST_STEPS: u32 = 2_000;

/// Where a ball comes to rest, by a state that holds its height above `datum_m`.
#[derive(Debug, Clone, Copy)]
struct Rest {
    stiffness: f64,
    arithmetic: Arithmetic,
    datum_m: f64,
}

/// How a ball rests.
#[derive(Debug, Clone, Copy)]
struct Rested {
    /// Largest difference from the depth `g/ω²`.
    gap_error_m: f64,
    /// Largest speed, which should be 0, m/s.
    speed: f64,
}

impl Rest {
    /// Lets it settle under symplectic Euler, from its depth at rest.
    fn settle(self) -> Rested {
        match self.arithmetic {
            Arithmetic::F64 => self.settle_in::<f64, f64>(),
            Arithmetic::F32 => self.settle_in::<f32, f32>(),
            Arithmetic::CompensatedF32 => self.settle_in::<f32, Compensated<f32>>(),
        }
    }

    fn settle_in<R: Real, S: Sum<R>>(self) -> Rested {
        let frequency = self.stiffness.sqrt();
        let forces = Forces {
            gravity: R::of(GRAVITY),
            stiffness: R::of(self.stiffness),
            damping: R::of(2.0 * REST_DAMPING * frequency),
            restitution: R::of(0.0),
            datum: R::of(self.datum_m),
        };
        let rest_m = -GRAVITY / self.stiffness;
        let mut ball = Ball {
            height: S::start(forces.datum),
            speed: S::start(R::of(0.0)),
        };
        ball.height.add(R::of(rest_m));
        let dt = R::of(REST_STEP / frequency);
        let mut rested = Rested {
            gap_error_m: 0.0,
            speed: 0.0,
        };
        for i in 0..2 * REST_STEPS {
            step(Integrator::SymplecticEuler, &forces, &mut ball, dt);
            if i >= REST_STEPS {
                let gap = ball.height.total() - forces.datum.as_f64();
                rested.gap_error_m = rested.gap_error_m.max((gap - rest_m).abs());
                rested.speed = rested.speed.max(ball.speed.total().abs());
            }
        }
        rested
    }
}

pub(super) fn page() -> String {
    let mut rows = Vec::new();
    for stiffness in [1e3, 1e5, 1e7] {
        for arithmetic in Arithmetic::ALL {
            for datum_m in [0.0, 10.0, 100.0, GROUND_M, 8_000.0] {
                let rest = Rest {
                    stiffness,
                    arithmetic,
                    datum_m,
                };
                let rested = rest.settle();
                rows.push(vec![
                    format!("{stiffness:e}"),
                    arithmetic.name().to_owned(),
                    datum_m.to_string(),
                    or(Some(rested.gap_error_m), ""),
                    or(Some(rested.speed), ""),
                ]);
            }
        }
    }
    let headings = [
        "stiffness, 1/s²",
        "arithmetic",
        "height of the ground, m",
        "gap, m",
        "speed, m/s",
    ];
    format!(
        "## A ball at rest

Under symplectic Euler, by the height of the ground that its stored height includes: the largest difference from its
depth g/ω², and its largest speed, which should be 0.
{}",
        table(&headings, rows)
    )
}

#[test]
fn height_above_the_ellipsoid_is_no_state_for_a_stiff_contact() {
    let rest = |arithmetic, datum_m| Rest {
        stiffness: 1e7,
        arithmetic,
        datum_m,
    };
    let high = rest(Arithmetic::F32, GROUND_M).settle();
    let gap = rest(Arithmetic::F32, 0.0).settle();
    eprintln!("{high:?} {gap:?}");
    assert!(
        high.gap_error_m > 10.0 * GRAVITY / 1e7 && high.speed > 0.1,
        "{high:?}"
    );
    // Negative controls: the gap as state is right, and so is a height that keeps what it rounds off.
    let compensated = rest(Arithmetic::CompensatedF32, GROUND_M).settle();
    for rested in [gap, compensated] {
        assert!(rested.gap_error_m < 1e-3 * GRAVITY / 1e7, "{rested:?}");
    }
}
