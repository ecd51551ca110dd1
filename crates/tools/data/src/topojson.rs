// SPDX-License-Identifier: MIT OR Apache-2.0
//! TopoJSON to GeoJSON: arcs that polygons share become rings of their own.
//!
//! Positions are integers on a grid, each the difference from the one before. Rings are joined on the
//! grid, so that ends of arcs meet exactly; degrees are `grid × scale + translate`, rounded to a number
//! of decimals. Source: Bostock and Metcalf, The TopoJSON Format Specification, 2.1.

use serde::Deserialize;
use std::collections::BTreeMap;

/// Why a text gives no polygons.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TopologyError {
    /// Not TopoJSON with a grid.
    #[error("{0}")]
    Syntax(#[from] serde_json::Error),
    /// No such object.
    #[error("objects: found {found}, expected {expected} among them")]
    NoObject {
        /// Names there are.
        found: String,
        /// Name asked for.
        expected: String,
    },
    /// An arc that is not there, arcs that do not meet, a geometry without a number or a name.
    #[error("{object}, geometry {geometry}: {message}")]
    Geometry {
        /// Name of the object.
        object: String,
        /// Index of the geometry.
        geometry: usize,
        /// What was found, and what is allowed.
        message: String,
    },
}

/// A file of arcs.
#[derive(Deserialize)]
pub(crate) struct Topology {
    transform: Transform,
    /// Each position the difference from the one before, on the grid.
    arcs: Vec<Vec<[i64; 2]>>,
    objects: BTreeMap<String, serde_json::Value>,
}

#[derive(Deserialize)]
struct Transform {
    scale: [f64; 2],
    translate: [f64; 2],
}

#[derive(Deserialize)]
struct Collection {
    geometries: Vec<Geometry>,
}

/// Arcs by their number; `!n` is arc `n` backwards.
#[derive(Deserialize)]
#[serde(tag = "type")]
enum Geometry {
    Polygon {
        id: Option<u64>,
        arcs: Vec<Vec<i64>>,
    },
    MultiPolygon {
        id: Option<u64>,
        arcs: Vec<Vec<Vec<i64>>>,
    },
    /// Lines and points, which have no area.
    #[serde(other)]
    Other,
}

/// What becomes of an object's polygons.
pub(crate) struct Conversion {
    /// The object.
    pub(crate) object: &'static str,
    /// Decimals of a degree that are kept.
    pub(crate) decimals: usize,
    /// Digits of an id, filled up with zeros.
    pub(crate) id_digits: usize,
    /// Name of the feature with an id.
    pub(crate) name_of: fn(u64) -> Option<&'static str>,
}

/// Fewest positions of a ring, its end included: a triangle's.
const MIN_POSITIONS: usize = 4;

impl Topology {
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, TopologyError> {
        Ok(serde_json::from_slice(bytes)?)
    }

    /// A feature collection with a feature a line; those without rings of four positions are left out.
    pub(crate) fn geojson(&self, conversion: &Conversion) -> Result<String, TopologyError> {
        let object = conversion.object;
        let Some(found) = self.objects.get(object) else {
            let names: Vec<&str> = self.objects.keys().map(String::as_str).collect();
            return Err(TopologyError::NoObject {
                found: names.join(", "),
                expected: object.to_owned(),
            });
        };
        let collection = Collection::deserialize(found)?;
        let mut features = Vec::new();
        for (index, geometry) in collection.geometries.iter().enumerate() {
            let wrong = |message: String| TopologyError::Geometry {
                object: object.to_owned(),
                geometry: index,
                message,
            };
            let (id, polygons) = match geometry {
                Geometry::Polygon { id, arcs } => (*id, std::slice::from_ref(arcs)),
                Geometry::MultiPolygon { id, arcs } => (*id, arcs.as_slice()),
                Geometry::Other => continue,
            };
            let mut texts = Vec::new();
            for polygon in polygons {
                let mut rings = Vec::new();
                for arcs in polygon {
                    let ring = self.ring(arcs).map_err(wrong)?;
                    if ring.len() >= MIN_POSITIONS {
                        rings.push(self.ring_text(&ring, conversion.decimals));
                    }
                }
                if !rings.is_empty() {
                    texts.push(format!("[{}]", rings.join(",")));
                }
            }
            let geometry = match texts.as_slice() {
                [] => continue,
                [polygon] => format!("{{\"type\":\"Polygon\",\"coordinates\":{polygon}}}"),
                several => format!(
                    "{{\"type\":\"MultiPolygon\",\"coordinates\":[{}]}}",
                    several.join(",")
                ),
            };
            let id = id.ok_or_else(|| wrong("found no id, expected a whole number".to_owned()))?;
            let name = (conversion.name_of)(id);
            let name = name.ok_or_else(|| wrong(format!("found id {id}, which has no name")))?;
            let digits = conversion.id_digits;
            features.push(format!(
                "{{\"type\":\"Feature\",\"properties\":{{\"id\":\"{id:0digits$}\",\"name\":\"{name}\"}},\
                 \"geometry\":{geometry}}}"
            ));
        }
        let features = features.join(",\n");
        Ok(format!(
            "{{\"type\":\"FeatureCollection\",\"features\":[\n{features}\n]}}\n"
        ))
    }

    /// Positions of a ring on the grid, the first one again at its end.
    ///
    /// # Errors
    /// What is wrong with it: an arc that is not there, arcs that do not meet, an end that is no start.
    fn ring(&self, arcs: &[i64]) -> Result<Vec<[i64; 2]>, String> {
        let gap = |arc: i64, start: [i64; 2], end: [i64; 2]| {
            Err(format!("arc {arc} begins at {start:?}, expected {end:?}"))
        };
        let mut ring: Vec<[i64; 2]> = Vec::new();
        for &number in arcs {
            let arc = self.arc(number).ok_or_else(|| {
                let count = i64::try_from(self.arcs.len()).unwrap_or(i64::MAX);
                format!("found arc {number}, allowed: {} to {}", -count, count - 1)
            })?;
            match (ring.last(), arc.first()) {
                (Some(&end), Some(&start)) if end != start => return gap(number, start, end),
                (Some(_), _) => ring.extend(arc.iter().skip(1)),
                (None, _) => ring = arc,
            }
        }
        match (ring.first(), ring.last(), arcs.last()) {
            // The published states have three scraps of two positions, which are left out.
            _ if ring.len() < MIN_POSITIONS => Ok(ring),
            (Some(&start), Some(&end), Some(&arc)) if start != end => gap(arc, start, end),
            _ => Ok(ring),
        }
    }

    /// Positions of an arc on the grid, backwards for `!n`.
    fn arc(&self, number: i64) -> Option<Vec<[i64; 2]>> {
        let is_backwards = number < 0;
        let index = if is_backwards { !number } else { number };
        let steps = self.arcs.get(usize::try_from(index).ok()?)?;
        let mut at = [0_i64; 2];
        let mut arc: Vec<[i64; 2]> = steps
            .iter()
            .map(|step| {
                at = [at[0].saturating_add(step[0]), at[1].saturating_add(step[1])];
                at
            })
            .collect();
        if is_backwards {
            arc.reverse();
        }
        Some(arc)
    }

    fn ring_text(&self, ring: &[[i64; 2]], decimals: usize) -> String {
        let Transform { scale, translate } = &self.transform;
        let degrees = |at: [i64; 2], axis: usize| {
            // On a grid of far fewer than 2⁵³ steps.
            let steps = at[axis] as f64;
            rounded(steps * scale[axis] + translate[axis], decimals)
        };
        let positions: Vec<String> = ring
            .iter()
            .map(|&at| format!("[{},{}]", degrees(at, 0), degrees(at, 1)))
            .collect();
        format!("[{}]", positions.join(","))
    }
}

/// A number to some decimals without zeros at its end, but one behind the point.
fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let short = text.trim_end_matches('0');
    match short.strip_suffix('.') {
        Some(_) => format!("{short}0"),
        None => short.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares with a border in common, arc 0; the second has a hole, and there is a sliver of
    /// three positions. Degrees are a tenth of the grid's steps.
    const SQUARES: &str = r#"{"type":"Topology",
        "transform":{"scale":[0.1,0.1],"translate":[-1,0.05]},
        "arcs":[
            [[10,0],[0,10]],
            [[10,10],[-10,0],[0,-10],[10,0]],
            [[10,0],[10,0],[0,10],[-10,0]],
            [[12,2],[0,2],[2,0],[0,-2],[-2,0]],
            [[30,0],[1,0],[-1,0]]
        ],
        "objects":{"squares":{"type":"GeometryCollection","geometries":[
            {"type":"Polygon","id":1,"arcs":[[0,1]]},
            {"type":"MultiPolygon","id":2,"arcs":[[[2,-1],[3]],[[4]]]},
            {"type":"MultiPolygon","id":1,"arcs":[[[0,1]],[[3]]]},
            {"type":"Polygon","id":9,"arcs":[[4]]},
            {"type":"LineString","arcs":[0]}
        ]}}}"#;

    const CONVERSION: Conversion = Conversion {
        object: "squares",
        decimals: 2,
        id_digits: 3,
        name_of: |id| {
            ["zero", "one", "two"]
                .get(usize::try_from(id).ok()?)
                .copied()
        },
    };

    fn converted(text: &str) -> Result<String, String> {
        let geojson = Topology::parse(text.as_bytes()).and_then(|it| it.geojson(&CONVERSION));
        geojson.map_err(|error| error.to_string())
    }

    #[test]
    fn arcs_become_rings_with_a_border_in_common() {
        let west = "[[0.0,0.05],[0.0,1.05],[-1.0,1.05],[-1.0,0.05],[0.0,0.05]]";
        let east = "[[0.0,0.05],[1.0,0.05],[1.0,1.05],[0.0,1.05],[0.0,0.05]]";
        let hole = "[[0.2,0.25],[0.2,0.45],[0.4,0.45],[0.4,0.25],[0.2,0.25]]";
        let feature = |id: &str, name: &str, kind: &str, coordinates: &str| {
            format!(
                "{{\"type\":\"Feature\",\"properties\":{{\"id\":\"{id}\",\"name\":\"{name}\"}},\
                 \"geometry\":{{\"type\":\"{kind}\",\"coordinates\":{coordinates}}}}}"
            )
        };
        let expected = [
            "{\"type\":\"FeatureCollection\",\"features\":[\n",
            &feature("001", "one", "Polygon", &format!("[{west}]")),
            ",\n",
            // The sliver is left out, and so is the feature that is nothing else.
            &feature("002", "two", "Polygon", &format!("[{east},{hole}]")),
            ",\n",
            &feature(
                "001",
                "one",
                "MultiPolygon",
                &format!("[[{west}],[{hole}]]"),
            ),
            "\n]}\n",
        ]
        .concat();
        assert_eq!(converted(SQUARES), Ok(expected));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        // What is replaced by what, and how the message begins.
        let mistakes = r#"[[0,1]] -> [[0,5]]
    squares, geometry 0: found arc 5, allowed: -5 to 4
[[0,1]] -> [[-6,1]]
    squares, geometry 0: found arc -6, allowed: -5 to 4
[[0,1]] -> [[0,2]]
    squares, geometry 0: arc 2 begins at [10, 0], expected [10, 10]
[[0,1]] -> [[1]]
    squares, geometry 0: arc 1 begins at [10, 10], expected [10, 0]
"squares": -> "s":
    objects: found s, expected squares among them
"id":1, ->
    squares, geometry 0: found no id, expected a whole number
"id":2 -> "id":3
    squares, geometry 1: found id 3, which has no name
"transform" -> "t"
    missing field `transform`
[[10,0],[0,10]] -> [[10.5,0],[0,10]]
    invalid type: floating point"#;
        let mut lines = mistakes.lines();
        while let (Some(change), Some(expected)) = (lines.next(), lines.next()) {
            let (from, to) = change.split_once(" ->").expect(expected);
            let text = SQUARES.replacen(from, to.trim_start(), 1);
            assert_ne!(text, SQUARES, "{from}");
            let error = converted(&text).expect_err(expected);
            assert!(error.starts_with(expected.trim_start()), "{error}");
        }
    }

    #[test]
    fn numbers_are_rounded_to_the_nearest_and_written_short() {
        for (value, decimals, expected) in [
            (-88.097_818_4, 6, "-88.097818"),
            (-88.097_818_6, 6, "-88.097819"),
            (42.0, 6, "42.0"),
            (42.100_000_01, 6, "42.1"),
            (100.0, 5, "100.0"),
            (0.000_001, 5, "0.0"),
        ] {
            assert_eq!(rounded(value, decimals), expected);
        }
    }
}
