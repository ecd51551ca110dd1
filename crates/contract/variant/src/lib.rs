// SPDX-License-Identifier: MIT OR Apache-2.0
//! Everything that can be chosen of a technique, as keys and values: its own parameters, the switches of fills by
//! volumes, and the options of the frame plan.
//!
//! The table of switches stands here and not with the code that obeys it, since whoever measures names a [`Variant`]
//! without drawing one.

mod route_choice;
mod switch;
mod switches;
mod variant;

pub use route_choice::RouteChoice;
pub use switch::{Switch, SwitchError, Values, pick};
pub use switches::*;
pub use variant::{Parameter, Variant, is_gone};
