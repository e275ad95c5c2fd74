//! Names of modules: a body's module is named by its key, a simple shader by the name of its entry fragment, a probe module by the name of its entry fragment
//! and a key.
//!
//! In: text. Out: [`ModuleId`]; the lists of simple shaders and of probes. Always: each simple shader and each probe has an entry
//! fragment `entry/<name>.wesl`. Not here: the content of a module.

use super::key::{KeyTextError, ShaderKey};
use std::fmt;
use std::str::FromStr;

/// The name of a module: a body's key, a simple shader, or a probe.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ModuleId {
    /// The module of a draw with a shader key: a planet, moon, the Sun, a ring, clouds, or the sky.
    Keyed(ShaderKey),
    /// One of [`SIMPLE_MODULES`].
    Simple(&'static str),
    /// One of [`PROBES`], and the key that provides its features.
    Probe(&'static str, ShaderKey),
}

impl fmt::Display for ModuleId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Keyed(key) => key.fmt(f),
            Self::Simple(name) => f.pad(name),
            Self::Probe(name, key) => f.pad(&format!("{name}.{key}")),
        }
    }
}

impl FromStr for ModuleId {
    type Err = KeyTextError;
    /// Parses a simple shader's name, a key's text, or a probe's present or former name and a key's text joined by `.`; upper and lower case are the same.
    fn from_str(text: &str) -> Result<Self, KeyTextError> {
        let probe = text.split_once('.').and_then(|(first, key)| {
            let name = FORMER_PROBES.iter().find(|(former, _)| former.eq_ignore_ascii_case(first)).map_or(first, |(_, name)| *name);
            PROBES.iter().find(|p| p.eq_ignore_ascii_case(name)).map(|p| (p, key))
        });
        if let Some((name, key)) = probe {
            return key.parse().map(|key| Self::Probe(name, key));
        }
        match SIMPLE_MODULES.iter().find(|name| name.eq_ignore_ascii_case(text)) {
            Some(name) => Ok(Self::Simple(name)),
            None => text.parse().map(Self::Keyed).map_err(|e| e.suggest_module_name(&SIMPLE_MODULES)),
        }
    }
}

/// Simple shaders: modules without a key, with the entry fragment `entry/<name>.wesl`.
pub const SIMPLE_MODULES: [&str; 25] = [
    "anaglyph",
    "blur",
    "coarse_air",
    "comet_tail",
    "corona",
    "dot",
    "equirectangular",
    "fisheye",
    "glow",
    "interface",
    "interlace",
    "label",
    "line",
    "minor_planets",
    "orbit",
    "outline",
    "point",
    "refracted_limb",
    "shrink",
    "side_by_side",
    "sky_background",
    "sky_image",
    "tone_map",
    "tone_map_bloom",
    "warp",
];

/// Probes: modules that evaluate one formula for given inputs, from the entry fragment `entry/<name>.wesl` with the features of a key.
pub const PROBES: [&str; 5] = ["probe_body_shadow", "probe_disc_overlap", "probe_ring_transmission", "probe_scatter", "probe_sunlight"];

/// Pairs of a probe's former name, which is still read, and its present name.
const FORMER_PROBES: [(&str, &str); 1] = [("probe_ring_shadow", "probe_body_shadow")];

/// The probe modules that are recorded (`shader::record`) and tested: each probe, with keys of some of the models that it evaluates.
pub fn probe_samples() -> Vec<ModuleId> {
    let modules = |name: &'static str, keys: &[&str]| {
        keys.iter().map(|text| text.parse().expect("a shader key")).map(|key| ModuleId::Probe(name, key)).collect::<Vec<_>>()
    };
    let overlap_keys = ["linear", "uniform-disc", "limb-darkened"].map(|m| format!("lambert.sun1.eclipse1-{m}.sphere"));
    let mut all = modules("probe_disc_overlap", &overlap_keys.each_ref().map(String::as_str));
    all.extend(modules("probe_sunlight", &["lambert.sun1.eclipse1-limb-darkened.sphere", "lambert.sun1.eclipse4-refracted.sphere"]));
    all.extend(modules("probe_body_shadow", &["ring.sun1.bodyshadow-sphere.sphere", "ring.sun1.bodyshadow-ellipsoid-penumbra.sphere"]));
    all.extend(modules(
        "probe_ring_transmission",
        &["lambert.sun1.ringshadow-point-sun.sphere", "lambert.sun1.ringshadow-penumbra.sphere"],
    ));
    let air_parts = ["air-pixel-8", "air-pixel-16-mie", "air-pixel-32-mie-absorption", "air-pixel-16-absorption"];
    let scatter_keys = air_parts.map(|air| format!("sky.sun1.{air}.sphere"));
    all.extend(modules("probe_scatter", &scatter_keys.each_ref().map(String::as_str)));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_former_name_of_a_probe_is_read_as_its_present_one() {
        for former in ["probe_ring_shadow", "Probe_Ring_Shadow"] {
            let id = format!("{former}.ring.sun1.bodyshadow-sphere.sphere").parse::<ModuleId>().expect("a probe");
            assert_eq!(Ok(&id), "probe_body_shadow.ring.sun1.bodyshadow-sphere.sphere".parse::<ModuleId>().as_ref());
            assert!(id.to_string().starts_with("probe_body_shadow."), "{id}");
        }
        for (_, name) in FORMER_PROBES {
            assert!(PROBES.contains(&name), "{name}");
        }
        assert!("probe_ring.ring.sun1.sphere".parse::<ModuleId>().is_err());
    }
}
