// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pixels of nodes, counted by devices: on Vulkan by precise occlusion queries, on wgpu by a target of node numbers
//! and a histogram. WebGPU's queries say no more than zero or not.

use super::scene::NodeVertices;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError, Devices, ViewConstants};
use terrafill_globe_views::{Canvas, Eye, Stages, uniform, vertices, view_constants};
use terrafill_gpu::{Gpu, read_buffer};
use terrafill_maps::Node;
use terrafill_scene::ImageSize;
use terrafill_study::Figures;
use terrafill_vulkan::{
    Buffer, BufferUse, DirectDraw, DrawCall, DrawPipeline, Measured, PrimitiveStages, Resource,
    Resources, Shader, Topology, VertexFormat,
};

/// Pixels a side: with pictures of 64² texels, some 40 nodes.
pub(crate) const SIDE_PX: u32 = 400;
const SIZE: ImageSize = ImageSize::new(SIDE_PX, SIDE_PX);
/// Texels along a side of a node's picture.
pub(crate) const NODE_TEXELS: u32 = 64;

/// Draws nodes and counts their pixels.
pub(crate) trait Counter {
    /// Pixels of each node, in the order in which they are drawn.
    fn count(&mut self, eye: &Eye, drawn: &NodeVertices) -> Result<Vec<u64>, DeviceError>;

    /// Draws them without counting, and waits.
    fn draw(&mut self, eye: &Eye, drawn: &NodeVertices) -> Result<(), DeviceError>;
}

/// How pixels are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PixelCount {
    Histogram,
    Queries,
}

impl PixelCount {
    pub(crate) const ALL: [Self; 2] = [Self::Histogram, Self::Queries];

    /// Interface and name.
    pub(crate) fn names(self) -> [&'static str; 2] {
        match self {
            Self::Histogram => ["wgpu", "histogram"],
            Self::Queries => ["vulkan", "queries"],
        }
    }

    fn open(self, devices: &Devices) -> Result<Box<dyn Counter>, DeviceError> {
        Ok(match self {
            Self::Histogram => Box::new(ByHistogram::new(devices, SIZE)?),
            Self::Queries => Box::new(ByQueries::new(devices)?),
        })
    }
}

/// Counters of one size, opened when they are first wanted.
pub(crate) struct Counters<'a> {
    devices: &'a Devices,
    /// By interface.
    open: BTreeMap<&'static str, Box<dyn Counter>>,
}

impl<'a> Counters<'a> {
    pub(crate) fn new(devices: &'a Devices) -> Self {
        Self {
            devices,
            open: BTreeMap::new(),
        }
    }

    pub(crate) fn get(&mut self, way: PixelCount) -> Result<&mut dyn Counter, DeviceError> {
        let [name, _] = way.names();
        if let Entry::Vacant(entry) = self.open.entry(name) {
            entry.insert(way.open(self.devices)?);
        }
        let counter = self.open.get_mut(name);
        let counter = counter.ok_or(DeviceError::Missing("a counter of pixels"))?;
        Ok(counter.as_mut())
    }

    /// Pixels of each node.
    pub(crate) fn by_node(
        &mut self,
        way: PixelCount,
        eye: &Eye,
        drawn: &NodeVertices,
    ) -> Result<BTreeMap<Node, u64>, DeviceError> {
        let counts = self.get(way)?.count(eye, drawn)?;
        Ok(drawn.nodes.iter().copied().zip(counts).collect())
    }

    /// A frame with its counts read at once, and without counts.
    pub(crate) fn time(
        &mut self,
        way: PixelCount,
        eye: &Eye,
        drawn: &NodeVertices,
    ) -> Result<Figures, DeviceError> {
        let counter = self.get(way)?;
        let watch = CpuStopwatch::start();
        counter.count(eye, drawn)?;
        let counted_ms = watch.cpu_ms();
        let watch = CpuStopwatch::start();
        counter.draw(eye, drawn)?;
        Ok(vec![
            ("globe_counted_cpu_ms", counted_ms),
            ("globe_uncounted_cpu_ms", watch.cpu_ms()),
        ])
    }
}

/// Counts the pixels of a canvas by the numbers that they hold.
pub(crate) struct Histogram {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

impl Histogram {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, DeviceError> {
        let types = [
            wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Uint,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: false },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
        ];
        let types = types.map(|ty| (wgpu::ShaderStages::COMPUTE, ty));
        let layout = gpu.mixed_layout("counts", types);
        let module = gpu.shader("globes/nodes.wgsl")?;
        let groups = [None, Some(&layout)];
        let pipeline = gpu.compute_pipeline("counts", &module, "count_main", &groups, &[]);
        Ok(Self { pipeline, layout })
    }

    /// Submits what was recorded, and reads how many pixels have each number from 1 to `numbers`.
    pub(crate) fn count(
        &self,
        canvas: &Canvas,
        mut encoder: wgpu::CommandEncoder,
        numbers: usize,
    ) -> Result<Vec<u64>, DeviceError> {
        let gpu = &canvas.gpu;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let counts = gpu.unwritten("counts", 4 * (numbers as u64 + 1), usage);
        let view = canvas.view();
        let [width, height] = [view.texture().width(), view.texture().height()];
        let view = wgpu::BindingResource::TextureView(&view);
        let bound = gpu.bind("counts", &self.layout, [view, counts.as_entire_binding()]);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(1, &bound, &[]);
        pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&read_buffer(gpu, &counts)?);
        Ok(counts.into_iter().skip(1).map(u64::from).collect())
    }
}

/// Draws the number of each node, and counts them.
pub(crate) struct ByHistogram {
    canvas: Canvas,
    draw: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    bound_view: wgpu::BindGroup,
    histogram: Histogram,
}

impl ByHistogram {
    pub(crate) fn new(devices: &Devices, size: ImageSize) -> Result<Self, DeviceError> {
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        let view_layout = gpu.buffer_layout(
            "nodes",
            wgpu::ShaderStages::VERTEX,
            &[wgpu::BufferBindingType::Uniform],
        );
        let view = uniform::<ViewConstants>(&gpu, "view constants");
        let module = gpu.shader("globes/nodes.wgsl")?;
        let canvas = Canvas::new(&gpu, size, wgpu::TextureFormat::R32Uint);
        let attributes = [
            wgpu::vertex_attr_array![0 => Float32x3],
            wgpu::vertex_attr_array![1 => Uint32],
        ];
        let stages = Stages {
            module: &module,
            entry_points: ["vertex_main", "fragment_main"],
            constants: &[],
            buffers: &attributes.each_ref().map(|attributes| vertices(attributes)),
        };
        let layout = gpu.pipeline_layout("nodes", &[Some(&view_layout)]);
        let draw = canvas.pipeline("nodes", &layout, &stages);
        Ok(Self {
            draw,
            histogram: Histogram::new(&gpu)?,
            bound_view: gpu.bind_buffers("view", &view_layout, &[&view]),
            view,
            canvas,
        })
    }

    fn record(&self, eye: &Eye, drawn: &NodeVertices) -> Result<wgpu::CommandEncoder, DeviceError> {
        let gpu = &self.canvas.gpu;
        gpu.write_buffer(&self.view, 0, bytemuck::bytes_of(&view_constants(eye)));
        let count = u32::try_from(drawn.vertices_rte.len()).unwrap_or(u32::MAX);
        let numbers: Vec<u32> = (0..count)
            .map(|vertex| vertex / drawn.per_node + 1)
            .collect();
        let usage = wgpu::BufferUsages::VERTEX;
        let places = gpu.upload("nodes", bytemuck::cast_slice(&drawn.vertices_rte), usage)?;
        let numbers = gpu.upload("numbers", bytemuck::cast_slice(&numbers), usage)?;
        let mut encoder = self.canvas.frame();
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(&self.draw);
            pass.set_bind_group(0, &self.bound_view, &[]);
            pass.set_vertex_buffer(0, places.slice(..));
            pass.set_vertex_buffer(1, numbers.slice(..));
            pass.draw(0..count, 0..1);
        });
        Ok(encoder)
    }
}

impl ByHistogram {
    /// The node that each pixel shows, from 1, row by row from the top; 0 for none.
    pub(crate) fn picture(&self, eye: &Eye, drawn: &NodeVertices) -> Result<Vec<u32>, DeviceError> {
        let encoder = self.record(eye, drawn)?;
        self.canvas.finish(encoder)?;
        self.canvas.read()
    }
}

impl Counter for ByHistogram {
    fn count(&mut self, eye: &Eye, drawn: &NodeVertices) -> Result<Vec<u64>, DeviceError> {
        let encoder = self.record(eye, drawn)?;
        let numbers = drawn.nodes.len();
        self.histogram.count(&self.canvas, encoder, numbers)
    }

    fn draw(&mut self, eye: &Eye, drawn: &NodeVertices) -> Result<(), DeviceError> {
        let encoder = self.record(eye, drawn)?;
        self.canvas.gpu.queue.submit([encoder.finish()]);
        self.canvas.gpu.wait()
    }
}

struct ByQueries {
    gpu: Arc<terrafill_vulkan::Gpu>,
    targets: terrafill_vulkan::RenderTargets,
    pipeline: DrawPipeline,
    view: Arc<Buffer>,
    vertices: Buffer,
}

impl ByQueries {
    fn new(devices: &Devices) -> Result<Self, DeviceError> {
        let gpu = terrafill_vulkan::shared_gpu(devices)?;
        let bytes = size_of::<ViewConstants>() as u64;
        let view = Buffer::streamed(&gpu, "view constants", bytes, BufferUse::Uniform)?;
        let view = Arc::new(view);
        let resources = Resources::new(&gpu, vec![Resource::Uniform(Arc::clone(&view))])?;
        let shader = |entry_point| Shader::Wgsl {
            path: "surface/surface.wgsl",
            entry_point,
        };
        let stages = PrimitiveStages::Vertices {
            vertex: shader("vertex_main"),
            geometry: None,
            format: VertexFormat::Metres,
            topology: Topology::Triangles,
        };
        Ok(Self {
            targets: terrafill_vulkan::RenderTargets::new(&gpu, SIZE)?,
            pipeline: DrawPipeline::new(&gpu, &resources, stages, shader("fragment_main"))?,
            view,
            vertices: Buffer::streamed(&gpu, "nodes", 12, BufferUse::Vertex)?,
            gpu,
        })
    }

    fn frame(
        &mut self,
        eye: &Eye,
        drawn: &NodeVertices,
        measured: Measured,
    ) -> Result<Option<Vec<u64>>, DeviceError> {
        self.view.stream(bytemuck::bytes_of(&view_constants(eye)))?;
        let bytes: &[u8] = bytemuck::cast_slice(&drawn.vertices_rte);
        if bytes.len() as u64 > self.vertices.size() {
            let size = bytes.len() as u64;
            self.vertices = Buffer::streamed(&self.gpu, "nodes", size, BufferUse::Vertex)?;
        }
        self.vertices.stream(bytes)?;
        let count = u32::try_from(drawn.nodes.len()).unwrap_or(u32::MAX);
        let ranges: Vec<Range<u32>> = (0..count)
            .map(|node| node * drawn.per_node..(node + 1) * drawn.per_node)
            .collect();
        let draw = DirectDraw {
            pipeline: &self.pipeline,
            vertices: Some(&self.vertices),
            call: DrawCall::Vertices(&ranges),
        };
        Ok(self.targets.draw_directly(None, &draw, measured)?.samples)
    }
}

impl Counter for ByQueries {
    fn count(&mut self, eye: &Eye, drawn: &NodeVertices) -> Result<Vec<u64>, DeviceError> {
        let samples = self.frame(eye, drawn, Measured::Samples)?;
        let name = &self.gpu.facts.name;
        samples.ok_or_else(|| DeviceError::unsupported("occlusionQueryPrecise", name))
    }

    fn draw(&mut self, eye: &Eye, drawn: &NodeVertices) -> Result<(), DeviceError> {
        self.frame(eye, drawn, Measured::Nothing).map(|_| ())
    }
}
