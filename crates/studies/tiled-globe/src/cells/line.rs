// SPDX-License-Identifier: MIT OR Apache-2.0
//! A straight line through points by least squares, with Student's interval of its slope.

/// Share of repetitions whose interval holds the slope.
const CONFIDENCE: f64 = 0.95;

/// A straight line through points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Upwards for each step across.
    pub slope: f64,
    /// Where it crosses x = 0.
    pub start: f64,
    /// Of both, −1 … 1; 0 where all are equal upwards.
    pub correlation: f64,
    /// Two-sided probability of a correlation as large where there is none.
    pub p: f64,
    /// Of the slope, 95 %, by what the line leaves over.
    pub interval: [f64; 2],
}

impl Line {
    /// Upwards at a place across.
    pub fn at(&self, x: f64) -> f64 {
        self.start + self.slope * x
    }
}

/// Least squares; `None` below three points, which leave nothing over, or where all stand at one place.
pub fn line(points: &[[f64; 2]]) -> Option<Line> {
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let middle = [mean(0), mean(1)];
    let sum = |a: usize, b: usize| -> f64 {
        let terms = points.iter();
        terms
            .map(|point| (point[a] - middle[a]) * (point[b] - middle[b]))
            .sum()
    };
    if points.len() < 3 || sum(0, 0) <= 0.0 {
        return None;
    }
    let (slope, freedom) = (sum(0, 1) / sum(0, 0), count - 2.0);
    // Where all are equal upwards nothing goes with anything.
    let correlation = match (sum(0, 0) * sum(1, 1)).sqrt() {
        0.0 => 0.0,
        spread => (sum(0, 1) / spread).clamp(-1.0, 1.0),
    };
    let t = correlation * (freedom / (1.0 - correlation * correlation)).sqrt();
    let left = (sum(1, 1) - slope * sum(0, 1)).max(0.0);
    let reach = quantile(freedom) * (left / freedom / sum(0, 0)).sqrt();
    Some(Line {
        slope,
        start: middle[1] - slope * middle[0],
        correlation,
        p: beyond(t.abs(), freedom),
        interval: [slope - reach, slope + reach],
    })
}

/// Probability that Student's t of `freedom` degrees is farther from 0 than `t`, both sides. With
/// `t = √ν tan θ` the density becomes `cos^(ν−1) θ`, which Simpson's rule takes on a finite range.
pub(crate) fn beyond(t: f64, freedom: f64) -> f64 {
    const STEPS: u32 = 2000;
    let integral = |from: f64, to: f64| {
        let step = (to - from) / f64::from(STEPS);
        let sum: f64 = (0..=STEPS)
            .map(|place| {
                let weight = match place {
                    0 | STEPS => 1.0,
                    odd if odd % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                weight * (from + f64::from(place) * step).cos().powf(freedom - 1.0)
            })
            .sum();
        sum * step / 3.0
    };
    let end = std::f64::consts::FRAC_PI_2;
    let from = (t / freedom.sqrt()).atan();
    integral(from, end) / integral(0.0, end)
}

/// How far Student's t strays in [`CONFIDENCE`] of all cases, by halving.
fn quantile(freedom: f64) -> f64 {
    // 12.7 at one degree of freedom is the largest.
    let [mut low, mut high] = [0.0, 20.0];
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if beyond(middle, freedom) > 1.0 - CONFIDENCE {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn students_distribution_has_its_tabulated_quantiles() {
        for (t, freedom, p) in [(2.306, 8.0, 0.05), (3.355, 8.0, 0.01), (12.706, 1.0, 0.05)] {
            assert!((beyond(t, freedom) / p - 1.0).abs() < 1e-3, "{t}");
        }
        assert!((beyond(0.0, 8.0) - 1.0).abs() < 1e-9);
        for (freedom, t) in [(1.0, 12.706), (8.0, 2.306), (30.0, 2.042)] {
            assert!((quantile(freedom) - t).abs() < 1e-3, "{freedom}");
        }
    }

    #[test]
    fn a_slope_has_an_interval_and_two_points_have_none() {
        // Anscombe's first set: slope 0.5001 with a standard error of 0.1179, start 3.0001.
        let x = [10.0, 8.0, 13.0, 9.0, 11.0, 14.0, 6.0, 4.0, 12.0, 7.0, 5.0];
        let y = [
            8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68,
        ];
        let points: Vec<[f64; 2]> = x.into_iter().zip(y).map(|(x, y)| [x, y]).collect();
        let found = line(&points).expect("a line");
        assert!((found.slope - 0.5001).abs() < 1e-4 && (found.start - 3.0001).abs() < 1e-4);
        assert!((found.p - 0.00217).abs() < 1e-5, "{found:?}");
        let reach = 0.5 * (found.interval[1] - found.interval[0]);
        assert!((reach - 2.2622 * 0.1179).abs() < 1e-4, "{reach}");
        assert!((found.at(9.0) - 7.501).abs() < 1e-3);
        assert_eq!(line(&points[..2]), None);
        // Equal times rise with nothing, and those on a line leave nothing over.
        let level = line(&[[1.0, 2.0], [2.0, 2.0], [3.0, 2.0]]).expect("a line");
        assert_eq!(
            (level.slope, level.correlation, level.interval),
            (0.0, 0.0, [0.0; 2])
        );
        assert!((level.p - 1.0).abs() < 1e-9);
        let straight = line(&[[1.0, 2.0], [2.0, 3.0], [3.0, 4.0]]).expect("a line");
        assert!(straight.correlation == 1.0 && straight.p.abs() < 1e-9);
        // Negative control: turned round, the slope is another.
        let turned: Vec<[f64; 2]> = points.iter().map(|[x, y]| [*y, *x]).collect();
        let turned = line(&turned).expect("a line");
        assert!((turned.slope - found.slope).abs() > 0.5 && (turned.p - found.p).abs() < 1e-9);
    }
}
