//! `sunlight`: the fraction of the Sun's light that other bodies and their rings leave at a point on a body's ground. Not considered: whether the body itself
//! (on its night side) or its own rings keep sunlight from the point. Every body of the catalog may count, however little it blocks (Mercury in transit: 3e-5
//! of the light); of more than [`MAX_OCCLUDERS`](crate::scene::draw::MAX_OCCLUDERS), those that block most. The rings of other bodies dim the place by the
//! catalog's limb darkening (`scene::rings::rings_before_sun`); those that take less than 2e-4 of the light of the whole body are left out.
//!
//! In: a body, a place on it, the time at which the light arrives at the ground, an eclipse model, coefficients of limb darkening. Out: `fraction`, `rgb` and
//! `by`. `fraction` is the green channel, with the law of limb darkening `u1` 0.40 and `u2` 0.26 (the Sun at 550 nm) unless the query gives others. `rgb` uses
//! the catalog's law per channel. `by` has for each body the fraction of green sunlight that it alone would block, and for its rings the fraction that they
//! block of the light past its globe. The models `linear` and `uniform-disc` have no limb darkening and ignore `u1` and `u2`.

use super::batch::{MAP_TAPS, PreparedProbe, ProbeInputs};
use super::{ProbeError, Prober, QueryKind, optional, parse_fields, required};
use crate::catalog::{Body, NaifId, Photometry};
use crate::ephemeris::topocentric::ground_point_km;
use crate::render::plan::uniform_bytes;
use crate::scene::draw::{DrawFeatures, DrawUniforms, Eclipse, EclipseModel, EclipseUniforms, Light};
use crate::scene::eclipse::{self, EclipseModelChoice, Occluder, Receiver, ReceiverExtent, ReceiverShape};
use crate::scene::rings::ring_table::RingTables;
use crate::scene::rings::rings_before_sun::{LitBody, rings_before_sun};
use crate::shader::ModuleId;
use crate::shader::key::ShaderKey;
use crate::time::Instant;
use glam::{DVec3, Vec3};
use serde::Deserialize;
use serde_json::{Map, Value, json};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    body: String,
    /// When the light meets the ground, as [`Instant::parse`] reads it.
    time: String,
    /// Planetographic latitude, degrees.
    lat: f64,
    /// Planetocentric east longitude, degrees.
    lon: f64,
    #[serde(default)]
    model: RequestedModel,
    /// Coefficient of 1 - mu in the Sun's limb darkening.
    #[serde(default = "u1_at_550_nm")]
    u1: f64,
    /// Coefficient of (1 - mu)^2.
    #[serde(default = "u2_at_550_nm")]
    u2: f64,
}

/// The default coefficients of limb darkening, for the Sun at 550 nm. They are defaults of the queries only; the catalog's green channel has 0.47 and 0.23.
pub(super) fn u1_at_550_nm() -> f64 {
    0.40
}
pub(super) fn u2_at_550_nm() -> f64 {
    0.26
}

/// Refuses coefficients for which the disc has no light (its flux is 1 - u1/3 - u2/6 times that of a uniform disc), and infinite ones.
pub(super) fn check_limb_darkening(u1: f64, u2: f64) -> Result<(), String> {
    match 1.0 - u1 / 3.0 - u2 / 6.0 > 0.0 && u1.is_finite() && u2.is_finite() {
        true => Ok(()),
        false => Err(format!("fields \"u1\" {u1} and \"u2\" {u2} leave the disc dark")),
    }
}

/// An [`EclipseModel`] that a query may name.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RequestedModel {
    Linear,
    UniformDisc,
    #[default]
    LimbDarkened,
    Refracted,
}

impl RequestedModel {
    fn model_choice(self) -> EclipseModelChoice {
        EclipseModelChoice::Requested(match self {
            Self::Linear => EclipseModel::Linear,
            Self::UniformDisc => EclipseModel::UniformDisc,
            Self::LimbDarkened => EclipseModel::LimbDarkened,
            Self::Refracted => EclipseModel::Refracted,
        })
    }
}

pub(super) static KIND: QueryKind = QueryKind {
    name: "sunlight",
    description: "the fraction of sunlight that other bodies, however small, and their rings leave at a point on a body's ground (not counting itself)",
    fields: &[
        required("body", "a body's name"),
        required("time", "ISO 8601 UTC or jd_tdb:DAY, when the light meets the ground"),
        required("lat", "planetographic latitude, degrees"),
        required("lon", "planetocentric east longitude, degrees"),
        optional("model", "linear, uniform-disc, limb-darkened or refracted", "limb-darkened"),
        optional("u1", "coefficient of 1 - mu in the Sun's limb darkening", "0.40"),
        optional("u2", "coefficient of (1 - mu)^2", "0.26"),
    ],
    example: r#"{"q":"sunlight","body":"earth","time":"2024-04-08T18:17:16Z","lat":25.29,"lon":-104.14}"#,
    answer,
};

fn answer(prober: &Prober<'_>, query: Value) -> Result<Value, ProbeError> {
    let query: Fields = parse_fields(query)?;
    let body = prober.catalog().body_named(&query.body).map_err(|e| format!("field \"body\": {e}"))?;
    if body.id == NaifId::SUN {
        return Err("field \"body\": the Sun lights itself".into());
    }
    let time = Instant::parse(&query.time).map_err(|e| format!("field \"time\": {e}"))?;
    if !(-90.0..=90.0).contains(&query.lat) || !(-360.0..=360.0).contains(&query.lon) {
        return Err("fields \"lat\" and \"lon\" are degrees: -90 to 90 and -360 to 360".into());
    }
    check_limb_darkening(query.u1, query.u2)?;
    let height_km = 0.0;
    let (point_km, _up) = ground_point_km(body.radii_km, query.lat, query.lon, height_km);
    let receiver = Receiver::at(prober.ephemeris(), body, time)?;
    let occluded_sun = OccludedSun::seen_from(prober, &receiver, query.model.model_choice())?;
    let same_law_in_all_channels = Photometry::Emissive { u1: [query.u1; 3], u2: [query.u2; 3] };
    let point_in_equatorial_radii = point_km / body.radii_km.x;
    let sunlight = |occluders: &[Occluder<'_>], sun_photometry| {
        let of_one_point = occluded_sun.sunlight(occluders, &[point_in_equatorial_radii], sun_photometry)?;
        of_one_point.first().copied().ok_or(ProbeError::from("no answer"))
    };
    // Of green light, by which the other channels differ only in the model `refracted`.
    let fraction = |occluders: &[Occluder<'_>]| sunlight(occluders, Some(&same_law_in_all_channels)).map(|[_, green, _]| green);
    let mut blocked_by = Map::new();
    for occluder in &occluded_sun.occluders {
        let blocked = 1.0 - fraction(std::slice::from_ref(occluder))?;
        blocked_by.insert(occluder.body.name.to_lowercase(), json!(blocked));
    }
    let ring_tables = RingTables::default();
    let place_km = receiver.body_from_icrf.transpose() * point_km;
    let mut past_rings = DVec3::ONE;
    for rings in rings_before_sun(prober.ephemeris(), prober.catalog(), &ring_tables, LitBody::from(&receiver)) {
        let fraction = rings.fraction_at(&ring_tables, place_km, occluded_sun.sun);
        blocked_by.insert(format!("{} rings", rings.owner.name.to_lowercase()), json!(1.0 - fraction.y));
        past_rings *= fraction;
    }
    let catalog_law = None;
    let past_bodies = DVec3::from_array(sunlight(&occluded_sun.occluders, catalog_law)?);
    let rgb = (past_bodies * past_rings).to_array();
    Ok(json!({ "fraction": fraction(&occluded_sun.occluders)? * past_rings.y, "rgb": rgb, "by": blocked_by }))
}

/// The occluders of the Sun for one body at one time, and the sunlight at points on the body's surface.
pub struct OccludedSun<'a> {
    prober: &'a Prober<'a>,
    receiver: &'a Receiver<'a>,
    sun: &'a Body,
    model_choice: EclipseModelChoice,
    /// The bodies that [`Self::seen_from`] found.
    pub occluders: Vec<Occluder<'a>>,
}

impl<'a> OccludedSun<'a> {
    /// Finds the bodies whose penumbra touches the receiver, however little they darken it; if more than
    /// [`MAX_OCCLUDERS`](crate::scene::draw::MAX_OCCLUDERS), those that block most light.
    ///
    /// # Errors
    /// The error is one line: the catalog has no Sun.
    pub fn seen_from(prober: &'a Prober<'a>, receiver: &'a Receiver<'a>, model_choice: EclipseModelChoice) -> Result<Self, ProbeError> {
        let sun = prober.catalog().body(NaifId::SUN).ok_or("the catalog has no Sun")?;
        // Points on the ground only, on every side and in every direction, without pixels. Without `min_change`, no shadow is too weak.
        let extent = ReceiverExtent { max_radius: 1.0, shape: ReceiverShape::Ball, camera_position: None, frustum: None, pixel_width: 0.0 };
        let (min_change, min_blocked_fraction) = (None, 0.0);
        let candidates = eclipse::candidates(prober.ephemeris(), prober.catalog().bodies().iter(), sun, receiver, min_blocked_fraction);
        let occluders = eclipse::select_occluders(&candidates, sun, receiver, extent, min_change, min_blocked_fraction).occluders;
        Ok(Self { prober, receiver, sun, model_choice, occluders })
    }

    /// Fraction of sunlight at points (body axes, equatorial radii), per channel. `sun_photometry`: the Sun's limb darkening; `None`: the catalog's.
    ///
    /// # Errors
    /// The error is one line: the module cannot be compiled, or the renderer fails.
    pub fn sunlight(
        &self,
        occluders: &[Occluder<'_>],
        points: &[DVec3],
        sun_photometry: Option<&Photometry>,
    ) -> Result<Vec<[f64; 3]>, ProbeError> {
        let mut occluders = occluders.to_vec();
        let mut sun = self.sun.clone();
        sun.photometry = sun_photometry.cloned().unwrap_or(sun.photometry);
        // The occluder whose air refracts light becomes the first, if the model needs it.
        let eclipse = eclipse::choose_eclipse_model(&mut occluders, self.model_choice);
        let uniforms = eclipse::uniforms_of_occluders(&occluders, eclipse.model, self.receiver, &sun);
        sunlight_from_uniforms(self.prober, eclipse, uniforms, points)
    }
}

/// Fraction of sunlight, per channel, that the shader computes at points (body axes, equatorial radii) for given uniforms.
///
/// # Errors
/// The error is one line: the module cannot be compiled, or needs a missing uniform, or the renderer fails.
pub fn sunlight_from_uniforms(
    prober: &Prober<'_>,
    eclipse: Eclipse,
    uniforms: EclipseUniforms,
    points: &[DVec3],
) -> Result<Vec<[f64; 3]>, ProbeError> {
    /// Rows of four numbers per point: red, green and blue; the fourth is unused.
    const RESULT_ROWS: u32 = 1;
    let key = ShaderKey::for_draw(&DrawFeatures { lights: 1, eclipse, ..DrawFeatures::MINIMAL });
    let module = ModuleId::Probe("probe_sunlight", key);
    // A key with an eclipse has a light; the probe reads neither its direction nor its irradiance.
    let lights = vec![Light { direction_in_body: Vec3::Z, irradiance: Vec3::ONE }];
    let built = prober.library().get(&module)?;
    // The probe reads no map, so `MAP_TAPS` has no effect.
    let uniform_bytes = uniform_bytes(&built.layout, &DrawUniforms { lights, eclipse: uniforms, ..DrawUniforms::default() }, MAP_TAPS)?;
    // The point's coordinates; the probe's other inputs are 0.
    let inputs_of = |p: &DVec3| -> ProbeInputs { std::array::from_fn(|k| p.to_array().get(k).copied().unwrap_or(0.0)) };
    let queries: Vec<_> = points.iter().map(inputs_of).collect();
    let results = PreparedProbe { uniform_bytes, ..PreparedProbe::without_bindings(module, RESULT_ROWS) }.results(
        prober.renderer,
        prober.library(),
        &queries,
    )?;
    results.iter().map(|rows| rows.first().map(|r| [r[0], r[1], r[2]].map(f64::from)).ok_or_else(|| "no answer".into())).collect()
}
