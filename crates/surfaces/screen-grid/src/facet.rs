// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a flat triangle lies: its heights, inside and not only at its corners, and its extent.

use glam::DVec3;
use terrafill_core::{Ellipsoid, Extent, wrapped_deg};
use terrafill_surface::HeightRange;

/// Added to extents, degrees: longitudes and latitudes are rounded to some 1e-14 of them.
const ROUNDING_DEG: f64 = 1e-9;

/// Heights of a triangle's points.
///
/// Scaled by 1 / radii, the body is the unit sphere. A point `s` from its centre there lies on a body `s` times
/// as large as this one. It is at most `a (1 − s)` below this one, and at most `a (s − 1)` above. The point
/// nearest to the centre is the lowest; above, the farthest corner is the highest.
pub(crate) fn heights(body: &Ellipsoid, corners_ecef: [DVec3; 3]) -> HeightRange {
    let scaled = corners_ecef.map(|corner| corner / body.radii_m());
    let radius_m = body.equatorial_radius_m();
    let farthest = scaled.map(DVec3::length).into_iter().fold(0.0, f64::max);
    HeightRange {
        lowest_m: radius_m * (nearest(scaled).length() - 1.0).min(0.0),
        highest_m: radius_m * (farthest - 1.0).max(0.0),
    }
}

/// The point of a triangle nearest to the origin: the foot of the perpendicular where the triangle holds it,
/// else on an edge.
fn nearest([a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = (b - a).cross(c - a);
    let foot = normal * (normal.dot(a) / normal.length_squared());
    let is_inside = |(from, to): (DVec3, DVec3)| (to - from).cross(foot - from).dot(normal) >= 0.0;
    let edges = [(a, b), (b, c), (c, a)];
    // Of a triangle without area the foot is no number, which is not inside.
    if edges.into_iter().all(is_inside) {
        return foot;
    }
    let on_edge = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let at = -from.dot(along) / along.length_squared();
        // Both ends may be one point.
        from + along * if at > 0.0 { at.min(1.0) } else { 0.0 }
    };
    let [one, two, three] = edges.map(on_edge);
    let nearer = |p: DVec3, q: DVec3| if q.length() < p.length() { q } else { p };
    nearer(nearer(one, two), three)
}

/// Smallest extent that is known to hold a triangle's points.
///
/// Seen from the centre it is a spherical triangle. Its latitudes reach to its corners and to a pole that it
/// holds. They also reach to the northernmost and southernmost points of its edges' great circles, where these
/// lie on the edges. Geodetic latitudes differ from those by the angle at which the normal passes the centre. It
/// passes it by no more than `a − b`, so that the angle is at most `asin((a − b) / r)` at the distance `r`.
pub(crate) fn extent(body: &Ellipsoid, corners_ecef: [DVec3; 3]) -> Extent {
    let degrees = |angle: f64| angle.to_degrees();
    let longitudes = corners_ecef.map(|p| degrees(p.y.atan2(p.x)));
    let turned = longitudes.map(|longitude| wrapped_deg(longitude - longitudes[0]));
    let (from, to) = (least(turned), greatest(turned));
    let latitude = |p: DVec3| degrees(p.z.atan2(p.x.hypot(p.y)));
    let (mut south, mut north) = (
        least(corners_ecef.map(latitude)),
        greatest(corners_ecef.map(latitude)),
    );
    for i in 0..3 {
        let (a, b) = (corners_ecef[i], corners_ecef[(i + 1) % 3]);
        let normal = a.cross(b);
        // Highest where the great circle's plane is steepest.
        let top = DVec3::Z - normal * (normal.z / normal.length_squared());
        let is_between = |p: DVec3| a.cross(p).dot(normal) > 0.0 && p.cross(b).dot(normal) > 0.0;
        if is_between(top) {
            north = north.max(latitude(top));
        }
        if is_between(-top) {
            south = south.min(latitude(-top));
        }
    }
    let is_round = to - from >= 180.0 - ROUNDING_DEG;
    if is_round {
        let [a, b, c] = corners_ecef;
        let normal = (b - a).cross(c - a);
        // Where the axis pierces the triangle's plane.
        let height = normal.dot(a) / normal.z;
        if height >= 0.0 || !height.is_finite() {
            north = 90.0;
        }
        if height <= 0.0 || !height.is_finite() {
            south = -90.0;
        }
    }
    let nearest_m = nearest(corners_ecef).length();
    let aside = (body.equatorial_radius_m() - body.polar_radius_m()).abs() / nearest_m;
    let margin = if aside < 1.0 {
        degrees(aside.asin())
    } else {
        180.0
    } + ROUNDING_DEG;
    let (west_deg, east_deg) = if is_round {
        (-180.0, 180.0)
    } else {
        (
            wrapped_deg(longitudes[0] + from - ROUNDING_DEG),
            wrapped_deg(longitudes[0] + to + ROUNDING_DEG),
        )
    };
    Extent {
        west_deg,
        south_deg: (south - margin).max(-90.0),
        east_deg,
        north_deg: (north + margin).min(90.0),
    }
}

/// An extent that holds both.
pub(crate) fn united(one: Extent, other: Extent) -> Extent {
    let width = |west: f64, east: f64| {
        if east >= west {
            east - west
        } else {
            east - west + 360.0
        }
    };
    let is_whole = |extent: &Extent| width(extent.west_deg, extent.east_deg) >= 360.0;
    // The narrower of beginning with the one and of beginning with the other.
    let from = |first: &Extent, second: &Extent| {
        let to_second = width(first.west_deg, second.west_deg);
        let reach = to_second + width(second.west_deg, second.east_deg);
        reach.max(width(first.west_deg, first.east_deg))
    };
    let (by_one, by_other) = (from(&one, &other), from(&other, &one));
    let (west_deg, wide) = if by_one <= by_other {
        (one.west_deg, by_one)
    } else {
        (other.west_deg, by_other)
    };
    let is_whole = wide >= 360.0 || is_whole(&one) || is_whole(&other);
    Extent {
        west_deg: if is_whole { -180.0 } else { west_deg },
        east_deg: if is_whole {
            180.0
        } else {
            wrapped_deg(west_deg + wide)
        },
        south_deg: one.south_deg.min(other.south_deg),
        north_deg: one.north_deg.max(other.north_deg),
    }
}

fn least(values: [f64; 3]) -> f64 {
    values.into_iter().fold(f64::INFINITY, f64::min)
}

fn greatest(values: [f64; 3]) -> f64 {
    values.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::Geodetic;

    fn is_in(extent: &Extent, longitude_deg: f64, latitude_deg: f64) -> bool {
        let is_between = if extent.west_deg <= extent.east_deg {
            (extent.west_deg..=extent.east_deg).contains(&longitude_deg)
        } else {
            longitude_deg >= extent.west_deg || longitude_deg <= extent.east_deg
        };
        is_between && (extent.south_deg..=extent.north_deg).contains(&latitude_deg)
    }

    /// Triangles with corners up to `wide` apart, and points of each.
    fn triangles(body: Ellipsoid, wide: f64) -> impl Iterator<Item = [DVec3; 3]> {
        (0..400_u32).map(move |i| {
            let at = |j: u32| {
                let noise = |k: u32| {
                    f64::from((i * 7919 + j * 104_729 + k * 15_485_863) % 10_007) / 10_007.0
                };
                let middle = [
                    f64::from(i % 37) * 10.0 - 180.0,
                    f64::from(i % 19) * 10.0 - 90.0,
                ];
                let longitude = middle[0] + (noise(1) - 0.5) * wide;
                let latitude = (middle[1] + (noise(2) - 0.5) * wide).clamp(-90.0, 90.0);
                body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, 0.0))
            };
            [at(0), at(1), at(2)]
        })
    }

    fn points([a, b, c]: [DVec3; 3]) -> impl Iterator<Item = DVec3> {
        (0..=12).flat_map(move |i| {
            (0..=12 - i).map(move |j| {
                let [u, v] = [i, j].map(|k| f64::from(k) / 12.0);
                a * (1.0 - u - v) + b * u + c * v
            })
        })
    }

    #[test]
    fn no_point_of_a_triangle_lies_outside_its_heights_and_its_extent() {
        let (mut beside, mut loose) = (0, 0.0_f64);
        for body in [Ellipsoid::WGS84, Ellipsoid::SATURN_LIKE] {
            for wide in [0.1, 20.0, 120.0] {
                for corners in triangles(body, wide) {
                    let (stated, extent) = (heights(&body, corners), extent(&body, corners));
                    let at_corners = corners.map(|p| {
                        let place = body.ecef_to_geodetic(p);
                        [place.longitude_rad, place.latitude_rad].map(f64::to_degrees)
                    });
                    let mut lowest = 0.0_f64;
                    for p in points(corners) {
                        let place = body.ecef_to_geodetic(p);
                        let [longitude, latitude] =
                            [place.longitude_rad, place.latitude_rad].map(f64::to_degrees);
                        let rounding = 1e-14 * body.equatorial_radius_m();
                        lowest = lowest.min(place.height_m);
                        assert!(
                            place.height_m >= stated.lowest_m - rounding,
                            "{place:?} {stated:?}"
                        );
                        assert!(place.height_m <= stated.highest_m + rounding);
                        if -place.height_m < 0.9 * body.smallest_curvature_radius_m() {
                            assert!(is_in(&extent, longitude, latitude), "{place:?} {extent:?}");
                        }
                        // Negative control: the corners' own extent does not hold it.
                        let beyond = at_corners.iter().all(|corner| corner[1] < latitude);
                        beside += usize::from(beyond);
                    }
                    let wide_m = (corners[1] - corners[0]).length();
                    if wide_m > 1e-3 * body.equatorial_radius_m() {
                        loose = loose.max(stated.lowest_m / lowest);
                    }
                }
            }
        }
        assert!(beside > 100, "{beside}");
        eprintln!("{loose:.2} times as deep as the deepest of 91 points at most");
        assert!(loose < 1.5, "{loose}");
    }

    #[test]
    fn an_extent_of_two_holds_both() {
        let extent = |west_deg, east_deg| Extent {
            west_deg,
            south_deg: 0.0,
            east_deg,
            north_deg: 1.0,
        };
        for (one, other, expected) in [
            ((0.0, 10.0), (5.0, 20.0), (0.0, 20.0)),
            ((170.0, 175.0), (-170.0, -160.0), (170.0, -160.0)),
            ((-170.0, -160.0), (170.0, 175.0), (170.0, -160.0)),
            ((170.0, -170.0), (-175.0, -150.0), (170.0, -150.0)),
            ((-180.0, 180.0), (3.0, 4.0), (-180.0, 180.0)),
            ((0.0, 10.0), (2.0, 3.0), (0.0, 10.0)),
        ] {
            let found = united(extent(one.0, one.1), extent(other.0, other.1));
            assert_eq!(
                (found.west_deg, found.east_deg),
                expected,
                "{one:?} {other:?}"
            );
        }
    }
}
