// SPDX-License-Identifier: MIT OR Apache-2.0
//! Choosing and opening a device.
//!
//! The order of preference is that of `terrafill-gpu`, so both open the same adapter. Vulkan 1.1 is
//! needed: viewports of negative height, SPIR-V 1.3.

use crate::failure::failure;
use crate::features::{Chained, Features, Physical};
use crate::fixtures::{DEPTH_STENCIL_FORMAT, Fixtures};
use crate::shader_modules::ShaderModules;
use crate::validation;
use ash::{ext, khr, vk};
use std::ffi::CStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use terrafill_contract::{
    DeviceError, DeviceLoss, DeviceOptions, DeviceType, THIS_MACHINE, ValidationLog, WorkCounters,
    WorkDone, choose_adapter, device_for_test,
};

/// What a device is, for reports.
pub type DeviceFacts = terrafill_contract::DeviceFacts<Features>;

/// The queue and what is needed to hand it one submission at a time.
#[derive(Debug)]
pub(crate) struct Queue {
    raw: vk::Queue,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
}

/// The loader, the instance and whoever listens to the layer.
struct Api {
    /// Keeps the library loaded.
    _entry: ash::Entry,
    instance: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
}

/// An open device.
pub struct Gpu {
    pub(crate) device: ash::Device,
    pub(crate) memory: vk::PhysicalDeviceMemoryProperties,
    pub(crate) limits: vk::PhysicalDeviceLimits,
    pub(crate) work: WorkCounters,
    pub(crate) allocated_bytes: AtomicU64,
    pub(crate) fixtures: Fixtures,
    pub(crate) shader_modules: ShaderModules,
    /// Draws by mesh shaders, where there are any.
    pub(crate) mesh: Option<ext::mesh_shader::Device>,
    /// Keeps what vertices become, where it can.
    pub(crate) feedback: Option<ext::transform_feedback::Device>,
    /// Builds trees of triangles for rays, where shaders can ask them.
    pub(crate) trees: Option<khr::acceleration_structure::Device>,
    /// What scratch memory of such a build is aligned to, bytes.
    pub(crate) scratch_alignment: u64,
    /// What it is.
    pub facts: DeviceFacts,
    loss: DeviceLoss,
    queue: Mutex<Queue>,
    physical: vk::PhysicalDevice,
    // Dropped last: fields go in the order in which they are written.
    api: Api,
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Gpu")
            .field("facts", &self.facts)
            .finish_non_exhaustive()
    }
}

impl Api {
    fn load(validation: bool) -> Result<Self, DeviceError> {
        // SAFETY: loads the system's Vulkan loader, whose initialisers are its own affair.
        let entry = unsafe { ash::Entry::load() }.map_err(|error| no_loader(&error))?;
        let mut layers = Vec::new();
        let mut extensions = Vec::new();
        if validation {
            validation::LOG.open()?;
            if has_layer(&entry, validation::LAYER)? {
                layers.push(validation::LAYER.as_ptr());
                extensions.push(ext::debug_utils::NAME.as_ptr());
            } else {
                // Must not pass for silence.
                let words = "validation is asked for and the layer is not installed";
                validation::LOG.keep("WARN", "validation-layer-missing", words);
            }
        }
        let application = vk::ApplicationInfo::default()
            .application_name(c"terrafill")
            .api_version(vk::API_VERSION_1_3);
        let mut messenger_info = validation::messenger_info();
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        if !layers.is_empty() {
            info = info.push_next(&mut messenger_info);
        }
        // SAFETY: the structures live through the call; the layer and the extension are there.
        let instance = unsafe { entry.create_instance(&info, None) }.map_err(|error| {
            DeviceError::unsupported(&format!("a Vulkan instance: {error}"), THIS_MACHINE)
        })?;
        let mut api = Self {
            messenger: None,
            _entry: entry,
            instance,
        };
        if !layers.is_empty() {
            let listener = ext::debug_utils::Instance::new(&api._entry, &api.instance);
            let info = validation::messenger_info();
            // SAFETY: the extension is enabled; the callback keeps to Rust and never unwinds.
            let messenger = unsafe { listener.create_debug_utils_messenger(&info, None) }
                .map_err(|error| failure(error, "debug messenger", 0))?;
            api.messenger = Some((listener, messenger));
        }
        Ok(api)
    }

    /// Adapters in order of preference.
    fn adapters(&self) -> Result<Vec<Adapter>, DeviceError> {
        // SAFETY: the instance is alive.
        let found = unsafe { self.instance.enumerate_physical_devices() }
            .map_err(|error| failure(error, "enumerating devices", 0))?;
        let mut adapters: Vec<Adapter> = found
            .into_iter()
            .map(|raw| Adapter::new(&self.instance, raw))
            .collect();
        adapters.sort_by_key(|adapter| adapter.device_type);
        Ok(adapters)
    }
}

impl Drop for Api {
    fn drop(&mut self) {
        // SAFETY: the messenger is the instance's own; nothing made by the instance is left, since
        // whoever holds such a thing holds this.
        unsafe {
            if let Some((listener, messenger)) = self.messenger.take() {
                listener.destroy_debug_utils_messenger(messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

fn no_loader(error: &ash::LoadingError) -> DeviceError {
    let what = format!("a Vulkan loader (ci/setup.sh installs one): {error}");
    DeviceError::unsupported(&what, THIS_MACHINE)
}

fn has_layer(entry: &ash::Entry, name: &CStr) -> Result<bool, DeviceError> {
    // SAFETY: the loader is loaded.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }
        .map_err(|error| failure(error, "enumerating layers", 0))?;
    Ok(layers
        .iter()
        .any(|layer| layer.layer_name_as_c_str() == Ok(name)))
}

struct Adapter {
    raw: vk::PhysicalDevice,
    device_type: DeviceType,
    limits: vk::PhysicalDeviceLimits,
    queue_family: Option<u32>,
    /// Attachments need not be stored.
    has_no_store: bool,
    scratch_alignment: u64,
    facts: DeviceFacts,
}

fn text(words: Result<&CStr, std::ffi::FromBytesUntilNulError>) -> String {
    words.map_or(String::new(), |words| words.to_string_lossy().into_owned())
}

/// Empty for bytes that nobody wrote.
fn hexadecimal(bytes: &[u8]) -> String {
    if bytes.iter().all(|byte| *byte == 0) {
        return String::new();
    }
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Adapter {
    fn new(instance: &ash::Instance, raw: vk::PhysicalDevice) -> Self {
        // SAFETY: the device is the instance's, and this is of Vulkan 1.0.
        let plain = unsafe { instance.get_physical_device_properties(raw) };
        let physical = Physical {
            instance,
            raw,
            version: plain.api_version,
        };
        let is_new = plain.api_version >= vk::API_VERSION_1_2;
        let (driver, ids): (
            vk::PhysicalDeviceDriverProperties<'_>,
            vk::PhysicalDeviceIDProperties<'_>,
        ) = if is_new {
            // SAFETY: of Vulkan 1.2, and of 1.1.
            unsafe { (physical.properties(), physical.properties()) }
        } else {
            Default::default()
        };
        // SAFETY: as above.
        let features = unsafe { instance.get_physical_device_features(raw) };
        // SAFETY: as above.
        let families = unsafe { instance.get_physical_device_queue_family_properties(raw) };
        let family = (0..)
            .zip(&families)
            .find(|(_, family)| family.queue_flags.contains(vk::QueueFlags::GRAPHICS));
        let format = physical.tiling_features(DEPTH_STENCIL_FORMAT);
        let attachable = format.contains(vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT);
        let own = Features {
            timestamps: family.is_some_and(|(_, family)| family.timestamp_valid_bits > 0),
            ..physical.asked(&features)
        };
        let mut lacks = Vec::new();
        if plain.api_version < vk::API_VERSION_1_1 {
            lacks.push("Vulkan 1.1".to_owned());
        }
        if family.is_none() {
            lacks.push("a graphics queue".to_owned());
        }
        if !attachable {
            lacks.push("Depth32FloatStencil8".to_owned());
        }
        let device_type = match plain.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => DeviceType::DiscreteGpu,
            vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceType::IntegratedGpu,
            vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceType::VirtualGpu,
            vk::PhysicalDeviceType::CPU => DeviceType::Cpu,
            _ => DeviceType::Other,
        };
        Self {
            raw,
            device_type,
            limits: plain.limits,
            queue_family: family.map(|(index, _)| index),
            has_no_store: plain.api_version >= vk::API_VERSION_1_3,
            scratch_alignment: physical.scratch_alignment(own.ray_query),
            facts: DeviceFacts {
                name: text(plain.device_name_as_c_str()),
                device_type: device_type.name(),
                vendor_id: plain.vendor_id,
                device_id: plain.device_id,
                driver: text(driver.driver_name_as_c_str()),
                driver_info: text(driver.driver_info_as_c_str()),
                driver_uuid: hexadecimal(&ids.driver_uuid),
                features: own,
                lacks,
            },
        }
    }
}

/// Every Vulkan adapter of this machine, in the order in which [`Gpu::open`] prefers them.
///
/// # Errors
/// [`DeviceError::Unsupported`] where there is no Vulkan loader.
pub fn list_adapters() -> Result<Vec<DeviceFacts>, DeviceError> {
    let adapters = Api::load(false)?.adapters()?;
    Ok(adapters.into_iter().map(|adapter| adapter.facts).collect())
}

impl Gpu {
    /// Opens a device.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when there is no loader, no adapter, none by that name, or it
    /// lacks something.
    pub fn open(options: &DeviceOptions) -> Result<Arc<Self>, DeviceError> {
        let api = Api::load(options.validation || ValidationLog::is_requested())?;
        let all = api.adapters()?;
        let names: Vec<&str> = all.iter().map(|a| a.facts.name.as_str()).collect();
        let adapter = &all[choose_adapter(&names, options.adapter.as_deref())?];
        adapter.facts.check()?;
        let Some(family) = adapter.queue_family else {
            let name = &adapter.facts.name;
            return Err(DeviceError::unsupported("a graphics queue", name));
        };
        Self::on(api, adapter, family, options.loss.clone())
    }

    fn on(
        api: Api,
        adapter: &Adapter,
        family: u32,
        loss: DeviceLoss,
    ) -> Result<Arc<Self>, DeviceError> {
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(family)
            .queue_priorities(&priorities)];
        let own = adapter.facts.features;
        let features = vk::PhysicalDeviceFeatures::default()
            // Every driver has it, and wgpu asks for it too.
            .robust_buffer_access(true)
            .geometry_shader(own.geometry_shader)
            .tessellation_shader(own.tessellation)
            .pipeline_statistics_query(own.pipeline_statistics)
            .occlusion_query_precise(own.occlusion_query_precise)
            .depth_bounds(own.depth_bounds)
            .depth_clamp(own.depth_clamp)
            .multi_draw_indirect(own.draws_listed)
            .draw_indirect_first_instance(own.draws_listed);
        let extensions = own.extensions();
        let mut chained = Chained::new(&own);
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&features)
            .enabled_extension_names(&extensions);
        let info = chained.onto(info, &own);
        // SAFETY: the family, the features and the extensions are the adapter's.
        let device = unsafe { api.instance.create_device(adapter.raw, &info, None) }
            .map_err(|error| failure(error, "device", 0))?;
        let made = Queue::new(&device, family).and_then(|queue| {
            Fixtures::new(&device, adapter.has_no_store)
                .inspect_err(|_| queue.destroy(&device))
                .map(|fixtures| (queue, fixtures))
        });
        let (queue, fixtures) = match made {
            Ok(made) => made,
            Err(error) => {
                // SAFETY: nothing made by the device is left.
                unsafe { device.destroy_device(None) };
                return Err(error);
            }
        };
        // SAFETY: the adapter is the instance's.
        let memory = unsafe {
            api.instance
                .get_physical_device_memory_properties(adapter.raw)
        };
        let mesh = own
            .mesh_shader
            .then(|| ext::mesh_shader::Device::new(&api.instance, &device));
        let trees = own
            .ray_query
            .then(|| khr::acceleration_structure::Device::new(&api.instance, &device));
        Ok(Arc::new(Self {
            mesh,
            trees,
            scratch_alignment: adapter.scratch_alignment,
            feedback: own
                .transform_feedback
                .then(|| ext::transform_feedback::Device::new(&api.instance, &device)),
            device,
            memory,
            limits: adapter.limits,
            work: WorkCounters::default(),
            allocated_bytes: AtomicU64::new(0),
            fixtures,
            shader_modules: ShaderModules::default(),
            facts: adapter.facts.clone(),
            queue: Mutex::new(queue),
            physical: adapter.raw,
            loss,
            api,
        }))
    }

    /// What was made and written so far.
    #[must_use]
    pub fn work_done(&self) -> WorkDone {
        self.work.done()
    }

    /// Device memory that is allocated now, bytes.
    #[must_use]
    pub fn allocated_bytes(&self) -> u64 {
        self.allocated_bytes.load(Ordering::Relaxed)
    }

    /// What images of `format`, tiled as the driver likes, can be used for.
    pub(crate) fn format_features(&self, format: vk::Format) -> vk::FormatFeatureFlags {
        // SAFETY: the adapter is the instance's.
        let properties = unsafe {
            self.api
                .instance
                .get_physical_device_format_properties(self.physical, format)
        };
        properties.optimal_tiling_features
    }

    /// That it lacks something.
    #[must_use]
    pub fn lacks(&self, capability: &str) -> DeviceError {
        DeviceError::unsupported(capability, &self.facts.name)
    }

    /// Refuses what it lacks.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`], which names the capability.
    pub fn require(&self, is_there: bool, capability: &str) -> Result<(), DeviceError> {
        if is_there {
            return Ok(());
        }
        Err(self.lacks(capability))
    }

    /// Nanoseconds per timestamp tick.
    #[must_use]
    pub fn timestamp_period_ns(&self) -> f32 {
        self.limits.timestamp_period
    }

    /// Records commands, submits them and waits until the device is done.
    ///
    /// # Safety
    /// What `record` records must be valid usage of the device's own objects, and these must live
    /// until this returns.
    pub(crate) unsafe fn submit(
        &self,
        record: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) -> Result<(), DeviceError> {
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let commands = [queue.commands];
        let submits = [vk::SubmitInfo::default().command_buffers(&commands)];
        // SAFETY: pool, buffer, fence and queue are used under the lock only, and the previous
        // submission has been waited for. What is recorded is the caller's promise.
        unsafe {
            self.device
                .reset_command_pool(queue.pool, vk::CommandPoolResetFlags::empty())
                .and_then(|()| self.device.begin_command_buffer(queue.commands, &begin))
                .map_err(|error| failure(error, "recording", 0))?;
            record(&self.device, queue.commands);
            self.device
                .end_command_buffer(queue.commands)
                .and_then(|()| self.device.reset_fences(&[queue.fence]))
                .and_then(|()| self.device.queue_submit(queue.raw, &submits, queue.fence))
                .and_then(|()| self.device.wait_for_fences(&[queue.fence], true, u64::MAX))
                .map_err(|error| {
                    let failure = failure(error, "submitting and waiting", 0);
                    if let DeviceError::DeviceLost(message) = &failure {
                        self.loss.report(message);
                    }
                    failure
                })
        }
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        let queue = self.queue.get_mut().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: every submission has been waited for, and whatever else was made by the device
        // holds this and is therefore gone.
        unsafe {
            self.shader_modules.destroy(&self.device);
            self.fixtures.destroy(&self.device);
            queue.destroy(&self.device);
            self.device.destroy_device(None);
        }
    }
}

impl Queue {
    fn new(device: &ash::Device, family: u32) -> Result<Self, DeviceError> {
        let pool_info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the family is one of the device's.
        let pool = unsafe { device.create_command_pool(&pool_info, None) }
            .map_err(|error| failure(error, "command pool", 0))?;
        let commands_info = vk::CommandBufferAllocateInfo::default()
            .command_pool(pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool is the device's; it is destroyed here if anything else cannot be had.
        let rest = unsafe {
            device
                .allocate_command_buffers(&commands_info)
                .and_then(|commands| {
                    let fence = device.create_fence(&vk::FenceCreateInfo::default(), None)?;
                    let first = commands.first().copied();
                    Ok((first.unwrap_or_default(), fence))
                })
                .inspect_err(|_| device.destroy_command_pool(pool, None))
        };
        let (commands, fence) = rest.map_err(|error| failure(error, "command buffer", 0))?;
        Ok(Self {
            // SAFETY: one queue of this family was asked for.
            raw: unsafe { device.get_device_queue(family, 0) },
            pool,
            commands,
            fence,
        })
    }

    fn destroy(&self, device: &ash::Device) {
        // SAFETY: both are the device's and no submission is under way.
        unsafe {
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_without_a_loader_is_told_what_it_lacks() {
        // SAFETY: there is no such file, so nothing of it is run.
        let loaded = unsafe { ash::Entry::load_from("no-such-folder/libvulkan.so.1") };
        let error = loaded.err().map(|error| no_loader(&error));
        let Some(DeviceError::Unsupported {
            capability,
            adapter,
        }) = error
        else {
            panic!("loaded from nowhere");
        };
        assert!(capability.starts_with("a Vulkan loader"), "{capability}");
        assert!(capability.contains("no-such-folder"), "{capability}");
        assert_eq!(adapter, THIS_MACHINE);
    }
}
