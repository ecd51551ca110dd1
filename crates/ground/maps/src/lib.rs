// SPDX-License-Identifier: MIT OR Apache-2.0
//! Maps in tiles over a body: Web Mercator's coordinates, tiles and levels, polar caps where it ends, and pictures cut into
//! both. Ways to keep a triangle across ±180° in one piece (A. Jeromel, StuCoSReC 2018, pp. 39–42). Tiles that come and go:
//! slots that hold them, and a thread that reads them. Projections of a whole body, and a quadtree over one large
//! picture (Gebbie and Bailey, "Fast Realistic Rendering of Global Worlds").

mod cap;
mod cut;
mod loader;
mod projection;
mod quadtree;
mod seam;
mod slots;
mod tile;

pub use cap::{CAP_SPAN, cap_point};
pub use cut::{PictureLevel, cut_cap, cut_tile};
pub use loader::Loader;
pub use projection::{HALF_RIM, dome, hyperbolic_cartesian, hyperbolic_polar};
pub use quadtree::{Node, Quadtree, Thresholds, children};
pub use seam::{Seam, SeamCorner, fragment_u, half_plane_crossings, split};
pub use slots::{Placed, Slots};
pub use tile::{
    MapPoint, MapTile, TILE_TEXELS, level_of, max_latitude_rad, mercator_v, mercator_v_of, place,
};
