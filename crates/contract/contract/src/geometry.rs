// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bytes of regions in a layout.

use std::ops::Add;

/// Bytes of one or more regions in one layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GeometryBytes {
    /// Positions and flags.
    pub vertex_bytes: u64,
    /// Indices.
    pub index_bytes: u64,
}

impl GeometryBytes {
    /// Both.
    #[must_use]
    pub fn total(self) -> u64 {
        self.vertex_bytes + self.index_bytes
    }
}

impl Add for GeometryBytes {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            vertex_bytes: self.vertex_bytes + other.vertex_bytes,
            index_bytes: self.index_bytes + other.index_bytes,
        }
    }
}

impl std::iter::Sum for GeometryBytes {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), Add::add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_add_up_each_with_its_own() {
        let bytes = |vertex_bytes, index_bytes| GeometryBytes {
            vertex_bytes,
            index_bytes,
        };
        let sum: GeometryBytes = [bytes(1, 10), bytes(2, 20)].into_iter().sum();
        assert_eq!((sum, sum.total()), (bytes(3, 30), 33));
        assert_ne!(sum, bytes(30, 3));
    }
}
