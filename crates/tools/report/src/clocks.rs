// SPDX-License-Identifier: MIT OR Apache-2.0
//! At which clocks the device ran, in a line.

use std::collections::BTreeSet;
use terrafill_results::{DeviceClock, Moment};

/// What was read of each clock, and why nothing was; `None` where nothing was tried.
pub(crate) fn sentence(read: &[DeviceClock]) -> Option<String> {
    let mut clocks: Vec<&str> = Vec::new();
    for row in read {
        if row.mhz.is_some() && !clocks.contains(&row.clock.as_str()) {
            clocks.push(&row.clock);
        }
    }
    let known = clocks.iter().map(|clock| of_clock(read, clock));
    let reasons = read.iter().map(|row| row.reason.as_str());
    let reasons: BTreeSet<&str> = reasons.filter(|reason| !reason.is_empty()).collect();
    let absent = reasons
        .into_iter()
        .map(|reason| format!("not known: {reason}"));
    let said: Vec<String> = known.chain(absent).collect();
    (!said.is_empty()).then(|| said.join("; "))
}

fn of_clock(read: &[DeviceClock], clock: &str) -> String {
    let of = || read.iter().filter(|row| row.clock == clock);
    let at = |moment| {
        range(
            of().filter(|row| row.moment == moment)
                .filter_map(|row| row.mhz),
        )
    };
    let processes: BTreeSet<u32> = of().map(|row| row.process).collect();
    let highest = of().filter_map(|row| row.max_mhz).max_by(f64::total_cmp);
    format!(
        "{clock} {} MHz at the start and {} at the end of {}{}",
        at(Moment::Start),
        at(Moment::End),
        match processes.len() {
            1 => "one process".to_owned(),
            some => format!("{some} processes"),
        },
        highest.map_or_else(String::new, |mhz| format!(", {mhz:.0} at most"))
    )
}

/// The least and the largest, or the one that all are.
fn range(values: impl Iterator<Item = f64>) -> String {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let shown: Vec<String> = values.iter().map(|mhz| format!("{mhz:.0}")).collect();
    match (shown.first(), shown.last()) {
        (Some(low), Some(high)) if low == high => low.clone(),
        (Some(low), Some(high)) => format!("{low}–{high}"),
        _ => "–".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(process: u32, moment: Moment, clock: &str, mhz: f64) -> DeviceClock {
        DeviceClock {
            process,
            moment,
            clock: clock.to_owned(),
            mhz: Some(mhz),
            max_mhz: (clock == "graphics").then_some(1_980.0),
            reason: String::new(),
        }
    }

    #[test]
    fn every_clock_has_its_range_and_an_unknown_one_its_reason() {
        use Moment::{End, Start};
        let mut rows = vec![
            read(0, Start, "graphics", 345.0),
            read(0, End, "graphics", 1_980.0),
            read(1, Start, "graphics", 1_755.0),
            read(1, End, "graphics", 1_980.0),
            read(0, Start, "memory", 3_201.0),
        ];
        let graphics =
            "graphics 345–1755 MHz at the start and 1980 at the end of 2 processes, 1980 at most";
        let memory = "memory 3201 MHz at the start and – at the end of one process";
        assert_eq!(sentence(&rows), Some(format!("{graphics}; {memory}")));
        // Negative controls: nothing known has its reason once, and nothing tried says nothing.
        for row in &mut rows {
            (row.mhz, row.reason) = (None, "no nvidia-smi".to_owned());
        }
        assert_eq!(sentence(&rows).as_deref(), Some("not known: no nvidia-smi"));
        assert_eq!(sentence(&[]), None);
    }
}
