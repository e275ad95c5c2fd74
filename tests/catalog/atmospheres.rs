//! Atmospheres in catalog files: the gases of the shipped ones agree with each other, and errors in a user's file are reported by line.

use super::entries::problems;
use orrery::catalog::{AerosolFunction, AerosolPhase, Catalog, NaifId};

/// A species; `kind` is its last lines, from line 7 of the file on if it is the first species.
fn species(name: &str, kind: &str) -> String {
    format!("[[atmosphere.species]]\nname = \"{name}\"\nscale_height_km = 8.0\n{kind}\n")
}

/// The problems of a file with an atmosphere of these species.
fn problems_of_air(species: &[String]) -> Vec<String> {
    problems(&format!("[[atmosphere]]\nbody = \"Mars\"\ntop_km = 80.0\n{}", species.concat()))
}

/// Gases scatter with the inverse fourth power of the wavelength, so the ratios of red and blue to green (linear sRGB) are the same for
/// all, except for the slow change of refractivity and depolarisation with wavelength.
#[test]
fn gases_scatter_with_the_wavelength_dependence_of_rayleigh() {
    let catalog = Catalog::embedded();
    let gas_scattering = |id: NaifId| catalog.body(id).and_then(|b| b.atmosphere.as_ref()).map(|a| &a.species[0].scattering_per_km);
    let earth = gas_scattering(NaifId::EARTH).expect("air");
    let mut checked = 0;
    for b in catalog.bodies().iter().filter(|b| b.id != NaifId::EARTH) {
        let Some(s) = b.atmosphere.as_ref().map(|a| &a.species[0]).filter(|s| s.is_gas()) else { continue };
        let [red, green, blue] = s.scattering_per_km;
        assert!((red / green / (earth[0] / earth[1]) - 1.0).abs() < 0.04, "{}: red {}", b.name, red / green);
        assert!((blue / green / (earth[2] / earth[1]) - 1.0).abs() < 0.04, "{}: blue {}", b.name, blue / green);
        checked += 1;
    }
    assert_eq!(checked, 8);
}

/// The refractivity at height 0 is that of the gas whose scattering is given there: scattering per refractivity is 32 pi³ / (3 N lambda⁴) times the
/// refractivity at 0 C and 1 atm and King's factor, with N the number density at 0 C and 1 atm.
#[test]
fn refractivities_belong_to_the_gas_that_scatters() {
    // Of each gas: refractivity in green at 0 C and 1 atm, King's factor.
    let [air, carbon_dioxide, nitrogen, hydrogen, helium]: [[f64; 2]; 5] =
        [[2.93e-4, 1.05], [4.49e-4, 1.15], [2.98e-4, 1.034], [1.39e-4, 1.03], [3.49e-5, 1.0]];
    // Mole fraction of a gas, and its two numbers.
    type Mixture<'a> = &'a [(f64, [f64; 2])];
    // Body, mole fractions of its gases, tolerance. The Earth's scattering makes up for its scale height (atmospheres.toml).
    let gases: [(&str, Mixture<'_>, f64); 8] = [
        ("Earth", &[(1.0, air)], 0.2),
        ("Mars", &[(1.0, carbon_dioxide)], 0.05),
        ("Venus", &[(1.0, carbon_dioxide)], 0.05),
        ("Titan", &[(1.0, nitrogen)], 0.05),
        ("Jupiter", &[(0.864, hydrogen), (0.136, helium)], 0.05),
        ("Saturn", &[(0.92, hydrogen), (0.08, helium)], 0.05),
        ("Uranus", &[(0.85, hydrogen), (0.15, helium)], 0.05),
        ("Neptune", &[(0.85, hydrogen), (0.15, helium)], 0.05),
    ];
    let catalog = Catalog::embedded();
    let refracting: Vec<_> =
        catalog.bodies().iter().filter(|b| b.atmosphere.as_ref().is_some_and(|air| air.refractivity.is_some())).collect();
    assert_eq!(refracting.len(), gases.len());
    for body in refracting {
        let (_, mixture, tolerance) = gases.iter().find(|(name, ..)| *name == body.name).expect("in the table");
        let atmosphere = body.atmosphere.as_ref().expect("air");
        let (refractivity, scattering) = (atmosphere.refractivity.expect("given"), atmosphere.species[0].scattering_per_km[1]);
        let sum = |of: fn([f64; 2]) -> f64| mixture.iter().map(|(fraction, gas)| fraction * of(*gas)).sum::<f64>();
        let per_refractivity = sum(|[n, king]| n * n * king) / sum(|[n, _]| n);
        // Per kilometre, at 548 nm.
        let expected = 32.0 * std::f64::consts::PI.powi(3) / (3.0 * 2.687e25 * 548e-9_f64.powi(4)) * 1e3 * per_refractivity * refractivity;
        assert!((scattering / expected - 1.0).abs() < *tolerance, "{}: {scattering} per km, by its refractivity {expected}", body.name);
    }
}

#[test]
fn wrong_haze_at_the_limb_is_refused() {
    let problems_of = |value: &str| problems(&format!("[[atmosphere]]\nbody = \"Mars\"\ntop_km = 80.0\nlimb_haze_km = {value}\n"));
    assert_eq!(problems_of("[0.0, 5.0]"), Vec::<String>::new());
    for wrong in ["[12.0]", "[-1.0, 5.0]", "[12.0, 0.0]", "[nan, 5.0]", "5.0"] {
        let expected = format!("mine.toml:4: atmosphere.limb_haze_km = {wrong}: expected two numbers of kilometres");
        let found = problems_of(wrong);
        assert!(found.len() == 1 && found[0].starts_with(&expected), "{found:?}");
    }
}

/// A draw has at most one species of each kind. A second one would count in optical depths and tables, but would not be drawn.
#[test]
fn a_second_species_of_a_kind_is_refused() {
    let [gas, aerosol, layer] = [("n2", ""), ("haze", "asymmetry = 0.5"), ("ozone", "tent_centre_km = 20.0")].map(|(n, k)| species(n, k));
    assert_eq!(problems_of_air(&[gas.clone(), aerosol.clone(), layer.clone()]), Vec::<String>::new());
    for (first, second, kind) in
        [(&gas, "", "gas "), (&aerosol, "asymmetry = 0.0", "aerosol "), (&layer, "tent_centre_km = 9.0", "absorption layer ")]
    {
        let found = problems_of_air(&[first.clone(), species("second", second)]);
        let expected = format!("mine.toml:8: atmosphere.species = \"second\": expected at most one {kind}");
        assert!(found.len() == 1 && found[0].starts_with(&expected), "{found:?}");
    }
}

#[test]
fn wrong_parameters_of_an_aerosol_are_refused() {
    for kind in ["asymmetry = -0.5", "asymmetry = [-0.5, 0.0, 0.99]"] {
        assert_eq!(problems_of_air(&[species("haze", kind)]), Vec::<String>::new());
    }
    // `lines` are those of the species' kind; the last one is wrong.
    let problem = |lines: &str, allowed: &str| {
        let (before, wrong) = lines.lines().enumerate().last().expect("a line");
        format!("mine.toml:{}: atmosphere.species.{wrong}: expected {allowed}", 7 + before)
    };
    let asymmetry = "a number between -1 and 1, or three (red, green, blue)";
    let words = AerosolFunction::words(&AerosolFunction::ALL);
    for (lines, allowed) in [
        ("asymmetry = 1.0", asymmetry),
        ("asymmetry = nan", asymmetry),
        ("asymmetry = [0.5, 0.6]", asymmetry),
        ("asymmetry = [0.5, 0.6, -1.0]", asymmetry),
        ("phase = \"hg\"", "`asymmetry` beside it"),
        ("asymmetry = 0.5\nphase = \"mie\"", words.as_str()),
    ] {
        assert_eq!(problems_of_air(&[species("haze", lines)]), [problem(lines, allowed)]);
    }
    for field in AerosolPhase::FIELDS {
        let lines_with = |function: AerosolFunction, value: f64| {
            let asymmetry = if field.catalog_key == "asymmetry" { "" } else { "asymmetry = 0.5\n" };
            // In TOML, NaN is `nan`.
            format!("{asymmetry}phase = \"{}\"\n{} = {value:?}", function.query_word(), field.catalog_key).to_lowercase()
        };
        let [least, greatest] = field.limits;
        let at_limits = field.includes_limits;
        for (value, is_allowed) in [
            (0.5 * (least + greatest), true),
            (least, at_limits),
            (greatest, at_limits),
            (least - 0.1, false),
            (greatest + 0.1, false),
            (f64::NAN, false),
        ] {
            let lines = lines_with(field.functions[0], value);
            let expected = if is_allowed { Vec::new() } else { vec![problem(&lines, &field.allowed())] };
            assert_eq!(problems_of_air(&[species("haze", &lines)]), expected);
        }
        for other in AerosolFunction::ALL.into_iter().filter(|function| !field.functions.contains(function)) {
            let lines = lines_with(other, least);
            let allowed = format!("`phase = {}` beside it", AerosolFunction::words(field.functions));
            assert_eq!(problems_of_air(&[species("haze", &lines)]), [problem(&lines, &allowed)]);
        }
    }
}

#[test]
fn the_head_of_the_file_explains_each_function_and_field_of_an_aerosol() {
    let (_, text) = orrery_catalogs::CATALOG_FILES.iter().find(|(name, _)| *name == "atmospheres.toml").expect("listed");
    let head: String = text.lines().take_while(|line| line.starts_with('#')).collect();
    for field in AerosolPhase::FIELDS {
        assert!(head.contains(&format!("`{}`", field.catalog_key)), "{}", field.catalog_key);
    }
    for function in AerosolFunction::ALL {
        assert!(head.contains(&AerosolFunction::words(&[function])), "{function:?}");
    }
}
