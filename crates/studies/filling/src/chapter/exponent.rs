// SPDX-License-Identifier: MIT OR Apache-2.0
//! How fill time grows with vertices: one map in two scales, seen by the same camera.

use super::data::{Data, has_role, name};
use crate::keys::VERTICES;
use terrafill_plot::number::{count, figure, significant};
use terrafill_results::{Block, Case, Cell, Heading, Row, Table, exponent};

/// The same countries, coarse and fine.
const SCENES: [&str; 2] = ["countries-110m", "countries-50m"];

/// The view that shows all of them.
const VIEW: &str = "globe";

/// A row for each technique that is right in both scenes.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let scenes = data.scenes();
    let of = |wanted: &str| {
        let scene = scenes.iter().find(|scene| scene.name == wanted)?;
        scene.views.iter().find(|view| view.name == VIEW)
    };
    let [Some(few), Some(many)] = SCENES.map(of) else {
        return Vec::new();
    };
    let rows = few.cases.iter().filter(|case| !has_role(case, "sweep"));
    let rows: Vec<Row> = rows
        .filter_map(|case| {
            let same = |other: &&&Case| name(other) == name(case);
            row(data, case, many.cases.iter().find(same)?)
        })
        .collect();
    if rows.is_empty() {
        return Vec::new();
    }
    let [few, many] = SCENES;
    let unit = data.unit();
    vec![
        Block::section("Fill time against vertices"),
        Block::Text(format!(
            "{many} beside {few}, {VIEW}: the same countries from the same eye. The exponent b of time \
             = c · verticesᵇ, with its 95 % interval over resampled processes: 0 where pixels cost \
             everything, 1 where vertices do."
        )),
        Block::Table(Table {
            headings: vec![
                Heading::plain("technique"),
                Heading::metric(format!("vertices, {few}"), VERTICES),
                Heading::metric(format!("vertices, {many}"), VERTICES),
                Heading::metric(format!("fill, {unit}, {few}"), data.metric),
                Heading::metric(format!("fill, {unit}, {many}"), data.metric),
                Heading::plain("exponent"),
            ],
            rows,
            is_main: true,
            ..Table::default()
        }),
    ]
}

fn row(data: &Data<'_>, few: &Case, many: &Case) -> Option<Row> {
    let vertices = [few.value(VERTICES)?, many.value(VERTICES)?];
    let times = [data.right_time(few)?, data.right_time(many)?];
    let [of_few, of_many] = [few, many].map(|case| data.replicates(case));
    let found = exponent(vertices, [&of_few, &of_many])?;
    let counted = |case: &Case| super::data::counter(case, VERTICES).map(count);
    Some(Row::new(vec![
        Cell::name(name(few)),
        Cell::plain(counted(few)?),
        Cell::plain(counted(many)?),
        Cell::plain(significant(times[0].median)),
        Cell::plain(significant(times[1].median)),
        Cell::plain(figure(&found)),
    ]))
}
