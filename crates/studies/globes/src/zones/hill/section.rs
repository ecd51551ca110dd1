// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on pictures of zones by counted pixels.

use super::{PART, Shown};
use crate::counts::why_not_settled;
use crate::metrics::{self, *};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_results::{Case, Finding};

pub(crate) const SECTION: Section<'static> = Section {
    title: "A hill that hides, and one seen edge-on",
    text: "Zones of the same height field, at rest, counted by occlusion queries in a picture of 400 × 400 pixels. A large \
           hill stands before the eye: zones behind it have no pixel and stay coarse, as their edges from above show; two \
           lines mark the eye. Another hill is so narrow that the coarsest level drops it. While its zone is seen edge-on it \
           has too few pixels to become finer. The eye climbs by 10 m at a time until the hill appears; the zone's edge is \
           bold. From the place before, a zone that was fine at first keeps its hill. Pixels show the triangle that rays \
           meet in f64, but where rounding of corners decides.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[("picture", VIEW), ("hill, m", HILL_M)]),
    columns: &[
        Column::metric("triangles", GLOBE_TRIANGLES),
        Column::metric("settled after, frames", GLOBE_COUNT_SETTLE_FRAMES).or_of(why_not_settled),
        Column::metric("hidden zones", GLOBE_ZONE_HIDDEN),
        Column::metric("finest level of them", GLOBE_ZONE_HIDDEN_LEVEL),
        Column::metric("px of the zone edge-on", GLOBE_ZONE_PX),
        Column::metric("its level", GLOBE_ZONE_LEVEL),
        Column::metric(
            "zones off by more than their edges",
            GLOBE_COUNT_WRONG_NODES,
        ),
        Column::metric("px of another triangle", GLOBE_ZONE_OTHER_PX),
        Column::metric("found when moved", GLOBE_ZONE_CONTROL_PX),
        Column::metric("px off every line", GLOBE_WIRE_BEYOND_PX),
        Column::metric("lines without a pixel", GLOBE_WIRE_MISSING),
        Column::metric("frame with counts, CPU ms", GLOBE_COUNTED_CPU_MS),
    ],
    pictures: &[("picture", "")],
    findings: &[hides, appears],
    ..Section::EMPTY
};

/// A figure of what is shown.
fn value(cases: &Cases<'_>, shown: Shown, of: impl Fn(&Case) -> Option<f64>) -> Option<f64> {
    let mut cases = cases.iter();
    let case = cases.find(|case| case.condition(VIEW) == shown.name())?;
    of(case)
}

fn hides(cases: &Cases<'_>) -> Finding {
    let of = |shown| {
        let hidden = value(cases, shown, |case| case.value(GLOBE_ZONE_HIDDEN))?;
        let level = value(cases, shown, |case| case.value(GLOBE_ZONE_HIDDEN_LEVEL))?;
        let triangles = value(cases, shown, |case| case.value(GLOBE_TRIANGLES))?;
        Some([hidden, level, triangles])
    };
    let both = of(Shown::Above).zip(of(Shown::AbovePlain));
    finding(
        "Gebbie & Bailey: behind a large hill there is a large area of low detail",
        both.map(|([hidden, level, triangles], [_, _, plain])| {
            hidden > 0.0 && level == 0.0 && triangles < plain
        }),
        both.map_or_else(
            String::new,
            |([hidden, level, triangles], [_, _, plain])| {
                format!(
                    "{hidden} of 25 zones are hidden, the finest at level {level}; {triangles} triangles, without the hill {plain}."
                )
            },
        ),
    )
}

fn appears(cases: &Cases<'_>) -> Finding {
    let of = |shown| {
        let pixels = value(cases, shown, |case| case.value(GLOBE_ZONE_PX))?;
        let level = value(cases, shown, |case| case.value(GLOBE_ZONE_LEVEL))?;
        Some([pixels, level])
    };
    let before = of(Shown::Before);
    let all = before.zip(of(Shown::After)).zip(of(Shown::BeforeFromFine));
    finding(
        "Gebbie & Bailey: a zone seen edge-on has very few pixels, until its hill appears at once",
        all.map(|(([few, coarse], [many, fine]), [from_fine, kept])| {
            few < many && few < from_fine && coarse == 0.0 && fine > 0.0 && kept > 0.0
        }),
        all.map_or_else(
            String::new,
            |(([few, coarse], [many, fine]), [from_fine, kept])| {
                format!(
                    "{few} pixels at level {coarse}, after 10 m more {many} at level {fine}; from the place before {from_fine} at level {kept} where it was fine at first."
                )
            },
        ),
    )
}
