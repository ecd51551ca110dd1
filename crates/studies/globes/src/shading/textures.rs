// SPDX-License-Identifier: MIT OR Apache-2.0
//! Each layer by itself, as the paper's figures 6 and 7 have them: by longitude and latitude, and as a cube map unfolded.
//! Each pixel is held to the same texels, filtered in `f64`, in the direction that its place shows.

use super::device::LayerTextures;
use super::judge::bytes;
use super::sources::{Sources, of_uv};
use super::texels::{Looked, Pictures, Texels};
use super::way::{Layer, Shading};
use crate::STUDY;
use crate::metrics::{self, *};
use crate::wires::none_off;
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_globe_views::{Canvas, DRAW, FrameWatch, Stages, fingerprint, write_png};
use terrafill_gpu::Gpu;
use terrafill_lab::{Cases, Column, Names, Section, Select};
use terrafill_results::{Case, CaseId, Finding, PlannedCase, Verdict};
use terrafill_scene::ImageSize;
use terrafill_study::{CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, judged, verified};

/// Name of this part in cases.
pub(crate) const PART: &str = "textures";
/// Texels along a side of a cube's face: pictures by angles have 1,024 × 512 then, as the paper's have.
const FACE: u32 = 256;
/// What `f32` may add to a texel's doubt.
const SUMS: f64 = 1e-5;
/// Share of the pixels that a layer mirrored east to west must be found in.
const CONTROL_SHARE: f64 = 0.01;

pub(super) const SECTION: Section<'static> = Section {
    title: "Layers by themselves",
    text: "The pictures that the globe is shaded with, drawn by the device without a globe: by longitude and latitude, and \
           as cube maps, unfolded. Normals are shares of normal, tangent and binormal as red, green and blue. Poles are \
           drawn out by angles and are not by a cube, whose faces bend what crosses their edges. Each pixel is held to the \
           same texels, filtered in f64. A layer mirrored east to west must be found by that.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[("layer", WHAT), ("pictures", PICTURES)]),
    columns: &[
        Column::metric("px", GLOBE_SHADE_PX),
        Column::metric("px beyond 8 bits", GLOBE_SHADE_BEYOND_PX),
        Column::metric("off the texels, largest", GLOBE_SHADE_TEXELS_MAX),
        Column::metric("px found when mirrored", GLOBE_MIRRORED_PX),
        DRAW,
    ],
    pictures: &[("picture", "")],
    findings: &[exact],
    ..Section::EMPTY
};

fn exact(cases: &Cases<'_>) -> Finding {
    let beyond = |case: &Case| case.value(GLOBE_SHADE_BEYOND_PX);
    none_off(
        cases,
        "Each layer by itself is its texels in f64",
        "pixels",
        beyond,
    )
}

/// What is drawn of a layer.
#[derive(Debug, Clone, Copy)]
struct Channels {
    name: &'static str,
    layer: Layer,
    /// Its fourth channel, as grey; else the first three.
    is_alpha: bool,
}

const fn channels(name: &'static str, layer: Layer, is_alpha: bool) -> Channels {
    Channels {
        name,
        layer,
        is_alpha,
    }
}

/// In the order of the paper's figure 7.
const ALL: [Channels; 6] = [
    channels("colour", Layer::Base, false),
    channels("water", Layer::Base, true),
    channels("clouds", Layer::Clouds, false),
    channels("night", Layer::Night, false),
    channels("elevation", Layer::Bumps, true),
    channels("normals", Layer::Bumps, false),
];

/// What one case draws.
#[derive(Debug, Clone, Copy)]
struct Work {
    channels: Channels,
    by_angles: bool,
}

impl Work {
    fn shading(self) -> Shading {
        Shading {
            by_angles: self.by_angles,
            ..Shading::default()
        }
    }

    /// Of its picture: twice as wide as high, or four faces across and three down.
    fn size(self, side_px: u32) -> ImageSize {
        let face = side_px / 4;
        let height = if self.by_angles { 2 * face } else { 3 * face };
        ImageSize::new(4 * face, height)
    }

    /// The direction that a place of the picture shows; `None` beside the faces of an unfolded cube.
    ///
    /// - `at`: 0 … 1 across and down
    fn direction(self, [x, y]: [f64; 2]) -> Option<DVec3> {
        if self.by_angles {
            return Some(of_uv([x, y]));
        }
        let (x, y) = (4.0 * x, 3.0 * y);
        let (s, t) = (2.0 * x.fract() - 1.0, 2.0 * y.fract() - 1.0);
        // Over the middle of each of the row's faces, which lie a quarter of a turn apart.
        let face = x.floor();
        let row = y.floor();
        if row == 1.0 {
            let (east, ahead) = (FRAC_PI_2 * (face - 1.0)).sin_cos();
            let out = DVec3::new(ahead, east, 0.0);
            let aside = DVec3::new(-east, ahead, 0.0);
            return Some((out + s * aside - t * DVec3::Z).normalize());
        }
        let north = if row == 0.0 { 1.0 } else { -1.0 };
        (face == 1.0).then(|| DVec3::new(north * t, s, north).normalize())
    }

    fn id(self, side_px: u32) -> CaseId {
        let pictures = if self.by_angles { "angles" } else { "cube" };
        let name = self.channels.name;
        CaseId::new(
            STUDY,
            format!("{PART}/{name}/{pictures}"),
            [
                (metrics::PART, PART.to_owned()),
                (WHAT, name.to_owned()),
                (PICTURES, pictures.to_owned()),
                (SIZE_PX, side_px.to_string()),
            ],
        )
    }
}

/// Every layer in both ways to store it.
pub(crate) struct Textures {
    works: Vec<Work>,
    side_px: u32,
    sources: Rc<Sources>,
}

impl Textures {
    pub(crate) fn planned((side_px, samples): (u32, u32), sources: Rc<Sources>) -> CaseGroup<Self> {
        let works = ALL.iter().flat_map(|&channels| {
            [true, false].map(|by_angles| Work {
                channels,
                by_angles,
            })
        });
        let works: Vec<Work> = works.collect();
        let cases = works.iter().map(|work| PlannedCase {
            id: work.id(side_px),
            samples,
            may_be_wrong: false,
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                works,
                side_px,
                sources,
            },
            open: |group, context| {
                Ok(Box::new(JudgedOnce::new(TexturesPart {
                    group: &group.work,
                    context,
                    pictures: None,
                    ready: BTreeMap::new(),
                })))
            },
        }
    }
}

/// How a picture differs from the texels that it shows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct TextureErrors {
    shown: usize,
    beyond: usize,
    largest: f64,
    /// Pixels that the layer mirrored east to west does not allow.
    mirrored: usize,
}

fn judge(work: Work, size: ImageSize, texels: &Texels, picture: &[[f32; 4]]) -> TextureErrors {
    let mut found = TextureErrors::default();
    let width = size.width as usize;
    let three = |of: [f64; 4]| {
        let [r, g, b, a] = of;
        if work.channels.is_alpha {
            DVec3::splat(a)
        } else {
            DVec3::new(r, g, b)
        }
    };
    for (pixel, &[r, g, b, alpha]) in picture.iter().enumerate() {
        let at = [
            ((pixel % width) as f64 + 0.5) / f64::from(size.width),
            ((pixel / width) as f64 + 0.5) / f64::from(size.height),
        ];
        let shown = DVec3::new(r.into(), g.into(), b.into());
        let Some(direction) = work.direction(at) else {
            found.beyond += usize::from(alpha != 0.0 || shown != DVec3::ZERO);
            continue;
        };
        // How far off it is, and whether that is beyond doubt; what is no number is.
        let off = |n: DVec3| {
            let Looked { value, doubt } = texels.bilinear(n);
            let off = (shown - three(value)).abs();
            let is_right = off.cmple(three(doubt) + SUMS).all() && alpha == 1.0;
            (off.max_element(), !is_right)
        };
        let (largest, is_beyond) = off(direction);
        found.shown += 1;
        found.beyond += usize::from(is_beyond);
        found.largest = found.largest.max(largest);
        found.mirrored += usize::from(off(direction * DVec3::new(1.0, -1.0, 1.0)).1);
    }
    found
}

/// What draws a case.
struct Ready {
    canvas: Canvas,
    pipeline: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
}

impl Ready {
    fn new(
        gpu: &Arc<Gpu>,
        work: Work,
        size: ImageSize,
        textures: &LayerTextures,
    ) -> Result<Self, DeviceError> {
        let canvas = Canvas::new(gpu, size, wgpu::TextureFormat::Rgba32Float);
        let of = |view_dimension| wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension,
            multisampled: false,
        };
        let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let dimensions = [
            wgpu::TextureViewDimension::Cube,
            wgpu::TextureViewDimension::D2,
        ];
        let [cube, map] = dimensions.map(of);
        let layout = gpu.fragment_layout(PART, &[cube, map, filtering]);
        let pipeline_layout = gpu.pipeline_layout(PART, &[Some(&layout)]);
        let flag = |is_so: bool| f64::from(u8::from(is_so));
        let stages = Stages {
            module: &gpu.shader("globes/textures.wgsl")?,
            entry_points: ["vertex_main", "fragment_main"],
            constants: &[
                ("BY_ANGLES", flag(work.by_angles)),
                ("ALPHA", flag(work.channels.is_alpha)),
                ("WIDTH", f64::from(size.width)),
                ("HEIGHT", f64::from(size.height)),
            ],
            buffers: &[],
        };
        let pipeline = canvas.pipeline(PART, &pipeline_layout, &stages);
        let [cube, map] = textures.views(work.channels.layer, dimensions);
        let sampler = super::device::sampler(gpu);
        let resources = [
            wgpu::BindingResource::TextureView(&cube),
            wgpu::BindingResource::TextureView(&map),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        Ok(Self {
            pipeline,
            bound: gpu.bind(PART, &layout, resources),
            canvas,
        })
    }

    fn draw(&self) -> Result<Option<f64>, DeviceError> {
        let mut encoder = self.canvas.frame();
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.bound, &[]);
            pass.draw(0..3, 0..1);
        });
        self.canvas.finish(encoder)
    }
}

struct TexturesPart<'a> {
    group: &'a Textures,
    context: Context<'a>,
    /// As the reference reads them, and as the device does.
    pictures: Option<(Pictures, LayerTextures)>,
    ready: BTreeMap<usize, Ready>,
}

impl Shows for TexturesPart<'_> {
    type Shown = Vec<[f32; 4]>;

    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure> {
        let work = self.group.works[case];
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let sources = &self.group.sources;
        let (_, textures) = self.pictures.get_or_insert_with(|| {
            let pictures = Pictures::new(sources, FACE);
            let textures = LayerTextures::new(&gpu, &pictures);
            (pictures, textures)
        });
        let ready = Ready::new(&gpu, work, work.size(self.group.side_px), textures)?;
        ready.draw()?;
        let picture: Vec<[f32; 4]> = ready.canvas.read()?;
        self.ready.insert(case, ready);
        Ok((fingerprint(&[bytemuck::cast_slice(&picture)]), picture))
    }

    fn judge(&mut self, case: usize, picture: Self::Shown) -> Result<Verdict, Failure> {
        let work = self.group.works[case];
        let size = work.size(self.group.side_px);
        let (pictures, _) = self
            .pictures
            .as_ref()
            .ok_or("no layers were made".to_owned())?;
        let texels = pictures.read_by(work.shading())[work.channels.layer as usize];
        let found = judge(work, size, texels, &picture);
        let reason = if found.beyond > 0 {
            format!(
                "{} pixels are farther from the same texels in f64 than 8 bits of place and value explain, allowed 0",
                found.beyond
            )
        } else if (found.mirrored as f64) < CONTROL_SHARE * found.shown as f64 {
            "a layer mirrored east to west is found in less than 1 % of the pixels: the comparison sees nothing"
                .to_owned()
        } else {
            String::new()
        };
        let name = work.id(self.group.side_px).key().replace(['/', '='], "-");
        let pixels = picture.iter().map(|colour| bytes(*colour));
        let path = write_png(
            self.context.folder,
            &name,
            [size.width, size.height],
            pixels,
        )?;
        let figures = vec![
            (GLOBE_SHADE_PX.name, found.shown as f64),
            (GLOBE_SHADE_BEYOND_PX.name, found.beyond as f64),
            (GLOBE_SHADE_TEXELS_MAX.name, found.largest),
            (GLOBE_MIRRORED_PX.name, found.mirrored as f64),
        ];
        Ok(judged(reason, figures, vec![("picture", path)]))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let ready = verified(&mut self.ready, case)?;
        let watch = FrameWatch::start();
        let gpu_ms = ready.draw()?;
        Ok(watch.drawn(gpu_ms))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cube::{face_of, on_cube};
    use crate::shading::synthetic;
    use terrafill_fixtures::on_device::{on_device, verdict};
    use terrafill_results::Status;
    use terrafill_study::Group as _;

    fn cube(by_angles: bool) -> Work {
        Work {
            channels: ALL[0],
            by_angles,
        }
    }

    #[test]
    fn faces_of_an_unfolded_cube_join_and_lie_where_a_map_has_them() {
        let work = cube(false);
        let at = |x: f64, y: f64| work.direction([x / 4.0, y / 3.0]);
        // Middles: west, the meridian of Greenwich, east, the antimeridian, both poles.
        let middles = [
            [0.5, 1.5],
            [1.5, 1.5],
            [2.5, 1.5],
            [3.5, 1.5],
            [1.5, 0.5],
            [1.5, 2.5],
        ];
        let axes = [
            -DVec3::Y,
            DVec3::X,
            DVec3::Y,
            -DVec3::X,
            DVec3::Z,
            -DVec3::Z,
        ];
        for ([x, y], axis) in middles.into_iter().zip(axes) {
            let found = at(x, y).expect("a face");
            assert!((found - axis).length() < 1e-12, "{x} {y} {found}");
            let face = face_of(axis);
            assert!((on_cube(face, [0.0; 2]) - axis).length() < 1e-12);
        }
        let step = 1e-9;
        for (before, after) in [
            ([1.0 - step, 1.3], [1.0 + step, 1.3]),
            ([2.0 - step, 1.9], [2.0 + step, 1.9]),
            ([1.7, 1.0 - step], [1.7, 1.0 + step]),
            ([1.2, 2.0 - step], [1.2, 2.0 + step]),
        ] {
            let [before, after] = [before, after].map(|[x, y]| at(x, y).expect("a face"));
            assert!((before - after).length() < 1e-6, "{before} {after}");
        }
        // Negative control: beside the faces there is nothing.
        assert!(at(0.5, 0.5).is_none() && at(2.5, 2.5).is_none());
        assert!(cube(true).direction([0.1, 0.1]).is_some());
    }

    #[test]
    fn layers_by_themselves_are_their_texels_and_a_wrong_pixel_is_found() {
        on_device(terrafill_gpu::shared_gpu, |context| {
            let group = Textures::planned((128, 1), Rc::new(synthetic::sources()));
            assert_eq!(group.cases.len(), 12);
            let mut session = group.open(context).expect("opens");
            for (case, work) in group.work.works.iter().enumerate() {
                let verdict = verdict(&mut *session, case, work);
                assert_eq!(verdict.status, Status::Ok, "{work:?}: {}", verdict.reason);
                assert!(session.time(case).is_ok());
            }
        });
        let pictures = Pictures::new(&synthetic::sources(), 32);
        for work in [cube(true), cube(false)] {
            let size = work.size(64);
            let texels = pictures.read_by(work.shading())[0];
            let pixel = |pixel: usize| {
                let width = size.width as usize;
                let at = [
                    ((pixel % width) as f64 + 0.5) / f64::from(size.width),
                    ((pixel / width) as f64 + 0.5) / f64::from(size.height),
                ];
                let value = |n| {
                    let [r, g, b, _] = texels.bilinear(n).value;
                    DVec3::new(r, g, b).extend(1.0).as_vec4().to_array()
                };
                work.direction(at).map_or([0.0; 4], value)
            };
            let mut picture: Vec<[f32; 4]> = (0..size.pixel_count()).map(pixel).collect();
            let right = judge(work, size, texels, &picture);
            assert_eq!(right.beyond, 0, "{right:?}");
            assert!(right.mirrored > right.shown / 10, "{right:?}");
            // Negative controls: a pixel of another colour, one that is no number, and one beside the faces.
            let middle = size.pixel_count() / 2 + size.width as usize / 2;
            picture[middle][1] += 0.1;
            picture[middle + 1][0] = f32::NAN;
            picture[0] = [1.0; 4];
            assert_eq!(judge(work, size, texels, &picture).beyond, 3);
        }
    }
}
