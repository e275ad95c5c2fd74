//! `pixel`: what one pixel of a view shows and how its module came to it.
//!
//! `view` is a camera file (`--camera-json`); beside it stand `time`, `size` ([1024, 1024]) and `effects` as on the command line, and `x`,
//! `y` from the picture's upper left corner. `radiance` is the linear pixel of the picture that `orrery render` writes, `draws` are those that
//! shade the pixel's middle, nearest first, each with every named value of its module.

use super::{Prober, fields};
use crate::render::plan::{Fineness, ModuleName, Plan, PlanDraw};
use crate::render::software::{NamedValue, PixelValues};
use crate::scene::Scene;
use crate::scene::draw::{Draw, Part};
use crate::scene::effects::EffectOverrides;
use crate::scene::request::{CameraFile, ViewRequest};
use crate::time::Instant;
use serde::Deserialize;
use serde_json::{Map, Value, json};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    view: CameraFile,
    /// J2000 where it is not given.
    time: Option<String>,
    size: Option<[u32; 2]>,
    effects: Option<String>,
    x: u32,
    y: u32,
}

/// The standard quality of the command line, so that the numbers are those of its picture.
const FINENESS: Fineness = Fineness { samples: 4, anisotropy: 8 };
const SIZE: [u32; 2] = [1024, 1024];

pub(super) fn ask(prober: &Prober<'_>, question: Value) -> Result<Value, String> {
    let f: Fields = fields(question)?;
    let [width, height] = f.size.unwrap_or(SIZE);
    if f.x >= width || f.y >= height {
        return Err(format!("fields \"x\" {} and \"y\" {}: the picture has {width}x{height} pixels, counted from 0", f.x, f.y));
    }
    let time = f.time.as_deref().unwrap_or("jd_tdb:2451545");
    let time = Instant::parse(time).map_err(|e| format!("field \"time\" {time}: {e}"))?;
    let mut request = ViewRequest::of(crate::catalog::NaifId::EARTH, time);
    request.target = None;
    (request.width, request.height) = (width, height);
    f.view.resolve(prober.catalog(), &mut request).map_err(|e| format!("field \"view\": {e}"))?;
    if let Some(effects) = &f.effects {
        request.effects = EffectOverrides::parse(effects).map_err(|e| format!("field \"effects\": {e}"))?;
    }
    request.check().map_err(|e| e.to_string())?;
    let (scene, plan) = prober.session.plan(&request, FINENESS).map_err(|e| e.to_string())?;
    let radiance = picture(prober, &plan, f.x, f.y)?;
    let bodies = plan.passes.first().map(|p| p.draws.as_slice()).unwrap_or_default();
    let mut draws = Vec::new();
    // Nearest last in the plan, points after all bodies.
    for (draw, of_body) in bodies.iter().zip(&scene.draws).rev() {
        let found = prober.renderer.pixel_values(draw, prober.library(), [width, height], [f.x, f.y]).map_err(|e| e.to_string())?;
        draws.extend(found.filter(|v| v.colour[3] != 0.0).map(|v| one(prober, draw, of_body, &v)));
    }
    let first = draws.iter().find(|d| d["part"] == "globe").or(draws.first());
    let of_first = |field: &str| first.map_or(Value::Null, |d| d[field].clone());
    let mut answer = Map::new();
    for field in ["body", "part", "lat", "lon", "key"] {
        answer.insert(field.into(), of_first(field));
    }
    answer.insert("radiance".into(), json!(radiance.map(f64::from)));
    answer.insert("exposure_stops".into(), json!(scene.exposure.stops));
    answer.insert("time".into(), json!(time_of(&scene)));
    answer.insert("draws".into(), draws.into());
    Ok(Value::Object(answer))
}

fn time_of(scene: &Scene) -> String {
    scene.time.to_utc_iso()
}

/// The picture's linear pixel: all draws, this pixel alone.
fn picture(prober: &Prober<'_>, plan: &Plan, x: u32, y: u32) -> Result<[f32; 3], String> {
    let mut pass = plan.passes.first().cloned().ok_or("the plan has no pass")?;
    for draw in &mut pass.draws {
        let [x0, y0, x1, y1] = draw.scissor;
        draw.scissor = [x0.max(x), y0.max(y), x1.min(x + 1), y1.min(y + 1)];
    }
    pass.draws.retain(|d| d.scissor[0] < d.scissor[2] && d.scissor[1] < d.scissor[3]);
    let at = (y * pass.width + x) as usize;
    let (frame, _) = prober.renderer.render(&Plan { passes: vec![pass] }, prober.library(), true).map_err(|e| e.to_string())?;
    frame.hdr.get(at).map(|p| [p[0], p[1], p[2]]).ok_or_else(|| "the picture has no such pixel".into())
}

fn part_name(part: Part) -> &'static str {
    match part {
        Part::RingBehind => "ring-behind",
        Part::Sky => "sky",
        Part::Globe => "globe",
        Part::Ring => "ring",
        Part::Clouds => "clouds",
    }
}

/// NaN has no place in JSON: what the pixel never came to is null.
fn number(v: f64) -> Value {
    serde_json::Number::from_f64(v).map_or(Value::Null, Value::Number)
}

fn one(prober: &Prober<'_>, draw: &PlanDraw, of_body: &Draw, seen: &PixelValues) -> Value {
    let body = prober.catalog().body(of_body.body);
    let named = |v: &NamedValue| match v.numbers[..] {
        [one] => number(one),
        ref all => all.iter().copied().map(number).collect(),
    };
    let values: Map<String, Value> = seen.values.iter().map(|v| (v.name.clone(), named(v))).collect();
    let place = seen.values.iter().find(|v| v.name == "seen.position" && v.numbers.iter().all(|n| n.is_finite()));
    let (mut lat, mut lon) = (Value::Null, Value::Null);
    if let (Some(&[x, y, z]), Some(body)) = (place.map(|v| &v.numbers[..]), body)
        && of_body.part == Part::Globe
    {
        // The unit sphere's point over the semi-axes is the direction of the ground's normal: planetographic latitude.
        let normal = glam::DVec3::new(x, y, z) / body.radii_km;
        lat = number(normal.z.atan2(normal.truncate().length()).to_degrees());
        lon = number((y * body.radii_km.y).atan2(x * body.radii_km.x).to_degrees());
    }
    let key = match &draw.module {
        ModuleName::Planet(key) => key.to_string(),
        other => other.to_string(),
    };
    json!({
        "body": body.map(|b| b.name.as_str()), "part": part_name(of_body.part), "lat": lat, "lon": lon, "key": key,
        "colour": seen.colour.map(number), "values": values,
    })
}
