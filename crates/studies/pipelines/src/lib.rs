// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `pipelines`: experiments of 2007 with the pipeline of shader model 4, beside what does the same
//! work today.
//!
//! Height grids are drawn by every way in which vertices may come, and points are amplified to cells by
//! geometry shaders. Ground in tiles is culled patch by patch in every place that can, blocks of it are kept
//! in all that can keep them, and depth maps of several lights are drawn by every way to layers. Pictures
//! show numbers of triangles or of lights, which `f64` rays verify. Variance shadows and motion blur are drawn into
//! layers too: shadows are held against definitions on the CPU, blur against rays. What formulas alone say of them is in
//! `docs/pipeline-numbers.md`. Set-ups and figures published: Patidar, Bhattacharjee, Singh and Narayanan,
//! "Exploiting the Shader Model 4.0 Architecture" (2007).

mod blur;
mod cache;
mod chapter;
mod culling;
mod draws;
mod images;
mod layered;
mod lights;
mod meshes;
mod metrics;
#[cfg(test)]
mod numbers;
mod on_vulkan;
mod on_wgpu;
mod study;
#[cfg(test)]
mod tested;
mod variance;
mod way;

pub use study::PipelinesStudy;

/// Name of the study.
pub const STUDY: &str = "pipelines";
