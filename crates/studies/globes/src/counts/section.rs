// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on level of detail by counted pixels.

use super::course::drawing;
use super::{ENOUGH, PART};
use crate::clock::compared_in;
use crate::metrics::{self, *};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_results::{Block, Case, ChapterError, Claim, Finding, Scope};

pub(crate) const SECTION: Section<'static> = Section {
    title: "Level of detail by counted pixels",
    text: "A picture of 40° × 40° below the eye is drawn by the leaves of a quadtree, each with 64² texels and 10 × 10 \
           sub-quads, the nearest first. A leaf splits where it has more pixels than the upper threshold and four merge \
           where all have fewer than the lower one. Hysteresis is the one over the other, delay the frames from \
           drawing to using a count. On Vulkan counts are precise occlusion queries, one a node. WebGPU's queries say \
           no more than zero or not, so on wgpu a compute pass counts a target of node numbers. Counts of the first \
           and the last frame are held against rays in f64: a node may be off by the pixels at its edge.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[
        ("path", PATH),
        ("counted by", COUNTED_BY),
        ("hysteresis", HYSTERESIS),
        ("delay", DELAY),
        ("transfers a frame", TRANSFERS),
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
        Column::metric("paging, CPU ms", GLOBE_COUNT_PAGE_CPU_MS),
        Column::metric("largest", GLOBE_COUNT_PAGE_MAX_CPU_MS),
    ],
    findings: &[exact, cycles, transfers],
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
        let capped = match case.condition(TRANSFERS) {
            "any" => String::new(),
            capped => format!(", {capped} transfer"),
        };
        let [path, hysteresis] = [PATH, HYSTERESIS].map(|key| case.condition(key));
        format!("{path}, hysteresis {hysteresis}{capped}")
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

/// With any number of transfers against one, counted either way.
fn transfers(cases: &Cases<'_>) -> Finding {
    let pairs = cases
        .with(&[(PATH, "zoom")])
        .pairs(TRANSFERS, ["any", "1"], &[]);
    cases.compared(
        &compared_in(TRANSFERS, GLOBE_COUNT_PAGE_MAX_CPU_MS, Scope::UPLOAD),
        &pairs,
        Claim::Faster,
        "Gebbie & Bailey: one transfer an update smooths its spikes, the largest paging of a frame in the zoom",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::Standing;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn spikes_within_the_noise_decide_nothing() {
        // A repeat takes 10 % longer than what it repeats.
        let standing = |any: f64, one: f64| {
            let mut run = MadeUpRun::default();
            for (transfers, ms) in [("any", any), ("1", one)] {
                let conditions = [("part", PART), ("path", "zoom"), ("transfers", transfers)];
                let id = case_id(crate::STUDY, transfers, &conditions);
                let metric = GLOBE_COUNT_PAGE_MAX_CPU_MS;
                run.case(id.repeat()).timed(metric, &[1.1 * ms; 5]);
                run.case(id).timed(metric, &[ms; 5]);
            }
            transfers(&Cases::of_study(&run.loaded(), crate::STUDY)).standing
        };
        assert_eq!(standing(1.05, 1.0), Standing::NoDifference);
        assert_eq!(standing(1.0, 1.05), Standing::NoDifference);
        // Controls: beyond it, either way.
        assert_eq!(standing(2.0, 1.0), Standing::Holds);
        assert_eq!(standing(1.0, 2.0), Standing::DoesNotHold);
    }
}
