// SPDX-License-Identifier: MIT OR Apache-2.0
//! Choosing and opening a device.

use crate::validation;
use std::sync::Arc;
use terrafill_contract::{
    DeviceError, DeviceLoss, DeviceOptions, DeviceType, ValidationLog, WorkCounters,
    choose_adapter, device_for_test,
};

/// What an adapter can do that not every one can.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Features {
    /// GPU timestamps in passes.
    pub timestamps: bool,
    /// Pipeline statistics.
    pub pipeline_statistics: bool,
}

/// What a device is, for reports.
pub type DeviceFacts = terrafill_contract::DeviceFacts<Features>;

/// An open device.
#[derive(Debug)]
pub struct Gpu {
    /// Device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What it is.
    pub facts: DeviceFacts,
    /// Nanoseconds per timestamp tick.
    pub timestamp_period_ns: f32,
    pub(crate) work: WorkCounters,
}

fn instance(validation: bool) -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN;
    descriptor.flags = if validation {
        validation::install_logger();
        // VALIDATION alone prints to standard output; with DEBUG the messages reach the logger.
        wgpu::InstanceFlags::VALIDATION | wgpu::InstanceFlags::DEBUG
    } else {
        wgpu::InstanceFlags::empty()
    };
    wgpu::Instance::new(descriptor)
}

fn device_type(info: &wgpu::AdapterInfo) -> DeviceType {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => DeviceType::DiscreteGpu,
        wgpu::DeviceType::IntegratedGpu => DeviceType::IntegratedGpu,
        wgpu::DeviceType::VirtualGpu => DeviceType::VirtualGpu,
        wgpu::DeviceType::Other => DeviceType::Other,
        wgpu::DeviceType::Cpu => DeviceType::Cpu,
    }
}

fn facts_of(adapter: &wgpu::Adapter) -> DeviceFacts {
    let info = adapter.get_info();
    let features = adapter.features();
    let mut lacks = Vec::new();
    if !features.contains(wgpu::Features::DEPTH32FLOAT_STENCIL8) {
        lacks.push("Depth32FloatStencil8".to_owned());
    }
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(wgpu::DownlevelFlags::VERTEX_STORAGE) {
        lacks.push("storage buffers in the vertex stage".to_owned());
    }
    DeviceFacts {
        device_type: device_type(&info).name(),
        name: info.name,
        vendor_id: info.vendor,
        device_id: info.device,
        driver: info.driver,
        driver_info: info.driver_info,
        driver_uuid: String::new(),
        features: Features {
            timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
            pipeline_statistics: features.contains(wgpu::Features::PIPELINE_STATISTICS_QUERY),
        },
        lacks,
    }
}

fn adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    found.sort_by_key(|adapter| device_type(&adapter.get_info()));
    found
}

/// Reports the device's loss. Whatever is made on a device that is gone is invalid, so errors follow from its
/// use. Any other error that nobody caught is a fault of this program.
fn watch(device: &wgpu::Device, loss: &DeviceLoss) {
    let reported = loss.clone();
    device.set_device_lost_callback(move |reason, message| {
        reported.report(&format!("{reason:?}: {message}"));
    });
    let known = loss.clone();
    device.on_uncaptured_error(Arc::new(move |error| {
        assert!(known.message().is_some(), "wgpu error: {error}");
    }));
}

/// Every Vulkan adapter of this machine, in the order in which [`Gpu::open`] prefers them.
#[must_use]
pub fn list_adapters() -> Vec<DeviceFacts> {
    adapters(&instance(false)).iter().map(facts_of).collect()
}

/// What mesh shaders need of a device, by SPIR-V of our own.
pub(crate) const MESH_SHADERS: wgpu::Features =
    wgpu::Features::EXPERIMENTAL_MESH_SHADER.union(wgpu::Features::PASSTHROUGH_SHADERS);

/// The features that mesh shaders need and the consent to experiments; neither where the adapter lacks one.
fn mesh_shaders(adapter: &wgpu::Adapter) -> (wgpu::Features, wgpu::ExperimentalFeatures) {
    if !adapter.features().contains(MESH_SHADERS) {
        return (
            wgpu::Features::empty(),
            wgpu::ExperimentalFeatures::disabled(),
        );
    }
    #[allow(
        unsafe_code,
        reason = "wgpu asks for consent to its experiments by an unsafe function"
    )]
    // SAFETY: the one experiment that is used is mesh shaders, by SPIR-V that validates; its pictures are judged.
    let consent = unsafe { wgpu::ExperimentalFeatures::enabled() };
    (MESH_SHADERS, consent)
}

impl Gpu {
    /// Opens a device.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when there is no adapter, none by that name, or it lacks
    /// something.
    pub fn open(options: &DeviceOptions) -> Result<Arc<Self>, DeviceError> {
        let validation = options.validation || ValidationLog::is_requested();
        if validation {
            validation::LOG.open()?;
        }
        let instance = instance(validation);
        let all = adapters(&instance);
        let infos: Vec<_> = all.iter().map(wgpu::Adapter::get_info).collect();
        let names: Vec<&str> = infos.iter().map(|info| info.name.as_str()).collect();
        let adapter = &all[choose_adapter(&names, options.adapter.as_deref())?];
        let facts = facts_of(adapter);
        facts.check()?;
        let optional = wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::PIPELINE_STATISTICS_QUERY
            | wgpu::Features::FLOAT32_BLENDABLE
            | wgpu::Features::FLOAT32_FILTERABLE
            | wgpu::Features::TEXTURE_FORMAT_16BIT_NORM
            | wgpu::Features::INDIRECT_FIRST_INSTANCE
            | wgpu::Features::PRIMITIVE_INDEX
            | wgpu::Features::TEXTURE_BINDING_ARRAY
            | wgpu::Features::SAMPLED_TEXTURE_AND_STORAGE_BUFFER_ARRAY_NON_UNIFORM_INDEXING;
        let (mesh_shaders, experimental_features) = mesh_shaders(adapter);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("terrafill"),
            required_features: wgpu::Features::DEPTH32FLOAT_STENCIL8
                | (adapter.features() & optional)
                | mesh_shaders,
            required_limits: adapter.limits(),
            experimental_features,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| DeviceError::DeviceLost(error.to_string()))?;
        watch(&device, &options.loss);
        let timestamp_period_ns = queue.get_timestamp_period();
        Ok(Arc::new(Self {
            device,
            queue,
            facts,
            timestamp_period_ns,
            work: WorkCounters::default(),
        }))
    }

    /// Compiles the shader at `path`, imports put in.
    ///
    /// # Errors
    /// [`DeviceError::Shader`].
    pub fn shader(&self, path: &str) -> Result<wgpu::ShaderModule, DeviceError> {
        self.volume_shader(path, false)
    }

    /// - `bends_footprints`: [`terrafill_shaders::with_footprints`]
    pub(crate) fn volume_shader(
        &self,
        path: &str,
        bends_footprints: bool,
    ) -> Result<wgpu::ShaderModule, DeviceError> {
        let source = terrafill_shaders::compose(path).map_err(|error| DeviceError::Shader {
            name: path.to_owned(),
            message: error.to_string(),
        })?;
        let source = if bends_footprints {
            terrafill_shaders::with_footprints(&source)
        } else {
            source
        };
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(path),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        };
        Ok(self.device.create_shader_module(descriptor))
    }

    /// That it lacks something.
    #[must_use]
    pub fn lacks(&self, capability: &str) -> DeviceError {
        DeviceError::unsupported(capability, &self.facts.name)
    }

    /// Whether the device was opened with features.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`], which names the capability.
    pub fn require(&self, needed: wgpu::Features, capability: &str) -> Result<(), DeviceError> {
        if self.device.features().contains(needed) {
            return Ok(());
        }
        Err(self.lacks(capability))
    }

    /// Waits until the device has nothing left to do.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn wait(&self) -> Result<(), DeviceError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map(|_| ())
            .map_err(|error| DeviceError::DeviceLost(error.to_string()))
    }
}

/// Opens a device for a test; see [`device_for_test`].
///
/// # Panics
/// As [`device_for_test`].
#[must_use]
pub fn open_for_test(options: &DeviceOptions) -> Option<Arc<Gpu>> {
    device_for_test(Gpu::open(options))
}
