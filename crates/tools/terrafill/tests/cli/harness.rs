// SPDX-License-Identifier: MIT OR Apache-2.0
//! A folder of its own for each test, the program run in it, and what every run must satisfy.

use sha2::{Digest as _, Sha256};
use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// What a quick run says first; the counts stand behind it.
pub(crate) const QUICK: &str = "a quick run takes one process and decides nothing\n";

/// Techniques that tests count cases of, named so that a new one changes no count.
pub(crate) const NAMED: [&str; 6] = [
    "--technique",
    "vertex",
    "--technique",
    "compute",
    "--technique",
    "native",
];

/// Begins the rest of a line on standard error that was too long.
const INDENT: &str = "    ";

/// What a run of the program came to.
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// A folder that the program runs in, so that messages and outputs have short names.
pub(crate) struct Desk {
    folder: TempDir,
}

impl Desk {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        Self { folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, content).expect("writable");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn read_text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("UTF-8")
    }

    /// Names in the folder, sorted: what a run left behind.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("a folder");
        let mut names: Vec<String> = entries
            .map(|entry| {
                let name = entry.expect("an entry").file_name();
                name.to_string_lossy().into_owned()
            })
            .collect();
        names.sort();
        names
    }

    /// The program, in this folder, without real data, its output in pipes.
    ///
    /// Without the validation layer, which takes a third of a short run: tests of the crates that draw run under it,
    /// and so do the commands of the README.
    pub(crate) fn command<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_terrafill"));
        command
            .args(arguments)
            .current_dir(self.folder.path())
            .env_remove("TERRAFILL_DATA")
            .env_remove("TERRAFILL_VALIDATION")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    pub(crate) fn run<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Ran {
        ran(&mut self.command(arguments))
    }

    /// As [`Desk::run`], with `input` on standard input.
    pub(crate) fn run_with_input<S: AsRef<OsStr>>(&self, arguments: &[S], input: &str) -> Ran {
        self.write(".input", input);
        let file = std::fs::File::open(self.path(".input")).expect("readable");
        ran(self.command(arguments).stdin(file))
    }

    /// As [`Desk::run`], on a machine whose Vulkan loader finds no driver.
    pub(crate) fn run_without_device<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Ran {
        let nowhere = self.path("no-driver.json");
        let mut command = self.command(arguments);
        // The second is what loaders before 1.3.207 read.
        command.env("VK_DRIVER_FILES", &nowhere);
        command.env("VK_ICD_FILENAMES", &nowhere);
        ran(&mut command)
    }

    /// The regions of `geojson` as a scene of the file `NAME.toml`, with its data in `data/`, seen
    /// from 3,000 km above longitude and latitude 0.
    pub(crate) fn write_scene(&self, name: &str, geojson: &str) {
        let hash: String = Sha256::digest(geojson.as_bytes())
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        self.write(&format!("data/{name}.geojson"), geojson);
        self.write(
            &format!("{name}.toml"),
            format!(
                "name = \"{name}\"\ndescription = \"for a test\"\nbody = \"wgs84\"\n\
                 [regions]\nfile = \"{name}.geojson\"\nsha256 = \"{hash}\"\nhow = \"no way\"\n\
                 [surface]\nkind = \"ellipsoid\"\nrows = 180\n\
                 [[views]]\nname = \"above\"\nlongitude_deg = 0\nlatitude_deg = 0\n\
                 height_m = 3_000_000\nheading_deg = 0\npitch_deg = -90\n"
            ),
        );
    }
}

/// Runs to the end. Whatever it was asked, the program neither panics nor writes to a pipe what
/// only a terminal understands.
pub(crate) fn ran(command: &mut Command) -> Ran {
    let output = command.output().expect("the program starts");
    let ran = Ran::new(&output);
    check_manners(&ran).unwrap_or_else(|complaint| panic!("{command:?}: {complaint}"));
    // Tests look for words wherever a long line was broken.
    let begins = format!("\n{INDENT}");
    let stderr = ran.stderr.replace(&format!("|{begins}"), "|");
    let stderr = stderr.replace(&begins, " ");
    let is_message = |line: &&str| !is_progress(line);
    let stderr = stderr.split_inclusive('\n').filter(is_message).collect();
    Ran { stderr, ..ran }
}

/// Whether a line on standard error says how far a run is, which changes from run to run: tests do not see it.
pub(crate) fn is_progress(line: &str) -> bool {
    line.contains("; step ")
}

fn check_manners(ran: &Ran) -> Result<(), String> {
    for text in [&ran.stdout, &ran.stderr] {
        if let Some(found) = text.chars().find(|c| c.is_control() && *c != '\n') {
            return Err(format!("control character {found:?} in a pipe: {text}"));
        }
        if text.contains("panicked") {
            return Err(format!("a panic: {text}"));
        }
    }
    // Words for people: no list without end, nothing as the code writes it.
    for line in ran.stderr.lines() {
        let begins = ["error: ", "warning: ", "skipped: ", INDENT];
        let is_message = begins.iter().any(|begins| line.starts_with(begins));
        // A case's name may be longer, and is copied whole.
        let is_name = !line.trim_start().contains(' ');
        if is_message && !is_name && line.chars().count() > 200 {
            return Err(format!("over 200 characters: {line}"));
        }
        for words in ["allowed: allowed:", "Some(", "Err("] {
            if line.contains(words) {
                return Err(format!("{words:?} in {line}"));
            }
        }
    }
    if ran.code < 0 {
        return Err("ended by a signal".to_owned());
    }
    Ok(())
}

impl Ran {
    fn new(output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("UTF-8");
        Self {
            code: output.status.code().unwrap_or(-1),
            stdout: text(&output.stdout),
            stderr: text(&output.stderr),
        }
    }

    /// What it printed, when it ended well and had nothing to complain about.
    #[track_caller]
    pub(crate) fn succeeded(self) -> String {
        assert_eq!(
            (self.code, self.stderr.as_str()),
            (0, ""),
            "{}",
            self.stdout
        );
        self.stdout
    }

    /// Refused as bad input: one line for each of `problems`, in their order, holding its phrases.
    #[track_caller]
    pub(crate) fn refused(&self, problems: &[&[&str]]) {
        if let Err(complaint) = self.check_refusal(problems) {
            panic!("{complaint}");
        }
    }

    fn check_refusal(&self, problems: &[&[&str]]) -> Result<(), String> {
        let Self {
            code,
            stdout,
            stderr,
        } = self;
        if *code != 2 {
            return Err(format!("exit code {code}: {stderr}"));
        }
        if !stdout.is_empty() {
            return Err(format!("on standard output: {stdout}"));
        }
        let lines: Vec<&str> = stderr.lines().collect();
        if lines.len() != problems.len() {
            let (found, expected) = (lines.len(), problems.len());
            return Err(format!("{found} lines instead of {expected}: {stderr}"));
        }
        for (line, phrases) in lines.iter().zip(problems) {
            if !line.starts_with("error: ") {
                return Err(format!("not an error line: {line}"));
            }
            if let Some(phrase) = phrases.iter().find(|phrase| !line.contains(**phrase)) {
                return Err(format!("{phrase:?} is not in: {line}"));
            }
        }
        Ok(())
    }
}

/// Names of every technique of the program.
pub(crate) fn techniques() -> Vec<String> {
    listed_techniques(|_| true)
}

/// Names of those whose pictures have to be right.
pub(crate) fn exact_techniques() -> Vec<String> {
    let exact = listed_techniques(|technique| technique["approximate"] == false);
    // Negative control: some are none of them.
    assert!(exact.len() < techniques().len(), "{exact:?}");
    exact
}

fn listed_techniques(is_wanted: impl Fn(&serde_json::Value) -> bool) -> Vec<String> {
    let json = Desk::new().run(&["techniques", "--json"]).succeeded();
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let listed = json["techniques"].as_array().expect("a list");
    let names = listed
        .iter()
        .filter(|technique| is_wanted(technique))
        .filter_map(|technique| technique["name"].as_str());
    let names: Vec<String> = names.map(str::to_owned).collect();
    assert!(names.len() >= 4, "{names:?}");
    names
}

/// Whether a device can run the vertex backend; says why not, and fails where one is required.
pub(crate) fn has_device() -> bool {
    a_device("vertex     runs")
}

/// Whether `devices` says so of one; if not as above.
pub(crate) fn a_device(words: &str) -> bool {
    let ran = Desk::new().run(&["devices"]);
    if ran.code == 0 && ran.stdout.contains(words) {
        return true;
    }
    let why = format!("no {words:?} in: {}{}", ran.stdout, ran.stderr);
    assert!(
        std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_none(),
        "TERRAFILL_REQUIRE_DEVICE is set, but: {why}"
    );
    eprintln!("skipped: {why}");
    false
}

/// A polygon of one ring, closed here.
pub(crate) fn polygon(ring: &[[f64; 2]]) -> String {
    let mut positions: Vec<String> = ring.iter().map(|[x, y]| format!("[{x},{y}]")).collect();
    positions.push(positions[0].clone());
    format!(
        "{{\"type\":\"Polygon\",\"coordinates\":[[{}]]}}",
        positions.join(",")
    )
}

/// A collection of features, each of a name and a geometry.
pub(crate) fn collection(features: &[(&str, String)]) -> String {
    let features: Vec<String> = features
        .iter()
        .map(|(name, geometry)| {
            format!(
                "{{\"type\":\"Feature\",\"properties\":{{\"name\":\"{name}\"}},\
                 \"geometry\":{geometry}}}"
            )
        })
        .collect();
    format!(
        "{{\"type\":\"FeatureCollection\",\"features\":[{}]}}",
        features.join(",")
    )
}

/// Corners of a rectangle, counter-clockwise.
pub(crate) fn rectangle(west: f64, south: f64, east: f64, north: f64) -> [[f64; 2]; 4] {
    [[west, south], [east, south], [east, north], [west, north]]
}

/// Two triangles that meet where edges cross, at 0.5, 0.5.
pub(crate) const BOW_TIE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];

#[test]
fn a_run_that_is_no_refusal_is_not_taken_for_one() {
    let ran = |code, stdout: &str, stderr: &str| Ran {
        code,
        stdout: stdout.to_owned(),
        stderr: stderr.to_owned(),
    };
    let good = ran(2, "", "error: f: line 1: what\n");
    assert_eq!(good.check_refusal(&[&["f: line 1"]]), Ok(()));
    let wrong = [
        ran(0, "", "error: f: line 1: what\n"),
        ran(101, "", "error: f: line 1: what\n"),
        ran(2, "{", "error: f: line 1: what\n"),
        ran(2, "", ""),
        ran(2, "", "error: f: line 1: what\nerror: f: line 1: what\n"),
        ran(2, "", "error: f: what\n"),
        ran(2, "", "f: line 1: what\n"),
    ];
    for (index, ran) in wrong.iter().enumerate() {
        assert!(ran.check_refusal(&[&["f: line 1"]]).is_err(), "{index}");
    }
}

#[test]
fn bad_manners_are_noticed() {
    let ran = |code, stderr: &str| Ran {
        code,
        stdout: String::new(),
        stderr: stderr.to_owned(),
    };
    assert_eq!(check_manners(&ran(0, "fine ×\n")), Ok(()));
    assert_eq!(
        check_manners(&ran(2, &"x".repeat(201))),
        Ok(()),
        "no message"
    );
    let name = ran(0, &format!("skipped: x\n    {}", "x".repeat(200)));
    assert_eq!(check_manners(&name), Ok(()), "copied whole");
    let wrong = [
        ran(2, &format!("error: {}", "x".repeat(200))),
        ran(2, &format!("error: x\n    {}", "x ".repeat(100))),
        ran(2, "error: a: found \"b\", allowed: allowed: c"),
        ran(2, "error: found Some(1)"),
        ran(0, "\u{1b}[2K"),
        ran(0, "1/9\r2/9"),
        ran(101, "thread 'main' panicked at"),
        ran(-1, ""),
    ];
    for ran in wrong {
        assert!(check_manners(&ran).is_err(), "{:?}", ran.stderr);
    }
}
