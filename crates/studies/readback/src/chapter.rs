// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on reading back: time against bytes, one curve per graphics interface.
//!
//! Time is modelled as latency + bytes ÷ rate. The line is fitted by least squares of the relative
//! residuals, since noise grows with time; by absolute ones the largest image alone would set both.
//! Every process has a line of its own, and the range over processes is the fit's spread.

use crate::keys::{API, SIZE_PX};
use crate::metrics::METRICS;
use terrafill_lab::{
    Cases, Column, Drawing, Figure, Names, Panel, Section, SectionedChapter, range, slope_one,
};
use terrafill_plot::number::significant;
use terrafill_results::{
    Answers, Block, Cell, ChapterError, Heading, Metric, Row, Table, process_medians,
};

const CPU: &Metric = Metric::of(&METRICS, "readback_cpu_ms");
const WALL: &Metric = Metric::of(&METRICS, "readback_wall_ms");
const BYTES: &Metric = Metric::of(&METRICS, "readback_bytes");
const RATE: &Metric = Metric::of(&METRICS, "readback_rate");

/// A line through two sizes has no residual that could speak against it.
const MIN_SIZES_FOR_FIT: usize = 3;

/// What reading an image back costs.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: "Read-back: time against bytes",
    text: "Colour and depth are read back: through wgpu one after the other, through Vulkan both at once. Times include \
           new staging buffers and packing rows. On a GPU a read-back is a wait of the CPU outside of every GPU pass, so \
           wall clock is compared; on a software device the CPU itself copies, so process CPU time is. The rate is bytes \
           over wall clock.",
    primary: Figure::ByClock(WALL, CPU),
    answers,
    sections: &[Section {
        named_by: Names::Columns(&[("interface", API), ("pixels a side", SIZE_PX)]),
        columns: &[
            Column::metric("bytes", BYTES),
            Column::metric("CPU, ms", CPU),
            Column::metric("wall, ms", WALL),
            Column::metric("rate, MB/s", RATE),
        ],
        is_main: true,
        drawing: Some(Drawing {
            caption: "Time of reading colour and depth back; whiskers: 5–95 % of the reads. Along the dashed line time \
                      grows as the bytes do. A curve is flat where latency rules.",
            panels: &[Panel {
                title: "Time to read back against bytes",
                across: ("bytes of colour and depth", Figure::Metric(BYTES)),
                up: ("ms", Figure::ByClock(WALL, CPU)),
                curve: Names::Joined(&[API]),
                knob: Figure::Metric(BYTES),
                lines: slope_one,
                ..Panel::EMPTY
            }],
        }),
        more: &[fits],
        ..Section::EMPTY
    }],
};

/// Through which interface each size takes least.
fn answers(cases: &Cases<'_>) -> Answers {
    let time = cases.clock().pick(WALL, CPU);
    let said = |(side, own): &(&str, Cases<'_>)| {
        let best = own.best(time)?;
        let (api, ms) = (best.case.condition(API), significant(best.value));
        let ties = best.tied_with(|case| case.condition(API).to_owned());
        Some(format!(
            "{side} × {side} pixels take least through {api}, {ms} ms{ties}."
        ))
    };
    let sizes: Vec<String> = cases.by(SIZE_PX).iter().filter_map(said).collect();
    Answers {
        blocks: Vec::from_iter((!sizes.is_empty()).then_some(Block::List(sizes))),
        ..Answers::default()
    }
}

/// Latency and rate of each interface over its sizes: a line through all, for each process.
fn fits(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let time = cases.clock().pick(WALL, CPU);
    let rows = cases.by(API).into_iter().map(|(api, own)| {
        let sizes = own.iter().filter(|case| case.counts());
        let sizes =
            sizes.filter_map(|case| Some((case.value(BYTES)?, process_medians(case, time))));
        let sizes: Vec<_> = sizes.collect();
        let processes = sizes
            .first()
            .into_iter()
            .flat_map(|(_, times)| times.keys());
        let lines = processes.filter_map(|process| {
            let points = sizes
                .iter()
                .filter_map(|(bytes, times)| Some([*bytes, *times.get(process)?]));
            fit(&points.collect::<Vec<_>>())
        });
        let lines: Vec<[f64; 2]> = lines.collect();
        let cell = |end: usize| {
            let values: Vec<f64> = lines.iter().map(|line| line[end]).collect();
            let why = format!("fewer than {MIN_SIZES_FOR_FIT} sizes, or no rising times");
            Cell::or_absent(range(&values), why)
        };
        Row::new(vec![Cell::name(api), cell(0), cell(1)])
    });
    Ok(Some(Block::Table(Table {
        caption: "Line through all sizes, time = latency + bytes ÷ rate: range over processes. A latency below 0 means \
                  that small images come faster than any line allows."
            .to_owned(),
        headings: ["interface", "latency, ms", "rate, MB/s"].map(Heading::plain).into(),
        rows: rows.collect(),
        ..Table::default()
    })))
}

/// Latency, ms, and rate, MB/s, by weighted regression of milliseconds on bytes, weights 1 / time²; `None` with too few
/// points or where time does not rise.
fn fit(points: &[[f64; 2]]) -> Option<[f64; 2]> {
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
    let latency_ms = middle[1] - ms_per_byte * middle[0];
    (ms_per_byte > 0.0).then_some([latency_ms, 1e-3 / ms_per_byte])
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{CellClass, Chapter as _, Clock, RunEnvironment, Status};

    /// 0.5 ms, and 1,000 MB/s; process 1 is twice as slow.
    fn run() -> MadeUpRun {
        let mut run = MadeUpRun {
            metrics: METRICS.to_vec(),
            ..MadeUpRun::default()
        };
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
        CHAPTER.blocks(&run).expect("a chapter")
    }

    #[test]
    fn a_line_is_found_and_two_points_are_none() {
        let line = [[1e5, 0.6], [1e6, 1.5], [1e7, 10.5], [1e8, 100.5]];
        let [latency_ms, rate] = fit(&line).expect("a line");
        assert!((latency_ms - 0.5).abs() < 1e-9, "{latency_ms}");
        assert!((rate - 1000.0).abs() < 1e-6, "{rate}");
        assert_eq!(fit(&line[..2]), None);
        // Twin: times that fall with size are no rate.
        assert_eq!(fit(&line.map(|[x, y]| [x, 1.0 / y])), None);
    }

    #[test]
    fn times_stand_in_a_sentence_a_plot_and_tables() {
        let blocks = blocks(&run());
        let [
            Block::Text(_),
            Block::List(answer),
            Block::Plot(plot),
            Block::Table(table),
            Block::Table(fits),
        ] = &blocks[..]
        else {
            panic!("a text, answers, a plot and two tables: {blocks:?}");
        };
        assert_eq!(
            answer[2],
            "1024 × 1024 pixels take least through wgpu, 13.3 ms."
        );
        assert!(plot.svg.contains("slope 1") && plot.svg.contains("process CPU"));
        let cells = |row: usize| table.rows[row].cells.iter();
        let texts = |row| {
            cells(row)
                .map(|cell| cell.text.as_str())
                .collect::<Vec<_>>()
        };
        assert_eq!(texts(2), ["wgpu", "1024", "8.39 MB", "13.3", "88.9", "100"]);
        assert!(cells(3).skip(2).all(|cell| cell.class == CellClass::Absent));
        assert_eq!(table.rows[3].remark, "no such device");
        assert_eq!(fits.rows[0].cells[1].text, "0.500 to 1.00");
        assert_eq!(fits.rows[1].cells[1].class, CellClass::Absent);
    }

    #[test]
    fn interfaces_within_the_noise_tie_and_others_do_not() {
        let answer = |vulkan_ms: f64| {
            let mut run = run();
            for case in &mut run.cases {
                case.timed(CPU, &[1.0; 5]);
            }
            let vulkan = run.cases.last_mut().expect("planned");
            vulkan.ended(Status::Ok, "").timed(CPU, &[vulkan_ms; 5]);
            let blocks = blocks(&run);
            let Block::List(answer) = &blocks[1] else {
                panic!("an answer: {blocks:?}");
            };
            answer[0].clone()
        };
        assert!(
            answer(1.01).contains("through wgpu, 1.00 ms, tied with vulkan."),
            "{}",
            answer(1.01)
        );
        assert!(
            answer(2.0).contains("through wgpu, 1.00 ms."),
            "{}",
            answer(2.0)
        );
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
        let Some(Block::List(answer)) = blocks.get(1) else {
            panic!("an answer: {blocks:?}");
        };
        let answer = &answer[2];
        assert!(
            answer.contains("take least through wgpu, 88.9 ms"),
            "{answer}"
        );
        let metrics = [Clock::Gpu, Clock::ProcessCpu].map(|clock| CHAPTER.primary_metric(clock));
        assert_eq!(metrics, [Some(WALL.name), Some(CPU.name)]);
    }

    #[test]
    fn a_run_without_read_backs_has_no_chapter() {
        let mut run = MadeUpRun::default();
        run.case(case_id("filling", "a", &[]));
        assert_eq!(blocks(&run), []);
    }
}
