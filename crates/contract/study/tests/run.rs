// SPDX-License-Identifier: MIT OR Apache-2.0
//! The runner, measuring a made-up study.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use tempfile::TempDir;
use terrafill_contract::{DeviceLoss, Devices};
use terrafill_results::{
    Block, CaseId, Chapter, ChapterError, Clock, ConditionKey, Kind, Metric, Numbered, Outcome,
    PlannedCase, Run, RunEnvironment, RunError, RunFolder, SCHEMA, Shard, Status, UNSTEADY_CLOCK,
    Verdict,
};
use terrafill_study::{
    CaseGroup, Failure, Figures, FramesPerSample, Group, Plan, Planned, Request, RunOptions,
    RunOutcome, Session, Settling, Silent, Study, StudyError, Turn, Turns, plan, run, run_by_turns,
};

const METRICS: [Metric; 2] = [
    Metric::less("cost_ms", "ms", Kind::Time, "What a made-up case costs."),
    Metric::neither("draws", "", Kind::Counter, "Made-up draws."),
];

/// What the sessions did, and when they are to break.
#[derive(Default)]
struct Script {
    verified: RefCell<Vec<usize>>,
    rechecked: RefCell<Vec<usize>>,
    sampled: RefCell<Vec<usize>>,
    /// What was to be sampled next, of samples that count.
    before: RefCell<Vec<usize>>,
    blocks: Cell<usize>,
    /// Breaks off, as a killed process does, once so many samples were taken.
    broken_after: Cell<Option<usize>>,
    /// The device is lost once so many samples were taken: they and all that follow fail.
    lost_after: Cell<Option<usize>>,
    /// The case that can no longer be drawn once it has been verified.
    failing: Cell<Option<usize>>,
    /// Costs of the first case, sample by sample; the last one repeats. Empty: a constant cost.
    costs: RefCell<Vec<f64>>,
    /// What a recheck answers.
    recheck_status: Cell<Status>,
}

thread_local! {
    static SCRIPT: RefCell<Rc<Script>> = RefCell::default();
}

fn script() -> Rc<Script> {
    SCRIPT.with(|script| Rc::clone(&script.borrow()))
}

fn fresh_script() -> Rc<Script> {
    SCRIPT.with(|script| *script.borrow_mut() = Rc::default());
    script().recheck_status.set(Status::Ok);
    script()
}

struct MadeUp {
    groups: usize,
    /// How many of its two conditions it declares.
    declared: usize,
}

impl Chapter for MadeUp {
    fn study(&self) -> &'static str {
        "made-up"
    }

    fn title(&self) -> &'static str {
        "Made up"
    }

    fn question(&self) -> &'static str {
        "none"
    }

    fn primary_metric(&self, _clock: Clock) -> Option<&'static str> {
        Some("cost_ms")
    }

    fn blocks(&self, _run: &Run) -> Result<Vec<Block>, ChapterError> {
        Ok(Vec::new())
    }
}

impl Study for MadeUp {
    fn name(&self) -> &'static str {
        "made-up"
    }

    fn metrics(&self) -> &'static [Metric] {
        &METRICS
    }

    fn conditions(&self) -> Vec<ConditionKey> {
        let all = ["group", "case"].map(ConditionKey::declare);
        all[..self.declared].to_vec()
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let samples = request.samples.unwrap_or(3);
        let group = |index| -> Box<dyn Group> { Box::new(group(index, samples)) };
        Ok(Planned {
            groups: (0..self.groups).map(group).collect(),
            ..Planned::default()
        })
    }

    fn chapter(&self) -> &dyn Chapter {
        self
    }
}

const STATUSES: [Status; 8] = [
    Status::Ok,
    Status::Ok,
    Status::Ok,
    Status::Ok,
    Status::Wrong,
    Status::Wrong,
    Status::Skipped,
    Status::Ok,
];

/// Four right cases, one that is wrong, one that may be, one skipped, one that is only verified.
fn group(index: usize, samples: u32) -> CaseGroup<()> {
    let name = format!("group-{index}");
    let cases = (0..STATUSES.len()).map(|case| PlannedCase {
        id: CaseId::new(
            "made-up",
            format!("{name}/case-{case}"),
            [("group", name.clone()), ("case", case.to_string())],
        ),
        samples: if case == 7 { 0 } else { samples },
        may_be_wrong: case == 5,
    });
    CaseGroup {
        cases: cases.collect(),
        name,
        warm_up: None,
        work: (),
        open: |_, context| Ok(Box::new(MadeUpSession(context.devices.loss().clone()))),
    }
}

struct MadeUpSession(DeviceLoss);

impl Session for MadeUpSession {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        script().verified.borrow_mut().push(case);
        Ok(Verdict {
            status: STATUSES[case],
            reason: match STATUSES[case] {
                Status::Ok => String::new(),
                _ => "as the script says".to_owned(),
            },
            figures: vec![("draws", 7.0)],
            notes: vec![("picture", format!("{case}.png"))],
            ..Verdict::default()
        })
    }

    fn recheck(
        &mut self,
        case: usize,
        _status: Status,
        notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        assert_eq!(notes["picture"], format!("{case}.png"));
        script().rechecked.borrow_mut().push(case);
        let status = match STATUSES[case] {
            Status::Ok => script().recheck_status.get(),
            status => status,
        };
        Ok(Verdict {
            status,
            ..Verdict::default()
        })
    }

    fn begin_block(&mut self) -> Result<(), StudyError> {
        script().blocks.set(script().blocks.get() + 1);
        Ok(())
    }

    fn before_sample(&mut self, case: usize) -> Result<(), Failure> {
        script().before.borrow_mut().push(case);
        Ok(())
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let script = script();
        if script.broken_after.get() == Some(script.sampled.borrow().len()) {
            // What a kill leaves: nothing of this sample, everything of those before.
            std::panic::panic_any("killed");
        }
        script.sampled.borrow_mut().push(case);
        let lost = script.lost_after.get();
        if lost.is_some_and(|lost| script.sampled.borrow().len() > lost) {
            self.0.report("timed out");
            return Err(Failure::broken("a fence was not signalled"));
        }
        if script.failing.get() == Some(case) {
            return Err(Failure::broken("out of memory"));
        }
        let costs = script.costs.borrow();
        let taken = script.sampled.borrow().len();
        let cost = costs.get(taken - 1).or(costs.last()).copied();
        Ok(vec![("cost_ms", cost.unwrap_or(1.0 + case as f64))])
    }
}

fn options() -> RunOptions {
    RunOptions {
        processes: 1,
        process: 0,
        warm_up: 1,
        seed: 4,
        shard: None,
    }
}

fn environment() -> RunEnvironment {
    RunEnvironment {
        schema: SCHEMA,
        commit: "abc".to_owned(),
        ..RunEnvironment::default()
    }
}

fn planned(groups: usize, options: &RunOptions) -> Plan {
    plan(
        &[&MadeUp {
            groups,
            declared: 2,
        }],
        &Request::default(),
        options,
    )
    .expect("planned")
}

/// A plan, the script of its sessions and the folder that it is measured into.
struct Measured {
    plan: Plan,
    script: Rc<Script>,
    place: TempDir,
    folder: RunFolder,
}

impl Measured {
    fn begin(plan: Plan) -> Self {
        let place = tempfile::tempdir().expect("a folder");
        let to_measure = plan.run_plan().clone();
        let folder = RunFolder::create(place.path(), environment(), to_measure, &METRICS);
        Self {
            script: fresh_script(),
            folder: folder.expect("new"),
            place,
            plan,
        }
    }

    fn resume(&mut self) {
        let folder = RunFolder::resume(self.place.path(), &environment(), self.plan.run_plan());
        self.folder = folder.expect("there");
    }

    fn try_to(&self, options: &RunOptions) -> Result<(), StudyError> {
        let devices = Rc::new(Devices::default());
        run(&self.plan, &self.folder, &devices, options, &mut Silent)
    }

    fn measure(&self, options: &RunOptions) {
        self.try_to(options).expect("measured");
    }

    fn run(&self) -> Run {
        Run::load(self.place.path()).expect("a run")
    }

    fn outcome(&self) -> RunOutcome {
        RunOutcome::of(self.place.path()).expect("a run")
    }

    /// Samples that the first process has kept.
    fn kept(&self) -> usize {
        let cases = self.run().cases;
        cases.iter().map(|case| case.timed_samples(0).len()).sum()
    }

    fn missing(&self) -> usize {
        let cases = self.run().cases;
        let missing = cases.iter().filter(|case| case.outcome == Outcome::Missing);
        missing.count()
    }
}

#[test]
fn every_case_is_verified_once_and_only_right_ones_are_timed() {
    let made = Measured::begin(planned(1, &options()));
    made.measure(&options());
    assert_eq!(*made.script.verified.borrow(), [0, 1, 2, 3, 4, 5, 6, 7]);
    let run = made.run();
    for case in &run.cases {
        let index: usize = case.condition("case").parse().expect("a number");
        let times = case.replicates("cost_ms");
        let is_timed = [0, 1, 2, 3, 5].contains(&index);
        assert_eq!(times.len(), usize::from(is_timed), "{}", case.id());
        assert_eq!(case.timed_samples(0).len(), if is_timed { 3 } else { 0 });
        // A wrong case, unless its error is the question, is never timed.
        let wrong = index == 4 || index == 5;
        assert_eq!(case.outcome == Outcome::Wrong, wrong);
    }
    let repeats: Vec<_> = run.cases.iter().filter(|case| case.is_repeat()).collect();
    assert_eq!(repeats.len(), 2);
    for repeat in repeats {
        let original = run.case(repeat.condition("repeats")).expect("the original");
        assert_eq!(repeat.value("cost_ms"), original.value("cost_ms"));
        assert_eq!(original.value("draws"), Some(7.0));
        assert_eq!(repeat.value("draws"), None, "figures stand once");
    }
    let outcome = made.outcome();
    let expected = RunOutcome {
        ok: 5,
        wrong: 1,
        wrong_on_purpose: 1,
        skipped: 1,
        ..RunOutcome::default()
    };
    assert_eq!(outcome, expected);
    // Seven are timed, repeats included, in three blocks and a warm-up.
    assert_eq!(made.script.sampled.borrow().len(), 7 * 4);
    assert_eq!(made.script.blocks.get(), 4);
}

#[test]
fn a_killed_run_names_what_is_missing_and_goes_on_where_it_was() {
    let mut made = Measured::begin(planned(2, &options()));
    made.script.broken_after.set(Some(17));
    let killed = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        made.measure(&options());
    }));
    assert!(killed.is_err());
    // Of the first group the seven that are timed, of the second all.
    assert_eq!(made.missing(), 7 + 10);
    assert_eq!(made.kept(), 17 - 7, "the warm-up is not kept");
    made.script.broken_after.set(None);
    made.script.sampled.borrow_mut().clear();
    made.resume();
    made.measure(&options());
    assert_eq!(made.missing(), 0);
    for case in &made.run().cases {
        let samples: Vec<u32> = case.timed_samples(0).into_iter().collect();
        assert!(samples.is_empty() || samples == [1, 2, 3], "{}", case.id());
    }
    // Negative control: what is complete is not measured again.
    made.script.sampled.borrow_mut().clear();
    made.script.verified.borrow_mut().clear();
    made.measure(&options());
    assert!(made.script.sampled.borrow().is_empty() && made.script.verified.borrow().is_empty());
}

#[test]
fn a_lost_device_ends_the_run_and_fails_no_case() {
    let mut made = Measured::begin(planned(2, &options()));
    made.script.lost_after.set(Some(17));
    let said = made.try_to(&options()).expect_err("lost").to_string();
    assert!(
        said.starts_with("made-up/group-0/case-")
            && said.ends_with(": the device was lost: timed out"),
        "{said}"
    );
    let counted = made.outcome();
    assert_eq!((counted.failed, counted.ok), (0, 1), "{counted:?}");
    assert_eq!(made.kept(), 17 - 7, "all before the loss, but the warm-up");
    // The same command with --resume, on devices that are there.
    made.script.lost_after.set(None);
    made.resume();
    made.measure(&options());
    let counted = made.outcome();
    assert_eq!((counted.failed, counted.missing), (0, 0), "{counted:?}");
}

#[test]
fn a_case_that_fails_while_it_is_timed_has_one_row() {
    let made = Measured::begin(planned(1, &options()));
    made.script.failing.set(Some(2));
    made.measure(&options());
    let run = made.run();
    let failed: Vec<&str> = run
        .cases
        .iter()
        .filter(|case| case.outcome == Outcome::Failed)
        .map(|case| case.condition("case"))
        .collect();
    assert!(
        !failed.is_empty() && failed.iter().all(|case| *case == "2"),
        "{failed:?}"
    );
    let table = std::fs::read_to_string(made.place.path().join("cases.csv")).expect("a table");
    assert_eq!(table.lines().count(), 1 + made.plan.run_plan().cases.len());
    // Negative control: the others are right.
    assert_eq!(made.outcome().ok, 4);
}

#[test]
fn another_process_rechecks_and_a_case_that_changed_fails() {
    let two = RunOptions {
        processes: 2,
        ..options()
    };
    let made = Measured::begin(planned(1, &two));
    made.measure(&two);
    assert!(made.missing() > 0);
    let second = RunOptions { process: 1, ..two };
    made.measure(&second);
    assert_eq!(*made.script.rechecked.borrow(), [0, 1, 2, 3, 5]);
    assert_eq!(made.missing(), 0);
    assert_eq!(made.run().cases[0].replicates("cost_ms").len(), 2);

    // Negative control: a second process whose pictures differ.
    let made = Measured::begin(planned(1, &two));
    made.measure(&two);
    made.script.recheck_status.set(Status::Wrong);
    made.measure(&second);
    let run = made.run();
    assert_eq!(run.cases[0].outcome, Outcome::Failed);
    assert!(
        run.cases[0].reason.contains("wrong in process 1"),
        "{}",
        run.cases[0].reason
    );
}

#[test]
fn shards_share_the_groups_and_leave_none_out() {
    fresh_script();
    let mut seen = BTreeSet::new();
    for index in 1..=2 {
        let options = RunOptions {
            shard: Some(Shard { index, count: 2 }),
            ..options()
        };
        for case in &planned(3, &options).run_plan().cases {
            assert!(seen.insert(case.id.key()), "in one shard only");
        }
    }
    let all = planned(3, &options());
    assert_eq!(seen.len(), all.run_plan().cases.len());
}

#[test]
fn a_condition_that_is_not_declared_is_refused() {
    fresh_script();
    let refused = |declared| {
        let made_up = MadeUp {
            groups: 1,
            declared,
        };
        let planned = plan(&[&made_up], &Request::default(), &options());
        planned.err().map(|error| error.to_string())
    };
    let said = refused(1).expect("undeclared");
    for word in [
        "made-up/group-0/case-0",
        "study made-up",
        "\"case\"",
        "allowed: group",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    // Negative control: both are declared.
    assert_eq!(refused(2), None);
}

#[test]
fn a_case_that_is_planned_twice_is_refused() {
    fresh_script();
    let made_up = MadeUp {
        groups: 1,
        declared: 2,
    };
    let twice: [&dyn Study; 2] = [&made_up, &made_up];
    let error = plan(&twice, &Request::default(), &options()).map(|_| ());
    let error = error.expect_err("twice").to_string();
    assert!(error.contains("made-up/group-0/case-0"), "{error}");
}

#[test]
fn resuming_refuses_another_plan_and_another_commit() {
    let made = Measured::begin(planned(1, &options()));
    let other = planned(2, &options());
    let refused = |environment: &RunEnvironment, plan: &Plan| match RunFolder::resume(
        made.place.path(),
        environment,
        plan.run_plan(),
    ) {
        Err(RunError::Occupied { message, .. }) => message,
        other => panic!("{other:?}"),
    };
    assert!(refused(&environment(), &other).contains("plan differs"));
    let newer = RunEnvironment {
        commit: "def".to_owned(),
        ..environment()
    };
    assert!(refused(&newer, &made.plan).contains("commit \"def\""));
    assert!(RunFolder::resume(made.place.path(), &environment(), made.plan.run_plan()).is_ok());
}

#[test]
fn a_sample_is_the_mean_of_its_frames_and_extra_ones_add_their_cost() {
    for (frames, extra, factor) in [(1, 0, 1.0), (10, 0, 1.0), (10, 1, 1.1), (20, 1, 1.05)] {
        let plan = planned(1, &options()).with_frames(FramesPerSample { frames, extra });
        let made = Measured::begin(plan);
        made.measure(&options());
        let run = made.run();
        let cost = run.cases[1].value("cost_ms").expect("timed");
        assert!(
            (cost - 2.0 * factor).abs() < 1e-12,
            "{frames}+{extra}: {cost}"
        );
        // One frame in the warm-up, then three samples.
        let sampled = made.script.sampled.borrow();
        let drawn = sampled.iter().filter(|&&c| c == 3).count();
        assert_eq!(drawn % (1 + 3 * (frames + extra) as usize), 0);
        assert_eq!(run.cases[1].timed_samples(0).len(), 3);
    }
}

#[test]
fn a_process_may_time_a_few_cases_and_rechecks_no_other() {
    let mut made = Measured::begin(planned(1, &options()));
    made.measure(&options());
    let key = made.plan.run_plan().cases[1].id.key();
    let few = planned(1, &options()).timing_only(BTreeSet::from([key.clone()]));
    made.plan = few.expect("planned");
    let second = RunOptions {
        process: 1,
        ..options()
    };
    made.measure(&second);
    assert_eq!(*made.script.rechecked.borrow(), [1]);
    let run = made.run();
    for case in &run.cases {
        let is_timed = case.id().key() == key;
        assert_eq!(!case.timed_samples(1).is_empty(), is_timed, "{}", case.id());
        assert_ne!(case.outcome, Outcome::Missing);
    }
    // Negative control: what is not planned is no case that was left out.
    let unknown = planned(1, &options()).timing_only(BTreeSet::from(["x/y".to_owned()]));
    let error = unknown.map(|_| ()).expect_err("unknown").to_string();
    assert!(error.contains("\"x/y\""), "{error}");
}

/// Turns from a list, and what came of them.
struct Listed {
    turns: Vec<Turn>,
    ready: Vec<Vec<String>>,
    over: Vec<bool>,
}

impl Turns for Listed {
    fn ready(&mut self, cases: &[String]) -> Result<(), String> {
        self.ready.push(cases.to_vec());
        Ok(())
    }

    fn next(&mut self) -> Result<Turn, String> {
        if self.turns.is_empty() {
            return Err("no more turns".to_owned());
        }
        Ok(self.turns.remove(0))
    }

    fn over(&mut self, is_well: bool) -> Result<(), String> {
        self.over.push(is_well);
        Ok(())
    }
}

#[test]
fn samples_are_taken_as_turns_release_them_and_no_other() {
    let made = Measured::begin(planned(1, &options()));
    let by_turns = |process: u32, turns: Vec<Turn>| {
        let mut turns = Listed {
            turns,
            ready: Vec::new(),
            over: Vec::new(),
        };
        let options = RunOptions {
            process,
            ..options()
        };
        let devices = Rc::new(Devices::default());
        let ran = run_by_turns(
            &made.plan,
            &made.folder,
            &devices,
            &options,
            &mut Silent,
            &mut turns,
        );
        (ran.map_err(|error| error.to_string()), turns)
    };
    let sample = |place, counts| Turn::Sample {
        place,
        of: 1,
        counts,
    };
    let list = vec![
        Turn::Block,
        sample(1, false),
        sample(1, true),
        sample(0, true),
        sample(1, true),
        Turn::NextGroup,
    ];
    let (ran, turns) = by_turns(0, list);
    assert_eq!(ran, Ok(()));
    assert_eq!(turns.over, [true; 5]);
    assert_eq!(made.script.blocks.get(), 1);
    assert_eq!(*made.script.sampled.borrow(), [1, 1, 0, 1]);
    // The first one does not count.
    assert_eq!(*made.script.before.borrow(), [1, 0, 1]);
    let taken = |turns: &Listed, place: usize, process| {
        let run = made.run();
        let case = run.case(&turns.ready[0][place]).expect("a case");
        case.timed_samples(process).len()
    };
    let counted = [0, 1, 2].map(|place| taken(&turns, place, 0));
    assert_eq!(counted, [1, 2, 0]);

    // A sample of several measurements is one row.
    let of = 3;
    let place = 2;
    let counts = true;
    let (ran, turns) = by_turns(4, vec![Turn::Sample { place, of, counts }, Turn::NextGroup]);
    assert_eq!((ran, &turns.over), (Ok(()), &vec![true]));
    assert_eq!(made.script.sampled.borrow().len(), 4 + 3);
    assert_eq!(taken(&turns, 2, 4), 1);

    // A case that breaks off says so and the next goes on.
    made.script.failing.set(Some(0));
    let (ran, turns) = by_turns(1, vec![sample(0, true), sample(1, true), Turn::NextGroup]);
    assert_eq!(ran, Ok(()));
    assert_eq!(turns.over, [false, true]);

    // Negative controls: a place that there is not, and turns that end early.
    let (ran, _) = by_turns(2, vec![sample(99, true)]);
    assert!(ran.expect_err("no such place").contains("turn of case 99"));
    let (ran, _) = by_turns(3, vec![Turn::Block]);
    assert!(ran.expect_err("no end").contains("no more turns"));
}

/// Times that a run keeps, and its notes of unsteady clocks.
fn settled(costs: Vec<f64>, max_looks: u32, each_group: bool) -> (Vec<f64>, Vec<String>) {
    let settling = Settling {
        max_looks,
        each_group,
    };
    let options = RunOptions {
        warm_up: 0,
        ..options()
    };
    let plan = planned(2, &options).with_settling(settling);
    let made = Measured::begin(plan);
    *made.script.costs.borrow_mut() = costs;
    made.measure(&options);
    let run = made.run();
    let times = run.cases.iter().filter_map(|case| case.samples("cost_ms"));
    let times = times.flat_map(Numbered::values).flat_map(Numbered::values);
    let notes = run.cases.iter().flat_map(|case| case.notes());
    let notes = notes.filter(|(name, _)| name.starts_with(UNSTEADY_CLOCK));
    (
        times.copied().collect(),
        notes.map(|(_, text)| text.clone()).collect(),
    )
}

#[test]
fn nothing_is_timed_before_the_clock_is_steady() {
    let rising = vec![370.0, 280.0, 190.0, 120.0, 100.0];
    let (times, notes) = settled(rising.clone(), 20, false);
    assert!(
        times.iter().all(|ms| *ms <= 100.0) && !times.is_empty(),
        "{times:?}"
    );
    assert!(notes.is_empty(), "{notes:?}");
    // Negative control: without the wait the first values are kept.
    let (times, _) = settled(rising, 0, false);
    assert!(
        times.contains(&370.0) && times.contains(&120.0),
        "{times:?}"
    );
}

#[test]
fn a_clock_that_never_settles_is_waited_for_so_often_and_said() {
    let waves: Vec<f64> = (0..500)
        .map(|at| if at % 2 == 0 { 100.0 } else { 200.0 })
        .collect();
    let (times, notes) = settled(waves.clone(), 7, false);
    assert!(!times.is_empty());
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(
        notes[0].contains("process 0") && notes[0].contains("7 looks"),
        "{notes:?}"
    );
    assert!(notes[0].contains("100 %"), "{notes:?}");
    // Each group waits where a device rests while the CPU verifies.
    assert_eq!(settled(waves, 7, true).1.len(), 2);
}
