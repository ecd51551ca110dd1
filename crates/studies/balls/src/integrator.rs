// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ways to take a ball one time step further, in any arithmetic.

use crate::arithmetic::{Real, Sum};

/// Splits of one step at the surface. A ball that crosses it more often has a contact far shorter than
/// the step, which no split makes right.
const MAX_SPLITS: u32 = 8;

terrafill_results::named! {
    /// A way to take a ball one step further.
    #[derive(Hash, PartialOrd, Ord)]
    pub(crate) enum Integrator {
        ExplicitEuler = "explicit-euler",
        SymplecticEuler = "symplectic-euler",
        VelocityVerlet = "velocity-verlet",
        /// Velocity Verlet, the step cut where the ball crosses the surface.
        SplitVerlet = "split-verlet",
        Rk4 = "rk4",
        ImplicitEuler = "implicit-euler",
        ImplicitMidpoint = "implicit-midpoint",
        /// Explicit Euler; the velocity is turned round whenever the ball is below the surface.
        ReflectExplicit = "reflect-explicit",
        /// Symplectic Euler, else the same.
        ReflectSymplectic = "reflect-symplectic",
        /// The same, if the ball moves downwards only, and put onto the surface.
        ReflectGuarded = "reflect-guarded",
        /// The step cut at the time at which the parabola meets the surface.
        ExactEvent = "exact-event",
    }
}

impl Integrator {
    /// Those for a spring.
    pub(crate) const SPRING: [Self; 7] = [
        Self::ExplicitEuler,
        Self::SymplecticEuler,
        Self::VelocityVerlet,
        Self::SplitVerlet,
        Self::Rk4,
        Self::ImplicitEuler,
        Self::ImplicitMidpoint,
    ];
    /// Those that reflect.
    pub(crate) const HARD: [Self; 4] = [
        Self::ReflectExplicit,
        Self::ReflectSymplectic,
        Self::ReflectGuarded,
        Self::ExactEvent,
    ];

    /// Power of the step by which the error falls once contact is resolved; the kink of the force at the
    /// surface caps RK4 at 2. `None`: exact but for rounding.
    pub(crate) fn order(self) -> Option<f64> {
        match self {
            Self::ExplicitEuler
            | Self::SymplecticEuler
            | Self::ImplicitEuler
            | Self::ReflectExplicit
            | Self::ReflectSymplectic
            | Self::ReflectGuarded => Some(1.0),
            Self::VelocityVerlet | Self::SplitVerlet | Self::Rk4 | Self::ImplicitMidpoint => {
                Some(2.0)
            }
            Self::ExactEvent => None,
        }
    }
}

/// What acts on a ball.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Forces<R> {
    pub(crate) gravity: R,
    /// k/m of the spring below the surface; without meaning where balls are reflected.
    pub(crate) stiffness: R,
    /// Drag below the surface over mass, 1/s.
    pub(crate) damping: R,
    /// Share of the speed that a reflection leaves.
    pub(crate) restitution: R,
    /// The surface, in the units that heights are stored in.
    pub(crate) datum: R,
}

impl<R: Real> Forces<R> {
    fn acceleration(&self, gap: R, speed: R) -> R {
        if gap < R::of(0.0) {
            -self.gravity - self.stiffness * gap - self.damping * speed
        } else {
            -self.gravity
        }
    }
}

/// Where a ball is and how fast it moves upwards.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ball<S> {
    /// Above [`Forces::datum`]'s zero.
    pub(crate) height: S,
    pub(crate) speed: S,
}

/// Takes `ball` a step of `dt` further.
#[inline]
pub(crate) fn step<R: Real, S: Sum<R>>(
    integrator: Integrator,
    forces: &Forces<R>,
    ball: &mut Ball<S>,
    dt: R,
) {
    let zero = R::of(0.0);
    let half = R::of(0.5);
    let gap = ball.height.minus(forces.datum);
    let speed = ball.speed.minus(zero);
    match integrator {
        Integrator::ExplicitEuler | Integrator::ReflectExplicit => {
            let acceleration = match integrator {
                Integrator::ExplicitEuler => forces.acceleration(gap, speed),
                _ => -forces.gravity,
            };
            ball.height.add(dt * speed);
            ball.speed.add(dt * acceleration);
            if integrator == Integrator::ReflectExplicit {
                reflect(forces, ball);
            }
        }
        Integrator::SymplecticEuler => {
            ball.speed.add(dt * forces.acceleration(gap, speed));
            ball.height.add(dt * ball.speed.minus(zero));
        }
        Integrator::ReflectSymplectic | Integrator::ReflectGuarded => {
            ball.speed.add(-(dt * forces.gravity));
            ball.height.add(dt * ball.speed.minus(zero));
            if integrator == Integrator::ReflectSymplectic {
                reflect(forces, ball);
            } else if ball.height.minus(forces.datum) < zero && ball.speed.minus(zero) < zero {
                reflect(forces, ball);
                ball.height = S::start(forces.datum);
            }
        }
        Integrator::VelocityVerlet => {
            let before = forces.acceleration(gap, speed);
            ball.height.add(dt * (speed + half * dt * before));
            let after = forces.acceleration(ball.height.minus(forces.datum), speed);
            ball.speed.add(half * dt * (before + after));
        }
        Integrator::SplitVerlet => split_verlet(forces, ball, dt),
        Integrator::Rk4 => {
            let at = |gap: R, speed: R| (speed, forces.acceleration(gap, speed));
            let (v1, a1) = at(gap, speed);
            let (v2, a2) = at(gap + half * dt * v1, speed + half * dt * a1);
            let (v3, a3) = at(gap + half * dt * v2, speed + half * dt * a2);
            let (v4, a4) = at(gap + dt * v3, speed + dt * a3);
            let (two, sixth) = (R::of(2.0), dt / R::of(6.0));
            ball.height.add(sixth * (v1 + two * (v2 + v3) + v4));
            ball.speed.add(sixth * (a1 + two * (a2 + a3) + a4));
        }
        Integrator::ImplicitEuler => {
            // The force at the end is linear on either side: solved there, no iteration.
            let free = -(dt * forces.gravity);
            let change = if gap + dt * (speed + free) < zero {
                let stiff = dt * forces.stiffness;
                (free - stiff * (gap + dt * speed)) / (R::of(1.0) + dt * stiff)
            } else {
                free
            };
            ball.speed.add(change);
            ball.height.add(dt * ball.speed.minus(zero));
        }
        Integrator::ImplicitMidpoint => {
            let free = -(half * dt * forces.gravity);
            // Change of speed up to the middle of the step.
            let change = if gap + half * dt * (speed + free) < zero {
                let stiff = half * dt * forces.stiffness;
                (free - stiff * (gap + half * dt * speed)) / (R::of(1.0) + half * dt * stiff)
            } else {
                free
            };
            ball.height.add(dt * (speed + change));
            ball.speed.add(R::of(2.0) * change);
        }
        Integrator::ExactEvent => exact_event(forces, ball, dt),
    }
}

/// As published: turned round whenever it is below, also if it moves out already.
fn reflect<R: Real, S: Sum<R>>(forces: &Forces<R>, ball: &mut Ball<S>) {
    if ball.height.minus(forces.datum) < R::of(0.0) {
        ball.speed = S::start(-(forces.restitution * ball.speed.minus(R::of(0.0))));
    }
}

/// When a ball `gap` above the surface meets it in free fall, by the root without cancellation.
fn fall_time<R: Real>(gravity: R, gap: R, speed: R) -> R {
    let at_surface = (speed * speed + R::of(2.0) * gravity * gap).sqrt();
    if speed > R::of(0.0) {
        (speed + at_surface) / gravity
    } else {
        R::of(2.0) * gap / (at_surface - speed)
    }
}

fn exact_event<R: Real, S: Sum<R>>(forces: &Forces<R>, ball: &mut Ball<S>, dt: R) {
    let (zero, half) = (R::of(0.0), R::of(0.5));
    let mut left = dt;
    for _ in 0..MAX_SPLITS {
        let (gap, speed) = (ball.height.minus(forces.datum), ball.speed.minus(zero));
        let next = gap + left * (speed - half * forces.gravity * left);
        if next >= zero {
            break;
        }
        let fall = fall_time(forces.gravity, gap, speed);
        let at_surface = (speed * speed + R::of(2.0) * forces.gravity * gap).sqrt();
        ball.height = S::start(forces.datum);
        ball.speed = S::start(forces.restitution * at_surface);
        left = left - fall;
    }
    let speed = ball.speed.minus(zero);
    ball.height
        .add(left * (speed - half * forces.gravity * left));
    ball.speed.add(-(forces.gravity * left));
}

fn split_verlet<R: Real, S: Sum<R>>(forces: &Forces<R>, ball: &mut Ball<S>, dt: R) {
    let (zero, half, two) = (R::of(0.0), R::of(0.5), R::of(2.0));
    let mut left = dt;
    for _ in 0..MAX_SPLITS {
        let (gap, speed) = (ball.height.minus(forces.datum), ball.speed.minus(zero));
        let is_below = gap < zero || (gap == zero && speed < zero);
        let before = forces.acceleration(gap, speed);
        let next = gap + left * (speed + half * left * before);
        if (next < zero) == is_below {
            ball.height.add(left * (speed + half * left * before));
            let after = if is_below {
                forces.acceleration(ball.height.minus(forces.datum), speed)
            } else {
                -forces.gravity
            };
            ball.speed.add(half * left * (before + after));
            return;
        }
        let crossing = if !is_below {
            fall_time(forces.gravity, gap, speed)
        } else {
            let root = (speed * speed - two * before * gap).sqrt();
            if speed > zero {
                -(two * gap) / (speed + root)
            } else {
                (root - speed) / before
            }
        };
        // The force is that of free fall at the surface, from either side.
        ball.height = S::start(forces.datum);
        ball.speed.add(half * crossing * (before - forces.gravity));
        left = left - crossing;
        if left <= zero {
            return;
        }
    }
}
