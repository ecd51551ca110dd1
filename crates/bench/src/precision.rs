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
use terrafill_gpu::Gpu;
use terrafill_results::{PrecisionGrid, PrecisionKey, PrecisionPart, PrecisionPlan, RunFolder};
use timing::Times;

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
            points: if quick { 200 } else { 600 },
            rounds: if quick { 7 } else { 15 },
        }
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

#[cfg(test)]
mod tests {
    use super::kernel::coordinate_evaluator_of;
    use super::*;
    use terrafill_gpu::{GpuOptions, open_for_test};
    use terrafill_results::{PrecisionRow, RunEnvironment, RunPlan, Status};
    use terrafill_texture::CoordinateRoute;

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
}
