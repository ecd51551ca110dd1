// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on tiles that are read while frames are drawn.

use super::PART;
use crate::metrics::{self, *};
use crate::tiled::section::COUNT;
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_plot::number::{digits, measured_bytes, significant};
use terrafill_plot::{Course, Courses};
use terrafill_results::{Block, Case, ChapterError, Finding, Metric};

pub(crate) const SECTION: Section<'static> = Section {
    title: "Tiles read beside frames",
    text: "Tiles are files, PNGs of 256 × 256 texels, written before the flight. So reading means the system’s page \
           cache and decoding, not a cold disk and no network; “latency” adds a wait to each tile, as a network might. \
           A flight has 16 eyes, at most 60 a second, and begins with the coarsest level alone. Frames choose tiles by \
           the corners of 20 × 20 cells. In the background a thread reads what frames lack, the newest wishes first; \
           no frame waits, and one sends at most so many tiles. In the foreground each frame reads what it lacks. \
           Or all tiles are there before the first frame, in as many slots; else there are 40, and the tile that was \
           used longest ago makes room. A tile that is not there is drawn by the nearest that it is a part of. \
           Each pixel of the judged frames is held against rays in double precision and the tiles that were there: it must show the \
           texel of the finest one, and nothing else. “Coarse” is the share of pixels that show a coarser level than they \
           want, summed over frames. Where a level is not there, each fragment searches for the next one. A frame’s clock covers making the grid, choosing, sending and drawing; the CPU time of the \
           thread is apart. Pictures have a colour for each level, pale where it is coarser than wanted.",
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
        timed("coarse, frames", GLOBE_LOAD_COARSE),
        Column::metric("px, last frame", GLOBE_LOAD_COARSE_LAST_PX),
        timed("frames to rest", GLOBE_LOAD_REST_FRAMES),
        timed("given up", GLOBE_LOAD_CANCELLED),
        timed("tiles sent, most in a frame", GLOBE_LOAD_SENT_MAX),
        timed("bytes sent", GLOBE_LOAD_BYTES).written(measured_bytes),
        timed("most in a frame", GLOBE_LOAD_BYTES_MAX).written(measured_bytes),
        Column::metric("at rest", GLOBE_LOAD_STEADY_BYTES),
        timed("frame, wall ms", GLOBE_LOAD_FRAME_WALL_MS),
        timed("longest", GLOBE_LOAD_FRAME_MAX_WALL_MS),
        timed("longest / median", GLOBE_LOAD_SPIKE),
        timed("frame, CPU ms", GLOBE_LOAD_FRAME_CPU_MS),
        timed("thread, CPU ms", GLOBE_LOAD_THREAD_CPU_MS),
        COUNT,
        Column::metric("files", GLOBE_LOAD_FILE_BYTES),
    ],
    findings: &[exact, at_rest, spikes, late],
    pictures: &[("before", "frame 3"), ("picture", "at rest")],
    more: &[coarse, bytes],
    ..Section::EMPTY
};

const fn timed(heading: &'static str, metric: &'static Metric) -> Column {
    Column::metric(heading, metric).or("flights over a picture are judged, not timed")
}

fn exact(cases: &Cases<'_>) -> Finding {
    let [wrong, of] = [GLOBE_LOAD_WRONG_PX, GLOBE_LOAD_JUDGED_PX].map(|metric| cases.sum(metric));
    let said = wrong.zip(of).map_or_else(String::new, |(wrong, of)| {
        format!("{} of {} pixels wrong.", digits(wrong), digits(of))
    });
    finding(
        "While tiles come and go, each pixel shows the texel of the finest tile that is there",
        wrong.map(|wrong| wrong == 0.0),
        said,
    )
}

fn at_rest(cases: &Cases<'_>) -> Finding {
    let most = cases.greatest(GLOBE_LOAD_STEADY_BYTES);
    finding(
        "A frame whose eye rests, and that has its tiles, sends nothing to the device",
        most.map(|most| most == 0.0),
        most.map_or_else(String::new, |most| {
            format!("At most {} in three frames.", measured_bytes(most))
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
    format!("{}.", words.collect::<Vec<_>>().join("; "))
}

fn spikes(cases: &Cases<'_>) -> Finding {
    let pairs = pairs(cases, GLOBE_LOAD_SPIKE);
    let (at_once, waits): (Vec<_>, Vec<_>) =
        pairs.iter().partition(|(name, _)| name.ends_with(" 0 ms"));
    let holds = waits
        .iter()
        .all(|(_, [background, foreground])| background < foreground);
    finding(
        "Where each tile is waited for, a flight’s longest frame is fewer medians long with a thread beside it",
        (!waits.is_empty()).then_some(holds),
        format!("{} Without a wait, {}", words(waits), words(at_once)),
    )
}

/// What not waiting costs in what is seen.
fn late(cases: &Cases<'_>) -> Finding {
    let pairs = pairs(cases, GLOBE_LOAD_COARSE);
    let holds = pairs
        .iter()
        .all(|(_, [background, foreground])| background > foreground);
    finding(
        "Frames that do not wait show more pixels at a coarser level than they want",
        (!pairs.is_empty()).then_some(holds),
        words(&pairs),
    )
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
    let caption = "Share of pixels that show a coarser level than they want, frame by frame of the judged flight.";
    course(cases, caption, "coarse")
}

fn bytes(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let caption = "Bytes that are sent, frame by frame of the judged flight.";
    course(cases, caption, "bytes")
}
