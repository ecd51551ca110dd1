// SPDX-License-Identifier: MIT OR Apache-2.0
//! Texture coordinates at points whose longitude and latitude are known because they were put there,
//! footprints against differences, and pictures that must not jump.
//!
//! Points come from the closed forward map (longitude, latitude, height to ECEF); what is under
//! test goes the other way. The affine map of angles that backends read is held against the same
//! points: the two were written from the words of the definition alone.

use super::pictures::input;
use crate::ReferenceBackend;
use crate::backend::ReferenceFrame;
use crate::extent::RegionExtent;
use crate::texture::{SurfacePoint, Texturing};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;
use terrafill_contract::{AddressMode, FillInput, PlannedTexture, TexturePixel};
use terrafill_core::{EdgeRule, Ellipsoid, Geodetic};
use terrafill_fixtures::{Random, data, region};
use terrafill_scene::{
    CameraPose, Outside, Overlap, Scene, SceneTexture, TextureAnchor, TexturePlacement,
};

const FIJI: &str = "[[[[177,-18],[180,-18],[180,-16],[177,-16],[177,-18]]],\
                     [[[-180,-18],[-178,-18],[-178,-17],[-180,-17],[-180,-18]]]]";
const ANTARCTICA: &str = "[[[[-180,-90],[180,-90],[180,-70],[0,-63],[-180,-70],[-180,-90]]]]";
const CAP: &str = "[[[[0,60],[90,65],[180,60],[270,61],[360,60]]]]";
const ZONE: &str =
    "[[[[0,60],[90,65],[180,60],[270,61],[360,60]],[[0,80],[120,81],[240,80],[360,80]]]]";
const BOX: &str = "[[[[10,40],[14,40],[14,43],[10,43],[10,40]]]]";

fn checker(placement: TexturePlacement) -> SceneTexture {
    let text = "name = \"t\"\ndescription = \"t\"\nbody = \"wgs84\"\n[regions]\n\
                embedded = \"california.geojson\"\n[surface]\nkind = \"ellipsoid\"\n[[views]]\n\
                name = \"a\"\nlongitude_deg = 0\nlatitude_deg = 0\nheight_m = 1\nheading_deg = 0\n\
                pitch_deg = 0\n[texture]\nchecker = { size = 256, cells = 16 }\n\
                placement = \"extents\"\n";
    let scene = Scene::from_toml(text, "t.toml", None).expect("valid");
    let texture = SceneTexture::clone(&scene.texture.expect("a texture"));
    SceneTexture {
        placement,
        ..texture
    }
}

fn anchor(longitude: f64, latitude: f64, rotation: f64) -> TextureAnchor {
    TextureAnchor {
        longitude_rad: longitude.to_radians(),
        latitude_rad: latitude.to_radians(),
        rotation_rad: rotation.to_radians(),
    }
}

fn placed(anchor: TextureAnchor, width_m: f64, height_m: f64) -> TexturePlacement {
    TexturePlacement::Anchor {
        anchor,
        width_m,
        height_m,
        outside: Outside::Repeat,
    }
}

/// A view of a textured scene of one region.
struct Shot {
    body: Ellipsoid,
    coordinates: &'static str,
    rule: EdgeRule,
    placement: TexturePlacement,
    /// Longitude, latitude, height in metres, pitch.
    eye: [f64; 4],
    size: u32,
}

impl Shot {
    fn of(coordinates: &'static str, placement: TexturePlacement, eye: [f64; 4]) -> Self {
        Self {
            body: Ellipsoid::WGS84,
            coordinates,
            rule: EdgeRule::Planar,
            placement,
            eye,
            size: 64,
        }
    }

    fn input(&self) -> FillInput {
        let [longitude, latitude, height_m, pitch_deg] = self.eye;
        let pose = CameraPose {
            eye: Geodetic::from_degrees(longitude, latitude, height_m),
            heading_rad: 0.0,
            pitch_rad: pitch_deg.to_radians(),
            fov_y_rad: 50_f64.to_radians(),
            near_m: height_m * 1e-3,
        };
        let mut input = input(self.body, &pose, self.size, 90);
        input.scene.edge_rule = self.rule;
        input.scene.overlap = Overlap::Disjoint;
        input.scene.regions = [region(self.coordinates)].into();
        input.scene.texture = Some(Arc::new(checker(self.placement)));
        input
    }

    fn judged(&self) -> ReferenceFrame {
        let judged = ReferenceBackend::textured().judge(&self.input());
        judged.expect("regions that can be judged")
    }
}

fn pixels(judged: &ReferenceFrame) -> &[Option<TexturePixel>] {
    &judged.frame.texture.as_ref().expect("textured").pixels
}

const UP: [f64; 4] = [12.0, 41.5, 4e5, -90.0];

fn uv_at(input: &FillInput, [longitude, latitude, height]: [f64; 3]) -> [f64; 2] {
    let texturing = Texturing::new(input).expect("a texture");
    let place = Geodetic::from_degrees(longitude, latitude, height);
    let ecef = input.scene.body.geodetic_to_ecef(place);
    let point = SurfacePoint::new(&input.scene.body, ecef);
    texturing.at(0, &point).uv
}

fn distance([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    (a - c).abs().max((b - d).abs())
}

#[test]
fn a_point_put_at_a_longitude_and_latitude_is_found_there() {
    let mut random = Random(7);
    for body in Ellipsoid::ALL {
        for _ in 0..500 {
            let [longitude, latitude] = random.place();
            // From a share of the depth at which normals begin to cross to far outside.
            let height = (random.share() * 3.0 - 0.3) * body.smallest_curvature_radius_m();
            let place = Geodetic::from_degrees(longitude, latitude, height);
            let found = SurfacePoint::new(&body, body.geodetic_to_ecef(place));
            let error = (found.latitude - place.latitude_rad).abs();
            assert!(error < 1e-12, "{} {place:?}: {error}", body.name());
            let east = (found.longitude - place.longitude_rad) * latitude.to_radians().cos();
            assert!(east.abs() < 1e-12, "{} {place:?}", body.name());
        }
    }
    // Negative control: geocentric latitude is a sixth of a degree off.
    let ecef = Ellipsoid::WGS84.geodetic_to_ecef(Geodetic::from_degrees(0.0, 45.0, 0.0));
    let found = SurfacePoint::new(&Ellipsoid::WGS84, ecef);
    assert!((found.latitude - ecef.z.atan2(ecef.x)).abs() > 3e-3);
}

#[test]
fn extents_put_the_corners_of_the_picture_at_those_of_the_region() {
    let box_ = Shot::of(BOX, TexturePlacement::Extents, UP).input();
    for ([longitude, latitude], expected) in [
        ([10.0, 43.0], [0.0, 0.0]),
        ([14.0, 43.0], [1.0, 0.0]),
        ([10.0, 40.0], [0.0, 1.0]),
        ([11.0, 42.25], [0.25, 0.25]),
    ] {
        for height in [-11e3, 0.0, 9e3] {
            let found = uv_at(&box_, [longitude, latitude, height]);
            assert!(distance(found, expected) < 1e-12, "{found:?} {expected:?}");
        }
    }
    // Across the antimeridian: 177 … 182.
    let fiji = Shot::of(FIJI, TexturePlacement::Extents, UP).input();
    for (longitude, u) in [(177.0, 0.0), (179.5, 0.5), (-180.0, 0.6), (-178.0, 1.0)] {
        let found = uv_at(&fiji, [longitude, -17.0, 0.0]);
        assert!(distance(found, [u, 0.5]) < 1e-12, "{longitude}: {found:?}");
    }
    // Over a pole: all longitudes, down to it; there is nothing that is no number on the axis.
    let pole = Shot::of(ANTARCTICA, TexturePlacement::Extents, UP).input();
    let found = uv_at(&pole, [90.0, -81.0, 0.0]);
    assert!(distance(found, [0.75, 18.0 / 27.0]) < 1e-12, "{found:?}");
    let found = uv_at(&pole, [0.0, -90.0, 0.0]);
    assert!(distance(found, [0.5, 1.0]) < 1e-12, "{found:?}");
}

#[test]
fn extents_agree_with_those_that_backends_are_given() {
    let pieces = "[[[[170,0],[200,0],[200,1],[170,1],[170,0]]],\
                   [[[-175,0],[-150,0],[-150,1],[-175,1],[-175,0]]],\
                   [[[20,40],[60,40],[60,62],[20,62],[20,40]]]]";
    let mut compared = 0;
    for coordinates in [FIJI, ANTARCTICA, CAP, ZONE, BOX, pieces] {
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let shot = Shot {
                rule,
                ..Shot::of(coordinates, TexturePlacement::Extents, UP)
            };
            let input = shot.input();
            let texturing = Texturing::new(&input).expect("a texture");
            let own = *texturing.extent(0);
            let planned = PlannedTexture::of_scene(&input.scene);
            let given = planned[0].extent_rad;
            let own = [own.west, own.south, own.east, own.north];
            for i in 0..4 {
                let error = (own[i] - given[i]).abs();
                assert!(error < 1e-12, "{coordinates} {rule:?}: {own:?} {given:?}");
            }
            assert_eq!(texturing.address(0), planned[0].address);
            compared += 1;
        }
    }
    assert_eq!(compared, 12);
    let zone = Shot::of(ZONE, TexturePlacement::Extents, UP).input();
    let north = Texturing::new(&zone).expect("a texture").extent(0).north;
    assert!((north - 81_f64.to_radians()).abs() < 1e-15, "{north}");
}

#[test]
fn extents_of_islands_agree_with_those_that_backends_are_given() {
    assert_extents_agree(&["planet-134"], None);
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-50m, us-10m"]
fn extents_of_real_countries_agree_with_those_that_backends_are_given() {
    let names = ["countries-110m", "countries-50m", "us-states"];
    assert_extents_agree(&names, Some(&data::folder()));
}

fn assert_extents_agree(names: &[&str], data_dir: Option<&Path>) {
    for &name in names {
        let scene = Scene::shipped(name, data_dir).expect("a scene");
        let texture = checker(TexturePlacement::Extents);
        let body = scene.body;
        for region in scene.regions.iter() {
            let own = RegionExtent::new(region, scene.edge_rule, &scene.body);
            let given = PlannedTexture::new(&texture, region, scene.edge_rule, &body).extent_rad;
            let own = [own.west, own.south, own.east, own.north];
            let error = (0..4).map(|i| (own[i] - given[i]).abs());
            assert!(
                error.fold(0.0, f64::max) < 1e-12,
                "{name}, {}: {own:?} {given:?}",
                region.name
            );
        }
        let extent_deg = |name: &str| {
            let region = scene.regions.iter().find(|region| region.name == name);
            let extent =
                RegionExtent::new(region.expect("in the file"), scene.edge_rule, &scene.body);
            [extent.west, extent.south, extent.east, extent.north].map(f64::to_degrees)
        };
        if name == "countries-110m" {
            // From Kaliningrad to Cape Dezhnev, and all round from the pole.
            let [west, _, east, _] = extent_deg("Russia");
            assert!((19.0..21.0).contains(&west) && (190.0..191.0).contains(&east));
            let [west, _, east, _] = extent_deg("Fiji");
            assert!((177.0..177.5).contains(&west) && (180.0..180.5).contains(&east));
            let [west, south, east, _] = extent_deg("Antarctica");
            assert_eq!([west, south, east], [-180.0, -90.0, 180.0]);
        }
    }
}

#[test]
fn placements_agree_with_the_affine_map_that_backends_are_given() {
    let pattern = TexturePlacement::Pattern {
        anchor: anchor(-179.0, -20.0, 30.0),
        texels_per_px: 1.0,
    };
    let mut random = Random(3);
    for placement in [
        TexturePlacement::Extents,
        placed(anchor(12.0, 41.0, 0.0), 3e5, 2e5),
        placed(anchor(-179.0, -20.0, 200.0), 1e6, 5e5),
        pattern,
    ] {
        for body in [Ellipsoid::WGS84, Ellipsoid::SATURN_LIKE] {
            for coordinates in [FIJI, BOX, CAP] {
                let shot = Shot {
                    body,
                    ..Shot::of(coordinates, placement, UP)
                };
                let input = shot.input();
                let planned = PlannedTexture::of_scene(&input.scene)[0];
                let [lon, lat] = planned.anchor_lon_lat_rad.map(f64::to_degrees);
                for _ in 0..50 {
                    let step = [random.share() - 0.5, random.share() - 0.5].map(|x| x * 5.0);
                    let found = uv_at(&input, [lon + step[0], lat + step[1], 0.0]);
                    let [dlon, dlat] = step.map(f64::to_radians);
                    let given = planned.uv(dlon, dlat);
                    let scale = 1.0 + found[0].abs() + found[1].abs();
                    let error = distance(found, given);
                    assert!(error < 1e-12 * scale, "{placement:?}: {found:?} {given:?}");
                    // Negative control: longitude and latitude swapped.
                    assert!(distance(found, planned.uv(dlat, dlon)) > 1e-9);
                }
            }
        }
    }
}

#[test]
fn an_anchors_picture_spans_its_metres_and_turns_clockwise() {
    let body = Ellipsoid::WGS84;
    // Degrees of 1 km along the meridian and the parallel at 45°, from the published radii
    // M = 6,367,381.816 m and N = 6,388,838.290 m (NIMA TR8350.2).
    let north = (1000.0_f64 / 6_367_381.816).to_degrees();
    let east = (1000.0 / (6_388_838.290 * 0.5_f64.sqrt())).to_degrees();
    let at = |rotation: f64, dx: f64, dy: f64| {
        let placement = placed(anchor(12.0, 45.0, rotation), 4000.0, 8000.0);
        let shot = Shot {
            body,
            ..Shot::of(BOX, placement, UP)
        };
        uv_at(&shot.input(), [12.0 + dx * east, 45.0 + dy * north, 0.0])
    };
    for (found, expected) in [
        (at(0.0, 0.0, 0.0), [0.5, 0.5]),
        (at(0.0, 1.0, 0.0), [0.75, 0.5]),
        (at(0.0, 0.0, 1.0), [0.5, 0.375]),
        (at(90.0, 1.0, 0.0), [0.5, 0.375]),
        (at(90.0, 0.0, 1.0), [0.25, 0.5]),
        (at(180.0, 1.0, 1.0), [0.25, 0.625]),
    ] {
        assert!(distance(found, expected) < 1e-9, "{found:?} {expected:?}");
    }
}

/// Texture coordinates where a ray meets the plane through `point` across `normal`.
fn uv_on_plane(
    texturing: &Texturing<'_>,
    input: &FillInput,
    point: DVec3,
    normal: DVec3,
    direction: DVec3,
) -> [f64; 2] {
    let eye = input.camera.eye_ecef;
    let t = normal.dot(point - eye) / normal.dot(direction);
    let met = SurfacePoint::new(&input.scene.body, eye + direction * t);
    texturing.at(0, &met).uv
}

#[test]
fn footprints_are_the_derivatives_of_the_coordinates() {
    let placements = [
        TexturePlacement::Extents,
        placed(anchor(-179.0, -20.0, 200.0), 1e6, 5e5),
    ];
    let eyes = [
        (FIJI, [179.9, -17.0, 2e5, -90.0]),
        (FIJI, [179.0, -25.0, 2e4, -8.0]),
        (ANTARCTICA, [30.0, -89.0, 3e5, -70.0]),
        (BOX, [12.0, 41.0, 3e6, -90.0]),
    ];
    let mut checked = 0;
    for (coordinates, eye) in eyes {
        for placement in placements {
            let input = Shot::of(coordinates, placement, eye).input();
            let texturing = Texturing::new(&input).expect("a texture");
            let body = input.scene.body;
            for (column, row) in [(10, 40), (32, 32), (50, 60), (3, 20)] {
                let direction = |column: f64, row: f64| {
                    // The pixels' directions are linear in column and row.
                    let origin = input.camera.pixel_direction_ecef(input.size, 0, 0);
                    let right = input.camera.pixel_direction_ecef(input.size, 1, 0) - origin;
                    let down = input.camera.pixel_direction_ecef(input.size, 0, 1) - origin;
                    origin + right * column + down * row
                };
                let ray = direction(f64::from(column), f64::from(row));
                // A point where the ray comes down to the equator's radius at most: any will do.
                let Some(depth) = depth_of_sphere(&input, ray) else {
                    continue;
                };
                let point = input.camera.eye_ecef + ray * depth;
                let place = body.ecef_to_geodetic(point);
                let normal = body.geodetic_surface_normal(place.longitude_rad, place.latitude_rad);
                let on_surface = SurfacePoint::new(&body, point);
                let coordinates = texturing.at(0, &on_surface);
                let found = texturing.footprints(&on_surface, &coordinates, ray, depth);
                let step = 1e-4;
                for (k, shift) in [(0, [step, 0.0]), (1, [0.0, step])] {
                    let [x, y] = [f64::from(column), f64::from(row)];
                    let at = |sign: f64| {
                        let ray = direction(x + sign * shift[0], y + sign * shift[1]);
                        uv_on_plane(&texturing, &input, point, normal, ray)
                    };
                    let (before, after) = (at(-1.0), at(1.0));
                    for i in 0..2 {
                        let expected = (after[i] - before[i]) / (2.0 * step) * 256.0;
                        let length = found[k][0].hypot(found[k][1]);
                        let error = (found[k][i] - expected).abs();
                        assert!(error < 1e-5 * length, "{found:?} {expected} {placement:?}");
                    }
                }
                checked += 1;
            }
        }
    }
    assert!(checked >= 16, "{checked}");
}

/// Depth at which a ray meets a sphere a little inside the body.
fn depth_of_sphere(input: &FillInput, direction: DVec3) -> Option<f64> {
    let radius = input.scene.body.polar_radius_m() * 0.999;
    let eye = input.camera.eye_ecef;
    let (a, b) = (direction.length_squared(), eye.dot(direction));
    let root = b * b - a * (eye.length_squared() - radius * radius);
    (root > 0.0).then(|| (-b - root.sqrt()) / a)
}

/// Largest change of the coordinates in texels from a pixel to its right and lower neighbours, over
/// the footprint there, and of the level of detail; pixels of one region only.
fn largest_jump(judged: &ReferenceFrame) -> [f64; 2] {
    let pixels = pixels(judged);
    let width = judged.frame.size.width as usize;
    let repeats = judged.frame.texture.as_ref().map(|t| t.address[0]);
    let mut jump = [0.0_f64; 2];
    for index in 0..pixels.len() - width {
        for next in [index + 1, index + width] {
            let (Some(a), Some(b)) = (pixels[index], pixels[next]) else {
                continue;
            };
            if next == index + 1 && next.is_multiple_of(width) {
                continue;
            }
            let mut change = [0, 1].map(|i| b.uv[i] - a.uv[i]);
            if repeats.is_some_and(|[u, _]| u == AddressMode::Repeat) {
                change[0] -= change[0].round();
            }
            let texels = change.map(|c| c * 256.0);
            let footprint = a.footprint_texels.max(b.footprint_texels);
            jump[0] = jump[0].max(texels[0].hypot(texels[1]) / footprint);
            jump[1] = jump[1].max((a.level - b.level).abs());
        }
    }
    jump
}

#[test]
fn nothing_jumps_at_the_antimeridian_or_at_a_pole() {
    let fiji = Shot::of(FIJI, TexturePlacement::Extents, [180.0, -17.0, 3e5, -90.0]).judged();
    let [uv, level] = largest_jump(&fiji);
    assert!(uv < 1.05 && level < 0.1, "{uv} {level}");
    // Across −180 … 180 the picture is all round: its left edge meets its right one.
    let pole = Shot::of(CAP, TexturePlacement::Extents, [180.0, 75.0, 5e5, -90.0]).judged();
    let [uv, level] = largest_jump(&pole);
    assert!(uv < 1.05 && level < 0.3, "{uv} {level}");
    // Negative control: with longitudes as they come the two sides are a picture apart.
    let mut broken = fiji;
    let texture = broken.frame.texture.as_mut().expect("textured");
    for pixel in texture.pixels.iter_mut().flatten() {
        if pixel.uv[0] > 0.6 {
            pixel.uv[0] -= 1.0;
        }
    }
    assert!(largest_jump(&broken)[0] > 10.0);
}

#[test]
fn over_a_pole_everything_is_a_number() {
    for (coordinates, latitude) in [(ANTARCTICA, -90.0), (CAP, 90.0)] {
        for placement in [
            TexturePlacement::Extents,
            placed(anchor(0.0, latitude * 0.9, 45.0), 1e6, 1e6),
        ] {
            let judged = Shot {
                // Odd, so that the middle pixel looks at the pole itself.
                size: 65,
                ..Shot::of(coordinates, placement, [0.0, latitude, 3e5, -90.0])
            }
            .judged();
            assert_eq!(judged.frame.non_finite, 0);
            let found = pixels(&judged).iter().flatten();
            assert!(found.clone().count() > 4000);
            assert!(found.clone().all(TexturePixel::is_finite));
            assert!(
                found
                    .clone()
                    .all(|pixel| (0.0..=8.0).contains(&pixel.level))
            );
        }
    }
}

#[test]
fn a_moving_region_uncovers_the_picture_and_does_not_move_it() {
    const MOVED: &str = "[[[[11,40.5],[15,40.5],[15,43.5],[11,43.5],[11,40.5]]]]";
    let apart = |placement: TexturePlacement| {
        let [before, after] = [BOX, MOVED].map(|c| Shot::of(c, placement, UP).judged());
        let both = pixels(&before).iter().zip(pixels(&after));
        let errors: Vec<f64> = both
            .filter_map(|(a, b)| Some(distance(a.as_ref()?.uv, b.as_ref()?.uv)))
            .collect();
        assert!(errors.len() > 500, "{}", errors.len());
        errors.into_iter().fold(0.0, f64::max)
    };
    let anchored = apart(placed(anchor(11.0, 42.0, 20.0), 2e5, 2e5));
    assert!(anchored < 1e-12, "{anchored}");
    // Negative control: by extents the picture goes along.
    assert!(apart(TexturePlacement::Extents) > 0.1);
}

/// Largest change of a channel when the eye moves by a millionth across the distance at which a
/// pattern takes another level; `blends` off for the control.
fn pattern_jump(blends: bool) -> f64 {
    let placement = TexturePlacement::Pattern {
        anchor: anchor(12.0, 41.5, 10.0),
        texels_per_px: 0.7,
    };
    let input = Shot::of(BOX, placement, UP).input();
    let texturing = Texturing::new(&input).expect("a texture");
    let mut jump = 0.0_f64;
    for (column, row) in [(5, 9), (32, 32), (60, 31)] {
        let direction = input.camera.pixel_direction_ecef(input.size, column, row);
        let mut pixel = texturing.pixel(0, direction, 4e5);
        let whole = pixel.pattern_level.round();
        let mut at = |level: f64| {
            pixel.pattern_level = if blends { level } else { level.floor() };
            texturing.colour(0, &pixel)
        };
        let (below, above) = (at(whole - 1e-7), at(whole + 1e-7));
        for i in 0..3 {
            jump = jump.max((below[i] - above[i]).abs());
        }
    }
    jump
}

#[test]
fn a_pattern_does_not_jump_where_it_changes_its_level() {
    let jump = pattern_jump(true);
    assert!(jump < 1e-6, "{jump}");
    // Negative control: the nearest level alone.
    assert!(pattern_jump(false) > 0.05);
}

#[test]
fn a_pattern_keeps_its_texels_per_pixel_from_any_height() {
    let placement = TexturePlacement::Pattern {
        anchor: anchor(12.0, 41.5, 10.0),
        texels_per_px: 0.7,
    };
    for height in [1e3, 3.7e4, 2e5, 2e6] {
        let eye = [12.0, 41.5, height, -90.0];
        let judged = Shot::of(BOX, placement, eye).judged();
        let middle = pixels(&judged)[32 * 64 + 32].expect("inside");
        // In texels of 2ᵏ metres a pixel straight below spans what was asked for.
        let spans = middle.footprint_texels * (-middle.pattern_level).exp2();
        assert!((spans / 0.7 - 1.0).abs() < 0.01, "{height}: {spans}");
    }
}

#[test]
fn a_fill_fades_with_the_distance_of_the_pixel() {
    let shot = Shot::of(BOX, TexturePlacement::Extents, UP);
    let mut input = shot.input();
    let mut texture = checker(TexturePlacement::Extents);
    texture.alpha = 0.5;
    texture.fade_m = Some([100.0, 300.0]);
    input.scene.texture = Some(Arc::new(texture));
    let texturing = Texturing::new(&input).expect("a texture");
    let direction = input.camera.pixel_direction_ecef(input.size, 32, 32);
    let pixel = texturing.pixel(0, direction, 4e5);
    let alpha = |distance_m: f64| {
        texturing.colour(
            0,
            &TexturePixel {
                distance_m,
                ..pixel
            },
        )[3]
    };
    assert_eq!(
        [50.0, 150.0, 200.0, 300.0, 1e9].map(alpha),
        [0.5, 0.375, 0.25, 0.0, 0.0]
    );
}

#[test]
fn a_plain_frame_has_no_texture_and_a_textured_one_the_same_ids() {
    let input = Shot::of(BOX, TexturePlacement::Extents, UP).input();
    let plain = ReferenceBackend::new().judge(&input).expect("judged");
    let textured = ReferenceBackend::textured().judge(&input).expect("judged");
    assert!(plain.frame.texture.is_none() && plain.picture.is_none());
    assert_eq!(plain.frame.ids, textured.frame.ids);
    let owned = textured.frame.ids.iter().map(|&id| id != 0);
    let has_texture = pixels(&textured).iter().map(Option::is_some);
    assert!(owned.eq(has_texture));
    let picture = textured.picture.expect("a picture");
    let background = terrafill_contract::paint(&plain.frame);
    let pairs = picture.chunks(3).zip(background.chunks(3));
    for ((textured, plain), &id) in pairs.zip(&plain.frame.ids) {
        assert_eq!(textured == plain, id == 0, "{textured:?} {plain:?}");
    }
}
