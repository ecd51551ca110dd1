// SPDX-License-Identifier: MIT OR Apache-2.0
//! Buffers, each with memory of its own as images have theirs: a scene has a handful of them, and what
//! each takes can be read off.

use crate::Gpu;
use crate::failure::failure;
use crate::owned::Owned;
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use terrafill_contract::DeviceError;
use terrafill_stencil::changed_words;

/// What a buffer is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BufferUse {
    /// Vertices.
    Vertex,
    /// Indices.
    Index,
    /// A uniform block.
    Uniform,
    /// Uniform blocks one after the other, of which each draw reads one.
    Constants,
    /// An array that shaders read.
    Storage,
    /// Arguments of draws, which shaders may write and the host may read back.
    Arguments,
    /// What steps write, by a shader or by transform feedback, and the host may read back.
    State,
}

impl BufferUse {
    fn flags(self) -> vk::BufferUsageFlags {
        match self {
            Self::Vertex => vk::BufferUsageFlags::VERTEX_BUFFER,
            Self::Index => vk::BufferUsageFlags::INDEX_BUFFER,
            Self::Uniform | Self::Constants => vk::BufferUsageFlags::UNIFORM_BUFFER,
            Self::Storage => vk::BufferUsageFlags::STORAGE_BUFFER,
            Self::State => {
                vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC
            }
            Self::Arguments => {
                vk::BufferUsageFlags::STORAGE_BUFFER
                    | vk::BufferUsageFlags::INDIRECT_BUFFER
                    | vk::BufferUsageFlags::TRANSFER_SRC
            }
        }
    }
}

/// A buffer in device memory.
#[derive(Debug)]
pub struct Buffer {
    gpu: Arc<Gpu>,
    pub(crate) raw: vk::Buffer,
    /// What `raw` is, which goes before its memory.
    _owned: Owned<vk::Buffer>,
    memory: Memory,
    size: u64,
    use_for: Option<BufferUse>,
    /// In memory that the host sees, and free to be written between submissions.
    is_streamed: bool,
}

/// One allocation.
#[derive(Debug)]
pub(crate) struct Memory {
    pub(crate) owned: Owned<vk::DeviceMemory>,
    bytes: u64,
}

impl Memory {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        label: &str,
        needs: vk::MemoryRequirements,
        wanted: &[vk::MemoryPropertyFlags],
        has_address: bool,
    ) -> Result<Self, DeviceError> {
        let fits = |flags: vk::MemoryPropertyFlags| {
            let types = gpu.memory.memory_types_as_slice();
            (0_u32..)
                .zip(types)
                .find(|(index, kind)| {
                    needs.memory_type_bits >> index & 1 == 1 && kind.property_flags.contains(flags)
                })
                .map(|(index, _)| index)
        };
        let out_of_memory = || DeviceError::OutOfMemory {
            what: label.to_owned(),
            bytes: needs.size,
        };
        let kind = wanted.iter().find_map(|&flags| fits(flags));
        let mut flags =
            vk::MemoryAllocateFlagsInfo::default().flags(vk::MemoryAllocateFlags::DEVICE_ADDRESS);
        let mut info = vk::MemoryAllocateInfo::default()
            .allocation_size(needs.size)
            .memory_type_index(kind.ok_or_else(out_of_memory)?);
        if has_address {
            info = info.push_next(&mut flags);
        }
        // SAFETY: size and type are what the driver asked for; what lies in it holds it.
        let owned = unsafe {
            let made = gpu.device.allocate_memory(&info, None);
            Owned::sized(gpu, label, needs.size, made)
        }?;
        let counted = &gpu.allocated_bytes;
        counted.fetch_add(needs.size, Ordering::Relaxed);
        Ok(Self {
            owned,
            bytes: needs.size,
        })
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        let counted = &self.owned.gpu().allocated_bytes;
        counted.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

pub(crate) const DEVICE: &[vk::MemoryPropertyFlags] = &[
    vk::MemoryPropertyFlags::DEVICE_LOCAL,
    vk::MemoryPropertyFlags::empty(),
];

/// Coherent, so that mapping needs no flushes; cached where there is a choice, since read-back
/// from uncached memory takes many times as long.
const HOST: &[vk::MemoryPropertyFlags] = &[
    vk::MemoryPropertyFlags::from_raw(
        vk::MemoryPropertyFlags::HOST_VISIBLE.as_raw()
            | vk::MemoryPropertyFlags::HOST_COHERENT.as_raw()
            | vk::MemoryPropertyFlags::HOST_CACHED.as_raw(),
    ),
    vk::MemoryPropertyFlags::from_raw(
        vk::MemoryPropertyFlags::HOST_VISIBLE.as_raw()
            | vk::MemoryPropertyFlags::HOST_COHERENT.as_raw(),
    ),
];

/// Most bytes that a command may carry.
const CHUNK: usize = 65_536;

/// Stages, and how they touch memory.
type Touch = (vk::PipelineStageFlags, vk::AccessFlags);

/// What `later` does to any memory waits for what `earlier` did before.
///
/// # Safety
/// Recording is under way, outside of a pass.
pub(crate) unsafe fn barrier(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    earlier: Touch,
    later: Touch,
) {
    let memory = [vk::MemoryBarrier::default()
        .src_access_mask(earlier.1)
        .dst_access_mask(later.1)];
    let none = vk::DependencyFlags::empty();
    // SAFETY: the caller's promise.
    unsafe { device.cmd_pipeline_barrier(commands, earlier.0, later.0, none, &memory, &[], &[]) };
}

/// Whatever follows reads what was copied into buffers before.
///
/// # Safety
/// Recording is under way, outside of a pass.
unsafe fn let_be_read(device: &ash::Device, commands: vk::CommandBuffer) {
    let copies = (
        vk::PipelineStageFlags::TRANSFER,
        vk::AccessFlags::TRANSFER_WRITE,
    );
    let reads = (
        vk::PipelineStageFlags::ALL_COMMANDS,
        vk::AccessFlags::MEMORY_READ,
    );
    // SAFETY: the caller's promise.
    unsafe { barrier(device, commands, copies, reads) };
}

impl Buffer {
    /// A buffer in device memory with these contents, of exactly that size; 4 bytes when there are
    /// none, since a buffer of 0 bytes is not allowed.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the device cannot bind one that large,
    /// [`DeviceError::OutOfMemory`].
    pub fn upload(
        gpu: &Arc<Gpu>,
        label: &str,
        bytes: &[u8],
        use_for: BufferUse,
    ) -> Result<Self, DeviceError> {
        let size = bytes.len().max(4) as u64;
        let buffer = Self::unwritten(gpu, label, size, use_for)?;
        if !bytes.is_empty() {
            let staging = Self::staging(gpu, label, bytes)?;
            gpu.work.count_upload(bytes.len() as u64);
            let region = [vk::BufferCopy::default().size(size)];
            // SAFETY: both buffers have this size and live until the submission is done. Fewer than 4
            // bytes leave the rest of the staging buffer as the driver made it, which nothing reads.
            unsafe {
                gpu.submit(|device, commands| {
                    device.cmd_copy_buffer(commands, staging.raw, buffer.raw, &region);
                    let_be_read(device, commands);
                })?;
            }
        }
        Ok(buffer)
    }

    /// A buffer in device memory for shaders to write.
    ///
    /// - `size`: in bytes, at least 1
    ///
    /// # Errors
    /// As [`Buffer::upload`].
    pub fn unwritten(
        gpu: &Arc<Gpu>,
        label: &str,
        size: u64,
        use_for: BufferUse,
    ) -> Result<Self, DeviceError> {
        Self::used(gpu, label, size, use_for, DEVICE)
    }

    /// A buffer that the CPU writes for each frame and the device reads where it lies.
    ///
    /// - `size`: in bytes, at least 1
    ///
    /// # Errors
    /// As [`Buffer::upload`].
    pub fn streamed(
        gpu: &Arc<Gpu>,
        label: &str,
        size: u64,
        use_for: BufferUse,
    ) -> Result<Self, DeviceError> {
        let mut buffer = Self::used(gpu, label, size, use_for, HOST)?;
        buffer.is_streamed = true;
        Ok(buffer)
    }

    /// Writes the start of a buffer of [`Buffer::streamed`].
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when there are more bytes than the buffer has,
    /// [`DeviceError::Unsupported`] when the buffer is no such one, [`DeviceError::OutOfMemory`].
    pub fn stream(&self, bytes: &[u8]) -> Result<(), DeviceError> {
        let what = "mapping a buffer in device memory";
        self.gpu.require(self.is_streamed, what)?;
        let found = bytes.len() as u64;
        let what = "bytes written into a streamed buffer";
        DeviceError::check_capacity(what, found, self.size)?;
        self.gpu.work.count_upload(found);
        self.write(bytes)
    }

    fn used(
        gpu: &Arc<Gpu>,
        label: &str,
        size: u64,
        use_for: BufferUse,
        wanted: &[vk::MemoryPropertyFlags],
    ) -> Result<Self, DeviceError> {
        let allowed: u64 = match use_for {
            BufferUse::Uniform => u64::from(gpu.limits.max_uniform_buffer_range),
            BufferUse::Storage | BufferUse::Arguments | BufferUse::State => {
                u64::from(gpu.limits.max_storage_buffer_range)
            }
            // What is bound of constants at a time is checked when it is.
            BufferUse::Vertex | BufferUse::Index | BufferUse::Constants => u64::MAX,
        };
        DeviceError::check_capacity(&format!("bytes of {label}"), size, allowed)?;
        let mut usage = use_for.flags() | vk::BufferUsageFlags::TRANSFER_DST;
        if use_for == BufferUse::State && gpu.feedback.is_some() {
            usage |= vk::BufferUsageFlags::TRANSFORM_FEEDBACK_BUFFER_EXT;
        }
        let mut buffer = Self::new(gpu, label, size, usage, wanted)?;
        buffer.use_for = Some(use_for);
        gpu.work.count_buffer(size);
        Ok(buffer)
    }

    /// Writes what the buffer has to hold over what it holds, where that differs.
    ///
    /// - `before`: what it holds from its first byte on
    ///
    /// # Errors
    /// As [`Buffer::rewrite`].
    pub fn rewrite_changed(&self, before: &[u8], after: &[u8]) -> Result<(), DeviceError> {
        changed_words(before, after).map_or(Ok(()), |changed| {
            self.rewrite(changed.start as u64, &after[changed])
        })
    }

    /// Overwrites whole words of a buffer that was uploaded; meant for constants.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the bytes do not fit or are no whole words,
    /// [`DeviceError::DeviceLost`].
    pub fn rewrite(&self, first_byte: u64, bytes: &[u8]) -> Result<(), DeviceError> {
        let found = first_byte.saturating_add(bytes.len() as u64);
        let is_whole = first_byte.is_multiple_of(4) && found.is_multiple_of(4);
        if found > self.size || !is_whole || self.use_for.is_none() {
            return Err(DeviceError::OverCapacity {
                what: "bytes written into a buffer, in whole words".to_owned(),
                found,
                allowed: self.size,
            });
        }
        // SAFETY: the chunks lie inside the buffer, which was made to be written to; they are whole
        // words of at most 65,536 bytes, the most that a command may carry.
        unsafe {
            self.gpu.submit(|device, commands| {
                for (offset, chunk) in (first_byte..).step_by(CHUNK).zip(bytes.chunks(CHUNK)) {
                    device.cmd_update_buffer(commands, self.raw, offset, chunk);
                }
                let_be_read(device, commands);
            })?;
        }
        self.gpu.work.count_upload(bytes.len() as u64);
        Ok(())
    }

    /// Overwrites parts of a buffer that was uploaded, at any bytes: copies need no alignment. One
    /// submission takes them all, since each of its own costs as much as a frame's worth of copies.
    ///
    /// - `parts`: the first byte of each, and its bytes
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when a part does not fit, [`DeviceError::OutOfMemory`],
    /// [`DeviceError::DeviceLost`].
    pub fn rewrite_parts(&self, parts: &[(u64, &[u8])]) -> Result<(), DeviceError> {
        let mut staged: Vec<u8> = Vec::new();
        let mut regions = Vec::with_capacity(parts.len());
        for &(first_byte, bytes) in parts.iter().filter(|(_, bytes)| !bytes.is_empty()) {
            let size = bytes.len() as u64;
            let found = first_byte.saturating_add(size);
            if found > self.size || self.use_for.is_none() {
                return Err(DeviceError::OverCapacity {
                    what: "bytes written into a part of a buffer".to_owned(),
                    found,
                    allowed: self.size,
                });
            }
            let region = vk::BufferCopy::default().src_offset(staged.len() as u64);
            regions.push(region.dst_offset(first_byte).size(size));
            staged.extend_from_slice(bytes);
        }
        if regions.is_empty() {
            return Ok(());
        }
        let staging = Self::staging(&self.gpu, "rewritten parts", &staged)?;
        // SAFETY: the parts lie inside the buffer, which was made to be copied into, and in the staging
        // buffer, which holds all of them; both live until the submission is done.
        unsafe {
            self.gpu.submit(|device, commands| {
                device.cmd_copy_buffer(commands, staging.raw, self.raw, &regions);
                let_be_read(device, commands);
            })?;
        }
        self.gpu.work.count_upload(staged.len() as u64);
        Ok(())
    }

    /// A buffer that carries bytes to images.
    pub(crate) fn staging(gpu: &Arc<Gpu>, label: &str, bytes: &[u8]) -> Result<Self, DeviceError> {
        let size = bytes.len().max(4) as u64;
        let staging = Self::new(gpu, label, size, vk::BufferUsageFlags::TRANSFER_SRC, HOST)?;
        staging.write(bytes)?;
        Ok(staging)
    }

    /// A buffer that the device writes and the host reads.
    pub(crate) fn for_reading(gpu: &Arc<Gpu>, label: &str, size: u64) -> Result<Self, DeviceError> {
        Self::new(gpu, label, size, vk::BufferUsageFlags::TRANSFER_DST, HOST)
    }

    /// A buffer that device code finds by its address; the device must have such addresses.
    ///
    /// - `bytes`: what it holds, where the host has something to say; such a buffer lies in host memory
    pub(crate) fn addressed(
        gpu: &Arc<Gpu>,
        label: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        bytes: Option<&[u8]>,
    ) -> Result<Self, DeviceError> {
        let usage = usage | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let wanted = if bytes.is_some() { HOST } else { DEVICE };
        let buffer = Self::new(gpu, label, size, usage, wanted)?;
        if let Some(bytes) = bytes {
            buffer.write(bytes)?;
        }
        gpu.work.count_buffer(size);
        Ok(buffer)
    }

    /// Address of a buffer of [`Buffer::addressed`].
    pub(crate) fn address(&self) -> vk::DeviceAddress {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.raw);
        // SAFETY: the buffer was made to have one, as only a device that has the feature makes them.
        unsafe { self.gpu.device.get_buffer_device_address(&info) }
    }

    fn new(
        gpu: &Arc<Gpu>,
        label: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        wanted: &[vk::MemoryPropertyFlags],
    ) -> Result<Self, DeviceError> {
        let info = vk::BufferCreateInfo::default()
            .size(size)
            .usage(usage)
            .sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the size is not 0; every submission that uses the buffer is waited for.
        let owned = unsafe {
            let made = gpu.device.create_buffer(&info, None);
            Owned::sized(gpu, label, size, made)
        }?;
        let raw = owned.raw;
        // SAFETY: the buffer is the device's.
        let needs = unsafe { gpu.device.get_buffer_memory_requirements(raw) };
        let has_address = usage.contains(vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS);
        let memory = Memory::new(gpu, label, needs, wanted, has_address)?;
        // SAFETY: fresh memory of the type and size that the buffer asked for.
        unsafe { gpu.device.bind_buffer_memory(raw, memory.owned.raw, 0) }
            .map_err(|error| failure(error, label, size))?;
        Ok(Self {
            gpu: Arc::clone(gpu),
            raw,
            _owned: owned,
            memory,
            size,
            use_for: None,
            is_streamed: false,
        })
    }

    /// Bytes as asked for.
    #[must_use]
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Bytes that the driver took for it.
    #[must_use]
    pub fn allocated_bytes(&self) -> u64 {
        self.memory.bytes
    }

    /// Whether it is this device's and made for a use.
    pub(crate) fn is_for(&self, gpu: &Arc<Gpu>, use_for: BufferUse) -> bool {
        self.is_on(gpu) && self.use_for == Some(use_for)
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }

    /// Copies `bytes` to the start of a buffer in host memory.
    fn write(&self, bytes: &[u8]) -> Result<(), DeviceError> {
        self.mapped(|start| {
            // SAFETY: `start` is the first of at least `bytes.len()` mapped bytes that nobody else
            // looks at.
            unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), start, bytes.len()) };
        })
    }

    /// Contents of a buffer in host memory.
    pub(crate) fn read(&self) -> Result<Vec<u8>, DeviceError> {
        let len = usize::try_from(self.size).unwrap_or(usize::MAX);
        self.mapped(|start| {
            // SAFETY: `start` is the first of `size` mapped bytes; the device has written what it
            // was asked to and been waited for, and memory is never uninitialised to the host.
            unsafe { std::slice::from_raw_parts(start, len) }.to_vec()
        })
    }

    fn mapped<T>(&self, use_it: impl FnOnce(*mut u8) -> T) -> Result<T, DeviceError> {
        let (device, memory) = (&self.gpu.device, self.memory.owned.raw);
        // SAFETY: the memory is host-visible, coherent and not mapped: this crate maps only here,
        // and unmaps before it returns.
        let start = unsafe { device.map_memory(memory, 0, self.size, vk::MemoryMapFlags::empty()) }
            .map_err(|error| failure(error, "mapping", self.size))?;
        let result = use_it(start.cast());
        // SAFETY: mapped above.
        unsafe { device.unmap_memory(memory) };
        Ok(result)
    }
}

/// Refuses none of `what`, and more than is allowed.
pub(crate) fn check_some(what: &str, found: u32, allowed: u32) -> Result<(), DeviceError> {
    if (1..=allowed).contains(&found) {
        return Ok(());
    }
    Err(DeviceError::OverCapacity {
        what: what.to_owned(),
        found: found.into(),
        allowed: allowed.into(),
    })
}
