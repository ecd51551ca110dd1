// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a ball is, in closed form and `f64`: parabolas in flight, a harmonic oscillation in contact.
//!
//! A ball is dropped at rest onto flat ground. While it is below the surface, a spring of stiffness `k`
//! pushes it out: `a = −g − (k/m)·x`. Without a spring it is reflected. Nothing is lost, so that the
//! motion repeats from contact to contact.

/// Acceleration of free fall, m/s²: 9.81 as `f32` has it, so that no arithmetic errs by its rounding.
pub(crate) const GRAVITY: f64 = 9.81_f32 as f64;

/// Height above the ground of a ball dropped from `height_m` at rest, `time_s` later.
///
/// - `stiffness`: k/m, 1/s²; `None` reflects the ball at the surface
pub(crate) fn height_m(height_m: f64, stiffness: Option<f64>, time_s: f64) -> f64 {
    let fall_s = (2.0 * height_m / GRAVITY).sqrt();
    if time_s <= fall_s {
        return height_m - GRAVITY * time_s * time_s / 2.0;
    }
    let speed = GRAVITY * fall_s;
    let flight_s = 2.0 * fall_s;
    let contact = stiffness.map(|stiffness| Contact::new(speed, stiffness));
    let contact_s = contact.as_ref().map_or(0.0, |contact| contact.duration_s);
    let since_s = (time_s - fall_s).rem_euclid(contact_s + flight_s);
    match contact {
        Some(contact) if since_s < contact_s => contact.height_m(since_s),
        _ => {
            let up_s = since_s - contact_s;
            speed * up_s - GRAVITY * up_s * up_s / 2.0
        }
    }
}

/// From entering the ground to leaving it.
struct Contact {
    frequency: f64,
    phase: f64,
    amplitude_m: f64,
    rest_m: f64,
    duration_s: f64,
}

impl Contact {
    fn new(speed: f64, stiffness: f64) -> Self {
        let frequency = stiffness.sqrt();
        let rest_m = -GRAVITY / stiffness;
        // x = rest + R cos(ωt + φ) with x(0) = 0 and x'(0) = −speed.
        let phase = (speed * frequency).atan2(GRAVITY);
        Self {
            frequency,
            phase,
            amplitude_m: rest_m.hypot(speed / frequency),
            rest_m,
            duration_s: 2.0 * (std::f64::consts::PI - phase) / frequency,
        }
    }

    fn height_m(&self, since_s: f64) -> f64 {
        self.rest_m + self.amplitude_m * (self.frequency * since_s + self.phase).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest difference between the second difference quotient and the acceleration, in units of g or
    /// of the spring's largest acceleration.
    fn worst_residual(stiffness: f64, law: f64) -> f64 {
        let step = 1e-5;
        let at = |time| height_m(1.7, Some(stiffness), time);
        let largest = stiffness.sqrt() * 6.0;
        let mut worst: f64 = 0.0;
        for i in 1..40_000 {
            let time = f64::from(i) * 1.1e-4;
            let (before, now, after) = (at(time - step), at(time), at(time + step));
            // A kink of the acceleration inside the quotient belongs to neither side.
            if now.abs() < 1e-3 {
                continue;
            }
            let acceleration = (after - 2.0 * now + before) / (step * step);
            let expected = -GRAVITY - law * now.min(0.0);
            worst = worst.max((acceleration - expected).abs() / largest);
        }
        worst
    }

    #[test]
    fn the_closed_form_obeys_the_law_of_motion() {
        for stiffness in [1e3, 1e5] {
            let residual = worst_residual(stiffness, stiffness);
            assert!(residual < 1e-3, "k/m {stiffness}: {residual}");
            // Negative control: it does not obey that of a spring 1 % stiffer.
            assert!(worst_residual(stiffness, 1.01 * stiffness) > 5e-3);
        }
    }

    #[test]
    fn a_stiff_spring_tends_to_reflection_by_its_contact_time() {
        // After n contacts the ball is late by n·π/ω.
        let late = |stiffness: f64| {
            let soft = height_m(2.0, Some(stiffness), 1.2);
            let hard = height_m(2.0, None, 1.2);
            (soft - hard).abs() * stiffness.sqrt()
        };
        assert!((late(1e7) / late(1e9) - 1.0).abs() < 0.01);
        assert!(late(1e7) > 1.0);
    }
}
