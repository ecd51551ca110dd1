// SPDX-License-Identifier: MIT OR Apache-2.0
//! `scenes` and `studies`: what there is.

use crate::arguments::{ScenesArguments, StudiesArguments};
use crate::data::data_dirs;
use crate::outcome::{Failure, Outcome, print, print_json};
use crate::registry::STUDIES;
use rayon::prelude::*;
use serde::Serialize;
use terrafill_results::MetricRow;
use terrafill_scene::{Scene, SceneError, scene_names_in_folders, shipped_scene_names};

/// A scene as it is listed.
#[derive(Serialize)]
#[serde(untagged)]
enum ListedScene {
    Available {
        name: &'static str,
        available: bool,
        description: String,
        body: &'static str,
        edges: &'static str,
        overlap: &'static str,
        regions: usize,
        vertices: usize,
        views: Vec<String>,
    },
    /// Its data is not there.
    Skipped {
        name: &'static str,
        available: bool,
        reason: String,
        needs: String,
        sha256: String,
        how: String,
    },
    Wrong {
        name: &'static str,
        available: bool,
        reason: String,
    },
}

impl ListedScene {
    fn new(name: &'static str, scene: Result<Scene, SceneError>) -> Self {
        match scene {
            Ok(scene) => Self::Available {
                name,
                available: true,
                body: scene.body.name(),
                edges: scene.edge_rule.name(),
                overlap: scene.overlap.name(),
                regions: scene.regions.len(),
                vertices: scene.regions.iter().map(|r| r.vertex_count()).sum(),
                views: scene.views.into_iter().map(|view| view.name).collect(),
                description: scene.description,
            },
            Err(SceneError::DataMissing {
                file,
                sha256,
                why,
                how,
                ..
            }) => Self::Skipped {
                name,
                available: false,
                reason: why.clone(),
                needs: file,
                sha256,
                how,
            },
            Err(error) => Self::Wrong {
                name,
                available: false,
                reason: error.to_string(),
            },
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Available {
                name,
                description,
                body,
                edges,
                regions,
                vertices,
                views,
                ..
            } => format!(
                "{name}\n    {description}\n    {body} · {edges} edges · {regions} regions, \
                 {vertices} vertices · views {}\n",
                views.join(", ")
            ),
            Self::Skipped {
                name,
                reason,
                needs,
                sha256,
                how,
                ..
            } => format!(
                "{name}\n    skipped: {reason}\n    needs {needs}\n    sha256 {sha256}\n    {how}\n"
            ),
            Self::Wrong { name, reason, .. } => format!("{name}\n    not available: {reason}\n"),
        }
    }
}

pub(crate) fn scenes(arguments: &ScenesArguments) -> Result<Outcome, Failure> {
    let data = data_dirs(&arguments.data)?;
    let names = [shipped_scene_names(), scene_names_in_folders()].concat();
    let scenes: Vec<ListedScene> = names
        .into_par_iter()
        .map(|name| ListedScene::new(name, Scene::shipped(name, data.as_deref())))
        .collect();
    if arguments.json {
        print_json(&serde_json::json!({ "scenes": scenes }))?;
    } else {
        let texts: Vec<String> = scenes.iter().map(ListedScene::text).collect();
        print(texts.concat())?;
    }
    Ok(Outcome::Done)
}

pub(crate) fn studies(arguments: &StudiesArguments) -> Result<Outcome, Failure> {
    if arguments.json {
        let studies: Vec<serde_json::Value> = STUDIES
            .iter()
            .map(|study| {
                let metrics: Vec<MetricRow> = study.metrics().iter().map(MetricRow::from).collect();
                serde_json::json!({
                    "name": study.name(),
                    "question": study.chapter().question(),
                    "metrics": metrics,
                })
            })
            .collect();
        print_json(&serde_json::json!({ "studies": studies }))?;
        return Ok(Outcome::Done);
    }
    if arguments.markdown {
        print(metrics_as_markdown())?;
        return Ok(Outcome::Done);
    }
    let texts: Vec<String> = STUDIES
        .iter()
        .map(|study| {
            let (name, question) = (study.name(), study.chapter().question());
            format!(
                "{name}\n    {question}\n    {} metrics\n",
                study.metrics().len()
            )
        })
        .collect();
    print(texts.concat())?;
    Ok(Outcome::Done)
}

/// A table of each study's metrics, in Markdown.
fn metrics_as_markdown() -> String {
    let mut text = String::new();
    for study in STUDIES {
        text += &format!(
            "\n### Study `{}`\n\n{}\n\n| metric | unit | kind | better | meaning |\n|---|---|---|---|---|\n",
            study.name(),
            study.chapter().question()
        );
        for metric in study.metrics() {
            let kind = metric.kind.name();
            let better = format!("{:?}", metric.better).to_lowercase();
            text += &format!(
                "| `{}` | {} | {kind} | {better} | {} |\n",
                metric.name, metric.unit, metric.meaning
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_metric_has_a_row_with_its_meaning() {
        let text = metrics_as_markdown();
        let has_row = |name: &str, meaning: &str| {
            let mut lines = text.lines();
            lines.any(|line| line.starts_with(&format!("| `{name}` |")) && line.contains(meaning))
        };
        let metrics = STUDIES.iter().flat_map(|study| study.metrics());
        for metric in metrics {
            assert!(has_row(metric.name, metric.meaning), "{}", metric.name);
        }
        // Negative control: a metric that no study declares.
        assert!(!has_row("fill_moon_ms", ""));
    }
}
