// SPDX-License-Identifier: MIT OR Apache-2.0
//! Parts of gates: which scenes each has, and which reports are refused.

use super::*;
use crate::made_up_report::finding;
use crate::{CaseTime, GATE_SCHEMA, Gate, Severity, TimeGate, Verdict, write_files};

fn scenes(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn part(index: usize, count: usize, all: &[&str]) -> Result<GateShard, GateError> {
    GateShard::new(Shard { index, count }, &scenes(all), None)
}

fn report(part: Option<GateShard>) -> GateReport {
    let of = part.as_ref().map_or(&[][..], |part| &part.scenes);
    GateReport {
        schema: GATE_SCHEMA,
        verdict: Verdict::Pass,
        base: "a".to_owned(),
        new: "b".to_owned(),
        commits: ["a", "b"].map(str::to_owned),
        device: "llvmpipe".to_owned(),
        compared: of
            .iter()
            .map(|scene| format!("filling/{scene}/globe/x"))
            .collect(),
        figures: 3,
        part,
        ..GateReport::default()
    }
}

/// Writes the reports and merges them.
fn merged(reports: &[&GateReport]) -> Result<GateReport, GateError> {
    let place = tempfile::tempdir().expect("a folder");
    let folder = |index: usize| place.path().join(format!("part-{index}"));
    for (index, report) in reports.iter().enumerate() {
        write_files(report, &folder(index)).expect("written");
    }
    let folders: Vec<PathBuf> = (0..reports.len()).map(folder).collect();
    merge_gates(&folders)
}

const ALL: [&str; 5] = ["a", "b", "c", "d", "e"];

#[test]
fn parts_hold_every_scene_once_and_too_many_parts_are_refused() {
    for count in 1..=ALL.len() {
        let parts = (1..=count).map(|index| part(index, count, &ALL).expect("a part").scenes);
        let mut all: Vec<String> = parts.flatten().collect();
        all.sort();
        assert_eq!(all, scenes(&ALL));
    }
    for (index, count, all) in [(1, 6, &ALL[..]), (1, 1, &[]), (1, 2, &["a", "b", "a"])] {
        assert_eq!(part(index, count, all).expect_err("refused").exit_code(), 2);
    }
}

#[test]
fn an_earlier_gate_balances_the_parts() {
    let time = |case: &str, ms: f64| CaseTime {
        case: format!("filling/{case}/globe/x"),
        base_ms: Some(ms),
        new_ms: Some(ms),
        ..CaseTime::default()
    };
    let costs = [("a", 8.0), ("b", 1.0), ("c", 2.0), ("d", 3.0), ("e", 2.0)];
    let earlier = GateReport {
        time: Some(TimeGate {
            cases: costs.map(|(scene, ms)| time(scene, ms)).to_vec(),
            ..TimeGate::default()
        }),
        ..report(None)
    };
    let shard = |index| Shard { index, count: 2 };
    let of = |index| GateShard::new(shard(index), &scenes(&ALL), Some(&earlier));
    assert_eq!(of(1).expect("a part").scenes, ["a"]);
    assert_eq!(of(2).expect("a part").scenes, ["d", "c", "e", "b"]);
    // Negative control: without it the parts are as even in number as can be.
    assert_eq!(part(1, 2, &ALL).expect("a part").scenes.len(), 3);
}

#[test]
fn the_parts_come_together_with_the_worst_verdict() {
    let [first, mut second] = [1, 2].map(|index| report(part(index, 2, &ALL).ok()));
    let whole = merged(&[&second, &first]).expect("merged");
    assert_eq!((whole.verdict, whole.exit_code), (Verdict::Pass, 0));
    assert_eq!((whole.compared.len(), whole.figures), (5, 6));
    assert_eq!(whole.part, None);
    let finding = |severity| finding("filling/b/globe/x", severity, Gate::Counters);
    second.findings = vec![finding(Severity::Unknown)];
    assert_eq!(merged(&[&first, &second]).expect("merged").exit_code, 3);
    second.findings.push(finding(Severity::Worse));
    assert_eq!(merged(&[&first, &second]).expect("merged").exit_code, 1);
}

#[test]
fn a_blessing_is_unused_only_where_no_part_uses_it() {
    let [mut first, mut second] = [1, 2].map(|index| report(part(index, 2, &ALL).ok()));
    first.idle_blessings = scenes(&["unused: x", "unused: y"]);
    second.idle_blessings = scenes(&["unused: y", "stale: z"]);
    let whole = merged(&[&first, &second]).expect("merged");
    assert_eq!(whole.idle_blessings, ["unused: y", "stale: z"]);
}

#[test]
fn missing_repeated_and_foreign_parts_are_refused() {
    let [first, second] = [1, 2].map(|index| report(part(index, 2, &ALL).ok()));
    let of_three = report(part(3, 3, &ALL).ok());
    let of_others = report(part(2, 2, &["a", "b"]).ok());
    let of = |change: &dyn Fn(&mut GateReport)| {
        let mut other = second.clone();
        change(&mut other);
        other
    };
    let commit = of(&|other| other.commits[1] = "c".to_owned());
    let device = of(&|other| other.device = "another".to_owned());
    let timed = of(&|other| other.time = Some(TimeGate::default()));
    let packed = of(&|other| {
        if let Some(part) = &mut other.part {
            part.scenes = scenes(&["a", "b"]);
        }
    });
    let longer = of(&|other| other.options.push("more=1".to_owned()));
    let cases: [(&[&GateReport], &str); 11] = [
        (&[], "are missing"),
        (&[&first], "shards 2 of 2 are missing"),
        (&[&first, &second, &second], "part-1 too, allowed: once"),
        (&[&first, &report(None)], "a whole gate"),
        (
            &[&first, &of_three],
            "found \"3 shards\", expected \"2 shards\"",
        ),
        (&[&first, &longer], "\"more=1\""),
        (&[&first, &of_others], "over a b"),
        (&[&first, &commit], "found \"c\", expected \"b\""),
        (&[&first, &device], "\"another\""),
        (&[&first, &timed], "\"not timed\""),
        (&[&first, &packed], "--balance-by"),
    ];
    for (parts, words) in cases {
        let error = merged(parts).expect_err(words);
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains(words), "{words}: {error}");
    }
    // One that was killed has runs and no verdict.
    let place = tempfile::tempdir().expect("a folder");
    std::fs::create_dir_all(place.path().join("base")).expect("a folder");
    let error = merge_gates(&[place.path().to_owned()]).expect_err("killed");
    assert!(error.to_string().contains("found no gate.json"), "{error}");
}

#[test]
fn a_limit_is_about_nothing_where_no_part_has_its_case() {
    let of = |index, unmatched: &[&str]| GateReport {
        unmatched_limits: scenes(unmatched),
        ..report(Some(part(index, 2, &ALL).expect("a part")))
    };
    let whole = merged(&[&of(1, &["a", "b"]), &of(2, &["c"])]).expect("each is of one part");
    assert_eq!(whole.unmatched_limits, [""; 0]);
    let error = merged(&[&of(1, &["a", "b"]), &of(2, &["b"])]).expect_err("no part has it");
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("in either run for b"), "{error}");
}
