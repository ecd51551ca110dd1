// SPDX-License-Identifier: MIT OR Apache-2.0
//! Casters without what lies under the sea: nothing there is seen, and its volumes are written all the same.

use crate::mesh::index;
use crate::volume::SEA_RADIUS_M;
use crate::{ConvexPart, Mesh, MeshError, Policy, Prepared, verdict};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// For each part, a height below all the curved sea that it stands in: z, m.
///
/// The sea lies D²/2R below the tangent plane at distance D from the origin.
///
/// - `margin_m`: below that, for waves and rounding
#[must_use]
pub fn feet_below_sea(mesh: &Mesh, margin_m: f64) -> Vec<f64> {
    let level = |part: &ConvexPart| {
        let places = mesh.vertices[part.vertices.clone()].iter();
        let away = places.map(|place| place.truncate().length_squared());
        -(away.fold(0.0, f64::max) / (2.0 * SEA_RADIUS_M) + margin_m)
    };
    mesh.parts.iter().map(level).collect()
}

/// A part while it is cut: its own vertices, those on its cut edges, and where they came from.
#[derive(Default)]
struct Cut {
    vertices: Vec<DVec3>,
    /// By index in the whole mesh; those of the edge between two, lower index first.
    kept: HashMap<[u32; 2], u32>,
}

impl Cut {
    /// The vertex that stands for an edge's crossing, or for a vertex where both ends are the same.
    fn vertex(&mut self, key: [u32; 2], place: impl FnOnce() -> DVec3) -> u32 {
        let Self { vertices, kept } = self;
        *kept.entry(key).or_insert_with(|| {
            vertices.push(place());
            index(vertices.len() - 1)
        })
    }

    /// What is left of a triangle: its corners at `level` and above, and where its edges cross it.
    fn ring(&mut self, mesh: &Mesh, corners: [u32; 3], level: f64) -> Vec<u32> {
        let place = |at: u32| mesh.vertices[at as usize];
        let is_kept = |at: u32| place(at).z >= level;
        let mut ring = Vec::with_capacity(4);
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (corners[a], corners[b])) {
            if is_kept(from) {
                ring.push(self.vertex([from; 2], || place(from)));
            }
            // A corner at the level itself is kept and is no crossing.
            let on = |at: u32| place(at).z.to_bits() == level.to_bits();
            if is_kept(from) != is_kept(to) && !on(from) && !on(to) {
                // From the lower index, so that both triangles of an edge have the same bits.
                let [a, b] = [from.min(to), from.max(to)];
                ring.push(self.vertex([a, b], || {
                    let (a, b) = (place(a), place(b));
                    let flat = a.truncate().lerp(b.truncate(), (level - a.z) / (b.z - a.z));
                    flat.extend(level)
                }));
            }
        }
        ring
    }
}

impl Prepared {
    /// The same without what lies below these heights, closed there again; parts wholly below are left out.
    ///
    /// A mesh that is not closed stays as it is.
    ///
    /// - `levels`: z by part, m
    ///
    /// # Errors
    /// [`MeshError::Refused`] where the cut is no simple loop, or leaves a triangle without area.
    pub fn cut_below(&self, levels: &[f64]) -> Result<Self, MeshError> {
        let whole = &self.mesh;
        if self.is_robust || !verdict(whole).is_closed() {
            return Ok(self.clone());
        }
        let mut mesh = Mesh {
            normals: whole.normals.clone(),
            ..Mesh::default()
        };
        for caster in &whole.casters {
            mesh.begin(&caster.name);
            for at in caster.parts.clone() {
                push_cut(&mut mesh, whole, &whole.parts[at], levels[at]);
            }
        }
        Policy::Cap.prepare(mesh)
    }
}

/// A part's vertices with those below `level` moved up to it, each along the one edge that leads there.
///
/// Walls stay in their planes, and no triangle is added. `None` where a vertex has no such edge or several, or where a
/// face wholly below is not level: then triangles must be cut.
fn moved_up(mesh: &Mesh, part: &ConvexPart, level: f64) -> Option<Vec<DVec3>> {
    let first = part.vertices.start;
    let mut places = mesh.vertices[part.vertices.clone()].to_vec();
    let mut is_used = vec![false; places.len()];
    let mut planes: HashMap<[u32; 2], u32> = HashMap::new();
    let mut upper: Vec<Option<u32>> = vec![None; places.len()];
    let is_below = |at: u32| mesh.vertices[at as usize].z < level;
    for triangle in part.triangles.clone() {
        let ([a, b, c], plane) = (mesh.triangles[triangle], mesh.planes[triangle]);
        let is_level = mesh.normals[plane as usize].truncate() == DVec2::ZERO;
        if [a, b, c].into_iter().all(is_below) && !is_level {
            return None;
        }
        for (from, to) in [(a, b), (b, c), (c, a)] {
            is_used[from as usize - first] = true;
            let edge = [from.min(to), from.max(to)];
            // An edge between triangles of one plane is none of the body.
            let is_of_body = planes
                .insert(edge, plane)
                .is_some_and(|other| other != plane);
            let (low, high) = if is_below(from) {
                (from, to)
            } else {
                (to, from)
            };
            if is_of_body && is_below(low) && !is_below(high) {
                let known = upper[low as usize - first].replace(high);
                if known.is_some() {
                    return None;
                }
            }
        }
    }
    for (at, place) in places.iter_mut().enumerate() {
        if is_used[at] && place.z < level {
            let up = mesh.vertices[upper[at]? as usize];
            let flat = place
                .truncate()
                .lerp(up.truncate(), (level - place.z) / (up.z - place.z));
            *place = flat.extend(level);
        }
    }
    Some(places)
}

/// What is left of a part, open where triangles are cut.
fn push_cut(mesh: &mut Mesh, whole: &Mesh, part: &ConvexPart, level: f64) {
    let mut places = whole.vertices[part.vertices.clone()].iter();
    if places.any(|place| place.z > level)
        && let Some(places) = moved_up(whole, part, level)
    {
        let first = index(part.vertices.start);
        mesh.push_part(places, part.triangles.len(), |mesh, own| {
            for triangle in part.triangles.clone() {
                let corners = whole.triangles[triangle].map(|corner| corner - first + own);
                mesh.triangles.push(corners);
                mesh.planes.push(whole.planes[triangle]);
            }
        });
        return;
    }
    let mut cut = Cut::default();
    let mut triangles = Vec::with_capacity(part.triangles.len());
    for triangle in part.triangles.clone() {
        let ring = cut.ring(whole, whole.triangles[triangle], level);
        for at in 1..ring.len().saturating_sub(1) {
            triangles.push(([ring[0], ring[at], ring[at + 1]], whole.planes[triangle]));
        }
    }
    // A face in the level itself, all of whose part lies below, would be a part of no height.
    let is_above = |place: &DVec3| place.z > level;
    if triangles.is_empty() || !cut.vertices.iter().any(is_above) {
        return;
    }
    mesh.push_part(cut.vertices, triangles.len(), |mesh, first| {
        for (corners, plane) in triangles {
            mesh.triangles.push(corners.map(|corner| corner + first));
            mesh.planes.push(plane);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EdgeTable, Extent, Facing, PortSize, Volume, hull, port};

    fn prepared(mesh: Mesh) -> Prepared {
        Policy::Refuse.prepare(mesh).expect("closed")
    }

    #[test]
    fn a_port_is_cut_at_its_feet_and_closed_again() {
        let whole = prepared(port(PortSize::NAMED[0].1));
        let levels = feet_below_sea(&whole.mesh, 1.0);
        assert!(levels.iter().all(|level| (-1.1..=-1.0).contains(level)));
        let cut = whole.cut_below(&levels).expect("closed");
        assert!(verdict(&cut.mesh).is_closed());
        assert_eq!(cut.mesh.parts.len(), whole.mesh.parts.len());
        let lowest = |mesh: &Mesh| {
            mesh.vertices
                .iter()
                .map(|place| place.z)
                .fold(0.0, f64::min)
        };
        assert_eq!(lowest(&whole.mesh).to_bits(), f64::to_bits(-12.0));
        assert!(lowest(&cut.mesh) > -1.1, "{}", lowest(&cut.mesh));
        // What stands above is where it was.
        let above = |mesh: &Mesh| {
            let places = mesh.vertices.iter().filter(|place| place.z > 0.0);
            let mut bits: Vec<_> = places
                .map(|place| place.to_array().map(f64::to_bits))
                .collect();
            bits.sort_unstable();
            bits
        };
        assert_eq!(above(&cut.mesh), above(&whole.mesh));
        assert_eq!(cut.mesh.triangles.len(), whole.mesh.triangles.len());
        // Each face keeps its plane, and with it its facing.
        for (corners, plane) in cut.mesh.triangles.iter().zip(&cut.mesh.planes) {
            let [a, b, c] = corners.map(|corner| cut.mesh.vertices[corner as usize]);
            let normal = cut.mesh.normals[*plane as usize].normalize();
            let own = (b - a).cross(c - a).normalize();
            assert!(own.dot(normal) > 1.0 - 1e-9, "{own} beside {normal}");
        }
    }

    #[test]
    fn volumes_of_cut_casters_are_closed() {
        let whole = prepared(hull(600));
        let cut = whole
            .cut_below(&feet_below_sea(&whole.mesh, 1.0))
            .expect("closed");
        assert!(cut.mesh.vertices.len() < whole.mesh.vertices.len());
        let to_light = DVec3::new(0.3, -0.4, 0.5).normalize();
        let facing = Facing::of(&cut.mesh, to_light);
        let sides = EdgeTable::of(&cut.mesh).sides(&cut, &facing);
        let volume = Volume::of(&cut, &facing, &sides, to_light, &Extent::Infinite);
        assert!(volume.expect("from above").open_edges().is_empty());
    }

    #[test]
    fn what_reaches_the_level_stays_and_what_lies_below_it_goes() {
        let whole = prepared(port(PortSize::NAMED[0].1));
        let parts = whole.mesh.parts.len();
        let cut = |level: f64| whole.cut_below(&vec![level; parts]).expect("simple").mesh;
        assert!(cut(100.0).triangles.is_empty());
        // Piles end at 5 m, where beams begin: a level through corners.
        let at_beams = cut(5.0);
        assert!(verdict(&at_beams).is_closed());
        assert!(at_beams.parts.len() < parts);
        assert_eq!(cut(-12.0).triangles.len(), whole.mesh.triangles.len());
    }

    #[test]
    fn a_mesh_that_need_not_be_closed_stays() {
        let robust = Policy::Robust.prepare(hull(100)).expect("any");
        let same = robust.cut_below(&feet_below_sea(&robust.mesh, 1.0));
        assert_eq!(same, Ok(robust));
    }
}
