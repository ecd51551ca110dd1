// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: blocks by their number, what keeps them, and the order in which they are read.

use super::keep::Keep;
use super::keeps::Keeps;
use super::queries::{Access, Blocks, SIDE, TexelQuery, answer, queries};
use super::{on_vulkan, on_wgpu};
use crate::STUDY;
use crate::draws::verdict_of;
use crate::keys;
use crate::keys::{ACCESS, API, EXPERIMENT, KEPT_IN};
use crate::way::Interface;
use std::collections::BTreeMap;
use std::ops::Range;
use terrafill_fill::DeviceError;
use terrafill_results::{CaseId, PlannedCase, Status, Verdict};
use terrafill_study::{Context, Group, Session, StudyError};

/// Blocks; the last is above what array textures usually allow.
const BLOCKS: [u32; 6] = [1, 16, 64, 256, 1_024, 4_096];
const QUICK_BLOCKS: [u32; 2] = [16, 64];
/// Texels looked up in a frame, those of a picture of 512 × 512.
const QUERIES: u32 = 1 << 18;
const QUICK_QUERIES: u32 = 1 << 14;
/// Blocks written in a timed sample, each waited for.
const UPDATES: u32 = 8;

/// Blocks kept by all that can.
pub(crate) struct Caches {
    planned: Vec<PlannedCase>,
    cases: Vec<(Interface, Keep, Blocks, Access)>,
    queries: u32,
}

impl Caches {
    pub(crate) fn new(is_quick: bool, samples: u32) -> Self {
        let counts: &[u32] = if is_quick { &QUICK_BLOCKS } else { &BLOCKS };
        let (mut planned, mut cases) = (Vec::new(), Vec::new());
        for &count in counts {
            for access in Access::ALL {
                let on = |interface| Keep::ALL.map(|keep| (interface, keep));
                let all = Interface::ALL.into_iter().flat_map(on);
                // What rounds is asked about once.
                let asked = all.filter(|(on, keep)| *on == Interface::Wgpu || !keep.rounds());
                for (interface, keep) in asked {
                    let conditions = [
                        (EXPERIMENT, "cache".to_owned()),
                        (API, interface.name().to_owned()),
                        (KEPT_IN, keep.name().to_owned()),
                        (ACCESS, access.name().to_owned()),
                        (keys::BLOCKS, count.to_string()),
                    ];
                    let values = conditions.iter().map(|(_, value)| value.as_str());
                    let name: Vec<&str> = values.collect();
                    planned.push(PlannedCase {
                        id: CaseId::new(STUDY, name.join("/"), conditions.clone()),
                        samples,
                        may_be_wrong: keep.rounds(),
                    });
                    cases.push((interface, keep, Blocks::new(count), access));
                }
            }
        }
        Self {
            planned,
            cases,
            queries: if is_quick { QUICK_QUERIES } else { QUERIES },
        }
    }
}

impl Group for Caches {
    fn name(&self) -> String {
        format!("{STUDY}/cache")
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.planned
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(CacheSession {
            group: self,
            context,
            opened: BTreeMap::new(),
        }))
    }
}

struct CacheSession<'a> {
    group: &'a Caches,
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

impl CacheSession<'_> {
    /// Looks everything up, writes a block anew, and looks everything up again.
    fn run(&mut self, case: usize) -> Result<(usize, usize), DeviceError> {
        let (interface, keep, blocks, access) = self.group.cases[case];
        let devices = self.context.devices;
        let mut asked = queries(blocks, access, self.group.queries);
        let ranges = match keep {
            Keep::Rebound => by_block(blocks, &mut asked),
            _ => Vec::new(),
        };
        let cache: Box<dyn Keeps> = match interface {
            Interface::Wgpu => {
                let gpu = terrafill_gpu::shared_gpu(devices)?;
                Box::new(on_wgpu::Cache::new(&gpu, keep, blocks, &asked, &ranges)?)
            }
            Interface::Vulkan => {
                let gpu = terrafill_vulkan::shared_gpu(devices)?;
                Box::new(on_vulkan::Cache::new(&gpu, keep, blocks, &asked, &ranges)?)
            }
        };
        cache.look_up()?;
        let mut wrong = differing(blocks, &asked, &cache.read()?, |_| 0);
        let changed = blocks.count() / 2;
        cache.update(changed, &Blocks::texels(changed, 1))?;
        cache.look_up()?;
        let versions = |block| u32::from(block == changed);
        wrong += differing(blocks, &asked, &cache.read()?, versions);
        let binds = cache.binds();
        if self.group.planned[case].samples > 0 {
            self.opened.insert(case, Opened { cache, version: 1 });
        }
        Ok((wrong, binds))
    }
}

impl Session for CacheSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        let (wrong, binds) = match self.run(case) {
            Ok(run) => run,
            Err(error) => return Ok(verdict_of(&error)),
        };
        let (_, _, blocks, _) = self.group.cases[case];
        let asked = 2 * self.group.queries;
        Ok(Verdict {
            status: if wrong == 0 {
                Status::Ok
            } else {
                Status::Wrong
            },
            reason: match wrong {
                0 => String::new(),
                _ => format!("{wrong} of {asked} texels are not those by integers"),
            },
            figures: vec![
                ("cache_differing", wrong as f64),
                ("cache_asked", f64::from(asked)),
                ("cache_binds", binds as f64),
                (
                    "cache_bytes",
                    f64::from(blocks.count()) * f64::from(4 * SIDE * SIDE),
                ),
                ("cache_update_bytes", f64::from(4 * SIDE * SIDE)),
            ],
            ..Verdict::default()
        })
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let (_, _, blocks, _) = self.group.cases[case];
        let opened = self.opened.get_mut(&case).ok_or("it was not verified")?;
        let broken = |error: DeviceError| error.to_string();
        let mut figures = opened.cache.look_up().map_err(broken)?.figures();
        let (mut cpu_ms, mut wall_ms) = (0.0, 0.0);
        for update in 0..UPDATES {
            opened.version += 1;
            let block = update % blocks.count();
            let texels = Blocks::texels(block, opened.version);
            let times = opened.cache.update(block, &texels).map_err(broken)?;
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
    use std::rc::Rc;
    use terrafill_fill::Devices;

    #[test]
    fn everything_keeps_the_same_texels_and_one_number_for_the_ground_does_not() {
        let devices = Rc::new(Devices::default());
        let wgpu = terrafill_gpu::shared_gpu(&devices).map(drop);
        let vulkan = terrafill_vulkan::shared_gpu(&devices).map(drop);
        if terrafill_fill::device_for_test(wgpu).is_none()
            || terrafill_fill::device_for_test(vulkan).is_none()
        {
            return;
        }
        let group = Caches::new(true, 1);
        let folder = std::path::Path::new("");
        let context = Context {
            devices: &devices,
            folder,
        };
        let mut session = group.open(context).expect("opens");
        let mut right = 0;
        for (at, (planned, (_, keep, ..))) in group.planned.iter().zip(&group.cases).enumerate() {
            let verdict = session.verify(at).expect("a verdict");
            let name = &planned.id.name;
            eprintln!(
                "{name}: {:?} {} {:?}",
                verdict.status, verdict.reason, verdict.figures
            );
            match (keep, verdict.status) {
                // Twin.
                (Keep::ArrayByWorld, status) => assert_eq!(status, Status::Wrong, "{name}"),
                (_, Status::Skipped) => {}
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
        let times = session.sample(0).expect("a time");
        assert!(times.iter().all(|(_, time)| *time > 0.0), "{times:?}");
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
