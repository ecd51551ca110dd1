// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is said of a probe frame: its figures, what speaks against it, and which of its pictures are written.

use super::ViewSession;
use super::drawn::ProbePicture;
use super::references::Against;
use crate::cases::FillCase;
use crate::driver_fault::LostPixels;
use crate::keys::WALL_SHIFT_M;
use crate::probe::{Probe, failed, tallest_wall_allowed};
use crate::purpose::Purpose;
use crate::subject::Subject;
use crate::textured::ShownPicture;
use terrafill_conformance::{
    ErrorFigures, Verdict as Comparison, checks_nothing, movement_in_picture, verdict_of_moved,
};
use terrafill_contract::Frame;
use terrafill_plan::{DrawnAs, FramePlan, PlannedRegion};
use terrafill_results::{Status, Verdict};
use terrafill_study::{Driver, Failure, StudyError};
use terrafill_variant::{ColourWay, RouteChoice};

/// Why a row lacks the times of its passes.
const ALTERNATING: &str =
    "stencil and colour alternate region by region: no GPU times of their own";

/// Why texels of a fill that only reads depth and samples once are not compared.
const NOT_MAPPED: &str = "a lower limit: its fragments read their depth and sample the picture \
                          once, nowhere in particular, so that its texels have no error";

impl ViewSession<'_> {
    /// Holds a probe frame against the reference.
    pub(super) fn compare(
        &mut self,
        case: &FillCase,
        drawn: &mut ProbePicture,
    ) -> Result<Verdict, Failure> {
        let against = self.references.against(case);
        self.references.of(against)?;
        let is_rival = case.is(Purpose::Rival);
        let mut probe = Probe::new(case, drawn.memory, &drawn.frame);
        // A rival makes no use of our plans and meshes.
        if !is_rival {
            probe.add_input(&drawn.input);
            probe.add("plan_cpu_ms", drawn.plan_cpu_ms);
            probe.add("prepare_cpu_ms", Some(drawn.prepare_cpu_ms));
        }
        let mesh = case.mesh.as_ref().map(|(mesh, _)| *mesh);
        let mesh = mesh.unwrap_or(self.group.scene.mesh);
        if case.is(Purpose::Subdivision) {
            probe.add("wall_bound_m", tallest_wall_allowed(&drawn.input, &mesh));
        }
        let shift_m = case.subject.figure(WALL_SHIFT_M.name, &drawn.input);
        probe.add("wall_shift_m", shift_m);
        if tells_needs(case) {
            let needs = drawn.backend.needs(&drawn.input).map_err(failed)?;
            if let Some(needs) = needs {
                probe.add_needs(&needs);
            }
        }
        // What is timed is a frame like the one before it.
        if case.frames > 0 {
            let again = drawn.backend.render_uncounted(&drawn.input);
            let again = again.map_err(failed)?;
            if let Some(counters) = &again.counters {
                probe.add_steady(counters);
            }
        }
        let (mask_hash, ids_hash) = drawn.hashes();
        let texture_route = drawn.backend.note().unwrap_or_default();
        let is_approximate = case.subject.is_approximate();
        let moved_px = moved_px(&drawn.input.plan);
        let hash = (mask_hash.as_str(), ids_hash.as_str());
        let options = case.subject.plan();
        let may_move = options.boundary_lod_px.is_some() || options.far_level_px.is_some();
        let is_moved = may_move && !is_approximate;
        match self
            .references
            .figures(hash, &drawn.frame, is_moved, against)
        {
            Ok(figures) if is_approximate => {
                let reasons = reasons_of(verdict_of_moved(&figures, 0.0));
                let reference = &self.references.of(against)?.frame;
                let moved = movement_in_picture(reference, &drawn.frame);
                probe.add_errors(&ErrorFigures {
                    boundary_moved_px: moved.ok().flatten(),
                    ..figures
                });
                probe.set_approximate(&reasons);
            }
            Ok(figures) => {
                let mut reasons = reasons_of(verdict_of_moved(&figures, moved_px));
                let is_mask_right = reasons.is_empty();
                probe.add_errors(&figures);
                if is_mapped(&case.subject) {
                    let compared = self.textured_references.compare(&drawn.input, &drawn.frame);
                    probe.texture_errors = compared.0;
                    reasons.extend(compared.1);
                }
                probe.set_status(&reasons);
                if let Some(fault) = self.driver_fault(case) {
                    let settled = self.settle(fault, &reasons, (hash.1, moved_px), &drawn.frame)?;
                    (probe.status, probe.reason) = settled;
                }
                probe.let_off_if_all_silhouette(is_mask_right);
            }
            Err(error) => {
                probe.status = Status::Failed;
                probe.reason = error;
            }
        }
        if route(&case.subject).is_some() && !is_mapped(&case.subject) {
            probe.remark(NOT_MAPPED);
        }
        if case.frames > 0 && one_at_a_time(&case.subject) {
            probe.remark(ALTERNATING);
        }
        let is_shown = case.is_compared() || case.is(Purpose::Rival);
        let is_plain_main = is_shown && !case.variant_name().contains('=');
        let is_plain_main = is_plain_main || case.is(Purpose::Suite);
        // Of an approximate fill one picture a view shows what it is like.
        let is_wrong = probe.status == Status::Wrong && !is_approximate;
        if is_plain_main || is_wrong {
            let reference = self.references.of(against)?;
            let as_mask = ids_hash.is_empty();
            self.pictures
                .write(case, drawn, reference, as_mask, &mut probe)?;
        }
        if route(&case.subject).is_some() && (is_wrong || shows_chosen(case)) {
            let references = &self.textured_references;
            self.pictures
                .write_textured(case, drawn, references, &mut probe)?;
        }
        let reference = self.references.of(against)?;
        let (all, outside) = reference.disagreements;
        probe.add_counts([
            ("reference_disagreements", Some(all)),
            ("reference_disagreements_outside_band", Some(outside)),
        ]);
        if let Some([largest, p99]) = reference.moved_px_true {
            probe.add("moved_px_true", Some(largest));
            probe.add("moved_px_true_p99", Some(p99));
        }
        if !probe.has_note("reference_image") {
            probe.note("reference_image", reference.image.clone());
        }
        probe.note("map_image", self.references.map()?);
        if checks_nothing(&reference.frame) {
            probe.remark("no region boundary in sight: this view checks nothing");
        }
        if let Some(note) = &self.group.view.note {
            probe.remark(note);
        }
        probe.note("mask_hash", mask_hash);
        probe.note("ids_hash", ids_hash);
        probe.note("texture_route", texture_route);
        Ok(probe.verdict())
    }

    /// The pixels that the driver is known to lose of a case.
    fn driver_fault(&self, case: &FillCase) -> Option<&'static LostPixels> {
        if case.subject.api() != terrafill_gpu::API {
            return None;
        }
        let targets = self.wgpu.borrow();
        let facts = &targets.gpu().facts;
        let driver = Driver {
            name: &facts.name,
            info: &facts.driver_info,
        };
        let group = self.group;
        LostPixels::of(
            driver,
            &group.scene.name,
            &group.view.name,
            group.size,
            case,
        )
    }

    /// How a case ends of which the driver is known to lose pixels: as the picture without them.
    ///
    /// - `reasons`: against the picture as drawn
    fn settle(
        &self,
        fault: &LostPixels,
        reasons: &[String],
        (ids_hash, moved_px): (&str, f64),
        frame: &Frame,
    ) -> Result<(Status, String), StudyError> {
        let as_mask = ids_hash.is_empty();
        let against = Against::scene(self.group.scene.edge_rule);
        let reference = &self.references.of(against)?.frame;
        let (excused, differing) = fault.excused(frame, reference, as_mask);
        let figures = self
            .references
            .compare_pixels(&excused, as_mask, moved_px > 0.0, against);
        let against = figures.map(|figures| reasons_of(verdict_of_moved(&figures, moved_px)));
        let against = against.unwrap_or_else(|error| vec![error]);
        Ok(fault.settle(reasons, &against, differing))
    }
}

/// How regions find their places in a picture; `None` of a plain fill.
fn route(subject: &Subject) -> Option<RouteChoice> {
    subject.switches()?.texture
}

/// Whether what regions are filled with has its place on the ground.
fn is_mapped(subject: &Subject) -> bool {
    route(subject).is_some_and(|route| route != RouteChoice::Floor)
}

/// Whether the case is a textured fill as it should be used.
pub(super) fn shows_chosen(case: &FillCase) -> bool {
    route(&case.subject) == Some(RouteChoice::Chosen) && case.shown == ShownPicture::Scene
}

/// Whether a case lists what it holds and leaves out: compared cases without switches, and cases about needs.
fn tells_needs(case: &FillCase) -> bool {
    let is_plain_main = case.is_compared() && !case.variant_name().contains('=');
    case.is(Purpose::Needs) || is_plain_main || shows_chosen(case)
}

/// Whether stencil and colour share a pass.
fn one_at_a_time(subject: &Subject) -> bool {
    let colour = subject.switches().map(|switches| switches.colour);
    matches!(colour, Some(ColourWay::Rectangle | ColourWay::Volume))
}

/// What speaks against a picture.
pub(super) fn reasons_of(verdict: Comparison) -> Vec<String> {
    match verdict {
        Comparison::Pass => Vec::new(),
        Comparison::Fail(reasons) => reasons,
    }
}

/// By how many pixels a plan may have moved boundaries on purpose. Where all that is drawn is as it was written,
/// boundaries are off by rounding alone, which the band around them allows for.
pub(super) fn moved_px(plan: &FramePlan) -> f64 {
    let has_coarser = plan.regions.iter().any(|of| of.mesh != of.region);
    let is_flat = |of: &PlannedRegion| of.drawn_as == DrawnAs::FlatMesh;
    let has_flat = plan.regions.iter().any(is_flat);
    let options = &plan.options;
    let by_level = options.boundary_lod_px.filter(|_| has_coarser);
    let by_height = options.far_level_px.filter(|_| has_flat);
    by_level.unwrap_or(0.0) + by_height.unwrap_or(0.0)
}
