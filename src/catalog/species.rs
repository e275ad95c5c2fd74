//! A species of an atmosphere: a gas, an aerosol or an absorption layer.
//!
//! Plain values, filled by the reader of catalog files.

/// A gas or aerosol with an exponential profile, or a triangular one if `tent_centre_km` is set.
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    /// Name of the gas or aerosol.
    pub name: String,
    /// Scale height of an exponential profile; half width of a triangular one.
    pub scale_height_km: f64,
    /// Height of the peak of a triangular profile; `None` for an exponential one.
    pub tent_centre_km: Option<f64>,
    /// Scattering coefficient, linear sRGB channel means, per kilometre, at the reference level.
    pub scattering_per_km: [f64; 3],
    /// Absorption coefficient, in the same units, at the same level.
    pub absorption_per_km: [f64; 3],
    /// Angular distribution of the scattered light.
    pub phase: PhaseFunction,
    /// Estimated error of scattering and absorption, if they were not taken from a published table.
    pub estimate_percent: Option<f64>,
}

/// The phase function of a species; `scene::atmosphere::phase` computes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseFunction {
    /// That of gas, without parameters.
    Rayleigh,
    /// That of aerosols.
    Aerosol(AerosolPhase),
}

/// The parameters of the aerosols' phase function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AerosolPhase {
    /// Henyey-Greenstein asymmetry: the mean cosine of the scattering angle, between -1 and 1.
    pub asymmetry: f64,
}

impl AerosolPhase {
    /// The parameters in the order of the uniform `air_mie_phase`, which `aerosol_phase` of shaders/lib/air/phase.wesl reads; 0 where there is none.
    pub fn parameters(self) -> [f64; 4] {
        // Without `..`, so that the compiler demands each field here.
        let Self { asymmetry } = self;
        [asymmetry, 0.0, 0.0, 0.0]
    }
}

impl Species {
    /// Whether it is a gas: Rayleigh's phase function and an exponential profile.
    pub fn is_gas(&self) -> bool {
        self.phase == PhaseFunction::Rayleigh && self.tent_centre_km.is_none()
    }

    /// The phase function's parameters, if it is an aerosol: its profile is exponential.
    pub fn aerosol_phase(&self) -> Option<AerosolPhase> {
        match self.phase {
            PhaseFunction::Aerosol(phase) if self.tent_centre_km.is_none() => Some(phase),
            _ => None,
        }
    }
}
