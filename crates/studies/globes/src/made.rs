// SPDX-License-Identifier: MIT OR Apache-2.0
//! The spiral's vertices made on the GPU: by a compute shader into a buffer that is drawn and read back, or by the vertex
//! stage, from the vertex's number or one static buffer. Beside them stand those that the CPU makes and sends. Over
//! terrain each vertex is moved up by the height that it finds where it is, which the paper leaves to the future.

pub(crate) mod device;
mod heights;
mod section;
pub(crate) mod spiral;
pub(crate) mod stored;

pub(crate) use section::SECTION;

use crate::STUDY;
use crate::list::List;
use crate::metrics::{self, HEIGHTS, LAW, LOOKUP, SIZE_PX, TRIG, VERTICES, VIEW};
use crate::shading::KIND;
use device::{MadeScene, MadeTargets, Making};
use glam::DVec3;
use heights::HeightCube;
use spiral::{Law, Lookup, Source, Spiral};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use terrafill_core::Ellipsoid;
use terrafill_globe_views::{Eye, FrameWatch, Opened, fingerprint};
use terrafill_plot::number::significant;
use terrafill_results::{CaseId, PlannedCase, RunInput, Skipped, Verdict};
use terrafill_scene::Scene;
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, files_read, judged, verified,
};
use toml::Value;

/// Name of this part in cases.
pub(crate) const PART: &str = "made";

/// Vertices of a turn.
const N: u32 = 72;
/// What a vertex made in f32 may be off f64 on the screen, pixels: 8e-5 were measured in pictures of 160 rows, which is
/// 4e-4 of 800, with a margin of five.
const ALLOWED_PX: f64 = 2e-3;

const VIEWS: [&str; 5] = [
    "globe",
    "nadir-1161km",
    "oblique-100km",
    "horizon-2km",
    "ground-1.7m",
];

/// Heights of the whole Earth, read where there is data.
const ETOPO: &str = include_str!("../etopo.toml");
/// Cells along a side of a cube's face of heights: 39 km on the Earth, about as far apart as the samples of [`ETOPO`].
const HEIGHT_CELLS: u32 = 256;

/// Of the relief: a slope of 1.5 % under the eyes that are low.
const SEED: i64 = 7;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Work {
    view: &'static str,
    source: Source,
    has_series: bool,
    law: Law,
    /// Which of the height fields, and how it is read.
    terrain: Option<(usize, Lookup)>,
}

/// Height fields to move vertices by: relief from a seed, and where there is data the Earth's.
///
/// - returns: also what is left out, and the files that were read
pub(crate) fn height_fields(
    opened: &Opened,
    data_dir: Option<&Path>,
) -> (Vec<Arc<HeightCube>>, Vec<Skipped>, Vec<RunInput>) {
    let body = Ellipsoid::WGS84;
    let relief = || {
        let parameters = [("base", Value::from("relief")), ("seed", SEED.into())];
        let surface = opened.get(KIND, parameters)?;
        HeightCube::of("relief", &body, &surface, HEIGHT_CELLS)
    };
    let mut inputs = Vec::new();
    let mut earth = || {
        let scene = Scene::from_toml(ETOPO, "etopo.toml of study globes", data_dir);
        let scene = scene.map_err(|error| error.to_string())?;
        inputs = files_read(&scene);
        HeightCube::of("etopo", &body, &opened.of_scene(&scene)?, HEIGHT_CELLS)
    };
    let (mut fields, mut skipped) = (Vec::new(), Vec::new());
    for (name, field) in [("relief", relief()), ("etopo", earth())] {
        match field {
            Ok(field) => fields.push(Arc::new(field)),
            Err(reason) => skipped.push(Skipped {
                what: format!("{STUDY}/{PART} over {name}"),
                reason,
            }),
        }
    }
    (fields, skipped, inputs)
}

/// Globes whose vertices a device makes: the work of all cases, and the heights that they share.
pub(crate) struct MadeGlobes {
    work: Vec<Work>,
    list: List,
    side_px: u32,
    fields: Vec<Arc<HeightCube>>,
}

impl MadeGlobes {
    /// - `fields`: [`height_fields`]
    pub(crate) fn planned(
        list: &List,
        (side_px, samples): (u32, u32),
        fields: Vec<Arc<HeightCube>>,
    ) -> CaseGroup<Self> {
        let mut work = Vec::new();
        for view in VIEWS {
            for source in Source::ALL {
                for law in [Law::Exponential, Law::Quadratic, Law::Published] {
                    let trigonometry: &[bool] = match (source, law) {
                        // A radius that the shader makes is not rounded as a stored one, which the root magnifies.
                        (Source::Compute | Source::Number, Law::Published)
                        | (Source::Static, Law::Quadratic) => &[],
                        (Source::Sent, _) => &[false],
                        (Source::Static, _) => &[true],
                        (Source::Compute | Source::Number, _) => &[false, true],
                    };
                    work.extend(trigonometry.iter().map(|&has_series| Work {
                        view,
                        source,
                        has_series,
                        law,
                        terrain: None,
                    }));
                }
                for field in 0..fields.len() {
                    // The CPU has f64 for both.
                    let lookups: &[Lookup] = match source {
                        Source::Sent => &[Lookup::Local],
                        Source::Static => &[Lookup::Local],
                        Source::Compute | Source::Number => &[Lookup::Absolute, Lookup::Local],
                    };
                    work.extend(lookups.iter().map(|&lookup| Work {
                        view,
                        source,
                        has_series: source != Source::Sent,
                        law: Law::Exponential,
                        terrain: Some((field, lookup)),
                    }));
                }
            }
        }
        let cases = work.iter().map(|work| {
            let trig = if work.has_series { "series" } else { "native" };
            let law = work.law.name();
            let terrain = work.terrain.map(|(field, lookup)| {
                let lookup = match work.source {
                    Source::Sent => "f64",
                    Source::Compute | Source::Number | Source::Static => lookup.name(),
                };
                (fields[field].name, lookup)
            });
            let (field, lookup) = terrain.unwrap_or(("none", ""));
            let conditions = [
                (metrics::PART, PART.to_owned()),
                (VIEW, work.view.to_owned()),
                (VERTICES, work.source.name().to_owned()),
                (TRIG, trig.to_owned()),
                (LAW, law.to_owned()),
                (HEIGHTS, field.to_owned()),
                (LOOKUP, lookup.to_owned()),
                (SIZE_PX, side_px.to_string()),
            ];
            let mut name = format!("{PART}/{}/{}/{trig}/{law}", work.view, work.source.name());
            if let Some((field, lookup)) = terrain {
                name = format!("{name}/{field}/{lookup}");
            }
            PlannedCase {
                id: CaseId::new(STUDY, name, conditions),
                samples,
                // Native sines have no bound that helps, and f32 is half a metre at the Earth's radius.
                may_be_wrong: work.source != Source::Sent
                    && (!work.has_series
                        || work.terrain.is_some_and(|(_, how)| how == Lookup::Absolute)),
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                work,
                list: list.clone(),
                side_px,
                fields,
            },
            open: |group, context| {
                Ok(Box::new(JudgedOnce::new(MadePart {
                    group: &group.work,
                    context,
                    targets: None,
                    ready: BTreeMap::new(),
                })))
            },
        }
    }

    fn heights(&self, work: &Work) -> Option<&Arc<HeightCube>> {
        work.terrain.map(|(field, _)| &self.fields[field])
    }

    fn spiral(&self, eye: &Eye, work: &Work) -> Spiral {
        Spiral::new(eye, N, work.law, self.heights(work))
    }

    fn eye(&self, work: &Work) -> Result<Eye, String> {
        let view = self.list.view(work.view)?;
        let eye = view.eye(self.side_px);
        Ok(self.heights(work).map_or(eye, |heights| {
            view.eye_above(heights.height_m(eye.foot()), self.side_px)
        }))
    }
}

struct MadePart<'a> {
    group: &'a MadeGlobes,
    context: Context<'a>,
    targets: Option<MadeTargets>,
    ready: BTreeMap<usize, MadeScene>,
}

/// Vertices of the device against f64.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct VertexErrors {
    /// On the screen, pixels, and on the ground, metres, largest.
    px: f64,
    metres: f64,
    /// Of `px`, what is beyond radii kept in f32, largest.
    beyond_px: f64,
    /// How many are not finite.
    lost: usize,
}

fn against(eye: &Eye, spiral: &Spiral, made: &[[f32; 3]]) -> VertexErrors {
    let mut errors = VertexErrors::default();
    for (number, vertex) in (0..).zip(made) {
        let (found, exact) = (DVec3::from(vertex.map(f64::from)), spiral.place(number));
        if !found.is_finite() {
            errors.lost += 1;
            continue;
        }
        let angle = found.cross(exact).length().atan2(found.dot(exact));
        let px = angle * eye.focal_px();
        let rounding_px = spiral.rounding_m(number) / exact.length() * eye.focal_px();
        errors.px = errors.px.max(px);
        errors.beyond_px = errors.beyond_px.max(px - rounding_px);
        errors.metres = errors.metres.max(found.distance(exact));
    }
    errors
}

/// A picture, and the vertices that it was drawn from where they can be read back.
struct ShownSpiral {
    eye: Eye,
    spiral: Spiral,
    /// Bits of distances.
    picture: Vec<u32>,
    vertices: Option<Vec<[f32; 3]>>,
    sent: u64,
}

impl MadePart<'_> {
    /// Draws a case, or what the compute shader makes of the same view.
    fn drawn(&mut self, case: usize, is_twin: bool) -> Result<(MadeScene, ShownSpiral), Failure> {
        let work = self.group.work[case];
        let eye = self.group.eye(&work)?;
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let targets = &mut self.targets;
        let targets = match targets {
            Some(targets) => targets,
            None => targets.insert(MadeTargets::new(&gpu, eye.size, N)?),
        };
        let spiral = self.group.spiral(&eye, &work);
        let source = if is_twin {
            Source::Compute
        } else {
            work.source
        };
        let making = Making {
            source,
            lookup: work.terrain.map(|(_, lookup)| lookup),
            has_series: work.has_series,
            is_stored: work.source == Source::Static,
        };
        let mut scene = targets.scene(&spiral, making)?;
        let sent = targets.send(&mut scene, &eye, &spiral);
        targets.draw(&scene)?;
        let vertices = match source {
            Source::Sent => Some(spiral.vertices()),
            Source::Compute => Some(targets.vertices(&scene)?),
            Source::Number | Source::Static => None,
        };
        let shown = ShownSpiral {
            eye,
            spiral,
            picture: targets.read()?,
            vertices,
            sent,
        };
        Ok((scene, shown))
    }
}

impl Shows for MadePart<'_> {
    type Shown = ShownSpiral;

    fn show(&mut self, case: usize) -> Result<(String, ShownSpiral), Failure> {
        let (scene, shown) = self.drawn(case, false)?;
        self.ready.insert(case, scene);
        let vertices = shown.vertices.as_deref().unwrap_or_default();
        let [picture, vertices] = [
            bytemuck::cast_slice(&shown.picture),
            bytemuck::cast_slice(vertices),
        ];
        Ok((fingerprint(&[picture, vertices]), shown))
    }

    fn judge(&mut self, case: usize, shown: ShownSpiral) -> Result<Verdict, Failure> {
        let work = self.group.work[case];
        // The vertex stage is held to what the compute shader made of the same view.
        let (_, computed) = self.drawn(case, true)?;
        let ShownSpiral { eye, spiral, .. } = &shown;
        let made = shown.vertices.as_ref().or(computed.vertices.as_ref());
        let errors = against(eye, spiral, made.map_or(&[], Vec::as_slice));
        let VertexErrors { px, beyond_px, .. } = errors;
        let pixels = shown.picture.iter().zip(&computed.picture);
        let differs = pixels.filter(|(a, b)| a != b).count();
        let mut reasons = Vec::new();
        if errors.lost > 0 {
            reasons.push(format!(
                "{} vertices are not finite, allowed 0",
                errors.lost
            ));
        }
        if beyond_px > ALLOWED_PX {
            reasons.push(format!(
                "vertices are {} px farther off f64 than radii kept in f32, allowed {ALLOWED_PX}",
                significant(beyond_px)
            ));
        }
        let is_in_vertex_stage = matches!(work.source, Source::Number | Source::Static);
        if is_in_vertex_stage && differs > 0 {
            reasons.push(format!(
                "{differs} pixels differ from those of the vertices that the compute shader made, allowed 0"
            ));
        }
        let mut figures = vec![
            ("globe_made_px_max", px),
            ("globe_made_m_max", errors.metres),
            ("globe_made_differs_px", differs as f64),
            ("globe_non_finite", errors.lost as f64),
            ("globe_triangles", spiral.triangles().len() as f64),
            ("globe_vertices", f64::from(spiral.count())),
            ("globe_upload_bytes", shown.sent as f64),
        ];
        let targets = self
            .targets
            .as_ref()
            .filter(|_| work.source == Source::Static);
        figures.extend(targets.map(|of| ("globe_stored_bytes", of.stored_bytes() as f64)));
        let heights = self.group.heights(&work);
        figures.extend(heights.map(|field| ("globe_height_bytes", field.bytes() as f64)));
        Ok(judged(reasons.join(", "), figures, Vec::new()))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let work = self.group.work[case];
        let eye = self.group.eye(&work)?;
        let targets = self.targets.as_ref();
        let targets = targets.ok_or("it has no targets".to_owned())?;
        let scene = verified(&mut self.ready, case)?;
        let mut watch = FrameWatch::start();
        let spiral = self.group.spiral(&eye, &work);
        targets.send(scene, &eye, &spiral);
        watch.ends("globe_upload_cpu_ms");
        let gpu_ms = targets.draw(scene)?;
        Ok(watch.drawn(gpu_ms))
    }
}

#[cfg(test)]
mod tests;
