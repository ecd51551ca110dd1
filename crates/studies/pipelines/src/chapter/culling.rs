// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two-level culling: what each test keeps and loses, what each way costs, and the flight with and without level 2.

use super::kit::{
    FRAME, WHOLE, beside, compared, counter, frame_time, gain, percent, ratios, remark,
};
use crate::culling::{CullStage, VIEWS};
use crate::metrics::*;
use terrafill_lab::{
    Cases, Column, Drawing, Figure, Follows, Names, Panel, Section, Select, finding,
};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Claim, Estimate, Finding, Noise};

/// Patches that a box may keep beyond those needed.
const EXTRA_SHARE: f64 = 0.02;

/// Patches that each range of the published test lost in views of the same kind, as computed apart from this program: tiles
/// of 256 cells, other relief of ten octaves.
const COMPUTED_APART: [(&str, [u32; 5]); 3] = [
    ("point-1", [570, 570, 547, 139, 455]),
    ("point-1.25", [15, 12, 3, 0, 17]),
    ("point-2", [5, 5, 0, 0, 4]),
];

const WHAT_FIGURE_8_CANNOT_SHOW: &str = "The published figure shows frames per second along a fly-through of 25 s, with and without level 2, \
     between 60 and 240. Its path, window and patches are not stated, and which curve is which cannot \
     be read from its text, which says that level 2 is faster. The flight here is its own.";

pub(super) const SECTION: Section<'static> = Section {
    title: "Two-level culling",
    caption: "Every place and test in the five views",
    text: "Ground of 16 × 16 tiles with relief of ten octaves, cells of 30 m. Level 1: the CPU keeps the tiles whose box \
           meets the view. Level 2: patches of 8 × 8 cells. A patch is needed where one of its cells is not wholly \
           outside of one plane of the view, cell by cell in double precision. The published test labels a point of \
           each patch, projected, \"against a range\"; the range is not stated, and which point is not either: here its \
           first corner, |x/w| and |y/w| up to the range, w above 0. A case that loses a patch or a pixel is wrong and \
           not timed. Pictures show the five views, and in red what a test of points takes out of them. Times are by \
           the clock of height grids.",
    cases: Select::With(EXPERIMENT, "culling"),
    named_by: Names::Columns(&[
        ("view", VIEW),
        ("interface", API),
        ("level 2 in", PLACE),
        ("test", TEST),
    ]),
    pictures: &[("picture", "")],
    columns: &[
        Column::of("time, ms", FRAME),
        ratios("time without the test ÷ time", |cases, case| {
            gain(without(cases, case), Some(case), frame_time(cases.clock()))
        }),
        Column::metric("patches drawn", CULL_KEPT),
        Column::metric("lost", CULL_LOST),
        counter("vertices shaded", PIPELINE_VERTEX_INVOCATIONS),
        counter("geometry invocations", PIPELINE_GEOMETRY_INVOCATIONS),
        counter("primitives", PIPELINE_PRIMITIVES),
        Column::metric("sent a frame", PIPELINE_SENT_BYTES),
        Column::metric("pixels that differ", PIPELINE_DIFFERING_PX),
    ],
    ..Section::EMPTY
};

pub(super) const COUNTED: Section<'static> = Section {
    title: "Patches that each test keeps and loses",
    text: "Counted by the reference: of the frames that are timed, and of tiles of 256 cells, whose frames are not.",
    cases: Select::Fitting(|case| {
        let is_of_views = matches!(case.condition(EXPERIMENT), "culling" | "culling-count");
        is_of_views && matches!(case.condition(PLACE), "tiles-alone" | "compute")
    }),
    named_by: Names::Columns(&[
        ("counted for", EXPERIMENT),
        ("tile's cells a side", TILE_CELLS),
        ("view", VIEW),
        ("interface", API),
        ("test", TEST),
    ]),
    columns: &[
        Column::metric("tiles kept", CULL_TILES),
        Column::metric("patches in them", CULL_IN_TILES),
        Column::metric("needed", CULL_NEEDED),
        Column::metric("kept", CULL_KEPT),
        Column::metric("lost", CULL_LOST),
        percent("too many, %", CULL_EXTRA_SHARE),
    ],
    is_main: true,
    findings: &[
        |cases| exact(cases, 0),
        |cases| exact(cases, 1),
        |cases| exact(cases, 2),
    ],
    ..Section::EMPTY
};

pub(super) const FLIGHT: Section<'static> = Section {
    title: "The flight with and without level 2",
    cases: Select::With(EXPERIMENT, "culling-flight"),
    findings: &[
        |cases| faster(cases, "vulkan", "compute"),
        |cases| faster(cases, "vulkan", "geometry-shader"),
        |cases| faster(cases, "wgpu", "compute"),
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
    more: &[|_| remark(WHAT_FIGURE_8_CANNOT_SHOW)],
    ..Section::EMPTY
};

const ALONG: Panel<'static> = Panel {
    across: ("second of the flight", Figure::Condition(FLIGHT_S)),
    curve: Names::Joined(&[PLACE, TEST, API]),
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
    let counted = cases.with(&[(EXPERIMENT, "culling-count"), (TEST, "box")]);
    let tile_cells = counted
        .first()
        .map_or("256", |case| case.condition(TILE_CELLS));
    let extra = counted.greatest(CULL_EXTRA_SHARE);
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
            "In the five views of tiles of 256 cells a box keeps at most 2 % more patches than are needed:",
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
fn faster(cases: &Cases<'_>, api: &str, place: &str) -> Finding {
    let metric = frame_time(cases.clock());
    let own = cases.with(&[(API, api), (PLACE, place), (TEST, "box")]);
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
        "Level 2 in {place} on {api} raises the frame rate along the flight{}, in the median (published, measured):",
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

/// Whether the published test with one of its ranges loses nothing.
fn exact(cases: &Cases<'_>, range: usize) -> Finding {
    let (test, apart) = COMPUTED_APART[range];
    let counted = cases.with(&[(EXPERIMENT, "culling-count"), (TEST, test)]);
    let lost = counted.values(CULL_LOST);
    let list: Vec<String> = lost.iter().map(|lost| significant(*lost)).collect();
    let apart = apart.map(|lost| lost.to_string()).join(", ");
    finding(
        format!("A {test} test is exact, as the published text says of its range:"),
        (!lost.is_empty()).then(|| lost.iter().all(|lost| *lost <= 0.0)),
        format!(
            "patches lost in the five views: {}; computed apart from this program, on other relief: {apart}",
            list.join(", ")
        ),
    )
}

/// Time, patches and vertices of the five views together.
struct Views {
    ms: f64,
    patches: f64,
    shaded: Option<f64>,
}

impl Views {
    /// `None` where one of them was not measured.
    fn of(cases: &Cases<'_>, place: &str, test: &str) -> Option<Self> {
        let own = cases.with(&[(PLACE, place), (TEST, test)]);
        let own = own.fitting(Case::counts);
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

/// The place to cull in, by the sum of the five views' times, with the counters behind it.
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
            "On {api} {advice} in {place}{ties}: {} ms for the five views, {} patches drawn{shaded}; {against}.",
            significant(best.ms),
            significant(best.patches),
        ))
    };
    ["vulkan", "wgpu"].into_iter().filter_map(on).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::culling::groups;
    use crate::images::PICTURE;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{CaseId, Run};

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
            let all = groups(is_quick, (PICTURE, 1));
            let ids: Vec<&CaseId> = all[0].cases.iter().map(|case| &case.id).collect();
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

    fn run_of(figures: &[(&str, &str, f64)]) -> Run {
        let mut made = MadeUpRun::default();
        for view in VIEWS {
            for &(place, test, ms) in figures {
                let conditions = [
                    ("experiment", "culling"),
                    ("api", "vulkan"),
                    ("place", place),
                    ("test", test),
                    ("view", view.name),
                    ("tile_cells", "64"),
                ];
                let name = format!("{place}/{test}/{}", view.name);
                let case = made.case(case_id(crate::STUDY, &name, &conditions));
                case.timed("pipeline_cpu_ms", &[ms]);
                case.figure("cull_kept", 100.0);
            }
        }
        made.loaded()
    }

    #[test]
    fn what_the_test_gains_is_said_of_one_stage_alone() {
        let said = |figures: &[(&str, &str, f64)]| {
            let run = run_of(figures);
            recommended(&Cases::of_study(&run, crate::STUDY)).join(" ")
        };
        let alone = ("tiles-alone", "none", 2.0);
        let tested = ("task-shader", "box", 1.0);
        let all = said(&[alone, tested, ("task-shader", "none", 1.2)]);
        assert!(all.contains("fastest in task-shader: 5.00 ms"), "{all}");
        assert!(all.contains("against 6.00 ms"), "{all}");
        // Negative controls: a test that gains nothing in its stage, and a stage without its control.
        let slower = said(&[alone, tested, ("task-shader", "none", 0.9)]);
        assert!(slower.contains("gains nothing"), "{slower}");
        let same = said(&[alone, tested, ("task-shader", "none", 1.0)]);
        assert!(same.contains("makes no difference"), "{same}");
        let lacking = said(&[alone, tested]);
        assert!(lacking.contains("were not measured"), "{lacking}");
        assert!(!lacking.contains("10.0 ms"), "{lacking}");
    }
}
