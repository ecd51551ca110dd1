// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs a function written in WGSL on the device for an array of inputs, reads its answers back, and
//! times it.
//!
//! What a formula costs and how wrong it is are properties of the device as much as of the formula:
//! WGSL leaves a device 4096 ULP for `atan2`, and `fma` may round twice. So the very text that a
//! fill compiles is compiled here and asked.
//!
//! Times are those of a loop of evaluations per invocation, whose input moves by a uniform step in
//! each turn and whose answers are summed up. Nothing can be hoisted, and a pass lasts milliseconds
//! though an evaluation lasts less than a nanosecond. The loop around a function that returns its
//! input ([`Kernel::BASELINE`]) costs what is not the function; it is timed in the same rounds.

use crate::readback::read_buffer_start;
use crate::{CpuStopwatch, Gpu, read_buffer};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// Inputs of one dispatch; more are taken in several.
pub const EVALUATIONS_PER_DISPATCH: usize = 16_384;

/// Invocations of a workgroup: a multiple of every subgroup size in use.
const WORKGROUP_SIZE: usize = 64;

/// Evaluations written out in a turn of the timed loop, so that counting turns, and the bound that
/// naga puts on every loop, weigh little.
const EVALUATIONS_PER_TURN: u32 = 4;

/// Format of a table's texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TableFormat {
    /// One 8-bit normalised channel.
    R8Unorm,
    /// One 16-bit normalised channel.
    R16Unorm,
    /// One half float.
    R16Float,
    /// One float.
    R32Float,
    /// Two floats.
    Rg32Float,
}

impl TableFormat {
    fn wgpu(self) -> wgpu::TextureFormat {
        match self {
            Self::R8Unorm => wgpu::TextureFormat::R8Unorm,
            Self::R16Unorm => wgpu::TextureFormat::R16Unorm,
            Self::R16Float => wgpu::TextureFormat::R16Float,
            Self::R32Float => wgpu::TextureFormat::R32Float,
            Self::Rg32Float => wgpu::TextureFormat::Rg32Float,
        }
    }

    fn bytes_per_texel(self) -> u32 {
        match self {
            Self::R8Unorm => 1,
            Self::R16Unorm | Self::R16Float => 2,
            Self::R32Float => 4,
            Self::Rg32Float => 8,
        }
    }

    /// What a device must be opened with.
    fn features(self, linear: bool) -> wgpu::Features {
        let filtered = matches!(self, Self::R32Float | Self::Rg32Float) && linear;
        let mut features = wgpu::Features::empty();
        features.set(wgpu::Features::FLOAT32_FILTERABLE, filtered);
        features.set(
            wgpu::Features::TEXTURE_FORMAT_16BIT_NORM,
            self == Self::R16Unorm,
        );
        features
    }
}

/// A table that a kernel reads: the texture at binding 0 of group 1 and its sampler at binding 1,
/// which the kernel's text declares.
#[derive(Debug, Clone, Copy)]
pub struct KernelTable<'a> {
    /// Of its texels.
    pub format: TableFormat,
    /// Texels in a row.
    pub width: u32,
    /// Rows; 1 for a line.
    pub height: u32,
    /// Six faces, each of `width` by `height`, one after the other, as a cube; else one plane.
    pub cube: bool,
    /// Whether the sampler is linear.
    pub linear: bool,
    /// Texels, row by row, without padding.
    pub texels: &'a [u8],
}

impl KernelTable<'_> {
    fn layers(&self) -> u32 {
        if self.cube { 6 } else { 1 }
    }

    fn view_dimension(&self) -> wgpu::TextureViewDimension {
        if self.cube {
            wgpu::TextureViewDimension::Cube
        } else {
            wgpu::TextureViewDimension::D2
        }
    }
}

/// A function to be evaluated.
#[derive(Debug, Clone, Copy)]
pub struct Kernel<'a> {
    /// Its name in messages.
    pub name: &'a str,
    /// WGSL that `call` needs; may be empty. It declares no bindings but those of its table.
    pub wgsl: &'a str,
    /// Type of the uniform `constants`, a structure of `wgsl`; `None` where there is none.
    pub constants: Option<&'a str>,
    /// Expression of type `vec4f` of the input `x: vec4f` and of `constants`.
    pub call: &'a str,
    /// Table of group 1.
    pub table: Option<KernelTable<'a>>,
}

impl Kernel<'static> {
    /// Returns its input: what the loop costs without the function.
    pub const BASELINE: Self = Self {
        name: "empty",
        wgsl: "",
        constants: None,
        call: "x",
        table: None,
    };
}

/// Why a kernel cannot be evaluated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// The device, or the kernel's text.
    #[error(transparent)]
    Backend(#[from] DeviceError),
    /// Other constants than the kernel was made with room for.
    #[error("{kernel}: {found} vectors of constants, allowed: at most {allowed}")]
    Constants {
        /// Which kernel.
        kernel: String,
        /// As given.
        found: usize,
        /// Room for them.
        allowed: usize,
    },
    /// A table's texels are not as many as its size says.
    #[error("{kernel}: a table of {found} bytes, needs {required}")]
    Table {
        /// Which kernel.
        kernel: String,
        /// As given.
        found: usize,
        /// Width × height × layers × bytes of a texel.
        required: usize,
    },
}

/// What the device answered.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// An answer per input, in order.
    pub values: Vec<[f32; 4]>,
    /// Dispatches it took.
    pub dispatches: usize,
}

impl Evaluation {
    /// Answers of which one of the first `components` is NaN or infinite.
    #[must_use]
    pub fn non_finite(&self, components: usize) -> usize {
        let is_bad = |value: &&[f32; 4]| value.iter().take(components).any(|v| !v.is_finite());
        self.values.iter().filter(is_bad).count()
    }
}

/// What a pass of evaluations took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EvaluationTime {
    /// CPU time of the process, milliseconds.
    pub cpu_ms: f64,
    /// Wall clock, milliseconds.
    pub wall_ms: f64,
    /// GPU clock, milliseconds; `None` where the device has no timestamps or gave none.
    pub gpu_ms: Option<f64>,
    /// Evaluations in it.
    pub evaluations: u64,
}

/// As `Run` in [`source`].
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Run {
    step: [f32; 4],
    count: u32,
    turns: u32,
    padding: [u32; 2],
}

/// A kernel on a device.
#[derive(Debug)]
pub struct Evaluator {
    gpu: Arc<Gpu>,
    name: String,
    evaluate: wgpu::ComputePipeline,
    time: wgpu::ComputePipeline,
    inputs: wgpu::Buffer,
    outputs: wgpu::Buffer,
    constants: wgpu::Buffer,
    run: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    table: Option<wgpu::BindGroup>,
    stamps: Option<Stamps>,
    constant_vectors: usize,
    input_count: usize,
}

/// A pair of timestamps around a compute pass.
#[derive(Debug)]
struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

/// WGSL of a kernel's two entry points.
fn source(kernel: &Kernel<'_>) -> String {
    let constants = kernel.constants.map_or_else(String::new, |name| {
        format!("@group(0) @binding(3) var<uniform> constants: {name};\n")
    });
    let call = kernel.call;
    let turn = format!("        x += run.step;\n        sum += {call};\n")
        .repeat(EVALUATIONS_PER_TURN as usize);
    format!(
        "struct Run {{
    step: vec4f,
    count: u32,
    turns: u32,
}}

@group(0) @binding(0) var<storage, read> inputs: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> outputs: array<vec4f>;
@group(0) @binding(2) var<uniform> run: Run;
{constants}
{wgsl}

@compute @workgroup_size({WORKGROUP_SIZE})
fn evaluate_main(@builtin(global_invocation_id) id: vec3u) {{
    if id.x >= run.count {{
        return;
    }}
    let x = inputs[id.x];
    outputs[id.x] = {call};
}}

@compute @workgroup_size({WORKGROUP_SIZE})
fn time_main(@builtin(global_invocation_id) id: vec3u) {{
    if id.x >= run.count {{
        return;
    }}
    var x = inputs[id.x];
    var sum = vec4f();
    for (var turn = 0u; turn < run.turns; turn++) {{
{turn}    }}
    outputs[id.x] = sum;
}}
",
        wgsl = kernel.wgsl
    )
}

impl Evaluator {
    /// Compiles `kernel`, with room for `constant_vectors` of four floats.
    ///
    /// # Errors
    /// [`DeviceError::Shader`] where the text does not compile, [`DeviceError::Unsupported`] where
    /// the device lacks its table's format, [`EvaluateError::Table`].
    pub fn new(
        gpu: &Arc<Gpu>,
        kernel: &Kernel<'_>,
        constant_vectors: usize,
    ) -> Result<Self, EvaluateError> {
        let module = compile(gpu, kernel)?;
        let table_layout = table_layout(gpu, kernel)?;
        let layout = group_layout(gpu, kernel);
        let layouts: Vec<Option<&wgpu::BindGroupLayout>> = std::iter::once(&layout)
            .chain(table_layout.as_ref())
            .map(Some)
            .collect();
        let pipeline_layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(kernel.name),
                bind_group_layouts: &layouts,
                immediate_size: 0,
            });
        let pipeline = |entry_point| {
            gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(kernel.name),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let buffer = |size: usize, usage| {
            gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some(kernel.name),
                size: size as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let vectors = size_of::<[f32; 4]>();
        let of_inputs = EVALUATIONS_PER_DISPATCH * vectors;
        let inputs = buffer(
            of_inputs,
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        );
        let outputs = buffer(
            of_inputs,
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        );
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let constants = buffer(constant_vectors.max(1) * vectors, uniform);
        let run = buffer(size_of::<Run>(), uniform);
        let bound = [&inputs, &outputs, &run, &constants];
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(&bound[..binding_count(kernel)])
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(kernel.name),
            layout: &layout,
            entries: &entries,
        });
        let table = match (&kernel.table, &table_layout) {
            (Some(table), Some(layout)) => Some(table_group(gpu, kernel.name, table, layout)?),
            _ => None,
        };
        Ok(Self {
            gpu: Arc::clone(gpu),
            name: kernel.name.to_owned(),
            evaluate: pipeline("evaluate_main"),
            time: pipeline("time_main"),
            inputs,
            outputs,
            constants,
            run,
            bind_group,
            table,
            stamps: Stamps::new(gpu),
            constant_vectors,
            input_count: 0,
        })
    }

    /// What the kernel is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Sets the uniform constants.
    ///
    /// # Errors
    /// [`EvaluateError::Constants`] for more than there is room for.
    pub fn set_constants(&self, constants: &[[f32; 4]]) -> Result<(), EvaluateError> {
        if constants.len() > self.constant_vectors {
            return Err(EvaluateError::Constants {
                kernel: self.name.clone(),
                found: constants.len(),
                allowed: self.constant_vectors,
            });
        }
        if !constants.is_empty() {
            let bytes = bytemuck::cast_slice(constants);
            self.gpu.write_buffer(&self.constants, 0, bytes);
        }
        Ok(())
    }

    /// Evaluates every input, in as many dispatches as it takes.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn evaluate(&self, inputs: &[[f32; 4]]) -> Result<Evaluation, EvaluateError> {
        let mut values = Vec::with_capacity(inputs.len());
        let mut dispatches = 0;
        for chunk in inputs.chunks(EVALUATIONS_PER_DISPATCH) {
            self.write_run(chunk, [0.0; 4], 1);
            self.dispatch(&self.evaluate, chunk.len(), false);
            let of_chunk = size_of_val(chunk) as u64;
            let bytes = read_buffer_start(&self.gpu, &self.outputs, of_chunk)?;
            let answers: &[[f32; 4]] = bytemuck::cast_slice(&bytes);
            values.extend_from_slice(answers);
            dispatches += 1;
        }
        Ok(Evaluation { values, dispatches })
    }

    /// Uploads what [`Evaluator::time`] evaluates: at most [`EVALUATIONS_PER_DISPATCH`] inputs, of
    /// which those beyond are left out, walked in `turns` times four steps.
    pub fn prepare_timing(&mut self, inputs: &[[f32; 4]], step: [f32; 4], turns: u32) {
        let inputs = &inputs[..inputs.len().min(EVALUATIONS_PER_DISPATCH)];
        self.write_run(inputs, step, turns);
        self.input_count = inputs.len();
    }

    /// Evaluates what was prepared once and waits; `turns` as prepared.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn time(&self, turns: u32) -> Result<EvaluationTime, EvaluateError> {
        let watch = CpuStopwatch::start();
        self.dispatch(&self.time, self.input_count, true);
        self.gpu.wait()?;
        let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        let gpu_ms = match &self.stamps {
            Some(stamps) => stamps.read_ms(&self.gpu)?,
            None => None,
        };
        Ok(EvaluationTime {
            cpu_ms,
            wall_ms,
            gpu_ms,
            evaluations: self.input_count as u64 * u64::from(turns * EVALUATIONS_PER_TURN),
        })
    }

    fn write_run(&self, inputs: &[[f32; 4]], step: [f32; 4], turns: u32) {
        let run = Run {
            step,
            count: u32::try_from(inputs.len()).unwrap_or(u32::MAX),
            turns,
            padding: [0; 2],
        };
        self.gpu
            .write_buffer(&self.run, 0, bytemuck::bytes_of(&run));
        if !inputs.is_empty() {
            let bytes = bytemuck::cast_slice(inputs);
            self.gpu.write_buffer(&self.inputs, 0, bytes);
        }
    }

    fn dispatch(&self, pipeline: &wgpu::ComputePipeline, count: usize, timed: bool) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let stamps = self.stamps.as_ref().filter(|_| timed);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(&self.name),
            timestamp_writes: stamps.map(|stamps| wgpu::ComputePassTimestampWrites {
                query_set: &stamps.queries,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            }),
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        if let Some(table) = &self.table {
            pass.set_bind_group(1, table, &[]);
        }
        let groups = count.div_ceil(WORKGROUP_SIZE);
        pass.dispatch_workgroups(u32::try_from(groups).unwrap_or(u32::MAX), 1, 1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
    }
}

impl Stamps {
    fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.facts.features.timestamps {
            return None;
        }
        Some(Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("evaluation timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("evaluation timestamps"),
                size: 16,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
        })
    }

    /// `None` for stamps of zero or that run backwards; see `timing`.
    fn read_ms(&self, gpu: &Gpu) -> Result<Option<f64>, DeviceError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        gpu.queue.submit([encoder.finish()]);
        let bytes = read_buffer(gpu, &self.resolved)?;
        let ticks: &[u64] = bytemuck::cast_slice(&bytes);
        Ok(match *ticks {
            [begin, end] if begin != 0 && end > begin => {
                Some((end - begin) as f64 * f64::from(gpu.timestamp_period_ns) * 1e-6)
            }
            _ => None,
        })
    }
}

/// Compiles the kernel's text; wgpu tells of a mistake only to whoever asks.
fn compile(gpu: &Gpu, kernel: &Kernel<'_>) -> Result<wgpu::ShaderModule, DeviceError> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = gpu
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(kernel.name),
            source: wgpu::ShaderSource::Wgsl(source(kernel).into()),
        });
    match pollster::block_on(scope.pop()) {
        None => Ok(module),
        Some(error) => Err(DeviceError::Shader {
            name: kernel.name.to_owned(),
            message: error.to_string(),
        }),
    }
}

fn binding_count(kernel: &Kernel<'_>) -> usize {
    3 + usize::from(kernel.constants.is_some())
}

fn group_layout(gpu: &Gpu, kernel: &Kernel<'_>) -> wgpu::BindGroupLayout {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let types = [
        Storage { read_only: true },
        Storage { read_only: false },
        Uniform,
        Uniform,
    ];
    let entries: Vec<wgpu::BindGroupLayoutEntry> = (0..)
        .zip(&types[..binding_count(kernel)])
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: *ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(kernel.name),
            entries: &entries,
        })
}

/// Layout of group 1, where the kernel has a table.
fn table_layout(
    gpu: &Gpu,
    kernel: &Kernel<'_>,
) -> Result<Option<wgpu::BindGroupLayout>, DeviceError> {
    let Some(table) = &kernel.table else {
        return Ok(None);
    };
    let missing = table.format.features(table.linear) - gpu.device.features();
    if !missing.is_empty() {
        return Err(DeviceError::Unsupported {
            capability: format!("{:?}, {missing}", table.format),
            adapter: gpu.facts.name.clone(),
        });
    }
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let sampler = if table.linear {
        wgpu::SamplerBindingType::Filtering
    } else {
        wgpu::SamplerBindingType::NonFiltering
    };
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float {
            filterable: table.linear,
        },
        view_dimension: table.view_dimension(),
        multisampled: false,
    };
    let descriptor = wgpu::BindGroupLayoutDescriptor {
        label: Some(kernel.name),
        entries: &[
            entry(0, texture),
            entry(1, wgpu::BindingType::Sampler(sampler)),
        ],
    };
    Ok(Some(gpu.device.create_bind_group_layout(&descriptor)))
}

fn table_group(
    gpu: &Gpu,
    name: &str,
    table: &KernelTable<'_>,
    layout: &wgpu::BindGroupLayout,
) -> Result<wgpu::BindGroup, EvaluateError> {
    let row_bytes = table.width * table.format.bytes_per_texel();
    let required = row_bytes as usize * table.height as usize * table.layers() as usize;
    if table.texels.len() != required {
        return Err(EvaluateError::Table {
            kernel: name.to_owned(),
            found: table.texels.len(),
            required,
        });
    }
    let size = wgpu::Extent3d {
        width: table.width,
        height: table.height,
        depth_or_array_layers: table.layers(),
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: table.format.wgpu(),
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout_of_texels = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(row_bytes),
        rows_per_image: Some(table.height),
    };
    gpu.queue.write_texture(
        texture.as_image_copy(),
        table.texels,
        layout_of_texels,
        size,
    );
    let filter = if table.linear {
        wgpu::FilterMode::Linear
    } else {
        wgpu::FilterMode::Nearest
    };
    let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some(name),
        mag_filter: filter,
        min_filter: filter,
        ..Default::default()
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(table.view_dimension()),
        ..Default::default()
    });
    Ok(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(name),
        layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&view),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Sampler(&sampler),
            },
        ],
    }))
}
