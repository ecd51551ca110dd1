// SPDX-License-Identifier: MIT OR Apache-2.0
//! What each scene needs: the features built into a view's fill and those left out, each with its reason,
//! and what leaving out is worth, from everything that a fill can hold to only what is needed.
//!
//! Every figure is what the backend held and the device made; sums that differ are an alarm.

use super::data::{Data, counter, distinct, has_role, name, title};
use super::ladder;
use super::rungs::counters;
use crate::keys::{
    HELD_BYTES, HELD_PIPELINES, MADE_BYTES, MADE_PIPELINES, NEEDS_RUNG, NEEDS_STEP, SCENE,
    SPARED_BYTES, TECHNIQUE, VARIANT, VIEW,
};
use terrafill_fill::{Feature, Need};
use terrafill_plot::number::{bytes, count, significant, spread};
use terrafill_plot::{RatioAxis, Step, Steps};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Estimate, Finding, Heading, Metric, Plot, Row, Standing, Table,
};

/// Title of the section.
pub(super) const TITLE: &str = "What each scene needs";

/// What one case says of all features.
struct Told<'a> {
    case: &'a Case,
    needs: Vec<Need>,
}

impl<'a> Told<'a> {
    /// `None` of a case that says nothing.
    fn of(case: &'a Case) -> Option<Self> {
        let needs = Feature::ALL.iter();
        let needs = needs.filter_map(|&(feature, note)| Need::read(feature, case.note(note)));
        let needs: Vec<Need> = needs.collect();
        (!needs.is_empty()).then_some(Self { case, needs })
    }

    fn features(&self, is_held: bool) -> usize {
        let needs = self.needs.iter();
        needs.filter(|need| need.is_held == is_held).count()
    }

    /// Names of features that are built in here and not there.
    fn without(&self, other: &Self) -> Vec<String> {
        let held = |told: &Self, feature| {
            let mut needs = told.needs.iter();
            needs.any(|need| need.feature == feature && need.is_held)
        };
        let own = self.needs.iter().filter(|need| need.is_held);
        let gone = own.filter(|need| !held(other, need.feature));
        gone.map(|need| shown(need.feature)).collect()
    }
}

/// A feature's name as it is read.
fn shown(feature: Feature) -> String {
    let name = feature.note();
    name.trim_start_matches("need_").replace('_', " ")
}

fn rung(case: &Case) -> Option<u32> {
    case.condition(NEEDS_RUNG).parse().ok()
}

/// Every case that says what it holds.
fn all<'a>(data: &Data<'a>) -> Vec<Told<'a>> {
    data.cases.iter().copied().filter_map(Told::of).collect()
}

/// Whether a case holds only what its view needs: the last of the rungs, or the only one.
fn is_needed(told: &Told<'_>, all: &[Told<'_>]) -> bool {
    let key = |case: &Case| {
        let keys = [SCENE, VIEW, TECHNIQUE];
        keys.map(|key| case.condition(key).to_owned())
    };
    has_role(told.case, "needs")
        && all.iter().all(|other| {
            key(other.case) != key(told.case)
                || !has_role(other.case, "needs")
                || rung(other.case) <= rung(told.case)
        })
}

/// The section.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let all = all(data);
    if all.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = vec![
        Block::section(TITLE),
        Block::Text(
            "What a fill holds for a view, and what it leaves out, each with the value that decided it. \
             Bytes are those of buffers and textures that the device was asked to make, pipelines likewise. \
             “Only what is needed” is the variant that decides by itself what each view needs: `terrafill \
             bench SCENE --ladder SCENE` measures the way there from everything that a fill can hold."
                .to_owned(),
        ),
    ];
    let red: Vec<String> = all.iter().filter_map(disagreement).collect();
    if !red.is_empty() {
        blocks.push(Block::Alarm(
            "What is declared and what was made differ:".to_owned(),
        ));
        blocks.push(Block::List(red));
    }
    for scene in distinct(all.iter().map(|told| told.case.condition(SCENE))) {
        let of_scene = |told: &&Told<'_>| told.case.condition(SCENE) == scene;
        blocks.push(Block::Heading {
            level: 4,
            text: format!("Needs of {scene}"),
        });
        let needed: Vec<&Told<'_>> = all
            .iter()
            .filter(of_scene)
            .filter(|told| is_needed(told, &all))
            .collect();
        for technique in distinct(needed.iter().map(|told| told.case.condition(TECHNIQUE))) {
            let own = needed.iter().copied();
            let own: Vec<&Told<'_>> = own
                .filter(|told| told.case.condition(TECHNIQUE) == technique)
                .collect();
            blocks.push(Block::Table(features(&own)));
        }
        let own: Vec<&Told<'_>> = all.iter().filter(of_scene).collect();
        let listed = |told: &&&Told<'_>| rung(told.case).is_none() || is_needed(told, &all);
        let compared: Vec<&Told<'_>> = own.iter().filter(listed).copied().collect();
        blocks.push(Block::Table(sums(&compared, &all)));
        blocks.extend(ladders(data, &own)?);
    }
    Ok(blocks)
}

/// Everything that is made is declared; `None` for a run that tells nothing.
pub(super) fn requirement(data: &Data<'_>) -> Option<Finding> {
    let all = all(data);
    let differing = all.iter().filter_map(disagreement).count();
    (!all.is_empty()).then(|| Finding {
        claim: "Every byte and pipeline that a fill holds belongs to a feature that says why."
            .to_owned(),
        standing: Standing::holds_if(differing == 0),
        because: format!(
            "{} of {} fills declare what the device made for them",
            all.len() - differing,
            all.len()
        ),
    })
}

/// How sums over features differ from what the device made.
fn disagreement(told: &Told<'_>) -> Option<String> {
    let case = told.case;
    let declared = [
        (
            "bytes",
            MADE_BYTES,
            told.needs.iter().map(|need| need.bytes).sum::<u64>(),
        ),
        (
            "pipelines",
            MADE_PIPELINES,
            told.needs.iter().map(|need| need.pipelines).sum(),
        ),
    ];
    let differing =
        declared
            .iter()
            .filter_map(|(what, metric, declared)| match counter(case, metric) {
                Some(made) if made == *declared => None,
                Some(made) => Some(format!("{declared} {what} declared, {made} made")),
                None => Some(format!("{what} made were not recorded")),
            });
    let differing: Vec<String> = differing.collect();
    (!differing.is_empty())
        .then(|| format!("{}: {}: {}", title(case), name(case), differing.join("; ")))
}

/// One row for each feature, and for each group of views of which the same is said.
fn features(needed: &[&Told<'_>]) -> Table {
    let mut rows = Vec::new();
    for (feature, _) in Feature::ALL {
        let mut groups: Vec<(&Need, Vec<&str>)> = Vec::new();
        for told in needed {
            let mut own = told.needs.iter();
            let Some(need) = own.find(|need| need.feature == feature) else {
                continue;
            };
            let view = told.case.condition(VIEW);
            match groups.iter_mut().find(|(known, _)| *known == need) {
                Some((_, views)) => views.push(view),
                None => groups.push((need, vec![view])),
            }
        }
        for (need, views) in groups {
            let is_everywhere = views.len() == needed.len();
            rows.push(row(
                need,
                if is_everywhere {
                    "all".to_owned()
                } else {
                    views.join(", ")
                },
            ));
        }
    }
    let of = needed
        .first()
        .map_or("", |told| told.case.condition(TECHNIQUE));
    let variants = distinct(needed.iter().map(|told| told.case.condition(VARIANT)));
    Table {
        caption: format!("Only what is needed, by {of}: {}.", variants.join("; ")),
        headings: vec![
            Heading::plain("feature"),
            Heading::plain("views"),
            Heading::plain("built in"),
            Heading::explained("bytes", "of its buffers and textures, as made"),
            Heading::explained("pipelines", "made for it"),
            Heading::explained(
                "would take",
                "bytes that it would take, where it is left out and would take any",
            ),
            Heading::plain("because"),
        ],
        rows,
        ..Table::default()
    }
}

fn row(need: &Need, views: String) -> Row {
    let some = |number: u64, print: fn(u64) -> String, why: &str| {
        Cell::or_absent((number > 0).then(|| print(number)), why)
    };
    Row::new(vec![
        Cell::name(shown(need.feature)),
        Cell::name(views),
        Cell::name(if need.is_held { "yes" } else { "left out" }),
        some(
            need.bytes,
            count,
            "it has no buffer and no texture of its own",
        ),
        some(need.pipelines, count, "no pipeline was made for it"),
        some(
            need.spared_bytes,
            count,
            "it is built in, or would take no bytes",
        ),
        Cell::name(&need.reason),
    ])
}

/// Sums of all fills that say what they hold.
fn sums(told: &[&Told<'_>], all: &[Told<'_>]) -> Table {
    let row = |told: &&Told<'_>| {
        let case = told.case;
        let print = |metric: &Metric, print: fn(u64) -> String| {
            Cell::or_absent(counter(case, metric).map(print), "not recorded by this run")
        };
        let detail = if is_needed(told, all) {
            "only what is needed".to_owned()
        } else {
            String::new()
        };
        Row::new(vec![
            Cell::name(case.condition(VIEW)),
            Cell {
                detail,
                ..Cell::name(name(case))
            },
            print(HELD_BYTES, count),
            print(SPARED_BYTES, count),
            print(HELD_PIPELINES, count),
            Cell::plain(count(told.features(true) as u64)),
            Cell::plain(count(told.features(false) as u64)),
        ])
        .bad_if(disagreement(told).is_some())
    };
    Table {
        caption: "What fills of each view hold in all.".to_owned(),
        headings: vec![
            Heading::plain("view"),
            Heading::plain("fill"),
            Heading::metric("bytes held", HELD_BYTES),
            Heading::metric("bytes spared", SPARED_BYTES),
            Heading::metric("pipelines", HELD_PIPELINES),
            Heading::plain("features built in"),
            Heading::plain("left out"),
        ],
        rows: told.iter().map(row).collect(),
        ..Table::default()
    }
}

/// The ways from everything to what is needed, one for each view and technique.
fn ladders(data: &Data<'_>, told: &[&Told<'_>]) -> Result<Vec<Block>, ChapterError> {
    let rungs = || {
        told.iter()
            .copied()
            .filter(|told| rung(told.case).is_some())
    };
    let key = |told: &Told<'_>| [VIEW, TECHNIQUE].map(|key| told.case.condition(key).to_owned());
    let mut blocks = Vec::new();
    for of in distinct(rungs().map(key)) {
        let mut own: Vec<&Told<'_>> = rungs().filter(|told| key(told) == of).collect();
        own.sort_by_key(|told| rung(told.case));
        let [view, technique] = &of;
        blocks.push(Block::Heading {
            level: 4,
            text: format!("From everything to what {view} needs, by {technique}"),
        });
        blocks.extend(sentence(data, &own).map(Block::Text));
        if let Some(svg) = plot(data, &own)? {
            blocks.push(Block::Plot(Plot {
                caption: String::new(),
                svg,
            }));
        }
        blocks.push(Block::Table(steps(data, &own)));
    }
    Ok(blocks)
}

/// What all of leaving out is worth.
fn sentence(data: &Data<'_>, rungs: &[&Told<'_>]) -> Option<String> {
    let (first, last) = (rungs.first()?.case, rungs.last()?.case);
    let held = |case| counter(case, HELD_BYTES);
    let (before, after) = (held(first)?, held(last)?);
    let share = match before {
        0 => String::new(),
        _ => format!(", {} %", significant(100.0 * after as f64 / before as f64)),
    };
    let time = data.over(first, last).map_or_else(
        || "the two were not timed, or one is not right".to_owned(),
        |gain| format!("gain in time {}", data.ratio_text(&gain)),
    );
    Some(format!(
        "Leaving out what the view does not need: {} held instead of {}{share}; {time}.",
        bytes(after),
        bytes(before)
    ))
}

/// Time of the step before over this one's.
fn gain(data: &Data<'_>, rungs: &[&Told<'_>], index: usize) -> Option<Estimate> {
    let before = rungs[index.checked_sub(1)?].case;
    data.over(before, rungs[index].case)
}

fn steps(data: &Data<'_>, rungs: &[&Told<'_>]) -> Table {
    let rows = rungs.iter().enumerate().map(|(index, told)| {
        let case = told.case;
        let before = index.checked_sub(1).map(|before| rungs[before]);
        let why = match case.reason.as_str() {
            "" => case.outcome.name(),
            reason => reason,
        };
        let print = |metric: &Metric, print: fn(u64) -> String| {
            Cell::or_absent(counter(case, metric).map(print), why)
        };
        let gain = gain(data, rungs, index);
        let gone = match before {
            None => Cell::absent("nothing comes before it"),
            Some(before) => {
                let gone = before.without(told);
                let come = told.without(before);
                let said = match (gone.is_empty(), come.is_empty()) {
                    (true, true) => "the same features".to_owned(),
                    (false, true) => format!("without {}", gone.join(", ")),
                    (true, false) => format!("with {}", come.join(", ")),
                    (false, false) => {
                        format!("with {} in place of {}", come.join(", "), gone.join(", "))
                    }
                };
                Cell {
                    detail: counters(before.case, case),
                    ..Cell::name(said)
                }
            }
        };
        Row {
            cells: vec![
                Cell {
                    detail: name(case),
                    ..Cell::name(format!(
                        "{} · {}: {}",
                        index + 1,
                        case.condition(NEEDS_STEP),
                        case.note("needs_change")
                    ))
                },
                Cell::plain(case.outcome.name()),
                print(HELD_BYTES, count),
                print(HELD_PIPELINES, count),
                Cell::or_absent(data.spread_over_depth_pass(case).map(spread), why),
                data.ratio_cell(
                    gain.as_ref(),
                    "no right step before it, or no times of both",
                ),
                gone,
            ],
            status: case.outcome.name().to_owned(),
            remark: String::new(),
        }
    });
    Table {
        headings: vec![
            Heading::plain("step"),
            Heading::plain("status"),
            Heading::metric("bytes held", HELD_BYTES),
            Heading::metric("pipelines", HELD_PIPELINES),
            Heading::explained(
                "÷\u{a0}depth-pass (5\u{2060}–\u{2060}95\u{a0}%)",
                "times over the median of the full-screen depth-pass of the same view",
            ),
            Heading::explained(
                "gain over the step before [95\u{a0}%]",
                "time of the step before over this one's, paired by process",
            ),
            Heading::explained("features", "what the step left out or brought in"),
        ],
        rows: rows.collect(),
        is_main: true,
        ..Table::default()
    }
}

fn plot(data: &Data<'_>, rungs: &[&Told<'_>]) -> Result<Option<String>, ChapterError> {
    let rows = rungs.iter().enumerate().map(|(index, told)| {
        let case = told.case;
        let ratio = data.spread_over_depth_pass(case);
        let held = counter(case, HELD_BYTES)
            .map_or_else(String::new, |held| format!(" · {}", bytes(held)));
        Step {
            label: format!("{} · {}", index + 1, case.condition(NEEDS_STEP)),
            value: ratio.map_or_else(String::new, |ratio| {
                format!("{} ×{held}", significant(ratio.median))
            }),
            begins: ratio
                .zip(gain(data, rungs, index))
                .map(|(ratio, gain)| ratio.median * gain.middle),
            is_kept: case.counts(),
            ratio: ratio.ok_or_else(|| ladder::no_ratio(data, case)),
            command: data.command(case),
        }
    });
    let axis = ladder::axis_title(data);
    let case = rungs.first().map(|told| told.case);
    let steps = Steps {
        title: format!(
            "{}: time over depth-pass, from everything to what is needed",
            case.map_or_else(String::new, title)
        ),
        axis: RatioAxis {
            title: &axis,
            one: ladder::AXIS_ONE,
        },
        rows: rows.collect(),
    };
    Ok(steps.draw()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chapter::FillingChapter;
    use terrafill_results::made_up::{MadeUpCase, MadeUpRun, case_id};
    use terrafill_results::{CellClass, Chapter as _, RunEnvironment};

    const PROCESSES: [f64; 4] = [1.0, 1.1, 0.9, 1.05];

    fn told(feature: Feature, bytes: u64, pipelines: u64) -> Need {
        Need {
            feature,
            is_held: bytes + pipelines > 0,
            bytes,
            spared_bytes: if bytes == 0 { 64 } else { 0 },
            pipelines,
            reason: format!("{} because of {bytes}", shown(feature)),
        }
    }

    /// A case that holds `needs` and says that this was made.
    fn add<'a>(
        run: &'a mut MadeUpRun,
        (view, variant): (&str, &str),
        more: &[(&str, &str)],
        needs: &[Need],
        ms: f64,
    ) -> &'a mut MadeUpCase {
        let key = format!("s/{view}/vertex/{variant}");
        let mut conditions = vec![
            ("scene", "s"),
            ("view", view),
            ("technique", "vertex"),
            ("variant", variant),
            ("layout", "doubled"),
        ];
        conditions.extend(more);
        let bytes: u64 = needs.iter().map(|need| need.bytes).sum();
        let pipelines: u64 = needs.iter().map(|need| need.pipelines).sum();
        let case = run.case(case_id("filling", &key, &conditions));
        for (metric, value) in [
            ("held_bytes", bytes),
            ("made_bytes", bytes),
            ("held_pipelines", pipelines),
            ("made_pipelines", pipelines),
            ("spared_bytes", 64),
            ("mismatched_px", 0),
            ("mismatched_px_outside_band", 0),
            ("vertices", 10 * bytes),
        ] {
            case.figure(metric, value as f64);
        }
        for need in needs {
            case.note(need.feature.note(), &need.line());
        }
        case.timed("fill_cpu_ms", &PROCESSES.map(|factor| factor * ms))
    }

    /// Two views, of which one needs bottom caps; a ladder of the other.
    fn run() -> MadeUpRun {
        let mut run = MadeUpRun {
            environment: RunEnvironment {
                device_type: "cpu".to_owned(),
                ..RunEnvironment::default()
            },
            ..MadeUpRun::default()
        };
        let depth_pass = case_id(
            "filling",
            "s/far/depth-pass/full-screen",
            &[("scene", "s"), ("view", "far"), ("technique", "depth-pass")],
        );
        run.case(depth_pass).timed("fill_cpu_ms", &PROCESSES);
        let everything = [
            told(Feature::BottomCaps, 300, 0),
            told(Feature::CountBehind, 0, 2),
            told(Feature::Walls, 100, 0),
        ];
        let needed = [
            told(Feature::BottomCaps, 0, 0),
            told(Feature::CountBehind, 0, 0),
            told(Feature::Walls, 100, 0),
        ];
        let rung = |number, step| {
            [
                ("role", "needs"),
                ("needs-rung", number),
                ("needs-step", step),
            ]
        };
        let first = rung("1", "everything");
        add(&mut run, ("far", "doubled,a=b"), &first, &everything, 8.0);
        let last = rung("2", "bottom-caps");
        add(&mut run, ("far", "doubled,c=d"), &last, &needed, 2.0);
        let near = [("role", "needs")];
        add(&mut run, ("near", "doubled,c=d"), &near, &everything, 4.0);
        run
    }

    fn section(run: &MadeUpRun) -> Vec<Block> {
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        let all = FillingChapter.blocks(&run).expect("a chapter");
        let is_section = |block: &&Block| matches!(block, Block::Heading { level: 3, .. });
        let mut own = all
            .iter()
            .skip_while(|block| **block != Block::section(TITLE));
        let title = own.next().cloned();
        let rest = own.take_while(|block| !is_section(block)).cloned();
        title.into_iter().chain(rest).collect()
    }

    fn tables(blocks: &[Block]) -> Vec<&Table> {
        let tables = blocks.iter().filter_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        });
        tables.collect()
    }

    fn texts(row: &Row) -> Vec<&str> {
        row.cells.iter().map(|cell| cell.text.as_str()).collect()
    }

    #[test]
    fn what_views_need_is_told_feature_by_feature_and_step_by_step() {
        let blocks = section(&run());
        let tables = tables(&blocks);
        let [features, sums, steps] = tables[..] else {
            panic!("{} tables", tables.len());
        };
        let rows: Vec<Vec<&str>> = features.rows.iter().map(texts).collect();
        assert_eq!(
            rows[0],
            [
                "bottom caps",
                "far",
                "left out",
                "–",
                "–",
                "64",
                "bottom caps because of 0"
            ]
        );
        assert_eq!(rows[1][..4], ["bottom caps", "near", "yes", "300"]);
        // Views of which the same is said share a row.
        assert_eq!(rows[2][..4], ["walls", "all", "yes", "100"]);
        assert_eq!(rows.len(), 5);
        assert_eq!(
            sums.rows.len(),
            2,
            "rungs before the last one have their own table"
        );
        assert_eq!(texts(&steps.rows[1])[2..4], ["100", "0"]);
        let last = &steps.rows[1].cells;
        assert_eq!(last[6].text, "without bottom caps, count behind");
        assert!(last[5].text.starts_with('4'), "{}", last[5].text);
        let said = blocks.iter().find_map(|block| match block {
            Block::Text(text) if text.starts_with("Leaving out") => Some(text),
            _ => None,
        });
        let said = said.expect("what it is worth");
        assert!(
            said.contains("25.0 %") && said.contains("gain in time 4"),
            "{said}"
        );
        assert!(!blocks.iter().any(|block| matches!(block, Block::Alarm(_))));
    }

    #[test]
    fn bytes_that_no_feature_declares_are_an_alarm() {
        let mut forged = run();
        forged.cases[3].figure("made_bytes", 500.0);
        let blocks = section(&forged);
        let alarm = blocks.iter().any(|block| matches!(block, Block::Alarm(_)));
        assert!(alarm, "400 bytes are declared");
        let list = blocks.iter().find_map(|block| match block {
            Block::List(lines) => Some(lines.join("\n")),
            _ => None,
        });
        let list = list.expect("which one");
        assert!(list.contains("400 bytes declared, 500 made"), "{list}");
        let sums = tables(&blocks)[1];
        assert!(
            sums.rows[1]
                .cells
                .iter()
                .any(|cell| cell.class == CellClass::Bad)
        );
        // Twins: a pipeline; and a run that says nothing has no such section.
        let mut forged = run();
        forged.cases[1].figure("made_pipelines", 9.0);
        let alarm = |block: &Block| matches!(block, Block::Alarm(_));
        assert!(section(&forged).iter().any(alarm));
        assert!(section(&MadeUpRun::default()).is_empty());
    }
}
