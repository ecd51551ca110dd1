// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rings that cross themselves or one another: every crossing becomes a vertex.
//!
//! A crossing that is a vertex of both edges is no crossing any more but a touch, which the even-odd
//! rule fills without ambiguity. Real files need this: at 1:110m a vertex of Sudan's outline that was
//! meant to lie on another of its edges lies 5.7e-14° (6 nm) beyond it, and by exact arithmetic that
//! is a crossing.

use crate::antimeridian::{AtAntimeridian, crossings_at_antimeridian};
use crate::crossings::{CrossingPlaces, MAX_ROUNDS, distance, find_crossings};
use crate::edge::Degrees;
use crate::pieces::{Piece, pieces_as_compared};
use crate::{EdgePlace, EdgeRule, Polygon, Region, Repair, Ring, WarningSubject};
use terrafill_planar::intersection::Crossing;

/// Crossings to those of an earlier round from which on there is no end of them.
const MAX_GROWTH: usize = 2;

impl Region {
    /// Makes of rings that cross or overlap what `repair` says, so that the region can be meshed, as
    /// [`Region::split_at_crossings`] does for [`Repair::EvenOdd`].
    pub fn repair(&mut self, repair: Repair, rule: EdgeRule) {
        if repair == Repair::KeepShells {
            let holes: usize = self
                .polygons
                .iter()
                .map(|polygon| polygon.holes.len())
                .sum();
            for polygon in &mut self.polygons {
                polygon.holes.clear();
            }
            if holes > 0 {
                let noun = if holes == 1 { "hole was" } else { "holes were" };
                let text = format!("{holes} {noun} left out: only shells are kept");
                self.warnings.push(WarningSubject::Repair.warn(text));
            }
        }
        self.split_all(repair, rule);
    }

    /// Makes a vertex of every place where two edges cross, so that the region can be meshed and is
    /// filled by the even-odd rule; returns how many there were and notes them in
    /// [`Region::warnings`]. Parts that overlap without crossing are filled by that rule as well:
    /// the mesh notes them, which finds them.
    ///
    /// Edges are compared where they lie on the body, whichever turn they were written in.
    pub fn split_at_crossings(&mut self, rule: EdgeRule) -> usize {
        self.split_all(Repair::EvenOdd, rule)
    }

    fn split_all(&mut self, repair: Repair, rule: EdgeRule) -> usize {
        let mut total = 0;
        if let Some(without) = self.without_collapsed(rule) {
            *self = without;
        }
        self.repaired = Some(repair);
        let mut fewest = usize::MAX;
        for _ in 0..MAX_ROUNDS {
            let found = self.split_once(rule);
            total += found;
            // Edges that are one to rounding cross more often with every place that they are split at.
            if found == 0 || found > fewest.saturating_mul(MAX_GROWTH) {
                break;
            }
            fewest = fewest.min(found);
        }
        if total > 0 {
            let plural = if total == 1 { "" } else { "s" };
            let text = format!("{total} crossing{plural} of edges: {}", repair.effect());
            self.warnings.push(WarningSubject::Repair.warn(text));
        }
        total
    }

    fn split_once(&mut self, rule: EdgeRule) -> usize {
        let FoundCrossings {
            pieces,
            crossings,
            edges,
            at_cuts,
        } = self.find_crossings(rule, usize::MAX);
        if crossings.is_empty() && at_cuts.is_empty() {
            return 0;
        }
        let several_turns = pieces.iter().any(|piece| piece.piece.turns != 0.0);
        let mut inserted: Vec<Vec<Insertion>> = self.rings().map(|_| Vec::new()).collect();
        for (pair, at) in &crossings {
            let at = if several_turns {
                [round_for_turning(at[0]), at[1]]
            } else {
                *at
            };
            for &index in pair {
                let RingPiece { ring, piece } = &pieces[index];
                let [start, at] = [piece.start, at].map(|place| piece_as_written(piece, place));
                inserted[*ring].push(Insertion {
                    vertex: piece.vertex,
                    piece: index,
                    distance: distance(rule, start, at),
                    at,
                });
            }
        }
        for &(pair, [_, latitude]) in &at_cuts {
            for index in pair.map(|index| edges[index]) {
                let RingPiece { ring, piece } = &pieces[index];
                // The end of a piece that is cut there; a place on one that runs along it.
                let at = [piece.end[0], latitude];
                inserted[*ring].push(Insertion {
                    vertex: piece.vertex,
                    piece: index,
                    distance: distance(rule, piece.start, at),
                    at: piece_as_written(piece, at),
                });
            }
        }
        keep_cuts(&pieces, &mut inserted);
        let rings = self
            .polygons
            .iter_mut()
            .flat_map(|polygon| std::iter::once(&mut polygon.shell).chain(&mut polygon.holes));
        for (ring, mut insertions) in rings.zip(inserted) {
            if !insertions.is_empty() {
                let key = |new: &Insertion| (new.vertex, new.piece);
                insertions.sort_by(|a, b| {
                    let by_piece = key(a).cmp(&key(b));
                    by_piece.then(a.distance.total_cmp(&b.distance))
                });
                *ring = with_insertions(ring, &insertions);
            }
        }
        crossings.len() + at_cuts.len()
    }

    /// Whether any two edges cross, compared where they lie on the body.
    pub(crate) fn has_crossings(&self, rule: EdgeRule) -> bool {
        let found = self.find_crossings(rule, 1);
        !(found.crossings.is_empty() && found.at_cuts.is_empty())
    }

    /// Up to `most` places where arcs cross, as the file has its edges.
    pub(crate) fn arc_crossings(&self, most: usize) -> Vec<CrossingPlaces> {
        let rings_of = |(index, polygon): (usize, &Polygon)| {
            (0..polygon.rings().count()).map(move |ring| (index, ring))
        };
        let rings: Vec<(usize, usize)> = self
            .polygons
            .iter()
            .enumerate()
            .flat_map(rings_of)
            .collect();
        let found = self.find_crossings(EdgeRule::GreatEllipse, most);
        let place = |index: usize| {
            let RingPiece { ring, piece } = &found.pieces[index];
            let (polygon, ring) = rings[*ring];
            let vertex = piece.vertex;
            EdgePlace {
                polygon,
                ring,
                vertex,
            }
        };
        let places = found.crossings.iter().map(|(pair, at)| {
            let [a, b] = pair.map(place);
            CrossingPlaces::of([a, b], *at)
        });
        places.collect()
    }

    /// Up to `most` of those between cuts and as many of those on the antimeridian.
    fn find_crossings(&self, rule: EdgeRule, most: usize) -> FoundCrossings {
        let pieces: Vec<RingPiece> = self
            .rings()
            .enumerate()
            .flat_map(|(ring, found)| {
                let pieces = pieces_as_compared(rule, found);
                pieces
                    .into_iter()
                    .map(move |piece| RingPiece { ring, piece })
            })
            .collect();
        let ends: Vec<[Degrees; 2]> = pieces.iter().map(RingPiece::ends).collect();
        let (crossings, _) = find_crossings(rule, &ends, most);
        let (edges, at_antimeridian) = self.at_antimeridian(rule, &pieces);
        let at_cuts = crossings_at_antimeridian(rule, &at_antimeridian, most);
        FoundCrossings {
            pieces,
            crossings,
            edges,
            at_cuts,
        }
    }

    /// Pieces that end in a cut at the antimeridian or run along it, by their position too.
    fn at_antimeridian(
        &self,
        rule: EdgeRule,
        pieces: &[RingPiece],
    ) -> (Vec<usize>, Vec<AtAntimeridian>) {
        if rule == EdgeRule::GreatEllipse {
            // Whole arcs are compared.
            return (Vec::new(), Vec::new());
        }
        let rings: Vec<&Ring> = self.rings().collect();
        let of_piece = |index: usize| {
            let RingPiece { ring, piece } = &pieces[index];
            let next = pieces.get(index + 1).filter(|next| next.ring == *ring);
            let next = next.map_or(*piece, |next| next.piece);
            AtAntimeridian::of(rings[*ring], &[*piece, next]).map(|found| (index, found))
        };
        (0..pieces.len()).filter_map(of_piece).unzip()
    }
}

/// Crossings of a region's edges.
struct FoundCrossings {
    pieces: Vec<RingPiece>,
    /// Of two pieces.
    crossings: Vec<Crossing>,
    /// Pieces that are cut at the antimeridian or run along it.
    edges: Vec<usize>,
    /// Of two of those, on the antimeridian.
    at_cuts: Vec<Crossing>,
}

/// Part of a ring between two cuts at the antimeridian.
struct RingPiece {
    ring: usize,
    piece: Piece,
}

impl RingPiece {
    fn ends(&self) -> [Degrees; 2] {
        [self.piece.start, self.piece.end]
    }
}

/// A place on a piece as its file would write it.
fn piece_as_written(piece: &Piece, [longitude, latitude]: Degrees) -> Degrees {
    [longitude + 360.0 * piece.turns, latitude]
}

/// To the nearest multiple of 2⁻⁴³ degrees (12 nm on the Earth): the last place of numbers up to
/// 1,024, so that whole turns can be added and taken away without rounding.
fn round_for_turning(longitude_deg: f64) -> f64 {
    let unit = 1.0 / (1_u64 << 43) as f64;
    (longitude_deg / unit).round() * unit
}

/// Makes vertices of the places where edges that get new vertices were cut at the antimeridian: cut
/// again from a new vertex, they would be cut a rounding away, and could cross again.
fn keep_cuts(pieces: &[RingPiece], inserted: &mut [Vec<Insertion>]) {
    let mut split: Vec<(usize, usize)> = inserted
        .iter()
        .enumerate()
        .flat_map(|(ring, new)| new.iter().map(move |new| (ring, new.vertex)))
        .collect();
    split.sort_unstable();
    for (index, pair) in pieces.windows(2).enumerate() {
        let [before, after] = pair else { continue };
        let edge = (before.ring, before.piece.vertex);
        let is_cut = edge == (after.ring, after.piece.vertex);
        if is_cut && split.binary_search(&edge).is_ok() {
            inserted[edge.0].push(Insertion {
                vertex: edge.1,
                piece: index,
                distance: f64::INFINITY,
                at: piece_as_written(&before.piece, before.piece.end),
            });
        }
    }
}

/// A new vertex.
struct Insertion {
    /// Vertex that its edge starts at.
    vertex: usize,
    /// Pieces of an edge have growing numbers.
    piece: usize,
    /// From the piece's start.
    distance: f64,
    at: Degrees,
}

fn with_insertions(ring: &Ring, insertions: &[Insertion]) -> Ring {
    let mut waiting = insertions.iter().peekable();
    // With their longitudes as the file has them.
    let mut vertices: Vec<(Degrees, f64)> =
        Vec::with_capacity(ring.vertices_deg().len() + insertions.len());
    for (vertex, start) in ring.vertices_deg().iter().enumerate() {
        vertices.push((*start, ring.written_longitude_deg(vertex)));
        while let Some(Insertion { at, .. }) = waiting.next_if(|new| new.vertex == vertex) {
            vertices.push((*at, at[0]));
        }
    }
    // Rounding may put a crossing on the end of its edge.
    vertices.dedup_by_key(|(position, _)| *position);
    let winding_deg = ring.winding_deg();
    let ([west, first_latitude], _) = vertices[0];
    while vertices.len() > 1
        && vertices[vertices.len() - 1].0 == [west + winding_deg, first_latitude]
    {
        vertices.pop();
    }
    let (vertices, written) = vertices.into_iter().unzip();
    Ring::from_checked(vertices, winding_deg)
        .with_written_longitudes(written)
        .after_dropped(ring.file_ring(0))
        .after_dropped_parts(ring.file_polygon(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ellipsoid, MeshError, MeshOptions, RegionMesh};
    use terrafill_fixtures::random_numbers;

    fn region(rings: &[&[Degrees]]) -> Region {
        let polygons = rings
            .iter()
            .map(|ring| Polygon {
                shell: Ring::from_checked(ring.to_vec(), 0.0),
                holes: Vec::new(),
            })
            .collect();
        Region {
            name: "test".to_owned(),
            polygons,
            ..Region::default()
        }
    }

    fn build(region: &Region, rule: EdgeRule) -> Result<RegionMesh, MeshError> {
        let body = Ellipsoid::WGS84;
        let mesh = RegionMesh::build(region, &body, rule, &MeshOptions::default())?;
        assert_eq!(mesh.check_invariants(&body), Ok(()));
        Ok(mesh)
    }

    #[test]
    fn a_pentagram_is_refused_and_repaired_to_its_five_points() {
        let star: Vec<Degrees> = (0..5)
            .map(|k| {
                let angle = std::f64::consts::TAU * f64::from(2 * k) / 5.0;
                [10.0 + angle.cos(), 5.0 + angle.sin()]
            })
            .collect();
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let mut region = region(&[&star]);
            assert!(matches!(
                build(&region, rule),
                Err(MeshError::SelfCrossing { .. })
            ));
            assert_eq!(region.split_at_crossings(rule), 5);
            assert_eq!(
                region.warnings,
                ["5 crossings of edges: filled by the even-odd rule"]
            );
            let mesh = build(&region, rule).expect("repaired");
            // Even-odd leaves the pentagon in the middle empty: one loop of ten would fill it.
            assert_eq!(mesh.triangle_count(), 5, "{}", rule.name());
            assert_eq!(mesh.boundary_edge_count(), 15);
        }
    }

    #[test]
    fn arcs_that_cross_are_refused_whatever_the_tolerance() {
        // The northern edges meet at this latitude; the southern one rises to 50.43° there.
        let ring = |latitude: f64| {
            let vertices = [
                [0.0, 50.0],
                [20.0, 50.0],
                [20.0, 51.0],
                [10.0, latitude],
                [0.0, 51.0],
            ];
            region(&[&vertices])
        };
        let body = Ellipsoid::WGS84;
        for boundary_tolerance_m in [1.0, 1_000.0, 100_000.0] {
            let options = MeshOptions {
                boundary_tolerance_m,
                ..MeshOptions::default()
            };
            let build = |region: &Region, rule| RegionMesh::build(region, &body, rule, &options);
            let error = build(&ring(50.2), EdgeRule::GreatEllipse).expect_err("crosses");
            let MeshError::SelfCrossing {
                first,
                second,
                longitude_deg,
                latitude_deg,
                ..
            } = error
            else {
                panic!("{error}");
            };
            assert_eq!([first.vertex, second.vertex], [0, 2]);
            assert!((10.0..20.0).contains(&longitude_deg), "{longitude_deg}");
            assert!((50.2..50.43).contains(&latitude_deg), "{latitude_deg}");
            let mut repaired = ring(50.2);
            assert_eq!(repaired.split_at_crossings(EdgeRule::GreatEllipse), 2);
            assert!(build(&repaired, EdgeRule::GreatEllipse).is_ok());
            // Negative controls: north of the arc, and as straight lines.
            assert!(build(&ring(50.5), EdgeRule::GreatEllipse).is_ok());
            assert!(build(&ring(50.2), EdgeRule::Planar).is_ok());
        }
    }

    #[test]
    fn a_coast_beside_an_arc_is_refused_if_and_only_if_it_crosses() {
        let body = Ellipsoid::WGS84;
        let options = MeshOptions {
            boundary_tolerance_m: 1e6,
            ..MeshOptions::default()
        };
        let refused = |region: &Region| {
            let mesh = RegionMesh::build(region, &body, EdgeRule::GreatEllipse, &options);
            matches!(mesh, Err(MeshError::SelfCrossing { .. }))
        };
        let crosses = |region: &Region| {
            let mut repaired = region.clone();
            repaired.split_at_crossings(EdgeRule::GreatEllipse) > 0
        };
        // The vertex in the lens, the ninth, is no corner of the flat triangle beside the arc.
        let mut coast = [
            [0.0, 43.277497375078475],
            [20.0, 46.21451845788132],
            [20.4, 48.391826798273875],
            [18.980727227641424, 46.245925428100115],
            [18.565376967027948, 46.12708654088134],
            [17.631383745950796, 46.23916743601111],
            [10.50224075214462, 45.47812084202469],
            [7.454906021571159, 45.02616318057405],
            [6.267840171578126, 44.75601674820085],
            [5.262381147082305, 44.432816572977956],
            [1.669926304579843, 43.76847933253629],
            [-0.4, 45.45480571547103],
        ];
        assert!(refused(&region(&[&coast])) && crosses(&region(&[&coast])));
        for vertex in &mut coast[3..11] {
            vertex[1] += 0.2;
        }
        assert!(!refused(&region(&[&coast])) && !crosses(&region(&[&coast])));

        let mut random = random_numbers(11);
        let mut crossing = 0;
        for round in 0..2_000 {
            let width = [1.0, 5.0, 20.0, 60.0][round % 4];
            let (south, slope) = (10.0 + 50.0 * random(), 0.3 * (random() - 0.5));
            let bow = width * width * 0.001 * (2.0 * south.to_radians()).sin();
            let mut eastings: Vec<f64> = (0..3 + round % 9).map(|_| random()).collect();
            eastings.sort_by(|a, b| b.total_cmp(a));
            let mut ring = vec![[0.0, south], [width, south + slope * width]];
            ring.push([1.02 * width, south + slope * width + 6.0 * bow]);
            for share in eastings {
                let height = bow * (4.5 * share * (1.0 - share) + 0.3 * random());
                ring.push([share * width, south + slope * share * width + height]);
            }
            ring.push([-0.02 * width, south + 6.0 * bow]);
            let region = region(&[&ring]);
            assert_eq!(refused(&region), crosses(&region), "{ring:?}");
            crossing += u32::from(crosses(&region));
        }
        // Negative control: there were both.
        assert!((200..1_800).contains(&crossing), "{crossing}");
    }

    #[test]
    fn polygons_that_overlap_are_filled_where_an_odd_number_of_them_is() {
        let a = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let b = a.map(|[x, y]| [x + 1.0, y + 1.0]);
        let mut region = region(&[&a, &b]);
        assert_eq!(region.split_at_crossings(EdgeRule::Planar), 2);
        let mesh = build(&region, EdgeRule::Planar).expect("repaired");
        let square = |south: f64, width: f64| {
            Ellipsoid::WGS84.quadrangle_area_m2(
                width.to_radians(),
                south.to_radians(),
                (south + 1.0).to_radians(),
            )
        };
        let exact = square(0.0, 2.0) + 2.0 * square(1.0, 1.0) + square(2.0, 2.0);
        assert!((mesh.area_m2 / exact - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rings_written_a_turn_apart_cross_all_the_same() {
        let a = [[170.0, 0.0], [190.3, 0.1], [190.1, 10.0], [170.0, 10.0]];
        let b = [[175.0, 5.0], [195.0, 5.7], [195.2, 15.0], [175.0, 15.3]];
        let shifted = |ring: &[Degrees; 4], turn: f64| ring.map(|[x, y]| [x + 360.0 * turn, y]);
        let mut areas = Vec::new();
        for turn in [0.0, -1.0] {
            let mut region = region(&[&a, &shifted(&b, turn)]);
            assert!(matches!(
                build(&region, EdgeRule::Planar),
                Err(MeshError::SelfCrossing { .. })
            ));
            assert_eq!(region.split_at_crossings(EdgeRule::Planar), 2, "{turn}");
            // Where the edges were cut stays a vertex of those that were split.
            let mesh = build(&region, EdgeRule::Planar).expect("repaired");
            areas.push(mesh.area_m2);
        }
        assert!((areas[0] / areas[1] - 1.0).abs() < 1e-12, "{areas:?}");
        // Negative control: apart on the body, they do not cross, though their longitudes overlap modulo a
        // smaller angle than a turn.
        let mut apart = region(&[&a, &shifted(&b, -0.5)]);
        assert_eq!(apart.split_at_crossings(EdgeRule::Planar), 0);
    }

    #[test]
    fn random_rings_a_turn_apart_mesh_once_they_are_split() {
        let mut random = random_numbers(5);
        let mut crossings = 0;
        for _ in 0..200 {
            let mut ring = |west: f64| -> Vec<Degrees> {
                let vertex = |_| [west + 20.0 * random(), 30.0 * random()];
                (0..6).map(vertex).collect()
            };
            let mut region = region(&[&ring(170.0), &ring(-190.0), &ring(170.0)]);
            crossings += region.split_at_crossings(EdgeRule::Planar);
            build(&region, EdgeRule::Planar).expect("repaired");
        }
        assert!(crossings > 2_000, "{crossings}");
    }

    #[test]
    fn every_crossing_of_a_region_is_listed_up_to_a_bound() {
        let zigzag = |count: u32, turned: bool| -> Vec<Degrees> {
            // Long teeth, closed by a way round that touches nothing; each of them crosses each of
            // those turned by 90°.
            let tooth = |k: u32| {
                [
                    f64::from(k) * 0.1 + 1.0,
                    if k.is_multiple_of(2) { 0.25 } else { 44.5 },
                ]
            };
            let mut ring: Vec<Degrees> = (0..2 * count).map(tooth).collect();
            ring.push([f64::from(2 * count) * 0.1 + 2.0, 0.0]);
            ring.push([0.0, 0.0]);
            if turned {
                for vertex in &mut ring {
                    vertex.swap(0, 1);
                }
            }
            ring
        };
        for (count, listed, more, counted_all) in [
            (3, 36, 0, true),
            (20, 100, 1_500, true),
            (80, 100, 9_992, false),
        ] {
            let region = region(&[&zigzag(count, false), &zigzag(count, true)]);
            let errors = RegionMesh::build_all(
                std::slice::from_ref(&region),
                &Ellipsoid::WGS84,
                EdgeRule::Planar,
                &MeshOptions::default(),
            )
            .expect_err("teeth cross");
            let place = |error: &MeshError| match error {
                MeshError::SelfCrossing { first, .. } => Some(*first),
                _ => None,
            };
            let crossings: Vec<_> = errors.iter().filter_map(place).collect();
            assert_eq!(crossings.len(), listed, "{errors:?}");
            assert!(crossings.is_sorted());
            let found = errors.iter().find_map(|error| match error {
                MeshError::MoreCrossings {
                    more, counted_all, ..
                } => Some((*more, *counted_all)),
                _ => None,
            });
            let expected = (more > 0).then_some((more, counted_all));
            assert_eq!(found, expected, "{count}");
            // The repair finds as many.
            if counted_all {
                let mut repaired = region.clone();
                assert_eq!(repaired.split_at_crossings(EdgeRule::Planar), listed + more);
            }
        }
    }

    #[test]
    fn what_does_not_cross_is_left_alone() {
        let touching = [
            [0.0, 0.0],
            [1.0, 1.0],
            [2.0, 2.0],
            [2.0, 0.0],
            [1.0, 1.0],
            [0.0, 2.0],
        ];
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let mut region = region(&[&touching]);
            let mut before = region.clone();
            assert_eq!(region.split_at_crossings(rule), 0);
            before.repaired = Some(Repair::EvenOdd);
            assert_eq!(region, before);
        }
    }
}
