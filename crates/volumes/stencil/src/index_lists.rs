// SPDX-License-Identifier: MIT OR Apache-2.0
//! Index lists of two widths, as every layout of meshes in GPU buffers has them.

/// Indices of a scene: of 16 bits for regions whose vertices fit, of 32 for the others.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct IndexLists {
    /// Of 16 bits.
    pub short: Vec<u16>,
    /// Of 32 bits.
    pub long: Vec<u32>,
}

impl IndexLists {
    /// Appends `index` to the list of its region's width. `u32::MAX` is the largest value of either,
    /// which restarts strips and separates loops.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "short indices are below 2^16 by choice of width, or the restart value"
    )]
    pub fn push(&mut self, is_short: bool, index: u32) {
        if is_short {
            self.short.push(index as u16);
        } else {
            self.long.push(index);
        }
    }

    /// Indices of one width so far.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "buffers are refused by the device long before 2^32 elements"
    )]
    #[must_use]
    pub fn count(&self, is_short: bool) -> u32 {
        if is_short {
            self.short.len() as u32
        } else {
            self.long.len() as u32
        }
    }

    /// Puts others behind them.
    pub fn append(&mut self, others: &Self) {
        self.short.extend(&others.short);
        self.long.extend(&others.long);
    }

    /// Bytes of both.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.short.len() as u64 * 2 + self.long.len() as u64 * 4
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_lies_in_the_list_of_its_width() {
        let mut lists = IndexLists::default();
        for (is_short, index) in [
            (true, 7),
            (false, 70_000),
            (true, u32::MAX),
            (false, u32::MAX),
        ] {
            lists.push(is_short, index);
        }
        assert_eq!(lists.short, [7, 0xffff]);
        assert_eq!(lists.long, [70_000, u32::MAX]);
        lists.append(&IndexLists {
            short: vec![8],
            long: Vec::new(),
        });
        assert_eq!((lists.count(true), lists.count(false)), (3, 2));
        assert_eq!(lists.bytes(), 3 * 2 + 2 * 4);
        let twin = IndexLists {
            short: lists.short.clone(),
            ..IndexLists::default()
        };
        assert_ne!(twin.bytes(), lists.bytes());
    }
}
