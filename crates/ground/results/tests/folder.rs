// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is written can be read, and a folder that was tampered with is refused with the place.

use std::path::Path;
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{
    CaseId, Kind, Measurement, Metric, Note, Outcome, PlannedCase, Primary, Run, RunEnvironment,
    RunError, RunFolder, RunPlan, SCHEMA, Scope, Status,
};

const METRICS: [Metric; 2] = [
    Metric::less(
        "fill_cpu_ms",
        "ms",
        Kind::Time,
        "What a fill costs, and \"quotes\".",
    ),
    Metric::neither("draws", "", Kind::Counter, "Draw calls."),
];

fn case(name: &str, samples: u32) -> PlannedCase {
    PlannedCase {
        id: CaseId::new(
            "filling",
            name,
            [
                ("scene", "moon".to_owned()),
                ("colour", "xor".to_owned()),
                ("view", "globe".to_owned()),
            ],
        ),
        samples,
        may_be_wrong: false,
    }
}

fn plan() -> RunPlan {
    RunPlan {
        cases: vec![case("a", 2), case("b", 0), case("c", 1)],
        processes: 1,
        ..RunPlan::default()
    }
}

fn environment() -> RunEnvironment {
    RunEnvironment {
        schema: SCHEMA,
        commit: "abc".to_owned(),
        ..RunEnvironment::default()
    }
}

fn time(case: &str, sample: u32, value: f64) -> Measurement {
    Measurement {
        case: case.to_owned(),
        metric: "fill_cpu_ms".to_owned(),
        process: 0,
        sample,
        value,
    }
}

/// Two cases verified, one of them timed; the third never reached.
fn written(path: &Path) -> RunFolder {
    let folder = RunFolder::create(path, environment(), plan(), &METRICS).expect("new");
    folder
        .append_measurements(&[Measurement {
            metric: "draws".to_owned(),
            ..time("filling/a", 0, 7.0)
        }])
        .expect("written");
    folder
        .append_case(&plan().cases[0], Status::Ok, "")
        .expect("written");
    folder
        .append_case(&plan().cases[1], Status::Wrong, "two lines\nof \"reasons\"")
        .expect("written");
    folder
        .append_notes(&[Note {
            case: "filling/a".to_owned(),
            note: "image".to_owned(),
            text: "images/a, b.png".to_owned(),
        }])
        .expect("written");
    folder
        .append_measurements(&[time("filling/a", 1, 3.0), time("filling/a", 2, f64::NAN)])
        .expect("written");
    folder
}

#[test]
fn what_is_written_is_read() {
    let place = tempfile::tempdir().expect("a folder");
    written(place.path());
    let run = Run::load(place.path()).expect("a run");
    let [a, b, c] = run.cases.as_slice() else {
        panic!("three cases");
    };
    assert_eq!((a.outcome, b.outcome), (Outcome::Ok, Outcome::Wrong));
    assert_eq!(b.reason, "two lines\nof \"reasons\"");
    assert_eq!(c.outcome, Outcome::Missing);
    assert_eq!(a.value("draws"), Some(7.0));
    assert_eq!(a.value("fill_gpu_ms"), None);
    assert_eq!(a.note("image"), "images/a, b.png");
    assert_eq!(a.condition("colour"), "xor");
    let times = &a.samples("fill_cpu_ms").expect("timed")[&0];
    assert!(times[&2].is_nan(), "what is no number stays none");
    assert_eq!(run.metrics[0].meaning, METRICS[0].meaning);
    let header = std::fs::read_to_string(place.path().join("cases.csv")).expect("a table");
    assert!(
        header.starts_with("case,study,status,reason,timed,commit,scene,view,colour\n"),
        "{header}"
    );
}

/// Keys and statuses of `cases.csv`, in its order.
fn case_rows(folder: &Path) -> Vec<[String; 2]> {
    let mut reader = csv::Reader::from_path(folder.join("cases.csv")).expect("a table");
    let rows = reader.records().map(|row| row.expect("a row"));
    rows.map(|row| [0, 2].map(|column| row[column].to_owned()))
        .collect()
}

#[test]
fn a_case_that_fails_after_it_was_verified_keeps_one_row() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = written(place.path());
    folder.fail_case(&plan().cases[0], "lost").expect("written");
    let rows = [["filling/b", "wrong"], ["filling/a", "failed"]];
    assert_eq!(case_rows(place.path()), rows);
    let run = Run::load(place.path()).expect("a run");
    assert_eq!(run.cases[0].outcome, Outcome::Failed);
    assert_eq!(run.cases[0].reason, "lost");
    assert_eq!(run.cases[1].reason, "two lines\nof \"reasons\"");
    // What a kill between writing and renaming leaves disturbs nothing.
    std::fs::write(place.path().join("cases.csv.new"), "case,stu").expect("written");
    let folder = RunFolder::resume(place.path(), &environment(), &plan()).expect("there");
    assert_eq!(case_rows(place.path()), rows);
    folder.fail_case(&plan().cases[1], "lost").expect("written");
    folder
        .append_case(&plan().cases[2], Status::Ok, "")
        .expect("written");
    assert_eq!(
        case_rows(place.path()),
        [
            ["filling/a", "failed"],
            ["filling/b", "failed"],
            ["filling/c", "ok"]
        ]
    );
    // Negative control: a second row of a case is refused.
    folder
        .append_case(&plan().cases[2], Status::Ok, "")
        .expect("written");
    let message = Run::load(place.path()).expect_err("two rows").to_string();
    let expected = "row 5, column case: found \"filling/c\", expected one row a case";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn a_torn_last_row_is_let_pass_and_cut_when_the_run_goes_on() {
    let place = tempfile::tempdir().expect("a folder");
    written(place.path());
    let table = place.path().join("measurements.csv");
    let whole = std::fs::read_to_string(&table).expect("a table");
    std::fs::write(&table, format!("{whole}filling/c,fill_c")).expect("written");
    let run = Run::load(place.path()).expect("a run");
    assert_eq!(run.cases[2].outcome, Outcome::Missing);
    RunFolder::resume(place.path(), &environment(), &plan()).expect("there");
    assert_eq!(std::fs::read_to_string(&table).expect("a table"), whole);
    // Negative control: the same row in the middle is an error.
    std::fs::write(&table, format!("{whole}filling/c,fill_c\n{whole}")).expect("written");
    assert!(Run::load(place.path()).is_err());
}

/// What reading says after `edit` of a file.
fn refusal(file: &str, edit: impl Fn(&str) -> Option<String>) -> String {
    let place = tempfile::tempdir().expect("a folder");
    written(place.path());
    let path = place.path().join(file);
    let text = std::fs::read_to_string(&path).expect("there");
    match edit(&text) {
        Some(edited) => {
            assert_ne!(edited, text, "the edit of {file} changes something");
            std::fs::write(&path, edited).expect("written");
        }
        None => std::fs::remove_file(&path).expect("removed"),
    }
    let error = Run::load(place.path()).expect_err(file);
    assert!(!matches!(error, RunError::Occupied { .. }));
    let message = error.to_string();
    assert!(message.contains(file), "{message}");
    message
}

#[test]
fn a_renamed_missing_or_additional_column_is_named_with_what_was_expected() {
    for file in ["measurements.csv", "cases.csv", "notes.csv", "metrics.csv"] {
        let message = refusal(file, |text| Some(text.replacen("e,", "é,", 1)));
        assert!(
            message.contains("column") && message.contains("expected"),
            "{message}"
        );
    }
    let renamed = refusal("cases.csv", |text| {
        Some(text.replacen("colour", "color", 1))
    });
    assert!(
        renamed.contains("found \"color\", expected \"colour\""),
        "{renamed}"
    );
    let missing = refusal("measurements.csv", |text| {
        Some(text.replacen(",value", "", 1))
    });
    assert!(
        missing.contains("found \"\", expected \"value\""),
        "{missing}"
    );
    let more = refusal("notes.csv", |text| {
        Some(text.replacen("text\n", "text,more\n", 1))
    });
    assert!(more.contains("found \"more\", expected \"\""), "{more}");
}

#[test]
fn a_run_says_what_ranks_its_studies_and_what_times_cover_and_an_older_one_is_read_without() {
    let time = |name, primary| {
        let time = Metric::less(name, "ms", Kind::Time, "A time.");
        time.covering(Scope::UPLOAD.and(Scope::DRAW))
            .ranking(primary)
    };
    let mut run = MadeUpRun {
        metrics: vec![time("gpu_ms", Primary::Gpu), time("cpu_ms", Primary::Cpu)],
        ..MadeUpRun::default()
    };
    for study in ["fills", "suite"] {
        let case = run.case(case_id(study, "case", &[]));
        case.timed("gpu_ms", &[1.0]).timed("cpu_ms", &[1.0]);
    }
    let place = tempfile::tempdir().expect("a folder");
    let written = run.write(place.path()).expect("a run");
    assert_eq!(written.primary_metric("fills"), Some("cpu_ms"));
    // Control: a study that measures another's metrics is not ranked by them.
    assert_eq!(written.primary_metric("suite"), None);
    assert_eq!(written.metrics[0].scope, "upload+draw");
    let path = place.path().join("metrics.csv");
    let text = std::fs::read_to_string(&path).expect("a table");
    assert!(
        text.ends_with("\ncpu_ms,ms,time,less,A time.,cpu,upload+draw\n"),
        "{text}"
    );
    let without = |columns: usize| {
        let lines = text.lines();
        let cut = lines.map(|line| line.rsplitn(columns + 1, ',').last().unwrap_or_default());
        std::fs::write(&path, cut.collect::<Vec<_>>().join("\n") + "\n").expect("written");
        Run::load(place.path())
    };
    let old = without(2).expect("an older run");
    assert_eq!(old.primary_metric("fills"), None);
    assert_eq!(
        (old.metrics.len(), old.metrics[1].name.as_str()),
        (2, "cpu_ms")
    );
    // Control: one of the two columns alone is neither.
    let half = without(1).expect_err("half").to_string();
    assert!(
        half.contains("column 7: found \"\", expected \"scope\""),
        "{half}"
    );
}

#[test]
fn a_missing_table_and_another_schema_are_refused() {
    for file in ["measurements.csv", "cases.csv", "notes.csv", "metrics.csv"] {
        let message = refusal(file, |_| None);
        assert!(
            message.contains("no such file") && message.contains("expected"),
            "{message}"
        );
    }
    for file in ["schema.json", "plan.json", "environment.json"] {
        refusal(file, |_| None);
    }
    for file in ["schema.json", "environment.json"] {
        let message = refusal(file, |text| {
            Some(text.replacen("\"schema\": 1", "\"schema\": 2", 1))
        });
        assert!(message.contains("found 2, expected 1"), "{message}");
    }
}

#[test]
fn rows_that_do_not_belong_to_the_run_are_refused() {
    let commit = refusal("cases.csv", |text| Some(text.replacen("abc", "def", 1)));
    assert!(
        commit.contains("row 2, column commit: found \"def\""),
        "{commit}"
    );
    let case = refusal("measurements.csv", |text| {
        Some(text.replacen("filling/a", "filling/x", 1))
    });
    assert!(case.contains("row 2, column case"), "{case}");
    let metric = refusal("measurements.csv", |text| {
        Some(text.replacen("draws", "strokes", 1))
    });
    assert!(
        metric.contains("column metric: found \"strokes\""),
        "{metric}"
    );
    let value = refusal("measurements.csv", |text| {
        Some(text.replacen("7.0", "seven", 1))
    });
    assert!(
        value.contains("column value: found \"seven\", expected a number"),
        "{value}"
    );
    let status = refusal("cases.csv", |text| Some(text.replacen("wrong", "fine", 1)));
    assert!(status.contains("column status: found \"fine\""), "{status}");
    let condition = refusal("cases.csv", |text| Some(text.replacen("moon", "mars", 1)));
    assert!(
        condition.contains("column scene: found \"mars\""),
        "{condition}"
    );
}

#[test]
fn a_folder_with_a_run_is_not_written_over() {
    let place = tempfile::tempdir().expect("a folder");
    written(place.path());
    let again = RunFolder::create(place.path(), environment(), plan(), &METRICS);
    assert!(matches!(again, Err(RunError::Occupied { .. })));
}
