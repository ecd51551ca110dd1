// SPDX-License-Identifier: MIT OR Apache-2.0
//! Voids are filled from their neighbours by push and pull (Gortler et al., "The Lumigraph", 1996,
//! §3.2): means of the samples that there are, on ever coarser rasters, then back down into the gaps.
//!
//! Smooth across a void of any size, the same on every machine, and O(samples).

use terrafill_core::nearest_f32;

struct Level {
    columns: usize,
    rows: usize,
    /// NaN is a void.
    samples: Vec<f32>,
}

impl Level {
    /// Half as many columns and rows: means of the two by two samples that are no voids.
    fn pulled(&self) -> Self {
        let (columns, rows) = (self.columns.div_ceil(2), self.rows.div_ceil(2));
        let mut samples = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let (mut sum, mut count) = (0.0_f64, 0.0);
                for y in 2 * row..(2 * row + 2).min(self.rows) {
                    for x in 2 * column..(2 * column + 2).min(self.columns) {
                        let sample = f64::from(self.samples[y * self.columns + x]);
                        if !sample.is_nan() {
                            sum += sample;
                            count += 1.0;
                        }
                    }
                }
                samples.push(nearest_f32(sum / count));
            }
        }
        Self {
            columns,
            rows,
            samples,
        }
    }

    /// Fills this level's voids bilinearly from the next coarser one, which has none.
    fn push(&mut self, coarser: &Self) {
        for row in 0..self.rows {
            for column in 0..self.columns {
                let sample = &mut self.samples[row * self.columns + column];
                if sample.is_nan() {
                    // A quarter of a coarse sample to either side of its centre.
                    let near = [column / 2, row / 2];
                    let far = [beside(column, coarser.columns), beside(row, coarser.rows)];
                    let at =
                        |x: usize, y: usize| f64::from(coarser.samples[y * coarser.columns + x]);
                    *sample = nearest_f32(
                        (9.0 * at(near[0], near[1])
                            + 3.0 * (at(far[0], near[1]) + at(near[0], far[1]))
                            + at(far[0], far[1]))
                            / 16.0,
                    );
                }
            }
        }
    }
}

/// The coarse sample on the other side of a fine one, or its own at the rim.
fn beside(index: usize, count: usize) -> usize {
    let own = index / 2;
    match index % 2 {
        0 => own.saturating_sub(1),
        _ => (own + 1).min(count - 1),
    }
}

/// Fills every NaN; gives how many there were, or `None` where there is nothing else.
pub(crate) fn fill(samples: &mut Vec<f32>, columns: usize, rows: usize) -> Option<u64> {
    let voids = samples.iter().filter(|sample| sample.is_nan()).count();
    if voids == samples.len() {
        return None;
    }
    if voids > 0 {
        let mut levels = vec![Level {
            columns,
            rows,
            samples: std::mem::take(samples),
        }];
        while let Some(finest) = levels
            .last()
            .filter(|l| l.samples.iter().any(|s| s.is_nan()))
        {
            levels.push(finest.pulled());
        }
        while let Some(coarser) = levels.pop() {
            match levels.last_mut() {
                Some(finer) => finer.push(&coarser),
                None => *samples = coarser.samples,
            }
        }
    }
    Some(voids as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voids_are_filled_between_their_neighbours_and_the_rest_stays() {
        let (columns, rows) = (13, 9);
        let mut samples: Vec<f32> = (0_u16..117).map(|i| f32::from(i % 13) * 10.0).collect();
        let before = samples.clone();
        for i in [0, 30, 31, 32, 43, 44, 45, 116] {
            samples[i] = f32::NAN;
        }
        let kept = samples.clone();
        assert_eq!(fill(&mut samples, columns, rows), Some(8));
        for (i, sample) in samples.iter().enumerate() {
            assert!((0.0..=120.0).contains(sample), "{i}: {sample}");
            if kept[i].is_nan() {
                assert!((sample - before[i]).abs() <= 20.0, "{i}: {sample}");
            } else {
                assert_eq!(sample.to_bits(), before[i].to_bits());
            }
        }
        let mut nothing = vec![f32::NAN; 12];
        assert_eq!(fill(&mut nothing, 4, 3), None);
        let mut lonely = vec![f32::NAN; 35];
        lonely[17] = 7.0;
        assert_eq!(fill(&mut lonely, 7, 5), Some(34));
        assert!(lonely.iter().all(|&sample| (sample - 7.0).abs() < 1e-6));
    }
}
