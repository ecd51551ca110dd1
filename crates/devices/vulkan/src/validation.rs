// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vulkan validation messages: the layer's callback, which keeps what [`ValidationLog`] says.

use ash::vk;
use std::ffi::CStr;
use terrafill_contract::ValidationLog;

/// The layer that checks.
pub(crate) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

pub(crate) static LOG: ValidationLog = ValidationLog::new();

/// What the layer has said so far in this process.
#[must_use]
pub fn validation_log() -> &'static ValidationLog {
    &LOG
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
    LOG.keep(
        if is_error { "ERROR" } else { "WARN" },
        &words(id),
        &words(text),
    );
    vk::FALSE
}
