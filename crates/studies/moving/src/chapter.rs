// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on regions that move: what a frame costs by technique, part by part.

use crate::keys::{SCENE, SENSORS, TECHNIQUE, UPKEEP, VARIANT};
use crate::metrics::METRICS;
use terrafill_plot::dotted;
use terrafill_plot::number::{measured_bytes, significant};
use terrafill_results::{
    Answers, Block, Case, Cell, CellClass, Chapter, ChapterError, Clock, Estimate, Finding,
    Heading, Metric, Noise, Picture, PictureFigure, Pictures, Row, Run, Standing, Table,
    over_processes, process_medians,
};

const MESH: &Metric = Metric::of(&METRICS, "moving_mesh_cpu_ms");
const PLAN: &Metric = Metric::of(&METRICS, "moving_plan_cpu_ms");
const UPDATE: &Metric = Metric::of(&METRICS, "moving_update_cpu_ms");
const FILL_CPU: &Metric = Metric::of(&METRICS, "moving_fill_cpu_ms");
const FILL_GPU: &Metric = Metric::of(&METRICS, "moving_fill_gpu_ms");
const FRAME_CPU: &Metric = Metric::of(&METRICS, "moving_frame_cpu_ms");
const FRAME_WALL: &Metric = Metric::of(&METRICS, "moving_frame_wall_ms");
const BYTES: &Metric = Metric::of(&METRICS, "moving_upload_bytes");
const COMPARED: &Metric = Metric::of(&METRICS, "moving_frames_compared");
const WRONG: &Metric = Metric::of(&METRICS, "moving_frames_wrong");
const OUTSIDE: &Metric = Metric::of(&METRICS, "moving_outside_px");
const BOUND_M: &Metric = Metric::of(&METRICS, "moving_bound_m");
const BOUND_PX: &Metric = Metric::of(&METRICS, "moving_bound_px");

/// Ways whose cost a frame is compared: the others show what they spare.
const WAYS: [&str; 2] = ["bend", "rewrite"];

/// The number of sensors that the limits below are for.
const SENSORS_OF_LIMITS: &str = "50";
/// Mesh and update of a frame, process CPU time: a tenth of a frame at 60 a second.
const MAX_MESH_AND_UPDATE_MS: f64 = 1.5;
/// Uploaded for a frame, bytes.
const MAX_UPLOAD_BYTES: f64 = 65_536.0;

/// What is measured, and how the three ways differ.
const WHAT_IS_COMPARED: &str = "Sensors fly and sweep over the countries; each footprint has 256 vertices. In every frame all \
     footprints are brought up to date and filled. “bend” uploads discs once and per frame a few \
     numbers a cone, by which the vertex stage bends the discs in f32; the CPU finds the same vertices \
     in f64 for the plan's boxes alone. “rewrite” meshes strips on the CPU, whose vertices and triangles \
     stay as many, so that they are written where they lie; “reload” uploads the whole scene instead; \
     “remesh” uses the general mesher, whose numbers of vertices change. Every frame is compared with \
     the reference of that frame.";

/// What regions cost that change in every frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct MovingChapter;

impl Chapter for MovingChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Moving regions: sensors that sweep"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(primary(clock).name)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let sweeps = sweeps(run);
        let frames = |metric| -> f64 {
            let values = cases(run).filter_map(|case| case.value(metric));
            values.sum()
        };
        let compared = frames(COMPARED);
        let scope = (compared > 0.0).then(|| {
            format!(
                "{compared} frames of moving regions were compared, each with the reference of that \
                 frame; {} are wrong.",
                frames(WRONG)
            )
        });
        Ok(Answers {
            scope: scope.into_iter().collect(),
            blocks: sweeps
                .iter()
                .filter_map(|sweep| answer(sweep, run.clock()))
                .map(Block::Text)
                .collect(),
            requirements: requirements(&sweeps),
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let (sweeps, clock) = (sweeps(run), run.clock());
        if sweeps.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = vec![Block::Text(WHAT_IS_COMPARED.to_owned())];
        for sweep in &sweeps {
            blocks.extend(answer(sweep, clock).map(Block::Text));
            blocks.push(Block::Table(table(sweep, clock)));
            blocks.extend(pictures(sweep).map(Block::Pictures));
        }
        blocks.push(Block::section("Findings"));
        let noise = mesh_and_update_noise(run);
        blocks.extend(findings(&sweeps, noise).into_iter().map(Block::Finding));
        Ok(blocks)
    }
}

/// All cases of one number of sensors over one scene.
struct Sweep<'a> {
    scene: &'a str,
    sensors: &'a str,
    cases: Vec<&'a Case>,
}

fn primary(clock: Clock) -> &'static Metric {
    clock.pick(FRAME_WALL, FRAME_CPU)
}

fn cases(run: &Run) -> impl Iterator<Item = &Case> {
    run.of_study(crate::STUDY).filter(|case| !case.is_twin())
}

/// In the order in which they first appear.
fn sweeps(run: &Run) -> Vec<Sweep<'_>> {
    let mut sweeps: Vec<Sweep<'_>> = Vec::new();
    for case in cases(run) {
        let key = (case.condition(SCENE), case.condition(SENSORS));
        let mut known = sweeps.iter_mut();
        match known.find(|sweep| (sweep.scene, sweep.sensors) == key) {
            Some(sweep) => sweep.cases.push(case),
            None => sweeps.push(Sweep {
                scene: key.0,
                sensors: key.1,
                cases: vec![case],
            }),
        }
    }
    sweeps
}

fn value(case: &Case, metric: &Metric) -> Option<f64> {
    case.value(metric).filter(|_| case.counts())
}

fn name(case: &Case) -> String {
    format!("{} {}", case.condition(TECHNIQUE), case.condition(VARIANT))
}

impl<'a> Sweep<'a> {
    /// Cases that count, by this way of keeping up to date, with a value of theirs.
    fn by(&self, upkeep: &'static str, of: impl Fn(&Case) -> Option<f64>) -> Vec<(&'a Case, f64)> {
        let cases = self.cases.iter().copied();
        let cases = cases.filter(|case| case.condition(UPKEEP) == upkeep);
        cases.filter_map(|case| Some((case, of(case)?))).collect()
    }

    fn least(
        &self,
        upkeeps: &[&'static str],
        of: impl Fn(&Case) -> Option<f64>,
    ) -> Option<(&'a Case, f64)> {
        let cases = upkeeps.iter().flat_map(|upkeep| self.by(upkeep, &of));
        cases.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

fn mesh_and_update_ms(case: &Case) -> Option<f64> {
    Some(value(case, MESH)? + value(case, UPDATE)?)
}

/// The same of two cases, one over the other, by process.
fn mesh_and_update_ratio(case: &Case, other: &Case) -> Option<Estimate> {
    let of = |case| [MESH, UPDATE].map(|metric| process_medians(case, metric));
    let ([mesh, update], [other_mesh, other_update]) = (of(case), of(other));
    let ratios = mesh.iter().filter_map(|(process, mesh)| {
        let other = other_mesh.get(process)? + other_update.get(process)?;
        Some((mesh + update.get(process)?) / other)
    });
    over_processes(&ratios.collect::<Vec<f64>>())
}

/// By how much either part of identical work differed, the larger one.
fn mesh_and_update_noise(run: &Run) -> Option<Noise> {
    let own: Vec<&Case> = run.of_study(crate::STUDY).collect();
    let of = |metric| Noise::of(own.iter().copied(), metric);
    let noises = [MESH, UPDATE].into_iter().filter_map(of);
    noises.max_by(|a, b| a.max.total_cmp(&b.max))
}

/// The fastest, and what the other ways cost beside it.
fn answer(sweep: &Sweep<'_>, clock: Clock) -> Option<String> {
    let frame = |case: &Case| value(case, primary(clock));
    let (best, ms) = sweep.least(&WAYS, frame)?;
    let part = |metric| value(best, metric).map_or_else(|| "–".to_owned(), significant);
    let ways = ["bend", "rewrite", "reload", "remesh"].into_iter();
    let ways = ways.filter(|way| *way != best.condition(UPKEEP));
    let others = ways.filter_map(|way| {
        // Of the same technique, where that way was measured; its fastest layout.
        let cases = sweep.by(way, frame).into_iter();
        let same = cases.filter(|(case, _)| case.condition(TECHNIQUE) == best.condition(TECHNIQUE));
        let other = same.min_by(|a, b| a.1.total_cmp(&b.1));
        other.map(|(_, other)| format!("by {way} {} ms", significant(other)))
    });
    let others: Vec<String> = others.collect();
    let others = match others.is_empty() {
        true => String::new(),
        false => format!("; {}", others.join(", ")),
    };
    Some(format!(
        "{} sensors over {}: a frame takes least with {}, {} ms of {} (mesh {}, plan {}, update {}, \
         fill {}){others}. It uploads {} a frame.",
        sweep.sensors,
        sweep.scene,
        name(best),
        significant(ms),
        clock.pick("wall clock", "process CPU time"),
        part(MESH),
        part(PLAN),
        part(UPDATE),
        part(FILL_CPU),
        value(best, BYTES).map_or_else(|| "–".to_owned(), measured_bytes),
    ))
}

/// A row for each case, those that were not measured too.
fn table(sweep: &Sweep<'_>, clock: Clock) -> Table {
    let rows = sweep.cases.iter().map(|case| {
        let why = match case.reason.as_str() {
            "" => "not measured",
            reason => reason,
        };
        let timed = |metric, why| {
            let time = Cell::or_absent(value(case, metric).map(significant), why);
            dotted(time, case, metric)
        };
        let cell = |metric| timed(metric, why);
        let plain = |metric| {
            let count = case.value(metric).map(|count| count.to_string());
            Cell::or_absent(count, why)
        };
        let stored = "vertices are stored; rounding them is within a unit of their format";
        let bound = |metric| {
            let bound = case.value(metric).map(significant);
            Cell::or_absent(bound, stored)
        };
        let wrong = match case.value(WRONG) {
            Some(count) if count > 0.0 => Cell {
                class: CellClass::Bad,
                ..plain(WRONG)
            },
            _ => plain(WRONG),
        };
        let no_gpu_clock = "no GPU clock, or passes that alternate region by region";
        Row {
            cells: vec![
                Cell::name(name(case)),
                Cell::plain(case.condition(UPKEEP)),
                cell(primary(clock)),
                cell(MESH),
                cell(PLAN),
                cell(UPDATE),
                cell(FILL_CPU),
                timed(FILL_GPU, no_gpu_clock),
                Cell::or_absent(case.value(BYTES).map(measured_bytes), why),
                plain(COMPARED),
                wrong,
                plain(OUTSIDE),
                bound(BOUND_M),
                bound(BOUND_PX),
            ],
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    });
    Table {
        caption: format!("{} sensors over {}", sweep.sensors, sweep.scene),
        headings: vec![
            Heading::plain("technique"),
            Heading::explained("way", "how the scene is brought up to date"),
            Heading::metric("frame, ms", primary(clock)),
            Heading::metric("mesh, ms", MESH),
            Heading::metric("plan, ms", PLAN),
            Heading::metric("update, ms", UPDATE),
            Heading::metric("fill, CPU ms", FILL_CPU),
            Heading::metric("fill, GPU ms", FILL_GPU),
            Heading::metric("upload", BYTES),
            Heading::metric("frames compared", COMPARED),
            Heading::metric("wrong", WRONG),
            Heading::metric("px outside band", OUTSIDE),
            Heading::metric("bound, m", BOUND_M),
            Heading::metric("bound, px", BOUND_PX),
        ],
        rows: rows.collect(),
        is_main: true,
        ..Table::default()
    }
}

/// One of all techniques that draw the same.
fn pictures(sweep: &Sweep<'_>) -> Option<Pictures> {
    let figures: Vec<PictureFigure> = sweep
        .cases
        .iter()
        .filter_map(|case| {
            let path = case.note("image");
            (!path.is_empty()).then(|| PictureFigure {
                pictures: vec![Picture {
                    path: path.to_owned(),
                    caption: "the last frame compared".to_owned(),
                }],
                notes: vec![name(case)],
            })
        })
        .collect();
    (!figures.is_empty()).then(|| Pictures {
        caption: format!("{} sensors over {}", sweep.sensors, sweep.scene),
        figures,
        ..Pictures::default()
    })
}

/// Limits of the frame with [`SENSORS_OF_LIMITS`] sensors, and no wrong frame anywhere.
fn requirements(sweeps: &[Sweep<'_>]) -> Vec<Finding> {
    let of_limits = sweeps
        .iter()
        .find(|sweep| sweep.sensors == SENSORS_OF_LIMITS);
    let limit = |claim: String, found: Option<(String, bool)>| {
        let (because, standing) = match found {
            Some((because, holds)) => (because, Standing::holds_if(holds)),
            None => (String::new(), Standing::NotMeasured),
        };
        Finding {
            claim,
            standing,
            because,
        }
    };
    let time = of_limits.and_then(|sweep| sweep.least(&WAYS, mesh_and_update_ms));
    let upload = of_limits.and_then(|sweep| sweep.least(&WAYS, |case| value(case, BYTES)));
    let all = || sweeps.iter().flat_map(|sweep| &sweep.cases);
    let compared: f64 = all().filter_map(|case| case.value(COMPARED)).sum();
    let wrong: f64 = all().filter_map(|case| case.value(WRONG)).sum();
    vec![
        limit(
            "every frame of moving regions is right".to_owned(),
            (compared > 0.0).then(|| {
                let because = format!("{wrong} of {compared} frames are wrong");
                (because, wrong == 0.0)
            }),
        ),
        limit(
            format!(
                "{SENSORS_OF_LIMITS} moving footprints are meshed and updated in at most \
                 {MAX_MESH_AND_UPDATE_MS} ms of process CPU time by the best technique"
            ),
            time.map(|(case, ms)| {
                let because = format!("{} takes {} ms", name(case), significant(ms));
                (because, ms <= MAX_MESH_AND_UPDATE_MS)
            }),
        ),
        limit(
            format!(
                "{SENSORS_OF_LIMITS} moving footprints are uploaded with at most {} a frame by the \
                 best technique",
                measured_bytes(MAX_UPLOAD_BYTES)
            ),
            upload.map(|(case, count)| {
                let because = format!("{} uploads {}", name(case), measured_bytes(count));
                (because, count <= MAX_UPLOAD_BYTES)
            }),
        ),
    ]
}

/// What two cases with a figure each say of a claim, and why they do not decide it.
type Judge<'j> = &'j dyn Fn((&Case, f64), (&Case, f64)) -> (Standing, String);

/// What the 2007 paper expects of geometry shaders where regions change.
fn findings(sweeps: &[Sweep<'_>], noise: Option<Noise>) -> Vec<Finding> {
    let most = sweeps
        .iter()
        .max_by_key(|sweep| sweep.sensors.parse::<u32>().unwrap_or(0));
    let Some(sweep) = most else {
        return Vec::new();
    };
    let is_native = |case: &Case| {
        case.condition(TECHNIQUE) == "native" && !case.condition(VARIANT).starts_with("vs-")
    };
    let compare = |what: &str,
                   of: &dyn Fn(&Case) -> Option<f64>,
                   write: fn(f64) -> String,
                   judge: Judge<'_>| {
        let shader = sweep.least(&["rewrite"], |case| of(case).filter(|_| is_native(case)));
        let copied = sweep.least(&["rewrite"], |case| {
            of(case).filter(|_| case.condition(TECHNIQUE) == "vertex")
        });
        let claim = format!(
            "where regions change, extruding in a geometry shader takes less {what} than volumes \
             copied for the vertex shader (Cozzi 2007, abstract: it “reduces preprocessing, main \
             memory, and CPU-GPU bandwidth”)"
        );
        let Some((shader, copied)) = shader.zip(copied) else {
            return Finding {
                claim,
                standing: Standing::NotMeasured,
                because: String::new(),
            };
        };
        let (standing, reason) = judge(shader, copied);
        Finding {
            claim,
            standing,
            because: format!(
                "{} sensors: {} {}, {} {}{reason}",
                sweep.sensors,
                name(shader.0),
                write(shader.1),
                name(copied.0),
                write(copied.1)
            ),
        }
    };
    vec![
        compare(
            "upload",
            &|case| value(case, BYTES),
            measured_bytes,
            &|shader, copied| (Standing::holds_if(shader.1 < copied.1), String::new()),
        ),
        compare(
            "CPU time of mesh and update",
            &mesh_and_update_ms,
            |ms| format!("{} ms", significant(ms)),
            &|shader, copied| {
                let gain = mesh_and_update_ratio(copied.0, shader.0);
                let judged = gain.map(|gain| Standing::of_times(&gain, noise));
                match judged.unwrap_or((Standing::CannotTell, String::new())) {
                    (standing, reason) if reason.is_empty() => (standing, reason),
                    (standing, reason) => (standing, format!(". {reason}")),
                }
            },
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::Status;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    fn add(run: &mut MadeUpRun, technique: &str, upkeep: &str, update_ms: f64, upload: f64) {
        let conditions = [
            ("scene", "planet-134"),
            ("sensors", "50"),
            ("technique", technique),
            ("variant", "plain"),
            ("upkeep", upkeep),
        ];
        let name = format!("planet-134/50/{technique}/plain/{upkeep}");
        let case = run.case(case_id(crate::STUDY, &name, &conditions));
        case.figure(BYTES, upload);
        case.figure(COMPARED, 60.0);
        case.figure(WRONG, 0.0);
        for (metric, ms) in [
            (MESH, 1.0),
            (PLAN, 0.5),
            (UPDATE, update_ms),
            (FILL_CPU, 10.0),
            (FRAME_CPU, 11.5 + update_ms),
            (FRAME_WALL, 6.0 + update_ms),
        ] {
            case.timed(metric, &[ms; 5]);
        }
    }

    fn read(run: &MadeUpRun) -> Run {
        let folder = tempfile::tempdir().expect("a folder");
        run.write(folder.path()).expect("a run")
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
        let run = read(&made_up);
        let answers = MovingChapter.answers(&run).expect("answers");
        use Standing::{DoesNotHold, Holds, NotMeasured};
        assert_eq!(standings(&answers.requirements), [Holds; 3]);
        assert!(
            answers.scope[0].contains("180 frames"),
            "{:?}",
            answers.scope
        );
        assert_eq!(
            standings(&findings(&sweeps(&run), mesh_and_update_noise(&run))),
            [Holds; 2]
        );
        // Another way that counts takes less.
        add(&mut made_up, "vertex", "bend", 0.1, 6_000.0);
        let run = read(&made_up);
        let answers = MovingChapter.answers(&run).expect("answers");
        let because = &answers.requirements[2].because;
        assert!(because.starts_with("vertex plain"), "{because}");
        // Twin: slower, larger, and one frame wrong; geometry shaders are no better.
        let mut made_up = MadeUpRun::default();
        add(&mut made_up, "vertex", "rewrite", 0.9, 200_000.0);
        add(&mut made_up, "native", "rewrite", 1.4, 300_000.0);
        let wrong = made_up.case(case_id(crate::STUDY, "other", &[("sensors", "1")]));
        wrong.ended(Status::Wrong, "1 of 60 frames");
        wrong.figure(COMPARED, 60.0);
        wrong.figure(WRONG, 1.0);
        let run = read(&made_up);
        let answers = MovingChapter.answers(&run).expect("answers");
        assert_eq!(standings(&answers.requirements), [DoesNotHold; 3]);
        assert_eq!(
            standings(&findings(&sweeps(&run), mesh_and_update_noise(&run))),
            [DoesNotHold; 2]
        );
        // Nothing of it: no verdict.
        let run = read(&MadeUpRun::default());
        let answers = MovingChapter.answers(&run).expect("answers");
        assert_eq!(standings(&answers.requirements), [NotMeasured; 3]);
        assert!(MovingChapter.blocks(&run).expect("a chapter").is_empty());
    }

    #[test]
    fn a_difference_within_the_noise_decides_nothing() {
        let standing = |copied_ms: f64| {
            let mut made_up = MadeUpRun::default();
            add(&mut made_up, "vertex", "rewrite", copied_ms, 200_000.0);
            add(&mut made_up, "native", "rewrite", 1.0, 60_000.0);
            // Identical work takes 10 % longer.
            let id = made_up.cases[1].id.twin();
            made_up.case(id).timed(UPDATE, &[1.1; 5]);
            let run = read(&made_up);
            findings(&sweeps(&run), mesh_and_update_noise(&run))[1].clone()
        };
        let open = standing(1.1);
        assert_eq!(open.standing, Standing::CannotTell);
        assert!(open.because.contains("identical work differed"), "{open:?}");
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
        let run = read(&made_up);
        let blocks = MovingChapter.blocks(&run).expect("a chapter");
        let texts = blocks.iter().filter_map(|block| match block {
            Block::Text(text) => Some(text.as_str()),
            _ => None,
        });
        let text: String = texts.collect();
        assert!(
            text.contains("a frame takes least with native plain"),
            "{text}"
        );
        assert!(text.contains("by reload"), "{text}");
        assert!(!text.contains("by rewrite"), "{text}");
        let table = blocks.iter().find_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        });
        assert_eq!(table.expect("a table").rows.len(), 3);
    }
}
