// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ways that conditions and tables name.

/// Declares an enumeration with the name of each variant; with `all`, a list of them too.
macro_rules! named {
    ($(#[$meta:meta])* all $kind:ident { $($(#[$of:meta])* $variant:ident = $name:expr,)* }) => {
        $crate::named::named! { $(#[$meta])* $kind { $($(#[$of])* $variant = $name,)* } }

        impl $kind {
            pub(crate) const ALL: [Self; [$(stringify!($variant)),*].len()] = [$(Self::$variant),*];
        }
    };
    ($(#[$meta:meta])* $kind:ident { $($(#[$of:meta])* $variant:ident = $name:expr,)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum $kind {
            $($(#[$of])* $variant,)*
        }

        impl $kind {
            /// As rows have it.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

pub(crate) use named;
