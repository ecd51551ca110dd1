// SPDX-License-Identifier: MIT OR Apache-2.0
//! Parts of a gate on several machines, and their reports as one.
//!
//! A part is some of the scenes. Its machine measures both programs over them, so that no pair of base and
//! new is ever of two machines.

use crate::report::{refuse_unmatched, sort};
use crate::{GateError, GateReport, GateShard, Span, verdict};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use terrafill_results::Shard;

impl GateShard {
    /// The scenes of one part, packed by what they cost an earlier gate: the heaviest first, each to the
    /// part that has least so far. Every machine comes to the same parts.
    ///
    /// - `all`: scenes of the whole gate
    /// - `earlier`: that gate; without one, or for a scene that it has not, scenes weigh the same
    ///
    /// # Errors
    /// [`GateError::BadInput`] without scenes, for one named twice, and for more parts than scenes.
    pub fn new(
        shard: Shard,
        all: &[String],
        earlier: Option<&GateReport>,
    ) -> Result<Self, GateError> {
        let bad = |message: String| Err(GateError::BadInput(message));
        let distinct: BTreeSet<&String> = all.iter().collect();
        if all.is_empty() {
            return bad("--shard needs the scenes that it shares out: name them".to_owned());
        }
        if distinct.len() < all.len() {
            return bad(format!("a scene is given twice: {}", all.join(", ")));
        }
        if shard.count > all.len() {
            return bad(format!(
                "--shard {}/{}: found {} scenes, allowed: as many shards at most",
                shard.index,
                shard.count,
                all.len()
            ));
        }
        let weights = earlier.map(weights).unwrap_or_default();
        let usual = weights.values().sum::<f64>() / weights.len().max(1) as f64;
        let weight = |scene: &String| weights.get(scene).copied().unwrap_or(usual.max(1.0));
        let mut heaviest: Vec<&String> = distinct.into_iter().collect();
        heaviest.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
        let mut parts: Vec<(f64, Vec<String>)> = vec![(0.0, Vec::new()); shard.count];
        for scene in heaviest {
            let lightest = parts.iter_mut().min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((sum, scenes)) = lightest {
                *sum += weight(scene);
                scenes.push(scene.clone());
            }
        }
        Ok(Self {
            shard,
            scenes: parts.swap_remove(shard.index - 1).1,
            all: all.to_vec(),
        })
    }
}

/// What each scene cost: milliseconds over its cases, or their number where none was timed.
fn weights(report: &GateReport) -> BTreeMap<String, f64> {
    let mut weights = BTreeMap::new();
    // A key is study/scene/view/…
    let scene = |case: &str| case.split('/').nth(1).unwrap_or_default().to_owned();
    match &report.time {
        Some(time) => {
            for case in time.cases.iter().filter(|case| case.span == Span::Frame) {
                *weights.entry(scene(&case.case)).or_insert(0.0) += case.base_ms.unwrap_or(0.0);
            }
        }
        None => {
            for case in &report.compared {
                *weights.entry(scene(case)).or_insert(0.0) += 1.0;
            }
        }
    }
    weights
}

/// Reads the reports of all parts of a gate as one.
///
/// - `folders`: of the parts, in any order
///
/// # Errors
/// [`GateError::BadInput`] for a part that did not end, is missing, is there twice or is of another gate;
/// as [`crate::read_json`].
pub fn merge_gates(folders: &[PathBuf]) -> Result<GateReport, GateError> {
    let mut parts: BTreeMap<usize, (&Path, GateReport, GateShard)> = BTreeMap::new();
    let mut first: Option<(&Path, Vec<String>)> = None;
    let mut count = 0;
    for folder in folders {
        let (report, part) = read_part(folder)?;
        let Shard { index, count: of } = part.shard;
        let mut identity = report.identity();
        identity.extend([
            format!("{of} shards"),
            format!("over {}", part.all.join(" ")),
        ]);
        let wrong = |message: String| {
            let folder = folder.display();
            Err(GateError::BadInput(format!("{folder}: {message}")))
        };
        match &first {
            None => first = Some((folder, identity)),
            Some((other, expected)) if *expected != identity => {
                let only = |of: &[String], others: &[String]| -> String {
                    let of = of.iter().filter(|word| !others.contains(word));
                    of.cloned().collect::<Vec<_>>().join(", ")
                };
                return wrong(format!(
                    "found {:?}, expected {:?} as in {}",
                    only(&identity, expected),
                    only(expected, &identity),
                    other.display()
                ));
            }
            Some(_) => {}
        }
        count = of;
        if let Some((other, ..)) = parts.insert(index, (folder, report, part)) {
            return wrong(format!(
                "shard {index}/{of} is {} too, allowed: once",
                other.display()
            ));
        }
    }
    let missing: Vec<String> = (1..=count)
        .filter(|index| !parts.contains_key(index))
        .map(|index| index.to_string())
        .collect();
    if parts.is_empty() || !missing.is_empty() {
        return Err(GateError::BadInput(format!(
            "shards {} of {count} are missing, expected a folder for each",
            missing.join(", ")
        )));
    }
    all_scenes(parts.values().map(|(_, _, part)| part))?;
    let whole = join(parts.into_values().map(|(_, report, _)| report));
    refuse_unmatched(&whole.unmatched_limits)?;
    Ok(whole)
}

/// The report of a part.
fn read_part(folder: &Path) -> Result<(GateReport, GateShard), GateError> {
    let wrong = |message: &str| {
        let folder = folder.display();
        GateError::BadInput(format!("{folder}: {message}"))
    };
    let path = folder.join("gate.json");
    if !path.is_file() {
        return Err(wrong(
            "found no gate.json: this gate did not come to a verdict",
        ));
    }
    let report = crate::read_json(&path)?;
    let part = report.part.clone();
    let part = part.ok_or_else(|| wrong("a whole gate, allowed: parts made with --shard m/n"))?;
    Ok((report, part))
}

/// Every scene is in one part: parts packed by different earlier gates overlap.
fn all_scenes<'a>(parts: impl Iterator<Item = &'a GateShard> + Clone) -> Result<(), GateError> {
    let mut measured: Vec<&String> = parts.clone().flat_map(|part| &part.scenes).collect();
    measured.sort();
    let mut expected: Vec<&String> = parts.take(1).flat_map(|part| &part.all).collect();
    expected.sort();
    if measured == expected {
        return Ok(());
    }
    Err(GateError::BadInput(format!(
        "the shards measured {measured:?}, expected each of {expected:?} once: give all of them one \
         --balance-by"
    )))
}

fn join(parts: impl Iterator<Item = GateReport>) -> GateReport {
    let mut parts = parts.collect::<Vec<_>>().into_iter();
    let mut whole = parts.next().unwrap_or_default();
    for part in parts {
        whole.compared.extend(part.compared);
        whole.figures += part.figures;
        whole.skipped.extend(part.skipped);
        whole.findings.extend(part.findings);
        whole.time = match (whole.time, part.time) {
            (Some(mut all), Some(mut more)) => {
                all.cases.append(&mut more.cases);
                // Of each look the fewest blocks that a part has.
                all.screen.truncate(more.screen.len());
                if all.confirm.is_empty() || more.confirm.is_empty() {
                    all.confirm.append(&mut more.confirm);
                } else {
                    all.confirm.truncate(more.confirm.len());
                }
                if let crate::TimingOrder::Turns { .. } = more.way {
                    all.way = more.way;
                }
                Some(all)
            }
            (all, more) => all.or(more),
        };
        // Unused is what no part uses, stale what one part finds another value of.
        let is_stale = |words: &String| words.starts_with("stale");
        let others = part.idle_blessings;
        whole
            .idle_blessings
            .retain(|words| is_stale(words) || others.contains(words));
        whole
            .idle_blessings
            .extend(others.into_iter().filter(is_stale));
        let elsewhere = part.unmatched_limits;
        whole
            .unmatched_limits
            .retain(|limit| elsewhere.contains(limit));
        whole.elapsed_s = whole.elapsed_s.max(part.elapsed_s);
    }
    sort(&mut whole.findings);
    whole.verdict = verdict(&whole.findings, whole.compared.len());
    whole.exit_code = whole.verdict.exit_code();
    whole.part = None;
    // They lie in the folders of the parts.
    whole.pictures = Vec::new();
    whole.see = String::new();
    whole
}

#[cfg(test)]
mod tests;
