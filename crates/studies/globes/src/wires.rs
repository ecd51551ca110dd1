// SPDX-License-Identifier: MIT OR Apache-2.0
//! Edges of every surface's triangles as lines, as the spiral's paper shows its tessellation (figures 3 to 5). Each line
//! is held to its triangle's corners in `f64`, both ways.

use crate::STUDY;
use crate::list::{SurfaceRow, number};
use crate::metrics::{self, *};
use crate::sight::Chosen;
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use terrafill_contract::{DeviceError, ViewConstants};
use terrafill_globe_views::{
    Canvas, DRAW, Eye, FrameWatch, Opened, Stages, ViewRow, fingerprint, uniform, vertices,
    view_constants, write_png, written,
};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_results::{Case, CaseId, Finding, PlannedCase, Verdict};
use terrafill_study::{CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, judged, verified};
use terrafill_surface::SurfaceFrame;

/// Name of this part in cases.
const PART: &str = "wires";
/// A globe as a whole, and the same surfaces from nearer.
const VIEWS: [&str; 2] = ["globe", "nadir-1161km"];
/// How far a line's pixels may lie from it: half a pixel across and along, and corners in steps of 1/256.
const NEAR_PX: f64 = 1.0;
/// Shorter lines may light no pixel by the rules of rasterisation.
const SHORT_PX: f64 = 2.0;
/// By what the negative control moves the picture.
const MOVED_PX: [i32; 2] = [5, 3];
/// Share of the lit pixels that must then be found wrong.
const CONTROL_SHARE: f64 = 0.01;

pub(crate) const SECTION: Section<'static> = Section {
    title: "Surfaces by their edges",
    text: "Edges of the triangles that face the eye, as lines: where a surface spends its triangles, at one value of its \
           knob. A lit pixel lies at most a pixel from a line in f64, and each line of two pixels or more lights a \
           pixel at its middle. A picture moved by a few pixels must be found by that. The spiral's radius grows \
           exponentially, or by the paper's correction. Where its step does not divide a turn, corners of neighbouring \
           turns do not meet.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[
        ("view", VIEW),
        ("surface", SURFACE),
        ("knob", KNOB),
        ("value", VALUE),
    ]),
    columns: &[
        Column::metric("triangles", GLOBE_TRIANGLES),
        Column::metric("lines", GLOBE_WIRES),
        Column::metric("lit px", GLOBE_WIRE_PX),
        Column::metric("px off every line", GLOBE_WIRE_BEYOND_PX),
        Column::metric("lines without a pixel", GLOBE_WIRE_MISSING),
        Column::metric("px found when moved", GLOBE_WIRE_CONTROL_PX),
        DRAW,
    ],
    pictures: &[("picture", "")],
    findings: &[exact],
    ..Section::EMPTY
};

fn exact(cases: &Cases<'_>) -> Finding {
    let wrong =
        |case: &Case| Some(case.value(GLOBE_WIRE_BEYOND_PX)? + case.value(GLOBE_WIRE_MISSING)?);
    let claim = "Lines are the edges of the triangles in f64, both ways";
    none_off(cases, claim, "pixels and lines", wrong)
}

/// Whether nothing is off in any picture.
///
/// - `what`: may be off, in the plural
/// - `off`: how many of a case are; `None` where it was not drawn
pub(crate) fn none_off(
    cases: &Cases<'_>,
    claim: &str,
    what: &str,
    off: impl Fn(&Case) -> Option<f64>,
) -> Finding {
    let all: Vec<f64> = cases.iter().filter_map(off).collect();
    let most = all.iter().copied().reduce(f64::max);
    finding(
        claim,
        most.map(|most| most == 0.0),
        most.map_or_else(String::new, |most| {
            format!("{most} {what} off at most, of {} pictures.", all.len())
        }),
    )
}

/// A surface with a value of its knob, in a view.
struct Work {
    view: ViewRow,
    surface: Chosen,
}

/// Every surface in both views.
pub(crate) struct Wires {
    works: Vec<Work>,
    side_px: u32,
    opened: Rc<Opened>,
}

impl Wires {
    pub(crate) fn planned(
        views: &[ViewRow],
        rows: &[SurfaceRow],
        (side_px, samples): (u32, u32),
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let views = views
            .iter()
            .filter(|view| VIEWS.contains(&view.name.as_str()));
        let works = views.flat_map(|view| {
            let surfaces = rows.iter().filter_map(Chosen::pictured);
            surfaces.map(|surface| Work {
                view: view.clone(),
                surface,
            })
        });
        let works: Vec<Work> = works.collect();
        let cases = works.iter().map(|work| {
            let row = &work.surface.row;
            let value = number(&work.surface.value).unwrap_or(f64::NAN).to_string();
            let view = &work.view.name;
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    format!("{PART}/{view}/{}/{}={value}", row.name, row.knob),
                    [
                        (metrics::PART, PART.to_owned()),
                        (VIEW, view.clone()),
                        (SURFACE, row.name.clone()),
                        (KNOB, row.knob.clone()),
                        (VALUE, value),
                        (SIZE_PX, side_px.to_string()),
                    ],
                ),
                samples,
                may_be_wrong: false,
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                works,
                side_px,
                opened: Rc::clone(opened),
            },
            open: |group, context| {
                Ok(Box::new(JudgedOnce::new(WirePart {
                    group: &group.work,
                    cases: &group.cases,
                    context,
                    pen: None,
                    ready: BTreeMap::new(),
                })))
            },
        }
    }
}

/// Corners of triangles relative to the eye, metres, and which of them lines join.
pub(crate) struct Edges {
    pub(crate) corners: Vec<[f32; 3]>,
    pub(crate) lines: Vec<[u32; 2]>,
    pub(crate) triangles: usize,
}

/// Of the triangles that face the eye, each edge once.
fn edges(frame: &SurfaceFrame) -> Edges {
    let at = |corner: u32| DVec3::from(frame.vertices_rte[corner as usize].map(f64::from));
    let faces = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(at);
        // The eye is at 0; outside is where corners go round against the clock.
        (b - a).cross(c - a).dot(a) < 0.0
    };
    let facing = frame
        .triangles
        .iter()
        .copied()
        .filter(|corners| faces(*corners));
    let of = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    let lines: BTreeSet<[u32; 2]> = facing
        .flat_map(of)
        .map(|[from, to]| [from.min(to), from.max(to)])
        .collect();
    Edges {
        corners: frame.vertices_rte.to_vec(),
        lines: lines.into_iter().collect(),
        triangles: frame.triangles.len(),
    }
}

/// How a picture of lines differs from them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct WireErrors {
    lit: usize,
    /// Lit pixels that are near no line.
    beyond: usize,
    /// Lines without a pixel at their middle.
    missing: usize,
    /// Lit pixels near no line, were the picture moved.
    control: usize,
}

impl WireErrors {
    /// Why the picture is wrong; empty where it is not.
    pub(crate) fn reason(&self) -> String {
        let Self {
            lit,
            beyond,
            missing,
            control,
        } = *self;
        if lit == 0 {
            "it shows no line".to_owned()
        } else if beyond + missing > 0 {
            format!(
                "{beyond} pixels lie off every line and {missing} lines light no pixel, allowed 0"
            )
        } else if (control as f64) < CONTROL_SHARE * lit as f64 {
            "a picture that is moved is found in less than 1 % of its pixels: the comparison sees nothing".to_owned()
        } else {
            String::new()
        }
    }

    /// What is counted of a picture of these edges.
    pub(crate) fn figures(&self, edges: &Edges) -> Figures {
        vec![
            ("globe_triangles", edges.triangles as f64),
            ("globe_wires", edges.lines.len() as f64),
            ("globe_wire_px", self.lit as f64),
            ("globe_wire_beyond_px", self.beyond as f64),
            ("globe_wire_missing", self.missing as f64),
            ("globe_wire_control_px", self.control as f64),
        ]
    }
}

/// Lines in pixels; none of those that begin or end behind the near plane.
pub(crate) fn in_pixels(eye: &Eye, edges: &Edges) -> Vec<[DVec2; 2]> {
    let place = |corner: u32| {
        let relative = DVec3::from(edges.corners[corner as usize].map(f64::from));
        let at = eye
            .camera
            .project_px(eye.size, eye.camera.eye_ecef + relative)?;
        Some(DVec2::from(at))
    };
    let lines = edges.lines.iter();
    lines
        .filter_map(|&[from, to]| Some([place(from)?, place(to)?]))
        .collect()
}

/// Compares a picture with the lines that it shows.
///
/// - `lit`: row by row from the top
#[allow(
    clippy::cast_possible_truncation,
    reason = "places in a picture, and steps along a line in it"
)]
pub(crate) fn judge([width, height]: [u32; 2], lines: &[[DVec2; 2]], lit: &[bool]) -> WireErrors {
    let [columns, rows] = [width, height].map(i64::from);
    let index = |column: i64, row: i64| {
        let is_inside = (0..columns).contains(&column) && (0..rows).contains(&row);
        is_inside.then(|| usize::try_from(row * columns + column).unwrap_or(0))
    };
    // Pixels whose centres are near a place on a line.
    let around = |place: DVec2| {
        let [x, y] = place.floor().to_array().map(|at| at as i64);
        let beside = (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| [x + dx, y + dy]));
        beside.filter_map(move |[column, row]| {
            let centre = DVec2::new(column as f64, row as f64) + 0.5;
            let is_near = (centre - place).abs().max_element() <= NEAR_PX;
            is_near.then(|| index(column, row)).flatten()
        })
    };
    let mut is_near = vec![false; lit.len()];
    let mut found = WireErrors::default();
    for &[from, to] in lines {
        let length = (to - from).length();
        // Half a pixel of a place is at most half a pixel from a sample of the line.
        let steps = (2.0 * length).ceil().max(1.0);
        let samples = (0..=steps as usize).map(|step| from.lerp(to, step as f64 / steps));
        for pixel in samples.flat_map(around) {
            is_near[pixel] = true;
        }
        let middle = from.lerp(to, 0.5);
        let end = DVec2::new(f64::from(width), f64::from(height)) - NEAR_PX;
        let is_inside = middle.cmpge(DVec2::splat(NEAR_PX)).all() && middle.cmple(end).all();
        if length >= SHORT_PX && is_inside && !around(middle).any(|pixel| lit[pixel]) {
            found.missing += 1;
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let Some(pixel) = index(column, row).filter(|pixel| lit[*pixel]) else {
                continue;
            };
            found.lit += 1;
            found.beyond += usize::from(!is_near[pixel]);
            let [x, y] = MOVED_PX.map(i64::from);
            let moved = index(column + x, row + y);
            found.control += usize::from(moved.is_some_and(|moved| !is_near[moved]));
        }
    }
    found
}

/// What draws lines, or triangles.
pub(crate) struct Pen {
    canvas: Canvas,
    pipeline: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    bound: wgpu::BindGroup,
}

/// Lines or triangles on the device.
pub(crate) struct Ready {
    eye: Eye,
    corners: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

impl Pen {
    pub(crate) fn new(
        context: Context<'_>,
        eye: &Eye,
        topology: wgpu::PrimitiveTopology,
    ) -> Result<Self, DeviceError> {
        let gpu = terrafill_gpu::shared_gpu(context.devices)?;
        let canvas = Canvas::new(&gpu, eye.size, wgpu::TextureFormat::R8Unorm);
        let types = [wgpu::BufferBindingType::Uniform];
        let view_layout = gpu.buffer_layout("wires", wgpu::ShaderStages::VERTEX, &types);
        let layout = gpu.pipeline_layout("wires", &[Some(&view_layout)]);
        let attributes = wgpu::vertex_attr_array![0 => Float32x3];
        let stages = Stages {
            module: &gpu.shader("globes/wires.wgsl")?,
            entry_points: ["vertex_main", "fragment_main"],
            constants: &[],
            buffers: &[vertices(&attributes)],
        };
        let pipeline = canvas.pipeline_of(topology, "wires", &layout, &stages);
        let view = uniform::<ViewConstants>(&gpu, "view constants");
        Ok(Self {
            pipeline,
            bound: gpu.bind_buffers("view", &view_layout, &[&view]),
            view,
            canvas,
        })
    }

    /// - `corners`: relative to the eye, metres
    /// - `indices`: which of them lines or triangles join
    pub(crate) fn ready(&self, eye: Eye, corners: &[[f32; 3]], indices: &[u32]) -> Ready {
        let gpu = &self.canvas.gpu;
        let buffer = |label, bytes: &[u8], usage| {
            let buffer = written(gpu, label, bytes.len().max(4) as u64, usage);
            gpu.write_buffer(&buffer, 0, bytes);
            buffer
        };
        Ready {
            eye,
            corners: buffer(
                "corners",
                bytemuck::cast_slice(corners),
                wgpu::BufferUsages::VERTEX,
            ),
            indices: buffer(
                "indices",
                bytemuck::cast_slice(indices),
                wgpu::BufferUsages::INDEX,
            ),
            count: u32::try_from(indices.len()).unwrap_or(u32::MAX),
        }
    }

    pub(crate) fn draw(&self, ready: &Ready) -> Result<Option<f64>, DeviceError> {
        let gpu = &self.canvas.gpu;
        gpu.write_buffer(
            &self.view,
            0,
            bytemuck::bytes_of(&view_constants(&ready.eye)),
        );
        let mut encoder = self.canvas.frame();
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.bound, &[]);
            pass.set_vertex_buffer(0, ready.corners.slice(..));
            pass.set_index_buffer(ready.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..ready.count, 0, 0..1);
        });
        self.canvas.finish(encoder)
    }

    /// A byte a pixel, row by row from the top: 0 where nothing is drawn.
    pub(crate) fn read(&self) -> Result<Vec<u8>, DeviceError> {
        self.canvas.read()
    }
}

struct WirePart<'a> {
    group: &'a Wires,
    cases: &'a [PlannedCase],
    context: Context<'a>,
    /// All pictures have one size.
    pen: Option<Rc<Pen>>,
    ready: BTreeMap<usize, Ready>,
}

impl WirePart<'_> {
    fn pen(&mut self, eye: &Eye) -> Result<Rc<Pen>, DeviceError> {
        if let Some(pen) = &self.pen {
            return Ok(Rc::clone(pen));
        }
        let pen = Rc::new(Pen::new(
            self.context,
            eye,
            wgpu::PrimitiveTopology::LineList,
        )?);
        self.pen = Some(Rc::clone(&pen));
        Ok(pen)
    }
}

/// A picture, and what it is of.
struct Drawn {
    eye: Eye,
    edges: Edges,
    lit: Vec<bool>,
}

impl Shows for WirePart<'_> {
    type Shown = Drawn;

    fn show(&mut self, case: usize) -> Result<(String, Drawn), Failure> {
        let Wires {
            works,
            side_px,
            opened,
        } = self.group;
        let Work { view, surface } = &works[case];
        let eye = view.eye(*side_px);
        let surface = opened.get(&surface.row.kind, surface.parameters())?;
        let frame = surface.frame(&eye.camera, eye.size);
        let edges = edges(&frame.map_err(|error| error.to_string())?);
        let pen = self.pen(&eye)?;
        let ready = pen.ready(eye, &edges.corners, edges.lines.as_flattened());
        pen.draw(&ready)?;
        let bytes = pen.read()?;
        self.ready.insert(case, ready);
        let lit = bytes.iter().map(|byte| *byte != 0).collect();
        Ok((fingerprint(&[&bytes]), Drawn { eye, edges, lit }))
    }

    fn judge(&mut self, case: usize, drawn: Drawn) -> Result<Verdict, Failure> {
        let Drawn { eye, edges, lit } = drawn;
        let size = [eye.size.width, eye.size.height];
        let found = judge(size, &in_pixels(&eye, &edges), &lit);
        let name = self.cases[case].id.key().replace(['/', '=', ' '], "-");
        let pixels = lit.iter().map(|is_lit| [if *is_lit { 255 } else { 0 }; 3]);
        let path = write_png(self.context.folder, &name, size, pixels)?;
        let figures = found.figures(&edges);
        Ok(judged(found.reason(), figures, vec![("picture", path)]))
    }

    /// Drawing alone: lines stay on the device.
    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let pen = self.pen.clone().ok_or("it has no pen".to_owned())?;
        let ready = verified(&mut self.ready, case)?;
        let watch = FrameWatch::start();
        let gpu_ms = pen.draw(ready)?;
        Ok(watch.drawn(gpu_ms))
    }
}

#[cfg(test)]
mod tests;
