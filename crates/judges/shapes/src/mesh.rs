// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles in squares of cells, as they are numbered, and what shaders read of mesh and camera.

use crate::grid::GridCamera;
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4};

/// How the cells of a mesh are cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cut {
    /// From corner (1, 0) to (0, 1), as published.
    Published,
    /// From corner (0, 0) to (1, 1).
    Other,
}

/// Triangles, numbered from 1 on: square by square, cell by cell in rows, the half at the cell's first corner before
/// the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Metres: square by square, (cells + 1)² each, row by row.
    pub vertices: Vec<DVec3>,
    /// Corners by their index, those of a cell's first half before the second's.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// - `cut`: of the cell at (column, row)
    pub fn new(vertices: Vec<DVec3>, cells: u32, cut: impl Fn(u32, u32) -> Cut) -> Self {
        let side = cells + 1;
        let squares = u32::try_from(vertices.len()).unwrap_or(u32::MAX) / (side * side);
        let all = (0..squares).flat_map(|square| {
            (0..cells).flat_map(move |row| (0..cells).map(move |column| (square, column, row)))
        });
        let triangles = all.flat_map(|(square, column, row)| {
            let near = (square * side + row) * side + column;
            let (right, below, far) = (near + 1, near + side, near + side + 1);
            match cut(column, row) {
                Cut::Published => [[near, right, below], [far, below, right]],
                Cut::Other => [[near, right, far], [near, far, below]],
            }
        });
        let triangles = triangles.collect();
        Self {
            vertices,
            triangles,
        }
    }

    /// Of a triangle's index, metres.
    pub fn corners(&self, index: usize) -> [DVec3; 3] {
        self.triangles[index].map(|corner| self.vertices[corner as usize])
    }

    /// How much light from above the eye falls on a triangle, 0 to 1, either side of it.
    pub fn light(&self, index: usize, view: &GridCamera) -> f64 {
        let [a, b, c] = self.corners(index);
        let toward = (2.0 * view.up - view.forward - view.right).normalize();
        let normal = (b - a).cross(c - a).normalize_or_zero();
        // Lit is what faces the light on the side that the eye sees.
        let faces_eye = normal.dot(view.eye - a).signum();
        (faces_eye * normal.dot(toward)).max(0.0)
    }
}

/// Twin of `MeshConstants` in `shared/mesh.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct MeshConstants {
    x: [f32; 4],
    y: [f32; 4],
    z: [f32; 4],
    origin: [f32; 4],
    cells: u32,
    is_folded: u32,
    padding: [u32; 2],
}

impl MeshConstants {
    /// Of a view and of squares with so many cells a side.
    #[must_use]
    pub fn new(view: &GridCamera, cells: u32) -> Self {
        let clip = view.clip_from_world();
        let column = |of: DVec4| of.as_vec4().to_array();
        Self {
            x: column(clip.x_axis),
            y: column(clip.y_axis),
            z: column(clip.z_axis),
            origin: column(clip.w_axis),
            cells,
            is_folded: 0,
            padding: [0; 2],
        }
    }

    /// Of a geometry image: whether its cells are cut along its folds.
    pub fn folded(self, is_folded: bool) -> Self {
        Self {
            is_folded: u32::from(is_folded),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    #[test]
    fn constants_lie_as_the_shader_reads_them() {
        let layout = struct_layout("pipelines/bezier.wgsl", "MeshConstants").expect("a struct");
        let offset = |name: &str| layout.offset(name).expect(name);
        assert_eq!(offset("x"), offset_of!(MeshConstants, x));
        assert_eq!(offset("y"), offset_of!(MeshConstants, y));
        assert_eq!(offset("z"), offset_of!(MeshConstants, z));
        assert_eq!(offset("origin"), offset_of!(MeshConstants, origin));
        assert_eq!(offset("cells"), offset_of!(MeshConstants, cells));
        assert_eq!(offset("is_folded"), offset_of!(MeshConstants, is_folded));
        assert_eq!(layout.stride as usize, size_of::<MeshConstants>());
        // Negative control: two members lie apart.
        assert_ne!(offset("y"), offset_of!(MeshConstants, z));
    }

    #[test]
    fn cells_are_numbered_in_rows_and_cut_as_they_say() {
        let vertices = vec![DVec3::ZERO; 2 * 9];
        let of = |cut| Mesh::new(vertices.clone(), 2, move |_, _| cut).triangles;
        let published = of(Cut::Published);
        assert_eq!(published.len(), 2 * 8);
        assert_eq!(published[..2], [[0, 1, 3], [4, 3, 1]]);
        assert_eq!(published[4..6], [[3, 4, 6], [7, 6, 4]]);
        assert_eq!(published[8], [9, 10, 12]);
        // Negative control: the other cut has other corners.
        assert_eq!(of(Cut::Other)[..2], [[0, 1, 4], [0, 4, 3]]);
    }
}
