// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: blocks by their number, what keeps them, and the order in which they are read.

use super::keep::Keep;
use super::keeps::Keeps;
use super::queries::{Access, Blocks, SIDE, TexelQuery, answer, queries};
use super::{on_vulkan, on_wgpu};
use crate::STUDY;
use crate::keys::{self, ACCESS, API, EXPERIMENT, KEPT_IN};
use crate::way::Interface;
use std::collections::BTreeMap;
use std::ops::Range;
use terrafill_results::Verdict;
use terrafill_study::{
    CaseGroup, CaseSession, Context, Failure, Figures, Group, Measures, judged, planned_case,
    verified,
};

/// Blocks; the last is above what array textures usually allow.
const BLOCKS: [u32; 6] = [1, 16, 64, 256, 1_024, 4_096];
const QUICK_BLOCKS: [u32; 2] = [16, 64];
/// Texels looked up in a frame, those of a picture of 512 × 512.
const QUERIES: u32 = 1 << 18;
const QUICK_QUERIES: u32 = 1 << 14;
/// Blocks written in a timed sample, each waited for.
const UPDATES: u32 = 8;

/// What is kept and how it is read.
#[derive(Debug, Clone, Copy)]
struct CacheCase {
    interface: Interface,
    keep: Keep,
    blocks: Blocks,
    access: Access,
    queries: u32,
}

fn cases(is_quick: bool) -> Vec<CacheCase> {
    let counts: &[u32] = if is_quick { &QUICK_BLOCKS } else { &BLOCKS };
    let mut cases = Vec::new();
    for &count in counts {
        for access in Access::ALL {
            let on = |interface| Keep::ALL.map(|keep| (interface, keep));
            let all = Interface::ALL.into_iter().flat_map(on);
            // What rounds is asked about once.
            let asked = all.filter(|(on, keep)| *on == Interface::Wgpu || !keep.rounds());
            cases.extend(asked.map(|(interface, keep)| CacheCase {
                interface,
                keep,
                blocks: Blocks::new(count),
                access,
                queries: if is_quick { QUICK_QUERIES } else { QUERIES },
            }));
        }
    }
    cases
}

/// Blocks kept by all that can.
pub(crate) fn group(is_quick: bool, samples: u32) -> impl Group {
    group_of(cases(is_quick), samples)
}

fn group_of(cases: Vec<CacheCase>, samples: u32) -> CaseGroup<Vec<CacheCase>> {
    let case = |case: &CacheCase| {
        let conditions = vec![
            (EXPERIMENT, "cache".to_owned()),
            (API, case.interface.name().to_owned()),
            (KEPT_IN, case.keep.name().to_owned()),
            (ACCESS, case.access.name().to_owned()),
            (keys::BLOCKS, case.blocks.count().to_string()),
        ];
        let mut planned = planned_case(STUDY, samples, conditions, None);
        planned.may_be_wrong = case.keep.rounds();
        planned
    };
    CaseGroup {
        name: format!("{STUDY}/cache"),
        cases: cases.iter().map(case).collect(),
        warm_up: None,
        work: cases,
        open: |group, context| {
            Ok(Box::new(CaseSession(CacheSession {
                group,
                context,
                opened: BTreeMap::new(),
            })))
        },
    }
}

struct CacheSession<'a> {
    group: &'a CaseGroup<Vec<CacheCase>>,
    context: Context<'a>,
    /// By case.
    opened: BTreeMap<usize, Opened>,
}

struct Opened {
    cache: Box<dyn Keeps>,
    /// How often a block was written.
    version: u32,
}

/// Queries sorted by block, and the range of each block.
fn by_block(blocks: Blocks, queries: &mut [TexelQuery]) -> Vec<Range<u32>> {
    let number = |query: &TexelQuery| query.block[1] * blocks.across + query.block[0];
    // Those of a block stay in their order.
    queries.sort_by_key(number);
    let mut start = 0_u32;
    let range = |block: u32| {
        let own = queries[start as usize..].iter();
        #[allow(
            clippy::cast_possible_truncation,
            reason = "queries are counted in u32"
        )]
        let count = own.take_while(|query| number(query) == block).count() as u32;
        let range = start..start + count;
        start += count;
        range
    };
    (0..blocks.count()).map(range).collect()
}

/// Answers that are not the texel's.
fn differing(
    blocks: Blocks,
    queries: &[TexelQuery],
    found: &[f32],
    versions: impl Fn(u32) -> u32,
) -> usize {
    let pairs = queries.iter().zip(found);
    let wrong = pairs.filter(|(query, found)| answer(blocks, query, &versions) != **found);
    wrong.count() + queries.len().abs_diff(found.len())
}

impl CacheCase {
    fn open(
        self,
        context: Context<'_>,
        asked: &mut [TexelQuery],
    ) -> Result<Box<dyn Keeps>, Failure> {
        let Self { keep, blocks, .. } = self;
        let ranges = match keep {
            Keep::Rebound => by_block(blocks, asked),
            _ => std::iter::once(0..self.queries).collect(),
        };
        Ok(match self.interface {
            Interface::Wgpu => {
                let gpu = terrafill_gpu::shared_gpu(context.devices)?;
                Box::new(on_wgpu::Cache::new(&gpu, keep, blocks, asked, &ranges)?)
            }
            Interface::Vulkan => {
                let gpu = terrafill_vulkan::shared_gpu(context.devices)?;
                Box::new(on_vulkan::Cache::new(&gpu, keep, blocks, asked, &ranges)?)
            }
        })
    }
}

impl Measures for CacheSession<'_> {
    /// Looks everything up, writes a block anew, and looks everything up again.
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let asked_for = self.group.work[case];
        let blocks = asked_for.blocks;
        let mut asked = queries(blocks, asked_for.access, asked_for.queries);
        let cache = asked_for.open(self.context, &mut asked)?;
        cache.look_up()?;
        let mut wrong = differing(blocks, &asked, &cache.read()?, |_| 0);
        let changed = blocks.count() / 2;
        cache.update(changed, &Blocks::texels(changed, 1))?;
        cache.look_up()?;
        let versions = |block| u32::from(block == changed);
        wrong += differing(blocks, &asked, &cache.read()?, versions);
        let binds = cache.binds();
        if self.group.cases[case].samples > 0 {
            self.opened.insert(case, Opened { cache, version: 1 });
        }
        let asked = 2 * asked_for.queries;
        let block_bytes = f64::from(4 * SIDE * SIDE);
        let reason = match wrong {
            0 => String::new(),
            _ => format!("{wrong} of {asked} texels are not those by integers"),
        };
        let figures = vec![
            ("cache_differing", wrong as f64),
            ("cache_asked", f64::from(asked)),
            ("cache_binds", binds as f64),
            ("cache_bytes", f64::from(blocks.count()) * block_bytes),
            ("cache_update_bytes", block_bytes),
        ];
        Ok(judged(reason, figures, Vec::new()))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let blocks = self.group.work[case].blocks;
        let opened = verified(&mut self.opened, case)?;
        let mut figures = opened.cache.look_up()?.figures();
        let (mut cpu_ms, mut wall_ms) = (0.0, 0.0);
        for update in 0..UPDATES {
            opened.version += 1;
            let block = update % blocks.count();
            let texels = Blocks::texels(block, opened.version);
            let times = opened.cache.update(block, &texels)?;
            cpu_ms += times.cpu_ms;
            wall_ms += times.wall_ms;
        }
        let each_us = 1e3 / f64::from(UPDATES);
        figures.push(("cache_update_cpu_us", cpu_ms * each_us));
        figures.push(("cache_update_wall_us", wall_ms * each_us));
        Ok(figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tested::Tested;
    use terrafill_results::Status;

    #[test]
    fn everything_keeps_the_same_texels_and_one_number_for_the_ground_does_not() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let group = group_of(cases(true), 1);
        let mut right = 0;
        for (at, verdict) in tested.verdicts(&group) {
            let (name, case) = (&group.cases[at].id.name, &group.work[at]);
            match (case.keep, verdict.status) {
                // Negative control.
                (Keep::ArrayByWorld, status) => assert_eq!(status, Status::Wrong, "{name}"),
                (keep, status) => {
                    assert!(
                        status == Status::Ok || keep.rounds(),
                        "{name}: {}",
                        verdict.reason
                    );
                    right += 1;
                }
            }
        }
        // Without bindless arrays 8 of each kind on wgpu, and 5 on Vulkan.
        assert!(right >= 4 * 13, "{right}");
    }

    #[test]
    fn a_wrong_and_a_missing_answer_are_counted() {
        let blocks = Blocks::new(4);
        let mut asked = queries(blocks, Access::Random, 100);
        let ranges = by_block(blocks, &mut asked);
        assert_eq!(ranges.iter().map(|range| range.len()).sum::<usize>(), 100);
        let mut found: Vec<f32> = asked
            .iter()
            .map(|query| answer(blocks, query, |_| 0))
            .collect();
        assert_eq!(differing(blocks, &asked, &found, |_| 0), 0);
        assert!(differing(blocks, &asked, &found, |_| 1) > 90);
        found[7] += 1.0;
        found.pop();
        assert_eq!(differing(blocks, &asked, &found, |_| 0), 2);
    }
}
