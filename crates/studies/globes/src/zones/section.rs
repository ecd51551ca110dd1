// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on zones of a height field by counted pixels.

use super::PART;
use crate::counts::{course, why_not_settled};
use crate::metrics::{self, *};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, ChapterError, Finding};

pub(crate) const SECTION: Section<'static> = Section {
    title: "Height zones by counted pixels",
    text: "A height field of 5 × 5 zones with four levels, each with a quarter of the next one's triangles. A zone \
           becomes finer where it has more pixels a triangle than the upper threshold, and coarser where it has fewer \
           than the lower one, by counts of the frame before. Spikes between two rows of zones stand on every second \
           vertex, so that only two zones at the finest level show them; they hide all but 1/m of the zones behind. A \
           cycle needs a hysteresis below 4 m.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[
        ("counted by", COUNTED_BY),
        ("spikes, m", SPIKE_M),
        ("wanted px a triangle", WANTED),
        ("hysteresis", HYSTERESIS),
    ]),
    columns: &[
        Column::metric("m, hidden but 1/m", GLOBE_ZONE_HIDES),
        Column::metric("settled after, frames", GLOBE_COUNT_SETTLE_FRAMES).or_of(why_not_settled),
        Column::metric("triangles", GLOBE_TRIANGLES),
        Column::metric("off rays, px", GLOBE_COUNT_OFF_PX),
        Column::metric(
            "zones off by more than their edges",
            GLOBE_COUNT_WRONG_NODES,
        ),
        Column::metric("frame with counts, CPU ms", GLOBE_COUNTED_CPU_MS),
        Column::metric("without", GLOBE_UNCOUNTED_CPU_MS),
    ],
    findings: &[rest, bypass],
    more: &[courses],
    ..Section::EMPTY
};

fn hysteresis(case: &Case) -> Option<f64> {
    case.condition(HYSTERESIS).parse().ok()
}

fn rest(cases: &Cases<'_>) -> Finding {
    // Hysteresis over four times what spikes hide, and whether it cycles.
    let measured = |case: &Case| {
        let hides = case.value(GLOBE_ZONE_HIDES)?;
        let cycles = case.value(GLOBE_COUNT_CYCLES)? > 0.0;
        Some((hysteresis(case)? / (4.0 * hides) >= 1.0, cycles))
    };
    let all: Vec<(bool, bool)> = cases.iter().filter_map(measured).collect();
    let counts = [true, false].map(|is_enough| {
        let own = all.iter().filter(|(enough, _)| *enough == is_enough);
        (
            own.clone().filter(|(_, cycles)| *cycles).count(),
            own.count(),
        )
    });
    let [enough, less] = counts.map(|(cycling, of)| format!("{cycling} of {of} cycle"));
    finding(
        "With a hysteresis of 4 m or more no field of zones cycles, m what a finer level hides",
        (counts[0].1 > 0).then_some(counts[0].0 == 0),
        format!("From 4 m on {enough}; below it {less}."),
    )
}

fn bypass(cases: &Cases<'_>) -> Finding {
    let spiked = cases.fitting(|case| case.condition(SPIKE_M) != "0");
    let cycling = spiked.fitting(|case| case.value(GLOBE_COUNT_CYCLES) == Some(1.0));
    let most = cycling.iter().filter_map(hysteresis).max_by(f64::total_cmp);
    finding(
        "Gebbie & Bailey: oscillations of a spike that comes and goes bypass even large buffer thresholds",
        (!spiked.is_empty()).then(|| most.is_some_and(|hysteresis| hysteresis >= 4.0)),
        match most.zip(spiked.greatest(GLOBE_ZONE_HIDES)) {
            Some((most, hides)) => format!(
                "Here up to a hysteresis of {}; the spikes hide all but 1/{} of a zone, so one of {} stops every cycle.",
                significant(most),
                significant(hides),
                significant(4.0 * hides)
            ),
            None => "No field with spikes cycles here.".to_owned(),
        },
    )
}

fn courses(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let shown = cases.with(&[(COUNTED_BY, "histogram"), (WANTED, "3")]);
    let shown = shown.fitting(|case| ["4", "8", "64"].contains(&case.condition(HYSTERESIS)));
    let name = |case: &Case| {
        let [spikes, hysteresis] = [SPIKE_M, HYSTERESIS].map(|key| case.condition(key));
        format!("spikes {spikes} m, hysteresis {hysteresis}")
    };
    course::drawing(
        &shown,
        "Triangles of height zones frame by frame: answers to a step from the coarsest level.",
        "triangles-by-frame",
        name,
    )
}
