//! Facts about the chosen star, comet or minor planet, in the Information panel: catalog values, and its place in the sky of the observer's place.
//!
//! In: the object, the observer's place, the time. Out: a table; a query that computes the place in the sky. Always: places and magnitudes of small bodies are
//! those of `orrery ephemeris`; those of stars are without aberration and parallax.

use super::{LengthUnit, duration_text, rise_and_set, scaled_angle_text};
use crate::catalog::NaifId;
use crate::catalog::constellations::{Constellation, Constellations};
use crate::catalog::small_bodies::{NamedTarget, SmallBody};
use crate::ephemeris::star_place::star_from_viewer;
use crate::ephemeris::target::Target;
use crate::ephemeris::topocentric::{Observer, ObserverSky, RiseSetTimes};
use crate::scene::labels::SkyObject;
use crate::scene::{Observed, SkyOfEarth};
use crate::session::Session;
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::place_text::latitude_longitude_text;
use crate::view::app::settings::Home;
use crate::view::error_texts::error_text;
use crate::view::language::numbers::localised;
use crate::view::language::{decimal, signed, text};
use crate::view::panels::{Interface, fact, star};
use crate::view::worker::render_worker::RenderWorker;
use egui::{Grid, Ui};
use glam::DVec3;

/// The place of the observer and the displayed time, as far as a report depends on them.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct PlaceAndDay {
    /// Geodetic latitude and east longitude of the place, degrees.
    pub(super) place_deg: [f64; 2],
    /// The time in whole minutes since J2000, TDB.
    tdb_minutes: i64,
    /// Start and end of the day of that time, in the displayed time zone.
    pub(super) day: (Instant, Instant),
}

impl PlaceAndDay {
    pub(super) fn of(place: Home, time: Instant, zone: ShownTimeZone) -> Self {
        let tdb_s = time.tdb_seconds_past_j2000();
        // The day for years outside the calendar. J2000 is at 12h TDB, so days of TDB start half a day before and after it.
        let day_of_tdb = || {
            let start_s = ((tdb_s / SECONDS_PER_DAY - 0.5).floor() + 0.5) * SECONDS_PER_DAY;
            let [start, end] = [start_s, start_s + SECONDS_PER_DAY].map(Instant::from_tdb_seconds_past_j2000);
            (start, end)
        };
        Self {
            place_deg: [place.latitude_deg, place.longitude_deg],
            tdb_minutes: (tdb_s / 60.0).floor() as i64,
            day: zone.day(time).unwrap_or_else(day_of_tdb),
        }
    }

    /// The place, at the height 0.
    pub(super) fn observer(&self) -> Observer {
        Observer { body: NaifId::EARTH, lat_graphic_deg: self.place_deg[0], lon_east_deg: self.place_deg[1], height_km: 0.0 }
    }

    /// Start and length of the day.
    pub(super) fn start_and_length_s(&self) -> (Instant, f64) {
        let (start, end) = self.day;
        (start, end.tdb_seconds_past_j2000() - start.tdb_seconds_past_j2000())
    }
}

/// The inputs of a report, which is computed again when they change.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct ObjectInputs {
    object: SkyObject,
    at: PlaceAndDay,
}

/// The object in the sky of the place.
pub(crate) struct ObjectReport {
    constellation: Option<&'static Constellation>,
    /// Of a comet or minor planet; `None` for a star.
    observed: Option<Result<Observed, String>>,
    /// Altitude and azimuth, degrees.
    altitude_azimuth_deg: Result<[f64; 2], String>,
    rise_set: Result<RiseSetTimes, String>,
}

/// Direction of a star, ICRF, as seen from the solar system's barycentre; `None` if the star is not in the catalog.
fn star_direction(session: &Session, index: usize, time: Instant) -> Option<DVec3> {
    let stars = session.catalog().stars();
    let years_since_epoch = stars.years_since_epoch(time.jd_tt());
    star_from_viewer(stars.stars().get(index)?, years_since_epoch, DVec3::ZERO).try_normalize()
}

/// Computes a report; `None` if the object is not in the catalog. Runs on the query worker.
fn report(session: &Session, ObjectInputs { object, at }: ObjectInputs, time: Instant) -> Option<ObjectReport> {
    let (catalog, ephemeris) = (session.catalog(), session.ephemeris());
    let sky = ObserverSky { catalog, ephemeris, place: at.observer() };
    let (start, length_s) = at.start_and_length_s();
    let in_sky = |target: Target<'_>| {
        let horizontal = sky.topocentric(target, time).map(|h| [h.altitude_deg, h.azimuth_deg]).map_err(|e| error_text(&e));
        (horizontal, sky.rise_set_times(target, start, length_s).map_err(|e| error_text(&e)))
    };
    let all = catalog.small_bodies();
    let Some(body) = object.small_body(&all) else {
        let SkyObject::Star(index) = object else { return None };
        let direction = star_direction(session, index, time)?;
        let (altitude_azimuth_deg, rise_set) = in_sky(Target::Direction(direction));
        let constellation = Constellations::embedded().containing(direction);
        return Some(ObjectReport { constellation, observed: None, altitude_azimuth_deg, rise_set });
    };
    let named = NamedTarget::SmallBody(Box::new(body.clone()));
    let observed = SkyOfEarth::new(catalog, ephemeris, Some(at.observer())).observe(&named, time).map_err(|e| error_text(&e));
    let (altitude_azimuth_deg, rise_set) = in_sky(Target::SmallBody(body));
    let constellation = observed.as_ref().ok().and_then(|observed| observed.constellation);
    Some(ObjectReport { constellation, observed: Some(observed), altitude_azimuth_deg, rise_set })
}

/// Shows the facts about the chosen object, if there is one.
pub(super) fn show(interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker) {
    let Some(object) = interface.viewport.sky_object else { return };
    let (catalog, time, zone) = (worker.session().catalog(), interface.viewer.view.time(), interface.settings.time_zone);
    let unit = interface.information.unit;
    let inputs = ObjectInputs { object, at: PlaceAndDay::of(interface.information.observer_place, time, zone) };
    let answer = interface.information.object_report.update(worker, inputs, move |session| report(session, inputs, time));
    let report = answer.filter(|(inputs, _)| inputs.object == object).and_then(|(_, report)| report.as_ref());
    let all = catalog.small_bodies();
    match (object, object.small_body(&all)) {
        (SkyObject::Star(index), _) => {
            let stars = catalog.stars();
            let Some(star) = stars.stars().get(index) else { return };
            let years_since_epoch = stars.years_since_epoch(time.jd_tt());
            star::facts(ui, star, years_since_epoch, |ui| sky_rows(ui, report, inputs.at, zone));
        }
        (_, Some(body)) => {
            ui.strong(body.full_name());
            Grid::new("small body").num_columns(2).striped(true).show(ui, |ui| {
                small_body_rows(ui, body, report, unit);
                sky_rows(ui, report, inputs.at, zone);
            });
        }
        (_, None) => return,
    }
    ui.separator();
}

/// The rows about a comet or minor planet as seen from the observer's place.
fn small_body_rows(ui: &mut Ui, body: &SmallBody, report: Option<&ObjectReport>, unit: LengthUnit) {
    fact::row(ui, text!("fact-kind"), if body.is_comet() { text!("search-comet") } else { text!("search-minor-planet") });
    let observed = match report.and_then(|report| report.observed.as_ref()) {
        Some(Ok(observed)) => observed,
        Some(Err(why)) => return fact::row(ui, text!("fact-distance"), why.clone()),
        None => return,
    };
    // The radius of the body, which would be the unit, is not known.
    let unit = if unit == LengthUnit::BodyRadii { LengthUnit::AstronomicalUnits } else { unit };
    let no_radius_km = 1.0;
    fact::row(ui, text!("fact-distance"), unit.format_length(observed.place.distance_km, no_radius_km));
    fact::row(ui, text!("fact-light-time"), duration_text(observed.place.light_time_s));
    fact::row(ui, text!("fact-sun-distance"), unit.format_length(observed.sun_distance_km, no_radius_km));
    fact::row(ui, text!("fact-magnitude"), observed.magnitude.map_or(text!("fact-none").into(), |m| signed(m, 1)));
    if let Some(phase_angle_deg) = observed.phase_angle_deg {
        fact::row(ui, text!("fact-phase-angle"), scaled_angle_text(phase_angle_deg));
    }
    if let Some(elongation) = observed.elongation {
        let angle = scaled_angle_text(elongation.angle_deg);
        let value =
            if elongation.is_east { text!("fact-elongation-east", angle = angle) } else { text!("fact-elongation-west", angle = angle) };
        fact::row(ui, text!("fact-elongation"), value);
    }
    fact::row(ui, text!("fact-right-ascension"), localised(observed.place.true_of_date.ra_text()));
    fact::row(ui, text!("fact-declination"), localised(observed.place.true_of_date.dec_text()));
    fact::row(ui, text!("fact-source"), text!("fact-osculating"));
}

/// The rows about an object in the sky of the observer's place.
fn sky_rows(ui: &mut Ui, report: Option<&ObjectReport>, at: PlaceAndDay, zone: ShownTimeZone) {
    let Some(report) = report else {
        ui.weak(text!("computing"));
        ui.end_row();
        return;
    };
    if let Some(constellation) = report.constellation {
        // One constellation in two parts, with a name each.
        let name = if constellation.abbreviation == "Ser" { "Serpens" } else { constellation.name.as_str() };
        fact::row(ui, text!("fact-constellation"), name);
    }
    let [latitude_deg, longitude_deg] = at.place_deg;
    fact::row(ui, text!("fact-from-place"), latitude_longitude_text(latitude_deg, longitude_deg, 2));
    match &report.altitude_azimuth_deg {
        Ok([altitude_deg, azimuth_deg]) => {
            fact::row(ui, text!("fact-altitude"), text!("fact-altitude-value", altitude = signed(altitude_deg, 2)));
            fact::row(ui, text!("fact-azimuth"), format!("{}°", decimal(azimuth_deg, 2)));
        }
        Err(why) => fact::row(ui, text!("fact-altitude"), why.clone()),
    }
    match &report.rise_set {
        Ok(times) => rise_and_set(ui, times, zone),
        Err(why) => fact::row(ui, text!("fact-rise"), why.clone()),
    }
}
