// SPDX-License-Identifier: MIT OR Apache-2.0
//! One core for all processes that are compared.
//!
//! A process stays on the cores that it was first put on, and what else runs there slows it for as long as it
//! lives. Two processes of the same work on different cores of a busy machine differ by 15 % of CPU time, on
//! one core by 3 %. A software driver that sees one core starts no threads, which wait for one another else.

use std::path::Path;
use std::process::{Command, Stdio};

/// The program of util-linux that starts another one on given cores.
const TASKSET: &str = "taskset";

/// Cores that processes can be put on, one after another.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Cores(Vec<u32>);

impl Cores {
    /// Those that this process may use; none where processes cannot be put on cores.
    pub(crate) fn of_this_process() -> Self {
        let mut taskset = Command::new(TASKSET);
        let known = taskset.arg("--version").stdin(Stdio::null());
        let known = known.stdout(Stdio::null()).stderr(Stdio::null()).status();
        if !known.is_ok_and(|status| status.success()) {
            return Self::default();
        }
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mut lines = status.lines();
        let list = lines.find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
        Self(list.map(parse).unwrap_or_default())
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A command that runs `program` on the core of block `number`.
    pub(crate) fn command(&self, program: &Path, number: u32) -> Command {
        let place = number as usize % self.0.len().max(1);
        let Some(core) = self.0.get(place) else {
            return Command::new(program);
        };
        let mut command = Command::new(TASKSET);
        command.arg("--cpu-list").arg(core.to_string()).arg(program);
        command
    }
}

/// `0-2,5` as numbers; none where it is no such list.
fn parse(list: &str) -> Vec<u32> {
    let range = |part: &str| -> Option<std::ops::RangeInclusive<u32>> {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.parse().ok()?..=last.parse().ok()?)
    };
    let ranges: Option<Vec<_>> = list.trim().split(',').map(range).collect();
    ranges.into_iter().flatten().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_cores_are_read() {
        assert_eq!(parse("\t0-1\n"), [0, 1]);
        assert_eq!(parse("3"), [3]);
        assert_eq!(parse("0-2,5,8-9"), [0, 1, 2, 5, 8, 9]);
        for wrong in ["", "a", "1-", "0,x"] {
            assert_eq!(parse(wrong), [0_u32; 0], "{wrong}");
        }
    }

    #[test]
    fn blocks_take_the_cores_by_turns() {
        let of = |cores: &[u32], number| {
            let command = Cores(cores.to_vec()).command(Path::new("bench"), number);
            let words = std::iter::once(command.get_program()).chain(command.get_args());
            let words: Vec<String> = words.map(|w| w.to_string_lossy().into_owned()).collect();
            words.join(" ")
        };
        assert_eq!(of(&[4, 7], 0), "taskset --cpu-list 4 bench");
        assert_eq!(of(&[4, 7], 3), "taskset --cpu-list 7 bench");
        assert_eq!(of(&[], 3), "bench");
    }
}
