// SPDX-License-Identifier: MIT OR Apache-2.0
//! Footprints that move: rings and meshes with the same vertices and triangles in every frame.
//!
//! A cone whose edge meets the body all round cuts a closed curve out of it. Here that curve is
//! followed in equal steps of the angle about the cone's axis, and the cap is one strip of triangles
//! across it. So the numbers of vertices, edges and triangles depend on nothing but the number of
//! steps, and what was uploaded for one frame is rewritten in place for the next.
//!
//! The general mesher does more: it follows a tolerance, splits edges, and bounds the facets' sagitta
//! by vertices inside. A strip has facets as wide as the footprint, so its top cap is higher
//! ([`RegionMesh::volume_heights`]).

mod cone;
mod cone_edge;
mod error;

use crate::edge::area::{ZoneArea, compensated_sum};
use crate::edge::{Degrees, edge_bounds_m};
use crate::mesh::{sagitta_m, wrapped_deg};
use crate::{EdgeRule, Ellipsoid, Extent, Polygon, Region, RegionMesh, Ring};
use cone::ConeOverBody;
pub use cone::SensorCone;
use cone_edge::faces_inwards;
pub use cone_edge::{ConeEdge, MovingFootprint};
pub use error::FootprintError;
use glam::DVec3;
use std::f64::consts::TAU;
use terrafill_planar::index_u32;

/// A triangle has the fewest; as many as 16-bit indices can name is the most.
const STEPS: std::ops::RangeInclusive<u32> = 3..=65_535;

/// Makes rings and meshes of cones on one body, all with as many vertices.
#[derive(Debug, Clone)]
pub struct FootprintMesher {
    body: Ellipsoid,
    /// Cosine and sine of each step's angle about the axis.
    steps: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
}

/// The closed curve that a cone cuts out of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Footprint {
    /// Counter-clockwise from outside; longitudes run on over ±180.
    vertices_deg: Vec<Degrees>,
    /// Of the same vertices, on the surface.
    vertices_ecef: Vec<DVec3>,
}

impl FootprintMesher {
    /// - `vertices`: of each footprint, 3 … 65,535
    ///
    /// # Errors
    /// [`FootprintError::VertexCount`].
    pub fn new(body: Ellipsoid, vertices: u32) -> Result<Self, FootprintError> {
        if !STEPS.contains(&vertices) {
            return Err(FootprintError::VertexCount {
                found: vertices,
                smallest: *STEPS.start(),
                largest: *STEPS.end(),
            });
        }
        let angle = |step| TAU * f64::from(step) / f64::from(vertices);
        Ok(Self {
            body,
            steps: (0..vertices)
                .map(|step| {
                    let (sin, cos) = angle(step).sin_cos();
                    [cos, sin]
                })
                .collect(),
            triangles: strip(vertices),
        })
    }

    /// Follows the edge of a cone.
    ///
    /// # Errors
    /// [`FootprintError`] for values out of range, a cone that misses the body,
    /// [`FootprintError::NotAllRound`] for one whose edge meets it in part only or that holds a pole.
    pub fn footprint(&self, cone: &SensorCone) -> Result<Footprint, FootprintError> {
        let cone = self.checked(cone)?;
        let vertices_ecef: Vec<DVec3> = self
            .steps
            .iter()
            .map(|&[cos, sin]| cone.hit_towards(cos, sin))
            .collect();
        let mut vertices_deg: Vec<Degrees> = Vec::with_capacity(vertices_ecef.len());
        for ecef in &vertices_ecef {
            let [mut longitude_deg, latitude_deg] = on_surface_deg(&self.body, *ecef);
            if let Some([before, _]) = vertices_deg.last() {
                longitude_deg += 360.0 * ((before - longitude_deg) / 360.0).round();
            }
            vertices_deg.push([longitude_deg, latitude_deg]);
        }
        let ends = vertices_deg.first().zip(vertices_deg.last());
        if ends.is_none_or(|(first, last)| (first[0] - last[0]).abs() > 180.0) {
            return Err(FootprintError::not_all_round(&self.body, "it holds a pole"));
        }
        Ok(Footprint {
            vertices_deg,
            vertices_ecef,
        })
    }

    /// # Errors
    /// As [`FootprintMesher::footprint`], poles aside.
    fn checked(&self, cone: &SensorCone) -> Result<ConeOverBody, FootprintError> {
        cone.check(&self.body)?;
        let cone = ConeOverBody::new(&self.body, cone);
        cone.check_all_round(&self.body)?;
        Ok(cone)
    }

    /// The edge of a cone for a device that makes the vertices itself, from [`FootprintMesher::disc`].
    ///
    /// # Errors
    /// As [`FootprintMesher::footprint`], and as [`FootprintMesher::mesh`]; a footprint may hold a pole.
    pub fn moving(&self, cone: &SensorCone) -> Result<MovingFootprint, FootprintError> {
        let edge = self.checked(cone)?.edge();
        MovingFootprint::new(&self.body, edge, &self.steps, &self.triangles)
    }

    /// The mesh that a device bends into any footprint: vertices, triangles and boundary as of
    /// [`FootprintMesher::mesh`], but a vertex's position is `(cos, sin, 0)` of its angle about the
    /// axis. It lies on no body.
    ///
    /// - `index`: [`RegionMesh::region_index`]
    #[must_use]
    pub fn disc(&self, name: impl Into<String>, index: usize) -> RegionMesh {
        let vertices = self.steps.iter();
        RegionMesh {
            region_index: index,
            name: name.into(),
            vertices_ecef: vertices.map(|&[x, y]| DVec3::new(x, y, 0.0)).collect(),
            vertices_deg: vec![[0.0; 2]; self.steps.len()],
            triangles: self.triangles.clone(),
            boundary_loops: vec![(0..self.steps.len()).map(index_u32).collect()],
            ..RegionMesh::without_geometry()
        }
    }

    /// Cosine and sine of each vertex's angle about the axis.
    #[must_use]
    pub fn steps(&self) -> &[[f64; 2]] {
        &self.steps
    }

    /// The footprint as a region, for whoever reads rings.
    #[must_use]
    pub fn region(&self, name: impl Into<String>, footprint: &Footprint) -> Region {
        Region {
            name: name.into(),
            polygons: vec![Polygon {
                shell: Ring::from_checked(footprint.vertices_deg.clone(), 0.0),
                holes: Vec::new(),
            }],
            ..Region::default()
        }
    }

    /// The footprint as a strip of triangles, to be drawn.
    ///
    /// - `index`: [`RegionMesh::region_index`]
    /// - `rule`: what the ring's edges are; [`RegionMesh::boundary_deviation_m`] is an upper bound here
    ///
    /// # Errors
    /// [`FootprintError::Folded`] where a facet faces inwards.
    pub fn mesh(
        &self,
        name: impl Into<String>,
        index: usize,
        footprint: Footprint,
        rule: EdgeRule,
    ) -> Result<RegionMesh, FootprintError> {
        let body = &self.body;
        let Footprint {
            vertices_deg,
            vertices_ecef,
        } = footprint;
        let triangles = self.triangles.iter();
        let facets = triangles.map(|triangle| triangle.map(|i| vertices_ecef[i as usize]));
        if facets.clone().any(faces_inwards) {
            return Err(FootprintError::Folded { body: body.name() });
        }
        let cap_sagitta_m = sagitta_m(body, facets);
        let edges = || {
            let next = vertices_deg.iter().cycle().skip(1);
            vertices_deg.iter().zip(next)
        };
        let deviation = |(from, to): (&Degrees, &Degrees)| edge_bounds_m(body, rule, *from, *to)[1];
        let boundary_deviation_m = edges().map(deviation).fold(0.0, f64::max);
        let reference_deg = vertices_deg.first().map_or(0.0, |vertex| vertex[1]);
        let zone = ZoneArea::new(body, reference_deg);
        let under = edges().map(|(from, to)| zone.under_edge(rule, *from, *to));
        let area_m2 = -compensated_sum(under);
        let extent = extent(&vertices_deg);
        let wrapped =
            |[longitude_deg, latitude_deg]: Degrees| [wrapped_deg(longitude_deg), latitude_deg];
        Ok(RegionMesh {
            region_index: index,
            name: name.into(),
            triangles: self.triangles.clone(),
            boundary_loops: vec![(0..vertices_ecef.len()).map(index_u32).collect()],
            vertices_deg: vertices_deg.into_iter().map(wrapped).collect(),
            vertices_ecef,
            area_m2,
            extent,
            boundary_deviation_m,
            cap_sagitta_m,
            ..RegionMesh::without_geometry()
        })
    }
}

/// Triangles across a convex ring, from side to side: (0, 1, n−1), (1, 2, n−1), (2, n−2, n−1) …
fn strip(vertices: u32) -> Vec<[u32; 3]> {
    let (mut low, mut high) = (0, vertices - 1);
    let mut triangles = Vec::new();
    while low + 1 < high {
        triangles.push([low, low + 1, high]);
        low += 1;
        if low + 1 < high {
            triangles.push([low, high - 1, high]);
            high -= 1;
        }
    }
    triangles
}

/// Geodetic longitude and latitude of a point of the surface: its normal is `p / radii²`.
fn on_surface_deg(body: &Ellipsoid, ecef: DVec3) -> Degrees {
    let radii_m = body.radii_m();
    let normal = ecef / (radii_m * radii_m);
    let latitude_rad = normal.z.atan2(normal.x.hypot(normal.y));
    let longitude_rad = normal.y.atan2(normal.x);
    [longitude_rad.to_degrees(), latitude_rad.to_degrees()]
}

fn extent(vertices_deg: &[Degrees]) -> Extent {
    let along = |axis: usize| {
        let values = vertices_deg.iter().map(move |vertex| vertex[axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        (low, values.fold(f64::NEG_INFINITY, f64::max))
    };
    let ((west, east), (south_deg, north_deg)) = (along(0), along(1));
    Extent {
        west_deg: wrapped_deg(west),
        south_deg,
        east_deg: wrapped_deg(east),
        north_deg,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Geodetic, MeshOptions};

    fn cone(longitude_deg: f64, latitude_deg: f64, half_angle_deg: f64) -> SensorCone {
        SensorCone {
            apex: Geodetic::from_degrees(longitude_deg, latitude_deg, 700_000.0),
            azimuth_rad: 1.0,
            elevation_rad: -70_f64.to_radians(),
            half_angle_rad: half_angle_deg.to_radians(),
        }
    }

    fn mesher(vertices: u32) -> FootprintMesher {
        FootprintMesher::new(Ellipsoid::WGS84, vertices).expect("allowed")
    }

    fn meshed(vertices: u32, cone: &SensorCone) -> RegionMesh {
        let mesher = mesher(vertices);
        let footprint = mesher.footprint(cone).expect("all round");
        let mesh = mesher.mesh("cone", 7, footprint, EdgeRule::Planar);
        mesh.expect("unfolded")
    }

    #[test]
    fn a_strip_has_the_area_extent_and_boundary_that_the_general_mesher_finds() {
        let body = Ellipsoid::WGS84;
        for (longitude_deg, latitude_deg) in [(15.0, 20.0), (179.0, -40.0), (-100.0, 65.0)] {
            let cone = cone(longitude_deg, latitude_deg, 15.0);
            let mesher = mesher(256);
            let footprint = mesher.footprint(&cone).expect("all round");
            let region = mesher.region("cone", &footprint);
            let strip = mesher.mesh("cone", 0, footprint, EdgeRule::Planar);
            let strip = strip.expect("unfolded");
            let options = MeshOptions::default();
            let general = RegionMesh::build(&region, &body, EdgeRule::Planar, &options);
            let general = general.expect("a plain ring");
            let off = strip.area_m2 / general.area_m2 - 1.0;
            assert!(off.abs() < 1e-12, "{off}");
            let sides = |mesh: &RegionMesh| {
                let Extent {
                    west_deg,
                    south_deg,
                    east_deg,
                    north_deg,
                } = mesh.extent;
                [west_deg, south_deg, east_deg, north_deg]
            };
            for (a, b) in sides(&strip).into_iter().zip(sides(&general)) {
                assert!((a - b).abs() < 1e-9, "{a} {b}");
            }
            assert!(strip.boundary_deviation_m < 100.0);
            assert_eq!(strip.triangle_count(), 254);
            assert_eq!(strip.boundary_edge_count(), 256);
            // Wider facets hang deeper: that is the price.
            assert!(strip.cap_sagitta_m > general.cap_sagitta_m);
        }
    }

    #[test]
    fn numbers_stay_while_the_footprint_moves() {
        let still = meshed(64, &cone(0.0, 0.0, 10.0));
        let moved = meshed(64, &cone(3.0, 1.0, 12.0));
        assert_eq!(still.triangles, moved.triangles);
        assert_eq!(still.boundary_loops, moved.boundary_loops);
        assert_ne!(still.vertices_ecef, moved.vertices_ecef);
    }

    #[test]
    fn what_is_no_closed_curve_is_refused_with_its_reason() {
        let refused = |cone: &SensorCone| {
            let found = mesher(64).footprint(cone).expect_err("refused");
            found.to_string()
        };
        let over_horizon = SensorCone {
            elevation_rad: -25_f64.to_radians(),
            ..cone(0.0, 0.0, 10.0)
        };
        assert!(refused(&over_horizon).contains("the horizon cuts it off"));
        let past = SensorCone {
            elevation_rad: 10_f64.to_radians(),
            ..cone(0.0, 0.0, 10.0)
        };
        assert!(refused(&past).contains("misses"));
        let polar = SensorCone {
            elevation_rad: -90_f64.to_radians(),
            ..cone(0.0, 89.0, 20.0)
        };
        assert!(refused(&polar).contains("holds a pole"));
        let blunt = SensorCone {
            half_angle_rad: 2.0,
            ..cone(0.0, 0.0, 10.0)
        };
        assert!(refused(&blunt).contains("half angle"));
        for vertices in [0, 2, 65_536] {
            let found = FootprintMesher::new(Ellipsoid::WGS84, vertices).expect_err("refused");
            assert!(found.to_string().contains("3 … 65535"), "{found}");
        }
        // Negative control.
        assert!(mesher(64).footprint(&cone(0.0, 0.0, 10.0)).is_ok());
    }

    #[test]
    fn a_facet_that_faces_inwards_is_noticed() {
        let mesher = mesher(64);
        let mut footprint = mesher.footprint(&cone(0.0, 0.0, 10.0)).expect("all round");
        footprint.vertices_ecef.reverse();
        let folded = mesher.mesh("cone", 0, footprint, EdgeRule::Planar);
        assert!(matches!(folded, Err(FootprintError::Folded { .. })));
    }
}
