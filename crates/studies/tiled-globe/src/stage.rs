// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles across ±180° split by a geometry shader, as published, and by the CPU, on Vulkan, under tiles of a map. Each
//! texel holds its own address in 24 bits, so that a picture says which texel every pixel shows.

mod section;

pub(crate) use section::SECTION;

use super::device::{MapConstants, keys};
use super::mesh::{MapMesh, MapVertex, map_mesh};
use super::options::{Options, Seam};
use super::steps::step_texels;
use super::tile_set::{SIDE, Shown, address, shown};
use super::tiles::{grid, judge, may_be_wrong, seam_reason};
use super::truth::{Tile, Truth, tiles, truths};
use crate::metrics::{self, LIMIT, SIZE_PX, SPLIT_BY, VIEW};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Picture, ViewConstants};
use terrafill_globe_views::{Eye, FrameWatch, Opened, STUDY, ViewRow, fingerprint, view_constants};
use terrafill_results::{CaseId, PlannedCase, Verdict, quantile};
use terrafill_study::{CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, judged};
use terrafill_vulkan::{
    BlockImage, Buffer, BufferUse, DirectDraw, DrawCall, DrawPipeline, GeometryOutput, Gpu,
    ImageShape, Measured, PrimitiveStages, RenderTargets, Resource, Resources, Shader, Topology,
    VertexFormat,
};

/// Name of this part in cases.
pub(crate) const PART: &str = "seams";

/// Who splits, and where two corners' U differ by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Splitter {
    Nobody,
    Cpu(f64),
    Geometry(f64),
}

impl Splitter {
    const ALL: [Self; 5] = [
        Self::Nobody,
        Self::Cpu(0.7),
        Self::Cpu(0.5),
        Self::Geometry(0.7),
        Self::Geometry(0.5),
    ];

    fn names(self) -> [String; 2] {
        match self {
            Self::Nobody => ["nobody".to_owned(), String::new()],
            Self::Cpu(limit) => ["cpu".to_owned(), limit.to_string()],
            Self::Geometry(limit) => ["geometry-shader".to_owned(), limit.to_string()],
        }
    }

    /// Compiled for the limit.
    fn shader(self) -> Option<GeometryOutput> {
        let name = match self {
            Self::Geometry(limit) if limit > 0.5 => "globes/seam.published.spv",
            Self::Geometry(_) => "globes/seam.half.spv",
            Self::Nobody | Self::Cpu(_) => return None,
        };
        Some(GeometryOutput {
            name,
            vertices: 9,
            // A position, the place from the eye, U with its twin, and V': each location counts as a whole of four.
            components: 16,
        })
    }

    fn seam(self) -> Seam {
        match self {
            Self::Cpu(limit) => Seam::Split(limit),
            Self::Nobody | Self::Geometry(_) => Seam::None,
        }
    }

    /// What pixels show of the seam, whoever splits.
    fn keeps(self) -> Seam {
        match self {
            Self::Nobody => Seam::None,
            Self::Cpu(limit) | Self::Geometry(limit) => Seam::Split(limit),
        }
    }
}

/// A view, and who splits.
pub(crate) struct Stages {
    eye: Eye,
    opened: Rc<Opened>,
}

impl Stages {
    pub(crate) fn planned(
        view: &ViewRow,
        (side_px, samples): (u32, u32),
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let eye = view.eye(side_px);
        let cases = Splitter::ALL.map(|splitter| {
            let [by, limit] = splitter.names();
            let name = format!("{PART}/{}/{by}{limit}", view.name);
            let conditions = [
                (metrics::PART, PART.to_owned()),
                (VIEW, view.name.clone()),
                (SPLIT_BY, by),
                (LIMIT, limit),
                (SIZE_PX, side_px.to_string()),
            ];
            PlannedCase {
                id: CaseId::new(STUDY, name, conditions),
                samples,
                may_be_wrong: may_be_wrong(&eye, splitter.keeps()),
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}/{}", view.name),
            cases: cases.into(),
            warm_up: None,
            work: Self {
                eye,
                opened: Rc::clone(opened),
            },
            open: |group, context| {
                Ok(Box::new(JudgedOnce::new(StagePart {
                    group: &group.work,
                    context,
                    targets: None,
                    truths: None,
                    tiles: None,
                    ready: BTreeMap::new(),
                })))
            },
        }
    }

    fn options(splitter: Splitter) -> Options {
        Options {
            seam: splitter.seam(),
            ..Options::BASE
        }
    }
}

struct Ready {
    pipeline: DrawPipeline,
    view: Arc<Buffer>,
    map: Arc<Buffer>,
    vertices: Arc<Buffer>,
}

/// Tiles, and their texels.
type TileImage = (Vec<Tile>, Arc<BlockImage>);

struct StagePart<'a> {
    group: &'a Stages,
    context: Context<'a>,
    targets: Option<RenderTargets>,
    truths: Option<Rc<Vec<Option<Truth>>>>,
    tiles: Option<Rc<TileImage>>,
    ready: BTreeMap<usize, Ready>,
}

/// Tiles that 24 bits number, with 0 left out.
const MAX_TILES: u64 = 255;

/// What each pixel shows: alpha says whether there is a surface.
fn shown_by(picture: &Picture, tiles: &[Tile]) -> Vec<Shown> {
    let pixels = picture.rgba.chunks_exact(4);
    let of_pixel = |pixel: &[u8]| match [0, 1, 2, 3].map(|i| u32::from(pixel[i])) {
        [.., 0] => Shown::Nothing,
        [0, 0, 0, _] => Shown::Missing,
        [r, g, b, _] => shown(tiles, r << 16 | g << 8 | b),
    };
    pixels.map(of_pixel).collect()
}

/// Tiles whose texels hold their address.
fn layers(gpu: &Arc<Gpu>, tiles: &[Tile]) -> Result<BlockImage, DeviceError> {
    DeviceError::check_capacity("tiles that 24 bits number", tiles.len() as u64, MAX_TILES)?;
    let count = u32::try_from(tiles.len()).unwrap_or(u32::MAX);
    let image = BlockImage::new(gpu, [SIDE; 2], ImageShape::Array(count))?;
    for tile in 0..count {
        // Below 2^24.
        let texels: Vec<f32> = (0..SIDE * SIDE)
            .map(|texel| address(tile, texel) as f32)
            .collect();
        image.write([0, 0, tile], [SIDE; 2], &texels)?;
    }
    Ok(image)
}

impl StagePart<'_> {
    fn mesh(&self, splitter: Splitter) -> Result<(MapMesh, Vec<Option<Truth>>), String> {
        let eye = &self.group.eye;
        let options = Stages::options(splitter);
        let surface = grid(&self.group.opened, options.n)?;
        let frame = surface.frame(&eye.camera, eye.size);
        let frame = frame.map_err(|error| error.to_string())?;
        let mesh = map_mesh(&eye.body, &eye.camera, &frame, &options);
        let truths = match self.truths {
            Some(_) => Vec::new(),
            None => truths(eye, &frame),
        };
        Ok((mesh, truths))
    }

    fn open(
        &mut self,
        gpu: &Arc<Gpu>,
        splitter: Splitter,
        count: usize,
        tiles: &TileImage,
    ) -> Result<Ready, DeviceError> {
        if self.targets.is_none() {
            self.targets = Some(RenderTargets::new(gpu, self.group.eye.size)?);
        }
        let buffer = |what, bytes: usize, of| -> Result<Arc<Buffer>, DeviceError> {
            Ok(Arc::new(Buffer::streamed(gpu, what, bytes as u64, of)?))
        };
        let view = buffer(
            "view constants",
            size_of::<ViewConstants>(),
            BufferUse::Uniform,
        )?;
        let map = buffer(
            "map constants",
            size_of::<MapConstants>(),
            BufferUse::Uniform,
        )?;
        let keys = keys(&tiles.0);
        let list = buffer("tiles", size_of_val(keys.as_slice()), BufferUse::Storage)?;
        list.stream(bytemuck::cast_slice(&keys))?;
        let bytes = count * size_of::<MapVertex>();
        let vertices = buffer("map vertices", bytes, BufferUse::Storage)?;
        let resources = vec![
            Resource::Uniform(Arc::clone(&view)),
            Resource::Uniform(Arc::clone(&map)),
            Resource::Storage(list),
            Resource::Storage(Arc::clone(&vertices)),
            Resource::Blocks(Arc::clone(&tiles.1)),
        ];
        let resources = Resources::new(gpu, resources)?;
        let shader = |entry_point| Shader::Wgsl {
            path: "globes/seam.wgsl",
            entry_point,
        };
        let stages = PrimitiveStages::Vertices {
            vertex: shader("pulled_vertex"),
            geometry: splitter.shader(),
            format: VertexFormat::Number,
            topology: Topology::Triangles,
        };
        Ok(Ready {
            pipeline: DrawPipeline::new(gpu, &resources, stages, shader("addressed"))?,
            view,
            map,
            vertices,
        })
    }

    fn draw(
        &mut self,
        ready: &Ready,
        splitter: Splitter,
        vertices: &[MapVertex],
        measured: Measured,
    ) -> Result<Option<f64>, DeviceError> {
        let eye = &self.group.eye;
        ready
            .view
            .stream(bytemuck::bytes_of(&view_constants(eye)))?;
        let count = self.tiles.as_ref().map_or(0, |tiles| tiles.0.len());
        let map = MapConstants::new(eye, &Stages::options(splitter), count, None);
        ready.map.stream(bytemuck::bytes_of(&map))?;
        ready.vertices.stream(bytemuck::cast_slice(vertices))?;
        let count = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
        let whole = 0..count;
        let draw = DirectDraw {
            pipeline: &ready.pipeline,
            vertices: None,
            call: DrawCall::Vertices(std::slice::from_ref(&whole)),
        };
        let targets = self.targets.as_mut();
        let targets = targets.ok_or(DeviceError::Missing("targets of the seam"))?;
        Ok(targets.draw_directly(None, &draw, measured)?.gpu_ms)
    }
}

impl Shows for StagePart<'_> {
    type Shown = (MapMesh, Picture);

    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure> {
        let splitter = Splitter::ALL[case];
        let (mesh, truths) = self.mesh(splitter)?;
        let truths = Rc::clone(self.truths.get_or_insert_with(|| Rc::new(truths)));
        let gpu = terrafill_vulkan::shared_gpu(self.context.devices)?;
        let tiles = if let Some(known) = &self.tiles {
            Rc::clone(known)
        } else {
            let tiles = tiles(&truths, &Stages::options(splitter));
            let image = layers(&gpu, &tiles)?;
            Rc::new((tiles, Arc::new(image)))
        };
        self.tiles = Some(Rc::clone(&tiles));
        let ready = self.open(&gpu, splitter, mesh.vertices.len(), &tiles)?;
        self.draw(&ready, splitter, &mesh.vertices, Measured::Nothing)?;
        let targets = self.targets.as_ref();
        let picture = targets
            .ok_or(DeviceError::Missing("targets of the seam"))?
            .read()?;
        self.ready.insert(case, ready);
        let vertices = bytemuck::cast_slice(&mesh.vertices);
        let hash = fingerprint(&[vertices, &picture.rgba]);
        Ok((hash, (mesh, picture)))
    }

    fn judge(&mut self, case: usize, (mesh, picture): Self::Shown) -> Result<Verdict, Failure> {
        let splitter = Splitter::ALL[case];
        let known = self.truths.as_ref().zip(self.tiles.as_ref());
        let (truths, tiles) = known.ok_or("it was not drawn".to_owned())?;
        let options = Stages::options(splitter);
        let at_hand = tiles.0.iter().copied().collect();
        let found = judge(truths, &shown_by(&picture, &tiles.0), &options, &at_hand);
        let step = step_texels(&self.group.eye, splitter.keeps());
        let reason = seam_reason(&found, step);
        let sent = std::mem::size_of_val(mesh.vertices.as_slice());
        let mut figures = vec![
            ("globe_tile_px", found.drawn.len() as f64),
            ("globe_tile_seam_px", found.seam_px as f64),
            ("globe_tile_seam_wrong_px", found.seam_wrong_px as f64),
            ("globe_tile_missing_px", found.missing_px as f64),
            ("globe_tile_count", tiles.0.len() as f64),
            ("globe_tile_crossing", mesh.crossing as f64),
            ("globe_triangles", (mesh.vertices.len() / 3) as f64),
            ("globe_upload_bytes", sent as f64),
        ];
        figures.extend(quantile(&found.drawn, 1.0).map(|worst| ("globe_tile_texels_max", worst)));
        figures.extend(step.map(|step| ("globe_tile_step_texels", step)));
        // What a geometry shader leaves whole nobody counts but it.
        if splitter.shader().is_none() {
            figures.push(("globe_tile_missed", mesh.missed as f64));
        }
        Ok(judged(reason, figures, Vec::new()))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let ready = self.ready.remove(&case);
        let ready = ready.ok_or("it was not verified".to_owned())?;
        let mut watch = FrameWatch::start();
        let (mesh, _) = self.mesh(Splitter::ALL[case])?;
        watch.ends("globe_make_cpu_ms");
        let gpu_ms = self.draw(&ready, Splitter::ALL[case], &mesh.vertices, Measured::Times);
        self.ready.insert(case, ready);
        Ok(watch.drawn(gpu_ms?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::views::tiled_view;
    use terrafill_fixtures::on_device::{on_device, verdict};
    use terrafill_results::Status;
    use terrafill_screen_grid::ScreenGridKind;
    use terrafill_study::Group as _;

    #[test]
    fn a_geometry_shader_keeps_the_seam_as_the_cpu_does() {
        on_device(terrafill_vulkan::shared_gpu, |context| {
            let view = tiled_view("globe-antimeridian");
            let opened = Rc::new(Opened::new(&[&ScreenGridKind]));
            let stages = Stages::planned(&view, (160, 1), &opened);
            let mut session = stages.open(context).expect("opens");
            for (case, splitter) in Splitter::ALL.iter().enumerate() {
                let verdict = verdict(&mut *session, case, splitter);
                match splitter {
                    Splitter::Cpu(limit) if *limit <= 0.5 => assert_eq!(verdict.status, Status::Ok),
                    // A device without geometry shaders skips it.
                    Splitter::Geometry(limit) if *limit <= 0.5 => {
                        assert_ne!(verdict.status, Status::Wrong, "{}", verdict.reason);
                        assert_ne!(verdict.status, Status::Failed, "{}", verdict.reason);
                        if verdict.status == Status::Ok {
                            assert!(session.time(case).is_ok());
                        }
                    }
                    // Negative control: with nobody, pixels beside the seam are wrong.
                    Splitter::Nobody => assert_eq!(verdict.status, Status::Wrong),
                    _ => {}
                }
            }
        });
    }
}
