//! Writes an invented shape for Phobos, with lumps and craters, and the catalog file that makes Orrery draw it.
//!
//!     cargo run --release --example lumpy_moon -- FOLDER
//!     orrery render --catalogs FOLDER --target phobos -o phobos.png
//!
//! The shape is not that of Phobos. The example only shows what the files of a shape model contain. The shape has 82 000 triangles (6 MB).

use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::fmt::Write;

/// How often each edge of the icosahedron is halved.
const HALVINGS: u32 = 6;
/// Semi-axes of Phobos' ellipsoid, as in the catalog.
const RADII_KM: DVec3 = DVec3::new(13.0, 11.4, 9.1);
const CRATER_COUNT: usize = 240;

/// An icosahedron, subdivided: vertices on the unit sphere, and triangles, counter-clockwise seen from outside.
fn icosphere() -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let golden_ratio = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut vertices = Vec::new();
    for (a, b) in [(1.0, golden_ratio), (-1.0, golden_ratio), (1.0, -golden_ratio), (-1.0, -golden_ratio)] {
        vertices.extend([DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)].map(DVec3::normalize));
    }
    // Three vertices that are one edge apart form a face.
    let is_edge = |a: usize, b: usize| (vertices[a] - vertices[b]).length() < 1.1;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in (b + 1..12).filter(|c| is_edge(a, b) && is_edge(b, *c) && is_edge(a, *c)) {
                let is_outward = (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]).dot(vertices[a]) > 0.0;
                faces.push(if is_outward { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    for _ in 0..HALVINGS {
        let mut midpoints: HashMap<(usize, usize), usize> = HashMap::new();
        let mut midpoint = |a: usize, b: usize| {
            *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a] + vertices[b]).normalize());
                vertices.len() - 1
            })
        };
        let subdivided = |[a, b, c]: [usize; 3]| {
            let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(subdivided).collect();
    }
    (vertices, faces)
}

/// A generator of uniform random numbers from 0 to 1, the same in each run.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        // Multiplier and increment are Knuth's (MMIX). The lower bits are less random, so they are dropped.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        let (z, longitude) = (2.0 * self.uniform() - 1.0, TAU * self.uniform());
        let cos_latitude = (1.0 - z * z).sqrt();
        DVec3::new(cos_latitude * longitude.cos(), cos_latitude * longitude.sin(), z)
    }
}

/// The height of a crater at a distance from its centre, both in crater radii. The crater is a parabolic bowl 0.24 radii deep (negative heights), with a rim
/// 0.06 radii high.
fn crater_height(distance: f64) -> f64 {
    let bowl = if distance < 1.0 { 0.24 * (distance * distance - 1.0) } else { 0.0 };
    bowl + 0.06 * (-((distance - 1.0) / 0.25).powi(2)).exp()
}

fn main() {
    let Some(folder) = std::env::args().nth(1) else {
        eprintln!("name the folder to write to");
        std::process::exit(2);
    };
    let (directions, faces) = icosphere();
    let mut random = Random(2024);
    // Wave vector, phase in radians, amplitude: shorter waves are lower. All numbers are invented.
    let waves: Vec<(DVec3, f64, f64)> = (0..24)
        .map(|k| (random.direction() * (2.0 + 0.4 * f64::from(k)), random.uniform() * TAU, 0.05 / (1.0 + 0.25 * f64::from(k))))
        .collect();
    // The centre's direction, and the radius relative to the body's. The number of craters larger than r is proportional to 1 / r²: most are small.
    let craters: Vec<(DVec3, f64)> = (0..CRATER_COUNT).map(|_| (random.direction(), 0.035 / random.uniform().max(0.006).sqrt())).collect();
    // Distance of the surface from the centre in a direction, relative to that of the ellipsoid.
    let relative_radius = |direction: DVec3| {
        let lumps: f64 = waves.iter().map(|(wave_vector, phase, amplitude)| amplitude * (wave_vector.dot(direction) + phase).sin()).sum();
        let crater_heights: f64 =
            craters.iter().map(|(centre, radius)| radius * crater_height((direction - *centre).length() / radius)).sum();
        1.0 + lumps + crater_heights
    };
    let mut text = String::from("# An invented shape, kilometres, body axes: x through the prime meridian, z the pole.\n");
    for direction in &directions {
        let vertex_km = *direction * relative_radius(*direction) * RADII_KM;
        let _ = writeln!(text, "v {:.5} {:.5} {:.5}", vertex_km.x, vertex_km.y, vertex_km.z);
    }
    for [a, b, c] in &faces {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    let catalog = "[[body]]\nid = 401 # Phobos\n[body.mesh]\nfile = \"lumpy.obj\"\n\
                   invented = \"lumps and craters by chance; nothing of it is Phobos but its size\"\n";
    let write = |name: &str, text: &str| std::fs::write(std::path::Path::new(&folder).join(name), text);
    if let Err(e) = std::fs::create_dir_all(&folder).and_then(|()| write("lumpy.obj", &text)).and_then(|()| write("lumpy.toml", catalog)) {
        eprintln!("{folder}: {e}");
        std::process::exit(1);
    }
    println!("{} vertices, {} triangles", directions.len(), faces.len());
}
