// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases that need no device: geometry images, variance shadows, hard shadows and motion blur in numbers.

use crate::STUDY;
use crate::blur::{self, Filter, Resolve, blur_error, resolve_error};
use crate::geometry_image::{CellCut, Texels, image_error};
use crate::keys;
use crate::keys::{CUT, DEPTH, EXPERIMENT, FILTER, FLOOR, MOMENTS, RESOLVE, SIGMA, STORED};
use crate::variance::{
    DepthFormat, Moments, NO_FLOOR, bleeding, hard_shadow, lit_plane, noise, worst_bleeding,
};
use std::collections::BTreeMap;
use terrafill_results::{CaseId, ConditionKey, PlannedCase, Status, Verdict};
use terrafill_study::{Context, Group, Session, StudyError};

/// Texels a side; a quick run leaves out the last two.
const TEXELS: [u32; 6] = [33, 65, 129, 257, 513, 1_025];
const QUICK_TEXELS: usize = 4;
/// Spread of depths, of the range.
const SIGMAS: [f64; 4] = [1e-2, 1e-3, 3e-4, 1e-4];
/// Under the variance; the first is none.
const FLOORS: [f32; 2] = [NO_FLOOR, 1e-7];
/// Texels a side of a hard shadow's map.
const MAPS: [u32; 5] = [256, 512, 1_024, 2_048, 4_096];
/// Distance between two occluders over that from the lower one to the receiver.
const GAPS: [f64; 5] = [0.5, 1.0, 2.0, 5.0, 10.0];
/// Layers of a blurred picture.
const LAYERS: [u32; 8] = [4, 8, 16, 32, 64, 128, 256, 512];
const RESOLVED_LAYERS: [u32; 4] = [4, 8, 16, 32];

/// What a case computes.
#[derive(Debug, Clone, Copy)]
enum Number {
    Image(u32, CellCut, Texels),
    Noise(Moments, f64),
    LitPlane(Moments, DepthFormat, f32),
    Bleeding(f64),
    HardShadow(u32),
    Blur(Filter, blur::Moments, u32),
    Resolve(Resolve, u32),
}

impl Number {
    /// The experiment, and the case's conditions in the order of its name.
    fn conditions(self) -> (&'static str, Vec<(ConditionKey, String)>) {
        match self {
            Self::Image(texels, cut, stored) => (
                "geometry-image",
                vec![
                    (CUT, cut.name().to_owned()),
                    (STORED, stored.name()),
                    (keys::TEXELS, texels.to_string()),
                ],
            ),
            Self::Noise(moments, sigma) => (
                "variance-noise",
                vec![
                    (MOMENTS, moments.name().to_owned()),
                    (SIGMA, format!("{sigma:e}")),
                ],
            ),
            Self::LitPlane(moments, format, floor) => {
                let floor = match floor.is_finite() {
                    true => format!("{floor:e}"),
                    false => "none".to_owned(),
                };
                (
                    "lit-plane",
                    vec![
                        (MOMENTS, moments.name().to_owned()),
                        (DEPTH, format.name()),
                        (FLOOR, floor),
                    ],
                )
            }
            Self::Bleeding(gaps) => ("bleeding", vec![(keys::GAPS, gaps.to_string())]),
            Self::HardShadow(texels) => ("hard-shadow", vec![(keys::TEXELS, texels.to_string())]),
            Self::Blur(filter, moments, layers) => (
                "motion-blur",
                vec![
                    (FILTER, filter.name().to_owned()),
                    (MOMENTS, moments.name().to_owned()),
                    (keys::LAYERS, layers.to_string()),
                ],
            ),
            Self::Resolve(resolve, layers) => (
                "blur-resolve",
                vec![
                    (RESOLVE, resolve.name().to_owned()),
                    (keys::LAYERS, layers.to_string()),
                ],
            ),
        }
    }

    fn figures(self) -> Vec<(&'static str, f64)> {
        let figures = match self {
            Self::Image(texels, cut, stored) => {
                let error = image_error(texels, cut, stored);
                vec![
                    ("image_max_m", error.max_m),
                    ("image_rms_m", error.rms_m),
                    ("image_max_px", error.max_px()),
                    ("image_normal_deg", error.normal_rms_deg),
                    ("image_open_texels", error.open_texels as f64),
                ]
            }
            Self::Noise(moments, sigma) => {
                let noise = noise(moments, sigma);
                vec![
                    ("variance_relative_rms", noise.relative_rms),
                    ("variance_absolute_rms", noise.absolute_rms),
                    ("variance_absolute_max", noise.absolute_max),
                    ("variance_non_finite", f64::from(noise.non_finite)),
                ]
            }
            Self::LitPlane(moments, format, floor) => {
                let plane = lit_plane(moments, format, floor);
                vec![
                    ("variance_dark_share", plane.dark),
                    ("variance_black_share", plane.black),
                    ("variance_outside_share", plane.outside),
                    ("variance_non_finite", f64::from(plane.non_finite)),
                ]
            }
            Self::Bleeding(gaps) => vec![("variance_bleeding", bleeding(gaps))],
            Self::HardShadow(texels) => {
                let shadow = hard_shadow(texels, 0.0);
                vec![
                    ("hard_wrong_area", shadow.wrong_area),
                    ("hard_area_share", shadow.area_share),
                    ("hard_deviation_texels", shadow.deviation_texels),
                ]
            }
            Self::Blur(filter, moments, layers) => {
                let error = blur_error(filter, moments, layers);
                vec![
                    ("blur_rms", error.rms),
                    ("blur_max", error.max),
                    ("blur_layers", f64::from(layers)),
                ]
            }
            Self::Resolve(resolve, layers) => {
                let error = resolve_error(resolve, layers);
                vec![
                    ("blur_rms", error.rms),
                    ("blur_max", error.max),
                    ("blur_layers", f64::from(layers)),
                ]
            }
        };
        let finite = figures.into_iter().filter(|(_, value)| value.is_finite());
        finite.collect()
    }

    /// Why its figures cannot be, where they contradict what is proved.
    fn contradiction(self, figures: &[(&'static str, f64)]) -> Option<String> {
        let Self::Bleeding(gaps) = self else {
            return None;
        };
        let most = worst_bleeding(gaps);
        let found = figures.first().map(|figure| figure.1)?;
        (found > most).then(|| format!("{found} of the light bleeds, at most {most} can"))
    }
}

fn images(is_quick: bool) -> Vec<Number> {
    let texels = &TEXELS[..if is_quick { QUICK_TEXELS } else { TEXELS.len() }];
    let cuts = CellCut::ALL.into_iter();
    let exact = cuts.flat_map(|cut| {
        texels
            .iter()
            .map(move |&texels| Number::Image(texels, cut, Texels::Exact))
    });
    let rounded = Texels::ROUNDED.into_iter().flat_map(|stored| {
        let few = texels.iter().skip(1).step_by(2);
        few.map(move |&texels| Number::Image(texels, CellCut::Fold, stored))
    });
    exact.chain(rounded).collect()
}

fn shadows() -> Vec<Number> {
    let moments = Moments::ALL.into_iter();
    let noise = moments.flat_map(|way| SIGMAS.map(|sigma| Number::Noise(way, sigma)));
    let planes = [Moments::Published, Moments::FromReceiver].into_iter();
    let planes = planes.flat_map(|way| {
        let formats = DepthFormat::ALL.into_iter();
        formats.flat_map(move |format| FLOORS.map(|floor| Number::LitPlane(way, format, floor)))
    });
    let bleeding = GAPS.map(Number::Bleeding);
    let maps = MAPS.map(Number::HardShadow);
    noise.chain(planes).chain(bleeding).chain(maps).collect()
}

fn blurs() -> Vec<Number> {
    let filters = Filter::ALL.into_iter();
    let layers = filters.flat_map(|filter| {
        let moments = blur::Moments::ALL.into_iter();
        moments.flat_map(move |moments| LAYERS.map(|layers| Number::Blur(filter, moments, layers)))
    });
    let resolves = Resolve::ALL.into_iter();
    let resolves =
        resolves.flat_map(|resolve| RESOLVED_LAYERS.map(|layers| Number::Resolve(resolve, layers)));
    layers.chain(resolves).collect()
}

/// Cases of one part.
pub(crate) struct Numbers {
    part: &'static str,
    cases: Vec<PlannedCase>,
    numbers: Vec<Number>,
}

impl Numbers {
    /// Every part.
    pub(crate) fn all(is_quick: bool) -> [Self; 3] {
        [
            Self::new("geometry-image", images(is_quick)),
            Self::new("shadows", shadows()),
            Self::new("motion-blur", blurs()),
        ]
    }

    fn new(part: &'static str, numbers: Vec<Number>) -> Self {
        let case = |number: &Number| {
            let (experiment, conditions) = number.conditions();
            let values = conditions.iter().map(|(_, value)| value.as_str());
            let name: Vec<&str> = [experiment].into_iter().chain(values).collect();
            let name = name.join("/");
            let experiment = (EXPERIMENT, experiment.to_owned());
            let all = [experiment].into_iter().chain(conditions.iter().cloned());
            PlannedCase {
                id: CaseId::new(STUDY, name, all),
                // Exact: nothing is timed.
                samples: 0,
                may_be_wrong: false,
            }
        };
        Self {
            part,
            cases: numbers.iter().map(case).collect(),
            numbers,
        }
    }
}

impl Group for Numbers {
    fn name(&self) -> String {
        format!("{STUDY}/{}", self.part)
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn warm_up(&self) -> Option<u32> {
        Some(0)
    }

    fn open<'a>(&'a self, _context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(NumberSession(&self.numbers)))
    }
}

struct NumberSession<'a>(&'a [Number]);

impl Session for NumberSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        let number = self.0[case];
        let figures = number.figures();
        let reason = number.contradiction(&figures).unwrap_or_default();
        Ok(Verdict {
            status: match reason.is_empty() {
                true => Status::Ok,
                false => Status::Wrong,
            },
            reason,
            figures,
            ..Verdict::default()
        })
    }

    fn recheck(
        &mut self,
        _case: usize,
        status: Status,
        _notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, StudyError> {
        // The figures are exact: another process has the same.
        Ok(Verdict {
            status,
            ..Verdict::default()
        })
    }

    fn sample(&mut self, _case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        Err("nothing of it is timed".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::METRICS;
    use std::collections::BTreeSet;

    #[test]
    fn every_case_has_a_name_of_its_own_and_declared_figures() {
        let mut names = BTreeSet::new();
        for group in Numbers::all(true) {
            for (case, number) in group.cases.iter().zip(&group.numbers) {
                assert!(names.insert(case.id.name.clone()), "{}", case.id.name);
                // Large images take their time, and their figures are those of small ones.
                let is_large = matches!(number, Number::Image(texels, ..) if *texels > 65)
                    || matches!(number, Number::HardShadow(texels) if *texels > 512);
                if is_large {
                    continue;
                }
                let figures = number.figures();
                assert!(!figures.is_empty(), "{}", case.id.name);
                for (figure, _) in figures {
                    let is_known = METRICS.iter().any(|metric| metric.name == figure);
                    assert!(is_known, "{figure} of {}", case.id.name);
                }
            }
        }
        assert!(names.len() > 100, "{}", names.len());
    }

    #[test]
    fn more_light_than_can_bleed_is_a_contradiction() {
        let number = Number::Bleeding(2.0);
        assert_eq!(number.contradiction(&number.figures()), None);
        let found = number.contradiction(&[("variance_bleeding", 0.26)]);
        assert!(found.is_some_and(|why| why.contains("0.26")));
    }
}
