// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on shadows: a section a question, what was published beside what is measured.

mod drawn;
mod elsewhere;
mod findings;
mod sections;
mod steps;

use crate::keys::{
    API, BIAS, DEPTH_BOUNDS, EXTENT, EYE_TEST, FACES, FILL_CPU, LENGTH_M, LOST, MAP_WRONG, MESH,
    MISSED, NEAR_M, QUESTION, RULE, SCISSOR, SHADOW_BAND_PX, SHADOW_BYTES, SHADOW_FALSE_DARK_PX,
    SHADOW_FALSE_LIT_PX, SHADOW_FRAGMENTS, SHADOW_MESH_TRIANGLES, SHADOW_RECEIVER_PX, SILHOUETTE,
    SUN, TEXEL_M, TIME, UPDATES,
};
use sections::{SECTIONS, Section};
use terrafill_plot::number::{count, significant};
use terrafill_plot::{
    Curve, Palette, Point, PointStanding, Reading, Upwards, WorkPrecision, dotted, named_aside,
};
use terrafill_results::{
    Answers, Block, Case, Cell, Chapter, ChapterError, Clock, ConditionKey, Heading, Metric, Noise,
    Outcome, Picture, PictureFigure, Pictures, Plot, Row, Run, Table, process_medians,
    sample_spread,
};

const PORT: &str = "A procedural port: a trestle dock, cranes, ships, containers, in seven channels \
     over 270° from a bridge 30 m up.";
const BROUGHT: &str = "A model from a file over the sea, its middle at the origin, seen from four sides, above its top.";
const WHAT: &str = "The reference sends rays in f64 \
     from each visible point to the sun, and a second test looks from the sun down. A volume's mask is what a \
     stencil would hold: its triangles, counted along the ray of each pixel. Devices draw the same volumes in a \
     section of their own. \
     Wrong pixels are counted outside the band of one pixel along the shadow's boundary. Pixels on faces within \
     10⁻³ of edge-on to the sun are not judged. Shadows are hard: the sun's disc of 0.53° and refraction are left \
     out.";

/// What each optimisation of shadow volumes saves and gets wrong.
#[derive(Debug, Clone, Copy, Default)]
pub struct ShadowsChapter;

impl Chapter for ShadowsChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Shadows: what each optimisation of shadow volumes saves, and its error"
    }

    fn primary_metric(&self, _clock: Clock) -> Option<&'static str> {
        Some(TIME.name)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let own = Own::of(run);
        Ok(Answers {
            blocks: own
                .findings(run.clock())
                .into_iter()
                .map(Block::Finding)
                .collect(),
            ..Answers::default()
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let own = Own::of(run);
        if own.cases.is_empty() {
            return Ok(Vec::new());
        }
        let casters = if own.has("model") { BROUGHT } else { PORT };
        let mut blocks = vec![Block::Text(format!("{casters} {WHAT}"))];
        blocks.extend(own.findings(run.clock()).into_iter().map(Block::Finding));
        for section in SECTIONS.iter().filter(|section| own.has(section.question)) {
            blocks.push(Block::section(section.title));
            blocks.push(Block::Text(section.text.to_owned()));
            blocks.extend(own.drawing(section)?);
            blocks.push(Block::Table(own.table(section)));
            blocks.extend(own.pictures(section));
        }
        blocks.push(Block::Remark(
            "Published: \"about 35 fps\" for part of a trestle dock on a GeForce 6800, all optimisations on (Yang & \
             Jin, 2006); no resolution, triangle count, sun or baseline."
                .to_owned(),
        ));
        Ok(blocks)
    }
}

/// The study's cases of a run.
struct Own<'a> {
    run: &'a Run,
    cases: Vec<&'a Case>,
}

/// What was computed; a wrong answer is one.
fn value(case: &Case, metric: &Metric) -> Option<f64> {
    let is_known = matches!(case.outcome, Outcome::Ok | Outcome::Wrong);
    case.value(metric).filter(|_| is_known)
}

/// Wrong pixels of volumes, the band included, in per cent of what is seen.
fn own_share(case: &Case) -> Option<f64> {
    let px = [SHADOW_FALSE_LIT_PX, SHADOW_FALSE_DARK_PX, SHADOW_BAND_PX];
    let px: Option<f64> = px.iter().map(|metric| value(case, metric)).sum();
    Some(100.0 * px? / value(case, SHADOW_RECEIVER_PX)?)
}

/// Counts as they are, everything else in three digits.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "whole, positive and below 2⁵³"
)]
fn number(value: f64) -> String {
    match value.fract() == 0.0 && (0.0..1e15).contains(&value) {
        true => count(value as u64),
        false => significant(value),
    }
}

impl<'a> Own<'a> {
    fn of(run: &'a Run) -> Self {
        let all = run.of_study(crate::STUDY);
        Self {
            run,
            cases: all.filter(|case| !case.is_twin()).collect(),
        }
    }

    /// By how much identical work differed in a time.
    fn noise(&self, metric: &Metric) -> Option<Noise> {
        let all: Vec<&Case> = self.run.of_study(crate::STUDY).collect();
        Noise::of(all.iter().copied(), metric)
    }

    fn of_question(&self, question: &str) -> impl Iterator<Item = &'a Case> {
        let all = self.cases.iter().copied();
        all.filter(move |case| case.condition(QUESTION) == question)
    }

    fn has(&self, question: &str) -> bool {
        self.of_question(question).next().is_some()
    }

    /// Values of a metric where all conditions hold.
    fn values(
        &self,
        question: &str,
        conditions: &[(ConditionKey, &str)],
        metric: &Metric,
    ) -> Vec<f64> {
        let all = self.of_question(question);
        let own = all.filter(|case| {
            conditions
                .iter()
                .all(|(key, value)| case.condition(*key) == *value)
        });
        own.filter_map(|case| value(case, metric)).collect()
    }

    fn value(
        &self,
        question: &str,
        conditions: &[(ConditionKey, &str)],
        metric: &Metric,
    ) -> Option<f64> {
        self.values(question, conditions, metric).first().copied()
    }

    /// Suns of a question, in order.
    fn suns(&self, question: &str) -> Vec<&'a str> {
        let mut suns = Vec::new();
        for case in self.of_question(question) {
            if !suns.contains(&case.condition(SUN)) {
                suns.push(case.condition(SUN));
            }
        }
        suns
    }

    fn table(&self, section: &Section) -> Table {
        let row = |case: &Case| {
            let why = match (case.outcome, case.reason.as_str()) {
                (Outcome::Ok | Outcome::Wrong, _) => "there is none",
                (_, reason) => reason,
            };
            let figures = section.columns.iter().map(|(_, metric)| {
                let why = match (*metric, why) {
                    (SHADOW_FRAGMENTS, "there is none") => "not counted by the device",
                    _ => why,
                };
                let figure = Cell::or_absent(value(case, metric).map(number), why);
                dotted(figure, case, metric)
            });
            // What is wrong stands in the row's figures.
            let is_said = case.outcome == Outcome::Wrong && section.question != "scissors";
            Row {
                cells: std::iter::once(Cell::name(section.name(case)))
                    .chain(figures)
                    .collect(),
                status: case.outcome.name().to_owned(),
                remark: if is_said {
                    String::new()
                } else {
                    case.reason.clone()
                },
            }
        };
        let figures = section
            .columns
            .iter()
            .map(|(text, metric)| Heading::metric(*text, *metric));
        let names: Vec<String> = section
            .named_by
            .iter()
            .map(|key| key.name().replace('_', " "))
            .collect();
        Table {
            caption: section.title.to_owned(),
            headings: std::iter::once(Heading::plain(names.join(", ")))
                .chain(figures)
                .collect(),
            rows: self.of_question(section.question).map(row).collect(),
            is_main: true,
            ..Table::default()
        }
    }

    fn pictures(&self, section: &Section) -> Option<Block> {
        let figure = |case: &Case| {
            let keys = [
                ("reference_image", "reference"),
                ("image", "as drawn, wrong pixels red"),
                ("exact_image", "near rectangle tested"),
            ];
            let picture = |&(key, caption): &(&str, &str)| {
                let path = case.note(key);
                (!path.is_empty()).then(|| Picture {
                    path: path.to_owned(),
                    caption: caption.to_owned(),
                })
            };
            let pictures: Vec<Picture> = keys.iter().filter_map(picture).collect();
            (!pictures.is_empty()).then(|| PictureFigure {
                pictures,
                notes: vec![section.name(case)],
            })
        };
        let figures: Vec<PictureFigure> = self
            .of_question(section.question)
            .filter_map(figure)
            .collect();
        (!figures.is_empty()).then(|| {
            Block::Pictures(Pictures {
                caption: format!(
                    "{}: sea blue, casters sand, shadow dark; purple is not judged.",
                    section.title
                ),
                figures,
                ..Pictures::default()
            })
        })
    }

    fn drawing(&self, section: &Section) -> Result<Option<Block>, ChapterError> {
        let (across, up, upwards, caption) = match section.question {
            "eyes" => (
                "near plane, m",
                "eyes missed, %",
                Upwards::Error,
                "Eyes missed against the near plane; tests of the near rectangle miss none.",
            ),
            "updates" => (
                "sun's elevation, degrees",
                "stencil writes per pixel",
                Upwards::Amount,
                "Writes per pixel against the sun's elevation; suns differ in azimuth, see the table.",
            ),
            "finite" => (
                "stencil writes per pixel",
                "shadow pixels lost, %",
                Upwards::Error,
                "Error against cost: volumes of finite length, m beside the points, and those that end at infinity or at \
                 the sea.",
            ),
            "silhouettes" => (
                "triangles of the casters",
                "process CPU ms: median, 5–95 %",
                Upwards::Amount,
                "Time of a silhouette against triangles. Ports are boxes; hulls are smooth and have fewer sides.",
            ),
            "maps" => (
                "bytes of the map",
                "wrong pixels, %",
                Upwards::Error,
                "Wrong pixels against bytes, texel in m beside the points; volumes have none outside the band.",
            ),
            "device-maps" => (
                "process CPU ms of a frame, median",
                "wrong pixels, %",
                Upwards::Error,
                "Wrong pixels, the band included, against time; texel in m beside the points. Volumes closed at the sea \
                 under the same suns stand beside.",
            ),
            _ => return Ok(None),
        };
        let curves = self.curves(section.question);
        let plot = WorkPrecision {
            title: section.title,
            across,
            up,
            upwards,
            curves,
            lines: Vec::new(),
        };
        let names: Vec<String> = plot.curves.iter().map(|curve| curve.name.clone()).collect();
        let svg = named_aside(section.title, &plot, &names, &Palette::new(names.clone()))?;
        Ok(svg.map(|svg| {
            Block::Plot(Plot {
                caption: caption.to_owned(),
                svg,
            })
        }))
    }

    fn curves(&self, question: &str) -> Vec<Curve> {
        let mut curves: Vec<Curve> = Vec::new();
        // Beside finite volumes under a sun: those that end elsewhere.
        let suns = self.suns(question);
        let others = self.of_question("updates").filter(|case| {
            question == "finite"
                && case.condition(RULE) == "z-fail"
                && suns.contains(&case.condition(SUN))
        });
        let volumes = self.of_question("devices").filter(|case| {
            question == "device-maps"
                && case.condition(API) == "wgpu"
                && is_plain(case)
                && suns.contains(&case.condition(SUN))
        });
        let others = others.chain(volumes);
        for case in self.of_question(question).chain(others) {
            let number = |key: ConditionKey| case.condition(key).parse::<f64>().ok();
            let elevation = || case.condition(SUN).split('°').next()?.parse::<f64>().ok();
            let of = |metric: &Metric| value(case, metric);
            let (name, knob, x, y, label) = match question {
                "eyes" => {
                    let name = format!("{}, sun {}", case.condition(EYE_TEST), case.condition(SUN));
                    (
                        name,
                        number(NEAR_M),
                        number(NEAR_M),
                        of(MISSED),
                        String::new(),
                    )
                }
                "updates" => {
                    let name = format!("{}, {}", case.condition(RULE), case.condition(EXTENT));
                    (name, elevation(), elevation(), of(UPDATES), String::new())
                }
                "finite" => {
                    let length = case.condition(LENGTH_M);
                    let name = match case.condition(EXTENT) {
                        "" => "finite",
                        extent => extent,
                    };
                    let knob = number(LENGTH_M).or(Some(f64::INFINITY));
                    (
                        name.to_owned(),
                        knob,
                        of(UPDATES),
                        of(LOST),
                        length.to_owned(),
                    )
                }
                "maps" => {
                    let name = format!("sun {}, {}", case.condition(SUN), case.condition(BIAS));
                    let texel = case.condition(TEXEL_M).to_owned();
                    (
                        name,
                        number(TEXEL_M),
                        of(SHADOW_BYTES),
                        of(MAP_WRONG),
                        texel,
                    )
                }
                "device-maps" => {
                    let (sun, texel) = (case.condition(SUN), case.condition(TEXEL_M));
                    let wrong = match texel {
                        "" => own_share(case),
                        _ => of(MAP_WRONG),
                    };
                    let name = match texel {
                        "" => format!("volumes, sun {sun}"),
                        _ => format!("map, sun {sun}, {}", case.condition(BIAS)),
                    };
                    let knob = number(TEXEL_M).or(Some(0.0));
                    (name, knob, of(FILL_CPU), wrong, texel.to_owned())
                }
                _ => {
                    let kind = match case.condition(MESH).split('-').next() {
                        None | Some("") => "the model",
                        Some(kind) => kind,
                    };
                    let name = format!("{}, {kind}", case.condition(SILHOUETTE));
                    let triangles = of(SHADOW_MESH_TRIANGLES);
                    let is_whole = !case.condition(MESH).contains("turned");
                    (
                        name,
                        triangles,
                        triangles.filter(|_| is_whole),
                        of(TIME),
                        String::new(),
                    )
                }
            };
            let is_printed = case.condition(RULE).contains("printed");
            let (Some(knob), Some(x), Some(y), false) = (knob, x, y, is_printed) else {
                continue;
            };
            let reading = match sample_spread(case, TIME) {
                Some(spread) => {
                    let replicates: Vec<f64> = process_medians(case, TIME).into_values().collect();
                    Reading::sampled(spread, &replicates)
                }
                None => Reading::exact(y),
            };
            let point = Point {
                knob,
                label,
                x: Some(Reading::exact(x)),
                y: Some(reading),
                y_rms: None,
                standing: PointStanding::Right,
                command: String::new(),
            };
            match curves.iter_mut().find(|curve| curve.name == name) {
                Some(curve) => curve.points.push(point),
                None => curves.push(Curve {
                    name,
                    points: vec![point],
                }),
            }
        }
        for curve in &mut curves {
            curve.points.sort_by(|a, b| a.knob.total_cmp(&b.knob));
        }
        curves
    }
}

/// Volumes closed at the sea as the rows of a device begin with them.
fn is_plain(case: &Case) -> bool {
    let plain = [
        (EXTENT, "sea-closed"),
        (RULE, "z-fail"),
        (FACES, "two-sided"),
        (SCISSOR, "off"),
        (DEPTH_BOUNDS, "off"),
        (SILHOUETTE, "adjacency"),
    ];
    plain
        .iter()
        .all(|(key, value)| case.condition(*key) == *value)
}

#[cfg(test)]
mod tests;
