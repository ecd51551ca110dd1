// SPDX-License-Identifier: MIT OR Apache-2.0
//! A made-up data set, fetched from a server of this machine: right, broken off, altered, missing.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use tempfile::TempDir;
use terrafill_data::{Catalogue, DataError, Plan};
use terrafill_fixtures::loopback::{Answer, Loopback};
use terrafill_scene::sha256_hex;

/// Bytes of the set: more than one packet, and no part like another.
fn bytes() -> Vec<u8> {
    (0..300_000_u32)
        .flat_map(|i| (i.wrapping_mul(2_654_435_761)).to_le_bytes())
        .collect()
}

/// A catalogue of one set, and a folder for it.
struct Desk {
    catalogue: Catalogue,
    folder: TempDir,
}

impl Desk {
    fn new() -> Self {
        Self::of(&bytes(), "")
    }

    fn of(bytes: &[u8], more: &str) -> Self {
        let text = format!(
            "[[sets]]\nname = \"numbers\"\nwhat = \"for a test\"\nlicence = \"ours\"\n\
             url = \"https://host.example/at/numbers.bin\"\nbytes = {}\nsha256 = \"{}\"\n\
             file = \"sources/numbers.bin\"\n{more}",
            bytes.len(),
            sha256_hex(bytes)
        );
        Self {
            catalogue: Catalogue::from_toml(&text, "c.toml").expect("a catalogue"),
            folder: tempfile::tempdir().expect("a folder"),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
        std::fs::write(path, bytes).expect("writable");
    }

    fn get_into(&self, folder: &Path, server: &Loopback) -> Result<u64, DataError> {
        let mirror = server.base().parse().expect("a mirror");
        let plan = Plan::new(&self.catalogue.sets[0], folder, Some(&mirror))?;
        let mut arrived = 0;
        plan.carry_out(&mut |bytes| arrived = bytes)?;
        Ok(arrived)
    }

    fn get(&self, server: &Loopback) -> Result<u64, DataError> {
        self.get_into(self.folder.path(), server)
    }

    fn refused(&self, server: &Loopback) -> String {
        let error = self.get(server).expect_err("refused").to_string();
        assert!(!error.contains('\n'), "{error}");
        error
    }

    /// Names in `sources/`, sorted.
    fn names(&self) -> Vec<String> {
        let Ok(entries) = std::fs::read_dir(self.path("sources")) else {
            return Vec::new();
        };
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("an entry").file_name())
            .map(|name| name.to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    fn has_it(&self) -> bool {
        let found = std::fs::read(self.path("sources/numbers.bin"));
        self.names() == ["numbers.bin"] && found.is_ok_and(|found| found == bytes())
    }
}

/// First bytes that each request asked for.
fn froms(server: &Loopback) -> Vec<Option<u64>> {
    server.asked().iter().map(|asked| asked.from).collect()
}

#[test]
fn a_set_is_fetched_once_from_the_path_of_its_address() {
    let desk = Desk::new();
    let server = Loopback::start(|_| Answer::File(bytes()));
    let plan = Plan::new(&desk.catalogue.sets[0], desk.folder.path(), None).expect("nothing there");
    assert_eq!(plan.url(), "https://host.example/at/numbers.bin");
    assert_eq!(
        (plan.fetch_bytes(), plan.write_bytes()),
        (1_200_000, 1_200_000)
    );
    assert_eq!(desk.get(&server).expect("fetched"), 1_200_000);
    assert!(desk.has_it());
    assert_eq!(server.asked()[0].path, "/at/numbers.bin");
    // A second time nothing is left to do.
    let plan = Plan::new(&desk.catalogue.sets[0], desk.folder.path(), None).expect("it is there");
    assert_eq!((plan.fetch_bytes(), plan.write_bytes()), (0, 0));
    desk.get(&server).expect("there");
    assert_eq!(froms(&server), [None]);
}

#[test]
fn a_transfer_that_breaks_off_goes_on_where_it_ended() {
    let desk = Desk::new();
    let server = Loopback::start(|_| Answer::ClosesAfter(bytes(), 500_000));
    desk.get(&server).expect("in three parts");
    assert!(desk.has_it());
    assert_eq!(froms(&server), [None, Some(500_000), Some(1_000_000)]);
}

#[test]
fn a_later_call_goes_on_where_an_earlier_one_ended() {
    let desk = Desk::new();
    let count = AtomicUsize::new(0);
    let once = Loopback::start(move |_| match count.fetch_add(1, Ordering::SeqCst) {
        0 => Answer::ClosesAfter(bytes(), 500_000),
        _ => Answer::Status(503),
    });
    let error = desk.refused(&once);
    let part = desk.path("sources/numbers.bin.part");
    let kept = format!("{} holds 500000 of 1200000 bytes", part.display());
    assert!(error.contains("503") && error.contains(&kept), "{error}");
    assert_eq!(desk.names(), ["numbers.bin.part"]);
    let folder = desk.folder.path();
    let plan = Plan::new(&desk.catalogue.sets[0], folder, None).expect("begun");
    assert_eq!(plan.fetch_bytes(), 700_000);
    let server = Loopback::start(|_| Answer::File(bytes()));
    desk.get(&server).expect("the rest");
    assert!(desk.has_it());
    assert_eq!(froms(&server), [Some(500_000)]);
}

#[test]
fn a_server_that_always_closes_is_not_asked_for_ever() {
    let desk = Desk::new();
    let server = Loopback::start(|_| Answer::ClosesAfter(bytes(), 1_000));
    assert!(
        desk.refused(&server)
            .contains("holds 5000 of 1200000 bytes")
    );
    assert_eq!(server.asked().len(), 5);
    // Nor is one that closes at once.
    let desk = Desk::new();
    let server = Loopback::start(|_| Answer::ClosesAfter(bytes(), 0));
    assert!(!desk.refused(&server).contains("holds"));
    assert_eq!((server.asked().len(), desk.names()), (1, Vec::new()));
}

#[test]
fn a_server_without_parts_of_files_sends_the_whole_file_again() {
    let desk = Desk::new();
    desk.write("sources/numbers.bin.part", &bytes()[..9]);
    let server = Loopback::start(|_| Answer::WholeOnly(bytes()));
    desk.get(&server).expect("from nothing");
    assert!(desk.has_it());
    assert_eq!(froms(&server), [Some(9), None]);
}

#[test]
fn altered_bytes_are_named_by_both_hashes_and_nothing_stays() {
    let desk = Desk::new();
    let mut altered = bytes();
    altered[777] ^= 1;
    let hash = sha256_hex(&altered);
    let url = {
        let server = Loopback::start(move |_| Answer::File(altered.clone()));
        let error = desk.refused(&server);
        let url = format!("{}/at/numbers.bin", server.base());
        let expected = sha256_hex(&bytes());
        assert_eq!(
            error,
            format!("{url}: found sha256 {hash}, expected sha256 {expected}; nothing was kept")
        );
        url
    };
    assert!(url.starts_with("http://127.0.0.1:"), "{url}");
    assert_eq!(desk.names(), [""; 0]);
}

#[test]
fn a_file_of_another_size_is_refused_and_nothing_stays() {
    for (change, found) in [
        (-1, "found 1199999 bytes"),
        (1, "found more than 1200000 bytes"),
    ] {
        let desk = Desk::new();
        let mut other = bytes();
        other.resize(other.len().checked_add_signed(change).expect("a size"), 0);
        let server = Loopback::start(move |_| Answer::File(other.clone()));
        let error = desk.refused(&server);
        assert!(error.contains(found), "{error}");
        assert!(error.contains("expected 1200000 bytes"), "{error}");
        assert_eq!(desk.names(), [""; 0]);
    }
}

#[test]
fn a_part_of_another_file_is_thrown_away_and_the_set_fetched_anew() {
    for length in [9, 1_200_000, 1_200_001] {
        let desk = Desk::new();
        desk.write("sources/numbers.bin.part", &vec![7; length]);
        let server = Loopback::start(|_| Answer::File(bytes()));
        desk.get(&server).expect("anew");
        assert!(desk.has_it(), "{length}");
        assert_eq!(froms(&server).last(), Some(&None), "{length}");
    }
}

#[test]
fn a_file_that_is_not_published_any_more_is_a_status() {
    let desk = Desk::new();
    let server = Loopback::start(|_| Answer::Status(404));
    let error = desk.refused(&server);
    assert!(
        error.contains("/at/numbers.bin: cannot be fetched: curl: "),
        "{error}"
    );
    assert!(error.contains("404"), "{error}");
    assert_eq!(desk.names(), [""; 0]);
}

#[test]
fn another_file_under_the_name_is_left_alone() {
    let desk = Desk::new();
    desk.write("sources/numbers.bin", b"mine");
    let server = Loopback::start(|_| Answer::File(bytes()));
    let error = desk.refused(&server);
    let found = format!(
        "is there with sha256 {}, expected sha256 ",
        sha256_hex(b"mine")
    );
    assert!(
        error.contains(&found) && error.ends_with("move it away first"),
        "{error}"
    );
    assert_eq!(
        std::fs::read(desk.path("sources/numbers.bin")).expect("there"),
        b"mine"
    );
    assert_eq!(
        server.asked().len(),
        0,
        "it was refused before the transfer"
    );
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let desk = Desk::new();
    let server = Loopback::start(|_| Answer::File(bytes()));
    desk.write("file", b"");
    let places = ["file/folder", "/proc/terrafill"].map(|place| desk.path(place));
    for place in places {
        if place.starts_with("/proc") && !Path::new("/proc/self").exists() {
            continue;
        }
        let error = desk
            .get_into(&place, &server)
            .expect_err("refused")
            .to_string();
        assert!(error.starts_with(&place.display().to_string()), "{error}");
    }
    assert_eq!(server.asked().len(), 0);
}

#[test]
fn a_set_that_the_disk_has_no_room_for_is_refused_before_its_transfer() {
    let mut desk = Desk::new();
    let server = Loopback::start(|_| Answer::File(bytes()));
    let bytes = std::mem::replace(&mut desk.catalogue.sets[0].bytes, 1 << 60);
    let error = desk.refused(&server);
    let needed = "bytes free on its disk, needs 1152921504606846976 bytes; nothing was fetched";
    assert!(error.ends_with(needed), "{error}");
    assert_eq!((server.asked().len(), desk.names()), (0, Vec::new()));
    // Negative control: with room for it, it is fetched.
    desk.catalogue.sets[0].bytes = bytes;
    desk.get(&server).expect("fetched");
    assert!(desk.has_it());
}

#[cfg(unix)]
#[test]
fn a_disk_that_is_full_is_named() {
    if !Path::new("/dev/full").exists() {
        eprintln!("skipped: there is no /dev/full");
        return;
    }
    let desk = Desk::new();
    let server = Loopback::start(|_| Answer::File(bytes()));
    std::fs::create_dir(desk.path("sources")).expect("writable");
    let part = desk.path("sources/numbers.bin.part");
    std::os::unix::fs::symlink("/dev/full", &part).expect("writable");
    let error = desk.refused(&server);
    let expected = format!("{}: cannot be written: ", part.display());
    assert!(error.starts_with(&expected), "{error}");
    assert_eq!(desk.names(), [""; 0]);
    // Negative control: with room it is fetched.
    desk.get(&server).expect("fetched");
    assert!(desk.has_it());
}

#[cfg(unix)]
#[test]
fn a_folder_that_may_not_be_written_is_named() {
    use std::os::unix::fs::PermissionsExt as _;
    let desk = Desk::new();
    let sources = desk.path("sources");
    std::fs::create_dir(&sources).expect("writable");
    let allow = |mode| {
        std::fs::set_permissions(&sources, std::fs::Permissions::from_mode(mode)).expect("ours");
    };
    allow(0o555);
    if std::fs::write(sources.join("probe"), b"").is_ok() {
        eprintln!("skipped: this user may write into folders that nobody may write into");
        return;
    }
    let server = Loopback::start(|_| Answer::File(bytes()));
    let error = desk.refused(&server);
    allow(0o755);
    assert!(
        error.contains("numbers.bin.part: cannot be written: "),
        "{error}"
    );
    assert_eq!((server.asked().len(), desk.names()), (0, Vec::new()));
}

/// A topology of one triangle in California.
const TOPOLOGY: &str = r#"{"type":"Topology","transform":{"scale":[1,1],"translate":[-120,35]},
    "arcs":[[[0,0],[1,0],[0,1],[-1,-1]]],
    "objects":{"states":{"type":"GeometryCollection","geometries":[
        {"type":"Polygon","id":6,"arcs":[[0]]}]}}}"#;

/// What is made of it.
const STATES: &str = "{\"type\":\"FeatureCollection\",\"features\":[\n\
    {\"type\":\"Feature\",\"properties\":{\"id\":\"06\",\"name\":\"California\"},\
    \"geometry\":{\"type\":\"Polygon\",\"coordinates\":\
    [[[-120.0,35.0],[-119.0,35.0],[-119.0,36.0],[-120.0,35.0]]]}}\n]}\n";

fn topology(made: &str) -> Desk {
    let more = format!(
        "[[sets.made]]\nby = \"us-states\"\nbytes = {}\nsha256 = \"{}\"\nfile = \"v/states.geojson\"\n",
        made.len(),
        sha256_hex(made.as_bytes())
    );
    Desk::of(TOPOLOGY.as_bytes(), &more)
}

#[test]
fn what_is_made_of_a_set_is_made_with_it_and_again_where_it_was_lost() {
    let desk = topology(STATES);
    let server = Loopback::start(|_| Answer::File(TOPOLOGY.as_bytes().to_vec()));
    desk.get(&server).expect("made");
    let read = || std::fs::read_to_string(desk.path("v/states.geojson"));
    assert_eq!(read().expect("made"), STATES);
    std::fs::remove_file(desk.path("v/states.geojson")).expect("ours");
    let folder = desk.folder.path();
    let plan = Plan::new(&desk.catalogue.sets[0], folder, None).expect("half of it is there");
    let made = STATES.len() as u64;
    assert_eq!((plan.fetch_bytes(), plan.write_bytes()), (0, made));
    desk.get(&server).expect("made again");
    assert_eq!(read().expect("made"), STATES);
    assert_eq!(server.asked().len(), 1, "nothing was fetched again");
    // Negative controls: what is made otherwise than the catalogue says, and what cannot be made, are not written.
    let desk = topology(&STATES.replace("35.0", "35"));
    let error = desk.refused(&server);
    let found = format!(
        "made with sha256 {}, expected",
        sha256_hex(STATES.as_bytes())
    );
    assert!(error.contains(&found), "{error}");
    assert!(!desk.path("v/states.geojson").exists());
    let other = TOPOLOGY.replace("states", "counties");
    let more = "[[sets.made]]\nby = \"us-states\"\nbytes = 1\nfile = \"v/states.geojson\"\n";
    let more = format!("{more}sha256 = \"{}\"\n", "0".repeat(64));
    let desk = Desk::of(other.as_bytes(), &more);
    let served: Arc<str> = other.into();
    let server = Loopback::start(move |_| Answer::File(served.as_bytes().to_vec()));
    let error = desk.refused(&server);
    let expected = "cannot be converted by us-states: objects: found counties, expected states";
    assert!(error.contains(expected), "{error}");
    assert!(!desk.path("v").exists());
}
