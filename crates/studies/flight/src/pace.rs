// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the pieces of a surface are made during a flight.

/// Pieces a frame of the ways that have such a number.
const FEW: usize = 16;
const MANY: usize = 128;
/// A budget that a flight does not fit into.
const TIGHT_BYTES: u64 = 8 * MEGABYTE;
const MEGABYTE: u64 = 1_000_000;

/// One way of making them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pace {
    pub(crate) making: Making,
    /// Of the pieces; `None`: as the scene says.
    pub(crate) budget_bytes: Option<u64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Making {
    /// A frame makes all it wants and keeps nothing for the next.
    Anew,
    /// A frame waits for what it wants and is not there.
    Wait,
    /// So many after each frame, on the thread that draws.
    AFrame(usize),
    /// By a thread of its own.
    Background,
}

impl Pace {
    const fn new(making: Making) -> Self {
        Self {
            making,
            budget_bytes: None,
        }
    }

    pub(crate) const ALL: [Self; 6] = [
        Self::new(Making::Anew),
        Self::new(Making::Wait),
        Self::new(Making::AFrame(MANY)),
        Self::new(Making::AFrame(FEW)),
        Self::new(Making::Background),
        Self {
            making: Making::AFrame(MANY),
            budget_bytes: Some(TIGHT_BYTES),
        },
    ];

    /// As a condition of a case.
    pub(crate) fn name(self) -> String {
        let making = match self.making {
            Making::Anew => "anew".to_owned(),
            Making::Wait => "wait".to_owned(),
            Making::AFrame(pieces) => format!("{pieces} a frame"),
            Making::Background => "background".to_owned(),
        };
        match self.budget_bytes {
            None => making,
            Some(bytes) => format!("{making} in {} MB", bytes / MEGABYTE),
        }
    }
}
