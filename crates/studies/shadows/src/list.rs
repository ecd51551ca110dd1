// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which cases there are.

use crate::STUDY;
use crate::brought::Brought;
use crate::count::Rule;
use crate::device::Interface;
use crate::drawing::{DeviceWay, Positions, Silhouettes};
use crate::maps::Bias;
use crate::near::EyeTest;
use crate::outline::Way;
use crate::work::{End, NEARS, Scissor};
use terrafill_casters::Policy;
use terrafill_fill::FacePasses;
use terrafill_results::{CaseId, PlannedCase};
use terrafill_study::Depth;

/// Suns over the deck: elevation and azimuth from the dock, degrees.
const DECK_SUNS: [[f64; 2]; 2] = [[30.0, -60.0], [5.0, 0.0]];
/// Suns over the bridge; a quick run has the first four.
const SUNS: [[f64; 2]; 7] = [
    [60.0, 90.0],
    [10.0, -60.0],
    [5.0, 0.0],
    [1.0, 0.0],
    [30.0, -60.0],
    [2.0, 0.0],
    [0.3, -60.0],
];
const QUICK_SUNS: usize = 4;
/// Suns of devices; a quick run has the first two.
const DEVICE_SUNS: [[f64; 2]; 4] = [[10.0, -60.0], [5.0, 0.0], [60.0, 90.0], [1.0, 0.0]];
const QUICK_DEVICE_SUNS: usize = 2;
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
const SAMPLES: u32 = 5;

/// Questions that a user's model is asked, in order.
const OF_ANY_MODEL: [&str; 6] = [
    "model",
    "updates",
    "scissors",
    "silhouettes",
    "devices",
    "maps",
];

/// How a silhouette is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Method {
    Stack,
    Hash,
    Adjacency,
}

impl Method {
    pub(crate) const ALL: [Self; 3] = [Self::Stack, Self::Hash, Self::Adjacency];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Stack => "stack",
            Self::Hash => "hash",
            Self::Adjacency => "adjacency",
        }
    }
}

/// What a case computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Job {
    Eye([f64; 2], f64, EyeTest),
    Updates([f64; 2], End, Rule),
    Scissor([f64; 2], Scissor),
    Finite([f64; 2], f64),
    Row(u32, bool),
    Casters(Policy),
    Outline(u32, Way),
    Silhouette(&'static str, Method),
    /// What a user's file holds.
    Model,
    Device([f64; 2], DeviceWay),
    Origin([f64; 2], DeviceWay),
    Map([f64; 2], f64, Bias),
}

/// Volumes from the CPU, closed at the sea, z-fail, two-sided, whole.
fn device_way(interface: Interface) -> DeviceWay {
    DeviceWay {
        interface,
        silhouettes: Silhouettes::Adjacency,
        positions: Positions::Eye,
        end: End::Sea,
        rule: Rule::Fail,
        faces: FacePasses::TwoSided,
        is_cut: false,
    }
}

/// How devices draw: what differs from one to the next is one thing.
fn device_ways(interface: Interface) -> Vec<DeviceWay> {
    let way = device_way(interface);
    let (end, rule, faces) = (End::Infinite, Rule::Pass, FacePasses::TwoPass);
    let mut ways = vec![
        DeviceWay { end, ..way },
        DeviceWay { end, rule, ..way },
        way,
        DeviceWay { rule, ..way },
        DeviceWay { faces, ..way },
        DeviceWay {
            is_cut: true,
            ..way
        },
    ];
    // On Vulkan geometry shaders would find them.
    if interface == Interface::Wgpu {
        let silhouettes = Silhouettes::Pulled;
        ways.push(DeviceWay {
            end,
            silhouettes,
            ..way
        });
    }
    ways
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

pub(crate) fn sun_name([elevation, azimuth]: [f64; 2]) -> String {
    format!("{elevation}° from {azimuth}°")
}

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
        None => &MESHES,
    };
    let eyes = DECK_SUNS.into_iter().flat_map(|sun| {
        let of = move |near| EyeTest::ALL.map(|test| Job::Eye(sun, near, test));
        NEARS.into_iter().flat_map(of)
    });
    let updates = suns.iter().flat_map(|sun| {
        let of = |end| Rule::ALL.map(|rule| Job::Updates(*sun, end, rule));
        [End::Infinite, End::Sea].into_iter().flat_map(of)
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
    let origins = Interface::ALL.into_iter().flat_map(origin_ways);
    let origins = origins.map(|way| Job::Origin(LOW_SUN, way));
    let (map_suns, texels) = match is_quick {
        true => (&MAP_SUNS[..1], &TEXELS_M[..2]),
        false => (&MAP_SUNS[..], &TEXELS_M[..]),
    };
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
        (
            "scissors",
            cases(
                Scissor::ALL
                    .map(|scissor| Job::Scissor(LOW_SUN, scissor))
                    .into(),
                0,
            ),
        ),
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
        ("origins", cases(origins.collect(), 0)),
        ("maps", cases(maps.collect(), samples.unwrap_or(1))),
    ];
    let is_asked = |name| match brought {
        Some(_) => OF_ANY_MODEL.contains(&name),
        None => name != "model",
    };
    all.into_iter().filter(|(name, _)| is_asked(*name)).collect()
}

fn planned(job: Job, samples: u32, brought: Option<&Brought>) -> PlannedCase {
    let (question, conditions, may_be_wrong): (_, Vec<(&str, String)>, _) = match job {
        Job::Model => ("model", Vec::new(), false),
        Job::Eye(sun, near, test) => (
            "eyes",
            vec![
                ("sun", sun_name(sun)),
                ("near_m", near.to_string()),
                ("eye_test", test.name().to_owned()),
            ],
            test == EyeTest::Eye,
        ),
        Job::Updates(sun, end, rule) => (
            "updates",
            vec![
                ("sun", sun_name(sun)),
                ("extent", end.name().to_owned()),
                ("rule", rule.name().to_owned()),
            ],
            rule == Rule::PassAsPrinted,
        ),
        Job::Scissor(sun, scissor) => (
            "scissors",
            vec![
                ("sun", sun_name(sun)),
                ("scissor", scissor.name().to_owned()),
            ],
            !matches!(scissor, Scissor::Off | Scissor::CasterRectangle),
        ),
        Job::Finite(sun, length) => (
            "finite",
            vec![("sun", sun_name(sun)), ("length_m", length.to_string())],
            true,
        ),
        Job::Row(count, guard) => (
            "rows",
            vec![
                ("casters", count.to_string()),
                (
                    "counting",
                    if guard {
                        "passes of 255"
                    } else {
                        "8 bits, wrapping"
                    }
                    .to_owned(),
                ),
            ],
            !guard,
        ),
        Job::Casters(policy) => (
            "casters",
            vec![("policy", policy.name().to_owned())],
            policy == Policy::AsIs,
        ),
        Job::Outline(count, way) => (
            "outlines",
            vec![
                ("models", count.to_string()),
                ("outline", way.name().to_owned()),
            ],
            matches!(way, Way::ValueAsPrinted | Way::ValueNeverCleared),
        ),
        Job::Silhouette(mesh, method) => (
            "silhouettes",
            match brought {
                Some(_) => vec![("silhouette", method.name().to_owned())],
                None => vec![
                    ("mesh", mesh.to_owned()),
                    ("silhouette", method.name().to_owned()),
                ],
            },
            mesh.contains("turned") && method != Method::Adjacency,
        ),
        Job::Map(sun, texel, bias) => (
            "maps",
            vec![
                ("sun", sun_name(sun)),
                ("texel_m", texel.to_string()),
                ("bias", bias.name().to_owned()),
            ],
            true,
        ),
        Job::Origin(sun, way) => (
            "origins",
            vec![
                ("sun", sun_name(sun)),
                ("api", way.interface.name().to_owned()),
                ("positions", way.positions.name()),
            ],
            way.positions != Positions::Eye,
        ),
        Job::Device(sun, way) => {
            let scissor = if way.is_cut {
                Scissor::CasterRectangle
            } else {
                Scissor::Off
            };
            let faces = match way.faces {
                FacePasses::TwoSided => "two-sided",
                FacePasses::TwoPass => "two-pass",
            };
            let conditions = [
                ("sun", sun_name(sun)),
                ("api", way.interface.name().to_owned()),
                ("extent", way.end.name().to_owned()),
                ("rule", way.rule.name().to_owned()),
                ("faces", faces.to_owned()),
                ("scissor", scissor.name().to_owned()),
                ("silhouette", way.silhouettes.name().to_owned()),
            ];
            ("devices", conditions.into(), false)
        }
    };
    let model = brought.map(|brought| ("model", brought.name.clone()));
    let conditions: Vec<(&str, String)> = model.into_iter().chain(conditions).collect();
    let values: Vec<&str> = conditions.iter().map(|(_, value)| value.as_str()).collect();
    let name = format!("{question}/{}", values.join("/"));
    let conditions = std::iter::once(("question", question.to_owned())).chain(conditions.clone());
    // Of a mesh that is not closed, any answer but the verdict may be wrong.
    let may_leak = brought.is_some_and(|brought| brought.policy == Policy::AsIs);
    PlannedCase {
        id: CaseId::new(STUDY, name, conditions),
        samples,
        may_be_wrong: may_be_wrong || may_leak,
    }
}
