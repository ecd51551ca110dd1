// SPDX-License-Identifier: MIT OR Apache-2.0
//! The locator against two inside tests of its own kind each, on random points over real countries.
//!
//! Degrees, planar edges. The locator counts edges to the north (exact) and winds along a parallel.
//! Here instead:
//!
//! - *Quadrants*: a ring seen from the point passes from quadrant to quadrant; the sum of those
//!   steps over four is its winding number (Weiler, 1994, "An Incremental Angle Point in Polygon
//!   Test", Graphics Gems IV);
//! - *Triangles*: the signed triangles between the ring's first vertex and its edges, summed where
//!   they hold the point (Feito, Torres and Ureña, 1995, "Orientation, simplicity, and inclusion
//!   test for planar polygons").
//!
//! Both in plain f64 over every edge of every ring whose box holds the point. All three must name
//! the same regions, except within a millimetre of a border.

#![allow(
    clippy::print_stdout,
    reason = "a skipped test says why, and the counts are the result"
)]

use rayon::prelude::*;
use terrafill_core::{EdgeRule, Ellipsoid, Polygon, Region, Ring, parse_regions};
use terrafill_fixtures::{Random, data, region};
use terrafill_reference::Locator;

/// Within this, borders are a matter of rounding, metres.
const BORDER_M: f64 = 1e-3;

/// Spread over the Earth; a fiftieth as many more lie beside borders.
const POINTS: usize = 1_000_000;

const COUNTRIES: &str = "ne_50m_admin_0_countries.geojson";

type Degrees = [f64; 2];

fn countries() -> Vec<Region> {
    let bytes = data::bytes(&format!("vectors/{COUNTRIES}"));
    parse_regions(&bytes, COUNTRIES).expect("valid")
}

struct Outline<'a> {
    region: usize,
    vertices: &'a [Degrees],
    low: Degrees,
    high: Degrees,
}

impl<'a> Outline<'a> {
    fn all(regions: &'a [Region]) -> Vec<Self> {
        let rings = regions.iter().enumerate().flat_map(|(region, it)| {
            let rings = it.polygons.iter().flat_map(Polygon::rings);
            rings.map(move |ring| (region, ring))
        });
        rings
            .map(|(region, ring): (usize, &Ring)| {
                assert!(
                    ring.winding_deg() == 0.0,
                    "the tests below know no rings round the axis"
                );
                let vertices = ring.vertices_deg();
                let extreme = |pick: fn(f64, f64) -> f64| {
                    [0, 1].map(|i| {
                        vertices
                            .iter()
                            .map(|v| v[i])
                            .reduce(pick)
                            .expect("vertices")
                    })
                };
                Self {
                    region,
                    vertices,
                    low: extreme(f64::min),
                    high: extreme(f64::max),
                }
            })
            .collect()
    }

    fn edges(&self) -> impl Iterator<Item = [Degrees; 2]> + '_ {
        let ends = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(ends).map(|(a, b)| [*a, *b])
    }

    fn may_hold(&self, point: Degrees) -> bool {
        (0..2).all(|i| self.low[i] <= point[i] && point[i] <= self.high[i])
    }

    /// By quadrants.
    fn winds_round(&self, point: Degrees) -> bool {
        let quadrant = |[x, y]: Degrees| match (x >= point[0], y >= point[1]) {
            (true, true) => 0,
            (false, true) => 1,
            (false, false) => 2,
            (true, false) => 3,
        };
        let mut quarters = 0;
        for [a, b] in self.edges() {
            quarters += match (quadrant(b) - quadrant(a) + 4) % 4 {
                0 => 0,
                1 => 1,
                3 => -1,
                // To the opposite quadrant: past the point on one side or the other.
                _ if orientation(a, b, point) > 0.0 => 2,
                _ => -2,
            };
        }
        quarters % 8 != 0
    }

    /// By triangles.
    fn covers(&self, point: Degrees) -> bool {
        let apex = self.vertices[0];
        let mut twice = 0;
        for [a, b] in self.edges() {
            let turn = sign(orientation(apex, a, b));
            if turn == 0 {
                continue;
            }
            // A side from the apex belongs to two triangles, half to each; the ring's own edge
            // to one.
            let first = sign(orientation(apex, a, point)) * turn;
            let last = sign(orientation(b, apex, point)) * turn;
            let outer = sign(orientation(a, b, point)) * turn;
            if first >= 0 && last >= 0 && outer >= 0 {
                twice += turn * if first == 0 || last == 0 { 1 } else { 2 };
            }
        }
        twice % 4 != 0
    }
}

/// Twice the signed area of a triangle, positive counter-clockwise.
fn orientation(a: Degrees, b: Degrees, c: Degrees) -> f64 {
    (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0])
}

fn sign(value: f64) -> i32 {
    i32::from(value > 0.0) - i32::from(value < 0.0)
}

/// Regions with an odd number of rings that hold the point, ascending.
fn regions_that_hold(
    outlines: &[&Outline<'_>],
    holds: impl Fn(&Outline<'_>) -> bool,
) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    for outline in outlines {
        if holds(outline) {
            // Rings of one region are neighbours in the list.
            if found.last() == Some(&outline.region) {
                found.pop();
            } else {
                found.push(outline.region);
            }
        }
    }
    found
}

/// Distance to the nearest edge of any ring, in the plane that touches the Earth at the point,
/// metres: right near the point, and that is where it matters.
fn distance_to_border_m(outlines: &[Outline<'_>], point: Degrees) -> f64 {
    let body = Ellipsoid::WGS84;
    let (sin, cos) = point[1].to_radians().sin_cos();
    let w = 1.0 - body.eccentricity_squared() * sin * sin;
    let normal_m = body.equatorial_radius_m() / w.sqrt();
    let meridian_m = normal_m * (1.0 - body.eccentricity_squared()) / w;
    let local = |v: Degrees| {
        [
            (v[0] - point[0]).to_radians() * normal_m * cos,
            (v[1] - point[1]).to_radians() * meridian_m,
        ]
    };
    let mut nearest = f64::INFINITY;
    for [a, b] in outlines.iter().flat_map(Outline::edges) {
        let ([ax, ay], [bx, by]) = (local(a), local(b));
        let (dx, dy) = (bx - ax, by - ay);
        let squared = dx * dx + dy * dy;
        let along = if squared > 0.0 {
            (-(ax * dx + ay * dy) / squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        nearest = nearest.min((ax + along * dx).hypot(ay + along * dy));
    }
    nearest
}

/// What comparing the three tests on some points found.
#[derive(Debug, Default)]
struct Comparison {
    points: usize,
    in_a_region: usize,
    /// The three do not name the same regions, within a millimetre of a border.
    at_a_border: usize,
    /// The locator's own two tests differ, within a millimetre of a border.
    doubted: usize,
    /// Either of those, farther away.
    wrong: Vec<Degrees>,
}

impl Comparison {
    fn join(mut self, other: Self) -> Self {
        self.points += other.points;
        self.in_a_region += other.in_a_region;
        self.at_a_border += other.at_a_border;
        self.doubted += other.doubted;
        self.wrong.extend(other.wrong);
        self
    }
}

fn compare(locator: &Locator, outlines: &[Outline<'_>], point: Degrees) -> Comparison {
    let near: Vec<&Outline<'_>> = outlines
        .iter()
        .filter(|outline| outline.may_hold(point))
        .collect();
    let found = locator.locate(point[0], point[1]);
    let quadrants = regions_that_hold(&near, |outline| outline.winds_round(point));
    let triangles = regions_that_hold(&near, |outline| outline.covers(point));
    let mut result = Comparison {
        points: 1,
        in_a_region: usize::from(!found.regions.is_empty()),
        ..Comparison::default()
    };
    let differ = found.regions != quadrants || found.regions != triangles;
    if differ || !found.disagree.is_empty() {
        if distance_to_border_m(outlines, point) > BORDER_M {
            result.wrong.push(point);
        } else {
            result.at_a_border += usize::from(differ);
            result.doubted += usize::from(!found.disagree.is_empty());
        }
    }
    result
}

fn compare_all(
    locator: &Locator,
    outlines: &[Outline<'_>],
    count: usize,
    choose: impl Fn(&mut Random) -> Degrees + Sync,
) -> Comparison {
    // A seed for each point, so that order does not matter.
    (0..count)
        .into_par_iter()
        .map(|seed| compare(locator, outlines, choose(&mut Random(seed as u64))))
        .reduce(Comparison::default, Comparison::join)
}

/// Beside some edge, at a distance from nothing that a double can hold to a hundred metres.
fn beside_a_border(outlines: &[Outline<'_>], random: &mut Random) -> Degrees {
    let outline = &outlines[random.below(outlines.len())];
    let first = random.below(outline.vertices.len());
    let a = outline.vertices[first];
    let b = outline.vertices[(first + 1) % outline.vertices.len()];
    let along = random.share();
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx.hypot(dy);
    let side = if random.share() < 0.5 { 1.0 } else { -1.0 };
    let away = side * 10_f64.powf(-17.0 + 14.0 * random.share()) / length;
    // The tests here know no turns: a place past the antimeridian is written from its own side.
    let longitude = a[0] + along * dx - away * dy;
    let turns = if longitude.abs() > 180.0 {
        (longitude / 360.0).round()
    } else {
        0.0
    };
    [
        longitude - 360.0 * turns,
        (a[1] + along * dy + away * dx).clamp(-90.0, 90.0),
    ]
}

#[test]
#[ignore = "needs data: natural-earth-50m"]
fn the_locator_names_the_regions_that_two_other_tests_name() {
    let regions = countries();
    let locator = Locator::new(&regions, EdgeRule::Planar, &Ellipsoid::WGS84).expect("clear rings");
    let outlines = Outline::all(&regions);
    let scattered = compare_all(&locator, &outlines, POINTS, Random::place);
    let beside = compare_all(&locator, &outlines, POINTS / 50, |random| {
        beside_a_border(&outlines, random)
    });
    for (name, result) in [
        ("random points", &scattered),
        ("points beside borders", &beside),
    ] {
        println!(
            "{name}: {} of them, {} in a region; within 1 mm of a border {} named differently and \
             {} doubted by the locator itself; farther away {}",
            result.points,
            result.in_a_region,
            result.at_a_border,
            result.doubted,
            result.wrong.len()
        );
        assert!(result.wrong.is_empty(), "{name}: {:?}", result.wrong);
        // Land is 29 % of the Earth; 241 countries without Antarctica's ice shelves about that.
        let share = result.in_a_region as f64 / result.points as f64;
        assert!((0.25..0.75).contains(&share), "{name}: {share}");
    }
    let land = scattered.in_a_region as f64 / scattered.points as f64;
    assert!((land - 0.29).abs() < 0.02, "{land} of the Earth is land");
}

#[test]
#[ignore = "needs data: natural-earth-50m"]
fn a_vertex_moved_by_a_metre_is_noticed() {
    let regions = countries();
    let outlines = Outline::all(&regions);
    // The largest ring of Brazil, moved by 1e-5° at one vertex, for the locator only.
    let brazil = regions
        .iter()
        .position(|region| region.name == "Brazil")
        .expect("Brazil");
    let outline = outlines
        .iter()
        .filter(|outline| outline.region == brazil)
        .max_by_key(|outline| outline.vertices.len())
        .expect("a ring");
    let moved = outline.vertices.len() / 2;
    let place = outline.vertices[moved];
    let mut ring = outline.vertices.to_vec();
    ring[moved][0] += 1e-5;
    let mutant = [region(&format!("[{ring:?}]"))];
    let locator = Locator::new(&mutant, EdgeRule::Planar, &Ellipsoid::WGS84).expect("a clear ring");
    let alone = [Outline {
        region: 0,
        ..*outline
    }];
    let near = |random: &mut Random| place.map(|value| value + 2e-5 * (random.share() - 0.5));
    let noticed = compare_all(&locator, &alone, 2_000, near).wrong.len();
    assert!(noticed > 20, "{noticed}");
    // And the same points on the ring as it is.
    let unmoved = std::slice::from_ref(&regions[brazil]);
    let locator = Locator::new(unmoved, EdgeRule::Planar, &Ellipsoid::WGS84).expect("a clear ring");
    assert_eq!(
        compare_all(&locator, &alone, 2_000, near).wrong,
        Vec::<Degrees>::new()
    );
}

#[test]
fn both_tests_know_a_square_with_a_notch() {
    let regions = [region("[[[0,0],[4,0],[4,4],[2,1],[0,4]]]")];
    let outline = &Outline::all(&regions)[0];
    for (point, inside) in [
        ([2.0, 0.5], true),
        ([0.5, 3.0], true),
        ([3.5, 3.0], true),
        ([2.0, 2.0], false),
        ([5.0, 1.0], false),
        ([-1.0, -1.0], false),
    ] {
        assert_eq!(outline.winds_round(point), inside, "{point:?}");
        assert_eq!(outline.covers(point), inside, "{point:?}");
    }
    let border = distance_to_border_m(&Outline::all(&regions), [2.0, 0.5]);
    // Half a degree of latitude near the equator: 110.57 km per degree.
    assert!((border / 55_287.0 - 1.0).abs() < 1e-3, "{border}");
}
