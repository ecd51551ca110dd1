// SPDX-License-Identifier: MIT OR Apache-2.0
//! An array of images as a set of its own, of which a shader chooses one by any number.

use crate::bindings::SetPool;
use crate::failure::failure;
use crate::{BlockImage, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

const KIND: vk::DescriptorType = vk::DescriptorType::SAMPLED_IMAGE;

#[derive(Debug)]
pub(crate) struct ImageArray {
    gpu: Arc<Gpu>,
    layout: vk::DescriptorSetLayout,
    pool: Option<SetPool>,
    /// The set points at them.
    images: Vec<Arc<BlockImage>>,
}

impl ImageArray {
    pub(crate) fn new(gpu: &Arc<Gpu>, images: Vec<Arc<BlockImage>>) -> Result<Self, DeviceError> {
        if !gpu.facts.features.image_arrays {
            let what = "freely indexed arrays of images";
            return Err(DeviceError::unsupported(what, &gpu.facts.name));
        }
        if !images.iter().all(|image| image.is_on(gpu)) {
            let what = "binding an image of another device";
            return Err(DeviceError::unsupported(what, &gpu.facts.name));
        }
        let limits = &gpu.limits;
        let allowed = limits
            .max_per_stage_descriptor_sampled_images
            .min(limits.max_descriptor_set_sampled_images);
        let count = u32::try_from(images.len()).unwrap_or(u32::MAX);
        if count > allowed || count == 0 {
            return Err(DeviceError::OverCapacity {
                what: "images of a freely indexed array".to_owned(),
                found: count.into(),
                allowed: allowed.into(),
            });
        }
        let mut made = Self {
            gpu: Arc::clone(gpu),
            layout: vk::DescriptorSetLayout::null(),
            pool: None,
            images,
        };
        let bindings = [vk::DescriptorSetLayoutBinding::default()
            .descriptor_type(KIND)
            .descriptor_count(count)
            .stage_flags(vk::ShaderStageFlags::ALL)];
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the structures live through the call.
        made.layout = unsafe { gpu.device.create_descriptor_set_layout(&info, None) }
            .map_err(|error| failure(error, "array of images", 0))?;
        let kinds = vec![KIND; made.images.len()];
        let pool = SetPool::new(gpu, made.layout, &kinds)?;
        let infos: Vec<_> = made
            .images
            .iter()
            .map(|image| vk::DescriptorImageInfo {
                sampler: vk::Sampler::null(),
                image_view: image.view(),
                image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            })
            .collect();
        let writes = [vk::WriteDescriptorSet::default()
            .dst_set(pool.set)
            .descriptor_type(KIND)
            .image_info(&infos)];
        // SAFETY: of the kind and number that the layout has; the images live as long as the set.
        unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
        made.pool = Some(pool);
        Ok(made)
    }

    pub(crate) fn layout(&self) -> vk::DescriptorSetLayout {
        self.layout
    }

    pub(crate) fn count(&self) -> usize {
        self.images.len()
    }

    pub(crate) fn set(&self) -> vk::DescriptorSet {
        let pool = self.pool.as_ref();
        pool.map_or(vk::DescriptorSet::null(), |pool| pool.set)
    }
}

impl Drop for ImageArray {
    fn drop(&mut self) {
        // SAFETY: every submission that used it has been waited for; null is ignored.
        unsafe {
            self.gpu
                .device
                .destroy_descriptor_set_layout(self.layout, None)
        };
    }
}
