// SPDX-License-Identifier: MIT OR Apache-2.0
//! Numbers as people read them: three significant digits for measured values, every digit for counts.

use terrafill_results::{Estimate, Spread};

/// Groups of three digits are separated by a narrow no-break space, which no locale takes for a
/// decimal sign (SI brochure, 9th edition, §5.4.4).
const GROUP: char = '\u{202f}';

/// A measured value to three significant digits.
#[must_use]
pub fn significant(value: f64) -> String {
    if !value.is_finite() {
        return "not finite".to_owned();
    }
    let magnitude = value.abs();
    if magnitude > 0.0 && !(1e-4..1e7).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    let decimals = match magnitude {
        0.0 => 0,
        m if m >= 99.95 => 0,
        m if m >= 9.995 => 1,
        m if m >= 0.9995 => 2,
        m if m >= 0.09995 => 3,
        m if m >= 0.009_995 => 4,
        _ => 5,
    };
    let text = format!("{value:.decimals$}");
    match text.split_once('.') {
        Some((whole, fraction)) => format!("{}.{fraction}", grouped(whole)),
        None => grouped(&text),
    }
}

/// A count, every digit.
#[must_use]
pub fn count(value: u64) -> String {
    grouped(&value.to_string())
}

/// The same of a measured value, which is whole and not negative.
#[must_use]
#[allow(
    clippy::cast_possible_truncation,
    reason = "whole, not negative and below 2⁵³"
)]
pub fn digits(value: f64) -> String {
    count(value.round() as u64)
}

/// Bytes, short: decimal units, three significant digits.
#[must_use]
pub fn bytes(value: u64) -> String {
    measured_bytes(value as f64)
}

/// The same of a measured value, which is a whole number.
#[must_use]
pub fn measured_bytes(value: f64) -> String {
    match value {
        v if v >= 1e9 => format!("{} GB", significant(v / 1e9)),
        v if v >= 1e6 => format!("{} MB", significant(v / 1e6)),
        v if v >= 1e3 => format!("{} kB", significant(v / 1e3)),
        v => format!("{v} B"),
    }
}

/// `text` cut in its middle to at most `limit` characters.
#[must_use]
pub fn elided(text: &str, limit: usize) -> String {
    let length = text.chars().count();
    if length <= limit {
        return text.to_owned();
    }
    let kept = limit.saturating_sub(1);
    let head: String = text.chars().take(kept.div_ceil(2)).collect();
    let tail: String = text.chars().skip(length - kept / 2).collect();
    format!("{head}…{tail}")
}

/// Seconds since 1970 as date and time, UTC; empty for 0, which stands for "not recorded".
///
/// Days to date after Hinnant, "chrono-compatible low-level date algorithms" (`civil_from_days`).
#[must_use]
pub fn utc(unix_s: u64) -> String {
    if unix_s == 0 {
        return String::new();
    }
    let (days, second) = (unix_s / 86_400 + 719_468, unix_s % 86_400);
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = (shifted_month + 2) % 12 + 1;
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!(
        "{year}-{month:02}-{day:02} {:02}:{:02} UTC",
        second / 3600,
        second / 60 % 60
    )
}

fn grouped(digits: &str) -> String {
    let (sign, digits) = digits
        .strip_prefix('-')
        .map_or(("", digits), |rest| ("-", rest));
    let mut text = String::from(sign);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(GROUP);
        }
        text.push(digit);
    }
    text
}

/// A factor, with its interval where there is one: `2.00 × [1.90–2.10]`.
#[must_use]
pub fn times(ratio: &Estimate) -> String {
    format!("{} ×{}", significant(ratio.middle), interval(ratio))
}

/// A plain figure with its interval.
#[must_use]
pub fn figure(estimate: &Estimate) -> String {
    format!("{}{}", significant(estimate.middle), interval(estimate))
}

fn interval(estimate: &Estimate) -> String {
    estimate.interval.map_or_else(String::new, |[low, high]| {
        format!(" [{}–{}]", significant(low), significant(high))
    })
}

/// A median with its 5th and 95th percentile, `12.0 (11.1–13.0)`: brackets are for 95 % intervals.
/// One sample has none.
#[must_use]
pub fn spread(of: Spread) -> String {
    let [median, p5, p95] = [of.median, of.p5, of.p95].map(significant);
    if of.p5 < of.p95 {
        format!("{median} ({p5}–{p95})")
    } else {
        median
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_whatever_the_size() {
        let cases = [
            (0.0, "0"),
            (0.001_234, "0.00123"),
            (0.012_34, "0.0123"),
            (0.999_6, "1.00"),
            (1.234, "1.23"),
            (9.996, "10.0"),
            (12.34, "12.3"),
            (123.4, "123"),
            (12_345.6, "12\u{202f}346"),
            (-1.5, "-1.50"),
            (3.2e-9, "3.20e-9"),
        ];
        for (value, text) in cases {
            assert_eq!(significant(value), text, "{value}");
        }
        assert_eq!(significant(f64::NAN), "not finite");
    }

    #[test]
    fn counts_keep_every_digit() {
        assert_eq!(count(0), "0");
        assert_eq!(count(999), "999");
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn bytes_are_decimal() {
        assert_eq!(bytes(512), "512 B");
        assert_eq!(bytes(13_900_000), "13.9 MB");
        assert_ne!(bytes(1_048_576), "1.00 MB", "a mebibyte is no megabyte");
    }

    #[test]
    fn dates_around_leap_days() {
        let cases = [
            (1, "1970-01-01 00:00 UTC"),
            (951_782_399, "2000-02-28 23:59 UTC"),
            (951_782_400, "2000-02-29 00:00 UTC"),
            (951_868_800, "2000-03-01 00:00 UTC"),
            (1_735_689_599, "2024-12-31 23:59 UTC"),
            (0, ""),
        ];
        for (unix_s, text) in cases {
            assert_eq!(utc(unix_s), text);
        }
    }

    #[test]
    fn long_names_lose_their_middle_only() {
        assert_eq!(elided("doubled", 7), "doubled");
        assert_eq!(elided("abcdefghij", 5), "ab…ij");
        assert_eq!(elided("äöüßéèê", 4).chars().count(), 4);
    }
}
