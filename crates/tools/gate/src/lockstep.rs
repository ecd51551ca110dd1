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

/// A sample lasts at least so long, as the median of as many frames: on a busy machine frames of less than a
/// millisecond differ by a fifth, and a process that gets its turn has cold caches.
const SAMPLE_TIME: Duration = Duration::from_millis(8);

/// Most frames of a sample.
pub(crate) const MAX_FRAMES: u32 = 32;

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
/// - `bursts`: of each case; a burst is six samples, two of each process
/// - `max_frames`: most frames of a sample
///
/// # Errors
/// Which process failed, and how.
pub(crate) fn step(
    processes: &mut [Stepped; 3],
    bursts: u32,
    max_frames: u32,
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
        step_group(processes, cases, [bursts, max_frames], &mut random)?;
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
    /// The shortest turn so far.
    shortest: Duration,
    /// Frames of a sample, the same in all processes.
    frames: u32,
}

fn step_group(
    processes: &mut [Stepped; 3],
    cases: Vec<String>,
    [bursts, max_frames]: [u32; 2],
    random: &mut SplitMix64,
) -> Result<(), (usize, io::Error)> {
    let mut cases: Vec<Stepping> = cases
        .into_iter()
        .map(|key| Stepping {
            key,
            shortest: Duration::MAX,
            frames: 1,
        })
        .collect();
    let orders = random.shuffled(ORDERS.len());
    let rounds = if cases.is_empty() {
        0
    } else {
        WARM_UP_ROUNDS + bursts
    };
    for round in 0..rounds {
        let counts = round >= WARM_UP_ROUNDS;
        for (index, process) in processes.iter_mut().enumerate() {
            process.turn("block").map_err(|error| (index, error))?;
        }
        let mut broken = Vec::new();
        for place in random.shuffled(cases.len()) {
            let order = ORDERS[orders[(round as usize + place) % ORDERS.len()]];
            let case = &mut cases[place];
            for index in order.into_iter().chain(order.into_iter().rev()) {
                let started = Instant::now();
                let sampled = processes[index].sample(&case.key, case.frames, counts);
                if !sampled.map_err(|error| (index, error))? {
                    broken.push(case.key.clone());
                    break;
                }
                case.shortest = case.shortest.min(started.elapsed());
            }
            if round + 1 == WARM_UP_ROUNDS {
                case.frames = frames_of(case.shortest).min(max_frames);
            }
        }
        cases.retain(|case| !broken.contains(&case.key));
    }
    Ok(())
}

/// Frames that last as long as a sample should.
fn frames_of(frame: Duration) -> u32 {
    let frames = SAMPLE_TIME.as_nanos().div_ceil(frame.as_nanos().max(1));
    u32::try_from(frames).map_or(MAX_FRAMES, |frames| frames.clamp(1, MAX_FRAMES))
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
        let ended = step(&mut processes, 6, MAX_FRAMES, 1).map_err(|(index, _)| index);
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
        assert_eq!(samples.len(), 36);
        let orders: std::collections::BTreeSet<&[String]> = samples.chunks(6).collect();
        assert_eq!(orders.len(), 6, "{orders:?}");
        for burst in &orders {
            let back: Vec<&String> = burst.iter().rev().collect();
            assert!(burst.iter().eq(back), "{burst:?}");
            let has = |words: &str| burst.iter().any(|found| found == words);
            assert!(has("null sample 1") && has("new sample 0"), "{burst:?}");
        }
        assert_eq!(log.iter().filter(|line| line.contains("warm")).count(), 6);
        assert_eq!(log.iter().filter(|line| line.contains("block")).count(), 21);
        for process in processes {
            let ended = process.end().expect("ended");
            assert!(ended.status.success());
            assert_eq!(ended.said, ["bye"]);
        }
    }

    #[test]
    fn samples_last_so_long_and_have_a_frame_at_least() {
        let of = |ms: f64| frames_of(Duration::from_secs_f64(1e-3 * ms));
        assert_eq!([of(100.0), of(8.0), of(3.0), of(0.3)], [1, 1, 3, 27]);
        assert_eq!(
            [frames_of(Duration::ZERO), frames_of(Duration::MAX)],
            [32, 1]
        );
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
