// SPDX-License-Identifier: MIT OR Apache-2.0
//! A grid on the screen, projected to the body (A. Jeromel, StuCoSReC 2018, pp. 39–42): for each view the
//! screen is divided into N × N cells, a ray through each corner meets the bare ellipsoid, and two triangles a
//! cell are drawn. They hang far below the body at the limb, and cover what the view shows and no more.

mod facet;
mod mesh;
mod rays;
mod surface;

pub use mesh::{GridOptions, Limb, ScreenMesh};
pub use rays::Rays;
pub use surface::ScreenGridKind;
