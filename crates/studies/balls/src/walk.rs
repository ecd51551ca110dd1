// SPDX-License-Identifier: MIT OR Apache-2.0
//! Balls over terrain followed step by step, beside `f64`.
//!
//! The ground's slopes jump from cell to cell. A ball that touches the ground within rounding of a border may have a
//! step's push from either side, and leaves otherwise: no arithmetic of `f32` can hold its place to `f64`'s. A thousand
//! balls even begin on vertices, where a first push to the left that `f32` rounds away keeps them in the other cell.
//! So three things are asked. Each step from a state that the device had is that of `f64` to the last
//! places. Whoever is far from `f64` in the end has touched the ground in another cell than `f64` had it
//! in. And `f64` that takes the device's cell near a border, and its own elsewhere, is near every ball.

use crate::on_devices::{STEPS, STEPS_PER_SECOND, STIFFNESS};
use crate::stepping::Steps;
use crate::terrain::{State, Terrain};
use glam::DVec3;
use terrafill_contract::DeviceError;

/// What a place may differ by in one step, metres along an axis: half a last place below 128 m, since balls leave the
/// tile of 64 m, and a sixth as much again for the velocity's rounding.
const ALLOWED_STEP_M: f64 = 4.5e-6;
/// What a velocity may, metres a second. Heights up to 2 m are rounded by 1.2e-7 a few times, which the spring makes
/// 1e-6. Velocities below 4 m/s are rounded by 2.4e-7 thrice. The margin is about 2.
const ALLOWED_STEP_SPEED: f64 = 4e-6;
/// What `f32` may differ from `f64` after all steps, metres. A place between 32 and 64 m is rounded by up to 1.9 µm a
/// step, and in flight at even speed by the same each time: up to 0.46 mm in 240 steps along either axis.
pub(crate) const ALLOWED_M: f64 = 1e-3;
/// Within this of a border a ball may be on either side, metres: the same 0.46 mm.
const BORDER_M: f64 = 5e-4;
/// Balls that are followed at most: evenly spread over all.
const FOLLOWED: usize = 2_000;

/// How far balls were from `f64`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Walk {
    /// Distances from where `f64` takes the same balls, metres.
    pub(crate) max_m: f64,
    pub(crate) rms_m: f64,
    pub(crate) p95_m: f64,
    /// Balls that are farther than is allowed, and those of them that never touched ground in another cell.
    pub(crate) beyond: usize,
    pub(crate) unexplained: usize,
    /// Largest distance from `f64` that takes the device's cell near borders.
    pub(crate) guided_max_m: f64,
    /// Largest difference of one step from the same state, along an axis.
    pub(crate) step_m: f64,
    pub(crate) step_speed: f64,
    pub(crate) followed: usize,
    /// That the CPU wrote for the device meanwhile.
    pub(crate) uploaded: u64,
}

struct Followed {
    /// In the device's list.
    at: usize,
    /// What the device has.
    device: [DVec3; 2],
    own: [DVec3; 2],
    guided: [DVec3; 2],
    has_crossed: bool,
}

fn wide(state: &State) -> [DVec3; 2] {
    [0, 1].map(|part| DVec3::from_slice(&state[part].map(f64::from)))
}

/// What is larger; what is no number stays.
fn most(one: f64, other: f64) -> f64 {
    if one.is_nan() || one > other {
        one
    } else {
        other
    }
}

impl Followed {
    fn new(at: usize, state: &State) -> Self {
        let state = wide(state);
        Self {
            at,
            device: state,
            own: state,
            guided: state,
            has_crossed: false,
        }
    }

    /// Largest differences of the device's step in place and velocity.
    fn follow(&mut self, terrain: &Terrain, after: [DVec3; 2]) -> [f64; 2] {
        let step_s = 1.0 / f64::from(STEPS_PER_SECOND);
        let cell = Terrain::cell_of(self.device[0].truncate());
        let own = Terrain::cell_of(self.own[0].truncate());
        let touches = terrain.touches(own, self.own[0]) || terrain.touches(cell, self.device[0]);
        self.has_crossed |= own != cell && touches;
        let inside = self.guided[0].truncate() - cell;
        let is_near = inside.min_element() >= -BORDER_M && inside.max_element() <= 1.0 + BORDER_M;
        let guided = if is_near {
            cell
        } else {
            Terrain::cell_of(self.guided[0].truncate())
        };
        terrain.step(&mut self.own, step_s, STIFFNESS);
        terrain.step_in(guided, &mut self.guided, step_s, STIFFNESS);
        let mut expected = self.device;
        terrain.step(&mut expected, step_s, STIFFNESS);
        self.device = after;
        [0, 1].map(|part| (expected[part] - after[part]).abs().max_element())
    }
}

/// Takes all steps, one by one, beside `f64`.
///
/// - `first`: what the device has
pub(crate) fn walk(
    steps: &mut dyn Steps,
    terrain: &Terrain,
    first: &[State],
) -> Result<Walk, DeviceError> {
    let stride = first.len().div_ceil(FOLLOWED).max(1);
    let balls = first.iter().enumerate().step_by(stride);
    let mut balls: Vec<Followed> = balls.map(|(at, state)| Followed::new(at, state)).collect();
    let mut walk = Walk {
        followed: balls.len(),
        ..Walk::default()
    };
    for _ in 0..STEPS {
        let before = steps.uploaded();
        steps.step(1)?;
        walk.uploaded += steps.uploaded() - before;
        let states = steps.read()?;
        for ball in &mut balls {
            let nowhere = [DVec3::NAN; 2];
            let after = states.get(ball.at).map_or(nowhere, wide);
            let [place, speed] = ball.follow(terrain, after);
            walk.step_m = most(place, walk.step_m);
            walk.step_speed = most(speed, walk.step_speed);
        }
    }
    let far = |ball: &Followed| ball.own[0].distance(ball.device[0]);
    let mut all: Vec<f64> = balls.iter().map(far).collect();
    // What is no number comes last.
    all.sort_by(f64::total_cmp);
    let count = all.len().max(1) as f64;
    walk.max_m = all.last().copied().unwrap_or(f64::INFINITY);
    walk.rms_m = (all.iter().map(|error| error * error).sum::<f64>() / count).sqrt();
    let p95 = all.get(all.len() * 19 / 20).copied();
    walk.p95_m = p95.unwrap_or(f64::INFINITY);
    for ball in &balls {
        // What is no number is beyond.
        let is_beyond = far(ball).partial_cmp(&ALLOWED_M) != Some(std::cmp::Ordering::Less);
        walk.beyond += usize::from(is_beyond);
        walk.unexplained += usize::from(is_beyond && !ball.has_crossed);
        walk.guided_max_m = most(ball.guided[0].distance(ball.device[0]), walk.guided_max_m);
    }
    Ok(walk)
}

impl Walk {
    /// What is wrong; empty where nothing is.
    pub(crate) fn reason(&self) -> String {
        let holds = |found: f64, allowed: f64| found <= allowed;
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
        } else if self.unexplained > 0 {
            format!(
                "{} balls are farther than {ALLOWED_M} m from f64 and never touched ground in another cell",
                self.unexplained
            )
        } else if !holds(self.guided_max_m, ALLOWED_M) {
            format!(
                "a ball is {} m from f64 in the same cells, allowed {ALLOWED_M} m",
                self.guided_max_m
            )
        } else if self.uploaded > 0 {
            let bytes = self.uploaded;
            format!("{bytes} bytes were uploaded while stepping, allowed 0")
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
        assert_eq!(Walk::default().reason(), "");
        let said = |change: fn(&mut Walk)| {
            let mut wrong = Walk::default();
            change(&mut wrong);
            wrong.reason()
        };
        let wrong = [
            said(|walk| walk.step_m = f64::NAN),
            said(|walk| walk.step_speed = 1e-3),
            said(|walk| walk.unexplained = 1),
            said(|walk| walk.guided_max_m = 2.0 * ALLOWED_M),
        ];
        assert!(
            wrong.iter().all(|said| said.contains("from f64")),
            "{wrong:?}"
        );
        assert!(said(|walk| walk.uploaded = 4).contains("4 bytes"));
    }

    #[test]
    fn a_ball_in_another_cell_is_told_from_one_that_strays() {
        let terrain = Terrain::new();
        let deep = |x: f64| {
            let place = glam::DVec2::new(x, 20.3);
            [place.extend(terrain.at(place).0 - 0.05), DVec3::ZERO]
        };
        let ball = |own: f64, device: f64| Followed {
            at: 0,
            device: deep(device),
            own: deep(own),
            guided: deep(own),
            has_crossed: false,
        };
        let stepped = |x: f64| {
            let mut state = deep(x);
            terrain.step(&mut state, 1.0 / f64::from(STEPS_PER_SECOND), STIFFNESS);
            state
        };
        let mut across = ball(9.999_99, 10.000_01);
        let [place, speed] = across.follow(&terrain, stepped(10.000_01));
        assert!(across.has_crossed && place <= 0.0 && speed <= 0.0);
        // The guided one took the device's push.
        let pushes = [across.own, across.guided, across.device].map(|state| state[1]);
        assert!(
            pushes[1].distance(pushes[2]) < 0.1 * pushes[0].distance(pushes[2]),
            "{pushes:?}"
        );
        let mut same = ball(10.4, 10.400_01);
        same.follow(&terrain, stepped(10.400_01));
        assert!(!same.has_crossed);
        // Negative control: a step that the device did not take.
        let [_, speed] = ball(10.4, 10.4).follow(&terrain, deep(10.4));
        assert!(speed > ALLOWED_STEP_SPEED);
    }
}
