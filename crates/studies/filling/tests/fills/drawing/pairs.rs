// SPDX-License-Identifier: MIT OR Apache-2.0
//! Variants of a technique in which every two values of its switches meet.

use std::collections::BTreeSet;
use terrafill_contract::Technique;
use terrafill_results::SplitMix64;
use terrafill_scene::Overlap;
use terrafill_variant::{Switches, Variant};

/// Switches that are not drawn here, and why.
const LEFT_OUT: [(&str, &str); 5] = [
    (
        "normalize",
        "of textured fills, which have tests of their own",
    ),
    ("position", "of textured fills"),
    ("texture", "of textured fills"),
    ("texture-code", "of textured fills"),
    ("vertices", "of footprints, which have tests of their own"),
];

/// Fewer values of a switch: `zpass` is wrong from within a volume, which has a test of its own, and of numbers of bits the
/// least and the most do all.
const FEWER: [(&str, &[&str]); 2] = [
    ("depth-rule", &["zfail", "automatic", "uncut"]),
    ("stencil-bits", &["8", "1"]),
];

/// Rows drawn by lot, and of those that go together so many, of which few are chosen.
const DRAWN: usize = 60_000;
const CANDIDATES: usize = 1_000;

/// A key and the values that it may have.
type Choice = (&'static str, Vec<&'static str>);

/// What may be chosen, with its values: a new switch is among them without being named here.
fn choices(technique: &dyn Technique, own: &[&str]) -> Vec<Choice> {
    for (key, _) in LEFT_OUT {
        assert!(Switches::TABLE.iter().any(|row| row.key == key), "{key}");
    }
    let parameters = technique.parameters().iter();
    let parameters = parameters.filter(|parameter| own.contains(&parameter.key));
    let own = parameters.map(|parameter| (parameter.key, parameter.values.list()));
    let rows = Switches::TABLE.iter();
    let rows = rows.filter(|row| LEFT_OUT.iter().all(|(key, _)| *key != row.key));
    let switches = rows.map(|row| {
        let fewer = FEWER.iter().find(|(key, _)| *key == row.key);
        let values = fewer.map_or_else(|| row.values.list(), |(_, values)| values.to_vec());
        (row.key, values)
    });
    own.chain(switches).collect()
}

/// The variant of a row, a value for each choice; `None` of values that do not go together.
fn variant_of(technique: &dyn Technique, choices: &[Choice], row: &[usize]) -> Option<Variant> {
    let mut variant = technique.main(Overlap::Disjoint);
    for ((key, values), &value) in choices.iter().zip(row) {
        assert_eq!(variant.set(key, values[value]), Ok(true), "{key}");
    }
    let checked = technique.check(&variant, Overlap::Disjoint);
    checked.is_ok().then_some(variant)
}

/// Every two values of a row.
fn pairs(row: &[usize]) -> impl Iterator<Item = [(usize, usize); 2]> {
    let values = || row.iter().copied().enumerate();
    values().flat_map(move |later| values().take(later.0).map(move |earlier| [earlier, later]))
}

/// Few variants in which every two values of two keys that go together meet at least once: what
/// two switches do to each other shows in pairs (Kuhn, Wallace and Gallo, 2004). Greedy: of many rows drawn by lot, the
/// one with most pairs that are still missing comes next.
///
/// - `own`: parameters of the technique that are chosen beside the switches of every fill
pub(crate) fn pairwise(technique: &dyn Technique, own: &[&str]) -> Vec<Variant> {
    let choices = choices(technique, own);
    let mut lot = SplitMix64::new(7);
    let mut row = || -> Vec<usize> {
        let counts = choices.iter().map(|(_, values)| values.len());
        counts.map(|count| lot.below(count)).collect()
    };
    let mut rows: Vec<Vec<usize>> = (0..DRAWN).map(|_| row()).collect();
    rows.retain(|row| variant_of(technique, &choices, row).is_some());
    assert!(rows.len() >= CANDIDATES, "{} rows go together", rows.len());
    rows.truncate(CANDIDATES);
    let mut missing: BTreeSet<_> = rows.iter().flat_map(|row| pairs(row)).collect();
    for (key, (name, values)) in choices.iter().enumerate() {
        for (value, text) in values.iter().enumerate() {
            let is_drawn = missing.iter().any(|pair| pair.contains(&(key, value)));
            assert!(is_drawn, "{name}={text} goes with nothing that was drawn");
        }
    }
    let mut chosen = Vec::new();
    while !missing.is_empty() {
        let gain = |row: &Vec<usize>| pairs(row).filter(|pair| missing.contains(pair)).count();
        let Some(best) = rows.iter().max_by_key(|row| gain(row)) else {
            break;
        };
        for pair in pairs(best) {
            missing.remove(&pair);
        }
        chosen.extend(variant_of(technique, &choices, best));
    }
    chosen
}
