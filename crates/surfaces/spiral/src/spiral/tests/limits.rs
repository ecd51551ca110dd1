// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a view's mesh ends, and what is refused.

use super::*;

#[test]
fn extremes_are_finite_and_an_eye_on_or_below_the_ground_is_refused() {
    let mut count = 0;
    for body in Ellipsoid::ALL {
        for n in [3, 36] {
            for height in [1.7, 1.7 / 6.4e6, 1e8, 1e8 / 6.4e6, 1e3, 1.0] {
                for [longitude, latitude] in
                    [[0.0, 90.0], [180.0, -90.0], [180.0, 0.0], [15.0, 20.0]]
                {
                    for (pitch, fov_deg, size) in [
                        (-90.0, 60.0, [64, 64]),
                        (0.0, 170.0, [1, 1]),
                        (90.0, 1.0, [16_384, 1]),
                    ] {
                        let mut camera = camera(&body, [longitude, latitude, height], pitch);
                        camera.fov_y_rad = f64::to_radians(fov_deg);
                        let size = ImageSize::new(size[0], size[1]);
                        let spiral = Spiral::new(&body, n);
                        let frame = spiral.frame(&camera, size).expect("above");
                        let vertices = frame.vertices_rte.iter().flatten();
                        assert!(
                            vertices.copied().all(f32::is_finite),
                            "{} {n} {height}",
                            body.name()
                        );
                        let HeightRange {
                            lowest_m,
                            highest_m,
                        } = frame.heights;
                        assert!(lowest_m.is_finite() && highest_m.is_finite());
                        assert!(frame.triangles.len() >= n as usize);
                        count += 1;
                    }
                }
            }
        }
    }
    assert_eq!(count, 864);
    let body = Ellipsoid::WGS84;
    for (height_m, is_above) in [(1e-6, true), (0.0, false), (-1.0, false), (-7e6, false)] {
        let frame = Spiral::new(&body, 36).frame(&camera(&body, [0.0, 0.0, height_m], 0.0), SIZE);
        assert_eq!(frame.is_ok(), is_above, "{height_m}");
        if let Err(error) = frame {
            assert!(
                error.to_string().contains("above the spiral surface"),
                "{error}"
            );
        }
    }
    let hilly = Spiral::new(&body, 36).with_elevation(grown());
    let ground = hilly.ground_m(camera(&body, [10.5, 46.5, 0.0], 0.0).eye_ecef);
    for (over, is_above) in [(2.0, true), (-2.0, false)] {
        let camera = camera(&body, [10.5, 46.5, ground + over], 0.0);
        assert_eq!(hilly.frame(&camera, SIZE).is_ok(), is_above, "{ground}");
    }
}

#[test]
fn the_outer_radius_is_the_horizon_or_the_pictures_corner() {
    let body = sphere();
    let spiral = Spiral {
        rim: Rim::Horizon,
        ..Spiral::new(&body, 36)
    };
    let outer = |height_m: f64, pitch: f64| {
        let camera = camera(&body, [10.0, 20.0, height_m], pitch);
        spiral.limits(&camera, SIZE).expect("above").outer
    };
    for height_m in [1.7, 2e3, 8e6] {
        let horizon = (1.0 + height_m / RADIUS_M).recip().acos();
        assert!(
            (outer(height_m, -2.0) / horizon - 1.0).abs() < 1e-9,
            "{height_m}"
        );
    }
    // Looking down from 2 km, the corner of the picture is 2 km · tan 60° · √(1 + (16/9)²) / √3 away.
    let corner_m = 2e3 * 30_f64.to_radians().tan() * (16.0_f64 / 9.0).hypot(1.0);
    assert!((outer(2e3, -90.0) * RADIUS_M / corner_m - 1.0).abs() < 1e-3);
    // Octaves with a fan of 50 pixels, from the sheet.
    for (height_m, expected) in [
        (1.7, 15.6),
        (10.0, 14.4),
        (100.0, 12.7),
        (2e3, 10.5),
        (1e4, 9.4),
        (1e5, 7.7),
        (1.161e6, 5.9),
        (8e6, 4.1),
    ] {
        let camera = camera(&body, [10.0, 20.0, height_m], 0.0);
        let limits = spiral.limits(&camera, SIZE).expect("above");
        let found = (limits.outer / limits.inner).log2();
        assert!((found - expected).abs() < 0.06, "{height_m} {found}");
    }
    // Summits are seen behind the horizon.
    let hilly = spiral.clone().with_elevation(grown());
    let summit = (RADIUS_M / (RADIUS_M + 9e3)).acos();
    let camera = camera(&body, [10.0, 20.0, 1e4], -2.0);
    let found = hilly.limits(&camera, SIZE).expect("above").outer;
    assert!(found > outer(1e4, -2.0) + summit, "{found}");
}

fn opened(surface: &str) -> Result<Arc<dyn Surface>, String> {
    let text = format!(
        "name = \"t\"\ndescription = \"d\"\nbody = \"wgs84\"\n\
         [regions]\nembedded = \"california.geojson\"\n[surface]\nkind = \"spiral\"\n{surface}\n\
         [[views]]\nname = \"a\"\nlongitude_deg = 0\nlatitude_deg = 0\nheight_m = 1\n\
         heading_deg = 0\npitch_deg = 0\n"
    );
    let scene = Scene::from_toml(&text, "t.toml", None).map_err(|error| error.to_string())?;
    open_surface(&[&EllipsoidKind, &SpiralKind], &scene).map_err(|error| error.to_string())
}

#[test]
fn a_scene_names_its_spiral_and_what_is_wrong_is_named() {
    let all = "n = 24\nstd = 4\nlaw = \"quadratic\"\nfan_px = 20\nindices = \"published\"\n\
               rim = \"horizon\"\nframe = \"lonlat\"\ntrig = \"5/6\"\nprecision = \"f32\"\n\
               step_deg = 7\nbase = \"relief\"\nseed = 4";
    for text in ["", all] {
        assert_eq!(opened(text).expect(text).kind(), "spiral");
    }
    for (text, expected) in [
        ("n = 2", "t.toml: surface.n: found 2, allowed: 3 to 288"),
        (
            "std = 0",
            "t.toml: surface.std: found 0, allowed: 0.3 to 64",
        ),
        (
            "law = \"cubic\"",
            "t.toml: surface.law: found \"cubic\", allowed: exponential, published, quadratic, \
             equal-area, linear",
        ),
        (
            "frame = \"global\"",
            "t.toml: surface.frame: found \"global\", allowed: local-sin2, lonlat, hemisphere, local; \
             did you mean \"local\"?",
        ),
        (
            "trig = \"2/3\"",
            "t.toml: surface.trig: found \"2/3\", allowed: native, 1/2, 3/2, 3/4, 5/4, 5/6, 7/8, 9/10; \
             did you mean \"3/2\"?",
        ),
        (
            "seed = 4",
            "t.toml: surface.seed: found 4, allowed: only the keys kind, n, step_deg, std, law, fan_px, \
             indices, rim, frame, trig … and 2 more; did you mean \"std\"?",
        ),
    ] {
        assert_eq!(opened(text).expect_err(text), expected);
    }
}
