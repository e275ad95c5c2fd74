//! Reading `[[ring]]`, and the rings of each body.
//!
//! In: TOML tables, and the bodies of all files. Out: the rings of each body, and problems, added to those of the catalog. The rings that a file gives a body
//! replace those of earlier files. Always: a ring begins outside its body's equator. The renderers rely on this: they draw the half of the rings in front of
//! the body's centre over the ground, without a comparison of depths, because from no viewpoint does the ground hide a part of this half.

use super::fields::{ALLOWED_NAME, each_component, is_name, required_number};
use super::table::{Problems, SourceLine, TableReader, WithLine};
use super::{Body, Ring};
use crate::wording::echo_within;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Single-scattering albedo of a ring for which the catalog gives none.
const DEFAULT_RING_ALBEDO: [f64; 3] = [0.5; 3];
/// Maximum number of rings of a body: each has two edges, and the table of edges (`scene::rings`) has room for 4,096.
const MAX_RINGS: usize = 2000;
/// Rings end below this radius, in equatorial radii of the body; the query `ring-transmission` has the same limit. In f32 the squares of much larger radii
/// overflow. The largest known ring, Phoebe's, ends at 270.
const MAX_RADII: f64 = 1e6;
/// Maximum number of characters that messages quote of a body's name.
const NAME_ECHO_CHARS: usize = 60;

/// A ring as it was read.
struct RingDraft {
    ring: Ring,
    inner_line: SourceLine,
    outer_line: SourceLine,
}

/// The rings of a file whose field `body` is the same name.
pub(super) struct RingsOfFile {
    body_name: WithLine<String>,
    rings: Vec<RingDraft>,
}

/// Reads a `[[ring]]`: the body's name and the ring; `None` if a required field is missing or invalid, which is reported.
fn ring(mut table: TableReader) -> Option<(WithLine<String>, RingDraft)> {
    let body_name = table.required("body", "the name of a body", |_: &String| true);
    let name = table.required("name", ALLOWED_NAME, is_name);
    let inner_km = table.required("inner_km", "kilometres above 0", |x: &f64| x.is_finite() && *x > 0.0);
    let outer_km = table.required("outer_km", "kilometres above inner_km", |x: &f64| {
        x.is_finite() && inner_km.as_ref().is_none_or(|inner| *x > inner.value)
    });
    let tau_normal = required_number(&mut table, "tau_normal", "an optical depth from 0 to 100", |x| (0.0..=100.0).contains(&x));
    let albedo = table.optional("albedo", "three numbers from 0 to 1 (red, green, blue)", each_component(|x| (0.0..=1.0).contains(&x)));
    // The fraction of the scattered light.
    let dust = table.optional("dust", "a fraction from 0 to 1", |x: &f64| (0.0..=1.0).contains(x));
    table.finish();
    let (body_name, inner_km, outer_km) = (body_name?, inner_km?, outer_km?);
    let ring = Ring {
        name: name?.value,
        inner_km: inner_km.value,
        outer_km: outer_km.value,
        tau_normal: tau_normal?,
        albedo: albedo.map_or(DEFAULT_RING_ALBEDO, |a| a.value),
        dust_fraction: dust.map_or(0.0, |d| d.value),
    };
    Some((body_name, RingDraft { ring, inner_line: inner_km.source_line, outer_line: outer_km.source_line }))
}

/// Reads the `[[ring]]` tables of a file.
pub(super) fn rings_of_file(tables: Vec<TableReader>) -> Vec<RingsOfFile> {
    let mut found: Vec<RingsOfFile> = Vec::new();
    for (body_name, ring) in tables.into_iter().filter_map(ring) {
        match found.iter_mut().find(|r| r.body_name.value == body_name.value) {
            Some(of_body) => of_body.rings.push(ring),
            None => found.push(RingsOfFile { body_name, rings: vec![ring] }),
        }
    }
    found
}

/// Gives each body its rings. `find_id`: the NAIF code of the body with a name; reports an unknown name. `radii_lines`: the line of the field `radii_km`, by
/// NAIF code.
pub(super) fn add_to_bodies(
    rings: Vec<RingsOfFile>,
    bodies: &mut [Body],
    find_id: impl Fn(&WithLine<String>) -> Option<i32>,
    radii_lines: &BTreeMap<i32, SourceLine>,
    problems: &Problems,
) {
    // For each body the last file that gives rings, and these rings. By the body's id and not by its name, because a file may name a body in several ways: as
    // `Saturn`, `saturn` or an alias.
    let mut rings_by_body: BTreeMap<i32, (Rc<str>, Vec<RingDraft>)> = BTreeMap::new();
    for RingsOfFile { body_name, rings } in rings {
        let Some(id) = find_id(&body_name) else { continue };
        let file = &body_name.source_line.file;
        let (kept_file, kept) = rings_by_body.entry(id).or_insert_with(|| (Rc::clone(file), Vec::new()));
        if !Rc::ptr_eq(kept_file, file) {
            *kept_file = Rc::clone(file);
            kept.clear();
        }
        kept.extend(rings);
        if kept.len() > MAX_RINGS {
            let (body, count) = (echo_within(&body_name.value, NAME_ECHO_CHARS), kept.len());
            problems.add(&body_name.source_line, format!("{body} has {count} rings: expected at most {MAX_RINGS}"));
        }
    }
    for body in bodies {
        let Some((_, kept)) = rings_by_body.remove(&body.id.0) else { continue };
        report_impossible_radii(&kept, body, radii_lines.get(&body.id.0), problems);
        body.rings = kept.into_iter().map(|draft| draft.ring).collect();
    }
}

/// Reports rings that begin inside the body or end too far away. If the rings are shipped ones and the radii of the body are the user's, the message names
/// the line of the radii.
fn report_impossible_radii(rings: &[RingDraft], body: &Body, radii_line: Option<&SourceLine>, problems: &Problems) {
    let equator_km = body.radii_km.x.max(body.radii_km.y);
    let limit_km = MAX_RADII * equator_km;
    let innermost_km = rings.iter().map(|r| r.ring.inner_km).fold(f64::INFINITY, f64::min);
    let outermost_km = rings.iter().map(|r| r.ring.outer_km).fold(0.0, f64::max);
    let name = echo_within(&body.name, NAME_ECHO_CHARS);
    // `ring_problem` and `expected_radius` end the two messages.
    let report = |ring_line: &SourceLine, ring_problem: String, expected_radius: String| {
        match radii_line.filter(|radii| ring_line.is_embedded() && !radii.is_embedded()) {
            // For each ring the same message; it is shown once.
            Some(radii_line) => problems.add(radii_line, format!("{name}.radii_km: expected an equatorial radius {expected_radius}")),
            None => problems.add(ring_line, format!("ring.{ring_problem}, the equatorial radius of {name}")),
        }
    };
    for RingDraft { ring: Ring { inner_km, outer_km, .. }, inner_line, outer_line } in rings {
        if *inner_km <= equator_km {
            let field = format!("inner_km = {inner_km:?}: expected kilometres above {equator_km:?}");
            report(inner_line, field, format!("below {innermost_km:?} km, where its rings begin"));
        }
        if *outer_km >= limit_km {
            let field = format!("outer_km = {outer_km:?}: expected kilometres below {limit_km:?}, a million times {equator_km:?}");
            report(outer_line, field, format!("above {:?} km, a millionth of that of its rings", outermost_km / MAX_RADII));
        }
    }
}
