// SPDX-License-Identifier: MIT OR Apache-2.0
//! GLB by `gltf`, whose checks of the JSON come first; bytes are read here, within the bounds they say.
//!
//! Every node of the scene that has a mesh is a model, its triangles moved by the node's transform in
//! `f64`. A skinned mesh is where its joints are, whatever its own node says (glTF 2.0, §3.7.3.3). Animations are not
//! played: joints and morph targets are as the file has them at rest.

mod accessors;
mod extensions;
mod skin;

use self::accessors::{Accessors, buffers};
use super::model::{Contents, Model, Wrong, wrong};
use glam::{DMat4, DQuat, DVec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::scene::Transform;
use gltf::{Document, Gltf, Node, Semantic};

/// What numbers of places may be by `KHR_mesh_quantization`.
const QUANTIZED: [DataType; 5] = [
    DataType::F32,
    DataType::I8,
    DataType::U8,
    DataType::I16,
    DataType::U16,
];
/// Bytes of the file's header: magic, version, length.
const HEADER_BYTES: usize = 12;
/// Vertices, and corners of triangles, of all models together: nodes may repeat a mesh, so that a small file has many.
const MAX_VERTICES: usize = 1 << 25;
const MAX_CORNERS: usize = 1 << 26;

pub(super) fn read(bytes: &[u8]) -> Result<Contents, Wrong> {
    check_header(bytes)?;
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(refused)?;
    let mut json = document.into_json();
    let mut contents = Contents::default();
    let is_quantized = extensions::check(&json, &mut contents.warnings)?;
    check_attributes(&json)?;
    // `gltf` would refuse any that it does not read itself.
    json.extensions_required.clear();
    let document = Document::from_json(json).map_err(refused)?;
    let bin = blob.unwrap_or_default();
    let buffers = buffers(&document, &bin)?;
    let roots = roots(&document, &mut contents.warnings);
    let nodes = placed(&document, roots)?;
    let mut walk = Walk {
        accessors: Accessors {
            buffers: &buffers,
            file_bytes: bytes.len(),
        },
        is_quantized,
        nodes: &nodes,
        vertices: 0,
        corners: 0,
        contents,
    };
    for (node, scene_from_node) in &nodes {
        walk.node(node, *scene_from_node)?;
    }
    Ok(walk.contents)
}

/// Nodes of the default scene that are below no other; of the first one where no scene is the default; of the whole file
/// where there is no scene.
fn roots<'a>(document: &'a Document, warnings: &mut Vec<String>) -> Vec<Node<'a>> {
    if let Some(scene) = document.default_scene() {
        return scene.nodes().collect();
    }
    let count = document.scenes().count();
    if let Some(scene) = document.scenes().next() {
        if count > 1 {
            warnings.push(format!(
                "scenes: {count}, and none is the default; the first is read"
            ));
        }
        return scene.nodes().collect();
    }
    warnings.push("scenes: none; every node that is below no other is read".to_owned());
    let mut is_below = vec![false; document.nodes().len()];
    for child in document
        .nodes()
        .flat_map(|node| node.children().collect::<Vec<_>>())
    {
        is_below[child.index()] = true;
    }
    let roots = document.nodes().filter(|node| !is_below[node.index()]);
    roots.collect()
}

/// Every node below these with its transform to the scene, parents before children.
fn placed<'a>(document: &Document, roots: Vec<Node<'a>>) -> Result<Vec<(Node<'a>, DMat4)>, Wrong> {
    let mut is_met = vec![false; document.nodes().len()];
    let mut placed = Vec::new();
    let mut waiting: Vec<(Node<'a>, DMat4)> = Vec::new();
    waiting.extend(roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)));
    while let Some((node, above)) = waiting.pop() {
        if std::mem::replace(&mut is_met[node.index()], true) {
            let element = format!("nodes[{}]", node.index());
            return Err(wrong(element, "a node below itself or below two", "a tree"));
        }
        let scene_from_node = above * matrix(node.transform());
        let children: Vec<Node<'a>> = node.children().collect();
        waiting.extend(
            children
                .into_iter()
                .rev()
                .map(|child| (child, scene_from_node)),
        );
        placed.push((node, scene_from_node));
    }
    Ok(placed)
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

/// `gltf-json` 1.4.1 checks the bounds of positions before it knows that there is such an accessor, and panics.
fn check_attributes(json: &gltf::json::Root) -> Result<(), Wrong> {
    let count = json.accessors.len();
    for (mesh, own) in json.meshes.iter().enumerate() {
        for (at, primitive) in own.primitives.iter().enumerate() {
            let mut indices = primitive.attributes.values().map(|index| index.value());
            if let Some(found) = indices.find(|index| *index >= count) {
                let element = format!("meshes[{mesh}].primitives[{at}].attributes");
                let allowed = format!("below {count}, the accessors");
                return Err(wrong(element, format!("accessor {found}"), allowed));
            }
        }
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
    accessors: Accessors<'a>,
    /// Whether places may be whole numbers.
    is_quantized: bool,
    nodes: &'a [(Node<'a>, DMat4)],
    vertices: usize,
    corners: usize,
    contents: Contents,
}

impl Walk<'_> {
    fn node(&mut self, node: &Node<'_>, scene_from_node: DMat4) -> Result<(), Wrong> {
        let Some(mesh) = node.mesh() else {
            return Ok(());
        };
        let element = format!("nodes[{}]", node.index());
        let name = node.name().or_else(|| mesh.name()).map(str::to_owned);
        let mut model = Model {
            name: name.unwrap_or_else(|| element.clone()),
            ..Model::default()
        };
        let joints = match node.skin() {
            Some(skin) => Some(skin::joints(&skin, self.nodes, &self.accessors)?),
            None => None,
        };
        if joints.is_some() {
            self.contents.warnings.push(format!(
                "{element}: a skinned mesh; it stands as its joints do at rest, and its own node moves it nowhere"
            ));
        }
        let weights = node.weights().or_else(|| mesh.weights()).unwrap_or(&[]);
        let mut degenerate = 0;
        for primitive in mesh.primitives() {
            let own = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
            let first = model.places.len();
            degenerate += self.primitive(&mut model, &primitive, weights, &own)?;
            let places = &mut model.places[first..];
            match &joints {
                Some(joints) => skin::pose(places, &primitive, joints, &self.accessors)?,
                None => {
                    for place in places {
                        let moved = scene_from_node.transform_point3(DVec3::from(*place));
                        *place = moved.to_array();
                    }
                }
            }
        }
        // A mirror turns faces over; so does their order, back.
        let first = joints.as_ref().and_then(|joints| joints.first());
        if first.unwrap_or(&scene_from_node).determinant() < 0.0 {
            for corners in &mut model.triangles {
                corners.swap(1, 2);
            }
        }
        self.contents.warn_degenerate(&model.name, degenerate);
        self.contents.models.push(model);
        Ok(())
    }

    /// Adds a primitive's triangles, its places as the mesh has them: one solid may have several, each of a material.
    ///
    /// - returns: triangles that were left out since they have no area
    fn primitive(
        &mut self,
        model: &mut Model,
        primitive: &gltf::Primitive<'_>,
        weights: &[f32],
        element: &str,
    ) -> Result<usize, Wrong> {
        if let Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip = primitive.mode() {
            return Ok(0);
        }
        let positions = primitive.get(&Semantic::Positions);
        let positions = positions
            .ok_or_else(|| wrong(format!("{element}.attributes"), "no POSITION", "POSITION"))?;
        let count = positions.count();
        self.vertices = self.vertices.saturating_add(count);
        if self.vertices > MAX_VERTICES {
            let allowed = format!("{MAX_VERTICES} in all nodes together");
            return Err(wrong(
                format!("{element}.attributes"),
                self.vertices,
                allowed,
            ));
        }
        let kinds: &[DataType] = if self.is_quantized {
            &QUANTIZED
        } else {
            &[DataType::F32]
        };
        let first = model.places.len();
        let places = self
            .accessors
            .numbers(&positions, kinds, Dimensions::Vec3)?;
        model
            .places
            .extend(places.chunks_exact(3).map(|own| [own[0], own[1], own[2]]));
        for (target, weight) in primitive.morph_targets().zip(weights) {
            let Some(moves) = target.positions().filter(|_| *weight != 0.0) else {
                continue;
            };
            let moves = self.accessors.numbers(&moves, kinds, Dimensions::Vec3)?;
            for (place, by) in model.places[first..].iter_mut().zip(moves.chunks_exact(3)) {
                *place = [0, 1, 2].map(|axis| place[axis] + f64::from(*weight) * by[axis]);
            }
        }
        let (corners, of) = if let Some(indices) = primitive.indices() {
            let of = format!("accessors[{}]", indices.index());
            (self.accessors.indices(&indices)?, of)
        } else {
            let past = u32::try_from(count).unwrap_or(u32::MAX);
            let of = format!("accessors[{}]", positions.index());
            ((0..past).collect(), of)
        };
        self.corners = self.corners.saturating_add(corners.len());
        if self.corners > MAX_CORNERS {
            let allowed = format!("{MAX_CORNERS} in all nodes together");
            return Err(wrong(of, format!("{} corners", self.corners), allowed));
        }
        if let Some(at) = corners.iter().position(|corner| *corner as usize >= count) {
            let found = format!("index {} at {at}", corners[at]);
            return Err(wrong(of, found, format!("below {count}, its vertices")));
        }
        let is_list = primitive.mode() == Mode::Triangles;
        if is_list && !corners.len().is_multiple_of(3) {
            let found = format!("{} corners", corners.len());
            return Err(wrong(of, found, "3 for each triangle"));
        }
        let all = triangles(primitive.mode(), &corners);
        let has_area = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        let solid: Vec<[u32; 3]> = all.iter().copied().filter(has_area).collect();
        let first = u32::try_from(first).unwrap_or(u32::MAX);
        let moved = |corners: &[u32; 3]| corners.map(|corner| corner.saturating_add(first));
        model.triangles.extend(solid.iter().map(moved));
        // A strip has them where it turns.
        Ok(if is_list { all.len() - solid.len() } else { 0 })
    }
}

/// As glTF 2.0, §3.7.2.1, numbers them.
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let all = corners.windows(3).enumerate();
            let own = |(at, own): (usize, &[u32])| match at % 2 {
                0 => [own[0], own[1], own[2]],
                _ => [own[0], own[2], own[1]],
            };
            all.map(own).collect()
        }
        Mode::TriangleFan => {
            let all = corners.get(1..).unwrap_or_default().windows(2);
            all.map(|own| [own[0], own[1], corners[0]]).collect()
        }
        _ => {
            let all = corners.chunks_exact(3);
            all.map(|own| [own[0], own[1], own[2]]).collect()
        }
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

    fn text_of(read: Result<Contents, Wrong>) -> String {
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
        let models = read(&glb(JSON, &bin())).expect("a tetrahedron").models;
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
                r#""POSITION":0"#,
                r#""POSITION":7"#,
                "meshes[0].primitives[0].attributes: found accessor 7, allowed: below 2, the accessors",
            ),
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
                 allowed: what lies in its 72 bytes",
            ),
            (
                r#""count":4"#,
                r#""count":18446744073709551615"#,
                "attributes: found 18446744073709551615, allowed: 33554432 in all nodes together",
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
                "accessors[1]: found Scalar of F32, allowed: Scalar of U8, U16, U32",
            ),
            (
                r#""asset""#,
                r#""extensionsRequired":["KHR_draco_mesh_compression"],"asset""#,
                "extensionsRequired[0]: found KHR_draco_mesh_compression, allowed: plain triangles: `gltf-pipeline",
            ),
            (
                r#""mesh":0,"#,
                r#""mesh":0,"children":[0],"#,
                "found a node below itself or below two, allowed: a tree",
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

    /// The tetrahedron's volume and its highest place.
    fn volume_and_top(contents: &Contents) -> (f64, f64) {
        let [model] = contents.models.as_slice() else {
            panic!("one model, found {:?}", contents.models);
        };
        let volumes = model.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|at| DVec3::from(model.places[at as usize]));
            a.dot(b.cross(c)) / 6.0
        });
        let top = model
            .places
            .iter()
            .map(|place| place[2])
            .fold(0.0, f64::max);
        (volumes.sum(), top)
    }

    fn near((volume, top): (f64, f64), expected: (f64, f64)) {
        let is_near = (volume - expected.0).abs() < 1e-9 && (top - expected.1).abs() < 1e-9;
        assert!(is_near, "{volume} {top}, not {expected:?}");
    }

    #[test]
    fn fans_scenes_that_are_missing_and_targets_are_read() {
        let plain = read(&glb(JSON, &bin())).expect("read");
        near(volume_and_top(&plain), (8.0 / 6.0, 12.0));
        assert!(plain.warnings.is_empty(), "{:?}", plain.warnings);
        // A fan around corner 0 of the three other faces; the fourth, below it, is missing.
        let mut fan = bin();
        let corners: [u16; 5] = [3, 1, 2, 0, 1];
        fan.truncate(48);
        fan.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
        fan.resize(72, 0);
        let json = JSON
            .replace(r#""mode":4"#, r#""mode":6"#)
            .replace(r#""count":12"#, r#""count":5"#);
        let found = read(&glb(&json, &fan)).expect("a fan");
        // Mirrored as the node is.
        assert_eq!(found.models[0].triangles, [[1, 3, 2], [2, 3, 0], [0, 3, 1]]);
        let json = JSON.replace(r#""scene":0,"scenes":[{"nodes":[0]}],"#, "");
        let found = read(&glb(&json, &bin())).expect("no scene");
        near(volume_and_top(&found), (8.0 / 6.0, 12.0));
        assert_eq!(
            found.warnings,
            ["scenes: none; every node that is below no other is read"]
        );
        // Twice the places, added half.
        let json = JSON.replace(r#""mode":4"#, r#""mode":4,"targets":[{"POSITION":0}]"#);
        let json = json.replace(r#""primitives""#, r#""weights":[0.5],"primitives""#);
        let found = read(&glb(&json, &bin())).expect("a target");
        near(volume_and_top(&found), (8.0 / 6.0 * 1.5_f64.powi(3), 13.0));
        // Control: a weight of 0 adds nothing.
        let found = read(&glb(&json.replace("[0.5]", "[0]"), &bin())).expect("a target");
        near(volume_and_top(&found), (8.0 / 6.0, 12.0));
    }

    #[test]
    fn whole_numbers_are_places_where_the_extension_says_so() {
        let mut bytes = Vec::new();
        for place in [
            [0_u16, 0, 0],
            [65_535, 0, 0],
            [0, 65_535, 0],
            [0, 0, 65_535],
        ] {
            let place = place.iter().chain(&[0]);
            bytes.extend(place.flat_map(|value| value.to_le_bytes()));
        }
        bytes.extend(&bin()[48..]);
        let json = JSON
            .replace(
                r#""asset""#,
                r#""extensionsRequired":["KHR_mesh_quantization"],"asset""#,
            )
            .replace(r#"5126,"count":4"#, r#"5123,"normalized":true,"count":4"#)
            .replace(r#""byteLength":48}"#, r#""byteLength":32,"byteStride":8}"#)
            .replace(r#""byteOffset":48"#, r#""byteOffset":32"#)
            .replace(r#"[{"byteLength":72}]"#, r#"[{"byteLength":56}]"#);
        let found = read(&glb(&json, &bytes)).expect("quantized");
        near(volume_and_top(&found), (1.0 / 6.0, 11.0));
        let signed = json.replace("5123,\"normalized\":true", "5122");
        let found = read(&glb(&signed, &bytes)).expect("quantized");
        near(volume_and_top(&found), (-1.0 / 6.0, 10.0));
        // Control: without the extension core glTF 2.0 has no such places.
        let core = json.replace(r#""extensionsRequired":["KHR_mesh_quantization"],"#, "");
        assert_eq!(
            text_of(read(&glb(&core, &bytes))),
            "accessors[0]: found Vec3 of U16, allowed: Vec3 of F32"
        );
    }

    #[test]
    fn extensions_are_refused_said_or_passed_by_what_they_touch() {
        let with = |key: &str, name: &str| {
            let json = JSON.replace(r#""asset""#, &format!(r#""{key}":["{name}"],"asset""#));
            read(&glb(&json, &bin()))
        };
        for name in [
            "KHR_materials_variants",
            "KHR_texture_basisu",
            "EXT_texture_webp",
        ] {
            let found = with("extensionsRequired", name).expect(name);
            assert_eq!(
                found.warnings,
                [format!(
                    "extensionsRequired[0]: {name} says nothing of where triangles are, and is not read"
                )]
            );
            assert!(
                with("extensionsUsed", name)
                    .expect(name)
                    .warnings
                    .is_empty()
            );
        }
        for (key, name) in [
            ("extensionsRequired", "EXT_meshopt_compression"),
            ("extensionsRequired", "VENDOR_anything"),
            ("extensionsUsed", "EXT_mesh_gpu_instancing"),
        ] {
            let text = text_of(with(key, name));
            assert!(
                text.starts_with(&format!("{key}[0]: found {name}, allowed: ")),
                "{text}"
            );
        }
        let found = with("extensionsUsed", "VENDOR_anything").expect("read");
        assert_eq!(
            found.warnings,
            ["extensionsUsed[0]: VENDOR_anything is not known, and what it says is not read"]
        );
    }

    #[test]
    fn buffers_elsewhere_and_nodes_met_twice_are_refused() {
        let json = JSON.replace(
            r#"{"byteLength":72}"#,
            r#"{"byteLength":72,"uri":"hull.bin"}"#,
        );
        let text = text_of(read(&glb(&json, &bin())));
        assert!(
            text.starts_with("buffers[0].uri: found \"hull.bin\", allowed: the file's own bytes"),
            "{text}"
        );
        // Thirty levels of two equal children would be a thousand million nodes.
        let twice = JSON.replace(r#""children":[1]"#, r#""children":[1,1]"#);
        let text = text_of(read(&glb(&twice, &bin())));
        assert_eq!(
            text,
            "nodes[1]: found a node below itself or below two, allowed: a tree"
        );
    }
}
