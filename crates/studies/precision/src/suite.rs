// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures: formulas, regions, views and how many places of each.

use crate::kernel::Kernels;
use crate::row::PrecisionRow;
use crate::{coordinate, place, position, routes, sight, special, vertex};
use terrafill_gpu::{Gpu, GpuOptions};
use terrafill_study::StudyError;
use terrafill_texture::{CoordinateRoute, PositionRoute, VertexFormat};

/// Places of a region and of a view at which errors are measured.
const POINTS: u32 = 600;
const QUICK_POINTS: u32 = 200;

/// Formulas, and the conditions under which each is measured.
#[derive(Debug)]
pub(crate) struct Suite {
    pub(crate) routes: Vec<CoordinateRoute>,
    pub(crate) places: Vec<place::RegionPicture>,
    /// What a frame plan takes in each of them.
    pub(crate) chosen: Vec<Option<CoordinateRoute>>,
    pub(crate) sights: Vec<sight::ProbeView>,
    pub(crate) points: u32,
}

/// One condition: all its formulas are measured at once.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Condition {
    /// A region, by its place in [`Suite::places`].
    Place(usize),
    /// An input where formulas break.
    Special(&'static special::Special),
    /// A view, by its place in [`Suite::sights`].
    Sight(usize),
    /// Vertices of a region, from a distance.
    Vertex(vertex::Seen),
}

impl Suite {
    /// The whole suite, or enough of it to see that it works.
    pub(crate) fn new(quick: bool) -> Self {
        let places = place::places(quick);
        let chosen = routes::chosen(&places);
        let mut routes = routes::coordinate_routes(quick);
        for route in chosen.iter().flatten() {
            if !routes.contains(route) {
                routes.push(*route);
            }
        }
        Self {
            routes,
            places,
            chosen,
            sights: sight::sights(quick),
            points: if quick { QUICK_POINTS } else { POINTS },
        }
    }

    /// Every condition.
    pub(crate) fn conditions(&self) -> Vec<Condition> {
        let places = (0..self.places.len()).map(Condition::Place);
        let specials = special::INPUTS.iter().map(Condition::Special);
        let sights = (0..self.sights.len()).map(Condition::Sight);
        let vertices = vertex::conditions().map(Condition::Vertex);
        places
            .chain(specials)
            .chain(sights)
            .chain(vertices)
            .collect()
    }

    /// Rows of a condition before anything is measured.
    pub(crate) fn identities(&self, condition: &Condition) -> Vec<PrecisionRow> {
        let routes = self.routes.iter();
        match condition {
            Condition::Place(index) => {
                let place = &self.places[*index];
                let identity = |route| coordinate::identity(place, route);
                routes.map(identity).collect()
            }
            Condition::Special(input) => {
                let identity = |route| special::identity(input, route);
                routes.map(identity).collect()
            }
            Condition::Sight(index) => {
                let sight = &self.sights[*index];
                PositionRoute::ALL
                    .map(|route| position::identity(sight, route))
                    .into()
            }
            Condition::Vertex(seen) => VertexFormat::ALL
                .map(|format| vertex::identity(format, *seen))
                .into(),
        }
    }

    /// The same rows measured.
    ///
    /// # Errors
    /// A device that is lost. What a device cannot run becomes rows with the reason.
    pub(crate) fn rows(
        &self,
        condition: &Condition,
        kernels: &Kernels,
    ) -> Result<Vec<PrecisionRow>, StudyError> {
        match condition {
            Condition::Place(index) => {
                let (place, chosen) = (&self.places[*index], self.chosen[*index]);
                coordinate::rows(place, chosen, self.points, kernels)
            }
            Condition::Special(input) => special::rows(input, kernels),
            Condition::Sight(index) => position::rows(&self.sights[*index], self.points, kernels),
            Condition::Vertex(seen) => Ok(vertex::rows(*seen)),
        }
    }
}

/// Errors of the whole suite, without times, on the device there is.
///
/// # Errors
/// [`StudyError::NoDevice`], or a device that is lost.
pub fn measure_suite() -> Result<Vec<PrecisionRow>, StudyError> {
    let gpu = Gpu::open(&GpuOptions::default());
    let gpu = gpu.map_err(|error| StudyError::NoDevice(error.to_string()))?;
    let suite = Suite::new(false);
    let kernels = Kernels::new(&gpu, &suite.routes);
    let mut rows = Vec::new();
    for condition in suite.conditions() {
        rows.extend(suite.rows(&condition, &kernels)?);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{TimedFormula, coordinate_evaluator};
    use crate::metrics::{
        CHOSEN, DEVICE_MAX_M, EMULATED_MAX_M, EXPECTED_MAX_RAD, MAX_PX, NON_FINITE_DEVICE,
        NON_FINITE_EMULATED, OPERATIONS_COST,
    };
    use crate::row::PrecisionPart;
    use crate::suite_findings;
    use terrafill_gpu::open_for_test;
    use terrafill_results::Status;
    use terrafill_texture::{Chooser, CoordinateRoute, SuiteFinding};

    /// A few routes in two regions, seen from two distances.
    fn small() -> Suite {
        let names = [
            "atan2-native",
            "odd-7",
            "recentred-odd-11",
            "lut-256-r32f-linear",
            "gnomonic-3",
        ];
        let places = [("0", 0.0, 0.0), ("+9km", 0.0, 9_000.0)];
        let places: Vec<place::RegionPicture> = places
            .iter()
            .filter_map(|heights| place::RegionPicture::new(1.0, 45.0, *heights))
            .collect();
        let gnomonic = CoordinateRoute::parse("gnomonic-3");
        Suite {
            chosen: vec![gnomonic; places.len()],
            places,
            routes: names
                .iter()
                .filter_map(|name| CoordinateRoute::parse(name))
                .collect(),
            sights: sight::sights(true).into_iter().take(2).collect(),
            points: 60,
        }
    }

    fn row<'a>(rows: &'a [PrecisionRow], route: &str, condition: &str) -> &'a PrecisionRow {
        let found = rows
            .iter()
            .find(|row| row.route.starts_with(route) && row.condition.contains(condition));
        found.unwrap_or_else(|| panic!("{route}, {condition}"))
    }

    #[test]
    fn every_planned_row_is_measured_under_its_name() {
        let Some(gpu) = open_for_test(&GpuOptions::default()) else {
            return;
        };
        let suite = small();
        assert_eq!(suite.routes.len(), 5);
        let kernels = Kernels::new(&gpu, &suite.routes);
        let mut rows = Vec::new();
        for condition in suite.conditions() {
            let measured = suite.rows(&condition, &kernels).expect("runs");
            let ids =
                |rows: &[PrecisionRow]| -> Vec<_> { rows.iter().map(|row| row.id()).collect() };
            let (mut planned, mut found) = (ids(&suite.identities(&condition)), ids(&measured));
            planned.sort_unstable();
            found.sort_unstable();
            assert_eq!(planned, found, "{condition:?}");
            rows.extend(measured);
        }
        for row in &rows {
            let name = row.id();
            assert_ne!(row.status, Status::Skipped, "{name}: {}", row.reason);
            let says_why = row.status == Status::Ok || !row.reason.is_empty();
            assert!(says_why, "{name}");
        }
        // Known sizes: a gnomonic cubic on one degree is off by less than a metre on the surface, odd
        // degree 7 in absolute angles by hundreds of metres.
        let gnomonic = row(&rows, "gnomonic-3", "heights=0");
        let absolute = row(&rows, "odd-7", "heights=0");
        assert!(gnomonic.figure(DEVICE_MAX_M).expect("measured") < 1.0);
        assert!((200.0..1200.0).contains(&absolute.figure(DEVICE_MAX_M).expect("measured")));
        assert!(gnomonic.figure(OPERATIONS_COST).is_some());
        let chosen = rows
            .iter()
            .filter(|row| row.figure(CHOSEN) == Some(1.0))
            .count();
        assert_eq!(chosen, 2, "one in each region");
        let verdict = gnomonic.verdict();
        let figure = |name: &str| verdict.figures.iter().find(|(of, _)| *of == name);
        assert_eq!(
            figure("device_max_m").map(|f| Some(f.1)),
            Some(gnomonic.figure(DEVICE_MAX_M))
        );
        assert_eq!(
            figure("expected_max_rad").map(|f| Some(f.1)),
            Some(gnomonic.figure(EXPECTED_MAX_RAD))
        );
        assert!(rows.iter().any(|row| row.part == PrecisionPart::Special));
    }

    #[test]
    fn every_formula_is_timed_on_the_device() {
        let Some(gpu) = open_for_test(&GpuOptions::default()) else {
            return;
        };
        let suite = small();
        let mut kernels = Kernels::new(&gpu, &suite.routes);
        kernels.prepare_timing().expect("fits");
        assert!(kernels.time_empty().expect("runs").cpu_ms > 0.0);
        let timed = TimedFormula::all(&suite.routes);
        assert_eq!(
            timed.len(),
            5 + 9,
            "five routes, three positions by three mappings"
        );
        for formula in &timed {
            let time = kernels.time(formula).expect("runs");
            assert!(
                time.cpu_ms > 0.0 && time.evaluations > 0,
                "{}",
                formula.name()
            );
        }
        // Negative control: what was not compiled has no time.
        let other = CoordinateRoute::parse("planes").expect("a route");
        assert!(kernels.time(&TimedFormula::Coordinate(other)).is_err());
    }

    /// Rows of the small suite's first region, with the device's text of one route replaced.
    fn rows_with(replace: impl Fn(&str) -> String) -> Option<Vec<PrecisionRow>> {
        let gpu = open_for_test(&GpuOptions::default())?;
        let suite = small();
        let mut kernels = Kernels::new(&gpu, &suite.routes);
        let odd = kernels
            .coordinate
            .iter_mut()
            .find(|k| k.route.name().starts_with("odd-7"));
        let odd = odd.expect("in the suite");
        let text = replace(&odd.program.wgsl());
        odd.device = coordinate_evaluator(&gpu, "odd-7", &odd.program, &text);
        Some(coordinate::rows(&suite.places[0], None, suite.points, &kernels).expect("runs"))
    }

    #[test]
    fn a_wrong_coefficient_on_the_device_is_noticed() {
        let Some(right) = rows_with(str::to_owned) else {
            return;
        };
        assert_eq!(row(&right, "odd-7", "").status, Status::Ok);
        let wrong = rows_with(|text| {
            let wrong = text.replace("0.14626446f", "0.15626446f");
            assert_ne!(wrong, text, "the coefficient is in the text");
            wrong
        });
        let wrong = wrong.expect("a device");
        let odd = row(&wrong, "odd-7", "");
        assert_eq!(odd.status, Status::Wrong);
        assert!(odd.reason.contains("above its bound"), "{}", odd.reason);
        assert!(
            odd.figure(EMULATED_MAX_M) < odd.figure(DEVICE_MAX_M),
            "the emulation has the right one"
        );
    }

    #[test]
    fn answers_that_are_not_finite_and_texts_that_do_not_compile_are_said() {
        let nan = rows_with(|text| {
            text.replace("return vec2f(", "return sqrt(-1.0 - abs(d.x)) * vec2f(")
        });
        let Some(nan) = nan else { return };
        let odd = row(&nan, "odd-7", "");
        assert_eq!(
            odd.figure(NON_FINITE_DEVICE),
            odd.figure(crate::metrics::POINTS)
        );
        assert_eq!(
            (odd.figure(NON_FINITE_EMULATED), odd.status),
            (Some(0.0), Status::Wrong)
        );
        assert_eq!(odd.figure(DEVICE_MAX_M), None, "no number stands for it");
        let broken = rows_with(|text| text.replace("return", "retrun")).expect("a device");
        let odd = row(&broken, "odd-7", "");
        assert_eq!(odd.status, Status::Skipped);
        assert!(odd.reason.contains("not on this device") && odd.figure(EMULATED_MAX_M).is_some());
    }

    /// Every row of these routes at one extent and latitude, whatever the heights, and at the special
    /// inputs; the device's text of each route as `replace` has it.
    fn cell_rows(
        routes: &[CoordinateRoute],
        cell: (f64, f64),
        replace: impl Fn(&str) -> String,
    ) -> Option<Vec<PrecisionRow>> {
        let gpu = open_for_test(&GpuOptions::default())?;
        let mut kernels = Kernels::new(&gpu, routes);
        for kernel in &mut kernels.coordinate {
            let text = replace(&kernel.program.wgsl());
            kernel.device = coordinate_evaluator(&gpu, "replaced", &kernel.program, &text);
        }
        let places = place::places(false).into_iter();
        let here = places.filter(|place| (place.extent_deg, place.latitude_deg) == cell);
        let mut rows = Vec::new();
        for place in here {
            let of_place = coordinate::rows(&place, None, POINTS, &kernels);
            rows.extend(of_place.expect("runs"));
        }
        for input in &special::INPUTS {
            rows.extend(special::rows(input, &kernels).expect("runs"));
        }
        Some(rows)
    }

    #[test]
    fn a_part_of_the_checked_in_findings_is_found_again() {
        let routes = [
            "near-odd-7+bowring-1",
            "near-rat-0-1+bowring-1",
            "odd-11+bowring-1",
            "planes",
        ];
        let routes = routes.map(|name| CoordinateRoute::parse(name).expect("a route"));
        let mut listed = 0;
        for cell in [(90.0, 45.0), (10.0, 45.0)] {
            let Some(rows) = cell_rows(&routes, cell, str::to_owned) else {
                return;
            };
            let found = suite_findings(&rows);
            let of_cell = |finding: &SuiteFinding| {
                routes.contains(&finding.route)
                    && (finding.cell.extent_deg, finding.cell.latitude_deg) == cell
            };
            let checked_in = SuiteFinding::checked_in().into_iter();
            let checked_in: Vec<SuiteFinding> = checked_in.filter(of_cell).collect();
            assert_eq!(
                SuiteFinding::table(&found),
                SuiteFinding::table(&checked_in)
            );
            listed += checked_in.len();
        }
        assert!(listed > 0, "nothing was compared");
    }

    #[test]
    fn a_route_that_the_device_gets_wrong_is_listed_and_the_next_one_is_taken() {
        let place = place::RegionPicture::new(1.0, 45.0, ("+9km", 0.0, 9_000.0)).expect("bounds");
        let demand = place.demand();
        let chosen = |findings: Vec<SuiteFinding>| {
            let candidates = Chooser::default_candidates();
            let chooser = Chooser::new(&candidates, findings);
            chooser.choose(&demand).chosen.expect("a route").route
        };
        let first = chosen(Vec::new());
        let rows = |replace: fn(&str) -> String| cell_rows(&[first], (1.0, 45.0), replace);
        let Some(right) = rows(str::to_owned) else {
            return;
        };
        assert_eq!(suite_findings(&right), []);
        for planted in [
            (|text| text.replace("return vec2f(", "return 1.01 * vec2f(")) as fn(&str) -> String,
            |text| text.replace("return vec2f(", "return sqrt(-1.0 - abs(d.x)) * vec2f("),
        ] {
            let found = suite_findings(&rows(planted).expect("a device"));
            assert_eq!(found.len(), 1, "{found:?}");
            // As a file holds it.
            let found = SuiteFinding::parse(&SuiteFinding::table(&found)).expect("a table");
            assert_ne!(chosen(found), first);
        }
        assert_eq!(chosen(suite_findings(&right)), first);
    }

    /// Largest errors on the device of the default position, in metres and pixels.
    fn default_positions(
        distance_m: f64,
        anchor: sight::Anchor,
    ) -> Option<Vec<(String, f64, f64)>> {
        let gpu = open_for_test(&GpuOptions::default())?;
        let kernels = Kernels::new(&gpu, &[]);
        let sights = sight::sights(false);
        let here = sights.iter().filter(|s| s.is_default(distance_m, anchor));
        let rows =
            here.flat_map(|sight| position::rows(sight, QUICK_POINTS, &kernels).expect("runs"));
        let default = rows.filter(|row| row.route == "eye-region");
        let figures = default.map(|row| {
            let (metres, pixels) = (row.figure(DEVICE_MAX_M), row.figure(MAX_PX));
            (
                row.condition,
                metres.expect("asked"),
                pixels.expect("asked"),
            )
        });
        Some(figures.collect())
    }

    #[test]
    fn where_a_plan_puts_the_anchor_positions_hold_everywhere() {
        use sight::Anchor::{Middle, Plan};
        for distance_m in [10.0, 20.0, 1e3, 1e6, 3e7] {
            let Some(found) = default_positions(distance_m, Plan) else {
                return;
            };
            assert!(found.len() >= 12, "{}", found.len());
            for (condition, metres, pixels) in found {
                assert!(pixels <= 0.25, "{condition}: {pixels} px");
                assert!(
                    distance_m > 20.0 || metres <= 1e-4,
                    "{condition}: {metres} m"
                );
            }
        }
        // Negative control: anchored in the middle of a region that goes on beyond the horizon, both are exceeded.
        let middle = default_positions(10.0, Middle).expect("a device");
        assert!(
            middle.iter().any(|(_, _, pixels)| *pixels > 0.25),
            "{middle:?}"
        );
        assert!(
            middle.iter().any(|(_, metres, _)| *metres > 1e-3),
            "{middle:?}"
        );
    }
}
