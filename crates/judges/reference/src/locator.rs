// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which regions hold a point, by two independent tests per ring.
//!
//! Longitude and latitude in degrees, geodetic. A region holds a point that an odd number of its
//! rings hold, unless its repair joins parts, so holes, islands in holes, and parts cut at the antimeridian need no order. The
//! first test decides; the second one only says where the first is not to be trusted blindly.

use crate::great_ellipse::GreatEllipseRing;
use crate::planar::PlanarRing;
use crate::point::{Bounds, LocatorError, Point, RingSource, Verdicts};
use crate::sides::poles_held;
use crate::validity::check_rings;
use terrafill_core::{EdgeRule, Ellipsoid, Polygon, Region, Repair};

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

/// A ring, and what it is to its region.
#[derive(Debug, Clone)]
struct LocatedRing {
    /// Position of its region.
    region: usize,
    tests: RingTests,
    role: RingRole,
}

/// What a ring changes about a place that it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RingRole {
    /// Whether it is inside of the region: the even-odd rule.
    Toggles,
    /// Parts are joined: it is inside of this part.
    Shell {
        /// Among the region's parts.
        part: usize,
    },
    /// Parts are joined: it is outside of this part.
    Hole {
        /// Among the region's parts.
        part: usize,
    },
    /// Parts are joined, and this one goes round the axis: it changes sides.
    Round {
        /// Among the region's parts.
        part: usize,
    },
}

impl RingRole {
    fn of(region: &Region, part: usize, index: usize) -> Self {
        let is_round = |polygon: &Polygon| polygon.rings().any(|ring| ring.winding_deg() != 0.0);
        match region.repaired {
            None | Some(Repair::EvenOdd) => Self::Toggles,
            Some(_) if is_round(&region.polygons[part]) => Self::Round { part },
            Some(_) if index == 0 => Self::Shell { part },
            Some(_) => Self::Hole { part },
        }
    }
}

/// What the rings of one region so far say of a point.
#[derive(Default)]
struct RegionVerdicts {
    region: usize,
    /// Of parts that are done, or of all rings by parity.
    sum: Verdicts,
    part: usize,
    /// Of the part at hand.
    of_part: Verdicts,
}

impl RegionVerdicts {
    fn of(region: usize) -> Self {
        Self {
            region,
            ..Self::default()
        }
    }

    fn add(&mut self, role: RingRole, verdicts: Verdicts) {
        let both = |change: fn(bool, bool) -> bool, of: Verdicts| Verdicts {
            first: change(of.first, verdicts.first),
            second: change(of.second, verdicts.second),
        };
        match role {
            RingRole::Toggles => self.sum = odd(self.sum, verdicts),
            RingRole::Shell { part } | RingRole::Hole { part } | RingRole::Round { part } => {
                if part != self.part {
                    self.sum = self.total();
                    self.of_part = Verdicts::default();
                    self.part = part;
                }
                self.of_part = match role {
                    RingRole::Hole { .. } => both(|inside, held| inside && !held, self.of_part),
                    _ => odd(self.of_part, verdicts),
                };
            }
        }
    }

    fn total(&self) -> Verdicts {
        Verdicts {
            first: self.sum.first || self.of_part.first,
            second: self.sum.second || self.of_part.second,
        }
    }
}

/// Regions made ready to be asked which of them hold a point.
#[derive(Debug, Clone)]
pub struct Locator {
    rings: Vec<LocatedRing>,
    cells: Cells,
}

impl Locator {
    /// Builds the tests of every ring of `regions` on `body`, whose areas decide which side of a ring
    /// round a pole is inside ([`Region::inside`]).
    ///
    /// - cost: O(vertices · log vertices)
    ///
    /// # Errors
    /// [`LocatorError`] when a ring leaves open what is inside it, or two rings of a region that is not
    /// repaired say two things of one place.
    pub fn new(regions: &[Region], rule: EdgeRule, body: &Ellipsoid) -> Result<Self, LocatorError> {
        for region in regions {
            check_rings(region, rule, body)?;
        }
        let sources = regions.iter().enumerate().flat_map(|(position, region)| {
            let polygons = region.polygons.iter().enumerate();
            polygons.flat_map(move |(part, polygon)| {
                let held = poles_held(polygon, rule, body, region.inside);
                let rings = polygon.rings().zip(held).enumerate();
                rings.map(move |(index, (ring, holds_poles))| {
                    let source = RingSource {
                        place: format!(
                            "feature {} ({}), polygon {}, ring {}",
                            region.index,
                            region.name,
                            ring.file_polygon(part),
                            ring.file_ring(index)
                        ),
                        vertices_deg: ring.vertices_deg(),
                        winding_deg: ring.winding_deg(),
                        holds_poles,
                    };
                    (position, source, RingRole::of(region, part, index))
                })
            })
        });
        Self::from_rings(sources, rule)
    }

    /// From rings, each with the position of its region, ascending, and its role there.
    pub(crate) fn from_rings<'a>(
        sources: impl Iterator<Item = (usize, RingSource<'a>, RingRole)>,
        rule: EdgeRule,
    ) -> Result<Self, LocatorError> {
        let mut rings = Vec::new();
        let mut cells = Cells::new();
        for (region, source, role) in sources {
            let tests = RingTests::new(&source, rule)?;
            cells.insert(rings.len(), tests.bounds());
            rings.push(LocatedRing {
                region,
                tests,
                role,
            });
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
        let mut so_far: Option<RegionVerdicts> = None;
        for ring in near {
            if let Some(done) = so_far.take_if(|so_far| so_far.region != ring.region) {
                visit(done.region, done.total());
            }
            let of_region = so_far.get_or_insert_with(|| RegionVerdicts::of(ring.region));
            of_region.add(ring.role, ring.tests.holds(point));
        }
        if let Some(done) = so_far {
            visit(done.region, done.total());
        }
    }

    /// [`Locator::locate`] without any index.
    #[cfg(test)]
    pub(crate) fn locate_brute(&self, longitude_deg: f64, latitude_deg: f64) -> Location {
        let mut location = Location::default();
        let Some(point) = Point::new(longitude_deg, latitude_deg) else {
            return location;
        };
        let last = self.rings.last().map_or(0, |ring| ring.region + 1);
        let mut verdicts: Vec<RegionVerdicts> = (0..last).map(RegionVerdicts::of).collect();
        for ring in &self.rings {
            verdicts[ring.region].add(ring.role, ring.tests.holds_brute(&point));
        }
        for (region, verdicts) in verdicts.iter().map(RegionVerdicts::total).enumerate() {
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
        reason = "the cast saturates, and the number of rows and columns bounds it from above"
    )]
    fn row(latitude_deg: f64) -> usize {
        ((latitude_deg + 90.0) as usize).min(Self::ROWS - 1)
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "a remainder of 360 is neither negative nor above 360"
    )]
    fn column(longitude_deg: f64) -> usize {
        (longitude_deg.floor().rem_euclid(360.0) as usize) % Self::COLUMNS
    }
}
