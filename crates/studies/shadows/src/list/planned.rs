// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a case is called, its conditions, and whether being wrong is what it is to show.

use crate::STUDY;
use crate::brought::Brought;
use crate::count::Rule;
use crate::job::{Job, Method, sun_name};
use crate::near::EyeTest;
use crate::outline::Way;
use crate::views::Chooser;
use crate::way::{Counting, Positions};
use crate::work::Scissor;
use terrafill_casters::Policy;
use terrafill_fill::FacePasses;
use terrafill_results::{CaseId, PlannedCase};

fn counting(is_guarded: bool) -> &'static str {
    match is_guarded {
        true => "passes of 255",
        false => "8 bits, wrapping",
    }
}

pub(super) fn planned(job: Job, samples: u32, brought: Option<&Brought>) -> PlannedCase {
    let (question, conditions, may_be_wrong): (_, Vec<(&str, String)>, _) = match job {
        Job::Model => ("model", Vec::new(), false),
        Job::Eye(sun, near, test) => (
            "eyes",
            vec![
                ("sun", sun_name(sun)),
                ("near_m", near.to_string()),
                ("eye_test", test.name().to_owned()),
            ],
            test == EyeTest::Eye,
        ),
        Job::Updates(sun, end, rule) => (
            "updates",
            vec![
                ("sun", sun_name(sun)),
                ("extent", end.name().to_owned()),
                ("rule", rule.name().to_owned()),
            ],
            rule == Rule::PassAsPrinted,
        ),
        Job::Scissor(sun, scissor) => (
            "scissors",
            vec![
                ("sun", sun_name(sun)),
                ("scissor", scissor.name().to_owned()),
            ],
            !matches!(scissor, Scissor::Off | Scissor::CasterRectangle),
        ),
        Job::Bounds(sun, rule) => (
            "bounds",
            vec![
                ("sun", sun_name(sun)),
                ("rule", rule.name().to_owned()),
                ("depth_bounds", "on".to_owned()),
            ],
            false,
        ),
        Job::Finite(sun, length) => (
            "finite",
            vec![("sun", sun_name(sun)), ("length_m", length.to_string())],
            true,
        ),
        Job::Row(count, guard) => (
            "rows",
            vec![
                ("casters", count.to_string()),
                ("counting", counting(guard).to_owned()),
            ],
            !guard,
        ),
        Job::Casters(policy) => (
            "casters",
            vec![("policy", policy.name().to_owned())],
            policy == Policy::AsIs,
        ),
        Job::Outline(count, way) => (
            "outlines",
            vec![
                ("models", count.to_string()),
                ("outline", way.name().to_owned()),
            ],
            matches!(way, Way::ValueAsPrinted | Way::ValueNeverCleared),
        ),
        Job::Silhouette(mesh, method) => (
            "silhouettes",
            match brought {
                Some(_) => vec![("silhouette", method.name().to_owned())],
                None => vec![
                    ("mesh", mesh.to_owned()),
                    ("silhouette", method.name().to_owned()),
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
                ("sun", sun_name(sun)),
                ("texel_m", texel.to_string()),
                ("bias", bias.name().to_owned()),
            ],
            true,
        ),
        Job::View(sun, place, chooser) => (
            "views",
            vec![
                ("sun", sun_name(sun)),
                ("view", place.name().to_owned()),
                ("rule", chooser.name()),
            ],
            matches!(
                chooser,
                Chooser::All(Rule::Pass) | Chooser::Test(EyeTest::Eye)
            ),
        ),
        Job::Rival(sun, rival) => (
            "rivals",
            vec![
                ("sun", sun_name(sun)),
                ("api", rival.api().to_owned()),
                ("rival", rival.name().to_owned()),
            ],
            false,
        ),
        Job::Rung(sun, rung) => (
            "ladder",
            vec![
                ("sun", sun_name(sun)),
                ("api", rung.way.interface.name().to_owned()),
                ("step", format!("{} {}", rung.number, rung.name)),
                ("paper", rung.paper.to_owned()),
            ],
            false,
        ),
        Job::Origin(sun, eyes, way) => (
            "origins",
            vec![
                ("sun", sun_name(sun)),
                ("view", eyes.name().to_owned()),
                ("api", way.interface.name().to_owned()),
                ("positions", way.positions.name()),
            ],
            way.positions != Positions::Eye,
        ),
        Job::Near(sun, way) => {
            let may_be_wrong = match way.counting {
                Counting::Casters => way.rule == Rule::Pass,
                counting => counting == Counting::Chosen(EyeTest::Eye),
            };
            let conditions = vec![
                ("sun", sun_name(sun)),
                ("api", way.interface.name().to_owned()),
                ("rule", way.rule_name()),
            ];
            ("near", conditions, may_be_wrong)
        }
        Job::DeviceRow(count, way) => {
            let is_guarded = way.counting == Counting::Parts { is_guarded: true };
            let conditions = vec![
                ("casters", count.to_string()),
                ("api", way.interface.name().to_owned()),
                ("counting", counting(is_guarded).to_owned()),
            ];
            ("device-rows", conditions, !is_guarded)
        }
        Job::Facing(sun, is_edge_on, way) => (
            "facings",
            vec![
                ("sun", sun_name(sun)),
                (
                    "boxes",
                    if is_edge_on { "edge-on" } else { "at random" }.to_owned(),
                ),
                ("api", way.interface.name().to_owned()),
                ("silhouette", way.silhouettes.name().to_owned()),
            ],
            way.silhouettes.decides_by_corners(),
        ),
        Job::Device(sun, way) => {
            let faces = match way.faces {
                FacePasses::TwoSided => "two-sided",
                FacePasses::TwoPass => "two-pass",
            };
            let conditions = [
                ("sun", sun_name(sun)),
                ("api", way.interface.name().to_owned()),
                ("extent", way.end.name().to_owned()),
                ("rule", way.rule_name()),
                ("faces", faces.to_owned()),
                ("scissor", way.cut.name().to_owned()),
                ("depth_bounds", way.bounds_name()),
                ("silhouette", way.silhouettes.name().to_owned()),
            ];
            ("devices", conditions.into(), false)
        }
    };
    let model = brought.map(|brought| ("model", brought.name.clone()));
    let conditions: Vec<(&str, String)> = model.into_iter().chain(conditions).collect();
    let values: Vec<&str> = conditions.iter().map(|(_, value)| value.as_str()).collect();
    let name = format!("{question}/{}", values.join("/"));
    let conditions = std::iter::once(("question", question.to_owned())).chain(conditions.clone());
    // Of a mesh that is not closed, any answer but the verdict may be wrong.
    let may_leak = brought.is_some_and(|brought| brought.policy == Policy::AsIs);
    PlannedCase {
        id: CaseId::new(STUDY, name, conditions),
        samples,
        may_be_wrong: may_be_wrong || may_leak,
    }
}
