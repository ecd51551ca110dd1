// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which vertex shaders place what they draw by the shared step to clip space, and whether their positions are
//! invariant.
//!
//! A surface and the caps of volumes that lie on it are drawn by different shaders and meet in the depth test.
//! Without `@invariant` a compiler may fuse one shader's steps and not the other's. On an NVIDIA H200 that turned
//! 57–72 pixels of each of 100 pictures of shadows; lavapipe showed none of it.

use naga::{
    Binding, Block, BuiltIn, EntryPoint, Handle, Module, ShaderStage, Statement, TypeInner,
};

/// The function in `shaders/shared/view.wgsl` by which positions come to clip space.
const TO_CLIP: &str = "clip_from_eye_relative";

/// Entry points of a validated module that place vertices by the shared step and may place them a rounding apart.
pub(crate) fn variant_positions(module: &Module) -> Vec<&str> {
    let mut functions = module.functions.iter();
    let to_clip = functions.find(|(_, function)| function.name.as_deref() == Some(TO_CLIP));
    let Some((to_clip, _)) = to_clip else {
        return Vec::new();
    };
    let may_vary = |entry: &&EntryPoint| {
        entry.stage == ShaderStage::Vertex
            && calls(module, &entry.function.body, to_clip)
            && has_variant_position(module, entry)
    };
    let entries = module.entry_points.iter().filter(may_vary);
    entries.map(|entry| entry.name.as_str()).collect()
}

/// Whether a block comes to call a function, by itself or by others. WGSL has no recursion.
fn calls(module: &Module, block: &Block, target: Handle<naga::Function>) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Call { function, .. } => {
            *function == target || calls(module, &module.functions[*function].body, target)
        }
        Statement::Block(inner) => calls(module, inner, target),
        Statement::If { accept, reject, .. } => {
            calls(module, accept, target) || calls(module, reject, target)
        }
        Statement::Switch { cases, .. } => {
            cases.iter().any(|case| calls(module, &case.body, target))
        }
        Statement::Loop {
            body, continuing, ..
        } => calls(module, body, target) || calls(module, continuing, target),
        _ => false,
    })
}

fn has_variant_position(module: &Module, entry: &EntryPoint) -> bool {
    let Some(result) = &entry.function.result else {
        return false;
    };
    let varies = |binding: Option<&Binding>| {
        matches!(
            binding,
            Some(Binding::BuiltIn(BuiltIn::Position { invariant: false }))
        )
    };
    match &module.types[result.ty].inner {
        TypeInner::Struct { members, .. } => {
            members.iter().any(|member| varies(member.binding.as_ref()))
        }
        _ => varies(result.binding.as_ref()),
    }
}

#[cfg(test)]
mod tests {
    use crate::{compose, validate};

    #[test]
    fn a_position_that_may_vary_is_found_however_deep_its_call_is() {
        let surface = "surface/surface.wgsl";
        let composed = compose(surface).expect("exists");
        validate(surface, &composed).expect("invariant");
        let error = validate(surface, &composed.replace("@invariant", "")).expect_err("may vary");
        let said = error.to_string();
        assert!(
            said.starts_with("surface/surface.wgsl: entry point ") && said.contains("@invariant"),
            "{said}"
        );
        // Negative control: what does not come by the shared step may vary.
        let other = "@vertex fn corner() -> @builtin(position) vec4<f32> { return vec4<f32>(); }";
        validate("corner.wgsl", other).expect("nothing to compare with");
    }
}
