// SPDX-License-Identifier: MIT OR Apache-2.0
//! Constrained Delaunay triangulation of a rectangle, point by point and edge by edge.
//!
//! The plane, any unit. A triangle knows its corners, its neighbours and its edges' marks: 28 bytes,
//! and there are two to a vertex. A million vertices fit where the half-edges of a general library take
//! three times as much. How time grows with size is how memory is reached. Four corners of a frame
//! round everything that will come spare every case at the hull.
//!
//! Where something is, is decided exactly (Shewchuk 1997, crate `robust`). Whether an edge is Delaunay
//! is decided by the first stage of his in-circle test alone. An edge is flipped only where that stage
//! is certain. Points on one circle, which cost the exact stages most and gain nothing, are left as
//! they are. A certain flip lowers the triangulation lifted to the paraboloid, so flipping ends.

mod constraints;

use crate::index_u32;
use crate::intersection;
use robust::Coord;

/// A position in the plane.
pub type Point = [f64; 2];

/// Corners of the frame; they are the first vertices.
pub const FRAME_CORNERS: usize = 4;
/// No triangle: what is beyond the frame.
const NONE: u32 = u32::MAX;
/// Mark of an edge that must stay.
const CONSTRAINT: u8 = 1;
/// Mark of an edge along which an odd number of constraints run.
const ODD: u8 = 2;
/// Shewchuk (1997), equation for `ccwerrboundA`: (3 + 16ε)ε with ε = 2⁻⁵³.
const ORIENT_BOUND: f64 = 3.330_669_073_875_471_6e-16;
/// The same for `iccerrboundA`: (10 + 96ε)ε.
const INCIRCLE_BOUND: f64 = 1.110_223_024_625_157_7e-15;

/// Why a point or an edge cannot be had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blocked {
    /// The edge crosses another constraint.
    Crossing,
    /// The point is outside the frame.
    Outside,
    /// Flips towards an edge did not end; a fault of this program.
    Endless,
}

/// Where a point lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointLocation {
    /// Strictly within a triangle.
    Face(u32),
    /// On the edge of a triangle opposite its corner of that number.
    Edge(u32, usize),
    /// On a vertex.
    Vertex(u32),
    /// Beyond the frame.
    Outside,
}

/// The corner after one, counter-clockwise, and the one before: a remainder by 3 is a multiplication.
const AFTER: [usize; 3] = [1, 2, 0];
const BEFORE: [usize; 3] = [2, 0, 1];

/// Counter-clockwise; neighbour and mark `i` are those of the edge opposite corner `i`.
///
/// Four bytes more than its parts, so that none lies across two lines of the cache.
#[derive(Clone, Copy)]
#[repr(align(32))]
struct Triangle {
    corners: [u32; 3],
    neighbours: [u32; 3],
    marks: [u8; 3],
    side: Side,
}

/// Of the constraints that a triangle lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Unknown,
    Outside,
    Inside,
}

impl Side {
    /// Across an edge along which so many constraints run.
    fn across(self, is_odd: bool) -> Self {
        match self {
            Self::Outside if is_odd => Self::Inside,
            Self::Inside if is_odd => Self::Outside,
            same => same,
        }
    }
}

impl Triangle {
    fn index_of_corner(&self, vertex: u32) -> usize {
        index_of(self.corners, vertex)
    }

    fn index_of_neighbour(&self, triangle: u32) -> usize {
        index_of(self.neighbours, triangle)
    }
}

/// Place of one of three numbers, of which no two are the same but [`NONE`]; without a branch, since
/// which of them it is is not to be foreseen.
fn index_of(numbers: [u32; 3], number: u32) -> usize {
    usize::from(numbers[1] == number) + 2 * usize::from(numbers[2] == number)
}

/// A position and the way to it. Together, since an edge is flipped after its ends were looked at. In a
/// triangulation that is larger than the cache and the translation buffers, every list of its own is
/// another place of memory to go to.
#[derive(Clone, Copy)]
struct Vertex {
    point: Point,
    /// A triangle that it is a corner of.
    triangle: u32,
}

/// The triangulation.
pub struct Delaunay {
    vertices: Vec<Vertex>,
    triangles: Vec<Triangle>,
    /// Where the search for the next point starts: where the last one went.
    hint: u32,
    /// Triangles whose first edge may be illegal.
    waiting: Vec<u32>,
    /// Whether a vertex lies on a constraint, between its ends.
    touches: bool,
}

impl Delaunay {
    /// An empty frame round `[west, south, east, north]`, with room for so many vertices.
    pub fn new([west, south, east, north]: [f64; 4], vertex_count: usize) -> Self {
        // As wide again on every side, so that no triangle between an outline and the frame is
        // much thinner than the outline itself makes it.
        let margin = (east - west).max(north - south).max(1.0);
        let (west, south) = (west - margin, south - margin);
        let (east, north) = (east + margin, north + margin);
        let count = vertex_count + FRAME_CORNERS;
        let mut vertices = Vec::with_capacity(count);
        let corners = [[west, south], [east, south], [east, north], [west, north]];
        let corners = corners.into_iter().zip([0, 0, 0, 1]);
        vertices.extend(corners.map(|(point, triangle)| Vertex { point, triangle }));
        let mut triangles = Vec::with_capacity(2 * count);
        triangles.extend([
            Triangle {
                corners: [0, 1, 2],
                neighbours: [NONE, 1, NONE],
                marks: [0; 3],
                side: Side::Unknown,
            },
            Triangle {
                corners: [0, 2, 3],
                neighbours: [NONE, NONE, 0],
                marks: [0; 3],
                side: Side::Unknown,
            },
        ]);
        Self {
            vertices,
            triangles,
            hint: 0,
            waiting: Vec::new(),
            touches: false,
        }
    }

    /// Tells inside from outside: whether an odd number of constraints separates a triangle from the
    /// frame. To be called when all constraints are in; points that are inserted later keep it, so
    /// that the triangles need to be gone through only once.
    pub fn find_inside(&mut self) {
        // Nothing is constrained at the frame, so the triangles there are outside.
        let outside = self.vertices[0].triangle;
        self.triangles[outside as usize].side = Side::Outside;
        let mut waiting = vec![outside];
        while let Some(index) = waiting.pop() {
            let triangle = self.triangles[index as usize];
            for (neighbour, mark) in triangle.neighbours.into_iter().zip(triangle.marks) {
                if neighbour == NONE {
                    continue;
                }
                let across = &mut self.triangles[neighbour as usize];
                if across.side == Side::Unknown {
                    across.side = triangle.side.across(mark & ODD != 0);
                    waiting.push(neighbour);
                }
            }
        }
    }

    /// Whether a triangle is inside, once [`Delaunay::find_inside`] has told.
    pub fn is_inside(&self, triangle: u32) -> bool {
        self.triangles[triangle as usize].side == Side::Inside
    }

    /// Those of the frame included.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Those at the frame included.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Where a vertex is.
    pub fn point(&self, vertex: u32) -> Point {
        self.vertices[vertex as usize].point
    }

    /// Corners of a triangle, counter-clockwise.
    pub fn corners(&self, triangle: u32) -> [u32; 3] {
        self.triangles[triangle as usize].corners
    }

    /// Ends of the edge opposite corner `i`, the triangle on their left.
    pub fn ends(&self, triangle: u32, i: usize) -> [u32; 2] {
        let corners = self.triangles[triangle as usize].corners;
        [corners[AFTER[i]], corners[BEFORE[i]]]
    }

    /// The triangle across the edge opposite corner `i`; none beyond the frame.
    pub fn neighbour(&self, triangle: u32, i: usize) -> Option<u32> {
        let neighbour = self.triangles[triangle as usize].neighbours[i];
        (neighbour != NONE).then_some(neighbour)
    }

    /// Whether the edge opposite corner `i` must stay.
    pub fn is_constraint(&self, triangle: u32, i: usize) -> bool {
        self.triangles[triangle as usize].marks[i] & CONSTRAINT != 0
    }

    /// Whether an odd number of constraints run along the edge opposite corner `i`.
    pub fn is_odd(&self, triangle: u32, i: usize) -> bool {
        self.triangles[triangle as usize].marks[i] & ODD != 0
    }

    /// Whether a vertex lies on a constraint, between its ends.
    pub fn has_touches(&self) -> bool {
        self.touches
    }

    /// Every edge once, as a triangle and the corner opposite.
    pub fn edges(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        (0..).zip(&self.triangles).flat_map(|(index, triangle)| {
            let once = move |i: &usize| {
                let neighbour = triangle.neighbours[*i];
                neighbour == NONE || index < neighbour
            };
            (0..3).filter(once).map(move |i| (index, i))
        })
    }

    /// Every edge once that may be flipped, of triangles inside.
    pub fn inner_edges(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        let inside = (0..).zip(&self.triangles);
        let inside = inside.filter(|(_, triangle)| triangle.side == Side::Inside);
        inside.flat_map(|(index, triangle)| {
            let is_free = |i: &usize| triangle.marks[*i] & CONSTRAINT == 0;
            let once = move |i: &usize| index < triangle.neighbours[*i];
            (0..3).filter(is_free).filter(once).map(move |i| (index, i))
        })
    }

    /// Every edge once along which an odd number of constraints run.
    pub fn odd_edges(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        let marked = (0..).zip(&self.triangles);
        let marked = marked.filter(|(_, triangle)| triangle.marks != [0; 3]);
        marked.flat_map(|(index, triangle)| {
            let is_odd = |i: &usize| triangle.marks[*i] & ODD != 0;
            let once = move |i: &usize| index < triangle.neighbours[*i];
            (0..3).filter(is_odd).filter(once).map(move |i| (index, i))
        })
    }

    /// Has the search for the next point start at a vertex.
    pub fn start_at(&mut self, vertex: u32) {
        self.hint = self.vertices[vertex as usize].triangle;
    }

    /// Every edge at a vertex within the frame, as a triangle and the corner opposite.
    pub fn edges_at(&self, vertex: u32) -> impl Iterator<Item = (u32, usize)> + '_ {
        let mut fan = Some(Fan::new(self, vertex));
        std::iter::from_fn(move || {
            let here = fan?;
            fan = here.next(self);
            let i = self.triangles[here.triangle as usize].index_of_corner(vertex);
            Some((here.triangle, BEFORE[i]))
        })
    }

    /// Finds a point, by a walk that turns at random where it may: in a constrained triangulation a
    /// walk by rule can go round for ever (Devillers, Pion & Teillaud 2002).
    pub fn locate(&self, point: Point) -> PointLocation {
        let mut random = 0x9e37_79b9_u32;
        let (mut current, mut last) = (self.hint, NONE);
        'walk: loop {
            random ^= random << 13;
            random ^= random >> 17;
            random ^= random << 5;
            let triangle = &self.triangles[current as usize];
            let first = (random % 3) as usize;
            let mut on = [false; 3];
            for i in [first, AFTER[first], BEFORE[first]] {
                let next = triangle.neighbours[i];
                if next == last && last != NONE {
                    continue;
                }
                let [from, to] = [AFTER[i], BEFORE[i]].map(|k| self.point(triangle.corners[k]));
                let side = orient(from, to, point);
                if side < 0.0 {
                    if next == NONE {
                        return PointLocation::Outside;
                    }
                    (last, current) = (current, next);
                    continue 'walk;
                }
                on[i] = side == 0.0;
            }
            return match on {
                [false, false, false] => PointLocation::Face(current),
                [true, false, false] => PointLocation::Edge(current, 0),
                [false, true, false] => PointLocation::Edge(current, 1),
                [false, false, true] => PointLocation::Edge(current, 2),
                // On two edges is on the corner between them.
                [true, true, _] => PointLocation::Vertex(triangle.corners[2]),
                [true, _, true] => PointLocation::Vertex(triangle.corners[1]),
                [_, true, true] => PointLocation::Vertex(triangle.corners[0]),
            };
        }
    }

    /// The vertex at `point`, new if there was none.
    ///
    /// # Errors
    /// [`Blocked::Outside`].
    pub fn insert(&mut self, point: Point) -> Result<u32, Blocked> {
        let vertex = index_u32(self.vertices.len());
        match self.locate(point) {
            PointLocation::Vertex(known) => {
                self.hint = self.vertices[known as usize].triangle;
                return Ok(known);
            }
            PointLocation::Outside => return Err(Blocked::Outside),
            PointLocation::Face(triangle) => {
                self.split_face(triangle, vertex, point);
            }
            PointLocation::Edge(triangle, i) => {
                if self.triangles[triangle as usize].neighbours[i] == NONE {
                    return Err(Blocked::Outside);
                }
                self.touches |= self.is_constraint(triangle, i);
                self.split_edge(triangle, i, vertex, point);
            }
        }
        self.hint = self.vertices[vertex as usize].triangle;
        self.legalise(point);
        Ok(vertex)
    }

    /// Flips what is illegal across from the vertex at `point`, which is the first corner of every
    /// triangle that waits and of those that a flip makes of it.
    fn legalise(&mut self, point: Point) {
        while let Some(triangle) = self.waiting.pop() {
            let here = &self.triangles[triangle as usize];
            let across = here.neighbours[0];
            if across == NONE || here.marks[0] & CONSTRAINT != 0 {
                continue;
            }
            let there = &self.triangles[across as usize];
            let j = there.index_of_neighbour(triangle);
            let [b, c] = [1, 2].map(|i| self.point(here.corners[i]));
            if is_certainly_in_circle(self.point(there.corners[j]), c, b, point) {
                self.flip_across(triangle, 0, j);
                self.waiting.extend([triangle, across]);
            }
        }
    }

    /// Corner `a`, `b`, `c` → `p b c`, `p c a`, `p a b`.
    fn split_face(&mut self, triangle: u32, p: u32, point: Point) {
        let old = self.triangles[triangle as usize];
        let [a, b, c] = old.corners;
        let second = index_u32(self.triangles.len());
        let third = second + 1;
        self.triangles[triangle as usize] = Triangle {
            corners: [p, b, c],
            neighbours: [old.neighbours[0], second, third],
            marks: [old.marks[0], 0, 0],
            side: old.side,
        };
        self.triangles.push(Triangle {
            corners: [p, c, a],
            neighbours: [old.neighbours[1], third, triangle],
            marks: [old.marks[1], 0, 0],
            side: old.side,
        });
        self.triangles.push(Triangle {
            corners: [p, a, b],
            neighbours: [old.neighbours[2], triangle, second],
            marks: [old.marks[2], 0, 0],
            side: old.side,
        });
        self.relink(old.neighbours[1], triangle, second);
        self.relink(old.neighbours[2], triangle, third);
        self.vertices.push(Vertex { point, triangle });
        self.vertices[a as usize].triangle = second;
        self.vertices[b as usize].triangle = triangle;
        self.vertices[c as usize].triangle = triangle;
        self.waiting.extend([triangle, second, third]);
    }

    /// `a b c` and, across its edge `b c`, `d c b` → `p a b`, `p c a`, `p d c`, `p b d`. Both halves of
    /// the edge keep its marks.
    fn split_edge(&mut self, triangle: u32, i: usize, p: u32, point: Point) {
        let here = self.triangles[triangle as usize];
        let across = here.neighbours[i];
        let there = self.triangles[across as usize];
        let j = there.index_of_neighbour(triangle);
        let [a, b, c] = [i, i + 1, i + 2].map(|k| here.corners[k % 3]);
        let d = there.corners[j];
        let mark = here.marks[i];
        let (ca, ab) = ((i + 1) % 3, (i + 2) % 3);
        let (bd, dc) = ((j + 1) % 3, (j + 2) % 3);
        let at_ca = index_u32(self.triangles.len());
        let at_dc = at_ca + 1;
        self.triangles[triangle as usize] = Triangle {
            corners: [p, a, b],
            neighbours: [here.neighbours[ab], across, at_ca],
            marks: [here.marks[ab], mark, 0],
            side: here.side,
        };
        self.triangles[across as usize] = Triangle {
            corners: [p, b, d],
            neighbours: [there.neighbours[bd], at_dc, triangle],
            marks: [there.marks[bd], 0, mark],
            side: there.side,
        };
        self.triangles.push(Triangle {
            corners: [p, c, a],
            neighbours: [here.neighbours[ca], triangle, at_dc],
            marks: [here.marks[ca], 0, mark],
            side: here.side,
        });
        self.triangles.push(Triangle {
            corners: [p, d, c],
            neighbours: [there.neighbours[dc], at_ca, across],
            marks: [there.marks[dc], mark, 0],
            side: there.side,
        });
        self.relink(here.neighbours[ca], triangle, at_ca);
        self.relink(there.neighbours[dc], across, at_dc);
        self.vertices.push(Vertex { point, triangle });
        self.vertices[a as usize].triangle = triangle;
        self.vertices[b as usize].triangle = triangle;
        self.vertices[c as usize].triangle = at_ca;
        self.vertices[d as usize].triangle = across;
        self.waiting.extend([triangle, across, at_ca, at_dc]);
    }

    fn relink(&mut self, triangle: u32, from: u32, to: u32) {
        if triangle != NONE {
            let triangle = &mut self.triangles[triangle as usize];
            let i = triangle.index_of_neighbour(from);
            triangle.neighbours[i] = to;
        }
    }

    /// Whether the edge opposite corner `i` may be flipped and is certain to gain by it.
    fn is_certainly_illegal(&self, triangle: u32, i: usize) -> bool {
        let here = &self.triangles[triangle as usize];
        let across = here.neighbours[i];
        if across == NONE || here.marks[i] & CONSTRAINT != 0 {
            return false;
        }
        let there = &self.triangles[across as usize];
        let d = there.corners[there.index_of_neighbour(triangle)];
        let [p, b, c] = [i, AFTER[i], BEFORE[i]].map(|k| self.point(here.corners[k]));
        is_certainly_in_circle(self.point(d), c, b, p)
    }

    /// Flips the edges across from a vertex that are illegal, be it by less than the first stage can
    /// tell, and whatever becomes illegal by that; returns one end of each edge that this makes.
    ///
    /// Ends, as by the first stage alone: each flip lowers the lifted triangulation. Of two triangles
    /// that an illegal edge lies between, the four corners are strictly convex.
    pub fn legalise_exactly(&mut self, vertex: u32) -> Vec<u32> {
        let across = |(triangle, i): (u32, usize)| self.ends(triangle, (i + 1) % 3);
        let mut waiting: Vec<[u32; 2]> = self.edges_at(vertex).map(across).collect();
        let mut made = Vec::new();
        while let Some([u, v]) = waiting.pop() {
            let Ok((triangle, i)) = self.edge_between(u, v) else {
                continue;
            };
            let Some([p, d]) = self.opposite(triangle, i) else {
                continue;
            };
            let [b, c] = self.ends(triangle, i);
            let corners = [p, b, c, d].map(|k| self.point(k));
            if !self.is_constraint(triangle, i) && is_in_circle(corners) {
                self.flip(triangle, i);
                made.push(p);
                waiting.extend([[p, b], [b, d], [d, c], [c, p]]);
            }
        }
        made
    }

    /// `p b c` and, across `b c`, `d c b` → `p b d` and `p d c`; the caller knows that the four are
    /// strictly convex.
    fn flip(&mut self, triangle: u32, i: usize) {
        let across = self.triangles[triangle as usize].neighbours[i];
        let j = self.triangles[across as usize].index_of_neighbour(triangle);
        self.flip_across(triangle, i, j);
    }

    /// As [`Delaunay::flip`], by the corner `j` opposite the edge on its other side.
    #[inline]
    fn flip_across(&mut self, triangle: u32, i: usize, j: usize) {
        let here = self.triangles[triangle as usize];
        let across = here.neighbours[i];
        let there = self.triangles[across as usize];
        let (cp, pb) = (AFTER[i], BEFORE[i]);
        let (bd, dc) = (AFTER[j], BEFORE[j]);
        let [p, b, c] = [i, cp, pb].map(|k| here.corners[k]);
        let d = there.corners[j];
        self.triangles[triangle as usize] = Triangle {
            corners: [p, b, d],
            neighbours: [there.neighbours[bd], across, here.neighbours[pb]],
            marks: [there.marks[bd], 0, here.marks[pb]],
            side: here.side,
        };
        self.triangles[across as usize] = Triangle {
            corners: [p, d, c],
            neighbours: [there.neighbours[dc], here.neighbours[cp], triangle],
            marks: [there.marks[dc], here.marks[cp], 0],
            side: here.side,
        };
        self.relink(there.neighbours[bd], across, triangle);
        self.relink(here.neighbours[cp], triangle, across);
        self.vertices[b as usize].triangle = triangle;
        self.vertices[c as usize].triangle = across;
    }

    /// The edge between two vertices, as a triangle and the corner opposite; the end with fewer
    /// triangles if there is none. Both ends are searched in step: a vertex may have as many
    /// triangles as there are others.
    pub fn edge_between(&self, a: u32, b: u32) -> Result<(u32, usize), u32> {
        let mut fans = [(Fan::new(self, a), b), (Fan::new(self, b), a)];
        loop {
            for (fan, other) in &mut fans {
                let triangle = &self.triangles[fan.triangle as usize];
                let i = triangle.index_of_corner(fan.vertex);
                if triangle.corners[AFTER[i]] == *other {
                    return Ok((fan.triangle, BEFORE[i]));
                }
                if triangle.corners[BEFORE[i]] == *other {
                    return Ok((fan.triangle, AFTER[i]));
                }
                match fan.next(self) {
                    Some(next) => *fan = next,
                    None => return Err(fan.vertex),
                }
            }
        }
    }

    /// The corners opposite an edge, on its own side and across.
    fn opposite(&self, triangle: u32, i: usize) -> Option<[u32; 2]> {
        let across = self.neighbour(triangle, i)?;
        let there = &self.triangles[across as usize];
        let j = there.index_of_neighbour(triangle);
        Some([self.corners(triangle)[i], there.corners[j]])
    }
}

/// The triangles round a vertex: counter-clockwise, and at a corner of the frame the rest clockwise.
#[derive(Clone, Copy)]
struct Fan {
    vertex: u32,
    first: u32,
    triangle: u32,
    clockwise: bool,
}

impl Fan {
    fn new(mesh: &Delaunay, vertex: u32) -> Self {
        let first = mesh.vertices[vertex as usize].triangle;
        Self {
            vertex,
            first,
            triangle: first,
            clockwise: false,
        }
    }

    fn next(mut self, mesh: &Delaunay) -> Option<Self> {
        let beside = |triangle: u32, turn: usize| {
            let triangle = &mesh.triangles[triangle as usize];
            triangle.neighbours[(triangle.index_of_corner(self.vertex) + turn) % 3]
        };
        let mut next = if self.clockwise {
            beside(self.triangle, 2)
        } else {
            beside(self.triangle, 1)
        };
        if next == NONE && !self.clockwise {
            self.clockwise = true;
            next = beside(self.first, 2);
        }
        if next == NONE || next == self.first {
            return None;
        }
        self.triangle = next;
        Some(self)
    }
}

/// Positive where `c` is to the left of the line from `a` to `b`, exact in its sign.
#[inline]
fn orient(a: Point, b: Point, c: Point) -> f64 {
    let left = (a[0] - c[0]) * (b[1] - c[1]);
    let right = (a[1] - c[1]) * (b[0] - c[0]);
    let det = left - right;
    if det.abs() >= ORIENT_BOUND * (left.abs() + right.abs()) {
        return det;
    }
    intersection::orient(a, b, c)
}

/// Whether `p` is certain to lie within the circle through `a`, `b`, `c`, counter-clockwise.
fn is_certainly_in_circle(a: Point, b: Point, c: Point, p: Point) -> bool {
    let [a, b, c] = [a, b, c].map(|[x, y]| [x - p[0], y - p[1]]);
    let lift = |[x, y]: Point| x * x + y * y;
    let minors = [(a, b, c), (b, c, a), (c, a, b)].map(|(lifted, from, to)| {
        let (plus, minus) = (from[0] * to[1], to[0] * from[1]);
        (lift(lifted), plus, minus)
    });
    let det = minors.iter().fold(0.0, |det, (lifted, plus, minus)| {
        det + lifted * (plus - minus)
    });
    // Most are outside, whatever the bound.
    if det <= 0.0 {
        return false;
    }
    let permanent = minors.iter().fold(0.0, |permanent, (lifted, plus, minus)| {
        permanent + lifted * (plus.abs() + minus.abs())
    });
    det > INCIRCLE_BOUND * permanent
}

/// Whether the last lies within the circle through the others, counter-clockwise; exact.
fn is_in_circle(corners: [Point; 4]) -> bool {
    let [a, b, c, p] = corners.map(|[x, y]| Coord { x, y });
    robust::incircle(a, b, c, p) > 0.0
}

#[cfg(test)]
mod tests;
