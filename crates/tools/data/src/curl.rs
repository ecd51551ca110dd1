// SPDX-License-Identifier: MIT OR Apache-2.0
//! One transfer by `curl`, a child process: bytes of an address from an offset on.

use std::io::{self, Read as _};
use std::process::{Child, Command, Stdio};

/// Read at once: large enough that system calls do not count, small enough for progress to be seen.
const CHUNK_BYTES: usize = 64 * 1024;
/// `curl`'s exit code where a server sends a whole file though a part of it was asked for.
const NO_RANGES: i32 = 33;
/// Options of every transfer. A status of 400 or more is an error, and only HTTP is spoken,
/// whatever a server redirects to. A connection is broken that cannot be made in half a minute, or
/// brings less than a byte a second for a whole minute. `[` and `{` in an address mean themselves.
const OPTIONS: [&str; 17] = [
    "--fail",
    "--silent",
    "--show-error",
    "--location",
    "--max-redirs",
    "5",
    "--globoff",
    "--proto",
    "=http,https",
    "--proto-redir",
    "=http,https",
    "--connect-timeout",
    "30",
    "--speed-limit",
    "1",
    "--speed-time",
    "60",
];

/// How a transfer ended.
#[derive(Debug)]
pub(crate) enum Ended {
    /// The server says that this was all.
    Complete,
    /// The server cannot begin in the middle.
    NoRanges,
    /// It failed; `curl`'s words.
    Broken(String),
}

/// Why a transfer was given up.
#[derive(Debug)]
pub(crate) enum Stopped<E> {
    /// `curl` cannot be started.
    NotStarted(io::Error),
    /// What takes the bytes refused them.
    Refused(E),
}

/// Hands the bytes of `url` from the offset `from` on to `take`, as they arrive.
pub(crate) fn read<E>(
    url: &str,
    from: u64,
    mut take: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<Ended, Stopped<E>> {
    let mut command = Command::new("curl");
    command.args(OPTIONS);
    if from > 0 {
        command.args(["--continue-at", &from.to_string()]);
    }
    if is_loopback(url) {
        // A proxy is no way to this machine.
        command.args(["--noproxy", "*"]);
    }
    let child = command
        .args(["--url", url])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(Stopped::NotStarted)?;
    let mut child = Running(child);
    let mut chunk = vec![0; CHUNK_BYTES];
    if let Some(mut bytes) = child.0.stdout.take() {
        loop {
            match bytes.read(&mut chunk) {
                Ok(0) => break,
                Ok(read) => take(&chunk[..read]).map_err(Stopped::Refused)?,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Ok(Ended::Broken(error.to_string())),
            }
        }
    }
    Ok(child.ended())
}

/// Whether an address is one of this machine.
fn is_loopback(url: &str) -> bool {
    let host = url.split_once("://").map_or(url, |(_, rest)| rest);
    let host = host.split([':', '/']).next().unwrap_or_default();
    ["127.0.0.1", "localhost"].contains(&host)
}

/// A child process that does not outlive its value.
struct Running(Child);

impl Running {
    /// Waits for the end. `--show-error` writes a line or two, which a pipe holds.
    fn ended(&mut self) -> Ended {
        let mut words = String::new();
        if let Some(mut stderr) = self.0.stderr.take() {
            drop(stderr.read_to_string(&mut words));
        }
        match self.0.wait() {
            Ok(status) if status.success() => Ended::Complete,
            Ok(status) if status.code() == Some(NO_RANGES) => Ended::NoRanges,
            Ok(status) => Ended::Broken(match one_line(&words) {
                nothing if nothing.is_empty() => format!("curl: {status}"),
                words => words,
            }),
            Err(error) => Ended::Broken(error.to_string()),
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // One that has ended cannot be killed, which is all right.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

/// Words of another program as they may stand in a line of ours.
fn one_line(words: &str) -> String {
    let shown = words.replace(|c: char| c.is_control() && c != '\n', " ");
    let lines: Vec<&str> = shown.lines().map(str::trim).collect();
    lines.join(" ").trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_addresses_of_this_machine_go_past_a_proxy() {
        for url in [
            "http://127.0.0.1:80/a",
            "https://localhost/a",
            "http://localhost:1",
        ] {
            assert!(is_loopback(url), "{url}");
        }
        for url in [
            "https://host.example/127.0.0.1",
            "http://127.0.0.1.example/a",
            "http://",
        ] {
            assert!(!is_loopback(url), "{url}");
        }
    }

    #[test]
    fn words_of_curl_become_one_line_without_control_characters() {
        assert_eq!(
            one_line("curl: (22) 404\r\n\u{1b}[2K more\n"),
            "curl: (22) 404 [2K more"
        );
        assert_eq!(one_line("\n"), "");
    }
}
