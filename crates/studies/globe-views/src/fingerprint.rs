// SPDX-License-Identifier: MIT OR Apache-2.0
//! What tells one frame from another: a hash of bytes that a device reads or writes.

use std::hash::{DefaultHasher, Hasher as _};

/// Why a case whose [`fingerprint`] has changed is not timed.
pub const OTHER_TRIANGLES: &str = "it made other triangles than when it was verified";

/// Hash of what a device reads or writes, 16 hexadecimal digits.
pub fn fingerprint(parts: &[&[u8]]) -> String {
    let mut hasher = DefaultHasher::new();
    for part in parts {
        hasher.write(part);
    }
    format!("{:016x}", hasher.finish())
}
