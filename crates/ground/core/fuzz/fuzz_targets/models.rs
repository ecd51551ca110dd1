// SPDX-License-Identifier: MIT OR Apache-2.0
//! libFuzzer program; see `terrafill_fixtures::fuzz`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::sync::Once;
use terrafill_fixtures::fuzz::{models, target::Target};

static TARGET: Target = Target::new(models::BRANCHES, models::check);

/// libFuzzer's hook ends the process at every panic. The reader of OBJ files catches those of `spade`; one that
/// nobody catches ends the process all the same.
static QUIET: Once = Once::new();

fuzz_target!(|input: &[u8]| {
    QUIET.call_once(|| std::panic::set_hook(Box::new(|panic| eprintln!("{panic}"))));
    TARGET.execute(input);
});
