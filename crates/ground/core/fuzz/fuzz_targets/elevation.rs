// SPDX-License-Identifier: MIT OR Apache-2.0
//! libFuzzer program; see `terrafill_fixtures::fuzz`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::sync::Mutex;
use terrafill_fixtures::fuzz::{elevation, reached::Reached};

static REACHED: Mutex<Option<Reached>> = Mutex::new(None);

/// The counters are written this often: libFuzzer leaves without running destructors.
const EXECUTIONS_PER_REPORT: u64 = 256;

fuzz_target!(|input: &[u8]| {
    let mut guard = REACHED.lock().expect("a panic ends the process");
    let reached = guard.get_or_insert_with(|| Reached::new(elevation::BRANCHES));
    if let Err(find) = elevation::check(input, reached) {
        panic!("{find}");
    }
    if reached.executions().is_multiple_of(EXECUTIONS_PER_REPORT)
        && let Some(path) = std::env::var_os("TERRAFILL_FUZZ_COUNTERS")
    {
        let written = reached.write(path.as_ref());
        written.expect("the counters' file can be written");
    }
});
