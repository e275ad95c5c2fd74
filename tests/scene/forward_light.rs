//! The tables `forward_light` of catalogs/atmospheres.toml are the light of drawn discs less that of the ground in their points (catalogs/README.md).
//!
//! After a change of the air `ORRERY_RECORD_FORWARD_LIGHT=1 cargo test --test main forward_light` records the tables, in one run.

use super::points_like_discs::{DISC_WITH_LOW_RIM, POINT, TIME, light_in};
use crate::support::session::{SESSION, sources};
use crate::support::{scratch, sweep, switch};
use glam::DVec3;
use orrery::catalog::Body;
use orrery::session::{Session, Sources};
use orrery::time::Instant;
use orrery::units::luminance;
use std::cell::LazyCell;
use std::path::Path;

/// Where the published law of Mars ends. Beyond it the ground keeps the factor that it has there. The other bodies with a table have no law.
const LAW_ENDS_DEG: f64 = 120.0;

/// Periods of rotation of the bodies with a table (Titan and Pluto are locked to their orbits). They have bright and dark sides.
const ROTATION_HOURS: [(i32, f64); 3] = [(499, 24.623), (606, 382.69), (999, 153.293)];

/// The bodies with a table, and their tables.
fn tables() -> Vec<(&'static Body, &'static [[f64; 4]])> {
    let table = |body: &'static Body| Some((body, body.atmosphere.as_ref()?.forward_light.as_slice()));
    SESSION.catalog().bodies().iter().filter_map(table).filter(|(_, rows)| !rows.is_empty()).collect()
}

/// The text of catalogs/atmospheres.toml.
fn catalog_text() -> String {
    let (_, text) = orrery_catalogs::CATALOG_FILES.iter().find(|(name, _)| *name == "atmospheres.toml").expect("listed");
    (*text).to_owned()
}

/// A number to three significant digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.2e}").parse().expect("a number")
}

/// The file's text with other rows of a body.
fn with_rows(text: &str, body: &Body, rows: &[[f64; 4]]) -> String {
    const FIRST_LINE: &str = "forward_light = [\n";
    let of_body = text.find(&format!("body = \"{}\"\n", body.name)).expect("the body's air");
    let from = of_body + text[of_body..].find(FIRST_LINE).expect("a table") + FIRST_LINE.len();
    let to = from + text[from..].find("]\n").expect("the table's end");
    // Never with an exponent, always with a point.
    let number = |x: f64| if x.fract() == 0.0 { format!("{x:.1}") } else { x.to_string() };
    let lines: String = rows.iter().map(|row| format!("    [{}],\n", row.map(number).join(", "))).collect();
    format!("{}{lines}{}", &text[..from], &text[to..])
}

/// A session in whose catalog the haze of every body with a table gives its point this radiance at every phase angle. The disc only notices that the haze
/// leaves less of a published law to the ground.
fn session_with_radiance(radiance: f64) -> Session {
    let rows = [[0.0, radiance, radiance, radiance]];
    let text = tables().into_iter().fold(catalog_text(), |text, (body, _)| with_rows(&text, body, &rows));
    let folder = scratch::folder(&format!("forward-light-{radiance}"));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("atmospheres.toml"), text).expect("written");
    Session::open(&Sources { catalogs: Some(folder), ..sources() }, |line| panic!("{line}")).expect("opens")
}

/// A body at a phase angle, in the unit of its table: the mean of four moments, a quarter of a rotation apart.
struct Measured {
    /// The ground's light in the point, if the haze takes nothing from a published law.
    ground: DVec3,
    /// The light of the disc with its air over such ground.
    disc: DVec3,
    /// The ground's light in `disc`; 0 without a published law, where it is not needed.
    ground_in_disc: DVec3,
    /// The smallest part of a published law that is left to the ground; 1 without a law.
    least_part: f64,
}

impl Measured {
    /// `sessions`: with radiances of 0 and 1. `effects`: of the disc.
    fn of(sessions: &[Session; 2], body: &Body, phase_deg: f64, effects: &str) -> Self {
        let (_, rotation_hours) = ROTATION_HOURS.iter().find(|(id, _)| *id == body.id.0).expect("its period of rotation is listed");
        let start = Instant::parse(TIME).expect("a time");
        let times = [0.0, 0.25, 0.5, 0.75].map(|turn| start.plus_seconds(turn * rotation_hours * 3600.0));
        let mean = |session: &Session, size: [u32; 2], effects: &str| -> DVec3 {
            let effects = format!(",-planet-shine,-eclipse,-rings{effects}");
            times.iter().map(|time| light_in(session, body.id, phase_deg, *time, 400.0, size, &effects)).sum::<DVec3>() / 4.0
        };
        let [ground, least_ground] = [0, 1].map(|k| mean(&sessions[k], POINT, ",-atmosphere"));
        // A radiance of 1.
        let unit = (mean(&sessions[1], POINT, "") - least_ground).y;
        let [disc, disc_over_least] = [0, 1].map(|k| mean(&sessions[k], DISC_WITH_LOW_RIM, effects));
        let least_part = least_ground.y / ground.y;
        let has_law = least_part < 0.999;
        let ground_in_disc = if has_law { (disc - disc_over_least) / (1.0 - least_part) } else { DVec3::ZERO };
        Self { ground: ground / unit, disc: disc / unit, ground_in_disc: ground_in_disc / unit, least_part }
    }

    /// The part of a published law that the haze leaves to the ground: the one with which the disc has the law's light.
    fn ground_part(&self) -> f64 {
        let excess = luminance((self.disc - self.ground).to_array()) / luminance(self.ground_in_disc.to_array()).max(1e-12);
        (1.0 - excess).max(self.least_part).min(1.0)
    }

    /// The light that the table gives to the point, so that it has the light of the disc. `part`: of the law, left to the ground.
    fn light(&self, part: f64) -> DVec3 {
        (self.disc - self.ground_in_disc * (1.0 - part) - self.ground * part).max(DVec3::ZERO)
    }
}

/// Within 3 %, and within the error of a faint light that is the difference of two brighter ones.
fn is_as_recorded(found: DVec3, recorded: DVec3) -> bool {
    (found - recorded).abs().max_element() < 1e-4 + 0.03 * recorded.max_element()
}

/// The first row of a table is where the haze begins to matter, and has no light. The others are computed; each run compares a part of them, a full sweep and a
/// recording all.
#[test]
fn tables_are_the_light_of_drawn_discs() {
    let records = switch::is_on("ORRERY_RECORD_FORWARD_LIGHT");
    let sessions = [0.0, 1.0].map(session_with_radiance);
    let (mut text, mut case, mut failures) = (catalog_text(), 0, Vec::new());
    for (body, recorded) in tables() {
        let part_at_end_of_law = LazyCell::new(|| Measured::of(&sessions, body, LAW_ENDS_DEG, "").ground_part());
        let mut rows = recorded.to_vec();
        for row in rows.iter_mut().skip(1) {
            case += 1;
            if !records && !sweep::runs(case, 4) {
                continue;
            }
            let [phase_deg, rgb @ ..] = *row;
            let measured = Measured::of(&sessions, body, phase_deg, "");
            let part = if phase_deg <= LAW_ENDS_DEG { measured.ground_part() } else { *part_at_end_of_law };
            let (found, now) = (measured.light(part), DVec3::from_array(rgb));
            println!("{} at {phase_deg}: {found:.5}, recorded {now:.5}, {part:.3} of a law is left to the ground", body.name);
            if !is_as_recorded(found, now) {
                failures.push(format!("{} at {phase_deg}: {found:.5}, recorded {now:.5}", body.name));
            }
            let [red, green, blue] = found.to_array().map(rounded);
            *row = [phase_deg, red, green, blue];
        }
        // Negative control: a disc without its air, at the last phase angle.
        let [phase_deg, rgb @ ..] = recorded[recorded.len() - 1];
        let without_air = Measured::of(&sessions, body, phase_deg, ",-atmosphere");
        let found = without_air.light(without_air.least_part);
        assert!(!is_as_recorded(found, DVec3::from_array(rgb)), "{} without its air: {found}", body.name);
        text = with_rows(&text, body, &rows);
    }
    if records {
        std::fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join("catalogs/atmospheres.toml"), text).expect("written");
    } else {
        let how_to_record = "to record intended changes: ORRERY_RECORD_FORWARD_LIGHT=1 cargo test --test main forward_light";
        assert!(failures.is_empty(), "{}\n{how_to_record}", failures.join("\n"));
    }
}

/// Recorded tables have the form of the file, so that a recording changes only what is different.
#[test]
fn equal_rows_do_not_change_the_file() {
    for (body, rows) in tables() {
        assert_eq!(with_rows(&catalog_text(), body, rows), catalog_text(), "{}", body.name);
        let mut other = rows.to_vec();
        other[1][1] += 6e-5;
        assert_ne!(with_rows(&catalog_text(), body, &other), catalog_text(), "{}", body.name);
    }
}
