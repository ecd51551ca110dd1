// SPDX-License-Identifier: MIT OR Apache-2.0
//! Balls that are reflected at the surface, literally as published and put onto it: how many sink.

use super::{or, table};
use crate::drop::{Arithmetic, Drop};
use crate::integrator::Integrator;

/// Deeper than this a ball has sunk, metres.
const SUNK_M: f64 = 0.5;
/// Balls of a row. The share that sinks is that of 2,000 to within a point.
const BALLS: u32 = 500;

fn reflected(integrator: Integrator, restitution: f64, steps_per_second: u32) -> Drop {
    Drop {
        integrator,
        stiffness: None,
        arithmetic: Arithmetic::F64,
        datum_m: 0.0,
        steps_per_second,
        restitution,
        balls: BALLS,
        seconds: 10,
    }
}

/// Share of the balls that have sunk at the end.
fn sunk_share(drop: &Drop) -> f64 {
    let ends = drop.heights_m().map(|height| drop.run::<false>(height));
    let sunk = ends.filter(|end| end.height_m < -SUNK_M).count();
    sunk as f64 / f64::from(drop.balls)
}

pub(super) fn page() -> String {
    let mut rows = Vec::new();
    for integrator in Integrator::HARD {
        for restitution in [1.0, 0.8, 0.5] {
            for steps in [30, 60, 240] {
                let drop = reflected(integrator, restitution, steps);
                rows.push(vec![
                    integrator.name().to_owned(),
                    restitution.to_string(),
                    steps.to_string(),
                    or(Some(100.0 * sunk_share(&drop)), ""),
                    or(drop.land().energy_change, "all blew up"),
                ]);
            }
        }
    }
    let headings = [
        "integrator",
        "restitution",
        "steps a second",
        "sunk, %",
        "energy change",
    ];
    format!(
        "## Reflection

{BALLS} balls dropped from 1 to 3 m, after 10 s: the share that is deeper than {SUNK_M} m, and energy at the end over that
at the start, less 1. Literal reflection turns the velocity round whenever a ball is below the surface, also where it
moves out already.
{}",
        table(&headings, rows)
    )
}

#[test]
fn literal_reflection_sinks_balls_and_the_guarded_one_none() {
    let sunk = |integrator, steps_per_second| {
        let drop = Drop {
            balls: 2_000,
            arithmetic: Arithmetic::F32,
            ..reflected(integrator, 1.0, steps_per_second)
        };
        sunk_share(&drop)
    };
    let literal = [30, 60, 240].map(|steps| sunk(Integrator::ReflectSymplectic, steps));
    eprintln!("literal, symplectic: {literal:?}");
    assert!((literal[1] - 0.109).abs() < 0.02, "{literal:?}");
    assert!(literal[0] > literal[1] && literal[2] == 0.0);
    // Negative controls: under explicit Euler, and when the ball is put onto the surface, none sinks.
    assert_eq!(sunk(Integrator::ReflectExplicit, 60), 0.0);
    assert_eq!(sunk(Integrator::ReflectGuarded, 60), 0.0);
}
