//! Prints the Saturn entries of catalogs/rings.toml: `cargo run --features bake --example bake_rings`.
//!
//! Radii and optical depths of named edges, gaps, plateaus and ringlets are those of the published occultation profiles (Colwell et al.
//! 2009 and 2010; Cuzzi et al. 1984 for features that Voyager saw), entered from memory and rounded. No table small enough to include lists
//! the ringlets between named features, hundreds of them in the B ring. There a fixed sum of waves varies over the published range of optical
//! depth, so the individual ringlets are not real. The brightness of the B ring is real at scales from 500 km to the width of the entire
//! ring: it is read from the ring map of Solar System Scope (CC-BY-4.0), as described at `B_BRIGHTNESS`.
//!
//! Dust: the D, F, G and E rings and the Encke ringlet consist mostly of dust. In C, A and the Cassini Division its fraction is a percent
//! (none in the named ringlets), in the B ring zero. These fractions, the dust's albedos and the radial profiles of G and E are estimates
//! after Showalter et al. 1991 (Icarus 94, 451: E), Hedman et al. 2007 (Science 317, 653: G) and Horányi et al. 2009 (Saturn from
//! Cassini-Huygens, ch. 16), from memory.

/// Name, inner edge, outer edge (km), optical depth along the normal at each edge, width of a step (km), amplitude of the variation (fraction
/// of the optical depth, see `waves`), single-scattering albedo (red, green, blue).
struct Region(&'static str, f64, f64, f64, f64, f64, f64, [f64; 3]);

/// Single-scattering albedos of the particles of the C ring and its plateaus, the B ring, the Cassini Division and the A ring.
const C: [f64; 3] = [0.33, 0.30, 0.26];
const PLATEAU: [f64; 3] = [0.42, 0.37, 0.31];
const B: [f64; 3] = [1.0, 0.87, 0.67];
const DIVISION: [f64; 3] = [0.40, 0.37, 0.33];
const A: [f64; 3] = [0.68, 0.61, 0.50];
/// Single-scattering albedos of dust, which absorbs little of the light that it intercepts. Grains of the E ring range from smaller than
/// the wavelength of light to larger, which makes that ring blue.
const ICE_DUST: [f64; 3] = [0.95, 0.93, 0.90];
const G_DUST: [f64; 3] = [0.95, 0.90, 0.86];
const E_DUST: [f64; 3] = [0.80, 0.90, 1.00];

/// Brightness of the B ring relative to its mean, every 500 km from 92 200 km outwards: linear luminance of the ring map averaged over
/// annuli 0.7 texels wide (527 km per texel). The scale is fixed by the brightness steps at the B ring's inner edge (91 975 km, 160.05
/// texels) and outer edge (117 507 km, 208.53 texels); it puts the A ring's outer edge within 500 km of its true radius. Within 2.5 texels
/// of either edge the nearest unaffected value is repeated.
const B_BRIGHTNESS: [f64; 51] = [
    0.69, 0.69, 0.69, 0.69, 0.71, 0.70, 0.69, 0.69, 0.69, 0.70, 0.70, 0.70, 0.72, 0.79, 0.87, 0.95, 1.01, 1.07, 1.11, 1.13, 1.14, 1.12,
    1.08, 1.05, 1.05, 1.05, 1.05, 1.08, 1.15, 1.20, 1.21, 1.21, 1.25, 1.30, 1.27, 1.20, 1.15, 1.09, 1.03, 1.01, 1.03, 1.05, 1.05, 1.03,
    1.00, 1.04, 1.15, 1.25, 1.25, 1.25, 1.25,
];
/// The map's contrast is exaggerated. Raised to this power, the brightness of its inner B ring is about 0.7 of the brightest part, as in
/// Hubble's photometry (Cuzzi et al. 2002, from memory).
const B_CONTRAST: f64 = 0.55;

const REGIONS: &[Region] = &[
    // Name, inner and outer edge, optical depths there, width of a step, amplitude, albedo.
    Region("D", 66900.0, 74658.0, 1e-5, 3e-4, 800.0, 0.0, ICE_DUST),
    Region("C inner", 74658.0, 80000.0, 0.045, 0.07, 120.0, 0.25, C),
    Region("C middle", 80000.0, 86000.0, 0.07, 0.10, 120.0, 0.2, C),
    Region("C outer", 86000.0, 90620.0, 0.09, 0.12, 120.0, 0.2, C),
    Region("C ramp", 90620.0, 91975.0, 0.11, 0.26, 100.0, 0.05, C),
    Region("B1", 91975.0, 99000.0, 0.95, 1.3, 60.0, 0.45, B),
    Region("B2", 99000.0, 104500.0, 1.7, 2.4, 60.0, 0.5, B),
    Region("B3", 104500.0, 110000.0, 4.5, 4.8, 80.0, 0.35, B),
    Region("B4", 110000.0, 117507.0, 2.6, 2.2, 60.0, 0.35, B),
    Region("Cassini Division inner", 117932.0, 120600.0, 0.08, 0.11, 60.0, 0.35, DIVISION),
    Region("Cassini Division ramp", 120600.0, 122050.0, 0.11, 0.20, 100.0, 0.05, DIVISION),
    Region("A inner", 122050.0, 124500.0, 1.05, 0.75, 80.0, 0.08, A),
    Region("A middle", 124500.0, 128500.0, 0.62, 0.45, 100.0, 0.10, A),
    Region("A outer", 128500.0, 133423.0, 0.44, 0.50, 100.0, 0.10, A),
    Region("A beyond Encke", 133745.0, 136488.0, 0.52, 0.58, 80.0, 0.06, A),
    Region("A edge", 136522.0, 136774.0, 0.62, 0.60, 60.0, 0.0, A),
    Region("F skirt", 139920.0, 140520.0, 0.02, 0.02, 300.0, 0.0, ICE_DUST),
    Region("F core", 140195.0, 140245.0, 0.25, 0.25, 50.0, 0.0, ICE_DUST),
];

/// Plateaus, gaps and ringlets, which replace the parts of the regions that they cover: name, inner edge, outer edge (km), optical depth
/// along the normal, single-scattering albedo.
const FEATURES: &[(&str, f64, f64, f64, [f64; 3])] = &[
    ("C plateau 1", 76020.0, 76260.0, 0.22, PLATEAU),
    ("C plateau 2", 77160.0, 77220.0, 0.25, PLATEAU),
    ("Colombo gap", 77748.0, 77929.0, 0.0, C),
    ("Titan ringlet", 77867.0, 77892.0, 1.2, PLATEAU),
    ("C plateau 3", 79220.0, 79270.0, 0.30, PLATEAU),
    ("C plateau 4", 82010.0, 82090.0, 0.30, PLATEAU),
    ("C plateau 5", 84750.0, 84950.0, 0.40, PLATEAU),
    ("C plateau 6", 85660.0, 85760.0, 0.40, PLATEAU),
    ("C plateau 7", 86370.0, 86600.0, 0.40, PLATEAU),
    ("Maxwell gap", 87342.0, 87610.0, 0.0, C),
    ("Maxwell ringlet", 87460.0, 87524.0, 1.0, PLATEAU),
    ("C plateau 8", 88350.0, 88590.0, 0.40, PLATEAU),
    ("Bond gap", 88687.0, 88723.0, 0.0, C),
    ("Bond ringlet", 88701.0, 88718.0, 1.0, PLATEAU),
    ("C plateau 9", 89190.0, 89300.0, 0.40, PLATEAU),
    ("C plateau 10", 89790.0, 89940.0, 0.45, PLATEAU),
    ("Dawes gap", 90200.0, 90220.0, 0.0, C),
    ("C plateau 11", 90400.0, 90620.0, 0.45, PLATEAU),
    ("Huygens ringlet", 117806.0, 117824.0, 0.9, DIVISION),
    ("Herschel gap", 118188.0, 118283.0, 0.0, DIVISION),
    ("Russell gap", 118589.0, 118628.0, 0.0, DIVISION),
    ("Jeffreys gap", 118929.0, 118967.0, 0.0, DIVISION),
    ("Laplace gap", 119845.0, 120086.0, 0.0, DIVISION),
    ("Laplace ringlet", 120036.0, 120078.0, 0.4, DIVISION),
    ("Bessel gap", 120231.0, 120243.0, 0.0, DIVISION),
    ("Barnard gap", 120304.0, 120318.0, 0.0, DIVISION),
    ("Encke ringlet", 133580.0, 133600.0, 0.05, ICE_DUST),
];

/// A fixed sum of waves between -1.3 and 1.3, in place of ringlets that no published table lists.
fn waves(radius_km: f64) -> f64 {
    let wave = |length_km: f64, phase: f64| (radius_km / length_km * std::f64::consts::TAU + phase).sin();
    0.4 * wave(1310.0, 0.3) + 0.3 * wave(577.0, 1.9) + 0.3 * wave(263.0, 4.1) + 0.3 * wave(171.0, 2.2) * wave(2900.0, 0.8)
}

/// The B ring's single-scattering albedo at a radius.
fn b_albedo(radius_km: f64) -> [f64; 3] {
    let index = ((radius_km - 92_200.0) / 500.0).clamp(0.0, (B_BRIGHTNESS.len() - 1) as f64);
    let low = (index as usize).min(B_BRIGHTNESS.len() - 2);
    let fraction = index - low as f64;
    let brightest = B_BRIGHTNESS.iter().copied().fold(0.0, f64::max);
    let brightness = (B_BRIGHTNESS[low] * (1.0 - fraction) + B_BRIGHTNESS[low + 1] * fraction) / brightest;
    B.map(|c| (c * brightness.powf(B_CONTRAST) * 1e3).round() / 1e3)
}

/// Fraction of the light of a region or feature that dust scatters.
fn dust_fraction(name: &str) -> f64 {
    match name {
        "D" => 1.0,
        "F skirt" | "Encke ringlet" => 0.95,
        "F core" => 0.6,
        n if n.starts_with('C') || n.starts_with('A') || n.starts_with("Cassini") => 0.01,
        _ => 0.0,
    }
}

/// Optical depth of the G ring along its normal: a core at its inner edge, and an outer part that falls by a factor e in 2500 km.
fn g_tau(radius_km: f64) -> f64 {
    if radius_km < 168_000.0 { 2e-6 } else { 1e-6 * (-(radius_km - 168_000.0) / 2500.0).exp() }
}

/// Optical depth of the E ring along its normal: a power of the radius on each side of Enceladus' orbit.
fn e_tau(radius_km: f64) -> f64 {
    let ratio = radius_km / 238_000.0;
    1.5e-5 * if ratio < 1.0 { ratio.powi(15) } else { ratio.powi(-7) }
}

/// Prints a ring of pure dust whose optical depth varies smoothly, as `count` numbered rings of equal width. `tau`: optical depth along the normal at a radius
/// in km.
fn print_steps(name: &str, inner_km: f64, outer_km: f64, count: u32, tau: fn(f64) -> f64, albedo: [f64; 3]) {
    for k in 0..count {
        let edge = |k: u32| inner_km + (outer_km - inner_km) * f64::from(k) / f64::from(count);
        let (step_inner_km, step_outer_km) = (edge(k), edge(k + 1));
        let step_tau = (tau((step_inner_km + step_outer_km) / 2.0) * 1e9).round() / 1e9;
        print_ring(&format!("{name} {}", k + 1), step_inner_km, step_outer_km, step_tau, albedo, 1.0);
    }
}

/// `tau`: optical depth along the normal. `dust`: fraction of the light that dust scatters.
fn print_ring(name: &str, inner_km: f64, outer_km: f64, tau: f64, albedo: [f64; 3], dust: f64) {
    let [r, g, b] = albedo;
    println!("\n[[ring]]\nbody = \"Saturn\"\nname = \"{name}\"\ninner_km = {inner_km:.1}\nouter_km = {outer_km:.1}\ntau_normal = {tau}");
    println!("albedo = [{r:?}, {g:?}, {b:?}]");
    if dust > 0.0 {
        println!("dust = {dust:?}");
    }
}

fn main() {
    for Region(name, inner_km, outer_km, tau_inner, tau_outer, step_km, amplitude, albedo) in REGIONS {
        let count = ((outer_km - inner_km) / step_km).round().max(1.0) as usize;
        let edge = |k: usize| inner_km + (outer_km - inner_km) * k as f64 / count as f64;
        for k in 0..count {
            let (step_inner_km, step_outer_km) = (edge(k), edge(k + 1));
            let middle_km = (step_inner_km + step_outer_km) / 2.0;
            let fraction = (middle_km - inner_km) / (outer_km - inner_km);
            let tau = (tau_inner + (tau_outer - tau_inner) * fraction) * (1.0 + amplitude * waves(middle_km)).max(0.1);
            let ring_name = if count == 1 { (*name).to_owned() } else { format!("{name} {}", k + 1) };
            let albedo = if *albedo == B { b_albedo(middle_km) } else { *albedo };
            print_ring(&ring_name, step_inner_km, step_outer_km, (tau * 1e6).round() / 1e6, albedo, dust_fraction(name));
        }
    }
    for (name, inner_km, outer_km, tau, albedo) in FEATURES {
        print_ring(name, *inner_km, *outer_km, *tau, *albedo, dust_fraction(name));
    }
    print_steps("G", 166_000.0, 175_000.0, 18, g_tau, G_DUST);
    print_steps("E", 180_000.0, 480_000.0, 60, e_tau, E_DUST);
}
