// SPDX-License-Identifier: MIT OR Apache-2.0
//! Energy that one contact gains or loses by its integrator, without gravity.
//!
//! It depends on `ω·dt` and on where in a step the ball enters the ground, on nothing else.

use super::{or, table};
use crate::integrator::{Ball, Forces, Integrator, step};

/// Places in a step at which balls enter.
const PHASES: u32 = 1_000;
/// Half periods after which a ball that is still in contact is taken to stay.
const MAX_HALF_PERIODS: f64 = 100.0;

/// `ω·dt` of the rows. 1 is a resonance of the step with the half period, at which symplectic Euler has
/// no error: it says nothing of its neighbours.
const STEPS: [f64; 9] = [0.05, 0.1, 0.2, 0.5, 1.0, 1.5, 1.9, 2.5, 5.0];

/// Energy after a contact over that before it, over all phases.
#[derive(Debug, Clone, Copy)]
struct EnergyRatio {
    mean: f64,
    largest: f64,
    /// Root mean square of the ratio less 1.
    rms_change: f64,
    /// Share of the phases after which the ball never left.
    stayed_share: f64,
}

/// Sends balls of unit speed into a spring of unit frequency.
fn energy_ratio(integrator: Integrator, step_length: f64) -> Option<EnergyRatio> {
    let forces = Forces {
        gravity: 0.0,
        stiffness: 1.0,
        damping: 0.0,
        restitution: 1.0,
        datum: 0.0,
    };
    let mut ratios = Vec::new();
    for phase in 0..PHASES {
        let above = step_length * (f64::from(phase) + 0.5) / f64::from(PHASES);
        let mut ball = Ball {
            height: above,
            speed: -1.0_f64,
        };
        let mut time = 0.0;
        while time < MAX_HALF_PERIODS * std::f64::consts::PI {
            step(integrator, &forces, &mut ball, step_length);
            time += step_length;
            if ball.height > 0.0 && ball.speed > 0.0 {
                ratios.push(ball.speed * ball.speed);
                break;
            }
        }
    }
    if ratios.is_empty() {
        return None;
    }
    let count = ratios.len() as f64;
    let squares: f64 = ratios.iter().map(|ratio| (ratio - 1.0).powi(2)).sum();
    Some(EnergyRatio {
        mean: ratios.iter().sum::<f64>() / count,
        largest: ratios.iter().copied().fold(0.0, f64::max),
        rms_change: (squares / count).sqrt(),
        stayed_share: 1.0 - count / f64::from(PHASES),
    })
}

/// Largest ratio of symplectic Euler and velocity Verlet by formula, from `ω·dt = √3` on.
fn worst_symplectic(step_length: f64) -> f64 {
    (step_length * step_length - 1.0).powi(2)
}

pub(super) fn page() -> String {
    let rows = Integrator::SPRING.into_iter().flat_map(|integrator| {
        STEPS.map(|length| {
            let ratio = energy_ratio(integrator, length);
            let of = |figure: fn(EnergyRatio) -> f64| or(ratio.map(figure), "no ball left");
            vec![
                integrator.name().to_owned(),
                length.to_string(),
                of(|ratio| ratio.mean),
                of(|ratio| ratio.largest),
                of(|ratio| ratio.rms_change),
                or(Some(ratio.map_or(1.0, |ratio| ratio.stayed_share)), ""),
            ]
        })
    });
    let headings = [
        "integrator",
        "ω·dt",
        "mean",
        "largest",
        "change, rms",
        "share that stayed",
    ];
    format!(
        "## Energy of one contact

Energy after a contact over that before it, over {PHASES} places in a step at which it begins. A contact that has not
ended after {MAX_HALF_PERIODS} half periods is taken to stay. Explicit Euler gains energy at every step. Symplectic Euler
at ω·dt = 1.9, inside its limit, multiplies it by up to {}.
{}",
        or(Some(worst_symplectic(1.9)), ""),
        table(&headings, rows)
    )
}

fn ratio(integrator: Integrator, step_length: f64) -> EnergyRatio {
    energy_ratio(integrator, step_length).expect("balls leave")
}

#[test]
fn a_stable_step_may_still_multiply_energy() {
    for step_length in [1.9, 2.5, 5.0] {
        let expected = worst_symplectic(step_length);
        for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
            let found = ratio(integrator, step_length).largest;
            eprintln!(
                "{} {step_length}: {found:.3}, {expected:.3}",
                integrator.name()
            );
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
        }
    }
    // Negative control: a tenth of the limit keeps it to 1 %.
    assert!(ratio(Integrator::SymplecticEuler, 0.2).largest < 1.01);
}

#[test]
fn explicit_euler_gains_and_implicit_euler_loses_at_every_step() {
    for step_length in STEPS {
        let gain = ratio(Integrator::ExplicitEuler, step_length).mean;
        let loss = ratio(Integrator::ImplicitEuler, step_length).mean;
        eprintln!("{step_length}: {gain:.3} {loss:.3}");
        assert!(gain > 1.0 && loss < 1.0, "{step_length}: {gain} {loss}");
        if step_length <= 0.1 {
            let law = (std::f64::consts::PI * step_length).exp();
            assert!((gain / law - 1.0).abs() < 0.02, "{gain} {law}");
            assert!((loss * law - 1.0).abs() < 0.02, "{loss} {law}");
        }
    }
    // Negative control: one that is stable does neither.
    assert!((ratio(Integrator::SymplecticEuler, 0.1).mean - 1.0).abs() < 1e-3);
}
