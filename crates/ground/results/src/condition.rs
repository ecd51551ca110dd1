// SPDX-License-Identifier: MIT OR Apache-2.0
//! Names of conditions: declared once by the study whose cases have them, read by these constants.

/// The name of a condition. Studies make theirs with [`conditions!`](crate::conditions), which lists
/// all of them as well: a name that is declared nowhere cannot be written by mistake.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ConditionKey(&'static str);

impl ConditionKey {
    /// For declarations alone: a study lists its keys by [`conditions!`](crate::conditions).
    #[must_use]
    pub const fn declare(name: &'static str) -> Self {
        Self(name)
    }

    /// The column in `cases.csv`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.0
    }
}

impl AsRef<str> for ConditionKey {
    fn as_ref(&self) -> &str {
        self.0
    }
}

impl From<ConditionKey> for String {
    fn from(key: ConditionKey) -> Self {
        key.0.to_owned()
    }
}

impl std::fmt::Display for ConditionKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)
    }
}

/// Declares the conditions of a study: a constant for each, the list `CONDITIONS` of all, and `TERMS` with what they and
/// their values mean.
///
/// - `shared`: names in [`condition`](crate::condition) that other studies have as well; `GLOSSARY.md` explains them
/// - a condition without a meaning is explained elsewhere: it is a switch, or stands in `GLOSSARY.md`
/// - one that another crate of the study declares has its name from there: `KEY = other::KEY.name(), "what it is";`
/// - last: values, and other words of its chapter
#[macro_export]
macro_rules! conditions {
    (
        shared $($shared:ident),*;
        $($key:ident = $name:expr $(, $meaning:literal)?;)*
        $($word:literal = $of_word:literal;)*
    ) => {
        pub(crate) use $crate::condition::{$($shared),*};
        $(pub(crate) const $key: $crate::ConditionKey = $crate::ConditionKey::declare($name);)*
        /// Every condition of the study's cases.
        pub(crate) const CONDITIONS: &[$crate::ConditionKey] = &[$($shared,)* $($key,)*];
        /// What conditions, their values and other words of the chapter mean.
        pub(crate) const TERMS: &[$crate::Term] = &[
            $($(($name, $meaning),)?)*
            $(($word, $of_word),)*
        ];
    };
}

/// Declares metrics by the constants with which they are written and read, and `METRICS`, all of them in this order. With
/// `pub;` before them, other crates of the study read them too.
#[macro_export]
macro_rules! metrics {
    (pub; $($metrics:tt)*) => { $crate::metrics! { @pub, $($metrics)* } };
    (@$vis:vis, $($(#[$said:meta])* $key:ident = $metric:expr;)*) => {
        $($(#[$said])* $vis const $key: &$crate::Metric = &$metric;)*
        /// Everything that is measured by these, in this order.
        $vis const METRICS: [$crate::Metric; [$(stringify!($key)),*].len()] = [$(*$key),*];
    };
    ($($metrics:tt)*) => { $crate::metrics! { @pub(crate), $($metrics)* } };
}

/// Declares an enumeration that conditions and tables name, with the name of each variant; with `all`, a list of them too.
#[macro_export]
macro_rules! named {
    ($(#[$said:meta])* all $vis:vis enum $kind:ident { $($(#[$of:meta])* $variant:ident = $name:expr,)* }) => {
        $crate::named! { $(#[$said])* $vis enum $kind { $($(#[$of])* $variant = $name,)* } }

        impl $kind {
            /// Every one, in this order.
            $vis const ALL: [Self; [$(stringify!($variant)),*].len()] = [$(Self::$variant),*];
        }
    };
    ($(#[$said:meta])* $vis:vis enum $kind:ident { $($(#[$of:meta])* $variant:ident = $name:expr,)* }) => {
        $(#[$said])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        $vis enum $kind {
            $($(#[$of])* $variant,)*
        }

        impl $kind {
            /// As rows have it.
            #[must_use]
            $vis const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

/// The scene that is drawn.
pub const SCENE: ConditionKey = ConditionKey::declare("scene");
/// The camera, by its name.
pub const VIEW: ConditionKey = ConditionKey::declare("view");
/// How regions are filled.
pub const TECHNIQUE: ConditionKey = ConditionKey::declare("technique");
/// The technique's switches, as one text.
pub const VARIANT: ConditionKey = ConditionKey::declare("variant");
/// Graphics interface.
pub const API: ConditionKey = ConditionKey::declare("api");
/// Part of the study: its cases have conditions of their own.
pub const PART: ConditionKey = ConditionKey::declare("part");
/// Pixels a side.
pub const SIZE_PX: ConditionKey = ConditionKey::declare("size_px");
/// The case whose work this one repeats: measured again to see by how much identical work
/// differs.
pub const REPEATS: ConditionKey = ConditionKey::declare("repeats");
