// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter's section on balls that step on devices.

use crate::finding::finding;
use crate::keys::{BALL_DEVICE_MAX_M, BALL_DEVICE_RMS_M, BALLS, INTERFACE, PART, WAY};
use crate::metrics::METRICS;
use crate::on_devices::{STEPS, TIMED};
use crate::stepping::Way;
use terrafill_plot::dotted;
use terrafill_plot::number::significant;
use terrafill_results::{
    Block, Case, Cell, Clock, Finding, Heading, Metric, Outcome, Row, Run, Table,
};

const CPU: &Metric = Metric::of(&METRICS, "ball_step_cpu_us");
const WALL: &Metric = Metric::of(&METRICS, "ball_step_wall_us");
const GPU: &Metric = Metric::of(&METRICS, "ball_step_gpu_us");
const UPLOADED: &Metric = Metric::of(&METRICS, "ball_upload_bytes");
/// Numbers of balls between which the slope is taken.
const SLOPE: [&str; 2] = ["10000", "1000000"];
/// Slopes of log time over log number of balls that count as proportional.
const PROPORTIONAL: std::ops::RangeInclusive<f64> = 0.9..=1.1;
/// What is measured.
const WHAT_IS_COMPARED: &str = "Balls are dropped from 0.1 to 0.3 m onto a spring of k/m = 1e3 1/s² and take 240 steps of 1/480 s by \
     symplectic Euler. A device steps them from one buffer into another, and nothing is drawn. Errors are \
     against the same integrator in f64, for 10 000 balls at most. A frame is four steps in one submission. \
     CPU time is that of the whole process, threads of a driver that draws on the CPU included.";

fn cases(run: &Run) -> Vec<&Case> {
    let own = run.of_study(crate::STUDY);
    own.filter(|case| !case.is_twin() && case.condition(PART) == "device")
        .collect()
}

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run) -> Vec<Block> {
    let cases = cases(run);
    if cases.is_empty() {
        return Vec::new();
    }
    vec![
        Block::section("Steps on devices"),
        Block::Text(WHAT_IS_COMPARED.to_owned()),
        Block::Table(table(&cases)),
    ]
}

fn table(cases: &[&Case]) -> Table {
    let rows = cases.iter().map(|case| {
        let balls = balls(case);
        let value = |metric| case.value(metric);
        let why = match case.reason.as_str() {
            "" => "not measured",
            reason => reason,
        };
        let shown = |value: Option<f64>| Cell::or_absent(value.map(significant), why);
        let timed = |metric| dotted(shown(value(metric)), case, metric);
        let gpu = match (case.counts(), value(GPU)) {
            (true, None) => Cell::absent("the device keeps no time"),
            _ => timed(GPU),
        };
        Row::new(vec![
            Cell::name(format!(
                "{} {}",
                case.condition(INTERFACE),
                case.condition(WAY)
            )),
            Cell::name(case.condition(BALLS)),
            shown(value(BALL_DEVICE_MAX_M)),
            shown(value(BALL_DEVICE_RMS_M)),
            timed(CPU),
            shown(value(CPU).map(|us| us * 1e3 / balls)),
            timed(WALL),
            gpu,
            shown(value(UPLOADED).map(|bytes| bytes / f64::from(STEPS / TIMED))),
        ])
    });
    let measured = |text: &str, metric: &Metric| Heading::metric(text, metric);
    Table {
        caption: "Balls on devices, by way and number of balls".to_owned(),
        headings: vec![
            Heading::plain("way"),
            Heading::plain("balls"),
            measured("largest error, m", BALL_DEVICE_MAX_M),
            measured("rms error, m", BALL_DEVICE_RMS_M),
            measured("CPU µs a step", CPU),
            measured("CPU ns a step and ball", CPU),
            measured("wall µs a step", WALL),
            measured("GPU µs a step", GPU),
            measured("uploaded a frame, B", UPLOADED),
        ],
        rows: rows.collect(),
        ..Table::default()
    }
}

/// What devices are compared by.
fn time(clock: Clock) -> &'static Metric {
    clock.pick(GPU, CPU)
}

fn balls(case: &Case) -> f64 {
    case.condition(BALLS).parse().unwrap_or(f64::NAN)
}

/// Slope of log time over log number of balls.
fn slope(first: (f64, f64), last: (f64, f64)) -> f64 {
    (last.1 / first.1).ln() / (last.0 / first.0).ln()
}

fn slope_of(cases: &[&Case], way: Way, clock: Clock) -> Option<f64> {
    let (interface, name) = way.names();
    let point = |count: &str| {
        let of_way = |case: &&&Case| {
            case.counts()
                && case.condition(INTERFACE) == interface
                && case.condition(WAY) == name
                && case.condition(BALLS) == count
        };
        let case = cases.iter().find(of_way)?;
        Some((balls(case), case.value(time(clock))?))
    };
    Some(slope(point(SLOPE[0])?, point(SLOPE[1])?))
}

/// The way that steps the most balls fastest, with what explains it.
pub(crate) fn recommended(run: &Run) -> Option<String> {
    let (cases, clock) = (cases(run), run.clock());
    let timed = cases
        .iter()
        .filter(|case| case.counts())
        .filter_map(|case| Some((balls(case), case.value(time(clock))?, *case)));
    let timed: Vec<(f64, f64, &Case)> = timed.collect();
    let most = timed.iter().map(|of| of.0).max_by(f64::total_cmp)?;
    let of_most = timed.iter().filter(|of| of.0 >= most);
    let (_, us, best) = of_most.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let uploaded = best.value(UPLOADED).map(significant).unwrap_or_default();
    Some(format!(
        "{most} balls are stepped fastest by {} {}: {} ns of {} a ball and step, {uploaded} bytes uploaded.",
        best.condition(INTERFACE),
        best.condition(WAY),
        significant(1e3 * us / most),
        clock.name(),
    ))
}

pub(crate) fn findings(run: &Run) -> Vec<Finding> {
    let (cases, clock) = (cases(run), run.clock());
    let mut findings = Vec::new();
    for way in Way::ALL {
        let (interface, name) = way.names();
        let slope = slope_of(&cases, way, clock);
        findings.push(finding(
            format!(
                "{} of a step by {interface} {name} grows as the balls do, from 1e4 to 1e6",
                clock.pick("GPU time", "CPU time")
            ),
            slope.map(|slope| PROPORTIONAL.contains(&slope)),
            slope.map_or_else(String::new, |slope| format!("slope {}", significant(slope))),
        ));
    }
    let judged = |case: &&&Case| case.counts() || case.outcome == Outcome::Wrong;
    let uploads: Vec<f64> = cases
        .iter()
        .filter(judged)
        .filter_map(|case| case.value(UPLOADED))
        .collect();
    let most = uploads.iter().copied().max_by(f64::total_cmp);
    findings.push(finding(
        "The CPU uploads nothing while balls step on a device".to_owned(),
        most.map(|most| most <= 0.0),
        most.map_or_else(String::new, |most| format!("at most {most} B")),
    ));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::RunEnvironment;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    /// The sentence on the fastest way, where the two clocks of the ways on Vulkan disagree.
    fn fastest(device_type: &str, gpu_timestamps: bool) -> String {
        let mut made = MadeUpRun {
            environment: RunEnvironment {
                device_type: device_type.to_owned(),
                gpu_timestamps,
                ..RunEnvironment::default()
            },
            ..MadeUpRun::default()
        };
        for (way, [gpu, cpu]) in [
            (Way::VulkanCompute, [1.0, 9.0]),
            (Way::VulkanFeedback, [3.4, 8.0]),
        ] {
            let (interface, name) = way.names();
            let conditions = [
                ("part", "device"),
                ("interface", interface),
                ("way", name),
                ("balls", "1000000"),
            ];
            let case = made.case(case_id(crate::STUDY, name, &conditions));
            case.timed(GPU, &[gpu]).timed(CPU, &[cpu]);
        }
        let folder = tempfile::tempdir().expect("a folder");
        let run = made.write(folder.path()).expect("a run");
        recommended(&run).expect("a sentence")
    }

    #[test]
    fn a_gpu_ranks_its_steps_by_its_own_clock_and_a_software_device_by_the_process() {
        let said = fastest("discrete-gpu", true);
        assert!(said.contains("by vulkan compute"), "{said}");
        assert!(said.contains("GPU time"), "{said}");
        // Negative control: process CPU time names the other way, and is said.
        let said = fastest("cpu", true);
        assert!(said.contains("by vulkan transform-feedback"), "{said}");
        assert!(said.contains("process CPU time"), "{said}");
    }

    #[test]
    fn time_in_proportion_has_slope_1_and_a_fixed_cost_has_less() {
        assert!((slope((1e4, 3.0), (1e6, 300.0)) - 1.0).abs() < 1e-12);
        assert!(PROPORTIONAL.contains(&slope((1e4, 3.3), (1e6, 300.0))));
        // Twins: a fixed cost as large as that of 1e4 balls, and growth by the power 1.2.
        assert!(!PROPORTIONAL.contains(&slope((1e4, 6.0), (1e6, 303.0))));
        assert!(!PROPORTIONAL.contains(&slope((1e4, 1.0), (1e6, 100_f64.powf(1.2)))));
    }
}
