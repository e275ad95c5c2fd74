//! SPK kernels. In: the bytes of a file. Out: states of bodies relative to the centre of their segment, or to another body of the file.
//!
//! The crate anise reads and checks the file (record layout, byte order, segment bounds). The coefficients are stored here as plain
//! doubles and summed in `chebyshev`: anise's own evaluation converts to an epoch in nanoseconds, which costs more than the sum.
//! Always: a segment covers its span without a gap, in records of equal length, so that a division gives the record of an instant. Types 2
//! (Chebyshev positions) and 3 (positions and velocities) are read; other types are rejected by name. A file is rejected before anise reads it
//! if its chain of summary records leaves the file or returns to a record, because anise would follow it for ever.

use super::chebyshev::value_and_slope;
use super::{EphemerisError, State};
use crate::unwinding::catch_panic;
use anise::naif::SPK;
use anise::naif::daf::{DafDataType, NAIFSummaryRecord, datatypes::Type2ChebyshevSet, datatypes::Type3ChebyshevSet};
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// Bytes of a record of a DAF file, the container of SPK. The *file record*, the *summary records* and the *name records* are such records. A
/// record of a segment is something else: a set of Chebyshev coefficients.
const DAF_RECORD_BYTES: usize = 1024;
/// Largest number of links from a body to its centre, from this to the centre's own centre and so on, that [`Spk::state`] follows.
const MAX_CENTRES: usize = 16;
/// Maximum number of summaries in a record of an SPK: (128 - 3) doubles, 5 per summary.
const MAX_SUMMARIES: f64 = 25.0;

/// Walks the chain of summary records. Each begins with three doubles: the number of the next summary record, the number of the previous one, and the count of
/// its summaries. Records are numbered from 1, and the last summary record names 0 as the next (NAIF's DAF Required Reading).
///
/// # Errors
/// Names the record that is outside the file, occurs twice, or has an impossible number of summaries.
fn check_summary_records(bytes: &[u8]) -> Result<(), String> {
    let record_count = bytes.len() / DAF_RECORD_BYTES;
    // The number of the first summary record: FWARD in the file record.
    let first_record = bytes.get(76..80).and_then(|b| b.try_into().ok()).map_or(0, i32::from_le_bytes);
    let mut seen = HashSet::new();
    let mut number = f64::from(first_record);
    loop {
        if number.fract() != 0.0 || !(1.0..=record_count as f64).contains(&number) {
            return Err(format!("summary record {number} is not in the file, which has {record_count} records; fetch the file again"));
        }
        if !seen.insert(number as usize) {
            return Err(format!("summary record {number} follows itself; fetch the file again"));
        }
        let start = (number as usize - 1) * DAF_RECORD_BYTES;
        // The double with index `k` of the record.
        let double =
            |k: usize| bytes.get(start + 8 * k..start + 8 * k + 8).and_then(|b| b.try_into().ok()).map_or(f64::NAN, f64::from_le_bytes);
        let (next, count) = (double(0), double(2));
        if count.fract() != 0.0 || !(0.0..=MAX_SUMMARIES).contains(&count) {
            return Err(format!("summary record {number} has {count} summaries, the most are {MAX_SUMMARIES}; fetch the file again"));
        }
        if next == 0.0 {
            return Ok(());
        }
        number = next;
    }
}

/// A segment: one body's states over a span, as records of Chebyshev coefficients.
#[derive(Debug)]
pub struct Segment {
    /// NAIF code of the body.
    pub target: i32,
    /// NAIF code of the origin of the body's states.
    pub center: i32,
    /// Start of the covered span, TDB seconds past J2000.
    pub start_s: f64,
    /// End of the covered span, TDB seconds past J2000.
    pub end_s: f64,
    /// Start of the first record, TDB seconds past J2000.
    first_s: f64,
    /// Time that each record covers.
    record_span_s: f64,
    /// Doubles in a record: midpoint and radius (half the length) of its time span in seconds, then one row of coefficients per component.
    record_len: usize,
    /// 3: positions; 6: positions and velocities.
    components: usize,
    /// The records one after another.
    data: Vec<f64>,
}

impl Segment {
    /// Whether the segment covers an instant, its ends included.
    fn covers(&self, tdb_s: f64) -> bool {
        tdb_s >= self.start_s && tdb_s <= self.end_s
    }

    /// Position in km and velocity in km/s of the target relative to the centre, ICRF.
    pub fn state(&self, tdb_s: f64) -> State {
        let record_count = self.data.len() / self.record_len;
        let index = (((tdb_s - self.first_s) / self.record_span_s).max(0.0) as usize).min(record_count - 1);
        let record = &self.data[index * self.record_len..][..self.record_len];
        let (midpoint_s, radius_s) = (record[0], record[1]);
        // The argument of the polynomials, -1 to 1.
        let u = (tdb_s - midpoint_s) / radius_s;
        let terms = (self.record_len - 2) / self.components;
        let row = |k: usize| &record[2 + k * terms..][..terms];
        let [(x, x_slope), (y, y_slope), (z, z_slope)] = [0, 1, 2].map(|k| value_and_slope(row(k), u));
        let vel_km_s = match self.components {
            6 => DVec3::from_array([3, 4, 5].map(|k| value_and_slope(row(k), u).0)),
            _ => DVec3::new(x_slope, y_slope, z_slope) / radius_s,
        };
        State { pos_km: DVec3::new(x, y, z), vel_km_s }
    }
}

/// A kernel file in memory, indexed by target.
#[derive(Debug)]
pub struct Spk {
    /// The name given to [`Self::parse`].
    pub name: String,
    /// Segments by the target's NAIF code, in order of precedence.
    by_target: HashMap<i32, Vec<Segment>>,
}

impl Spk {
    /// Reads the bytes of an SPK file. `name` is used only in errors.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Self, EphemerisError> {
        catch_panic(|| Self::read(name, bytes))
            .unwrap_or_else(|| Err(EphemerisError::other(format!("kernel {name}: damaged; fetch the file again"))))
    }

    /// As [`Self::parse`], but damaged bytes may make anise panic.
    fn read(name: &str, bytes: &[u8]) -> Result<Self, EphemerisError> {
        let kernel_error = |what: String| EphemerisError::other(format!("kernel {name}: {}", what.replace('\n', " ")));
        if !bytes.starts_with(b"DAF/SPK") {
            return Err(kernel_error("not an SPK file (it does not begin with DAF/SPK); give a file such as de440.bsp".into()));
        }
        // The file record's field for the byte order.
        if bytes.get(88..96) == Some(b"BIG-IEEE") {
            return Err(kernel_error("its numbers are big-endian; NAIF's program bingo makes a little-endian file of it".into()));
        }
        check_summary_records(bytes).map_err(kernel_error)?;
        let mut by_target: HashMap<i32, Vec<Segment>> = HashMap::new();
        let spk = SPK::parse(bytes).map_err(|e| kernel_error(e.to_string()))?;
        let mut doubles_left = bytes.len() / size_of::<f64>();
        // Number of the summary record, from 1; `None` for the first one of the file.
        let mut summary_record = None;
        loop {
            for (index, summary) in spk.data_summaries(summary_record).map_err(|e| kernel_error(e.to_string()))?.iter().enumerate() {
                if summary.is_empty() {
                    continue;
                }
                let (target, center, frame) = (summary.target_id, summary.center_id, summary.frame_id);
                if frame != 1 {
                    return Err(kernel_error(format!("segment of {target}: frame {frame}; only ICRF (1) is read")));
                }
                let segment_error = |e: &dyn std::fmt::Display| kernel_error(format!("segment of {target}: {e}"));
                let (record_len, components, data) = match summary.data_type().map_err(|e| segment_error(&e))? {
                    DafDataType::Type2ChebyshevTriplet => {
                        let set: Type2ChebyshevSet = spk.nth_data(summary_record, index).map_err(|e| segment_error(&e))?;
                        (set.rsize, 3, set.record_data.get(..set.rsize * set.num_records).unwrap_or(&[]))
                    }
                    DafDataType::Type3ChebyshevSextuplet => {
                        let set: Type3ChebyshevSet = spk.nth_data(summary_record, index).map_err(|e| segment_error(&e))?;
                        (set.rsize, 6, set.record_data.get(..set.rsize * set.num_records).unwrap_or(&[]))
                    }
                    other => return Err(kernel_error(format!("segment of {target}: data of kind {other:?}; types 2 and 3 are read"))),
                };
                // Segments that share their records would let a small file allocate any amount of memory.
                doubles_left = doubles_left.checked_sub(data.len()).ok_or_else(|| {
                    kernel_error(format!("segment of {target}: the segments hold more than the file; fetch the file again"))
                })?;
                let segment = Segment {
                    target,
                    center,
                    start_s: summary.start_epoch_et_s,
                    end_s: summary.end_epoch_et_s,
                    first_s: data.first().zip(data.get(1)).map_or(f64::NAN, |(midpoint, radius)| midpoint - radius),
                    record_span_s: data.get(1).map_or(f64::NAN, |radius| 2.0 * radius),
                    record_len,
                    components,
                    data: data.to_vec(),
                };
                let is_complete = record_len >= 2 + components && (record_len - 2).is_multiple_of(components) && data.len() >= record_len;
                if !is_complete || !segment.record_span_s.is_finite() || segment.record_span_s <= 0.0 || data.iter().any(|d| !d.is_finite())
                {
                    return Err(kernel_error(format!("segment of {target}: broken records; fetch the file again")));
                }
                // A summary may claim a longer span than its records cover, and a polynomial diverges outside its record.
                let records_end_s = segment.first_s + (data.len() / record_len) as f64 * segment.record_span_s;
                let (start_s, end_s) = (segment.start_s.max(segment.first_s), segment.end_s.min(records_end_s));
                let segment = Segment { start_s, end_s, ..segment };
                // A later segment of a file has precedence over an earlier one (SPK Required Reading).
                by_target.entry(target).or_default().insert(0, segment);
            }
            let summary = spk.daf_summary(summary_record).map_err(|e| kernel_error(e.to_string()))?;
            if summary.is_final_record() || summary.is_corrupt() {
                break;
            }
            summary_record = Some(summary.next_record());
        }
        if by_target.is_empty() {
            return Err(kernel_error("no segments".into()));
        }
        Ok(Self { name: name.to_owned(), by_target })
    }

    /// The centre of the segment that covers the instant, and the state of `target` relative to this centre; `None` if no segment covers the instant.
    pub fn state_and_center(&self, target: i32, tdb_s: f64) -> Option<(i32, State)> {
        self.segment(target, tdb_s).map(|segment| (segment.center, segment.state(tdb_s)))
    }

    /// All segments; those of one target in order of precedence.
    pub fn segments(&self) -> impl Iterator<Item = &Segment> + '_ {
        self.by_target.values().flatten()
    }

    /// The segment of `target` that covers the instant, by precedence; `None` if there is none.
    pub fn segment(&self, target: i32, tdb_s: f64) -> Option<&Segment> {
        self.by_target.get(&target)?.iter().find(|s| s.covers(tdb_s))
    }

    /// The spans that the segments of `target` cover, TDB seconds past J2000, in order of precedence.
    pub fn spans(&self, target: i32) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.by_target.get(&target).into_iter().flatten().map(|s| (s.start_s, s.end_s))
    }

    /// The first and the last TDB second past J2000 that any segment of `target` covers; there may be gaps between them. `None` if
    /// `target` has no segment.
    pub fn coverage(&self, target: i32) -> Option<(f64, f64)> {
        self.spans(target).reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
    }

    /// State of `target` relative to `center` from this file only: both are followed from centre to centre up to a common one. `None` if there is none.
    pub fn state(&self, target: i32, center: i32, tdb_s: f64) -> Option<State> {
        // The body and the centres above it, each with the body's state relative to this centre.
        let chain_of_centres = |mut id: i32| {
            let mut path = vec![(id, State::REST)];
            while let Some((next_center, link_state)) = self.state_and_center(id, tdb_s) {
                let (_, so_far) = path[path.len() - 1];
                path.push((next_center, so_far.plus(link_state)));
                id = next_center;
                // A damaged file may name a cycle of centres.
                if path.len() > MAX_CENTRES {
                    break;
                }
            }
            path
        };
        let (target_chain, center_chain) = (chain_of_centres(target), chain_of_centres(center));
        target_chain.iter().find_map(|(id, target_state)| {
            let (_, center_state) = center_chain.iter().find(|(other, _)| other == id)?;
            Some(target_state.minus(*center_state))
        })
    }

    /// NAIF codes of the bodies that have segments, in no particular order.
    pub fn targets(&self) -> impl Iterator<Item = i32> + '_ {
        self.by_target.keys().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_not_kernels_are_rejected() {
        for bytes in [&b""[..], &b"PNG"[..], &b"DAF/SPK "[..], &[b'D'; 4096][..]] {
            let error = Spk::parse("x.bsp", bytes).expect_err("not a kernel").to_string();
            assert!(error.starts_with("kernel x.bsp: ") && !error.contains('\n'));
        }
        let mut cut = b"DAF/SPK ".to_vec();
        cut.resize(3000, 0);
        assert!(Spk::parse("x.bsp", &cut).is_err());
    }

    #[test]
    fn a_truncated_kernel_is_refused_in_one_line() {
        let whole = orrery_catalogs::PLUTO_KERNEL;
        assert!(Spk::parse("x.bsp", whole).is_ok());
        for tenths in 1..10 {
            let error = Spk::parse("x.bsp", &whole[..whole.len() * tenths / 10]).expect_err("cut short").to_string();
            assert!(error.starts_with("kernel x.bsp: ") && !error.contains('\n'), "{error}");
        }
    }

    /// A little-endian file of one segment of one record: Earth (399) from the Earth-Moon barycentre (3), ICRF, -100 to 100 s.
    fn file_of(data_type: i32, record: &[f64]) -> Vec<u8> {
        let mut data = record.to_vec();
        // The segment's directory: start and length in seconds of the first record, doubles per record, number of records.
        data.extend([-100.0, 200.0, record.len() as f64, 1.0]);
        // Addresses count doubles from 1: the data begin in the fourth record of 128 doubles.
        let (first, last) = (385, 384 + data.len() as i32);
        let mut bytes = vec![0; 4 * 1024];
        let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
        // The file record: ID, ND, NI, name, FWARD, BWARD, FREE, format, FTP test string.
        put(0, b"DAF/SPK ");
        put(8, &2_i32.to_le_bytes());
        put(12, &6_i32.to_le_bytes());
        put(16, &[b' '; 60]);
        put(76, &2_i32.to_le_bytes());
        put(80, &2_i32.to_le_bytes());
        put(84, &(last + 1).to_le_bytes());
        put(88, b"LTL-IEEE");
        put(699, b"FTPSTR:\r:\n:\r\n:\r\0:\x81:\x10\xce:ENDFTP");
        // The summary record: the count, 1, and one summary (start, end, then the integers). Then a blank name record, and the data.
        put(1024 + 16, &1.0_f64.to_le_bytes());
        put(1024 + 24, &(-100.0_f64).to_le_bytes());
        put(1024 + 32, &100.0_f64.to_le_bytes());
        for (i, integer) in [399, 3, 1, data_type, first, last].into_iter().enumerate() {
            put(1024 + 40 + 4 * i, &i32::to_le_bytes(integer));
        }
        put(2048, &[b' '; 1024]);
        for (i, number) in data.iter().enumerate() {
            put(3072 + 8 * i, &number.to_le_bytes());
        }
        bytes
    }

    #[test]
    fn type_3_takes_its_velocities_from_the_file() {
        // Midpoint, radius, then two coefficients of x, y, z and of their velocities, which differ from the slopes of the positions.
        let record = [0.0, 100.0, 1.0, 10.0, 2.0, 20.0, 3.0, 30.0, 7.0, 0.5, 8.0, 0.25, 9.0, -1.0];
        let spk = Spk::parse("x.bsp", &file_of(3, &record)).expect("a kernel");
        // Half a radius after the midpoint, so the values are first coefficient + second / 2.
        let (center, state) = spk.state_and_center(399, 50.0).expect("the Earth");
        assert_eq!(center, 3);
        assert!((state.pos_km - DVec3::new(6.0, 12.0, 18.0)).length() < 1e-12, "{}", state.pos_km);
        assert!((state.vel_km_s - DVec3::new(7.25, 8.125, 8.5)).length() < 1e-12, "{}", state.vel_km_s);
        assert!(spk.state_and_center(399, 100.5).is_none() && spk.state_and_center(301, 50.0).is_none());
        // With type 2, the velocity is the slope of the same positions: the second coefficient over the radius of 100 s.
        let spk = Spk::parse("x.bsp", &file_of(2, &record[..8])).expect("a kernel");
        let (_, state) = spk.state_and_center(399, 50.0).expect("the Earth");
        assert!((state.vel_km_s - DVec3::new(0.1, 0.2, 0.3)).length() < 1e-12, "{}", state.vel_km_s);
    }

    /// The summary claims -100 to 300 s, the only record ends at 100 s. Its polynomial would give any position beyond.
    #[test]
    fn a_segment_covers_no_more_than_its_records() {
        let mut bytes = file_of(2, &[0.0, 100.0, 1.0, 10.0, 2.0, 20.0, 3.0, 30.0]);
        bytes[1024 + 32..1024 + 40].copy_from_slice(&300.0_f64.to_le_bytes());
        let spk = Spk::parse("x.bsp", &bytes).expect("a kernel");
        assert_eq!(spk.coverage(399), Some((-100.0, 100.0)));
        assert!(spk.state_and_center(399, 100.0).is_some() && spk.state_and_center(399, 250.0).is_none());
    }

    #[test]
    fn rejections_of_kernels_state_the_reason() {
        let record = [0.0, 100.0, 1.0, 10.0, 2.0, 20.0, 3.0, 30.0];
        let mut big = file_of(2, &record);
        big[88..96].copy_from_slice(b"BIG-IEEE");
        let mut other_frame = file_of(2, &record);
        other_frame[1024 + 48..1024 + 52].copy_from_slice(&17_i32.to_le_bytes());
        let mut with_nan = record;
        with_nan[3] = f64::NAN;
        for (bytes, word) in [
            (big, "big-endian"),
            (other_frame, "frame 17"),
            // A type that is known to anise but not read here, then an unknown one.
            (file_of(13, &record), "types 2 and 3 are read"),
            (file_of(99, &record), "segment of 399"),
            (file_of(2, &with_nan), "segment of 399"),
            (file_of(2, &record[..7]), "segment of 399"),
        ] {
            let error = Spk::parse("x.bsp", &bytes).expect_err(word).to_string();
            assert!(error.starts_with("kernel x.bsp: ") && error.contains(word) && !error.contains('\n'), "{word}: {error}");
        }
    }

    #[test]
    fn a_chain_of_records_that_never_ends_is_refused_at_once() {
        let record = [0.0, 100.0, 1.0, 10.0, 2.0, 20.0, 3.0, 30.0];
        let whole = file_of(2, &record);
        let with = |at: usize, number: f64| {
            let mut bytes = whole.clone();
            bytes[at..at + 8].copy_from_slice(&number.to_le_bytes());
            bytes
        };
        let (next_offset, count_offset) = (1024, 1024 + 16);
        for (bytes, word) in [
            (with(next_offset, 2.0), "summary record 2 follows itself"),
            (with(next_offset, 1e9), "is not in the file, which has 4 records"),
            (with(next_offset, -1.0), "is not in the file"),
            (with(next_offset, 0.5), "is not in the file"),
            (with(next_offset, f64::NAN), "is not in the file"),
            (with(count_offset, 1e18), "the most are 25"),
            (with(count_offset, -1.0), "the most are 25"),
        ] {
            let error = Spk::parse("x.bsp", &bytes).expect_err(word).to_string();
            assert!(error.starts_with("kernel x.bsp: ") && error.contains(word) && !error.contains('\n'), "{word}: {error}");
        }
        assert!(Spk::parse("x.bsp", &whole).is_ok());
    }

    /// Each summary of a record may name the same data: a file of some kilobytes must not cause larger allocations than its own size.
    #[test]
    fn segments_that_share_their_records_are_refused() {
        let mut bytes = file_of(2, &[0.0, 100.0, 1.0, 10.0, 2.0, 20.0, 3.0, 30.0]);
        // One record of 122 doubles, a quarter of the file's 512, named by as many summaries as fit.
        let (first, last, record_len) = (385_i32, 510_i32, 122.0_f64);
        let summary = bytes[1024 + 24..1024 + 64].to_vec();
        for k in 0..25 {
            let offset = 1024 + 24 + 40 * k;
            bytes[offset..offset + 40].copy_from_slice(&summary);
            bytes[offset + 32..offset + 36].copy_from_slice(&first.to_le_bytes());
            bytes[offset + 36..offset + 40].copy_from_slice(&last.to_le_bytes());
        }
        bytes[1024 + 16..1024 + 24].copy_from_slice(&25.0_f64.to_le_bytes());
        let record = [0.0, 100.0].into_iter().chain(std::iter::repeat_n(1.0, 120)).chain([-100.0, 200.0, record_len, 1.0]);
        for (k, number) in record.enumerate() {
            bytes[3072 + 8 * k..3080 + 8 * k].copy_from_slice(&f64::to_le_bytes(number));
        }
        let error = Spk::parse("x.bsp", &bytes).expect_err("shared records").to_string();
        assert!(error.contains("the segments hold more than the file"), "{error}");
    }

    /// Every double and every integer of the headers is replaced by extremes: the reader may return anything, but must not panic.
    #[test]
    fn no_number_in_the_headers_makes_the_reader_panic() {
        let whole = file_of(3, &[0.0, 100.0, 1.0, 10.0, 2.0, 20.0, 3.0, 30.0, 7.0, 0.5, 8.0, 0.25, 9.0, -1.0]);
        // The file record and the start of the summary record; the data, 14 doubles of the record and 4 of the directory.
        let offsets = (0..1024 + 64).chain(3072..3072 + 18 * 8);
        for at in offsets.step_by(4) {
            for whole_number in [-1_i32, 0, 1, 127, 384, 386, i32::MAX, i32::MIN] {
                let mut bytes = whole.clone();
                bytes[at..at + 4].copy_from_slice(&whole_number.to_le_bytes());
                drop(Spk::parse("x.bsp", &bytes));
            }
            for number in [-1.0, 0.0, 0.5, 3.0, 1e-308, 1e9, 1e19, -1e300, f64::INFINITY, f64::NAN] {
                let mut bytes = whole.clone();
                bytes[at..at + 8].copy_from_slice(&f64::to_le_bytes(number));
                drop(Spk::parse("x.bsp", &bytes));
            }
        }
    }
}
