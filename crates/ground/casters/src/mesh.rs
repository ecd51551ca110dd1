// SPDX-License-Identifier: MIT OR Apache-2.0
//! A mesh of convex parts, each face of which has one plane.
//!
//! Triangles are wound counter-clockwise seen from outside. Parts share no vertices.

use glam::DVec3;
use std::ops::Range;

/// A convex part: contiguous vertices and triangles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConvexPart {
    /// Of [`Mesh::vertices`].
    pub vertices: Range<usize>,
    /// Of [`Mesh::triangles`].
    pub triangles: Range<usize>,
}

/// One model, such as a ship: parts that follow one another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Caster {
    /// `dock`, `crane`, `moored ship`.
    pub name: String,
    /// Of [`Mesh::parts`].
    pub parts: Range<usize>,
}

/// Why triangles are no mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A vertex that is not a place.
    #[error("vertex {vertex} of triangle {triangle} is ({x}, {y}, {z}), allowed: finite numbers")]
    NotFinite {
        /// Which triangle.
        triangle: usize,
        /// Index of the vertex.
        vertex: u32,
        /// East.
        x: f64,
        /// North.
        y: f64,
        /// Up.
        z: f64,
    },
    /// An index that names no vertex.
    #[error("triangle {triangle} names vertex {found}, there are {count}")]
    NoSuchVertex {
        /// Which triangle.
        triangle: usize,
        /// Index found.
        found: u32,
        /// Vertices.
        count: usize,
    },
    /// A mesh that the policy does not take.
    #[error("{verdict}: refused by policy {policy}")]
    Refused {
        /// What is wrong, see [`crate::Verdict`].
        verdict: String,
        /// Policy's name.
        policy: &'static str,
    },
}

/// Triangles in space with planes, parts and models.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Places, m.
    pub vertices: Vec<DVec3>,
    /// Indices of vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Of each triangle: its plane.
    pub planes: Vec<u32>,
    /// Outward normal of each plane, of any length.
    pub normals: Vec<DVec3>,
    /// Convex parts.
    pub parts: Vec<ConvexPart>,
    /// Models.
    pub casters: Vec<Caster>,
}

impl Mesh {
    /// One model of one part, from triangles as a file has them; each triangle is its own plane.
    ///
    /// # Errors
    /// [`MeshError::NoSuchVertex`], [`MeshError::NotFinite`].
    pub fn from_triangles(
        name: &str,
        vertices: Vec<DVec3>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, MeshError> {
        for (triangle, corners) in triangles.iter().enumerate() {
            for &vertex in corners {
                let count = vertices.len();
                let place = vertices
                    .get(vertex as usize)
                    .ok_or(MeshError::NoSuchVertex {
                        triangle,
                        found: vertex,
                        count,
                    })?;
                if !place.is_finite() {
                    let [x, y, z] = place.to_array();
                    return Err(MeshError::NotFinite {
                        triangle,
                        vertex,
                        x,
                        y,
                        z,
                    });
                }
            }
        }
        let mut mesh = Self::default();
        mesh.begin(name);
        mesh.push_part(vertices, triangles.len(), |mesh, first| {
            for [a, b, c] in triangles {
                mesh.push_face(&[first + a, first + b, first + c]);
            }
        });
        Ok(mesh)
    }

    /// Begins a model, to which the parts pushed from now on belong.
    pub(crate) fn begin(&mut self, name: &str) {
        self.casters.push(Caster {
            name: name.to_owned(),
            parts: self.parts.len()..self.parts.len(),
        });
    }

    pub(crate) fn push_part(
        &mut self,
        vertices: Vec<DVec3>,
        expected: usize,
        faces: impl FnOnce(&mut Self, u32),
    ) {
        let (first, triangles) = (self.vertices.len(), self.triangles.len());
        self.vertices.extend(vertices);
        self.triangles.reserve(expected);
        faces(self, index(first));
        self.parts.push(ConvexPart {
            vertices: first..self.vertices.len(),
            triangles: triangles..self.triangles.len(),
        });
        let past = self.parts.len();
        if let Some(caster) = self.casters.last_mut() {
            caster.parts.end = past;
        }
    }

    /// A convex polygon as a fan, in one plane.
    pub(crate) fn push_face(&mut self, ring: &[u32]) {
        let plane = index(self.normals.len());
        let places: Vec<DVec3> = ring.iter().map(|at| self.vertices[*at as usize]).collect();
        self.normals.push(fan_normal(&places));
        for at in 1..ring.len() - 1 {
            self.triangles.push([ring[0], ring[at], ring[at + 1]]);
            self.planes.push(plane);
        }
    }

    /// A closed prism: `ring`, a convex polygon, and the same moved by `along`.
    pub(crate) fn push_prism(&mut self, ring: &[DVec3], along: DVec3) {
        let count = index(ring.len());
        let mut base = ring.to_vec();
        if fan_normal(ring).dot(along) < 0.0 {
            base.reverse();
        }
        let ends = base.iter().map(|place| *place + along);
        let vertices: Vec<DVec3> = base.iter().copied().chain(ends).collect();
        self.push_part(vertices, 4 * ring.len() - 4, |mesh, first| {
            let top: Vec<u32> = (0..count).map(|at| first + count + at).collect();
            let bottom: Vec<u32> = (0..count).rev().map(|at| first + at).collect();
            mesh.push_face(&top);
            mesh.push_face(&bottom);
            for at in 0..count {
                let next = (at + 1) % count;
                mesh.push_face(&[
                    first + at,
                    first + next,
                    first + count + next,
                    first + count + at,
                ]);
            }
        });
    }

    /// Adds another mesh's models, moved.
    pub(crate) fn append(&mut self, other: &Self, by: DVec3) {
        let (vertex, triangle) = (self.vertices.len(), self.triangles.len());
        let (plane, part) = (index(self.normals.len()), self.parts.len());
        self.vertices
            .extend(other.vertices.iter().map(|place| *place + by));
        let moved = |corners: &[u32; 3]| corners.map(|corner| corner + index(vertex));
        self.triangles.extend(other.triangles.iter().map(moved));
        self.planes
            .extend(other.planes.iter().map(|own| own + plane));
        self.normals.extend(&other.normals);
        self.parts.extend(other.parts.iter().map(|own| ConvexPart {
            vertices: own.vertices.start + vertex..own.vertices.end + vertex,
            triangles: own.triangles.start + triangle..own.triangles.end + triangle,
        }));
        self.casters.extend(other.casters.iter().map(|own| Caster {
            name: own.name.clone(),
            parts: own.parts.start + part..own.parts.end + part,
        }));
    }

    /// Corners of a triangle.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.vertices[corner as usize])
    }

    /// Part of each triangle.
    #[must_use]
    pub fn part_of_triangles(&self) -> Vec<u32> {
        let mut parts = vec![0; self.triangles.len()];
        for (at, part) in self.parts.iter().enumerate() {
            parts[part.triangles.clone()].fill(index(at));
        }
        parts
    }
}

/// Normal of a polygon, twice its area long: the sum over a fan from its first place.
pub(crate) fn fan_normal(ring: &[DVec3]) -> DVec3 {
    let spokes = ring.iter().map(|place| *place - ring[0]);
    let next = spokes.clone().skip(1);
    spokes.zip(next).map(|(a, b)| a.cross(b)).sum()
}

/// Meshes have fewer than 2³² of anything: their indices are `u32`.
#[allow(
    clippy::cast_possible_truncation,
    reason = "a mesh of 2³² vertices does not fit in memory that its indices can address"
)]
pub(crate) fn index(at: usize) -> u32 {
    at as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prism_has_one_plane_a_face_and_normals_outward() {
        for along in [DVec3::Z, -DVec3::Z] {
            let ring = [DVec3::ZERO, DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y];
            let mut mesh = Mesh::default();
            mesh.begin("box");
            mesh.push_prism(&ring, along);
            assert_eq!((mesh.triangles.len(), mesh.normals.len()), (12, 6));
            let middle = DVec3::new(0.5, 0.5, 0.5 * along.z);
            for (triangle, plane) in mesh.planes.iter().enumerate() {
                let [a, ..] = mesh.corners(triangle);
                assert!(mesh.normals[*plane as usize].dot(a - middle) > 0.0);
            }
            assert_eq!(mesh.casters[0].parts, 0..1);
        }
    }

    #[test]
    fn places_that_are_none_are_refused_with_where() {
        let mut vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let missing = Mesh::from_triangles("a", vertices.clone(), vec![[0, 1, 3]]);
        assert!(missing.is_err_and(|error| error.to_string().contains("vertex 3, there are 3")));
        assert!(Mesh::from_triangles("a", vertices.clone(), vec![[0, 1, 2]]).is_ok());
        vertices[2].y = f64::NAN;
        let error = Mesh::from_triangles("a", vertices, vec![[0, 1, 2]]);
        assert!(error.is_err_and(|error| error.to_string().contains("(0, NaN, 0)")));
    }
}
