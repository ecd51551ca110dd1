// SPDX-License-Identifier: MIT OR Apache-2.0
//! The watch of a frame's steps, and which times are compared, by the clock that a device is read by.

use crate::metrics::{
    GLOBE_DRAW_CPU_MS, GLOBE_DRAW_GPU_MS, GLOBE_MAKE_CPU_MS, GLOBE_WHOLE_CPU_MS, GLOBE_WHOLE_GPU_MS,
};
use terrafill_contract::CpuStopwatch;
use terrafill_lab::{Column, Comparison};
use terrafill_results::{Clock, ConditionKey, Metric, Scope};
use terrafill_study::Figures;

/// Time of a whole frame, milliseconds.
pub fn whole(clock: Clock) -> &'static Metric {
    clock.pick(GLOBE_WHOLE_GPU_MS, GLOBE_WHOLE_CPU_MS)
}

/// Time of drawing it, milliseconds.
pub fn draw(clock: Clock) -> &'static Metric {
    clock.pick(GLOBE_DRAW_GPU_MS, GLOBE_DRAW_CPU_MS)
}

/// A column of whole frames.
pub const FRAME: Column = Column::clocked("frame, ms", GLOBE_WHOLE_GPU_MS, GLOBE_WHOLE_CPU_MS);

/// A column of making what they draw.
pub const MAKE: Column = Column::metric("make, CPU ms", GLOBE_MAKE_CPU_MS);

/// A column of their drawing.
pub const DRAW: Column = Column::clocked("draw, ms", GLOBE_DRAW_GPU_MS, GLOBE_DRAW_CPU_MS);

/// Two cases that differ in one condition, by a time that covers what is asked.
pub const fn compared_in(
    changed: ConditionKey,
    metric: &'static Metric,
    needs: Scope,
) -> Comparison<'static> {
    Comparison {
        changed: changed.name(),
        follows: &[],
        one_sided: None,
        metric,
        needs,
    }
}

/// Times the steps of a frame, one after the other.
pub struct FrameWatch {
    watch: CpuStopwatch,
    steps: Figures,
    /// CPU time at the end of the last step.
    ended_ms: f64,
}

impl FrameWatch {
    /// Starts with the first step.
    #[must_use]
    pub fn start() -> Self {
        Self {
            watch: CpuStopwatch::start(),
            steps: Vec::new(),
            ended_ms: 0.0,
        }
    }

    /// Ends a step that is not drawing; its process CPU time is the figure of this metric.
    pub fn ends(&mut self, metric: &'static str) {
        let now_ms = self.watch.cpu_ms();
        self.steps.push((metric, now_ms - self.ended_ms));
        self.ended_ms = now_ms;
    }

    /// Ends drawing and with it the frame; gives the figures of all steps.
    ///
    /// - `gpu_ms`: the GPU's time of drawing, where it has a clock
    pub fn drawn(self, gpu_ms: Option<f64>) -> Figures {
        let (cpu_ms, wall_ms) = (self.watch.cpu_ms(), self.watch.wall_ms());
        let mut values = vec![
            ("globe_whole_cpu_ms", cpu_ms),
            ("globe_whole_wall_ms", wall_ms),
        ];
        values.extend(self.steps);
        values.push(("globe_draw_cpu_ms", cpu_ms - self.ended_ms));
        if let Some(gpu_ms) = gpu_ms {
            values.push(("globe_draw_gpu_ms", gpu_ms));
            values.push(("globe_whole_gpu_ms", self.ended_ms + gpu_ms));
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_add_up_to_the_whole() {
        let mut watch = FrameWatch::start();
        let work: f64 = (0..100_000_u32).map(|i| f64::from(i).sqrt()).sum();
        watch.ends("globe_make_cpu_ms");
        watch.ends("globe_upload_cpu_ms");
        let values = watch.drawn(Some(2.0));
        let of = |name: &str| {
            let mut values = values.iter();
            let found = values.find(|(known, _)| *known == name);
            found.map_or(f64::NAN, |(_, value)| *value)
        };
        let [make, upload, draw] = [
            "globe_make_cpu_ms",
            "globe_upload_cpu_ms",
            "globe_draw_cpu_ms",
        ]
        .map(of);
        assert!(work > 0.0 && (make + upload + draw - of("globe_whole_cpu_ms")).abs() < 1e-9);
        assert!((of("globe_whole_gpu_ms") - 2.0 - make - upload).abs() < 1e-9);
        // Negative control: without the GPU's clock nothing is of it.
        let none = FrameWatch::start().drawn(None);
        assert!(none.iter().all(|(name, _)| !name.contains("gpu")));
    }
}
