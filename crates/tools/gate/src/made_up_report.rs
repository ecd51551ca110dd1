// SPDX-License-Identifier: MIT OR Apache-2.0
//! Made-up reports, for the tests of everything that shows one.

use crate::{Finding, GATE_SCHEMA, Gate, GateReport, Severity, verdict};

pub(crate) fn finding(case: &str, severity: Severity, gate: Gate) -> Finding {
    Finding {
        case: case.to_owned(),
        conditions: [("scene", "california"), ("technique", "vertex")]
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .into(),
        metric: "draws".to_owned(),
        gate,
        severity,
        from: "3".to_owned(),
        to: "6".to_owned(),
        words: "+100 %, a | b".to_owned(),
        ..Finding::default()
    }
}

pub(crate) fn report(findings: Vec<Finding>) -> GateReport {
    let verdict = verdict(&findings, 2);
    GateReport {
        schema: GATE_SCHEMA,
        verdict,
        exit_code: verdict.exit_code(),
        base: "main (4e23c86)".to_owned(),
        new: "topic (abcdef0)".to_owned(),
        commits: ["4e23c86", "abcdef0"].map(str::to_owned),
        options: vec!["size=512x512".to_owned()],
        part: None,
        device: "llvmpipe, Mesa 25".to_owned(),
        clock: "process CPU time".to_owned(),
        compared: vec!["filling/a".to_owned(), "filling/b".to_owned()],
        figures: 60,
        skipped: vec![("filling/c".to_owned(), "no data".to_owned())],
        findings,
        time: None,
        pictures: Vec::new(),
        idle_blessings: vec!["unused: filling/z, draws 1 → 2".to_owned()],
        unmatched_limits: Vec::new(),
        elapsed_s: 12.0,
        see: "terrafill compare out/gate/base out/gate/new".to_owned(),
    }
}
