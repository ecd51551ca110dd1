// SPDX-License-Identifier: MIT OR Apache-2.0
//! A dot for each process beside the time of a case: what an interval is made of.
//!
//! All rows have one scale, relative to the row's median. So a wide row is a noisy case wherever it stands.

use crate::number::significant;
use terrafill_results::{Case, Cell, CellClass, has_two_groups, median, process_medians};

/// The dots reach from the median over this factor to the median times it. The clocks of a GPU differ by more,
/// and a hundredth is two thirds of a pixel.
pub const DOTS_FACTOR: f64 = 1.5;

/// Size of the drawing, CSS pixels, as the report's style sheet has it: as wide as a cell with a time.
const WIDTH_PX: f64 = 60.0;
const HEIGHT_PX: f64 = 8.0;
/// Half a dot, and the length of a triangle at the rim.
const DOT_PX: f64 = 2.0;
const RIM_PX: f64 = 5.0;

/// Stands beside a time whose processes fall into two groups.
pub const TWO_GROUPS: &str = "two groups";

/// The cell of a time, with a dot for each process where it has several, and marked where these fall into two
/// groups. An empty cell, a count, and a figure that counts for nothing stay as they are.
#[must_use]
pub fn dotted(cell: Cell, case: &Case, metric: impl AsRef<str>) -> Cell {
    let metric = metric.as_ref();
    let times: Vec<f64> = process_medians(case, metric).into_values().collect();
    // What all processes have to the last digit is counted, not timed.
    let is_time = times.iter().any(|time| *time != times[0]);
    if !is_time || matches!(cell.class, CellClass::Absent | CellClass::Void) {
        return cell;
    }
    let mark = if has_two_groups(case, metric) {
        TWO_GROUPS
    } else {
        ""
    };
    Cell {
        dots: dots(&times),
        mark: mark.to_owned(),
        ..cell
    }
}

/// One dot for each time; beyond the scale, a triangle at its rim that points outwards.
fn dots(times: &[f64]) -> String {
    let middle = median(times).unwrap_or(1.0);
    let (half, y) = (WIDTH_PX / 2.0, HEIGHT_PX / 2.0);
    let (mut inside, mut beyond) = (String::new(), String::new());
    for time in times {
        let off = (time / middle).ln() / DOTS_FACTOR.ln();
        if off.abs() <= 1.0 {
            let x = half + off * (half - RIM_PX - DOT_PX);
            let x = (10.0 * x).round() / 10.0;
            inside += &format!("M{x} {y}h0");
        } else if off > 0.0 {
            beyond += &format!("M{} 0l{RIM_PX} {y}l-{RIM_PX} {y}z", WIDTH_PX - RIM_PX);
        } else {
            beyond += &format!("M{RIM_PX} 0l-{RIM_PX} {y}l{RIM_PX} {y}z");
        }
    }
    let said: Vec<String> = times.iter().map(|time| significant(*time)).collect();
    // The page says once how these are drawn, and how large: there are hundreds.
    format!(
        "<svg class=\"dots\"><title>processes: {}</title><path d=\"{inside}\"/>{}</svg>",
        said.join(", "),
        match beyond.as_str() {
            "" => String::new(),
            beyond => format!("<path class=\"beyond\" d=\"{beyond}\"/>"),
        }
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::Run;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    const METRIC: &str = "fill_cpu_ms";

    fn run(processes: &[f64]) -> Run {
        let mut run = MadeUpRun::default();
        run.case(case_id("filling", "a", &[]))
            .timed(METRIC, processes);
        run.loaded()
    }

    fn cell(processes: &[f64]) -> Cell {
        let run = run(processes);
        dotted(Cell::plain("10"), &run.cases[0], METRIC)
    }

    #[test]
    fn every_process_has_a_dot_and_one_beyond_the_scale_points_outwards() {
        let steady = cell(&[10.0, 10.1, 9.9, 10.0, 10.2]);
        assert_eq!((steady.text.as_str(), steady.mark.as_str()), ("10", ""));
        assert_eq!(steady.dots.matches("h0").count(), 5, "{}", steady.dots);
        assert!(steady.dots.contains("processes: 10.0, 10.1, 9.90,"));
        assert!(
            steady.dots.contains("M30 4h0"),
            "the median: {}",
            steady.dots
        );
        let slow = cell(&[10.0, 10.1, 9.9, 10.0, 37.0]);
        assert_eq!(slow.dots.matches("h0").count(), 4);
        assert!(slow.dots.contains("M55 0l5 4l-5 4z"), "{}", slow.dots);
        let fast = cell(&[10.0, 10.1, 9.9, 10.0, 2.0]);
        assert!(fast.dots.contains("M5 0l-5 4l5 4z"), "{}", fast.dots);
    }

    #[test]
    fn processes_at_two_clocks_are_marked_and_one_alone_has_no_dots() {
        let split = cell(&[1.07, 0.293, 0.294, 1.06, 0.295]);
        assert_eq!(split.mark, TWO_GROUPS);
        // Negative controls: scattered processes, one process, a count, and a figure that counts for nothing.
        assert_eq!(cell(&[1.0, 1.1, 1.2, 1.3, 1.4]).mark, "");
        assert_eq!(cell(&[1.0]), Cell::plain("10"));
        assert_eq!(cell(&[12.0; 5]), Cell::plain("10"), "a count");
        let split = run(&[1.07, 0.293, 0.294, 1.06, 0.295]);
        let absent = Cell::absent("why");
        assert_eq!(dotted(absent.clone(), &split.cases[0], METRIC), absent);
    }
}
