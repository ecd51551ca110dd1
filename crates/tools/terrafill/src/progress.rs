// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a run is doing: a bar on a terminal, elsewhere a line at least every half minute.

use crate::outcome::complain;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal as _;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use terrafill_results::{GroupDuration, RunError, RunFolder, append_durations};
use terrafill_study::Progress;

/// Longest silence where there is no terminal: what watches a job takes longer ones for a hang.
const LONGEST_SILENCE: Duration = Duration::from_secs(25);

/// Says what a run is doing until it is dropped.
pub(crate) enum Said {
    Bar(ProgressBar),
    Lines {
        steps: Option<Sender<String>>,
        writer: Option<JoinHandle<()>>,
    },
}

impl Said {
    /// - `process`, `processes`: which of how many, from 0
    /// - `at_most`: how many there are at most, where more than these are taken
    pub(crate) fn new(process: u32, processes: u32, at_most: Option<u32>) -> Self {
        Self::titled(title(process, processes, at_most))
    }

    /// - `prefix`: what every line begins with
    pub(crate) fn titled(prefix: String) -> Self {
        if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(0).with_prefix(prefix);
            let style = "{prefix} {bar:30} {pos}/{len} · {eta} · {msg}";
            if let Ok(style) = ProgressStyle::with_template(style) {
                bar.set_style(style);
            }
            return Self::Bar(bar);
        }
        let (steps, said) = channel();
        Self::Lines {
            steps: Some(steps),
            writer: Some(std::thread::spawn(move || write_lines(&prefix, &said))),
        }
    }
}

/// Which process it is, and how many are left.
fn title(process: u32, processes: u32, at_most: Option<u32>) -> String {
    let all = at_most.unwrap_or(processes);
    let bound = if at_most.is_some() { " at most" } else { "" };
    let number = process + 1;
    match all.saturating_sub(number) {
        0 => format!("process {number}/{all}"),
        left => format!("process {number}/{all}{bound}, {left}{bound} left"),
    }
}

/// Writes the newest step whenever a silence has lasted long enough, even within one long step.
fn write_lines(prefix: &str, said: &Receiver<String>) {
    let mut newest = "starting".to_owned();
    loop {
        let silent_since = Instant::now();
        loop {
            let left = LONGEST_SILENCE.saturating_sub(silent_since.elapsed());
            match said.recv_timeout(left) {
                Ok(step) => newest = step,
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
        complain(format!("{prefix}, {newest}"));
    }
}

impl Progress for Said {
    fn step(&mut self, done: usize, all: usize, what: &str) {
        match self {
            Self::Bar(bar) => {
                bar.set_length(all as u64);
                bar.set_position(done as u64);
                bar.set_message(what.to_owned());
            }
            Self::Lines { steps, .. } => {
                if let Some(steps) = steps {
                    // A writer that has ended has nobody to write to.
                    drop(steps.send(format!("step {done} of {all}: {what}")));
                }
            }
        }
    }
}

/// Says what a run is doing, and writes down how long each group took.
pub(crate) struct Timed<'a> {
    said: Said,
    folder: &'a RunFolder,
    process: u32,
    since: Instant,
    written: Result<(), RunError>,
}

impl<'a> Timed<'a> {
    pub(crate) fn new(said: Said, folder: &'a RunFolder, process: u32) -> Self {
        Self {
            said,
            folder,
            process,
            since: Instant::now(),
            written: Ok(()),
        }
    }

    /// Ends what it says; the first table row that could not be written, if any.
    pub(crate) fn end(self) -> Result<(), RunError> {
        self.written
    }
}

impl Progress for Timed<'_> {
    fn step(&mut self, done: usize, all: usize, what: &str) {
        self.said.step(done, all, what);
    }

    fn measured(&mut self, first: &str) {
        let row = GroupDuration {
            first_case: first.to_owned(),
            process: self.process,
            seconds: self.since.elapsed().as_secs_f64(),
        };
        self.since = Instant::now();
        if self.written.is_ok() {
            self.written = append_durations(self.folder.path(), &[row]);
        }
    }
}

impl Drop for Said {
    fn drop(&mut self) {
        match self {
            Self::Bar(bar) => bar.finish_and_clear(),
            Self::Lines { steps, writer } => {
                drop(steps.take());
                if let Some(writer) = writer.take() {
                    drop(writer.join());
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processes_are_numbered_and_what_is_left_is_said() {
        assert_eq!(title(0, 1, None), "process 1/1");
        assert_eq!(title(0, 5, None), "process 1/5, 4 left");
        assert_eq!(title(4, 5, None), "process 5/5");
        // An ablation that goes on says its bound.
        assert_eq!(
            title(5, 5, Some(36)),
            "process 6/36 at most, 30 at most left"
        );
    }
}
