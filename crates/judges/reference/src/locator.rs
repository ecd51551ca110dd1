// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which regions hold a point, by two independent tests per ring.
//!
//! Longitude and latitude in degrees, geodetic. A region holds a point that an odd number of its
//! rings hold, so holes, islands in holes, and parts cut at the antimeridian need no order. The
//! first test decides; the second one only says where the first is not to be trusted blindly.

use crate::great_ellipse::GreatEllipseRing;
use crate::planar::PlanarRing;
use crate::point::{Bounds, LocatorError, Point, RingSource, Verdicts};
use crate::sides::poles_held;
use terrafill_core::{EdgeRule, Ellipsoid, Region};

#[derive(Debug, Clone)]
enum RingTests {
    Planar(PlanarRing),
    GreatEllipse(GreatEllipseRing),
}

impl RingTests {
    fn new(source: &RingSource<'_>, rule: EdgeRule) -> Result<Self, LocatorError> {
        Ok(match rule {
            EdgeRule::Planar => Self::Planar(PlanarRing::new(source)?),
            EdgeRule::GreatEllipse => Self::GreatEllipse(GreatEllipseRing::new(source)?),
        })
    }

    fn bounds(&self) -> Bounds {
        match self {
            Self::Planar(ring) => ring.bounds(),
            Self::GreatEllipse(ring) => ring.bounds(),
        }
    }

    fn holds(&self, point: &Point) -> Verdicts {
        match self {
            Self::Planar(ring) => ring.holds(point),
            Self::GreatEllipse(ring) => ring.holds(point),
        }
    }

    #[cfg(test)]
    fn holds_brute(&self, point: &Point) -> Verdicts {
        match self {
            Self::Planar(ring) => ring.holds_brute(point),
            Self::GreatEllipse(ring) => ring.holds_brute(point),
        }
    }
}

/// Where a point is.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Location {
    /// Positions, in the slice given to [`Locator::new`], of the regions that hold the point by
    /// the first test, ascending.
    pub regions: Vec<usize>,
    /// Positions of the regions about which the two tests differ, ascending: the point is within
    /// rounding of their boundary.
    pub disagree: Vec<usize>,
}

/// Regions made ready to be asked which of them hold a point.
#[derive(Debug, Clone)]
pub struct Locator {
    rings: Vec<(usize, RingTests)>,
    cells: Cells,
}

impl Locator {
    /// Builds the tests of every ring of `regions` on `body`, whose areas decide which side of a ring
    /// round a pole is inside ([`Region::inside`]).
    ///
    /// - cost: O(vertices · log vertices)
    ///
    /// # Errors
    /// [`LocatorError`] when a ring leaves open what is inside it.
    pub fn new(regions: &[Region], rule: EdgeRule, body: &Ellipsoid) -> Result<Self, LocatorError> {
        let sources = regions.iter().enumerate().flat_map(|(position, region)| {
            let polygons = region.polygons.iter().enumerate();
            polygons.flat_map(move |(part, polygon)| {
                let held = poles_held(polygon, rule, body, region.inside);
                let rings = polygon.rings().zip(held).enumerate();
                rings.map(move |(index, (ring, holds_poles))| {
                    let source = RingSource {
                        place: format!(
                            "feature {} ({}), polygon {part}, ring {}",
                            region.index,
                            region.name,
                            ring.file_ring(index)
                        ),
                        vertices_deg: ring.vertices_deg(),
                        winding_deg: ring.winding_deg(),
                        holds_poles,
                    };
                    (position, source)
                })
            })
        });
        Self::from_rings(sources, rule)
    }

    /// From rings, each with the position of its region, ascending.
    pub(crate) fn from_rings<'a>(
        sources: impl Iterator<Item = (usize, RingSource<'a>)>,
        rule: EdgeRule,
    ) -> Result<Self, LocatorError> {
        let mut rings = Vec::new();
        let mut cells = Cells::new();
        for (position, source) in sources {
            let ring = RingTests::new(&source, rule)?;
            cells.insert(rings.len(), ring.bounds());
            rings.push((position, ring));
        }
        Ok(Self { rings, cells })
    }

    /// The regions that hold a point.
    ///
    /// Longitude may be any number of turns out. A position that is not finite or lies beyond a
    /// pole is in no region: whoever reads positions from a file refuses those first.
    ///
    /// Longitudes of the point and of the regions are rounded to multiples of 2⁻⁴³ degrees (13 nm at
    /// the equator), so that turns can be added without an error. For great-ellipse edges places are
    /// rounded to unit normals in `f64` as well (1 nm). On which side of an edge the rounded place lies
    /// is decided exactly.
    #[must_use]
    pub fn locate(&self, longitude_deg: f64, latitude_deg: f64) -> Location {
        let mut location = Location::default();
        if let Some(point) = Point::new(longitude_deg, latitude_deg) {
            self.for_each_region(&point, |region, verdicts| {
                if verdicts.first {
                    location.regions.push(region);
                }
                if verdicts.first != verdicts.second {
                    location.disagree.push(region);
                }
            });
        }
        location
    }

    /// Calls `visit` for each region that may hold `point`, ascending; all that do are among them.
    pub(crate) fn for_each_region(&self, point: &Point, mut visit: impl FnMut(usize, Verdicts)) {
        let near = self
            .cells
            .at(point)
            .iter()
            .map(|&ring| &self.rings[ring as usize]);
        let mut sum: Option<(usize, Verdicts)> = None;
        for (region, ring) in near {
            let verdicts = ring.holds(point);
            sum = match sum {
                Some((same, so_far)) if same == *region => Some((same, odd(so_far, verdicts))),
                other => {
                    if let Some((done, verdicts)) = other {
                        visit(done, verdicts);
                    }
                    Some((*region, verdicts))
                }
            };
        }
        if let Some((done, verdicts)) = sum {
            visit(done, verdicts);
        }
    }

    /// [`Locator::locate`] without any index.
    #[cfg(test)]
    pub(crate) fn locate_brute(&self, longitude_deg: f64, latitude_deg: f64) -> Location {
        let mut location = Location::default();
        let Some(point) = Point::new(longitude_deg, latitude_deg) else {
            return location;
        };
        let last = self.rings.last().map_or(0, |(region, _)| region + 1);
        let mut verdicts = vec![Verdicts::default(); last];
        for (region, ring) in &self.rings {
            verdicts[*region] = odd(verdicts[*region], ring.holds_brute(&point));
        }
        for (region, verdicts) in verdicts.iter().enumerate() {
            if verdicts.first {
                location.regions.push(region);
            }
            if verdicts.first != verdicts.second {
                location.disagree.push(region);
            }
        }
        location
    }
}

/// Even-odd rule over rings.
fn odd(a: Verdicts, b: Verdicts) -> Verdicts {
    Verdicts {
        first: a.first != b.first,
        second: a.second != b.second,
    }
}

/// Rings by cell of one degree.
#[derive(Debug, Clone)]
struct Cells {
    rings: Vec<Vec<u32>>,
}

impl Cells {
    const COLUMNS: usize = 360;
    const ROWS: usize = 180;

    fn new() -> Self {
        Self {
            rings: vec![Vec::new(); Self::COLUMNS * Self::ROWS],
        }
    }

    /// Enters a ring in every cell that `bounds`, taken modulo turns, touches.
    fn insert(&mut self, ring: usize, bounds: Bounds) {
        let ring = u32::try_from(ring).expect("fewer rings than bytes of memory");
        // Clipping to one turn from the western edge on, a cell wider, covers every column once.
        let first = bounds.west.floor();
        let columns = (bounds.east.floor() - first + 1.0).clamp(0.0, Self::COLUMNS as f64);
        for row in Self::row(bounds.south)..=Self::row(bounds.north) {
            let mut longitude = first;
            while longitude < first + columns {
                let list = &mut self.rings[row * Self::COLUMNS + Self::column(longitude)];
                list.push(ring);
                longitude += 1.0;
            }
        }
    }

    fn at(&self, point: &Point) -> &[u32] {
        let row = Self::row(point.latitude_deg);
        &self.rings[row * Self::COLUMNS + Self::column(point.longitude_deg)]
    }

    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast saturates, and the number of rows and columns bounds it from above"
    )]
    fn row(latitude_deg: f64) -> usize {
        ((latitude_deg + 90.0) as usize).min(Self::ROWS - 1)
    }

    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a remainder of 360 is neither negative nor above 360"
    )]
    fn column(longitude_deg: f64) -> usize {
        (longitude_deg.floor().rem_euclid(360.0) as usize) % Self::COLUMNS
    }
}
