//! From catalog files to bodies: drafts per body, later files over earlier ones, then one check of the whole.
//!
//! In: (name, text) pairs. Out: the bodies, or every problem with file, line, field, value and what is allowed. A field of a later file
//! replaces that field; photometry, motion, rotation, clouds, mesh, atmosphere and the set of rings are replaced whole, maps one by one.

use super::overlay;
use super::table::{Problems, SourceLine, TableReader, TomlFile, WithLine, nearest};
use super::{
    Atmosphere, Body, BodyField, BodyKind, Catalog, CatalogError, Clouds, EclipseRadii, Estimates, FileLine, Map, MapLatitude, Maps,
    MeanElements, Motion, NaifId, Overlay, Photometry, Ring, Rotation, ShapeModel, Species, moments,
};
use glam::{DVec3, Vec3};
use orrery_catalogs::TABLES;
use std::collections::BTreeMap;

/// What the files say of one body so far.
struct BodyDraft {
    place: SourceLine,
    name: Option<WithLine<String>>,
    aliases: Option<WithLine<Vec<String>>>,
    kind: Option<BodyKind>,
    parent: Option<WithLine<String>>,
    radii_km: Option<[f64; 3]>,
    gm_km3_s2: Option<f64>,
    geometric_albedo: Option<f64>,
    bond_albedo: Option<f64>,
    clear_sky_albedo: Option<f64>,
    colour: Option<[f64; 3]>,
    photometry: Option<Photometry>,
    maps: Maps,
    clouds: Option<Clouds>,
    mesh: Option<WithLine<ShapeModel>>,
    motion: Option<WithLine<Motion>>,
    rotation: Option<WithLine<Rotation>>,
    sources: BTreeMap<String, String>,
    estimates: Estimates,
}

fn finite(v: &f64) -> bool {
    v.is_finite()
}

pub(super) fn each(check: impl Fn(f64) -> bool) -> impl Fn(&[f64; 3]) -> bool {
    move |v| v.iter().all(|x| x.is_finite() && check(*x))
}

/// Reads one of a few words.
fn word<T: Copy>(section: &mut TableReader, field: &'static str, words: &[(&str, T)]) -> Option<T> {
    let allowed = format!("one of {}", words.iter().map(|(w, _)| format!("\"{w}\"")).collect::<Vec<_>>().join(", "));
    let found = section.take::<String>(field, &allowed, |v| words.iter().any(|(w, _)| w == v))?;
    words.iter().find(|(w, _)| *w == found.value).map(|(_, t)| *t)
}

fn need_word<T: Copy>(section: &mut TableReader, field: &'static str, words: &[(&str, T)]) -> Option<T> {
    let allowed = format!("one of {}", words.iter().map(|(w, _)| format!("\"{w}\"")).collect::<Vec<_>>().join(", "));
    let found = section.need::<String>(field, &allowed, |v| words.iter().any(|(w, _)| w == v))?;
    words.iter().find(|(w, _)| *w == found.value).map(|(_, t)| *t)
}

pub(super) fn number(section: &mut TableReader, field: &'static str, allowed: &str, ok: impl Fn(f64) -> bool) -> Option<f64> {
    section.need::<f64>(field, allowed, |v| v.is_finite() && ok(*v)).map(|l| l.value)
}

fn photometry(mut s: TableReader) -> Option<Photometry> {
    let model =
        need_word(&mut s, "model", &[("emissive", 0), ("lambert", 1), ("lommel-seeliger", 2), ("lunar-lambert", 3), ("oren-nayar", 4)]);
    let result = match model {
        Some(0) => {
            let allowed = "three numbers from -1 to 2 (red, green, blue)";
            let u1 = s.need("u1", allowed, each(|x| (-1.0..=2.0).contains(&x)));
            let u2 = s.need("u2", allowed, each(|x| (-1.0..=2.0).contains(&x)));
            u1.zip(u2).map(|(u1, u2)| Photometry::Emissive { u1: u1.value, u2: u2.value })
        }
        Some(1) => Some(Photometry::Lambert),
        Some(2) => Some(Photometry::LommelSeeliger),
        Some(3) => number(&mut s, "lunar_weight", "a number from 0 to 1", |x| (0.0..=1.0).contains(&x))
            .map(|lunar_weight| Photometry::LunarLambert { lunar_weight }),
        Some(4) => number(&mut s, "roughness_deg", "degrees from 0 to 60", |x| (0.0..=60.0).contains(&x))
            .map(|roughness_deg| Photometry::OrenNayar { roughness_deg }),
        _ => return None,
    };
    s.finish();
    result
}

fn motion(mut s: TableReader) -> Option<Motion> {
    let theory = need_word(&mut s, "theory", &[("planetary", 0), ("galilean-l12", 1), ("tass17", 2), ("mean-elements", 3)]);
    let result = match theory {
        Some(0) => Some(Motion::Planetary),
        Some(1) => {
            s.need("index", "0 Io, 1 Europa, 2 Ganymede or 3 Callisto", |i: &usize| *i < 4).map(|l| Motion::GalileanL12 { index: l.value })
        }
        Some(2) => s
            .need("index", "0 Mimas, 1 Enceladus, 2 Tethys, 3 Dione, 4 Rhea, 5 Titan, 6 Iapetus or 7 Hyperion", |i: &usize| *i < 8)
            .map(|l| Motion::Tass17 { index: l.value }),
        Some(3) => elements(&mut s).map(Motion::MeanElements),
        _ => return None,
    };
    s.finish();
    result
}

fn elements(s: &mut TableReader) -> Option<MeanElements> {
    let any = |_| true;
    let pole_ra_deg = number(s, "pole_ra_deg", "degrees", any);
    let pole_dec_deg = number(s, "pole_dec_deg", "degrees from -90 to 90", |x| x.abs() <= 90.0);
    let epoch_jd_tt = number(s, "epoch_jd_tt", "a Julian date", any);
    let semi_major_axis_km = number(s, "semi_major_axis_km", "kilometres above 0", |x| x > 0.0);
    let eccentricity = number(s, "eccentricity", "a number from 0 to below 1", |x| (0.0..1.0).contains(&x));
    let inclination_deg = number(s, "inclination_deg", "degrees from 0 to 180", |x| (0.0..=180.0).contains(&x));
    let node_deg = number(s, "node_deg", "degrees", any);
    let argument_of_periapsis_deg = number(s, "argument_of_periapsis_deg", "degrees", any);
    let mean_anomaly_deg = number(s, "mean_anomaly_deg", "degrees", any);
    let mean_motion_deg_day = number(s, "mean_motion_deg_day", "degrees a day above 0", |x| x > 0.0);
    let node_period_yr = number(s, "node_period_yr", "Julian years, 0 for none", any);
    let argument_period_yr = number(s, "argument_period_yr", "Julian years, 0 for none", any);
    let quadratic = s.take::<f64>("longitude_quadratic_deg_cy2", "degrees per Julian century squared, 0 if left out", |v| v.is_finite());
    Some(MeanElements {
        pole_ra_deg: pole_ra_deg?,
        pole_dec_deg: pole_dec_deg?,
        epoch_jd_tt: epoch_jd_tt?,
        semi_major_axis_km: semi_major_axis_km?,
        eccentricity: eccentricity?,
        inclination_deg: inclination_deg?,
        node_deg: node_deg?,
        argument_of_periapsis_deg: argument_of_periapsis_deg?,
        mean_anomaly_deg: mean_anomaly_deg?,
        mean_motion_deg_day: mean_motion_deg_day?,
        node_period_yr: node_period_yr?,
        argument_period_yr: argument_period_yr?,
        longitude_quadratic_deg_cy2: quadratic.map_or(0.0, |l| l.value),
    })
}

fn rotation(mut s: TableReader) -> Option<Rotation> {
    let model = need_word(&mut s, "model", &[("earth-iau2006", 0), ("pck", 1), ("synchronous", 2), ("fixed", 3)]);
    let result = match model {
        Some(0) => Some(Rotation::EarthIau2006),
        Some(1) => Some(Rotation::Pck),
        Some(2) => Some(Rotation::Synchronous),
        Some(3) => {
            let pole_ra_deg = number(&mut s, "pole_ra_deg", "degrees", |_| true);
            let pole_dec_deg = number(&mut s, "pole_dec_deg", "degrees from -90 to 90", |x| x.abs() <= 90.0);
            let w0_deg = number(&mut s, "w0_deg", "degrees", |_| true);
            let w_deg_day = number(&mut s, "w_deg_day", "degrees a day", |_| true);
            match (pole_ra_deg, pole_dec_deg, w0_deg, w_deg_day) {
                (Some(pole_ra_deg), Some(pole_dec_deg), Some(w0_deg), Some(w_deg_day)) => {
                    Some(Rotation::Fixed { pole_ra_deg, pole_dec_deg, w0_deg, w_deg_day })
                }
                _ => None,
            }
        }
        _ => return None,
    };
    s.finish();
    result
}

/// What of a map or a shape is invented, in words of one line.
fn invented(s: &mut TableReader) -> Option<String> {
    let said = s.take("invented", "what of it is invented, in a line of words", |v: &String| !v.trim().is_empty() && !v.contains('\n'));
    said.map(|l| l.value)
}

/// A table's value with the line where it begins.
fn located<T>(s: TableReader, read: impl FnOnce(TableReader) -> Option<T>) -> Option<WithLine<T>> {
    let place = s.place.clone();
    Some(WithLine { value: read(s)?, place })
}

fn map(mut s: TableReader) -> Option<Map> {
    let file = s.need::<String>("file", "a file name without folders", |f| !f.is_empty() && !f.contains(['/', '\\']) && f != "..");
    let gain = s.take("gain", "three numbers from 0 to 100 (red, green, blue)", each(|x| (0.0..=100.0).contains(&x)));
    let latitude =
        word(&mut s, "latitude", &[("planetographic", MapLatitude::Planetographic), ("planetocentric", MapLatitude::Planetocentric)]);
    let invented = invented(&mut s);
    let _ = s.take::<String>("source", "a string", |_| true);
    s.finish();
    let (gain, latitude) = (gain.map_or([1.0; 3], |g| g.value), latitude.unwrap_or(MapLatitude::Planetocentric));
    Some(Map { file: file?.value, gain, latitude, invented })
}

fn clouds(mut s: TableReader) -> Option<Clouds> {
    let part = "a number from 0 to 1";
    let height_km = number(&mut s, "height_km", "kilometres above 0, at most 1000", |x| x > 0.0 && x <= 1000.0);
    let albedo = number(&mut s, "albedo", part, |x| (0.0..=1.0).contains(&x));
    let clear_texel = number(&mut s, "clear_texel", part, |x| (0.0..=1.0).contains(&x));
    let closed_texel =
        number(&mut s, "closed_texel", "a number above clear_texel, at most 1", |x| x <= 1.0 && clear_texel.is_none_or(|clear| x > clear));
    let map = map(s)?;
    Some(Clouds { map, height_km: height_km?, albedo: albedo?, clear_texel: clear_texel?, closed_texel: closed_texel? })
}

fn mesh(mut s: TableReader) -> Option<WithLine<ShapeModel>> {
    let place = s.place.clone();
    let file = s.need::<String>("file", "the name of a .obj file without folders", |f| {
        f.to_lowercase().ends_with(".obj") && f.len() > 4 && !f.contains(['/', '\\'])
    });
    let scale_km = s.take("scale_km", "kilometres above 0, below 1e7", |x: &f64| *x > 0.0 && *x < 1e7);
    let mut flag = |field, default| s.take::<bool>(field, "true or false", |_| true).map_or(default, |l| l.value);
    let (two_sided, alpha, vertex_colours) = (flag("two_sided", false), flag("alpha", false), flag("vertex_colours", true));
    let invented = invented(&mut s);
    let _ = s.take::<String>("source", "a string", |_| true);
    s.finish();
    let scale_km = scale_km.map_or(1.0, |l| l.value);
    let value = ShapeModel { file: file?.value, scale_km, two_sided, alpha, vertex_colours, invented };
    Some(WithLine { value, place })
}

fn maps(mut s: TableReader, into: &mut Maps) {
    for (field, slot) in
        [("albedo", &mut into.albedo), ("normal", &mut into.normal), ("specular", &mut into.specular), ("night", &mut into.night)]
    {
        if let Some(found) = s.section(field).and_then(map) {
            *slot = Some(found);
        }
    }
    s.finish();
}

/// Below 100: of a value that may be wholly wrong nothing is known.
const PERCENT: &str = "percent above 0, at most 90";

fn percent(s: &mut TableReader, field: &'static str) -> Option<f64> {
    s.take(field, PERCENT, |p: &f64| *p > 0.0 && *p <= 90.0).map(|l| l.value)
}

fn estimates(mut s: TableReader) -> Estimates {
    let found = Estimates { albedo_percent: percent(&mut s, "albedo_percent"), colour_percent: percent(&mut s, "colour_percent") };
    s.finish();
    found
}

/// One line that says something.
fn is_name(text: &String) -> bool {
    !text.trim().is_empty() && !text.contains(char::is_control)
}

fn body(mut s: TableReader, drafts: &mut BTreeMap<i32, BodyDraft>) {
    let name = s.take("name", "a name", is_name);
    let place = s.place.clone();
    if let Some(n) = &name {
        s.rename(&n.value);
    }
    let id = s.need("id", "a NAIF code above 9", |i: &i32| *i > 9);
    if let (None, Some(n)) = (&name, id.as_ref().and_then(|id| drafts.get(&id.value)?.name.clone())) {
        s.rename(&n.value);
    }
    let mut fresh = BodyDraft {
        place,
        name,
        aliases: s.take("aliases", "a list of names", |names: &Vec<String>| names.iter().all(is_name)),
        kind: word(
            &mut s,
            "kind",
            &[
                ("star", BodyKind::Star),
                ("planet", BodyKind::Planet),
                ("dwarf-planet", BodyKind::DwarfPlanet),
                ("moon", BodyKind::Moon),
                ("asteroid", BodyKind::Asteroid),
            ],
        ),
        parent: s.take("parent", "the name of a body", |_: &String| true),
        radii_km: s.take("radii_km", "three lengths above 0 and below 1e7", each(|x| x > 0.0 && x < 1e7)).map(|l| l.value),
        gm_km3_s2: s.take("gm_km3_s2", "a number from 0", |v| finite(v) && *v >= 0.0).map(|l| l.value),
        geometric_albedo: s.take("geometric_albedo", "a number from 0 to 2", |v| (0.0..=2.0).contains(v)).map(|l| l.value),
        bond_albedo: s.take("bond_albedo", "a number from 0 to 1", |v| (0.0..=1.0).contains(v)).map(|l| l.value),
        clear_sky_albedo: s.take("clear_sky_albedo", "a number from 0 to 2", |v| (0.0..=2.0).contains(v)).map(|l| l.value),
        colour: s
            .take("colour_linear_srgb", "three numbers from 0 to 100, not all 0", |v: &[f64; 3]| {
                each(|x| (0.0..=100.0).contains(&x))(v) && v.iter().sum::<f64>() > 0.0
            })
            .map(|l| l.value),
        photometry: s.section("photometry").and_then(photometry),
        maps: Maps::default(),
        clouds: s.section("clouds").and_then(clouds),
        mesh: s.section("mesh").and_then(mesh),
        motion: s.section("motion").and_then(|s| located(s, motion)),
        rotation: s.section("rotation").and_then(|s| located(s, rotation)),
        sources: BTreeMap::new(),
        estimates: s.section("estimates").map(estimates).unwrap_or_default(),
    };
    let Some(id) = id else {
        return s.finish();
    };
    let older = drafts.remove(&id.value);
    if let Some(older) = older {
        // An estimate is of the value that it came with.
        let kept = |own: Option<f64>, replaced: bool, former: Option<f64>| own.or(former.filter(|_| !replaced));
        fresh.estimates = Estimates {
            albedo_percent: kept(fresh.estimates.albedo_percent, fresh.geometric_albedo.is_some(), older.estimates.albedo_percent),
            colour_percent: kept(fresh.estimates.colour_percent, fresh.colour.is_some(), older.estimates.colour_percent),
        };
        fresh.place = older.place;
        fresh.name = fresh.name.or(older.name);
        fresh.aliases = fresh.aliases.or(older.aliases);
        fresh.kind = fresh.kind.or(older.kind);
        fresh.parent = fresh.parent.or(older.parent);
        fresh.radii_km = fresh.radii_km.or(older.radii_km);
        fresh.gm_km3_s2 = fresh.gm_km3_s2.or(older.gm_km3_s2);
        fresh.geometric_albedo = fresh.geometric_albedo.or(older.geometric_albedo);
        fresh.bond_albedo = fresh.bond_albedo.or(older.bond_albedo);
        fresh.clear_sky_albedo = fresh.clear_sky_albedo.or(older.clear_sky_albedo);
        fresh.colour = fresh.colour.or(older.colour);
        fresh.photometry = fresh.photometry.or(older.photometry);
        fresh.maps = older.maps;
        fresh.clouds = fresh.clouds.or(older.clouds);
        fresh.mesh = fresh.mesh.or(older.mesh);
        fresh.motion = fresh.motion.or(older.motion);
        fresh.rotation = fresh.rotation.or(older.rotation);
        fresh.sources = older.sources;
    }
    if let Some(m) = s.section("maps") {
        maps(m, &mut fresh.maps);
    }
    fresh.sources.extend(s.strings("sources"));
    drafts.insert(id.value, fresh);
    s.finish();
}

fn ring(mut s: TableReader) -> Option<(WithLine<String>, Ring)> {
    let of = s.need("body", "the name of a body", |_: &String| true);
    let name = s.need("name", "a name", is_name);
    let inner_km = number(&mut s, "inner_km", "kilometres above 0", |x| x > 0.0);
    let outer_km = s.need("outer_km", "kilometres above inner_km", |x: &f64| x.is_finite() && inner_km.is_none_or(|i| *x > i));
    let tau_normal = number(&mut s, "tau_normal", "an optical depth from 0 to 100", |x| (0.0..=100.0).contains(&x));
    let albedo = s.take("albedo", "three numbers from 0 to 1 (red, green, blue)", each(|x| (0.0..=1.0).contains(&x)));
    let dust = s.take("dust", "a part from 0 to 1", |x: &f64| (0.0..=1.0).contains(x));
    s.finish();
    Some((
        of?,
        Ring {
            name: name?.value,
            inner_km: inner_km?,
            outer_km: outer_km?.value,
            tau_normal: tau_normal?,
            albedo: albedo.map_or([0.5; 3], |l| l.value),
            dust: dust.map_or(0.0, |l| l.value),
        },
    ))
}

fn species(mut s: TableReader) -> Option<Species> {
    let per_km = "three numbers from 0 to 10 per kilometre";
    let name = s.need("name", "a name", is_name);
    let scale_height_km = number(&mut s, "scale_height_km", "kilometres above 0", |x| x > 0.0);
    let tent_centre_km = s.take("tent_centre_km", "kilometres from 0", |x: &f64| finite(x) && *x >= 0.0);
    let scattering = s.take("scattering_per_km", per_km, each(|x| (0.0..=10.0).contains(&x)));
    let absorption = s.take("absorption_per_km", per_km, each(|x| (0.0..=10.0).contains(&x)));
    let asymmetry = s.take("asymmetry", "a number between -1 and 1", |x: &f64| x.abs() < 1.0);
    let estimate_percent = percent(&mut s, "estimate_percent");
    s.finish();
    Some(Species {
        name: name?.value,
        scale_height_km: scale_height_km?,
        tent_centre_km: tent_centre_km.map(|l| l.value),
        scattering_per_km: scattering.map_or([0.0; 3], |l| l.value),
        absorption_per_km: absorption.map_or([0.0; 3], |l| l.value),
        asymmetry: asymmetry.map(|l| l.value),
        estimate_percent,
    })
}

fn atmosphere(mut s: TableReader) -> Option<(WithLine<String>, Atmosphere)> {
    let of = s.need("body", "the name of a body", |_: &String| true);
    let top_km = number(&mut s, "top_km", "kilometres above 0", |x| x > 0.0);
    let refractivity = s.take("refractivity", "a number above 0 and below 0.01", |x: &f64| *x > 0.0 && *x < 0.01).map(|l| l.value);
    let airglow_cd_m2 = s.take("airglow_cd_m2", "candelas a square metre from 0 to 1", |x: &f64| (0.0..=1.0).contains(x)).map(|l| l.value);
    let species: Vec<_> = s.sections("species").into_iter().filter_map(species).collect();
    let _ = s.take::<String>("source", "a string", |_| true);
    s.finish();
    Some((of?, Atmosphere { top_km: top_km?, refractivity, airglow_cd_m2, species }))
}

/// Reads every file; later ones override. All problems come back together.
pub(super) fn read(files: &[(&str, &str)]) -> Result<Catalog, CatalogError> {
    let problems = Problems::default();
    let mut drafts = BTreeMap::new();
    let mut rings: Vec<(WithLine<String>, Vec<Ring>)> = Vec::new();
    let mut atmospheres = Vec::new();
    let mut overlays = Vec::new();
    let mut moments_drafts = Vec::new();
    for (file, text) in files {
        let source = TomlFile::new(file, text, &problems);
        let mut root = source.root();
        for s in root.sections("body") {
            body(s, &mut drafts);
        }
        let mut of_file: Vec<(WithLine<String>, Vec<Ring>)> = Vec::new();
        for (of, ring) in root.sections("ring").into_iter().filter_map(ring) {
            match of_file.iter_mut().find(|(b, _)| b.value == of.value) {
                Some((_, list)) => list.push(ring),
                None => of_file.push((of, vec![ring])),
            }
        }
        rings.extend(of_file);
        overlays.extend(root.sections("overlay").into_iter().filter_map(overlay::overlay));
        atmospheres.extend(root.sections("atmosphere").into_iter().filter_map(atmosphere));
        moments_drafts.extend(root.sections("moment").into_iter().filter_map(moments::draft));
        root.finish();
    }
    let field_lines = drafts.iter().flat_map(lines_of).collect();
    let bodies = assemble(drafts, rings, atmospheres, overlays, &problems);
    let moments = moments::assemble(moments_drafts, &bodies, &problems);
    problems.into_result()?;
    Ok(Catalog { bodies, moments, eclipse_radii: EclipseRadii::default(), field_lines })
}

/// Where a body's fields stand that only the whole can check.
fn lines_of((id, d): (&i32, &BodyDraft)) -> Vec<(BodyField, FileLine)> {
    let fields = [
        ("", Some(&d.place)),
        ("parent", d.parent.as_ref().map(|l| &l.place)),
        ("motion", d.motion.as_ref().map(|l| &l.place)),
        ("rotation", d.rotation.as_ref().map(|l| &l.place)),
    ];
    fields.into_iter().filter_map(|(field, place)| Some(((NaifId(*id), field), (place?.file.to_string(), place?.line)))).collect()
}

fn is_embedded(place: &SourceLine) -> bool {
    TABLES.iter().any(|(file, _)| *file == &*place.file)
}

/// Parents that lead round in a circle, each said at the parents of it that the user's files name.
fn circles(bodies: &[Body], parents: &BTreeMap<i32, SourceLine>, problems: &Problems) {
    let parent_of = |id: NaifId| bodies.iter().find(|b| b.id == id).and_then(|b| b.parent);
    for body in bodies {
        let round: Vec<NaifId> =
            std::iter::successors(body.parent, |id| parent_of(*id)).take(bodies.len()).take_while(|id| *id != body.id).collect();
        let is_circle = round.len() < bodies.len() && round.last().map_or(body.parent, |id| parent_of(*id)) == Some(body.id);
        // A body that is its own parent has its own message.
        if let (true, false, Some(place)) = (is_circle, round.is_empty(), parents.get(&body.id.0).filter(|place| !is_embedded(place))) {
            let names = round.iter().filter_map(|id| bodies.iter().find(|b| b.id == *id)).map(|b| b.name.as_str());
            let names: Vec<&str> = names.chain([body.name.as_str()]).collect();
            problems.add(place, format!("{}.parent leads round in a circle: {}", body.name, names.join(", ")));
        }
    }
}

/// Drafts to bodies: what must be there is there, names are single, parents and owners exist.
fn assemble(
    drafts: BTreeMap<i32, BodyDraft>,
    rings: Vec<(WithLine<String>, Vec<Ring>)>,
    atmospheres: Vec<(WithLine<String>, Atmosphere)>,
    overlays: Vec<(WithLine<String>, Overlay)>,
    problems: &Problems,
) -> Vec<Body> {
    let mut ids: BTreeMap<String, i32> = BTreeMap::new();
    let mut named: BTreeMap<String, (i32, &SourceLine)> = BTreeMap::new();
    for (id, d) in &drafts {
        let aliases = d.aliases.iter().flat_map(|l| l.value.iter().map(|alias| (alias, &l.place)));
        for (name, place) in d.name.iter().map(|l| (&l.value, &l.place)).chain(aliases) {
            ids.insert(name.to_lowercase(), *id);
            let Some((other, other_place)) = named.insert(name.to_lowercase(), (*id, place)).filter(|(other, _)| other != id) else {
                continue;
            };
            // The user's file is to blame, whichever body comes first.
            let (place, other) = if is_embedded(place) { (other_place, *id) } else { (place, other) };
            problems.add(place, format!("the name \"{name}\" is already that of body {other}"));
        }
    }
    let known: Vec<&str> = ids.keys().map(String::as_str).collect();
    let resolve = |name: &WithLine<String>| {
        let id = ids.get(&name.value.to_lowercase()).copied();
        if id.is_none() {
            let hint = nearest(&name.value.to_lowercase(), &known).map_or(String::new(), |n| format!("; did you mean \"{n}\"?"));
            problems.add(&name.place, format!("\"{}\" is not the name of a body{hint}", name.value));
        }
        id
    };
    let parents = drafts.iter().filter_map(|(id, d)| Some((*id, d.parent.as_ref()?.place.clone()))).collect();
    let mut bodies = Vec::with_capacity(drafts.len());
    for (id, d) in drafts {
        let label = d.name.as_ref().map_or_else(|| format!("body {id}"), |l| l.value.clone());
        let missing = |field: &str| problems.add(&d.place, format!("{label}.{field} is missing"));
        macro_rules! need {
            ($field:ident, $name:literal) => {
                match d.$field {
                    Some(v) => Some(v),
                    None => {
                        missing($name);
                        None
                    }
                }
            };
        }
        if d.name.is_none() {
            missing("name");
        }
        let parent = d.parent.as_ref().and_then(&resolve).map(NaifId);
        if parent == Some(NaifId(id)) {
            problems.add(d.parent.as_ref().map_or(&d.place, |l| &l.place), format!("{label}.parent is the body itself"));
        }
        let (kind, radii, albedo, colour) = (
            need!(kind, "kind"),
            need!(radii_km, "radii_km"),
            need!(geometric_albedo, "geometric_albedo"),
            need!(colour, "colour_linear_srgb"),
        );
        if d.parent.is_none() && kind.is_some_and(|k| k != BodyKind::Star) {
            missing("parent");
        }
        let photometry = need!(photometry, "photometry");
        let motion = match d.motion {
            Some(m) => Some(m.value),
            None => {
                missing("motion");
                None
            }
        };
        let rotation = match d.rotation {
            Some(r) => Some(r.value),
            None => {
                missing("rotation");
                None
            }
        };
        let (Some(name), Some(kind), Some(radii), Some(geometric_albedo), Some(c), Some(photometry), Some(motion), Some(rotation)) =
            (d.name.map(|l| l.value), kind, radii, albedo, colour, photometry, motion, rotation)
        else {
            continue;
        };
        if let Some(mesh) = &d.mesh {
            let wrong = |what: &str| problems.add(&mesh.place, format!("{name}.mesh: {what}"));
            if mesh.value.alpha && d.maps.albedo.is_none() {
                wrong("alpha = true needs an albedo map, whose alpha cuts the mesh out");
            }
            if atmospheres.iter().any(|(of, _)| ids.get(&of.value.to_lowercase()) == Some(&id)) || d.clouds.is_some() {
                wrong("a body with an atmosphere or clouds takes none: they lie over an ellipsoid");
            }
        }
        let luminance = crate::units::luminance([c[0], c[1], c[2]]);
        bodies.push(Body {
            id: NaifId(id),
            name,
            aliases: d.aliases.map(|l| l.value).unwrap_or_default(),
            kind,
            parent,
            radii_km: DVec3::from_array(radii),
            gm_km3_s2: d.gm_km3_s2,
            geometric_albedo,
            bond_albedo: d.bond_albedo,
            clear_sky_albedo: d.clear_sky_albedo,
            colour: Vec3::from_array(c.map(|x| (x / luminance) as f32)),
            photometry,
            maps: d.maps,
            overlays: Vec::new(),
            clouds: d.clouds,
            mesh: d.mesh.map(|m| m.value),
            motion,
            rotation,
            rings: Vec::new(),
            atmosphere: None,
            sources: d.sources,
            estimates: d.estimates,
        });
    }
    circles(&bodies, &parents, problems);
    for (of, list) in rings {
        if let Some(b) = resolve(&of).and_then(|id| bodies.iter_mut().find(|b| b.id.0 == id)) {
            b.rings = list;
        }
    }
    for (of, air) in atmospheres {
        if let Some(b) = resolve(&of).and_then(|id| bodies.iter_mut().find(|b| b.id.0 == id)) {
            b.atmosphere = Some(air);
        }
    }
    for (of, new) in overlays {
        if let Some(b) = resolve(&of).and_then(|id| bodies.iter_mut().find(|b| b.id.0 == id))
            && let Err(wrong) = overlay::add(&mut b.overlays, new)
        {
            problems.add(&of.place, format!("{}: {wrong}", b.name));
        }
    }
    bodies
}
