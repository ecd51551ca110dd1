// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run folder through its life: written, killed, read, resumed. Each rule has a twin that breaks
//! it on purpose and must be noticed.

use std::fs;
use std::path::Path;
use terrafill_results::legacy::{
    CaseKey, LadderRung, MemoryRow, PrecisionGrid, PrecisionPart, PrecisionPlan, PrecisionRow,
    PrecisionTime, RunEnvironment, RunError, RunFolder, RunPlan, Sample, Status, Summary,
};

/// The stable part of `summary.csv`, word for word from the design's §6.
const STABLE_SUMMARY_HEADER: &str = "scene,view,backend,variant,status,reason,surface_gpu_ms,\
    fill_gpu_ms,fill_cpu_ms,bound_gpu_ms,bound_cpu_ms,floor_cpu_ms,fill_over_bound_cpu,\
    geometry_bytes,upload_bytes,draws,vertices,filled_px,mismatched_px,\
    mismatched_px_outside_band,hausdorff_px,left_out";

const SAMPLES_HEADER: &str = "scene,view,backend,variant,frame,surface_gpu_ms,stencil_gpu_ms,\
    colour_gpu_ms,fill_gpu_ms,fill_cpu_ms,fill_wall_ms";

fn key(variant: &str) -> CaseKey {
    CaseKey {
        scene: "planet-134".to_owned(),
        view: "globe".to_owned(),
        backend: "vertex".to_owned(),
        variant: variant.to_owned(),
    }
}

fn plan(variants: &[&str]) -> RunPlan {
    RunPlan {
        cases: variants.iter().map(|variant| key(variant)).collect(),
        frames: 2,
        warm_up: 1,
        ..RunPlan::default()
    }
}

fn summary(variant: &str, fill_cpu_ms: Option<f64>) -> Summary {
    Summary {
        fill_cpu_ms,
        ..Summary::new(key(variant), Status::Ok)
    }
}

fn samples(variant: &str, fill_cpu_ms: &[f64]) -> Vec<Sample> {
    let key = key(variant);
    fill_cpu_ms
        .iter()
        .zip(0..)
        .map(|(&fill_cpu_ms, frame)| Sample {
            scene: key.scene.clone(),
            view: key.view.clone(),
            backend: key.backend.clone(),
            variant: key.variant.clone(),
            frame,
            surface_gpu_ms: None,
            stencil_gpu_ms: Some(0.5),
            colour_gpu_ms: None,
            fill_gpu_ms: Some(1.0),
            fill_cpu_ms,
            fill_wall_ms: fill_cpu_ms,
        })
        .collect()
}

fn start(path: &Path, variants: &[&str]) -> RunFolder {
    RunFolder::create(path, &RunEnvironment::default(), &plan(variants)).expect("an empty folder")
}

/// A run of `a` and `b`, `c` still to do.
fn half_done(path: &Path) -> RunFolder {
    let run = start(path, &["a", "b", "c"]);
    for variant in ["a", "b"] {
        run.append_samples(&samples(variant, &[1.0, 2.0]))
            .expect("samples");
        run.append_summary(&summary(variant, Some(1.5)))
            .expect("summary");
    }
    run
}

fn append_text(path: &Path, text: &str) {
    let old = fs::read_to_string(path).expect("the file");
    fs::write(path, old + text).expect("writable");
}

fn header(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("the file");
    text.lines().next().expect("a header").to_owned()
}

#[test]
fn the_headers_are_the_stable_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    half_done(folder.path());
    let summary = header(&folder.path().join("summary.csv"));
    assert!(
        summary.starts_with(&format!("{STABLE_SUMMARY_HEADER},")),
        "{summary}"
    );
    assert_eq!(header(&folder.path().join("samples.csv")), SAMPLES_HEADER);
    // Twin: with two columns swapped, the comparison above would fail.
    let swapped = STABLE_SUMMARY_HEADER.replace("draws,vertices", "vertices,draws");
    assert!(!summary.starts_with(&swapped));
}

#[test]
fn rows_come_back_as_they_went_in() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = start(folder.path(), &["a"]);
    let row = Summary {
        reason: "two lines,\nand \"quotes\"".to_owned(),
        hausdorff_px: Some(0.1 + 0.2),
        geometry_bytes: Some(u64::MAX),
        ..summary("a", None)
    };
    run.append_summary(&row).expect("summary");
    let frames = samples("a", &[1.0 / 3.0, 2e-300]);
    run.append_samples(&frames).expect("samples");
    assert_eq!(run.summaries().expect("rows"), [row]);
    assert_eq!(run.samples().expect("rows"), frames);
}

#[test]
fn what_was_not_measured_is_an_empty_cell() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = start(folder.path(), &["a"]);
    run.append_summary(&summary("a", None)).expect("summary");
    let text = fs::read_to_string(folder.path().join("summary.csv")).expect("the file");
    let cells: Vec<&str> = text.lines().nth(1).expect("a row").split(',').collect();
    let column = |name: &str| {
        let index = text.lines().next().expect("header").split(',');
        cells[index.clone().position(|cell| cell == name).expect(name)]
    };
    assert_eq!(column("fill_cpu_ms"), "");
    assert_eq!(column("mismatched_px"), "");
    assert_eq!(column("status"), "ok");
}

#[test]
fn a_torn_last_line_is_dropped_and_a_torn_middle_one_is_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = half_done(folder.path());
    append_text(&folder.path().join("summary.csv"), "planet-134,globe,ver");
    append_text(&folder.path().join("samples.csv"), "planet-134,globe");
    assert_eq!(run.summaries().expect("the whole rows").len(), 2);
    assert_eq!(run.samples().expect("the whole rows").len(), 4);
    // Twin: the same piece with a line end after it was not torn by a kill.
    append_text(&folder.path().join("summary.csv"), "\n");
    let error = run.summaries().expect_err("a short row");
    let RunError::Row { path, row, .. } = &error else {
        panic!("{error}");
    };
    assert!(path.ends_with("summary.csv"));
    assert_eq!(*row, 4, "header is 1, two rows, then the bad one");
}

#[test]
fn a_row_torn_inside_a_quoted_line_end_is_dropped() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = half_done(folder.path());
    append_text(
        &folder.path().join("summary.csv"),
        "planet-134,globe,vertex,c,failed,\"first line\nsecond",
    );
    assert_eq!(run.summaries().expect("the whole rows").len(), 2);
}

#[test]
fn a_value_that_is_no_number_is_an_error_with_its_row() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = half_done(folder.path());
    let path = folder.path().join("samples.csv");
    append_text(&path, "planet-134,globe,vertex,c,0,,,,,fast,1\n");
    let message = run.samples().expect_err("not a number").to_string();
    assert!(
        message.contains("samples.csv, row 6: column fill_cpu_ms holds \"fast\""),
        "{message}"
    );
}

#[test]
fn missing_cases_are_named_in_the_plans_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = start(folder.path(), &["c", "a", "b"]);
    assert_eq!(run.missing().expect("a plan").len(), 3);
    run.append_summary(&summary("a", None)).expect("summary");
    assert_eq!(run.missing().expect("a plan"), [key("c"), key("b")]);
    // A case that nobody planned does not stand in for one that was.
    run.append_summary(&summary("z", None)).expect("summary");
    assert_eq!(run.missing().expect("a plan").len(), 2);
}

#[test]
fn the_last_row_of_a_case_counts() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = half_done(folder.path());
    run.append_summary(&summary("a", Some(9.0)))
        .expect("summary");
    let mut again = samples("a", &[7.0]);
    run.append_samples(&again).expect("samples");
    let rows = run.summaries().expect("rows");
    let values: Vec<_> = rows
        .iter()
        .map(|row| (row.variant.as_str(), row.fill_cpu_ms))
        .collect();
    assert_eq!(values, [("b", Some(1.5)), ("a", Some(9.0))]);
    let kept = run.samples().expect("rows");
    let of_a: Vec<_> = kept.iter().filter(|row| row.variant == "a").collect();
    again[0].frame = 0;
    assert_eq!(of_a.len(), 2);
    assert_eq!(of_a[1], &again[0], "frame 0 was replaced");
    assert!((of_a[0].fill_cpu_ms - 2.0).abs() < 1e-12, "frame 1 stays");
}

#[test]
fn resuming_drops_the_torn_row_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = half_done(folder.path());
    run.append_samples(&samples("c", &[3.0])).expect("samples");
    append_text(&folder.path().join("samples.csv"), "planet-134,globe,ve");
    let run = RunFolder::resume(folder.path(), &plan(&["a", "b", "c"])).expect("same plan");
    assert_eq!(run.samples().expect("rows").len(), 5);
    assert_eq!(run.missing().expect("a plan"), [key("c")]);
    run.append_samples(&samples("c", &[3.0, 4.0])[1..])
        .expect("samples of the frames that are still to do");
    run.append_summary(&summary("c", Some(3.5)))
        .expect("summary");
    assert_eq!(run.samples().expect("rows").len(), 6);
    assert!(run.missing().expect("a plan").is_empty());
    let text = fs::read_to_string(folder.path().join("summary.csv")).expect("the file");
    assert_eq!(text.matches("scene,view").count(), 1, "one header");
}

#[test]
fn resuming_a_run_killed_in_its_header_works() {
    let folder = tempfile::tempdir().expect("a folder");
    start(folder.path(), &["a"]);
    fs::write(folder.path().join("summary.csv"), "scene,vie").expect("writable");
    let run = RunFolder::resume(folder.path(), &plan(&["a"])).expect("same plan");
    run.append_summary(&summary("a", Some(1.0)))
        .expect("summary");
    assert_eq!(run.summaries().expect("rows").len(), 1);
}

#[test]
fn another_plan_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    half_done(folder.path());
    let error = RunFolder::resume(folder.path(), &plan(&["a", "b"])).expect_err("another plan");
    assert!(matches!(error, RunError::Occupied { .. }), "{error}");
    let again = RunFolder::create(
        folder.path(),
        &RunEnvironment::default(),
        &plan(&["a", "b", "c"]),
    );
    assert!(matches!(again, Err(RunError::Occupied { .. })));
}

#[test]
fn a_folder_without_a_run_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = RunFolder::open(folder.path()).expect_err("nothing there");
    assert!(error.to_string().contains("plan.json"), "{error}");
}

#[test]
fn ladders_and_bytes_are_kept_and_old_rows_without_new_columns_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = start(folder.path(), &["a"]);
    assert_eq!(run.ladder().expect("none is no error"), []);
    assert_eq!(run.memory().expect("none is no error"), []);
    let rung = |number| LadderRung {
        ladder: "vertex".to_owned(),
        rung: number,
        step: "culling".to_owned(),
        change: "regions out of sight are left out".to_owned(),
        scene: "planet-134".to_owned(),
        view: "globe".to_owned(),
        backend: "vertex".to_owned(),
        variant: format!("rung-{number}"),
    };
    run.write_ladder(&[rung(1), rung(2)]).expect("writable");
    run.write_ladder(&[rung(1), rung(2), rung(3)])
        .expect("again");
    assert_eq!(run.ladder().expect("rows").len(), 3, "replaced, not added");
    assert_eq!(run.ladder().expect("rows")[0].key(), key("rung-1"));

    let bytes = |layout: &str, regions, allocated| MemoryRow {
        scene: "planet-134".to_owned(),
        backend: "vertex".to_owned(),
        layout: layout.to_owned(),
        regions,
        mesh_vertices: 10,
        mesh_triangles: 8,
        boundary_edges: 10,
        boundary_loops: 1,
        formula_vertex_bytes: 320,
        formula_index_bytes: 142,
        allocated_vertex_bytes: allocated,
        allocated_index_bytes: allocated.map(|_| 142),
        region_bytes_smallest: 462,
        region_bytes_median: 462,
        region_bytes_largest: 462,
    };
    run.append_memory(&[]).expect("nothing to do");
    run.append_memory(&[
        bytes("doubled", 134, Some(1)),
        bytes("doubled", 5_000, None),
    ])
    .expect("writable");
    run.append_memory(&[bytes("doubled", 134, Some(320))])
        .expect("writable");
    let rows = run.memory().expect("rows");
    assert_eq!(rows.len(), 2, "a layout of as many regions stands once");
    let of = |regions| rows.iter().find(|row| row.regions == regions).expect("it");
    assert_eq!(of(134).allocated_bytes(), Some(462), "the last one counts");
    assert_eq!(of(134).formula_bytes(), 462);
    assert_eq!(of(5_000).allocated_bytes(), None, "absent, not 0");

    run.append_summary(&summary("a", None)).expect("writable");
    let path = folder.path().join("summary.csv");
    let text = fs::read_to_string(&path).expect("rows");
    let older: Vec<String> = text
        .lines()
        .map(|line| line.rsplitn(20, ',').last().unwrap_or_default().to_owned())
        .collect();
    assert!(older[0].ends_with(",plan_cpu_ms"), "{}", older[0]);
    fs::write(&path, older.join("\n") + "\n").expect("writable");
    assert_eq!(run.summaries().expect("readable"), [summary("a", None)]);
    // Twin: a column that was always there may not be absent.
    fs::write(
        &path,
        older.join("\n").replace("left_out", "let_out") + "\n",
    )
    .expect("writable");
    assert!(run.summaries().is_err());
}

fn precision_row(route: &str, condition: &str) -> PrecisionRow {
    PrecisionRow {
        part: PrecisionPart::Coordinate,
        route: route.to_owned(),
        condition: condition.to_owned(),
        status: Status::Ok,
        device_max_m: Some(1.25e-7),
        ..PrecisionRow::default()
    }
}

#[test]
fn a_missing_row_of_the_numerical_suite_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = RunFolder::create(
        folder.path(),
        &RunEnvironment::default(),
        &RunPlan::default(),
    )
    .expect("an empty folder");
    assert_eq!(run.precision_plan().expect("no plan"), None);
    assert_eq!(run.precision_missing().expect("nothing planned"), []);
    let plan = PrecisionPlan {
        grids: vec![PrecisionGrid {
            part: PrecisionPart::Coordinate,
            routes: vec!["planes".to_owned(), "odd-7".to_owned()],
            conditions: vec!["a".to_owned(), "b".to_owned()],
        }],
        rounds: 5,
    };
    run.write_precision_plan(&plan).expect("written");
    assert_eq!(run.precision_missing().expect("rows").len(), 4);
    let rows = [
        precision_row("planes", "a"),
        precision_row("odd-7", "a"),
        precision_row("planes", "b"),
        precision_row("odd-7", "b"),
    ];
    run.append_precision(&rows[..2]).expect("written");
    run.append_precision(&rows[2..]).expect("written");
    assert_eq!(run.precision().expect("rows"), rows);
    assert_eq!(run.precision_missing().expect("rows"), []);
    // Twin: the last row cut off.
    let file = folder.path().join("precision.csv");
    let whole = std::fs::read_to_string(&file).expect("text");
    let end = whole.trim_end().rfind('\n').expect("rows") + 1;
    std::fs::write(&file, &whole[..end]).expect("writable");
    let missing = run.precision_missing().expect("rows");
    let names: Vec<String> = missing.iter().map(ToString::to_string).collect();
    assert_eq!(names, ["coordinate/odd-7/b"]);
    // A run is not gone on with under another plan.
    let other = PrecisionPlan { rounds: 6, ..plan };
    let refused = run.write_precision_plan(&other).expect_err("differs");
    assert!(refused.to_string().contains("plan of the numerical suite"));
}

#[test]
fn times_are_those_beyond_the_empty_formula() {
    let time = PrecisionTime {
        part: PrecisionPart::Position,
        route: "eye-region".to_owned(),
        round: 0,
        evaluations: 2_000_000,
        cpu_ms: 5.0,
        empty_cpu_ms: 4.0,
        gpu_ms: Some(3.0),
        empty_gpu_ms: None,
    };
    assert!((time.cpu_ns() - 0.5).abs() < 1e-12);
    assert_eq!(time.gpu_ns(), None, "no empty pass to take away");
}
