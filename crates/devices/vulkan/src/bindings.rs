// SPDX-License-Identifier: MIT OR Apache-2.0
//! Descriptor sets, and that of a view's and its regions' constants.

use crate::failure::failure;
use crate::fixtures;
use crate::owned::Owned;
use crate::{Buffer, BufferUse, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// View constants at binding 0 and, for fills, region constants at binding 1 and the footprints that lie
/// behind them at binding 2.
#[derive(Debug)]
pub struct BindGroup {
    pub(crate) set: Set,
    pub(crate) has_regions: bool,
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
        let fits = view.is_for(gpu, BufferUse::Uniform)
            && regions.is_none_or(|regions| regions.is_for(gpu, BufferUse::Storage));
        let what = "binding a buffer of another device or made for another use";
        gpu.require(fits, what)?;
        let (uniform, storage) = (
            vk::DescriptorType::UNIFORM_BUFFER,
            vk::DescriptorType::STORAGE_BUFFER,
        );
        let set = Set::unwritten(gpu, gpu.fixtures.set_layout, &[uniform, storage, storage])?;
        // SAFETY: the buffers are of the kinds that the layout has there and live as long as the group.
        unsafe {
            set.write(0, 0, &Bound::Buffer(uniform, view));
            if let Some(regions) = regions {
                set.write(1, 0, &Bound::Buffer(storage, regions));
                set.write(2, 0, &Bound::Buffer(storage, regions));
            }
        }
        Ok(Self {
            set,
            has_regions: regions.is_some(),
            _view: Arc::clone(view),
            _regions: regions.cloned(),
        })
    }
}

/// What lies at a binding.
#[derive(Debug)]
pub(crate) enum Bound<'a> {
    /// All of a buffer.
    Buffer(vk::DescriptorType, &'a Buffer),
    /// So many bytes of a buffer from wherever a draw says.
    Part(&'a Buffer, u64),
    /// An image in this layout.
    Image(vk::ImageView, vk::ImageLayout),
    Sampler(vk::Sampler),
    Triangles(vk::AccelerationStructureKHR),
}

impl Bound<'_> {
    /// An image that was made to be read.
    pub(crate) fn readable(view: vk::ImageView) -> Self {
        Self::Image(view, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
    }

    pub(crate) fn kind(&self) -> vk::DescriptorType {
        match self {
            Self::Buffer(kind, _) => *kind,
            Self::Part(..) => vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC,
            Self::Image(..) => vk::DescriptorType::SAMPLED_IMAGE,
            Self::Sampler(_) => vk::DescriptorType::SAMPLER,
            Self::Triangles(_) => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        }
    }
}

/// A descriptor set with a pool of its own.
#[derive(Debug)]
pub(crate) struct Set {
    pool: Owned<vk::DescriptorPool>,
    pub(crate) raw: vk::DescriptorSet,
}

impl Set {
    /// A set that holds these at the bindings 0, 1 …
    ///
    /// # Safety
    /// The layout is the device's and has these kinds; what is bound lives as long as the set.
    pub(crate) unsafe fn new(
        gpu: &Arc<Gpu>,
        layout: vk::DescriptorSetLayout,
        bound: &[Bound<'_>],
    ) -> Result<Self, DeviceError> {
        let kinds: Vec<_> = bound.iter().map(Bound::kind).collect();
        let set = Self::unwritten(gpu, layout, &kinds)?;
        for (binding, bound) in (0..).zip(bound) {
            // SAFETY: the caller's promise.
            unsafe { set.write(binding, 0, bound) };
        }
        Ok(set)
    }

    /// A set of `layout`, which has one descriptor of each of `kinds`.
    pub(crate) fn unwritten(
        gpu: &Arc<Gpu>,
        layout: vk::DescriptorSetLayout,
        kinds: &[vk::DescriptorType],
    ) -> Result<Self, DeviceError> {
        let size = |&ty: &_| vk::DescriptorPoolSize {
            ty,
            descriptor_count: 1,
        };
        let sizes: Vec<_> = kinds.iter().map(size).collect();
        let info = vk::DescriptorPoolCreateInfo::default()
            .max_sets(1)
            .pool_sizes(&sizes);
        // SAFETY: the structures live through the call.
        let pool = unsafe {
            let made = gpu.device.create_descriptor_pool(&info, None);
            Owned::new(gpu, "descriptor pool", made)
        }?;
        let layouts = [layout];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(pool.raw)
            .set_layouts(&layouts);
        // SAFETY: the pool has room for one set of this layout; the set goes with it.
        let sets = unsafe { gpu.device.allocate_descriptor_sets(&info) }
            .map_err(|error| failure(error, "descriptor set", 0))?;
        Ok(Self {
            pool,
            raw: sets.first().copied().unwrap_or_default(),
        })
    }

    /// Writes an element of a binding.
    ///
    /// # Safety
    /// The layout has this kind there; what is bound lives as long as the set.
    pub(crate) unsafe fn write(&self, binding: u32, element: u32, bound: &Bound<'_>) {
        let write = vk::WriteDescriptorSet::default()
            .dst_set(self.raw)
            .dst_binding(binding)
            .dst_array_element(element)
            .descriptor_type(bound.kind());
        let buffer = |buffer: &Buffer, range| {
            [vk::DescriptorBufferInfo {
                buffer: buffer.raw,
                offset: 0,
                range,
            }]
        };
        let image = |sampler, image_view, image_layout| {
            [vk::DescriptorImageInfo {
                sampler,
                image_view,
                image_layout,
            }]
        };
        let (buffers, images, trees);
        let mut of_trees;
        let write = match *bound {
            Bound::Buffer(_, whole) => {
                buffers = buffer(whole, vk::WHOLE_SIZE);
                write.buffer_info(&buffers)
            }
            Bound::Part(of, bytes) => {
                buffers = buffer(of, bytes);
                write.buffer_info(&buffers)
            }
            Bound::Image(view, layout) => {
                images = image(vk::Sampler::null(), view, layout);
                write.image_info(&images)
            }
            Bound::Sampler(sampler) => {
                images = image(sampler, vk::ImageView::null(), vk::ImageLayout::UNDEFINED);
                write.image_info(&images)
            }
            Bound::Triangles(tree) => {
                trees = [tree];
                of_trees = vk::WriteDescriptorSetAccelerationStructureKHR::default()
                    .acceleration_structures(&trees);
                write.descriptor_count(1).push_next(&mut of_trees)
            }
        };
        // SAFETY: the caller's promise.
        unsafe { self.pool.gpu().device.update_descriptor_sets(&[write], &[]) };
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        self.pool.is_on(gpu)
    }
}

/// A layout of so many of each kind at the bindings 0, 1 …, for every stage.
pub(crate) fn set_layout(
    gpu: &Arc<Gpu>,
    kinds: impl Iterator<Item = (vk::DescriptorType, u32)>,
) -> Result<Owned<vk::DescriptorSetLayout>, DeviceError> {
    let kinds = kinds.map(|(kind, count)| (kind, count, vk::ShaderStageFlags::ALL));
    let made = fixtures::set_layout(&gpu.device, kinds);
    // SAFETY: the layout is this device's; sets hold what they are made with.
    unsafe { Owned::new(gpu, "layout of resources", made) }
}
