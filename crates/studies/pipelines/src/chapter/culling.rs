// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two-level culling: what each test keeps and loses, what each way costs, and the flight with and without level 2.

use super::kit::{FRAME, WHOLE, beside, compared, counter, frame_time, gain, percent, ratios};
use crate::culling::{CullStage, RANGES, Test, VIEWS};
use crate::metrics::*;
use terrafill_lab::{
    Cases, Column, Drawing, Figure, Follows, Names, Panel, Section, Select, finding,
};
use terrafill_plot::number::{digits, significant};
use terrafill_results::{Case, Claim, Estimate, Finding, Noise};

/// Patches that a box may keep beyond those needed.
const EXTRA_SHARE: f64 = 0.02;

pub(super) const SECTION: Section<'static> = Section {
    title: "Two-level culling",
    text: "Ground of 8 × 8 tiles with relief of ten octaves, cells of 30 m. A tile is 256 × 256 cells as published, and \
           64 × 64 in a quick run; how many tiles there were is not stated. Level 1: the CPU keeps the tiles whose box \
           of least and greatest height meets the view. Level 2: patches of 8 × 8 cells of these tiles are tested. A \
           patch is needed where one of its cells is not wholly outside of one plane of the view, cell by cell in \
           double precision. The published test labels a point of each patch, projected, \"against a range\". Neither \
           the range nor which point is stated. Here it is the first corner; w is above 0, and |x/w| and |y/w| are up \
           to the range that follows the test's name. A frame that lost a patch is wrong: its time says what the test costs, \
           and no recommendation names it. Pictures show the views, and in red what a test of points takes out of \
           them. Times are by the clock of height grids.",
    cases: Select::With(EXPERIMENT, "culling"),
    per: Some(VIEW),
    named_by: Names::Columns(&[("interface", API), ("level 2 in", PLACE), ("test", TEST)]),
    pictures: &[("picture", "")],
    columns: &[
        Column::of("time, ms", FRAME),
        ratios("time without the test ÷ time", |cases, case| {
            gain(without(cases, case), Some(case), frame_time(cases.clock()))
        }),
        Column::metric("tiles", CULL_TILES),
        Column::metric("patches needed", CULL_NEEDED),
        Column::metric("drawn", CULL_KEPT),
        Column::metric("lost", CULL_LOST).or(NOT_LISTED),
        percent("too many, %", CULL_EXTRA_SHARE).or(NOT_LISTED),
        counter("vertices shaded", PIPELINE_VERTEX_INVOCATIONS),
        counter("geometry invocations", PIPELINE_GEOMETRY_INVOCATIONS),
        Column::metric("sent a frame", PIPELINE_SENT_BYTES),
        Column::metric("pixels that differ", PIPELINE_DIFFERING_PX),
    ],
    is_main: true,
    findings: &[
        |cases| exact(cases, RANGES[0]),
        |cases| exact(cases, RANGES[1]),
        |cases| exact(cases, RANGES[2]),
    ],
    ..Section::EMPTY
};

const NOT_LISTED: &str = "this stage says how many it draws, and no list of its test has as many";

pub(super) const FLIGHT: Section<'static> = Section {
    title: "The flight with and without level 2",
    text: "The published figure shows frames per second along a fly-through of 25 s, with and without level 2, between \
           60 and 240. Its path, window and patches are not stated, and which curve is which cannot be read from its \
           text, which says that level 2 is faster. The flight here is its own, on Vulkan.",
    cases: Select::With(EXPERIMENT, "culling-flight"),
    findings: &[
        |cases| faster(cases, "compute"),
        |cases| faster(cases, "geometry-shader"),
    ],
    drawing: Some(Drawing {
        caption: "Along the flight: time of a frame, and patches that are drawn, whose share bounds what level 2 can gain.",
        panels: &[
            Panel {
                title: "time",
                up: ("frame, ms", FRAME),
                ..ALONG
            },
            Panel {
                title: "patches",
                up: ("patches drawn", Figure::Metric(CULL_KEPT)),
                ..ALONG
            },
        ],
    }),
    ..Section::EMPTY
};

const ALONG: Panel<'static> = Panel {
    across: ("second of the flight", Figure::Condition(FLIGHT_S)),
    curve: Names::Joined(&[PLACE, TEST]),
    knob: Figure::Condition(FLIGHT_S),
    ..Panel::EMPTY
};

/// Where patches are drawn by the same stages untested: what makes a list draws as tiles alone do.
fn untested(place: &str) -> &str {
    match place {
        "compute" | "cpu" => "tiles-alone",
        stage => stage,
    }
}

/// The same case without level 2.
fn without<'a>(cases: &Cases<'a>, case: &Case) -> Option<&'a Case> {
    let place = untested(case.condition(PLACE));
    beside(cases, case, &[(PLACE, place), (TEST, "none")])
}

/// What is required: boxes lose nothing and keep little.
pub(super) fn requirements(cases: &Cases<'_>) -> Vec<Finding> {
    if cases.with(&[(EXPERIMENT, "culling")]).is_empty() {
        return Vec::new();
    }
    let lost = cases.with(&[(TEST, "box")]).values(CULL_LOST);
    let most = lost.iter().copied().max_by(f64::total_cmp);
    let boxes = cases.with(&[(EXPERIMENT, "culling"), (TEST, "box")]);
    let tile_cells = boxes.first().map_or("", |case| case.condition(TILE_CELLS));
    let extra = boxes.greatest(CULL_EXTRA_SHARE);
    // Smaller tiles have coarser relief a patch, of which that is not asked.
    let is_little = extra
        .filter(|_| tile_cells == "256")
        .map(|extra| extra <= EXTRA_SHARE);
    vec![
        finding(
            "A box of least and greatest height loses no patch in view:",
            most.map(|most| most <= 0.0),
            most.map_or_else(String::new, |most| {
                format!("at most {most} in {} cases", lost.len())
            }),
        ),
        finding(
            "In the views of tiles of 256 cells a box keeps at most 2 % more patches than are needed:",
            is_little,
            extra.map_or_else(String::new, |extra| {
                format!(
                    "at most {} %, tiles of {tile_cells} cells",
                    significant(100.0 * extra)
                )
            }),
        ),
    ]
}

/// A frame without the test has no place in which it is done.
const WITH_THE_TEST: [Follows<'static>; 1] = [Follows {
    key: PLACE.name(),
    because: "a frame without the test has no place in which it is done",
}];

/// What is published of the flight, by the second whose gain is the median.
fn faster(cases: &Cases<'_>, place: &str) -> Finding {
    let metric = frame_time(cases.clock());
    let own = cases.with(&[(PLACE, place), (TEST, "box")]);
    let pair = |case| {
        let without = without(cases, case)?;
        Some(([without, case], gain(Some(without), Some(case), metric)?))
    };
    let mut pairs: Vec<([&Case; 2], Estimate)> = own.iter().filter_map(pair).collect();
    pairs.sort_by(|a, b| a.1.middle.total_cmp(&b.1.middle));
    let middle = pairs.get(pairs.len() / 2).map(|(pair, _)| *pair);
    let ends = pairs.first().zip(pairs.last()).map(|(slow, fast)| {
        let [slow, fast] = [slow, fast].map(|of| significant(of.1.middle));
        format!(", {slow} to {fast} times")
    });
    let claim = format!(
        "Level 2 in {place} raises the frame rate along the flight{}, in the median (published, measured):",
        ends.unwrap_or_default()
    );
    let says = (claim, Claim::Faster);
    compared(
        cases,
        (TEST, &WITH_THE_TEST),
        (metric, WHOLE),
        middle.as_slice(),
        says,
    )
}

/// Whether the published test in a range loses nothing, and its time against that of the box in the same stage.
fn exact(cases: &Cases<'_>, range: f32) -> Finding {
    let test = Test::Point(range).name();
    let vulkan = cases.with(&[(API, "vulkan")]);
    let own = vulkan.with(&[(TEST, &test)]);
    let lost = own.values(CULL_LOST);
    let of_view = |(view, cases): (&str, Cases<'_>)| {
        let [lost, needed] = [CULL_LOST, CULL_NEEDED].map(|metric| cases.greatest(metric));
        Some(format!(
            "{} of {} in {view}",
            digits(lost?),
            digits(needed?)
        ))
    };
    let against_box = |place: &str| {
        let [point, boxes] = [test.as_str(), "box"].map(|test| Views::of(&vulkan, place, test));
        Some(format!("{} in {place}", significant(point?.ms / boxes?.ms)))
    };
    let of_views: Vec<String> = own.by(VIEW).into_iter().filter_map(of_view).collect();
    let places = own.distinct(PLACE).into_iter();
    let times: Vec<String> = places.filter_map(against_box).collect();
    finding(
        format!("A {test} test is exact, as published:"),
        (!lost.is_empty()).then(|| lost.iter().all(|lost| *lost <= 0.0)),
        format!(
            "patches lost: {}; time of the views ÷ that of the box in the same stage: {}",
            of_views.join(", "),
            times.join(", ")
        ),
    )
}

/// Time, patches and vertices of the views together.
struct Views {
    ms: f64,
    patches: f64,
    shaded: Option<f64>,
}

impl Views {
    /// `None` where one of them was not measured.
    fn of(cases: &Cases<'_>, place: &str, test: &str) -> Option<Self> {
        let own = cases.with(&[(PLACE, place), (TEST, test)]);
        let own = own.fitting(|case| case.counts() || case.planned.may_be_wrong);
        let all = |metric| -> Option<f64> {
            let values = own.values(metric);
            (values.len() == VIEWS.len()).then(|| values.iter().sum())
        };
        Some(Self {
            ms: all(frame_time(cases.clock()))?,
            patches: all(CULL_KEPT)?,
            shaded: all(PIPELINE_VERTEX_INVOCATIONS),
        })
    }
}

/// The place to cull by boxes in, by the sum of the views' times, with the counters behind it. Tests of a point are
/// none of them: they lose patches in view.
pub(super) fn recommended(cases: &Cases<'_>) -> Vec<String> {
    let own = cases.with(&[(EXPERIMENT, "culling")]);
    let band = Noise::band(own.noise(frame_time(cases.clock())));
    let on = |api: &str| {
        let own = own.with(&[(API, api)]);
        let places = CullStage::ALL.into_iter().map(CullStage::name);
        let culled = places.filter_map(|place| Some((place, Views::of(&own, place, "box")?)));
        let culled: Vec<(&str, Views)> = culled.collect();
        let (place, best) = culled.iter().min_by(|a, b| a.1.ms.total_cmp(&b.1.ms))?;
        let ties = culled
            .iter()
            .filter(|(other, views)| other != place && views.ms <= band * best.ms);
        let ties: Vec<&str> = ties.map(|(other, _)| *other).collect();
        let ties = if ties.is_empty() {
            String::new()
        } else {
            format!(", tied with {}", ties.join(" and "))
        };
        let shaded = best.shaded.map_or_else(String::new, |shaded| {
            format!(" and {} vertex shader invocations", significant(shaded))
        });
        let without = Views::of(&own, untested(place), "none");
        let advice = match &without {
            Some(without) if without.ms * band < best.ms => {
                "culling patches by their boxes gains nothing, least slow"
            }
            Some(without) if without.ms <= band * best.ms => {
                "culling patches by their boxes makes no difference, least slow"
            }
            _ => "culling patches by their boxes is fastest",
        };
        let against = without.map_or_else(
            || "the same stages without the test were not measured".to_owned(),
            |without| {
                let [ms, patches] = [without.ms, without.patches].map(significant);
                format!("against {ms} ms and {patches} patches by the same stages without the test")
            },
        );
        Some(format!(
            "On {api} {advice} in {place}{ties}: {} ms for the views, {} patches drawn{shaded}; {against}.",
            significant(best.ms),
            significant(best.patches),
        ))
    };
    let points = own.fitting(|case| case.condition(TEST).starts_with("point"));
    let is_lossy = points.values(CULL_LOST).iter().any(|lost| *lost > 0.0);
    let warning = is_lossy.then(|| "The published test of a point loses patches in view.".into());
    let best = ["vulkan", "wgpu"].into_iter().filter_map(on);
    best.chain(warning).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::culling::group;
    use crate::images::PICTURE;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{CaseId, Run, Standing, Status};

    fn differing(one: &CaseId, other: &CaseId) -> Vec<String> {
        let keys = one.conditions.keys().chain(other.conditions.keys());
        let mut keys: Vec<String> = keys.map(ToString::to_string).collect();
        keys.sort_unstable();
        keys.dedup();
        keys.retain(|key| one.condition(key) != other.condition(key));
        keys
    }

    #[test]
    fn a_stage_with_the_test_is_held_against_the_same_stage_without_it() {
        for is_quick in [true, false] {
            let all = group(is_quick, (PICTURE, 1));
            let ids: Vec<&CaseId> = all.cases.iter().map(|case| &case.id).collect();
            let at = |place: &str, test: &str, view: &str| {
                let is_it = |id: &&&CaseId| {
                    id.condition("api") == "vulkan"
                        && id.condition("place") == place
                        && id.condition("test") == test
                        && id.condition("view") == view
                };
                *ids.iter().find(is_it).expect("a planned case")
            };
            for view in VIEWS {
                for stage in ["geometry-shader", "task-shader"] {
                    let tested = at(stage, "box", view.name);
                    let pair = at(untested(stage), "none", view.name);
                    assert_eq!(differing(tested, pair), ["test"]);
                    // Negative control: tiles alone come by other stages too.
                    let alone = at("tiles-alone", "none", view.name);
                    assert_eq!(differing(tested, alone), ["place", "test"]);
                }
            }
        }
    }

    /// - `lost`: patches of each view that tests of a point lose
    fn run_of(figures: &[(&str, &str, f64)], lost: f64) -> Run {
        let mut made = MadeUpRun::default();
        for view in VIEWS {
            for &(place, test, ms) in figures {
                let conditions = [
                    ("experiment", "culling"),
                    ("api", "vulkan"),
                    ("place", place),
                    ("test", test),
                    ("view", view.name),
                    ("tile_cells", "256"),
                ];
                let name = format!("{place}/{test}/{}", view.name);
                let case = made.case(case_id(crate::STUDY, &name, &conditions));
                case.timed("pipeline_cpu_ms", &[ms]);
                case.figure("cull_kept", 100.0);
                case.figure("cull_needed", 100.0);
                if test.starts_with("point") {
                    case.figure("cull_lost", lost).may_be_wrong = true;
                }
                if case.may_be_wrong && lost > 0.0 {
                    case.ended(Status::Wrong, "patches are lost");
                }
            }
        }
        made.loaded()
    }

    #[test]
    fn what_the_test_gains_is_said_of_one_stage_alone() {
        let said = |figures: &[(&str, &str, f64)]| {
            let run = run_of(figures, 0.0);
            recommended(&Cases::of_study(&run, crate::STUDY)).join(" ")
        };
        let alone = ("tiles-alone", "none", 2.0);
        let tested = ("task-shader", "box", 1.0);
        let all = said(&[alone, tested, ("task-shader", "none", 1.2)]);
        assert!(all.contains("fastest in task-shader: 3.00 ms"), "{all}");
        assert!(all.contains("against 3.60 ms"), "{all}");
        // Negative controls: a test that gains nothing in its stage, and a stage without its control.
        let slower = said(&[alone, tested, ("task-shader", "none", 0.9)]);
        assert!(slower.contains("gains nothing"), "{slower}");
        let same = said(&[alone, tested, ("task-shader", "none", 1.0)]);
        assert!(same.contains("makes no difference"), "{same}");
        let lacking = said(&[alone, tested]);
        assert!(lacking.contains("were not measured"), "{lacking}");
        assert!(!lacking.contains("6.00 ms"), "{lacking}");
    }

    #[test]
    fn a_test_that_loses_patches_has_its_cost_beside_and_is_never_named() {
        let of = |lost| {
            let figures = ["none", "box", "point-1"].into_iter().zip([3.0, 2.0, 1.0]);
            let figures: Vec<_> = figures
                .map(|(test, ms)| ("geometry-shader", test, ms))
                .collect();
            let run = run_of(&figures, lost);
            let cases = Cases::of_study(&run, crate::STUDY);
            (recommended(&cases).join(" "), exact(&cases, 1.0))
        };
        let (said, found) = of(3.0);
        assert!(
            said.contains("fastest in geometry-shader: 6.00 ms"),
            "{said}"
        );
        assert!(said.contains("loses patches"), "{said}");
        assert_eq!(found.standing, Standing::DoesNotHold);
        for part in ["3 of 100 in 10-km-nadir", "0.500 in geometry-shader"] {
            assert!(found.because.contains(part), "{found:?}");
        }
        // Negative control: a test that loses none.
        let (said, found) = of(0.0);
        assert!(!said.contains("loses"), "{said}");
        assert_eq!(found.standing, Standing::Holds);
    }
}
