// SPDX-License-Identifier: MIT OR Apache-2.0
//! A switch, said once: its key, its values, its default and what it does. Parsing, lists, columns of tables and names
//! of variants are made from that.

use crate::RouteChoice;
use terrafill_scene::choices;

/// Values that a switch or a parameter may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Values {
    /// One of these.
    OneOf(&'static [&'static str]),
    /// A whole number of percent from 1 to 100.
    Percent,
    /// A number of pixels above 0, or `off`.
    Pixels,
    /// A way from a position to a texel, or one of these.
    RouteOr(&'static [&'static str]),
}

impl Values {
    /// Each with its placeholder or as it is.
    #[must_use]
    pub fn list(self) -> Vec<&'static str> {
        match self {
            Self::OneOf(values) => values.to_vec(),
            Self::Percent => vec!["1…100"],
            Self::Pixels => vec!["PIXELS", "off"],
            Self::RouteOr(values) => [values, &["a route such as gnomonic-3"]].concat(),
        }
    }

    /// Whether it is one of these.
    #[must_use]
    pub fn allows(self, value: &str) -> bool {
        match self {
            Self::OneOf(values) => values.contains(&value),
            Self::Percent => value
                .parse()
                .is_ok_and(|percent| (1..=100).contains(&percent)),
            Self::Pixels => pixels(value).is_some(),
            Self::RouteOr(values) => values.contains(&value) || RouteChoice::parse(value).is_some(),
        }
    }

    /// As an error says what is allowed in place of `found`.
    #[must_use]
    pub fn allowed(self, found: &str) -> String {
        match self {
            Self::OneOf(values) => choices(found, values.iter().copied()),
            Self::Percent => "whole percent, 1 to 100".to_owned(),
            Self::Pixels => "PIXELS, a number above 0, or off".to_owned(),
            Self::RouteOr(values) => {
                let values = values.join(", ");
                format!("{values}, or a route such as recentred-odd-7, gnomonic-3")
            }
        }
    }
}

/// Switches that do not go together, or not with the scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{switch}: found {found}, allowed: {allowed}")]
pub struct SwitchError {
    /// Which switch.
    pub switch: &'static str,
    /// Its value, and what it does not go with.
    pub found: String,
    /// What does.
    pub allowed: String,
}

/// A switch of `T`.
#[derive(Debug, Clone, Copy)]
pub struct Switch<T: 'static> {
    /// Its name, as it is set and as its column is called.
    pub key: &'static str,
    /// What it may be.
    pub values: Values,
    /// What it decides, in a line.
    pub meaning: &'static str,
    /// Its value.
    pub(crate) get: fn(&T) -> String,
    /// Sets it; `None` where the value is none of its own.
    pub(crate) set: fn(&mut T, &str) -> Option<()>,
}

/// A switch between values of a field, or, with `PIXELS`, of a number of pixels or none.
macro_rules! one_of {
    ($key:literal, $field:ident: PIXELS, $meaning:literal) => {
        $crate::switch::Switch {
            key: $key,
            values: $crate::switch::Values::Pixels,
            meaning: $meaning,
            get: |of| of.$field.map_or_else(|| "off".to_owned(), |px: f64| px.to_string()),
            set: |of, value| {
                of.$field = $crate::switch::pixels(value)?;
                Some(())
            },
        }
    };
    ($key:literal, $($field:ident).+: [$($value:literal => $choice:expr),+ $(,)?], $meaning:literal) => {
        $crate::switch::Switch {
            key: $key,
            values: $crate::switch::Values::OneOf(&[$($value),+]),
            meaning: $meaning,
            get: |of| {
                let all = [$(($value, $choice)),+];
                let own = all.into_iter().find(|(_, choice)| *choice == of.$($field).+);
                own.map(|(value, _)| value.to_owned()).unwrap_or_default()
            },
            set: |of, value| {
                let mut all = [$(($value, $choice)),+].into_iter();
                of.$($field).+ = all.find(|(own, _)| *own == value)?.1;
                Some(())
            },
        }
    };
}
pub(crate) use one_of;

/// A number of pixels above 0, or `off`.
pub(crate) fn pixels(value: &str) -> Option<Option<f64>> {
    if value == "off" {
        return Some(None);
    }
    let px: f64 = value.parse().ok()?;
    (px > 0.0 && px.is_finite()).then_some(Some(px))
}

impl<T: Default> Switch<T> {
    /// Its value unless it is set.
    #[must_use]
    pub fn default(&self) -> String {
        (self.get)(&T::default())
    }
}

/// Every switch with its value, in the order of the table.
pub(crate) fn settings<T>(table: &[Switch<T>], of: &T) -> Vec<(&'static str, String)> {
    let all = table.iter();
    all.map(|switch| (switch.key, (switch.get)(of))).collect()
}

/// `key=value` of every switch that differs from the default.
pub(crate) fn names<T: Default>(table: &[Switch<T>], of: &T) -> Vec<String> {
    let settings = settings(table, of).into_iter().zip(table);
    settings
        .filter(|((_, value), switch)| *value != switch.default())
        .map(|((key, value), _)| format!("{key}={value}"))
        .collect()
}

/// Sets the switch `key`; `Ok(false)` where there is none.
///
/// # Errors
/// [`SwitchError`] where the value is none of the switch's.
pub(crate) fn set<T>(
    table: &[Switch<T>],
    of: &mut T,
    key: &str,
    value: &str,
) -> Result<bool, SwitchError> {
    let Some(switch) = table.iter().find(|switch| switch.key == key) else {
        return Ok(false);
    };
    (switch.set)(of, value).ok_or_else(|| SwitchError {
        switch: switch.key,
        found: value.to_owned(),
        allowed: switch.values.allowed(value),
    })?;
    Ok(true)
}

/// The choice that `value` names.
///
/// # Errors
/// [`SwitchError`] with all names when it is none of them.
pub fn pick<T: Copy>(
    switch: &'static str,
    value: &str,
    known: &[(&'static str, T)],
) -> Result<T, SwitchError> {
    let found = known.iter().find(|(name, _)| *name == value);
    found.map(|&(_, choice)| choice).ok_or_else(|| SwitchError {
        switch,
        found: value.to_owned(),
        allowed: choices(value, known.iter().map(|(name, _)| *name)),
    })
}
