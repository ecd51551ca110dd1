// SPDX-License-Identifier: MIT OR Apache-2.0
//! Least squares and near-minimax fits in `f64`.
//!
//! The design matrix is factored by Householder reflections, not by normal equations: columns of
//! a degree-5 fit are close to dependent, and normal equations would square that. Lawson's
//! reweighting (1961) then moves the least-squares fit towards the smallest maximum: each round
//! multiplies a sample's weight by its error, so that the largest errors come to weigh most.

/// Columns of coefficients that make `rows · x` closest to `target` in the weighted 2-norm.
///
/// - `rows`: one per sample, all of the same length, at least as many as that length
/// - `weights`: one per sample, not negative
/// - returns: one coefficient per column; 0 for a column that depends on earlier ones
/// - cost: O(samples · columns²)
pub(crate) fn least_squares(rows: &[Vec<f64>], target: &[f64], weights: &[f64]) -> Vec<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    let mut matrix: Vec<Vec<f64>> = rows
        .iter()
        .zip(target)
        .zip(weights)
        .map(|((row, value), weight)| {
            let scale = weight.sqrt();
            row.iter().chain([value]).map(|x| x * scale).collect()
        })
        .collect();
    for k in 0..columns.min(matrix.len()) {
        reflect_column(&mut matrix, k);
    }
    let mut solution = vec![0.0; columns];
    let largest = (0..columns.min(matrix.len()))
        .map(|k| matrix[k][k].abs())
        .fold(0.0, f64::max);
    for k in (0..columns.min(matrix.len())).rev() {
        let known: f64 = (k + 1..columns).map(|j| matrix[k][j] * solution[j]).sum();
        let pivot = matrix[k][k];
        // Below this a column is a combination of earlier ones as far as f64 can tell.
        if pivot.abs() > 1e-14 * largest {
            solution[k] = (matrix[k][columns] - known) / pivot;
        }
    }
    solution
}

/// Clears column `k` below the diagonal by one Householder reflection of all later columns.
fn reflect_column(matrix: &mut [Vec<f64>], k: usize) {
    let norm = matrix[k..]
        .iter()
        .map(|row| row[k] * row[k])
        .sum::<f64>()
        .sqrt();
    if norm == 0.0 {
        return;
    }
    let pivot = if matrix[k][k] > 0.0 { -norm } else { norm };
    let mut mirror: Vec<f64> = matrix[k..].iter().map(|row| row[k]).collect();
    mirror[0] -= pivot;
    let length_squared: f64 = mirror.iter().map(|x| x * x).sum();
    let width = matrix[k].len();
    for j in k..width {
        let along: f64 = mirror
            .iter()
            .zip(&matrix[k..])
            .map(|(m, row)| m * row[j])
            .sum();
        let factor = 2.0 * along / length_squared;
        for (m, row) in mirror.iter().zip(&mut matrix[k..]) {
            row[j] -= factor * m;
        }
    }
}

/// Coefficients of a fit with nearly the smallest maximal error over the samples.
///
/// - `rounds`: of reweighting; the round with the smallest maximum is kept, so more never hurt
pub(crate) fn near_minimax(rows: &[Vec<f64>], target: &[f64], rounds: usize) -> Vec<f64> {
    let mut weights = vec![1.0; rows.len()];
    let mut best = (f64::INFINITY, Vec::new());
    for _ in 0..=rounds {
        let solution = least_squares(rows, target, &weights);
        let errors: Vec<f64> = rows
            .iter()
            .zip(target)
            .map(|(row, value)| {
                let sum: f64 = row.iter().zip(&solution).map(|(a, x)| a * x).sum();
                (sum - value).abs()
            })
            .collect();
        let largest = errors.iter().copied().fold(0.0, f64::max);
        if largest < best.0 {
            best = (largest, solution);
        }
        if largest == 0.0 {
            break;
        }
        let mut total = 0.0;
        for (weight, error) in weights.iter_mut().zip(&errors) {
            *weight *= error / largest;
            total += *weight;
        }
        for weight in &mut weights {
            *weight /= total;
        }
    }
    best.1
}

/// `count` Chebyshev nodes of `[low, high]`, ascending, with both ends scaled in (Chebyshev–
/// Gauss nodes stretched to reach them): a region's error is largest at its edges.
pub(crate) fn chebyshev_nodes(low: f64, high: f64, count: usize) -> Vec<f64> {
    let middle = 0.5 * (low + high);
    let half = 0.5 * (high - low);
    if count < 2 {
        return vec![middle];
    }
    let angle = |i: usize| std::f64::consts::PI * (i as f64 + 0.5) / count as f64;
    let reach = angle(0).cos();
    (0..count)
        .map(|i| middle - half * angle(i).cos() / reach)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn powers(nodes: &[f64], columns: i32) -> Vec<Vec<f64>> {
        nodes
            .iter()
            .map(|x| (0..columns).map(|k| x.powi(k)).collect())
            .collect()
    }

    #[test]
    fn a_polynomial_is_found_again() {
        let nodes = chebyshev_nodes(-1.0, 1.0, 30);
        let target: Vec<f64> = nodes
            .iter()
            .map(|x| 3.0 - 2.0 * x + 0.5 * x.powi(5))
            .collect();
        let rows = powers(&nodes, 6);
        let found = least_squares(&rows, &target, &vec![1.0; rows.len()]);
        for (got, want) in found.iter().zip([3.0, -2.0, 0.0, 0.0, 0.0, 0.5]) {
            assert!((got - want).abs() < 1e-13, "{found:?}");
        }
    }

    #[test]
    fn dependent_columns_do_not_blow_up() {
        let nodes = chebyshev_nodes(0.0, 1.0, 10);
        let rows: Vec<Vec<f64>> = nodes.iter().map(|x| vec![1.0, *x, 2.0 * x]).collect();
        let found = least_squares(&rows, &nodes, &[1.0; 10]);
        assert!(found.iter().all(|x| x.abs() < 2.0), "{found:?}");
    }

    #[test]
    fn reweighting_comes_close_to_the_known_minimax_error() {
        // The best linear fit of x² on [−1, 1] is ½, with error ½; least squares has ⅔.
        let nodes = chebyshev_nodes(-1.0, 1.0, 41);
        let target: Vec<f64> = nodes.iter().map(|x| x * x).collect();
        let rows = powers(&nodes, 2);
        let largest = |c: &[f64]| {
            nodes
                .iter()
                .map(|x| (c[0] + c[1] * x - x * x).abs())
                .fold(0.0, f64::max)
        };
        let minimax = largest(&near_minimax(&rows, &target, 30));
        let squares = largest(&near_minimax(&rows, &target, 0));
        assert!((0.5..0.51).contains(&minimax), "{minimax}");
        assert!(squares > minimax, "{squares}");
    }

    #[test]
    fn nodes_reach_both_ends() {
        let nodes = chebyshev_nodes(2.0, 5.0, 7);
        assert!((nodes[0] - 2.0).abs() < 1e-15 && (nodes[6] - 5.0).abs() < 1e-15);
        assert!(nodes.windows(2).all(|w| w[0] < w[1]));
        assert!((chebyshev_nodes(2.0, 4.0, 1)[0] - 3.0).abs() < 1e-15);
    }
}
