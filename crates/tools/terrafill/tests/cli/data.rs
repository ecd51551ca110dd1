// SPDX-License-Identifier: MIT OR Apache-2.0
//! `data`: sets are listed, and got from a server of this machine that stands for their sources.

use crate::harness::{Desk, Ran, has_device, ran};
use std::path::Path;
use terrafill_fixtures::data;
use terrafill_fixtures::loopback::{Answer, Loopback};

/// The set that most tests get, its place and its size.
const SET: &str = "natural-earth-110m-countries";
const FILE: &str = "sources/ne_110m_admin_0_countries.json";
const BYTES: usize = 725_717;

/// The end of its address.
const ADDRESS: &str = "/110m/cultural/ne_110m_admin_0_countries.json";

fn get(desk: &Desk, server: &Loopback, more: &[&str]) -> Ran {
    let base = server.base();
    desk.run(&[&["data", "get"][..], more, &["--from", &base]].concat())
}

/// Every file under a folder, by its path in it.
fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let Ok(entries) = std::fs::read_dir(folder) else {
        return found;
    };
    for entry in entries {
        let path = entry.expect("an entry").path();
        let name = path
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        if path.is_dir() {
            found.extend(files(&path).iter().map(|file| format!("{name}/{file}")));
        } else {
            found.push(name);
        }
    }
    found.sort();
    found
}

#[test]
fn sets_are_listed_with_licence_source_size_and_readers() {
    let desk = Desk::new();
    let text = desk.run(&["data", "list"]).succeeded();
    for phrase in [
        "data folder: data\n",
        "natural-earth-110m-countries (or natural-earth-110m)\n",
        "    public domain\n",
        "    https://raw.githubusercontent.com/d3/d3-geo/",
        "    vectors/us_states_10m.geojson · 180,766 bytes · not here\n",
        "    read by countries-110m, blue-marble, terrain/countries-over-etopo\n",
        "Cannot be got yet:\n",
        "terrain/N27E086.hgt · not here\n",
    ] {
        assert!(text.contains(phrase), "{phrase:?} is not in {text}");
    }
    desk.write(&format!("data/{FILE}"), "other");
    let json = desk.run(&["data", "list", "--json"]).succeeded();
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let set = &json["sets"][0];
    assert_eq!(
        (&set["name"], &set["file"]["bytes"]),
        (&SET.into(), &BYTES.into())
    );
    assert_eq!(set["file"]["state"], "different");
    assert_eq!(json["sets"].as_array().map(Vec::len), Some(12));
    assert_eq!(json["missing"].as_array().map(Vec::len), Some(10));
}

#[test]
fn names_and_mirrors_that_mean_nothing_are_refused() {
    let desk = Desk::new();
    let refused = |words: &[&str], phrases: &[&str]| {
        desk.run(&[&["data", "get"][..], words].concat())
            .refused(&[phrases]);
    };
    refused(
        &["moon"],
        &["data set: found \"moon\", allowed: natural-earth-110m-countries, "],
    );
    refused(
        &["srtm"],
        &[
            "found \"srtm\", which begins several names",
            "srtm-alps, srtm-aconcagua",
        ],
    );
    refused(
        &[SET, "--from", "ftp://h"],
        &["--from: found \"ftp://h\", allowed: http://HOST or https://HOST"],
    );
    let both = desk.run(&["data", "get", "moon", "mars"]);
    both.refused(&[&["\"moon\""], &["\"mars\""]]);
    assert_eq!(desk.names(), [""; 0]);
}

#[test]
fn altered_missing_and_broken_transfers_end_with_2_and_leave_no_data() {
    let altered = Loopback::start(|_| Answer::File(vec![b' '; BYTES]));
    let desk = Desk::new();
    let refused = get(&desk, &altered, &["natural-earth-110m"]);
    assert_eq!((refused.code, refused.stderr.lines().count()), (2, 1));
    for phrase in [
        "error: natural-earth-110m-countries: http://127.0.0.1:",
        ADDRESS,
        "found sha256 ",
        "expected sha256 a2faba6d84aeb04246240ee301c5e94a1a32b0e294a2c97094262fd0a6ae3c16",
    ] {
        assert!(refused.stderr.contains(phrase), "{}", refused.stderr);
    }
    let announced = "natural-earth-110m-countries: 725,717 bytes from http://127.0.0.1:";
    assert!(refused.stdout.starts_with(announced), "{}", refused.stdout);
    let total = "to fetch 725,717 bytes, to write 725,717 bytes into data\n";
    assert!(refused.stdout.ends_with(total), "{}", refused.stdout);
    assert_eq!(files(&desk.path("data")), [""; 0]);

    let missing = Loopback::start(|_| Answer::Status(404));
    let refused = get(&desk, &missing, &[SET, "blue-marble"]);
    let lines: Vec<&str> = refused.stderr.lines().collect();
    assert_eq!((refused.code, lines.len()), (2, 2), "{}", refused.stderr);
    for (line, name) in lines.iter().zip([SET, "blue-marble"]) {
        assert!(
            line.starts_with(&format!("error: {name}: http://")),
            "{line}"
        );
        assert!(
            line.contains("cannot be fetched: curl: ") && line.contains("404"),
            "{line}"
        );
    }
    assert_eq!(files(&desk.path("data")), [""; 0]);

    let mut first = true;
    let broken = Loopback::start(move |_| {
        if std::mem::take(&mut first) {
            Answer::ClosesAfter(vec![b' '; BYTES], 1_000)
        } else {
            Answer::Status(503)
        }
    });
    let refused = get(&desk, &broken, &[SET]);
    assert!(
        refused.stderr.contains("holds 1000 of 725717 bytes"),
        "{}",
        refused.stderr
    );
    assert_eq!(files(&desk.path("data")), [format!("{FILE}.part")]);
    let listed = desk.run(&["data", "list"]).succeeded();
    assert!(
        listed.contains("725,717 bytes · begun, 1,000 bytes are here\n"),
        "{listed}"
    );
    // No scene takes that for its data.
    let scenes = desk.run(&["scenes"]).succeeded();
    assert!(scenes.contains("countries-110m\n    skipped: "), "{scenes}");
}

#[test]
fn without_curl_the_message_says_what_to_do() {
    let desk = Desk::new();
    let words = ["data", "get", "blue-marble"];
    let refused = ran(desk.command(&words).env("PATH", desk.path("nothing")));
    assert_eq!(refused.code, 2, "{}", refused.stderr);
    for phrase in [
        "error: blue-marble: curl cannot be started (",
        "install it, or put https://raw.githubusercontent.com/vasturiano/",
        "into data/textures/color_blue_marble_4096.jpg (1461877 bytes, sha256 228deba2",
    ] {
        assert!(refused.stderr.contains(phrase), "{}", refused.stderr);
    }
    assert_eq!(files(&desk.path("data")), [""; 0]);
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let desk = Desk::new();
    desk.write("file", "");
    let server = Loopback::start(|_| Answer::Status(404));
    let refused = get(&desk, &server, &[SET, "--to", "file/data"]);
    assert_eq!(refused.code, 2);
    assert!(
        refused
            .stderr
            .contains("file/data/sources/ne_110m_admin_0_countries.json: cannot be "),
        "{}",
        refused.stderr
    );
    assert!(server.asked().is_empty());
}

/// The published files of the data folder, served under their addresses.
fn sources() -> Loopback {
    let served = [
        (ADDRESS, FILE),
        ("/test/data/us-10m.json", "sources/us-10m.json"),
    ]
    .map(|(address, file)| (address, data::bytes(file)));
    Loopback::start(move |asked| {
        let found = served
            .iter()
            .find(|(address, _)| asked.path.ends_with(address));
        found.map_or(Answer::Status(404), |(_, bytes)| {
            Answer::File(bytes.clone())
        })
    })
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn what_the_readme_says_gives_the_pictures_of_the_trimmed_file() {
    let server = sources();
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../README.md");
    let readme = std::fs::read_to_string(readme).expect("README.md");
    let line = "terrafill data get natural-earth-110m && terrafill bench countries-110m --quick";
    assert!(readme.contains(line), "README.md has another line");

    let desk = Desk::new();
    let got = get(&desk, &server, &["natural-earth-110m"]).succeeded();
    let path = format!("natural-earth-110m-countries: data/{FILE}\n");
    assert!(got.contains(&path), "{got}");
    assert!(
        got.ends_with("scenes that have all their data: countries-110m\n"),
        "{got}"
    );
    assert_eq!(files(&desk.path("data")), [FILE]);
    let again = get(&desk, &server, &["natural-earth-110m"]).succeeded();
    assert!(
        again.contains("nothing to fetch\nto fetch 0 bytes, to write 0 bytes"),
        "{again}"
    );
    assert_eq!(server.asked().len(), 1);
    let scenes = desk.run(&["scenes"]).succeeded();
    assert!(scenes.contains("177 regions, 10367 vertices"), "{scenes}");

    let trimmed = data::file("vectors/ne_110m_admin_0_countries.geojson");
    if !has_device() {
        return;
    }
    let data = trimmed.ancestors().nth(2).expect("a folder");
    let data = data.to_str().expect("UTF-8");
    let bench = ["bench", "countries-110m", "--quick", "--size", "96"];
    let options = ["--samples", "1", "--technique", "vertex", "--out"];
    let bench = [&bench[..], &options].concat();
    // Without --data: in the folder that `data get` filled.
    desk.run(&[&bench[..], &["source"]].concat()).succeeded();
    desk.run(&[&bench[..], &["trimmed", "--data", data]].concat())
        .succeeded();
    let hashes = |run: &str| {
        let notes = desk.read_text(&format!("{run}/notes.csv"));
        let is_hash = |line: &&str| line.contains("_hash,");
        notes
            .lines()
            .filter(is_hash)
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let (source, trimmed) = (hashes("source"), hashes("trimmed"));
    assert!(source.len() >= 6, "{source:?}");
    assert_eq!(source, trimmed);
}

#[test]
#[ignore = "needs data: us-10m"]
fn states_and_counties_are_made_into_another_folder() {
    let server = sources();
    let desk = Desk::new();
    let got = get(&desk, &server, &["us-10m", "--to", "there"]).succeeded();
    for phrase in [
        "to fetch 656,701 bytes, to write 1,990,043 bytes into there\n",
        "scenes that have all their data: us-states\n",
        "other verbs find it by --data there, or TERRAFILL_DATA=there\n",
    ] {
        assert!(got.contains(phrase), "{phrase:?} is not in {got}");
    }
    let made = [
        "sources/us-10m.json",
        "vectors/us_counties_10m.geojson",
        "vectors/us_states_10m.geojson",
    ];
    assert_eq!(files(&desk.path("there")), made);
    let scenes = desk.run(&["scenes", "--data", "there"]).succeeded();
    assert!(scenes.contains("53 regions, 7407 vertices"), "{scenes}");
}
