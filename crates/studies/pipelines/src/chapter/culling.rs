// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two-level culling: what each test keeps and loses, what each way costs, and the flight with and without level 2.

use super::cells::{
    WHOLE, byte_cell, count, frame_time, gain, headings, of, paired_finding, time_cell, values,
    what_times_cover, why,
};
use crate::culling::{Place, VIEWS};
use crate::keys::{
    API, CULL_EXTRA_SHARE, CULL_IN_TILES, CULL_KEPT, CULL_LOST, CULL_NEEDED, CULL_TILES,
    EXPERIMENT, FLIGHT_S, PIPELINE_DIFFERING_PX, PIPELINE_GEOMETRY_INVOCATIONS,
    PIPELINE_PRIMITIVES, PIPELINE_SENT_BYTES, PIPELINE_VERTEX_INVOCATIONS, PLACE, TEST, TILE_CELLS,
    VIEW,
};
use terrafill_lab::Follows;
use terrafill_plot::number::{significant, times};
use terrafill_plot::{Palette, RatioAxis, RatioGroup, RatioPlot, RatioRow};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Claim, Clock, Estimate, Finding, Picture, PictureFigure,
    Pictures, Plot, Row, Run, Spread, Standing, Table,
};

/// Patches that a box may keep beyond those needed.
const EXTRA_SHARE: f64 = 0.02;

/// Patches that each range of the published test lost in views of the same kind, as computed apart from this program: tiles
/// of 256 cells, other relief of ten octaves.
const COMPUTED_APART: [(&str, [u32; 5]); 3] = [
    ("point-1", [570, 570, 547, 139, 455]),
    ("point-1.25", [15, 12, 3, 0, 17]),
    ("point-2", [5, 5, 0, 0, 4]),
];

const WHAT_IS_CULLED: &str = "Ground of 16 × 16 tiles with relief of ten octaves, cells of 30 m. Level 1: the CPU keeps the tiles whose box \
     meets the view. Level 2: patches of 8 × 8 cells. A patch is needed where one of its cells is not \
     wholly outside of one plane of the view, cell by cell in double precision. The published test labels \
     a point of each patch, projected, \"against a range\"; the range is not stated, and which point is \
     not either: here its first corner, |x/w| and |y/w| up to the range, w above 0. A case that loses a \
     patch or a pixel is wrong and not timed.";
const WHAT_FIGURE_8_CANNOT_SHOW: &str = "The published figure shows frames per second along a fly-through of 25 s, with and without level 2, \
     between 60 and 240. Its path, window and patches are not stated, and which curve is which cannot \
     be read from its text, which says that level 2 is faster. The flight here is its own.";

pub(super) fn section(cases: &[&Case], run: &Run) -> Result<Vec<Block>, ChapterError> {
    let clock = run.clock();
    let own = of(cases, &[(EXPERIMENT, "culling")]);
    if own.is_empty() {
        return Ok(Vec::new());
    }
    let flown = of(cases, &[(EXPERIMENT, "culling-flight")]);
    let mut blocks = vec![
        Block::section("Two-level culling"),
        Block::Text(WHAT_IS_CULLED.to_owned()),
        what_times_cover(clock),
    ];
    blocks.extend(claims(cases, run).into_iter().map(Block::Finding));
    let counted = of(cases, &[(EXPERIMENT, "culling-count")]);
    for cases in [&counted, &own] {
        if !cases.is_empty() {
            blocks.push(Block::Table(tests(cases)));
        }
    }
    blocks.extend(pictures(&own));
    blocks.push(Block::Table(ways(&own, clock)));
    let svg = drawing(&flown, clock)?;
    blocks.extend(svg.map(|svg| {
        Block::Plot(Plot {
            caption: "Along the flight: time of a frame without level 2 ÷ with it, by second; right of it, \
                      the share of the tiles' patches that level 2 keeps, which bounds what it can gain."
                .to_owned(),
            svg,
        })
    }));
    blocks.push(Block::Remark(WHAT_FIGURE_8_CANNOT_SHOW.to_owned()));
    Ok(blocks)
}

fn one<'a>(cases: &[&'a Case], api: &str, place: &str, test: &str, view: &str) -> Option<&'a Case> {
    let conditions = [(API, api), (PLACE, place), (TEST, test), (VIEW, view)];
    of(cases, &conditions).first().copied()
}

/// Where patches are drawn by the same stages untested: what makes a list draws as tiles alone do.
fn untested(place: &str) -> &str {
    match place {
        "compute" | "cpu" => "tiles-alone",
        stage => stage,
    }
}

/// Of a test in compute, on whichever interface counted it.
fn by_compute<'a>(cases: &[&'a Case], test: &str, view: &str) -> Option<&'a Case> {
    let on = |api| one(cases, api, "compute", test, view);
    let is_counted = |case: &&Case| case.value(CULL_LOST).is_some();
    on("vulkan")
        .filter(is_counted)
        .or_else(|| on("wgpu").filter(is_counted))
}

/// What is required: boxes lose nothing and keep little.
pub(super) fn findings(cases: &[&Case]) -> Vec<Finding> {
    let boxes: Vec<&Case> = cases
        .iter()
        .copied()
        .filter(|case| case.condition(TEST) == "box" && case.value(CULL_LOST).is_some())
        .collect();
    let all = |metric| -> Vec<f64> { boxes.iter().filter_map(|case| case.value(metric)).collect() };
    let most = |metric| all(metric).into_iter().max_by(f64::total_cmp);
    let in_views = |metric| {
        let own = of(&boxes, &[(EXPERIMENT, "culling-count")]);
        let values = own.into_iter().filter_map(|case| case.value(metric));
        values.max_by(f64::total_cmp)
    };
    if of(cases, &[(EXPERIMENT, "culling")]).is_empty() {
        return Vec::new();
    }
    let holds = |limit: f64, found: Option<f64>| {
        found.map_or(Standing::NotMeasured, |found| {
            Standing::holds_if(found <= limit)
        })
    };
    let (lost, extra) = (most(CULL_LOST), in_views(CULL_EXTRA_SHARE));
    let counted = of(cases, &[(EXPERIMENT, "culling-count")]);
    let tile_cells = counted
        .first()
        .map_or("256", |case| case.condition(TILE_CELLS));
    vec![
        Finding {
            claim: "A box of least and greatest height loses no patch in view:".to_owned(),
            standing: holds(0.0, lost),
            because: lost.map_or_else(String::new, |lost| {
                format!("at most {lost} in {} cases", boxes.len())
            }),
        },
        Finding {
            claim: "In the five views of tiles of 256 cells a box keeps at most 2 % more patches than are needed:"
                .to_owned(),
            // Smaller tiles have coarser relief a patch, of which that is not asked.
            standing: holds(EXTRA_SHARE, extra.filter(|_| tile_cells == "256")),
            because: extra.map_or_else(String::new, |extra| {
                format!("at most {} %, tiles of {tile_cells} cells", significant(100.0 * extra))
            }),
        },
    ]
}

/// Frames without level 2 and with it, and how many times as fast the second is, at every second of the flight.
fn flight_pairs<'a>(
    cases: &[&'a Case],
    api: &str,
    place: &str,
    clock: Clock,
) -> Vec<(u32, [&'a Case; 2], Estimate)> {
    let flown = of(cases, &[(EXPERIMENT, "culling-flight"), (API, api)]);
    let without = untested(place);
    let of_second = |second: u32| {
        let at = second.to_string();
        let case = |place, test| {
            let conditions = [(PLACE, place), (TEST, test), (FLIGHT_S, at.as_str())];
            of(&flown, &conditions).first().copied()
        };
        let pair = [case(without, "none")?, case(place, "box")?];
        let gain = gain(Some(pair[0]), Some(pair[1]), frame_time(clock))?;
        Some((second, pair, gain))
    };
    values(&flown, FLIGHT_S)
        .into_iter()
        .filter_map(of_second)
        .collect()
}

/// A frame without the test has no place in which it is done.
const WITH_THE_TEST: [Follows<'static>; 1] = [Follows {
    key: PLACE.name(),
    because: "a frame without the test has no place in which it is done",
}];

const FLOWN: [(&str, &str); 3] = [
    ("vulkan", "compute"),
    ("vulkan", "geometry-shader"),
    ("wgpu", "compute"),
];

/// What is published, held against what is measured.
fn claims(cases: &[&Case], run: &Run) -> Vec<Finding> {
    let mut claims = Vec::new();
    for (api, place) in FLOWN {
        let mut pairs = flight_pairs(cases, api, place, run.clock());
        pairs.sort_by(|a, b| a.2.middle.total_cmp(&b.2.middle));
        let middle = pairs.get(pairs.len() / 2).map(|(_, pair, _)| *pair);
        let ends = pairs.first().zip(pairs.last()).map(|(slow, fast)| {
            let [slow, fast] = [slow, fast].map(|of| significant(of.2.middle));
            format!(", {slow} to {fast} times")
        });
        let claim = format!(
            "Level 2 in {place} on {api} raises the frame rate along the flight{}, in the median (published, \
             measured):",
            ends.unwrap_or_default()
        );
        claims.push(paired_finding(
            run,
            (TEST, &WITH_THE_TEST),
            (frame_time(run.clock()), WHOLE),
            middle.as_slice(),
            (claim, Claim::Faster),
        ));
    }
    let lost = |test: &str| -> Vec<f64> {
        let own = VIEWS.iter().filter_map(|view| {
            let counted = of(cases, &[(EXPERIMENT, "culling-count")]);
            let own = of(cases, &[(EXPERIMENT, "culling")]);
            by_compute(&counted, test, view.name).or_else(|| by_compute(&own, test, view.name))
        });
        own.filter_map(|case| case.value(CULL_LOST)).collect()
    };
    for (test, apart) in COMPUTED_APART {
        let lost = lost(test);
        let list: Vec<String> = lost.iter().map(|lost| significant(*lost)).collect();
        let apart = apart.map(|lost| lost.to_string()).join(", ");
        claims.push(Finding {
            claim: format!("A {test} test is exact, as the published text says of its range:"),
            standing: match lost.is_empty() {
                true => Standing::NotMeasured,
                false => Standing::holds_if(lost.iter().all(|lost| *lost <= 0.0)),
            },
            because: format!(
                "patches lost in the five views: {}; computed apart from this program, on other relief: {apart}",
                list.join(", ")
            ),
        });
    }
    claims
}

/// The place to cull in, by the sum of the five views' times, with the counters behind it.
pub(super) fn recommended(cases: &[&Case], clock: Clock) -> Vec<String> {
    let own = of(cases, &[(EXPERIMENT, "culling")]);
    let mut sentences = Vec::new();
    for api in ["vulkan", "wgpu"] {
        let sum = |place: &str, test: &str| -> Option<(f64, f64, Option<f64>)> {
            let mut sums = (0.0, 0.0, Some(0.0));
            for view in VIEWS {
                let case = one(&own, api, place, test, view.name).filter(|case| case.counts())?;
                sums.0 += case.value(frame_time(clock))?;
                sums.1 += case.value(CULL_KEPT)?;
                let shaded = case.value(PIPELINE_VERTEX_INVOCATIONS);
                sums.2 = sums.2.zip(shaded).map(|(sum, shaded)| sum + shaded);
            }
            Some(sums)
        };
        let places = Place::ALL.into_iter().map(Place::name);
        let culled = places.filter_map(|place| Some((place, sum(place, "box")?)));
        let Some((place, best)) = culled.min_by(|a, b| a.1.0.total_cmp(&b.1.0)) else {
            continue;
        };
        let shaded = best.2.map_or_else(String::new, |shaded| {
            format!(" and {} vertex shader invocations", significant(shaded))
        });
        let without = sum(untested(place), "none");
        let is_slower = without.is_some_and(|without| without.0 <= best.0);
        let advice = match is_slower {
            true => "culling patches by their boxes gains nothing, least slow",
            false => "culling patches by their boxes is fastest",
        };
        let against = without.map_or_else(
            || "the same stages without the test were not measured".to_owned(),
            |without| {
                let [ms, patches] = [without.0, without.1].map(significant);
                format!("against {ms} ms and {patches} patches by the same stages without the test")
            },
        );
        sentences.push(format!(
            "On {api} {advice} in {place}: {} ms for the five views, {} patches drawn{shaded}; {against}.",
            significant(best.0),
            significant(best.1),
        ));
    }
    sentences
}

fn pictures(cases: &[&Case]) -> Option<Block> {
    let with_pictures = cases.iter().filter(|case| !case.note("picture").is_empty());
    let figures: Vec<PictureFigure> = with_pictures
        .map(|case| PictureFigure {
            pictures: vec![Picture {
                path: case.note("picture").to_owned(),
                caption: case.condition(VIEW).to_owned(),
            }],
            notes: vec![format!(
                "{}, test {}, on {}",
                case.condition(PLACE),
                case.condition(TEST),
                case.condition(API)
            )],
        })
        .collect();
    (!figures.is_empty()).then(|| {
        Block::Pictures(Pictures {
            caption: "The five views, and what a test of points takes out of them, in red: cells as a chessboard."
                .to_owned(),
            reference: String::new(),
            figures,
        })
    })
}

/// A row for each view: what each test keeps and loses.
fn tests(cases: &[&Case]) -> Table {
    let mut rows = Vec::new();
    let mut tile_cells = String::new();
    for view in VIEWS {
        let Some(boxed) = by_compute(cases, "box", view.name) else {
            continue;
        };
        tile_cells = boxed.condition(TILE_CELLS).to_owned();
        let figure = |case: Option<&Case>, metric| {
            let value = case.and_then(|case| case.value(metric));
            Cell::or_absent(value.map(significant), case.map_or("not measured", why))
        };
        let extra = boxed
            .value(CULL_EXTRA_SHARE)
            .map(|share| significant(100.0 * share));
        let mut cells = vec![
            Cell::name(view.name),
            figure(Some(boxed), CULL_TILES),
            figure(Some(boxed), CULL_IN_TILES),
            figure(Some(boxed), CULL_NEEDED),
            figure(Some(boxed), CULL_KEPT),
            figure(Some(boxed), CULL_LOST),
            Cell::or_absent(extra, why(boxed)),
        ];
        for test in ["point-1", "point-1.25", "point-2"] {
            let case = by_compute(cases, test, view.name);
            cells.push(figure(case, CULL_KEPT));
            cells.push(figure(case, CULL_LOST));
        }
        rows.push(Row::new(cells));
    }
    Table {
        caption: format!(
            "Patches that each test keeps and loses, tiles of {tile_cells} cells a side, counted by the reference"
        ),
        headings: headings(&[
            ("view", None),
            ("tiles kept", Some(CULL_TILES)),
            ("patches in them", Some(CULL_IN_TILES)),
            ("needed", Some(CULL_NEEDED)),
            ("box keeps", Some(CULL_KEPT)),
            ("box loses", Some(CULL_LOST)),
            ("box keeps too many, %", Some(CULL_EXTRA_SHARE)),
            ("point, range 1, keeps", None),
            ("loses", None),
            ("range 1.25 keeps", None),
            ("loses", None),
            ("range 2 keeps", None),
            ("loses", None),
        ]),
        rows,
        is_main: true,
        ..Table::default()
    }
}

/// A row for each view and way: time and counters.
fn ways(cases: &[&Case], clock: Clock) -> Table {
    let mut rows = Vec::new();
    for view in VIEWS {
        for case in of(cases, &[(VIEW, view.name)]) {
            let api = case.condition(API);
            let place = untested(case.condition(PLACE));
            let without = one(cases, api, place, "none", view.name);
            let gain = gain(without, Some(case), frame_time(clock));
            rows.push(Row {
                cells: vec![
                    Cell::name(view.name),
                    Cell::name(case.condition(API)),
                    Cell::name(case.condition(PLACE)),
                    Cell::name(case.condition(TEST)),
                    time_cell(case, frame_time(clock)),
                    Cell::or_absent(gain.as_ref().map(times), why(case)),
                    Cell::or_absent(case.value(CULL_KEPT).map(significant), why(case)),
                    count(case, PIPELINE_VERTEX_INVOCATIONS),
                    count(case, PIPELINE_GEOMETRY_INVOCATIONS),
                    count(case, PIPELINE_PRIMITIVES),
                    byte_cell(case, PIPELINE_SENT_BYTES),
                    Cell::or_absent(
                        case.value(PIPELINE_DIFFERING_PX).map(significant),
                        why(case),
                    ),
                ],
                status: case.outcome.name().to_owned(),
                remark: case.reason.clone(),
            });
        }
    }
    Table {
        caption: "Every place and test in the five views".to_owned(),
        headings: headings(&[
            ("view", None),
            ("interface", None),
            ("level 2 in", None),
            ("test", None),
            ("time, ms", Some(frame_time(clock))),
            ("time without the test ÷ time", None),
            ("patches drawn", Some(CULL_KEPT)),
            ("vertices shaded", Some(PIPELINE_VERTEX_INVOCATIONS)),
            ("geometry invocations", Some(PIPELINE_GEOMETRY_INVOCATIONS)),
            ("primitives", Some(PIPELINE_PRIMITIVES)),
            ("sent a frame", Some(PIPELINE_SENT_BYTES)),
            ("pixels that differ", Some(PIPELINE_DIFFERING_PX)),
        ]),
        rows,
        ..Table::default()
    }
}

fn drawing(flown: &[&Case], clock: Clock) -> Result<Option<String>, ChapterError> {
    let mut groups = Vec::new();
    let mut names = Vec::new();
    for (api, place) in FLOWN {
        let name = format!("{place} on {api}");
        let pairs = flight_pairs(flown, api, place, clock);
        let rows = pairs.into_iter().map(|(second, _, gain)| {
            let conditions = [(API, api), (PLACE, place), (TEST, "box")];
            let at = second.to_string();
            let own = of(flown, &conditions);
            let case = of(&own, &[(FLIGHT_S, at.as_str())]).first().copied();
            let share =
                case.and_then(|case| Some(case.value(CULL_KEPT)? / case.value(CULL_IN_TILES)?));
            let [p5, p95] = gain.interval.unwrap_or([gain.middle; 2]);
            let median = gain.middle;
            RatioRow {
                label: format!("{second} s"),
                series: name.clone(),
                ratio: Ok(Spread { p5, median, p95 }),
                processes: Vec::new(),
                value: share.map_or_else(String::new, |share| {
                    format!("{} of the patches", significant(share))
                }),
                command: String::new(),
            }
        });
        groups.push(RatioGroup {
            name: format!("level 2 in {name}"),
            dashed: None,
            rows: rows.collect(),
        });
        names.push(name);
    }
    let plot = RatioPlot {
        title: "Time without level 2 over time with it, by second of the flight".to_owned(),
        axis: RatioAxis {
            title: "time without level 2 ÷ with it: median over processes, 95 % interval",
            one: "no gain",
        },
        tie_factor: None,
        groups,
    };
    Ok(plot.draw(&Palette::new(names))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::culling::Culling;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{CaseId, Run};
    use terrafill_scene::ImageSize;
    use terrafill_study::Group;

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
            let size = ImageSize {
                width: 256,
                height: 256,
            };
            let groups = Culling::all(is_quick, (size, 1));
            let ids: Vec<&CaseId> = groups[0].cases().iter().map(|case| &case.id).collect();
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
        let folder = tempfile::tempdir().expect("a folder");
        made.write(folder.path()).expect("a run")
    }

    #[test]
    fn what_the_test_gains_is_said_of_one_stage_alone() {
        let said = |figures: &[(&str, &str, f64)]| {
            let run = run_of(figures);
            let cases: Vec<&Case> = run.cases.iter().collect();
            recommended(&cases, Clock::ProcessCpu).join(" ")
        };
        let alone = ("tiles-alone", "none", 2.0);
        let tested = ("task-shader", "box", 1.0);
        let all = said(&[alone, tested, ("task-shader", "none", 1.2)]);
        assert!(all.contains("fastest in task-shader: 5.00 ms"), "{all}");
        assert!(all.contains("against 6.00 ms"), "{all}");
        // Negative controls: a test that gains nothing in its stage, and a stage without its control.
        let slower = said(&[alone, tested, ("task-shader", "none", 0.9)]);
        assert!(slower.contains("gains nothing"), "{slower}");
        let lacking = said(&[alone, tested]);
        assert!(lacking.contains("were not measured"), "{lacking}");
        assert!(!lacking.contains("10.0 ms"), "{lacking}");
    }
}
