// SPDX-License-Identifier: MIT OR Apache-2.0
//! A large picture over a part of the Earth in nodes of a quadtree, and each node's pixels by rays in `f64`.
//!
//! A node draws its whole area as 10 × 10 sub-quads, as Gebbie and Bailey's decals do.

use glam::DVec3;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use terrafill_core::Geodetic;
use terrafill_globe_views::{Eye, around, no_triangles};
use terrafill_maps::Node;
use terrafill_reference::SurfaceTriangles;
use terrafill_surface::SurfaceFrame;

/// Sub-quads along a side of a node.
const SUB_QUADS: u32 = 10;
/// Vertices of a node: two triangles a sub-quad, three vertices each.
const NODE_VERTICES: u32 = 6 * SUB_QUADS * SUB_QUADS;
/// Side of the picture, degrees.
const SIDE_DEG: f64 = 40.0;

/// Where the picture lies, and vertices of nodes that were made already.
pub(crate) struct Picture {
    /// Of its south-western corner, degrees.
    corner_deg: [f64; 2],
    made: HashMap<Node, Arc<Vec<DVec3>>>,
}

impl Picture {
    /// About the place below an eye.
    pub(crate) fn below(eye: &Eye) -> Self {
        let place = eye.pose.eye;
        let middle = [place.longitude_rad, place.latitude_rad].map(f64::to_degrees);
        Self {
            corner_deg: middle.map(|middle| middle - 0.5 * SIDE_DEG),
            made: HashMap::new(),
        }
    }

    /// Triangles of a node, ECEF, counter-clockwise from above.
    fn node(&mut self, eye: &Eye, node: Node) -> Arc<Vec<DVec3>> {
        let corner = self.corner_deg;
        let made = self.made.entry(node).or_insert_with(|| {
            let (level, column, row) = node;
            let side_deg = SIDE_DEG / f64::from(level).exp2();
            let at = |x: u32, y: u32| {
                let along = |from: f64, node: usize, sub: u32| {
                    from + side_deg * (node as f64 + f64::from(sub) / f64::from(SUB_QUADS))
                };
                let place = Geodetic::from_degrees(
                    along(corner[0], column, x),
                    along(corner[1], row, y),
                    0.0,
                );
                eye.body.geodetic_to_ecef(place)
            };
            let mut vertices = Vec::with_capacity(NODE_VERTICES as usize);
            for y in 0..SUB_QUADS {
                for x in 0..SUB_QUADS {
                    let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
                    vertices.extend([a, b, d, a, d, c]);
                }
            }
            Arc::new(vertices)
        });
        Arc::clone(made)
    }

    /// Nodes as the device draws them.
    pub(crate) fn drawn(&mut self, eye: &Eye, leaves: impl Iterator<Item = Node>) -> NodeVertices {
        let nodes = leaves.map(|node| (node, self.node(eye, node))).collect();
        NodeVertices::sorted(eye, NODE_VERTICES, nodes)
    }
}

/// Vertices of nodes in their order.
#[derive(Debug, Clone)]
pub(crate) struct NodeVertices {
    /// Metres from the eye, ECEF axes.
    pub(crate) vertices_rte: Vec<[f32; 3]>,
    pub(crate) nodes: Vec<Node>,
    /// Vertices of each node, three a triangle.
    pub(crate) per_node: u32,
}

impl NodeVertices {
    /// The nearest first, so that a depth test passes for what is seen alone.
    ///
    /// - `nodes`: with their vertices, ECEF
    pub(crate) fn sorted(eye: &Eye, per_node: u32, nodes: Vec<(Node, Arc<Vec<DVec3>>)>) -> Self {
        let eye_ecef = eye.camera.eye_ecef;
        let nearest = |vertices: &Arc<Vec<DVec3>>| {
            let distances = vertices.iter().map(|vertex| vertex.distance(eye_ecef));
            distances.fold(f64::INFINITY, f64::min)
        };
        let mut nodes: Vec<(f64, Node, Arc<Vec<DVec3>>)> = nodes
            .into_iter()
            .map(|(node, vertices)| (nearest(&vertices), node, vertices))
            .collect();
        nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let vertices = nodes.iter().flat_map(|(_, _, vertices)| {
            let places = vertices.iter();
            places.map(|place| (*place - eye_ecef).as_vec3().to_array())
        });
        Self {
            vertices_rte: vertices.collect(),
            nodes: nodes.into_iter().map(|(_, node, _)| node).collect(),
            per_node,
        }
    }
}

/// Pixels of nodes by rays: how many, and how many of them lie beside another node, where a device's rounding of
/// vertices to its own grid decides.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct ByRays {
    pub(crate) counts: BTreeMap<Node, [u64; 2]>,
}

impl ByRays {
    pub(crate) fn new(eye: &Eye, drawn: &NodeVertices) -> Self {
        Self::of_picture(&numbers(eye, drawn), eye.size.width as usize, &drawn.nodes)
    }

    /// - `numbers`: of nodes from 1, row by row; 0 for none
    fn of_picture(numbers: &[u32], width: usize, nodes: &[Node]) -> Self {
        let mut counts: BTreeMap<Node, [u64; 2]> =
            nodes.iter().map(|node| (*node, [0; 2])).collect();
        let mut count = |number: u32, which: usize| {
            let node = number.checked_sub(1).and_then(|at| nodes.get(at as usize));
            if let Some(count) = node.and_then(|node| counts.get_mut(node)) {
                count[which] += 1;
            }
        };
        for (pixel, &number) in numbers.iter().enumerate() {
            let around = around(pixel, width, numbers.len());
            let mut touching: Vec<u32> = around.map(|beside| numbers[beside]).collect();
            touching.sort_unstable();
            touching.dedup();
            // A pixel at an edge may be another's in the device's picture, so it counts for all that touch it.
            if touching.len() > 1 {
                for number in touching {
                    count(number, 1);
                }
            }
            count(number, 0);
        }
        Self { counts }
    }

    /// Largest difference of a device's counts, and nodes for which it is more than the pixels at their edges.
    pub(crate) fn against(&self, device: &BTreeMap<Node, u64>) -> (u64, usize) {
        let mut largest = 0;
        let mut wrong = 0;
        for (node, [count, beside]) in &self.counts {
            let found = device.get(node).copied().unwrap_or(0);
            let off = found.abs_diff(*count);
            largest = largest.max(off);
            wrong += usize::from(off > *beside);
        }
        (largest, wrong)
    }
}

/// The node that each pixel shows, from 1; 0 for none.
pub(crate) fn numbers(eye: &Eye, drawn: &NodeVertices) -> Vec<u32> {
    let count = u32::try_from(drawn.vertices_rte.len()).unwrap_or(u32::MAX);
    let triangles: Vec<[u32; 3]> = (0..count / 3)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let frame = SurfaceFrame {
        vertices_rte: drawn.vertices_rte.clone().into(),
        triangles: triangles.into(),
        ..no_triangles()
    };
    let key = |corners: [DVec3; 3]| corners.map(|corner| corner.to_array().map(f64::to_bits));
    let per_node = drawn.per_node as usize;
    let of: HashMap<_, u32> = drawn
        .vertices_rte
        .chunks_exact(3)
        .enumerate()
        .map(|(triangle, corners)| {
            let corners = [0, 1, 2].map(|i| DVec3::from(corners[i].map(f64::from)));
            let node = u32::try_from(3 * triangle / per_node + 1).unwrap_or(u32::MAX);
            (key(corners), node)
        })
        .collect();
    let by_rays = SurfaceTriangles::new(&frame);
    eye.by_pixel(|_, _, direction| {
        let hit = by_rays.hit_facet(direction, eye.camera.near_m);
        let number = hit.and_then(|(_, facet)| of.get(&key(facet)));
        number.copied().unwrap_or(0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_may_differ_by_its_edge_and_by_no_more() {
        // Left half one node, right half another, eight by eight.
        let numbers: Vec<u32> = (0..64)
            .map(|pixel| if pixel % 8 < 4 { 1 } else { 2 })
            .collect();
        let nodes: [Node; 2] = [(1, 0, 0), (1, 1, 0)];
        let rays = ByRays::of_picture(&numbers, 8, &nodes);
        assert_eq!(rays.counts[&nodes[0]], [32, 16]);
        let device = |a, b| BTreeMap::from([(nodes[0], a), (nodes[1], b)]);
        assert_eq!(rays.against(&device(32, 32)), (0, 0));
        assert_eq!(rays.against(&device(40, 24)), (8, 0));
        // Negative control: more than the edge has, and a node that was not counted.
        assert_eq!(rays.against(&device(50, 32)), (18, 1));
        assert_eq!(rays.against(&BTreeMap::from([(nodes[0], 32)])), (32, 1));
    }
}
