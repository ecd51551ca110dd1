// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which crate may depend on which, by the folder that it stands in.
//!
//! What is allowed is written down, not what is forbidden: a crate in a folder that nobody thought of
//! is refused. Edges of tests count as well, since a technique whose tests need another technique
//! cannot be taken out.

use crate::source::{read, sources};
use anyhow::{Context as _, Result, bail};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::Path;

/// Folders of `crates/`, from the bottom up. A crate may need those of the layers that its own layer
/// names, and none of its own layer unless [`WITHIN`] says so: techniques, surfaces, studies and
/// devices never name each other. So a new crate needs no line here.
const LAYERS: &[(&str, &[&str])] = &[
    ("ground", &[]),
    ("contract", &["ground"]),
    ("volumes", &["ground", "contract"]),
    ("devices", &["ground", "contract", "volumes"]),
    ("techniques", &["ground", "contract", "volumes", "devices"]),
    ("surfaces", &["ground", "contract", "devices"]),
    ("judges", &["ground", "contract"]),
    (
        "studies",
        &["ground", "contract", "volumes", "devices", "judges"],
    ),
    (
        "tools",
        &[
            "ground",
            "contract",
            "volumes",
            "devices",
            "techniques",
            "surfaces",
            "judges",
            "studies",
        ],
    ),
];

/// What a crate may need within its own layer.
const WITHIN: &[(&str, &[&str])] = &[
    ("casters", &["results"]),
    ("core", &["planar"]),
    ("texture", &["core"]),
    ("elevation", &["core"]),
    ("maps", &["core"]),
    ("shaders", &["texture"]),
    ("plot", &["results"]),
    ("surface", &["scene"]),
    ("plan", &["scene", "surface"]),
    ("variant", &["scene", "plan"]),
    ("contract", &["scene", "surface", "plan", "variant"]),
    ("study", &["scene", "contract", "surface"]),
    ("tiled-globe", &["globe-views"]),
    ("globes", &["globe-views", "tiled-globe"]),
    ("outlines", &["shadow-views"]),
    ("shadows", &["outlines", "shadow-views"]),
    ("history", &["gate"]),
    ("terrafill", &["data", "gate", "history", "report"]),
];

/// Crates that may need less than their layer: the reference finds texture coordinates by itself and
/// shares no meshing, projection or fill with what it verifies. `report` opens no device, so it sees
/// results and the kit that plots are drawn with. `gate` starts programs that do, and sees results alone.
/// `history` compares runs as `gate` does. `data` reads what scenes need. `growth` runs on the CPU alone.
const LESS: &[(&str, &[&str])] = &[
    ("core", &["planar"]),
    ("planar", &[]),
    ("results", &[]),
    ("scene", &["core", "texture"]),
    (
        "reference",
        &["core", "scene", "surface", "plan", "contract"],
    ),
    ("report", &["results", "plot"]),
    ("data", &["scene"]),
    ("gate", &["results"]),
    ("history", &["results", "plot", "gate"]),
    ("growth", &["core", "results", "contract", "study", "lab"]),
    ("xtask", &["shaders"]),
];

/// What the tests of a layer may need beside: those of a study draw with every technique on every
/// surface, while the study itself is handed lists and names none. Those of a technique are verified by
/// the reference.
const IN_TESTS: &[(&str, &[&str])] = &[
    ("studies", &["techniques", "surfaces"]),
    ("techniques", &["judges", "surfaces"]),
    ("surfaces", &["judges"]),
];

/// What tests share. Every crate's tests may use it and nothing that ships may.
const DEV_ONLY: &str = "fixtures";

/// What the reference may take from core: bodies, parsed rings, and what is to be made of those that overlap or
/// have opposite ends; nothing that meshes.
const REFERENCE_MAY_IMPORT: &[&str] = &[
    "EdgeRule",
    "Ellipsoid",
    "Geodetic",
    "Inside",
    "NEARLY_OPPOSITE_RAD",
    "Polygon",
    "Region",
    "RegionFileError",
    "Repair",
    "Ring",
    "parse_regions",
];

/// The part of `cargo metadata` that is read.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
pub(crate) struct Package {
    pub(crate) name: String,
    pub(crate) manifest_path: String,
    pub(crate) dependencies: Vec<Dependency>,
}

#[derive(Deserialize)]
pub(crate) struct Dependency {
    pub(crate) name: String,
    /// What the code calls it, where that is another name.
    pub(crate) rename: Option<String>,
    /// `dev` or `build`; `None` for an ordinary one.
    pub(crate) kind: Option<String>,
    path: Option<String>,
}

/// A crate: its short name and the layer that it stands in.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Crate {
    name: String,
    layer: String,
}

impl Crate {
    /// - `folder`: of its manifest, such as `…/crates/ground/core`
    fn new(name: &str, folder: &Path) -> Self {
        let layer = folder.parent().and_then(Path::file_name);
        Self {
            name: name.strip_prefix("terrafill-").unwrap_or(name).to_owned(),
            layer: layer.map_or_else(String::new, |layer| layer.to_string_lossy().into_owned()),
        }
    }
}

/// One crate of the workspace needs another.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Edge {
    from: Crate,
    to: Crate,
    /// `dev` or `build`; `None` for an ordinary one.
    kind: Option<String>,
}

/// What `cargo metadata` says of the workspace's packages.
pub(crate) fn packages_of(metadata: &str) -> Result<Vec<Package>> {
    let metadata: Metadata = serde_json::from_str(metadata).context("cargo metadata")?;
    Ok(metadata.packages)
}

/// Edges between crates of the workspace, sorted.
pub(crate) fn edges(packages: &[Package]) -> Vec<Edge> {
    let mut edges = BTreeSet::new();
    for package in packages {
        let manifest = Path::new(&package.manifest_path);
        let from = Crate::new(&package.name, manifest.parent().unwrap_or(manifest));
        for dependency in &package.dependencies {
            if let Some(path) = &dependency.path {
                edges.insert(Edge {
                    from: from.clone(),
                    to: Crate::new(&dependency.name, Path::new(path)),
                    kind: dependency.kind.clone(),
                });
            }
        }
    }
    edges.into_iter().collect()
}

/// What `name` has in a list; nothing where it has no line.
fn listed<'a>(list: &[(&str, &'a [&'a str])], name: &str) -> Option<&'a [&'a str]> {
    let mut lines = list.iter();
    lines.find(|(of, _)| *of == name).map(|(_, names)| *names)
}

/// Why an edge is not allowed.
fn objection(Edge { from, to, kind }: &Edge) -> Option<String> {
    let is_dev = kind.as_deref() == Some("dev");
    let has = |names: Option<&[&str]>, name: &str| names.is_some_and(|names| names.contains(&name));
    if to.name == DEV_ONLY {
        return (!is_dev).then(|| "allowed: as a dev-dependency".to_owned());
    }
    if from.name == DEV_ONLY {
        // Only tests see it, so that what it needs of a contract ships with nothing.
        let is_below = ["ground", "contract", "volumes"].contains(&to.layer.as_str());
        return (!is_below).then(|| "allowed: ground, contract and volumes".to_owned());
    }
    if is_dev && has(listed(IN_TESTS, &from.layer), &to.layer) {
        return None;
    }
    if let Some(less) = listed(LESS, &from.name) {
        let is_allowed = less.contains(&to.name.as_str());
        return (!is_allowed).then(|| format!("allowed: {}", less.join(", ")));
    }
    let Some(layers) = listed(LAYERS, &from.layer) else {
        let known: Vec<&str> = LAYERS.iter().map(|(layer, _)| *layer).collect();
        let layer = &from.layer;
        return Some(format!(
            "{} stands in {layer:?}, allowed: a folder of crates/ that is {}",
            from.name,
            known.join(", ")
        ));
    };
    let within = listed(WITHIN, &from.name);
    if layers.contains(&to.layer.as_str()) || has(within, &to.name) {
        return None;
    }
    let within = within.unwrap_or_default().iter();
    let allowed: Vec<&str> = layers.iter().chain(within).copied().collect();
    Some(format!("allowed: {}", allowed.join(", ")))
}

/// Refuses edges that are not allowed.
pub(crate) fn check(edges: &[Edge]) -> Result<String> {
    if edges.is_empty() {
        bail!("no edges found: the workspace was not read");
    }
    let forbidden: Vec<String> = edges
        .iter()
        .filter_map(|edge| {
            let why = objection(edge)?;
            Some(format!("{} -> {}: {why}", edge.from.name, edge.to.name))
        })
        .collect();
    if forbidden.is_empty() {
        return Ok(format!("{} edges between crates, all allowed", edges.len()));
    }
    bail!("forbidden dependencies:\n  {}", forbidden.join("\n  "));
}

/// Refuses a configuration of nextest whose group of tests for devices leaves out a crate that opens one.
///
/// Such a crate depends on one in `crates/devices`, itself or by others, so the group is to name these by
/// what depends on them.
pub(crate) fn check_test_group(config: &str, packages: &[Package]) -> Result<String> {
    let folders = packages.iter().map(|package| {
        let manifest = Path::new(&package.manifest_path);
        let of = Crate::new(&package.name, manifest.parent().unwrap_or(manifest));
        (&package.name, of.layer)
    });
    let devices: Vec<&String> = folders
        .filter(|(_, layer)| layer == "devices")
        .map(|(name, _)| name)
        .collect();
    if devices.is_empty() {
        bail!("no crate stands in crates/devices: the workspace was not read");
    }
    let overrides = config.split("[[").skip(1);
    let mut group = overrides.filter(|text| text.contains("\ntest-group = \"gpu\""));
    let filter = group.next().context("nextest's group gpu has no tests")?;
    for name in &devices {
        if !filter.contains(&format!("rdeps({name})")) {
            bail!("nextest's group gpu leaves out what depends on {name}: expected rdeps({name})");
        }
    }
    Ok(format!(
        "nextest's group holds what depends on {} crates of devices",
        devices.len()
    ))
}

/// Refuses a reference that takes anything but bodies and rings from core, or reads a scene's meshes.
///
/// The reference judges what the mesher and its users produce; were it to share their code, a
/// mistake in it would be right by definition.
pub(crate) fn check_reference(folder: &Path) -> Result<String> {
    let mut names = BTreeSet::new();
    for path in sources(folder)? {
        let text = read(&path)?;
        if text.contains(".meshes") {
            bail!("{}: the reference reads a scene's meshes", path.display());
        }
        names.extend(imports_from_core(&text));
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

    fn edge(from: (&str, &str), to: (&str, &str), kind: Option<&str>) -> Edge {
        let of = |(layer, name): (&str, &str)| Crate {
            name: name.to_owned(),
            layer: layer.to_owned(),
        };
        Edge {
            from: of(from),
            to: of(to),
            kind: kind.map(str::to_owned),
        }
    }

    const CORE: (&str, &str) = ("ground", "core");
    const CONTRACT: (&str, &str) = ("contract", "contract");
    const STENCIL: (&str, &str) = ("volumes", "stencil");
    const GPU: (&str, &str) = ("devices", "gpu");
    const VERTEX: (&str, &str) = ("techniques", "vertex");
    const FILLING: (&str, &str) = ("studies", "filling");
    const REFERENCE: (&str, &str) = ("judges", "reference");
    const REPORT: (&str, &str) = ("tools", "report");

    #[test]
    fn what_points_down_is_allowed_also_for_a_newcomer() {
        let newcomer = ("techniques", "newcomer");
        let allowed = [
            edge(CONTRACT, CORE, None),
            edge(STENCIL, CONTRACT, None),
            edge(GPU, STENCIL, None),
            edge(newcomer, GPU, None),
            edge(newcomer, REFERENCE, Some("dev")),
            edge(FILLING, REFERENCE, None),
            edge(FILLING, VERTEX, Some("dev")),
            edge(("tools", "terrafill"), newcomer, None),
            edge(("tools", "terrafill"), REPORT, None),
            edge(CORE, ("ground", "fixtures"), Some("dev")),
        ];
        let summary = check(&allowed).expect("allowed");
        assert!(summary.starts_with("10 edges"), "{summary}");
    }

    #[test]
    fn each_forbidden_edge_is_named() {
        let compute = ("techniques", "compute");
        for (from, to, kind) in [
            (VERTEX, compute, None),
            (VERTEX, compute, Some("dev")),
            (VERTEX, FILLING, None),
            (GPU, ("devices", "vulkan"), None),
            (GPU, VERTEX, None),
            (CONTRACT, GPU, None),
            (CONTRACT, STENCIL, None),
            (STENCIL, GPU, None),
            (("surfaces", "grid"), STENCIL, None),
            (("studies", "growth"), STENCIL, None),
            (REFERENCE, STENCIL, None),
            (CORE, ("ground", "results"), None),
            (CORE, CONTRACT, None),
            (FILLING, VERTEX, None),
            (FILLING, ("studies", "growth"), None),
            (FILLING, REPORT, None),
            (REFERENCE, GPU, None),
            (REFERENCE, ("ground", "texture"), None),
            (REFERENCE, VERTEX, Some("dev")),
            (REPORT, GPU, None),
            (REPORT, FILLING, None),
            (VERTEX, REFERENCE, None),
            (("contract", "scene"), CONTRACT, None),
            (("surfaces", "grid"), ("surfaces", "tiles"), None),
            (VERTEX, ("ground", "fixtures"), None),
            (("elsewhere", "newcomer"), CORE, None),
        ] {
            let error = check(&[edge(CONTRACT, CORE, None), edge(from, to, kind)]);
            let text = error.expect_err(to.1).to_string();
            assert!(text.contains(&format!("{} -> {}:", from.1, to.1)), "{text}");
            assert!(!text.contains("contract -> core"), "{text}");
        }
    }

    #[test]
    fn a_workspace_without_edges_was_not_read() {
        assert!(check(&[]).is_err());
        assert!(packages_of("{}").is_err());
    }

    #[test]
    fn edges_are_read_from_metadata_with_their_layers_and_those_of_tests() {
        let metadata = r#"{"packages":[{"name":"terrafill-contract",
            "manifest_path":"/x/crates/contract/contract/Cargo.toml","dependencies":[
            {"name":"glam","kind":null},
            {"name":"terrafill-scene","kind":null,"path":"/x/crates/contract/scene"},
            {"name":"terrafill-gpu","kind":"dev","path":"/x/crates/devices/gpu"}]}]}"#;
        let edges = edges(&packages_of(metadata).expect("valid"));
        let expected = [
            edge(CONTRACT, GPU, Some("dev")),
            edge(CONTRACT, ("contract", "scene"), None),
        ];
        assert_eq!(edges, expected);
        let error = check(&edges).expect_err("an edge of tests is an edge");
        assert!(error.to_string().contains("contract -> gpu"), "{error}");
    }

    #[test]
    fn a_group_of_tests_that_leaves_out_a_device_is_refused() {
        let package = |name: &str| {
            format!(
                r#"{{"name":"terrafill-{name}","manifest_path":"/x/crates/devices/{name}/Cargo.toml","dependencies":[]}}"#
            )
        };
        let metadata = format!(
            r#"{{"packages":[{},{}]}}"#,
            package("gpu"),
            package("vulkan")
        );
        let packages = packages_of(&metadata).expect("valid");
        let config = |filter: &str| {
            format!("[[profile.default.overrides]]\nfilter = \"{filter}\"\ntest-group = \"gpu\"\n")
        };
        let both = config("rdeps(terrafill-gpu) | rdeps(terrafill-vulkan)");
        assert!(check_test_group(&both, &packages).is_ok());
        for filter in [
            "rdeps(terrafill-gpu)",
            "rdeps(terrafill-gpu) | package(terrafill-vulkan)",
        ] {
            let error = check_test_group(&config(filter), &packages).expect_err(filter);
            assert!(error.to_string().contains("terrafill-vulkan"), "{error}");
        }
        let other = both.replace("\"gpu\"", "\"other\"");
        assert!(check_test_group(&other, &packages).is_err());
        assert!(check_test_group(&both, &[]).is_err());
    }

    #[test]
    fn layers_name_only_layers_below() {
        for (index, (layer, allowed)) in LAYERS.iter().enumerate() {
            for other in *allowed {
                let place = LAYERS.iter().position(|(name, _)| name == other);
                assert!(
                    place.is_some_and(|place| place < index),
                    "{layer} -> {other}"
                );
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
