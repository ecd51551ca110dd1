// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on level of detail by counted pixels.

use super::{ENOUGH, PART};
use crate::keys;
use crate::keys::{
    COUNTED_BY, DELAY, GLOBE_COUNT_CYCLES, GLOBE_COUNT_LEAVES, GLOBE_COUNT_NODES,
    GLOBE_COUNT_OFF_PX, GLOBE_COUNT_PAGE_CPU_MS, GLOBE_COUNT_SETTLE_FRAMES,
    GLOBE_COUNT_TEXELS_PER_PX, GLOBE_COUNT_WRONG_NODES, GLOBE_COUNTED_CPU_MS,
    GLOBE_UNCOUNTED_CPU_MS, HYSTERESIS, PATH, TRANSFERS,
};
use crate::metrics::METRICS;
use crate::table::{by_case, cases, conditions, with};
use terrafill_plot::number::significant;
use terrafill_plot::{Course, Courses};
use terrafill_results::{
    Block, Case, ChapterError, Finding, Metric, Noise, Plot, Run, Standing, Table, ratio,
};

/// Longest paging of a frame.
const LARGEST_PAGE: &Metric = Metric::of(&METRICS, "globe_count_page_max_cpu_ms");

/// What is measured.
const WHAT_IS_COMPARED: &str = "A picture of 40° × 40° below the eye is drawn by the leaves of a quadtree, each with 64² texels and 10 × 10 \
     sub-quads, the nearest first. A leaf splits where it has more pixels than the upper threshold and four merge \
     where all have fewer than the lower one. Hysteresis is the one over the other, delay the frames from drawing \
     to using a count. On Vulkan counts are precise occlusion queries, one a node. WebGPU's queries say no more \
     than zero or not, so on wgpu a compute pass counts a target of node numbers. Counts of the first and the last \
     frame are held against rays in f64: a node may be off by the pixels at its edge.";

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run) -> Result<Vec<Block>, ChapterError> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Ok(Vec::new());
    }
    let own = run.of_study(crate::STUDY);
    let own: Vec<&Case> = own
        .filter(|case| case.condition(keys::PART) == PART)
        .collect();
    let noise = Noise::of(own.iter().copied(), LARGEST_PAGE);
    let mut blocks = vec![
        Block::section("Level of detail by counted pixels"),
        Block::Text(WHAT_IS_COMPARED.to_owned()),
        Block::Finding(exact_finding(&cases)),
        Block::Finding(cycle_finding(&cases)),
        Block::Finding(transfer_finding(&cases, noise)),
        Block::Table(table(&cases)),
    ];
    let svg = courses(&cases).draw()?;
    blocks.extend(svg.map(|svg| {
        Block::Plot(Plot {
            caption: "Leaves frame by frame, counts used one frame late.".to_owned(),
            svg,
        })
    }));
    Ok(blocks)
}

fn table(cases: &[&Case]) -> Table {
    let columns = [
        ("settled after, frames", GLOBE_COUNT_SETTLE_FRAMES),
        ("leaves", GLOBE_COUNT_LEAVES),
        ("texels a pixel", GLOBE_COUNT_TEXELS_PER_PX),
        ("off rays, px", GLOBE_COUNT_OFF_PX),
        (
            "nodes off by more than their edges",
            GLOBE_COUNT_WRONG_NODES,
        ),
        ("frame with counts, CPU ms", GLOBE_COUNTED_CPU_MS),
        ("without", GLOBE_UNCOUNTED_CPU_MS),
        ("paging, CPU ms", GLOBE_COUNT_PAGE_CPU_MS),
        ("largest", LARGEST_PAGE),
    ];
    let names = [
        "path",
        "counted by",
        "hysteresis",
        "delay",
        "transfers a frame",
    ];
    let keys = [PATH, COUNTED_BY, HYSTERESIS, DELAY, TRANSFERS];
    by_case(
        "Quadtrees by counted pixels",
        cases,
        (&names, &conditions(&keys)),
        &columns,
        &|case| match case.value(GLOBE_COUNT_CYCLES) {
            Some(1.0) => "it does not settle",
            _ => "the eye moves, or it was not measured",
        },
    )
}

fn courses(cases: &[&Case]) -> Courses<'static> {
    let shown = cases.iter().filter(|case| {
        case.condition(COUNTED_BY) == "histogram"
            && case.condition(DELAY) == "1"
            && ["1", "4"].contains(&case.condition(HYSTERESIS))
    });
    let panels = shown.map(|case| {
        let values = case.note("leaves").split(' ');
        Course {
            name: format!(
                "{}, hysteresis {}{}",
                case.condition(PATH),
                case.condition(HYSTERESIS),
                match case.condition(TRANSFERS) {
                    "any" => String::new(),
                    capped => format!(", {capped} transfer"),
                }
            ),
            values: values.filter_map(|value| value.parse().ok()).collect(),
            wanted: None,
        }
    });
    Courses {
        title: "leaves of quadtrees frame by frame".to_owned(),
        across: "frames",
        panels: panels.collect(),
    }
}

fn sum(cases: &[&Case], metric: &Metric) -> (f64, usize) {
    let values = cases.iter().filter_map(|case| case.value(metric));
    values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1))
}

fn exact_finding(cases: &[&Case]) -> Finding {
    let of = |way: &str| with(cases, COUNTED_BY, way);
    let words: Vec<String> = ["histogram", "queries"]
        .iter()
        .map(|way| {
            let own = of(way);
            let (nodes, count) = sum(&own, GLOBE_COUNT_NODES);
            let (wrong, _) = sum(&own, GLOBE_COUNT_WRONG_NODES);
            match count {
                0 => format!("{way}: not measured"),
                _ => format!("{way}: {wrong} of {nodes} nodes off by more than their edges"),
            }
        })
        .collect();
    let (wrong, count) = sum(cases, GLOBE_COUNT_WRONG_NODES);
    Finding {
        claim: "Counts by precise queries and by a histogram of node numbers are the pixels that rays see".to_owned(),
        standing: match count {
            0 => Standing::CannotTell,
            _ => Standing::holds_if(wrong == 0.0),
        },
        because: format!("{}.", words.join("; ")),
    }
}

fn cycle_finding(cases: &[&Case]) -> Finding {
    let hysteresis = |case: &Case| case.condition(HYSTERESIS).parse().unwrap_or(f64::NAN);
    let still: Vec<&Case> = cases
        .iter()
        .copied()
        .filter(|case| case.value(GLOBE_COUNT_CYCLES).is_some())
        .collect();
    let mut all: Vec<f64> = still.iter().map(|case| hysteresis(case)).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    let cycling = |share: f64| {
        let own: Vec<&Case> = still
            .iter()
            .copied()
            .filter(|case| hysteresis(case) == share)
            .collect();
        let (sum, count) = sum(&own, GLOBE_COUNT_CYCLES);
        (sum, count)
    };
    let words: Vec<String> = all
        .iter()
        .map(|share| {
            let (never, of) = cycling(*share);
            format!("{share}: {never} of {of}")
        })
        .collect();
    let enough: Vec<f64> = all
        .iter()
        .copied()
        .filter(|share| *share >= ENOUGH)
        .collect();
    Finding {
        claim: "With a hysteresis of 4 or more no quadtree cycles in a view that stands still"
            .to_owned(),
        standing: match enough.is_empty() {
            true => Standing::CannotTell,
            false => Standing::holds_if(enough.iter().all(|share| cycling(*share).0 == 0.0)),
        },
        because: format!("Never at rest by hysteresis: {}.", words.join("; ")),
    }
}

fn transfer_finding(cases: &[&Case], noise: Option<Noise>) -> Finding {
    let largest = |transfers: &str| {
        let own = cases.iter().filter(|case| {
            case.condition(PATH) == "zoom" && case.condition(TRANSFERS) == transfers
        });
        let timed = own.filter_map(|case| Some((*case, case.value(LARGEST_PAGE)?)));
        timed.max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let pair = largest("any").zip(largest("1"));
    let gain = pair.and_then(|((any, _), (one, _))| ratio(any, one, LARGEST_PAGE));
    let judged = gain.map(|gain| Standing::of_times(&gain, noise));
    let (standing, reason) = judged.unwrap_or((Standing::CannotTell, String::new()));
    Finding {
        claim: "Gebbie & Bailey: one transfer an update smooths its spikes".to_owned(),
        standing,
        because: match pair {
            Some(((_, any), (_, one))) => format!(
                "Largest paging of a frame in the zoom: {} ms of CPU time with any number of transfers, {} with \
                 one. {reason}",
                significant(any),
                significant(one)
            ),
            None => "The zoom was not measured.".to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn spikes_within_the_noise_decide_nothing() {
        // A repeat takes 10 % longer than what it repeats.
        let standing = |any: f64, one: f64| {
            let mut run = MadeUpRun::default();
            for (transfers, ms) in [("any", any), ("1", one)] {
                let conditions = [("part", PART), ("path", "zoom"), ("transfers", transfers)];
                let id = case_id(crate::STUDY, transfers, &conditions);
                run.case(id.twin()).timed(LARGEST_PAGE, &[1.1 * ms; 5]);
                run.case(id).timed(LARGEST_PAGE, &[ms; 5]);
            }
            let folder = tempfile::tempdir().expect("a folder");
            let run = run.write(folder.path()).expect("a run");
            let found = blocks(&run).expect("a section").into_iter();
            let findings = found.filter_map(|block| match block {
                Block::Finding(finding) if finding.claim.contains("transfer") => Some(finding),
                _ => None,
            });
            findings.map(|finding| finding.standing).next_back()
        };
        assert_eq!(standing(1.05, 1.0), Some(Standing::CannotTell));
        assert_eq!(standing(1.0, 1.05), Some(Standing::CannotTell));
        // Controls: beyond it, either way.
        assert_eq!(standing(2.0, 1.0), Some(Standing::Holds));
        assert_eq!(standing(1.0, 2.0), Some(Standing::DoesNotHold));
    }
}
