// SPDX-License-Identifier: MIT OR Apache-2.0
//! Messages of Vulkan's validation layer, kept by each device crate and written to one file.
//!
//! With `TERRAFILL_VALIDATION=1` device crates load the layer, and keep every message of severity warning or
//! error. Each is appended to the file named by `TERRAFILL_VALIDATION_LOG` as one line: process id, severity,
//! message id, text and a full stop, separated by tabs. Many processes write to it, and one that is killed may
//! leave half a message: so each message begins a line of its own, and only a whole one has the stop.
//! Silence alone proves nothing, so each crate can commit an error ([`POSITIVE_CONTROL`]) that a working layer
//! must report.

use crate::{DeviceError, THIS_MACHINE};
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// One message of the validation layer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ValidationMessage {
    /// `ERROR` or `WARN`.
    pub severity: String,
    /// `VUID-…` or another message id.
    pub id: String,
    /// What it says, on one line.
    pub text: String,
}

/// Id of the message about a buffer of 0 bytes, which device crates make to see that the layer is heard.
pub const POSITIVE_CONTROL: &str = "VUID-VkBufferCreateInfo-size-00912";

/// Messages of one device crate in this process.
#[derive(Debug)]
pub struct ValidationLog(Mutex<Kept>);

#[derive(Debug)]
struct Kept {
    messages: Vec<ValidationMessage>,
    file: Option<File>,
}

impl ValidationLog {
    /// Without messages or a file.
    #[must_use]
    #[allow(
        clippy::new_without_default,
        reason = "it stands in a static, which a default cannot initialise"
    )]
    pub const fn new() -> Self {
        Self(Mutex::new(Kept {
            messages: Vec::new(),
            file: None,
        }))
    }

    /// Whether the environment asks for validation.
    #[must_use]
    pub fn is_requested() -> bool {
        std::env::var("TERRAFILL_VALIDATION").is_ok_and(|value| value != "0")
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Opens the file, if the environment names one.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] where it cannot be written: that would hide every message.
    pub fn open(&self) -> Result<(), DeviceError> {
        let Some(path) = std::env::var_os("TERRAFILL_VALIDATION_LOG") else {
            return Ok(());
        };
        let opened = OpenOptions::new().create(true).append(true).open(&path);
        let file = opened.map_err(|error| {
            let path = path.display();
            let what = format!("a writable TERRAFILL_VALIDATION_LOG={path}: {error}");
            DeviceError::unsupported(&what, THIS_MACHINE)
        })?;
        self.kept().file = Some(file);
        Ok(())
    }

    /// Keeps a message and writes it down.
    pub fn keep(&self, severity: &str, id: &str, text: &str) {
        let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let [id, text] = [id, text].map(one_line);
        let line = line(std::process::id(), severity, &id, &text);
        let message = |severity: &str, id: String, text: String| ValidationMessage {
            severity: severity.to_owned(),
            id,
            text,
        };
        let mut kept = self.kept();
        let written = kept
            .file
            .as_mut()
            .map(|file| file.write_all(line.as_bytes()));
        kept.messages.push(message(severity, id, text));
        if let Some(Err(error)) = written {
            let lost = message("ERROR", "validation-log-lost".to_owned(), error.to_string());
            kept.messages.push(lost);
        }
    }

    /// Number of messages so far.
    #[must_use]
    pub fn count(&self) -> usize {
        self.kept().messages.len()
    }

    /// Messages after the first `known`.
    #[must_use]
    pub fn after(&self, known: usize) -> Vec<ValidationMessage> {
        self.kept().messages.iter().skip(known).cloned().collect()
    }

    /// Whether there is a message with this id.
    #[must_use]
    pub fn has(&self, id: &str) -> bool {
        self.kept().messages.iter().any(|message| message.id == id)
    }
}

/// As a file has it. The line before may be half a message of a process that was killed.
fn line(process: u32, severity: &str, id: &str, text: &str) -> String {
    format!("\n{process}\t{severity}\t{id}\t{text}\t.\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_message_spoils_no_other() {
        let whole = line(2, "WARN", "VUID-y", "b");
        let cut = line(1, "ERROR", "VUID-x", "a long text").replace("text\t.\n", "");
        let both = cut + &whole;
        let lines: Vec<&str> = both.lines().filter(|line| !line.is_empty()).collect();
        assert_eq!(
            lines,
            ["1\tERROR\tVUID-x\ta long ", "2\tWARN\tVUID-y\tb\t."]
        );
    }

    #[test]
    fn a_message_is_kept_on_one_line() {
        let log = ValidationLog::new();
        log.keep("WARN", "VUID-x", "a\n\tb  c");
        let message = log.after(0).pop().expect("kept");
        assert_eq!([&*message.severity, &*message.id], ["WARN", "VUID-x"]);
        assert_eq!(message.text, "a b c");
        assert!(log.has("VUID-x") && log.after(1).is_empty());
        // Negative control: another log has none of it.
        let other = ValidationLog::new();
        assert!(!other.has("VUID-x") && other.after(0).is_empty());
    }
}
