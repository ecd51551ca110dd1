// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files that are made from published ones, the same bytes each time.

use crate::topojson::{Conversion, Topology, TopologyError};

/// Every conversion by its name.
const MAKERS: [(&str, Conversion); 2] = [
    (
        "us-states",
        Conversion {
            object: "states",
            decimals: 6,
            id_digits: 2,
            name_of: state_name,
        },
    ),
    (
        "us-counties",
        Conversion {
            object: "counties",
            decimals: 5,
            id_digits: 5,
            name_of: |county| state_name(county / 1000),
        },
    ),
];

/// Names of all conversions.
pub(crate) fn makers() -> impl Iterator<Item = &'static str> {
    MAKERS.iter().map(|(name, _)| *name)
}

/// What the conversion called `by` makes of the bytes `source`; `None` if there is no such conversion.
pub(crate) fn make(by: &str, source: &[u8]) -> Option<Result<String, TopologyError>> {
    let (_, conversion) = MAKERS.iter().find(|(name, _)| *name == by)?;
    Some(Topology::parse(source).and_then(|topology| topology.geojson(conversion)))
}

/// Name of a state, a district or a territory of the USA by its number. A county's number has three
/// digits more. Source: ANSI INCITS 38, which was FIPS 5-2.
fn state_name(number: u64) -> Option<&'static str> {
    Some(match number {
        1 => "Alabama",
        2 => "Alaska",
        4 => "Arizona",
        5 => "Arkansas",
        6 => "California",
        8 => "Colorado",
        9 => "Connecticut",
        10 => "Delaware",
        11 => "District of Columbia",
        12 => "Florida",
        13 => "Georgia",
        15 => "Hawaii",
        16 => "Idaho",
        17 => "Illinois",
        18 => "Indiana",
        19 => "Iowa",
        20 => "Kansas",
        21 => "Kentucky",
        22 => "Louisiana",
        23 => "Maine",
        24 => "Maryland",
        25 => "Massachusetts",
        26 => "Michigan",
        27 => "Minnesota",
        28 => "Mississippi",
        29 => "Missouri",
        30 => "Montana",
        31 => "Nebraska",
        32 => "Nevada",
        33 => "New Hampshire",
        34 => "New Jersey",
        35 => "New Mexico",
        36 => "New York",
        37 => "North Carolina",
        38 => "North Dakota",
        39 => "Ohio",
        40 => "Oklahoma",
        41 => "Oregon",
        42 => "Pennsylvania",
        44 => "Rhode Island",
        45 => "South Carolina",
        46 => "South Dakota",
        47 => "Tennessee",
        48 => "Texas",
        49 => "Utah",
        50 => "Vermont",
        51 => "Virginia",
        53 => "Washington",
        54 => "West Virginia",
        55 => "Wisconsin",
        56 => "Wyoming",
        72 => "Puerto Rico",
        78 => "Virgin Islands",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Catalogue;
    use terrafill_fixtures::data;
    use terrafill_scene::sha256_hex;

    #[test]
    #[ignore = "needs data: us-10m"]
    fn states_and_counties_are_made_with_the_bytes_that_scenes_name() {
        let catalogue = Catalogue::shipped().expect("the catalogue");
        let set = catalogue.find("us-10m").expect("a set");
        let source = data::bytes(&set.file);
        assert_eq!(set.made.len(), 2);
        for made in &set.made {
            let text = make(&made.by, &source).expect("a maker").expect("TopoJSON");
            assert_eq!(text.len() as u64, made.bytes, "{}", made.file);
            assert_eq!(sha256_hex(text.as_bytes()), made.sha256, "{}", made.file);
        }
        // Negative control: another grid gives other bytes.
        let moved = String::from_utf8(source).expect("UTF-8");
        let other = moved.replacen("-179.1473399999999", "-179.1473", 2);
        assert_ne!(other, moved);
        let text = make("us-states", other.as_bytes()).expect("a maker");
        let text = text.expect("TopoJSON");
        assert_ne!(sha256_hex(text.as_bytes()), set.made[0].sha256);
    }

    #[test]
    fn what_is_made_is_known() {
        assert_eq!(makers().collect::<Vec<_>>(), ["us-states", "us-counties"]);
        assert!(make("magic", b"{}").is_none());
        assert!(matches!(make("us-states", b"{}"), Some(Err(_))));
        let names = (0..100).filter_map(state_name).count();
        assert_eq!(
            (names, state_name(6), state_name(3)),
            (53, Some("California"), None)
        );
    }
}
