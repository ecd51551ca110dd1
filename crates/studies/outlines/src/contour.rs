// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contour edges as a device is handed them: those between a face that the eye is before and one that it is behind.

use crate::fleet::{Fleet, index};
use std::ops::Range;
use terrafill_casters::{EdgeTable, Facing};

/// A contour edge, in the layout of its vertex buffer.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Stroke {
    /// From the eye, metres.
    pub(crate) ends: [[f32; 3]; 2],
    /// The model's place among all.
    pub(crate) model: u32,
}

/// Strokes of all models, and which are each one's. By one sign a plane in `f64`, and stored adjacency.
pub(crate) fn strokes(fleet: &Fleet) -> (Vec<Stroke>, Vec<Range<u32>>) {
    let (mesh, eye) = (&fleet.mesh, fleet.camera.eye);
    // In the order of vertices, hence of models.
    let sides = EdgeTable::of(mesh).silhouette(&Facing::towards(mesh, eye));
    let (mut all, mut ranges) = (Vec::with_capacity(sides.len()), Vec::new());
    let mut rest = sides.as_slice();
    for model in 0..mesh.casters.len() {
        let past = fleet.of_model(model, |part| part.vertices.clone()).end;
        let own = rest.partition_point(|side| (side[0] as usize) < past);
        let (own, others) = rest.split_at(own);
        let first = index(all.len());
        all.extend(own.iter().map(|side| Stroke {
            ends: side.map(|end| from_eye(fleet, end as usize)),
            model: index(model),
        }));
        ranges.push(first..index(all.len()));
        rest = others;
    }
    (all, ranges)
}

/// A vertex from the eye, metres.
pub(crate) fn from_eye(fleet: &Fleet, vertex: usize) -> [f32; 3] {
    (fleet.mesh.vertices[vertex] - fleet.camera.eye)
        .as_vec3()
        .to_array()
}
