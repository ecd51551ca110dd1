// SPDX-License-Identifier: MIT OR Apache-2.0
//! What frames of a flight add up to.

use crate::flight::FrameRecord;
use crate::metrics::*;
use crate::path::{FRAMES, REST};
use crate::texture::PAGE;
use terrafill_results::{median, quantile};
use terrafill_study::Figures;

/// Values frame by frame, as a note keeps them.
pub(crate) fn trace(records: &[FrameRecord], of: impl Fn(&FrameRecord) -> f64) -> String {
    let values: Vec<String> = records
        .iter()
        .map(|record| of(record).to_string())
        .collect();
    values.join(" ")
}

/// Frames in which the eye moves, or has just jumped.
fn moving(records: &[FrameRecord]) -> &[FrameRecord] {
    &records[..(FRAMES - REST).min(records.len())]
}

/// Exact figures.
pub(crate) fn of_records(records: &[FrameRecord]) -> Figures {
    let sum = |of: fn(&FrameRecord) -> f64| records.iter().map(of).sum::<f64>();
    let most = |of: fn(&FrameRecord) -> f64| records.iter().map(of).fold(0.0, f64::max);
    // Flights with few pages a frame are longer: what a frame lacks is of the frames that all have.
    let common = &records[..FRAMES.min(records.len())];
    let missing = |of: &FrameRecord| of.pixels.map_or(f64::NAN, |[_, missing]| missing as f64);
    let moving = moving(records);
    let wanted = moving.iter().map(|of| of.wanted as f64).sum::<f64>();
    let mut figures = vec![
        (
            PAGING_MISSING_FRAMES.name,
            common.iter().filter(|of| missing(of) > 0.0).count() as f64,
        ),
        (
            PAGING_MISSING_PX.name,
            common.iter().map(missing).sum::<f64>() / common.len().max(1) as f64,
        ),
        (PAGING_MISSING_MAX_PX.name, most(missing)),
        (PAGING_FRAMES.name, records.len() as f64),
        (PAGING_WANTED.name, wanted / moving.len().max(1) as f64),
        (PAGING_READS.name, sum(|of| of.reads as f64)),
        (PAGING_READS_MAX.name, most(|of| of.reads as f64)),
        (PAGING_WITHOUT_SLOT.name, sum(|of| of.without_slot as f64)),
        (PAGING_BYTES.name, sum(|of| of.bytes as f64)),
        (PAGING_BYTES_MAX.name, most(|of| of.bytes as f64)),
    ];
    if let [.., before, last] = records
        && before.reads + last.reads == 0
    {
        let texels = last.wanted as f64 * f64::from(PAGE * PAGE);
        figures.push((PAGING_STEADY_BYTES.name, (before.bytes + last.bytes) as f64));
        let pixels = last.pixels.filter(|[pixels, _]| *pixels > 0);
        figures
            .extend(pixels.map(|[pixels, _]| (PAGING_TEXELS_PER_PX.name, texels / pixels as f64)));
    }
    figures
}

/// Times of a flight, by the process' clock and by the wall's.
pub(crate) fn times(records: &[FrameRecord]) -> Figures {
    let clocks = [
        [
            PAGING_FRAME_CPU_MS,
            PAGING_FRAME_P95_CPU_MS,
            PAGING_FRAME_MAX_CPU_MS,
            PAGING_DRAW_CPU_MS,
        ],
        [
            PAGING_FRAME_WALL_MS,
            PAGING_FRAME_P95_WALL_MS,
            PAGING_FRAME_MAX_WALL_MS,
            PAGING_DRAW_WALL_MS,
        ],
    ];
    let mean = |of: &[f64]| Some(of.iter().sum::<f64>() / of.len().max(1) as f64);
    // Reading may block, which no process clock sees.
    let update = |of: &FrameRecord| of.update_ms[1];
    let longest = records.iter().map(update).max_by(f64::total_cmp);
    let updates: Vec<f64> = moving(records).iter().map(update).collect();
    let mut found = vec![
        (PAGING_UPDATE_MS, mean(&updates)),
        (PAGING_UPDATE_MAX_MS, longest),
    ];
    for (clock, metrics) in clocks.into_iter().enumerate() {
        let draws: Vec<f64> = records.iter().map(|of| of.draw_ms[clock]).collect();
        let frames = records
            .iter()
            .map(|of| of.update_ms[clock] + of.draw_ms[clock]);
        let frames: Vec<f64> = frames.collect();
        let values = [
            median(&frames),
            quantile(&frames, 0.95),
            quantile(&frames, 1.0),
            mean(&draws),
        ];
        found.extend(metrics.into_iter().zip(values));
    }
    let found = found.into_iter();
    found
        .filter_map(|(metric, value)| Some((metric.name, value?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(figures: &Figures, metric: &terrafill_results::Metric) -> f64 {
        let mut figures = figures.iter();
        let found = figures.find(|(name, _)| *name == metric.name);
        found.map_or(f64::NAN, |(_, value)| *value)
    }

    #[test]
    fn spikes_and_missing_frames_are_told_from_the_others() {
        let calm = FrameRecord {
            wanted: 3,
            reads: 0,
            without_slot: 0,
            bytes: 0,
            pixels: Some([100, 0]),
            update_ms: [1.0, 2.0],
            draw_ms: [4.0, 5.0],
        };
        let mut records = vec![calm; FRAMES];
        records[7] = FrameRecord {
            reads: 12,
            bytes: 900,
            pixels: Some([100, 40]),
            update_ms: [9.0, 11.0],
            ..calm
        };
        let found = of_records(&records);
        let of = |metric| figure(&found, metric);
        assert_eq!(of(PAGING_MISSING_FRAMES), 1.0);
        assert_eq!(
            [PAGING_MISSING_PX, PAGING_MISSING_MAX_PX].map(of),
            [40.0 / 48.0, 40.0]
        );
        assert_eq!([PAGING_READS_MAX, PAGING_BYTES_MAX].map(of), [12.0, 900.0]);
        assert_eq!(of(PAGING_STEADY_BYTES), 0.0);
        let times = times(&records);
        let of = |metric| figure(&times, metric);
        assert_eq!(
            [PAGING_FRAME_CPU_MS, PAGING_FRAME_MAX_CPU_MS].map(of),
            [5.0, 13.0]
        );
        let means = [PAGING_UPDATE_MS, PAGING_UPDATE_MAX_MS].map(of);
        assert_eq!(means, [(37.0 * 2.0 + 11.0) / 38.0, 11.0]);
        assert_eq!(trace(&records[6..8], |of| of.bytes as f64), "0 900");
        // Negative controls: what is sent at the end is no rest, and what is read is none to speak of.
        records[FRAMES - 1].bytes = 4;
        assert_eq!(figure(&of_records(&records), PAGING_STEADY_BYTES), 4.0);
        records[FRAMES - 1].reads = 1;
        assert!(figure(&of_records(&records), PAGING_STEADY_BYTES).is_nan());
    }
}
