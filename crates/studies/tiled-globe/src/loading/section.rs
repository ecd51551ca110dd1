// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on tiles that are read while frames are drawn.

use super::PART;
use crate::metrics::{self, *};
use crate::tiles::section::COUNT;
use terrafill_globe_views::compared_in;
use terrafill_lab::{Cases, Column, Comparison, Names, Section, Select, finding, sentences};
use terrafill_plot::number::{digits, measured_bytes, significant};
use terrafill_plot::{Course, Courses};
use terrafill_results::{Block, Case, ChapterError, Claim, Finding, Metric, Scope};

pub(crate) const SECTION: Section<'static> = Section {
    title: "Tiles read beside frames",
    text: "Tiles are files, PNGs of 256 × 256 texels, written before the flight. So reading means the system's page \
           cache and decoding, not a cold disk and no network; “latency” adds a wait to each tile, as a network might. \
           A flight has 16 eyes, at most 60 a second, and begins with the coarsest level alone. Frames choose tiles by \
           the corners of 20 × 20 cells. In the background a thread reads what frames lack, the newest wishes first; no \
           frame waits, and one sends at most so many tiles. In the foreground each frame reads what it lacks. Or all \
           tiles are there before the first frame, in as many slots; else there are 40, and the tile that was used \
           longest ago makes room. A tile that is not there is drawn by the nearest that it is a part of. Each pixel of \
           the judged frames is held against rays in f64 and the tiles that were there: it must show the texel of the \
           finest one. “Coarse” is the share of pixels that show a coarser level than they want, summed over frames. \
           Where a level is not there, each fragment searches for the next one. A frame's clock covers making the grid, \
           choosing, sending and drawing; its CPU time has what a thread uses meanwhile, whose whole time stands beside \
           it. Pictures have a colour for each level, pale where it is coarser than wanted.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[
        ("tiles hold", PICTURES),
        ("path", PATH),
        ("loading", LOADING),
        ("tiles a frame", TRANSFERS),
        ("latency, ms", LATENCY_MS),
    ]),
    columns: &[
        Column::metric("wrong px", GLOBE_LOAD_WRONG_PX),
        Column::metric("of px", GLOBE_LOAD_JUDGED_PX),
        Column::metric("coarse px, eye moves", GLOBE_LOAD_MOVING_COARSE_PX),
        timed("coarse, frames", GLOBE_LOAD_COARSE),
        Column::metric("px, last frame", GLOBE_LOAD_COARSE_LAST_PX),
        timed("frames to rest", GLOBE_LOAD_REST_FRAMES),
        Column::metric("given up", GLOBE_LOAD_CANCELLED).or_of(why_no_thread),
        timed("tiles sent, most in a frame", GLOBE_LOAD_SENT_MAX),
        timed("bytes sent", GLOBE_LOAD_BYTES).written(measured_bytes),
        timed("most in a frame", GLOBE_LOAD_BYTES_MAX).written(measured_bytes),
        Column::metric("at rest", GLOBE_LOAD_STEADY_BYTES),
        timed("frame, wall ms", GLOBE_LOAD_FRAME_WALL_MS),
        timed("longest", GLOBE_LOAD_FRAME_MAX_WALL_MS),
        timed("longest / median", GLOBE_LOAD_SPIKE),
        timed("frame, CPU ms", GLOBE_LOAD_FRAME_CPU_MS),
        Column::metric("thread, CPU ms", GLOBE_LOAD_THREAD_CPU_MS).or_of(why_no_thread),
        COUNT,
        Column::metric("files", GLOBE_LOAD_FILE_BYTES),
    ],
    findings: &[exact, at_rest, spikes],
    pictures: &[("before", "frame 3"), ("picture", "at rest")],
    more: &[late, coarse, bytes],
    ..Section::EMPTY
};

const fn timed(heading: &'static str, metric: &'static Metric) -> Column {
    Column::metric(heading, metric).or(NOT_TIMED)
}

const NOT_TIMED: &str = "flights over a picture are judged, not timed";

fn why_no_thread(case: &Case) -> &'static str {
    match case.condition(LOADING) {
        "background" => NOT_TIMED,
        _ => "no thread reads beside its frames",
    }
}

fn exact(cases: &Cases<'_>) -> Finding {
    let [wrong, of] = [GLOBE_LOAD_WRONG_PX, GLOBE_LOAD_JUDGED_PX].map(|metric| cases.sum(metric));
    // Where nothing is lacking while the eye moves, nothing comes and goes.
    let background = cases.with(&[(LOADING, "background")]);
    let coarse = background.sum(GLOBE_LOAD_MOVING_COARSE_PX).unwrap_or(0.0);
    let said = wrong.zip(of).map_or_else(String::new, |(wrong, of)| {
        format!(
            "{} of {} pixels wrong; with a thread beside frames {} pixels showed a coarser level than they want while the eye moved.",
            digits(wrong),
            digits(of),
            digits(coarse)
        )
    });
    finding(
        "While tiles come and go, each pixel shows the texel of the finest tile that is there",
        wrong.and_then(|wrong| (wrong > 0.0 || coarse > 0.0).then_some(wrong == 0.0)),
        said,
    )
}

fn at_rest(cases: &Cases<'_>) -> Finding {
    let most = cases.greatest(GLOBE_LOAD_STEADY_BYTES);
    finding(
        "A frame whose eye rests, and that has its tiles, sends nothing to the device",
        most.map(|most| most == 0.0),
        most.map_or_else(String::new, |most| {
            format!(
                "At most {} at the queue in a flight's resting frames.",
                measured_bytes(most)
            )
        }),
    )
}

/// Figures of cases that differ in when tiles are read alone, with what names a pair.
fn pairs(cases: &Cases<'_>, metric: &'static Metric) -> Vec<(String, [f64; 2])> {
    let pairs = cases.pairs(LOADING, ["background", "foreground"], &[]);
    let pairs = pairs.iter().filter_map(|pair| {
        let [background, foreground] = pair.map(|case| case.value(metric));
        let [path, latency] = [PATH, LATENCY_MS].map(|key| pair[0].condition(key));
        let name = format!("{path}, latency {latency} ms");
        Some((name, [background?, foreground?]))
    });
    pairs.collect()
}

fn words<'p>(pairs: impl IntoIterator<Item = &'p (String, [f64; 2])>) -> String {
    let words = pairs.into_iter().map(|(name, figures)| {
        let [background, foreground] = figures.map(significant);
        format!("{name}: {background} in the background, {foreground} in the foreground")
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() {
        return "not measured.".to_owned();
    }
    format!("{}.", words.join("; "))
}

/// Of a flight's longest frame, by the noise of these cases, and of processes enough.
const LONGEST: Comparison<'static> = compared_in(
    LOADING,
    GLOBE_LOAD_FRAME_MAX_WALL_MS,
    Scope::PLAN.and(Scope::FRAME),
);

fn spikes(cases: &Cases<'_>) -> Finding {
    let waits = cases.fitting(|case| case.condition(LATENCY_MS) != "0");
    let found = cases.compared(
        &LONGEST,
        &waits.pairs(LOADING, ["foreground", "background"], &[]),
        Claim::Faster,
        "Where each tile is waited for, a flight's longest frame is shorter with a thread beside it",
    );
    let at_once = cases.with(&[(LATENCY_MS, "0")]);
    let [waits, at_once] =
        [&waits, &at_once].map(|own| words(&pairs(own, GLOBE_LOAD_FRAME_MAX_WALL_MS)));
    let said = format!(
        "Wall ms of the longest frame, {waits} That follows from the latency that is asked for: a frame waits so long for \
         each tile that it lacks. Without a wait, {at_once}"
    );
    Finding {
        because: sentences([found.because, said]),
        ..found
    }
}

/// What not waiting costs in what is seen. It is no finding: the first frame asks and takes nothing, and frames that wait
/// lack nothing.
fn late(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let pairs = pairs(cases, GLOBE_LOAD_COARSE);
    let said = format!(
        "Frames' worth of pixels at a coarser level than they want, {} The first frame of a flight in the background has the \
         coarsest level alone.",
        words(&pairs)
    );
    Ok((!pairs.is_empty()).then_some(Block::Text(said)))
}

fn course(cases: &Cases<'_>, caption: &str, note: &str) -> Result<Option<Block>, ChapterError> {
    let own = cases.with(&[(PICTURES, "addresses")]);
    let panel = |case: &Case| {
        let [path, loading, tiles, latency] =
            [PATH, LOADING, TRANSFERS, LATENCY_MS].map(|key| case.condition(key));
        let values = case.note(note).split(' ');
        Course {
            name: format!("{path}, {loading}, {tiles} a frame, {latency} ms"),
            values: values.filter_map(|value| value.parse().ok()).collect(),
            wanted: None,
        }
    };
    let courses = Courses {
        title: caption.to_owned(),
        across: "frames",
        panels: own.iter().map(panel).collect(),
    };
    Ok(Block::plot(caption, courses.draw()?))
}

fn coarse(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let caption = "Share of pixels that show a coarser level than they want, frame by frame of a flight whose pictures are not judged on the way.";
    course(cases, caption, "coarse")
}

fn bytes(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let caption =
        "Bytes that are sent, frame by frame of a flight whose pictures are not judged on the way.";
    course(cases, caption, "bytes")
}
