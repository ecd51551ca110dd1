// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arguments of the gate and of blessings.

use super::own::OwnArguments;
use super::values::{parse_processes, parse_shard, parse_size};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use terrafill_gate::threshold;
use terrafill_results::Shard;

pub(super) const GATE_EXAMPLE: &str = "\
Exit codes: 0 pass · 1 differs for the worse, or for the better and not blessed · 2 bad input ·
            3 inconclusive · 4 nothing measured · 5 no usable device · 6 the machine failed
Example: terrafill gate california --base origin/main --out out/gate";

#[derive(Debug, Clone, Args)]
pub(crate) struct GateArguments {
    /// Shipped scenes by name, scene files, GeoJSON files [default: all shipped scenes]
    pub(crate) scenes: Vec<String>,
    #[command(flatten)]
    pub(crate) own: OwnArguments,
    /// Program or git revision to compare with: both run by turns
    #[arg(long)]
    pub(crate) base: Option<String>,
    /// Program or git revision to decide about [default: this program]
    #[arg(long)]
    pub(crate) new: Option<String>,
    /// Run folder to compare with, without times
    #[arg(long, value_name = "DIR")]
    pub(crate) base_run: Option<PathBuf>,
    /// Run folder to decide about, without times
    #[arg(long, value_name = "DIR", conflicts_with = "new")]
    pub(crate) new_run: Option<PathBuf>,
    /// Saved baseline to compare with, without times
    #[arg(long, value_name = "NAME")]
    pub(crate) baseline: Option<String>,
    /// Save the new run's counters, bytes and errors under this name
    #[arg(long, value_name = "NAME")]
    pub(crate) save_baseline: Option<String>,
    /// Folder of baselines
    #[arg(long, value_name = "DIR", default_value = "gate/baselines")]
    pub(crate) baselines: PathBuf,
    /// File of accepted differences
    #[arg(long, value_name = "FILE", default_value = "gate/blessed.csv")]
    pub(crate) blessed: PathBuf,
    /// File of further limits: case,metric,min,max,reason
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// Study to measure; may be repeated [default: filling]
    #[arg(long)]
    pub(crate) study: Vec<String>,
    /// Technique to run; may be repeated [default: all]
    #[arg(long)]
    pub(crate) technique: Vec<String>,
    /// All main variants, not the quick ones alone
    #[arg(long)]
    pub(crate) main: bool,
    /// Image size, WIDTHxHEIGHT or one number for both
    #[arg(long, default_value = "256", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Compare counters, bytes and errors alone
    #[arg(long)]
    pub(crate) no_time: bool,
    /// Times are printed and decide nothing: for shared machines
    #[arg(long, conflicts_with = "no_time")]
    pub(crate) advisory_time: bool,
    /// Smallest change of a frame's time that fails
    #[arg(long, value_name = "PERCENT", default_value_t = threshold::FLOOR_PERCENT,
        value_parser = parse_floor)]
    pub(crate) floor_percent: f64,
    /// The same of wall clock, preparation, planning [default: 10,50,50]
    #[arg(long, value_name = "W,P,P", value_parser = parse_floors)]
    pub(crate) other_floors: Option<[f64; 3]>,
    /// Time for measuring, builds not counted
    #[arg(long, value_name = "SECONDS", default_value = "600")]
    pub(crate) time_budget_s: u64,
    /// Part m of n of the named scenes; `merge` joins the parts
    #[arg(long, value_name = "M/N", value_parser = parse_shard)]
    pub(crate) shard: Option<Shard>,
    /// Folder of an earlier gate whose times balance the shards
    #[arg(long, value_name = "DIR", requires = "shard")]
    pub(crate) balance_by: Option<PathBuf>,
    /// How often is the time gate right: with equal work, or with more
    #[arg(long, value_name = "aa|inject", hide_possible_values = true)]
    pub(crate) self_test: Option<SelfTestKind>,
    /// Work that the self-test adds
    #[arg(long, default_value = "10")]
    pub(crate) percent: u32,
    /// Gates of a self-test
    #[arg(long, default_value = "4", value_parser = parse_processes)]
    pub(crate) runs: u32,
    /// Folder for runs and report, new or empty
    #[arg(long, default_value = "out/gate")]
    pub(crate) out: PathBuf,
    /// Folder that keeps built revisions
    #[arg(long, value_name = "DIR", default_value = "target/gate")]
    pub(crate) cache: PathBuf,
    /// Folder of data, may be repeated [default: $TERRAFILL_DATA, or data]
    #[arg(long)]
    pub(crate) data: Vec<PathBuf>,
    /// Part of the adapter's name
    #[arg(long)]
    pub(crate) adapter: Option<String>,
}

/// What a self-test proves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SelfTestKind {
    // No false alarm.
    Aa,
    // Added work is caught.
    Inject,
}

#[derive(Debug, Args)]
pub(crate) struct BlessArguments {
    /// Cases, as the gate names them; * stands for any characters
    #[arg(required_unless_present_any = ["all", "prune"])]
    pub(crate) cases: Vec<String>,
    /// Accept every difference that the gate found
    #[arg(long, conflicts_with = "cases")]
    pub(crate) all: bool,
    /// Take out what covers nothing any more of the scenes that it measured
    #[arg(long)]
    pub(crate) prune: bool,
    /// Why the differences are accepted
    #[arg(long)]
    pub(crate) reason: Option<String>,
    /// Metric to accept; may be repeated [default: all that differ]
    #[arg(long)]
    pub(crate) metric: Vec<String>,
    /// Folder of the gate that found it
    #[arg(long, value_name = "DIR", default_value = "out/gate")]
    pub(crate) gate: PathBuf,
    /// File of accepted differences
    #[arg(long, value_name = "FILE", default_value = "gate/blessed.csv")]
    pub(crate) blessed: PathBuf,
}

pub(super) const BLESS_EXAMPLE: &str = "\
A change of a time is accepted from the base that it was found on, and from no later one.
Example: terrafill bless \"filling/hills/*/doubled\" --reason \"two caps\"
         terrafill bless --all --reason \"another mesh\" --prune";

fn parse_floors(text: &str) -> Result<[f64; 3], &'static str> {
    let floors: Option<Vec<f64>> = text.split(',').map(|of| parse_floor(of).ok()).collect();
    let floors = floors.and_then(|floors| <[f64; 3]>::try_from(floors).ok());
    floors.ok_or("three of 0.5 … 100 with commas between: wall clock, preparation, planning")
}

/// A floor of 0 would fail on noise alone.
fn parse_floor(text: &str) -> Result<f64, &'static str> {
    match text.parse() {
        Ok(percent) if (0.5..=100.0).contains(&percent) => Ok(percent),
        _ => Err("0.5 … 100"),
    }
}
