// SPDX-License-Identifier: MIT OR Apache-2.0
//! The report as a page: everything worded and formatted here, laid out by `templates/report.html`.

use crate::exponent::{self, GrowthTable};
use crate::ladder::{self, LadderTable};
use crate::matrix::{self, MatrixTable};
use crate::memory::{self, MemoryChapter};
use crate::number::{bytes, count, significant, utc};
use crate::pairs::{self, PairRow};
use crate::picture::{Picture, embed};
use crate::plot::{self, Palette};
use crate::precision::{self, PrecisionChapter, Table};
use crate::run_data::{Case, Outcome, RunData, SceneCases, ViewCases};
use crate::subdivision::{self, SubdivisionTable};
use crate::textured::{self, TexturedChapter};
use crate::{ReportError, glossary, growth, published};
use askama::Template;

/// A column of the case tables.
pub(crate) struct Column {
    /// Its entry in `GLOSSARY.md`.
    pub(crate) term: &'static str,
    heading: &'static str,
    cell: fn(&Case) -> Option<String>,
    /// A time, which counts for nothing when the picture is wrong.
    is_time: bool,
    /// Why a case that is right may lack it.
    absent_because: &'static str,
}

const NO_GPU_TIME: &str = "the device gave no GPU time";
const NO_PASS_TIME: &str = "no GPU time of its own: stencil and colour alternate region by region, or the device gave none";
const NOT_COUNTED: &str = "not counted by this backend";
const NOT_COMPARED: &str = "not compared with the reference";

/// The columns, left to right.
pub(crate) const COLUMNS: [Column; 16] = [
    Column {
        term: "fill_cpu_ms",
        heading: "fill, CPU ms",
        cell: fill_cpu_cell,
        is_time: true,
        absent_because: "no frame was timed",
    },
    Column {
        term: "fill_over_bound_cpu",
        heading: "÷\u{a0}bound",
        cell: |case| case.value(|row| row.fill_over_bound_cpu).map(significant),
        is_time: true,
        absent_because: "no bound was measured in this run",
    },
    Column {
        term: "fill over floor",
        heading: "÷\u{a0}floor",
        cell: |case| {
            case.value(|row| Some(row.fill_cpu_ms? / row.floor_cpu_ms?))
                .map(significant)
        },
        is_time: true,
        absent_because: "no floor was measured in this run",
    },
    Column {
        term: "fill_gpu_ms",
        heading: "fill, GPU\u{a0}ms",
        cell: |case| case.value(|row| row.fill_gpu_ms).map(significant),
        is_time: true,
        absent_because: NO_GPU_TIME,
    },
    Column {
        term: "surface_gpu_ms",
        heading: "surface, GPU\u{a0}ms",
        cell: |case| case.value(|row| row.surface_gpu_ms).map(significant),
        is_time: true,
        absent_because: NO_GPU_TIME,
    },
    Column {
        term: "stencil_gpu_ms",
        heading: "stencil, GPU\u{a0}ms",
        cell: |case| case.value(|row| row.stencil_gpu_ms).map(significant),
        is_time: true,
        absent_because: NO_PASS_TIME,
    },
    Column {
        term: "colour_gpu_ms",
        heading: "colour, GPU\u{a0}ms",
        cell: |case| case.value(|row| row.colour_gpu_ms).map(significant),
        is_time: true,
        absent_because: NO_PASS_TIME,
    },
    Column {
        term: "geometry_bytes",
        heading: "geometry bytes",
        cell: |case| case.value(|row| row.geometry_bytes).map(count),
        is_time: false,
        absent_because: NOT_COUNTED,
    },
    Column {
        term: "draws",
        heading: "draws",
        cell: |case| case.value(|row| row.draws).map(count),
        is_time: false,
        absent_because: NOT_COUNTED,
    },
    Column {
        term: "vertices",
        heading: "vertices",
        cell: |case| case.value(|row| row.vertices).map(count),
        is_time: false,
        absent_because: NOT_COUNTED,
    },
    Column {
        term: "regions_left_out",
        heading: "regions left out",
        cell: |case| case.value(|row| row.regions_left_out).map(count),
        is_time: false,
        absent_because: "not recorded by this run",
    },
    Column {
        term: "mismatched_px",
        heading: "wrong px",
        cell: |case| case.value(|row| row.mismatched_px).map(count),
        is_time: false,
        absent_because: NOT_COMPARED,
    },
    Column {
        term: "mismatched_px_outside_band",
        heading: "outside band",
        cell: |case| case.value(|row| row.mismatched_px_outside_band).map(count),
        is_time: false,
        absent_because: NOT_COMPARED,
    },
    Column {
        term: "hausdorff_px",
        heading: "Hausdorff, px",
        cell: |case| case.value(|row| row.hausdorff_px).map(significant),
        is_time: false,
        absent_because: "one of the two pictures has no boundary, or they were not compared",
    },
    Column {
        term: "boundary_moved_px",
        heading: "moved, px",
        cell: |case| case.value(|row| row.boundary_moved_px).map(significant),
        is_time: false,
        absent_because: "boundaries are drawn aside by levels of detail alone; or more pixels mismatch \
                         than are asked about",
    },
    Column {
        term: "boundary_deviation_m",
        heading: "boundary,\u{a0}m",
        cell: |case| case.value(|row| row.boundary_deviation_m).map(significant),
        is_time: false,
        absent_because: "not recorded by this run",
    },
];

/// Words of the plots that are no CSV columns.
#[cfg(test)]
pub(crate) const PLOT_TERMS: [&str; 14] = [
    "case",
    "bound",
    "floor",
    "time over bound",
    "whisker",
    "curve",
    "knob",
    "slope 1",
    "growth ratio",
    "zero line",
    "upper edge",
    "Pareto front",
    "boundary band",
    "geometry ratio",
];

#[derive(Template)]
#[template(path = "report.html")]
struct Page {
    verdict: Verdict,
    missing: Vec<String>,
    skipped_scenes: Vec<(String, String)>,
    notes: Vec<String>,
    environment: Vec<(&'static str, String)>,
    ladders: Vec<LadderTable>,
    ladder_source: &'static str,
    pairs: Vec<PairRow>,
    pair_headings: Vec<&'static str>,
    matrices: Vec<MatrixTable>,
    memory: Option<MemorySection>,
    precision: Option<PrecisionSection>,
    subdivision: Option<SubdivisionSection>,
    textured: Option<TexturedChapter>,
    exponent: Option<GrowthTable>,
    scenes: Vec<SceneSection>,
    growth: GrowthSection,
    glossary: Vec<(&'static str, String)>,
    dark_rules: String,
}

/// The memory chapter with its plots.
struct MemorySection {
    chapter: MemoryChapter,
    published: String,
    plots: Vec<(String, String)>,
}

/// The chapter on subdivision with its plot.
struct SubdivisionSection {
    plot: Option<String>,
    tables: Vec<SubdivisionTable>,
}

/// The chapter on precision with its plots, each with its caption.
struct PrecisionSection {
    chapter: PrecisionChapter,
    least_ns: String,
    plots: Vec<(String, String)>,
    tables: Vec<(&'static str, &'static str, &'static str, Table)>,
}

struct Verdict {
    class: &'static str,
    sentences: Vec<String>,
}

/// How the cost of a mesh grows with its outline.
struct GrowthSection {
    plot: Option<String>,
    bound: f64,
    rows: Vec<GrowthTableRow>,
}

struct GrowthTableRow {
    shape: String,
    /// Medians at the two sizes of the ratio, then the ratio; with the reason where one is absent.
    cells: Vec<String>,
    is_above: bool,
}

struct SceneSection {
    name: String,
    anchor: String,
    ratio_plot: Option<String>,
    bytes_plot: Option<String>,
    published: Option<PublishedTable>,
    views: Vec<ViewSection>,
}

struct ViewSection {
    name: String,
    anchor: String,
    reference: Option<Picture>,
    pictures: Vec<PictureGroup>,
    picture_problems: Vec<String>,
    headings: Vec<Heading>,
    rows: Vec<Row>,
    footnotes: Vec<String>,
    left_out: Vec<LeftOut>,
    error_plot: Option<String>,
    not_drawn: Vec<String>,
}

/// Cases whose pictures are the same to the byte.
#[derive(PartialEq)]
struct PictureGroup {
    picture: Option<Picture>,
    difference: Option<Picture>,
    captions: Vec<String>,
}

struct Heading {
    text: &'static str,
    meaning: String,
}

struct Row {
    /// The case's name, cut where a line may break.
    name_parts: Vec<String>,
    status: &'static str,
    cells: Vec<Cell>,
    reason: String,
}

/// Cases of a view whose plans left out the same.
struct LeftOut {
    cases: Vec<String>,
    text: String,
}

struct Cell {
    text: String,
    class: &'static str,
    title: String,
    /// Number of the footnote, from 1; 0 for none.
    footnote: usize,
}

struct PublishedTable {
    headings: [&'static str; 3],
    rows: Vec<PublishedRow>,
    source: &'static str,
    caveat: String,
}

struct PublishedRow {
    name_parts: Vec<String>,
    is_ours: bool,
    cells: Vec<String>,
}

/// Puts the page together.
///
/// # Errors
/// [`ReportError::Plot`], [`ReportError::Template`].
pub(crate) fn render(data: &RunData) -> Result<String, ReportError> {
    let palette = Palette::new(data.series());
    let scenes = data
        .scenes()
        .iter()
        .map(|scene| scene_section(data, scene, &palette))
        .collect::<Result<_, _>>()?;
    let page = Page {
        verdict: verdict(data),
        missing: names_of(data, Outcome::Missing),
        skipped_scenes: data.plan.skipped_scenes.clone(),
        notes: data.notes.clone(),
        environment: environment(data),
        ladders: ladders(data)?,
        ladder_source: ladder::SOURCE,
        pairs: pairs::rows(data),
        pair_headings: pairs::PAIRS.map(|pair| pair.heading).into(),
        matrices: matrix::tables(data),
        memory: memory_section(data)?,
        precision: precision_section(data)?,
        subdivision: subdivision_section(data)?,
        textured: textured::chapter(data),
        exponent: exponent::table(data),
        scenes,
        growth: growth_section(data)?,
        glossary: glossary::entries(),
        dark_rules: plot::dark_rules(),
    };
    Ok(page.render()?)
}

fn growth_section(data: &RunData) -> Result<GrowthSection, ReportError> {
    let rows = data.growth.iter().map(|curve| {
        let times = [curve.near(growth::RATIO_FROM), curve.near(growth::RATIO_TO)];
        let ratio = curve.ratio();
        let mut cells: Vec<String> = times
            .iter()
            .map(|time| time.map_or("not measured".to_owned(), |ms| significant(ms.median)))
            .collect();
        cells.push(ratio.map_or("not measured".to_owned(), significant));
        GrowthTableRow {
            shape: curve.shape.clone(),
            cells,
            is_above: ratio.is_some_and(|ratio| ratio > growth::STEEPEST_RATIO),
        }
    });
    Ok(GrowthSection {
        plot: plot::growth(&data.growth)?,
        bound: growth::STEEPEST_RATIO,
        rows: rows.collect(),
    })
}

fn ladders(data: &RunData) -> Result<Vec<LadderTable>, ReportError> {
    let mut tables = ladder::tables(data);
    for table in &mut tables {
        let rungs = ladder::rungs(data, &table.scene, &table.view, &table.ladder);
        table.plot = plot::ladder_steps(&table.title, &rungs)?;
    }
    Ok(tables)
}

fn memory_section(data: &RunData) -> Result<Option<MemorySection>, ReportError> {
    let Some(chapter) = memory::chapter(data) else {
        return Ok(None);
    };
    let mut plots = Vec::new();
    for table in &chapter.tables {
        let curves = memory::curves(data, &table.scene);
        if let Some(svg) = plot::bytes_over_regions(&table.scene, &curves)? {
            let most = memory::range_text(&curves);
            plots.push((
                format!("{}: its regions repeated in turn, to {most}.", table.scene),
                svg,
            ));
        }
    }
    Ok(Some(MemorySection {
        published: memory::published(),
        chapter,
        plots,
    }))
}

fn precision_section(data: &RunData) -> Result<Option<PrecisionSection>, ReportError> {
    let Some(mut chapter) = precision::chapter(data) else {
        return Ok(None);
    };
    let drawn = precision::plots(data);
    let mut names: Vec<String> = drawn
        .iter()
        .flat_map(|plot| plot.by_operations.iter().map(|curve| curve.name.clone()))
        .collect();
    names.sort_unstable();
    names.dedup();
    let palette = Palette::new(names);
    let mut plots = Vec::new();
    for plot in &drawn {
        if let Some(svg) = plot::precision(plot, chapter.clock, &palette)? {
            plots.push((format!("{}.", plot.title), svg));
        }
    }
    let tables = precision_tables(&mut chapter);
    Ok(Some(PrecisionSection {
        chapter,
        least_ns: significant(precision::LEAST_NS),
        plots,
        tables,
    }))
}

fn subdivision_section(data: &RunData) -> Result<Option<SubdivisionSection>, ReportError> {
    let mut tables = subdivision::tables(data);
    if tables.is_empty() {
        return Ok(None);
    }
    let mut take = |curves: fn(&mut SubdivisionTable) -> &mut Vec<plot::Curve>| {
        tables
            .iter_mut()
            .flat_map(|table| std::mem::take(curves(table)))
            .collect()
    };
    let plot = plot::subdivision(take(|t| &mut t.times), take(|t| &mut t.walls))?;
    Ok(Some(SubdivisionSection { plot, tables }))
}

fn precision_tables(
    chapter: &mut PrecisionChapter,
) -> Vec<(&'static str, &'static str, &'static str, Table)> {
    let mut take = |table: fn(&mut PrecisionChapter) -> &mut Table| {
        std::mem::replace(
            table(chapter),
            Table {
                headings: Vec::new(),
                rows: Vec::new(),
            },
        )
    };
    vec![
        (
            "precision-chosen",
            "What a plan takes",
            "The cheapest route whose computed residual is within ¼ texel and ¼ pixel RMS and ½ texel at \
             most, for terrain up to 9 km, with its measured RMS error in texels. Columns: extent. The \
             picture has 4096 texels a side, from 90° on 16,384; the view shows the region on 1,080 rows. \
             A dash: a region that is another one's already.",
            take(|c| &mut c.chosen),
        ),
        (
            "precision-position",
            "Position from depth",
            "Largest error of a fragment's offset from its region's anchor, on the device, over all extents \
             and latitudes, the anchor where a plan puts it for this eye; for the default also in the middle \
             of the region, so that what a plan's anchor is worth is seen. Pixels of a view of 60° on 1,080 \
             rows. Red: more than ¼ pixel somewhere.",
            take(|c| &mut c.positions),
        ),
        (
            "precision-vertex",
            "Position of a vertex",
            "Largest error of one component relative to the eye, in a region of 1°, by emulation. Red: \
             more than ¼ pixel somewhere.",
            take(|c| &mut c.vertices),
        ),
        (
            "precision-reasons",
            "Why formula and measurement part",
            "Rows whose measured and expected error part by more than twice, by reason.",
            take(|c| &mut c.reasons),
        ),
        (
            "precision-residual",
            "Formula against measurement",
            "Where measured and expected error part by more than twice, by family and reason. Expected is \
             the formula's own error and 2.5 standard deviations of its roundings, each correct and \
             independent; the bound that no error may exceed is another, and is checked above. Of \
             positions, root mean squares are compared.",
            take(|c| &mut c.disagreements),
        ),
        (
            "precision-special",
            "Where formulas break",
            "Inputs that are special to floating point or to the map. The last seven lines are \
             no fragment's: stencil and depth keep them away.",
            take(|c| &mut c.special),
        ),
    ]
}

fn names_of(data: &RunData, outcome: Outcome) -> Vec<String> {
    data.cases
        .iter()
        .filter(|case| case.outcome == outcome)
        .map(|case| case.key.to_string())
        .collect()
}

/// One paragraph: how many of what, and whether the pictures are right.
fn verdict(data: &RunData) -> Verdict {
    let n = |outcome| data.count(outcome);
    let (ok, wrong, skipped) = (n(Outcome::Ok), n(Outcome::Wrong), n(Outcome::Skipped));
    let (failed, missing) = (n(Outcome::Failed), n(Outcome::Missing));
    let in_sweep = data.wrong_in_sweep();
    let total = data.cases.len();
    let mut sentences = vec![format!(
        "{}{}: {ok} right, {wrong} wrong{}, {skipped} skipped, {failed} failed, {missing} missing.",
        plural(total, "case"),
        match data.cases.iter().filter(|case| case.is_baseline()).count() {
            0 => String::new(),
            passes => format!(", {passes} of them full-screen passes to compare with"),
        },
        match in_sweep {
            0 => String::new(),
            _ => format!(" ({in_sweep} of them in the sweep, where error is the question)"),
        },
    )];
    if missing > 0 {
        sentences.push(format!(
            "This run broke off: {missing} of {total} planned cases have no result, and the report \
             covers the rest."
        ));
    }
    sentences.push(picture_sentence(data));
    let class = match (ok, wrong - in_sweep + failed, missing) {
        (_, 1.., _) | (0, _, _) => "bad",
        (_, _, 1..) => "incomplete",
        _ => "good",
    };
    Verdict { class, sentences }
}

fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Whether the pictures outside the sweep match the reference.
fn picture_sentence(data: &RunData) -> String {
    let outside = |case: &Case| case.value(|row| row.mismatched_px_outside_band);
    let compared: Vec<&Case> = data
        .cases
        .iter()
        .filter(|case| outside(case).is_some() && !case.is_sweep())
        .collect();
    let differing: Vec<String> = compared
        .iter()
        .filter(|case| outside(case) != Some(0) || case.outcome == Outcome::Wrong)
        .map(|case| case.key.to_string())
        .collect();
    match (compared.len(), differing.len()) {
        (0, _) => "No picture was compared with the reference.".to_owned(),
        (all, 0) => format!(
            "Every picture that was compared ({all}) matches the reference outside the 1-pixel \
             boundary band."
        ),
        (all, some) => format!(
            "{some} of {all} compared pictures do not match the reference: {}.",
            first_few(&differing)
        ),
    }
}

/// The names, or the first of them and how many more there are.
fn first_few(names: &[String]) -> String {
    const FEW: usize = 4;
    match names.len().saturating_sub(FEW) {
        0 => names.join(", "),
        more => format!("{} and {more} more", names[..FEW].join(", ")),
    }
}

fn environment(data: &RunData) -> Vec<(&'static str, String)> {
    let e = &data.environment;
    let number = |value: u64| match value {
        0 => String::new(),
        value => count(value),
    };
    let image = match (e.width, e.height) {
        (0, _) | (_, 0) => String::new(),
        (width, height) => format!("{width} × {height} px"),
    };
    let ids = match (e.vendor_id, e.device_id) {
        (0, 0) => String::new(),
        (vendor, device) => format!("{vendor:#06x} : {device:#06x}"),
    };
    vec![
        ("started", utc(e.started_unix_s)),
        ("commit", e.commit.clone()),
        ("build", e.profile.clone()),
        ("graphics API", e.api.clone()),
        ("adapter", e.gpu.clone()),
        ("device type", e.device_type.clone()),
        ("vendor : device", ids),
        (
            "driver",
            format!("{} {}", e.driver, e.driver_info).trim().to_owned(),
        ),
        ("Mesa", e.mesa_version.clone()),
        ("CPU", e.cpu.clone()),
        ("logical cores", number(u64::from(e.cores))),
        (
            "memory",
            Some(e.memory_bytes)
                .filter(|b| *b > 0)
                .map_or_else(String::new, bytes),
        ),
        ("system", e.os.clone()),
        ("image", image),
        ("timed frames per case", number(u64::from(data.plan.frames))),
        ("warm-up frames", number(u64::from(data.plan.warm_up))),
        ("options", e.options.join("  ")),
        ("shader hash", e.shader_hash.clone()),
    ]
}

fn scene_section(
    data: &RunData,
    scene: &SceneCases<'_>,
    palette: &Palette,
) -> Result<SceneSection, ReportError> {
    Ok(SceneSection {
        name: scene.name.to_owned(),
        anchor: anchor(&[scene.name]),
        ratio_plot: plot::time_over_bound(scene, palette)?,
        bytes_plot: plot::geometry_bytes(scene, palette)?,
        published: published_table(data, scene),
        views: scene
            .views
            .iter()
            .map(|view| view_section(data, scene.name, view, palette))
            .collect::<Result<_, _>>()?,
    })
}

fn view_section(
    data: &RunData,
    scene: &str,
    view: &ViewCases<'_>,
    palette: &Palette,
) -> Result<ViewSection, ReportError> {
    let mut footnotes = Vec::new();
    let rows = view
        .baselines
        .iter()
        .chain(&view.cases)
        .map(|case| table_row(case, &mut footnotes))
        .collect();
    let (error_plot, not_drawn) = plot::error_against_time(scene, view, palette)?
        .map_or((None, Vec::new()), |plot| (Some(plot.svg), plot.not_drawn));
    let mut picture_problems = Vec::new();
    let reference = reference_picture(data, view, &mut picture_problems);
    Ok(ViewSection {
        name: view.name.to_owned(),
        anchor: anchor(&[scene, view.name]),
        reference,
        pictures: picture_groups(data, view, &mut picture_problems),
        picture_problems,
        headings: COLUMNS
            .iter()
            .map(|column| Heading {
                text: column.heading,
                meaning: glossary::meaning(column.term).unwrap_or_default(),
            })
            .collect(),
        rows,
        footnotes,
        left_out: left_out_groups(view),
        error_plot,
        not_drawn,
    })
}

fn load(data: &RunData, path: &str, problems: &mut Vec<String>) -> Option<Picture> {
    if path.is_empty() {
        return None;
    }
    match embed(&data.folder, path) {
        Ok(picture) => Some(picture),
        Err(problem) => {
            if !problems.contains(&problem) {
                problems.push(problem);
            }
            None
        }
    }
}

fn reference_picture(
    data: &RunData,
    view: &ViewCases<'_>,
    problems: &mut Vec<String>,
) -> Option<Picture> {
    let mut paths: Vec<&str> = view
        .cases
        .iter()
        .filter_map(|case| Some(case.summary.as_ref()?.reference_image.as_str()))
        .collect();
    paths.dedup();
    paths.iter().find_map(|path| load(data, path, problems))
}

fn picture_groups(
    data: &RunData,
    view: &ViewCases<'_>,
    problems: &mut Vec<String>,
) -> Vec<PictureGroup> {
    let mut groups: Vec<PictureGroup> = Vec::new();
    for case in &view.cases {
        let Some(row) = &case.summary else {
            continue;
        };
        let picture = load(data, &row.image, problems);
        let difference = load(data, &row.difference_image, problems);
        if picture.is_none() && difference.is_none() {
            continue;
        }
        let caption = caption(case);
        let same = groups
            .iter_mut()
            .find(|group| group.picture == picture && group.difference == difference);
        match same {
            Some(group) => group.captions.push(caption),
            None => groups.push(PictureGroup {
                picture,
                difference,
                captions: vec![caption],
            }),
        }
    }
    groups
}

fn caption(case: &Case) -> String {
    let figure = |value: Option<String>| value.unwrap_or_else(|| "–".to_owned());
    format!(
        "{}{}: {} wrong px, {} outside the band, Hausdorff {} px{}{}",
        case.name(),
        if case.outcome == Outcome::Ok {
            String::new()
        } else {
            format!(" ({})", case.outcome.name())
        },
        figure(case.value(|row| row.mismatched_px).map(count)),
        figure(case.value(|row| row.mismatched_px_outside_band).map(count)),
        figure(case.value(|row| row.hausdorff_px).map(significant)),
        case.value(|row| row.boundary_moved_px)
            .map_or(String::new(), |px| format!(
                ", moved {} px",
                significant(px)
            )),
        case.value(|row| row.foreign_px)
            .filter(|px| *px > 0)
            .map_or(String::new(), |px| format!(", {} foreign", count(px))),
    )
}

fn fill_cpu_cell(case: &Case) -> Option<String> {
    let spread = case.fill_cpu?;
    Some(format!(
        "{} [{}–{}]",
        significant(spread.median),
        significant(spread.p5),
        significant(spread.p95)
    ))
}

fn table_row(case: &Case, footnotes: &mut Vec<String>) -> Row {
    Row {
        name_parts: breakable(&case.name()),
        status: case.outcome.name(),
        cells: COLUMNS
            .iter()
            .map(|column| table_cell(case, column, footnotes))
            .collect(),
        reason: case.reason().to_owned(),
    }
}

/// A name in the pieces between which a line may break: after commas and slashes.
pub(crate) fn breakable(name: &str) -> Vec<String> {
    name.split_inclusive([',', '/'])
        .map(str::to_owned)
        .collect()
}

/// Frame plans that left something out, equal ones together.
fn left_out_groups(view: &ViewCases<'_>) -> Vec<LeftOut> {
    let mut groups: Vec<LeftOut> = Vec::new();
    for case in &view.cases {
        let Some(row) = case.summary.as_ref().filter(|row| !row.left_out.is_empty()) else {
            continue;
        };
        match groups.iter_mut().find(|group| group.text == row.left_out) {
            Some(group) => group.cases.push(case.name()),
            None => groups.push(LeftOut {
                cases: vec![case.name()],
                text: row.left_out.clone(),
            }),
        }
    }
    groups
}

fn table_cell(case: &Case, column: &Column, footnotes: &mut Vec<String>) -> Cell {
    let void = column.is_time && case.outcome == Outcome::Wrong;
    match (column.cell)(case) {
        Some(text) if void => {
            let title = "the picture is wrong: this time counts for nothing".to_owned();
            Cell {
                text,
                class: "void",
                footnote: footnote(&title, footnotes),
                title,
            }
        }
        Some(text) => Cell {
            text,
            class: "",
            title: String::new(),
            footnote: 0,
        },
        None => {
            let title = why_absent(case, column);
            Cell {
                text: "–".to_owned(),
                class: "absent",
                footnote: footnote(&title, footnotes),
                title,
            }
        }
    }
}

fn why_absent(case: &Case, column: &Column) -> String {
    match (case.outcome, case.reason()) {
        (Outcome::Ok, _) if case.is_baseline() => "does not apply to a full-screen pass".to_owned(),
        (Outcome::Ok, _) => column.absent_because.to_owned(),
        (outcome, "") => format!("{}, no reason was recorded", outcome.name()),
        (outcome, reason) => format!("{}: {reason}", outcome.name()),
    }
}

/// Number of the footnote with this text, from 1.
fn footnote(text: &str, footnotes: &mut Vec<String>) -> usize {
    match footnotes.iter().position(|known| known == text) {
        Some(index) => index + 1,
        None => {
            footnotes.push(text.to_owned());
            footnotes.len()
        }
    }
}

fn anchor(parts: &[&str]) -> String {
    parts
        .join("--")
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect()
}

fn published_table(data: &RunData, scene: &SceneCases<'_>) -> Option<PublishedTable> {
    let published = published::of_scene(scene.name);
    let has_a_view = scene
        .views
        .iter()
        .any(|view| published::VIEWS.contains(&view.name));
    if published.is_empty() || !has_a_view {
        return None;
    }
    let comparable = is_comparable(data);
    let mut rows: Vec<PublishedRow> = published
        .iter()
        .map(|row| PublishedRow {
            name_parts: vec![format!("CesiumJS, {}", row.method)],
            is_ours: false,
            cells: row
                .fill_cpu_ms
                .iter()
                .map(|ms| format!("{} ms", significant(*ms)))
                .chain([bytes(row.bytes)])
                .collect(),
        })
        .collect();
    let mut names: Vec<String> = Vec::new();
    for case in scene.views.iter().flat_map(|view| &view.cases) {
        if !names.contains(&case.name()) {
            names.push(case.name());
        }
    }
    rows.extend(names.into_iter().map(|name| PublishedRow {
        cells: our_cells(scene, &name, &published, comparable),
        name_parts: breakable(&name),
        is_ours: true,
    }));
    Some(PublishedTable {
        headings: published::VIEWS,
        rows,
        source: published::SOURCE,
        caveat: if comparable {
            String::new()
        } else {
            format!(
                "This run was not made on {} at {1} × {1} px, so no ratios are given.",
                published::DRIVER,
                published::IMAGE_SIDE_PX
            )
        },
    })
}

fn is_comparable(data: &RunData) -> bool {
    let e = &data.environment;
    let named = [&e.gpu, &e.driver, &e.driver_info];
    named.iter().any(|text| text.contains(published::DRIVER))
        && (e.width, e.height) == (published::IMAGE_SIDE_PX, published::IMAGE_SIDE_PX)
}

/// Our figure for each published view and the bytes, each followed by how many times less it is
/// than each published technique's.
fn our_cells(
    scene: &SceneCases<'_>,
    name: &str,
    published: &[published::Published],
    comparable: bool,
) -> Vec<String> {
    let of_view = |view: &str| {
        let view = scene.views.iter().find(|found| found.name == view)?;
        view.cases.iter().find(|case| case.name() == name).copied()
    };
    let ratios = |theirs: Vec<f64>, ours: f64| {
        let texts: Vec<String> = theirs
            .iter()
            .map(|theirs| format!("{} ×", significant(theirs / ours)))
            .collect();
        if comparable && ours > 0.0 {
            format!(" ({})", texts.join(" / "))
        } else {
            String::new()
        }
    };
    let mut cells = Vec::new();
    for (index, view) in published::VIEWS.iter().enumerate() {
        cells.push(match of_view(view) {
            None => "–".to_owned(),
            Some(case) if !case.counts() => case.outcome.name().to_owned(),
            Some(case) => case.fill_cpu.map_or_else(
                || "–".to_owned(),
                |fill| {
                    let theirs = published.iter().map(|row| row.fill_cpu_ms[index]).collect();
                    format!(
                        "{} ms{}",
                        significant(fill.median),
                        ratios(theirs, fill.median)
                    )
                },
            ),
        });
    }
    let held = published::VIEWS
        .iter()
        .filter_map(|view| of_view(view)?.value(|row| row.geometry_bytes))
        .max();
    cells.push(held.map_or_else(
        || "–".to_owned(),
        |held| {
            let theirs = published.iter().map(|row| row.bytes as f64).collect();
            format!("{}{}", bytes(held), ratios(theirs, held as f64))
        },
    ));
    cells
}
