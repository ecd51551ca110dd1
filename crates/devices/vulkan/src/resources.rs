// SPDX-License-Identifier: MIT OR Apache-2.0
//! Buffers and images at the bindings of one set, for pipelines that are no fills.

use crate::bindings::SetPool;
use crate::failure::failure;
use crate::image_array::ImageArray;
use crate::{BlockImage, Buffer, BufferUse, Gpu, LayeredDepth, SampledImage, TriangleTree};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// What shaders find at a binding.
#[derive(Debug, Clone)]
pub enum Resource {
    /// A uniform block.
    Uniform(Arc<Buffer>),
    /// An array that shaders read or write.
    Storage(Arc<Buffer>),
    /// An image whose texels are loaded by their number.
    Image(Arc<SampledImage>),
    /// Depth maps that are drawn into before.
    Depths(Arc<LayeredDepth>),
    /// Triangles that rays may meet.
    Triangles(Arc<TriangleTree>),
    /// An image that is written in parts, whose texels are loaded by their number.
    Blocks(Arc<BlockImage>),
}

impl Resource {
    fn kind(&self) -> vk::DescriptorType {
        match self {
            Self::Uniform(_) => vk::DescriptorType::UNIFORM_BUFFER,
            Self::Storage(_) => vk::DescriptorType::STORAGE_BUFFER,
            Self::Image(_) | Self::Depths(_) | Self::Blocks(_) => vk::DescriptorType::SAMPLED_IMAGE,
            Self::Triangles(_) => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        }
    }

    /// Null for what is no image.
    fn view(&self) -> vk::ImageView {
        match self {
            Self::Uniform(_) | Self::Storage(_) | Self::Triangles(_) => vk::ImageView::null(),
            Self::Image(image) => image.view(),
            Self::Depths(depths) => depths.view(),
            Self::Blocks(blocks) => blocks.view(),
        }
    }

    fn fits(&self, gpu: &Arc<Gpu>) -> bool {
        match self {
            Self::Uniform(buffer) => {
                buffer.is_on(gpu) && buffer.use_for() == Some(BufferUse::Uniform)
            }
            Self::Storage(buffer) => {
                let uses = [BufferUse::Storage, BufferUse::Arguments, BufferUse::State];
                buffer.is_on(gpu) && buffer.use_for().is_some_and(|of| uses.contains(&of))
            }
            Self::Image(image) => image.is_on(gpu),
            Self::Depths(depths) => depths.is_on(gpu),
            Self::Triangles(tree) => tree.is_on(gpu),
            Self::Blocks(blocks) => blocks.is_on(gpu),
        }
    }
}

/// Resources at the bindings 0, 1 … of set 0, visible to every stage, and an array of images where there is one.
#[derive(Debug)]
pub struct Resources {
    gpu: Arc<Gpu>,
    set_layout: vk::DescriptorSetLayout,
    pub(crate) layout: vk::PipelineLayout,
    pool: Option<SetPool>,
    kinds: Vec<vk::DescriptorType>,
    array: Option<ImageArray>,
    /// The set points at them.
    _held: Vec<Resource>,
}

impl Resources {
    /// Binds `resources` in their order.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when one is of another device or a buffer for another use;
    /// [`DeviceError::OutOfMemory`].
    pub fn new(gpu: &Arc<Gpu>, resources: Vec<Resource>) -> Result<Arc<Self>, DeviceError> {
        Self::make(gpu, resources, None)
    }

    /// As [`Resources::new`], with an array of images, indexed freely, at binding 0 of set 1.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] also when the device does not index arrays of images freely,
    /// [`DeviceError::OverCapacity`] when it binds fewer images.
    pub fn with_array(
        gpu: &Arc<Gpu>,
        resources: Vec<Resource>,
        images: Vec<Arc<BlockImage>>,
    ) -> Result<Arc<Self>, DeviceError> {
        let array = ImageArray::new(gpu, images)?;
        Self::make(gpu, resources, Some(array))
    }

    fn make(
        gpu: &Arc<Gpu>,
        resources: Vec<Resource>,
        array: Option<ImageArray>,
    ) -> Result<Arc<Self>, DeviceError> {
        if !resources.iter().all(|resource| resource.fits(gpu)) {
            return Err(DeviceError::unsupported(
                "binding a resource of another device or made for another use",
                &gpu.facts.name,
            ));
        }
        let kinds: Vec<_> = resources.iter().map(Resource::kind).collect();
        let bindings: Vec<_> = (0..)
            .zip(&kinds)
            .map(|(binding, &kind)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding)
                    .descriptor_type(kind)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::ALL)
            })
            .collect();
        let mut made = Self {
            gpu: Arc::clone(gpu),
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            pool: None,
            kinds,
            array,
            _held: resources.clone(),
        };
        let broken = |error| failure(error, "resources", 0);
        let set_info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the structures live through the calls.
        unsafe {
            let device = &gpu.device;
            made.set_layout = device
                .create_descriptor_set_layout(&set_info, None)
                .map_err(broken)?;
            let mut set_layouts = vec![made.set_layout];
            set_layouts.extend(made.array.as_ref().map(ImageArray::layout));
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts);
            made.layout = device.create_pipeline_layout(&info, None).map_err(broken)?;
        }
        let pool = SetPool::new(gpu, made.set_layout, &made.kinds)?;
        for (binding, resource) in (0..).zip(&resources) {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(pool.set)
                .dst_binding(binding)
                .descriptor_type(resource.kind());
            match resource {
                Resource::Uniform(buffer) | Resource::Storage(buffer) => {
                    let whole = [vk::DescriptorBufferInfo {
                        buffer: buffer.raw,
                        offset: 0,
                        range: vk::WHOLE_SIZE,
                    }];
                    let writes = [write.buffer_info(&whole)];
                    // SAFETY: of the kind that the layout has there; it lives as long as the set.
                    unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
                }
                Resource::Image(_) | Resource::Depths(_) | Resource::Blocks(_) => {
                    let images = [vk::DescriptorImageInfo {
                        sampler: vk::Sampler::null(),
                        image_view: resource.view(),
                        image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
                    }];
                    let writes = [write.image_info(&images)];
                    // SAFETY: as above.
                    unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
                }
                Resource::Triangles(tree) => {
                    let trees = [tree.raw()];
                    let mut own = vk::WriteDescriptorSetAccelerationStructureKHR::default()
                        .acceleration_structures(&trees);
                    let writes = [write.descriptor_count(1).push_next(&mut own)];
                    // SAFETY: as above.
                    unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
                }
            }
        }
        made.pool = Some(pool);
        Ok(Arc::new(made))
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }

    /// Whether pipelines made for one find the other's just as well.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let counts = [self, other].map(|of| of.array.as_ref().map(ImageArray::count));
        Arc::ptr_eq(&self.gpu, &other.gpu) && self.kinds == other.kinds && counts[0] == counts[1]
    }

    /// All sets, from 0.
    pub(crate) fn sets(&self) -> Vec<vk::DescriptorSet> {
        let array = self.array.as_ref().map(ImageArray::set);
        [self.set()].into_iter().chain(array).collect()
    }

    pub(crate) fn set(&self) -> vk::DescriptorSet {
        self.pool
            .as_ref()
            .map_or(vk::DescriptorSet::null(), |pool| pool.set)
    }
}

impl Drop for Resources {
    fn drop(&mut self) {
        // SAFETY: every submission that used them has been waited for; null is ignored.
        unsafe {
            self.gpu.device.destroy_pipeline_layout(self.layout, None);
            self.gpu
                .device
                .destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}
