//! World coordinates of a FITS image (Greisen & Calabretta 2002, A&A 395, 1061; Calabretta & Greisen 2002, A&A 395, 1077).
//!
//! In: the header. Out: the tangent plane of a sky image (TAN), or the edges of a map of a body (plate carree: CAR, or an image without coordinates that is
//! twice as wide as high). Always: an image with another projection, distortion or frame is rejected, and so is a map of a body with a rotated pole,
//! since it would appear at the wrong place.

use super::header::{CardError, Header};
use crate::wording::echo_within;

/// The position of an image on the sky or a body.
#[derive(Clone, Debug, PartialEq)]
pub enum ImageWcs {
    /// On the sky.
    Tangent {
        /// Right ascension and declination (ICRF) of the point of tangency, degrees.
        centre_deg: [f64; 2],
        /// The pixel coordinates of the point of tangency, x to the right, y up; (1, 1) is the centre of the lower left pixel.
        centre_px: [f64; 2],
        /// Degrees in the tangent plane per pixel. Rows: degrees east and north; columns: pixels to the right and up.
        deg_per_px: [[f64; 2]; 2],
    },
    /// On a body: its edges, planetographic latitude and east longitude.
    PlateCarree {
        /// Western edge.
        west_deg: f64,
        /// Eastern edge, greater than `west_deg`.
        east_deg: f64,
        /// Southern edge.
        south_deg: f64,
        /// Northern edge.
        north_deg: f64,
        /// Whether the columns of the file run from east to west; those of [`PlacedImage`](super::PlacedImage) do not.
        mirrored: bool,
    },
}

/// Largest pixel coordinate of the point of tangency of a sky image, which may lie outside of the image.
const MAX_CENTRE_PX: f64 = 1e7;

/// The error of a card whose value is not supported.
fn unsupported_card(header: &Header, keyword: &str, why: &str) -> CardError {
    (header.card_number(keyword), format!("{keyword}: `{}`: {why}", echo_within(header.text(keyword), 30)))
}

/// The number of the card with the scale along an axis, 1 or 2: of CD, or of CDELT in a file without CD.
fn scale_card_number(header: &Header, axis: u8) -> usize {
    let keywords = [format!("CD{axis}_{axis}"), format!("CDELT{axis}")];
    keywords.iter().find(|k| !header.text(k).is_empty()).map_or(1, |k| header.card_number(k))
}

/// The numeric value of a card that the image must have. A value outside ±`limit` is an error.
fn required(header: &Header, keyword: &str, limit: f64) -> Result<f64, CardError> {
    match header.number(keyword)? {
        Some(v) if v.abs() <= limit => Ok(v),
        Some(_) => {
            let value = echo_within(header.text(keyword), 30);
            Err((header.card_number(keyword), format!("{keyword}: `{value}` is not within ±{limit}")))
        }
        None => Err((1, format!("{keyword} is missing"))),
    }
}

/// The matrix from pixels to intermediate world coordinates, degrees: CD, or CDELT with PC or CROTA2.
fn matrix(header: &Header) -> Result<[[f64; 2]; 2], CardError> {
    let number = |keyword: &str| header.number(keyword);
    let matrix_cards = |name: &str| -> Result<[[Option<f64>; 2]; 2], CardError> {
        let element = |k: &str| number(&format!("{name}{k}"));
        Ok([[element("1_1")?, element("1_2")?], [element("2_1")?, element("2_2")?]])
    };
    let cd = matrix_cards("CD")?;
    let deg_per_px = if cd.iter().flatten().any(Option::is_some) {
        cd.map(|row| row.map(|v| v.unwrap_or(0.0)))
    } else {
        let pc = matrix_cards("PC")?;
        let has_pc = pc.iter().flatten().any(Option::is_some);
        // With PC, CDELT has the default 1 (FITS 4.0, section 8.2). Without CD, PC and CDELT nothing states the scale.
        let default = has_pc.then_some(1.0);
        let [Some(dx), Some(dy)] = [number("CDELT1")?.or(default), number("CDELT2")?.or(default)] else {
            return Err((1, "CD1_1 or CDELT1 and CDELT2: missing; the image has no scale".to_owned()));
        };
        if has_pc {
            let [[a, b], [c, d]] = pc;
            [[dx * a.unwrap_or(1.0), dx * b.unwrap_or(0.0)], [dy * c.unwrap_or(0.0), dy * d.unwrap_or(1.0)]]
        } else {
            let (sin, cos) = number("CROTA2")?.unwrap_or(0.0).to_radians().sin_cos();
            [[dx * cos, -dy * sin], [dx * sin, dy * cos]]
        }
    };
    let [[a, b], [c, d]] = deg_per_px;
    let area = (a * d - b * c).abs();
    // A pixel has at least 1e-9 square arcseconds and at most 10,000 square degrees, about a quarter of the sky.
    if !(1e-9 / (3600.0 * 3600.0)..=1e4).contains(&area) {
        return Err((scale_card_number(header, 1), format!("a pixel of {area:.1e} square degrees cannot be placed")));
    }
    Ok(deg_per_px)
}

/// Rejects axes in units other than degrees. The standard's name of the unit is `deg` (FITS 4.0, section 4.3, table 3); other spellings are common.
fn check_units(header: &Header) -> Result<(), CardError> {
    for keyword in ["CUNIT1", "CUNIT2"] {
        let unit = header.text(keyword);
        if !unit.is_empty() && !["deg", "degree", "degrees"].iter().any(|degrees| unit.eq_ignore_ascii_case(degrees)) {
            return Err(unsupported_card(header, keyword, "only degrees (deg) are supported"));
        }
    }
    Ok(())
}

/// The tangent plane of an image of the sky.
pub(super) fn of_sky_image(header: &Header) -> Result<ImageWcs, CardError> {
    let types = [header.text("CTYPE1"), header.text("CTYPE2")];
    if types != ["RA---TAN", "DEC--TAN"] {
        let keyword = if types[0] == "RA---TAN" { "CTYPE2" } else { "CTYPE1" };
        return Err(unsupported_card(header, keyword, "on the sky only RA---TAN with DEC--TAN, without distortion, is drawn"));
    }
    // Distortions as in the images of Spitzer (SIP: A_ORDER, B_ORDER) and in those of SCAMP (PV).
    for keyword in ["A_ORDER", "B_ORDER", "PV1_5", "PV2_1"] {
        if !header.text(keyword).is_empty() {
            return Err(unsupported_card(header, keyword, "distorted images are not drawn"));
        }
    }
    // In older files RADESYS is called RADECSYS, and EQUINOX is called EPOCH (standard, section 8.3).
    let frame = if header.text("RADESYS").is_empty() { "RADECSYS" } else { "RADESYS" };
    let has_known_frame = matches!(header.text(frame), "" | "ICRS" | "FK5");
    // In some files EPOCH is the time of the observation, a text or 0; it is ignored if it cannot be an equinox. The ICRS has no equinox.
    let is_equinox = |year: &f64| (1800.0..2100.0).contains(year) && header.text(frame) != "ICRS";
    let (keyword, equinox) = match header.number("EQUINOX")? {
        Some(year) => ("EQUINOX", Some(year)),
        None => ("EPOCH", header.number("EPOCH").ok().flatten().filter(is_equinox)),
    };
    if !has_known_frame || !matches!(equinox, None | Some(2000.0)) {
        let keyword = if has_known_frame { keyword } else { frame };
        return Err(unsupported_card(header, keyword, "only ICRS and FK5 J2000 coordinates are supported"));
    }
    check_units(header)?;
    let centre_deg = [required(header, "CRVAL1", 360.0)?, required(header, "CRVAL2", 90.0)?];
    let centre_px = [required(header, "CRPIX1", MAX_CENTRE_PX)?, required(header, "CRPIX2", MAX_CENTRE_PX)?];
    // LONPOLE states on which side of the image north is. Without it, north is up (180), but in an image around the north pole it is down (0; Calabretta &
    // Greisen, section 2.2).
    let default_lonpole = if centre_deg[1] < 90.0 { 180.0 } else { 0.0 };
    let deg_per_px = with_north_up(matrix(header)?, header.number("LONPOLE")?.unwrap_or(default_lonpole));
    Ok(ImageWcs::Tangent { centre_deg, centre_px, deg_per_px })
}

/// Rotates a matrix from pixels to intermediate world coordinates, so that its rows give degrees east and degrees north. `lonpole_deg`: the native longitude
/// of the celestial pole, 0 if north is towards the image's bottom, 90 if it is along x, 180 if it is at the top.
fn with_north_up([x_row, y_row]: [[f64; 2]; 2], lonpole_deg: f64) -> [[f64; 2]; 2] {
    // Sine and cosine of the usual values, without rounding errors.
    let (sin, cos) = match lonpole_deg {
        180.0 => (0.0, -1.0),
        0.0 => (0.0, 1.0),
        angle => angle.to_radians().sin_cos(),
    };
    // Sums that start at 0.0 are never -0.0, so the matrix of an unrotated image has plain zeros.
    let east = [0, 1].map(|axis| 0.0 - cos * x_row[axis] - sin * y_row[axis]);
    let north = [0, 1].map(|axis| 0.0 + sin * x_row[axis] - cos * y_row[axis]);
    [east, north]
}

/// The edges of a map of a body. The size is the image's width and height, pixels.
pub(super) fn of_body_map(header: &Header, [width, height]: [u32; 2]) -> Result<ImageWcs, CardError> {
    let types = [header.text("CTYPE1"), header.text("CTYPE2")];
    if types == ["", ""] && width == 2 * height {
        return Ok(ImageWcs::PlateCarree { west_deg: -180.0, east_deg: 180.0, south_deg: -90.0, north_deg: 90.0, mirrored: false });
    }
    let is_car = |text: &str, axis: &str| text.strip_suffix("CAR").is_some_and(|name| name.trim_end_matches('-') == axis);
    // Axes of a body's map are named xxLN and xxLT, or LON and LAT; GLON and RA are coordinates of the sky.
    let has_longitude = types[0].get(2..4) == Some("LN") && types[0].ends_with("-CAR");
    let has_latitude = types[1].get(2..4) == Some("LT") && types[1].ends_with("-CAR");
    if !(has_longitude && has_latitude || is_car(types[0], "LON") && is_car(types[1], "LAT")) {
        return Err(unsupported_card(
            header,
            "CTYPE1",
            "on a body a plate carree (xxLN-CAR, xxLT-CAR) is drawn, or a map of the whole globe without CTYPE, twice as wide as high",
        ));
    }
    check_units(header)?;
    if header.number("CRVAL2")?.unwrap_or(0.0) != 0.0 {
        return Err(unsupported_card(
            header,
            "CRVAL2",
            "only a plate carree with CRVAL2 = 0 is supported: any other value means a rotated map",
        ));
    }
    if !matches!(header.number("LONPOLE")?, None | Some(0.0 | 180.0)) {
        return Err(unsupported_card(header, "LONPOLE", "only 0 and 180 are supported: any other value means a rotated map"));
    }
    // With CRVAL2 = 0, LONPOLE allows two orientations. The one whose pole has the latitude nearest to LATPOLE (90 by default) applies (Calabretta &
    // Greisen, section 2.4), so south is up if LATPOLE is negative.
    if header.number("LATPOLE")?.is_some_and(|latitude| latitude < 0.0) {
        return Err(unsupported_card(header, "LATPOLE", "only a map with north up is supported: a negative value means that south is up"));
    }
    // Degrees per pixel. `lon_by_y` and `lat_by_x` are 0 except for rounding errors unless the map is rotated.
    let [[dx, lon_by_y], [lat_by_x, dy]] = matrix(header)?;
    if lon_by_y.abs() > 1e-9 || lat_by_x.abs() > 1e-9 || dy <= 0.0 {
        return Err((
            scale_card_number(header, 2),
            "a rotated map, or one whose rows run from north to south, is not supported".to_owned(),
        ));
    }
    // The limits keep the edges short in a message.
    let [reference_x, reference_y, reference_lon_deg] =
        [required(header, "CRPIX1", 1e10)?, required(header, "CRPIX2", 1e10)?, required(header, "CRVAL1", 720.0)?];
    // Pixel 1 is centred at the pixel coordinate 1, so that its outer edge is at 0.5.
    let edges_deg = [0.5, f64::from(width) + 0.5].map(|px| reference_lon_deg + (px - reference_x) * dx);
    let [west_deg, east_deg] = if dx < 0.0 { [edges_deg[1], edges_deg[0]] } else { edges_deg };
    let [south_deg, north_deg] = [0.5, f64::from(height) + 0.5].map(|px| (px - reference_y) * dy);
    // Rounding may place an edge slightly beyond a pole, or the edges slightly more than 360 degrees apart.
    let tolerance_deg = 1e-6;
    if east_deg - west_deg > 360.0 + tolerance_deg
        || west_deg.abs() > 360.0
        || south_deg < -90.0 - tolerance_deg
        || north_deg > 90.0 + tolerance_deg
    {
        return Err((
            header.card_number("CRPIX1"),
            format!("longitudes {west_deg} to {east_deg} and latitudes {south_deg} to {north_deg} do not fit on a globe"),
        ));
    }
    let (east_deg, south_deg, north_deg) = (east_deg.min(west_deg + 360.0), south_deg.max(-90.0), north_deg.min(90.0));
    Ok(ImageWcs::PlateCarree { west_deg, east_deg, south_deg, north_deg, mirrored: dx < 0.0 })
}
