// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on reading back: time against bytes, one curve per graphics interface.

use crate::metrics::{API, BYTES, CPU, RATE, SIZE_PX, WALL};
use terrafill_lab::{
    Column, Drawing, Figure, Lines, Names, Panel, Section, SectionedChapter, slope_one,
};
use terrafill_results::Answers;

const TIME: Figure = Figure::ByClock(WALL, CPU);

/// What reading an image back costs.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: "Read-back: time against bytes",
    question: "How long does reading an image back take, and at which rate?",
    text: "Colour and depth are read back: through wgpu one after the other, through Vulkan both at once. Times include \
           new staging buffers and packing rows. On a GPU a read-back is a wait of the CPU outside of every GPU pass, so \
           wall clock is compared; on a software device the CPU itself copies, so process CPU time is. The rate is bytes \
           over wall clock.",
    terms: crate::metrics::TERMS,
    primary: TIME,
    answers: |cases| {
        let time = cases.clock().pick(WALL, CPU);
        let says = |side: &str| format!("{side} × {side} pixels take least through");
        Answers {
            blocks: Vec::from_iter(cases.least_of_each(SIZE_PX, (API, time), says)),
            ..Answers::default()
        }
    },
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
                up: ("ms", TIME),
                curve: Names::Joined(&[API]),
                knob: Figure::Metric(BYTES),
                lines: slope_one,
                ..Panel::EMPTY
            }],
        }),
        lines: Some(Lines {
            caption: "Line through all sizes, time = latency + bytes ÷ rate: range over processes. A latency below 0 means \
                      that small images come faster than any line allows.",
            by: ("interface", API),
            across: Figure::Metric(BYTES),
            up: TIME,
            start: "latency, ms",
            slope: ("rate, MB/s", |ms_per_byte| 1e-3 / ms_per_byte),
        }),
        ..Section::EMPTY
    }],
    claims: None,
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::METRICS;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Block, CellClass, Chapter as _, Clock, RunEnvironment, Status};

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
        CHAPTER.blocks(&run.loaded()).expect("a chapter")
    }

    #[test]
    fn times_stand_in_a_sentence_a_plot_and_tables() {
        let blocks = blocks(&run());
        let [
            Block::List(answer),
            Block::Text(_),
            Block::Plot(plot),
            Block::Table(table),
            Block::Table(fits),
        ] = &blocks[..]
        else {
            panic!("answers, a text, a plot and two tables: {blocks:?}");
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
            let Block::List(answer) = &blocks[0] else {
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
        let Some(Block::List(answer)) = blocks.first() else {
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
