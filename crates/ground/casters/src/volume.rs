// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadow volumes: the light cap, a side for each silhouette edge, and a dark cap where there is an end.
//!
//! Vertices are homogeneous, (place, 1) or (direction, 0), and shared by index, so that faces that meet
//! have the same bits along their edge. Triangles are wound counter-clockwise seen from outside.

use crate::mesh::index;
use crate::{ConvexPart, Facing, Mesh, Prepared, Side};
use glam::{DVec3, DVec4};
use std::collections::BTreeMap;

/// Radius of the sea, m: the mean radius of the Earth.
pub(crate) const SEA_RADIUS_M: f64 = 6_371_000.0;

/// Where a volume ends.
#[derive(Debug, Clone, PartialEq)]
pub enum Extent {
    /// In the one point away from the light.
    Infinite,
    /// In a plane below the sea or, where the mesh reaches below it, there: z by part, m; see
    /// [`sea_level_below`].
    ClosedAt(Vec<f64>),
    /// After so many metres.
    Finite(f64),
}

/// Which face of a volume a triangle is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Face {
    /// Of the mesh itself, towards the light: triangle of the mesh.
    LightCap(u32),
    /// Between a silhouette edge and its shadow.
    Side,
    /// The end.
    DarkCap,
}

/// A triangle of a volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VolumeTriangle {
    /// Indices of [`Volume::vertices`].
    pub corners: [u32; 3],
    /// Part of the mesh whose volume it is of.
    pub part: u32,
    /// What it is.
    pub face: Face,
}

/// Volumes of all parts of a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Volume {
    /// Homogeneous places.
    pub vertices: Vec<DVec4>,
    /// In the order of caps, sides, dark caps.
    pub triangles: Vec<VolumeTriangle>,
}

/// A light that a kind of volume is not for.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("sun at {found_deg}° elevation: volumes closed at the sea need one above 0°")]
pub struct LightError {
    /// Elevation found.
    pub found_deg: f64,
}

impl Volume {
    /// The volume of a mesh under a directional light.
    ///
    /// - `sides`: silhouette, directed as in the lit triangles
    /// - `to_light`: unit vector
    ///
    /// # Errors
    /// [`LightError`] for volumes closed at the sea under a light that does not come from above.
    pub fn of(
        prepared: &Prepared,
        facing: &Facing,
        sides: &[Side],
        to_light: DVec3,
        extent: &Extent,
    ) -> Result<Self, LightError> {
        let mesh = &prepared.mesh;
        let parts = part_of_vertices(mesh);
        let mut volume = Self {
            vertices: mesh
                .vertices
                .iter()
                .map(|place| place.extend(1.0))
                .collect(),
            triangles: Vec::new(),
        };
        let far = index(volume.vertices.len());
        match extent {
            Extent::Infinite => volume.vertices.push((-to_light).extend(0.0)),
            Extent::Finite(length) => {
                let ends = mesh.vertices.iter();
                let ends = ends.map(|place| (place - to_light * *length).extend(1.0));
                volume.vertices.extend(ends);
            }
            Extent::ClosedAt(levels) => {
                check_above(to_light)?;
                let ends = mesh.vertices.iter().zip(&parts).map(|(place, part)| {
                    // A place below the level stays, or a pile would be cast upwards from its foot. Both
                    // ends then lie below the level, where nothing is seen.
                    let fall = ((place.z - levels[*part as usize]) / to_light.z).max(0.0);
                    (place - to_light * fall).extend(1.0)
                });
                volume.vertices.extend(ends);
            }
        }
        let caps = caps(prepared, facing);
        for &(triangle, corners) in &caps {
            volume.push(&parts, corners, Face::LightCap(triangle));
        }
        for &[a, b] in sides {
            if *extent == Extent::Infinite {
                volume.push(&parts, [b, a, far], Face::Side);
            } else {
                volume.push(&parts, [b, a, a + far], Face::Side);
                volume.push(&parts, [b, a + far, b + far], Face::Side);
            }
        }
        if *extent != Extent::Infinite {
            for (_, [a, b, c]) in caps {
                let end = [a, c, b].map(|corner| corner + far);
                let part = parts[a as usize];
                volume.triangles.push(VolumeTriangle {
                    corners: end,
                    part,
                    face: Face::DarkCap,
                });
            }
        }
        Ok(volume)
    }

    fn push(&mut self, parts: &[u32], corners: [u32; 3], face: Face) {
        self.triangles.push(VolumeTriangle {
            corners,
            part: parts[corners[0] as usize],
            face,
        });
    }

    /// Directed edges that are met more often one way than the other; none in a closed volume.
    #[must_use]
    pub fn open_edges(&self) -> Vec<Side> {
        let mut counts: BTreeMap<Side, i32> = BTreeMap::new();
        for triangle in &self.triangles {
            let [a, b, c] = triangle.corners;
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let way = if from < to { 1 } else { -1 };
                *counts.entry([from.min(to), from.max(to)]).or_default() += way;
            }
        }
        let open = counts.into_iter().filter(|(_, count)| *count != 0);
        open.map(|(edge, _)| edge).collect()
    }
}

/// Lit triangles, or under `robust` all of them, turned towards the light.
pub(crate) fn caps(prepared: &Prepared, facing: &Facing) -> Vec<(u32, [u32; 3])> {
    let triangles = prepared.mesh.triangles.iter().zip(&facing.is_lit);
    let cap = |(at, (&[a, b, c], &is_lit)): (usize, (&[u32; 3], &bool))| match is_lit {
        true => Some((index(at), [a, b, c])),
        false if prepared.is_robust => Some((index(at), [a, c, b])),
        false => None,
    };
    triangles.enumerate().filter_map(cap).collect()
}

pub(crate) fn part_of_vertices(mesh: &Mesh) -> Vec<u32> {
    let mut parts = vec![0; mesh.vertices.len()];
    for (at, part) in mesh.parts.iter().enumerate() {
        parts[part.vertices.clone()].fill(index(at));
    }
    parts
}

fn check_above(to_light: DVec3) -> Result<(), LightError> {
    if to_light.z > 0.0 {
        Ok(())
    } else {
        Err(LightError {
            found_deg: to_light.z.clamp(-1.0, 1.0).asin().to_degrees(),
        })
    }
}

/// For each part, a height below all the curved sea that its shadow can meet.
///
/// The sea drops by D²/2R at distance D from the origin, and D is at most the part's own distance and
/// the shadow's length over the ground. No shadow on the sea is longer than √(2R·height).
///
/// - `margin_m`: below that, for waves and rounding
///
/// # Errors
/// [`LightError`] for a light that does not come from above.
pub fn sea_level_below(
    mesh: &Mesh,
    to_light: DVec3,
    margin_m: f64,
) -> Result<Vec<f64>, LightError> {
    check_above(to_light)?;
    let tan = to_light.z / to_light.truncate().length();
    let level = |part: &ConvexPart| {
        let places = &mesh.vertices[part.vertices.clone()];
        let top = places.iter().map(|place| place.z).fold(0.0, f64::max);
        let away = places.iter().map(|place| place.truncate().length());
        let away = away.fold(0.0, f64::max);
        // Over the tangent plane at the part, whose sea drops by (own distance + way)²/2R.
        let drop = |way: f64| (away + way) * (away + way) / (2.0 * SEA_RADIUS_M);
        let longest = (2.0 * SEA_RADIUS_M * (top + drop(0.0))).sqrt() + away;
        let mut way = 0.0;
        // Rising to its limit, which is the landing place or the longest there can be.
        for _ in 0..64 {
            way = ((top + drop(way)) / tan).min(longest);
        }
        -(drop(way) + margin_m)
    };
    Ok(mesh.parts.iter().map(level).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EdgeTable, Policy, PortSize, by_stack, hull, port};

    fn sun(elevation_deg: f64, azimuth_deg: f64) -> DVec3 {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let (y, x) = azimuth_deg.to_radians().sin_cos();
        DVec3::new(cos * x, cos * y, sin)
    }

    fn volumes(prepared: &Prepared, to_light: DVec3) -> Vec<Volume> {
        let levels = sea_level_below(&prepared.mesh, to_light, 1.0).expect("from above");
        let facing = Facing::of(&prepared.mesh, to_light);
        let sides = EdgeTable::of(&prepared.mesh).sides(prepared, &facing);
        let extents = [
            Extent::Infinite,
            Extent::ClosedAt(levels),
            Extent::Finite(50.0),
        ];
        let volumes =
            extents.map(|extent| Volume::of(prepared, &facing, &sides, to_light, &extent));
        volumes.map(|volume| volume.expect("from above")).into()
    }

    #[test]
    fn every_volume_of_a_closed_mesh_is_closed() {
        for mesh in [port(PortSize::NAMED[0].1), hull(600)] {
            for policy in [Policy::Refuse, Policy::Robust] {
                let prepared = policy.prepare(mesh.clone()).expect("closed");
                for to_light in [sun(60.0, 90.0), sun(5.0, 0.0), sun(0.3, -60.0)] {
                    for volume in volumes(&prepared, to_light) {
                        assert!(volume.triangles.len() > 100);
                        assert_eq!(volume.open_edges(), [] as [Side; 0]);
                    }
                }
            }
        }
    }

    #[test]
    fn the_directed_count_closes_the_volume_of_an_open_and_of_a_flipped_mesh() {
        let mut open = hull(600);
        open.triangles.swap_remove(100);
        open.planes.swap_remove(100);
        open.parts[0].triangles.end -= 1;
        let mut flipped = hull(600);
        flipped.triangles[100].swap(1, 2);
        flipped.normals[flipped.planes[100] as usize] *= -1.0;
        for mesh in [open, flipped] {
            for policy in [Policy::Robust, Policy::AsIs] {
                let prepared = policy.prepare(mesh.clone()).expect("taken");
                for volume in volumes(&prepared, sun(30.0, 20.0)) {
                    assert_eq!(volume.open_edges(), [] as [Side; 0], "{policy:?}");
                }
            }
            assert!(Policy::Refuse.prepare(mesh).is_err());
        }
    }

    #[test]
    fn twins_that_open_a_volume_are_found() {
        let to_light = sun(30.0, 20.0);
        let mesh = port(PortSize::NAMED[0].1);
        let mut prepared = Policy::Refuse.prepare(mesh).expect("closed");
        let facing = Facing::of(&prepared.mesh, to_light);
        let sides = by_stack(&prepared.mesh, &facing);
        let open = |prepared: &Prepared, facing: &Facing, sides: &[Side]| {
            let volume = Volume::of(prepared, facing, sides, to_light, &Extent::Infinite);
            volume.expect("above").open_edges().len()
        };
        assert_eq!(open(&prepared, &facing, &sides), 0);
        // One side dropped, one facing bit that others do not agree on, one lit triangle turned round.
        assert_eq!(open(&prepared, &facing, &sides[1..]), 3);
        let lit = facing.is_lit.iter().position(|is_lit| *is_lit);
        let lit = lit.expect("lit");
        let mut other = facing.clone();
        other.is_lit[lit] = false;
        assert_eq!(open(&prepared, &other, &sides), 3);
        prepared.mesh.triangles[lit].swap(1, 2);
        assert_eq!(open(&prepared, &facing, &sides), 3);
        // The toggle deletes what a flipped lit triangle shares with a lit one: the volume is open.
        let flipped = by_stack(&prepared.mesh, &facing);
        assert!(open(&prepared, &facing, &flipped) > 0);
        let counted = EdgeTable::of(&prepared.mesh).silhouette(&facing);
        assert_eq!(
            open(&prepared, &facing, &counted),
            0,
            "counted, it is closed"
        );
    }

    #[test]
    fn volumes_end_below_the_curved_sea_and_refuse_a_sun_below_it() {
        let mesh = port(PortSize::NAMED[1].1);
        let levels = |to_light| sea_level_below(&mesh, to_light, 1.0);
        let lowest = |to_light| {
            let levels = levels(to_light).expect("above");
            levels.into_iter().fold(0.0, f64::min)
        };
        let (high, low, grazing) = (
            lowest(sun(60.0, 0.0)),
            lowest(sun(1.0, 0.0)),
            lowest(sun(0.01, 0.0)),
        );
        assert!(high < -1.0 && high > -1.1, "{high}");
        assert!(low < high && low > -3.0, "{low}");
        assert!(
            grazing < -40.0 && grazing > -200.0,
            "{grazing}: the longest shadow there is"
        );
        let error = levels(sun(-1.0, 0.0)).expect_err("below");
        assert!(
            error.to_string().starts_with("sun at -1°") || error.to_string().contains("-1.0"),
            "{error}"
        );
        assert!(levels(DVec3::X).is_err());
    }
}
