// SPDX-License-Identifier: MIT OR Apache-2.0
//! Programs made of a shell script, for tests: they verify by copying a made-up run, and in lock-step they answer
//! with times as given. So a whole gate runs in a second and needs no device.

use crate::{GateError, GateOptions, GateReport, GatedTime, Job, Program, Rules, Workload, gate};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::time::Duration;
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{Clock, Kind, Metric, Scope};

pub(crate) const METRICS: [Metric; 6] = [
    time("fill_cpu_ms", Scope::FRAME),
    time("fill_wall_ms", Scope::FRAME),
    time("stencil_gpu_ms", Scope::DRAW),
    time("plan_cpu_ms", Scope::PLAN),
    time("prepare_cpu_ms", Scope::PLAN.and(Scope::UPLOAD)),
    Metric::less("draws", "", Kind::Counter, "Draws."),
];

const fn time(name: &'static str, scope: Scope) -> Metric {
    Metric::less(name, "ms", Kind::Time, "Time.").covering(scope)
}

pub(crate) fn gated(_study: &str, _clock: Clock) -> Vec<GatedTime> {
    GatedTime::of(&METRICS, Some("fill_cpu_ms"))
}

/// What a program measures.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fake {
    /// Milliseconds of every sample.
    pub(crate) fill_cpu_ms: f64,
    /// How much longer the wall clock says.
    pub(crate) waits_ms: f64,
    /// Milliseconds of preparation.
    pub(crate) prepare_cpu_ms: f64,
    /// Milliseconds of planning.
    pub(crate) plan_cpu_ms: f64,
    /// A condition of its cases.
    pub(crate) surface: &'static str,
    /// Shell commands of a process before it does anything.
    pub(crate) before: &'static str,
}

impl Default for Fake {
    fn default() -> Self {
        Self {
            fill_cpu_ms: 10.0,
            waits_ms: 0.0,
            prepare_cpu_ms: 7.0,
            plan_cpu_ms: 0.5,
            surface: "ellipsoid",
            before: "",
        }
    }
}

/// What comes before the values of a program: `$out`, `$process` and `$list` are as `bench` is started with.
const START: &str = r#"#!/bin/sh
for word in "$@"; do
  case "$word" in --help) exit 0;; --process=*) process=${word#--process=};; esac
  case "$last" in --out) out=$word;; --time-only) list=$word;; esac
  last=$word
done
"#;

const STEPS: &str = r#"
if [ -z "$process" ]; then mkdir -p "$out"; cp -r "$verified"/. "$out"; exit 0; fi
places=0
printf ready
while read -r key || [ -n "$key" ]; do
  printf '\t%s' "$key"; eval "key_$places=\$key; n_$places=0"; places=$((places + 1))
done <"$list"
echo
while read -r turn place of; do
  case "$turn" in
    next) exit 0;;
    sample) eval "key=\$key_$place; n=\$((n_$place + 1)); n_$place=\$n"; rows >>"$out/measurements.csv";;
  esac
  echo over
done
"#;

impl Fake {
    /// Writes the program `name` with the run that it verifies.
    pub(crate) fn write(&self, place: &Path, name: &str) -> Program {
        let mut run = MadeUpRun {
            metrics: METRICS.to_vec(),
            ..MadeUpRun::default()
        };
        for view in ["globe", "near"] {
            let conditions = [
                ("scene", "square"),
                ("view", view),
                ("technique", "vertex"),
                ("surface", self.surface),
            ];
            let case = run.case(case_id(
                "filling",
                &format!("square/{view}/vertex"),
                &conditions,
            ));
            case.samples = 1;
            // No two runs are equal to the last bit.
            let own = f64::from(name.as_bytes()[0]) * 1e-9;
            case.figure("draws", 3.0)
                .figure("prepare_cpu_ms", self.prepare_cpu_ms)
                .figure("plan_cpu_ms", self.plan_cpu_ms)
                .timed("fill_cpu_ms", &[self.fill_cpu_ms + own])
                .timed("fill_wall_ms", &[self.fill_cpu_ms + self.waits_ms])
                .timed("stencil_gpu_ms", &[0.5 * self.fill_cpu_ms]);
        }
        let verified = place.join(format!("{name}-verified"));
        run.write(&verified).expect("a run");
        let (of, ms, before) = (verified.display(), self.fill_cpu_ms, self.before);
        let rows = [
            ("fill_cpu_ms", ms),
            ("fill_wall_ms", ms + self.waits_ms),
            ("stencil_gpu_ms", 0.5 * ms),
        ];
        let rows = rows.map(|(metric, ms)| format!("echo \"$key,{metric},$process,$n,{ms}\";"));
        let rows = format!("rows() {{ {} }}", rows.join(" "));
        let script = format!("{START}verified='{of}'\n{rows}\n{before}\n{STEPS}");
        let path = place.join(name);
        std::fs::write(&path, script).expect("written");
        let executable = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(&path, executable).expect("set");
        Program {
            path,
            asked: name.to_owned(),
            commit: None,
        }
    }
}

pub(crate) fn options() -> GateOptions {
    GateOptions {
        times: true,
        advisory: false,
        floors_percent: [3.0, 10.0, 50.0, 50.0],
        budget: Duration::from_secs(600),
        is_part: false,
    }
}

/// Gates two programs in the folder `out` of `place`.
pub(crate) fn gate_in(
    place: &Path,
    out: &str,
    base: &Fake,
    new: &Fake,
    rules: &Rules<'_>,
) -> Result<GateReport, GateError> {
    let programs = [base.write(place, "old"), new.write(place, "new")];
    let names = ["old", "new"].map(str::to_owned);
    let workload = Workload {
        samples: 30,
        frames: 1,
        ..Workload::default()
    };
    let mut say = |_: &str| {};
    let mut job = Job::new(programs, workload, &place.join(out), &mut say)?;
    gate(&mut job, names, &options(), rules, &gated)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Finding, Verdict};
    use std::collections::BTreeSet;

    const NO_RULES: Rules<'_> = Rules {
        limits: &[],
        blessings: &[],
    };

    /// Verdict and sentences of a gate of the usual program against this one.
    fn found(new: Fake) -> (Verdict, Vec<String>) {
        let place = tempfile::tempdir().expect("a folder");
        let old = Fake::default();
        let report = gate_in(place.path(), "out", &old, &new, &NO_RULES).expect("a verdict");
        let sentences = report.findings.iter().map(Finding::sentence);
        (report.verdict, sentences.collect())
    }

    #[test]
    fn what_waits_or_prepares_or_plans_longer_is_called_by_its_name() {
        let usual = Fake::default();
        for (new, start) in [
            (
                Fake {
                    prepare_cpu_ms: 35.0,
                    ..usual
                },
                "prepare_cpu_ms 7.000 ms → 35.000 ms: preparation, +400.0 %",
            ),
            (
                Fake {
                    plan_cpu_ms: 1.0,
                    ..usual
                },
                "plan_cpu_ms 0.500 ms → 1.000 ms: planning, +100.0 %",
            ),
            // It sleeps 2 ms a frame, and then for two thirds of it.
            (
                Fake {
                    waits_ms: 2.0,
                    ..usual
                },
                "fill_wall_ms 10.000 ms → 12.000 ms: frame by the wall clock, +20.0 %",
            ),
            (
                Fake {
                    waits_ms: 20.0,
                    ..usual
                },
                "fill_wall_ms 10.000 ms → 30.000 ms: frame by the wall clock, +200.0 %",
            ),
        ] {
            let (verdict, sentences) = found(new);
            assert_eq!(verdict, Verdict::Regression, "{sentences:?}");
            assert_eq!(sentences.len(), 2, "one for each view: {sentences:?}");
            let is_so = |sentence: &String| sentence.starts_with(start);
            assert!(sentences.iter().all(is_so), "{start}: {sentences:?}");
        }
        // Negative control: below the floors of their own, above that of the frame.
        let little = Fake {
            waits_ms: 0.7,
            prepare_cpu_ms: 9.0,
            plan_cpu_ms: 0.6,
            ..usual
        };
        assert_eq!(found(little), (Verdict::Pass, Vec::new()));
    }

    #[test]
    fn a_slower_frame_says_in_which_stage() {
        let slower = Fake {
            fill_cpu_ms: 10.8,
            ..Fake::default()
        };
        let (verdict, sentences) = found(slower);
        assert_eq!(verdict, Verdict::Regression);
        let sentence = &sentences[0];
        assert!(
            sentence.starts_with("fill_cpu_ms 10.000 ms → 10.800 ms: frame, +8.0 %"),
            "{sentence}"
        );
        assert!(sentence.ends_with("stencil +0.400 ms"), "{sentence}");
    }

    fn refused(base: Fake, new: Fake) -> GateError {
        let place = tempfile::tempdir().expect("a folder");
        gate_in(place.path(), "out", &base, &new, &NO_RULES).expect_err("no verdict")
    }

    #[test]
    fn a_base_that_lacks_an_option_or_is_killed_never_passes() {
        let usual = Fake::default();
        let lacks = Fake {
            before: r#"echo "error: unexpected argument '--processes' found" >&2; exit 2"#,
            ..usual
        };
        let error = refused(lacks, usual);
        assert_eq!(error.exit_code(), 2, "{error}");
        assert!(
            error.to_string().starts_with("base program old: "),
            "{error}"
        );
        assert!(error.to_string().contains("'--processes' found"), "{error}");
        // Memory or the disk ran out: of a verifying process, and of a timing one.
        let killed = Fake {
            before: "kill -9 $$",
            ..usual
        };
        assert_eq!(refused(killed, usual).exit_code(), 6);
        let full = Fake {
            before: r#"[ -n "$process" ] && { echo "error: x.csv: No space left on device (os error 28)" >&2; exit 2; }"#,
            ..usual
        };
        let error = refused(usual, full);
        assert_eq!(error.exit_code(), 6, "{error}");
        // Negative control: one that breaks off by itself.
        let broken = Fake {
            before: r#"[ -n "$process" ] && exit 2"#,
            ..usual
        };
        assert_eq!(refused(usual, broken).exit_code(), 2);
    }

    #[test]
    fn a_change_of_the_plan_under_the_same_name_is_inconclusive() {
        let edited = Fake {
            surface: "tiles",
            ..Fake::default()
        };
        let (verdict, sentences) = found(edited);
        assert_eq!(verdict, Verdict::Inconclusive);
        assert_eq!(
            sentences[0],
            "status ellipsoid → tiles: another surface under the same name: its work is not compared"
        );
    }

    #[test]
    fn every_timing_process_reads_as_much_as_every_other_one() {
        let place = tempfile::tempdir().expect("a folder");
        // What it has to read, and what the folder that all processes of the base could share has.
        let logged = Fake {
            before: r#"if [ -n "$process" ]; then
              cat "$out"/*.* | wc -c >>"$verified/../read"; cat "$out/../../base"/*.* | wc -c >>"$verified/../common"
              printf '%s' "$0 $*" | wc -c >>"$verified/../words"
            fi"#,
            ..Fake::default()
        };
        let of = |name: &str| -> Vec<u64> {
            let text = std::fs::read_to_string(place.path().join(name)).expect(name);
            text.lines()
                .map(|line| line.trim().parse().expect("a number"))
                .collect()
        };
        let report = gate_in(place.path(), "out", &logged, &logged, &NO_RULES).expect("a verdict");
        assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.findings);
        let read = of("read");
        assert_eq!(read.len(), 15, "five blocks of three");
        assert!(read.iter().all(|bytes| *bytes == read[0]), "{read:?}");
        let words: BTreeSet<u64> = of("words").into_iter().collect();
        assert_eq!(words.len(), 1, "command lines of one length: {words:?}");
        // Negative control: the shared folder grows from block to block.
        let shared = of("common");
        assert!(
            shared[14] > shared[3] && shared[3] > shared[0],
            "{shared:?}"
        );
        // Nothing of the processes is left but their measurements.
        let left = std::fs::read_dir(place.path().join("out"))
            .expect("a folder")
            .count();
        assert_eq!(left, 2);
    }
}
