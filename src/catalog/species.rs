//! A species of an atmosphere: a gas, an aerosol or an absorption layer.
//!
//! Plain values: `catalog::read` fills them from catalog files and checks their ranges. Not here: densities and phase functions (`scene::atmosphere`).
//! docs/phase-function.md lists the edits for another phase function of aerosols.

/// A gas or an aerosol, whose density is exponential in height, or an absorption layer, whose density is triangular (`tent_centre_km` is set). An
/// atmosphere has at most one gas, one aerosol and one absorption layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    /// The species' name, shown with its estimated error.
    pub name: String,
    /// Scale height of an exponential profile; of a triangular one, the distance from its peak to either end.
    pub scale_height_km: f64,
    /// Height of the peak of a triangular (tent-shaped) profile; `None` for an exponential one.
    pub tent_centre_km: Option<f64>,
    /// Scattering coefficient per kilometre, averaged over each linear sRGB channel. It applies at height 0, on the ellipsoid; for a triangular profile, at
    /// the peak. Draws treat light that a triangular profile scatters as absorbed.
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

/// A phase function of aerosols, whose values `scene::atmosphere::phase` computes. For a new function, add a variant, and the match arms that the compiler
/// then reports as missing. The words of the existing variants must keep their meaning, because catalogs and queries of others contain them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AerosolFunction {
    /// Henyey and Greenstein 1941, Astrophysical Journal 93, 70.
    HenyeyGreenstein,
}

impl AerosolFunction {
    /// The function of an aerosol of a catalog that names none.
    pub const OF_CATALOGS: Self = Self::HenyeyGreenstein;
    /// All functions.
    pub const ALL: [Self; 1] = [Self::HenyeyGreenstein];

    /// Its word, as `phase` of a species in catalogs and in the query `scatter`.
    pub const fn query_word(self) -> &'static str {
        match self {
            Self::HenyeyGreenstein => "hg",
        }
    }

    /// The function that has this word.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|function| function.query_word() == word)
    }

    /// The words of these functions, in quotes, for messages.
    pub fn words(functions: &[Self]) -> String {
        functions.iter().map(|function| format!("\"{}\"", function.query_word())).collect::<Vec<_>>().join(" or ")
    }
}

/// The phase function of an aerosol, with its parameters. Shaders evaluate it only once per view ray, so choosing the function by a parameter costs little; no
/// shader module needs a variant for each function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AerosolPhase {
    /// The function that has these parameters.
    pub function: AerosolFunction,
    /// The parameter g in each linear sRGB channel, between -1 and 1: of Henyey-Greenstein's function, the mean cosine of the scattering angle.
    pub asymmetry: [f64; 3],
}

/// A numeric field of [`AerosolPhase`], as catalogs and the query `scatter` give it. If they leave it out, it has its default, that of [`AerosolPhase::of`].
#[derive(Clone, Copy)]
pub struct AerosolField {
    /// Its key in catalogs.
    pub catalog_key: &'static str,
    /// Its key in the query `scatter`.
    pub query_key: &'static str,
    /// The functions that have it. Beside another one the keys are errors.
    pub functions: &'static [AerosolFunction],
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
        let mut any = AerosolPhase::with_asymmetry([0.0; 3]);
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
    /// All numeric fields. Catalogs, the query `scatter`, names of stored tables and tests loop over this list. A species of a catalog has an aerosol's phase
    /// function if it has the catalog key of the first field.
    pub const FIELDS: &[AerosolField] = &[AerosolField {
        catalog_key: "asymmetry",
        query_key: "g",
        functions: &AerosolFunction::ALL,
        limits: [-1.0, 1.0],
        includes_limits: false,
        numbers: |aerosol| &mut aerosol.asymmetry,
    }];

    /// A function with the default of all numeric fields: 0.
    pub const fn of(function: AerosolFunction) -> Self {
        Self { function, asymmetry: [0.0; 3] }
    }

    /// The function of catalogs with this asymmetry.
    pub const fn with_asymmetry(asymmetry: [f64; 3]) -> Self {
        Self { asymmetry, ..Self::of(AerosolFunction::OF_CATALOGS) }
    }

    /// Samples of each function, with which tests compare all implementations: two asymmetries, and its other numbers a quarter above their least values.
    #[doc(hidden)]
    pub fn samples() -> Vec<Self> {
        let samples_of = |function| {
            let mut sample = Self::of(function);
            for field in Self::FIELDS.iter().filter(|field| field.functions.contains(&function)) {
                let [least, greatest] = field.limits;
                (field.numbers)(&mut sample).fill(0.75 * least + 0.25 * greatest);
            }
            [[-0.3, 0.0, 0.76], [0.95, 0.5, -0.3]].map(|asymmetry| Self { asymmetry, ..sample })
        };
        AerosolFunction::ALL.into_iter().flat_map(samples_of).collect()
    }

    /// The four components of the uniform `air_mie_phase_parameters`, which `aerosol_phase` of shaders/lib/air/phase.wesl reads: the asymmetry, then w, which
    /// identifies the function or is a number of it.
    pub fn parameters(self) -> [f64; 4] {
        // Destructured without `..`, so that a new field is a compile error here.
        let Self { function, asymmetry: [red, green, blue] } = self;
        let w = match function {
            AerosolFunction::HenyeyGreenstein => 0.0,
        };
        [red, green, blue, w]
    }

    /// A number of the function, then those of all fields.
    fn numbers(mut self) -> Vec<f64> {
        let function = f64::from(self.function as u8);
        let of_fields = Self::FIELDS.iter().flat_map(|field| (field.numbers)(&mut self).to_vec());
        [function].into_iter().chain(of_fields).collect()
    }
}

impl Species {
    /// Whether it is a gas: it has the Rayleigh phase function and an exponential profile.
    pub fn is_gas(&self) -> bool {
        self.phase == PhaseFunction::Rayleigh && self.tent_centre_km.is_none()
    }

    /// The phase function of an aerosol; `None` for a gas, and for an absorption layer even if the catalog gives it an asymmetry.
    pub fn aerosol_phase(&self) -> Option<AerosolPhase> {
        match self.phase {
            PhaseFunction::Aerosol(phase) if self.tent_centre_km.is_none() => Some(phase),
            _ => None,
        }
    }

    /// All numbers of this species that influence the light of the air, for keys of caches and names of stored tables.
    pub(crate) fn optical_numbers(&self) -> impl Iterator<Item = f64> {
        // A pattern without `..`, so that the compiler demands a decision about each new field.
        let Self { name: _, scale_height_km, tent_centre_km, scattering_per_km, absorption_per_km, phase, estimate_percent: _ } = *self;
        // A missing `tent_centre_km` (the species has no triangular profile) and the Rayleigh phase function are represented by a number that neither a height
        // nor a function has.
        let profile = [scale_height_km, tent_centre_km.unwrap_or(-1.0)];
        let phase = match phase {
            PhaseFunction::Rayleigh => vec![-1.0],
            PhaseFunction::Aerosol(aerosol) => aerosol.numbers(),
        };
        scattering_per_km.into_iter().chain(absorption_per_km).chain(profile).chain(phase)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All fields of the struct but the function are numbers. Each of them must be in the list, from which catalogs, samples and names of tables take them.
    #[test]
    fn every_number_is_in_the_list() {
        let mut aerosol = AerosolPhase::with_asymmetry([0.0; 3]);
        let listed: usize = AerosolPhase::FIELDS.iter().map(|field| (field.numbers)(&mut aerosol).len()).sum();
        let bytes_of_function = size_of::<AerosolFunction>().next_multiple_of(align_of::<f64>());
        assert_eq!(size_of::<AerosolPhase>(), bytes_of_function + listed * size_of::<f64>(), "AerosolPhase::FIELDS lacks a number");
    }

    #[test]
    fn each_function_has_its_own_word() {
        assert!(AerosolFunction::ALL.contains(&AerosolFunction::OF_CATALOGS));
        for (k, function) in AerosolFunction::ALL.into_iter().enumerate() {
            assert!(AerosolFunction::ALL.into_iter().take(k).all(|other| other.query_word() != function.query_word()), "{function:?}");
        }
    }
}
