// SPDX-License-Identifier: MIT OR Apache-2.0
//! Casters for shaders that find their silhouettes: what each way of finding them reads.
//!
//! One facing bit a triangle, decided by the CPU in `f64`, is what all of them share. Two ways compute the
//! facing in `f32` instead, as engines do, from corners in the order in which they have them. There the edges
//! of one triangle may disagree where it is edge-on.

use crate::way::{DeviceWay, Silhouettes};
use crate::work::{End, Scene};
use terrafill_casters::{EdgeTable, Mesh, Side, Volume};
use terrafill_shadow_views::{
    Adjacency, Adjacent, Computed, DeckCamera, EyeMesh, IS_CAP, Positions, VolumeSource, count,
    eye_vertices,
};
use terrafill_study::Failure;

/// An edge, from its lower to its higher vertex, and the triangles that have it so and the other way round.
type Edge = (Side, [u32; 2]);

impl Scene {
    /// What a shader finds silhouettes of; no place yet, since places are the eye's. `None` where the CPU has
    /// found them.
    ///
    /// # Errors
    /// [`Failure::Unable`] for a mesh in which an edge has not two triangles, one either way.
    pub(crate) fn found_by(&self, way: DeviceWay) -> Result<Option<VolumeSource>, Failure> {
        Ok(Some(match way.silhouettes {
            Silhouettes::Adjacency | Silhouettes::EachFrame | Silhouettes::EachTriangle => {
                return Ok(None);
            }
            Silhouettes::Pulled => VolumeSource::Pulled(self.pieces(false)?),
            Silhouettes::Corners => VolumeSource::Pulled(self.pieces(true)?),
            Silhouettes::Computed => VolumeSource::Computed(Computed {
                vertices: Vec::new(),
                mesh: self.pieces(false)?,
                far: count(self.mesh().vertices.len()),
                is_closed: way.end != End::Infinite,
            }),
            Silhouettes::Geometry(by) => VolumeSource::Adjacent(self.adjacent(by)?),
        }))
    }

    /// Edges, those within a plane among them if asked for: a facing that is no plane's may differ there.
    fn edges(&self, within_planes: bool) -> Result<Vec<Edge>, Failure> {
        let mut mesh = self.mesh().clone();
        if within_planes {
            mesh.planes = (0..count(mesh.triangles.len())).collect();
        }
        let unfit = || {
            let needs = "silhouettes on devices: found an edge without two triangles, one either way; allowed: \
                         closed meshes";
            Failure::Unable(needs.to_owned())
        };
        if self.prepared.is_robust {
            Err(unfit())
        } else {
            EdgeTable::of(&mesh).pairs().ok_or_else(unfit)
        }
    }

    /// Triangles and edges by caster.
    ///
    /// - `by_corners`: with the opposite corners instead of the triangles of an edge
    fn pieces(&self, by_corners: bool) -> Result<EyeMesh, Failure> {
        let mesh = self.mesh();
        let part_of = mesh.part_of_triangles();
        let mut sides: Vec<Vec<[u32; 4]>> = vec![Vec::new(); mesh.parts.len()];
        for (edge, pair) in self.edges(by_corners)? {
            let [first, second] = if by_corners {
                pair.map(|triangle| opposite(mesh, triangle, edge))
            } else {
                pair
            };
            let part = part_of[pair[0] as usize] as usize;
            sides[part].push([edge[0], edge[1], first, second]);
        }
        let mut made = EyeMesh {
            lit: if by_corners {
                Vec::new()
            } else {
                packed(&self.facing.is_lit)
            },
            ..EyeMesh::default()
        };
        for caster in &mesh.casters {
            let first = count(made.pieces.len());
            for part in caster.parts.clone() {
                let caps = mesh.parts[part].triangles.clone();
                let cap = |triangle: usize| {
                    let [a, b, c] = mesh.triangles[triangle];
                    [a, b, c, count(triangle) | IS_CAP]
                };
                made.pieces.extend(caps.map(cap));
                made.pieces.append(&mut sides[part]);
            }
            made.ranges.push(first..count(made.pieces.len()));
        }
        Ok(made)
    }

    /// Corners with adjacency and facing bits, as `casters/adjacent.wgsl` reads them.
    fn adjacent(&self, by: Adjacency) -> Result<Adjacent, Failure> {
        let mesh = self.mesh();
        // A geometry shader looks at every edge of a triangle; one that is given edges can be given fewer.
        let edges = self.edges(by != Adjacency::Lines)?;
        let (mut table, mut vertices) = (Vec::new(), Vec::new());
        let (mut corners, mut caps, mut bits) = (Vec::new(), Vec::new(), Vec::new());
        let is_lit = |triangle: u32| self.is_lit(triangle as usize);
        // The direction is before all places.
        let placed = |vertex: u32| vertex + 1;
        let part_of = mesh.part_of_triangles();
        let mut by_part: Vec<Vec<Edge>> = vec![Vec::new(); mesh.parts.len()];
        let mut across = vec![[0; 3]; mesh.triangles.len()];
        for (edge, pair) in edges {
            by_part[part_of[pair[0] as usize] as usize].push((edge, pair));
            for (own, other) in [(pair[0], pair[1]), (pair[1], pair[0])] {
                let corners = mesh.triangles[own as usize];
                let at = corners.iter().position(|corner| !edge.contains(corner));
                // The edge opposite to a corner follows the next one.
                across[own as usize][(at.unwrap_or_default() + 1) % 3] = other;
            }
        }
        for caster in &mesh.casters {
            let parts = mesh.parts[caster.parts.clone()].iter();
            let triangles = parts.flat_map(|part| part.triangles.clone());
            let mut counted = [0, 0];
            if by == Adjacency::Lines {
                table.extend([count(corners.len() / 4), count(caps.len() / 3)]);
                for &(edge, pair) in by_part[caster.parts.clone()].iter().flatten() {
                    let [first, second] = pair.map(|triangle| opposite(mesh, triangle, edge));
                    corners.extend([first, edge[0], edge[1], second].map(placed));
                    bits.extend(pair.map(is_lit));
                    counted[0] += 4;
                }
                for triangle in triangles {
                    caps.extend(mesh.triangles[triangle].map(placed));
                    counted[1] += 3;
                }
            } else {
                table.extend([count(corners.len() / 6), 0]);
                for triangle in triangles {
                    let own = mesh.triangles[triangle];
                    bits.extend([is_lit(count(triangle))]);
                    for at in 0..3 {
                        let neighbour = across[triangle][at];
                        let edge = [own[at], own[(at + 1) % 3]];
                        corners.extend([own[at], opposite(mesh, neighbour, edge)].map(placed));
                        bits.extend([is_lit(neighbour)]);
                    }
                    counted[0] += 6;
                    counted[1] += 3;
                }
            }
            vertices.push(counted);
        }
        if by == Adjacency::Lines {
            bits.resize(bits.len().next_multiple_of(u32::BITS as usize), false);
            let parts = mesh.casters.iter().flat_map(|caster| caster.parts.clone());
            let triangles = parts.flat_map(|part| mesh.parts[part].triangles.clone());
            bits.extend(triangles.map(|triangle| self.is_lit(triangle)));
        }
        let bits = packed(&bits);
        let corners_at = count(table.len());
        let caps_at = corners_at + count(corners.len());
        let bits_at = caps_at + count(caps.len());
        let places_at = bits_at + count(bits.len());
        let light_bytes = size_of_val(&*bits) as u64;
        Ok(Adjacent {
            by,
            vertices,
            begins: [0, corners_at, bits_at, places_at, caps_at],
            words: [table, corners, caps, bits].concat(),
            light_bytes,
        })
    }

    /// The same as this eye has it.
    ///
    /// - `volume`: from the CPU, of which a compute shader takes the vertices
    pub(crate) fn seen_from(
        &self,
        view: &DeckCamera,
        found: &VolumeSource,
        positions: Positions,
        volume: &Volume,
    ) -> VolumeSource {
        let away = (-self.to_light).as_vec3();
        let places = self.mesh().vertices.iter();
        let places = places.map(|place| (place - view.eye).as_vec3());
        let mut seen = found.clone();
        match &mut seen {
            VolumeSource::Volumes(_) => {}
            VolumeSource::Pulled(mesh) => {
                let places = places.map(|place| place.extend(1.0));
                let all = places.chain([away.extend(0.0)]);
                mesh.places = all.map(|place| place.to_array()).collect();
            }
            VolumeSource::Computed(own) => own.vertices = eye_vertices(positions, view, volume),
            VolumeSource::Adjacent(own) => {
                let all = std::iter::once(away).chain(places);
                let words = all.flat_map(|place| place.to_array()).map(f32::to_bits);
                own.words.extend(words);
            }
        }
        seen
    }

    /// Triangles whose sign of facing in `f32` from an eye depends on which corner comes first.
    pub(crate) fn undecided_facings(&self, view: &DeckCamera) -> usize {
        let to_light = self.to_light.as_vec3();
        let is_split = |corners: &&[u32; 3]| {
            let places = corners.map(|at| (self.mesh().vertices[at as usize] - view.eye).as_vec3());
            let signs = [0, 1, 2].map(|first| {
                let [a, b, c] = [0, 1, 2].map(|at| places[(first + at) % 3]);
                (b - a).cross(c - a).dot(to_light) > 0.0
            });
            signs.iter().any(|sign| *sign != signs[0])
        };
        self.mesh().triangles.iter().filter(is_split).count()
    }
}

/// The corner of a triangle that is on no end of an edge.
fn opposite(mesh: &Mesh, triangle: u32, edge: Side) -> u32 {
    let corners = mesh.triangles[triangle as usize];
    let other = corners.into_iter().find(|corner| !edge.contains(corner));
    // Of a triangle without area.
    other.unwrap_or(corners[0])
}

/// Bits in words, the lowest first.
fn packed(bits: &[bool]) -> Vec<u32> {
    let word = |bits: &[bool]| {
        let bits = bits.iter().rev();
        bits.fold(0, |word, bit| word << 1 | u32::from(*bit))
    };
    bits.chunks(u32::BITS as usize).map(word).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_fill_words_from_the_lowest_on() {
        let bits = [&[true, false, true][..], &[false; 61], &[true]].concat();
        assert_eq!(packed(&bits), [5, 0, 1]);
    }

    #[test]
    fn corners_disagree_where_faces_are_edge_on_and_nowhere_else() {
        let count = |is_edge_on| {
            let scene = Scene::of_boxes([30.0, -60.0], is_edge_on, [8, 6]).expect("boxes");
            scene.undecided_facings(&scene.views[0])
        };
        let (edge_on, random) = (count(true), count(false));
        assert!(edge_on > 5 && random == 0, "{edge_on} {random}");
    }
}
