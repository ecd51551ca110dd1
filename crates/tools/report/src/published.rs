// SPDX-License-Identifier: MIT OR Apache-2.0
//! Published figures of the best-known web globe, to lay ours beside.
//!
//! Natural Earth countries on CesiumJS's globe at the three cameras that the scenes of the same
//! names use. `volumes` is its `GroundPrimitive` (stencil volumes, one per polygon), `lookup` its
//! newer world-cell path, which looks a pixel's edges up in a grid instead of using the stencil.

/// Where all figures of this module come from, in the words printed under the table.
pub(crate) const SOURCE: &str = "CesiumJS 1.145, llvmpipe, 1024², same kind of machine; \
    process CPU ms of shown minus hidden";

/// Image side of those measurements, pixels.
pub(crate) const IMAGE_SIDE_PX: u32 = 1024;

/// The software driver of those measurements; ratios across drivers would say nothing.
pub(crate) const DRIVER: &str = "llvmpipe";

/// The views that were measured, in the order of [`Published::fill_cpu_ms`].
pub(crate) const VIEWS: [&str; 3] = ["globe", "fill", "horizon"];

/// One technique on one scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Published {
    /// Scene of the same regions here.
    pub(crate) scene: &'static str,
    /// Technique.
    pub(crate) method: &'static str,
    /// Cost of the fill per frame for each of [`VIEWS`], CPU time of the process, milliseconds.
    pub(crate) fill_cpu_ms: [f64; 3],
    /// Bytes on the GPU.
    pub(crate) bytes: u64,
}

/// Every published row.
pub(crate) const PUBLISHED: [Published; 4] = [
    Published {
        scene: "countries-110m",
        method: "volumes",
        fill_cpu_ms: [361.0, 66.0, 119.0],
        bytes: 13_900_000,
    },
    Published {
        scene: "countries-110m",
        method: "lookup",
        fill_cpu_ms: [120.0, 47.0, 53.0],
        bytes: 510_000,
    },
    Published {
        scene: "countries-50m",
        method: "volumes",
        fill_cpu_ms: [743.0, 73.0, 178.0],
        bytes: 59_800_000,
    },
    Published {
        scene: "countries-50m",
        method: "lookup",
        fill_cpu_ms: [133.0, 50.0, 61.0],
        bytes: 3_340_000,
    },
];

/// The published rows for `scene`.
pub(crate) fn of_scene(scene: &str) -> Vec<Published> {
    PUBLISHED
        .into_iter()
        .filter(|row| row.scene == scene)
        .collect()
}
