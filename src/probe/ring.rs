//! `ring-transmission`: the fraction of sunlight that a ring transmits; `ring-shadow`: the fraction that a planet blocks from its ring.
//!
//! In: a ring (a profile given in the query, or that of a body in the catalog) or a planet's figure, a point, the direction of the Sun, a model. Out: one
//! fraction, `transmission` or `blocked`. Lengths are in equatorial radii; axes are the body's, with the pole at +z. The shadow of a planet on its ring, which
//! `ring-shadow` asks for, is called [`BodyShadow`] in the code; [`RingShadow`] is the shadow of a ring.

use super::batch::{MAP_TAPS, PreparedProbe, ProbeInputs};
use super::sunlight::{check_limb_darkening, u1_at_550_nm, u2_at_550_nm};
use super::{ProbeError, Prober, QueryKind, alternative, optional, parse_fields, required, unit_vector};
use crate::catalog::{Body, Ring};
use crate::render::plan::{RING_PROFILE, TextureBinding, TextureSource, ring_profile, uniform_bytes};
use crate::scene::draw::{BodyShadow, DrawFeatures, DrawUniforms, Light, RingShadow, RingTable, RingUniforms, Surface};
use crate::scene::rings::ring_table::MAX_NODES;
use crate::scene::rings::slants_of_sunlight;
use crate::shader::ModuleId;
use crate::shader::key::ShaderKey;
use glam::{DVec3, Vec2, Vec3};
use serde::Deserialize;
use serde_json::{Value, json};
use std::sync::Arc;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Annulus {
    /// Inner radius, equatorial radii.
    r_in: f64,
    /// Outer radius, equatorial radii.
    r_out: f64,
    /// Optical depth along the normal of the plane.
    tau_normal: f64,
    #[serde(default)]
    name: String,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum TransmissionModel {
    /// One ray to the Sun's centre.
    #[default]
    PointSun,
    /// The mean over the Sun's disc.
    Penumbra,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TransmissionFields {
    /// The ring; a query gives either this or `body`.
    profile: Option<Vec<Annulus>>,
    body: Option<String>,
    /// Accepted without effect: the light that a ring transmits to a given point does not depend on the shape of the planet.
    #[serde(default)]
    #[allow(dead_code)]
    flattening: f64,
    point: [f64; 3],
    sun: [f64; 3],
    #[serde(default)]
    sun_angular_radius_deg: f64,
    #[serde(default)]
    model: TransmissionModel,
}

#[derive(Clone, Copy, Default, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
enum BodyShadowModel {
    /// A point Sun behind a sphere.
    Sphere,
    /// A uniform disc of the Sun behind the ellipsoid.
    #[serde(alias = "uniform")]
    UniformDisc,
    /// A limb-darkened disc of the Sun behind the ellipsoid.
    #[default]
    #[serde(alias = "ellipsoid-penumbra")]
    LimbDarkened,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyShadowFields {
    /// A query gives either this or `flattening`.
    body: Option<String>,
    flattening: Option<f64>,
    point: [f64; 3],
    sun: [f64; 3],
    #[serde(default)]
    sun_angular_radius_deg: f64,
    #[serde(default)]
    model: BodyShadowModel,
    /// Coefficient of 1 - mu in the Sun's limb darkening; `None`: that at 550 nm.
    u1: Option<f64>,
    /// Coefficient of (1 - mu)^2; `None`: that at 550 nm.
    u2: Option<f64>,
}

/// Coordinates of a point and radii of a ring are below this, in equatorial radii.
const MAX_RADII: f64 = 1e6;

/// Largest optical depth of a ring along its normal. A ring of a far smaller depth already lets no light pass.
const MAX_TAU: f64 = 1e4;

/// Tangent of the Sun's angular radius, which is given in degrees; at least 1e-6, so that a point Sun becomes a very small disc.
fn sun_radius_tangent(degrees: f64) -> Result<f32, ProbeError> {
    if (0.0..=20.0).contains(&degrees) {
        Ok(degrees.to_radians().tan().max(1e-6) as f32)
    } else {
        Err(format!("field \"sun_angular_radius_deg\" {degrees}: degrees from 0 to 20").into())
    }
}

fn body<'a>(prober: &'a Prober<'_>, name: &str) -> Result<&'a Body, ProbeError> {
    prober.catalog().body_named(name).map_err(|e| format!("field \"body\": {e}").into())
}

/// The fraction of sunlight that a probe module computes at a point. `probe_name`: name of the module's fragment in shaders/entry; `point`: body axes,
/// equatorial radii.
fn evaluate(
    prober: &Prober<'_>,
    probe_name: &'static str,
    features: &DrawFeatures,
    uniforms: &DrawUniforms,
    point: [f64; 3],
) -> Result<f64, ProbeError> {
    // A row of four numbers: red, green, blue, alpha.
    const RESULT_ROWS: u32 = 1;
    if !point.iter().all(|x| x.abs() < MAX_RADII) {
        return Err(format!("field \"point\": three numbers below {MAX_RADII:e} equatorial radii").into());
    }
    let module = ModuleId::Probe(probe_name, ShaderKey::for_draw(features));
    let built = prober.library().get(&module)?;
    let uniform_bytes = uniform_bytes(&built.layout, uniforms, MAP_TAPS)?;
    let binding = built.layout.textures.iter().find(|t| t.name == RING_PROFILE).map(|t| t.binding);
    let texture = |(table, binding): (&Arc<RingTable>, u32)| TextureBinding { binding, source: TextureSource::Image(ring_profile(table)) };
    let textures = uniforms.ring.table.iter().zip(binding).map(texture).collect();
    // The fragment reads only the first three inputs.
    let mut numbers: ProbeInputs = [0.0; 12];
    numbers[..3].copy_from_slice(&point);
    let probe = PreparedProbe { uniform_bytes, textures, ..PreparedProbe::without_bindings(module, RESULT_ROWS) };
    let results = probe.results(prober.renderer, prober.library(), &[numbers])?;
    // The green channel; all channels are equal here.
    results.first().and_then(|rows| rows.first()).map(|row| f64::from(row[1])).ok_or_else(|| "no answer".into())
}

/// Sunlight of irradiance 1, as the only light of a draw. `sun`: unit vector towards the Sun, body axes.
fn sun_light(sun: DVec3) -> Vec<Light> {
    vec![Light { direction_in_body: sun.as_vec3(), irradiance: Vec3::ONE }]
}

pub(super) static TRANSMISSION: QueryKind = QueryKind {
    name: "ring-transmission",
    description: "the fraction of the Sun's light that a ring transmits to a point; lengths in equatorial radii, body-fixed axes, pole +z",
    fields: &[
        alternative(
            "profile",
            "a list of {\"r_in\", \"r_out\", \"tau_normal\"}, with r_out below 1e6 and tau_normal from 0 to 1e4; where two overlap, the later in the list counts",
        ),
        alternative("body", "a body's name: its rings in the catalog"),
        required("point", "[x, y, z], each below 1e6"),
        required("sun", "[x, y, z] towards the Sun, of any length"),
        optional("sun_angular_radius_deg", "0 to 20", "0"),
        optional("model", "point-sun or penumbra", "point-sun"),
        optional("flattening", "of the planet; accepted, without effect", "0"),
    ],
    example: r#"{"q":"ring-transmission","body":"saturn","point":[0.9,0,0.2],"sun":[0.9,0,-0.4]}"#,
    answer: transmission,
};

pub(super) static BODY_SHADOW: QueryKind = QueryKind {
    name: "ring-shadow",
    description: "the fraction of the Sun's light that a planet blocks at a point of its ring; lengths in equatorial radii, body-fixed axes, pole +z",
    fields: &[
        alternative("flattening", "of the planet, from 0 to below 0.9"),
        alternative("body", "a body's name: its figure in the catalog"),
        required("point", "[x, y, z], each below 1e6"),
        required("sun", "[x, y, z] towards the Sun, of any length"),
        optional("sun_angular_radius_deg", "0 to 20", "0"),
        optional("model", "sphere, uniform-disc or limb-darkened", "limb-darkened"),
        optional("u1", "coefficient of 1 - mu in the Sun's limb darkening", "0.40"),
        optional("u2", "coefficient of (1 - mu)^2", "0.26"),
    ],
    example: r#"{"q":"ring-shadow","body":"saturn","point":[-1.5,0,0],"sun":[1,0,0.4],"sun_angular_radius_deg":0.028}"#,
    answer: body_shadow,
};

fn transmission(prober: &Prober<'_>, query: Value) -> Result<Value, ProbeError> {
    let query: TransmissionFields = parse_fields(query)?;
    let sun = unit_vector("sun", query.sun)?;
    let sun_tangent = sun_radius_tangent(query.sun_angular_radius_deg)?;
    let ring_shadow = match query.model {
        TransmissionModel::PointSun => RingShadow::PointSun,
        TransmissionModel::Penumbra => RingShadow::Penumbra,
    };
    let slants = slants_of_sunlight(sun.z, f64::from(sun_tangent), ring_shadow == RingShadow::Penumbra);
    let table = match (&query.profile, &query.body) {
        (Some(profile), None) => {
            if let Some(invalid) = profile
                .iter()
                .find(|a| !(a.r_in >= 0.0 && a.r_out > a.r_in && a.r_out < MAX_RADII && (0.0..=MAX_TAU).contains(&a.tau_normal)))
            {
                return Err(format!(
                    "field \"profile\": {:?} to {:?} of optical depth {:?}: r_in from 0, r_out above it and below {MAX_RADII:e}, tau_normal from 0 to {MAX_TAU:e}",
                    invalid.r_in, invalid.r_out, invalid.tau_normal
                )
                .into());
            }
            let ring = |a: &Annulus| Ring {
                name: a.name.clone(),
                inner_km: a.r_in,
                outer_km: a.r_out,
                tau_normal: a.tau_normal,
                albedo: [0.0; 3],
                dust_fraction: 0.0,
            };
            let rings: Vec<_> = profile.iter().map(ring).collect();
            // The profile's radii are in equatorial radii, the unit of the table.
            let unit_km = 1.0;
            let table = RingTable::of_shadow(rings.iter(), unit_km, &slants);
            if table.is_none() && !rings.is_empty() {
                return Err(format!("field \"profile\": its edges divide the ring into {MAX_NODES} or more intervals").into());
            }
            table
        }
        (None, Some(name)) => {
            let body = body(prober, name)?;
            RingTable::of_shadow(body.rings.iter(), body.radii_km.x, &slants)
        }
        _ => return Err("give either \"profile\" or \"body\"".into()),
    };
    // Without rings there is no table, and nothing dims the Sun.
    let Some(table) = table else { return Ok(json!({ "transmission": 1.0 })) };
    let ring = RingUniforms {
        radius_range: Vec2::new(table.radius_range[0] as f32, table.radius_range[1] as f32),
        table: Some(Arc::new(table)),
        sun_tangent,
        ..RingUniforms::default()
    };
    let features = DrawFeatures { lights: 1, ring_shadow, ..DrawFeatures::MINIMAL };
    let uniforms = DrawUniforms { lights: sun_light(sun), ring, ..DrawUniforms::default() };
    Ok(json!({ "transmission": evaluate(prober, "probe_ring_transmission", &features, &uniforms, query.point)? }))
}

fn body_shadow(prober: &Prober<'_>, query: Value) -> Result<Value, ProbeError> {
    let query: BodyShadowFields = parse_fields(query)?;
    let sun = unit_vector("sun", query.sun)?;
    let semi_axes = match (query.flattening, &query.body) {
        (Some(flattening), None) if (0.0..0.9).contains(&flattening) => DVec3::new(1.0, 1.0, 1.0 - flattening),
        (Some(flattening), None) => return Err(format!("field \"flattening\" {flattening}: from 0 to below 0.9").into()),
        (None, Some(name)) => {
            let body = body(prober, name)?;
            body.radii_km / body.radii_km.x
        }
        _ => return Err("give either \"flattening\" or \"body\"".into()),
    };
    let (u1, u2) = match query.model {
        BodyShadowModel::UniformDisc => (0.0, 0.0),
        _ => (query.u1.unwrap_or_else(u1_at_550_nm), query.u2.unwrap_or_else(u2_at_550_nm)),
    };
    check_limb_darkening(u1, u2)?;
    let ring = RingUniforms {
        sun_tangent: sun_radius_tangent(query.sun_angular_radius_deg)?,
        shadow_axes: semi_axes.as_vec3(),
        sun_limb_darkening_u1: Vec3::splat(u1 as f32),
        sun_limb_darkening_u2: Vec3::splat(u2 as f32),
        ..RingUniforms::default()
    };
    let body_shadow = if query.model == BodyShadowModel::Sphere { BodyShadow::Sphere } else { BodyShadow::EllipsoidPenumbra };
    let features = DrawFeatures { surface: Surface::Ring, lights: 1, body_shadow, ..DrawFeatures::MINIMAL };
    let uniforms = DrawUniforms { lights: sun_light(sun), ring, ..DrawUniforms::default() };
    let unblocked = evaluate(prober, "probe_body_shadow", &features, &uniforms, query.point)?;
    Ok(json!({ "blocked": 1.0 - unblocked }))
}
