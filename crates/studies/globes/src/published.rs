// SPDX-License-Identifier: MIT OR Apache-2.0
//! What two documents printed about their globes, and what can be computed from that alone.
//!
//! Nothing here was measured by this program. Published times stand in tables of their own, as ratios to
//! their first row.

use terrafill_plot::number::significant;
use terrafill_results::{Block, Cell, Finding, Heading, Row, Standing, Table};

/// A. Jeromel, StuCoSReC 2018: a grid of N × N rectangles on the screen; frames per second.
const FRAME_RATES: [(f64, f64); 10] = [
    (1.0, 452.90),
    (2.0, 350.62),
    (3.0, 397.89),
    (4.0, 407.09),
    (5.0, 405.80),
    (6.0, 364.40),
    (7.0, 356.11),
    (8.0, 370.66),
    (9.0, 382.86),
    (10.0, 359.95),
];

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

/// Table 3: what was removed, each row lacking all above, and GPU ms.
pub(crate) const TABLE_3: [(&str, f64); 8] = [
    ("None (Complete)", 8.326),
    ("Clouds", 8.082),
    ("City Lights", 7.820),
    ("Tangent normalize", 7.457),
    ("Bump mapping", 4.787),
    ("Specular lighting", 3.535),
    ("Diffuse lighting", 2.143),
    ("White", 1.974),
];

/// Probability below which an effect of chance is not believed.
const SIGNIFICANT: f64 = 0.05;

/// A straight line through points.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    slope: f64,
    correlation: f64,
    /// Two-sided probability of a correlation as large where there is none.
    p: f64,
}

/// Least squares, and Student's test of the correlation.
#[allow(clippy::cast_precision_loss, reason = "ten points")]
fn line(points: &[[f64; 2]]) -> Line {
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let middle = [mean(0), mean(1)];
    let sum = |a: usize, b: usize| -> f64 {
        let terms = points.iter();
        terms
            .map(|point| (point[a] - middle[a]) * (point[b] - middle[b]))
            .sum()
    };
    let correlation = sum(0, 1) / (sum(0, 0) * sum(1, 1)).sqrt();
    let freedom = count - 2.0;
    let t = correlation * (freedom / (1.0 - correlation * correlation)).sqrt();
    Line {
        slope: sum(0, 1) / sum(0, 0),
        correlation,
        p: beyond(t.abs(), freedom),
    }
}

/// Probability that Student's t of `freedom` degrees is farther from 0 than `t`, both sides. With
/// `t = √ν tan θ` the density becomes `cos^(ν−1) θ`, which Simpson's rule takes on a finite range.
fn beyond(t: f64, freedom: f64) -> f64 {
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

/// Idle CPU as the tables' own figures give it, per cent.
fn idle(gpu_ms: f64, cpu_ms: f64) -> f64 {
    100.0 * (1.0 - cpu_ms / gpu_ms)
}

/// Triangles and milliseconds a frame of the published rates.
fn frame_times() -> Vec<[f64; 2]> {
    let rates = FRAME_RATES.iter();
    rates
        .map(|(n, rate)| [2.0 * n * n, 1000.0 / rate])
        .collect()
}

/// All of it.
///
/// - `ours`: by view, cells a side and ms of a frame drawn as published
pub(crate) fn blocks(ours: &[(String, Vec<[f64; 2]>)]) -> Vec<Block> {
    let mut blocks = vec![
        Block::section("What two documents printed"),
        Block::Remark(
            "Published figures, none of ours: another machine, another picture, and neither document \
             says how wrong its pictures are. Times are ratios to their table's first row."
                .to_owned(),
        ),
        Block::Table(frame_rates()),
        Block::Finding(frame_rate_finding()),
    ];
    for (view, times) in ours {
        blocks.push(Block::Table(our_frame_times(view, times)));
        blocks.push(Block::Finding(our_finding(view, times)));
    }
    blocks.extend([
        Block::Table(table_1()),
        Block::Finding(idle_finding()),
        Block::Finding(tessellation_finding()),
        Block::Table(table_2()),
        Block::Table(table_3()),
    ]);
    blocks
}

pub(crate) fn cells(values: impl IntoIterator<Item = f64>) -> Vec<Cell> {
    values
        .into_iter()
        .map(|value| Cell::plain(significant(value)))
        .collect()
}

pub(crate) fn headed(
    caption: &str,
    headings: &[&str],
    rows: impl Iterator<Item = Vec<Cell>>,
) -> Table {
    Table {
        caption: caption.to_owned(),
        headings: headings.iter().map(|text| Heading::plain(*text)).collect(),
        rows: rows.map(Row::new).collect(),
        ..Table::default()
    }
}

fn frame_rates() -> Table {
    let times = frame_times();
    let first = times[0][1];
    let rows = FRAME_RATES
        .iter()
        .zip(&times)
        .map(|((n, rate), [triangles, ms])| cells([*n, *triangles, *rate, *ms, ms / first]));
    headed(
        "StuCoSReC 2018, frames per second by N × N rectangles on the screen",
        &["N", "triangles", "FPS, published", "ms", "ratio to N = 1"],
        rows,
    )
}

fn frame_rate_finding() -> Finding {
    let times = frame_times();
    let (all, rest) = (line(&times), line(&times[1..]));
    Finding {
        claim: "StuCoSReC 2018: time rises with the number of triangles".to_owned(),
        standing: match all.p < SIGNIFICANT {
            true => Standing::Holds,
            false => Standing::CannotTell,
        },
        because: format!(
            "Of the ten published rates: {} µs a triangle, correlation {}, p = {}; without N = 1 \
             correlation {}, p = {}.",
            significant(1e3 * all.slope),
            significant(all.correlation),
            significant(all.p),
            significant(rest.correlation),
            significant(rest.p),
        ),
    }
}

/// Ours beside theirs, as ratios to their first rows.
fn our_frame_times(view: &str, times: &[[f64; 2]]) -> Table {
    let theirs = frame_times();
    let published = |n: f64| {
        let mut rates = FRAME_RATES.iter().zip(&theirs);
        let found = rates.find(|((cells, _), _)| *cells == n);
        found.map(|(_, [_, ms])| ms / theirs[0][1])
    };
    let first = times.first().map_or(f64::NAN, |time| time[1]);
    let rows = times.iter().map(|[n, ms]| {
        let mut row = cells([*n, 2.0 * n * n, *ms, ms / first]);
        row.push(Cell::or_absent(
            published(*n).map(significant),
            "not published",
        ));
        row
    });
    headed(
        &format!("Ours in view {view}, tiles drawn one by one as published"),
        &[
            "N",
            "triangles before the seam",
            "frame, ms",
            "ratio to the first",
            "published, ratio",
        ],
        rows,
    )
}

/// Whether our own times rise with the number of triangles.
fn our_finding(view: &str, times: &[[f64; 2]]) -> Finding {
    let points: Vec<[f64; 2]> = times.iter().map(|[n, ms]| [2.0 * n * n, *ms]).collect();
    let all = line(&points);
    Finding {
        claim: format!("Ours in view {view}: time rises with the number of triangles"),
        standing: match all.p.is_nan() {
            true => Standing::CannotTell,
            false if all.p < SIGNIFICANT && all.slope > 0.0 => Standing::Holds,
            false => Standing::CannotTell,
        },
        because: format!(
            "Of {} numbers of cells: {} µs a triangle, correlation {}, p = {}.",
            points.len(),
            significant(1e3 * all.slope),
            significant(all.correlation),
            significant(all.p)
        ),
    }
}

fn table_1() -> Table {
    let (_, _, [full, ..], [white, ..]) = TABLE_1[0];
    let rows = TABLE_1.iter().map(|(window, triangles, shaded, plain)| {
        let mut row = vec![Cell::plain(format!("{window}²"))];
        row.extend(cells([f64::from(*triangles)]));
        for ([gpu, cpu, printed], first) in [(shaded, full), (plain, white)] {
            row.extend(cells([
                gpu / first,
                cpu / first,
                *printed,
                idle(*gpu, *cpu),
            ]));
        }
        row
    });
    headed(
        "Gebbie & Bailey, Table 1: times as ratios to the first row's GPU time, with the full shader and \
         with a white one",
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
        rows,
    )
}

/// How far what Table 1 prints as idle is from 1 − CPU/GPU at most, points.
fn idle_difference() -> f64 {
    let both = TABLE_1.iter().flat_map(|row| [row.2, row.3]);
    both.map(|[gpu, cpu, printed]| (idle(gpu, cpu) - printed).abs())
        .fold(0.0, f64::max)
}

fn idle_finding() -> Finding {
    let worst = idle_difference();
    Finding {
        claim: "Gebbie & Bailey: “Note the very high percentage of CPU idle time.”".to_owned(),
        standing: Standing::CannotTell,
        because: format!(
            "1 − CPU/GPU reproduces the 18 printed figures to {} points. What is called idle is the \
             share of the GPU's time in which the CPU did not draw, and no load that was measured.",
            significant(worst)
        ),
    }
}

/// GPU time with the most triangles over that with the fewest, less 1, by window: full and white shader.
pub(crate) fn tessellation_published() -> [Vec<f64>; 2] {
    let of = |pick: fn(&Timing) -> f64| -> Vec<f64> {
        let most = TABLE_1[..3].iter();
        let fewest = &TABLE_1[6..];
        most.zip(fewest)
            .map(|(most, fewest)| pick(most) / pick(fewest) - 1.0)
            .collect()
    };
    [of(|row| row.2[0]), of(|row| row.3[0])]
}

fn tessellation_finding() -> Finding {
    let per_cent = |shares: &[f64]| {
        let shares = shares
            .iter()
            .map(|share| format!("{:+.1} %", 100.0 * share));
        shares.collect::<Vec<_>>().join(", ")
    };
    let [full, white] = tessellation_published();
    Finding {
        claim: "Gebbie & Bailey: “Note that the GPU time is almost completely independent of the level of \
                tessellation.”"
            .to_owned(),
        standing: Standing::CannotTell,
        because: format!(
            "Of Table 1, 17,058 triangles against 2,146, at 1000², 800², 600²: with the full shader {}, \
             with the white one {}. It is true of what fragments cost there.",
            per_cent(&full),
            per_cent(&white)
        ),
    }
}

fn table_2() -> Table {
    let (_, first) = TABLE_2[0];
    let rows = TABLE_2
        .iter()
        .map(|(path, [gpu, cpu, printed, mean, most, capped])| {
            let mut row = vec![Cell::plain(*path)];
            row.extend(cells([
                gpu / first[0],
                cpu / first[0],
                *printed,
                idle(*gpu, *cpu),
            ]));
            row.extend(cells([mean / first[3], most / first[3], capped / first[3]]));
            row
        });
    headed(
        "Gebbie & Bailey, Table 2, decals of an 8192 × 8192 picture: times as ratios to the first row's GPU \
         time, updates as ratios to its mean update",
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
        rows,
    )
}

/// What each removal saves, ms and share of the whole.
fn steps() -> Vec<[f64; 2]> {
    let pairs = TABLE_3.windows(2);
    pairs
        .map(|pair| {
            let saved = pair[0].1 - pair[1].1;
            [saved, saved / TABLE_3[0].1]
        })
        .collect()
}

fn table_3() -> Table {
    let steps = steps();
    let rows = TABLE_3.iter().enumerate().map(|(place, (removed, ms))| {
        let step = place.checked_sub(1).map(|before| steps[before]);
        let share = step.map(|[_, share]| format!("{:.1} %", 100.0 * share));
        vec![
            Cell::plain(*removed),
            Cell::plain(significant(ms / TABLE_3[0].1)),
            Cell::or_absent(share, "nothing is removed in the first row"),
        ]
    });
    headed(
        "Gebbie & Bailey, Table 3, “successive features removed”: GPU time as a ratio to the first row, and \
         what each removal saves of it",
        &["feature removed", "GPU", "step"],
        rows,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_frame_rates_show_no_effect() {
        let times = frame_times();
        let all = line(&times);
        assert!((all.correlation - 0.47).abs() < 0.005, "{all:?}");
        assert!((all.p - 0.17).abs() < 0.005, "{all:?}");
        assert!((1e3 * all.slope - 1.4).abs() < 0.05, "{all:?}");
        let rest = line(&times[1..]);
        assert!((rest.correlation - 0.31).abs() < 0.005, "{rest:?}");
        // The facts print 0.41; t = 0.856 with seven degrees of freedom gives 0.42.
        assert!((rest.p - 0.42).abs() < 0.005, "{rest:?}");
        assert_eq!(frame_rate_finding().standing, Standing::CannotTell);
        // Twin: times that do grow with the triangles.
        let grow = |[triangles, ms]: &[f64; 2]| [*triangles, ms + 0.01 * triangles];
        assert!(line(&times.iter().map(grow).collect::<Vec<_>>()).p < 1e-4);
    }

    #[test]
    fn students_distribution_has_its_tabulated_quantiles() {
        for (t, freedom, p) in [(2.306, 8.0, 0.05), (3.355, 8.0, 0.01), (12.706, 1.0, 0.05)] {
            assert!((beyond(t, freedom) / p - 1.0).abs() < 1e-3, "{t}");
        }
        assert!((beyond(0.0, 8.0) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn printed_idle_times_are_ratios_and_steps_add_up() {
        // By the facts 0.6 points.
        assert!(idle_difference() < 0.65, "{}", idle_difference());
        // Twin: as a share of the CPU's own time they are not.
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
        let [full, white] = tessellation_published();
        let expected = [[0.029, -0.026, -0.066], [-0.39, -0.34, -0.42]];
        // The facts count from the most triangles to the fewest.
        for (found, expected) in [full, white].iter().zip(expected) {
            for (share, expected) in found.iter().zip(expected) {
                let fewer = 1.0 / (1.0 + share) - 1.0;
                assert!((fewer - expected).abs() < 0.006, "{fewer} {expected}");
            }
        }
    }
}
