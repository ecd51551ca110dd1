// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files of the kinds that public bug reports are about: each is the same tower, or two of them.

use glam::DVec3;
use std::path::{Path, PathBuf};
use terrafill_casters::{Mesh, ModelFile, Reading, Up, verdict};

fn path(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    folder.join(name)
}

fn case(name: &str) -> ModelFile {
    let reading = Reading {
        up: Up::Z,
        unit_m: 1.0,
    };
    ModelFile::read(&path(name), reading).unwrap_or_else(|error| panic!("{error}"))
}

fn volume(mesh: &Mesh) -> f64 {
    let volumes = (0..mesh.triangles.len()).map(|triangle| {
        let [a, b, c] = mesh.corners(triangle);
        a.dot(b.cross(c)) / 6.0
    });
    volumes.sum()
}

/// Corners of the box around a mesh.
fn bounds(mesh: &Mesh) -> [DVec3; 2] {
    let places = mesh.vertices.iter().copied();
    [
        places.clone().fold(DVec3::INFINITY, DVec3::min),
        places.fold(DVec3::NEG_INFINITY, DVec3::max),
    ]
}

/// An L of 8 m by 7 m with arms of 3 m, from −1 m to 5 m.
const TOWER_M3: f64 = 36.0 * 6.0;
const TOWER: [DVec3; 2] = [DVec3::new(0.0, 0.0, -1.0), DVec3::new(8.0, 7.0, 5.0)];

#[test]
fn each_file_is_the_same_closed_tower() {
    for (name, warned) in [
        ("triangle_strip.glb", None),
        ("sparse_accessor.glb", None),
        ("data_uri_buffer.glb", None),
        (
            "basisu_required.glb",
            Some("extensionsRequired[0]: KHR_texture_basisu says nothing of where triangles are"),
        ),
        (
            "unlit_required.glb",
            Some("extensionsRequired[0]: KHR_materials_unlit says nothing of where triangles are"),
        ),
        ("concave_cap.obj", None),
        ("line_continuation.obj", None),
        (
            "degenerate_faces.obj",
            Some(
                "object \"tower\": 2 faces that name a vertex twice have no area, and are left out",
            ),
        ),
        ("bom_before_first_vertex.obj", None),
    ] {
        let ModelFile { mesh, warnings } = case(name);
        assert_eq!(verdict(&mesh).to_string(), "closed", "{name}");
        assert!(
            (volume(&mesh) - TOWER_M3).abs() < 1e-6,
            "{name}: {}",
            volume(&mesh)
        );
        assert_eq!(bounds(&mesh), TOWER, "{name}");
        match (warned, warnings.as_slice()) {
            (None, []) => {}
            (Some(words), [warning]) => assert!(warning.starts_with(words), "{warning}"),
            (_, found) => panic!("{name}: {found:?}"),
        }
    }
}

#[test]
fn a_skinned_mesh_stands_where_its_joints_do() {
    let control = case("skinned_control.obj").mesh;
    let skinned = case("skinned_node_scale.glb");
    assert_eq!(skinned.mesh.casters.len(), control.casters.len());
    assert_eq!(bounds(&skinned.mesh), bounds(&control));
    assert!((volume(&skinned.mesh) - 2.0 * TOWER_M3).abs() < 1e-6);
    assert_eq!(verdict(&skinned.mesh).to_string(), "closed");
    let [warning] = skinned.warnings.as_slice() else {
        panic!("one, found {:?}", skinned.warnings);
    };
    assert!(warning.starts_with("nodes[1]: a skinned mesh; it stands as its joints do at rest"));
    // Control: the node's own scale would make it a hundred times as large.
    assert!((bounds(&control)[1].x - 28.0).abs() < 1e-9);
}
