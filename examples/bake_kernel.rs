//! Writes `orrery_1900_2100.bsp` and `pluto_1551_2646.bsp` from JPL's DE440:
//!
//!     cargo run --release --features bake --example bake_kernel -- de440.bsp catalogs
//!
//! Each body is refitted with Chebyshev polynomials that interpolate DE440 at the Chebyshev nodes of intervals of equal length. For each of
//! several interval lengths the program finds the lowest degree that keeps the stated error, and writes the smallest result as an SPK segment
//! of type 2 (NAIF's SPK and DAF Required Reading). For each body it prints the worst error against DE440 between the nodes.

use glam::DVec3;
use orrery::ephemeris::chebyshev::{fit_nodes, value_and_slope};
use orrery::ephemeris::spk::Spk;
use orrery::units::SECONDS_PER_DAY;
use std::f64::consts::PI;

/// Fits have fewer coefficients per axis than this number.
const TERMS_END: usize = 40;

/// A kernel file to write: its span in days past J2000 and its bodies.
struct KernelSpec {
    file: &'static str,
    /// Internal file name in the DAF's file record, at most 60 characters.
    title: &'static str,
    start_days: f64,
    end_days: f64,
    bodies: &'static [BodySpec],
}

/// 1899-12-31T12:00 to 2100-01-02T00:00 TDB: 200 years with a margin of at least half a day, more than any Delta T.
const MAIN: KernelSpec = KernelSpec {
    file: "orrery_1900_2100.bsp",
    title: "ORRERY 1900-2100, REFITTED FROM DE440",
    start_days: -36_525.0,
    end_days: 36_525.5,
    bodies: BODIES,
};

/// Pluto for nearly all dates that DE440 covers. Outside the span of the main file the other planets have series, but no short published series of Pluto
/// covers these dates. The allowed error is far below that of the series of the outer planets.
const PLUTO: KernelSpec = KernelSpec {
    file: "pluto_1551_2646.bsp",
    title: "ORRERY PLUTO 1551-2646, REFITTED FROM DE440",
    start_days: -164_000.0,
    end_days: 236_000.0,
    bodies: &[BodySpec { name: "PLUTO BARYCENTER", target: 9, center: 0, error_km: 500.0 }],
};

struct BodySpec {
    name: &'static str,
    /// NAIF id of the body.
    target: i32,
    /// NAIF id of the body or barycentre to which positions are relative; 0 is the solar system's barycentre.
    center: i32,
    /// Largest position error allowed, km.
    error_km: f64,
}

/// The allowed errors are those that the ephemeris states (`kernel_error_km` in `src/ephemeris/mod.rs`): for the planets below 0.003 arcsec as
/// seen from the Sun, and less for the Sun, on which every heliocentric direction depends.
const BODIES: &[BodySpec] = &[
    BodySpec { name: "MERCURY BARYCENTER", target: 1, center: 0, error_km: 0.5 },
    BodySpec { name: "VENUS BARYCENTER", target: 2, center: 0, error_km: 0.5 },
    BodySpec { name: "EARTH-MOON BARYCENTER", target: 3, center: 0, error_km: 0.3 },
    BodySpec { name: "MARS BARYCENTER", target: 4, center: 0, error_km: 1.0 },
    BodySpec { name: "JUPITER BARYCENTER", target: 5, center: 0, error_km: 2.0 },
    BodySpec { name: "SATURN BARYCENTER", target: 6, center: 0, error_km: 2.0 },
    BodySpec { name: "URANUS BARYCENTER", target: 7, center: 0, error_km: 5.0 },
    BodySpec { name: "NEPTUNE BARYCENTER", target: 8, center: 0, error_km: 5.0 },
    BodySpec { name: "PLUTO BARYCENTER", target: 9, center: 0, error_km: 5.0 },
    BodySpec { name: "SUN", target: 10, center: 0, error_km: 0.1 },
    BodySpec { name: "MERCURY", target: 199, center: 1, error_km: 1e-3 },
    BodySpec { name: "VENUS", target: 299, center: 2, error_km: 1e-3 },
    BodySpec { name: "EARTH", target: 399, center: 3, error_km: 0.03 },
    BodySpec { name: "MOON", target: 301, center: 399, error_km: 0.03 },
];

/// The stride of [`worst_km`] that checks the entire span.
const EVERY_INTERVAL: usize = 1;

/// Interval lengths to try.
const LENGTHS_DAYS: &[f64] =
    &[4.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0, 96.0, 128.0, 192.0, 256.0, 400.0, 600.0, 1000.0, 4000.0, 10_000.0];

/// A choice of interval length and degree for one segment.
struct Fit {
    /// Length of an interval.
    length_days: f64,
    /// Number of intervals.
    records: usize,
    /// Coefficients per axis.
    terms: usize,
    /// Numbers in the segment's array.
    doubles: usize,
}

/// Coefficients per axis, from interpolation at `terms` Chebyshev nodes of an interval. `midpoint_s`: its middle, TDB seconds past J2000; `radius_s`: half its
/// length.
fn coefficients(de440: &Spk, body: &BodySpec, midpoint_s: f64, radius_s: f64, terms: usize) -> [Vec<f64>; 3] {
    fit_nodes(terms, |u| position(de440, body, midpoint_s + u * radius_s))
}

/// Position in km at a time in TDB seconds past J2000; NaN outside DE440's span.
fn position(de440: &Spk, body: &BodySpec, tdb_s: f64) -> DVec3 {
    de440.state(body.target, body.center, tdb_s).map_or(DVec3::NAN, |s| s.pos_km)
}

/// Worst error in km over every `stride`-th interval, at the interval's ends and between its nodes.
fn worst_km(de440: &Spk, spec: &KernelSpec, body: &BodySpec, length_days: f64, terms: usize, stride: usize) -> f64 {
    let records = ((spec.end_days - spec.start_days) / length_days).ceil() as usize;
    let radius_s = 0.5 * length_days * SECONDS_PER_DAY;
    (0..records).step_by(stride).fold(0.0, |worst: f64, i| {
        let midpoint_s = spec.start_days * SECONDS_PER_DAY + (2 * i + 1) as f64 * radius_s;
        let axes = coefficients(de440, body, midpoint_s, radius_s, terms);
        (0..=terms).fold(worst, |worst, j| {
            let u = (PI * j as f64 / terms as f64).cos();
            let truth = position(de440, body, midpoint_s + u * radius_s);
            let [x, y, z] = axes.each_ref().map(|axis| value_and_slope(axis, u).0);
            let error = (DVec3::new(x, y, z) - truth).length();
            // Outside DE440's span the position is NaN, which max() would ignore.
            if error.is_nan() { f64::INFINITY } else { worst.max(error) }
        })
    })
}

/// The fit with the smallest array that keeps the body's allowed error; `None` if no choice does.
fn smallest_fit(de440: &Spk, spec: &KernelSpec, body: &BodySpec) -> Option<Fit> {
    let mut best: Option<Fit> = None;
    for &length_days in LENGTHS_DAYS {
        let records = ((spec.end_days - spec.start_days) / length_days).ceil() as usize;
        // At least 40 intervals, evenly spaced, or all.
        let sparse_stride = (records / 40).max(1);
        for terms in 2..TERMS_END {
            // Each record has a midpoint, a radius and the coefficients of three axes; four numbers follow the records (see `segment`).
            let doubles = records * (2 + 3 * terms) + 4;
            if best.as_ref().is_some_and(|b| doubles >= b.doubles) {
                break;
            }
            // A sparse check rejects most choices; the check of the entire span decides.
            if worst_km(de440, spec, body, length_days, terms, sparse_stride) <= body.error_km
                && worst_km(de440, spec, body, length_days, terms, EVERY_INTERVAL) <= body.error_km
            {
                best = Some(Fit { length_days, records, terms, doubles });
                break;
            }
        }
    }
    best
}

/// One DAF array: the records, then the start, the length of an interval, the record size and the number of records.
fn segment(de440: &Spk, spec: &KernelSpec, body: &BodySpec, fit: &Fit) -> Vec<f64> {
    let radius_s = 0.5 * fit.length_days * SECONDS_PER_DAY;
    let mut data = Vec::with_capacity(fit.doubles);
    for i in 0..fit.records {
        let midpoint_s = spec.start_days * SECONDS_PER_DAY + (2 * i + 1) as f64 * radius_s;
        data.extend([midpoint_s, radius_s]);
        coefficients(de440, body, midpoint_s, radius_s, fit.terms).iter().for_each(|axis| data.extend(axis));
    }
    data.extend([spec.start_days * SECONDS_PER_DAY, fit.length_days * SECONDS_PER_DAY, (2 + 3 * fit.terms) as f64, fit.records as f64]);
    data
}

/// A complete DAF file: file record, comments, summaries, names, arrays; little-endian records of 1024 bytes. A summary has 2 doubles and 6
/// integers, 40 bytes; addresses count doubles from 1.
fn daf(spec: &KernelSpec, segments: &[(&BodySpec, Vec<f64>)], comment: &str) -> Vec<u8> {
    const RECORD_BYTES: usize = 1024;
    /// Characters of the comments in one record.
    const COMMENT_CHARS: usize = 1000;
    // In the comments a line ends with 0 and the text with 4.
    let comment: Vec<u8> = comment.bytes().map(|b| if b == b'\n' { 0 } else { b }).chain([4]).collect();
    let comment_records = comment.len().div_ceil(COMMENT_CHARS);
    let summary_record = 2 + comment_records;
    let mut address = (summary_record + 1) * RECORD_BYTES / 8 + 1;
    let mut summaries = vec![0u8; RECORD_BYTES];
    let mut names = vec![b' '; RECORD_BYTES];
    // The record begins with three doubles, 24 bytes: next and previous summary record (0: none), and the number of summaries.
    summaries[16..24].copy_from_slice(&(segments.len() as f64).to_le_bytes());
    let mut arrays = Vec::new();
    for (i, (body, data)) in segments.iter().enumerate() {
        let offset = 24 + 40 * i;
        summaries[offset..offset + 8].copy_from_slice(&(spec.start_days * SECONDS_PER_DAY).to_le_bytes());
        summaries[offset + 8..offset + 16].copy_from_slice(&(spec.end_days * SECONDS_PER_DAY).to_le_bytes());
        // Target, centre, frame (1: J2000), type of segment (2: Chebyshev positions), first and last address.
        let integers = [body.target, body.center, 1, 2, address as i32, (address + data.len() - 1) as i32];
        for (k, n) in integers.iter().enumerate() {
            summaries[offset + 16 + 4 * k..offset + 20 + 4 * k].copy_from_slice(&n.to_le_bytes());
        }
        names[40 * i..40 * i + body.name.len()].copy_from_slice(body.name.as_bytes());
        address += data.len();
        arrays.extend(data.iter().flat_map(|d| d.to_le_bytes()));
    }
    let mut file = vec![0u8; RECORD_BYTES];
    file[..8].copy_from_slice(b"DAF/SPK ");
    // Doubles and integers of a summary.
    file[8..12].copy_from_slice(&2i32.to_le_bytes());
    file[12..16].copy_from_slice(&6i32.to_le_bytes());
    file[16..76].copy_from_slice(format!("{:60}", spec.title).as_bytes());
    // The first and the last summary record, and the first free address.
    for (offset, n) in [(76, summary_record), (80, summary_record), (84, address)] {
        file[offset..offset + 4].copy_from_slice(&(n as i32).to_le_bytes());
    }
    file[88..96].copy_from_slice(b"LTL-IEEE");
    // The validation string of DAF Required Reading reveals a file damaged by text-mode transfer.
    file[699..727].copy_from_slice(b"FTPSTR:\r:\n:\r\n:\r\0:\x81:\x10\xce:ENDFTP");
    for part in comment.chunks(COMMENT_CHARS) {
        file.extend(part);
        file.resize(file.len().div_ceil(RECORD_BYTES) * RECORD_BYTES, 0);
    }
    file.extend(summaries);
    file.extend(names);
    file.extend(arrays);
    file.resize(file.len().div_ceil(RECORD_BYTES) * RECORD_BYTES, 0);
    file
}

/// Writes the kernel file of a specification into `folder`.
fn bake(de440: &Spk, spec: &KernelSpec, folder: &str) -> Result<(), Box<dyn std::error::Error>> {
    let mut segments = Vec::new();
    let mut comment =
        String::from("Refitted from JPL DE440 (Park et al. 2021) by Orrery's examples/bake_kernel.rs.\nWorst error against DE440 in km:\n");
    for body in spec.bodies {
        let fit = smallest_fit(de440, spec, body).ok_or_else(|| format!("{}: no choice reaches {} km", body.name, body.error_km))?;
        let error_km = worst_km(de440, spec, body, fit.length_days, fit.terms, EVERY_INTERVAL);
        let line =
            format!("{:22} {:6} days x {:2} terms  {:7} bytes  {error_km:.4} km", body.name, fit.length_days, fit.terms, fit.doubles * 8);
        println!("{line}");
        comment += &line;
        comment.push('\n');
        segments.push((body, segment(de440, spec, body, &fit)));
    }
    let file = daf(spec, &segments, &comment);
    let path = format!("{folder}/{}", spec.file);
    std::fs::write(&path, &file)?;
    println!("{path}: {} bytes", file.len());
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(from), Some(folder)) = (arguments.next(), arguments.next()) else {
        return Err("usage: bake_kernel DE440.bsp FOLDER".into());
    };
    let de440 = Spk::parse(&from, &std::fs::read(&from)?)?;
    bake(&de440, &MAIN, &folder)?;
    bake(&de440, &PLUTO, &folder)
}
