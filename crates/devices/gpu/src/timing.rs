// SPDX-License-Identifier: MIT OR Apache-2.0
//! GPU timestamps around passes.
//!
//! A pair of stamps that is zero, or runs backwards, was not measured: drivers produce such values
//! (wgpu #6406, #9414), and a difference of them is no time.

use crate::Gpu;
use crate::queries::Queries;
use terrafill_contract::DeviceError;

/// Stamps of up to `PASSES` passes a frame.
#[derive(Debug)]
pub struct PassTimer {
    queries: Queries,
    period_ns: f64,
}

/// Slot of a pass's pair of stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimedPass {
    /// Surface.
    Surface,
    /// Stencil.
    Stencil,
    /// Colour, or stencil and colour in one pass.
    Colour,
    /// A full-screen baseline.
    Baseline,
}

const PASSES: u32 = 4;

impl TimedPass {
    fn first_query(self) -> u32 {
        2 * match self {
            Self::Surface => 0,
            Self::Stencil => 1,
            Self::Colour => 2,
            Self::Baseline => 3,
        }
    }
}

/// Stamps read back.
#[derive(Debug, Clone, Copy)]
pub struct Stamps {
    ticks: [u64; 2 * PASSES as usize],
    period_ns: f64,
}

impl Stamps {
    /// Duration of one pass, milliseconds.
    #[must_use]
    pub fn pass_ms(&self, pass: TimedPass) -> Option<f64> {
        self.span_ms(pass, pass)
    }

    /// From the start of one pass to the end of another, milliseconds.
    #[must_use]
    pub fn span_ms(&self, first: TimedPass, last: TimedPass) -> Option<f64> {
        let begin = self.ticks[first.first_query() as usize];
        let end = self.ticks[last.first_query() as usize + 1];
        let valid = begin != 0 && end >= begin;
        valid.then(|| (end - begin) as f64 * self.period_ns * 1e-6)
    }
}

impl PassTimer {
    /// A timer, or `None` where the device has no timestamps.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.facts.features.timestamps {
            return None;
        }
        let ty = wgpu::QueryType::Timestamp;
        let queries = Queries::new(gpu, "pass timestamps", ty, 2 * PASSES, 1);
        Some(Self {
            queries,
            period_ns: f64::from(gpu.timestamp_period_ns),
        })
    }

    /// Begins the slot `pass` before the next command of `encoder`.
    ///
    /// Copies and clears cannot be stamped, so an empty compute pass is.
    pub fn begin(&self, encoder: &mut wgpu::CommandEncoder, pass: TimedPass) {
        drop(encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("begin of a frame"),
            timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                query_set: &self.queries.set,
                beginning_of_pass_write_index: Some(pass.first_query()),
                end_of_pass_write_index: None,
            }),
        }));
    }

    /// Stamps at both ends of a pass.
    #[must_use]
    pub fn around(&self, pass: TimedPass) -> wgpu::RenderPassTimestampWrites<'_> {
        self.writes(Some(pass), Some(pass))
    }

    /// Stamps at the start of a pass, under the slot `begin`, and at its end, under `end`.
    #[must_use]
    pub fn writes(
        &self,
        begin: Option<TimedPass>,
        end: Option<TimedPass>,
    ) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries.set,
            beginning_of_pass_write_index: begin.map(TimedPass::first_query),
            end_of_pass_write_index: end.map(|pass| pass.first_query() + 1),
        }
    }

    /// As [`PassTimer::around`], of a pass of compute.
    #[must_use]
    pub fn around_compute(&self, pass: TimedPass) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries.set,
            beginning_of_pass_write_index: Some(pass.first_query()),
            end_of_pass_write_index: Some(pass.first_query() + 1),
        }
    }

    /// Duration of one pass, which has been drawn, milliseconds.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn pass_ms(&self, gpu: &Gpu, pass: TimedPass) -> Result<Option<f64>, DeviceError> {
        Ok(self.read(gpu, pass, pass)?.pass_ms(pass))
    }

    /// Reads the stamps of the passes in `first..=last`, which must all have been drawn; other
    /// slots read as 0, hence as not measured.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn read(
        &self,
        gpu: &Gpu,
        first: TimedPass,
        last: TimedPass,
    ) -> Result<Stamps, DeviceError> {
        let range = first.first_query()..last.first_query() + 2;
        let mut ticks = [0; 2 * PASSES as usize];
        let values = self.queries.read(gpu, range.clone())?;
        ticks[range.start as usize..range.end as usize].copy_from_slice(&values);
        Ok(Stamps {
            ticks,
            period_ns: self.period_ns,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_and_backward_stamps_are_not_measured() {
        let stamps = Stamps {
            ticks: [10, 2_000_010, 0, 5, 9, 8, 7, 7],
            period_ns: 1.0,
        };
        assert_eq!(stamps.pass_ms(TimedPass::Surface), Some(2.0));
        assert_eq!(stamps.pass_ms(TimedPass::Stencil), None);
        assert_eq!(stamps.pass_ms(TimedPass::Colour), None);
        assert_eq!(stamps.pass_ms(TimedPass::Baseline), Some(0.0));
    }
}
