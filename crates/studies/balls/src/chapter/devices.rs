// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter's section on balls that step on devices.

use super::number::number;
use crate::metrics::*;
use crate::stepping::Stepping;
use terrafill_lab::{Cases, Column, Figure, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Clock, Finding, Metric};

/// Numbers of balls between which the slope is taken.
const SLOPE: [&str; 2] = ["10000", "1000000"];
/// Slopes of log time over log number of balls that count as proportional.
pub(super) const PROPORTIONAL: std::ops::RangeInclusive<f64> = 0.9..=1.1;

pub(super) const SECTION: Section<'static> = Section {
    title: "Steps on devices",
    text: "Balls are dropped from 0.1 to 0.3 m onto a spring of k/m = 1e3 1/s² and take 240 steps of 1/480 s by \
           symplectic Euler. A device steps them from one buffer into another, and nothing is drawn. Errors are \
           against the same integrator in f64, for 10 000 balls at most. A frame is four steps in one submission. \
           CPU time is that of the whole process, threads of a driver that draws on the CPU included.",
    cases: Select::With(PART, "device"),
    named_by: Names::Columns(&[("interface", INTERFACE), ("way", WAY), ("balls", BALLS)]),
    columns: &[
        Column::metric("largest error, m", BALL_DEVICE_MAX_M),
        Column::metric("rms error, m", BALL_DEVICE_RMS_M),
        Column::metric("CPU µs a step", BALL_STEP_CPU_US),
        Column::of(
            "CPU ns a step and ball",
            Figure::Computed(|case| {
                Some(1e3 * case.value(BALL_STEP_CPU_US)? / number(case, BALLS))
            }),
        ),
        Column::metric("wall µs a step", BALL_STEP_WALL_US),
        Column::metric("GPU µs a step", BALL_STEP_GPU_US).or("the device keeps no time"),
        Column::metric("uploaded in all steps", BALL_UPLOAD_BYTES),
    ],
    ..Section::EMPTY
};

/// What devices are compared by.
fn time(clock: Clock) -> &'static Metric {
    clock.pick(BALL_STEP_GPU_US, BALL_STEP_CPU_US)
}

/// By what a way is: no device's clock covers what the CPU steps.
fn time_of(way: Stepping, clock: Clock) -> &'static Metric {
    match way {
        Stepping::Cpu => BALL_STEP_CPU_US,
        _ => time(clock),
    }
}

/// What that is called.
pub(super) fn time_name(way: Stepping, clock: Clock) -> &'static str {
    match way {
        Stepping::Cpu => "CPU time",
        _ => clock.pick("GPU time", "CPU time"),
    }
}

/// Slope of log time over log number of balls.
fn slope(first: (f64, f64), last: (f64, f64)) -> f64 {
    (last.1 / first.1).ln() / (last.0 / first.0).ln()
}

fn slope_of(cases: &Cases<'_>, way: Stepping) -> Option<f64> {
    let (interface, name) = way.names();
    let own = cases.with(&[(INTERFACE, interface), (WAY, name)]);
    let point = |count: &str| {
        let case = own
            .with(&[(BALLS, count)])
            .iter()
            .find(|case| case.counts())?;
        Some((
            number(case, BALLS),
            case.value(time_of(way, cases.clock()))?,
        ))
    };
    Some(slope(point(SLOPE[0])?, point(SLOPE[1])?))
}

/// The way that steps the most balls fastest, with what explains it.
pub(super) fn recommended(cases: &Cases<'_>) -> Option<String> {
    let clock = cases.clock();
    let timed = cases.with(&[(PART, "device")]);
    let timed = timed.fitting(|case| case.counts() && case.value(time(clock)).is_some());
    let balls = |case: &Case| number(case, BALLS);
    let most = timed.iter().map(balls).max_by(f64::total_cmp)?;
    let best = timed
        .fitting(|case| balls(case) >= most)
        .best(time(clock))?;
    let name = |case: &Case| format!("{} {}", case.condition(INTERFACE), case.condition(WAY));
    let uploaded = best.case.value(BALL_UPLOAD_BYTES).map(significant);
    Some(format!(
        "{most} balls are stepped fastest by {}{}: {} ns of {} a ball and step, {} bytes uploaded.",
        name(best.case),
        best.tied_with(name),
        significant(1e3 * best.value / most),
        clock.name(),
        uploaded.unwrap_or_default(),
    ))
}

pub(super) fn findings(cases: &Cases<'_>) -> Vec<Finding> {
    let own = cases.with(&[(PART, "device")]);
    let of_way = |way: Stepping| {
        let (interface, name) = way.names();
        let slope = slope_of(&own, way);
        finding(
            format!(
                "{} of a step by {interface} {name} grows as the balls do, from 1e4 to 1e6:",
                time_name(way, cases.clock())
            ),
            slope.map(|slope| PROPORTIONAL.contains(&slope)),
            slope.map_or_else(String::new, |slope| format!("slope {}", significant(slope))),
        )
    };
    let devices = own.fitting(|case| case.condition(INTERFACE) != Stepping::Cpu.names().0);
    let most = devices.greatest(BALL_UPLOAD_BYTES);
    let mut findings = Stepping::ALL.map(of_way).to_vec();
    findings.push(finding(
        "The CPU uploads nothing while balls step on a device:",
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
            (Stepping::VulkanCompute, [1.0, 9.0]),
            (Stepping::VulkanFeedback, [3.4, 8.0]),
        ] {
            let (interface, name) = way.names();
            let conditions = [
                ("part", "device"),
                ("interface", interface),
                ("way", name),
                ("balls", "1000000"),
            ];
            let case = made.case(case_id(crate::STUDY, name, &conditions));
            case.timed(BALL_STEP_GPU_US, &[gpu])
                .timed(BALL_STEP_CPU_US, &[cpu]);
        }
        recommended(&Cases::of_study(&made.loaded(), crate::STUDY)).expect("a sentence")
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
        // Negative controls: a fixed cost as large as that of 1e4 balls, and growth by the power 1.2.
        assert!(!PROPORTIONAL.contains(&slope((1e4, 6.0), (1e6, 303.0))));
        assert!(!PROPORTIONAL.contains(&slope((1e4, 1.0), (1e6, 100_f64.powf(1.2)))));
    }
}
