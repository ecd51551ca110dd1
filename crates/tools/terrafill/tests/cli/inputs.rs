// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every run says which files it read, be its scenes named or the studies' own.

use crate::harness::{Desk, has_device};
use terrafill_results::{INPUT_COLUMNS, read_inputs};

/// Regions of the shipped scene `california`.
const CALIFORNIA: &[u8] = include_bytes!("../../../../../bench-scenes/california.geojson");

#[test]
fn a_run_that_names_no_scene_says_which_files_it_read() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let run = |study: &str, out: &str| {
        let options = ["--quick", "--size", "32", "--samples", "1", "--out", out];
        let line = ["bench", "--study", study, "--technique", "vertex"];
        let ran = desk.run(&[&line[..], &options].concat());
        assert_eq!(ran.code, 0, "{study}: {}", ran.stderr);
        read_inputs(&desk.path(out)).expect("a table")
    };
    let read = run("filling", "fills");
    let name = "bench-scenes/california.geojson";
    let row = read.iter().find(|row| row.file == name);
    let row = row.unwrap_or_else(|| panic!("{name} is not in {read:?}"));
    assert_eq!(row.scene, "california");
    assert_eq!(row.sha256, terrafill_scene::sha256_hex(CALIFORNIA));
    // A scene that is made from a seed has no file.
    assert!(read.iter().all(|row| row.scene != "planet-134"), "{read:?}");
    let page = desk.read_text("fills/index.html");
    assert!(page.contains(&row.sha256));
    // Negative control: a run that reads no file says so, by a table without rows.
    assert_eq!(run("readback", "none"), []);
    let header = format!("{}\n", INPUT_COLUMNS.join(","));
    assert_eq!(desk.read_text("none/inputs.csv"), header);
}
