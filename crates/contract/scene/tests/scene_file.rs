// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scene files that are wrong: each gives one exact message, and the same file unbroken loads.

use sha2::{Digest, Sha256};
use terrafill_core::{EdgeRule, Inside};
use terrafill_scene::{
    DataNeed, LevelChoice, Outside, Overlap, Scene, SceneError, SceneTexture, TexturePlacement,
    TextureShare, scene_needs, sha256_hex,
};

const GOOD: &str = r#"name = "test"
description = "One square"
body = "wgs84"

[regions]
embedded = "california.geojson"

[surface]
kind = "ellipsoid"

[[views]]
name = "a"
longitude_deg = 10
latitude_deg = 20
height_m = 5_000
heading_deg = 0
pitch_deg = -90
"#;

const SECOND_VIEW: &str = r#"
[[views]]
name = "a"
longitude_deg = 0
latitude_deg = 0
height_m = 1
heading_deg = 0
pitch_deg = 0
"#;

const FILE_SOURCE: &str = r#"file = "a.geojson"
sha256 = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
how = "draw it""#;

fn message(text: &str) -> String {
    match Scene::from_toml(text, "t.toml", None) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => error.to_string(),
    }
}

/// Replaces one part of the good scene; the part must be there.
fn broken(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    GOOD.replacen(from, to, 1)
}

/// Mistakes in a good scene, two lines each: what is replaced by what, with `\n` for a line break, and the message
/// behind the name of the file.
#[track_caller]
fn assert_all_refused(good: &str, mistakes: &str) {
    let mut lines = mistakes.lines();
    while let (Some(change), Some(expected)) = (lines.next(), lines.next()) {
        let change = change.replace("\\n", "\n");
        let (from, to) = change.split_once(" ->").expect(expected);
        let text = good.replacen(from, to.trim_start(), 1);
        assert_ne!(text, good, "{from}");
        assert_eq!(message(&text), format!("t.toml: {}", expected.trim()));
    }
}

#[test]
fn the_good_scene_loads_with_its_defaults() {
    let scene = Scene::from_toml(GOOD, "t.toml", None).expect("valid");
    assert_eq!(scene.edge_rule, EdgeRule::Planar);
    assert_eq!(scene.overlap, Overlap::Disjoint);
    assert_eq!(
        (scene.surface.kind.as_str(), scene.surface.file.as_str()),
        ("ellipsoid", "t.toml")
    );
    assert!(scene.surface.parameters.is_empty());
    assert!(scene.sweep_boundary_tolerance_m.is_empty() && scene.sweep_cap_step_deg.is_empty());
    assert!(!scene.sweep_positions);
    assert_eq!(scene.levels, LevelChoice::Automatic);
    let pose = scene.views[0].pose;
    assert_eq!(pose.near_m, 5.0);
    assert_eq!(pose.fov_y_rad, 60_f64.to_radians());
    assert_eq!(pose.eye.latitude_rad, 20_f64.to_radians());
}

#[test]
fn keys_of_the_surface_are_kept_and_not_read() {
    let without = broken("[surface]\nkind = \"ellipsoid\"\n", "");
    let scene = Scene::from_toml(&without, "t.toml", None).expect("valid");
    assert_eq!(scene.surface.kind, "ellipsoid");
    let text = broken(
        "kind = \"ellipsoid\"",
        "kind = \"any\"\nseed = 7\nfolders = [\"a\"]",
    );
    let surface = Scene::from_toml(&text, "t.toml", None)
        .expect("valid")
        .surface;
    assert_eq!(surface.kind, "any");
    assert_eq!(surface.parameters["seed"].as_integer(), Some(7));
    assert_eq!(surface.parameters.len(), 2);
    // Negative control: elsewhere a key that means nothing is refused.
    let stray = broken("[surface]", "[mesh]\nseed = 7\n[surface]");
    assert!(message(&stray).contains("seed"));
    assert!(message(&broken("kind = \"ellipsoid\"", "kind = 3")).contains("expected a string"));
}

#[test]
fn every_setting_arrives() {
    let text = broken(
        "body = \"wgs84\"",
        "body = \"moon\"\nedges = \"great-ellipse\"\noverlap = \"ordered\"",
    ) + "fov_deg = 45\nnear_m = 0.25\nnote = \"n\"\n\n[mesh]\nboundary_tolerance_m = 7\n\
         cap_step_deg = 2\n\n[levels]\ndeviation_m = [30, 400.5]\n\n[vary]\nboundary_tolerance_m = [1, 2.5]\n\
         cap_step_deg = [0.5, 10]\npositions = true\n";
    let scene = Scene::from_toml(&text, "t.toml", None).expect("valid");
    assert_eq!(scene.body.name(), "moon");
    assert_eq!(scene.edge_rule, EdgeRule::GreatEllipse);
    assert_eq!(scene.overlap, Overlap::Ordered);
    assert_eq!(scene.mesh.boundary_tolerance_m, 7.0);
    assert_eq!(scene.mesh.cap_step_deg, 2.0);
    assert_eq!(scene.levels, LevelChoice::Given(vec![30.0, 400.5]));
    assert_eq!(scene.sweep_boundary_tolerance_m, [1.0, 2.5]);
    assert_eq!(scene.sweep_cap_step_deg, [0.5, 10.0]);
    assert!(scene.sweep_positions);
    let view = &scene.views[0];
    assert_eq!(view.note.as_deref(), Some("n"));
    assert_eq!(
        (view.pose.near_m, view.pose.fov_y_rad),
        (0.25, 45_f64.to_radians())
    );
}

#[test]
fn values_outside_what_is_allowed() {
    let mistakes = r#""wgs84" -> "venus"
    body: found "venus", allowed: wgs84, moon, mars, saturn-like, unit-sphere, asteroid-250m
body = "wgs84" -> body = "wgs84"\nedges = "rhumb"
    edges: found "rhumb", allowed: planar, great-ellipse
name = "test" -> name = "a/b"
    name: found "a/b", allowed: lower-case letters, digits and -
latitude_deg = 20 -> latitude_deg = 91
    views[0].latitude_deg: found 91, allowed: -90 to 90
latitude_deg = 20 -> latitude_deg = nan
    views[0].latitude_deg: found NaN, allowed: -90 to 90
height_m = 5_000 -> height_m = inf
    views[0].height_m: found inf, allowed: greater than 0
pitch_deg = -90 -> pitch_deg = -90\n[mesh]\nboundary_tolerance_m = -1
    mesh.boundary_tolerance_m: found -1, allowed: greater than 0
pitch_deg = -90 -> pitch_deg = -90\n[mesh]\ncap_step_deg = 31
    mesh.cap_step_deg: found 31, allowed: greater than 0, at most 30
pitch_deg = -90 -> pitch_deg = -90\n[levels]\ndeviation_m = [100, 100]
    levels.deviation_m[1]: found 100, allowed: greater than 100
pitch_deg = -90 -> pitch_deg = -90\n[vary]\ncap_step_deg = [10, 31]
    vary.cap_step_deg[1]: found 31, allowed: greater than 0, at most 30
pitch_deg = -90 -> pitch_deg = -90\n[vary]\nboundary_tolerance_m = [10, 0]
    vary.boundary_tolerance_m[1]: found 0, allowed: greater than 0"#;
    assert_all_refused(GOOD, mistakes);
    let no_views = GOOD.split("[[views]]").next().expect("a head");
    for (text, expected) in [
        (
            format!("views = []\n{no_views}"),
            "t.toml: views: found 0 views, allowed: at least 1",
        ),
        (
            format!("{GOOD}{SECOND_VIEW}"),
            "t.toml: views[1].name: found \"a\" again, allowed: a name of its own",
        ),
    ] {
        assert_eq!(message(&text), expected);
    }
}

#[test]
fn region_sources_that_are_not_exactly_one() {
    let mistakes = r#"embedded = "california.geojson" ->
    regions: found none, allowed: exactly one of file, embedded, inline, procedural
california.geojson -> nevada.geojson
    regions.embedded: found "nevada.geojson", allowed: california.geojson, square-10m.geojson, square-200km.geojson, window-west.geojson, window-east.geojson
"california.geojson" -> "california.geojson"\nhow = "buy it"
    regions.how: found a value, allowed: only together with file
"california.geojson" -> "california.geojson"\nsource = { file = "b", sha256 = "" }
    regions.source: found a value, allowed: only together with file"#;
    assert_all_refused(GOOD, mistakes);
    let mistakes = r#"how = "draw it" -> how = "draw it"\nembedded = "california.geojson"
    regions: found file and embedded, allowed: exactly one of file, embedded, inline, procedural
"a.geojson" -> ""
    regions.file: found nothing, allowed: an absolute path, or one from the scene file or the data folder
e3b0 -> E3B0
    regions.sha256: found "E3B0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855", allowed: 64 lower-case hexadecimal digits
how = "draw it" -> how = "draw it"\nsource = { file = "", sha256 = "" }
    regions.source.file: found nothing, allowed: an absolute path, or one from the scene file or the data folder
how = "draw it" -> how = "draw it"\nsource = { file = "b", sha256 = "0" }
    regions.source.sha256: found "0", allowed: 64 lower-case hexadecimal digits"#;
    let of_file = broken("embedded = \"california.geojson\"", FILE_SOURCE);
    assert_all_refused(&of_file, mistakes);
}

#[test]
fn the_published_file_will_do_where_the_trimmed_one_is_not_there() {
    let square = |side: u32| {
        format!(
            "{{\"type\":\"Polygon\",\"coordinates\":[[[0,0],[{side},0],[{side},{side}],[0,0]]]}}"
        )
    };
    let (trimmed, published) = (square(1), square(2));
    let text = broken(
        "embedded = \"california.geojson\"",
        &format!(
            "file = \"a.geojson\"\nsha256 = \"{}\"\n\
             source = {{ file = \"b.json\", sha256 = \"{}\" }}\nhow = \"draw it\"",
            sha256_hex(trimmed.as_bytes()),
            sha256_hex(published.as_bytes())
        ),
    );
    let folder = tempfile::tempdir().expect("temporary folder");
    let write = |name: &str, content: &str| {
        std::fs::write(folder.path().join(name), content).expect("writable");
    };
    // Longitude of the second vertex: which of the files was read.
    let read = || match Scene::from_toml(&text, "t.toml", Some(folder.path())) {
        Ok(scene) => Ok(scene.regions[0].polygons[0].shell.vertices_deg()[1][0].to_string()),
        Err(error) => Err(error.to_string()),
    };
    let error = read().expect_err("neither");
    for part in [
        "a.geojson is not there, and ",
        "b.json is not there; draw it",
    ] {
        assert!(error.contains(part), "{error}");
    }
    write("b.json", &published);
    assert_eq!(read(), Ok("2".to_owned()));
    write("a.geojson", &trimmed);
    assert_eq!(read(), Ok("1".to_owned()));
    // Negative controls: one that has other bytes is not read, whichever it is.
    write("a.geojson", &square(3));
    assert_eq!(read(), Ok("2".to_owned()));
    write("b.json", &trimmed);
    let error = read().expect_err("the trimmed file under the other's name");
    assert_eq!(error.matches("has sha256").count(), 2, "{error}");
    let error = Scene::from_toml(&text, "t.toml", None).expect_err("no folder");
    let error = error.to_string();
    assert_eq!(error.matches("no data folder").count(), 1, "{error}");
    let needs = scene_needs(&text, "t.toml").expect("a scene");
    let paths = |need: &DataNeed| {
        [&need.file, need.source.as_ref()?]
            .map(|f| f.path.clone())
            .into()
    };
    assert_eq!(
        needs
            .iter()
            .map(paths)
            .collect::<Vec<Option<[String; 2]>>>(),
        [Some(["a.geojson".to_owned(), "b.json".to_owned()])]
    );
}

#[test]
fn crossing_rings_stay_as_they_are_unless_the_scene_asks_for_repair() {
    // A bow tie of four vertices, crossing in the middle.
    let bow_tie = br#"{"type":"Polygon","coordinates":[[[0,0],[2,2],[2,0],[0,2],[0,0]]]}"#;
    let sha256: String = Sha256::digest(bow_tie)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let folder = tempfile::tempdir().expect("temporary folder");
    std::fs::write(folder.path().join("a.geojson"), bow_tie).expect("writable");
    let source = format!("file = \"a.geojson\"\nsha256 = \"{sha256}\"\nhow = \"draw it\"");
    let vertices = |repair: &str| {
        let text = broken(
            "embedded = \"california.geojson\"",
            &format!("{source}\n{repair}"),
        );
        Scene::from_toml(&text, "t.toml", Some(folder.path()))
            .map(|scene| scene.regions[0].vertex_count())
            .map_err(|error| error.to_string())
    };
    assert_eq!(vertices(""), Ok(4));
    assert_eq!(vertices("repair = \"even-odd\""), Ok(6));
    assert_eq!(
        vertices("repair = \"buffer\""),
        Err(
            "t.toml: regions.repair: found \"buffer\", allowed: even-odd, union, keep-shells"
                .to_owned()
        )
    );
}

#[test]
fn a_scene_may_read_pole_rings_and_long_edges_otherwise() {
    let source = "embedded = \"california.geojson\"";
    let read = |keys: &str| {
        let text = GOOD.replace(source, &format!("{source}\n{keys}"));
        let scene = Scene::from_toml(&text, "t.toml", None);
        scene
            .map(|scene| scene.regions[0].inside)
            .map_err(|error| error.to_string())
    };
    assert_eq!(read(""), Ok(Inside::Smaller));
    assert_eq!(read("inside = \"left\""), Ok(Inside::Left));
    assert_eq!(read("unwrap = \"shortest\""), Ok(Inside::Smaller));
    assert_eq!(
        read("inside = \"right\""),
        Err("t.toml: regions.inside: found \"right\", allowed: smaller, left".to_owned())
    );
    assert_eq!(
        read("unwrap = \"long\""),
        Err("t.toml: regions.unwrap: found \"long\", allowed: auto, shortest, literal".to_owned())
    );
}

#[test]
fn unknown_keys_missing_keys_and_wrong_types_name_their_line() {
    let cases = [
        (
            broken("description", "summary"),
            "t.toml:2:1: unknown field `summary`, allowed: name, description, body, edges, overlap, regions, surface, \
             mesh, levels, views … and 4 more",
        ),
        (
            broken("description", "descripton"),
            "views … and 4 more; did you mean \"description\"?",
        ),
        (
            broken("pitch_deg = -90", "pitch = -90"),
            "t.toml:17:1: unknown field `pitch`",
        ),
        (broken("height_m = 5_000\n", ""), "missing field `height_m`"),
        (
            broken("height_m = 5_000", "height_m = \"low\""),
            "t.toml:15:12: invalid type",
        ),
        (broken("name = \"test\"", "name = "), "t.toml:1:"),
    ];
    for (text, expected) in cases {
        let found = message(&text);
        assert!(found.contains(expected), "{found}\nlacks {expected}");
        assert!(!found.contains('\n'), "more than a line: {found}");
    }
}

#[test]
fn a_wrong_scene_is_wrong_even_where_its_data_is_missing() {
    let with_file = broken("embedded = \"california.geojson\"", FILE_SOURCE);
    let error = Scene::from_toml(&with_file, "t.toml", None).expect_err("no data");
    assert!(matches!(error, SceneError::DataMissing { .. }), "{error}");
    let wrong = with_file.replace("latitude_deg = 20", "latitude_deg = 91");
    let error = Scene::from_toml(&wrong, "t.toml", None).expect_err("latitude");
    assert!(matches!(error, SceneError::Value { .. }), "{error}");
}

#[test]
fn a_scene_file_is_read_from_disk_and_its_path_is_in_the_message() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("s.toml");
    let missing = Scene::load(&path, None).expect_err("missing");
    assert!(
        matches!(missing, SceneError::Unreadable { .. }),
        "{missing}"
    );
    std::fs::write(&path, GOOD).expect("writable");
    assert_eq!(Scene::load(&path, None).expect("valid").name, "test");
    std::fs::write(&path, broken("= 20", "= 200")).expect("writable");
    let wrong = Scene::load(&path, None).expect_err("latitude");
    assert!(
        wrong.to_string().starts_with(&path.display().to_string()),
        "{wrong}"
    );
}

const TEXTURE: &str = r#"
[texture]
checker = { size = 64, cells = 4 }
share = "each"
alpha = 0.5
fade = { begin_m = 10, end_m = 20 }
placement = { anchor = { longitude_deg = 30, latitude_deg = -45, rotation_deg = 90, width_m = 1000, height_m = 500, outside = "transparent" } }
"#;

fn texture(text: &str) -> SceneTexture {
    let scene = Scene::from_toml(&(GOOD.to_owned() + text), "t.toml", None).expect("valid");
    SceneTexture::clone(&scene.texture.expect("a texture"))
}

#[test]
fn every_setting_of_a_texture_arrives() {
    assert!(
        Scene::from_toml(GOOD, "t.toml", None)
            .expect("valid")
            .texture
            .is_none()
    );
    let found = texture(TEXTURE);
    assert_eq!(found.image.size_px(), [64, 64]);
    assert_eq!(found.image.levels().len(), 7);
    assert_eq!((found.share, found.alpha), (TextureShare::Each, 0.5));
    assert_eq!(found.fade_m, Some([10.0, 20.0]));
    let TexturePlacement::Anchor {
        anchor,
        width_m,
        height_m,
        outside,
    } = found.placement
    else {
        panic!("{:?}", found.placement);
    };
    assert_eq!(
        (width_m, height_m, outside),
        (1000.0, 500.0, Outside::Transparent)
    );
    assert_eq!(
        [
            anchor.longitude_rad,
            anchor.latitude_rad,
            anchor.rotation_rad
        ],
        [30_f64, -45.0, 90.0].map(f64::to_radians)
    );

    let plain = "[texture]\nchecker = { size = 16, cells = 2 }\nplacement = \"extents\"\n";
    let found = texture(plain);
    assert_eq!(found.placement, TexturePlacement::Extents);
    assert_eq!((found.share, found.alpha), (TextureShare::One, 1.0));
    assert!(found.fade_m.is_none());
    let pattern = plain.replace(
        "\"extents\"",
        "{ pattern = { longitude_deg = 1, latitude_deg = 2, texels_per_px = 0.5 } }",
    );
    let TexturePlacement::Pattern { texels_per_px, .. } = texture(&pattern).placement else {
        panic!("no pattern");
    };
    assert_eq!(texels_per_px, 0.5);
}

#[test]
fn wrong_textures_name_the_key_the_value_and_what_is_allowed() {
    let mistakes = r#"checker = { size = 64, cells = 4 }\n ->
    texture: found none, allowed: exactly one of image, checker, hatch
size = 64 -> size = 66
    texture.checker.size: found 66, allowed: a multiple of 4 cells
size = 64 -> size = 16384
    texture.checker.size: found 16384, allowed: 2 to 8192
cells = 4 -> cells = 1
    texture.checker.cells: found 1, allowed: 2 to 64
"each" -> "both"
    texture.share: found "both", allowed: one, each
alpha = 0.5 -> alpha = 1.5
    texture.alpha: found 1.5, allowed: 0 to 1
alpha = 0.5 -> alpha = nan
    texture.alpha: found NaN, allowed: 0 to 1
end_m = 20 -> end_m = 10
    texture.fade.end_m: found 10, allowed: greater than 10
begin_m = 10 -> begin_m = -1
    texture.fade.begin_m: found -1, allowed: 0 or more
latitude_deg = -45 -> latitude_deg = -90
    texture.placement.anchor.latitude_deg: found -90, allowed: -89.9 to 89.9
width_m = 1000 -> width_m = 0
    texture.placement.anchor.width_m: found 0, allowed: greater than 0
"transparent" -> "black"
    texture.placement.anchor.outside: found "black", allowed: repeat, transparent
checker = { size = 64, cells = 4 } -> image = { path = "", sha256 = "0" }
    texture.image.path: found nothing, allowed: an absolute path, or one from the scene file or the data folder
checker = { size = 64, cells = 4 } -> image = { path = "a.png", sha256 = "0" }
    texture.image.sha256: found "0", allowed: 64 lower-case hexadecimal digits"#;
    assert_all_refused(&(GOOD.to_owned() + TEXTURE), mistakes);
    let pattern = "[texture]\nchecker = { size = 16, cells = 2 }\nplacement = { pattern = { \
                   longitude_deg = 1, latitude_deg = 2, texels_per_px = 0 } }\n";
    assert_eq!(
        message(&(GOOD.to_owned() + pattern)),
        "t.toml: texture.placement.pattern.texels_per_px: found 0, allowed: 0.001 to 1000"
    );
    let unknown = TEXTURE.replace("rotation_deg", "turn_deg");
    let text = message(&(GOOD.to_owned() + &unknown));
    assert!(text.contains("unknown field `turn_deg`"), "{text}");
}

#[test]
fn a_picture_is_read_by_its_hash_and_refused_if_it_is_none() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let load = |bytes: &[u8], sha256: &str| {
        std::fs::write(folder.path().join("a.png"), bytes).expect("writable");
        let image = format!("image = {{ path = \"a.png\", sha256 = \"{sha256}\" }}");
        let text = TEXTURE.replace("checker = { size = 64, cells = 4 }", &image);
        Scene::from_toml(&(GOOD.to_owned() + &text), "t.toml", Some(folder.path()))
    };
    let hash = |bytes: &[u8]| -> String {
        let digest = Sha256::digest(bytes);
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    };
    let mut png = std::io::Cursor::new(Vec::new());
    let texels = [255, 0, 0, 0, 0, 255];
    let colour = image::ExtendedColorType::Rgb8;
    image::write_buffer_with_format(&mut png, &texels, 2, 1, colour, image::ImageFormat::Png)
        .expect("a picture");
    let png = png.into_inner();

    let scene = load(&png, &hash(&png)).expect("a picture");
    let texture = scene.texture.expect("a texture");
    assert_eq!(texture.source, "a.png");
    assert_eq!(
        texture.image.levels()[0].rgba,
        [255, 0, 0, 255, 0, 0, 255, 255]
    );
    // Other bytes are no wrong scene, but one whose data is not here.
    let error = load(&png[1..], &hash(&png)).expect_err("other bytes");
    assert!(matches!(error, SceneError::DataMissing { .. }), "{error}");
    // The right bytes of something else are wrong.
    let error = load(b"text", &hash(b"text")).expect_err("no picture");
    assert!(matches!(error, SceneError::Image { .. }), "{error}");
    assert!(
        error.to_string().starts_with("a.png: is no picture"),
        "{error}"
    );
}

#[test]
fn formats_are_swept_through_tolerances_and_not_without() {
    let with = |more: &str| broken("[surface]", &format!("[vary]\n{more}\n[surface]"));
    assert_eq!(
        message(&with("positions = true")),
        "t.toml: vary.positions: found true, allowed: false, or a list vary.boundary_tolerance_m that \
         is not empty"
    );
    let text = with("positions = true\nboundary_tolerance_m = [1]");
    assert!(Scene::from_toml(&text, "t.toml", None).is_ok());
    let text = with("positions = false");
    assert!(Scene::from_toml(&text, "t.toml", None).is_ok());
}

#[test]
fn files_of_a_surface_are_read_by_their_hash_in_their_order() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let hash = |bytes: &[u8]| -> String {
        let digest = Sha256::digest(bytes);
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    };
    let file = |path: &str, sha256: &str| {
        format!("[[surface.files]]\npath = \"{path}\"\nsha256 = \"{sha256}\"\nhow = \"ask\"\n")
    };
    std::fs::write(folder.path().join("a.tif"), b"first").expect("writable");
    std::fs::write(folder.path().join("b.tif"), b"second").expect("writable");
    let both = [
        file("b.tif", &hash(b"second")),
        file("a.tif", &hash(b"first")),
    ]
    .concat();
    let kind = "kind = \"ellipsoid\"\n";
    let load = |files: &str| {
        let text = GOOD.replace(kind, &format!("{kind}rows = 90\n{files}"));
        Scene::from_toml(&text, "t.toml", Some(folder.path()))
    };
    let surface = load(&both).expect("both are there").surface;
    let found: Vec<(&str, &[u8])> = surface
        .files
        .iter()
        .map(|f| (f.path.as_str(), &*f.bytes))
        .collect();
    assert_eq!(found, [("b.tif", &b"second"[..]), ("a.tif", &b"first"[..])]);
    assert!(surface.parameters.contains_key("rows") && surface.parameters.len() == 1);
    // Negative controls: other bytes, no file, half a hash, no path.
    for (files, expected) in [
        (file("a.tif", &hash(b"other")), "has sha256"),
        (file("c.tif", &hash(b"other")), "c.tif is not there; ask"),
    ] {
        let error = load(&files).expect_err("no data");
        assert!(matches!(error, SceneError::DataMissing { .. }), "{error}");
        assert!(error.to_string().contains(expected), "{error}");
    }
    for (files, expected) in [
        (
            file("a.tif", "0"),
            "t.toml: surface.files[0].sha256: found \"0\"",
        ),
        (file("", ""), "t.toml: surface.files[0].path: found nothing"),
    ] {
        let error = load(&files).expect_err("wrong").to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn a_surface_may_have_a_picture() {
    let scene = |text: &str| Scene::from_toml(&(GOOD.to_owned() + text), "t.toml", None);
    assert!(scene("").expect("valid").surface.picture.is_none());
    let found = scene("[surface.picture]\nchecker = { size = 32, cells = 4 }\n");
    let picture = found.expect("valid").surface.picture.expect("a picture");
    assert_eq!(picture.size_px(), [32, 32]);
    let file =
        "[surface.picture]\nimage = { path = \"a.png\", sha256 = \"HASH\", how = \"draw it\" }\n";
    for (text, expected) in [
        (
            "[surface.picture]\n",
            "t.toml: surface.picture: found none, allowed: exactly one of image, checker, hatch",
        ),
        (
            "[surface.picture]\nchecker = { size = 33, cells = 4 }\n",
            "t.toml: surface.picture.checker.size: found 33, allowed: a multiple of 4 cells",
        ),
        (
            file,
            "t.toml: surface.picture.image.sha256: found \"HASH\", allowed: 64 lower-case hexadecimal digits",
        ),
    ] {
        assert_eq!(message(&(GOOD.to_owned() + text)), expected);
    }
    // A file that is not there is missing data, and is listed as needed.
    let file = GOOD.to_owned() + &file.replace("HASH", &"0".repeat(64));
    let missing = Scene::from_toml(&file, "t.toml", None).expect_err("no data");
    assert!(matches!(missing, SceneError::DataMissing { ref file, .. } if file == "a.png"));
    let needs = scene_needs(&file, "t.toml").expect("a scene");
    assert!(needs.iter().any(|need| need.file.path == "a.png"));
}
