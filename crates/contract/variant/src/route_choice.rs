// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a textured fill's coordinate routes are picked.

use std::hash::{Hash, Hasher};
use terrafill_texture::CoordinateRoute;

/// Name of a textured fill without a route.
const FLOOR: &str = "floor";

/// How a textured fill's coordinate routes are picked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RouteChoice {
    /// Per region, the cheapest whose computed residual the picture and the screen do not show.
    Chosen,
    /// This one for all regions, whatever its residual.
    Route(CoordinateRoute),
    /// None: what any textured fill must pay, whose fragments read their depth and sample a picture
    /// once. It draws colours that stand nowhere in particular, and is there to be measured.
    Floor,
}

impl Hash for RouteChoice {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name().hash(state);
    }
}

impl RouteChoice {
    /// Name in variants.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Chosen => "chosen".to_owned(),
            Self::Route(route) => route.name(),
            Self::Floor => FLOOR.to_owned(),
        }
    }

    /// The choice called `name`.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        if name == "chosen" {
            return Some(Self::Chosen);
        }
        if name == FLOOR {
            return Some(Self::Floor);
        }
        CoordinateRoute::parse(name).map(Self::Route)
    }
}
