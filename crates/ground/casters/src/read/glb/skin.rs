// SPDX-License-Identifier: MIT OR Apache-2.0
//! Skinned meshes at rest: each vertex moves with its joints, by their weights (glTF 2.0, §3.7.3).

use super::accessors::Accessors;
use crate::read::model::{Wrong, wrong};
use glam::{DMat4, DVec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::{Node, Primitive, Semantic, Skin};

/// Transforms from a mesh at its binding to the scene, one for each joint.
///
/// - `nodes`: of the scene, with their transforms to it
pub(super) fn joints(
    skin: &Skin<'_>,
    nodes: &[(Node<'_>, DMat4)],
    accessors: &Accessors<'_>,
) -> Result<Vec<DMat4>, Wrong> {
    let element = || format!("skins[{}]", skin.index());
    let joints: Vec<usize> = skin.joints().map(|joint| joint.index()).collect();
    let bindings = match skin.inverse_bind_matrices() {
        Some(matrices) => accessors.numbers(&matrices, &[DataType::F32], Dimensions::Mat4)?,
        None => DMat4::IDENTITY.to_cols_array().repeat(joints.len()),
    };
    let mut bindings = bindings.chunks_exact(16);
    let transforms = joints.into_iter().map(|joint| {
        let node = nodes.iter().find(|(node, _)| node.index() == joint);
        let (_, scene_from_joint) = node.ok_or_else(|| {
            let found = format!("joint nodes[{joint}], which is in no scene that is read");
            wrong(element(), found, "joints of the scene")
        })?;
        let binding = bindings.next().and_then(|matrix| matrix.try_into().ok());
        let binding: [f64; 16] = binding.ok_or_else(|| {
            wrong(
                element(),
                "fewer inverse bind matrices",
                "one for each joint",
            )
        })?;
        Ok(*scene_from_joint * DMat4::from_cols_array(&binding))
    });
    transforms.collect()
}

/// Moves a primitive's places from its binding to the scene.
pub(super) fn pose(
    places: &mut [[f64; 3]],
    primitive: &Primitive<'_>,
    joints: &[DMat4],
    accessors: &Accessors<'_>,
) -> Result<(), Wrong> {
    let mut moved = vec![DVec3::ZERO; places.len()];
    let mut sums = vec![0.0; places.len()];
    let whole = [DataType::U8, DataType::U16];
    let shares = [DataType::F32, DataType::U8, DataType::U16];
    let mut set = 0;
    while let (Some(indices), Some(weights)) = (
        primitive.get(&Semantic::Joints(set)),
        primitive.get(&Semantic::Weights(set)),
    ) {
        let element = || format!("accessors[{}]", indices.index());
        let own = accessors.numbers(&indices, &whole, Dimensions::Vec4)?;
        let weights = accessors.numbers(&weights, &shares, Dimensions::Vec4)?;
        for (at, (joint, weight)) in own.iter().zip(weights).enumerate() {
            let (Some(place), true) = (places.get(at / 4), weight != 0.0) else {
                continue;
            };
            #[allow(clippy::cast_possible_truncation, reason = "a whole number of 16 bits")]
            let transform = joints.get(*joint as usize).ok_or_else(|| {
                let allowed = format!("below {}, the joints of its skin", joints.len());
                wrong(element(), format!("joint {joint}"), allowed)
            })?;
            moved[at / 4] += weight * transform.transform_point3(DVec3::from(*place));
            sums[at / 4] += weight;
        }
        set += 1;
    }
    for (vertex, place) in places.iter_mut().enumerate() {
        let sum: f64 = sums[vertex];
        if sum.is_nan() || sum <= 0.0 {
            let element = format!("vertex {vertex} of a skinned mesh");
            return Err(wrong(element, format!("weights of {sum}"), "above 0"));
        }
        *place = (moved[vertex] / sum).to_array();
    }
    Ok(())
}
