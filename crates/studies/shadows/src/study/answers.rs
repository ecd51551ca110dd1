// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases that the CPU answers.

use super::Answering;
use super::meshes::{Ready, SILHOUETTE_SUN, ready};
use crate::counted::{Counted, Ranges};
use crate::eyes::EyeTable;
use crate::job::{Job, Method};
use crate::maps::Mapped;
use crate::metrics::MOSTLY;
use crate::views::{Chooser, Eyes};
use crate::work::{BOUNDS_SHARE, ChannelTotals, End, NEARS, Pixels, Scene, Scissor};
use std::path::Path;
use terrafill_casters::{Extent, Policy, Volume};
use terrafill_results::{Status, Verdict};
use terrafill_shadow_views::{EyeTest, Rule, Wrong, sun, write};
use terrafill_study::{Failure, Figures, judged};

fn verdict(is_right: bool, reason: String, figures: Figures) -> Verdict {
    let reason = if is_right { String::new() } else { reason };
    judged(reason, figures, Vec::new())
}

/// A share in per cent.
pub(super) fn percent(part: f64, whole: usize) -> f64 {
    100.0 * part / whole.max(1) as f64
}

/// What the views hold, and what of it is lost.
pub(super) fn seen_figures(pixels: Pixels, lost: usize) -> [(&'static str, f64); 3] {
    [
        ("shadow_receiver_px", pixels.receivers as f64),
        ("shadow_px", pixels.shadow as f64),
        ("shadow_lost_share", percent(lost as f64, pixels.shadow)),
    ]
}

/// On a scene, over all channels.
fn drawn_verdict(scene: &Scene, drawn: &ChannelTotals) -> Verdict {
    counted_verdict(scene, drawn, Counted::All)
}

/// The same of pixels that count.
fn counted_verdict(scene: &Scene, drawn: &ChannelTotals, counted: Counted) -> Verdict {
    let (wrong, lost, shadow) = scene.counting(drawn, counted);
    let pixels = Pixels {
        shadow,
        ..scene.pixels()
    };
    let mut figures = vec![
        ("shadow_edge_on_px", pixels.edge_on as f64),
        ("shadow_undecided_px", pixels.undecided as f64),
        ("shadow_updates", drawn.updates as f64 / pixels.all as f64),
        ("shadow_volume_triangles", drawn.volume_triangles as f64),
        ("shadow_max_overlap", f64::from(drawn.max_overlap)),
    ];
    figures.extend(seen_figures(pixels, lost));
    verdict_of(wrong, figures)
}

/// Right where no pixel outside the band is wrong.
pub(super) fn verdict_of(wrong: Wrong, mut figures: Figures) -> Verdict {
    let reason = format!(
        "{} pixels lit in shadow, {} in shadow in the light, outside the band",
        wrong.false_lit, wrong.false_dark
    );
    figures.extend([
        ("shadow_false_lit_px", wrong.false_lit as f64),
        ("shadow_false_dark_px", wrong.false_dark as f64),
        ("shadow_band_px", wrong.in_band as f64),
    ]);
    verdict(wrong.outside() == 0, reason, figures)
}

/// A note with the picture of the channel with the most shadow, by masks of all channels or the reference alone.
fn picture(
    scene: &Scene,
    folder: &Path,
    name: &str,
    masks: Option<&[Vec<bool>]>,
) -> Result<(&'static str, String), String> {
    let at = scene.darkest_channel()?;
    let mask = masks.map(|masks| masks[at].as_slice());
    let path = write(folder, name, &scene.truths()[at], mask)?;
    Ok(match mask {
        Some(_) => ("image", path),
        None => ("reference_image", path),
    })
}

/// Of a map, by what is wrong of it.
pub(super) fn map_figures(mapped: &Mapped, wrong: Wrong) -> Figures {
    vec![
        (
            "shadow_map_wrong",
            percent(wrong.all() as f64, mapped.judged),
        ),
        ("shadow_map_bias_m", mapped.bias_m),
        ("shadow_bytes", mapped.bytes as f64),
    ]
}

impl Answering<'_> {
    pub(super) fn answer(&mut self, job: Job) -> Result<Verdict, Failure> {
        let (folder, size) = (self.context.folder, self.question.size);
        match job {
            Job::Eye(sun, near, test) => Ok(self.eye(sun, near, test)?),
            Job::Updates(sun, end, rule) => {
                let scene = self.of_end(sun, end)?;
                let drawn = scene.drawn(end, rule, Scissor::Off)?;
                let mut verdict = drawn_verdict(scene, &drawn);
                if end == End::Sea && rule == Rule::Fail {
                    let name = format!("sun-{}-{}", sun[0], sun[1]);
                    verdict.notes.push(picture(scene, folder, &name, None)?);
                }
                Ok(verdict)
            }
            Job::Scissor(sun, scissor, counted) => {
                let scene = self.of_end(sun, End::Infinite)?;
                let drawn = scene.drawn(End::Infinite, Rule::Fail, scissor)?;
                let mut verdict = counted_verdict(scene, &drawn, counted);
                if counted == Counted::All {
                    let image = picture(scene, folder, scissor.name(), Some(&drawn.masks))?;
                    verdict.notes.push(image);
                }
                Ok(verdict)
            }
            Job::Bounds(sun, rule, ranges, counted) => {
                let scene = self.of_end(sun, End::Sea)?;
                let drawn = match ranges {
                    Ranges::OfParts => scene.drawn_within(rule, BOUNDS_SHARE)?,
                    Ranges::One => scene.drawn_in_one_range(rule)?,
                };
                Ok(counted_verdict(scene, &drawn, counted))
            }
            Job::View(sun, place, chooser) => {
                let scene = self.seen_from(Eyes::At(place), sun, End::Sea.feet_m(), size)?;
                let drawn = scene.drawn_chosen(chooser)?;
                let mut verdict = drawn_verdict(scene, &drawn);
                if chooser == Chooser::ALL[0] {
                    let image = picture(scene, folder, place.name(), None)?;
                    verdict.notes.push(image);
                }
                Ok(verdict)
            }
            Job::Finite(sun, length) => {
                let scene = self.of_end(sun, End::Finite(length))?;
                let drawn = scene.drawn(End::Finite(length), Rule::Fail, Scissor::Off)?;
                Ok(drawn_verdict(scene, &drawn))
            }
            Job::Row(count, guard) => {
                let scene = self.scene(&count.to_string(), || Scene::of_row(count, size))?;
                let drawn = if guard {
                    scene.drawn_guarded(Rule::Pass)?
                } else {
                    scene.drawn(End::Infinite, Rule::Pass, Scissor::Off)?
                };
                Ok(drawn_verdict(scene, &drawn))
            }
            Job::Casters(policy) => {
                let scene = self.scene("hull", || Scene::of_hull(size))?;
                match scene.drawn_open(policy) {
                    Ok((drawn, triangles)) => {
                        let mut verdict = drawn_verdict(scene, &drawn);
                        let triangles = ("shadow_mesh_triangles", triangles as f64);
                        verdict.figures.push(triangles);
                        Ok(verdict)
                    }
                    // As it should be: the mesh is not closed.
                    Err(error) if policy == Policy::Refuse => Ok(Verdict {
                        status: Status::Ok,
                        reason: error.to_string(),
                        ..Verdict::default()
                    }),
                    Err(error) => Err(error.to_string().into()),
                }
            }
            Job::Silhouette(mesh, method) => Ok(self.silhouette(mesh, method)?),
            Job::Model => {
                let own = self.question.brought.as_deref();
                let own = own.ok_or_else(|| "no model".to_owned())?;
                let mesh = &own.prepared.mesh;
                let found = format!("policy {}: {}", own.policy.name(), own.verdict);
                let warnings = own.warnings.iter().map(|text| format!("; warning: {text}"));
                Ok(Verdict {
                    status: Status::Ok,
                    reason: found + &warnings.collect::<String>(),
                    figures: vec![
                        ("shadow_mesh_triangles", mesh.triangles.len() as f64),
                        ("shadow_mesh_models", mesh.casters.len() as f64),
                        ("shadow_mesh_parts", mesh.parts.len() as f64),
                    ],
                    ..Verdict::default()
                })
            }
            Job::Map(sun, texel_m, bias) => {
                let scene = self.of_end(sun, End::Sea)?;
                let mapped = scene.mapped(texel_m, bias)?;
                let mut figures = map_figures(&mapped, mapped.wrong);
                let unbiased = percent(mapped.unbiased as f64, mapped.judged);
                figures.push(("shadow_map_wrong_in_three", 100.0 * mapped.wrong_in_three));
                figures.push(("shadow_map_wrong_unbiased", unbiased));
                let mut verdict = verdict_of(mapped.wrong, figures);
                let name = format!("map-{}-{texel_m}-{}", sun[0], bias.name());
                let image = picture(scene, folder, &name, Some(&mapped.masks))?;
                verdict.notes.push(image);
                Ok(verdict)
            }
            _ => Err("devices answer by case".to_owned().into()),
        }
    }

    fn eye(&mut self, sun: [f64; 2], near: f64, test: EyeTest) -> Result<Verdict, String> {
        if self.eyes.as_ref().is_none_or(|table| table.at != sun) {
            self.eyes = Some(EyeTable::new(sun)?);
        }
        let table = self.eyes.as_ref().ok_or("no eyes")?;
        let result = table.result(test, near).ok_or("no such near plane")?;
        let share = |part: f64| percent(part, result.eyes);
        let mut figures = vec![
            ("shadow_eyes_missed", share(result.missed as f64)),
            (
                "shadow_eyes_missed_at_corners",
                share(result.missed_at_corners as f64),
            ),
            (MOSTLY.name, share(result.missed_mostly as f64)),
            ("shadow_eyes_needless", share(result.needless as f64)),
            ("shadow_fail_triangles", share(result.fail_share)),
        ];
        if result.missed > 0 {
            let dark = percent(result.missed_share, result.missed);
            figures.push(("shadow_near_dark", dark));
        }
        let reason = format!("{} of {} eyes missed", result.missed, result.eyes);
        let mut verdict = verdict(result.missed == 0, reason, figures);
        let is_last_near = NEARS.last().is_some_and(|last| *last <= near);
        if test == EyeTest::Eye
            && is_last_near
            && let Some((truth, [missed, exact])) = table.missed()?
        {
            let folder = self.context.folder;
            for (key, what, mask) in [
                ("reference_image", "reference", None),
                ("image", "eye", Some(&missed)),
                ("exact_image", "exact", Some(&exact)),
            ] {
                let name = format!("eye-{}-{what}", sun[0]);
                let path = write(folder, &name, &truth, mask.map(Vec::as_slice))?;
                verdict.notes.push((key, path));
            }
        }
        Ok(verdict)
    }

    pub(super) fn ready(&mut self, name: &'static str) -> Result<&Ready, String> {
        let known = self.meshes.iter().position(|own| own.name == name);
        let place = known.unwrap_or(self.meshes.len());
        if known.is_none() {
            let brought = self.question.brought.as_deref();
            self.meshes.push(ready(name, brought)?);
        }
        Ok(&self.meshes[place])
    }

    fn silhouette(&mut self, name: &'static str, method: Method) -> Result<Verdict, String> {
        let mesh = self.ready(name)?;
        let sides = mesh.sides(method);
        let to_light = sun(SILHOUETTE_SUN);
        let (prepared, facing) = (&mesh.prepared, &mesh.facing);
        let volume = Volume::of(prepared, facing, &sides, to_light, &Extent::Infinite);
        let volume = volume.map_err(|error| error.to_string())?;
        let open = volume.open_edges().len();
        let triangles = prepared.mesh.triangles.len();
        let figures = vec![
            ("shadow_sides", sides.len() as f64),
            ("shadow_mesh_triangles", triangles as f64),
            ("shadow_open_edges", open as f64),
        ];
        let reason = format!("{open} edges of the volumes are open");
        Ok(verdict(open == 0, reason, figures))
    }
}
