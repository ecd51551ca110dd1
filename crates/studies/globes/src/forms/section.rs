// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on the spiral's vertices.

use super::{FINE_PX, PART, SERIES};
use crate::STUDY;
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, Cell, Finding, Heading, Row, Run, Standing, Table};

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run) -> Vec<Block> {
    let own = run.of_study(STUDY);
    let cases: Vec<&Case> = own
        .filter(|case| !case.is_twin() && case.condition("part") == PART)
        .collect();
    if cases.is_empty() {
        return Vec::new();
    }
    let of = |what: &str| -> Vec<&Case> {
        let with = cases.iter().copied();
        with.filter(|case| case.condition("what") == what).collect()
    };
    vec![
        Block::section("Vertices of the spiral"),
        Block::Text(
            "Each form of a vertex's position in single precision is compared with itself in double precision, \
             and each Taylor series of sine and cosine with the functions, vertex by vertex, up to the horizon. \
             Pixels are of a picture of 1,080 rows and 60°. Single precision is emulated; sines are rounded from \
             f64, and a device's are worse. Rings are the fewest with which no edge between two of them sags by \
             more than ¼ px."
                .to_owned(),
        ),
        Block::Table(grid("f32 against f64, largest, px", &of("f32"), "globe_form_px_max")),
        Block::Table(grid("Series against sine and cosine, largest, px", &of("series"), "globe_form_px_max")),
        Block::Table(rings(&of("rings"))),
        Block::Finding(series_finding(&of("series"))),
    ]
}

fn heights(cases: &[&Case]) -> Vec<String> {
    let mut heights: Vec<String> = Vec::new();
    for case in cases {
        let height = case.condition("height_m").to_owned();
        if !heights.contains(&height) {
            heights.push(height);
        }
    }
    heights
}

fn names<'a>(cases: &[&'a Case]) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for case in cases {
        if !names.contains(&case.condition("form")) {
            names.push(case.condition("form"));
        }
    }
    names
}

fn value(cases: &[&Case], form: &str, height: &str, metric: &str) -> Option<f64> {
    let mut cases = cases.iter().filter(|case| {
        case.condition("form") == form && case.condition("height_m") == height && case.counts()
    });
    cases.next()?.value(metric)
}

/// A row a form, a column a height.
fn grid(caption: &str, cases: &[&Case], metric: &'static str) -> Table {
    let heights = heights(cases);
    let rows = names(cases).into_iter().map(|name| {
        let mut cells = vec![Cell::name(name)];
        cells.extend(heights.iter().map(|height| {
            let value = value(cases, name, height, metric);
            Cell::or_absent(value.map(significant), "it failed")
        }));
        Row::new(cells)
    });
    let mut headings = vec![Heading::plain("form")];
    headings.extend(
        heights
            .iter()
            .map(|height| Heading::metric(format!("{height} m"), metric)),
    );
    Table {
        caption: caption.to_owned(),
        headings,
        rows: rows.collect(),
        ..Table::default()
    }
}

fn rings(cases: &[&Case]) -> Table {
    let heights = heights(cases);
    let metrics = ["globe_form_rings", "globe_form_expected_rings"];
    let rows = names(cases).into_iter().map(|name| {
        let mut cells = vec![Cell::name(name)];
        for height in &heights {
            cells.extend(metrics.map(|metric| {
                let value = value(cases, name, height, metric);
                Cell::or_absent(value.map(significant), "it failed")
            }));
        }
        Row::new(cells)
    });
    let mut headings = vec![Heading::plain("law")];
    for height in &heights {
        headings.push(Heading::metric(format!("{height} m: found"), metrics[0]));
        headings.push(Heading::metric("formula", metrics[1]));
    }
    Table {
        caption: "Rings for ¼ px by law of radii".to_owned(),
        headings,
        rows: rows.collect(),
        ..Table::default()
    }
}

fn series_finding(cases: &[&Case]) -> Finding {
    let worst = |name: &str| {
        let all = heights(cases);
        let values = all
            .iter()
            .map(|height| value(cases, name, height, "globe_form_px_max"));
        let values: Option<Vec<f64>> = values.collect();
        values
            .filter(|values| !values.is_empty())?
            .into_iter()
            .max_by(f64::total_cmp)
    };
    let words: Vec<String> = SERIES
        .iter()
        .filter_map(|name| Some(format!("{name}: {} px", significant(worst(name)?))))
        .collect();
    Finding {
        claim: "Gebbie & Bailey: low orders of Taylor's series are not noticed; at 5/6 they are below ¼ px everywhere"
            .to_owned(),
        standing: match worst("5/6") {
            Some(px) => Standing::holds_if(px <= FINE_PX),
            None => Standing::CannotTell,
        },
        because: format!("Largest at any height: {}.", words.join(", ")),
    }
}
