// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on level of detail by counted pixels.

use super::course::drawing;
use super::{ENOUGH, PART};
use crate::metrics::{self, *};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_results::{Block, Case, ChapterError, Finding};

pub(crate) const SECTION: Section<'static> = Section {
    title: "Level of detail by counted pixels",
    text: "A picture of 40° × 40° below the eye is drawn by the leaves of a quadtree, each with 64² texels and 10 × 10 \
           sub-quads, the nearest first. A leaf splits where it has more pixels than the upper threshold and four merge \
           where all have fewer than the lower one. Hysteresis is the one over the other, delay the frames from \
           drawing to using a count. On Vulkan counts are precise occlusion queries, one a node. WebGPU's queries say \
           no more than zero or not, so on wgpu a compute pass counts a target of node numbers. Counts of the first \
           and the last frame are held against rays in f64: a node may be off by the pixels at its edge. \
           What reading and sending its pictures costs is a question of the study paging.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[
        ("path", PATH),
        ("counted by", COUNTED_BY),
        ("hysteresis", HYSTERESIS),
        ("delay", DELAY),
    ]),
    columns: &[
        Column::metric("settled after, frames", GLOBE_COUNT_SETTLE_FRAMES).or_of(why_not_settled),
        Column::metric("leaves", GLOBE_COUNT_LEAVES),
        Column::metric("texels a pixel", GLOBE_COUNT_TEXELS_PER_PX),
        Column::metric("off rays, px", GLOBE_COUNT_OFF_PX),
        Column::metric(
            "nodes off by more than their edges",
            GLOBE_COUNT_WRONG_NODES,
        ),
        Column::metric("frame with counts, CPU ms", GLOBE_COUNTED_CPU_MS),
        Column::metric("without", GLOBE_UNCOUNTED_CPU_MS),
    ],
    findings: &[exact, cycles],
    more: &[courses],
    ..Section::EMPTY
};

/// Of a loop that has no frame after which nothing changes.
pub(crate) fn why_not_settled(case: &Case) -> &'static str {
    match case.value(GLOBE_COUNT_CYCLES) {
        Some(1.0) => "it does not settle",
        _ => "the eye moves, or it was not measured",
    }
}

fn courses(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let shown = cases.with(&[(COUNTED_BY, "histogram"), (DELAY, "1")]);
    let shown = shown.fitting(|case| ["1", "4"].contains(&case.condition(HYSTERESIS)));
    let name = |case: &Case| {
        let [path, hysteresis] = [PATH, HYSTERESIS].map(|key| case.condition(key));
        format!("{path}, hysteresis {hysteresis}")
    };
    drawing(
        &shown,
        "Leaves of quadtrees frame by frame, counts used one frame late.",
        "leaves",
        name,
    )
}

fn exact(cases: &Cases<'_>) -> Finding {
    let words = ["histogram", "queries"].map(|way| {
        let own = cases.with(&[(COUNTED_BY, way)]);
        match own
            .sum(GLOBE_COUNT_WRONG_NODES)
            .zip(own.sum(GLOBE_COUNT_NODES))
        {
            Some((wrong, of)) => {
                format!("{way}: {wrong} of {of} nodes off by more than their edges")
            }
            None => format!("{way}: not measured"),
        }
    });
    finding(
        "Counts by precise queries and by a histogram of node numbers are the pixels that rays see",
        cases.sum(GLOBE_COUNT_WRONG_NODES).map(|wrong| wrong == 0.0),
        format!("{}.", words.join("; ")),
    )
}

fn cycles(cases: &Cases<'_>) -> Finding {
    let still = cases.fitting(|case| case.value(GLOBE_COUNT_CYCLES).is_some());
    let cycling = |own: &Cases<'_>| own.sum(GLOBE_COUNT_CYCLES).unwrap_or(0.0);
    let all = still.by(HYSTERESIS);
    let words: Vec<String> = all
        .iter()
        .map(|(share, own)| format!("{share}: {} of {}", cycling(own), own.iter().count()))
        .collect();
    let is_enough = |share: &str| share.parse().is_ok_and(|share: f64| share >= ENOUGH);
    let mut enough = all.iter().filter(|(share, _)| is_enough(share)).peekable();
    let is_known = enough.peek().is_some();
    finding(
        "With a hysteresis of 4 or more no quadtree cycles in a view that stands still",
        is_known.then(|| enough.all(|(_, own)| cycling(own) == 0.0)),
        format!("Never at rest by hysteresis: {}.", words.join("; ")),
    )
}
