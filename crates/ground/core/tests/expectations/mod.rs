// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reads `expectations.json`, which `make_expectations.py` writes; used by the tests of more than
//! one crate.

#![allow(dead_code, reason = "each of the tests uses a part")]

use serde::Deserialize;
use std::f64::consts::TAU;
use terrafill_core::{EdgeRule, Ellipsoid, Region, RegionFileError, parse_regions};

/// Fewer than these would mean that something was lost.
const FEWEST_CASES: usize = 150;

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
}

/// One edge case.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Case {
    pub(crate) name: String,
    says: String,
    pub(crate) body: String,
    pub(crate) rule: EdgeRule,
    /// The file's content, or [`Case::shape`].
    #[serde(default)]
    text: Option<String>,
    #[serde(default)]
    shape: Option<Shape>,
    /// Expected when the case is to be refused; then nothing below counts.
    #[serde(default)]
    pub(crate) refusal: Option<Refusal>,
    /// Whether crossings are made vertices before meshing.
    #[serde(default)]
    pub(crate) repair: bool,
    #[serde(default)]
    pub(crate) area_m2: f64,
    #[serde(default)]
    pub(crate) relative_tolerance: f64,
    /// `agrees`, or a part of the locator's refusal.
    #[serde(default)]
    pub(crate) locator: String,
    /// Each is the beginning of a part of some warning.
    #[serde(default)]
    pub(crate) warnings: Vec<String>,
    #[serde(default)]
    pub(crate) boundary_loops: Option<usize>,
    #[serde(default)]
    pub(crate) inside: Vec<[f64; 2]>,
    #[serde(default)]
    pub(crate) outside: Vec<[f64; 2]>,
    /// Closer to the boundary than it is drawn.
    #[serde(default)]
    pub(crate) exact_inside: Vec<[f64; 2]>,
    #[serde(default)]
    pub(crate) exact_outside: Vec<[f64; 2]>,
}

/// What a refusal must say and where it must point.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Refusal {
    pub(crate) stage: Stage,
    /// In this order in the message.
    pub(crate) parts: Vec<String>,
    #[serde(default)]
    pub(crate) place: Place,
    /// Longitude and latitude of the crossing.
    #[serde(default)]
    pub(crate) at: Option<[f64; 2]>,
    /// Parts of every problem, where there are several.
    #[serde(default)]
    pub(crate) others: Vec<Vec<String>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Stage {
    /// By `parse_regions`.
    Read,
    /// By `RegionMesh::build`.
    Mesh,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Place {
    pub(crate) feature: Option<usize>,
    pub(crate) polygon: Option<usize>,
    pub(crate) ring: Option<usize>,
    pub(crate) vertex: Option<usize>,
}

/// A ring too long to be written down; the same formulas as in `case_list.py`.
#[derive(Debug, Clone, Deserialize)]
#[serde(
    tag = "kind",
    rename_all = "kebab-case",
    rename_all_fields = "kebab-case"
)]
enum Shape {
    Circle {
        longitude: f64,
        latitude: f64,
        radius: f64,
        vertices: u32,
        inner: Option<f64>,
    },
    Parallel {
        latitude: f64,
        vertices: u32,
    },
    Minkowski {
        west: f64,
        south: f64,
        level: u32,
        step: f64,
    },
    Comb {
        west: f64,
        south: f64,
        teeth: u32,
        pitch: f64,
        height: f64,
    },
    Spiral {
        longitude: f64,
        latitude: f64,
        legs: u32,
        step: f64,
    },
}

impl Shape {
    fn ring(&self) -> Vec<[f64; 2]> {
        match *self {
            Self::Circle {
                longitude,
                latitude,
                radius,
                vertices,
                inner,
            } => (0..vertices)
                .map(|k| {
                    let (sin, cos) = (TAU * f64::from(k) / f64::from(vertices)).sin_cos();
                    let share = if k % 2 == 1 { inner } else { None };
                    let r = radius * share.unwrap_or(1.0);
                    [longitude + r * cos, latitude + r * sin]
                })
                .collect(),
            Self::Parallel { latitude, vertices } => (0..vertices)
                .map(|k| [360.0 * f64::from(k) / f64::from(vertices) - 180.0, latitude])
                .collect(),
            Self::Minkowski {
                west,
                south,
                level,
                step,
            } => minkowski(west, south, level, step),
            Self::Comb {
                west,
                south,
                teeth,
                pitch,
                height,
            } => {
                let mut ring = vec![[west, south], [west + f64::from(teeth) * pitch, south]];
                let (valley, tip) = (south + 1.0, south + 1.0 + height);
                for tooth in (0..teeth).rev() {
                    let x = west + f64::from(tooth) * pitch;
                    let middle = x + 0.5 * pitch;
                    ring.extend([
                        [x + pitch, valley],
                        [middle, valley],
                        [middle, tip],
                        [x, tip],
                    ]);
                }
                ring
            }
            Self::Spiral {
                longitude,
                latitude,
                legs,
                step,
            } => spiral(legs)
                .into_iter()
                .map(|[x, y]| [longitude + x * step, latitude + y * step])
                .collect(),
        }
    }
}

/// Quadratic Koch island: a square, each side of each round replaced by eight.
fn minkowski(west: f64, south: f64, level: u32, step: f64) -> Vec<[f64; 2]> {
    // Turn to the left before each side.
    let mut turns = vec![1; 4];
    for _ in 0..level {
        turns = turns
            .into_iter()
            .flat_map(|turn| [turn, 1, -1, -1, 0, 1, 1, -1])
            .collect();
    }
    let (mut at, mut direction) = ([0.0, 0.0], [0.0, -1.0]);
    let mut ring = Vec::with_capacity(turns.len());
    for turn in turns {
        ring.push([west + at[0] * step, south + at[1] * step]);
        let [x, y]: [f64; 2] = direction;
        direction = match turn {
            1 => [-y, x],
            -1 => [y, -x],
            _ => [x, y],
        };
        at = [at[0] + direction[0], at[1] + direction[1]];
    }
    ring
}

/// A corridor along legs of lengths 1, 1, 2, 2, 3 …, each to the left of the one before.
fn spiral(legs: u32) -> Vec<[f64; 2]> {
    let (mut at, mut direction) = ([0.0, 0.0], [1.0, 0.0]);
    let mut right = vec![[0.0, -0.25]];
    let mut left = vec![[0.0, 0.25]];
    for leg in 0..legs {
        let length = f64::from(leg / 2 + 1);
        let [x, y]: [f64; 2] = direction;
        at = [at[0] + x * length, at[1] + y * length];
        let next = [-y, x];
        // The corner lies half way round; the last leg just ends.
        let side = if leg + 1 < legs {
            [0.25 * (next[0] - x), 0.25 * (next[1] - y)]
        } else {
            [0.25 * next[0], 0.25 * next[1]]
        };
        right.push([at[0] - side[0], at[1] - side[1]]);
        left.push([at[0] + side[0], at[1] + side[1]]);
        direction = next;
    }
    right.extend(left.into_iter().rev());
    right
}

impl Case {
    pub(crate) fn body(&self) -> Ellipsoid {
        Ellipsoid::by_name(&self.body).unwrap_or_else(|| panic!("no body {}", self.body))
    }

    /// Reads the case's file.
    pub(crate) fn read(&self) -> Result<Vec<Region>, RegionFileError> {
        let text = match (&self.text, &self.shape) {
            (Some(text), None) => text.clone(),
            (None, Some(shape)) => {
                let ring: Vec<String> = shape
                    .ring()
                    .iter()
                    .map(|[x, y]| format!("[{x},{y}]"))
                    .collect();
                let ring = ring.join(",");
                format!(r#"{{"type":"Polygon","coordinates":[[{ring}]]}}"#)
            }
            _ => panic!("{}: either a text or a shape", self.name),
        };
        parse_regions(text.as_bytes(), &self.name)
    }

    /// The one region of an accepted case.
    pub(crate) fn region(&self) -> Region {
        let mut regions = self
            .read()
            .unwrap_or_else(|error| panic!("{}: refused: {error}", self.name));
        assert_eq!(regions.len(), 1, "{}: one region each", self.name);
        regions.remove(0)
    }
}

/// Every case; a file with too few of them is no file.
pub(crate) fn all_cases() -> Vec<Case> {
    let file: File =
        serde_json::from_str(include_str!("expectations.json")).expect("expectations.json");
    assert!(
        file.cases.len() >= FEWEST_CASES,
        "only {} edge cases",
        file.cases.len()
    );
    file.cases
}

/// The cases that are to be accepted.
pub(crate) fn accepted() -> Vec<Case> {
    let mut cases = all_cases();
    cases.retain(|case| case.refusal.is_none());
    cases
}
