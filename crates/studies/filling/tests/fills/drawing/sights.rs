// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions and views of them on which backends go wrong, if anywhere; and ways to break a volume.

use super::{Pose, collection, input, polygon};
use terrafill_contract::FillInput;
use terrafill_core::{Ellipsoid, RegionMesh};

/// A view, and what to call it where something is wrong.
pub(crate) type Sight = (&'static str, FillInput);

/// Views of WGS 84 with a grid of 180 rows.
fn sights(features: &[String], poses: &[(&'static str, Pose)]) -> Vec<Sight> {
    let text = collection(features);
    let sight = |&(name, pose)| (name, input(&text, Ellipsoid::WGS84, 180, pose));
    poses.iter().map(sight).collect()
}

/// A hole, an island in it and a neighbour.
pub(crate) fn hole_island_and_neighbour() -> Vec<Sight> {
    sights(
        &[
            polygon(
                "shell",
                "[[0,0],[10,0],[10,10],[0,10],[0,0]],[[2,2],[2,8],[8,8],[8,2],[2,2]]",
            ),
            polygon("island", "[[4,4],[6,4],[6,6],[4,6],[4,4]]"),
            polygon("neighbour", "[[10,0],[20,-5],[20,12],[10,10],[10,0]]"),
        ],
        &[
            ("above", (9.0, 4.0, 2e6, 30.0, -90.0)),
            ("oblique", (5.0, -2.0, 3e5, 10.0, -25.0)),
            ("low, inside", (1.7, 5.0, 5e3, 90.0, -12.0)),
        ],
    )
}

/// Across the antimeridian and over both poles.
pub(crate) fn seam_and_poles() -> Vec<Sight> {
    sights(
        &[
            polygon("strip", "[[170,-10],[190,-10],[190,10],[170,10],[170,-10]]"),
            polygon(
                "north",
                "[[-180,80],[-90,75],[0,80],[90,75],[180,80],[180,90],[-180,90],[-180,80]]",
            ),
            polygon(
                "south",
                "[[-180,-90],[180,-90],[180,-70],[60,-75],[-60,-65],[-180,-70],[-180,-90]]",
            ),
        ],
        &[
            ("antimeridian", (178.0, 3.0, 3e6, 0.0, -90.0)),
            ("antimeridian, low", (-179.0, -10.5, 2e4, 350.0, -10.0)),
            ("north pole", (20.0, 89.0, 4e6, 0.0, -90.0)),
            ("over the pole, low", (20.0, 80.5, 2e4, 180.0, -8.0)),
            ("south pole", (20.0, -89.0, 4e6, 0.0, -90.0)),
        ],
    )
}

/// Ten metres from fifty.
pub(crate) fn ten_metres() -> Vec<Sight> {
    // 10 m are 1.39e-4 degrees of longitude and 9e-5 of latitude here.
    let text = polygon(
        "square",
        "[[10.0,50.0],[10.000139,50.0],[10.000139,50.00009],[10.0,50.00009],[10.0,50.0]]",
    );
    let pose = (10.00007, 50.000045, 50.0, 0.0, -90.0);
    // The 1° grid hangs hundreds of metres below the ellipsoid; a fine one keeps the surface near.
    vec![("ten metres", input(&text, Ellipsoid::WGS84, 720, pose))]
}

/// The same patch on bodies from a pebble to a giant.
pub(crate) fn other_bodies() -> Vec<Sight> {
    let text = polygon("patch", "[[-20,-10],[25,-15],[30,40],[-5,35],[-20,-10]]");
    let bodies = [
        ("Moon", Ellipsoid::MOON, 2e6),
        ("Mars", Ellipsoid::MARS, 4e6),
        ("like Saturn", Ellipsoid::SATURN_LIKE, 8e7),
        ("unit sphere", Ellipsoid::UNIT_SPHERE, 1.5),
        ("asteroid", Ellipsoid::ASTEROID_250M, 400.0),
    ];
    let sight = |(name, body, height_m)| {
        let pose = (5.0, 10.0, height_m, 0.0, -90.0);
        (name, input(&text, body, 180, pose))
    };
    bodies.map(sight).into()
}

/// One region.
pub(crate) fn square() -> String {
    polygon("square", "[[0,0],[10,0],[10,10],[0,10],[0,0]]")
}

/// The square seen from `pose`.
pub(crate) fn square_from(pose: Pose) -> FillInput {
    input(&square(), Ellipsoid::WGS84, 180, pose)
}

/// Two neighbours with a common border and a third region apart from them.
pub(crate) fn three_regions() -> String {
    collection(&[
        polygon("west", "[[0,0],[4,0],[6,10],[0,10],[0,0]]"),
        polygon("east", "[[4,0],[10,0],[10,10],[6,10],[4,0]]"),
        polygon("far", "[[12,2],[14,2],[14,4],[12,4],[12,2]]"),
    ])
}

/// The three regions seen from `pose`.
pub(crate) fn three_regions_from(pose: Pose) -> FillInput {
    input(&three_regions(), Ellipsoid::WGS84, 180, pose)
}

/// Of the three regions: from above; close above a border; and inside the volumes, below their tops.
pub(crate) const POSES: [Pose; 3] = [
    (7.0, 5.0, 3e6, 0.0, -90.0),
    (4.9, 4.0, 2e4, 10.0, -30.0),
    (4.95, 5.0, 400.0, 80.0, -5.0),
];

/// One way to break a volume.
pub(crate) struct Mutant {
    pub(crate) name: &'static str,
    pub(crate) change: fn(&mut RegionMesh),
    pub(crate) notices: Notices,
    /// It is the way that faces look: to whoever flips bits, all faces are alike.
    pub(crate) asks_for_counting: bool,
}

/// Who sees that a volume is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Notices {
    /// Nothing is broken.
    Nobody,
    Everybody,
    /// Whoever makes walls along the boundary, not those who make them around every triangle. If all
    /// of such a volume is turned over it counts −1, which is not 0 either.
    WhoeverAsksForLoops,
}

pub(crate) const MUTANTS: [Mutant; 6] = [
    Mutant {
        name: "none",
        change: |_| {},
        notices: Notices::Nobody,
        asks_for_counting: false,
    },
    Mutant {
        name: "half the caps missing",
        change: |mesh| mesh.triangles.truncate(mesh.triangles.len() / 2),
        notices: Notices::Everybody,
        asks_for_counting: false,
    },
    Mutant {
        name: "walls missing",
        change: |mesh| mesh.boundary_loops.clear(),
        notices: Notices::WhoeverAsksForLoops,
        asks_for_counting: false,
    },
    Mutant {
        name: "walls turned over",
        change: |mesh| {
            for ring in &mut mesh.boundary_loops {
                ring.reverse();
            }
        },
        notices: Notices::WhoeverAsksForLoops,
        asks_for_counting: true,
    },
    Mutant {
        name: "caps turned over",
        change: |mesh| {
            for [_, b, c] in &mut mesh.triangles {
                std::mem::swap(b, c);
            }
        },
        notices: Notices::WhoeverAsksForLoops,
        asks_for_counting: true,
    },
    Mutant {
        name: "vertices pushed 50 km east",
        change: |mesh| {
            for vertex in &mut mesh.vertices_ecef {
                vertex.y += 5e4;
            }
        },
        notices: Notices::Everybody,
        asks_for_counting: false,
    },
];
