// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on what is known of the grid on the screen without a device.

use super::PART;
use crate::keys::{
    CELLS, GLOBE_CLOSED_MAP_M_MAX, GLOBE_EXPECTED_MAP_M_MAX, GLOBE_MAP_M_MAX, GLOBE_TILE_CROSSING,
    GLOBE_TILE_CROSSING_MET, GLOBE_TILE_MISSED, GLOBE_TILE_UNTOUCHED, GLOBE_TILE_UNTOUCHED_MET,
    GLOBE_TILE_WITH_POLE, HEIGHT_M, LATITUDE_DEG, LIMIT, VIEWS, WHAT,
};
use crate::table::{cases, why, with};
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, Cell, Finding, Heading, Metric, Row, Run, Standing, Table};

/// By how much the fit may be off (facts on globes, 7.1).
const FIT_SHARE: f64 = 0.12;
/// Of triangles across ±180°, those that the published rule leaves untouched: 45 of 2,713 (facts on globes, 2).
const UNTOUCHED: [f64; 2] = [45.0, 2713.0];
/// Two counts of the same share differ by fewer standard deviations than this.
const COUNT_SIGMAS: f64 = 2.0;

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run) -> Vec<Block> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Vec::new();
    }
    let (nadir, seam) = (with(&cases, WHAT, "nadir"), with(&cases, WHAT, "seam"));
    vec![
        Block::section("The grid on the screen, computed"),
        Block::Text(
            "An eye that looks straight down: how far the place that a map shows on a facet is from the place behind it, \
             largest, on the ground. The fit (1.3 + 2 tan φ) s²/8R has one constant where the closed form has \
             2√2 tan(fov/2) (1 − 1/N): 1.31 for 5 cells, 1.47 for 10 and 1.55 for 20. The fit takes φ and the cell below the \
             eye, the worst facet lies in a corner of the picture. Triangles across ±180° are counted over many \
             views straight down, from 1 km to 100,000 km, of 1 to 20 cells."
                .to_owned(),
        ),
        Block::Table(nadir_table(&nadir)),
        Block::Finding(fit_finding(&nadir)),
        Block::Finding(slope_finding(&nadir)),
        Block::Table(seam_table(&seam)),
        Block::Finding(seam_finding(&seam)),
    ]
}

/// Found over what a formula says, less 1.
fn off(case: &Case, formula: &Metric) -> Option<f64> {
    let found = case.value(GLOBE_MAP_M_MAX)?;
    Some(found / case.value(formula)? - 1.0)
}

fn per_cent(share: f64) -> String {
    format!("{:+.1} %", 100.0 * share)
}

fn nadir_table(cases: &[&Case]) -> Table {
    let rows = cases.iter().map(|case| {
        let names = [HEIGHT_M, LATITUDE_DEG, CELLS];
        let mut cells = names.map(|key| Cell::name(case.condition(key))).to_vec();
        for metric in [
            GLOBE_MAP_M_MAX,
            GLOBE_EXPECTED_MAP_M_MAX,
            GLOBE_CLOSED_MAP_M_MAX,
        ] {
            let value = case.value(metric).map(significant);
            cells.push(Cell::or_absent(value, why(case, "not computed")));
        }
        for formula in [GLOBE_EXPECTED_MAP_M_MAX, GLOBE_CLOSED_MAP_M_MAX] {
            let share = off(case, formula).map(per_cent);
            cells.push(Cell::or_absent(share, why(case, "not computed")));
        }
        Row {
            cells,
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    });
    Table {
        caption: "Largest error of a map straight down".to_owned(),
        headings: vec![
            Heading::plain("height, m"),
            Heading::plain("latitude, °"),
            Heading::plain("N"),
            Heading::metric("found, m", GLOBE_MAP_M_MAX),
            Heading::metric("fit, m", GLOBE_EXPECTED_MAP_M_MAX),
            Heading::metric("closed form, m", GLOBE_CLOSED_MAP_M_MAX),
            Heading::plain("found over the fit"),
            Heading::plain("found over the closed form"),
        ],
        rows: rows.collect(),
        ..Table::default()
    }
}

/// From the lowest to the highest.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |so_far: Option<[f64; 2]>, value| {
        let [low, high] = so_far.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

fn fit_finding(cases: &[&Case]) -> Finding {
    let ten = with(cases, CELLS, "10");
    let over = |cases: &[&Case], formula: &Metric| {
        range(cases.iter().filter_map(|case| off(case, formula)))
    };
    let fit = |is_equator: bool| {
        let own: Vec<&Case> = ten
            .iter()
            .copied()
            .filter(|case| (case.condition(LATITUDE_DEG) == "0") == is_equator)
            .collect();
        over(&own, GLOBE_EXPECTED_MAP_M_MAX)
    };
    let text = |range: Option<[f64; 2]>| match range {
        Some([low, high]) => format!("{} … {}", per_cent(low), per_cent(high)),
        None => "not computed".to_owned(),
    };
    let all = over(&ten, GLOBE_EXPECTED_MAP_M_MAX);
    let closed = over(cases, GLOBE_CLOSED_MAP_M_MAX);
    Finding {
        claim: "Straight down from up to 100 km the largest error is within 12 % of (1.3 + 2 tan φ) s²/8R, N = 10".to_owned(),
        standing: match all {
            Some([low, high]) => Standing::holds_if(low >= -FIT_SHARE && high <= FIT_SHARE),
            None => Standing::CannotTell,
        },
        because: format!(
            "N = 10, from 15° on: {}; over the equator: {}, where nothing but the slope of the ray is left and the constant is \
             1.47, not 1.3. Over the closed form, all N and latitudes: {}.",
            text(fit(false)),
            text(fit(true)),
            text(closed)
        ),
    }
}

/// By how much the error falls with the number of cells, in each view.
fn slopes(cases: &[&Case]) -> Vec<f64> {
    let of = |n: &str, like: &Case| {
        let mut own = with(cases, CELLS, n).into_iter();
        let same = [HEIGHT_M, LATITUDE_DEG];
        own.find(|case| {
            same.iter()
                .all(|key| case.condition(*key) == like.condition(*key))
        })?
        .value(GLOBE_MAP_M_MAX)
    };
    let coarse = with(cases, CELLS, "5");
    let pairs = coarse
        .iter()
        .filter_map(|case| of("5", case).zip(of("20", case)));
    pairs
        .map(|(five, twenty)| (twenty / five).ln() / 4_f64.ln())
        .collect()
}

fn slope_finding(cases: &[&Case]) -> Finding {
    let found = range(slopes(cases).into_iter());
    Finding {
        claim: "Its slope in N is −2".to_owned(),
        standing: match found {
            Some([low, high]) => Standing::holds_if(low > -2.2 && high < -1.8),
            None => Standing::CannotTell,
        },
        because: match found {
            Some([low, high]) => format!(
                "From N = 5 to 20 in all views: {} … {}; with the slope of the outermost ray, 1 − 1/N, it is less steep over the \
                 equator.",
                significant(low),
                significant(high)
            ),
            None => "It was not computed.".to_owned(),
        },
    }
}

fn seam_table(cases: &[&Case]) -> Table {
    let columns = [
        ("crossing triangles", GLOBE_TILE_CROSSING),
        ("untouched", GLOBE_TILE_UNTOUCHED),
        ("not split on both edges", GLOBE_TILE_MISSED),
        ("with a pole", GLOBE_TILE_WITH_POLE),
        ("crossing, a corner met", GLOBE_TILE_CROSSING_MET),
        ("of them untouched", GLOBE_TILE_UNTOUCHED_MET),
    ];
    crate::table::by_case(
        "Triangles across ±180° by the rule that splits them",
        cases,
        (
            &["where U differs by", "views"],
            &crate::table::conditions(&[LIMIT, VIEWS]),
        ),
        &columns,
        &|_| "not computed",
    )
}

fn seam_finding(cases: &[&Case]) -> Finding {
    let of = |limit: &str, metric: &Metric| with(cases, LIMIT, limit).first()?.value(metric);
    let share =
        |limit: &str, metric: &Metric| Some(of(limit, metric)? / of(limit, GLOBE_TILE_CROSSING)?);
    let shares = [
        share("0.7", GLOBE_TILE_UNTOUCHED),
        share("0.7", GLOBE_TILE_MISSED),
        share("0.5", GLOBE_TILE_MISSED),
        of("0.7", GLOBE_TILE_UNTOUCHED_MET),
        of("0.7", GLOBE_TILE_CROSSING_MET),
    ];
    let [
        Some(untouched),
        Some(missed),
        Some(half),
        Some(untouched_met),
        Some(crossing_met),
    ] = shares
    else {
        return Finding {
            claim: SEAM_CLAIM.to_owned(),
            standing: Standing::CannotTell,
            because: "It was not computed.".to_owned(),
        };
    };
    let met = [untouched_met, crossing_met];
    Finding {
        claim: SEAM_CLAIM.to_owned(),
        standing: Standing::holds_if(half == 0.0 && is_same_share(met, UNTOUCHED)),
        because: format!(
            "0.7 inserts nothing into {untouched_met} of {crossing_met} = {:.2} % of those with a corner whose ray met the body; \
             the facts count 45 of 2,713 = 1.66 %, and two counts so small may differ by {COUNT_SIGMAS} standard deviations. \
             With triangles at the limb, all of whose corners were moved there, it is {:.2} %. Into {:.2} % of all it does \
             not insert both vertices: where one edge alone differs by more than 0.7, a part still runs back over the map. \
             0.5 misses {:.2} %.",
            100.0 * untouched_met / crossing_met,
            100.0 * untouched,
            100.0 * missed,
            100.0 * half
        ),
    }
}

/// Whether two counts, each of some number, can be of the same share: by what a count of independent events varies.
fn is_same_share(a: [f64; 2], b: [f64; 2]) -> bool {
    let share = |[found, of]: [f64; 2]| found / of;
    let variance = |[found, of]: [f64; 2]| found / (of * of);
    (share(a) - share(b)).abs() <= COUNT_SIGMAS * (variance(a) + variance(b)).sqrt()
}

const SEAM_CLAIM: &str = "The published 0.7 leaves some 1.7 % of the crossing triangles untouched, those over 108° wide; 0.5 misses none";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_of_one_share_are_the_same_and_of_twice_that_are_not() {
        assert!(is_same_share([38.0, 2709.0], UNTOUCHED));
        // Twin: what triangles at the limb would make of it.
        assert!(!is_same_share([156.0, 5024.0], UNTOUCHED));
    }
}
