// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ways to compute an arctangent, by name.

use crate::lookup::{Filter, LookupTable, TexelFormat};

/// What error a family's coefficients make smallest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weight {
    /// The absolute error.
    Absolute,
    /// The error relative to the angle.
    Relative,
    /// The absolute error with slope 1 at 0 and π/4 at 1 kept, so that octants meet.
    Pinned,
}

/// How the arctangent of a ratio is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleCore {
    /// The device's own `atan2`, whatever that is.
    Native,
    /// A table.
    Lookup {
        /// Entries.
        texels: u16,
        /// How they are stored.
        format: TexelFormat,
        /// How they are read.
        filter: Filter,
    },
    /// `x P(x²)`.
    Odd {
        /// Highest power of x: 3, 5, … 15.
        degree: u8,
        /// What its coefficients make smallest.
        weight: Weight,
    },
    /// `x P(x)` on [0, 1].
    Dense {
        /// Highest power of x: 2 … 8.
        degree: u8,
    },
    /// `x (c₀ + c₁ x + c₂ x²)` on [0, 1] with π/4 kept at 1, to four decimals: what CesiumJS takes for
    /// both angles of a texture coordinate (`czm_fastApproximateAtan`), after Drobot (2014), "Low level
    /// optimizations for GCN". Here to be measured, not to be chosen.
    CesiumCubic,
    /// `x P(x²) / Q(x²)`.
    Rational {
        /// Degree of P.
        numerator: u8,
        /// Degree of Q.
        denominator: u8,
        /// What its coefficients make smallest.
        weight: Weight,
    },
}

impl AngleCore {
    /// Stable name: `atan2-native`, `lut-256-r16-linear`, `odd-7`, `odd-pin-7`, `dense-5`,
    /// `cubic-cesium`, `rat-2-2`, `rat-rel-2-2`.
    #[must_use]
    pub fn name(self) -> String {
        let infix = |weight| match weight {
            Weight::Absolute => "",
            Weight::Relative => "rel-",
            Weight::Pinned => "pin-",
        };
        match self {
            Self::Native => "atan2-native".to_owned(),
            Self::Lookup {
                texels,
                format,
                filter,
            } => format!("lut-{texels}-{}-{}", format.name(), filter.name()),
            Self::Odd { degree, weight } => format!("odd-{}{degree}", infix(weight)),
            Self::Dense { degree } => format!("dense-{degree}"),
            Self::CesiumCubic => "cubic-cesium".to_owned(),
            Self::Rational {
                numerator,
                denominator,
                weight,
            } => format!("rat-{}{numerator}-{denominator}", infix(weight)),
        }
    }

    /// Every core: what [`Self::name`] may say.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self::Native];
        let weights = [Weight::Absolute, Weight::Relative, Weight::Pinned];
        for degree in (3..=15).step_by(2) {
            for weight in weights {
                // One coefficient is left over after pinning from degree 5 on.
                if degree > 3 || weight != Weight::Pinned {
                    all.push(Self::Odd { degree, weight });
                }
            }
        }
        all.extend((2..=8).map(|degree| Self::Dense { degree }));
        all.push(Self::CesiumCubic);
        for (numerator, denominator) in [(0, 1), (1, 1), (1, 2), (2, 2), (2, 3), (3, 3)] {
            all.extend(
                [Weight::Absolute, Weight::Relative].map(|weight| Self::Rational {
                    numerator,
                    denominator,
                    weight,
                }),
            );
        }
        for power in 4..=12 {
            for format in TexelFormat::ALL {
                all.extend(Filter::ALL.map(|filter| Self::Lookup {
                    texels: 1 << power,
                    format,
                    filter,
                }));
            }
        }
        all
    }

    /// The table it reads, if it reads one.
    #[must_use]
    pub fn table(self) -> Option<LookupTable> {
        match self {
            Self::Lookup {
                texels,
                format,
                filter,
            } => Some(LookupTable::arctangent(texels, format, filter)),
            _ => None,
        }
    }
}
