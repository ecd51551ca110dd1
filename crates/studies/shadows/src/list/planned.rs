// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a case is called, its conditions, and whether being wrong is what it is to show.

use crate::STUDY;
use crate::brought::Brought;
use crate::count::Rule;
use crate::job::{Job, Method, sun_name};
use crate::keys::{
    API, BIAS, BOXES, CASTERS, COUNTING, DEPTH_BOUNDS, EXTENT, EYE_TEST, FACES, LENGTH_M, MESH,
    MODEL, MODELS, NEAR_M, OUTLINE, PAPER, POLICY, POSITIONS, QUESTION, RIVAL, RULE, SCISSOR,
    SILHOUETTE, STEP, SUN, TEXEL_M, VIEW,
};
use crate::near::EyeTest;
use crate::outline::Way;
use crate::views::Chooser;
use crate::way::{Counting, Positions};
use crate::work::Scissor;
use terrafill_casters::Policy;
use terrafill_fill::FacePasses;
use terrafill_results::{CaseId, ConditionKey, PlannedCase};

fn counting(is_guarded: bool) -> &'static str {
    match is_guarded {
        true => "passes of 255",
        false => "8 bits, wrapping",
    }
}

pub(super) fn planned(job: Job, samples: u32, brought: Option<&Brought>) -> PlannedCase {
    let (question, conditions, may_be_wrong): (_, Vec<(ConditionKey, String)>, _) = match job {
        Job::Model => ("model", Vec::new(), false),
        Job::Eye(sun, near, test) => (
            "eyes",
            vec![
                (SUN, sun_name(sun)),
                (NEAR_M, near.to_string()),
                (EYE_TEST, test.name().to_owned()),
            ],
            test == EyeTest::Eye,
        ),
        Job::Updates(sun, end, rule) => (
            "updates",
            vec![
                (SUN, sun_name(sun)),
                (EXTENT, end.name().to_owned()),
                (RULE, rule.name().to_owned()),
            ],
            rule == Rule::PassAsPrinted,
        ),
        Job::Scissor(sun, scissor) => (
            "scissors",
            vec![(SUN, sun_name(sun)), (SCISSOR, scissor.name().to_owned())],
            !matches!(scissor, Scissor::Off | Scissor::CasterRectangle),
        ),
        Job::Bounds(sun, rule) => (
            "bounds",
            vec![
                (SUN, sun_name(sun)),
                (RULE, rule.name().to_owned()),
                (DEPTH_BOUNDS, "on".to_owned()),
            ],
            false,
        ),
        Job::Finite(sun, length) => (
            "finite",
            vec![(SUN, sun_name(sun)), (LENGTH_M, length.to_string())],
            true,
        ),
        Job::Row(count, guard) => (
            "rows",
            vec![
                (CASTERS, count.to_string()),
                (COUNTING, counting(guard).to_owned()),
            ],
            !guard,
        ),
        Job::Casters(policy) => (
            "casters",
            vec![(POLICY, policy.name().to_owned())],
            policy == Policy::AsIs,
        ),
        Job::Outline(count, way) => (
            "outlines",
            vec![
                (MODELS, count.to_string()),
                (OUTLINE, way.name().to_owned()),
            ],
            matches!(way, Way::ValueAsPrinted | Way::ValueNeverCleared),
        ),
        Job::Silhouette(mesh, method) => (
            "silhouettes",
            match brought {
                Some(_) => vec![(SILHOUETTE, method.name().to_owned())],
                None => vec![
                    (MESH, mesh.to_owned()),
                    (SILHOUETTE, method.name().to_owned()),
                ],
            },
            mesh.contains("turned") && method != Method::Adjacency,
        ),
        Job::Map(sun, texel, bias) | Job::DeviceMap(sun, texel, bias) => (
            if matches!(job, Job::Map(..)) {
                "maps"
            } else {
                "device-maps"
            },
            vec![
                (SUN, sun_name(sun)),
                (TEXEL_M, texel.to_string()),
                (BIAS, bias.name().to_owned()),
            ],
            true,
        ),
        Job::View(sun, place, chooser) => (
            "views",
            vec![
                (SUN, sun_name(sun)),
                (VIEW, place.name().to_owned()),
                (RULE, chooser.name()),
            ],
            matches!(
                chooser,
                Chooser::All(Rule::Pass) | Chooser::Test(EyeTest::Eye)
            ),
        ),
        Job::Rival(sun, rival) => (
            "rivals",
            vec![
                (SUN, sun_name(sun)),
                (API, rival.api().to_owned()),
                (RIVAL, rival.name().to_owned()),
            ],
            false,
        ),
        Job::Rung(sun, rung) => (
            "ladder",
            vec![
                (SUN, sun_name(sun)),
                (API, rung.way.interface.name().to_owned()),
                (STEP, format!("{} {}", rung.number, rung.name)),
                (PAPER, rung.paper.to_owned()),
            ],
            false,
        ),
        Job::Origin(sun, eyes, way) => (
            "origins",
            vec![
                (SUN, sun_name(sun)),
                (VIEW, eyes.name().to_owned()),
                (API, way.interface.name().to_owned()),
                (POSITIONS, way.positions.name()),
            ],
            way.positions != Positions::Eye,
        ),
        Job::Near(sun, way) => {
            let may_be_wrong = match way.counting {
                Counting::Casters => way.rule == Rule::Pass,
                counting => counting == Counting::Chosen(EyeTest::Eye),
            };
            let conditions = vec![
                (SUN, sun_name(sun)),
                (API, way.interface.name().to_owned()),
                (RULE, way.rule_name()),
            ];
            ("near", conditions, may_be_wrong)
        }
        Job::DeviceRow(count, way) => {
            let is_guarded = way.counting == Counting::Parts { is_guarded: true };
            let conditions = vec![
                (CASTERS, count.to_string()),
                (API, way.interface.name().to_owned()),
                (COUNTING, counting(is_guarded).to_owned()),
            ];
            ("device-rows", conditions, !is_guarded)
        }
        Job::Facing(sun, is_edge_on, way) => (
            "facings",
            vec![
                (SUN, sun_name(sun)),
                (
                    BOXES,
                    if is_edge_on { "edge-on" } else { "at random" }.to_owned(),
                ),
                (API, way.interface.name().to_owned()),
                (SILHOUETTE, way.silhouettes.name().to_owned()),
            ],
            way.silhouettes.decides_by_corners(),
        ),
        Job::Device(sun, way) => {
            let faces = match way.faces {
                FacePasses::TwoSided => "two-sided",
                FacePasses::TwoPass => "two-pass",
            };
            let conditions = [
                (SUN, sun_name(sun)),
                (API, way.interface.name().to_owned()),
                (EXTENT, way.end.name().to_owned()),
                (RULE, way.rule_name()),
                (FACES, faces.to_owned()),
                (SCISSOR, way.cut.name().to_owned()),
                (DEPTH_BOUNDS, way.bounds_name()),
                (SILHOUETTE, way.silhouettes.name().to_owned()),
            ];
            ("devices", conditions.into(), false)
        }
    };
    let model = brought.map(|brought| (MODEL, brought.name.clone()));
    let conditions: Vec<(ConditionKey, String)> = model.into_iter().chain(conditions).collect();
    let values: Vec<&str> = conditions.iter().map(|(_, value)| value.as_str()).collect();
    let name = format!("{question}/{}", values.join("/"));
    let conditions = std::iter::once((QUESTION, question.to_owned())).chain(conditions.clone());
    // Of a mesh that is not closed, any answer but the verdict may be wrong.
    let may_leak = brought.is_some_and(|brought| brought.policy == Policy::AsIs);
    PlannedCase {
        id: CaseId::new(STUDY, name, conditions),
        samples,
        may_be_wrong: may_be_wrong || may_leak,
    }
}
