// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a surface promises, what it draws in a view, and what may fail.

use glam::DVec3;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;
use terrafill_core::{Extent, index_u32};
use terrafill_scene::{Camera, ImageSize};

/// Heights above the ellipsoid between which a surface lies, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightRange {
    /// No point lies lower.
    pub lowest_m: f64,
    /// No point lies higher.
    pub highest_m: f64,
}

impl HeightRange {
    /// What lies in both ranges, or `None` where they have nothing in common.
    #[must_use]
    pub fn intersection(self, other: Self) -> Option<Self> {
        let both = Self {
            lowest_m: self.lowest_m.max(other.lowest_m),
            highest_m: self.highest_m.min(other.highest_m),
        };
        (both.lowest_m <= both.highest_m).then_some(both)
    }

    /// The smallest range that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            lowest_m: self.lowest_m.min(other.lowest_m),
            highest_m: self.highest_m.max(other.highest_m),
        }
    }
}

/// A planet's surface. One that is the same in every view is closed around the body.
///
/// One that is made for a view may hold what that view shows and no more. It may leave out what it cannot cover,
/// such as a rim beside the limb: a ray that meets no triangle shows the sky, and regions are not filled there.
/// Where triangles end on the body, nothing that lies behind them may show.
pub trait Surface: Debug + Send + Sync {
    /// Name in scene files.
    fn kind(&self) -> &'static str;

    /// Heights of everything that may be drawn over `extent`, in whatever view. The range of a volume
    /// over that extent.
    fn heights(&self, extent: &Extent) -> HeightRange;

    /// Height above the ellipsoid, metres, of what the triangles stand for at this place, at its full
    /// resolution. How far coarse triangles move a boundary is measured from it. `None` where the surface
    /// cannot say, which it then can nowhere.
    fn true_height_m(&self, _longitude_deg: f64, _latitude_deg: f64) -> Option<f64> {
        None
    }

    /// What has to be said of the files that the surface was made from: what was read otherwise than a file says, or may
    /// be wrong. Each names its file.
    fn warnings(&self) -> &[String] {
        &[]
    }

    /// What is drawn in a view.
    ///
    /// # Errors
    /// [`SurfaceError::EyeBelow`], or whatever the surface cannot provide for this view.
    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError>;

    /// Vertices of [`Surface::frame`] before they are rounded to `f32`, metres relative to the eye, ECEF axes: what
    /// the rounding of a frame is measured from. `None` where the surface does not say.
    ///
    /// # Errors
    /// As [`Surface::frame`].
    fn exact_vertices(
        &self,
        _camera: &Camera,
        _size: ImageSize,
    ) -> Result<Option<Vec<DVec3>>, SurfaceError> {
        Ok(None)
    }

    /// The same surface as one whose pieces are made while frames are drawn; `None` where there are no pieces.
    fn refining(&self) -> Option<&dyn Refining> {
        None
    }
}

/// A surface that need not wait for all pieces of a view. [`Surface::frame`] waits for them.
pub trait Refining: Send + Sync {
    /// What can be drawn of a view with the pieces that are there, and how far that is from what is wanted.
    /// The missing ones are asked for, in place of those asked for before: also those in between, which are
    /// drawn on the way.
    ///
    /// # Errors
    /// As [`Surface::frame`].
    fn frame_now(
        &self,
        camera: &Camera,
        size: ImageSize,
    ) -> Result<(SurfaceFrame, Refinement), SurfaceError>;

    /// Makes up to `most` of the pieces that the last frame asked for, those that lack most first, and says how
    /// many it made. Pieces of earlier frames leave where the memory would exceed its budget; where all are in
    /// use nothing is made.
    fn refine(&self, most: usize) -> usize;

    /// Lets go of every piece.
    fn forget(&self);

    /// Lets go of every piece; from now on they may take so much.
    fn set_budget(&self, bytes: u64);

    /// What is kept now.
    fn memory(&self) -> PieceMemory;
}

/// How far a frame is from what its view wants.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Refinement {
    /// Pieces that were asked for. 0: the frame is what [`Surface::frame`] gives.
    pub waiting: usize,
    /// How far from the full resolution what is drawn may be on the screen, pixels: a bound.
    pub error_px: f64,
}

/// Pieces in memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PieceMemory {
    /// Of all pieces.
    pub bytes: u64,
    /// What they may take.
    pub budget_bytes: u64,
    /// How many there are.
    pub pieces: usize,
    /// Made since the surface was opened.
    pub made: u64,
    /// Of these, let go to make room.
    pub evicted: u64,
}

/// A surface as one view draws it.
#[derive(Debug, Clone)]
pub struct SurfaceFrame {
    /// Metres relative to the eye, ECEF axes: subtracted in `f64`, then rounded. Every renderer and the
    /// reference read these numbers, so the tessellation is no source of error.
    pub vertices_rte: Arc<[[f32; 3]]>,
    /// Counter-clockwise seen from outside.
    pub triangles: Arc<[[u32; 3]]>,
    /// Heights of the triangles as drawn in this view, metres above the ellipsoid.
    pub heights: HeightRange,
    /// The same for parts of the surface, which together hold every triangle that can be seen; none where
    /// the surface has the same heights in every view.
    pub parts: Arc<[SurfacePart]>,
    /// Ranges of the triangles, ascending, that hold every front face the view may show; all of them where there is
    /// `None`. The reference looks at all triangles, so that it judges this choice too.
    pub shown: Option<Arc<[Range<u32>]>>,
}

/// A part of a surface as one view draws it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePart {
    /// No point of its triangles lies outside.
    pub extent: Extent,
    /// Heights of its triangles as drawn, metres above the ellipsoid.
    pub heights: HeightRange,
}

impl SurfaceFrame {
    /// Ranges of indices to draw, three a triangle: what the view may show, or everything.
    ///
    /// - `draws_back_faces`: which are not known to be hidden
    #[must_use]
    pub fn index_ranges(&self, draws_back_faces: bool) -> Vec<Range<u32>> {
        let whole = 0..index_u32(self.triangles.len());
        let shown = self.shown.as_deref().filter(|_| !draws_back_faces);
        let shown = shown.unwrap_or(std::slice::from_ref(&whole)).iter();
        let some = shown.map(|range| 3 * range.start..3 * range.end.min(whole.end));
        some.filter(|range| !range.is_empty()).collect()
    }

    /// One phrase on the triangles that are not drawn, where that is any.
    #[must_use]
    pub fn left_out_summary(&self) -> Option<String> {
        let of = self.triangles.len();
        let ranges = self.index_ranges(false);
        let drawn: usize = ranges.iter().map(|range| range.len() / 3).sum();
        let left_out = of - drawn;
        (left_out > 0).then(|| {
            format!(
                "{left_out} of {of} triangles of the surface that face away or lie outside the image"
            )
        })
    }

    /// Heights of what this view draws over `extent`.
    ///
    /// - `stated`: of the surface there in whatever view, [`Surface::heights`]
    #[must_use]
    pub fn heights_over(&self, extent: &Extent, stated: HeightRange) -> HeightRange {
        let parts = self.parts.iter();
        let here = parts.filter(|part| overlaps(&part.extent, extent));
        let drawn = here.map(|part| part.heights).reduce(HeightRange::union);
        // Over what is not drawn in parts, and where the two have nothing in common, nothing is seen.
        let drawn = drawn.unwrap_or(self.heights);
        stated.intersection(drawn).unwrap_or(stated)
    }
}

/// Whether two extents have a place in common, edges included.
fn overlaps(one: &Extent, other: &Extent) -> bool {
    let is_between = |at: f64, extent: &Extent| {
        if extent.west_deg <= extent.east_deg {
            (extent.west_deg..=extent.east_deg).contains(&at)
        } else {
            at >= extent.west_deg || at <= extent.east_deg
        }
    };
    // ±180° is one meridian.
    let begins_in = |one: &Extent, other: &Extent| {
        let opposite = if one.west_deg >= 180.0 {
            -180.0
        } else {
            one.west_deg
        };
        is_between(one.west_deg, other) || is_between(opposite, other)
    };
    let touch = |one: &Extent, other: &Extent| {
        let is_meridian = |degrees: f64| degrees.abs() >= 180.0;
        is_meridian(one.east_deg) && is_meridian(other.west_deg)
    };
    one.south_deg <= other.north_deg
        && other.south_deg <= one.north_deg
        && (begins_in(one, other)
            || begins_in(other, one)
            || touch(one, other)
            || touch(other, one))
}

/// Why a surface cannot be opened or drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A value in a scene's `[surface]` that is not allowed.
    #[error("{file}: surface.{key}: found {found}, allowed: {allowed}")]
    Value {
        /// The scene file.
        file: String,
        /// Key in `[surface]`.
        key: String,
        /// The value.
        found: String,
        /// What it may be.
        allowed: String,
    },
    /// A file of the surface's that cannot be used.
    #[error("{file}: surface.files: {message}")]
    Data {
        /// The scene file.
        file: String,
        /// What is wrong with which file.
        message: String,
    },
    /// Seen from inside, a surface hides nothing, and there is nothing to fill.
    #[error(
        "the eye is {eye_height_m:.1} m above the ellipsoid, allowed: above the {kind} surface, \
         which is higher there"
    )]
    EyeBelow {
        /// The surface.
        kind: &'static str,
        /// Height of the eye above the ellipsoid, metres.
        eye_height_m: f64,
    },
    /// Deeper down, normals of the ellipsoid cross, and no place has a longitude and latitude of its own.
    #[error(
        "the {kind} surface is so coarse in this view that it reaches {lowest_m:.0} m above the \
         ellipsoid, allowed: {allowed_m:.0} m or more"
    )]
    TooDeep {
        /// The surface.
        kind: &'static str,
        /// Lowest point of its triangles, metres above the ellipsoid.
        lowest_m: f64,
        /// Where it may be.
        allowed_m: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extent(west_deg: f64, east_deg: f64) -> Extent {
        Extent {
            west_deg,
            south_deg: 0.0,
            east_deg,
            north_deg: 10.0,
        }
    }

    fn range(lowest_m: f64, highest_m: f64) -> HeightRange {
        HeightRange {
            lowest_m,
            highest_m,
        }
    }

    #[test]
    fn heights_over_an_extent_are_those_of_the_parts_that_meet_it() {
        let part = |west, east, lowest, highest| SurfacePart {
            extent: extent(west, east),
            heights: range(lowest, highest),
        };
        let frame = SurfaceFrame {
            vertices_rte: Arc::default(),
            triangles: Arc::default(),
            heights: range(-50.0, 500.0),
            parts: [
                part(0.0, 10.0, 0.0, 100.0),
                part(10.0, 20.0, -50.0, 60.0),
                part(170.0, 180.0, 300.0, 500.0),
            ]
            .into(),
            shown: None,
        };
        let stated = range(-1000.0, 1000.0);
        for (west, east, expected) in [
            (2.0, 3.0, range(0.0, 100.0)),
            (12.0, 13.0, range(-50.0, 60.0)),
            (5.0, 12.0, range(-50.0, 100.0)),
            (-10.0, 200.0 - 21.0, range(-50.0, 500.0)),
            (175.0, -170.0, range(300.0, 500.0)),
            (-180.0, -179.0, range(300.0, 500.0)),
            (100.0, 101.0, range(-50.0, 500.0)),
        ] {
            let found = frame.heights_over(&extent(west, east), stated);
            assert_eq!(found, expected, "{west} {east}");
        }
        let high = frame.heights_over(&extent(2.0, 3.0), range(700.0, 800.0));
        assert_eq!(high, range(700.0, 800.0));
        // Negative control: further north nothing of the parts is met.
        let north = Extent {
            south_deg: 11.0,
            north_deg: 12.0,
            ..extent(2.0, 3.0)
        };
        assert_eq!(frame.heights_over(&north, stated), frame.heights);
    }
}
