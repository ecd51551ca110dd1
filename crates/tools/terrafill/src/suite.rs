// SPDX-License-Identifier: MIT OR Apache-2.0
//! `bench --suite`: a process that runs the scenes, and this one, which outlives its crashes.
//!
//! A panic is caught where it happens. What no process survives (a fault in a driver, a kill for want of
//! memory) and what never ends costs one case: it is written down as failed, and another process goes on
//! with the next.

use crate::arguments::BenchArguments;
use crate::outcome::{Failure, Outcome, complain};
use crate::registry::chapters;
use crate::report::print_report;
use crate::stop::{STOPPED_ENDS, say_when_stopped};
use crate::techniques::terms;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use terrafill_filling::{IN_HAND, extreme_sentence};
use terrafill_results::{Run, RunFolder};

/// A case that takes longer is taken for one that never ends: the slowest of them takes a tenth of this
/// on two cores.
const MAX_CASE: Duration = Duration::from_secs(240);

/// How often the process is looked after.
const GLANCE: Duration = Duration::from_millis(200);

/// Exit codes of a process that ended by itself without a result: bad input, no usable device.
const OWN_ENDS: [i32; 3] = [2, 4, 5];

pub(crate) fn run(arguments: &BenchArguments) -> Result<Outcome, Failure> {
    let out = &arguments.out;
    say_when_stopped(out)?;
    let mut is_first = true;
    loop {
        let ended = run_once(out, !is_first && !arguments.resume)?;
        match ended {
            Ended::Done => break,
            Ended::Own(code) => {
                return Err(Failure {
                    outcome: Outcome::from_code(code),
                    message: "the suite was not run".to_owned(),
                });
            }
            Ended::Stopped(code) => std::process::exit(code),
            Ended::Broken(why) => {
                let case = fail_case_in_hand(out, &why)?;
                complain(format!("{case}: {why}; going on with the next"));
            }
        }
        is_first = false;
    }
    // A run that is whole has no case in hand.
    drop(std::fs::remove_file(out.join(IN_HAND)));
    let run = Run::load(out).map_err(Failure::bad_input)?;
    let sentence = extreme_sentence(&run).unwrap_or_default();
    print_report(
        terrafill_report::write(out, &chapters(), terms()),
        &format!("{sentence}\n"),
        arguments.open,
    )
}

/// How a process ended.
enum Ended {
    /// Every case has its row.
    Done,
    /// It said why and has this exit code.
    Own(u8),
    /// Told to stop, which is no case's fault; it said so, and has this exit code.
    Stopped(i32),
    /// In the middle of a case.
    Broken(String),
}

/// - `goes_on`: with the run that an earlier process began
fn run_once(out: &Path, goes_on: bool) -> Result<Ended, Failure> {
    let this = std::env::current_exe().map_err(Failure::bad_input)?;
    let mut command = Command::new(this);
    command.args(std::env::args_os().skip(1)).arg("--in-suite");
    if goes_on {
        command.arg("--resume");
    }
    // Silence of the layer is part of what is asked, unless somebody says otherwise.
    if std::env::var_os("TERRAFILL_VALIDATION").is_none() {
        command.env("TERRAFILL_VALIDATION", "1");
    }
    // Ends with this process, see `lines_of_first_process`.
    command.stdin(Stdio::piped());
    let mut child = command.spawn().map_err(Failure::bad_input)?;
    let Some(status) = wait(&mut child, out)? else {
        let seconds = MAX_CASE.as_secs();
        return Ok(Ended::Broken(format!("did not end within {seconds} s")));
    };
    Ok(match status.code() {
        Some(0) => Ended::Done,
        Some(code) if STOPPED_ENDS.contains(&code) => Ended::Stopped(code),
        Some(code) if OWN_ENDS.contains(&code) => Ended::Own(u8::try_from(code).unwrap_or(2)),
        _ => Ended::Broken(format!("the process crashed: {status}")),
    })
}

/// Waits for a process; ends one whose case in hand stays the same for [`MAX_CASE`], and gives `None`.
fn wait(child: &mut Child, out: &Path) -> Result<Option<ExitStatus>, Failure> {
    let in_hand = out.join(IN_HAND);
    let mut last: Option<std::time::SystemTime> = None;
    let mut since = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(Failure::bad_input)? {
            return Ok(Some(status));
        }
        let written = std::fs::metadata(&in_hand).and_then(|facts| facts.modified());
        let written = written.ok();
        if written != last {
            (last, since) = (written, Instant::now());
        }
        if since.elapsed() > MAX_CASE {
            child.kill().map_err(Failure::bad_input)?;
            child.wait().map_err(Failure::bad_input)?;
            return Ok(None);
        }
        std::thread::sleep(GLANCE);
    }
}

/// Writes the case that a process died in down as failed: the one it named, or the first without a row
/// where that one has failed already. Each death costs a case, so that the suite comes to its end.
fn fail_case_in_hand(out: &Path, why: &str) -> Result<String, Failure> {
    let named = std::fs::read_to_string(out.join(IN_HAND)).unwrap_or_default();
    let run = Run::load(out).map_err(Failure::bad_input)?;
    let has_failed = |key: &str| {
        let case = run.case(key);
        case.and_then(|case| case.status()) == Some(terrafill_results::Status::Failed)
    };
    let folder = RunFolder::open(out).map_err(Failure::bad_input)?;
    let planned = &folder.plan().cases;
    let case = planned
        .iter()
        .find(|case| case.id.key() == named && !has_failed(&named));
    let without_row = || {
        let mut cases = planned.iter();
        cases.find(|case| {
            let found = run.case(&case.id.key());
            found.and_then(|found| found.status()).is_none()
        })
    };
    let case = case
        .or_else(without_row)
        .ok_or_else(|| Failure::bad_input(format!("{why}, after its last case")))?;
    folder.fail_case(case, why).map_err(Failure::bad_input)?;
    Ok(case.id.key())
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::{
        CaseId, Outcome as Came, PlannedCase, RunEnvironment, RunPlan, SCHEMA, Status,
    };

    #[test]
    fn each_death_costs_the_case_in_hand_and_no_other() {
        let place = tempfile::tempdir().expect("a folder");
        let case = |name: &str| PlannedCase {
            id: CaseId::new("extreme", name, [("scene", name.to_owned())]),
            samples: 1,
            may_be_wrong: false,
        };
        let plan = RunPlan {
            cases: ["a", "b", "c"].map(case).into(),
            skipped: Vec::new(),
            processes: 1,
            warm_up: 0,
            seed: 1,
            shard: None,
        };
        let environment = RunEnvironment {
            schema: SCHEMA,
            ..RunEnvironment::default()
        };
        let folder = RunFolder::create(place.path(), environment, plan, crate::registry::metrics());
        let folder = folder.expect("a new folder");
        let in_hand = |key: &str| std::fs::write(place.path().join(IN_HAND), key).expect("written");
        let ended = || {
            let run = Run::load(place.path()).expect("a run");
            let cases = run.cases.iter().map(|case| case.outcome);
            cases.collect::<Vec<_>>()
        };
        folder
            .append_case(&case("a"), Status::Skipped, "no data")
            .expect("a row");
        in_hand("extreme/b");
        let fail = || fail_case_in_hand(place.path(), "the process crashed: signal 11");
        assert_eq!(fail().ok().as_deref(), Some("extreme/b"));
        assert_eq!(ended(), [Came::Skipped, Came::Failed, Came::Missing]);
        // The next process dies before it takes another case in hand: the next one pays.
        assert_eq!(fail().ok().as_deref(), Some("extreme/c"));
        assert_eq!(ended(), [Came::Skipped, Came::Failed, Came::Failed]);
        // Negative control: with every case paid for there is no going on for ever.
        let message = fail().expect_err("over").message;
        assert!(message.ends_with("after its last case"), "{message}");
    }
}
