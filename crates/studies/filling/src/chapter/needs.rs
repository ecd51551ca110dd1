// SPDX-License-Identifier: MIT OR Apache-2.0
//! What each scene needs: the features built into a view's fill and those left out, each with its reason,
//! and what leaving out is worth, from everything that a fill can hold to only what is needed.
//!
//! Every figure is what the backend held and the device made; sums that differ are an alarm.

use super::data::{Data, counter, distinct, grouped, has_role, name, title};
use super::rungs::{Ladder, NEEDS, Rung, counters, ladders};
use super::table::Show::{Count, Own, Ratios, Status};
use super::table::{
    Column, alarm, figures, head, none_differs, part, row, step_cells, steps_plot, table,
};
use crate::keys::*;
use terrafill_contract::{Feature, Need};
use terrafill_plot::number::{bytes, count, significant};
use terrafill_results::{Block, Case, Cell, ChapterError, Finding, Row, Table};

const SUMS: [Column; 7] = [
    ("view", Own("")),
    ("fill", Own("")),
    ("bytes held", Count(HELD_BYTES)),
    ("bytes spared", Count(SPARED_BYTES)),
    ("pipelines", Count(HELD_PIPELINES)),
    ("features built in", Own("")),
    ("left out", Own("")),
];

const STEPS: [Column; 7] = [
    ("step", Own("")),
    ("status", Status),
    ("bytes held", Count(HELD_BYTES)),
    ("pipelines", Count(HELD_PIPELINES)),
    ("÷\u{a0}depth-pass (5\u{2060}–\u{2060}95\u{a0}%)", Ratios),
    (
        "gain over the step before [95\u{a0}%]",
        Own("time of the step before over this one's, paired by process"),
    ),
    ("features", Own("what the step left out or brought in")),
];

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

    fn features(&self, is_held: bool) -> u64 {
        let needs = self.needs.iter();
        needs.filter(|need| need.is_held == is_held).count() as u64
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
fn is_needed(data: &Data<'_>, case: &Case) -> bool {
    let technique = case.condition(TECHNIQUE);
    let mut others = data.beside(case).iter();
    has_role(case, "needs")
        && others.all(|other| {
            other.condition(TECHNIQUE) != technique
                || !has_role(other, "needs")
                || rung(other) <= rung(case)
        })
}

/// The section.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let all = all(data);
    if all.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = head(
        TITLE,
        "What a fill holds for a view, and what it leaves out, each with the value that decided it. \
             Bytes are those of buffers and textures that the device was asked to make, pipelines likewise. \
             “Only what is needed” is the variant that decides by itself what each view needs: `terrafill \
             bench SCENE --ladder SCENE` measures the way there from everything that a fill can hold.",
    );
    let red = all.iter().filter_map(disagreement).collect();
    blocks.extend(alarm("What is declared and what was made differ:", red));
    let ladders = ladders(data, NEEDS);
    for (scene, own) in grouped(&all, |told| told.case.condition(SCENE)) {
        blocks.push(part(format!("Needs of {scene}")));
        let needed = own.iter().copied();
        let needed = needed.filter(|told| is_needed(data, told.case));
        for (technique, own) in grouped(needed, |told| told.case.condition(TECHNIQUE)) {
            blocks.push(Block::Table(features(technique, &own)));
        }
        blocks.push(Block::Table(sums(data, &own)));
        for ladder in ladders.iter().filter(|ladder| ladder.scene == scene) {
            blocks.extend(ladder_blocks(data, ladder)?);
        }
    }
    Ok(blocks)
}

/// Everything that is made is declared; `None` for a run that tells nothing.
pub(super) fn requirement(data: &Data<'_>) -> Option<Finding> {
    let all = all(data);
    let differing = all.iter().filter_map(disagreement).count();
    let claim = "Every byte and pipeline that a fill holds belongs to a feature that says why.";
    let what = "fills declare what the device made for them";
    (!all.is_empty()).then(|| none_differs(claim, all.len(), differing, what))
}

/// How sums over features differ from what the device made.
fn disagreement(told: &Told<'_>) -> Option<String> {
    let case = told.case;
    let sum = |figure: fn(&Need) -> u64| told.needs.iter().map(figure).sum::<u64>();
    let declared = [
        ("bytes", MADE_BYTES, sum(|need| need.bytes)),
        ("pipelines", MADE_PIPELINES, sum(|need| need.pipelines)),
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
fn features(technique: &str, needed: &[&Told<'_>]) -> Table {
    let of_feature = |(feature, _): (Feature, _)| {
        let told = needed.iter().filter_map(move |told| {
            let need = told.needs.iter().find(|need| need.feature == feature)?;
            Some((need, told.case.condition(VIEW)))
        });
        grouped(told, |(need, _)| need.line()).into_iter()
    };
    let rows = Feature::ALL.into_iter().flat_map(of_feature);
    let rows = rows.map(|(_, same)| {
        let views: Vec<&str> = same.iter().map(|(_, view)| *view).collect();
        let is_all = views.len() == needed.len();
        let views = if is_all {
            "all".to_owned()
        } else {
            views.join(", ")
        };
        feature(same[0].0, &views)
    });
    let variants = distinct(needed.iter().map(|told| told.case.condition(VARIANT)));
    let headings = [
        ("feature", ""),
        ("views", ""),
        ("built in", ""),
        ("bytes", "of its buffers and textures, as made"),
        ("pipelines", "made for it"),
        (
            "would take",
            "bytes that it would take, where it is left out and would take any",
        ),
        ("because", ""),
    ];
    Table {
        caption: format!(
            "Only what is needed, by {technique}: {}.",
            variants.join("; ")
        ),
        ..figures(&headings, rows.collect())
    }
}

fn feature(need: &Need, views: &str) -> Row {
    let some = |number: u64, why: &str| Cell::or_absent((number > 0).then(|| count(number)), why);
    let cells = [
        Cell::name(views),
        Cell::name(if need.is_held { "yes" } else { "left out" }),
        some(need.bytes, "it has no buffer and no texture of its own"),
        some(need.pipelines, "no pipeline was made for it"),
        some(need.spared_bytes, "it is built in, or would take no bytes"),
        Cell::name(&need.reason),
    ];
    row(Cell::name(shown(need.feature)), cells)
}

/// Sums of all fills that say what they hold; rungs before the last one have their own table.
fn sums(data: &Data<'_>, told: &[&Told<'_>]) -> Table {
    let listed = |told: &&&Told<'_>| rung(told.case).is_none() || is_needed(data, told.case);
    let told = told.iter().filter(listed);
    let rows = told.clone().map(|told| {
        let detail = match is_needed(data, told.case) {
            true => "only what is needed",
            false => "",
        };
        let features = [true, false].map(|is_held| Cell::plain(count(told.features(is_held))));
        let fill = Cell {
            detail: detail.to_owned(),
            ..Cell::name(name(told.case))
        };
        let names = [Cell::name(told.case.condition(VIEW)), fill];
        (told.case, names.into_iter().chain(features).collect())
    });
    let mut table = table(data, &SUMS, rows);
    table.caption = "What fills of each view hold in all.".to_owned();
    let rows = table.rows.into_iter().zip(told);
    table.rows = rows
        .map(|(row, told)| row.bad_if(disagreement(told).is_some()))
        .collect();
    table
}

/// The way from everything to what is needed.
fn ladder_blocks(data: &Data<'_>, ladder: &Ladder<'_>) -> Result<Vec<Block>, ChapterError> {
    let rungs = &ladder.rungs;
    let title = format!(
        "{}, {}: time over depth-pass, from everything to what is needed",
        ladder.scene, ladder.view
    );
    let held = |rung: &Rung<'_>| {
        let held = counter(rung.case, HELD_BYTES);
        held.map_or_else(String::new, |held| format!(" · {}", bytes(held)))
    };
    let rows = rungs.iter().map(|rung| {
        let features = match rung.before.and_then(Told::of).zip(Told::of(rung.case)) {
            None => Cell::absent("nothing comes before it"),
            Some((before, told)) => Cell {
                detail: counters(before.case, rung.case),
                ..Cell::name(change(&before, &told))
            },
        };
        let own = step_cells(data, rung).into_iter().chain([features]);
        (rung.case, own.collect())
    });
    let heading = part(format!(
        "From everything to what {} needs, by {}",
        ladder.view, ladder.technique
    ));
    let blocks = [
        Some(heading),
        sentence(data, rungs).map(Block::Text),
        steps_plot(data, title, rungs, held)?,
        Some(Block::Table(Table {
            is_main: true,
            ..table(data, &STEPS, rows)
        })),
    ];
    Ok(blocks.into_iter().flatten().collect())
}

/// What a step left out and brought in.
fn change(before: &Told<'_>, after: &Told<'_>) -> String {
    let (gone, come) = (before.without(after), after.without(before));
    match (gone.is_empty(), come.is_empty()) {
        (true, true) => "the same features".to_owned(),
        (false, true) => format!("without {}", gone.join(", ")),
        (true, false) => format!("with {}", come.join(", ")),
        (false, false) => format!("with {} in place of {}", come.join(", "), gone.join(", ")),
    }
}

/// What all of leaving out is worth.
fn sentence(data: &Data<'_>, rungs: &[Rung<'_>]) -> Option<String> {
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
