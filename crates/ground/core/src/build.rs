// SPDX-License-Identifier: MIT OR Apache-2.0
//! Region → [`RegionMesh`]: outline, triangles, stitching, boundary loops, area.
//!
//! Groups are meshed in degrees and put together on the body (see `stitch`). What crosses is refused
//! with its places; what crosses only where parts of edges were rounded is snapped and meshed again.

use crate::crossings::CrossingPlaces;
use crate::edge::area::{ZoneArea, compensated_sum};
use crate::edge::{Degrees, EdgeSplitter, ROUNDING, surface_point};
use crate::inside::{SideChoice, side_note};
use crate::lens::{WithinRounding, follow_arcs};
use crate::mesh::sagitta_m;
use crate::mesh_error::MeshError;
use crate::outline::{OppositeEnds, Outline, share_breakpoints};
use crate::overlaps::{
    OverlapPlace, Overlaps, RingAreas, find_overlaps, shared_edges, union_border,
};
use crate::pieces::OutlineEdge;
use crate::snap::snap_rounded;
use crate::stitch::Stitcher;
use crate::triangulate::{Arcs, GroupMesh, TriangulateError, triangulate};
use crate::{
    EdgePlace, EdgeRule, Ellipsoid, Extent, MeshOptions, Region, RegionMesh, RegionWarning, Repair,
    WarningSubject,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Crossings listed of one region; the rest are counted.
const MAX_LISTED_CROSSINGS: usize = 100;
/// Crossings of arcs after which the search ends: a message says how many more there are.
const MAX_COUNTED_CROSSINGS: usize = 10_000;
/// Share of its area below which a repair has changed nothing that anyone means.
const REPAIR_AREA_TOLERANCE: f64 = 1e-9;
/// Edges of a region from which its groups are triangulated several at a time: below that, handing
/// them out costs more than it saves.
const PARALLEL_FROM_EDGES: usize = 2_000;

impl MeshOptions {
    /// # Errors
    /// [`MeshError::Option`] for a value that cannot be meshed with.
    pub fn check(&self) -> Result<(), MeshError> {
        let tolerance = self.boundary_tolerance_m;
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(MeshError::Option {
                option: "boundary_tolerance_m",
                found: tolerance,
                allowed: "above 0 and finite",
            });
        }
        // Upwards of 30° a facet's sagitta is a large part of the body; downwards of 0.01° a
        // whole globe has a billion facets.
        if !(0.01..=30.0).contains(&self.cap_step_deg) {
            return Err(MeshError::Option {
                option: "cap_step_deg",
                found: self.cap_step_deg,
                allowed: "0.01 … 30",
            });
        }
        Ok(())
    }
}

impl RegionMesh {
    /// Meshes one region.
    ///
    /// Inside is what an odd number of the region's ring edges separates from the outside, so holes
    /// and islands in holes need no nesting order. Longitudes within 10⁻¹¹ degrees of ±180 are on the
    /// antimeridian, and latitudes within 2⁻³⁶ degrees (1.6 µm on the Earth) of ±90 at the pole. Which
    /// side of a ring round a pole is inside is said at [`Inside`](crate::Inside); where its two
    /// readings differ, [`RegionMesh::warnings`] says so.
    ///
    /// # Errors
    /// [`MeshError`]; the first one found.
    pub fn build(
        region: &Region,
        body: &Ellipsoid,
        rule: EdgeRule,
        options: &MeshOptions,
    ) -> Result<Self, MeshError> {
        Self::build_or_list(region, body, rule, options).map_err(|mut errors| errors.swap_remove(0))
    }

    /// # Errors
    /// At least one [`MeshError`]: everything that is wrong with the region.
    fn build_or_list(
        region: &Region,
        body: &Ellipsoid,
        rule: EdgeRule,
        options: &MeshOptions,
    ) -> Result<Self, Vec<MeshError>> {
        options.check().map_err(|error| vec![error])?;
        let without_collapsed = region.without_collapsed(rule);
        let region = without_collapsed.as_ref().unwrap_or(region);
        let build = |crossings| Self::build_once(region, body, rule, options, crossings);
        build(Crossings::Refused).or_else(|errors| {
            if !only_parts_cross(region, rule, &errors) {
                return Err(with_all_arc_crossings(region, rule, errors));
            }
            build(Crossings::SnappedAway)
        })
    }

    fn build_once(
        region: &Region,
        body: &Ellipsoid,
        rule: EdgeRule,
        options: &MeshOptions,
        crossings: Crossings,
    ) -> Result<Self, Vec<MeshError>> {
        let long_edges = match rule {
            EdgeRule::Planar => region.long_edge_count(),
            EdgeRule::GreatEllipse => 0,
        };
        let no_area = || {
            vec![MeshError::NoArea {
                feature: region.index,
                name: region.name.clone(),
                long_edges,
            }]
        };
        let mesh = |bent: &Bent| Meshed::new(region, body, rule, options, crossings, bent);
        let mut bent = Bent::new();
        let mut meshed = mesh(&bent)?;
        for near in [WithinRounding::Kept, WithinRounding::Merged] {
            let turned_over = turned_over(body, &meshed.groups);
            if turned_over.is_empty() {
                break;
            }
            bent.extend(turned_over.into_iter().map(|group| (group, near)));
            meshed = mesh(&bent)?;
        }
        let Meshed {
            groups,
            extent,
            boundary_deviation_m,
            notes,
        } = meshed;
        let mut stitcher = Stitcher::default();
        let mut area_m2 = 0.0;
        for (group, group_area_m2) in groups {
            area_m2 += group_area_m2;
            stitcher.add(body, group);
        }
        if stitcher.triangles.is_empty() {
            return Err(no_area());
        }
        let Some(boundary_loops) = stitcher.boundary_loops() else {
            return Err(failed(region, "the boundary is not closed".to_owned()));
        };
        // Without a border there is only the whole body. Anything else is within micrometres of a
        // pole, where its border became a point.
        let whole_m2 = body.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2);
        if boundary_loops.is_empty() && area_m2 < 0.999_999 * whole_m2 {
            return Err(no_area());
        }
        let facets = stitcher.triangles.iter();
        let facets = facets.map(|corners| corners.map(|i| stitcher.vertices_ecef[i as usize]));
        let cap_sagitta_m = sagitta_m(body, facets);
        let mesh = Self {
            region_index: region.index,
            name: region.name.clone(),
            vertices_ecef: stitcher.vertices_ecef,
            vertices_deg: stitcher.vertices_deg,
            triangles: stitcher.triangles,
            boundary_loops,
            holes: region.polygons.iter().map(|of| of.holes.len()).sum(),
            // Of what is narrower than rounding it may be a rounding below.
            area_m2: area_m2.max(0.0),
            extent,
            boundary_deviation_m,
            cap_sagitta_m,
            warnings: region
                .warnings
                .iter()
                .cloned()
                .chain(long_edges_note(long_edges))
                .chain(notes)
                .chain(repair_note(region, body, rule, area_m2))
                .collect(),
        };
        // Rare enough to be looked at again: what was a rounding wide has been moved by as much.
        if !bent.is_empty() || matches!(crossings, Crossings::SnappedAway) {
            mesh.check_invariants(body)
                .map_err(|violation| failed(region, violation.to_string()))?;
        }
        Ok(mesh)
    }

    /// Meshes every region, several at a time.
    ///
    /// # Errors
    /// Everything that is wrong with any region, in order: each crossing is a [`MeshError`] of its
    /// own, up to a hundred a region, and the rest are counted.
    pub fn build_all(
        regions: &[Region],
        body: &Ellipsoid,
        rule: EdgeRule,
        options: &MeshOptions,
    ) -> Result<Vec<Self>, Vec<MeshError>> {
        options.check().map_err(|error| vec![error])?;
        let results: Vec<Result<Self, Vec<MeshError>>> = regions
            .par_iter()
            .map(|region| Self::build_or_list(region, body, rule, options))
            .collect();
        if results.iter().all(Result::is_ok) {
            return results.into_iter().collect();
        }
        let errors = results.into_iter().filter_map(Result::err);
        Err(errors.flatten().collect())
    }
}

/// A fault of this program.
fn failed(region: &Region, message: String) -> Vec<MeshError> {
    vec![MeshError::Triangulation {
        feature: region.index,
        name: region.name.clone(),
        message,
    }]
}

fn opposite_ends(region: &Region, opposite: Vec<OppositeEnds>) -> Vec<MeshError> {
    let error = |OppositeEnds { place, start, end }| MeshError::OppositeEnds {
        feature: region.index,
        name: region.name.clone(),
        place: region.in_file(place),
        start,
        end,
    };
    opposite.into_iter().map(error).collect()
}

/// What becomes of places where parts of edges cross.
#[derive(Clone, Copy)]
enum Crossings {
    /// As they should be: edges of a file cross at its vertices only.
    Refused,
    /// Where [`only_parts_cross`].
    SnappedAway,
}

/// Groups of which arcs are followed before they are triangulated, or snapped.
type Bent = BTreeMap<usize, WithinRounding>;

/// A region's groups, not yet put together.
struct Meshed {
    /// With the area of each.
    groups: Vec<(GroupMesh, f64)>,
    extent: Extent,
    boundary_deviation_m: f64,
    /// For the warnings.
    notes: Vec<RegionWarning>,
}

impl Meshed {
    /// # Errors
    /// At least one [`MeshError`].
    fn new(
        region: &Region,
        body: &Ellipsoid,
        rule: EdgeRule,
        options: &MeshOptions,
        crossings: Crossings,
        bent: &Bent,
    ) -> Result<Self, Vec<MeshError>> {
        let mut splitter = EdgeSplitter::new(body, rule, options);
        let mut outline = Outline::new(region, rule, &mut splitter)
            .map_err(|opposite| opposite_ends(region, opposite))?;
        let mut followed = vec![false; outline.groups.len()];
        for (group, edges) in outline.groups.iter_mut().enumerate() {
            let near = match crossings {
                Crossings::Refused => bent.get(&group).copied(),
                // Snapped where chords cross, arcs would be led to places off themselves.
                Crossings::SnappedAway => bent.get(&group).copied().or(Some(WithinRounding::Kept)),
            };
            if let Some(near) = near.filter(|_| rule == EdgeRule::GreatEllipse) {
                *edges = follow_arcs(std::mem::take(edges), near);
                followed[group] = true;
            }
        }
        let (groups, at_splits) = match crossings {
            Crossings::Refused => {
                let at_splits = outline.crossings_at_splits(rule, MAX_LISTED_CROSSINGS);
                (outline.groups, at_splits)
            }
            Crossings::SnappedAway => {
                let mut groups = snap_rounded(rule, &outline.groups);
                share_breakpoints(&mut groups.iter_mut().collect::<Vec<_>>());
                (groups, Vec::new())
            }
        };
        let arcs = |followed: &bool| {
            if *followed {
                Arcs::Settled
            } else {
                Arcs::AsDrawn
            }
        };
        let groups: Vec<_> = groups.into_iter().zip(followed.iter().map(arcs)).collect();
        let groups = triangulate_groups(region, body, rule, options, groups, at_splits)?;
        // Chords within the tolerance of arcs may lie apart where these cross. No arc does unless a
        // vertex lies between another and its chord, which has them followed.
        if region.repaired.is_none() && groups.iter().any(|group| group.mesh.arcs_followed) {
            let places = region.arc_crossings(MAX_COUNTED_CROSSINGS);
            if !places.is_empty() {
                let counted_all = places.len() < MAX_COUNTED_CROSSINGS;
                return Err(self_crossings(region, places, counted_all));
            }
        }
        let mut notes = side_notes(region, &outline.choices);
        notes.extend(finest_note(options, splitter.deviation_m));
        notes.extend(
            if groups.iter().any(|group| group.in_doubt || group.is_joined) {
                notes_on_parts(region, body, rule, options, &groups)?
            } else {
                Vec::new()
            },
        );
        let mut extent = outline.extent;
        for (group, followed) in groups.iter().zip(followed) {
            // Feet may lie nearer to the arc's highest latitude than the places it was split at, and
            // what lies in one cell has been moved to its middle.
            if followed || group.mesh.arcs_followed {
                for position in &group.mesh.vertices {
                    widen(&mut extent, *position);
                }
            }
        }
        let groups = groups.into_iter().map(|group| (group.mesh, group.area_m2));
        Ok(Self {
            groups: groups.collect(),
            extent,
            boundary_deviation_m: splitter.deviation_m,
            notes,
        })
    }
}

/// What is to be said of rings round a pole.
fn side_notes(region: &Region, choices: &[(EdgePlace, SideChoice)]) -> Vec<RegionWarning> {
    let note = |(place, choice): &(EdgePlace, SideChoice)| {
        let EdgePlace { polygon, ring, .. } = region.in_file(*place);
        WarningSubject::Inside.warn(format!(
            "polygon {polygon}, ring {ring}: {}",
            side_note(ring > 0, region.inside, choice)
        ))
    };
    choices.iter().map(note).collect()
}

fn long_edges_note(count: usize) -> Option<RegionWarning> {
    let edges = match count {
        0 => return None,
        1 => "1 edge spans".to_owned(),
        _ => format!("{count} edges span"),
    };
    Some(WarningSubject::Inside.warn(format!(
        "{edges} more than 180° of longitude: planar edges go the long way (RFC 7946); --unwrap \
         shortest takes the shorter one"
    )))
}

/// What was reached where edges are not split as finely as was asked for.
fn finest_note(options: &MeshOptions, deviation_m: f64) -> Option<RegionWarning> {
    let asked_m = options.boundary_tolerance_m;
    (deviation_m > asked_m).then(|| {
        WarningSubject::Mesh.warn(format!(
            "boundary tolerance {asked_m:e} m is too fine: {deviation_m:.3e} m was reached"
        ))
    })
}

/// Moves the nearer end of either interval to a vertex that is a little outside. ±180 is one
/// meridian, and at a pole there is none.
fn widen(extent: &mut Extent, [longitude, latitude]: Degrees) {
    extent.south_deg = extent.south_deg.min(latitude);
    extent.north_deg = extent.north_deg.max(latitude);
    let (west, east) = (extent.west_deg, extent.east_deg);
    let is_within = if west <= east {
        (west..=east).contains(&longitude)
    } else {
        longitude >= west || longitude <= east
    };
    if is_within || longitude.abs() == 180.0 || latitude.abs() == 90.0 {
        return;
    }
    if (longitude - east).rem_euclid(360.0) < (west - longitude).rem_euclid(360.0) {
        extent.east_deg = longitude;
    } else {
        extent.west_deg = longitude;
    }
}

/// What is to be said of groups in which parts overlap or have edges in common.
///
/// # Errors
/// [`MeshError::Overlap`] of every pair of rings, unless the region is repaired.
fn notes_on_parts(
    region: &Region,
    body: &Ellipsoid,
    rule: EdgeRule,
    options: &MeshOptions,
    groups: &[TriangulatedGroup],
) -> Result<Vec<RegionWarning>, Vec<MeshError>> {
    // Seldom enough that the edges are made again and not kept.
    let mut splitter = EdgeSplitter::new(body, rule, options);
    let outline = Outline::new(region, rule, &mut splitter)
        .map_err(|opposite| opposite_ends(region, opposite))?;
    let tolerance_deg = (options.boundary_tolerance_m / body.polar_radius_m()).to_degrees();
    let (mut overlaps, mut nested, mut shared) = (Vec::new(), Vec::new(), 0);
    for (edges, group) in outline.groups.into_iter().zip(groups) {
        if group.is_joined {
            shared += shared_edges(&edges);
        }
        if group.in_doubt {
            let found = find_overlaps(edges, rule, tolerance_deg).ok_or_else(|| {
                let message = "parts that overlap could not be looked for";
                failed(region, message.to_owned())
            })?;
            let Overlaps {
                refused,
                nested: of_group,
            } = found;
            overlaps.extend(refused);
            nested.extend(of_group);
        }
    }
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    let mut notes = Vec::new();
    if shared > 0 {
        notes.push(WarningSubject::Mesh.warn(format!(
            "{shared} edge{} shared by parts: no boundary there",
            plural(shared)
        )));
    }
    let is_joined = joins_parts(region);
    notes.extend(nested.iter().filter(|_| !is_joined).map(|[inner, outer]| {
        let [inner, outer] = [*inner, *outer].map(|ring| region.in_file(ring));
        let EdgePlace { polygon, ring, .. } = inner;
        WarningSubject::Inside.warn(format!(
            "polygon {polygon}, ring {ring} is a hole in the hole of ring {}: filled as an island; \
             --repair union cuts it out",
            outer.ring
        ))
    }));
    if overlaps.is_empty() {
        return Ok(notes);
    }
    if let Some(repair) = region.repaired {
        notes.push(WarningSubject::Repair.warn(format!(
            "{} overlap{} of parts: {}",
            overlaps.len(),
            plural(overlaps.len()),
            repair.effect()
        )));
        return Ok(notes);
    }
    let error = |overlap: OverlapPlace| MeshError::Overlap {
        feature: region.index,
        name: region.name.clone(),
        first: region.in_file(overlap.rings[0]),
        second: region.in_file(overlap.rings[1]),
        longitude_deg: overlap.at[0],
        latitude_deg: overlap.at[1],
    };
    overlaps.truncate(MAX_LISTED_CROSSINGS);
    Err(overlaps.into_iter().map(error).collect())
}

/// Whether what several parts cover is inside.
fn joins_parts(region: &Region) -> bool {
    matches!(region.repaired, Some(Repair::Union | Repair::KeepShells))
}

/// What a repair changed, where its area says so.
fn repair_note(
    region: &Region,
    body: &Ellipsoid,
    rule: EdgeRule,
    area_m2: f64,
) -> Option<RegionWarning> {
    region.repaired?;
    let polygons = region.polygons.iter();
    let one_by_one_m2: f64 = polygons
        .map(|polygon| polygon.ring_by_ring_m2(rule, body, region.inside))
        .sum();
    let differs = (area_m2 - one_by_one_m2).abs() > REPAIR_AREA_TOLERANCE * area_m2;
    differs.then(|| {
        WarningSubject::Repair.warn(format!(
            "area as repaired {area_m2:.6e} m², by its rings one by one {one_by_one_m2:.6e} m²"
        ))
    })
}

/// A group's triangles.
struct TriangulatedGroup {
    mesh: GroupMesh,
    area_m2: f64,
    /// Whether its rings enclose another area than they do one by one.
    in_doubt: bool,
    /// Whether edges have fallen out of its boundary or were split.
    is_joined: bool,
}

/// Whether all that is wrong are crossings of parts of edges that do not cross as the file has them,
/// or cross by no more than a repair left of them.
///
/// Where an edge is split or cut at the antimeridian is rounded, which bends it over a vertex that
/// touches it or over another edge a rounding away.
fn only_parts_cross(region: &Region, rule: EdgeRule, errors: &[MeshError]) -> bool {
    errors.iter().all(is_crossing) && (region.repaired.is_some() || !region.has_crossings(rule))
}

/// Errors with every crossing of arcs in place of those that are crossings of chords: parts of edges
/// that were split meet at the places that split them, and do not cross there.
fn with_all_arc_crossings(
    region: &Region,
    rule: EdgeRule,
    errors: Vec<MeshError>,
) -> Vec<MeshError> {
    if rule == EdgeRule::Planar || region.repaired.is_some() || !errors.iter().all(is_crossing) {
        return errors;
    }
    let places = region.arc_crossings(MAX_COUNTED_CROSSINGS);
    if places.is_empty() {
        return errors;
    }
    let counted_all = places.len() < MAX_COUNTED_CROSSINGS;
    self_crossings(region, places, counted_all)
}

fn is_crossing(error: &MeshError) -> bool {
    matches!(
        error,
        MeshError::SelfCrossing { .. } | MeshError::MoreCrossings { .. }
    )
}

/// Indices of the groups that are turned over.
///
/// The triangles see chords. Of a sliver between an arc and its chord they see the far side: its
/// border runs round it the wrong way and its area is below 0. Arcs split where it lies in their
/// lenses put that right ([`follow_arcs`]), unless its width is rounding, which does not count.
fn turned_over(body: &Ellipsoid, groups: &[(GroupMesh, f64)]) -> Vec<usize> {
    let rounding_m = ROUNDING * body.equatorial_radius_m();
    let is_turned_over = |(group, area_m2): &(GroupMesh, f64)| {
        let length_m = |ends: &[u32; 2]| {
            let [start, end] = ends.map(|i| surface_point(body, group.vertices[i as usize]));
            start.distance(end)
        };
        *area_m2 < 0.0 && -area_m2 > rounding_m * group.boundary.iter().map(length_m).sum::<f64>()
    };
    let turned_over = groups
        .iter()
        .enumerate()
        .filter(|(_, group)| is_turned_over(group));
    turned_over.map(|(index, _)| index).collect()
}

/// Triangles and area of each group.
///
/// # Errors
/// `crossings`, and those of all groups, or a fault of this program.
fn triangulate_groups(
    region: &Region,
    body: &Ellipsoid,
    rule: EdgeRule,
    options: &MeshOptions,
    groups: Vec<(Vec<OutlineEdge>, Arcs)>,
    mut crossings: Vec<CrossingPlaces>,
) -> Result<Vec<TriangulatedGroup>, Vec<MeshError>> {
    let mesh_one = |(edges, arcs): (Vec<OutlineEdge>, Arcs)| {
        let one_by_one = RingAreas::of(&edges);
        let edge_count = edges.len();
        let to_join = joins_parts(region).then(|| edges.clone());
        let mut mesh = triangulate(edges, rule, options, arcs)?;
        let in_doubt = one_by_one.is_some_and(|areas| areas.differ_from(&mesh));
        let is_joined = one_by_one.is_some() && mesh.boundary.len() != edge_count;
        if let Some(edges) = to_join.filter(|_| in_doubt) {
            let fault = "parts that overlap could not be joined";
            let border = union_border(edges, rule)
                .ok_or_else(|| TriangulateError::Refused(fault.to_owned()))?;
            mesh = triangulate(border, rule, options, arcs)?;
        }
        Ok(TriangulatedGroup {
            area_m2: enclosed_area_m2(body, rule, &mesh),
            in_doubt,
            is_joined,
            mesh,
        })
    };
    let edge_count: usize = groups.iter().map(|(edges, _)| edges.len()).sum();
    let results: Vec<Result<TriangulatedGroup, TriangulateError>> =
        if groups.len() > 1 && edge_count >= PARALLEL_FROM_EDGES {
            groups.into_par_iter().map(mesh_one).collect()
        } else {
            groups.into_iter().map(mesh_one).collect()
        };
    let mut meshed = Vec::with_capacity(results.len());
    let mut counted_all = true;
    for result in results {
        match result {
            Ok(group) => meshed.push(group),
            Err(TriangulateError::Crossings { found, complete }) => {
                crossings.extend(found);
                counted_all &= complete;
            }
            Err(TriangulateError::TooFine { points }) => {
                return Err(vec![MeshError::CapStep {
                    feature: region.index,
                    name: region.name.clone(),
                    found_deg: options.cap_step_deg,
                    vertices: points,
                }]);
            }
            Err(TriangulateError::Refused(message)) => {
                return Err(failed(region, message));
            }
        }
    }
    if crossings.is_empty() {
        Ok(meshed)
    } else {
        Err(self_crossings(region, crossings, counted_all))
    }
}

fn self_crossings(
    region: &Region,
    mut crossings: Vec<CrossingPlaces>,
    counted_all: bool,
) -> Vec<MeshError> {
    crossings.sort_by_key(|crossing| (crossing.first, crossing.second));
    crossings.dedup_by_key(|crossing| (crossing.first, crossing.second));
    let more = crossings.len().saturating_sub(MAX_LISTED_CROSSINGS);
    crossings.truncate(MAX_LISTED_CROSSINGS);
    let (feature, name) = (region.index, &region.name);
    let mut errors: Vec<MeshError> = crossings
        .into_iter()
        .map(|crossing| MeshError::SelfCrossing {
            feature,
            name: name.clone(),
            first: region.in_file(crossing.first),
            second: region.in_file(crossing.second),
            longitude_deg: crossing.at[0],
            latitude_deg: crossing.at[1],
        })
        .collect();
    if more > 0 {
        errors.push(MeshError::MoreCrossings {
            feature,
            name: name.clone(),
            more,
            counted_all,
        });
    }
    errors
}

/// `−∮ (Z − Z₀) dλ` round the boundary, each edge by its rule: Green's theorem for
/// `dA = (dZ/dφ) dφ dλ`. Exact for the rings: splitting an edge does not change where it runs.
/// Below 0 where [`turned_over`] says why.
fn enclosed_area_m2(body: &Ellipsoid, rule: EdgeRule, group: &GroupMesh) -> f64 {
    let Some(first) = group.vertices.first() else {
        return 0.0;
    };
    let zone = ZoneArea::new(body, first[1]);
    let under = group.boundary.iter().map(|ends| {
        let [start, end] = ends.map(|i| group.vertices[i as usize]);
        zone.under_edge(rule, start, end)
    });
    -compensated_sum(under)
}

#[cfg(test)]
mod tests;
