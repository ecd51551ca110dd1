// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which cases a suite has: each technique in each view, or one for a scene that must be refused whole.
//!
//! Only reasons and expectations are read here. The scenes themselves are opened by their groups.

use super::keys::{EXPECTED, ROLE, SCENE, SCENE_REASON, TECHNIQUE, VIEW};
use super::session::{Closed, State, SuiteSession, drawing, words_of};
use crate::cases::{FillCase, ViewGroup};
use crate::purpose::Purpose;
use crate::scenes::{LastScene, ReadyScene};
use crate::subject::{Subject, Surfaces, Techniques};
use std::cell::OnceCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::Technique;
use terrafill_results::{CaseId, PlannedCase, Skipped};
use terrafill_scene::{
    Expectation, ImageSize, Scene, SceneError, SuiteScene, SuiteView, choices, names_files,
    suite_scenes,
};
use terrafill_study::{
    CaseGroup, Context, Depth, Group, Planned, Request, Session, StudyError, files_read,
};

/// Name of the suite and of its study.
pub const EXTREME: &str = "extreme";

/// Timed frames of a case: correctness is the question, and one time says what a scene is like.
const FRAMES: u32 = 1;

/// View of a scene that must be refused whole.
pub(super) const WHOLE: &str = "whole-scene";

/// A scene that is ready to be drawn.
pub(super) struct Opened {
    pub(super) scene: Arc<Scene>,
    pub(super) ready: Rc<ReadyScene>,
}

type OpenResult = Result<Rc<Opened>, Closed>;

/// One view of a scene, or a scene that must be refused whole.
pub(super) struct SuiteGroup {
    /// Place among the scenes.
    place: usize,
    file: String,
    text: String,
    header: Rc<SuiteScene>,
    /// `None` for a scene that must be refused whole.
    pub(super) view: Option<SuiteView>,
    techniques: Vec<&'static dyn Technique>,
    surfaces: Surfaces,
    size: ImageSize,
    data_dir: Option<PathBuf>,
    last: Rc<LastScene<usize, Rc<Opened>>>,
    /// Made when the group is opened.
    drawn: OnceCell<ViewGroup>,
}

pub(super) fn plan(
    all: Techniques,
    surfaces: Surfaces,
    request: &Request,
) -> Result<Planned, StudyError> {
    let mut techniques = techniques(all, request)?;
    let mut skipped = Vec::new();
    // Each draws the same scenes, so one shows quickly whether they can be read, meshed and drawn.
    if request.depth == Depth::Quick && request.techniques.is_empty() {
        let left_out = techniques.split_off(techniques.len().min(1));
        skipped.extend(left_out.iter().map(|technique| Skipped {
            what: format!("{EXTREME}/{}", technique.name()),
            reason: "a quick run draws by one technique, --technique names others".to_owned(),
        }));
    }
    let scenes = scenes(request)?;
    let last = Rc::new(LastScene::default());
    let mut groups: Vec<Box<dyn Group>> = Vec::new();
    let mut names: Vec<String> = Vec::new();
    let mut inputs = Vec::new();
    for (place, (file, text)) in scenes.into_iter().enumerate() {
        let header = SuiteScene::from_toml(&text, &file).map_err(bad_input)?;
        if names.contains(&header.name) {
            let message = format!("scene {:?} is given twice, allowed: once", header.name);
            return Err(StudyError::BadInput(message));
        }
        names.push(header.name.clone());
        // Only those that name files are opened before their turn; what is wrong with one is said then.
        if names_files(&text, &file).map_err(bad_input)? {
            let scene = Scene::from_toml(&text, &file, request.data_dir.as_deref());
            inputs.extend(scene.iter().flat_map(files_read));
        }
        let header = Rc::new(header);
        let views: Vec<Option<SuiteView>> = match &header.expect {
            Expectation::Refused(_) => vec![None],
            Expectation::Fills => header.views.iter().cloned().map(Some).collect(),
        };
        for view in views {
            let [width, height] = request.size;
            let size = view.as_ref().and_then(|view| view.size);
            let group = SuiteGroup {
                place,
                file: file.clone(),
                text: text.clone(),
                header: Rc::clone(&header),
                view,
                techniques: techniques.clone(),
                surfaces,
                size: size.unwrap_or(ImageSize { width, height }),
                data_dir: request.data_dir.clone(),
                last: Rc::clone(&last),
                drawn: OnceCell::new(),
            };
            groups.push(Box::new(CaseGroup {
                name: format!("{}/{}", group.header.name, group.view_name()),
                cases: group.planned_cases(),
                warm_up: Some(0),
                work: group,
                open,
            }));
        }
    }
    Ok(Planned {
        groups,
        skipped,
        inputs,
    })
}

/// Those whose pictures have to be right, or of these the ones that are named.
fn techniques(
    all: Techniques,
    request: &Request,
) -> Result<Vec<&'static dyn Technique>, StudyError> {
    let all = all.iter().copied();
    let exact: Vec<&'static dyn Technique> = all
        .filter(|technique| technique.has_stencil_switches())
        .collect();
    if request.techniques.is_empty() {
        return Ok(exact);
    }
    let find = |name: &String| {
        let mut known = exact.iter().copied();
        known.find(|known| known.name() == name).ok_or_else(|| {
            let allowed = choices(name, exact.iter().map(|known| known.name()));
            StudyError::BadInput(format!(
                "technique {name:?} of {EXTREME}, allowed: {allowed}"
            ))
        })
    };
    request.techniques.iter().map(find).collect()
}

/// File and text of those asked for, by the name of one in the suite or by a path; all where none is.
fn scenes(request: &Request) -> Result<Vec<(String, String)>, StudyError> {
    let suite = suite_scenes(EXTREME).unwrap_or_default();
    let owned = |(file, text): &(&str, &str)| (format!("bench-scenes/{file}"), (*text).to_owned());
    if request.scenes.is_empty() {
        return Ok(suite.iter().map(owned).collect());
    }
    let folder = format!("{EXTREME}/");
    let find = |name: &String| {
        let name = name.strip_prefix(&folder).unwrap_or(name);
        if name.contains('/') || name.ends_with(".toml") {
            let read = std::fs::read_to_string(name);
            let read = read.map_err(|source| SceneError::Unreadable {
                path: PathBuf::from(name),
                source,
            });
            return Ok((name.to_owned(), read.map_err(bad_input)?));
        }
        let is_it = |(file, _): &&(&str, &str)| *file == format!("{folder}{name}.toml");
        suite.iter().find(is_it).map(owned).ok_or_else(|| {
            let files = suite.iter().map(|(file, _)| Path::new(file).file_stem());
            let allowed = choices(name, files.filter_map(|stem| stem?.to_str()));
            StudyError::BadInput(format!("scene {name:?} of {EXTREME}, allowed: {allowed}"))
        })
    };
    request.scenes.iter().map(find).collect()
}

fn bad_input(error: impl std::fmt::Display) -> StudyError {
    StudyError::BadInput(error.to_string())
}

impl SuiteGroup {
    /// What must come of it.
    pub(super) fn expect(&self) -> &Expectation {
        match &self.view {
            Some(view) => &view.expect,
            None => &self.header.expect,
        }
    }

    fn view_name(&self) -> &str {
        self.view.as_ref().map_or(WHOLE, |view| &view.name)
    }

    fn planned_cases(&self) -> Vec<PlannedCase> {
        let (scene, view) = (&self.header.name, self.view_name());
        let case = |technique: &str, samples: u32| {
            let conditions = [
                (SCENE, scene.clone()),
                (VIEW, view.to_owned()),
                (TECHNIQUE, technique.to_owned()),
                (ROLE, Purpose::Suite.name().to_owned()),
                (EXPECTED, self.expect().text()),
                (SCENE_REASON, self.header.reason.clone()),
            ];
            PlannedCase {
                id: CaseId::new(EXTREME, format!("{scene}/{view}/{technique}"), conditions),
                samples,
                may_be_wrong: false,
            }
        };
        if self.view.is_none() {
            return vec![case("none", 0)];
        }
        let techniques = self.techniques.iter();
        let frames = match self.expect() {
            Expectation::Fills => FRAMES,
            Expectation::Refused(_) => 0,
        };
        techniques
            .map(|technique| case(technique.name(), frames))
            .collect()
    }

    /// Reads, meshes and lays on its surface; whatever goes wrong is the scene's own.
    fn open_scene(&self) -> OpenResult {
        let opened = catch_unwind(AssertUnwindSafe(|| -> OpenResult {
            let scene = Scene::from_toml(&self.text, &self.file, self.data_dir.as_deref());
            let scene = Arc::new(scene.map_err(|error| match error {
                SceneError::DataMissing { .. } => Closed::Missing(error.to_string()),
                other => Closed::Refused(other.to_string()),
            })?);
            let ready = ReadyScene::new(&scene, self.surfaces);
            let ready = ready.map_err(|error| Closed::Refused(error.to_string()))?;
            Ok(Rc::new(Opened { scene, ready }))
        }));
        opened.unwrap_or_else(|panic| Err(Closed::Crashed(words_of(&*panic))))
    }

    fn open_view<'a>(&'a self, context: Context<'a>) -> Result<State<'a>, StudyError> {
        let opened = match self.last.get(self.place, || self.open_scene()) {
            Ok(opened) => opened,
            Err(closed) => return Ok(Err(closed)),
        };
        let Some(view) = &self.view else {
            return Ok(Ok(None));
        };
        let group = match self.drawn.get() {
            Some(group) => group,
            None => match self.view_group(&opened, view) {
                Ok(group) => self.drawn.get_or_init(|| group),
                Err(message) => return Ok(Err(Closed::Refused(message))),
            },
        };
        drawing(group, &opened.ready, context)
    }

    /// The cases of this view of the opened scene.
    fn view_group(&self, opened: &Opened, wanted: &SuiteView) -> Result<ViewGroup, String> {
        let scene = &opened.scene;
        let view = scene.views.iter().find(|view| view.name == wanted.name);
        let view = view.ok_or_else(|| format!("view {:?} is not in the scene", wanted.name))?;
        let mut cases = Vec::new();
        for &technique in &self.techniques {
            // As it should be used, unless the view asks for a switch of its own.
            let full_plan = technique.full_plans(scene.overlap).into_iter().next();
            let full_plan = full_plan.filter(|_| wanted.set.is_empty());
            let mut variant = full_plan.unwrap_or_else(|| technique.main(scene.overlap));
            for (key, value) in &wanted.set {
                match variant.set(key, value) {
                    Ok(true) => {}
                    Ok(false) => return Err(format!("{} has no {key}", technique.name())),
                    Err(error) => return Err(error.to_string()),
                }
            }
            let subject = Subject::Fill(technique, variant);
            cases.push(FillCase::new(subject, Purpose::Suite, FRAMES));
        }
        Ok(ViewGroup {
            scene: Arc::clone(scene),
            view: view.clone(),
            size: self.size,
            cases,
        })
    }
}

fn open<'a>(
    group: &'a CaseGroup<SuiteGroup>,
    context: Context<'a>,
) -> Result<Box<dyn Session + 'a>, StudyError> {
    let mut session = SuiteSession::begin(group.work.expect(), &group.cases, context.folder)?;
    session.state = group.work.open_view(context)?;
    Ok(Box::new(session))
}
