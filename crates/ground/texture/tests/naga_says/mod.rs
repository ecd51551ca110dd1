// SPDX-License-Identifier: MIT OR Apache-2.0
//! What naga says of the text of a route.

/// Whether naga takes it.
pub(crate) fn is_valid(text: &str) -> Result<(), String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
    let flags = naga::valid::ValidationFlags::all();
    let capabilities = naga::valid::Capabilities::empty();
    let validated = naga::valid::Validator::new(flags, capabilities).validate(&module);
    validated.map(|_| ()).map_err(|e| e.emit_to_string(text))
}
