// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a device was asked to make and to take: buffers, pipelines, writes of the CPU.
//!
//! A frame in a steady state asks for none of these. What only measuring needs, such as queries and
//! read-back, is not counted, nor are buffers that only carry bytes to or from the host.

use crate::Counters;
use std::ops::{Add, Sub};
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts since a device was opened, or over a span.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WorkDone {
    /// Buffers made.
    pub buffer_creations: u64,
    /// Bytes of the buffers and textures made.
    pub made_bytes: u64,
    /// Pipelines made.
    pub pipeline_creations: u64,
    /// Writes of the CPU into buffers.
    pub uploads: u64,
    /// Bytes written by them.
    pub upload_bytes: u64,
}

impl WorkDone {
    /// Writes into `counters` what a frame asked for: all since the one before, `prepared` before it
    /// was drawn and `drawing` while it was; bytes are those of drawing alone.
    pub fn write_into(counters: &mut Counters, prepared: Self, drawing: Self) {
        let all = prepared + drawing;
        counters.buffer_creations = all.buffer_creations;
        counters.pipeline_creations = all.pipeline_creations;
        counters.uploads = all.uploads;
        counters.upload_bytes = drawing.upload_bytes;
    }

    fn zip(self, other: Self, join: fn(u64, u64) -> u64) -> Self {
        Self {
            buffer_creations: join(self.buffer_creations, other.buffer_creations),
            made_bytes: join(self.made_bytes, other.made_bytes),
            pipeline_creations: join(self.pipeline_creations, other.pipeline_creations),
            uploads: join(self.uploads, other.uploads),
            upload_bytes: join(self.upload_bytes, other.upload_bytes),
        }
    }
}

impl Add for WorkDone {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.zip(other, u64::add)
    }
}

impl Sub for WorkDone {
    type Output = Self;

    fn sub(self, earlier: Self) -> Self {
        self.zip(earlier, u64::sub)
    }
}

/// The counters of a device behind [`WorkDone`].
#[derive(Debug, Default)]
pub struct WorkCounters {
    buffer_creations: AtomicU64,
    made_bytes: AtomicU64,
    pipeline_creations: AtomicU64,
    uploads: AtomicU64,
    upload_bytes: AtomicU64,
}

impl WorkCounters {
    /// What was counted so far: two readings around a frame tell what it asked for.
    #[must_use]
    pub fn done(&self) -> WorkDone {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        WorkDone {
            buffer_creations: read(&self.buffer_creations),
            made_bytes: read(&self.made_bytes),
            pipeline_creations: read(&self.pipeline_creations),
            uploads: read(&self.uploads),
            upload_bytes: read(&self.upload_bytes),
        }
    }

    /// Counts a buffer of so many bytes.
    pub fn count_buffer(&self, bytes: u64) {
        self.buffer_creations.fetch_add(1, Ordering::Relaxed);
        self.made_bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Counts a texture whose texels take so many bytes.
    pub fn count_texture(&self, bytes: u64) {
        self.made_bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Counts a pipeline.
    pub fn count_pipeline(&self) {
        self.pipeline_creations.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a write into a buffer; one of no bytes is none.
    pub fn count_upload(&self, bytes: u64) {
        if bytes > 0 {
            self.uploads.fetch_add(1, Ordering::Relaxed);
            self.upload_bytes.fetch_add(bytes, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(n: u64) -> WorkDone {
        WorkDone {
            buffer_creations: n,
            uploads: 2 * n,
            upload_bytes: 3 * n,
            pipeline_creations: 4 * n,
            made_bytes: 5 * n,
        }
    }

    #[test]
    fn what_was_done_between_two_readings_is_their_difference() {
        assert_eq!(reading(7) - reading(5), reading(2));
        assert_eq!(reading(7) + reading(5), reading(12));
        assert_ne!(reading(7) - reading(5), reading(3));
    }

    #[test]
    fn each_count_goes_to_its_own() {
        let counters = WorkCounters::default();
        counters.count_buffer(8);
        counters.count_buffer(4);
        counters.count_texture(100);
        counters.count_pipeline();
        counters.count_upload(0);
        counters.count_upload(12);
        let done = WorkDone {
            buffer_creations: 2,
            pipeline_creations: 1,
            uploads: 1,
            upload_bytes: 12,
            made_bytes: 112,
        };
        assert_eq!(counters.done(), done);
    }

    #[test]
    fn bytes_of_a_frame_are_those_of_drawing_it() {
        let mut counters = Counters::default();
        WorkDone::write_into(&mut counters, reading(2), reading(1));
        let expected = Counters {
            buffer_creations: 3,
            uploads: 6,
            pipeline_creations: 12,
            upload_bytes: 3,
            ..Counters::default()
        };
        assert_eq!(counters, expected);
        // Negative control: which is which matters.
        WorkDone::write_into(&mut counters, reading(1), reading(2));
        assert_ne!(counters, expected);
    }
}
