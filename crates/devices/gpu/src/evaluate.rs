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
use crate::route_table::RouteTable;
use crate::{CpuStopwatch, Gpu, PassTimer, TimedPass};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_stencil::RouteTexels;

/// Of its stamps.
const SLOT: TimedPass = TimedPass::Surface;

/// Inputs of one dispatch; more are taken in several.
pub const EVALUATIONS_PER_DISPATCH: usize = 16_384;

/// Invocations of a workgroup: a multiple of every subgroup size in use.
const WORKGROUP_SIZE: usize = 64;

/// Evaluations written out in a turn of the timed loop, so that counting turns, and the bound that
/// naga puts on every loop, weigh little.
const EVALUATIONS_PER_TURN: u32 = 4;

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
    /// Table of group 1, which the text declares: the texture at binding 0, its sampler at 1.
    pub table: Option<&'a RouteTexels>,
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
    table: Option<RouteTable>,
    timer: Option<PassTimer>,
    constant_vectors: usize,
    input_count: usize,
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
        let table = table(gpu, kernel)?;
        let layout = gpu.buffer_layout(
            kernel.name,
            wgpu::ShaderStages::COMPUTE,
            &BINDINGS[..binding_count(kernel)],
        );
        let own = table.as_ref().map(|table| &table.layout);
        let layouts: Vec<_> = std::iter::once(&layout).chain(own).map(Some).collect();
        let pipeline =
            |entry_point| gpu.compute_pipeline(kernel.name, &module, entry_point, &layouts, &[]);
        let buffer = |size: usize, usage| gpu.unwritten(kernel.name, size as u64, usage);
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
        let bound = &bound[..binding_count(kernel)];
        let bind_group = gpu.bind_buffers(kernel.name, &layout, bound);
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
            timer: PassTimer::new(gpu),
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
        let timed = self.timer.as_ref().map(|of| of.pass_ms(&self.gpu, SLOT));
        // Two equal stamps are no time of so many evaluations.
        let gpu_ms = timed.transpose()?.flatten().filter(|ms| *ms > 0.0);
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
        let timer = self.timer.as_ref().filter(|_| timed);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(&self.name),
            timestamp_writes: timer.map(|timer| timer.around_compute(SLOT)),
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        if let Some(table) = &self.table {
            pass.set_bind_group(1, &table.group, &[]);
        }
        let groups = count.div_ceil(WORKGROUP_SIZE);
        pass.dispatch_workgroups(u32::try_from(groups).unwrap_or(u32::MAX), 1, 1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
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

/// Inputs, outputs, [`Run`], and the kernel's own constants.
const BINDINGS: [wgpu::BufferBindingType; 4] = [
    wgpu::BufferBindingType::Storage { read_only: true },
    wgpu::BufferBindingType::Storage { read_only: false },
    wgpu::BufferBindingType::Uniform,
    wgpu::BufferBindingType::Uniform,
];

/// What the kernel reads, if it reads any.
fn table(gpu: &Gpu, kernel: &Kernel<'_>) -> Result<Option<RouteTable>, EvaluateError> {
    let Some(texels) = kernel.table else {
        return Ok(None);
    };
    let (found, required) = (texels.bytes.len(), texels.byte_count());
    if found != required {
        return Err(EvaluateError::Table {
            kernel: kernel.name.to_owned(),
            found,
            required,
        });
    }
    Ok(Some(RouteTable::new(
        gpu,
        texels,
        wgpu::ShaderStages::COMPUTE,
    )?))
}
