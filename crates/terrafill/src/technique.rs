// SPDX-License-Identifier: MIT OR Apache-2.0
//! Techniques by name: their switches, and the backend that draws them.

use crate::arguments::RenderBackend;
use terrafill_compute::{ComputeBackend, ComputeVariant, Expansion, GpuCulling, Transform};
use terrafill_frame::{BackendError, SwitchError, Switches, VolumeBackend};
use terrafill_native::{NativeBackend, NativeVariant};
use terrafill_scene::{ImageSize, Overlap};
use terrafill_vertex::{VertexBackend, VertexVariant};

/// A backend of volumes with its switches set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Technique {
    Vertex(VertexVariant),
    Compute(ComputeVariant),
    Native(NativeVariant),
}

/// Switches of every fill, with their values. [`VertexVariant::KEYS`] ends with them.
const FILL_KEYS: &str = "bottom-cap=always|where-needed, \
    colour=xor|rectangle|volume|bit-planes|one-colour|one-colour-volumes|id-accumulation, \
    cover-faces=both|culled, depth-rule=zfail|zpass|automatic, faces=two-sided|two-pass, \
    scissor=covers|volumes, stencil-clear=at-start|by-colour";

/// Switches that only the compute backend has.
const COMPUTE_KEYS: &str =
    "expansion=per-frame|cached, gpu-culling=off|regions|triangles, transform=vertex|compute";

impl Technique {
    /// The main variant of `backend` for scenes of this kind; `None` for the reference.
    pub(crate) fn new(backend: RenderBackend, overlap: Overlap) -> Option<Self> {
        let switches = Switches::for_overlap(overlap);
        match backend {
            RenderBackend::Vertex => Some(Self::Vertex(VertexVariant {
                switches,
                ..VertexVariant::default()
            })),
            RenderBackend::Compute => Some(Self::Compute(ComputeVariant {
                switches,
                ..ComputeVariant::default()
            })),
            RenderBackend::Native => Some(Self::Native(NativeVariant {
                switches,
                ..NativeVariant::default()
            })),
            RenderBackend::Reference => None,
        }
    }

    /// Every key that [`Technique::set`] takes, with its values.
    pub(crate) fn keys(&self) -> String {
        match self {
            Self::Vertex(_) => VertexVariant::KEYS.to_owned(),
            Self::Compute(_) => format!("{COMPUTE_KEYS}, {FILL_KEYS}"),
            Self::Native(_) => format!("{}, {FILL_KEYS}", NativeVariant::KEYS),
        }
    }

    /// Sets the switch `key` to `value`; `Ok(false)` when the backend has no such switch.
    ///
    /// # Errors
    /// [`SwitchError`] when the value is none of the switch's.
    pub(crate) fn set(&mut self, key: &str, value: &str) -> Result<bool, SwitchError> {
        match self {
            Self::Vertex(variant) => variant.set(key, value),
            Self::Compute(variant) => set_compute(variant, key, value),
            Self::Native(variant) => variant.set(key, value),
        }
    }

    fn switches(&self) -> &Switches {
        match self {
            Self::Vertex(variant) => &variant.switches,
            Self::Compute(variant) => &variant.switches,
            Self::Native(variant) => &variant.switches,
        }
    }

    /// Whether the switches go together, with the backend's API and with a scene of this kind.
    ///
    /// # Errors
    /// [`SwitchError`].
    pub(crate) fn check(&self, overlap: Overlap) -> Result<(), SwitchError> {
        // On no device would it run, so that it is no device's fault.
        if self.switches().depth_bounds && !matches!(self, Self::Native(_)) {
            return Err(SwitchError {
                switch: "depth-bounds",
                found: "on with a backend on wgpu, which has no such test".to_owned(),
                allowed: "off, or --backend native".to_owned(),
            });
        }
        match self {
            Self::Vertex(variant) => variant.check(overlap),
            Self::Compute(variant) => {
                variant.check()?;
                variant.switches.check(overlap)
            }
            Self::Native(variant) => variant.switches.check(overlap),
        }
    }

    /// A backend that draws so, on a device of its own.
    ///
    /// - `adapter`: part of the adapter's name
    ///
    /// # Errors
    /// [`BackendError::Unsupported`] when no device can, else whatever it reports.
    pub(crate) fn open(
        &self,
        adapter: Option<&str>,
        size: ImageSize,
    ) -> Result<Box<dyn VolumeBackend>, BackendError> {
        Ok(match self {
            Self::Vertex(variant) => {
                Box::new(VertexBackend::new(&wgpu_stage(adapter, size)?, *variant)?)
            }
            Self::Compute(variant) => {
                Box::new(ComputeBackend::new(&wgpu_stage(adapter, size)?, *variant)?)
            }
            Self::Native(variant) => {
                Box::new(NativeBackend::new(&vulkan_stage(adapter, size)?, *variant)?)
            }
        })
    }
}

fn wgpu_stage(
    adapter: Option<&str>,
    size: ImageSize,
) -> Result<terrafill_gpu::SharedStage, BackendError> {
    let gpu = terrafill_gpu::Gpu::open(&terrafill_gpu::GpuOptions {
        adapter: adapter.map(str::to_owned),
        ..Default::default()
    })?;
    terrafill_gpu::Stage::shared(&gpu, size)
}

fn vulkan_stage(
    adapter: Option<&str>,
    size: ImageSize,
) -> Result<terrafill_vulkan::SharedStage, BackendError> {
    let gpu = terrafill_vulkan::Gpu::open(&terrafill_vulkan::GpuOptions {
        adapter: adapter.map(str::to_owned),
        ..Default::default()
    })?;
    terrafill_vulkan::Stage::shared(&gpu, size)
}

fn set_compute(variant: &mut ComputeVariant, key: &str, value: &str) -> Result<bool, SwitchError> {
    match key {
        "expansion" => {
            let choices = [Expansion::PerFrame, Expansion::Cached];
            let choices = choices.map(|choice| (choice.name(), choice));
            variant.expansion = pick("expansion", value, &choices)?;
        }
        "gpu-culling" => {
            let choices = [GpuCulling::Off, GpuCulling::Regions, GpuCulling::Triangles];
            let choices = choices.map(|choice| (choice.name(), choice));
            variant.culling = pick("gpu-culling", value, &choices)?;
        }
        "transform" => {
            let choices = [
                ("vertex", Transform::VertexStage),
                ("compute", Transform::ComputeStage),
            ];
            variant.transform = pick("transform", value, &choices)?;
        }
        _ => return variant.switches.set(key, value),
    }
    Ok(true)
}

fn pick<T: Copy>(
    switch: &'static str,
    value: &str,
    choices: &[(&'static str, T)],
) -> Result<T, SwitchError> {
    let found = choices.iter().find(|(name, _)| *name == value);
    found.map(|&(_, choice)| choice).ok_or_else(|| {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        SwitchError {
            switch,
            found: value.to_owned(),
            allowed: names.join(", "),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const BACKENDS: [RenderBackend; 3] = [
        RenderBackend::Vertex,
        RenderBackend::Compute,
        RenderBackend::Native,
    ];

    fn technique(backend: RenderBackend) -> Technique {
        Technique::new(backend, Overlap::Disjoint).expect("no reference")
    }

    /// `key=value` of every value in the list.
    fn settings(keys: &str) -> Vec<(&str, &str)> {
        let keys = keys.split(", ").map(|key| key.split_once('='));
        keys.map(|key| key.expect("key=values"))
            .flat_map(|(key, values)| values.split('|').map(move |value| (key, value)))
            .collect()
    }

    /// Those of `keys` that `backend` does not take.
    fn not_taken(backend: RenderBackend, keys: &str) -> Vec<(&str, &str)> {
        let all = settings(keys).into_iter();
        all.filter(|(key, value)| technique(backend).set(key, value) != Ok(true))
            .collect()
    }

    #[test]
    fn what_a_message_allows_is_taken() {
        for backend in BACKENDS {
            let keys = technique(backend).keys();
            let keys = keys.replace("1…100", "1|100");
            assert!(settings(&keys).len() > 20, "{keys}");
            assert_eq!(not_taken(backend, &keys), [], "{backend:?}");
        }
        assert!(VertexVariant::KEYS.ends_with(FILL_KEYS));
    }

    #[test]
    fn what_another_backend_has_alone_is_not_taken() {
        for (owner, keys) in [
            (RenderBackend::Vertex, "layout=pulled, walls=list"),
            (RenderBackend::Compute, COMPUTE_KEYS),
            (RenderBackend::Native, "technique=gs-line"),
        ] {
            for backend in BACKENDS {
                let expected = if backend == owner {
                    Vec::new()
                } else {
                    settings(keys)
                };
                assert_eq!(not_taken(backend, keys), expected, "{backend:?}");
            }
        }
    }

    #[test]
    fn values_of_the_compute_backend_end_up_in_its_name() {
        let mut compute = ComputeVariant::default();
        for (key, value) in [
            ("expansion", "cached"),
            ("gpu-culling", "regions"),
            ("transform", "compute"),
            ("faces", "two-pass"),
        ] {
            assert_eq!(set_compute(&mut compute, key, value), Ok(true));
        }
        let name = "cached,faces=two-pass,gpu-culling=regions,transform=compute";
        assert_eq!(compute.name(), name);
        for key in ["expansion", "gpu-culling", "transform"] {
            let error = set_compute(&mut compute, key, "never").expect_err("no such value");
            assert_eq!((error.switch, error.found.as_str()), (key, "never"));
        }
        assert_eq!(compute.name(), name);
    }

    #[test]
    fn only_vulkan_itself_has_a_depth_bounds_test() {
        for backend in BACKENDS {
            let mut technique = technique(backend);
            assert_eq!(technique.check(Overlap::Disjoint), Ok(()));
            assert_eq!(technique.set("depth-bounds", "on"), Ok(true));
            let is_native = backend == RenderBackend::Native;
            assert_eq!(technique.check(Overlap::Disjoint).is_ok(), is_native);
        }
    }

    #[test]
    fn main_variants_suit_the_scene_they_are_made_for() {
        for backend in BACKENDS {
            let ordered = Technique::new(backend, Overlap::Ordered).expect("no reference");
            assert_eq!(ordered.check(Overlap::Ordered), Ok(()));
            // Twin: numbers of regions that overlap would mix.
            assert!(technique(backend).check(Overlap::Ordered).is_err());
        }
        assert_eq!(
            Technique::new(RenderBackend::Reference, Overlap::Ordered),
            None
        );
    }
}
