// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lagoons narrower than a pixel, at levels of detail that move their shores by half of one.

use crate::harness::{Desk, has_device};
use std::fmt::Write as _;
use terrafill_results::{Case, Outcome, Run};

/// Lagoons, and stretches of each shore.
const COUNT: u32 = 16;
const STRETCHES: u32 = 100;

/// From shore to shore, degrees; a pixel is some ten times as wide.
const WIDTH_DEG: f64 = 0.01;

/// More pixels outside the band around the reference's boundary pixels were once not asked about
/// (`terrafill_conformance::MAX_PROBED`).
const FORMERLY_WRONG: f64 = 64.0;

/// A shore that winds from 14 to 26 degrees north, in GeoJSON's order.
fn shore(lagoon: u32, east_deg: f64) -> Vec<String> {
    let place = |k: u32| {
        let latitude = 14.0 + 12.0 * f64::from(k) / f64::from(STRETCHES);
        let winding = 0.5 * (0.9 * latitude).sin() + 0.035 * (30.0 * latitude).sin();
        let own = 0.008 * (11.0 * latitude + east_deg).sin();
        let longitude = 1.2 * f64::from(lagoon) + winding + east_deg + own;
        format!("[{longitude:.5},{latitude:.5}]")
    };
    (0..=STRETCHES).map(place).collect()
}

fn scene() -> String {
    let polygon = |lagoon: u32| {
        let mut ring = shore(lagoon, WIDTH_DEG);
        ring.extend(shore(lagoon, 0.0).into_iter().rev());
        ring.push(ring[0].clone());
        format!("[[{}]]", ring.join(","))
    };
    let polygons: Vec<String> = (0..COUNT).map(polygon).collect();
    let mut text = String::new();
    write!(
        text,
        "name = \"lagoons\"\ndescription = \"for a test\"\nbody = \"wgs84\"\nedges = \"planar\"\n\
         [regions]\ninline = '''{{\"type\":\"Feature\",\"geometry\":{{\"type\":\"MultiPolygon\",\
         \"coordinates\":[{}]}}}}'''\n[surface]\nkind = \"ellipsoid\"\n\
         [mesh]\nboundary_tolerance_m = 10\n[levels]\ndeviation_m = [1000, 2000, 4000]\n\
         [[views]]\nname = \"above\"\nlongitude_deg = 10\nlatitude_deg = 20\n\
         height_m = 2_600_000\nheading_deg = 0\npitch_deg = -90\n",
        polygons.join(",")
    )
    .expect("written");
    text
}

#[test]
fn shores_less_than_a_pixel_apart_may_move_by_half_a_pixel() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    desk.write("lagoons.toml", scene());
    let options = ["--technique", "vertex", "--samples", "1", "--out", "run"];
    let line = ["bench", "lagoons.toml", "--quick", "--size", "256"];
    desk.run(&[&line[..], &options].concat()).succeeded();
    let run = Run::load(&desk.path("run")).expect("a run");
    let mismatched = |case: &Case| case.value("mismatched_px").unwrap_or(0.0);
    let with_levels = |case: &&Case| case.condition_named("boundary-lod-px") == "0.5";
    // A repeat is timed, and compared with nothing.
    let drawn = || {
        let timed = run.cases.iter().filter(|case| case.planned.samples > 0);
        timed.filter(|case| !case.is_repeat())
    };
    let leveled: Vec<&Case> = drawn().filter(with_levels).collect();
    assert!(!leveled.is_empty());
    for case in &leveled {
        let key = case.id().key();
        assert_eq!(case.outcome, Outcome::Ok, "{key}");
        assert_eq!(case.value("mismatched_px_outside_band"), Some(0.0), "{key}");
        // Negative control: levels moved the shores, in more pixels than were once asked about.
        assert!(
            mismatched(case) > FORMERLY_WRONG,
            "{key}: {}",
            mismatched(case)
        );
        let moved_px = case.value("boundary_moved_px");
        assert!(moved_px.is_some_and(|px| px > 0.25), "{key}: {moved_px:?}");
    }
    // Negative control: as it is written, the boundary moves by rounding alone.
    for case in drawn().filter(|case| !with_levels(case)) {
        assert!(mismatched(case) < 16.0, "{}", case.id().key());
    }
}
