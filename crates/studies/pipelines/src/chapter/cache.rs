// SPDX-License-Identifier: MIT OR Apache-2.0
//! What keeps blocks of ground: texels that differ, time to look them up, and to write a block anew.

use super::cells::{byte_cell, gain, headings, of, paired_finding, time, time_cell, values, why};
use crate::cache::Keep;
use crate::keys::{
    ACCESS, API, BLOCKS, CACHE_BINDS, CACHE_BYTES, CACHE_DIFFERING, CACHE_UPDATE_CPU_US,
    CACHE_UPDATE_WALL_US, EXPERIMENT, KEPT_IN,
};
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Block, Case, Cell, Claim, Clock, Finding, Row, Run, Scope, Standing, Table,
};

/// Fewest blocks from which an array is claimed to win.
const LEAST_CLAIMED: u32 = 64;

const WHAT_IS_COMPARED: &str = "Blocks of 64 × 64 texels of 32-bit floats are kept in the layers of one array texture, as published, or in \
     what else there is. Places are given as a block and a share of it, a quarter of them on a border \
     of texels or blocks or one last place beside it. A frame looks up 262,144 of them by compute, on Vulkan with a \
     barrier between the dispatches of blocks that are bound in turn, block by block or anywhere; then a block is written anew and everything is looked up again. Texels \
     are numbers of 24 bits, which must be those that arithmetic of integers finds. No time was published.";
const WHAT_ROUNDS: &str = "Loading a texel by its number is exact everywhere. The ways named \"sampled\" give a share of the whole \
     to a sampler of nearest texels, as published for the array, and a device may round it at a border; \
     \"by world\" computes layer and share from one number for the whole ground, as if the \
     layer were found in the shader. These are asked how often they differ, on wgpu, and are not timed.";

fn own<'a>(cases: &[&'a Case]) -> Vec<&'a Case> {
    of(cases, &[(EXPERIMENT, "cache")])
}

const INTERFACES: [&str; 2] = ["wgpu", "vulkan"];

fn one<'a>(
    cases: &[&'a Case],
    api: &str,
    keep: Keep,
    access: &str,
    blocks: u32,
) -> Option<&'a Case> {
    let blocks = blocks.to_string();
    let conditions = [
        (API, api),
        (KEPT_IN, keep.name()),
        (ACCESS, access),
        (BLOCKS, blocks.as_str()),
    ];
    of(cases, &conditions).first().copied()
}

pub(super) fn section(cases: &[&Case], run: &Run) -> Vec<Block> {
    let clock = run.clock();
    let own = own(cases);
    if own.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![
        Block::section("What keeps blocks of ground"),
        Block::Text(WHAT_IS_COMPARED.to_owned()),
    ];
    blocks.extend(claims(&own, run).into_iter().map(Block::Finding));
    blocks.push(Block::Table(table(&own, clock)));
    blocks.push(Block::Remark(WHAT_ROUNDS.to_owned()));
    blocks
}

/// What is required: loaded texels are the same everywhere.
pub(super) fn findings(cases: &[&Case]) -> Vec<Finding> {
    let own = own(cases);
    if own.is_empty() {
        return Vec::new();
    }
    let exact = Keep::ALL.into_iter().filter(|keep| !keep.rounds());
    let exact = exact.flat_map(|keep| of(&own, &[(KEPT_IN, keep.name())]));
    let differing: Vec<f64> = exact
        .filter_map(|case| case.value(CACHE_DIFFERING))
        .collect();
    let most = differing.iter().copied().max_by(f64::total_cmp);
    vec![Finding {
        claim: "Whatever keeps the blocks, a loaded texel is the one by integers:".to_owned(),
        standing: most.map_or(Standing::NotMeasured, |most| {
            Standing::holds_if(most <= 0.0)
        }),
        because: most.map_or_else(String::new, |most| {
            format!("at most {most} texels differ in {} cases", differing.len())
        }),
    }]
}

fn claims(cases: &[&Case], run: &Run) -> Vec<Finding> {
    let on = |api: &str| {
        let mut pairs: Vec<[&Case; 2]> = Vec::new();
        for blocks in values(cases, BLOCKS)
            .into_iter()
            .filter(|blocks| *blocks >= LEAST_CLAIMED)
        {
            for access in ["coherent", "random"] {
                let case = |keep| one(cases, api, keep, access, blocks);
                pairs.extend(
                    case(Keep::Rebound)
                        .zip(case(Keep::Array))
                        .map(<[&Case; 2]>::from),
                );
            }
        }
        let claim = format!(
            "On {api} one array texture bound once is faster than a texture bound for each block, from 64 blocks on \
             (published in words):"
        );
        paired_finding(
            run,
            (KEPT_IN, &[]),
            (time(run.clock()), Scope::DRAW),
            &pairs,
            (claim, Claim::Faster),
        )
    };
    INTERFACES.into_iter().map(on).collect()
}

/// What keeps the most blocks best for random access, with the counters behind it.
pub(super) fn recommended(cases: &[&Case], clock: Clock) -> Vec<String> {
    let on = |api| recommended_on(cases, api, clock);
    INTERFACES.into_iter().filter_map(on).collect()
}

fn recommended_on(cases: &[&Case], api: &str, clock: Clock) -> Option<String> {
    let own = of(&own(cases), &[(API, api)]);
    let timed = own
        .into_iter()
        .filter(|case| case.counts() && case.value(time(clock)).is_some());
    let timed: Vec<&Case> = timed.collect();
    // The most blocks that an array holds.
    let arrays = of(&timed, &[(KEPT_IN, Keep::Array.name()), (ACCESS, "random")]);
    let blocks = *values(&arrays, BLOCKS).last()?;
    let of_most = of(&timed, &[(BLOCKS, &blocks.to_string()), (ACCESS, "random")]);
    let ms = |case: &&Case| case.value(time(clock)).unwrap_or(f64::INFINITY);
    let best = of_most
        .iter()
        .copied()
        .min_by(|a, b| ms(a).total_cmp(&ms(b)))?;
    let array = arrays
        .into_iter()
        .find(|case| case.condition(BLOCKS) == blocks.to_string());
    let against = array
        .filter(|array| array.id() != best.id())
        .map(|array| format!(", against {} ms of the array", significant(ms(&array))));
    let binds = best.value(CACHE_BINDS).map(significant).unwrap_or_default();
    let update = best
        .value(CACHE_UPDATE_WALL_US)
        .map(significant)
        .unwrap_or_default();
    Some(format!(
        "On {api} {blocks} blocks of ground are read fastest anywhere from: {} ({} ms, {binds} bind groups{}); writing \
         one anew takes {update} µs.",
        best.condition(KEPT_IN),
        significant(ms(&best)),
        against.unwrap_or_default(),
    ))
}

fn table(cases: &[&Case], clock: Clock) -> Table {
    let mut rows = Vec::new();
    for blocks in values(cases, BLOCKS) {
        let accesses = ["coherent", "random"];
        let asked = INTERFACES
            .iter()
            .flat_map(|api| accesses.map(|access| (*api, access)));
        for (api, access) in asked {
            for keep in Keep::ALL {
                let Some(case) = one(cases, api, keep, access, blocks) else {
                    continue;
                };
                let figure =
                    |metric| Cell::or_absent(case.value(metric).map(significant), why(case));
                let array = one(cases, api, Keep::Array, access, blocks);
                let ratio = gain(Some(case), array, time(clock));
                rows.push(Row {
                    cells: vec![
                        Cell::plain(blocks.to_string()),
                        Cell::name(api),
                        Cell::name(access),
                        Cell::name(keep.name()),
                        figure(CACHE_DIFFERING),
                        time_cell(case, time(clock)),
                        Cell::or_absent(ratio.as_ref().map(times), why(case)),
                        figure(CACHE_BINDS),
                        byte_cell(case, CACHE_BYTES),
                        time_cell(case, CACHE_UPDATE_CPU_US),
                        time_cell(case, CACHE_UPDATE_WALL_US),
                    ],
                    status: case.outcome.name().to_owned(),
                    remark: case.reason.clone(),
                });
            }
        }
    }
    Table {
        caption: "What keeps blocks of 64 × 64 texels".to_owned(),
        headings: headings(&[
            ("blocks", None),
            ("interface", None),
            ("read", None),
            ("kept in", None),
            ("texels that differ", Some(CACHE_DIFFERING)),
            ("time, ms", Some(time(clock))),
            ("time ÷ that of the array", None),
            ("bind groups", Some(CACHE_BINDS)),
            ("held", Some(CACHE_BYTES)),
            ("CPU µs to write a block", Some(CACHE_UPDATE_CPU_US)),
            ("wall µs to write a block", Some(CACHE_UPDATE_WALL_US)),
        ]),
        rows,
        is_main: true,
        ..Table::default()
    }
}
