//! The Information panel: facts about the selected body at the displayed time, and its position in the sky of an observer on the Earth.
//!
//! In: the body as the last scene shows it, the observer's place, the time. Out: tables; queries that compute the position in the sky.

mod object_facts;
mod sizes_and_distances;

use self::object_facts::{ObjectInputs, ObjectReport, PlaceAndDay};
use self::sizes_and_distances::SizeComparison;
use super::Interface;
use super::fact;
use super::number_field::{self, NumberKind};
use super::theme::MIN_LIST_HEIGHT;
use crate::catalog::cities::{self, City};
use crate::catalog::{Catalog, NaifId, Photometry};
use crate::ephemeris::Source;
use crate::ephemeris::apparent::{ApparentPlace, apparent_place};
use crate::ephemeris::topocentric::{DiscPassage, ObserverSky, RiseSetTimes};
use crate::message::Message;
use crate::scene::{BodyReport, InventedData, SubPoint};
use crate::session::Session;
use crate::time::Instant;
use crate::units::{KM_PER_AU, SPEED_OF_LIGHT_KM_S};
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::place_text::latitude_longitude_text;
use crate::view::app::settings::{Home, LengthUnit, Settings};
use crate::view::app::view_state::{MAX_TYPED_LONGITUDE_DEG, wrapped_longitude_deg};
use crate::view::error_texts::error_text;
use crate::view::language::dates::second_text;
use crate::view::language::numbers::{grouped, localised};
use crate::view::language::{body_name, catalog_text, decimal, message_text, reason_text, signed, text};
use crate::view::worker::latest_answer::LatestAnswer;
use crate::view::worker::render_worker::RenderWorker;
use crate::wording::{echo_within, nearest};
use egui::{Grid, ScrollArea};

/// An international mile.
const KM_PER_MILE: f64 = 1.609_344;
/// A foot: 1/5280 of a mile.
const KM_PER_FOOT: f64 = 0.000_304_8;

impl LengthUnit {
    const ALL: [Self; 4] = [Self::Kilometres, Self::AstronomicalUnits, Self::Miles, Self::BodyRadii];

    fn name(self) -> &'static str {
        match self {
            Self::Kilometres => text!("unit-km"),
            Self::AstronomicalUnits => text!("unit-au"),
            Self::Miles => text!("unit-miles"),
            Self::BodyRadii => text!("unit-radii"),
        }
    }

    /// A length in this unit, with the unit's name. `radius_km`: the body's equatorial radius, the unit of [`Self::BodyRadii`].
    pub(super) fn format_length(self, km: f64, radius_km: f64) -> String {
        let (value, decimals) = match self {
            Self::Kilometres => (km, 0),
            Self::AstronomicalUnits => (km / KM_PER_AU, 6),
            Self::Miles => (km / KM_PER_MILE, 0),
            Self::BodyRadii => (km / radius_km, 3),
        };
        format!("{} {}", grouped(value, decimals), self.name())
    }

    /// A height above the ground of a body near the camera, with three significant digits below a thousand: in miles or feet if the unit is miles, otherwise in
    /// kilometres or metres, because astronomical units and radii are too large for heights.
    fn format_height(self, km: f64) -> String {
        let (large_km, large, small_km, small) = match self {
            Self::Miles => (KM_PER_MILE, text!("unit-miles"), KM_PER_FOOT, text!("unit-feet")),
            Self::Kilometres | Self::AstronomicalUnits | Self::BodyRadii => (1.0, text!("unit-km"), 1e-3, text!("unit-metres")),
        };
        // A height that would round to a whole larger unit is given in it.
        let (value, name) = if km < 0.9995 * large_km { (km / small_km, small) } else { (km / large_km, large) };
        let decimals = match value {
            _ if value < 9.995 => 2,
            _ if value < 99.95 => 1,
            _ => 0,
        };
        format!("{} {name}", grouped(value, decimals))
    }
}

/// Largest number of cities suggested for a typed name.
const MAX_CITIES: usize = 4;
/// Largest number of characters of an unknown name that the message quotes.
const MAX_NAME_CHARS: usize = 40;

/// One body in the sky of one place on the Earth: its position at one time, its rise, transit and set on the displayed day, and the day's solar eclipse.
struct SkyReport {
    /// The body's apparent place as seen from the Earth's centre. `None` for the Earth itself, and outside the ephemeris.
    apparent: Option<ApparentPlace>,
    /// Altitude and azimuth, degrees. `None` for the Earth itself, on which the observer stands.
    altitude_azimuth_deg: Option<Result<[f64; 2], String>>,
    /// Rise, transit and set on the day at the place; `None` for the Earth itself.
    rise_set: Option<Result<RiseSetTimes, String>>,
    /// The solar eclipse of the day at the place (the Moon's passage over the Sun's disc), if any.
    solar_eclipse: Result<Option<DiscPassage>, String>,
    /// A sentence that states the radii of the Sun and the Moon used for the eclipse.
    eclipse_radii: Message,
}

/// The inputs of a report, which is computed again when they change.
#[derive(Clone, Copy, PartialEq)]
struct ReportInputs {
    body: NaifId,
    at: PlaceAndDay,
}

/// State of the Information panel.
#[derive(Default)]
pub(crate) struct InformationPanel {
    /// The unit of lengths, which all panels use.
    pub unit: LengthUnit,
    /// The observer's place on the Earth, which all panels use.
    pub observer_place: Home,
    pub comparison: SizeComparison,
    /// Text in the city field.
    typed_city: String,
    /// The city that was chosen in the field or in the search, as long as its place is the observer's.
    chosen_city: Option<&'static City>,
    /// The last text that was entered although no city has this name, until the text in the field changes.
    unknown_city: Option<String>,
    report: LatestAnswer<ReportInputs, SkyReport>,
    /// About the chosen star, comet or minor planet; `None` if it is not in the catalog.
    object_report: LatestAnswer<ObjectInputs, Option<ObjectReport>>,
}

impl InformationPanel {
    /// The panel's first state, with the unit and the observer's place of the settings.
    pub(crate) fn from_settings(settings: &Settings) -> Self {
        Self { unit: settings.unit, observer_place: settings.home, ..Self::default() }
    }

    /// Makes a city the observer's place, and shows its name in the city field.
    pub(super) fn choose_city(&mut self, city: &'static City) {
        self.observer_place = place_of(city);
        self.typed_city = city.name.to_owned();
        (self.chosen_city, self.unknown_city) = (Some(city), None);
    }

    /// Drops the reports, whose errors are texts in the language in which they were asked for.
    pub(crate) fn forget_report(&mut self) {
        self.report.clear();
        self.object_report.clear();
    }
}

/// Shows the panel: the chosen star, comet or minor planet, if any, and the selected body.
pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker) {
    unit_row(ui, &mut interface.information.unit);
    let selected = interface.viewer.selected;
    let time = interface.viewer.view.time();
    let body = interface.shown().and_then(|rendered| rendered.scene.body(selected)).cloned();
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(MIN_LIST_HEIGHT).show(ui, |ui| {
        object_facts::show(interface, ui, worker);
        let Some(body) = body else { return };
        ui.strong(body_name(&body.name));
        facts_from_camera(ui, &body, interface.information.unit, worker.session().catalog());
        ui.separator();
        position_in_sky(interface, ui, worker, &body, time);
        ui.separator();
        sizes_and_distances::panel(interface, ui, worker);
    });
}

/// Shows the choice of the unit of lengths.
pub(super) fn unit_row(ui: &mut egui::Ui, chosen: &mut LengthUnit) {
    ui.horizontal(|ui| {
        ui.label(text!("units"));
        for unit in LengthUnit::ALL {
            ui.selectable_value(chosen, unit, unit.name()).on_hover_text(text!("units-hint"));
        }
    });
}

/// Formats an angle, given in degrees, in degrees, arcminutes or arcseconds, by its size.
pub(super) fn scaled_angle_text(angle_deg: f64) -> String {
    match angle_deg.abs() {
        size if size >= 1.0 => format!("{}°", decimal(angle_deg, 3)),
        size if size >= 1.0 / 60.0 => format!("{}′", decimal(angle_deg * 60.0, 2)),
        _ => format!("{}″", decimal(angle_deg * 3600.0, 2)),
    }
}

/// Shows facts about a body as seen from the camera, and its constant properties.
fn facts_from_camera(ui: &mut egui::Ui, body: &BodyReport, unit: LengthUnit, catalog: &Catalog) {
    let radius_km = body.placement.radii_km.x;
    Grid::new("from here").num_columns(2).striped(true).show(ui, |ui| {
        if let Some([distance, light_time]) = distance_and_light_time(body.distance_km, radius_km, unit) {
            fact::row(ui, text!("fact-distance"), distance);
            fact::row(ui, text!("fact-light-time"), light_time);
        }
        if let Some(height_km) = body.placement.height_near_ground_km() {
            fact::row(ui, text!("fact-height"), unit.format_height(height_km));
        }
        let place_text = |p: SubPoint| latitude_longitude(p.lat_centric_deg, p.lon_east_deg);
        if body.has_direction() {
            fact::row(ui, text!("fact-angular-diameter"), scaled_angle_text(body.angular_diameter_deg));
            fact::row(ui, text!("fact-size-on-screen"), format!("{} px", decimal(body.diameter_px, 1)));
            fact::row(ui, text!("fact-magnitude"), body.magnitude.map_or(text!("fact-none").into(), |m| signed(m, 2)));
            if body.id != NaifId::SUN {
                fact::row(ui, text!("fact-phase-angle"), scaled_angle_text(body.phase_angle_deg));
                let illuminated_fraction = (1.0 + body.phase_angle_deg.to_radians().cos()) / 2.0;
                fact::row(ui, text!("fact-illuminated"), format!("{} %", decimal(illuminated_fraction * 100.0, 1)));
            }
            fact::row(ui, text!("fact-sub-observer"), place_text(body.sub_observer));
        }
        if let Some(altitude_deg) = body.sun_altitude_deg {
            fact::row(ui, text!("fact-sun-altitude"), text!("fact-altitude-value", altitude = signed(altitude_deg, 2)));
        }
        if let Some(sun) = body.sub_solar {
            fact::row(ui, text!("fact-sub-solar"), place_text(sun));
        }
        fact::row(ui, text!("fact-latitudes"), text!("fact-latitudes-centric"));
        fact::row(ui, text!("fact-equatorial-radius"), unit.format_length(radius_km, radius_km));
        if let Some(known) = catalog.body(body.id) {
            // The catalog has 0 for a body that shines by its own light.
            if !matches!(known.photometry, Photometry::Emissive { .. }) {
                fact::row(ui, text!("fact-geometric-albedo"), decimal(known.geometric_albedo, 3));
            }
            for estimate in known.estimate_notes() {
                fact::row(ui, text!("fact-estimate"), message_text(&estimate));
            }
            for InventedData { source, how_made } in &body.invented {
                fact::row(ui, text!("fact-invented-map"), format!("{source}: {}", reason_text(how_made)));
            }
            if let Some(air) = &known.atmosphere {
                fact::row(
                    ui,
                    text!("fact-atmosphere"),
                    air.species.iter().map(|s| catalog_text("species", &s.name)).collect::<Vec<_>>().join(", "),
                );
            }
        }
    });
}

/// Texts for the distance of a body and for its light time; `None` for a body that the ephemeris cannot place.
fn distance_and_light_time(distance_km: f64, radius_km: f64, unit: LengthUnit) -> Option<[String; 2]> {
    distance_km.is_finite().then(|| [unit.format_length(distance_km, radius_km), duration_text(distance_km / SPEED_OF_LIGHT_KM_S)])
}

/// Formats a duration in milliseconds, seconds, minutes or hours, by its length.
pub(super) fn duration_text(duration_s: f64) -> String {
    match duration_s {
        s if s < 1.0 => format!("{} ms", decimal(s * 1e3, 1)),
        s if s < 120.0 => format!("{} s", decimal(s, 1)),
        s if s < 7200.0 => format!("{} min", decimal(s / 60.0, 1)),
        s => format!("{} h", decimal(s / 3600.0, 2)),
    }
}

/// Shows the body's position in the sky of the observer's place and the day's solar eclipse, which the query worker computes.
fn position_in_sky(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, body: &BodyReport, time: Instant) {
    let zone = interface.settings.time_zone;
    let panel = &mut interface.information;
    ui.strong(text!("place-heading"));
    place_fields(ui, panel);
    let inputs = ReportInputs { body: body.id, at: PlaceAndDay::of(panel.observer_place, time, zone) };
    let answer = panel.report.update(worker, inputs, move |session| report(session, inputs, time));
    let Some((_, report)) = answer.filter(|(inputs, _)| inputs.body == body.id) else {
        ui.weak(text!("computing"));
        return;
    };
    Grid::new("from a place").num_columns(2).striped(true).show(ui, |ui| {
        if let Some(apparent) = &report.apparent {
            fact::row(ui, text!("fact-right-ascension"), localised(apparent.true_of_date.ra_text()));
            fact::row(ui, text!("fact-declination"), localised(apparent.true_of_date.dec_text()));
            fact::row(ui, text!("fact-source"), source_text(apparent.source, apparent.error_arcsec));
        }
        match &report.altitude_azimuth_deg {
            Some(Ok([altitude_deg, azimuth_deg])) => {
                fact::row(ui, text!("fact-altitude"), text!("fact-altitude-value", altitude = signed(altitude_deg, 2)));
                fact::row(ui, text!("fact-azimuth"), format!("{}°", decimal(azimuth_deg, 2)));
            }
            Some(Err(why)) => fact::row(ui, text!("fact-altitude"), why.clone()),
            None => {}
        }
        match &report.rise_set {
            Some(Ok(times)) => rise_and_set(ui, times, zone),
            // If the altitude is known, only a part of the day is outside the ephemeris; otherwise the reason is shown above.
            Some(Err(why)) if matches!(report.altitude_azimuth_deg, Some(Ok(_))) => fact::row(ui, text!("fact-rise"), why.clone()),
            Some(Err(_)) | None => {}
        }
    });
    solar_eclipse(ui, report, zone);
}

/// Shows the rows of the times at which the body rises, culminates and sets on the displayed day.
fn rise_and_set(ui: &mut egui::Ui, times: &RiseSetTimes, zone: ShownTimeZone) {
    // A day may have a rise and no set, or the reverse: the Moon rises some 50 minutes later each day. "-" stands for the one that is missing.
    let absent: &str = match (times.rise.or(times.set), times.is_up_at_start) {
        (Some(_), _) => "-",
        (None, true) => text!("fact-up-all-day"),
        (None, false) => text!("fact-down-all-day"),
    };
    // The stars, and so the planets, may rise, culminate or set twice in a day.
    let with_second = |first: String, second: Option<String>| second.map_or(first.clone(), |second| format!("{first}; {second}"));
    let time_text = |time: Instant| second_text(time, zone);
    let time_or_absent = |time: Option<Instant>| time.map_or(absent.to_owned(), time_text);
    fact::row(ui, text!("fact-rise"), with_second(time_or_absent(times.rise), times.second_rise.map(time_text)));
    let transit_text =
        |(time, altitude_deg): (Instant, f64)| text!("fact-transit-value", time = time_text(time), deg = decimal(altitude_deg, 1));
    let transit = times.transit.map_or("-".into(), transit_text);
    fact::row(ui, text!("fact-transit"), with_second(transit, times.second_transit.map(transit_text)));
    fact::row(ui, text!("fact-set"), with_second(time_or_absent(times.set), times.second_set.map(time_text)));
}

fn place_of(city: &City) -> Home {
    Home { latitude_deg: city.latitude_deg, longitude_deg: city.longitude_deg }
}

/// Shows the fields for the observer's place: a city, or latitude and longitude. Escape takes back what was typed of a city's name; so does leaving the field
/// if no city has this name.
pub(super) fn place_fields(ui: &mut egui::Ui, panel: &mut InformationPanel) {
    let place_before = panel.observer_place;
    ui.horizontal_wrapped(|ui| {
        let field = egui::TextEdit::singleline(&mut panel.typed_city).hint_text(text!("place-city")).desired_width(110.0);
        let response = ui.add(field).on_hover_text(text!("place-city-hint")).accessible_name(text!("place-city"));
        let enter_pressed = response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
        if response.changed() {
            panel.unknown_city = None;
        }
        let mut found = cities::with_prefix(&panel.typed_city, MAX_CITIES);
        if response.lost_focus() {
            let (typed, is_cancelled) = (panel.typed_city.trim().to_owned(), number_field::is_cancelled(ui));
            if found.is_empty() && !typed.is_empty() && !is_cancelled {
                panel.unknown_city = Some(typed);
            } else if is_cancelled {
                panel.unknown_city = None;
            }
            if enter_pressed && panel.unknown_city.is_some() {
                // The name can be corrected at once.
                response.request_focus();
            } else if is_cancelled || found.is_empty() {
                panel.typed_city = panel.chosen_city.map_or_else(String::new, |city| city.name.to_owned());
                found = cities::with_prefix(&panel.typed_city, MAX_CITIES);
            }
        }
        if panel.unknown_city.is_some() {
            // A press on a similar name takes the focus from the field. Until the release the name stays where it is.
            found.clear();
        }
        let is_chosen = |city: &City| panel.observer_place == place_of(city);
        let mut chosen = found.first().copied().filter(|_| enter_pressed);
        for city in found {
            let hover = text!("place-city-choose", city = city.name, country = catalog_text("country", city.country));
            if ui.selectable_label(is_chosen(city), city.name).on_hover_text(hover).clicked() {
                chosen = Some(city);
            }
        }
        if let Some(unknown) = &panel.unknown_city {
            chosen = similar_cities(ui, unknown);
        }
        if let Some(city) = chosen {
            panel.choose_city(city);
        }
    });
    let observer_place = &mut panel.observer_place;
    ui.horizontal_wrapped(|ui| {
        for (value_deg, (kind, limit_deg), label, accessible_name) in [
            (&mut observer_place.latitude_deg, (NumberKind::Latitude, 90.0), text!("place-latitude"), text!("place-latitude-hint")),
            (
                &mut observer_place.longitude_deg,
                (NumberKind::Longitude, MAX_TYPED_LONGITUDE_DEG),
                text!("place-longitude"),
                text!("place-longitude-hint"),
            ),
        ] {
            ui.label(label);
            let range = -limit_deg..=limit_deg;
            number_field::show(ui, value_deg, kind, range, accessible_name, |field| field.speed(0.1).fixed_decimals(4));
        }
    });
    observer_place.longitude_deg = wrapped_longitude_deg(observer_place.longitude_deg);
    // The field does not name a city whose place is no longer the observer's.
    let is_outdated = panel.chosen_city.take_if(|city| place_of(city) != panel.observer_place).is_some();
    let is_other_place = panel.observer_place != place_before && panel.chosen_city.is_none();
    if is_outdated || is_other_place {
        panel.typed_city.clear();
        panel.unknown_city = None;
    }
}

/// Says that no city has this name, and offers cities with similar names; returns the one that is clicked.
fn similar_cities(ui: &mut egui::Ui, unknown: &str) -> Option<&'static City> {
    let failure = text!("search-nothing", typed = echo_within(unknown, MAX_NAME_CHARS));
    let failure_label = ui.colored_label(ui.visuals().warn_fg_color, failure);
    // Screen readers announce the failure although the focus stays in the field.
    ui.ctx().accesskit_node_builder(failure_label.id, |node| node.set_live(egui::accesskit::Live::Polite));
    let mut chosen = None;
    for name in nearest(unknown, cities::all().iter().map(|city| city.name)) {
        let is_clicked = ui.selectable_label(false, text!("search-did-you-mean", name = name)).clicked();
        chosen = chosen.or(cities::all().iter().find(|city| is_clicked && city.name == name));
    }
    chosen
}

/// Shows the solar eclipse of the report's day at its place, if any.
fn solar_eclipse(ui: &mut egui::Ui, report: &SkyReport, zone: ShownTimeZone) {
    ui.add_space(6.0);
    ui.strong(text!("eclipse-today"));
    match &report.solar_eclipse {
        Ok(None) => {
            ui.weak(text!("eclipse-none"));
        }
        Ok(Some(eclipse)) => {
            Grid::new("eclipse").num_columns(2).striped(true).show(ui, |ui| {
                if let Some(first) = eclipse.begins {
                    fact::row(ui, text!("eclipse-first-contact"), second_text(first, zone));
                }
                if let Some((second, third)) = eclipse.inner {
                    fact::row(ui, text!("eclipse-second-contact"), second_text(second, zone));
                    fact::row(ui, text!("eclipse-third-contact"), second_text(third, zone));
                }
                fact::row(ui, text!("eclipse-greatest"), second_text(eclipse.greatest, zone));
                if let Some(last) = eclipse.ends {
                    fact::row(ui, text!("eclipse-last-contact"), second_text(last, zone));
                }
                fact::row(ui, text!("event-magnitude"), decimal(eclipse.magnitude, 4));
                fact::row(ui, text!("eclipse-sun-altitude"), format!("{}°", signed(eclipse.altitude_deg, 1)));
                fact::row(ui, text!("eclipse-radii"), message_text(&report.eclipse_radii));
            });
        }
        Err(why) => {
            ui.weak(why);
        }
    }
}

/// Computes a report; runs on the query worker.
fn report(session: &Session, inputs: ReportInputs, time: Instant) -> SkyReport {
    let sky = ObserverSky { catalog: session.catalog(), ephemeris: session.ephemeris(), place: inputs.at.observer() };
    let error_line = |e: crate::ephemeris::EphemerisError| error_text(&e);
    let (start, length_s) = inputs.at.start_and_length_s();
    // The Earth itself is not in the sky of a place on it.
    let observed = (inputs.body != NaifId::EARTH).then_some(inputs.body);
    SkyReport {
        apparent: observed.and_then(|body| apparent_place(session.ephemeris(), body, time).ok()),
        altitude_azimuth_deg: observed.map(|body| sky.topocentric(body, time).map(|h| [h.altitude_deg, h.azimuth_deg]).map_err(error_line)),
        rise_set: observed.map(|body| sky.rise_set_times(body, start, length_s).map_err(error_line)),
        solar_eclipse: sky.passage(NaifId::SUN, NaifId::MOON, start, length_s).map_err(error_line),
        eclipse_radii: session.catalog().eclipse_radii_text(),
    }
}

/// A place, such as `12.34° N, 56.78° E`.
fn latitude_longitude(latitude_deg: f64, longitude_deg: f64) -> String {
    latitude_longitude_text(latitude_deg, longitude_deg, 2)
}

/// The source of a position and the bound of its error, such as `kernel (±0.018″)`. The bound is rounded up.
fn source_text(source: Source, error_arcsec: f64) -> String {
    let name = match source {
        Source::Kernel => text!("source-kernel"),
        Source::Series => text!("source-series"),
        Source::Mean => text!("source-mean"),
    };
    let (bound_arcsec, decimals) = if error_arcsec < 1.0 { ((1e3 * error_arcsec).ceil() / 1e3, 3) } else { (error_arcsec.ceil(), 0) };
    if error_arcsec.is_finite() { format!("{name} (±{}″)", decimal(bound_arcsec, decimals)) } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_places_errors_and_durations_are_formatted_with_their_units() {
        assert_eq!(grouped(-1_234_567.8, 1), "-1 234 567.8");
        assert_eq!(grouped(12.0, 0), "12");
        assert_eq!(LengthUnit::AstronomicalUnits.format_length(KM_PER_AU, 1.0), "1.000000 au");
        assert_eq!(LengthUnit::BodyRadii.format_length(12.0, 4.0), "3.000 radii");
        assert_eq!(latitude_longitude(-33.3, 0.1), "33.30° S, 0.10° E");
        assert_eq!(source_text(Source::Kernel, 0.0172), "kernel (±0.018″)");
        assert_eq!(source_text(Source::Series, 0.0003), "series (±0.001″)");
        assert_eq!(duration_text(90.0 * 60.0), "90.0 min");
        let at = |distance_km: f64| distance_and_light_time(distance_km, 1.0, LengthUnit::Kilometres);
        assert_eq!(at(SPEED_OF_LIGHT_KM_S), Some(["299 792 km", "1.0 s"].map(str::to_owned)));
        // The camera at the centre, and a body without a place, for which the panel once showed NaN.
        assert_eq!(at(0.0), Some(["0 km", "0.0 ms"].map(str::to_owned)));
        assert_eq!(at(f64::NAN), None);
    }
}
