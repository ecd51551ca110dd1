// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on growth: what a mesh costs by the vertices of its outline, one curve per shape.

use crate::keys::{OUTLINE_VERTICES, SHAPE};
use crate::metrics::METRICS;
use terrafill_plot::number::significant;
use terrafill_plot::{
    Curve, Palette, Point, PointStanding, Reading, ReferenceLine, Upwards, WorkPrecision,
    named_aside,
};
use terrafill_results::{
    Answers, Block, Case, Cell, Chapter, ChapterError, Clock, Heading, Metric, Plot, Row, Run,
    Spread, Table, process_medians, sample_spread,
};

/// Process CPU time from text to mesh: a mesh is made on the CPU, whatever the device.
const TIME: &Metric = Metric::of(&METRICS, "mesh_cpu_ms");
/// Vertices that the shape came to have; about as many as were asked for.
const VERTICES: &Metric = Metric::of(&METRICS, "vertices_of_outline");

/// Sizes of the ratio, as in the condition `outline_vertices`.
const RATIO_SIZES: [&str; 2] = ["100000", "1000000"];
/// Largest ratio allowed: n log n comes to 12 between the two sizes, and a third more is left for memory
/// beyond the caches.
const MAX_RATIO: f64 = 16.0;

/// What a mesh costs by the size of its outline.
#[derive(Debug, Clone, Copy, Default)]
pub struct GrowthChapter;

/// One shape.
struct Shape<'a> {
    name: &'a str,
    /// By rising vertices.
    sizes: Vec<Size<'a>>,
}

/// A shape of one size that was measured.
struct Size<'a> {
    asked: &'a str,
    vertices: f64,
    time: Spread,
    replicates: Vec<f64>,
}

impl Shape<'_> {
    fn median_ms(&self, asked: &str) -> Option<f64> {
        let mut sizes = self.sizes.iter();
        sizes
            .find(|size| size.asked == asked)
            .map(|size| size.time.median)
    }
}

impl Chapter for GrowthChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Growth: time to mesh against vertices"
    }

    fn primary_metric(&self, _clock: Clock) -> Option<&'static str> {
        Some(TIME.name)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let shapes = shapes(run);
        let blocks = match shapes.is_empty() {
            true => Vec::new(),
            false => vec![Block::Table(table(&shapes))],
        };
        Ok(Answers {
            blocks,
            ..Answers::default()
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let shapes = shapes(run);
        if shapes.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = Vec::new();
        if let Some(svg) = drawing(&shapes)? {
            blocks.push(Block::Plot(Plot {
                caption: "Process CPU time from GeoJSON text to mesh, for made-up shapes; whiskers: \
                          5–95 % of the builds. Along the dashed line time grows as the vertices do. \
                          Beside each name: cost per vertex at the largest size."
                    .to_owned(),
                svg,
            }));
        }
        blocks.push(Block::Table(table(&shapes)));
        Ok(blocks)
    }
}

/// Shapes in the order in which they first appear.
fn shapes(run: &Run) -> Vec<Shape<'_>> {
    let mut shapes: Vec<Shape<'_>> = Vec::new();
    for case in run.of_study(crate::STUDY).filter(|case| !case.is_twin()) {
        let name = case.condition(SHAPE);
        let index = shapes.iter().position(|shape| shape.name == name);
        let index = index.unwrap_or_else(|| {
            shapes.push(Shape {
                name,
                sizes: Vec::new(),
            });
            shapes.len() - 1
        });
        shapes[index].sizes.extend(size(case));
    }
    for shape in &mut shapes {
        shape
            .sizes
            .sort_by(|a, b| a.vertices.total_cmp(&b.vertices));
    }
    shapes
}

/// `None` unless it was measured as often as planned.
fn size(case: &Case) -> Option<Size<'_>> {
    if !case.counts() {
        return None;
    }
    Some(Size {
        asked: case.condition(OUTLINE_VERTICES),
        vertices: case.value(VERTICES)?,
        time: sample_spread(case, TIME)?,
        replicates: process_medians(case, TIME).into_values().collect(),
    })
}

fn table(shapes: &[Shape<'_>]) -> Table {
    let rows = shapes.iter().map(|shape| {
        let times = RATIO_SIZES.map(|asked| shape.median_ms(asked));
        let ratio = times[1].zip(times[0]).map(|(many, few)| many / few);
        let cell = |value: Option<f64>| Cell::or_absent(value.map(significant), "not measured");
        let mut cells = vec![Cell::name(shape.name)];
        cells.extend(times.map(cell));
        cells.push(cell(ratio));
        cells.push(Cell::plain(significant(MAX_RATIO)));
        Row::new(cells).bad_if(ratio.is_some_and(|ratio| ratio > MAX_RATIO))
    });
    Table {
        headings: vec![
            Heading::plain("shape"),
            Heading::metric("100 000 vertices, CPU ms", TIME),
            Heading::metric("1 000 000 vertices, CPU ms", TIME),
            Heading::explained(
                "ratio",
                "time at 1 000 000 vertices over time at 100 000; 10 is linear",
            ),
            Heading::explained(
                "allowed",
                "n log n comes to 12 between the two sizes, memory beyond the caches to a third more",
            ),
        ],
        rows: rows.collect(),
        is_main: true,
        ..Table::default()
    }
}

fn drawing(shapes: &[Shape<'_>]) -> Result<Option<String>, ChapterError> {
    let curves = shapes.iter().filter(|shape| !shape.sizes.is_empty());
    let shapes: Vec<&Shape<'_>> = curves.collect();
    let plot = WorkPrecision {
        title: "Time to mesh against vertices",
        across: "vertices of the outline",
        up: "text to mesh, process CPU ms: median, 5–95 %",
        upwards: Upwards::Amount,
        curves: shapes.iter().map(|shape| curve(shape)).collect(),
        lines: slope(&shapes).into_iter().collect(),
    };
    let names: Vec<String> = shapes.iter().map(|shape| name(shape)).collect();
    let palette = Palette::new(shapes.iter().map(|shape| shape.name.to_owned()).collect());
    Ok(named_aside(
        "time to mesh against vertices",
        &plot,
        &names,
        &palette,
    )?)
}

fn curve(shape: &Shape<'_>) -> Curve {
    let point = |size: &Size<'_>| Point {
        knob: size.vertices,
        label: String::new(),
        x: Some(Reading::exact(size.vertices)),
        y: Some(Reading::sampled(size.time, &size.replicates)),
        y_rms: None,
        standing: PointStanding::Right,
        command: String::new(),
    };
    Curve {
        name: shape.name.to_owned(),
        points: shape.sizes.iter().map(point).collect(),
    }
}

/// From the cheapest shape's first point.
fn slope(shapes: &[&Shape<'_>]) -> Option<ReferenceLine> {
    let firsts = shapes.iter().filter_map(|shape| shape.sizes.first());
    let cheapest = firsts.min_by(|a, b| a.time.median.total_cmp(&b.time.median));
    cheapest.map(|size| ReferenceLine {
        label: "slope 1".to_owned(),
        from_x: Some(size.vertices),
        y: size.time.median,
        power: 1.0,
    })
}

/// The shape, and the cost of a vertex at the curve's end.
fn name(shape: &Shape<'_>) -> String {
    let nanoseconds = shape
        .sizes
        .last()
        .map(|size| size.time.median * 1e6 / size.vertices);
    let nanoseconds = nanoseconds.map_or_else(|| "–".to_owned(), significant);
    format!("{} · {nanoseconds} ns", shape.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{CaseId, CellClass, Status};

    fn id(shape: &str, asked: u64) -> CaseId {
        let asked = asked.to_string();
        let conditions = [("shape", shape), ("outline_vertices", &asked)];
        case_id(crate::STUDY, &format!("{shape}/{asked}"), &conditions)
    }

    fn grow(run: &mut MadeUpRun, shape: &str, times: &[(u64, f64)]) {
        for &(asked, ms) in times {
            let case = run.case(id(shape, asked));
            // Shapes have about as many vertices as were asked for.
            case.figure(VERTICES, asked as f64 + 4.0);
            case.sampled(TIME, &[&[0.95 * ms, ms, 1.1 * ms], &[ms, ms, ms]]);
        }
    }

    fn blocks(run: &MadeUpRun) -> Vec<Block> {
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        GrowthChapter.blocks(&run).expect("a chapter")
    }

    #[test]
    fn growth_is_drawn_and_compared_with_its_bound() {
        let sizes = [1_000, 10_000, 100_000, 1_000_000];
        let timed = |ms: [f64; 4]| sizes.into_iter().zip(ms).collect::<Vec<_>>();
        let mut run = MadeUpRun::default();
        grow(&mut run, "comb", &timed([1.0, 10.0, 100.0, 1_110.0]));
        grow(&mut run, "spiral", &timed([1.0, 10.0, 100.0, 1_700.0]));
        grow(&mut run, "needle", &[(1_000, 1.0)]);
        let blocks = blocks(&run);
        let [Block::Plot(plot), Block::Table(table)] = &blocks[..] else {
            panic!("a plot and a table: {blocks:?}");
        };
        for word in [
            "slope 1",
            "comb · 1",
            "spiral · 1",
            "vertices of the outline",
        ] {
            assert!(plot.svg.contains(word), "{word}");
        }
        let ratio = |row: usize| {
            (
                table.rows[row].cells[3].text.as_str(),
                table.rows[row].cells[3].class,
            )
        };
        assert_eq!(ratio(0), ("11.1", CellClass::Plain));
        assert_eq!(ratio(1), ("17.0", CellClass::Bad));
        assert_eq!(
            ratio(2),
            ("–", CellClass::Absent),
            "no ratio of something else"
        );
    }

    #[test]
    fn a_build_that_broke_off_has_no_point_and_no_ratio() {
        let mut run = MadeUpRun::default();
        grow(&mut run, "comb", &[(100_000, 100.0), (1_000_000, 1_110.0)]);
        run.cases[1].ended(Status::Failed, "out of memory");
        let blocks = blocks(&run);
        let Some(Block::Table(table)) = blocks.last() else {
            panic!("a table: {blocks:?}");
        };
        assert_eq!(table.rows[0].cells[3].class, CellClass::Absent);
    }

    #[test]
    fn a_run_without_growth_has_no_chapter() {
        let mut run = MadeUpRun::default();
        run.case(case_id("filling", "a", &[]));
        assert_eq!(blocks(&run), []);
    }
}
