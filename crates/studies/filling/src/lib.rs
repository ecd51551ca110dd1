// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs cases and writes raw rows.
//!
//! For each scene and view: the reference judges once; every case draws a probe frame that is
//! compared with it; then all cases and the two baselines are timed in rounds, so that whatever
//! else the machine does falls on all of them alike. Every sample is kept and flushed.
//!
//! Four things are asked beside: the *ladder*, from the un-optimised method to the full plan one
//! switch at a time; the *matrix*, every backend, layout and switch on the same view, drawn once; the
//! bytes of every layout, by formula and as allocated; and the *textured fill* of scenes with a picture,
//! held against their plain one.

mod cases;
mod chapter;
mod environment;
mod fingerprint;
mod group;
mod images;
mod memory;
mod options;
mod rounding;
mod runner;
mod scenes;
mod subject;
mod summary;
mod textured;

pub use cases::{BenchCase, Roles, SceneGroup, group_cases};
pub use chapter::FillingChapter;
pub use environment::environment;
pub use options::{BenchError, BenchOptions, LADDER_SCENE, MATRIX_SCENES, NO_SCENE, Shard};
pub use runner::{BenchOutcome, run};
pub use scenes::open_scene;
pub use subject::{Subject, Techniques};
pub use textured::{PICTURE_SCENES, ShownPicture};

#[cfg(test)]
mod tests {
    use terrafill_compute::ComputeTechnique;
    use terrafill_native::NativeTechnique;
    use terrafill_vertex::VertexTechnique;

    /// As the command line hands them over.
    pub(crate) const TECHNIQUES: crate::Techniques =
        &[&VertexTechnique, &ComputeTechnique, &NativeTechnique];
}
