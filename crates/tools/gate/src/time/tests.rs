// SPDX-License-Identifier: MIT OR Apache-2.0
//! The time gate on made-up programs whose noise is that of a busy two-core machine. By turns, processes
//! spread by 2 %, one in ten is held up by 8 % on average, and all drift by 0.4 % a process. In lock-step
//! another program slows every second burst or so by a quarter, samples spread by 3 %, one in ten is held up
//! by 30 % on average, and processes differ by 1 %.

use super::*;
use crate::block::bursts;
use terrafill_results::SplitMix64;

/// The generator of Steele, Lea and Flood (2014).
struct Random(u64);

impl Random {
    /// Uniform in 0 … 1, neither end.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        ((z >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    fn normal(&mut self) -> f64 {
        let (radius, turn) = ((-2.0 * self.uniform().ln()).sqrt(), self.uniform());
        radius * (std::f64::consts::TAU * turn).cos()
    }
}

/// Two programs of which the new one takes `factor` times as long.
struct MadeUp {
    random: Random,
    factor: f64,
    base_ms: f64,
    spread: f64,
    way: TimingOrder,
    /// Time of a process that is to be lost: absent, or this value.
    broken: Option<(u32, Option<f64>)>,
    seconds_per_process: u64,
    /// In lock-step, by how much a process is faster than the one that started before it.
    later_is_faster: f64,
    /// The three of a block always start in the order of their roles.
    keeps_order: bool,
    ran: Vec<(Side, u32)>,
    times: [Times; 2],
}

impl MadeUp {
    fn new(seed: u64, factor: f64) -> Self {
        Self {
            random: Random(seed),
            factor,
            base_ms: 10.0,
            spread: 0.02,
            way: by_turns(),
            broken: None,
            seconds_per_process: 1,
            later_is_faster: 0.0,
            keeps_order: false,
            ran: Vec::new(),
            times: [Times::new(), Times::new()],
        }
    }
}

/// Bursts of a case in a block: the fewest that there are.
const BURSTS: u32 = 6;

/// Spread of samples in lock-step, and by how much each process differs.
const SAMPLE_SPREAD: f64 = 0.03;
const PROCESS_SPREAD: f64 = 0.01;

fn by_turns() -> TimingOrder {
    let why = "made up".to_owned();
    TimingOrder::Turns { why }
}

impl MadeUp {
    fn in_lock_step(seed: u64, factor: f64) -> Self {
        Self {
            way: TimingOrder::LockStep,
            spread: PROCESS_SPREAD,
            ..Self::new(seed, factor)
        }
    }

    /// One whose processes are measured in this way.
    fn measured(way: &TimingOrder, seed: u64, factor: f64) -> Self {
        match way {
            TimingOrder::LockStep => Self::in_lock_step(seed, factor),
            TimingOrder::Turns { .. } => Self::new(seed, factor),
        }
    }

    fn keep(&mut self, side: Side, case: &str, process: u32, sample: u32, log: f64) {
        let factor = if side == Side::New { self.factor } else { 1.0 };
        let mut ms = Some(self.base_ms * factor * log.exp());
        if let Some((_, value)) = self.broken.filter(|(broken, _)| *broken == process) {
            ms = value;
        }
        if let Some(ms) = ms {
            let of = &mut self.times[side.index()];
            let processes = of.entry(case.to_owned()).or_default();
            processes.entry(process).or_default().insert(sample, ms);
        }
    }
}

impl Sides for MadeUp {
    fn way(&self) -> &TimingOrder {
        &self.way
    }

    fn run_together(&mut self, trio: Trio, cases: &BTreeSet<String>) -> Result<(), GateError> {
        for case in cases {
            let order = if self.keeps_order {
                [0, 1, 2]
            } else {
                trio.start_order()
            };
            let mut levels = [0.0; 3];
            for (before, place) in (0..).zip(order) {
                levels[place] =
                    self.spread * self.random.normal() - self.later_is_faster * f64::from(before);
            }
            for burst in 0..BURSTS {
                let slowed = if self.random.uniform() < 0.5 {
                    0.22
                } else {
                    0.0
                };
                for sample in [2 * burst + 1, 2 * burst + 2] {
                    for ((side, process), level) in trio.processes().into_iter().zip(levels) {
                        let mut log = level + slowed + SAMPLE_SPREAD * self.random.normal();
                        if self.random.uniform() < 0.1 {
                            log += -0.3 * self.random.uniform().ln();
                        }
                        self.keep(side, case, process, sample, log);
                    }
                }
            }
        }
        self.ran.extend(trio.processes());
        Ok(())
    }

    fn run(&mut self, side: Side, process: u32, cases: &BTreeSet<String>) -> Result<(), GateError> {
        self.ran.push((side, process));
        for case in cases {
            let mut log = self.spread * self.random.normal() + 0.004 * f64::from(process);
            if self.random.uniform() < 0.1 {
                log += -0.08 * self.random.uniform().ln();
            }
            self.keep(side, case, process, 1, log);
        }
        Ok(())
    }

    fn times(&mut self, side: Side, _metric: &str) -> Result<Times, GateError> {
        Ok(self.times[side.index()].clone())
    }

    fn verify_again(&mut self, _number: u32) -> Result<(), GateError> {
        Ok(())
    }

    fn setups(&self, _side: Side, _metric: &str) -> Times {
        Times::new()
    }

    fn elapsed(&self) -> Duration {
        Duration::from_secs(self.seconds_per_process * self.ran.len() as u64)
    }

    fn say(&mut self, _what: &str) {}
}

fn options() -> TimeOptions {
    TimeOptions::new(Clock::ProcessCpu, Duration::from_secs(600))
}

const METRIC: &str = "fill_cpu_ms";

fn watched(span: Span, count: usize) -> Watched {
    Watched {
        metric: METRIC.to_owned(),
        span,
        cases: (0..count)
            .map(|index| format!("filling/{index:03}"))
            .collect(),
    }
}

fn cases(count: usize) -> [Watched; 1] {
    [watched(Span::Frame, count)]
}

fn paces(way: &TimingOrder, seed: u64, factor: f64, count: usize) -> Vec<Pace> {
    let mut sides = MadeUp::measured(way, seed, factor);
    let gate = compare_times(&mut sides, &cases(count), &options()).expect("measured");
    gate.cases.iter().map(|case| case.pace).collect()
}

fn share(paces: &[Pace], of: Pace) -> f64 {
    paces.iter().filter(|pace| **pace == of).count() as f64 / paces.len() as f64
}

#[test]
fn identical_programs_raise_no_alarm_and_five_percent_is_caught_either_way() {
    for way in [by_turns(), TimingOrder::LockStep] {
        let same = paces(&way, 1, 1.0, 2000);
        assert!(share(&same, Pace::Slower) + share(&same, Pace::Faster) < 0.0005);
        let quiet = share(&same, Pace::Same);
        assert!(quiet > 0.98, "{way:?}: {quiet}");
        for seed in [2, 3] {
            let slower = paces(&way, seed, 1.05, 500);
            let faster = paces(&way, seed, 1.0 / 1.05, 500);
            let found = [share(&slower, Pace::Slower), share(&faster, Pace::Faster)];
            assert!(
                found.iter().all(|share| *share > 0.93),
                "{way:?}: {found:?}"
            );
            assert!((found[0] - found[1]).abs() < 0.05, "{way:?}: {found:?}");
            assert!(share(&slower, Pace::Faster) + share(&faster, Pace::Slower) < 0.001);
        }
        assert!(share(&paces(&way, 4, 1.10, 300), Pace::Slower) > 0.99);
    }
}

#[test]
fn processes_that_are_faster_the_later_they_start_raise_no_alarm() {
    let called = |keeps_order| {
        let mut sides = MadeUp {
            later_is_faster: 0.015,
            keeps_order,
            ..MadeUp::in_lock_step(21, 1.0)
        };
        let gate = compare_times(&mut sides, &cases(400), &options()).expect("measured");
        let paces: Vec<Pace> = gate.cases.iter().map(|case| case.pace).collect();
        [Pace::Slower, Pace::Faster].map(|pace| share(&paces, pace))
    };
    assert_eq!(called(false), [0.0, 0.0]);
    // Negative control: started in the order of their roles, the new program is the last and called faster.
    let [slower, faster] = called(true);
    assert!(slower == 0.0 && faster > 0.02, "{slower} {faster}");
}

#[test]
fn noise_that_only_lengthens_frames_makes_no_bias() {
    // One frame in four is late by up to 40 %.
    let case = "filling/a/globe/vertex/x";
    let late = |process: u32, sample: u32| {
        let mut random = SplitMix64::new(u64::from(process) << 32 | u64::from(sample));
        let is_late = random.unit() < 0.25;
        1.0 + 0.01 * random.unit() + if is_late { 0.4 * random.unit() } else { 0.0 }
    };
    let mut times = [Times::new(), Times::new()];
    let blocks: Vec<Trio> = (0..600).map(Trio::of_block).collect();
    for (side, process) in blocks.iter().flat_map(|trio| trio.processes()) {
        let samples = (1..=24).map(|sample| (sample, late(process, sample)));
        let of = times[side.index()].entry(case.to_owned()).or_default();
        of.insert(process, samples.collect());
    }
    let mean = |of: &dyn Fn(Trio) -> f64| {
        blocks.iter().map(|trio| of(*trio)).sum::<f64>() / blocks.len() as f64
    };
    let found = mean(&|trio| {
        let block = Block::LockStep(trio);
        block.difference(case, &times).expect("measured")
    });
    assert!(found.abs() < 0.001, "{found}");
    // Negative control: against the mean of both base processes the new one looks faster.
    let skewed = mean(&|trio| {
        let bursts = bursts(case, trio, &times).expect("measured");
        let gaps = bursts
            .iter()
            .map(|[base, null, new]| new - 0.5 * (base + null));
        median(&gaps.collect::<Vec<_>>()).expect("some")
    });
    assert!(skewed < -0.003, "{skewed}");
}

#[test]
fn each_of_a_block_starts_first_second_and_last_equally_often() {
    let orders = |blocks: &mut dyn Iterator<Item = u32>| {
        let mut counts = [[0; 3]; 3];
        for block in blocks {
            let trio = Trio::of_block(block);
            assert_eq!(trio.block(), block);
            let order = trio.start_order().map(|place| trio.processes()[place].1);
            assert_eq!(order, [1, 2, 3].map(|of| 3 * block + of));
            for (before, place) in trio.start_order().into_iter().enumerate() {
                counts[place][before] += 1;
            }
        }
        counts
    };
    assert_eq!(orders(&mut (0..6)), [[2; 3]; 3]);
    // Blocks take two cores by turns.
    for first in [0, 1] {
        assert_eq!(orders(&mut (first..6).step_by(2)), [[1; 3]; 3]);
    }
    // Negative control: a block alone favours somebody.
    assert_ne!(orders(&mut (0..1)), [[1; 3]; 3]);
}

#[test]
fn a_burst_with_an_unusable_sample_does_not_count_and_half_of_them_must() {
    let mut sides = MadeUp::in_lock_step(14, 1.0);
    let trio = Trio::of_block(0);
    sides
        .run_together(trio, &cases(1)[0].cases)
        .expect("made up");
    let case = "filling/000";
    let mut times = both(&mut sides, METRIC).expect("times");
    let count = |times: &[Times; 2]| bursts(case, trio, times).map(|bursts| bursts.len());
    assert_eq!(count(&times), Some(6));
    // One unusable sample in each of three bursts, then in a fourth.
    for (lost, sample, expected) in [
        (1, 2, Some(5)),
        (2, 3, Some(4)),
        (3, 6, Some(3)),
        (4, 7, None),
    ] {
        let of_case = times[1].get_mut(case).expect("the case");
        let samples = of_case.get_mut(&trio.new).expect("the process");
        samples.insert(sample, if lost % 2 == 0 { 0.0 } else { f64::NAN });
        assert_eq!(count(&times), expected, "{lost} lost");
    }
}

#[test]
fn reversed_operands_reverse_the_answer() {
    let mut sides = MadeUp::new(5, 1.08);
    let gate = compare_times(&mut sides, &cases(1), &options()).expect("measured");
    let times = both(&mut sides, METRIC).expect("times");
    let turned: Vec<Block> = gate
        .confirm
        .iter()
        .map(|block| match block {
            Block::Turns { base, new } => Block::Turns {
                base: *new,
                new: *base,
            },
            Block::LockStep(_) => panic!("by turns"),
        })
        .collect();
    let [base, new] = times.clone();
    let case = "filling/000";
    let there = decide(case, &cases(1)[0], &gate.confirm, &times, &options());
    let back = decide(case, &cases(1)[0], &turned, &[new, base], &options());
    assert_eq!((there.pace, back.pace), (Pace::Slower, Pace::Faster));
    let product =
        (1.0 + 0.01 * there.percent.expect("n")) * (1.0 + 0.01 * back.percent.expect("n"));
    assert!((product - 1.0).abs() < 1e-12, "{product}");
}

#[test]
fn blocks_go_there_and_back_and_cases_are_decided_by_fresh_ones() {
    let mut sides = MadeUp::new(6, 1.2);
    let gate = compare_times(&mut sides, &cases(2), &options()).expect("measured");
    assert_eq!((gate.screen.len(), gate.confirm.len()), (5, 20));
    use Side::{Base, New};
    let order: Vec<Side> = sides.ran.iter().take(8).map(|(side, _)| *side).collect();
    assert_eq!(order, [Base, New, New, Base, New, Base, Base, New]);
    let all: Vec<&Block> = gate.screen.iter().chain(&gate.confirm).collect();
    let of = |block: &&Block| [Base, New].map(|side| block.processes(side)).concat();
    let processes: BTreeSet<u32> = all.iter().flat_map(of).collect();
    assert_eq!(processes.len(), 100, "no process counts twice");
    // An even drift of 0.4 % a process falls out.
    let change = gate.cases[0].percent.expect("measured");
    assert!((change - 20.0).abs() < 2.0, "{change}");

    let mut sides = MadeUp::in_lock_step(6, 1.2);
    let gate = compare_times(&mut sides, &cases(2), &options()).expect("measured");
    assert_eq!((gate.screen.len(), gate.confirm.len()), (5, 20));
    let processes: BTreeSet<u32> = sides.ran.iter().map(|(_, process)| *process).collect();
    assert_eq!(processes.len(), 75, "three fresh processes a block");
}

#[test]
fn a_collapse_is_no_improvement() {
    for way in [by_turns(), TimingOrder::LockStep] {
        let found = paces(&way, 7, 0.1, 3);
        let is_collapsed = |pace: &Pace| *pace == Pace::Collapsed;
        assert!(found.iter().all(is_collapsed), "{found:?}");
        // Negative control: a third less is an improvement.
        let found = paces(&way, 7, 0.67, 3);
        assert!(found.iter().all(|pace| *pace == Pace::Faster), "{found:?}");
    }
    let sides = &mut MadeUp::new(7, 0.1);
    let gate = compare_times(sides, &cases(1), &options()).expect("measured");
    let finding = gate.cases[0].finding(&BTreeMap::new()).expect("a finding");
    assert_eq!(finding.severity, Severity::Unknown);
    assert!(
        finding.words.contains("stopped doing its work"),
        "{}",
        finding.words
    );
}

#[test]
fn a_time_that_is_absent_zero_or_no_number_is_never_a_pass() {
    for value in [
        None,
        Some(0.0),
        Some(f64::NAN),
        Some(-1.0),
        Some(f64::INFINITY),
    ] {
        for (way, process, factor) in [
            (by_turns(), 3, 1.0),
            (by_turns(), 40, 1.2),
            (TimingOrder::LockStep, 2, 1.0),
            (TimingOrder::LockStep, 30, 1.2),
        ] {
            let mut sides = MadeUp::measured(&way, 8, factor);
            sides.broken = Some((process, value));
            let gate = compare_times(&mut sides, &cases(1), &options()).expect("measured");
            let case = &gate.cases[0];
            assert_eq!(case.pace, Pace::Unknown, "{value:?} in {process}");
            assert!(case.words.contains("no usable time"), "{}", case.words);
        }
    }
}

#[test]
fn noise_that_could_hide_a_change_is_no_pass() {
    for way in [by_turns(), TimingOrder::LockStep] {
        let mut sides = MadeUp::measured(&way, 9, 1.0);
        sides.spread = 0.3;
        let gate = compare_times(&mut sides, &cases(40), &options()).expect("measured");
        let paces: Vec<Pace> = gate.cases.iter().map(|case| case.pace).collect();
        assert!(share(&paces, Pace::Unknown) > 0.8, "{paces:?}");
        assert!(share(&paces, Pace::Slower) < 0.05);
    }
}

#[test]
fn where_base_against_base_moves_the_answer_is_unknown() {
    // Outer base processes of two blocks slower than inner ones by turns: what the null looks at.
    let mut sides = MadeUp::new(10, 1.2);
    sides.spread = 0.001;
    let steady = compare_times(&mut sides, &cases(1), &options()).expect("measured");
    assert_eq!(steady.cases[0].pace, Pace::Slower);
    let [mut base, new] = both(&mut sides, METRIC).expect("times");
    let case = "filling/000".to_owned();
    let processes = |block: &Block| block.processes(Side::Base);
    for (index, blocks) in steady.confirm.chunks(2).enumerate() {
        let (first, second) = (processes(&blocks[0]), processes(&blocks[1]));
        let outer = [first[0], second[1]];
        let inner = [first[1], second[0]];
        for process in if index % 2 == 0 { outer } else { inner } {
            let of = base.get_mut(&case).expect("the case");
            let samples = of.get_mut(&process).expect("the process");
            for ms in samples.values_mut() {
                *ms *= 1.08;
            }
        }
    }
    let found = decide(
        &case,
        &cases(1)[0],
        &steady.confirm,
        &[base, new],
        &options(),
    );
    assert_eq!(found.pace, Pace::Unknown);
    assert!(found.words.contains("base against base"), "{}", found.words);

    // In lock-step: the other base process of each block is slower.
    let mut sides = MadeUp::in_lock_step(10, 1.2);
    let steady = compare_times(&mut sides, &cases(1), &options()).expect("measured");
    assert_eq!(steady.cases[0].pace, Pace::Slower);
    let mut times = both(&mut sides, METRIC).expect("times");
    for block in &steady.confirm {
        let of = times[0].get_mut(&case).expect("the case");
        let samples = of.get_mut(&processes(block)[1]).expect("the process");
        for ms in samples.values_mut() {
            *ms *= 1.08;
        }
    }
    let found = decide(&case, &cases(1)[0], &steady.confirm, &times, &options());
    assert_eq!(found.pace, Pace::Unknown);
    assert!(found.words.contains("base against base"), "{}", found.words);
}

#[test]
fn what_one_round_leaves_undecided_is_measured_on_while_the_budget_lasts() {
    let gate = |budget_s| {
        let mut sides = MadeUp {
            spread: 0.045,
            ..MadeUp::in_lock_step(23, 1.0)
        };
        let options = TimeOptions {
            budget: Duration::from_secs(budget_s),
            ..options()
        };
        compare_times(&mut sides, &cases(200), &options).expect("measured")
    };
    let unknown = |gate: &TimeGate| {
        gate.cases
            .iter()
            .filter(|c| c.pace == Pace::Unknown)
            .count()
    };
    let called = |gate: &TimeGate| {
        let is_called = |c: &&CaseTime| matches!(c.pace, Pace::Slower | Pace::Faster);
        gate.cases.iter().filter(is_called).count()
    };
    let long = gate(600);
    assert_eq!(long.confirm.len(), 60);
    assert!(unknown(&long) < 40, "{}", unknown(&long));
    // Negative control: 25 blocks of three seconds, and time for one more.
    let short = gate(75);
    assert_eq!(short.confirm.len(), 21);
    assert!(unknown(&short) > 60, "{}", unknown(&short));
    // The same work, and further rounds call none of it slower or faster.
    assert_eq!(called(&long), called(&short));
    assert!(called(&short) <= 2, "1 % of the first round's");
}

#[test]
fn a_budget_that_ends_early_is_no_pass() {
    let mut sides = MadeUp::new(11, 1.2);
    let short = TimeOptions {
        budget: Duration::from_secs(12),
        ..options()
    };
    let error = compare_times(&mut sides, &cases(1), &short).expect_err("too short");
    assert_eq!(error.exit_code(), 4);
    assert!(error.to_string().contains("3 of 5 blocks"), "{error}");

    let mut sides = MadeUp::new(11, 1.2);
    let short = TimeOptions {
        budget: Duration::from_secs(40),
        ..options()
    };
    let gate = compare_times(&mut sides, &cases(1), &short).expect("screened");
    assert_eq!(gate.confirm.len(), 5);
    assert_eq!(gate.cases[0].pace, Pace::Unknown);
    assert!(
        gate.cases[0].words.contains("allowed 5 blocks"),
        "{}",
        gate.cases[0].words
    );
}

#[test]
fn differences_below_the_clock_do_not_count() {
    let mut sides = MadeUp::new(12, 1.2);
    sides.base_ms = 0.02;
    let gate = compare_times(&mut sides, &cases(1), &options()).expect("measured");
    assert_eq!(gate.cases[0].pace, Pace::Same);
    assert!(
        gate.cases[0].words.contains("below 0.01 ms"),
        "{}",
        gate.cases[0].words
    );
}

/// The machine is slow in half of the bursts, so that the median of either side lies in one of its two states.
/// The absolute floor must judge what the blocks say, in which both were measured at the same moments.
#[test]
fn a_real_difference_counts_where_the_machine_is_slow_half_of_the_time() {
    let below_floor = |base_ms: f64, factor: f64| {
        let mut sides = MadeUp::in_lock_step(31, factor);
        sides.base_ms = base_ms;
        let gate = compare_times(&mut sides, &cases(500), &options()).expect("measured");
        let of = gate.cases.iter();
        of.filter(|case| case.words.contains("below 0.01 ms"))
            .count()
    };
    // 0.027–0.029 ms, near three times the floor.
    assert_eq!(below_floor(0.42, 1.07), 0);
    assert_eq!(below_floor(0.42, 1.0 / 1.07), 0);
    // 0.007 ms.
    assert!(below_floor(0.1, 1.07) > 450);
}

#[test]
fn the_wall_clock_has_a_floor_of_its_own_and_decides_nothing_where_others_move_it() {
    let of = |span, factor, spread| {
        let mut sides = MadeUp {
            spread,
            ..MadeUp::in_lock_step(41, factor)
        };
        let gate = compare_times(&mut sides, &[watched(span, 40)], &options()).expect("measured");
        let paces: Vec<Pace> = gate.cases.iter().map(|case| case.pace).collect();
        [Pace::Same, Pace::Slower, Pace::Unknown].map(|pace| share(&paces, pace))
    };
    // 5 % is called of a frame, and of its wall clock not.
    assert!(of(Span::Frame, 1.05, 0.01)[1] > 0.9);
    assert_eq!(of(Span::Wall, 1.05, 0.01), [1.0, 0.0, 0.0]);
    assert!(of(Span::Wall, 1.2, 0.01)[1] > 0.9);
    // Noise that hides a change of the floor's size leaves a frame undecided.
    let [same, slower, unknown] = of(Span::Frame, 1.0, 0.4);
    assert!(unknown > 0.7 && slower < 0.05, "{same} {slower} {unknown}");
    let [same, slower, _] = of(Span::Wall, 1.0, 0.4);
    assert!(same > 0.5 && slower < 0.05, "{same} {slower}");
    // Three times as long is seen through it.
    assert!(of(Span::Wall, 3.0, 0.4)[1] > 0.9);
}

#[test]
fn stages_say_where_a_difference_lies_and_decide_nothing() {
    let mut sides = MadeUp::in_lock_step(43, 1.2);
    let mut stage = watched(Span::Stage, 1);
    stage.metric = "stencil_gpu_ms".to_owned();
    let [frame] = cases(1);
    let gate = compare_times(&mut sides, &[frame, stage], &options()).expect("measured");
    assert_eq!(gate.cases.len(), 1);
    // The made-up program's stage is its whole frame.
    let case = &gate.cases[0];
    let [stage] = case.stages.as_slice() else {
        panic!("{:?}", case.stages);
    };
    assert_eq!(
        [Some(stage.base_ms), Some(stage.new_ms)],
        [case.base_ms, case.new_ms]
    );
    let sentence = case.sentence();
    assert!(sentence.contains(", stencil +"), "{sentence}");
}
