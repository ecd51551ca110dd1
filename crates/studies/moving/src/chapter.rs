// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on regions that move: what a frame costs by technique, part by part.

use crate::metrics::*;
use terrafill_lab::{
    Best, Cases, Column, Comparison, Figure, Follows, Names, Section, SectionedChapter, finding,
    measured,
};
use terrafill_plot::number::{measured_bytes, significant};
use terrafill_results::{Answers, Block, Case, Claim, Finding, Metric, Scope};

/// Ways whose cost a frame is compared: the others show what they spare.
const WAYS: [&str; 2] = ["bend", "rewrite"];

/// The number of sensors that the limits below are for.
const SENSORS_OF_LIMITS: &str = "50";
/// Mesh and update of a frame, process CPU time: a tenth of a frame at 60 a second.
const MAX_MESH_AND_UPDATE_MS: f64 = 1.5;
/// Uploaded for a frame, bytes.
const MAX_UPLOAD_BYTES: f64 = 65_536.0;

/// Why there is no bound of what vertices are off.
const STORED: &str = "vertices are stored; rounding them is within a unit of their format";

/// What regions cost that change in every frame.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: "Moving regions: sensors that sweep",
    question: "What do regions cost that change in every frame, such as what sensors see?",
    text: "Sensors fly and sweep over the countries; each footprint has 256 vertices. In every frame all footprints are \
           brought up to date and filled. “bend” uploads discs once and per frame a few numbers a cone, by which the \
           vertex stage bends the discs in f32; the CPU finds the same vertices in f64 for the plan's boxes alone. \
           “rewrite” meshes strips on the CPU, whose vertices and triangles stay as many, so that they are written where \
           they lie; “reload” uploads the whole scene instead; “remesh” uses the general mesher, whose numbers of vertices \
           change. Every frame is compared with the reference of that frame.",
    terms: crate::metrics::TERMS,
    primary: Figure::ByClock(FRAME_WALL, FRAME_CPU),
    answers,
    sections: &[Section {
        title: "Frames by number of sensors",
        named_by: Names::Columns(&[
            ("technique", TECHNIQUE),
            ("variant", VARIANT),
            ("way", UPKEEP),
        ]),
        columns: &[
            Column::clocked("frame, ms", FRAME_WALL, FRAME_CPU),
            Column::metric("mesh, ms", MESH),
            Column::metric("plan, ms", PLAN),
            Column::metric("update, ms", UPDATE),
            Column::metric("fill, CPU ms", FILL_CPU),
            Column::metric("fill, GPU ms", FILL_GPU)
                .or("no GPU clock, or passes that alternate region by region"),
            Column::metric("upload", BYTES),
            Column::metric("frames compared", COMPARED),
            Column::metric("wrong", WRONG),
            Column::metric("px outside band", OUTSIDE),
            Column::metric("bound, m", BOUND_M).or(STORED),
            Column::metric("bound, px", BOUND_PX).or(STORED),
        ],
        per: Some(SENSORS),
        is_main: true,
        findings: &[
            |cases| {
                less_by_geometry_shaders(cases, "upload", (BYTES, Scope::NOTHING), measured_bytes)
            },
            |cases| {
                let what = "CPU time of mesh and update";
                let needs = Scope::PLAN.and(Scope::UPLOAD);
                less_by_geometry_shaders(cases, what, (MESH_AND_UPDATE, needs), text_ms)
            },
        ],
        // One of all techniques that draw the same.
        pictures: &[("image", "the last frame compared")],
        ..Section::EMPTY
    }],
    claims: None,
};

fn answers(cases: &Cases<'_>) -> Answers {
    let [compared, wrong] = [COMPARED, WRONG].map(|metric| cases.sum(metric));
    let scope = compared.zip(wrong).map(|(compared, wrong)| {
        format!(
            "{compared} frames of moving regions were compared, each with the reference of that frame; {wrong} are wrong."
        )
    });
    let sweeps = cases.by(SENSORS);
    let said = sweeps
        .iter()
        .filter_map(|(sensors, own)| answer(sensors, own));
    Answers {
        scope: scope.into_iter().collect(),
        blocks: said.map(Block::Text).collect(),
        requirements: requirements(cases),
    }
}

fn name(case: &Case) -> String {
    format!("{} {}", case.condition(TECHNIQUE), case.condition(VARIANT))
}

fn text_ms(ms: f64) -> String {
    format!("{} ms", significant(ms))
}

fn counted(case: &Case, metric: &Metric) -> Option<f64> {
    measured(case, metric).filter(|_| case.counts())
}

/// Cases of [`WAYS`].
fn competing<'a>(cases: &Cases<'a>) -> Cases<'a> {
    cases.fitting(|case| WAYS.contains(&case.condition(UPKEEP)))
}

/// The fastest, those that tie with it, and what the other ways cost beside it.
fn answer(sensors: &str, cases: &Cases<'_>) -> Option<String> {
    let time = cases.clock().pick(FRAME_WALL, FRAME_CPU);
    let best = competing(cases).best(time)?;
    let Best { case, value, .. } = best;
    let ways = ["bend", "rewrite", "reload", "remesh"].into_iter();
    let ways = ways.filter(|way| *way != case.condition(UPKEEP));
    let others = ways.filter_map(|way| {
        // Of the same technique, where that way was measured; its fastest layout.
        let same = [(UPKEEP, way), (TECHNIQUE, case.condition(TECHNIQUE))];
        let (_, ms) = cases.with(&same).least_of(|case| counted(case, time))?;
        Some(format!("; by {way} {} ms", significant(ms)))
    });
    let part = |metric| counted(case, metric).map_or_else(|| "–".to_owned(), significant);
    Some(format!(
        "{sensors} sensors over {}: a frame takes least with {} by {}{}: {} ms of {} (mesh {}, plan {}, update {}, fill \
         {}){}. It uploads {} a frame.",
        case.condition(SCENE),
        name(case),
        case.condition(UPKEEP),
        best.tied_with(|case| format!("{} by {}", name(case), case.condition(UPKEEP))),
        significant(value),
        cases.clock().pick("wall clock", "process CPU time"),
        part(MESH),
        part(PLAN),
        part(UPDATE),
        part(FILL_CPU),
        others.collect::<String>(),
        counted(case, BYTES).map_or_else(|| "–".to_owned(), measured_bytes),
    ))
}

/// Limits of the frame with [`SENSORS_OF_LIMITS`] sensors, and no wrong frame anywhere.
fn requirements(cases: &Cases<'_>) -> Vec<Finding> {
    let of_limits = competing(&cases.with(&[(SENSORS, SENSORS_OF_LIMITS)]));
    let limit = |what: String, metric: &Metric, most: f64, write: fn(f64) -> String| {
        let least = of_limits.least_of(|case| counted(case, metric));
        finding(
            format!("{SENSORS_OF_LIMITS} moving footprints are {what} by the best technique:"),
            least.map(|(_, value)| value <= most),
            least.map_or_else(String::new, |(case, value)| {
                format!("{} takes {}", name(case), write(value))
            }),
        )
    };
    let frames = cases.sum(WRONG).zip(cases.sum(COMPARED));
    vec![
        finding(
            "every frame of moving regions is right:",
            frames.map(|(wrong, _)| wrong == 0.0),
            frames.map_or_else(String::new, |(wrong, all)| {
                format!("{wrong} of {all} frames are wrong")
            }),
        ),
        limit(
            format!(
                "meshed and updated in at most {MAX_MESH_AND_UPDATE_MS} ms of process CPU time"
            ),
            MESH_AND_UPDATE,
            MAX_MESH_AND_UPDATE_MS,
            text_ms,
        ),
        limit(
            format!(
                "uploaded with at most {} a frame",
                measured_bytes(MAX_UPLOAD_BYTES)
            ),
            BYTES,
            MAX_UPLOAD_BYTES,
            measured_bytes,
        ),
    ]
}

/// The best vertex shader and the best geometry shader of the largest number of sensors, both rewriting.
fn rivals<'a>(cases: &Cases<'a>, metric: &Metric) -> Option<[(&'a Case, f64); 2]> {
    let sensors = cases.distinct(SENSORS).into_iter();
    let most = sensors.max_by_key(|count| count.parse::<u32>().unwrap_or(0))?;
    let own = cases.with(&[(SENSORS, most), (UPKEEP, "rewrite")]);
    let by = |technique| own.with(&[(TECHNIQUE, technique)]);
    let shaders = by("native").fitting(|case| !case.condition(VARIANT).starts_with("vs-"));
    let least = |cases: Cases<'a>| cases.least_of(|case| counted(case, metric));
    Some([least(by("vertex"))?, least(shaders)?])
}

/// What the 2007 paper expects of geometry shaders where regions change.
fn less_by_geometry_shaders(
    cases: &Cases<'_>,
    what: &str,
    (metric, needs): (&'static Metric, Scope),
    write: fn(f64) -> String,
) -> Finding {
    let claim = format!(
        "where regions change, extruding in a geometry shader takes less {what} than volumes copied for the vertex shader \
         (Cozzi 2007, abstract: it “reduces preprocessing, main memory, and CPU-GPU bandwidth”):"
    );
    let comparison = Comparison {
        changed: TECHNIQUE.name(),
        follows: &[Follows {
            key: VARIANT.name(),
            because: "each technique has layouts of its own, of which the best is compared",
        }],
        one_sided: None,
        metric,
        needs,
    };
    let rivals = rivals(cases, metric);
    let pairs = rivals.map(|rivals| rivals.map(|(case, _)| case));
    let found = cases.compared(&comparison, pairs.as_slice(), Claim::Faster, claim);
    let figures = rivals.map(|rivals| {
        let [copied, shader] =
            rivals.map(|(case, value)| format!("{} {}", name(case), write(value)));
        let sensors = rivals[0].0.condition(SENSORS);
        format!("{sensors} sensors: {shader}, {copied}; {}", found.because)
    });
    Finding {
        because: figures.unwrap_or_default(),
        ..found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Chapter as _, Run, Standing, Status};

    fn add(run: &mut MadeUpRun, technique: &str, upkeep: &str, update_ms: f64, upload: f64) {
        let conditions = [
            ("scene", "planet-134"),
            ("sensors", "50"),
            ("technique", technique),
            ("variant", "plain"),
            ("upkeep", upkeep),
        ];
        run.metrics = METRICS.to_vec();
        let name = format!("planet-134/50/{technique}/plain/{upkeep}");
        let case = run.case(case_id(crate::STUDY, &name, &conditions));
        case.figure(BYTES, upload);
        case.figure(COMPARED, 60.0);
        case.figure(WRONG, 0.0);
        for (metric, ms) in [
            (MESH, 1.0),
            (PLAN, 0.5),
            (UPDATE, update_ms),
            (MESH_AND_UPDATE, 1.0 + update_ms),
            (FILL_CPU, 10.0),
            (FRAME_CPU, 11.5 + update_ms),
            (FRAME_WALL, 6.0 + update_ms),
        ] {
            case.timed(metric, &[ms; 5]);
        }
    }

    /// Of the section: those on geometry shaders.
    fn findings(run: &Run) -> Vec<Finding> {
        let cases = Cases::of_study(run, crate::STUDY);
        let of_section = CHAPTER.sections[0].findings.iter();
        of_section.map(|of| of(&cases)).collect()
    }

    fn standings(findings: &[Finding]) -> Vec<Standing> {
        findings.iter().map(|finding| finding.standing).collect()
    }

    #[test]
    fn limits_hold_or_do_not_by_the_best_technique() {
        let mut made_up = MadeUpRun::default();
        add(&mut made_up, "vertex", "rewrite", 0.9, 200_000.0);
        add(&mut made_up, "native", "rewrite", 0.4, 60_000.0);
        add(&mut made_up, "native", "reload", 0.1, 50.0);
        let run = made_up.loaded();
        let answers = CHAPTER.answers(&run).expect("answers");
        use Standing::{DoesNotHold, Holds, NotMeasured};
        assert_eq!(standings(&answers.requirements), [Holds; 3]);
        assert!(
            answers.scope[0].contains("180 frames"),
            "{:?}",
            answers.scope
        );
        assert_eq!(standings(&findings(&run)), [Holds; 2]);
        // Another way that counts takes less.
        add(&mut made_up, "vertex", "bend", 0.1, 6_000.0);
        let run = made_up.loaded();
        let answers = CHAPTER.answers(&run).expect("answers");
        let because = &answers.requirements[2].because;
        assert!(because.starts_with("vertex plain"), "{because}");
        // Negative control: slower, larger, and one frame wrong; geometry shaders are no better.
        let mut made_up = MadeUpRun::default();
        add(&mut made_up, "vertex", "rewrite", 0.9, 200_000.0);
        add(&mut made_up, "native", "rewrite", 1.4, 300_000.0);
        let wrong = made_up.case(case_id(crate::STUDY, "other", &[("sensors", "1")]));
        wrong.ended(Status::Wrong, "1 of 60 frames");
        wrong.figure(COMPARED, 60.0);
        wrong.figure(WRONG, 1.0);
        let run = made_up.loaded();
        let answers = CHAPTER.answers(&run).expect("answers");
        assert_eq!(standings(&answers.requirements), [DoesNotHold; 3]);
        assert_eq!(standings(&findings(&run)), [DoesNotHold; 2]);
        // Nothing of it: no verdict.
        let run = MadeUpRun::default().loaded();
        let answers = CHAPTER.answers(&run).expect("answers");
        assert_eq!(standings(&answers.requirements), [NotMeasured; 3]);
        assert!(CHAPTER.blocks(&run).expect("a chapter").is_empty());
    }

    #[test]
    fn a_difference_within_the_noise_decides_nothing() {
        let standing = |copied_ms: f64| {
            let mut made_up = MadeUpRun::default();
            add(&mut made_up, "vertex", "rewrite", copied_ms, 200_000.0);
            add(&mut made_up, "native", "rewrite", 1.0, 60_000.0);
            // Identical work takes 10 % longer.
            let id = made_up.cases[1].id.repeat();
            made_up.case(id).timed(MESH_AND_UPDATE, &[2.2; 5]);
            findings(&made_up.loaded())[1].clone()
        };
        let none = standing(1.1);
        assert_eq!(none.standing, Standing::NoDifference);
        let figures = "50 sensors: native plain 2.00 ms, vertex plain 2.10 ms; 1.05 ×";
        assert!(none.because.starts_with(figures), "{none:?}");
        // Controls: beyond it, either way.
        assert_eq!(standing(1.5).standing, Standing::Holds);
        assert_eq!(standing(0.5).standing, Standing::DoesNotHold);
    }

    #[test]
    fn the_answer_names_the_fastest_and_the_other_ways() {
        let mut made_up = MadeUpRun::default();
        add(&mut made_up, "vertex", "rewrite", 0.9, 200_000.0);
        add(&mut made_up, "native", "rewrite", 0.4, 60_000.0);
        add(&mut made_up, "native", "reload", 3.0, 900_000.0);
        let run = made_up.loaded();
        let blocks = CHAPTER.blocks(&run).expect("a chapter");
        let Some(Block::Text(text)) = blocks.first() else {
            panic!("an answer: {blocks:?}");
        };
        // The other one differs by less than two that are alike may.
        let best = "least with native plain by rewrite, tied with vertex plain by rewrite: 11.9 ms";
        assert!(text.contains(best), "{text}");
        assert!(text.contains("; by reload 14.5 ms"), "{text}");
        assert!(!text.contains("; by rewrite"), "{text}");
        let table = blocks.iter().find_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        });
        assert_eq!(table.expect("a table").rows.len(), 3);
        // Negative control: one that is slower by more ties with none.
        add(&mut made_up, "vertex", "bend", 5.0, 6_000.0);
        made_up.cases.remove(0);
        let answers = CHAPTER.answers(&made_up.loaded()).expect("answers");
        let Some(Block::Text(text)) = answers.blocks.first() else {
            panic!("an answer: {answers:?}");
        };
        assert!(
            text.contains("least with native plain by rewrite: 11.9 ms"),
            "{text}"
        );
    }
}
