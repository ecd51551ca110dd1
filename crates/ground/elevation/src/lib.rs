// SPDX-License-Identifier: MIT OR Apache-2.0
//! Elevation: heights of a planet's surface above its ellipsoid, from files or from a seed.
//!
//! [`read`] turns the bytes of a file into a [`HeightField`]: a raster of heights in degrees of
//! longitude and latitude or in Web-Mercator metres, with its voids filled, sampled bilinearly, and
//! with bounds of every part. [`Relief`] is a planet grown from a seed. [`Elevation`] lays fields
//! over one another, over a relief or over the bare ellipsoid.
//!
//! Angles are in degrees, as the files have them; heights in metres above the ellipsoid. Files count
//! from mean sea level instead; the geoid, up to 106 m, is left out on purpose.

mod elevation;
mod error;
mod field;
mod pyramid;
mod readers;
mod relief;
mod voids;

pub use elevation::{Base, Elevation};
pub use error::ElevationError;
pub use field::{Bounds, Grid, HeightField, MAX_HEIGHT_M, MAX_SAMPLES, Projection, Registration};
pub use pyramid::Heights;
pub use readers::read;
pub use relief::Relief;
