// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on shadows: a section a question, what was published beside what is measured.

use terrafill_plot::number::{count, significant};
use terrafill_plot::{
    Curve, Palette, Point, PointStanding, Reading, Upwards, WorkPrecision, named_aside,
};
use terrafill_results::{
    Answers, Block, Case, Cell, Chapter, ChapterError, Clock, Finding, Heading, Outcome, Picture,
    PictureFigure, Pictures, Plot, Row, Run, Standing, Table, process_medians, sample_spread,
};

const TIME: &str = "shadow_silhouette_cpu_ms";
const UPDATES: &str = "shadow_updates";
const MISSED: &str = "shadow_eyes_missed";
const LOST: &str = "shadow_lost_share";
const MAP_WRONG: &str = "shadow_map_wrong";

const WHAT: &str = "A procedural port: a trestle dock, cranes, ships, containers. The reference sends rays in f64 \
     from each visible point to the sun, and a second test looks from the sun down. A volume's mask is what a \
     stencil would hold: its triangles, counted along the ray of each pixel. Devices draw the same volumes in a \
     section of their own. \
     Wrong pixels are counted outside the band of one pixel along the shadow's boundary. Pixels on faces within \
     10⁻³ of edge-on to the sun are not judged. Shadows are hard: the sun's disc of 0.53° and refraction are left \
     out.";

/// What each optimisation of shadow volumes saves and gets wrong.
#[derive(Debug, Clone, Copy, Default)]
pub struct ShadowsChapter;

/// A column: its heading and its metric.
type Column = (&'static str, &'static str);

/// A question's section.
struct Section {
    question: &'static str,
    title: &'static str,
    text: &'static str,
    /// Conditions that name a row.
    named_by: &'static [&'static str],
    columns: &'static [Column],
}

const SECTIONS: [Section; 10] = [
    Section {
        question: "eyes",
        title: "Which rule: the test of the eye",
        text: "400 eyes on deck, 1.7 m over it. Published: z-fail where the segment from the eye to the light \
               meets a caster. z-pass is right where the near rectangle is outside the volumes, so an eye in the \
               light whose near rectangle is partly in shadow is missed.",
        named_by: &["sun", "near_m", "eye_test"],
        columns: &[
            ("missed, %", MISSED),
            ("needless, %", "shadow_eyes_needless"),
            ("triangles by z-fail, %", "shadow_fail_triangles"),
            (
                "near rectangle in shadow where missed, %",
                "shadow_near_dark",
            ),
        ],
    },
    Section {
        question: "updates",
        title: "Volumes, rules and suns",
        text: "Seven channels over 270° from a bridge 30 m up. Volumes end at infinity or in a plane below the \
               curved sea. Stencil writes per pixel are a cost without noise.",
        named_by: &["sun", "extent", "rule"],
        columns: &[
            ("writes per pixel", UPDATES),
            ("triangles", "shadow_volume_triangles"),
            ("largest count", "shadow_max_overlap"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("edge-on px", "shadow_edge_on_px"),
            ("undecided px", "shadow_undecided_px"),
            ("shadow px", "shadow_px"),
        ],
    },
    Section {
        question: "scissors",
        title: "Scissors",
        text: "Three readings of \"what lies above the sea\": rows above the horizon; a rectangle round each \
               caster's volume, closed at the sea; and the same, cut by the rectangle round everything above \
               the sea. The last leaves shadows on the sea out. z-fail, infinite volumes.",
        named_by: &["sun", "scissor"],
        columns: &[
            ("shadow pixels lost, %", LOST),
            ("writes per pixel", UPDATES),
            ("false dark px", "shadow_false_dark_px"),
        ],
    },
    Section {
        question: "finite",
        title: "Finite volumes",
        text: "Volumes that end after so many metres, with a dark cap, by z-fail, beside those of the section above.",
        named_by: &["sun", "length_m"],
        columns: &[
            ("shadow pixels lost, %", LOST),
            ("writes per pixel", UPDATES),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
        ],
    },
    Section {
        question: "rows",
        title: "Eight bits",
        text: "Plates in a row, all of which lie before the same water. A count that is a multiple of 256 wraps to \
               0. The guard draws passes of at most 255 casters.",
        named_by: &["casters", "counting"],
        columns: &[
            ("largest count", "shadow_max_overlap"),
            ("shadow px", "shadow_px"),
            ("shadow pixels lost, %", LOST),
            ("false lit px", "shadow_false_lit_px"),
            ("writes per pixel", UPDATES),
        ],
    },
    Section {
        question: "casters",
        title: "Casters that are not closed",
        text: "A hull of 1,022 triangles with a tenth of its deck missing, under each policy, against the shadow of \
               the whole hull: what passes the hole meets the bottom. z-fail, volumes closed at the sea.",
        named_by: &["policy"],
        columns: &[
            ("triangles", "shadow_mesh_triangles"),
            ("shadow px", "shadow_px"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("largest count", "shadow_max_overlap"),
            ("writes per pixel", UPDATES),
        ],
    },
    Section {
        question: "outlines",
        title: "Outlines by a stencil value",
        text: "Not a shadow technique: a value S for each model instead of a clear (McGuire & Hughes, 2004). The \
               test is printed as \"stencil == S\"; inner contours are suppressed by ≠.",
        named_by: &["models", "outline"],
        columns: &[
            ("clears", "shadow_clears"),
            ("contour pixels wrong", "shadow_contour_px"),
        ],
    },
    Section {
        question: "silhouettes",
        title: "Silhouettes on the CPU",
        text: "The published stack of borders, the same toggle by a hash, and stored adjacency with a directed \
               count. All read the same facing bits. With a face turned, two lit triangles have an edge the same \
               way round: the toggles delete it, and the volume is open.",
        named_by: &["mesh", "silhouette"],
        columns: &[
            ("CPU ms", TIME),
            ("triangles", "shadow_mesh_triangles"),
            ("sides", "shadow_sides"),
            ("open edges", "shadow_open_edges"),
        ],
    },
    Section {
        question: "devices",
        title: "Drawn by devices",
        text: "The same volumes drawn into a stencil by the executors that fill regions: vertices from the CPU, sea and \
               casters as a surface, one colour over the screen where the count is not 0. Times are those of the \
               channel that has most shadow, all else is over seven channels. Rows of one sun differ in one thing \
               from one to the next.",
        named_by: &["sun", "api", "extent", "rule", "faces", "scissor"],
        columns: &[
            ("CPU ms", "shadow_fill_cpu_ms"),
            ("GPU ms", "shadow_fill_gpu_ms"),
            ("fragments per pixel", "shadow_fragments"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("draws", "shadow_draws"),
            ("casters left out", "shadow_casters_left_out"),
            ("bytes", "shadow_bytes"),
        ],
    },
    Section {
        question: "maps",
        title: "Shadow maps",
        text: "One orthographic map along the light, fitted to the casters, drawn and asked on the CPU: the nearest \
               texel, no filter. The bias is the best of 13 constants from 0 to 40 m, or of 7 multiples of texel and \
               slope from 0 to 2. Wrong pixels are of all that the reference judges, the band included.",
        named_by: &["sun", "texel_m", "bias"],
        columns: &[
            ("wrong, %", MAP_WRONG),
            ("wrong without bias, %", "shadow_map_wrong_unbiased"),
            ("best bias, m", "shadow_map_bias_m"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("CPU ms", "shadow_map_cpu_ms"),
            ("bytes", "shadow_bytes"),
        ],
    },
];

impl Section {
    /// A case as its row has it.
    fn name(&self, case: &Case) -> String {
        let names: Vec<&str> = self
            .named_by
            .iter()
            .map(|key| case.condition(key))
            .collect();
        names.join(", ")
    }
}

impl Chapter for ShadowsChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Shadows: what each optimisation of shadow volumes saves, and its error"
    }

    fn primary_metric(&self, _clock: Clock) -> Option<&'static str> {
        Some(TIME)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let own = Own::of(run);
        Ok(Answers {
            blocks: own.findings().into_iter().map(Block::Finding).collect(),
            ..Answers::default()
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let own = Own::of(run);
        if own.cases.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = vec![Block::Text(WHAT.to_owned())];
        blocks.extend(own.findings().into_iter().map(Block::Finding));
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
    cases: Vec<&'a Case>,
}

/// What was computed; a wrong answer is one.
fn value(case: &Case, metric: &str) -> Option<f64> {
    let is_known = matches!(case.outcome, Outcome::Ok | Outcome::Wrong);
    case.value(metric).filter(|_| is_known)
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
            cases: all.filter(|case| !case.is_twin()).collect(),
        }
    }

    fn of_question(&self, question: &str) -> impl Iterator<Item = &'a Case> {
        let all = self.cases.iter().copied();
        all.filter(move |case| case.condition("question") == question)
    }

    fn has(&self, question: &str) -> bool {
        self.of_question(question).next().is_some()
    }

    /// Values of a metric where all conditions hold.
    fn values(&self, question: &str, conditions: &[(&str, &str)], metric: &str) -> Vec<f64> {
        let all = self.of_question(question);
        let own = all.filter(|case| {
            conditions
                .iter()
                .all(|(key, value)| case.condition(key) == *value)
        });
        own.filter_map(|case| value(case, metric)).collect()
    }

    fn value(&self, question: &str, conditions: &[(&str, &str)], metric: &str) -> Option<f64> {
        self.values(question, conditions, metric).first().copied()
    }

    /// Suns of a question, in order.
    fn suns(&self, question: &str) -> Vec<&'a str> {
        let mut suns = Vec::new();
        for case in self.of_question(question) {
            if !suns.contains(&case.condition("sun")) {
                suns.push(case.condition("sun"));
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
            let figures = section
                .columns
                .iter()
                .map(|(_, metric)| Cell::or_absent(value(case, metric).map(number), why));
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
            .map(|key| key.replace('_', " "))
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
                && case.condition("rule") == "z-fail"
                && suns.contains(&case.condition("sun"))
        });
        for case in self.of_question(question).chain(others) {
            let number = |key: &str| case.condition(key).parse::<f64>().ok();
            let elevation = || case.condition("sun").split('°').next()?.parse::<f64>().ok();
            let of = |metric: &str| value(case, metric);
            let (name, knob, x, y, label) = match question {
                "eyes" => {
                    let name = format!(
                        "{}, sun {}",
                        case.condition("eye_test"),
                        case.condition("sun")
                    );
                    (
                        name,
                        number("near_m"),
                        number("near_m"),
                        of(MISSED),
                        String::new(),
                    )
                }
                "updates" => {
                    let name = format!("{}, {}", case.condition("rule"), case.condition("extent"));
                    (name, elevation(), elevation(), of(UPDATES), String::new())
                }
                "finite" => {
                    let length = case.condition("length_m");
                    let name = match case.condition("extent") {
                        "" => "finite",
                        extent => extent,
                    };
                    let knob = number("length_m").or(Some(f64::INFINITY));
                    (
                        name.to_owned(),
                        knob,
                        of(UPDATES),
                        of(LOST),
                        length.to_owned(),
                    )
                }
                "maps" => {
                    let name = format!("sun {}, {}", case.condition("sun"), case.condition("bias"));
                    let texel = case.condition("texel_m").to_owned();
                    (
                        name,
                        number("texel_m"),
                        of("shadow_bytes"),
                        of(MAP_WRONG),
                        texel,
                    )
                }
                _ => {
                    let kind = case.condition("mesh").split('-').next().unwrap_or_default();
                    let name = format!("{}, {kind}", case.condition("silhouette"));
                    let triangles = of("shadow_mesh_triangles");
                    let is_whole = !case.condition("mesh").contains("turned");
                    (
                        name,
                        triangles,
                        triangles.filter(|_| is_whole),
                        of(TIME),
                        String::new(),
                    )
                }
            };
            let is_printed = case.condition("rule").contains("printed");
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

    fn findings(&self) -> Vec<Finding> {
        let findings = [
            self.masks(),
            self.eye_test(),
            self.pass_is_faster(),
            self.closed_at_the_sea(),
            self.horizon(),
            self.clears(),
            self.wrap(),
            self.devices(),
            self.maps(),
        ];
        findings.into_iter().flatten().collect()
    }

    /// Every rule and extent against the reference.
    fn masks(&self) -> Option<Finding> {
        let own: Vec<&Case> = self
            .of_question("updates")
            .filter(|case| !case.condition("rule").contains("printed"))
            .collect();
        let wrong = |case: &&Case| {
            let px =
                ["shadow_false_lit_px", "shadow_false_dark_px"].map(|metric| value(case, metric));
            px.into_iter().try_fold(0.0, |sum, px| Some(sum + px?))
        };
        let all: Option<Vec<f64>> = own.iter().map(wrong).collect();
        let total: f64 = all?.iter().sum();
        (!own.is_empty()).then(|| Finding {
            claim: "Every rule and extent has the reference's mask outside the band.".to_owned(),
            standing: Standing::holds_if(total == 0.0),
            because: format!("{} pixels wrong in {} cases", significant(total), own.len()),
        })
    }

    /// Every way of drawing, by each interface.
    fn devices(&self) -> Option<Finding> {
        let own: Vec<&Case> = self.of_question("devices").collect();
        let known: Vec<&Case> = own
            .iter()
            .copied()
            .filter(|case| value(case, "shadow_false_lit_px").is_some())
            .collect();
        let right = known.iter().filter(|case| case.outcome == Outcome::Ok);
        let right = right.count();
        let keys = ["sun", "extent", "rule", "faces", "scissor"];
        let is_same = |a: &Case, b: &Case| {
            let mut keys = keys.iter();
            keys.all(|key| a.condition(key) == b.condition(key))
        };
        let (mut pairs, mut equal) = (0, 0);
        for (at, case) in known.iter().enumerate() {
            for other in &known[at + 1..] {
                if is_same(case, other) {
                    pairs += 1;
                    equal += u32::from(case.note("mask_hash") == other.note("mask_hash"));
                }
            }
        }
        (!known.is_empty()).then(|| Finding {
            claim: "Devices draw the reference's shadows outside the band, and each interface the same mask."
                .to_owned(),
            standing: Standing::holds_if(right == known.len() && equal == pairs),
            because: format!(
                "{right} of {} cases right, {equal} of {pairs} pairs of masks equal",
                known.len()
            ),
        })
    }

    /// Under each sun and bias, by texels.
    fn maps(&self) -> Option<Finding> {
        let of_sun = |sun: &&str| {
            let mut texels: Vec<(f64, f64)> = self
                .of_question("maps")
                .filter(|case| {
                    case.condition("sun") == *sun && case.condition("bias") == "constant"
                })
                .filter_map(|case| {
                    Some((
                        case.condition("texel_m").parse().ok()?,
                        value(case, MAP_WRONG)?,
                    ))
                })
                .collect();
            texels.sort_by(|a, b| a.0.total_cmp(&b.0));
            texels
        };
        let suns = self.suns("maps");
        let all: Vec<(&str, Vec<(f64, f64)>)> =
            suns.iter().map(|sun| (*sun, of_sun(sun))).collect();
        let is_known = all.iter().any(|(_, texels)| texels.len() > 1);
        let falls = |texels: &Vec<(f64, f64)>| texels.is_sorted_by(|a, b| a.1 <= b.1);
        let text = all.iter().map(|(sun, texels)| {
            let texels = texels
                .iter()
                .map(|(texel, wrong)| format!("{} % at {texel} m", significant(*wrong)));
            format!("sun {sun}: {}", texels.collect::<Vec<_>>().join(", "))
        });
        is_known.then(|| Finding {
            claim: "Smaller texels leave fewer wrong pixels of a shadow map, and none of them leaves none."
                .to_owned(),
            standing: Standing::holds_if(all.iter().all(|(_, texels)| {
                falls(texels) && texels.iter().all(|(_, wrong)| *wrong > 0.0)
            })),
            because: format!("Best constant bias, {}", text.collect::<Vec<_>>().join("; ")),
        })
    }

    fn eye_test(&self) -> Option<Finding> {
        let published = self.values("eyes", &[("eye_test", "eye")], MISSED);
        let exact = self.values("eyes", &[("eye_test", "near-exact")], MISSED);
        let most = published.iter().copied().reduce(f64::max)?;
        let least = published.iter().copied().reduce(f64::min)?;
        let missed = exact.iter().copied().reduce(f64::max)?;
        Some(Finding {
            claim: "The segment from the eye to the light says where z-pass is right (Yang & Jin, 2006, anticipated)."
                .to_owned(),
            standing: Standing::holds_if(most == 0.0),
            because: format!(
                "It misses {} to {} % of the eyes on deck; the near rectangle tested exactly misses {} %",
                significant(least),
                significant(most),
                significant(missed)
            ),
        })
    }

    /// Writes of a rule and extent under a sun.
    fn writes(&self, sun: &str, extent: &str, rule: &str) -> Option<f64> {
        self.value(
            "updates",
            &[("sun", sun), ("extent", extent), ("rule", rule)],
            UPDATES,
        )
    }

    fn pass_is_faster(&self) -> Option<Finding> {
        let suns = self.suns("updates");
        let ratios = |extent: &str| -> Option<[f64; 2]> {
            let of = |sun: &&str| {
                Some(self.writes(sun, extent, "z-fail")? / self.writes(sun, extent, "z-pass")?)
            };
            let all: Option<Vec<f64>> = suns.iter().map(of).collect();
            let all = all?;
            Some([
                all.iter().copied().reduce(f64::min)?,
                all.iter().copied().reduce(f64::max)?,
            ])
        };
        let (infinite, closed) = (ratios("infinite")?, ratios("sea-closed")?);
        let range = |of: [f64; 2]| format!("{} to {}", significant(of[0]), significant(of[1]));
        Some(Finding {
            claim: "z-pass writes less than z-fail (Yang & Jin, 2006, anticipated).".to_owned(),
            standing: Standing::holds_if(infinite[0] > 1.0 && closed[0] > 1.0),
            because: format!(
                "z-fail over z-pass: {} for infinite volumes, {} for those closed at the sea",
                range(infinite),
                range(closed)
            ),
        })
    }

    fn closed_at_the_sea(&self) -> Option<Finding> {
        let suns = self.suns("updates");
        let ratio = |sun: &&str| {
            let ratio = self.writes(sun, "infinite", "z-fail")?
                / self.writes(sun, "sea-closed", "z-fail")?;
            Some(format!("{} at {sun}", significant(ratio)))
        };
        let ratios: Option<Vec<String>> = suns.iter().map(ratio).collect();
        let always = suns.iter().all(|sun| {
            let closed = self.writes(sun, "sea-closed", "z-fail");
            self.writes(sun, "infinite", "z-fail")
                .zip(closed)
                .is_some_and(|(open, closed)| closed < open)
        });
        Some(Finding {
            claim: "Closing volumes at the sea saves stencil writes of z-fail.".to_owned(),
            standing: Standing::holds_if(always),
            because: format!(
                "Writes of infinite volumes over closed ones: {}",
                ratios?.join(", ")
            ),
        })
    }

    fn horizon(&self) -> Option<Finding> {
        let lost = |scissor: &str| self.value("scissors", &[("scissor", scissor)], LOST);
        let (horizon, caster) = (lost("horizon")?, lost("caster-rect")?);
        Some(Finding {
            claim: "There is no shadow below the horizon, so a scissor there loses none (Yang & Jin, 2006, considered)."
                .to_owned(),
            standing: Standing::holds_if(horizon == 0.0),
            because: format!(
                "It loses {} % of the shadow pixels; rectangles of casters lose {} %",
                significant(horizon),
                significant(caster)
            ),
        })
    }

    fn clears(&self) -> Option<Finding> {
        let all = self
            .of_question("outlines")
            .filter(|case| case.condition("outline") == "value");
        let pairs: Option<Vec<(f64, f64)>> = all
            .map(|case| {
                Some((
                    case.condition("models").parse().ok()?,
                    value(case, "shadow_clears")?,
                ))
            })
            .collect();
        let pairs = pairs.filter(|pairs| !pairs.is_empty())?;
        let text = pairs
            .iter()
            .map(|(models, clears)| format!("{models}: {clears}"));
        Some(Finding {
            claim: "A stencil value for each model takes 1 + ⌊N/255⌋ clears.".to_owned(),
            standing: Standing::holds_if(
                pairs
                    .iter()
                    .all(|(models, clears)| *clears == 1.0 + (models / 255.0).floor()),
            ),
            because: format!("Clears by models: {}", text.collect::<Vec<_>>().join(", ")),
        })
    }

    fn wrap(&self) -> Option<Finding> {
        let lost = |casters: &str, counting: &str| {
            self.value(
                "rows",
                &[("casters", casters), ("counting", counting)],
                LOST,
            )
        };
        let wrapping = "8 bits, wrapping";
        let counts = ["255", "256", "257", "511", "512"];
        let wraps: Option<Vec<f64>> = counts.iter().map(|count| lost(count, wrapping)).collect();
        let guarded: Option<Vec<f64>> = counts
            .iter()
            .map(|count| lost(count, "passes of 255"))
            .collect();
        let (wraps, guarded) = (wraps?, guarded?);
        let text = counts
            .iter()
            .zip(&wraps)
            .map(|(count, lost)| format!("{count}: {} %", significant(*lost)));
        Some(Finding {
            claim: "Eight bits that wrap lose shadows of exactly 256 and 512 casters, and passes of 255 lose none."
                .to_owned(),
            standing: Standing::holds_if(
                wraps.iter().zip(counts).all(|(lost, count)| (*lost > 0.0) == matches!(count, "256" | "512"))
                    && guarded.iter().all(|lost| *lost == 0.0),
            ),
            because: format!("Shadow pixels lost by casters: {}", text.collect::<Vec<_>>().join(", ")),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    fn finding(run: &MadeUpRun, claim: &str) -> Option<Standing> {
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        let found = Own::of(&run)
            .findings()
            .into_iter()
            .find(|finding| finding.claim.contains(claim));
        found.map(|finding| finding.standing)
    }

    fn with(
        question: &str,
        conditions: &[(&str, &str)],
        metric: &'static str,
        value: f64,
        run: &mut MadeUpRun,
    ) {
        let mut all = vec![("question", question)];
        all.extend(conditions);
        let name: Vec<&str> = all.iter().map(|(_, value)| *value).collect();
        run.case(case_id(crate::STUDY, &name.join("/"), &all))
            .figure(metric, value);
    }

    fn updates(values: [f64; 4]) -> MadeUpRun {
        let mut run = MadeUpRun::default();
        let ways = [
            ("infinite", "z-pass"),
            ("infinite", "z-fail"),
            ("sea-closed", "z-pass"),
            ("sea-closed", "z-fail"),
        ];
        for ((extent, rule), value) in ways.into_iter().zip(values) {
            let conditions = [("sun", "5° from 0°"), ("extent", extent), ("rule", rule)];
            with("updates", &conditions, UPDATES, value, &mut run);
        }
        run
    }

    #[test]
    fn claims_stand_and_fall_by_their_figures() {
        let cheap = updates([12.0, 41.0, 12.0, 7.5]);
        assert_eq!(
            finding(&cheap, "z-pass writes less"),
            Some(Standing::DoesNotHold)
        );
        assert_eq!(finding(&cheap, "Closing volumes"), Some(Standing::Holds));
        // Twin: the other way round.
        let dear = updates([12.0, 41.0, 12.0, 43.0]);
        assert_eq!(finding(&dear, "z-pass writes less"), Some(Standing::Holds));
        assert_eq!(
            finding(&dear, "Closing volumes"),
            Some(Standing::DoesNotHold)
        );
        assert_eq!(finding(&cheap, "clears"), None, "not measured");
    }

    #[test]
    fn a_row_that_wraps_where_it_must_not_is_no_agreement() {
        let rows = |lost_of_257: f64| {
            let mut run = MadeUpRun::default();
            for (count, lost) in [
                ("255", 0.0),
                ("256", 100.0),
                ("257", lost_of_257),
                ("511", 0.0),
                ("512", 100.0),
            ] {
                with(
                    "rows",
                    &[("casters", count), ("counting", "8 bits, wrapping")],
                    LOST,
                    lost,
                    &mut run,
                );
                with(
                    "rows",
                    &[("casters", count), ("counting", "passes of 255")],
                    LOST,
                    0.0,
                    &mut run,
                );
            }
            finding(&run, "Eight bits")
        };
        assert_eq!(rows(0.0), Some(Standing::Holds));
        assert_eq!(rows(3.0), Some(Standing::DoesNotHold));
    }

    #[test]
    fn a_question_that_was_measured_has_a_table_and_others_have_none() {
        let run = updates([12.0, 41.0, 12.0, 7.5]);
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        let blocks = ShadowsChapter.blocks(&run).expect("a chapter");
        let tables = blocks
            .iter()
            .filter(|block| matches!(block, Block::Table(_)));
        assert_eq!(tables.count(), 1);
        let plots = blocks
            .iter()
            .filter(|block| matches!(block, Block::Plot(_)));
        assert_eq!(plots.count(), 1);
        let mut other = MadeUpRun::default();
        other.case(case_id("filling", "a", &[]));
        let other = other.write(&folder.path().join("other")).expect("a run");
        assert_eq!(ShadowsChapter.blocks(&other).expect("a chapter"), []);
    }
}
