// SPDX-License-Identifier: MIT OR Apache-2.0
//! What draws a case, and the one place where it is made.

use std::cell::OnceCell;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_compute::{ComputeBackend, ComputeVariant, Expansion, compute_bytes};
use terrafill_core::RegionMesh;
use terrafill_frame::{BackendError, Switches, VolumeBackend};
use terrafill_gpu::{BaselineKind, SharedStage};
use terrafill_native::{NativeBackend, NativeVariant, native_bytes};
use terrafill_scene::{ImageSize, Overlap, PlanOptions};
use terrafill_vertex::{VertexBackend, VertexVariant, shared_flag_bytes, variant_bytes};

/// What draws a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Technique {
    /// A full-screen pass.
    Baseline(BaselineKind),
    /// Volumes extruded in the vertex shader.
    Vertex(VertexVariant),
    /// The geometry shader emulated in compute.
    Compute(ComputeVariant),
    /// Geometry shaders, and the vertex shader as their control, on Vulkan itself.
    Native(NativeVariant),
}

/// Backends that `--backend` knows, in the order in which they are measured. The first is the one
/// whose pictures the others' are laid beside.
pub const BACKENDS: [&str; 3] = ["vertex", "compute", "native"];

/// Where techniques draw: the stage that all wgpu backends share, and one on Vulkan itself, which is
/// made when it is first asked for.
#[derive(Debug)]
pub(crate) struct Stages {
    pub(crate) wgpu: SharedStage,
    native_gpu: SharedNativeGpu,
    native: OnceCell<Result<terrafill_vulkan::SharedStage, String>>,
    size: ImageSize,
}

/// A device of Vulkan itself for all scenes of a run, opened when it is first asked for; or why there
/// is none.
pub(crate) type SharedNativeGpu = Rc<NativeGpu>;

/// See [`SharedNativeGpu`].
#[derive(Debug)]
pub(crate) struct NativeGpu {
    adapter: Option<String>,
    gpu: OnceCell<Result<Arc<terrafill_vulkan::Gpu>, String>>,
}

impl NativeGpu {
    /// - `adapter`: part of the adapter's name
    pub(crate) fn new(adapter: Option<String>) -> SharedNativeGpu {
        Rc::new(Self {
            adapter,
            gpu: OnceCell::new(),
        })
    }

    fn open(&self) -> Result<&Arc<terrafill_vulkan::Gpu>, &String> {
        let open = || {
            terrafill_vulkan::Gpu::open(&terrafill_vulkan::GpuOptions {
                adapter: self.adapter.clone(),
                ..terrafill_vulkan::GpuOptions::default()
            })
            .map_err(|error| error.to_string())
        };
        self.gpu.get_or_init(open).as_ref()
    }
}

impl Stages {
    pub(crate) fn new(wgpu: SharedStage, native_gpu: SharedNativeGpu, size: ImageSize) -> Self {
        Self {
            wgpu,
            native_gpu,
            native: OnceCell::new(),
            size,
        }
    }

    fn native(&self) -> Result<&terrafill_vulkan::SharedStage, BackendError> {
        let make = || {
            let gpu = self.native_gpu.open().map_err(Clone::clone)?;
            terrafill_vulkan::Stage::shared(gpu, self.size).map_err(|error| error.to_string())
        };
        self.native
            .get_or_init(make)
            .as_ref()
            .map_err(|why| BackendError::Unsupported {
                capability: format!("a device for the native backend: {why}"),
                adapter: "this machine".to_owned(),
            })
    }
}

/// Bytes of geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct GeometryBytes {
    /// Positions and flags.
    pub(crate) vertex_bytes: u64,
    /// Indices.
    pub(crate) index_bytes: u64,
}

impl GeometryBytes {
    pub(crate) fn total(self) -> u64 {
        self.vertex_bytes + self.index_bytes
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            vertex_bytes: self.vertex_bytes + other.vertex_bytes,
            index_bytes: self.index_bytes + other.index_bytes,
        }
    }
}

impl Technique {
    /// Name of the backend in rows.
    #[must_use]
    pub fn backend(&self) -> &'static str {
        match self {
            Self::Baseline(kind) => kind.name(),
            Self::Vertex(_) => "vertex",
            Self::Compute(_) => "compute",
            Self::Native(_) => "native",
        }
    }

    /// Layout first, then what differs from the default, `key=value`, sorted.
    #[must_use]
    pub fn variant_name(&self) -> String {
        match self {
            Self::Baseline(_) => "full-screen".to_owned(),
            Self::Vertex(variant) => variant.name(),
            Self::Compute(variant) => variant.name(),
            Self::Native(variant) => variant.name(),
        }
    }

    /// The fill's switches; a full-screen pass has none.
    #[must_use]
    pub fn switches(&self) -> Option<&Switches> {
        match self {
            Self::Baseline(_) => None,
            Self::Vertex(variant) => Some(&variant.switches),
            Self::Compute(variant) => Some(&variant.switches),
            Self::Native(variant) => Some(&variant.switches),
        }
    }

    /// The fill's switches, to be set.
    pub(crate) fn switches_mut(&mut self) -> Option<&mut Switches> {
        match self {
            Self::Baseline(_) => None,
            Self::Vertex(variant) => Some(&mut variant.switches),
            Self::Compute(variant) => Some(&mut variant.switches),
            Self::Native(variant) => Some(&mut variant.switches),
        }
    }

    /// Whether it draws onto the surface of the stage that all wgpu backends share.
    pub(crate) fn shares_stage(&self) -> bool {
        !matches!(self, Self::Native(_))
    }

    /// A backend that draws so.
    ///
    /// # Errors
    /// [`BackendError::Unsupported`] when the device lacks something, else whatever it reports.
    pub(crate) fn open(
        &self,
        stages: &Stages,
    ) -> Option<Result<Box<dyn VolumeBackend>, BackendError>> {
        fn boxed<B: VolumeBackend + 'static>(backend: B) -> Box<dyn VolumeBackend> {
            Box::new(backend)
        }
        // wgpu has no depth-bounds test, whatever the device has; silence would look like one that
        // changes nothing.
        let is_native = matches!(self, Self::Native(_));
        if !is_native
            && self
                .switches()
                .is_some_and(|switches| switches.depth_bounds)
        {
            return Some(Err(BackendError::Unsupported {
                capability: "a depth-bounds test".to_owned(),
                adapter: "wgpu".to_owned(),
            }));
        }
        let stage = &stages.wgpu;
        match self {
            Self::Baseline(_) => None,
            Self::Vertex(variant) => Some(VertexBackend::new(stage, *variant).map(boxed)),
            Self::Compute(variant) => Some(ComputeBackend::new(stage, *variant).map(boxed)),
            Self::Native(variant) => Some(
                stages
                    .native()
                    .and_then(|stage| NativeBackend::new(stage, *variant).map(boxed)),
            ),
        }
    }

    /// Bytes of one region by the layout's formula; `None` where there is no geometry.
    ///
    /// - `is_drawn`: whether the view draws it, since some layouts hold parts for those only
    pub(crate) fn formula(&self, mesh: &RegionMesh, is_drawn: bool) -> Option<GeometryBytes> {
        match self {
            Self::Baseline(_) => None,
            Self::Vertex(variant) => {
                let bytes = variant_bytes(variant, mesh);
                Some(GeometryBytes {
                    vertex_bytes: bytes.vertex_bytes,
                    index_bytes: bytes.index_bytes,
                })
            }
            Self::Compute(variant) => {
                let bytes = compute_bytes(mesh);
                let output = match variant.expansion {
                    Expansion::PerFrame if !is_drawn => 0,
                    _ => bytes.output_index_bytes,
                };
                Some(GeometryBytes {
                    vertex_bytes: bytes.input_vertex_bytes,
                    index_bytes: bytes.input_index_bytes + output,
                })
            }
            Self::Native(variant) => {
                let bytes = native_bytes(variant.technique, mesh);
                Some(GeometryBytes {
                    vertex_bytes: bytes.vertex_bytes,
                    index_bytes: bytes.index_bytes,
                })
            }
        }
    }

    /// Bytes that all regions share, by the layout's formula.
    pub(crate) fn shared_formula(&self, meshes: &[RegionMesh]) -> GeometryBytes {
        match self {
            Self::Baseline(_) | Self::Compute(_) | Self::Native(_) => GeometryBytes::default(),
            Self::Vertex(variant) => GeometryBytes {
                vertex_bytes: shared_flag_bytes(variant.layout, meshes),
                index_bytes: 0,
            },
        }
    }

    /// Whether layout and switches go together, and with a scene of this kind.
    pub(crate) fn is_allowed(&self, overlap: Overlap) -> bool {
        match self {
            Self::Baseline(_) => true,
            Self::Vertex(variant) => variant.check(overlap).is_ok(),
            Self::Compute(variant) => {
                variant.check().is_ok() && variant.switches.check(overlap).is_ok()
            }
            Self::Native(variant) => variant.switches.check(overlap).is_ok(),
        }
    }
}

/// A technique and how its frames are planned: all that a variant's name says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// What draws.
    pub technique: Technique,
    /// What is left out before.
    pub plan: PlanOptions,
}

impl Setting {
    /// The technique with everything planned as it should be.
    pub(crate) fn new(technique: Technique) -> Self {
        Self {
            technique,
            plan: PlanOptions::default(),
        }
    }

    /// The same with other switches of the fill.
    pub(crate) fn with(mut self, change: impl FnOnce(&mut Switches)) -> Self {
        if let Some(switches) = self.technique.switches_mut() {
            change(switches);
        }
        self
    }

    /// Layout first, then the switches of technique and plan that differ from the default, sorted.
    #[must_use]
    pub fn variant_name(&self) -> String {
        let own = self.technique.variant_name();
        let mut parts = own.split(',');
        let layout = parts.next().unwrap_or_default().to_owned();
        let mut names: Vec<String> = parts.map(str::to_owned).collect();
        names.extend(plan_names(self.plan));
        names.sort_unstable();
        names.insert(0, layout);
        names.join(",")
    }

    /// First part of the variant: how geometry is stored.
    pub(crate) fn layout(&self) -> String {
        let name = self.technique.variant_name();
        name.split(',').next().unwrap_or_default().to_owned()
    }
}

/// `key=value` of what differs from the default.
fn plan_names(plan: PlanOptions) -> Vec<String> {
    let default = PlanOptions::default();
    [
        (
            "frustum-culling",
            plan.frustum_culling,
            default.frustum_culling,
        ),
        (
            "horizon-culling",
            plan.horizon_culling,
            default.horizon_culling,
        ),
        (
            "too-small-culling",
            plan.too_small_culling,
            default.too_small_culling,
        ),
    ]
    .into_iter()
    .filter(|(_, value, default)| value != default)
    .map(|(key, value, _)| format!("{key}={}", if value { "on" } else { "off" }))
    .chain(
        plan.boundary_lod_px
            .map(|px| format!("boundary-lod-px={px}")),
    )
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_frame::FacePasses;

    #[test]
    fn plan_and_fill_switches_share_one_sorted_name() {
        let main = Setting::new(Technique::Vertex(VertexVariant::default()));
        assert_eq!(main.variant_name(), "doubled");
        let mut changed = main.with(|switches| {
            switches.faces = FacePasses::TwoPass;
            switches.scissor = true;
        });
        changed.plan.horizon_culling = false;
        changed.plan.boundary_lod_px = Some(0.5);
        assert_eq!(
            changed.variant_name(),
            "doubled,boundary-lod-px=0.5,faces=two-pass,horizon-culling=off,scissor=volumes"
        );
        assert_eq!(changed.layout(), "doubled");
    }

    #[test]
    fn a_full_screen_pass_is_no_technique() {
        let mut bound = Technique::Baseline(BaselineKind::Bound);
        assert!(bound.switches().is_none() && bound.switches_mut().is_none());
        assert_eq!(Setting::new(bound).variant_name(), "full-screen");
    }
}
