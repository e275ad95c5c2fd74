//! `orrery explain`: lists for every body of a view which effects are drawn, which are not, and why.
//!
//! In: a view (`view_args`). Out: text or JSON on standard output. Nothing is drawn. Not here: the decisions and their reasons (`scene`).

use super::output::{print_message, print_result};
use super::view_args::ViewArgs;
use super::{CliError, Common};
use crate::catalog::{Body, Catalog};
use crate::message::Message;
use crate::render::plan::SamplingQuality;
use crate::scene::request::Purpose;
use crate::scene::{Appearance, BodyInView, Scene};
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
    let bodies: Vec<&BodyInView> = scene.bodies.iter().filter(|b| args.all || b.appearance != Appearance::NotShown).collect();
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
fn keys(body: &BodyInView) -> Vec<String> {
    body.features.iter().map(|f| ShaderKey::for_draw(f).to_string()).collect()
}

/// The estimated values of the body in the catalog and their effect on the image, one note per value.
fn estimate_notes(catalog: &Catalog, body: &BodyInView) -> Vec<Message> {
    catalog.body(body.id).map(Body::estimate_notes).unwrap_or_default()
}

fn as_json(body: &BodyInView, estimate_notes: &[Message]) -> Value {
    json!({
        "id": body.id, "name": body.name, "appearance": body.appearance, "key": keys(body).first(), "keys": keys(body),
        "distance_km": body.distance_km, "angular_diameter_deg": body.angular_diameter_deg, "diameter_px": body.diameter_px,
        "phase_angle_deg": body.phase_angle_deg, "magnitude": body.magnitude,
        "sub_viewer": body.sub_observer, "sub_solar": body.sub_solar, "features": body.decisions, "estimates": estimate_notes,
        "invented": body.invented.iter().map(|(file, how)| json!({"file": file, "how": how})).collect::<Vec<_>>(),
    })
}

/// The report as text. `+` marks what is drawn, `-` what is not, and `~` a note on an estimate.
fn as_text(scene: &Scene, bodies: &[&BodyInView], catalog: &Catalog) -> String {
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
        let magnitude = body.magnitude.map_or("none (in full shadow)".to_owned(), |m| format!("{m:.2}"));
        text.push_str(&format!(
            "\n{}: {:.6e} km away, {:.3} px across, phase angle {:.2} deg, magnitude {magnitude}\n",
            body.name, body.distance_km, body.diameter_px, body.phase_angle_deg
        ));
        text.push_str(&format!("  sub-observer {:.3} {:.3}", body.sub_observer.lat_centric_deg, body.sub_observer.lon_east_deg));
        if let Some(sub_solar) = body.sub_solar {
            text.push_str(&format!(", sub-solar {:.3} {:.3}", sub_solar.lat_centric_deg, sub_solar.lon_east_deg));
        }
        text.push_str(" (planetocentric latitude, east longitude)\n");
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
