//! What a message says of the times that a kernel covers: a gap between its segments, and the whole span otherwise. Kernels whose centres form a cycle.

use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::Ephemeris;
use orrery::time::Instant;

const EROS: i32 = 2_000_433;
const SUN: i32 = 10;
const EARTH: i32 = 399;
const MOON: i32 = 301;
const JUPITER: i32 = 599;
const IO: i32 = 501;
const YEAR_S: f64 = 365.25 * 86_400.0;

/// A little-endian SPK with a segment of Eros at rest relative to the Sun for each span of years after J2000.
fn kernel(spans: &[(f64, f64)]) -> Vec<u8> {
    kernel_of(&spans.iter().map(|span| (EROS, SUN, *span)).collect::<Vec<_>>())
}

/// A little-endian SPK of segments: a target, its centre, relative to which it is at rest, and a span of years after J2000.
fn kernel_of(segments: &[(i32, i32, (f64, f64))]) -> Vec<u8> {
    let mut bytes = vec![0; 3 * 1024];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    // The file record, the summary record and a blank name record, then the data.
    put(0, b"DAF/SPK ");
    put(8, &2_i32.to_le_bytes());
    put(12, &6_i32.to_le_bytes());
    put(16, &[b' '; 60]);
    put(76, &2_i32.to_le_bytes());
    put(80, &2_i32.to_le_bytes());
    put(88, b"LTL-IEEE");
    put(699, b"FTPSTR:\r:\n:\r\n:\r\0:\x81:\x10\xce:ENDFTP");
    put(1024 + 16, &(segments.len() as f64).to_le_bytes());
    put(2048, &[b' '; 1024]);
    let mut data: Vec<f64> = Vec::new();
    for (k, (target, center, (first_year, last_year))) in segments.iter().enumerate() {
        let (start_s, end_s) = (first_year * YEAR_S, last_year * YEAR_S);
        // Addresses count doubles from 1.
        let first_address = 385 + data.len() as i32;
        // One record: midpoint, radius, and a constant and a slope for each of x, y, z. Then start, length, size and number of records.
        data.extend([0.5 * (start_s + end_s), 0.5 * (end_s - start_s), 2e8, 0.0, 0.0, 0.0, 0.0, 0.0]);
        data.extend([start_s, end_s - start_s, 8.0, 1.0]);
        let summary = 1024 + 24 + 40 * k;
        put(summary, &start_s.to_le_bytes());
        put(summary + 8, &end_s.to_le_bytes());
        for (i, integer) in [*target, *center, 1, 2, first_address, 384 + data.len() as i32].into_iter().enumerate() {
            put(summary + 16 + 4 * i, &integer.to_le_bytes());
        }
    }
    put(84, &(385 + data.len() as i32).to_le_bytes());
    bytes.extend(data.iter().flat_map(|number| number.to_le_bytes()));
    bytes
}

/// The message for a time at which the kernels have no place of Eros; `None` if they have one.
fn message(kernels: &[Vec<(f64, f64)>], time: &str) -> Option<String> {
    let shipped = Ephemeris::embedded(&Catalog::embedded()).expect("positions");
    let ephemeris =
        kernels.iter().fold(shipped, |ephemeris, spans| ephemeris.with_kernel("eros.bsp", kernel(spans)).expect("a valid kernel"));
    let time = Instant::parse(time).expect("a time");
    ephemeris.state(NaifId(EROS), NaifId(SUN), time, None).err().map(|e| e.to_string())
}

/// Kernels of 2000 to 2010 and 2020 to 2030, in one file or in two, have a gap. Control: no gap is named before the first and after the last segment, nor if a
/// third segment overlaps the gap.
#[test]
fn a_message_names_the_gap_of_a_kernel() {
    let (early, late, between) = ((0.0, 10.0), (20.0, 30.0), (9.0, 20.0));
    let gap = "from 2000-01-01 to 2029-12-31, except from 2009-12-31 to 2020-01-01, not at 2012-01-01T00:00:00Z";
    for kernels in [vec![vec![early, late]], vec![vec![late, early]], vec![vec![late], vec![early]]] {
        assert_eq!(message(&kernels, "2005-01-01T00:00:00Z"), None);
        let text = message(&kernels, "2012-01-01T00:00:00Z").expect("in the gap");
        assert!(text.contains(gap), "{text}");
        for time in ["1990-01-01T00:00:00Z", "2040-01-01T00:00:00Z"] {
            let text = message(&kernels, time).expect("outside");
            assert!(text.contains(&format!("from 2000-01-01 to 2029-12-31, not at {time}")), "{text}");
        }
    }
    let whole = [vec![late, early], vec![between]];
    assert_eq!(message(&whole, "2012-01-01T00:00:00Z"), None);
    let text = message(&whole, "2040-01-01T00:00:00Z").expect("outside");
    assert!(text.contains("from 2000-01-01 to 2029-12-31, not at"), "{text}");
}

/// A date alone would say that the kernel has the time. 2000-01-01T12:00:00 TDB is 11:58:55.816 UTC, and TDB differs from TT by less than 2 ms.
#[test]
fn an_end_on_the_day_of_the_time_has_its_time_of_day() {
    let kernels = [vec![(0.0, 10.0), (20.0, 30.0)]];
    for (time, expected) in [
        ("2000-01-01T00:00:00Z", "from 2000-01-01T11:58:55.81"),
        ("2009-12-31T23:59:30Z", "from 2000-01-01 to 2029-12-31, except from 2009-12-31T23:58:53.81"),
    ] {
        let text = message(&kernels, time).expect("outside");
        assert!(text.contains(expected) && text.contains(&format!("not at {time}")), "{text}");
    }
    // Control: on another day the date suffices.
    let text = message(&kernels, "1999-12-31T00:00:00Z").expect("outside");
    assert!(text.contains("from 2000-01-01 to 2029-12-31, not at 1999-12-31T00:00:00Z"), "{text}");
}

/// With a cycle no chain of centres ends, and nothing relative to it has a place. The shipped kernel has the Moon relative to the Earth, the catalog has Io
/// relative to Jupiter.
#[test]
fn a_kernel_whose_centres_form_a_cycle_is_refused() {
    let error_of = |segments: &[(i32, i32)]| {
        let segments: Vec<_> = segments.iter().map(|(target, center)| (*target, *center, (0.0, 10.0))).collect();
        let shipped = Ephemeris::embedded(&Catalog::embedded()).expect("positions");
        shipped.with_kernel("x.bsp", kernel_of(&segments)).err().map(|e| e.to_string())
    };
    for (segments, cycle) in [
        (&[(EARTH, EARTH)][..], "Earth relative to Earth"),
        (&[(EARTH, MOON)][..], "Earth relative to Moon relative to Earth"),
        (&[(JUPITER, IO)][..], "Jupiter relative to Io relative to Jupiter"),
        (&[(EROS, -31), (-31, EROS)][..], "body -31 relative to"),
    ] {
        let text = error_of(segments).unwrap_or_default();
        assert!(text.starts_with("kernel x.bsp: ") && text.contains(cycle) && !text.contains('\n'), "{cycle}: {text}");
    }
    // Controls: the same pairs the other way round, and a cycle that the kernel itself replaces.
    for segments in [&[(MOON, EARTH)][..], &[(IO, JUPITER)][..], &[(EROS, -31), (-31, SUN)][..], &[(EARTH, MOON), (MOON, 3)][..]] {
        assert_eq!(error_of(segments), None, "{segments:?}");
    }
}
