// SPDX-License-Identifier: MIT OR Apache-2.0
//! The picture of a study's case, `terrafill render globes/layers --view night-edge`: drawn and judged as a run does.

use crate::arguments::{RenderArguments, Style};
use crate::data::data_dirs;
use crate::draft;
use crate::outcome::Failure;
use crate::registry::STUDIES;
use image::ImageFormat;
use std::collections::BTreeSet;
use std::path::Path;
use std::rc::Rc;
use terrafill_contract::Devices;
use terrafill_results::{CaseId, Status, Verdict};
use terrafill_scene::{choices, scene_names_in_folders};
use terrafill_study::{Context, Depth, Planned, Request, Study, StudyError};

/// Cases that are verified in search of a picture: some studies draw one of a few cases alone.
const MAX_TRIED: usize = 16;

/// Setting by which a study keeps pictures of all its cases.
const PICTURES: &str = "pictures";

/// A case's picture, as its study writes it.
pub(super) struct CasePicture {
    /// An encoded picture in the format that was asked for.
    pub(super) bytes: Vec<u8>,
    /// What to say of it.
    pub(super) said: Vec<String>,
    /// Why it is wrong, where it is.
    pub(super) objection: Option<String>,
}

/// A study, and values that a case's conditions must have.
pub(super) struct Asked<'a> {
    study: &'static dyn Study,
    values: Vec<&'a str>,
}

impl<'a> Asked<'a> {
    /// What `STUDY` or `STUDY/VALUE…` asks for; `None` where it names a scene, a file, or no study.
    pub(super) fn of(name: &'a str) -> Option<Self> {
        if scene_names_in_folders().contains(&name) {
            return None;
        }
        let mut parts = name.split('/');
        let study = parts.next()?;
        let study = STUDIES.iter().find(|known| known.name() == study)?;
        let values = parts.filter(|value| !value.is_empty()).collect();
        (!Path::new(name).is_file()).then_some(Self {
            study: *study,
            values,
        })
    }

    fn matches(&self, case: &CaseId, arguments: &RenderArguments) -> bool {
        let has = |key: &str, value: &str| case.conditions.get(key).is_some_and(|v| v == value);
        let mut values = self.values.iter();
        let view = arguments.view.as_deref();
        let mut set = arguments.set.iter().flat_map(|all| all.split(','));
        values.all(|value| case.conditions.values().any(|own| own == value))
            && view.is_none_or(|view| has("view", view))
            && set.all(|pair| matches!(pair.split_once('='), Some((key, value)) if has(key, value)))
    }

    /// The picture of the first case that has one.
    ///
    /// # Errors
    /// What is asked for and no study can do, an input that cannot be read, a case without a picture, and a device that
    /// is not there.
    pub(super) fn draw(
        &self,
        arguments: &RenderArguments,
        format: ImageFormat,
    ) -> Result<CasePicture, Failure> {
        draft::refuse_for_scenes(&arguments.own)?;
        let of_scenes = [
            ("--fit", arguments.fit),
            ("--technique", arguments.technique.is_some()),
            ("--ids", arguments.ids.is_some()),
            ("--stats", arguments.stats.is_some()),
        ];
        if let Some((option, _)) = of_scenes.iter().find(|(_, is_given)| *is_given) {
            let study = self.study.name();
            let message = format!("{option}: found with study {study}, allowed: with a scene");
            return Err(Failure::bad_input(message));
        }
        let planned = self.study.plan(&Request {
            depth: Depth::Full,
            samples: Some(1),
            size: arguments.size.into(),
            names_size: true,
            data_dir: data_dirs(&arguments.data)?,
            settings: [(PICTURES.to_owned(), Vec::new())].into(),
            ..Request::default()
        });
        let planned = planned.map_err(Failure::bad_input)?;
        let is_asked = |case: &CaseId| self.matches(case, arguments);
        let number = planned.groups.iter().flat_map(|group| group.cases());
        let number = number.filter(|case| is_asked(&case.id)).count();
        if number == 0 {
            return Err(self.refused(&planned, arguments));
        }
        let folder = tempfile::tempdir().map_err(Failure::bad_input)?;
        let images = folder.path().join("images");
        std::fs::create_dir(images).map_err(Failure::bad_input)?;
        let devices = Rc::new(Devices::new(arguments.adapter.clone()));
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        let (mut tried, mut reason) = (0, String::new());
        for group in &planned.groups {
            if !group.cases().iter().any(|case| is_asked(&case.id)) {
                continue;
            }
            let mut session = group.open(context).map_err(failed)?;
            let cases = group.cases().iter().enumerate();
            for (index, case) in cases.filter(|(_, case)| is_asked(&case.id)) {
                if tried == MAX_TRIED {
                    break;
                }
                tried += 1;
                let verdict = session.verify(index);
                let verdict = verdict.or_else(terrafill_study::Failure::verdict);
                let verdict = verdict.map_err(failed)?;
                let Some(path) = picture(&verdict, arguments.picture.as_deref(), arguments.style)
                else {
                    reason = match (&arguments.picture, verdict.reason.is_empty()) {
                        (Some(name), true) => {
                            let names = choices(name, pictures(&verdict).map(|(name, _)| name));
                            format!("--picture: found {name:?}, allowed: {names}")
                        }
                        _ => verdict.reason,
                    };
                    continue;
                };
                let path = folder.path().join(path);
                return Ok(CasePicture {
                    bytes: encoded(&path, format)?,
                    said: said(&case.id, number - 1),
                    objection: (verdict.status != Status::Ok).then_some(verdict.reason),
                });
            }
        }
        let because = if reason.is_empty() {
            "its study draws none of them".to_owned()
        } else {
            reason
        };
        Err(Failure::bad_input(format!(
            "{}: found no picture of {tried} cases tried, of {number}: {because}; allowed: cases whose report shows one",
            arguments.scene.as_deref().unwrap_or_default()
        )))
    }

    /// That no case has all that was asked for: which values there are.
    fn refused<'b>(&self, planned: &Planned, arguments: &'b RenderArguments) -> Failure {
        let groups = planned.groups.iter();
        let cases: Vec<&CaseId> = groups
            .flat_map(|group| group.cases())
            .map(|case| &case.id)
            .collect();
        let values: BTreeSet<&str> = cases
            .iter()
            .flat_map(|case| case.conditions.values())
            .map(String::as_str)
            .collect();
        let study = self.study.name();
        if let Some(value) = self.values.iter().find(|value| !values.contains(**value)) {
            // Of numbers there are too many where a word is what was meant.
            let is_number = |value: &str| value.parse::<f64>().is_ok();
            let is_like = |own: &&str| !own.is_empty() && is_number(own) == is_number(value);
            let names = values.into_iter().filter(is_like);
            let mut message = format!(
                "{study}: found {value:?}, allowed: {}",
                choices(value, in_order(names))
            );
            for skipped in &planned.skipped {
                message += &format!("\nleft out: {}: {}", skipped.what, skipped.reason);
            }
            return Failure::bad_input(message);
        }
        let has = |case: &CaseId, value: &str| case.conditions.values().any(|own| own == value);
        let alike = cases
            .iter()
            .filter(|case| self.values.iter().all(|value| has(case, value)));
        let of = |key: &str| -> Vec<&str> {
            let values = alike.clone().filter_map(|case| case.conditions.get(key));
            in_order(values.map(String::as_str))
        };
        let asked = |pair: &'b str| pair.split_once('=');
        let set = arguments.set.iter().flat_map(|all| all.split(','));
        let refused = set.filter_map(asked).find_map(|(key, value)| {
            let known = of(key);
            (!known.is_empty() && !known.contains(&value))
                .then(|| format!("--set {key}={}", choices(value, known)))
        });
        let allowed = refused.unwrap_or_else(|| format!("--view {}", choices("", of("view"))));
        Failure::bad_input(format!(
            "{study}: found no case with all of these values, allowed with {:?}: {allowed}",
            self.values,
        ))
    }
}

/// Each once: by their size where all are numbers, else by the alphabet.
fn in_order<'a>(values: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let values: BTreeSet<&str> = values.collect();
    let numbers = values.iter().map(|value| value.parse::<f64>().ok());
    match numbers.collect::<Option<Vec<f64>>>() {
        Some(numbers) => {
            let mut both: Vec<(f64, &str)> = numbers.into_iter().zip(values).collect();
            both.sort_by(|a, b| a.0.total_cmp(&b.0));
            both.into_iter().map(|(_, value)| value).collect()
        }
        None => values.into_iter().collect(),
    }
}

/// Pictures that a verdict names, and their paths relative to the folder.
fn pictures(verdict: &Verdict) -> impl Iterator<Item = (&str, &str)> {
    let notes = verdict.notes.iter();
    let notes = notes.map(|(name, path)| (*name, path.as_str()));
    notes.filter(|(_, path)| path.starts_with("images/"))
}

/// The picture of this name that a verdict has, relative to the folder. Without a name it is the one made for people, where
/// they are asked for and there is one. Else it is the first: what is drawn stands before what it is compared with.
fn picture<'a>(verdict: &'a Verdict, name: Option<&str>, style: Style) -> Option<&'a str> {
    let of = |name: &str| {
        let named = pictures(verdict).find(|(note, _)| *note == name);
        named.map(|(_, path)| path)
    };
    if let Some(name) = name {
        return of(name);
    }
    let for_people = of("map").filter(|_| style == Style::Map);
    let judged = || of("picture").or_else(|| of("image"));
    let any = || pictures(verdict).map(|(_, path)| path).next();
    for_people.or_else(judged).or_else(any)
}

fn encoded(path: &Path, format: ImageFormat) -> Result<Vec<u8>, Failure> {
    let picture = image::open(path).map_err(Failure::bad_input)?.to_rgb8();
    let mut encoded = std::io::Cursor::new(Vec::new());
    let written = picture.write_to(&mut encoded, format);
    written.map_err(Failure::bad_input)?;
    Ok(encoded.into_inner())
}

/// Which case it is, by its conditions, and how many others were asked for by the same words.
fn said(case: &CaseId, others: usize) -> Vec<String> {
    let conditions = case
        .conditions
        .iter()
        .filter(|(_, value)| !value.is_empty());
    let conditions: Vec<String> = conditions
        .map(|(key, value)| format!("{key}={value}"))
        .collect();
    let mut said = vec![format!("{}: {}", case.study, conditions.join(", "))];
    if others > 0 {
        said.push(format!(
            "{others} more cases are like that; --set KEY=VALUE names another, by conditions as above"
        ));
    }
    said
}

fn failed(error: StudyError) -> Failure {
    match error {
        StudyError::NoDevice(_) => Failure::no_device(error),
        _ => Failure::bad_input(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::{Arguments, Verb};
    use clap::Parser as _;

    fn arguments(line: &str) -> RenderArguments {
        let line = format!("terrafill render {line} --out a.png");
        let arguments = Arguments::try_parse_from(line.split(' ')).expect("a command");
        let Verb::Render(arguments) = arguments.verb else {
            panic!("{line}");
        };
        arguments
    }

    #[test]
    fn a_map_of_a_case_is_its_picture_for_people_where_it_has_one() {
        let of = |notes: &[&'static str], style| {
            let notes = notes
                .iter()
                .map(|note| (*note, format!("images/{note}.png")));
            let verdict = Verdict {
                notes: notes.collect(),
                ..Verdict::default()
            };
            picture(&verdict, None, style).map(str::to_owned)
        };
        let both = ["image", "map"];
        assert_eq!(of(&both, Style::Map).as_deref(), Some("images/map.png"));
        // Negative controls: the judged picture, and a case that has no other.
        assert_eq!(
            of(&both, Style::Judged).as_deref(),
            Some("images/image.png")
        );
        assert_eq!(
            of(&["image"], Style::Map).as_deref(),
            Some("images/image.png")
        );
        assert_eq!(of(&[], Style::Map), None);
    }

    #[test]
    fn a_case_is_asked_for_by_values_views_and_conditions() {
        let conditions = [
            ("part", "layers"),
            ("view", "night-edge"),
            ("bumps", "tangent"),
        ];
        let conditions = conditions.map(|(key, value)| (key, value.to_owned()));
        let case = CaseId::new("globes", "a", conditions);
        let is_asked = |line: &str| {
            let arguments = arguments(line);
            let name = arguments.scene.clone().expect("a name");
            Asked::of(&name)
                .expect("a study")
                .matches(&case, &arguments)
        };
        assert!(is_asked("globes"));
        assert!(is_asked("globes/layers --view night-edge"));
        assert!(is_asked("globes/night-edge/layers --set bumps=tangent"));
        // Negative controls.
        assert!(!is_asked("globes/tiles"));
        assert!(!is_asked("globes/layers --view day"));
        assert!(!is_asked("globes/layers --set view=tangent"));
        assert!(!is_asked("globes/layers --set tangent"));
        assert!(Asked::of("california").is_none());
        assert!(Asked::of("extreme/poles").is_none() && Asked::of("extreme/a").is_some());
    }

    #[test]
    fn numbers_are_listed_by_size_and_a_picture_is_named() {
        let of = |values: &[&'static str]| in_order(values.iter().copied());
        assert_eq!(of(&["10", "2", "1", "10"]), ["1", "2", "10"]);
        // Negative control: a word among them is sorted as words are.
        assert_eq!(of(&["10", "2", "any"]), ["10", "2", "any"]);
        let verdict = Verdict {
            notes: vec![
                ("bytes", "1 2".to_owned()),
                ("before", "images/a.png".to_owned()),
                ("picture", "images/b.png".to_owned()),
            ],
            ..Verdict::default()
        };
        let named = |name| picture(&verdict, name, Style::Judged);
        assert_eq!(named(None), Some("images/b.png"));
        assert_eq!(named(Some("before")), Some("images/a.png"));
        // Negative controls: what is no picture, and a name that there is not.
        assert_eq!(named(Some("bytes")), None);
        assert_eq!(named(Some("tree")), None);
    }
}
