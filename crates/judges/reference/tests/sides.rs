// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sides of rings round a pole as the locator takes them, against `core`'s, which shares no code with
//! it, and against places of which there is no doubt.

#![allow(
    clippy::print_stdout,
    reason = "how much was compared is worth reading"
)]

use terrafill_core::{EdgeRule, Ellipsoid, Inside, Reading, Region, Unwrap, parse_regions_as};
use terrafill_fixtures::expectations::circle_of_100_degrees;
use terrafill_reference::Locator;

type Degrees = [f64; 2];

/// A ring, its rule, places inside of its smaller side and outside.
type Case<'a> = (&'a [Degrees], EdgeRule, [Degrees; 3], [Degrees; 3]);

fn region(rings: &[&[Degrees]], inside: Inside) -> Region {
    let text = format!(r#"{{"type":"Polygon","coordinates":{rings:?}}}"#);
    let reading = Reading {
        inside,
        ..Reading::default()
    };
    parse_regions_as(text.as_bytes(), "test", reading)
        .expect("valid")
        .remove(0)
}

fn locator(region: &Region, rule: EdgeRule, body: &Ellipsoid) -> Locator {
    Locator::new(std::slice::from_ref(region), rule, body).expect("clear rings")
}

fn holds(locator: &Locator, [longitude, latitude]: Degrees) -> bool {
    let found = locator.locate(longitude, latitude);
    assert!(found.disagree.is_empty(), "{longitude} {latitude}");
    !found.regions.is_empty()
}

#[test]
fn rings_of_doubtful_sides_hold_the_places_that_are_meant() {
    let spiked = [
        [-180.0, 60.0],
        [-1.0, 60.0],
        [-1.0, -70.0],
        [0.0, -75.0],
        [1.0, -70.0],
        [1.0, 60.0],
        [180.0, 60.0],
        [-180.0, 60.0],
    ];
    let notched = [
        [-180.0, 10.0],
        [-90.0, 10.0],
        [0.0, 10.0],
        [60.0, -40.0],
        [120.0, 10.0],
        [180.0, 10.0],
        [-180.0, 10.0],
    ];
    let both_poles = [
        [-5.0, 80.0],
        [-5.0, 0.0],
        [-5.0, -80.0],
        [-90.0, -85.0],
        [180.0, -80.0],
        [90.0, -85.0],
        [5.0, -80.0],
        [5.0, 0.0],
        [5.0, 80.0],
        [90.0, 85.0],
        [180.0, 80.0],
        [-90.0, 85.0],
        [-5.0, 80.0],
    ];
    let (planar, arcs) = (EdgeRule::Planar, EdgeRule::GreatEllipse);
    // Places inside and outside of the smaller side; whether it is on the left.
    let cases: [Case<'_>; 3] = [
        (
            &spiked,
            planar,
            [[0.0, 90.0], [0.0, -72.0], [170.0, 61.0]],
            [[0.0, -90.0], [0.0, -76.0], [90.0, 59.0]],
        ),
        (
            &notched,
            planar,
            [[0.0, 90.0], [60.0, -39.0], [-90.0, 11.0]],
            [[0.0, -90.0], [60.0, -41.0], [-90.0, 9.0]],
        ),
        (
            &both_poles,
            arcs,
            [[0.0, 90.0], [0.0, -90.0], [0.0, 0.0]],
            [[90.0, 0.0], [-90.0, 70.0], [180.0, -70.0]],
        ),
    ];
    let body = Ellipsoid::WGS84;
    for (ring, rule, inside, outside) in cases {
        let backwards: Vec<Degrees> = ring.iter().rev().copied().collect();
        for (written, is_left) in [(ring, true), (&backwards, false)] {
            for (choice, as_smaller) in [(Inside::Smaller, true), (Inside::Left, is_left)] {
                let locator = locator(&region(&[written], choice), rule, &body);
                for place in inside {
                    assert_eq!(holds(&locator, place), as_smaller, "{place:?}");
                }
                for place in outside {
                    assert_eq!(holds(&locator, place), !as_smaller, "{place:?}");
                }
            }
        }
    }
    // Exact halves by orientation.
    let eastern = [
        [0.0, -90.0],
        [180.0, -90.0],
        [180.0, 0.0],
        [180.0, 90.0],
        [0.0, 90.0],
        [0.0, 0.0],
        [0.0, -90.0],
    ];
    let western: Vec<Degrees> = eastern.iter().rev().copied().collect();
    for (ring, is_eastern) in [(&eastern[..], true), (&western, false)] {
        let locator = locator(&region(&[ring], Inside::Smaller), arcs, &body);
        assert_eq!(holds(&locator, [90.0, 10.0]), is_eastern);
        assert_eq!(holds(&locator, [-90.0, 10.0]), !is_eastern);
    }
}

#[test]
fn the_left_of_a_circle_beyond_a_hemisphere_is_all_but_what_lies_behind_it() {
    let circle = circle_of_100_degrees();
    let text = format!(r#"{{"type":"Polygon","coordinates":[{circle:?}]}}"#);
    let body = Ellipsoid::WGS84;
    for (rule, unwrap) in [
        (EdgeRule::Planar, Unwrap::Shortest),
        (EdgeRule::GreatEllipse, Unwrap::Literal),
    ] {
        for (inside, is_left) in [(Inside::Left, true), (Inside::Smaller, false)] {
            let reading = Reading { inside, unwrap };
            let region = parse_regions_as(text.as_bytes(), "test", reading)
                .expect("valid")
                .remove(0);
            let locator = locator(&region, rule, &body);
            for place in [
                [20.0, 0.0],
                [0.0, 90.0],
                [0.0, -90.0],
                [110.0, 0.0],
                [-79.0, 1.0],
            ] {
                assert_eq!(holds(&locator, place), is_left, "{rule:?} {place:?}");
            }
            for place in [[-160.0, 0.0], [-81.0, 1.0], [-160.0, 79.0], [180.0, -40.0]] {
                assert_eq!(holds(&locator, place), !is_left, "{rule:?} {place:?}");
            }
        }
    }
}

/// SplitMix64 (Steele, Lea and Flood, 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Round the axis, at any latitudes.
    fn round(&mut self) -> Vec<Degrees> {
        let mut longitude = -180.0;
        let first = [longitude, 120.0 * self.next() - 60.0];
        let mut ring = vec![first];
        while longitude < 100.0 {
            longitude += 1.0 + 78.0 * self.next();
            ring.push([longitude, 178.0 * self.next() - 89.0]);
        }
        ring.extend([[180.0, first[1]], first]);
        ring
    }

    /// Most of the way round the equator, from the south to the north and back, an arc every 20°.
    fn band(&mut self) -> Vec<Degrees> {
        let (west, latitude) = (360.0 * self.next() - 180.0, 50.0 + 35.0 * self.next());
        let count = 10 + i32::from(self.next() < 0.5) * 6;
        let at = |i: i32, latitude: f64| [west + 20.0 * f64::from(i), latitude];
        let there = (0..=count).map(|i| at(i, -latitude));
        let back = (0..=count).rev().map(|i| at(i, latitude));
        let mut ring: Vec<Degrees> = there.chain(back).collect();
        ring.push(ring[0]);
        ring
    }

    /// Anywhere, most of them wide, crossing themselves as they like.
    fn anywhere(&mut self) -> Vec<Degrees> {
        let count = 5 + 4 * u32::from(self.next() < 0.5);
        let mut ring: Vec<Degrees> = (0..count)
            .map(|_| {
                let longitude = 360.0 * self.next() - 180.0;
                [longitude, (2.0 * self.next() - 1.0).asin().to_degrees()]
            })
            .collect();
        ring.push(ring[0]);
        ring
    }
}

#[test]
fn the_locator_and_the_mesher_take_the_same_sides() {
    let mut random = Random(15);
    // By the poles held: neither, south, north, both; and warnings.
    let mut found = [0_u32; 4];
    let mut warned = 0;
    for round in 0..1_000 {
        let rule = [EdgeRule::Planar, EdgeRule::GreatEllipse][round % 2];
        let body = Ellipsoid::ALL[round % Ellipsoid::ALL.len()];
        let inside = [Inside::Smaller, Inside::Left][round / 2 % 2];
        let kind = random.next();
        let mut ring = if kind < 0.4 {
            random.round()
        } else if kind < 0.6 {
            random.band()
        } else {
            random.anywhere()
        };
        if random.next() < 0.5 {
            ring.reverse();
        }
        let region = region(&[&ring], inside);
        let side = region.polygons[0].sides(rule, &body, inside)[0];
        let locator = locator(&region, rule, &body);
        let poles = [-90.0, 90.0].map(|latitude| holds(&locator, [61.0, latitude]));
        assert_eq!(
            poles,
            side.holds_poles,
            "{rule:?} {inside:?} {} {ring:?}",
            body.name()
        );
        found[usize::from(poles[0]) + 2 * usize::from(poles[1])] += 1;
        warned += u32::from(side.choice.is_some());
        if let Some(choice) = side.choice {
            let takes_smaller = choice.taken_m2 < choice.other_m2;
            // A part of the plane may be more than half of the body.
            if choice.is_round {
                assert_eq!(takes_smaller, inside == Inside::Smaller);
            }
        }
    }
    println!("{found:?} by poles, {warned} with two readings");
    assert!(found.iter().all(|count| *count > 10), "{found:?}");
    assert!(warned > 200, "{warned}");
}
