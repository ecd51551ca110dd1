// SPDX-License-Identifier: MIT OR Apache-2.0
//! The report of a made-up run, read as a reader would: what it must say, and what it must not.

mod made_up;

use made_up::samples;
use std::fs;
use std::path::Path;
use terrafill_report::{ReportError, ReportSummary, write_report};
use terrafill_results::legacy::{
    CaseKey, GrowthRow, RunEnvironment, RunFolder, RunPlan, Status, Summary, spread,
};

const BOUND_MS: f64 = 10.0;

fn key(variant: &str) -> CaseKey {
    CaseKey {
        scene: "countries-110m".to_owned(),
        view: "globe".to_owned(),
        backend: "vertex".to_owned(),
        variant: variant.to_owned(),
    }
}

fn environment() -> RunEnvironment {
    RunEnvironment {
        gpu: "llvmpipe".to_owned(),
        width: 1024,
        height: 1024,
        ..RunEnvironment::default()
    }
}

fn start(folder: &Path, variants: &[&str]) -> RunFolder {
    let plan = RunPlan {
        cases: variants.iter().map(|variant| key(variant)).collect(),
        frames: 6,
        warm_up: 1,
        ..RunPlan::default()
    };
    RunFolder::create(folder, &environment(), &plan).expect("an empty folder")
}

/// A measured row around `median` milliseconds, with its samples recorded.
fn measured(run: &RunFolder, variant: &str, status: Status, median: f64) -> Summary {
    let key = key(variant);
    let times = [0.9, 0.95, 1.0, 1.0, 1.05, 1.1].map(|factor| factor * median);
    run.append_samples(&samples(&key, &times)).expect("samples");
    let fill = spread(&times).expect("six frames");
    Summary {
        fill_cpu_ms: Some(fill.median),
        fill_cpu_ms_p5: Some(fill.p5),
        fill_cpu_ms_p95: Some(fill.p95),
        bound_cpu_ms: Some(BOUND_MS),
        floor_cpu_ms: Some(3.0),
        fill_over_bound_cpu: Some(fill.median / BOUND_MS),
        geometry_bytes: Some(1_390_000),
        vertex_bytes: Some(1_000_000),
        index_bytes: Some(390_000),
        draws: Some(354),
        mismatched_px: Some(3),
        mismatched_px_outside_band: Some(0),
        hausdorff_px: Some(1.0),
        boundary_deviation_m: Some(90.0),
        samples: 6,
        ..Summary::new(key, status)
    }
}

fn finish(run: &RunFolder, row: &Summary) {
    run.append_summary(row).expect("summary");
}

/// One case of each outcome, the last one missing.
fn mixed_run(folder: &Path) -> RunFolder {
    let run = start(
        folder,
        &["doubled", "pulled", "walls=list", "gs-line", "gs-adjacency"],
    );
    finish(&run, &measured(&run, "doubled", Status::Ok, 36.1));
    let mut wrong = measured(&run, "pulled", Status::Wrong, 7.77);
    wrong.mismatched_px_outside_band = Some(41);
    wrong.reason = "41 pixels outside the boundary band".to_owned();
    finish(&run, &wrong);
    let mut skipped = Summary::new(key("walls=list"), Status::Skipped);
    skipped.reason = "adapter lacks <lists> & \"quotes\"".to_owned();
    finish(&run, &skipped);
    let mut failed = Summary::new(key("gs-line"), Status::Failed);
    failed.reason = "the device was lost".to_owned();
    finish(&run, &failed);
    run
}

fn report(folder: &Path) -> (ReportSummary, String) {
    let summary = write_report(folder).expect("a report");
    let html = fs::read_to_string(&summary.path).expect("the report");
    (summary, html)
}

/// The page without the marks for line breaks in names.
fn without_breaks(html: &str) -> String {
    html.replace("<span>", "").replace("</span><wbr>", "")
}

/// The table row of a case.
fn row_of(html: &str, variant: &str) -> String {
    let plain = without_breaks(html);
    let name = format!("<th scope=\"row\">vertex/{variant}</th>");
    let at = plain.find("<table class=\"cases\">").expect("a table");
    let start = at + plain[at..].find(&name).expect("the case's row");
    let end = start + plain[start..].find("</tr>").expect("its end");
    plain[start..end].to_owned()
}

/// The drawing whose label contains `title`.
fn plot(html: &str, title: &str) -> String {
    let label = html.find(&format!("{title}\"")).expect("the plot");
    let start = html[..label].rfind("<svg").expect("its start");
    let end = start + html[start..].find("</svg>").expect("its end");
    html[start..end].to_owned()
}

#[test]
fn every_case_is_counted_and_named() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    let (summary, html) = report(folder.path());
    let counts = [
        summary.ok,
        summary.wrong,
        summary.skipped,
        summary.failed,
        summary.missing,
    ];
    assert_eq!(counts, [1; 5]);
    assert_eq!(summary.path, folder.path().join("report.html"));
    for variant in ["doubled", "pulled", "walls=list", "gs-line", "gs-adjacency"] {
        row_of(&html, variant);
    }
    assert!(html.contains("5 cases: 1 right, 1 wrong, 1 skipped, 1 failed, 1 missing."));
    assert!(html.contains("This run broke off: 1 of 5 planned cases"));
    assert!(html.contains("<li>countries-110m/globe/vertex/gs-adjacency</li>"));
    assert!(html.contains("1 of 2 compared pictures do not match the reference"));
}

#[test]
fn a_whole_and_right_run_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = start(folder.path(), &["doubled"]);
    finish(&run, &measured(&run, "doubled", Status::Ok, 36.1));
    let (_, html) = report(folder.path());
    assert!(html.contains("Every picture that was compared (1) matches"));
    assert!(html.contains("verdict good"));
    // Twins: words that only a run with something wrong may hold.
    for word in [
        "This run broke off",
        "do not match",
        "Missing cases",
        "does not fit together",
    ] {
        assert!(!html.contains(word), "{word}");
    }
}

#[test]
fn a_run_killed_before_its_first_case_is_no_success() {
    let folder = tempfile::tempdir().expect("a folder");
    start(folder.path(), &["doubled", "pulled"]);
    let (summary, html) = report(folder.path());
    assert_eq!((summary.ok, summary.missing), (0, 2));
    assert!(html.contains("verdict bad") && html.contains("No picture was compared"));
}

#[test]
fn a_run_killed_in_the_middle_of_a_row_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    for file in ["summary.csv", "samples.csv"] {
        let path = folder.path().join(file);
        let text = fs::read_to_string(&path).expect("the file");
        fs::write(&path, &text[..text.len() - 7]).expect("writable");
    }
    let (summary, html) = report(folder.path());
    assert_eq!((summary.failed, summary.missing), (0, 2));
    assert!(html.contains("<li>countries-110m/globe/vertex/gs-line</li>"));
}

/// Addresses that a browser would fetch.
fn loads(html: &str) -> Vec<&str> {
    ["src=\"", "href=\"", "url(", "@import", "srcset=\""]
        .iter()
        .flat_map(|mark| {
            html.match_indices(mark)
                .map(|(at, _)| &html[at + mark.len()..])
        })
        .map(|rest| &rest[..rest.find(['"', ')', ';']).unwrap_or(rest.len())])
        .filter(|address| !address.starts_with('#') && !address.starts_with("data"))
        .collect()
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = mixed_run(folder.path());
    image::RgbImage::new(8, 8)
        .save(folder.path().join("images/a.png"))
        .expect("a picture");
    let mut row = measured(&run, "doubled", Status::Ok, 36.1);
    row.image = "images/a.png".to_owned();
    row.reference_image = "images/a.png".to_owned();
    finish(&run, &row);
    let (_, html) = report(folder.path());
    assert_eq!(loads(&html), [""; 0]);
    assert!(html.contains("data:image/png;base64,"));
    assert!(!html.contains("<script") && !html.contains("<link"));
    // Twin: the check sees what it looks for.
    assert_eq!(loads("<img src=\"images/a.png\">"), ["images/a.png"]);
    assert_eq!(loads("a { b: url(https://c.d) }"), ["https://c.d"]);
}

#[test]
fn a_wrong_case_is_shown_as_wrong_and_its_time_counts_for_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    let (_, html) = report(folder.path());
    let wrong = row_of(&html, "pulled");
    assert!(wrong.contains("<td class=\"status\">wrong</td>"), "{wrong}");
    assert!(wrong.contains("<s>7.77 "), "{wrong}");
    assert!(wrong.contains("<s>0.777</s>"), "{wrong}");
    let right = row_of(&html, "doubled");
    assert!(!right.contains("<s>") && right.contains("3.61"), "{right}");
    let ratios = plot(&html, "fill time over bound");
    assert!(ratios.contains("3.61 ×"), "the right one has its ratio");
    assert!(!ratios.contains("0.777"), "the wrong one has none");
    for word in ["wrong", "failed", "skipped", "missing"] {
        assert!(ratios.contains(&format!("\n{word}\n")) || ratios.contains(&format!(">{word}")));
    }
    // Twin: were it right, its time would be in the plot.
    let other = tempfile::tempdir().expect("a folder");
    let run = start(other.path(), &["pulled"]);
    finish(&run, &measured(&run, "pulled", Status::Ok, 7.77));
    assert!(plot(&report(other.path()).1, "fill time over bound").contains("0.777 ×"));
}

#[test]
fn wrong_and_failed_cases_stay_on_the_error_plot() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    let (_, html) = report(folder.path());
    let errors = plot(&html, "error against run time");
    let labels = |svg: &str, word: &str| svg.lines().filter(|line| line.trim() == word).count();
    assert_eq!(labels(&errors, "wrong"), 2, "one on each panel");
    assert_eq!(labels(&errors, "failed"), 4, "and two name the edge itself");
    assert!(html.contains("Not drawn: vertex/walls=list (skipped:"));
    assert!(html.contains("vertex/gs-adjacency (missing: the run ended before this case)"));
    // Twin: a run without such cases names the edge and pins nothing to it.
    let other = tempfile::tempdir().expect("a folder");
    let run = start(other.path(), &["doubled"]);
    finish(&run, &measured(&run, "doubled", Status::Ok, 36.1));
    let errors = plot(&report(other.path()).1, "error against run time");
    assert_eq!(
        (labels(&errors, "wrong"), labels(&errors, "failed")),
        (0, 2)
    );
}

#[test]
fn what_was_not_measured_is_a_dash_with_a_reason_and_never_a_zero() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    let (_, html) = report(folder.path());
    for variant in ["walls=list", "gs-line", "gs-adjacency"] {
        let row = row_of(&html, variant);
        let cells: Vec<&str> = row.split("<td").skip(2).collect();
        assert_eq!(cells.len(), 16);
        for cell in cells {
            assert!(cell.contains(">–<sup>"), "{variant}: {cell}");
            assert!(cell.contains("title=\""), "{variant}: {cell}");
        }
    }
    assert!(row_of(&html, "gs-line").contains("title=\"failed: the device was lost\""));
    assert!(
        html.contains("<li>failed: the device was lost</li>"),
        "footnote for print"
    );
    // Twin: a measured zero is a zero.
    assert!(row_of(&html, "doubled").contains("<td>0</td>"));
}

#[test]
fn text_from_the_run_cannot_become_markup() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    let (_, html) = report(folder.path());
    assert!(!html.contains("<lists>"));
    assert!(html.contains("&#60;lists&#62; &#38; &#34;quotes&#34;"));
    let run = start(&folder.path().join("b"), &["<img src=x>"]);
    finish(&run, &measured(&run, "<img src=x>", Status::Ok, 1.0));
    let (_, html) = report(run.path());
    assert!(
        !html.contains("<img src=x>"),
        "neither in the page nor in a plot"
    );
}

#[test]
fn malformed_rows_are_refused_with_file_and_row() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    let path = folder.path().join("summary.csv");
    let text = fs::read_to_string(&path).expect("the file");
    fs::write(&path, text.replace(",skipped,", ",maybe,")).expect("writable");
    let error = write_report(folder.path()).expect_err("no such status");
    assert!(matches!(error, ReportError::Run(_)));
    let message = error.to_string();
    assert!(message.contains("summary.csv, row 4: "), "{message}");
    assert!(message.contains("maybe"), "{message}");
    assert!(!folder.path().join("report.html").exists());
}

#[test]
fn a_folder_without_a_run_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = write_report(folder.path()).expect_err("nothing there");
    assert!(error.to_string().contains("plan.json"), "{error}");
}

#[test]
fn a_summary_that_its_samples_contradict_is_called_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = start(folder.path(), &["doubled"]);
    let mut row = measured(&run, "doubled", Status::Ok, 36.1);
    row.fill_cpu_ms = Some(30.0);
    finish(&run, &row);
    let (_, html) = report(folder.path());
    assert!(html.contains("gives 30 ms as median, its samples give 36.1 ms"));
}

#[test]
fn a_row_called_ok_whose_picture_differs_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = start(folder.path(), &["doubled"]);
    let mut row = measured(&run, "doubled", Status::Ok, 36.1);
    row.mismatched_px_outside_band = Some(2);
    finish(&run, &row);
    let (_, html) = report(folder.path());
    assert!(html.contains(
        "1 of 1 compared pictures do not match the reference: countries-110m/globe/vertex/doubled."
    ));
    assert!(html.contains("ok, though 2 pixels outside the boundary band are wrong"));
}

#[test]
fn full_screen_passes_have_rows_and_are_no_techniques() {
    let folder = tempfile::tempdir().expect("a folder");
    let bound = CaseKey {
        backend: "bound".to_owned(),
        ..key("full-screen")
    };
    let floor = CaseKey {
        backend: "floor".to_owned(),
        ..key("full-screen")
    };
    let plan = RunPlan {
        cases: vec![bound.clone(), floor, key("doubled")],
        ..RunPlan::default()
    };
    let run = RunFolder::create(folder.path(), &environment(), &plan).expect("an empty folder");
    let mut row = Summary::new(bound, Status::Ok);
    row.fill_cpu_ms = Some(BOUND_MS);
    finish(&run, &row);
    finish(&run, &measured(&run, "doubled", Status::Ok, 36.1));
    let (summary, html) = report(folder.path());
    assert_eq!((summary.ok, summary.missing), (2, 1));
    assert!(html.contains("3 cases, 2 of them full-screen passes"));
    assert!(html.contains("<li>countries-110m/globe/floor/full-screen</li>"));
    assert!(without_breaks(&html).contains("<th scope=\"row\">bound/full-screen</th>"));
    assert!(html.contains("title=\"does not apply to a full-screen pass\""));
    assert!(!plot(&html, "fill time over bound").contains("full-screen"));
    assert!(!html.contains("does not fit together"));
}

#[test]
fn a_wrong_case_of_the_sweep_does_not_spoil_the_verdict() {
    let verdict = |variant: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let run = start(folder.path(), &["doubled", variant]);
        finish(&run, &measured(&run, "doubled", Status::Ok, 36.1));
        let mut row = measured(&run, variant, Status::Wrong, 7.77);
        row.mismatched_px_outside_band = Some(41);
        finish(&run, &row);
        let (summary, html) = report(folder.path());
        (summary.wrong, summary.wrong_in_sweep, html)
    };
    let (wrong, in_sweep, html) = verdict("doubled,boundary-tolerance-m=20000");
    assert_eq!((wrong, in_sweep), (1, 1));
    assert!(html.contains("verdict good") && html.contains("1 wrong (1 of them in the sweep"));
    assert!(html.contains("Every picture that was compared (1) matches"));
    // Twin: the same outside the sweep does.
    let (wrong, in_sweep, html) = verdict("pulled");
    assert_eq!((wrong, in_sweep), (1, 0));
    assert!(html.contains("verdict bad"));
}

#[test]
fn pictures_are_grouped_and_broken_ones_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = start(folder.path(), &["doubled", "pulled"]);
    for name in ["a.png", "b.png"] {
        image::RgbImage::from_pixel(8, 8, image::Rgb([9, 9, 9]))
            .save(folder.path().join("images").join(name))
            .expect("a picture");
    }
    for (variant, image) in [("doubled", "a.png"), ("pulled", "b.png")] {
        let mut row = measured(&run, variant, Status::Ok, 36.1);
        row.image = format!("images/{image}");
        row.difference_image = "images/gone.png".to_owned();
        finish(&run, &row);
    }
    let (_, html) = report(folder.path());
    assert!(html.contains("picture, the same for 2 cases"));
    assert!(html.contains("<li>vertex/pulled: 3 wrong px, 0 outside the band, Hausdorff 1.00 px"));
    assert_eq!(html.matches("images/gone.png").count(), 1, "named once");
    // Twin: another picture is not grouped.
    image::RgbImage::from_pixel(8, 8, image::Rgb([9, 9, 8]))
        .save(folder.path().join("images/b.png"))
        .expect("a picture");
    assert!(!report(folder.path()).1.contains("the same for 2 cases"));
}

#[test]
fn the_web_globe_stands_beside_us_only_where_it_may() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    let (_, html) = report(folder.path());
    let at = html.find("<table class=\"published\">").expect("the table");
    let table = without_breaks(&html[at..at + html[at..].find("</table>").expect("its end")]);
    assert!(table.contains("<td>361 ms</td>") && table.contains("<td>13.9 MB</td>"));
    // 361 / 36.1 and 120 / 36.1; 13.9 MB and 0.51 MB / 1.39 MB.
    assert!(table.contains("36.1 ms (10.0 × / 3.32 ×)"), "{table}");
    assert!(table.contains("1.39 MB (10.0 × / 0.367 ×)"), "{table}");
    assert!(
        !table.contains("7.77"),
        "a wrong picture has no time to compare"
    );
    assert!(html.contains("CesiumJS 1.145, llvmpipe, 1024²"));
}

#[test]
fn another_driver_gets_no_ratios_to_published_figures() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = RunPlan {
        cases: vec![key("doubled")],
        ..RunPlan::default()
    };
    let environment = RunEnvironment {
        gpu: "Some GPU".to_owned(),
        ..environment()
    };
    let run = RunFolder::create(folder.path(), &environment, &plan).expect("an empty folder");
    finish(&run, &measured(&run, "doubled", Status::Ok, 36.1));
    let (_, html) = report(folder.path());
    assert!(html.contains("<td>36.1 ms</td>"));
    assert!(html.contains("was not made on llvmpipe"));
}

#[test]
fn the_same_run_gives_the_same_report() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    let (_, first) = report(folder.path());
    let (_, second) = report(folder.path());
    assert_eq!(first, second);
}

fn grow(run: &RunFolder, shape: &str, times: &[(u64, f64)]) {
    for &(outline_vertices, ms) in times {
        for (repetition, factor) in [0.95, 1.0, 1.1].into_iter().enumerate() {
            run.append_growth(&GrowthRow {
                shape: shape.to_owned(),
                outline_vertices,
                repetition: u32::try_from(repetition).expect("three"),
                mesh_cpu_ms: factor * ms,
            })
            .expect("a row");
        }
    }
}

#[test]
fn growth_is_drawn_and_held_against_its_bound() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = mixed_run(folder.path());
    let sizes = [1_000, 10_000, 100_000, 1_000_000];
    let timed = |ms: [f64; 4]| sizes.into_iter().zip(ms).collect::<Vec<_>>();
    grow(&run, "comb", &timed([1.0, 10.0, 100.0, 1_110.0]));
    grow(&run, "spiral", &timed([1.0, 10.0, 100.0, 1_300.0]));
    grow(&run, "needle", &[(1_000, 1.0)]);
    let (_, html) = report(folder.path());
    let table = html.split("<table class=\"growth\">").nth(1);
    let table = table.and_then(|rest| rest.split("</table>").next());
    let table = table.expect("the table");
    let row = |shape: &str| {
        let of_shape = format!(">{shape}</th>");
        let mut rows = table.split("<tr").filter(|row| row.contains(&of_shape));
        rows.next().expect("a row").to_owned()
    };
    assert!(row("comb").contains("<td>11.1</td><td>12</td>") && !row("comb").contains("above"));
    assert!(row("spiral").contains("<td>13.0</td><td>12</td>") && row("spiral").contains("above"));
    assert!(row("needle").contains("not measured") && !row("needle").contains("above"));
    let drawn = plot(&html, "time to mesh against vertices");
    assert!(drawn.contains("slope 1") && drawn.contains("spiral"));
    assert!(!html.contains("Not measured: this run's folder has no"));
}

#[test]
fn a_run_without_growth_says_why_and_a_broken_row_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run(folder.path());
    let (_, html) = report(folder.path());
    assert!(html.contains("<h2 id=\"growth\">") && !html.contains("<table class=\"growth\">"));
    assert!(html.contains("Not measured: this run's folder has no <code>growth.csv</code>"));
    let text = "shape,outline_vertices,repetition,mesh_cpu_ms\ncomb,many,0,1.0\n";
    fs::write(folder.path().join("growth.csv"), text).expect("writable");
    let error = write_report(folder.path()).expect_err("a word is no number");
    assert!(error.to_string().contains("outline_vertices"), "{error}");
}
