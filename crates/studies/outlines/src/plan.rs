// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: so many models, outlined in every way.

use crate::metrics::{MODELS, OUTLINE, STROKE_PX};
use crate::on_wgpu::Way;
use crate::session::{Outlined, opened};
use terrafill_results::condition::{API, SIZE_PX};
use terrafill_results::{ConditionKey, PlannedCase};
use terrafill_study::{CaseGroup, Depth, Group, Request, planned_case, size_name};

/// Models: all of a small port and of one of 33,340 triangles, what a run of values holds, one more, and many.
const MODELS_DRAWN: [usize; 6] = [12, 17, 254, 255, 1_000, 5_000];
const QUICK_MODELS: usize = 5;
/// Of which every width of strokes is drawn, pixels; others have the middle one.
const OF_EVERY_WIDTH: usize = 17;
const WIDTHS_PX: [u32; 3] = [1, 3, 5];
/// Pixels of a run that names no size: those of a channel, and of a quick run.
const SIZE: [u32; 2] = [512, 384];
const QUICK_SIZE: [u32; 2] = [256, 192];
/// Timed frames of a process, and of those that take a software device longer than a second.
const SAMPLES: u32 = 2;
const LONG_SAMPLES: u32 = 1;
/// Setting by which whoever renders keeps pictures.
const PICTURES: &str = "pictures";

/// A group for each number of models.
///
/// - `study`: whose cases they are
/// - `question`: the condition that tells questions apart, and this one's name
#[must_use]
pub fn planned(
    study: &'static str,
    question: (ConditionKey, &'static str),
    request: &Request,
) -> Vec<Box<dyn Group>> {
    let numbers = match request.depth {
        Depth::Quick => &MODELS_DRAWN[..QUICK_MODELS],
        _ => &MODELS_DRAWN[..],
    };
    let groups = numbers.iter().map(|models| -> Box<dyn Group> {
        let widths = match *models {
            OF_EVERY_WIDTH => &WIDTHS_PX[..],
            _ => &WIDTHS_PX[1..2],
        };
        let of = |width: &u32| Way::ALL.map(|way| (way, *width));
        let ways: Vec<(Way, u32)> = widths.iter().flat_map(of).collect();
        let size = match (request.names_size, request.depth) {
            (true, _) => request.size,
            (false, Depth::Quick) => QUICK_SIZE,
            (false, _) => SIZE,
        };
        let case = |(way, width): &(Way, u32)| {
            let is_right = matches!(way, Way::Clear | Way::Value);
            let is_long = *models > 1_000;
            let samples = if is_long { LONG_SAMPLES } else { SAMPLES };
            let samples = request.samples.unwrap_or(samples);
            let conditions = [
                (question.0, question.1.to_owned()),
                (API, terrafill_gpu::API.name.to_owned()),
                (MODELS, models.to_string()),
                (STROKE_PX, width.to_string()),
                (OUTLINE, way.name().to_owned()),
            ];
            let size = (SIZE_PX, size_name(size));
            PlannedCase {
                may_be_wrong: !is_right,
                ..planned_case(
                    study,
                    if is_right { samples } else { 0 },
                    conditions,
                    Some(size),
                )
            }
        };
        Box::new(CaseGroup {
            name: format!("{study}/{}/{models}", question.1),
            cases: ways.iter().map(case).collect(),
            warm_up: None,
            work: Outlined {
                models: *models,
                ways,
                size,
                keeps_all: request.settings.contains_key(PICTURES),
            },
            open: opened,
        })
    });
    groups.collect()
}
