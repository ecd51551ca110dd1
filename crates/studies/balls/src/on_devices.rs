// SPDX-License-Identifier: MIT OR Apache-2.0
//! Balls stepped on devices, nothing drawn, against the same integrator in `f64`.

use crate::STUDY;
use crate::arithmetic::Real as _;
use crate::closed_form::GRAVITY;
use crate::flight::{CRATER_DEPTH, CRATER_S, Law};
use crate::integrator::{Ball, Forces, Integrator, step};
use crate::metrics::{BALLS, INTERFACE, PART, WAY};
use crate::stepping::Stepping;
use crate::steps::{BallConstants, Steps};
use crate::terrain::{BLOCKS, CELL_M, CELLS, State};
use terrafill_contract::{CpuStopwatch, DeviceError};
use terrafill_results::{ConditionKey, Verdict};
use terrafill_study::{Context, Failure, Figures, Group, Trial, judged, trials};

pub(crate) const STIFFNESS: f64 = 1e3;
pub(crate) const STEPS_PER_SECOND: u32 = 480;
/// Half a second: every ball meets the ground.
pub(crate) const STEPS: u32 = 240;
/// What `f32` may differ from `f64`, metres. 240 roundings by half a last place of 0.3 m add up to 3.6 µm: a
/// margin of about 3.
const ALLOWED_M: f64 = 1e-5;
/// Balls compared with `f64` at most: evenly spread over all.
const JUDGED: usize = 10_000;
/// Steps of a submission, which a timed sample is: a frame.
pub(crate) const TIMED: u32 = 4;

/// Numbers of balls that are stepped, and drawn.
pub(crate) fn counts(is_quick: bool) -> &'static [u32] {
    if is_quick {
        &[500, 4_000]
    } else {
        &[
            500, 1_000, 2_000, 3_000, 4_000, 5_000, 10_000, 100_000, 1_000_000,
        ]
    }
}

/// Balls on devices.
pub(crate) fn group(counts: &[u32], samples: u32) -> impl Group + use<> {
    let stepped = Stepping::ALL.into_iter().flat_map(move |way| {
        let of = move |&balls: &u32| Stepped { way, balls };
        counts.iter().map(of)
    });
    trials(STUDY, format!("{STUDY}/device"), samples, stepped.collect())
}

/// So many balls, stepped in a way.
struct Stepped {
    way: Stepping,
    balls: u32,
}

/// Dropped at rest from 0.1 to 0.3 m.
fn balls(count: u32) -> Vec<State> {
    let height = |i: u32| 0.1 + 0.2 * (f64::from(i) + 0.5) / f64::from(count);
    // The device's first state is the nearest f32, and the reference begins there.
    let ball = |i| [[0.0, 0.0, f32::of(height(i)), 1.0], [0.0; 4]];
    (0..count).map(ball).collect()
}

pub(crate) fn constants(count: u32) -> BallConstants {
    BallConstants {
        step_s: f32::of(1.0 / f64::from(STEPS_PER_SECOND)),
        gravity: f32::of(GRAVITY),
        stiffness: f32::of(STIFFNESS),
        count,
        cells: CELLS,
        cell_m: f32::of(CELL_M),
        blocks: BLOCKS,
        law: Law::Published.number(),
        restitution: 0.0,
        crater_s: f32::of(CRATER_S),
        crater_depth: f32::of(CRATER_DEPTH),
        padding: 0,
    }
}

/// Height of a ball after all steps.
fn height_m(integrator: Integrator, first_m: f64) -> f64 {
    let forces = Forces {
        gravity: GRAVITY,
        stiffness: STIFFNESS,
        damping: 0.0,
        restitution: 1.0,
        datum: 0.0,
    };
    let mut ball = Ball {
        height: first_m,
        speed: 0.0_f64,
    };
    let step_s = 1.0 / f64::from(STEPS_PER_SECOND);
    for _ in 0..STEPS {
        step(integrator, &forces, &mut ball, step_s);
    }
    ball.height
}

#[derive(Debug, Clone, Copy)]
struct Judged {
    max_m: f64,
    rms_m: f64,
    count: u32,
}

fn judge(integrator: Integrator, first: &[State], last: &[State]) -> Judged {
    let stride = first.len().div_ceil(JUDGED).max(1);
    let (mut max_m, mut squares, mut count) = (0.0_f64, 0.0, 0_u32);
    for (first, last) in first.iter().zip(last).step_by(stride) {
        let exact = height_m(integrator, f64::from(first[0][2]));
        let error = (f64::from(last[0][2]) - exact).abs();
        // What is no number must not be lost in a maximum.
        max_m = if error <= max_m { max_m } else { error };
        squares += error * error;
        count += 1;
    }
    Judged {
        max_m,
        rms_m: (squares / f64::from(count.max(1))).sqrt(),
        count,
    }
}

/// Takes steps in frames of a few; bytes that the CPU wrote for the device meanwhile.
pub(crate) fn take(steps: &mut dyn Steps, count: u32) -> Result<u64, DeviceError> {
    let before = steps.uploaded();
    for _ in 0..count / TIMED {
        steps.step(TIMED)?;
    }
    if !count.is_multiple_of(TIMED) {
        steps.step(count % TIMED)?;
    }
    Ok(steps.uploaded() - before)
}

impl Trial for Stepped {
    type Opened = Box<dyn Steps>;

    fn conditions(&self) -> Vec<(ConditionKey, String)> {
        let (interface, way) = self.way.names();
        vec![
            (PART, "device".to_owned()),
            (INTERFACE, interface.to_owned()),
            (WAY, way.to_owned()),
            (BALLS, self.balls.to_string()),
        ]
    }

    fn verify(&self, context: Context<'_>) -> Result<(Self::Opened, Verdict), Failure> {
        let first = balls(self.balls);
        let constants = constants(self.balls);
        let mut steps = self.way.open(context.devices, &constants, &first, None)?;
        let uploaded = take(steps.as_mut(), STEPS)?;
        let last = steps.read()?;
        let mut found = judge(Integrator::SymplecticEuler, &first, &last);
        if last.len() != first.len() {
            found.max_m = f64::INFINITY;
        }
        let is_right = found.max_m <= ALLOWED_M;
        let expected = self.way.uploads(self.balls, STEPS / TIMED);
        let reason = if !is_right {
            format!("{} m from f64, allowed {ALLOWED_M} m", found.max_m)
        } else if uploaded != expected {
            format!("{uploaded} bytes were uploaded while stepping, expected {expected}")
        } else {
            String::new()
        };
        let figures = vec![
            ("ball_device_max_m", found.max_m),
            ("ball_device_rms_m", found.rms_m),
            ("ball_device_judged", f64::from(found.count)),
            ("ball_upload_bytes", uploaded as f64),
        ];
        Ok((steps, judged(reason, figures, Vec::new())))
    }

    fn time(&self, steps: &mut Self::Opened) -> Result<Figures, Failure> {
        let watch = CpuStopwatch::start();
        steps.step(TIMED)?;
        let each = 1e3 / f64::from(TIMED);
        let mut times = vec![
            ("ball_step_cpu_us", watch.cpu_ms() * each),
            ("ball_step_wall_us", watch.wall_ms() * each),
        ];
        let gpu_ms = steps.gpu_ms()?;
        times.extend(gpu_ms.map(|ms| ("ball_step_gpu_us", ms * each)));
        Ok(times)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::DrawsBalls;
    use terrafill_contract::Devices;
    use terrafill_scene::ImageSize;
    use terrafill_vulkan::{Buffer, BufferUse};

    /// Negative control: writes the state anew before it steps.
    struct Rewriting<'a> {
        steps: Box<dyn Steps>,
        way: Stepping,
        devices: &'a Devices,
    }

    impl Steps for Rewriting<'_> {
        fn step(&mut self, count: u32) -> Result<(), DeviceError> {
            let state = self.steps.read()?;
            let bytes: &[u8] = bytemuck::cast_slice(&state);
            if self.way == Stepping::WgpuCompute {
                let gpu = terrafill_gpu::shared_gpu(self.devices)?;
                gpu.upload("balls", bytes, wgpu::BufferUsages::STORAGE)?;
            } else {
                let gpu = terrafill_vulkan::shared_gpu(self.devices)?;
                Buffer::upload(&gpu, "balls", bytes, BufferUse::State)?;
            }
            self.steps.step(count)
        }

        fn gpu_ms(&self) -> Result<Option<f64>, DeviceError> {
            self.steps.gpu_ms()
        }

        fn read(&self) -> Result<Vec<State>, DeviceError> {
            self.steps.read()
        }

        fn uploaded(&self) -> u64 {
            self.steps.uploaded()
        }

        fn current(&self) -> usize {
            self.steps.current()
        }

        fn points(&self, size: ImageSize) -> Result<Box<dyn DrawsBalls>, DeviceError> {
            self.steps.points(size)
        }
    }

    #[test]
    fn every_way_follows_f64_and_another_integrator_does_not() {
        let devices = Devices::default();
        let mut ends: Vec<(Stepping, Vec<State>)> = Vec::new();
        for way in Stepping::ALL {
            let first = balls(1_000);
            let mut steps = match way.open(&devices, &constants(1_000), &first, None) {
                Ok(steps) => steps,
                Err(error) => {
                    assert!(matches!(error, DeviceError::Unsupported { .. }), "{error}");
                    eprintln!("{way:?}: {error}");
                    continue;
                }
            };
            let written = take(steps.as_mut(), STEPS).expect("steps");
            assert_eq!(written, way.uploads(1_000, STEPS / TIMED), "{way:?}");
            let last = steps.read().expect("reads");
            let judged = judge(Integrator::SymplecticEuler, &first, &last);
            eprintln!("{way:?}: {judged:?}");
            assert!(judged.max_m <= ALLOWED_M, "{way:?}: {judged:?}");
            let steps = way.open(&devices, &constants(1_000), &first, None);
            let mut rewriting = Rewriting {
                steps: steps.expect("opens"),
                way,
                devices: &devices,
            };
            let state_bytes = std::mem::size_of_val(first.as_slice()) as u64;
            let written = take(&mut rewriting, STEPS).expect("steps");
            let expected = u64::from(STEPS / TIMED) * state_bytes;
            let own = way.uploads(1_000, STEPS / TIMED);
            assert_eq!(written, expected + own, "{way:?}");
            // Negative controls: another integrator, and one step fewer.
            let other = judge(Integrator::VelocityVerlet, &first, &last);
            assert!(other.max_m > 100.0 * ALLOWED_M, "{way:?}: {other:?}");
            let mut fewer = way
                .open(&devices, &constants(1_000), &first, None)
                .expect("opens");
            fewer.step(STEPS - 1).expect("steps");
            let last_of_fewer = fewer.read().expect("reads");
            let short = judge(Integrator::SymplecticEuler, &first, &last_of_fewer);
            assert!(short.max_m > 100.0 * ALLOWED_M, "{way:?}: {short:?}");
            ends.push((way, last));
        }
        for (way, last) in ends.iter().skip(1) {
            let differing = last.iter().zip(&ends[0].1).filter(|(a, b)| a != b).count();
            eprintln!(
                "{way:?}: {differing} of 1000 balls differ from {:?}",
                ends[0].0
            );
        }
    }
}
