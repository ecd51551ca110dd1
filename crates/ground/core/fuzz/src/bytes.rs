// SPDX-License-Identifier: MIT OR Apache-2.0
//! A fuzzer's bytes as a source of choices.
//!
//! Written here rather than taken from a crate: the meaning of every file among the seeds and
//! regressions depends on it, so it must never change under them.

/// What is left of an input. Once exhausted it yields zeros, so every input is a complete one.
pub struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    /// All of `input`.
    pub fn new(input: &'a [u8]) -> Self {
        Self(input)
    }

    /// Whether only zeros follow.
    pub fn is_exhausted(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        match self.0.split_first() {
            Some((first, rest)) => {
                self.0 = rest;
                *first
            }
            None => 0,
        }
    }

    /// 0 … `count` − 1 from one byte; small numbers are a little more frequent.
    pub fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count.max(1)
    }

    /// One of `choices`.
    pub fn choose<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// `[0, 1)` in steps of 2⁻³².
    pub fn unit(&mut self) -> f64 {
        let bytes = [self.byte(), self.byte(), self.byte(), self.byte()];
        f64::from(u32::from_le_bytes(bytes)) / 4_294_967_296.0
    }
}
