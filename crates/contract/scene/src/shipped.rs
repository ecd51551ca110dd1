// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scenes of `bench-scenes/`, built into the program so that it works from any folder.

/// One file of `bench-scenes/` with its name.
macro_rules! file {
    ($name:literal) => {
        file!(include_str, $name)
    };
    ($include:ident, $name:literal) => {
        (
            $name,
            $include!(concat!("../../../../bench-scenes/", $name)),
        )
    };
}

/// Scenes that need nothing else first, then those that need data.
pub(crate) const SCENES: &[(&str, &str)] = &[
    file!("planet-134.toml"),
    file!("california.toml"),
    file!("square-10m.toml"),
    file!("square-200km.toml"),
    file!("hills.toml"),
    file!("screen-grid.toml"),
    file!("spiral.toml"),
    file!("countries-110m.toml"),
    file!("countries-50m.toml"),
    file!("countries-10m.toml"),
    file!("us-states.toml"),
    file!("blue-marble.toml"),
    file!("fade.toml"),
    file!("hatching.toml"),
    file!("shared-picture.toml"),
    file!("window-west.toml"),
    file!("window-east.toml"),
];

/// Scenes over real elevation, which a run without names leaves out.
pub(crate) const TERRAIN: &[(&str, &str)] = &[
    file!("terrain/countries-over-etopo.toml"),
    file!("terrain/everest.toml"),
    file!("terrain/grand-canyon.toml"),
    file!("terrain/san-francisco.toml"),
];

/// Suites: scenes that are there to break a fill, with what must come of each.
const SUITES: &[(&str, &[(&str, &str)])] = &[("extreme", EXTREME)];

/// What globes break at, by the risk of it.
const EXTREME: &[(&str, &str)] = &[
    file!("extreme/poles.toml"),
    file!("extreme/antimeridian.toml"),
    file!("extreme/hemisphere.toml"),
    file!("extreme/strips-170.toml"),
    file!("extreme/world-minus-hole.toml"),
    file!("extreme/nested-255.toml"),
    file!("extreme/nested-256.toml"),
    file!("extreme/nested-257.toml"),
    file!("extreme/nested-512.toml"),
    file!("extreme/rings-512.toml"),
    file!("extreme/eye-in-volume.toml"),
    file!("extreme/cliffs.toml"),
    file!("extreme/horizon.toml"),
    file!("extreme/strips-half-metre.toml"),
    file!("extreme/shared-borders.toml"),
    file!("extreme/bow-tie.toml"),
    file!("extreme/bow-tie-repaired.toml"),
    file!("extreme/degenerate.toml"),
    file!("extreme/terrain-x1.toml"),
    file!("extreme/terrain-x10.toml"),
    file!("extreme/voids.toml"),
    file!("extreme/flattened.toml"),
    file!("extreme/asteroid.toml"),
    file!("extreme/field-of-view.toml"),
    file!("extreme/viewports.toml"),
    file!("extreme/sky.toml"),
    file!("extreme/smaller-than-a-pixel.toml"),
    file!("extreme/five-thousand.toml"),
    file!("extreme/million-vertices.toml"),
    file!("extreme/nothing-in-view.toml"),
    file!("extreme/under-and-far.toml"),
    file!("extreme/below-the-ellipsoid.toml"),
    file!("extreme/nan-heights.toml"),
    file!("extreme/orthographic.toml"),
    file!("extreme/too-wide.toml"),
    file!("extreme/empty.toml"),
    file!("extreme/nan-coordinates.toml"),
    file!("extreme/beyond-the-pole.toml"),
    file!("extreme/antipodal-edge.toml"),
    file!("extreme/grid-on-the-screen.toml"),
    file!("extreme/spiral-round-the-eye.toml"),
];

/// Height files that scenes name by `embedded`; ours.
const HEIGHTS: &[(&str, &[u8])] = &[
    file!(include_bytes, "extreme/cliffs.tif"),
    file!(include_bytes, "extreme/nan-heights.tif"),
    file!(include_bytes, "extreme/voids.tif"),
];

/// Region files that scenes name by `embedded`.
const DATA: &[(&str, &str)] = &[
    file!("california.geojson"),
    file!("square-10m.geojson"),
    file!("square-200km.geojson"),
    file!("window-west.geojson"),
    file!("window-east.geojson"),
];

/// Names of the scenes that ship with the program, those without need of data first.
#[must_use]
pub fn shipped_scene_names() -> Vec<&'static str> {
    SCENES
        .iter()
        .map(|(file, _)| file.trim_end_matches(".toml"))
        .collect()
}

/// Names of those in folders, which a run without names leaves out: `terrain/everest`, `extreme/poles`.
#[must_use]
pub fn scene_names_in_folders() -> Vec<&'static str> {
    let names = all().skip(SCENES.len());
    names
        .map(|(file, _)| file.trim_end_matches(".toml"))
        .collect()
}

/// Every scene that ships: file and text.
fn all() -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    let suites = SUITES.iter().flat_map(|(_, scenes)| *scenes);
    SCENES.iter().chain(TERRAIN).chain(suites)
}

/// Names of the suites.
#[must_use]
pub fn suite_names() -> Vec<&'static str> {
    names(SUITES)
}

/// File and text of each scene of a suite; `None` for a name that is none.
#[must_use]
pub fn suite_scenes(suite: &str) -> Option<&'static [(&'static str, &'static str)]> {
    find(SUITES, suite)
}

pub(crate) fn height_bytes(name: &str) -> Option<&'static [u8]> {
    find(HEIGHTS, name)
}

pub(crate) fn height_names() -> Vec<&'static str> {
    names(HEIGHTS)
}

/// File of a scene that ships with the program, by name.
#[must_use]
pub fn shipped_scene_text(name: &str) -> Option<&'static str> {
    find(all(), &format!("{name}.toml"))
}

pub(crate) fn data_text(name: &str) -> Option<&'static str> {
    find(DATA, name)
}

pub(crate) fn data_names() -> Vec<&'static str> {
    names(DATA)
}

fn names<T>(all: &[(&'static str, T)]) -> Vec<&'static str> {
    all.iter().map(|(name, _)| *name).collect()
}

fn find<'a, T: Copy + 'a>(
    all: impl IntoIterator<Item = &'a (&'static str, T)>,
    wanted: &str,
) -> Option<T> {
    let mut all = all.into_iter();
    all.find(|(name, _)| *name == wanted).map(|(_, own)| *own)
}
