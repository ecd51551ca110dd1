// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where data lies on the sphere, in `f64`: patches by longitude and latitude, great circles, and places about a corner.
//!
//! The body is a sphere, as the paper's. Here places are found from the centre and then subtracted; shaders find the
//! differences themselves.

use glam::{DVec2, DVec3};

/// Mean radius of the Earth (IUGG), metres.
pub(crate) const RADIUS_M: f64 = 6_371_008.8;

/// A place's direction from the centre, axes of the body.
///
/// - `at`: longitude and latitude, radians
pub(crate) fn direction(at: DVec2) -> DVec3 {
    let ((sin_lon, cos_lon), (sin_lat, cos_lat)) = (at.x.sin_cos(), at.y.sin_cos());
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// Longitude and latitude of a place, radians.
pub(crate) fn angles(place: DVec3) -> DVec2 {
    let level = place.truncate().length();
    DVec2::new(place.y.atan2(place.x), place.z.atan2(level))
}

/// East, north and up at a place.
pub(crate) fn axes(at: DVec2) -> [DVec3; 3] {
    let up = direction(at);
    let east = DVec3::new(-at.x.sin(), at.x.cos(), 0.0);
    [east, up.cross(east), up]
}

/// How a line runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Path {
    /// Straight in longitude and latitude, by this much of them.
    Straight(DVec2),
    /// The shortest way: from its start, of length 1 in its tangent plane, by an angle.
    GreatCircle {
        /// Along east and north.
        toward: DVec2,
        angle: f64,
    },
}

/// What is laid over the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// A patch of so much longitude and latitude, radians.
    Decal(DVec2),
    /// A line.
    Line(Path),
}

/// Data with a place on the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Data {
    /// Longitude and latitude of its lower left corner, or of its start, radians.
    pub(crate) corner: DVec2,
    pub(crate) shape: Shape,
}

impl Data {
    /// A square of so much latitude about a place, as wide in its middle as it is high.
    pub(crate) fn square(middle: DVec2, height: f64) -> Self {
        let size = DVec2::new(height / middle.y.cos(), height);
        Self {
            corner: middle - 0.5 * size,
            shape: Shape::Decal(size),
        }
    }

    /// A line that runs east through a place as its middle, by an angle of the sphere.
    pub(crate) fn line(middle: DVec2, angle: f64, is_great_circle: bool) -> Self {
        if !is_great_circle {
            let size = DVec2::new(angle / middle.y.cos(), 0.0);
            return Self {
                corner: middle - 0.5 * size,
                shape: Shape::Line(Path::Straight(size)),
            };
        }
        let [east, _, up] = axes(middle);
        let at = |turn: f64| up * turn.cos() + east * turn.sin();
        let corner = angles(at(-0.5 * angle));
        let tangent = up * (0.5 * angle).sin() + east * (0.5 * angle).cos();
        let [own_east, own_north, _] = axes(corner);
        let toward = DVec2::new(tangent.dot(own_east), tangent.dot(own_north));
        Self {
            corner,
            shape: Shape::Line(Path::GreatCircle { toward, angle }),
        }
    }

    /// Longitude and latitude at a share of both sides, or of the way; radians.
    pub(crate) fn angles(&self, share: DVec2) -> DVec2 {
        match self.shape {
            Shape::Decal(size) => self.corner + size * share,
            Shape::Line(Path::Straight(size)) => self.corner + size * share.x,
            Shape::Line(Path::GreatCircle { .. }) => angles(self.direction(share)),
        }
    }

    /// From the centre, of length 1.
    pub(crate) fn direction(&self, share: DVec2) -> DVec3 {
        match self.shape {
            Shape::Line(Path::GreatCircle { toward, angle }) => {
                let [east, north, up] = axes(self.corner);
                let (sin, cos) = (angle * share.x).sin_cos();
                up * cos + (east * toward.x + north * toward.y) * sin
            }
            _ => direction(self.angles(share)),
        }
    }

    /// Which shares of both sides a place has, within a decal or beyond it.
    ///
    /// - `at`: longitude and latitude
    pub(crate) fn share_of(&self, at: DVec2) -> Option<DVec2> {
        let Shape::Decal(size) = self.shape else {
            return None;
        };
        let mut from = at - self.corner;
        // To the nearer side of the decal's middle, where longitude jumps.
        let turn = std::f64::consts::TAU;
        from.x -= turn * ((from.x - 0.5 * size.x) / turn).round();
        Some(from / size)
    }

    /// Largest second derivative of places by shares of both sides or of the way, over an edge that spans all of it;
    /// radii. Linear interpolation is off by an eighth of it, over the square of the number of cells.
    pub(crate) fn bend(&self) -> f64 {
        match self.shape {
            Shape::Decal(size) => {
                let [low, high] = [self.corner.y, self.corner.y + size.y];
                let nearest = low.max(0.0f64.min(high));
                let steepest = low.abs().max(high.abs()).sin();
                nearest.cos() * size.x * size.x + 2.0 * steepest * size.x * size.y + size.y * size.y
            }
            Shape::Line(Path::Straight(size)) => self.corner.y.cos() * size.x * size.x,
            Shape::Line(Path::GreatCircle { angle, .. }) => angle * angle,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(longitude_deg: f64, latitude_deg: f64) -> DVec2 {
        DVec2::new(longitude_deg.to_radians(), latitude_deg.to_radians())
    }

    #[test]
    fn a_great_circle_is_shorter_than_its_parallel_and_meets_its_ends() {
        let [circle, parallel] = [true, false].map(|is| Data::line(at(15.0, 45.0), 1.0, is));
        let ends = [0.0, 1.0].map(|share| circle.direction(DVec2::new(share, 0.0)));
        assert!((ends[0].angle_between(ends[1]) - 1.0).abs() < 1e-12);
        let middle = angles(circle.direction(DVec2::new(0.5, 0.0)));
        assert!((middle - at(15.0, 45.0)).length() < 1e-12);
        let ends = [0.0, 1.0].map(|share| parallel.direction(DVec2::new(share, 0.0)));
        assert!(ends[0].angle_between(ends[1]) < 0.99);
        // Its length along the parallel is the same.
        let Shape::Line(Path::Straight(size)) = parallel.shape else {
            panic!("a straight line");
        };
        assert!((size.x * parallel.corner.y.cos() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn interpolation_is_never_farther_off_than_the_bend_says() {
        for height in [1e-3, 0.14, 0.7] {
            let data = Data::square(at(15.0, 45.0), height);
            for cells in [1_u32, 4] {
                let step = f64::from(cells).recip();
                let bound = data.bend() / (8.0 * f64::from(cells).powi(2));
                let mut worst = 0.0_f64;
                for cell in 0..cells * cells {
                    let low = DVec2::new(f64::from(cell % cells), f64::from(cell / cells)) * step;
                    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)];
                    let corners = corners.map(|(x, y)| low + DVec2::new(x, y) * step);
                    for weights in [
                        [0.5, 0.5, 0.0],
                        [0.5, 0.0, 0.5],
                        [0.0, 0.5, 0.5],
                        [1.0 / 3.0; 3],
                    ] {
                        let all = || corners.iter().zip(weights);
                        let flat: DVec3 = all().map(|(c, w)| data.direction(*c) * w).sum();
                        let share: DVec2 = all().map(|(c, w)| *c * w).sum();
                        worst = worst.max(flat.distance(data.direction(share)));
                    }
                }
                assert!(worst <= bound, "{height} {cells}: {worst} {bound}");
                // And not by much: a bound that is far too large divides far too finely.
                assert!(worst > 0.2 * bound, "{height} {cells}: {worst} {bound}");
            }
        }
    }

    #[test]
    fn shares_of_a_decal_go_there_and_back() {
        let data = Data::square(at(179.0, -20.0), 0.2);
        for share in [
            DVec2::new(0.0, 0.0),
            DVec2::new(0.9, 0.3),
            DVec2::new(1.2, -0.1),
        ] {
            let back = data
                .share_of(angles(data.direction(share)))
                .expect("a decal");
            assert!((back - share).length() < 1e-9, "{share} {back}");
        }
        assert!(
            Data::line(at(0.0, 0.0), 1.0, true)
                .share_of(DVec2::ZERO)
                .is_none()
        );
    }
}
