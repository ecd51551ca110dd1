// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an adapter can do that not every one can: how it is asked, and how a device is opened with it.

use crate::fixtures::{DEPTH_STENCIL_FORMAT, NUMBER_FORMAT};
use ash::{ext, khr, vk};
use std::ffi::{CStr, c_char};

/// What an adapter can do that not every one can.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Features {
    /// Geometry shaders.
    pub geometry_shader: bool,
    /// Shaders that divide patches.
    pub tessellation: bool,
    /// Pipeline statistics queries.
    pub pipeline_statistics: bool,
    /// Occlusion queries that count samples.
    pub occlusion_query_precise: bool,
    /// The depth bounds test.
    pub depth_bounds: bool,
    /// Depth clamping; with an infinite far plane nothing here needs it.
    pub depth_clamp: bool,
    /// Timestamps on the graphics queue.
    pub timestamps: bool,
    /// Blending into `R32_SFLOAT`.
    pub blends_float: bool,
    /// Shaders can read the depth that the surface left.
    pub samples_depth: bool,
    /// Mesh shaders.
    pub mesh_shader: bool,
    /// Task shaders, which start them.
    pub task_shader: bool,
    /// What vertices become can be kept in a buffer.
    pub transform_feedback: bool,
    /// Views that one draw goes to, at most; 0 without multiview.
    pub max_views: u32,
    /// Vertex shaders can choose the layer that they draw into.
    pub vertex_layer: bool,
    /// Shaders can ask what a ray meets.
    pub ray_query: bool,
    /// One call draws by many commands in a buffer, each with an instance number of its own.
    pub draws_listed: bool,
    /// Shaders can index arrays of sampled images by any number.
    pub image_arrays: bool,
}

/// What rays in shaders need besides Vulkan 1.2, which has SPIR-V 1.4 and the extensions that these lean on.
const RAY_EXTENSIONS: [&CStr; 3] = [
    khr::acceleration_structure::NAME,
    khr::deferred_host_operations::NAME,
    khr::ray_query::NAME,
];

impl Features {
    /// Extensions that a device is opened with.
    pub(crate) fn extensions(&self) -> Vec<*const c_char> {
        let own = [
            (self.mesh_shader, ext::mesh_shader::NAME),
            (self.transform_feedback, ext::transform_feedback::NAME),
            (self.vertex_layer, ext::shader_viewport_index_layer::NAME),
        ];
        let all = own
            .into_iter()
            .chain(RAY_EXTENSIONS.map(|name| (self.ray_query, name)));
        let used = all.filter(|(is_used, _)| *is_used);
        used.map(|(_, name)| name.as_ptr()).collect()
    }
}

/// An adapter that is asked.
#[derive(Clone, Copy)]
pub(crate) struct Physical<'a> {
    pub(crate) instance: &'a ash::Instance,
    pub(crate) raw: vk::PhysicalDevice,
    /// Of Vulkan.
    pub(crate) version: u32,
}

impl Physical<'_> {
    /// # Safety
    /// The adapter has Vulkan 1.1, and its version or an extension of it has the structure.
    unsafe fn features<T: vk::ExtendsPhysicalDeviceFeatures2 + Default>(self) -> T {
        let mut asked = T::default();
        let mut all = vk::PhysicalDeviceFeatures2::default().push_next(&mut asked);
        // SAFETY: the caller's promise; the device is the instance's.
        unsafe {
            self.instance
                .get_physical_device_features2(self.raw, &mut all);
        };
        asked
    }

    /// # Safety
    /// As [`Physical::features`].
    pub(crate) unsafe fn properties<T: vk::ExtendsPhysicalDeviceProperties2 + Default>(self) -> T {
        let mut asked = T::default();
        let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut asked);
        // SAFETY: the caller's promise; the device is the instance's.
        unsafe {
            self.instance
                .get_physical_device_properties2(self.raw, &mut all);
        };
        asked
    }

    /// What images of `format`, tiled as the driver likes, can be used for.
    pub(crate) fn tiling_features(self, format: vk::Format) -> vk::FormatFeatureFlags {
        let instance = self.instance;
        // SAFETY: the device is the instance's.
        let found = unsafe { instance.get_physical_device_format_properties(self.raw, format) };
        found.optimal_tiling_features
    }

    fn has(self, version: u32, extensions: &[&CStr]) -> bool {
        // SAFETY: the device is the instance's.
        let found = unsafe {
            self.instance
                .enumerate_device_extension_properties(self.raw)
        };
        let found = found.unwrap_or_default();
        let is_there = |name: &&CStr| {
            let mut names = found.iter().map(|of| of.extension_name_as_c_str());
            names.any(|found| found == Ok(*name))
        };
        self.version >= version && extensions.iter().all(is_there)
    }

    /// All but the timestamps, which a queue keeps.
    pub(crate) fn asked(self, plain: &vk::PhysicalDeviceFeatures) -> Features {
        let is = |feature: vk::Bool32| feature == vk::TRUE;
        let formats = [NUMBER_FORMAT, DEPTH_STENCIL_FORMAT].map(|of| self.tiling_features(of));
        let [numbers, depth] = formats;
        let read = vk::FormatFeatureFlags::SAMPLED_IMAGE;
        let (first, second) = (vk::API_VERSION_1_1, vk::API_VERSION_1_2);
        let mut found = Features {
            geometry_shader: is(plain.geometry_shader),
            tessellation: is(plain.tessellation_shader),
            pipeline_statistics: is(plain.pipeline_statistics_query),
            occlusion_query_precise: is(plain.occlusion_query_precise),
            depth_bounds: is(plain.depth_bounds),
            depth_clamp: is(plain.depth_clamp),
            draws_listed: is(plain.multi_draw_indirect) && is(plain.draw_indirect_first_instance),
            vertex_layer: self.has(0, &[ext::shader_viewport_index_layer::NAME]),
            blends_float: numbers.contains(read | vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND),
            samples_depth: depth.contains(read),
            ..Features::default()
        };
        if self.has(first, &[]) {
            // SAFETY: both are of Vulkan 1.1.
            let (views, limits): (
                vk::PhysicalDeviceMultiviewFeatures<'_>,
                vk::PhysicalDeviceMultiviewProperties<'_>,
            ) = unsafe { (self.features(), self.properties()) };
            found.max_views = limits.max_multiview_view_count * u32::from(is(views.multiview));
        }
        if self.has(first, &[ext::transform_feedback::NAME]) {
            // SAFETY: of an extension that is there.
            let of: vk::PhysicalDeviceTransformFeedbackFeaturesEXT<'_> = unsafe { self.features() };
            found.transform_feedback = is(of.transform_feedback);
        }
        if self.has(second, &[]) {
            // SAFETY: of Vulkan 1.2.
            let of: vk::PhysicalDeviceDescriptorIndexingFeatures<'_> = unsafe { self.features() };
            found.image_arrays = is(of.runtime_descriptor_array)
                && is(of.shader_sampled_image_array_non_uniform_indexing);
        }
        // Mesh shaders need SPIR-V 1.4, which Vulkan 1.2 has.
        if self.has(second, &[ext::mesh_shader::NAME]) {
            // SAFETY: of an extension that is there.
            let of: vk::PhysicalDeviceMeshShaderFeaturesEXT<'_> = unsafe { self.features() };
            found.mesh_shader = is(of.mesh_shader);
            found.task_shader = found.mesh_shader && is(of.task_shader);
        }
        if self.has(second, &RAY_EXTENSIONS) {
            // SAFETY: of Vulkan 1.2, and of extensions that are there.
            let (addresses, trees, rays): (
                vk::PhysicalDeviceBufferDeviceAddressFeatures<'_>,
                vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'_>,
                vk::PhysicalDeviceRayQueryFeaturesKHR<'_>,
            ) = unsafe { (self.features(), self.features(), self.features()) };
            let all = [
                addresses.buffer_device_address,
                trees.acceleration_structure,
                rays.ray_query,
            ];
            found.ray_query = all.map(is) == [true; 3];
        }
        found
    }

    /// What scratch memory of trees is aligned to, bytes.
    pub(crate) fn scratch_alignment(self, has_rays: bool) -> u64 {
        if !has_rays {
            return 1;
        }
        // SAFETY: of an extension that is there.
        let trees: vk::PhysicalDeviceAccelerationStructurePropertiesKHR<'_> =
            unsafe { self.properties() };
        u64::from(trees.min_acceleration_structure_scratch_offset_alignment).max(1)
    }
}

/// What a device is opened with beside the features of Vulkan 1.0.
pub(crate) struct Chained {
    mesh: vk::PhysicalDeviceMeshShaderFeaturesEXT<'static>,
    views: vk::PhysicalDeviceMultiviewFeatures<'static>,
    indexing: vk::PhysicalDeviceDescriptorIndexingFeatures<'static>,
    feedback: vk::PhysicalDeviceTransformFeedbackFeaturesEXT<'static>,
    addresses: vk::PhysicalDeviceBufferDeviceAddressFeatures<'static>,
    trees: vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'static>,
    rays: vk::PhysicalDeviceRayQueryFeaturesKHR<'static>,
}

impl Chained {
    pub(crate) fn new(own: &Features) -> Self {
        Self {
            mesh: vk::PhysicalDeviceMeshShaderFeaturesEXT::default()
                .mesh_shader(true)
                .task_shader(own.task_shader),
            views: vk::PhysicalDeviceMultiviewFeatures::default().multiview(true),
            indexing: vk::PhysicalDeviceDescriptorIndexingFeatures::default()
                .runtime_descriptor_array(true)
                .shader_sampled_image_array_non_uniform_indexing(true),
            feedback: vk::PhysicalDeviceTransformFeedbackFeaturesEXT::default()
                .transform_feedback(true),
            addresses: vk::PhysicalDeviceBufferDeviceAddressFeatures::default()
                .buffer_device_address(true),
            trees: vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default()
                .acceleration_structure(true),
            rays: vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true),
        }
    }

    /// With what the adapter has of it.
    pub(crate) fn onto<'a>(
        &'a mut self,
        mut info: vk::DeviceCreateInfo<'a>,
        own: &Features,
    ) -> vk::DeviceCreateInfo<'a> {
        if own.mesh_shader {
            info = info.push_next(&mut self.mesh);
        }
        if own.max_views > 0 {
            info = info.push_next(&mut self.views);
        }
        if own.image_arrays {
            info = info.push_next(&mut self.indexing);
        }
        if own.transform_feedback {
            info = info.push_next(&mut self.feedback);
        }
        if own.ray_query {
            info = info
                .push_next(&mut self.addresses)
                .push_next(&mut self.trees)
                .push_next(&mut self.rays);
        }
        info
    }
}
