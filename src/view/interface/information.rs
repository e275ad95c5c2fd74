//! What is known of the selected body now, and of the sky over a place.

use super::{Interface, named};
use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::apparent::{ApparentPlace, apparent_place};
use crate::ephemeris::horizon::{Day, Passage, Place, Sky};
use crate::scene::BodyInView;
use crate::session::Session;
use crate::time::Instant;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S};
use crate::view::settings::Settings;
use crate::view::studio::{Studio, Ticket, ask};
use egui::{Grid, ScrollArea};
use serde::{Deserialize, Serialize};

/// In what lengths are told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    #[default]
    Kilometres,
    AstronomicalUnits,
    Miles,
    BodyRadii,
}

impl Unit {
    const ALL: [Self; 4] = [Self::Kilometres, Self::AstronomicalUnits, Self::Miles, Self::BodyRadii];

    fn name(self) -> &'static str {
        match self {
            Self::Kilometres => "km",
            Self::AstronomicalUnits => "au",
            Self::Miles => "miles",
            Self::BodyRadii => "radii",
        }
    }

    fn tell(self, km: f64, radius_km: f64) -> String {
        let (value, digits) = match self {
            Self::Kilometres => (km, 0),
            Self::AstronomicalUnits => (km / KM_PER_AU, 6),
            // The international mile.
            Self::Miles => (km / 1.609_344, 0),
            Self::BodyRadii => (km / radius_km, 3),
        };
        format!("{} {}", grouped(value, digits), self.name())
    }
}

/// Thousands set apart.
fn grouped(value: f64, digits: usize) -> String {
    let text = format!("{:.digits$}", value.abs());
    let (whole, rest) = text.split_once('.').map_or((text.as_str(), String::new()), |(w, r)| (w, format!(".{r}")));
    let spaced: Vec<&str> = whole.as_bytes().rchunks(3).rev().filter_map(|c| std::str::from_utf8(c).ok()).collect();
    format!("{}{}{rest}", if value < 0.0 { "-" } else { "" }, spaced.join(" "))
}

/// The answers for one body, place and minute.
struct SkyReport {
    apparent: Option<ApparentPlace>,
    altitude_azimuth_deg: Result<[f64; 2], String>,
    day: Result<Day, String>,
    passage: Result<Option<Passage>, String>,
}

/// What a report is of: it is made anew when this changes.
#[derive(Clone, Copy, PartialEq)]
struct Question {
    body: NaifId,
    place: [f64; 2],
    minute: i64,
}

/// A place on the Earth by name, for those who look from there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Home {
    pub latitude_deg: f64,
    pub longitude_deg: f64,
}

impl Default for Home {
    fn default() -> Self {
        // The Royal Observatory in Greenwich.
        Self { latitude_deg: 51.4769, longitude_deg: 0.0 }
    }
}

#[derive(Default)]
pub struct InformationPanel {
    pub unit: Unit,
    pub home: Home,
    asked: Option<Question>,
    ticket: Option<Ticket<SkyReport>>,
    report: Option<(Question, SkyReport)>,
}

impl InformationPanel {
    pub fn with(settings: &Settings) -> Self {
        Self { unit: settings.unit, home: settings.home, ..Self::default() }
    }
}

pub fn panel(interface: &mut Interface, ui: &mut egui::Ui, studio: &dyn Studio) {
    ui.horizontal(|ui| {
        ui.label("Lengths in");
        for unit in Unit::ALL {
            ui.selectable_value(&mut interface.information.unit, unit, unit.name());
        }
    });
    let selected = interface.viewer.selected;
    let time = interface.viewer.sight.time();
    let Some(body) = interface.sky.drawing.as_ref().and_then(|d| d.scene.body(selected)).cloned() else { return };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.strong(&body.name);
        from_here(ui, &body, interface.information.unit, studio.session().catalog());
        ui.separator();
        over_a_place(interface, ui, studio, &body, time);
    });
}

fn line(ui: &mut egui::Ui, what: &str, value: impl Into<String>) {
    ui.label(what);
    ui.add(egui::Label::new(egui::RichText::new(value.into()).monospace()).wrap());
    ui.end_row();
}

fn degrees(value: f64) -> String {
    match value.abs() {
        v if v >= 1.0 => format!("{value:.3} deg"),
        v if v >= 1.0 / 60.0 => format!("{:.2} arcmin", value * 60.0),
        _ => format!("{:.2} arcsec", value * 3600.0),
    }
}

/// As the eye of the picture sees it.
fn from_here(ui: &mut egui::Ui, body: &BodyInView, unit: Unit, catalog: &Catalog) {
    let radius_km = body.placement.radii_km.x;
    Grid::new("from here").num_columns(2).striped(true).show(ui, |ui| {
        line(ui, "distance", unit.tell(body.distance_km, radius_km));
        line(ui, "light takes", seconds(body.distance_km / SPEED_OF_LIGHT_KM_S));
        line(ui, "apparent size", degrees(body.angular_diameter_deg));
        line(ui, "on the picture", format!("{:.1} px", body.diameter_px));
        line(ui, "magnitude", body.magnitude.map_or("none".into(), |m| format!("{m:+.2}")));
        if body.id != NaifId::SUN {
            line(ui, "phase angle", degrees(body.phase_angle_deg));
            let lit = (1.0 + body.phase_angle_deg.to_radians().cos()) / 2.0;
            line(ui, "illuminated", format!("{:.1} %", lit * 100.0));
        }
        let point = |p: crate::scene::SubPoint| format!("{:+.2} lat, {:+.2} east", p.latitude_deg, p.longitude_deg);
        line(ui, "below the eye", point(body.sub_viewer));
        if let Some(sun) = body.sub_solar {
            line(ui, "below the Sun", point(sun));
        }
        line(ui, "radius", unit.tell(radius_km, radius_km));
        if let Some(known) = catalog.body(body.id) {
            line(ui, "albedo", format!("{:.3} geometric", known.geometric_albedo));
            for estimate in known.estimated() {
                line(ui, "estimate", estimate);
            }
            if let Some(air) = &known.atmosphere {
                line(ui, "air", air.species.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", "));
            }
        }
    });
}

fn seconds(s: f64) -> String {
    match s {
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.1} min", s / 60.0),
        s => format!("{:.2} h", s / 3600.0),
    }
}

fn over_a_place(interface: &mut Interface, ui: &mut egui::Ui, studio: &dyn Studio, body: &BodyInView, time: Instant) {
    let panel = &mut interface.information;
    ui.strong("Seen from the Earth");
    ui.horizontal_wrapped(|ui| {
        ui.label("at");
        let drag = |value, range| egui::DragValue::new(value).range(range).speed(0.1).fixed_decimals(4).suffix(" deg");
        for (value, most, what) in [
            (&mut panel.home.latitude_deg, 90.0, "Latitude of the place, degrees north"),
            (&mut panel.home.longitude_deg, 180.0, "Longitude of the place, degrees east"),
        ] {
            named::number(ui, drag(value, -most..=most), what);
        }
    });
    let question = Question {
        body: body.id,
        place: [panel.home.latitude_deg, panel.home.longitude_deg],
        minute: (time.tdb_seconds_past_j2000() / 60.0).floor() as i64,
    };
    if let Some(report) = panel.ticket.as_ref().and_then(Ticket::take) {
        panel.report = panel.asked.map(|asked| (asked, report));
        panel.ticket = None;
    }
    if panel.asked != Some(question) && panel.ticket.is_none() {
        panel.asked = Some(question);
        panel.ticket = Some(ask(studio, move |session| report(session, question, time)));
    }
    let Some((_, report)) = panel.report.as_ref().filter(|(of, _)| of.body == body.id) else {
        ui.weak("computing");
        return;
    };
    Grid::new("from a place").num_columns(2).striped(true).show(ui, |ui| {
        if let Some(a) = &report.apparent {
            line(ui, "right ascension", hours(a.true_of_date.ra_deg));
            line(ui, "declination", sexagesimal(a.true_of_date.dec_deg, "d"));
            line(ui, "ephemeris", format!("{:?}, error below {:.2e} arcsec", a.source, a.error_arcsec));
        }
        match &report.altitude_azimuth_deg {
            Ok([altitude, azimuth]) => {
                line(ui, "altitude", format!("{altitude:+.2} deg, airless"));
                line(ui, "azimuth", format!("{azimuth:.2} deg from north by east"));
            }
            Err(why) => line(ui, "altitude", why.clone()),
        }
        if let Ok(day) = &report.day {
            let clock = |t: Option<Instant>, none: &str| t.map_or(none.to_owned(), |t| t.to_utc_iso());
            let never = if day.up_at_start { "always up" } else { "always down" };
            line(ui, "rises", clock(day.rise, never));
            line(ui, "highest", day.transit.map_or("-".into(), |(t, deg)| format!("{} at {deg:.1} deg", t.to_utc_iso())));
            line(ui, "sets", clock(day.set, never));
        }
    });
    eclipse(ui, report);
}

/// What the Moon does to the Sun over the place that day.
fn eclipse(ui: &mut egui::Ui, report: &SkyReport) {
    ui.add_space(6.0);
    ui.strong("Eclipse of the Sun that day");
    match &report.passage {
        Ok(None) => {
            ui.weak("none at this place");
        }
        Ok(Some(p)) => {
            Grid::new("eclipse").num_columns(2).striped(true).show(ui, |ui| {
                line(ui, "first contact", p.begins.to_utc_iso());
                if let Some((second, third)) = p.inner {
                    line(ui, "second contact", second.to_utc_iso());
                    line(ui, "third contact", third.to_utc_iso());
                }
                line(ui, "greatest", p.greatest.to_utc_iso());
                line(ui, "last contact", p.ends.to_utc_iso());
                line(ui, "magnitude", format!("{:.4}", p.magnitude));
                line(ui, "the Sun stands", format!("{:+.1} deg high", p.altitude_deg));
            });
        }
        Err(why) => {
            ui.weak(why);
        }
    }
}

fn report(session: &Session, of: Question, time: Instant) -> SkyReport {
    let place = Place { body: NaifId::EARTH, latitude_deg: of.place[0], longitude_deg: of.place[1], height_km: 0.0 };
    let sky = Sky { catalog: session.catalog(), ephemeris: session.ephemeris(), place };
    let words = |e: crate::ephemeris::EphemerisError| e.to_string();
    let midnight_s = (time.tdb_seconds_past_j2000() / SECONDS_PER_DAY - 0.5).floor() * SECONDS_PER_DAY + 0.5 * SECONDS_PER_DAY;
    let midnight = Instant::from_tdb_seconds_past_j2000(midnight_s);
    let on_it = || "you stand on it".to_owned();
    let elsewhere = of.body != NaifId::EARTH;
    SkyReport {
        apparent: apparent_place(session.ephemeris(), of.body, time).ok().filter(|_| elsewhere),
        altitude_azimuth_deg: if elsewhere {
            sky.look(of.body, time).map(|h| [h.altitude_deg, h.azimuth_deg]).map_err(words)
        } else {
            Err(on_it())
        },
        day: if elsewhere { sky.day(of.body, midnight, SECONDS_PER_DAY).map_err(words) } else { Err(on_it()) },
        passage: sky.passage(NaifId::SUN, NaifId::MOON, midnight, SECONDS_PER_DAY).map_err(words),
    }
}

fn hours(ra_deg: f64) -> String {
    sexagesimal(ra_deg / 15.0, "h")
}

/// `-12d 34m 56.7s`.
fn sexagesimal(value: f64, unit: &str) -> String {
    let tenths = (value.abs() * 36_000.0).round() as u64;
    let (whole, minutes, rest) = (tenths / 36_000, tenths / 600 % 60, tenths % 600);
    format!("{}{whole}{unit} {minutes:02}m {:04.1}s", if value < 0.0 { "-" } else { "" }, rest as f64 / 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_as_people_read_them() {
        assert_eq!(grouped(-1_234_567.8, 1), "-1 234 567.8");
        assert_eq!(grouped(12.0, 0), "12");
        assert_eq!(Unit::AstronomicalUnits.tell(KM_PER_AU, 1.0), "1.000000 au");
        assert_eq!(Unit::BodyRadii.tell(12.0, 4.0), "3.000 radii");
        assert_eq!(sexagesimal(-0.5, "d"), "-0d 30m 00.0s");
        assert_eq!(hours(359.999_999_9), "24h 00m 00.0s");
        assert_eq!(seconds(90.0 * 60.0), "90.0 min");
    }
}
