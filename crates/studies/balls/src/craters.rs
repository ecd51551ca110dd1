// SPDX-License-Identifier: MIT OR Apache-2.0
//! Craters where balls first meet the ground, in the layers of the very array texture that balls read heights from.
//!
//! Each ball digs once, at its first impact: craters of one step add up, so their order matters by rounding alone. They
//! are drawn into the layers, as considered in 2007, or the CPU reads the balls and writes the layers. Balls that come
//! later are reflected off the changed ground. The reference takes each step in `f64` from the balls and heights that the
//! device had. Slopes jump from cell to cell, so no arithmetic of `f32` follows `f64` for long.

mod on_wgpu;

pub(crate) use on_wgpu::CraterWay;

use crate::STUDY;
use crate::drawn::{COMPARED_BALLS, STEP_S, constants_over_terrain, flight_over};
use crate::flight::{
    ALLOWED_STEP_M, ALLOWED_STEP_SPEED, CRATER_DEPTH, CRATER_S, FlyingBall, Law, flown,
};
use crate::metrics::{BALLS, CRATER_WAY, GROUND, INTEGRATOR, INTERFACE, PART, SIZE_PX, WAY};
use crate::scene::SceneRays;
use crate::stepping::Stepping;
use crate::steps::BallConstants;
use crate::terrain::{BLOCKS, CELL_M, CELLS, SAMPLES, State, Terrain, whole};
use crate::walk::{flight_steps, most};
use glam::{DVec2, DVec3};
use on_wgpu::{Cratering, Snapshot};
use std::collections::BTreeMap;
use terrafill_contract::{CpuStopwatch, DeviceError, numbers_hash};
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, file_stem, judged, planned_case,
    verified, write_rgb,
};

/// What a height may differ by after a step, metres. Place and speed of an impact err by rounding, some 1e-5, and slopes of a
/// crater are up to a half. A margin of 10.
pub(crate) const ALLOWED_CRATER_M: f64 = 1e-4;
/// Numbers of balls: of more the ground would be craters alone.
pub(crate) const COUNTS: [u32; 2] = [500, COMPARED_BALLS];
/// Samples of a block.
const EACH: usize = (SAMPLES * SAMPLES) as usize;

/// A crater in `f64`.
struct Crater {
    place: DVec2,
    radius_m: f64,
}

impl Crater {
    /// - `before`: the ball before the step in which it meets the ground
    /// - `met`: when it does, steps
    fn new(before: &FlyingBall, met: f64) -> (Self, DVec3) {
        let [place, velocity] = flown(before.state, (met - before.steps) * STEP_S);
        let crater = Self {
            place: place.truncate(),
            radius_m: CRATER_S * velocity.length(),
        };
        (crater, place)
    }

    /// Adds how deep it is to all samples that it reaches.
    ///
    /// - `depths`: of each block, empty where no crater reached it
    fn dig(&self, depths: &mut [Vec<f64>]) {
        let depth_m = CRATER_DEPTH * self.radius_m;
        for (block, depths) in (0..).zip(depths) {
            let first =
                DVec2::new(f64::from(block % BLOCKS), f64::from(block / BLOCKS)) * f64::from(CELLS);
            let at = self.place / CELL_M - first;
            let reach = self.radius_m / CELL_M;
            let last = f64::from(CELLS);
            if (at + reach).min_element() < 0.0 || (at - reach).max_element() > last {
                continue;
            }
            depths.resize(EACH, 0.0);
            let held = |of: DVec2| {
                of.clamp(DVec2::ZERO, DVec2::splat(last))
                    .to_array()
                    .map(whole)
            };
            let ([left, top], [right, bottom]) =
                (held((at - reach).ceil()), held((at + reach).floor()));
            for (x, y) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (x, y))) {
                let away = (DVec2::new(f64::from(x), f64::from(y)) - at) / reach;
                depths[(y * SAMPLES + x) as usize] +=
                    depth_m * (1.0 - away.length_squared()).max(0.0);
            }
        }
    }
}

/// How balls and ground were compared with `f64`, step by step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Strikes {
    step_m: f64,
    step_speed: f64,
    /// Steps that rounding decided otherwise.
    in_band: usize,
    /// First impacts of the device and of `f64`, and those that one has and the other has not, outside of the band.
    impacts: usize,
    expected: usize,
    undecided: usize,
    /// Largest distance of a ball from the ground where it meets it first.
    gap_m: f64,
    /// Reflections on ground that a crater had changed before.
    on_craters: usize,
    /// Largest difference of a height after a step.
    height_m: f64,
    /// Heights that differ between blocks that share them.
    torn: usize,
}

impl Strikes {
    /// Compares a step with that of `f64` from the same balls and heights.
    ///
    /// - `untouched`: the ground before the first step
    /// - `digs`: whether first impacts are to make craters
    fn compare(&mut self, before: &Snapshot, after: &Snapshot, untouched: &Terrain, digs: bool) {
        let ground = &before.ground;
        let flight = flight_over(ground, Law::Event);
        let mut depths = vec![Vec::new(); ground.blocks.len()];
        for (was, is) in before.balls.iter().zip(&after.balls) {
            let error = flight.judge(was, is);
            self.step_m = most(error.place_m, self.step_m);
            self.step_speed = most(error.speed, self.step_speed);
            self.in_band += usize::from(error.is_in_band);
            let [was, is] = [was, is].map(FlyingBall::of);
            // Free flight leaves the level part of a velocity as it is, bit for bit.
            if was.state[1].truncate() != is.state[1].truncate() {
                let cell = Terrain::cell_of(is.state[0].truncate());
                let is_changed = ground.surface(cell) != untouched.surface(cell);
                self.on_craters += usize::from(is_changed);
            }
            if was.first_impact > 0.0 {
                continue;
            }
            let [expects, strikes] = [flight.step(&was), is].map(|ball| ball.first_impact > 0.0);
            self.expected += usize::from(expects);
            self.impacts += usize::from(strikes);
            self.undecided += usize::from(expects != strikes && !error.is_in_band);
            if !strikes {
                continue;
            }
            let (crater, place) = Crater::new(&was, is.first_impact);
            self.gap_m = most((place.z - ground.at(crater.place).0).abs(), self.gap_m);
            if digs {
                crater.dig(&mut depths);
            }
        }
        let blocks = ground.blocks.iter().zip(&after.ground.blocks);
        for ((before, after), depths) in blocks.zip(depths) {
            // Of the million samples most are in blocks that nothing reached: those are compared as they lie in memory.
            let bytes = bytemuck::cast_slice::<f32, u8>;
            if depths.is_empty() && bytes(before) == bytes(after) {
                continue;
            }
            let depths = depths.into_iter().chain(std::iter::repeat(0.0));
            for ((&before, &after), depth) in before.iter().zip(after).zip(depths) {
                if before.to_bits() != after.to_bits() || depth > 0.0 {
                    let error = (f64::from(after) - (f64::from(before) - depth)).abs();
                    self.height_m = most(error, self.height_m);
                }
            }
        }
    }

    fn reason(&self, digs: bool) -> String {
        let holds = |found: f64, allowed: f64| found <= allowed;
        if !holds(self.step_m, ALLOWED_STEP_M) || !holds(self.step_speed, ALLOWED_STEP_SPEED) {
            format!(
                "a step is {} m and {} m/s from f64",
                self.step_m, self.step_speed
            )
        } else if self.undecided > 0 {
            format!(
                "{} balls meet the ground first in another step than in f64",
                self.undecided
            )
        } else if !holds(self.gap_m, ALLOWED_STEP_M) {
            format!("a ball meets the ground {} m from it", self.gap_m)
        } else if !holds(self.height_m, ALLOWED_CRATER_M) {
            format!(
                "a height is {} m from f64, allowed {ALLOWED_CRATER_M} m",
                self.height_m
            )
        } else if self.torn > 0 {
            format!(
                "{} heights differ between blocks that share them",
                self.torn
            )
        } else if self.impacts == 0 {
            "no ball meets the ground".to_owned()
        } else if digs != (self.on_craters > 0) {
            format!(
                "balls are reflected {} times by ground that craters changed",
                self.on_craters
            )
        } else {
            String::new()
        }
    }
}

/// Samples of borders whose bits differ between the blocks that share them.
fn torn(terrain: &Terrain) -> usize {
    let height = |block: u32, [x, y]: [u32; 2]| {
        terrain.blocks[block as usize][(y * SAMPLES + x) as usize].to_bits()
    };
    let blocks = (0..BLOCKS * BLOCKS).flat_map(|block| (0..SAMPLES).map(move |at| (block, at)));
    let differ = |(block, at): (u32, u32)| {
        let right =
            block % BLOCKS + 1 < BLOCKS && height(block, [CELLS, at]) != height(block + 1, [0, at]);
        let below = block / BLOCKS + 1 < BLOCKS
            && height(block, [at, CELLS]) != height(block + BLOCKS, [at, 0]);
        usize::from(right) + usize::from(below)
    };
    blocks.map(differ).sum()
}

/// Balls that strike ground.
pub(crate) struct Craters {
    cases: Vec<(CraterWay, u32)>,
    size: ImageSize,
}

/// - `counts`: numbers of balls
pub(crate) fn group(counts: &[u32], size: ImageSize, samples: u32) -> CaseGroup<Craters> {
    let of = |&balls: &u32| CraterWay::ALL.map(|way| (way, balls));
    let cases: Vec<_> = counts.iter().flat_map(of).collect();
    let case = |(way, balls): &(CraterWay, u32)| {
        let (interface, name) = Stepping::WgpuCompute.names();
        let conditions = vec![
            (PART, "craters".to_owned()),
            (INTERFACE, interface.to_owned()),
            (WAY, name.to_owned()),
            (GROUND, "terrain".to_owned()),
            (INTEGRATOR, Law::Event.name().to_owned()),
            (CRATER_WAY, way.name().to_owned()),
            (BALLS, balls.to_string()),
        ];
        planned_case(
            STUDY,
            samples,
            conditions,
            Some((SIZE_PX, size.width.to_string())),
        )
    };
    CaseGroup {
        name: format!("{STUDY}/craters"),
        cases: cases.iter().map(case).collect(),
        warm_up: Some(0),
        work: Craters { cases, size },
        open: |group, context| {
            Ok(Box::new(JudgedOnce::new(CraterSession {
                group,
                context,
                terrain: Terrain::new(),
                opened: BTreeMap::new(),
            })))
        },
    }
}

struct CraterSession<'a> {
    group: &'a CaseGroup<Craters>,
    context: Context<'a>,
    terrain: Terrain,
    /// By case.
    opened: BTreeMap<usize, Cratering>,
}

/// Takes all steps beside `f64`.
///
/// - returns: how they compare, and balls and ground at the end
fn strike(
    cratering: &mut Cratering,
    first: &[State],
    terrain: &Terrain,
    digs: bool,
) -> Result<(Strikes, Snapshot), DeviceError> {
    let mut strikes = Strikes::default();
    let mut before = Snapshot::new(first, terrain);
    for _ in 0..flight_steps(first.len()) {
        cratering.step()?;
        let after = cratering.read()?;
        strikes.compare(&before, &after, terrain, digs);
        before = after;
    }
    strikes.torn = torn(&before.ground);
    Ok((strikes, before))
}

fn constants(balls: u32) -> BallConstants {
    constants_over_terrain(balls, Law::Event)
}

impl Shows for CraterSession<'_> {
    /// Balls and ground at the end.
    type Shown = Snapshot;

    fn show(&mut self, case: usize) -> Result<(String, Snapshot), Failure> {
        let (way, count) = self.group.work.cases[case];
        let first = self.terrain.balls(count);
        let devices = self.context.devices;
        let mut cratering = Cratering::new(devices, way, &constants(count), &first, &self.terrain)?;
        for _ in 0..flight_steps(first.len()) {
            cratering.step()?;
        }
        let last = cratering.read()?;
        let picture = numbers_hash(&cratering.picture(self.group.work.size)?);
        self.opened.insert(case, cratering);
        let heights = last.ground.blocks.concat();
        let [balls, heights] = [
            bytemuck::cast_slice(&last.balls),
            bytemuck::cast_slice(&heights),
        ]
        .map(numbers_hash);
        Ok((format!("{balls}-{heights}-{picture}"), last))
    }

    /// Takes the steps once more, each beside `f64`.
    fn judge(&mut self, case: usize, shown: Snapshot) -> Result<Verdict, Failure> {
        let Craters { ref cases, size } = self.group.work;
        let (way, count) = cases[case];
        let digs = way != CraterWay::Nothing;
        let first = self.terrain.balls(count);
        let cratering = verified(&mut self.opened, case)?;
        cratering.begin(&first, &self.terrain)?;
        let (strikes, last) = strike(cratering, &first, &self.terrain, digs)?;
        let numbers = cratering.picture(size)?;
        let rays = SceneRays::new(&last.ground, &last.balls, size);
        let found = rays.judge(&numbers);
        let mut reason = strikes.reason(digs);
        if reason.is_empty() && last != shown {
            let otherwise = "balls or ground end otherwise when the same steps are taken once more";
            otherwise.clone_into(&mut reason);
        }
        if reason.is_empty() && found.mismatched > 0 {
            reason = format!(
                "{} pixels show what the reference does not allow",
                found.mismatched
            );
        } else if reason.is_empty() && !SceneRays::shows_balls(&numbers) {
            reason = "it shows no ball".to_owned();
        }
        let figures = vec![
            ("ball_terrain_step_m", strikes.step_m),
            ("ball_terrain_step_speed", strikes.step_speed),
            ("ball_terrain_in_band", strikes.in_band as f64),
            ("ball_strikes", strikes.impacts as f64),
            ("ball_strikes_differing", strikes.undecided as f64),
            ("ball_bounces_on_craters", strikes.on_craters as f64),
            ("ball_crater_m", strikes.height_m),
            ("ball_crater_torn", strikes.torn as f64),
            ("ball_upload_bytes", cratering.written_bytes as f64),
            ("ball_mismatched_px", found.mismatched as f64),
        ];
        let stem = file_stem(&format!("{STUDY}-{}", self.group.cases[case].id.name));
        let pixels: Vec<u8> = rays.colours(&numbers).flatten().collect();
        let path = write_rgb(
            self.context.folder,
            &stem,
            [size.width, size.height],
            &pixels,
        )?;
        Ok(judged(reason, figures, vec![("picture", path)]))
    }

    /// The mean of all steps, in which all balls strike: in the end none would.
    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let first = self.terrain.balls(self.group.work.cases[case].1);
        let cratering = verified(&mut self.opened, case)?;
        cratering.begin(&first, &self.terrain)?;
        let steps = flight_steps(first.len());
        let watch = CpuStopwatch::start();
        for _ in 0..steps {
            cratering.step()?;
        }
        let each = 1e3 / f64::from(steps);
        Ok(vec![
            ("ball_frame_cpu_us", watch.cpu_ms() * each),
            ("ball_frame_wall_us", watch.wall_ms() * each),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;
    use terrafill_contract::{Devices, device_for_test};
    use terrafill_results::Status;
    use terrafill_study::Group as _;

    const SIZE: ImageSize = ImageSize::new(192, 192);
    const COUNT: u32 = 500;
    const MANY: u32 = 1_000;

    #[test]
    fn balls_dig_where_f64_says_and_later_ones_meet_what_was_dug() {
        let devices = Rc::new(Devices::default());
        if device_for_test(terrafill_gpu::shared_gpu(&devices)).is_none() {
            return;
        }
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("images")).expect("writable");
        let group = group(&[COUNT], SIZE, 1);
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        let mut session = group.open(context).expect("opens");
        for (at, case) in group.cases.iter().enumerate() {
            let verdict = session
                .verify(at)
                .or_else(Failure::verdict)
                .expect("a verdict");
            let name = &case.id.name;
            eprintln!(
                "{name}: {:?} {} {:?}",
                verdict.status, verdict.reason, verdict.figures
            );
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            let times = session.time(at).expect("a time");
            assert!(times.iter().all(|(_, time)| *time > 0.0), "{times:?}");
        }
    }

    #[test]
    fn craters_that_are_forgotten_moved_or_not_read_by_balls_are_noticed() {
        let devices = Rc::new(Devices::default());
        if device_for_test(terrafill_gpu::shared_gpu(&devices)).is_none() {
            return;
        }
        let terrain = Terrain::new();
        let first = terrain.balls(MANY);
        let open = |way, constants: &BallConstants| {
            Cratering::new(&devices, way, constants, &first, &terrain).expect("opens")
        };
        // As many steps as half of the balls need, or the lowest ones.
        let run = |way, constants: &BallConstants, steps: u32, forgets: bool| {
            let mut cratering = open(way, constants);
            let mut before = Snapshot::new(&first, &terrain);
            let (mut strikes, mut blind) = (Strikes::default(), Strikes::default());
            for _ in 0..steps {
                cratering.step().expect("steps");
                let mut after = cratering.read().expect("reads");
                if forgets {
                    // A block as it was.
                    after.ground.blocks[5].clone_from(&terrain.blocks[5]);
                }
                strikes.compare(&before, &after, &terrain, true);
                // Balls as over the untouched ground.
                let [was, is] = [&before, &after].map(|of| Snapshot::new(&of.balls, &terrain));
                blind.compare(&was, &is, &terrain, false);
                before = after;
            }
            strikes.torn = torn(&before.ground);
            (strikes, blind)
        };
        let own = constants(MANY);
        let (right, blind) = run(CraterWay::Drawn, &own, 100, false);
        assert_eq!(right.reason(true), "", "{right:?}");
        assert!(
            right.impacts > 300 && right.impacts == right.expected,
            "{right:?}"
        );
        // Negative controls: balls do not fly as over untouched ground, nor is the ground as without craters, with deeper
        // ones or with those of a block left out.
        assert!(blind.reason(false).contains("from f64"), "{blind:?}");
        let (none, _) = run(CraterWay::Nothing, &own, 60, false);
        assert!(none.reason(true).contains("a height is"), "{none:?}");
        let deeper = BallConstants {
            crater_depth: 0.2505,
            ..own
        };
        let (deeper, _) = run(CraterWay::Drawn, &deeper, 60, false);
        assert!(deeper.reason(true).contains("a height is"), "{deeper:?}");
        let (forgotten, _) = run(CraterWay::Written, &own, 60, true);
        assert!(forgotten.height_m > 0.01, "{forgotten:?}");
        // One height of a border, which another block has as it was.
        let mut broken = terrain.clone();
        broken.blocks[5][(CELLS + SAMPLES) as usize] += 1e-3;
        assert_eq!([torn(&terrain), torn(&broken)], [0, 1]);
    }

    #[test]
    fn other_balls_other_ground_and_a_shifted_picture_are_noticed() {
        let devices = Rc::new(Devices::default());
        if device_for_test(terrafill_gpu::shared_gpu(&devices)).is_none() {
            return;
        }
        let terrain = Terrain::new();
        let first = terrain.balls(COUNT);
        let way = CraterWay::Nothing;
        let cratering = Cratering::new(&devices, way, &constants(COUNT), &first, &terrain);
        let numbers = cratering
            .and_then(|of| of.picture(SIZE))
            .expect("a picture");
        let judged = |terrain: &Terrain, balls: &[State], numbers: &[u32]| {
            SceneRays::new(terrain, balls, SIZE)
                .judge(numbers)
                .mismatched
        };
        assert_eq!(judged(&terrain, &first, &numbers), 0);
        assert!(judged(&Terrain::flat(), &first, &numbers) > 1_000);
        assert!(judged(&terrain, &first[..COUNT as usize / 2], &numbers) > 0);
        let mut shifted = numbers.clone();
        shifted.rotate_left(1);
        assert!(judged(&terrain, &first, &shifted) > 1_000);
    }
}
