// SPDX-License-Identifier: MIT OR Apache-2.0
//! DTED levels 0 to 2 (MIL-PRF-89020B, 2000, §3.13): three headers, then a record for each meridian
//! from the west, of 16-bit whole metres from the south, sign and magnitude, each with a checksum.
//!
//! Some producers write negative heights in two's complement instead, and some wrong checksums; GDAL reads both
//! (`dted_api.c`), and so does this, with a warning.

use crate::error::Complaints;
use crate::{ElevationError, Grid, HeightField, MAX_SAMPLES, Projection, Registration};

/// Bytes of the headers UHL, DSI and ACC.
const HEADERS: usize = 80 + 648 + 2700;
/// Bytes of a record before and after its heights.
const BEFORE: usize = 8;
const AFTER: usize = 4;
/// First byte of a record.
const SENTINEL: u8 = 0xAA;
/// All bits set: minus 32,767, no height.
const VOID: u16 = 0xFFFF;
/// Lower than this by sign and magnitude, metres, a sample is in two's complement: there it is above −16,768 m.
const LOWEST_M: f32 = -16_000.0;

pub(super) fn read(
    complaints: Complaints<'_>,
    bytes: &[u8],
) -> Result<HeightField, ElevationError> {
    if bytes.len() < HEADERS {
        return Err(complaints.value(
            "bytes",
            bytes.len(),
            format!("{HEADERS} of headers, then records"),
        ));
    }
    if &bytes[..4] != b"UHL1" {
        let found = String::from_utf8_lossy(&bytes[..4]).into_owned();
        return Err(complaints.value("UHL, first bytes", format!("{found:?}"), "\"UHL1\""));
    }
    let number = |place: &str, from: usize, to: usize, most: u32| -> Result<u32, ElevationError> {
        let text = String::from_utf8_lossy(&bytes[from..to]).into_owned();
        let digits = text.trim();
        let value = digits
            .parse()
            .ok()
            .filter(|value| (1..=most).contains(value));
        value.ok_or_else(|| complaints.value(place, format!("{text:?}"), format!("1 to {most}")))
    };
    let west_deg = angle(
        complaints,
        "UHL, longitude",
        &bytes[4..12],
        ['E', 'W'],
        180.0,
    )?;
    let south_deg = angle(
        complaints,
        "UHL, latitude",
        &bytes[12..20],
        ['N', 'S'],
        90.0,
    )?;
    // Tenths of arc-seconds; no level is coarser than a degree.
    let step_east = number("UHL, longitude interval", 20, 24, 9_999)?;
    let step_north = number("UHL, latitude interval", 24, 28, 9_999)?;
    let columns = number("UHL, longitude lines", 47, 51, 9_999)?;
    let rows = number("UHL, latitude points", 51, 55, 9_999)?;
    let record = BEFORE + 2 * rows as usize + AFTER;
    let needed = HEADERS + record * columns as usize;
    // Before anything is allocated for it.
    if bytes.len() < needed || u64::from(columns) * u64::from(rows) > MAX_SAMPLES {
        let allowed = format!("{needed}, for {columns} records of {rows} heights");
        return Err(complaints.value("bytes", bytes.len(), allowed));
    }
    let mut samples = vec![f32::NAN; columns as usize * rows as usize];
    let (mut wrong_sums, mut complements) = (Vec::new(), 0);
    for (column, record) in bytes[HEADERS..needed].chunks_exact(record).enumerate() {
        if let Some(wrong) = wrong_sum(complaints, column, record)? {
            wrong_sums.push(wrong);
        }
        let heights = &record[BEFORE..record.len() - AFTER];
        for (north, pair) in heights.chunks_exact(2).enumerate() {
            let row = rows as usize - 1 - north;
            let (height_m, is_complement) = height_m([pair[0], pair[1]]);
            complements += u64::from(is_complement);
            samples[row * columns as usize + column] = height_m;
        }
    }
    let step = [step_east, step_north].map(|tenths| f64::from(tenths) / 36_000.0);
    let grid = Grid {
        projection: Projection::Geographic,
        registration: Registration::Point,
        columns,
        rows,
        first: [
            west_deg,
            south_deg + f64::from(rows.saturating_sub(1)) * step[1],
        ],
        step,
    };
    let mut warnings = Vec::new();
    if let Some(first) = wrong_sums.first() {
        warnings.push(format!(
            "{} of {columns} records have a wrong checksum, and are read: {first}",
            wrong_sums.len()
        ));
    }
    if complements > 0 {
        warnings.push(format!(
            "{complements} heights are in two's complement, where DTED has sign and magnitude: read so; a height of -1 m \
             cannot be told from a void there"
        ));
    }
    Ok(HeightField::new(complaints.file, grid, samples)?.with_warnings(warnings))
}

/// Words for a checksum that is not the sum of its record.
fn wrong_sum(
    complaints: Complaints<'_>,
    column: usize,
    record: &[u8],
) -> Result<Option<String>, ElevationError> {
    let place = |what: &str| format!("record {column}, {what}");
    if record[0] != SENTINEL {
        let found = format!("{:#04x}", record[0]);
        return Err(complaints.value(place("first byte"), found, format!("{SENTINEL:#04x}")));
    }
    let (summed, stated) = record.split_at(record.len() - AFTER);
    let sum: u32 = summed.iter().map(|&byte| u32::from(byte)).sum();
    let stated = stated
        .iter()
        .fold(0, |value: u32, &byte| value << 8 | u32::from(byte));
    Ok((sum != stated).then(|| {
        let place = place("checksum");
        format!("{place}: found {stated}, allowed: {sum}, the sum of its bytes")
    }))
}

/// The height, and whether it is in two's complement.
fn height_m(pair: [u8; 2]) -> (f32, bool) {
    let bits = u16::from_be_bytes(pair);
    let magnitude = f32::from(bits & 0x7FFF);
    match bits >> 15 {
        _ if bits == VOID => (f32::NAN, false),
        0 => (magnitude, false),
        _ if -magnitude < LOWEST_M => (f32::from(bits.cast_signed()), true),
        _ => (-magnitude, false),
    }
}

/// `DDDMMSSH`, degrees, minutes, seconds and hemisphere.
fn angle(
    complaints: Complaints<'_>,
    place: &str,
    text: &[u8],
    letters: [char; 2],
    most_deg: f64,
) -> Result<f64, ElevationError> {
    let degrees = || -> Option<f64> {
        let text = std::str::from_utf8(text).ok()?;
        let part = |from: usize, to: usize| -> Option<f64> {
            let digits = text.get(from..to)?;
            digits
                .bytes()
                .all(|b| b.is_ascii_digit())
                .then(|| digits.parse().ok())?
        };
        let magnitude = part(0, 3)? + part(3, 5)? / 60.0 + part(5, 7)? / 3600.0;
        let sign = match text.chars().nth(7)? {
            letter if letter == letters[0] => 1.0,
            letter if letter == letters[1] => -1.0,
            _ => return None,
        };
        (magnitude <= most_deg).then_some(sign * magnitude)
    };
    degrees().ok_or_else(|| {
        let found = String::from_utf8_lossy(text).into_owned();
        let allowed = format!(
            "DDDMMSS{} or DDDMMSS{}, up to {most_deg}°",
            letters[0], letters[1]
        );
        complaints.value(place, format!("{found:?}"), allowed)
    })
}
