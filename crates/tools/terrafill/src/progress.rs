// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a run is doing: a bar on a terminal, elsewhere a line at once and then every few seconds.

use crate::outcome::complain;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal as _;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use terrafill_results::{GroupDuration, RunError, RunFolder, append_durations};
use terrafill_study::Progress;

/// From line to line where there is no terminal: what watches a job takes silence for a hang.
const INTERVAL: Duration = Duration::from_secs(5);

/// From here on the time that is left is said in minutes.
const LONG_S: f64 = 120.0;

/// Says what a run is doing until it is dropped.
pub(crate) enum Said {
    Bar(ProgressBar),
    Lines {
        steps: Option<Sender<Step>>,
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

/// How far a run is.
pub(crate) struct Step {
    done: usize,
    all: usize,
    what: String,
}

impl Step {
    /// - `passed`: since the first step was begun
    fn line(&self, prefix: &str, passed: Duration) -> String {
        let Self { done, all, what } = self;
        let left_s = passed.as_secs_f64() * all.saturating_sub(*done) as f64 / *done as f64;
        let left = match done {
            0 => "time left not known yet".to_owned(),
            _ if left_s < LONG_S => format!("about {left_s:.0} s left"),
            _ => format!("about {:.0} min left", left_s / 60.0),
        };
        format!("{prefix}; step {done} of {all}, {left}: {what}")
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

/// Writes the first step, and then the newest after each interval, even within one long step.
fn write_lines(prefix: &str, said: &Receiver<Step>) {
    let Ok(mut newest) = said.recv() else {
        return;
    };
    let started = Instant::now();
    loop {
        complain(newest.line(prefix, started.elapsed()));
        let said_at = Instant::now();
        loop {
            let left = INTERVAL.saturating_sub(said_at.elapsed());
            match said.recv_timeout(left) {
                Ok(step) => newest = step,
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
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
                    let what = what.to_owned();
                    drop(steps.send(Step { done, all, what }));
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
    fn a_line_has_totals_and_the_time_that_is_left() {
        let line = |done, seconds| {
            let what = "globe".to_owned();
            let step = Step {
                done,
                all: 40,
                what,
            };
            step.line("process 1/5, 4 left", Duration::from_secs(seconds))
        };
        let begins = "process 1/5, 4 left; step";
        assert_eq!(
            line(10, 5),
            format!("{begins} 10 of 40, about 15 s left: globe")
        );
        assert_eq!(
            line(10, 60),
            format!("{begins} 10 of 40, about 3 min left: globe")
        );
        // Negative control: from no step nothing is concluded.
        assert_eq!(
            line(0, 5),
            format!("{begins} 0 of 40, time left not known yet: globe")
        );
    }

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
