// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every scene with its views: plots, tables of all cases, and pictures beside the reference's.

use super::data::{
    DEPTH_PASS, Data, STENCIL_PASS, Scene, View, competes, counter, has_role, is_approximate,
    is_baseline, is_rival, name, standing,
};
use super::ladder::no_ratio;
use super::{error_time, memory, published};
use crate::keys::{
    BOUNDARY_DEVIATION_M, BOUNDARY_MOVED_PX, COLOUR_GPU_MS, CONSTANT_BYTES, DRAWS, FILL_CPU_MS,
    FILL_GPU_MS, FOREIGN_PX, GEOMETRY_BYTES, HAUSDORFF_PX, INDEX_BYTES, MISMATCHED_PX,
    MISMATCHED_PX_OUTSIDE_BAND, MOVED_PX_TRUE, REGIONS_LEFT_OUT, SCENE, STENCIL_GPU_MS,
    SURFACE_BYTES, SURFACE_GPU_MS, TECHNIQUE, VERTEX_BYTES, VERTICES, VIEW,
};
use terrafill_plot::number::{bytes, count, significant, spread};
use terrafill_plot::{Bar, Bars, Palette, RatioAxis, RatioGroup, RatioPlot, RatioRow, dotted};
use terrafill_results::{
    Block, Case, Cell, CellClass, ChapterError, Estimate, Heading, Metric, Outcome, Picture,
    PictureFigure, Pictures, Plot, Row, Spread, Table, sample_spread,
};

const NO_GPU_TIME: &str = "the device gave no GPU time";
const NO_PASS_TIME: &str = "no GPU time of its own: stencil and colour alternate region by region, or the device gave none";
const NOT_COUNTED: &str = "not counted by this technique";
const NOT_COMPARED: &str = "not compared with the reference";
const NOT_RECORDED: &str = "not recorded by this run";

/// Key of the pictures of differences, as `terrafill-conformance` draws them.
const DIFFERENCE_KEY: &str = "Pictures: the reference, and every picture, those that are the same once. A \
    difference is shown where a pixel differs: grey, both fill with the same region; dark, neither \
    fills; a shade apart, the 1-pixel boundary band; orange, differs within the band; red, differs \
    outside it. Differing pixels are drawn 3 × 3. Worst pixel: the one furthest from the reference's \
    boundary, framed in white, with 24 × 24 pixels around it, from left to right the reference, the \
    picture and the difference. A picture that is chosen by Tab or click fills the window.";

/// How a metric is printed.
#[derive(Clone, Copy)]
enum Print {
    /// Three digits; a time counts for nothing when the picture is wrong.
    Time,
    /// Three digits.
    Figure,
    /// Every digit.
    Count,
}

/// Columns after those by the run's clock: heading, metric, how it is printed, and why a case that is
/// right may lack it.
const COLUMNS: [(&str, &Metric, Print, &str); 14] = [
    (
        "surface, GPU\u{a0}ms",
        SURFACE_GPU_MS,
        Print::Time,
        "the technique draws a surface of its own, untimed, or the device gave no GPU time",
    ),
    ("surface bytes", SURFACE_BYTES, Print::Count, NOT_COUNTED),
    (
        "stencil, GPU\u{a0}ms",
        STENCIL_GPU_MS,
        Print::Time,
        NO_PASS_TIME,
    ),
    (
        "colour, GPU\u{a0}ms",
        COLOUR_GPU_MS,
        Print::Time,
        NO_PASS_TIME,
    ),
    ("geometry bytes", GEOMETRY_BYTES, Print::Count, NOT_COUNTED),
    ("draws", DRAWS, Print::Count, NOT_COUNTED),
    ("vertices", VERTICES, Print::Count, NOT_COUNTED),
    (
        "regions left out",
        REGIONS_LEFT_OUT,
        Print::Count,
        NOT_RECORDED,
    ),
    ("px that differ", MISMATCHED_PX, Print::Count, NOT_COMPARED),
    (
        "outside band",
        MISMATCHED_PX_OUTSIDE_BAND,
        Print::Count,
        NOT_COMPARED,
    ),
    (
        "Hausdorff, px",
        HAUSDORFF_PX,
        Print::Figure,
        "one of the two pictures has no boundary, or they were not compared",
    ),
    (
        "moved, px",
        BOUNDARY_MOVED_PX,
        Print::Figure,
        "only levels of detail move boundaries on purpose; or too many pixels mismatch to compare",
    ),
    (
        "by the surface, px",
        MOVED_PX_TRUE,
        Print::Figure,
        "the surface does not say where the ground truly is, or they were not compared",
    ),
    (
        "boundary,\u{a0}m",
        BOUNDARY_DEVIATION_M,
        Print::Figure,
        NOT_RECORDED,
    ),
];

/// Views with their fastest right technique.
pub(super) fn overview(data: &Data<'_>) -> Option<Block> {
    let mut rows = Vec::new();
    for scene in data.scenes() {
        for view in &scene.views {
            rows.extend(overview_row(data, scene.name, view));
        }
    }
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: format!(
                "The fastest right technique of each view by {}. A tie differs from it by no more than \
                 identical work did.",
                data.run.clock().name()
            ),
            headings: vec![
                Heading::plain("scene, view"),
                Heading::plain("right of all"),
                Heading::plain("fastest"),
                Heading::metric(format!("fill, {}", data.unit()), data.metric),
                Heading::plain("÷\u{a0}depth-pass"),
                Heading::plain("÷\u{a0}stencil-pass"),
                Heading::plain("ties"),
            ],
            rows,
            is_main: true,
            ..Table::default()
        })
    })
}

fn overview_row(data: &Data<'_>, scene: &str, view: &View<'_>) -> Option<Row> {
    let all = view.cases.iter().copied().filter(|case| competes(case));
    let right = all.clone().filter(|case| case.counts());
    let fastest = best(data, view)?;
    let time = data.typical(fastest)?;
    let ties = right
        .clone()
        .filter(|case| case.id() != fastest.id() && data.ties_with(case, fastest));
    let ties: Vec<String> = ties.map(name).collect();
    let over = |technique| {
        let ratio = data.over_baseline(fastest, technique);
        data.ratio_cell(ratio.as_ref(), "this pass was not measured")
    };
    Some(Row::new(vec![
        Cell::name(format!("{scene}, {}", view.name)),
        Cell::plain(format!("{} of {}", right.count(), all.count())),
        Cell::name(name(fastest)),
        Cell::plain(significant(time.middle)),
        over(DEPTH_PASS),
        over(STENCIL_PASS),
        match data.noise {
            Some(_) => Cell::name(ties.join("; ")),
            None => Cell::absent("no identical work was measured twice"),
        },
    ]))
}

/// Every scene.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let palette = Palette::new(data.all_series());
    let mut blocks = Vec::new();
    for scene in data.scenes() {
        blocks.push(Block::section(scene.name));
        if let Some(svg) = ratio_plot(data, &scene, &palette)? {
            blocks.push(Block::Plot(Plot {
                caption: format!(
                    "{} of each right fill over that of its view's fastest: the medians over \
                     processes, one over the other. Points of sweeps and approximate fills compete with \
                     none and stand in the plots of error against run time. \
                     Whiskers: 95 % interval, where there are five processes or more. Shaded: ties. \
                     Dashed: the depth-pass of that view, a full-screen pass that reads depth and \
                     writes a constant colour; a yardstick, not a bound. A cross at the right edge has \
                     no time that counts.",
                    sentence(data.run.clock().name())
                ),
                svg,
            }));
        }
        if let Some(svg) = bytes_plot(data, &scene, &palette)? {
            blocks.push(Block::Plot(Plot {
                caption:
                    "Bytes per variant. Printed: geometry (positions, flags, indices) and its \
                          ratio to vertex/doubled where that was measured."
                        .to_owned(),
                svg,
            }));
        }
        blocks.extend(published::blocks(data, &scene));
        let has_pictures = |view| pictures(data, &scene, view).is_some();
        if scene.views.iter().any(has_pictures) {
            blocks.push(Block::Remark(DIFFERENCE_KEY.to_owned()));
        }
        for view in &scene.views {
            blocks.extend(view_blocks(data, &scene, view, &palette)?);
        }
    }
    Ok(blocks)
}

/// Each case that competes over the fastest right one of its view, fastest first.
fn ratio_plot(
    data: &Data<'_>,
    scene: &Scene<'_>,
    palette: &Palette,
) -> Result<Option<String>, ChapterError> {
    let groups = scene.views.iter().map(|view| {
        let best = best(data, view);
        let ratio = |case: &Case| data.over_fastest(case, best?);
        let mut cases = view.cases.clone();
        cases.retain(|case| competes(case));
        let order = |case: &Case| ratio(case).map_or(f64::INFINITY, |ratio| ratio.middle);
        cases.sort_by(|a, b| order(a).total_cmp(&order(b)));
        let dashed = view.baselines.iter().find_map(|pass| {
            let ratio = ratio(pass).filter(|_| pass.condition(TECHNIQUE) == DEPTH_PASS)?;
            let name = format!("depth-pass {} × (dashed)", significant(ratio.middle));
            Some((ratio.middle, name))
        });
        RatioGroup {
            name: view.name.to_owned(),
            dashed,
            rows: cases
                .into_iter()
                .map(|case| ratio_row(data, case, ratio(case)))
                .collect(),
        }
    });
    let title = format!(
        "{} of the fill ÷ that of the view's fastest (logarithmic)",
        data.run.clock().name()
    );
    let plot = RatioPlot {
        title: format!("{}: fill time over the fastest", scene.name),
        axis: RatioAxis {
            title: &title,
            one: "fastest = 1",
        },
        tie_factor: data.noise.map(|noise| noise.max_factor()),
        groups: groups.collect(),
    };
    Ok(plot.draw(palette)?)
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

/// The fastest right fill of a view.
pub(super) fn best<'a>(data: &Data<'a>, view: &View<'a>) -> Option<&'a Case> {
    data.fastest(view.cases.iter().copied().filter(|case| competes(case)))
}

/// With a capital.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(letters).collect()
}

/// What one variant holds, largest over the scene's views: geometry is the same in all of them,
/// per-view constants vary.
fn bytes_plot(
    data: &Data<'_>,
    scene: &Scene<'_>,
    palette: &Palette,
) -> Result<Option<String>, ChapterError> {
    let mut variants: Vec<(&Case, [u64; 3], u64)> = Vec::new();
    for case in scene.views.iter().flat_map(|view| &view.cases) {
        let Some(geometry) = counter(case, GEOMETRY_BYTES) else {
            continue;
        };
        let index = counter(case, INDEX_BYTES).unwrap_or(0);
        let vertex = counter(case, VERTEX_BYTES).unwrap_or(geometry.saturating_sub(index));
        let parts = [vertex, index, counter(case, CONSTANT_BYTES).unwrap_or(0)];
        match variants
            .iter_mut()
            .find(|(known, ..)| name(known) == name(case))
        {
            Some((_, most, of)) if parts.iter().sum::<u64>() > most.iter().sum() => {
                (*most, *of) = (parts, geometry);
            }
            Some(_) => {}
            None => variants.push((case, parts, geometry)),
        }
    }
    let base = variants
        .iter()
        .find(|(case, ..)| name(case) == memory::BASE);
    let base = base
        .map(|(_, _, geometry)| *geometry)
        .filter(|base| *base > 0);
    let rows = variants.iter().map(|(case, parts, geometry)| Bar {
        label: data.label(case),
        series: data.marked(case),
        parts: *parts,
        value: match base {
            Some(base) => {
                let ratio = significant(*geometry as f64 / base as f64);
                format!("{} · {ratio} ×", bytes(*geometry))
            }
            None => bytes(*geometry),
        },
        command: data.command(case),
    });
    let bars = Bars {
        title: format!("{}: bytes per variant", scene.name),
        axis: "bytes on the device, largest over the views",
        parts: ["positions and flags", "indices", "constants per view"],
        rows: rows.collect(),
    };
    Ok(bars.draw(palette)?)
}

fn view_blocks(
    data: &Data<'_>,
    scene: &Scene<'_>,
    view: &View<'_>,
    palette: &Palette,
) -> Result<Vec<Block>, ChapterError> {
    let mut blocks = vec![Block::Heading {
        level: 4,
        text: format!("{}, {}", scene.name, view.name),
    }];
    blocks.extend(pictures(data, scene, view).map(Block::Pictures));
    blocks.push(Block::Table(table(data, palette, view)));
    blocks.extend(left_out(view));
    if let Some((svg, not_drawn)) = error_time::plot(data, scene.name, view, palette)? {
        let not_drawn = match not_drawn.is_empty() {
            true => String::new(),
            false => format!(" Not drawn: {}.", not_drawn.join("; ")),
        };
        blocks.push(Block::Plot(Plot {
            caption: format!(
                "Error against run time; one curve per layout through its boundary tolerance, which \
                 labels the points. Zero errors stand on the line at the bottom; wrong and failed cases \
                 (crosses) are pinned to the upper edge, except those whose error is the question, \
                 which stand at it; open marks are approximate fills. Ringed and joined by dashes: the Pareto front, where at least 95 % of \
                 bootstrap resamples of the processes keep it.{not_drawn}"
            ),
            svg,
        }));
    }
    Ok(blocks)
}

fn table(data: &Data<'_>, palette: &Palette, view: &View<'_>) -> Table {
    let clock = data.run.clock();
    let other = clock.pick(
        ("fill, CPU\u{a0}ms", FILL_CPU_MS),
        ("fill, GPU\u{a0}ms", FILL_GPU_MS),
    );
    let mut headings = vec![
        Heading::plain("case"),
        Heading::plain("status"),
        Heading::metric(format!("fill, {} (5–95 %)", data.unit()), data.metric),
        Heading::explained(
            "÷\u{a0}depth-pass",
            "over the full-screen pass that reads depth, paired by process",
        ),
        Heading::explained(
            "÷\u{a0}stencil-pass",
            "over the full-screen pass that clears and tests the stencil, paired by process",
        ),
        Heading::metric(other.0, other.1),
    ];
    headings.extend(COLUMNS.map(|(text, metric, ..)| Heading::metric(text, metric)));
    let cases = view.baselines.iter().chain(&view.cases);
    let cases = cases.chain(&view.rivals);
    Table {
        rows: cases
            .map(|case| row(data, palette, case, other.1))
            .collect(),
        headings,
        ..Table::default()
    }
}

fn row(data: &Data<'_>, palette: &Palette, case: &Case, other_metric: &Metric) -> Row {
    let over = |technique| match data.over_baseline(case, technique) {
        Some(ratio) => Cell::plain(significant(ratio.middle)),
        None => absent(case, "this pass was not measured in this run"),
    };
    let mut cells = vec![
        Cell {
            marker: match is_baseline(case) {
                true => String::new(),
                false => palette.marker(&data.marked(case)),
            },
            command: data.command(case),
            detail: match name(case) {
                name if name == data.label(case) => String::new(),
                name => name,
            },
            ..Cell::name(data.label(case))
        },
        Cell::plain(standing(case)),
        time_cell(
            case,
            data.metric,
            data.time(case).map(spread),
            "no frame was timed",
        ),
        over(DEPTH_PASS),
        over(STENCIL_PASS),
        time_cell(
            case,
            other_metric,
            sample_spread(case, other_metric).map(|ms| significant(ms.median)),
            NO_GPU_TIME,
        ),
    ];
    cells.extend(COLUMNS.map(|(_, metric, print, why)| {
        let value = case.value(metric);
        match print {
            Print::Time => time_cell(case, metric, value.map(significant), why),
            Print::Figure => value.map_or_else(
                || absent(case, why),
                |value| Cell::plain(significant(value)),
            ),
            Print::Count => counter(case, metric)
                .map_or_else(|| absent(case, why), |value| Cell::plain(count(value))),
        }
    }));
    Row {
        cells,
        status: standing(case).to_owned(),
        remark: case.reason.clone(),
    }
}

/// A time, which counts for nothing when the picture is wrong.
fn time_cell(case: &Case, metric: &Metric, text: Option<String>, why: &str) -> Cell {
    let cell = match text {
        Some(text) if is_approximate(case) => Cell {
            title: "approximate: its picture differs by nature, and it competes with none"
                .to_owned(),
            ..Cell::plain(text)
        },
        // A rival's error is part of the answer, and stands beside its time.
        Some(text) if case.outcome == Outcome::Wrong && !is_rival(case) => Cell {
            class: CellClass::Void,
            title: "the picture is wrong: this time counts for nothing".to_owned(),
            ..Cell::plain(text)
        },
        Some(text) => Cell::plain(text),
        None => absent(case, why),
    };
    dotted(cell, case, metric)
}

fn absent(case: &Case, why: &str) -> Cell {
    Cell::absent(match (case.outcome, case.reason.as_str()) {
        (Outcome::Ok, _) if is_baseline(case) => "does not apply to a full-screen pass".to_owned(),
        (Outcome::Ok, _) => why.to_owned(),
        (outcome, "") => format!("{}, no reason was recorded", outcome.name()),
        (outcome, reason) => format!("{}: {reason}", outcome.name()),
    })
}

/// The reference's picture, then each case's beside its difference and its worst pixel. Wrong cases
/// of the ladder and the matrix are among them: their own tables have no room for pictures.
fn pictures(data: &Data<'_>, scene: &Scene<'_>, view: &View<'_>) -> Option<Pictures> {
    let picture = |case: &Case, note: &str, caption: String| {
        let path = case.note(note);
        (!path.is_empty()).then(|| Picture {
            path: path.to_owned(),
            caption,
        })
    };
    let listed: Vec<&Case> = view.cases.iter().chain(&view.rivals).copied().collect();
    let wrong = data.cases.iter().copied().filter(|case| {
        let is_here = case.condition(SCENE) == scene.name && case.condition(VIEW) == view.name;
        // Textured fills have their pictures in their own section.
        is_here
            && case.outcome == Outcome::Wrong
            && !has_role(case, "texture")
            && !listed.iter().any(|listed| listed.id() == case.id())
    });
    let cases: Vec<&Case> = listed.iter().copied().chain(wrong).collect();
    let reference = cases
        .iter()
        .find_map(|case| picture(case, "reference_image", "reference".to_owned()))
        .map(|reference| PictureFigure {
            pictures: vec![reference],
            notes: Vec::new(),
        });
    let own = cases.iter().filter_map(|case| {
        // Where nothing differs, a difference shows nothing.
        let differs = counter(case, MISMATCHED_PX) != Some(0);
        let worst = format!("worst pixel ({})", case.note("worst_px"));
        let pictures = [
            picture(case, "image", "picture".to_owned()),
            picture(case, "difference_image", "difference".to_owned()).filter(|_| differs),
            picture(case, "worst_image", worst).filter(|_| differs),
        ];
        let pictures: Vec<Picture> = pictures.into_iter().flatten().collect();
        (!pictures.is_empty()).then(|| PictureFigure {
            pictures,
            notes: vec![caption(case)],
        })
    });
    let path = reference
        .as_ref()
        .and_then(|figure| figure.pictures.first());
    // A committed run leaves pictures out, and a worst pixel cannot be laid over the whole.
    let has_pictures = cases.iter().any(|case| !case.note("image").is_empty());
    let path = path.filter(|_| has_pictures);
    let path = path.map_or_else(String::new, |picture| picture.path.clone());
    let figures: Vec<PictureFigure> = reference.into_iter().chain(own).collect();
    (!figures.is_empty()).then_some(Pictures {
        reference: path,
        figures,
        ..Pictures::default()
    })
}

fn caption(case: &Case) -> String {
    let counted = |metric| counter(case, metric).map_or_else(|| "–".to_owned(), count);
    let mut text = format!(
        "{}{}: {} px differ, {} of them outside the band, Hausdorff distance {} px",
        name(case),
        match case.outcome {
            Outcome::Ok => String::new(),
            _ => format!(" ({})", standing(case)),
        },
        counted(MISMATCHED_PX),
        counted(MISMATCHED_PX_OUTSIDE_BAND),
        case.value(HAUSDORFF_PX)
            .map_or_else(|| "–".to_owned(), significant),
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
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for case in view
        .cases
        .iter()
        .filter(|case| !case.note("left_out").is_empty())
    {
        let text = case.note("left_out");
        match groups.iter_mut().find(|(known, _)| *known == text) {
            Some((_, cases)) => cases.push(name(case)),
            None => groups.push((text, vec![name(case)])),
        }
    }
    let lines = groups
        .iter()
        .map(|(text, cases)| format!("{}: {text}", cases.join("; ")));
    let lines: Vec<String> = lines.collect();
    (!lines.is_empty()).then(|| Block::Folded {
        summary: "What the frame plans left out, by reason".to_owned(),
        is_open: false,
        blocks: vec![Block::List(lines)],
    })
}
