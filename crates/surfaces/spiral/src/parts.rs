// SPDX-License-Identifier: MIT OR Apache-2.0
//! Parts of the mesh with the extents that they lie over, so that near ground, where facets are small and hang
//! by little, gets low walls.

use glam::DVec3;
use terrafill_core::{Ellipsoid, Extent, wrapped_deg};
use terrafill_surface::{HeightRange, SurfaceMesh, SurfacePart};

/// Parts of a turn. With fewer a part is long and its extent holds much that is not in it.
const PARTS_PER_TURN: usize = 12;

/// - `fan`: triangles of the fan, the mesh's first
/// - `strip_per_turn`: triangles of a turn of the strip
/// - `eye_ecef`: vertices are drawn rounded relative to it
pub(crate) fn parts(
    mesh: &SurfaceMesh,
    fan: usize,
    strip_per_turn: usize,
    eye_ecef: DVec3,
) -> Vec<SurfacePart> {
    let (fan, strip) = mesh.triangles.split_at(fan.min(mesh.triangles.len()));
    let chunks = strip.chunks(strip_per_turn.div_ceil(PARTS_PER_TURN).max(1));
    std::iter::once(fan)
        .chain(chunks)
        .filter_map(|triangles| {
            let heights = triangles.iter().map(|facet| mesh.facet_heights(facet));
            let heights = heights.reduce(HeightRange::union)?;
            let corners = triangles.iter().flatten();
            let corners: Vec<DVec3> = corners
                .map(|&vertex| mesh.vertices_ecef[vertex as usize])
                .collect();
            Some(SurfacePart {
                extent: extent(&mesh.body, &corners, heights, eye_ecef),
                heights,
            })
        })
        .collect()
}

/// Longitudes and geodetic latitudes of everything between these corners.
///
/// Seen from the centre, triangles lie in the smallest cone around any axis that holds their corners. The
/// geodetic latitude of a place is found from the geocentric one as if it lay on the ellipsoid. A place higher or
/// lower by `h` is off by at most about `e² h / R`, which is doubled for flat bodies.
fn extent(body: &Ellipsoid, corners: &[DVec3], heights: HeightRange, eye_ecef: DVec3) -> Extent {
    let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
    let axis = corners
        .iter()
        .map(|corner| corner.normalize())
        .sum::<DVec3>();
    let angle = |corner: &DVec3| axis.cross(*corner).length().atan2(axis.dot(*corner));
    let farthest = corners.iter().map(|corner| (*corner - eye_ecef).length());
    let rounding = farthest.fold(0.0, f64::max) / f64::from(1_u32 << 23);
    let widest = corners.iter().map(angle).fold(0.0, f64::max) + rounding / b;
    let middle = axis.z.atan2(axis.x.hypot(axis.y));
    let flattened = 1.0 - (b / a).powi(2);
    let deep_m = heights.lowest_m.abs().max(heights.highest_m.abs());
    let margin = (2.0 * flattened * deep_m / b).to_degrees() + 1e-9;
    let geodetic = |geocentric: f64| {
        let (sine, cosine) = geocentric.sin_cos();
        sine.atan2(cosine * (1.0 - flattened)).to_degrees()
    };
    let (south, north) = (middle - widest, middle + widest);
    let has_pole = middle.abs() + widest >= std::f64::consts::FRAC_PI_2 - 1e-9;
    let (mut west_deg, mut east_deg) = (-180.0, 180.0);
    if !has_pole {
        let aside = (widest.sin() / middle.cos()).min(1.0).asin().to_degrees() + margin;
        let longitude = axis.y.atan2(axis.x).to_degrees();
        if aside < 179.0 {
            west_deg = wrapped_deg(longitude - aside);
            east_deg = wrapped_deg(longitude + aside);
        }
    }
    let latitude = |geocentric: f64, margin: f64| match geocentric.abs() {
        beyond if beyond >= std::f64::consts::FRAC_PI_2 => 90_f64.copysign(geocentric),
        _ => (geodetic(geocentric) + margin).clamp(-90.0, 90.0),
    };
    let (mut south_deg, mut north_deg) = (latitude(south, -margin), latitude(north, margin));
    if has_pole {
        if middle > 0.0 {
            north_deg = 90.0;
        } else {
            south_deg = -90.0;
        }
    }
    Extent {
        west_deg,
        south_deg,
        east_deg,
        north_deg,
    }
}
