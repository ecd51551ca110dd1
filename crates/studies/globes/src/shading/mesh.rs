// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a frame draws: a mesh of the CPU's, or a range of the static buffer.

use super::device::{Geometry, LayerVertex};
use super::judge::{Met, foot, normal};
use crate::made::spiral::Spiral;
use crate::projection::Projection;
use glam::DVec3;
use std::sync::Arc;
use terrafill_globe_views::{Eye, no_triangles};
use terrafill_surface::SurfaceFrame;

/// What a frame draws.
pub(super) enum Mesh {
    /// Made and projected by the CPU.
    Sent(SurfaceFrame, Vec<LayerVertex>),
    /// Of the static buffer; its places from the eye are known in `f64`.
    Stored(Spiral),
}

impl Mesh {
    pub(super) fn geometry(&self) -> Geometry<'_> {
        match self {
            Self::Sent(_, vertices) => Geometry::Sent(vertices),
            Self::Stored(spiral) => Geometry::Stored(spiral),
        }
    }

    pub(super) fn triangles(&self) -> Arc<[[u32; 3]]> {
        match self {
            Self::Sent(frame, _) => Arc::clone(&frame.triangles),
            Self::Stored(spiral) => spiral.triangles().into(),
        }
    }

    /// Coordinates that are not finite.
    pub(super) fn lost(&self) -> usize {
        let Self::Sent(_, vertices) = self else {
            return 0;
        };
        let places = vertices.iter().flat_map(|vertex| vertex.clip);
        places.filter(|at| !at.is_finite()).count()
    }

    /// The triangles that pixels show.
    pub(super) fn met(&self, eye: &Eye, projection: Projection) -> Met {
        match self {
            Self::Sent(frame, _) => Met::new(eye, frame),
            Self::Stored(spiral) => met(eye, &places(spiral), spiral.triangles(), projection),
        }
    }

    /// Those that pixels would show if each were four, with corners on the body.
    pub(super) fn met_finer(&self, eye: &Eye, projection: Projection) -> Met {
        let (mut places, triangles) = match self {
            Self::Sent(frame, _) => {
                let places = frame.vertices_rte.iter();
                let places = places.map(|place| DVec3::from(place.map(f64::from)));
                (places.collect(), frame.triangles.to_vec())
            }
            Self::Stored(spiral) => (places(spiral), spiral.triangles()),
        };
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[from, to]| {
                let middle = 0.5 * (places[from as usize] + places[to as usize]);
                places.push(foot(eye, normal(eye, middle)));
                u32::try_from(places.len() - 1).unwrap_or(u32::MAX)
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        met(eye, &places, finer, projection)
    }
}

/// From the eye.
fn places(spiral: &Spiral) -> Vec<DVec3> {
    (0..spiral.count()).map(|k| spiral.place(k)).collect()
}

fn met(eye: &Eye, places: &[DVec3], triangles: Vec<[u32; 3]>, projection: Projection) -> Met {
    if projection != Projection::Globe {
        return Met::projected(eye, places, &triangles, projection);
    }
    let vertices = places.iter().map(|place| place.as_vec3().to_array());
    let frame = SurfaceFrame {
        vertices_rte: vertices.collect(),
        triangles: triangles.into(),
        ..no_triangles()
    };
    Met::new(eye, &frame)
}

pub(super) fn vertices(eye: &Eye, frame: &SurfaceFrame) -> Vec<LayerVertex> {
    let places = frame.vertices_rte.iter();
    places
        .map(|vertex| {
            let relative_m = DVec3::from(vertex.map(f64::from));
            LayerVertex {
                clip: Projection::Globe.clip(eye, relative_m).as_vec4().to_array(),
                to_eye: (-relative_m).as_vec3().to_array(),
                normal: normal(eye, relative_m).as_vec3().to_array(),
            }
        })
        .collect()
}
