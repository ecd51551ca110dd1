// SPDX-License-Identifier: MIT OR Apache-2.0
//! GLB by `gltf`, whose checks of the JSON come first; bytes are read here, within the bounds they say.
//!
//! Every node of the scene that has a mesh is a model, its triangles moved by the node's transform in
//! `f64`. Skins and morph targets are taken at rest.

use super::model::{Model, Wrong, wrong};
use glam::{DMat4, DQuat, DVec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::scene::Transform;
use gltf::{Accessor, Document, Gltf, Node, Semantic};

/// Bytes of the file's header: magic, version, length.
const HEADER_BYTES: usize = 12;

pub(super) fn read(bytes: &[u8]) -> Result<Vec<Model>, Wrong> {
    check_header(bytes)?;
    let Gltf { document, blob } = Gltf::from_slice(bytes).map_err(refused)?;
    let blob = blob.unwrap_or_default();
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| wrong("scenes", 0, "at least 1"))?;
    let mut walk = Walk {
        document: &document,
        blob: &blob,
        models: Vec::new(),
    };
    for node in scene.nodes() {
        walk.node(&node, DMat4::IDENTITY, 0)?;
    }
    Ok(walk.models)
}

/// `gltf` takes the header's length as it is, and subtracts from it.
fn check_header(bytes: &[u8]) -> Result<(), Wrong> {
    let magic = bytes.get(..4).unwrap_or(bytes);
    if magic != b"glTF" {
        let found = format!("{:?}", String::from_utf8_lossy(magic));
        return Err(wrong("first bytes", found, "\"glTF\""));
    }
    let word = |at: usize| {
        let bytes = bytes.get(at..at + 4)?;
        bytes.try_into().ok().map(u32::from_le_bytes)
    };
    let (version, length) = (word(4).unwrap_or(0), word(8).unwrap_or(0));
    if version != 2 {
        return Err(wrong("version", version, "2"));
    }
    if length as usize != bytes.len() || bytes.len() < HEADER_BYTES {
        return Err(wrong(
            "length",
            bytes.len(),
            format!("{length}, as its header says"),
        ));
    }
    Ok(())
}

fn refused(error: gltf::Error) -> Wrong {
    match error {
        gltf::Error::Validation(all) => match all.into_iter().next() {
            Some((path, error)) => wrong(path.as_str(), error, "what glTF 2.0 has there"),
            None => wrong("JSON", "a fault", "glTF 2.0"),
        },
        gltf::Error::Deserialize(error) => wrong("JSON", error, "glTF 2.0"),
        other => wrong("chunks", other, "JSON, then BIN"),
    }
}

struct Walk<'a> {
    document: &'a Document,
    blob: &'a [u8],
    models: Vec<Model>,
}

impl Walk<'_> {
    fn node(&mut self, node: &Node<'_>, above: DMat4, depth: usize) -> Result<(), Wrong> {
        let element = || format!("nodes[{}]", node.index());
        if depth >= self.document.nodes().len() {
            return Err(wrong(element(), "a node below itself", "a tree"));
        }
        let scene_from_node = above * matrix(node.transform());
        if let Some(mesh) = node.mesh() {
            let name = node.name().or_else(|| mesh.name()).map(str::to_owned);
            let mut model = Model {
                name: name.unwrap_or_else(element),
                ..Model::default()
            };
            for primitive in mesh.primitives() {
                let own = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
                self.primitive(&mut model, &primitive, &own)?;
            }
            // A mirror turns faces over; so does their order, back.
            if scene_from_node.determinant() < 0.0 {
                for corners in &mut model.triangles {
                    corners.swap(1, 2);
                }
            }
            for place in &mut model.places {
                *place = scene_from_node
                    .transform_point3(DVec3::from(*place))
                    .to_array();
            }
            self.models.push(model);
        }
        for child in node.children() {
            self.node(&child, scene_from_node, depth + 1)?;
        }
        Ok(())
    }

    /// Adds a primitive's triangles: one solid may have several, each of a material.
    fn primitive(
        &self,
        model: &mut Model,
        primitive: &gltf::Primitive<'_>,
        element: &str,
    ) -> Result<(), Wrong> {
        match primitive.mode() {
            Mode::Triangles => {}
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => return Ok(()),
            other => {
                return Err(wrong(
                    format!("{element}.mode"),
                    format!("{other:?}"),
                    "Triangles",
                ));
            }
        }
        let positions = primitive.get(&Semantic::Positions);
        let positions = positions
            .ok_or_else(|| wrong(format!("{element}.attributes"), "no POSITION", "POSITION"))?;
        let first = model.places.len();
        let form = (DataType::F32, Dimensions::Vec3);
        let places = self.items(&positions, form)?;
        model.places.extend(places.map(|bytes| {
            let number = |at: usize| {
                let bytes = bytes[4 * at..].first_chunk().copied();
                f64::from(f32::from_le_bytes(bytes.unwrap_or_default()))
            };
            [number(0), number(1), number(2)]
        }));
        let count = model.places.len() - first;
        let (corners, of) = match primitive.indices() {
            Some(indices) => {
                let kind = indices.data_type();
                if !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
                    let element = format!("accessors[{}]", indices.index());
                    return Err(wrong(element, format!("{kind:?}"), "U8, U16 or U32"));
                }
                let all = self.items(&indices, (kind, Dimensions::Scalar))?;
                let number = |bytes: &[u8]| {
                    let bytes = bytes.iter().rev();
                    bytes.fold(0_u32, |number, byte| number << 8 | u32::from(*byte))
                };
                let all: Vec<u32> = all.map(number).collect();
                (all, format!("accessors[{}]", indices.index()))
            }
            None => {
                let past = u32::try_from(count).unwrap_or(u32::MAX);
                (
                    (0..past).collect(),
                    format!("accessors[{}]", positions.index()),
                )
            }
        };
        if corners.len() % 3 != 0 {
            let found = format!("{} corners", corners.len());
            return Err(wrong(of, found, "3 for each triangle"));
        }
        if let Some(at) = corners.iter().position(|corner| *corner as usize >= count) {
            let found = format!("index {} at {at}", corners[at]);
            return Err(wrong(of, found, format!("below {count}, its vertices")));
        }
        let first = u32::try_from(first).unwrap_or(u32::MAX);
        let triangles = corners.chunks_exact(3);
        let triangles = triangles.map(|own| [own[0], own[1], own[2]]);
        let moved = |corners: [u32; 3]| corners.map(|corner| corner.saturating_add(first));
        model.triangles.extend(triangles.map(moved));
        Ok(())
    }

    /// Bytes of each item of an accessor.
    fn items(
        &self,
        accessor: &Accessor<'_>,
        form: (DataType, Dimensions),
    ) -> Result<impl Iterator<Item = &[u8]>, Wrong> {
        let element = format!("accessors[{}]", accessor.index());
        let found = (accessor.data_type(), accessor.dimensions());
        if found != form {
            let [found, allowed] = [found, form].map(|(kind, of)| format!("{of:?} of {kind:?}"));
            return Err(wrong(element, found, allowed));
        }
        if accessor.sparse().is_some() {
            return Err(wrong(element, "sparse values", "values in a buffer view"));
        }
        let view = accessor.view();
        let view = view.ok_or_else(|| wrong(element.as_str(), "no buffer view", "one"))?;
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        let count = accessor.count();
        let bytes = || -> Option<&[u8]> {
            let start = view.offset();
            let view = self.blob.get(start..start.checked_add(view.length())?)?;
            let last = stride.checked_mul(count.checked_sub(1)?)?;
            let past = accessor.offset().checked_add(last)?.checked_add(size)?;
            view.get(accessor.offset()..past)
        };
        // Another buffer than the file's own would be another file.
        let bytes = bytes().filter(|_| view.buffer().index() == 0 && stride >= size);
        let bytes = bytes.ok_or_else(|| {
            let found = format!(
                "{count} items of {size} bytes, {stride} apart, from byte {} of bufferViews[{}] in buffers[{}]",
                accessor.offset(),
                view.index(),
                view.buffer().index()
            );
            let allowed = format!("what lies in the {} bytes of BIN", self.blob.len());
            wrong(element.as_str(), found, allowed)
        })?;
        Ok((0..count).map(move |at| &bytes[at * stride..at * stride + size]))
    }
}

fn matrix(transform: Transform) -> DMat4 {
    match transform {
        Transform::Matrix { matrix } => {
            DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
        }
        Transform::Decomposed {
            translation,
            rotation,
            scale,
        } => DMat4::from_scale_rotation_translation(
            scale.map(f64::from).into(),
            DQuat::from_array(rotation.map(f64::from)).normalize(),
            translation.map(f64::from).into(),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron of 2 m: four corners, then twelve indices of 16 bits.
    fn bin() -> Vec<u8> {
        let places: [[f32; 3]; 4] = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]];
        let corners: [u16; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
        let places = places
            .iter()
            .flatten()
            .flat_map(|value| value.to_le_bytes());
        let corners = corners.iter().flat_map(|corner| corner.to_le_bytes());
        places.chain(corners).collect()
    }

    const JSON: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"name":"above","translation":[0,0,10],"children":[1]},
                 {"name":"hull","mesh":0,"scale":[-1,1,1]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":4}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",
                      "min":[0,0,0],"max":[2,2,2]},
                     {"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],
        "buffers":[{"byteLength":72}]}"#;

    fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
        let json = format!("{json}{}", " ".repeat((4 - json.len() % 4) % 4));
        let word = |length: usize| u32::try_from(length).expect("small").to_le_bytes();
        let mut bytes = b"glTF".to_vec();
        bytes.extend(word(2));
        bytes.extend(word(12 + 8 + json.len() + 8 + bin.len()));
        bytes.extend(word(json.len()));
        bytes.extend(b"JSON");
        bytes.extend(json.bytes());
        bytes.extend(word(bin.len()));
        bytes.extend(b"BIN\0");
        bytes.extend(bin);
        bytes
    }

    fn text_of(read: Result<Vec<Model>, Wrong>) -> String {
        match read {
            Ok(_) => "read".to_owned(),
            Err(Wrong {
                element,
                found,
                allowed,
            }) => {
                format!("{element}: found {found}, allowed: {allowed}")
            }
        }
    }

    #[test]
    fn nodes_move_their_meshes_and_a_mirror_keeps_faces_outwards() {
        let models = read(&glb(JSON, &bin())).expect("a tetrahedron");
        let [hull] = models.as_slice() else {
            panic!("one model, found {models:?}");
        };
        assert_eq!(hull.name, "hull");
        assert_eq!(
            hull.places[1..],
            [[-2.0, 0.0, 10.0], [0.0, 2.0, 10.0], [0.0, 0.0, 12.0]]
        );
        let volume = |model: &Model| {
            let triangles = model.triangles.iter().map(|corners| {
                let [a, b, c] = corners.map(|at| DVec3::from(model.places[at as usize]));
                a.dot(b.cross(c)) / 6.0
            });
            triangles.sum::<f64>()
        };
        assert!((volume(hull) - 8.0 / 6.0).abs() < 1e-12, "{}", volume(hull));
        // Without indices corners follow one another: three of the four are a triangle too many.
        let loose = JSON.replace(r#","indices":1"#, "");
        assert_eq!(
            text_of(read(&glb(&loose, &bin()))),
            "accessors[0]: found 4 corners, allowed: 3 for each triangle"
        );
    }

    #[test]
    fn each_broken_element_is_named_with_what_is_allowed() {
        for (from, to, message) in [
            (
                r#""indices":1"#,
                r#""indices":7"#,
                "indices: found Index out of bounds",
            ),
            (
                r#""count":12"#,
                r#""count":11"#,
                "accessors[1]: found 11 corners, allowed: 3 for each triangle",
            ),
            (
                r#""count":12"#,
                r#""count":15"#,
                "accessors[1]: found 15 items of 2 bytes, 2 apart, from byte 0 of bufferViews[1] in buffers[0], \
                 allowed: what lies in the 72 bytes of BIN",
            ),
            (
                r#""count":4"#,
                r#""count":18446744073709551615"#,
                "allowed: what lies in the 72 bytes of BIN",
            ),
            (r#""count":4"#, r#""count":0"#, "accessors[0]"),
            (
                r#""byteLength":48"#,
                r#""byteLength":24"#,
                "accessors[0]: found 4 items of 12 bytes, 12 apart",
            ),
            (
                r#"5126,"count":4,"type":"VEC3""#,
                r#"5121,"count":4,"type":"VEC3""#,
                "accessors[0]: found Vec3 of U8, allowed: Vec3 of F32",
            ),
            (
                r#"5123"#,
                r#"5126"#,
                "accessors[1]: found F32, allowed: U8, U16 or U32",
            ),
            (
                r#""mode":4"#,
                r#""mode":5"#,
                "meshes[0].primitives[0].mode: found TriangleStrip, allowed: Triangles",
            ),
            (
                r#""asset""#,
                r#""extensionsRequired":["KHR_draco_mesh_compression"],"asset""#,
                "extensionsRequired[0] = \"KHR_draco_mesh_compression\": found Unsupported extension",
            ),
            (
                r#""scene":0,"scenes":[{"nodes":[0]}],"#,
                "",
                "scenes: found 0, allowed: at least 1",
            ),
            (
                r#""mesh":0,"#,
                r#""mesh":0,"children":[0],"#,
                "found a node below itself, allowed: a tree",
            ),
            (r#"{"asset""#, r#"["asset""#, "JSON: found "),
        ] {
            assert!(JSON.contains(from), "{from}");
            let text = text_of(read(&glb(&JSON.replacen(from, to, 1), &bin())));
            assert!(text.contains(message), "{text}\n{message}");
        }
        let mut far = bin();
        far[48] = 4;
        assert_eq!(
            text_of(read(&glb(JSON, &far))),
            "accessors[1]: found index 4 at 0, allowed: below 4, its vertices"
        );
    }

    #[test]
    fn headers_that_lie_are_refused_whatever_they_say() {
        let whole = glb(JSON, &bin());
        assert_eq!(text_of(read(&whole)), "read");
        for cut in 0..whole.len() {
            assert_ne!(text_of(read(&whole[..cut])), "read", "{cut}");
        }
        for length in [0_u32, 5, 11, 12, 20, 4_000_000_000] {
            let mut bytes = whole.clone();
            bytes[8..12].copy_from_slice(&length.to_le_bytes());
            assert!(
                text_of(read(&bytes)).contains("as its header says"),
                "{length}"
            );
            // The chunk's own length.
            let mut bytes = whole.clone();
            bytes[12..16].copy_from_slice(&length.to_le_bytes());
            assert_ne!(text_of(read(&bytes)), "read", "{length}");
        }
        let mut old = whole;
        old[4] = 1;
        assert_eq!(text_of(read(&old)), "version: found 1, allowed: 2");
    }
}
