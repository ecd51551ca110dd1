// SPDX-License-Identifier: MIT OR Apache-2.0
//! A procedural port: a trestle dock with cranes, ships, containers and sheds, of convex prisms.
//!
//! Metres, ENU, sea at 0; the dock lies along x from −150 m, land at +y, ships at −y. Seeded: the same
//! port on every machine.

use crate::Mesh;
use crate::mesh::index;
use glam::{DVec2, DVec3};
use terrafill_results::SplitMix64;

/// How much of a port there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortSize {
    /// Bents of the dock, 6 m apart.
    pub bents: u32,
    /// Cranes on it.
    pub cranes: u32,
    /// Rows of containers along each ship, at most.
    pub rows: u32,
    /// Ships beside the moored one.
    pub ships: usize,
    /// Such ports, 700 m apart towards the sea.
    pub copies: u32,
    /// Whether each of them has containers, ships' headings and cranes of its own.
    pub is_varied: bool,
}

const fn size(bents: u32, cranes: u32, rows: u32, ships: usize, copies: u32) -> PortSize {
    PortSize {
        bents,
        cranes,
        rows,
        ships,
        copies,
        is_varied: false,
    }
}

impl PortSize {
    /// Ports by name, from 1,000 to 100,000 triangles and beyond.
    pub const NAMED: [(&'static str, Self); 7] = [
        ("port-xs", size(4, 0, 1, 0, 1)),
        ("port-s", size(11, 1, 1, 1, 1)),
        ("port-m", size(51, 3, 14, 4, 1)),
        ("port-l", size(51, 3, 14, 4, 2)),
        ("port-l3", size(51, 3, 14, 4, 3)),
        ("port-xl", size(51, 3, 14, 4, 18)),
        (
            "port-m10",
            Self {
                is_varied: true,
                ..size(51, 3, 14, 4, 10)
            },
        ),
    ];

    /// The one called `name`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let mut all = Self::NAMED.into_iter();
        all.find(|(own, _)| *own == name).map(|(_, size)| size)
    }
}

/// Seed of container heights.
const SEED: u64 = 21;
/// West end of the dock, m.
const DOCK_START_M: f64 = -150.0;
const BENT_M: f64 = 6.0;
const DOCK_WIDTH_M: f64 = 20.0;
/// The deck's lower and upper side.
const DECK_M: [f64; 2] = [6.0, 7.2];

/// Prisms pushed into a mesh, about a vertical axis at `origin` with a heading.
struct Yard<'a> {
    mesh: &'a mut Mesh,
    origin: DVec3,
    /// Unit vector along the model.
    ahead: DVec2,
}

impl Yard<'_> {
    fn at(&self, local: DVec3) -> DVec3 {
        let turned = self.ahead.rotate(local.truncate());
        self.origin + turned.extend(local.z)
    }

    /// A prism over a local ring, from its lowest height up.
    fn prism(&mut self, ring: &[DVec2], low: f64, high: f64) {
        let ring: Vec<DVec3> = ring
            .iter()
            .map(|place| self.at(place.extend(low)))
            .collect();
        self.mesh.push_prism(&ring, DVec3::Z * (high - low));
    }

    fn cuboid(&mut self, low: [f64; 3], high: [f64; 3]) {
        let [x0, y0, z0] = low;
        let [x1, y1, z1] = high;
        let ring = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(DVec2::from);
        self.prism(&ring, z0, z1);
    }

    /// A regular prism with a vertical axis.
    fn pile(&mut self, x: f64, y: f64, diameter: f64, low: f64, high: f64) {
        let ring = (0..8).map(|corner| {
            let turn = std::f64::consts::TAU / 8.0 * (f64::from(corner) + 0.5);
            DVec2::new(x, y) + DVec2::from_angle(turn) * diameter / 2.0
        });
        let ring: Vec<DVec2> = ring.collect();
        self.prism(&ring, low, high);
    }

    /// A square bar from place to place.
    fn bar(&mut self, from: [f64; 3], to: [f64; 3], side: f64) {
        let (from, to) = (self.at(from.into()), self.at(to.into()));
        let along = to - from;
        let across = if along.x.abs() + along.y.abs() > 1e-9 * along.length() {
            along.cross(DVec3::Z).normalize()
        } else {
            DVec3::X
        };
        let (a, b) = (
            across * side / 2.0,
            along.cross(across).normalize() * side / 2.0,
        );
        self.mesh.push_prism(
            &[from + a + b, from - a + b, from - a - b, from + a - b],
            along,
        );
    }
}

fn yard<'a>(mesh: &'a mut Mesh, name: &str, origin: [f64; 3], heading_deg: f64) -> Yard<'a> {
    mesh.begin(name);
    Yard {
        mesh,
        origin: origin.into(),
        ahead: match heading_deg {
            // The dock's faces are exactly along the axes.
            0.0 => DVec2::X,
            turned => DVec2::from_angle(turned.to_radians()),
        },
    }
}

/// The port of this size.
#[must_use]
pub fn port(size: PortSize) -> Mesh {
    let mut mesh = Mesh::default();
    let mut one = one_port(size, 0);
    for copy in 0..size.copies {
        if size.is_varied && copy > 0 {
            one = one_port(size, copy);
        }
        mesh.append(&one, -700.0 * f64::from(copy) * DVec3::Y);
    }
    mesh
}

/// - `variation`: 0 for the port as it is
fn one_port(size: PortSize, variation: u32) -> Mesh {
    let mut one = Mesh::default();
    let mut random = SplitMix64::new(SEED + u64::from(variation));
    dock(&mut one, size.bents);
    let length = BENT_M * f64::from(size.bents - 1);
    let cranes = size.cranes + variation % 3;
    for crane_at in 0..cranes {
        let share = (f64::from(crane_at) + 0.5) / f64::from(cranes);
        crane(&mut one, DOCK_START_M + share * length);
    }
    let moored = [DOCK_START_M + length / 2.0, -30.0, 0.0];
    let own = [-60.0, -140.0, 0.0];
    let ships = [
        ("moored ship", moored, 0.0, [180.0, 28.0], size.rows, 9),
        ("own ship", own, 25.0, [150.0, 22.0], 0, 0),
        (
            "ship at 0.5 km",
            [300.0, -400.0, 0.0],
            160.0,
            [110.0, 18.0],
            size.rows.min(5),
            6,
        ),
        (
            "ship at 1.5 km",
            [-900.0, -1_200.0, 0.0],
            70.0,
            [240.0, 32.0],
            size.rows,
            11,
        ),
        (
            "ship at 3.8 km",
            [2_300.0, -3_000.0, 0.0],
            10.0,
            [120.0, 20.0],
            size.rows.min(4),
            6,
        ),
    ];
    for (name, origin, heading, hull, rows, columns) in ships.into_iter().take(size.ships + 1) {
        // Who is moored lies along the dock.
        let turned = match heading {
            0.0 => 0.0,
            heading => heading + 17.0 * f64::from(variation),
        };
        let mut yard = yard(&mut one, name, origin, turned);
        ship(&mut yard, hull, rows, columns, &mut random);
    }
    for shed in 0..8 {
        let west = DOCK_START_M + 38.0 * f64::from(shed);
        let mut yard = yard(&mut one, "shed", [west, 60.0, 0.0], 0.0);
        yard.cuboid([0.0, 0.0, -1.0], [30.0, 18.0, 9.0]);
    }
    one
}

fn dock(mesh: &mut Mesh, bents: u32) {
    let mut yard = yard(mesh, "dock", [DOCK_START_M, 0.0, 0.0], 0.0);
    let half = DOCK_WIDTH_M / 2.0;
    let length = BENT_M * f64::from(bents - 1);
    // Slabs meet at joints of 2 cm.
    for slab in 0..bents - 1 {
        let west = BENT_M * f64::from(slab);
        yard.cuboid(
            [west + 0.01, -half, DECK_M[0]],
            [west + BENT_M - 0.01, half, DECK_M[1]],
        );
    }
    for bent in 0..bents {
        let x = BENT_M * f64::from(bent);
        yard.cuboid([x - 0.6, -half, 5.0], [x + 0.6, half, DECK_M[0]]);
        for pile in 0..6 {
            yard.pile(x, -half + 1.0 + 3.6 * f64::from(pile), 0.8, -12.0, 5.0);
        }
    }
    let posts = 3 * (bents - 1) + 1;
    for y in [-half + 0.1, half - 0.1] {
        for post in 0..posts {
            let x = 2.0 * f64::from(post);
            yard.cuboid(
                [x - 0.03, y - 0.03, DECK_M[1]],
                [x + 0.03, y + 0.03, DECK_M[1] + 1.05],
            );
        }
        for height in [0.55, 1.05] {
            let low = DECK_M[1] + height;
            yard.cuboid([0.0, y - 0.025, low], [length, y + 0.025, low + 0.05]);
        }
    }
    for bollard in 0..bents.div_ceil(4) + 2 {
        let x = length * (f64::from(bollard) + 0.5) / f64::from(bents.div_ceil(4) + 2);
        yard.pile(x, -half + 0.8, 0.6, DECK_M[1], DECK_M[1] + 0.7);
    }
}

fn crane(mesh: &mut Mesh, x: f64) {
    let mut yard = yard(mesh, "crane", [x, 0.0, 0.0], 0.0);
    let (legs, foot, top) = ([-8.0, 8.0], DECK_M[1], 37.0);
    for along in legs {
        for across in [-7.5, 7.5] {
            yard.cuboid(
                [along - 0.7, across - 0.7, foot],
                [along + 0.7, across + 0.7, top],
            );
        }
        yard.cuboid([along - 0.7, -6.8, 18.0], [along + 0.7, 6.8, 19.4]);
    }
    for across in [-7.5, 7.5] {
        yard.cuboid([-7.3, across - 0.7, 35.5], [7.3, across + 0.7, top]);
    }
    yard.cuboid([-4.0, 1.0, top], [4.0, 11.0, top + 5.0]);
    // The boom: four chords and their lattice, from 20 m over land to 50 m over the sea.
    let corner = |side: u32, station: f64| {
        let x = if side.is_multiple_of(2) { -1.5 } else { 1.5 };
        let z = if side < 2 { top } else { top + 3.0 };
        [x, 20.0 - station, z]
    };
    for side in 0..4 {
        yard.bar(corner(side, 0.0), corner(side, 70.0), 0.35);
    }
    for bay in 0..17 {
        let (from, to) = (
            70.0 / 17.0 * f64::from(bay),
            70.0 / 17.0 * f64::from(bay + 1),
        );
        for [low, high] in [[0, 2], [1, 3], [0, 1], [2, 3]] {
            yard.bar(corner(low, from), corner(high, to), 0.2);
        }
    }
}

fn ship(
    yard: &mut Yard<'_>,
    [length, beam]: [f64; 2],
    rows: u32,
    columns: u32,
    random: &mut SplitMix64,
) {
    let (half, side) = (length / 2.0, beam / 2.0);
    let deck = 6.0 + length / 60.0;
    // A plan with a round stern and a pointed bow, convex.
    let mut plan = vec![[-half, -0.7 * side], [-0.94 * half, -side]];
    let bow = [
        (0.62, 1.0),
        (0.74, 0.9),
        (0.84, 0.72),
        (0.92, 0.46),
        (0.98, 0.16),
    ];
    plan.extend(bow.map(|(along, across)| [along * half, -across * side]));
    let other = plan.clone().into_iter().rev();
    plan.extend(other.map(|[x, y]| [x, -y]));
    let plan: Vec<DVec2> = plan.into_iter().map(DVec2::from).collect();
    yard.prism(&plan, -8.0, deck);
    let house = -0.82 * half;
    for storey in 0..5 {
        let low = deck + 3.0 * f64::from(storey);
        let inset = 0.4 * f64::from(storey);
        yard.cuboid(
            [house - 6.0 + inset, -side + 2.0 + inset, low],
            [house + 7.0 - inset, side - 2.0 - inset, low + 2.9],
        );
    }
    yard.pile(house - 9.0, 0.0, 4.0, deck, deck + 20.0);
    yard.pile(house, 0.0, 0.5, deck + 15.0, deck + 24.0);
    yard.pile(0.8 * half, 0.0, 0.6, deck, deck + 14.0);
    let posts = 40_u32;
    for y in [-side + 0.15, side - 0.15] {
        for post in 0..posts {
            let x = -0.9 * half + 1.5 * half * f64::from(post) / f64::from(posts - 1);
            yard.cuboid([x - 0.03, y - 0.03, deck], [x + 0.03, y + 0.03, deck + 1.1]);
        }
        yard.cuboid(
            [-0.9 * half, y - 0.025, deck + 1.1],
            [0.6 * half, y + 0.025, deck + 1.15],
        );
    }
    // Containers of 6.06 × 2.44 × 2.59 m with gaps of 4 cm; a stack is one to four high, most of them
    // full.
    for row in 0..rows {
        let x = -0.66 * half + 6.12 * f64::from(row);
        for column in 0..columns {
            let y = 2.48 * (f64::from(column) - f64::from(columns) / 2.0);
            let empty = random.below(10).saturating_sub(7);
            for layer in 0..4 - index(empty) {
                let z = deck + 1.5 + 2.63 * f64::from(layer);
                yard.cuboid([x, y, z], [x + 6.06, y + 2.44, z + 2.59]);
            }
        }
    }
}

/// A smooth lofted hull of about so many triangles: half an ellipsoid under a flat deck, as one part.
///
/// - `triangles`: at least 24
#[must_use]
pub fn hull(triangles: u32) -> Mesh {
    // n meridians by n/2 rings: about n² triangles.
    let around = f64::from(triangles.max(24)).sqrt().ceil();
    #[allow(clippy::cast_possible_truncation, reason = "the root of a u32")]
    let around = around as u32;
    let rings = around / 2;
    let place = |ring: u32, meridian: u32| {
        let down = std::f64::consts::FRAC_PI_2 * f64::from(ring) / f64::from(rings);
        let turn =
            DVec2::from_angle(std::f64::consts::TAU * f64::from(meridian) / f64::from(around));
        let flat = turn * down.cos() * DVec2::new(75.0, 11.0);
        flat.extend(10.0 - 16.0 * down.sin())
    };
    let mut vertices: Vec<DVec3> = (0..rings)
        .flat_map(|ring| (0..around).map(move |meridian| place(ring, meridian)))
        .collect();
    let keel = index(vertices.len());
    vertices.push(DVec3::new(0.0, 0.0, -6.0));
    let mut faces = Vec::new();
    for at in 0..around {
        let next = (at + 1) % around;
        for ring in 0..rings - 1 {
            let (upper, lower) = (ring * around, (ring + 1) * around);
            faces.push([upper + at, lower + at, lower + next]);
            faces.push([upper + at, lower + next, upper + next]);
        }
        let last = (rings - 1) * around;
        faces.push([last + at, keel, last + next]);
    }
    // The deck, a fan over the first ring.
    faces.extend((1..around - 1).map(|at| [0, at, at + 1]));
    let mut mesh = Mesh::default();
    if let Ok(made) = Mesh::from_triangles("hull", vertices, faces) {
        mesh = made;
    }
    mesh
}

/// So many upright plates of 25 m in a row along x, half a metre apart: towards a low sun along x every
/// one of them lies before the same water.
#[must_use]
pub fn row(count: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let mut yard = yard(&mut mesh, "row", [0.0; 3], 0.0);
    for plate in 0..count {
        let x = 0.5 * f64::from(plate);
        yard.cuboid([x, -100.0, -1.0], [x + 0.1, 100.0, 25.0]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict;

    #[test]
    fn ports_are_closed_and_as_large_as_their_names_say() {
        let count = |name: &str| {
            let mesh = port(PortSize::named(name).expect("named"));
            assert_eq!(verdict(&mesh).to_string(), "closed", "{name}");
            assert_eq!(
                mesh.parts.last().map(|part| part.triangles.end),
                Some(mesh.triangles.len())
            );
            mesh.triangles.len()
        };
        let sizes = ["port-xs", "port-s", "port-m", "port-l", "port-l3"].map(count);
        assert!((800..3_000).contains(&sizes[0]), "{sizes:?}");
        assert!((3_000..10_000).contains(&sizes[1]), "{sizes:?}");
        assert!((28_000..40_000).contains(&sizes[2]), "{sizes:?}");
        assert_eq!([sizes[3], sizes[4]], [2 * sizes[2], 3 * sizes[2]]);
        let ten = port(PortSize::named("port-m10").expect("named"));
        assert_eq!(verdict(&ten).to_string(), "closed");
        let share = ten.triangles.len() as f64 / (10 * sizes[2]) as f64;
        assert!((0.95..1.1).contains(&share), "{share}");
        // Negative control: copies of one port are its triangles over again.
        assert_ne!(ten.triangles.len(), 10 * sizes[2]);
        assert!(PortSize::named("port-xxl").is_none());
    }

    #[test]
    fn the_dock_has_the_published_triangles() {
        let mut mesh = Mesh::default();
        dock(&mut mesh, 51);
        assert_eq!(mesh.triangles.len(), 13_872);
        let mut mesh = Mesh::default();
        crane(&mut mesh, 0.0);
        assert_eq!(mesh.triangles.len(), 972);
    }

    #[test]
    fn hulls_and_rows_are_closed_and_convex_outward() {
        for mesh in [hull(24), hull(600), hull(20_000), row(257)] {
            assert_eq!(verdict(&mesh).to_string(), "closed");
            for part in &mesh.parts {
                let places = &mesh.vertices[part.vertices.clone()];
                let middle = places.iter().sum::<DVec3>() / places.len() as f64;
                for triangle in part.triangles.clone() {
                    let [a, b, c] = mesh.corners(triangle);
                    assert!((b - a).cross(c - a).dot(a - middle) > 0.0, "{triangle}");
                }
            }
        }
        assert_eq!(row(257).parts.len(), 257);
        let smooth = hull(20_000).triangles.len();
        assert!((18_000..22_000).contains(&smooth), "{smooth}");
    }
}
