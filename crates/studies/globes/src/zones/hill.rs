// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of zones that follow their counted pixels, as figures 11 and 12 of Gebbie and Bailey have them. One hill hides
//! the zones behind it. Another is dropped by a zone seen edge-on, until an eye that climbs counts enough of it.

mod picture;
mod section;

pub(crate) use section::SECTION;

use super::field::{COARSE_TRIANGLES, FINEST, Field, Hill, Levels, ZONES, node, number};
use super::rule::ZoneRule;
use super::{DELAY, run};
use crate::STUDY;
use crate::counts::course::{CountedFrame, Course};
use crate::counts::device::{ByHistogram, Counters, PixelCount, SIDE_PX};
use crate::counts::scene::{NodeVertices, numbers};
use crate::metrics::{self, *};
use crate::wires::{Pen, in_pixels, judge as judge_wires};
use picture::{Painted, above, colours, edges, is_rounding, judge, triangles};
use std::collections::BTreeMap;
use terrafill_globe_views::{Eye, ViewRow, fingerprint, write_png};
use terrafill_results::{CaseId, PlannedCase, Verdict};
use terrafill_scene::ImageSize;
use terrafill_study::{CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, judged, verified};

/// Name of this part in cases.
const PART: &str = "hill";
/// The paper has occlusion queries.
const WAY: PixelCount = PixelCount::Queries;
const HYSTERESIS_TIMES: f64 = 4.0;

/// Hides zones of three columns from an eye below its top.
const LARGE: Hill = Hill {
    at: [40.0, 14.0],
    sigma: 5.0,
    height_m: 500.0,
};
const LARGE_EYE_M: f64 = 250.0;
const LARGE_PITCH_DEG: f64 = -4.0;
const LARGE_WANTED: f64 = 3.0;

/// On a vertex that level 1 has and level 0 has not, and so narrow that 1 % of it is left at those that level 0 has.
const DROPPED: Hill = Hill {
    at: [44.0, 28.0],
    sigma: 1.8,
    height_m: 500.0,
};
/// The zone with that hill.
const EDGE_ON: usize = ZONES + 2;
/// Pixels a triangle: so many that the zone, flat and seen edge-on, stays at level 0 at first.
const EDGE_ON_WANTED: f64 = 40.0;
const EDGE_ON_PITCH_DEG: f64 = 0.0;
/// The eye climbs from here by so much at a time, and waits until zones are at rest.
const FIRST_EYE_M: f64 = 60.0;
const CLIMB_M: f64 = 10.0;
const CLIMBS: u32 = 40;

/// What a case shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Shown {
    /// From the eye whose pixels are counted, behind the large hill.
    Seen,
    /// The same zones from above, as edges.
    Above,
    /// The same without the hill.
    AbovePlain,
    /// The last rest at which the zone seen edge-on is coarse.
    Before,
    /// From the same place, where that zone was fine at first.
    BeforeFromFine,
    /// The next rest as the eye climbs.
    After,
}

impl Shown {
    const ALL: [Self; 6] = [
        Self::Seen,
        Self::Above,
        Self::AbovePlain,
        Self::Before,
        Self::BeforeFromFine,
        Self::After,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Seen => "seen",
            Self::Above => "wires",
            Self::AbovePlain => "wires without hill",
            Self::Before => "edge-on before",
            Self::BeforeFromFine => "edge-on from fine",
            Self::After => "edge-on after",
        }
    }

    fn field(self) -> Field {
        let hill = match self {
            Self::Seen | Self::Above => Some(LARGE),
            Self::AbovePlain => None,
            Self::Before | Self::BeforeFromFine | Self::After => Some(DROPPED),
        };
        Field { spike_m: 0.0, hill }
    }

    fn is_edge_on(self) -> bool {
        matches!(self, Self::Before | Self::BeforeFromFine | Self::After)
    }

    fn wanted(self) -> f64 {
        if self.is_edge_on() {
            EDGE_ON_WANTED
        } else {
            LARGE_WANTED
        }
    }

    fn rule(self) -> ZoneRule {
        ZoneRule::new(
            COARSE_TRIANGLES.into(),
            FINEST,
            self.wanted(),
            HYSTERESIS_TIMES,
        )
    }
}

/// All of them, as one group of cases.
pub(crate) struct HillPictures {
    /// Of pictures; pixels are counted in one of `SIDE_PX`.
    side_px: u32,
}

impl HillPictures {
    pub(crate) fn planned((side_px, samples): (u32, u32)) -> CaseGroup<Self> {
        let [api, counted_by] = WAY.names();
        let cases = Shown::ALL.map(|shown| PlannedCase {
            id: CaseId::new(
                STUDY,
                format!("{PART}/{}", shown.name()),
                [
                    (metrics::PART, PART.to_owned()),
                    (API, api.to_owned()),
                    (COUNTED_BY, counted_by.to_owned()),
                    (VIEW, shown.name().to_owned()),
                    (
                        HILL_M,
                        shown
                            .field()
                            .hill
                            .map_or(0.0, |hill| hill.height_m)
                            .to_string(),
                    ),
                    (WANTED, shown.wanted().to_string()),
                    (HYSTERESIS, HYSTERESIS_TIMES.to_string()),
                    (metrics::DELAY, DELAY.to_string()),
                    (SIZE_PX, side_px.to_string()),
                ],
            ),
            samples,
            may_be_wrong: false,
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: cases.to_vec(),
            warm_up: None,
            work: Self { side_px },
            open: |group, context| {
                Ok(Box::new(JudgedOnce::new(HillPart {
                    cases: &group.cases,
                    side_px: group.work.side_px,
                    context,
                    counters: Counters::new(context.devices),
                    rests: BTreeMap::new(),
                    last: BTreeMap::new(),
                })))
            },
        }
    }
}

fn eye(height_m: f64, pitch_deg: f64, side_px: u32) -> Eye {
    let [longitude_deg, latitude_deg] = Field::eye_deg();
    let row = ViewRow {
        longitude_deg,
        latitude_deg,
        height_m,
        pitch_deg,
        ..ViewRow::default()
    };
    row.eye(side_px)
}

/// Zones after the frames of an eye that stands still.
#[derive(Clone)]
struct Rest {
    height_m: f64,
    pitch_deg: f64,
    levels: Levels,
    course: Course,
}

impl Rest {
    fn eye(&self, side_px: u32) -> Eye {
        eye(self.height_m, self.pitch_deg, side_px)
    }

    /// Counted pixels of a zone.
    fn pixels(&self, zone: usize) -> u64 {
        let last = self.course.ends.last();
        let count = last.and_then(|frame| frame.counts.get(&node(zone)));
        count.copied().unwrap_or(0)
    }
}

struct HillPart<'a> {
    cases: &'a [PlannedCase],
    side_px: u32,
    context: Context<'a>,
    counters: Counters<'a>,
    /// Those that were found already.
    rests: BTreeMap<Shown, Rest>,
    /// The last counted frame of each case.
    last: BTreeMap<usize, CountedFrame>,
}

/// A picture by the device, and what it is of.
struct Drawn {
    rest: Rest,
    eye: Eye,
    drawn: NodeVertices,
    pixels: Pixels,
}

enum Pixels {
    /// Whether an edge lights it.
    Lines(Vec<bool>),
    /// The triangle that it shows, from 1.
    Triangles(Vec<u32>),
}

impl HillPart<'_> {
    /// - `levels`: those of the first frame
    fn rest(
        &mut self,
        shown: Shown,
        height_m: f64,
        pitch_deg: f64,
        mut levels: Levels,
    ) -> Result<Rest, Failure> {
        let eye = eye(height_m, pitch_deg, SIDE_PX);
        let (field, rule) = (shown.field(), shown.rule());
        let course = run(&mut self.counters, WAY, &eye, field, &rule, &mut levels)?;
        Ok(Rest {
            height_m,
            pitch_deg,
            levels,
            course,
        })
    }

    fn found(&mut self, shown: Shown) -> Result<Rest, Failure> {
        if let Some(known) = self.rests.get(&shown) {
            return Ok(known.clone());
        }
        if shown.is_edge_on() {
            self.climb()?;
        } else {
            let coarse = [0; ZONES * ZONES];
            let rest = self.rest(shown, LARGE_EYE_M, LARGE_PITCH_DEG, coarse)?;
            self.rests.insert(shown, rest);
        }
        let found = self.rests.get(&shown).cloned();
        found.ok_or_else(|| "no zone appears while the eye climbs".to_owned().into())
    }

    /// Climbs until the zone seen edge-on becomes finer.
    fn climb(&mut self) -> Result<(), Failure> {
        let mut before: Option<Rest> = None;
        for climb in 0..CLIMBS {
            let height_m = FIRST_EYE_M + f64::from(climb) * CLIMB_M;
            let levels = before
                .as_ref()
                .map_or([0; ZONES * ZONES], |rest| rest.levels);
            let after = self.rest(Shown::After, height_m, EDGE_ON_PITCH_DEG, levels)?;
            let Some(coarse) = before.replace(after.clone()) else {
                continue;
            };
            if after.levels[EDGE_ON] > coarse.levels[EDGE_ON] {
                let mut levels = coarse.levels;
                levels[EDGE_ON] = FINEST;
                let fine = Shown::BeforeFromFine;
                let fine_rest = self.rest(fine, coarse.height_m, EDGE_ON_PITCH_DEG, levels)?;
                self.rests.insert(fine, fine_rest);
                self.rests.insert(Shown::Before, coarse);
                self.rests.insert(Shown::After, after);
                break;
            }
        }
        Ok(())
    }

    /// Zones without a pixel that have some where there is no hill, and the finest one's level.
    fn hidden(&mut self, rest: &Rest) -> Result<(usize, u32), Failure> {
        let eye = rest.eye(SIDE_PX);
        let plain = Field::default().drawn(&eye, &rest.levels);
        let plain = self.counters.by_node(WAY, &eye, &plain)?;
        let hidden = plain
            .iter()
            .filter(|(_, pixels)| **pixels > 0)
            .map(|(node, _)| number(*node))
            .filter(|zone| rest.pixels(*zone) == 0);
        let hidden: Vec<u32> = hidden.map(|zone| rest.levels[zone]).collect();
        Ok((hidden.len(), hidden.into_iter().max().unwrap_or(0)))
    }

    fn draw(&mut self, shown: Shown) -> Result<Drawn, Failure> {
        let rest = self.found(shown)?;
        let field = shown.field();
        let (eye, drawn, pixels) = if matches!(shown, Shown::Above | Shown::AbovePlain) {
            let eye = above(self.side_px);
            let drawn = field.drawn(&eye, &rest.levels);
            let edges = edges(&eye, &drawn);
            let lines = wgpu::PrimitiveTopology::LineList;
            let pen = Pen::new(self.context, &eye, lines)?;
            pen.draw(&pen.ready(eye, &edges.corners, edges.lines.as_flattened()))?;
            let lit = pen.read()?.iter().map(|byte| *byte != 0).collect();
            (eye, drawn, Pixels::Lines(lit))
        } else {
            let eye = rest.eye(self.side_px);
            let drawn = field.drawn(&eye, &rest.levels);
            let size = ImageSize::new(self.side_px, self.side_px);
            let device = ByHistogram::new(self.context.devices, size)?;
            let numbers = device.picture(&eye, &triangles(&drawn))?;
            (eye, drawn, Pixels::Triangles(numbers))
        };
        Ok(Drawn {
            rest,
            eye,
            drawn,
            pixels,
        })
    }
}

impl Shows for HillPart<'_> {
    type Shown = Drawn;

    fn show(&mut self, case: usize) -> Result<(String, Drawn), Failure> {
        let drawn = self.draw(Shown::ALL[case])?;
        let counted = drawn.rest.course.hash();
        let hash = match &drawn.pixels {
            Pixels::Lines(lit) => {
                let bytes: Vec<u8> = lit.iter().map(|is_lit| u8::from(*is_lit)).collect();
                fingerprint(&[counted.as_bytes(), &bytes])
            }
            Pixels::Triangles(numbers) => {
                fingerprint(&[counted.as_bytes(), bytemuck::cast_slice(numbers)])
            }
        };
        let last = drawn.rest.course.ends.last().cloned();
        self.last.extend(last.map(|last| (case, last)));
        Ok((hash, drawn))
    }

    fn judge(&mut self, case: usize, shown: Drawn) -> Result<Verdict, Failure> {
        let Drawn {
            rest,
            eye,
            drawn,
            pixels,
        } = shown;
        let (mut figures, mut reason) = rest.course.exactness();
        figures.extend(rest.course.rest(DELAY));
        if Shown::ALL[case].is_edge_on() {
            figures.push((GLOBE_ZONE_PX.name, rest.pixels(EDGE_ON) as f64));
            figures.push((GLOBE_ZONE_LEVEL.name, f64::from(rest.levels[EDGE_ON])));
        } else {
            let (hidden, level) = self.hidden(&rest)?;
            figures.push((GLOBE_ZONE_HIDDEN.name, hidden as f64));
            figures.push((GLOBE_ZONE_HIDDEN_LEVEL.name, f64::from(level)));
        }
        let (of_picture, wrong, colours) = match pixels {
            Pixels::Lines(lit) => {
                let edges = edges(&eye, &drawn);
                let size = [eye.size.width, eye.size.height];
                let found = judge_wires(size, &in_pixels(&eye, &edges), &lit);
                let colours = lit.iter().map(|is_lit| [if *is_lit { 255 } else { 0 }; 3]);
                (found.figures(&edges), found.reason(), colours.collect())
            }
            Pixels::Triangles(device) => {
                let rays = numbers(&eye, &triangles(&drawn));
                let is_rounding =
                    |pixel, met, shown| is_rounding(&eye, &drawn, pixel, [met, shown]);
                let found = judge(eye.size.width as usize, &rays, &device, is_rounding);
                let painted = Painted {
                    eye: &eye,
                    drawn: &drawn,
                    levels: &rest.levels,
                    outlined: Shown::ALL[case].is_edge_on().then_some(EDGE_ON),
                };
                let sizes = rest.course.sizes.last().copied().unwrap_or(0.0);
                let mut figures = vec![(GLOBE_TRIANGLES.name, sizes)];
                figures.extend(found.figures());
                (figures, found.reason(), colours(&painted, &device))
            }
        };
        figures.extend(of_picture);
        if reason.is_empty() {
            reason = wrong;
        }
        let name = self.cases[case].id.key().replace(['/', '=', ' '], "-");
        let size = [eye.size.width, eye.size.height];
        let path = write_png(self.context.folder, &name, size, colours.into_iter())?;
        Ok(judged(reason, figures, vec![("picture", path)]))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let CountedFrame { eye, drawn, .. } = verified(&mut self.last, case)?;
        Ok(self.counters.time(WAY, eye, drawn)?)
    }
}

#[cfg(test)]
mod tests;
