// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures as short texts that are equal where the pictures are.
//!
//! FNV-1a over 64 bits (Fowler, Noll and Vo, 1991): two of a thousand different
//! pictures share a value with probability 3·10⁻¹⁴, and nobody chooses pixels to make them collide.

/// Hash of which region each pixel shows, as sixteen hexadecimal digits.
pub(crate) fn fingerprint(ids: impl IntoIterator<Item = u32>) -> String {
    const OFFSET_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let hash = ids
        .into_iter()
        .flat_map(u32::to_le_bytes)
        .fold(OFFSET_BASIS, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(PRIME)
        });
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_values_come_out() {
        // FNV-1a of nothing and of the four bytes of "foob" (test vectors of its authors).
        assert_eq!(fingerprint([]), "cbf29ce484222325");
        assert_eq!(
            fingerprint([u32::from_le_bytes(*b"foob")]),
            "dd120e790c2512af"
        );
    }

    #[test]
    fn one_wrong_pixel_and_two_swapped_ones_are_noticed() {
        let mut ids = vec![0_u32; 1 << 16];
        ids[7] = 3;
        let right = fingerprint(ids.iter().copied());
        assert_eq!(right, fingerprint(ids.iter().copied()));
        ids[40_000] = 1;
        assert_ne!(right, fingerprint(ids.iter().copied()));
        ids[40_000] = 0;
        ids.swap(7, 8);
        assert_ne!(right, fingerprint(ids.iter().copied()));
    }
}
