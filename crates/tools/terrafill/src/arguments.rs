// SPDX-License-Identifier: MIT OR Apache-2.0
//! Verbs and their arguments.
#![allow(
    clippy::doc_markdown,
    reason = "these are texts of --help, where marks of code would show"
)]

mod budget;
mod gate;
mod history;
mod own;
mod values;

pub(crate) use budget::BudgetArguments;
pub(crate) use gate::{BlessArguments, GateArguments, SelfTestKind};
pub(crate) use history::{
    BackfillArguments, BisectArguments, HistoryArguments, HistoryVerb, StoreArguments,
};
pub(crate) use own::{InitArguments, OwnArguments, SceneArguments, SceneVerb, UnusedArguments};
pub(crate) use values::{Edges, ReadingArguments, RingRepair};

use crate::{registry, version};
use clap::builder::PossibleValuesParser;
use clap::{Args, ColorChoice, Parser, Subcommand, ValueEnum};
use clap_complete::aot::Shell;
use gate::{BLESS_EXAMPLE, GATE_EXAMPLE};
use history::HISTORY_EXAMPLE;
use std::path::PathBuf;
use terrafill_core::Ellipsoid;
use terrafill_data::{Mirror, WrongMirror};
use terrafill_filling::EXTREME;
use terrafill_results::Shard;
use terrafill_scene::choices;
use values::{parse_body, parse_number, parse_processes, parse_samples, parse_shard, parse_size};

const EXIT_CODES: &str = "\
Exit codes: 0 done · 1 a picture is wrong · 2 bad input or usage · 3 inconclusive ·
            4 nothing measured · 5 no usable device · 128 + n stopped by signal n
Colours: --color auto|always|never with any command; auto has none where NO_COLOR is set
Example: terrafill bench california --quick --out out/first";

const BENCH_EXAMPLE: &str = "\
Takes --tolerance-px, --max-mb, --budget-ms and --open of `terrafill report`, too.
Example: terrafill bench planet-134 california --out out/first";

const LOCATE_AFTER_HELP: &str = "\
Prints the table of points with a column regions behind the others: indices of
features from 0, joined by ;. Longitudes are rounded to multiples of 2^-43 degrees
(13 nm at the equator) and, for great-ellipse edges, places to unit vectors in f64
(1 nm); on which side of an edge the rounded place lies is decided exactly.
Example: terrafill locate countries.geojson --points points.csv --names";

/// Draws things on planets by competing GPU techniques and measures their error and their cost.
#[derive(Debug, Parser)]
#[command(version, long_version = version::long(), after_help = EXIT_CODES, max_term_width = 100)]
pub(crate) struct Arguments {
    // Hidden, since every verb has it: `terrafill --help` names it below.
    #[arg(long, global = true, hide = true, default_value = "auto")]
    #[allow(dead_code, reason = "read before the others are, see `colour`")]
    pub(crate) color: ColorChoice,
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Measure studies into a folder of tables, and write its report
    #[command(after_help = BENCH_EXAMPLE)]
    #[command(mut_arg("tolerance_px", |arg| arg.hide(true)))]
    #[command(mut_arg("max_mb", |arg| arg.hide(true)))]
    #[command(mut_arg("budget_ms", |arg| arg.hide(true)))]
    Bench(BenchArguments),
    /// Rebuild the report of a run from its tables alone
    #[command(after_help = "Example: terrafill report out/first --tolerance-px 2 --max-mb 8")]
    Report(ReportArguments),
    /// Join the shards of a run, or of a gate, into one folder
    #[command(after_help = "Example: terrafill merge out/shard-1 out/shard-2 --out out/all")]
    Merge(MergeArguments),
    /// Decide whether a version does more work, errs more or takes longer than another
    #[command(after_help = GATE_EXAMPLE, mut_arg("terrain", |arg| arg.hide(true)))]
    Gate(GateArguments),
    /// Accept differences that the gate found, in a file that is reviewed
    #[command(after_help = BLESS_EXAMPLE)]
    Bless(BlessArguments),
    /// Set two runs side by side, or many by device
    #[command(after_help = COMPARE_EXAMPLE)]
    Compare(CompareArguments),
    /// Keep runs of many commits, and find where figures changed
    #[command(after_help = HISTORY_EXAMPLE)]
    History(HistoryArguments),
    /// Draw one picture
    #[command(
        after_help = "Example: terrafill render california --view globe --out california.png"
    )]
    Render(RenderArguments),
    /// Mesh regions and print what came of it
    #[command(after_help = "Example: terrafill mesh countries.geojson --json | jq .totals")]
    Mesh(MeshArguments),
    /// Say which regions hold which points, by the reference's tests
    #[command(after_help = LOCATE_AFTER_HELP)]
    Locate(LocateArguments),
    /// List the data sets that scenes need, and get them from where they are published
    #[command(after_help = DATA_EXAMPLE)]
    Data(DataArguments),
    /// Make a scene file of one's own regions
    #[command(after_help = "Example: terrafill scene init hoods.geojson --out hoods.toml")]
    Scene(SceneArguments),
    /// List the shipped scenes and whether they can run
    #[command(after_help = "Example: terrafill scenes --data natural-earth")]
    Scenes(ScenesArguments),
    /// List the studies, what each asks and what it measures
    #[command(after_help = "Example: terrafill studies --json")]
    Studies(StudiesArguments),
    /// List the techniques with their switches, values and defaults
    #[command(after_help = "Example: terrafill techniques --json | jq .techniques[].name")]
    Techniques(TechniquesArguments),
    /// List the devices of this machine, what runs on them, and what the rest lack
    #[command(after_help = "Example: terrafill devices --json")]
    Devices(DevicesArguments),
    /// Print what a shell completes commands by
    #[command(after_help = "Example: terrafill completions bash > ~/.terrafill.bash")]
    Completions {
        #[arg(value_enum)]
        shell: Shell,
    },
    /// Write manual pages, one for each command
    #[command(after_help = "Example: terrafill man target/man && man -l target/man/terrafill.1")]
    Man {
        /// Folder for them
        folder: PathBuf,
    },
    /// Mesh one region and print its vertices and CPU milliseconds: what `bench` starts for each
    #[command(hide = true, name = registry::GROWTH_SAMPLE)]
    GrowthSample(GrowthSampleArguments),
}

#[derive(Debug, Args)]
pub(crate) struct GrowthSampleArguments {
    /// GeoJSON of one region
    pub(crate) file: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct StudiesArguments {
    /// Print one JSON object instead of a list
    #[arg(long, conflicts_with = "markdown")]
    pub(crate) json: bool,
    /// Print every metric with its meaning, as tables in Markdown
    #[arg(long)]
    pub(crate) markdown: bool,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct BenchArguments {
    /// Shipped scenes by name, scene files, GeoJSON files [default: all shipped scenes]
    pub(crate) scenes: Vec<String>,
    #[command(flatten)]
    pub(crate) own: OwnArguments,
    #[arg(long, help = STUDY_HELP)]
    pub(crate) study: Vec<String>,
    /// Run a suite of scenes that globes break at instead: extreme
    #[arg(long, value_name = "NAME", value_parser = parse_suite,
        conflicts_with_all = ["study", "quick", "full", "processes", "shard", "ablation", "matrix"])]
    pub(crate) suite: Option<String>,
    /// This process runs the suite's scenes: another one started it and outlives its crashes
    #[arg(long, hide = true, requires = "suite")]
    pub(crate) in_suite: bool,
    /// Technique to run; may be repeated [default: all]
    #[arg(long, alias = "backend")]
    pub(crate) technique: Vec<String>,
    /// Main variants in few frames and one process
    #[arg(long, conflicts_with = "full")]
    pub(crate) quick: bool,
    /// Every study, variant, ablation, matrix and sweep
    #[arg(long)]
    pub(crate) full: bool,
    /// Processes, each a replicate [default: 5, quick 1, ablations to 36]
    #[arg(long, value_parser = parse_processes)]
    pub(crate) processes: Option<u32>,
    /// Which of the processes this is: `bench` starts the others with it
    #[arg(long, hide = true, default_value = "0")]
    pub(crate) process: u32,
    /// How many processes there are at most, where what is undecided takes more than planned
    #[arg(long, hide = true)]
    pub(crate) process_of: Option<u32>,
    /// File of case keys, one a line, that this process times alone: `gate` starts replicates with it
    #[arg(long, hide = true, value_name = "FILE")]
    pub(crate) time_only: Option<PathBuf>,
    /// Take samples as lines on standard input release them: `gate` steps several programs by turns
    #[arg(long, hide = true, requires = "time_only")]
    pub(crate) stepped: bool,
    /// Frames that a timed sample is the mean of
    #[arg(long, hide = true, default_value = "1", value_parser = parse_samples)]
    pub(crate) frames_per_sample: u32,
    /// Frames whose cost is added to each sample: the gate's self-test
    #[arg(long, hide = true, default_value = "0")]
    pub(crate) extra_frames: u32,
    /// Folder for the run
    #[arg(long, default_value = "out/run")]
    pub(crate) out: PathBuf,
    /// Go on with a run that was killed
    #[arg(long)]
    pub(crate) resume: bool,
    /// Folder of data, may be repeated [default: $TERRAFILL_DATA, or data]
    #[arg(long)]
    pub(crate) data: Vec<PathBuf>,
    /// Timed samples of a case in each process [default: each study's]
    #[arg(long, alias = "frames", value_parser = parse_samples)]
    pub(crate) samples: Option<u32>,
    /// Image size, WIDTHxHEIGHT or one number [default: 1024, extreme 256]
    #[arg(long, value_parser = parse_size)]
    pub(crate) size: Option<(u32, u32)>,
    /// Part m of n of the run
    #[arg(long, value_name = "M/N", value_parser = parse_shard)]
    pub(crate) shard: Option<Shard>,
    #[arg(long, value_name = "WAY", default_value = "turns", requires = "shard",
        value_parser = parse_sharing, help = SHARD_BY_HELP)]
    pub(crate) shard_by: Sharing,
    /// Part of the adapter's name
    #[arg(long)]
    pub(crate) adapter: Option<String>,
    /// Seed of the order in which cases are measured
    #[arg(long, default_value = "1")]
    pub(crate) seed: u64,
    #[arg(long, value_name = "SCENE", alias = "ladder", help = ABLATION_HELP)]
    pub(crate) ablation: Vec<String>,
    #[arg(long, value_name = "SCENE", help = MATRIX_HELP)]
    pub(crate) matrix: Vec<String>,
    #[arg(long, value_name = "FILE", requires = "study", help = CASTERS_HELP)]
    pub(crate) casters: Option<String>,
    #[arg(long, hide = true)]
    pub(crate) open: bool,
    #[command(flatten)]
    pub(crate) budget: BudgetArguments,
}

impl BenchArguments {
    /// Width and height of pictures, pixels. Small ones keep the suite within minutes; larger ones show errors
    /// that they hide, and can be asked for.
    pub(crate) fn size(&self) -> (u32, u32) {
        let is_suite = self.suite.is_some() || self.study == [EXTREME];
        let side = if is_suite { 256 } else { 1024 };
        self.size.unwrap_or((side, side))
    }
}

fn parse_suite(text: &str) -> Result<String, String> {
    let suites = terrafill_scene::suite_names();
    if suites.contains(&text) {
        Ok(text.to_owned())
    } else {
        Err(choices(text, suites))
    }
}

/// How groups of cases are shared among shards.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Sharing {
    Turns,
    Hash,
    /// By how long they took in the run of this folder.
    Duration(PathBuf),
}

const SHARD_BY_HELP: &str = "\
turns, hash (a scene stays in its shard) or duration:RUN
(balanced by how long RUN took)";

const STUDY_HELP: &str = "\
Study to measure; may be repeated; `terrafill studies`
lists them [default: filling, with --full all]";

#[derive(Debug, Args)]
pub(crate) struct MergeArguments {
    /// Folders of all the shards of a run or of a gate
    #[arg(required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// New folder for the whole
    #[arg(long)]
    pub(crate) out: PathBuf,
}

const COMPARE_EXAMPLE: &str = "\
Counters, bytes and errors are compared exactly and decide the exit code: 0 nothing differs ·
1 something does · 3 inconclusive · 4 nothing compared. Times of two jobs are advice.
Example: terrafill compare out/before out/after --html out/compared
         terrafill compare out/laptop out/server --by device";

#[derive(Debug, Args)]
pub(crate) struct CompareArguments {
    /// Run folders: the base and the new one, or with --by device any number
    #[arg(required = true)]
    pub(crate) runs: Vec<PathBuf>,
    #[arg(long, value_name = "device", hide_possible_values = true, help = BY_HELP)]
    pub(crate) by: Option<Sides>,
    /// With --by device: what times are divided by
    #[arg(long, value_name = "TECHNIQUE", default_value = terrafill_history::CONTROL)]
    pub(crate) control: String,
    /// Print one JSON object
    #[arg(long, conflicts_with = "csv")]
    pub(crate) json: bool,
    /// Print a table, every difference and every time
    #[arg(long)]
    pub(crate) csv: bool,
    /// Also write a page, index.html in this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) html: Option<PathBuf>,
}

/// What stands side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Sides {
    // Kinds of machines.
    Device,
}

const BY_HELP: &str = "\
device: a column for each kind of machine, times as ratios
to its own control";

const ABLATION_HELP: &str = "\
Scene to measure switch by switch, from the un-optimised
method to the full plan, SCENE:STEP from a step on, or
none; may be repeated
[default: none, with --full planet-134]";

const CASTERS_HELP: &str = "\
OBJ or GLB file whose models cast the shadows of study
shadows, m; ,up=z where an OBJ file is z up; ,unit=METRES;
,policy=refuse|cap|robust|as-is if it is not closed";

const MATRIX_HELP: &str = "\
Scene to draw by every backend, layout and switch, or none;
may be repeated [default: none, with --full planet-134,
california, countries-110m]";

#[derive(Debug, Args)]
pub(crate) struct ReportArguments {
    /// Folder of a run
    pub(crate) run: PathBuf,
    /// Put all pages and pictures into index.html alone
    #[arg(long)]
    pub(crate) single_file: bool,
    /// Open the report with the system's program for pages
    #[arg(long)]
    pub(crate) open: bool,
    #[command(flatten)]
    pub(crate) budget: BudgetArguments,
}

const SET_HELP: &str = "\
Draw this variant in place of the technique's full plan:
a name from a report (doubled: bare) or switches, such as
layout=pulled,walls=list; may be repeated; after full-plan
they change that plan";

const FIT_HELP: &str = "\
SCENE is a GeoJSON file: on WGS 84, by planar edges, seen
from above so that all is in view; crossings are filled by
the even-odd rule";

const POINTS_HELP: &str = "\
CSV file with columns lon and lat, degrees, or - for
standard input; every column comes out again";

#[derive(Debug, Args)]
pub(crate) struct RenderArguments {
    /// Shipped scene by name, a scene file, a GeoJSON file, or STUDY/VALUE… of a case
    #[arg(required_unless_present = "list_switches")]
    pub(crate) scene: Option<String>,
    #[command(flatten)]
    pub(crate) own: OwnArguments,
    /// View if there are several; of GeoJSON all, filled or dense, horizon
    #[arg(long, conflicts_with = "fit")]
    pub(crate) view: Option<String>,
    #[arg(long, help = FIT_HELP)]
    pub(crate) fit: bool,
    /// Which of a study case's pictures, by name: a wrong one lists them
    #[arg(long, value_name = "NAME")]
    pub(crate) picture: Option<String>,
    #[arg(long, value_enum, default_value = "judged", hide_possible_values = true, help = STYLE_HELP)]
    pub(crate) style: Style,
    /// A technique, or reference [default: vertex]
    #[arg(
        long,
        alias = "backend",
        value_parser = picture_backends(),
        hide_possible_values = true
    )]
    pub(crate) technique: Option<String>,
    #[arg(long, alias = "variant", value_name = "KEY=VALUE", help = SET_HELP)]
    pub(crate) set: Vec<String>,
    /// Print each switch with meaning, values and default; draw nothing
    #[arg(long)]
    pub(crate) list_switches: bool,
    /// Picture to write, .png, or - for standard output
    #[arg(long, required_unless_present = "list_switches")]
    pub(crate) out: Option<PathBuf>,
    /// Region ids to write, 16-bit grey PNG: feature index + 1, 0 for none
    #[arg(long)]
    pub(crate) ids: Option<PathBuf>,
    /// Counters, memory and what was left out, JSON
    #[arg(long)]
    pub(crate) stats: Option<PathBuf>,
    /// Compare with the reference: a picture that is wrong ends with 1
    #[arg(long)]
    pub(crate) check: bool,
    /// Folder of data, may be repeated [default: $TERRAFILL_DATA, or data]
    #[arg(long)]
    pub(crate) data: Vec<PathBuf>,
    /// Image size, WIDTHxHEIGHT or one number for both
    #[arg(long, default_value = "1024", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Part of the adapter's name
    #[arg(long)]
    pub(crate) adapter: Option<String>,
}

/// How a picture looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Style {
    // A colour for each region, as the reference and the techniques are compared.
    Judged,
    // For people.
    Map,
}

impl RenderArguments {
    /// What draws; maps are the reference's.
    pub(crate) fn technique(&self) -> &str {
        let default = match self.style {
            Style::Judged => "vertex",
            Style::Map => "reference",
        };
        self.technique.as_deref().unwrap_or(default)
    }
}

impl Style {
    /// Extensions of its files: who compares pixels needs every bit.
    pub(crate) fn formats(self) -> &'static [&'static str] {
        match self {
            Self::Judged => &["png"],
            Self::Map => &["png", "jpg"],
        }
    }
}

const STYLE_HELP: &str = "\
judged: flat colours, as pictures are compared; map: for
people, drawn from the reference, without a technique:
tints of height in a light from the north-west, sky,
outlines, and where the eye is; writes .jpg, too";

/// What can draw a picture. The values have no help of their own: with it clap prints a paragraph
/// per option, and the page no longer fits a screen.
fn picture_backends() -> PossibleValuesParser {
    PossibleValuesParser::new(registry::names().into_iter().chain(["reference"]))
}

const EDGES_HELP: &str = "\
What an edge between two vertices is: planar (straight in
longitude and latitude, RFC 7946) or great-ellipse (in the
plane through the body's centre)";

const BODY_HELP: &str = "\
Ellipsoid: wgs84, moon, mars, saturn-like, unit-sphere or
asteroid-250m";

const REPAIR_HELP: &str = "\
Rings that cross or overlap: even-odd, union (joined) or
keep-shells (without holes); without it they are refused";

#[derive(Debug, Args)]
pub(crate) struct MeshArguments {
    /// GeoJSON file, or - for standard input
    pub(crate) regions: PathBuf,
    #[arg(long, default_value = "planar", hide_possible_values = true, help = EDGES_HELP)]
    pub(crate) edges: Edges,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
    #[arg(long, hide_possible_values = true, help = REPAIR_HELP)]
    pub(crate) repair: Option<RingRepair>,
    /// Go on with the features that are right, and list the others
    #[arg(long)]
    pub(crate) skip_invalid: bool,
    #[arg(long, default_value = "wgs84", value_parser = parse_body, help = BODY_HELP)]
    pub(crate) body: Ellipsoid,
    /// Largest distance of a drawn edge from its rule
    #[arg(long, default_value = "100", value_name = "METRES", value_parser = parse_number)]
    pub(crate) boundary_tolerance_m: f64,
    /// Largest edge of a cap triangle
    #[arg(long, default_value = "3", value_name = "DEGREES", value_parser = parse_number)]
    pub(crate) cap_step_deg: f64,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) unused: UnusedArguments,
}

#[derive(Debug, Args)]
pub(crate) struct LocateArguments {
    /// GeoJSON file, or - for standard input
    pub(crate) regions: PathBuf,
    #[arg(long, help = POINTS_HELP)]
    pub(crate) points: PathBuf,
    /// Add a column names behind regions
    #[arg(long)]
    pub(crate) names: bool,
    #[arg(long, default_value = "planar", hide_possible_values = true, help = EDGES_HELP)]
    pub(crate) edges: Edges,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
    #[arg(long, hide_possible_values = true, help = REPAIR_HELP)]
    pub(crate) repair: Option<RingRepair>,
    /// Go on with the features that are right, and list the others
    #[arg(long)]
    pub(crate) skip_invalid: bool,
    #[arg(long, default_value = "wgs84", value_parser = parse_body, help = BODY_HELP)]
    pub(crate) body: Ellipsoid,
    #[command(flatten)]
    pub(crate) unused: UnusedArguments,
}

#[derive(Debug, Args)]
pub(crate) struct TechniquesArguments {
    /// Print one JSON object instead of a list
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct DevicesArguments {
    /// Print one JSON object instead of a list
    #[arg(long)]
    pub(crate) json: bool,
}

const DATA_EXAMPLE: &str = "\
The data folder is that of TERRAFILL_DATA, or data in the current folder.
Example: terrafill data get natural-earth-110m && terrafill bench countries-110m --quick";

#[derive(Debug, Args)]
pub(crate) struct DataArguments {
    #[command(subcommand)]
    pub(crate) verb: DataVerb,
}

/// What to do about data sets.
#[derive(Debug, Subcommand)]
pub(crate) enum DataVerb {
    /// List every set: licence, source, size, whether it is here, and who reads it
    #[command(after_help = "Example: terrafill data list --json | jq .sets[].name")]
    List {
        /// Print one JSON object instead of a list
        #[arg(long)]
        json: bool,
        /// Folder with real data [default: $TERRAFILL_DATA, or data]
        #[arg(long, value_name = "DIR")]
        data: Option<PathBuf>,
    },
    /// Fetch sets with curl, verify them, and make what is made of them
    #[command(after_help = "Example: terrafill data get natural-earth-110m us-10m")]
    Get {
        /// Sets by their names, or what begins one name alone
        #[arg(required = true, value_name = "NAME")]
        names: Vec<String>,
        /// Folder to put them into [default: $TERRAFILL_DATA, or data]
        #[arg(long, value_name = "DIR")]
        to: Option<PathBuf>,
        /// Host that has the same paths, instead of the sources'
        #[arg(long, value_name = "BASE_URL", value_parser = parse_mirror)]
        from: Option<Mirror>,
    },
}

fn parse_mirror(text: &str) -> Result<Mirror, WrongMirror> {
    text.parse()
}

#[derive(Debug, Args)]
pub(crate) struct ScenesArguments {
    /// Print one JSON object instead of a list
    #[arg(long)]
    pub(crate) json: bool,
    /// Folder of data, may be repeated [default: $TERRAFILL_DATA, or data]
    #[arg(long)]
    pub(crate) data: Vec<PathBuf>,
}

// The error of each parser is what is allowed; the message around it is made in `usage`.

fn parse_sharing(text: &str) -> Result<Sharing, &'static str> {
    match (text, text.split_once(':')) {
        ("turns", _) => Ok(Sharing::Turns),
        ("hash", _) => Ok(Sharing::Hash),
        (_, Some(("duration", run))) if !run.is_empty() => Ok(Sharing::Duration(run.into())),
        _ => Err("turns, hash or duration:RUN, a run folder"),
    }
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
    fn a_suite_alone_is_drawn_small() {
        for (options, side) in [
            (&["--suite", "extreme"][..], 256),
            (&["--study", "extreme", "--quick"], 256),
            (&["--study", "extreme", "--size", "512"], 512),
            (&["--study", "extreme", "--study", "filling"], 1024),
            (&["--full"], 1024),
        ] {
            let line = [&["terrafill", "bench"][..], options].concat();
            let Ok(Arguments {
                verb: Verb::Bench(arguments),
                ..
            }) = Arguments::try_parse_from(line)
            else {
                panic!("{options:?} is not taken");
            };
            assert_eq!(arguments.size(), (side, side), "{options:?}");
        }
    }

    #[test]
    fn an_ablation_has_its_old_name_too_and_no_other() {
        let scenes = |option: &str| {
            let line = ["terrafill", "bench", option, "california:colours"];
            match Arguments::try_parse_from(line) {
                Ok(Arguments {
                    verb: Verb::Bench(arguments),
                    ..
                }) => Some(arguments.ablation),
                _ => None,
            }
        };
        let expected = Some(vec!["california:colours".to_owned()]);
        assert_eq!(scenes("--ablation"), expected);
        assert_eq!(scenes("--ladder"), expected);
        assert_eq!(scenes("--rungs"), None);
    }

    #[test]
    fn sizes_are_read_and_refused() {
        assert_eq!(parse_size("1024"), Ok((1024, 1024)));
        assert_eq!(parse_size("1920x1080"), Ok((1920, 1080)));
        for wrong in ["0", "16385", "x", "10x", "-1", "10x20x30", ""] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }
}
