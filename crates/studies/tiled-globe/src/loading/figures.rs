// SPDX-License-Identifier: MIT OR Apache-2.0
//! What frames of a flight add up to.

use super::flight::{FlightRecord, FrameRecord, MOVING};
use crate::metrics::*;
use terrafill_results::median;
use terrafill_study::Figures;

/// Values frame by frame, as a note keeps them.
pub(crate) fn trace(record: &FlightRecord, of: impl Fn(&FrameRecord) -> f64) -> String {
    let values = record.frames.iter().map(|frame| of(frame).to_string());
    values.collect::<Vec<_>>().join(" ")
}

/// What is wrong with a flight's frames; empty where nothing is.
pub(crate) fn of_frames(record: &FlightRecord, budget: usize) -> String {
    for (number, frame) in record.frames.iter().enumerate() {
        let FrameRecord {
            sent, without_slot, ..
        } = *frame;
        if sent > budget {
            return format!("frame {number} sends {sent} tiles, allowed {budget}");
        }
        if without_slot > 0 {
            return format!("frame {number} has no slot for {without_slot} tiles");
        }
    }
    String::new()
}

/// What does not depend on when a thread ran.
pub(crate) fn steady(record: &FlightRecord) -> Figures {
    let rest = record.frames.iter().filter(|frame| frame.rests);
    let bytes = rest.clone().map(|frame| frame.queue_bytes as f64).sum();
    let coarse = record.frames.last().map_or(0, |frame| frame.pixels[1]);
    let mut figures = vec![(GLOBE_LOAD_COARSE_LAST_PX.name, coarse as f64)];
    if rest.count() > 0 {
        figures.push((GLOBE_LOAD_STEADY_BYTES.name, bytes));
    }
    figures
}

/// What depends on how fast things went.
pub(crate) fn of_flight(record: &FlightRecord) -> Figures {
    let frames = &record.frames;
    let all = |of: fn(&FrameRecord) -> f64| frames.iter().map(of);
    let most = |of: fn(&FrameRecord) -> f64| all(of).fold(0.0, f64::max);
    let walls: Vec<f64> = all(|frame| frame.wall_ms).collect();
    let longest = most(|frame| frame.wall_ms);
    let last_sent = frames.iter().rposition(|frame| frame.sent > 0);
    let rest = last_sent.map_or(0, |at| (at + 1).saturating_sub(MOVING - 1));
    let mut figures = vec![
        (GLOBE_LOAD_COARSE.name, all(FrameRecord::coarse_share).sum()),
        (GLOBE_LOAD_REST_FRAMES.name, rest as f64),
        (GLOBE_LOAD_BYTES.name, all(|frame| frame.bytes as f64).sum()),
        (GLOBE_LOAD_BYTES_MAX.name, most(|frame| frame.bytes as f64)),
        (GLOBE_LOAD_SENT_MAX.name, most(|frame| frame.sent as f64)),
        (GLOBE_LOAD_FRAME_MAX_WALL_MS.name, longest),
        (
            GLOBE_LOAD_FRAME_CPU_MS.name,
            all(|frame| frame.cpu_ms).sum::<f64>() / frames.len().max(1) as f64,
        ),
    ];
    if let Some(thread) = record.beside {
        figures.push((GLOBE_LOAD_CANCELLED.name, thread.cancelled as f64));
        figures.push((GLOBE_LOAD_THREAD_CPU_MS.name, thread.cpu_ms));
    }
    if let Some(median) = median(&walls) {
        figures.push((GLOBE_LOAD_FRAME_WALL_MS.name, median));
        figures.push((GLOBE_LOAD_SPIKE.name, longest / median));
    }
    figures
}
