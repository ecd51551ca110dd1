// SPDX-License-Identifier: MIT OR Apache-2.0
//! Output that cannot be written: no verb ends as if it had been, and a reader who has seen enough is
//! no error.

use crate::harness::{Desk, Ran, collection, has_device, polygon, ran, rectangle};
use std::collections::BTreeSet;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use terrafill_results::made_up::{MadeUpRun, case_id};

/// A device that every write to fails on with "no space left".
const FULL: &str = "/dev/full";

/// Command lines of every verb, each of which prints something. `OUT` is a folder that is new each
/// time. `GPU`: only where there is a device.
const COMMANDS: [&str; 37] = [
    "--help",
    "--version",
    "help",
    "help mesh",
    "GPU bench california --quick --study filling --technique vertex --size 32 --samples 1 --out OUT",
    "report run",
    "merge part --out OUT",
    "gate --base-run run --new-run next --out OUT",
    "bless filling/moon/globe/vertex/doubled --reason meant --gate gated --blessed OUT",
    "compare run next",
    "compare run next --csv --html OUT",
    "compare run next --by device --html OUT",
    "history add run --store OUT --repository .",
    "history list --store kept",
    "history changes --store kept",
    "history report --store kept --out OUT",
    "history bisect filling/moon/globe/vertex/doubled --store kept",
    "history export --store kept --csv OUT",
    "history import tables --store OUT",
    "render --list-switches",
    "render --help",
    "mesh r.geojson",
    "mesh r.geojson --json",
    "locate r.geojson --points points.csv",
    "data list",
    "data list --json",
    // What it takes is said before the transfer, which fails: there is no such port.
    "data get blue-marble --to OUT --from http://127.0.0.1:65536",
    "scene init r.geojson",
    "scenes",
    "scenes --json",
    "studies",
    "studies --json",
    "studies --markdown",
    "techniques",
    "devices",
    "completions bash",
    "man OUT",
];

/// Hidden, and a verb all the same.
const HIDDEN: &str = "growth-sample square.geojson";

fn desk() -> Desk {
    let desk = Desk::new();
    let square = polygon(&rectangle(0.0, 0.0, 1.0, 1.0));
    desk.write("square.geojson", &square);
    desk.write("r.geojson", collection(&[("square", square)]));
    desk.write("points.csv", "lon,lat\n0.5,0.5\n");
    for (name, mismatched_px) in [("run", 3.0), ("part", 3.0), ("next", 4.0)] {
        let mut run = MadeUpRun::default();
        run.environment.commit = format!("{:040x}", name.len());
        let conditions = [
            ("scene", "moon"),
            ("view", "globe"),
            ("technique", "vertex"),
            ("role", "main"),
        ];
        run.case(case_id("filling", "moon/globe/vertex/doubled", &conditions))
            .figure("mismatched_px", mismatched_px)
            .timed("fill_cpu_ms", &[1.5]);
        run.write(&desk.path(name)).expect("written");
    }
    let plan = desk.read_text("part/plan.json");
    let part = plan.replace("\"shard\": null", "\"shard\": {\"index\": 1, \"count\": 1}");
    assert_ne!(part, plan, "a whole run became a shard");
    desk.write("part/plan.json", part);
    // What `history` reads.
    for line in [
        "history add run --store kept --repository .",
        "history export --store kept --csv tables",
    ] {
        assert_eq!(ran(&mut command(&desk, line, "")).code, 0, "{line}");
    }
    // What `bless` accepts.
    let runs = ["--base-run", "run", "--new-run", "next"];
    let gated = ran(&mut desk.command(&[&["gate"][..], &runs, &["--out", "gated"]].concat()));
    assert_eq!(gated.code, 1, "{}{}", gated.stdout, gated.stderr);
    desk
}

/// The command of a line, which writes into the new folder `out`.
fn command(desk: &Desk, line: &str, out: &str) -> Command {
    let words: Vec<&str> = line
        .split(' ')
        .filter(|word| *word != "GPU")
        .map(|word| if word == "OUT" { out } else { word })
        .collect();
    desk.command(&words)
}

/// A pipe that nobody reads any more.
fn closed_pipe() -> Stdio {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

fn full() -> Stdio {
    let file = File::options().write(true).open(FULL);
    file.expect("a device that is full").into()
}

/// Refused, with one line on standard error that says what could not be written.
fn says_what_was_not_written(ran: &Ran) -> Result<(), String> {
    let errors: Vec<&str> = ran
        .stderr
        .lines()
        .filter(|line| line.starts_with("error: "))
        .collect();
    match errors.as_slice() {
        [line]
            if ran.code == 2 && line.starts_with("error: standard output: cannot be written: ") =>
        {
            Ok(())
        }
        _ => Err(format!("exit code {}: {}", ran.code, ran.stderr)),
    }
}

#[test]
fn no_verb_ends_well_when_its_output_was_not_written() {
    if !Path::new(FULL).exists() {
        eprintln!("skipped: there is no {FULL}");
        return;
    }
    let has_device = has_device();
    let desk = desk();
    for (index, line) in COMMANDS.iter().chain([&HIDDEN]).enumerate() {
        if line.starts_with("GPU") && !has_device {
            continue;
        }
        let plain = ran(&mut command(&desk, line, &format!("plain-{index}")));
        assert!(!plain.stdout.is_empty(), "{line}: prints nothing");
        // Negative control: where it is written, the same command ends otherwise.
        assert!(says_what_was_not_written(&plain).is_err(), "{line}");
        let mut to_full = command(&desk, line, &format!("full-{index}"));
        says_what_was_not_written(&ran(to_full.stdout(full())))
            .unwrap_or_else(|found| panic!("{line}: {found}"));
        let mut unread = command(&desk, line, &format!("unread-{index}"));
        let unread = ran(unread.stdout(closed_pipe()));
        assert_eq!(
            (unread.code, &unread.stderr),
            (plain.code, &plain.stderr),
            "{line}"
        );
    }
}

#[test]
fn every_verb_is_among_them() {
    let help = Desk::new().run(&["--help"]).succeeded();
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let listed = listed.take_while(|line| !line.is_empty());
    let listed: BTreeSet<&str> = listed
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    let tried: BTreeSet<&str> = COMMANDS
        .iter()
        .filter_map(|line| line.trim_start_matches("GPU ").split(' ').next())
        .collect();
    let untried: Vec<&&str> = listed.difference(&tried).collect();
    assert!(untried.is_empty() && listed.len() > 9, "{untried:?}");
}

#[test]
fn pictures_and_folders_that_cannot_be_written_are_named() {
    if !Path::new(FULL).exists() {
        return;
    }
    let desk = desk();
    let render = ["render", "california", "--view", "globe", "--size", "8"];
    let reference = ["--technique", "reference", "--out"];
    let draw = |more: &[&str]| desk.run(&[&render[..], &reference, more].concat());
    let words: &[&str] = &["/dev/full: cannot be written: "];
    draw(&[FULL]).refused(&[words]);
    draw(&["a.png", "--ids", FULL]).refused(&[words]);
    draw(&["a.png", "--stats", FULL]).refused(&[words]);
    assert!(!desk.path("a.png").exists(), "all files or none");
    desk.run(&["merge", "part", "--out", "square.geojson/folder"])
        .refused(&[&["square.geojson/folder"]]);
    // Negative control.
    draw(&["/dev/null"]).succeeded();
    // Standard output as a file: a reader that closed it has seen enough.
    let words = [&render[..], &reference, &["/dev/stdout"]].concat();
    let unread = ran(desk.command(&words).stdout(closed_pipe()));
    assert_eq!((unread.code, unread.stderr.as_str()), (0, ""));
}

#[test]
fn an_error_that_cannot_be_printed_is_still_an_exit_code() {
    if !Path::new(FULL).exists() {
        return;
    }
    let desk = desk();
    for line in [
        "mesh none.geojson",
        "mesh",
        "mesh r.geojson --edges x",
        "report none",
    ] {
        for stderr in [full(), closed_pipe()] {
            let ran = ran(command(&desk, line, "out").stderr(stderr));
            assert_eq!(ran.code, 2, "{line}");
        }
    }
    // Negative control: what has nothing to complain about ends well.
    assert_eq!(
        ran(command(&desk, "mesh r.geojson", "out").stderr(full())).code,
        0
    );
}
