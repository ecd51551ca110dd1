// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tree that serde builds of a GeoJSON file: only what is needed, positions as two numbers,
//! properties as a name.

use super::problem::unnamed;
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// Any GeoJSON object: members may come in any order, so the type is known only at its end.
#[derive(serde::Deserialize)]
#[serde(expecting = "a GeoJSON object")]
pub(super) struct RawObject {
    #[serde(rename = "type")]
    pub(super) kind: Option<String>,
    pub(super) coordinates: Option<RawCoordinates>,
    pub(super) geometries: Option<Vec<Self>>,
    /// Outer `None`: no such member. `Some(None)`: null, which RFC 7946 allows.
    #[serde(default, deserialize_with = "present")]
    pub(super) geometry: Option<Option<Box<Self>>>,
    pub(super) features: Option<Vec<Self>>,
    properties: Option<RawProperties>,
    id: Option<RawLabel>,
    crs: Option<serde_json::Value>,
}

/// A member that is there, null or not.
fn present<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Option<Box<RawObject>>>, D::Error> {
    Option::deserialize(deserializer).map(Some)
}

/// Ends of the names that WGS 84 has as a coordinate reference system in longitude and latitude:
/// `urn:ogc:def:crs:OGC:1.3:CRS84`, `urn:ogc:def:crs:EPSG::4326`, `EPSG:4979` …
const WGS84_NAMES: [&str; 5] = ["crs84", "crs84h", ":4326", "/4326", ":4979"];

impl RawObject {
    /// The coordinate reference system that a member `crs` of the GeoJSON of 2008 names, unless it
    /// is WGS 84 or null.
    pub(super) fn foreign_crs(&self) -> Option<String> {
        let crs = self.crs.as_ref().filter(|crs| !crs.is_null())?;
        let properties = &crs["properties"];
        let name = [
            &properties["name"],
            &properties["href"],
            &properties["code"],
            crs,
        ];
        let name = name.into_iter().find(|value| !value.is_null())?;
        let name = name
            .as_str()
            .map_or_else(|| name.to_string(), str::to_owned);
        let lower = name.to_lowercase();
        let is_wgs84 = WGS84_NAMES.iter().any(|end| lower.ends_with(end)) || lower == "4326";
        (!is_wgs84).then_some(name)
    }

    pub(super) fn label(&self, index: usize) -> String {
        let from_properties = self.properties.as_ref().and_then(|p| p.label.clone());
        let from_id = self.id.as_ref().and_then(|id| id.0.clone());
        from_properties
            .or(from_id)
            .unwrap_or_else(|| unnamed(index))
    }
}

/// Properties that name a feature, best first.
const NAME_PROPERTIES: [&str; 8] = [
    "NAME",
    "name",
    "Name",
    "ADMIN",
    "admin",
    "NAME_LONG",
    "id",
    "ID",
];

/// Only the name of all the properties.
struct RawProperties {
    label: Option<String>,
}

impl<'de> Deserialize<'de> for RawProperties {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PropertiesVisitor;
        impl<'de> Visitor<'de> for PropertiesVisitor {
            type Value = RawProperties;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of properties")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut best = NAME_PROPERTIES.len();
                let mut label = None;
                while let Some(RawKey(rank)) = map.next_key()? {
                    match rank {
                        Some(rank) => {
                            let RawLabel(found) = map.next_value()?;
                            if rank < best && found.is_some() {
                                (best, label) = (rank, found);
                            }
                        }
                        None => {
                            map.next_value::<IgnoredAny>()?;
                        }
                    }
                }
                Ok(RawProperties { label })
            }
        }
        deserializer.deserialize_map(PropertiesVisitor)
    }
}

/// Rank of a property among [`NAME_PROPERTIES`], compared without copying the key.
struct RawKey(Option<usize>);

impl<'de> Deserialize<'de> for RawKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct KeyVisitor;
        impl Visitor<'_> for KeyVisitor {
            type Value = RawKey;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a key")
            }

            fn visit_str<E>(self, key: &str) -> Result<RawKey, E> {
                Ok(RawKey(NAME_PROPERTIES.iter().position(|name| *name == key)))
            }
        }
        deserializer.deserialize_str(KeyVisitor)
    }
}

/// A name or number; nothing for any other kind of value and for an empty string.
struct RawLabel(Option<String>);

impl<'de> Deserialize<'de> for RawLabel {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let label = match serde_json::Value::deserialize(deserializer)? {
            serde_json::Value::String(text) if !text.trim().is_empty() => Some(text),
            serde_json::Value::Number(number) => Some(number.to_string()),
            _ => None,
        };
        Ok(Self(label))
    }
}

/// Coordinates of any depth. Third and further numbers of a position are dropped while reading.
pub(super) enum RawCoordinates {
    Position([f64; 2]),
    List(Vec<Self>),
    Number(f64),
    Other(Box<str>),
    /// A list that starts as a position does and has something else in it. Boxed, so that the many
    /// positions of a file take no more memory for it.
    NotANumber(Box<NotANumber>),
}

/// Something that is no number, in a position.
pub(super) struct NotANumber {
    /// Place in the position, from 0.
    pub(super) element: usize,
    /// In words.
    pub(super) found: String,
}

impl RawCoordinates {
    /// No rings, or none that has a position.
    pub(super) fn is_empty_polygon(&self) -> bool {
        let is_empty = |ring: &Self| matches!(ring, Self::List(list) if list.is_empty());
        matches!(self, Self::List(rings) if rings.iter().all(is_empty))
    }

    pub(super) fn describe(&self) -> String {
        match self {
            Self::Position(_) => "a position".to_owned(),
            Self::List(list) if list.is_empty() => "an empty list".to_owned(),
            Self::List(_) => "a list of lists".to_owned(),
            Self::Number(value) => format!("the number {value}"),
            Self::Other(text) => text.to_string(),
            Self::NotANumber(not) => format!("{} in a list", not.found),
        }
    }
}

impl<'de> Deserialize<'de> for RawCoordinates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CoordinatesVisitor)
    }
}

struct CoordinatesVisitor;

impl<'de> Visitor<'de> for CoordinatesVisitor {
    type Value = RawCoordinates;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("coordinates")
    }

    fn visit_f64<E>(self, value: f64) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Number(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Number(value as f64))
    }

    fn visit_str<E>(self, text: &str) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Other(format!("the text \"{text}\"").into()))
    }

    fn visit_bool<E>(self, value: bool) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Other(value.to_string().into()))
    }

    fn visit_unit<E>(self) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Other("null".into()))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RawCoordinates, A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(RawCoordinates::Other("an object".into()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<RawCoordinates, A::Error> {
        let longitude = match seq.next_element()? {
            None => return Ok(RawCoordinates::List(Vec::new())),
            Some(RawCoordinates::Number(longitude)) => longitude,
            Some(RawCoordinates::Other(found)) => {
                while seq.next_element::<IgnoredAny>()?.is_some() {}
                let found = found.into_string();
                let not = NotANumber { element: 0, found };
                return Ok(RawCoordinates::NotANumber(Box::new(not)));
            }
            Some(first) => {
                let mut list = vec![first];
                while let Some(item) = seq.next_element()? {
                    list.push(item);
                }
                return Ok(RawCoordinates::List(list));
            }
        };
        let mut numbers = 1;
        let mut latitude = 0.0;
        let mut intruder = None;
        while let Some(item) = seq.next_element::<RawCoordinates>()? {
            match item {
                RawCoordinates::Number(value) if numbers == 1 => latitude = value,
                RawCoordinates::Number(_) => {}
                other => {
                    intruder.get_or_insert((numbers, other.describe()));
                }
            }
            numbers += 1;
        }
        Ok(match intruder {
            Some((element, found)) => {
                RawCoordinates::NotANumber(Box::new(NotANumber { element, found }))
            }
            None if numbers == 1 => RawCoordinates::Other("a position of 1 number".into()),
            None => RawCoordinates::Position([longitude, latitude]),
        })
    }
}
