// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions that a scene file has made by the program.

use super::check::Check;
use super::raw::{RawCells, RawCoast, RawIslands, RawNested, RawProcedural};
use crate::SceneError;
use crate::error::one_line;
use crate::generated::{Cells, Coast, Nested};
use crate::procedural::Islands;

fn later<T: 'static>(generator: T, geojson: fn(&T) -> String) -> Box<dyn Fn() -> String> {
    Box::new(move || geojson(&generator))
}

impl Check<'_> {
    /// What a generator makes of its keys.
    pub(super) fn procedural(
        &self,
        raw: RawProcedural,
    ) -> Result<Box<dyn Fn() -> String>, SceneError> {
        Ok(match raw.kind.as_str() {
            "islands" => later(self.islands(&self.keys(raw.keys)?)?, Islands::geojson),
            "nested" => later(self.nested(&self.keys(raw.keys)?)?, Nested::geojson),
            "cells" => later(self.cells(&self.keys(raw.keys)?)?, Cells::geojson),
            "coast" => later(self.coast(&self.keys(raw.keys)?)?, Coast::geojson),
            other => {
                let kinds = ["islands", "nested", "cells", "coast"];
                return Err(self.refuse_name("regions.procedural.kind", other, kinds));
            }
        })
    }

    /// The keys of a generator of one kind.
    pub(super) fn keys<T: serde::de::DeserializeOwned>(
        &self,
        keys: toml::Table,
    ) -> Result<T, SceneError> {
        let found = keys.keys().cloned().collect::<Vec<_>>().join(", ");
        keys.try_into().map_err(|error: toml::de::Error| {
            self.refuse("regions.procedural", found, one_line(&error))
        })
    }

    pub(super) fn seed(&self, seed: i64) -> Result<u64, SceneError> {
        u64::try_from(seed).map_err(|_| self.refuse("regions.procedural.seed", seed, "0 or more"))
    }

    /// Longitude, latitude and radius, degrees, of what keeps clear of the poles and of half the
    /// body's girth.
    pub(super) fn disc(
        &self,
        [longitude, latitude, radius]: [f64; 3],
    ) -> Result<[f64; 3], SceneError> {
        let key = |name: &str| format!("regions.procedural.{name}");
        let latitude = self.within(key("latitude_deg"), latitude, -80.0..=80.0)?;
        let room = 85.0 - latitude.abs();
        Ok([
            self.within(key("longitude_deg"), longitude, -180.0..=180.0)?,
            latitude,
            self.within(key("radius_deg"), radius, 1e-6..=room)?,
        ])
    }

    pub(super) fn nested(&self, raw: &RawNested) -> Result<Nested, SceneError> {
        let [longitude_deg, latitude_deg, radius_deg] =
            self.disc([raw.longitude_deg, raw.latitude_deg, raw.radius_deg])?;
        Ok(Nested {
            count: self.count("regions.procedural.count", raw.count, 1..=4_096)?,
            vertices: self.count("regions.procedural.vertices", raw.vertices, 3..=1_000)?,
            longitude_deg,
            latitude_deg,
            radius_deg,
            as_one: raw.as_one,
        })
    }

    pub(super) fn cells(&self, raw: &RawCells) -> Result<Cells, SceneError> {
        let key = |name: &str| format!("regions.procedural.{name}");
        let south_deg = self.within(key("south_deg"), raw.south_deg, -89.0..=89.0)?;
        Ok(Cells {
            columns: self.count(&key("columns"), raw.columns, 1..=1_000)?,
            rows: self.count(&key("rows"), raw.rows, 1..=1_000)?,
            west_deg: self.within(key("west_deg"), raw.west_deg, -180.0..=180.0)?,
            south_deg,
            width_deg: self.within(key("width_deg"), raw.width_deg, 1e-9..=180.0)?,
            height_deg: self.within(key("height_deg"), raw.height_deg, 1e-9..=89.0 - south_deg)?,
        })
    }

    pub(super) fn coast(&self, raw: &RawCoast) -> Result<Coast, SceneError> {
        let [longitude_deg, latitude_deg, radius_deg] =
            self.disc([raw.longitude_deg, raw.latitude_deg, raw.radius_deg])?;
        Ok(Coast {
            seed: self.seed(raw.seed)?,
            vertices: self.count("regions.procedural.vertices", raw.vertices, 32..=4_000_000)?,
            longitude_deg,
            latitude_deg,
            radius_deg,
        })
    }

    pub(super) fn islands(&self, raw: &RawIslands) -> Result<Islands, SceneError> {
        let seed = self.seed(raw.seed)?;
        let key = |name: &str| format!("regions.procedural.{name}");
        let min_vertices = self.count(&key("min_vertices"), raw.min_vertices, 32..=100_000)?;
        Ok(Islands {
            seed,
            // From two on there is a neighbour to keep clear of; at ten thousand islands are 2°.
            count: self.count(&key("count"), raw.count, 2..=10_000)?,
            min_vertices,
            max_vertices: self.count(
                &key("max_vertices"),
                raw.max_vertices,
                i64::from(min_vertices)..=100_000,
            )?,
            lake_every: self.count(&key("lake_every"), raw.lake_every, 0..=10_000)?,
        })
    }
}
