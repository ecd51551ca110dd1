// SPDX-License-Identifier: MIT OR Apache-2.0
//! Silhouettes towards a directional light, three ways, all of which read the same facing bits.
//!
//! [`by_stack`] and [`by_hash`] are parity toggles on undirected edges: right for 2-manifolds only.
//! [`EdgeTable`] counts directed edges, which is right for any oriented mesh: lit triangle (a, b, c)
//! adds 1 to (a, b) if a < b and else takes 1 from (b, a).

use crate::mesh::index;
use crate::{Mesh, Prepared};
use glam::DVec3;
use std::collections::HashMap;

/// Side of a volume: an edge, directed as in the lit triangle that has it.
pub type Side = [u32; 2];

/// Which triangles face the light.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Facing {
    /// Of each triangle.
    pub is_lit: Vec<bool>,
}

impl Facing {
    /// One sign a plane; a plane that is exactly edge-on is not lit.
    ///
    /// - `to_light`: towards the light
    #[must_use]
    pub fn of(mesh: &Mesh, to_light: DVec3) -> Self {
        let lit = mesh.normals.iter().map(|normal| normal.dot(to_light) > 0.0);
        let lit: Vec<bool> = lit.collect();
        let planes = mesh.planes.iter();
        Self {
            is_lit: planes.map(|plane| lit[*plane as usize]).collect(),
        }
    }

    fn lit<'a>(&'a self, mesh: &'a Mesh) -> impl Iterator<Item = [u32; 3]> + 'a {
        let triangles = mesh.triangles.iter().zip(&self.is_lit);
        triangles
            .filter(|(_, is_lit)| **is_lit)
            .map(|(corners, _)| *corners)
    }
}

fn undirected([from, to]: Side) -> Side {
    [from.min(to), from.max(to)]
}

fn borders([a, b, c]: [u32; 3]) -> [Side; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The published stack: push three borders a lit triangle; where a border lies in it already, delete
/// both. O(triangles · silhouette).
#[must_use]
pub fn by_stack(mesh: &Mesh, facing: &Facing) -> Vec<Side> {
    let mut stack: Vec<Side> = Vec::new();
    for border in facing.lit(mesh).flat_map(borders) {
        let same = |other: &Side| undirected(*other) == undirected(border);
        // From the top: neighbours are often a few triangles apart.
        match stack.iter().rposition(same) {
            Some(found) => drop(stack.swap_remove(found)),
            None => stack.push(border),
        }
    }
    stack
}

/// The same toggle with a hash of the borders. O(triangles).
#[must_use]
pub fn by_hash(mesh: &Mesh, facing: &Facing) -> Vec<Side> {
    let mut sides: Vec<Option<Side>> = Vec::new();
    let mut places: HashMap<Side, usize> = HashMap::new();
    for border in facing.lit(mesh).flat_map(borders) {
        if let Some(found) = places.remove(&undirected(border)) {
            sides[found] = None;
        } else {
            places.insert(undirected(border), sides.len());
            sides.push(Some(border));
        }
    }
    sides.into_iter().flatten().collect()
}

/// An edge's triangle, and whether it has the edge from its lower to its higher vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Use {
    triangle: u32,
    is_forward: bool,
}

/// Stored adjacency: each edge with its triangles. Edges within a plane are left out (Ren et al.,
/// 2007): with one facing bit a plane they are on no silhouette.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct EdgeTable {
    edges: Vec<Side>,
    /// Of each edge, and one past the last: its first use.
    starts: Vec<u32>,
    uses: Vec<Use>,
}

impl EdgeTable {
    /// Of a mesh.
    #[must_use]
    pub fn of(mesh: &Mesh) -> Self {
        let mut met: Vec<(Side, Use)> = Vec::with_capacity(3 * mesh.triangles.len());
        for (triangle, corners) in mesh.triangles.iter().enumerate() {
            met.extend(borders(*corners).map(|border| {
                let of = Use {
                    triangle: index(triangle),
                    is_forward: border[0] < border[1],
                };
                (undirected(border), of)
            }));
        }
        met.sort_by_key(|(edge, of)| (*edge, of.triangle));
        let mut table = Self::default();
        for group in met.chunk_by(|a, b| a.0 == b.0) {
            let plane = |at: usize| mesh.planes[group[at].1.triangle as usize];
            let is_opposite = |at: usize| group[at].1.is_forward;
            if group.len() == 2 && plane(0) == plane(1) && is_opposite(0) != is_opposite(1) {
                continue;
            }
            table.edges.push(group[0].0);
            table.starts.push(index(table.uses.len()));
            table.uses.extend(group.iter().map(|(_, of)| *of));
        }
        table.starts.push(index(table.uses.len()));
        table
    }

    /// Edges between planes.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        self.edges.len()
    }

    /// Each edge, from its lower to its higher vertex, with the triangles that have it so and the other way
    /// round; `None` where some edge has other uses than these two.
    #[must_use]
    pub fn pairs(&self) -> Option<Vec<(Side, [u32; 2])>> {
        let of = |(at, edge): (usize, &Side)| {
            let uses = self.starts[at] as usize..self.starts[at + 1] as usize;
            match &self.uses[uses] {
                [one, other] if one.is_forward != other.is_forward => {
                    let pair = [one.triangle, other.triangle];
                    let [forward, backward] = if one.is_forward {
                        pair
                    } else {
                        [pair[1], pair[0]]
                    };
                    Some((*edge, [forward, backward]))
                }
                _ => None,
            }
        };
        self.edges.iter().enumerate().map(of).collect()
    }

    /// Directed count over lit triangles: |count| sides, wound by its sign. O(edges).
    #[must_use]
    pub fn silhouette(&self, facing: &Facing) -> Vec<Side> {
        self.count(
            |of| match (facing.is_lit[of.triangle as usize], of.is_forward) {
                (false, _) => 0,
                (true, true) => 1,
                (true, false) => -1,
            },
        )
    }

    /// Directed count over all triangles, each turned towards the light.
    #[must_use]
    pub fn robust_silhouette(&self, facing: &Facing) -> Vec<Side> {
        self.count(|of| {
            if facing.is_lit[of.triangle as usize] == of.is_forward {
                1
            } else {
                -1
            }
        })
    }

    /// As the prepared mesh needs it.
    #[must_use]
    pub fn sides(&self, prepared: &Prepared, facing: &Facing) -> Vec<Side> {
        if prepared.is_robust {
            self.robust_silhouette(facing)
        } else {
            self.silhouette(facing)
        }
    }

    fn count(&self, weight: impl Fn(Use) -> i32) -> Vec<Side> {
        let mut sides = Vec::new();
        for (at, &[low, high]) in self.edges.iter().enumerate() {
            let uses = self.starts[at] as usize..self.starts[at + 1] as usize;
            let count: i32 = self.uses[uses].iter().map(|of| weight(*of)).sum();
            let side = if count > 0 { [low, high] } else { [high, low] };
            sides.extend((0..count.unsigned_abs()).map(|_| side));
        }
        sides
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::tests::tetrahedron;
    use crate::{PortSize, hull, port, row};

    fn sorted(mut sides: Vec<Side>) -> Vec<Side> {
        sides.sort_unstable();
        sides
    }

    /// By stack, hash and table.
    fn all(mesh: &Mesh, to_light: DVec3) -> [Vec<Side>; 3] {
        let facing = Facing::of(mesh, to_light);
        [
            by_stack(mesh, &facing),
            by_hash(mesh, &facing),
            EdgeTable::of(mesh).silhouette(&facing),
        ]
        .map(sorted)
    }

    #[test]
    fn three_methods_find_the_same_sides_on_closed_meshes() {
        let suns = [
            DVec3::Z,
            DVec3::X,
            DVec3::new(0.3, -0.5, 0.1),
            DVec3::new(1.0, 0.0, 0.05),
        ];
        for mesh in [port(PortSize::NAMED[0].1), hull(600), row(5)] {
            for sun in suns {
                let [stack, hash, table] = all(&mesh, sun);
                assert!(!table.is_empty());
                assert!(stack == hash && hash == table, "sun {sun}");
            }
        }
    }

    #[test]
    fn pairs_of_triangles_give_the_same_sides_and_an_open_mesh_has_none() {
        let sun = DVec3::new(0.3, -0.5, 0.1);
        for mesh in [port(PortSize::NAMED[0].1), hull(600)] {
            let facing = Facing::of(&mesh, sun);
            let table = EdgeTable::of(&mesh);
            let sides = table.pairs().expect("closed").into_iter();
            let sides = sides.filter_map(|([low, high], pair)| {
                match pair.map(|triangle| facing.is_lit[triangle as usize]) {
                    [true, false] => Some([low, high]),
                    [false, true] => Some([high, low]),
                    _ => None,
                }
            });
            assert_eq!(sorted(sides.collect()), sorted(table.silhouette(&facing)));
        }
        let (vertices, mut triangles) = tetrahedron();
        triangles.pop();
        let open = Mesh::from_triangles("open", vertices, triangles).expect("finite");
        assert_eq!(EdgeTable::of(&open).pairs(), None);
    }

    #[test]
    fn a_prism_over_an_n_gon_has_n_and_two_sides_and_no_edge_within_a_plane() {
        for corners in [3_u32, 4, 8] {
            let turn = std::f64::consts::TAU / f64::from(corners);
            let ring = (0..corners).map(|at| {
                let (sin, cos) = (turn * f64::from(at)).sin_cos();
                DVec3::new(cos, sin, 0.0)
            });
            let mut mesh = Mesh::default();
            mesh.begin("prism");
            mesh.push_prism(&ring.collect::<Vec<_>>(), DVec3::Z);
            assert_eq!(EdgeTable::of(&mesh).edge_count(), 3 * corners as usize);
            let [_, _, table] = all(&mesh, DVec3::new(0.7, 0.4, 0.5));
            assert_eq!(table.len(), corners as usize + 2);
        }
    }

    #[test]
    fn a_flipped_face_splits_the_parity_from_the_count() {
        let (vertices, mut triangles) = tetrahedron();
        // Lit from +x +y +z: the slanted face alone. Flip a face that shares an edge with it, so that
        // it is lit too and has the edge the same way round.
        triangles[0].swap(1, 2);
        let mesh = Mesh::from_triangles("a", vertices, triangles).expect("finite");
        let [stack, hash, table] = all(&mesh, DVec3::ONE);
        assert_eq!(stack, hash);
        assert_ne!(hash, table, "weight 2 at an edge that the toggle deletes");
        assert_eq!(
            table
                .iter()
                .filter(|side| table.contains(&[side[1], side[0]]))
                .count(),
            0
        );
        assert_eq!(table.len(), stack.len() + 2);
    }

    #[test]
    fn a_triangle_alone_has_three_sides_from_the_front_and_none_from_behind_unless_robust() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let mesh = Mesh::from_triangles("sheet", vertices, vec![[0, 1, 2]]).expect("finite");
        let table = EdgeTable::of(&mesh);
        for (sun, sides) in [(DVec3::Z, 3), (-DVec3::Z, 0), (DVec3::X, 0)] {
            let facing = Facing::of(&mesh, sun);
            assert_eq!(table.silhouette(&facing).len(), sides);
            assert_eq!(table.robust_silhouette(&facing).len(), 3);
        }
    }
}
