// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces filled with one colour before an empty background, as the paper shows cracks (figure 4): where no triangle is,
//! the background is seen. Each pixel is held to its ray in `f64`.

use crate::STUDY;
use crate::error::{of_frame, truths};
use crate::list::{SurfaceRow, number};
use crate::metrics::{self, *};
use crate::sight::{Chosen, drawn_otherwise};
use crate::wires::{Pen, Ready};
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_globe_views::{DRAW, Eye, FrameWatch, Opened, ViewRow, fingerprint, write_png};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_results::{Case, CaseId, Finding, PlannedCase, Verdict};
use terrafill_study::{CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, judged, verified};
use terrafill_surface::SurfaceFrame;

/// Name of this part in cases.
const PART: &str = "filled";
/// Where all of a surface is seen.
pub(crate) const VIEW_OF_ALL: &str = "globe";
/// By what the negative control moves the picture.
const MOVED_PX: usize = 3;
/// Share of the pixels that must then be found wrong.
const CONTROL_SHARE: f64 = 0.001;

pub(crate) const SECTION: Section<'static> = Section {
    title: "Cracks, filled surfaces before an empty background",
    text: "Where the spiral's step does not divide a turn, chords of neighbouring turns end at other places, and between \
           them nothing is drawn. The step is so coarse that the cracks are wide. Each pixel shows a triangle where its ray \
           in f64 meets one, and the background elsewhere, but for those beside an edge. A picture moved by a few pixels \
           must be found by that.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[("surface", SURFACE), ("knob", KNOB), ("value", VALUE)]),
    columns: &[
        Column::metric("triangles", GLOBE_TRIANGLES),
        Column::metric("px of cracks", GLOBE_CRACK_PX),
        Column::metric("px drawn otherwise", GLOBE_DRAWN_OTHERWISE_PX),
        Column::metric("px found when moved", GLOBE_FILLED_CONTROL_PX),
        DRAW,
    ],
    pictures: &[("picture", "")],
    findings: &[cracks],
    ..Section::EMPTY
};

fn cracks(cases: &Cases<'_>) -> Finding {
    let of = |is_mended: bool| -> Vec<f64> {
        let is_of = |case: &&Case| case.condition(SURFACE).contains("shared") == is_mended;
        let cases = cases.iter().filter(is_of);
        cases
            .filter_map(|case| case.value(GLOBE_CRACK_PX))
            .collect()
    };
    let (open, mended) = (of(false), of(true));
    let both = open.first().zip(mended.first());
    finding(
        "A step that does not divide a turn leaves cracks, and vertices that turns share close them",
        both.map(|(open, mended)| *open > 0.0 && *mended == 0.0),
        both.map_or_else(String::new, |(open, mended)| {
            format!("{open} pixels of cracks, {mended} where vertices are shared.")
        }),
    )
}

/// Every surface whose cracks are looked at, and what it is compared with.
pub(crate) struct FilledSurfaces {
    surfaces: Vec<Chosen>,
    view: ViewRow,
    side_px: u32,
    opened: Rc<Opened>,
}

impl FilledSurfaces {
    pub(crate) fn planned(
        view: &ViewRow,
        rows: &[SurfaceRow],
        (side_px, samples): (u32, u32),
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let rows = rows.iter().filter(|row| row.pictured.is_some());
        let surfaces: Vec<Chosen> = rows.filter_map(Chosen::pictured).collect();
        let cases = surfaces.iter().map(|Chosen { row, value }| {
            let value = number(value).unwrap_or(f64::NAN).to_string();
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    format!("{PART}/{}/{}={value}", row.name, row.knob),
                    [
                        (metrics::PART, PART.to_owned()),
                        (VIEW, view.name.clone()),
                        (SURFACE, row.name.clone()),
                        (KNOB, row.knob.clone()),
                        (VALUE, value),
                        (SIZE_PX, side_px.to_string()),
                    ],
                ),
                samples,
                // Rays through the middle of pixels do not tell a crack thinner than one from what a device rounds.
                may_be_wrong: row.cracks,
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                surfaces,
                view: view.clone(),
                side_px,
                opened: Rc::clone(opened),
            },
            open: |group, context| {
                Ok(Box::new(JudgedOnce::new(FilledPart {
                    group: &group.work,
                    cases: &group.cases,
                    context,
                    pen: None,
                    ready: BTreeMap::new(),
                })))
            },
        }
    }
}

struct FilledPart<'a> {
    group: &'a FilledSurfaces,
    cases: &'a [PlannedCase],
    context: Context<'a>,
    pen: Option<Rc<Pen>>,
    ready: BTreeMap<usize, Ready>,
}

/// A picture, and what it is of.
struct Drawn {
    frame: SurfaceFrame,
    is_filled: Vec<bool>,
}

impl FilledPart<'_> {
    fn eye(&self) -> Eye {
        self.group.view.eye(self.group.side_px)
    }

    fn pen(&mut self) -> Result<Rc<Pen>, Failure> {
        if let Some(pen) = &self.pen {
            return Ok(Rc::clone(pen));
        }
        let triangles = wgpu::PrimitiveTopology::TriangleList;
        let pen = Rc::new(Pen::new(self.context, &self.eye(), triangles)?);
        self.pen = Some(Rc::clone(&pen));
        Ok(pen)
    }
}

/// Pixels drawn otherwise than rays meet triangles, and those of the same picture moved to the left.
fn judge(width: usize, rays: &[bool], is_filled: &[bool]) -> [usize; 2] {
    let moved: Vec<bool> = (0..is_filled.len())
        .map(|pixel| pixel % width + MOVED_PX < width && is_filled[pixel + MOVED_PX])
        .collect();
    [is_filled, &moved].map(|picture| drawn_otherwise(width, rays, picture))
}

/// Pixels without a triangle from which no way without one leads out of the picture: beyond the rim there is a way.
fn enclosed(width: usize, is_filled: &[bool]) -> usize {
    let count = is_filled.len();
    let is_border = |at: usize| {
        let [x, y] = [at % width, at / width];
        x == 0 || x + 1 == width || y == 0 || (y + 1) * width == count
    };
    let mut is_known = is_filled.to_vec();
    let mut open: Vec<usize> = (0..count).filter(|at| is_border(*at)).collect();
    while let Some(at) = open.pop() {
        if std::mem::replace(&mut is_known[at], true) {
            continue;
        }
        let x = at % width;
        open.extend((x > 0).then(|| at - 1));
        open.extend((x + 1 < width).then_some(at + 1));
        open.extend(at.checked_sub(width));
        open.extend((at + width < count).then_some(at + width));
    }
    is_known.iter().filter(|is_known| !**is_known).count()
}

impl Shows for FilledPart<'_> {
    type Shown = Drawn;

    fn show(&mut self, case: usize) -> Result<(String, Drawn), Failure> {
        let eye = self.eye();
        let Chosen { row, .. } = &self.group.surfaces[case];
        let parameters = self.group.surfaces[case].parameters();
        let surface = self.group.opened.get(&row.kind, parameters)?;
        let frame = surface.frame(&eye.camera, eye.size)?;
        let pen = self.pen()?;
        let ready = pen.ready(eye, &frame.vertices_rte, frame.triangles.as_flattened());
        pen.draw(&ready)?;
        let bytes = pen.read()?;
        self.ready.insert(case, ready);
        let is_filled = bytes.iter().map(|byte| *byte != 0).collect();
        Ok((fingerprint(&[&bytes]), Drawn { frame, is_filled }))
    }

    fn judge(&mut self, case: usize, drawn: Drawn) -> Result<Verdict, Failure> {
        let eye = self.eye();
        let Drawn { frame, is_filled } = drawn;
        let errors = of_frame(&eye, &truths(&eye), &frame);
        let size = [eye.size.width, eye.size.height];
        let [otherwise, control] = judge(eye.size.width as usize, &errors.shown, &is_filled);
        let filled = is_filled.iter().filter(|is_filled| **is_filled).count();
        let reason = if filled == 0 {
            "it shows nothing".to_owned()
        } else if otherwise > 0 {
            format!(
                "{otherwise} pixels are drawn otherwise than rays meet the triangles, allowed 0"
            )
        } else if (control as f64) < CONTROL_SHARE * filled as f64 {
            "a picture that is moved is found in less than 0.1 % of its pixels: the comparison sees nothing".to_owned()
        } else {
            String::new()
        };
        let name = self.cases[case].id.key().replace(['/', '=', ' '], "-");
        let pixels = is_filled
            .iter()
            .map(|is_filled| [if *is_filled { 255 } else { 0 }; 3]);
        let path = write_png(self.context.folder, &name, size, pixels)?;
        let figures = vec![
            (GLOBE_TRIANGLES.name, frame.triangles.len() as f64),
            (
                GLOBE_CRACK_PX.name,
                enclosed(eye.size.width as usize, &is_filled) as f64,
            ),
            (GLOBE_DRAWN_OTHERWISE_PX.name, otherwise as f64),
            (GLOBE_FILLED_CONTROL_PX.name, control as f64),
        ];
        Ok(judged(reason, figures, vec![("picture", path)]))
    }

    /// Drawing alone: triangles stay on the device.
    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let pen = self.pen()?;
        let ready = verified(&mut self.ready, case)?;
        let watch = FrameWatch::start();
        let gpu_ms = pen.draw(ready)?;
        Ok(watch.drawn(gpu_ms))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::list::List;
    use terrafill_fixtures::on_device::{figure, on_device, verdict};
    use terrafill_results::Status;
    use terrafill_spiral::SpiralKind;
    use terrafill_study::Group as _;
    use terrafill_surface::SurfaceKind;

    const KINDS: &[&dyn SurfaceKind] = &[&SpiralKind];

    #[test]
    fn cracks_are_seen_where_vertices_are_not_shared() {
        let list = List::shipped().expect("a list");
        let opened = Rc::new(Opened::new(KINDS));
        let view = list.view(VIEW_OF_ALL).expect("a view");
        let group = FilledSurfaces::planned(view, &list.surface, (200, 1), &opened);
        assert_eq!(group.cases.len(), 2);
        on_device(terrafill_gpu::shared_gpu, |context| {
            let mut session = group.open(context).expect("opens");
            let mut cracks = Vec::new();
            for case in 0..2 {
                let name = &group.work.surfaces[case].row.name;
                let verdict = verdict(&mut *session, case, name);
                assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
                cracks.push(figure(&verdict, "globe_crack_px"));
                assert!(session.time(case).is_ok());
            }
            assert!(cracks[0] > 50.0 && cracks[1] == 0.0, "{cracks:?}");
        });
    }

    #[test]
    fn a_crack_that_is_closed_is_noticed() {
        let width = 16;
        // A crack of three columns in a filled picture.
        let rays: Vec<bool> = (0..width * width)
            .map(|px| !(6..9).contains(&(px % width)))
            .collect();
        assert_eq!(judge(width, &rays, &rays)[0], 0);
        assert!(judge(width, &rays, &rays)[1] > 0);
        // Negative controls: nothing is left open, and one pixel is.
        assert_eq!(judge(width, &rays, &vec![true; width * width])[0], width);
        let mut one = rays.clone();
        one[2 * width + 2] = false;
        assert_eq!(judge(width, &rays, &one)[0], 1);
        // The crack leads out of the picture, the pixel does not.
        assert_eq!(
            [&rays, &one].map(|picture| enclosed(width, picture)),
            [0, 1]
        );
    }
}
