// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whatever is written over a right file, a reader answers: heights that are numbers, or an error that names the file.

use proptest::prelude::*;
use terrafill_elevation::read;

const FILES: [&str; 12] = [
    "alpha_band.tif",
    "bad_checksum.dt0",
    "grid_registered.tif",
    "internal_mask.tif",
    "miniswhite_f32.tif",
    "rgb_zstd.tif",
    "scale_offset.tif",
    "sirgas2000.tif",
    "southup.tif",
    "sparse_strip.tif",
    "t_terrarium_12-2130-1473.png",
    "vertical_ftus.tif",
];
/// Headers and tags, where most changes mean something.
const HEAD: usize = 600;

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn readers_answer_to_anything(
        file in 0..FILES.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<bool>(), any::<u8>()), 0..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let name = FILES[file];
        let path = format!("{}/tests/cases/{name}", env!("CARGO_MANIFEST_DIR"));
        let mut bytes = std::fs::read(path).expect(name);
        for (at, in_head, byte) in changes {
            let most = if in_head { bytes.len().min(HEAD) } else { bytes.len() };
            bytes[at.index(most)] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        match read(name, &bytes) {
            Ok(field) => {
                let heights = field.heights();
                prop_assert!(heights.lowest_m.is_finite() && heights.highest_m.is_finite());
                prop_assert!(field.warnings().iter().all(|warning| warning.starts_with(name)));
            }
            Err(error) => prop_assert!(error.to_string().starts_with(name), "{error}"),
        }
    }
}
