// SPDX-License-Identifier: MIT OR Apache-2.0
//! Craters where balls have struck, written into the layers of an array texture: drawn into them, or written by the CPU.
//!
//! A layer that is drawn into cannot be read: what was there is copied into a texture of its own first. The reference are
//! the same craters in `f64`; the ground is then drawn from its layers, and rays over the heights that the device has
//! judge the picture.

use super::ground::BlockGround;
use super::on_wgpu::{OnWgpu, texture, write as write_block};
use super::study::ray_every;
use crate::STUDY;
use crate::cache::keep::Keep;
use crate::draws::{Draws as _, Times};
use crate::images::{of_relief, size_px, write};
use crate::metrics::{self, CRATER_WAY, CRATERS, EXPERIMENT, GRID_CELLS};
use crate::on_wgpu::{storage_type, texture_type, uniform_type};
use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use std::collections::BTreeMap;
use terrafill_contract::{CpuStopwatch, DeviceError, ids_of};
use terrafill_gpu::{PassTimer, TimedPass, read_texture};
use terrafill_results::{SplitMix64, Verdict};
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::{GridCamera, nearest};
use terrafill_shapes::rays::Rays;
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, Group, Session, judged, planned_case, verified,
};

/// Blocks a side and cells a side of a block.
const GROUND: [u32; 2] = [4, 256];
const QUICK_GROUND: [u32; 2] = [4, 32];
const COUNTS: [u32; 3] = [16, 256, 1_024];
const QUICK_COUNTS: [u32; 1] = [16];
/// Radius, metres: of the smallest and of the largest, and its share that a crater is deep.
const RADIUS_M: [f64; 2] = [20.0, 60.0];
const DEPTH: f64 = 0.25;
/// What a height may differ by, metres. A dozen craters may lie over each other, and each rounds heights up to 200 m by
/// 7.6 µm.
const ALLOWED_M: f64 = 1e-4;

terrafill_results::named! {
    /// How craters come into the layers.
    all pub(crate) enum CraterWay {
        /// Layers are drawn into, as published.
        Drawn = "drawn-into-layers",
        /// The CPU writes the layers anew.
        Written = "written-by-cpu",
    }
}

/// Twin of `Crater` in `pipelines/craters.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Crater {
    place: [f32; 2],
    radius: f32,
    depth: f32,
}

/// Twin of `CraterConstants` in `pipelines/craters.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct CraterConstants {
    first: [u32; 2],
    count: u32,
    padding: u32,
}

impl Crater {
    /// Anywhere on the ground, of seeded sizes.
    fn many(ground: &BlockGround, count: u32) -> Vec<Self> {
        let mut random = SplitMix64::new(7);
        let cells = f64::from(ground.grid.cells);
        let step_m = ground.grid.step_m();
        let crater = |_| {
            let place = [0; 2].map(|_| nearest(cells * random.unit()));
            let radius_m = RADIUS_M[0] + (RADIUS_M[1] - RADIUS_M[0]) * random.unit();
            Self {
                place,
                radius: nearest(radius_m / step_m),
                depth: nearest(DEPTH * radius_m),
            }
        };
        (0..count).map(crater).collect()
    }

    /// How much deeper a vertex is for it, in `f64`.
    fn below(&self, column: u32, row: u32) -> f64 {
        let [x, y] = self.place.map(f64::from);
        let away = DVec2::new(f64::from(column) - x, f64::from(row) - y) / f64::from(self.radius);
        f64::from(self.depth) * (1.0 - away.length_squared()).max(0.0)
    }

    /// Whether it reaches a square of samples.
    fn reaches(&self, first: [u32; 2], cells: u32) -> bool {
        let outside = [0, 1].map(|axis| {
            let (low, at) = (first[axis] as f32, self.place[axis]);
            at - at.clamp(low, low + cells as f32)
        });
        outside[0].hypot(outside[1]) <= self.radius
    }
}

/// Heights after craters, vertex by vertex in `f64`.
fn expected(ground: &BlockGround, craters: &[Crater]) -> Vec<f64> {
    let mut heights: Vec<f64> = ground.grid.heights.iter().copied().map(f64::from).collect();
    let side = ground.grid.cells;
    for crater in craters {
        let [columns, rows] = [0, 1].map(|axis| {
            let (at, reach) = (
                f64::from(crater.place[axis]),
                f64::from(crater.radius) + 1.0,
            );
            whole(at - reach, side)..=whole(at + reach, side)
        });
        for row in rows {
            for column in columns.clone() {
                heights[ground.grid.index(column, row)] -= crater.below(column, row);
            }
        }
    }
    heights
}

/// A vertex within the grid.
#[allow(
    clippy::cast_possible_truncation,
    reason = "held between 0 and the grid's cells"
)]
fn whole(at: f64, side: u32) -> u32 {
    at.clamp(0.0, f64::from(side)) as u32
}

/// A block that craters reach, and what draws them into its layer.
struct Struck {
    block: u32,
    bound: wgpu::BindGroup,
    layer: wgpu::TextureView,
    craters: Vec<Crater>,
}

/// Ground with what strikes it, on wgpu.
struct Opened {
    way: CraterWay,
    ground: BlockGround,
    drawn: OnWgpu,
    struck: Vec<Struck>,
    pipeline: wgpu::RenderPipeline,
    /// A layer as it was.
    before: wgpu::Texture,
    /// Of each struck block, as the CPU has them.
    heights: Vec<Vec<f32>>,
    timer: Option<PassTimer>,
}

impl Opened {
    fn new(
        context: Context<'_>,
        way: CraterWay,
        ground: &BlockGround,
        craters: &[Crater],
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let gpu = terrafill_gpu::shared_gpu(context.devices)?;
        let drawn = OnWgpu::new(&gpu, Keep::Array, ground, size)?;
        let side = ground.samples();
        let before = texture(&gpu, [side, side, 1], wgpu::TextureDimension::D2);
        let before_view = before.create_view(&Default::default());
        let types = [
            uniform_type(),
            storage_type(true),
            texture_type(wgpu::TextureViewDimension::D2),
        ];
        let layout = gpu.mixed_layout(
            "craters",
            types.map(|ty| (wgpu::ShaderStages::FRAGMENT, ty)),
        );
        let mut struck = Vec::new();
        for block in 0..ground.blocks() {
            let first = ground.first_vertex(block);
            let reach = |crater: &&Crater| crater.reaches(first, ground.block_cells);
            let craters: Vec<Crater> = craters.iter().filter(reach).copied().collect();
            if craters.is_empty() {
                continue;
            }
            let constants = CraterConstants {
                first,
                count: crate::draws::count(&craters),
                padding: 0,
            };
            let bytes = bytemuck::bytes_of(&constants);
            let constants = gpu.upload("craters of a block", bytes, wgpu::BufferUsages::UNIFORM)?;
            let bytes = bytemuck::cast_slice(&craters);
            let listed = gpu.upload("craters", bytes, wgpu::BufferUsages::STORAGE)?;
            let resources = [
                constants.as_entire_binding(),
                listed.as_entire_binding(),
                wgpu::BindingResource::TextureView(&before_view),
            ];
            struck.push(Struck {
                block,
                bound: gpu.bind("craters", &layout, resources),
                layer: drawn.textures[0].create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2),
                    base_array_layer: block,
                    array_layer_count: Some(1),
                    ..Default::default()
                }),
                craters,
            });
        }
        let path = "pipelines/craters.wgsl";
        let module = gpu.shader(path)?;
        let of_pipeline = gpu.pipeline_layout(path, &[Some(&layout)]);
        let targets = [Some(wgpu::TextureFormat::R32Float.into())];
        let mut described = terrafill_gpu::described(path, &of_pipeline, &module, &targets);
        described.vertex.entry_point = Some("vertex_main");
        let pipeline = gpu.create_render_pipeline(&described);
        let heights = struck.iter().map(|of| ground.heights(of.block)).collect();
        Ok(Self {
            way,
            ground: ground.clone(),
            struck,
            pipeline,
            before,
            heights,
            timer: PassTimer::new(&gpu),
            drawn,
        })
    }

    /// Lets all craters in, and waits.
    fn strike(&mut self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        match self.way {
            CraterWay::Drawn => self.draw_craters(),
            CraterWay::Written => self.write_craters(),
        }
        self.drawn.gpu.wait()?;
        let times = Times::since(&watch, None);
        let timer = self.timer.as_ref().filter(|_| self.way == CraterWay::Drawn);
        let gpu_ms = timer.map(|timer| timer.pass_ms(&self.drawn.gpu, TimedPass::Surface));
        Ok(Times {
            gpu_ms: gpu_ms.transpose()?.flatten(),
            ..times
        })
    }

    fn draw_craters(&self) {
        let gpu = &self.drawn.gpu;
        let side = self.ground.samples();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        if let Some(timer) = &self.timer {
            timer.begin(&mut encoder, TimedPass::Surface);
        }
        for (number, struck) in self.struck.iter().enumerate() {
            let layer = wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d {
                    z: struck.block,
                    ..wgpu::Origin3d::ZERO
                },
                ..self.drawn.textures[0].as_image_copy()
            };
            let size = wgpu::Extent3d {
                width: side,
                height: side,
                depth_or_array_layers: 1,
            };
            encoder.copy_texture_to_texture(layer, self.before.as_image_copy(), size);
            let is_last = number + 1 == self.struck.len();
            let timer = self.timer.as_ref().filter(|_| is_last);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("craters"),
                color_attachments: &[Some(terrafill_gpu::attached(
                    &struck.layer,
                    wgpu::LoadOp::Load,
                ))],
                timestamp_writes: timer.map(|of| of.writes(None, Some(TimedPass::Surface))),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &struck.bound, &[]);
            pass.draw(0..3, 0..1);
        }
        gpu.queue.submit([encoder.finish()]);
    }

    fn write_craters(&mut self) {
        let side = self.ground.samples();
        for (struck, heights) in self.struck.iter().zip(&mut self.heights) {
            let [column, row] = self.ground.first_vertex(struck.block);
            for (at, height) in (0..).zip(heights.iter_mut()) {
                let place = [column + at % side, row + at / side].map(|at| at as f32);
                for crater in &struck.craters {
                    let [x, y] =
                        [0, 1].map(|axis| (place[axis] - crater.place[axis]) / crater.radius);
                    *height -= crater.depth * (1.0 - (x * x + y * y)).max(0.0);
                }
            }
            let first = [0, 0, struck.block];
            write_block(
                &self.drawn.gpu,
                &self.drawn.textures[0],
                first,
                side,
                heights,
            );
        }
        self.drawn.gpu.queue.submit([]);
    }

    /// Heights that the device has, and how many samples of borders differ between neighbours.
    fn read(&self) -> Result<(Vec<f32>, usize), DeviceError> {
        let whole = wgpu::TextureAspect::All;
        let bytes = read_texture(&self.drawn.gpu, &self.drawn.textures[0], whole)?;
        let texels: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
        let mut heights = vec![f32::NAN; self.ground.grid.heights.len()];
        let mut torn = 0;
        let side = self.ground.samples();
        let layers = texels.chunks((side * side) as usize);
        for (block, layer) in (0..).zip(layers) {
            let [column, row] = self.ground.first_vertex(block);
            for (at, height) in (0..).zip(layer) {
                let vertex = self.ground.grid.index(column + at % side, row + at / side);
                let known = heights[vertex];
                torn += usize::from(!known.is_nan() && known.to_bits() != height.to_bits());
                heights[vertex] = *height;
            }
        }
        Ok((heights, torn))
    }

    /// Bytes that the CPU sends for a frame.
    fn sent_bytes(&self) -> f64 {
        match self.way {
            // They were sent when balls struck.
            CraterWay::Drawn => {
                let craters: usize = self.struck.iter().map(|of| of.craters.len()).sum();
                (craters * size_of::<Crater>()) as f64
            }
            CraterWay::Written => {
                let texels = self.struck.len() * self.ground.samples().pow(2) as usize;
                4.0 * texels as f64
            }
        }
    }
}

/// Heights of a device held against `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct JudgedHeights {
    max_m: f64,
    /// Vertices that no crater reaches and that changed.
    strayed: usize,
    struck: usize,
}

fn judge(ground: &BlockGround, expected: &[f64], heights: &[f32]) -> JudgedHeights {
    let mut judged = JudgedHeights {
        max_m: 0.0,
        strayed: 0,
        struck: 0,
    };
    for ((before, expected), height) in ground.grid.heights.iter().zip(expected).zip(heights) {
        let error = (f64::from(*height) - expected).abs();
        // What is no number must not be lost in a maximum.
        judged.max_m = if error <= judged.max_m {
            judged.max_m
        } else {
            error
        };
        let is_struck = *expected < f64::from(*before);
        judged.struck += usize::from(is_struck);
        judged.strayed += usize::from(!is_struck && height.to_bits() != before.to_bits());
    }
    judged
}

/// Numbers of craters by both ways.
pub(crate) struct Craters {
    ground: [u32; 2],
    cases: Vec<(CraterWay, u32)>,
    size: ImageSize,
}

pub(crate) fn group(is_quick: bool, (size, samples): (ImageSize, u32)) -> impl Group {
    let (ground, counts): (_, &[u32]) = if is_quick {
        (QUICK_GROUND, &QUICK_COUNTS)
    } else {
        (GROUND, &COUNTS)
    };
    group_of(ground, counts, (size, samples))
}

fn group_of(
    ground: [u32; 2],
    counts: &[u32],
    (size, samples): (ImageSize, u32),
) -> CaseGroup<Craters> {
    let of = |&count: &u32| CraterWay::ALL.map(|way| (way, count));
    let cases: Vec<_> = counts.iter().flat_map(of).collect();
    let case = |&(way, count): &(CraterWay, u32)| {
        let conditions = vec![
            (EXPERIMENT, "craters".to_owned()),
            (CRATER_WAY, way.name().to_owned()),
            (CRATERS, count.to_string()),
            (metrics::BLOCKS, (ground[0] * ground[0]).to_string()),
            (GRID_CELLS, (ground[0] * ground[1]).to_string()),
        ];
        planned_case(STUDY, samples, conditions, Some(size_px(size)))
    };
    CaseGroup {
        name: format!("{STUDY}/craters"),
        cases: cases.iter().map(case).collect(),
        warm_up: None,
        work: Craters {
            ground,
            cases,
            size,
        },
        open: |group, context| {
            let [across, block_cells] = group.work.ground;
            Ok(Box::new(CraterSession {
                group,
                context,
                ground: BlockGround::new(across, block_cells),
                opened: BTreeMap::new(),
            }))
        },
    }
}

struct CraterSession<'a> {
    group: &'a CaseGroup<Craters>,
    context: Context<'a>,
    ground: BlockGround,
    /// By case.
    opened: BTreeMap<usize, Opened>,
}

impl Session for CraterSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let Craters {
            ref cases, size, ..
        } = self.group.work;
        let (way, count) = cases[case];
        let craters = Crater::many(&self.ground, count);
        let mut opened = Opened::new(self.context, way, &self.ground, &craters, size)?;
        opened.strike()?;
        let (heights, torn) = opened.read()?;
        let found = judge(&self.ground, &expected(&self.ground, &craters), &heights);
        let (picture, _) = opened.drawn.draw()?;
        let numbers = ids_of(&picture);
        let mut struck = self.ground.clone();
        struck.grid.heights = heights;
        let rays = Rays::new(&struck.grid, GridCamera::new(), size);
        let shown = rays.judge_triangles(&numbers, &rays.picture(ray_every(size)));
        let reason = if found.max_m.is_nan() || found.max_m > ALLOWED_M {
            format!(
                "a height is {} m from f64, allowed {ALLOWED_M} m",
                found.max_m
            )
        } else if found.strayed > 0 {
            format!("{} heights changed that no crater reaches", found.strayed)
        } else if torn > 0 {
            format!("{torn} heights differ between blocks that share them")
        } else if found.struck == 0 {
            "no crater reaches the ground".to_owned()
        } else if shown.mismatched > 0 {
            let pixels = shown.mismatched;
            format!("{pixels} pixels show what the reference does not allow")
        } else {
            String::new()
        };
        let figures = vec![
            ("pipeline_mismatched_px", shown.mismatched as f64),
            ("pipeline_band_px", shown.in_band as f64),
            ("pipeline_shown_px", shown.shown as f64),
            ("pipeline_sent_bytes", opened.sent_bytes()),
            ("crater_error_m", found.max_m),
            ("crater_strayed", (found.strayed + torn) as f64),
            ("crater_struck", found.struck as f64),
            ("crater_layers", opened.struck.len() as f64),
        ];
        self.opened.insert(case, opened);
        let notes = if way == CraterWay::Drawn || !reason.is_empty() {
            let name = &self.group.cases[case].id.name;
            let pixels = of_relief(&numbers, &struck.grid);
            write(self.context.folder, name, size, pixels)?
        } else {
            Vec::new()
        };
        Ok(judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        Ok(verified(&mut self.opened, case)?.strike()?.figures())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::PICTURE;
    use crate::tested::Tested;
    use std::mem::offset_of;
    use terrafill_results::Status;
    use terrafill_shaders::struct_layout;

    #[test]
    fn craters_lie_as_the_shader_reads_them() {
        let layout = struct_layout("pipelines/craters.wgsl", "Crater").expect("a struct");
        assert_eq!(
            layout.offset("radius").expect("radius"),
            offset_of!(Crater, radius)
        );
        assert_eq!(
            layout.offset("depth").expect("depth"),
            offset_of!(Crater, depth)
        );
        assert_eq!(layout.stride as usize, size_of::<Crater>());
        let layout = struct_layout("pipelines/craters.wgsl", "CraterConstants").expect("a struct");
        assert_eq!(
            layout.offset("count").expect("count"),
            offset_of!(CraterConstants, count)
        );
        assert_ne!(
            layout.offset("first").expect("first"),
            offset_of!(CraterConstants, count)
        );
    }

    #[test]
    fn craters_are_those_of_f64_by_both_ways_and_what_is_wrong_is_noticed() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let group = group_of(QUICK_GROUND, &[16, 64], (PICTURE, 1));
        let verdicts = tested.verdicts(&group);
        for (at, verdict) in &verdicts {
            let name = &group.cases[*at].id.name;
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
        }
        assert_eq!(verdicts.len(), 4);
        let context = Context {
            devices: &tested.devices,
            folder: std::path::Path::new(""),
        };
        let ground = BlockGround::new(QUICK_GROUND[0], QUICK_GROUND[1]);
        let mut craters = Crater::many(&ground, 16);
        // Where four blocks meet.
        craters.push(Crater {
            place: [32.0, 31.5],
            radius: 4.0,
            depth: 9.0,
        });
        let expected = expected(&ground, &craters);
        // Negative controls: a crater more, one elsewhere, one that a block does not know of.
        let judged = |craters: &[Crater], forgets: bool| {
            let way = CraterWay::Drawn;
            let mut opened = Opened::new(context, way, &ground, craters, PICTURE).expect("opens");
            if forgets {
                opened.struck.retain(|of| of.block != 0);
            }
            opened.strike().expect("strikes");
            let (heights, torn) = opened.read().expect("reads");
            (judge(&ground, &expected, &heights), torn)
        };
        let (right, torn) = judged(&craters, false);
        assert!(
            right.max_m <= ALLOWED_M && right.strayed == 0 && torn == 0,
            "{right:?}"
        );
        let (one_less, _) = judged(&craters[1..], false);
        assert!(one_less.max_m > 1.0, "{one_less:?}");
        let mut moved = craters.clone();
        moved[3].place[0] += 0.5;
        let (elsewhere, _) = judged(&moved, false);
        assert!(elsewhere.max_m > ALLOWED_M, "{elsewhere:?}");
        let (forgotten, torn) = judged(&craters, true);
        assert!(
            forgotten.max_m > ALLOWED_M && torn > 0,
            "{forgotten:?} {torn}"
        );
    }
}
