//! Star catalogs as text: comma-separated values with named columns, and the fixed columns of Hipparcos' hip2.dat.
//!
//! In: the text. Out: the epoch and the stars, or the first wrong line, with its field. A table's first line names its columns; a word such as J2016.0 in that
//! line is the epoch of the positions; the default is J2000. Unknown columns are ignored. Tables of the HYG database are read as such: its `ra` is in hours, so
//! `rarad` and `decrad` are taken, and the row of the Sun is left out. A text whose first line names no columns is hip2.dat (van Leeuwen 2007, CDS I/311),
//! whose positions are of J1991.25. Not read: the measurement errors of the values.

use super::{Star, StarFileError, julian_epoch};
use crate::catalog::csv_line::{borrowed_values, comparable_name, unique_columns_of_fields};
use crate::units::{DAYS_PER_JULIAN_YEAR, KM_PER_AU, RAD_PER_ARCSEC, SECONDS_PER_DAY};
use crate::wording::{echo, echo_within, without_byte_order_mark};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

/// Maximum number of stars in a file. Each takes 72 bytes of memory.
const MAX_STARS: usize = 5_000_000;
/// One au per Julian year, km/s.
const KM_S_PER_AU_YR: f64 = KM_PER_AU / (DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY);
/// Epoch of the positions in hip2.dat, as a Julian year.
const HIPPARCOS_EPOCH: f64 = 1991.25;

/// A quantity of a star.
struct Field {
    /// Its name in messages, with its unit.
    name: &'static str,
    /// The accepted names of its column, reduced to lower-case letters and digits. Earlier ones have precedence.
    columns: &'static [&'static str],
    /// The least and the greatest value, in the unit of the name.
    min: f64,
    max: f64,
    /// Unit or kind of the value, for messages.
    expected: &'static str,
    /// Whether only whole numbers are allowed.
    is_whole: bool,
}

const fn field(name: &'static str, columns: &'static [&'static str], [min, max]: [f64; 2], expected: &'static str) -> Field {
    Field { name, columns, min, max, expected, is_whole: false }
}

/// Indices of the fields in [`FIELDS`].
const RA: usize = 0;
const DEC: usize = 1;
const V: usize = 2;
const HIP: usize = 3;
const PARALLAX: usize = 4;
const PM_RA: usize = 5;
const PM_DEC: usize = 6;
const B_V: usize = 7;
const RADIAL_VELOCITY: usize = 8;
const FIELD_COUNT: usize = 9;
/// The number of required fields, which are the first ones.
const REQUIRED_FIELDS: usize = 3;
/// The fields in the order of the indices above.
static FIELDS: [Field; FIELD_COUNT] = [
    field("ra_deg", &["radeg"], [0.0, 360.0], "degrees"),
    field("dec_deg", &["decdeg", "dedeg"], [-90.0, 90.0], "degrees"),
    field("v_mag", &["vmag", "v", "mag"], [-30.0, 30.0], "magnitudes"),
    // Up to a number that fits into u32, since `id` may be the table's own number.
    Field { is_whole: true, ..field("hip", &["hip", "id"], [0.0, 4.0e9], "a whole number") },
    field("plx_mas", &["plxmas", "plx", "parallax"], [-1000.0, 10_000.0], "milliarcseconds"),
    field("pm_ra_mas_yr", &["pmramasyr", "pmracosdecmasyr", "pmra"], [-1e5, 1e5], "milliarcseconds a year, times cos dec"),
    field("pm_dec_mas_yr", &["pmdecmasyr", "pmdec", "pmde"], [-1e5, 1e5], "milliarcseconds a year"),
    field("b_v", &["bv", "ci"], [-5.0, 15.0], "magnitudes"),
    field("rv_km_s", &["rvkms", "radialvelocitykms", "rv"], [-1e4, 1e4], "kilometres a second"),
];

/// Columns of other names or units that are read if a table lacks the one of [`FIELDS`]: the index of the field, the column, and the factor to the unit
/// of the field. Earlier ones have precedence: the HYG database has `rarad` beside an `ra` in hours.
static OTHER_COLUMNS: [(usize, Field, f64); 5] = [
    (RA, field("rarad", &["rarad"], [0.0, TAU], "radians"), DEG_PER_RAD),
    (RA, field("ra_hours", &["rahours"], [0.0, 24.0], "hours"), DEG_PER_HOUR),
    (RA, field("ra", &[BARE_RA], [0.0, 360.0], "degrees"), 1.0),
    (DEC, field("decrad", &["decrad"], [-FRAC_PI_2, FRAC_PI_2], "radians"), DEG_PER_RAD),
    (DEC, field("dec", &["dec"], [-90.0, 90.0], "degrees"), 1.0),
];
/// A column name without a unit. It counts as degrees if one of its values is above 24, so that they cannot be hours.
const BARE_RA: &str = "ra";
const DEG_PER_RAD: f64 = 360.0 / TAU;
const DEG_PER_HOUR: f64 = 15.0;
/// In a table of the HYG database, a star of at most this magnitude is the Sun: the first row, at right ascension 0.
const SUN_MAGNITUDE: f64 = -20.0;

/// Index and byte range of each field in hip2.dat (ReadMe of catalog I/311). V is not among them: it is computed from Hp, the magnitude in Hipparcos' own band.
const HIP2: [(usize, Range<usize>); 7] =
    [(HIP, 0..6), (RA, 15..28), (DEC, 29..42), (PARALLAX, 43..50), (PM_RA, 51..59), (PM_DEC, 60..68), (B_V, 152..158)];
/// Byte range of the magnitude Hp.
const HIP2_HP: Range<usize> = 129..136;
/// Minimum length of a line of hip2.dat.
const HIP2_BYTES: usize = 158;

/// The column of each field in a table.
struct Columns {
    /// By index of the field in [`FIELDS`].
    by_field: [Option<usize>; FIELD_COUNT],
    /// By the same index: the column's name, unit and range, and the factor to the unit of the field.
    units: [(&'static Field, f64); FIELD_COUNT],
    /// Whether the unit of the right ascension is known only from its values ([`BARE_RA`]).
    has_bare_ra: bool,
    /// Whether the table is of the HYG database.
    is_hyg: bool,
    /// Number of all columns of the table, including ignored ones.
    column_count: usize,
    /// Epoch of the positions, as a Julian year such as 2000.0.
    epoch: f64,
}

/// The line without text in brackets, which may contain commas.
fn without_brackets(line: &str) -> String {
    let mut depth = 0_u32;
    let outside = |c: char| {
        match c {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ => return (depth == 0).then_some(c),
        }
        None
    };
    line.chars().filter_map(outside).collect()
}

impl Columns {
    /// The columns that a table's first line names; `None` if no title begins with a letter, so that the file must be hip2.dat.
    fn named(line: &str) -> Option<Result<Self, String>> {
        let line_without_brackets = without_brackets(line);
        let titles = match borrowed_values(&line_without_brackets) {
            Ok(titles) => titles,
            Err(why) => return Some(Err(why)),
        };
        let names: Vec<String> = titles.iter().map(|name| comparable_name(name)).collect();
        // The earlier of a field's accepted names has precedence: `hip` before `id`, which may be the table's own number.
        let mut by_field = match unique_columns_of_fields(&names, FIELDS.each_ref().map(|f| f.columns)) {
            Ok(by_field) => by_field,
            Err(why) => return Some(Err(why)),
        };
        let others = match unique_columns_of_fields(&names, OTHER_COLUMNS.each_ref().map(|(_, f, _)| f.columns)) {
            Ok(others) => others,
            Err(why) => return Some(Err(why)),
        };
        let mut units = FIELDS.each_ref().map(|f| (f, 1.0));
        let mut has_bare_ra = false;
        for ((k, f, factor), column) in OTHER_COLUMNS.iter().zip(others) {
            if by_field[*k].is_none() && column.is_some() {
                (by_field[*k], units[*k]) = (column, (f, *factor));
                has_bare_ra |= f.columns == [BARE_RA];
            }
        }
        if by_field[RA].is_none() && by_field[DEC].is_none() && !names.iter().any(|n| n.starts_with(|c: char| c.is_ascii_alphabetic())) {
            return None;
        }
        if let Some(missing) = (0..REQUIRED_FIELDS).find(|k| by_field[*k].is_none()) {
            let f = &FIELDS[missing];
            return Some(Err(format!("no column `{}` ({}); the first line must name it", f.name, f.expected)));
        }
        // Words such as J2 or J0437 in a title are no years.
        let words = line.split(|c: char| !(c.is_ascii_alphanumeric() || c == '.'));
        let years = words.filter_map(|w| w.strip_prefix('J')?.parse::<f64>().ok());
        let epoch = years.into_iter().find(|y| (1000.0..3000.0).contains(y)).unwrap_or(2000.0);
        let is_hyg = ["rarad", "decrad", "proper"].iter().all(|title| names.iter().any(|name| name == title));
        Some(Ok(Self { by_field, units, has_bare_ra, is_hyg, column_count: names.len(), epoch }))
    }
}

/// Parses the number of a field and checks its range.
fn number(f: &Field, text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|v| (f.min..=f.max).contains(v) && (!f.is_whole || v.fract() == 0.0));
    value.ok_or_else(|| format!("{} is `{}`; expected {} from {} to {}", f.name, echo_within(text.trim(), 40), f.expected, f.min, f.max))
}

/// A star from its fields; the required fields must be present, and the others count as 0 if they are missing, except B-V.
fn star(values: &[Option<f64>; FIELD_COUNT]) -> Star {
    let value = |k: usize| values[k].unwrap_or(0.0);
    let ((sin_ra, cos_ra), (sin_dec, cos_dec)) = (value(RA).to_radians().sin_cos(), value(DEC).to_radians().sin_cos());
    let direction = DVec3::new(cos_dec * cos_ra, cos_dec * sin_ra, sin_dec);
    let (east, north) = (DVec3::new(-sin_ra, cos_ra, 0.0), DVec3::new(-sin_dec * cos_ra, -sin_dec * sin_ra, cos_dec));
    let rad_per_mas = RAD_PER_ARCSEC / 1000.0;
    // The measured parallax of a distant star can be negative because of its error; it then counts as not measured.
    let parallax_rad = value(PARALLAX).max(0.0) * rad_per_mas;
    // Radial velocity in au a year, divided by the distance in au.
    let radial_per_year = value(RADIAL_VELOCITY) / KM_S_PER_AU_YR * parallax_rad;
    Star {
        hip: value(HIP) as u32,
        direction,
        motion_per_year: (east * value(PM_RA) + north * value(PM_DEC)) * rad_per_mas + direction * radial_per_year,
        parallax_rad,
        v_magnitude: value(V) as f32,
        b_v: values[B_V].map(|b_v| b_v as f32),
    }
}

/// The values of a row of a table, in the units of the fields.
fn values_of_row(line: &str, columns: &Columns) -> Result<[Option<f64>; FIELD_COUNT], String> {
    let cells = borrowed_values(line)?;
    if cells.len() != columns.column_count {
        return Err(format!("{} values, and the first line names {} columns", cells.len(), columns.column_count));
    }
    let mut values = [None; FIELD_COUNT];
    for (k, (f, factor)) in columns.units.iter().enumerate() {
        let text = columns.by_field[k].map_or("", |column| cells[column].as_ref());
        if !text.is_empty() {
            values[k] = Some(number(f, text)? * factor);
        } else if k < REQUIRED_FIELDS {
            return Err(format!("{} is empty; expected {} from {} to {}", f.name, f.expected, f.min, f.max));
        }
    }
    Ok(values)
}

/// V from Hipparcos' magnitude Hp and B-V (Harmanec 1998, Astron. Astrophys. 335, 173, with U-B = 0): within 0.02 magnitudes for
/// common stars. The polynomial of ESA SP-1200, volume 1, table 1.3.5 differs by less than 0.005 at B-V of 0.6 and 1.2, which were compared. B-V outside -0.3
/// to 1.6, as few stars have it, counts as the nearer limit.
fn v_from_hp(hp: f64, b_v: f64) -> f64 {
    let x = b_v.clamp(-0.3, 1.6);
    hp + 0.0072 + x * (-0.2964 + x * (0.1110 + x * 0.0157))
}

/// The star of a line of hip2.dat.
fn star_from_hip2(line: &str) -> Result<Star, String> {
    let too_short = || "too short for hip2.dat, and the first line has no columns such as ra_deg,dec_deg,v_mag".to_owned();
    if line.len() < HIP2_BYTES {
        return Err(too_short());
    }
    let cell = |bytes: &Range<usize>| line.get(bytes.clone()).ok_or_else(too_short);
    let mut values = [None; FIELD_COUNT];
    for (k, bytes) in &HIP2 {
        let text = cell(bytes)?;
        // The positions of hip2.dat are in radians. They are converted as text, because `number` takes text; text that is no number goes into its message.
        let text = if matches!(*k, RA | DEC) {
            text.trim().parse::<f64>().map_or(text.to_owned(), |v| v.to_degrees().to_string())
        } else {
            text.to_owned()
        };
        values[*k] = Some(number(&FIELDS[*k], &text)?);
    }
    let hp = number(&Field { name: "Hpmag", ..FIELDS[V] }, cell(&HIP2_HP)?)?;
    values[V] = Some(v_from_hp(hp, values[B_V].unwrap_or(0.0)));
    Ok(star(&values))
}

/// Reads a catalog: its epoch as a Julian date (TT), and its stars. `file_name`: for errors.
pub(super) fn read(file_name: &str, text: &str) -> Result<(f64, Vec<Star>), StarFileError> {
    let file_error = |line: usize, message: String| StarFileError { file: echo(file_name), line, message };
    let text = without_byte_order_mark(text);
    let mut lines = text.lines().enumerate().map(|(k, line)| (k + 1, line)).filter(|(_, line)| !line.trim().is_empty()).peekable();
    let Some((first_line_number, line)) = lines.peek().copied() else { return Err(file_error(1, "no stars: the file is empty".into())) };
    let columns = Columns::named(line.trim_start_matches('#')).transpose().map_err(|e| file_error(first_line_number, e))?;
    if columns.is_some() {
        lines.next();
    }
    let mut stars = Vec::new();
    let mut greatest_ra = 0.0_f64;
    for (line_number, line) in lines.filter(|(_, line)| !line.starts_with('#')) {
        if stars.len() == MAX_STARS {
            return Err(file_error(line_number, format!("more than {MAX_STARS} stars")));
        }
        let Some(columns) = &columns else {
            stars.push(star_from_hip2(line).map_err(|e| file_error(line_number, e))?);
            continue;
        };
        let values = values_of_row(line, columns).map_err(|e| file_error(line_number, e))?;
        if columns.is_hyg && values[V].is_some_and(|v| v <= SUN_MAGNITUDE) {
            continue;
        }
        greatest_ra = greatest_ra.max(values[RA].unwrap_or(0.0));
        stars.push(star(&values));
    }
    if stars.is_empty() {
        return Err(file_error(first_line_number, "no stars below the line that names the columns".into()));
    }
    if columns.as_ref().is_some_and(|c| c.has_bare_ra) && greatest_ra <= 24.0 {
        let why = "no value of the column `ra` is above 24, so it may be in hours; name it ra_deg (degrees), ra_hours or rarad (radians)";
        return Err(file_error(first_line_number, why.into()));
    }
    Ok((julian_epoch(columns.map_or(HIPPARCOS_EPOCH, |c| c.epoch)), stars))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of hip2.dat with these values and plausible values in the other columns.
    fn hip2(ra_rad: f64, dec_rad: f64, hp: &str) -> String {
        let place = format!(
            "{:>6} {:>3} {:>1} {:>1} {ra_rad:13.10} {dec_rad:13.10} {:>7} {:>8} {:>8}",
            91_262, 5, 0, 1, "130.23", "200.94", "286.23"
        );
        let errors =
            format!("{:>6} {:>6} {:>6} {:>6} {:>6} {:>3} {:>5} {:>2} {:>6} {:>4}", 0.33, 0.36, 0.36, 0.37, 0.44, 114, 1.33, 0, 0.0, 0);
        format!("{place} {errors} {hp:>7} 0.0017 0.005 1 {:>6} 0.003 -0.010", "-0.001")
    }

    #[test]
    fn both_formats_give_the_same_star() {
        let (ra_deg, dec_deg) = (279.234_108_f64, 38.782_993_f64);
        let table = format!(
            "# name,RA_deg(ICRS, J1991.25),dec_deg,V,plx,pmRA,pmDec,B-V\nVega,{ra_deg},{dec_deg},0.03,130.23,200.94,286.23,-0.001\n"
        );
        let (epoch, table_stars) = read("a.csv", &table).expect("a table");
        let hip2_text = hip2(ra_deg.to_radians(), dec_deg.to_radians(), "0.0868");
        let (hip2_epoch, hip2_stars) = read("hip2.dat", &hip2_text).expect("hip2.dat");
        for (text, stars) in [(&table, &table_stars), (&hip2_text, &hip2_stars)] {
            assert_eq!(&read("marked", &format!("\u{feff}{text}")).expect("a byte order mark").1, stars, "{text}");
        }
        assert!(epoch == hip2_epoch && epoch == julian_epoch(1991.25));
        let (a, b) = (table_stars[0], hip2_stars[0]);
        assert!(a.direction.distance(b.direction) < 1e-9 && a.motion_per_year.distance(b.motion_per_year) < 1e-12);
        assert_eq!((a.parallax_rad, a.b_v, b.hip), (b.parallax_rad, b.b_v, 91_262));
        // Vega's Hp is 0.0868, from which `v_from_hp` gives 0.094; its V in the table is 0.03.
        assert!((a.v_magnitude - b.v_magnitude).abs() < 0.07, "{} {}", a.v_magnitude, b.v_magnitude);
        assert_eq!(read("b.csv", "ra_deg,dec,mag\n0,0,1\n").expect("few columns").0, julian_epoch(2000.0));
        // `id` (the table's own number) is not taken for the Hipparcos number, nor `ra` (in hours) for degrees.
        let (_, stars) = read("c.csv", "id,hip,ra,dec,mag,ra_deg\n90979,91262,18.6,38.8,0.03,279.2\n").expect("other columns");
        assert!(stars[0].hip == 91_262 && stars[0].direction.distance(a.direction) < 1e-3, "{:?}", stars[0]);
        let (_, quoted) = read("d.csv", "\"name, usual\",ra,dec,mag\n\"Vega, alpha Lyrae\",279.2,38.8,0.03\n").expect("quoted values");
        assert!(quoted[0].direction.distance(a.direction) < 1e-3, "{:?}", quoted[0]);
    }

    /// The first rows of the HYG database, version 4, without the columns that are not read. Its `ra` is in hours.
    #[test]
    fn tables_in_other_units_give_the_same_directions() {
        let head = "id,hip,proper,ra,dec,dist,pmra,pmdec,rv,mag,ci,rarad,decrad";
        let sirius = "32263,32349,Sirius,6.752481,-16.716116,2.6371,-546.01,-1223.08,-9.4,-1.440,0.009,1.7677953919,-0.2917512623";
        let hyg = format!("{head}\n0,,Sol,0,0,0,0,0,0,-26.7,0.656,0,0\n{sirius}\n");
        let (_, stars) = read("hyg.csv", &hyg).expect("HYG");
        let (_, expected) = read("s.csv", "ra_deg,dec_deg,v_mag\n101.287215,-16.716116,-1.44\n").expect("degrees");
        assert_eq!((stars.len(), stars[0].hip, stars[0].b_v), (1, 32_349, Some(0.009)), "the Sun is left out");
        assert!(stars[0].direction.distance(expected[0].direction) < 1e-6, "{:?}", stars[0].direction);
        let (_, hours) = read("h.csv", "ra_hours,dec,mag\n6.752481,-16.716116,-1.44\n").expect("hours");
        assert!(hours[0].direction.distance(expected[0].direction) < 1e-6, "{:?}", hours[0].direction);
        // Without the columns in radians the unit is unknown, unless a value cannot be in hours.
        let bare = |ra: &str| read("b.csv", &format!("ra,dec,mag\n6.75,-16.7,-1.44\n{ra},2,3\n"));
        let refused = bare("23.9").expect_err("hours or degrees").to_string();
        assert!(refused.starts_with("b.csv:1: ") && ["ra_deg", "ra_hours", "rarad"].iter().all(|name| refused.contains(name)), "{refused}");
        assert_eq!(bare("24.5").expect("degrees").1.len(), 2);
        let radians = read("r.csv", "rarad,decrad,mag\n101.3,0,1\n").expect_err("not radians").to_string();
        assert!(radians.contains("rarad is `101.3`; expected radians"), "{radians}");
    }

    #[test]
    fn errors_name_line_and_field() {
        let why = |text: &str| read("s.csv", text).expect_err(text).to_string();
        assert_eq!(why("ra_deg,v\n1,2\n"), "s.csv:1: no column `dec_deg` (degrees); the first line must name it");
        assert_eq!(why("ra,dec,v\n1,2,3\n1,95,3\n"), "s.csv:3: dec is `95`; expected degrees from -90 to 90");
        assert_eq!(why("ra,dec,v\n1,2,\n"), "s.csv:2: v_mag is empty; expected magnitudes from -30 to 30");
        assert_eq!(why("ra,dec,v,V\n1,2,3,4\n"), "s.csv:1: two columns are named `v` (only letters and digits count); leave one out");
        assert_eq!(why("ra,dec,v\n1,2\n"), "s.csv:2: 2 values, and the first line names 3 columns");
        assert!(why("ra,dec,v\n1,2,NaN\n").contains("v_mag is `NaN`") && why("ra,dec,v\n1,inf,1\n").contains("dec is `inf`"));
        assert_eq!(why("hip,ra,dec,v\n32349.5,1,2,3\n"), "s.csv:2: hip is `32349.5`; expected a whole number from 0 to 4000000000");
        assert_eq!(why("ra,dec,v,name\n1,2,3,\"Vega\n"), "s.csv:2: a quoted value does not end on this line");
        assert!(why("").contains("empty") && why("ra,dec,v\n").contains("no stars"));
        assert!(why("12 13 14\n").contains("too short"));
        assert!(why(&hip2(1.0, 0.5, "bright")).contains("Hpmag is `bright`"));
        assert!(why(&hip2(7.0, 0.5, "1.0")).contains("ra_deg"));
        assert!(!why("ra,dec,v\n1,2,\u{1b}[2J\n").contains('\u{1b}'));
    }
}
