// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which regions hold a point, by two independent tests per ring.
//!
//! Longitude and latitude in degrees, geodetic. A region holds a point that an odd number of its
//! rings hold, so holes, islands in holes, and parts cut at the antimeridian need no order. The
//! first test decides; the second one only says where the first is not to be trusted blindly.

use crate::great_ellipse::{GreatEllipseRing, goes_round};
use crate::planar::{PlanarRing, on_longitude_grid};
use glam::DVec3;
use terrafill_core::{EdgeRule, Polygon, Region, Ring};

/// Why a ring cannot be judged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LocatorError {
    /// A planar ring ends neither where it started nor one turn on.
    #[error("{place} ends {found}° from its start, needs 0 or ±360")]
    Winding {
        /// Region and ring.
        place: String,
        /// Longitude of the end minus that of the start.
        found: f64,
    },
    /// A planar ring lies over itself.
    #[error("{place} is {found}° wide, allowed 360")]
    WiderThanATurn {
        /// Region and ring.
        place: String,
        /// Its width.
        found: f64,
    },
    /// Turns cannot be added exactly that far out.
    #[error("{place} reaches longitude ±{found}, allowed ±{allowed}")]
    LongitudeOutOfRange {
        /// Region and ring.
        place: String,
        /// Largest absolute longitude.
        found: f64,
        /// The limit.
        allowed: f64,
    },
    /// Every plane through the ends of a great-ellipse edge holds the centre.
    #[error(
        "{place}: the edge from vertex {vertex} joins the opposite points {start:?} and {end:?}"
    )]
    OppositeEnds {
        /// Region and ring.
        place: String,
        /// Vertex that the edge starts at.
        vertex: usize,
        /// Longitude and latitude of its start, degrees.
        start: [f64; 2],
        /// Longitude and latitude of its end, degrees.
        end: [f64; 2],
    },
}

/// A ring as the tests read it, with its place for messages.
#[derive(Debug, Clone)]
pub(crate) struct RingSource<'a> {
    pub(crate) place: String,
    pub(crate) vertices_deg: &'a [[f64; 2]],
    pub(crate) winding_deg: f64,
    /// Which pole is inside, should the ring go round the axis.
    pub(crate) holds_north: bool,
}

impl RingSource<'_> {
    pub(crate) fn winding_error(&self) -> LocatorError {
        LocatorError::Winding {
            place: self.place.clone(),
            found: self.winding_deg,
        }
    }

    pub(crate) fn width_error(&self, found: f64) -> LocatorError {
        LocatorError::WiderThanATurn {
            place: self.place.clone(),
            found,
        }
    }

    pub(crate) fn longitude_error(&self, found: f64, allowed: f64) -> LocatorError {
        LocatorError::LongitudeOutOfRange {
            place: self.place.clone(),
            found,
            allowed,
        }
    }

    pub(crate) fn opposite_error(&self, vertex: usize) -> LocatorError {
        LocatorError::OppositeEnds {
            place: self.place.clone(),
            vertex,
            start: self.vertices_deg[vertex],
            end: self.vertices_deg[(vertex + 1) % self.vertices_deg.len()],
        }
    }
}

/// A point as both kinds of ring want it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    /// −180 … 180, on the grid of [`on_longitude_grid`].
    pub(crate) longitude_deg: f64,
    /// Strictly within ±90.
    pub(crate) latitude_deg: f64,
    /// Unit geodetic normal.
    pub(crate) normal: DVec3,
}

impl Point {
    /// A pole is every longitude at once, and on the rim of whatever is straight in longitude and
    /// latitude; so it is read as the nearest latitude to it that a double can hold, 10⁻⁹ m away.
    pub(crate) fn new(longitude_deg: f64, latitude_deg: f64) -> Option<Self> {
        if !longitude_deg.is_finite() || latitude_deg.is_nan() || latitude_deg.abs() > 90.0 {
            return None;
        }
        let turns = (longitude_deg / 360.0).round();
        Some(Self {
            longitude_deg: on_longitude_grid(longitude_deg - 360.0 * turns),
            latitude_deg: latitude_deg.clamp((-90.0_f64).next_up(), 90.0_f64.next_down()),
            normal: normal(longitude_deg, latitude_deg),
        })
    }
}

/// Unit geodetic normal.
///
/// One place has one vector to the bit, under whichever longitude it is written, and the
/// antimeridian lies in one plane to the bit: parts cut there or run to a pole meet without a gap.
pub(crate) fn normal(longitude_deg: f64, latitude_deg: f64) -> DVec3 {
    if latitude_deg.abs() >= 90.0 {
        return DVec3::new(0.0, 0.0, latitude_deg.signum());
    }
    let turns = ((longitude_deg + 180.0) / 360.0).floor();
    let longitude_deg = longitude_deg - 360.0 * turns;
    let (sin_lon, cos_lon) = if longitude_deg == -180.0 {
        (0.0, -1.0)
    } else {
        longitude_deg.to_radians().sin_cos()
    };
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// What the two tests say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Verdicts {
    pub(crate) first: bool,
    pub(crate) second: bool,
}

/// A rectangle in longitude and latitude, degrees; `west..east` may lie beyond ±180.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) west: f64,
    pub(crate) south: f64,
    pub(crate) east: f64,
    pub(crate) north: f64,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self {
        west: f64::INFINITY,
        south: f64::INFINITY,
        east: f64::NEG_INFINITY,
        north: f64::NEG_INFINITY,
    };

    pub(crate) fn include(&mut self, vertex: [f64; 2]) {
        self.west = self.west.min(vertex[0]);
        self.east = self.east.max(vertex[0]);
        self.south = self.south.min(vertex[1]);
        self.north = self.north.max(vertex[1]);
    }
}

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
    /// Builds the tests of every ring of `regions`.
    ///
    /// - cost: O(vertices · log vertices)
    ///
    /// # Errors
    /// [`LocatorError`] when a ring leaves open what is inside it.
    pub fn new(regions: &[Region], rule: EdgeRule) -> Result<Self, LocatorError> {
        let sources = regions.iter().enumerate().flat_map(|(position, region)| {
            let polygons = region.polygons.iter().enumerate();
            polygons.flat_map(move |(part, polygon)| {
                rings_of(polygon, rule).into_iter().enumerate().map(
                    move |(index, (ring, north))| {
                        let source = RingSource {
                            place: format!(
                                "feature {} ({}), polygon {part}, ring {index}",
                                region.index, region.name
                            ),
                            vertices_deg: ring.vertices_deg(),
                            winding_deg: ring.winding_deg(),
                            holds_north: north,
                        };
                        (position, source)
                    },
                )
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

/// Shell and holes, each with whether it holds the north pole, should it go round the axis.
///
/// A ring that does holds the pole of the hemisphere in which its vertices lie on average, north
/// if undecided. The holes of a shell that goes round are closed over the shell's pole.
fn rings_of(polygon: &Polygon, rule: EdgeRule) -> Vec<(&Ring, bool)> {
    let holds_north = |ring: &Ring| holds_north(ring.vertices_deg());
    let shell = &polygon.shell;
    let mut rings = vec![(shell, holds_north(shell))];
    let shell_goes_round = match rule {
        EdgeRule::Planar => shell.winding_deg() != 0.0,
        EdgeRule::GreatEllipse => !polygon.holes.is_empty() && goes_round(shell.vertices_deg()),
    };
    for hole in &polygon.holes {
        let decides = if shell_goes_round { shell } else { hole };
        rings.push((hole, holds_north(decides)));
    }
    rings
}

/// Whether vertices lie north of the equator on average.
pub(crate) fn holds_north(vertices_deg: &[[f64; 2]]) -> bool {
    vertices_deg.iter().map(|vertex| vertex[1]).sum::<f64>() >= 0.0
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
