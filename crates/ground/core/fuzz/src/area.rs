// SPDX-License-Identifier: MIT OR Apache-2.0
//! Area enclosed by rings under the even-odd rule, by slabs of latitude.
//!
//! Shares nothing with the mesher, which integrates the authalic zone area along edges of triangles:
//! here the plane of longitude and latitude is cut into slabs at every vertex, the edges through a
//! slab are sorted, and `∫ (λ_right − λ_left) M N cos φ dφ` is summed over every other gap.
//! Longitudes are not bounded; what lies whole turns apart is added modulo 2, as on the body.

use terrafill_core::Ellipsoid;

/// Longitude and latitude, degrees.
pub type Degrees = [f64; 2];

/// Square metres enclosed by closed `paths` (first vertex not repeated) that cross nowhere.
pub fn even_odd_area_m2(body: &Ellipsoid, paths: &[Vec<Degrees>]) -> f64 {
    let mut edges: Vec<[Degrees; 2]> = Vec::new();
    for path in paths {
        for (start, end) in path.iter().zip(path.iter().cycle().skip(1)) {
            push_within_turns(*start, *end, &mut edges);
        }
    }
    let mut latitudes: Vec<f64> = edges.iter().flatten().map(|end| end[1]).collect();
    latitudes.sort_by(f64::total_cmp);
    latitudes.dedup();
    let is_seam = seams(&edges);
    let edges: Vec<([Degrees; 2], bool)> = edges.into_iter().zip(is_seam).collect();
    latitudes
        .windows(2)
        .map(|slab| slab_area_m2(body, &edges, slab[0], slab[1]))
        .sum()
}

/// Turns from longitudes within ±180 to those of an edge.
fn turn_of([a, b]: &[Degrees; 2]) -> f64 {
    ((0.5 * (a[0] + b[0]) + 180.0) / 360.0).floor()
}

/// Which edges run along a meridian in pairs, turns apart: what a ring round a pole is closed by. On
/// the body the two cancel, and others may cross them.
fn seams(edges: &[[Degrees; 2]]) -> Vec<bool> {
    let mut is_seam = vec![false; edges.len()];
    let is_meridian = |[a, b]: &[Degrees; 2]| a[0] == b[0];
    let latitudes = |[a, b]: &[Degrees; 2]| [a[1].min(b[1]), a[1].max(b[1])];
    for (i, a) in edges.iter().enumerate().filter(|(_, a)| is_meridian(a)) {
        let is_twin = |j: usize| {
            let b = &edges[j];
            let turns = turn_of(b) - turn_of(a);
            // Turns are added with rounding.
            let off_deg = b[0][0] - a[0][0] - 360.0 * turns;
            let is_same = turns != 0.0 && off_deg.abs() < 2e-13;
            is_same && is_meridian(b) && latitudes(a) == latitudes(b)
        };
        let twin = (i + 1..edges.len()).find(|&j| !is_seam[i] && !is_seam[j] && is_twin(j));
        if let Some(j) = twin {
            is_seam[i] = true;
            is_seam[j] = true;
        }
    }
    is_seam
}

/// Cuts an edge at 180° + 360° k and leaves out what runs along a parallel.
fn push_within_turns(start: Degrees, end: Degrees, edges: &mut Vec<[Degrees; 2]>) {
    let (west, east) = if start[0] <= end[0] {
        (start, end)
    } else {
        (end, start)
    };
    let mut from = west;
    let mut push = |from: Degrees, to: Degrees| {
        if from[1] != to[1] {
            edges.push([from, to]);
        }
    };
    let mut border = 180.0 + 360.0 * ((west[0] - 180.0) / 360.0).floor() + 360.0;
    while border < east[0] {
        let share = (border - west[0]) / (east[0] - west[0]);
        let to = [border, west[1] + (east[1] - west[1]) * share];
        push(from, to);
        from = to;
        border += 360.0;
    }
    push(from, east);
}

/// An edge within a slab, longitude within ±180.
struct Side {
    south_deg: f64,
    north_deg: f64,
}

/// Of edges and whether they are [`seams`].
fn slab_area_m2(body: &Ellipsoid, edges: &[([Degrees; 2], bool)], south: f64, north: f64) -> f64 {
    let mut sides: Vec<Side> = Vec::new();
    // Parity just east of −180: of what lies west of each −180 + 360 k.
    let mut inside = false;
    for (edge, is_seam) in edges {
        let [a, b] = edge;
        let (low, high) = if a[1] < b[1] { (a, b) } else { (b, a) };
        if low[1] > south || high[1] < north {
            continue;
        }
        let at = |latitude: f64| {
            let share = (latitude - low[1]) / (high[1] - low[1]);
            low[0] * (1.0 - share) + high[0] * share
        };
        let turn = turn_of(edge);
        // West of the start of each later turn; of two turns on either side every path has been
        // crossed an even number of times.
        let mut later = turn + 1.0;
        while later <= 4.0 {
            inside = !inside;
            later += 1.0;
        }
        if *is_seam {
            continue;
        }
        sides.push(Side {
            south_deg: at(south) - 360.0 * turn,
            north_deg: at(north) - 360.0 * turn,
        });
    }
    let middle = |side: &Side| side.south_deg + side.north_deg;
    sides.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    let border = |degrees: f64| Side {
        south_deg: degrees,
        north_deg: degrees,
    };
    sides.insert(0, border(-180.0));
    sides.push(border(180.0));
    let mut area = 0.0;
    for gap in sides.windows(2) {
        if inside {
            area += trapezoid_m2(body, &gap[0], &gap[1], south, north);
        }
        inside = !inside;
    }
    area
}

/// Area between two sides.
fn trapezoid_m2(body: &Ellipsoid, west: &Side, east: &Side, south: f64, north: f64) -> f64 {
    let (a2, e2) = (
        body.equatorial_radius_m().powi(2),
        body.eccentricity_squared(),
    );
    // Five-point Gauss–Legendre on pieces of at most 2°: h¹⁰ leaves 1e-14. Three points left 1.2e-9
    // at the poles of a body as flat as Saturn, where cos φ and the width of a wedge both vanish.
    let (inner, outer) = (
        (5.0 - 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0,
        (5.0 + 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0,
    );
    let (heavy, light) = (
        (322.0 + 13.0 * 70_f64.sqrt()) / 900.0,
        (322.0 - 13.0 * 70_f64.sqrt()) / 900.0,
    );
    let nodes = [
        (-outer, light),
        (-inner, heavy),
        (0.0, 128.0 / 225.0),
        (inner, heavy),
        (outer, light),
    ];
    let pieces = ((north - south) / 2.0).ceil().max(1.0);
    let mut sum = 0.0;
    let mut piece = 0.0;
    while piece < pieces {
        for (node, weight) in nodes {
            let share = (piece + 0.5 + 0.5 * node) / pieces;
            let latitude = (south + (north - south) * share).to_radians();
            let width = (east.south_deg - west.south_deg) * (1.0 - share)
                + (east.north_deg - west.north_deg) * share;
            let w = 1.0 - e2 * latitude.sin().powi(2);
            // M N cos φ.
            sum += weight * width * a2 * (1.0 - e2) / (w * w) * latitude.cos();
        }
        piece += 1.0;
    }
    sum.to_radians() * (north - south).to_radians() / (2.0 * pieces)
}
