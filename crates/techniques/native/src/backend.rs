// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend: its volumes, and the fill that every backend on Vulkan itself shares.

use crate::NativeVariant;
use crate::pass::NativeVolumes;
use std::sync::Arc;
use terrafill_fill::{
    Capabilities, Colours, DeviceError, FillBackend, FillInput, FillProgram, Frame, FrameTimes,
    MemoryUse, Picture, PositionFormat, RegionConstants, Uploaded,
};
use terrafill_vulkan::{SharedTargets, VolumeFill};

/// Shadow volumes extruded in geometry shaders, or by `vs-control` in the vertex shader.
#[derive(Debug)]
pub struct NativeBackend {
    variant: NativeVariant,
    fill: VolumeFill,
    volumes: NativeVolumes,
}

/// In pictures for people.
const OPAQUE: Colours = Colours::Palette { opacity: 1.0 };

impl NativeBackend {
    /// A backend on `targets`.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks `geometryShader`, `depthBounds` or
    /// depth that shaders can read, and the variant needs it.
    pub fn new(targets: &SharedTargets, variant: NativeVariant) -> Result<Self, DeviceError> {
        let gpu = Arc::clone(targets.borrow().gpu());
        if variant.technique.needs_geometry_shader() && !gpu.facts.features.geometry_shader {
            return Err(DeviceError::unsupported("geometryShader", &gpu.facts.name));
        }
        Ok(Self {
            variant,
            fill: VolumeFill::new(targets, "native", &variant.switches)?,
            volumes: NativeVolumes::new(variant),
        })
    }

    /// Extrusion and switches.
    #[must_use]
    pub fn variant(&self) -> NativeVariant {
        self.variant
    }

    /// Brings program and constants up to date; nothing is made or written where they are already.
    fn upload_view(&mut self, input: &FillInput, colours: Colours) -> Result<(), DeviceError> {
        let Some(place_of) = self.volumes.places() else {
            return self.fill.check_prepared(input);
        };
        let program = FillProgram::new(&input.plan, &self.variant.switches, input.scene.overlap)?;
        let positions = PositionFormat::Fixed;
        let constants = RegionConstants::bytes_of_all(input, positions, colours, place_of);
        self.fill.upload_view(input, program, constants)
    }

    /// Brings geometry, constants and pipelines up to date, and gives the bytes handed over.
    fn bring_up_to_date(&mut self, input: &FillInput) -> Result<u64, DeviceError> {
        let gpu = self.fill.gpu();
        let before = gpu.work_done();
        if !self.fill.holds_meshes(input) {
            self.volumes.upload(&gpu, &input.scene.meshes)?;
            self.fill.hold_meshes(input);
        }
        self.upload_view(input, Colours::Ids)?;
        self.fill.ensure_pipelines(&mut self.volumes, input)?;
        Ok(self.fill.count_work_since(before))
    }
}

impl FillBackend for NativeBackend {
    fn capabilities(&self) -> &Capabilities {
        self.fill.capabilities()
    }

    fn tells_regions_apart(&self) -> bool {
        self.variant.switches.colour.tells_regions_apart()
    }

    fn note(&self) -> Option<String> {
        self.fill.note()
    }

    fn prepare(&mut self, input: &FillInput) -> Result<MemoryUse, DeviceError> {
        input.check_region_count()?;
        self.fill.targets().borrow_mut().prepare(input)?;
        let upload_bytes = self.bring_up_to_date(input)?;
        let (bytes, buffers) = self.volumes.memory();
        Ok(MemoryUse {
            vertex_bytes: bytes.vertex_bytes,
            index_bytes: bytes.index_bytes,
            constant_bytes: RegionConstants::byte_count(input) + self.fill.textured_bytes(),
            target_bytes: self.fill.target_bytes(),
            texture_bytes: self.fill.texture_bytes(),
            // And the constants'.
            buffers: buffers + self.fill.constant_buffers(),
            upload_bytes,
        })
    }

    fn update(&mut self, input: &FillInput, changed: &[usize]) -> Result<Uploaded, DeviceError> {
        input.check_region_count()?;
        let changed = self.fill.check_update(input, changed)?;
        self.fill.targets().borrow_mut().prepare(input)?;
        let before = self.fill.gpu().work_done();
        self.fill.forget_meshes();
        let is_rewritten = self.volumes.rewrite(&input.scene.meshes, changed)?;
        if is_rewritten {
            self.fill.hold_meshes(input);
        }
        let rewritten_bytes = self.fill.count_work_since(before);
        let regions = if is_rewritten {
            changed.to_vec()
        } else {
            (0..input.scene.meshes.len()).collect()
        };
        Ok(Uploaded {
            bytes: rewritten_bytes + self.bring_up_to_date(input)?,
            regions,
        })
    }

    fn render(&mut self, input: &FillInput) -> Result<Frame, DeviceError> {
        let (picture, mut counters) = self.fill.draw_and_read(&self.volumes, input)?;
        counters.stencil_fragments = self.fill.count_fragments(&mut self.volumes, input)?;
        self.fill.frame(&self.volumes, input, &picture, counters)
    }

    fn picture(&mut self, input: &FillInput) -> Result<Picture, DeviceError> {
        self.upload_view(input, OPAQUE)?;
        let drawn = self.fill.draw_and_read(&self.volumes, input);
        self.upload_view(input, Colours::Ids)?;
        drawn.map(|(picture, _)| picture)
    }

    fn draw_surface(&mut self, input: &FillInput) -> Result<Option<f64>, DeviceError> {
        self.fill.draw_surface(input)
    }

    fn time_frame(&mut self, input: &FillInput) -> Result<FrameTimes, DeviceError> {
        self.fill.time_frame(&self.volumes, input)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::SceneGeometry;
    use crate::{Extrusion, Indices, strip_counts};
    use terrafill_core::RegionMesh;
    use terrafill_fill::{ColourWay, PreparedScene, Switches};
    use terrafill_scene::{ImageSize, PlanOptions, Scene};
    use terrafill_surface::{EllipsoidKind, open_surface};
    use terrafill_vulkan::Measured;

    /// California from the side: from above, walls turned against caps are hardly seen.
    fn california() -> FillInput {
        let scene = Scene::shipped("california", None).expect("it ships");
        let meshes =
            RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh);
        let surface = open_surface(&[&EllipsoidKind], &scene).expect("a surface");
        let prepared = PreparedScene::new(&scene, meshes.expect("meshes").into(), surface);
        let mut views = scene.views.iter();
        let view = views.find(|view| view.name == "horizon").expect("a view");
        let size = ImageSize {
            width: 256,
            height: 256,
        };
        FillInput::new(&prepared, view, size, PlanOptions::default()).expect("a surface")
    }

    /// Takes the strips of the only region apart and puts them together again, changed.
    fn change_strips(geometry: &mut SceneGeometry, change: impl FnOnce(&mut Vec<Vec<u16>>)) {
        let indices = std::mem::take(&mut geometry.indices.short);
        let strips = indices.split(|&index| index == u16::MAX);
        let mut strips: Vec<Vec<u16>> = strips.map(<[u16]>::to_vec).collect();
        change(&mut strips);
        geometry.indices.short = strips.join(&u16::MAX);
        let region = geometry.regions.first_mut().expect("one region");
        region.index_count = geometry.indices.count(true);
    }

    /// Of whole strips a device makes what it makes of lists, and of broken ones it does not.
    #[test]
    fn broken_strips_are_seen() {
        let Some(gpu) = terrafill_vulkan::open_for_test(&Default::default()) else {
            return;
        };
        // Regions that are counted: to bits that flip, all faces are alike.
        let switches = Switches {
            colour: ColourWay::Rectangle,
            ..Switches::default()
        };
        let input = california();
        let targets =
            terrafill_vulkan::RenderTargets::shared(&gpu, input.size).expect("small targets");
        // How many indices stand for a corner.
        for (technique, step) in [(Extrusion::GsDegenerate, 1), (Extrusion::GsAdjacency, 2)] {
            let drawn = |indices, change: &dyn Fn(&mut SceneGeometry)| {
                let variant = NativeVariant {
                    technique,
                    indices: Some(indices),
                    switches,
                };
                let mut backend = NativeBackend::new(&targets, variant).expect("has the features");
                backend.prepare(&input).expect("fits");
                let mut geometry = SceneGeometry::build(technique, indices, &input.scene.meshes);
                change(&mut geometry);
                let gpu = backend.fill.gpu();
                let uploaded = backend.volumes.upload_geometry(&gpu, geometry);
                uploaded.expect("fits");
                backend.render(&input).expect("draws").ids
            };
            let list = drawn(Indices::List, &|_| {});
            let filled = list.iter().filter(|id| **id > 0).count();
            assert!(filled > 1000, "{filled}");
            let differing = |change: &dyn Fn(&mut Vec<Vec<u16>>)| {
                let ids = drawn(Indices::Strip, &|geometry| change_strips(geometry, change));
                let both = ids.iter().zip(&list);
                both.filter(|(found, expected)| found != expected).count()
            };
            let name = technique.name();
            assert_eq!(differing(&|_| {}), 0, "{name}");
            let turned_over = differing(&|strips| {
                for strip in strips.iter_mut().filter(|strip| !strip.is_empty()) {
                    strip.splice(0..0, strip[..step].to_vec());
                }
            });
            assert!(turned_over > 100, "{name}, parity: {turned_over}");
            let joined = differing(&|strips| *strips = vec![strips.concat()]);
            assert!(joined > 100, "{name}, restarts missing: {joined}");
            if technique == Extrusion::GsAdjacency {
                let swapped = differing(&|strips| {
                    for strip in strips.iter_mut().filter(|strip| !strip.is_empty()) {
                        strip.swap(1, 3);
                    }
                });
                assert!(swapped > 100, "neighbours swapped: {swapped}");
            }
        }
    }

    /// A device that took a restart for a vertex, or turned a strip otherwise, would be given more.
    #[test]
    fn geometry_shaders_are_given_what_the_strips_hold() {
        let Some(gpu) = terrafill_vulkan::open_for_test(&Default::default()) else {
            return;
        };
        if !gpu.facts.features.pipeline_statistics {
            eprintln!("skipped: no pipeline statistics");
            return;
        }
        let input = california();
        let mesh = &input.scene.meshes[0];
        let (triangles, edges) = (mesh.triangle_count(), mesh.boundary_edge_count());
        let in_strips = triangles + strip_counts(mesh).repeated;
        let between = edges - mesh.boundary_loops.len();
        let targets =
            terrafill_vulkan::RenderTargets::shared(&gpu, input.size).expect("small targets");
        let (list, strip) = (Indices::List, Indices::Strip);
        for (technique, indices, expected) in [
            (Extrusion::GsDegenerate, list, triangles + edges),
            (Extrusion::GsDegenerate, strip, in_strips + edges + between),
            (Extrusion::GsAdjacency, list, triangles),
            (Extrusion::GsAdjacency, strip, in_strips),
        ] {
            let variant = NativeVariant {
                technique,
                indices: Some(indices),
                ..NativeVariant::default()
            };
            let mut backend = NativeBackend::new(&targets, variant).expect("has the features");
            backend.prepare(&input).expect("fits");
            backend.render(&input).expect("draws");
            let statistics = Measured::Statistics;
            let measured = backend.fill.measure(&backend.volumes, &input, statistics);
            let (report, _) = measured.expect("draws");
            let given = report.statistics.expect("has the feature");
            let what = (technique.name(), indices.name());
            let found = given.geometry_shader_invocations;
            assert_eq!(found, Some(expected as u64), "{what:?}");
            let made = 2 * (triangles + edges) as u64;
            assert_eq!(given.geometry_shader_primitives, Some(made), "{what:?}");
        }
        // Twin: some corners are said again, and some edges are not the first of their loop.
        assert!(in_strips > triangles && between > 0);
    }
}
