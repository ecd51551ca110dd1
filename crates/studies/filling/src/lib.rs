// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `filling`: which technique fills regions with which error, time and memory.
//!
//! For each scene and view the reference is drawn once. Every case draws a probe frame that is compared
//! with it. Then all cases and the two full-screen passes are timed in blocks, so that whatever else
//! the machine does falls on all of them alike.
//!
//! Beside the main variants stand the *ablation*, from the un-optimised method to the full plan one
//! switch at a time; the *matrix*, every technique, layout and switch on the same view, drawn once; the
//! bytes of every layout, by formula and as allocated; *sweeps* through the boundary tolerance and the
//! cap step; and the *textured fill* of scenes with a picture.

mod cases;
mod chapter;
mod claims;
mod driver_fault;
mod images;
mod keys;
mod memory;
mod metrics;
mod probe;
mod purpose;
mod request;
mod rounding;
mod scenes;
mod session;
mod study;
mod subject;
mod suite;
mod textured;

pub use chapter::{FillingChapter, answer_text};
pub use request::STUDY;
pub use session::PictureCheck;
pub use study::FillingStudy;
pub use subject::{Surfaces, Techniques};
pub use suite::{EXTREME, ExtremeChapter, ExtremeStudy, IN_HAND, extreme_sentence};

#[cfg(test)]
mod tests {
    use terrafill_compute::ComputeTechnique;
    use terrafill_contract::Technique;
    use terrafill_native::NativeTechnique;
    use terrafill_vertex::VertexTechnique;

    /// Those of the program, so that the study's own tests need no registry.
    pub(crate) static TECHNIQUES: &[&dyn Technique] =
        &[&VertexTechnique, &ComputeTechnique, &NativeTechnique];
}
