// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a textured fill of one region needs, and where the texels of a drawn frame came from.
//!
//! Every placement of a picture is affine in longitude and latitude measured from a point of the
//! region, so backends differ in how they find those two angles and in nothing else. Radians and
//! metres, `f64`; whoever rounds to `f32` does so after subtracting. The reference reads the scene's
//! placement itself and never the affine map made here.
//!
//! Colours: texels are decoded from sRGB, filtered in linear light and encoded again; then they are
//! blended over what the target holds as it stands, by the texel's alpha times the scene's times what
//! the distance leaves of it.

use crate::PreparedScene;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use terrafill_core::{EdgeRule, Ellipsoid, Polygon, Region, Ring};
use terrafill_scene::{Outside, SceneTexture, TextureAnchor, TexturePlacement, TextureShare};

/// Widths from here on are the whole way round: what a sum of longitudes in degrees loses.
const FULL_TURN_RAD: f64 = TAU - 1e-9;

/// What a sampler does beyond the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AddressMode {
    /// The picture again.
    Repeat,
    /// The texel at the edge.
    ClampToEdge,
    /// The texel at the edge where filtering needs it; nothing where the coordinate is below 0 or
    /// above 1.
    Transparent,
}

/// A picture whose size on the ground follows the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pattern {
    /// Texels that a pixel spans. A pixel at a distance spans `distance · 2 tan(fov / 2) / rows`
    /// metres and a texel 2ᵏ, which gives `k`; the map of angles gives the coordinates for `k = 0`,
    /// to be multiplied by `2^−⌊k⌋` and by half of that, and blended by the fraction of `k`.
    pub texels_per_px: f64,
}

/// The texture of one region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedTexture {
    /// Which copy of the scene's picture: 0 where all regions share one, the region's index else.
    pub image: usize,
    /// Where the angles are measured from: the middle of the region's extent, geodetic.
    pub anchor_lon_lat_rad: [f64; 2],
    /// West, south, east and north; longitudes unwrapped, `west ≤ λ ≤ east ≤ west + 2π`.
    pub extent_rad: [f64; 4],
    /// Rows give `u` and `v`; columns multiply `λ − λ0` (within ±π), `φ − φ0` and 1.
    pub uv_from_angles: [[f64; 3]; 2],
    /// Beyond the picture, in `u` and in `v`.
    pub address: [AddressMode; 2],
    /// Set where the size on the ground follows the view.
    pub pattern: Option<Pattern>,
    /// Distances from the eye at which the fill begins to fade and where it is gone, metres.
    pub fade_m: Option<[f64; 2]>,
    /// Opacity, times the picture's own.
    pub alpha: f64,
}

impl PlannedTexture {
    /// How `texture` lies on `region`.
    #[must_use]
    pub fn new(
        texture: &SceneTexture,
        region: &Region,
        edge_rule: EdgeRule,
        body: &Ellipsoid,
    ) -> Self {
        let extent_rad = region_extent_rad(region, edge_rule, body);
        let [west, south, east, north] = extent_rad;
        let middle = [(west + east) / 2.0, (south + north) / 2.0];
        let uv_from_angles = match texture.placement {
            TexturePlacement::Extents => [
                [1.0 / (east - west), 0.0, 0.5],
                [0.0, -1.0 / (north - south), 0.5],
            ],
            TexturePlacement::Anchor {
                anchor,
                width_m,
                height_m,
                ..
            } => anchored(body, &anchor, [width_m, height_m], middle),
            TexturePlacement::Pattern { anchor, .. } => {
                let size_m = texture.image.size_px().map(f64::from);
                anchored(body, &anchor, size_m, middle)
            }
        };
        Self {
            image: match texture.share {
                TextureShare::One => 0,
                TextureShare::Each => region.index,
            },
            anchor_lon_lat_rad: middle,
            extent_rad,
            uv_from_angles,
            address: address_modes(&texture.placement, east - west),
            pattern: match texture.placement {
                TexturePlacement::Pattern { texels_per_px, .. } => Some(Pattern { texels_per_px }),
                _ => None,
            },
            fade_m: texture.fade_m,
            alpha: texture.alpha,
        }
    }

    /// The textures of all regions of `scene`, in their order, which also numbers the copies of the
    /// picture where each region has one; empty where the scene has no texture.
    #[must_use]
    pub fn of_scene(scene: &PreparedScene) -> Vec<Self> {
        let Some(texture) = &scene.texture else {
            return Vec::new();
        };
        let plan = |(place, region)| {
            let planned = Self::new(texture, region, scene.edge_rule, &scene.body);
            match texture.share {
                TextureShare::One => planned,
                TextureShare::Each => Self {
                    image: place,
                    ..planned
                },
            }
        };
        scene.regions.iter().enumerate().map(plan).collect()
    }

    /// Texture coordinates at angles from [`PlannedTexture::anchor_lon_lat_rad`]; of a pattern, those
    /// for `k = 0`.
    #[must_use]
    pub fn uv(&self, dlon_rad: f64, dlat_rad: f64) -> [f64; 2] {
        self.uv_from_angles
            .map(|[by_lon, by_lat, at_anchor]| by_lon * dlon_rad + by_lat * dlat_rad + at_anchor)
    }
}

/// What a sampler does beyond the picture, where a region is `width_rad` wide.
fn address_modes(placement: &TexturePlacement, width_rad: f64) -> [AddressMode; 2] {
    match placement {
        // All the way round the picture's left edge meets its right one.
        TexturePlacement::Extents if width_rad >= FULL_TURN_RAD => {
            [AddressMode::Repeat, AddressMode::ClampToEdge]
        }
        TexturePlacement::Extents => [AddressMode::ClampToEdge; 2],
        TexturePlacement::Anchor {
            outside: Outside::Transparent,
            ..
        } => [AddressMode::Transparent; 2],
        TexturePlacement::Anchor { .. } | TexturePlacement::Pattern { .. } => {
            [AddressMode::Repeat; 2]
        }
    }
}

/// The map of angles from `middle` for a picture of `size_m` at an anchor.
fn anchored(
    body: &Ellipsoid,
    anchor: &TextureAnchor,
    [width_m, height_m]: [f64; 2],
    middle: [f64; 2],
) -> [[f64; 3]; 2] {
    let e2 = body.eccentricity_squared();
    let (sin_lat, cos_lat) = anchor.latitude_rad.sin_cos();
    let w2 = 1.0 - e2 * sin_lat * sin_lat;
    // Radii of curvature in the prime vertical and the meridian (Snyder, 1987, eqs. 4-18 to 4-20).
    let prime_vertical_m = body.equatorial_radius_m() / w2.sqrt();
    let meridian_m = prime_vertical_m * (1.0 - e2) / w2;
    let east_m = prime_vertical_m * cos_lat;
    let (sin_up, cos_up) = anchor.rotation_rad.sin_cos();
    let row = |by_lon: f64, by_lat: f64| {
        let lon = within_half_turn(middle[0] - anchor.longitude_rad);
        let lat = middle[1] - anchor.latitude_rad;
        [by_lon, by_lat, 0.5 + by_lon * lon + by_lat * lat]
    };
    [
        row(east_m * cos_up / width_m, -meridian_m * sin_up / width_m),
        row(-east_m * sin_up / height_m, -meridian_m * cos_up / height_m),
    ]
}

/// `angle` less full turns, in −π ≤ · < π.
fn within_half_turn(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// West, south, east and north of `region` as its edges run, radians: `−π ≤ west < π` and `west <
/// east ≤ west + 2π`, the widest gap in longitude left out. A region all round has west −π.
fn region_extent_rad(region: &Region, rule: EdgeRule, body: &Ellipsoid) -> [f64; 4] {
    let mut spans = Vec::with_capacity(region.polygons.len());
    let (mut south, mut north) = (f64::INFINITY, f64::NEG_INFINITY);
    for polygon in &region.polygons {
        let shell = RingExtent::new(&polygon.shell, rule);
        let sides = polygon.sides(rule, body, region.inside);
        let holds_poles = sides[0].holds_poles;
        let mut latitudes = shell.latitudes;
        close_over_poles(&mut latitudes, holds_poles, polygon, rule);
        south = south.min(latitudes[0]);
        north = north.max(latitudes[1]);
        let [west, east] = shell.longitudes;
        let is_round = holds_poles != [false; 2];
        let width = if is_round { TAU } else { east - west };
        spans.push((within_half_turn(west), width));
    }
    let [west, east] = without_widest_gap(spans);
    [west, south, east, north]
}

/// Extends a shell to the poles that it holds; one that parts the poles only to a hole that does as
/// well.
fn close_over_poles(
    latitudes: &mut [f64; 2],
    holds_poles: [bool; 2],
    polygon: &Polygon,
    rule: EdgeRule,
) {
    let holes = polygon.holes.iter().map(|hole| RingExtent::new(hole, rule));
    let round_hole = holes.filter(|hole| hole.turns).map(|hole| hole.latitudes);
    match holds_poles {
        [false, false] => {}
        [true, true] => *latitudes = [-FRAC_PI_2, FRAC_PI_2],
        [false, true] => {
            let rim = round_hole.map(|[_, north]| north).reduce(f64::min);
            latitudes[1] = latitudes[1].max(rim.unwrap_or(FRAC_PI_2));
        }
        [true, false] => {
            let rim = round_hole.map(|[south, _]| south).reduce(f64::max);
            latitudes[0] = latitudes[0].min(rim.unwrap_or(-FRAC_PI_2));
        }
    }
}

/// Bounds of a ring's edges.
struct RingExtent {
    /// Unwrapped along the ring.
    longitudes: [f64; 2],
    latitudes: [f64; 2],
    /// Whether the ring goes round the axis.
    turns: bool,
}

impl RingExtent {
    fn new(ring: &Ring, rule: EdgeRule) -> Self {
        let mut longitude = ring.vertices_deg()[0][0].to_radians();
        let first = longitude;
        let mut longitudes = [longitude; 2];
        let mut latitudes = [f64::INFINITY, f64::NEG_INFINITY];
        for edge in ring.edges_deg() {
            let [from, to] = [edge.0, edge.1].map(|vertex| vertex.map(f64::to_radians));
            longitude = match rule {
                EdgeRule::Planar => to[0],
                EdgeRule::GreatEllipse => longitude + within_half_turn(to[0] - from[0]),
            };
            longitudes = [longitudes[0].min(longitude), longitudes[1].max(longitude)];
            let highest = match rule {
                EdgeRule::Planar => None,
                EdgeRule::GreatEllipse => turning_latitude(from, to),
            };
            for latitude in [Some(from[1]), highest].into_iter().flatten() {
                latitudes = [latitudes[0].min(latitude), latitudes[1].max(latitude)];
            }
        }
        Self {
            longitudes,
            latitudes,
            turns: (longitude - first).abs() > PI,
        }
    }
}

/// Latitude at which the shorter arc between two points runs along a parallel, if it does inside.
///
/// A plane through the body's centre is a great circle of the surface normals too, since geodetic
/// and geocentric latitude differ by a factor of their tangents.
fn turning_latitude(from: [f64; 2], to: [f64; 2]) -> Option<f64> {
    let turn = within_half_turn(to[0] - from[0]);
    let (sin_turn, cos_turn) = turn.sin_cos();
    let (tan_from, tan_to) = (from[1].tan(), to[1].tan());
    // tan φ = A cos(λ − λ_from) + B sin(λ − λ_from) along the circle.
    let slope = (tan_to - tan_from * cos_turn) / sin_turn;
    if !slope.is_finite() {
        return None;
    }
    // Its derivative along the edge at either end; inside it turns only if they differ in sign.
    let direction = turn.signum();
    let at_start = slope * direction;
    let at_end = (slope * cos_turn - tan_from * sin_turn) * direction;
    (at_start * at_end < 0.0).then(|| tan_from.hypot(slope).atan().copysign(at_start))
}

/// The shortest interval that holds all spans of (start, width) on the circle.
fn without_widest_gap(mut spans: Vec<(f64, f64)>) -> [f64; 2] {
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(first, _)) = spans.first() else {
        return [-PI, PI];
    };
    let (mut reach, mut widest) = (first, (0.0, first));
    for &(start, width) in &spans {
        if start - reach > widest.0 {
            widest = (start - reach, start);
        }
        reach = reach.max(start + width);
    }
    // Round the back; a span may reach over the first ones there.
    let mut from = first + TAU;
    for &(start, width) in &spans {
        if start + TAU > reach {
            from = start + TAU;
            break;
        }
        reach = reach.max(start + TAU + width);
    }
    if from - reach > widest.0 {
        widest = (from - reach, within_half_turn(from));
    }
    let (gap, west) = widest;
    if gap <= TAU - FULL_TURN_RAD {
        return [-PI, PI];
    }
    [west, west + TAU - gap]
}

/// Where the texels of a frame came from.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureCoordinates {
    /// Columns and rows of the picture.
    pub texels: [u32; 2],
    /// What happens beyond the picture, by region.
    pub address: Vec<[AddressMode; 2]>,
    /// Per pixel, row 0 at the top; `None` outside regions.
    pub pixels: Vec<Option<TexturePixel>>,
}

/// Where one pixel's texels came from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TexturePixel {
    /// Texture coordinates; of a pattern, those for `k = 0`, or others that differ from them by a
    /// multiple of 2ᵏ, rounded up to a whole `k`.
    pub uv: [f64; 2],
    /// The `k` of a pattern; 0 without one.
    pub pattern_level: f64,
    /// Length in texels of the longer of the footprints of a step to the next column and row; of a
    /// pattern, in texels for `k = 0`.
    pub footprint_texels: f64,
    /// Level of detail: log2 of the footprint, of a pattern for `⌊k⌋`, from 0 to the last level.
    pub level: f64,
    /// From the eye, metres.
    pub distance_m: f64,
}

impl TexturePixel {
    /// Whether everything is a number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let Self {
            uv: [u, v],
            pattern_level,
            footprint_texels,
            level,
            distance_m,
        } = *self;
        [u, v, pattern_level, footprint_texels, level, distance_m]
            .iter()
            .all(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::parse_regions;

    fn region(coordinates: &str) -> Region {
        let text = format!(r#"{{"type":"MultiPolygon","coordinates":{coordinates}}}"#);
        let mut regions = parse_regions(text.as_bytes(), "test").expect("valid");
        regions.remove(0)
    }

    fn extent_deg(coordinates: &str, rule: EdgeRule) -> [f64; 4] {
        region_extent_rad(&region(coordinates), rule, &Ellipsoid::WGS84)
            .map(|radians| (radians.to_degrees() * 1e9).round() / 1e9)
    }

    const BOX: &str = "[[[[10,20],[14,20],[14,23],[10,23],[10,20]]]]";

    #[test]
    fn extents_are_unwrapped_and_leave_the_widest_gap_out() {
        let planar = |text| extent_deg(text, EdgeRule::Planar);
        assert_eq!(planar(BOX), [10.0, 20.0, 14.0, 23.0]);
        // Fiji's way: pieces on both sides of the antimeridian.
        let fiji = "[[[[178,-18],[180,-18],[180,-16],[178,-16],[178,-18]]],\
                     [[[-180,-18],[-179,-18],[-179,-17],[-180,-17],[-180,-18]]]]";
        assert_eq!(planar(fiji), [178.0, -18.0, 181.0, -16.0]);
        // Past 180 as RFC 7946 does not want it.
        let uncut = "[[[[178,-18],[182,-18],[182,-16],[178,-16],[178,-18]]]]";
        assert_eq!(planar(uncut), [178.0, -18.0, 182.0, -16.0]);
        // Antarctica's way: closed along the antimeridian and the pole.
        let closed = "[[[[-180,-90],[180,-90],[180,-70],[0,-63],[-180,-70],[-180,-90]]]]";
        assert_eq!(planar(closed), [-180.0, -90.0, 180.0, -63.0]);
        // A ring round the pole, written uncut.
        let round = "[[[[0,60],[90,65],[180,60],[270,61],[360,60]]]]";
        assert_eq!(planar(round), [-180.0, 60.0, 180.0, 90.0]);
        // Two that overlap across the antimeridian, and one inside them.
        let nested = "[[[[170,0],[200,0],[200,1],[170,1],[170,0]]],\
                       [[[-175,0],[-150,0],[-150,1],[-175,1],[-175,0]]],\
                       [[[172,0],[173,0],[173,2],[172,2],[172,0]]]]";
        assert_eq!(planar(nested), [170.0, 0.0, 210.0, 2.0]);
    }

    #[test]
    fn great_ellipses_reach_further_north_than_their_ends() {
        let coordinates = "[[[[170,40],[-170,40],[180,50],[170,40]]]]";
        let [west, south, east, north] = extent_deg(coordinates, EdgeRule::GreatEllipse);
        assert_eq!((west, east, north), (170.0, 190.0, 50.0));
        assert_eq!(south, 40.0);
        // The edge between two points of one parallel turns in the middle: tan φ / cos 10°.
        let turning = turning_latitude([0.0, 0.7], [20_f64.to_radians(), 0.7]).expect("turns");
        let expected = (0.7_f64.tan() / 10_f64.to_radians().cos()).atan();
        assert!((turning - expected).abs() < 1e-15, "{turning} {expected}");
        let south = turning_latitude([0.0, -0.7], [20_f64.to_radians(), -0.7]).expect("turns");
        assert!((south + expected).abs() < 1e-15);
        assert_eq!(turning_latitude([0.0, 0.1], [0.1, 0.9]), None);
        let round = "[[[[0,60],[120,60],[-120,60],[0,60]]]]";
        let [west, south, east, north] = extent_deg(round, EdgeRule::GreatEllipse);
        assert_eq!([west, south, east, north], [-180.0, 60.0, 180.0, 90.0]);
    }

    fn checker(placement: &str) -> SceneTexture {
        let text = format!(
            "name = \"t\"\ndescription = \"t\"\nbody = \"wgs84\"\n[regions]\n\
             embedded = \"california.geojson\"\n[surface]\nkind = \"ellipsoid\"\n[[views]]\n\
             name = \"a\"\nlongitude_deg = 0\nlatitude_deg = 0\nheight_m = 1\nheading_deg = 0\n\
             pitch_deg = 0\n[texture]\nchecker = {{ size = 64, cells = 8 }}\nshare = \"each\"\n\
             placement = {placement}\n"
        );
        let scene = terrafill_scene::Scene::from_toml(&text, "t.toml", None).expect("valid");
        SceneTexture::clone(&scene.texture.expect("a texture"))
    }

    #[test]
    fn the_corners_of_the_extent_are_the_corners_of_the_picture() {
        let planned = PlannedTexture::new(
            &checker("\"extents\""),
            &region(BOX),
            EdgeRule::Planar,
            &Ellipsoid::WGS84,
        );
        let (lon, lat) = (2_f64.to_radians(), 1.5_f64.to_radians());
        for (dlon, dlat, expected) in [
            (-lon, lat, [0.0, 0.0]),
            (lon, lat, [1.0, 0.0]),
            (-lon, -lat, [0.0, 1.0]),
            (0.0, 0.0, [0.5, 0.5]),
        ] {
            let uv = planned.uv(dlon, dlat);
            assert!(
                (0..2).all(|i| (uv[i] - expected[i]).abs() < 1e-12),
                "{uv:?} {expected:?}"
            );
        }
        assert_eq!(planned.address, [AddressMode::ClampToEdge; 2]);
        assert_eq!((planned.image, planned.pattern), (0, None));
    }

    #[test]
    fn an_anchor_counts_metres_clockwise_from_north() {
        let body = Ellipsoid::WGS84;
        let at = |rotation: f64| {
            let placement = format!(
                "{{ anchor = {{ longitude_deg = 12, latitude_deg = 0, rotation_deg = {rotation}, \
                 width_m = 1000, height_m = 2000 }} }}"
            );
            PlannedTexture::new(&checker(&placement), &region(BOX), EdgeRule::Planar, &body)
        };
        // The region's middle is at 12°, 21.5°; its anchor on the equator, where the meridian's
        // radius is b²/a: 250 m further north is an eighth of the picture up.
        let north = 250.0 / (6_356_752.314_245_179_f64.powi(2) / 6_378_137.0);
        let east = 250.0 / 6_378_137.0;
        let to_anchor = -21.5_f64.to_radians();
        let close = |a: [f64; 2], b: [f64; 2]| (0..2).all(|i| (a[i] - b[i]).abs() < 1e-9);
        assert!(close(at(0.0).uv(0.0, to_anchor + north), [0.5, 0.375]));
        assert!(close(at(0.0).uv(east, to_anchor), [0.75, 0.5]));
        // Up is east: north of the anchor is to the left.
        assert!(close(at(90.0).uv(0.0, to_anchor + north), [0.25, 0.5]));
        assert!(close(at(90.0).uv(east, to_anchor), [0.5, 0.375]));
        assert_eq!(at(0.0).address, [AddressMode::Repeat; 2]);
        // Negative control: turned the other way it is another place.
        assert!(!close(at(-90.0).uv(0.0, to_anchor + north), [0.25, 0.5]));
    }

    #[test]
    fn an_anchor_across_the_antimeridian_is_near() {
        let placement = "{ anchor = { longitude_deg = -179, latitude_deg = -17, width_m = 1e6, \
                         height_m = 1e6, outside = \"transparent\" } }";
        let fiji = "[[[[177,-18],[179,-18],[179,-16],[177,-16],[177,-18]]]]";
        let body = Ellipsoid::WGS84;
        let planned =
            PlannedTexture::new(&checker(placement), &region(fiji), EdgeRule::Planar, &body);
        // Three degrees of longitude at 17° are 319 km: 0.32 of the picture to the left.
        let [u, v] = planned.uv(0.0, 0.0);
        assert!(
            (u - 0.18).abs() < 0.002 && (v - 0.5).abs() < 1e-9,
            "{u} {v}"
        );
        assert_eq!(planned.address, [AddressMode::Transparent; 2]);
    }

    #[test]
    fn a_region_all_round_repeats_from_left_to_right_only() {
        let round = region("[[[[0,60],[90,65],[180,60],[270,61],[360,60]]]]");
        let planned = PlannedTexture::new(
            &checker("\"extents\""),
            &round,
            EdgeRule::Planar,
            &Ellipsoid::WGS84,
        );
        assert_eq!(
            planned.address,
            [AddressMode::Repeat, AddressMode::ClampToEdge]
        );
        let [lon, lat] = planned.anchor_lon_lat_rad;
        assert!(lon == 0.0 && (lat - 75_f64.to_radians()).abs() < 1e-15);
    }

    #[test]
    fn a_pattern_is_a_texel_a_metre_at_its_level_0() {
        let placement =
            "{ pattern = { longitude_deg = 12, latitude_deg = 21.5, texels_per_px = 2 } }";
        let body = Ellipsoid::UNIT_SPHERE;
        let planned =
            PlannedTexture::new(&checker(placement), &region(BOX), EdgeRule::Planar, &body);
        assert_eq!(planned.pattern, Some(Pattern { texels_per_px: 2.0 }));
        let [_, v] = planned.uv(0.0, 0.64);
        assert!((v - 0.49).abs() < 1e-12, "{v}");
    }
}
