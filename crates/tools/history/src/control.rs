// SPDX-License-Identifier: MIT OR Apache-2.0
//! Times relative to the control passes of the same runs.
//!
//! A machine that was slower in one run was slower in everything, in the full-screen pass too that no
//! technique has a part in. How far those passes are from their own medians is the machine's shift. It is
//! taken from the other times where that leaves most of them with less spread. One noisy control can add
//! more than it takes, and then it is left alone.

use crate::series::Followed;
use std::collections::BTreeMap;
use terrafill_results::median;

/// Takes the machine's shift from the times of one machine and metric; the number of them, 0 where that
/// does not help.
pub(crate) fn relative(group: &mut [Followed<'_>]) -> usize {
    let mut seen: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for control in group.iter().filter(|of| of.series.is_control) {
        let Some(middle) = median(&control.values) else {
            continue;
        };
        for (place, value) in places(control).zip(&control.values) {
            seen.entry(place).or_default().push(value - middle);
        }
    }
    let shift: BTreeMap<usize, f64> = seen
        .into_iter()
        .filter_map(|(place, values)| Some((place, median(&values)?)))
        .collect();
    let without = |of: &Followed<'_>| -> Option<Vec<f64>> {
        let shifts = places(of).map(|place| shift.get(&place));
        let values = of.values.iter().zip(shifts);
        values.map(|(value, shift)| Some(value - shift?)).collect()
    };
    // A commit without a control leaves a series as it is.
    let candidates: Vec<(usize, Vec<f64>)> = group
        .iter()
        .enumerate()
        .filter(|(_, of)| !of.series.is_control)
        .filter_map(|(at, of)| Some((at, without(of)?)))
        .collect();
    let gains: Vec<f64> = candidates
        .iter()
        .map(|(at, values)| spread(&group[*at].values) - spread(values))
        .collect();
    if median(&gains).is_none_or(|gain| gain <= 0.0) {
        return 0;
    }
    let count = candidates.len();
    for (at, values) in candidates {
        group[at].values = values;
    }
    count
}

/// Places of the commits of a series among all.
fn places<'a>(of: &'a Followed<'_>) -> impl Iterator<Item = usize> + 'a {
    of.points.iter().map(|at| of.series.points[*at].place)
}

/// Mean distance from the median: steps count, unlike in the scatter that steps are measured by.
fn spread(values: &[f64]) -> f64 {
    let middle = median(values).unwrap_or(0.0);
    values
        .iter()
        .map(|value| (value - middle).abs())
        .sum::<f64>()
        / values.len() as f64
}
