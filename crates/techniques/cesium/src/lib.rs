// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a user would pick instead: CesiumJS (Apache-2.0) in headless Chromium, as a technique.
//!
//! Its two ways to fill polygons on terrain are layouts: `volumes`, a `GroundPrimitive` for each polygon
//! (stencil shadow volumes), and `lookup`, one `BufferPolygonCollection` clamped to terrain (edges in a
//! grid for each tile, which the globe's fragment shader looks up). The scene's regions and the view's
//! camera go to a page by way of node, region ids come back as colours, and time is CPU time of all the
//! browser's processes: a frame with the regions shown less one with them hidden.
//!
//! The surface is CesiumJS's own globe, a quadtree of tiles on the ellipsoid. So the reference meets rays with
//! the ellipsoid itself: near the eye its tiles lie closer to that than the scene's grid does. Edges of
//! `volumes` are arcs in the plane through the centre, those of `lookup` straight in longitude and latitude;
//! the reference takes them for the same.
//!
//! Nothing of CesiumJS is here: `ci/peers.sh` fetches it, and [`FOLDER`] says where it lies.

mod backend;
mod browser;
mod pose;
mod technique;
mod way;

pub use technique::{CesiumTechnique, FOLDER};
