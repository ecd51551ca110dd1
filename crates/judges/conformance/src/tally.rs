// SPDX-License-Identifier: MIT OR Apache-2.0
//! Verdicts of many frames of one case, such as those of a flight.

use crate::{ErrorFigures, Verdict, verdict};

/// Wrong frames that a reason names.
const MAX_NAMED: usize = 5;

/// What the frames of a case showed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// Frames compared.
    pub frames: u32,
    /// Those that are wrong, each with its reason.
    pub wrong: Vec<(u32, String)>,
    /// Pixels outside the boundary band that differ; most of all frames.
    pub outside_px: u64,
}

impl Tally {
    /// Adds a frame: how it differs from its reference, or why it could not be compared.
    pub fn add(&mut self, frame: u32, figures: Result<&ErrorFigures, String>) {
        self.frames += 1;
        let reason = match figures {
            Ok(figures) => {
                self.outside_px = self.outside_px.max(figures.mismatched_px_outside_band);
                match verdict(figures) {
                    Verdict::Pass => return,
                    Verdict::Fail(reasons) => reasons.join(", "),
                }
            }
            Err(error) => error,
        };
        self.wrong.push((frame, reason));
    }

    /// Whether none is wrong.
    #[must_use]
    pub fn is_right(&self) -> bool {
        self.wrong.is_empty()
    }

    /// How many frames are wrong, and the first of them; empty where none is.
    #[must_use]
    pub fn reason(&self) -> String {
        if self.is_right() {
            return String::new();
        }
        let named = self.wrong.iter().take(MAX_NAMED);
        let named: Vec<String> = named
            .map(|(frame, reason)| format!("frame {frame}: {reason}"))
            .collect();
        let wrong = self.wrong.len();
        format!("{wrong} of {} frames; {}", self.frames, named.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_that_is_wrong_or_was_not_compared_is_named() {
        let right = ErrorFigures::default();
        let mut tally = Tally::default();
        tally.add(0, Ok(&right));
        assert!(tally.is_right() && tally.reason().is_empty());
        let wrong = ErrorFigures {
            mismatched_px_outside_band: 7,
            ..right
        };
        tally.add(1, Ok(&wrong));
        tally.add(2, Err("lost".to_owned()));
        assert!(!tally.is_right() && tally.frames == 3 && tally.outside_px == 7);
        let reason = tally.reason();
        assert!(reason.starts_with("2 of 3 frames; frame 1: "), "{reason}");
        assert!(reason.ends_with("frame 2: lost"), "{reason}");
    }
}
