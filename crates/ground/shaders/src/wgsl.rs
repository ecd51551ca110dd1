// SPDX-License-Identifier: MIT OR Apache-2.0
//! The WGSL sources: embedded, composed by `#import`, validated and reflected by naga.

use crate::invariance::variant_positions;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

/// A shader file, path relative to `shaders/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShaderSource {
    /// `vertex/doubled.wgsl` …
    pub path: &'static str,
    pub(crate) text: &'static str,
}

macro_rules! shader_sources {
    ($($path:literal),* $(,)?) => {
        [$($crate::wgsl::ShaderSource { path: $path, text: include_str!(concat!("../../../../shaders/", $path)) }),*]
    };
}

pub(crate) use shader_sources;

/// Files with entry points that compile as they are, by path: listed by the build script.
pub(crate) const MODULES: &[ShaderSource] = include!(concat!(env!("OUT_DIR"), "/modules.rs"));

/// Files that others import: listed by the build script.
pub(crate) const SHARED: &[ShaderSource] = include!(concat!(env!("OUT_DIR"), "/shared.rs"));

/// What can be wrong with a shader.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShaderError {
    /// No such file.
    #[error("no shader is called {0}")]
    Unknown(String),
    /// An import names a file that is not in `shaders/shared/`.
    #[error("{path} imports {import}, which is not among the shared shaders")]
    UnknownImport {
        /// Importing file.
        path: String,
        /// What it names.
        import: String,
    },
    /// naga rejects it, or a position may vary between shaders.
    #[error("{path}: {message}")]
    Invalid {
        /// File.
        path: String,
        /// naga's words, or which position.
        message: String,
    },
    /// The struct is not in the shader.
    #[error("{path} has no struct {name}")]
    UnknownStruct {
        /// File.
        path: String,
        /// Struct asked for.
        name: String,
    },
}

/// Every file with entry points.
#[must_use]
pub fn modules() -> &'static [ShaderSource] {
    MODULES
}

/// Source of `path` with its imports put in.
///
/// # Errors
/// [`ShaderError::Unknown`], [`ShaderError::UnknownImport`].
pub fn compose(path: &str) -> Result<String, ShaderError> {
    let source = MODULES
        .iter()
        .find(|source| source.path == path)
        .ok_or_else(|| ShaderError::Unknown(path.to_owned()))?;
    compose_text(source.path, source.text)
}

pub(crate) fn compose_text(path: &str, text: &str) -> Result<String, ShaderError> {
    let mut composed = String::new();
    for line in text.lines() {
        if let Some(import) = line.strip_prefix("#import ") {
            let shared = SHARED
                .iter()
                .find(|source| source.path == import.trim())
                .ok_or_else(|| ShaderError::UnknownImport {
                    path: path.to_owned(),
                    import: import.trim().to_owned(),
                })?;
            composed.push_str(&compose_text(shared.path, shared.text)?);
        } else {
            composed.push_str(line);
        }
        composed.push('\n');
    }
    Ok(composed)
}

/// Text of a file that others import, such as one of pure functions that a test evaluates.
///
/// # Errors
/// [`ShaderError::Unknown`].
pub fn shared_text(path: &str) -> Result<&'static str, ShaderError> {
    let shared = SHARED.iter().find(|source| source.path == path);
    let shared = shared.ok_or_else(|| ShaderError::Unknown(path.to_owned()))?;
    Ok(shared.text)
}

/// A composed source for scenes in which sensors' footprints move: volumes that have one are bent into
/// it by the vertex stage. The text stays as it is where it reads no volumes.
#[must_use]
pub fn with_footprints(composed: &str) -> String {
    composed.replace(
        "override FOOTPRINTS: bool = false;",
        "const FOOTPRINTS: bool = true;",
    )
}

/// Parses and validates one composed source.
///
/// # Errors
/// [`ShaderError::Invalid`] with naga's message and place, or the entry point whose position may vary.
pub fn validate(path: &str, composed: &str) -> Result<naga::Module, ShaderError> {
    parse_and_validate(path, composed).map(|(module, _)| module)
}

/// Globes of a study, on which nothing else is drawn. There a vertex stage that makes its places must round as
/// a compute shader does, which has no invariant results.
const DRAWN_ALONE: &str = "globes/";

/// What not every device has: a module that numbers primitives or indexes arrays of textures says so, and its device
/// is asked first. Half floats that are unpacked are in WGSL itself.
fn capabilities() -> Capabilities {
    Capabilities::PRIMITIVE_INDEX
        | Capabilities::RAY_QUERY
        | Capabilities::SHADER_FLOAT16_IN_FLOAT32
        | Capabilities::TEXTURE_AND_SAMPLER_BINDING_ARRAY
        | Capabilities::TEXTURE_AND_SAMPLER_BINDING_ARRAY_NON_UNIFORM_INDEXING
}

pub(crate) fn parse_and_validate(
    path: &str,
    composed: &str,
) -> Result<(naga::Module, ModuleInfo), ShaderError> {
    let invalid = |message: String| ShaderError::Invalid {
        path: path.to_owned(),
        message,
    };
    let module = naga::front::wgsl::parse_str(composed)
        .map_err(|error| invalid(error.emit_to_string_with_path(composed, path)))?;
    let info = Validator::new(ValidationFlags::all(), capabilities())
        .validate(&module)
        .map_err(|error| invalid(error.emit_to_string_with_path(composed, path)))?;
    let may_vary = if path.starts_with(DRAWN_ALONE) {
        Vec::new()
    } else {
        variant_positions(&module)
    };
    if let Some(entry) = may_vary.first() {
        return Err(invalid(format!(
            "entry point {entry} places vertices by clip_from_eye_relative; its position must be @invariant, or \
             what another shader draws in the same place has another depth"
        )));
    }
    Ok((module, info))
}

/// Validates every module and returns how many there are, so that a caller can refuse an empty set.
///
/// # Errors
/// The first [`ShaderError`].
pub fn check_all() -> Result<usize, ShaderError> {
    for source in MODULES {
        validate(source.path, &compose(source.path)?)?;
    }
    Ok(MODULES.len())
}

/// Name, byte offset and size of a struct's members as the GPU lays them out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StructLayout {
    /// `(name, offset, size)` in order.
    pub members: Vec<(String, u32, u32)>,
    /// Bytes from one array element to the next.
    pub stride: u32,
}

impl StructLayout {
    /// Byte at which a member starts.
    #[must_use]
    pub fn offset(&self, name: &str) -> Option<usize> {
        let mut members = self.members.iter();
        let member = members.find(|(member, ..)| member == name)?;
        Some(member.1 as usize)
    }
}

/// Layout of struct `name` in the shader at `path`.
///
/// # Errors
/// [`ShaderError::UnknownStruct`], or the shader does not validate.
pub fn struct_layout(path: &str, name: &str) -> Result<StructLayout, ShaderError> {
    layout_in(&validate(path, &compose(path)?)?, path, name)
}

pub(crate) fn layout_in(
    module: &naga::Module,
    path: &str,
    name: &str,
) -> Result<StructLayout, ShaderError> {
    let unknown = || ShaderError::UnknownStruct {
        path: path.to_owned(),
        name: name.to_owned(),
    };
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(name))
        .ok_or_else(unknown)?;
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        return Err(unknown());
    };
    let size = |ty| module.types[ty].inner.size(module.to_ctx());
    Ok(StructLayout {
        members: members
            .iter()
            .map(|member| {
                let name = member.name.clone().unwrap_or_default();
                (name, member.offset, size(member.ty))
            })
            .collect(),
        stride: *span,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_module_validates() {
        assert_eq!(check_all().expect("all shaders are valid"), MODULES.len());
        assert!(
            compose("surface/surface.wgsl").is_ok(),
            "the list is not empty"
        );
    }

    #[test]
    fn a_broken_shader_is_refused_with_its_place() {
        let composed = compose("vertex/doubled.wgsl").expect("exists");
        let broken = composed.replace("is_bottom != 0u", "is_bottom != 0.0");
        assert_ne!(broken, composed);
        let error = validate("vertex/doubled.wgsl", &broken).expect_err("types differ");
        assert!(error.to_string().contains("vertex/doubled.wgsl"), "{error}");
    }

    #[test]
    fn modules_that_draw_volumes_bend_footprints_when_asked_to() {
        let mut bent = 0;
        for source in MODULES {
            let composed = compose(source.path).expect("exists");
            let other = with_footprints(&composed);
            let draws = source.text.contains("eye_relative_m(");
            assert!(!draws || other != composed, "{}", source.path);
            bent += usize::from(other != composed);
            validate(source.path, &other).expect("valid both ways");
        }
        // Negative control: what reads no volumes stays.
        assert!(bent >= 5 && bent < MODULES.len(), "{bent}");
    }

    #[test]
    fn an_unknown_import_is_refused() {
        let error = compose_text("x.wgsl", "#import shared/nothing.wgsl").expect_err("unknown");
        assert_eq!(
            error.to_string(),
            "x.wgsl imports shared/nothing.wgsl, which is not among the shared shaders"
        );
    }
}
