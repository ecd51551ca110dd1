// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions written down in a test, views of them, and whatever draws them.
//!
//! A backend is opened by its [`Technique`] and drawn with as a [`FillBackend`]: what every backend must do is then written once, in [`checks`], over the views
//! of [`sights`]. Another backend joins by an arm in [`AllTargets::open`] and a list of its variants.

#![allow(
    dead_code,
    reason = "written once for tests of several kinds, not all of which use all of it"
)]

pub(crate) mod by_main;
pub(crate) mod checks;
pub(crate) mod pairs;
pub(crate) mod sights;

use std::cell::OnceCell;
use std::sync::Arc;
use terrafill_compute::{ComputeBackend, ComputeTechnique, ComputeVariant};
use terrafill_conformance::{ErrorFigures, compare, verdict};
use terrafill_contract::{Counters, FillBackend, FillInput, Frame, PreparedScene};
use terrafill_core::{
    EdgeRule, Ellipsoid, Extent, Geodetic, MeshOptions, RegionMesh, parse_regions,
};
use terrafill_filling::Techniques;
use terrafill_fixtures::data;
use terrafill_native::{Extrusion, Indices, NativeBackend, NativeTechnique, NativeVariant};
use terrafill_plan::{LazyParts, LeveledMeshes, PlanOptions, RegionSet, SceneBounds};
use terrafill_reference::ReferenceBackend;
use terrafill_scene::{Camera, CameraPose, ImageSize, Overlap, Scene, View};
use terrafill_surface::{
    EllipsoidKind, HeightRange, Surface, SurfaceError, SurfaceFrame, open_surface,
};
use terrafill_variant::{ColourWay, Switches};
use terrafill_vertex::{Layout, VertexBackend, VertexTechnique, VertexVariant};

/// As the command line hands them to a study.
pub(crate) const TECHNIQUES: Techniques = &[&VertexTechnique, &ComputeTechnique, &NativeTechnique];

/// A variant of one of the techniques, as its own crate writes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Technique {
    Vertex(VertexVariant),
    Compute(ComputeVariant),
    Native(NativeVariant),
}

impl Technique {
    pub(crate) fn switches(&self) -> Switches {
        match self {
            Self::Vertex(variant) => variant.switches,
            Self::Compute(variant) => variant.switches,
            Self::Native(variant) => variant.switches,
        }
    }
}

pub(crate) const fn square(side_px: u32) -> ImageSize {
    ImageSize::new(side_px, side_px)
}

/// Size of most pictures here.
pub(crate) const SIZE: ImageSize = square(384);

/// The adapter through wgpu and, where a test asks for it, through Vulkan itself.
pub(crate) struct Devices {
    pub(crate) wgpu: Arc<terrafill_gpu::Gpu>,
    vulkan: OnceCell<Arc<terrafill_vulkan::Gpu>>,
}

impl Devices {
    /// Through wgpu; `None`, said aloud, where there is no device.
    pub(crate) fn open() -> Option<Self> {
        Some(Self {
            wgpu: terrafill_gpu::open_for_test(&Default::default())?,
            vulkan: OnceCell::new(),
        })
    }

    /// Both ways.
    pub(crate) fn open_both() -> Option<Self> {
        let devices = Self::open()?;
        let vulkan = terrafill_vulkan::open_for_test(&Default::default())?;
        devices.vulkan.set(vulkan).ok()?;
        Some(devices)
    }

    /// As many ways as `techniques` need.
    pub(crate) fn open_for(techniques: &[Technique]) -> Option<Self> {
        let is_native = |technique| matches!(technique, &Technique::Native(_));
        if techniques.iter().any(is_native) {
            Self::open_both()
        } else {
            Self::open()
        }
    }

    pub(crate) fn vulkan(&self) -> &Arc<terrafill_vulkan::Gpu> {
        self.vulkan.get().expect("opened both ways")
    }
}

/// Targets of one size on each device, made when they are first drawn on.
pub(crate) struct AllTargets<'a> {
    devices: &'a Devices,
    size: ImageSize,
    wgpu: OnceCell<terrafill_gpu::SharedTargets>,
    vulkan: OnceCell<terrafill_vulkan::SharedTargets>,
}

impl<'a> AllTargets<'a> {
    pub(crate) fn new(devices: &'a Devices, size: ImageSize) -> Self {
        Self {
            devices,
            size,
            wgpu: OnceCell::new(),
            vulkan: OnceCell::new(),
        }
    }

    pub(crate) fn wgpu(&self) -> &terrafill_gpu::SharedTargets {
        let make = || terrafill_gpu::RenderTargets::shared(&self.devices.wgpu, self.size);
        self.wgpu.get_or_init(|| make().expect("small targets"))
    }

    pub(crate) fn vulkan(&self) -> &terrafill_vulkan::SharedTargets {
        let make = || terrafill_vulkan::RenderTargets::shared(self.devices.vulkan(), self.size);
        self.vulkan.get_or_init(|| make().expect("small targets"))
    }

    /// What draws so.
    pub(crate) fn open(&self, technique: Technique) -> Box<dyn FillBackend> {
        match technique {
            Technique::Vertex(variant) => {
                Box::new(VertexBackend::new(self.wgpu(), variant).expect("valid shaders"))
            }
            Technique::Compute(variant) => {
                Box::new(ComputeBackend::new(self.wgpu(), variant).expect("valid shaders"))
            }
            Technique::Native(variant) => {
                Box::new(NativeBackend::new(self.vulkan(), variant).expect("has the features"))
            }
        }
    }

    /// The frame on targets that may hold the surface already.
    pub(crate) fn draw(&self, input: &FillInput, technique: Technique) -> Frame {
        draw_with(&mut *self.open(technique), input)
    }
}

/// The frame on targets of its own.
pub(crate) fn draw(devices: &Devices, input: &FillInput, technique: Technique) -> Frame {
    AllTargets::new(devices, input.size).draw(input, technique)
}

/// The frame by a backend that may have drawn others.
pub(crate) fn draw_with(backend: &mut (impl FillBackend + ?Sized), input: &FillInput) -> Frame {
    backend.prepare(input).expect("fits");
    backend.render(input).expect("draws")
}

/// What other backends are laid beside: doubled vertices with these switches.
pub(crate) fn vertex(switches: Switches) -> Technique {
    in_layout(Layout::Doubled, switches)
}

/// Vertices in a layout, with these switches.
pub(crate) fn in_layout(layout: Layout, switches: Switches) -> Technique {
    Technique::Vertex(VertexVariant {
        layout,
        switches,
        ..VertexVariant::default()
    })
}

/// Vertices in every layout, with these switches.
pub(crate) fn layouts(switches: Switches) -> Vec<Technique> {
    Layout::ALL.map(|layout| in_layout(layout, switches)).into()
}

/// One of the extrusions on Vulkan, with these switches.
pub(crate) fn native(technique: Extrusion, switches: Switches) -> Technique {
    Technique::Native(NativeVariant {
        technique,
        switches,
        ..NativeVariant::default()
    })
}

/// The same with indices of one kind.
pub(crate) fn stored(technique: Extrusion, indices: Indices, switches: Switches) -> Technique {
    Technique::Native(NativeVariant {
        technique,
        indices: Some(indices),
        switches,
        ..NativeVariant::default()
    })
}

/// Every extrusion with every kind of indices that it has.
pub(crate) fn storages() -> Vec<(Extrusion, Indices)> {
    let lists = Extrusion::ALL.map(|technique| (technique, Indices::List));
    let own = Extrusion::ALL.into_iter();
    let own = own.filter(|technique| technique.has_index_choice());
    let strips = own.map(|technique| (technique, Indices::Strip));
    lists.into_iter().chain(strips).collect()
}

/// Volumes made by compute shaders, with these switches.
pub(crate) fn compute(switches: Switches) -> Technique {
    Technique::Compute(ComputeVariant {
        switches,
        ..ComputeVariant::default()
    })
}

/// The same technique with other switches.
pub(crate) fn with_switches(mut technique: Technique, switches: Switches) -> Technique {
    match &mut technique {
        Technique::Vertex(variant) => variant.switches = switches,
        Technique::Compute(variant) => variant.switches = switches,
        Technique::Native(variant) => variant.switches = switches,
    }
    technique
}

/// Default switches but for the way of colouring.
pub(crate) fn with_colour(colour: ColourWay) -> Switches {
    Switches {
        colour,
        ..Switches::default()
    }
}

/// What the reference finds.
pub(crate) fn judge(input: &FillInput) -> Frame {
    ReferenceBackend::new().judge(input).expect("judges").frame
}

/// What the comparison with the reference says.
pub(crate) fn figures(reference: &Frame, frame: &Frame) -> ErrorFigures {
    compare(reference, frame).expect("same size")
}

/// Whether the frame may pass for what the reference found.
pub(crate) fn is_right(reference: &Frame, frame: &Frame) -> bool {
    verdict(&figures(reference, frame)).is_pass()
}

/// Pixels that belong to another region, or to one in one frame alone.
pub(crate) fn differing(a: &Frame, b: &Frame) -> usize {
    assert_eq!(a.ids.len(), b.ids.len());
    a.ids.iter().zip(&b.ids).filter(|(a, b)| a != b).count()
}

/// What a GPU backend counted.
pub(crate) fn counters(frame: &Frame) -> Counters {
    frame.counters.expect("a GPU backend counts")
}

/// Buffers, pipelines and uploads that a frame needed.
pub(crate) fn made(frame: &Frame) -> [u64; 3] {
    let found = counters(frame);
    [
        found.buffer_creations,
        found.pipeline_creations,
        found.uploads,
    ]
}

/// Longitude, latitude, height, heading, pitch, in degrees and metres.
pub(crate) type Pose = (f64, f64, f64, f64, f64);

/// A view of disjoint regions.
pub(crate) fn input(geojson: &str, body: Ellipsoid, rows: u32, pose: Pose) -> FillInput {
    let scene = scene(geojson, body, rows, Overlap::Disjoint);
    look(&scene, pose, pose.2 * 1e-3, SIZE)
}

/// Regions over a grid of `rows` rows.
pub(crate) fn scene(geojson: &str, body: Ellipsoid, rows: u32, overlap: Overlap) -> PreparedScene {
    let tolerance_m = body.equatorial_radius_m() * 1e-7;
    scene_within(tolerance_m, geojson, body, rows, overlap)
}

/// The same with boundaries this close to what the reference judges by.
pub(crate) fn scene_within(
    boundary_tolerance_m: f64,
    geojson: &str,
    body: Ellipsoid,
    rows: u32,
    overlap: Overlap,
) -> PreparedScene {
    let regions = parse_regions(geojson.as_bytes(), "test").expect("valid regions");
    let options = MeshOptions {
        boundary_tolerance_m,
        cap_step_deg: 3.0,
    };
    let meshes = RegionMesh::build_all(&regions, &body, EdgeRule::Planar, &options);
    PreparedScene {
        name: "test".to_owned(),
        body,
        edge_rule: EdgeRule::Planar,
        overlap,
        regions: regions.into(),
        meshes: RegionSet::default(),
        levels: Arc::default(),
        footprints: Arc::default(),
        bounds: SceneBounds::default(),
        parts: LazyParts::default(),
        surface: EllipsoidKind::surface(&body, rows),
        picture: None,
        texture: None,
    }
    .with_meshes(meshes.expect("meshes").into())
}

/// A view of `scene`.
pub(crate) fn look(scene: &PreparedScene, pose: Pose, near_m: f64, size: ImageSize) -> FillInput {
    let (longitude, latitude, height_m, heading, pitch) = pose;
    let view = View {
        name: "test".to_owned(),
        pose: CameraPose {
            eye: Geodetic::from_degrees(longitude, latitude, height_m),
            heading_rad: heading.to_radians(),
            pitch_rad: pitch.to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m,
        },
        note: None,
    };
    shown(scene, &view, size)
}

/// What a view shows, planned as usual.
pub(crate) fn shown(scene: &PreparedScene, view: &View, size: ImageSize) -> FillInput {
    FillInput::new(scene, view, size, PlanOptions::default()).expect("a surface")
}

pub(crate) fn named<'a>(views: &'a [View], name: &str) -> &'a View {
    let found = views.iter().find(|view| view.name == name);
    found.expect("one of the scene's views")
}

/// A shipped scene with its views.
pub(crate) fn shipped(name: &str) -> (PreparedScene, Vec<View>) {
    let scene = data::scene(name);
    let prepared = by_main::prepared(&[&EllipsoidKind], &scene);
    (prepared, scene.views)
}

/// A scene over the bare body with all its levels.
pub(crate) fn leveled(scene: &Scene) -> PreparedScene {
    let meshes = LeveledMeshes::build(scene, &scene.mesh).expect("meshes");
    let surface = open_surface(&[&EllipsoidKind], scene).expect("a surface");
    PreparedScene::leveled(scene, meshes, surface)
}

/// The same triangles, said to lie between the heights of their corners.
#[derive(Debug)]
struct WithoutSagitta(Arc<dyn Surface>);

/// All corners of a bare body's triangles.
const CORNERS: HeightRange = HeightRange {
    lowest_m: 0.0,
    highest_m: 0.0,
};

impl Surface for WithoutSagitta {
    fn kind(&self) -> &'static str {
        self.0.kind()
    }

    fn heights(&self, _extent: &Extent) -> HeightRange {
        CORNERS
    }

    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError> {
        Ok(SurfaceFrame {
            heights: CORNERS,
            parts: Arc::default(),
            ..self.0.frame(camera, size)?
        })
    }
}

/// The scene over a surface that hides how far its facets hang below the body.
pub(crate) fn without_sagitta(scene: &PreparedScene) -> PreparedScene {
    let surface = Arc::new(WithoutSagitta(Arc::clone(&scene.surface)));
    PreparedScene {
        surface,
        ..scene.clone()
    }
    .with_meshes(scene.meshes.clone())
}

/// A feature.
pub(crate) fn polygon(name: &str, rings: &str) -> String {
    format!(
        r#"{{"type":"Feature","properties":{{"name":"{name}"}},
            "geometry":{{"type":"Polygon","coordinates":[{rings}]}}}}"#
    )
}

/// Features as a file.
pub(crate) fn collection(features: &[String]) -> String {
    let joined = features.join(",");
    format!(r#"{{"type":"FeatureCollection","features":[{joined}]}}"#)
}
