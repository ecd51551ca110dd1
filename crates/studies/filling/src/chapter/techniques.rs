// SPDX-License-Identifier: MIT OR Apache-2.0
//! One section a technique: its best fill of every view beside the view's fastest, and what it could not
//! draw rightly.

use super::data::{Data, Scene, View, competes, counter, distinct, name, title};
use super::scenes::best;
use crate::keys::{GEOMETRY_BYTES, HAUSDORFF_PX, LAYOUT, MISMATCHED_PX, SCENE, TECHNIQUE};
use terrafill_plot::Palette;
use terrafill_plot::number::{bytes, count, significant, spread};
use terrafill_results::{Block, Case, Cell, Heading, Outcome, Row, Table, ratio};

/// Technique by technique, in order of appearance.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let scenes = data.scenes();
    let palette = Palette::new(data.all_series());
    let views = || scenes.iter().flat_map(|scene| &scene.views);
    let cases = views().flat_map(|view| &view.cases);
    let cases = cases.filter(|case| competes(case));
    let names = distinct(cases.map(|case| case.condition(TECHNIQUE)));
    let section = |technique| section(data, &scenes, &palette, technique);
    names.into_iter().flat_map(section).collect()
}

fn section(
    data: &Data<'_>,
    scenes: &[Scene<'_>],
    palette: &Palette,
    technique: &str,
) -> Vec<Block> {
    let is_own = |case: &&&Case| case.condition(TECHNIQUE) == technique;
    let mut own: Vec<&Case> = Vec::new();
    let mut rows = Vec::new();
    for scene in scenes {
        for view in &scene.views {
            let of_view = View {
                name: view.name,
                baselines: Vec::new(),
                rivals: Vec::new(),
                cases: view.cases.iter().filter(is_own).copied().collect(),
            };
            own.extend(of_view.cases.iter().copied().filter(|case| competes(case)));
            rows.extend(row(data, palette, best(data, view), &of_view));
        }
    }
    let right = own.iter().filter(|case| case.counts()).count();
    let layouts = distinct(own.iter().map(|case| case.condition(LAYOUT)));
    let mut blocks = vec![
        Block::section(format!("Technique {technique}")),
        Block::Text(format!(
            "{right} of {} fills are right. Layouts: {}.",
            own.len(),
            layouts.join(", ")
        )),
        Block::Table(Table {
            caption: format!(
                "{technique}'s fastest right fill of each view, and its time over that of the view's fastest \
                 fill by any technique, paired by process."
            ),
            headings: vec![
                Heading::plain("scene, view"),
                Heading::plain("fill"),
                Heading::metric(format!("fill, {} (5–95 %)", data.unit()), data.metric),
                Heading::plain("÷\u{a0}fastest"),
                Heading::plain("the fastest"),
                Heading::metric("geometry bytes", GEOMETRY_BYTES),
                Heading::metric("px that differ", MISMATCHED_PX),
                Heading::metric("Hausdorff, px", HAUSDORFF_PX),
            ],
            rows,
            is_main: true,
            ..Table::default()
        }),
    ];
    let others = own
        .iter()
        .filter(|case| !case.counts() && case.outcome != Outcome::Ok);
    let others = others.map(|case| {
        let (of, status) = (name(case), case.outcome.name());
        format!("{}, {of}: {status}: {}", title(case), case.reason)
    });
    let others: Vec<String> = others.collect();
    let summary = format!("{} fills without a right picture", others.len());
    blocks.extend(Block::folded_list(summary, others));
    blocks
}

/// `None` for a view that the technique was not planned for.
fn row(data: &Data<'_>, palette: &Palette, fastest: Option<&Case>, own: &View<'_>) -> Option<Row> {
    let place = title(own.cases.first()?);
    let Some(case) = best(data, own) else {
        let why = "no fill of this technique is right here and was timed";
        let mut cells = vec![Cell::name(place)];
        cells.extend((1..8).map(|_| Cell::absent(why)));
        return Some(Row::new(cells));
    };
    let over = fastest.and_then(|fastest| ratio(case, fastest, data.metric));
    Some(Row::new(vec![
        Cell {
            section: case.condition(SCENE).to_owned(),
            ..Cell::name(place)
        },
        Cell {
            marker: palette.marker(&data.marked(case)),
            command: data.command(case),
            ..Cell::name(data.label(case))
        },
        Cell::or_absent(data.right_time(case).map(spread), "no frame was timed"),
        data.ratio_cell(over.as_ref(), "no process measured both"),
        Cell::or_absent(fastest.map(|case| data.label(case)), "nothing was timed"),
        Cell::or_absent(
            counter(case, GEOMETRY_BYTES).map(bytes),
            "not counted by this technique",
        ),
        Cell::or_absent(
            counter(case, MISMATCHED_PX).map(count),
            "not compared with the reference",
        ),
        Cell::or_absent(
            case.value(HAUSDORFF_PX).map(significant),
            "one of the two pictures has no boundary",
        ),
    ]))
}
