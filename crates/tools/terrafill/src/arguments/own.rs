// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arguments of files of regions that become scenes.

use super::values::{Edges, LongEdges, PoleSide, ReadingArguments, RingRepair, parse_size};
use clap::{Args, Subcommand};
use std::path::PathBuf;
use terrafill_core::Reading;

/// What a file of regions becomes a scene with. All but the terrain are rare: `scene init --help` has them.
#[derive(Debug, Clone, Args)]
pub(crate) struct OwnArguments {
    /// Heights under GeoJSON: file or folder; `scene init --help` has more
    #[arg(long, value_name = "PATH")]
    pub(crate) terrain: Vec<PathBuf>,
    #[arg(long, default_value = "planar", hide = true)]
    pub(crate) edges: Edges,
    #[arg(long, default_value = "auto", hide = true)]
    pub(crate) unwrap: LongEdges,
    #[arg(long, default_value = "smaller", hide = true)]
    pub(crate) inside: PoleSide,
    /// Crossings of a scene made of a file are never refused
    #[arg(long, hide = true, default_value = "even-odd")]
    pub(crate) repair: RingRepair,
    #[arg(long, hide = true)]
    pub(crate) name: Option<String>,
}

impl OwnArguments {
    /// How the file is read.
    pub(crate) fn reading(&self) -> Reading {
        ReadingArguments {
            unwrap: self.unwrap,
            inside: self.inside,
        }
        .into()
    }
}

/// What other verbs take with a file of regions and `mesh` and `locate` have no use for: one line of options fits all.
#[derive(Debug, Args)]
pub(crate) struct UnusedArguments {
    #[arg(long, hide = true)]
    terrain: Vec<PathBuf>,
    #[arg(long, hide = true)]
    name: Option<String>,
}

impl UnusedArguments {
    /// A line for each that was given.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let given = [
            (
                "--terrain",
                !self.terrain.is_empty(),
                "regions lie on the body here, whatever is under a fill",
            ),
            ("--name", self.name.is_some(), "no scene is made here"),
        ];
        let given = given.into_iter().filter(|(_, is_given, _)| *is_given);
        given
            .map(|(option, _, why)| format!("warning: {option} decides nothing: {why}"))
            .collect()
    }
}

const SCENE_EXAMPLE: &str = "\
These have `bench`, `render` and `gate` of GeoJSON, too:
      --edges planar|great-ellipse, --unwrap auto|literal|shortest: as of `mesh`
      --inside smaller|left: as of `mesh`
      --repair even-odd|union|keep-shells: without it crossings are filled even-odd
      --name NAME: of the scene [default: the file's]
Example: terrafill scene init hoods.geojson --terrain dem.tif --out hoods.toml
         terrafill bench hoods.toml --quick";

#[derive(Debug, Args)]
pub(crate) struct SceneArguments {
    #[command(subcommand)]
    pub(crate) verb: SceneVerb,
}

/// What to do about scene files.
#[derive(Debug, Subcommand)]
pub(crate) enum SceneVerb {
    /// Write the scene file that `bench FILE.geojson` measures, to be edited
    #[command(after_help = SCENE_EXAMPLE)]
    Init(InitArguments),
}

#[derive(Debug, Args)]
pub(crate) struct InitArguments {
    /// GeoJSON file
    pub(crate) regions: PathBuf,
    #[command(flatten)]
    pub(crate) own: OwnArguments,
    /// Scene file to write, .toml, or - for standard output
    #[arg(long, default_value = "-")]
    pub(crate) out: PathBuf,
    /// Image size that cameras are made for
    #[arg(long, default_value = "1024", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
}
