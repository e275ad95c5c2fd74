//! Well-known moments, each with a viewpoint: eclipses, transits, shadows of three moons on Jupiter at once, ring-plane crossings.
//!
//! In: the `[[moment]]` tables of the catalog files. Out: [`Moment`]s with known bodies and valid times, or additions to the list of problems that all catalog
//! files share. A field that the moment's kind of viewpoint ([`Vantage`]) does not use is checked and then ignored. A moment replaces an earlier moment of the
//! same name. Nothing is computed here; tests compare the moments with the ephemeris.

use super::fields::{ALLOWED_NAME, is_name};
use super::table::{Problems, TableReader, WithLine};
use super::{Body, NaifId};
use crate::time::Instant;
use std::collections::BTreeMap;

/// The viewpoint of a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Vantage {
    /// From a body's centre, towards the target.
    Centre {
        /// The body at whose centre the camera is.
        body: NaifId,
        /// Vertical field of view.
        fov_deg: f64,
    },
    /// Above the side of the target that faces a body, or above the opposite side; towards the target, with the default field of view.
    Side {
        /// The body that the near side faces; the far side is opposite.
        reference_body: NaifId,
        /// False: above the side that faces this body; true: above the opposite side.
        is_far_side: bool,
        /// Distance from the target's centre, in equatorial radii of the target.
        distance_radii: f64,
    },
    /// Above a place on a body, towards the target; straight down if the body is the target.
    Place {
        /// The body that the place is on.
        body: NaifId,
        /// Planetographic latitude.
        latitude_deg: f64,
        /// Planetocentric east longitude, -360 to 360.
        longitude_deg: f64,
        /// Height above the ellipsoid.
        height_km: f64,
        /// Vertical field of view.
        fov_deg: f64,
    },
}

/// A time and a view of a remarkable event.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// The title in the window's list.
    pub name: String,
    /// The group in the list, one of [`KINDS`].
    pub kind: String,
    /// A description in one sentence.
    pub about: String,
    /// The instant.
    pub time: Instant,
    /// The body in the middle of the view.
    pub target: NaifId,
    /// The viewpoint.
    pub vantage: Vantage,
    /// The reference (publication) for the instant.
    pub source: String,
}

/// Kinds of moments, in the order of the window's list.
pub const KINDS: [&str; 7] = ["solar eclipse", "lunar eclipse", "transit", "shadows", "rings", "conjunction", "photograph"];

/// One `[[moment]]` table whose body names have not been looked up yet.
pub(super) struct UnresolvedMoment {
    name: WithLine<String>,
    kind: String,
    about: String,
    time: Instant,
    target: WithLine<String>,
    vantage: UnresolvedVantage,
    source: String,
}

/// A [`Vantage`] whose body is given by name.
enum UnresolvedVantage {
    Centre { body: WithLine<String>, fov_deg: f64 },
    Side { reference_body: WithLine<String>, is_far_side: bool, distance_radii: f64 },
    Place { body: WithLine<String>, latitude_deg: f64, longitude_deg: f64, height_km: f64, fov_deg: f64 },
}

/// Reads one `[[moment]]` table; `None` if a required field or the viewpoint is missing or invalid, which is then a reported problem.
pub(super) fn unresolved_moment(mut table: TableReader) -> Option<UnresolvedMoment> {
    let text =
        |table: &mut TableReader, field: &'static str, allowed: &str| table.required(field, allowed, |v: &String| !v.trim().is_empty());
    let name = table.required("name", ALLOWED_NAME, is_name);
    if let Some(name) = &name {
        table.set_message_prefix(&name.value);
    }
    let kind = table.required("kind", &format!("one of {}", KINDS.join(", ")), |k: &String| KINDS.contains(&k.as_str()));
    let about = text(&mut table, "about", "a sentence");
    let time = table.required("time", "ISO 8601 UTC, as 2024-04-08T18:17:16Z", |t: &String| Instant::parse(t).is_ok());
    let target = text(&mut table, "target", "the name of a body");
    let source = text(&mut table, "source", "a string");
    // Determined before the fields are read, which removes them from the table. A field with an invalid value counts as given, so that it is not reported as
    // missing, too.
    let bodies_given = ["from", "side", "away_from", "over"].map(|field| table.has(field));
    let [has_fov, has_radii] = ["fov_deg", "radii"].map(|field| table.has(field));
    let has_place = ["latitude_deg", "longitude_deg", "height_km"].iter().all(|field| table.has(field));
    let body_name = "the name of a body";
    let within = |min: f64, max: f64| move |v: &f64| (min..=max).contains(v);
    let fov = table.optional("fov_deg", "degrees from 0.0001 to 120", within(1e-4, 120.0)).map(|field| field.value);
    // At 1 the camera would be on the surface.
    let distance_radii = table.optional("radii", "equatorial radii above 1", within(1.000_001, 1e9)).map(|field| field.value);
    let from_body = table.optional("from", body_name, |_: &String| true);
    let side_body = table.optional("side", body_name, |_: &String| true);
    let away_from_body = table.optional("away_from", body_name, |_: &String| true);
    let over_body = table.optional("over", body_name, |_: &String| true);
    let latitude_deg = table.optional("latitude_deg", "degrees from -90 to 90", within(-90.0, 90.0)).map(|field| field.value);
    let longitude_deg = table.optional("longitude_deg", "degrees east from -360 to 360", within(-360.0, 360.0)).map(|field| field.value);
    let height_km = table.optional("height_km", "kilometres above 0", |h: &f64| *h > 0.0 && h.is_finite()).map(|field| field.value);
    let side = |body: Option<WithLine<String>>, is_far_side: bool| {
        let given = body.zip(distance_radii);
        given.map(|(reference_body, distance_radii)| UnresolvedVantage::Side { reference_body, is_far_side, distance_radii })
    };
    // Exactly one of `from`, `side`, `away_from` and `over` must be given.
    let (is_complete, vantage) = match bodies_given {
        [true, false, false, false] => (has_fov, from_body.zip(fov).map(|(body, fov_deg)| UnresolvedVantage::Centre { body, fov_deg })),
        [false, true, false, false] => (has_radii, side(side_body, false)),
        [false, false, true, false] => (has_radii, side(away_from_body, true)),
        [false, false, false, true] => {
            let place = match (over_body, latitude_deg, longitude_deg, height_km, fov) {
                (Some(body), Some(latitude_deg), Some(longitude_deg), Some(height_km), Some(fov_deg)) => {
                    Some(UnresolvedVantage::Place { body, latitude_deg, longitude_deg, height_km, fov_deg })
                }
                _ => None,
            };
            (has_place && has_fov, place)
        }
        _ => (false, None),
    };
    if !is_complete {
        let source_line = table.source_line.clone();
        let allowed = "`from` and `fov_deg`; `side` or `away_from`, and `radii`; or `over`, `latitude_deg`, `longitude_deg`, `height_km` and `fov_deg`";
        table.report_invalid(&source_line, "vantage", "incomplete or ambiguous", allowed);
    }
    table.finish();
    Some(UnresolvedMoment {
        name: name?,
        kind: kind?.value,
        about: about?.value,
        time: Instant::parse(&time?.value).ok()?,
        target: target?,
        vantage: vantage?,
        source: source?.value,
    })
}

/// Looks up the bodies by their names, and sorts the moments by kind, then by time. A moment with an unknown body is left out and reported in `problems`.
pub(super) fn assemble(unresolved: Vec<UnresolvedMoment>, bodies: &[Body], problems: &Problems) -> Vec<Moment> {
    let names: Vec<(&str, NaifId)> =
        bodies.iter().flat_map(|b| std::iter::once(&b.name).chain(&b.aliases).map(move |name| (name.as_str(), b.id))).collect();
    let ids: BTreeMap<String, NaifId> = names.iter().map(|(name, id)| (name.to_lowercase(), *id)).collect();
    let known: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
    let resolve = |field: &str, name: &WithLine<String>| {
        let found = ids.get(&name.value.to_lowercase()).copied();
        if found.is_none() {
            problems.add_unknown_body(field, name, &known);
        }
        found
    };
    let mut moments: Vec<Moment> = Vec::new();
    for moment in unresolved {
        let target = resolve("target", &moment.target);
        let vantage = match moment.vantage {
            UnresolvedVantage::Centre { body, fov_deg } => resolve("from", &body).map(|body| Vantage::Centre { body, fov_deg }),
            UnresolvedVantage::Side { reference_body, is_far_side, distance_radii } => {
                let field = if is_far_side { "away_from" } else { "side" };
                resolve(field, &reference_body).map(|reference_body| Vantage::Side { reference_body, is_far_side, distance_radii })
            }
            UnresolvedVantage::Place { body, latitude_deg, longitude_deg, height_km, fov_deg } => {
                resolve("over", &body).map(|body| Vantage::Place { body, latitude_deg, longitude_deg, height_km, fov_deg })
            }
        };
        let (Some(target), Some(vantage)) = (target, vantage) else { continue };
        moments.retain(|m| m.name != moment.name.value);
        moments.push(Moment {
            name: moment.name.value,
            kind: moment.kind,
            about: moment.about,
            time: moment.time,
            target,
            vantage,
            source: moment.source,
        });
    }
    let kind_index = |m: &Moment| KINDS.iter().position(|k| *k == m.kind).unwrap_or(KINDS.len());
    moments.sort_by(|a, b| {
        kind_index(a).cmp(&kind_index(b)).then(a.time.tdb_seconds_past_j2000().total_cmp(&b.time.tdb_seconds_past_j2000()))
    });
    moments
}
