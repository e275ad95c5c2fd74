//! `orrery explain`: lists for every body of a view which effects are drawn, which are not, and why.
//!
//! In: a view (`view_args`). Out: text or JSON on standard output. Nothing is drawn. Not here: the decisions and their reasons (`scene`).

use super::output::{print_message, print_result};
use super::view_args::{ViewArgs, below_horizon_message};
use super::{CliError, Common};
use crate::catalog::{Body, Catalog, NaifId};
use crate::message::Message;
use crate::render::plan::SamplingQuality;
use crate::scene::request::Purpose;
use crate::scene::{Appearance, BodyReport, Scene};
use crate::session::Session;
use crate::shader::key::ShaderKey;
use serde_json::{Value, json};

#[derive(clap::Args, Debug, Default)]
#[command(
    after_help = "Example:\n  orrery explain --target jupiter --from earth --time 2024-12-07T20:00:00Z",
    next_help_heading = "Output"
)]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    view: ViewArgs,
    /// Print one JSON value
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Print the render passes and their draws instead
    #[arg(long, conflicts_with = "json", help_heading = "Output")]
    passes: bool,
    /// Explain linear output (EXR files, pixel probes) in place of a display image
    #[arg(long, help_heading = "Output")]
    linear: bool,
    /// Include bodies that are not in the image
    #[arg(long, help_heading = "Output")]
    all: bool,
}

pub(crate) fn run(common: &Common, args: &ExplainArgs) -> Result<(), CliError> {
    let session = Session::open(&common.sources(), print_message)?;
    let mut request = args.view.request(session.catalog())?;
    request.quality = common.quality;
    request.purpose = if args.linear { Purpose::LINEAR } else { Purpose::Display };
    if args.passes {
        return print_result(&session.passes(&request, SamplingQuality::of(common.quality))?);
    }
    let scene = session.scene(&request)?;
    below_horizon_message(&request, &scene).iter().for_each(|message| print_message(message));
    let bodies: Vec<&BodyReport> = scene.bodies.iter().filter(|b| args.all || b.appearance != Appearance::NotShown).collect();
    let text = if args.json {
        let value = json!({
            "time": scene.time.to_utc_iso(),
            "exposure": {"stops": scene.exposure.stops, "reason": scene.exposure.reason},
            "eclipse_radii": session.catalog().eclipse_radii_text(),
            "purpose": scene.purpose.to_string(),
            "sky": scene.sky_decisions,
            "bodies": bodies.iter().map(|b| as_json(b, &estimate_notes(session.catalog(), b))).collect::<Vec<_>>(),
        });
        format!("{value:#}\n")
    } else {
        as_text(&scene, &bodies, session.catalog())
    };
    print_result(&text)
}

/// The shader keys of a body's draws. The key of the globe comes first.
fn keys(body: &BodyReport) -> Vec<String> {
    body.features.iter().map(|f| ShaderKey::for_draw(f).to_string()).collect()
}

/// The estimated values of the body in the catalog and their effect on the image, one note per value.
fn estimate_notes(catalog: &Catalog, body: &BodyReport) -> Vec<Message> {
    catalog.body(body.id).map(Body::estimate_notes).unwrap_or_default()
}

/// A body as JSON: the fields of its report, null where they are undefined, and its shader keys, its estimates, and what of it is invented.
fn as_json(body: &BodyReport, estimate_notes: &[Message]) -> Value {
    let mut value = json!(body);
    if !body.has_direction() {
        for undefined in ["angular_diameter_deg", "phase_angle_deg", "sub_viewer"] {
            value[undefined] = Value::Null;
        }
    }
    let keys = keys(body);
    value["key"] = json!(keys.first());
    value["keys"] = json!(keys);
    value["estimates"] = json!(estimate_notes);
    value["invented"] = body.invented.iter().map(|i| json!({"file": i.source, "how": i.how_made})).collect();
    value
}

/// A distance with seven digits, as a plain number up to a hundred light years, in kilometres.
fn kilometres(km: f64) -> String {
    let digits_before_point = km.abs().max(1e-3).log10().floor() as i32 + 1;
    let decimals = (7 - digits_before_point).clamp(0, 9) as usize;
    if km.abs() < 1e15 { format!("{km:.decimals$} km") } else { format!("{km:.6e} km") }
}

/// Distance, size, phase and magnitude of a body, and its sub-observer and sub-solar points: two lines of text after an empty one; without the second line if
/// the points are not defined.
fn seen_by_the_camera(body: &BodyReport) -> String {
    let heading = if body.has_direction() {
        let none = if body.id == NaifId::SUN { "none (entirely hidden)" } else { "none (in full shadow)" };
        let magnitude = body.magnitude.map_or(none.to_owned(), |m| format!("{m:.2}"));
        let (distance, diameter_px, phase_angle_deg) = (kilometres(body.distance_km), body.diameter_px, body.phase_angle_deg);
        format!("{distance} away, {diameter_px:.3} px across, phase angle {phase_angle_deg:.2} deg, magnitude {magnitude}")
    } else if body.distance_km == 0.0 {
        "the camera is at its centre".to_owned()
    } else {
        "its place is unknown".to_owned()
    };
    let sub_observer = body.has_direction().then_some(("sub-observer", body.sub_observer));
    let points = sub_observer.into_iter().chain(body.sub_solar.map(|point| ("sub-solar", point)));
    let points: Vec<_> = points.map(|(name, p)| format!("{name} {:.3} {:.3}", p.lat_centric_deg, p.lon_east_deg)).collect();
    let mut text = format!("\n{}: {heading}\n", body.name);
    if !points.is_empty() {
        text.push_str(&format!("  {} (planetocentric latitude, east longitude)\n", points.join(", ")));
    }
    text
}

/// The report as text. `+` marks what is drawn, `-` what is not, and `~` a note on an estimate.
fn as_text(scene: &Scene, bodies: &[&BodyReport], catalog: &Catalog) -> String {
    let mut text = format!(
        "{}  exposure {:+.2} stops ({})\nfor {}\n",
        scene.time.to_utc_iso(),
        scene.exposure.stops,
        scene.exposure.reason,
        scene.purpose
    );
    text.push_str(&format!("radii in eclipses (--radii): {}\n", catalog.eclipse_radii_text()));
    for decision in &scene.sky_decisions {
        text.push_str(&format!("{} {} {}\n", if decision.on { '+' } else { '-' }, decision.effect, decision.description()));
    }
    for body in bodies {
        text.push_str(&seen_by_the_camera(body));
        for key in keys(body) {
            text.push_str(&format!("  key {key}\n"));
        }
        for note in estimate_notes(catalog, body) {
            text.push_str(&format!("  ~ {note}\n"));
        }
        for decision in &body.decisions {
            text.push_str(&format!("  {} {:13} {}\n", if decision.on { '+' } else { '-' }, decision.effect, decision.description()));
        }
    }
    text
}
