// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is drawn: data by extent and view, and how it is divided.

use crate::divided::{Divided, Origin, Series, cells_by_formula};
use crate::interface::Interface;
use crate::metrics::{
    API, DEPTH, DIVISION, EXTENT, ORIGIN, PART, PATH, PLACE, PROJECTION, SERIES, VIEW,
};
use crate::place::{Data, RADIUS_M};
use crate::view::{Eye, Projection};
use glam::DVec2;
use std::f64::consts::FRAC_PI_2;
use terrafill_results::ConditionKey;

/// The campus of the paper's own picture, in San Diego, degrees.
const CAMPUS_DEG: [f64; 2] = [-117.237, 32.880];
/// So near to ±180° that data of a country's extent crosses it, degrees.
const WEST_OF_LINE_DEG: f64 = 179.0;

terrafill_results::named! {
    /// How large data is.
    all pub(crate) enum Extent {
        Campus = "campus",
        City = "city",
        Country = "country",
        Continent = "continent",
    }
}

impl Extent {
    /// Of latitude, or of a line; radians.
    pub(crate) fn angle(self) -> f64 {
        let degrees: f64 = match self {
            Self::Campus => 0.04,
            Self::City => 0.5,
            Self::Country => 8.0,
            Self::Continent => 40.0,
        };
        degrees.to_radians()
    }
}

terrafill_results::named! {
    /// Where data lies.
    pub(crate) enum Place {
        Campus = "",
        /// Its upper edge is the north pole.
        Pole = "pole",
        DateLine = "date-line",
    }
}

impl Place {
    /// Longitude and latitude of the data's middle, radians.
    fn middle(self, extent: Extent) -> DVec2 {
        let [longitude, latitude] = CAMPUS_DEG.map(f64::to_radians);
        match self {
            Self::Campus => DVec2::new(longitude, latitude),
            Self::Pole => DVec2::new(longitude, FRAC_PI_2 - 0.5 * extent.angle()),
            Self::DateLine => DVec2::new(WEST_OF_LINE_DEG.to_radians(), latitude),
        }
    }
}

terrafill_results::named! {
    /// From where data is seen.
    pub(crate) enum Vantage {
        Nadir = "nadir",
        Oblique = "oblique",
        Limb = "limb",
        Close = "close",
    }
}

/// Metres above the body of the near view.
const CLOSE_M: f64 = 150.0;
/// Height of the eye over the data's height on the ground.
const HEIGHT_SHARE: f64 = 1.1;

impl Vantage {
    /// The eye: from south of the data's middle, at which it looks.
    fn eye(self, middle: DVec2, extent: Extent, side: u32) -> Eye {
        let angle = extent.angle();
        let height_m = HEIGHT_SHARE * angle * RADIUS_M;
        // How far the horizon is.
        let horizon = |height_m: f64| (RADIUS_M / (RADIUS_M + height_m)).acos();
        let (away, height_m) = match self {
            Self::Nadir => (0.0, height_m),
            // Nearly half of it beyond the middle, where the sphere still lets it be seen.
            Self::Oblique => ((1.2 * angle).min(0.6 * horizon(height_m)), 0.7 * height_m),
            Self::Limb => (0.85 * horizon(height_m), height_m),
            Self::Close => (0.0, CLOSE_M),
        };
        Eye::new(middle, away, height_m, side)
    }
}

/// How data is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Division {
    /// So many cells along a side.
    Fixed(u32),
    /// By [`cells_by_formula`].
    Formula,
    /// By counted pixels.
    Query,
    /// By pixels that are counted obliquely, whatever the view in which it is drawn.
    Elsewhere,
}

impl Division {
    pub(crate) fn name(self) -> String {
        match self {
            Self::Fixed(cells) => cells.to_string(),
            Self::Formula => "formula".to_owned(),
            Self::Query => "query".to_owned(),
            Self::Elsewhere => "elsewhere".to_owned(),
        }
    }

    pub(crate) fn is_counted(self) -> bool {
        matches!(self, Self::Query | Self::Elsewhere)
    }
}

/// What lies on the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    Decal,
    /// Along a great circle, or a parallel.
    Line {
        is_great_circle: bool,
    },
}

/// A case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Work {
    pub(crate) part: Part,
    pub(crate) extent: Extent,
    pub(crate) place: Place,
    pub(crate) from: Vantage,
    pub(crate) projection: Projection,
    pub(crate) division: Division,
    pub(crate) origin: Origin,
    pub(crate) series: Series,
    pub(crate) is_tested: bool,
    pub(crate) interface: Interface,
}

impl Work {
    /// Conditions, in the order of its name.
    pub(crate) fn conditions(&self) -> Vec<(ConditionKey, String)> {
        let (part, path) = match self.part {
            Part::Decal => ("decal", ""),
            Part::Line { is_great_circle } => {
                let path = if is_great_circle {
                    "great-circle"
                } else {
                    "parallel"
                };
                ("line", path)
            }
        };
        let depth = if self.is_tested { "tested" } else { "" };
        let all = [
            (PART, part),
            (PATH, path),
            (EXTENT, self.extent.name()),
            (PLACE, self.place.name()),
            (VIEW, self.from.name()),
            (PROJECTION, self.projection.name()),
            (DEPTH, depth),
            (ORIGIN, self.origin.name()),
            (SERIES, self.series.name()),
            (API, self.interface.name()),
        ];
        let mut all: Vec<_> = all.map(|(key, value)| (key, value.to_owned())).into();
        all.push((DIVISION, self.division.name()));
        all
    }

    /// Whether its vertices are placed once more by the device, to be read back: where their origin is compared.
    pub(crate) fn is_read_back(&self) -> bool {
        let is_compared = Self {
            origin: Origin::Corner,
            ..*self
        };
        let usual = Self {
            extent: self.extent,
            place: self.place,
            from: self.from,
            ..USUAL
        };
        is_compared == usual
    }

    /// Its name: what its conditions say beyond the usual.
    pub(crate) fn name(&self) -> String {
        let usual = ["", "globe", "corner", "14", "wgpu"];
        let all = self.conditions();
        let values = all.iter().map(|(_, value)| value.as_str());
        let values: Vec<&str> = values.filter(|value| !usual.contains(value)).collect();
        values.join("/")
    }

    pub(crate) fn data(&self) -> Data {
        let (middle, angle) = (self.place.middle(self.extent), self.extent.angle());
        match self.part {
            Part::Decal => Data::square(middle, angle),
            Part::Line { is_great_circle } => Data::line(middle, angle, is_great_circle),
        }
    }

    pub(crate) fn eye(&self, side: u32) -> Eye {
        Eye {
            projection: self.projection,
            ..self
                .from
                .eye(self.place.middle(self.extent), self.extent, side)
        }
    }

    /// What is drawn to count its pixels.
    pub(crate) fn counted(&self, side: u32, cells: u32) -> Divided {
        let from = match self.division {
            Division::Elsewhere => Vantage::Oblique,
            _ => self.from,
        };
        Self { from, ..*self }.divided(side, Some(cells))
    }

    /// What is drawn, where its division is known before.
    ///
    /// - `cells`: those that counting found
    pub(crate) fn divided(&self, side: u32, cells: Option<u32>) -> Divided {
        let (data, eye) = (self.data(), self.eye(side));
        let cells = cells.unwrap_or_else(|| match self.division {
            Division::Fixed(cells) => cells,
            Division::Formula => cells_by_formula(&eye, &data),
            Division::Query | Division::Elsewhere => 1,
        });
        Divided {
            data,
            eye,
            cells,
            origin: self.origin,
            series: self.series,
            is_tested: self.is_tested,
        }
    }
}

const USUAL: Work = Work {
    part: Part::Decal,
    extent: Extent::Country,
    place: Place::Campus,
    from: Vantage::Nadir,
    projection: Projection::Globe,
    division: Division::Fixed(10),
    origin: Origin::Corner,
    series: Series::Full,
    is_tested: false,
    interface: Interface::Wgpu,
};

/// 1,024 decals side by side, as vertices of one draw: of 10 × 10 cells each, and of 14 × 14, twice as many.
const MANY: [Division; 2] = [Division::Fixed(320), Division::Fixed(448)];

/// Every way to divide what is drawn like this; counted on Vulkan, whose queries count.
fn divisions(work: Work) -> [Work; 4] {
    let known = [Division::Fixed(1), Division::Fixed(10), Division::Formula];
    let of = |division| Work { division, ..work };
    let query = Work {
        interface: Interface::Vulkan,
        ..of(Division::Query)
    };
    let [one, ten, formula] = known.map(of);
    [one, ten, formula, query]
}

/// Cases in groups that share what is drawn and from where.
pub(crate) fn groups(is_quick: bool) -> Vec<Vec<Work>> {
    let mut groups = Vec::new();
    for extent in Extent::ALL {
        let mut views = vec![Vantage::Nadir, Vantage::Oblique];
        match extent {
            Extent::Campus => views.push(Vantage::Close),
            Extent::City => {}
            Extent::Country | Extent::Continent => views.push(Vantage::Limb),
        }
        for from in views {
            let work = Work {
                extent,
                from,
                ..USUAL
            };
            let mut works = divisions(work).to_vec();
            works.push(Work {
                origin: Origin::Centre,
                ..work
            });
            if matches!(extent, Extent::Campus | Extent::City) {
                let low = [Series::First, Series::Second];
                works.extend(low.map(|series| Work { series, ..work }));
            } else if from != Vantage::Limb {
                let tested = Work {
                    is_tested: true,
                    ..work
                };
                works.extend(divisions(tested));
            }
            if (extent, from) == (Extent::Country, Vantage::Nadir) {
                works.extend(MANY.map(|division| Work { division, ..work }));
            }
            groups.push(works);
        }
    }
    for projection in [Projection::Flat, Projection::Hyperbolic, Projection::Dome] {
        for from in [Vantage::Nadir, Vantage::Oblique] {
            let work = Work {
                extent: Extent::Continent,
                projection,
                from,
                ..USUAL
            };
            let mut works = divisions(work).to_vec();
            if from == Vantage::Nadir && projection != Projection::Flat {
                works.push(Work {
                    division: Division::Elsewhere,
                    ..works[3]
                });
            }
            groups.push(works);
        }
    }
    for (extent, is_great_circle) in [
        (Extent::Country, true),
        (Extent::Continent, true),
        (Extent::Continent, false),
    ] {
        for from in [Vantage::Nadir, Vantage::Oblique] {
            let work = Work {
                part: Part::Line { is_great_circle },
                extent,
                from,
                ..USUAL
            };
            let tested = Work {
                is_tested: true,
                ..work
            };
            groups.push([divisions(work), divisions(tested)].concat());
        }
    }
    let line = Work {
        part: Part::Line {
            is_great_circle: false,
        },
        extent: Extent::Continent,
        // A line through the focus stays straight.
        from: Vantage::Oblique,
        projection: Projection::Hyperbolic,
        ..USUAL
    };
    groups.push(divisions(line).into());
    groups.extend(elsewhere());
    for works in &mut groups {
        works.extend(on_vulkan(works));
    }
    if is_quick {
        groups.retain(|works| works[0].is_quick());
    }
    groups
}

/// Where longitude and latitude are no plain coordinates.
fn elsewhere() -> Vec<Vec<Work>> {
    let mut groups = Vec::new();
    for place in [Place::Pole, Place::DateLine] {
        for from in [Vantage::Nadir, Vantage::Oblique] {
            let decal = Work {
                place,
                from,
                ..USUAL
            };
            let centre = Work {
                origin: Origin::Centre,
                ..decal
            };
            groups.push([&divisions(decal)[..], &[centre]].concat());
        }
        let line = Work {
            part: Part::Line {
                is_great_circle: true,
            },
            place,
            from: Vantage::Oblique,
            ..USUAL
        };
        groups.push(divisions(line).into());
    }
    let map = Work {
        extent: Extent::Continent,
        place: Place::DateLine,
        projection: Projection::Hyperbolic,
        ..USUAL
    };
    groups.push(divisions(map).into());
    groups
}

impl Work {
    /// One view of each question.
    fn is_quick(&self) -> bool {
        let is_line = self.part != Part::Decal;
        if self.place != Place::Campus {
            return false;
        }
        match (self.extent, self.from) {
            (Extent::Campus, Vantage::Close) => true,
            (Extent::Continent, Vantage::Oblique) => {
                is_line || self.projection == Projection::Globe
            }
            (Extent::Continent, Vantage::Nadir) => self.projection == Projection::Hyperbolic,
            _ => false,
        }
    }
}

/// The same on Vulkan, of those that are not: what is divided by counts is compared within one interface.
fn on_vulkan(works: &[Work]) -> Vec<Work> {
    let own = works
        .iter()
        .filter(|work| work.interface == Interface::Wgpu);
    // Vertices about the centre are judged by where the device has them, which wgpu reads back.
    let own = own.filter(|work| work.origin == Origin::Corner && work.series == Series::Full);
    let of = |work: &Work| Work {
        interface: Interface::Vulkan,
        ..*work
    };
    own.map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::place::direction;
    use std::collections::BTreeSet;
    use std::f64::consts::PI;

    #[test]
    fn every_case_has_a_name_of_its_own() {
        let names: Vec<String> = groups(false).concat().iter().map(Work::name).collect();
        let distinct: BTreeSet<&String> = names.iter().collect();
        assert_eq!(distinct.len(), names.len());
        assert!(
            names.contains(&"decal/continent/nadir/10".to_owned()),
            "{names:?}"
        );
        assert!(groups(true).len() < groups(false).len());
    }

    #[test]
    fn all_data_is_seen_in_its_views() {
        for works in groups(false) {
            let divided = works[0].divided(256, None);
            let (eye, data) = (divided.eye, divided.data);
            let share = DVec2::splat(0.5);
            let at = eye.pixel(eye.clip(data.direction(share) * RADIUS_M, data.angles(share)));
            let off = (at - DVec2::splat(128.0)).abs().max_element();
            let is_map = divided.eye.projection != Projection::Globe;
            let most = if is_map { 128.0 } else { 1e-6 };
            assert!(off < most, "{}: {at}", works[0].name());
            // Negative control: data on the other side of the body.
            let other = DVec2::new(data.corner.x + PI, -0.5 * data.corner.y);
            let at = eye.pixel(eye.clip(direction(other) * RADIUS_M, other));
            let off = (at - DVec2::splat(128.0)).abs().max_element();
            let is_before = eye.horizon().dot((direction(other) * RADIUS_M).extend(1.0)) >= 0.0;
            assert!(off > 1.0 && !(is_before && off < 128.0 && !is_map), "{at}");
        }
    }
}
