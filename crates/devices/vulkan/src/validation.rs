// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vulkan validation messages: caught, kept, and proved to be on.
//!
//! With `TERRAFILL_VALIDATION=1` the layer is loaded and every message of severity warning or error is
//! kept. Each is appended to the file named by `TERRAFILL_VALIDATION_LOG` as one line: process id,
//! severity, message id and text, separated by tabs. `terrafill-gpu` writes the same lines. Silence
//! alone proves nothing, so [`crate::make_deliberate_error`] commits an error that a working layer must
//! report.

use ash::vk;
use std::ffi::CStr;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::sync::{Mutex, MutexGuard, PoisonError};
use terrafill_contract::DeviceError;

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

/// Message id that [`crate::make_deliberate_error`] must bring about.
pub const POSITIVE_CONTROL: &str = "VUID-VkBufferCreateInfo-size-00912";

/// The layer that checks.
pub(crate) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

#[derive(Debug)]
struct Kept {
    messages: Vec<ValidationMessage>,
    log: Option<File>,
}

static KEPT: Mutex<Kept> = Mutex::new(Kept {
    messages: Vec::new(),
    log: None,
});

fn kept() -> MutexGuard<'static, Kept> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Messages so far in this process.
#[must_use]
pub fn messages() -> Vec<ValidationMessage> {
    kept().messages.clone()
}

/// Whether the environment asks for validation.
pub(crate) fn is_requested() -> bool {
    std::env::var("TERRAFILL_VALIDATION").is_ok_and(|value| value != "0")
}

/// Opens the log, if the environment names one: a log that cannot be written would hide every
/// message.
pub(crate) fn open_log() -> Result<(), DeviceError> {
    let Some(path) = std::env::var_os("TERRAFILL_VALIDATION_LOG") else {
        return Ok(());
    };
    let opened = OpenOptions::new().create(true).append(true).open(&path);
    let file = opened.map_err(|error| DeviceError::Unsupported {
        capability: format!(
            "a writable TERRAFILL_VALIDATION_LOG={}: {error}",
            path.display()
        ),
        adapter: "this machine".to_owned(),
    })?;
    kept().log = Some(file);
    Ok(())
}

/// Keeps a message and writes it down.
pub(crate) fn keep(severity: &str, id: &str, text: &str) {
    let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let message = ValidationMessage {
        severity: severity.to_owned(),
        id: one_line(id),
        text: one_line(text),
    };
    let mut kept = kept();
    let line = format!(
        "{}\t{}\t{}\t{}\n",
        std::process::id(),
        message.severity,
        message.id,
        message.text
    );
    let written = kept.log.as_mut().map(|log| log.write_all(line.as_bytes()));
    kept.messages.push(message);
    if let Some(Err(error)) = written {
        kept.messages.push(ValidationMessage {
            severity: "ERROR".to_owned(),
            id: "validation-log-lost".to_owned(),
            text: error.to_string(),
        });
    }
}

/// What the layer is told to report to.
pub(crate) fn messenger_info() -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(
            vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
        )
        .message_type(
            vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
        )
        .pfn_user_callback(Some(on_message))
}

/// The layer's callback; false lets the call that caused the message go on.
unsafe extern "system" fn on_message(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    _user: *mut std::ffi::c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes a structure that lives for the call, or null.
    let Some(data) = (unsafe { data.as_ref() }) else {
        return vk::FALSE;
    };
    // SAFETY: the specification has both texts end with a zero byte; a missing one is null.
    let (id, text) = unsafe { (data.message_id_name_as_c_str(), data.message_as_c_str()) };
    let words = |text: Option<&CStr>| text.map_or(String::new(), |t| t.to_string_lossy().into());
    let is_error = severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR);
    keep(
        if is_error { "ERROR" } else { "WARN" },
        &words(id),
        &words(text),
    );
    vk::FALSE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_kept_on_one_line() {
        keep("WARN", "VUID-x", "a\n\tb  c");
        let message = messages().pop().expect("kept");
        assert_eq!(
            (message.severity.as_str(), message.id.as_str()),
            ("WARN", "VUID-x")
        );
        assert_eq!(message.text, "a b c");
    }
}
