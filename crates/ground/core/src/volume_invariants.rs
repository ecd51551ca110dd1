// SPDX-License-Identifier: MIT OR Apache-2.0
//! What must hold for the closed solid of every mesh, before and after its positions are rounded.
//!
//! ECEF metres, `f64`. Closed: every edge of the solid is used once each way, by vertex and by
//! position. Of the rings: their edges, and no others, carry walls, and each is an edge of the caps,
//! so no triangle reaches across one. In place: every corner at its height over its vertex, walls
//! and caps to the same bit. Right side out: no cap shows its back by more than its edges bow, and
//! the volume is that of the prisms under the triangles, and the rings' area times the thickness.

use crate::edge::normal;
use crate::volume::{ring_edges, wall_of};
use crate::{
    Ellipsoid, RegionMesh, RegionVolume, VolumeHeights, VolumePart, VolumeTriangle, check_closed,
};
use glam::{DVec3, Vec3};

/// A share of the body's radius within which positions are the same but for rounding: half a dozen
/// roundings of coordinates as large as the radius, 0.13 µm on the Earth.
const ROUNDING: f64 = 2e-14;
/// Relative error of a triple product and of adding up a million of them; 2⁻⁵² is 2.2e-16.
const PRODUCT_ROUNDING: f64 = 1e-13;
/// A flat facet covers less than the surface over it. Over an equilateral triangle of circumradius
/// r on a sphere of radius R the prism lacks the share 3r²/8R² of base and r²/4R² of mean height
/// along its axis, which is 5/4 of the sagitta r²/2R over R; obtuse triangles, whose sagitta is
/// taken over the longest side, and the change of curvature on a flat body take no more than this
/// many.
const LARGEST_FACET_LOSS_SAGITTAS: f64 = 4.0;

/// A promise of a region's volume that is broken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeFault {
    /// Heights between which there is no solid, or one that reaches below the body's centres of
    /// curvature, where normals cross.
    #[error(
        "the volume from {bottom_m} m to {top_m} m does not stand on its bottom; the bottom must be \
         lower, and above {lowest_m} m"
    )]
    Heights {
        /// Of the top cap.
        top_m: f64,
        /// Of the bottom cap.
        bottom_m: f64,
        /// Minus the body's smallest radius of curvature.
        lowest_m: f64,
    },
    /// A triangle or loop of the mesh names a vertex that is not there.
    #[error("vertex index {vertex} is out of range; there are {count} vertices")]
    Index {
        /// The index.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// Two triangles of one part with the same corners, turned the same way.
    #[error("triangles {first} and {second} of the {part} are the same, at {at_deg:?}")]
    DuplicateTriangle {
        /// Where both are.
        part: VolumePart,
        /// Index in the volume.
        first: usize,
        /// Index in the volume.
        second: usize,
        /// Longitude and latitude of a corner.
        at_deg: [f64; 2],
    },
    /// Three corners on one line in longitude and latitude, exactly, or two that are one.
    #[error("triangle {triangle} of the {part} is degenerate, at {at_deg:?}")]
    Degenerate {
        /// Where it is.
        part: VolumePart,
        /// Index in the volume.
        triangle: usize,
        /// Longitude and latitude of a corner.
        at_deg: [f64; 2],
    },
    /// An edge of a ring that the top cap does not end at: a triangle lies across it.
    #[error(
        "the ring edge from {from_deg:?} to {to_deg:?} is used {uses} times by the top cap, its \
         reverse {reverse_uses} times; the rings have it {ring_uses} times"
    )]
    ConstraintMissing {
        /// Longitude and latitude of its start.
        from_deg: [f64; 2],
        /// Longitude and latitude of its end.
        to_deg: [f64; 2],
        /// By the top cap, in the ring's direction.
        uses: usize,
        /// By the top cap, the other way.
        reverse_uses: usize,
        /// By rings.
        ring_uses: usize,
    },
    /// Walls are more or fewer than twice the rings' edges.
    #[error("{found} wall triangles; the rings' edges ask for {expected}")]
    WallCount {
        /// Wall triangles.
        found: usize,
        /// Twice the edges of all rings.
        expected: usize,
    },
    /// A wall that does not stand on its ring edge.
    #[error(
        "triangle {triangle}, a wall, has vertices {found:?}; the ring edge from {from_deg:?} to \
         {to_deg:?} asks for {expected:?}"
    )]
    WallOffBoundary {
        /// Index in the volume.
        triangle: usize,
        /// Its vertices.
        found: [u32; 3],
        /// What they should be.
        expected: [u32; 3],
        /// Longitude and latitude of the ring edge's start.
        from_deg: [f64; 2],
        /// Longitude and latitude of the ring edge's end.
        to_deg: [f64; 2],
    },
    /// An edge without a triangle on its other side.
    #[error(
        "triangle {triangle} of the {part}: its edge from {from_deg:?} to {to_deg:?} is used {uses} \
         times, its reverse {reverse_uses} times"
    )]
    OpenEdge {
        /// Of the triangle.
        part: VolumePart,
        /// A triangle that has it; index in the volume.
        triangle: usize,
        /// Longitude and latitude of its start.
        from_deg: [f64; 2],
        /// Longitude and latitude of its end.
        to_deg: [f64; 2],
        /// As that triangle has it.
        uses: usize,
        /// The other way.
        reverse_uses: usize,
    },
    /// An edge whose triangles do not turn the same way.
    #[error(
        "triangle {triangle} of the {part} turns against its neighbour: the edge from {from_deg:?} \
         to {to_deg:?} is used {uses} times, its reverse {reverse_uses} times"
    )]
    TwistedEdge {
        /// Of the triangle.
        part: VolumePart,
        /// A triangle that has it; index in the volume.
        triangle: usize,
        /// Longitude and latitude of its start.
        from_deg: [f64; 2],
        /// Longitude and latitude of its end.
        to_deg: [f64; 2],
        /// As that triangle has it.
        uses: usize,
        /// The other way.
        reverse_uses: usize,
    },
    /// An edge with more than two triangles where neither rings touch nor a pole is.
    #[error(
        "triangle {triangle} of the {part}: its edge from {from_deg:?} to {to_deg:?} is used {uses} \
         times each way; allowed is {allowed}"
    )]
    CrowdedEdge {
        /// Of the triangle.
        part: VolumePart,
        /// A triangle that has it; index in the volume.
        triangle: usize,
        /// Longitude and latitude of its start.
        from_deg: [f64; 2],
        /// Longitude and latitude of its end.
        to_deg: [f64; 2],
        /// Each way.
        uses: usize,
        /// 1, or how often rings pass the vertex that the edge stands on.
        allowed: usize,
    },
    /// Two triangles have the same vertex at different positions, if only in the last bit.
    #[error(
        "triangle {triangle} of the {part} has vertex {vertex}, over {at_deg:?}, at {found_ecef}; \
         another has it at {expected_ecef}"
    )]
    Seam {
        /// Of the triangle.
        part: VolumePart,
        /// Index in the volume.
        triangle: usize,
        /// Index of the copy.
        vertex: u32,
        /// Its longitude and latitude.
        at_deg: [f64; 2],
        /// In this triangle.
        found_ecef: DVec3,
        /// In the first triangle that has it.
        expected_ecef: DVec3,
    },
    /// A copy of a vertex that is not on the vertex's normal at its cap's height.
    #[error(
        "vertex {vertex} of the {part} is {height_m} m over {at_deg:?} and {aside_m} m beside the \
         normal there; its cap is at {expected_m} m, allowed is {allowed_m} m"
    )]
    OutOfPlace {
        /// Top or bottom cap.
        part: VolumePart,
        /// Index of the copy.
        vertex: u32,
        /// Longitude and latitude of its vertex.
        at_deg: [f64; 2],
        /// Found by the inverse of the formula that extruded it.
        height_m: f64,
        /// Angle between the normals, as an arc of the equator.
        aside_m: f64,
        /// Of its cap.
        expected_m: f64,
        /// Rounding.
        allowed_m: f64,
    },
    /// A cap triangle that shows its back.
    #[error(
        "triangle {triangle} of the {part} is turned over at {at_deg:?}: height {found_m} m over its \
         longest edge; at least {allowed_m} is allowed"
    )]
    Inverted {
        /// Top or bottom cap.
        part: VolumePart,
        /// Index in the volume.
        triangle: usize,
        /// Longitude and latitude of a corner.
        at_deg: [f64; 2],
        /// Signed height of the third corner.
        found_m: f64,
        /// What the bow of planar edges can explain.
        allowed_m: f64,
    },
    /// The surface encloses another volume than the prisms under the mesh's triangles have.
    #[error(
        "the surface encloses {found_m3} m³, the prisms have {expected_m3} m³; allowed difference \
         {allowed_m3}"
    )]
    Volume {
        /// By the divergence theorem.
        found_m3: f64,
        /// Sum over the mesh's triangles.
        expected_m3: f64,
        /// Rounding.
        allowed_m3: f64,
    },
    /// The volume is not the rings' area times the thickness.
    #[error(
        "the surface encloses {found_m3} m³; area times thickness is {least_m3} … {most_m3} m³"
    )]
    AreaTimesThickness {
        /// By the divergence theorem, with ruled walls.
        found_m3: f64,
        /// For the largest radius of curvature, less what facets and edges may lose.
        least_m3: f64,
        /// For the smallest radius of curvature, and what edges may gain.
        most_m3: f64,
    },
    /// An edge of rounded positions whose uses do not cancel.
    #[error(
        "after rounding, an edge of triangle {triangle} of the {part}, at {at_deg:?}, is used {uses} \
         times, its reverse {reverse_uses} times"
    )]
    OpenAfterRounding {
        /// Of the triangle.
        part: VolumePart,
        /// Index in the volume.
        triangle: usize,
        /// Longitude and latitude of a corner.
        at_deg: [f64; 2],
        /// As the triangle has it.
        uses: usize,
        /// The other way.
        reverse_uses: usize,
    },
}

/// What rounding did to a volume that stayed closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RoundedVolume {
    /// Copies of vertices that the triangles use.
    pub vertices: usize,
    /// Different positions that are left of them.
    pub positions: usize,
    /// Triangles with two corners at one position.
    pub collapsed_triangles: usize,
    /// Vertices of the rings whose two copies fell together: walls of no height.
    pub collapsed_columns: usize,
    /// Cap triangles that showed their face and now show their back.
    pub turned_over: usize,
}

/// What was found of a sound volume.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VolumeReport {
    /// Of the closed surface.
    pub triangles: usize,
    /// Different ones.
    pub edges: usize,
    /// Edges on which rings touch, or that meet at a pole, used more than once each way.
    pub shared_edges: usize,
    /// Cap triangles that show their back by no more than their edges bow. They cover nothing that
    /// the triangles round them do not cover once more, so counting stays right.
    pub turned_over: usize,
    /// By the divergence theorem.
    pub volume_m3: f64,
    /// Largest distance between the two diagonals of a wall: how far it matters which one is drawn.
    pub wall_twist_m: f64,
    /// Difference from area times thickness as a share of what is allowed.
    pub share_of_allowed: f64,
    /// After rounding to `f32` from [`RegionVolume::center_ecef`].
    pub rounded: RoundedVolume,
}

impl RegionMesh {
    /// Extrudes the mesh and checks the closed solid, as it is and rounded to `f32`.
    ///
    /// # Errors
    /// The first [`VolumeFault`] found.
    pub fn check_volume_invariants(
        &self,
        body: &Ellipsoid,
        heights: VolumeHeights,
    ) -> Result<VolumeReport, VolumeFault> {
        RegionVolume::new(self, body, heights)?.check()
    }
}

/// A directed edge, its ends in order, so that both directions sort together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct EdgeUse {
    low: u32,
    high: u32,
    downwards: bool,
    /// Not one of the surface's, but what those must agree with.
    of_ring: bool,
    triangle: usize,
}

impl EdgeUse {
    fn new(from: u32, to: u32, of_ring: bool, triangle: usize) -> Self {
        Self {
            low: from.min(to),
            high: from.max(to),
            downwards: from > to,
            of_ring,
            triangle,
        }
    }

    fn ends(self) -> [u32; 2] {
        if self.downwards {
            [self.high, self.low]
        } else {
            [self.low, self.high]
        }
    }
}

/// Upwards and downwards.
fn count_uses(uses: &[EdgeUse], of_ring: bool) -> (usize, usize) {
    let mut counts = (0, 0);
    for edge in uses.iter().filter(|edge| edge.of_ring == of_ring) {
        if edge.downwards {
            counts.1 += 1;
        } else {
            counts.0 += 1;
        }
    }
    counts
}

fn triangle_edges(triangle: &VolumeTriangle) -> [[u32; 2]; 3] {
    let [a, b, c] = triangle.vertices;
    [[a, b], [b, c], [c, a]]
}

impl RegionVolume<'_> {
    /// Checks everything that the module promises.
    ///
    /// # Errors
    /// The first [`VolumeFault`] found.
    pub fn check(&self) -> Result<VolumeReport, VolumeFault> {
        self.check_heights()?;
        self.check_indices()?;
        self.check_triangles_differ()?;
        self.check_constraints()?;
        self.check_walls()?;
        let mut report = VolumeReport::default();
        self.check_edges(&mut report)?;
        let positions = self.check_seams()?;
        self.check_places(&positions)?;
        self.check_caps(&mut report)?;
        self.check_volume(&positions, &mut report)?;
        let center_ecef = self.center_ecef();
        report.rounded = self.check_rounded(|_, corner| (corner - center_ecef).as_vec3())?;
        Ok(report)
    }

    fn check_heights(&self) -> Result<(), VolumeFault> {
        let VolumeHeights { top_m, bottom_m } = self.heights;
        let lowest_m = -self.body.smallest_curvature_radius_m();
        if top_m > bottom_m && bottom_m > lowest_m && top_m.is_finite() {
            Ok(())
        } else {
            Err(VolumeFault::Heights {
                top_m,
                bottom_m,
                lowest_m,
            })
        }
    }

    fn check_indices(&self) -> Result<(), VolumeFault> {
        let count = self.mesh.vertices_deg.len();
        let used = self.triangles.iter().flat_map(|triangle| triangle.vertices);
        match used.max() {
            Some(vertex) if vertex as usize >= 2 * count => Err(VolumeFault::Index {
                vertex,
                count: 2 * count,
            }),
            _ => Ok(()),
        }
    }

    fn touches_pole(&self, vertices: &[u32]) -> bool {
        vertices.iter().any(|v| self.degrees(*v)[1].abs() == 90.0)
    }

    fn check_triangles_differ(&self) -> Result<(), VolumeFault> {
        let mut canonical: Vec<([u32; 3], usize)> = Vec::with_capacity(self.triangles.len());
        for (index, triangle) in self.triangles.iter().enumerate() {
            let [a, b, c] = triangle.vertices;
            let degenerate = a == b || b == c || c == a;
            let is_cap = triangle.part != VolumePart::Wall;
            if degenerate || is_cap && self.mesh.is_degenerate([a / 2, b / 2, c / 2]) {
                return Err(VolumeFault::Degenerate {
                    part: triangle.part,
                    triangle: index,
                    at_deg: self.degrees(a),
                });
            }
            // Turned so that the smallest comes first: which way round is kept.
            let turned = match a.min(b).min(c) {
                first if first == a => [a, b, c],
                first if first == b => [b, c, a],
                _ => [c, a, b],
            };
            canonical.push((turned, index));
        }
        canonical.sort_unstable();
        match canonical.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            None => Ok(()),
            Some(pair) => {
                let (first, second) = (pair[0].1, pair[1].1);
                Err(VolumeFault::DuplicateTriangle {
                    part: self.triangles[first].part,
                    first,
                    second,
                    at_deg: self.degrees(pair[0].0[0]),
                })
            }
        }
    }

    /// Each ring edge is an edge of one triangle of the top cap, on its left; so no triangle lies
    /// across it. At a pole, where lines towards different longitudes become one, only the sums
    /// must agree.
    fn check_constraints(&self) -> Result<(), VolumeFault> {
        let mut uses: Vec<EdgeUse> = Vec::new();
        for (index, triangle) in self.triangles.iter().enumerate() {
            if triangle.part == VolumePart::TopCap {
                let edges = triangle_edges(triangle);
                uses.extend(edges.map(|[from, to]| EdgeUse::new(from, to, false, index)));
            }
        }
        for (index, [from, to]) in ring_edges(self.mesh).enumerate() {
            uses.push(EdgeUse::new(2 * from, 2 * to, true, index));
        }
        uses.sort_unstable();
        for same in uses.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
            let Some(ring_edge) = same.iter().find(|edge| edge.of_ring) else {
                continue;
            };
            let (up, down) = count_uses(same, false);
            let (ring_up, ring_down) = count_uses(same, true);
            let holds = if self.touches_pole(&[ring_edge.low, ring_edge.high]) {
                up + ring_down == down + ring_up && up >= ring_up && down >= ring_down
            } else {
                (up, down) == (ring_up, ring_down) && up + down == 1
            };
            if !holds {
                let (uses, reverse_uses) = match ring_edge.downwards {
                    true => (down, up),
                    false => (up, down),
                };
                let [from_deg, to_deg] = ring_edge.ends().map(|vertex| self.degrees(vertex));
                return Err(VolumeFault::ConstraintMissing {
                    from_deg,
                    to_deg,
                    uses,
                    reverse_uses,
                    ring_uses: ring_up + ring_down,
                });
            }
        }
        Ok(())
    }

    fn check_walls(&self) -> Result<(), VolumeFault> {
        let mut walls = self
            .triangles
            .iter()
            .enumerate()
            .filter(|(_, triangle)| triangle.part == VolumePart::Wall);
        let found = walls.clone().count();
        let expected = 2 * self.mesh.boundary_edge_count();
        if found != expected {
            return Err(VolumeFault::WallCount { found, expected });
        }
        for [from, to] in ring_edges(self.mesh) {
            for (expected, (triangle, wall)) in wall_of([from, to]).into_iter().zip(walls.by_ref())
            {
                // Orientation and closing are the edges' business; here, whose corners they are.
                let is_corner = |vertex: &u32| wall.vertices.contains(vertex);
                if !expected.iter().all(is_corner) {
                    let [from_deg, to_deg] = [2 * from, 2 * to].map(|v| self.degrees(v));
                    return Err(VolumeFault::WallOffBoundary {
                        triangle,
                        found: wall.vertices,
                        expected,
                        from_deg,
                        to_deg,
                    });
                }
            }
        }
        Ok(())
    }

    fn check_edges(&self, report: &mut VolumeReport) -> Result<(), VolumeFault> {
        let mut passes = vec![0_usize; self.mesh.vertices_deg.len()];
        for &vertex in self.mesh.boundary_loops.iter().flatten() {
            passes[vertex as usize] += 1;
        }
        let mut uses: Vec<EdgeUse> = Vec::with_capacity(3 * self.triangles.len());
        for (index, triangle) in self.triangles.iter().enumerate() {
            let edges = triangle_edges(triangle);
            uses.extend(edges.map(|[from, to]| EdgeUse::new(from, to, false, index)));
        }
        uses.sort_unstable();
        for same in uses.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
            let last = same[same.len() - 1];
            let (up, down) = count_uses(same, false);
            let (uses, reverse_uses) = if last.downwards {
                (down, up)
            } else {
                (up, down)
            };
            let triangle = last.triangle;
            let part = self.triangles[triangle].part;
            let [from_deg, to_deg] = last.ends().map(|vertex| self.degrees(vertex));
            if up != down && (up + down) % 2 == 1 {
                return Err(VolumeFault::OpenEdge {
                    part,
                    triangle,
                    from_deg,
                    to_deg,
                    uses,
                    reverse_uses,
                });
            }
            if up != down {
                return Err(VolumeFault::TwistedEdge {
                    part,
                    triangle,
                    from_deg,
                    to_deg,
                    uses,
                    reverse_uses,
                });
            }
            // Where rings touch at a vertex, all their walls there meet in one upright edge.
            let is_upright = last.low / 2 == last.high / 2;
            let allowed = if is_upright {
                passes[(last.low / 2) as usize]
            } else if self.touches_pole(&[last.low, last.high]) {
                usize::MAX
            } else {
                1
            };
            if uses > allowed {
                return Err(VolumeFault::CrowdedEdge {
                    part,
                    triangle,
                    from_deg,
                    to_deg,
                    uses,
                    allowed,
                });
            }
            report.edges += 1;
            report.shared_edges += usize::from(uses > 1);
        }
        report.triangles = self.triangles.len();
        Ok(())
    }

    /// Positions by vertex, the same to the bit in every triangle; `None` where no triangle has it.
    fn check_seams(&self) -> Result<Vec<Option<DVec3>>, VolumeFault> {
        let mut positions: Vec<Option<DVec3>> = vec![None; 2 * self.mesh.vertices_deg.len()];
        for (index, triangle) in self.triangles.iter().enumerate() {
            for (vertex, found_ecef) in triangle.vertices.into_iter().zip(triangle.corners_ecef) {
                let expected_ecef = *positions[vertex as usize].get_or_insert(found_ecef);
                let bits = |position: DVec3| position.to_array().map(f64::to_bits);
                if bits(found_ecef) != bits(expected_ecef) {
                    return Err(VolumeFault::Seam {
                        part: triangle.part,
                        triangle: index,
                        vertex,
                        at_deg: self.degrees(vertex),
                        found_ecef,
                        expected_ecef,
                    });
                }
            }
        }
        Ok(positions)
    }

    /// By the inverse formula, which extruding has not used.
    fn check_places(&self, positions: &[Option<DVec3>]) -> Result<(), VolumeFault> {
        let radius_m = self.body.equatorial_radius_m();
        for (vertex, position) in (0_u32..).zip(positions) {
            let Some(position) = position else { continue };
            let at_deg = self.degrees(vertex);
            let (part, expected_m) = match vertex % 2 {
                0 => (VolumePart::TopCap, self.heights.top_m),
                _ => (VolumePart::BottomCap, self.heights.bottom_m),
            };
            let found = self.body.ecef_to_geodetic(*position);
            let up = self
                .body
                .geodetic_surface_normal(found.longitude_rad, found.latitude_rad);
            let aside_m = up.cross(normal(at_deg)).length() * radius_m;
            let allowed_m = ROUNDING * (radius_m + expected_m.abs());
            let off_m = (found.height_m - expected_m).abs().max(aside_m);
            if off_m.is_nan() || off_m > allowed_m {
                return Err(VolumeFault::OutOfPlace {
                    part,
                    vertex,
                    at_deg,
                    height_m: found.height_m,
                    aside_m,
                    expected_m,
                    allowed_m,
                });
            }
        }
        Ok(())
    }

    /// Height of a cap triangle's third corner over its longest edge, seen along the normal at its
    /// middle; below 0 where the triangle shows its back.
    fn signed_height_m(&self, part: VolumePart, [a, b, c]: [DVec3; 3]) -> f64 {
        let middle = self.body.ecef_to_geodetic((a + b + c) / 3.0);
        let up = self
            .body
            .geodetic_surface_normal(middle.longitude_rad, middle.latitude_rad);
        let outwards = if part == VolumePart::BottomCap {
            -up
        } else {
            up
        };
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        (b - a).cross(c - a).dot(outwards) / longest
    }

    /// Curved edges are drawn straight, so where three vertices lie almost on one edge the triangle
    /// may be turned over by as much as its edges bow; exactly as [`RegionMesh::check_invariants`]
    /// allows on the surface, scaled to the height.
    fn check_caps(&self, report: &mut VolumeReport) -> Result<(), VolumeFault> {
        let radius_m = self.body.equatorial_radius_m();
        for (index, triangle) in self.triangles.iter().enumerate() {
            if triangle.part == VolumePart::Wall {
                continue;
            }
            let found_m = self.signed_height_m(triangle.part, triangle.corners_ecef);
            if found_m > 0.0 {
                continue;
            }
            let height_m = match triangle.part {
                VolumePart::TopCap => self.heights.top_m,
                _ => self.heights.bottom_m,
            };
            let scale = 1.0 + height_m.abs() / self.body.smallest_curvature_radius_m();
            let bows: f64 = triangle_edges(triangle)
                .map(|[from, to]| self.mesh.planar_bow_m(&self.body, from / 2, to / 2))
                .iter()
                .sum();
            let allowed_m = -bows * scale - ROUNDING * radius_m;
            // Two corners at one position have no height at all.
            if found_m < allowed_m {
                return Err(VolumeFault::Inverted {
                    part: triangle.part,
                    triangle: index,
                    at_deg: self.degrees(triangle.vertices[0]),
                    found_m,
                    allowed_m,
                });
            }
            report.turned_over += usize::from(found_m < 0.0);
        }
        Ok(())
    }

    fn check_volume(
        &self,
        positions: &[Option<DVec3>],
        report: &mut VolumeReport,
    ) -> Result<(), VolumeFault> {
        let center_ecef = self.center_ecef();
        let enclosed = enclosed_volume(&self.triangles, center_ecef);
        let mut prisms = self.prism_volume(positions);
        let diagonals = self.diagonals_volume(positions, report);
        prisms.add(diagonals.sum, diagonals.scale);
        let found_m3 = enclosed.sum;
        let allowed_m3 = PRODUCT_ROUNDING * (enclosed.scale + prisms.scale);
        let difference = (found_m3 - prisms.sum).abs();
        if difference.is_nan() || difference > allowed_m3 {
            return Err(VolumeFault::Volume {
                found_m3,
                expected_m3: prisms.sum,
                allowed_m3,
            });
        }
        report.volume_m3 = found_m3;
        let [least_m3, most_m3] = self.area_times_thickness();
        let least_m3 = least_m3 - allowed_m3;
        let most_m3 = most_m3 + allowed_m3;
        let middle = 0.5 * (least_m3 + most_m3);
        // Which diagonal a wall has is no matter of area.
        let found_m3 = found_m3 - diagonals.sum;
        report.share_of_allowed = ((found_m3 - middle) / (most_m3 - middle)).abs();
        // A volume below 0 is within these only where the area is a rounding.
        if !(least_m3..=most_m3).contains(&found_m3) {
            return Err(VolumeFault::AreaTimesThickness {
                found_m3,
                least_m3,
                most_m3,
            });
        }
        Ok(())
    }

    /// Volume between the caps over each triangle of the mesh, with ruled walls.
    ///
    /// Over one triangle, between corners b and t, `∫ ½ e₁(s) × e₂(s) · w ds` with the edges at the
    /// share s of the way up and w the mean of t − b: a quadratic in s, so Simpson's rule is exact.
    fn prism_volume(&self, positions: &[Option<DVec3>]) -> Terms {
        let copies = |vertex: u32| both_copies(positions, vertex);
        let mut terms = Terms::default();
        for corners in &self.mesh.triangles {
            let [[at, ab], [bt, bb], [ct, cb]] = corners.map(copies);
            let along = ((at - ab) + (bt - bb) + (ct - cb)) / 3.0;
            let twice_area = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a);
            let middle = [(at + ab) * 0.5, (bt + bb) * 0.5, (ct + cb) * 0.5];
            let sections = twice_area(ab, bb, cb)
                + 4.0 * twice_area(middle[0], middle[1], middle[2])
                + twice_area(at, bt, ct);
            let size = (bt - at).length() * (ct - at).length() * along.length();
            terms.add(sections.dot(along) / 12.0, size);
        }
        terms
    }

    /// What the walls' diagonals add to the volume with ruled walls: such a wall lies half-way
    /// between its two diagonals, whose difference is the volume of the tetrahedron of its corners.
    /// A wall and the same wall seen from the other side have different diagonals, and both sides of
    /// a sliver gain, or both lose.
    fn diagonals_volume(&self, positions: &[Option<DVec3>], report: &mut VolumeReport) -> Terms {
        let copies = |vertex: u32| both_copies(positions, vertex);
        let mut terms = Terms::default();
        for [from, to] in ring_edges(self.mesh) {
            let ([top, bottom], [top_end, bottom_end]) = (copies(from), copies(to));
            let (across, up, diagonal) = (top_end - top, bottom - top, bottom_end - top);
            let tetrahedron = across.cross(up).dot(diagonal) / 6.0;
            let size = across.length() * up.length() * diagonal.length();
            terms.add(0.5 * tetrahedron, size);
            let between = diagonal.cross(bottom - top_end).length();
            if between > 0.0 {
                report.wall_twist_m = report.wall_twist_m.max((6.0 * tetrahedron / between).abs());
            }
        }
        terms
    }

    /// Bounds of `A ∫ (1 + h/M)(1 + h/N) dh` over the heights, the principal radii M and N being
    /// between b²/a and a²/b, widened by what flat facets lose and by the band between the rings and
    /// the edges that are drawn for them.
    fn area_times_thickness(&self) -> [f64; 2] {
        let VolumeHeights { top_m, bottom_m } = self.heights;
        let (a, b) = (self.body.equatorial_radius_m(), self.body.polar_radius_m());
        let (smallest, largest) = (b * b / a, a * a / b);
        let swept = |radius: f64, from: f64, to: f64| {
            let cube =
                |height: f64| height * (1.0 + height / radius * (1.0 + height / radius / 3.0));
            cube(to) - cube(from)
        };
        let (below, above) = ([bottom_m, top_m.min(0.0)], [bottom_m.max(0.0), top_m]);
        let bounds = |under: f64, over: f64| {
            let under = if bottom_m < 0.0 {
                swept(under, below[0], below[1])
            } else {
                0.0
            };
            let over = if top_m > 0.0 {
                swept(over, above[0], above[1])
            } else {
                0.0
            };
            under + over
        };
        let least_m = bounds(smallest, largest);
        let most_m = bounds(largest, smallest);
        let area_m2 = self.mesh.area_m2;
        let loss = LARGEST_FACET_LOSS_SAGITTAS * self.mesh.cap_sagitta_m / smallest;
        let beside_m = self.mesh.boundary_deviation_m + ROUNDING * a;
        let band_m3 = self.mesh.boundary_length_m() * beside_m * most_m;
        let size = area_m2.abs();
        [
            area_m2 * least_m - size * loss * most_m - band_m3,
            area_m2 * most_m + PRODUCT_ROUNDING * size * most_m + band_m3,
        ]
    }

    /// Checks the solid with its positions rounded; `round` is what a backend stores of a corner.
    ///
    /// Vertices may fall together. What must hold is that for each pair of different positions the
    /// uses one way equal those the other way, see [`check_closed`].
    ///
    /// # Errors
    /// [`VolumeFault::OpenAfterRounding`].
    pub fn check_rounded(
        &self,
        round: impl Fn(VolumePart, DVec3) -> Vec3,
    ) -> Result<RoundedVolume, VolumeFault> {
        // Adding 0 turns −0 into 0: they are one position.
        let key = |position: Vec3| (position + Vec3::ZERO).to_array().map(f32::to_bits);
        let mut rounded = RoundedVolume::default();
        let mut corners: Vec<[[u32; 3]; 3]> = Vec::with_capacity(self.triangles.len());
        let mut by_vertex: Vec<Option<[u32; 3]>> = vec![None; 2 * self.mesh.vertices_deg.len()];
        for triangle in &self.triangles {
            let stored = triangle
                .corners_ecef
                .map(|corner| round(triangle.part, corner));
            let keys = stored.map(key);
            for (vertex, key) in triangle.vertices.into_iter().zip(keys) {
                by_vertex[vertex as usize].get_or_insert(key);
            }
            if triangle.part != VolumePart::Wall {
                let before = triangle.corners_ecef;
                let [up, now] =
                    [before, stored.map(Vec3::as_dvec3)].map(|[a, b, c]| (b - a).cross(c - a));
                rounded.turned_over += usize::from(up.dot(now) < 0.0);
            }
            corners.push(keys);
        }
        let closed = check_closed(corners).map_err(|open| {
            let triangle = &self.triangles[open.triangle];
            VolumeFault::OpenAfterRounding {
                part: triangle.part,
                triangle: open.triangle,
                at_deg: self.degrees(triangle.vertices[0]),
                uses: open.uses,
                reverse_uses: open.reverse_uses,
            }
        })?;
        rounded.collapsed_triangles = closed.collapsed_triangles;
        let fell =
            |&&vertex: &&u32| by_vertex[2 * vertex as usize] == by_vertex[2 * vertex as usize + 1];
        let on_rings = self.mesh.boundary_loops.iter().flatten();
        rounded.collapsed_columns = on_rings.filter(fell).count();
        let mut positions: Vec<[u32; 3]> = by_vertex.into_iter().flatten().collect();
        rounded.vertices = positions.len();
        positions.sort_unstable();
        positions.dedup();
        rounded.positions = positions.len();
        Ok(rounded)
    }
}

/// Top and bottom.
fn both_copies(positions: &[Option<DVec3>], vertex: u32) -> [DVec3; 2] {
    [2 * vertex, 2 * vertex + 1].map(|copy| positions[copy as usize].unwrap_or(DVec3::NAN))
}

/// A sum, and the sum of the sizes that its terms were rounded at.
#[derive(Debug, Clone, Copy, Default)]
struct Terms {
    sum: f64,
    scale: f64,
}

impl Terms {
    fn add(&mut self, term: f64, size: f64) {
        self.sum += term;
        self.scale += size;
    }
}

/// `⅓ ∮ x · dA` by the divergence theorem, relative to `center_ecef`.
fn enclosed_volume(triangles: &[VolumeTriangle], center_ecef: DVec3) -> Terms {
    let mut terms = Terms::default();
    for triangle in triangles {
        let [a, b, c] = triangle.corners_ecef.map(|corner| corner - center_ecef);
        let (e1, e2) = (b - a, c - a);
        let size = a.length() * e1.length() * e2.length();
        terms.add(a.dot(e1.cross(e2)) / 6.0, size);
    }
    terms
}
