// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadow volumes of a light at a place: sides run away from it, and the dark cap lies at infinity or beyond its range.
//!
//! A volume that ends at the range must hold all that is dark within it. Ends on the sphere of the range do not: a flat
//! dark cap between them cuts through the sphere. Here each corner of a lit triangle moves away from the light by a
//! factor s ≥ range / (distance of the triangle's nearest place). A place of the dark triangle is k times one of the
//! lit triangle, where k is a mean of the corners' factors. So it lies at the range or beyond.

use crate::mesh::index;
use crate::volume::{Face, caps, part_of_vertices};
use crate::{Facing, Mesh, Prepared, Side, Volume, VolumeTriangle};
use glam::{DVec3, DVec4};

/// Ends lie beyond the range by this factor: places are rounded to `f32` on devices, by 10⁻⁷ of their size.
const BEYOND: f64 = 1.001;

/// Where the volume of a light at a place ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// Nowhere: the ends are directions.
    Infinite,
    /// Beyond a range, m. It holds all that is dark within the range.
    Range(f64),
    /// Each corner at the range, m: too short between corners.
    OnSphere(f64),
}

impl Facing {
    /// One sign a plane, towards a place; a plane through the place is not lit.
    #[must_use]
    pub fn towards(mesh: &Mesh, place: DVec3) -> Self {
        let mut lit = vec![None; mesh.normals.len()];
        let of = |(triangle, &plane): (usize, &u32)| {
            let plane = plane as usize;
            *lit[plane].get_or_insert_with(|| {
                let [corner, ..] = mesh.corners(triangle);
                mesh.normals[plane].dot(place - corner) > 0.0
            })
        };
        Self {
            is_lit: mesh.planes.iter().enumerate().map(of).collect(),
        }
    }
}

impl Volume {
    /// The volumes of a mesh under a light at a place. Parts beyond its reach have none.
    ///
    /// - `sides`: silhouette, directed as in the lit triangles
    /// - `light`: m, outside of every part
    #[must_use]
    pub fn of_lamp(
        prepared: &Prepared,
        facing: &Facing,
        sides: &[Side],
        light: DVec3,
        reach: Reach,
    ) -> Self {
        let mesh = &prepared.mesh;
        let parts = part_of_vertices(mesh);
        let caps = caps(prepared, facing);
        let mut nearest = vec![f64::INFINITY; mesh.parts.len()];
        let mut factors = vec![1.0_f64; mesh.vertices.len()];
        for &(_, corners) in &caps {
            let away = distance(light, corners.map(|corner| mesh.vertices[corner as usize]));
            let part = &mut nearest[parts[corners[0] as usize] as usize];
            *part = part.min(away);
            if let Reach::Range(range) = reach {
                for corner in corners {
                    let factor = &mut factors[corner as usize];
                    *factor = factor.max(BEYOND * range / away);
                }
            }
        }
        let end = |(&place, factor): (&DVec3, &f64)| -> DVec4 {
            let along = place - light;
            match reach {
                Reach::Infinite => along.extend(0.0),
                Reach::Range(_) => (light + along * *factor).extend(1.0),
                Reach::OnSphere(range) => {
                    (light + along * (range / along.length()).max(1.0)).extend(1.0)
                }
            }
        };
        let places = mesh.vertices.iter();
        let ends = places.clone().zip(&factors).map(end);
        let vertices = places.map(|place| place.extend(1.0)).chain(ends);
        let is_reached = |vertex: u32| match reach {
            Reach::Infinite => true,
            Reach::Range(range) | Reach::OnSphere(range) => {
                nearest[parts[vertex as usize] as usize] < range
            }
        };
        let far = index(mesh.vertices.len());
        let mut volume = Self {
            vertices: vertices.collect(),
            triangles: Vec::new(),
        };
        let mut push = |first: u32, corners, face| {
            let part = parts[first as usize];
            volume.triangles.push(VolumeTriangle {
                corners,
                part,
                face,
            });
        };
        let caps = caps.into_iter().filter(|(_, [a, ..])| is_reached(*a));
        let caps: Vec<_> = caps.collect();
        for &(triangle, corners) in &caps {
            push(corners[0], corners, Face::LightCap(triangle));
        }
        for &[a, b] in sides.iter().filter(|[a, _]| is_reached(*a)) {
            push(a, [b, a, a + far], Face::Side);
            push(a, [b, a + far, b + far], Face::Side);
        }
        for (_, [a, b, c]) in caps {
            push(a, [a, c, b].map(|corner| corner + far), Face::DarkCap);
        }
        volume
    }
}

/// Distance of a triangle from a place, m (Ericson, 2005, §5.1.5).
fn distance(from: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let [a, b, c] = [a - from, b - from, c - from];
    let normal = (b - a).cross(c - a);
    let is_over = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(from, to)| (*to - *from).cross(-*from).dot(normal) >= 0.0);
    if is_over && normal != DVec3::ZERO {
        return normal.dot(a).abs() / normal.length();
    }
    let to_edge = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let share =
            (-from.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (from + along * share).length()
    };
    let edges = [(a, b), (b, c), (c, a)].map(to_edge);
    edges.into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EdgeTable, Policy, PortSize, hull, port};

    const LIGHT: DVec3 = DVec3::new(-118.0, -9.0, 33.0);
    const RANGE: f64 = 90.0;

    fn volume(prepared: &Prepared, light: DVec3, reach: Reach) -> Volume {
        let facing = Facing::towards(&prepared.mesh, light);
        let sides = EdgeTable::of(&prepared.mesh).sides(prepared, &facing);
        Volume::of_lamp(prepared, &facing, &sides, light, reach)
    }

    #[test]
    fn every_volume_of_a_lamp_is_closed_and_one_without_a_side_is_not() {
        for mesh in [port(PortSize::NAMED[1].1), hull(600)] {
            for policy in [Policy::Refuse, Policy::Robust] {
                let prepared = policy.prepare(mesh.clone()).expect("closed");
                for reach in [Reach::Infinite, Reach::Range(RANGE), Reach::OnSphere(RANGE)] {
                    let mut volume = volume(&prepared, LIGHT, reach);
                    assert!(volume.triangles.len() > 30, "{reach:?}");
                    assert_eq!(volume.open_edges(), [] as [Side; 0], "{reach:?}");
                    // Negative control.
                    let side = volume
                        .triangles
                        .iter()
                        .position(|own| own.face == Face::Side);
                    volume.triangles.remove(side.expect("a side"));
                    assert_eq!(volume.open_edges().len(), 3);
                }
            }
        }
    }

    #[test]
    fn no_place_of_a_dark_cap_lies_within_the_range_unless_ends_lie_on_its_sphere() {
        let prepared = Policy::Refuse
            .prepare(port(PortSize::NAMED[1].1))
            .expect("closed");
        let nearest = |reach| {
            let volume = volume(&prepared, LIGHT, reach);
            let ends = volume
                .triangles
                .iter()
                .filter(|own| own.face == Face::DarkCap);
            let corners = |own: &VolumeTriangle| {
                own.corners
                    .map(|corner| volume.vertices[corner as usize].truncate())
            };
            let away = ends.map(|own| distance(LIGHT, corners(own)));
            away.fold(f64::INFINITY, f64::min)
        };
        assert!(nearest(Reach::Range(RANGE)) >= RANGE);
        // Negative control.
        assert!(nearest(Reach::OnSphere(RANGE)) < 0.9 * RANGE);
    }

    #[test]
    fn a_triangle_is_as_far_as_its_face_its_edge_or_its_corner() {
        let triangle = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        let away = |x, y, z| distance(DVec3::new(x, y, z), triangle);
        assert!((away(1.0, 1.0, 3.0) - 3.0).abs() < 1e-12);
        assert!((away(2.0, -3.0, 4.0) - 5.0).abs() < 1e-12);
        assert!((away(-3.0, -4.0, 12.0) - 13.0).abs() < 1e-12);
        assert!((away(3.0, 3.0, 0.0) - 2.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_face_is_lit_from_its_own_side() {
        let mesh = hull(600);
        let facing = Facing::towards(&mesh, DVec3::Z * 500.0);
        let far = Facing::of(&mesh, DVec3::Z);
        let apart = facing
            .is_lit
            .iter()
            .zip(&far.is_lit)
            .filter(|(a, b)| a != b);
        assert!(apart.count() < mesh.triangles.len() / 4);
        let below = Facing::towards(&mesh, DVec3::Z * -500.0);
        let both = facing
            .is_lit
            .iter()
            .zip(&below.is_lit)
            .filter(|(a, b)| **a && **b);
        assert!(both.count() < mesh.triangles.len() / 4);
    }
}
