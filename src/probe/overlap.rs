//! `disc-overlap`: the fraction of the Sun's light that a disc or an ellipse in front of it blocks.
//!
//! In: the outline's semi-axes and the distance of the centres in solar radii, the limb darkening and an eclipse model. Out: `blocked`, 0 to 1.

use super::batch::{PreparedProbe, ProbeInputs};
use super::sunlight::{check_limb_darkening, u1_at_550_nm, u2_at_550_nm};
use super::{ProbeError, Prober, QueryKind, alternative, optional, parse_fields};
use crate::scene::draw::{DrawFeatures, Eclipse, EclipseModel};
use crate::shader::ModuleId;
use crate::shader::key::ShaderKey;
use serde::Deserialize;
use serde_json::{Value, json};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    /// Radius of a disc in front of the Sun, solar radii.
    k: Option<f64>,
    /// Distance of the disc's centre from the Sun's, solar radii.
    d: Option<f64>,
    /// Semi-major axis of an ellipse in front of the Sun, solar radii.
    semi_major: Option<f64>,
    /// Semi-minor axis of the ellipse, solar radii.
    semi_minor: Option<f64>,
    /// Distance of the ellipse's centre from the Sun's, solar radii.
    centre_distance: Option<f64>,
    /// Angle from the ellipse's major axis to the direction of the Sun's centre.
    #[serde(default)]
    offset_angle_from_major_axis_deg: f64,
    /// Limb darkening of the Sun; see [`Self::limb_darkening`].
    u1: Option<f64>,
    u2: Option<f64>,
    #[serde(default)]
    model: Model,
}

/// The eclipse models ([`EclipseModel`]) that need only the occluder's outline.
#[derive(Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Model {
    /// The blocked fraction is a linear function of the distance of the centres, between external and internal contact.
    Linear,
    UniformDisc,
    #[default]
    LimbDarkened,
}

/// Largest semi-axis of an occluder, solar radii. In f32, neighbouring numbers near 1e6 differ by 0.06. Those near 1e8 differ by 8, which is more than the
/// Sun's diameter: the limb of such an occluder would nowhere cross the Sun's disc.
const MAX_SEMI_AXIS: f64 = 1e6;

impl Fields {
    /// Coefficients of limb darkening, the Sun's at 550 nm by default. If only one is given, the other is 0.
    fn limb_darkening(&self) -> (f64, f64) {
        match (self.u1, self.u2) {
            (None, None) => (u1_at_550_nm(), u2_at_550_nm()),
            (u1, u2) => (u1.unwrap_or(0.0), u2.unwrap_or(0.0)),
        }
    }

    /// Semi-axes and distance of the centres; or the reason why any field of the query, not only one of these, is invalid.
    fn checked_outline(&self) -> Result<[f64; 3], String> {
        let missing = |field: &str| format!("missing field `{field}`: give k and d, or semi_major, semi_minor and centre_distance");
        let is_disc = self.k.is_some() || self.d.is_some();
        let is_ellipse = [self.semi_major, self.semi_minor, self.centre_distance].iter().any(Option::is_some);
        if is_disc && is_ellipse {
            return Err("give k and d, or semi_major, semi_minor and centre_distance, not both".into());
        }
        let [major, minor, distance] = match (self.k, self.semi_major) {
            (Some(k), _) => [k, k, self.d.ok_or_else(|| missing("d"))?],
            (None, Some(a)) => {
                let b = self.semi_minor.ok_or_else(|| missing("semi_minor"))?;
                [a, b, self.centre_distance.ok_or_else(|| missing("centre_distance"))?]
            }
            (None, None) => return Err(missing("k")),
        };
        let is_length = |v: f64| v >= 0.0 && v.is_finite();
        if !(is_length(major) && is_length(minor) && is_length(distance)) {
            return Err(match self.k {
                Some(_) => "fields \"k\" and \"d\" are lengths: 0 or more".into(),
                None => "fields \"semi_major\", \"semi_minor\" and \"centre_distance\" are lengths: 0 or more".into(),
            });
        }
        if major > MAX_SEMI_AXIS {
            let field = if self.k.is_some() { "k" } else { "semi_major" };
            return Err(format!("field \"{field}\" is {major:e}: at most {MAX_SEMI_AXIS:e} solar radii"));
        }
        if minor > major {
            return Err(format!("field \"semi_minor\" is {minor}: not above semi_major, {major}"));
        }
        if !self.offset_angle_from_major_axis_deg.is_finite() {
            return Err("field \"offset_angle_from_major_axis_deg\" is not a number".into());
        }
        let (u1, u2) = self.limb_darkening();
        check_limb_darkening(u1, u2)?;
        Ok([major, minor, distance])
    }
}

pub(super) static KIND: QueryKind = QueryKind {
    name: "disc-overlap",
    description: "the fraction of the Sun's light that a disc (k, d) or an ellipse in front of the Sun blocks; lengths in solar radii",
    fields: &[
        alternative("k", "the disc's radius, at most 1e6"),
        alternative("d", "distance of the centres"),
        alternative("semi_major", "the ellipse's semi-axes; at most 1e6"),
        alternative("semi_minor", "at most semi_major"),
        alternative("centre_distance", "distance of the centres"),
        optional("offset_angle_from_major_axis_deg", "from the ellipse's major axis to the Sun's centre", "0"),
        optional("u1", "coefficient of 1 - mu in the Sun's limb darkening", "0.40, the Sun at 550 nm; 0 where u2 is given"),
        optional("u2", "coefficient of (1 - mu)^2", "0.26; 0 where u1 is given"),
        optional("model", "linear, uniform-disc or limb-darkened", "limb-darkened"),
    ],
    example: r#"{"q":"disc-overlap","k":0.9,"d":0.5}"#,
    answer,
};

fn answer(prober: &Prober<'_>, query: Value) -> Result<Value, ProbeError> {
    const RESULT_ROWS: u32 = 1;
    let query: Fields = parse_fields(query)?;
    let [major, minor, distance] = query.checked_outline()?;
    // With the model of a uniform disc, all light has the factor 1 - u1 - u2 (the constant term of limb darkening), which cancels in the fraction. Coefficients
    // with the sum 1 would make the fraction 0 / 0; so both are replaced by 0.
    let (model, (u1, u2)) = match query.model {
        Model::Linear => (EclipseModel::Linear, query.limb_darkening()),
        Model::UniformDisc => (EclipseModel::UniformDisc, (0.0, 0.0)),
        Model::LimbDarkened => (EclipseModel::LimbDarkened, query.limb_darkening()),
    };
    let key = ShaderKey::for_draw(&DrawFeatures { lights: 1, eclipse: Eclipse { occluders: 1, model }, ..DrawFeatures::MINIMAL });
    let (sin, cos) = query.offset_angle_from_major_axis_deg.to_radians().sin_cos();
    // In the order in which shaders/entry/probe_disc_overlap.wesl reads them.
    let mut numbers: ProbeInputs = [0.0; 12];
    numbers[..6].copy_from_slice(&[major, minor, distance * cos, distance * sin, u1, u2]);
    let probe = PreparedProbe::without_bindings(ModuleId::Probe("probe_disc_overlap", key), RESULT_ROWS);
    let results = probe.results(prober.renderer, prober.library(), &[numbers])?;
    let blocked = results.first().and_then(|rows| rows.first()).map(|row| row[0]).ok_or("no answer")?;
    Ok(json!({ "blocked": blocked }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If a query could give both outlines, the fields of one of them would have no effect.
    #[test]
    fn fields_of_both_outlines_are_refused() {
        let outline = |text: &str| serde_json::from_str::<Fields>(text).expect("fields").checked_outline();
        assert_eq!(outline(r#"{"k":0.9,"d":0.5}"#), Ok([0.9, 0.9, 0.5]));
        assert_eq!(outline(r#"{"semi_major":0.9,"semi_minor":0.8,"centre_distance":0.5}"#), Ok([0.9, 0.8, 0.5]));
        for text in [
            r#"{"k":0.9,"d":0.5,"semi_minor":0.1}"#,
            r#"{"k":0.9,"d":0.5,"centre_distance":0.1}"#,
            r#"{"k":0.9,"centre_distance":0.5}"#,
            r#"{"semi_major":0.9,"semi_minor":0.8,"centre_distance":0.5,"d":0.1}"#,
            r#"{"k":0.9,"d":0.5,"semi_major":0.9}"#,
        ] {
            assert!(outline(text).is_err_and(|e| e.contains("not both")), "{text}");
        }
        for text in [r#"{"k":0.9}"#, r#"{"d":0.9}"#, r#"{"semi_minor":0.9}"#, "{}"] {
            assert!(outline(text).is_err_and(|e| e.contains("missing")), "{text}");
        }
    }
}
