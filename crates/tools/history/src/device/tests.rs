// SPDX-License-Identifier: MIT OR Apache-2.0

use super::*;
use std::path::Path;
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{Clock, Status};

fn primary(_: &str, clock: Clock) -> Option<&'static str> {
    Some(clock.pick("fill_gpu_ms", "fill_cpu_ms"))
}

/// A run in which the control takes 10 and the case `factor` times as much, by the device's own clock.
fn run(folder: &Path, name: &str, gpu: &str, is_hardware: bool, factor: f64) -> Run {
    let mut run = MadeUpRun::default();
    run.environment.gpu = gpu.to_owned();
    run.environment.device_type = if is_hardware { "discrete-gpu" } else { "cpu" }.to_owned();
    run.environment.gpu_timestamps = true;
    let metric = if is_hardware {
        "fill_gpu_ms"
    } else {
        "fill_cpu_ms"
    };
    let conditions = |technique| {
        [
            ("scene", "moon"),
            ("view", "globe"),
            ("technique", technique),
        ]
    };
    run.case(case_id("filling", "control", &conditions(CONTROL)))
        .timed(metric, &[10.0; 5]);
    run.case(case_id("filling", "vertex", &conditions("vertex")))
        .timed(metric, &[10.0 * factor; 5]);
    run.case(case_id("filling", "broken", &conditions("native")))
        .ended(Status::Failed, "device lost");
    run.case(case_id("filling", "bytes", &conditions("vertex")))
        .figure("draws", 3.0);
    run.write(&folder.join(name)).expect("written")
}

#[test]
fn each_device_is_measured_by_its_own_control() {
    let folder = tempfile::tempdir().expect("a folder");
    let runs = [
        run(folder.path(), "a", "software", false, 3.0),
        run(folder.path(), "b", "hardware", true, 0.5),
        run(folder.path(), "c", "hardware", true, 0.7),
    ];
    let table = by_device(&runs, CONTROL, &primary);
    let clocks: Vec<&str> = table
        .devices
        .iter()
        .map(|device| device.clock.as_str())
        .collect();
    assert_eq!(clocks, ["process CPU time", "GPU time"]);
    assert_eq!(table.devices[1].runs.len(), 2);
    let cases: Vec<&str> = table.rows.iter().map(|row| row.case.as_str()).collect();
    assert_eq!(
        cases,
        ["filling/broken", "filling/control", "filling/vertex"]
    );
    let ratios = |row: usize| -> Vec<Option<f64>> {
        let cells = table.rows[row].cells.iter();
        let ratio = |cell: &DeviceCell| match cell {
            DeviceCell::Ratio { ratio, .. } => Some((ratio * 1e6).round() / 1e6),
            DeviceCell::None { .. } => None,
        };
        cells.map(ratio).collect()
    };
    assert_eq!(ratios(0), [None, None]);
    assert_eq!(ratios(1), [Some(1.0), Some(1.0)]);
    assert_eq!(ratios(2), [Some(3.0), Some(0.6)]);
    // Negative control: without that control nothing has a ratio, and the reason is said.
    let table = by_device(&runs, "no-pass", &primary);
    assert!(matches!(
        &table.rows[2].cells[0],
        DeviceCell::None { reason, .. } if reason.contains("no time of no-pass")
    ));
}
