// SPDX-License-Identifier: MIT OR Apache-2.0
//! A zone of a height field whose level of detail follows its counted pixels.
//!
//! A level has four times the triangles of the one below it: every second row and column is dropped (geomipmaps). A
//! zone becomes finer where it has more pixels a triangle than the upper threshold, and coarser where it has fewer than
//! the lower one. Where a finer level shows a spike that hides all but 1/m of the zone's own pixels, it has fewer pixels
//! the finer it is, which no loop expects. (Gebbie and Bailey saw such oscillations "bypass even large buffer
//! thresholds".)

/// When a zone changes its level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ZoneRule {
    /// Triangles of level 0, the coarsest.
    triangles: f64,
    /// The finest level.
    finest: u32,
    /// Pixels a triangle: fewer make it coarser, more make it finer.
    low: f64,
    high: f64,
}

impl ZoneRule {
    /// - `triangles`: of level 0
    /// - `wanted`: pixels a triangle
    /// - `hysteresis`: the upper threshold over the lower one, which is `wanted / √hysteresis`
    pub(crate) fn new(triangles: f64, finest: u32, wanted: f64, hysteresis: f64) -> Self {
        Self {
            triangles,
            finest,
            low: wanted / hysteresis.sqrt(),
            high: wanted * hysteresis.sqrt(),
        }
    }

    /// Triangles of a level.
    pub(crate) fn triangles(&self, level: u32) -> f64 {
        self.triangles * 4_f64.powi(i32::try_from(level).unwrap_or(i32::MAX))
    }

    /// The level after one that was drawn with so many pixels.
    pub(crate) fn next(&self, level: u32, pixels: f64) -> u32 {
        let each = pixels / self.triangles(level);
        match level {
            level if each > self.high && level < self.finest => level + 1,
            level if each < self.low && level > 0 => level - 1,
            level => level,
        }
    }
}
