// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions given by a formula: circles, ellipses and sectors of geodesic distance, and what a
//! sensor's cone covers.
//!
//! They come out as ordinary rings whose edges are *planar*, straight in longitude and latitude
//! ([`AnalyticRegion::EDGE_RULE`]). That rule alone can write regions that hold both poles or more
//! than a hemisphere, and its edges have no opposite ends to stumble over. Angles in radians,
//! lengths in metres; bearings clockwise from north. At a pole north is the direction that a
//! meridian of the centre's own longitude has there.
//!
//! Distances are geodesic, by [`geodesic`]; the cone's footprint is closed form, see [`cone`]; the
//! polyline is subdivided until it is as near as asked for, see [`boundary`].

mod boundary;
mod cone;
mod cone_edge;
mod footprint;
mod geodesic;

use crate::{EdgeRule, Ellipsoid, Geodetic, Inside, Region};
use boundary::{Band, Boundary, Curve, Leg, pieces_of_turn};
pub use cone::SensorCone;
use cone::Sight;
pub use cone_edge::{ConeEdge, MovingFootprint};
pub use footprint::{Footprint, FootprintMesher};
use geodesic::{Geodesic, shortest_cut_m};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Smallest radius or width, as a share of the equatorial radius: 6 mm on the Earth, a million
/// times the rounding of degrees.
const SMALLEST_SHARE: f64 = 1e-9;
/// Finest tolerance, as a share of the equatorial radius: 64 µm on the Earth, which takes a large
/// circle a million vertices.
const FINEST_SHARE: f64 = 1e-11;
/// Sweeps this close to a whole turn are one: 360° in radians, less 0°, is rounded.
const WHOLE_TURN_ROUNDING_RAD: f64 = 1e-12;
/// Pieces of a geodesic that are measured at least.
const RADIAL_PIECES: u32 = 4;

/// A region made from a formula, and how far its rings are from it.
#[derive(Debug, Clone, PartialEq)]
pub struct AnalyticRegion {
    /// Rings of planar edges.
    pub region: Region,
    /// Largest distance between an edge by [`AnalyticRegion::EDGE_RULE`] and the true curve,
    /// metres, straight, both ways; an upper bound. [`RegionMesh`](crate::RegionMesh) adds its own
    /// `boundary_deviation_m`.
    pub deviation_m: f64,
}

impl AnalyticRegion {
    /// What the edges between the vertices are.
    pub const EDGE_RULE: EdgeRule = EdgeRule::Planar;
}

/// An ellipse in geodesic polar coordinates: at each bearing from the centre the distance of a
/// plane ellipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceEllipse {
    /// Its height plays no part.
    pub center: Geodetic,
    /// Metres along the surface.
    pub semi_major_m: f64,
    /// Metres along the surface.
    pub semi_minor_m: f64,
    /// Of the major axis, clockwise from north.
    pub bearing_rad: f64,
}

/// What lies between two distances and two bearings from a centre; clockwise from start to end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeodesicSector {
    /// Its height plays no part.
    pub center: Geodetic,
    /// Metres along the surface; 0 for one with its tip at the centre.
    pub inner_radius_m: f64,
    /// Metres along the surface.
    pub outer_radius_m: f64,
    /// Within ±2π.
    pub start_bearing_rad: f64,
    /// Within ±2π. Whole turns do not count, except that an end a whole turn from the start means
    /// all round.
    pub end_bearing_rad: f64,
}

/// Why there is no region by a formula.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AnalyticError {
    /// An angle out of its range; most often in degrees.
    #[error("{parameter} is {found} rad; allowed is {smallest} … {largest}")]
    Angle {
        /// Its name.
        parameter: &'static str,
        /// Its value.
        found: f64,
        /// Smallest value allowed.
        smallest: f64,
        /// Largest value allowed.
        largest: f64,
    },
    /// A length out of its range.
    #[error("{parameter} is {found_m} m; allowed on {body} is {smallest_m} … {largest_m}")]
    Length {
        /// Its name.
        parameter: &'static str,
        /// Name of the body.
        body: &'static str,
        /// Its value.
        found_m: f64,
        /// Smallest value allowed.
        smallest_m: f64,
        /// Largest value allowed.
        largest_m: f64,
    },
    /// A circle that would run into itself on the other side of the body.
    #[error(
        "{parameter} is {found_m} m; from {largest_m} m on the geodesics from this centre meet again \
         on the other side of {body}"
    )]
    BeyondCut {
        /// Its name.
        parameter: &'static str,
        /// Name of the body.
        body: &'static str,
        /// Its value.
        found_m: f64,
        /// Radii have to be smaller.
        largest_m: f64,
    },
    /// A sensor on or in the body.
    #[error("the apex is at a height of {found_m} m; allowed is {smallest_m} and more")]
    ApexInside {
        /// Height of the apex.
        found_m: f64,
        /// Smallest height allowed.
        smallest_m: f64,
    },
    /// A cone that points past the body.
    #[error(
        "the cone misses {body}: its axis is {found_deg:.4}° from the horizon, its half angle is \
         {half_angle_deg:.4}°"
    )]
    Misses {
        /// Name of the body.
        body: &'static str,
        /// Smallest angle between axis and horizon.
        found_deg: f64,
        /// Would have to be larger.
        half_angle_deg: f64,
    },
    /// A footprint that is no single closed curve with as many vertices as asked for.
    #[error("the cone's edge cannot be followed all round on {body}: {why}")]
    NotAllRound {
        /// Name of the body.
        body: &'static str,
        /// What is in the way.
        why: &'static str,
    },
    /// A footprint so wide that facets across it face inwards.
    #[error("a facet across the footprint faces inwards on {body}")]
    Folded {
        /// Name of the body.
        body: &'static str,
    },
    /// Too few or too many vertices.
    #[error("{found} vertices; allowed are {smallest} … {largest}")]
    VertexCount {
        /// How many.
        found: u32,
        /// Fewest allowed.
        smallest: u32,
        /// Most allowed.
        largest: u32,
    },
    /// A shape without width.
    #[error("the shape is {found_m:.3e} m wide; allowed on {body} is {smallest_m:.3e} and more")]
    TooNarrow {
        /// Name of the body.
        body: &'static str,
        /// Area over length.
        found_m: f64,
        /// Smallest width allowed.
        smallest_m: f64,
    },
}

impl Region {
    /// Everything within a geodesic distance of a centre.
    ///
    /// - `center`: its height plays no part
    /// - `radius_m`: may exceed a quarter of the circumference, up to where geodesics meet again
    /// - `tolerance_m`: largest distance between the ring's planar edges and the circle
    ///
    /// # Errors
    /// [`AnalyticError`] for values out of range.
    pub fn circle(
        name: impl Into<String>,
        body: &Ellipsoid,
        center: Geodetic,
        radius_m: f64,
        tolerance_m: f64,
    ) -> Result<AnalyticRegion, AnalyticError> {
        check_center(center)?;
        check_radius(body, center, "radius", radius_m)?;
        let circle = move |t: f64| Geodesic::new(body, center, TAU * t).at(radius_m);
        let bands = vec![Band {
            curves: vec![Box::new(circle)],
            pieces: pieces_of_turn(TAU),
        }];
        let rings = vec![vec![backwards(0, 0)]];
        finish(name, body, &Boundary { bands, rings }, tolerance_m)
    }

    /// Everything within an ellipse of geodesic distance.
    ///
    /// - `tolerance_m`: largest distance between the ring's planar edges and the ellipse
    ///
    /// # Errors
    /// [`AnalyticError`] for values out of range.
    pub fn ellipse(
        name: impl Into<String>,
        body: &Ellipsoid,
        ellipse: &SurfaceEllipse,
        tolerance_m: f64,
    ) -> Result<AnalyticRegion, AnalyticError> {
        let SurfaceEllipse {
            center,
            semi_major_m,
            semi_minor_m,
            bearing_rad,
        } = *ellipse;
        check_center(center)?;
        check_angle("bearing", bearing_rad, TAU)?;
        check_radius(body, center, "semi-major axis", semi_major_m)?;
        let smallest_m = SMALLEST_SHARE * body.equatorial_radius_m();
        let range = smallest_m..=semi_major_m;
        check_length(body, "semi-minor axis", semi_minor_m, range)?;
        // By the eccentric anomaly: by the bearing nearly all of a thin ellipse lies in two spots.
        let curve = move |t: f64| {
            let (sin, cos) = (TAU * t).sin_cos();
            let (along, across) = (semi_major_m * cos, semi_minor_m * sin);
            let azimuth_rad = bearing_rad + across.atan2(along);
            Geodesic::new(body, center, azimuth_rad).at(along.hypot(across))
        };
        let bands = vec![Band {
            curves: vec![Box::new(curve)],
            pieces: pieces_of_turn(TAU),
        }];
        let rings = vec![vec![backwards(0, 0)]];
        finish(name, body, &Boundary { bands, rings }, tolerance_m)
    }

    /// Everything between two geodesic distances and two bearings.
    ///
    /// - `tolerance_m`: largest distance between the rings' planar edges and the outline
    ///
    /// # Errors
    /// [`AnalyticError`] for values out of range.
    pub fn geodesic_sector(
        name: impl Into<String>,
        body: &Ellipsoid,
        sector: &GeodesicSector,
        tolerance_m: f64,
    ) -> Result<AnalyticRegion, AnalyticError> {
        let GeodesicSector {
            center,
            inner_radius_m,
            outer_radius_m,
            start_bearing_rad,
            end_bearing_rad,
        } = *sector;
        check_center(center)?;
        check_angle("start bearing", start_bearing_rad, TAU)?;
        check_angle("end bearing", end_bearing_rad, TAU)?;
        check_radius(body, center, "outer radius", outer_radius_m)?;
        if inner_radius_m != 0.0 {
            check_radius(body, center, "inner radius", inner_radius_m)?;
        }
        check_length(body, "inner radius", inner_radius_m, 0.0..=outer_radius_m)?;
        let Some(sweep_rad) = sweep_rad(start_bearing_rad, end_bearing_rad) else {
            // Sides without a width: no sector, see finish for others as bad.
            return Err(too_narrow(body, 0.0));
        };
        let has_hole = inner_radius_m > 0.0;
        let arc = |radius_m: f64| -> Curve<'_> {
            Box::new(move |t: f64| {
                Geodesic::new(body, center, start_bearing_rad + sweep_rad * t).at(radius_m)
            })
        };
        let mut arcs = Band {
            curves: vec![arc(outer_radius_m)],
            pieces: pieces_of_turn(sweep_rad),
        };
        if has_hole {
            arcs.curves.push(arc(inner_radius_m));
        }
        if sweep_rad >= TAU {
            let mut rings = vec![vec![backwards(0, 0)]];
            if has_hole {
                rings.push(vec![forwards(0, 1)]);
            }
            let bands = vec![arcs];
            return finish(name, body, &Boundary { bands, rings }, tolerance_m);
        }
        let radial = |bearing_rad: f64| -> Curve<'_> {
            let geodesic = Geodesic::new(body, center, bearing_rad);
            let length_m = outer_radius_m - inner_radius_m;
            Box::new(move |t: f64| geodesic.at(inner_radius_m + length_m * t))
        };
        let radials = Band {
            curves: vec![
                radial(start_bearing_rad),
                radial(start_bearing_rad + sweep_rad),
            ],
            pieces: RADIAL_PIECES,
        };
        let mut ring = vec![forwards(1, 1), backwards(0, 0), backwards(1, 0)];
        if has_hole {
            ring.push(forwards(0, 1));
        }
        let (bands, rings) = (vec![arcs, radials], vec![ring]);
        finish(name, body, &Boundary { bands, rings }, tolerance_m)
    }

    /// What a sensor sees of the surface at height 0: the part within its cone that the body itself
    /// does not hide.
    ///
    /// - `tolerance_m`: largest distance between the ring's planar edges and the outline
    ///
    /// # Errors
    /// [`AnalyticError`] for values out of range, an apex that is not above the surface, or a cone
    /// that misses the body.
    pub fn cone_footprint(
        name: impl Into<String>,
        body: &Ellipsoid,
        cone: &SensorCone,
        tolerance_m: f64,
    ) -> Result<AnalyticRegion, AnalyticError> {
        check_cone(body, cone)?;
        let sight = Sight::new(body, cone);
        let boundary = sight.boundary(body).ok_or_else(|| misses(body, &sight))?;
        finish(name, body, &boundary, tolerance_m)
    }
}

fn forwards(band: usize, curve: usize) -> Leg {
    Leg {
        band,
        curve,
        reversed: false,
    }
}

/// Bearings grow clockwise, rings go counter-clockwise.
fn backwards(band: usize, curve: usize) -> Leg {
    Leg {
        band,
        curve,
        reversed: true,
    }
}

/// Clockwise from start to end, up to a whole turn; `None` when they are the same.
fn sweep_rad(start_rad: f64, end_rad: f64) -> Option<f64> {
    let step = end_rad - start_rad;
    let over = step.rem_euclid(TAU);
    let whole = over.min(TAU - over) < WHOLE_TURN_ROUNDING_RAD;
    if whole && step.abs() > PI {
        Some(TAU)
    } else if over > 0.0 {
        Some(over)
    } else {
        None
    }
}

fn finish(
    name: impl Into<String>,
    body: &Ellipsoid,
    boundary: &Boundary<'_>,
    tolerance_m: f64,
) -> Result<AnalyticRegion, AnalyticError> {
    let finest_m = FINEST_SHARE * body.equatorial_radius_m();
    check_length(body, "tolerance", tolerance_m, finest_m..=f64::MAX)?;
    let narrowest_m = boundary.narrowest_m(body);
    if narrowest_m < SMALLEST_SHARE * body.equatorial_radius_m() {
        return Err(too_narrow(body, narrowest_m));
    }
    let traced = boundary.trace(body, tolerance_m);
    Ok(AnalyticRegion {
        region: Region {
            index: 0,
            name: name.into(),
            polygons: vec![traced.polygon],
            warnings: Vec::new(),
            repaired: false,
            inside: Inside::default(),
        },
        deviation_m: traced.deviation_m,
    })
}

fn too_narrow(body: &Ellipsoid, found_m: f64) -> AnalyticError {
    AnalyticError::TooNarrow {
        body: body.name(),
        found_m,
        smallest_m: SMALLEST_SHARE * body.equatorial_radius_m(),
    }
}

fn misses(body: &Ellipsoid, sight: &Sight) -> AnalyticError {
    AnalyticError::Misses {
        body: body.name(),
        found_deg: sight.horizon_off_axis_rad().to_degrees(),
        half_angle_deg: sight.half_angle_rad.to_degrees(),
    }
}

fn check_cone(body: &Ellipsoid, cone: &SensorCone) -> Result<(), AnalyticError> {
    check_center(cone.apex)?;
    check_angle("azimuth", cone.azimuth_rad, TAU)?;
    check_angle("elevation", cone.elevation_rad, FRAC_PI_2)?;
    let smallest_m = SMALLEST_SHARE * body.equatorial_radius_m();
    let height_m = cone.apex.height_m;
    if !(height_m >= smallest_m && height_m.is_finite()) {
        return Err(AnalyticError::ApexInside {
            found_m: height_m,
            smallest_m,
        });
    }
    let half_angle_rad = cone.half_angle_rad;
    if !(half_angle_rad > 0.0 && half_angle_rad < FRAC_PI_2) {
        return Err(AnalyticError::Angle {
            parameter: "half angle",
            found: half_angle_rad,
            smallest: f64::MIN_POSITIVE,
            largest: FRAC_PI_2.next_down(),
        });
    }
    Ok(())
}

fn check_center(center: Geodetic) -> Result<(), AnalyticError> {
    check_angle("latitude", center.latitude_rad, FRAC_PI_2)?;
    // As far as files may go past the antimeridian.
    check_angle("longitude", center.longitude_rad, 3.0 * PI)
}

fn check_angle(parameter: &'static str, found: f64, largest: f64) -> Result<(), AnalyticError> {
    if (-largest..=largest).contains(&found) {
        return Ok(());
    }
    Err(AnalyticError::Angle {
        parameter,
        found,
        smallest: -largest,
        largest,
    })
}

fn check_length(
    body: &Ellipsoid,
    parameter: &'static str,
    found_m: f64,
    allowed_m: std::ops::RangeInclusive<f64>,
) -> Result<(), AnalyticError> {
    if allowed_m.contains(&found_m) {
        return Ok(());
    }
    Err(AnalyticError::Length {
        parameter,
        body: body.name(),
        found_m,
        smallest_m: *allowed_m.start(),
        largest_m: *allowed_m.end(),
    })
}

fn check_radius(
    body: &Ellipsoid,
    center: Geodetic,
    parameter: &'static str,
    found_m: f64,
) -> Result<(), AnalyticError> {
    let smallest_m = SMALLEST_SHARE * body.equatorial_radius_m();
    let largest_m = shortest_cut_m(body, center.latitude_rad);
    if found_m >= largest_m {
        return Err(AnalyticError::BeyondCut {
            parameter,
            body: body.name(),
            found_m,
            largest_m,
        });
    }
    check_length(body, parameter, found_m, smallest_m..=largest_m)
}
