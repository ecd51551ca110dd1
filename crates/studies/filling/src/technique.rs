// SPDX-License-Identifier: MIT OR Apache-2.0
//! What draws a case, and the one place where it is made.

use std::cell::OnceCell;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_compute::{ComputeBackend, ComputeVariant, Expansion, compute_bytes};
use terrafill_core::RegionMesh;
use terrafill_fill::{
    DeviceError, GeometryBytes, PositionFormat, SwitchError, Switches, THIS_MACHINE, VolumeBackend,
};
use terrafill_gpu::{BaselineKind, SharedTargets};
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

/// Where techniques draw: the render targets that all wgpu backends share, and one on Vulkan itself, which is
/// made when it is first asked for.
#[derive(Debug)]
pub(crate) struct AllTargets {
    pub(crate) wgpu: SharedTargets,
    native_gpu: SharedNativeGpu,
    native: OnceCell<Result<terrafill_vulkan::SharedTargets, String>>,
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
        let open = || open_vulkan(self.adapter.as_deref()).map_err(|error| error.to_string());
        self.gpu.get_or_init(open).as_ref()
    }
}

impl AllTargets {
    pub(crate) fn new(wgpu: SharedTargets, native_gpu: SharedNativeGpu, size: ImageSize) -> Self {
        Self {
            wgpu,
            native_gpu,
            native: OnceCell::new(),
            size,
        }
    }

    fn native(&self) -> Result<&terrafill_vulkan::SharedTargets, DeviceError> {
        let make = || {
            let gpu = self.native_gpu.open().map_err(Clone::clone)?;
            terrafill_vulkan::RenderTargets::shared(gpu, self.size)
                .map_err(|error| error.to_string())
        };
        self.native.get_or_init(make).as_ref().map_err(|why| {
            let what = format!("a device for the native backend: {why}");
            DeviceError::unsupported(&what, THIS_MACHINE)
        })
    }
}

/// Opens the first wgpu device whose name contains `adapter`.
fn open_wgpu(adapter: Option<&str>) -> Result<Arc<terrafill_gpu::Gpu>, DeviceError> {
    terrafill_gpu::Gpu::open(&terrafill_gpu::GpuOptions {
        adapter: adapter.map(str::to_owned),
        ..terrafill_gpu::GpuOptions::default()
    })
}

/// The same on Vulkan itself.
fn open_vulkan(adapter: Option<&str>) -> Result<Arc<terrafill_vulkan::Gpu>, DeviceError> {
    terrafill_vulkan::Gpu::open(&terrafill_vulkan::GpuOptions {
        adapter: adapter.map(str::to_owned),
        ..terrafill_vulkan::GpuOptions::default()
    })
}

fn boxed<B: VolumeBackend + 'static>(backend: B) -> Box<dyn VolumeBackend> {
    Box::new(backend)
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

    /// How it stores positions, where that is a choice.
    pub(crate) fn positions(&self) -> Option<PositionFormat> {
        match self {
            Self::Vertex(variant) => Some(variant.positions),
            Self::Baseline(_) | Self::Compute(_) | Self::Native(_) => None,
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

    /// Whether it draws onto the surface of the render targets that all wgpu backends share.
    pub(crate) fn shares_stage(&self) -> bool {
        !matches!(self, Self::Native(_))
    }

    /// A backend that draws so on these targets; `None` for a full-screen pass.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks something, else whatever it reports.
    pub(crate) fn open(
        &self,
        targets: &AllTargets,
    ) -> Option<Result<Box<dyn VolumeBackend>, DeviceError>> {
        let wgpu = || Ok(SharedTargets::clone(&targets.wgpu));
        let vulkan = || targets.native().map(terrafill_vulkan::SharedTargets::clone);
        self.open_on(wgpu, vulkan)
    }

    /// The same on a device of its own.
    ///
    /// - `adapter`: part of the adapter's name
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when there is no such device, it lacks something, or this is a
    /// full-screen pass; else whatever the device reports.
    pub fn open_alone(
        &self,
        adapter: Option<&str>,
        size: ImageSize,
    ) -> Result<Box<dyn VolumeBackend>, DeviceError> {
        let wgpu = || terrafill_gpu::RenderTargets::shared(&open_wgpu(adapter)?, size);
        let vulkan = || terrafill_vulkan::RenderTargets::shared(&open_vulkan(adapter)?, size);
        self.open_on(wgpu, vulkan)
            .unwrap_or_else(|| Err(DeviceError::unsupported("drawing volumes", self.backend())))
    }

    /// The one place where backends of volumes are made.
    fn open_on(
        &self,
        wgpu: impl FnOnce() -> Result<SharedTargets, DeviceError>,
        vulkan: impl FnOnce() -> Result<terrafill_vulkan::SharedTargets, DeviceError>,
    ) -> Option<Result<Box<dyn VolumeBackend>, DeviceError>> {
        Some(match self {
            Self::Baseline(_) => return None,
            Self::Vertex(variant) => {
                wgpu().and_then(|targets| VertexBackend::new(&targets, *variant).map(boxed))
            }
            Self::Compute(variant) => {
                wgpu().and_then(|targets| ComputeBackend::new(&targets, *variant).map(boxed))
            }
            Self::Native(variant) => {
                vulkan().and_then(|targets| NativeBackend::new(&targets, *variant).map(boxed))
            }
        })
    }

    /// Bytes of one region by the layout's formula; `None` where there is no geometry.
    ///
    /// - `is_drawn`: whether the view draws it, since some layouts hold parts for those only
    pub(crate) fn formula(&self, mesh: &RegionMesh, is_drawn: bool) -> Option<GeometryBytes> {
        match self {
            Self::Baseline(_) => None,
            Self::Vertex(variant) => Some(variant_bytes(variant, mesh)),
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
            Self::Native(variant) => Some(native_bytes(variant.technique, variant.indices(), mesh)),
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
        self.check_variant(overlap).is_ok()
    }

    fn check_variant(&self, overlap: Overlap) -> Result<(), SwitchError> {
        match self {
            Self::Baseline(_) => Ok(()),
            Self::Vertex(variant) => variant.check(overlap),
            Self::Compute(variant) => {
                variant.check()?;
                variant.switches.check(overlap)
            }
            Self::Native(variant) => variant.check(overlap),
        }
    }

    /// Whether the switches go together, with the backend's API and with a scene of this kind.
    ///
    /// # Errors
    /// [`SwitchError`].
    pub fn check(&self, overlap: Overlap) -> Result<(), SwitchError> {
        // On no device would it run, so that it is no device's fault.
        let tests_bounds = self.switches().is_some_and(|s| s.depth_bounds);
        if tests_bounds && !matches!(self, Self::Native(_)) {
            return Err(SwitchError {
                switch: "depth-bounds",
                found: "on with a backend on wgpu, which has no such test".to_owned(),
                allowed: "off, or --backend native".to_owned(),
            });
        }
        self.check_variant(overlap)
    }

    /// The main variant of a backend of [`BACKENDS`] for scenes of this kind.
    #[must_use]
    pub fn main(backend: &str, overlap: Overlap) -> Option<Self> {
        let mut main = match backend {
            "vertex" => Self::Vertex(VertexVariant::default()),
            "compute" => Self::Compute(ComputeVariant::default()),
            "native" => Self::Native(NativeVariant::default()),
            _ => return None,
        };
        if let Some(switches) = main.switches_mut() {
            *switches = Switches::for_overlap(overlap);
        }
        Some(main)
    }

    /// Every key that [`Technique::set`] takes, with its values.
    #[must_use]
    pub fn keys(&self) -> String {
        let own = match self {
            Self::Baseline(_) => return String::new(),
            Self::Vertex(_) => VertexVariant::KEYS,
            Self::Compute(_) => ComputeVariant::KEYS,
            Self::Native(_) => NativeVariant::KEYS,
        };
        format!("{own}, {}", Switches::KEYS)
    }

    /// Sets the switch `key` to `value`; `Ok(false)` when the backend has no such switch.
    ///
    /// # Errors
    /// [`SwitchError`] when the value is none of the switch's.
    pub fn set(&mut self, key: &str, value: &str) -> Result<bool, SwitchError> {
        match self {
            Self::Baseline(_) => Ok(false),
            Self::Vertex(variant) => variant.set(key, value),
            Self::Compute(variant) => variant.set(key, value),
            Self::Native(variant) => variant.set(key, value),
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

    /// How geometry is stored: the first part of the variant, and after it how triangles are indexed
    /// where that is not the default.
    pub(crate) fn layout(&self) -> String {
        let name = self.technique.variant_name();
        let layout = name.split(',').next().unwrap_or_default();
        match self.technique {
            Technique::Native(variant)
                if variant.indices() != variant.technique.default_indices() =>
            {
                format!("{layout}/{}", variant.indices().name())
            }
            _ => layout.to_owned(),
        }
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
    use terrafill_fill::{FacePasses, FrameInput, PreparedScene};
    use terrafill_scene::Scene;
    use terrafill_surface::{EllipsoidKind, open_surface};

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

    fn technique(backend: &str) -> Technique {
        Technique::main(backend, Overlap::Disjoint).expect("a backend")
    }

    /// `key=value` of every value in the list.
    fn settings(keys: &str) -> Vec<(&str, &str)> {
        let keys = keys.split(", ").map(|key| key.split_once('='));
        keys.map(|key| key.expect("key=values"))
            .flat_map(|(key, values)| values.split('|').map(move |value| (key, value)))
            .collect()
    }

    /// Those of `keys` that `backend` does not take.
    fn not_taken<'a>(backend: &str, keys: &'a str) -> Vec<(&'a str, &'a str)> {
        let all = settings(keys).into_iter();
        all.filter(|(key, value)| technique(backend).set(key, value) != Ok(true))
            .collect()
    }

    #[test]
    fn what_a_message_allows_is_taken() {
        for backend in BACKENDS {
            let keys = technique(backend).keys();
            let keys = keys
                .replace("1…100", "1|100")
                .replace("a route such as ", "");
            assert!(settings(&keys).len() > 20, "{keys}");
            assert_eq!(not_taken(backend, &keys), [], "{backend}");
        }
    }

    #[test]
    fn what_another_backend_has_alone_is_not_taken() {
        for (owner, keys) in [
            ("vertex", "layout=pulled, walls=list"),
            ("compute", ComputeVariant::KEYS),
            ("native", "technique=gs-line"),
        ] {
            for backend in BACKENDS {
                let expected = if backend == owner {
                    Vec::new()
                } else {
                    settings(keys)
                };
                assert_eq!(not_taken(backend, keys), expected, "{backend}");
            }
        }
    }

    #[test]
    fn only_vulkan_itself_has_a_depth_bounds_test() {
        for backend in BACKENDS {
            let mut technique = technique(backend);
            assert_eq!(technique.check(Overlap::Disjoint), Ok(()));
            assert_eq!(technique.set("depth-bounds", "on"), Ok(true));
            let is_native = backend == "native";
            assert_eq!(technique.check(Overlap::Disjoint).is_ok(), is_native);
        }
    }

    #[test]
    fn main_variants_suit_the_scene_they_are_made_for() {
        for backend in BACKENDS {
            let ordered = Technique::main(backend, Overlap::Ordered).expect("a backend");
            assert_eq!(ordered.check(Overlap::Ordered), Ok(()));
            // Twin: numbers of regions that overlap would mix.
            assert!(technique(backend).check(Overlap::Ordered).is_err());
        }
        assert_eq!(Technique::main("reference", Overlap::Ordered), None);
    }

    #[test]
    fn a_target_of_numbers_is_counted_where_there_is_one() {
        if terrafill_gpu::open_for_test(&Default::default()).is_none()
            || terrafill_vulkan::open_for_test(&Default::default()).is_none()
        {
            return;
        }
        let scene = Scene::shipped("california", None).expect("it ships");
        let (body, rule) = (&scene.body, scene.edge_rule);
        let meshes = RegionMesh::build_all(&scene.regions, body, rule, &scene.mesh);
        let meshes = meshes.expect("it meshes").into();
        let surface = open_surface(&[&EllipsoidKind], &scene).expect("a surface");
        let prepared = PreparedScene::new(&scene, meshes, surface);
        let view = &scene.views[0];
        let size = ImageSize {
            width: 40,
            height: 30,
        };
        let input =
            FrameInput::new(&prepared, view, size, PlanOptions::default()).expect("a surface");
        for backend in BACKENDS {
            let bytes = |colour: &str| {
                let mut technique = technique(backend);
                assert_eq!(technique.set("colour", colour), Ok(true));
                let mut backend = technique.open_alone(None, size).expect("opens");
                let memory = backend.prepare(&input).expect("fits");
                // Preparing again holds the same.
                assert_eq!(
                    backend.prepare(&input).expect("fits").target_bytes,
                    memory.target_bytes
                );
                memory.target_bytes
            };
            assert_eq!(bytes("id-accumulation"), 4 * 40 * 30, "{backend}");
            // Twin: without such a target nothing is counted.
            assert_eq!(bytes("xor"), 0, "{backend}");
        }
    }

    #[test]
    fn a_full_screen_pass_opens_no_backend_of_volumes() {
        let bound = Technique::Baseline(BaselineKind::Bound);
        let size = ImageSize {
            width: 1,
            height: 1,
        };
        let error = bound.open_alone(None, size).map(|_| ());
        let error = error.expect_err("it draws none").to_string();
        assert_eq!(error, "bound lacks drawing volumes");
        assert_eq!(bound.keys(), "");
    }
}
