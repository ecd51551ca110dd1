// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures as short texts that are equal where the pictures are.
//!
//! FNV-1a over 64 bits (Fowler, Noll and Vo, 1991): two of a thousand different
//! pictures share a value with probability 3·10⁻¹⁴, and nobody chooses pixels to make them collide.

use crate::Frame;

/// Hash of which region each pixel shows, as sixteen hexadecimal digits.
#[must_use]
pub fn ids_hash(frame: &Frame) -> String {
    fingerprint(&frame.ids, |id| id)
}

/// Hash of which pixels show any region, as sixteen hexadecimal digits.
#[must_use]
pub fn mask_hash(frame: &Frame) -> String {
    fingerprint(&frame.ids, |id| id.min(1))
}

/// Hash of numbers as they are, as sixteen hexadecimal digits.
#[must_use]
pub fn numbers_hash(numbers: &[u32]) -> String {
    fingerprint(numbers, |number| number)
}

/// Of the four bytes of each id, the lowest first.
fn fingerprint(ids: &[u32], seen_as: impl Fn(u32) -> u32) -> String {
    const OFFSET_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    // A byte of 0 leaves nothing to do but the product, so that three of them are one.
    const PRIME_TO_THE_FOURTH: u64 = PRIME.wrapping_pow(4);
    let add = |hash: u64, id: u32| match id {
        0..=0xff => (hash ^ u64::from(id)).wrapping_mul(PRIME_TO_THE_FOURTH),
        _ => id.to_le_bytes().into_iter().fold(hash, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(PRIME)
        }),
    };
    let hash = ids
        .iter()
        .fold(OFFSET_BASIS, |hash, &id| add(hash, seen_as(id)));
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_values_come_out() {
        // FNV-1a of nothing and of the four bytes of "foob" (test vectors of its authors).
        assert_eq!(fingerprint(&[], |id| id), "cbf29ce484222325");
        let foob = u32::from_le_bytes(*b"foob");
        assert_eq!(fingerprint(&[foob], |id| id), "dd120e790c2512af");
    }

    #[test]
    fn small_ids_are_hashed_like_all_others() {
        let byte_by_byte = |ids: &[u32]| {
            let bytes = ids.iter().flat_map(|id| id.to_le_bytes());
            let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            });
            format!("{hash:016x}")
        };
        let ids = [0, 1, 254, 255, 256, 257, 65_535, 65_536, u32::MAX, 3];
        assert_eq!(fingerprint(&ids, |id| id), byte_by_byte(&ids));
        // Negative control: another order is another hash.
        assert_ne!(fingerprint(&ids, |id| id), byte_by_byte(&[1, 0]));
    }

    #[test]
    fn one_wrong_pixel_and_two_swapped_ones_are_noticed() {
        let mut ids = vec![0_u32; 1 << 16];
        ids[7] = 3;
        let hash = |ids: &[u32]| fingerprint(ids, |id| id);
        let right = hash(&ids);
        assert_eq!(right, hash(&ids));
        ids[40_000] = 1;
        assert_ne!(right, hash(&ids));
        ids[40_000] = 0;
        ids.swap(7, 8);
        assert_ne!(right, hash(&ids));
    }
}
