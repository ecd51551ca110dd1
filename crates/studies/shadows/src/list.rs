// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which cases there are.

mod planned;

use self::planned::planned;
use crate::brought::Brought;
use crate::count::Rule;
use crate::device::Interface;
use crate::job::{Job, Method};
use crate::ladder::rungs;
use crate::maps::Bias;
use crate::near::EyeTest;
use crate::outline::Way;
use crate::rivals::Rival;
use crate::source::Adjacency;
use crate::views::{Chooser, Eyes, Place};
use crate::way::Silhouettes;
use crate::way::{Bounds, Counting, Cut, DeviceWay, Positions};
use crate::work::{End, NEARS, Scissor};
use terrafill_casters::Policy;
use terrafill_fill::FacePasses;
use terrafill_results::PlannedCase;
use terrafill_study::Depth;

/// Suns over the deck: elevation and azimuth from the dock, degrees.
const DECK_SUNS: [[f64; 2]; 2] = [[30.0, -60.0], [5.0, 0.0]];
/// Suns over the bridge, from the zenith to one at which the shadows of the highest tops land nowhere on the sphere;
/// a quick run has the first four.
const SUNS: [[f64; 2]; 9] = [
    [60.0, 90.0],
    [10.0, -60.0],
    [5.0, 0.0],
    [1.0, 0.0],
    [30.0, -60.0],
    [2.0, 0.0],
    [0.3, -60.0],
    [90.0, 0.0],
    [0.2, -60.0],
];
const QUICK_SUNS: usize = 4;
/// Suns of devices; a quick run has the first.
const DEVICE_SUNS: [[f64; 2]; 4] = [[10.0, -60.0], [5.0, 0.0], [60.0, 90.0], [1.0, 0.0]];
const QUICK_DEVICE_SUNS: usize = 1;
/// Sun of facings.
const FACING_SUN: [f64; 2] = [30.0, -60.0];
/// Distances of an origin from the port, m: the last is that of the earth's centre.
const ORIGINS_M: [f64; 3] = [1e5, 1e6, 6.371e6];
/// Suns of maps and their texels, m; a quick run has the first sun and the first two texels.
const MAP_SUNS: [[f64; 2]; 5] = [
    [10.0, -60.0],
    [30.0, -60.0],
    [5.0, -60.0],
    [2.0, -60.0],
    [1.0, -60.0],
];
const TEXELS_M: [f64; 4] = [1.0, 0.25, 0.1, 0.05];
/// Sun of scissors and finite volumes.
const LOW_SUN: [f64; 2] = [10.0, -60.0];
/// Sun of rails seen from near, low enough to show a step of f32.
const RAIL_SUN: [f64; 2] = [3.0, -60.0];
/// Lengths of finite volumes, m.
const LENGTHS: [f64; 7] = [6.0, 12.0, 25.0, 50.0, 100.0, 200.0, 400.0];
/// Casters of rows; 255 is the most that 8 bits count.
const ROWS: [u32; 5] = [255, 256, 257, 511, 512];
/// Models with outlines.
const MODELS: [u32; 4] = [254, 255, 1_000, 5_000];
/// Meshes for silhouettes: ports, and smooth hulls of so many triangles; quick runs have the first five.
const MESHES: [&str; 8] = [
    "port-s",
    "hull-1000",
    "hull-5000",
    "port-s, one face turned",
    "port-m",
    "hull-20000",
    "port-l",
    "port-l3",
];
const QUICK_MESHES: usize = 5;
/// Stands for a user's mesh where meshes are named.
pub(crate) const BROUGHT: &str = "";
/// Timed silhouettes, and frames of a device, a process.
const SAMPLES: u32 = 3;

/// Questions that a user's model is asked, in order.
const OF_ANY_MODEL: [&str; 10] = [
    "model",
    "updates",
    "scissors",
    "bounds",
    "silhouettes",
    "devices",
    "ladder",
    "rivals",
    "maps",
    "device-maps",
];

/// Volumes from the CPU, closed at the sea, z-fail, two-sided, whole.
fn device_way(interface: Interface) -> DeviceWay {
    DeviceWay {
        interface,
        silhouettes: Silhouettes::Adjacency,
        positions: Positions::Eye,
        end: End::Sea,
        rule: Rule::Fail,
        faces: FacePasses::TwoSided,
        cut: Cut::Off,
        counting: Counting::Casters,
        bounds: Bounds::Off,
    }
}

/// How devices draw: what differs from one to the next is one thing.
fn device_ways(interface: Interface) -> Vec<DeviceWay> {
    let way = device_way(interface);
    let (end, rule, faces) = (End::Infinite, Rule::Pass, FacePasses::TwoPass);
    let bounded = |bounds| DeviceWay { bounds, ..way };
    // No more than some fifty volumes of this port lie over a pixel.
    let by_part = |bounds| DeviceWay {
        counting: Counting::Parts { is_guarded: false },
        ..bounded(bounds)
    };
    let mut ways = vec![
        DeviceWay { end, ..way },
        DeviceWay { end, rule, ..way },
        way,
        DeviceWay { rule, ..way },
        DeviceWay { faces, ..way },
        DeviceWay {
            cut: Cut::Rectangle,
            ..way
        },
        bounded(Bounds::Native),
        by_part(Bounds::Native),
        bounded(Bounds::Tiles),
        by_part(Bounds::Tiles),
        DeviceWay {
            rule: Rule::Preload,
            ..way
        },
    ];
    let found = |silhouettes, end| DeviceWay {
        end,
        silhouettes,
        ..way
    };
    match interface {
        Interface::Wgpu => ways.extend([
            bounded(Bounds::Discard),
            by_part(Bounds::Discard),
            found(Silhouettes::Pulled, end),
            found(Silhouettes::Computed, end),
            found(Silhouettes::Computed, End::Sea),
        ]),
        Interface::Vulkan => ways.extend([
            found(Silhouettes::Geometry(Adjacency::Triangles), end),
            found(Silhouettes::Geometry(Adjacency::Lines), end),
        ]),
    }
    ways
}

/// Whose near plane is partly in shadow: by rule, and by who chooses it.
fn near_ways(interface: Interface) -> Vec<DeviceWay> {
    let way = device_way(interface);
    let rule = |rule| DeviceWay { rule, ..way };
    let counting = |counting| DeviceWay { counting, ..way };
    vec![
        rule(Rule::Pass),
        counting(Counting::Chosen(EyeTest::Eye)),
        counting(Counting::Chosen(EyeTest::PartBox)),
        counting(Counting::Chosen(EyeTest::Exact)),
        counting(Counting::ZpPlus),
        rule(Rule::Preload),
        way,
    ]
}

/// Plates in a row, each of which is a volume.
fn row_ways(interface: Interface) -> impl Iterator<Item = DeviceWay> {
    [false, true].into_iter().map(move |is_guarded| DeviceWay {
        end: End::Infinite,
        rule: Rule::Pass,
        counting: Counting::Parts { is_guarded },
        ..device_way(interface)
    })
}

/// Infinite volumes by z-fail, by who decides which triangles face the sun.
fn facing_ways(interface: Interface) -> Vec<DeviceWay> {
    let all = match interface {
        Interface::Wgpu => vec![
            Silhouettes::Adjacency,
            Silhouettes::Pulled,
            Silhouettes::Computed,
            Silhouettes::Corners,
        ],
        Interface::Vulkan => vec![
            Silhouettes::Geometry(Adjacency::Triangles),
            Silhouettes::Geometry(Adjacency::Lines),
            Silhouettes::Geometry(Adjacency::Corners),
        ],
    };
    let of = |silhouettes| DeviceWay {
        end: End::Infinite,
        silhouettes,
        ..device_way(interface)
    };
    all.into_iter().map(of).collect()
}

/// The same from numbers that count from elsewhere.
fn origin_ways(interface: Interface) -> impl Iterator<Item = DeviceWay> {
    let way = device_way(interface);
    let worlds = ORIGINS_M.map(Positions::World).into_iter();
    let all = std::iter::once(Positions::Eye).chain(worlds);
    all.map(move |positions| DeviceWay { positions, ..way })
}

/// A question's cases.
pub(crate) type Questions = (&'static str, Vec<(Job, PlannedCase)>);

/// All of a depth, by question.
///
/// - `brought`: a user's model, of which the questions are asked that any model answers
pub(crate) fn questions(
    depth: Depth,
    samples: Option<u32>,
    brought: Option<&Brought>,
) -> Vec<Questions> {
    let is_quick = depth == Depth::Quick;
    let suns = &SUNS[..if is_quick { QUICK_SUNS } else { SUNS.len() }];
    let meshes = match brought {
        Some(_) => &[BROUGHT][..],
        None if is_quick => &MESHES[..QUICK_MESHES],
        None => &MESHES[..],
    };
    let eyes = DECK_SUNS.into_iter().flat_map(|sun| {
        let of = move |near| EyeTest::ALL.map(|test| Job::Eye(sun, near, test));
        NEARS.into_iter().flat_map(of)
    });
    let updates = suns.iter().flat_map(|sun| {
        let all = |end| Rule::ALL.map(|rule| Job::Updates(*sun, end, rule));
        let fail = |end| [Job::Updates(*sun, end, Rule::Fail)];
        // By what the casters are cut to: each scene is made once.
        let whole = all(End::Infinite).into_iter().chain(fail(End::SeaOfWhole));
        whole.chain(all(End::Sea)).chain(fail(End::Calm))
    });
    let bounds = suns.iter().flat_map(|sun| {
        let rules = [Rule::Pass, Rule::Fail];
        rules.map(|rule| Job::Bounds(*sun, rule))
    });
    let views = Place::ALL.into_iter().flat_map(|place| {
        let of = move |chooser| Job::View(LOW_SUN, place, chooser);
        Chooser::ALL.into_iter().map(of)
    });
    let rows = ROWS
        .into_iter()
        .flat_map(|count| [false, true].map(|guard| Job::Row(count, guard)));
    let outlines = MODELS
        .into_iter()
        .flat_map(|count| Way::ALL.map(|way| Job::Outline(count, way)));
    let silhouettes = meshes
        .iter()
        .flat_map(|mesh| Method::ALL.map(|method| Job::Silhouette(mesh, method)));
    let device_suns = match is_quick {
        true => &DEVICE_SUNS[..QUICK_DEVICE_SUNS],
        false => &DEVICE_SUNS[..],
    };
    let devices = device_suns.iter().flat_map(|sun| {
        let ways = Interface::ALL.into_iter().flat_map(device_ways);
        ways.map(move |way| Job::Device(*sun, way))
    });
    let rivals = device_suns.iter().flat_map(|sun| {
        let of = move |rival| Job::Rival(*sun, rival);
        Rival::ALL.into_iter().map(of)
    });
    let ladder = device_suns.iter().flat_map(|sun| {
        let all = Interface::ALL.into_iter().flat_map(rungs);
        all.map(move |rung| Job::Rung(*sun, rung))
    });
    let origins = Interface::ALL.into_iter().flat_map(origin_ways);
    let origins = origins.flat_map(|way| {
        [
            Job::Origin(LOW_SUN, Eyes::Bridge, way),
            Job::Origin(RAIL_SUN, Eyes::At(Place::QuayEdge), way),
            Job::Origin(LOW_SUN, Eyes::At(Place::RailShadow), way),
        ]
    });
    let facings = [true, false].into_iter().flat_map(|is_edge_on| {
        let ways = Interface::ALL.into_iter().flat_map(facing_ways);
        ways.map(move |way| Job::Facing(FACING_SUN, is_edge_on, way))
    });
    let nears = Interface::ALL.into_iter().flat_map(near_ways);
    let nears = nears.map(|way| Job::Near(DECK_SUNS[1], way));
    let device_rows = ROWS.into_iter().flat_map(|casters| {
        let ways = Interface::ALL.into_iter().flat_map(row_ways);
        ways.map(move |way| Job::DeviceRow(casters, way))
    });
    let (map_suns, texels) = match is_quick {
        true => (&MAP_SUNS[..1], &TEXELS_M[..2]),
        false => (&MAP_SUNS[..], &TEXELS_M[..]),
    };
    let device_maps = map_suns.iter().flat_map(|sun| {
        let of = move |texel: &f64| Bias::DRAWN.map(|bias| Job::DeviceMap(*sun, *texel, bias));
        texels.iter().flat_map(of)
    });
    let maps = map_suns.iter().flat_map(|sun| {
        let of = move |texel: &f64| Bias::ALL.map(|bias| Job::Map(*sun, *texel, bias));
        texels.iter().flat_map(of)
    });
    let cases = |jobs: Vec<Job>, samples: u32| {
        jobs.into_iter()
            .map(|job| (job, planned(job, samples, brought)))
            .collect()
    };
    let all = vec![
        ("model", cases(vec![Job::Model], 0)),
        ("eyes", cases(eyes.collect(), 0)),
        ("updates", cases(updates.collect(), 0)),
        ("views", cases(views.collect(), 0)),
        (
            "scissors",
            cases(
                Scissor::ALL
                    .map(|scissor| Job::Scissor(LOW_SUN, scissor))
                    .into(),
                0,
            ),
        ),
        ("bounds", cases(bounds.collect(), 0)),
        (
            "finite",
            cases(LENGTHS.map(|length| Job::Finite(LOW_SUN, length)).into(), 0),
        ),
        ("rows", cases(rows.collect(), 0)),
        ("casters", cases(Policy::ALL.map(Job::Casters).into(), 0)),
        ("outlines", cases(outlines.collect(), 0)),
        (
            "silhouettes",
            cases(silhouettes.collect(), samples.unwrap_or(SAMPLES)),
        ),
        (
            "devices",
            cases(devices.collect(), samples.unwrap_or(SAMPLES)),
        ),
        (
            "ladder",
            cases(ladder.collect(), samples.unwrap_or(SAMPLES)),
        ),
        (
            "rivals",
            cases(rivals.collect(), samples.unwrap_or(SAMPLES)),
        ),
        ("near", cases(nears.collect(), samples.unwrap_or(SAMPLES))),
        (
            "device-rows",
            cases(device_rows.collect(), samples.unwrap_or(SAMPLES)),
        ),
        ("facings", cases(facings.collect(), 0)),
        ("origins", cases(origins.collect(), 0)),
        ("maps", cases(maps.collect(), samples.unwrap_or(1))),
        (
            "device-maps",
            cases(device_maps.collect(), samples.unwrap_or(SAMPLES)),
        ),
    ];
    let is_asked = |name| match brought {
        Some(_) => OF_ANY_MODEL.contains(&name),
        None => name != "model",
    };
    all.into_iter()
        .filter(|(name, _)| is_asked(*name))
        .collect()
}
