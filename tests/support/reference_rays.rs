//! The rays of tests/data/rayleigh_reference_public.json, with the radiance that they have with the tests' own phase functions.
//!
//! The table has radiances with the phase functions that its field `method` names; rayleigh_integrals.json beside it has what is left without them: radiance is
//! the sum over the species of integral times phase function. So a change of a phase function needs no change of either file.

use super::photons::per_steradian;
use glam::DVec3;
use orrery::catalog::{AerosolFunction, AerosolPhase, PhaseFunction};
use serde_json::Value;
use std::sync::LazyLock;

pub static TABLE: LazyLock<Value> =
    LazyLock::new(|| serde_json::from_str(include_str!("../data/rayleigh_reference_public.json")).expect("JSON"));

pub struct ReferenceRay {
    /// Its row of the table.
    pub row: &'static Value,
    /// The species of its atmosphere, each with its integral.
    species: Vec<(&'static Value, DVec3)>,
}

pub fn vector(v: &Value) -> DVec3 {
    let component = |k: usize| v[k].as_f64().expect("a number");
    DVec3::new(component(0), component(1), component(2))
}

/// The phase function of a species of a probe question, such as those of the table. An absent field has the value of [`AerosolPhase::of`].
pub fn read_phase(species: &Value) -> PhaseFunction {
    let Some(function) = AerosolFunction::ALL.into_iter().find(|function| species["phase"] == function.query_word()) else {
        return PhaseFunction::Rayleigh;
    };
    let mut aerosol = AerosolPhase::of(function);
    for field in AerosolPhase::FIELDS {
        let numbers = (field.numbers)(&mut aerosol);
        match &species[field.query_key] {
            Value::Null => {}
            list @ Value::Array(_) => numbers.copy_from_slice(&vector(list).to_array()),
            number => numbers.fill(number.as_f64().expect("a number")),
        }
    }
    PhaseFunction::Aerosol(aerosol)
}

/// All rays, in the order of the table.
pub fn rays() -> Vec<ReferenceRay> {
    let integrals: Value = serde_json::from_str(include_str!("../data/rayleigh_integrals.json")).expect("JSON");
    let list = |v: &'static Value| v.as_array().expect("a list");
    let (rows, integrals) = (list(&TABLE["rays"]), integrals["rays"].as_array().expect("a list"));
    assert_eq!(rows.len(), integrals.len());
    let ray = |(row, integrals): (&'static Value, &Value)| {
        let name = row["atm"].as_str().expect("a name");
        let integrals: Vec<DVec3> = integrals.as_array().expect("a list").iter().map(vector).collect();
        let species = list(&TABLE["atmospheres"][name]["species"]);
        assert_eq!(species.len(), integrals.len(), "{row}");
        ReferenceRay { row, species: species.iter().zip(integrals).collect() }
    };
    rows.iter().zip(integrals).map(ray).collect()
}

impl ReferenceRay {
    /// Its radiance with the given phase functions, per steradian: of a species, at a cosine of the scattering angle.
    pub fn radiance_with(&self, per_steradian: impl Fn(&Value, f64) -> DVec3) -> DVec3 {
        let cosine = vector(&self.row["dir"]).normalize().dot(vector(&self.row["sun"]).normalize());
        self.species.iter().map(|&(species, integral)| integral * per_steradian(species, cosine)).sum()
    }

    /// Its radiance with the phase functions of the species, as the tests compute them.
    pub fn radiance(&self) -> DVec3 {
        self.radiance_with(|species, cosine| {
            let phase = read_phase(species);
            DVec3::from_array([0, 1, 2].map(|channel| per_steradian(phase, channel, cosine)))
        })
    }
}
