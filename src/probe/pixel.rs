//! `pixel`: the colour of one pixel of a view, and the values from which its module computes it.
//!
//! In: `view`, a camera file (`--camera-json`); `time`, `size` ([1024, 1024] by default) and `effects`, as on the command line; `x` and `y`, counted from
//! the image's upper left corner. Out: `radiance`, the linear pixel of the EXR that `orrery render` writes; `draws`, the draws that cover the pixel's
//! centre, nearest first. Each draw has every value bound to a name in its WGSL (`let`, `var`), after the last assignment.

use super::{ProbeError, Prober, QueryField, QueryKind, optional, parse_fields, required};
use crate::catalog::NaifId;
use crate::ephemeris::topocentric::place_of_normal_deg;
use crate::render::plan::{FrameImages, Plan, SamplingQuality};
use crate::render::software::{NamedValue, PixelValues};
use crate::scene::draw::{BodyPart, Draw};
use crate::scene::effects::EffectOverrides;
use crate::scene::request::{CameraFile, Purpose, ViewRequest};
use crate::scene::{OutOfRange, RequestValue, SceneError};
use crate::shader::ModuleId;
use crate::time::Instant;
use serde::Deserialize;
use serde_json::{Map, Value, json};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    view: CameraFile,
    /// Default: J2000.
    time: Option<String>,
    /// Default: [`SIZE`].
    size: Option<[u32; 2]>,
    effects: Option<String>,
    x: u32,
    y: u32,
}

/// The sampling of the command line's standard quality, so that the numbers match the image that the command line draws.
const SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 8 };
/// Default width and height of the image.
const SIZE: [u32; 2] = [1024, 1024];

// The fields that describe a view; the query `project` has them, too.
pub(super) const VIEW: QueryField = required("view", "a camera file's object, as --camera-json takes it");
pub(super) const TIME: QueryField = optional("time", "ISO 8601 UTC or jd_tdb:DAY", "J2000");
pub(super) const IMAGE_SIZE: QueryField = optional("size", "[width, height] in pixels", "[1024, 1024]");

pub(super) static KIND: QueryKind = QueryKind {
    name: "pixel",
    description: "what one pixel of a view shows: linear radiance, body, latitude and longitude, key, and every value bound to a name in its WGSL",
    fields: &[
        VIEW,
        TIME,
        IMAGE_SIZE,
        optional("effects", "as --effects takes them", "as the scene needs"),
        required("x", "pixels from the left, from 0"),
        required("y", "pixels from the top, from 0"),
    ],
    example: r#"{"q":"pixel","view":{"position":{"body":"mars","radii":[0,-3,1]},"look":{"at":"mars"}},"time":"2024-04-08T18:17:16Z","size":[64,64],"x":32,"y":32}"#,
    answer,
};

fn answer(prober: &Prober<'_>, query: Value) -> Result<Value, ProbeError> {
    if !query["view"].is_object() {
        return Err("field `view` is not an object: give a camera file's, as {\"position\": {…}, \"look\": {…}}".into());
    }
    let query: Fields = parse_fields(query)?;
    let mut request = view_request(prober, &query.view, query.time.as_deref(), query.size)?;
    let (width, height) = (request.width, request.height);
    if query.x >= width || query.y >= height {
        return Err(format!("fields \"x\" {} and \"y\" {}: the image has {width}x{height} pixels, counted from 0", query.x, query.y).into());
    }
    if let Some(effects) = &query.effects {
        request.effects = EffectOverrides::parse(effects).map_err(|e| format!("field \"effects\": {e}"))?;
        request.check_bodies(prober.catalog())?;
    }
    let report = inspect_pixel(prober, &request, SAMPLING, [query.x, query.y])?;
    let draws: Vec<Value> = report.draws.iter().map(draw_json).collect();
    let main_draw = report.globe_or_nearest().map_or(Value::Null, draw_json);
    let mut answer = Map::new();
    for field in ["body", "part", "lat", "lon", "key"] {
        answer.insert(field.into(), main_draw[field].clone());
    }
    answer.insert("radiance".into(), json!(report.radiance.map(f64::from)));
    answer.insert("exposure_stops".into(), json!(report.exposure_stops));
    answer.insert("time".into(), json!(report.time.to_utc_iso()));
    answer.insert("draws".into(), draws.into());
    Ok(Value::Object(answer))
}

/// The view request, in linear light, for a query's camera file, time and size.
pub(super) fn view_request(
    prober: &Prober<'_>,
    view: &CameraFile,
    time: Option<&str>,
    size: Option<[u32; 2]>,
) -> Result<ViewRequest, ProbeError> {
    let time = Instant::parse(time.unwrap_or("jd_tdb:2451545")).map_err(|e| format!("field \"time\": {e}"))?;
    let [width, height] = size.unwrap_or(SIZE);
    let mut request = ViewRequest { target: None, width, height, purpose: Purpose::LINEAR, ..ViewRequest::of(NaifId::EARTH, time) };
    view.resolve(prober.catalog(), &mut request).map_err(|e| view_error(view, &e))?;
    request.check().map_err(|e| view_error(view, &e))?;
    Ok(request)
}

/// The error of a view, which begins with the field of the query that has the invalid value.
fn view_error(view: &CameraFile, error: &SceneError) -> String {
    let in_view = match error {
        SceneError::CameraField { field, why } => return format!("field `view.{field}`: {why}"),
        SceneError::OutOfRange(OutOfRange { what: RequestValue::Size, .. }) => return format!("field `size`: {error}"),
        SceneError::OutOfRange(OutOfRange { what, .. }) => view.field_of(*what),
        _ => None,
    };
    match in_view {
        Some(field) => format!("field `view.{field}`: {error}"),
        None => format!("field `view`: {error}"),
    }
}

/// The light of one pixel of an image, and the values from which its draws compute it, in the precision of the [`Prober`]'s renderer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PixelReport {
    /// The linear pixel, all draws together.
    pub radiance: [f32; 3],
    /// Exposure of the view.
    pub exposure_stops: f64,
    /// Time of the view.
    pub time: Instant,
    /// Draws that cover the pixel's centre, nearest first.
    pub draws: Vec<PixelDraw>,
}

/// One draw at the pixel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PixelDraw {
    /// The body that is drawn.
    pub body: NaifId,
    /// The body's name.
    pub body_name: String,
    /// The part of the body: globe, air, clouds, or a half of the ring.
    pub part: BodyPart,
    /// The shader module that draws it.
    pub module: ModuleId,
    /// Planetographic latitude and planetocentric east longitude of the point on the surface, degrees; `None` if the draw is no globe.
    pub ground_deg: Option<[f64; 2]>,
    /// The colour and the named values that the module computes.
    pub values: PixelValues,
}

impl PixelReport {
    /// The nearest globe, or the nearest draw if there is no globe.
    pub(crate) fn globe_or_nearest(&self) -> Option<&PixelDraw> {
        self.draws.iter().find(|d| d.part == BodyPart::Globe).or(self.draws.first())
    }
}

/// Evaluates one pixel of a view.
///
/// # Errors
/// The error is one line: an impossible view or plan, or a pixel outside the image.
pub(crate) fn inspect_pixel(
    prober: &Prober<'_>,
    request: &ViewRequest,
    sampling: SamplingQuality,
    [x, y]: [u32; 2],
) -> Result<PixelReport, ProbeError> {
    if !request.composition.is_plain() {
        return Err("a pixel's values are those of one perspective image: choose the perspective projection, without stereo".into());
    }
    let size = [request.width, request.height];
    // Each draw is evaluated by itself, without the images of earlier passes.
    let (scene, plan) = prober.session.plan(&ViewRequest { may_use_coarse_air: false, ..request.clone() }, sampling)?;
    let radiance = linear_pixel(prober, &plan, x, y)?;
    let all_draws = plan.hdr_pass().map(|p| p.draws.as_slice()).unwrap_or_default();
    // The plan keeps the order of the scene's draws.
    let plan_draws: Vec<_> = all_draws.iter().filter(|d| matches!(d.module, ModuleId::Keyed(_))).collect();
    let mut draws = Vec::new();
    // Bodies are drawn from far to near, so that the nearest draw is the last.
    for (plan_draw, scene_draw) in plan_draws.into_iter().zip(&scene.draws).rev() {
        let found = prober.renderer.pixel_values(plan_draw, prober.library(), size, [x, y])?;
        // A draw with alpha 0 does not count as covering the pixel.
        draws.extend(found.filter(|v| v.colour[3] != 0.0).map(|values| PixelDraw {
            body: scene_draw.body,
            body_name: prober.catalog().body(scene_draw.body).map_or_else(|| scene_draw.name.clone(), |b| b.name.clone()),
            part: scene_draw.part,
            module: plan_draw.module.clone(),
            ground_deg: ground_deg(prober, scene_draw, &values),
            values,
        }));
    }
    Ok(PixelReport { radiance, exposure_stops: scene.exposure.stops, time: scene.time, draws })
}

/// Planetographic latitude and planetocentric east longitude of the point on the surface at a globe's pixel, degrees.
fn ground_deg(prober: &Prober<'_>, scene_draw: &Draw, values: &PixelValues) -> Option<[f64; 2]> {
    let position = values.named.iter().find(|v| v.name == "hit.position" && v.numbers.iter().all(|n| n.is_finite()))?;
    let (&[x, y, z], BodyPart::Globe) = (&position.numbers[..], scene_draw.part) else { return None };
    let radii_km = prober.catalog().body(scene_draw.body)?.radii_km;
    // The point on the unit sphere divided by the semi-axes is the direction of the surface normal.
    Some(place_of_normal_deg(radii_km, glam::DVec3::new(x, y, z) / radii_km))
}

/// The image's linear pixel: all draws, restricted to this pixel.
fn linear_pixel(prober: &Prober<'_>, plan: &Plan, x: u32, y: u32) -> Result<[f32; 3], ProbeError> {
    let mut pass = plan.hdr_pass().cloned().ok_or("the plan has no HDR pass")?;
    for draw in &mut pass.draws {
        let [x0, y0, x1, y1] = draw.scissor;
        draw.scissor = [x0.max(x), y0.max(y), x1.min(x + 1), y1.min(y + 1)];
    }
    pass.draws.retain(|d| d.scissor[0] < d.scissor[2] && d.scissor[1] < d.scissor[3]);
    let index = (y * pass.width + x) as usize;
    let (frame, _) = prober.renderer.render(&Plan { passes: vec![pass] }, prober.library(), FrameImages::DisplayAndHdr)?;
    frame.hdr.get(index).map(|p| [p[0], p[1], p[2]]).ok_or_else(|| "the image has no such pixel".into())
}

/// A JSON number. Values that the pixel's module has not computed are NaN, which JSON cannot express; they become null.
fn number(v: f64) -> Value {
    serde_json::Number::from_f64(v).map_or(Value::Null, Value::Number)
}

fn draw_json(draw: &PixelDraw) -> Value {
    let named = |v: &NamedValue| match v.numbers[..] {
        [single] => number(single),
        ref all => all.iter().copied().map(number).collect(),
    };
    let values: Map<String, Value> = draw.values.named.iter().map(|v| (v.name.clone(), named(v))).collect();
    let [lat, lon] = draw.ground_deg.map_or([Value::Null, Value::Null], |degrees| degrees.map(number));
    json!({
        "body": draw.body_name, "part": draw.part.name(), "lat": lat, "lon": lon, "key": draw.module.to_string(),
        "colour": draw.values.colour.map(number), "values": values,
    })
}
