//! Reads catalog files: one draft per body, in which later files override earlier ones, then a check of the entire catalog.
//!
//! In: (name, text) pairs. Out: a [`Catalog`], or all problems, each with its file and line. A field of a later file replaces the same field of earlier ones.
//! Photometry, motion, rotation, clouds, mesh, atmosphere and the set of rings are replaced as a whole; maps one by one; overlays, instruments and moments by
//! name. Data layers are never replaced.

use super::data_layer;
use super::fields::{ALLOWED_NAME, each_component, finite, is_name, optional_percent, required_number, with_line};
use super::instrument::{Instrument, instrument};
use super::layer_list::LayerList;
use super::overlay;
use super::read_body::{BodyDraft, body};
use super::read_ring::{self, RingsOfFile, rings_of_file};
use super::table::{Problems, SourceLine, TableReader, TomlFile, WithLine};
use super::{
    AerosolField, AerosolFunction, AerosolPhase, Atmosphere, Body, BodyField, BodyKind, Catalog, CatalogError, EclipseRadii, FileLine,
    NaifId, Overlay, PerChannel, PhaseFunction, Species, is_name_of_barycenter, moments, normalized_name,
};
use crate::wording::echo_within;
use glam::{DVec3, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

/// Reads a `[[atmosphere.species]]`; `None` if a required field is missing or invalid, which is reported.
fn species(mut table: TableReader) -> Option<Species> {
    let per_km = "three numbers from 0 to 10 per kilometre";
    let name = table.required("name", ALLOWED_NAME, is_name);
    let scale_height_km = required_number(&mut table, "scale_height_km", "kilometres above 0", |x| x > 0.0);
    let tent_centre_km = table.optional("tent_centre_km", "kilometres from 0", |x: &f64| finite(x) && *x >= 0.0);
    let scattering = table.optional("scattering_per_km", per_km, each_component(|x| (0.0..=10.0).contains(&x)));
    let absorption = table.optional("absorption_per_km", per_km, each_component(|x| (0.0..=10.0).contains(&x)));
    let phase = phase_function(&mut table, AerosolPhase::FIELDS);
    let estimate_percent = optional_percent(&mut table, "estimate_percent");
    table.finish();
    Some(Species {
        name: name?.value,
        scale_height_km: scale_height_km?,
        tent_centre_km: tent_centre_km.map(|l| l.value),
        scattering_per_km: scattering.map_or([0.0; 3], |l| l.value),
        absorption_per_km: absorption.map_or([0.0; 3], |l| l.value),
        phase,
        estimate_percent,
    })
}

/// Reads the phase function of a species: Rayleigh's, unless the first of `fields` is present; then an aerosol's, to which `phase` and the other fields belong.
fn phase_function(table: &mut TableReader, fields: &[AerosolField]) -> PhaseFunction {
    let first_key = fields[0].catalog_key;
    let is_aerosol = table.has(first_key);
    let first_beside_it = format!("`{first_key}` beside it");
    let allowed = if is_aerosol { AerosolFunction::words(&AerosolFunction::ALL) } else { first_beside_it.clone() };
    let word = table.optional("phase", &allowed, |word: &String| is_aerosol && AerosolFunction::of_word(word).is_some());
    let function = word.and_then(|l| AerosolFunction::of_word(&l.value)).unwrap_or(AerosolFunction::OF_CATALOGS);
    let mut aerosol = AerosolPhase::of(function);
    for field in fields {
        let is_of_function = field.functions.contains(&function);
        let allowed = if !is_aerosol {
            first_beside_it.clone()
        } else if is_of_function {
            field.allowed()
        } else {
            format!("`phase = {}` beside it", AerosolFunction::words(field.functions))
        };
        // `set` returns `None` for a value that the field may not have.
        let is_allowed = |value: &PerChannel| is_aerosol && is_of_function && field.set(aerosol, *value).is_some();
        let value = table.optional(field.catalog_key, &allowed, is_allowed);
        aerosol = value.and_then(|l| field.set(aerosol, l.value)).unwrap_or(aerosol);
    }
    if is_aerosol { PhaseFunction::Aerosol(aerosol) } else { PhaseFunction::Rayleigh }
}

/// Number of species above which an atmosphere is rejected unread: a file of one megabyte could list thousands. A valid atmosphere has at most three.
const MAX_SPECIES: usize = 16;

/// What [`is_forward_light`] accepts, for messages.
const ALLOWED_FORWARD_LIGHT: &str =
    "up to 100 rows: a phase angle from 0 to 180 degrees, ascending, then three numbers from 0 to 10 (red, green, blue)";

/// Whether these rows may be an atmosphere's `forward_light`.
fn is_forward_light(rows: &[[f64; 4]]) -> bool {
    let is_row = |[phase_deg, rgb @ ..]: &[f64; 4]| (0.0..=180.0).contains(phase_deg) && rgb.iter().all(|x| (0.0..=10.0).contains(x));
    rows.len() <= 100 && rows.iter().all(is_row) && rows.windows(2).all(|pair| pair[0][0] < pair[1][0])
}

/// What [`is_limb_haze`] accepts, for messages.
const ALLOWED_LIMB_HAZE: &str = "two numbers of kilometres: a height from 0 to 10000, and a scale height from 0.1 to 10000";

/// Whether this may be an atmosphere's `limb_haze_km`.
fn is_limb_haze([height_km, scale_height_km]: &[f64; 2]) -> bool {
    (0.0..=1e4).contains(height_km) && (0.1..=1e4).contains(scale_height_km)
}

/// Reads an `[[atmosphere]]`: the body's name and the atmosphere; `None` without a valid `body` and `top_km`, or with too many species, which is reported.
fn atmosphere(mut table: TableReader) -> Option<(WithLine<String>, Atmosphere)> {
    let body_name = table.required("body", "the name of a body", |_: &String| true);
    let top_km = required_number(&mut table, "top_km", "kilometres above 0", |x| x > 0.0);
    let refractivity = table.optional("refractivity", "a number above 0 and below 0.01", |x: &f64| *x > 0.0 && *x < 0.01).map(|l| l.value);
    let limb_haze_km = table.optional("limb_haze_km", ALLOWED_LIMB_HAZE, is_limb_haze).map(|l| l.value);
    let airglow_cd_m2 =
        table.optional("airglow_cd_m2", "candelas a square metre from 0 to 1", |x: &f64| (0.0..=1.0).contains(x)).map(|l| l.value);
    let forward_light = table.optional("forward_light", ALLOWED_FORWARD_LIGHT, |rows: &Vec<[f64; 4]>| is_forward_light(rows));
    let sections = table.sections("species");
    if let Some(section) = sections.get(MAX_SPECIES) {
        table.report_invalid(&section.source_line, "species", &sections.len().to_string(), &format!("at most {MAX_SPECIES} species"));
        return None;
    }
    let species: Vec<WithLine<Species>> = sections.into_iter().filter_map(|section| with_line(section, species)).collect();
    report_second_of_a_kind(&table, &species);
    let _ = table.optional::<String>("source", "a string", |_| true);
    table.finish();
    let species = species.into_iter().map(|l| l.value).collect();
    let forward_light = forward_light.map_or_else(Vec::new, |l| l.value);
    Some((body_name?, Atmosphere { top_km: top_km?, refractivity, limb_haze_km, airglow_cd_m2, forward_light, species }))
}

/// Reports a second gas, aerosol or absorption layer: a draw has one of each, and would leave out a second one.
fn report_second_of_a_kind(table: &TableReader, species: &[WithLine<Species>]) {
    type IsOfKind = fn(&Species) -> bool;
    let kinds: [(&str, IsOfKind); 3] = [
        ("gas (a species without `asymmetry`); a mixture of gases is one", Species::is_gas),
        ("aerosol (a species with `asymmetry`)", |s| s.aerosol_phase().is_some()),
        ("absorption layer (a species with `tent_centre_km`)", |s| s.tent_centre_km.is_some()),
    ];
    for (kind, is_of_kind) in kinds {
        if let Some(second) = species.iter().filter(|s| is_of_kind(&s.value)).nth(1) {
            let name = format!("\"{}\"", echo_within(&second.value.name, 60));
            table.report_invalid(&second.source_line, "species", &name, &format!("at most one {kind}"));
        }
    }
}

/// Reads every file; later files override earlier ones. All problems are returned together.
pub(super) fn read(files: &[(&str, &str)]) -> Result<Catalog, CatalogError> {
    let problems = Problems::default();
    let mut drafts = BTreeMap::new();
    let mut rings = Vec::new();
    let mut atmospheres = Vec::new();
    let mut overlays = Vec::new();
    let mut unresolved_moments = Vec::new();
    let mut layers = Vec::new();
    let mut instruments: Vec<Instrument> = Vec::new();
    let mut all_are_toml = true;
    for (file, text) in files {
        let toml_file = TomlFile::new(file, text, &problems);
        let Some(mut root) = toml_file.root() else {
            all_are_toml = false;
            continue;
        };
        let mut first_lines = BTreeMap::new();
        for id in root.sections("body").into_iter().filter_map(|table| body(table, &mut drafts)) {
            if let Some(first) = first_lines.get(&id.value) {
                let why =
                    format!("[[body]] with the id {}: this file has one already in line {first}; put their fields together", id.value);
                problems.add(&id.source_line, why);
            }
            first_lines.entry(id.value).or_insert(id.source_line.line);
        }
        rings.extend(rings_of_file(root.sections("ring")));
        overlays.extend(root.sections("overlay").into_iter().filter_map(overlay::overlay));
        atmospheres.extend(root.sections("atmosphere").into_iter().filter_map(atmosphere));
        layers.extend(root.sections("layer").into_iter().filter_map(data_layer::layer));
        for new in root.sections("instrument").into_iter().filter_map(instrument) {
            // A later instrument replaces an earlier one of the same name.
            instruments.retain(|listed| listed.name != new.name);
            instruments.push(new);
        }
        unresolved_moments.extend(root.sections("moment").into_iter().filter_map(moments::unresolved_moment));
        root.finish();
    }
    // Names of bodies are looked up only if every file is valid TOML: a body whose name seems unknown may be in the file that could not be read.
    if !all_are_toml {
        return Err(problems.into_error());
    }
    let field_lines = drafts.iter().flat_map(lines_of_fields).collect();
    let bodies = assemble(drafts, rings, atmospheres, overlays, &problems);
    let moments = moments::assemble(unresolved_moments, &bodies, &problems);
    let mut data_layers = Vec::new();
    for (body_name, mut layer) in layers {
        layer.body = body_name.as_ref().and_then(|body_name| body_of_layer(&bodies, body_name, &problems));
        data_layers.push(layer);
    }
    problems.into_result()?;
    Ok(Catalog {
        bodies,
        moments,
        data_layers: LayerList::new(data_layers),
        instruments,
        eclipse_radii: EclipseRadii::default(),
        stars: None,
        small_bodies: OnceLock::new(),
        lunar_heights: None,
        field_lines,
    })
}

/// The body with the name or alias that a layer gives; reports an unknown name.
fn body_of_layer(bodies: &[Body], body_name: &WithLine<String>, problems: &Problems) -> Option<NaifId> {
    let is_named = |name: &String| name.to_lowercase() == body_name.value.to_lowercase();
    let found = bodies.iter().find(|b| is_named(&b.name) || b.aliases.iter().any(is_named)).map(|b| b.id);
    if found.is_none() {
        let known: Vec<&str> = bodies.iter().map(|b| b.name.as_str()).collect();
        problems.add_unknown_body("body", body_name, &known);
    }
    found
}

/// The entries of a body in `Catalog::field_lines`; that of the field "" is the line of the body itself.
fn lines_of_fields((id, draft): (&i32, &BodyDraft)) -> Vec<(BodyField, FileLine)> {
    let fields = [
        ("", Some(&draft.source_line)),
        ("parent", draft.parent.as_ref().map(|l| &l.source_line)),
        ("motion", draft.motion.as_ref().map(|l| &l.source_line)),
        ("rotation", draft.rotation.as_ref().map(|l| &l.source_line)),
    ];
    fields
        .into_iter()
        .filter_map(|(field, source_line)| Some(((NaifId(*id), field), (source_line?.file.to_string(), source_line?.line))))
        .collect()
}

/// Maximum number of bodies that the message about a cycle of parents lists.
const MAX_NAMES_OF_CYCLE: usize = 8;

/// Reports each cycle of parents, at all of its `parent` fields that are in a user's file. `parent_lines`: the line of the field `parent`, by NAIF code.
fn report_parent_cycles(bodies: &[Body], parent_lines: &BTreeMap<i32, SourceLine>, problems: &Problems) {
    let by_id: BTreeMap<NaifId, &Body> = bodies.iter().map(|b| (b.id, b)).collect();
    let parent_of = |body: &Body| body.parent.and_then(|id| by_id.get(&id).copied());
    // Each body is visited once. A walk from parent to parent ends at a body of an earlier walk, or at one of its own bodies: a cycle.
    let mut walked = BTreeSet::new();
    for start in bodies {
        let path: Vec<&Body> =
            std::iter::successors(Some(start), |body| parent_of(body)).take_while(|body| walked.insert(body.id)).collect();
        let cycle_start = path.last().and_then(|last| parent_of(last)).and_then(|next| path.iter().position(|body| body.id == next.id));
        // `assemble` reports a body that is its own parent.
        let Some(cycle) = cycle_start.map(|first| &path[first..]).filter(|cycle| cycle.len() > 1) else { continue };
        for (position, body) in cycle.iter().enumerate() {
            let Some(source_line) = parent_lines.get(&body.id.0).filter(|source_line| !source_line.is_embedded()) else { continue };
            // The cycle from the body's parent to the body itself.
            let from_parent = cycle[position + 1..].iter().chain(&cycle[..=position]);
            let names: Vec<&str> = from_parent.take(MAX_NAMES_OF_CYCLE).map(|b| b.name.as_str()).collect();
            let more = if cycle.len() > MAX_NAMES_OF_CYCLE { ", …" } else { "" };
            problems.add(source_line, format!("{}.parent is a cycle: {}{more}", body.name, names.join(", ")));
        }
    }
}

/// If a normalized name of body `id` is the NAIF code of a barycentre or of another body: that one, in words. A look-up by the code would find body `id`,
/// because names are looked up first. Normalized names have no minus sign, so the name may also stand for the negative code.
fn owner_of_code(normalized: &str, id: i32, drafts: &BTreeMap<i32, BodyDraft>) -> Option<String> {
    let code: i32 = normalized.parse().ok()?;
    // 0: the solar system's; 1 to 9: those of the planets and Pluto.
    if (0..=9).contains(&code) {
        return Some("a barycentre".into());
    }
    [code, -code].into_iter().find(|other| *other != id && drafts.contains_key(other)).map(|other| format!("body {other}"))
}

/// Turns drafts into bodies: checks that required fields are present, that names are unique, and that the bodies named as parents and by rings,
/// atmospheres and overlays exist.
fn assemble(
    drafts: BTreeMap<i32, BodyDraft>,
    rings: Vec<RingsOfFile>,
    atmospheres: Vec<(WithLine<String>, Atmosphere)>,
    overlays: Vec<(WithLine<String>, Overlay)>,
    problems: &Problems,
) -> Vec<Body> {
    let mut id_by_name: BTreeMap<String, i32> = BTreeMap::new();
    let mut owner_by_normalized_name: BTreeMap<String, (i32, &SourceLine)> = BTreeMap::new();
    for (id, draft) in &drafts {
        let aliases = draft.aliases.iter().flat_map(|l| l.value.iter().map(|alias| (alias, &l.source_line)));
        for (name, source_line) in draft.name.iter().map(|l| (&l.value, &l.source_line)).chain(aliases) {
            id_by_name.insert(name.to_lowercase(), *id);
            // Of two bodies whose names have the same normalized form, a look-up would find only one.
            let normalized = normalized_name(name);
            if is_name_of_barycenter(&normalized) {
                problems.add(source_line, format!("the name \"{name}\" is that of a barycentre"));
            }
            if let Some(owner) = owner_of_code(&normalized, *id, &drafts) {
                problems.add(source_line, format!("the name \"{name}\" is the NAIF code of {owner}"));
            }
            let Some((other_id, other_line)) =
                owner_by_normalized_name.insert(normalized, (*id, source_line)).filter(|(other_id, _)| other_id != id)
            else {
                continue;
            };
            // The message points to the user's file, not to an embedded one.
            let (source_line, owner_id) = if source_line.is_embedded() { (other_line, *id) } else { (source_line, other_id) };
            problems.add(source_line, format!("the name \"{name}\" is already that of body {owner_id}"));
        }
    }
    // A renamed body keeps its former names as aliases, because other entries refer to it by them, unless they are now names of another body.
    let mut kept_names: BTreeMap<i32, Vec<String>> = BTreeMap::new();
    for (id, draft) in &drafts {
        for WithLine { value: name, source_line } in &draft.former_names {
            let (owner, _) = *owner_by_normalized_name.entry(normalized_name(name)).or_insert((*id, source_line));
            if owner == *id && !id_by_name.contains_key(&name.to_lowercase()) {
                id_by_name.insert(name.to_lowercase(), *id);
                kept_names.entry(*id).or_default().push(name.clone());
            }
        }
    }
    // As written, for suggestions: the keys of `id_by_name` are in lower case.
    let names_of = |draft: &BodyDraft| {
        let aliases = draft.aliases.iter().flat_map(|l| l.value.clone());
        draft.name.iter().map(|l| l.value.clone()).chain(aliases).collect::<Vec<_>>()
    };
    let written_names: Vec<String> = drafts.values().flat_map(names_of).collect();
    let known: Vec<&str> = written_names.iter().map(String::as_str).collect();
    let find_id_of_field = |field: &str, name: &WithLine<String>| {
        let id = id_by_name.get(&name.value.to_lowercase()).copied();
        if id.is_none() {
            problems.add_unknown_body(field, name, &known);
        }
        id
    };
    let find_id = |name: &WithLine<String>| find_id_of_field("body", name);
    let radii_lines = drafts.iter().filter_map(|(id, draft)| Some((*id, draft.radii_km.as_ref()?.source_line.clone()))).collect();
    let parent_lines = drafts.iter().filter_map(|(id, draft)| Some((*id, draft.parent.as_ref()?.source_line.clone()))).collect();
    let ids_with_atmosphere: BTreeSet<i32> =
        atmospheres.iter().filter_map(|(owner, _)| id_by_name.get(&owner.value.to_lowercase()).copied()).collect();
    let mut bodies = Vec::with_capacity(drafts.len());
    for (id, draft) in drafts {
        let message_name = draft.name.as_ref().map_or_else(|| format!("body {id}"), |l| l.value.clone());
        // `given` also has the fields whose values were refused, which has been reported.
        let missing = |field: &str| {
            if !draft.given.contains(field) {
                problems.add(&draft.source_line, format!("{message_name}.{field} is missing"));
            }
        };
        // The value of a field of the draft; reports a missing one.
        macro_rules! required {
            ($field:ident, $name:literal) => {
                match draft.$field {
                    Some(v) => Some(v),
                    None => {
                        missing($name);
                        None
                    }
                }
            };
        }
        if draft.name.is_none() {
            missing("name");
        }
        let parent_id = |name: &WithLine<String>| find_id_of_field(&format!("{message_name}.parent"), name);
        let parent = draft.parent.as_ref().and_then(parent_id).map(NaifId);
        if parent == Some(NaifId(id)) {
            problems.add(
                draft.parent.as_ref().map_or(&draft.source_line, |l| &l.source_line),
                format!("{message_name}.parent is the body itself"),
            );
        }
        let (kind, radii, albedo, colour) = (
            required!(kind, "kind"),
            required!(radii_km, "radii_km").map(|r| r.value),
            required!(geometric_albedo, "geometric_albedo"),
            required!(colour, "colour_linear_srgb"),
        );
        if let Some(kind) = kind.as_ref().filter(|kind| draft.parent.is_none() && kind.value != BodyKind::Star) {
            // An embedded star has no parent. It needs one if a user's file makes it a body of another kind, so the problem is at the field `kind`.
            if draft.source_line.is_embedded() && !draft.given.contains("parent") {
                problems.add(&kind.source_line, format!("{message_name}.parent is missing: all bodies but stars have one"));
            } else {
                missing("parent");
            }
        }
        let kind = kind.map(|k| k.value);
        let photometry = required!(photometry, "photometry");
        let motion = required!(motion, "motion").map(|m| m.value);
        let rotation = required!(rotation, "rotation").map(|r| r.value);
        let (Some(name), Some(kind), Some(radii), Some(geometric_albedo), Some(colour), Some(photometry), Some(motion), Some(rotation)) =
            (draft.name.map(|l| l.value), kind, radii, albedo, colour, photometry, motion, rotation)
        else {
            continue;
        };
        if let Some(mesh) = &draft.mesh {
            let add_problem = |what: &str| problems.add(&mesh.source_line, format!("{name}.mesh: {what}"));
            if mesh.value.has_map_alpha && draft.maps.albedo.is_none() {
                add_problem("alpha = true needs an albedo map, whose alpha cuts the mesh out");
            }
            if ids_with_atmosphere.contains(&id) || draft.clouds.is_some() {
                add_problem("a body with an atmosphere or clouds cannot have a mesh: both are drawn over an ellipsoid");
            }
        }
        bodies.push(Body {
            id: NaifId(id),
            name,
            aliases: draft.aliases.into_iter().flat_map(|l| l.value).chain(kept_names.remove(&id).unwrap_or_default()).collect(),
            kind,
            parent,
            radii_km: DVec3::from_array(radii),
            gm_km3_s2: draft.gm_km3_s2,
            geometric_albedo,
            bond_albedo: draft.bond_albedo,
            clear_sky_albedo: draft.clear_sky_albedo,
            invented_relief: draft.invented_relief.unwrap_or_default(),
            // Set later by `Catalog::set_custom_surface`.
            custom_surface: 0,
            clear_sky_colour: draft.clear_sky_colour.map(scaled_to_luminance_1),
            colour: scaled_to_luminance_1(colour),
            photometry,
            maps: draft.maps,
            overlays: Vec::new(),
            clouds: draft.clouds,
            mesh: draft.mesh.map(|m| m.value),
            motion,
            rotation,
            rings: Vec::new(),
            atmosphere: None,
            sources: draft.sources,
            estimates: draft.estimates,
        });
    }
    report_parent_cycles(&bodies, &parent_lines, problems);
    read_ring::add_to_bodies(rings, &mut bodies, find_id, &radii_lines, problems);
    for (body_name, air) in atmospheres {
        if let Some(b) = find_id(&body_name).and_then(|id| bodies.iter_mut().find(|b| b.id.0 == id)) {
            b.atmosphere = Some(air);
        }
    }
    for (body_name, new) in overlays {
        if let Some(b) = find_id(&body_name).and_then(|id| bodies.iter_mut().find(|b| b.id.0 == id))
            && let Err(why) = overlay::add(&mut b.overlays, new)
        {
            problems.add(&body_name.source_line, format!("{}: {why}", b.name));
        }
    }
    bodies
}

/// A linear sRGB colour scaled to luminance 1.
fn scaled_to_luminance_1(rgb: [f64; 3]) -> Vec3 {
    Vec3::from_array(rgb.map(|x| (x / crate::units::luminance(rgb)) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_light_by_phase_ascend_within_their_limits() {
        assert!(is_forward_light(&[]) && is_forward_light(&[[0.0; 4], [90.0, 0.1, 0.2, 0.3], [180.0, 10.0, 0.0, 0.0]]));
        for wrong in [[[20.0, 0.0, 0.0, 0.0]; 2], [[30.0, 0.0, 0.0, 0.0], [20.0, 0.0, 0.0, 0.0]]] {
            assert!(!is_forward_light(&wrong), "{wrong:?} does not ascend");
        }
        for wrong in
            [[-1.0, 0.0, 0.0, 0.0], [181.0, 0.0, 0.0, 0.0], [9.0, -0.1, 0.0, 0.0], [9.0, 0.0, f64::NAN, 0.0], [9.0, 0.0, 0.0, 11.0]]
        {
            assert!(!is_forward_light(&[wrong]), "{wrong:?}");
        }
    }

    /// The field `red` is made up: a single number, which may be equal to its limits, allowed only beside the asymmetry and a function that has it.
    #[test]
    fn a_phase_function_and_a_field_with_one_number_are_read_beside_the_first() {
        let red = AerosolField {
            catalog_key: "red",
            query_key: "red",
            functions: &AerosolFunction::ALL,
            limits: [0.0, 0.5],
            includes_limits: true,
            numbers: |aerosol| &mut aerosol.asymmetry[..1],
        };
        let read_with = |field: AerosolField, text: &str| {
            let problems = Problems::default();
            let file = TomlFile::new("mine.toml", text, &problems);
            let phase = phase_function(&mut file.root().expect("TOML"), &[AerosolPhase::FIELDS[0], field]);
            problems.into_result().map(|()| phase).map_err(|e| e.problems.into_iter().map(|p| p.message).collect::<Vec<_>>())
        };
        let read = |text: &str| read_with(red, text);
        let aerosol = |asymmetry: [f64; 3]| Ok(PhaseFunction::Aerosol(AerosolPhase::with_asymmetry(asymmetry)));
        assert_eq!(read(""), Ok(PhaseFunction::Rayleigh));
        assert_eq!(read("asymmetry = 0.25"), aerosol([0.25; 3]));
        for function in AerosolFunction::ALL {
            let expected = PhaseFunction::Aerosol(AerosolPhase { asymmetry: [0.25; 3], ..AerosolPhase::of(function) });
            assert_eq!(read(&format!("asymmetry = 0.25\nphase = \"{}\"", function.query_word())), Ok(expected));
        }
        let of_no_function = AerosolField { functions: &[], ..red };
        assert!(read_with(of_no_function, "asymmetry = 0.25").is_ok() && read_with(of_no_function, "asymmetry = 0.25\nred = 0.5").is_err());
        for red in [0.0, 0.125, 0.5] {
            assert_eq!(read(&format!("asymmetry = 0.25\nred = {red:?}")), aerosol([red, 0.25, 0.25]));
        }
        for (lines, allowed) in [
            ("asymmetry = 0.25\nred = 0.75", "a number from 0 to 0.5"),
            ("asymmetry = 0.25\nred = [0.5, 0.5, 0.5]", "a number from 0 to 0.5"),
            ("red = 0.5", "`asymmetry` beside it"),
        ] {
            // The message quotes the last line.
            let wrong = lines.lines().next_back().expect("a line");
            assert_eq!(read(lines), Err(vec![format!("{wrong}: expected {allowed}")]));
        }
    }
}
