// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run that is told to stop says what is left of it.

use crate::outcome::{Failure, complain};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// What shells add to a signal's number for the exit code of what it ended.
const ENDED_BY_SIGNAL: i32 = 128;

/// Exit codes of what [`say_when_stopped`] ends.
pub(crate) const STOPPED_ENDS: [i32; 3] = [
    ENDED_BY_SIGNAL + SIGINT,
    ENDED_BY_SIGNAL + SIGTERM,
    ENDED_BY_SIGNAL + SIGHUP,
];

/// What is left of a run that did not end, and how to go on.
///
/// - `out`: the run's folder
pub(crate) fn what_is_kept(out: &Path) -> String {
    let out = out.display();
    format!("{out} keeps what was measured; the same command with --resume goes on")
}

/// From now on, ends this process by a message when it is interrupted, terminated or left by its terminal.
/// Each value was written when it was measured, so nothing is lost but the sample that was being taken.
/// Further processes of the run end by themselves, since their standard input does.
///
/// - `out`: the run's folder
pub(crate) fn say_when_stopped(out: &Path) -> Result<(), Failure> {
    when_stopped(what_is_kept(out), || {})
}

/// The same of a gate, whose folder keeps the copies of its programs no longer.
///
/// - `out`: the gate's folder
pub(crate) fn clear_when_stopped(out: &Path) -> Result<(), Failure> {
    let words = format!(
        "nothing is decided; the same command begins {} anew",
        out.display()
    );
    let out = out.to_owned();
    when_stopped(words, move || terrafill_gate::clear_processes(&out))
}

/// Whether a signal is being answered.
static IS_STOPPING: AtomicBool = AtomicBool::new(false);

/// Waits for the end where a signal is being answered: what failed because of it is not said as well.
pub(crate) fn wait_if_stopping() {
    while IS_STOPPING.load(Ordering::SeqCst) {
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn when_stopped(kept: String, last: impl FnOnce() + Send + 'static) -> Result<(), Failure> {
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP]).map_err(Failure::bad_input)?;
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            let name = match signal {
                SIGINT => "SIGINT",
                SIGTERM => "SIGTERM",
                _ => "SIGHUP",
            };
            IS_STOPPING.store(true, Ordering::SeqCst);
            last();
            complain(format!("stopped by {name}: {kept}"));
            // Not by `std::process::exit`: a driver's own clean-up at exit fails while its threads still draw.
            signal_hook::low_level::exit(ENDED_BY_SIGNAL + signal);
        }
    });
    Ok(())
}
