// SPDX-License-Identifier: MIT OR Apache-2.0
//! `history` and `compare` over made-up runs: what is stored, found, proposed, written and refused.

use crate::harness::{Desk, Ran, ran};
use std::process::Command;
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{Kind, Metric};

const CASE: &str = "filling/moon/globe/vertex/doubled";

/// A run of a commit: a time of this many milliseconds and a counter, and the full-screen pass.
fn write_run(desk: &Desk, name: &str, commit: &str, gpu: &str, [time, draws]: [f64; 2]) {
    let mut run = MadeUpRun {
        metrics: vec![
            Metric::less("fill_cpu_ms", "ms", Kind::Time, "Time."),
            Metric::less("draws", "", Kind::Counter, "Draws."),
        ],
        ..MadeUpRun::default()
    };
    run.environment.commit = commit.to_owned();
    run.environment.gpu = gpu.to_owned();
    run.environment.device_type = "cpu".to_owned();
    run.environment.started_unix_s = 1_000;
    (run.environment.width, run.environment.height) = (256, 256);
    let conditions = |technique| {
        [
            ("scene", "moon"),
            ("view", "globe"),
            ("technique", technique),
        ]
    };
    let wave = [1.0, 1.003, 0.998, 1.001, 0.999].map(|factor| factor * time);
    run.case(case_id(
        "filling",
        "moon/globe/vertex/doubled",
        &conditions("vertex"),
    ))
    .figure("draws", draws)
    .timed("fill_cpu_ms", &wave);
    run.case(case_id(
        "filling",
        "moon/globe/depth-pass/full-screen",
        &conditions("depth-pass"),
    ))
    .timed("fill_cpu_ms", &[4.0, 4.01, 3.99, 4.0, 4.02]);
    run.write(&desk.path(name)).expect("written");
}

/// A repository of empty commits in the folder `repository`; their hashes, the oldest first.
fn repository(desk: &Desk, commits: usize) -> Vec<String> {
    desk.write("repository/.keep", "");
    let git = |arguments: &[&str]| {
        let output = Command::new("git")
            .current_dir(desk.path("repository"))
            .args(["-c", "user.name=n", "-c", "user.email=e@example.org"])
            .args(arguments)
            .output()
            .expect("git");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8(output.stdout)
            .expect("UTF-8")
            .trim()
            .to_owned()
    };
    git(&["init", "--quiet"]);
    let commit = |number: usize| {
        git(&[
            "commit",
            "--quiet",
            "--allow-empty",
            "-m",
            &format!("change {number}"),
        ]);
        git(&["rev-parse", "HEAD"])
    };
    (0..commits).map(commit).collect()
}

/// A store of runs at every second commit of a repository: from the run `step` on the time is longer by
/// a fifth and the counter by one.
fn stepped(desk: &Desk, runs: usize, step: usize) -> Vec<String> {
    let commits = repository(desk, 2 * runs);
    let mut add = vec!["history".to_owned(), "add".to_owned()];
    for at in 0..runs {
        let figures = if at < step {
            [10.0, 134.0]
        } else {
            [12.0, 135.0]
        };
        let name = format!("run-{at:02}");
        write_run(desk, &name, &commits[2 * at], "software", figures);
        add.push(name);
    }
    add.extend(["--repository".to_owned(), "repository".to_owned()]);
    let added = desk.run(&add).succeeded();
    assert_eq!(
        added
            .lines()
            .filter(|line| line.contains(": stored: "))
            .count(),
        runs
    );
    commits
}

fn history(desk: &Desk, arguments: &[&str]) -> Ran {
    desk.run(&[&["history"][..], arguments].concat())
}

#[test]
fn a_change_is_found_located_and_shown() {
    let desk = Desk::new();
    let commits = stepped(&desk, 16, 9);
    let list = history(&desk, &["list"]).succeeded();
    assert!(
        list.starts_with("16 runs of 16 commits on 1 kind of machine\n"),
        "{list}"
    );
    let changes = history(&desk, &["changes"]).succeeded();
    let worse: Vec<&str> = changes
        .lines()
        .filter(|line| line.starts_with("worse: "))
        .collect();
    let [counter, time] = worse[..] else {
        panic!("{changes}");
    };
    let first_bad = &commits[18];
    for (line, words) in [(counter, "draws 134 → 135"), (time, "(+20.0 %), step")] {
        assert!(
            line.contains(words) && line.contains(&format!("at {first_bad}")),
            "{line}"
        );
    }
    // The commits between two runs; the one in the middle is to be built.
    let bisect = [
        "bisect",
        CASE,
        "--metric",
        "fill_cpu_ms",
        "--repository",
        "repository",
    ];
    let plan = history(&desk, &bisect).succeeded();
    for words in [
        format!("last good commit in the store: {}", commits[16]),
        "1 commit between them, 1 build".to_owned(),
        format!("  {} build first change 17", commits[17]),
        format!(
            "  terrafill gate moon --study filling --technique vertex --main --size 256x256 --adapter software \
             --base {} --new {}\n",
            commits[16], commits[17]
        ),
    ] {
        assert!(plan.contains(&words), "{words}: {plan}");
    }
    // Negative controls: without the repository, and another case.
    let plan = history(&desk, &["bisect", CASE]).succeeded();
    assert!(
        plan.contains("git rev-list --reverse --ancestry-path"),
        "{plan}"
    );
    history(&desk, &["bisect", "filling/none"]).refused(&[&["filling/none"]]);
    history(&desk, &["changes", "--metric", "none"]).refused(&[&["--metric", "\"none\""]]);

    assert_eq!(
        history(
            &desk,
            &["report", "-o", "page", "--repository", "repository"]
        )
        .succeeded(),
        "report: page/index.html\n"
    );
    let page = desk.read_text("page/index.html");
    assert!(page.len() < 300_000, "{}", page.len());
    for words in [
        "<svg role=\"img\"",
        "Regressions",
        "Improvements",
        "Missing",
        "+20.0 %",
        "Machine 1: 2 changed for the worse",
        "change 18",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let names = std::fs::read_dir(desk.path("page"))
        .expect("a folder")
        .count();
    assert_eq!(names, 1, "one file that needs no other");
}

#[test]
fn equal_work_changes_nothing_and_one_commit_is_nothing_measured() {
    let desk = Desk::new();
    stepped(&desk, 12, 99);
    let changes = history(&desk, &["changes"]).succeeded();
    assert_eq!(changes.lines().count(), 1, "{changes}");
    let none = history(&desk, &["bisect", CASE]).succeeded();
    assert_eq!(
        none,
        format!("{CASE}: no change among the commits of the store\n")
    );
    // Negative control: a store of a single commit has nothing to compare.
    let add = [
        "add",
        "run-00",
        "--store",
        "one.sqlite",
        "--repository",
        "repository",
    ];
    history(&desk, &add).succeeded();
    let lonely = history(&desk, &["changes", "--store", "one.sqlite"]);
    assert_eq!(lonely.code, 4, "{}", lonely.stdout);
    assert!(lonely.stderr.contains("two commits"), "{}", lonely.stderr);
}

#[test]
fn a_run_is_stored_once_and_a_store_goes_into_another_by_tables() {
    let desk = Desk::new();
    stepped(&desk, 3, 99);
    let again = history(&desk, &["add", "run-01", "--repository", "repository"]).succeeded();
    assert!(
        again.contains("run-01: is there already, nothing was done"),
        "{again}"
    );
    let elsewhere = history(&desk, &["add", "run-01", "--repository", "/"]);
    assert!(
        elsewhere.stderr.contains("ordered by time"),
        "{}",
        elsewhere.stderr
    );
    let exported = history(&desk, &["export", "--csv", "tables"]).succeeded();
    assert_eq!(exported, "exported: 3 runs to tables\n");
    let import = ["import", "tables", "--store", "other.sqlite"];
    for said in [
        "imported: 3 runs, 0 were there already\n",
        "imported: 0 runs, 3 were there already\n",
    ] {
        assert_eq!(history(&desk, &import).succeeded(), said);
    }
    let lists = ["history.sqlite", "other.sqlite"]
        .map(|store| history(&desk, &["list", "--store", store, "--json"]).succeeded());
    assert_eq!(lists[0], lists[1]);
}

#[test]
fn what_is_no_history_and_no_run_is_refused_and_stays() {
    let desk = Desk::new();
    write_run(&desk, "run", &"a".repeat(40), "software", [10.0, 1.0]);
    write_run(&desk, "nameless", "", "software", [10.0, 1.0]);
    history(&desk, &["list"]).refused(&[&["history.sqlite: found no such file", "history add"]]);
    desk.write(
        "notes.txt",
        "not a database, but a text of some length that nobody wants to lose",
    );
    history(&desk, &["add", "run", "--store", "notes.txt"])
        .refused(&[&["notes.txt: found no SQLite file", "not touched"]]);
    assert!(desk.read_text("notes.txt").starts_with("not a database"));
    history(&desk, &["add", "nameless"]).refused(&[&["commit: found \"\"", "hexadecimal"]]);
    history(&desk, &["add", "lost"]).refused(&[&["lost"]]);
    history(&desk, &["add", "run", "--store", "none/h.sqlite"]).refused(&[&["none/h.sqlite"]]);
    assert!(!desk.path("history.sqlite").exists(), "nothing was begun");
}

#[test]
#[cfg(unix)]
fn a_full_disk_loses_nothing() {
    let desk = Desk::new();
    stepped(&desk, 2, 99);
    let before = desk.read("history.sqlite");
    let mut large = MadeUpRun {
        metrics: vec![Metric::less("draws", "", Kind::Counter, "Draws.")],
        ..MadeUpRun::default()
    };
    large.environment.commit = "b".repeat(40);
    for case in 0..2_000 {
        large
            .case(case_id("filling", &format!("case-{case}"), &[]))
            .figure("draws", 1.0);
    }
    large.write(&desk.path("large")).expect("written");
    // No file may grow beyond this many blocks of 512 bytes; the signal of that is ignored.
    let add = |limit: &str| {
        let script = format!(
            "trap '' XFSZ; ulimit -f {limit}; exec \"$0\" history add large --repository repository"
        );
        let program = env!("CARGO_BIN_EXE_terrafill");
        ran(Command::new("sh")
            .args(["-c", &script, program])
            .current_dir(desk.path("")))
    };
    let full = add("150");
    assert_eq!(full.code, 2, "{}{}", full.stdout, full.stderr);
    assert!(
        full.stderr.contains("history.sqlite") && full.stderr.contains("stored"),
        "{}",
        full.stderr
    );
    let list = history(&desk, &["list"]).succeeded();
    assert!(list.starts_with("2 runs"), "{list}");
    assert_eq!(desk.read("history.sqlite"), before);
    // Negative control: with room it is stored.
    let stored = add("unlimited");
    assert_eq!(stored.code, 0, "{}", stored.stderr);
    assert!(history(&desk, &["list"]).succeeded().starts_with("3 runs"));
}

#[test]
fn two_runs_are_compared_in_every_format() {
    let desk = Desk::new();
    write_run(&desk, "a", &"a".repeat(40), "software", [10.0, 134.0]);
    write_run(&desk, "b", &"b".repeat(40), "software", [12.0, 134.0]);
    write_run(&desk, "c", &"c".repeat(40), "software", [10.01, 135.0]);
    write_run(&desk, "d", &"d".repeat(40), "hardware", [30.0, 134.0]);
    // Times alone are advice.
    let slower = desk
        .run(&["compare", "a", "b", "--html", "page"])
        .succeeded();
    assert!(
        slower.contains("Times of two jobs: advice.") && slower.contains("| 1.20 ["),
        "{slower}"
    );
    let page = desk.read_text("page/index.html");
    for words in [
        "Regressions",
        "Improvements",
        "Missing and new",
        "Unchanged",
        "1.20 [",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let counted = desk.run(&["compare", "a", "c", "--csv"]);
    assert_eq!(counted.code, 1, "{}", counted.stderr);
    assert!(
        counted
            .stdout
            .contains(&format!("{CASE},draws,worse,134,135")),
        "{}",
        counted.stdout
    );
    let json = desk.run(&["compare", "a", "b", "--json"]).succeeded();
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["verdict"], "pass");
    assert_eq!(json["times"][0]["cases"][1]["standing"], "slower");
    // Another device is no regression, neither by pairs nor side by side.
    let other = desk.run(&["compare", "a", "d"]);
    assert!(
        !other.stdout.contains("Times of two jobs: advice."),
        "{}",
        other.stdout
    );
    assert!(
        other.stdout.contains("different machines are not compared"),
        "{}",
        other.stdout
    );
    let devices = desk
        .run(&["compare", "a", "b", "d", "--by", "device"])
        .succeeded();
    let row = devices
        .lines()
        .find(|line| line.contains(CASE))
        .expect("a row");
    assert!(
        row.contains("| 2.75 | 7.50 [") && !devices.contains("slower"),
        "{devices}"
    );
    let table = desk.run(&[
        "compare", "a", "d", "--by", "device", "--csv", "--html", "by",
    ]);
    assert!(
        table.succeeded().lines().count() == 5,
        "a header, and two cases on two devices"
    );
    desk.run(&["compare", "a"])
        .refused(&[&["found 1 runs, allowed: two"]]);
    desk.run(&["compare", "a", "a"]).refused(&[&["one folder"]]);
}

#[test]
fn bisect_uses_the_runs_of_other_machines_and_refuses_a_drift() {
    let desk = Desk::new();
    let commits = repository(&desk, 17);
    let mut add = vec!["history".to_owned(), "add".to_owned()];
    let mut run = |at: usize, gpu: &str, figures: [f64; 2]| {
        let name = format!("{gpu}-{at:02}");
        write_run(&desk, &name, &commits[at], gpu, figures);
        add.push(name);
    };
    // The one machine knows the first and the last commit, the other one some between; times grow slowly.
    for at in [0, 16] {
        run(at, "one", [10.0, if at < 9 { 134.0 } else { 135.0 }]);
    }
    for at in (0..17).filter(|at| *at != 9) {
        let grown = 10.0 * 1.02_f64.powi(i32::try_from(at).expect("small"));
        run(at, "another", [grown, if at < 9 { 7.0 } else { 9.0 }]);
    }
    add.extend(["--repository".to_owned(), "repository".to_owned()]);
    desk.run(&add).succeeded();
    let bisect = |metric: &str, machine: &str| {
        let arguments = ["bisect", CASE, "--metric", metric, "--machine", machine];
        history(
            &desk,
            &[&arguments[..], &["--repository", "repository"]].concat(),
        )
    };
    let plan = bisect("draws", "1").succeeded();
    for words in [
        format!(
            "stored between: {} machine 2: 7, before the change",
            commits[8]
        ),
        format!(
            "stored between: {} machine 2: 9, after the change",
            commits[10]
        ),
        format!("last good commit in the store: {}", commits[8]),
        format!("first bad commit in the store: {}", commits[10]),
        "1 commit between them, 1 build".to_owned(),
        format!(
            "--adapter one --no-time --base {} --new {}",
            commits[8], commits[9]
        ),
    ] {
        assert!(plan.contains(&words), "{words}: {plan}");
    }
    let drift = bisect("fill_cpu_ms", "2");
    assert_eq!(drift.code, 3, "{}", drift.stderr);
    for words in [
        "a drift, from",
        "no bisection finds one",
        "--base",
        &commits[16],
    ] {
        assert!(drift.stdout.contains(words), "{words}: {}", drift.stdout);
    }
}

/// Programs `cargo` that "builds" a terrafill which copies a prepared run: a commit whose subject is
/// `broken` does not build.
#[cfg(unix)]
fn write_builder(desk: &Desk, broken: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    let kept = desk.path("kept");
    let (built, kept) = (desk.path("built"), kept.display());
    let script = format!(
        r#"#!/bin/sh
commit=$(git rev-parse HEAD)
echo "$commit" >> '{}'
if [ "$(git log -1 --format=%s)" = '{broken}' ]; then echo 'error: does not compile' >&2; exit 101; fi
mkdir -p "$CARGO_TARGET_DIR/release"
cat > "$CARGO_TARGET_DIR/release/terrafill" <<END
#!/bin/sh
test "\$1 \$2 \$3 \$4" = "bench moon --size 256" || exit 9
mkdir -p "\$6" && cp -r '{kept}/$commit/.' "\$6"
END
chmod +x "$CARGO_TARGET_DIR/release/terrafill"
"#,
        built.display()
    );
    desk.write("tools/cargo", script);
    let mode = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(desk.path("tools/cargo"), mode).expect("a mode");
}

#[test]
#[cfg(unix)]
fn old_commits_are_built_and_measured_and_only_what_lacks() {
    let desk = Desk::new();
    let commits = repository(&desk, 5);
    for (at, commit) in (0_u32..).zip(&commits) {
        let figures = [10.0, 134.0 + f64::from(at)];
        write_run(
            &desk,
            &format!("kept/{commit}"),
            commit,
            "software",
            figures,
        );
    }
    let run = |arguments: &[&str]| {
        let tools = desk.path("tools").display().to_string();
        let path = std::env::var("PATH").expect("a path");
        let words = [&["history"][..], arguments].concat();
        let mut command = desk.command(&words);
        command.env("PATH", format!("{tools}:{path}"));
        ran(command.current_dir(desk.path("repository")))
    };
    let first = format!("../kept/{}", commits[1]);
    run(&["add", &first]).succeeded();
    let range = format!("{}..", commits[0]);
    let bench = ["--", "moon", "--size", "256"];
    let backfill = [&["backfill", &range][..], &bench].concat();

    write_builder(&desk, "change 2");
    let dry = run(&[&["backfill", &range, "--dry-run"][..], &bench].concat()).succeeded();
    for words in [
        format!("{}: is stored already: change 1\n", commits[1]),
        format!(
            "git worktree add --force --detach target/gate/tree {}\n",
            commits[2]
        ),
        format!(
            "target/gate/bin/{0}/terrafill bench moon --size 256 --out out/backfill/{0}\n",
            commits[4]
        ),
    ] {
        assert!(dry.contains(&words), "{words}: {dry}");
    }
    assert!(!desk.path("built").exists(), "nothing was done");

    // One of four is there, one does not build, and the others are stored.
    let some = run(&backfill);
    assert_eq!(some.code, 3, "{}{}", some.stdout, some.stderr);
    assert!(
        some.stdout
            .ends_with("backfilled: 2 stored, 1 were there already, 1 failed\n"),
        "{}",
        some.stdout
    );
    let named = format!("{} (change 2): ", commits[2]);
    assert!(some.stderr.contains(&named), "{}", some.stderr);
    let built = |desk: &Desk| desk.read_text("built").lines().count();
    assert_eq!(built(&desk), 3);
    // Mended, the same command builds the one that lacks.
    write_builder(&desk, "nothing");
    let all = run(&backfill);
    assert_eq!(all.code, 0, "{}", all.stderr);
    let end = "backfilled: 1 stored, 3 were there already, 0 failed\n";
    assert!(all.stdout.ends_with(end), "{}", all.stdout);
    assert_eq!(built(&desk), 4);
    let changes = run(&["changes", "--metric", "draws"]).succeeded();
    assert_eq!(
        changes.lines().filter(|l| l.starts_with("worse: ")).count(),
        3,
        "{changes}"
    );

    // Negative controls: bad input, and nothing but failures.
    run(&["backfill", "main"]).refused(&[&["\"main\"", "FROM..TO"]]);
    run(&["backfill", "nowhere..HEAD"]).refused(&[&["found no commit \"nowhere\""]]);
    run(&[&backfill[..], &["--out", "x"]].concat()).refused(&[&["--out: found among"]]);
    run(&["backfill", &range, "--machine", "9"]).refused(&[&["--machine: found 9, allowed: 1"]]);
    let wrong = ["backfill", &range, "--store", "new.sqlite", "--", "mars"];
    assert_eq!(run(&wrong).code, 4);
}
