// SPDX-License-Identifier: MIT OR Apache-2.0
//! Help, version, exit codes, wrong arguments, and what there is.

use crate::harness::{Desk, collection, has_device, polygon, rectangle, techniques};

fn verbs(help: &str) -> Vec<String> {
    help.lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.split_whitespace().next())
        .filter(|verb| *verb != "help")
        .map(str::to_owned)
        .collect()
}

fn check_help(text: &str, example: &str) -> Result<(), String> {
    let (lines, columns) = (
        text.lines().count(),
        text.lines().map(|line| line.chars().count()).max(),
    );
    if lines > 40 || columns > Some(100) {
        return Err(format!("{lines} lines of up to {columns:?} columns"));
    }
    if !text.contains(&format!("Example: {example}")) {
        return Err(format!("no example of {example}"));
    }
    Ok(())
}

#[test]
fn help_of_every_verb_fits_a_screen_and_shows_an_example() {
    let desk = Desk::new();
    let help = desk.run(&["--help"]).succeeded();
    assert_eq!(check_help(&help, "terrafill "), Ok(()));
    let verbs = verbs(&help);
    for verb in [
        "bench",
        "report",
        "merge",
        "gate",
        "bless",
        "compare",
        "history",
        "render",
        "mesh",
        "locate",
        "scenes",
        "studies",
        "techniques",
        "devices",
    ] {
        assert!(verbs.iter().any(|found| found == verb), "{verb}: {verbs:?}");
    }
    for verb in &verbs {
        let text = desk.run(&[verb, "--help"]).succeeded();
        let example = format!("terrafill {verb}");
        assert_eq!(check_help(&text, &example), Ok(()), "{text}");
        assert_eq!(desk.run(&["help", verb]).succeeded(), text);
        for inner in self::verbs(&text) {
            let text = desk.run(&[verb, &inner, "--help"]).succeeded();
            let example = format!("terrafill {verb} {inner}");
            assert_eq!(check_help(&text, &example), Ok(()), "{text}");
        }
    }
}

#[test]
fn help_that_is_too_long_too_wide_or_without_example_is_noticed() {
    let good = "Usage\n\nExample: terrafill mesh f\n";
    assert_eq!(check_help(good, "terrafill mesh"), Ok(()));
    assert!(check_help(&"\n".repeat(41), "").is_err());
    let wide = format!("{good}{}", "ü".repeat(101));
    assert!(check_help(&wide, "terrafill mesh").is_err());
    assert!(check_help(good, "terrafill render").is_err());
}

#[test]
fn exit_codes_are_listed_and_the_version_is_the_packages() {
    let desk = Desk::new();
    let help = desk.run(&["--help"]).succeeded();
    for (code, word) in [
        (0, "done"),
        (1, "a picture is wrong"),
        (2, "bad input or usage"),
        (3, "inconclusive"),
        (4, "nothing measured"),
        (5, "no usable device"),
    ] {
        assert!(help.contains(&format!("{code} {word}")), "{help}");
    }
    let short = concat!("terrafill ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(desk.run(&["-V"]).succeeded(), short);
    let long = desk.run(&["--version"]).succeeded();
    let lines: Vec<&str> = long.lines().collect();
    let [number, commit, build] = lines[..] else {
        panic!("{long}");
    };
    assert_eq!(number, short.trim_end());
    let known = ["unknown, built outside git", env!("TERRAFILL_COMMIT")];
    let known = known[usize::from(!known[1].is_empty())];
    assert_eq!(commit, format!("commit {known}"));
    for words in [" build, features ", ", wgpu ", ", ash "] {
        assert!(build.contains(words), "{build}");
    }
}

#[test]
fn errors_of_every_kind_have_one_colour_where_colours_are_asked_for() {
    let desk = Desk::new();
    let stderr = |line: &str, colour: &str| {
        let words: Vec<&str> = line.split(' ').chain(["--color", colour]).collect();
        let output = desk.command(&words).env("NO_COLOR", "1").output();
        let output = output.expect("the program starts");
        assert_eq!(output.status.code(), Some(2), "{line}");
        String::from_utf8(output.stderr).expect("UTF-8")
    };
    // The program's own, one about a value, and clap's.
    for line in ["mesh none.geojson", "mesh f --edges x", "mesh f --fly"] {
        let coloured = stderr(line, "always");
        assert!(
            coloured.starts_with("\u{1b}[1m\u{1b}[31merror:\u{1b}[0m "),
            "{coloured:?}"
        );
        // Negative controls: an error that is written to a pipe, and where none is wanted.
        for colour in ["auto", "never"] {
            let plain = stderr(line, colour);
            assert!(
                plain.starts_with("error: ") && !plain.contains('\u{1b}'),
                "{plain:?}"
            );
        }
    }
    desk.run(&["mesh", "f", "--color", "blue"])
        .refused(&[&["--color: found \"blue\", allowed: auto, always, never"]]);
}

#[test]
fn a_wrong_value_gets_one_line_with_what_is_allowed() {
    let desk = Desk::new();
    let cases: [(&[&str], &str); 17] = [
        (
            &["mesh", "f", "--edges", "rhumb"],
            "--edges: found \"rhumb\", allowed: planar, great-ellipse",
        ),
        (
            &["locate", "f", "--points", "p", "--edges", "x"],
            "--edges: found \"x\", allowed: planar, great-ellipse",
        ),
        (
            &["mesh", "f", "--repair", "nonzero"],
            "--repair: found \"nonzero\", allowed: even-odd, union, keep-shells",
        ),
        (
            &["mesh", "f", "--body", "pluto"],
            "--body: found \"pluto\", allowed: wgs84, moon, mars",
        ),
        (
            &["mesh", "f", "--boundary-tolerance-m", "wide"],
            "--boundary-tolerance-m: found \"wide\", allowed: a number",
        ),
        (
            &["mesh", "f", "--boundary-tolerance-m", "0"],
            "--boundary-tolerance-m: found 0, allowed: above 0",
        ),
        (
            &["mesh", "f", "--boundary-tolerance-m", "inf"],
            "--boundary-tolerance-m: found inf, allowed: above 0 and finite",
        ),
        (
            &["mesh", "f", "--cap-step-deg", "NaN"],
            "--cap-step-deg: found NaN, allowed: 0.01 … 30",
        ),
        (
            &["bench", "--size", "0x4"],
            "--size: found \"0x4\", allowed: 1 … 16384 pixels",
        ),
        (
            &["bench", "--frames", "0"],
            "--samples: found \"0\", allowed: 1 … 100000",
        ),
        (
            &["bench", "--processes", "0"],
            "--processes: found \"0\", allowed: 1 … 1000",
        ),
        (
            &["bench", "--shard", "1/2", "--shard-by", "duration:"],
            "--shard-by: found \"duration:\", allowed: turns, hash or duration:RUN",
        ),
        (
            &["bench", "--shard", "3/2"],
            "--shard: found \"3/2\", allowed: M/N with 1 ≤ M ≤ N",
        ),
        (
            &["bench", "--max-mb", "0"],
            "--max-mb: found \"0\", allowed: a number above 0, or none",
        ),
        (
            &["report", "run", "--tolerance-px", "inf"],
            "--tolerance-px: found \"inf\", allowed: 0 or more pixels",
        ),
        (
            &["bench", "--backend", "metal"],
            "technique \"metal\", allowed: vertex, compute,",
        ),
        (
            &[
                "render",
                "california",
                "--view",
                "v",
                "--out",
                "o",
                "--technique",
                "x",
            ],
            "--technique: found \"x\", allowed: vertex, compute,",
        ),
    ];
    for (arguments, line) in cases {
        desk.run(arguments).refused(&[&[line]]);
    }
    assert_eq!(desk.names(), [""; 0], "nothing was written");
}

#[test]
fn what_is_misspelt_gets_the_name_that_was_meant() {
    let desk = Desk::new();
    let render = "render california --out a.png --size 8 --view";
    let cases: [(&str, &str); 12] = [
        ("bench californiax", "california"),
        ("bench --study fillingx", "filling"),
        ("bench --suite extremex", "extreme"),
        ("bench california --technique instancedx", "instanced"),
        ("bench california --ablation californiax", "california"),
        ("data get blue-marblex", "blue-marble"),
        ("mesh f --edges planarx", "planar"),
        ("bench everestx", "terrain/everest"),
        (&format!("{render} globex"), "globe"),
        (
            &format!("{render} globe --technique instancedx"),
            "instanced",
        ),
        (&format!("{render} globe --set layoutx=pulled"), "layout"),
        (&format!("{render} globe --set layout=pulledx"), "pulled"),
    ];
    for (line, meant) in cases {
        let line: Vec<&str> = line.split(' ').collect();
        let meant = format!("; did you mean {meant:?}?");
        desk.run(&line).refused(&[&["allowed: ", &meant]]);
    }
    // Negative control: what is like nothing. Of many names the first are listed.
    let ran = desk.run(&["bench", "atlantis"]);
    ran.refused(&[&["allowed: planet-134, california, ", " … and "]]);
    assert!(!ran.stderr.contains("did you mean"), "{}", ran.stderr);
    assert_eq!(desk.names(), [""; 0], "nothing was written");
}

#[test]
fn usage_errors_end_with_2_and_say_what_is_missing() {
    let desk = Desk::new();
    let cases: [(&[&str], &str); 5] = [
        (&[], "Usage: terrafill"),
        (&["fly"], "unrecognized subcommand 'fly'"),
        (&["mesh"], "<REGIONS>"),
        (&["locate", "f"], "--points <POINTS>"),
        (&["report", "a", "b"], "unexpected argument 'b'"),
    ];
    for (arguments, phrase) in cases {
        let ran = desk.run(arguments);
        assert_eq!((ran.code, ran.stdout.as_str()), (2, ""), "{arguments:?}");
        assert!(ran.stderr.contains(phrase), "{}", ran.stderr);
    }
}

#[test]
fn scenes_says_what_there_is_and_what_the_rest_needs() {
    let desk = Desk::new();
    let text = desk.run(&["scenes"]).succeeded();
    for phrase in [
        "planet-134\n",
        "134 regions",
        "california\n",
        "square-10m\n",
        "square-200km\n",
        "views globe, top-down, horizon",
        "countries-110m\n    skipped: no data folder is given (TERRAFILL_DATA is not set, and there is no folder \
         data)\n",
        "needs vectors/ne_110m_admin_0_countries.geojson\n",
        "terrain/everest\n    skipped: ",
        "extreme/poles\n",
        "extreme/nan-coordinates\n    not available: ",
    ] {
        assert!(text.contains(phrase), "{phrase:?} is not in {text}");
    }
    // An empty folder is a folder: other words.
    desk.write("data/readme", "");
    let text = desk.run(&["scenes", "--data", "data"]).succeeded();
    assert!(text.contains("is not there"), "{text}");
    let json = desk.run(&["scenes", "--json"]).succeeded();
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let scenes = json["scenes"].as_array().expect("a list");
    let named = |name: &str| {
        let found = scenes.iter().find(|scene| scene["name"] == name);
        found.unwrap_or_else(|| panic!("no {name} in {json}"))
    };
    let planet = named("planet-134");
    assert_eq!(
        (&planet["available"], &planet["regions"]),
        (&true.into(), &134.into())
    );
    let views = serde_json::json!(["globe", "top-down", "horizon"]);
    assert_eq!(
        (&planet["views"], &planet["edges"]),
        (&views, &"planar".into())
    );
    let countries = named("countries-110m");
    assert_eq!(countries["available"], false);
    let needs = "vectors/ne_110m_admin_0_countries.geojson";
    assert_eq!(countries["needs"], needs);
    assert!(
        countries["reason"]
            .as_str()
            .is_some_and(|reason| !reason.is_empty())
    );
    assert!(!text.contains("TERRAFILL_DATA is not set"), "{text}");
}

#[test]
fn studies_says_what_each_asks_and_measures() {
    let desk = Desk::new();
    let text = desk.run(&["studies"]).succeeded();
    let json = desk.run(&["studies", "--json"]).succeeded();
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let studies = json["studies"].as_array().expect("a list");
    let names = studies.iter().map(|study| study["name"].as_str());
    let names: Vec<Option<&str>> = names.collect();
    // More may follow.
    assert_eq!(names[..3], ["filling", "precision", "growth"].map(Some));
    for study in studies {
        let word = |key: &str| study[key].as_str().expect("a text");
        let metrics = study["metrics"].as_array().expect("a list");
        let lines = format!(
            "{}\n    {}\n    {} metrics\n",
            word("name"),
            word("question"),
            metrics.len()
        );
        assert!(text.contains(&lines), "{lines:?} is not in {text}");
        assert!(word("question").ends_with('?'));
        for metric in metrics {
            for key in ["name", "unit", "kind", "better", "meaning"] {
                assert!(metric[key].is_string(), "{key}: {metric}");
            }
        }
    }
}

#[test]
fn devices_says_what_runs_and_ends_with_5_where_no_device_does() {
    let desk = Desk::new();
    let ran = desk.run_without_device(&["devices"]);
    assert_eq!(ran.code, 5, "{}", ran.stdout);
    assert!(ran.stdout.contains("reference  runs"), "{}", ran.stdout);
    let json = desk.run_without_device(&["devices", "--json"]);
    assert_eq!(
        (json.code, json.stdout.as_str()),
        (5, "{\n  \"devices\": []\n}\n")
    );
    for backend in &techniques() {
        let runs = format!("{backend:<10} runs");
        assert!(!ran.stdout.contains(&runs), "{}", ran.stdout);
        let needs = ran.stderr.contains("no Vulkan device") && ran.stderr.contains(backend);
        assert!(needs, "{}", ran.stderr);
    }
    if has_device() {
        let text = desk.run(&["devices"]).succeeded();
        assert!(text.contains("reference  runs"), "{text}");
        assert!(text.contains("vertex     runs"), "{text}");
        assert!(text.contains("compute    runs"), "{text}");
        assert!(text.contains("driver     "), "{text}");
        let json = desk.run(&["devices", "--json"]).succeeded();
        let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        let device = &json["devices"][0];
        let name = device["name"].as_str().expect("a name");
        assert!(text.contains(&format!(
            "{name} ({})",
            device["type"].as_str().expect("a type")
        )));
        let listed = device["techniques"].as_array().expect("a list");
        let names: Vec<&str> = listed
            .iter()
            .filter_map(|one| one["name"].as_str())
            .collect();
        assert_eq!(names, techniques());
        assert!(
            listed.iter().any(|technique| technique["runs"] == true),
            "{json}"
        );
        // Of every feature that only some devices have it says that it is there or that it lacks.
        let native = text.split_once("native     ").expect("native").1;
        let native = native.split_once("flat-mesh ").expect("the next one").0;
        for feature in [
            "geometry shaders",
            "GPU timestamps",
            "pipeline statistics",
            "depth bounds",
        ] {
            assert_eq!(native.matches(feature).count(), 1, "{feature}: {text}");
        }
    }
}

#[test]
fn without_a_device_what_needs_one_ends_with_5_and_writes_nothing() {
    let desk = Desk::new();
    let render = ["render", "california", "--view", "globe", "--out", "a.png"];
    let by = |backend| [&render[..], &["--technique", backend]].concat();
    let bench = ["bench", "california", "--quick", "--out", "run"];
    for arguments in [&bench[..], &render, &by("compute"), &by("native")] {
        let ran = desk.run_without_device(arguments);
        assert_eq!((ran.code, ran.stdout.as_str()), (5, ""), "{}", ran.stderr);
        assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
    }
    assert_eq!(desk.names(), [""; 0], "nothing was written");
    // The rest of the program needs none.
    desk.write("r.geojson", polygon(&rectangle(0.0, 0.0, 1.0, 1.0)));
    assert_eq!(desk.run_without_device(&["mesh", "r.geojson"]).code, 0);
}

#[test]
fn a_reader_that_closes_the_pipe_is_no_error() {
    let desk = Desk::new();
    let square = polygon(&rectangle(0.0, 0.0, 1.0, 1.0));
    let many: Vec<(&str, String)> = (0..3_000).map(|_| ("square", square.clone())).collect();
    desk.write("r.geojson", collection(&many));
    let mut child = desk
        .command(&["mesh", "r.geojson", "--json"])
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), &*stderr), (Some(0), ""));
}
