// SPDX-License-Identifier: MIT OR Apache-2.0
//! libFuzzer program; see `terrafill_fixtures::fuzz`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::sync::{Mutex, Once};
use terrafill_fixtures::fuzz::{models, reached::Reached};

static REACHED: Mutex<Option<Reached>> = Mutex::new(None);

/// libFuzzer's hook ends the process at every panic. The reader of OBJ files catches those of `spade`; one that
/// nobody catches ends the process all the same.
static QUIET: Once = Once::new();

/// The counters are written this often: libFuzzer leaves without running destructors.
const EXECUTIONS_PER_REPORT: u64 = 256;

/// Nanoseconds that this thread has been on a processor; `None` where the system does not tell. By
/// the clock an input would take longer on a busy machine.
fn cpu_nanos() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok()
}

/// No file may take longer.
const MAX_CPU_NANOS: u64 = 20_000_000_000;

fuzz_target!(|input: &[u8]| {
    QUIET.call_once(|| std::panic::set_hook(Box::new(|panic| eprintln!("{panic}"))));
    let before = cpu_nanos();
    let mut guard = REACHED.lock().expect("a panic ends the process");
    let reached = guard.get_or_insert_with(|| Reached::new(models::BRANCHES));
    if let Err(find) = models::check(input, reached) {
        panic!("{find}");
    }
    let spent = before.and_then(|before| Some(cpu_nanos()? - before));
    if let Some(spent) = spent.filter(|spent| *spent > MAX_CPU_NANOS) {
        panic!("takes {spent} ns of CPU time");
    }
    if reached.executions().is_multiple_of(EXECUTIONS_PER_REPORT)
        && let Some(path) = std::env::var_os("TERRAFILL_FUZZ_COUNTERS")
    {
        let written = reached.write(path.as_ref());
        written.expect("the counters' file can be written");
    }
});
