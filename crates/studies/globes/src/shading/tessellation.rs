// SPDX-License-Identifier: MIT OR Apache-2.0
//! Time against the number of triangles, with the full shader and with a white one: the windows and triangles of Gebbie
//! and Bailey's Table 1.

use super::REMOVED;
use super::rows::{cases, noise, value};
use crate::clock::draw;
use crate::keys;
use crate::keys::{CELLS, GLOBE_TRIANGLES, SIZE_PX};
use crate::published::tessellation_published;
use crate::table::with;
use terrafill_plot::number::significant;
use terrafill_plot::{
    Arrangement, Curve, Palette, Point, PointStanding, Reading, Upwards, WorkPrecision, panels,
};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Clock, Estimate, Finding, Heading, Noise, Plot, Row, Run,
    Standing, Table, process_medians, ratio, sample_spread,
};

/// Share of the time above which time is not independent of the number of triangles.
const INDEPENDENT: f64 = 0.03;

/// Features removed, and the shader's name.
const SHADERS: [(u32, &str); 2] = [(0, "full shader"), (REMOVED, "white shader")];

/// The section; nothing where no case was planned.
pub(super) fn blocks(run: &Run, clock: Clock) -> Result<Vec<Block>, ChapterError> {
    let cases = cases(run, "tessellation");
    if cases.is_empty() {
        return Ok(Vec::new());
    }
    let noise = noise(run, clock);
    let mut blocks = vec![Block::section("Time against tessellation")];
    let svg = drawing(&cases, clock)?;
    blocks.extend(svg.map(|svg| {
        Block::Plot(Plot {
            caption: "Time of drawing against triangles, one curve a window; both axes logarithmic. Time that does not \
                      depend on tessellation is level."
                .to_owned(),
            svg,
        })
    }));
    blocks.push(Block::Table(tessellation_table(&cases, clock)));
    blocks.push(Block::Finding(finding(&cases, clock, noise)));
    Ok(blocks)
}

/// In the order in which they were planned.
fn windows<'a>(cases: &[&'a Case]) -> Vec<&'a str> {
    let mut windows: Vec<&str> = Vec::new();
    for case in cases {
        if !windows.contains(&case.condition(SIZE_PX)) {
            windows.push(case.condition(SIZE_PX));
        }
    }
    windows
}

fn drawing(cases: &[&Case], clock: Clock) -> Result<Option<String>, ChapterError> {
    let windows = windows(cases);
    let name = |window: &str| format!("{window}² px");
    let palette = Palette::new(windows.iter().map(|window| name(window)).collect());
    let metric = draw(clock);
    let point = |case: &&Case| -> Option<Point> {
        let triangles = value(case, GLOBE_TRIANGLES)?;
        let spread = sample_spread(case, metric).filter(|_| case.counts())?;
        let replicates: Vec<f64> = process_medians(case, metric).into_values().collect();
        Some(Point {
            knob: triangles,
            label: significant(triangles),
            x: Some(Reading::exact(triangles)),
            y: Some(Reading::sampled(spread, &replicates)),
            y_rms: None,
            standing: PointStanding::Right,
            command: String::new(),
        })
    };
    let up = clock.pick("draw, GPU ms", "draw, process CPU ms");
    let plots = SHADERS.map(|(removed, title)| WorkPrecision {
        title,
        across: "triangles",
        up,
        upwards: Upwards::Amount,
        curves: windows
            .iter()
            .map(|window| Curve {
                name: name(window),
                points: with(
                    &with(cases, keys::REMOVED, &removed.to_string()),
                    SIZE_PX,
                    window,
                )
                .iter()
                .filter_map(point)
                .collect(),
            })
            .collect(),
        lines: Vec::new(),
    });
    let title = "time of drawing a globe against its triangles";
    Ok(panels(title, &plots, Arrangement::SideBySide, &palette)?)
}

fn tessellation_table(cases: &[&Case], clock: Clock) -> Table {
    let drawing = draw(clock);
    let [full, white] =
        SHADERS.map(|(removed, _)| with(cases, keys::REMOVED, &removed.to_string()));
    let largest = windows(cases).last().copied().unwrap_or_default();
    let firsts = [&full, &white].map(|cases| {
        let first = cases
            .iter()
            .rev()
            .find(|case| case.condition(SIZE_PX) == largest);
        first.and_then(|case| value(case, drawing))
    });
    let rows = full.iter().rev().map(|case| {
        let key = |case: &Case| {
            [
                case.condition(SIZE_PX).to_owned(),
                case.condition(CELLS).to_owned(),
            ]
        };
        let plain = white.iter().find(|other| key(other) == key(case));
        let times =
            [Some(*case), plain.copied()].map(|case| case.and_then(|case| value(case, drawing)));
        let mut cells = vec![
            Cell::plain(format!("{}²", case.condition(SIZE_PX))),
            Cell::or_absent(
                value(case, GLOBE_TRIANGLES).map(significant),
                "not measured",
            ),
        ];
        for (ms, first) in times.into_iter().zip(firsts) {
            let ratio = ms.zip(first).map(|(ms, first)| ms / first);
            cells.push(Cell::or_absent(ratio.map(significant), "not measured"));
            cells.push(Cell::or_absent(ms.map(significant), "not measured"));
        }
        Row::new(cells)
    });
    Table {
        caption: "Windows and triangles as in Gebbie & Bailey's Table 1, with the full shader and a white one; ratios to \
                  the first row"
            .to_owned(),
        headings: vec![
            Heading::plain("window"),
            Heading::metric("triangles", GLOBE_TRIANGLES),
            Heading::plain("full, ratio"),
            Heading::metric("full, draw ms", drawing),
            Heading::plain("white, ratio"),
            Heading::metric("white, draw ms", drawing),
        ],
        rows: rows.collect(),
        ..Table::default()
    }
}

/// Time with the most triangles over that with the fewest, by window.
fn growth(cases: &[&Case], clock: Clock) -> Vec<(String, Estimate)> {
    let of = |window: &&str| {
        let own = with(cases, SIZE_PX, window);
        let mut times: Vec<(f64, &Case)> = own
            .iter()
            .filter_map(|case| {
                value(case, draw(clock))?;
                Some((value(case, GLOBE_TRIANGLES)?, *case))
            })
            .collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (fewest, most) = (times.first()?, times.last()?);
        let growth = ratio(most.1, fewest.1, draw(clock))?;
        (times.len() > 1).then(|| ((*window).to_owned(), growth))
    };
    windows(cases).iter().filter_map(of).collect()
}

fn per_cent(share: f64) -> String {
    format!("{:+.1} %", 100.0 * share)
}

/// The claim is false where one window's time grows by more than 3 % and by more than identical work differs, and
/// true where no interval has so much.
fn standing(growth: &[(String, Estimate)], noise: Option<Noise>) -> Standing {
    let grows = |ratio: &Estimate| {
        let is_longer = Standing::of_times(ratio, noise).0 == Standing::Holds;
        is_longer
            && ratio
                .interval
                .is_some_and(|[low, _]| low - 1.0 > INDEPENDENT)
    };
    let is_level = |ratio: &Estimate| {
        ratio
            .interval
            .is_some_and(|[_, high]| high - 1.0 <= INDEPENDENT)
    };
    let mut ratios = growth.iter().map(|(_, ratio)| ratio);
    match growth.is_empty() {
        true => Standing::CannotTell,
        false if ratios.clone().any(grows) => Standing::DoesNotHold,
        false if ratios.all(is_level) => Standing::Holds,
        false => Standing::CannotTell,
    }
}

fn finding(cases: &[&Case], clock: Clock, noise: Option<Noise>) -> Finding {
    let words = |growth: &[(String, Estimate)]| {
        let shares = growth
            .iter()
            .map(|(window, ratio)| format!("{window}²: {}", per_cent(ratio.middle - 1.0)));
        shares.collect::<Vec<_>>().join(", ")
    };
    let [full, white] = SHADERS
        .map(|(removed, _)| growth(&with(cases, keys::REMOVED, &removed.to_string()), clock));
    let [published, _] = tessellation_published();
    let published: Vec<String> = published.iter().map(|share| per_cent(*share)).collect();
    let noise_text = match noise {
        Some(noise) => format!(
            "Identical work differed by up to {} %.",
            significant(100.0 * (noise.max_factor() - 1.0))
        ),
        None => "No identical work was measured twice.".to_owned(),
    };
    Finding {
        claim: "Gebbie & Bailey: with the full shader GPU time does not depend on the number of triangles".to_owned(),
        standing: standing(&full, noise),
        because: format!(
            "From 2,146 triangles to 17,058 about, full shader: {}; white: {}. Published, full, at 1000², 800², 600²: {}. \
             More than {} % counts as dependent. {noise_text}",
            words(&full),
            words(&white),
            published.join(", "),
            100.0 * INDEPENDENT
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Windows whose times grow by these ratios in every process.
    fn growth_of(ratios: &[f64], processes: usize) -> Vec<(String, Estimate)> {
        let estimate = |ratio: &f64| Estimate {
            middle: *ratio,
            interval: (processes >= 5).then_some([*ratio; 2]),
            processes,
        };
        let windows = ratios
            .iter()
            .map(|ratio| ("600".to_owned(), estimate(ratio)));
        windows.collect()
    }

    #[test]
    fn growth_beyond_the_noise_is_dependence_and_within_it_nothing_is_known() {
        let noise = Noise {
            max: 0.1,
            median: 0.01,
            pairs: 4,
            reach: 0.1,
            between: None,
        };
        let of = |ratios: &[f64]| standing(&growth_of(ratios, 5), Some(noise));
        assert_eq!(of(&[]), Standing::CannotTell);
        assert_eq!(of(&[1.02, 0.95]), Standing::Holds);
        // Twins: within the noise, and beyond it.
        assert_eq!(of(&[1.02, 1.05]), Standing::CannotTell);
        assert_eq!(of(&[1.02, 1.3]), Standing::DoesNotHold);
        // Too few processes decide nothing.
        let few = growth_of(&[1.02, 1.3], 3);
        assert_eq!(standing(&few, Some(noise)), Standing::CannotTell);
    }
}
