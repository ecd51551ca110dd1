// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: blocks by their number, what keeps them, and the order in which they are read.

use super::keep::{Keep, Keeps};
use super::queries::{Access, Blocks, SIDE, TexelQuery, answer, queries};
use super::{on_vulkan, on_wgpu};
use crate::STUDY;
use crate::metrics::{self, ACCESS, API, EXPERIMENT, KEPT_IN};
use crate::way::Interface;
use terrafill_results::{ConditionKey, Verdict};
use terrafill_study::{CaseGroup, Context, Failure, Figures, Group, Trial, judged, trials};

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
            let on = |interface| Keep::LOOKED_UP.map(|keep| (interface, keep));
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
    let mut group = trials(STUDY, format!("{STUDY}/cache"), samples, cases);
    for (planned, case) in group.cases.iter_mut().zip(&group.work) {
        planned.may_be_wrong = case.keep.rounds();
    }
    group
}

struct Opened {
    cache: Box<dyn Keeps>,
    /// How often a block was written.
    version: u32,
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
    fn open(&self, context: Context<'_>, asked: &[TexelQuery]) -> Result<Box<dyn Keeps>, Failure> {
        let Self { keep, blocks, .. } = *self;
        Ok(match self.interface {
            Interface::Wgpu => {
                let gpu = terrafill_gpu::shared_gpu(context.devices)?;
                Box::new(on_wgpu::Cache::new(&gpu, keep, blocks, asked)?)
            }
            Interface::Vulkan => {
                let gpu = terrafill_vulkan::shared_gpu(context.devices)?;
                Box::new(on_vulkan::Cache::new(&gpu, keep, blocks, asked)?)
            }
        })
    }
}

impl Trial for CacheCase {
    type Opened = Opened;

    fn conditions(&self) -> Vec<(ConditionKey, String)> {
        vec![
            (EXPERIMENT, "cache".to_owned()),
            (API, self.interface.name().to_owned()),
            (KEPT_IN, self.keep.name().to_owned()),
            (ACCESS, self.access.name().to_owned()),
            (metrics::BLOCKS, self.blocks.count().to_string()),
        ]
    }

    /// Looks everything up, writes a block anew, and looks everything up again.
    fn verify(&self, context: Context<'_>) -> Result<(Opened, Verdict), Failure> {
        let blocks = self.blocks;
        let asked = queries(blocks, self.access, self.queries);
        let cache = self.open(context, &asked)?;
        cache.look_up()?;
        let mut wrong = differing(blocks, &asked, &cache.read()?, |_| 0);
        let changed = blocks.count() / 2;
        cache.update(changed, &Blocks::texels(changed, 1))?;
        cache.look_up()?;
        let versions = |block| u32::from(block == changed);
        wrong += differing(blocks, &asked, &cache.read()?, versions);
        let asked = 2 * self.queries;
        let block_bytes = f64::from(4 * SIDE * SIDE);
        let reason = match wrong {
            0 => String::new(),
            _ => format!("{wrong} of {asked} texels are not those by integers"),
        };
        let figures = vec![
            ("cache_differing", wrong as f64),
            ("cache_bytes", f64::from(blocks.count()) * block_bytes),
        ];
        let verdict = judged(reason, figures, Vec::new());
        Ok((Opened { cache, version: 1 }, verdict))
    }

    fn time(&self, opened: &mut Opened) -> Result<Figures, Failure> {
        let mut figures = opened.cache.look_up()?.figures();
        let (mut cpu_ms, mut wall_ms) = (0.0, 0.0);
        for update in 0..UPDATES {
            opened.version += 1;
            let block = update % self.blocks.count();
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
        // Without bindless arrays 7 of each kind on wgpu, and 4 on Vulkan.
        assert!(right >= 4 * 11, "{right}");
    }

    #[test]
    fn a_wrong_and_a_missing_answer_are_counted() {
        let blocks = Blocks::new(4);
        let asked = queries(blocks, Access::Random, 100);
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
