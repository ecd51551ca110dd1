// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shapes that studies draw, and what rays in `f64` see of them: height grids on a plane, bicubic patches, and a model
//! with its geometry image.
//!
//! Metres, z up, unless a shape says otherwise. Triangles and points are numbered from 1 on, and pictures show these
//! numbers. Pictures of these numbers are judged here, by rays that know no matrix and no list of vertices.
//! Snapping of vertices by a device is allowed for; see [`rays::BAND_PX`].

pub mod dents;
pub mod distance;
pub mod grid;
pub mod mesh;
pub mod mesh_rays;
pub mod patch;
pub mod pot;
pub mod rabbit;
pub mod rays;
pub mod sphere;
pub mod square;
pub mod tetrahedra;
