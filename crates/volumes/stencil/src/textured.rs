// SPDX-License-Identifier: MIT OR Apache-2.0
//! The plan of a textured fill: which route each region's fragments take to their place in the
//! picture, and the constants they read on the way.
//!
//! Everything a backend does not need to know is settled here in `f64`, once for every API:
//! anchors, the chosen routes with their residuals, and what a shader reads, rounded last. The
//! layout is that of `TexturedRegion` in `texture/cover.wgsl`; a test holds the two together.

use crate::footprint::is_magnified;
use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use terrafill_contract::{
    AddressMode, FillInput, PlannedTexture, TextureCoordinates, TexturePixel,
};
use terrafill_core::nearest_f32;
use terrafill_plan::PlannedRegion;
use terrafill_scene::SceneTexture;
use terrafill_texture::{
    Chart, Chooser, CoordinateRoute, Demand, DepthFormat, MapExtent, MapRegion, PerspectiveView,
    PositionRoute, Reason,
};
use terrafill_variant::{RouteChoice, SwitchError};

/// What stands in the shader of [`RouteChoice::Floor`] all the same: the fewest steps there are.
const UNTAKEN: CoordinateRoute = CoordinateRoute::Chart(Chart::Planes);

/// A region as the textured cover sees it. Meridian axes: body axes turned about the polar axis
/// until the anchor's longitude is 0. Metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct TexturedRegion {
    /// The region's anchor, a point of the body's surface.
    pub anchor_m: [f32; 3],
    /// What the probe writes for the region: its index and 1.
    pub id: f32,
    /// Eye minus anchor.
    pub eye_m: [f32; 3],
    /// Opacity, times the picture's own.
    pub alpha: f32,
    /// Step to the pixel on the right, in the image plane at distance 1.
    pub right: [f32; 3],
    /// The body's.
    pub equatorial_radius_m: f32,
    /// Step to the pixel below, in the image plane at distance 1.
    pub down: [f32; 3],
    /// The body's first eccentricity squared.
    pub eccentricity_squared: f32,
    /// u per radian of longitude and of latitude, and at the anchor.
    pub u: [f32; 3],
    /// Distance from the eye at which nothing is left of the fill.
    pub fade_end_m: f32,
    /// v as `u`.
    pub v: [f32; 3],
    /// 1 / the length of the fade.
    pub fade_per_m: f32,
    /// Of a pattern: metres that a texel should span, per metre of distance from the eye.
    pub texel_per_m: f32,
    /// The routes' constants start at a multiple of 16 bytes.
    pub padding: [f32; 3],
}

impl TexturedRegion {
    /// `vec4f` that the fixed part takes.
    pub const VECTORS: usize = size_of::<Self>() / 16;
}

/// One planned region of a textured fill.
#[derive(Debug, Clone)]
pub struct TexturedCover {
    /// How the picture lies on it.
    pub texture: PlannedTexture,
    /// How its fragments find their angles.
    pub route: CoordinateRoute,
    /// Fixed part of what the shader reads.
    pub region: TexturedRegion,
    /// Constants of the position route.
    pub position_constants: Vec<[f32; 4]>,
    /// Constants of the coordinate route.
    pub route_constants: Vec<[f32; 4]>,
    /// Whether no pixel of it spans more than a texel of the picture, by a bound: the level of detail
    /// is 0 everywhere, and the shader need not look for it.
    pub is_magnified: bool,
    /// Whether the position is normalised before its angles are taken, for the price to be measured.
    pub normalizes_position: bool,
    /// Whether it is [`RouteChoice::Floor`]: the route is not taken.
    pub is_floor: bool,
}

/// What the shader of one cover's colour pass has in it and what not: its `override` constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct CoverOverrides {
    fades: bool,
    ends_at_edges: bool,
    is_magnified: bool,
    normalizes_position: bool,
    is_floor: bool,
}

impl CoverOverrides {
    /// Of the probe of the same cover, which finds level and place of everything and colours nothing.
    fn of_probe(self) -> Self {
        Self {
            normalizes_position: self.normalizes_position,
            is_floor: self.is_floor,
            ..Self::default()
        }
    }

    /// By the shader's names, 1 where it is so.
    #[must_use]
    pub fn constants(self) -> [(&'static str, f64); 5] {
        [
            ("FADES", self.fades),
            ("ENDS_AT_EDGES", self.ends_at_edges),
            ("IS_MAGNIFIED", self.is_magnified),
            ("NORMALIZES_POSITION", self.normalizes_position),
            ("IS_FLOOR", self.is_floor),
        ]
        .map(|(name, is_so)| (name, f64::from(u8::from(is_so))))
    }
}

/// What a textured cover is drawn for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CoverPurpose {
    /// The picture's colours.
    Colour,
    /// Where the picture's texels came from, into targets of floats.
    Probe,
}

/// What a pipeline of textured covers does with its fragments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CoverLook {
    /// What for.
    pub purpose: CoverPurpose,
    /// What its shader has in it.
    pub overrides: CoverOverrides,
    /// Colours are blended over what lies under them.
    pub blends: bool,
}

impl CoverLook {
    /// Entry point of its fragment shader.
    #[must_use]
    pub fn entry_point(self) -> &'static str {
        match self.purpose {
            CoverPurpose::Colour => "fragment_main",
            CoverPurpose::Probe => "probe_main",
        }
    }
}

impl TexturedCover {
    /// How it is drawn.
    ///
    /// - `images_are_opaque`: no texel of the pictures lets anything show that lies under it
    #[must_use]
    pub fn look(&self, purpose: CoverPurpose, images_are_opaque: bool) -> CoverLook {
        let overrides = self.overrides();
        match purpose {
            CoverPurpose::Colour => CoverLook {
                purpose,
                overrides,
                blends: self.is_translucent() || !images_are_opaque,
            },
            CoverPurpose::Probe => CoverLook {
                purpose,
                overrides: overrides.of_probe(),
                blends: false,
            },
        }
    }

    /// Whether the picture ends at its edges.
    fn ends_at_edges(&self) -> bool {
        self.texture.address.contains(&AddressMode::Transparent)
    }

    /// What its colour pass has in it.
    #[must_use]
    pub fn overrides(&self) -> CoverOverrides {
        CoverOverrides {
            fades: self.texture.fade_m.is_some(),
            ends_at_edges: self.ends_at_edges(),
            is_magnified: self.is_magnified,
            normalizes_position: self.normalizes_position,
            is_floor: self.is_floor,
        }
    }

    /// Whether something of what lies under the fill shows, whatever the picture's own alpha.
    fn is_translucent(&self) -> bool {
        self.texture.alpha < 1.0 || self.texture.fade_m.is_some() || self.ends_at_edges()
    }
}

/// What a row says about a route.
#[derive(Debug, Clone, PartialEq)]
pub struct RouteNote {
    /// Name of the route.
    pub route: String,
    /// How many regions of the frame take it.
    pub regions: usize,
    /// Largest computed error over those regions, metres.
    pub max_m: f64,
    /// The same in texels of the picture, along the axis where it is larger.
    pub max_texels: f64,
    /// Whether every one of them is within the tolerances.
    pub is_within: bool,
    /// Cheaper routes that were left out for one of them, each with the reason.
    pub left_out: Vec<String>,
}

/// The textured covers of a frame.
#[derive(Debug, Clone)]
pub struct TexturedPlan {
    /// By planned region.
    pub covers: Vec<TexturedCover>,
    /// How all fragments find their offset.
    pub position: PositionRoute,
    /// The depth they read.
    pub depth: DepthFormat,
    /// The routes taken, the most frequent first; with their residuals where they were chosen.
    pub notes: Vec<RouteNote>,
}

impl TexturedPlan {
    /// Plans the textured fill of a frame.
    ///
    /// # Errors
    /// [`SwitchError`] where the scene has no picture, or no route is finite for a region.
    pub fn new(
        input: &FillInput,
        choice: RouteChoice,
        position: PositionRoute,
    ) -> Result<Self, SwitchError> {
        let refuse = |found: String, allowed: &str| SwitchError {
            switch: "texture",
            found,
            allowed: allowed.to_owned(),
        };
        let Some(scene_texture) = &input.scene.texture else {
            let found = format!("{} for a scene without a picture", choice.name());
            return Err(refuse(found, "plain"));
        };
        let depth = DepthFormat::reversed(input.camera.near_m)
            .map_err(|error| refuse(error.to_string(), "a near plane in front of the eye"))?;
        let view = view(input, depth);
        let textures = PlannedTexture::of_scene(&input.scene);
        let mut covers = Vec::with_capacity(input.plan.regions.len());
        let mut notes: Vec<RouteNote> = Vec::new();
        let chooser = Chooser::of_plan();
        for planned in &input.plan.regions {
            let texture = textures[planned.region];
            let told =
                |what: String| format!("{} for region {}: {what}", choice.name(), planned.region);
            let sight = EyeDistance::new(input, planned);
            let map = map_region(input, &texture, &sight)
                .map_err(|error| refuse(told(error.to_string()), "plain"))?;
            let (route, note) = match choice {
                RouteChoice::Route(route) => (route, named(route.name())),
                RouteChoice::Floor => (UNTAKEN, named(choice.name())),
                RouteChoice::Chosen => {
                    let demand = sight.demand(map, &texture, scene_texture);
                    chosen_once(&chooser, &demand)
                        .ok_or_else(|| refuse(told("none is finite".to_owned()), "plain"))?
                }
            };
            add_note(&mut notes, note);
            covers.push(TexturedCover {
                texture,
                route,
                region: fixed_part(input, &view, &map, &texture, &sight, planned.region),
                position_constants: position.constants(&view, &map),
                route_constants: route.constants(&map),
                is_magnified: is_magnified(
                    input,
                    planned,
                    &texture,
                    scene_texture.image.size_px(),
                    sight.farthest_m,
                ),
                normalizes_position: false,
                is_floor: choice == RouteChoice::Floor,
            });
        }
        notes.sort_by_key(|note| std::cmp::Reverse(note.regions));
        Ok(Self {
            covers,
            position,
            depth,
            notes,
        })
    }

    /// One line of what was chosen and why, for a row.
    #[must_use]
    pub fn note(&self) -> String {
        let routes = self.notes.iter().map(|note| {
            let within = if note.is_within {
                ""
            } else {
                ", beyond tolerance"
            };
            let computed = if note.max_m.is_finite() {
                format!(
                    ", computed ≤ {:.3e} m, {:.3} texels{within}",
                    note.max_m, note.max_texels
                )
            } else {
                String::new()
            };
            let plural = if note.regions == 1 { "" } else { "s" };
            format!("{} ({} region{plural}{computed})", note.route, note.regions)
        });
        let left_out = self.left_out_note();
        routes.chain(left_out).collect::<Vec<_>>().join("; ")
    }

    /// The cheapest routes that were left out, each with its first reason.
    fn left_out_note(&self) -> Option<String> {
        let mut reasons: Vec<&str> = Vec::new();
        let route = |reason: &str| reason.split(':').next().map(str::to_owned);
        for reason in self.notes.iter().flat_map(|note| &note.left_out) {
            if !reasons.iter().any(|known| route(known) == route(reason)) {
                reasons.push(reason);
            }
        }
        let more = reasons.len().saturating_sub(LEFT_OUT_NAMED);
        reasons.truncate(LEFT_OUT_NAMED);
        let more = (more > 0).then(|| format!("and {more} more"));
        (!reasons.is_empty()).then(|| {
            let all: Vec<&str> = reasons.into_iter().chain(more.as_deref()).collect();
            format!("cheaper ones left out: {}", all.join(", "))
        })
    }

    /// The places that a device's probe found, as the comparison takes them.
    ///
    /// - `pixels`: per pixel, row 0 at the top
    #[must_use]
    pub fn coordinates(
        &self,
        input: &FillInput,
        pixels: Vec<Option<TexturePixel>>,
    ) -> TextureCoordinates {
        let texels = input.scene.texture.as_ref().map(|t| t.image.size_px());
        TextureCoordinates {
            texels: texels.unwrap_or_default(),
            address: PlannedTexture::of_scene(&input.scene)
                .iter()
                .map(|texture| texture.address)
                .collect(),
            pixels,
        }
    }
}

/// Routes that a row names as left out: beyond those nobody reads on.
const LEFT_OUT_NAMED: usize = 5;

/// What [`chosen`] said, by the demand as written, which tells apart what differs in the last bit.
/// Choosing for a planet of islands takes seconds, and a bench asks the same for every case of a view.
static KNOWN: Mutex<BTreeMap<String, Option<(CoordinateRoute, RouteNote)>>> =
    Mutex::new(BTreeMap::new());

/// Demands remembered: those of a dozen views of a planet, a kilobyte each.
const MOST_KNOWN: usize = 2048;

/// [`chosen`] by the default candidates.
fn chosen_once(chooser: &Chooser, demand: &Demand) -> Option<(CoordinateRoute, RouteNote)> {
    let key = format!("{demand:?}");
    let lock = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = lock().get(&key) {
        return known.clone();
    }
    let found = chosen(chooser, demand);
    let mut known = lock();
    if known.len() >= MOST_KNOWN {
        known.clear();
    }
    known.insert(key, found.clone());
    found
}

fn chosen(chooser: &Chooser, demand: &Demand) -> Option<(CoordinateRoute, RouteNote)> {
    let choice = chooser.choose(demand);
    let taken = choice.best_effort()?;
    let left_out = choice
        .left_out
        .iter()
        .filter(|(considered, reason)| {
            !matches!(reason, Reason::Dearer { .. }) && considered.route != taken.route
        })
        .map(|(considered, reason)| format!("{}: {}", considered.route.name(), why(reason)))
        .collect();
    let note = RouteNote {
        route: taken.route.name(),
        regions: 1,
        max_m: taken.residual.map_or(f64::NAN, |residual| residual.max_m),
        max_texels: taken.residual.map_or(f64::NAN, |residual| {
            let size_rad = demand.region.extent().size_rad();
            let texels = |axis: usize| {
                residual.max_axis_rad[axis] * f64::from(demand.texture_size[axis]) / size_rad[axis]
            };
            texels(0).max(texels(1))
        }),
        is_within: choice.chosen.is_some(),
        left_out,
    };
    Some((taken.route, note))
}

/// Of a route that was asked for by name.
fn named(route: String) -> RouteNote {
    RouteNote {
        route,
        regions: 1,
        max_m: f64::NAN,
        max_texels: f64::NAN,
        is_within: true,
        left_out: Vec::new(),
    }
}

fn why(reason: &Reason) -> String {
    match reason {
        Reason::RmsTexels { found, allowed } => format!("{found:.2} texels RMS of {allowed}"),
        Reason::MaxTexels { found, allowed } => format!("{found:.2} texels of {allowed}"),
        Reason::RmsPixels { found, allowed } => format!("{found:.2} pixels RMS of {allowed}"),
        Reason::NonFinite { found } => format!("not finite at {found} places"),
        other => other.to_string(),
    }
}

fn add_note(notes: &mut Vec<RouteNote>, note: RouteNote) {
    let same = |there: &&mut RouteNote| there.route == note.route;
    let Some(there) = notes.iter_mut().find(same) else {
        notes.push(note);
        return;
    };
    there.regions += note.regions;
    there.max_m = there.max_m.max(note.max_m);
    there.max_texels = there.max_texels.max(note.max_texels);
    there.is_within &= note.is_within;
    for reason in note.left_out {
        if !there.left_out.contains(&reason) {
            there.left_out.push(reason);
        }
    }
}

/// What a frame asks of a region: the part in sight, anchored where offsets are short for the eye.
fn map_region(
    input: &FillInput,
    texture: &PlannedTexture,
    sight: &EyeDistance,
) -> Result<MapRegion, terrafill_texture::MapRegionError> {
    let [west_rad, south_rad, east_rad, north_rad] = texture.extent_rad;
    let whole = MapExtent {
        west_rad,
        south_rad,
        east_rad,
        north_rad,
    };
    let terrain = input.terrain();
    let heights = (terrain.lowest_m, terrain.highest_m);
    let pixel_m = sight.pixel * sight.nearest_m;
    let eye_ecef = input.camera.eye_ecef;
    MapRegion::seen_from(input.scene.body, whole, heights, eye_ecef, pixel_m)
}

fn view(input: &FillInput, depth: DepthFormat) -> PerspectiveView {
    let camera = &input.camera;
    let ecef_from_view = camera.view_from_ecef.transpose();
    let focal_y = camera.tan_half_fov().recip();
    PerspectiveView {
        eye_ecef: camera.eye_ecef,
        right: ecef_from_view.x_axis,
        up: ecef_from_view.y_axis,
        backward: ecef_from_view.z_axis,
        focal_x: focal_y / input.size.aspect(),
        focal_y,
        size: [input.size.width, input.size.height],
        depth,
    }
}

/// How far the eye is from a region.
#[derive(Debug, Clone, Copy)]
struct EyeDistance {
    nearest_m: f64,
    farthest_m: f64,
    /// Of a pixel at distance 1.
    pixel: f64,
}

impl EyeDistance {
    fn new(input: &FillInput, planned: &PlannedRegion) -> Self {
        let bounds = input.scene.bounds.get(planned.mesh);
        let (nearest_m, farthest_m) = bounds.map_or((0.0, f64::INFINITY), |bounds| {
            bounds.bounds.distances_m(input.camera.eye_ecef)
        });
        let camera = &input.camera;
        let body = &input.scene.body;
        // A box holds the region's caps too, and the eye may be in it; the ground is further away.
        let above_m = body.ecef_to_geodetic(camera.eye_ecef).height_m - input.terrain().highest_m;
        Self {
            nearest_m: nearest_m.max(above_m).max(camera.near_m),
            // No finite box: as far as anything on the body can be.
            farthest_m: farthest_m
                .min(input.camera.eye_ecef.length() + 2.0 * input.scene.body.equatorial_radius_m()),
            pixel: input.camera.pixel_size_m(input.size, 1.0),
        }
    }

    /// log2 of the metres that a pattern's texel spans at a distance.
    fn pattern_level(&self, texels_per_px: f64, distance_m: f64) -> f64 {
        (distance_m * self.pixel / texels_per_px).log2()
    }

    fn demand(&self, map: MapRegion, texture: &PlannedTexture, scene: &SceneTexture) -> Demand {
        let [columns, rows] = scene.image.size_px().map(f64::from);
        let finest = texture.pattern.map_or(1.0, |pattern| {
            let level = self.pattern_level(pattern.texels_per_px, self.nearest_m);
            (-level.floor()).exp2()
        });
        let [u, v] = texture.uv_from_angles;
        let size = map.extent().size_rad();
        // Texels of the finest picture across the extent, whichever way the picture is turned.
        let texels = |axis: usize| {
            let per_radian = (u[axis].abs() * columns).max(v[axis].abs() * rows) * finest;
            whole(per_radian * size[axis])
        };
        Demand {
            region: map,
            texture_size: [texels(0), texels(1)],
            pixel_m: self.pixel * self.nearest_m,
        }
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "clamped to what the type holds"
)]
fn whole(texels: f64) -> u32 {
    texels.ceil().clamp(1.0, f64::from(u32::MAX)) as u32
}

fn fixed_part(
    input: &FillInput,
    view: &PerspectiveView,
    map: &MapRegion,
    texture: &PlannedTexture,
    sight: &EyeDistance,
    region: usize,
) -> TexturedRegion {
    let body = map.body();
    let turn = DMat3::from_rotation_z(-map.anchor_longitude_rad());
    let step = |axis: DVec3, length: f64| (turn * axis * length).as_vec3().to_array();
    let [width, height] = view.size.map(f64::from);
    let fade = texture
        .fade_m
        .map(|[begin, end]| [end, 1.0 / (end - begin)]);
    let [fade_end, fade_per_m] = fade.unwrap_or_default();
    let texels_per_px = texture.pattern.map(|pattern| pattern.texels_per_px);
    let level = texels_per_px.map(|texels| sight.pattern_level(texels, sight.farthest_m));
    let row = |axis: usize| {
        let at_anchor = at_anchor(texture, map, axis);
        let [by_lon, by_lat, _] = texture.uv_from_angles[axis];
        [
            by_lon,
            by_lat,
            reduced(at_anchor, texture.address[axis], level),
        ]
        .map(nearest_f32)
    };
    TexturedRegion {
        anchor_m: map.anchor_meridian().as_vec3().to_array(),
        id: (region + 1) as f32,
        eye_m: view.exact_offset_m(map, [0.0; 2], 0.0).as_vec3().to_array(),
        alpha: nearest_f32(texture.alpha),
        right: step(view.right, 2.0 / (width * view.focal_x)),
        equatorial_radius_m: nearest_f32(body.equatorial_radius_m()),
        down: step(view.up, -2.0 / (height * view.focal_y)),
        eccentricity_squared: nearest_f32(body.eccentricity_squared()),
        u: row(0),
        fade_end_m: nearest_f32(fade_end),
        v: row(1),
        fade_per_m: nearest_f32(fade_per_m),
        texel_per_m: texels_per_px.map_or(0.0, |texels| nearest_f32(sight.pixel / texels)),
        padding: [0.0; 3],
    }
    .checked(input)
}

impl TexturedRegion {
    /// Debug builds look at what was rounded: an infinite constant draws nothing and says nothing.
    fn checked(self, input: &FillInput) -> Self {
        let vectors: &[f32] = bytemuck::cast_slice(std::slice::from_ref(&self));
        debug_assert!(
            vectors.iter().all(|value| value.is_finite()),
            "{}: {self:?}",
            input.view
        );
        self
    }
}

/// u or v at the anchor that the routes measure from.
fn at_anchor(texture: &PlannedTexture, map: &MapRegion, axis: usize) -> f64 {
    let [longitude, latitude] = texture.anchor_lon_lat_rad;
    let moved = [
        map.anchor_longitude_rad() - longitude,
        map.anchor_latitude_rad() - latitude,
    ];
    texture.uv(moved[0], moved[1])[axis]
}

/// A coordinate at the anchor less whole pictures: what `f32` loses of a far anchor is not lost here.
///
/// - `coarsest`: of a pattern, the largest `k` in view: its pictures come in 2ᵏ⁺¹, of which every
///   finer one is a part
fn reduced(at_anchor: f64, address: AddressMode, coarsest: Option<f64>) -> f64 {
    match (address, coarsest) {
        (AddressMode::Repeat, Some(level)) => {
            at_anchor.rem_euclid((level.floor() + 2.0).max(0.0).exp2())
        }
        (AddressMode::Repeat, None) => at_anchor.rem_euclid(1.0),
        (AddressMode::ClampToEdge | AddressMode::Transparent, _) => at_anchor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_can_be_named_and_found_again() {
        for name in ["chosen", "recentred-odd-rel-7+bowring-1", "gnomonic-3"] {
            let choice = RouteChoice::parse(name).expect("known");
            assert_eq!(choice.name(), name);
        }
        assert_eq!(RouteChoice::parse("odd-4"), None);
    }

    #[test]
    fn whole_pictures_are_left_out_only_where_they_repeat() {
        let exact = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        exact(reduced(12_345.25, AddressMode::Repeat, None), 0.25);
        exact(reduced(-0.25, AddressMode::Repeat, None), 0.75);
        exact(reduced(1.75, AddressMode::ClampToEdge, None), 1.75);
        exact(reduced(-3.5, AddressMode::Transparent, None), -3.5);
        // At k = 3.5 the coarser of the two pictures has 2⁴ times the size.
        let left = reduced(12_345.25, AddressMode::Repeat, Some(3.5));
        exact((12_345.25 - left) / 16.0 % 1.0, 0.0);
        assert!(left < 32.0);
        // Negative control: less would move the coarser picture.
        let wrong = 12_345.25_f64.rem_euclid(8.0);
        assert!(((12_345.25 - wrong) / 16.0 % 1.0).abs() > 0.1);
    }
}
