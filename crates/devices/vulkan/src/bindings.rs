// SPDX-License-Identifier: MIT OR Apache-2.0
//! Constants of a view and its regions, bound for shaders.

use crate::failure::failure;
use crate::{Buffer, BufferUse, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// View constants at binding 0 and, for fills, region constants at binding 1 and the footprints that lie
/// behind them at binding 2.
#[derive(Debug)]
pub struct BindGroup {
    gpu: Arc<Gpu>,
    pool: SetPool,
    has_regions: bool,
    /// The set points at them.
    _view: Arc<Buffer>,
    _regions: Option<Arc<Buffer>>,
}

impl BindGroup {
    /// Binds a uniform buffer and, for fills, a storage buffer.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`]; [`DeviceError::Unsupported`] when a buffer is of another
    /// device or for another use.
    pub fn new(
        gpu: &Arc<Gpu>,
        view: &Arc<Buffer>,
        regions: Option<&Arc<Buffer>>,
    ) -> Result<Self, DeviceError> {
        let fits =
            |buffer: &Buffer, use_for| buffer.is_on(gpu) && buffer.use_for() == Some(use_for);
        let all_fit = fits(view, BufferUse::Uniform)
            && regions.is_none_or(|regions| fits(regions, BufferUse::Storage));
        if !all_fit {
            return Err(DeviceError::unsupported(
                "binding a buffer of another device or made for another use",
                &gpu.facts.name,
            ));
        }
        let kinds = [
            vk::DescriptorType::UNIFORM_BUFFER,
            vk::DescriptorType::STORAGE_BUFFER,
            vk::DescriptorType::STORAGE_BUFFER,
        ];
        let group = Self {
            gpu: Arc::clone(gpu),
            pool: SetPool::new(gpu, gpu.fixtures.set_layout, &kinds)?,
            has_regions: regions.is_some(),
            _view: Arc::clone(view),
            _regions: regions.cloned(),
        };
        let view_info = [whole(view)];
        let region_info = [regions.map(|regions| whole(regions)).unwrap_or_default()];
        let write = |binding, kind, info| {
            vk::WriteDescriptorSet::default()
                .dst_set(group.pool.set)
                .dst_binding(binding)
                .descriptor_type(kind)
                .buffer_info(info)
        };
        let writes = [
            write(0, kinds[0], &view_info),
            write(1, kinds[1], &region_info),
            write(2, kinds[2], &region_info),
        ];
        let used = if group.has_regions { 3 } else { 1 };
        // SAFETY: the buffers are of the kinds written and live as long as the group.
        unsafe { gpu.device.update_descriptor_sets(&writes[..used], &[]) };
        Ok(group)
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }

    pub(crate) fn set(&self) -> vk::DescriptorSet {
        self.pool.set
    }

    pub(crate) fn has_regions(&self) -> bool {
        self.has_regions
    }
}

/// A descriptor set with a pool of its own.
#[derive(Debug)]
pub(crate) struct SetPool {
    gpu: Arc<Gpu>,
    pool: vk::DescriptorPool,
    pub(crate) set: vk::DescriptorSet,
}

impl SetPool {
    /// A set of `layout`, which has one descriptor of each of `kinds`.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        layout: vk::DescriptorSetLayout,
        kinds: &[vk::DescriptorType],
    ) -> Result<Self, DeviceError> {
        let sizes: Vec<_> = kinds.iter().map(|&kind| pool_size(kind)).collect();
        let pool_info = vk::DescriptorPoolCreateInfo::default()
            .max_sets(1)
            .pool_sizes(&sizes);
        // SAFETY: the structures live through the call.
        let pool = unsafe { gpu.device.create_descriptor_pool(&pool_info, None) }
            .map_err(|error| failure(error, "descriptor pool", 0))?;
        let mut made = Self {
            gpu: Arc::clone(gpu),
            pool,
            set: vk::DescriptorSet::null(),
        };
        let layouts = [layout];
        let set_info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(pool)
            .set_layouts(&layouts);
        // SAFETY: the pool has room for one set of this layout.
        let sets = unsafe { gpu.device.allocate_descriptor_sets(&set_info) }
            .map_err(|error| failure(error, "descriptor set", 0))?;
        made.set = sets.first().copied().unwrap_or_default();
        Ok(made)
    }
}

impl Drop for SetPool {
    fn drop(&mut self) {
        // SAFETY: every submission that used it has been waited for; the set goes with its pool.
        unsafe { self.gpu.device.destroy_descriptor_pool(self.pool, None) };
    }
}

fn pool_size(kind: vk::DescriptorType) -> vk::DescriptorPoolSize {
    vk::DescriptorPoolSize {
        ty: kind,
        descriptor_count: 1,
    }
}

fn whole(buffer: &Buffer) -> vk::DescriptorBufferInfo {
    vk::DescriptorBufferInfo {
        buffer: buffer.raw,
        offset: 0,
        range: vk::WHOLE_SIZE,
    }
}
