// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every scene with its views: plots, tables of all cases, and pictures beside the reference's.

use super::data::{DEPTH_PASS, Data, STENCIL_PASS, ViewCases, reason_or, setting, standing};
use super::error_time;
use super::table::{STATUS, or_dash};
use crate::keys::*;
use crate::purpose::{Purpose, is_approximate};
use terrafill_lab::{Column, case_table};
use terrafill_plot::number::{digits, significant, times};
use terrafill_plot::{DOTS_OF_PROCESSES, RatioAxis, RatioGroup, RatioPlot, RatioRow};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Estimate, Heading, Outcome, Picture, PictureFigure, Pictures,
    Table, over_typical,
};

/// Key of the pictures of differences, as `terrafill-conformance` draws them.
const DIFFERENCE_KEY: &str = "Pictures: the reference, and every picture, those that are the same once. A \
    difference is shown where a pixel differs: grey, both fill with the same region; dark, neither \
    fills; a shade apart, the 1-pixel boundary band; orange, differs within the band; red, differs \
    outside it. Differing pixels are drawn 3 × 3. Worst pixel: the one furthest from the reference's \
    boundary, framed in white, with 24 × 24 pixels around it, from left to right the reference, the \
    picture and the difference. A picture that is chosen by Tab or click fills the window.";

/// What is said of a case before its figures, with what it means.
const SAID: [(&str, &str); 4] = [
    ("case", ""),
    (
        "÷\u{a0}fastest right",
        "medians over processes; only an approximate fill may be below 1",
    ),
    (
        "÷\u{a0}depth-pass",
        "over the full-screen pass that reads depth, paired by process",
    ),
    (
        "÷\u{a0}stencil-pass",
        "the same with the pass that clears and tests the stencil",
    ),
];

/// What is left out stands in `summary.csv`, such as bytes by what they hold.
const COLUMNS: [Column; 19] = [
    STATUS,
    Column::sampled("fill, {unit} (5–95 %)", FILL_GPU_MS, FILL_CPU_MS),
    Column::sampled("fill, {unit} (5–95 %)", FILL_CPU_MS, FILL_GPU_MS),
    Column::metric("surface, {unit}", SURFACE_GPU_MS),
    Column::metric("surface bytes", SURFACE_BYTES).written(digits),
    Column::metric("stencil, {unit}", STENCIL_GPU_MS),
    Column::metric("colour, {unit}", COLOUR_GPU_MS),
    Column::metric("geometry bytes", GEOMETRY_BYTES).written(digits),
    Column::metric("target bytes", TARGET_BYTES).written(digits),
    Column::metric("to prepare, {unit}", PREPARE_CPU_MS),
    Column::metric("draws", DRAWS),
    Column::metric("vertices", VERTICES),
    Column::metric("regions left out", REGIONS_LEFT_OUT),
    Column::metric("px that differ", MISMATCHED_PX),
    Column::metric("outside band", MISMATCHED_PX_OUTSIDE_BAND),
    Column::metric("Hausdorff, px", HAUSDORFF_PX).written(significant),
    Column::metric("moved, px", BOUNDARY_MOVED_PX).written(significant),
    Column::metric("by the surface, px", MOVED_PX_TRUE).written(significant),
    Column::metric("boundary,\u{a0}m", BOUNDARY_DEVIATION_M).written(significant),
];

/// Every scene.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let clock = data.run.clock().name();
    let mut blocks = Vec::new();
    for (scene, views) in data.scenes() {
        blocks.push(Block::section(scene));
        let caption = format!(
            "By {clock}: each right fill over its view's fastest, medians over processes. Points of sweeps and \
             approximate fills compete with none and stand in the plots of error against time. Whiskers: 95 % \
             interval, where there are five processes or more. Shaded: ties. Dashed: the depth-pass of that view, \
             a full-screen pass that reads depth and writes a constant colour; a yardstick, not a bound. A cross \
             at the right edge has no time that counts."
        );
        blocks.extend(Block::plot(caption, ratio_plot(data, scene, &views)?));
        let pictures: Vec<_> = views.iter().map(|view| pictures(data, view)).collect();
        if pictures.iter().any(Option::is_some) {
            blocks.push(Block::Remark(DIFFERENCE_KEY.to_owned()));
        }
        for (view, pictures) in views.iter().zip(pictures) {
            blocks.push(Block::part(view.title()));
            blocks.extend(pictures.map(Block::Pictures));
            blocks.push(Block::Table(cases(data, view)));
            blocks.extend(error_time::of_view(data, view)?);
        }
    }
    Ok(blocks)
}

/// Each case that competes over the fastest right one of its view, fastest first.
fn ratio_plot(
    data: &Data<'_>,
    scene: &str,
    views: &[&ViewCases<'_>],
) -> Result<Option<String>, ChapterError> {
    let groups = views.iter().map(|view| {
        let best = data.timings.fastest(view.competing());
        let ratio = |case: &Case| data.timings.over_fastest(case, best?);
        let mut cases: Vec<&Case> = view.competing().collect();
        let order = |case: &Case| ratio(case).map_or(f64::INFINITY, |ratio| ratio.middle);
        cases.sort_by(|a, b| order(a).total_cmp(&order(b)));
        let dashed = view.baselines.iter().find_map(|pass| {
            let ratio = ratio(pass).filter(|_| pass.condition(TECHNIQUE) == DEPTH_PASS)?;
            let name = format!("depth-pass {} × (dashed)", significant(ratio.middle));
            Some((ratio.middle, name))
        });
        let rows = cases.into_iter();
        RatioGroup {
            name: view.name.to_owned(),
            dashed,
            rows: rows
                .map(|case| ratio_row(data, case, ratio(case)))
                .collect(),
        }
    });
    let title = format!(
        "{} of the fill ÷ that of the view's fastest (logarithmic)",
        data.run.clock().name()
    );
    let plot = RatioPlot {
        title: format!("{scene}: fill time over the fastest"),
        axis: RatioAxis {
            title: &title,
            one: "fastest = 1",
        },
        dots: DOTS_OF_PROCESSES,
        tie_factor: data.timings.noise.map(|noise| noise.max_factor()),
        groups: groups.collect(),
    };
    Ok(plot.draw(data.palette())?)
}

fn ratio_row(data: &Data<'_>, case: &Case, ratio: Option<Estimate>) -> RatioRow {
    RatioRow {
        label: data.label(case),
        series: data.marked(case),
        command: data.command(case),
        ..data
            .timings
            .ratio_row(case, ratio.ok_or_else(|| data.no_ratio(case)))
    }
}

fn cases(data: &Data<'_>, view: &ViewCases<'_>) -> Table {
    let fastest = data.timings.fastest(view.competing());
    let rows = view.listed().map(|case| {
        let cell = Cell {
            detail: setting(case, view).unwrap_or_default().to_owned(),
            ..data.name_cell(case, data.label(case))
        };
        let counts = case.counts() || is_approximate(case) || Purpose::Rival.is_of(case);
        let over = fastest.filter(|_| counts);
        let over = over.and_then(|fastest| over_typical(case, fastest, data.timings.metric));
        let why = "it is not right or was not timed, or no fill of this view is";
        let said = vec![
            cell,
            Cell::or_absent(over.as_ref().map(times), reason_or(case, why)),
            data.over_pass_cell(case, DEPTH_PASS),
            data.over_pass_cell(case, STENCIL_PASS),
        ];
        (case, said)
    });
    let mut table = case_table(&data.study, SAID.map(Heading::from).into(), &COLUMNS, rows);
    for (row, case) in table.rows.iter_mut().zip(view.listed()) {
        row.status = standing(case).to_owned();
    }
    table
}

/// The reference's picture, then each case's beside its difference and its worst pixel. Wrong cases
/// of the ablation and the matrix are among them: their own tables have no room for pictures.
fn pictures(data: &Data<'_>, view: &ViewCases<'_>) -> Option<Pictures> {
    let listed = || view.cases.iter().chain(&view.rivals).copied();
    let wrong = view.all.iter().copied().filter(|case| {
        // Textured fills have their pictures in their own section.
        case.outcome == Outcome::Wrong
            && !Purpose::Texture.is_of(case)
            && !listed().any(|listed| listed.id() == case.id())
    });
    let cases: Vec<&Case> = listed().chain(wrong).collect();
    let mut references = cases.iter();
    let reference = references.find_map(|case| Picture::of(case, "reference_image", "reference"));
    let own = cases.iter().filter_map(|case| {
        // Where nothing differs, a difference shows nothing.
        let differs = case.value(MISMATCHED_PX) != Some(0.0);
        let worst = format!("worst pixel ({})", case.note("worst_px"));
        let pictures = [
            Picture::of(case, "image", "picture"),
            Picture::of(case, "difference_image", "difference").filter(|_| differs),
            Picture::of(case, "worst_image", worst).filter(|_| differs),
        ];
        let pictures: Vec<Picture> = pictures.into_iter().flatten().collect();
        let status = match case.outcome {
            Outcome::Ok => String::new(),
            _ => format!(" ({})", standing(case)),
        };
        let [differ, outside] = [MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND]
            .map(|metric| or_dash(case.value(metric).map(digits)));
        (!pictures.is_empty()).then(|| PictureFigure {
            pictures,
            notes: vec![format!(
                "{}{status}: {differ} px differ, {outside} of them outside the band",
                data.label(case)
            )],
        })
    });
    // A committed run leaves pictures out, and a worst pixel cannot be laid over the whole.
    let has_pictures = cases.iter().any(|case| !case.note("image").is_empty());
    let laid_over = reference.as_ref().filter(|_| has_pictures);
    let laid_over = laid_over.map_or_else(String::new, |picture| picture.path.clone());
    let map = cases
        .iter()
        .find_map(|case| Picture::of(case, "map_image", "the view, as a map shows it"));
    let reference = reference.map(|reference| PictureFigure {
        pictures: map.into_iter().chain([reference]).collect(),
        notes: Vec::new(),
    });
    let figures: Vec<PictureFigure> = reference.into_iter().chain(own).collect();
    (!figures.is_empty()).then_some(Pictures {
        reference: laid_over,
        figures,
        ..Pictures::default()
    })
}
