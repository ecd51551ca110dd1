// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reference: rays in `f64`, from the eye to what it sees and from there to the sun.
//!
//! Shares nothing with volumes or silhouettes. Each visible point is tested twice:
//!
//! - Test A walks from the point to the sun through a tree of boxes.
//! - Test B looks from the sun down on triangles sorted into a grid across its light. The point is lit if it is of
//!   the first plane there.
//!
//! Where they disagree the pixel is undecided. The sea is a sphere that touches the origin.

use crate::view::{DeckCamera, box_of, whole};
use glam::{DVec2, DVec3};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use terrafill_casters::Mesh;

/// Radius of the sea, m: the mean radius of the Earth.
pub const SEA_RADIUS_M: f64 = 6_371_000.0;
/// Hits nearer than this belong to the point itself: places kilometres away are rounded by 10⁻¹² m, and
/// the distance along a grazing ray by a thousand times that.
pub(crate) const CONTACT_M: f64 = 1e-7;
/// Faces on which the cosine to the sun is below this are edge-on: which side is lit is undecidable.
pub(crate) const EDGE_ON: f64 = 1e-3;
const LEAF_SIZE: usize = 4;
/// Cells of test B's grid along each axis, at most; halved until a triangle is in few of them.
const MAX_CELLS: usize = 512;
const CELLS_PER_TRIANGLE: usize = 64;

/// What a pixel sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Seen {
    /// Nothing.
    Sky,
    /// At this depth, m.
    Sea(f64),
    /// Index of a triangle and its depth, m.
    Triangle(u32, f64),
}

impl Seen {
    /// m; `None` for the sky.
    pub fn depth(self) -> Option<f64> {
        match self {
            Self::Sky => None,
            Self::Sea(depth) | Self::Triangle(_, depth) => Some(depth),
        }
    }
}

/// What the reference says of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// Nothing that could be lit.
    Sky,
    /// Nothing lies between it and the sun.
    Lit,
    /// Turned away from the sun, or behind something.
    Shadow,
    /// On a face that is edge-on to the sun.
    EdgeOn,
    /// The two tests disagree.
    Undecided,
    /// Beyond the range of a lamp, or outside its beam: unlit by itself.
    OutOfReach,
}

/// A picture's truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Pixels.
    pub size: [u32; 2],
    /// Of each pixel, row by row from the top.
    pub seen: Vec<Seen>,
    /// The same.
    pub light: Vec<Light>,
    /// Pixels beside one of the other light: the boundary runs through them.
    pub band: Vec<bool>,
}

impl Truth {
    /// Shadow pixels that a mask has lit, in the band too.
    #[must_use]
    pub fn lost(&self, mask: &[bool]) -> usize {
        let pixels = mask.iter().zip(&self.light);
        pixels
            .filter(|(is_dark, light)| !**is_dark && **light == Light::Shadow)
            .count()
    }

    /// Asks for what a ray through each pixel's centre sees, and its light.
    pub(crate) fn of(view: &DeckCamera, ask: impl Fn(DVec3) -> (Seen, Light) + Sync) -> Self {
        let pixels = (0..view.pixel_count()).into_par_iter().map(|at| {
            let [column, row] = view.pixel(at);
            ask(view.ray(column, row))
        });
        let (seen, light): (Vec<_>, Vec<_>) = pixels.unzip();
        Self {
            size: view.size,
            band: band(view.size, &seen, &light),
            seen,
            light,
        }
    }

    /// Pixels of that light.
    pub fn count(&self, light: Light) -> usize {
        self.light.iter().filter(|own| **own == light).count()
    }

    /// Pixels of which it says whether they are lit.
    pub fn judged(&self) -> usize {
        self.count(Light::Lit) + self.count(Light::Shadow)
    }
}

struct Node {
    low: DVec3,
    high: DVec3,
    /// Of the order of triangles.
    first: usize,
    past: usize,
    /// The first child is the next node; 0 for a leaf.
    second: usize,
}

/// A mesh under a sun, ready for rays.
pub struct Reference<'a> {
    pub(crate) mesh: &'a Mesh,
    to_light: DVec3,
    corners: Vec<[DVec3; 3]>,
    order: Vec<u32>,
    nodes: Vec<Node>,
    grid: Grid,
}

/// Triangles by where they lie across the light.
struct Grid {
    axes: [DVec3; 2],
    low: DVec2,
    /// m.
    extent: DVec2,
    /// Cells along each axis.
    count: usize,
    cells: Vec<Vec<u32>>,
}

impl<'a> Reference<'a> {
    /// Sorts a mesh for rays.
    ///
    /// - `to_light`: unit vector towards the sun
    pub fn new(mesh: &'a Mesh, to_light: DVec3) -> Self {
        let corners: Vec<[DVec3; 3]> = (0..mesh.triangles.len())
            .map(|at| mesh.corners(at))
            .collect();
        let grid = Grid::new(&corners, to_light);
        let mut reference = Self {
            mesh,
            to_light,
            order: (0..).take(corners.len()).collect(),
            corners,
            nodes: Vec::new(),
            grid,
        };
        if !reference.corners.is_empty() {
            reference.split(0, reference.corners.len());
        }
        reference
    }

    fn split(&mut self, first: usize, past: usize) {
        let own = self.order[first..past].iter();
        let [low, high] = box_of(own.flat_map(|at| &self.corners[*at as usize]));
        let node = self.nodes.len();
        self.nodes.push(Node {
            low,
            high,
            first,
            past,
            second: 0,
        });
        if past - first <= LEAF_SIZE {
            return;
        }
        let extent = (high - low).to_array();
        let axis = (0..3)
            .max_by(|a, b| extent[*a].total_cmp(&extent[*b]))
            .unwrap_or(0);
        let middle = first.midpoint(past);
        let corners = &self.corners;
        let key = |at: &u32| {
            corners[*at as usize]
                .iter()
                .map(|place| place[axis])
                .sum::<f64>()
        };
        self.order[first..past]
            .select_nth_unstable_by(middle - first, |a, b| key(a).total_cmp(&key(b)));
        self.split(first, middle);
        self.nodes[node].second = self.nodes.len();
        self.split(middle, past);
    }

    /// Calls `meet` with every triangle that the ray meets and how far along it, until it returns the
    /// farthest distance that still matters.
    pub(crate) fn walk(&self, from: DVec3, along: DVec3, mut meet: impl FnMut(u32, f64) -> f64) {
        let mut farthest = f64::INFINITY;
        let inverse = along.recip();
        let mut stack = vec![0];
        while let Some(at) = stack.pop() {
            let Some(node) = self.nodes.get(at) else {
                return;
            };
            let (a, b) = ((node.low - from) * inverse, (node.high - from) * inverse);
            // A box thinner than the rounding of its distances is still met.
            let enter = a.min(b).max_element() - CONTACT_M;
            let leave = a.max(b).min_element() + CONTACT_M;
            if enter > leave || leave < 0.0 || enter > farthest {
                continue;
            }
            if node.second != 0 {
                stack.extend([node.second, at + 1]);
                continue;
            }
            for &triangle in &self.order[node.first..node.past] {
                if let Some(distance) = meets(&self.corners[triangle as usize], from, along) {
                    farthest = meet(triangle, distance);
                }
            }
        }
    }

    /// The first thing on a ray from the eye, 1 m deep a unit.
    pub fn seen(&self, eye: DVec3, ray: DVec3, near: f64) -> Seen {
        let mut best = (f64::INFINITY, 0);
        self.walk(eye, ray, |triangle, distance| {
            if distance >= near && (distance, triangle) < best {
                best = (distance, triangle);
            }
            best.0
        });
        match sea_distance(eye, ray) {
            Some(sea) if sea < best.0 => Seen::Sea(sea),
            _ if best.0 < f64::INFINITY => Seen::Triangle(best.1, best.0),
            _ => Seen::Sky,
        }
    }

    /// Test A: whether something lies between a place and the sun, of other planes than `own`.
    pub fn is_shadowed(&self, place: DVec3, own: Option<u32>) -> bool {
        let mut is_shadowed = false;
        self.walk(place, self.to_light, |triangle, distance| {
            let plane = self.mesh.planes[triangle as usize];
            is_shadowed |= distance > CONTACT_M && own != Some(plane);
            if is_shadowed {
                f64::NEG_INFINITY
            } else {
                f64::INFINITY
            }
        });
        is_shadowed
    }

    /// Test A by every triangle, one after the other.
    #[cfg(test)]
    fn is_shadowed_by_any(&self, place: DVec3, own: Option<u32>) -> bool {
        let all = self.corners.iter().zip(&self.mesh.planes);
        all.filter(|(_, plane)| own != Some(**plane))
            .any(|(corners, _)| {
                meets(corners, place, self.to_light).is_some_and(|distance| distance > CONTACT_M)
            })
    }

    /// Test B: whether the first plane from the sun down through a place is another one.
    fn is_covered(&self, place: DVec3, own: Option<u32>) -> bool {
        let first = self.grid.first(&self.corners, place, self.to_light);
        first.is_some_and(|(triangle, above)| {
            above > CONTACT_M && own != Some(self.mesh.planes[triangle as usize])
        })
    }

    /// Of the casters, where what is seen is one.
    pub(crate) fn plane(&self, seen: Seen) -> Option<u32> {
        match seen {
            Seen::Sky | Seen::Sea(_) => None,
            Seen::Triangle(triangle, _) => Some(self.mesh.planes[triangle as usize]),
        }
    }

    /// How far a place is from the plane of a triangle that is seen, or from the sea, m; infinite from the sky.
    pub fn away(&self, seen: Seen, place: DVec3) -> f64 {
        match seen {
            Seen::Sky => f64::INFINITY,
            Seen::Sea(_) => ((place + DVec3::Z * SEA_RADIUS_M).length() - SEA_RADIUS_M).abs(),
            Seen::Triangle(triangle, _) => {
                let plane = self.mesh.planes[triangle as usize] as usize;
                let normal = self.mesh.normals[plane].normalize_or_zero();
                let [corner, ..] = self.corners[triangle as usize];
                normal.dot(place - corner).abs()
            }
        }
    }

    /// Light of a visible point.
    pub fn light(&self, view: &DeckCamera, ray: DVec3, seen: Seen) -> Light {
        let Some(depth) = seen.depth() else {
            return Light::Sky;
        };
        let own = self.plane(seen);
        let place = view.eye + ray * depth;
        let cosine = own.map(|plane| {
            let normal = self.mesh.normals[plane as usize];
            normal.normalize_or_zero().dot(self.to_light)
        });
        if cosine.is_some_and(|cosine| cosine.abs() < EDGE_ON) {
            return Light::EdgeOn;
        }
        let is_turned_away = cosine.is_some_and(|cosine| cosine <= 0.0);
        let from_below = is_turned_away || self.is_shadowed(place, own);
        match (from_below, self.is_covered(place, own)) {
            (true, true) => Light::Shadow,
            (false, false) => Light::Lit,
            _ => Light::Undecided,
        }
    }

    /// What each pixel sees, and its light.
    pub fn picture(&self, view: &DeckCamera) -> Truth {
        Truth::of(view, |ray| {
            let seen = self.seen(view.eye, ray, view.near);
            (seen, self.light(view, ray, seen))
        })
    }
}

/// Pixels with a neighbour of the other light.
fn band([width, height]: [u32; 2], seen: &[Seen], light: &[Light]) -> Vec<bool> {
    let (width, height) = (width as usize, height as usize);
    (0..seen.len())
        .map(|at| {
            let (column, row) = (at % width, at / width);
            let rows = row.saturating_sub(1)..(row + 2).min(height);
            rows.into_iter().any(|row| {
                let columns = column.saturating_sub(1)..(column + 2).min(width);
                columns
                    .into_iter()
                    .any(|column| light[row * width + column] != light[at])
            })
        })
        .collect()
}

/// Signs of the volumes that the ray spans with each edge, and how far along its plane is.
fn meets([a, b, c]: &[DVec3; 3], from: DVec3, along: DVec3) -> Option<f64> {
    let (a, b, c) = (a - from, b - from, c - from);
    let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|side| side.dot(along));
    if !(sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)) {
        return None;
    }
    let normal = (b - a).cross(c - a);
    let slope = normal.dot(along);
    let distance = (slope != 0.0).then(|| normal.dot(a) / slope);
    distance.filter(|distance| *distance > 0.0)
}

/// Where a ray enters the sea.
fn sea_distance(from: DVec3, along: DVec3) -> Option<f64> {
    let centre = from + DVec3::Z * SEA_RADIUS_M;
    let (a, b) = (along.dot(along), centre.dot(along));
    // |centre|² − R², without the difference of two large squares.
    let c = from.dot(from) + 2.0 * SEA_RADIUS_M * from.z;
    let discriminant = b * b - a * c;
    (b < 0.0 && c > 0.0 && discriminant >= 0.0).then(|| c / (discriminant.sqrt() - b))
}

impl Grid {
    fn new(corners: &[[DVec3; 3]], to_light: DVec3) -> Self {
        let axes: [DVec3; 2] = to_light.any_orthonormal_pair().into();
        let flat = |place: DVec3| DVec2::new(place.dot(axes[0]), place.dot(axes[1]));
        let places = corners.iter().flatten().map(|place| flat(*place));
        let (low, high) = places.fold(
            (DVec2::INFINITY, DVec2::NEG_INFINITY),
            |(low, high), place| (low.min(place), high.max(place)),
        );
        let mut grid = Self {
            axes,
            low,
            extent: (high - low).max(DVec2::splat(1e-3)),
            count: MAX_CELLS,
            cells: Vec::new(),
        };
        let spans = |grid: &Self, corners: &[DVec3; 3]| {
            let flat = corners.map(flat);
            let low = grid.cell(flat[0].min(flat[1]).min(flat[2]) - CONTACT_M);
            let high = grid.cell(flat[0].max(flat[1]).max(flat[2]) + CONTACT_M);
            [low, high]
        };
        let entries = |grid: &Self| {
            let of = |corners: &[DVec3; 3]| {
                let [low, high] = spans(grid, corners);
                (high[0] - low[0] + 1) * (high[1] - low[1] + 1)
            };
            corners.iter().map(of).sum::<usize>()
        };
        while grid.count > 1 && entries(&grid) > CELLS_PER_TRIANGLE * corners.len() {
            grid.count /= 2;
        }
        grid.cells = vec![Vec::new(); grid.count * grid.count];
        for (triangle, corners) in corners.iter().enumerate() {
            let [low, high] = spans(&grid, corners);
            for row in low[1]..=high[1] {
                for column in low[0]..=high[0] {
                    let cell = &mut grid.cells[row * grid.count + column];
                    cell.extend(u32::try_from(triangle));
                }
            }
        }
        grid
    }

    fn cell(&self, flat: DVec2) -> [usize; 2] {
        let at = (flat - self.low) / self.extent * self.count as f64;
        let last = self.count as f64 - 1.0;
        [at.x, at.y].map(|at| whole(at.clamp(0.0, last)) as usize)
    }

    /// The triangle nearest to the sun over a place, and how far above the place it is.
    fn first(&self, corners: &[[DVec3; 3]], place: DVec3, to_light: DVec3) -> Option<(u32, f64)> {
        let flat = |place: DVec3| DVec2::new(place.dot(self.axes[0]), place.dot(self.axes[1]));
        let [column, row] = self.cell(flat(place));
        let mut best: Option<(u32, f64)> = None;
        for &triangle in &self.cells[row * self.count + column] {
            // Relative to the place: as many digits as there can be.
            let local = corners[triangle as usize].map(|corner| corner - place);
            let [a, b, c] = local.map(flat);
            let [u, v, w] = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
            let area = u + v + w;
            let is_inside = [u, v, w].iter().all(|share| share * area >= 0.0);
            if !is_inside || area == 0.0 {
                continue;
            }
            let heights = local.map(|corner| corner.dot(to_light));
            let above = (u * heights[0] + v * heights[1] + w * heights[2]) / area;
            if best.is_none_or(|(_, best)| above > best) {
                best = Some((triangle, above));
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{bridge, sun};
    use terrafill_casters::{PortSize, port, row};

    #[test]
    fn a_plate_shades_the_sea_as_far_as_its_height_says() {
        let mesh = row(1);
        let to_light = sun([30.0, 180.0]);
        let reference = Reference::new(&mesh, to_light);
        // The plate ends at 0.1 m and is 25 m high: 43.3 m of shadow towards +x.
        let ends = 0.1 + 25.0 / 30_f64.to_radians().tan();
        for (x, is_shadow) in [
            (1.0, true),
            (ends - 0.01, true),
            (ends + 0.01, false),
            (-1.0, false),
        ] {
            let place = DVec3::new(x, 3.0, 0.0);
            assert_eq!(reference.is_shadowed(place, None), is_shadow, "{x}");
            assert_eq!(reference.is_covered(place, None), is_shadow, "{x}");
        }
    }

    #[test]
    fn the_sea_is_met_at_its_horizon_and_not_above() {
        let eye = DVec3::Z * 30.0;
        let down = |drop: f64| sea_distance(eye, DVec3::new(1.0, 0.0, -drop));
        let dip = (2.0 * 30.0 / SEA_RADIUS_M).sqrt();
        assert!(down(0.99 * dip).is_none() && down(0.0).is_none());
        let horizon = down(1.0001 * dip).expect("met");
        // √(2 · 10⁻⁴) before the horizon itself.
        let share = horizon / (2.0 * 30.0 * SEA_RADIUS_M).sqrt();
        assert!((0.98..0.99).contains(&share), "{share}");
        let below = down(1.0).expect("met");
        assert!((below - 30.0).abs() < 1e-4, "{below}");
    }

    #[test]
    fn both_tests_agree_and_the_tree_finds_what_every_triangle_says() {
        let mesh = port(PortSize::NAMED[1].1);
        for elevation in [30.0, 5.0] {
            let reference = Reference::new(&mesh, sun([elevation, -60.0]));
            let view = bridge([48, 36])[4];
            let truth = reference.picture(&view);
            let [lit, dark, apart] =
                [Light::Lit, Light::Shadow, Light::Undecided].map(|of| truth.count(of));
            assert!(lit > 300 && dark > 20, "{lit} lit, {dark} in shadow");
            assert_eq!(apart, 0);
            for at in (0..truth.seen.len()).step_by(7) {
                let own = reference.plane(truth.seen[at]);
                let Some(depth) = truth.seen[at].depth() else {
                    continue;
                };
                let [column, row] = view.pixel(at);
                let place = view.eye + view.ray(column, row) * depth;
                assert_eq!(
                    reference.is_shadowed(place, own),
                    reference.is_shadowed_by_any(place, own)
                );
            }
        }
    }

    #[test]
    fn twin_a_sun_that_one_test_has_moved_is_seen_as_undecided() {
        let mesh = row(3);
        let mut reference = Reference::new(&mesh, sun([30.0, 180.0]));
        let view = DeckCamera::level(DVec3::new(90.0, -180.0, 30.0), 105.0, 0.5, [24, 18]);
        assert_eq!(reference.picture(&view).count(Light::Undecided), 0);
        reference.to_light = sun([10.0, 150.0]);
        assert!(reference.picture(&view).count(Light::Undecided) > 5);
    }
}
