// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where samples lie and in which unit they count: the keys of a GeoTIFF, and its tie point or transformation.

use crate::error::Complaints;
use crate::{ElevationError, Grid, Projection, Registration};
use std::io::Cursor;
use tiff::decoder::Decoder;
use tiff::tags::Tag;

/// What a key does to the meaning of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum KeyTreatment {
    /// Honoured.
    Read,
    /// Whatever it says, heights and places stay the same.
    Harmless,
    /// Numbers that are not 0 move places, and are refused.
    Zero,
}
use KeyTreatment::{Harmless, Read, Zero};

/// Number, name and treatment (OGC 19-008r4, annex D; 2062 by GDAL), ascending.
pub(super) const KEYS: &[(u16, &str, KeyTreatment)] = &[
    (1024, "GTModelType", Read),
    (1025, "GTRasterType", Read),
    (1026, "GTCitation", Harmless),
    (2048, "GeodeticCRS", Read),
    (2049, "GeodeticCitation", Harmless),
    (2050, "GeodeticDatum", Read),
    (2051, "PrimeMeridian", Read),
    // Of the ellipsoid's axes. The scene says which body it is.
    (2052, "GeogLinearUnits", Harmless),
    (2053, "GeogLinearUnitSize", Harmless),
    (2054, "GeogAngularUnits", Read),
    // Of units that another key names, and that are refused.
    (2055, "GeogAngularUnitSize", Harmless),
    (2056, "Ellipsoid", Harmless),
    (2057, "EllipsoidSemiMajorAxis", Harmless),
    (2058, "EllipsoidSemiMinorAxis", Harmless),
    (2059, "EllipsoidInvFlattening", Harmless),
    (2060, "GeogAzimuthUnits", Harmless),
    (2061, "PrimeMeridianLongitude", Zero),
    (2062, "GeogTOWGS84", Zero),
    (3072, "ProjectedCRS", Read),
    (3073, "ProjectedCitation", Harmless),
    // Only EPSG:3857 is read, which says all of these.
    (3074, "Projection", Harmless),
    (3075, "ProjMethod", Harmless),
    (3076, "ProjLinearUnits", Read),
    (3077, "ProjLinearUnitSize", Harmless),
    (3078, "ProjStdParallel1", Harmless),
    (3079, "ProjStdParallel2", Harmless),
    (3080, "ProjNatOriginLong", Harmless),
    (3081, "ProjNatOriginLat", Harmless),
    (3082, "ProjFalseEasting", Harmless),
    (3083, "ProjFalseNorthing", Harmless),
    (3084, "ProjFalseOriginLong", Harmless),
    (3085, "ProjFalseOriginLat", Harmless),
    (3086, "ProjFalseOriginEasting", Harmless),
    (3087, "ProjFalseOriginNorthing", Harmless),
    (3088, "ProjCenterLong", Harmless),
    (3089, "ProjCenterLat", Harmless),
    (3090, "ProjCenterEasting", Harmless),
    (3091, "ProjCenterNorthing", Harmless),
    (3092, "ProjScaleAtNatOrigin", Harmless),
    (3093, "ProjScaleAtCenter", Harmless),
    (3094, "ProjAzimuthAngle", Harmless),
    (3095, "ProjStraightVertPoleLong", Harmless),
    (4096, "Vertical", Read),
    (4097, "VerticalCitation", Harmless),
    // The geoid, up to 106 m, is left out on purpose.
    (4098, "VerticalDatum", Harmless),
    (4099, "VerticalUnits", Read),
    (5120, "CoordinateEpoch", Harmless),
];

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEODETIC_CRS: u16 = 2048;
const GEODETIC_DATUM: u16 = 2050;
const PRIME_MERIDIAN: u16 = 2051;
const ANGULAR_UNITS: u16 = 2054;
const PROJECTED_CRS: u16 = 3072;
const LINEAR_UNITS: u16 = 3076;
const VERTICAL_CRS: u16 = 4096;
const VERTICAL_UNITS: u16 = 4099;
/// Values of the keys.
const MODEL_PROJECTED: u16 = 1;
const MODEL_GEOGRAPHIC: u16 = 2;
const PIXEL_IS_AREA: u16 = 1;
const PIXEL_IS_POINT: u16 = 2;
/// The second is the same angle with its notation left open.
const DEGREES: [u16; 2] = [9102, 9122];
const METRE: u16 = 9001;
const GREENWICH: u16 = 8901;
const WEB_MERCATOR: u16 = 3857;
/// Within two metres of WGS 84, a small part of a sample: WGS 84 (two and three axes), NAD 83, WGS 72, ETRS 89, SIRGAS
/// 2000, CGCS 2000, GDA 2020, GDA 94, JGD 2011, JGD 2000, NAD 83 (CSRS), NZGD 2000.
const GEODETIC: [u16; 13] = [
    4326, 4979, 4269, 4322, 4258, 4674, 4490, 7844, 4283, 6668, 4612, 4617, 4167,
];
/// Their datums, for a system that a file puts together itself.
const DATUMS: [u16; 12] = [
    6326, 6269, 6322, 6258, 6674, 1043, 1168, 6283, 1128, 6612, 6140, 6167,
];
/// A key that says "defined elsewhere" leaves other keys to speak.
const USER_DEFINED: u16 = 32_767;

/// Metres of a foot, and of a United States survey foot.
const FOOT_M: f64 = 0.3048;
const SURVEY_FOOT_M: f64 = 1200.0 / 3937.0;
/// EPSG's vertical systems whose heights are metres upwards: ellipsoidal ones of GeoTIFF 1.0 and WGS 84, EGM 2008, 96
/// and 84, mean sea level, NAVD 88, NGVD 29 (m), CGVD 28 and 2013, EVRF 2000, 2007 and 2019, and national ones.
const METRES_UP: [u16; 34] = [
    4979, 5030, 3855, 5773, 5798, 5714, 5703, 7968, 5713, 6647, 5730, 5621, 9389, 5701, 5705, 5709,
    5710, 5711, 5720, 5728, 5729, 5737, 5776, 5780, 5782, 5783, 7837, 5799, 5613, 5717, 3900, 5941,
    6695, 7839,
];
/// The same in feet (NAVD 88, mean sea level), and in survey feet (NAVD 88, NGVD 29, mean sea level).
const FEET_UP: [u16; 2] = [8228, 8050];
const SURVEY_FEET_UP: [u16; 3] = [6360, 5702, 8052];
/// Depths: positive downwards.
const DOWN: [u16; 9] = [5715, 6357, 6358, 6359, 8051, 8053, 5831, 5861, 5866];

/// What a file says of where it lies.
pub(super) struct RasterPlace {
    projection: Projection,
    registration: Registration,
    /// Column and row that have a known place.
    tie: [f64; 2],
    /// That place.
    at: [f64; 2],
    /// Steps to the east and to the south.
    scale: [f64; 2],
    /// Whether the first row is the southern one.
    pub(super) is_south_up: bool,
    /// Metres of the vertical system's unit; `None` where no key says one.
    pub(super) unit_m: Option<f64>,
    pub(super) warnings: Vec<String>,
}

/// The `GeoKeyDirectory` with the numbers that it points to.
struct Keys {
    entries: Vec<[u16; 4]>,
    doubles: Vec<f64>,
}

impl Keys {
    fn read(decoder: &mut Decoder<Cursor<&[u8]>>) -> Self {
        let shorts = decoder.find_tag(Tag::GeoKeyDirectoryTag).ok().flatten();
        let shorts = shorts.and_then(|value| value.into_u16_vec().ok());
        let shorts = shorts.unwrap_or_default();
        // Four numbers a key: which, where its value is (0: here), how many, the value. The first four are a header.
        let entries = shorts.chunks_exact(4).skip(1);
        Self {
            entries: entries
                .map(|key| [key[0], key[1], key[2], key[3]])
                .collect(),
            doubles: numbers(decoder, Tag::GeoDoubleParamsTag),
        }
    }

    fn short(&self, wanted: u16) -> Option<u16> {
        let mut entries = self.entries.iter();
        let found = entries.find(|[key, location, ..]| *key == wanted && *location == 0);
        found.map(|[.., value]| *value)
    }

    fn doubles(&self, [_, location, count, first]: [u16; 4]) -> &[f64] {
        if location != Tag::GeoDoubleParamsTag.to_u16() {
            return &[];
        }
        let past = usize::from(first) + usize::from(count);
        self.doubles.get(usize::from(first)..past).unwrap_or(&[])
    }

    /// Refuses numbers that move places, and lists the keys that are not known.
    fn check(&self, complaints: Complaints<'_>) -> Result<Vec<String>, ElevationError> {
        let mut unknown = Vec::new();
        for &entry in &self.entries {
            match KEYS.binary_search_by_key(&entry[0], |(key, ..)| *key) {
                Err(_) => unknown.push(entry[0].to_string()),
                Ok(row) if KEYS[row].2 == Zero => {
                    let moved = self.doubles(entry).iter().find(|number| **number != 0.0);
                    if let Some(found) = moved {
                        let allowed = format!("0; {}", complaints.gdalwarp());
                        return Err(complaints.value(KEYS[row].1, found, allowed));
                    }
                }
                Ok(_) => {}
            }
        }
        let warning = (!unknown.is_empty()).then(|| {
            format!(
                "keys of the GeoKeyDirectory that are not known and not read: {}",
                unknown.join(", ")
            )
        });
        Ok(warning.into_iter().collect())
    }
}

/// Numbers of a tag, none where there is no such tag.
fn numbers(decoder: &mut Decoder<Cursor<&[u8]>>, tag: Tag) -> Vec<f64> {
    let found = decoder.find_tag(tag).ok().flatten();
    let found = found.and_then(|value| value.into_f64_vec().ok());
    found.unwrap_or_default()
}

impl RasterPlace {
    pub(super) fn read(
        complaints: Complaints<'_>,
        decoder: &mut Decoder<Cursor<&[u8]>>,
    ) -> Result<Self, ElevationError> {
        let keys = Keys::read(decoder);
        let mut warnings = keys.check(complaints)?;
        let projection = projection(complaints, &keys)?;
        let raster = keys.short(RASTER_TYPE);
        let known = [PIXEL_IS_AREA, PIXEL_IS_POINT];
        if let Some(found) = raster.filter(|found| !known.contains(found)) {
            return Err(complaints.value("GTRasterType", found, "1 (areas), 2 (points)"));
        }
        let unit_m = unit_m(complaints, &keys, &mut warnings)?;
        let transformation = numbers(decoder, Tag::ModelTransformationTag);
        let scale = numbers(decoder, Tag::ModelPixelScaleTag);
        let place = Self {
            projection,
            registration: match raster {
                Some(PIXEL_IS_POINT) => Registration::Point,
                // What the standard says of a file that says nothing.
                _ => Registration::Area,
            },
            tie: [0.0; 2],
            at: [0.0; 2],
            scale: [0.0; 2],
            is_south_up: false,
            unit_m,
            warnings,
        };
        match transformation.as_slice() {
            matrix @ [_, _, _, _, _, _, _, _, ..] if scale.is_empty() => {
                place.by_transformation(complaints, matrix)
            }
            _ => place.by_tie(complaints, &scale, &numbers(decoder, Tag::ModelTiepointTag)),
        }
    }

    fn by_tie(
        self,
        complaints: Complaints<'_>,
        scale: &[f64],
        tie: &[f64],
    ) -> Result<Self, ElevationError> {
        for (name, found, least) in [("ModelPixelScale", scale, 2), ("ModelTiepoint", tie, 6)] {
            if found.len() < least {
                let words = format!("{} numbers", found.len());
                let allowed = format!(
                    "at least {least}, or a ModelTransformation; {}",
                    complaints.gdalwarp()
                );
                return Err(complaints.value(name, words, allowed));
            }
        }
        // Height = z of the tie + (value − its k) × scale: only the identity is read.
        let scale_z = scale.get(2).copied().unwrap_or(0.0);
        let is_identity = scale_z == 0.0 || (scale_z == 1.0 && tie[5] == tie[2]);
        if !is_identity {
            let found = format!("{scale_z} from {} at {}", tie[5], tie[2]);
            let allowed = format!(
                "0, or 1 from 0 at 0; {}",
                complaints.gdal_translate("-unscale")
            );
            return Err(complaints.value("ModelPixelScale, third number", found, allowed));
        }
        let mut place = Self {
            tie: [tie[0], tie[1]],
            at: [tie[3], tie[4]],
            scale: [scale[0], scale[1]],
            ..self
        };
        if tie.len() > 6 {
            let count = tie.len() / 6;
            place.warnings.push(format!(
                "ModelTiepoint has {count} points; the first is used, with ModelPixelScale"
            ));
        }
        Ok(place)
    }

    /// Rows of four: x, y and z from column, row and value.
    fn by_transformation(
        self,
        complaints: Complaints<'_>,
        matrix: &[f64],
    ) -> Result<Self, ElevationError> {
        let [east, turned_x, turned_y, south] = [matrix[0], matrix[1], matrix[4], matrix[5]];
        let third = matrix.get(8..12).unwrap_or(&[0.0; 4]);
        let is_height = [[0.0; 4], [0.0, 0.0, 1.0, 0.0]]
            .iter()
            .any(|row| row == third);
        if turned_x != 0.0 || turned_y != 0.0 || east <= 0.0 || !is_height {
            let found = format!(
                "a step of ({east}, {turned_y}) along rows, ({turned_x}, {south}) along columns, heights {third:?}"
            );
            let allowed = format!(
                "rows to the east, columns to the south or north, heights as they are; {}",
                complaints.gdalwarp()
            );
            return Err(complaints.value("ModelTransformation", found, allowed));
        }
        Ok(Self {
            at: [matrix[3], matrix[7]],
            scale: [east, south.abs()],
            is_south_up: south > 0.0,
            ..self
        })
    }

    /// A tie point is a corner of a cell where pixels are areas, a sample where they are points.
    pub(super) fn grid(&self, columns: u32, rows: u32) -> Grid {
        let half = match self.registration {
            Registration::Area => 0.5,
            Registration::Point => 0.0,
        };
        let last_row = f64::from(rows) - 1.0;
        let first_y = if self.is_south_up {
            self.at[1] + (last_row + half - self.tie[1]) * self.scale[1]
        } else {
            self.at[1] - (half - self.tie[1]) * self.scale[1]
        };
        let last_y = first_y - last_row * self.scale[1];
        // Rows of samples on both poles, as ETOPO has them: the half cells beyond are nowhere.
        let beyond = half * self.scale[1];
        let is_past = first_y + beyond > 90.0 + 1e-6 || last_y - beyond < -90.0 - 1e-6;
        let is_on_globe = first_y <= 90.0 + 1e-6 && last_y >= -90.0 - 1e-6;
        let registration = match self.projection {
            Projection::Geographic if is_past && is_on_globe => Registration::Point,
            _ => self.registration,
        };
        Grid {
            projection: self.projection,
            registration,
            columns,
            rows,
            first: [self.at[0] + (half - self.tie[0]) * self.scale[0], first_y],
            step: self.scale,
        }
    }
}

/// Axes of the file, or why it has to be warped first.
fn projection(complaints: Complaints<'_>, keys: &Keys) -> Result<Projection, ElevationError> {
    let warp = |name: &str, found: String, allowed: &str| {
        let allowed = format!("{allowed}; {}", complaints.gdalwarp());
        complaints.value(name, found, allowed)
    };
    let only = |name: &str, found: Option<u16>, allowed: &[u16]| match found {
        Some(found) if !allowed.contains(&found) => {
            let allowed: Vec<String> = allowed.iter().map(u16::to_string).collect();
            Err(warp(name, found.to_string(), &allowed.join(", ")))
        }
        _ => Ok(()),
    };
    match (keys.short(MODEL_TYPE), keys.short(PROJECTED_CRS)) {
        (Some(MODEL_GEOGRAPHIC), _) => {
            let said = |key: u16| keys.short(key).filter(|&value| value != USER_DEFINED);
            let crs = said(GEODETIC_CRS);
            only("GeodeticCRS", crs, &GEODETIC)?;
            if crs.is_none() {
                only("GeodeticDatum", said(GEODETIC_DATUM), &DATUMS)?;
            }
            // One of its own has its longitude in another key.
            only("PrimeMeridian", said(PRIME_MERIDIAN), &[GREENWICH])?;
            only("GeogAngularUnits", keys.short(ANGULAR_UNITS), &DEGREES)?;
            Ok(Projection::Geographic)
        }
        (Some(MODEL_PROJECTED), Some(WEB_MERCATOR)) => {
            only("ProjLinearUnits", keys.short(LINEAR_UNITS), &[METRE])?;
            Ok(Projection::WebMercator)
        }
        (Some(MODEL_PROJECTED), found) => {
            let found = match found {
                Some(zone @ 32_601..=32_660) => format!("{zone} (UTM {} N)", zone - 32_600),
                Some(zone @ 32_701..=32_760) => format!("{zone} (UTM {} S)", zone - 32_700),
                Some(USER_DEFINED) => "one of its own".to_owned(),
                Some(other) => other.to_string(),
                None => "none".to_owned(),
            };
            Err(warp("ProjectedCRS", found, "3857, or a file in degrees"))
        }
        (model, _) => {
            let found = model.map_or("none".to_owned(), |model| model.to_string());
            let allowed = "2 (degrees), or 1 (projected) with ProjectedCRS 3857";
            Err(warp("GTModelType", found, allowed))
        }
    }
}

/// Metres of a unit of height.
fn unit_m(
    complaints: Complaints<'_>,
    keys: &Keys,
    warnings: &mut Vec<String>,
) -> Result<Option<f64>, ElevationError> {
    let said = |key: u16| keys.short(key).filter(|&value| value != USER_DEFINED);
    let system = said(VERTICAL_CRS);
    if let Some(found) = system.filter(|system| DOWN.contains(system)) {
        let allowed = "heights; depths are positive downwards: `gdal_calc.py -A IN.tif --calc=\"-A\" --outfile=OUT.tif`";
        return Err(complaints.value("Vertical", format!("{found} (depths)"), allowed));
    }
    let by_system = match system {
        Some(system) if METRES_UP.contains(&system) => Some(1.0),
        Some(system) if FEET_UP.contains(&system) => Some(FOOT_M),
        Some(system) if SURVEY_FEET_UP.contains(&system) => Some(SURVEY_FOOT_M),
        _ => None,
    };
    let by_unit = match keys.short(VERTICAL_UNITS) {
        None => None,
        Some(METRE) => Some(1.0),
        Some(9002) => Some(FOOT_M),
        Some(9003) => Some(SURVEY_FOOT_M),
        Some(found) => {
            let allowed = "9001 (metre), 9002 (foot), 9003 (US survey foot)";
            return Err(complaints.value("VerticalUnits", found, allowed));
        }
    };
    match (system, by_system, by_unit) {
        (_, Some(a), Some(b)) if a != b => {
            let found = format!(
                "a unit of {b} m with Vertical {}",
                system.unwrap_or_default()
            );
            Err(complaints.value("VerticalUnits", found, format!("its unit, of {a} m")))
        }
        (Some(system), None, Some(_)) => {
            warnings.push(format!(
                "Vertical {system} is not known: heights are read upwards, in the unit that VerticalUnits says"
            ));
            Ok(by_unit)
        }
        (Some(system), None, None) => {
            let allowed = format!(
                "one that is known, or VerticalUnits beside it; where heights are metres upwards, {}",
                complaints.gdal_translate("-a_srs EPSG:4326")
            );
            Err(complaints.value("Vertical", system, allowed))
        }
        _ => Ok(by_unit.or(by_system)),
    }
}
