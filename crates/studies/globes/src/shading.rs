// SPDX-License-Identifier: MIT OR Apache-2.0
//! Five layers over the spiral (Gebbie and Bailey, Tables 1 and 3), of real pictures of the Earth where there is data.
//! Sides from which they are seen, storages of bumps, features taken away one after the other, faults of the printed
//! shader, and projections. Cube maps stand against pictures by angles, triangles against pixels.

mod device;
mod judge;
mod layers;
mod mesh;
mod section;
mod sources;
#[cfg(test)]
mod synthetic;
mod tessellation;
mod texels;
mod textures;
mod way;
mod work;

pub(crate) use section::SECTIONS;
#[cfg(test)]
pub(crate) use section::TABLE_3;
pub(crate) use sources::layers;
#[cfg(test)]
pub(crate) use synthetic::sources as synthetic_layers;
pub(crate) use textures::Textures;
pub(crate) use way::{KIND, PART};

use crate::STUDY;
use crate::list::List;
use crate::made::spiral::{Law, Spiral};
use crate::metrics::{self, WHAT};
use crate::projection::Projection;
use device::{LayerScene, LayerTargets, LayerTextures};
use judge::{Met, bytes, judge};
use layers::{Lights, Sampled};
use mesh::{Mesh, vertices};
use sources::Sources;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_globe_views::{Eye, FrameWatch, Opened, fingerprint, write_png};
use terrafill_results::{Case, PlannedCase, Verdict, quantile};
use terrafill_study::{CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, judged, verified};
use texels::Pictures;
use work::{ABLATION_N, Work, work};

/// Texels along a side of a cube's face: as dense along the equator as the finest picture, 4,096 round it.
const FACE: u32 = 1024;
const QUICK_FACE: u32 = 256;
/// Share of a picture's pixels that wrong layers must be found in.
const CONTROL_SHARE: f64 = 0.01;
/// By what share triangles half as long are off a projection's formula, at most. A smooth one gives a quarter; beside a
/// pole and at the rim a map's slope has no bound.
const FINER: f64 = 2.0 / 3.0;

/// All work on shading, as one group of cases.
pub(crate) struct Shadings {
    work: Vec<Work>,
    list: List,
    opened: Rc<Opened>,
    face: u32,
    sources: Rc<Sources>,
}

/// - `what`: its condition of that name
fn is_of(case: &Case, what: &str) -> bool {
    case.condition(metrics::PART) == PART && case.condition(WHAT) == what
}

impl Shadings {
    pub(crate) fn planned(
        list: &List,
        (side_px, samples): (u32, u32),
        is_quick: bool,
        sources: Rc<Sources>,
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let work = work(side_px, is_quick);
        let cases = work.iter().map(|work| PlannedCase {
            id: work.id(list.shaded(work.view).ok()),
            samples,
            may_be_wrong: work.shading.fault > 0,
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                work,
                list: list.clone(),
                opened: Rc::clone(opened),
                face: if is_quick { QUICK_FACE } else { FACE },
                sources,
            },
            open: |group, context| {
                Ok(Box::new(JudgedOnce::new(ShadingPart {
                    group: &group.work,
                    cases: &group.cases,
                    context,
                    pictures: None,
                    targets: BTreeMap::new(),
                    met: None,
                    ready: BTreeMap::new(),
                })))
            },
        }
    }

    fn eye(&self, work: &Work) -> Result<Eye, String> {
        Ok(self.list.shaded(work.view)?.eye(work.size_px))
    }

    fn lights(&self, work: &Work) -> Result<Lights, String> {
        let view = self.list.shaded(work.view)?;
        Ok(Lights::new(view, work.hours.unwrap_or(view.hours)))
    }
}

/// A view, pixels a side, vertices a turn, whether they are stored, and the projection: what triangles depend on.
type MetBy = (&'static str, u32, u32, bool, Projection);

struct ShadingPart<'a> {
    group: &'a Shadings,
    cases: &'a [PlannedCase],
    context: Context<'a>,
    /// As the reference reads them, and as the device does.
    pictures: Option<(Pictures, LayerTextures)>,
    /// By pixels a side.
    targets: BTreeMap<u32, LayerTargets>,
    /// Of the view last judged.
    met: Option<(MetBy, Met)>,
    ready: BTreeMap<usize, LayerScene>,
}

impl ShadingPart<'_> {
    fn mesh(&self, work: &Work, eye: &Eye) -> Result<Mesh, String> {
        if work.is_stored {
            return Ok(Mesh::Stored(Spiral::new(eye, work.n, Law::Published, None)));
        }
        let surface = self.group.opened.get(KIND, [("n", work.n)])?;
        let frame = surface.frame(&eye.camera, eye.size);
        let frame = frame.map_err(|error| error.to_string())?;
        let vertices = vertices(eye, &frame);
        Ok(Mesh::Sent(frame, vertices))
    }

    /// Why a picture is wrong, and its figures.
    fn judged(&mut self, work: &Work, drawn: &Drawn) -> (String, Figures) {
        let Drawn {
            eye,
            lights,
            mesh,
            picture,
            ..
        } = drawn;
        let lost = mesh.lost();
        let by = (
            work.view,
            work.size_px,
            work.n,
            work.is_stored,
            work.projection,
        );
        if self.met.as_ref().is_none_or(|(known, _)| *known != by) {
            self.met = Some((by, mesh.met(eye, work.projection)));
        }
        let (Some((_, met)), Some((pictures, _))) = (&self.met, &self.pictures) else {
            return ("no layers were made".to_owned(), Figures::new());
        };
        let sampled = Sampled {
            pictures,
            shading: work.shading,
        };
        let layers = (&sampled, Some(&*self.group.sources));
        // Clouds that have not moved are no control of themselves.
        let controls = work.what == "layers";
        let found = judge(eye, met, lights, layers, picture, controls);
        let mut figures = vec![
            ("globe_shade_px", found.shown as f64),
            ("globe_shade_beyond_px", found.beyond as f64),
            ("globe_non_finite", (found.non_finite + lost) as f64),
            ("globe_drawn_otherwise_px", found.otherwise as f64),
        ];
        let largest = quantile(&found.from_texels, 1.0);
        figures.extend(found.quantiles());
        let least = found.controls.map(|controls| {
            let least = controls.into_iter().min().unwrap_or(0);
            figures.push(("globe_shade_control_px", least as f64));
            least
        });
        let mut is_tessellation = true;
        let other = work.is_stored.then(|| {
            let other = mesh.met(eye, work.projection.next());
            let other = judge(eye, &other, lights, (&sampled, None), picture, false).beyond;
            let fine = mesh.met_finer(eye, work.projection);
            let of = |met: &Met| met.off_formula(eye, work.projection);
            let (coarse, fine) = (of(met), of(&fine));
            let [most, fine] = [&coarse, &fine].map(|of| quantile(of, 0.99).unwrap_or(f64::NAN));
            is_tessellation = fine < FINER * most;
            figures.extend([
                ("globe_shade_other_px", other as f64),
                (
                    "globe_formula_px_max",
                    quantile(&coarse, 1.0).unwrap_or(f64::NAN),
                ),
                ("globe_formula_px_p99", most),
                ("globe_formula_fine_px_p99", fine),
            ]);
            other
        });
        let is_blind = |found_px: &usize| (*found_px as f64) < CONTROL_SHARE * found.shown as f64;
        let reason = if found.non_finite + lost > 0 {
            let lost = found.non_finite + lost;
            format!("{lost} pixels or vertices are not finite, allowed 0")
        } else if found.shown == 0 {
            "it shows nothing".to_owned()
        } else if found.beyond > 0 {
            format!(
                "{} pixels are farther from the same texels in f64 than 8 bits of place and value explain, by up to \
                 {:.4}, allowed 0",
                found.beyond,
                largest.unwrap_or(f64::INFINITY)
            )
        } else if found.otherwise > 0 {
            format!(
                "{} pixels are drawn that no ray meets, or the other way round, allowed 0",
                found.otherwise
            )
        } else if least.iter().chain(&other).any(is_blind) {
            "wrong layers, or another projection, are found in less than 1 % of the pixels: the comparison sees nothing"
                .to_owned()
        } else if !is_tessellation {
            "triangles half as long are as far off the formula, so that tessellation is not the cause".to_owned()
        } else {
            String::new()
        };
        (reason, figures)
    }
}

/// A frame, drawn and read back.
struct Drawn {
    eye: Eye,
    lights: Lights,
    mesh: Mesh,
    triangles: Arc<[[u32; 3]]>,
    sent: usize,
    picture: Vec<[f32; 4]>,
}

impl ShadingPart<'_> {
    fn drawn(&mut self, case: usize) -> Result<Drawn, Failure> {
        let work = self.group.work[case];
        let (eye, lights) = (self.group.eye(&work)?, self.group.lights(&work)?);
        let mesh = self.mesh(&work, &eye)?;
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let (_, textures) = self.pictures.get_or_insert_with(|| {
            let pictures = Pictures::new(&self.group.sources, self.group.face);
            let textures = LayerTextures::new(&gpu, &pictures);
            (pictures, textures)
        });
        let targets = match self.targets.entry(work.size_px) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                new.insert(LayerTargets::new(&gpu, eye.size, textures, ABLATION_N)?)
            }
        };
        let triangles = mesh.triangles();
        let way = (work.shading, work.projection);
        let mut scene = targets.scene(way, mesh.geometry(), &triangles)?;
        let sent = targets.send(&mut scene, (&eye, &lights), mesh.geometry());
        targets.draw(&scene)?;
        let picture = targets.read()?;
        self.ready.insert(case, scene);
        Ok(Drawn {
            eye,
            lights,
            mesh,
            triangles,
            sent,
            picture,
        })
    }
}

impl Shows for ShadingPart<'_> {
    type Shown = Drawn;

    fn show(&mut self, case: usize) -> Result<(String, Drawn), Failure> {
        let drawn = self.drawn(case)?;
        let hash = fingerprint(&[bytemuck::cast_slice(&drawn.picture)]);
        Ok((hash, drawn))
    }

    fn judge(&mut self, case: usize, drawn: Drawn) -> Result<Verdict, Failure> {
        let work = self.group.work[case];
        let (reason, mut figures) = self.judged(&work, &drawn);
        figures.push(("globe_triangles", drawn.triangles.len() as f64));
        figures.push(("globe_upload_bytes", drawn.sent as f64));
        let mut notes = Vec::new();
        if work.what != "tessellation" {
            let name = self.cases[case].id.key().replace(['/', '='], "-");
            let size = [work.size_px; 2];
            let pixels = drawn.picture.iter().map(|colour| bytes(*colour));
            let path = write_png(self.context.folder, &name, size, pixels)?;
            notes.push(("picture", path));
        }
        Ok(judged(reason, figures, notes))
    }

    /// A frame as the paper's measurements have it: a mesh that is not stored is made and sent anew.
    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let work = self.group.work[case];
        let (eye, lights) = (self.group.eye(&work)?, self.group.lights(&work)?);
        let mut watch = FrameWatch::start();
        let mesh = self.mesh(&work, &eye)?;
        watch.ends("globe_make_cpu_ms");
        let targets = self.targets.get(&work.size_px);
        let targets = targets.ok_or("it has no targets".to_owned())?;
        let scene = verified(&mut self.ready, case)?;
        targets.send(scene, (&eye, &lights), mesh.geometry());
        watch.ends("globe_upload_cpu_ms");
        let gpu_ms = targets.draw(scene)?;
        Ok(watch.drawn(gpu_ms))
    }
}

#[cfg(test)]
mod tests;
