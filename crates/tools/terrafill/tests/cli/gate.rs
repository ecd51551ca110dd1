// SPDX-License-Identifier: MIT OR Apache-2.0
//! `gate`, `bless` and `compare`: what passes, what does not, and that nothing passes unmeasured.

use crate::harness::{Desk, Ran, collection, has_device, polygon, rectangle};
use std::collections::BTreeSet;
use std::io::Write as _;

/// A run of one technique that takes a moment, into `out`.
fn measure(desk: &Desk, out: &str) {
    let options = ["--technique", "vertex", "--size", "64", "--samples", "1"];
    let bench = ["bench", "california", "--quick", "--out", out];
    desk.run(&[&bench[..], &options].concat()).succeeded();
}

fn gate(desk: &Desk, arguments: &[&str]) -> Ran {
    desk.run(&[&["gate"][..], arguments].concat())
}

/// The gate over the run folders `a` and `b`.
fn of_runs(desk: &Desk) -> Ran {
    gate(desk, &["--base-run", "a", "--new-run", "b"])
}

/// The program under another name, with a byte more at its end: the same work of another file.
fn repeat(desk: &Desk) {
    let path = desk.path("same");
    std::fs::copy(env!("CARGO_BIN_EXE_terrafill"), &path).expect("copied");
    let file = std::fs::OpenOptions::new().append(true).open(&path);
    file.expect("writable").write_all(b"\n").expect("written");
}

const CASE: &str = "filling/california/globe/vertex/doubled";

/// Replaces the value of a counter of [`CASE`] in a run's table.
fn tamper(desk: &Desk, run: &str, metric: &str, value: &str) {
    let name = format!("{run}/measurements.csv");
    let text = desk.read_text(&name);
    let start = format!("{CASE},{metric},0,0,");
    assert!(text.contains(&start), "{start}");
    let lines = text.lines().map(|line| match line.strip_prefix(&start) {
        Some(_) => format!("{start}{value}\n"),
        None => format!("{line}\n"),
    });
    desk.write(&name, lines.collect::<String>());
}

#[test]
fn equal_work_passes_and_a_counter_that_changed_fails_until_it_is_blessed() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    measure(&desk, "a");
    measure(&desk, "b");
    let passed = of_runs(&desk);
    assert_eq!(passed.code, 0, "{}{}", passed.stdout, passed.stderr);
    assert!(
        passed.stdout.starts_with("PASS (exit 0)"),
        "{}",
        passed.stdout
    );
    for file in ["gate.md", "gate.json", "gate.junit.xml"] {
        assert!(desk.path("out/gate").join(file).is_file(), "{file}");
    }

    tamper(&desk, "b", "draws", "999");
    let failed = of_runs(&desk);
    assert_eq!(failed.code, 1, "{}", failed.stdout);
    for words in [
        CASE,
        "→ 999",
        "draws ",
        "see: terrafill bench california --study filling",
    ] {
        assert!(failed.stdout.contains(words), "{words}: {}", failed.stdout);
    }
    let compared = desk.run(&["compare", "a", "b"]);
    assert_eq!(compared.code, 1);
    assert!(compared.stdout.contains("| 999 |"), "{}", compared.stdout);

    desk.run(&["bless", CASE, "--reason", ""])
        .refused(&[&["--reason"]]);
    desk.run(&["bless", "filling/none", "--reason", "x"])
        .refused(&[&["filling/none", CASE]]);
    let blessed = desk
        .run(&["bless", CASE, "--reason", "a second cap"])
        .succeeded();
    assert!(blessed.contains("→ 999"), "{blessed}");
    assert!(desk.read_text("gate/blessed.csv").contains("a second cap"));
    assert_eq!(of_runs(&desk).code, 0);

    // Another value is not the blessed one, which is now stale.
    tamper(&desk, "b", "draws", "1000");
    let stale = of_runs(&desk);
    assert_eq!(stale.code, 1, "{}", stale.stdout);
    assert!(stale.stdout.contains("blessing stale"), "{}", stale.stdout);

    // Everything at once, by a pattern, and what is idle taken out.
    let before = desk.read("b/measurements.csv");
    tamper(&desk, "b", "vertices", "7");
    assert_eq!(of_runs(&desk).code, 1);
    desk.run(&["bless", "filling/*/no", "--reason", "x"])
        .refused(&[&["filling/*/no", CASE]]);
    desk.run(&["bless", "--all"]).refused(&[&["--reason"]]);
    let all = desk.run(&["bless", "--all", "--reason", "another mesh"]);
    let all = all.succeeded();
    assert!(all.contains("→ 1000") && all.contains("→ 7"), "{all}");
    let accepted = of_runs(&desk);
    assert_eq!(accepted.code, 0, "{}", accepted.stdout);
    for name in ["gate.md", "gate.json", "gate.junit.xml"] {
        let text = desk.read_text(&format!("out/gate/{name}"));
        assert!(text.contains("another mesh"), "{name}: {text}");
    }
    tamper(&desk, "b", "draws", "1001");
    assert_eq!(of_runs(&desk).code, 1);
    let by_pattern = ["bless", "*/doubled", "--reason", "more", "--prune"];
    let pruned = desk.run(&by_pattern).succeeded();
    assert!(pruned.contains("0 blessings taken out"), "{pruned}");
    desk.write("b/measurements.csv", before);
    tamper(&desk, "b", "draws", "1001");
    assert_eq!(of_runs(&desk).code, 0);
    let pruned = desk.run(&["bless", "--prune"]).succeeded();
    assert!(pruned.contains("1 blessings taken out"), "{pruned}");
    assert!(!desk.read_text("gate/blessed.csv").contains(",vertices,"));

    // A limit that is about nothing guards nothing.
    let limits =
        |metric: &str| format!("case,metric,min,max,reason\nfilling/*,{metric},,2000,so\n");
    let with_limits = [
        "--base-run",
        "a",
        "--new-run",
        "b",
        "--limits",
        "limits.csv",
    ];
    desk.write("limits.csv", limits("nope"));
    gate(&desk, &with_limits).refused(&[&["\"filling/*\"", "\"nope\""]]);
    desk.write("limits.csv", limits("draws"));
    assert_eq!(gate(&desk, &with_limits).code, 0);
}

#[test]
fn nothing_that_was_not_measured_passes() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    measure(&desk, "a");
    measure(&desk, "b");
    for (metric, value) in [("filled_px", "0"), ("filled_px", "NaN"), ("draws", "0")] {
        let before = desk.read("b/measurements.csv");
        tamper(&desk, "b", metric, value);
        assert_eq!(of_runs(&desk).code, 1, "{metric} {value}");
        desk.write("b/measurements.csv", before);
    }
    gate(&desk, &["--base-run", "a", "--new-run", "a"]).refused(&[&["one folder"]]);
    let copied = std::process::Command::new("cp")
        .args(["-r", "a", "c"])
        .current_dir(desk.path("."))
        .status();
    assert!(copied.expect("cp runs").success());
    gate(&desk, &["--base-run", "a", "--new-run", "c"]).refused(&[&["a copy of the other"]]);
    gate(&desk, &["--base-run", "a"]).refused(&[&["--new-run"]]);
    gate(&desk, &["--base-run", "a", "--new-run", "none"]).refused(&[&["none"]]);
    gate(&desk, &[]).refused(&[&["nothing to compare with"]]);

    let cases = desk.read_text("b/cases.csv");
    let without: String = cases
        .lines()
        .filter(|line| !line.starts_with(&format!("{CASE},")))
        .map(|line| format!("{line}\n"))
        .collect();
    desk.write("b/cases.csv", without);
    let missing = of_runs(&desk);
    assert_eq!(missing.code, 3, "{}", missing.stdout);
    assert!(
        missing.stdout.contains("INCONCLUSIVE"),
        "{}",
        missing.stdout
    );

    desk.write("b/cases.csv", cases.replace("status", "state"));
    of_runs(&desk).refused(&[&["b/cases.csv, column 3", "\"state\"", "\"status\""]]);
    std::fs::remove_file(desk.path("b/cases.csv")).expect("removed");
    of_runs(&desk).refused(&[&["b/cases.csv"]]);
    assert!(
        !desk.path("out/gate/gate.json").exists(),
        "no answer of an earlier gate"
    );
}

#[test]
fn a_baseline_is_saved_compared_with_and_missed() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    measure(&desk, "a");
    let missing = gate(&desk, &["--new-run", "a", "--baseline", "main"]);
    assert_eq!(missing.code, 4, "{}", missing.stderr);
    assert!(
        missing.stderr.contains("--save-baseline main"),
        "{}",
        missing.stderr
    );
    gate(&desk, &["--new-run", "a", "--save-baseline", "main"]).succeeded();
    measure(&desk, "b");
    let compare = ["--new-run", "b", "--baseline", "main"];
    assert_eq!(gate(&desk, &compare).code, 0);
    tamper(&desk, "b", "mismatched_px", "1e6");
    assert_eq!(gate(&desk, &compare).code, 1);
}

#[test]
fn two_programs_are_compared_and_one_program_or_none_is_not() {
    let desk = Desk::new();
    repeat(&desk);
    let quick = ["california", "--technique", "vertex", "--size", "48"];
    let with = |more: &[&'static str]| [&quick[..], more].concat();
    let this = env!("CARGO_BIN_EXE_terrafill");
    gate(&desk, &with(&["--base", this])).refused(&[&["one program"]]);
    gate(&desk, &with(&["--base", "no-such-revision"])).refused(&[&["no-such-revision"]]);
    std::fs::copy(this, desk.path("equal")).expect("copied");
    let equal = gate(&desk, &with(&["--base", "equal"]));
    assert_eq!(equal.code, 4, "{}", equal.stderr);

    let gate_it = [
        &["gate"][..],
        &with(&["--base", "same", "--out", "nowhere"]),
    ]
    .concat();
    assert_eq!(desk.run_without_device(&gate_it).code, 5);
    if !has_device() {
        return;
    }
    let ran = gate(
        &desk,
        &with(&["--base", "same", "--no-time", "--out", "exact"]),
    );
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    assert!(
        ran.stdout.contains("times were not compared"),
        "{}",
        ran.stdout
    );
    gate(&desk, &with(&["--base", "same", "--out", "exact"])).refused(&[&["holds something"]]);
    // Times were asked for, and there was no time for them.
    let ran = gate(
        &desk,
        &with(&["--base", "same", "--time-budget-s", "1", "--out", "late"]),
    );
    assert_eq!(ran.code, 4, "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stderr.contains("time budget of 1 s"), "{}", ran.stderr);
}

/// A program that is this one, with something done before or after it.
fn altered(desk: &Desk, name: &str, before: &str, after: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    let this = env!("CARGO_BIN_EXE_terrafill");
    let script = format!("#!/bin/sh\n{before}\n\"{this}\" \"$@\"\ncode=$?\n{after}\nexit $code\n");
    desk.write(name, script);
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(desk.path(name), executable).expect("set");
}

/// Sets `out` to the folder that `bench` writes to.
const OUT: &str = "for word in \"$@\"; do [ \"$last\" = --out ] && out=$word; last=$word; done";

/// One square seen from above by one technique: what takes two programs the least time.
const QUICK: [&str; 7] = [
    "few.toml",
    "--data",
    "data",
    "--technique",
    "vertex",
    "--size",
    "48",
];

/// Writes the scene of [`QUICK`].
fn write_few(desk: &Desk) {
    let square = polygon(&rectangle(-9.0, -9.0, 9.0, 9.0));
    desk.write_scene("few", &collection(&[("square", square)]));
}

#[test]
fn programs_that_measure_nothing_that_counts_never_pass() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    write_few(&desk);
    let edit = |what: &str, table: &str| {
        let file = format!("\"$out/{table}\"");
        format!("{OUT}\n[ -f {file} ] && sed -i '{what}' {file}")
    };
    let cases: [(&str, String, String, i32, &str); 7] = [
        // What it draws is a tenth of what it was.
        (
            "tenth",
            String::new(),
            edit(r"s/\(,draws,0,0,\).*/\10.1/", "measurements.csv"),
            1,
            "draws",
        ),
        (
            "absent",
            String::new(),
            edit(r"/^filling\/few\/above\/vertex\/doubled,/d", "cases.csv"),
            3,
            "doubled",
        ),
        (
            "nan",
            String::new(),
            edit(r"s/\(,filled_px,0,0,\).*/\1NaN/", "measurements.csv"),
            1,
            "filled_px",
        ),
        (
            "device",
            String::new(),
            edit(r#"s/"gpu": ".*"/"gpu": "another"/"#, "environment.json"),
            2,
            "give --adapter",
        ),
        ("dies", "exit 9".to_owned(), String::new(), 2, "status: 9"),
        (
            "silent",
            "[ \"$1\" = bench ] && exit 4".to_owned(),
            String::new(),
            4,
            "nothing measured",
        ),
        // Negative control.
        ("equal", String::new(), String::new(), 0, "PASS"),
    ];
    for (name, before, after, code, words) in cases {
        altered(&desk, name, &before, &after);
        let out = format!("out-{name}");
        let more = ["--base", env!("CARGO_BIN_EXE_terrafill"), "--new"];
        let paths = [&format!("./{name}"), "--no-time", "--out", &out];
        let ran = gate(&desk, &[&QUICK[..], &more, &paths].concat());
        let said = format!("{}{}", ran.stdout, ran.stderr);
        assert_eq!(ran.code, code, "{name}: {said}");
        assert!(said.contains(words), "{name}: {said}");
        let has_answer = desk.path(&format!("{out}/gate.json")).exists();
        assert_eq!(has_answer, !matches!(code, 2 | 4), "{name}");
    }
}

/// A gate of the few cases of one view with times, small enough for a test.
fn timed(desk: &Desk, base: &str, new: &str, out: &str, budget_s: &str) -> Ran {
    write_few(desk);
    let scene = ["few.toml", "--data", "data", "--technique", "instanced"];
    let sides = ["--base", base, "--new", new, "--out", out];
    let rest = ["--size", "16", "--time-budget-s", budget_s];
    gate(desk, &[&scene[..], &sides, &rest].concat())
}

#[test]
fn times_are_taken_in_lock_step_and_by_turns_of_a_program_that_cannot() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let this = env!("CARGO_BIN_EXE_terrafill");
    let before = "case \" $* \" in *' --time-only '*) echo \"$0\" >>files; \
                  cat \"${0%/*}\"/run/*.* | wc -c >>read; esac";
    altered(&desk, "listed", before, "");
    // A busy machine uses up the short budget before a second process begins, and gets a long one then.
    let second_began = ["6", "90"].into_iter().any(|budget_s| {
        for file in ["files", "read"] {
            let _absent_at_first = std::fs::remove_file(desk.path(file));
        }
        let out = format!("together-{budget_s}");
        let ran = timed(&desk, "./listed", this, &out, budget_s);
        let said = format!("{}{}", ran.stdout, ran.stderr);
        // It may be inconclusive; nothing is slower and nothing is an error.
        assert!(matches!(ran.code, 0 | 3 | 4), "{said}");
        assert!(!said.contains("whole processes by turns"), "{said}");
        let options = desk.read_text(&format!("{out}/base/environment.json"));
        assert!(options.contains("samples=1\""), "{options}");
        let rows = desk.read_text(&format!("{out}/base/measurements.csv"));
        rows.contains(",2,12,")
    });
    assert!(second_began, "the second process has samples");

    // Processes of one file share its pages, which makes them as fast as each other and no others.
    let text = desk.read_text("files");
    let files: BTreeSet<&str> = text.lines().collect();
    assert!(files.len() >= 2, "{text}");
    assert_eq!(
        files.len(),
        text.lines().count(),
        "each has its own: {text}"
    );
    for file in files {
        assert!(!desk.path(file).exists(), "{file} is left");
    }
    // What earlier ones measured is nothing that a process reads.
    let read = desk.read_text("read");
    let read: BTreeSet<&str> = read.lines().map(str::trim).collect();
    assert_eq!(read.len(), 1, "{read:?}");

    // Negative control: one that was built before.
    let before = "case \" $* \" in *' --stepped '*) echo unexpected >&2; exit 2;; esac";
    altered(&desk, "old", before, "");
    let ran = timed(&desk, "./old", this, "turns", "1");
    assert_eq!(ran.code, 4, "{}{}", ran.stdout, ran.stderr);
    let options = desk.read_text("turns/base/environment.json");
    assert!(options.contains("samples=30"), "{options}");

    // A program whose timing processes break off.
    let before = "case \" $* \" in *' --process=00003 '*) echo broken by hand >&2; exit 2;; esac";
    altered(&desk, "breaks", before, "");
    let ran = timed(&desk, this, "./breaks", "broken", "40");
    assert_eq!(ran.code, 2, "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stderr.contains("./breaks"), "{}", ran.stderr);
}

/// A repository of two commits, each with this program in the cache as what was built from it.
fn two_commits(desk: &Desk) -> [String; 2] {
    let git = |arguments: &[&str]| git(&desk.path("."), arguments);
    git(&["init", "--quiet"]);
    let mut commits = Vec::new();
    for name in ["first", "second"] {
        git(&["commit", "--quiet", "--allow-empty", "-m", name]);
        let commit = git(&["rev-parse", "HEAD"]);
        let folder = desk.path(&format!("target/gate/bin/{commit}"));
        std::fs::create_dir_all(&folder).expect("a folder");
        let bytes = std::fs::read(env!("CARGO_BIN_EXE_terrafill")).expect("read");
        let binary = folder.join("terrafill");
        std::fs::copy(env!("CARGO_BIN_EXE_terrafill"), &binary).expect("copied");
        std::fs::write(&binary, [&bytes[..], name.as_bytes()].concat()).expect("written");
        commits.push(commit);
    }
    <[String; 2]>::try_from(commits).expect("two")
}

#[test]
fn revisions_the_wrong_way_round_are_refused() {
    let desk = Desk::new();
    write_few(&desk);
    let [first, second] = two_commits(&desk);
    let of = |base: &str, new: &str| {
        let sides = ["--base", base, "--new", new, "--no-time", "--out", "out"];
        gate(&desk, &[&QUICK[..], &sides].concat())
    };
    of(&second, &first).refused(&[&["is a descendant of new", "the wrong way round"]]);
    of(&first, &first).refused(&[&["one program"]]);
    // Negative control.
    if has_device() {
        let ran = of(&first, "HEAD");
        assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    }
}

#[test]
fn a_scene_that_a_change_edits_is_run_by_both_programs_as_it_is_now() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let shipped = include_str!("../../../../../bench-scenes/square-10m.toml");
    let commit = |text: &str| {
        std::fs::create_dir_all(desk.path("bench-scenes")).expect("a folder");
        desk.write("bench-scenes/square-10m.toml", text);
        git(&desk.path("."), &["add", "bench-scenes"]);
    };
    git(&desk.path("."), &["init", "--quiet"]);
    commit(shipped);
    let [first, _] = two_commits(&desk);
    let gate_it = |out: &str| {
        let work = ["square-10m", "--technique", "vertex", "--size", "48"];
        let sides = ["--base", &first, "--new", "HEAD", "--no-time", "--out", out];
        gate(&desk, &[&work[..], &sides].concat())
    };
    // Negative control: nothing was edited.
    let ran = gate_it("same");
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    assert!(!ran.stderr.contains("was edited"), "{}", ran.stderr);
    commit(&format!("# edited\n{shipped}"));
    two_commits(&desk);
    let ran = gate_it("edited");
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    let words = "square-10m was edited: both programs run it as the new version has it";
    assert!(ran.stderr.contains(words), "{}", ran.stderr);
    // What the base cannot read says nothing for or against the new version.
    commit(&format!("added-lately = 1\n{shipped}"));
    two_commits(&desk);
    let ran = gate_it("unreadable");
    assert_eq!(ran.code, 3, "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stderr.contains("added-lately"), "{}", ran.stderr);
}

fn git(folder: &std::path::Path, arguments: &[&str]) -> String {
    let mut command = std::process::Command::new("git");
    let author = ["-c", "user.name=a", "-c", "user.email=a@b"];
    command.args(author).args(arguments).current_dir(folder);
    let output = command.output().expect("git runs");
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).expect("text");
    text.trim().to_owned()
}

#[test]
fn a_clone_without_the_base_and_a_base_that_is_not_found_are_refused() {
    let desk = Desk::new();
    let [first, _] = two_commits(&desk);
    let origin = format!(
        "file://{}",
        desk.path(".").canonicalize().expect("a folder").display()
    );
    git(
        &desk.path("."),
        &["clone", "--quiet", "--depth", "1", &origin, "shallow"],
    );
    let in_clone = |base: &str| {
        let mut command = desk.command(&["gate", "square-10m", "--base", base]);
        crate::harness::ran(command.current_dir(desk.path("shallow")))
    };
    in_clone(&first).refused(&[&[&first, "shallow clone", "fetch-depth: 0"]]);
    // Negative control: in the whole repository the word is another one.
    let whole = gate(&desk, &["square-10m", "--base", "no-such-revision"]);
    assert!(!whole.stderr.contains("shallow"), "{}", whole.stderr);
    whole.refused(&[&["no-such-revision"]]);

    // The script that finds the base by itself.
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../ci/gate.sh");
    std::fs::create_dir_all(desk.path("shallow/ci")).expect("a folder");
    std::fs::copy(script, desk.path("shallow/ci/gate.sh")).expect("copied");
    desk.write("shallow/ci/setup.sh", "#!/bin/sh\necho set up\nexit 9\n");
    let executable = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(desk.path("shallow/ci/setup.sh"), executable).expect("set");
    let by_script = |target: &str| {
        let mut bash = std::process::Command::new("bash");
        bash.arg("ci/gate.sh").env("GATE_TARGET", target);
        crate::harness::ran(bash.current_dir(desk.path("shallow")))
    };
    by_script(&first).refused(&[&["no merge base", &first, "fetch-depth: 0"]]);
    // Negative control: one that is there is built.
    let built = by_script("HEAD");
    assert_eq!((built.code, built.stdout.as_str()), (9, "set up\n"));
}

#[test]
fn a_gate_that_was_killed_leaves_no_answer_and_no_process() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    write_few(&desk);
    repeat(&desk);
    let sides = ["--base", "same", "--out", "killed"];
    let mut command = desk.command(&[&["gate"][..], &QUICK, &sides].concat());
    let mut child = command.spawn().expect("the program starts");
    let is_timing = || desk.path("killed/process-00003").exists();
    let started = std::time::Instant::now();
    while !is_timing() && started.elapsed().as_secs() < 120 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    child.kill().expect("killed");
    child.wait().expect("a child");
    assert!(is_timing(), "it timed nothing");
    assert!(!desk.path("killed/gate.json").exists());
    // Its processes end with the pipe, after the sample in hand.
    let is_alive = || {
        let here = desk.path(".").canonicalize().expect("a folder");
        let all = std::fs::read_dir("/proc").expect("processes");
        let folders =
            all.filter_map(|entry| std::fs::read_link(entry.ok()?.path().join("cwd")).ok());
        folders.into_iter().any(|folder| folder == here)
    };
    let started = std::time::Instant::now();
    while is_alive() && started.elapsed().as_secs() < 60 {
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert!(!is_alive(), "a process of it goes on");
    let merged = desk.run(&["merge", "killed", "--out", "all"]);
    merged.refused(&[&["killed: found no gate.json"]]);

    // The same command takes away what is left and begins anew; told to stop, it leaves no copy of a program.
    let mut command = desk.command(&[&["gate"][..], &QUICK, &sides].concat());
    let child = command.spawn().expect("the program starts");
    let copies = || {
        let names = std::fs::read_dir(desk.path("killed")).expect("a folder");
        let names = names.map(|entry| entry.expect("an entry").file_name().into_string());
        let of_process = |name: &String| name.starts_with("process-");
        names.filter_map(Result::ok).filter(of_process).count()
    };
    let is_new = || !desk.path("killed/process-00002").exists();
    while !is_new() && started.elapsed().as_secs() < 120 {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    while !is_timing() && started.elapsed().as_secs() < 120 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(copies() > 0, "it timed nothing");
    let mut terminate = std::process::Command::new("kill");
    let status = terminate.arg(child.id().to_string()).status();
    assert!(status.expect("kill runs").success());
    let ended = child.wait_with_output().expect("a child");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(143), "{said}");
    assert!(
        said.contains("stopped by SIGTERM: nothing is decided"),
        "{said}"
    );
    assert_eq!(copies(), 0);
    assert!(!desk.path("killed/gate.json").exists());
}

#[test]
fn a_full_disk_is_no_pass() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    measure(&desk, "a");
    measure(&desk, "b");
    let words = ["--base-run", "a", "--new-run", "b", "--out", "out"];
    // Files may have so many blocks of 512 bytes; who ignores the signal gets an error.
    let limited = |blocks: &str| {
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
        let mut shell = std::process::Command::new("sh");
        shell
            .args(["-c", &script, "sh"])
            .arg(env!("CARGO_BIN_EXE_terrafill"))
            .arg("gate")
            .args(words);
        shell
            .current_dir(desk.path("."))
            .stdin(std::process::Stdio::null());
        crate::harness::ran(&mut shell)
    };
    let full = limited("0");
    assert_eq!(full.code, 6, "{}{}", full.stdout, full.stderr);
    assert!(full.stderr.contains("gate.md"), "{}", full.stderr);
    assert!(!desk.path("out/gate.json").exists());
    // Negative control.
    assert_eq!(limited("unlimited").code, 0);
}

#[test]
fn two_processes_gate_a_shard_each_and_merge_refuses_what_is_not_all_of_it() {
    let desk = Desk::new();
    repeat(&desk);
    let scenes = [
        "california",
        "square-10m",
        "--technique",
        "vertex",
        "--size",
        "32",
    ];
    let shard = |of: &'static str, out: &'static str| {
        let sides = ["--base", "same", "--no-time", "--shard", of, "--out", out];
        [&["gate"][..], &scenes, &sides].concat()
    };
    let none = ["gate", "--base", "same", "--shard", "1/2"];
    desk.run(&none).refused(&[&["--shard needs the scenes"]]);
    desk.run(&shard("3/3", "x")).refused(&[&["found 2 scenes"]]);
    gate(&desk, &["california", "--shard", "1/2"]).refused(&[&["--shard needs --base"]]);
    if !has_device() {
        return;
    }
    let both = [("1/2", "one"), ("2/2", "two")].map(|(of, out)| {
        desk.command(&shard(of, out))
            .spawn()
            .expect("the program starts")
    });
    for child in both {
        let output = child.wait_with_output().expect("ended");
        assert!(output.status.success(), "{output:?}");
    }
    let whole = desk.run(&["merge", "two", "one", "--out", "all"]);
    assert_eq!(whole.code, 0, "{}{}", whole.stdout, whole.stderr);
    assert!(
        whole.stdout.starts_with("PASS (exit 0)"),
        "{}",
        whole.stdout
    );
    let json = desk.read_text("all/gate.json");
    for scene in ["filling/california/", "filling/square-10m/"] {
        assert!(json.contains(scene), "{scene}");
    }
    let merge = |parts: &[&str]| desk.run(&[&["merge"], parts, &["--out", "no"]].concat());
    merge(&["one"]).refused(&[&["shards 2 of 2 are missing"]]);
    merge(&["one", "one"]).refused(&[&["shard 1/2 is one too"]]);
    merge(&["one", "two", "all"]).refused(&[&["a whole gate"]]);
    assert!(!desk.path("no").exists());
}

#[test]
fn regions_of_a_file_become_one_scene_that_both_programs_run() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    repeat(&desk);
    let square = polygon(&rectangle(0.0, 0.01, 0.02, 0.03));
    desk.write("hoods.geojson", collection(&[("a", square)]));
    let same = desk.path("same").display().to_string();
    let options = [
        "--no-time",
        "--size",
        "48",
        "--technique",
        "vertex",
        "--out",
        "g",
    ];
    let line = ["hoods.geojson", "--edges", "great-ellipse", "--base", &same];
    let ran = gate(&desk, &[&line[..], &options].concat());
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    let report = desk.read_text("g/gate.json");
    assert!(
        report.contains("filling/hoods/horizon/vertex/doubled"),
        "{report}"
    );
    let scene = desk.read_text("target/gate/scenes/hoods.toml");
    assert!(scene.contains("edges = \"great-ellipse\""), "{scene}");
    // What a scene says itself is refused, and a file that is not there.
    gate(
        &desk,
        &["california", "--edges", "great-ellipse", "--base", &same],
    )
    .refused(&[&["--edges: found with a scene"]]);
    gate(&desk, &["none.geojson", "--base", &same]).refused(&[&["none.geojson", "no such file"]]);
}
