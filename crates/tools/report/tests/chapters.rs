// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapters on the ladder, the matrix, memory and growth, read as a reader would. Each has a twin
//! in which something is wrong and must be seen.

mod made_up;

use made_up::samples;
use std::fs;
use std::path::Path;
use terrafill_report::write_report;
use terrafill_results::legacy::{
    CaseKey, LadderRung, MemoryRow, PrecisionGrid, PrecisionPart, PrecisionPlan, PrecisionRow,
    RunEnvironment, RunFolder, RunPlan, Status, Summary, median,
};

const BOUND_MS: f64 = 10.0;

/// How a round differs from the others: shared by all cases, as on a busy machine.
const ROUNDS: [f64; 8] = [1.0, 3.0, 0.9, 1.1, 2.0, 1.05, 1.3, 0.95];

fn key(scene: &str, view: &str, backend: &str, variant: &str) -> CaseKey {
    CaseKey {
        scene: scene.to_owned(),
        view: view.to_owned(),
        backend: backend.to_owned(),
        variant: variant.to_owned(),
    }
}

fn start(folder: &Path, cases: &[CaseKey], drawn_only: &[CaseKey]) -> RunFolder {
    let plan = RunPlan {
        cases: cases.to_vec(),
        drawn_only: drawn_only.to_vec(),
        frames: 8,
        warm_up: 1,
        ..RunPlan::default()
    };
    RunFolder::create(folder, &RunEnvironment::default(), &plan).expect("an empty folder")
}

/// A right row whose frames take `ms` times the round's factor.
fn timed(run: &RunFolder, key: &CaseKey, role: &str, ms: f64) -> Summary {
    let times = ROUNDS.map(|round| round * ms);
    run.append_samples(&samples(key, &times)).expect("samples");
    Summary {
        fill_cpu_ms: median(&times),
        bound_cpu_ms: Some(BOUND_MS),
        samples: 8,
        ..drawn(key, role, "m", "i")
    }
}

/// A right row that is not timed.
fn drawn(key: &CaseKey, role: &str, mask: &str, ids: &str) -> Summary {
    Summary {
        role: role.to_owned(),
        mask_hash: mask.to_owned(),
        ids_hash: ids.to_owned(),
        mismatched_px: Some(2),
        mismatched_px_outside_band: Some(0),
        vertices: Some(1_000),
        draws: Some(7),
        stencil_fragments: Some(5_000),
        fragment_shader_invocations: Some(3_000),
        ..Summary::new(key.clone(), Status::Ok)
    }
}

fn report(run: &RunFolder) -> String {
    let summary = write_report(run.path()).expect("a report");
    fs::read_to_string(summary.path).expect("the report")
}

fn section<'a>(html: &'a str, id: &str) -> &'a str {
    let start = html
        .find(&format!("<h2 id=\"{id}\">"))
        .expect("the chapter");
    &html[start..start + html[start..].find("</section>").expect("its end")]
}

fn rung(number: u32, step: &str, key: &CaseKey) -> LadderRung {
    LadderRung {
        ladder: key.backend.clone(),
        rung: number,
        step: step.to_owned(),
        change: format!("{step} is switched"),
        scene: key.scene.clone(),
        view: key.view.clone(),
        backend: key.backend.clone(),
        variant: key.variant.clone(),
    }
}

/// A ladder whose rungs take these times; the first is `start`.
fn ladder(folder: &Path, view: &str, rungs: &[(&str, f64)]) -> RunFolder {
    let keys: Vec<CaseKey> = rungs
        .iter()
        .map(|(step, _)| key("planet-134", view, "vertex", step))
        .collect();
    let run = start(folder, &keys, &[]);
    let named: Vec<LadderRung> = (1..)
        .zip(rungs.iter().zip(&keys))
        .map(|(number, ((step, _), key))| rung(number, step, key))
        .collect();
    run.write_ladder(&named).expect("writable");
    for ((_, ms), key) in rungs.iter().zip(&keys) {
        let row = timed(&run, key, "ladder", *ms);
        run.append_summary(&row).expect("a row");
    }
    run
}

#[test]
fn gains_are_those_of_the_rounds_and_findings_follow_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let steps = [
        ("start", 200.0),
        ("back-faces", 100.0),
        ("strips", 99.0),
        ("z-pass", 100.0),
    ];
    let html = report(&ladder(folder.path(), "globe", &steps));
    let chapter = section(&html, "ladder");
    // Rounds differ threefold; the ratio within a round does not.
    assert!(chapter.contains("<td>2.00 × [2.00–2.00]</td>"), "{chapter}");
    let overview = "<td>21.5</td><td>10.8</td><td>2.00 × [2.00–2.00]</td>\
                    <td>back-faces: 2.00 × [2.00–2.00]</td>";
    assert!(chapter.contains(overview), "{chapter}");
    assert!(chapter.contains("“back-faces” gave most: 2.00 ×"));
    let standing = |html: &str, sentence: &str| {
        let chapter = section(html, "ladder");
        let at = chapter.find(sentence).expect("the finding") + sentence.len();
        let rest = &chapter[at..];
        let end = rest.find("</b>").expect("its standing");
        rest[rest.find('>').expect("a tag") + 1..end].to_owned()
    };
    let back_faces = "Culling back faces in the colour pass was kept as a gain.";
    let strips = "Strips instead of lists made no difference.";
    let z_pass = "Counting fragments in front of the surface was faster than behind it.";
    assert_eq!(standing(&html, back_faces), "holds");
    assert_eq!(standing(&html, strips), "holds");
    assert_eq!(standing(&html, z_pass), "does not hold");
    // Twin: other times, other answers; nothing is written down beforehand.
    let folder = tempfile::tempdir().expect("a folder");
    let steps = [
        ("start", 100.0),
        ("back-faces", 100.0),
        ("strips", 50.0),
        ("z-pass", 20.0),
    ];
    let html = report(&ladder(folder.path(), "globe", &steps));
    assert_eq!(standing(&html, back_faces), "does not hold");
    assert_eq!(standing(&html, strips), "does not hold");
    assert_eq!(standing(&html, z_pass), "holds");
    assert!(section(&html, "ladder").contains("“z-pass” gave most: 2.50 ×"));
}

#[test]
fn a_wrong_rung_has_no_gain_and_the_next_is_held_against_the_last_right_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let steps = [("start", 100.0), ("back-faces", 80.0), ("strips", 50.0)];
    let run = ladder(folder.path(), "globe", &steps);
    let mut wrong = drawn(
        &key("planet-134", "globe", "vertex", "back-faces"),
        "ladder",
        "x",
        "x",
    );
    wrong.status = Status::Wrong;
    wrong.samples = 8;
    run.append_summary(&wrong).expect("the last row counts");
    let html = report(&run);
    let chapter = section(&html, "ladder");
    assert!(chapter.contains("<td>2.00 × [2.00–2.00]</td>"), "100 ÷ 50");
    assert!(!chapter.contains("1.25 ×") && !chapter.contains("1.60 ×"));
    assert!(chapter.contains("<b class=\"cannot-tell\">cannot tell</b>"));
}

#[test]
fn a_missing_rung_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = ladder(folder.path(), "globe", &[("start", 9.0), ("culling", 5.0)]);
    assert!(!section(&report(&run), "ladder").contains("Rungs without a result"));
    // One that was planned and not measured.
    let path = folder.path().join("summary.csv");
    let text = fs::read_to_string(&path).expect("rows");
    let kept: Vec<&str> = text.lines().take(2).collect();
    fs::write(&path, kept.join("\n") + "\n").expect("writable");
    let html = report(&run);
    let named = "Rungs without a result: rung 2, “culling”: planet-134/globe/vertex/culling.";
    assert!(section(&html, "ladder").contains(named));
    // One that nobody planned.
    let first = rung(1, "start", &key("planet-134", "globe", "vertex", "start"));
    let third = rung(
        3,
        "culling",
        &key("planet-134", "globe", "vertex", "culling"),
    );
    run.write_ladder(&[first, third]).expect("writable");
    let html = report(&run);
    assert!(section(&html, "ladder").contains("rung 2 (the ladder goes on with 3, “culling”)"));
}

#[test]
fn fill_rate_is_the_limit_when_fewer_vertices_do_not_help() {
    let sentence = |after_ms: f64, after_vertices: u64, after_fragments: u64| {
        let folder = tempfile::tempdir().expect("a folder");
        let steps = [("start", 100.0), ("culling", after_ms)];
        let run = ladder(folder.path(), "horizon", &steps);
        let culled = key("planet-134", "horizon", "vertex", "culling");
        let mut row = drawn(&culled, "ladder", "m", "i");
        row.vertices = Some(after_vertices);
        row.stencil_fragments = Some(after_fragments);
        row.samples = 8;
        row.bound_cpu_ms = Some(BOUND_MS);
        run.append_summary(&row).expect("the last row counts");
        let html = report(&run);
        let chapter = section(&html, "ladder").to_owned();
        let at = chapter.find("fill rate is the limit").expect("the finding");
        chapter[at..at + 160].to_owned()
    };
    assert!(sentence(95.0, 250, 5_000).contains("Today: holds; at “culling” 4.00 ×"));
    assert!(sentence(25.0, 250, 5_000).contains("Today: does not hold"));
    assert!(sentence(95.0, 990, 5_000).contains("Today: cannot tell"));
    // Fewer vertices and fewer fragments: nobody knows which of the two it was.
    assert!(sentence(25.0, 250, 2_500).contains("no step leaves out vertices alone"));
}

/// A run of matrix cells with these hashes of mask and regions.
fn matrix(folder: &Path, cells: &[(&str, &str, &str)]) -> RunFolder {
    let keys: Vec<CaseKey> = cells
        .iter()
        .map(|(variant, _, _)| key("california", "globe", "vertex", variant))
        .collect();
    let run = start(folder, &keys, &keys);
    for (key, (_, mask, ids)) in keys.iter().zip(cells) {
        run.append_summary(&drawn(key, "matrix", mask, ids))
            .expect("a row");
    }
    run
}

#[test]
fn a_cell_of_another_mask_is_red_and_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let cells = [
        ("doubled", "m", "i"),
        ("pulled", "m", "i"),
        ("pulled,colour=one-colour", "m", ""),
        ("pulled,boundary-lod-px=0.5", "other", "other"),
    ];
    let html = report(&matrix(folder.path(), &cells));
    let chapter = section(&html, "matrix");
    assert!(
        chapter.contains("4 of 4 cells right and equal"),
        "{chapter}"
    );
    assert!(!chapter.contains("✗</span>"));
    // They are no rows of their scene's tables.
    assert!(!html.contains("<table class=\"cases\">"));
    // Twin.
    let folder = tempfile::tempdir().expect("a folder");
    let mut cells = cells;
    cells[2] = ("pulled,colour=one-colour", "another", "");
    let html = report(&matrix(folder.path(), &cells));
    let chapter = section(&html, "matrix");
    assert!(chapter.contains("3 of 4 cells right and equal"));
    assert!(chapter.contains(
        "<li>california/globe/vertex/pulled,colour=one-colour: its mask differs from that of \
         vertex/doubled</li>"
    ));
    assert_eq!(chapter.matches("✗</span>").count(), 1);
}

#[test]
fn a_cell_that_was_never_drawn_is_red_and_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = matrix(
        folder.path(),
        &[("doubled", "m", "i"), ("pulled", "m", "i")],
    );
    let path = folder.path().join("summary.csv");
    let text = fs::read_to_string(&path).expect("rows");
    let kept: Vec<&str> = text.lines().take(2).collect();
    fs::write(&path, kept.join("\n") + "\n").expect("writable");
    let html = report(&run);
    let chapter = section(&html, "matrix");
    assert!(chapter.contains("1 of 2 cells right and equal"));
    assert!(chapter.contains("<li>california/globe/vertex/pulled: missing:"));
}

fn bytes(layout: &str, backend: &str, formula: u64, allocated: Option<u64>) -> MemoryRow {
    MemoryRow {
        scene: "california".to_owned(),
        backend: backend.to_owned(),
        layout: layout.to_owned(),
        regions: if allocated.is_some() { 1 } else { 5_000 },
        mesh_vertices: 109,
        mesh_triangles: 107,
        boundary_edges: 109,
        boundary_loops: 1,
        formula_vertex_bytes: formula,
        formula_index_bytes: 100,
        allocated_vertex_bytes: allocated,
        allocated_index_bytes: allocated.map(|_| 100),
        region_bytes_smallest: formula + 100,
        region_bytes_median: formula + 100,
        region_bytes_largest: formula + 100,
    }
}

#[test]
fn bytes_by_formula_and_as_allocated_stand_side_by_side_and_one_byte_is_red() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = start(folder.path(), &[], &[]);
    run.append_memory(&[
        bytes("doubled", "vertex", 900, Some(900)),
        bytes("doubled", "vertex", 4_500_000, None),
        bytes("gs-line", "native", 310, Some(310)),
    ])
    .expect("writable");
    let html = report(&run);
    let chapter = section(&html, "memory");
    assert!(chapter.contains("31\u{202f}986") && chapter.contains("90\u{202f}540"));
    assert!(chapter.contains("<td>0.410 ×</td>"), "{chapter}");
    assert!(chapter.contains("native/gs-line: 0.410 × <b class=\"holds\">holds</b>"));
    assert!(chapter.contains("bytes over regions"), "the plot");
    assert!(!chapter.contains("differ:"));
    // Twin.
    run.append_memory(&[bytes("gs-line", "native", 310, Some(311))])
        .expect("the last row counts");
    let html = report(&run);
    assert!(section(&html, "memory").contains(
        "<li>california/native/gs-line: positions and flags: 310 bytes by formula, 311 \
         allocated</li>"
    ));
}

#[test]
fn growth_with_vertices_is_an_exponent_with_its_interval() {
    let folder = tempfile::tempdir().expect("a folder");
    let few = key("countries-110m", "globe", "vertex", "doubled");
    let many = key("countries-50m", "globe", "vertex", "doubled");
    let run = start(folder.path(), &[few.clone(), many.clone()], &[]);
    for (key, ms, vertices) in [(&few, 10.0, 1_000), (&many, 80.0, 8_000)] {
        let mut row = timed(&run, key, "main", ms);
        row.vertices = Some(vertices);
        run.append_summary(&row).expect("a row");
    }
    let html = report(&run);
    assert!(
        section(&html, "exponent").contains("<td>1.00 ["),
        "time as vertices"
    );
    // Twin: with one of the two wrong, nothing is said.
    let mut wrong = drawn(&many, "main", "m", "i");
    wrong.status = Status::Wrong;
    wrong.samples = 8;
    run.append_summary(&wrong).expect("the last row counts");
    assert!(!report(&run).contains("<h2 id=\"exponent\">"));
}

#[test]
fn pairs_are_ratios_within_rounds() {
    let folder = tempfile::tempdir().expect("a folder");
    let control = key("planet-134", "globe", "native", "vs-control");
    let shader = key("planet-134", "globe", "native", "gs-line");
    let run = start(folder.path(), &[control.clone(), shader.clone()], &[]);
    for (key, ms) in [(&control, 10.0), (&shader, 11.0)] {
        let row = timed(&run, key, "main", ms);
        run.append_summary(&row).expect("a row");
    }
    let html = report(&run);
    let chapter = section(&html, "pairs");
    assert!(chapter.contains("<td>1.10 × [1.10–1.10]</td>"), "{chapter}");
    assert_eq!(
        chapter.matches("<td>–</td>").count(),
        3,
        "not measured, not 0"
    );
}

#[test]
fn a_run_without_them_has_none_of_these_chapters() {
    let folder = tempfile::tempdir().expect("a folder");
    let case = key("california", "globe", "vertex", "doubled");
    let run = start(folder.path(), std::slice::from_ref(&case), &[]);
    let row = timed(&run, &case, "", 10.0);
    run.append_summary(&row).expect("a row");
    let html = report(&run);
    for id in [
        "ladder", "pairs", "matrix", "memory", "exponent", "textured",
    ] {
        assert!(!html.contains(&format!("<h2 id=\"{id}\">")), "{id}");
    }
    assert!(
        html.contains("<table class=\"cases\">"),
        "a row of no role is listed"
    );
}

const NATIVE: &str = "doubled,texture=atan2-native+bowring-1";
const CHOSEN: &str = "doubled,texture=chosen";
const FLOOR: &str = "doubled,texture=floor";

/// Plain, chosen, native and least fills that take these times; the reader of the report wants to know why.
fn textured(folder: &Path, times: [f64; 4]) -> RunFolder {
    let of = |variant: &str| key("california", "top-down", "vertex", variant);
    let keys = ["doubled", CHOSEN, NATIVE, FLOOR].map(of);
    let run = start(folder, &keys, &[]);
    for (key, ms) in keys.iter().zip(times) {
        let role = match key.variant.as_str() {
            "doubled" => "main",
            _ => "texture",
        };
        let mut row = timed(&run, key, role, ms);
        if role == "texture" && key.variant != FLOOR {
            row.texture_route = "gnomonic-3 (1 region, computed ≤ 1.000e1 m, 0.010 texels); \
                                 cheaper ones left out: gnomonic-1: 3.00 texels of 0.5"
                .to_owned();
            row.texel_rms = Some(0.0625);
            row.texel_max = Some(0.125);
            row.texel_non_finite = Some(0);
            row.texel_compared_px = Some(4_321);
        }
        run.append_summary(&row).expect("a row");
    }
    run
}

#[test]
fn textured_fill_is_held_against_plain_fill_and_the_document() {
    let folder = tempfile::tempdir().expect("a folder");
    let html = report(&textured(folder.path(), [10.0, 12.0, 30.0, 11.0]));
    let chapter = section(&html, "textured");
    for cell in [
        "3.00 × [3.00–3.00]",
        "1.20 × [1.20–1.20]",
        "2.50 × [2.50–2.50]",
        "1.10 × [1.10–1.10]",
        "1.09 × [1.09–1.09]",
    ] {
        assert!(chapter.contains(&format!("<td>{cell}</td>")), "{cell}");
    }
    let standings = |chapter: &str| {
        ["holds", "does-not", "cannot-tell"]
            .map(|class| chapter.matches(&format!("<b class=\"{class}\">")).count())
    };
    assert_eq!(standings(chapter), [5, 0, 0], "{chapter}");
    for text in [
        "0.0625",
        "0.125",
        "4\u{202f}321",
        "gnomonic-1: 3.00 texels of 0.5",
    ] {
        assert!(chapter.contains(text), "{text}");
    }
    // Textured fills stand in their chapter, not among the layouts.
    assert!(!section(&html, "california").contains("texture=chosen"));
    // Three of eight comparisons were not made: they are named, and are no 0. Nor has a floor texels,
    // and nobody misses them.
    assert_eq!(chapter.matches("<td>–</td>").count(), 3 + 7 + 2 * 2 + 6);
    assert!(!chapter.contains("texture=floor: its texture coordinates"));
    assert!(chapter.contains("in the same rounds, for a picture each ÷ one for all"));

    // Twin: other times, other answers.
    let folder = tempfile::tempdir().expect("a folder");
    let html = report(&textured(folder.path(), [10.0, 20.0, 20.0, 15.0]));
    assert_eq!(standings(section(&html, "textured")), [0, 5, 0]);
}

#[test]
fn a_wrong_textured_fill_has_no_time_and_what_is_absent_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = textured(folder.path(), [10.0, 12.0, 30.0, 11.0]);
    let mut wrong = drawn(
        &key("california", "top-down", "vertex", CHOSEN),
        "texture",
        "m",
        "i",
    );
    wrong.status = Status::Wrong;
    wrong.reason = "RMS error 0.900 texels, allowed 0.25".to_owned();
    wrong.samples = 8;
    wrong.texel_rms = Some(0.9);
    run.append_summary(&wrong).expect("the last row counts");
    let html = report(&run);
    let chapter = section(&html, "textured");
    assert!(!chapter.contains("2.50 ×"), "a wrong fill is never fast");
    assert!(chapter.contains(
        "<li>california/top-down/vertex/doubled,texture=chosen: wrong: RMS error 0.900 texels, \
         allowed 0.25</li>"
    ));
    assert!(chapter.contains("<b class=\"cannot-tell\">not measured</b>"));

    let mut skipped = wrong.clone();
    skipped.status = Status::Skipped;
    skipped.reason =
        "texture: found chosen for a scene without a picture, allowed: plain".to_owned();
    run.append_summary(&skipped).expect("the last row counts");
    let html = report(&run);
    assert!(section(&html, "textured").contains("skipped: texture: found chosen for a scene"));
}

#[test]
fn pictures_of_a_textured_fill_are_shown_or_missed_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = textured(folder.path(), [10.0, 12.0, 30.0, 11.0]);
    let key = key("california", "top-down", "vertex", CHOSEN);
    let mut row = drawn(&key, "texture", "m", "i");
    row.samples = 8;
    row.texel_compared_px = Some(1);
    row.colour_max = Some(3);
    row.colour_mean = Some(0.5);
    for (cell, name) in [
        (&mut row.reference_image, "images/a.png"),
        (&mut row.image, "images/b.png"),
        (&mut row.difference_image, "images/c.png"),
    ] {
        *cell = name.to_owned();
        image::RgbImage::from_pixel(8, 4, image::Rgb([1, 2, 3]))
            .save(folder.path().join(name))
            .expect("a picture");
    }
    run.append_summary(&row).expect("the last row counts");
    let html = report(&run);
    let chapter = section(&html, "textured");
    assert_eq!(chapter.matches("<img ").count(), 3);
    assert!(chapter.contains("colours differ by 0.500 of 255 on average, 3 at most"));
    // Twin: a picture that is gone is named, and the others do not pass for the row's.
    fs::remove_file(folder.path().join("images/b.png")).expect("there");
    let html = report(&run);
    let chapter = section(&html, "textured");
    assert_eq!(chapter.matches("<img ").count(), 0);
    assert!(chapter.contains("could not be shown: california, top-down: images/b.png"));
}

/// Rows of a sweep through the cap step: coarser is faster by as much as asked.
fn swept(folder: &Path, faster: f64) -> String {
    let steps = [
        ("0.3", 1.0, 900.0),
        ("3", faster, 4_000.0),
        ("10", faster, 40_000.0),
    ];
    let name = |step: &str| format!("doubled,cap-step-deg={step}");
    let keys: Vec<CaseKey> = steps
        .iter()
        .map(|(step, ..)| key("s", "v", "vertex", &name(step)))
        .collect();
    let run = start(folder, &keys, &[]);
    for (key, (_, factor, wall_m)) in keys.iter().zip(steps) {
        let row = Summary {
            wall_height_m: Some(wall_m),
            cap_triangles: Some(1_234),
            ..timed(&run, key, "subdivision", 12.0 / factor)
        };
        run.append_summary(&row).expect("a row");
    }
    write_report(folder).expect("a report");
    fs::read_to_string(folder.join("report.html")).expect("the report")
}

#[test]
fn coarse_caps_with_tall_walls_stand_beside_fine_ones_and_are_judged() {
    let folder = tempfile::tempdir().expect("a folder");
    let html = swept(&folder.path().join("faster"), 1.5);
    assert!(html.contains("id=\"subdivision\"") && html.contains("tallest wall drawn, m"));
    assert!(html.contains("10° fills 1.50 times as fast as 0.3°"));
    assert!(html.contains("<b class=\"holds\">holds</b>"));
    assert!(
        !html.contains("<h3 id=\"s-v\">"),
        "no case table of its own"
    );
    // Twin: where coarse is not faster, the expectation does not hold.
    let html = swept(&folder.path().join("equal"), 1.0);
    assert!(html.contains("<b class=\"does-not\">does not hold</b>"));
}

fn precision_row(route: &str, knob: f64, error_m: f64) -> PrecisionRow {
    PrecisionRow {
        route: route.to_owned(),
        family: "gnomonic".to_owned(),
        knob: Some(knob),
        condition: "extent=1;latitude=45;heights=+9km".to_owned(),
        extent_deg: Some(1.0),
        latitude_deg: Some(45.0),
        highest_m: Some(9_000.0),
        status: Status::Ok,
        points: 10,
        device_max_m: Some(error_m),
        device_rms_m: Some(0.3 * error_m),
        texture_px: Some(4096),
        max_texels: Some(0.4),
        rms_texels: Some(0.1),
        max_over_residual: Some(0.9),
        measured_over_expected: Some(0.9),
        operations_cost: Some(10.0 + knob),
        chosen: true,
        ..PrecisionRow::default()
    }
}

/// A report of these rows, planned as `planned` routes.
fn precision_report(folder: &Path, rows: &[PrecisionRow], planned: &[&str]) -> String {
    let run = start(folder, &[], &[]);
    let plan = PrecisionPlan {
        grids: vec![PrecisionGrid {
            part: PrecisionPart::Coordinate,
            routes: planned.iter().map(|route| (*route).to_owned()).collect(),
            conditions: vec![rows[0].condition.clone()],
        }],
        rounds: 1,
    };
    run.write_precision_plan(&plan).expect("a plan");
    run.append_precision(rows).expect("rows");
    write_report(folder).expect("a report");
    fs::read_to_string(folder.join("report.html")).expect("the report")
}

#[test]
fn the_numerical_suite_has_its_chapter_and_says_what_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = [precision_row("gnomonic-3", 3.0, 0.25)];
    let html = precision_report(&folder.path().join("whole"), &rows, &["gnomonic-3"]);
    assert!(html.contains("id=\"precision\"") && html.contains("Error against operations"));
    assert!(html.contains("gnomonic-3 · 0.100"), "what a plan takes");
    assert!(html.contains("at most 0.100 texel RMS"));
    assert!(!html.contains("planned rows are missing"));
    // Twins: a row that was planned and is not there; one that is too coarse for a plan.
    let html = precision_report(&folder.path().join("cut"), &rows, &["gnomonic-3", "odd-7"]);
    assert!(html.contains("1 planned rows are missing, among them coordinate/odd-7/extent=1"));
    let coarse = PrecisionRow {
        rms_texels: Some(0.26),
        ..rows[0].clone()
    };
    let html = precision_report(&folder.path().join("coarse"), &[coarse], &["gnomonic-3"]);
    assert!(html.contains("<b class=\"does-not\">does not hold</b>"));
}
