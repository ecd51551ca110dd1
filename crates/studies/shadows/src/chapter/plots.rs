// SPDX-License-Identifier: MIT OR Apache-2.0
//! Figures that plots of sections take from cases, and plots in which cases of other questions stand beside.

use crate::metrics::*;
use terrafill_lab::{Cases, Drawing, Figure, Names, Panel, measured};
use terrafill_plot::Upwards;
use terrafill_results::{Block, Case, ChapterError};

pub(super) fn elevation_deg(case: &Case) -> Option<f64> {
    case.condition(SUN).split('°').next()?.parse().ok()
}

/// Of the rule as printed there is no curve: it is wrong.
pub(super) fn writes(case: &Case) -> Option<f64> {
    let is_printed = case.condition(RULE).contains("printed");
    measured(case, UPDATES).filter(|_| !is_printed)
}

/// Of a mesh in which no face is turned.
pub(super) fn whole_triangles(case: &Case) -> Option<f64> {
    let is_turned = case.condition(MESH).contains("turned");
    measured(case, SHADOW_MESH_TRIANGLES).filter(|_| !is_turned)
}

pub(super) fn mesh_kind(case: &Case) -> String {
    let kind = match case.condition(MESH).split('-').next() {
        None | Some("") => "the model",
        Some(kind) => kind,
    };
    format!("{}, {kind}", case.condition(SILHOUETTE))
}

/// Of all cases of the run that stand in it: those of the section, and those beside them under the same suns.
fn beside(
    own: &Cases<'_>,
    title: &str,
    is_beside: fn(&Case) -> bool,
    drawing: Drawing<'_>,
) -> Result<Option<Block>, ChapterError> {
    let suns = own.distinct(SUN);
    let question = own.first().map_or("", |case| case.condition(QUESTION));
    let all = Cases::of_study(own.run(), crate::STUDY).fitting(|case| {
        let is_own = case.condition(QUESTION) == question;
        is_own || is_beside(case) && suns.contains(&case.condition(SUN))
    });
    drawing.block(title, &all)
}

/// Beside finite volumes: those that end elsewhere.
pub(super) fn finite_plot(own: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let ends = |case: &Case| match case.condition(EXTENT) {
        "" => "finite".to_owned(),
        extent => extent.to_owned(),
    };
    let drawing = Drawing {
        caption: "Error against cost: volumes of finite length, m beside the points, and those that end at infinity or at \
                  the sea.",
        panels: &[Panel {
            across: ("stencil writes per pixel", Figure::Metric(UPDATES)),
            up: ("shadow pixels lost, %", Figure::Metric(LOST)),
            upwards: Upwards::Error,
            curve: Names::Of("", ends),
            knob: Figure::Condition(LENGTH_M),
            label: Some(Names::Joined(&[LENGTH_M])),
            ..Panel::EMPTY
        }],
    };
    let is_beside =
        |case: &Case| case.condition(QUESTION) == "updates" && case.condition(RULE) == "z-fail";
    beside(own, "Finite volumes", is_beside, drawing)
}

/// Beside maps of a device: its volumes closed at the sea.
pub(super) fn device_map_plot(own: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let name = |case: &Case| match case.condition(BIAS) {
        "" => format!("volumes, sun {}", case.condition(SUN)),
        bias => format!("map, sun {}, {bias}", case.condition(SUN)),
    };
    let drawing = Drawing {
        caption: "Wrong pixels, the band included, against time; texel in m beside the points. Volumes closed at the sea \
                  under the same suns stand beside.",
        panels: &[Panel {
            across: ("ms of a frame", Figure::ByClock(FILL_GPU, FILL_CPU)),
            up: ("wrong pixels, %", Figure::Computed(wrong_share)),
            upwards: Upwards::Error,
            curve: Names::Of("", name),
            knob: Figure::Condition(TEXEL_M),
            label: Some(Names::Joined(&[TEXEL_M])),
            ..Panel::EMPTY
        }],
    };
    beside(own, "Shadow maps of a device", is_beside_maps, drawing)
}

/// Wrong pixels, the band included, in per cent of what is seen.
fn wrong_share(case: &Case) -> Option<f64> {
    let of_volumes = || {
        let px = [SHADOW_FALSE_LIT_PX, SHADOW_FALSE_DARK_PX, SHADOW_BAND_PX];
        let px: Option<f64> = px.iter().map(|metric| measured(case, metric)).sum();
        Some(100.0 * px? / measured(case, SHADOW_RECEIVER_PX)?)
    };
    measured(case, MAP_WRONG).or_else(of_volumes)
}

/// Volumes closed at the sea as the rows of a device begin with them.
pub(super) fn is_plain(case: &Case) -> bool {
    let plain = [
        (EXTENT, "sea-closed"),
        (RULE, "z-fail"),
        (FACES, "two-sided"),
        (SCISSOR, "off"),
        (DEPTH_BOUNDS, "off"),
        (SILHOUETTE, "adjacency"),
    ];
    let mut plain = plain.iter();
    plain.all(|(key, value)| case.condition(*key) == *value)
}

/// The same on wgpu, beside which shadow maps of a device stand.
fn is_beside_maps(case: &Case) -> bool {
    let is_own = case.condition(QUESTION) == "devices" && case.condition(VIEW).is_empty();
    is_own && case.condition(API) == "wgpu" && is_plain(case)
}
