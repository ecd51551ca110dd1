// SPDX-License-Identifier: MIT OR Apache-2.0
//! Curves on the surface → rings of planar edges that stay within a tolerance of them.
//!
//! Degrees, deviations as straight-line metres. An edge is compared with its curve both ways: the
//! curve's points with the edge as it runs in longitude and latitude, and the other way round. It
//! is halved in the curve's parameter until both are near enough. Every distance measured is one
//! to a point that was actually found, hence never too small.

use crate::edge::{Degrees, surface_point};
use crate::{EdgeRule, Ellipsoid, Inside, Polygon, Ring};
use glam::DVec3;
use std::f64::consts::TAU;

/// Samples of an edge; the ends are not measured.
const SAMPLES: u32 = 6;
/// What a deviation can rise to between samples, for each metre found at one: a parabola's peak is
/// missed by 3 %, that of a cubic with its node in the middle by 4 %.
const BETWEEN_SAMPLES: f64 = 17.0 / 16.0;
/// Rounding of positions in degrees and of the curves, as a share of the equatorial radius.
const ROUNDING: f64 = 4e-14;
/// Closer to a pole than this, degrees, longitudes are noise; less than [`ROUNDING`].
const POLE_SNAP_DEG: f64 = 1e-12;
/// An edge may be this many times shorter in parameter than the piece that it was cut from: a
/// double has no more digits.
const MAX_HALVINGS: u32 = 50;
/// Steps towards the nearest point; each squares the error.
const MAX_STEPS: u32 = 4;
/// Tolerances coarser than this share of the narrowest width would let opposite sides cross.
const COARSEST_SHARE: f64 = 0.05;

/// Pieces of a whole turn that are measured at least.
const PIECES_PER_TURN: f64 = 16.0;

/// How many pieces an arc of this many radians starts with.
pub(super) fn pieces_of_turn(angle_rad: f64) -> u32 {
    (1..)
        .find(|pieces| angle_rad * PIECES_PER_TURN <= TAU * f64::from(*pieces) + 1e-9)
        .unwrap_or(1)
        .max(4)
}

/// A curve over the parameters 0 … 1; longitude within ±180.
pub(super) type Curve<'a> = Box<dyn Fn(f64) -> Degrees + 'a>;

/// Curves that run side by side and are cut at the same parameters, so that they cannot cross
/// where they are close.
pub(super) struct Band<'a> {
    pub(super) curves: Vec<Curve<'a>>,
    /// Into how many pieces at least.
    pub(super) pieces: u32,
}

/// One curve of a ring.
#[derive(Clone, Copy)]
pub(super) struct Leg {
    pub(super) band: usize,
    pub(super) curve: usize,
    pub(super) reversed: bool,
}

/// Closed curves with the interior on the left seen from outside the body.
pub(super) struct Boundary<'a> {
    pub(super) bands: Vec<Band<'a>>,
    pub(super) rings: Vec<Vec<Leg>>,
}

/// Rings of planar edges.
pub(super) struct Traced {
    pub(super) polygon: Polygon,
    /// Largest distance between an edge and its curve, metres, both ways; an upper bound.
    pub(super) deviation_m: f64,
}

impl Boundary<'_> {
    /// Area over length, metres, as a few points of each curve show it: half a rectangle's short
    /// side at least.
    pub(super) fn narrowest_m(&self, body: &Ellipsoid) -> f64 {
        let coarse: Vec<Vec<Vec<Degrees>>> = self
            .bands
            .iter()
            .map(|band| {
                let parameters: Vec<f64> = (0..=band.pieces)
                    .map(|piece| f64::from(piece) / f64::from(band.pieces))
                    .collect();
                places_of(band, &parameters)
            })
            .collect();
        let rings: Vec<Vec<DVec3>> = self
            .rings_of(&coarse)
            .iter()
            .map(|ring| ring.iter().map(|at| surface_point(body, *at)).collect())
            .collect();
        let mut doubled_area = DVec3::ZERO;
        let mut longest: f64 = 0.0;
        for ring in &rings {
            let origin = ring[0];
            for (from, to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                doubled_area += (*from - origin).cross(*to - origin);
                longest = ring
                    .iter()
                    .map(|other| from.distance(*other))
                    .fold(longest, f64::max);
            }
        }
        if longest > 0.0 {
            0.5 * doubled_area.length() / longest
        } else {
            0.0
        }
    }

    /// - `tolerance_m`: made finer where the shape is so narrow that its sides could cross
    pub(super) fn trace(&self, body: &Ellipsoid, tolerance_m: f64) -> Traced {
        let mut subdivider = Subdivider {
            body,
            tolerance_m: tolerance_m.min(COARSEST_SHARE * self.narrowest_m(body)),
            deviation_m: 0.0,
        };
        let fine: Vec<Vec<Vec<Degrees>>> = self
            .bands
            .iter()
            .map(|band| places_of(band, &subdivider.parameters(band)))
            .collect();
        let rings: Vec<SidedRing> = self
            .rings_of(&fine)
            .iter()
            .map(|places| SidedRing::new(places, body))
            .collect();
        Traced {
            polygon: polygon(rings),
            deviation_m: subdivider.deviation_m,
        }
    }

    /// - `places`: by band and curve
    fn rings_of(&self, places: &[Vec<Vec<Degrees>>]) -> Vec<Vec<Degrees>> {
        let ring = |legs: &Vec<Leg>| {
            let mut ring = Vec::new();
            for leg in legs {
                let mut places = places[leg.band][leg.curve].clone();
                if leg.reversed {
                    places.reverse();
                }
                // The next leg starts there.
                places.pop();
                ring.append(&mut places);
            }
            ring
        };
        self.rings.iter().map(ring).collect()
    }
}

/// Places of each curve at the same parameters.
fn places_of(band: &Band<'_>, parameters: &[f64]) -> Vec<Vec<Degrees>> {
    let places = |curve: &Curve<'_>| parameters.iter().map(|t| place(curve, *t)).collect();
    band.curves.iter().map(places).collect()
}

/// The curve at a parameter; what is at a pole but for rounding is there.
fn place(curve: &Curve<'_>, parameter: f64) -> Degrees {
    let [longitude, latitude] = curve(parameter);
    if 90.0 - latitude.abs() < POLE_SNAP_DEG {
        [longitude, 90.0_f64.copysign(latitude)]
    } else {
        [longitude, latitude]
    }
}

/// `to − from` by whichever way round is shorter; half a turn goes east.
fn short_step(from_deg: f64, to_deg: f64) -> f64 {
    let step = to_deg - from_deg;
    if step > 180.0 {
        step - 360.0
    } else if step <= -180.0 {
        step + 360.0
    } else {
        step
    }
}

struct Subdivider<'a> {
    body: &'a Ellipsoid,
    tolerance_m: f64,
    deviation_m: f64,
}

impl Subdivider<'_> {
    /// Where to cut the curves of a band, 0 and 1 included.
    fn parameters(&mut self, band: &Band<'_>) -> Vec<f64> {
        let mut parameters = vec![0.0];
        for piece in 0..band.pieces {
            let ends = [piece, piece + 1].map(|end| f64::from(end) / f64::from(band.pieces));
            self.split(band, ends, MAX_HALVINGS, &mut parameters);
        }
        parameters
    }

    /// Adds every cut after `from` up to `to`.
    fn split(
        &mut self,
        band: &Band<'_>,
        [from, to]: [f64; 2],
        halvings_left: u32,
        parameters: &mut Vec<f64>,
    ) {
        let mut deviation_m: f64 = 0.0;
        for curve in &band.curves {
            let limit_m = if halvings_left > 0 {
                self.tolerance_m
            } else {
                f64::INFINITY
            };
            let arc = Arc::new(self.body, curve, [from, to]);
            deviation_m = deviation_m.max(arc.deviation_m(limit_m));
            if deviation_m > limit_m {
                let middle = 0.5 * (from + to);
                self.split(band, [from, middle], halvings_left - 1, parameters);
                self.split(band, [middle, to], halvings_left - 1, parameters);
                return;
            }
        }
        self.deviation_m = self.deviation_m.max(deviation_m);
        parameters.push(to);
    }
}

/// A piece of a curve and the edge that is to stand for it.
struct Arc<'a> {
    body: &'a Ellipsoid,
    curve: &'a Curve<'a>,
    from: f64,
    to: f64,
    start_deg: Degrees,
    step_deg: Degrees,
}

impl<'a> Arc<'a> {
    fn new(body: &'a Ellipsoid, curve: &'a Curve<'a>, [from, to]: [f64; 2]) -> Self {
        let mut start = place(curve, from);
        let mut end = place(curve, to);
        // A pole has no longitude of its own: see SidedRing.
        if start[1].abs() == 90.0 {
            start[0] = end[0];
        } else if end[1].abs() == 90.0 {
            end[0] = start[0];
        }
        Self {
            body,
            curve,
            from,
            to,
            start_deg: start,
            step_deg: [short_step(start[0], end[0]), end[1] - start[1]],
        }
    }

    fn on_curve(&self, fraction: f64) -> DVec3 {
        let parameter = self.from + (self.to - self.from) * fraction;
        surface_point(self.body, place(self.curve, parameter))
    }

    fn on_edge(&self, fraction: f64) -> DVec3 {
        surface_point(
            self.body,
            [0, 1].map(|k| self.start_deg[k] + self.step_deg[k] * fraction),
        )
    }

    /// Upper bound on the distance between curve and edge; where that is above `limit_m`, anything
    /// above it.
    fn deviation_m(&self, limit_m: f64) -> f64 {
        let stated =
            |found: f64| found * BETWEEN_SAMPLES + ROUNDING * self.body.equatorial_radius_m();
        let mut found: f64 = 0.0;
        // The middle first: it nearly always decides.
        let order = [3, 1, 2, 4, 5];
        debug_assert!(order.len() + 1 == SAMPLES as usize);
        for (from_curve, sample) in order
            .map(|k| (true, k))
            .into_iter()
            .chain(order.map(|k| (false, k)))
        {
            let fraction = f64::from(sample) / f64::from(SAMPLES);
            let distance_m = if from_curve {
                nearest(self.on_curve(fraction), fraction, found, |f| {
                    self.on_edge(f)
                })
            } else {
                nearest(self.on_edge(fraction), fraction, found, |f| {
                    self.on_curve(f)
                })
            };
            found = found.max(distance_m);
            if stated(found) > limit_m {
                break;
            }
        }
        stated(found)
    }
}

/// Distance from `point` to a line, by Gauss and Newton from the fraction `start`; anything up to
/// `enough_m` is as good as 0.
fn nearest(point: DVec3, start: f64, enough_m: f64, line: impl Fn(f64) -> DVec3) -> f64 {
    /// Of the difference quotient: short for the line to be straight, long against rounding.
    const SPACING: f64 = 1e-3;
    let mut fraction = start;
    let mut smallest = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        let at = line(fraction);
        let distance = point.distance(at);
        // Once it no longer falls by a thousandth the next step cannot change what is stated.
        let settled = distance > 0.999 * smallest;
        smallest = smallest.min(distance);
        if smallest <= enough_m || settled {
            break;
        }
        let aside = if fraction > 0.5 {
            fraction - SPACING
        } else {
            fraction + SPACING
        };
        let slope = (line(aside) - at) / (aside - fraction);
        let length_squared = slope.length_squared();
        if length_squared == 0.0 {
            break;
        }
        fraction = (fraction + (point - at).dot(slope) / length_squared).clamp(0.0, 1.0);
    }
    smallest
}

/// A ring, and whether what a file with only this ring would mean by it is what is meant.
struct SidedRing {
    ring: Ring,
    /// Otherwise it means the rest of the body.
    natural: bool,
}

impl SidedRing {
    /// - `places`: interior on the left, longitudes within ±180
    ///
    /// A pole becomes two vertices, at the longitudes of its neighbours: the edges to it are
    /// meridians, and the one along it is a point of the body.
    fn new(places: &[Degrees], body: &Ellipsoid) -> Self {
        let is_pole = |at: &Degrees| at[1].abs() == 90.0;
        let first = places.iter().position(|at| !is_pole(at)).unwrap_or(0);
        let start_deg = places[first][0];
        let mut vertices: Vec<Degrees> = Vec::with_capacity(places.len());
        let (mut turns, mut longitude) = (0.0, start_deg);
        let mut pole = None;
        for at in places[first..].iter().chain(&places[..=first]) {
            if is_pole(at) {
                vertices.push([longitude + 360.0 * turns, at[1]]);
                pole = Some(at[1]);
                continue;
            }
            let step = short_step(longitude, at[0]);
            turns += ((longitude + step - at[0]) / 360.0).round();
            longitude = at[0];
            let unrolled = longitude + 360.0 * turns;
            if let Some(latitude) = pole.take() {
                vertices.push([unrolled, latitude]);
            }
            vertices.push([unrolled, at[1]]);
        }
        // The start again, one turn on where the ring goes round the axis.
        vertices.pop();
        vertices.dedup();
        let ring = Ring::from_checked(vertices, 360.0 * turns);
        let natural = if turns == 0.0 {
            signed_area(&ring) > 0.0
        } else {
            // The smaller side is what a reader takes; of halves the left one.
            let polygon = Polygon {
                shell: ring.clone(),
                holes: Vec::new(),
            };
            let side = polygon.sides(EdgeRule::Planar, body, Inside::Smaller)[0];
            side.choice.is_none()
        };
        Self { ring, natural }
    }
}

/// Twice the area in square degrees, positive when counter-clockwise.
fn signed_area(ring: &Ring) -> f64 {
    let origin = ring.vertices_deg()[0];
    ring.edges_deg()
        .map(|(from, to)| {
            (from[0] - origin[0]) * (to[1] - origin[1])
                - (to[0] - origin[0]) * (from[1] - origin[1])
        })
        .sum()
}

/// The polygon of one ring, or of an outer and an inner one.
///
/// A ring that would be read the other way round is cut out of the whole body. When both are, each
/// stands for the rest of the body, and the inner one's rest holds the outer one's.
fn polygon(rings: Vec<SidedRing>) -> Polygon {
    let outer_natural = rings.first().is_none_or(|outer| outer.natural);
    // An inner ring is seen from the region, which is outside it: turned round it must be natural.
    let inner_natural = rings.get(1).is_none_or(|inner| !inner.natural);
    let mut rings: Vec<Ring> = rings.into_iter().map(|sided| sided.ring).collect();
    if !outer_natural && inner_natural {
        rings.insert(0, whole_body());
    } else if !outer_natural {
        rings.reverse();
    }
    let shell = rings.remove(0);
    Polygon {
        shell,
        holes: rings,
    }
}

fn whole_body() -> Ring {
    let corners = vec![
        [-180.0, -90.0],
        [180.0, -90.0],
        [180.0, 90.0],
        [-180.0, 90.0],
    ];
    Ring::from_checked(corners, 0.0)
}
