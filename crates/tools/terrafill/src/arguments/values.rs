// SPDX-License-Identifier: MIT OR Apache-2.0
//! Values that options of several verbs take.

use clap::{Args, ValueEnum};
use terrafill_core::{EdgeRule, Ellipsoid, Inside, Reading, Repair, Unwrap};
use terrafill_results::Shard;
use terrafill_scene::choices;

/// Edge rule by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Edges {
    // Straight in longitude and latitude (RFC 7946).
    Planar,
    // In the plane through the body's centre.
    GreatEllipse,
}

impl From<Edges> for EdgeRule {
    fn from(edges: Edges) -> Self {
        match edges {
            Edges::Planar => Self::Planar,
            Edges::GreatEllipse => Self::GreatEllipse,
        }
    }
}

/// Which way edges over more than 180° of longitude go, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LongEdges {
    Auto,
    Literal,
    Shortest,
}

/// Which side of a ring round a pole is inside, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PoleSide {
    Smaller,
    Left,
}

/// How a file is read where it can be read in several ways.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct ReadingArguments {
    #[arg(long, default_value = "auto", hide_possible_values = true, help = UNWRAP_HELP)]
    pub(crate) unwrap: LongEdges,
    #[arg(long, default_value = "smaller", hide_possible_values = true, help = INSIDE_HELP)]
    pub(crate) inside: PoleSide,
}

impl From<ReadingArguments> for Reading {
    fn from(arguments: ReadingArguments) -> Self {
        Self {
            unwrap: match arguments.unwrap {
                LongEdges::Auto => Unwrap::Auto,
                LongEdges::Literal => Unwrap::Literal,
                LongEdges::Shortest => Unwrap::Shortest,
            },
            inside: match arguments.inside {
                PoleSide::Smaller => Inside::Smaller,
                PoleSide::Left => Inside::Left,
            },
        }
    }
}

pub(super) const UNWRAP_HELP: &str = "\
Edges over more than 180° of longitude: literal (as the
numbers stand, RFC 7946), shortest (over the antimeridian)
or auto (what is oriented right)";

pub(super) const INSIDE_HELP: &str = "\
Inside of a ring round a pole: smaller (the side with less
area; of halves the left), or left of every shell, as RFC
7946 orients it";

/// `1024` or `1920x1080`.
pub(super) fn parse_size(text: &str) -> Result<(u32, u32), &'static str> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    let parse = |side: &str| match side.parse::<u32>() {
        Ok(pixels @ 1..=16_384) => Ok(pixels),
        _ => Err("1 … 16384 pixels a side, such as 1024 or 1920x1080"),
    };
    Ok((parse(width)?, parse(height)?))
}

pub(super) fn parse_samples(text: &str) -> Result<u32, &'static str> {
    match text.parse() {
        Ok(samples @ 1..=100_000) => Ok(samples),
        _ => Err("1 … 100000"),
    }
}

pub(super) fn parse_processes(text: &str) -> Result<u32, &'static str> {
    match text.parse() {
        Ok(processes @ 1..=1_000) => Ok(processes),
        _ => Err("1 … 1000"),
    }
}

pub(super) fn parse_shard(text: &str) -> Result<Shard, &'static str> {
    text.parse().map_err(|_| "M/N with 1 ≤ M ≤ N")
}

pub(super) fn parse_number(text: &str) -> Result<f64, &'static str> {
    text.parse().map_err(|_| "a number")
}

pub(super) fn parse_body(text: &str) -> Result<Ellipsoid, String> {
    Ellipsoid::by_name(text).ok_or_else(|| choices(text, Ellipsoid::ALL.map(|body| body.name())))
}

/// What to do about rings that cross themselves or one another, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RingRepair {
    // Inside is what an odd number of edges separates from the outside.
    EvenOdd,
    // Parts are joined, and holes are.
    Union,
    // So are parts, without their holes.
    KeepShells,
}

impl From<RingRepair> for Repair {
    fn from(repair: RingRepair) -> Self {
        match repair {
            RingRepair::EvenOdd => Self::EvenOdd,
            RingRepair::Union => Self::Union,
            RingRepair::KeepShells => Self::KeepShells,
        }
    }
}
