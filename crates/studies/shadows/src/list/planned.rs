// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a case is called, its conditions, and whether being wrong is what it is to show.

use crate::STUDY;
use crate::brought::Brought;
use crate::counted::{Counted, Ranges};
use crate::job::{Job, Method, PORT, sun_name};
use crate::lamps::{LampEye, Limit, MOON_NAME};
use crate::maps::Bias;
use crate::metrics::*;
use crate::views::{Chooser, Eyes};
use crate::way::Counting;
use crate::work::Scissor;
use terrafill_casters::Policy;
use terrafill_results::{ConditionKey, PlannedCase};
use terrafill_shadow_views::{EyeTest, Interface, Positions, Rule};
use terrafill_study::{planned_case, size_name};
use terrafill_variant::FacePasses;

/// Timed samples a process: a frame of a device is seven pictures, and a run has five processes.
const SAMPLES: u32 = 1;

type Condition = (ConditionKey, String);

fn is(key: ConditionKey, value: impl ToString) -> Condition {
    (key, value.to_string())
}

fn under(sun: [f64; 2]) -> Condition {
    is(SUN, sun_name(sun))
}

fn by(interface: Interface) -> Condition {
    is(API, interface.name())
}

fn counting(is_guarded: bool) -> Condition {
    let name = if is_guarded {
        "passes of 255"
    } else {
        "8 bits, wrapping"
    };
    is(COUNTING, name)
}

fn unlimited() -> Condition {
    is(LIMIT, Limit::Off.name())
}

/// A sun, where the port is seen from if not the bridge, and what else there is.
fn seen_under(
    sun: [f64; 2],
    eyes: Eyes,
    others: impl IntoIterator<Item = Condition>,
) -> Vec<Condition> {
    let view = (eyes != Eyes::Bridge).then(|| is(VIEW, eyes.name()));
    let own = std::iter::once(under(sun)).chain(view);
    own.chain(others).collect()
}

/// Where not every pixel counts.
fn where_counted(counted: Counted) -> Option<Condition> {
    (counted != Counted::All).then(|| is(COUNTED, counted.name()))
}

/// Its question, its conditions beside that, and whether it may be wrong.
fn described(job: Job) -> (&'static str, Vec<Condition>, bool) {
    match job {
        Job::Model => ("model", Vec::new(), false),
        Job::Eye(sun, near, test) => {
            let conditions = vec![under(sun), is(NEAR_M, near), is(EYE_TEST, test.name())];
            (
                "eyes",
                conditions,
                matches!(test, EyeTest::Eye | EyeTest::EyeModel),
            )
        }
        Job::Updates(sun, end, rule) => {
            let conditions = vec![under(sun), is(EXTENT, end.name()), is(RULE, rule.name())];
            ("updates", conditions, rule == Rule::PassAsPrinted)
        }
        Job::Scissor(sun, scissor, counted) => {
            let may_be_wrong = match scissor {
                Scissor::Off | Scissor::CasterRectangle => false,
                Scissor::Horizon => true,
                Scissor::SeaLevel | Scissor::ReceiverRectangle => counted == Counted::All,
            };
            let conditions = vec![under(sun), is(SCISSOR, scissor.name())];
            let conditions = conditions.into_iter().chain(where_counted(counted));
            ("scissors", conditions.collect(), may_be_wrong)
        }
        Job::Bounds(sun, rule, ranges, counted) => {
            let bounds = is(DEPTH_BOUNDS, ranges.name());
            let conditions = vec![under(sun), is(RULE, rule.name()), bounds];
            let conditions = conditions.into_iter().chain(where_counted(counted));
            let may_be_wrong = ranges == Ranges::One && counted == Counted::All;
            ("bounds", conditions.collect(), may_be_wrong)
        }
        Job::Finite(sun, length) => ("finite", vec![under(sun), is(LENGTH_M, length)], true),
        Job::Row(count, guard) => ("rows", vec![is(CASTERS, count), counting(guard)], !guard),
        Job::Casters(policy) => {
            let conditions = vec![is(POLICY, policy.name())];
            ("casters", conditions, policy == Policy::AsIs)
        }
        Job::Silhouette(mesh, method) => {
            // A user's mesh has no name.
            let mesh_name = (!mesh.is_empty()).then(|| is(MESH, mesh));
            let conditions = mesh_name.into_iter().chain([is(SILHOUETTE, method.name())]);
            let may_be_wrong = mesh.contains("turned") && method != Method::Adjacency;
            ("silhouettes", conditions.collect(), may_be_wrong)
        }
        Job::Map(sun, texel, bias) | Job::DeviceMap(sun, texel, bias) => {
            let question = match job {
                Job::Map(..) => "maps",
                _ => "device-maps",
            };
            let conditions = vec![under(sun), is(TEXEL_M, texel), is(BIAS, bias.name())];
            (question, conditions, true)
        }
        Job::Harbour(frame) => {
            let seen = [under(frame.sun), is(VIEW, frame.eyes.name())];
            let casters = (frame.port != PORT).then(|| is(MESH, frame.port));
            let size = frame.size.map(|size| is(SIZE_PX, size_name(size)));
            let is_plain = size.is_none() && casters.is_none();
            let question = if is_plain { "harbour" } else { "fits" };
            let named = std::iter::once(by(frame.interface)).chain(casters);
            (
                question,
                seen.into_iter().chain(named).chain(size).collect(),
                false,
            )
        }
        Job::Lamp(name, rule, limit) => {
            let limit_name = is(LIMIT, limit.name());
            let conditions = vec![is(LIGHT, name.name()), is(RULE, rule.name()), limit_name];
            ("lights", conditions, limit.may_be_wrong())
        }
        Job::DeviceLamp(name, eye, interface, rule, limit) => {
            let conditions = vec![
                is(LIGHT, name.name()),
                is(VIEW, eye.name()),
                by(interface),
                is(RULE, rule.name()),
                is(LIMIT, limit.name()),
            ];
            let is_outside = eye == LampEye::InShadow && rule == Rule::Pass;
            ("device-lights", conditions, is_outside)
        }
        Job::Moon(rule) => {
            let conditions = vec![is(LIGHT, MOON_NAME), is(RULE, rule.name()), unlimited()];
            ("lights", conditions, false)
        }
        Job::DeviceMoon(eyes, interface, rule) => {
            let conditions = vec![
                is(LIGHT, MOON_NAME),
                is(VIEW, eyes.name()),
                by(interface),
                is(RULE, rule.name()),
                unlimited(),
            ];
            ("device-lights", conditions, false)
        }
        Job::View(sun, place, chooser) => (
            "views",
            vec![under(sun), is(VIEW, place.name()), is(RULE, chooser.name())],
            matches!(
                chooser,
                Chooser::All(Rule::Pass) | Chooser::Test(EyeTest::Eye)
            ),
        ),
        Job::Rival(sun, eyes, rival) => {
            let named = [by(rival.interface()), is(RIVAL, rival.name())];
            ("rivals", seen_under(sun, eyes, named), false)
        }
        Job::StencilStep(sun, step) => {
            let named = is(STEP, format!("{} {}", step.number, step.name));
            let conditions = vec![
                under(sun),
                by(step.way.interface),
                named,
                is(PAPER, step.paper),
            ];
            ("ladder", conditions, false)
        }
        Job::Origin(sun, eyes, way) => {
            let positions = is(POSITIONS, way.positions.name());
            let conditions = vec![
                under(sun),
                is(VIEW, eyes.name()),
                by(way.interface),
                positions,
            ];
            ("origins", conditions, way.positions != Positions::Eye)
        }
        Job::Near(sun, way) => {
            let may_be_wrong = match way.counting {
                Counting::Casters => way.rule == Rule::Pass,
                Counting::Chosen(test) => matches!(test, EyeTest::Eye | EyeTest::EyeModel),
                _ => false,
            };
            let conditions = vec![under(sun), by(way.interface), is(RULE, way.rule_name())];
            ("near", conditions, may_be_wrong)
        }
        Job::DeviceRow(count, way) => {
            let is_guarded = way.counting == Counting::Parts { is_guarded: true };
            let conditions = vec![is(CASTERS, count), by(way.interface), counting(is_guarded)];
            ("device-rows", conditions, !is_guarded)
        }
        Job::Facing(sun, is_edge_on, way) => {
            let boxes = if is_edge_on { "edge-on" } else { "at random" };
            let silhouette = is(SILHOUETTE, way.silhouettes.name());
            let conditions = vec![under(sun), is(BOXES, boxes), by(way.interface), silhouette];
            ("facings", conditions, way.silhouettes.decides_by_corners())
        }
        Job::Device(sun, eyes, way) => {
            let faces = match way.faces {
                FacePasses::TwoSided => "two-sided",
                FacePasses::TwoPass => "two-pass",
            };
            let named = [
                by(way.interface),
                is(EXTENT, way.end.name()),
                is(RULE, way.rule_name()),
                is(FACES, faces),
                is(SCISSOR, way.cut.name()),
                is(DEPTH_BOUNDS, way.bounds_name()),
                is(SILHOUETTE, way.silhouettes.name()),
            ];
            let named = named.into_iter().chain(where_counted(way.counted()));
            ("devices", seen_under(sun, eyes, named), false)
        }
    }
}

pub(super) fn question(job: Job) -> &'static str {
    described(job).0
}

/// - `samples`: of a process, for what is timed
pub(super) fn planned(job: Job, samples: Option<u32>, brought: Option<&Brought>) -> PlannedCase {
    let (question, conditions, may_be_wrong) = described(job);
    let model = brought.map(|brought| is(MODEL, &brought.name));
    let conditions = std::iter::once(is(QUESTION, question))
        .chain(model)
        .chain(conditions);
    let samples = match job {
        Job::Silhouette(..) => samples.unwrap_or(SAMPLES),
        // Where every limit is drawn.
        Job::DeviceLamp(_, LampEye::Bridge, ..) => samples.unwrap_or(SAMPLES),
        Job::Harbour(..) | Job::DeviceMoon(Eyes::Bridge, ..) => samples.unwrap_or(SAMPLES),
        // The paper asks for seven channels.
        Job::Device(_, Eyes::At(_), _) | Job::Rival(_, Eyes::At(_), _) => 0,
        // A bias is one comparison, and costs nothing.
        Job::Map(_, _, bias) | Job::DeviceMap(_, _, bias) if bias != Bias::Constant => 0,
        Job::Map(..) => samples.unwrap_or(SAMPLES),
        job if job.is_of_device() => samples.unwrap_or(SAMPLES),
        _ => 0,
    };
    // Of a mesh that is not closed, any answer but the verdict may be wrong.
    let may_leak = brought.is_some_and(|brought| brought.policy == Policy::AsIs);
    PlannedCase {
        may_be_wrong: may_be_wrong || may_leak,
        ..planned_case(STUDY, samples, conditions, None)
    }
}
