// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter of made-up runs, read as a reader would. Each rule has a control in which something is
//! wrong and must be seen.

use super::data::{Data, name};
use super::{FillingChapter, answer_text, error_time, textured};
use crate::claims::PAPER;
use std::collections::BTreeSet;
use terrafill_fixtures::data;
use terrafill_plot::PointStanding;
use terrafill_results::made_up::{MadeUpCase, MadeUpRun, case_id};
use terrafill_results::{
    Answers, Block, Case, Cell, CellClass, Chapter as _, Finding, Outcome, Run, RunEnvironment,
    Standing, Status, Table,
};

const TIME: &str = "fill_cpu_ms";

/// How a process differs from the others: shared by all cases, as on a busy machine.
const PROCESSES: [f64; 8] = [1.0, 3.0, 0.9, 1.1, 2.0, 1.05, 1.3, 0.95];

/// The stable part of `summary.csv`, word for word from the design's §6.
const STABLE_SUMMARY_HEADER: &str = "scene,view,backend,variant,status,reason,surface_gpu_ms,\
    fill_gpu_ms,fill_cpu_ms,bound_gpu_ms,bound_cpu_ms,floor_cpu_ms,fill_over_bound_cpu,\
    geometry_bytes,upload_bytes,draws,vertices,filled_px,mismatched_px,\
    mismatched_px_outside_band,hausdorff_px,left_out";

/// A case of `SCENE/VIEW/TECHNIQUE/VARIANT` whose switches are conditions of their own.
fn add<'a>(run: &'a mut MadeUpRun, key: &str, more: &[(&str, &str)]) -> &'a mut MadeUpCase {
    let parts: Vec<&str> = key.splitn(4, '/').collect();
    let [scene, view, technique, variant] = parts[..] else {
        panic!("four parts: {key}");
    };
    let mut switches = variant.split(',');
    let mut conditions = vec![
        ("scene", scene),
        ("view", view),
        ("technique", technique),
        ("variant", variant),
        ("layout", switches.next().unwrap_or_default()),
    ];
    conditions.extend(switches.filter_map(|switch| switch.split_once('=')));
    conditions.extend(more);
    run.case(case_id("filling", key, &conditions))
}

/// A right case that is not timed.
fn drawn<'a>(run: &'a mut MadeUpRun, key: &str, more: &[(&str, &str)]) -> &'a mut MadeUpCase {
    let case = add(run, key, more);
    case.figure("mismatched_px", 2.0)
        .figure("mismatched_px_outside_band", 0.0)
        .figure("vertices", 1_000.0)
        .figure("draws", 7.0)
        .figure("stencil_fragments", 5_000.0)
        .figure("fragment_shader_invocations", 3_000.0)
        .note("mask_hash", "m")
        .note("ids_hash", "i")
}

/// A right case that takes `ms` times the process's factor.
fn timed<'a>(
    run: &'a mut MadeUpRun,
    key: &str,
    more: &[(&str, &str)],
    ms: f64,
) -> &'a mut MadeUpCase {
    drawn(run, key, more).timed(TIME, &PROCESSES.map(|factor| factor * ms))
}

/// A case's work once more, which takes `ms` times the process's factor.
fn again(run: &mut MadeUpRun, case: usize, ms: f64) {
    let repeat = run.cases[case].id.repeat();
    run.case(repeat)
        .timed(TIME, &PROCESSES.map(|factor| factor * ms));
}

fn set(case: &mut MadeUpCase, key: &str, value: &str) {
    let conditions = &mut case.id.conditions;
    conditions.insert(key.to_owned(), value.to_owned());
}

pub(super) fn on_cpu() -> MadeUpRun {
    MadeUpRun {
        environment: RunEnvironment {
            device_type: "cpu".to_owned(),
            gpu: "llvmpipe".to_owned(),
            width: 1024,
            height: 1024,
            gpu_timestamps: true,
            ..RunEnvironment::default()
        },
        ..MadeUpRun::default()
    }
}

fn written(run: &MadeUpRun) -> (tempfile::TempDir, Run) {
    let folder = tempfile::tempdir().expect("a folder");
    let run = run.write(folder.path()).expect("a run");
    (folder, run)
}

fn blocks(run: &MadeUpRun) -> Vec<Block> {
    let (_folder, run) = written(run);
    FillingChapter.blocks(&run).expect("a chapter")
}

/// The blocks of one section.
pub(super) fn section(run: &MadeUpRun, title: &str) -> Vec<Block> {
    let all = blocks(run);
    let is_section = |block: &Block| matches!(block, Block::Heading { level: 3, .. });
    let own = all
        .iter()
        .skip_while(|block| **block != Block::section(title));
    let rest = own.clone().skip(1).take_while(|block| !is_section(block));
    own.take(1).chain(rest).cloned().collect()
}

pub(super) fn tables(blocks: &[Block]) -> Vec<&Table> {
    let tables = blocks.iter().filter_map(|block| match block {
        Block::Table(table) => Some(table),
        _ => None,
    });
    tables.collect()
}

fn findings(blocks: &[Block]) -> Vec<&Finding> {
    let findings = blocks.iter().filter_map(|block| match block {
        Block::Finding(finding) => Some(finding),
        _ => None,
    });
    findings.collect()
}

fn texts(table: &Table, row: usize) -> Vec<&str> {
    table.rows[row]
        .cells
        .iter()
        .map(|cell| cell.text.as_str())
        .collect()
}

/// Everything that a reader sees.
fn words(blocks: &[Block]) -> String {
    format!("{blocks:?}").replace("\\u{202f}", "\u{202f}")
}

/// An ablation whose steps take these times, beside a depth-pass of 10 ms.
fn climbed(view: &str, steps: &[(&str, f64)]) -> MadeUpRun {
    let mut run = on_cpu();
    timed(
        &mut run,
        &format!("s/{view}/depth-pass/full-screen"),
        &[("role", "baseline")],
        10.0,
    );
    for (number, (step, ms)) in (1..).zip(steps) {
        let number = number.to_string();
        let more = [
            ("role", "ladder"),
            ("rung", number.as_str()),
            ("step", step),
            ("layout", "doubled"),
        ];
        timed(&mut run, &format!("s/{view}/vertex/{step}"), &more, *ms)
            .note("change", &format!("{step} is switched"));
    }
    run
}

const ABLATION: &str = "From 2007 to the full plan";

#[test]
fn gains_are_paired_by_process_and_claims_follow_them() {
    let steps = [
        ("start", 200.0),
        ("back-faces", 100.0),
        ("strips", 99.0),
        ("z-pass", 100.0),
    ];
    let run = climbed("globe", &steps);
    let chapter = section(&run, ABLATION);
    // Processes differ threefold; the ratio within a process does not.
    let overview = tables(&chapter)[0];
    assert_eq!(
        texts(overview, 0),
        [
            "s, globe: vertex",
            "2.00 × [2.00–2.00]",
            "back-faces: 2.00 × [2.00–2.00]"
        ]
    );
    assert_eq!(
        tables(&chapter)[1].rows[1].cells[1].text,
        "2.00 × [2.00–2.00]"
    );
    let verdicts = |run: &MadeUpRun| {
        let claims = [
            "a small increase by culling backfaces during the final rendering pass",
            STRIPS,
            "I anticipate a modest performance gain.",
        ];
        claims.map(|words| claim_row(run, words)[5].clone())
    };
    assert_eq!(verdicts(&run), ["holds", "holds", "no difference"]);
    // Negative control: other times, other answers; nothing is written down beforehand.
    let steps = [
        ("start", 100.0),
        ("back-faces", 100.0),
        ("strips", 50.0),
        ("z-pass", 20.0),
    ];
    let run = climbed("globe", &steps);
    assert_eq!(verdicts(&run), ["no difference", "does not hold", "holds"]);
    let chapter = section(&run, ABLATION);
    let most = texts(tables(&chapter)[0], 0)[2];
    assert!(most.starts_with("z-pass: 2.50 ×"), "{most}");
}

#[test]
fn a_wrong_step_has_no_gain_and_the_next_is_compared_with_the_last_right_one() {
    let steps = [
        ("start", 100.0),
        ("back-faces", 80.0),
        ("strips", 50.0),
        ("z-pass", 50.0),
    ];
    let mut run = climbed("globe", &steps);
    run.cases[2].ended(Status::Wrong, "9 pixels");
    let chapter = section(&run, ABLATION);
    let gains = |row: usize| tables(&chapter)[1].rows[row].cells[1].text.clone();
    assert_eq!(
        [gains(1), gains(2)],
        ["–", "2.00 × [2.00–2.00]"],
        "100 ÷ 50"
    );
    // That gain is of two steps, and says nothing of either.
    assert_eq!(
        claim_row(&run, STRIPS)[4..6],
        ["globe –", "not measured"].map(str::to_owned)
    );
}

#[test]
fn a_step_that_changes_more_than_it_says_is_refused() {
    let mut run = climbed("globe", &[("start", 100.0), ("strips", 50.0)]);
    let verdict = |run: &MadeUpRun| claim_row(run, STRIPS)[5..].join(": ");
    set(&mut run.cases[1], "walls", "list");
    set(&mut run.cases[2], "walls", "strip");
    assert!(verdict(&run).starts_with("does not hold"));
    set(&mut run.cases[1], "depth-rule", "zfail");
    set(&mut run.cases[2], "depth-rule", "zpass");
    let refused = verdict(&run);
    assert!(
        refused.starts_with("cannot be tested") && refused.contains("differ in \"depth-rule\""),
        "{refused}"
    );
}

#[test]
fn a_missing_step_is_named() {
    let mut run = climbed("globe", &[("start", 9.0), ("culling", 5.0)]);
    assert!(!words(&section(&run, ABLATION)).contains("Steps without a result"));
    // One that was planned and not measured, and one that nobody planned.
    run.cases[2].missing();
    let named = "Steps without a result: step 2, culling: filling/s/globe/vertex/culling.";
    assert!(words(&section(&run, ABLATION)).contains(named));
    run.cases[2].ended(Status::Ok, "");
    set(&mut run.cases[2], "rung", "3");
    let named = "step 2 (the ablation goes on with 3, culling)";
    assert!(words(&section(&run, ABLATION)).contains(named));
}

fn plots(blocks: &[Block]) -> impl Iterator<Item = &str> {
    blocks.iter().filter_map(|block| match block {
        Block::Plot(plot) => Some(plot.svg.as_str()),
        _ => None,
    })
}

/// Lines of the figures that a plot carries, from the headings on.
fn plotted(svg: &str) -> std::str::Lines<'_> {
    let figures = svg.split("<metadata>").nth(1);
    let figures = figures.and_then(|rest| rest.split("</metadata>").next());
    figures.expect("figures").lines()
}

/// Drawn figures of the ablation's plot: each row's ratio to the depth-pass, and where its bar begins.
fn drawn_bars(chapter: &[Block]) -> Vec<(f64, Option<f64>)> {
    let svg = plots(chapter).find(|svg| svg.contains("bar begins"));
    let mut lines = plotted(svg.expect("a plot"));
    let headings = lines.next().expect("headings");
    assert!(headings.ends_with(",bar begins"), "{headings}");
    let number = |text: &str| text.parse().ok();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (
            number(cells[2]).expect("a ratio"),
            cells.last().copied().and_then(number),
        )
    };
    lines.map(row).collect()
}

/// Rows whose bar is not as long as the printed gain, or has a gain and no bar.
fn false_bars(bars: &[(f64, Option<f64>)], chapter: &[Block]) -> Vec<usize> {
    let table = tables(chapter).pop().expect("an ablation");
    let gain = |row: usize| {
        let text = &table.rows[row].cells[1].text;
        text.split(' ')
            .next()
            .and_then(|gain| gain.parse::<f64>().ok())
    };
    let is_false = |(row, (end, begin)): &(usize, &(f64, Option<f64>))| {
        let length = begin.map(|begin| begin / end);
        match (length, gain(*row)) {
            // Three digits are printed.
            (Some(length), Some(gain)) => (length / gain - 1.0).abs() > 0.005,
            (length, gain) => length.is_some() || gain.is_some(),
        }
    };
    let rows = bars.iter().enumerate();
    rows.filter(is_false).map(|(row, _)| row).collect()
}

#[test]
fn a_bar_is_as_long_as_the_gain_that_is_printed() {
    let steps = [
        ("start", 200.0),
        ("back-faces", 100.0),
        ("first-pass-colour", 20.0),
        ("strips", 28.0),
        ("z-pass", 35.0),
    ];
    let mut run = climbed("globe", &steps);
    set(&mut run.cases[3], "aside", "yes");
    // Processes that differ: the median of ratios is no ratio of medians.
    run.cases[4].timed(TIME, &[28.0, 90.0, 25.0, 31.0, 60.0, 30.0, 36.0, 20.0]);
    let chapter = section(&run, ABLATION);
    let bars = drawn_bars(&chapter);
    assert_eq!(bars.len(), 5);
    assert_eq!(false_bars(&bars, &chapter), [0; 0], "{bars:?}");
    // Control: bars from the row before, where that one is not kept.
    let from_before: Vec<_> = (0..bars.len())
        .map(|row| (bars[row].0, row.checked_sub(1).map(|before| bars[before].0)))
        .collect();
    assert!(false_bars(&from_before, &chapter).contains(&3), "{bars:?}");
}

#[test]
fn what_stands_aside_is_measured_and_nothing_is_measured_against_it() {
    let steps = [
        ("start", 100.0),
        ("first-pass-colour", 200.0),
        ("strips", 50.0),
    ];
    let mut run = climbed("globe", &steps);
    let gains = |run: &MadeUpRun| {
        let chapter = section(run, ABLATION);
        let table = tables(&chapter).pop().expect("an ablation");
        [1, 2].map(|row: usize| table.rows[row].cells[1].text.clone())
    };
    assert_eq!(gains(&run)[1], "4.00 × [4.00–4.00]", "200 ÷ 50");
    set(&mut run.cases[2], "aside", "yes");
    let aside = gains(&run);
    assert_eq!(aside, ["0.500 × [0.500–0.500]", "2.00 × [2.00–2.00]"]);
    let chapter = section(&run, ABLATION);
    assert!(words(&chapter).contains("aside, first-pass-colour"));
    // What cuts performance in half is what the document says of it.
    const HALVES: &str =
        "if you enable writes to the color buffer during the 1st pass, performance cuts in half";
    assert_eq!(claim_row(&run, HALVES)[5], "holds");
}

#[test]
fn what_is_no_difference_follows_from_identical_work() {
    let steps = [("start", 100.0), ("strips", 97.0)];
    let standing = |again_ms: Option<f64>| {
        let mut run = climbed("globe", &steps);
        if let Some(ms) = again_ms {
            again(&mut run, 2, ms);
        }
        let verdict = claim_row(&run, STRIPS)[5].clone();
        (verdict, words(&section(&run, ABLATION)))
    };
    // Without repeats 5 % are nothing; with quiet ones 3 % are something, with noisy ones nothing again.
    let (unknown, text) = standing(None);
    assert_eq!(unknown, "holds");
    assert!(text.contains("measured no identical work twice"), "{text}");
    let (quiet, text) = standing(Some(97.97));
    assert_eq!(quiet, "does not hold");
    assert!(text.contains("Less than 1.00 % either way"), "{text}");
    assert_eq!(standing(Some(101.0)).0, "holds");
}

#[test]
fn identical_work_that_scatters_is_no_difference() {
    let scatter = |percent: f64| {
        [-1.0, -1.0, -1.0, 0.0, 0.0, 1.0, 1.0, 1.0].map(|f| 1.0 + f * percent / 100.0)
    };
    let standing = |step_percent: f64, again_percent: f64| {
        let mut run = climbed("globe", &[("start", 100.0), ("strips", 100.0)]);
        let repeat = run.cases[2].id.repeat();
        let times = |percent| {
            let scattered = PROCESSES.iter().zip(scatter(percent));
            scattered
                .map(|(factor, off)| 100.0 * factor * off)
                .collect::<Vec<_>>()
        };
        run.case(repeat).timed(TIME, &times(again_percent));
        run.cases[1].timed(TIME, &times(step_percent));
        claim_row(&run, STRIPS)[5].clone()
    };
    assert_eq!(standing(1.0, 1.0), "holds");
    // Negative control: a step that scatters more widely than identical work tells nothing.
    assert_eq!(standing(2.0, 1.0), Standing::CannotTell.name());
}

#[test]
fn time_over_vertices_and_over_fragments_are_told_apart() {
    const FILL_RATE: &str = "this algorithm is fill rate limited";
    let found = |by_vertices_ms: f64, by_fragments_ms: f64| {
        let steps = [
            ("culling", 100.0),
            ("mesh-lod", by_vertices_ms),
            ("walls-global", by_fragments_ms),
        ];
        let mut run = climbed("horizon", &steps);
        for index in [2, 3] {
            set(&mut run.cases[index], "aside", "yes");
        }
        run.cases[2].figure("vertices", 250.0);
        run.cases[3].figure("stencil_fragments", 29_000.0);
        claim_row(&run, FILL_RATE)[4..6].join(" | ")
    };
    // Four times fewer vertices do nothing; four times as many fragments take twice as long.
    assert_eq!(
        found(100.0, 200.0),
        "horizon: fragments 0.500 [0.500–0.500], vertices 0 [0–0] | holds"
    );
    let vertices = found(25.0, 100.0);
    assert!(
        vertices.ends_with("vertices 1.00 [1.00–1.00] | does not hold"),
        "{vertices}"
    );
    // Fewer vertices and fewer fragments: nobody knows which of the two it was.
    let mut run = climbed("horizon", &[("culling", 100.0), ("mesh-lod", 25.0)]);
    run.cases[2]
        .figure("vertices", 250.0)
        .figure("stencil_fragments", 2_500.0);
    assert_eq!(claim_row(&run, FILL_RATE)[5], "not measured");
}

#[test]
fn a_step_shows_its_walls_its_work_and_its_wrong_pixels() {
    let steps = [("culling", 100.0), ("walls-global", 160.0)];
    let mut run = climbed("horizon", &steps);
    run.cases[1].figure("wall_height_m", 1_500.0);
    run.cases[2]
        .figure("wall_height_m", 24_000.0)
        .figure("stencil_fragments", 20_000.0)
        .figure("mismatched_px", 11.0);
    let row = |run: &MadeUpRun, row: usize| {
        let chapter = section(run, ABLATION);
        let cells = texts(tables(&chapter)[1], row).join(" | ");
        cells.replace('\u{202f}', ",")
    };
    let global = row(&run, 1);
    for words in [
        "0.625 × [0.625–0.625]",
        "stencil fragments 5,000 → 20,000",
        "| 24,000 | 11 |",
    ] {
        assert!(global.contains(words), "{words}: {global}");
    }
    assert!(row(&run, 0).contains("| 1,500 | 2 |"));
    // Negative control: a wrong picture has no ratio of times.
    run.cases[2].ended(Status::Wrong, "3 pixels");
    assert!(!row(&run, 1).contains("0.625"));
}

const CLAIMS_SECTION: &str = "The claims of 2007";

/// What the document says of strips.
const STRIPS: &str = "did not change the frame rate";

/// The row of the claim with these words.
fn claim_row(run: &MadeUpRun, words: &str) -> Vec<String> {
    let chapter = section(run, CLAIMS_SECTION);
    let table = tables(&chapter)[0];
    let quoted = format!("“{words}”");
    let found = table.rows.iter().find(|row| row.cells[0].text == quoted);
    let row = found.expect("every claim has its row");
    row.cells.iter().map(|cell| cell.text.clone()).collect()
}

#[test]
fn every_claim_has_a_row_and_what_was_not_run_an_empty_cell() {
    const CAP: &str = "This resulted in a modest performance gain from 92 to 97 fps for the worst case of \
                       looking out along the horizon.";
    let mut run = climbed("horizon", &[("start", 105.4), ("bottom-cap", 100.0)]);
    run.cases[2].figure("vertices", 900.0);
    let chapter = section(&run, CLAIMS_SECTION);
    let table = tables(&chapter)[0];
    assert_eq!(table.rows.len(), PAPER.claims.len());
    let row = claim_row(&run, CAP);
    assert_eq!(row[1..3], ["measured", "1.054 ×"]);
    assert_eq!(row[4..6], ["horizon 1.05 × [1.05–1.05]", "holds"]);
    assert_eq!(row[6], "horizon: vertices 1\u{202f}000 → 900");
    let absent = claim_row(&run, STRIPS);
    let how = "its rows are not in this run. To measure it: terrafill bench --study filling --full --processes 5";
    assert_eq!(absent[4..], ["–", "not measured", how]);
    let never = claim_row(
        &run,
        "using less memory gives the VBOs a better chance of staying in video memory",
    );
    assert_eq!(never[5], "cannot be tested");
    let all = PAPER.claims.len();
    assert!(words(&chapter).contains(&format!("{all} claims: ")));
    // Negative control: another gain is another verdict.
    let mut run = climbed("horizon", &[("start", 130.0), ("bottom-cap", 100.0)]);
    run.cases[2].figure("vertices", 900.0);
    assert_eq!(claim_row(&run, CAP)[5], "does not hold");
    // An eye inside keeps the cap: as many vertices say nothing of leaving it out.
    let steps = [("start", 130.0), ("bottom-cap", 100.0), ("strips", 99.0)];
    let inside = climbed("horizon", &steps);
    let row = claim_row(&inside, CAP);
    assert_eq!((row[4].as_str(), row[5].as_str()), ("–", "not measured"));
    assert!(
        row[6].starts_with("in these views the eye is inside"),
        "{row:?}"
    );
    // As data: a line for each claim.
    let (_folder, loaded) = written(&run);
    let tables = FillingChapter.tables(&loaded).expect("tables");
    let csv = tables.iter().find(|table| table.file == "claims.csv");
    let lines = csv.expect("the claims").text.lines().count();
    assert_eq!(lines, 1 + all);
    // Negative control: a run that measured nothing of it shows no table.
    assert_eq!(section(&on_cpu(), CLAIMS_SECTION), []);
}

#[test]
fn centric_normals_are_reasonable_where_every_picture_on_terrain_is_right() {
    const EARTH: &str = "I will have to test this for earth to see if it is reasonable.";
    const STORED: &str = "reduced by not storing any normals for the mesh";
    let with = |outside: f64, status: Status| {
        let mut run = climbed("globe", &[("one-volume", 100.0), ("normals-stored", 100.0)]);
        for (case, bytes) in [(1, 1_600.0), (2, 2_800.0)] {
            run.cases[case].figure("vertex_bytes", bytes);
        }
        let more = [("role", "main"), ("normals", "centric")];
        for view in ["globe", "horizon"] {
            let key = format!("hills/{view}/vertex/doubled,normals=centric");
            let case = drawn(&mut run, &key, &more).figure("wall_shift_m", 28.5);
            if view == "horizon" {
                case.figure("mismatched_px_outside_band", outside)
                    .ended(status, "");
            }
        }
        run
    };
    let right = with(0.0, Status::Ok);
    let row = claim_row(&right, EARTH);
    let first = "hills, globe: 0 px outside the band, walls off by up to 28.5 m";
    assert!(row[4].starts_with(first), "{row:?}");
    assert_eq!(row[5], "holds");
    let bytes = claim_row(&right, STORED);
    assert_eq!(bytes[4..6], ["globe 0.571 ×", "holds"]);
    // Negative control: one view that is wrong.
    let wrong = with(9.0, Status::Wrong);
    let row = claim_row(&wrong, EARTH);
    assert!(row[4].contains("horizon: 9 px outside the band"), "{row:?}");
    assert_eq!(row[5], "does not hold");
}

#[test]
fn what_is_drawn_instead_of_volumes_is_laid_beside_them() {
    const MESH: &str =
        "creating the mesh and its LODs will be slow and potentially consume a lot of memory";
    const FIGHTING: &str =
        "z-fighting is likely to become an issue between the mesh and the terrain";
    const GOALS: &str = "The performance goals were to match the original fill in STK which does not conform to terrain.";
    let rows = |flat_ms: f64, draped: f64, outside: f64| {
        let mut run = climbed("globe", &[("start", 100.0)]);
        let volumes = [("role", "main"), ("variant", "doubled")];
        timed(&mut run, "hills/globe/vertex/doubled", &volumes, 10.0)
            .timed("prepare_cpu_ms", &[5.0; 5])
            .figure("geometry_bytes", 1_000.0);
        for (technique, knob, value, ms) in [
            ("flat-mesh", "height-m", "top", flat_ms),
            ("draped-mesh", "depth-offset", "2^-10", 3.0),
            ("draped-mesh", "depth-offset", "0", 3.0),
        ] {
            let key = format!("hills/globe/{technique}/{knob}={value}");
            let more = [("role", "main"), ("approximate", "yes"), (knob, value)];
            timed(&mut run, &key, &more, ms)
                .timed("prepare_cpu_ms", &[5.0 * draped; 5])
                .figure("geometry_bytes", 4_000.0)
                .figure("mismatched_px_outside_band", outside)
                .ended(Status::Wrong, "approximate")
                .may_be_wrong = true;
        }
        [MESH, FIGHTING, GOALS].map(|words| claim_row(&run, words)[4..6].join(": "))
    };
    assert_eq!(
        rows(20.0, 40.0, 7.0),
        [
            "hills, globe, prepare_cpu_ms 40.0 ×; hills, globe, geometry_bytes 4.00 ×: holds",
            "hills, globe: 7 px outside the band: holds",
            "hills, globe 2.00 × [2.00–2.00]: holds",
        ]
    );
    // Negative controls: a cut that takes less than volumes do, one that is right, a flat mesh that is faster.
    let repeats = rows(5.0, 0.5, 0.0);
    assert!(
        repeats.iter().all(|row| row.ends_with(": does not hold")),
        "{repeats:?}"
    );
}

#[test]
fn more_processes_are_wanted_for_what_is_undecided_and_for_nothing_else() {
    let keys_beside = |strips_ms: &[f64], again_ms: Option<f64>| {
        let mut run = climbed("globe", &[("start", 100.0)]);
        if let Some(ms) = again_ms {
            again(&mut run, 1, ms);
        }
        let more = [
            ("role", "ladder"),
            ("rung", "2"),
            ("step", "strips"),
            ("layout", "doubled"),
        ];
        let times: Vec<f64> = PROCESSES
            .iter()
            .zip(strips_ms)
            .map(|(factor, ms)| factor * ms)
            .collect();
        drawn(&mut run, "s/globe/vertex/strips", &more).timed(TIME, &times);
        let (_folder, run) = written(&run);
        FillingChapter.undecided(&run)
    };
    let keys = |strips_ms: &[f64]| keys_beside(strips_ms, None);
    let open = keys(&[90.0, 110.0, 80.0, 120.0, 100.0, 95.0, 130.0, 70.0]);
    assert_eq!(
        open,
        [
            "filling/s/globe/vertex/start",
            "filling/s/globe/vertex/strips"
        ]
    );
    assert!(keys(&[100.0; 8]).is_empty());
    // Too few processes leave everything open.
    assert_eq!(keys(&[100.0; 3]).len(), 2);
    // So does noise that would hide what the document measured; the repeats are measured with it.
    assert!(keys_beside(&[100.0; 8], Some(101.0)).is_empty());
    assert_eq!(keys_beside(&[100.0; 8], Some(104.0)).len(), 3);
}

/// What the tables quote, and where it stands.
fn quotations() -> impl Iterator<Item = (&'static str, &'static str)> {
    let claims = PAPER.claims.iter();
    let claims = claims.map(|claimed| (claimed.words.as_str(), claimed.place.as_str()));
    let quoted = PAPER.quoted.iter();
    claims.chain(quoted.map(|[words, place]| (words.as_str(), place.as_str())))
}

/// What the chapter quotes: all that stands between quotation marks in its sources, values that are put
/// in at run time left out.
fn quoted() -> Vec<&'static str> {
    let sources = [
        include_str!("claims.rs"),
        include_str!("from_2007.rs"),
        include_str!("memory.rs"),
        include_str!("mod.rs"),
        include_str!("comparisons.rs"),
        include_str!("subdivision.rs"),
        include_str!("textured.rs"),
        include_str!("../../../../../papers/cozzi-2007.toml"),
    ];
    let quotes = sources
        .into_iter()
        .flat_map(|source| source.split('“').skip(1));
    let quotes = quotes.filter_map(|rest| rest.split('”').next());
    quotes.filter(|words| *words != "{}").collect()
}

/// Whether `text` holds `words`, line breaks or not.
fn holds(text: &str, words: &str) -> bool {
    let joined = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    joined(text).contains(&joined(words))
}

#[test]
fn only_words_of_the_table_stand_between_quotation_marks() {
    let found = quoted();
    assert!(found.len() >= 2, "{found:?}");
    for words in found {
        assert!(
            quotations().any(|(known, _)| holds(known, words)),
            "{words:?} is not in the table"
        );
    }
    let distinct: BTreeSet<&str> = quotations().map(|(words, _)| words).collect();
    assert_eq!(
        distinct.len(),
        quotations().count(),
        "no claim stands twice"
    );
    for (words, place) in quotations() {
        assert!(!place.is_empty());
        assert!(words.split_whitespace().count() <= 25, "short: {words:?}");
    }
}

#[test]
#[ignore = "needs data: papers"]
fn quotations_are_words_of_the_document() {
    // As plain text, beside the data folder.
    let path = format!("../papers/{}.txt", PAPER.document);
    let document = String::from_utf8(data::bytes(&path)).expect("UTF-8");
    assert_eq!(PAPER.misquoted(&document), [""; 0]);
    // Negative controls: what an earlier version quoted, and one letter.
    assert!(!holds(&document, "two costly atan calls"));
    assert!(!holds(&document, "did not change the frame-rate"));
}

const MATRIX: &str = "Every technique, layout and switch";

/// Cells with their hashes of mask and regions.
fn matrix(cells: &[(&str, &str, &str)]) -> MadeUpRun {
    let mut run = on_cpu();
    for (variant, mask, ids) in cells {
        drawn(
            &mut run,
            &format!("california/globe/vertex/{variant}"),
            &[("role", "matrix")],
        )
        .note("mask_hash", mask)
        .note("ids_hash", ids);
    }
    run
}

#[test]
fn equal_pictures_are_green_and_one_wrong_hash_is_red_and_named() {
    let mut cells = vec![
        ("doubled", "m", "i"),
        ("doubled,faces=two-pass", "m", "i"),
        ("pulled", "m", "i"),
        ("doubled,colour=one-colour", "m", ""),
        ("doubled,boundary-lod-px=0.5", "l", "j"),
        ("pulled,boundary-lod-px=0.5", "l", "j"),
    ];
    let chapter = section(&matrix(&cells), MATRIX);
    assert!(words(&chapter).contains("california: 6 of 6 cells right and equal"));
    let table = tables(&chapter)[0];
    let heading = |column: usize| table.headings[column].text.as_str();
    assert_eq!(
        [heading(1), heading(2)],
        ["as it should be used", "boundary-lod-px=0.5"]
    );
    assert_eq!(table.rows.len(), 2);
    assert_eq!(
        texts(table, 1),
        ["california: vertex/pulled", "✓", "✓", "", ""],
        "not in the run"
    );
    assert_eq!(table.rows[0].cells[1].class, CellClass::Good);
    // Cells are no rows of their scene's tables.
    assert_eq!(section(&matrix(&cells), "california"), []);
    // Negative controls: another mask, another picture of regions under the same mask, another boundary's picture.
    let red = |cells: &[(&str, &str, &str)]| words(&section(&matrix(cells), MATRIX));
    cells[2] = ("pulled", "x", "i");
    let named = "california/globe/vertex/pulled: its mask differs from that of vertex/doubled";
    assert!(red(&cells).contains(named) && red(&cells).contains("5 of 6 cells"));
    cells[2] = ("pulled", "m", "x");
    let named = "pulled: its regions' picture differs from that of vertex/doubled";
    assert!(red(&cells).contains(named));
    cells[2] = ("pulled", "m", "i");
    cells[5] = ("pulled,boundary-lod-px=0.5", "m", "i");
    assert!(red(&cells).contains("differs from that of vertex/doubled,boundary-lod-px=0.5"));
}

#[test]
fn the_same_picture_is_not_enough_and_what_was_not_drawn_is_never_green() {
    let cells = [("doubled", "m", "i"), ("pulled", "m", "i")];
    let red = |change: &dyn Fn(&mut MadeUpCase)| {
        let mut run = matrix(&cells);
        change(&mut run.cases[1]);
        words(&section(&run, MATRIX))
    };
    assert!(red(&|_| ()).contains("2 of 2 cells"));
    let wrong = red(&|case| {
        case.figure("mismatched_px_outside_band", 3.0);
    });
    assert!(wrong.contains("pulled: 3 wrong pixels outside the band"));
    let wrong = red(&|case| {
        case.ended(Status::Wrong, "41 pixels");
    });
    assert!(wrong.contains("pulled: wrong: 41 pixels"));
    let missing = red(&|case| {
        case.missing();
    });
    assert!(missing.contains("1 of 2 cells") && missing.contains("pulled: missing: "));
    let unhashed = red(&|case| {
        case.note("mask_hash", "");
    });
    assert!(unhashed.contains("pulled: no hash of its mask"));
    let skipped = red(&|case| {
        case.ended(
            Status::Skipped,
            "the adapter lacks it; a remark on the view",
        );
    });
    assert!(
        skipped.contains("Unavailable on this device") && skipped.contains("lacks it (1 cells)")
    );
    assert!(skipped.contains("1 of 1 cells right and equal"));
}

/// Bytes of a layout by formula and as allocated.
fn layout(
    run: &mut MadeUpRun,
    layout: (&str, &str),
    formula: [f64; 2],
    allocated: Option<[f64; 2]>,
) {
    let regions = if allocated.is_some() { "1" } else { "5000" };
    let conditions = [
        ("scene", "california"),
        ("technique", layout.0),
        ("layout", layout.1),
        ("regions", regions),
        ("role", "memory"),
    ];
    let name = format!("california/memory/{}/{}/{regions}", layout.0, layout.1);
    let case = run.case(case_id("filling", &name, &conditions));
    case.figure("mesh_vertices", 109.0)
        .figure("formula_vertex_bytes", formula[0])
        .figure("formula_index_bytes", formula[1]);
    if let Some([vertex, index]) = allocated {
        case.figure("allocated_vertex_bytes", vertex)
            .figure("allocated_index_bytes", index);
    }
}

#[test]
fn bytes_by_formula_and_as_allocated_stand_side_by_side_and_one_byte_is_red() {
    let of = |allocated: [f64; 2]| {
        let mut run = on_cpu();
        timed(&mut run, "california/globe/vertex/doubled", &[], 10.0);
        layout(
            &mut run,
            ("vertex", "doubled"),
            [900.0, 100.0],
            Some([900.0, 100.0]),
        );
        layout(&mut run, ("vertex", "doubled"), [4.5e6, 100.0], None);
        layout(
            &mut run,
            ("native", "gs-line"),
            [310.0, 100.0],
            Some(allocated),
        );
        let told = answers(&run).requirements.into_iter();
        let told: Vec<Finding> = told.filter(|of| of.claim.contains("its formula")).collect();
        (section(&run, "Memory"), told[0].clone())
    };
    let (right, told) = of([310.0, 100.0]);
    assert!(words(&right).contains("bytes over regions"));
    assert_eq!(texts(tables(&right)[0], 1).last(), Some(&"0.410 ×"));
    assert_eq!(told.standing, Standing::Holds);
    // Negative controls: one byte; errors that cancel in the sum are two errors.
    let (wrong, told) = of([311.0, 100.0]);
    assert_eq!(told.standing, Standing::DoesNotHold);
    let named =
        "california/native/gs-line: positions and flags: 310 bytes by formula, 311 allocated";
    assert!(told.because.contains(named), "{}", told.because);
    assert_eq!(tables(&wrong)[0].rows[1].cells[1].class, CellClass::Bad);
    let (_, told) = of([311.0, 99.0]);
    let both = "311 allocated; indices: 100 bytes by formula, 99 allocated";
    assert!(told.because.contains(both), "{}", told.because);
}

#[test]
fn about_forty_per_cent_is_measured_in_bytes() {
    const FORTY: &str = "The GS algorithm uses only about 40% of the memory as the VS algorithm";
    let row = |bytes: f64| {
        let mut run = on_cpu();
        for (technique, name, bytes) in [
            ("vertex", "doubled", 1_000.0),
            // A control that needs no geometry shader is none.
            ("native", "vs-control", 700.0),
            ("native", "gs-degenerate/list", bytes),
        ] {
            let bytes = [bytes, 0.0];
            layout(&mut run, (technique, name), bytes, Some(bytes));
        }
        claim_row(&run, FORTY)[4..].to_vec()
    };
    let found = row(410.0);
    assert_eq!(
        found[..2],
        ["native/gs-degenerate/list 0.410 ×", "holds"].map(str::to_owned)
    );
    assert_eq!(row(449.0)[1], "holds");
    assert_eq!(
        [460.0, 340.0].map(|bytes| row(bytes)[1].clone()),
        ["does not hold"; 2]
    );
    // The document's own layouts on its California: 1,056 vertices and 1,107 triangles have
    // 2 · 1,056 − 2 − 1,107 = 1,003 boundary edges. The geometry shader reads vertices of 12 bytes and 3 indices for
    // each boundary edge beside the triangles'; the vertex shader two copies of 16 bytes, two caps, and 2 indices of
    // a strip for each boundary edge.
    let geometry_shader = 1_056 * 12 + (3_321 + 3 * 1_003) * 2;
    let vertex_shader = 1_056 * 2 * 16 + (2 * 3_321 + 2 * 1_003) * 2;
    let ratio = f64::from(geometry_shader) / f64::from(vertex_shader);
    assert!(found[2].contains(&format!("{ratio:.3} ×")), "{found:?}");
}

/// The cell of the first view's answer below a heading.
fn answered(run: &MadeUpRun, heading: &str) -> String {
    let blocks = answers(run).blocks;
    let table = tables(&blocks)[0];
    let mut headings = table.headings.iter();
    let column = headings.position(|own| own.text == heading);
    table.rows[0].cells[column.expect("a heading")].text.clone()
}

#[test]
fn pairs_are_ratios_within_processes_and_gaps_within_the_noise_are_ties() {
    let of = |control_ms: f64, shader_ms: f64| {
        let mut run = on_cpu();
        let role = [("role", "main")];
        timed(&mut run, "s/globe/native/vs-control", &role, control_ms);
        timed(&mut run, "s/globe/native/gs-line", &role, shader_ms);
        again(&mut run, 0, 1.05 * control_ms);
        let chapter = section(&run, "One thing changed");
        let cells = texts(tables(&chapter)[0], 0).join(" | ");
        let ties = answered(&run, "ties");
        (cells, words(&blocks(&run)), ties)
    };
    let (cells, all, _) = of(10.0, 11.0);
    assert_eq!(
        cells, "s, globe | – | 1.10 × [1.10–1.10] | – | –",
        "not measured, not 0"
    );
    assert!(!all.contains("(again)"), "repeats are in no table");
    // Negative controls: swapped operands, and a gap that identical work has as well.
    assert!(of(11.0, 10.0).0.contains("0.909 × ["));
    let (tie, _, ties) = of(10.0, 10.4);
    assert!(tie.contains("1.04 × [1.04–1.04] (tie)"), "{tie}");
    assert_eq!(ties, "native/gs-line");
}

#[test]
fn a_run_without_them_has_none_of_these_sections() {
    let mut run = on_cpu();
    timed(&mut run, "california/globe/vertex/doubled", &[], 10.0);
    let headings: Vec<String> = blocks(&run)
        .into_iter()
        .filter_map(|block| match block {
            Block::Heading { level: 3, text } => Some(text),
            _ => None,
        })
        .collect();
    assert_eq!(headings, ["california"], "a case of no role is listed");
    assert_eq!(blocks(&MadeUpRun::default()), []);
}

const NATIVE: &str = "california/top-down/vertex/doubled,texture=atan2-native+bowring-1";
const CHOSEN: &str = "california/top-down/vertex/doubled,texture=chosen";
const LEAST: &str = "california/top-down/vertex/doubled,texture=floor";

/// Plain, chosen, native and least fills that take these times.
fn textured_run(times: [f64; 4]) -> MadeUpRun {
    let mut run = on_cpu();
    timed(
        &mut run,
        "california/top-down/vertex/doubled",
        &[("role", "main")],
        times[0],
    );
    // As a run records them: every switch, also where it is as usual.
    let recorded = [
        ("role", "texture"),
        ("normalize", "needed"),
        ("picture", "scene"),
        ("position", "eye-region"),
    ];
    for (key, ms) in [CHOSEN, NATIVE, LEAST].into_iter().zip(&times[1..]) {
        let case = timed(&mut run, key, &recorded, *ms);
        if key != LEAST {
            case.figure("texel_rms", 0.0625)
                .figure("texel_max", 0.125)
                .figure("texel_non_finite", 0.0)
                .figure("texel_compared_px", 4_321.0)
                .note(
                    "texture_route",
                    "gnomonic-3; left out: gnomonic-1: 3.00 texels of 0.5",
                );
        }
    }
    run
}

/// The same with the document's fill as it was, without its normalize, and with a texture of spherical
/// coordinates: wrong, and timed all the same.
fn with_document(times: [f64; 4]) -> MadeUpRun {
    let mut run = textured_run(times);
    for (variant, normalize, ms) in [
        (
            "normalize=superfluous,position=inverse-ecef,texture=atan2-native+geocentric",
            "superfluous",
            times[2],
        ),
        (
            "position=inverse-ecef,texture=atan2-native+geocentric",
            "needed",
            times[2],
        ),
        ("position=inverse-ecef,texture=cube-512", "needed", times[1]),
    ] {
        let key = format!("california/top-down/vertex/doubled,{variant}");
        let recorded = [
            ("role", "texture"),
            ("normalize", normalize),
            ("picture", "scene"),
            ("position", "inverse-ecef"),
        ];
        let case = timed(&mut run, &key, &recorded, ms).ended(Status::Wrong, "RMS error");
        case.may_be_wrong = true;
    }
    run
}

#[test]
fn textured_fill_is_compared_with_plain_fill_and_the_document() {
    let chapter = |times| section(&with_document(times), "Textured fill");
    let first = chapter([10.0, 12.0, 30.0, 11.0]);
    let table = tables(&first)[0];
    let ratios = |fill: &str| {
        let cells = row_of(table, &format!("vertex/doubled: {fill}"));
        [2, 3].map(|column: usize| {
            cells[column]
                .text
                .split(' ')
                .next()
                .unwrap_or("")
                .to_owned()
        })
    };
    // Over the plain fill, and over the chosen route.
    for (fill, over) in [
        ("as in 2007", ["3.00", "2.50"]),
        ("chosen route", ["1.20", "1.00"]),
        ("least textured fill", ["1.10", "0.917"]),
        ("native atan2", ["3.00", "2.50"]),
        ("plain fill", ["–", "–"]),
    ] {
        assert_eq!(ratios(fill), over, "{fill}");
    }
    let text = words(&first);
    for word in [
        "0.0625",
        "0.125",
        "4\u{202f}321",
        "gnomonic-1: 3.00 texels of 0.5",
    ] {
        assert!(text.contains(word), "{word}");
    }
    // Textured fills stand in their section, not among the layouts.
    let scene = section(&textured_run([10.0, 12.0, 30.0, 11.0]), "california");
    assert!(!words(&scene).contains("texture=chosen"));
}

#[test]
fn a_textured_fill_by_the_chosen_route_stays_near_the_plain_one() {
    const DOUBLE: &str = "If the atan calls can be eliminated, the performance could double.";
    let verdicts = |times| {
        let run = with_document(times);
        let goal = answers(&run).requirements.into_iter();
        let mut goal = goal.filter(|finding| finding.claim.starts_with("This project's goal"));
        let goal = goal.next().map(|finding| finding.standing);
        (goal, claim_row(&run, DOUBLE)[5].clone())
    };
    let found = verdicts([10.0, 12.0, 30.0, 11.0]);
    assert_eq!(found, (Some(Standing::Holds), "holds".to_owned()));
    // Negative controls: other times, other answers.
    let found = verdicts([10.0, 20.0, 20.0, 15.0]);
    assert_eq!(
        found,
        (Some(Standing::DoesNotHold), "no difference".to_owned())
    );
}

#[test]
fn a_wrong_textured_fill_has_no_time_and_what_is_absent_is_named() {
    let mut run = textured_run([10.0, 12.0, 30.0, 11.0]);
    run.cases[1].ended(Status::Wrong, "RMS error 0.900 texels, allowed 0.25");
    let chapter = section(&run, "Textured fill");
    let text = words(&chapter);
    assert!(!text.contains("2.50 ×"), "a wrong fill is never fast");
    let table = tables(&chapter)[0];
    let row = table.rows.iter().find(|row| row.status == "wrong");
    let remark = &row.expect("the chosen route").remark;
    assert!(
        remark.ends_with("RMS error 0.900 texels, allowed 0.25"),
        "{remark}"
    );
    run.cases[1].ended(Status::Skipped, "no picture in this scene");
    assert!(words(&section(&run, "Textured fill")).contains("no picture in this scene"));
    // A right fill whose texels nobody compared is bad news.
    let is_bad = |compared_px: f64| {
        let mut run = textured_run([10.0, 12.0, 30.0, 11.0]);
        run.cases[1].figure("texel_compared_px", compared_px);
        let chapter = section(&run, "Textured fill");
        let cells = row_of(tables(&chapter)[0], "vertex/doubled: chosen route");
        cells.iter().any(|cell| cell.class == CellClass::Bad)
    };
    assert!(is_bad(0.0) && !is_bad(4_321.0));
}

#[test]
fn pictures_of_a_textured_fill_are_reference_technique_and_difference() {
    let mut run = textured_run([10.0, 12.0, 30.0, 11.0]);
    run.cases[1]
        .figure("colour_max", 3.0)
        .figure("colour_mean", 0.5)
        .note("reference_image", "images/a.png")
        .note("image", "images/b.png")
        .note("difference_image", "images/c.png");
    let chapter = section(&run, "Textured fill");
    let Some(Block::Pictures(pictures)) = chapter.last() else {
        panic!("pictures: {chapter:?}");
    };
    let paths: Vec<&str> = pictures.figures[0]
        .pictures
        .iter()
        .map(|p| p.path.as_str())
        .collect();
    assert_eq!(paths, ["images/a.png", "images/b.png", "images/c.png"]);
    assert_eq!(pictures.figures[0].notes, ["vertex/doubled: chosen route"]);
    let cells = row_of(tables(&chapter)[0], "vertex/doubled: chosen route");
    let colours = [8, 9].map(|column: usize| cells[column].text.as_str());
    assert_eq!(colours, ["0.500", "3"]);
}

#[test]
fn labels_say_what_differs() {
    let label_of = |variant: &str| {
        let mut run = on_cpu();
        add(&mut run, &format!("s/v/vertex/{variant}"), &[]);
        textured::label(&written(&run).1.cases[0])
    };
    for (variant, expected) in [
        ("doubled", "plain fill"),
        ("doubled,texture=chosen", "chosen route"),
        ("doubled,texture=floor", "least textured fill"),
        (
            "doubled,picture=32,texture=chosen",
            "picture=32,texture=chosen",
        ),
        (
            "doubled,normalize=superfluous,position=inverse-ecef,texture=atan2-native+geocentric",
            "as in 2007",
        ),
        ("doubled,texture=gnomonic-3", "texture=gnomonic-3"),
        (
            "doubled,normalize=needed,picture=scene,position=eye-region,texture=chosen",
            "chosen route",
        ),
    ] {
        assert_eq!(label_of(variant), expected);
    }
    let mut sets: Vec<&str> = PAPER.cases.values().map(String::as_str).collect();
    assert!(sets.iter().all(|set| set.split(',').is_sorted()));
    let all = sets.len();
    sets.sort_unstable();
    sets.dedup();
    assert_eq!(sets.len(), all, "each name has switches of its own");
}

#[test]
fn coarse_caps_with_tall_walls_are_compared_with_fine_ones() {
    let run = |highest_m: f64, faster: f64, coarsest: f64| {
        let mut run = on_cpu();
        for (step, factor, wall_m, triangles) in [
            ("0.3", 1.0, 900.0, 1_234.0),
            ("3", faster, 4e3, 500.0),
            ("10", faster, 4e4, coarsest),
        ] {
            let key = format!("s/v/vertex/doubled,cap-step-deg={step}");
            timed(&mut run, &key, &[("role", "subdivision")], 12.0 / factor)
                .figure("wall_height_m", wall_m)
                .figure("wall_bound_m", 1.2 * 4e3_f64.max(wall_m.min(highest_m)))
                .figure("cap_triangles", triangles);
        }
        assert_eq!(section(&run, "s"), [], "no table of its own");
        run
    };
    let swept_to = |highest_m: f64| {
        let run = run(highest_m, 1.5, 400.0);
        section(&run, "Subdivision against wall height")
    };
    let faster = swept_to(f64::INFINITY);
    assert!(words(&faster).contains("tallest wall, m"));
    let walls = findings(&faster)[0];
    assert_eq!(walls.standing, Standing::Holds);
    assert!(
        walls
            .because
            .ends_with("10°: 40\u{202f}000 of 48\u{202f}000 m"),
        "{}",
        walls.because
    );
    // Negative control: one wall that is taller than its step allows.
    let taller = swept_to(1e4);
    assert_eq!(findings(&taller)[0].standing, Standing::DoesNotHold);
    const PAYOFF: &str = "the extra subdivision is not going to payoff";
    let claim = |faster: f64, coarsest: f64| {
        let run = run(f64::INFINITY, faster, coarsest);
        claim_row(&run, PAYOFF)[4..6].join(": ")
    };
    assert_eq!(
        claim(1.5, 400.0),
        "s, v: vertex/doubled 0.667 × [0.667–0.667]: holds"
    );
    // Negative control: where coarse is slower, it does not hold.
    assert!(claim(0.8, 400.0).ends_with("1.25 × [1.25–1.25]: does not hold"));
    // A step that gives the mesh of a finer one is none.
    assert_eq!(claim(1.5, 500.0), claim(1.5, 400.0));
}

#[test]
fn a_rival_stands_beside_the_fastest_of_ours_and_competes_with_nothing() {
    let table = |ms: f64, has_ours: bool| {
        let mut run = on_cpu();
        if has_ours {
            timed(&mut run, "s/v/vertex/doubled", &[("role", "main")], 6.0);
        }
        let rival = timed(&mut run, "s/v/cesium/volumes", &[("role", "rival")], ms);
        rival.ended(Status::Wrong, "3 pixels").may_be_wrong = true;
        rival.note("texture_route", "CesiumJS 1 in Chromium 2");
        let chapter = section(&run, "What users would pick instead");
        assert!(words(&chapter).contains("Measured: CesiumJS 1 in Chromium 2."));
        let row = texts(tables(&chapter)[0], 0).into_iter();
        row.map(str::to_owned).collect::<Vec<String>>()
    };
    let row = table(18.0, true);
    assert_eq!(row[1..3], ["cesium/volumes", "vertex/doubled"]);
    assert_eq!(row[5], "wrong");
    assert!(row[4].starts_with("3.00 × ["), "{row:?}");
    // Negative controls: faster than ours it is no winner, and without ours there is nothing to divide by.
    let row = table(3.0, true);
    assert!(
        row[2] == "vertex/doubled" && row[4].starts_with("0.500 × ["),
        "{row:?}"
    );
    assert_eq!(table(3.0, false)[4], "–");
    assert_eq!(section(&mixed(), "What users would pick instead"), []);
}

/// A scene with both passes, a right, a wrong, a skipped and a missing technique.
fn mixed() -> MadeUpRun {
    let mut run = on_cpu();
    let of = |technique: &str| format!("countries-110m/globe/{technique}");
    timed(
        &mut run,
        &of("depth-pass/full-screen"),
        &[("role", "baseline")],
        10.0,
    );
    timed(
        &mut run,
        &of("stencil-pass/full-screen"),
        &[("role", "baseline")],
        3.0,
    );
    let main = [("role", "main")];
    timed(&mut run, &of("vertex/doubled"), &main, 36.0)
        .timed("fill_gpu_ms", &[18.0; 8])
        .figure("geometry_bytes", 1_390_000.0)
        .figure("boundary_deviation_m", 90.0)
        .note("left_out", "12 beyond the horizon");
    timed(&mut run, &of("vertex/pulled"), &main, 7.75).ended(Status::Wrong, "41 pixels");
    add(&mut run, &of("vertex/doubled,walls=list"), &main).ended(Status::Skipped, "no lists");
    add(&mut run, &of("native/gs-line"), &main).missing();
    run
}

fn row_of<'a>(table: &'a Table, name: &str) -> &'a [Cell] {
    let row = table.rows.iter().find(|row| row.cells[0].text == name);
    &row.expect("the row").cells
}

#[test]
fn a_wrong_time_counts_for_nothing_and_what_is_absent_has_its_reason() {
    let chapter = section(&mixed(), "countries-110m");
    let table = tables(&chapter).pop().expect("the table of the view");
    let wrong = row_of(table, "vertex/pulled");
    assert_eq!(wrong[5].class, CellClass::Void);
    for cell in &wrong[1..4] {
        assert!(cell.class == CellClass::Absent && cell.title == "41 pixels");
    }
    let right = row_of(table, "vertex/doubled");
    assert!(
        right[5].class == CellClass::Plain && right[5].text.starts_with("38.7 ("),
        "{right:?}"
    );
    let texts = [1, 2, 3, 6].map(|column: usize| right[column].text.as_str());
    assert!(texts[0].starts_with("1.00 ×"));
    assert_eq!(texts[1..], ["3.60", "12.0", "18.0"]);
    for name in ["vertex/doubled,walls=list", "native/gs-line"] {
        let cells = row_of(table, name);
        for cell in cells[1..4].iter().chain(&cells[5..]) {
            assert!(
                cell.class == CellClass::Absent && !cell.title.is_empty(),
                "{cell:?}"
            );
        }
    }
    let pass = row_of(table, "depth-pass/full-screen");
    assert_eq!(pass[19].title, crate::keys::HAUSDORFF_PX.absent);
    let plot = plots(&chapter).next().expect("a plot");
    assert!(plot.contains("1.00 × · 38.7 ms") && !plot.contains("0.215"));
    for word in [
        "wrong",
        "skipped",
        "missing",
        "fastest = 1",
        "depth-pass 0.278 × (dashed)",
    ] {
        assert!(plot.contains(word), "{word}");
    }
    let text = words(&chapter);
    assert!(!text.contains("bound =") && !text.contains("÷\u{a0}floor"));
    // Negative control: were it right, its time would be in the plot.
    let mut right = mixed();
    right.cases[3].ended(Status::Ok, "");
    assert!(words(&section(&right, "countries-110m")).contains("4.65 × · 38.7 ms"));
}

#[test]
fn ratios_use_the_clock_of_the_device_and_name_it() {
    let mut run = mixed();
    for (case, ms) in [(0, 2.0), (1, 1.0), (2, 18.0), (3, 9.0)] {
        run.cases[case].timed("fill_gpu_ms", &[ms; 8]);
    }
    let on = |device_type: &str| {
        let mut run = run.clone();
        run.environment.device_type = device_type.to_owned();
        let chapter = section(&run, "countries-110m");
        let table = tables(&chapter).pop().expect("the table of the view");
        let cells = row_of(table, "vertex/doubled");
        let cells = [5, 2, 3].map(|column: usize| cells[column].text.as_str());
        (cells.join(" | "), words(&chapter))
    };
    let (cells, text) = on("discrete-gpu");
    assert_eq!(cells, "18.0 | 9.00 | 18.0");
    assert!(
        text.contains("GPU time of the fill ÷") && !text.contains("process CPU time of the fill ÷")
    );
    let (cells, text) = on("cpu");
    assert!(cells.contains("| 3.60 |"), "{cells}");
    assert!(text.contains("process CPU time of the fill ÷"));
}

#[test]
fn contradictions_are_named() {
    let contradictions = |change: &dyn Fn(&mut MadeUpCase)| {
        let mut run = mixed();
        change(&mut run.cases[2]);
        FillingChapter.contradictions(&written(&run).1)
    };
    assert_eq!(contradictions(&|_| ()), [""; 0]);
    let found = contradictions(&|case| {
        case.figure("mismatched_px_outside_band", 7.0);
    });
    assert!(
        found[0].contains("vertex/doubled: ok, though 7 pixels outside"),
        "{found:?}"
    );
    let found = contradictions(&|case| {
        case.figures
            .retain(|(metric, ..)| *metric != "mismatched_px_outside_band");
    });
    assert!(found[0].contains("never compared"), "{found:?}");
    let found = contradictions(&|case| {
        case.timed(TIME, &[0.0, 2.0, 3.0]);
    });
    assert!(found[0].contains("1 of 3 times are 0"), "{found:?}");
}

#[test]
fn summary_has_its_stable_columns_old_names_and_empty_cells() {
    let mut run = mixed();
    let again = run.cases[2].id.repeat();
    run.case(again).timed(TIME, &[1.0; 8]);
    let (_folder, run) = written(&run);
    let tables = FillingChapter.tables(&run).expect("a table");
    assert_eq!(tables[0].file, "summary.csv");
    let lines: Vec<&str> = tables[0].text.lines().collect();
    assert!(lines[0].starts_with(&format!("{STABLE_SUMMARY_HEADER},stencil_gpu_ms,")));
    assert!(lines[0].contains(",mask_hash,ids_hash,"));
    assert_eq!(lines.len(), 6, "neither the missing case nor the repeat");
    assert!(lines[1].starts_with("countries-110m,globe,bound,full-screen,ok,,,,10.75,"));
    assert!(lines[2].starts_with("countries-110m,globe,floor,full-screen,"));
    let doubled: Vec<&str> = lines[3].split(',').collect();
    assert_eq!(
        doubled[..6],
        ["countries-110m", "globe", "vertex", "doubled", "ok", ""]
    );
    // No surface time; fill by both clocks; the passes of its view; their ratio.
    assert_eq!(
        doubled[6..13],
        ["", "18", "38.7", "", "10.75", "3.2250000000000005", "3.6"]
    );
    let wrong: Vec<&str> = lines[4].split(',').collect();
    assert_eq!(
        (wrong[4], wrong[12]),
        ("wrong", ""),
        "a wrong frame is never fast"
    );
    assert!(lines[5].contains("\"doubled,walls=list\",skipped,no lists,,,,"));
    assert!(
        FillingChapter
            .tables(&Run {
                cases: Vec::new(),
                ..run
            })
            .expect("none")
            .is_empty()
    );
}

/// Names of a view's curves, each with labels of its points, and whether it is a vertical line.
fn curves(run: &MadeUpRun) -> Vec<(String, Vec<String>, bool)> {
    let (_folder, run) = written(run);
    let data = Data::new(&run);
    let curves = error_time::curves(&data, &data.views[0]).into_iter();
    let read = curves.map(|curve| {
        let mut points = curve.points.iter();
        let is_line = points.all(|point| point.standing == PointStanding::Exact);
        let labels = curve.points.into_iter().map(|point| point.label);
        (curve.name, labels.collect(), is_line)
    });
    read.collect()
}

/// A sweep whose points are planned in no order, a mask by its texels, a full plan by its levels, and fills without a
/// knob.
fn knobs() -> MadeUpRun {
    let mut run = on_cpu();
    for (key, role, ms, wrong_px) in [
        ("vertex/doubled", "main", 20.0, 4.0),
        (
            "vertex/doubled,boundary-tolerance-m=9000",
            "sweep",
            10.0,
            900.0,
        ),
        (
            "vertex/doubled,boundary-tolerance-m=1000",
            "sweep",
            15.0,
            30.0,
        ),
        (
            "compute/cached,boundary-lod-px=0.5",
            "main+full-plan",
            9.0,
            60.0,
        ),
        (
            "compute/cached,boundary-lod-px=off",
            "main+full-plan",
            12.0,
            4.0,
        ),
        ("vertex/pulled", "main", 25.0, 4.0),
        ("native/gs-line", "main", 30.0, 4.0),
    ] {
        timed(&mut run, &format!("s/v/{key}"), &[("role", role)], ms)
            .figure("mismatched_px", wrong_px);
    }
    run.cases[0].figure("boundary_tolerance_m", 50.0);
    run.cases[1].ended(Status::Wrong, "coarse");
    for (size, ms, wrong_px) in [("2048", 3.0, 500.0), ("1024", 2.0, 2_000.0)] {
        let key = format!("s/v/mask-texture/texture,size={size}");
        timed(
            &mut run,
            &key,
            &[("role", "main"), ("approximate", "yes")],
            ms,
        )
        .figure("mismatched_px", wrong_px)
        .ended(Status::Wrong, "approximate");
    }
    run
}

#[test]
fn a_method_is_a_curve_in_the_order_of_its_knob_and_an_exact_one_without_a_knob_a_line() {
    let mut run = knobs();
    let expected = [
        ("vertex/doubled", "50 m, 1 km, 9 km", false),
        ("compute/cached, full plan", "0 px, ≤ 0.5 px", false),
        ("native/gs-line", "", true),
        ("vertex/pulled", "", true),
        ("mask-texture/texture", "1024, 2048", false),
    ];
    let found = curves(&run);
    let found: Vec<(&str, String, bool)> = found
        .iter()
        .map(|(name, labels, is_line)| (name.as_str(), labels.join(", "), *is_line))
        .collect();
    let expected = expected.map(|(name, labels, is_line)| (name, labels.to_owned(), is_line));
    assert_eq!(found, expected);
    // Negative controls: a wrong fill is no line, nor a point of a curve that is no sweep; one that moves boundaries
    // on purpose is no line; another switch is no knob.
    run.cases[4].ended(Status::Wrong, "41 pixels");
    run.cases[5].ended(Status::Wrong, "41 pixels");
    run.cases[6].figure("boundary_moved_px", 0.4);
    timed(
        &mut run,
        "s/v/vertex/doubled,walls=list",
        &[("role", "main")],
        20.0,
    );
    let found = curves(&run);
    let of = |wanted: &str| {
        let found = found.iter().find(|(name, ..)| name == wanted);
        found.map(|(_, labels, is_line)| (labels.len(), *is_line))
    };
    assert_eq!(of("vertex/pulled"), None);
    assert_eq!(of("compute/cached, full plan"), Some((1, true)));
    assert_eq!(of("native/gs-line"), Some((1, false)));
    assert_eq!(of("vertex/doubled"), Some((3, false)));
    assert_eq!(of("vertex/doubled,walls=list"), Some((1, true)));
}

#[test]
fn the_first_page_has_the_plot_of_the_view_with_the_most_errors_or_the_command_for_one() {
    let page = |run: &MadeUpRun| {
        let found = answers(run).blocks;
        let titles = ["s, v", "s, other"].map(|view| format!("{view}: error against time"));
        let has = titles.map(|title| plots(&found).any(|svg| svg.contains(&title)));
        (has, words(&found))
    };
    let mut run = knobs();
    for (key, px) in [("off", 4.0), ("0.5", 70.0)] {
        let key = format!("s/other/compute/cached,boundary-lod-px={key}");
        timed(&mut run, &key, &[("role", "main+full-plan")], 9.0).figure("mismatched_px", px);
    }
    let command = "To measure some: terrafill bench --study filling --full";
    let (found, said) = page(&run);
    assert_eq!(found, [true, false]);
    assert!(!said.contains(command), "{said}");
    // Negative control: without a choice of errors there is no plot, and the command is named.
    for case in &mut run.cases {
        case.figure("mismatched_px", 4.0);
    }
    let (found, said) = page(&run);
    assert_eq!(found, [false, false]);
    assert!(said.contains(command), "{said}");
    assert!(!plots(&section(&run, "s")).any(|svg| svg.contains("error against time")));
}

#[test]
fn cases_are_named_by_technique_and_variant() {
    let (_folder, run) = written(&mixed());
    let names: Vec<String> = run.cases.iter().map(name).collect();
    assert_eq!(names[0], "depth-pass/full-screen");
    assert_eq!(names[4], "vertex/doubled,walls=list");
    let outcome = |case: &Case| case.outcome;
    assert_eq!(outcome(&run.cases[5]), Outcome::Missing);
}

/// Two fills of about the same time, and a slow one that is small and exact; the first one again.
fn best_of(again_ms: f64) -> MadeUpRun {
    let mut run = on_cpu();
    for (key, ms, bytes, wrong_px) in [
        ("vertex/doubled", 20.0, 4_000.0, 5.0),
        ("vertex/pulled", 20.4, 1_000.0, 5.0),
        ("native/gs-line", 40.0, 500.0, 0.0),
    ] {
        let role = [("role", "main")];
        timed(&mut run, &format!("s/globe/{key}"), &role, ms)
            .figure("geometry_bytes", bytes)
            .figure("mismatched_px", wrong_px)
            .figure("hausdorff_px", 1.0)
            .figure("regions_drawn", 134.0);
    }
    again(&mut run, 0, again_ms);
    run
}

pub(super) fn answers(run: &MadeUpRun) -> Answers {
    let (_folder, run) = written(run);
    FillingChapter.answers(&run).expect("answers")
}

#[test]
fn the_best_fills_of_a_view_are_those_of_its_rows() {
    let found = answers(&best_of(21.0));
    let matrix = tables(&found.blocks)[0];
    assert_eq!(
        texts(matrix, 0),
        [
            "s, globe",
            "vertex/pulled",
            "vertex/doubled",
            "vertex/pulled",
            "native/gs-line",
            "native/gs-line"
        ],
        "view, recommended, fastest, ties, smallest, most exact"
    );
    let recommended = &matrix.rows[0].cells[1];
    assert!(
        recommended
            .detail
            .contains("ms · 1.00 kB · boundary off ≤ 1.00 px, 5 pixels differ")
    );
    assert_eq!(
        recommended.command,
        "terrafill render s --view globe --technique vertex --set pulled --out picture.png"
    );
    // Negative controls: with quieter identical work nothing ties, and a wrong fill wins nothing.
    let quiet = answers(&best_of(20.0));
    assert_eq!(
        texts(tables(&quiet.blocks)[0], 0)[1..3],
        ["vertex/doubled", "none"],
        "the fastest is the recommended one in all rows"
    );
    let mut wrong = best_of(20.0);
    wrong.cases[0].ended(Status::Wrong, "41 pixels");
    let wrong = answers(&wrong);
    assert_eq!(texts(tables(&wrong.blocks)[0], 0)[1], "vertex/pulled");
}

#[test]
fn the_first_words_say_what_to_take_what_it_costs_and_how_sure_that_is() {
    let first = |run: &MadeUpRun| match &answers(run).blocks[..2] {
        [Block::Lead(lead), Block::List(lines)] => format!("{lead}\n{}", lines.join("\n")),
        other => panic!("{other:?}"),
    };
    let assert_says = |said: &str, parts: &[&str]| {
        for part in parts {
            assert!(said.contains(part), "{part:?} is not in {said}");
        }
    };
    let tied = first(&best_of(21.0));
    assert_says(
        &tied,
        &[
            "Take vertex/pulled: the fastest of its view, or tied. Of the fills that tie with it on average it has \
             the fewest bytes.",
            "at most 1.00 kB on the device in a view: geometry, constants, targets and textures; geometry alone at most 1.00 kB.",
            "Pictures are right: at most 5 pixels of one differ from the exact reference, each within a pixel of a \
             boundary.",
            "How sure: times to ± ",
            " % (8 processes).",
            "As fast on average: vertex/doubled.",
            "No GPU was measured",
            "To draw one of its pictures, with all its switches: terrafill render ",
        ],
    );
    // Where all tie, times decide nothing.
    let mut all = best_of(21.0);
    all.cases[2].timed(TIME, &PROCESSES.map(|factor| factor * 20.3));
    assert_says(
        &first(&all),
        &[
            "No fill is proven faster: on average the 3 that are right in every view differ by less than the same work \
             measured twice, which differed by up to ",
            "Take native/gs-line for the fewest bytes.",
            "Pictures are right: none differs from the exact reference in any pixel.",
        ],
    );
    // With quieter identical work the faster one is taken.
    let mut run = best_of(20.0);
    let said = first(&run);
    assert_says(
        &said,
        &[
            "Take vertex/doubled: the fastest of its view, or tied.\n",
            "Next best: vertex/pulled, 1.02 × its time on average.",
        ],
    );
    // Few processes are not sure, moved boundaries have a price, and a GPU is no software.
    run.environment.device_type = "discrete-gpu".to_owned();
    run.environment.gpu_timestamps = false;
    run.cases[0]
        .timed(TIME, &[20.0; 3])
        .figure("boundary_moved_px", 0.25);
    assert_says(
        &first(&run),
        &[
            "Levels of detail moved boundaries by up to 0.250 px on purpose.",
            "How sure: unknown. 3 processes ran, and an interval takes 5. The same work measured twice differed by up to ",
            "Without moved boundaries the fastest is vertex/pulled: ",
            " × the time and 0.250 × the bytes of geometry.",
        ],
    );
    assert!(!first(&run).contains("No GPU was measured"));
    // Control: no fill that is wrong anywhere is taken.
    for case in &mut run.cases[..3] {
        case.ended(Status::Wrong, "41 pixels");
    }
    let none = answers(&run).blocks;
    assert!(
        !none.iter().any(|block| matches!(block, Block::Lead(_))),
        "{none:?}"
    );
}

#[test]
fn a_terminal_has_the_best_fill_of_each_technique() {
    let lines = |run: &MadeUpRun| -> Vec<String> {
        let (_folder, run) = written(run);
        answer_text(&run).lines().map(str::to_owned).collect()
    };
    let found = lines(&best_of(21.0));
    let [head, view, best, other] = &found[..] else {
        panic!("{found:#?}");
    };
    assert!(
        head.starts_with("fill ") && head.ends_with(" ÷ best"),
        "{head}"
    );
    assert!(head.contains(" process CPU ms "), "{head}");
    assert_eq!(view, "s, globe");
    for (line, name, time, bytes, over) in [
        (best, "  vertex/doubled ", " 21.5 ± ", " 4.00 kB ", " 1.00"),
        (other, "  native/gs-line ", " 43.0 ± ", " 500 B ", " 2.00"),
    ] {
        assert!(line.starts_with(name) && line.ends_with(over), "{line}");
        assert!(line.contains(time) && line.contains(bytes), "{line}");
    }
    // What full plans are compared with stands behind them, and takes part in what is the best.
    let mut run = best_of(21.0);
    let is_doubled = |case: &MadeUpCase| case.id.name.ends_with("vertex/doubled");
    let control = run.cases.iter_mut().find(|case| is_doubled(case));
    let conditions = &mut control.expect("it is measured").id.conditions;
    conditions.insert("role".to_owned(), "layout".to_owned());
    let found = lines(&run);
    let firsts: Vec<&str> = found.iter().map(|line| line.trim_start()).collect();
    let [_, _, plan, _, title, behind] = &firsts[..] else {
        panic!("{found:#?}");
    };
    assert!(plan.starts_with("vertex/pulled ") && !plan.ends_with(" 1.00"));
    assert_eq!(*title, "s, globe, controls");
    assert!(behind.starts_with("vertex/doubled ") && behind.ends_with(" 1.00"));
    // Negative controls: a wrong fill is none, and nothing is said of a run without fills.
    let mut wrong = best_of(21.0);
    wrong.cases[0].ended(Status::Wrong, "41 pixels");
    assert!(lines(&wrong)[2].starts_with("  vertex/pulled "));
    assert_eq!(lines(&on_cpu()), [""; 0]);
}

#[test]
fn nothing_is_drawn_or_advised_below_the_fastest() {
    let mut run = best_of(20.0);
    // In most processes the second takes less than the first, and its median is longer.
    let times = [
        [10.0, 10.0, 11.0, 40.0, 40.0],
        [9.0, 12.0, 12.0, 39.0, 39.0],
        [50.0; 5],
    ];
    for (case, times) in run.cases.iter_mut().zip(times) {
        case.timed(TIME, &times);
    }
    run.cases[3].timed(TIME, &times[0]);
    // A coarse boundary takes less than all, and competes with none.
    timed(&mut run, "s/globe/vertex/coarse", &[("role", "sweep")], 1.0);
    let chapter = section(&run, "s");
    let drawn = plots(&chapter).find(|svg| svg.contains("fastest = 1"));
    let ratios: Vec<f64> = plotted(drawn.expect("a plot"))
        .skip(1)
        .map(|row| row.split(',').nth(2).and_then(|ratio| ratio.parse().ok()))
        .collect::<Option<_>>()
        .expect("ratios");
    assert_eq!(ratios.len(), 3, "{ratios:?}");
    assert!(ratios.iter().all(|ratio| *ratio >= 1.0), "{ratios:?}");
    let found = answers(&run);
    assert_eq!(texts(tables(&found.blocks)[0], 0)[1], "vertex/doubled");
    let said = words(&found.blocks);
    assert!(
        said.contains("Over all views → vertex/doubled: s, globe, 1.00 × the best of each"),
        "{said}"
    );
    // Control: the median of ratios by process, which stood there before, is below 1.
    let (_folder, read) = written(&run);
    let before = terrafill_results::ratio(&read.cases[1], &read.cases[0], TIME);
    assert!(before.is_some_and(|ratio| ratio.middle < 1.0), "{before:?}");
}

#[test]
fn full_plans_are_drawn_again_by_their_switches() {
    for (role, set) in [
        ("main+full-plan", "doubled,a=b,boundary-lod-px=0.5"),
        ("main+full-plan", "doubled,a=b"),
        ("main", "doubled,a=b"),
        // Negative control: a switch of an older program, which today's refuses.
        ("main", "doubled,cap-faces=front"),
    ] {
        let mut run = on_cpu();
        let key = format!("s/globe/vertex/{set}");
        timed(&mut run, &key, &[("role", role)], 20.0)
            .figure("geometry_bytes", 1_000.0)
            .figure("mismatched_px", 0.0);
        // By the name that the run was given: scenes in folders have no other.
        for (given, scene) in [("r", "s"), ("r+terrain/s", "terrain/s")] {
            run.environment.options = vec![format!("scenes={given}")];
            let found = answers(&run);
            let command = &tables(&found.blocks)[0].rows[0].cells[1].command;
            let expected = format!(
                "terrafill render {scene} --view globe --technique vertex --set {set} --out picture.png"
            );
            let is_gone = set.contains("cap-faces");
            assert_eq!(*command, if is_gone { "" } else { &expected });
        }
    }
}

#[test]
fn advice_follows_the_rows() {
    let advice = |run: &MadeUpRun| {
        let found = answers(run);
        let lists = found.blocks.into_iter().filter_map(|block| match block {
            Block::List(lines) => Some(lines.join("\n")),
            _ => None,
        });
        lists.collect::<String>()
    };
    let said = advice(&best_of(21.0));
    let many = "Many regions in view (from 50 on) → vertex/doubled: s, globe, 1.00 × the best of each \
                on average, 1.00 × at most; ties: vertex/pulled.";
    assert!(said.contains(many), "{said}");
    assert!(said.contains("Eye far, vertices are the limit"));
    assert!(!said.contains("Eye near"), "5 fragments a vertex");
    // Negative controls: other times, other advice; few regions give none about many.
    let mut other = best_of(21.0);
    other.cases[2].timed(TIME, &PROCESSES);
    other.cases[2].figure("regions_drawn", 3.0);
    let said = advice(&other);
    assert!(!said.contains("Many regions"), "{said}");
    assert!(said.contains("Over all views → native/gs-line: s, globe, 1.00 ×"));
}

#[test]
fn a_full_plan_competes_under_its_own_name() {
    let mut run = best_of(21.0);
    let variant = "s/globe/vertex/doubled,boundary-lod-px=0.5,scissor=volumes";
    timed(&mut run, variant, &[("role", "full-plan+ladder")], 2.0)
        .figure("geometry_bytes", 4_000.0)
        .figure("mismatched_px", 78.0)
        .figure("hausdorff_px", 1.0)
        .figure("boundary_moved_px", 0.25);
    let found = answers(&run);
    let cells = texts(tables(&found.blocks)[0], 0);
    let label = "vertex/doubled, full plan, moved ≤ 0.5 px";
    assert_eq!(cells[1], label);
    assert_eq!(cells[4], "native/gs-line", "a moved boundary is not exact");
    assert!(words(&section(&run, "s")).contains(label));
}

#[test]
fn scope_and_requirements_are_exact() {
    let mut run = best_of(21.0);
    let found = answers(&run);
    assert_eq!(
        found.scope,
        ["3 of 3 pictures compared with the reference."]
    );
    assert_eq!(found.requirements[0].standing, Standing::Holds);
    // Negative controls: a wrong picture, one that may be wrong, and one that was never compared.
    run.cases[1].figure("mismatched_px_outside_band", 9.0);
    let found = answers(&run);
    assert_eq!(found.requirements[0].standing, Standing::DoesNotHold);
    let because = "2 of 3 pictures have none. Not: filling/s/globe/vertex/pulled: 9";
    assert_eq!(found.requirements[0].because, because);
    run.cases[1].may_be_wrong = true;
    run.cases[2].missing().figures.clear();
    let found = answers(&run);
    let one = "2 of 3 pictures compared with the reference (1 of sweeps, whose error";
    assert!(found.scope[0].starts_with(one), "{}", found.scope[0]);
    assert_eq!(found.requirements[0].standing, Standing::Holds);
    assert_eq!(answers(&MadeUpRun::default()), Answers::default());
}

#[test]
fn every_wrong_case_is_pictured_with_its_worst_pixel() {
    let pictured = |status: Status| {
        let mut run = on_cpu();
        timed(
            &mut run,
            "s/globe/vertex/doubled",
            &[("role", "main")],
            10.0,
        )
        .note("reference_image", "images/reference.png")
        .note("image", "images/a.png");
        add(
            &mut run,
            "s/globe/vertex/doubled,faces=two-pass",
            &[("role", "ladder"), ("rung", "1")],
        )
        .figure("mismatched_px", 9.0)
        .figure("mismatched_px_outside_band", 3.0)
        .note("image", "images/b.png")
        .note("difference_image", "images/c.png")
        .note("worst_image", "images/d.png")
        .note("worst_px", "503, 451")
        .ended(status, "3 pixels outside the band");
        let scene = section(&run, "s");
        let pictures = scene.iter().find_map(|block| match block {
            Block::Pictures(pictures) => Some(pictures.clone()),
            _ => None,
        });
        pictures.expect("pictures").figures
    };
    let wrong = pictured(Status::Wrong);
    let last = wrong.last().expect("a figure");
    let captions: Vec<&str> = last.pictures.iter().map(|p| p.caption.as_str()).collect();
    assert_eq!(
        captions,
        ["picture", "difference", "worst pixel (503, 451)"]
    );
    assert!(last.notes[0].contains("(wrong): 9 px differ, 3 of them outside the band"));
    // Negative control: a right step has no picture beside those of its scene.
    assert_eq!(pictured(Status::Ok).len(), wrong.len() - 1);
}

#[test]
fn an_approximate_fill_is_shown_as_such_and_wins_nothing() {
    let made = |more: &[(&str, &str)]| {
        let mut run = on_cpu();
        for (name, ms) in [("vertex/doubled", 20.0), ("compute/input", 30.0)] {
            timed(
                &mut run,
                &format!("s/globe/{name}"),
                &[("role", "main")],
                ms,
            );
        }
        let conditions: Vec<(&str, &str)> = std::iter::once(&("role", "main"))
            .chain(more)
            .copied()
            .collect();
        for (size, ms) in [("1024", 2.0), ("2048", 3.0)] {
            let key = format!("s/globe/mask-texture/texture,size={size}");
            let case = timed(&mut run, &key, &conditions, ms);
            case.figure("hausdorff_px", 7.0);
            if !more.is_empty() {
                case.ended(Status::Wrong, "approximate: 9 mismatched pixels");
                case.may_be_wrong = true;
            }
        }
        run
    };
    let title = "Volumes against approximate fills";
    let best = |run: &MadeUpRun| answered(run, "recommended");
    let run = made(&[("approximate", "yes")]);
    assert_eq!(best(&run), "vertex/doubled");
    let within = "mask-texture/texture,size=1024: within the tolerances in 0 of 1 views";
    assert!(words(&section(&run, title)).contains(within));
    let own = section(&run, "s");
    let rows = &tables(&own)[0].rows;
    let shown: Vec<[&str; 3]> = rows
        .iter()
        .map(|row| {
            let ratio = row.cells[1].text.split(' ').next().unwrap_or_default();
            [&row.cells[0].text, &row.cells[4].text, ratio]
        })
        .collect();
    let mask = ["1024", "2048"].map(|size| format!("mask-texture/texture,size={size}"));
    assert_eq!(
        shown,
        [
            ["vertex/doubled", "ok", "1.00"],
            ["compute/input", "ok", "1.50"],
            [&mask[0], "approximate", "0.100"],
            [&mask[1], "approximate", "0.150"],
        ]
    );
    assert_eq!(rows[2].cells[0].detail, "1024");
    assert!(answers(&run).scope[0].contains("2 approximate by nature"));
    // Negative control: what does not say so competes, and has no such section.
    let run = made(&[]);
    assert_eq!(best(&run), "mask-texture/texture,size=1024");
    assert!(section(&run, title).is_empty());
}
