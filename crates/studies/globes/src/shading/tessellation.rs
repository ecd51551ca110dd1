// SPDX-License-Identifier: MIT OR Apache-2.0
//! Time against the number of triangles, with the full shader and with a white one: the windows and triangles of Gebbie
//! and Bailey's Table 1.

use super::is_of;
use super::work::REMOVED;
use crate::metrics::{self, CELLS, GLOBE_DRAW_CPU_MS, GLOBE_DRAW_GPU_MS, GLOBE_TRIANGLES, SIZE_PX};
use terrafill_globe_views::{DRAW, compared_in, draw};
use terrafill_lab::{Cases, Column, Drawing, Figure, Names, Panel, Section, Select};
use terrafill_plot::number::{significant, times};
use terrafill_results::{Case, Claim, Finding, Scope, ratio};

/// Share of the time above which time is not independent of the number of triangles.
const INDEPENDENT: f64 = 0.03;

/// Gebbie & Bailey, Table 1: GPU ms with the full shader at 1000², 800² and 600², of 17,058 triangles and of 2,146.
pub(crate) const PUBLISHED_MS: [[f64; 2]; 3] = [[13.313, 13.7], [9.623, 9.37], [6.3, 5.884]];

pub(super) const SECTION: Section<'static> = Section {
    title: "Time against tessellation",
    text: "Windows and triangles as in Gebbie & Bailey's Table 1, with the full shader and with all seven features \
           removed. Time that does not depend on tessellation is level.",
    cases: Select::Fitting(|case| is_of(case, "tessellation")),
    named_by: Names::Columns(&[
        ("window, px", SIZE_PX),
        ("features removed", metrics::REMOVED),
    ]),
    columns: &[Column::metric("triangles", GLOBE_TRIANGLES), DRAW],
    findings: &[independent],
    drawing: Some(Drawing {
        caption: "Time of drawing against triangles, one curve a window and shader; both axes logarithmic.",
        panels: &[Panel {
            across: ("triangles", Figure::Metric(GLOBE_TRIANGLES)),
            up: (
                "draw, ms",
                Figure::ByClock(GLOBE_DRAW_GPU_MS, GLOBE_DRAW_CPU_MS),
            ),
            curve: Names::Of("", |case| {
                let [window, removed] = [SIZE_PX, metrics::REMOVED].map(|key| case.condition(key));
                format!("{window}² px, {removed} removed")
            }),
            knob: Figure::Metric(GLOBE_TRIANGLES),
            ..Panel::EMPTY
        }],
    }),
    ..Section::EMPTY
};

/// Of each window the case with the most triangles and the one with the fewest.
fn ends<'a>(cases: &Cases<'a>, removed: u32) -> Vec<[&'a Case; 2]> {
    let own = cases.with(&[(metrics::REMOVED, &removed.to_string())]);
    let of = |window: Cases<'a>| {
        let mut own: Vec<&Case> = window.iter().collect();
        own.sort_by(|a, b| {
            let [a, b] = [a, b].map(|case| case.value(GLOBE_TRIANGLES).unwrap_or(0.0));
            a.total_cmp(&b)
        });
        match own[..] {
            [fewest, .., most] => Some([most, fewest]),
            _ => None,
        }
    };
    let windows = own.by(SIZE_PX).into_iter();
    windows.filter_map(|(_, window)| of(window)).collect()
}

fn independent(cases: &Cases<'_>) -> Finding {
    let metric = draw(cases.clock());
    let white = ends(cases, REMOVED).into_iter();
    let white = white.filter_map(|[most, fewest]| ratio(most, fewest, metric));
    let white: Vec<String> = white.map(|growth| times(&growth)).collect();
    let published = PUBLISHED_MS.map(|[most, fewest]| significant(most / fewest));
    let found = cases.compared(
        &compared_in(CELLS, metric, Scope::DRAW),
        &ends(cases, 0),
        Claim::LessThan(1.0 + INDEPENDENT),
        format!(
            "Gebbie & Bailey: with the full shader GPU time does not depend on the number of triangles: eight times as \
             many take at most {} % longer",
            100.0 * INDEPENDENT
        ),
    );
    Finding {
        because: format!(
            "By window, full shader: {}. White: {}. Published, full, at 1000², 800², 600²: {}.",
            found.because,
            white.join("; "),
            published.join("; ")
        ),
        ..found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Clock, Standing};

    /// What times with many triangles, over 1 ms with few, say of one window each; a repeat takes as much longer.
    fn standing(ratios: &[f64], repeat: f64, processes: usize) -> Standing {
        let mut made = MadeUpRun::default();
        for (window, ratio) in ratios.iter().enumerate() {
            for (n, triangles, ms) in [("47", 2_146.0, 1.0), ("132", 17_058.0, *ratio)] {
                let window = window.to_string();
                let conditions = [
                    ("part", super::super::PART),
                    ("what", "tessellation"),
                    ("removed", "0"),
                    ("size_px", &window),
                    ("n", n),
                ];
                let id = case_id(crate::STUDY, &format!("{window}/{n}"), &conditions);
                let metric = draw(Clock::ProcessCpu);
                made.case(id.repeat())
                    .timed(metric, &vec![repeat * ms; processes]);
                let case = made.case(id);
                case.timed(metric, &vec![ms; processes]);
                case.figure(GLOBE_TRIANGLES, triangles);
            }
        }
        independent(&Cases::of_study(&made.loaded(), crate::STUDY)).standing
    }

    #[test]
    fn growth_beyond_the_noise_is_dependence_and_within_it_nothing_is_known() {
        let of = |ratios: &[f64]| standing(ratios, 1.1, 5);
        assert_eq!(of(&[]), Standing::NotMeasured);
        assert_eq!(of(&[1.02, 0.95]), Standing::Holds);
        // Negative controls: within the noise, and beyond it.
        assert_eq!(of(&[1.02, 1.05]), Standing::NoDifference);
        assert_eq!(of(&[1.02, 1.3]), Standing::DoesNotHold);
        // Too few processes decide nothing.
        assert_eq!(standing(&[1.02, 1.3], 1.1, 3), Standing::CannotTell);
    }
}
