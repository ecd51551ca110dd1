// SPDX-License-Identifier: MIT OR Apache-2.0
//! The surface: a spiral laid on the body anew in each view, from nothing but the view.

use crate::law::Law;
use crate::layout::{Indices, Steps, lay_out};
use crate::limits::{Limits, MAX_INNER, Rim, Shape};
use crate::parts::parts;
use crate::position::{Arithmetic, Attributes, Focus, Form, Trig};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, LN_2, TAU};
use std::sync::Arc;
use terrafill_core::{Ellipsoid, Extent};
use terrafill_elevation::{Base, Elevation};
use terrafill_scene::{Camera, ImageSize};
use terrafill_surface::{
    HeightRange, Parameters, Surface, SurfaceBlocks, SurfaceError, SurfaceFrame, SurfaceKind,
    SurfaceMesh, read_elevation,
};

/// Name in scene files.
const KIND: &str = "spiral";

/// Vertices of a turn where a scene names none.
const DEFAULT_N: u32 = 36;
/// Radius of the fan, pixels, where a scene names none.
const DEFAULT_FAN_PX: f64 = 50.0;
/// How far off the body the forms of position may set a vertex in single precision, as a share of the
/// radius: 1.5 m on the Earth were found, times four.
const F32_ERROR: f64 = 1e-6;

/// Scenes over one spiral: `kind = "spiral"`, the elevation as [`read_elevation`] knows it, the bare body where
/// a scene names none, and
///
/// - `n`: vertices of a turn
/// - `step_deg`: from vertex to vertex, 360/n where a scene names none
/// - `std`: turns in which the radius doubles; square cells where a scene names none
/// - `law`: how radii grow
/// - `fan_px`: radius of the fan in the middle, pixels
/// - `indices`: `watertight`, or `published` with its cracks
/// - `rim`: `covering`, or `horizon`, between whose chords the body is bare
/// - `frame`, `trig`, `precision`: how a vertex is computed
#[derive(Debug, Clone, Copy)]
pub struct SpiralKind;

impl SurfaceKind for SpiralKind {
    fn name(&self) -> &'static str {
        KIND
    }

    fn open(
        &self,
        body: &Ellipsoid,
        parameters: &mut Parameters<'_>,
    ) -> Result<Arc<dyn Surface>, SurfaceError> {
        let n = parameters.count("n", DEFAULT_N, 3..=288)?;
        let whole = 360.0 / f64::from(n);
        let step_deg = parameters.number("step_deg", whole, 1.0..=120.0)?;
        let spiral = Spiral {
            steps: Steps::new(step_deg),
            doubling: parameters.number("std", square_cells(n), 0.3..=64.0)?,
            law: parameters.one_of("law", Law::ALL)?,
            fan_px: parameters.number("fan_px", DEFAULT_FAN_PX, 1.0..=1e4)?,
            indices: parameters.one_of("indices", Indices::ALL)?,
            rim: parameters.one_of("rim", Rim::ALL)?,
            form: parameters.one_of("frame", FORMS)?,
            trig: parameters.one_of("trig", Trig::ALL)?,
            arithmetic: parameters.one_of("precision", Arithmetic::ALL)?,
            ..Spiral::new(body, n)
        };
        let elevation = elevation(body, parameters)?;
        Ok(Arc::new(spiral.with_elevation(elevation)))
    }
}

/// The form to take where a scene names none comes first.
const FORMS: [(&str, Form); 4] = {
    let [lon_lat, hemisphere, local, local_sin2] = Form::ALL;
    [local_sin2, lon_lat, hemisphere, local]
};

/// The bare body where a scene names no heights.
fn elevation(body: &Ellipsoid, parameters: &mut Parameters<'_>) -> Result<Elevation, SurfaceError> {
    let is_bare = parameters.files().is_empty()
        && parameters.word("base", "flat", &["flat", "relief"])? == "flat";
    if is_bare {
        Ok(bare())
    } else {
        read_elevation(body, parameters)
    }
}

fn bare() -> Elevation {
    Elevation::new(Vec::new(), Base::Flat, 0.0, 1.0)
}

/// Turns in which the radius doubles if cells are as wide as they are long: a turn grows by `e^(2π/n)`.
fn square_cells(n: u32) -> f64 {
    f64::from(n) * LN_2 / TAU
}

#[derive(Debug, Clone)]
pub(crate) struct Spiral {
    body: Ellipsoid,
    elevation: Elevation,
    /// Of the elevation, everywhere.
    terrain: HeightRange,
    steps: Steps,
    /// Turns in which the exponential radius doubles.
    doubling: f64,
    law: Law,
    fan_px: f64,
    indices: Indices,
    rim: Rim,
    form: Form,
    trig: Trig,
    arithmetic: Arithmetic,
}

impl Spiral {
    fn new(body: &Ellipsoid, n: u32) -> Self {
        Self {
            body: *body,
            elevation: bare(),
            terrain: HeightRange {
                lowest_m: 0.0,
                highest_m: 0.0,
            },
            steps: Steps::new(360.0 / f64::from(n)),
            doubling: square_cells(n),
            law: Law::Exponential,
            fan_px: DEFAULT_FAN_PX,
            indices: Indices::Watertight,
            rim: Rim::Covering,
            form: Form::LocalSin2,
            trig: Trig::Native,
            arithmetic: Arithmetic::F64,
        }
    }

    fn with_elevation(self, elevation: Elevation) -> Self {
        let heights = elevation.range(&Extent::WHOLE);
        Self {
            terrain: HeightRange {
                lowest_m: heights.lowest_m,
                highest_m: heights.highest_m,
            },
            elevation,
            ..self
        }
    }

    fn is_bare(&self) -> bool {
        self.elevation.fields().is_empty() && self.terrain.highest_m <= 0.0
    }

    fn shape(&self) -> Shape {
        Shape {
            steps: self.steps,
            widest_turn: self.law.widest_turn(self.doubling),
            fan_px: self.fan_px,
            rim: self.rim,
            terrain: self.terrain,
        }
    }

    /// Terrain above the ellipsoid below or above a place.
    fn ground_m(&self, ecef: DVec3) -> f64 {
        if self.is_bare() {
            return 0.0;
        }
        let place = self.body.ecef_to_geodetic(ecef);
        self.elevation.height_m(
            place.longitude_rad.to_degrees(),
            place.latitude_rad.to_degrees(),
        )
    }

    fn limits(&self, camera: &Camera, size: ImageSize) -> Result<Limits, SurfaceError> {
        let eye_height_m = self.body.ecef_to_geodetic(camera.eye_ecef).height_m;
        let ground_m = eye_height_m - self.ground_m(camera.eye_ecef);
        let below = SurfaceError::EyeBelow {
            kind: KIND,
            eye_height_m,
        };
        // On the ground there is no horizon, and nothing around it to draw.
        if ground_m <= 0.0 || ground_m.is_nan() {
            return Err(below);
        }
        let limits = self.shape().limits(&self.body, camera, size, ground_m);
        limits.ok_or(below)
    }

    /// Turns from the inner radius to the outer one.
    fn turns(&self, limits: Limits) -> f64 {
        self.doubling * (limits.outer / limits.inner).log2()
    }

    /// The mesh of a view, how many of its triangles are the fan, and of each vertex how far it is moved up.
    fn mesh(&self, camera: &Camera, limits: Limits) -> (SurfaceMesh, usize) {
        let layout = lay_out(self.steps, self.turns(limits), self.indices);
        let focus = Focus::new(&self.body, camera.eye_ecef);
        let form = (self.form, self.trig, self.arithmetic);
        let is_bare = self.is_bare();
        let is_exact = self.trig == Trig::Native && self.arithmetic == Arithmetic::F64;
        let mut vertices_ecef = Vec::with_capacity(layout.places.len());
        let mut heights_m = Vec::with_capacity(layout.places.len());
        for place in &layout.places {
            let radius = place.along.map_or(0.0, |along| {
                self.law.radius(along, limits.inner, limits.outer)
            });
            let attributes = Attributes::new(self.arithmetic, place.angle_rad, radius);
            let mut vertex = camera.eye_ecef + focus.vertex_rte(form, attributes);
            let mut height_m = 0.0;
            if !is_bare {
                let radii = self.body.radii_m();
                let normal = (vertex / (radii * radii)).normalize();
                let longitude = vertex.y.atan2(vertex.x).to_degrees();
                let latitude = normal.z.atan2(normal.x.hypot(normal.y)).to_degrees();
                height_m = self.elevation.height_m(longitude, latitude);
                vertex += normal * height_m;
            }
            if !is_exact {
                height_m = self.body.ecef_to_geodetic(vertex).height_m;
            }
            vertices_ecef.push(vertex);
            heights_m.push(height_m);
        }
        let mut mesh = SurfaceMesh {
            body: self.body,
            vertices_ecef,
            heights_m,
            triangles: layout.triangles.into(),
            heights: HeightRange {
                lowest_m: f64::INFINITY,
                highest_m: f64::NEG_INFINITY,
            },
            blocks: SurfaceBlocks::default(),
        };
        let facets = mesh.triangles.iter().map(|facet| mesh.facet_heights(facet));
        mesh.heights = facets.fold(mesh.heights, HeightRange::union);
        (mesh, layout.fan)
    }
}

impl Surface for Spiral {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn warnings(&self) -> &[String] {
        self.elevation.warnings()
    }

    /// Of the coarsest mesh that any view may draw, the same everywhere: seen from infinity a facet lies
    /// anywhere and is as large as any. A view's own parts say how much less it is.
    fn heights(&self, _extent: &Extent) -> HeightRange {
        let mut off = match self.arithmetic {
            Arithmetic::F64 => 0.0,
            Arithmetic::Buffer | Arithmetic::F32 => F32_ERROR,
        };
        if self.form != Form::LonLat {
            off += self.trig.worst_length_error();
        }
        let off_m = off * self.body.equatorial_radius_m();
        let sagitta_m = self
            .shape()
            .deepest_facet_m(&self.body, MAX_INNER, FRAC_PI_2);
        HeightRange {
            lowest_m: self.terrain.lowest_m - sagitta_m - off_m,
            highest_m: self.terrain.highest_m + off_m,
        }
    }

    fn true_height_m(&self, longitude_deg: f64, latitude_deg: f64) -> Option<f64> {
        Some(self.elevation.height_m(longitude_deg, latitude_deg))
    }

    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError> {
        let limits = self.limits(camera, size)?;
        let (mesh, fan) = self.mesh(camera, limits);
        let per_turn = 2 * self.steps.per_turn as usize;
        Ok(SurfaceFrame {
            parts: parts(&mesh, fan, per_turn, camera.eye_ecef).into(),
            ..mesh.frame(KIND, camera)?
        })
    }

    fn exact_vertices(
        &self,
        camera: &Camera,
        size: ImageSize,
    ) -> Result<Option<Vec<DVec3>>, SurfaceError> {
        let (mesh, _) = self.mesh(camera, self.limits(camera, size)?);
        let vertices = mesh.vertices_ecef.iter();
        Ok(Some(vertices.map(|v| *v - camera.eye_ecef).collect()))
    }
}

#[cfg(test)]
mod tests;
