// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is done with a mesh that is not closed.

use crate::mesh::{fan_normal, index};
use crate::verdict::{part_edges, welded};
use crate::{ConvexPart, Mesh, MeshError, verdict};
use glam::DVec3;
use std::collections::BTreeMap;

/// A border loop counts as planar within this share of its extent. Places in a file are often `f32`,
/// whose step is 6·10⁻⁸ of them, and several of them decide the loop's plane.
const PLANAR_SHARE: f64 = 1e-6;

/// See [`Policy::prepare`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Policy {
    /// A mesh that is not closed is an error.
    Refuse,
    /// Planar border loops are closed by a face; whatever else is wrong is an error.
    Cap,
    /// Every triangle is turned towards the light and casts: each layer of a closed mesh counts twice.
    Robust,
    /// Taken as it is, to show what leaks.
    AsIs,
}

/// A mesh as it is to cast.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// With caps where the policy adds them.
    pub mesh: Mesh,
    /// Whether every triangle casts, see [`Policy::Robust`].
    pub is_robust: bool,
}

impl Policy {
    /// Every policy.
    pub const ALL: [Self; 4] = [Self::Refuse, Self::Cap, Self::Robust, Self::AsIs];

    /// `refuse`, `cap`, `robust` or `as-is`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Refuse => "refuse",
            Self::Cap => "cap",
            Self::Robust => "robust",
            Self::AsIs => "as-is",
        }
    }

    /// The mesh as it is to cast under this policy.
    ///
    /// # Errors
    /// [`MeshError::Refused`] with what is wrong and where.
    pub fn prepare(self, mut mesh: Mesh) -> Result<Prepared, MeshError> {
        weld(&mut mesh);
        if self == Self::Cap {
            cap(&mut mesh);
        }
        let found = verdict(&mesh);
        if matches!(self, Self::Refuse | Self::Cap) && !found.is_closed() {
            return Err(MeshError::Refused {
                verdict: found.to_string(),
                policy: self.name(),
            });
        }
        Ok(Prepared {
            mesh,
            is_robust: self == Self::Robust,
        })
    }
}

/// Closes the planar border loops of every part whose vertices are its own.
fn cap(mesh: &mut Mesh) {
    let mut triangles = Vec::new();
    let mut planes = Vec::new();
    for at in 0..mesh.parts.len() {
        let part = mesh.parts[at].clone();
        let begin = triangles.len();
        triangles.extend_from_slice(&mesh.triangles[part.triangles.clone()]);
        planes.extend_from_slice(&mesh.planes[part.triangles.clone()]);
        for ring in planar_loops(mesh, &part) {
            let ring = from_where_a_fan_has_area(mesh, ring);
            let plane = index(mesh.normals.len());
            mesh.normals.push(normal(mesh, &ring));
            for at in 1..ring.len() - 1 {
                // A fan in one plane with one facing bit: triangles that overlap where the loop is not
                // convex are wound against each other and cancel.
                triangles.push([ring[0], ring[at], ring[at + 1]]);
                planes.push(plane);
            }
        }
        mesh.parts[at].triangles = begin..triangles.len();
    }
    mesh.triangles = triangles;
    mesh.planes = planes;
}

/// The same loop from a corner whose fan has no triangle without area, if there is one: corners of a loop often lie in
/// line.
fn from_where_a_fan_has_area(mesh: &Mesh, mut ring: Vec<u32>) -> Vec<u32> {
    let place = |at: u32| mesh.vertices[at as usize];
    let has_area = |ring: &[u32]| {
        let spokes = ring.windows(2).skip(1).map(|edge| {
            let start = place(ring[0]);
            (place(edge[0]) - start).cross(place(edge[1]) - start)
        });
        spokes.into_iter().all(|area| area != DVec3::ZERO)
    };
    for _ in 0..ring.len() {
        if has_area(&ring) {
            break;
        }
        ring.rotate_left(1);
    }
    ring
}

fn normal(mesh: &Mesh, ring: &[u32]) -> DVec3 {
    let places: Vec<DVec3> = ring.iter().map(|at| mesh.vertices[*at as usize]).collect();
    fan_normal(&places)
}

/// Simple planar loops along a part's border, wound against it.
fn planar_loops(mesh: &Mesh, part: &ConvexPart) -> Vec<Vec<u32>> {
    let mut next = BTreeMap::new();
    for ([low, high], met) in part_edges(mesh, part) {
        let [from, to] = match met {
            [1, 0] => [high, low],
            [0, 1] => [low, high],
            _ => continue,
        };
        if next.insert(from, to).is_some() {
            // Loops that touch: which way on is anyone's guess.
            return Vec::new();
        }
    }
    let mut loops = Vec::new();
    while let Some((start, mut at)) = next.pop_first() {
        let mut ring = vec![start];
        while at != start {
            ring.push(at);
            let Some(after) = next.remove(&at) else { break };
            at = after;
        }
        if at == start && is_planar(mesh, &ring) {
            loops.push(ring);
        }
    }
    loops
}

fn is_planar(mesh: &Mesh, ring: &[u32]) -> bool {
    let up = normal(mesh, ring).normalize_or_zero();
    let start = mesh.vertices[ring[0] as usize];
    let offsets = ring.iter().map(|at| mesh.vertices[*at as usize] - start);
    let offsets: Vec<DVec3> = offsets.collect();
    let extent = offsets
        .iter()
        .map(|offset| offset.length())
        .fold(0.0, f64::max);
    up != DVec3::ZERO
        && offsets
            .iter()
            .all(|offset| offset.dot(up).abs() <= PLANAR_SHARE * extent)
}

/// The same mesh whose vertices of equal bits are one, so that its edges meet.
fn weld(mesh: &mut Mesh) {
    for part in mesh.parts.clone() {
        let start = index(part.vertices.start);
        let equals = welded(&mesh.vertices[part.vertices.clone()]);
        for corners in &mut mesh.triangles[part.triangles] {
            *corners = corners.map(|corner| equals[(corner - start) as usize] + start);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PortSize;
    use crate::port;

    /// A box without its lid, or with its lid's corner bent up.
    fn open_box(bend: f64) -> Mesh {
        let ring = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]];
        let ring = ring.map(|[x, y]| DVec3::new(x, y, 0.0));
        let mut mesh = Mesh::default();
        mesh.begin("box");
        mesh.push_prism(&ring, DVec3::Z);
        // The first face of a prism is its top.
        mesh.triangles.drain(..2);
        mesh.planes.drain(..2);
        mesh.parts[0].triangles = 0..10;
        mesh.vertices[6].z += bend;
        mesh
    }

    #[test]
    fn a_missing_lid_is_refused_capped_or_taken() {
        let open = open_box(0.0);
        let error = Policy::Refuse.prepare(open.clone()).expect_err("open");
        let text = error.to_string();
        assert!(
            text.starts_with("border 4 edges") && text.ends_with("refused by policy refuse"),
            "{text}"
        );
        let capped = Policy::Cap.prepare(open.clone()).expect("capped");
        assert_eq!(capped.mesh.triangles.len(), 12);
        assert!(verdict(&capped.mesh).is_closed());
        let lid = capped.mesh.normals[capped.mesh.planes[10] as usize];
        assert!(lid.z > 0.0 && lid.truncate().length() == 0.0, "{lid}");
        assert!(
            Policy::Robust
                .prepare(open.clone())
                .is_ok_and(|mesh| mesh.is_robust)
        );
        assert!(Policy::AsIs.prepare(open).is_ok_and(|mesh| !mesh.is_robust));
    }

    #[test]
    fn a_bent_border_and_a_flipped_face_are_not_capped() {
        assert!(Policy::Cap.prepare(open_box(0.1)).is_err());
        let mut flipped = port(PortSize::NAMED[0].1);
        assert!(
            Policy::Cap.prepare(flipped.clone()).is_ok(),
            "closed as it is"
        );
        flipped.triangles[0].swap(0, 1);
        assert!(Policy::Cap.prepare(flipped).is_err());
    }

    #[test]
    fn a_soup_of_triangles_is_welded_by_equal_bits() {
        let (vertices, triangles) = crate::verdict::tests::tetrahedron();
        let places = triangles.iter().flatten().map(|at| vertices[*at as usize]);
        let soup = (0..4).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        let mut mesh = Mesh::from_triangles("soup", places.collect(), soup).expect("finite");
        let used = |mesh: &Mesh| {
            let mut used: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
            used.sort_unstable();
            used.dedup();
            used.len()
        };
        assert_eq!(used(&mesh), 12);
        weld(&mut mesh);
        assert_eq!(used(&mesh), 4);
    }
}
