//! A session that reads the decoded maps stored by an earlier one draws the same images as the session that decoded them.

use crate::support::sweep;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::image::StoredMaps;
use orrery::render::plan::SamplingQuality;
use orrery::scene::request::{Axes, Look, Position, ViewRequest};
use orrery::session::{Session, Sources};
use orrery::time::Instant;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

const STANDARD: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 8 };
const DRAFT: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

fn session(cache: &Path) -> Session {
    let sources = Sources { cache: Some(cache.to_owned()), threads: Some(2), ..Sources::default() };
    Session::open(&sources, |line| panic!("{line}")).expect("opens")
}

/// Five views of each body: whole, at its limb, over its pole and near its ground, in 256 x 256 pixels; and whole in one pixel.
fn views() -> Vec<(String, ViewRequest)> {
    let time = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
    let mut named_requests = Vec::new();
    for (name, body) in [("Earth", 399), ("Moon", 301), ("Mars", 499), ("Saturn", 699), ("Jupiter", 599)] {
        let body = NaifId(body);
        let whole = ViewRequest { width: 256, height: 256, ..ViewRequest::of(body, time) };
        let above = |latitude_deg: f64, height_km: f64| Position::Ground { body, latitude_deg, longitude_deg: 40.0, height_km };
        // The camera looks along the local tangent, so that the limb crosses the image.
        let limb = ViewRequest {
            position: above(10.0, 2000.0),
            look: Look::Along { direction: glam::DVec3::new(-0.9, 0.6, 0.3), axes: Axes::BodyFixed },
            fov_deg: Some(60.0),
            ..whole.clone()
        };
        let pole = ViewRequest { position: above(88.0, 5000.0), fov_deg: Some(40.0), ..whole.clone() };
        let near = ViewRequest { position: above(12.0, 300.0), fov_deg: Some(40.0), ..whole.clone() };
        let one_pixel = ViewRequest { width: 1, height: 1, ..whole.clone() };
        for (view, request) in [("whole", whole), ("limb", limb), ("pole", pole), ("near the ground", near), ("one pixel", one_pixel)] {
            named_requests.push((format!("{name}, {view}"), request));
        }
    }
    named_requests
}

/// The entries that [`StoredMaps`] keeps in this cache, made to look as if they were written in 1970.
fn entries_dated_1970(cache: &Path) -> Vec<PathBuf> {
    let folder = std::fs::read_dir(cache.join("orrery").join("maps")).expect("a folder");
    let entries: Vec<PathBuf> =
        folder.map(|e| e.expect("an entry").path()).filter(|path| path.extension().is_some_and(|e| e == "levels")).collect();
    for path in &entries {
        File::options().write(true).open(path).and_then(|file| file.set_modified(SystemTime::UNIX_EPOCH)).expect("a file");
    }
    entries
}

/// The number of entries that were written again.
fn written_again(entries: &[PathBuf]) -> usize {
    let modified = |path: &PathBuf| path.metadata().and_then(|m| m.modified()).expect("a time");
    entries.iter().filter(|path| modified(path) != SystemTime::UNIX_EPOCH).count()
}

/// A session decodes no map that is stored. If the entries are damaged, it decodes those maps again and draws the same bytes.
#[test]
fn a_session_with_stored_maps_draws_the_same_bytes() {
    let cache = tempfile::tempdir().expect("a folder");
    let draw = |session: &Session, request: &ViewRequest, sampling| {
        let frame = session.draw(request, sampling, FrameImages::DisplayAndHdr).expect("drawn").frame;
        (frame.display, frame.hdr.into_iter().map(|pixel| pixel.map(f32::to_bits)).collect::<Vec<_>>())
    };
    // The first session decodes and stores every map that it needs.
    let decoding = session(cache.path());
    let views = views();
    let drawn: Vec<_> = views.iter().map(|(_, request)| [DRAFT, STANDARD].map(|sampling| draw(&decoding, request, sampling))).collect();
    let stored = StoredMaps::new(cache.path());
    let entry_count = stored.status().entries;
    assert!(entry_count >= 9, "only {entry_count} maps were stored");
    assert_eq!(stored.verify(), (entry_count, Vec::new()));
    let entries = entries_dated_1970(cache.path());
    assert_eq!(entries.len() as u64, entry_count);
    // Each view has a new session, so that no mip level is in memory because of another view.
    for (_, ((name, request), expected)) in views.iter().zip(&drawn).enumerate().filter(|(k, _)| sweep::runs(*k, 3)) {
        let reading = session(cache.path());
        for (sampling, expected) in [DRAFT, STANDARD].into_iter().zip(expected) {
            assert!(draw(&reading, request, sampling) == *expected, "{name}, {sampling:?}");
        }
    }
    assert_eq!((stored.status().entries, written_again(&entries)), (entry_count, 0), "a map was decoded again");
    // Negative control: the views differ, so that equal images are no accident.
    let differing = drawn.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert_eq!(differing, views.len() - 1, "consecutive views with different images");
    // Negative control: a map whose entry is damaged is decoded and stored again.
    entries.iter().for_each(|path| std::fs::write(path, "damaged").expect("written"));
    let damaged = entries_dated_1970(cache.path());
    let saturn = views.iter().position(|(name, _)| name == "Saturn, whole").expect("a view");
    assert!(draw(&session(cache.path()), &views[saturn].1, DRAFT) == drawn[saturn][0], "with damaged entries");
    assert!((1..damaged.len()).contains(&written_again(&damaged)), "{} entries written again", written_again(&damaged));
}
