// SPDX-License-Identifier: MIT OR Apache-2.0
//! Buffers and images at the bindings of one set, for pipelines that are no fills.

use crate::bindings::{Bound, Set, set_layout};
use crate::fixtures::pipeline_layout;
use crate::image_array::ImageArray;
use crate::owned::Owned;
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
    fn bound(&self) -> Bound<'_> {
        match self {
            Self::Uniform(buffer) => Bound::Buffer(vk::DescriptorType::UNIFORM_BUFFER, buffer),
            Self::Storage(buffer) => Bound::Buffer(vk::DescriptorType::STORAGE_BUFFER, buffer),
            Self::Image(image) => Bound::readable(image.image.view),
            Self::Depths(depths) => Bound::readable(depths.image.view),
            Self::Blocks(blocks) => Bound::readable(blocks.image.view),
            Self::Triangles(tree) => Bound::Triangles(tree.raw()),
        }
    }

    fn fits(&self, gpu: &Arc<Gpu>) -> bool {
        match self {
            Self::Uniform(buffer) => buffer.is_for(gpu, BufferUse::Uniform),
            Self::Storage(buffer) => {
                let mut uses =
                    [BufferUse::Storage, BufferUse::Arguments, BufferUse::State].into_iter();
                uses.any(|of| buffer.is_for(gpu, of))
            }
            Self::Image(image) => image.image.is_on(gpu),
            Self::Depths(depths) => depths.image.is_on(gpu),
            Self::Triangles(tree) => tree.is_on(gpu),
            Self::Blocks(blocks) => blocks.image.is_on(gpu),
        }
    }
}

/// Resources at the bindings 0, 1 … of set 0, visible to every stage, and an array of images where there is one.
#[derive(Debug)]
pub struct Resources {
    layout: Owned<vk::PipelineLayout>,
    set: Set,
    kinds: Vec<vk::DescriptorType>,
    array: Option<ImageArray>,
    _set_layout: Owned<vk::DescriptorSetLayout>,
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
        let fits = resources.iter().all(|resource| resource.fits(gpu));
        let what = "binding a resource of another device or made for another use";
        gpu.require(fits, what)?;
        let bound: Vec<_> = resources.iter().map(Resource::bound).collect();
        let kinds: Vec<_> = bound.iter().map(Bound::kind).collect();
        let set_layout = set_layout(gpu, kinds.iter().map(|&kind| (kind, 1)))?;
        let mut set_layouts = vec![set_layout.raw];
        set_layouts.extend(array.as_ref().map(ImageArray::layout));
        let made = pipeline_layout(&gpu.device, &set_layouts);
        // SAFETY: the layout is this device's; pipelines hold what they are made with.
        let layout = unsafe { Owned::new(gpu, "resources", made) }?;
        // SAFETY: the layout was made of these kinds; what is bound is held beside the set.
        let set = unsafe { Set::new(gpu, set_layout.raw, &bound) }?;
        Ok(Arc::new(Self {
            layout,
            set,
            kinds,
            array,
            _set_layout: set_layout,
            _held: resources,
        }))
    }

    /// For pipelines.
    pub(crate) fn layout(&self) -> vk::PipelineLayout {
        self.layout.raw
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        self.layout.is_on(gpu)
    }

    /// Whether pipelines made for one find the other's just as well.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let counts = [self, other].map(|of| of.array.as_ref().map(ImageArray::count));
        self.is_on(other.layout.gpu()) && self.kinds == other.kinds && counts[0] == counts[1]
    }

    /// Binds all sets, from 0 on.
    ///
    /// # Safety
    /// Recording is under way on their device.
    pub(crate) unsafe fn bind(&self, commands: vk::CommandBuffer, point: vk::PipelineBindPoint) {
        let array = self.array.as_ref().map(|array| array.set.raw);
        let sets: Vec<_> = std::iter::once(self.set.raw).chain(array).collect();
        let device = &self.layout.gpu().device;
        // SAFETY: the caller's promise; the sets are those of the layout.
        unsafe {
            device.cmd_bind_descriptor_sets(commands, point, self.layout.raw, 0, &sets, &[]);
        }
    }
}
