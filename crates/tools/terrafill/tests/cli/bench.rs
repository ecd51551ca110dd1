// SPDX-License-Identifier: MIT OR Apache-2.0
//! `bench`, `report` and `merge`: what a run writes, what it is asked for, and how it ends.

use crate::harness::{
    Desk, NAMED, QUICK, collection, has_device, is_progress, polygon, ran, rectangle,
};
use std::collections::{BTreeMap, BTreeSet};
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{Case, Outcome, REPEATS, Run};

/// Columns that scripts and the gate rely on, in this order.
const STABLE_COLUMNS: &str = "scene,view,backend,variant,status,reason,surface_gpu_ms,fill_gpu_ms,\
    fill_cpu_ms,bound_gpu_ms,bound_cpu_ms,floor_cpu_ms,fill_over_bound_cpu,geometry_bytes,\
    upload_bytes,draws,vertices,filled_px,mismatched_px,mismatched_px_outside_band,hausdorff_px,\
    left_out,";

/// Numbers of regions for which bytes are worked out, of a scene whose own number is among them.
const REGION_COUNTS: usize = 12;

/// Every file of a run and its report.
const FILES: [&str; 15] = [
    "cases.csv",
    "clocks.csv",
    "durations.csv",
    "environment.json",
    "features.csv",
    "index.html",
    "inputs.csv",
    "measurements.csv",
    "metrics.csv",
    "notes.csv",
    "plan.json",
    "result.json",
    "schema.json",
    "summary.csv",
    "summary.md",
];

/// California at a size that takes a moment, into the folder `out`.
fn quick<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let options = ["--quick", "--size", "64", "--out", out];
    [&["bench", "california"][..], &options, more].concat()
}

fn load(desk: &Desk, name: &str) -> Run {
    Run::load(&desk.path(name)).expect("a run")
}

/// Names of a run's cases.
fn names(run: &Run) -> BTreeSet<String> {
    run.cases.iter().map(|case| case.id().key()).collect()
}

#[test]
fn a_quick_run_writes_every_file_and_ends_with_0() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let options = [&["--samples", "2"][..], &NAMED].concat();
    let text = desk.run(&quick("run", &options)).succeeded();
    // In each view nine full-screen passes and fills, six full plans and what it needs; two textured ones, bytes of
    // seven layouts.
    let all = 3 * (9 + 6 + 1) + 2 + 7 * REGION_COUNTS;
    let counts = format!("{QUICK}{all} right, 0 wrong, 0 failed, 0 skipped");
    assert!(text.starts_with(&counts), "{text}");
    assert!(text.ends_with("report: run/index.html\n"), "{text}");
    // Each view has its tables: the best full plan of each technique, then what they are compared with.
    for view in ["globe", "top-down", "horizon"] {
        let own = text.split_once(&format!("\ncalifornia, {view}\n"));
        let own: Vec<&str> = own.expect(view).1.lines().take(7).collect();
        assert_eq!(own[3], format!("california, {view}, controls"));
        for (plan, control) in own[..3].iter().zip(&own[4..]) {
            assert!(plan.starts_with("  ") && plan.contains(", full plan"));
            assert!(control.starts_with("  ") && !control.contains(", full plan"));
        }
        assert!(own.iter().any(|line| line.ends_with(" 1.00")), "{text}");
    }
    // Negative control: a full-screen pass is no fill.
    assert!(!text.contains("depth-pass"), "{text}");
    assert_eq!(desk.names(), ["run"]);
    for name in FILES {
        assert!(!desk.read(&format!("run/{name}")).is_empty(), "{name}");
    }
    let summary = desk.read_text("run/summary.csv");
    assert!(summary.starts_with(STABLE_COLUMNS), "{summary}");
    let mut expected = BTreeSet::new();
    for view in ["globe", "top-down", "horizon"] {
        for technique in [
            "depth-pass/full-screen",
            "stencil-pass/full-screen",
            "vertex/doubled",
            "vertex/pulled",
            "compute/per-frame",
            "compute/cached",
            "native/vs-control",
            "native/gs-degenerate",
            "native/gs-line",
        ] {
            expected.insert(format!("filling/california/{view}/{technique}"));
        }
    }
    for route in ["chosen", "atan2-native+bowring-1"] {
        expected.insert(format!(
            "filling/california/top-down/vertex/doubled,texture={route}"
        ));
    }
    let run = load(&desk, "run");
    // The desk is in no repository: a run names the commit of its program, not of its folder.
    assert_eq!(run.environment.commit, env!("TERRAFILL_COMMIT"));
    let timed = run.cases.iter().filter(|case| case.planned.samples > 0);
    let drawn = timed.clone().filter(|case| !case.is_repeat());
    let (full_plans, plain): (Vec<&Case>, Vec<&Case>) =
        drawn.partition(|case| case.condition("role") == "main+full-plan");
    let plain: BTreeSet<String> = plain.into_iter().map(|case| case.id().key()).collect();
    assert_eq!(plain, expected);
    // Of three techniques, with and without levels of detail.
    assert_eq!(full_plans.len(), 3 * 6);
    assert!(timed.clone().any(Case::is_repeat), "identical work twice");
    for case in timed {
        assert_eq!(case.timed_samples(0).len(), 2, "{}", case.id());
    }
    let result: serde_json::Value =
        serde_json::from_slice(&desk.read("run/result.json")).expect("JSON");
    assert_eq!(
        (&result["verdict"], &result["exit_code"]),
        (&"good".into(), &0.into())
    );
    let html = desk.read_text("run/index.html");
    assert!(html.trim_end().ends_with("</html>") && html.contains("california"));
    let page = "run/pages/filling-california.html";
    assert!(
        desk.read_text(page)
            .contains("terrafill render california --view globe")
    );
    // The report again, from the tables alone and without a device.
    for name in ["index.html", "summary.csv", "summary.md", "result.json"] {
        std::fs::remove_file(desk.path(&format!("run/{name}"))).expect("removable");
    }
    let ran = desk.run_without_device(&["report", "run"]);
    assert_eq!(ran.succeeded(), "report: run/index.html\n");
    assert_eq!(desk.read_text("run/index.html"), html);
    assert_eq!(desk.read_text("run/summary.csv"), summary);
    // By other limits, which a report of the same folder then keeps.
    assert!(html.contains("Boundaries moved by at most 1 px"), "{html}");
    let limited = [
        "report",
        "run",
        "--tolerance-px",
        "0",
        "--budget-ms",
        "1e-6",
    ];
    desk.run_without_device(&limited).succeeded();
    desk.run_without_device(&["report", "run"]).succeeded();
    let limited = desk.read_text("run/index.html");
    for words in [
        "Boundaries moved by at most 0 px",
        "none is within",
        "over --budget-ms",
    ] {
        assert!(limited.contains(words), "{words}");
    }
    desk.write("none/x", "");
    desk.run(&["report", "none", "--max-mb", "1"])
        .refused(&[&["none/schema.json"]]);
    assert!(!desk.path("none/budget.json").exists());
    // And as one file.
    desk.run_without_device(&["report", "run", "--single-file"])
        .succeeded();
    let single = desk.read_text("run/index.html");
    assert!(single.contains("data:image/png;base64,") && !desk.path(page).exists());
    // A run in the same place is not mixed with this one.
    desk.run(&quick("run", &[]))
        .refused(&[&["run holds a run already", "--resume"]]);
}

#[test]
fn a_run_in_a_pipe_says_at_once_how_far_it_is_and_then_seldom() {
    let desk = Desk::new();
    let line = ["bench", "--study", "growth", "--quick", "--samples", "1"];
    let started = std::time::Instant::now();
    let output = desk.command(&line).output().expect("the program starts");
    let seconds = started.elapsed().as_secs();
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    let lines: Vec<&str> = said.lines().filter(|line| is_progress(line)).collect();
    let first = lines.first().copied().unwrap_or_default();
    let begins = "process 1/1; step 0 of ";
    assert!(
        first.starts_with(begins) && first.contains(" left"),
        "{said}"
    );
    assert!(lines.len() as u64 <= 1 + seconds / 5, "{seconds} s: {said}");
    // Negative control: what says nothing of how far it is.
    assert!(!is_progress("process 1 of the run: exit status: 2"));
}

#[test]
fn a_wrong_picture_ends_with_1() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let overlapping = collection(&[
        ("below", polygon(&rectangle(-8.0, -8.0, 4.0, 8.0))),
        ("above", polygon(&rectangle(-4.0, -8.0, 8.0, 8.0))),
    ]);
    desk.write_scene("overlap", &overlapping);
    let bench = |out: &str| {
        let options = [
            "--quick",
            "--size",
            "64",
            "--samples",
            "1",
            "--data",
            "data",
        ];
        let bench = ["bench", "overlap.toml", "--out", out];
        let arguments = [&bench[..], &options, &NAMED].concat();
        desk.run(&arguments)
    };
    // Two full-screen passes, and the bytes of seven layouts; eight fills and six full plans are not right.
    let other = 2 + 7 * REGION_COUNTS;
    // Disjoint is what the scene says; XOR colouring relies on it.
    let ran = bench("wrong");
    assert_eq!(ran.code, 1, "{}", ran.stdout);
    assert!(
        ran.stdout
            .starts_with(&format!("{QUICK}{other} right, 14 wrong")),
        "{}",
        ran.stdout
    );
    let truth = format!("overlap = \"ordered\"\n{}", desk.read_text("overlap.toml"));
    desk.write("overlap.toml", truth);
    let right = bench("right").succeeded();
    let all = other + 14;
    assert!(
        right.starts_with(&format!("{QUICK}{all} right, 0 wrong")),
        "{right}"
    );
}

#[test]
fn nothing_to_measure_ends_with_4() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let ran = desk.run(&["bench", "countries-110m", "--out", "run"]);
    assert_eq!(ran.code, 4, "{}", ran.stderr);
    let skipped = "skipped: countries-110m: ";
    assert!(ran.stderr.starts_with(skipped), "{}", ran.stderr);
    assert!(
        ran.stderr.contains("TERRAFILL_DATA is not set"),
        "{}",
        ran.stderr
    );
    let ran = desk.run(&["bench", "california", "--shard", "4/4", "--out", "shard"]);
    assert_eq!(ran.code, 4, "{}", ran.stderr);
}

#[test]
#[cfg(unix)]
fn a_report_is_opened_by_the_systems_program_where_that_is_asked_for() {
    use std::os::unix::fs::PermissionsExt as _;
    let desk = Desk::new();
    let mut made = MadeUpRun::default();
    let conditions = [
        ("scene", "moon"),
        ("view", "globe"),
        ("technique", "vertex"),
    ];
    made.case(case_id("filling", "moon/globe/vertex/doubled", &conditions))
        .timed("fill_cpu_ms", &[1.5]);
    made.write(&desk.path("run")).expect("a run");
    let opener = "#!/bin/sh\nprintf %s \"$1\" > opened.new && mv opened.new opened\n";
    desk.write("bin/xdg-open", opener);
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(desk.path("bin/xdg-open"), executable).expect("ours");
    let report = |path: &str, more: &[&str]| {
        let mut command = desk.command(&[&["report", "run"][..], more].concat());
        ran(command.env("PATH", path))
    };
    let path = format!("{}:/usr/bin:/bin", desk.path("bin").display());
    let plain = report(&path, &[]);
    // Negative controls: without the option nothing is opened, and without the program the report is written.
    let nowhere = desk.path("none").display().to_string();
    let without = report(&nowhere, &["--open"]);
    assert_eq!((without.code, &without.stdout), (plain.code, &plain.stdout));
    let warning = "warning: --open: xdg-open: ";
    assert!(without.stderr.contains(warning), "{}", without.stderr);
    assert!(!desk.path("opened").exists());
    let opened = report(&path, &["--open"]);
    assert_eq!((opened.code, &opened.stdout), (plain.code, &plain.stdout));
    for _ in 0..500 {
        if desk.path("opened").exists() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    assert_eq!(desk.read_text("opened"), "run/index.html");
}

#[test]
fn a_folder_without_a_run_has_no_report_and_cannot_be_resumed() {
    let desk = Desk::new();
    desk.write("folder/file", "");
    for folder in ["none", "folder", "folder/file"] {
        let schema = format!("{folder}/schema.json: no such file");
        let no_run = format!("{folder} is no folder of a run, which holds schema.json, plan.json");
        desk.run(&["report", folder])
            .refused(&[&[&schema, &no_run]]);
        assert!(!desk.path("none").exists());
    }
    if has_device() {
        desk.run(&quick("run", &["--resume"]))
            .refused(&[&["run/schema.json"]]);
        assert_eq!(desk.names(), ["folder"]);
    }
}

#[test]
fn a_study_is_named_as_it_is_listed() {
    let desk = Desk::new();
    desk.run(&["bench", "--study", "nosuch"])
        .refused(&[&["--study: found \"nosuch\", allowed: filling, precision, growth"]]);
    assert_eq!(desk.names(), [""; 0], "nothing was written");
    // Only the named one is measured, and once however often it is named.
    let growth = ["bench", "--study", "growth", "--study", "growth"];
    let options = ["--quick", "--samples", "1", "--out", "run"];
    let ran = desk.run_without_device(&[&growth[..], &options].concat());
    let text = ran.succeeded();
    assert!(
        text.starts_with(&format!("{QUICK}24 right, 0 wrong")),
        "{text}"
    );
    let run = load(&desk, "run");
    assert!(run.cases.iter().all(|case| case.id().study == "growth"));
    assert!(!desk.path("run/summary.csv").exists(), "of filling alone");
}

/// The example that ships: a hut and its mast.
const HUT: &str = include_str!("../../../../../bench-scenes/hut.obj");
/// One side of its roof.
const LID: &str = "f 6 7 10 9\n";

#[test]
fn a_model_of_one_s_own_gets_the_rows_of_study_shadows() {
    let desk = Desk::new();
    desk.write("hut.obj", HUT);
    let bench = |casters: &'static str, out: &'static str| {
        let options = ["bench", "--study", "shadows", "--quick", "--samples", "1"];
        [&options[..], &["--casters", casters, "--out", out]].concat()
    };
    let ran = desk.run(&bench("hut.obj,up=z", "run")).succeeded();
    assert!(ran.contains(" right, 0 wrong, 0 failed"), "{ran}");
    let run = load(&desk, "run");
    let model = run
        .cases
        .iter()
        .find(|case| case.id().name == "model/hut.obj");
    let model = model.expect("a verdict");
    assert_eq!(model.reason, "policy refuse: closed");
    assert_eq!(model.value("shadow_mesh_triangles"), Some(22.0));
    let asked = |question: &str| {
        let all = run.cases.iter();
        let own = all.filter(|case| case.condition("question") == question);
        own.filter(|case| case.condition("model") == "hut.obj")
            .count()
    };
    for question in ["updates", "scissors", "silhouettes", "devices", "maps"] {
        assert!(asked(question) > 0, "{question}");
    }
    assert_eq!(asked("eyes"), 0, "of the port's deck");
    let page = desk.read_text("run/pages/shadows.html");
    assert!(
        page.contains("A model from a file"),
        "the chapter says what it is of"
    );

    // Without its lid it is refused by name, closed by a policy, and refused again where that cannot help.
    desk.write("open.obj", HUT.replace(LID, ""));
    let open = "open.obj: border 4 edges, the first from";
    desk.run(&bench("open.obj,up=z", "none")).refused(&[&[
        open,
        "refused by policy refuse; policies: refuse, cap, robust, as-is",
    ]]);
    assert!(!desk.path("none").exists(), "nothing was written");
    let capped = desk.run(&bench("open.obj,up=z,policy=cap", "capped"));
    capped.succeeded();
    let run = load(&desk, "capped");
    let model = run
        .cases
        .iter()
        .find(|case| case.id().name == "model/open.obj");
    assert!(model.is_some_and(|case| case.reason.starts_with("policy cap: border 4 edges")));
    desk.write("flipped.obj", HUT.replace(LID, "f 9 10 7 6\n"));
    desk.run(&bench("flipped.obj,up=z,policy=cap", "none"))
        .refused(&[&["flipped.obj: flipped 4 edges", "refused by policy cap"]]);
}

#[test]
fn casters_that_are_none_are_refused_with_place_and_what_is_allowed() {
    let desk = Desk::new();
    desk.write("hut.obj", HUT);
    desk.write("torn.obj", HUT.replace("f 4 3 2 1\n", "f 4 3 2 16\n"));
    desk.write("text.glb", "no model");
    let bench = |study: &'static str, casters: &'static str| {
        ["bench", "--study", study, "--quick", "--casters", casters]
    };
    for (casters, phrase) in [
        ("none.obj", "none.obj: "),
        (
            "hut.txt",
            r#"hut.txt: extension: found "txt", allowed: obj, glb"#,
        ),
        (
            "torn.obj",
            r#"torn.obj: line 13: found "f 4 3 2 16", allowed: vertices 1 … 15, or -10 … -1"#,
        ),
        (
            "text.glb",
            r#"text.glb: first bytes: found "no m", allowed: "glTF""#,
        ),
        ("hut.obj,up=x", r#"--casters: up: found "x", allowed: y, z"#),
    ] {
        desk.run(&bench("shadows", casters)).refused(&[&[phrase]]);
    }
    desk.run(&bench("growth", "hut.obj"))
        .refused(&[&["--casters: found --study growth, allowed: shadows"]]);
    assert_eq!(desk.names().len(), 3, "nothing was written");
}

#[test]
fn old_names_of_options_still_work() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let plan = |out: &str, options: [&str; 4]| {
        desk.run(&quick(out, &options)).succeeded();
        desk.read_text(&format!("{out}/plan.json"))
    };
    let old = plan("old", ["--backend", "vertex", "--frames", "1"]);
    let new = plan("new", ["--technique", "vertex", "--samples", "1"]);
    assert_eq!(old, new);
    // Negative control: another technique, and another number of samples.
    for (out, options) in [
        ("compute", ["--technique", "compute", "--samples", "1"]),
        ("two", ["--technique", "vertex", "--samples", "2"]),
    ] {
        assert_ne!(plan(out, options), new, "{out}");
    }
}

const TWO_PROCESSES: [&str; 6] = [
    "--technique",
    "vertex",
    "--samples",
    "2",
    "--processes",
    "2",
];

#[test]
fn two_processes_are_two_replicates_and_the_second_rechecks_every_picture() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    desk.run(&quick("run", &TWO_PROCESSES)).succeeded();
    let run = load(&desk, "run");
    let timed = run.cases.iter().filter(|case| case.planned.samples > 0);
    assert!(timed.clone().count() > 9);
    for case in timed {
        assert_eq!(case.replicates("fill_cpu_ms").len(), 2, "{}", case.id());
        for process in 0..2 {
            assert_eq!(case.timed_samples(process).len(), 2, "{}", case.id());
        }
    }
    // Figures of the picture are the first process's.
    let rows = desk.read_text("run/measurements.csv");
    assert!(rows.contains(",geometry_bytes,0,0,"));
    assert!(!rows.lines().any(|row| row.contains(",1,0,")), "{rows}");

    // Had the first process seen another picture, the second would notice.
    let first: Vec<&str> = rows.lines().filter(|row| !of_process(row, "1")).collect();
    desk.write("run/measurements.csv", first.join("\n") + "\n");
    let notes = desk.read_text("run/notes.csv");
    let case = "filling/california/globe/vertex/pulled";
    let hash = notes
        .lines()
        .find_map(|row| row.strip_prefix(&format!("{case},mask_hash,")))
        .expect("a hash");
    let changed = notes.replace(
        &format!("{case},mask_hash,{hash}"),
        &format!("{case},mask_hash,0000000000000000"),
    );
    desk.write("run/notes.csv", changed);
    let resumed = [&TWO_PROCESSES[..], &["--resume"]].concat();
    let ran = desk.run(&quick("run", &resumed));
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    let run = load(&desk, "run");
    let failed: Vec<&Case> = run
        .cases
        .iter()
        .filter(|case| case.outcome == Outcome::Failed && !case.is_repeat())
        .collect();
    let [failed] = failed[..] else {
        panic!("{} failed", failed.len());
    };
    assert_eq!(failed.id().key(), case);
    assert!(failed.reason.contains("another one"), "{}", failed.reason);
}

/// Whether a row of `measurements.csv` is of this process.
fn of_process(row: &str, process: &str) -> bool {
    row.rsplit(',').nth(2) == Some(process)
}

#[test]
fn shards_together_are_the_whole_run_and_nothing_less_is_merged() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let bench = |out: &str, more: &[&str]| {
        let options = [&["--technique", "vertex", "--samples", "1"][..], more].concat();
        desk.run(&quick(out, &options)).succeeded();
    };
    bench("whole", &[]);
    bench("one", &["--shard", "1/2"]);
    bench("two", &["--shard", "2/2"]);
    let merged = desk
        .run(&["merge", "two", "one", "--out", "all"])
        .succeeded();
    assert_eq!(merged, "report: all/index.html\n");
    let (whole, all) = (load(&desk, "whole"), load(&desk, "all"));
    assert_eq!(names(&all), names(&whole));
    assert_ne!(names(&load(&desk, "one")), names(&whole));
    let statuses = |run: &Run| -> BTreeMap<String, (Outcome, String)> {
        let cases = run.cases.iter();
        let picture = |case: &Case| (case.outcome, case.note("mask_hash").to_owned());
        cases.map(|case| (case.id().key(), picture(case))).collect()
    };
    let equal = statuses(&all) == statuses(&whole);
    assert!(equal, "other pictures");
    for name in FILES {
        assert!(desk.path(&format!("all/{name}")).is_file(), "{name}");
    }
    let refused = |parts: &[&str], phrases: &[&str]| {
        let merge = [&["merge"][..], parts, &["--out", "none"]].concat();
        desk.run(&merge).refused(&[phrases]);
        assert!(!desk.path("none").exists(), "{parts:?}");
    };
    refused(&["one"], &["shards 2 of 2 are missing"]);
    refused(
        &["one", "two", "one"],
        &["shard 1/2: found in one and in one"],
    );
    refused(&["whole", "one"], &["whole: a whole run, allowed: shards"]);
    refused(&["one", "lost"], &["lost/schema.json"]);

    // Balanced by how long that run took, both at once, as on two machines.
    let by = [
        "--technique",
        "vertex",
        "--samples",
        "1",
        "--shard-by",
        "duration:whole",
    ];
    let shard = |out: &str, shard: &str| {
        let options = [&by[..], &["--shard", shard]].concat();
        desk.command(&quick(out, &options))
            .spawn()
            .expect("the program starts")
    };
    for child in [shard("long", "1/2"), shard("rest", "2/2")] {
        let ended = child.wait_with_output().expect("ends");
        assert!(
            ended.status.success(),
            "{}",
            String::from_utf8_lossy(&ended.stderr)
        );
    }
    desk.run(&["merge", "long", "rest", "--out", "balanced"])
        .succeeded();
    let balanced = load(&desk, "balanced");
    assert_eq!(names(&balanced), names(&whole));
    assert_eq!(balanced.environment.options, whole.environment.options);
    for run in [load(&desk, "long"), load(&desk, "rest")] {
        for repeat in run.cases.iter().filter(|case| case.is_repeat()) {
            let original = run.case(repeat.condition(REPEATS));
            assert!(
                original.is_some(),
                "{}: its pair is in another shard",
                repeat.id()
            );
        }
    }
    // Negative controls: shards that were shared in two ways, and a run that says no durations.
    refused(&["one", "rest"], &["shard-by=duration"]);
    std::fs::remove_file(desk.path("whole/durations.csv")).expect("there");
    desk.run(&quick("none", &[&by[..], &["--shard", "1/2"]].concat()))
        .refused(&[&["--shard-by", "durations.csv"]]);
}

#[test]
fn a_growth_sample_is_two_numbers_of_the_region_of_a_file() {
    let desk = Desk::new();
    let square = r#"{"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1],[0,1],[0,0]]]}"#;
    desk.write("square.geojson", square);
    let sample = desk.run(&["growth-sample", "square.geojson"]).succeeded();
    let numbers: Vec<f64> = sample
        .split_whitespace()
        .map(|word| word.parse().expect("a number"))
        .collect();
    assert!(
        matches!(numbers[..], [4.0, cpu_ms] if cpu_ms > 0.0),
        "{sample}"
    );
    // Negative controls: no file, and one whose region crosses itself.
    desk.write(
        "bow-tie.geojson",
        square.replace("[1,1],[0,1]", "[0,1],[1,1]"),
    );
    for (file, why) in [
        ("missing.geojson", "No such file"),
        ("bow-tie.geojson", "crosses"),
    ] {
        let wrong = desk.run(&["growth-sample", file]);
        assert_eq!(wrong.code, 2);
        assert!(
            wrong.stderr.contains(file) && wrong.stderr.contains(why),
            "{}",
            wrong.stderr
        );
    }
}

/// What stands for Slurm: runs each task of an array at once, or a single job, and prints a job's number.
const SBATCH: &str = r#"#!/usr/bin/env bash
set -eu
count=0
for argument in "$@"; do
    case "$argument" in
        --array=1-*) count=${argument#--array=1-} ;;
        --wrap=*) work=${argument#--wrap=} ;;
    esac
done
if [ "$count" = 0 ]; then
    bash -c "$work" >&2
fi
tasks=
for task in $(seq "$count"); do
    SLURM_ARRAY_TASK_ID=$task bash -c "$work" >&2 &
    tasks+=" $!"
done
for task in $tasks; do
    wait "$task"
done
echo 7
"#;

#[test]
#[cfg(unix)]
fn the_slurm_example_measures_its_shards_at_once_and_joins_them() {
    use std::os::unix::fs::PermissionsExt as _;
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    desk.write("bin/sbatch", SBATCH);
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(desk.path("bin/sbatch"), executable).expect("ours");
    let repository = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let path = std::env::var("PATH").unwrap_or_default();
    let output = std::process::Command::new("bash")
        .arg(repository.join("ci/examples/shards-slurm.sh"))
        .arg("2")
        .arg(desk.path("out of 2"))
        .args([
            "california",
            "--quick",
            "--size",
            "48",
            "--samples",
            "1",
            "--technique",
            "vertex",
        ])
        .env("TERRAFILL", env!("CARGO_BIN_EXE_terrafill"))
        .env("PATH", format!("{}:{path}", desk.path("bin").display()))
        .env_remove("TERRAFILL_DATA")
        .output()
        .expect("bash");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let parts = ["shard-1", "shard-2"].map(|part| names(&load(&desk, &format!("out of 2/{part}"))));
    let all = names(&load(&desk, "out of 2/all"));
    assert!(
        parts
            .iter()
            .all(|part| !part.is_empty() && part.len() < all.len())
    );
    let joined: BTreeSet<String> = parts.into_iter().flatten().collect();
    assert_eq!(joined, all);
}
