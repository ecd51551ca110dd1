// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on the spiral's vertices.

use super::{FINE_PX, PART, SERIES};
use crate::keys::{
    FORM, GLOBE_FORM_EXPECTED_RINGS, GLOBE_FORM_PX_MAX, GLOBE_FORM_RINGS, HEIGHT_M, WHAT,
};
use crate::table::{cases, with};
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, Cell, Finding, Heading, Metric, Row, Run, Standing, Table};

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run) -> Vec<Block> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Vec::new();
    }
    let of = |what: &str| with(&cases, WHAT, what);
    vec![
        Block::section("Vertices of the spiral"),
        Block::Text(
            "Each form of a vertex's position in single precision is compared with itself in double precision, both from \
             angles and radii as a buffer of f32 holds them. Each Taylor series of sine and cosine is compared with the \
             functions. Both are compared vertex by vertex, up to the horizon. Pixels are of a picture of 1,080 rows and 60°. Single precision is emulated; sines are rounded from \
             f64, and a device's are worse. Rings are the fewest with which no edge between two of them sags by \
             more than ¼ px."
                .to_owned(),
        ),
        Block::Table(grid("f32 against f64, largest, px", &of("f32"), GLOBE_FORM_PX_MAX)),
        Block::Table(grid("Series against sine and cosine, largest, px", &of("series"), GLOBE_FORM_PX_MAX)),
        Block::Table(rings(&of("rings"))),
        Block::Finding(local_finding(&of("f32"))),
        Block::Finding(series_finding(&of("series"))),
        Block::Finding(ring_finding(&of("rings"))),
    ]
}

fn heights(cases: &[&Case]) -> Vec<String> {
    let mut heights: Vec<String> = Vec::new();
    for case in cases {
        let height = case.condition(HEIGHT_M).to_owned();
        if !heights.contains(&height) {
            heights.push(height);
        }
    }
    heights
}

fn names<'a>(cases: &[&'a Case]) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for case in cases {
        if !names.contains(&case.condition(FORM)) {
            names.push(case.condition(FORM));
        }
    }
    names
}

fn value(cases: &[&Case], form: &str, height: &str, metric: &Metric) -> Option<f64> {
    let mut cases = cases.iter().filter(|case| {
        case.condition(FORM) == form && case.condition(HEIGHT_M) == height && case.counts()
    });
    cases.next()?.value(metric)
}

/// A row a form, a column a height.
fn grid(caption: &str, cases: &[&Case], metric: &'static Metric) -> Table {
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
    let metrics = [GLOBE_FORM_RINGS, GLOBE_FORM_EXPECTED_RINGS];
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

/// The fixed eye height of the target: a standing person's.
const GROUND_M: &str = "1.7";
/// What single precision may cost there, pixels (facts on globes, 7.3).
const LOCAL_PX: f64 = 1e-4;

fn local_finding(cases: &[&Case]) -> Finding {
    let px = |form: &str| value(cases, form, GROUND_M, GLOBE_FORM_PX_MAX);
    let words: Vec<String> = names(cases)
        .into_iter()
        .filter_map(|form| Some(format!("{form}: {} px", significant(px(form)?))))
        .collect();
    Finding {
        claim: "At 1.7 m single precision costs hundreds of pixels in absolute forms, and at most 1e-4 px in the focus-local \
                form with −2 sin²(r/2)"
            .to_owned(),
        standing: match (px("lonlat"), px("hemisphere"), px("local-sin2")) {
            (Some(lonlat), Some(hemisphere), Some(local)) => {
                Standing::holds_if(lonlat > 100.0 && hemisphere > 100.0 && local <= LOCAL_PX)
            }
            _ => Standing::CannotTell,
        },
        because: format!("Largest at 1.7 m: {}.", words.join(", ")),
    }
}

fn ring_finding(cases: &[&Case]) -> Finding {
    let targets = [
        ("exponential", 24.0),
        ("published", 12.0),
        ("quadratic", 7.0),
    ];
    let rings = |law: &str| value(cases, law, "2000", GLOBE_FORM_RINGS);
    let words: Vec<String> = targets
        .iter()
        .filter_map(|(law, target)| {
            Some(format!("{law}: {} rings, by formula {target}", rings(law)?))
        })
        .collect();
    let is_met =
        |(law, target): &(&str, f64)| rings(law).map(|found| (found - target).abs() <= 1.0);
    let met: Option<Vec<bool>> = targets.iter().map(is_met).collect();
    Finding {
        claim: "From 2 km a quarter of a pixel takes 24 exponential, 12 published and 7 quadratic rings, one more or less"
            .to_owned(),
        standing: match met {
            Some(met) => Standing::holds_if(met.into_iter().all(|met| met)),
            None => Standing::CannotTell,
        },
        because: format!("Found: {}.", words.join("; ")),
    }
}

fn series_finding(cases: &[&Case]) -> Finding {
    let worst = |name: &str| {
        let all = heights(cases);
        let values = all
            .iter()
            .map(|height| value(cases, name, height, GLOBE_FORM_PX_MAX));
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
