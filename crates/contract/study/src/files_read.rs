// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a study has read of its scenes, as rows of `inputs.csv`.

use terrafill_results::RunInput;
use terrafill_scene::Scene;

/// Every file that `scene` was read from, with its hash, each followed by what is remarkable about it.
#[must_use]
pub fn files_read(scene: &Scene) -> Vec<RunInput> {
    let row = |file: &str, sha256: &str, warning: &str| RunInput {
        scene: scene.name.clone(),
        file: file.to_owned(),
        sha256: sha256.to_owned(),
        warning: warning.to_owned(),
    };
    let of_file = |file: &terrafill_scene::FileRead| {
        let warnings = file.warnings.iter();
        let warnings = warnings.map(|warning| row(&file.path, "", warning));
        let mut rows = vec![row(&file.path, &file.sha256, "")];
        rows.extend(warnings);
        rows
    };
    scene.files_read.iter().flat_map(of_file).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_scene::{sha256_hex, shipped_scene_text};

    #[test]
    fn a_scene_names_the_files_it_is_from_and_one_that_is_made_names_none() {
        let rows = |name: &str| files_read(&Scene::shipped(name, None).expect("it ships"));
        let bytes = include_bytes!("../../../../bench-scenes/california.geojson");
        let expected = RunInput {
            scene: "california".to_owned(),
            file: "bench-scenes/california.geojson".to_owned(),
            sha256: sha256_hex(bytes),
            warning: String::new(),
        };
        assert_eq!(rows("california"), [expected]);
        // Negative control: regions from a seed are read from nowhere.
        assert_eq!(rows("planet-134"), []);
        for (name, expected) in [("california", true), ("planet-134", false)] {
            let text = shipped_scene_text(name).expect("it ships");
            let names = terrafill_scene::names_files(text, name);
            assert_eq!(names.expect("a scene file"), expected, "{name}");
        }
    }

    #[test]
    fn what_is_remarkable_about_a_file_stands_behind_it_without_a_hash() {
        let mut scene = Scene::shipped("california", None).expect("it ships");
        scene.files_read[0].warnings = vec!["a byte order mark".to_owned()];
        let [file, warning] = &files_read(&scene)[..] else {
            panic!("two rows")
        };
        assert_eq!(file.file, warning.file);
        assert_eq!((file.warning.as_str(), warning.sha256.as_str()), ("", ""));
        assert_eq!(warning.warning, "a byte order mark");
    }
}
