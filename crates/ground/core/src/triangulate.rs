// SPDX-License-Identifier: MIT OR Apache-2.0
//! Closed edges in the plane of longitude and latitude → triangles of what they enclose.
//!
//! Degrees. Constrained Delaunay (see `delaunay`), inside and outside by the even-odd rule, then interior
//! points so that no cap facet is much longer than the step asked for. Longitudes are scaled by the power
//! of two nearest to the cosine of the middle latitude. Triangles come out well shaped on the body, and
//! not one bit of a coordinate changes. So predicates remain exact for the numbers of the file.

mod insertion_order;

use crate::crossings::{self, CrossingPlaces, crossing_places, find_crossings, split_outline};
use crate::edge::{Degrees, arc_rad, great_ellipse_crossing};
use crate::lens::{LensCorner, WithinRounding, any_in_lens, follow_arcs, sight_of};
use crate::mesh::LONGEST_INTERIOR_EDGE_STEPS;
use crate::pieces::{OutlineEdge, bounds};
use crate::{EdgeRule, MeshOptions};
use insertion_order::{Corners, in_order, odd_edges};
use terrafill_planar::delaunay::{Blocked, Delaunay, FRAME_CORNERS, PointLocation};
use terrafill_planar::index_u32;
use terrafill_planar::intersection::{Crossing, without_underflow};

/// Interior edges that span more longitude than this are halved: beyond it, close to a pole, a
/// triangle that is small on the body can still be turned over.
pub(crate) const WIDEST_INTERIOR_EDGE_DEG: f64 = 45.0;
/// Widest spacing of lattice points, degrees of longitude: twelve round a pole.
const WIDEST_LATTICE_STEP_DEG: f64 = 30.0;
/// Lattice points closer than this to the boundary, in steps, are left out: they make slivers.
const LATTICE_CLEARANCE_STEPS: f64 = 0.5;
/// Rounds of halving: the plane's width divided by 2¹⁶ is far below any step allowed.
const MAX_ROUNDS: usize = 16;
/// Where an edge that is too long is split, in this order and as long as it is still there. Binary
/// fractions: at a pole and at the antimeridian no product is rounded.
const SPLIT_SHARES: [f64; 5] = [0.5, 0.4375, 0.5625, 0.375, 0.625];

/// Triangles of one group of edges.
pub(crate) struct GroupMesh {
    pub(crate) vertices: Vec<Degrees>,
    /// Counter-clockwise in longitude and latitude.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Directed edges with the inside on the left.
    pub(crate) boundary: Vec<[u32; 2]>,
    /// Whether arcs were split because their chords crossed.
    pub(crate) arcs_followed: bool,
}

/// What has become of great-ellipse arcs before their chords are triangulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Arcs {
    /// Split for the boundary's tolerance only.
    AsDrawn,
    /// Followed as far as they can be, or moved with their chords.
    Settled,
}

/// Why a group could not be triangulated.
pub(crate) enum TriangulateError {
    /// Edges cross other than at a common vertex.
    Crossings {
        /// In order of their place in the file; at least one.
        found: Vec<CrossingPlaces>,
        /// Whether these are all.
        complete: bool,
    },
    /// The step asks for more points inside than [`MAX_LATTICE_POINTS`].
    TooFine {
        /// About how many.
        points: f64,
    },
    /// The triangulation refused; a fault in this program rather than in the file.
    Refused(String),
}

/// Triangulates what `edges`, a closed chain modulo 2, enclose.
///
/// The plane sees straight lines for great-ellipse arcs, within the boundary tolerance of them. Where two
/// of those lines cross although the arcs do not, arcs are split on their way if `arcs` says so. What
/// crosses even then becomes a vertex.
pub(crate) fn triangulate(
    edges: Vec<OutlineEdge>,
    rule: EdgeRule,
    options: &MeshOptions,
    arcs: Arcs,
) -> Result<GroupMesh, TriangulateError> {
    let mut group = load_without_false_crossings(edges, rule, arcs)?;
    group.mesh.find_inside();
    if group.reaches_beyond(options.cap_step_deg) {
        let points = group.lattice_points(options.cap_step_deg);
        if points > MAX_LATTICE_POINTS {
            return Err(TriangulateError::TooFine { points });
        }
        group.refine(options.cap_step_deg)?;
    }
    group.extract()
}

/// Points that a cap step may add to a group: as many as the largest region has vertices. Eight million
/// triangles take some gigabytes until they are a mesh.
pub(crate) const MAX_LATTICE_POINTS: f64 = 4e6;

/// Crossings of one group that are looked for: a list that long helps nobody, and a ring that
/// crosses itself everywhere has as many as the square of its edges.
const MAX_CROSSINGS: usize = 10_000;

fn load_without_false_crossings(
    edges: Vec<OutlineEdge>,
    rule: EdgeRule,
    arcs: Arcs,
) -> Result<Group, TriangulateError> {
    if rule == EdgeRule::Planar || arcs == Arcs::Settled {
        return load_split_at_crossings(edges, rule);
    }
    let drawn = match Group::load(&edges)? {
        Some(group) if !group.is_vertex_in_lens() => return Ok(group),
        drawn => drawn,
    };
    let followed = follow_arcs(edges.clone(), WithinRounding::Kept);
    // Not by their number alone: what cancels is left out, and feet are added.
    let ends = |edge: &OutlineEdge| (edge.start, edge.end);
    let is_unchanged = followed.iter().map(ends).eq(edges.iter().map(ends));
    if is_unchanged && let Some(group) = drawn {
        return Ok(group);
    }
    if let Ok(group) = load_split_at_crossings(followed, rule) {
        return Ok(Group {
            arcs_followed: true,
            ..group
        });
    }
    // The chords are within the tolerance as they were.
    drawn.map_or_else(|| load_split_at_crossings(edges, rule), Ok)
}

fn load_split_at_crossings(
    mut edges: Vec<OutlineEdge>,
    rule: EdgeRule,
) -> Result<Group, TriangulateError> {
    for _ in 0..crossings::MAX_ROUNDS {
        if let Some(group) = Group::load(&edges)? {
            return Ok(group);
        }
        let found = false_crossings(&edges, rule)?;
        edges = split_outline(&edges, &found);
    }
    match Group::load(&edges)? {
        Some(group) => Ok(group),
        // What comes again with every rounding is refused as what the plane sees.
        None => Err(false_crossings(&edges, EdgeRule::Planar)
            .err()
            .unwrap_or_else(|| refused("crossings of chords could not be resolved"))),
    }
}

/// Crossings of chords of which the arcs do not cross; at least one.
///
/// # Errors
/// Where edges cross by their rule.
fn false_crossings(
    edges: &[OutlineEdge],
    rule: EdgeRule,
) -> Result<Vec<Crossing>, TriangulateError> {
    let ends: Vec<[Degrees; 2]> = edges.iter().map(|edge| [edge.start, edge.end]).collect();
    let (found, complete) = find_crossings(EdgeRule::Planar, &ends, MAX_CROSSINGS);
    let crosses = |&([a, b], at): &Crossing| match rule {
        EdgeRule::Planar => Some(([a, b], at)),
        EdgeRule::GreatEllipse => great_ellipse_crossing(ends[a], ends[b]).map(|at| ([a, b], at)),
    };
    let by_rule: Vec<Crossing> = found.iter().filter_map(crosses).collect();
    if !by_rule.is_empty() {
        return Err(TriangulateError::Crossings {
            found: crossing_places(edges, &by_rule),
            complete,
        });
    }
    if found.is_empty() {
        return Err(refused("a crossing edge crosses no edge"));
    }
    Ok(found)
}

fn refused(message: &str) -> TriangulateError {
    TriangulateError::Refused(message.to_owned())
}

impl From<Blocked> for TriangulateError {
    fn from(blocked: Blocked) -> Self {
        Self::Refused(
            match blocked {
                Blocked::Crossing => "an edge crosses another",
                Blocked::Outside => "a point is outside its bounds",
                Blocked::Endless => "an edge could not be put in",
            }
            .to_owned(),
        )
    }
}

struct Group {
    /// Of longitudes times `scale`, and latitudes.
    mesh: Delaunay,
    /// Power of two that longitudes are multiplied by.
    scale: f64,
    /// Its inverse, as exact.
    unscale: f64,
    /// Indices of the outline's vertices in the order of the outline; some occur more than once.
    outline_order: Vec<u32>,
    /// `[west, south, east, north]`.
    bounds: [f64; 4],
    /// See [`GroupMesh`].
    arcs_followed: bool,
}

impl Group {
    /// `None` where edges cross.
    fn load(edges: &[OutlineEdge]) -> Result<Option<Self>, TriangulateError> {
        let bounds = bounds(edges);
        let cosine = (0.5 * (bounds[1] + bounds[3])).to_radians().cos();
        let scale = cosine.log2().round().clamp(-12.0, 0.0).exp2();
        let corners = Corners::new(edges);
        let count = corners.positions.len();
        let [west, south, east, north] = bounds;
        let mesh = Delaunay::new([west * scale, south, east * scale, north], count);
        let mut group = Self {
            mesh,
            scale,
            unscale: scale.recip(),
            outline_order: vec![0; count],
            bounds,
            arcs_followed: false,
        };
        for (new_corners, new_edges) in corners.rounds() {
            for corner in new_corners {
                // From the corner before it, if that is in: 0 is a corner of the frame.
                let before = group.outline_order[corner.saturating_sub(1) as usize];
                if before != 0 {
                    group.mesh.start_at(before);
                }
                let vertex = group.insert(corners.positions[corner as usize])?;
                group.outline_order[corner as usize] = vertex;
            }
            let ends = new_edges.map(|ends| ends.map(|i| group.outline_order[i as usize]));
            for [from, to] in odd_edges(ends, group.mesh.vertex_count()) {
                match group.mesh.constrain(from, to) {
                    Ok(()) => {}
                    Err(Blocked::Crossing) => return Ok(None),
                    Err(blocked) => return Err(blocked.into()),
                }
            }
        }
        Ok(Some(group))
    }

    /// Whether anything can be longer than the step; most islands are not.
    fn reaches_beyond(&self, step_deg: f64) -> bool {
        let [west, south, east, north] = self.bounds;
        (east - west).hypot(north - south) > step_deg
    }

    fn planar(&self, position: Degrees) -> [f64; 2] {
        [position[0] * self.scale, position[1]]
    }

    /// Degrees. The scale being a power of two, not one bit is lost on the way there and back.
    fn position(&self, vertex: u32) -> Degrees {
        let [x, y] = self.mesh.point(vertex);
        [x * self.unscale, y]
    }

    fn insert(&mut self, position: Degrees) -> Result<u32, TriangulateError> {
        let position = position.map(without_underflow);
        Ok(self.mesh.insert(self.planar(position))?)
    }

    /// Whether a vertex lies on an edge, or between one and its arc.
    ///
    /// That is the third corner of the triangle beside the edge, which sees it at the widest angle, unless
    /// that triangle is so flat that the arc leaves it on another side.
    fn is_vertex_in_lens(&self) -> bool {
        if self.mesh.has_touches() {
            return true;
        }
        let edges = self.mesh.edges();
        let constraints = edges.filter(|&(triangle, i)| self.mesh.is_constraint(triangle, i));
        let mut hidden = Vec::new();
        for (triangle, i) in constraints {
            let ends = self.mesh.ends(triangle, i);
            let across = self.mesh.neighbour(triangle, i);
            let arc = ends.map(|vertex| self.position(vertex));
            let corners = [Some(triangle), across].into_iter().flatten();
            let corners = corners.flat_map(|triangle| self.mesh.corners(triangle));
            for corner in corners.filter(|corner| !ends.contains(corner)) {
                match sight_of(arc, self.position(corner)) {
                    LensCorner::InLens if corner as usize >= FRAME_CORNERS => return true,
                    LensCorner::Clear => {}
                    LensCorner::InLens | LensCorner::Hidden => hidden.push(arc),
                }
            }
        }
        if hidden.is_empty() {
            return false;
        }
        let outline = self.outline_order.iter();
        let places: Vec<Degrees> = outline.map(|vertex| self.position(*vertex)).collect();
        any_in_lens(&hidden, &places)
    }

    /// Adds interior points until no interior edge is too long.
    ///
    /// Every edge that an insertion makes ends at the point inserted, so after the first look only
    /// the edges of new points are looked at.
    fn refine(&mut self, step_deg: f64) -> Result<(), TriangulateError> {
        let mut long: Vec<[u32; 2]> = self
            .mesh
            .inner_edges()
            .map(|(triangle, i)| self.mesh.ends(triangle, i))
            .filter(|ends| self.is_too_long(*ends, step_deg))
            .collect();
        let mut new = self.insert_lattice(step_deg)?;
        long.retain(|ends| self.is_edge(*ends));
        for _ in 0..MAX_ROUNDS {
            long.extend(self.long_edges_at(&new, step_deg));
            if long.is_empty() {
                break;
            }
            new.clear();
            for ends in long.drain(..) {
                self.split(ends, &mut new)?;
            }
        }
        Ok(())
    }

    /// Inserts points of an edge until it is gone, by its middle but for a few; adds to `new` what
    /// has new edges.
    ///
    /// The middle is rounded. Where an edge lies between neighbours a rounding away, its middle comes to
    /// lie beside it or is there already. To the first stage of the in-circle test all of them are one
    /// line. So the edge stayed, with no end that would have been looked at again.
    fn split(&mut self, ends: [u32; 2], new: &mut Vec<u32>) -> Result<(), TriangulateError> {
        for share in SPLIT_SHARES {
            let before = self.mesh.vertex_count();
            let vertex = self.insert(self.place_along(ends, share))?;
            if vertex as usize == before {
                new.push(vertex);
            }
            if !self.is_edge(ends) {
                break;
            }
            new.extend(self.mesh.legalise_exactly(vertex));
            if !self.is_edge(ends) || !self.has_room(ends) {
                break;
            }
        }
        Ok(())
    }

    fn is_edge(&self, [from, to]: [u32; 2]) -> bool {
        self.mesh.edge_between(from, to).is_ok()
    }

    /// Whether there are numbers between the coordinates of both ends; if not, every point of the
    /// edge is rounded to beside it.
    fn has_room(&self, ends: [u32; 2]) -> bool {
        let [a, b] = ends.map(|end| self.position(end));
        let middle = self.place_along(ends, 0.5);
        [0, 1]
            .into_iter()
            .all(|i| middle[i] != a[i] && middle[i] != b[i])
    }

    /// Edges that are too long among those that end at one of these vertices.
    fn long_edges_at(&self, new: &[u32], step_deg: f64) -> Vec<[u32; 2]> {
        let mut long: Vec<[u32; 2]> = Vec::new();
        for vertex in new {
            for (triangle, i) in self.mesh.edges_at(*vertex) {
                let [from, to] = self.mesh.ends(triangle, i);
                let ends = [from.min(to), from.max(to)];
                // A point that came to lie on the outline has edges outside, which may be as long as the
                // way round from +180 to −180.
                let is_inner =
                    self.mesh.is_inside(triangle) && !self.mesh.is_constraint(triangle, i);
                if is_inner && self.is_too_long(ends, step_deg) {
                    long.push(ends);
                }
            }
        }
        long.sort_unstable();
        long.dedup();
        long
    }

    /// The point of an edge at this share of the way from its first end.
    fn place_along(&self, ends: [u32; 2], share: f64) -> Degrees {
        let [a, b] = ends.map(|end| self.position(end));
        [0, 1].map(|i| (1.0 - share) * a[i] + share * b[i])
    }

    /// About how many points [`Self::insert_lattice`] will add: the area inside, in steps.
    fn lattice_points(&self, step_deg: f64) -> f64 {
        let triangles = 0..index_u32(self.mesh.triangle_count());
        let inside = triangles.filter(|triangle| self.mesh.is_inside(*triangle));
        let steps = inside.map(|triangle| {
            let [a, b, c] = self
                .mesh
                .corners(triangle)
                .map(|corner| self.position(corner));
            let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
            let middle = (a[1] + b[1] + c[1]) / 3.0;
            0.5 * twice.abs() * middle.to_radians().cos() / (step_deg * step_deg)
        });
        steps.sum()
    }

    /// Points on parallels that are multiples of the step apart, about one step apart on each.
    fn insert_lattice(&mut self, step_deg: f64) -> Result<Vec<u32>, TriangulateError> {
        let [west, south, east, north] = self.bounds;
        let mut chosen = Vec::new();
        let mut row = (south / step_deg).ceil();
        while row * step_deg <= north.min(90.0 - 1e-9) {
            let latitude = row * step_deg;
            row += 1.0;
            let cosine = latitude.to_radians().cos();
            let wanted = (step_deg / cosine).clamp(step_deg, WIDEST_LATTICE_STEP_DEG);
            let spacing = 360.0 / (360.0 / wanted).ceil();
            let mut column = ((west + 180.0) / spacing).ceil();
            while column * spacing - 180.0 <= east {
                let longitude = column * spacing - 180.0;
                column += 1.0;
                let clearance = LATTICE_CLEARANCE_STEPS * step_deg;
                if self.is_clear([longitude, latitude], cosine, clearance) {
                    chosen.push([longitude, latitude]);
                }
            }
        }
        let mut new = Vec::with_capacity(chosen.len());
        for position in chosen {
            new.push(self.insert(position)?);
        }
        Ok(new)
    }

    /// Whether a place is inside and far enough from the corners and marked edges of its face.
    fn is_clear(&self, position: Degrees, cosine: f64, clearance_deg: f64) -> bool {
        let PointLocation::Face(triangle) = self.mesh.locate(self.planar(position)) else {
            return false;
        };
        if !self.mesh.is_inside(triangle) {
            return false;
        }
        let local = |vertex: u32| {
            let [longitude, latitude] = self.position(vertex);
            [(longitude - position[0]) * cosine, latitude - position[1]]
        };
        (0..3).all(|i| {
            let [from, to] = self.mesh.ends(triangle, i).map(local);
            let near = if self.mesh.is_odd(triangle, i) {
                distance_to_segment(from, to)
            } else {
                from[0].hypot(from[1])
            };
            near >= clearance_deg
        })
    }

    /// Whether an edge is longer than that of a facet may be.
    fn is_too_long(&self, ends: [u32; 2], step_deg: f64) -> bool {
        let longest_deg = LONGEST_INTERIOR_EDGE_STEPS * step_deg;
        let [a, b] = ends.map(|end| self.position(end));
        let (width, height) = ((b[0] - a[0]).abs(), b[1] - a[1]);
        // A million edges are looked at, most of them short: no square root.
        width * width + height * height > longest_deg * longest_deg
            && (width > WIDEST_INTERIOR_EDGE_DEG || arc_rad(a, b).to_degrees() > longest_deg)
    }

    fn extract(self) -> Result<GroupMesh, TriangulateError> {
        let inside: Vec<bool> = (0..index_u32(self.mesh.triangle_count()))
            .map(|triangle| self.mesh.is_inside(triangle))
            .collect();
        let count = inside.iter().filter(|inside| **inside).count();
        let mut triangles = Vec::with_capacity(count);
        let count = self.mesh.vertex_count();
        let mut used = vec![false; count];
        for (triangle, _) in (0..).zip(&inside).filter(|(_, inside)| **inside) {
            let corners = self.mesh.corners(triangle);
            for &i in &corners {
                used[i as usize] = true;
            }
            triangles.push(corners);
        }
        // In the order of the outline: what is done with neighbours stays close in memory.
        let mut new_index = vec![u32::MAX; count];
        let mut vertices = Vec::with_capacity(count);
        let interior = 0..index_u32(count);
        for vertex in self.outline_order.iter().copied().chain(interior) {
            let old = vertex as usize;
            if used[old] && new_index[old] == u32::MAX {
                new_index[old] = index_u32(vertices.len());
                vertices.push(self.position(vertex));
            }
        }
        for corners in &mut triangles {
            *corners = corners.map(|i| new_index[i as usize]);
        }
        let mut boundary = Vec::with_capacity(self.outline_order.len());
        for (triangle, i) in self.mesh.odd_edges() {
            let left = inside[triangle as usize];
            let across = self.mesh.neighbour(triangle, i);
            if across.is_none_or(|across| inside[across as usize] == left) {
                let message = "an edge has the same side twice".to_owned();
                return Err(TriangulateError::Refused(message));
            }
            let [from, to] = self
                .mesh
                .ends(triangle, i)
                .map(|end| new_index[end as usize]);
            boundary.push(if left { [from, to] } else { [to, from] });
        }
        Ok(GroupMesh {
            boundary: in_order(boundary, vertices.len()),
            vertices,
            triangles,
            arcs_followed: self.arcs_followed,
        })
    }
}

/// Of the origin.
fn distance_to_segment(from: [f64; 2], to: [f64; 2]) -> f64 {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let along = -(from[0] * dx + from[1] * dy) / (dx * dx + dy * dy);
    let along = along.clamp(0.0, 1.0);
    (from[0] + along * dx).hypot(from[1] + along * dy)
}

#[cfg(test)]
mod tests;
