//! *What to see now*: five views for a user who has just started.
//!
//! In: the time, a session's catalog and positions. Out: titles and views. Always: quality, effects and layers are those of the base view; a view is
//! omitted if the ephemeris does not cover its time or the catalog lacks its moment.

use super::body_positions::{BodyPositions, SessionPositions};
use super::civil_time::ShownTimeZone;
use super::event_search::{EventKind, EventSearch, SkyEvent};
use super::moment_view::view_of_moment;
use super::orbit_camera::OrbitCamera;
use super::view_state::{CameraPose, DEFAULT_FOV_DEG, ViewState, inertial_orbit_pose};
use crate::catalog::NaifId;
use crate::catalog::moments::Moment;
use crate::session::Session;
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use crate::view::language::dates::day_text;
use crate::view::language::{catalog_text, decimal, text};
use std::sync::Arc;

const SATURN: NaifId = NaifId(699);
/// Vertical field of view around the Moon.
pub(crate) const MOON_FOV_DEG: f64 = 0.7;
/// Distance from Saturn, in equatorial radii, at which its rings fit into a wide image.
const SATURN_DISTANCE_RADII: f64 = 6.0;
/// Length of the search for the next eclipse, seconds: long enough, because a year has four to seven eclipses.
const ECLIPSE_SEARCH_S: f64 = 400.0 * SECONDS_PER_DAY;

/// Name, in the catalog, of the moment that [`NowItem::Shadows`] shows.
const SHADOWS_MOMENT: &str = "Triple shadow on Jupiter";
/// Name, in the catalog, of the moment that [`NowItem::Shader`] shows.
const SHADER_MOMENT: &str = "Total eclipse over North America";

/// The five views, in the order of the row of thumbnails (`view::panels::what_to_see_now`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NowItem {
    /// The Moon as it is now, from the Earth's centre.
    Moon,
    /// The next eclipse of the Sun or the Moon.
    Eclipse,
    /// Saturn as it is now, with its rings.
    Saturn,
    /// A moment of the catalog: the shadows of three moons on Jupiter.
    Shadows,
    /// A moment of the catalog; choosing it also opens the shader that draws it.
    Shader,
}

/// One of the views of *What to see now*, with its texts.
#[derive(Clone, Debug)]
pub struct NowView {
    pub title: String,
    subject: Subject,
    pub view: ViewState,
    /// Whether the view shows the time at which it is opened.
    pub opens_at_current_time: bool,
    /// The event that the view shows, for the Events panel.
    pub event: Option<Arc<SkyEvent>>,
}

/// What a view shows. A day is kept as an instant, because the displayed time zone may change while the view is offered.
#[derive(Clone, Debug)]
enum Subject {
    /// A text without a date.
    Undated(String),
    /// The name of an event or moment, and its time.
    Dated(String, Instant),
    /// The shader that draws the moment at this time.
    ShaderAt(Instant),
}

impl NowView {
    /// A short text about what the view shows, with the day in the displayed time zone.
    pub fn about(&self, zone: ShownTimeZone) -> String {
        match &self.subject {
            Subject::Undated(about) => about.clone(),
            Subject::Dated(what, time) => text!("now-dated", what = what, day = day_text(*time, zone)),
            Subject::ShaderAt(time) => text!("now-shader-about", day = day_text(*time, zone)),
        }
    }
}

impl NowItem {
    pub const ALL: [Self; 5] = [Self::Moon, Self::Eclipse, Self::Saturn, Self::Shadows, Self::Shader];

    /// The title, which is also the button's label before the view is known.
    pub fn name(self) -> &'static str {
        match self {
            Self::Moon => text!("now-moon"),
            Self::Eclipse => text!("now-eclipse"),
            Self::Saturn => text!("now-saturn"),
            Self::Shadows => text!("now-shadows"),
            Self::Shader => text!("now-shader"),
        }
    }

    /// The view of this item; `None` if the ephemeris does not cover it or the catalog lacks its moment.
    pub fn view(self, session: &Session, now: Instant, base_view: &ViewState) -> Option<NowView> {
        let (catalog, positions) = (session.catalog(), SessionPositions(session));
        let title = self.name().to_owned();
        let at_fixed_time =
            |subject: Subject, view| Some(NowView { title: title.clone(), subject, view, opens_at_current_time: false, event: None });
        // A view of the time at which it is opened. Whether time is then paused is left open: the caller decides.
        let at_current_time = |about: String, view: ViewState| {
            let view = ViewState { tdb_s: now.tdb_seconds_past_j2000(), paused: None, ..view };
            Some(NowView { title: title.clone(), subject: Subject::Undated(about), view, opens_at_current_time: true, event: None })
        };
        // Found by name, because the user's catalog may have moments of the same kind.
        let moment_named = |name: &str| catalog.moments().iter().find(|m| m.name == name);
        let of_moment = |moment: &Moment| view_of_moment(moment, catalog, &positions, base_view);
        match self {
            Self::Moon => {
                let camera = CameraPose::Centre { body: NaifId::EARTH };
                let lit_fraction = illuminated_fraction(&positions, NaifId::MOON, now)?;
                let view = base_view.tracking_view(NaifId::MOON, camera, MOON_FOV_DEG);
                at_current_time(text!("now-moon-about", percent = decimal(100.0 * lit_fraction, 0)), view)
            }
            Self::Eclipse => {
                let is_backward = false;
                let search = EventSearch::new(vec![EventKind::Solar, EventKind::Lunar], now, ECLIPSE_SEARCH_S, is_backward);
                let event = search.find_first(catalog, session.ephemeris()).ok()??;
                let view = event.view(catalog, &positions, base_view);
                let subject = Subject::Dated(event.title(catalog), event.greatest());
                Some(NowView { title: title.clone(), subject, view, opens_at_current_time: false, event: Some(Arc::new(event)) })
            }
            Self::Saturn => {
                let sunward = positions.geometric_vector_km(SATURN, NaifId::SUN, now)?.try_normalize()?;
                let pole = positions.body_from_icrf(SATURN, now)?.row(2);
                let orbit = OrbitCamera::on_lit_side(sunward, SATURN_DISTANCE_RADII, pole);
                let view = base_view.tracking_view(SATURN, inertial_orbit_pose(SATURN, orbit), DEFAULT_FOV_DEG);
                at_current_time(text!("now-saturn-about").into(), view)
            }
            Self::Shadows => {
                let moment = moment_named(SHADOWS_MOMENT)?;
                at_fixed_time(Subject::Dated(catalog_text("moment", &moment.name).into_owned(), moment.time), of_moment(moment)?)
            }
            Self::Shader => {
                let moment = moment_named(SHADER_MOMENT)?;
                at_fixed_time(Subject::ShaderAt(moment.time), of_moment(moment)?)
            }
        }
    }
}

/// Illuminated fraction of a body's disc as seen from the Earth.
fn illuminated_fraction(positions: &dyn BodyPositions, body: NaifId, time: Instant) -> Option<f64> {
    let towards = |to| positions.geometric_vector_km(body, to, time)?.try_normalize();
    Some(0.5 * (1.0 + towards(NaifId::SUN)?.dot(towards(NaifId::EARTH)?)))
}
