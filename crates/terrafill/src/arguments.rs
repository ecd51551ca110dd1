// SPDX-License-Identifier: MIT OR Apache-2.0
//! Verbs and their arguments.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use terrafill_bench::Shard;
use terrafill_core::EdgeRule;

const EXIT_CODES: &str = "Exit codes: 0 done · 1 a picture is wrong · 2 bad input or usage · \
    3 inconclusive · 4 nothing measured · 5 no usable device";

/// Fills polygon regions on planets on the GPU and measures the error and the cost.
#[derive(Debug, Parser)]
#[command(version, after_help = EXIT_CODES, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Measure cases; writes samples.csv, summary.csv, environment.json, images and report.html
    #[command(after_help = "Example: terrafill bench planet-134 california --out out/first")]
    Bench(BenchArguments),
    /// Rebuild report.html of a run from its CSV alone
    #[command(after_help = "Example: terrafill report out/first")]
    Report(ReportArguments),
    /// Draw one picture
    #[command(
        after_help = "Example: terrafill render california --view globe --out california.png"
    )]
    Render(RenderArguments),
    /// Mesh regions and print what came of it
    #[command(after_help = "Example: terrafill mesh countries.geojson --json | jq .totals")]
    Mesh(MeshArguments),
    /// Say which regions hold which points, by the reference's exact tests
    #[command(after_help = "Example: terrafill locate countries.geojson --points points.csv")]
    Locate(LocateArguments),
    /// List the shipped scenes and whether they can run
    Scenes(ScenesArguments),
    /// List the devices of this machine, and what they lack
    Devices,
}

#[derive(Debug, Args)]
pub(crate) struct BenchArguments {
    /// Shipped scenes by name, or paths of scene files [default: all shipped scenes]
    pub(crate) scenes: Vec<String>,
    /// Backend to run; may be repeated [default: all]
    #[arg(long)]
    pub(crate) backend: Vec<String>,
    /// 8 frames a case, main variants only
    #[arg(long)]
    pub(crate) quick: bool,
    /// Folder for the run
    #[arg(long, default_value = "out/run")]
    pub(crate) out: PathBuf,
    /// Go on with a run that was killed
    #[arg(long)]
    pub(crate) resume: bool,
    /// Folder with real data [default: $TERRAFILL_DATA]
    #[arg(long)]
    pub(crate) data: Option<PathBuf>,
    /// Timed frames per case [default: 30, with --quick 8]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) frames: Option<u32>,
    /// Image size, WIDTHxHEIGHT or one number for both
    #[arg(long, default_value = "1024", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Part m of n of the scene views
    #[arg(long, value_name = "M/N")]
    pub(crate) shard: Option<Shard>,
    /// Part of the adapter's name
    #[arg(long)]
    pub(crate) adapter: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct ReportArguments {
    /// Folder of a run
    pub(crate) run: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct RenderArguments {
    /// Shipped scene by name, or path of a scene file
    pub(crate) scene: String,
    /// View of the scene
    #[arg(long)]
    pub(crate) view: String,
    /// Backend
    #[arg(long, default_value = "vertex")]
    pub(crate) backend: RenderBackend,
    /// Switch, KEY=VALUE; may be repeated: layout=doubled|pulled, positions=fixed|local-f32,
    /// colour=xor|rectangle, boundary-tolerance-m=METRES
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) variant: Vec<String>,
    /// Picture to write, PNG
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Region ids to write, 16-bit grey PNG: 0 none, feature index + 1
    #[arg(long)]
    pub(crate) ids: Option<PathBuf>,
    /// Counters, memory and what was left out, JSON
    #[arg(long)]
    pub(crate) stats: Option<PathBuf>,
    /// Folder with real data [default: $TERRAFILL_DATA]
    #[arg(long)]
    pub(crate) data: Option<PathBuf>,
    /// Image size, WIDTHxHEIGHT or one number for both
    #[arg(long, default_value = "1024", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Part of the adapter's name
    #[arg(long)]
    pub(crate) adapter: Option<String>,
}

/// What can draw a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RenderBackend {
    /// Shadow volumes in the vertex shader
    Vertex,
    /// The f64 reference on the CPU
    Reference,
}

/// Edge rule by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Edges {
    /// Straight in longitude and latitude (RFC 7946)
    Planar,
    /// In the plane through the body's centre
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

#[derive(Debug, Args)]
pub(crate) struct MeshArguments {
    /// GeoJSON file
    pub(crate) regions: PathBuf,
    /// What an edge between two vertices is
    #[arg(long, default_value = "planar")]
    pub(crate) edges: Edges,
    /// wgs84, moon, mars, saturn-like, unit-sphere or asteroid-250m
    #[arg(long, default_value = "wgs84")]
    pub(crate) body: String,
    /// Largest distance of a drawn boundary edge from its rule, metres
    #[arg(long, default_value_t = 100.0)]
    pub(crate) boundary_tolerance_m: f64,
    /// Largest edge of a cap triangle, degrees of arc
    #[arg(long, default_value_t = 3.0)]
    pub(crate) cap_step_deg: f64,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct LocateArguments {
    /// GeoJSON file
    pub(crate) regions: PathBuf,
    /// CSV with columns lon and lat, degrees
    #[arg(long)]
    pub(crate) points: PathBuf,
    /// What an edge between two vertices is
    #[arg(long, default_value = "planar")]
    pub(crate) edges: Edges,
}

#[derive(Debug, Args)]
pub(crate) struct ScenesArguments {
    /// Folder with real data [default: $TERRAFILL_DATA]
    #[arg(long)]
    pub(crate) data: Option<PathBuf>,
}

/// `1024` or `1920x1080`.
fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    let parse = |side: &str| match side.parse::<u32>() {
        Ok(pixels @ 1..=16_384) => Ok(pixels),
        _ => Err(format!("{side:?}, allowed: 1 … 16384 pixels a side")),
    };
    Ok((parse(width)?, parse(height)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory as _;
        Arguments::command().debug_assert();
    }

    #[test]
    fn sizes_are_read_and_refused() {
        assert_eq!(parse_size("1024"), Ok((1024, 1024)));
        assert_eq!(parse_size("1920x1080"), Ok((1920, 1080)));
        for wrong in ["0", "16385", "x", "10x", "-1", "10x20x30"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }
}
