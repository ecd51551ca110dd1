// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files of a view's pictures.

use super::drawn::ProbePicture;
use super::references::Reference;
use crate::cases::{FillCase, ViewGroup};
use crate::images::{cut_out, file_stem, zoomed};
use crate::probe::Probe;
use crate::textured::TexturedReferences;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::Path;
use terrafill_conformance::{difference_rgb, worst_pixel};
use terrafill_contract::{Frame, paint};
use terrafill_scene::ImageSize;
use terrafill_study::{StudyError, write_rgb};

/// A wrong pixel is drawn 3 × 3 in a picture of differences, so that it shows in one scaled down.
const MARKER_RADIUS_PX: usize = 1;

/// Longest side of a cut-out, pixels: at one pixel to a pixel texels and their errors can be seen.
const CUT_OUT_PX: u32 = 480;

/// Writes pictures of one view.
pub(super) struct PictureFiles<'a> {
    group: &'a ViewGroup,
    folder: &'a Path,
    /// Files by what they show: equal pictures share one.
    written: RefCell<BTreeMap<u64, String>>,
    /// What was noted of a frame's difference, by what it is the difference of.
    differences: RefCell<BTreeMap<Difference, Notes>>,
}

/// The hashes of a frame's mask and ids, and the picture of its reference.
type Difference = ((String, String), String);

/// Names of notes and what they say.
type Notes = Vec<(&'static str, String)>;

impl<'a> PictureFiles<'a> {
    pub(super) fn new(group: &'a ViewGroup, folder: &'a Path) -> Self {
        Self {
            group,
            folder,
            written: RefCell::default(),
            differences: RefCell::default(),
        }
    }

    fn stem(&self, case: &FillCase) -> String {
        file_stem(&[
            &self.group.scene.name,
            &self.group.view.name,
            case.subject.backend(),
            &case.variant_name(),
        ])
    }

    /// The technique's picture, its difference from the reference, and where that is worst.
    ///
    /// - `as_mask`: a fill in one colour, which is compared as a mask
    pub(super) fn write(
        &self,
        case: &FillCase,
        drawn: &mut ProbePicture,
        reference: &Reference,
        as_mask: bool,
        probe: &mut Probe,
    ) -> Result<(), StudyError> {
        let (stem, size) = (self.stem(case), self.group.size);
        if let Ok(picture) = drawn.backend.picture(&drawn.input) {
            probe.note("image", self.write_once(&stem, size, &picture.rgb())?);
        }
        let key = (drawn.hashes(), reference.image.clone());
        let known = self.differences.borrow().get(&key).cloned();
        let notes = match known {
            Some(notes) => notes,
            None => self.write_differences(&stem, &drawn.frame, reference, as_mask)?,
        };
        for (note, text) in &notes {
            probe.note(note, text.clone());
        }
        self.differences.borrow_mut().insert(key, notes);
        Ok(())
    }

    /// What is noted of a frame's difference from the reference, as a picture and where it is worst.
    fn write_differences(
        &self,
        stem: &str,
        frame: &Frame,
        reference: &Reference,
        as_mask: bool,
    ) -> Result<Notes, StudyError> {
        let (size, mut notes) = (self.group.size, Notes::new());
        let (expected, frame) = reference.beside(frame, as_mask);
        if let Ok(rgb) = difference_rgb(expected, &frame, MARKER_RADIUS_PX) {
            let name = format!("{stem}_difference");
            notes.push(("difference_image", self.write_once(&name, size, &rgb)?));
        }
        if let (Ok(Some(worst)), Ok(exact)) = (
            worst_pixel(expected, &frame),
            difference_rgb(expected, &frame, 0),
        ) {
            // On the reference's surface: only ids are compared.
            let shown = Frame {
                ids: frame.ids.clone(),
                ..expected.clone()
            };
            let parts: [&[u8]; 3] = [&paint(expected), &paint(&shown), &exact];
            let (size, rgb) = zoomed(size, worst, &parts);
            let name = format!("{stem}_worst");
            notes.push(("worst_image", self.write_once(&name, size, &rgb)?));
            notes.push(("worst_px", format!("{}, {}", worst[0], worst[1])));
        }
        Ok(notes)
    }

    /// The file of these pixels, written unless an equal picture of this view was.
    fn write_once(&self, name: &str, size: ImageSize, rgb: &[u8]) -> Result<String, StudyError> {
        let mut hasher = DefaultHasher::new();
        (size.width, rgb).hash(&mut hasher);
        let shown = hasher.finish();
        let known = self.written.borrow().get(&shown).cloned();
        if let Some(path) = known {
            return Ok(path);
        }
        let path = write_rgb(self.folder, name, [size.width, size.height], rgb)?;
        self.written.borrow_mut().insert(shown, path.clone());
        Ok(path)
    }

    /// Cut-outs of the reference's picture, the technique's, and their difference ten times.
    pub(super) fn write_textured(
        &self,
        case: &FillCase,
        drawn: &mut ProbePicture,
        references: &TexturedReferences,
        probe: &mut Probe,
    ) -> Result<(), StudyError> {
        let (stem, size) = (self.stem(case), self.group.size);
        let picture = match drawn.backend.picture(&drawn.input) {
            Ok(picture) => picture,
            Err(error) => {
                probe.remark(&error.to_string());
                return Ok(());
            }
        };
        match references.pictures(&drawn.input, &drawn.frame, &picture) {
            Ok(pictures) => {
                for (note, end, rgb) in [
                    ("image", "cut", &pictures.found),
                    ("difference_image", "cut_x10", &pictures.difference),
                    ("reference_image", "cut_reference", &pictures.reference),
                ] {
                    let name = format!("{stem}_{end}");
                    let cut = cut_out(size, pictures.centre, CUT_OUT_PX, rgb);
                    let size = [cut.size.width, cut.size.height];
                    probe.note(note, write_rgb(self.folder, &name, size, &cut.rgb)?);
                }
                probe.add_counts([("colour_max", pictures.largest)]);
                probe.add("colour_mean", pictures.mean);
            }
            Err(why) => probe.remark(&why),
        }
        Ok(())
    }
}
