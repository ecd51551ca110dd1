// SPDX-License-Identifier: MIT OR Apache-2.0
//! The commands of README.md and docs/using.md, and the script of the latter, run as they stand there.

use crate::harness::{Desk, has_device, ran};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

fn page(name: &str) -> String {
    std::fs::read_to_string(repository().join(name)).expect(name)
}

/// First cells of the table of commands.
fn commands(readme: &str) -> Vec<&str> {
    readme
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once("` |"))
        .map(|(command, _)| command)
        .filter(|command| command.starts_with("terrafill ") || command.contains(" > "))
        .collect()
}

/// The second block of shell lines: how to build, and how to measure data of one's own.
fn second_block(readme: &str) -> &str {
    let block = readme.split("```sh\n").nth(2);
    block
        .and_then(|block| block.split("```").next())
        .expect("two blocks")
}

/// A folder with what a clone has and the commands need.
fn clone() -> Desk {
    let desk = Desk::new();
    for folder in ["bench-scenes", "bench-scenes/extreme"] {
        for entry in std::fs::read_dir(repository().join(folder)).expect(folder) {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                continue;
            }
            let name = path.file_name().expect("a name").to_string_lossy();
            let content = std::fs::read(&path).expect("readable");
            desk.write(&format!("{folder}/{name}"), content);
        }
    }
    desk
}

/// What cuts a bench of the README to a moment, where the line does not say it itself. It draws small pictures, one sample
/// in one process, one study, no ablation and no matrix. Where the line names no study, it has one technique. Of a full
/// run it draws a third of the groups.
const HASTE: [(&str, &str); 8] = [
    ("--size", "48"),
    ("--samples", "1"),
    ("--processes", "1"),
    ("--technique", "vertex"),
    ("--study", "filling"),
    ("--ablation", "none"),
    ("--matrix", "none"),
    ("--shard", "1/3"),
];

/// Runs a line in a shell that finds the program first in its path.
fn run_line(desk: &Desk, line: &str) -> Result<(), String> {
    let program = Path::new(env!("CARGO_BIN_EXE_terrafill"));
    let folder = program.parent().expect("a folder").display();
    let path = std::env::var("PATH").unwrap_or_default();
    let mut haste = String::new();
    for (option, value) in HASTE {
        let is_said = line.contains(option)
            || (option == "--technique" && line.contains("--study"))
            || (option == "--shard" && !line.contains("--full"));
        if line.starts_with("terrafill bench") && !is_said {
            haste += &format!(" {option} {value}");
        }
    }
    let ran = ran(Command::new("sh")
        .args(["-c", &format!("{line}{haste}")])
        .current_dir(desk.path(""))
        .env("PATH", format!("{folder}:{path}"))
        .env_remove("TERRAFILL_DATA")
        .stdin(Stdio::null()));
    if ran.code == 0 {
        Ok(())
    } else {
        Err(format!("{line}: {}: {}", ran.code, ran.stderr))
    }
}

/// The same into another folder, as one page has it and the other, shows nothing new.
fn without_output(command: &str) -> String {
    let mut words = command.split(' ');
    let mut kept = Vec::new();
    while let Some(word) = words.next() {
        if word == "--out" {
            words.next();
        } else {
            kept.push(word);
        }
    }
    kept.join(" ")
}

#[test]
fn commands_that_differ_in_their_output_alone_are_one() {
    let run = "terrafill bench planet-134 --out out/a";
    assert_eq!(without_output(run), "terrafill bench planet-134");
    // Negative control: what stands behind the folder counts.
    let resumed = "terrafill bench planet-134 --out out/a --resume";
    assert_ne!(without_output(resumed), without_output(run));
}

#[test]
fn every_command_of_the_tables_runs_as_written() {
    if !has_device() {
        return;
    }
    let pages = ["README.md", "docs/using.md"].map(page);
    let mut commands: Vec<&str> = pages.iter().flat_map(|page| commands(page)).collect();
    let own_data = second_block(&pages[0]).lines().last().expect("a line");
    assert!(own_data.contains(" --terrain "), "{own_data}");
    commands.push(own_data);
    for verb in [
        "data",
        "scenes",
        "studies",
        "techniques",
        "devices",
        "bench",
        "report",
        "render",
        "mesh",
        "locate",
    ] {
        let used = commands
            .iter()
            .any(|command| command.split(' ').nth(1) == Some(verb));
        assert!(used, "{verb}: {commands:?}");
    }
    let desk = clone();
    let mut known = BTreeSet::new();
    for command in commands {
        if known.insert(without_output(command)) {
            assert_eq!(run_line(&desk, command), Ok(()));
        }
    }
    for output in [
        "out/first/index.html",
        "out/mine/index.html",
        "out/run/index.html",
        "california.png",
        "regions.png",
    ] {
        assert!(desk.path(output).is_file(), "{output}");
    }
}

#[test]
fn a_command_that_does_not_run_is_noticed() {
    let table = "| `terrafill mesh none --json` | x |\n| `crates/` | y |\n";
    let commands = commands(table);
    assert_eq!(commands, ["terrafill mesh none --json"]);
    assert!(run_line(&clone(), commands[0]).is_err());
}

/// Fastest correct technique of each scene and view, with its bytes and its error, as docs/using.md has it.
const FASTEST: &str = r#"import pandas as pd
cases, rows = pd.read_csv("out/run/cases.csv"), pd.read_csv("out/run/measurements.csv")
wide = rows.pivot_table(index="case", columns="metric", values="value", aggfunc="median").reset_index()
right = cases[(cases.status == "ok") & cases.repeats.isna()].merge(wide, on="case").dropna(subset=["fill_cpu_ms", "mismatched_px"])
print(right.loc[right.groupby(["scene", "view"]).fill_cpu_ms.idxmin(), ["scene", "view", "technique", "variant", "fill_cpu_ms", "geometry_bytes", "mismatched_px"]].to_string(index=False))
"#;

type Record = BTreeMap<String, String>;

fn records(desk: &Desk, name: &str) -> Vec<Record> {
    let text = desk.read_text(name);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let rows = reader.deserialize().map(|row| row.expect("a row"));
    rows.collect()
}

/// The script's answer from the same two tables: scene, view, technique and variant.
fn fastest(desk: &Desk) -> Vec<[String; 4]> {
    let mut values: BTreeMap<[String; 2], Vec<f64>> = BTreeMap::new();
    for row in records(desk, "out/run/measurements.csv") {
        let value = row["value"].parse().expect("a number");
        let key = [row["case"].clone(), row["metric"].clone()];
        values.entry(key).or_default().push(value);
    }
    let value = |case: &str, metric: &str| {
        let all = values.get(&[case.to_owned(), metric.to_owned()])?;
        terrafill_results::median(all)
    };
    let mut best: BTreeMap<[String; 2], (f64, [String; 4])> = BTreeMap::new();
    for case in records(desk, "out/run/cases.csv") {
        if case["status"] != "ok" || !case["repeats"].is_empty() {
            continue;
        }
        let figures = ["fill_cpu_ms", "geometry_bytes", "mismatched_px"];
        let [Some(ms), Some(_), Some(_)] = figures.map(|metric| value(&case["case"], metric))
        else {
            continue;
        };
        let view = ["scene", "view"].map(|key| case[key].clone());
        let name = ["scene", "view", "technique", "variant"].map(|key| case[key].clone());
        if best.get(&view).is_none_or(|(best_ms, _)| ms < *best_ms) {
            best.insert(view, (ms, name));
        }
    }
    best.into_values().map(|(_, name)| name).collect()
}

/// Why the script cannot be run here; `None` where it can.
fn lacks_pandas() -> Option<String> {
    let import = Command::new("python3")
        .args(["-c", "import pandas"])
        .output();
    match import {
        Err(error) => Some(format!("python3: {error}")),
        Ok(output) if !output.status.success() => {
            let why = String::from_utf8_lossy(&output.stderr);
            Some(why.lines().last().unwrap_or_default().to_owned())
        }
        Ok(_) => None,
    }
}

/// Whether a line of the table that the script prints has these words in this order.
fn has_row(printed: &str, name: &[String; 4]) -> bool {
    printed.lines().any(|line| {
        let mut words = line.split_whitespace();
        name.iter().all(|word| words.any(|found| found == word))
    })
}

#[test]
fn the_script_finds_the_fastest_correct_technique_of_every_view() {
    let fenced = format!("```python\n{FASTEST}```\n");
    assert!(
        page("docs/using.md").contains(&fenced),
        "docs/using.md has other lines"
    );
    assert_eq!(FASTEST.lines().count(), 5);
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let bench = ["bench", "california", "--quick", "--size", "64"];
    let options = ["--samples", "2", "--out", "out/run"];
    desk.run(&[&bench[..], &options].concat()).succeeded();
    let fastest = fastest(&desk);
    let views = fastest.iter().map(|[scene, view, ..]| [scene, view]);
    let expected = ["globe", "horizon", "top-down"].map(|view| ["california", view]);
    assert_eq!(views.collect::<Vec<_>>(), expected);
    if let Some(why) = lacks_pandas() {
        eprintln!("the script itself is not run: {why}");
        return;
    }
    desk.write("fastest.py", FASTEST);
    let script = Command::new("python3")
        .arg("fastest.py")
        .current_dir(desk.path(""))
        // Where pandas would leave columns out of a table that is not made a text of.
        .env("COLUMNS", "80")
        .output();
    let script = script.expect("python3 starts");
    let printed = String::from_utf8_lossy(&script.stdout);
    let complaint = String::from_utf8_lossy(&script.stderr);
    assert!(script.status.success(), "{complaint}");
    for name in &fastest {
        assert!(has_row(&printed, name), "{name:?} is not in {printed}");
        // Negative control: another technique is not found.
        let mut other = name.clone();
        other[2] = "metal".to_owned();
        assert!(!has_row(&printed, &other));
    }
}

/// Rows of a table of features, and those with a yes.
fn features(text: &str) -> (usize, usize) {
    let rows = text.lines().filter(|line| {
        let first = line.split('|').nth(1).unwrap_or_default().trim();
        first.parse::<usize>().is_ok()
    });
    let answers: Vec<&str> = rows
        .filter_map(|row| row.split('|').nth(3).map(str::trim))
        .collect();
    assert!(answers.iter().all(|answer| ["yes", "no"].contains(answer)));
    let yes = answers.iter().filter(|answer| **answer == "yes").count();
    (answers.len(), yes)
}

#[test]
fn the_table_of_features_counts_itself() {
    let path = repository().join("docs/features.md");
    let text = std::fs::read_to_string(path).expect("readable");
    let (all, yes) = features(&text);
    assert_eq!(all, 48);
    let head = text.replace('\n', " ");
    let counted = format!("has {yes} and lacks {}", all - yes);
    assert!(head.contains(&counted), "found {counted}");
    // Negative control: one answer turned.
    let turned = text.replacen("| yes |", "| no |", 1);
    assert_eq!(features(&turned), (all, yes - 1));
}
