// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ground in blocks, what is looked up in it, and which texel that is, by integers.

use bytemuck::{Pod, Zeroable};
use terrafill_shapes::grid::nearest;

/// A side of a block, texels.
pub(crate) const SIDE: u32 = 64;
/// A texel is as wide as a cell of published terrain.
const TEXEL_M: f64 = 30.0;

/// Blocks in rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Blocks {
    pub(crate) across: u32,
    pub(crate) down: u32,
}

impl Blocks {
    /// As square as powers of two allow.
    ///
    /// - `count`: a power of two
    pub(crate) fn new(count: u32) -> Self {
        let across = 1 << count.ilog2().div_ceil(2);
        Self {
            across,
            down: count / across,
        }
    }

    pub(crate) fn count(self) -> u32 {
        self.across * self.down
    }

    /// Texels of a block, row by row.
    ///
    /// - `version`: how often it was written
    pub(crate) fn texels(number: u32, version: u32) -> Vec<f32> {
        let all = 0..SIDE * SIDE;
        all.map(|inner| texel(number, inner, version)).collect()
    }
}

/// A number of 24 bits, which f32 holds exactly, different for neighbours.
fn texel(block: u32, inner: u32, version: u32) -> f32 {
    (scatter(block * SIDE * SIDE + inner, version) >> 8) as f32
}

/// Bits of a number, scattered (the finaliser of MurmurHash3).
fn scatter(number: u32, seed: u32) -> u32 {
    let mut bits = number ^ seed.wrapping_mul(0x9e37_79b9);
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ (bits >> 13)).wrapping_mul(0xc2b2_ae35);
    bits ^ (bits >> 16)
}

terrafill_results::named! {
    /// In which order texels are looked up.
    all pub(crate) enum Access {
        /// Block by block, row by row.
        Coherent = "coherent",
        /// Anywhere.
        Random = "random",
    }
}

/// Twin of `TexelQuery` in `shared/cache.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct TexelQuery {
    pub(crate) block: [u32; 2],
    pub(crate) share: [f32; 2],
    pub(crate) world_m: [f32; 2],
}

/// Twin of `CacheConstants` in `shared/cache.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CacheConstants {
    pub(crate) blocks_across: u32,
    pub(crate) side: u32,
    pub(crate) count: u32,
    pub(crate) blocks: u32,
    pub(crate) block_m: f32,
}

impl CacheConstants {
    pub(crate) fn new(blocks: Blocks, count: u32) -> Self {
        Self {
            blocks_across: blocks.across,
            side: SIDE,
            count,
            blocks: blocks.count(),
            // A whole number far below 2^24.
            block_m: nearest(f64::from(SIDE) * TEXEL_M),
        }
    }
}

/// Places within a block along one axis, of its side: anywhere, and every fourth on a border of texels or of blocks, or
/// one last place beside it. Numerators are below 2²⁴ and divisors powers of two, so quotients are exact.
fn share(bits: u32) -> f32 {
    let border = (bits >> 8) % (SIDE + 1);
    let border = border as f32 / SIDE as f32;
    let is_last = border >= 1.0;
    match bits % 12 {
        0 if !is_last => border,
        1 if !is_last => border.next_up(),
        2 => border.next_down().max(0.0),
        _ => (bits >> 8) as f32 / (1 << 24) as f32,
    }
}

/// What is looked up.
///
/// - `count`: a multiple of the number of blocks
pub(crate) fn queries(blocks: Blocks, access: Access, count: u32) -> Vec<TexelQuery> {
    let query = |number: u32| {
        let bits = [1, 2, 3].map(|seed| scatter(number, seed));
        let mut share = [share(bits[0]), share(bits[1])];
        let at = match access {
            Access::Coherent => {
                // Rows of a block one after the other.
                let in_block = count / blocks.count();
                let row = f64::from(number % in_block) / f64::from(in_block);
                share[1] = nearest(row).min(1.0_f32.next_down());
                number / in_block
            }
            Access::Random => bits[2] % blocks.count(),
        };
        let block = [at % blocks.across, at / blocks.across];
        let world_m = [0, 1].map(|axis| {
            let place = f64::from(block[axis]) + f64::from(share[axis]);
            // Rounding to one f32 for the whole ground is what is asked about.
            nearest(place * f64::from(SIDE) * TEXEL_M)
        });
        TexelQuery {
            block,
            share,
            world_m,
        }
    };
    (0..count).map(query).collect()
}

/// The right answer: the texel's number by integers. A share is a whole number of 2⁻¹⁴⁹, so its product with the
/// side is exact in `f64` and its whole part is the texel.
///
/// - `versions`: how often each block was written
pub(crate) fn answer(blocks: Blocks, query: &TexelQuery, versions: impl Fn(u32) -> u32) -> f32 {
    let [column, row] = query.block;
    let block = row * blocks.across + column;
    let [x, y] = query.share.map(|share| {
        #[allow(clippy::cast_possible_truncation, reason = "from 0 to the side")]
        let texel = (f64::from(share) * f64::from(SIDE)) as u32;
        texel
    });
    texel(block, y * SIDE + x, versions(block))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    #[test]
    fn what_the_shader_reads_lies_as_it_does_here() {
        let path = "pipelines/cache_array.wgsl";
        let query = struct_layout(path, "TexelQuery").expect("a struct");
        let offset = |name: &str| query.offset(name).expect(name);
        assert_eq!(offset("share"), offset_of!(TexelQuery, share));
        assert_eq!(offset("world_m"), offset_of!(TexelQuery, world_m));
        assert_eq!(query.stride as usize, size_of::<TexelQuery>());
        let constants = struct_layout(path, "CacheConstants").expect("a struct");
        assert_eq!(constants.stride as usize, size_of::<CacheConstants>());
        assert_ne!(offset("share"), offset_of!(TexelQuery, world_m));
    }

    #[test]
    fn shares_lie_within_a_block_and_at_its_borders() {
        let blocks = Blocks::new(16);
        assert_eq!([blocks.across, blocks.down], [4, 4]);
        assert_eq!(Blocks::new(2_048).count(), 2_048);
        for access in Access::ALL {
            let all = queries(blocks, access, 4_096);
            let shares = || all.iter().map(|query| query.share[0]);
            assert!(all.iter().all(|query| {
                let [x, y] = query.share;
                (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y)
            }));
            let is_border = |share: f32| (share * 64.0).fract() == 0.0;
            assert!(shares().filter(|share| is_border(*share)).count() > 100);
            assert!(
                shares()
                    .filter(|share| *share == 1.0_f32.next_down())
                    .count()
                    > 1
            );
        }
    }

    #[test]
    fn answers_are_the_blocks_texels_and_change_with_the_version() {
        let blocks = Blocks::new(4);
        let texels = Blocks::texels(3, 0);
        let query = TexelQuery {
            block: [1, 1],
            share: [0.5, 1.0_f32.next_down()],
            world_m: [0.0; 2],
        };
        let right = texels[63 * 64 + 32];
        assert_eq!(answer(blocks, &query, |_| 0), right);
        // Negative controls: written anew, and another block.
        assert_ne!(answer(blocks, &query, |_| 1), right);
        let other = TexelQuery {
            block: [0, 1],
            ..query
        };
        assert_ne!(answer(blocks, &other, |_| 0), right);
    }
}
