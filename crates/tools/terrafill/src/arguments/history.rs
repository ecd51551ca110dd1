// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arguments of histories.

use clap::{Args, Subcommand};
use std::path::PathBuf;

pub(super) const HISTORY_EXAMPLE: &str = "\
A history is one file that is appended to and never edited. Changes of times are advice.
Example: terrafill history add out/run --store history.sqlite";

#[derive(Debug, Args)]
pub(crate) struct HistoryArguments {
    #[command(subcommand)]
    pub(crate) verb: HistoryVerb,
}

#[derive(Debug, Args)]
pub(crate) struct StoreArguments {
    /// File of the history
    #[arg(long, value_name = "FILE", default_value = "history.sqlite")]
    pub(crate) store: PathBuf,
}

/// What to do with a history.
#[derive(Debug, Subcommand)]
pub(crate) enum HistoryVerb {
    /// Store runs; one that is there already is left alone
    #[command(after_help = "Example: terrafill history add out/run --store history.sqlite")]
    Add {
        /// Run folders
        #[arg(required = true)]
        runs: Vec<PathBuf>,
        #[command(flatten)]
        store: StoreArguments,
        /// Repository that tells the order of commits
        #[arg(long, value_name = "DIR", default_value = ".")]
        repository: PathBuf,
    },
    /// List machines and runs
    #[command(after_help = "Example: terrafill history list --json")]
    List {
        #[command(flatten)]
        store: StoreArguments,
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// List where figures changed, for better and for worse, and what is missing
    #[command(after_help = "Example: terrafill history changes --metric fill_wall_ms")]
    Changes {
        #[command(flatten)]
        store: StoreArguments,
        /// Figure to look at; may be repeated [default: exact ones and main times]
        #[arg(long)]
        metric: Vec<String>,
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// Write a page: changes, what is missing, and the course of every case
    #[command(after_help = "Example: terrafill history report --out out/history")]
    Report {
        #[command(flatten)]
        store: StoreArguments,
        /// Figure to look at; may be repeated [default: exact ones and main times]
        #[arg(long)]
        metric: Vec<String>,
        /// Repository that knows the commits and their web host
        #[arg(long, value_name = "DIR", default_value = ".")]
        repository: PathBuf,
        /// Folder for index.html
        #[arg(short, long, value_name = "DIR", default_value = "out/history")]
        out: PathBuf,
    },
    /// Propose the commits to build to find the one that changed a case
    #[command(
        after_help = "Example: terrafill history bisect filling/california/globe/vertex/doubled"
    )]
    Bisect(BisectArguments),
    /// Build and measure commits of a range that the history lacks
    #[command(after_help = BACKFILL_EXAMPLE)]
    Backfill(BackfillArguments),
    /// Write everything as tables
    #[command(after_help = "Example: terrafill history export --csv out/tables")]
    Export {
        #[command(flatten)]
        store: StoreArguments,
        /// Folder for runs.csv, cases.csv, figures.csv and metrics.csv
        #[arg(long, value_name = "DIR")]
        csv: PathBuf,
    },
    /// Store the runs of exported tables
    #[command(after_help = "Example: terrafill history import out/tables --store both.sqlite")]
    Import {
        /// Folder of exported tables
        csv: PathBuf,
        #[command(flatten)]
        store: StoreArguments,
    },
}

const BACKFILL_EXAMPLE: &str = "\
Exit codes: 0 all are stored · 2 bad input · 3 some commits failed, each is named · 4 all failed
Again, it goes on where it was stopped. Run it in the repository that has the commits.
Example: terrafill history backfill v1.0..main -- california --quick --size 256";

#[derive(Debug, Args)]
pub(crate) struct BackfillArguments {
    /// Commits after FROM up to and with TO, as git names them
    #[arg(value_name = "FROM..TO")]
    pub(crate) range: String,
    #[command(flatten)]
    pub(crate) store: StoreArguments,
    /// Only runs of this machine count as stored [default: any]
    #[arg(long)]
    pub(crate) machine: Option<i64>,
    /// Print the commands and do nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Folder for the runs, one by commit
    #[arg(long, value_name = "DIR", default_value = "out/backfill")]
    pub(crate) runs: PathBuf,
    /// Folder that keeps built revisions
    #[arg(long, value_name = "DIR", default_value = "target/gate")]
    pub(crate) cache: PathBuf,
    /// Scenes and options of bench, after --
    #[arg(last = true, value_name = "BENCH")]
    pub(crate) bench: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct BisectArguments {
    /// Case, as `history changes` names it
    pub(crate) case: String,
    #[command(flatten)]
    pub(crate) store: StoreArguments,
    /// Figure to look at; may be repeated [default: exact ones and main times]
    #[arg(long)]
    pub(crate) metric: Vec<String>,
    /// Machine by its number in the list [default: any]
    #[arg(long)]
    pub(crate) machine: Option<i64>,
    /// Repository that has both commits
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub(crate) repository: PathBuf,
}
