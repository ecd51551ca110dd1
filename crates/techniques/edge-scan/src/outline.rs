// SPDX-License-Identifier: MIT OR Apache-2.0
//! Outlines of regions as lines of positions in the plane of longitude and latitude, from −180° to 180°.
//!
//! Degrees. Whether a place is inside follows from the number of edges south of it on its own meridian: each
//! turns inside into outside. What no edge is south of is inside or outside; which of them is found from a place
//! in the region. So neither pole needs an edge of its own. Nor do the ends of the plane, where lines that cross
//! the antimeridian are cut.
//! Edges are those of the region's mesh: straight in this plane to the mesh's tolerance, by either edge rule.

use std::ops::Range;
use terrafill_contract::{DeviceError, GeometryBytes, count_u32};
use terrafill_core::{Ellipsoid, RegionMesh, nearest_f32};
use terrafill_variant::{SwitchError, Variant};

/// Key of the way in which positions are kept.
pub(crate) const OUTLINE: &str = "outline";

/// Its values.
pub(crate) const OUTLINES: &[&str] = &["f32", "f16"];

/// From a pole, degrees: vertices nearer than this, 0.1 mm on the Earth, are at it.
const POLE_DEG: f64 = 1e-9;

/// Bytes of the number that a line ends with.
const LINE_BYTES: u64 = 4;

/// How positions are kept, longitude and latitude in degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    /// Two floats: at 180° off by up to 0.8 m on the Earth.
    F32,
    /// Two half floats: at 180° off by up to 7 km.
    F16,
}

impl Format {
    pub(crate) fn of(variant: &Variant) -> Result<Self, SwitchError> {
        variant.choice(OUTLINE, &[("f32", Self::F32), ("f16", Self::F16)])
    }

    fn position_bytes(self) -> u64 {
        match self {
            Self::F32 => 8,
            Self::F16 => 4,
        }
    }

    fn push(self, words: &mut Vec<u32>, place: [f64; 2]) {
        match self {
            Self::F32 => words.extend(place.map(|degrees| nearest_f32(degrees).to_bits())),
            Self::F16 => {
                let [low, high] = place.map(|degrees| half::f16::from_f64(degrees).to_bits());
                words.push(u32::from(high) << 16 | u32::from(low));
            }
        }
    }

    /// What is read where `degrees` was kept. Greater numbers never become smaller ones, so that a box of
    /// rounded ends holds all rounded positions.
    fn rounded(self, degrees: f64) -> f32 {
        match self {
            Self::F32 => nearest_f32(degrees),
            Self::F16 => half::f16::from_f64(degrees).to_f32(),
        }
    }
}

fn is_pole(place: [f64; 2]) -> bool {
    90.0 - place[1].abs() < POLE_DEG
}

/// Whether an edge between two places, the short way, reaches over the antimeridian.
fn is_cut(start: [f64; 2], end: [f64; 2]) -> bool {
    (end[0] - start[0]).abs() >= 180.0 && !is_pole(start) && !is_pole(end)
}

/// Bytes of one region, by formula: a position for each vertex of its boundary, one that closes each loop, one
/// more at a pole, two more where an edge is cut; and a number for each loop and cut.
pub(crate) fn outline_bytes(format: Format, mesh: &RegionMesh) -> GeometryBytes {
    let edges = mesh.boundary_edges();
    let edges = edges.map(|ends| ends.map(|vertex| mesh.vertices_deg[vertex as usize]));
    let [mut positions, mut cuts] = [0, 0];
    for [start, end] in edges {
        positions += 1 + u64::from(is_pole(start));
        cuts += u64::from(is_cut(start, end));
    }
    let loops = mesh.boundary_loops.len() as u64;
    GeometryBytes {
        vertex_bytes: (positions + loops + 2 * cuts) * format.position_bytes(),
        index_bytes: (loops + cuts) * LINE_BYTES,
    }
}

/// A line that is being drawn, and those before it.
struct Pen {
    lines: Vec<Vec<[f64; 2]>>,
    line: Vec<[f64; 2]>,
    at: [f64; 2],
}

impl Pen {
    fn draw(&mut self, to: [f64; 2]) {
        self.line.push(to);
        self.at = to;
    }

    /// The short way, cut in two where it reaches over the antimeridian. False where both ways are as long.
    fn draw_short(&mut self, to: [f64; 2]) -> bool {
        if is_cut(self.at, to) {
            let side = 180.0_f64.copysign(self.at[0]);
            let step = to[0] + 2.0 * side - self.at[0];
            if step.abs() >= 180.0 {
                return false;
            }
            // Along the antimeridian nothing is cut through.
            let share = if step == 0.0 {
                0.0
            } else {
                (side - self.at[0]) / step
            };
            let latitude = self.at[1] + share * (to[1] - self.at[1]);
            self.draw([side, latitude]);
            self.lines.push(std::mem::take(&mut self.line));
            self.draw([-side, latitude]);
        }
        self.draw(to);
        true
    }
}

/// The lines of one region.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outline {
    lines: Vec<Vec<[f64; 2]>>,
    is_inside_in_the_south: bool,
}

impl Outline {
    /// # Errors
    /// [`DeviceError::Unsupported`] for an edge of half a turn, which has no shorter way.
    fn of(body: &Ellipsoid, mesh: &RegionMesh) -> Result<Self, DeviceError> {
        let mut lines = Vec::new();
        for ring in &mesh.boundary_loops {
            let places: Vec<[f64; 2]> = ring
                .iter()
                .map(|&vertex| mesh.vertices_deg[vertex as usize])
                .collect();
            let own = lines_of(&places).ok_or_else(|| DeviceError::Unsupported {
                capability: format!(
                    "a way for region {} ({}): one of its edges is half a turn long",
                    mesh.region_index, mesh.name
                ),
                adapter: "an outline in longitude and latitude".to_owned(),
            })?;
            lines.extend(own);
        }
        let mut outline = Self {
            lines,
            is_inside_in_the_south: false,
        };
        let inside = place_inside(body, mesh);
        outline.is_inside_in_the_south =
            inside.is_some_and(|inside| !outline.is_south_of_odd(inside));
        Ok(outline)
    }

    /// Whether an odd number of edges is south of `place` on its meridian.
    fn is_south_of_odd(&self, [longitude, latitude]: [f64; 2]) -> bool {
        let edges = self.lines.iter().flat_map(|line| line.windows(2));
        let south = edges.filter(|ends| {
            let [start, end] = [ends[0], ends[1]];
            let share = (longitude - start[0]) / (end[0] - start[0]);
            (start[0] <= longitude) != (end[0] <= longitude)
                && start[1] + share * (end[1] - start[1]) < latitude
        });
        south.count() % 2 == 1
    }
}

/// Lines of a loop, closed. A pole that it goes through becomes an edge along it, from one longitude to the
/// other. `None` for an edge of half a turn.
fn lines_of(places: &[[f64; 2]]) -> Option<Vec<Vec<[f64; 2]>>> {
    let Some(first) = places.iter().position(|place| !is_pole(*place)) else {
        return Some(Vec::new());
    };
    let at = |step: usize| places[(first + step) % places.len()];
    let mut pen = Pen {
        lines: Vec::new(),
        line: Vec::new(),
        at: at(0),
    };
    pen.draw(at(0));
    for step in 1..=places.len() {
        let to = at(step);
        if is_pole(to) {
            let pole = 90.0_f64.copysign(to[1]);
            pen.draw([pen.at[0], pole]);
            pen.draw([at(step + 1)[0], pole]);
        } else if is_pole(pen.at) {
            pen.draw(to);
        } else if !pen.draw_short(to) {
            return None;
        }
    }
    pen.lines.push(pen.line);
    Some(pen.lines)
}

/// Longitude and latitude of the middle of the largest triangle; `None` of a mesh of nothing.
fn place_inside(body: &Ellipsoid, mesh: &RegionMesh) -> Option<[f64; 2]> {
    let corners = mesh.triangles.iter();
    let corners = corners.map(|corners| corners.map(|vertex| mesh.vertices_ecef[vertex as usize]));
    let largest = corners.max_by(|one, other| {
        let [one, other] = [one, other].map(|[a, b, c]| (b - a).cross(c - a).length());
        one.total_cmp(&other)
    })?;
    let middle = body.ecef_to_geodetic((largest[0] + largest[1] + largest[2]) / 3.0);
    Some([middle.longitude_rad, middle.latitude_rad].map(f64::to_degrees))
}

/// Where the outline of a mesh lies among those of a scene.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OutlinePlace {
    /// Its lines.
    pub(crate) lines: Range<u32>,
    /// West, south, east and north, degrees; west is greater than east of one across the antimeridian.
    pub(crate) box_deg: [f32; 4],
    /// What no edge is south of is inside.
    pub(crate) is_inside_in_the_south: bool,
}

/// Outlines of all meshes of a scene as the shader reads them.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct SceneOutlines {
    /// Positions of all lines: two words each, or one of two halves.
    pub(crate) words: Vec<u32>,
    /// Of each line the first position that is none of it any more.
    pub(crate) ends: Vec<u32>,
    /// By mesh.
    pub(crate) places: Vec<OutlinePlace>,
}

impl SceneOutlines {
    /// # Errors
    /// As [`Outline::of`]; [`DeviceError::OverCapacity`].
    pub(crate) fn new<'a>(
        format: Format,
        body: &Ellipsoid,
        meshes: impl IntoIterator<Item = &'a RegionMesh>,
    ) -> Result<Self, DeviceError> {
        let mut all = Self::default();
        let mut positions = 0;
        for mesh in meshes {
            let outline = Outline::of(body, mesh)?;
            let first = count_u32("lines of outlines", all.ends.len())?;
            for line in &outline.lines {
                for place in line {
                    format.push(&mut all.words, *place);
                }
                positions += line.len();
                all.ends
                    .push(count_u32("positions of outlines", positions)?);
            }
            let extent = &mesh.extent;
            let ends = [
                extent.west_deg,
                extent.south_deg,
                extent.east_deg,
                extent.north_deg,
            ];
            all.places.push(OutlinePlace {
                lines: first..count_u32("lines of outlines", all.ends.len())?,
                box_deg: ends.map(|degrees| format.rounded(degrees)),
                is_inside_in_the_south: outline.is_inside_in_the_south,
            });
        }
        Ok(all)
    }

    /// What they take.
    pub(crate) fn bytes(&self) -> GeometryBytes {
        GeometryBytes {
            vertex_bytes: size_of_val(self.words.as_slice()) as u64,
            index_bytes: size_of_val(self.ends.as_slice()) as u64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::{EdgeRule, MeshOptions};
    use terrafill_fixtures::region;

    const BODY: Ellipsoid = Ellipsoid::WGS84;

    fn meshed(coordinates: &str, rule: EdgeRule) -> RegionMesh {
        let regions = [region(coordinates)];
        let meshes = RegionMesh::build_all(&regions, &BODY, rule, &MeshOptions::default());
        meshes.expect("it meshes").remove(0)
    }

    type Places = &'static [[f64; 2]];

    /// Region, and places inside and outside of it.
    const CASES: [(&str, Places, Places); 7] = [
        (
            "[[[0,0],[10,0],[10,10],[0,10],[0,0]],[[4,4],[4,6],[6,6],[6,4],[4,4]]]",
            &[[2.0, 2.0], [5.0, 3.0], [5.0, 7.0]],
            &[[5.0, 5.0], [11.0, 5.0], [5.0, -1.0]],
        ),
        (
            "[[[170,-12],[190,-12],[190,12],[170,12],[170,-12]]]",
            &[[171.0, 0.0], [-171.0, 0.0], [179.9, 11.0]],
            &[[169.0, 0.0], [-169.0, 0.0], [0.0, 0.0], [180.0, 13.0]],
        ),
        (
            "[[[-180,70],[180,70],[180,90],[-180,90],[-180,70]]]",
            &[[0.0, 89.0], [-179.0, 71.0], [90.0, 80.0]],
            &[[0.0, 69.0], [179.0, -89.0]],
        ),
        (
            "[[[-180,-90],[180,-90],[180,-70],[-180,-70],[-180,-90]]]",
            &[[0.0, -89.0], [-179.0, -71.0], [90.0, -80.0]],
            &[[0.0, -69.0], [179.0, 89.0]],
        ),
        (
            "[[[10,60],[40,60],[40,90],[10,90],[10,60]]]",
            &[[11.0, 89.0], [39.0, 61.0]],
            &[[41.0, 89.0], [9.0, 61.0], [25.0, 59.0], [-155.0, 89.0]],
        ),
        (
            "[[[10,-90],[40,-90],[40,-60],[10,-60],[10,-90]]]",
            &[[11.0, -89.0], [39.0, -61.0]],
            &[[41.0, -89.0], [9.0, -61.0], [25.0, -59.0], [-155.0, -89.0]],
        ),
        (
            "[[[150,-90],[250,-90],[250,-60],[150,-60],[150,-90]]]",
            &[[151.0, -89.0], [-111.0, -61.0], [180.0, -80.0]],
            &[
                [149.0, -89.0],
                [0.0, -89.0],
                [170.0, -59.0],
                [-150.0, -59.0],
            ],
        ),
    ];

    fn is_right(outline: &Outline, inside: &[[f64; 2]], outside: &[[f64; 2]]) -> bool {
        // As the shader: 180° is −180°.
        let is_inside = |&[longitude, latitude]: &[f64; 2]| {
            let longitude = if longitude >= 180.0 {
                -180.0
            } else {
                longitude
            };
            outline.is_south_of_odd([longitude, latitude]) != outline.is_inside_in_the_south
        };
        inside.iter().all(is_inside) && !outside.iter().any(is_inside)
    }

    #[test]
    fn holes_the_antimeridian_and_both_poles_are_where_they_are() {
        for (coordinates, inside, outside) in CASES {
            let mesh = meshed(coordinates, EdgeRule::Planar);
            let outline = Outline::of(&BODY, &mesh).expect("has a shorter way");
            assert!(is_right(&outline, inside, outside), "{coordinates}");
            // Negative controls: the other side, and a line that is missing.
            let other = Outline {
                is_inside_in_the_south: !outline.is_inside_in_the_south,
                ..outline.clone()
            };
            assert!(!is_right(&other, inside, outside), "{coordinates}");
            let mut missing = outline;
            missing.lines.sort_by_key(Vec::len);
            missing.lines.pop();
            assert!(!is_right(&missing, inside, outside), "{coordinates}");
        }
    }

    #[test]
    fn bytes_are_those_of_the_formula() {
        let planar = CASES.map(|(coordinates, ..)| meshed(coordinates, EdgeRule::Planar));
        let great = [0, 1].map(|case| meshed(CASES[case].0, EdgeRule::GreatEllipse));
        for mesh in planar.iter().chain(&great) {
            for (format, position_bytes) in [(Format::F32, 8), (Format::F16, 4)] {
                let held = SceneOutlines::new(format, &BODY, [mesh]).expect("fits");
                let formula = outline_bytes(format, mesh);
                assert_eq!(held.bytes(), formula, "{:?}, {format:?}", mesh.extent);
                let last = held.ends.last().copied().map(u64::from);
                assert_eq!(last, Some(formula.vertex_bytes / position_bytes));
                // Negative control: a vertex more is a position more.
                let mut more = mesh.clone();
                let first = more.boundary_loops[0][0];
                more.boundary_loops[0].insert(1, first);
                let more = outline_bytes(format, &more);
                assert!(more.vertex_bytes >= formula.vertex_bytes + position_bytes);
            }
        }
    }

    #[test]
    fn an_edge_over_the_antimeridian_is_cut_there_and_one_of_half_a_turn_is_refused() {
        let lines = lines_of(&[[178.0, 0.0], [-178.0, 4.0], [179.0, 8.0]]).expect("short ways");
        let expected = [
            vec![[178.0, 0.0], [180.0, 2.0]],
            vec![[-180.0, 2.0], [-178.0, 4.0], [-180.0, 4.0 + 8.0 / 3.0]],
            vec![[180.0, 4.0 + 8.0 / 3.0], [179.0, 8.0], [178.0, 0.0]],
        ];
        assert_eq!(lines, expected);
        assert_eq!(lines_of(&[[-90.0, 0.0], [90.0, 1.0], [0.0, 9.0]]), None);
        // Control: a little shorter, and there is a way.
        assert!(lines_of(&[[-90.0, 0.0], [89.0, 1.0], [0.0, 9.0]]).is_some());
    }

    #[test]
    fn positions_are_kept_in_words() {
        let place = [-110.45, 10.18];
        let kept = |format: Format| {
            let mut words = Vec::new();
            format.push(&mut words, place);
            words
        };
        let floats: Vec<f32> = kept(Format::F32).into_iter().map(f32::from_bits).collect();
        assert_eq!(floats, place.map(|degrees| Format::F32.rounded(degrees)));
        // Of 64 to 128 a half has steps of 1/16, of 8 to 16 of 1/128; longitude in the low half.
        assert_eq!(Format::F16.rounded(place[0]), -110.4375);
        let [word] = kept(Format::F16)[..] else {
            panic!("one word");
        };
        let halves = [word & 0xffff, word >> 16].map(|bits| {
            let bits = u16::try_from(bits).expect("16 bits");
            half::f16::from_bits(bits).to_f32()
        });
        assert_eq!(halves, place.map(|degrees| Format::F16.rounded(degrees)));
        assert_ne!(halves[0], floats[0]);
    }
}
