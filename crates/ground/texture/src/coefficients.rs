// SPDX-License-Identifier: MIT OR Apache-2.0
//! Minimax coefficients of the arctangent on [0, 1], by family.
//!
//! The table is `coefficients.csv`, which `cargo run -p terrafill-texture --example coefficients`
//! prints; the tests of that example compare. No coefficient is written anywhere else.

use crate::angle_core::AngleCore;
use std::sync::LazyLock;

/// One core's coefficients, ascending powers.
pub(crate) struct Coefficients {
    core: String,
    /// Largest error in exact arithmetic: radians, or relative where the weight is.
    pub(crate) error: f64,
    pub(crate) numerator: Vec<f64>,
    /// Empty for polynomials.
    pub(crate) denominator: Vec<f64>,
}

/// Every core that has coefficients.
static COEFFICIENTS: LazyLock<Vec<Coefficients>> = LazyLock::new(|| {
    let lines = include_str!("coefficients.csv").lines().skip(1);
    lines.map(Coefficients::of_line).collect()
});

impl Coefficients {
    /// Those of a core; `None` where it has none in the table.
    pub(crate) fn of(core: AngleCore) -> Option<&'static Self> {
        let name = core.name();
        COEFFICIENTS.iter().find(|row| row.core == name)
    }

    fn of_line(line: &str) -> Self {
        let number = |text: &str| text.parse().expect("the checked-in table has numbers");
        let cells: Vec<&str> = line.split(',').collect();
        let list = |at: usize| cells[at].split_whitespace().map(number).collect();
        Self {
            core: cells[0].to_owned(),
            error: number(cells[1]),
            numerator: list(2),
            denominator: list(3),
        }
    }
}
