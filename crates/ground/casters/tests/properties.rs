// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whatever is written over a right file, a reader answers: a mesh of finite places, or an error that names the file.

use proptest::prelude::*;
use std::path::Path;
use terrafill_casters::{ModelFile, Reading};

const FILES: [&str; 11] = [
    "basisu_required.glb",
    "bom_before_first_vertex.obj",
    "concave_cap.obj",
    "data_uri_buffer.glb",
    "degenerate_faces.obj",
    "line_continuation.obj",
    "skinned_control.obj",
    "skinned_node_scale.glb",
    "sparse_accessor.glb",
    "triangle_strip.glb",
    "unlit_required.glb",
];
/// What is written: digits most of all, so that JSON and lines stay what they are.
const BYTES: &[u8] = b"0123456789012345678901234567890123456789-.e/\\# \n\"[]{},:fvo\xFF\x00";

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn readers_answer_to_anything(
        file in 0..FILES.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0..BYTES.len()), 0..5),
        cut in prop::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let name = FILES[file];
        let original = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name);
        let mut bytes = std::fs::read(original).expect(name);
        for (at, byte) in changes {
            let length = bytes.len();
            bytes[at.index(length)] = BYTES[byte];
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, &bytes).expect("written");
        match ModelFile::read(&path, Reading::default()) {
            Ok(read) => {
                prop_assert!(read.mesh.vertices.iter().all(|place| place.is_finite()));
                let count = read.mesh.vertices.len();
                let mut corners = read.mesh.triangles.iter().flatten();
                prop_assert!(corners.all(|corner| (*corner as usize) < count));
            }
            Err(error) => prop_assert!(error.to_string().contains(name), "{error}"),
        }
    }
}
