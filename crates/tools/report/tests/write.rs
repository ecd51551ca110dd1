// SPDX-License-Identifier: MIT OR Apache-2.0
//! The report of a made-up run, read as a reader would: what it must say, and what it must not. Each
//! rule has a control in which something is wrong and must be seen.

use std::fs;
use std::path::Path;
use terrafill_report::{ReportError, TermGroup, Verdict, WrittenReport, write, write_single_file};
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{
    Answers, Block, CaseId, Cell, CellClass, Chapter, ChapterError, Clock, DerivedTable, Finding,
    Heading, Kind, Metric, Outcome, Picture, PictureFigure, Pictures, Plot, Row, Run,
    RunEnvironment, Skipped, Standing, Status, Table,
};

const TIME: &str = "fill_cpu_ms";

const METRICS: [Metric; 1] = [Metric::less(
    TIME,
    "ms",
    Kind::Time,
    "Process CPU time of the <fill>.",
)];

/// Words of the made-up run's names, and one that stands nowhere.
fn terms() -> Vec<TermGroup> {
    vec![(
        "Fills",
        vec![("asked", "what was <wanted>"), ("nowhere", "in no report")],
    )]
}

/// A table of all cases with their times, a finding, and the cases' pictures.
struct TimesChapter;

impl Chapter for TimesChapter {
    fn study(&self) -> &'static str {
        "filling"
    }

    fn title(&self) -> &'static str {
        "Times"
    }

    fn question(&self) -> &'static str {
        "Which is fastest?"
    }

    fn primary_metric(&self, _clock: Clock) -> Option<&'static str> {
        Some(TIME)
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let row = |case: &terrafill_results::Case| {
            let time = case.value(TIME).map(|ms| ms.to_string());
            let mut cell = Cell::or_absent(time, &case.reason);
            if case.outcome == Outcome::Wrong {
                cell.class = CellClass::Void;
                cell.title = "the picture is wrong".to_owned();
            }
            Row {
                cells: vec![
                    Cell::name(&case.id().name),
                    Cell::plain(case.outcome.name()),
                    cell,
                    Cell::name("as asked"),
                ],
                status: case.outcome.name().to_owned(),
                remark: case.reason.clone(),
            }
        };
        let figure = |case: &terrafill_results::Case| PictureFigure {
            pictures: vec![Picture {
                path: case.note("image").to_owned(),
                caption: "picture".to_owned(),
            }],
            notes: vec![case.id().name.clone()],
        };
        let shown = run
            .cases
            .iter()
            .filter(|case| !case.note("image").is_empty());
        let first = shown.clone().next();
        Ok(vec![
            Block::section("Every case"),
            Block::Plot(Plot {
                caption: "A plot.".to_owned(),
                svg: "<svg stroke=\"currentColor\"><metadata>name,&lt;ms>\na,1\n</metadata></svg>"
                    .to_owned(),
            }),
            Block::Table(Table {
                headings: vec![
                    Heading::plain("case"),
                    Heading::plain("status"),
                    Heading::metric("ms", TIME),
                    Heading::plain("why"),
                ],
                rows: run.cases.iter().map(row).collect(),
                is_main: true,
                ..Table::default()
            }),
            Block::Finding(Finding {
                claim: "It is fast.".to_owned(),
                standing: Standing::DoesNotHold,
                because: "2.00 ×".to_owned(),
            }),
            Block::Pictures(Pictures {
                reference: first.map_or_else(String::new, |case| case.note("image").to_owned()),
                figures: shown.map(figure).collect(),
                ..Pictures::default()
            }),
        ])
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let right = run.count(Outcome::Ok);
        Ok(Answers {
            scope: vec![format!("{right} of {} compared", run.cases.len())],
            blocks: vec![Block::Text("By another clock.".to_owned())],
            requirements: vec![Finding {
                claim: "All are right.".to_owned(),
                standing: Standing::holds_if(right == run.cases.len()),
                because: String::new(),
            }],
        })
    }

    fn tables(&self, run: &Run) -> Result<Vec<DerivedTable>, ChapterError> {
        Ok(vec![DerivedTable {
            file: "summary.csv".to_owned(),
            text: format!("cases\n{}\n", run.cases.len()),
        }])
    }
}

fn id(name: &str) -> CaseId {
    case_id("filling", name, &[])
}

fn run() -> MadeUpRun {
    MadeUpRun {
        environment: RunEnvironment {
            gpu: "llvmpipe".to_owned(),
            device_type: "cpu".to_owned(),
            ..RunEnvironment::default()
        },
        metrics: METRICS.to_vec(),
        ..MadeUpRun::default()
    }
}

/// One case of each outcome.
fn mixed_run() -> MadeUpRun {
    let mut run = run();
    run.case(id("vertex/doubled")).timed(TIME, &[36.5]);
    run.case(id("vertex/pulled"))
        .timed(TIME, &[7.75])
        .ended(Status::Wrong, "41 pixels outside the boundary band");
    run.case(id("vertex/walls=list"))
        .ended(Status::Skipped, "adapter lacks <lists> & \"quotes\"");
    run.case(id("native/gs-line"))
        .ended(Status::Failed, "the device was lost");
    run.case(id("native/gs-adjacency")).missing();
    run
}

struct Report {
    written: WrittenReport,
    /// The first page.
    index: String,
    /// All pages.
    html: String,
    markdown: String,
    result: serde_json::Value,
}

fn report_in(folder: &Path) -> Report {
    let written = write(folder, &[&TimesChapter], terms()).expect("a report");
    let read = |file: &str| fs::read_to_string(folder.join(file)).expect("the file");
    let index = read("index.html");
    let pages = files(&folder.join("pages"));
    let pages = pages.iter().filter(|file| file.ends_with(".html"));
    Report {
        html: pages.fold(index.clone(), |all, file| {
            all + &read(&format!("pages/{file}"))
        }),
        index,
        markdown: read("summary.md"),
        result: serde_json::from_str(&read("result.json")).expect("JSON"),
        written,
    }
}

/// Names of files in a folder and the folders in it, sorted; none where there is no folder.
fn files(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy();
        if path.is_dir() {
            let inner = files(&path).into_iter();
            names.extend(inner.map(|inner| format!("{name}/{inner}")));
        } else {
            names.push(name.into_owned());
        }
    }
    names.sort();
    names
}

fn report(run: &MadeUpRun) -> Report {
    let folder = tempfile::tempdir().expect("a folder");
    run.write(folder.path()).expect("a run");
    report_in(folder.path())
}

/// The page without the marks for line breaks in names.
fn without_breaks(html: &str) -> String {
    html.replace("<span>", "").replace("</span><wbr>", "")
}

fn row_of(html: &str, name: &str) -> String {
    let plain = without_breaks(html);
    let start = plain
        .find(&format!("<th scope=\"row\">{name}</th>"))
        .expect("the row");
    plain[start..start + plain[start..].find("</tr>").expect("its end")].to_owned()
}

#[test]
fn every_case_is_counted_and_what_is_missing_or_wrong_is_named() {
    let found = report(&mixed_run());
    let counts = found.written.counts;
    let all = [counts.ok, counts.wrong, counts.skipped, counts.failed];
    assert_eq!((all, counts.missing), ([1; 4], 1));
    assert_eq!(found.written.missing, ["filling/native/gs-adjacency"]);
    assert_eq!(found.written.verdict, Verdict::Bad);
    let sentence = "5 cases: 1 right, 1 wrong, 1 skipped, 1 failed, 1 missing.";
    assert!(found.html.contains(sentence) && found.markdown.contains(sentence));
    assert!(found.html.contains("verdict bad"));
    assert!(found.html.contains("<li>filling/native/gs-adjacency</li>"));
    assert!(
        found
            .markdown
            .contains("- filling/native/gs-line: failed: the device was lost")
    );
    assert_eq!(found.result["exit_code"], 1);
    assert_eq!(found.result["missing"][0], "filling/native/gs-adjacency");
    assert_eq!(found.result["counts"]["failed"], 1);
    // Negative control: a run of the right case alone is good.
    let mut good = mixed_run();
    good.cases.truncate(1);
    let good = report(&good);
    assert_eq!(good.written.verdict, Verdict::Good);
    assert_eq!(good.result["exit_code"], 0);
    assert!(good.html.contains("verdict good") && !good.html.contains("Missing cases"));
}

#[test]
fn a_wrong_case_is_shown_as_wrong_and_its_time_counts_for_nothing() {
    let html = report(&mixed_run()).html;
    let wrong = row_of(&html, "vertex/pulled");
    assert!(wrong.contains("<td class=\"status\">wrong</td>"), "{wrong}");
    assert!(wrong.contains("<s>7.75</s><sup>1</sup>"), "{wrong}");
    assert!(html.contains("<li>the picture is wrong</li>"), "footnote");
    let right = row_of(&html, "vertex/doubled");
    assert!(!right.contains("<s>") && right.contains("36.5"), "{right}");
}

#[test]
fn a_wrong_answer_that_is_the_question_does_not_spoil_the_verdict() {
    let mut run = mixed_run();
    run.cases.truncate(2);
    assert_eq!(report(&run).written.verdict, Verdict::Bad);
    run.cases[1].may_be_wrong = true;
    let found = report(&run);
    assert_eq!(found.written.verdict, Verdict::Good);
    let sentence = "2 cases: 1 right, 0 wrong, 0 skipped, 0 failed, 0 missing; 1 more may be wrong, as \
                    their error is measured (wrong: 1).";
    assert!(found.html.contains(sentence), "{}", found.html);
    run.cases[0].may_be_wrong = true;
    let sentence = "2 cases: 0 right, 0 wrong, 0 skipped, 0 failed, 0 missing; 2 more may be wrong, as \
                    their error is measured (wrong: 1).";
    assert!(report(&run).html.contains(sentence));
}

#[test]
fn a_known_driver_fault_is_counted_apart_and_neither_right_nor_a_defect() {
    let mut run = mixed_run();
    run.cases.truncate(1);
    run.case(id("compute/cached"))
        .ended(Status::DriverFault, "1 px lost");
    let found = report(&run);
    let counts = found.written.counts;
    assert_eq!((counts.ok, counts.wrong, counts.driver_fault), (1, 0, 1));
    assert_eq!(found.written.verdict, Verdict::Good);
    let sentence = "0 missing; 1 differ by a known driver fault.";
    assert!(found.html.contains(sentence) && found.markdown.contains(sentence));
    let line = "- filling/compute/cached: driver-fault: 1 px lost";
    assert!(found.markdown.contains(line));
    let row = row_of(&found.html, "compute/cached");
    assert!(
        row.contains("<td class=\"status\">driver-fault</td>"),
        "{row}"
    );
    // Negative controls: by itself it makes no good run, and a wrong case is a bad one.
    run.cases.remove(0);
    assert_eq!(report(&run).written.verdict, Verdict::Nothing);
    run.cases[0].row = Some((Status::Wrong, "2 px".to_owned()));
    assert_eq!(report(&run).written.verdict, Verdict::Bad);
}

/// Words begin at the left of their column, and so does what is over them.
#[test]
fn a_heading_over_words_begins_where_they_do_and_one_over_figures_ends_where_they_do() {
    let html = report(&mixed_run()).html;
    assert!(html.contains("<th scope=\"col\" class=\"name\">why</th>"));
    assert!(html.contains("<th scope=\"col\">status</th>"));
}

#[test]
fn what_was_not_measured_is_a_dash_with_a_reason() {
    let html = report(&mixed_run()).html;
    let failed = row_of(&html, "native/gs-line");
    let dash = "<td class=\"absent\" title=\"the device was lost\">–<sup>";
    assert!(failed.contains(dash), "{failed}");
    assert!(html.contains("<li>the device was lost</li>"), "for print");
    // Negative control: a measured zero is a zero.
    let mut zero = run();
    zero.case(id("a")).timed(TIME, &[0.0]);
    assert!(row_of(&report(&zero).html, "a").contains("<td>0</td>"));
}

#[test]
fn text_from_the_run_cannot_become_markup() {
    let mut run = mixed_run();
    run.case(id("<img src=x>")).timed(TIME, &[1.0]);
    run.skipped.push(Skipped {
        what: "<b>moon</b>".to_owned(),
        reason: "its data is missing".to_owned(),
    });
    let found = report(&run);
    for markup in ["<lists>", "<img src=x>", "<b>moon", "<fill>"] {
        assert!(!found.html.contains(markup), "{markup}");
    }
    assert!(
        found
            .html
            .contains("&#60;lists&#62; &#38; &#34;quotes&#34;")
    );
    assert!(
        found
            .html
            .contains("title=\"Process CPU time of the &#60;fill&#62;.\"")
    );
    assert!(found.markdown.contains("\\<img src=x\\>"));
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
        .filter(|address| !address.starts_with('#') && !address.starts_with("data:"))
        .collect()
}

fn picture(folder: &Path, name: &str, grey: u8) {
    image::RgbImage::from_pixel(8, 8, image::Rgb([grey; 3]))
        .save(folder.join("images").join(name))
        .expect("a picture");
}

#[test]
fn pictures_are_carried_along_the_same_ones_once_and_broken_ones_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut run = run();
    for (name, image) in [
        ("a", "a.png"),
        ("b", "b.png"),
        ("c", "gone.png"),
        ("d", "torn.png"),
    ] {
        run.case(id(name)).note("image", &format!("images/{image}"));
    }
    run.write(folder.path()).expect("a run");
    picture(folder.path(), "a.png", 9);
    picture(folder.path(), "b.png", 9);
    fs::write(folder.path().join("images/torn.png"), "P").expect("writable");
    let single = |folder: &Path| {
        write_single_file(folder, &[&TimesChapter], terms()).expect("a report");
        fs::read_to_string(folder.join("index.html")).expect("the file")
    };
    report_in(folder.path());
    let html = single(folder.path());
    assert_eq!(loads(&html), [""; 0]);
    assert!(
        !folder.path().join("pages").exists(),
        "of the report before"
    );
    assert!(html.contains("data:image/png;base64,"));
    assert!(!html.contains("<link"));
    // What a sliding edge compares with, and the figures of plots, are in the file too.
    assert!(html.contains("data-reference=\"#first\""));
    assert!(html.contains("href=\"data:text/csv;base64,"));
    assert!(html.contains("download=\"report-figure.csv\""));
    let pages = report_in(folder.path()).html;
    assert!(pages.contains("data-reference=\"../images/a.png\""));
    for report in [&html, &report_in(folder.path()).html] {
        assert!(report.contains("the same for 2 cases"));
        assert!(report.contains("Pictures that could not be shown: images/torn.png"));
        assert!(!report.contains("gone.png"));
    }
    // Which are not there is said once, with what draws them.
    let left_out =
        "1 picture left out of this folder. To draw them anew: terrafill bench --study filling<";
    for front in [&html, &report_in(folder.path()).index] {
        assert_eq!(front.matches(left_out).count(), 1);
    }
    picture(folder.path(), "gone.png", 7);
    assert!(
        !report_in(folder.path())
            .index
            .contains("left out of this folder")
    );
    // Negative controls: another picture is not the same, and the check for addresses sees one.
    picture(folder.path(), "b.png", 8);
    assert!(!report_in(folder.path()).html.contains("the same for"));
    assert_eq!(loads("<img src=\"images/a.png\">"), ["images/a.png"]);
    assert_eq!(loads("a { b: url(https://c.d) }"), ["https://c.d"]);
}

#[test]
fn noise_clock_and_replicates_are_said() {
    let timed = |repeat: &[f64]| {
        let mut run = run();
        run.case(id("a")).timed(TIME, &[10.0, 11.0]);
        run.case(id("a").repeat()).timed(TIME, repeat);
        report(&run)
    };
    let noisy = timed(&[12.0, 13.2]);
    let sentence = "In filling, identical work differed by up to 20.0 % (fill_cpu_ms, 1 pair, median \
                    20.0 %) within a process, and by up to 10.0 % between processes (median \
                    10.0 %); smaller gaps are ties.";
    assert!(noisy.html.contains(sentence), "{}", noisy.markdown);
    assert!(
        noisy
            .html
            .contains("use process CPU time: the device is the CPU.")
    );
    assert!(
        noisy
            .html
            .contains("2 processes, each one replicate: fewer than 5 give no interval.")
    );
    assert!(
        noisy.html.contains("1 case: 1 right"),
        "repeats are not counted"
    );
    let factor = noisy.result["noise"][0]["max_factor"].as_f64();
    assert!((factor.expect("a factor") - 1.2).abs() < 1e-12);
    // Negative controls: no noise, and none that is known.
    assert!(timed(&[10.0, 11.0]).html.contains("by up to 0 %"));
    let mut alone = run();
    alone.case(id("a")).timed(TIME, &[10.0]);
    let alone = report(&alone);
    assert!(alone.html.contains("no identical work was measured twice"));
    assert!(alone.result["noise"][0]["max_factor"].is_null());
}

#[test]
fn findings_and_main_tables_are_in_both_files_and_derived_tables_beside_them() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run().write(folder.path()).expect("a run");
    let found = report_in(folder.path());
    assert!(
        found
            .html
            .contains("It is fast. 2.00 ×: <b class=\"does-not\">does not hold</b>")
    );
    assert!(
        found
            .markdown
            .contains("- It is fast. 2.00 ×: **does not hold**")
    );
    assert!(
        found
            .markdown
            .contains("| vertex/pulled | wrong | ~~7.75~~ |")
    );
    let table = fs::read_to_string(folder.path().join("summary.csv")).expect("the table");
    assert_eq!(table, "cases\n5\n");
    assert!(!folder.path().join("summary.csv.new").exists());
}

#[test]
fn a_missing_table_and_a_wrong_cell_are_refused_with_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run().write(folder.path()).expect("a run");
    let cases = folder.path().join("cases.csv");
    let text = fs::read_to_string(&cases).expect("the file");
    fs::write(&cases, text.replace(",skipped,", ",maybe,")).expect("writable");
    let refused = || {
        write(folder.path(), &[&TimesChapter], terms())
            .expect_err("refused")
            .to_string()
    };
    let message = refused();
    assert!(
        message.contains("cases.csv, row 4, column status"),
        "{message}"
    );
    assert!(message.contains("maybe"), "{message}");
    fs::write(&cases, text).expect("writable");
    let measurements = folder.path().join("measurements.csv");
    let text = fs::read_to_string(&measurements).expect("the file");
    fs::write(&measurements, text.replace("36.5", "fast")).expect("writable");
    assert!(refused().contains("measurements.csv, row 2, column value"));
    fs::remove_file(&measurements).expect("there");
    assert!(refused().contains("measurements.csv: found no such file"));
    assert!(!folder.path().join("index.html").exists());
    let empty = tempfile::tempdir().expect("a folder");
    let error = write(empty.path(), &[], terms()).expect_err("no run");
    assert!(
        matches!(error, ReportError::Chapter(ChapterError::Run(_))),
        "{error}"
    );
}

#[test]
fn the_same_run_gives_the_same_report() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run().write(folder.path()).expect("a run");
    assert_eq!(report_in(folder.path()).html, report_in(folder.path()).html);
}

#[test]
fn pages_refer_to_files_that_are_there_and_to_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut run = mixed_run();
    run.case(id("a")).note("image", "images/a,b=1 #.png");
    run.write(folder.path()).expect("a run");
    picture(folder.path(), "a,b=1 #.png", 9);
    report_in(folder.path());
    let pages = files(&folder.path().join("pages"));
    let pages = pages.iter().filter(|file| file.ends_with(".html"));
    let pages: Vec<String> = pages.map(|file| format!("pages/{file}")).collect();
    assert_eq!(pages, ["pages/filling.html", "pages/glossary.html"]);
    let mut found = 0;
    for page in std::iter::once(&"index.html".to_owned()).chain(&pages) {
        let path = folder.path().join(page);
        let html = fs::read_to_string(&path).expect("the page");
        for address in loads(&html) {
            assert!(!address.contains(':'), "{page}: {address}");
            let file = address.split('#').next().expect("a file");
            let file = file.replace("%20", " ").replace("%23", "#");
            let beside = path.parent().expect("its folder").join(&file);
            assert!(beside.is_file(), "{page}: {address}");
            found += 1;
        }
    }
    assert!(found > 12, "{found}");
}

#[test]
fn the_first_page_answers_and_what_is_required_is_met_or_not() {
    let line = |html: &str| {
        let list = html
            .split_once("<ul class=\"checklist\">")
            .expect("a list")
            .1;
        let (list, _) = list.split_once("</ul>").expect("its end");
        list.trim().to_owned()
    };
    let found = report(&mixed_run());
    assert!(found.index.contains("<dd>1 of 5 compared</dd>"));
    assert!(
        found
            .index
            .contains("llvmpipe (software: it runs on the CPU)")
    );
    let not_met = line(&found.index);
    assert!(not_met.starts_with("<li class=\"bad\">") && not_met.contains("All are right"));
    assert!(found.index.contains(
        "Requirements</a>: 1 not met.<br><span class=\"detail\">not met: All are right</span>"
    ));
    assert!(
        found
            .markdown
            .contains("- All are right: **does not hold**")
    );
    assert!(found.index.contains("By another clock."));
    // What fills pages is not on the first one.
    assert!(!found.index.contains("A plot.") && found.html.contains("A plot."));
    // Negative control: a run of the right case alone meets it.
    let mut good = mixed_run();
    good.cases.truncate(1);
    let good = report(&good);
    let met = line(&good.index);
    assert!(met.starts_with("<li class=\"good\">") && met.contains("All are right"));
}

#[test]
fn plots_are_files_too_with_their_figures_and_older_ones_are_removed() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run().write(folder.path()).expect("a run");
    let old = folder.path().join("pages/figures");
    fs::create_dir_all(&old).expect("a folder");
    fs::write(old.join("old.svg"), "").expect("writable");
    let html = report_in(folder.path()).html;
    assert_eq!(files(&old), ["filling-figure.csv", "filling-figure.svg"]);
    let read = |file: &str| fs::read_to_string(old.join(file)).expect("the file");
    assert_eq!(read("filling-figure.csv"), "name,<ms>\na,1\n");
    let svg = read("filling-figure.svg");
    assert!(
        svg.contains("xmlns=") && !svg.contains("currentColor"),
        "{svg}"
    );
    assert!(
        html.contains("<svg stroke=\"currentColor\"></svg>"),
        "no figures in the page"
    );
}

#[test]
fn many_names_have_a_page_of_their_own() {
    let mut run = run();
    for index in 0..40 {
        run.case(id(&format!("case-{index}"))).missing();
    }
    let found = report(&run);
    assert!(!found.index.contains("<li>filling/case-7</li>"));
    assert!(found.html.contains("<li>filling/case-7</li>"));
    assert!(
        found
            .index
            .contains("40 missing cases: <a href=\"pages/cases.html\">")
    );
    // Negative control: a few stay.
    run.cases.truncate(9);
    assert!(report(&run).index.contains("<li>filling/case-7</li>"));
}

#[test]
fn a_single_file_folds_chapters_and_sections_below_the_open_answers() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run().write(folder.path()).expect("a run");
    let single = |chapters: &[&dyn Chapter]| {
        write_single_file(folder.path(), chapters, terms()).expect("a report");
        fs::read_to_string(folder.path().join("index.html")).expect("the file")
    };
    let html = single(&[&TimesChapter, &TimesChapter]);
    let folded = html.find("<details class=\"part\">").expect("a chapter");
    let of = |text: &str| html.find(text).expect(text);
    // The question and the answer are open; the chapter and its section, in it, are not.
    assert!(of("<p class=\"question\">Which is fastest?</p>") < folded);
    assert!(of("By another clock.") < folded && folded < of("A plot."));
    let section =
        "<details class=\"part\"><summary><h3 id=\"Every-case\">Every case</h3></summary>";
    assert!(folded < of(section) && of(section) < of("A plot."));
    assert_eq!(
        html.matches("<details").count(),
        html.matches("</details>").count()
    );
    // A chapter alone is open, and pages of their own fold nothing.
    assert!(single(&[&TimesChapter]).contains("<details class=\"part\" open><summary><h2"));
    let pages = report_in(folder.path()).html;
    assert!(!pages.contains("class=\"part\""));
    assert!(pages.contains("<p class=\"question\">Which is fastest?</p>"));
}

#[test]
fn each_word_of_a_page_is_explained_on_it_once() {
    let folder = tempfile::tempdir().expect("a folder");
    mixed_run().write(folder.path()).expect("a run");
    report_in(folder.path());
    let page = |file: &str| fs::read_to_string(folder.path().join(file)).expect("a page");
    let entry = "<dt><code>asked</code></dt><dd>what was &#60;wanted&#62;</dd>";
    let pages = ["pages/filling.html", "pages/glossary.html"].map(page);
    write_single_file(folder.path(), &[&TimesChapter], terms()).expect("a report");
    for html in pages.into_iter().chain([page("index.html")]) {
        assert_eq!(html.matches(entry).count(), 1);
        // Negative control: a word that stands nowhere.
        assert!(!html.contains("nowhere"));
    }
}
