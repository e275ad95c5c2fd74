//! Writes catalogs/rings.toml's Saturn: `cargo run --features bake --example bake_rings`.
//!
//! Places and optical depths of named edges, gaps, plateaus and ringlets are those of the published occultation profiles (Colwell et al. 2009 and 2010;
//! Cuzzi et al. 1984 for what Voyager saw), entered from memory and rounded. Between named features the B ring's hundreds of ringlets are not in any table
//! small enough to carry: there a fixed sum of waves wanders over the published range of optical depth, so its single ringlets are not real ones.

/// Inner edge, outer edge (km), optical depth at each, width of a step, depth of the wandering (part of the optical depth), colour.
struct Region(&'static str, f64, f64, f64, f64, f64, f64, [f64; 3]);

const C: [f64; 3] = [0.33, 0.30, 0.26];
const PLATEAU: [f64; 3] = [0.42, 0.37, 0.31];
const B: [f64; 3] = [1.0, 0.87, 0.67];
const B_INNER: [f64; 3] = [0.90, 0.77, 0.58];
const DIVISION: [f64; 3] = [0.40, 0.37, 0.33];
const A: [f64; 3] = [0.68, 0.61, 0.50];
const ICE_DUST: [f64; 3] = [0.50, 0.50, 0.50];

const REGIONS: &[Region] = &[
    Region("D", 66900.0, 74658.0, 1e-5, 3e-4, 800.0, 0.0, ICE_DUST),
    Region("C inner", 74658.0, 80000.0, 0.045, 0.07, 120.0, 0.25, C),
    Region("C middle", 80000.0, 86000.0, 0.07, 0.10, 120.0, 0.2, C),
    Region("C outer", 86000.0, 90620.0, 0.09, 0.12, 120.0, 0.2, C),
    Region("C ramp", 90620.0, 91975.0, 0.11, 0.26, 100.0, 0.05, C),
    Region("B1", 91975.0, 99000.0, 0.95, 1.3, 60.0, 0.45, B_INNER),
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

/// Plateaus, gaps and ringlets that lie over the regions.
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

fn wander(radius_km: f64) -> f64 {
    let wave = |length_km: f64, phase: f64| (radius_km / length_km * std::f64::consts::TAU + phase).sin();
    0.4 * wave(1310.0, 0.3) + 0.3 * wave(577.0, 1.9) + 0.3 * wave(263.0, 4.1) + 0.3 * wave(171.0, 2.2) * wave(2900.0, 0.8)
}

fn entry(name: &str, inner_km: f64, outer_km: f64, tau: f64, albedo: [f64; 3], dust: f64) {
    let [r, g, b] = albedo;
    println!("\n[[ring]]\nbody = \"Saturn\"\nname = \"{name}\"\ninner_km = {inner_km:.1}\nouter_km = {outer_km:.1}\ntau_normal = {tau}");
    println!("albedo = [{r}, {g}, {b}]");
    if dust > 0.0 {
        println!("dust = {dust}");
    }
}

fn main() {
    for Region(name, inner, outer, tau_inner, tau_outer, step_km, depth, albedo) in REGIONS {
        let count = ((outer - inner) / step_km).round().max(1.0) as usize;
        let edge = |k: usize| inner + (outer - inner) * k as f64 / count as f64;
        for k in 0..count {
            let (from, to) = (edge(k), edge(k + 1));
            let middle = (from + to) / 2.0;
            let between = (middle - inner) / (outer - inner);
            let tau = (tau_inner + (tau_outer - tau_inner) * between) * (1.0 + depth * wander(middle)).max(0.1);
            let numbered = if count == 1 { (*name).to_owned() } else { format!("{name} {}", k + 1) };
            let dust = if *name == "D" || name.starts_with('F') { 0.5 } else { 0.0 };
            entry(&numbered, from, to, (tau * 1e6).round() / 1e6, *albedo, dust);
        }
    }
    for (name, inner, outer, tau, albedo) in FEATURES {
        entry(name, *inner, *outer, *tau, *albedo, 0.0);
    }
}
