// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which cases there are.

mod planned;

use self::planned::{planned, question};
use crate::ablation::steps;
use crate::brought::Brought;
use crate::counted::{Counted, Ranges};
use crate::job::{HarbourFrame, Job, Method, PORT, TEN_PORTS};
use crate::lamps::{LampEye, LampName, Limit};
use crate::maps::Bias;
use crate::rivals::Rival;
use crate::views::{Chooser, Eyes, Place};
use crate::way::{Bounds, Counting, Cut, DeviceWay, Silhouettes};
use crate::work::{End, NEARS, Scissor};
use terrafill_casters::Policy;
use terrafill_results::PlannedCase;
use terrafill_shadow_views::{Adjacency, EyeTest, Interface, Positions, Rule};
use terrafill_study::Depth;
use terrafill_variant::FacePasses;

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
/// Suns of devices: of the first every way is drawn, of the others those of the paper's questions. A quick run has the
/// first.
const DEVICE_SUNS: [[f64; 2]; 4] = [[10.0, -60.0], [60.0, 90.0], [30.0, -60.0], [5.0, 0.0]];
const QUICK_DEVICE_SUNS: usize = 1;
/// Suns of the ablation and of rivals, of which the paper says nothing sun by sun.
const OTHER_SUNS: usize = 1;
/// Suns of frames that are looked at: a quick run has the first.
const HARBOUR_SUNS: [[f64; 2]; 5] = [
    [10.0, -60.0],
    [60.0, -60.0],
    [30.0, -60.0],
    [5.0, -60.0],
    [1.0, -60.0],
];
const QUICK_HARBOUR_SUNS: usize = 1;
/// From where frames are seen: all channels of the bridge, and the one view from above.
const FRAMES: [Eyes; 2] = [Eyes::Bridge, Eyes::At(Place::Aerial)];
/// Pixels of each channel by which a run says what fits a frame's budget; a quick run has the first two, and a full one
/// the last.
const FITTING: [[u32; 2]; 5] = [[128, 96], [256, 192], [512, 384], [1024, 768], [3840, 2160]];
/// Rules under the moon.
const MOONLIT: [Rule; 2] = [Rule::Fail, Rule::Pass];
/// Sun of facings.
const FACING_SUN: [f64; 2] = [30.0, -60.0];
/// Distances of an origin from the port, m: the last is that of the earth's centre.
const ORIGINS_M: [f64; 3] = [1e5, 1e6, 6.371e6];
/// Suns of maps and their texels, m; a quick run has the first sun and the first two texels.
const MAP_SUNS: [[f64; 2]; 6] = [
    [10.0, -60.0],
    [60.0, 90.0],
    [30.0, -60.0],
    [5.0, 0.0],
    [2.0, -60.0],
    [1.0, -60.0],
];
const QUICK_MAP_SUNS: usize = 1;
const TEXELS_M: [f64; 4] = [1.0, 0.25, 0.1, 0.05];
const QUICK_TEXELS: usize = 2;
/// Sun of scissors and finite volumes.
const LOW_SUN: [f64; 2] = [10.0, -60.0];
/// What counts where a scissor cuts.
const SCISSORED: [Counted; 2] = [Counted::All, Counted::AboveSea];
/// The same of depth bounds, by whose they are.
const BOUNDED: [(Ranges, Counted); 3] = [
    (Ranges::OfParts, Counted::All),
    (Ranges::One, Counted::All),
    (Ranges::One, Counted::InRange),
];
/// Sun of rails seen from near, low enough to show a step of f32.
const RAIL_SUN: [f64; 2] = [3.0, -60.0];
/// From where places in `f32` are looked at.
const ORIGINS_SEEN: [([f64; 2], Eyes); 3] = [
    (LOW_SUN, Eyes::Bridge),
    (RAIL_SUN, Eyes::At(Place::QuayEdge)),
    (LOW_SUN, Eyes::At(Place::RailShadow)),
];
const BRIDGE: [Eyes; 1] = [Eyes::Bridge];
/// Where every way of a device is looked at beside the bridge: no horizon, no level camera.
const ABOVE: [Eyes; 1] = [Eyes::At(Place::Aerial)];
/// Lengths of finite volumes, m.
const LENGTHS: [f64; 7] = [6.0, 12.0, 25.0, 50.0, 100.0, 200.0, 400.0];
/// Casters of rows; 255 is the most that 8 bits count.
const ROWS: [u32; 5] = [255, 256, 257, 511, 512];
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

/// How devices draw: what differs from one to the next is one thing. Under the first sun.
fn device_ways(interface: Interface) -> Vec<DeviceWay> {
    let way = DeviceWay::plain(interface);
    let (end, rule, faces) = (End::Infinite, Rule::Pass, FacePasses::TwoPass);
    let bounded = |bounds| DeviceWay { bounds, ..way };
    // No more than some fifty volumes of this port lie over a pixel.
    let by_part = |bounds| DeviceWay {
        counting: Counting::Parts { is_guarded: false },
        ..bounded(bounds)
    };
    // As the paper has it, for the whole scene.
    let in_one = |bounds| DeviceWay {
        ranges: Ranges::One,
        ..bounded(bounds)
    };
    let by_rule = |counting| DeviceWay { counting, ..way };
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
        DeviceWay {
            cut: Cut::SeaLevel,
            ..way
        },
        by_rule(Counting::ByView(EyeTest::Eye)),
        by_rule(Counting::ByView(EyeTest::Exact)),
        by_rule(Counting::Chosen(EyeTest::EyeModel)),
        by_rule(Counting::Chosen(EyeTest::Exact)),
        bounded(Bounds::Native),
        by_part(Bounds::Native),
        in_one(Bounds::Native),
        bounded(Bounds::Tiles),
        by_part(Bounds::Tiles),
        in_one(Bounds::Tiles),
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
    ways.push(found(Silhouettes::EachFrame, end));
    match interface {
        Interface::Wgpu => ways.extend([
            bounded(Bounds::Discard),
            by_part(Bounds::Discard),
            in_one(Bounds::Discard),
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

/// The same under other suns: what the paper asks, by the interface that has it.
fn asked_ways(interface: Interface) -> Vec<DeviceWay> {
    let is_own = |way: &DeviceWay| match (interface, way.silhouettes, way.bounds) {
        // By part more is drawn, and the closed volumes of compute are asked once.
        _ if matches!(way.counting, Counting::Parts { .. }) => false,
        // Whether it is right is asked by counts, and what it saves under one sun.
        _ if way.ranges == Ranges::One => false,
        (Interface::Wgpu, Silhouettes::Computed, _) => way.end == End::Infinite,
        (Interface::Wgpu, _, _) => way.rule != Rule::Preload,
        (Interface::Vulkan, Silhouettes::Geometry(by), _) => by == Adjacency::Triangles,
        (Interface::Vulkan, _, Bounds::Native) => true,
        // What these are compared with.
        (Interface::Vulkan, _, _) => {
            let plain = DeviceWay::plain(interface);
            [End::Infinite, End::Sea]
                .map(|end| DeviceWay { end, ..plain })
                .contains(way)
                || way.silhouettes == Silhouettes::EachFrame
        }
    };
    let mut ways = device_ways(interface);
    ways.retain(is_own);
    ways
}

/// Whether a way is timed unless a run is full. Each is drawn and judged by both interfaces. What either can do is timed by
/// wgpu, and what Vulkan alone has with what it is compared with.
fn is_timed(way: DeviceWay) -> bool {
    let is_vulkan_s =
        matches!(way.silhouettes, Silhouettes::Geometry(_)) || way.bounds == Bounds::Native;
    way.interface == Interface::Wgpu || is_vulkan_s || asked_ways(way.interface).contains(&way)
}

/// Whose near plane is partly in shadow: by rule, and by who chooses it.
fn near_ways(interface: Interface) -> Vec<DeviceWay> {
    let way = DeviceWay::plain(interface);
    let rule = |rule| DeviceWay { rule, ..way };
    let counting = |counting| DeviceWay { counting, ..way };
    vec![
        rule(Rule::Pass),
        counting(Counting::Chosen(EyeTest::Eye)),
        counting(Counting::Chosen(EyeTest::EyeModel)),
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
        ..DeviceWay::plain(interface)
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
        ..DeviceWay::plain(interface)
    };
    all.into_iter().map(of).collect()
}

/// The same from numbers that count from elsewhere.
fn origin_ways(interface: Interface) -> impl Iterator<Item = DeviceWay> {
    let way = DeviceWay::plain(interface);
    let worlds = ORIGINS_M.map(Positions::World).into_iter();
    let all = std::iter::once(Positions::Eye).chain(worlds);
    all.map(move |positions| DeviceWay { positions, ..way })
}

/// Ways of every interface.
fn of_both<T, W: IntoIterator<Item = T>>(ways: impl Fn(Interface) -> W) -> Vec<T> {
    Interface::ALL.into_iter().flat_map(ways).collect()
}

/// Every one of the first with every one of the second.
fn cross<A: Copy, B: Copy>(first: &[A], second: &[B], job: impl Fn(A, B) -> Job) -> Vec<Job> {
    let of = |a: &A| second.iter().map(|b| job(*a, *b)).collect::<Vec<_>>();
    first.iter().flat_map(of).collect()
}

/// The same under each of these suns.
fn under<A: Copy, B: Copy>(
    suns: &[[f64; 2]],
    first: &[A],
    second: &[B],
    job: impl Fn([f64; 2], A, B) -> Job,
) -> Vec<Job> {
    let of = |sun: &[f64; 2]| cross(first, second, |a, b| job(*sun, a, b));
    suns.iter().flat_map(of).collect()
}

/// Frames that are looked at.
fn harbours(suns: &[[f64; 2]]) -> Vec<Job> {
    let of = |sun, eyes| Interface::ALL.map(|interface| HarbourFrame::plain(sun, eyes, interface));
    let mut frames: Vec<HarbourFrame> = Vec::new();
    for sun in suns {
        frames.extend(FRAMES.iter().flat_map(|eyes| of(*sun, *eyes)));
    }
    frames.into_iter().map(Job::Harbour).collect()
}

/// Frames from the bridge in several sizes, and of ten times the casters.
fn fitted(sizes: &[[u32; 2]]) -> Vec<Job> {
    // The same rays judge both interfaces, so that these follow one another.
    let of = |port, size| {
        Interface::ALL.map(|interface| HarbourFrame {
            port,
            size,
            ..HarbourFrame::plain(LOW_SUN, Eyes::Bridge, interface)
        })
    };
    let sized = sizes.iter().flat_map(|size| of(PORT, Some(*size)));
    sized.chain(of(TEN_PORTS, None)).map(Job::Harbour).collect()
}

/// Each lamp with every limit. A quick run has one rule.
fn counted_lamps(is_quick: bool) -> Vec<Job> {
    let rules = if is_quick { 1 } else { 2 };
    let of = |name: LampName| {
        cross(
            &[Rule::Fail, Rule::Pass][..rules],
            &Limit::ALL,
            |rule, limit| Job::Lamp(name, rule, limit),
        )
    };
    LampName::ALL.into_iter().flat_map(of).collect()
}

/// Each lamp by devices. A quick run has the bridge, and other eyes of the first lamp.
fn drawn_lamps(is_quick: bool) -> Vec<Job> {
    let seen = LampName::ALL.into_iter().flat_map(|name| {
        let of_all = name == LampName::Shore || !is_quick;
        let eyes = LampEye::ALL.into_iter();
        let own = eyes.filter(move |eye| of_all || *eye == LampEye::Bridge);
        own.map(move |eye| (name, eye))
    });
    let ways = [
        (Rule::Fail, Limit::Off),
        (Rule::Fail, Limit::Range),
        (Rule::Pass, Limit::Off),
    ];
    // Timed against volumes without a limit.
    let limited = [Limit::Scissor, Limit::Bounds, Limit::Casters].map(|limit| (Rule::Fail, limit));
    let of = |(name, eye)| {
        let limited = if eye == LampEye::Bridge {
            &limited[..]
        } else {
            &[]
        };
        cross(
            &Interface::ALL,
            &[&ways[..], limited].concat(),
            |interface, (rule, limit)| Job::DeviceLamp(name, eye, interface, rule, limit),
        )
    };
    seen.flat_map(of).collect()
}

/// Frames under the moon. A quick run has the bridge.
fn moonlit(is_quick: bool) -> Vec<Job> {
    let eyes = [Eyes::Bridge, Eyes::At(Place::Aerial)];
    let eyes = if is_quick { &eyes[..1] } else { &eyes[..] };
    let of = |own: &Eyes| {
        cross(&Interface::ALL, &MOONLIT, |interface, rule| {
            Job::DeviceMoon(*own, interface, rule)
        })
    };
    eyes.iter().flat_map(of).collect()
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
    let part = |quick: usize, all: usize| if is_quick { ..quick } else { ..all };
    let suns = &SUNS[part(QUICK_SUNS, SUNS.len())];
    let meshes = match brought {
        Some(_) => &[BROUGHT][..],
        None => &MESHES[part(QUICK_MESHES, MESHES.len())],
    };
    let device_suns = &DEVICE_SUNS[part(QUICK_DEVICE_SUNS, DEVICE_SUNS.len())];
    let harbour_suns = &HARBOUR_SUNS[part(QUICK_HARBOUR_SUNS, HARBOUR_SUNS.len())];
    let map_suns = &MAP_SUNS[part(QUICK_MAP_SUNS, MAP_SUNS.len())];
    let texels = &TEXELS_M[part(QUICK_TEXELS, TEXELS_M.len())];
    // A user's model is seen from where it is looked at.
    let from_above = match brought {
        Some(_) => &[][..],
        None => &[LOW_SUN],
    };
    // By what the casters are cut to: each scene is made once.
    let ends = [End::Infinite, End::SeaOfWhole, End::Sea, End::Calm];
    let rules = |end| match end {
        End::Infinite | End::Sea => &Rule::ALL[..],
        _ => &[Rule::Fail],
    };
    let updates = suns.iter().flat_map(|sun| {
        let of = |end| under(&[*sun], &[end], rules(end), Job::Updates);
        ends.into_iter().flat_map(of)
    });
    let of_place = |place, chooser| Job::View(LOW_SUN, place, chooser);
    let of_boxes = |is_edge_on, way| Job::Facing(FACING_SUN, is_edge_on, way);
    let seen = |way, (sun, eyes)| Job::Origin(sun, eyes, way);
    let of_bounds = |sun, rule, (ranges, counted)| Job::Bounds(sun, rule, ranges, counted);
    let fitting = match depth {
        Depth::Quick => &FITTING[..2],
        Depth::Main => &FITTING[..4],
        Depth::Full => &FITTING[..],
    };
    let all: [Vec<Job>; 23] = [
        vec![Job::Model],
        harbours(harbour_suns),
        fitted(fitting),
        under(&DECK_SUNS, &NEARS, &EyeTest::ALL, Job::Eye),
        updates.collect(),
        cross(&Place::ALL, &Chooser::ALL, of_place),
        under(&[LOW_SUN], &Scissor::ALL, &SCISSORED, Job::Scissor),
        under(suns, &[Rule::Pass, Rule::Fail], &BOUNDED, of_bounds),
        cross(&[LOW_SUN], &LENGTHS, Job::Finite),
        cross(&ROWS, &[false, true], Job::Row),
        Policy::ALL.map(Job::Casters).into(),
        cross(meshes, &Method::ALL, Job::Silhouette),
        under(
            &device_suns[..1],
            &BRIDGE,
            &of_both(device_ways),
            Job::Device,
        )
        .into_iter()
        .chain(under(
            &device_suns[1..],
            &BRIDGE,
            &of_both(asked_ways),
            Job::Device,
        ))
        .chain(under(
            from_above,
            &ABOVE,
            &of_both(device_ways),
            Job::Device,
        ))
        .collect(),
        cross(
            &device_suns[..OTHER_SUNS],
            &of_both(steps),
            Job::StencilStep,
        ),
        under(&device_suns[..OTHER_SUNS], &BRIDGE, &Rival::ALL, Job::Rival)
            .into_iter()
            .chain(under(from_above, &ABOVE, &Rival::ALL, Job::Rival))
            .collect(),
        cross(&DECK_SUNS[1..], &of_both(near_ways), Job::Near),
        cross(&ROWS, &of_both(row_ways), Job::DeviceRow),
        cross(&[true, false], &of_both(facing_ways), of_boxes),
        cross(&of_both(origin_ways), &ORIGINS_SEEN, seen),
        under(map_suns, texels, &Bias::ALL, Job::Map),
        under(device_suns, texels, &Bias::DRAWN, Job::DeviceMap),
        counted_lamps(is_quick)
            .into_iter()
            .chain(MOONLIT.map(Job::Moon))
            .collect(),
        drawn_lamps(is_quick)
            .into_iter()
            .chain(moonlit(is_quick))
            .collect(),
    ];
    let planned = |jobs: Vec<Job>| {
        let question = jobs.first().map_or("", |job| question(*job));
        let case = |job| {
            let mut case = planned(job, samples, brought);
            let is_timed = match job {
                Job::Device(.., way) => is_timed(way),
                Job::StencilStep(_, step) => step.way.interface == Interface::Wgpu,
                // Those of the CPU are no rival, so that one sun is enough.
                Job::Map(sun, ..) => Some(&sun) == map_suns.first(),
                _ => true,
            };
            if depth != Depth::Full && !is_timed {
                case.samples = 0;
            }
            (job, case)
        };
        (question, jobs.into_iter().map(case).collect())
    };
    let is_asked = |(name, _): &Questions| match brought {
        Some(_) => OF_ANY_MODEL.contains(name),
        None => *name != "model",
    };
    all.into_iter().map(planned).filter(is_asked).collect()
}
