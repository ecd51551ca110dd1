// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the port's parts are made of, told by their model's name and their size, and the colour of each place.

use glam::DVec3;
use terrafill_casters::Mesh;
use terrafill_shadow_views::box_of;

/// Height of a container and of a storey, m, as the port has them.
const CONTAINER_M: f64 = 2.59;
const STOREY_M: f64 = 2.9;
/// The lower side of the dock's deck and the top of its slabs, m over the sea.
const DECK_M: [f64; 2] = [6.0, 7.2];
/// Two sizes are one if they differ by less, m.
const SAME_M: f64 = 0.01;
/// Height to which hulls are red, and to which their line is white, m over the sea.
const WATERLINE_M: [f64; 2] = [0.8, 1.1];

const CONTAINERS: [DVec3; 6] = [
    DVec3::new(0.70, 0.24, 0.17),
    DVec3::new(0.16, 0.36, 0.58),
    DVec3::new(0.20, 0.47, 0.32),
    DVec3::new(0.86, 0.55, 0.18),
    DVec3::new(0.78, 0.78, 0.74),
    DVec3::new(0.45, 0.22, 0.38),
];
const HULLS: [DVec3; 3] = [
    DVec3::new(0.15, 0.22, 0.36),
    DVec3::new(0.17, 0.32, 0.27),
    DVec3::new(0.24, 0.24, 0.26),
];
const WHITE: DVec3 = DVec3::new(0.93, 0.93, 0.90);
const GLASS: DVec3 = DVec3::new(0.16, 0.22, 0.28);
const BOOT: DVec3 = DVec3::new(0.56, 0.18, 0.14);
const RED: DVec3 = DVec3::new(0.84, 0.34, 0.18);
const CONCRETE: DVec3 = DVec3::new(0.70, 0.68, 0.63);
const WET: DVec3 = DVec3::new(0.26, 0.29, 0.22);
const YELLOW: DVec3 = DVec3::new(0.93, 0.78, 0.26);
const DECK_GREEN: DVec3 = DVec3::new(0.36, 0.46, 0.40);
const BRICK: DVec3 = DVec3::new(0.66, 0.45, 0.36);
const SLATE: DVec3 = DVec3::new(0.48, 0.50, 0.54);
const SAND: DVec3 = DVec3::new(0.80, 0.75, 0.66);

/// What a part is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Material {
    /// Slabs of the dock, with joints.
    Deck,
    /// What carries them.
    Pile,
    Rail,
    Crane,
    /// Of a colour, with a waterline.
    Hull(DVec3),
    /// Storeys with windows, from this height, m.
    House(f64),
    /// Of a colour, corrugated.
    Container(DVec3),
    Mast,
    Shed,
    /// Of a user's model.
    Plain,
}

/// By part.
pub(super) fn materials(mesh: &Mesh) -> Vec<Material> {
    let mut all = vec![Material::Plain; mesh.parts.len()];
    for (number, caster) in mesh.casters.iter().enumerate() {
        for part in caster.parts.clone() {
            let [low, high] = box_of(&mesh.vertices[mesh.parts[part].vertices.clone()]);
            let is_high = |height: f64| ((high.z - low.z) - height).abs() < SAME_M;
            all[part] = match caster.name.as_str() {
                "crane" => Material::Crane,
                "shed" => Material::Shed,
                "dock" if high.z > DECK_M[1] + SAME_M => Material::Rail,
                "dock" if low.z > DECK_M[0] - SAME_M => Material::Deck,
                "dock" => Material::Pile,
                name if !name.contains("ship") => Material::Plain,
                _ if part == caster.parts.start => Material::Hull(HULLS[number % HULLS.len()]),
                _ if is_high(CONTAINER_M) => Material::Container(CONTAINERS[mixed(part)]),
                _ if is_high(STOREY_M) => Material::House(low.z),
                _ => Material::Mast,
            };
        }
    }
    all
}

/// One of the containers' colours, as if by chance.
fn mixed(part: usize) -> usize {
    (part.wrapping_mul(2_654_435_761) >> 7) % CONTAINERS.len()
}

impl Material {
    /// - `place`: m, ENU
    /// - `pixel_m`: width of a pixel there
    pub(super) fn colour(&self, place: DVec3, normal: DVec3, pixel_m: f64) -> DVec3 {
        let is_top = normal.z > 0.5;
        // Along a wall, and along x on what is level.
        let along = match normal.cross(DVec3::Z).try_normalize() {
            Some(level) if !is_top => level.dot(place),
            _ => place.x,
        };
        let lines = |at, period, share| stripes(at, period, share, pixel_m);
        match *self {
            Self::Deck if is_top => CONCRETE * (1.0 - 0.25 * lines(place.x, 1.5, 0.06)),
            Self::Deck => CONCRETE * 0.9,
            Self::Pile => {
                let dry = CONCRETE * 0.85;
                WET.lerp(dry, stripes(place.z - 1.2, 1e3, 0.5, pixel_m))
            }
            Self::Rail => YELLOW,
            Self::Crane => RED.lerp(WHITE, lines(along + place.z, 8.0, 0.25)),
            Self::Hull(_) if is_top => DECK_GREEN * (1.0 - 0.2 * lines(place.x, 12.0, 0.05)),
            Self::Hull(paint) => {
                let [red, line] = WATERLINE_M;
                let plates = paint * (1.0 - 0.12 * lines(place.z, 2.2, 0.08));
                let above = |height: f64| stripes(place.z - height, 1e3, 0.5, pixel_m);
                BOOT.lerp(WHITE, above(red)).lerp(plates, above(line))
            }
            Self::House(_) if is_top => WHITE * 0.92,
            Self::House(floor) => {
                let pane = lines(along, 1.8, 0.65);
                // From 1.1 to 2 m over the floor.
                let row = stripes(place.z - floor - 1.1, 1e3, 9e-4, pixel_m);
                WHITE.lerp(GLASS, pane * row)
            }
            Self::Container(paint) if is_top => paint * 0.95,
            Self::Container(paint) => paint * (1.0 - 0.22 * lines(along, 0.4, 0.5)),
            Self::Mast => WHITE * 0.9,
            Self::Shed if is_top => SLATE * (1.0 - 0.15 * lines(place.x, 1.0, 0.2)),
            Self::Shed => BRICK * (1.0 - 0.15 * lines(place.z, 0.5, 0.15)),
            Self::Plain => SAND,
        }
    }
}

/// Share of a pixel that stripes cover, each the first `share` of a period.
fn stripes(at: f64, period: f64, share: f64, pixel_m: f64) -> f64 {
    let width = pixel_m.max(1e-6);
    let covered = |end: f64| {
        let whole = (end / period).floor();
        period * (whole * share + (end / period - whole).min(share))
    };
    (covered(at + width / 2.0) - covered(at - width / 2.0)) / width
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_casters::{PortSize, port};

    #[test]
    fn every_part_of_the_port_is_made_of_something_and_of_the_right_thing() {
        let mesh = port(PortSize::named("port-m").expect("a port"));
        let all = materials(&mesh);
        let count = |is_it: fn(&Material) -> bool| all.iter().filter(|own| is_it(own)).count();
        assert_eq!(count(|own| *own == Material::Plain), 0);
        assert_eq!(count(|own| *own == Material::Deck), 50);
        assert_eq!(count(|own| matches!(own, Material::Hull(_))), 5);
        assert_eq!(count(|own| matches!(own, Material::House(_))), 25);
        assert!(count(|own| matches!(own, Material::Container(_))) > 500);
        // Negative control: a model of another name.
        let mut mesh = mesh;
        for caster in &mut mesh.casters {
            caster.name = "hut".to_owned();
        }
        assert!(materials(&mesh).iter().all(|own| *own == Material::Plain));
    }

    #[test]
    fn stripes_are_whole_from_near_and_their_mean_from_afar() {
        for (at, covered) in [(0.2, 1.0), (0.7, 0.0), (-0.8, 1.0), (0.5, 0.5)] {
            let found = stripes(at, 1.0, 0.5, 0.01);
            assert!((found - covered).abs() < 1e-12, "{at}: {found}");
        }
        for at in [0.0, 0.3, -7.9] {
            assert!((stripes(at, 1.0, 0.5, 100.0) - 0.5).abs() < 0.01, "{at}");
        }
    }
}
