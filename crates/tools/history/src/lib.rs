// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs of many commits and machines: kept in one file, searched for changes, and compared.
//!
//! A [`Store`] is appended to and never edited. A run is a [`Record`] of its [`Machine`], the kind of
//! machine, driver and options that figures belong to, and of its commit, which a [`Repository`] places
//! among others. [`changes`] finds where figures changed over the commits; [`compare`] sets two runs side
//! by side and [`by_device`] many. All of it is advisory where times are concerned, since those of two
//! jobs are not paired. Nothing here names a study or opens a device.

mod bisect;
mod change;
mod compare;
mod control;
mod device;
mod error;
mod exchange;
mod output;
mod page;
mod primary;
mod rank;
mod record;
mod repository;
mod scatter;
mod series;
mod store;
pub mod threshold;

pub use bisect::{Bisection, quoted};
pub use change::{Change, ChangeKind, Changes, Undecided, changes};
pub use compare::{CaseTimes, Comparison, SideFacts, StudyTimes, TimeStanding, compare};
pub use device::{CONTROL, Device, DeviceCell, DeviceRow, DeviceTable, by_device};
pub use error::HistoryError;
pub use exchange::{export, read_tables};
pub use output::{change_line, comparison_csv, device_csv, trend_lines};
pub use page::{Trends, comparison_page, device_page, history_page, runs_in_words};
pub use primary::Primary;
pub use record::{CaseRecord, Machine, Record, clean, is_dirty};
pub use repository::{CommitFacts, Position, Repository};
pub use series::{Point, Series};
pub use store::{Absent, Added, Entry, Overview, STORE_SCHEMA, Store};
