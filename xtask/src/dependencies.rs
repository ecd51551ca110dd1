// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which crate may depend on which.
//!
//! An allow list, not a list of what is forbidden: a crate that nobody thought of is refused until
//! someone writes down where it stands. Edges of tests count as well, since a backend whose tests
//! need another backend cannot be taken out.

use anyhow::{Context as _, Result, bail};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::Path;

/// What a crate may depend on, in the short names of the folders.
///
/// `core ← scene ← fill ← {devices ← techniques, conformance, filling} ← terrafill`; `core ← texture ←
/// {scene, fill, shaders}`; `{conformance, filling, report} → results`. Techniques never name each
/// other, nor does a study name them: `terrafill` holds the list. The reference finds texture coordinates by itself. `report` opens no device, so it sees results, and
/// the kit that plots are drawn with.
const ALLOWED: &[(&str, &[&str])] = &[
    ("core", &[]),
    ("texture", &["core"]),
    ("scene", &["core", "texture"]),
    ("fill", &["core", "texture", "scene"]),
    ("shaders", &["texture"]),
    ("gpu", &["core", "texture", "scene", "fill", "shaders"]),
    ("vulkan", &["core", "scene", "fill", "shaders"]),
    ("vertex", &["core", "scene", "fill", "shaders", "gpu"]),
    ("compute", &["core", "scene", "fill", "shaders", "gpu"]),
    ("native", &["core", "scene", "fill", "shaders", "vulkan"]),
    ("reference", &["core", "scene", "fill"]),
    ("results", &[]),
    ("plot", &["results"]),
    ("study", &["results"]),
    (
        "conformance",
        &[
            "core",
            "texture",
            "scene",
            "fill",
            "shaders",
            "gpu",
            "vulkan",
            "vertex",
            "compute",
            "native",
            "reference",
            "results",
        ],
    ),
    (
        "filling",
        &[
            "core",
            "texture",
            "scene",
            "fill",
            "shaders",
            "gpu",
            "vulkan",
            "reference",
            "conformance",
            "results",
            "plot",
        ],
    ),
    (
        "growth",
        &["core", "scene", "fill", "results", "plot", "study"],
    ),
    (
        "precision",
        &["core", "texture", "fill", "gpu", "results", "plot", "study"],
    ),
    ("report", &["results", "plot"]),
    (
        "terrafill",
        &[
            "core",
            "scene",
            "fill",
            "shaders",
            "gpu",
            "vulkan",
            "vertex",
            "compute",
            "native",
            "reference",
            "conformance",
            "results",
            "study",
            "filling",
            "growth",
            "precision",
            "report",
        ],
    ),
    ("fixtures", &["core", "scene", "fill"]),
    ("xtask", &["shaders"]),
];

/// What the tests of a crate may need beside: those of a study draw with every technique, while the
/// study itself is handed a list and names none.
const ALLOWED_IN_TESTS: &[(&str, &[&str])] = &[("filling", &["vertex", "compute", "native"])];

/// What tests share. Every crate's tests may use it and nothing that ships may.
const DEV_ONLY: &str = "fixtures";

/// What the reference may take from core: bodies and parsed rings, nothing that meshes.
const REFERENCE_MAY_IMPORT: &[&str] = &[
    "EdgeRule",
    "Ellipsoid",
    "Geodetic",
    "Polygon",
    "Region",
    "RegionFileError",
    "Ring",
    "parse_regions",
];

/// The part of `cargo metadata` that is read.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    dependencies: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    name: String,
    kind: Option<String>,
    path: Option<String>,
}

/// One crate of the workspace needs another.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Edge {
    from: String,
    to: String,
    /// `dev` or `build`; `None` for an ordinary one.
    kind: Option<String>,
}

/// `terrafill-core` → `core`; `terrafill` and `xtask` stay.
fn short(name: &str) -> String {
    name.strip_prefix("terrafill-").unwrap_or(name).to_owned()
}

/// Edges between crates of the workspace, sorted.
pub(crate) fn edges(metadata: &str) -> Result<Vec<Edge>> {
    let metadata: Metadata = serde_json::from_str(metadata).context("cargo metadata")?;
    let mut edges = BTreeSet::new();
    for package in &metadata.packages {
        let inside = package.dependencies.iter().filter(|d| d.path.is_some());
        edges.extend(inside.map(|dependency| Edge {
            from: short(&package.name),
            to: short(&dependency.name),
            kind: dependency.kind.clone(),
        }));
    }
    Ok(edges.into_iter().collect())
}

/// One line per crate, for the golden: whoever adds an edge sees it in the review.
pub(crate) fn listing(edges: &[Edge]) -> String {
    edges
        .iter()
        .map(|edge| {
            let kind = edge
                .kind
                .as_ref()
                .map_or(String::new(), |k| format!(" ({k})"));
            format!("{} -> {}{kind}\n", edge.from, edge.to)
        })
        .collect()
}

/// Refuses edges that are not allowed.
pub(crate) fn check(edges: &[Edge]) -> Result<String> {
    if edges.is_empty() {
        bail!("no edges found: the workspace was not read");
    }
    let mut forbidden = Vec::new();
    for Edge { from, to, kind } in edges {
        let in_tests = ALLOWED_IN_TESTS.iter().find(|(name, _)| name == from);
        let is_for_tests = in_tests.is_some_and(|(_, allowed)| allowed.contains(&to.as_str()));
        if is_for_tests && kind.as_deref() == Some("dev") {
            continue;
        }
        if to == DEV_ONLY {
            if kind.as_deref() != Some("dev") {
                forbidden.push(format!("{from} -> {to}: allowed: as a dev-dependency"));
            }
            continue;
        }
        match ALLOWED.iter().find(|(name, _)| name == from) {
            None => forbidden.push(format!("{from} -> {to}: {from} is not in the allow list")),
            Some((_, allowed)) if !allowed.contains(&to.as_str()) => {
                forbidden.push(format!("{from} -> {to}: allowed: {}", allowed.join(", ")));
            }
            Some(_) => {}
        }
    }
    if forbidden.is_empty() {
        return Ok(format!("{} edges between crates, all allowed", edges.len()));
    }
    bail!("forbidden dependencies:\n  {}", forbidden.join("\n  "));
}

/// Refuses a reference that takes anything but bodies and rings from core, or reads a scene's meshes.
///
/// The reference judges what the mesher and its users produce; were it to share their code, a
/// mistake in it would be right by definition.
pub(crate) fn check_reference(folder: &Path) -> Result<String> {
    let mut names = BTreeSet::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).with_context(|| next.display().to_string())? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text =
                    std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
                if text.contains(".meshes") {
                    bail!("{}: the reference reads a scene's meshes", path.display());
                }
                names.extend(imports_from_core(&text));
            }
        }
    }
    let allowed = |name: &&String| REFERENCE_MAY_IMPORT.contains(&name.as_str());
    let wrong: Vec<String> = names
        .iter()
        .filter(|name| !allowed(name))
        .cloned()
        .collect();
    if !wrong.is_empty() {
        bail!(
            "reference takes {} from core; allowed: {}",
            wrong.join(", "),
            REFERENCE_MAY_IMPORT.join(", ")
        );
    }
    if names.is_empty() {
        bail!("{}: nothing is taken from core: not read", folder.display());
    }
    Ok(format!(
        "reference takes {} names from core, all allowed",
        names.len()
    ))
}

/// Names after `terrafill_core::`, alone or in braces.
fn imports_from_core(text: &str) -> BTreeSet<String> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == '*';
    let mut names = BTreeSet::new();
    for after in text.split("terrafill_core::").skip(1) {
        let list = match after.strip_prefix('{') {
            Some(braced) => braced.split('}').next().unwrap_or(braced),
            None => after.split(|c| !is_name(c)).next().unwrap_or(after),
        };
        // `Name as Other` imports Name; a nested path would be refused by its first part.
        names.extend(
            list.split(',')
                .filter_map(|item| item.split_whitespace().next())
                .map(str::to_owned),
        );
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(from: &str, to: &str) -> Edge {
        Edge {
            from: from.to_owned(),
            to: to.to_owned(),
            kind: None,
        }
    }

    #[test]
    fn edges_of_the_architecture_pass() {
        let good = [("scene", "core"), ("vertex", "gpu"), ("filling", "results")];
        let edges: Vec<Edge> = good.map(|(from, to)| edge(from, to)).to_vec();
        assert_eq!(
            check(&edges).expect("allowed"),
            "3 edges between crates, all allowed"
        );
    }

    #[test]
    fn every_forbidden_edge_is_refused_by_name() {
        let forbidden = [
            ("core", "scene"),
            ("fill", "gpu"),
            ("vertex", "compute"),
            ("vertex", "reference"),
            ("gpu", "vulkan"),
            ("reference", "gpu"),
            ("reference", "vertex"),
            ("reference", "texture"),
            ("texture", "scene"),
            ("results", "core"),
            ("report", "gpu"),
            ("report", "filling"),
            ("filling", "report"),
            ("filling", "terrafill"),
            ("shaders", "core"),
            ("newcomer", "core"),
        ];
        for (from, to) in forbidden {
            let error = check(&[edge("scene", "core"), edge(from, to)]).expect_err(to);
            let text = error.to_string();
            assert!(text.contains(&format!("{from} -> {to}:")), "{text}");
            assert!(!text.contains("scene -> core"), "{text}");
        }
    }

    #[test]
    fn a_study_names_techniques_in_its_tests_only() {
        let of = |kind: Option<&str>| Edge {
            kind: kind.map(str::to_owned),
            ..edge("filling", "vertex")
        };
        assert!(check(&[of(Some("dev"))]).is_ok());
        assert!(check(&[of(None)]).is_err());
    }

    #[test]
    fn fixtures_are_for_tests_only() {
        let mut fixtures = edge("core", "fixtures");
        assert!(check(std::slice::from_ref(&fixtures)).is_err());
        fixtures.kind = Some("dev".to_owned());
        check(&[fixtures]).expect("allowed");
    }

    #[test]
    fn a_workspace_without_edges_was_not_read() {
        assert!(check(&[]).is_err());
        assert!(edges("{}").is_err());
    }

    #[test]
    fn edges_are_read_from_metadata_with_those_of_tests() {
        let metadata = r#"{"packages":[{"name":"terrafill-fill","dependencies":[
            {"name":"glam","kind":null},
            {"name":"terrafill-scene","kind":null,"path":"p"},
            {"name":"terrafill-gpu","kind":"dev","path":"p"}]}]}"#;
        let edges = edges(metadata).expect("valid");
        assert_eq!(listing(&edges), "fill -> gpu (dev)\nfill -> scene\n");
        let error = check(&edges).expect_err("an edge of tests is an edge");
        assert!(error.to_string().contains("fill -> gpu"), "{error}");
    }

    #[test]
    fn the_allow_list_has_no_circle() {
        // Whoever is allowed must stand earlier in the list.
        for (i, (name, allowed)) in ALLOWED.iter().enumerate() {
            for other in *allowed {
                let place = ALLOWED.iter().position(|(n, _)| n == other);
                assert!(place.is_some_and(|place| place < i), "{name} -> {other}");
            }
        }
    }

    #[test]
    fn a_reference_that_meshes_is_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        assert!(check_reference(folder.path()).is_err(), "nothing was read");
        let good = "use terrafill_core::{Ellipsoid,\n    Ring};\nterrafill_core::Region";
        std::fs::write(folder.path().join("lib.rs"), good).expect("writable");
        let summary = check_reference(folder.path()).expect("allowed");
        assert!(summary.contains("3 names"), "{summary}");
        let below = folder.path().join("below");
        std::fs::create_dir(&below).expect("writable");
        for twin in [
            "use terrafill_core::{Ellipsoid, RegionMesh};",
            "terrafill_core::RegionMesh::area",
            "use terrafill_core::*;",
            "use terrafill_core::{RegionMesh as Region};",
            "input.scene.meshes.len()",
        ] {
            std::fs::write(below.join("more.rs"), twin).expect("writable");
            assert!(check_reference(folder.path()).is_err(), "{twin}");
        }
    }
}
