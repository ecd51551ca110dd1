// SPDX-License-Identifier: MIT OR Apache-2.0
//! What must hold for every mesh, checked by other means than those that built it.
//!
//! Closed: each edge of a triangle meets its reverse in another triangle or a boundary loop, so the
//! extruded volume is watertight. Right side up: no triangle is turned over. Right size: the
//! triangles add up to the exact area of the rings.

use crate::edge::area::ZoneArea;
use crate::edge::{Degrees, normal, surface_point};
use crate::triangulate::WIDEST_INTERIOR_EDGE_DEG;
use crate::{EdgeRule, Ellipsoid, RegionMesh};
use terrafill_planar::intersection::orient;

/// Relative difference allowed between the triangles' area and the rings', from rounding alone.
const AREA_TOLERANCE: f64 = 1e-9;

/// A promise of [`RegionMesh`] that a mesh breaks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InvariantViolation {
    /// An index past the vertices, or vertex lists of different lengths.
    #[error("vertex index {found} is out of range; there are {allowed} vertices")]
    Index {
        /// The index, or the length of the second list.
        found: usize,
        /// Number of vertices.
        allowed: usize,
    },
    /// ECEF and degrees disagree.
    #[error("vertex {vertex} is {found_m} m from its place on the surface; allowed is {allowed_m}")]
    OffSurface {
        /// Index of the vertex.
        vertex: u32,
        /// Distance found.
        found_m: f64,
        /// Distance allowed.
        allowed_m: f64,
    },
    /// Two corners of a triangle or two neighbours of a loop are the same vertex, or three corners
    /// are on one line.
    #[error("triangle or loop edge {corners:?} is degenerate")]
    Degenerate {
        /// Vertex indices.
        corners: Vec<u32>,
    },
    /// A triangle shows its back.
    #[error(
        "triangle {triangle} is turned over: height {found_m} m over its longest edge; at least \
         {allowed_m} is allowed"
    )]
    Inverted {
        /// Its index.
        triangle: usize,
        /// Signed height of the third corner.
        found_m: f64,
        /// What the bow of planar edges can explain.
        allowed_m: f64,
    },
    /// A directed edge occurs more or less often than its reverse and the loops explain.
    #[error(
        "edge {from} → {to} is used {uses} times, its reverse {reverse_uses} times, and {loop_uses} \
         times by a boundary loop"
    )]
    OpenEdge {
        /// Start.
        from: u32,
        /// End.
        to: u32,
        /// By triangles.
        uses: usize,
        /// By triangles, the other way.
        reverse_uses: usize,
        /// By boundary loops.
        loop_uses: usize,
    },
    /// The triangles cover another area than the rings enclose.
    #[error(
        "triangles cover {found_m2} m², the rings enclose {expected_m2} m²; allowed difference {allowed_m2}"
    )]
    Area {
        /// Sum over the triangles.
        found_m2: f64,
        /// [`RegionMesh::area_m2`].
        expected_m2: f64,
        /// Difference allowed.
        allowed_m2: f64,
    },
}

impl RegionMesh {
    /// Checks that the mesh is closed, right side up and of the right size.
    ///
    /// Curved edges are drawn straight: in ECEF a triangle may be turned over by as much as its
    /// edges bow on the body, which happens where three vertices lie almost on one planar edge.
    /// Caps lie above and below all terrain, so that moves no pixel.
    ///
    /// # Errors
    /// The first [`InvariantViolation`] found.
    pub fn check_invariants(&self, body: &Ellipsoid) -> Result<(), InvariantViolation> {
        self.check_vertices(body)?;
        self.check_edges()?;
        self.check_triangles(body)?;
        self.check_area(body)
    }

    fn check_vertices(&self, body: &Ellipsoid) -> Result<(), InvariantViolation> {
        let count = self.vertices_ecef.len();
        if self.vertices_deg.len() != count {
            return Err(InvariantViolation::Index {
                found: self.vertices_deg.len(),
                allowed: count,
            });
        }
        let allowed_m = 1e-14 * body.equatorial_radius_m();
        for (vertex, (ecef, degrees)) in
            (0..).zip(self.vertices_ecef.iter().zip(&self.vertices_deg))
        {
            let found_m = (*ecef - surface_point(body, *degrees)).length();
            let in_range = degrees[0].abs() <= 180.0 && degrees[1].abs() <= 90.0;
            if !(in_range && found_m <= allowed_m) {
                return Err(InvariantViolation::OffSurface {
                    vertex,
                    found_m,
                    allowed_m,
                });
            }
        }
        let used = self.triangles.iter().flatten();
        for &index in used.chain(self.boundary_loops.iter().flatten()) {
            if index as usize >= count {
                return Err(InvariantViolation::Index {
                    found: index as usize,
                    allowed: count,
                });
            }
        }
        Ok(())
    }

    fn check_edges(&self) -> Result<(), InvariantViolation> {
        // Lower index, higher index, downwards?, boundary loop?
        let mut uses: Vec<(u32, u32, bool, bool)> =
            Vec::with_capacity(3 * self.triangles.len() + self.boundary_edge_count());
        for triangle in &self.triangles {
            add_cycle(triangle, false, &mut uses)?;
        }
        for ring in &self.boundary_loops {
            if ring.len() < 2 {
                let corners = ring.clone();
                return Err(InvariantViolation::Degenerate { corners });
            }
            add_cycle(ring, true, &mut uses)?;
        }
        uses.sort_unstable();
        for same in uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let count = |down: bool, in_loop: bool| {
                same.iter()
                    .filter(|use_| (use_.2, use_.3) == (down, in_loop))
                    .count()
            };
            let (up, down) = (count(false, false), count(true, false));
            let (loop_up, loop_down) = (count(false, true), count(true, true));
            // Pieces that meet at a pole may share an edge to it more than once: all their ends
            // there are one vertex.
            let most = if [same[0].0, same[0].1]
                .iter()
                .any(|&i| self.vertices_deg[i as usize][1].abs() == 90.0)
            {
                usize::MAX
            } else {
                1
            };
            // A loop runs the same way as the triangle inside it.
            let balanced = up + loop_down == down + loop_up;
            let single = up <= most && down <= most && (loop_up == 0 || loop_down == 0);
            if !(balanced && single && loop_up <= up && loop_down <= down) {
                return Err(InvariantViolation::OpenEdge {
                    from: same[0].0,
                    to: same[0].1,
                    uses: up,
                    reverse_uses: down,
                    loop_uses: loop_up + loop_down,
                });
            }
        }
        Ok(())
    }

    fn check_triangles(&self, body: &Ellipsoid) -> Result<(), InvariantViolation> {
        for (index, triangle) in self.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|i| self.vertices_ecef[i as usize]);
            let middle = body.ecef_to_geodetic((a + b + c) / 3.0);
            let up = body.geodetic_surface_normal(middle.longitude_rad, middle.latitude_rad);
            let cross = (b - a).cross(c - a);
            if self.is_degenerate(*triangle) {
                return Err(InvariantViolation::Degenerate {
                    corners: triangle.to_vec(),
                });
            }
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let found_m = cross.dot(up) / longest;
            if found_m > 0.0 {
                continue;
            }
            let bows: f64 = [0, 1, 2]
                .map(|k| self.planar_bow_m(body, triangle[k], triangle[(k + 1) % 3]))
                .iter()
                .sum();
            let allowed_m = -bows - 1e-14 * body.equatorial_radius_m();
            if found_m < allowed_m {
                return Err(InvariantViolation::Inverted {
                    triangle: index,
                    found_m,
                    allowed_m,
                });
            }
        }
        Ok(())
    }

    /// Whether the corners are on one line in longitude and latitude, exactly. On the body a sliver
    /// may be flat to the last bit, and a facet between two lines towards a pole is: the volume
    /// needs it to be closed.
    #[must_use]
    pub fn is_degenerate(&self, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|i| self.vertices_deg[i as usize]);
        if [a, b, c].iter().any(|corner| corner[1].abs() == 90.0) {
            return false;
        }
        // Longitudes taken over the antimeridian are rounded, and the question is about the last bit.
        let unrolled = (b[0] - a[0]).abs() > 180.0 || (c[0] - a[0]).abs() > 180.0;
        !unrolled && orient(a, b, c) == 0.0
    }

    /// Largest distance between an edge that is straight in longitude and latitude and the plane
    /// through its ends and the normal in its middle. Over tens of degrees of latitude the bow is
    /// deepest elsewhere than in the middle, so it is looked for at seven places.
    #[must_use]
    pub fn planar_bow_m(&self, body: &Ellipsoid, from: u32, to: u32) -> f64 {
        let [start, end] = [from, to].map(|i| self.vertices_deg[i as usize]);
        if start[1].abs() == 90.0 || end[1].abs() == 90.0 {
            // Meshed towards some longitude at the pole, up to the widest edge away from its
            // other end's, and drawn as a meridian: the bow of a line is Δλ · length / 4.
            let chord = self.vertices_ecef[to as usize] - self.vertices_ecef[from as usize];
            return 0.25 * WIDEST_INTERIOR_EDGE_DEG.to_radians() * chord.length();
        }
        let step = short_step(start[0], end[0]);
        let point = |eighths: u32| {
            let share = f64::from(eighths) / 8.0;
            let latitude = start[1] + share * (end[1] - start[1]);
            [start[0] + share * step, latitude]
        };
        let a = self.vertices_ecef[from as usize];
        let chord = self.vertices_ecef[to as usize] - a;
        let wall = chord.cross(normal(point(4))).normalize_or_zero();
        (1..8)
            .map(|eighths| wall.dot(surface_point(body, point(eighths)) - a).abs())
            .fold(0.0, f64::max)
    }

    fn check_area(&self, body: &Ellipsoid) -> Result<(), InvariantViolation> {
        let reference_deg = self.vertices_deg.first().map_or(0.0, |vertex| vertex[1]);
        let zone = ZoneArea::new(body, reference_deg);
        let mut found_m2 = 0.0;
        let mut scale_m2 = 0.0;
        for triangle in &self.triangles {
            let (area, terms) = self.planar_triangle_area(&zone, *triangle);
            found_m2 += area;
            scale_m2 += terms;
        }
        // Where edges follow great ellipses the triangles stand on their chords in longitude and
        // latitude; what lies between chord and arc is known exactly.
        let mut segments_m2 = 0.0;
        for ring in &self.boundary_loops {
            for (from, to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let [start, end] = [from, to].map(|i| self.vertices_deg[*i as usize]);
                if start[1].abs() < 90.0 && end[1].abs() < 90.0 {
                    let end = [start[0] + short_step(start[0], end[0]), end[1]];
                    segments_m2 += zone.under_edge(EdgeRule::Planar, start, end)
                        - zone.under_edge(EdgeRule::GreatEllipse, start, end);
                }
            }
        }
        let expected_m2 = self.area_m2;
        let rounding_m2 = 1e-14 * body.equatorial_radius_m() * self.boundary_length_m();
        let allowed_m2 = AREA_TOLERANCE * expected_m2 + 1e-14 * scale_m2 + rounding_m2;
        let planar = (found_m2 - expected_m2).abs();
        let great_ellipse = (found_m2 + segments_m2 - expected_m2).abs();
        if planar.min(great_ellipse) <= allowed_m2 {
            Ok(())
        } else {
            Err(InvariantViolation::Area {
                found_m2,
                expected_m2,
                allowed_m2,
            })
        }
    }

    /// Length of all boundary edges as drawn, metres.
    #[must_use]
    pub fn boundary_length_m(&self) -> f64 {
        let length = |ring: &Vec<u32>| -> f64 {
            let next = ring.iter().cycle().skip(1);
            ring.iter()
                .zip(next)
                .map(|(a, b)| {
                    let [a, b] = [a, b].map(|i| self.vertices_ecef[*i as usize]);
                    (b - a).length()
                })
                .sum()
        };
        self.boundary_loops.iter().map(length).sum()
    }

    /// Area of a triangle whose edges are straight in longitude and latitude, exact, and the sum of
    /// its terms' sizes. A corner at a pole has every longitude: the sides there are meridians.
    fn planar_triangle_area(&self, zone: &ZoneArea, triangle: [u32; 3]) -> (f64, f64) {
        let corners = triangle.map(|i| self.vertices_deg[i as usize]);
        let pole = corners.iter().position(|corner| corner[1].abs() == 90.0);
        let mut ring: Vec<Degrees> = Vec::with_capacity(4);
        if let Some(k) = pole {
            let (pole, from, to) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
            let to = [from[0] + short_step(from[0], to[0]), to[1]];
            ring.extend([from, to, [to[0], pole[1]], [from[0], pole[1]]]);
        } else {
            let [a, b, c] = corners;
            let b = [a[0] + short_step(a[0], b[0]), b[1]];
            let c = [a[0] + short_step(a[0], c[0]), c[1]];
            ring.extend([a, b, c]);
        }
        let mut area = 0.0;
        let mut terms = 0.0;
        for (start, end) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let term = zone.under_edge(EdgeRule::Planar, *start, *end);
            area -= term;
            terms += term.abs();
        }
        (area, terms)
    }
}

/// Difference of two longitudes, the short way; no edge of a mesh spans 180°.
fn short_step(from_deg: f64, to_deg: f64) -> f64 {
    let step = to_deg - from_deg;
    step - 360.0 * (step / 360.0).round()
}

fn add_cycle(
    cycle: &[u32],
    in_loop: bool,
    uses: &mut Vec<(u32, u32, bool, bool)>,
) -> Result<(), InvariantViolation> {
    for (&from, &to) in cycle.iter().zip(cycle.iter().cycle().skip(1)) {
        if from == to {
            let corners = cycle.to_vec();
            return Err(InvariantViolation::Degenerate { corners });
        }
        uses.push((from.min(to), from.max(to), from > to, in_loop));
    }
    Ok(())
}
