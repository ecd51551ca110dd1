// SPDX-License-Identifier: MIT OR Apache-2.0
//! Data sets that scenes need: where each is published, and how it gets into the data folder.
//!
//! The catalogue pins an address, a size and a SHA-256 for each set. A transfer goes into a file
//! `NAME.part` beside its place, is resumed there, and gets its name once size and hash are right. One that
//! the disk has no room for is refused before it begins.
//!
//! Transfers are `curl`'s, a child process. `ureq` 3, the smallest client with TLS that was weighed,
//! would bring rustls, ring and its C code into every build. It also brings `webpki-roots`, whose
//! licence `deny.toml` does not allow. `curl` costs no build time, and finds the system's proxies and
//! certificates by itself.

mod catalogue;
mod curl;
mod error;
mod fetch;
mod listing;
mod make;
mod part;
mod room;
mod state;
mod topojson;

pub use catalogue::{Catalogue, CatalogueError, DataSet, MadeFile, MissingFile, UnknownSet};
pub use error::DataError;
pub use fetch::{Mirror, Plan, WrongMirror};
pub use listing::{ListedFile, ListedMissing, ListedSet, Listing, grouped, ready_scenes};
pub use state::{FileState, PinnedFile};
pub use topojson::TopologyError;
