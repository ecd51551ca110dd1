// SPDX-License-Identifier: MIT OR Apache-2.0
//! What keeps blocks of ground: texels that differ, time to look them up, and to write a block anew.

use super::kit::{TIME, beside, gain, none_of, of_most, ratios, remark, said, time, within};
use crate::cache::Keep;
use crate::metrics::*;
use terrafill_lab::{Cases, Column, Names, Section, Select};
use terrafill_plot::number::significant;
use terrafill_results::Finding;

const WHAT_ROUNDS: &str = "Loading a texel by its number is exact everywhere. The ways named \"sampled\" give a share of the whole \
     to a sampler of nearest texels, as published for the array, and a device may round it at a border; \
     \"by world\" computes layer and share from one number for the whole ground, as if the \
     layer were found in the shader. These are asked how often they differ, on wgpu, and are not timed.";

pub(super) const SECTION: Section<'static> = Section {
    title: "What keeps blocks of ground",
    caption: "What keeps blocks of 64 × 64 texels",
    text: "Blocks of 64 × 64 texels of 32-bit floats are kept in the layers of one array texture, as published, or in \
           what else there is. Places are given as a block and a share of it, a quarter of them on a border of texels \
           or blocks or one last place beside it. A frame looks up 262,144 of them by compute, block by block or \
           anywhere. Then a block is \
           written anew and everything is looked up again. Texels are numbers of 24 bits, which must be those that \
           arithmetic of integers finds. No time was published.",
    cases: Select::With(EXPERIMENT, "cache"),
    named_by: Names::Columns(&[
        ("blocks", BLOCKS),
        ("interface", API),
        ("read", ACCESS),
        ("kept in", KEPT_IN),
    ]),
    columns: &[
        Column::metric("texels that differ", CACHE_DIFFERING),
        Column::of("time, ms", TIME),
        ratios("time ÷ that of the array", |cases, case| {
            let array = beside(cases, case, &[(KEPT_IN, Keep::Array.name())]);
            gain(Some(case), array, time(cases.clock()))
        }),
        Column::metric("held", CACHE_BYTES),
        Column::metric("CPU µs to write a block", CACHE_UPDATE_CPU_US),
        Column::metric("wall µs to write a block", CACHE_UPDATE_WALL_US),
    ],
    is_main: true,
    more: &[|_| remark(WHAT_ROUNDS)],
    ..Section::EMPTY
};

/// What is required: loaded texels are the same everywhere.
pub(super) fn requirement(cases: &Cases<'_>) -> Option<Finding> {
    let exact = Keep::LOOKED_UP.into_iter().filter(|keep| !keep.rounds());
    let exact: Vec<&str> = exact.map(Keep::name).collect();
    let own = cases.with(&[(EXPERIMENT, "cache")]);
    let own = own.fitting(|case| exact.contains(&case.condition(KEPT_IN)));
    let claim = "Whatever keeps the blocks, a loaded texel is the one by integers";
    (!own.is_empty()).then(|| none_of(claim, "texels differ", &own.values(CACHE_DIFFERING)))
}

/// What keeps the most blocks that an array holds best for random access, with the counters behind it.
pub(super) fn recommended(cases: &Cases<'_>) -> Vec<String> {
    let metric = time(cases.clock());
    let on = |api: &str| {
        let own = cases.with(&[(EXPERIMENT, "cache"), (API, api), (ACCESS, "random")]);
        let arrays = own.with(&[(KEPT_IN, Keep::Array.name())]);
        let (blocks, array) = of_most(&arrays, BLOCKS, metric)?;
        // What rounds a place to another texel is not named, however fast.
        let exact = within(&own.with(&[(BLOCKS, blocks)]), CACHE_DIFFERING, 0.0);
        let best = exact.best(metric)?;
        let array = array.first().filter(|array| array.id() != best.case.id());
        let against =
            array.map(|array| format!(", against {} ms of the array", said(array, metric)));
        Some(format!(
            "On {api} {blocks} blocks of ground are read fastest anywhere, every texel right, from: {}{} ({} ms{}); \
             writing one anew takes {} µs.",
            best.case.condition(KEPT_IN),
            best.tied_with(|case| case.condition(KEPT_IN).to_owned()),
            significant(best.value),
            against.unwrap_or_default(),
            said(best.case, CACHE_UPDATE_WALL_US),
        ))
    };
    ["wgpu", "vulkan"].into_iter().filter_map(on).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn what_is_fastest_and_has_another_texel_is_not_named() {
        let said = |differing: f64| {
            let mut made = MadeUpRun::default();
            for (keep, ms, differing) in [("array", 2.0, 0.0), ("atlas", 1.0, differing)] {
                let conditions = [
                    ("experiment", "cache"),
                    ("api", "wgpu"),
                    ("access", "random"),
                    ("kept_in", keep),
                    ("blocks", "64"),
                ];
                let case = made.case(case_id(crate::STUDY, keep, &conditions));
                case.timed("pipeline_cpu_ms", &[ms]);
                case.figure("cache_differing", differing);
            }
            recommended(&Cases::of_study(&made.loaded(), crate::STUDY)).join(" ")
        };
        assert!(said(1.0).contains("from: array"), "{}", said(1.0));
        // Negative control: with the same texels it is.
        assert!(said(0.0).contains("from: atlas"), "{}", said(0.0));
    }
}
