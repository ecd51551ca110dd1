// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fields over one another, over a relief or over the bare ellipsoid.

use crate::{HeightField, Heights, Relief};
use terrafill_core::Extent;

/// What lies under all fields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Base {
    /// The bare ellipsoid.
    Flat,
    /// A planet grown from a seed.
    Relief {
        /// Its shape.
        relief: Relief,
        /// Highest or deepest that it may be, metres.
        amplitude_m: f64,
    },
}

/// Spacing at which a relief shows all that it has, degrees: its finest ridges are some 0.36° wide on
/// the Earth.
const RELIEF_SPACING_DEG: f64 = 0.36;

/// Heights of a whole planet.
///
/// The first field that covers a place gives its height there. Towards its edge, over a share of its
/// shorter side, it goes over smoothly into what lies below it, so that no field ends in a cliff.
#[derive(Debug, Clone)]
pub struct Elevation {
    fields: Vec<HeightField>,
    base: Base,
    feather: f64,
    exaggeration: f64,
    warnings: Vec<String>,
}

impl Elevation {
    /// - `fields`: the first one lies on top
    /// - `feather`: share of a field's shorter side over which it goes over into what lies below, 0 … 0.5
    /// - `exaggeration`: every height is multiplied by this
    #[must_use]
    pub fn new(fields: Vec<HeightField>, base: Base, feather: f64, exaggeration: f64) -> Self {
        let warnings = fields.iter().flat_map(HeightField::warnings);
        Self {
            warnings: warnings.cloned().collect(),
            fields: join_neighbours(fields),
            base,
            feather,
            exaggeration,
        }
    }

    /// Fields that were laid over one another, the first on top; those that adjoin are one.
    #[must_use]
    pub fn fields(&self) -> &[HeightField] {
        &self.fields
    }

    /// What has to be said of the files, see [`HeightField::warnings`].
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Height, metres above the ellipsoid.
    #[must_use]
    pub fn height_m(&self, longitude_deg: f64, latitude_deg: f64) -> f64 {
        self.height_at_half_turns(
            (longitude_deg + 180.0) / 180.0,
            (latitude_deg + 90.0) / 180.0,
        )
    }

    /// The same by half turns east of 180° west and half turns north of the south pole: a relief's own
    /// numbers, of which no bit is lost.
    #[must_use]
    pub fn height_at_half_turns(&self, east: f64, north: f64) -> f64 {
        let (longitude_deg, latitude_deg) = (east * 180.0 - 180.0, north * 180.0 - 90.0);
        // What is seen of the layers below those that were looked at.
        let (mut sum, mut seen) = (0.0, 1.0);
        for field in &self.fields {
            let Some(height_m) = field.height_m(longitude_deg, latitude_deg) else {
                continue;
            };
            let cover = self.cover(field, longitude_deg, latitude_deg);
            sum += seen * cover * height_m;
            seen *= 1.0 - cover;
            if seen <= 0.0 {
                break;
            }
        }
        let below = match self.base {
            Base::Relief {
                relief,
                amplitude_m,
            } if seen > 0.0 => amplitude_m * relief.share(east, north),
            _ => 0.0,
        };
        (sum + seen * below) * self.exaggeration
    }

    /// How much of the layers below a field hides, 0 … 1.
    fn cover(&self, field: &HeightField, longitude_deg: f64, latitude_deg: f64) -> f64 {
        if self.feather <= 0.0 {
            return 1.0;
        }
        let share = field
            .share_from_edge(longitude_deg, latitude_deg)
            .unwrap_or(0.0);
        let t = (share / self.feather).min(1.0);
        t * t * (3.0 - 2.0 * t)
    }

    /// Bounds of every height over `extent`, layers below others included.
    #[must_use]
    pub fn range(&self, extent: &Extent) -> Heights {
        let base = match self.base {
            Base::Flat => Heights::of(0.0),
            Base::Relief { amplitude_m, .. } => Heights {
                lowest_m: -amplitude_m,
                highest_m: amplitude_m,
            },
        };
        let is_hidden = self.fields.iter().any(|field| self.hides(field, extent));
        let fields = self.fields.iter().filter_map(|field| field.range(extent));
        let found = if is_hidden {
            fields.reduce(Heights::union)
        } else {
            Some(fields.fold(base, Heights::union))
        };
        let range = found.unwrap_or(base);
        Heights {
            lowest_m: range.lowest_m * self.exaggeration,
            highest_m: range.highest_m * self.exaggeration,
        }
    }

    /// Whether `field` hides all below it over `extent`: bilinear values have no gaps, so that corners
    /// speak for a rectangle.
    fn hides(&self, field: &HeightField, extent: &Extent) -> bool {
        let is_hidden = |longitude: f64, latitude: f64| {
            let share = field.share_from_edge(longitude, latitude);
            share.is_some_and(|share| share >= self.feather)
        };
        let mut longitudes = [extent.west_deg, extent.east_deg].into_iter();
        let own = field.extent();
        extent.west_deg <= extent.east_deg
            && longitudes.all(|x| is_hidden(x, extent.south_deg) && is_hidden(x, extent.north_deg))
            && own.west_deg <= own.east_deg
            && own.west_deg <= extent.west_deg
            && own.east_deg >= extent.east_deg
    }

    /// Spacing at which `extent` shows all that there is, degrees: that of the finest field there, or of the
    /// relief; `None` where there is only the bare ellipsoid.
    #[must_use]
    pub fn spacing_deg(&self, extent: &Extent) -> Option<f64> {
        let here = self
            .fields
            .iter()
            .filter(|field| field.range(extent).is_some());
        let base = match self.base {
            Base::Flat => None,
            Base::Relief { .. } => Some(RELIEF_SPACING_DEG),
        };
        here.map(HeightField::spacing_deg)
            .chain(base)
            .reduce(f64::min)
    }

    /// Bytes in memory.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.fields.iter().map(HeightField::bytes).sum()
    }
}

/// Runs of fields of one grid that fill a rectangle become one, so that no feather parts them.
fn join_neighbours(fields: Vec<HeightField>) -> Vec<HeightField> {
    let mut joined: Vec<HeightField> = Vec::new();
    let mut rest = fields.as_slice();
    while !rest.is_empty() {
        let longest = (2..=rest.len()).rev().find_map(|count| {
            let field = HeightField::joined(&rest[..count])?;
            Some((field, count))
        });
        let (field, count) = longest.unwrap_or_else(|| (rest[0].clone(), 1));
        joined.push(field);
        rest = &rest[count..];
    }
    joined
}
