// SPDX-License-Identifier: MIT OR Apache-2.0
//! What can be named: a line for each.

use terrafill_surface::{EllipsoidKind, SurfaceKind};

/// Surfaces that scenes can name.
pub(crate) static SURFACES: &[&dyn SurfaceKind] = &[&EllipsoidKind, &terrafill_grid::GridKind];
