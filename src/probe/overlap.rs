//! `disc-overlap`: the part of the Sun's light that a disc takes.

use super::lanes::{Lanes, Numbers};
use super::{Prober, fields};
use crate::scene::draw::{Eclipse, EclipseModel, Needs};
use crate::shader::ModuleId;
use crate::shader::key::ShaderKey;
use serde::Deserialize;
use serde_json::{Value, json};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    /// Caster's radius and distance of the centres, solar radii.
    k: f64,
    d: f64,
    #[serde(default)]
    u1: f64,
    #[serde(default)]
    u2: f64,
    model: Model,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Model {
    Linear,
}

pub(super) fn ask(prober: &Prober<'_>, question: Value) -> Result<Value, String> {
    let f: Fields = fields(question)?;
    if !(f.k >= 0.0 && f.d >= 0.0) {
        return Err("fields \"k\" and \"d\" are lengths: 0 or more".into());
    }
    let model = match f.model {
        Model::Linear => EclipseModel::Linear,
    };
    let key = ShaderKey::for_draw(&Needs { lights: 1, eclipse: Eclipse { casters: 1, model }, ..Needs::LEAST });
    let mut numbers: Numbers = [0.0; 12];
    numbers[..4].copy_from_slice(&[f.k, f.d, f.u1, f.u2]);
    let lanes = Lanes::plain(ModuleId::Probe("probe_disc_overlap", key), 1);
    let answers = lanes.answers(prober.renderer, prober.library(), &[numbers])?;
    let blocked = answers.first().and_then(|rows| rows.first()).map(|row| row[0]).ok_or("no answer")?;
    Ok(json!({ "blocked": blocked }))
}
