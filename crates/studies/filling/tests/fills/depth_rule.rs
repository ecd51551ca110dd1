// SPDX-License-Identifier: MIT OR Apache-2.0
//! The automatic depth rule: in front of the surface wherever that is right, behind it wherever it
//! would not be; and `uncut`, which counts in front from within, too. Eyes inside volumes, on walls, with the near plane cutting walls and caps, and at
//! random around both.

use crate::drawing;

use drawing::{
    AllTargets, Devices, Pose, Technique, collection, differing, draw_with, figures, judge, look,
    polygon, scene_within, square, vertex,
};
use terrafill_conformance::verdict;
use terrafill_contract::{FillBackend, FillInput, Frame, PreparedScene};
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_plan::NearRectangle;
use terrafill_scene::{ImageSize, Overlap};
use terrafill_variant::{BottomCap, ColourWay, DepthRuleChoice, Switches};

const SMALL: ImageSize = square(128);

/// An L 22 km long and a square in its missing quarter that touches it: every box holds ground
/// that its region does not.
fn two_regions() -> PreparedScene {
    let text = collection(&[
        polygon(
            "l",
            "[[10,45],[10.2,45],[10.2,45.1],[10.1,45.1],[10.1,45.2],[10,45.2],[10,45]]",
        ),
        polygon(
            "square",
            "[[10.1,45.1],[10.15,45.1],[10.15,45.15],[10.1,45.15],[10.1,45.1]]",
        ),
    ]);
    // A centimetre is a pixel from 10 m above.
    scene_within(0.01, &text, Ellipsoid::WGS84, 90, Overlap::Disjoint)
}

fn with_rule(depth_rule: DepthRuleChoice) -> Technique {
    vertex(Switches {
        depth_rule,
        colour: match depth_rule {
            DepthRuleChoice::Uncut => ColourWay::Xor,
            _ => ColourWay::Rectangle,
        },
        bottom_cap: BottomCap::WhereNeeded,
        // Volumes around the eye may not be cut, those beside them may.
        scissor: depth_rule == DepthRuleChoice::Uncut,
        ..Switches::default()
    })
}

/// Backends of one set of targets, one for each rule.
struct Rules {
    backends: [Box<dyn FillBackend>; 4],
}

impl Rules {
    fn new(devices: &Devices) -> Self {
        let targets = AllTargets::new(devices, SMALL);
        let rules = [
            DepthRuleChoice::Automatic,
            DepthRuleChoice::Fail,
            DepthRuleChoice::Pass,
            DepthRuleChoice::Uncut,
        ];
        Self {
            backends: rules.map(|rule| targets.open(with_rule(rule))),
        }
    }

    /// Frames by the automatic rule, behind the surface, in front of it, and in front where no face is cut.
    fn draw(&mut self, input: &FillInput) -> [Frame; 4] {
        let backends = self.backends.iter_mut();
        let frames: Vec<Frame> = backends
            .map(|backend| draw_with(&mut **backend, input))
            .collect();
        frames.try_into().expect("four rules")
    }
}

/// What eyes and rules have shown so far.
#[derive(Default, Debug)]
struct Tally {
    eyes: usize,
    /// Regions drawn.
    regions: usize,
    /// Of them, counted in front of the surface by the automatic rule.
    in_front: usize,
    /// Of them, counted so from within.
    from_within: usize,
    /// Eyes from which counting in front everywhere is wrong.
    forced_wrong: usize,
}

impl Tally {
    fn look(&mut self, rules: &mut Rules, input: &FillInput, what: &str) {
        let reference = judge(input);
        let [automatic, behind, in_front, uncut] = rules.draw(input);
        assert_eq!(differing(&automatic, &behind), 0, "{what}");
        assert_eq!(differing(&uncut, &behind), 0, "{what}");
        let found = figures(&reference, &automatic);
        let verdict = verdict(&found);
        assert!(verdict.is_pass(), "{what}: {verdict:?} {found:?}");
        self.eyes += 1;
        for planned in &input.plan.regions {
            self.regions += 1;
            self.in_front += usize::from(planned.near_rectangle == NearRectangle::Outside);
            self.from_within += usize::from(planned.near_rectangle == NearRectangle::Within);
        }
        let is_wrong = differing(&in_front, &behind) > 0;
        self.forced_wrong += usize::from(is_wrong);
        // Where no volume meets the near plane, the rules may not differ at all.
        let is_free = input
            .plan
            .regions
            .iter()
            .all(|region| region.near_rectangle == NearRectangle::Outside);
        assert!(!(is_free && is_wrong), "{what}");
    }
}

/// Metres east, north and up of a place on the ground, as longitude, latitude and height.
fn moved(longitude: f64, latitude: f64, [east_m, north_m, up_m]: [f64; 3]) -> [f64; 3] {
    let body = Ellipsoid::WGS84;
    let start = Geodetic::from_degrees(longitude, latitude, 0.0);
    let up = body.geodetic_surface_normal(start.longitude_rad, start.latitude_rad);
    let mut east = up;
    (east.x, east.y, east.z) = (-start.longitude_rad.sin(), start.longitude_rad.cos(), 0.0);
    let at = body.geodetic_to_ecef(start) + east * east_m + up.cross(east) * north_m;
    let found = body.ecef_to_geodetic(at);
    [
        found.longitude_rad.to_degrees(),
        found.latitude_rad.to_degrees(),
        up_m,
    ]
}

fn eye([longitude, latitude, height_m]: [f64; 3], heading: f64, pitch: f64) -> Pose {
    (longitude, latitude, height_m, heading, pitch)
}

#[test]
fn on_a_wall_and_a_breath_to_either_side() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let scene = two_regions();
    let mut rules = Rules::new(&devices);
    let mut tally = Tally::default();
    let height_m = scene.bounds[0].heights.top_m * 0.5;
    // The western wall of the L, its inner corner, and the border of both.
    for (longitude, latitude) in [(10.0, 45.05), (10.1, 45.1), (10.1, 45.12)] {
        for offset_m in [0.0, 1e-9, 1e-6, 1e-3, 0.1, 1.0] {
            for side in [-1.0, 1.0] {
                for heading in [80.0, 225.0] {
                    let at = moved(longitude, latitude, [side * offset_m, 0.0, height_m]);
                    let input = look(&scene, eye(at, heading, -20.0), 0.2, SMALL);
                    let what = format!("{longitude} {latitude}: {offset_m} m {side} {heading}");
                    tally.look(&mut rules, &input, &what);
                }
            }
        }
    }
    assert_eq!(tally.eyes, 3 * 6 * 2 * 2);
    assert!(tally.forced_wrong > tally.eyes / 4, "{tally:?}");
}

#[test]
fn inside_and_with_the_near_plane_cutting_walls_and_caps() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let scene = two_regions();
    let mut rules = Rules::new(&devices);
    let mut tally = Tally::default();
    let top_m = scene.bounds[0].heights.top_m;
    let (inside_m, above_m) = (top_m * 0.5, top_m + 60.0);
    let [outside, within, cut] = [
        NearRectangle::Outside,
        NearRectangle::Within,
        NearRectangle::Cut,
    ];
    for (what, east_m, up_m, near_m, expected) in [
        ("inside", 500.0, inside_m, 0.2, within),
        ("outside", -500.0, inside_m, 0.2, outside),
        ("a wall cuts the near plane", -20.0, inside_m, 40.0, cut),
        (
            "the same wall, a nearer plane",
            -20.0,
            inside_m,
            0.2,
            outside,
        ),
        ("just above the top", 500.0, above_m, 0.2, outside),
        ("the top cuts the near plane", 500.0, above_m, 100.0, cut),
        (
            "the top before the near plane",
            500.0,
            above_m,
            150.0,
            within,
        ),
        ("far above", 500.0, top_m + 5e4, 50.0, outside),
    ] {
        let at = moved(10.0, 45.05, [east_m, 0.0, up_m]);
        let input = look(&scene, eye(at, 80.0, -35.0), near_m, SMALL);
        let found = input.plan.regions.iter();
        let found = found.map(|region| region.near_rectangle);
        let found = found.reduce(|nearest, other| match nearest {
            NearRectangle::Outside => other,
            nearest => nearest,
        });
        assert_eq!(found.unwrap_or_default(), expected, "{what}");
        tally.look(&mut rules, &input, what);
    }
    assert!(tally.forced_wrong >= 2, "{tally:?}");
}

#[test]
fn two_hundred_eyes_within_fifty_metres_of_walls_and_caps() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let scene = two_regions();
    let heights = scene.bounds[0].heights;
    let mut rules = Rules::new(&devices);
    let mut tally = Tally::default();
    let mut state = 20_071_029_u64;
    let mut between = |low: f64, high: f64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        low + (high - low) * ((state >> 11) as f64 / (1_u64 << 53) as f64)
    };
    // Ends of the walls; the inner corner belongs to both regions.
    let walls = [
        [[10.0, 45.0], [10.2, 45.0]],
        [[10.2, 45.0], [10.2, 45.1]],
        [[10.1, 45.1], [10.1, 45.2]],
        [[10.0, 45.2], [10.0, 45.0]],
        [[10.1, 45.15], [10.15, 45.15]],
        [[10.15, 45.1], [10.15, 45.15]],
    ];
    for index in 0..220_usize {
        let [start, end] = walls[index % walls.len()];
        let along = between(0.0, 1.0);
        let longitude = start[0] + (end[0] - start[0]) * along;
        let latitude = start[1] + (end[1] - start[1]) * along;
        let offset = [between(-50.0, 50.0), between(-50.0, 50.0)];
        // Every third eye is near the top, the others between it and the ellipsoid.
        let up_m = if index % 3 == 0 {
            heights.top_m + between(-50.0, 50.0)
        } else {
            between(0.0, heights.top_m)
        };
        let at = moved(longitude, latitude, [offset[0], offset[1], up_m]);
        let near_m = [0.1, 1.0, 10.0, 40.0][index % 4];
        let pose = eye(at, between(0.0, 360.0), between(-60.0, 5.0));
        let input = look(&scene, pose, near_m, SMALL);
        tally.look(
            &mut rules,
            &input,
            &format!("eye {index}: {pose:?}, near {near_m}"),
        );
    }
    eprintln!("{tally:?}");
    assert!(tally.eyes >= 200);
    // No blanket rule: a good part is counted in front of the surface.
    assert!(10 * tally.in_front > 3 * tally.regions, "{tally:?}");
    assert!(10 * tally.from_within > tally.regions, "{tally:?}");
    // Negative control: forced in front, many eyes see wrong pixels.
    assert!(tally.forced_wrong > 20, "{tally:?}");
}
