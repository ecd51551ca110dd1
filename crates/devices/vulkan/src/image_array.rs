// SPDX-License-Identifier: MIT OR Apache-2.0
//! An array of images as a set of its own, of which a shader chooses one by any number.

use crate::bindings::{Bound, Set, set_layout};
use crate::memory::check_some;
use crate::owned::Owned;
use crate::{BlockImage, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

const KIND: vk::DescriptorType = vk::DescriptorType::SAMPLED_IMAGE;

#[derive(Debug)]
pub(crate) struct ImageArray {
    layout: Owned<vk::DescriptorSetLayout>,
    pub(crate) set: Set,
    /// The set points at them.
    images: Vec<Arc<BlockImage>>,
}

impl ImageArray {
    pub(crate) fn new(gpu: &Arc<Gpu>, images: Vec<Arc<BlockImage>>) -> Result<Self, DeviceError> {
        let has_arrays = gpu.facts.features.image_arrays;
        gpu.require(has_arrays, "freely indexed arrays of images")?;
        let are_own = images.iter().all(|image| image.image.is_on(gpu));
        gpu.require(are_own, "binding an image of another device")?;
        let limits = &gpu.limits;
        let allowed = limits
            .max_per_stage_descriptor_sampled_images
            .min(limits.max_descriptor_set_sampled_images);
        let count = u32::try_from(images.len()).unwrap_or(u32::MAX);
        check_some("images of a freely indexed array", count, allowed)?;
        let layout = set_layout(gpu, std::iter::once((KIND, count)))?;
        let set = Set::unwritten(gpu, layout.raw, &vec![KIND; images.len()])?;
        for (element, image) in (0..).zip(&images) {
            // SAFETY: of the kind that the layout has; the images live as long as the set.
            unsafe { set.write(0, element, &Bound::readable(image.image.view)) };
        }
        Ok(Self {
            layout,
            set,
            images,
        })
    }

    pub(crate) fn layout(&self) -> vk::DescriptorSetLayout {
        self.layout.raw
    }

    pub(crate) fn count(&self) -> usize {
        self.images.len()
    }
}
