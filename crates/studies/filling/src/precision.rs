// SPDX-License-Identifier: MIT OR Apache-2.0
//! The numerical suite: how wrong every route from a fragment to its texture coordinate is, and what
//! it costs.
//!
//! Each formula is asked at many places of many regions, on the CPU by emulation and on the device
//! by the text that a fill compiles, and held against the exact map in `f64`; beside it stands what
//! it was computed to be off by. Times are of the formula alone, in rounds in which every formula and
//! an empty one take a turn (see [`terrafill_gpu::Evaluator`]). Other things are asked of other
//! places on purpose: the residual's places are those of `MapRegion::samples`, the measured ones a
//! Halton sequence, so that neither can fit itself.

mod coordinate;
mod error;
mod findings;
mod kernel;
mod place;
mod position;
mod routes;
mod special;
mod timing;
mod vertex;

use crate::BenchError;
use kernel::Kernels;
use std::collections::BTreeSet;
use std::sync::Arc;
use terrafill_gpu::{Gpu, GpuOptions};
use terrafill_results::legacy::{
    PrecisionGrid, PrecisionKey, PrecisionPart, PrecisionPlan, RunFolder,
};
use timing::Times;

pub use findings::suite_findings;

/// Places of a region and of a view at which errors are measured.
const POINTS: u32 = 600;
const QUICK_POINTS: u32 = 200;

/// What is measured.
pub(crate) struct Suite {
    routes: Vec<terrafill_texture::CoordinateRoute>,
    places: Vec<place::Place>,
    /// What a frame plan takes in each of them.
    chosen: Vec<Option<terrafill_texture::CoordinateRoute>>,
    sights: Vec<position::Sight>,
    points: u32,
    rounds: u32,
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
            sights: position::sights(quick),
            points: if quick { QUICK_POINTS } else { POINTS },
            rounds: if quick { 7 } else { 15 },
        }
    }

    /// Errors alone: no formula is timed.
    fn untimed(self) -> Self {
        Self { rounds: 0, ..self }
    }

    /// Its rows to be.
    pub(crate) fn plan(&self) -> PrecisionPlan {
        let names = || self.routes.iter().map(|route| route.name()).collect();
        let grid = |part, routes, conditions| PrecisionGrid {
            part,
            routes,
            conditions,
        };
        PrecisionPlan {
            grids: vec![
                grid(
                    PrecisionPart::Coordinate,
                    names(),
                    self.places.iter().map(place::Place::name).collect(),
                ),
                grid(PrecisionPart::Special, names(), special::names()),
                grid(
                    PrecisionPart::Position,
                    position::route_names(),
                    self.sights.iter().map(position::Sight::name).collect(),
                ),
                grid(
                    PrecisionPart::Vertex,
                    vertex::format_names(),
                    vertex::condition_names(),
                ),
            ],
            rounds: self.rounds,
        }
    }

    /// Measures what the run's folder does not have yet, and appends it condition by condition.
    ///
    /// # Errors
    /// A folder that cannot be read or written; a device that is lost. What a device cannot run
    /// becomes rows with the reason.
    pub(crate) fn measure(&self, gpu: &Arc<Gpu>, folder: &RunFolder) -> Result<(), BenchError> {
        folder.write_precision_plan(&self.plan())?;
        let missing: BTreeSet<PrecisionKey> = folder.precision_missing()?.into_iter().collect();
        if missing.is_empty() {
            return Ok(());
        }
        let mut kernels = Kernels::new(gpu, &self.routes);
        kernels.time(folder, self.rounds)?;
        let times = Times::of(&folder.precision_times()?);
        let is_missing = |part: PrecisionPart, condition: &str| {
            missing
                .iter()
                .any(|key| key.part == part && key.condition == condition)
        };
        for (place, chosen) in self.places.iter().zip(&self.chosen) {
            if is_missing(PrecisionPart::Coordinate, &place.name()) {
                let rows = coordinate::rows(place, *chosen, self.points, &kernels, &times)?;
                folder.append_precision(&rows)?;
            }
        }
        for name in special::names() {
            if is_missing(PrecisionPart::Special, &name) {
                folder.append_precision(&special::rows(&name, &kernels, &times)?)?;
            }
        }
        for sight in &self.sights {
            if is_missing(PrecisionPart::Position, &sight.name()) {
                let rows = position::rows(sight, self.points, &kernels, &times)?;
                folder.append_precision(&rows)?;
            }
        }
        for condition in vertex::condition_names() {
            if is_missing(PrecisionPart::Vertex, &condition) {
                folder.append_precision(&vertex::rows(&condition))?;
            }
        }
        Ok(())
    }
}

/// Measures the errors of the whole numerical suite into a run's folder, without times.
///
/// - `adapter`: part of the adapter's name
///
/// # Errors
/// No device, a folder that cannot be read or written, a device that is lost.
pub fn measure_suite(adapter: Option<String>, folder: &RunFolder) -> Result<(), BenchError> {
    let gpu = Gpu::open(&GpuOptions {
        adapter,
        ..GpuOptions::default()
    })
    .map_err(BenchError::NoDevice)?;
    Suite::new(false).untimed().measure(&gpu, folder)
}

#[cfg(test)]
mod tests {
    use super::kernel::coordinate_evaluator_of;
    use super::*;
    use terrafill_gpu::open_for_test;
    use terrafill_results::legacy::{PrecisionRow, RunEnvironment, RunPlan, Status};
    use terrafill_texture::{Chooser, CoordinateRoute, CostTable, SuiteFinding};

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
        let places: Vec<place::Place> = places
            .iter()
            .filter_map(|heights| place::Place::new(1.0, 45.0, *heights))
            .collect();
        let gnomonic = CoordinateRoute::parse("gnomonic-3");
        Suite {
            chosen: vec![gnomonic; places.len()],
            places,
            routes: names
                .iter()
                .filter_map(|name| CoordinateRoute::parse(name))
                .collect(),
            sights: position::sights(true).into_iter().take(2).collect(),
            points: 60,
            rounds: 2,
        }
    }

    fn folder(path: &std::path::Path) -> RunFolder {
        RunFolder::create(path, &RunEnvironment::default(), &RunPlan::default()).expect("empty")
    }

    fn row<'a>(rows: &'a [PrecisionRow], route: &str, condition: &str) -> &'a PrecisionRow {
        let found = rows
            .iter()
            .find(|row| row.route.starts_with(route) && row.condition.contains(condition));
        found.unwrap_or_else(|| panic!("{route}, {condition}"))
    }

    #[test]
    fn a_suite_is_measured_once_and_again_only_where_rows_are_missing() {
        let Some(gpu) = open_for_test(&GpuOptions::default()) else {
            return;
        };
        let temporary = tempfile::tempdir().expect("a folder");
        let run = folder(temporary.path());
        let suite = small();
        assert_eq!(suite.routes.len(), 5);
        suite.measure(&gpu, &run).expect("measures");
        let rows = run.precision().expect("rows");
        let planned = suite.plan().keys().count();
        assert_eq!(rows.len(), planned);
        assert_eq!(run.precision_missing().expect("rows"), []);
        for row in &rows {
            assert_ne!(row.status, Status::Skipped, "{}: {}", row.key(), row.reason);
            let says_why = row.status == Status::Ok || !row.reason.is_empty();
            assert!(says_why, "{}", row.key());
        }
        // Known sizes: a gnomonic cubic on one degree is off by less than a metre on the surface, odd
        // degree 7 in absolute angles by hundreds of metres.
        let gnomonic = row(&rows, "gnomonic-3", "heights=0");
        let absolute = row(&rows, "odd-7", "heights=0");
        assert!(gnomonic.device_max_m.expect("measured") < 1.0);
        assert!((200.0..1200.0).contains(&absolute.device_max_m.expect("measured")));
        assert!(gnomonic.cpu_ns.is_some() && gnomonic.operations_cost.is_some());
        assert_eq!(
            rows.iter().filter(|row| row.chosen).count(),
            2,
            "one in each region"
        );
        // Twin: without the last row, its condition is measured again and no other.
        let file = temporary.path().join("precision.csv");
        let whole = std::fs::read_to_string(&file).expect("text");
        let end = whole.trim_end().rfind('\n').expect("rows") + 1;
        std::fs::write(&file, &whole[..end]).expect("writable");
        suite.measure(&gpu, &run).expect("measures");
        assert_eq!(run.precision().expect("rows").len(), planned);
        let again = std::fs::read_to_string(&file).expect("text");
        assert!(again.starts_with(&whole[..end]));
        assert_eq!(
            run.precision_times().expect("rows").len(),
            (5 + 9) * 2,
            "times are not measured again"
        );
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
        odd.device = coordinate_evaluator_of(&gpu, "odd-7", &odd.program, &text);
        let times = Times::of(&[]);
        Some(
            coordinate::rows(&suite.places[0], None, suite.points, &kernels, &times).expect("runs"),
        )
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
            odd.emulated_max_m < odd.device_max_m,
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
        assert_eq!(odd.non_finite_device, Some(u64::from(odd.points)));
        assert_eq!(
            (odd.non_finite_emulated, odd.status),
            (Some(0), Status::Wrong)
        );
        assert_eq!(odd.device_max_m, None, "no number stands for it");
        let broken = rows_with(|text| text.replace("return", "retrun")).expect("a device");
        let odd = row(&broken, "odd-7", "");
        assert_eq!(odd.status, Status::Skipped);
        assert!(odd.reason.contains("not on this device") && odd.emulated_max_m.is_some());
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
            kernel.device = coordinate_evaluator_of(&gpu, "replaced", &kernel.program, &text);
        }
        let times = Times::of(&[]);
        let places = place::places(false).into_iter();
        let here = places.filter(|place| (place.extent_deg, place.latitude_deg) == cell);
        let mut rows = Vec::new();
        for place in here {
            let of_place = coordinate::rows(&place, None, POINTS, &kernels, &times);
            rows.extend(of_place.expect("runs"));
        }
        for name in special::names() {
            rows.extend(special::rows(&name, &kernels, &times).expect("runs"));
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
        let place = place::Place::new(1.0, 45.0, ("+9km", 0.0, 9_000.0)).expect("bounds");
        let demand = place.demand();
        let chosen = |findings: Vec<SuiteFinding>| {
            let candidates = Chooser::default_candidates();
            let chooser = Chooser::new(&candidates, &CostTable::default(), findings);
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
        anchor: position::Anchor,
    ) -> Option<Vec<(String, f64, f64)>> {
        let gpu = open_for_test(&GpuOptions::default())?;
        let kernels = Kernels::new(&gpu, &[]);
        let times = Times::of(&[]);
        let sights = position::sights(false);
        let here = sights.iter().filter(|s| s.is_default(distance_m, anchor));
        let rows = here
            .flat_map(|sight| position::rows(sight, QUICK_POINTS, &kernels, &times).expect("runs"));
        let default = rows.filter(|row| row.route == "eye-region");
        let figures = default.map(|row| {
            let (metres, pixels) = (row.device_max_m, row.max_px);
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
        use position::Anchor::{Middle, Plan};
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
        // Twin: anchored in the middle of a region that goes on beyond the horizon, both are exceeded.
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
