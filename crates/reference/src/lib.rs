// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact f64 CPU renderer and classifier: the only judge of error.
