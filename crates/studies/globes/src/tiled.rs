// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles of a map over the grid on the screen (StuCoSReC 2018, sections 2.4 and 2.5). Each texel holds its own
//! address, so a picture says exactly which texel every pixel shows.

mod device;
mod mesh;
pub(crate) mod options;
pub(crate) mod picture;
mod section;
pub(crate) mod stage;
mod tile_set;
mod truth;

#[cfg(test)]
pub(crate) use section::PUBLISHED_FPS;
pub(crate) use section::SECTION;

use crate::STUDY;
use crate::clock::FrameWatch;
use crate::keys;
use crate::keys::{CELLS, LEVEL, MERCATOR, SEAM, SIZE_PX, TILES, VIEW};
use crate::list::{Eye, ViewRow};
use crate::opened::Opened;
use device::{MapScene, MapTargets};
use mesh::{MapMesh, map_mesh};
use options::Options;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_results::{CaseId, PlannedCase, Verdict, quantile};
use terrafill_study::{CaseGroup, CaseSession, Context, Failure, Figures, Measures, judged};
use terrafill_surface::{Surface, SurfaceFrame};
use tile_set::{Content, Shown, TileSet};
use toml::{Table, Value};
use truth::{Truth, off_texels, tiles, truths};

/// Name of this part in cases.
pub(crate) const PART: &str = "tiles";
/// The surface under the tiles.
pub(crate) const KIND: &str = "screen-grid";

/// A view, and the ways to lay tiles over it.
pub(crate) struct Tiled {
    eye: Eye,
    options: Vec<Options>,
    opened: Rc<Opened>,
}

impl Tiled {
    pub(crate) fn planned(
        view: &ViewRow,
        (side_px, samples): (u32, u32),
        options: Vec<Options>,
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let cases = options.iter().map(|options| {
            let conditions = [
                (keys::PART, PART.to_owned()),
                (VIEW, view.name.clone()),
                (CELLS, options.n.to_string()),
                (SEAM, options.seam.name()),
                (TILES, options.drawing.name().to_owned()),
                (MERCATOR, options.mercator().to_owned()),
                (LEVEL, options.level().to_owned()),
                (SIZE_PX, side_px.to_string()),
            ];
            let set: Vec<String> = conditions[2..7]
                .iter()
                .map(|(name, value)| format!("{name}={value}"))
                .collect();
            let text = format!("{PART}/{}/{}", view.name, set.join("/"));
            PlannedCase {
                id: CaseId::new(STUDY, text, conditions),
                samples,
                may_be_wrong: options.may_be_wrong(),
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}/{}", view.name),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                eye: view.eye(side_px),
                options,
                opened: Rc::clone(opened),
            },
            open: |group, context| {
                Ok(Box::new(CaseSession(TiledPart {
                    group: &group.work,
                    context,
                    targets: None,
                    truths: BTreeMap::new(),
                    ready: BTreeMap::new(),
                })))
            },
        }
    }
}

struct Ready {
    surface: Arc<dyn Surface>,
    scene: MapScene,
    fingerprint: u64,
}

struct TiledPart<'a> {
    group: &'a Tiled,
    context: Context<'a>,
    targets: Option<MapTargets>,
    /// By number of cells.
    truths: BTreeMap<u32, Rc<Vec<Option<Truth>>>>,
    /// By case.
    ready: BTreeMap<usize, Ready>,
}

/// How far a picture of tiles is off.
#[derive(Debug, Clone, PartialEq, Default)]
struct TiledErrors {
    /// How far outside the texel shown each pixel's place is, by the triangles as drawn; those that hold a pole left
    /// out.
    drawn: Vec<f64>,
    /// By the body.
    body: Vec<f64>,
    seam_px: usize,
    /// Of them, those that show another texel's neighbour but one, or none.
    seam_wrong_px: usize,
    pole_px: usize,
    cap_px: usize,
    missing_px: usize,
}

/// Texels by which a pixel beside the seam may be off.
const ALLOWED_TEXELS: f64 = 0.5;

fn judge(truths: &[Option<Truth>], shown: &[Shown], by_fragment: bool) -> TiledErrors {
    let mut found = TiledErrors::default();
    for (truth, shown) in truths.iter().zip(shown) {
        let Some(truth) = truth else { continue };
        let off = match shown {
            Shown::Texel(texel) => Some(off_texels(*texel, &truth.drawn, by_fragment)),
            Shown::Missing | Shown::Nothing => None,
        };
        found.missing_px += usize::from(off.is_none());
        found.cap_px += usize::from(truth.drawn.cap.is_some());
        if truth.holds_pole {
            found.pole_px += 1;
        } else {
            found.drawn.extend(off);
        }
        if truth.is_at_seam && truth.drawn.cap.is_none() {
            found.seam_px += 1;
            found.seam_wrong_px += usize::from(off.is_none_or(|off| off > ALLOWED_TEXELS));
        }
        if let (Shown::Texel(texel), Some(body)) = (shown, &truth.body) {
            found.body.push(off_texels(*texel, body, by_fragment));
        }
    }
    found
}

/// Of all that the device reads.
fn fingerprint(mesh: &MapMesh) -> u64 {
    use std::hash::{DefaultHasher, Hasher as _};
    let mut hasher = DefaultHasher::new();
    hasher.write(bytemuck::cast_slice(&mesh.vertices));
    hasher.finish()
}

impl TiledPart<'_> {
    fn mesh(
        &self,
        surface: &Arc<dyn Surface>,
        options: &Options,
    ) -> Result<(SurfaceFrame, MapMesh), String> {
        let eye = &self.group.eye;
        let frame = surface.frame(&eye.camera, eye.size);
        let frame = frame.map_err(|error| error.to_string())?;
        let mesh = map_mesh(&eye.body, &eye.camera, &frame, options);
        Ok((frame, mesh))
    }
}

impl Measures for TiledPart<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let (eye, options) = (&self.group.eye, self.group.options[case]);
        if self.targets.is_none() {
            let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
            self.targets = Some(MapTargets::new(&gpu, eye.size));
        }
        let surface = grid(&self.group.opened, options.n)?;
        let (frame, mesh) = self.mesh(&surface, &options)?;
        let known = self.truths.entry(options.n);
        let truths = Rc::clone(known.or_insert_with(|| Rc::new(truths(eye, &frame))));
        let targets = self.targets.as_mut();
        let targets = targets.ok_or(DeviceError::Missing("targets of the map"))?;
        let all = tiles(&truths, &options);
        let mut scene = targets.scene(&options, &truths, (all, Content::Addresses))?;
        let sent = targets.send(&mut scene, eye, &options, &mesh);
        targets.draw(&scene)?;
        let shown = targets.shown(&scene)?;
        let found = judge(&truths, &shown, options.by_fragment);
        let verdict = verdict(&found, &mesh, &scene, sent);
        let ready = Ready {
            surface,
            scene,
            fingerprint: fingerprint(&mesh),
        };
        self.ready.insert(case, ready);
        Ok(verdict)
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let (eye, options) = (&self.group.eye, self.group.options[case]);
        let ready = self.ready.remove(&case);
        let mut ready = ready.ok_or("it was not verified".to_owned())?;
        let mut watch = FrameWatch::start();
        let (_, mesh) = self.mesh(&ready.surface, &options)?;
        watch.ends("globe_make_cpu_ms");
        let targets = self.targets.as_ref();
        let targets = targets.ok_or("it has no targets".to_owned())?;
        targets.send(&mut ready.scene, eye, &options, &mesh);
        watch.ends("globe_upload_cpu_ms");
        let gpu_ms = targets.draw(&ready.scene)?;
        let values = watch.drawn(gpu_ms);
        let is_same = fingerprint(&mesh) == ready.fingerprint;
        self.ready.insert(case, ready);
        if !is_same {
            let reason = "it made other triangles than when it was verified";
            return Err(reason.to_owned().into());
        }
        Ok(values)
    }
}

/// A grid on the screen of `n` × `n` cells.
fn grid(opened: &Opened, n: u32) -> Result<Arc<dyn Surface>, String> {
    let parameters = Table::from_iter([("n".to_owned(), Value::Integer(n.into()))]);
    opened.get(KIND, &parameters)
}

fn verdict(found: &TiledErrors, mesh: &MapMesh, scene: &MapScene, sent: u64) -> Verdict {
    let tiles = scene.set.tiles.len();
    let mut figures = vec![
        ("globe_tile_px", found.drawn.len() as f64),
        ("globe_tile_seam_px", found.seam_px as f64),
        ("globe_tile_seam_wrong_px", found.seam_wrong_px as f64),
        ("globe_tile_pole_px", found.pole_px as f64),
        ("globe_tile_cap_px", found.cap_px as f64),
        ("globe_tile_missing_px", found.missing_px as f64),
        ("globe_tile_crossing", mesh.crossing as f64),
        ("globe_tile_missed", mesh.missed as f64),
        ("globe_tile_count", tiles as f64),
        ("globe_tile_draws", MapTargets::draws(scene) as f64),
        (
            "globe_tile_bytes",
            tiles as f64 * TileSet::BYTES_PER_TILE as f64,
        ),
        ("globe_triangles", (mesh.vertices.len() / 3) as f64),
        ("globe_upload_bytes", sent as f64),
    ];
    let mut add = |name, of: &[f64], share| {
        figures.extend(quantile(of, share).map(|value| (name, value)));
    };
    add("globe_tile_texels_max", &found.drawn, 1.0);
    add("globe_tile_texels_p99", &found.drawn, 0.99);
    add("globe_tile_true_texels_max", &found.body, 1.0);
    add("globe_tile_true_texels_p99", &found.body, 0.99);
    add("globe_tile_true_texels_median", &found.body, 0.5);
    let reason = match found.seam_wrong_px {
        0 => String::new(),
        wrong => format!(
            "{wrong} of {} pixels beside ±180° show a texel off by more than {ALLOWED_TEXELS} or none, allowed 0",
            found.seam_px
        ),
    };
    let notes = vec![("triangles", format!("{:016x}", fingerprint(mesh)))];
    judged(reason, figures, notes)
}

#[cfg(test)]
mod tests;
