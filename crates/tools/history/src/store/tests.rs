// SPDX-License-Identifier: MIT OR Apache-2.0

use super::*;
use crate::exchange::{export, read_tables};
use terrafill_results::Clock;
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{Kind, Metric, Run, Status};

const METRIC: &str = "fill_cpu_ms";

fn primary(_: &str, _: Clock) -> Option<&'static str> {
    Some(METRIC)
}

/// A run at the commit `number`, of a counter and a time.
fn made_up(number: u32) -> MadeUpRun {
    let mut run = MadeUpRun {
        metrics: vec![
            Metric::less(METRIC, "ms", Kind::Time, "Time."),
            Metric::less("draws", "", Kind::Counter, "Draws."),
        ],
        ..MadeUpRun::default()
    };
    run.environment.commit = format!("{number:040x}");
    run.environment.started_unix_s = 1_000 + u64::from(number);
    run.environment.gpu = "software".to_owned();
    run.environment.device_type = "cpu".to_owned();
    run.environment.options = vec!["depth=quick".to_owned(), format!("seed={number}")];
    run.case(case_id("filling", "a", &[("scene", "moon")]))
        .figure("draws", 134.0)
        .timed(METRIC, &[1.0, 3.0, 2.0]);
    run
}

fn written(run: &MadeUpRun) -> (tempfile::TempDir, Run) {
    let folder = tempfile::tempdir().expect("a folder");
    let run = run.write(folder.path()).expect("a run");
    (folder, run)
}

fn record(run: &MadeUpRun) -> Record {
    Record::of(&written(run).1).expect("a whole run").0
}

/// A store of these runs in a folder of its own.
fn store(records: &[(Record, Option<Position>)]) -> (tempfile::TempDir, Store) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut store = Store::create_or_open(&folder.path().join("h.sqlite")).expect("a store");
    let added = store.add(records).expect("stored");
    assert!(added.iter().all(|added| *added == Added::New), "{added:?}");
    (folder, store)
}

#[test]
fn a_run_comes_back_as_it_was_and_is_stored_once() {
    let run = record(&made_up(1));
    let position = Some(Position {
        ordinal: 7,
        unix_s: 99,
    });
    let (folder, mut store) = store(&[(run.clone(), position)]);
    let overview = store.overview().expect("readable");
    let back = store.record(&overview.runs[0]).expect("readable");
    assert_eq!(back, (run.clone(), position));
    assert_eq!(
        store.add(&[(run.clone(), None)]).expect("known"),
        [Added::Known]
    );
    assert_eq!(store.overview().expect("readable").runs.len(), 1);
    // Opened again it is the same; negative control: another run is another one.
    let mut again = Store::open(&folder.path().join("h.sqlite")).expect("a store");
    assert_eq!(again.add(&[(run, None)]).expect("known"), [Added::Known]);
    assert_eq!(
        again.add(&[(record(&made_up(2)), None)]).expect("new"),
        [Added::New]
    );
}

#[test]
fn nothing_is_ever_edited() {
    let (_folder, store) = store(&[(record(&made_up(1)), None)]);
    for statement in ["UPDATE figures SET value = 0", "DELETE FROM runs"] {
        let refused = store
            .connection
            .execute_batch(statement)
            .expect_err(statement);
        assert!(refused.to_string().contains("never edited"), "{refused}");
    }
}

#[test]
fn the_fingerprint_is_of_the_kind_of_machine() {
    let same = |change: &dyn Fn(&mut MadeUpRun)| {
        let mut other = made_up(1);
        change(&mut other);
        record(&other).machine == record(&made_up(1)).machine
    };
    assert!(same(&|run| run.environment.options[1] = "seed=9".to_owned()));
    assert!(same(&|run| run.environment.os = "another kernel".to_owned()));
    // Negative controls.
    assert!(!same(
        &|run| run.environment.driver_info = "Mesa 26".to_owned()
    ));
    assert!(!same(&|run| run.environment.driver_uuid = "ab".to_owned()));
    assert!(!same(&|run| run.environment.cores = 4));
    assert!(!same(&|run| run.environment.width = 512));
    assert!(!same(
        &|run| run.environment.options[0] = "depth=main".to_owned()
    ));
}

#[test]
fn a_run_with_missing_cases_is_stored_with_what_is_missing_and_continued() {
    let mut first = made_up(1);
    first.case(case_id("filling", "b", &[])).missing();
    let mut whole = made_up(1);
    whole
        .case(case_id("filling", "b", &[]))
        .timed(METRIC, &[5.0; 3]);
    let (_folder, mut store) = store(&[(record(&first), None)]);
    let entry = |store: &Store, at: usize| store.overview().expect("readable").runs[at].clone();
    assert_eq!((entry(&store, 0).cases, entry(&store, 0).missing), (2, 1));
    assert_eq!(
        store.add(&[(record(&whole), None)]).expect("more"),
        [Added::Continued]
    );
    assert!(entry(&store, 0).is_superseded && !entry(&store, 1).is_superseded);
    // Negative control: other times in the same second are another run, and both count.
    let mut other = made_up(1);
    other
        .case(case_id("filling", "b", &[]))
        .timed(METRIC, &[5.5; 3]);
    other.cases[0].timed(METRIC, &[7.0; 3]);
    assert_eq!(
        store.add(&[(record(&other), None)]).expect("another"),
        [Added::New]
    );
    assert!(!entry(&store, 1).is_superseded && !entry(&store, 2).is_superseded);
}

#[test]
fn series_follow_ancestry_and_leave_edited_sources_out() {
    // Committed in the same second, and started in the wrong order.
    let at = |number: u32, ordinal: i64| {
        (
            record(&made_up(number)),
            Some(Position { ordinal, unix_s: 5 }),
        )
    };
    let mut dirty = made_up(9);
    dirty.environment.commit.push_str("+dirty");
    let mut more = made_up(3);
    more.cases[0]
        .timed(METRIC, &[4.0; 3])
        .figure("draws", 135.0);
    more.environment.started_unix_s = 5_000;
    let (_folder, store) = store(&[
        at(1, 30),
        at(2, 10),
        at(3, 20),
        (
            record(&dirty),
            Some(Position {
                ordinal: 40,
                unix_s: 5,
            }),
        ),
        (
            record(&more),
            Some(Position {
                ordinal: 20,
                unix_s: 5,
            }),
        ),
    ]);
    let overview = store.overview().expect("readable");
    assert!(overview.is_by_ancestry);
    let commits = [2, 3, 1].map(|number| format!("{number:040x}"));
    assert_eq!(overview.commits, commits);
    assert_eq!(overview.machines.len(), 1);
    let series = store.series(&overview, &primary, &[]).expect("readable");
    let names: Vec<&str> = series.iter().map(|of| of.metric.name.as_str()).collect();
    assert_eq!(names, ["draws", METRIC]);
    let values = |at: usize| {
        series[at]
            .points
            .iter()
            .map(|p| p.value)
            .collect::<Vec<f64>>()
    };
    assert_eq!(values(0), [134.0, 135.0, 134.0], "what the last run found");
    assert_eq!(
        values(1),
        [2.0, 3.0, 2.0],
        "median over processes, then over runs"
    );
    let only = store
        .series(&overview, &primary, &["draws".to_owned()])
        .expect("readable");
    assert_eq!(only.len(), 1);
    // Negative control: without a repository the time of the run decides.
    let (_folder, timed) = self::store(&[(record(&made_up(2)), None), (record(&made_up(1)), None)]);
    let overview = timed.overview().expect("readable");
    assert_eq!(
        overview.commits,
        [1, 2].map(|number| format!("{number:040x}"))
    );
    assert!(!overview.is_by_ancestry);
}

#[test]
fn a_run_says_by_which_metric_a_study_is_ranked() {
    let marked = |number: u32, mark: Option<usize>| {
        let mut run = made_up(number);
        run.metrics.push(Metric::less(
            "fill_wall_ms",
            "ms",
            Kind::Time,
            "By the wall clock.",
        ));
        run.cases[0].timed("fill_wall_ms", &[4.0, 4.0, 4.0]);
        if let Some(at) = mark {
            run.metrics[at] = run.metrics[at].ranking(terrafill_results::Primary::Any);
        }
        record(&run)
    };
    let times = |store: &Store| {
        let overview = store.overview().expect("readable");
        let series = store.series(&overview, &primary, &[]).expect("readable");
        let times = series.into_iter().filter(|of| !of.metric.kind.is_exact());
        times
            .map(|of| (of.metric.name, of.points.len()))
            .collect::<Vec<_>>()
    };
    let expected = |name: &str, commits| vec![(name.to_owned(), commits)];
    // Negative control: without a mark it is what this program's studies say.
    let (_folder, mut store) = store(&[(marked(1, None), None)]);
    assert_eq!(times(&store), expected(METRIC, 1));
    // The newest mark counts for all commits.
    store.add(&[(marked(2, Some(2)), None)]).expect("stored");
    assert_eq!(times(&store), expected("fill_wall_ms", 2));
    store.add(&[(marked(3, Some(0)), None)]).expect("stored");
    assert_eq!(times(&store), expected(METRIC, 3));
}

#[test]
fn a_store_of_an_older_program_is_gone_on_with() {
    let mut run = made_up(1);
    run.metrics[0] = run.metrics[0].ranking(terrafill_results::Primary::Any);
    let (folder, store) = store(&[(record(&run), None)]);
    store
        .connection
        .execute_batch("DROP TABLE ranks")
        .expect("an older store");
    drop(store);
    let mut store = Store::open(&folder.path().join("h.sqlite")).expect("a store");
    let ranks = |store: &Store| {
        let overview = store.overview().expect("readable");
        store.record(&overview.runs[0]).expect("readable").0.ranks
    };
    assert!(ranks(&store).is_empty());
    // Added again it is known, and its mark is kept from then on.
    assert_eq!(
        store.add(&[(record(&run), None)]).expect("known"),
        [Added::Known]
    );
    assert_eq!(ranks(&store), record(&run).ranks);
    assert_eq!(ranks(&store).len(), 1);
    let tables = folder.path().join("tables");
    export(&store, &tables).expect("written");
    assert_eq!(
        read_tables(&tables).expect("readable")[0].0.ranks,
        ranks(&store)
    );
    // Tables of an older program.
    std::fs::remove_file(tables.join("ranks.csv")).expect("there");
    assert!(
        read_tables(&tables).expect("readable")[0]
            .0
            .ranks
            .is_empty()
    );
}

#[test]
fn a_case_that_no_longer_gives_a_result_is_named() {
    let mut failed = made_up(2);
    failed.cases[0].ended(Status::Failed, "device lost");
    let mut without = made_up(3);
    without.cases[0].id.name = "b".to_owned();
    let (_folder, mut store) = store(&[(record(&made_up(1)), None)]);
    let absent = |store: &Store| {
        let overview = store.overview().expect("readable");
        let all = store.absent(&overview).expect("readable");
        all.into_iter()
            .map(|a| (a.case, a.outcome, a.last))
            .collect::<Vec<_>>()
    };
    assert_eq!(absent(&store), []);
    let first = format!("{:040x}", 1);
    for (run, outcome) in [(failed, "failed"), (without, "gone")] {
        store.add(&[(record(&run), None)]).expect("stored");
        let expected = ("filling/a".to_owned(), outcome.to_owned(), first.clone());
        assert_eq!(absent(&store), [expected]);
    }
}

#[test]
fn shards_and_runs_without_a_commit_are_refused() {
    let refused = |change: &dyn Fn(&mut Run)| {
        let (_folder, mut run) = written(&made_up(1));
        change(&mut run);
        Record::of(&run)
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    assert_eq!(refused(&|_| ()), Ok(()));
    let shard = terrafill_results::Shard { index: 1, count: 2 };
    let said = refused(&|run| run.plan.shard = Some(shard)).expect_err("a shard");
    assert!(
        said.contains("shard 1/2") && said.contains("merge"),
        "{said}"
    );
    for commit in ["", "--output=x", "main", "abc+dirty"] {
        let said = refused(&|run| run.environment.commit = commit.to_owned()).expect_err(commit);
        assert!(said.contains("hexadecimal"), "{said}");
    }
    assert!(
        refused(&|run| run.cases.clear())
            .expect_err("empty")
            .contains("no case")
    );
}

#[test]
fn a_metric_that_changed_its_unit_is_refused_with_the_whole_batch() {
    let (_folder, mut store) = store(&[(record(&made_up(1)), None)]);
    let mut other = made_up(3);
    other.metrics[0].unit = "s";
    let error = store
        .add(&[(record(&made_up(2)), None), (record(&other), None)])
        .expect_err("unit");
    assert!(error.to_string().contains("metric fill_cpu_ms"), "{error}");
    assert_eq!(
        store.overview().expect("readable").runs.len(),
        1,
        "all of them or none"
    );
}

#[test]
fn a_full_disk_stores_nothing_and_loses_nothing() {
    let (folder, mut store) = store(&[(record(&made_up(1)), None)]);
    let before = store.overview().expect("readable");
    let pages: i64 = store
        .connection
        .pragma_query_value(None, "page_count", |row| row.get(0))
        .expect("a number");
    store
        .connection
        .pragma_update(None, "max_page_count", pages)
        .expect("set");
    let mut large = made_up(2);
    for case in 0..400 {
        let name = format!("case-{case}");
        large
            .case(case_id("filling", &name, &[]))
            .timed(METRIC, &[1.0; 3]);
    }
    let large = record(&large);
    let error = store.add(&[(large.clone(), None)]).expect_err("full");
    assert!(matches!(error, HistoryError::Full { .. }), "{error}");
    assert_eq!(store.overview().expect("readable"), before);
    // Negative control: with room it is stored, also by who opens the file anew.
    drop(store);
    let mut store = Store::open(&folder.path().join("h.sqlite")).expect("whole");
    assert_eq!(store.add(&[(large, None)]).expect("room"), [Added::New]);
}

#[test]
fn other_files_other_schemas_and_damage_are_refused_and_not_touched() {
    let (folder, store) = store(&[(record(&made_up(1)), None)]);
    drop(store);
    let path = folder.path().join("h.sqlite");
    let good = std::fs::read(&path).expect("readable");
    let refused = |bytes: &[u8]| {
        let path = folder.path().join("other.sqlite");
        std::fs::write(&path, bytes).expect("written");
        let error = Store::create_or_open(&path).expect_err("refused");
        assert_eq!(std::fs::read(&path).expect("there"), bytes, "{error}");
        error
    };
    let error =
        refused(b"case,metric\nno database at all, and long enough to look like a file of pages");
    assert!(matches!(error, HistoryError::NotAStore { .. }), "{error}");
    // The header's user version and application id, big-endian at 60 and 68.
    let edited = |at: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[at] = value;
        bytes
    };
    let error = refused(&edited(63, 9));
    assert!(
        matches!(error, HistoryError::Schema { found: 9, .. }),
        "{error}"
    );
    let error = refused(&edited(71, 0));
    assert!(matches!(error, HistoryError::NotAStore { .. }), "{error}");
    // Every page but the first overwritten, and the end cut off.
    let mut damaged = good.clone();
    damaged[4096..].fill(0x5a);
    let error = refused(&damaged);
    assert!(matches!(error, HistoryError::Damaged { .. }), "{error}");
    let error = refused(&good[..good.len() / 2]);
    assert!(matches!(error, HistoryError::Damaged { .. }), "{error}");
    let missing = Store::open(&folder.path().join("none")).expect_err("no file");
    assert!(missing.to_string().contains("history add"), "{missing}");
    // Negative control.
    assert!(Store::create_or_open(&path).is_ok());
}

#[test]
fn tables_carry_a_history_to_another_store() {
    let position = Some(Position {
        ordinal: 3,
        unix_s: 50,
    });
    let mut odd = made_up(2);
    odd.cases[0].timed(METRIC, &[0.1 + 0.2, 1e-300, 123_456_789.123_456_79]);
    odd.cases[0].id.name = "a \"quoted\", b\nc".to_owned();
    let (folder, first) = store(&[(record(&made_up(1)), position), (record(&odd), None)]);
    let tables = folder.path().join("tables");
    assert_eq!(export(&first, &tables).expect("written"), 2);
    let records = read_tables(&tables).expect("readable");
    let (_other, mut second) = store(&records);
    let all = |store: &Store| {
        let overview = store.overview().expect("readable");
        overview
            .runs
            .iter()
            .map(|run| store.record(run).expect("readable"))
            .collect::<Vec<_>>()
    };
    assert_eq!(all(&first), all(&second));
    assert_eq!(second.add(&records).expect("known"), [Added::Known; 2]);
    assert!(
        export(&first, &tables).is_err(),
        "tables are not written over"
    );
    // Negative controls: an edited value, a lost row, a column of another name, a case of no table.
    let figures = tables.join("figures.csv");
    let good = std::fs::read_to_string(&figures).expect("readable");
    let refused = |text: &str| {
        std::fs::write(&figures, text).expect("written");
        read_tables(&tables)
            .map(|_| ())
            .expect_err("refused")
            .to_string()
    };
    assert!(refused(&good.replacen("134.0", "133.0", 1)).contains("edited or are missing"));
    // The last row's name has a line break.
    let shorter: Vec<&str> = good.lines().take(good.lines().count() - 2).collect();
    assert!(refused(&(shorter.join("\n") + "\n")).contains("edited or are missing"));
    assert!(refused(&good.replacen("process", "replicate", 1)).contains("row 1"));
    assert!(refused(&good.replacen("filling/a,", "filling/z,", 1)).contains("filling/z"));
    assert!(refused(&good.replacen(",134.0", ",many", 1)).contains("row "));
}
