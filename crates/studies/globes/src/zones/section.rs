// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on zones of a height field by counted pixels.

use super::PART;
use crate::keys::{
    COUNTED_BY, GLOBE_COUNT_CYCLES, GLOBE_COUNT_OFF_PX, GLOBE_COUNT_SETTLE_FRAMES,
    GLOBE_COUNT_WRONG_NODES, GLOBE_COUNTED_CPU_MS, GLOBE_TRIANGLES, GLOBE_UNCOUNTED_CPU_MS,
    GLOBE_ZONE_HIDES, HYSTERESIS, SPIKE_M, WANTED,
};
use crate::table::{by_case, cases, conditions, with};
use terrafill_plot::number::significant;
use terrafill_plot::{Course, Courses};
use terrafill_results::{Block, Case, ChapterError, Finding, Plot, Run, Standing, Table};

/// What is measured.
const WHAT_IS_COMPARED: &str = "A height field of 5 × 5 zones with four levels, each with a quarter of the next one's triangles. A zone becomes finer \
     where it has more pixels a triangle than the upper threshold, and coarser where it has fewer than the lower one, by \
     counts of the frame before. Spikes between two rows of zones stand on every second vertex, so that only two zones at \
     the finest level show them; they hide all but 1/m of the zones behind. A cycle needs a hysteresis below 4 m.";

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run) -> Result<Vec<Block>, ChapterError> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = vec![
        Block::section("Height zones by counted pixels"),
        Block::Text(WHAT_IS_COMPARED.to_owned()),
        Block::Finding(rest_finding(&cases)),
        Block::Finding(bypass_finding(&cases)),
        Block::Table(table(&cases)),
    ];
    let svg = courses(&cases).draw()?;
    blocks.extend(svg.map(|svg| {
        Block::Plot(Plot {
            caption:
                "Triangles of all zones frame by frame: answers to a step from the coarsest level."
                    .to_owned(),
            svg,
        })
    }));
    Ok(blocks)
}

fn table(cases: &[&Case]) -> Table {
    let columns = [
        ("m, hidden but 1/m", GLOBE_ZONE_HIDES),
        ("settled after, frames", GLOBE_COUNT_SETTLE_FRAMES),
        ("triangles", GLOBE_TRIANGLES),
        ("off rays, px", GLOBE_COUNT_OFF_PX),
        (
            "zones off by more than their edges",
            GLOBE_COUNT_WRONG_NODES,
        ),
        ("frame with counts, CPU ms", GLOBE_COUNTED_CPU_MS),
        ("without", GLOBE_UNCOUNTED_CPU_MS),
    ];
    let names = [
        "counted by",
        "spikes, m",
        "wanted px a triangle",
        "hysteresis",
    ];
    let keys = [COUNTED_BY, SPIKE_M, WANTED, HYSTERESIS];
    by_case(
        "Height zones",
        cases,
        (&names, &conditions(&keys)),
        &columns,
        &|case| match case.value(GLOBE_COUNT_CYCLES) {
            Some(1.0) => "it does not settle",
            _ => "not measured",
        },
    )
}

fn hysteresis(case: &Case) -> Option<f64> {
    case.condition(HYSTERESIS).parse().ok()
}

/// Hysteresis over four times what spikes hide, and whether it cycles.
fn measured(cases: &[&Case]) -> Vec<(f64, bool)> {
    let of = |case: &&Case| {
        let hides = case.value(GLOBE_ZONE_HIDES)?;
        let cycles = case.value(GLOBE_COUNT_CYCLES)? > 0.0;
        Some((hysteresis(case)? / (4.0 * hides), cycles))
    };
    cases.iter().filter_map(of).collect()
}

fn rest_finding(cases: &[&Case]) -> Finding {
    let all = measured(cases);
    let count = |is_enough: bool, cycles: bool| {
        let own = all.iter().filter(|(share, _)| (*share >= 1.0) == is_enough);
        own.filter(|(_, cycling)| !cycles || *cycling).count()
    };
    let [enough, less] = [true, false].map(|is_enough| {
        format!(
            "{} of {} cycle",
            count(is_enough, true),
            count(is_enough, false)
        )
    });
    Finding {
        claim:
            "With a hysteresis of 4 m or more no field of zones cycles, m what a finer level hides"
                .to_owned(),
        standing: match count(true, false) {
            0 => Standing::CannotTell,
            _ => Standing::holds_if(count(true, true) == 0),
        },
        because: format!("From 4 m on {enough}; below it {less}."),
    }
}

fn bypass_finding(cases: &[&Case]) -> Finding {
    let spiked: Vec<&Case> = cases
        .iter()
        .copied()
        .filter(|case| case.condition(SPIKE_M) != "0")
        .collect();
    let cycling = spiked
        .iter()
        .filter(|case| case.value(GLOBE_COUNT_CYCLES) == Some(1.0));
    let most = cycling
        .clone()
        .filter_map(|case| hysteresis(case))
        .max_by(f64::total_cmp);
    let hides = spiked
        .iter()
        .filter_map(|case| case.value(GLOBE_ZONE_HIDES));
    let hides = hides.max_by(f64::total_cmp);
    Finding {
        claim: "Gebbie & Bailey: oscillations of a spike that comes and goes bypass even large buffer thresholds".to_owned(),
        standing: match spiked.is_empty() {
            true => Standing::CannotTell,
            false => Standing::holds_if(most.is_some_and(|hysteresis| hysteresis >= 4.0)),
        },
        because: match (most, hides) {
            (Some(most), Some(hides)) => format!(
                "Here up to a hysteresis of {}; the spikes hide all but 1/{} of a zone, so one of {} stops every cycle.",
                significant(most),
                significant(hides),
                significant(4.0 * hides)
            ),
            _ => "No field with spikes cycles here.".to_owned(),
        },
    }
}

fn courses(cases: &[&Case]) -> Courses<'static> {
    let shown = with(&with(cases, COUNTED_BY, "histogram"), WANTED, "3");
    let shown = shown
        .into_iter()
        .filter(|case| ["4", "8", "64"].contains(&case.condition(HYSTERESIS)));
    let panels = shown.map(|case| Course {
        name: format!(
            "spikes {} m, hysteresis {}",
            case.condition(SPIKE_M),
            case.condition(HYSTERESIS)
        ),
        values: case
            .note("triangles-by-frame")
            .split(' ')
            .filter_map(|value| value.parse().ok())
            .collect(),
        wanted: None,
    });
    Courses {
        title: "triangles of height zones frame by frame".to_owned(),
        across: "frames",
        panels: panels.collect(),
    }
}
