// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sides of rings round a pole as the locator takes them, against `core`'s, which shares no code with
//! it, and against places of which there is no doubt.

#![allow(
    clippy::print_stdout,
    reason = "how much was compared is worth reading"
)]

use terrafill_core::{EdgeRule, Ellipsoid, Inside, Reading, Region, Unwrap, read_regions_as};
use terrafill_fixtures::Random;
use terrafill_fixtures::expectations::{
    BOTH_POLES, EASTERN_HALF, NOTCHED, SPIKED_CAP, circle_of_100_degrees,
};
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
    let read = read_regions_as(text.as_bytes(), "test", reading);
    read.expect("valid").regions.remove(0)
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
    let (planar, arcs) = (EdgeRule::Planar, EdgeRule::GreatEllipse);
    // Places inside and outside of the smaller side; whether it is on the left.
    let cases: [Case<'_>; 3] = [
        (
            &SPIKED_CAP,
            planar,
            [[0.0, 90.0], [0.0, -72.0], [170.0, 61.0]],
            [[0.0, -90.0], [0.0, -76.0], [90.0, 59.0]],
        ),
        (
            &NOTCHED,
            planar,
            [[0.0, 90.0], [60.0, -39.0], [-90.0, 11.0]],
            [[0.0, -90.0], [60.0, -41.0], [-90.0, 9.0]],
        ),
        (
            &BOTH_POLES,
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
    let western: Vec<Degrees> = EASTERN_HALF.iter().rev().copied().collect();
    for (ring, is_eastern) in [(&EASTERN_HALF[..], true), (&western, false)] {
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
            let read = read_regions_as(text.as_bytes(), "test", reading);
            let region = read.expect("valid").regions.remove(0);
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

/// At any latitudes.
fn round_the_axis(random: &mut Random) -> Vec<Degrees> {
    let mut longitude = -180.0;
    let first = [longitude, 120.0 * random.share() - 60.0];
    let mut ring = vec![first];
    while longitude < 100.0 {
        longitude += 1.0 + 78.0 * random.share();
        ring.push([longitude, 178.0 * random.share() - 89.0]);
    }
    ring.extend([[180.0, first[1]], first]);
    ring
}

/// Most of the way round the equator, from the south to the north and back, an arc every 20°.
fn band(random: &mut Random) -> Vec<Degrees> {
    let (west, latitude) = (360.0 * random.share() - 180.0, 50.0 + 35.0 * random.share());
    let count = 10 + i32::from(random.share() < 0.5) * 6;
    let at = |i: i32, latitude: f64| [west + 20.0 * f64::from(i), latitude];
    let there = (0..=count).map(|i| at(i, -latitude));
    let back = (0..=count).rev().map(|i| at(i, latitude));
    let mut ring: Vec<Degrees> = there.chain(back).collect();
    ring.push(ring[0]);
    ring
}

/// Anywhere, most of them wide, crossing themselves as they like.
fn anywhere(random: &mut Random) -> Vec<Degrees> {
    let count = 5 + 4 * u32::from(random.share() < 0.5);
    let mut ring: Vec<Degrees> = (0..count).map(|_| random.place()).collect();
    ring.push(ring[0]);
    ring
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
        let kind = random.share();
        let mut ring = if kind < 0.4 {
            round_the_axis(&mut random)
        } else if kind < 0.6 {
            band(&mut random)
        } else {
            anywhere(&mut random)
        };
        if random.share() < 0.5 {
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
