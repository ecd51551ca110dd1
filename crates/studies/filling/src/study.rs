// SPDX-License-Identifier: MIT OR Apache-2.0
//! The study: a group for each view of each scene.

use crate::cases::ViewGroup;
use crate::chapter::FillingChapter;
use crate::keys::CONDITIONS;
use crate::metrics::METRICS;
use crate::request::{STUDY, Wishes};
use crate::scenes::{LastReady, ReadyScene, plan_scenes};
use crate::session::ViewSession;
use crate::subject::{Subject, Surfaces, Techniques};
use std::rc::Rc;
use terrafill_results::{Chapter, ConditionKey, Metric};
use terrafill_scene::Overlap;
use terrafill_study::{CaseGroup, Group, Planned, Request, Study, StudyError, files_read};

/// Which technique fills regions with which error, at which cost.
#[derive(Debug, Clone, Copy)]
pub struct FillingStudy {
    /// Techniques that it compares, in the order in which they are measured.
    pub techniques: Techniques,
    /// What users would pick instead: timed whether their pictures are right or not.
    pub rivals: Techniques,
    /// Surfaces that scenes may lie on.
    pub surfaces: Surfaces,
}

impl Study for FillingStudy {
    fn name(&self) -> &'static str {
        STUDY
    }

    fn metrics(&self) -> &'static [Metric] {
        &METRICS
    }

    fn conditions(&self) -> Vec<ConditionKey> {
        // Switches and parameters are conditions under their own names.
        let fills = self.techniques.iter().chain(self.rivals);
        let settings = fills.flat_map(|technique| {
            let main = technique.main(Overlap::Disjoint);
            Subject::Fill(*technique, main).settings()
        });
        let keys = settings.map(|(key, _)| key);
        CONDITIONS.iter().copied().chain(keys).collect()
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let wishes = Wishes::new(request, [self.techniques, self.rivals], self.surfaces)?;
        let last = Rc::new(LastReady::default());
        let (groups, mut skipped) = plan_scenes(&wishes, &last)?;
        skipped.extend(wishes.missing_rivals.iter().cloned());
        let mut inputs = Vec::new();
        let of_one_scene = |a: &ViewGroup, b: &ViewGroup| a.scene.name == b.scene.name;
        for of_scene in groups.chunk_by(of_one_scene) {
            inputs.extend(files_read(&of_scene[0].scene));
        }
        let groups = groups.into_iter().map(|work| -> Box<dyn Group> {
            Box::new(CaseGroup {
                name: work.name(),
                cases: work.cases.iter().map(|case| work.planned(case)).collect(),
                warm_up: None,
                work: (work, wishes.surfaces, Rc::clone(&last)),
                open: |group, context| {
                    let (view, surfaces, last) = &group.work;
                    let scene = &view.scene;
                    let make = || ReadyScene::new(scene, surfaces);
                    let ready = last.get(scene.name.clone(), make)?;
                    let session = ViewSession::new(view, &ready, context)?;
                    Ok(Box::new(session))
                },
            })
        });
        Ok(Planned {
            groups: groups.collect(),
            skipped,
            inputs,
        })
    }

    fn chapter(&self) -> &dyn Chapter {
        &FillingChapter
    }
}
