// SPDX-License-Identifier: MIT OR Apache-2.0
//! A region as triangles and boundary loops on the ellipsoid's surface, in f64.
//!
//! This is what every backend extrudes: caps from the triangles, walls from the boundary.

use crate::{Ellipsoid, RegionWarning};
use glam::{DMat3, DVec3};

/// Interior edges longer than this many steps are halved.
pub(crate) const LONGEST_INTERIOR_EDGE_STEPS: f64 = 1.5;

/// How finely a region is meshed; both are knobs of the error-against-time plots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshOptions {
    /// Largest distance between a boundary edge as drawn and the edge by its rule, metres.
    pub boundary_tolerance_m: f64,
    /// Largest edge of a cap triangle, degrees between the normals at its ends; edges inside the region may
    /// have half as many more. Bounds the facets' sagitta and with it the height of the walls:
    /// [`MeshOptions::sagitta_bound_m`].
    pub cap_step_deg: f64,
}

impl MeshOptions {
    /// The largest [`RegionMesh::cap_sagitta_m`] that the cap step allows on `body`, metres.
    ///
    /// A step s, radians, bounds the angle between the normals at an edge's ends: s for boundary edges,
    /// 3/2 s for edges inside. Where no radius of curvature is above ρ = a²/b, points whose normals are θ
    /// apart are at most ρ θ apart, so no side of a facet is longer than 3/2 ρ s. A triangle fits in a circle
    /// whose radius is its longest side over √3 (Jung, 1901): r = √3/2 ρ s. In the ball of the smallest radius
    /// of curvature, R = b²/a, such a circle lies R − √(R² − r²) deep.
    #[must_use]
    pub fn sagitta_bound_m(&self, body: &Ellipsoid) -> f64 {
        let longest_rad = LONGEST_INTERIOR_EDGE_STEPS * self.cap_step_deg.to_radians();
        let longest_m = longest_rad * body.largest_curvature_radius_m();
        sagitta_of_circle_m(body, longest_m * longest_m / 3.0)
    }
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            boundary_tolerance_m: 100.0,
            cap_step_deg: 3.0,
        }
    }
}

/// Geodetic bounds in degrees. `west_deg > east_deg` when the region crosses the antimeridian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Western edge, −180 … 180.
    pub west_deg: f64,
    /// Southern edge.
    pub south_deg: f64,
    /// Eastern edge, −180 … 180.
    pub east_deg: f64,
    /// Northern edge.
    pub north_deg: f64,
}

impl Extent {
    /// All of a body.
    pub const WHOLE: Self = Self {
        west_deg: -180.0,
        south_deg: -90.0,
        east_deg: 180.0,
        north_deg: 90.0,
    };
}

impl Default for Extent {
    fn default() -> Self {
        Self::WHOLE
    }
}

/// A longitude that is less than a turn outside −180 … 180, as the same one inside.
#[must_use]
pub fn wrapped_deg(longitude_deg: f64) -> f64 {
    match longitude_deg {
        l if l > 180.0 => l - 360.0,
        l if l < -180.0 => l + 360.0,
        l => l,
    }
}

/// A box with its own axes, ECEF metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// Centre, ECEF.
    pub center_ecef: DVec3,
    /// Columns are the unit axes, ECEF.
    pub axes: DMat3,
    /// Half lengths along the axes, metres.
    pub half_extents_m: DVec3,
}

impl OrientedBox {
    /// Around these vertices, which lie on the ellipsoid, at both heights; see [`RegionMesh::oriented_box`].
    pub(crate) fn around(
        body: &Ellipsoid,
        vertices_ecef: &[DVec3],
        heights: VolumeHeights,
    ) -> Self {
        let sum: DVec3 = vertices_ecef.iter().copied().sum();
        let middle = body.ecef_to_geodetic(sum / vertices_ecef.len().max(1) as f64);
        let up = body.geodetic_surface_normal(middle.longitude_rad, middle.latitude_rad);
        let east = DVec3::new(-middle.longitude_rad.sin(), middle.longitude_rad.cos(), 0.0);
        let axes = DMat3::from_cols(east, up.cross(east), up);
        let to_local = axes.transpose();
        // The gradient of the ellipsoid's equation is along the geodetic normal.
        let per_axis = (body.radii_m() * body.radii_m()).recip();
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for vertex in vertices_ecef {
            let normal = (*vertex * per_axis).normalize();
            for height in [heights.top_m, heights.bottom_m] {
                let local = to_local * (*vertex + normal * height);
                low = low.min(local);
                high = high.max(local);
            }
        }
        Self {
            center_ecef: axes * ((low + high) * 0.5),
            axes,
            half_extents_m: (high - low) * 0.5,
        }
    }

    /// Distance from a point to the nearest place of the box, 0 inside, and to the farthest.
    #[must_use]
    pub fn distances_m(&self, ecef: DVec3) -> (f64, f64) {
        let local = (self.axes.transpose() * (ecef - self.center_ecef)).abs();
        let outside = (local - self.half_extents_m).max(DVec3::ZERO);
        (outside.length(), (local + self.half_extents_m).length())
    }

    /// The eight corners, ECEF metres.
    #[must_use]
    pub fn corners_ecef(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let local = self.half_extents_m * DVec3::new(sign(0), sign(1), sign(2));
            self.center_ecef + self.axes * local
        })
    }
}

/// Heights of a volume's caps above the ellipsoid, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeHeights {
    /// Height of the top cap's vertices: the facets between them stay above the highest terrain.
    pub top_m: f64,
    /// Height of the bottom cap's vertices: below the lowest terrain.
    pub bottom_m: f64,
}

/// One region, meshed. Vertices lie on the ellipsoid at height 0; backends extrude them along the
/// geodetic normal.
#[derive(Debug, Clone, Default)]
pub struct RegionMesh {
    /// Index of the feature in its file.
    pub region_index: usize,
    /// Name of the feature.
    pub name: String,
    /// ECEF metres, on the surface.
    pub vertices_ecef: Vec<DVec3>,
    /// Longitude in `[-180, 180]` and latitude of each vertex, degrees.
    pub vertices_deg: Vec<[f64; 2]>,
    /// Counter-clockwise seen from outside the body.
    pub triangles: Vec<[u32; 3]>,
    /// Closed loops, first vertex not repeated, interior on the left seen from outside. Edges that
    /// the antimeridian or a pole cut into a region are not among them.
    pub boundary_loops: Vec<Vec<u32>>,
    /// Holes in the file's rings.
    pub holes: usize,
    /// Exact area of the rings by their edge rule, square metres.
    pub area_m2: f64,
    /// Bounds.
    pub extent: Extent,
    /// Largest distance found between a boundary edge as drawn and by its rule, metres.
    pub boundary_deviation_m: f64,
    /// Largest depth of a cap facet below the spherical cap through its corners, metres.
    pub cap_sagitta_m: f64,
    /// Those of the region, and what meshing chose or could not reach.
    pub warnings: Vec<RegionWarning>,
}

impl RegionMesh {
    /// A mesh of nothing: no vertices, hence no triangles and no loops.
    #[must_use]
    pub fn without_geometry() -> Self {
        Self::default()
    }

    /// Vertices, those inside included.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertices_ecef.len()
    }

    /// Triangles of one cap.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Directed edges of the boundary, loop after loop, inside on the left.
    pub fn boundary_edges(&self) -> impl Iterator<Item = [u32; 2]> {
        self.boundary_loops.iter().flat_map(|ring| {
            let ends = ring.iter().cycle().skip(1);
            ring.iter().zip(ends).map(|(&start, &end)| [start, end])
        })
    }

    /// Edges of the boundary: as many walls.
    #[must_use]
    pub fn boundary_edge_count(&self) -> usize {
        self.boundary_loops.iter().map(Vec::len).sum()
    }

    /// Heights that contain terrain between `lowest_m` and `highest_m` (metres above the
    /// ellipsoid).
    ///
    /// The top is raised by the facets' sagitta, since a flat cap hangs through between its corners; a flat
    /// bottom hangs further down by itself. Raising the corners by h along their normals spreads them, and the
    /// sagitta grows by h/R. It is enlarged by twice h over the distance to the centre, which is more for
    /// every oblate body with f < ½. One thousandth of the span is added on both sides so that a cap never
    /// touches terrain of exactly the stated height.
    #[must_use]
    pub fn volume_heights(&self, lowest_m: f64, highest_m: f64) -> VolumeHeights {
        volume_heights(&self.vertices_ecef, self.cap_sagitta_m, lowest_m, highest_m)
    }

    /// The same for facets that hang `sagitta_m` deep, such as those of [`MeshOptions::sagitta_bound_m`].
    #[must_use]
    pub fn volume_heights_of_sagitta(
        &self,
        sagitta_m: f64,
        lowest_m: f64,
        highest_m: f64,
    ) -> VolumeHeights {
        volume_heights(&self.vertices_ecef, sagitta_m, lowest_m, highest_m)
    }

    /// A box around the volume between `heights`, aligned with the local vertical at its middle.
    ///
    /// Holds every vertex at both heights, hence their convex hull, hence the volume.
    #[must_use]
    pub fn oriented_box(&self, body: &Ellipsoid, heights: VolumeHeights) -> OrientedBox {
        OrientedBox::around(body, &self.vertices_ecef, heights)
    }

    /// As [`RegionMesh::oriented_box`], around some of the vertices: it holds the facets of both caps and the
    /// walls that have no others.
    ///
    /// - `vertices`: indices of them
    /// - cost: O(these vertices)
    #[must_use]
    pub fn box_of_some(
        &self,
        body: &Ellipsoid,
        vertices: &[u32],
        heights: VolumeHeights,
    ) -> OrientedBox {
        let places = vertices
            .iter()
            .map(|&vertex| self.vertices_ecef[vertex as usize]);
        OrientedBox::around(body, &places.collect::<Vec<_>>(), heights)
    }
}

/// See [`RegionMesh::volume_heights`].
pub(crate) fn volume_heights(
    vertices_ecef: &[DVec3],
    cap_sagitta_m: f64,
    lowest_m: f64,
    highest_m: f64,
) -> VolumeHeights {
    let span = (highest_m - lowest_m).max(cap_sagitta_m);
    let margin = span * 1e-3;
    let radius_m = vertices_ecef.first().map_or(1.0, |v| v.length());
    let raised_m = highest_m.max(0.0) + cap_sagitta_m;
    let sagitta_m = cap_sagitta_m * (1.0 + 2.0 * raised_m / radius_m);
    VolumeHeights {
        top_m: highest_m + sagitta_m + margin,
        bottom_m: lowest_m - margin,
    }
}

/// Largest depth of flat facets with these corners below the surface, metres; 0 of none.
///
/// A ball of the body's smallest curvature radius R rolls freely inside it (Blaschke), so no facet
/// hangs deeper than in that ball: `R − √(R² − r²)`, with r the radius of the smallest circle that
/// holds the facet.
pub(crate) fn sagitta_m(body: &Ellipsoid, facets: impl Iterator<Item = [DVec3; 3]>) -> f64 {
    let widest = facets.fold(0.0, |widest: f64, corners| {
        let sides = squared_sides(corners);
        // No acute triangle needs a circle of more than a third of its longest side squared, and
        // no other of more than a quarter: most are smaller than the widest so far by far.
        let longest = sides[0].max(sides[1]).max(sides[2]);
        if longest * 0.34 < widest {
            return widest;
        }
        widest.max(enclosing_radius_squared(corners))
    });
    sagitta_of_circle_m(body, widest)
}

/// Depth of a circle of this squared radius in the ball of the body's smallest curvature radius.
fn sagitta_of_circle_m(body: &Ellipsoid, radius_squared: f64) -> f64 {
    let ball_m = body.smallest_curvature_radius_m();
    let squared = radius_squared.min(ball_m * ball_m);
    // Without the cancellation of R − √(R² − r²).
    squared / (ball_m + (ball_m * ball_m - squared).sqrt())
}

fn squared_sides([a, b, c]: [DVec3; 3]) -> [f64; 3] {
    [(b, c), (c, a), (a, b)].map(|(from, to)| (from - to).length_squared())
}

/// Square of the radius of the smallest circle that holds a triangle.
fn enclosing_radius_squared([a, b, c]: [DVec3; 3]) -> f64 {
    let mut sides = squared_sides([a, b, c]);
    sides.sort_by(f64::total_cmp);
    let [shortest, middle, longest] = sides;
    if shortest + middle <= longest {
        // Obtuse: the longest side is a diameter.
        longest * 0.25
    } else {
        let area = (b - a).cross(c - a).length_squared();
        shortest * middle * longest / (4.0 * area)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_as_far_as_its_faces() {
        let unit = OrientedBox {
            center_ecef: DVec3::new(10.0, 0.0, 0.0),
            axes: DMat3::IDENTITY,
            half_extents_m: DVec3::ONE,
        };
        let (near, far) = unit.distances_m(DVec3::ZERO);
        assert!((near - 9.0).abs() < 1e-12 && (far - 123_f64.sqrt()).abs() < 1e-12);
        let (inside, _) = unit.distances_m(DVec3::new(10.5, 0.0, 0.0));
        assert!(inside.abs() < 1e-12);
    }
}
