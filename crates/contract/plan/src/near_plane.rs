// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where the near plane, as far as the image shows it, lies seen from a region's volume.
//!
//! Counting the faces in front of the surface starts at the near plane. It tells inside from outside where all rays
//! start on the same side, so where no face meets the near rectangle. From within, an even
//! number of faces in front means inside. What lies between eye and near plane is clipped, and matters to no count.
//!
//! Boxes come first: most regions are told apart by the axes of theirs. Where the box meets the near
//! rectangle, the volume itself is tested: the rectangle, grown on all sides by what the GPU's
//! rounding may move a face, is a box, too, in view space. A face meets it when something of the face
//! is left after clipping by the box's six planes (Sutherland and Hodgman, 1974). When no face
//! does, the rectangle lies wholly inside or wholly outside, and one of its points decides for all.
//! Of a mesh in parts only those are tested whose boxes may be met. Near the ground a frame would
//! otherwise spend milliseconds on the vertices of a continent.

use crate::parts::{MeshParts, edges_in};
use glam::{DMat3, DVec3};
use std::f64::consts::TAU;
use std::ops::Range;
use terrafill_core::{Ellipsoid, OrientedBox, RegionMesh, VolumeHeights, index_u32};
use terrafill_scene::{Camera, ImageSize};

/// Where the near plane lies, as far as the image shows it, seen from a closed volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum NearRectangle {
    /// Certainly outside: each ray of the image enters the volume as often as it leaves it.
    #[default]
    Outside,
    /// Certainly inside: each ray leaves it once more often.
    Within,
    /// A face of the volume may meet it: counting what lies in front of the surface would then miss faces.
    Cut,
}

impl NearRectangle {
    /// Where nothing but a volume's bounds is known.
    ///
    /// - `meets`: the near rectangle meets them
    #[must_use]
    pub fn by_bounds(meets: bool) -> Self {
        if meets { Self::Cut } else { Self::Outside }
    }
}

/// The rectangle of the near plane that the image shows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearPlane {
    corners_ecef: [DVec3; 4],
    /// What clipping in `f32` may move, metres.
    margin_m: f64,
}

/// What rounding moves a clip position against the near plane, as a share of the eye's distance to
/// what is clipped; 2⁻²⁴ each for the position, its rotation and the comparison, and a margin.
const CLIP_ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// What storing moves a position, as a share of the region's extent: 2⁻²⁴ in `f32`, far less in fixed
/// point, and a margin.
const STORED_ROUNDING: f64 = 1.0 / (1 << 22) as f64;

impl NearPlane {
    pub(crate) fn new(camera: &Camera, size: ImageSize) -> Self {
        let [half_x, half_y] = half_size_m(camera, size);
        let ecef_from_view = camera.view_from_ecef.transpose();
        let corner = |x: f64, y: f64| {
            let view = DVec3::new(x * half_x, y * half_y, -camera.near_m);
            camera.eye_ecef + ecef_from_view * view
        };
        Self {
            corners_ecef: [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ],
            margin_m: camera.near_m * CLIP_ROUNDING,
        }
    }

    /// Whether rectangle and box may share a point: true unless one of the box's own axes parts them.
    pub(crate) fn meets_box(&self, bounds: &OrientedBox) -> bool {
        (0..3).all(|axis| {
            let along = |corner: &DVec3| (*corner - bounds.center_ecef).dot(bounds.axes.col(axis));
            let extents = self.corners_ecef.iter().map(along);
            let (low, high) = extents
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                    (low.min(at), high.max(at))
                });
            let half = bounds.half_extents_m[axis] + self.margin_m + rounding_m(bounds);
            low <= half && -half <= high
        })
    }
}

/// What storing and projecting may move a volume that the near plane reaches, metres.
fn rounding_m(bounds: &OrientedBox) -> f64 {
    2.0 * bounds.half_extents_m.length() * (CLIP_ROUNDING + STORED_ROUNDING)
}

/// Half width and half height of the near rectangle, metres.
fn half_size_m(camera: &Camera, size: ImageSize) -> [f64; 2] {
    let half_y = camera.near_m * camera.tan_half_fov();
    [half_y * size.aspect(), half_y]
}

/// A region's volume in view space: x right, y up, z towards the viewer, metres from the eye.
pub(crate) struct ViewVolume<'a> {
    mesh: &'a RegionMesh,
    /// In which its triangles are in its parts, where it has several.
    order: Option<&'a [u32]>,
    placing: Placing,
    /// Top and bottom of every vertex; of a mesh in parts none: most of its parts are far away.
    corners: Vec<[DVec3; 2]>,
    /// All faces.
    pieces: Vec<Piece>,
    /// No corner is farther from the eye.
    reach_m: f64,
    /// What storing may move a vertex.
    stored_m: f64,
}

/// How a vertex on the ellipsoid becomes a corner of the volume.
struct Placing {
    view_from_ecef: DMat3,
    eye_ecef: DVec3,
    /// On the ellipsoid (x/a², y/a², z/b²) is parallel to the geodetic normal.
    normal_scale: DVec3,
    heights: VolumeHeights,
}

impl Placing {
    fn to_view(&self, ecef: DVec3) -> DVec3 {
        self.view_from_ecef * (ecef - self.eye_ecef)
    }

    fn corners(&self, vertex: DVec3) -> [DVec3; 2] {
        let normal = (vertex * self.normal_scale).normalize();
        [self.heights.top_m, self.heights.bottom_m]
            .map(|height_m| self.to_view(vertex + normal * height_m))
    }
}

/// Some of the faces of a volume, and a box that holds them.
struct Piece {
    /// Both caps' facets over these triangles, in the order of the parts.
    caps: Range<u32>,
    /// The walls on these boundary edges, loop after loop.
    walls: Range<u32>,
    around: ViewBox,
}

/// A box along the axes of view space.
#[derive(Clone, Copy)]
struct ViewBox {
    low: DVec3,
    high: DVec3,
}

impl ViewBox {
    fn around(corners: impl IntoIterator<Item = DVec3>) -> Self {
        let nowhere = Self {
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        corners.into_iter().fold(nowhere, |sum, corner| Self {
            low: sum.low.min(corner),
            high: sum.high.max(corner),
        })
    }

    /// Whether one side parts it from the box of these half sizes around `middle`.
    fn is_beside(&self, middle: DVec3, half: DVec3) -> bool {
        (self.low - middle).cmpgt(half).any() || (self.high - middle).cmplt(-half).any()
    }

    /// Whether a ray from `point` towards the viewer may meet something in it.
    fn may_meet_ray(&self, point: DVec3) -> bool {
        let (low, high) = (self.low - point, self.high - point);
        low.x <= 0.0 && low.y <= 0.0 && high.cmpge(DVec3::ZERO).all()
    }
}

impl<'a> ViewVolume<'a> {
    /// - `parts`: of `mesh`, where it has several
    pub(crate) fn new(
        body: &Ellipsoid,
        camera: &Camera,
        mesh: &'a RegionMesh,
        heights: VolumeHeights,
        parts: Option<&'a MeshParts>,
    ) -> Self {
        let radii = body.radii_m();
        let placing = Placing {
            view_from_ecef: camera.view_from_ecef,
            eye_ecef: camera.eye_ecef,
            normal_scale: (radii * radii).recip(),
            heights,
        };
        let mut corners = Vec::new();
        let pieces: Vec<Piece> = if let Some(parts) = parts {
            let on_view = |at: DVec3| placing.to_view(at);
            let piece = |(caps, walls, around): (_, _, OrientedBox)| Piece {
                caps,
                walls,
                around: ViewBox::around(around.corners_ecef().map(on_view)),
            };
            parts.boxes(heights).map(piece).collect()
        } else {
            let places = mesh.vertices_ecef.iter();
            corners.extend(places.map(|vertex| placing.corners(*vertex)));
            vec![Piece {
                caps: 0..index_u32(mesh.triangles.len()),
                walls: 0..index_u32(mesh.boundary_edge_count()),
                around: ViewBox::around(corners.iter().copied().flatten()),
            }]
        };
        let around = ViewBox::around(
            pieces
                .iter()
                .flat_map(|piece| [piece.around.low, piece.around.high]),
        );
        let extent_m =
            (around.high - around.low).length() + heights.top_m.abs().max(heights.bottom_m.abs());
        Self {
            mesh,
            order: parts.map(MeshParts::triangles),
            placing,
            corners,
            pieces,
            reach_m: around.low.abs().max(around.high.abs()).length(),
            stored_m: extent_m * STORED_ROUNDING,
        }
    }

    fn corners_at(&self, vertex: u32) -> [DVec3; 2] {
        let vertex = vertex as usize;
        let known = self.corners.get(vertex).copied();
        known.unwrap_or_else(|| self.placing.corners(self.mesh.vertices_ecef[vertex]))
    }

    /// Triangles of both caps and of the walls of a piece, wound counter-clockwise seen from outside.
    fn faces<'s>(&'s self, piece: &'s Piece) -> impl Iterator<Item = [DVec3; 3]> + 's {
        let caps = piece.caps.clone().flat_map(|place| {
            let place = place as usize;
            let triangle = self.order.map_or(place, |order| order[place] as usize);
            let [a, b, c] = self.mesh.triangles[triangle].map(|vertex| self.corners_at(vertex));
            [[a[0], b[0], c[0]], [a[1], c[1], b[1]]]
        });
        let walls = edges_in(self.mesh, piece.walls.clone()).flat_map(|ends| {
            let [start, end] = ends.map(|vertex| self.corners_at(vertex));
            [[start[0], start[1], end[0]], [end[0], start[1], end[1]]]
        });
        caps.chain(walls)
    }

    /// Where the near rectangle lies, seen from this volume.
    pub(crate) fn near_rectangle(&self, camera: &Camera, size: ImageSize) -> NearRectangle {
        let middle = DVec3::new(0.0, 0.0, -camera.near_m);
        let [half_x, half_y] = half_size_m(camera, size);
        let grown_by = |reach_m: f64| {
            let margin_m = (reach_m + camera.near_m) * CLIP_ROUNDING + self.stored_m;
            DVec3::new(half_x, half_y, 0.0) + DVec3::splat(margin_m)
        };
        let farthest = grown_by(self.reach_m);
        let meets = |face: [DVec3; 3]| {
            let around = face.map(|corner| corner - middle);
            if is_beside(&around, farthest) {
                return false;
            }
            let reach_m = face.map(DVec3::length).into_iter().fold(0.0, f64::max);
            meets_box(around, grown_by(reach_m))
        };
        let mut near = self.pieces.iter();
        let is_cut = near
            .any(|piece| !piece.around.is_beside(middle, farthest) && self.faces(piece).any(meets));
        match is_cut {
            true => NearRectangle::Cut,
            false if self.holds(middle) => NearRectangle::Within,
            false => NearRectangle::Outside,
        }
    }

    /// Whether a point is inside; one on a face may be called either.
    fn holds(&self, point: DVec3) -> bool {
        self.crossings(point)
            .map_or_else(|| self.surrounds(point), |crossings| crossings % 2 == 1)
    }

    /// How many faces a ray from `point` along z crosses. Along the ray, every edge is a pair of
    /// points of the plane. Both faces at an edge see the same sign of the same number there, so
    /// that no ray slips through between them or meets both. `None` when a face is met edge-on.
    fn crossings(&self, point: DVec3) -> Option<usize> {
        let mut crossings = 0;
        let pieces = self.pieces.iter();
        let met = pieces.filter(|piece| piece.around.may_meet_ray(point));
        for face in met.flat_map(|piece| self.faces(piece)) {
            let [a, b, c] = face.map(|corner| corner - point);
            let side = is_left(a, b);
            if side != is_left(b, c) || side != is_left(c, a) {
                continue;
            }
            let normal = (b - a).cross(c - a);
            if normal.z.abs() <= normal.length() * 1e-9 {
                return None;
            }
            crossings += usize::from(normal.dot(a) / normal.z > 0.0);
        }
        Some(crossings)
    }

    /// The same by the solid angle of all faces, 4π or 0 (Van Oosterom and Strackee, 1983): slower,
    /// and never at a loss.
    fn surrounds(&self, point: DVec3) -> bool {
        let faces = self.pieces.iter().flat_map(|piece| self.faces(piece));
        let angles = faces.map(|face| {
            let [a, b, c] = face.map(|corner| corner - point);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let spread = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * a.dot(b.cross(c)).atan2(spread)
        });
        angles.sum::<f64>().abs() > TAU
    }
}

/// Whether the origin lies to the left of the line from `a` to `b`, seen along z. The reverse of
/// `is_left(b, a)` whatever rounding does.
fn is_left(a: DVec3, b: DVec3) -> bool {
    let cross = |p: DVec3, q: DVec3| p.x * q.y - p.y * q.x >= 0.0;
    if (a.x, a.y) < (b.x, b.y) {
        cross(a, b)
    } else {
        !cross(b, a)
    }
}

/// Whether one side of the box of these half sizes around the origin parts it from a triangle.
fn is_beside([a, b, c]: &[DVec3; 3], half: DVec3) -> bool {
    let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
    low.cmpgt(half).any() || high.cmplt(-half).any()
}

/// Whether a triangle and the box of these half sizes around the origin share a point.
fn meets_box(face: [DVec3; 3], half: DVec3) -> bool {
    if is_beside(&face, half) {
        return false;
    }
    let mut polygon = face.to_vec();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            polygon = clipped(&polygon, |corner| half[axis] - sign * corner[axis]);
        }
    }
    !polygon.is_empty()
}

/// The part of a convex polygon where `distance` is not negative.
fn clipped(polygon: &[DVec3], distance: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    let nexts = polygon.iter().cycle().skip(1);
    for (&corner, &next) in polygon.iter().zip(nexts) {
        let (here, there) = (distance(corner), distance(next));
        if here >= 0.0 {
            kept.push(corner);
        }
        if (here < 0.0) != (there < 0.0) {
            kept.push(corner + (next - corner) * (here / (here - there)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parts::tests::strip;
    use terrafill_core::{EdgeRule, Geodetic, MeshOptions, RegionMesh, parse_regions};
    use terrafill_scene::CameraPose;

    const SIZE: ImageSize = ImageSize::new(200, 100);
    const HEIGHTS: VolumeHeights = VolumeHeights {
        top_m: 1000.0,
        bottom_m: -1000.0,
    };

    /// An L about 200 km long: the box holds a quarter that the region does not.
    fn l_shape() -> RegionMesh {
        let text = r#"{"type":"Polygon","coordinates":
            [[[0,0],[2,0],[2,1],[1,1],[1,2],[0,2],[0,0]]]}"#;
        let regions = parse_regions(text.as_bytes(), "test").expect("valid");
        let body = Ellipsoid::WGS84;
        let mut meshes =
            RegionMesh::build_all(&regions, &body, EdgeRule::Planar, &MeshOptions::default())
                .expect("meshes");
        meshes.remove(0)
    }

    fn camera(longitude: f64, latitude: f64, height_m: f64, near_m: f64) -> Camera {
        let pose = CameraPose {
            eye: Geodetic::from_degrees(longitude, latitude, height_m),
            heading_rad: 0.3,
            pitch_rad: -0.2,
            fov_y_rad: 1.0,
            near_m,
        };
        Camera::new(&Ellipsoid::WGS84, &pose)
    }

    /// Numbers from 0 to 1.
    fn random(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    fn seen(mesh: &RegionMesh, camera: &Camera) -> NearRectangle {
        ViewVolume::new(&Ellipsoid::WGS84, camera, mesh, HEIGHTS, None).near_rectangle(camera, SIZE)
    }

    #[test]
    fn a_concave_corner_is_outside_although_its_box_is_not() {
        let mesh = l_shape();
        let bounds = mesh.oriented_box(&Ellipsoid::WGS84, HEIGHTS);
        let [outside, within] = [NearRectangle::Outside, NearRectangle::Within];
        for (longitude, latitude, height_m, expected) in [
            (0.5, 0.5, 0.0, within),
            (1.5, 0.5, 500.0, within),
            (0.5, 1.5, -900.0, within),
            (1.5, 1.5, 0.0, outside),
            (1.5, 0.5, 1200.0, outside),
            // Facets of 2 degrees hang up to 1 km through between their corners.
            (0.5, 0.5, -2500.0, outside),
            (-0.5, 0.5, 0.0, outside),
        ] {
            let camera = camera(longitude, latitude, height_m, 1.0);
            assert_eq!(
                seen(&mesh, &camera),
                expected,
                "{longitude} {latitude} {height_m}"
            );
            // Negative control: the box alone takes the missing quarter for a part of the volume.
            if (longitude, latitude) == (1.5, 1.5) {
                assert!(NearPlane::new(&camera, SIZE).meets_box(&bounds));
            }
        }
    }

    #[test]
    fn a_near_plane_that_a_wall_or_a_cap_cuts_is_cut_wherever_its_middle_is() {
        let mesh = l_shape();
        let [outside, within, cut] = [
            NearRectangle::Outside,
            NearRectangle::Within,
            NearRectangle::Cut,
        ];
        // 40 m beyond the western wall (3.6e-4 degrees), the near rectangle almost 200 m wide.
        let beyond = camera(-0.000_36, 0.5, 0.0, 90.0);
        let volume = ViewVolume::new(&Ellipsoid::WGS84, &beyond, &mesh, HEIGHTS, None);
        assert!(!volume.holds(DVec3::new(0.0, 0.0, -beyond.near_m)));
        assert_eq!(seen(&mesh, &beyond), cut);
        assert_eq!(seen(&mesh, &camera(-0.000_36, 0.5, 0.0, 1.0)), outside);
        // As far on this side of it.
        assert_eq!(seen(&mesh, &camera(0.000_36, 0.5, 0.0, 90.0)), cut);
        assert_eq!(seen(&mesh, &camera(0.000_36, 0.5, 0.0, 1.0)), within);
        // 5 m above the top, at a corner of it.
        assert_eq!(seen(&mesh, &camera(0.0, 0.0, 1005.0, 90.0)), cut);
        assert_eq!(seen(&mesh, &camera(0.0, 0.0, 1005.0, 1.0)), outside);
    }

    #[test]
    fn a_mesh_in_parts_is_met_where_the_whole_is() {
        let (mesh, body) = (strip(1_000), Ellipsoid::WGS84);
        let parts = MeshParts::of(&body, &mesh).expect("several");
        let mut random = random(11);
        let (mut met, mut lacking) = ([0; 3], 0);
        for _ in 0..1_000 {
            let camera = camera(
                random() * 54.0 - 2.0,
                random() * 0.15 - 0.05,
                random() * 4_000.0 - 2_000.0,
                10_f64.powf(4.0 * random()),
            );
            let whole = seen(&mesh, &camera);
            let volume = |parts| ViewVolume::new(&body, &camera, &mesh, HEIGHTS, parts);
            let mut in_parts = volume(Some(&parts));
            assert_eq!(in_parts.near_rectangle(&camera, SIZE), whole);
            met[whole as usize] += 1;
            let middle = DVec3::new(0.0, 0.0, -camera.near_m);
            assert_eq!(in_parts.surrounds(middle), volume(None).surrounds(middle));
            // Negative control: without its caps.
            in_parts.pieces.retain(|piece| piece.caps.is_empty());
            lacking += usize::from(in_parts.near_rectangle(&camera, SIZE) != whole);
        }
        assert!(
            met.into_iter().all(|views| views > 50) && lacking > 100,
            "{met:?} {lacking}"
        );
    }

    #[test]
    fn both_inside_tests_agree_on_random_points() {
        let mesh = l_shape();
        let camera = camera(1.0, 1.0, 0.0, 1.0);
        let volume = ViewVolume::new(&Ellipsoid::WGS84, &camera, &mesh, HEIGHTS, None);
        let mut random = random(7);
        let (mut inside, mut missing_face) = (0, 0);
        for _ in 0..2_000 {
            let geodetic = Geodetic::from_degrees(
                random() * 2.4 - 0.2,
                random() * 2.4 - 0.2,
                random() * 3000.0 - 1500.0,
            );
            let ecef = Ellipsoid::WGS84.geodetic_to_ecef(geodetic);
            let point = camera.view_from_ecef * (ecef - camera.eye_ecef);
            let crossings = volume.crossings(point).expect("no face is met edge-on");
            assert_eq!(crossings % 2 == 1, volume.surrounds(point), "{geodetic:?}");
            inside += usize::from(crossings % 2 == 1);
            // Negative control: with a face missing, rays slip out.
            let open = RegionMesh {
                triangles: mesh.triangles[1..].to_vec(),
                ..mesh.clone()
            };
            let open = ViewVolume::new(&Ellipsoid::WGS84, &camera, &open, HEIGHTS, None);
            missing_face += usize::from(open.crossings(point) != Some(crossings));
        }
        assert!(inside > 400 && missing_face > 10, "{inside} {missing_face}");
    }

    #[test]
    fn a_triangle_and_a_box_meet_when_they_share_a_point() {
        let half = DVec3::new(2.0, 1.0, 0.1);
        let face = |corners: [[f64; 3]; 3]| corners.map(DVec3::from);
        for (corners, expected) in [
            // Through the middle, far larger than the box.
            ([[-9., -9., 0.], [9., -9., 0.], [0., 9., 0.]], true),
            // Upright through the middle: no corner near the box.
            ([[0., -9., -9.], [0., 9., -9.], [0., 0., 9.]], true),
            // Beside a corner of the box, each axis alone not telling them apart.
            ([[4., 0., 0.], [0., 4., 0.], [4., 4., 0.]], false),
            ([[3., 0., 0.], [0., 3., 0.], [3., 3., 0.]], true),
            // Above.
            ([[-9., -9., 0.2], [9., -9., 0.2], [0., 9., 0.2]], false),
        ] {
            assert_eq!(meets_box(face(corners), half), expected, "{corners:?}");
        }
    }
}
