// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vulkan validation messages: caught, kept, and proved to be on.
//!
//! wgpu hands the layer's messages to the `log` crate. With `TERRAFILL_VALIDATION=1` a logger is installed that
//! keeps every message of severity warning or error that comes from Vulkan, as [`ValidationLog`] says.

use std::sync::Once;
use terrafill_contract::ValidationLog;

pub(crate) static LOG: ValidationLog = ValidationLog::new();

/// Id given to synchronisation messages about depth that a pass attaches read-only and its fragment
/// shaders read as well. wgpu-hal 30 ends every such pass with the store operation `STORE`. That counts
/// as a write, though the bits are those that were loaded; Vulkan 1.3 has `STORE_OP_NONE` for it, and
/// wgpu no way to ask for that. Where the project speaks to Vulkan itself the same message would be a
/// fault of its own, so the id says who is meant.
const STORES_READ_ONLY_DEPTH: &str = "wgpu-stores-read-only-depth";

/// Parts of the layer's sentence about it.
const STORE_AFTER_READ: [&str; 3] = [
    "depth aspect during store with storeOp VK_ATTACHMENT_STORE_OP_STORE",
    "usage: SYNC_LATE_FRAGMENT_TESTS_DEPTH_STENCIL_ATTACHMENT_WRITE",
    "prior_usage: SYNC_FRAGMENT_SHADER_SHADER_SAMPLED_READ",
];

/// What the layer has said so far in this process.
#[must_use]
pub fn validation_log() -> &'static ValidationLog {
    &LOG
}

/// Installs the logger once. A logger that is there already stays, and keeps nothing.
pub(crate) fn install_logger() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        if log::set_logger(&VulkanLogger).is_ok() {
            log::set_max_level(log::LevelFilter::Warn);
        }
    });
}

struct VulkanLogger;

impl log::Log for VulkanLogger {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() <= log::Level::Warn && metadata.target().starts_with("wgpu_hal::vulkan")
    }

    fn log(&self, record: &log::Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = record.args().to_string();
        if let Some((id, body)) = parse(&text) {
            LOG.keep(record.level().as_str(), id, body);
        }
    }

    fn flush(&self) {}
}

/// Reads `TYPE [id (0x…)]\n\ttext`. Lines about queues and objects that follow a message have no
/// bracketed id and are dropped. A layer that was asked for and is not there says so without an
/// id; that must not pass for silence.
fn parse(text: &str) -> Option<(&str, &str)> {
    if text.contains("unable to find layer") {
        return Some(("validation-layer-missing", text));
    }
    let (head, body) = text.split_once('\n')?;
    let id = head.split_once('[')?.1.split_once(" (0x")?.0;
    let is_store = STORE_AFTER_READ.iter().all(|part| body.contains(part));
    if id == "SYNC-HAZARD-WRITE-AFTER-READ" && is_store {
        return Some((STORES_READ_ONLY_DEPTH, body));
    }
    Some((id, body))
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_contract::POSITIVE_CONTROL;

    #[test]
    fn a_message_is_taken_apart() {
        let text =
            "VALIDATION [VUID-VkBufferCreateInfo-size-00912 (0x3d9)]\n\tValidation Error:\n bad";
        let (id, body) = parse(text).expect("has an id");
        assert_eq!(id, POSITIVE_CONTROL);
        assert_eq!(body.trim(), "Validation Error:\n bad");
    }

    #[test]
    fn stores_of_read_only_depth_are_told_from_other_hazards() {
        let hazard = |body: &str| {
            let text = format!("VALIDATION [SYNC-HAZARD-WRITE-AFTER-READ (0x376bc9df)]\n\t{body}");
            parse(&text).expect("has an id").0.to_owned()
        };
        let body = STORE_AFTER_READ.join(" ");
        assert_eq!(hazard(&body), STORES_READ_ONLY_DEPTH);
        // Negative controls: a store that clears, a write of another stage, a copy that read.
        for part in STORE_AFTER_READ {
            let other = hazard(&body.replace(part, "something else"));
            assert_eq!(other, "SYNC-HAZARD-WRITE-AFTER-READ");
        }
    }

    #[test]
    fn trailing_lines_are_no_messages_but_a_missing_layer_is_one() {
        assert_eq!(parse("\tobjects: (type: BUFFER)"), None);
        let missing = "InstanceFlags::VALIDATION requested, but unable to find layer: X";
        let (id, _) = parse(missing).expect("kept");
        assert_eq!(id, "validation-layer-missing");
    }
}
