// SPDX-License-Identifier: MIT OR Apache-2.0
//! Processes of both programs, all alive, of which one at a time draws one sample.
//!
//! Each makes a group of cases ready and waits. A line on its standard input releases a sample, a line on
//! its standard output says that it is taken; `bench --stepped` has the other end. So samples that are
//! compared follow one another within milliseconds, and what slows the machine down slows both.

use std::collections::BTreeMap;
use std::io::{self, BufRead as _, BufReader, Lines, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use terrafill_results::SplitMix64;

/// Rounds at the start of each group whose samples are not kept: caches, clock rates and lazily made
/// pipelines settle.
const WARM_UP_ROUNDS: u32 = 1;

/// A sample lasts at least so long, as the median of as many frames. What disturbs a busy machine changes
/// every few milliseconds, so many short bursts tell more than a few long ones. On two busy cores bursts of
/// samples of 1 ms and of 8 ms both spread by 10 %.
const SAMPLE_TIME: Duration = Duration::from_micros(1500);

/// Most frames of a sample.
const MAX_FRAMES: u32 = 8;

/// All samples of a case in a block last about so long, where that is within [`BURSTS`].
const CASE_TIME: Duration = Duration::from_millis(350);

/// Fewest and most bursts of a case in a block. A burst is two samples of each process; six go once through
/// every order of the three.
const BURSTS: [u32; 2] = [6, 36];

/// Rounds between two blocks of the processes, see `bench`.
const ROUNDS_PER_BLOCK: u32 = 6;

/// Every order of three processes. A burst goes through one of them and back, so that an even drift falls
/// out; six bursts go through all, so that nobody always follows the same other one.
const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

/// How a program ended, and what it said on standard error.
pub(crate) struct Ended {
    pub(crate) status: ExitStatus,
    pub(crate) said: Vec<String>,
}

/// A process that waits for its turns.
pub(crate) struct Stepped {
    child: Child,
    turns: ChildStdin,
    answers: Lines<BufReader<ChildStdout>>,
    said: Option<JoinHandle<Vec<String>>>,
    /// Place by key of the cases that are ready; `None` once it has ended.
    ready: Option<BTreeMap<String, usize>>,
}

impl Stepped {
    /// Starts it and waits until its first group is ready.
    pub(crate) fn start(mut command: Command) -> io::Result<Self> {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let closed = || io::Error::other("no pipe");
        let turns = child.stdin.take().ok_or_else(closed)?;
        let answers = child.stdout.take().ok_or_else(closed)?;
        let errors = child.stderr.take().ok_or_else(closed)?;
        let said = std::thread::spawn(move || {
            BufReader::new(errors)
                .lines()
                .map_while(Result::ok)
                .collect()
        });
        let mut stepped = Self {
            child,
            turns,
            answers: BufReader::new(answers).lines(),
            said: Some(said),
            ready: Some(BTreeMap::new()),
        };
        stepped.wait_for_group()?;
        Ok(stepped)
    }

    fn wait_for_group(&mut self) -> io::Result<()> {
        self.ready = match self.answers.next().transpose()? {
            None => None,
            Some(line) => {
                let keys = line
                    .strip_prefix("ready\t")
                    .ok_or_else(|| unexpected(&line))?;
                let keys = keys.split('\t').filter(|key| !key.is_empty());
                Some(keys.map(str::to_owned).zip(0..).collect())
            }
        };
        Ok(())
    }

    /// One turn; false where the case broke off.
    fn turn(&mut self, turn: &str) -> io::Result<bool> {
        writeln!(self.turns, "{turn}")?;
        match self.answers.next().transpose()?.as_deref() {
            Some("over") => Ok(true),
            Some("broken") => Ok(false),
            Some(line) => Err(unexpected(line)),
            None => Err(io::ErrorKind::UnexpectedEof.into()),
        }
    }

    fn sample(&mut self, case: &str, of: u32, counts: bool) -> io::Result<bool> {
        let place = self.ready.as_ref().and_then(|ready| ready.get(case));
        let place = *place.ok_or_else(|| unexpected(case))?;
        let word = if counts { "sample" } else { "warm" };
        self.turn(&format!("{word} {place} {of}"))
    }

    fn next_group(&mut self) -> io::Result<()> {
        writeln!(self.turns, "next")?;
        self.wait_for_group()
    }

    /// Waits for its end. One that was cut short ends by itself when its pipe closes.
    pub(crate) fn end(mut self) -> io::Result<Ended> {
        if self.ready.is_some() {
            self.child.kill()?;
        }
        let status = self.child.wait()?;
        let said = self.said.take().and_then(|said| said.join().ok());
        Ok(Ended {
            status,
            said: said.unwrap_or_default(),
        })
    }
}

impl Drop for Stepped {
    fn drop(&mut self) {
        // Harmless after its end, and after an error no process stays behind.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

fn unexpected(line: &str) -> io::Error {
    io::Error::other(format!("unexpected answer {line:?}"))
}

/// Steps three processes through all groups of their cases.
///
/// - `frames`: that the processes themselves make a sample of; where it is 1, short frames get more
///
/// # Errors
/// Which process failed, and how.
pub(crate) fn step(
    processes: &mut [Stepped; 3],
    frames: u32,
    seed: u64,
) -> Result<(), (usize, io::Error)> {
    let mut random = SplitMix64::new(seed);
    while processes.iter().any(|process| process.ready.is_some()) {
        let [first, others @ ..] = &*processes;
        let is_in = |case: &&String, process: &Stepped| {
            let ready = process.ready.as_ref();
            ready.is_some_and(|ready| ready.contains_key(*case))
        };
        let ready = first.ready.iter().flat_map(BTreeMap::keys);
        let in_all = ready.filter(|case| others.iter().all(|other| is_in(case, other)));
        let cases: Vec<String> = in_all.cloned().collect();
        step_group(processes, cases, frames, &mut random)?;
        for (index, process) in processes.iter_mut().enumerate() {
            if process.ready.is_some() {
                process.next_group().map_err(|error| (index, error))?;
            }
        }
    }
    Ok(())
}

/// A case that all three have ready.
struct Stepping {
    key: String,
    /// Which of [`ORDERS`] it begins with.
    first_order: usize,
    /// The shortest turn of the rounds that warm up, of one frame.
    shortest: Duration,
    schedule: Schedule,
}

/// How often a case is measured, the same in all processes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Schedule {
    /// Measurements that a sample is the median of.
    of: u32,
    bursts: u32,
}

impl Schedule {
    /// - `frame`: how long one lasts
    /// - `frames`: of a measurement
    fn new(frame: Duration, frames: u32) -> Self {
        let measurement = frame.saturating_mul(frames).as_nanos().max(1);
        let in_range = |count: u128, [least, most]: [u32; 2]| {
            u32::try_from(count).map_or(most, |count| count.clamp(least, most))
        };
        let most = if frames > 1 { 1 } else { MAX_FRAMES };
        let of = in_range(SAMPLE_TIME.as_nanos().div_ceil(measurement), [1, most]);
        let burst = 6 * u128::from(of) * measurement;
        Self {
            of,
            bursts: in_range(CASE_TIME.as_nanos().div_ceil(burst), BURSTS),
        }
    }
}

fn step_group(
    processes: &mut [Stepped; 3],
    cases: Vec<String>,
    frames: u32,
    random: &mut SplitMix64,
) -> Result<(), (usize, io::Error)> {
    let warm_up = Schedule {
        of: 1,
        bursts: WARM_UP_ROUNDS,
    };
    let mut cases: Vec<Stepping> = cases
        .into_iter()
        .zip(0..)
        .map(|(key, first_order)| Stepping {
            key,
            first_order,
            shortest: Duration::MAX,
            schedule: warm_up,
        })
        .collect();
    let orders = random.shuffled(ORDERS.len());
    let mut round = 0;
    while !cases.is_empty() {
        let counts = round >= WARM_UP_ROUNDS;
        if round < WARM_UP_ROUNDS || (round - WARM_UP_ROUNDS).is_multiple_of(ROUNDS_PER_BLOCK) {
            for (index, process) in processes.iter_mut().enumerate() {
                process.turn("block").map_err(|error| (index, error))?;
            }
        }
        let mut broken = Vec::new();
        for place in random.shuffled(cases.len()) {
            let case = &mut cases[place];
            let turn = round as usize + case.first_order;
            let order = ORDERS[orders[turn % ORDERS.len()]];
            for index in order.into_iter().chain(order.into_iter().rev()) {
                let started = Instant::now();
                let sampled = processes[index].sample(&case.key, case.schedule.of, counts);
                if !sampled.map_err(|error| (index, error))? {
                    broken.push(case.key.clone());
                    break;
                }
                case.shortest = case.shortest.min(started.elapsed());
            }
            if round + 1 == WARM_UP_ROUNDS {
                let Schedule { of, bursts } = Schedule::new(case.shortest, frames);
                let bursts = WARM_UP_ROUNDS + bursts;
                case.schedule = Schedule { of, bursts };
            }
        }
        round += 1;
        cases.retain(|case| case.schedule.bursts > round && !broken.contains(&case.key));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// A process that writes its turns to a log, calls a case broken, and ends after its group.
    fn made_up(name: &str, ready: &str, log: &Path, answer: &str) -> io::Result<Stepped> {
        let script = format!(
            "printf 'ready\\t{ready}\\n'; while read -r turn; do echo \"{name} $turn\" >> \"$0\"; \
             case $turn in next) echo bye >&2; exit 0;; block) echo over;; *) {answer};; esac; done"
        );
        let mut command = Command::new("sh");
        command.args(["-c", &script]).arg(log);
        Stepped::start(command)
    }

    fn stepped(keys: [&str; 3], answer: &str) -> (Vec<String>, Result<(), usize>, [Stepped; 3]) {
        let place = tempfile::tempdir().expect("a folder");
        let log = place.path().join("log");
        let [base, null, new] = keys;
        let start = |name, ready, answer| made_up(name, ready, &log, answer).expect("started");
        let mut processes = [
            start("base", base, "echo over"),
            start("null", null, "echo over"),
            start("new", new, answer),
        ];
        let ended = step(&mut processes, 1, 1).map_err(|(index, _)| index);
        let log = std::fs::read_to_string(&log).unwrap_or_default();
        (log.lines().map(str::to_owned).collect(), ended, processes)
    }

    #[test]
    fn bursts_go_there_and_back_in_every_order() {
        let (log, ended, processes) = stepped(["x", "y\\tx", "x"], "echo over");
        assert_eq!(ended, Ok(()));
        // Where all have it: the second process knows it by another place.
        let of = |line: &&String| line.contains("sample");
        let words = |line: &String| line.rsplit_once(' ').map(|(words, _)| words.to_owned());
        let samples: Vec<String> = log.iter().filter(of).filter_map(words).collect();
        let bursts = samples.len() / 6;
        assert!(
            samples.len().is_multiple_of(6) && (6..=36).contains(&bursts),
            "{bursts}"
        );
        let orders: std::collections::BTreeSet<&[String]> = samples.chunks(6).collect();
        assert_eq!(orders.len(), 6, "{orders:?}");
        for burst in &orders {
            let back: Vec<&String> = burst.iter().rev().collect();
            assert!(burst.iter().eq(back), "{burst:?}");
            let has = |words: &str| burst.iter().any(|found| found == words);
            assert!(has("null sample 1") && has("new sample 0"), "{burst:?}");
        }
        assert_eq!(log.iter().filter(|line| line.contains("warm")).count(), 6);
        let blocks = log.iter().filter(|line| line.contains("block")).count();
        assert_eq!(blocks, 3 * (1 + bursts.div_ceil(6)));
        for process in processes {
            let ended = process.end().expect("ended");
            assert!(ended.status.success());
            assert_eq!(ended.said, ["bye"]);
        }
    }

    #[test]
    fn short_frames_are_measured_more_often_and_long_ones_often_enough() {
        let of = |ms: f64, frames| {
            let schedule = Schedule::new(Duration::from_secs_f64(1e-3 * ms), frames);
            (schedule.of, schedule.bursts)
        };
        assert_eq!([of(100.0, 1), of(3.0, 1)], [(1, 6), (1, 20)]);
        assert_eq!([of(0.5, 1), of(0.01, 1)], [(3, 36), (8, 36)]);
        // Samples that are means of many frames are long already.
        assert_eq!([of(0.5, 20), of(0.1, 20)], [(1, 6), (1, 30)]);
        assert_eq!(Schedule::new(Duration::ZERO, 1).of, 8);
        assert_eq!(Schedule::new(Duration::MAX, 100).bursts, 6);
    }

    #[test]
    fn a_case_that_breaks_off_or_that_one_lacks_is_left_out() {
        let (log, ended, _) = stepped(["x", "x", "x"], "echo broken");
        assert_eq!(ended, Ok(()));
        assert!(log.iter().all(|line| !line.contains("sample")), "{log:?}");
        let (log, ended, _) = stepped(["x", "x", "z"], "echo over");
        assert_eq!(ended, Ok(()));
        assert!(log.iter().all(|line| line.ends_with("next")), "{log:?}");
    }

    #[test]
    fn a_process_that_ends_or_says_something_else_is_named() {
        for answer in ["exit 7", "echo what"] {
            let (_, ended, _) = stepped(["x", "x", "x"], answer);
            assert_eq!(ended, Err(2), "{answer}");
        }
        let nobody = Stepped::start(Command::new("/nowhere/terrafill"));
        assert!(nobody.is_err());
    }
}
