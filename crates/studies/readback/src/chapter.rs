// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on reading back: time against bytes, one curve per graphics interface.
//!
//! Time is modelled as latency + bytes ÷ rate. The line is fitted by least squares of the relative
//! residuals, since noise grows with time; by absolute ones the largest image alone would set both.
//! Every process has a line of its own, and the range over processes is the fit's spread.

use crate::keys::{API, SIZE_PX};
use crate::metrics::METRICS;
use terrafill_plot::number::{bytes, significant};
use terrafill_plot::{
    Curve, Palette, Point, PointStanding, Reading, ReferenceLine, Upwards, WorkPrecision, dotted,
    named_aside,
};
use terrafill_results::{
    Answers, Block, Case, Cell, Chapter, ChapterError, Clock, Heading, Metric, Plot, Row, Run,
    Spread, Table, median, process_medians, sample_spread,
};

const CPU: &Metric = Metric::of(&METRICS, "readback_cpu_ms");
const WALL: &Metric = Metric::of(&METRICS, "readback_wall_ms");
const BYTES: &Metric = Metric::of(&METRICS, "readback_bytes");
const RATE: &Metric = Metric::of(&METRICS, "readback_rate");

/// A line through two sizes has no residual that could speak against it.
const MIN_SIZES_FOR_FIT: usize = 3;

/// Why one clock or the other.
const WHY_THIS_CLOCK: &str = "On a GPU a read-back is a wait of the CPU outside of every GPU pass, so wall clock is compared. \
     On a software device the CPU itself copies, so process CPU time is compared, which other \
     programs hardly change.";

/// What the interfaces do differently.
const WHAT_IS_COMPARED: &str = "Through wgpu colour and depth are submitted and waited for one after the other, through Vulkan \
     both at once. Both times include new staging buffers and packing the rows into new memory. The \
     rate is always bytes over wall clock.";

/// What reading an image back costs.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReadbackChapter;

/// One interface.
struct ApiTimes<'a> {
    name: &'a str,
    /// By rising bytes.
    sizes: Vec<Size<'a>>,
}

/// An image size that was measured.
struct Size<'a> {
    side: &'a str,
    bytes: f64,
    /// Median over processes.
    ms: f64,
    /// Of single reads.
    time: Spread,
    rate: Option<f64>,
    /// One time for each process.
    replicates: Vec<f64>,
}

/// Time = `latency_ms` + bytes ÷ `rate`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Fit {
    latency_ms: f64,
    /// MB/s.
    rate: f64,
}

impl Chapter for ReadbackChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Read-back: time against bytes"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(metric(clock).name)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let apis = apis(run);
        let blocks = match apis.is_empty() {
            true => Vec::new(),
            false => vec![Block::Text(answer(&apis, run.clock()))],
        };
        Ok(Answers {
            blocks,
            ..Answers::default()
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let apis = apis(run);
        if apis.is_empty() {
            return Ok(Vec::new());
        }
        let clock = run.clock();
        let mut blocks = vec![Block::Text(answer(&apis, clock))];
        if let Some(svg) = drawing(&apis, clock)? {
            blocks.push(Block::Plot(Plot {
                caption: format!(
                    "{} of reading colour and depth back; whiskers: 5–95 % of the reads. Along the \
                     dashed line time grows as the bytes do. A curve is flat where latency rules.",
                    clock_name(clock)
                ),
                svg,
            }));
        }
        blocks.push(Block::Table(table(run, clock)));
        blocks.push(Block::Table(fits(&apis)));
        blocks.push(Block::Remark(WHAT_IS_COMPARED.to_owned()));
        Ok(blocks)
    }
}

fn metric(clock: Clock) -> &'static Metric {
    clock.pick(WALL, CPU)
}

fn clock_name(clock: Clock) -> &'static str {
    clock.pick("Wall clock time", "Process CPU time")
}

fn cases(run: &Run) -> impl Iterator<Item = &Case> {
    run.of_study(crate::STUDY).filter(|case| !case.is_twin())
}

/// Interfaces in the order in which they first appear.
fn apis(run: &Run) -> Vec<ApiTimes<'_>> {
    let mut apis: Vec<ApiTimes<'_>> = Vec::new();
    for case in cases(run) {
        let name = case.condition(API);
        let index = apis.iter().position(|api| api.name == name);
        let index = index.unwrap_or_else(|| {
            apis.push(ApiTimes {
                name,
                sizes: Vec::new(),
            });
            apis.len() - 1
        });
        apis[index].sizes.extend(size(case, run.clock()));
    }
    for api in &mut apis {
        api.sizes.sort_by(|a, b| a.bytes.total_cmp(&b.bytes));
    }
    apis
}

/// `None` unless it was measured as often as planned.
fn size(case: &Case, clock: Clock) -> Option<Size<'_>> {
    if !case.counts() {
        return None;
    }
    Some(Size {
        side: case.condition(SIZE_PX),
        bytes: case.value(BYTES)?,
        ms: case.value(metric(clock))?,
        time: sample_spread(case, metric(clock))?,
        rate: case.value(RATE),
        replicates: process_medians(case, metric(clock)).into_values().collect(),
    })
}

/// A sentence for each interface, and one on the clock.
fn answer(apis: &[ApiTimes<'_>], clock: Clock) -> String {
    let sentences = apis.iter().map(|api| {
        let [Some(small), Some(large)] = [api.sizes.first(), api.sizes.last()] else {
            return format!("Nothing was read back through {}.", api.name);
        };
        let rate = large.rate.map_or_else(|| "–".to_owned(), significant);
        format!(
            "Through {} an image of {} × {} pixels ({}) takes {} ms to read back, {rate} MB/s by wall \
             clock; the smallest, {} × {}, takes {} ms, which stands for the latency.",
            api.name,
            large.side,
            large.side,
            megabytes(large.bytes),
            significant(large.ms),
            small.side,
            small.side,
            significant(small.ms),
        )
    });
    let sentences: Vec<String> = sentences.collect();
    format!(
        "{} Times are {}. {WHY_THIS_CLOCK}",
        sentences.join(" "),
        clock_name(clock).to_lowercase().replace("cpu", "CPU")
    )
}

/// Whole and positive, as written.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count of bytes below 2⁵³"
)]
fn megabytes(count: f64) -> String {
    bytes(count as u64)
}

/// A row for each case, those that were not measured too.
fn table(run: &Run, clock: Clock) -> Table {
    let rows = cases(run).map(|case| {
        let why = || match case.reason.as_str() {
            "" => "not measured",
            reason => reason,
        };
        let value = |metric| case.value(metric).filter(|_| case.counts());
        let cell = |value: Option<f64>| Cell::or_absent(value.map(significant), why());
        let timed = |metric| dotted(cell(value(metric)), case, metric);
        let each = process_medians(case, metric(clock)).into_values();
        let each: Vec<String> = each.map(significant).collect();
        let each = (case.counts() && !each.is_empty()).then(|| each.join(", "));
        Row {
            cells: vec![
                Cell::name(case.condition(API)),
                Cell::plain(case.condition(SIZE_PX)),
                Cell::or_absent(value(BYTES).map(megabytes), why()),
                timed(metric(clock)),
                timed(clock.pick(CPU, WALL)),
                cell(value(RATE)),
                Cell::or_absent(each, why()),
            ],
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    });
    let time = |name: &'static Metric| {
        let text = if name == CPU { "CPU, ms" } else { "wall, ms" };
        Heading::metric(text, name)
    };
    Table {
        headings: vec![
            Heading::plain("interface"),
            Heading::explained("pixels a side", "width and height of the image"),
            Heading::metric("bytes", BYTES),
            time(metric(clock)),
            time(clock.pick(CPU, WALL)),
            Heading::metric("rate, MB/s", RATE),
            Heading::explained(
                "each process, ms",
                format!(
                    "medians of single processes, {}",
                    clock_name(clock).to_lowercase().replace("cpu", "CPU")
                ),
            ),
        ],
        rows: rows.collect(),
        is_main: true,
        ..Table::default()
    }
}

/// Latency and rate of each interface over its sizes.
fn fits(apis: &[ApiTimes<'_>]) -> Table {
    let rows = apis.iter().map(|api| {
        let fits = fits_of_processes(api);
        let cell = |of: fn(&Fit) -> f64| {
            let values: Vec<f64> = fits.iter().map(of).collect();
            let why = format!("fewer than {MIN_SIZES_FOR_FIT} sizes, or no rising times");
            Cell::or_absent(with_range(&values), why)
        };
        Row::new(vec![
            Cell::name(api.name),
            cell(|fit| fit.latency_ms),
            cell(|fit| fit.rate),
        ])
    });
    Table {
        caption:
            "Line through all sizes: time = latency + bytes ÷ rate. Median over processes, and \
                  range where there are several. A latency below 0 means that small images come \
                  faster than any line allows."
                .to_owned(),
        headings: vec![
            Heading::plain("interface"),
            Heading::explained("latency, ms", "time of an image without pixels"),
            Heading::explained(
                "rate, MB/s",
                "bytes per time beyond latency, 1 MB = 10⁶ bytes",
            ),
        ],
        rows: rows.collect(),
        ..Table::default()
    }
}

fn fits_of_processes(api: &ApiTimes<'_>) -> Vec<Fit> {
    let counts = api.sizes.iter().map(|size| size.replicates.len());
    // Cases that count were measured by every process.
    let processes = counts.min().unwrap_or(0);
    let of = |process: usize| {
        let points = api.sizes.iter();
        let points: Vec<[f64; 2]> = points
            .map(|size| [size.bytes, size.replicates[process]])
            .collect();
        fit(&points)
    };
    (0..processes).filter_map(of).collect()
}

/// Weighted linear regression of milliseconds on bytes, weights 1 / time²; `None` with too few points
/// or where time does not rise.
fn fit(points: &[[f64; 2]]) -> Option<Fit> {
    if points.len() < MIN_SIZES_FOR_FIT {
        return None;
    }
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        let terms = points.iter().map(|&[x, y]| of(x, y) / (y * y));
        terms.sum()
    };
    let weight = sum(&|_, _| 1.0);
    let middle = [sum(&|x, _| x) / weight, sum(&|_, y| y) / weight];
    let spread = sum(&|x, _| (x - middle[0]).powi(2));
    let ms_per_byte = sum(&|x, y| (x - middle[0]) * (y - middle[1])) / spread;
    (ms_per_byte > 0.0).then(|| Fit {
        latency_ms: middle[1] - ms_per_byte * middle[0],
        rate: 1e-3 / ms_per_byte,
    })
}

/// `2.00, 1.90 to 2.10`: median, lowest and highest.
fn with_range(values: &[f64]) -> Option<String> {
    let middle = significant(median(values)?);
    if values.len() == 1 {
        return Some(middle);
    }
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let [lowest, highest] = [lowest, highest].map(significant);
    Some(format!("{middle}, {lowest} to {highest}"))
}

fn drawing(apis: &[ApiTimes<'_>], clock: Clock) -> Result<Option<String>, ChapterError> {
    let curves = apis.iter().filter(|api| !api.sizes.is_empty());
    let apis: Vec<&ApiTimes<'_>> = curves.collect();
    let up = clock.pick(
        "wall clock, ms: median, 5–95 %",
        "process CPU, ms: median, 5–95 %",
    );
    let plot = WorkPrecision {
        title: "Time to read back against bytes",
        across: "bytes of colour and depth",
        up,
        upwards: Upwards::Amount,
        curves: apis.iter().map(|api| curve(api)).collect(),
        lines: slope(&apis).into_iter().collect(),
    };
    let names: Vec<String> = apis.iter().map(|api| api.name.to_owned()).collect();
    let palette = Palette::new(names.clone());
    Ok(named_aside(
        "time to read back against bytes",
        &plot,
        &names,
        &palette,
    )?)
}

fn curve(api: &ApiTimes<'_>) -> Curve {
    let point = |size: &Size<'_>| Point {
        knob: size.bytes,
        label: String::new(),
        x: Some(Reading::exact(size.bytes)),
        y: Some(Reading::sampled(size.time, &size.replicates)),
        y_rms: None,
        standing: PointStanding::Right,
        command: String::new(),
    };
    Curve {
        name: api.name.to_owned(),
        points: api.sizes.iter().map(point).collect(),
    }
}

/// From the fastest first point.
fn slope(apis: &[&ApiTimes<'_>]) -> Option<ReferenceLine> {
    let firsts = apis.iter().filter_map(|api| api.sizes.first());
    let fastest = firsts.min_by(|a, b| a.time.median.total_cmp(&b.time.median));
    fastest.map(|size| ReferenceLine {
        label: "slope 1".to_owned(),
        from_x: Some(size.bytes),
        y: size.time.median,
        power: 1.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{CellClass, RunEnvironment, Status};

    /// 0.5 ms, and 1,000 MB/s; process 1 is twice as slow.
    fn run() -> MadeUpRun {
        let mut run = MadeUpRun::default();
        for side in [64_u32, 512, 1024] {
            let text = side.to_string();
            let conditions = [("api", "wgpu"), ("size_px", &text)];
            let case = run.case(case_id(crate::STUDY, &format!("wgpu/{side}"), &conditions));
            let bytes = 8.0 * f64::from(side).powi(2);
            let ms = 0.5 + bytes * 1e-6;
            case.figure(BYTES, bytes);
            case.timed(CPU, &[ms, 2.0 * ms]);
            case.timed(WALL, &[10.0 * ms, 10.0 * ms]);
            case.timed(RATE, &[100.0, 100.0]);
        }
        let conditions = [("api", "vulkan"), ("size_px", "64")];
        let skipped = run.case(case_id(crate::STUDY, "vulkan/64", &conditions));
        skipped.ended(Status::Skipped, "no such device");
        run
    }

    fn blocks(run: &MadeUpRun) -> Vec<Block> {
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        ReadbackChapter.blocks(&run).expect("a chapter")
    }

    #[test]
    fn a_line_is_found_and_two_points_are_none() {
        let line = [[1e5, 0.6], [1e6, 1.5], [1e7, 10.5], [1e8, 100.5]];
        let found = fit(&line).expect("a line");
        assert!((found.latency_ms - 0.5).abs() < 1e-9, "{found:?}");
        assert!((found.rate - 1000.0).abs() < 1e-6, "{found:?}");
        assert_eq!(fit(&line[..2]), None);
        // Twin: times that fall with size are no rate.
        assert_eq!(fit(&line.map(|[x, y]| [x, 1.0 / y])), None);
    }

    #[test]
    fn times_are_told_in_a_sentence_a_plot_and_tables() {
        let blocks = blocks(&run());
        let [
            Block::Text(text),
            Block::Plot(plot),
            Block::Table(table),
            Block::Table(fits),
            Block::Remark(_),
        ] = &blocks[..]
        else {
            panic!("a sentence, a plot, two tables and a remark: {blocks:?}");
        };
        assert!(text.contains("Through wgpu an image of 1024 × 1024 pixels (8.39 MB)"));
        assert!(text.contains("Nothing was read back through vulkan."));
        assert!(text.contains("Times are process CPU time."));
        assert!(plot.svg.contains("slope 1") && plot.svg.contains("process CPU"));
        let cells = |row: usize| table.rows[row].cells.iter();
        let texts = |row| {
            cells(row)
                .map(|cell| cell.text.as_str())
                .collect::<Vec<_>>()
        };
        assert_eq!(
            texts(2),
            [
                "wgpu",
                "1024",
                "8.39 MB",
                "13.3",
                "88.9",
                "100",
                "8.89, 17.8"
            ]
        );
        assert!(cells(3).skip(2).all(|cell| cell.class == CellClass::Absent));
        assert_eq!(table.rows[3].remark, "no such device");
        assert_eq!(fits.rows[0].cells[1].text, "0.750, 0.500 to 1.00");
        assert_eq!(fits.rows[1].cells[1].class, CellClass::Absent);
    }

    #[test]
    fn on_a_gpu_the_wall_clock_counts() {
        let mut run = run();
        run.environment = RunEnvironment {
            device_type: "discrete-gpu".to_owned(),
            gpu_timestamps: true,
            ..RunEnvironment::default()
        };
        let blocks = blocks(&run);
        let Some(Block::Text(text)) = blocks.first() else {
            panic!("a sentence: {blocks:?}");
        };
        assert!(text.contains("takes 88.9 ms to read back"), "{text}");
        assert!(text.contains("Times are wall clock time."), "{text}");
        let metrics = [Clock::Gpu, Clock::ProcessCpu].map(metric);
        assert_eq!(metrics, [WALL, CPU]);
    }

    #[test]
    fn a_run_without_read_backs_has_no_chapter() {
        let mut run = MadeUpRun::default();
        run.case(case_id("filling", "a", &[]));
        assert_eq!(blocks(&run), []);
    }
}
