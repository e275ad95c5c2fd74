//! A species of an atmosphere: a gas, an aerosol or an absorption layer.
//!
//! Plain values: `catalog::read` fills them from catalog files and checks their ranges. Not here: densities and phase functions (`scene::atmosphere`).
//! docs/phase-function.md lists the edits for another phase function of aerosols.

/// A gas or aerosol, whose density is exponential in height, or an absorption layer, whose density is triangular: `tent_centre_km` is set. An
/// atmosphere has at most one of each.
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    /// The species' name, shown with its estimated error.
    pub name: String,
    /// Scale height of an exponential profile; of a triangular one, the distance from its peak to either end.
    pub scale_height_km: f64,
    /// Height of the peak of a triangular (tent-shaped) profile; `None` for an exponential one.
    pub tent_centre_km: Option<f64>,
    /// Scattering coefficient per kilometre, averaged over each linear sRGB channel. It applies at height 0, on the ellipsoid; for a triangular profile, at
    /// the peak. In draws, a triangular profile only removes light: the light that it scatters is not added to view rays.
    pub scattering_per_km: [f64; 3],
    /// Absorption coefficient, in the same unit and at the same height.
    pub absorption_per_km: [f64; 3],
    /// Angular distribution of the scattered light; Rayleigh if the catalog gives no asymmetry, as for an absorption layer.
    pub phase: PhaseFunction,
    /// Estimated error of scattering and absorption, if they were not taken from a published table.
    pub estimate_percent: Option<f64>,
}

/// The kind of phase function of a species; `scene::atmosphere::phase` computes its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseFunction {
    /// The Rayleigh phase function of a gas, without parameters.
    Rayleigh,
    /// The phase function of an aerosol.
    Aerosol(AerosolPhase),
}

/// A number for all channels, or one for each (red, green, blue), as catalogs and queries write it.
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(untagged)]
pub(crate) enum PerChannel {
    Grey(f64),
    Rgb([f64; 3]),
}

/// The parameters of the aerosols' phase function. Shaders evaluate it only once per view ray, so that a parameter may choose the function: it costs little,
/// and needs no variant of each shader module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AerosolPhase {
    /// The parameter g in each linear sRGB channel, between -1 and 1: of Henyey-Greenstein's function, the mean cosine of the scattering angle.
    pub asymmetry: [f64; 3],
}

/// A field of [`AerosolPhase`], as catalogs and the query `scatter` give it. A field that they leave out is 0.
#[derive(Clone, Copy)]
pub struct AerosolField {
    /// Its key in catalogs.
    pub catalog_key: &'static str,
    /// Its key in the query `scatter`.
    pub query_key: &'static str,
    /// The least and the greatest value.
    pub limits: [f64; 2],
    /// Whether the limits themselves are allowed.
    pub includes_limits: bool,
    /// Its numbers: three, one per channel, or a single one for all channels.
    pub numbers: fn(&mut AerosolPhase) -> &mut [f64],
}

impl AerosolField {
    /// The allowed values in words.
    pub fn allowed(&self) -> String {
        let [least, greatest] = self.limits;
        let range = if self.includes_limits { format!("from {least} to {greatest}") } else { format!("between {least} and {greatest}") };
        let mut any = AerosolPhase::ISOTROPIC;
        let is_per_channel = (self.numbers)(&mut any).len() == 3;
        format!("a number {range}{}", if is_per_channel { ", or three (red, green, blue)" } else { "" })
    }

    fn is_allowed(&self, number: f64) -> bool {
        let [least, greatest] = self.limits;
        (least..=greatest).contains(&number) && (self.includes_limits || !self.limits.contains(&number))
    }

    /// The phase function with this value of the field; `None` if the field may not have it.
    pub(crate) fn set(&self, mut aerosol: AerosolPhase, value: PerChannel) -> Option<AerosolPhase> {
        let numbers = (self.numbers)(&mut aerosol);
        match value {
            PerChannel::Grey(number) => numbers.fill(number),
            PerChannel::Rgb(channels) if numbers.len() == channels.len() => numbers.copy_from_slice(&channels),
            PerChannel::Rgb(_) => return None,
        }
        let is_allowed = numbers.iter().all(|number| self.is_allowed(*number));
        is_allowed.then_some(aerosol)
    }
}

impl AerosolPhase {
    /// All fields, in the order of [`AerosolPhase::parameters`]. Catalogs, the query `scatter` and tests loop over this list. The presence of the first makes a
    /// species of a catalog an aerosol.
    pub const FIELDS: &[AerosolField] = &[AerosolField {
        catalog_key: "asymmetry",
        query_key: "g",
        limits: [-1.0, 1.0],
        includes_limits: false,
        numbers: |aerosol| &mut aerosol.asymmetry,
    }];

    /// Each field is 0.
    pub const ISOTROPIC: Self = Self::henyey_greenstein([0.0; 3]);

    /// The functions with which tests compare all implementations.
    #[doc(hidden)]
    pub const SAMPLES: [Self; 2] = [Self::henyey_greenstein([-0.3, 0.0, 0.76]), Self::henyey_greenstein([0.95, 0.5, -0.3])];

    /// Henyey-Greenstein's function.
    pub const fn henyey_greenstein(asymmetry: [f64; 3]) -> Self {
        Self { asymmetry }
    }

    /// The four components of the uniform `air_mie_phase`, which `aerosol_phase` of shaders/lib/air/phase.wesl reads. A component without a parameter is 0.
    pub fn parameters(self) -> [f64; 4] {
        // Destructured without `..`, so that a new field is a compile error here.
        let Self { asymmetry } = self;
        let [red, green, blue] = asymmetry;
        [red, green, blue, 0.0]
    }

    /// The mean cosine of the scattering angle, per channel. A test in `scene::atmosphere::phase` compares it with an integral over the phase function.
    pub(crate) fn mean_cosine(self) -> [f64; 3] {
        // Destructured without `..`, as in `parameters`.
        let Self { asymmetry } = self;
        asymmetry
    }
}

impl Species {
    /// Whether it is a gas: it has the Rayleigh phase function and an exponential profile.
    pub fn is_gas(&self) -> bool {
        self.phase == PhaseFunction::Rayleigh && self.tent_centre_km.is_none()
    }

    /// The parameters of the phase function, if it is an aerosol with an exponential profile.
    pub fn aerosol_phase(&self) -> Option<AerosolPhase> {
        match self.phase {
            PhaseFunction::Aerosol(phase) if self.tent_centre_km.is_none() => Some(phase),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of the listed fields are those of the uniform, which the compiler keeps complete. So no field is missing in the list.
    #[test]
    fn every_field_is_listed() {
        for mut aerosol in AerosolPhase::SAMPLES {
            let uniform = aerosol.parameters();
            let listed: Vec<f64> = AerosolPhase::FIELDS.iter().flat_map(|field| (field.numbers)(&mut aerosol).to_vec()).collect();
            let (used, unused) = uniform.split_at(listed.len());
            assert_eq!(listed, used, "{aerosol:?}");
            assert!(unused.iter().all(|number| *number == 0.0), "{uniform:?} has numbers that are in no field of the list");
        }
    }
}
