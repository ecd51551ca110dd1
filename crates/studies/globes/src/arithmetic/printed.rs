// SPDX-License-Identifier: MIT OR Apache-2.0
//! What two documents printed about their globes, and what can be computed from that alone.

use super::{numbers, table};
use crate::shading::TABLE_3;
use terrafill_plot::number::significant;
use terrafill_tiled_globe::{Line, PUBLISHED_FPS, line, published};

/// Window, triangles; milliseconds of GPU and CPU and what is called idle, per cent, with the full shader and with
/// a white one.
type Timing = (u32, u32, [f64; 3], [f64; 3]);

/// Gebbie & Bailey, Table 1: window, triangles; GPU ms, CPU ms and idle CPU in per cent, with the full
/// shader and with a white one.
const TABLE_1: [Timing; 9] = [
    (1000, 17_058, [13.313, 2.326, 82.5], [3.046, 2.266, 25.6]),
    (800, 17_058, [9.623, 1.967, 79.5], [2.312, 1.714, 25.8]),
    (600, 17_058, [6.3, 1.753, 72.1], [2.097, 1.544, 26.3]),
    (1000, 4_294, [13.89, 1.721, 87.0], [2.056, 1.38, 32.6]),
    (800, 4_294, [9.543, 1.41, 85.0], [1.626, 1.145, 29.56]),
    (600, 4_294, [6.07, 1.28, 78.8], [1.26, 0.94, 25.55]),
    (1000, 2_146, [13.7, 1.557, 88.6], [1.853, 1.161, 37.3]),
    (800, 2_146, [9.37, 1.23, 86.8], [1.523, 1.03, 31.8]),
    (600, 2_146, [5.884, 1.07, 81.75], [1.226, 0.878, 28.4]),
];

/// Table 2: path; GPU ms, CPU ms, idle per cent, mean update ms, and its maximum without and with one
/// transfer per update.
const TABLE_2: [(&str, [f64; 6]); 6] = [
    ("1000² smooth", [3.2, 2.07, 35.0, 0.665, 84.1, 56.0]),
    ("800² smooth", [2.56, 1.74, 31.7, 0.45, 28.1, 16.6]),
    ("600² smooth", [2.04, 1.488, 27.3, 0.381, 19.7, 15.1]),
    ("1000² zoom", [2.86, 1.96, 31.2, 0.56, 76.6, 29.3]),
    ("800² zoom", [2.18, 1.588, 27.1, 0.37, 93.5, 18.4]),
    ("600² zoom", [1.686, 1.26, 24.7, 0.28, 11.8, 14.5]),
];

fn fitted(points: &[[f64; 2]]) -> Line {
    line(points).expect("a line")
}

/// Idle CPU as the tables' own figures give it, per cent.
fn idle(gpu_ms: f64, cpu_ms: f64) -> f64 {
    100.0 * (1.0 - cpu_ms / gpu_ms)
}

/// How far what Table 1 prints as idle is from 1 − CPU/GPU at most, points.
fn idle_difference() -> f64 {
    let both = TABLE_1.iter().flat_map(|row| [row.2, row.3]);
    both.map(|[gpu, cpu, printed]| (idle(gpu, cpu) - printed).abs())
        .fold(0.0, f64::max)
}

/// GPU time with the most triangles over that with the fewest, less 1, by window: full and white shader.
fn tessellation() -> [Vec<f64>; 2] {
    let of = |pick: fn(&Timing) -> f64| -> Vec<f64> {
        let most = TABLE_1[..3].iter();
        most.zip(&TABLE_1[6..])
            .map(|(most, fewest)| pick(most) / pick(fewest) - 1.0)
            .collect()
    };
    [of(|row| row.2[0]), of(|row| row.3[0])]
}

/// What each removal of Table 3 saves, ms and share of the whole.
fn steps() -> Vec<[f64; 2]> {
    let pairs = TABLE_3.windows(2);
    pairs
        .map(|pair| {
            let saved = pair[0].1 - pair[1].1;
            [saved, saved / TABLE_3[0].1]
        })
        .collect()
}

fn rows_of_table_1() -> Vec<Vec<String>> {
    let (_, _, [full, ..], [white, ..]) = TABLE_1[0];
    let rows = TABLE_1.iter().map(|(window, triangles, shaded, plain)| {
        let mut row = vec![format!("{window}²"), triangles.to_string()];
        for ([gpu, cpu, printed], first) in [(shaded, full), (plain, white)] {
            row.extend(numbers([
                gpu / first,
                cpu / first,
                *printed,
                idle(*gpu, *cpu),
            ]));
        }
        row
    });
    rows.collect()
}

fn rows_of_table_2() -> Vec<Vec<String>> {
    let (_, first) = TABLE_2[0];
    let rows = TABLE_2
        .iter()
        .map(|(path, [gpu, cpu, printed, updates @ ..])| {
            let mut row = vec![(*path).to_owned()];
            row.extend(numbers([
                gpu / first[0],
                cpu / first[0],
                *printed,
                idle(*gpu, *cpu),
            ]));
            row.extend(numbers(updates.map(|ms| ms / first[3])));
            row
        });
    rows.collect()
}

pub(super) fn page() -> String {
    let times = published();
    let (all, rest) = (fitted(&times), fitted(&times[1..]));
    let rates = table(
        &["N", "triangles", "FPS, published", "ms", "ratio to N = 1"],
        (1..)
            .zip(PUBLISHED_FPS)
            .zip(&times)
            .map(|((n, rate), [triangles, ms])| {
                let exact = [f64::from(n), *triangles, rate].map(|figure| figure.to_string());
                let ratio = numbers([*ms, ms / times[0][1]]);
                exact.into_iter().chain(ratio).collect()
            }),
    );
    let [tables_1, tables_2] = [
        table(
            &[
                "window",
                "triangles",
                "GPU",
                "CPU",
                "idle %, printed",
                "1 − CPU/GPU, %",
                "GPU, white",
                "CPU, white",
                "idle %, printed",
                "1 − CPU/GPU, %",
            ],
            rows_of_table_1(),
        ),
        table(
            &[
                "path",
                "GPU",
                "CPU",
                "idle %, printed",
                "1 − CPU/GPU, %",
                "mean update",
                "largest",
                "largest, one transfer an update",
            ],
            rows_of_table_2(),
        ),
    ];
    let saved = std::iter::once(String::new()).chain(
        steps()
            .into_iter()
            .map(|[_, share]| format!("{:.1}", 100.0 * share)),
    );
    let rows = TABLE_3.iter().zip(saved);
    let table_3 = table(
        &["feature removed", "GPU", "saved, %"],
        rows.map(|((removed, ms), saved)| {
            vec![(*removed).to_owned(), significant(ms / TABLE_3[0].1), saved]
        }),
    );
    let [full, white] = tessellation().map(|shares| {
        let shares = shares
            .iter()
            .map(|share| format!("{:+.1} %", 100.0 * share));
        shares.collect::<Vec<_>>().join(", ")
    });
    let [correlation, p, rest_correlation, rest_p] =
        [all.correlation, all.p, rest.correlation, rest.p].map(significant);
    format!(
        "## What two documents printed

Another machine, another picture, and neither document says how wrong its pictures are. Times are ratios to their table's
first row.

StuCoSReC 2018, frames per second by N × N rectangles on the screen. “Time rises with the number of triangles” does not
follow: {slope} µs a triangle, correlation {correlation}, p = {p}; without N = 1 correlation {rest_correlation}, p = {rest_p}.
{rates}
Gebbie & Bailey, Table 1, with the full shader and with a white one. “Note the very high percentage of CPU idle time”:
1 − CPU/GPU reproduces the 18 printed figures to {idle} points, so idle is the share of the GPU's time in which the CPU did
not draw, and no load that was measured. “Note that the GPU time is almost completely independent of the level of
tessellation”: 17,058 triangles against 2,146 at 1000², 800², 600² take {full} with the full shader,
{white} with the white one.
{tables_1}
Table 2, decals of an 8192 × 8192 picture; updates are ratios to its first mean update.
{tables_2}
Table 3, “successive features removed”.
{table_3}",
        slope = significant(1e3 * all.slope),
        idle = significant(idle_difference()),
    )
}

/// Share of shuffles of the times whose slope is at least as far from 0.
fn shuffled_as_far(points: &[[f64; 2]], shuffles: u32) -> f64 {
    let middle = points.iter().map(|[x, _]| x).sum::<f64>() / points.len() as f64;
    // A slope but for a factor that no shuffle changes.
    let slope = |times: &[f64]| -> f64 {
        let products = points
            .iter()
            .zip(times)
            .map(|([x, _], ms)| (x - middle) * ms);
        products.sum::<f64>().abs()
    };
    let mut times: Vec<f64> = points.iter().map(|[_, ms]| *ms).collect();
    let least = slope(&times) * (1.0 - 1e-12);
    // Fisher and Yates, by a linear congruential generator (Knuth's MMIX).
    let mut state = 1_u64;
    let mut below = |end: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % end
    };
    let as_far = (0..shuffles).filter(|_| {
        for last in (1..times.len()).rev() {
            times.swap(last, below(last + 1));
        }
        slope(&times) >= least
    });
    as_far.count() as f64 / f64::from(shuffles)
}

#[test]
fn ten_frame_rates_show_no_effect() {
    let times = published();
    let all = fitted(&times);
    assert!((all.correlation - 0.47).abs() < 0.005, "{all:?}");
    assert!((all.p - 0.17).abs() < 0.005, "{all:?}");
    assert!((1e3 * all.slope - 1.4).abs() < 0.05, "{all:?}");
    // By shuffling the ten times the same: 1/6 of all orders correlate as much, none of the distribution assumed.
    assert!((shuffled_as_far(&times, 20_000) - all.p).abs() < 0.01);
    let rest = fitted(&times[1..]);
    assert!((rest.correlation - 0.31).abs() < 0.005, "{rest:?}");
    // The facts print 0.41; t = 0.856 with seven degrees of freedom gives 0.42.
    assert!((rest.p - 0.42).abs() < 0.005, "{rest:?}");
    // Negative control: times that do grow with the triangles.
    let grow = |[triangles, ms]: &[f64; 2]| [*triangles, ms + 0.01 * triangles];
    assert!(fitted(&times.iter().map(grow).collect::<Vec<_>>()).p < 1e-4);
}

#[test]
fn printed_idle_times_are_ratios_and_steps_add_up() {
    // By the facts 0.6 points.
    assert!(idle_difference() < 0.65, "{}", idle_difference());
    // Negative control: as a share of the CPU's own time they are not.
    let [gpu, cpu, printed] = TABLE_1[0].2;
    assert!((idle(cpu, gpu) - printed).abs() > 100.0);
    let steps = steps();
    let sum: f64 = steps.iter().map(|[ms, _]| ms).sum();
    assert!((sum - (8.326 - 1.974)).abs() < 1e-9);
    let most = steps
        .iter()
        .max_by(|a, b| a[0].total_cmp(&b[0]))
        .expect("steps");
    assert!((most[0] - 2.67).abs() < 1e-9 && (most[1] - 0.321).abs() < 5e-4);
    let [full, white] = tessellation();
    let expected = [[0.029, -0.026, -0.066], [-0.39, -0.34, -0.42]];
    // The facts count from the most triangles to the fewest.
    for (found, expected) in [full, white].iter().zip(expected) {
        for (share, expected) in found.iter().zip(expected) {
            let fewer = 1.0 / (1.0 + share) - 1.0;
            assert!((fewer - expected).abs() < 0.006, "{fewer} {expected}");
        }
    }
}
