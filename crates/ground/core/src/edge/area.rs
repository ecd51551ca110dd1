// SPDX-License-Identifier: MIT OR Apache-2.0
//! The area under a boundary edge, between it and a parallel, and the sums of such areas.
//!
//! Degrees within ±180 and ±90 in, square metres out. Symmetric in the endpoints but for the sign.

use super::{Degrees, great_circle_latitude};
use crate::{EdgeRule, Ellipsoid};

/// Halvings of an arc after which its area is taken as it is. An arc that passes a pole by 4e-8°
/// turns from one meridian to the other within about as much longitude: some 30 halvings.
const MAX_AREA_HALVINGS: u32 = 36;

/// `Z(φ) − Z(φ₀)`, where Z is [`Ellipsoid::zone_area_per_radian`], without cancellation: both terms
/// as differences, by `x/(1−e²x²) − y/(1−e²y²)` over a common denominator and
/// `artanh u − artanh v = artanh((u − v)/(1 − uv))`.
///
/// Latitudes come in degrees and are subtracted before they are converted: two that differ by their
/// last bits differ by other bits in radians.
pub(crate) struct ZoneArea {
    half_b2: f64,
    e2: f64,
    reference_deg: f64,
    sin_reference: f64,
    cos_reference: f64,
    /// Bound on `dZ/dφ / cos φ = M N`, square metres per steradian: as at a pole.
    largest_slope: f64,
}

impl ZoneArea {
    pub(crate) fn new(body: &Ellipsoid, reference_deg: f64) -> Self {
        let b = body.polar_radius_m();
        Self {
            half_b2: 0.5 * b * b,
            e2: body.eccentricity_squared(),
            reference_deg,
            sin_reference: reference_deg.to_radians().sin(),
            // 0 at a pole, of which radians are a rounding off.
            cos_reference: (90.0 - reference_deg.abs()).to_radians().sin(),
            largest_slope: (body.equatorial_radius_m().powi(2) / b).powi(2),
        }
    }

    /// At a latitude, square metres per radian of longitude.
    pub(crate) fn at(&self, latitude_deg: f64) -> f64 {
        self.above_reference(self.height_rad(latitude_deg))
    }

    /// How far a latitude is north of φ₀.
    fn height_rad(&self, latitude_deg: f64) -> f64 {
        (latitude_deg - self.reference_deg).to_radians()
    }

    /// As [`ZoneArea::at`], by the height above φ₀.
    fn above_reference(&self, height_rad: f64) -> f64 {
        self.by_sine(self.sine_above_reference(height_rad))
    }

    /// As [`ZoneArea::at`], by sin φ − sin φ₀.
    fn by_sine(&self, difference: f64) -> f64 {
        let (e2, t) = (self.e2, self.sin_reference);
        let s = t + difference;
        let rational = difference * (1.0 + e2 * s * t) / ((1.0 - e2 * s * s) * (1.0 - e2 * t * t));
        let argument = difference / (1.0 - e2 * s * t);
        let e = e2.sqrt();
        let artanh = if e < 1e-9 {
            argument
        } else {
            artanh(e * argument) / e
        };
        self.half_b2 * (rational + artanh)
    }

    /// sin φ − sin φ₀ without cancellation, with φ₀'s sine and cosine at hand.
    fn sine_above_reference(&self, height_rad: f64) -> f64 {
        let (sin_half, cos_half) = (0.5 * height_rad).sin_cos();
        2.0 * (self.cos_reference * cos_half - self.sin_reference * sin_half) * sin_half
    }

    /// `d²Z/dφ² = b² sin φ (4 e² cos² φ / (1 − e² sin² φ) − 1) / (1 − e² sin² φ)²`, by sin φ − sin φ₀.
    fn bend(&self, difference: f64) -> f64 {
        let s = self.sin_reference + difference;
        let w = 1.0 - self.e2 * s * s;
        2.0 * self.half_b2 * s * (4.0 * self.e2 * (1.0 - s * s) / w - 1.0) / (w * w)
    }

    /// `∫ (Z − Z₀) dλ` along an edge from `start` to `end`, square metres.
    pub(crate) fn under_edge(&self, rule: EdgeRule, start: Degrees, end: Degrees) -> f64 {
        if start[0] == end[0] {
            return 0.0;
        }
        let at_pole = start[1].abs() == 90.0 || end[1].abs() == 90.0;
        if rule == EdgeRule::Planar || at_pole {
            self.under_line(start, end)
        } else {
            let whole = self.under_arc_gauss(start, end);
            self.under_arc(start, end, whole, MAX_AREA_HALVINGS)
        }
    }

    fn under_line(&self, start: Degrees, end: Degrees) -> f64 {
        let width = (end[0] - start[0]).to_radians();
        let (from, to) = (self.height_rad(start[1]), self.height_rad(end[1]));
        if start[1] == end[1] {
            return width * self.above_reference(from);
        }
        let span = (to - from).abs();
        if span < SHORT_RAD {
            let middle = self.sine_above_reference(from + 0.5 * (to - from));
            return width * (self.by_sine(middle) + span * span / 24.0 * self.bend(middle));
        }
        // Error of n-point Gauss–Legendre falls with span²ⁿ; these keep it under 1e-14 relative.
        let rule: &[(f64, f64)] = if span < 0.15 { &GAUSS_5 } else { &GAUSS_10 };
        let pieces = (span / 0.7).ceil().max(1.0);
        let mut sum = 0.0;
        let mut piece = 0.0;
        while piece < pieces {
            let center = from + (to - from) * (piece + 0.5) / pieces;
            let half = 0.5 * (to - from) / pieces;
            sum += gauss(rule, |x| self.above_reference(center + half * x));
            piece += 1.0;
        }
        width * 0.5 * sum / pieces
    }

    /// Halves the arc until both halves together agree with the whole.
    fn under_arc(&self, start: Degrees, end: Degrees, whole: f64, halvings_left: u32) -> f64 {
        let middle_deg = 0.5 * (start[0] + end[0]);
        let middle = [middle_deg, great_circle_latitude(start, end, middle_deg)];
        let first = self.under_arc_gauss(start, middle);
        let second = self.under_arc_gauss(middle, end);
        let span_rad = (end[0] - start[0]).abs().to_radians();
        let rise = (end[1] - start[1]).abs();
        // The latitudes carry rounding of 1e-16 rad, which is little of Z near a pole, but for what
        // the sum with φ₀ carries of it. The longitudes carry theirs, by which a steep arc rises:
        // halving one that spans a few of their last bits would never end.
        let from_reference = [start, end].map(|[_, y]| self.height_rad(y).abs());
        let slope = self.largest_slope
            * (largest_cosine(start[1], end[1]) + from_reference[0].max(from_reference[1]));
        let last_bits_rad = 4e-16 * start[0].abs().max(end[0].abs()).to_radians();
        let rounding = slope * (1e-15 * span_rad + last_bits_rad * rise.to_radians());
        let allowed = 1e-13 * (first.abs() + second.abs()) + rounding;
        // Beside a pole all nodes may lie behind the turn and agree on having missed it; then the
        // middle is hardly nearer to one end's latitude than the other end.
        let lifted = (middle[1] - 0.5 * (start[1] + end[1])).abs();
        let turns = rise > 1e-4 && lifted > 0.3 * rise;
        let splittable = halvings_left > 0 && span_rad > 64.0 * last_bits_rad;
        if !splittable || !turns && (first + second - whole).abs() <= allowed {
            return first + second;
        }
        self.under_arc(start, middle, first, halvings_left - 1)
            + self.under_arc(middle, end, second, halvings_left - 1)
    }

    fn under_arc_gauss(&self, start: Degrees, end: Degrees) -> f64 {
        let (center, half) = (0.5 * (start[0] + end[0]), 0.5 * (end[0] - start[0]));
        if half == 0.0 {
            return 0.0;
        }
        let sum = gauss(&GAUSS_5, |x| {
            self.at(great_circle_latitude(start, end, center + half * x))
        });
        half.to_radians() * sum
    }
}

/// Of the latitudes of an arc, which lies nowhere nearer to the equator than its ends unless it
/// crosses it.
fn largest_cosine(start_deg: f64, end_deg: f64) -> f64 {
    if start_deg * end_deg <= 0.0 {
        return 1.0;
    }
    start_deg.abs().min(end_deg.abs()).to_radians().cos()
}

/// Heights of an edge below which a parabola is Z: what comes next is of the fourth power, 1e-18.
const SHORT_RAD: f64 = 2e-4;

/// The area hyperbolic tangent, odd; of small arguments by its series, which is four times as fast as
/// by a logarithm.
fn artanh(x: f64) -> f64 {
    /// The first term left out is 0.1²⁰/21 of the sum.
    const LARGEST: f64 = 0.1;
    if x.abs() > LARGEST {
        return x.atanh();
    }
    let squared = x * x;
    let odd = [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0];
    let sum = odd.iter().fold(0.0, |sum, n| squared * (sum + 1.0 / n));
    x + x * sum
}

/// Nodes and weights on [−1, 1] (Abramowitz & Stegun, table 25.4); nodes not listed are mirrored.
const GAUSS_5: [(f64, f64); 3] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];
const GAUSS_10: [(f64, f64); 5] = [
    (0.148_874_338_981_631_22, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_36),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_05),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// `∫ f dx` over [−1, 1].
fn gauss(rule: &[(f64, f64)], f: impl Fn(f64) -> f64) -> f64 {
    rule.iter()
        .map(|&(node, weight)| {
            if node == 0.0 {
                weight * f(0.0)
            } else {
                weight * (f(-node) + f(node))
            }
        })
        .sum()
}

/// A sum that keeps what each addition rounds away (Neumaier 1974). Its error does not grow with the number of
/// terms, of which a region may have millions. What lies under the two sides of a sliver is a million times the
/// sliver.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum {
    rounded: f64,
    lost: f64,
}

impl std::ops::AddAssign<f64> for Sum {
    fn add_assign(&mut self, term: f64) {
        let next = self.rounded + term;
        self.lost += if self.rounded.abs() >= term.abs() {
            (self.rounded - next) + term
        } else {
            (term - next) + self.rounded
        };
        self.rounded = next;
    }
}

impl Sum {
    pub(crate) fn value(self) -> f64 {
        self.rounded + self.lost
    }
}

pub(crate) fn compensated_sum(terms: impl Iterator<Item = f64>) -> f64 {
    let mut sum = Sum::default();
    terms.for_each(|term| sum += term);
    sum.value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_compensated_sum_keeps_what_a_plain_one_loses() {
        let terms = [1e16, 3.0, -1e16, 1.0, 1e-3];
        assert!((compensated_sum(terms.into_iter()) - 4.001).abs() < 1e-15);
        // Negative control: the plain sum does lose it.
        assert!((terms.iter().sum::<f64>() - 4.001).abs() > 0.5);
    }

    #[test]
    fn quadrature_rules_integrate_the_polynomials_they_promise() {
        for (rule, points) in [(&GAUSS_5[..], 5), (&GAUSS_10[..], 10)] {
            for degree in (0..2 * points).step_by(2) {
                let found = gauss(rule, |x| x.powi(degree));
                let exact = 2.0 / f64::from(degree + 1);
                assert!((found - exact).abs() < 4e-16, "{points} points, x^{degree}");
            }
            // Negative control: one degree more must be missed.
            let degree = 2 * points;
            let found = gauss(rule, |x| x.powi(degree));
            assert!((found - 2.0 / f64::from(degree + 1)).abs() > 1e-7);
        }
    }

    #[test]
    fn zone_area_is_the_difference_of_the_closed_forms() {
        for body in Ellipsoid::ALL {
            for reference_deg in [-90.0_f64, -30.0, 0.0, 45.0] {
                let zone = ZoneArea::new(&body, reference_deg);
                for latitude_deg in [-90.0_f64, -10.0, 0.0, 45.0, 46.0, 90.0] {
                    let exact = body.zone_area_per_radian(latitude_deg.to_radians())
                        - body.zone_area_per_radian(reference_deg.to_radians());
                    let found = zone.at(latitude_deg);
                    let scale = body.equatorial_radius_m().powi(2);
                    assert!((found - exact).abs() < 1e-15 * scale * 4.0);
                }
            }
        }
    }

    #[test]
    fn area_under_a_great_circle_matches_girard() {
        // Octant of the unit sphere: a quarter of the equator, two meridians; edges at 0, 0–90.
        let zone = ZoneArea::new(&Ellipsoid::UNIT_SPHERE, 0.0);
        // Triangle (0,0) (90,0) (45, atan √2 …): excess by the angles of the right triangles.
        let apex = [45.0, 60.0];
        let found = zone.under_edge(EdgeRule::GreatEllipse, [0.0, 0.0], apex)
            + zone.under_edge(EdgeRule::GreatEllipse, apex, [90.0, 0.0]);
        // tan(E/2) = tan(a/2) tan(b/2) for each right spherical triangle with legs a, b.
        let half_excess =
            ((45_f64.to_radians() / 2.0).tan() * (60_f64.to_radians() / 2.0).tan()).atan();
        assert!((found - 4.0 * half_excess).abs() < 1e-14);
        let planar = zone.under_edge(EdgeRule::Planar, [0.0, 0.0], apex);
        assert!(
            (planar - 2.0 * half_excess).abs() > 1e-2,
            "the rule must matter"
        );
    }
}
