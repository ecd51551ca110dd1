// SPDX-License-Identifier: MIT OR Apache-2.0
//! One boundary edge: where it runs by its rule, how far the wall drawn for it is away from that, and
//! where to split it.
//!
//! Endpoints in degrees within ±180 and ±90, no edge crossing the antimeridian. Everything here is
//! symmetric in the endpoints to the last bit, so that two regions that share an edge, one from
//! each side, split it at the same places.
//!
//! Great ellipses are handled as great circles on the sphere of geodetic latitudes: tangents of
//! geocentric and geodetic latitude differ by a constant factor, so a plane through the body's
//! centre stays one.

pub(crate) mod area;

use crate::{EdgeRule, Ellipsoid, Geodetic, MeshOptions};
use glam::DVec3;
use terrafill_planar::intersection::unit_arcs_crossing;
pub(crate) use terrafill_planar::{Degrees, in_order};

/// Ratio of the deviation of an edge to its length above which it is split however small it is. Beyond
/// it a triangle next to the edge can be turned over. That happens only near poles and on small bodies,
/// where the tolerance in metres says nothing.
const LARGEST_RELATIVE_BOW: f64 = 0.05;
/// Longitude span below which [`LARGEST_RELATIVE_BOW`] cannot be reached, degrees: the bow of a
/// straight line in longitude and latitude is at most Δλ · length / 4.
const HARMLESS_SPAN_DEG: f64 = 11.4;
/// Ratio of the distances from the pole between places that split a planar edge which ends there.
/// A power of two, so that their latitudes are exact.
const POLE_APPROACH_RATIO: f64 = 4.0;
/// Distance from the pole of the last such place, degrees: 2⁻³⁶, on the Earth 1.6 µm.
pub(crate) const POLE_APPROACH_END_DEG: f64 = 1.0 / (1_u64 << 36) as f64;
/// Longest edge along a pole, degrees of longitude: its triangles reach down to the next vertices.
pub(crate) const POLE_STEP_DEG: f64 = 30.0;
/// Edges along a pole are split at multiples of this, a sixteenth of a turn.
const POLE_PLACES_DEG: f64 = 22.5;
/// Distances smaller than this share of the body's radius are rounding, 0.1 µm on the Earth.
pub(crate) const ROUNDING: f64 = 2e-14;
/// Planar edges that span more longitude than this are split unmeasured, radians; none that a step
/// of 30° allows does, except on a circle round a pole that [`LARGEST_RELATIVE_BOW`] splits anyway.
const WIDEST_MEASURED_RAD: f64 = 1.0;
/// Arcs shorter than this are straight in longitude and latitude to the last bit, unless they span more
/// longitude than [`STRAIGHT_WIDTH_RAD`], as they do beside a pole.
const STRAIGHT_ARC_RAD: f64 = 1e-9;
/// A straight line in degrees is off an arc by a quarter of the product of the two.
const STRAIGHT_WIDTH_RAD: f64 = 1e-7;
/// Finest tolerance that edges are split for, as a share of the equatorial radius: 0.3 mm on the
/// Earth, as fine as positions are drawn of a region 340 km wide. Parts get more with the root of
/// what a finer one divides by, and all of an edge must be held and triangulated.
pub(crate) const FINEST_TOLERANCE: f64 = 5e-11;
/// Halvings of one edge after which splitting stops: a whole parallel is 65,536 parts of 600 m then,
/// at most 7 mm off on the Earth.
const MAX_HALVINGS: u32 = 16;

/// What is needed to judge edges, and the worst deviation seen so far.
pub(crate) struct EdgeSplitter<'a> {
    body: &'a Ellipsoid,
    rule: EdgeRule,
    tolerance_m: f64,
    step_rad: f64,
    /// Largest distance between a kept edge as drawn and by its rule, metres.
    pub(crate) deviation_m: f64,
}

impl<'a> EdgeSplitter<'a> {
    pub(crate) fn new(body: &'a Ellipsoid, rule: EdgeRule, options: &MeshOptions) -> Self {
        Self {
            body,
            rule,
            tolerance_m: options
                .boundary_tolerance_m
                .max(FINEST_TOLERANCE * body.equatorial_radius_m()),
            step_rad: options.cap_step_deg.to_radians(),
            deviation_m: 0.0,
        }
    }

    pub(crate) fn body(&self) -> &'a Ellipsoid {
        self.body
    }

    /// Calls `emit` with each point that splits the edge, in order from `start` to `end`.
    pub(crate) fn split(&mut self, start: Degrees, end: Degrees, emit: &mut impl FnMut(Degrees)) {
        if along_pole(start, end).is_some() {
            places_along_pole(start, end).for_each(emit);
            return;
        }
        let mut from = start;
        if self.rule == EdgeRule::Planar {
            for place in pole_approach(start, end) {
                self.split_further(from, place, MAX_HALVINGS, emit);
                emit(place);
                from = place;
            }
        }
        self.split_further(from, end, MAX_HALVINGS, emit);
    }

    fn split_further(
        &mut self,
        start: Degrees,
        end: Degrees,
        halvings_left: u32,
        emit: &mut impl FnMut(Degrees),
    ) {
        if is_at_pole(start, end) || !self.should_split(start, end) {
            return;
        }
        if halvings_left == 0 {
            let measured = measure(self.body, self.rule, start, end);
            self.deviation_m = self.deviation_m.max(measured.deviation_m);
            return;
        }
        let middle = point_on_edge(self.rule, start, end, 0.5);
        self.split_further(start, middle, halvings_left - 1, emit);
        emit(middle);
        self.split_further(middle, end, halvings_left - 1, emit);
    }

    /// An edge that spans no more degrees of longitude and latitude together and does not end at a pole is
    /// certainly drawn whole.
    pub(crate) fn whole_below_deg(&self) -> f64 {
        // Neither bound of edge_bounds_m grows by more than the square of this sum.
        let of_one_rad = edge_bounds_m(self.body, self.rule, [0.0; 2], [1_f64.to_degrees(); 2]);
        let tolerance_m = self.tolerance_m;
        let of_bounds = of_one_rad.map(|bound_m| (tolerance_m / bound_m).sqrt());
        let within_bounds = of_bounds[0].min(of_bounds[1]);
        let below = within_bounds.min(self.step_rad).to_degrees();
        below.min(0.5 * HARMLESS_SPAN_DEG)
    }

    /// Whether nothing about an edge can be too much, and it deviates by no more than `deviation_m`.
    fn is_harmless(&self, start: Degrees, end: Degrees, deviation_m: f64) -> bool {
        let [bow_bound_m, deviation_bound_m] = edge_bounds_m(self.body, self.rule, start, end);
        (end[0] - start[0]).abs() < HARMLESS_SPAN_DEG
            && bow_bound_m <= self.tolerance_m
            && deviation_bound_m <= deviation_m
    }

    fn should_split(&mut self, start: Degrees, end: Degrees) -> bool {
        let (start, end) = in_order(start, end);
        let longitude_rad = (end[0] - start[0]).abs().to_radians();
        let latitude_rad = (end[1] - start[1]).abs().to_radians();
        // Ends more than half a turn apart can be neighbours on the body, and the two ends of a
        // whole parallel are one place: nothing measured between them would mean the edge.
        if self.rule == EdgeRule::Planar && longitude_rad > WIDEST_MEASURED_RAD {
            return true;
        }
        // No square of such a length overflows, and what underflows is 0 to every bound below.
        let length_rad = hypotenuse(longitude_rad, latitude_rad);
        if length_rad > self.step_rad && arc_rad(start, end) > self.step_rad {
            return true;
        }
        if self.is_harmless(start, end, self.deviation_m.min(self.tolerance_m)) {
            return false;
        }
        let measured = measure(self.body, self.rule, start, end);
        // Below the rounding of ECEF coordinates a measured deviation is noise.
        let limit_m = self
            .tolerance_m
            .min(LARGEST_RELATIVE_BOW * measured.length_m)
            .max(ROUNDING * self.body.equatorial_radius_m());
        // A point that no longer lies between the ends cannot split the edge.
        let middle = point_on_edge(self.rule, start, end, 0.5);
        let splittable = middle != start && middle != end;
        if splittable && (measured.deviation_m > limit_m || measured.bow_m > limit_m) {
            return true;
        }
        self.deviation_m = self.deviation_m.max(measured.deviation_m);
        false
    }
}

/// Of lengths in radians: no square of one overflows, and what underflows is 0 to every bound here.
fn hypotenuse(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// Upper bounds in metres for an edge much shorter than a radian. Its bow is by how much a straight
/// line in longitude and latitude is off the great circle. Its deviation is by how much its rule is off
/// the edge as drawn.
pub(crate) fn edge_bounds_m(
    body: &Ellipsoid,
    rule: EdgeRule,
    start: Degrees,
    end: Degrees,
) -> [f64; 2] {
    let longitude_rad = (end[0] - start[0]).abs().to_radians();
    let latitude_rad = (end[1] - start[1]).abs().to_radians();
    let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
    // A straight line in longitude and latitude bends away from the great circle with the covariant
    // acceleration (sin φ cos φ Δλ², 2 tan φ · cos φ Δλ Δφ). An arc of acceleration w bows by w / 8.
    // Half as much again covers the change along the edge.
    let largest_radius_m = a * a / b;
    let bow_m =
        0.19 * largest_radius_m * longitude_rad * hypotenuse(longitude_rad, 2.0 * latitude_rad);
    let deviation_m = match rule {
        EdgeRule::Planar => bow_m,
        // Plane through the centre against plane along the normal: they differ by less than
        // e², and the arc rises above its chord by L² / 8R.
        EdgeRule::GreatEllipse => {
            let length_m = largest_radius_m * hypotenuse(longitude_rad, latitude_rad);
            0.25 * body.eccentricity_squared() * length_m * length_m / b
        }
    };
    [bow_m, deviation_m]
}

/// Whether an edge has one end at a pole and the other no farther from it than where
/// [`pole_approach`] ends: places between the two would be the pole to rounding.
fn is_at_pole(start: Degrees, end: Degrees) -> bool {
    let apart_deg = (start[1] - end[1]).abs();
    [start, end]
        .iter()
        .any(|[_, latitude]| latitude.abs() == 90.0)
        && apart_deg <= POLE_APPROACH_END_DEG
}

/// Places that split a planar edge with an end at a pole, in order from `start` to `end`; none for
/// other edges and for meridians.
///
/// All ends at a pole are one point of the body, so the last piece is drawn as a meridian whatever
/// longitude it was to end at. Two edges from one vertex would become one and lose the area between
/// them. Halving by the boundary's tolerance does not help: that area can be all a region has. So these
/// edges are split at fixed parallels down to where what is left is below rounding; parallels, and not
/// parts of the edge, so that edges side by side are split side by side.
///
/// An edge from pole to pole is split so at both: the ladders end 64° from their poles.
fn pole_approach(start: Degrees, end: Degrees) -> Vec<Degrees> {
    if start[0] == end[0] || along_pole(start, end).is_some() {
        return Vec::new();
    }
    let at_pole = |[_, latitude]: Degrees| latitude.abs() == 90.0;
    let mut places = Vec::new();
    if at_pole(start) {
        places.extend(ladder(start, end));
    }
    if at_pole(end) {
        let downwards = places.len();
        places.extend(ladder(end, start));
        places[downwards..].reverse();
    }
    places
}

/// Places on the edge from a pole, from there on.
fn ladder(pole: Degrees, other: Degrees) -> impl Iterator<Item = Degrees> {
    let height_deg = (pole[1] - other[1]).abs();
    let further = |distance_deg: &f64| Some(distance_deg * POLE_APPROACH_RATIO);
    std::iter::successors(Some(POLE_APPROACH_END_DEG), further)
        .take_while(move |distance_deg| *distance_deg < height_deg)
        .take_while(|distance_deg| *distance_deg < 90.0)
        .map(move |distance_deg| {
            [
                pole[0] + (other[0] - pole[0]) * (distance_deg / height_deg),
                pole[1] - distance_deg.copysign(pole[1]),
            ]
        })
}

/// Places that split an edge along a pole, in order from `start` to `end`.
///
/// They are split at the same longitudes in all edges, and never so near to an end that the rest could
/// have been left whole. Otherwise halves of two edges that partly overlap could lie a last bit apart.
/// No interior edge that ends at one of two such neighbours can be split at its middle without touching
/// those of the other.
fn places_along_pole(start: Degrees, end: Degrees) -> impl Iterator<Item = Degrees> {
    let (west, east) = (start[0].min(end[0]), start[0].max(end[0]));
    let clearance_deg = POLE_STEP_DEG - POLE_PLACES_DEG;
    // Shorter ones stay whole.
    let first = if east - west > POLE_STEP_DEG { -8 } else { 9 };
    let eastward = start[0] < end[0];
    (first..=8)
        .map(move |k| POLE_PLACES_DEG * f64::from(if eastward { k } else { -k }))
        .filter(move |x| *x - west >= clearance_deg && east - *x >= clearance_deg)
        .map(move |x| [x, start[1]])
}

/// Latitude of the pole that both ends lie at.
pub(crate) fn along_pole(start: Degrees, end: Degrees) -> Option<f64> {
    (start[1].abs() == 90.0 && start[1] == end[1]).then_some(start[1])
}

/// Unit normal of the body at a position.
pub(crate) fn normal([longitude_deg, latitude_deg]: Degrees) -> DVec3 {
    let (sin_lon, cos_lon) = longitude_deg.to_radians().sin_cos();
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// Where two arcs cross, each strictly between its ends and by more than rounding can feign.
pub(crate) fn great_ellipse_crossing(a: [Degrees; 2], b: [Degrees; 2]) -> Option<Degrees> {
    unit_arcs_crossing(a.map(normal), b.map(normal))
}

/// Angle between the normals of two positions. From the chord: an arc cosine has no digits left
/// for neighbours.
pub(crate) fn arc_rad(a: Degrees, b: Degrees) -> f64 {
    2.0 * (0.5 * (normal(b) - normal(a)).length()).min(1.0).asin()
}

/// Point on the surface, ECEF metres; poles exactly on the axis, ±180 one and the same meridian.
pub(crate) fn surface_point(body: &Ellipsoid, [longitude_deg, latitude_deg]: Degrees) -> DVec3 {
    if latitude_deg.abs() == 90.0 {
        return DVec3::new(0.0, 0.0, body.polar_radius_m().copysign(latitude_deg));
    }
    let longitude_deg = if longitude_deg == -180.0 {
        180.0
    } else {
        longitude_deg
    };
    body.geodetic_to_ecef(Geodetic::from_degrees(longitude_deg, latitude_deg, 0.0))
}

/// Point of the edge at `fraction` of its length (of its longitude span for planar edges).
pub(crate) fn point_on_edge(
    rule: EdgeRule,
    start: Degrees,
    end: Degrees,
    fraction: f64,
) -> Degrees {
    let (start, end) = in_order(start, end);
    // Rounding must not carry the point past the edge's ends: along a meridian, off it.
    let planar = [0, 1].map(|i| {
        let (low, high) = (start[i].min(end[i]), start[i].max(end[i]));
        (start[i] * (1.0 - fraction) + end[i] * fraction).clamp(low, high)
    });
    let meridian = start[0] == end[0] || start[1].abs() == 90.0 || end[1].abs() == 90.0;
    if rule == EdgeRule::Planar || meridian {
        return planar;
    }
    let (from, to) = (normal(start), normal(end));
    let angle = arc_rad(start, end);
    let width_rad = (end[0] - start[0]).to_radians();
    if angle < STRAIGHT_ARC_RAD && width_rad < STRAIGHT_WIDTH_RAD {
        return planar;
    }
    let point = from * ((1.0 - fraction) * angle).sin() + to * (fraction * angle).sin();
    let longitude_deg = point.y.atan2(point.x).to_degrees();
    let latitude_deg = point.z.atan2(point.x.hypot(point.y)).to_degrees();
    // Nor onto a pole: what ends there is drawn as a meridian, and this arc's parts are none.
    let highest_deg = 90_f64.next_down();
    [
        longitude_deg.clamp(start[0], end[0]),
        latitude_deg.clamp(-highest_deg, highest_deg),
    ]
}

/// Where the great circle through two places crosses a meridian between them, degrees latitude.
pub(crate) fn great_circle_latitude(start: Degrees, end: Degrees, longitude_deg: f64) -> f64 {
    let (start, end) = in_order(start, end);
    let span = (end[0] - start[0]).to_radians();
    let from_start = (longitude_deg - start[0]).to_radians();
    let from_end = (end[0] - longitude_deg).to_radians();
    let tangent =
        start[1].to_radians().tan() * from_end.sin() + end[1].to_radians().tan() * from_start.sin();
    (tangent / span.sin()).atan().to_degrees()
}

struct Measured {
    /// Of the chord, metres.
    length_m: f64,
    /// Between the edge by its rule and its wall, metres.
    deviation_m: f64,
    /// Between the straight line in longitude and latitude, which the triangulation sees, and the
    /// wall, metres.
    bow_m: f64,
}

/// Compares an edge with its wall: the chord swept along the normals of its ends.
fn measure(body: &Ellipsoid, rule: EdgeRule, start: Degrees, end: Degrees) -> Measured {
    let (start, end) = in_order(start, end);
    let from = surface_point(body, start);
    let chord = surface_point(body, end) - from;
    let up = [start, end].map(normal);
    let squared = chord.length_squared().max(f64::MIN_POSITIVE);
    let distance = |rule: EdgeRule, fraction: f64| {
        let point = surface_point(body, point_on_edge(rule, start, end, fraction)) - from;
        let share = point.dot(chord) / squared;
        // The two normals of an oblate body are not in one plane: the wall is twisted.
        let wall = chord.cross(up[0].lerp(up[1], share)).normalize_or_zero();
        wall.dot(point)
    };
    let largest = |rule: EdgeRule| largest_of([0.25, 0.5, 0.75].map(|t| distance(rule, t)));
    let deviation_m = largest(rule);
    let bow_m = match rule {
        EdgeRule::Planar => deviation_m,
        EdgeRule::GreatEllipse => largest(EdgeRule::Planar),
    };
    Measured {
        length_m: chord.length(),
        deviation_m,
        bow_m,
    }
}

/// Largest absolute value of `t (1 − t) q(t)` on 0 … 1, with the parabola q that gives it these
/// values at ¼, ½ and ¾: a long edge bows most off its middle.
fn largest_of([first, middle, last]: [f64; 3]) -> f64 {
    let (before, at, after) = (first * 16.0 / 3.0, middle * 4.0, last * 16.0 / 3.0);
    let (slope, bend) = (0.5 * (after - before), 0.5 * (after + before) - at);
    (1..32)
        .map(|k| {
            let t = f64::from(k) / 32.0;
            let x = 4.0 * t - 2.0;
            (t * (1.0 - t) * (at + x * (slope + x * bend))).abs()
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sine of the angle at which a place is off the plane of an arc.
    fn off(arc: [Degrees; 2], place: Degrees) -> f64 {
        let [from, to] = arc.map(normal);
        let plane = from.cross(to - from).normalize();
        plane.dot(normal(place) - from).abs()
    }

    #[test]
    fn a_crossing_of_arcs_that_hardly_differ_is_on_both() {
        let mut off_by_planes = 0.0_f64;
        for apart_deg in [1e-1, 1e-5, 1e-9, 1e-11] {
            let a = [[10.0, -33.0], [100.0, 41.0]];
            let b = [[10.0, -33.0 - apart_deg], [100.0, 41.0 + apart_deg]];
            let at = great_ellipse_crossing(a, b).expect("cross");
            for arc in [a, b] {
                assert!(off(arc, at) < 1e-15, "{apart_deg}: {}", off(arc, at));
            }
            // Negative control: as the line in which the planes meet.
            let [m, n] = [a, b]
                .map(|arc| arc.map(normal))
                .map(|[p, q]| p.cross(q - p));
            let line = m.cross(n).normalize();
            let place = [line.y.atan2(line.x), line.z.atan2(line.x.hypot(line.y))];
            off_by_planes = off_by_planes.max(off(a, place.map(f64::to_degrees)));
        }
        assert!(off_by_planes > 1e-8, "{off_by_planes}");
    }

    #[test]
    fn middle_of_two_neighbours_lies_between_them() {
        // Two corners of Washington, D.C., 2 cm apart at 1:110m.
        let (a, b) = (
            [-77.041_235_015_754_28, 38.789_544_853_649_8],
            [-77.041_234_970_092_77, 38.789_545_059_204_1],
        );
        for scale in [1.0, 1e-3, 1e-6] {
            let b = [0, 1].map(|i| a[i] + (b[i] - a[i]) * scale);
            let middle = point_on_edge(EdgeRule::GreatEllipse, a, b, 0.5);
            assert!(a[1] <= middle[1] && middle[1] <= b[1], "{middle:?}");
        }
    }

    #[test]
    fn a_tiny_arc_beside_a_pole_is_no_straight_line_in_degrees() {
        let [start, end] = [[-6.813_725_5, -89.999_999_994], [60.0, -89.999_999_999_9]];
        let off = |place: Degrees| off([start, end], place);
        for share in [0.125, 0.5, 0.75] {
            let on_arc = point_on_edge(EdgeRule::GreatEllipse, start, end, share);
            // The last bit of a latitude near 90.
            assert!(off(on_arc) < 3e-16, "{share}: {}", off(on_arc));
            // Negative control: as a straight line.
            let straight = point_on_edge(EdgeRule::Planar, start, end, share);
            assert!(off(straight) > 1e-12, "{share}: {}", off(straight));
        }
    }

    #[test]
    fn places_of_an_edge_along_the_antimeridian_are_on_it() {
        let ends = [[-180.0, 0.1], [-180.0, 0.3]];
        let mut off_without_clamp = 0;
        for step in 1..1_000 {
            let share = f64::from(step) / 1_000.0;
            for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
                let [longitude, latitude] = point_on_edge(rule, ends[0], ends[1], share);
                assert_eq!(longitude, -180.0);
                assert!((0.1..=0.3).contains(&latitude));
            }
            // Negative control: as the sum alone.
            let sum = ends[0][0] * (1.0 - share) + ends[1][0] * share;
            off_without_clamp += u32::from(sum < -180.0);
        }
        assert!(off_without_clamp > 10, "{off_without_clamp}");
    }

    #[test]
    fn an_edge_and_its_reverse_split_at_the_same_bits() {
        let body = Ellipsoid::WGS84;
        let options = MeshOptions {
            boundary_tolerance_m: 10.0,
            cap_step_deg: 3.0,
        };
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let (a, b) = ([10.1, 47.3], [31.7, 52.9]);
            let mut there = Vec::new();
            let mut back = Vec::new();
            let mut splitter = EdgeSplitter::new(&body, rule, &options);
            splitter.split(a, b, &mut |point| there.push(point));
            EdgeSplitter::new(&body, rule, &options).split(b, a, &mut |point| back.push(point));
            back.reverse();
            assert!(there.len() > 20);
            assert_eq!(there, back);
            assert!(splitter.deviation_m > 0.0 && splitter.deviation_m <= 10.0);
        }
    }

    #[test]
    fn shortcuts_never_change_where_an_edge_is_split() {
        // A splitter that has already seen a large deviation takes every shortcut it can; a fresh
        // one measures. Their points must agree.
        let options = MeshOptions::default();
        let mut random = terrafill_fixtures::random_numbers(7);
        for body in [
            Ellipsoid::WGS84,
            Ellipsoid::SATURN_LIKE,
            Ellipsoid::UNIT_SPHERE,
        ] {
            for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
                let mut hasty = EdgeSplitter::new(&body, rule, &options);
                hasty.deviation_m = options.boundary_tolerance_m;
                for _ in 0..400 {
                    let a = [360.0 * random() - 180.0, 180.0 * random() - 90.0];
                    let reach = 10_f64.powf(-4.0 * random()) * 30.0;
                    let b = [
                        (a[0] + reach * (random() - 0.5)).clamp(-180.0, 180.0),
                        (a[1] + reach * (random() - 0.5)).clamp(-90.0, 90.0),
                    ];
                    let (mut quick, mut slow) = (Vec::new(), Vec::new());
                    hasty.split(a, b, &mut |point| quick.push(point));
                    let mut fresh = EdgeSplitter::new(&body, rule, &options);
                    fresh.split(a, b, &mut |point| slow.push(point));
                    assert_eq!(quick, slow, "{} {a:?} {b:?}", body.name());
                }
            }
        }
    }

    #[test]
    fn edges_along_a_pole_are_split_at_the_same_places_wherever_they_end() {
        let places = |west: f64, east: f64| -> Vec<f64> {
            let options = MeshOptions::default();
            let body = Ellipsoid::WGS84;
            let mut splitter = EdgeSplitter::new(&body, EdgeRule::GreatEllipse, &options);
            let mut found = Vec::new();
            let mut emit = |place: Degrees| found.push(place);
            splitter.split([west, -90.0], [east, -90.0], &mut emit);
            assert!(found.iter().all(|place| place[1] == -90.0));
            found.iter().map(|place| place[0]).collect()
        };
        let whole = places(-180.0, 180.0);
        assert_eq!(whole.len(), 15);
        for (west, east) in [
            (-180.0, 180.0),
            (-180.0, 179.999_999_999_999_97),
            (-179.999_999, 22.500_000_1),
            (-97.3, 12.1),
            (10.0, 40.1),
        ] {
            let found = places(west, east);
            assert!(found.iter().all(|x| whole.contains(x)), "{found:?}");
            let all = [&[west], found.as_slice(), &[east]].concat();
            let steps = || all.windows(2).map(|pair| pair[1] - pair[0]);
            assert!(steps().all(|step| (7.5..=POLE_STEP_DEG).contains(&step)));
            let mut back = places(east, west);
            back.reverse();
            assert_eq!(back, found);
        }
        assert!(places(10.0, 40.0).is_empty());
        // Negative control: halves of the second do not lie at the places of the first.
        let end = 179.999_999_999_999_97_f64;
        let half = 0.5 * (-180.0 + end);
        assert!(!whole.contains(&half));
    }
}
