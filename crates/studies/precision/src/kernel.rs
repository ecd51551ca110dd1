// SPDX-License-Identifier: MIT OR Apache-2.0
//! Routes on the device: the text of each, compiled once and asked for every region.

use crate::place::{RegionPicture, halton};
use crate::row::PrecisionPart;
use crate::sight;
use glam::DVec3;
use std::sync::Arc;
use terrafill_gpu::{
    EVALUATIONS_PER_DISPATCH, Evaluation, EvaluationTime, Evaluator, Gpu, Kernel, RouteTexels,
};
use terrafill_results::median;
use terrafill_study::StudyError;
use terrafill_texture::{
    CoordinateRoute, DepthMapping, Filter, LookupTable, PositionRoute, Program, Sampler,
    TexelFormat,
};

/// Turns of the timed loop: some milliseconds of the native arctangents on a software device.
const TURNS: u32 = 48;

/// Passes of the empty formula per round: every other time is held against their median.
const EMPTY_PASSES: usize = 3;

/// Region whose fragments are timed, degrees: what a formula costs does not depend on its constants.
const TIMED_EXTENT_DEG: f64 = 1.0;
const TIMED_LATITUDE_DEG: f64 = 45.0;
/// How far a fragment moves between two timed evaluations, metres: far enough to be another number,
/// and all of them together far less than the region.
const TIMED_STEP_M: f32 = 0.01;

/// A coordinate route on the device.
pub(crate) struct CoordinateKernel {
    pub(crate) route: CoordinateRoute,
    pub(crate) program: Program,
    /// How this device's sampler reads the route's texture, where it was asked.
    pub(crate) sampler: Option<Sampler>,
    /// Or why it does not run.
    pub(crate) device: Result<Evaluator, String>,
}

/// A position route on the device, for the depths of one mapping.
pub(crate) struct PositionKernel {
    pub(crate) route: PositionRoute,
    pub(crate) mapping: DepthMapping,
    pub(crate) device: Result<Evaluator, String>,
}

/// All of them.
pub(crate) struct Kernels {
    pub(crate) coordinate: Vec<CoordinateKernel>,
    pub(crate) position: Vec<PositionKernel>,
    empty: Result<Evaluator, String>,
}

/// What the loop alone took in a round.
pub(crate) struct LoopTime {
    pub(crate) cpu_ms: f64,
    pub(crate) gpu_ms: Option<f64>,
}

/// A device's failure, with which the study cannot go on.
fn broken(why: impl ToString) -> StudyError {
    StudyError::Broken {
        place: crate::STUDY.to_owned(),
        message: why.to_string(),
    }
}

/// What the device's linear sampler does with each format of a table.
struct Samplers(Vec<(TexelFormat, Sampler)>);

impl Samplers {
    /// Asks it; a format that it does not filter has no entry.
    fn ask(gpu: &Arc<Gpu>) -> Self {
        let asked = TexelFormat::ALL.into_iter().filter_map(|format| {
            let table = LookupTable::arctangent(PROBE_TEXELS, format, Filter::Linear);
            let answers = sampled(gpu, &table)?;
            Some((format, sampler_of(&table, &answers)))
        });
        Self(asked.collect())
    }

    /// Of what a program reads through it; a cube texture holds single floats.
    fn of(&self, program: &Program) -> Option<Sampler> {
        let format = match program.table() {
            Some(table) if table.filter() == Filter::Linear => table.format(),
            Some(_) => return None,
            None => program.cube().map(|_| TexelFormat::R32Float)?,
        };
        self.0.iter().find(|(of, _)| *of == format).map(|(_, s)| *s)
    }
}

/// Entries of the table that a sampler is read at: so few that a step of a weight is far above the
/// last place of an answer.
const PROBE_TEXELS: u16 = 16;
/// Texture coordinates at which it is read.
const PROBES: u16 = 4096;
/// What an answer of 1 may be off by in `f32` after a handful of operations: below, a sampler has no error
/// of its own.
const ROUNDED: f64 = 4e-7;

/// Texture coordinates and the sampler's answers.
fn sampled(gpu: &Arc<Gpu>, table: &LookupTable) -> Option<Vec<(f32, f32)>> {
    let mut text = table.declarations(1, 0);
    text.push_str(
        "fn probe(x: vec4f) -> vec4f {\n    \
         return textureSampleLevel(route_table, route_sampler, vec2f(x.x, 0.5), 0.0);\n}\n",
    );
    let texels = RouteTexels::of_table(table);
    let kernel = Kernel {
        name: "sampler",
        wgsl: &text,
        constants: None,
        call: "probe(x)",
        table: Some(&texels),
    };
    let device = Evaluator::new(gpu, &kernel, 0).ok()?;
    let places: Vec<f32> = (0..PROBES)
        .map(|i| (f32::from(i) + 0.37) / f32::from(PROBES))
        .collect();
    let inputs: Vec<[f32; 4]> = places.iter().map(|u| [*u, 0.0, 0.0, 0.0]).collect();
    let answers = device.evaluate(&inputs).ok()?;
    let values = answers.values.iter().map(|value| value[0]);
    Some(places.into_iter().zip(values).collect())
}

/// The way of weighing that leaves the answers in the narrower range, and what they are off by beyond it:
/// an error of the filter's own is as wide for both.
fn sampler_of(table: &LookupTable, answers: &[(f32, f32)]) -> Sampler {
    let model = |weighs_exactly| {
        let sampler = Sampler {
            weighs_exactly,
            off: [0.0; 2],
        };
        let table = table.clone().on(sampler);
        let off = |(u, answer): &(f32, f32)| f64::from(*answer) - f64::from(table.sample(*u));
        let low = answers.iter().map(off).fold(f64::INFINITY, f64::min);
        let high = answers.iter().map(off).fold(f64::NEG_INFINITY, f64::max);
        let seen = |off: f64| if off.abs() > ROUNDED { off } else { 0.0 };
        let off = [seen(low), seen(high)];
        (high - low, Sampler { off, ..sampler })
    };
    let ((common, by_steps), (exact, exactly)) = (model(false), model(true));
    if exact < common { exactly } else { by_steps }
}

impl Kernels {
    pub(crate) fn new(gpu: &Arc<Gpu>, routes: &[CoordinateRoute]) -> Self {
        let samplers = Samplers::ask(gpu);
        let coordinate = routes.iter().map(|route| {
            let program = route.program();
            CoordinateKernel {
                route: *route,
                sampler: samplers.of(&program),
                device: coordinate_evaluator(gpu, &route.name(), &program, &program.wgsl()),
                program,
            }
        });
        let position = PositionRoute::ALL.into_iter().flat_map(|route| {
            DepthMapping::ALL.map(|mapping| PositionKernel {
                route,
                mapping,
                device: position_evaluator(gpu, route, mapping),
            })
        });
        Self {
            coordinate: coordinate.collect(),
            position: position.collect(),
            empty: Evaluator::new(gpu, &Kernel::BASELINE, 0).map_err(|error| error.to_string()),
        }
    }

    /// Uploads what is timed and sets the constants that it is timed under. Measuring errors sets
    /// others.
    pub(crate) fn prepare_timing(&mut self) -> Result<(), StudyError> {
        let offsets = timed_offsets();
        let of_offset = [TIMED_STEP_M; 4];
        let depths = sight::timed_inputs();
        if let Ok(empty) = &mut self.empty {
            empty.prepare_timing(&offsets, of_offset, TURNS);
        }
        let region = RegionPicture::new(TIMED_EXTENT_DEG, TIMED_LATITUDE_DEG, ("0", 0.0, 0.0));
        for kernel in &mut self.coordinate {
            if let (Ok(device), Some(place)) = (&mut kernel.device, &region) {
                let constants = kernel.route.constants(&place.region);
                device.set_constants(&constants).map_err(broken)?;
                device.prepare_timing(&offsets, of_offset, TURNS);
            }
        }
        for kernel in &mut self.position {
            if let Ok(device) = &mut kernel.device {
                let constants = sight::timed_constants(kernel.route, kernel.mapping);
                device.set_constants(&constants).map_err(broken)?;
                device.prepare_timing(&depths, sight::TIMED_STEP, TURNS);
            }
        }
        Ok(())
    }

    /// What the loop alone takes now.
    pub(crate) fn time_empty(&self) -> Result<LoopTime, StudyError> {
        let empty = self.empty.as_ref().map_err(broken)?;
        let (mut cpu_ms, mut gpu_ms) = (Vec::new(), Vec::new());
        for _ in 0..EMPTY_PASSES {
            let time = empty.time(TURNS).map_err(broken)?;
            cpu_ms.push(time.cpu_ms);
            gpu_ms.extend(time.gpu_ms);
        }
        Ok(LoopTime {
            cpu_ms: median(&cpu_ms).unwrap_or(f64::NAN),
            gpu_ms: median(&gpu_ms),
        })
    }

    /// The device's program of a timed formula, or why there is none.
    pub(crate) fn timed(&self, formula: &TimedFormula) -> Result<&Evaluator, String> {
        let device = match formula {
            TimedFormula::Coordinate(route) => {
                let mut kernels = self.coordinate.iter();
                kernels
                    .find(|kernel| kernel.route == *route)
                    .map(|kernel| &kernel.device)
            }
            TimedFormula::Position(route, mapping) => {
                let of =
                    |kernel: &&PositionKernel| kernel.route == *route && kernel.mapping == *mapping;
                self.position.iter().find(of).map(|kernel| &kernel.device)
            }
        };
        device
            .ok_or_else(|| "it was not compiled".to_owned())?
            .as_ref()
            .map_err(Clone::clone)
    }

    /// One timed pass of a formula.
    pub(crate) fn time(&self, formula: &TimedFormula) -> Result<EvaluationTime, String> {
        let device = self.timed(formula)?;
        device.time(TURNS).map_err(|error| error.to_string())
    }
}

/// A formula whose time is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum TimedFormula {
    Coordinate(CoordinateRoute),
    /// Storage and planes of a depth format are no part of a formula's text, its mapping is.
    Position(PositionRoute, DepthMapping),
}

impl TimedFormula {
    /// Every formula: `routes`, and every position route by each mapping.
    pub(crate) fn all(routes: &[CoordinateRoute]) -> Vec<Self> {
        let coordinate = routes.iter().copied().map(Self::Coordinate);
        let position = PositionRoute::ALL
            .into_iter()
            .flat_map(|route| DepthMapping::ALL.map(|mapping| Self::Position(route, mapping)));
        coordinate.chain(position).collect()
    }

    pub(crate) fn part(&self) -> PrecisionPart {
        match self {
            Self::Coordinate(_) => PrecisionPart::Coordinate,
            Self::Position(..) => PrecisionPart::Position,
        }
    }

    pub(crate) fn name(&self) -> String {
        match self {
            Self::Coordinate(route) => route.name(),
            Self::Position(route, mapping) => sight::timed_name(*route, *mapping),
        }
    }
}

/// Offsets of fragments, as many as a dispatch takes.
fn timed_offsets() -> Vec<[f32; 4]> {
    let metres = TIMED_EXTENT_DEG.to_radians() * 6.4e6 * 0.5;
    let places = (1..).map(halton).take(EVALUATIONS_PER_DISPATCH);
    let offset = |at: DVec3| ((2.0 * at - 1.0) * metres).as_vec3();
    places.map(|at| offset(at).extend(0.0).to_array()).collect()
}

/// The route's evaluator, or why there is none.
///
/// - `wgsl`: of the program, or a wrong one that must be noticed
pub(crate) fn coordinate_evaluator(
    gpu: &Arc<Gpu>,
    name: &str,
    program: &Program,
    wgsl: &str,
) -> Result<Evaluator, String> {
    let mut text = RouteTexels::declarations(program, 1);
    text.push_str(wgsl);
    let texels = RouteTexels::of(program);
    let kernel = Kernel {
        name,
        wgsl: &text,
        constants: Some("RouteConstants"),
        call: "vec4f(route_angles(x.xyz, constants), 0.0, 0.0)",
        table: texels.as_ref(),
    };
    Evaluator::new(gpu, &kernel, program.constant_vectors()).map_err(|error| error.to_string())
}

fn position_evaluator(
    gpu: &Arc<Gpu>,
    route: PositionRoute,
    mapping: DepthMapping,
) -> Result<Evaluator, String> {
    let format = sight::timed_format(mapping);
    let kernel = Kernel {
        name: &sight::timed_name(route, mapping),
        wgsl: &route.wgsl(&format),
        constants: Some("PositionConstants"),
        call: "vec4f(fragment_offset(x.xy, x.z, constants), 0.0)",
        table: None,
    };
    let vectors = route.program(&format).constant_vectors();
    Evaluator::new(gpu, &kernel, vectors).map_err(|error| error.to_string())
}

/// Asks a kernel for every input under these constants; the reason where it cannot be asked.
pub(crate) fn ask(
    device: &Result<Evaluator, String>,
    constants: &[[f32; 4]],
    inputs: &[[f32; 4]],
) -> Result<Result<Evaluation, String>, StudyError> {
    match device {
        Ok(device) => {
            device.set_constants(constants).map_err(broken)?;
            device.evaluate(inputs).map(Ok).map_err(broken)
        }
        Err(why) => Ok(Err(format!("not on this device: {why}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_gpu::{GpuOptions, open_for_test};

    /// What a sampler of these properties would answer.
    fn answers_of(table: &LookupTable, weighs_exactly: bool, shift: f32) -> Vec<(f32, f32)> {
        let off = [0.0; 2];
        let table = table.clone().on(Sampler {
            weighs_exactly,
            off,
        });
        let places = (0..PROBES).map(|i| (f32::from(i) + 0.37) / f32::from(PROBES));
        let answer = |u: f32| (u, table.sample(u) + if u > 0.5 { shift } else { 0.0 });
        places.map(answer).collect()
    }

    #[test]
    fn a_sampler_is_known_by_its_answers() {
        let table = LookupTable::arctangent(PROBE_TEXELS, TexelFormat::R8Unorm, Filter::Linear);
        let of = |exactly, shift| sampler_of(&table, &answers_of(&table, exactly, shift));
        assert_eq!(of(false, 0.0), Sampler::COMMON);
        assert!(of(true, 0.0).weighs_exactly, "control");
        // One that truncates answers to 8 bits is off to one side.
        let [low, high] = of(true, -1.0 / 255.0).off;
        assert!(
            (low + 1.0 / 255.0).abs() < 1e-6 && high.abs() < 1e-6,
            "{low} {high}"
        );
    }

    #[test]
    fn this_devices_sampler_is_within_what_the_bound_grants() {
        let Some(gpu) = open_for_test(&GpuOptions::default()) else {
            return;
        };
        let samplers = Samplers::ask(&gpu);
        assert!(
            samplers.0.len() >= 3,
            "formats that WebGPU filters everywhere"
        );
        for (format, sampler) in &samplers.0 {
            let most = sampler
                .off
                .iter()
                .fold(0.0, |most: f64, off| most.max(off.abs()));
            // A step of the format at most, beyond half a step of the weights.
            let step = match format {
                TexelFormat::R8Unorm => 1.0 / 255.0,
                TexelFormat::R16Unorm => 1.0 / 65_535.0,
                TexelFormat::R16Float | TexelFormat::R32Float => 1e-6,
            };
            assert!(most <= step * 1.01, "{format:?}: {sampler:?}");
        }
    }
}
