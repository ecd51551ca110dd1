// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a view's pictures are compared with: its references, and what was found of each picture.

use crate::cases::{FillCase, ViewGroup};
use crate::images::file_stem;
use crate::subject::Subject;
use std::borrow::Cow;
use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;
use terrafill_conformance::{
    BAND_RADIUS_PX, BORDER_ROUNDING, ErrorFigures, MAX_HAUSDORFF_PX, boundary_band,
    boundary_movement, boundary_rounding, compare_closely, filled_only, with_movement,
};
use terrafill_contract::{FillInput, Frame, Technique, paint};
use terrafill_core::EdgeRule;
use terrafill_reference::{CloseLook, MapPicture, ReferenceBackend, ReferenceScene};
use terrafill_results::quantile;
use terrafill_scene::ImageSize;
use terrafill_study::{StudyError, write_photo, write_rgb};
use terrafill_variant::Variant;

/// Errors of a picture, or why it could not be compared.
type Compared = Result<ErrorFigures, String>;

/// Longer side of a map, pixels.
const MAP_PX: u32 = 256;

/// The reference's picture of the view.
pub(super) struct Reference {
    pub(super) frame: Frame,
    /// With all regions as one.
    filled: Frame,
    /// Pixels on which its two inside tests disagree, in all and outside the boundary band.
    pub(super) disagreements: (u64, u64),
    /// Of the boundary as drawn from the true one: largest and 99th percentile.
    pub(super) moved_px_true: Option<[f64; 2]>,
    pub(super) image: String,
    /// What it was judged by, for who looks more closely.
    rays: ReferenceScene,
}

impl Reference {
    /// Its picture and another as they are compared: of a fill in one colour only whether a pixel is filled counts.
    pub(super) fn beside<'f>(&self, frame: &'f Frame, as_mask: bool) -> (&Frame, Cow<'f, Frame>) {
        if as_mask {
            (&self.filled, Cow::Owned(filled_only(frame)))
        } else {
            (&self.frame, Cow::Borrowed(frame))
        }
    }
}

/// What a picture is compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Against {
    /// What a ring edge is.
    pub(super) edges: EdgeRule,
    /// The body itself, and not the scene's surface as drawn.
    is_on_body: bool,
}

impl Against {
    /// What a technique draws on a scene whose edges are of this rule.
    pub(super) fn of(technique: &dyn Technique, variant: &Variant, scene: EdgeRule) -> Self {
        Self {
            edges: technique.edge_rule(variant, scene),
            is_on_body: technique.draws_own_surface(),
        }
    }

    /// What the scene says.
    pub(super) fn scene(edges: EdgeRule) -> Self {
        Self {
            edges,
            is_on_body: false,
        }
    }

    pub(super) fn reference(self) -> ReferenceBackend {
        if self.is_on_body {
            ReferenceBackend::on_body()
        } else {
            ReferenceBackend::new()
        }
    }
}

/// References of one view.
pub(super) struct References<'a> {
    group: &'a ViewGroup,
    folder: &'a Path,
    /// What the scene's mesh options give.
    input: Rc<FillInput>,
    /// Drawn when the first picture is compared: a process that only measures again needs none. By the
    /// scene's edge rule on its surface, and by what else a rival has.
    drawn: [OnceCell<Reference>; 4],
    /// File of the view as a map shows it.
    map: OnceCell<String>,
    /// What the comparison of each picture found: equal pictures get equal figures.
    compared: BTreeMap<(String, u64, bool, usize), Compared>,
}

impl<'a> References<'a> {
    pub(super) fn new(group: &'a ViewGroup, folder: &'a Path, input: &Rc<FillInput>) -> Self {
        Self {
            group,
            folder,
            input: Rc::clone(input),
            drawn: Default::default(),
            map: OnceCell::new(),
            compared: BTreeMap::new(),
        }
    }

    /// What a case's picture is compared with.
    pub(super) fn against(&self, case: &FillCase) -> Against {
        let scene = self.group.scene.edge_rule;
        match &case.subject {
            Subject::Baseline(_) => Against::scene(scene),
            Subject::Fill(technique, variant) => Against::of(*technique, variant, scene),
        }
    }

    /// The scene's input with edges of this rule, for the reference.
    fn input_of(&self, edges: EdgeRule) -> FillInput {
        let mut input = FillInput::clone(&self.input);
        input.scene.edge_rule = edges;
        input
    }

    /// Its place among the references.
    fn place(&self, against: Against) -> usize {
        let is_others = against.edges != self.group.scene.edge_rule;
        2 * usize::from(against.is_on_body) + usize::from(is_others)
    }

    pub(super) fn of(&self, against: Against) -> Result<&Reference, StudyError> {
        let place = self.place(against);
        let cell = &self.drawn[place];
        if let Some(reference) = cell.get() {
            return Ok(reference);
        }
        let (reference, input) = (against.reference(), self.input_of(against.edges));
        let rays = reference.scene(&input);
        let rays = rays.map_err(|error| self.group.broken(&error))?;
        let drawn = reference.judge_in(&input, &rays);
        let band = boundary_band(&drawn.frame);
        let disagree = drawn.disagreements.iter().zip(&band);
        let outside = disagree.filter(|&(&differ, &near)| differ && !near).count() as u64;
        let (scene, view) = (&self.group.scene.name, &self.group.view.name);
        let mut name = format!("{scene}_{view}_reference");
        if place > 0 {
            name.push_str(&format!("_{place}"));
        }
        let ImageSize { width, height } = self.group.size;
        let image = write_rgb(self.folder, &name, [width, height], &paint(&drawn.frame))?;
        Ok(cell.get_or_init(|| Reference {
            disagreements: (drawn.disagreement_px(), outside),
            moved_px_true: drawn.moved_px_true.as_deref().and_then(largest_and_p99),
            filled: filled_only(&drawn.frame),
            frame: drawn.frame,
            rays,
            image,
        }))
    }

    /// File of the view as a small map, for people: pictures that are judged show neither terrain nor horizon.
    pub(super) fn map(&self) -> Result<String, StudyError> {
        if let Some(known) = self.map.get() {
            return Ok(known.clone());
        }
        let map = MapPicture::small(&self.input, MAP_PX);
        let map = map.map_err(|error| self.group.broken(&error))?;
        let (scene, view) = (&self.group.scene.name, &self.group.view.name);
        let (name, size) = (
            file_stem(&[scene, view, "map"]),
            [map.size.width, map.size.height],
        );
        let file = write_photo(self.folder, &name, size, &map.rgb)?;
        Ok(self.map.get_or_init(|| file).clone())
    }

    /// How the frame differs from the reference; a fill in one colour is compared as a mask.
    ///
    /// - `hashes`: of its mask and of its ids, the latter empty for a fill in one colour
    /// - `is_moved`: boundaries are simplified on purpose, and how far they moved is measured
    /// - `against`: which reference
    pub(super) fn figures(
        &mut self,
        (mask_hash, ids_hash): (&str, &str),
        frame: &Frame,
        is_moved: bool,
        against: Against,
    ) -> Compared {
        let as_mask = ids_hash.is_empty();
        let hash = if as_mask {
            format!("mask {mask_hash}")
        } else {
            format!("ids {ids_hash}")
        };
        let key = (hash, frame.non_finite, is_moved, self.place(against));
        if let Some(known) = self.compared.get(&key) {
            return known.clone();
        }
        let compared = self.compare_pixels(frame, as_mask, is_moved, against);
        self.compared.insert(key, compared.clone());
        compared
    }

    pub(super) fn compare_pixels(
        &self,
        frame: &Frame,
        as_mask: bool,
        is_moved: bool,
        against: Against,
    ) -> Compared {
        let reference = self.of(against);
        let reference = reference.map_err(|error| error.to_string())?;
        let input = self.input_of(against.edges);
        let look = CloseLook::new(&input, &reference.rays);
        let (expected, frame) = reference.beside(frame, as_mask);
        compare_through(&look, expected, &frame, as_mask, is_moved)
    }
}

/// Errors of a frame, by a reference that is asked between its pixels as well.
///
/// - `as_mask`: both are fills in one colour
/// - `is_moved`: as of [`References::figures`]
pub(super) fn compare_through(
    look: &CloseLook<'_>,
    expected: &Frame,
    frame: &Frame,
    as_mask: bool,
    is_moved: bool,
) -> Compared {
    let as_compared = |id: u32| if as_mask { id.min(1) } else { id };
    let shows = |pixel: usize, id: u32| {
        let mut ids = look.ids_within(pixel, BAND_RADIUS_PX).into_iter();
        ids.any(|shown| as_compared(shown) == id)
    };
    let may_round_to = |pixel: usize, id: u32| {
        let mut ids = look.ids_by_rounding(pixel, BORDER_ROUNDING).into_iter();
        ids.any(|shown| as_compared(shown) == id)
    };
    let figures = compare_closely(expected, frame, may_round_to, shows).and_then(|figures| {
        let shown_at = |place| as_compared(look.id_at(place));
        let movement = if is_moved {
            boundary_movement(expected, frame, shown_at)?
        } else if figures.hausdorff_px.is_some_and(|px| px > MAX_HAUSDORFF_PX) {
            boundary_rounding(expected, frame, shown_at)?
        } else {
            return Ok(figures);
        };
        Ok(with_movement(figures, movement))
    });
    figures.map_err(|error| error.to_string())
}

/// `None` of no numbers.
fn largest_and_p99(values: &[f64]) -> Option<[f64; 2]> {
    Some([quantile(values, 1.0)?, quantile(values, 0.99)?])
}
