// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vertices of a frame with their places on the map, as the device reads them.

use super::options::{Options, Seam};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use terrafill_core::{Ellipsoid, nearest_f32};
use terrafill_maps::{MapPoint, SeamCorner, half_plane_crossings, split};
use terrafill_scene::Camera;
use terrafill_surface::SurfaceFrame;

/// As `vertex_main` of `globes/map.wgsl` reads it.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MapVertex {
    /// Metres from the eye, ECEF axes.
    pub(crate) relative_m: [f32; 3],
    /// U, and its half-turned twin.
    pub(crate) us: [f32; 2],
    /// V, or V' where the vertex makes it.
    pub(crate) v: f32,
}

/// A view's triangles, three vertices each.
#[derive(Debug, Clone, Default)]
pub(crate) struct MapMesh {
    pub(crate) vertices: Vec<MapVertex>,
    /// Triangles that ±180° crosses and that hold no pole.
    pub(crate) crossing: usize,
    /// Those of them that the seam's rule leaves as they are.
    pub(crate) missed: usize,
}

/// Place on the map of the eye's own point, from which `rotated` and `local` count; over a pole that of the map's
/// end, since V' is infinite there.
pub(crate) fn origin(body: &Ellipsoid, camera: &Camera) -> MapPoint {
    let point = MapPoint::new(body, camera.eye_ecef);
    MapPoint {
        mercator_v: point.mercator_v.clamp(0.0, 1.0),
        ..point
    }
}

/// Makes a frame's vertices.
///
/// - cost: O(triangles)
pub(crate) fn map_mesh(
    body: &Ellipsoid,
    camera: &Camera,
    frame: &SurfaceFrame,
    options: &Options,
) -> MapMesh {
    let places: Vec<DVec3> = frame
        .vertices_rte
        .iter()
        .map(|vertex| DVec3::from(vertex.map(f64::from)))
        .collect();
    let points: Vec<MapPoint> = places
        .iter()
        .map(|place| MapPoint::new(body, camera.eye_ecef + *place))
        .collect();
    let maker = Maker {
        options,
        origin: origin(body, camera),
    };
    let mut mesh = MapMesh::default();
    for triangle in frame.triangles.iter() {
        let corners = triangle.map(|at| places[at as usize]);
        let points = triangle.map(|at| points[at as usize]);
        let parts = maker.parts(points.map(|point| point.u));
        if half_plane_crossings(corners.map(|corner| corner + camera.eye_ecef)) == 2 {
            mesh.crossing += 1;
            mesh.missed += usize::from(maker.is_missed(parts.len()));
        }
        for part in parts {
            mesh.vertices
                .extend(part.map(|corner| maker.vertex(corners, points, corner)));
        }
    }
    mesh
}

struct Maker<'a> {
    options: &'a Options,
    origin: MapPoint,
}

impl Maker<'_> {
    fn parts(&self, us: [f64; 3]) -> Vec<[SeamCorner; 3]> {
        let limit = match self.options.seam {
            Seam::Split(limit) => limit,
            _ => f64::INFINITY,
        };
        split(us, limit)
    }

    /// A triangle across the seam is in three parts, or the fragment sees to it.
    fn is_missed(&self, parts: usize) -> bool {
        match self.options.seam {
            Seam::None => true,
            Seam::Split(_) => parts != 3,
            Seam::Derivative | Seam::Rotated | Seam::Local => false,
        }
    }

    fn vertex(&self, corners: [DVec3; 3], points: [MapPoint; 3], at: SeamCorner) -> MapVertex {
        let mixed =
            |of: &dyn Fn(usize) -> f64| -> f64 { (0..3).map(|i| of(i) * at.weights[i]).sum() };
        let place = DVec3::new(
            mixed(&|i| corners[i].x),
            mixed(&|i| corners[i].y),
            mixed(&|i| corners[i].z),
        );
        let v = if self.options.by_fragment {
            mixed(&|i| points[i].v)
        } else {
            mixed(&|i| points[i].mercator_v)
        };
        let turned = (at.u + 0.5).rem_euclid(1.0) - 0.5;
        let counted = (at.u - self.origin.u + 0.5).rem_euclid(1.0) - 0.5;
        let (us, v) = match self.options.seam {
            Seam::None | Seam::Split(_) | Seam::Derivative => ([at.u, turned], v),
            Seam::Rotated => ([counted, 0.0], v),
            Seam::Local => ([counted, 0.0], v - self.origin.mercator_v),
        };
        MapVertex {
            relative_m: place.as_vec3().to_array(),
            us: us.map(nearest_f32),
            v: nearest_f32(v),
        }
    }
}
