// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lights at a place, and rays to them in `f64`: the reference of their shadows.
//!
//! Test A walks from the visible point to the light through the tree of boxes, no farther than the light. Test B looks
//! from the light at triangles sorted into the cells of a cube around it: the point is lit if it is of the first plane
//! there. What lies beyond the range or outside the cone is unlit by itself, and no shadow.

use crate::reference::{CONTACT_M, EDGE_ON, Light, Reference, Seen, Truth};
use crate::scissor::{NONE, around, cut, joined};
use crate::view::{DeckCamera, whole};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};
use terrafill_casters::Mesh;
use terrafill_plan::PixelRect;

/// Cells of test B's cube along each axis of a face.
const CELLS: usize = 64;
/// Corners of the pyramid round a cone.
const PYRAMID: u32 = 16;
/// A beam is cut to less than a half-space, and its pyramid has an end.
const MAX_HALF_DEG: f64 = 80.0;

/// The cone of a searchlight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Unit vector away from the light.
    pub axis: DVec3,
    /// Between axis and rim, degrees, at most 80.
    pub half_deg: f64,
}

/// A light at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    /// m.
    pub place: DVec3,
    /// Beyond it nothing is lit, m.
    pub range_m: f64,
    /// `None` for a light that shines to all sides.
    pub beam: Option<Beam>,
}

impl Lamp {
    /// Whether its light comes as far as a place, were there nothing between.
    #[must_use]
    pub fn reaches(&self, place: DVec3) -> bool {
        let along = place - self.place;
        let is_in_beam = self.beam.is_none_or(|beam| {
            along.dot(beam.axis) >= along.length() * beam.half_deg.to_radians().cos()
        });
        is_in_beam && along.length() <= self.range_m
    }

    /// Pixels in which something that it reaches may be seen.
    ///
    /// - `share`: of its range and its beam; below 1 for a bound that is too small
    #[must_use]
    pub fn rectangle(&self, view: &DeckCamera, share: f64) -> PixelRect {
        let range = self.range_m * share;
        let sphere = around_sphere(view, self.place, range);
        let Some(beam) = self.beam else {
            return sphere;
        };
        let half = (share * beam.half_deg.min(MAX_HALF_DEG)).to_radians();
        let (right, up) = beam.axis.any_orthonormal_pair();
        // A pyramid whose sides touch the cone holds it; its base lies at the range along the axis.
        let radius = range * half.tan() / (TAU / 2.0 / f64::from(PYRAMID)).cos();
        let corner = |at: u32| {
            let (sin, cos) = (TAU * f64::from(at) / f64::from(PYRAMID)).sin_cos();
            self.place + beam.axis * range + (right * cos + up * sin) * radius - view.eye
        };
        let [tip, base] = [DVec3::ZERO, beam.axis * range].map(|way| self.place + way - view.eye);
        let faces = (0..PYRAMID).flat_map(|at| {
            let edge = [corner(at), corner(at + 1)];
            [tip, base].map(|top| [top, edge[0], edge[1]])
        });
        let pyramid = faces.map(|face| around(view, &face)).fold(NONE, joined);
        pyramid.within(sphere)
    }

    /// Depths between which something that it reaches may be seen, m.
    #[must_use]
    pub fn depths(&self, view: &DeckCamera) -> [f64; 2] {
        let middle = view.forward.dot(self.place - view.eye);
        [middle - self.range_m, middle + self.range_m]
    }
}

/// Pixels in which a sphere may be seen: between the planes through the eye that touch it, along either axis.
fn around_sphere(view: &DeckCamera, centre: DVec3, radius: f64) -> PixelRect {
    let along = centre - view.eye;
    let depth = along.dot(view.forward);
    let ends = [view.right, view.up].map(|axis| {
        let flat = DVec2::new(depth, along.dot(axis));
        if flat.length() <= radius {
            return Some([-FRAC_PI_2, FRAC_PI_2]);
        }
        let half = (radius / flat.length()).asin();
        let [low, high] = [-half, half].map(|turn| flat.to_angle() + turn);
        (low < FRAC_PI_2 && high > -FRAC_PI_2).then(|| [low.max(-FRAC_PI_2), high.min(FRAC_PI_2)])
    });
    let [Some(across), Some(upwards)] = ends else {
        return NONE;
    };
    let pixels = |[low, high]: [f64; 2], tan: f64, size: u32| {
        let at = |angle: f64| (angle.tan() / tan + 1.0) / 2.0 * f64::from(size);
        let end = |place: f64| whole(place.clamp(0.0, f64::from(size)));
        [end(at(low).floor() - 1.0), end(at(high).ceil() + 1.0)]
    };
    let [left, right] = pixels(across, view.tan[0], view.size[0]);
    let [top, bottom] = pixels([-upwards[1], -upwards[0]], view.tan[1], view.size[1]);
    PixelRect {
        left,
        top,
        right,
        bottom,
    }
}

/// A mesh under a lamp, ready for rays.
pub struct LampReference<'a> {
    tree: Reference<'a>,
    lamp: Lamp,
    cube: Cube,
}

impl<'a> LampReference<'a> {
    /// Sorts a mesh for rays.
    #[must_use]
    pub fn new(mesh: &'a Mesh, lamp: Lamp) -> Self {
        Self {
            // Its own light is not asked.
            tree: Reference::new(mesh, DVec3::Z),
            lamp,
            cube: Cube::new(mesh, lamp.place),
        }
    }

    /// Test A: whether something lies between a place and the lamp, of other planes than `own`.
    #[must_use]
    pub fn is_shadowed(&self, place: DVec3, own: Option<u32>) -> bool {
        let way = self.lamp.place - place;
        let (length, mut is_shadowed) = (way.length(), false);
        self.tree.walk(place, way / length, |triangle, distance| {
            let plane = self.tree.mesh.planes[triangle as usize];
            let is_between = (CONTACT_M..length).contains(&distance);
            is_shadowed |= is_between && own != Some(plane);
            if is_shadowed {
                f64::NEG_INFINITY
            } else {
                length
            }
        });
        is_shadowed
    }

    /// Test B: whether the first plane from the lamp towards a place is another one.
    fn is_covered(&self, place: DVec3, own: Option<u32>) -> bool {
        let along = place - self.lamp.place;
        let first = self.cube.first(along);
        first.is_some_and(|(triangle, share)| {
            (1.0 - share) * along.length() > CONTACT_M
                && own != Some(self.tree.mesh.planes[triangle as usize])
        })
    }

    /// The first thing on a ray from the eye, 1 m deep a unit.
    #[must_use]
    pub fn seen(&self, view: &DeckCamera, ray: DVec3) -> Seen {
        self.tree.seen(view.eye, ray, view.near)
    }

    /// As of [`Reference::away`].
    #[must_use]
    pub fn away(&self, seen: Seen, place: DVec3) -> f64 {
        self.tree.away(seen, place)
    }

    /// Light of a visible point.
    #[must_use]
    pub fn light(&self, view: &DeckCamera, ray: DVec3, seen: Seen) -> Light {
        let Some(depth) = seen.depth() else {
            return Light::Sky;
        };
        let place = view.eye + ray * depth;
        if !self.lamp.reaches(place) {
            return Light::OutOfReach;
        }
        let own = self.tree.plane(seen);
        let to_light = (self.lamp.place - place).normalize_or_zero();
        let cosine = own.map(|plane| {
            let normal = self.tree.mesh.normals[plane as usize];
            normal.normalize_or_zero().dot(to_light)
        });
        if cosine.is_some_and(|cosine| cosine.abs() < EDGE_ON) {
            return Light::EdgeOn;
        }
        let is_turned_away = cosine.is_some_and(|cosine| cosine <= 0.0);
        let is_dark = is_turned_away || self.is_shadowed(place, own);
        match (is_dark, self.is_covered(place, own)) {
            (true, true) => Light::Shadow,
            (false, false) => Light::Lit,
            _ => Light::Undecided,
        }
    }

    /// What each pixel sees, and its light.
    #[must_use]
    pub fn picture(&self, view: &DeckCamera) -> Truth {
        Truth::of(view, |ray| {
            let seen = self.seen(view, ray);
            (seen, self.light(view, ray, seen))
        })
    }
}

/// Triangles by where they lie as seen from a place.
struct Cube {
    /// Corners from the light, m.
    corners: Vec<[DVec3; 3]>,
    /// Of six faces, [`CELLS`] rows of as many each.
    cells: Vec<Vec<u32>>,
}

/// Of a face: its own axis and the two across.
fn axes(face: usize) -> [DVec3; 3] {
    let sign = if face < 3 { 1.0 } else { -1.0 };
    let axis = |at: usize| DVec3::AXES[at % 3];
    [axis(face) * sign, axis(face + 1), axis(face + 2)]
}

/// The cell along an axis of a face, of −1…1.
fn cell(at: f64) -> usize {
    let count = CELLS as f64;
    whole(((at + 1.0) / 2.0 * count).clamp(0.0, count - 1.0)) as usize
}

impl Cube {
    fn new(mesh: &Mesh, light: DVec3) -> Self {
        let all = 0..mesh.triangles.len();
        let corners = all.map(|at| mesh.corners(at).map(|corner| corner - light));
        let mut cube = Self {
            corners: corners.collect(),
            cells: vec![Vec::new(); 6 * CELLS * CELLS],
        };
        for (triangle, corners) in (0_u32..).zip(&cube.corners) {
            for face in 0..6 {
                let [ahead, right, up] = axes(face);
                // Wider than the face: what lies along its border is in cells on either side.
                let sides = [right, -right, up, -up].map(|side| ahead * (1.0 + 1e-9) + side);
                let ring = sides.iter().fold(corners.to_vec(), |ring, side| {
                    cut(&ring, |place| side.dot(place))
                });
                let flat = ring.iter().filter(|place| place.dot(ahead) > 0.0);
                let flat = flat
                    .map(|place| DVec2::new(place.dot(right), place.dot(up)) / place.dot(ahead));
                let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
                let [low, high] = flat.fold(none, |[low, high], at| [low.min(at), high.max(at)]);
                if low.x > high.x {
                    continue;
                }
                let [low, high] = [low - 1e-9, high + 1e-9].map(|at| [cell(at.x), cell(at.y)]);
                for row in low[1]..=high[1] {
                    for column in low[0]..=high[0] {
                        cube.cells[(face * CELLS + row) * CELLS + column].push(triangle);
                    }
                }
            }
        }
        cube
    }

    /// The triangle nearest to the light on the way to a place, and where on that way it is: 1 at the place.
    fn first(&self, along: DVec3) -> Option<(u32, f64)> {
        let axis = along.abs().max_position();
        let face = if along[axis] > 0.0 { axis } else { axis + 3 };
        let [ahead, right, up] = axes(face);
        let [x, y] = [right, up].map(|side| along.dot(side) / along.dot(ahead));
        let mut best: Option<(u32, f64)> = None;
        for &triangle in &self.cells[(face * CELLS + cell(y)) * CELLS + cell(x)] {
            let [a, b, c] = self.corners[triangle as usize];
            // Shares of the corners on the way, of which the sum over the volume is where on it.
            let shares = [b.cross(c), c.cross(a), a.cross(b)].map(|edge| edge.dot(along));
            let sum: f64 = shares.iter().sum();
            let is_inside = shares.iter().all(|share| share * sum >= 0.0);
            if !is_inside || sum == 0.0 {
                continue;
            }
            let at = a.dot(b.cross(c)) / sum;
            if at > 0.0 && best.is_none_or(|(_, best)| at < best) {
                best = Some((triangle, at));
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::bridge;
    use terrafill_casters::{PortSize, port, row};

    fn lamp(place: [f64; 3], range_m: f64) -> Lamp {
        Lamp {
            place: place.into(),
            range_m,
            beam: None,
        }
    }

    #[test]
    fn a_plate_shades_the_sea_between_rays_from_the_lamp_and_no_farther_than_its_range() {
        let mesh = row(1);
        // The plate is 25 m high and ends at x = 0.1; the lamp hangs at twice its height, 20 m before it.
        let reference = LampReference::new(&mesh, lamp([-20.0, 3.0, 50.0], 60.0));
        let ends = 0.1 + 20.1;
        for (x, is_shadow) in [(1.0, true), (ends - 0.01, true), (ends + 0.01, false)] {
            let place = DVec3::new(x, 3.0, 0.0);
            assert_eq!(reference.is_shadowed(place, None), is_shadow, "{x}");
            assert_eq!(reference.is_covered(place, None), is_shadow, "{x}");
        }
        // Beyond the lamp the plate shades nothing.
        let behind = DVec3::new(-30.0, 3.0, 60.0);
        assert!(!reference.is_shadowed(behind, None) && !reference.is_covered(behind, None));
        let view = DeckCamera::level(DVec3::new(60.0, 3.0, 40.0), 180.0, 0.5, [9, 9]);
        let ray = DVec3::new(-1.0, 0.0, -1.0);
        // √(40² + 50²) = 64 m away, and its shadow does not matter.
        assert_eq!(
            reference.light(&view, ray, Seen::Sea(40.0)),
            Light::OutOfReach
        );
    }

    #[test]
    fn both_tests_agree_and_a_lamp_that_one_of_them_has_moved_is_seen() {
        let mesh = port(PortSize::NAMED[1].1);
        let view = bridge([48, 36])[4];
        let mut reference = LampReference::new(&mesh, lamp([-118.0, -9.0, 33.0], 150.0));
        let truth = reference.picture(&view);
        let [lit, dark, apart] =
            [Light::Lit, Light::Shadow, Light::Undecided].map(|of| truth.count(of));
        assert!(lit > 100 && dark > 20, "{lit} lit, {dark} in shadow");
        assert_eq!(apart, 0);
        reference.lamp.place.x += 15.0;
        assert!(reference.picture(&view).count(Light::Undecided) > 5);
    }

    #[test]
    fn a_rectangle_holds_all_that_the_lamp_reaches_and_half_of_it_does_not() {
        let mesh = port(PortSize::NAMED[2].1);
        let axis = DVec3::new(0.6, 0.76, -0.1).normalize();
        let beam = Some(Beam {
            axis,
            half_deg: 9.0,
        });
        let search = Lamp {
            beam,
            ..lamp([-112.0, -158.0, 27.0], 300.0)
        };
        for lamp in [lamp([10.0, -9.0, 33.0], 60.0), search] {
            let reference = LampReference::new(&mesh, lamp);
            let views = bridge([48, 36]);
            let outside = |share: f64| {
                let of = |view: &DeckCamera| {
                    let (truth, own) = (reference.picture(view), lamp.rectangle(view, share));
                    let is_outside = |at: &usize| {
                        let [column, row] = view.pixel(*at);
                        let is_reached = matches!(truth.light[*at], Light::Lit | Light::Shadow);
                        is_reached
                            && !((own.left..own.right).contains(&column)
                                && (own.top..own.bottom).contains(&row))
                    };
                    (0..view.pixel_count()).filter(is_outside).count()
                };
                views.iter().map(of).sum::<usize>()
            };
            assert_eq!(outside(1.0), 0);
            assert!(outside(0.5) > 10, "{}", outside(0.5));
            let own = views.iter().map(|view| lamp.rectangle(view, 1.0).area());
            let all = views.iter().map(|view| view.whole().area());
            let [own, all] = [own.sum::<u64>(), all.sum()];
            assert!(3 * own < all, "{own} of {all}");
        }
    }
}
