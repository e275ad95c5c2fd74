//! `scatter`: single scattering of sunlight along a ray through an atmosphere, and the ray's transmittance.
//!
//! In: an atmosphere, the camera, a direction and the direction of the Sun. Out: `radiance` per unit of solar irradiance, `transmittance`, and whether the ray
//! ends at the ground. The ray ends at the top of the atmosphere; the columns towards the Sun include the air above it (lib/air/column_density.wesl).

use super::batch::{MAP_TAPS, PreparedProbe, ProbeInputs};
use super::{ProbeError, Prober, QueryKind, parse_fields, required, unit_vector};
use crate::catalog::{self, AerosolFunction, AerosolPhase, PerChannel, PhaseFunction};
use crate::render::plan::uniform_bytes;
use crate::scene::atmosphere::{air, species};
use crate::scene::draw::{AtmosphereModel, AtmosphereUniforms, DrawFeatures, DrawUniforms, Light, Surface};
use crate::scene::multi_scatter_table;
use crate::shader::ModuleId;
use crate::shader::key::ShaderKey;
use crate::wording::{echo, suggestion_or_list};
use glam::{DVec3, Vec2, Vec3, Vec4};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Map, Value, json};
use std::sync::Arc;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    atmosphere: Atmosphere,
    /// Position of the camera in planet radii, relative to the planet's centre.
    cam: [f64; 3],
    /// Direction of the ray, away from the camera; of any length.
    dir: [f64; 3],
    /// Direction towards the Sun; of any length.
    sun: [f64; 3],
    /// In queries the field keeps the name that it had in earlier versions.
    #[serde(rename = "tier")]
    model: ModelName,
}

/// An atmosphere. The ignored fields, here and in [`Species`], occur in tests/data/rayleigh_reference_public.json, but no model needs them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Atmosphere {
    planet_radius_km: f64,
    top_km: f64,
    species: Vec<Species>,
    #[serde(rename = "note", default)]
    _note: IgnoredAny,
    #[serde(rename = "r_top", default)]
    _top_radius: IgnoredAny,
}

#[derive(Deserialize)]
#[serde(tag = "profile", rename_all = "kebab-case", deny_unknown_fields)]
enum Species {
    Exponential(ExponentialSpecies),
    /// An absorption layer: its density falls linearly to 0 at `half_width_km` above and below `centre_km`.
    Tent {
        centre_km: f64,
        half_width_km: f64,
        extinction_per_m: [f64; 3],
        /// Zero: a tent only absorbs.
        #[serde(default)]
        scattering_per_m: [f64; 3],
        #[serde(rename = "phase", default)]
        _phase: IgnoredAny,
        #[serde(rename = "scattering_per_planet_radius", default)]
        _scattering_per_radius: IgnoredAny,
        #[serde(rename = "extinction_per_planet_radius", default)]
        _extinction_per_radius: IgnoredAny,
    },
}

/// A gas or an aerosol.
#[derive(Deserialize)]
struct ExponentialSpecies {
    scale_height_km: f64,
    scattering_per_m: [f64; 3],
    extinction_per_m: [f64; 3],
    phase: PhaseName,
    #[serde(rename = "scattering_per_planet_radius", default)]
    _scattering_per_radius: IgnoredAny,
    #[serde(rename = "extinction_per_planet_radius", default)]
    _extinction_per_radius: IgnoredAny,
    /// All other fields; [`aerosol_phase`] reads them.
    #[serde(flatten)]
    others: Map<String, Value>,
}

/// The phase function that a word of a query names.
#[derive(Deserialize)]
#[serde(try_from = "String")]
enum PhaseName {
    Rayleigh,
    Aerosol(AerosolFunction),
}

impl TryFrom<String> for PhaseName {
    type Error = String;

    fn try_from(word: String) -> Result<Self, Self::Error> {
        const RAYLEIGH: &str = "rayleigh";
        if word == RAYLEIGH {
            return Ok(Self::Rayleigh);
        }
        AerosolFunction::of_word(&word).map(Self::Aerosol).ok_or_else(|| {
            let known: Vec<&str> = [RAYLEIGH].into_iter().chain(AerosolFunction::ALL.map(AerosolFunction::query_word)).collect();
            format!("`{}` is not a phase function; {}", echo(&word), suggestion_or_list(&word, &known))
        })
    }
}

/// The word of a query for an [`AtmosphereModel`].
#[derive(Deserialize)]
enum ModelName {
    #[serde(rename = "vertex")]
    Vertex,
    #[serde(rename = "pixel-8")]
    Pixel8,
    #[serde(rename = "pixel-16")]
    Pixel16,
    #[serde(rename = "pixel-32")]
    Pixel32,
    /// The single scattering of the table model.
    #[serde(rename = "table")]
    Table,
}

/// Greatest distance of the camera from the planet's centre, planet radii. At this distance the rounding of a direction moves the ray by 1e-7
/// radii at the planet.
const MAX_CAMERA_RADII: f64 = 1e9;

pub(super) static KIND: QueryKind = QueryKind {
    name: "scatter",
    description: "radiance of sunlight that is scattered once into a ray through air, per unit of solar irradiance, and the ray's transmittance; lengths in planet radii, centre at the origin",
    fields: &[
        required(
            "atmosphere",
            "planet_radius_km, top_km (the ray ends there, but sunlight is dimmed on its way by the whole profile: take at least \
             6 scale heights) and species: each with profile exponential (scale_height_km, scattering_per_m, extinction_per_m, \
             phase rayleigh or hg (Henyey-Greenstein), its asymmetry g: a number, or three for red, green and blue) or tent (centre_km, half_width_km, extinction_per_m)",
        ),
        required("cam", "[x, y, z], not inside the planet, at most 1e9 from its centre"),
        required("dir", "[x, y, z] away from the camera, of any length"),
        required("sun", "[x, y, z] towards the Sun, of any length"),
        required("tier", "the model: vertex, pixel-8, pixel-16, pixel-32 or table (its single scattering)"),
    ],
    example: r#"{"q":"scatter","atmosphere":{"planet_radius_km":6371,"top_km":60,"species":[{"profile":"exponential","scale_height_km":8,"scattering_per_m":[5.8e-6,1.35e-5,3.31e-5],"extinction_per_m":[5.8e-6,1.35e-5,3.31e-5],"phase":"rayleigh"}]},"cam":[0,0,1.0001],"dir":[1,0,0.2],"sun":[1,0,1],"tier":"pixel-16"}"#,
    answer,
};

fn answer(prober: &Prober<'_>, query: Value) -> Result<Value, ProbeError> {
    /// The rows that the probe module writes: radiance and transmittance.
    const RESULT_ROWS: u32 = 2;
    let query: Fields = parse_fields(query)?;
    let model = match query.model {
        ModelName::Vertex => AtmosphereModel::Vertex,
        ModelName::Pixel8 => AtmosphereModel::Pixel8,
        ModelName::Pixel16 => AtmosphereModel::Pixel16,
        ModelName::Pixel32 => AtmosphereModel::Pixel32,
        ModelName::Table => AtmosphereModel::Table,
    };
    let (camera, direction, sun) = (DVec3::from_array(query.cam), unit_vector("dir", query.dir)?, unit_vector("sun", query.sun)?);
    let camera_radius_sq_minus_1 = (camera.length() - 1.0) * (camera.length() + 1.0);
    // A position on the ground may be slightly inside by rounding.
    if camera_radius_sq_minus_1 <= -1e-9 {
        return Err("field \"cam\" is inside the planet, whose radius is 1".into());
    }
    if camera.abs().max_element() > MAX_CAMERA_RADII {
        return Err(format!("field \"cam\" is more than {MAX_CAMERA_RADII:e} planet radii away").into());
    }
    check_atmosphere(&query.atmosphere)?;
    let atmosphere = catalog_atmosphere(&query.atmosphere)?;
    let features = species::features_of_air(&atmosphere, model);
    let key = ShaderKey::for_draw(&DrawFeatures { surface: Surface::Sky, lights: 1, air: features, ..DrawFeatures::MINIMAL });
    let module = ModuleId::Probe("probe_scatter", key);
    // Terms that would cancel in f32 are computed here in f64, as for the shader of a draw. `nearest` is the point of the ray's line nearest to the planet's
    // centre; `along` is the distance from there to the camera, positive in the direction of the ray, so negative if `nearest` is ahead. The distance of
    // `nearest` from the centre is not computed as sqrt(|camera|^2 - along^2), which would cancel for a distant camera. The numbers are in the order in which
    // shaders/entry/probe_scatter.wesl reads them.
    let along = camera.dot(direction);
    let nearest = camera - along * direction;
    let nearest_radius_sq_minus_1 = nearest.length_squared() - 1.0;
    let hits_ground = along < 0.0 && nearest_radius_sq_minus_1 < 0.0;
    let uniform_bytes =
        air_uniform_bytes(prober, &module, &atmosphere, query.atmosphere.planet_radius_km, camera.length() - 1.0, !hits_ground)?;
    let mut numbers: ProbeInputs = [0.0; 12];
    numbers[..3].copy_from_slice(&nearest.to_array());
    numbers[3] = nearest_radius_sq_minus_1;
    numbers[4..7].copy_from_slice(&direction.to_array());
    numbers[7] = along;
    numbers[8..11].copy_from_slice(&sun.to_array());
    numbers[11] = camera_radius_sq_minus_1;
    let probe = PreparedProbe { uniform_bytes, ..PreparedProbe::without_bindings(module, RESULT_ROWS) };
    let results = probe.results(prober.renderer, prober.library(), &[numbers])?;
    let [radiance, transmittance] = results.first().map(Vec::as_slice).unwrap_or_default() else { return Err("no answer".into()) };
    if !radiance[..3].iter().chain(&transmittance[..3]).all(|x| x.is_finite()) {
        let why = "field \"atmosphere\": the answer is not a number, because the lengths differ by too many powers of ten";
        return Err(why.into());
    }
    // The fourth number of the row of radiance is 1 if the ray ends at the ground, otherwise 0.
    Ok(json!({ "transmittance": &transmittance[..3], "radiance": &radiance[..3], "hits_ground": radiance[3] > 0.5 }))
}

/// The error about a field of an atmosphere whose value is not allowed.
fn out_of_range(field: &str, allowed: &str) -> String {
    format!("field \"atmosphere\": {field} must be {allowed}")
}

/// Checks the field values of an atmosphere, except those of an aerosol's phase function.
fn check_atmosphere(atmosphere: &Atmosphere) -> Result<(), String> {
    let is_positive = |x: f64| x > 0.0 && x.is_finite();
    for (field, value) in [("planet_radius_km", atmosphere.planet_radius_km), ("top_km", atmosphere.top_km)] {
        if !is_positive(value) {
            return Err(out_of_range(field, "greater than 0"));
        }
    }
    for s in &atmosphere.species {
        let (lengths, coefficients) = match s {
            Species::Exponential(ExponentialSpecies { scale_height_km, scattering_per_m, extinction_per_m, .. }) => {
                if extinction_per_m.iter().zip(scattering_per_m).any(|(extinction, scattering)| extinction < scattering) {
                    return Err(out_of_range("extinction_per_m", "at least scattering_per_m, which it includes"));
                }
                (
                    vec![("scale_height_km", *scale_height_km)],
                    vec![("scattering_per_m", scattering_per_m), ("extinction_per_m", extinction_per_m)],
                )
            }
            Species::Tent { centre_km, half_width_km, extinction_per_m, scattering_per_m, .. } => {
                if !(*centre_km >= 0.0 && centre_km.is_finite()) {
                    return Err(out_of_range("centre_km", "0 or greater"));
                }
                if *scattering_per_m != [0.0; 3] {
                    return Err(out_of_range("scattering_per_m", "0 in a tent, which only absorbs"));
                }
                (vec![("half_width_km", *half_width_km)], vec![("extinction_per_m", extinction_per_m)])
            }
        };
        if let Some((field, _)) = lengths.into_iter().find(|(_, x)| !is_positive(*x)) {
            return Err(out_of_range(field, "greater than 0"));
        }
        if let Some((field, _)) = coefficients.into_iter().find(|(_, v)| !v.iter().all(|x| (0.0..=1.0).contains(x))) {
            return Err(out_of_range(field, "three numbers from 0 to 1 per metre"));
        }
    }
    // Numbers of gases, aerosols and absorbing layers, in this order.
    let mut counts = [0; 3];
    for s in &atmosphere.species {
        let kind = match s {
            Species::Exponential(ExponentialSpecies { phase: PhaseName::Rayleigh, .. }) => 0,
            Species::Exponential(ExponentialSpecies { phase: PhaseName::Aerosol(_), .. }) => 1,
            Species::Tent { .. } => 2,
        };
        counts[kind] += 1;
    }
    if counts.iter().any(|count| *count > 1) {
        return Err(
            "field \"atmosphere\": at most one gas (phase rayleigh), one aerosol (another phase) and one layer (profile tent)".into()
        );
    }
    Ok(())
}

/// The phase function of an aerosol with these fields: those of [`AerosolPhase::FIELDS`] that the function has, and no others.
fn aerosol_phase(function: AerosolFunction, fields: &Map<String, Value>) -> Result<AerosolPhase, String> {
    let mut aerosol = AerosolPhase::of(function);
    for (key, value) in fields {
        let Some(field) = AerosolPhase::FIELDS.iter().find(|field| field.query_key == key) else {
            let known: Vec<&str> = AerosolPhase::FIELDS.iter().map(|field| field.query_key).collect();
            let hint = suggestion_or_list(key, &known);
            return Err(format!("field \"atmosphere\": `{}` is not a field of an exponential species; {hint}", echo(key)));
        };
        let value = PerChannel::deserialize(value).ok();
        aerosol = value.and_then(|value| field.set(aerosol, value)).ok_or_else(|| out_of_range(key, &field.allowed()))?;
        if !field.functions.contains(&function) {
            return Err(out_of_range(key, &format!("beside a phase that has it: {}", AerosolFunction::words(field.functions))));
        }
    }
    Ok(aerosol)
}

/// The atmosphere as an entry of a catalog, whose coefficients are per kilometre.
fn catalog_atmosphere(atmosphere: &Atmosphere) -> Result<catalog::Atmosphere, String> {
    let per_km = |per_m: &[f64; 3]| per_m.map(|x| x * 1000.0);
    let species = |s: &Species| match s {
        Species::Exponential(ExponentialSpecies { scale_height_km, scattering_per_m, extinction_per_m, phase, others, .. }) => {
            let phase = match *phase {
                // A gas may have the fields of an aerosol of catalogs, too: they are checked, but have no effect.
                PhaseName::Rayleigh => aerosol_phase(AerosolFunction::OF_CATALOGS, others).map(|_| PhaseFunction::Rayleigh)?,
                PhaseName::Aerosol(function) => PhaseFunction::Aerosol(aerosol_phase(function, others)?),
            };
            Ok(catalog::Species {
                name: String::new(),
                scale_height_km: *scale_height_km,
                tent_centre_km: None,
                scattering_per_km: per_km(scattering_per_m),
                // Converted to per kilometre before subtracting: then scattering + absorption gives back exactly the converted extinction if
                // extinction <= 2 * scattering (Sterbenz).
                absorption_per_km: std::array::from_fn(|k| per_km(extinction_per_m)[k] - per_km(scattering_per_m)[k]),
                phase,
                estimate_percent: None,
            })
        }
        Species::Tent { centre_km, half_width_km, extinction_per_m, .. } => Ok(catalog::Species {
            name: String::new(),
            // For a tent this is the half width.
            scale_height_km: *half_width_km,
            tent_centre_km: Some(*centre_km),
            scattering_per_km: [0.0; 3],
            absorption_per_km: per_km(extinction_per_m),
            // Without effect, because a tent does not scatter.
            phase: PhaseFunction::Rayleigh,
            estimate_percent: None,
        }),
    };
    let species = atmosphere.species.iter().map(species).collect::<Result<_, String>>()?;
    Ok(catalog::Atmosphere {
        top_km: atmosphere.top_km,
        refractivity: None,
        limb_haze_km: None,
        airglow_cd_m2: None,
        forward_light: Vec::new(),
        species,
    })
}

/// The bytes of the module's uniform struct `Draw`. `camera_height`: above the ground, in planet radii; `misses_ground`: the ray ends at the top of the
/// atmosphere.
fn air_uniform_bytes(
    prober: &Prober<'_>,
    module: &ModuleId,
    atmosphere: &catalog::Atmosphere,
    radius_km: f64,
    camera_height: f64,
    misses_ground: bool,
) -> Result<Vec<u8>, ProbeError> {
    let built = prober.library().get(module)?;
    let top = atmosphere.top_km / radius_km;
    // The air is computed down to the ground.
    const FLOOR_RADII: f64 = 1.0;
    let air = AtmosphereUniforms {
        end_heights: Vec2::new(camera_height.clamp(0.0, top) as f32, if misses_ground { top as f32 } else { 0.0 }),
        // Only single scattering.
        multi_scatter_heights: Vec2::ZERO,
        multi_scatter: Arc::new(vec![Vec4::ZERO; multi_scatter_table::NODES]),
        ..air::uniforms_of(atmosphere, radius_km, FLOOR_RADII)
    };
    // The direction of the light is an input of the query, so the module does not use that of the uniforms.
    let lights = vec![Light { direction_in_body: Vec3::Z, irradiance: Vec3::ONE }];
    Ok(uniform_bytes(&built.layout, &DrawUniforms { air, lights, ..DrawUniforms::default() }, MAP_TAPS)?)
}
