// SPDX-License-Identifier: MIT OR Apache-2.0
//! Large regions in parts: which of their facets and walls a view may leave out.
//!
//! A part is some facets of the caps, or some walls in their order along the boundary, with a box of its own.
//! Parts are no closed volumes and need not be. What is left out would have changed nothing:
//!
//! - *Frustum*: it is drawn onto no pixel, whichever fragments count.
//! - *Horizon*: it lies in the shadow of the body, so that all its fragments are behind the surface. They
//!   change nothing where fragments in front of the surface count, and only there.
//!
//! A pixel of the region shows a point below a facet that is not left out. So the region's rectangle
//! shrinks to those of its facets' parts.

use crate::left_out::LeftOutReason;
use crate::pixel_rect::PixelRect;
use glam::DVec3;
use std::collections::BTreeMap;
use std::ops::Range;
use terrafill_core::{Ellipsoid, OrientedBox, RegionMesh, VolumeHeights, index_u32};

/// Facets, or walls, of a part at most: few enough that parts end near the horizon, enough that the test of a part costs
/// less than its vertices.
pub const PART_FACETS: usize = 32;

/// Which facets and walls of a mesh belong together: the same for all who ask.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartOrder {
    /// Indices of triangles, part by part.
    pub triangles: Vec<u32>,
    /// Of each part of the caps its triangles, as places in `triangles`.
    pub caps: Vec<Range<u32>>,
    /// Of each part of the walls its boundary edges, loop after loop.
    pub walls: Vec<Range<u32>>,
}

impl PartOrder {
    /// `None` of a mesh so small that it is one part.
    ///
    /// - cost: O(n log n) of n triangles
    #[must_use]
    pub fn of(mesh: &RegionMesh) -> Option<Self> {
        if !Self::has_several(mesh) {
            return None;
        }
        let edges = mesh.boundary_edge_count();
        let corner = |vertex: u32| mesh.vertices_ecef[vertex as usize];
        let triangles = mesh.triangles.iter();
        let middles: Vec<DVec3> = triangles
            .map(|corners| corners.iter().map(|&vertex| corner(vertex)).sum())
            .collect();
        let mut order = Self {
            triangles: (0..index_u32(mesh.triangles.len())).collect(),
            caps: Vec::new(),
            walls: chunks(edges),
        };
        split(&mut order.triangles, 0, &middles, &mut order.caps);
        Some(order)
    }

    /// Whether a mesh has more than one part.
    #[must_use]
    pub fn has_several(mesh: &RegionMesh) -> bool {
        mesh.triangles.len().max(mesh.boundary_edge_count()) > 2 * PART_FACETS
    }

    /// The triangles of `mesh`, part by part.
    #[must_use]
    pub fn ordered(&self, mesh: &RegionMesh) -> Vec<[u32; 3]> {
        let places = self.triangles.iter();
        places
            .map(|&place| mesh.triangles[place as usize])
            .collect()
    }
}

/// Halves triangles by the widest extent of their middles until each part is small enough.
fn split(triangles: &mut [u32], first: u32, middles: &[DVec3], parts: &mut Vec<Range<u32>>) {
    if triangles.len() <= PART_FACETS {
        if !triangles.is_empty() {
            parts.push(first..first + index_u32(triangles.len()));
        }
        return;
    }
    let middle = |triangle: u32| middles[triangle as usize];
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &triangle in triangles.iter() {
        low = low.min(middle(triangle));
        high = high.max(middle(triangle));
    }
    let axis = (high - low).max_position();
    let half = triangles.len() / 2;
    // By number where places are the same, so that there is one order only.
    triangles.select_nth_unstable_by(half, |&a, &b| {
        let by_place = middle(a)[axis].total_cmp(&middle(b)[axis]);
        by_place.then(a.cmp(&b))
    });
    let (before, after) = triangles.split_at_mut(half);
    split(before, first, middles, parts);
    split(after, first + index_u32(half), middles, parts);
}

fn chunks(count: usize) -> Vec<Range<u32>> {
    let starts = (0..count).step_by(PART_FACETS);
    let chunk = |start: usize| index_u32(start)..index_u32((start + PART_FACETS).min(count));
    starts.map(chunk).collect()
}

/// Some facets or walls and where they are.
#[derive(Debug, Clone, PartialEq)]
struct FacetGroup {
    range: Range<u32>,
    /// Holds their vertices on the ellipsoid.
    on_body: OrientedBox,
}

impl FacetGroup {
    /// Holds its vertices between these heights.
    fn around(&self, heights: VolumeHeights) -> OrientedBox {
        // No vertex moves farther from the ellipsoid than that.
        grown(
            &self.on_body,
            heights.top_m.abs().max(heights.bottom_m.abs()),
        )
    }
}

/// Holds these vertices of a mesh on the ellipsoid.
pub(crate) fn box_on_body(
    body: &Ellipsoid,
    mesh: &RegionMesh,
    mut vertices: Vec<u32>,
) -> OrientedBox {
    vertices.sort_unstable();
    vertices.dedup();
    let on_body = VolumeHeights {
        top_m: 0.0,
        bottom_m: 0.0,
    };
    mesh.box_of_some(body, &vertices, on_body)
}

/// A box so much larger on all sides.
pub(crate) fn grown(around: &OrientedBox, by_m: f64) -> OrientedBox {
    OrientedBox {
        half_extents_m: around.half_extents_m + DVec3::splat(by_m),
        ..*around
    }
}

/// The parts of a mesh, with their boxes.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshParts {
    /// As in [`PartOrder::triangles`].
    triangles: Vec<u32>,
    caps: Vec<FacetGroup>,
    walls: Vec<FacetGroup>,
}

impl MeshParts {
    /// `None` of a mesh so small that it is one part.
    #[must_use]
    pub fn of(body: &Ellipsoid, mesh: &RegionMesh) -> Option<Self> {
        let order = PartOrder::of(mesh)?;
        let place = |range: &Range<u32>| range.start as usize..range.end as usize;
        let part = |range: &Range<u32>, vertices: &[u32]| FacetGroup {
            range: range.clone(),
            on_body: box_on_body(body, mesh, vertices.to_vec()),
        };
        let triangles = order.ordered(mesh);
        let caps = order.caps.iter();
        let caps = caps.map(|range| part(range, triangles[place(range)].as_flattened()));
        let edges: Vec<[u32; 2]> = mesh.boundary_edges().collect();
        let walls = order.walls.iter();
        let walls = walls.map(|range| part(range, edges[place(range)].as_flattened()));
        Some(Self {
            caps: caps.collect(),
            walls: walls.collect(),
            triangles: order.triangles,
        })
    }

    /// As in [`PartOrder::triangles`].
    #[must_use]
    pub fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// Of each part its triangles, as places in [`MeshParts::triangles`], or its boundary edges, loop after
    /// loop; and a box that holds the part of the volume.
    pub(crate) fn boxes(
        &self,
        heights: VolumeHeights,
    ) -> impl Iterator<Item = (Range<u32>, Range<u32>, OrientedBox)> {
        let caps = self
            .caps
            .iter()
            .map(move |part| (part.range.clone(), 0..0, part.around(heights)));
        let walls = self
            .walls
            .iter()
            .map(move |part| (0..0, part.range.clone(), part.around(heights)));
        caps.chain(walls)
    }

    /// What a view sees of them.
    ///
    /// - `heights`: of the volume
    /// - `look`: why a part with these corners is left out, or its rectangle
    pub(crate) fn seen(
        &self,
        heights: VolumeHeights,
        look: impl Fn(&[DVec3; 8]) -> Result<PixelRect, LeftOutReason>,
    ) -> (SeenParts, Option<PixelRect>) {
        let look = |part: &FacetGroup| look(&part.around(heights).corners_ecef());
        let mut seen = SeenParts::default();
        let mut rect: Option<PixelRect> = None;
        for (parts, is_cap) in [(&self.caps, true), (&self.walls, false)] {
            for part in parts {
                seen.of_parts += 1;
                let facets = part.range.len();
                seen.of_facets += facets;
                match look(part) {
                    Ok(own) if is_cap => {
                        push(&mut seen.caps, &part.range);
                        rect = Some(rect.map_or(own, |known| known.around(own)));
                    }
                    Ok(_) => push(&mut seen.walls, &part.range),
                    Err(reason) => {
                        *seen.left_out.entry(reason).or_default() += 1;
                        seen.facets_left_out += facets;
                    }
                }
            }
        }
        (seen, rect)
    }
}

/// Boundary edges of a range of them, loop after loop.
pub(crate) fn edges_in(mesh: &RegionMesh, range: Range<u32>) -> impl Iterator<Item = [u32; 2]> {
    let mut first = 0;
    mesh.boundary_loops.iter().flat_map(move |ring| {
        let (start, past) = (first, first + index_u32(ring.len()));
        first = past;
        let own = range.start.max(start)..range.end.min(past);
        own.map(move |edge| {
            let edge = (edge - start) as usize;
            [ring[edge], ring[(edge + 1) % ring.len()]]
        })
    })
}

/// Ranges that join are one.
fn push(ranges: &mut Vec<Range<u32>>, range: &Range<u32>) {
    match ranges.last_mut() {
        Some(last) if last.end == range.start => last.end = range.end,
        _ => ranges.push(range.clone()),
    }
}

/// What a view sees of a mesh of several parts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SeenParts {
    /// Facets of each cap, in the order of [`PartOrder::triangles`].
    pub caps: Vec<Range<u32>>,
    /// Boundary edges, loop after loop.
    pub walls: Vec<Range<u32>>,
    /// Parts left out by reason.
    pub left_out: BTreeMap<LeftOutReason, usize>,
    /// Of so many.
    pub of_parts: usize,
    /// Facets of a cap and walls left out.
    pub facets_left_out: usize,
    /// Of so many.
    pub of_facets: usize,
}

impl SeenParts {
    /// The walls seen, loop by loop: the loop, and of its edges those seen.
    ///
    /// - `mesh`: the mesh that this is of
    #[must_use]
    pub fn walls_by_loop(&self, mesh: &RegionMesh) -> Vec<(usize, Range<u32>)> {
        let mut found = Vec::new();
        let mut seen = self.walls.iter().peekable();
        let mut first = 0;
        for (number, ring) in mesh.boundary_loops.iter().enumerate() {
            let past = first + index_u32(ring.len());
            while let Some(range) = seen.peek() {
                let own = range.start.max(first)..range.end.min(past);
                if !own.is_empty() {
                    found.push((number, own.start - first..own.end - first));
                }
                if range.end > past {
                    break;
                }
                seen.next();
            }
            first = past;
        }
        found
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A strip of `count` squares along the equator, a twentieth of a degree each, and a triangle apart.
    pub(crate) fn strip(count: u32) -> RegionMesh {
        let body = Ellipsoid::WGS84;
        let mut vertices_deg = Vec::new();
        for column in 0..=count {
            let longitude_deg = f64::from(column) / 20.0;
            vertices_deg.extend([[longitude_deg, 0.0], [longitude_deg, 0.05]]);
        }
        let first = index_u32(vertices_deg.len());
        vertices_deg.extend([[-1.0, 0.0], [-0.9, 0.0], [-0.9, 0.1]]);
        let ecef = |[longitude, latitude]: &[f64; 2]| {
            let place = terrafill_core::Geodetic::from_degrees(*longitude, *latitude, 0.0);
            body.geodetic_to_ecef(place)
        };
        let squares = (0..count).flat_map(|k| {
            let [a, b, c, d] = [2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1];
            [[a, b, c], [a, c, d]]
        });
        let along = (0..=count).map(|k| 2 * k);
        let back = (0..=count).rev().map(|k| 2 * k + 1);
        RegionMesh {
            region_index: 0,
            name: "strip".to_owned(),
            vertices_ecef: vertices_deg.iter().map(ecef).collect(),
            triangles: squares.chain([[first, first + 1, first + 2]]).collect(),
            boundary_loops: vec![
                vec![first, first + 1, first + 2],
                along.chain(back).collect(),
            ],
            vertices_deg,
            holes: 0,
            area_m2: 1.0,
            extent: terrafill_core::Extent::WHOLE,
            boundary_deviation_m: 0.0,
            cap_sagitta_m: 0.0,
            warnings: Vec::new(),
        }
    }

    const HEIGHTS: VolumeHeights = VolumeHeights {
        top_m: 9_000.0,
        bottom_m: -11_000.0,
    };

    #[test]
    fn edges_of_a_range_are_those_of_all_at_these_places() {
        let mesh = strip(5);
        let all: Vec<[u32; 2]> = mesh.boundary_edges().collect();
        for (start, end) in [(0, 15), (0, 3), (2, 4), (3, 15), (5, 5), (14, 15)] {
            let own: Vec<[u32; 2]> = edges_in(&mesh, start..end).collect();
            assert_eq!(own, all[start as usize..end as usize], "{start} {end}");
        }
    }

    #[test]
    fn every_facet_and_wall_is_in_one_part_and_within_its_box() {
        let mesh = strip(1_000);
        let order = PartOrder::of(&mesh).expect("large");
        let mut all = order.triangles.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..2_001));
        for ranges in [&order.caps, &order.walls] {
            assert!(ranges.len() >= 8, "{}", ranges.len());
            let is_next = |pair: &[Range<u32>]| pair[0].end == pair[1].start;
            assert!(ranges.windows(2).all(is_next));
            assert!(ranges.iter().all(|range| range.len() <= PART_FACETS));
        }
        assert_eq!(order.walls.last().map(|range| range.end), Some(2_005));
        let body = Ellipsoid::WGS84;
        let parts = MeshParts::of(&body, &mesh).expect("large");
        let top = |vertex: u32| {
            let [longitude, latitude] = mesh.vertices_deg[vertex as usize];
            let place = terrafill_core::Geodetic::from_degrees(longitude, latitude, HEIGHTS.top_m);
            body.geodetic_to_ecef(place)
        };
        let triangles = order.ordered(&mesh);
        let is_within = |part: &FacetGroup, vertex: u32, reach_m: f64| {
            let local = part.on_body.axes.transpose() * (top(vertex) - part.on_body.center_ecef);
            let room = part.on_body.half_extents_m + DVec3::splat(reach_m + 1e-3);
            local.abs().cmple(room).all()
        };
        let holds_all = |reach_m: f64| {
            parts.caps.iter().all(|part| {
                let own = &triangles[part.range.start as usize..part.range.end as usize];
                let mut own = own.as_flattened().iter();
                own.all(|&vertex| is_within(part, vertex, reach_m))
            })
        };
        assert!(holds_all(HEIGHTS.top_m));
        // Negative control: not grown by the caps' height, boxes do not hold the caps.
        assert!(!holds_all(0.5 * HEIGHTS.top_m));
        // Negative control: what fits into one part has no parts.
        assert_eq!(PartOrder::of(&strip(12)), None);
    }

    #[test]
    fn what_is_seen_is_what_is_not_left_out_loop_by_loop() {
        let mesh = strip(1_000);
        let parts = MeshParts::of(&Ellipsoid::WGS84, &mesh).expect("large");
        let rect = |left| PixelRect {
            left,
            top: 0,
            right: left + 1,
            bottom: 1,
        };
        // As if all east of 25 degrees were beyond the horizon.
        let is_west = |corners: &[DVec3; 8]| {
            let longitude_deg = |corner: &DVec3| corner.y.atan2(corner.x).to_degrees();
            corners.iter().any(|corner| longitude_deg(corner) < 25.0)
        };
        let (seen, found) = parts.seen(HEIGHTS, |corners| {
            if is_west(corners) {
                Ok(rect(3))
            } else {
                Err(LeftOutReason::BeyondHorizon)
            }
        });
        assert_eq!(found, Some(rect(3)));
        let left_out = seen.left_out[&LeftOutReason::BeyondHorizon];
        assert!(left_out > 4 && left_out < seen.of_parts, "{seen:?}");
        let drawn = |ranges: &[Range<u32>]| ranges.iter().map(|range| range.len()).sum::<usize>();
        let of_facets = drawn(&seen.caps) + drawn(&seen.walls) + seen.facets_left_out;
        assert_eq!((of_facets, seen.of_facets), (2_001 + 2_005, 2_001 + 2_005));
        let by_loop = seen.walls_by_loop(&mesh);
        assert_eq!(by_loop[0], (0, 0..3));
        let of_second: usize = by_loop[1..].iter().map(|(_, edges)| edges.len()).sum();
        assert_eq!(of_second, drawn(&seen.walls) - 3);
        assert!(
            by_loop[1..]
                .iter()
                .all(|(ring, edges)| *ring == 1 && edges.end <= 2_002)
        );
        // Negative control: where all is seen nothing is left out, and each cap is one range.
        let (all, _) = parts.seen(HEIGHTS, |_| Ok(rect(0)));
        assert_eq!((all.facets_left_out, all.caps.len()), (0, 1));
        assert_eq!(all.walls_by_loop(&mesh), [(0, 0..3), (1, 0..2_002)]);
    }
}
