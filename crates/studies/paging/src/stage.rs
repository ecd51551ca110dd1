// SPDX-License-Identifier: MIT OR Apache-2.0
//! The device's part: slots of pages, the page table, the globe, and counts of fragments that come back later.

use crate::path::{Eye, Globe};
use crate::residency::SLOT;
use crate::texture::{STORED, Texture};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use terrafill_contract::{DeviceError, SurfaceView, ViewConstants, ViewId};
use terrafill_core::Ellipsoid;
use terrafill_gpu::{Gpu, read_texture, vertex_layout};
use terrafill_scene::ImageSize;
use terrafill_surface::{HeightRange, SurfaceFrame};

/// Of a picture that is looked at.
const COLOURS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Of a picture whose pixels say what they show.
const ADDRESSES: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
/// Frames from drawing to using a count: what mapping a buffer back takes where nothing waits.
pub(crate) const DELAY: usize = 2;

/// What a frame's fragments do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Look {
    /// Whether they find their level by their footprint.
    pub(crate) by_derivative: bool,
    /// Whether they count themselves by the page that they want.
    pub(crate) counts: bool,
    /// Whether those that show a coarser page than their footprint asks for are counted too.
    pub(crate) measures: bool,
    /// Whether they say which texels they show, in place of the texels' colour.
    pub(crate) addresses: bool,
}

/// What a pixel says: addresses of the first and the last texel that are mixed, the level that is wanted, and the one
/// that its footprint asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Said {
    pub(crate) texels: [u32; 2],
    /// `None` where nothing is drawn.
    pub(crate) wanted: Option<u32>,
    pub(crate) footprint: u32,
}

/// Counts on their way.
struct Coming {
    staging: wgpu::Buffer,
    frame: wgpu::SubmissionIndex,
    arrives: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

/// Slots, table, targets and pipelines.
pub(crate) struct Stage {
    gpu: Arc<Gpu>,
    pub(crate) size: ImageSize,
    finest: u32,
    /// Colours, addresses.
    targets: [wgpu::Texture; 2],
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    pipelines: BTreeMap<Look, wgpu::RenderPipeline>,
    view: wgpu::Buffer,
    bound: [wgpu::BindGroup; 2],
    globe: [wgpu::Buffer; 3],
    index_count: u32,
    slots: wgpu::Texture,
    table: wgpu::Buffer,
    counts: wgpu::Buffer,
    coming: VecDeque<Coming>,
    free: Vec<wgpu::Buffer>,
    /// As the device has them.
    written: ([u8; size_of::<ViewConstants>()], Vec<u32>),
    /// Bytes that were sent since the last question.
    sent: u64,
}

impl Stage {
    /// - `slots`: how many pages the device keeps
    ///
    /// # Errors
    /// Where the device has no so many layers, or its shader does not compile.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        size: ImageSize,
        texture: &Texture,
        slots: usize,
    ) -> Result<Self, DeviceError> {
        let layers = u32::try_from(slots).unwrap_or(u32::MAX);
        let allowed = gpu.device.limits().max_texture_array_layers;
        DeviceError::check_capacity("slots of pages", layers, allowed)?;
        let pages = u64::from(texture.page_count());
        let target = |label, format| {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
            gpu.texture(label, [size.width, size.height, 1], 1, format, usage)
        };
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let held = gpu.texture(
            "slots of pages",
            [STORED, STORED, layers],
            1,
            COLOURS,
            usage,
        );
        let copied = wgpu::BufferUsages::COPY_DST;
        let view_bytes = size_of::<ViewConstants>() as u64;
        let view = gpu.unwritten("view", view_bytes, copied | wgpu::BufferUsages::UNIFORM);
        let storage = copied | wgpu::BufferUsages::STORAGE;
        let table = gpu.unwritten("page table", 4 * pages, storage);
        let counts = storage | wgpu::BufferUsages::COPY_SRC;
        let counts = gpu.unwritten("counts", 4 * (pages + 1), counts);
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let vertex = wgpu::ShaderStages::VERTEX;
        let layouts = [
            gpu.mixed_layout("view", [(vertex, buffer(wgpu::BufferBindingType::Uniform))]),
            gpu.fragment_layout(
                "pages",
                &[
                    buffer(wgpu::BufferBindingType::Storage { read_only: true }),
                    buffer(wgpu::BufferBindingType::Storage { read_only: false }),
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: true },
                        view_dimension: wgpu::TextureViewDimension::D2Array,
                        multisampled: false,
                    },
                    wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                ],
            ),
        ];
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("between texels"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let seen = held.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let resources = [
            table.as_entire_binding(),
            counts.as_entire_binding(),
            wgpu::BindingResource::TextureView(&seen),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        let bound = [
            gpu.bind_buffers("view", &layouts[0], &[&view]),
            gpu.bind("pages", &layouts[1], resources),
        ];
        let globe = Globe::new();
        let upload = |label, bytes: &[u8], usage| gpu.upload(label, bytes, usage);
        let vertices = wgpu::BufferUsages::VERTEX;
        let indices = globe.triangles.as_flattened();
        Ok(Self {
            size,
            finest: texture.finest,
            targets: [target("colours", COLOURS), target("addresses", ADDRESSES)],
            module: gpu.shader("paging/pages.wgsl")?,
            layout: gpu.pipeline_layout("pages", &layouts.each_ref().map(Some)),
            pipelines: BTreeMap::new(),
            bound,
            globe: [
                upload("places", bytemuck::cast_slice(&globe.places), vertices)?,
                upload("U and V", bytemuck::cast_slice(&globe.uvs), vertices)?,
                upload(
                    "triangles",
                    bytemuck::cast_slice(indices),
                    wgpu::BufferUsages::INDEX,
                )?,
            ],
            index_count: u32::try_from(indices.len()).unwrap_or(u32::MAX),
            view,
            slots: held,
            written: (
                [0; size_of::<ViewConstants>()],
                vec![0; texture.page_count() as usize],
            ),
            table,
            counts,
            coming: VecDeque::new(),
            free: Vec::new(),
            sent: 0,
            gpu: Arc::clone(gpu),
        })
    }

    /// Forgets counts that are on their way, the view and the page table: flights send as much whichever came before.
    pub(crate) fn restart(&mut self) {
        self.coming.clear();
        self.written.0 = [0; size_of::<ViewConstants>()];
        self.write_table(&vec![0; self.written.1.len()]);
        self.sent = 0;
    }

    /// Bytes that were sent since the last call.
    pub(crate) fn sent(&mut self) -> u64 {
        std::mem::take(&mut self.sent)
    }

    /// Writes the bytes of a page into a slot.
    pub(crate) fn write_page(&mut self, slot: usize, bytes: &[u8]) {
        let z = u32::try_from(slot).unwrap_or(u32::MAX);
        self.gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y: 0, z },
                ..self.slots.as_image_copy()
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * STORED),
                rows_per_image: Some(STORED),
            },
            wgpu::Extent3d {
                width: STORED,
                height: STORED,
                depth_or_array_layers: 1,
            },
        );
        self.sent += bytes.len() as u64;
    }

    /// Writes the page table where it changed: from the first to the last entry that did.
    pub(crate) fn write_table(&mut self, table: &[u32]) {
        let written = &mut self.written.1;
        let differs = |at: &usize| table[*at] != written[*at];
        let Some(first) = (0..table.len()).find(differs) else {
            return;
        };
        let last = (first..table.len()).rev().find(differs).unwrap_or(first);
        let changed: &[u8] = bytemuck::cast_slice(&table[first..=last]);
        self.gpu
            .write_buffer(&self.table, 4 * first as u64, changed);
        self.sent += changed.len() as u64;
        written.copy_from_slice(table);
    }

    /// Ends what was written, and waits until the device has it and has drawn.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub(crate) fn flush(&self) -> Result<(), DeviceError> {
        self.gpu.queue.submit([]);
        self.gpu.wait()
    }

    fn pipeline(&mut self, look: Look) -> &wgpu::RenderPipeline {
        let entry = match self.pipelines.entry(look) {
            Entry::Occupied(made) => return made.into_mut(),
            Entry::Vacant(entry) => entry,
        };
        let (format, entry_point) = if look.addresses {
            (ADDRESSES, "fragment_addresses")
        } else {
            (COLOURS, "fragment_main")
        };
        let number = |is: bool| f64::from(u8::from(is));
        let constants = [
            ("FINEST", f64::from(self.finest)),
            ("BY_DERIVATIVE", number(look.by_derivative)),
            ("COUNTS", number(look.counts)),
            ("MEASURES", number(look.measures)),
        ];
        let attributes = [
            wgpu::vertex_attr_array![0 => Float32x3],
            wgpu::vertex_attr_array![1 => Float32x2],
        ];
        let buffers = attributes.each_ref().map(|own| vertex_layout(own));
        let targets = [Some(format.into())];
        let mut described = terrafill_gpu::described("pages", &self.layout, &self.module, &targets);
        described.vertex.buffers = &buffers;
        // The globe is convex: what faces the eye hides nothing else that does.
        described.primitive.cull_mode = Some(wgpu::Face::Back);
        if let Some(fragment) = &mut described.fragment {
            fragment.entry_point = Some(entry_point);
            fragment.compilation_options.constants = &constants;
        }
        entry.insert(self.gpu.create_render_pipeline(&described))
    }

    /// Draws a frame and waits. Its counts, where there are any, come with [`Stage::counts`].
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub(crate) fn draw(&mut self, eye: &Eye, look: Look) -> Result<(), DeviceError> {
        self.submit(eye, look);
        self.gpu.wait()
    }

    /// Draws a frame without waiting for it.
    pub(crate) fn submit(&mut self, eye: &Eye, look: Look) {
        let constants = view_constants(eye);
        let bytes: [u8; size_of::<ViewConstants>()] = bytemuck::cast(constants);
        if bytes != self.written.0 {
            self.gpu.write_buffer(&self.view, 0, &bytes);
            self.sent += bytes.len() as u64;
            self.written.0 = bytes;
        }
        let pipeline = self.pipeline(look).clone();
        let gpu = &self.gpu;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        if look.counts || look.measures {
            encoder.clear_buffer(&self.counts, 0, None);
        }
        let target = &self.targets[usize::from(look.addresses)];
        let target = target.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("pages"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        for (group, bound) in (0..).zip(&self.bound) {
            pass.set_bind_group(group, bound, &[]);
        }
        let [places, uvs, triangles] = &self.globe;
        pass.set_vertex_buffer(0, places.slice(..));
        pass.set_vertex_buffer(1, uvs.slice(..));
        pass.set_index_buffer(triangles.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.index_count, 0, 0..1);
        drop(pass);
        let staging = (look.counts || look.measures).then(|| {
            let free = self.free.pop();
            let staging = free.unwrap_or_else(|| {
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("counts on their way"),
                    size: self.counts.size(),
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                    mapped_at_creation: false,
                })
            });
            encoder.copy_buffer_to_buffer(&self.counts, 0, &staging, 0, self.counts.size());
            staging
        });
        let frame = gpu.queue.submit([encoder.finish()]);
        if let Some(staging) = staging {
            let (sender, arrives) = channel();
            staging.map_async(wgpu::MapMode::Read, .., move |result| {
                // A flight that began anew does not wait for it.
                let _ = sender.send(result);
            });
            self.coming.push_back(Coming {
                staging,
                frame,
                arrives,
            });
        }
    }

    /// Pages that fragments of a frame want and the device's table has in no slot.
    pub(crate) fn lacks(&self, counts: &[u32]) -> usize {
        let both = self.written.1.iter().zip(counts);
        both.filter(|(entry, count)| **count > 0 && *entry & SLOT == 0)
            .count()
    }

    /// Counts of the frame that is [`DELAY`] frames old, or of the last one at once; `None` where there is none yet. Waits
    /// for that frame alone.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub(crate) fn counts(&mut self, at_once: bool) -> Result<Option<Vec<u32>>, DeviceError> {
        let lost = |error: &dyn ToString| DeviceError::DeviceLost(error.to_string());
        let coming = if at_once {
            self.coming.pop_back()
        } else if self.coming.len() < DELAY {
            None
        } else {
            self.coming.pop_front()
        };
        let Some(coming) = coming else {
            return Ok(None);
        };
        let Coming {
            staging,
            frame,
            arrives,
        } = coming;
        let done = self.gpu.device.poll(wgpu::PollType::Wait {
            submission_index: Some(frame),
            timeout: None,
        });
        done.map_err(|error| lost(&error))?;
        let mapped = arrives.recv().map_err(|error| lost(&error))?;
        mapped.map_err(|error| lost(&error))?;
        let bytes = staging.get_mapped_range(..).map_err(|error| lost(&error))?;
        let counts = bytemuck::pod_collect_to_vec(&bytes);
        drop(bytes);
        staging.unmap();
        self.free.push(staging);
        Ok(Some(counts))
    }

    /// What each pixel of the last picture of addresses says, row by row.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub(crate) fn said(&self) -> Result<Vec<Said>, DeviceError> {
        let bytes = read_texture(&self.gpu, &self.targets[1], wgpu::TextureAspect::All)?;
        let pixels: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        let said = pixels.iter().map(|[first, last, wanted, footprint]| Said {
            texels: [*first, *last],
            wanted: wanted.checked_sub(1),
            footprint: *footprint,
        });
        Ok(said.collect())
    }

    /// Colours of the last picture, row by row.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub(crate) fn colours(&self) -> Result<Vec<[u8; 4]>, DeviceError> {
        let bytes = read_texture(&self.gpu, &self.targets[0], wgpu::TextureAspect::All)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}

fn view_constants(eye: &Eye) -> ViewConstants {
    let nothing = SurfaceFrame {
        vertices_rte: Arc::default(),
        triangles: Arc::default(),
        heights: HeightRange {
            lowest_m: 0.0,
            highest_m: 0.0,
        },
        parts: Arc::default(),
        shown: None,
    };
    ViewConstants::new(&SurfaceView {
        id: ViewId::unique(),
        body: &Ellipsoid::WGS84,
        camera: &eye.camera,
        size: eye.size,
        surface: &nothing,
        picture: None,
        draws_back_faces: false,
    })
}
