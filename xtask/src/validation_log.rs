// SPDX-License-Identifier: MIT OR Apache-2.0
//! The log that tests write while the Vulkan validation layer watches them.
//!
//! One message a line: `PID<TAB>severity<TAB>message id<TAB>text<TAB>.`. Silence is no success: a
//! layer that was never loaded is silent too. So one test commits an error on purpose, and a log
//! without that error fails. Tests also kill processes, and one that is killed as it writes leaves a
//! line without its stop: that is its last, and is judged by the id alone.

use anyhow::{Context as _, Result, bail};
use std::collections::BTreeMap;
use std::path::Path;

/// What the deliberate error is reported as.
const POSITIVE_CONTROL: &str = "VUID-VkBufferCreateInfo-size-00912";

/// Messages that are known to be false: how the id begins, what the text holds, why.
const FALSE_MESSAGES: &str = include_str!("../../ci/false-validation-messages.csv");

/// Starts of ids, and what the texts hold.
fn false_messages() -> impl Iterator<Item = (&'static str, &'static str)> {
    let rows = FALSE_MESSAGES.lines().skip(1);
    rows.filter_map(|row| {
        let mut cells = row.split(',');
        cells.next().zip(cells.next())
    })
}

/// Reads a log and refuses it if the layer was not at work or reported anything unexpected.
pub(crate) fn check(path: &Path) -> Result<String> {
    let text = std::fs::read_to_string(path).with_context(|| {
        format!(
            "{}: no log: did no test run with the layer on?",
            path.display()
        )
    })?;
    check_text(&text)
}

fn check_text(text: &str) -> Result<String> {
    let (mut control, mut known_false, mut unexpected) = (0_usize, 0_usize, Vec::new());
    // Lines cut off, by the process that wrote them.
    let mut cut: BTreeMap<&str, &str> = BTreeMap::new();
    for (i, line) in text.lines().enumerate() {
        if line.is_empty() {
            continue;
        }
        let pid = line.split('\t').next().unwrap_or_default();
        if let Some(earlier) = cut.get(pid) {
            bail!("process {pid} went on after half a message: {earlier:?}");
        }
        let Some(whole) = line.strip_suffix("\t.") else {
            if pid.parse::<u32>().is_err() {
                let allowed = "a message that begins with a process id";
                bail!("line {}: found {line:?}, allowed: {allowed}", i + 1);
            }
            cut.insert(pid, line);
            continue;
        };
        let mut fields = whole.splitn(4, '\t');
        let (Some(pid), Some(severity), Some(id), Some(message)) =
            (fields.next(), fields.next(), fields.next(), fields.next())
        else {
            bail!(
                "line {}: found {line:?}, allowed: five fields between tabs",
                i + 1
            );
        };
        if id == POSITIVE_CONTROL {
            control += 1;
        } else if is_known_false(id, message) {
            known_false += 1;
        } else {
            unexpected.push(format!("process {pid}: {severity} {id}: {message}"));
        }
    }
    for line in cut.values() {
        let fields: Vec<&str> = line.split('\t').collect();
        // With a field after it the id is whole.
        if let [pid, severity, id, _, ..] = fields.as_slice()
            && !may_be_false(id)
        {
            unexpected.push(format!("process {pid}, cut off: {severity} {id}"));
        }
    }
    if !unexpected.is_empty() {
        bail!(
            "{} unexpected validation messages:\n  {}",
            unexpected.len(),
            unexpected.join("\n  ")
        );
    }
    if control == 0 {
        bail!("the deliberate error {POSITIVE_CONTROL} was not reported: the layer is not at work");
    }
    Ok(format!(
        "validation layer at work ({control} deliberate errors reported), {known_false} messages \
         known to be false, {} cut off as their process was killed, nothing else",
        cut.len()
    ))
}

/// Whether some text makes a message with this id a false one.
fn may_be_false(id: &str) -> bool {
    let mut starts = false_messages().map(|(start, _)| start);
    id == POSITIVE_CONTROL || starts.any(|start| id.starts_with(start))
}

fn is_known_false(id: &str, message: &str) -> bool {
    false_messages().any(|(start, part)| id.starts_with(start) && message.contains(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONTROL: &str = "7\tERROR\tVUID-VkBufferCreateInfo-size-00912\tsize is 0\t.\n";
    const SPIRV: &str = "8\tERROR\tUNASSIGNED-CoreValidation-Shader-InconsistentSpirv\t\
                         Invalid source language operand: 10\t.\n";
    const LINE_WIDTH: &str = "8\tERROR\tVUID-vkCmdDrawIndexed-commandBuffer-02701\t\
                              VK_DYNAMIC_STATE_LINE_WIDTH not set\t.\n";

    const STORE: &str = "8\tERROR\twgpu-stores-read-only-depth\t\
                         storeOp VK_ATTACHMENT_STORE_OP_STORE\t.\n";

    #[test]
    fn the_deliberate_error_and_the_false_messages_pass() {
        let summary = check_text(&[CONTROL, SPIRV, LINE_WIDTH, STORE].concat()).expect("clean");
        assert!(summary.contains("1 deliberate errors"), "{summary}");
        assert!(
            summary.contains("3 messages known to be false"),
            "{summary}"
        );
    }

    #[test]
    fn silence_fails() {
        for text in ["", SPIRV] {
            let error = check_text(text).expect_err("no positive control");
            assert!(error.to_string().contains("not at work"), "{error}");
        }
        let folder = tempfile::tempdir().expect("temporary folder");
        assert!(check(&folder.path().join("none")).is_err());
    }

    #[test]
    fn any_other_message_fails_and_is_shown() {
        let others = [
            "9\tERROR\tVUID-vkCmdDrawIndexed-None-02699\tdescriptor not bound\t.\n",
            "9\tWARN\tvalidation-layer-missing\tunable to find layer\t.\n",
            // The same store from a pass that is not wgpu's.
            "9\tERROR\tSYNC-HAZARD-WRITE-AFTER-READ\tstoreOp VK_ATTACHMENT_STORE_OP_STORE\t.\n",
            // The false messages' ids with other texts are real ones.
            "9\tERROR\tUNASSIGNED-CoreValidation-Shader-InconsistentSpirv\tmissing capability\t.\n",
            "9\tERROR\tVUID-vkCmdDraw-commandBuffer-02701\tviewport not set\t.\n",
        ];
        for other in others {
            let error = check_text(&format!("{CONTROL}{other}")).expect_err(other);
            let id = other.split('\t').nth(2).expect("an id");
            assert!(error.to_string().contains(id), "{error}");
        }
    }

    #[test]
    fn a_message_cut_off_is_the_last_of_its_process_and_may_be_false() {
        let cut = "8\tERROR\tVUID-vkCmdDrawIndexed-commandBuffer-02701\tObject 0: handle\n";
        let text = [CONTROL, SPIRV, cut, &STORE.replace('8', "9")].concat();
        let summary = check_text(&text).expect("clean");
        assert!(summary.contains("1 cut off"), "{summary}");
        check_text(&[CONTROL, "8\tERR\n"].concat()).expect("says nothing yet");
        // Negative controls: a process that goes on was not killed; another id is never false.
        check_text(&[CONTROL, cut, SPIRV].concat()).expect_err("goes on");
        let real = cut.replace("vkCmdDrawIndexed-commandBuffer-02701", "vkCmdCopy-00001");
        let error = check_text(&[CONTROL, &real].concat()).expect_err("a real one");
        assert!(error.to_string().contains("vkCmdCopy-00001"), "{error}");
    }

    #[test]
    fn a_line_that_is_no_message_fails() {
        assert!(check_text(&format!("{CONTROL}half a line")).is_err());
    }
}
