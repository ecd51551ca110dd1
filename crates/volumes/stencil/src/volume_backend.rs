// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend of every technique that fills regions by volumes, on whatever interface.
//!
//! A technique says how meshes become volumes ([`RegionVolumes`]) and a device crate runs stencil
//! programs ([`StencilExecutor`]); this keeps both up to date with the input, and counts and measures
//! alike for all.

use crate::needs::needs_of;
use crate::textured_work::TexturedWork;
use crate::uses::Uses;
use crate::{
    FillProgram, HeldMeshes, Holding, PositionFormat, StencilExecutor, StencilWork,
    VolumeConstants, VolumeList, VolumePlace,
};
use terrafill_contract::{
    Colours, Counters, DeviceError, FillBackend, FillInput, Frame, FrameTimes, MemoryUse, Needs,
    Picture, Uploaded, ViewId, WorkDone,
};
use terrafill_scene::Overlap;
use terrafill_variant::Switches;

/// Volumes of the regions of a scene, made and drawn by one technique.
pub trait RegionVolumes: Sized {
    /// Name of the technique in rows.
    const TECHNIQUE: &'static str;
    /// What draws them.
    type Executor: StencilExecutor<Self>;
    /// The technique's parameters and switches.
    type Variant: Copy;

    /// The switches of a variant.
    ///
    /// # Errors
    /// [`DeviceError::Switch`] when its parameters do not go together.
    fn switches(variant: Self::Variant) -> Result<Switches, DeviceError>;

    /// Volumes of no scene yet.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks what the variant needs;
    /// [`DeviceError::Shader`].
    fn new(executor: &Self::Executor, variant: Self::Variant) -> Result<Self, DeviceError>;

    /// Whether bottom caps take bytes of their own; others are made by the device as they are drawn.
    fn stores_bottom_caps(&self) -> bool {
        false
    }

    /// Uploads every mesh of the scene, the bottom caps of some.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`]. The scene before stays.
    fn upload(
        &mut self,
        executor: &Self::Executor,
        input: &FillInput,
        bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError>;

    /// Writes the changed meshes over what they were. False, with nothing written, where one of
    /// them does not fit into its old place.
    ///
    /// # Errors
    /// As [`RegionVolumes::upload`].
    fn rewrite(
        &mut self,
        _executor: &Self::Executor,
        _input: &FillInput,
        _changed: &[usize],
    ) -> Result<bool, DeviceError> {
        Ok(false)
    }

    /// Makes what only this view needs, the bottom caps of some meshes among it.
    ///
    /// # Errors
    /// As [`RegionVolumes::upload`].
    fn upload_view(
        &mut self,
        _executor: &Self::Executor,
        _input: &FillInput,
        _bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        Ok(())
    }

    /// Where a mesh lies; `None` before anything is uploaded.
    fn places(&self) -> Option<impl Fn(usize) -> VolumePlace>;

    /// How positions are stored.
    fn positions(&self) -> PositionFormat {
        PositionFormat::Fixed
    }

    /// Opacity of regions in pictures for people.
    ///
    /// # Errors
    /// [`DeviceError::Switch`] when the variant cannot draw such a picture.
    fn opacity(&self, _overlap: Overlap) -> Result<f32, DeviceError> {
        Ok(1.0)
    }

    /// What they hold, besides the constants of the regions.
    fn holdings(&self) -> Vec<Holding>;

    /// Vertices of the last frame's draws whose size only the device knows.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    fn vertices_by_device(&self, _executor: &Self::Executor) -> Result<u64, DeviceError> {
        Ok(0)
    }
}

/// Fills regions by volumes.
#[derive(Debug)]
pub struct VolumeBackend<V: RegionVolumes> {
    switches: Switches,
    variant: V::Variant,
    executor: V::Executor,
    volumes: V,
    textured: TexturedWork,
    /// Revision of the meshes that the volumes hold.
    meshes: Option<u64>,
    /// Which of them.
    held: HeldMeshes,
    /// Of which of them they hold bottom caps.
    bottoms: HeldMeshes,
    /// View of the program that the executor holds.
    view: Option<ViewId>,
    /// What the device did since the last frame, for the next one's counters.
    work: WorkDone,
    /// What the device made since this was opened.
    made: WorkDone,
}

impl<V: RegionVolumes> VolumeBackend<V> {
    /// A backend that draws `variant` into `targets`.
    ///
    /// # Errors
    /// [`DeviceError::Switch`] when the variant's parameters do not go together;
    /// [`DeviceError::Unsupported`] for what device or interface lack; [`DeviceError::Shader`].
    pub fn new(
        targets: &<V::Executor as StencilExecutor<V>>::Targets,
        variant: V::Variant,
    ) -> Result<Self, DeviceError> {
        let switches = V::switches(variant)?;
        let executor = V::Executor::new(targets, &switches)?;
        let before = executor.work_done();
        let volumes = V::new(&executor, variant)?;
        Ok(Self {
            made: executor.work_done() - before,
            switches,
            variant,
            volumes,
            executor,
            textured: TexturedWork::default(),
            meshes: None,
            held: HeldMeshes::All,
            bottoms: HeldMeshes::default(),
            view: None,
            work: WorkDone::default(),
        })
    }

    /// Parameters and switches.
    #[must_use]
    pub fn variant(&self) -> V::Variant {
        self.variant
    }

    /// What it draws with.
    #[must_use]
    pub fn executor(&self) -> &V::Executor {
        &self.executor
    }

    /// What it draws.
    #[must_use]
    pub fn volumes(&self) -> &V {
        &self.volumes
    }

    /// What it draws, to be changed.
    #[must_use]
    pub fn volumes_mut(&mut self) -> &mut V {
        &mut self.volumes
    }

    fn check_prepared(&self, input: &FillInput) -> Result<(), DeviceError> {
        input.check_prepared(V::TECHNIQUE, self.meshes, self.view)
    }

    /// What is drawn of `input`, and how.
    fn program(&self, input: &FillInput) -> Result<(VolumeList, FillProgram), DeviceError> {
        let is_bent = self.switches.bends_footprints
            && self.volumes.positions() == PositionFormat::Fixed
            && self.switches.texture.is_none();
        if !input.scene.footprints.is_empty() && !is_bent {
            let what = "bending footprints without vertices=bent and positions=fixed";
            return Err(DeviceError::unsupported(what, &self.executor.adapter()));
        }
        let list = VolumeList::of(input, &self.switches);
        let program = FillProgram::new(&list.volumes, &self.switches, input.scene.overlap)?;
        Ok((list, program))
    }

    /// Brings program and constants up to date. Where that fails after something was changed,
    /// nothing is prepared any more.
    fn load(
        &mut self,
        input: &FillInput,
        (list, program): (VolumeList, FillProgram),
        colours: Colours,
        blends: bool,
    ) -> Result<(), DeviceError> {
        let bottoms = HeldMeshes::bottoms_drawn_by(&program, &list, &self.switches);
        self.view = None;
        self.volumes.upload_view(&self.executor, input, &bottoms)?;
        let places = self.volumes.places();
        let place_of = places.ok_or_else(|| input.not_prepared(V::TECHNIQUE))?;
        let positions = self.volumes.positions();
        let constants = VolumeConstants::bytes_of_all(input, positions, colours, place_of);
        let textured = &mut self.textured;
        textured.upload(&mut self.executor, input, &self.switches)?;
        self.executor.load(StencilWork {
            list,
            program,
            constants,
            blends,
        })?;
        self.view = Some(input.view_id);
        Ok(())
    }

    /// Uploads what is not there yet, and gives the bytes handed over since `before`, and whether all meshes
    /// that are held were among them.
    fn bring_up_to_date(
        &mut self,
        input: &FillInput,
        before: WorkDone,
    ) -> Result<(u64, bool), DeviceError> {
        let (list, program) = self.program(input)?;
        let revision = Some(input.scene.meshes.revision());
        let mut bottoms = HeldMeshes::bottoms_drawn_by(&program, &list, &self.switches);
        let is_new = self.meshes != revision;
        let mut held = HeldMeshes::needed_by(&list, &self.switches);
        let lacks_bottoms = self.volumes.stores_bottom_caps() && !self.bottoms.hold(&bottoms);
        let lacks = lacks_bottoms || !self.held.hold(&held);
        if is_new || lacks {
            if !is_new {
                // What an earlier view needed, the next one may need again.
                bottoms = bottoms.joined(&self.bottoms);
                let meshes = input.scene.meshes.len();
                held = self.held.followed_by(&held, &input.scene.levels, meshes);
            }
            self.upload(input, &held, &bottoms)?;
            (self.meshes, self.held, self.bottoms) = (revision, held, bottoms);
        }
        self.load(input, (list, program), Colours::Ids, false)?;
        self.executor.ensure(&mut self.volumes)?;
        let done = self.executor.work_done() - before;
        self.work = self.work + done;
        self.made = self.made + done;
        Ok((done.upload_bytes, is_new || lacks))
    }

    /// Uploads the meshes that are to be held; the others keep their places, empty.
    fn upload(
        &mut self,
        input: &FillInput,
        held: &HeldMeshes,
        bottoms: &HeldMeshes,
    ) -> Result<(), DeviceError> {
        if *held == HeldMeshes::All {
            return self.volumes.upload(&self.executor, input, bottoms);
        }
        let mut of_held = input.clone();
        of_held.scene.meshes = input.scene.meshes.with_geometry_of(|mesh| held.has(mesh));
        self.volumes.upload(&self.executor, &of_held, bottoms)
    }

    /// What all parts of the backend hold.
    fn holdings(&self) -> Vec<Holding> {
        let mut all = self.volumes.holdings();
        all.extend(self.executor.holdings());
        all
    }

    /// Fills the surface that the targets hold, without counting fragments.
    fn filled(&mut self, input: &FillInput) -> Result<Frame, DeviceError> {
        let before = self.executor.work_done();
        let (picture, mut counters) = self.draw_and_read()?;
        counters.vertices += self.volumes.vertices_by_device(&self.executor)?;
        let plain = Frame::from_picture(&picture, counters);
        let frame = match self.textured.plan() {
            None => plain,
            Some(plan) => {
                let probed = if plan.covers.is_empty() {
                    vec![None; input.size.pixel_count()]
                } else {
                    self.executor.probe(&mut self.volumes)?
                };
                plan.frame(input, plain, &probed)
            }
        };
        self.made = self.made + (self.executor.work_done() - before);
        Ok(frame)
    }

    /// Fills the surface that the targets hold and reads the picture back.
    fn draw_and_read(&mut self) -> Result<(Picture, Counters), DeviceError> {
        let before = self.executor.work_done();
        let mut counters = self.executor.draw(&mut self.volumes)?;
        let prepared = std::mem::take(&mut self.work);
        WorkDone::write_into(&mut counters, prepared, self.executor.work_done() - before);
        let picture = self.executor.targets().borrow().read()?;
        Ok((picture, counters))
    }
}

impl<V: RegionVolumes> FillBackend for VolumeBackend<V> {
    fn tells_regions_apart(&self) -> bool {
        self.switches.colour.tells_regions_apart()
    }

    fn note(&self) -> Option<String> {
        self.textured.plan().map(|plan| plan.note())
    }

    fn prepare(&mut self, input: &FillInput) -> Result<MemoryUse, DeviceError> {
        input.check_region_count()?;
        let view = input.into();
        self.executor.targets().borrow_mut().prepare(view)?;
        let (upload_bytes, _) = self.bring_up_to_date(input, self.executor.work_done())?;
        let uploaded = MemoryUse {
            upload_bytes,
            ..MemoryUse::default()
        };
        let held = self.holdings().into_iter().map(|held| held.memory);
        Ok(held.fold(uploaded, std::ops::Add::add))
    }

    fn needs(&self, input: &FillInput) -> Result<Option<Needs>, DeviceError> {
        self.check_prepared(input)?;
        let (list, program) = self.program(input)?;
        let uses = Uses::new(input, &list, &program, &self.switches);
        let held = self.holdings();
        let found = (held.as_slice(), self.made);
        let drawn = HeldMeshes::bottoms_drawn_by(&program, &list, &self.switches);
        let bottoms = if self.volumes.stores_bottom_caps() {
            &self.bottoms
        } else {
            &drawn
        };
        let needs = needs_of(input, &self.switches, &uses, (&self.held, bottoms), found);
        Ok(Some(needs))
    }

    fn update(&mut self, input: &FillInput, changed: &[usize]) -> Result<Uploaded, DeviceError> {
        input.check_region_count()?;
        let changed = input.check_update(V::TECHNIQUE, self.meshes, changed)?;
        let view = input.into();
        self.executor.targets().borrow_mut().prepare(view)?;
        let before = self.executor.work_done();
        self.meshes = None;
        // What is not held is handed over when a view draws it.
        let on_device: Vec<usize> = changed
            .iter()
            .copied()
            .filter(|mesh| self.held.has(*mesh))
            .collect();
        let is_rewritten = self.volumes.rewrite(&self.executor, input, &on_device)?;
        if is_rewritten {
            self.meshes = Some(input.scene.meshes.revision());
        }
        let (bytes, has_all) = self.bring_up_to_date(input, before)?;
        let regions = if has_all {
            (0..input.scene.meshes.len())
                .filter(|mesh| self.held.has(*mesh))
                .collect()
        } else {
            on_device
        };
        Ok(Uploaded { bytes, regions })
    }

    fn render(&mut self, input: &FillInput) -> Result<Frame, DeviceError> {
        self.check_prepared(input)?;
        self.draw_surface(input)?;
        let mut frame = self.filled(input)?;
        let before = self.executor.work_done();
        let fragments = self.executor.count_fragments(&mut self.volumes)?;
        self.made = self.made + (self.executor.work_done() - before);
        if let Some(counters) = &mut frame.counters {
            counters.stencil_fragments = fragments;
        }
        Ok(frame)
    }

    fn render_uncounted(&mut self, input: &FillInput) -> Result<Frame, DeviceError> {
        self.check_prepared(input)?;
        // Anew, or the colours of an earlier fill would stay in pixels that this one leaves alone.
        self.draw_surface(input)?;
        self.filled(input)
    }

    fn picture(&mut self, input: &FillInput) -> Result<Picture, DeviceError> {
        self.check_prepared(input)?;
        let opacity = self.volumes.opacity(input.scene.overlap)?;
        let view = input.into();
        self.executor.targets().borrow_mut().prepare(view)?;
        let before = self.executor.work_done();
        let work = self.program(input)?;
        let colours = Colours::Palette { opacity };
        self.load(input, work.clone(), colours, opacity < 1.0)?;
        let made = self.executor.ensure(&mut self.volumes);
        let drawn = made.and_then(|()| {
            self.draw_surface(input)?;
            self.draw_and_read()
        });
        self.load(input, work, Colours::Ids, false)?;
        self.made = self.made + (self.executor.work_done() - before);
        drawn.map(|(picture, _)| picture)
    }

    fn draw_surface(&mut self, input: &FillInput) -> Result<Option<f64>, DeviceError> {
        let mut targets = self.executor.targets().borrow_mut();
        targets.prepare(input.into())?;
        targets.draw_surface()
    }

    fn time_frame(&mut self, input: &FillInput) -> Result<FrameTimes, DeviceError> {
        self.check_prepared(input)?;
        // Another backend of the targets may have drawn another view since.
        if !self.executor.holds_surface(input.view_id) {
            return Err(input.not_prepared(V::TECHNIQUE));
        }
        self.executor.time(&mut self.volumes)
    }
}
