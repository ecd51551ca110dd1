// SPDX-License-Identifier: MIT OR Apache-2.0
//! libFuzzer program; see `terrafill_fixtures::fuzz`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use terrafill_fixtures::fuzz::{elevation, target::Target};

static TARGET: Target = Target::new(elevation::BRANCHES, elevation::check);

fuzz_target!(|input: &[u8]| TARGET.execute(input));
