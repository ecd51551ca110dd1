// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every scene with its views: plots, tables of all cases, and pictures beside the reference's.

use super::data::{
    DEPTH_PASS, Data, STENCIL_PASS, View, counter, grouped, has_role, is_approximate, is_rival,
    name, setting, standing,
};
use super::table::Show::{Count, Figure, OtherClock, Over, Own, Status, Times};
use super::table::{Column, no_ratio, or_dash, part, plot, table};
use super::{error_time, published};
use crate::keys::*;
use terrafill_plot::number::{count, significant, times};
use terrafill_plot::{RatioAxis, RatioGroup, RatioPlot, RatioRow};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Estimate, Outcome, Picture, PictureFigure, Pictures, Spread,
    Table, over_typical,
};

/// Key of the pictures of differences, as `terrafill-conformance` draws them.
const DIFFERENCE_KEY: &str = "Pictures: the reference, and every picture, those that are the same once. A \
    difference is shown where a pixel differs: grey, both fill with the same region; dark, neither \
    fills; a shade apart, the 1-pixel boundary band; orange, differs within the band; red, differs \
    outside it. Differing pixels are drawn 3 × 3. Worst pixel: the one furthest from the reference's \
    boundary, framed in white, with 24 × 24 pixels around it, from left to right the reference, the \
    picture and the difference. A picture that is chosen by Tab or click fills the window.";

const COLUMNS: [Column; 26] = [
    ("case", Own("")),
    ("status", Status),
    ("fill, {unit} (5–95 %)", Times),
    (
        "÷\u{a0}fastest right",
        Own("medians over processes; no right fill is below 1, an approximate one may be"),
    ),
    ("÷\u{a0}depth-pass", Over(DEPTH_PASS)),
    ("÷\u{a0}stencil-pass", Over(STENCIL_PASS)),
    ("fill, {other}", OtherClock),
    ("surface, GPU\u{a0}ms", Figure(SURFACE_GPU_MS)),
    ("surface bytes", Count(SURFACE_BYTES)),
    ("stencil, GPU\u{a0}ms", Figure(STENCIL_GPU_MS)),
    ("colour, GPU\u{a0}ms", Figure(COLOUR_GPU_MS)),
    ("geometry bytes", Count(GEOMETRY_BYTES)),
    ("vertex bytes", Count(VERTEX_BYTES)),
    ("index bytes", Count(INDEX_BYTES)),
    ("constant bytes", Count(CONSTANT_BYTES)),
    ("target bytes", Count(TARGET_BYTES)),
    ("to prepare, CPU\u{a0}ms", Figure(PREPARE_CPU_MS)),
    ("draws", Count(DRAWS)),
    ("vertices", Count(VERTICES)),
    ("regions left out", Count(REGIONS_LEFT_OUT)),
    ("px that differ", Count(MISMATCHED_PX)),
    ("outside band", Count(MISMATCHED_PX_OUTSIDE_BAND)),
    ("Hausdorff, px", Figure(HAUSDORFF_PX)),
    ("moved, px", Figure(BOUNDARY_MOVED_PX)),
    ("by the surface, px", Figure(MOVED_PX_TRUE)),
    ("boundary,\u{a0}m", Figure(BOUNDARY_DEVIATION_M)),
];

/// Every scene.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let clock = data.run.clock().name();
    let mut blocks = Vec::new();
    for views in data.scenes() {
        let scene = views[0].scene;
        blocks.push(Block::section(scene));
        let caption = format!(
            "By {clock}: each right fill over its view's fastest, medians over processes. Points of sweeps and \
             approximate fills compete with none and stand in the plots of error against run time. Whiskers: 95 % \
             interval, where there are five processes or more. Shaded: ties. Dashed: the depth-pass of that view, \
             a full-screen pass that reads depth and writes a constant colour; a yardstick, not a bound. A cross \
             at the right edge has no time that counts."
        );
        blocks.extend(plot(caption, ratio_plot(data, views)?));
        blocks.extend(published::blocks(data, views));
        let pictures: Vec<_> = views.iter().map(|view| pictures(data, view)).collect();
        if pictures.iter().any(Option::is_some) {
            blocks.push(Block::Remark(DIFFERENCE_KEY.to_owned()));
        }
        for (view, pictures) in views.iter().zip(pictures) {
            blocks.push(part(view.title()));
            blocks.extend(pictures.map(Block::Pictures));
            blocks.push(Block::Table(cases(data, view)));
            blocks.extend(left_out(view));
            blocks.extend(error_time::of_view(data, view)?);
        }
    }
    Ok(blocks)
}

/// Each case that competes over the fastest right one of its view, fastest first.
fn ratio_plot(data: &Data<'_>, views: &[View<'_>]) -> Result<Option<String>, ChapterError> {
    let groups = views.iter().map(|view| {
        let best = data.fastest(view.competing());
        let ratio = |case: &Case| data.over_fastest(case, best?);
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
        title: format!("{}: fill time over the fastest", views[0].scene),
        axis: RatioAxis {
            title: &title,
            one: "fastest = 1",
        },
        tie_factor: data.noise.map(|noise| noise.max_factor()),
        groups: groups.collect(),
    };
    Ok(plot.draw(data.palette())?)
}

fn ratio_row(data: &Data<'_>, case: &Case, ratio: Option<Estimate>) -> RatioRow {
    let whisker = ratio.map(|ratio| {
        let [p5, p95] = ratio.interval.unwrap_or([ratio.middle; 2]);
        let median = ratio.middle;
        Spread { p5, median, p95 }
    });
    let time = data.typical(case).map(|time| significant(time.middle));
    // The ratio is of medians, so a process stands as far from it as its time from the median.
    let processes = ratio.zip(data.typical(case)).map(|(ratio, typical)| {
        let times = data.replicates(case).into_iter();
        times
            .map(|time| ratio.middle * time / typical.middle)
            .collect()
    });
    RatioRow {
        label: data.label(case),
        series: data.marked(case),
        ratio: whisker.ok_or_else(|| no_ratio(data, case)),
        processes: processes.unwrap_or_default(),
        value: time.map_or_else(String::new, |time| format!(" · {time} ms")),
        command: data.command(case),
    }
}

fn cases(data: &Data<'_>, view: &View<'_>) -> Table {
    let all = view.baselines.iter().chain(&view.cases).chain(&view.rivals);
    let fastest = data.fastest(view.competing());
    let rows = all.clone().map(|case| {
        let (label, name) = (data.label(case), name(case));
        // Of what is approximate, the value that tells it from others of its technique.
        let detail = match setting(case, view).filter(|_| is_approximate(case)) {
            Some(setting) => setting.to_owned(),
            None if name == label => String::new(),
            None => name,
        };
        let cell = Cell {
            detail,
            ..data.name_cell(case, label)
        };
        let counts = case.counts() || is_approximate(case) || is_rival(case);
        let over = fastest.filter(|_| counts);
        let over = over.and_then(|fastest| over_typical(case, fastest, data.metric));
        let why = match case.reason.as_str() {
            "" => "it is not right or was not timed, or no fill of this view is",
            reason => reason,
        };
        (
            *case,
            vec![cell, Cell::or_absent(over.map(|over| times(&over)), why)],
        )
    });
    let mut table = table(data, &COLUMNS, rows);
    for (row, case) in table.rows.iter_mut().zip(all) {
        row.remark.clone_from(&case.reason);
    }
    table
}

/// One of a case's pictures, if it has it.
pub(crate) fn picture(case: &Case, note: &str, caption: impl Into<String>) -> Option<Picture> {
    let path = case.note(note);
    (!path.is_empty()).then(|| Picture {
        path: path.to_owned(),
        caption: caption.into(),
    })
}

/// The reference's picture, then each case's beside its difference and its worst pixel. Wrong cases
/// of the ladder and the matrix are among them: their own tables have no room for pictures.
fn pictures(data: &Data<'_>, view: &View<'_>) -> Option<Pictures> {
    let listed = || view.cases.iter().chain(&view.rivals).copied();
    let all = data.of_view([view.scene, view.name]).iter().copied();
    let wrong = all.filter(|case| {
        // Textured fills have their pictures in their own section.
        case.outcome == Outcome::Wrong
            && !has_role(case, "texture")
            && !listed().any(|listed| listed.id() == case.id())
    });
    let cases: Vec<&Case> = listed().chain(wrong).collect();
    let mut references = cases.iter();
    let reference = references.find_map(|case| picture(case, "reference_image", "reference"));
    let own = cases.iter().filter_map(|case| {
        // Where nothing differs, a difference shows nothing.
        let differs = counter(case, MISMATCHED_PX) != Some(0);
        let worst = format!("worst pixel ({})", case.note("worst_px"));
        let pictures = [
            picture(case, "image", "picture"),
            picture(case, "difference_image", "difference").filter(|_| differs),
            picture(case, "worst_image", worst).filter(|_| differs),
        ];
        let pictures: Vec<Picture> = pictures.into_iter().flatten().collect();
        (!pictures.is_empty()).then(|| PictureFigure {
            pictures,
            notes: vec![caption(case)],
        })
    });
    // A committed run leaves pictures out, and a worst pixel cannot be laid over the whole.
    let has_pictures = cases.iter().any(|case| !case.note("image").is_empty());
    let laid_over = reference.as_ref().filter(|_| has_pictures);
    let laid_over = laid_over.map_or_else(String::new, |picture| picture.path.clone());
    let reference = reference.map(|reference| PictureFigure {
        pictures: vec![reference],
        notes: Vec::new(),
    });
    let figures: Vec<PictureFigure> = reference.into_iter().chain(own).collect();
    (!figures.is_empty()).then_some(Pictures {
        reference: laid_over,
        figures,
        ..Pictures::default()
    })
}

fn caption(case: &Case) -> String {
    let counted = |metric| or_dash(counter(case, metric).map(count));
    let mut text = format!(
        "{}{}: {} px differ, {} of them outside the band, Hausdorff distance {} px",
        name(case),
        match case.outcome {
            Outcome::Ok => String::new(),
            _ => format!(" ({})", standing(case)),
        },
        counted(MISMATCHED_PX),
        counted(MISMATCHED_PX_OUTSIDE_BAND),
        or_dash(case.value(HAUSDORFF_PX).map(significant)),
    );
    if let Some(px) = case.value(BOUNDARY_MOVED_PX) {
        text.push_str(&format!(", moved {} px", significant(px)));
    }
    if let Some(px) = counter(case, FOREIGN_PX).filter(|px| *px > 0) {
        text.push_str(&format!(", {} foreign", count(px)));
    }
    text
}

/// Frame plans that left something out, equal ones together.
fn left_out(view: &View<'_>) -> Option<Block> {
    let cases = view.cases.iter().copied();
    let cases = cases.filter(|case| !case.note("left_out").is_empty());
    let groups = grouped(cases, |case| case.note("left_out")).into_iter();
    let lines = groups.map(|(text, cases)| {
        let cases: Vec<String> = cases.into_iter().map(name).collect();
        format!("{}: {text}", cases.join("; "))
    });
    let lines: Vec<String> = lines.collect();
    (!lines.is_empty()).then(|| Block::Folded {
        summary: "What the frame plans left out, by reason".to_owned(),
        is_open: false,
        blocks: vec![Block::List(lines)],
    })
}
