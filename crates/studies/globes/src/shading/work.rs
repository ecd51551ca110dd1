// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which globes are shaded: views, ways to store layers, hours, features, faults, projections, windows.

use super::way::{PART, Shading};
use crate::STUDY;
use crate::list::ShadedRow;
use crate::metrics::{
    self, BUMP_SCALE, BUMPS, CELLS, FAULT, HOURS, PICTURES, PROJECTION, SIZE_PX, VERTICES, VIEW,
    WHAT,
};
use crate::projection::Projection;
use terrafill_results::CaseId;

/// Vertices of a turn of the ablation, and of the published numbers of triangles: 2,146, 4,294 and 17,058 in view
/// `day`, within what whole turns allow.
pub(super) const ABLATION_N: u32 = 72;
const TABLE_1_N: [u32; 3] = [47, 66, 132];
const WINDOWS_PX: [u32; 3] = [600, 800, 1000];
pub(super) const REMOVED: u32 = 7;
const VIEWS: [&str; 4] = ["day", "night-edge", "limb", "pole"];
/// Hours after which the moving clouds are drawn, beside those of the view itself.
const HOURS_LATER: [u32; 2] = [0, 48];

/// Bumps of the paper's Figure 13, where clouds are away.
const BUMP_SCALES: [u32; 3] = [0, 1, 4];

/// Views, projections and bumps of the paper's Figure 14, where clouds are away.
const FIGURE_14: [(&str, Projection, u32); 3] = [
    ("north-america", Projection::HyperbolicPolar, 4),
    ("middle-east", Projection::Flat, 1),
    ("europe", Projection::Dome, 0),
];

/// The shader's faults as printed.
const FAULTS: [(u32, &str); 3] = [
    (1, "unclamped-power"),
    (2, "polar-tangent"),
    (3, "negated-night"),
];

/// What one case draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Work {
    pub(super) view: &'static str,
    pub(super) size_px: u32,
    pub(super) n: u32,
    pub(super) shading: Shading,
    pub(super) projection: Projection,
    /// Vertices are of the static buffer, and the vertex stage projects them.
    pub(super) is_stored: bool,
    /// For which clouds have moved; that of the view if none.
    pub(super) hours: Option<u32>,
    /// What it is for.
    pub(super) what: &'static str,
}

/// Ways to store bumps and pictures, one change from the first.
fn storages() -> [Shading; 3] {
    let cube = Shading::default();
    let object = Shading {
        is_object_space: true,
        ..cube
    };
    let angles = Shading {
        by_angles: true,
        ..cube
    };
    [cube, object, angles]
}

/// All of them, the first ones first.
pub(super) fn work(side_px: u32, is_quick: bool) -> Vec<Work> {
    let base = Work {
        view: VIEWS[0],
        size_px: side_px,
        n: ABLATION_N,
        shading: Shading::default(),
        projection: Projection::Globe,
        is_stored: false,
        hours: None,
        what: "ladder",
    };
    let without = |removed| Shading {
        removed,
        ..base.shading
    };
    let mut all = Vec::new();
    for view in VIEWS {
        all.extend(storages().map(|shading| Work {
            view,
            shading,
            what: "layers",
            ..base
        }));
    }
    all.extend(HOURS_LATER.map(|hours| Work {
        hours: Some(hours),
        what: "clouds",
        ..base
    }));
    all.extend((0..=REMOVED).map(|removed| Work {
        shading: without(removed),
        ..base
    }));
    all.extend(BUMP_SCALES.map(|bump_scale| Work {
        view: "limb",
        shading: Shading {
            bump_scale,
            ..without(1)
        },
        what: "bumps",
        ..base
    }));
    for view in ["day", "pole"] {
        all.extend(FAULTS.map(|(fault, _)| Work {
            view,
            shading: Shading {
                fault,
                ..base.shading
            },
            what: "faults",
            ..base
        }));
    }
    all.extend(Projection::ALL.iter().map(|&projection| Work {
        projection,
        is_stored: true,
        what: "projections",
        ..base
    }));
    if !is_quick {
        all.extend(FIGURE_14.map(|(view, projection, bump_scale)| Work {
            view,
            projection,
            shading: Shading {
                bump_scale,
                ..without(1)
            },
            is_stored: true,
            what: "areas",
            ..base
        }));
        all.extend([false, true].map(|by_angles| Work {
            view: "pole-near",
            shading: Shading {
                by_angles,
                ..without(1)
            },
            what: "near-pole",
            ..base
        }));
    }
    let windows = if is_quick { 1 } else { WINDOWS_PX.len() };
    for &size_px in &WINDOWS_PX[..windows] {
        for n in TABLE_1_N {
            all.extend([0, REMOVED].map(|removed| Work {
                size_px,
                n,
                shading: without(removed),
                what: "tessellation",
                ..base
            }));
        }
    }
    all
}

fn fault_name(fault: u32) -> &'static str {
    let mut faults = FAULTS.iter();
    faults
        .find(|(number, _)| *number == fault)
        .map_or("none", |(_, name)| name)
}

impl Work {
    pub(super) fn id(&self, view: Option<&ShadedRow>) -> CaseId {
        let Self { shading, .. } = self;
        let pictures = if shading.by_angles { "angles" } else { "cube" };
        let bumps = if shading.is_object_space {
            "object"
        } else {
            "tangent"
        };
        let hours = self.hours.or(view.map(|view| view.hours)).unwrap_or(0);
        let fault = fault_name(shading.fault);
        let conditions = [
            (metrics::PART, PART.to_owned()),
            (WHAT, self.what.to_owned()),
            (VIEW, self.view.to_owned()),
            (CELLS, self.n.to_string()),
            (metrics::REMOVED, shading.removed.to_string()),
            (PICTURES, pictures.to_owned()),
            (BUMPS, bumps.to_owned()),
            (BUMP_SCALE, shading.bump_scale.to_string()),
            (FAULT, fault.to_owned()),
            (PROJECTION, self.projection.name().to_owned()),
            (
                VERTICES,
                if self.is_stored { "static" } else { "sent" }.to_owned(),
            ),
            (HOURS, hours.to_string()),
            (SIZE_PX, self.size_px.to_string()),
        ];
        let scale = match shading.bump_scale {
            1 => String::new(),
            scale => format!("/bump_scale={scale}"),
        };
        let name = format!(
            "{PART}/{}/{}/n={}/removed={}/{pictures}/{bumps}{scale}/{fault}/{}/hours={hours}/{}",
            self.what,
            self.view,
            self.n,
            shading.removed,
            self.projection.name(),
            self.size_px
        );
        CaseId::new(STUDY, name, conditions)
    }
}
