// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases.

terrafill_results::conditions! {
    shared SCENE, TECHNIQUE, VARIANT;
    PIECES = "pieces";
}

/// Note with the path of a case's picture.
pub(crate) const IMAGE: &str = "image";
