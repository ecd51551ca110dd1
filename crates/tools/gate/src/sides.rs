// SPDX-License-Identifier: MIT OR Apache-2.0
//! The two programs of a time gate, and the order in which their processes start.

use crate::GateError;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// Which of the two programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// What is compared with.
    Base,
    /// What is to be decided about.
    New,
}

impl Side {
    /// Folder of its run, and its word in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Base => "base",
            Self::New => "new",
        }
    }

    /// Its place in arrays of base and new.
    pub(crate) fn index(self) -> usize {
        usize::from(self == Self::New)
    }
}

/// Case → process → sample, from 1 → milliseconds.
pub type Times = BTreeMap<String, BTreeMap<u32, BTreeMap<u32, f64>>>;

/// How the two programs are measured against one another.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TimingOrder {
    /// Frame by frame, their processes all alive.
    #[default]
    LockStep,
    /// Process by process.
    Turns {
        /// Why not in lock-step.
        why: String,
    },
}

/// Three processes in lock-step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trio {
    /// Number of a process of the base.
    pub base: u32,
    /// Number of the base's other process.
    pub null: u32,
    /// Number of the new program's process.
    pub new: u32,
}

/// Orders in which the three of a block start, by turns. A process that starts later is faster on a loaded core:
/// of 5,380 blocks of the same work the second was 0.5 % and the third 1.6 % faster than the first. Each is first,
/// second and last equally often, also in every second block alone, where blocks take two cores by turns. In the sixth
/// the new program is the second: so the first five, which are a first look, favour it by less than 0.1 %.
const START_ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [2, 1, 0],
    [1, 2, 0],
    [1, 0, 2],
    [2, 0, 1],
    [0, 2, 1],
];

impl Trio {
    /// The three of block `number`, from 0. Their numbers are in the order in which they start, so whatever goes by
    /// a number is exchanged between the sides from block to block.
    #[must_use]
    pub fn of_block(number: u32) -> Self {
        let order = START_ORDERS[number as usize % START_ORDERS.len()];
        let mut processes = [0; 3];
        for (process, place) in (3 * number + 1..).zip(order) {
            processes[place] = process;
        }
        let [base, null, new] = processes;
        Self { base, null, new }
    }

    /// Number of the block, from 0.
    #[must_use]
    pub fn block(self) -> u32 {
        self.base.saturating_sub(1) / 3
    }

    /// Places in [`Trio::processes`] in the order in which they start.
    #[must_use]
    pub fn start_order(self) -> [usize; 3] {
        let processes = self.processes().map(|(_, process)| process);
        let mut order = [0, 1, 2];
        order.sort_by_key(|place| processes[*place]);
        order
    }

    /// The processes with their sides.
    #[must_use]
    pub fn processes(self) -> [(Side, u32); 3] {
        [
            (Side::Base, self.base),
            (Side::Base, self.null),
            (Side::New, self.new),
        ]
    }
}

/// Two programs that can be measured, process by process.
pub trait Sides {
    /// How they are measured.
    fn way(&self) -> &TimingOrder;

    /// Whether all processes of a block run on one core.
    fn is_on_one_core(&self) -> bool {
        false
    }

    /// Runs three processes in lock-step, which time these cases; for [`TimingOrder::LockStep`]. Samples
    /// 2 *k* − 1 and 2 *k* of each make burst *k*.
    ///
    /// # Errors
    /// [`GateError`] when one does not end well.
    fn run_together(&mut self, trio: Trio, cases: &BTreeSet<String>) -> Result<(), GateError>;

    /// Runs one process of a side, which times these cases; for [`TimingOrder::Turns`].
    ///
    /// # Errors
    /// [`GateError`] when it does not end well.
    fn run(&mut self, side: Side, process: u32, cases: &BTreeSet<String>) -> Result<(), GateError>;

    /// Times of this metric by all processes of a side so far.
    ///
    /// # Errors
    /// [`GateError::Run`].
    fn times(&mut self, side: Side, metric: &str) -> Result<Times, GateError>;

    /// Lets both programs verify their pictures once more, each in a fresh process.
    ///
    /// - `number`: from 1; by its parity base or new goes first
    ///
    /// # Errors
    /// As [`Sides::run`].
    fn verify_again(&mut self, number: u32) -> Result<(), GateError>;

    /// What a process of a side measured of this metric while it verified, by the number of the verification: 0
    /// is the first one.
    fn setups(&self, side: Side, metric: &str) -> Times;

    /// Time since the gate began.
    fn elapsed(&self) -> Duration;

    /// Hears what comes next.
    fn say(&mut self, what: &str);
}
