//! Reading `[[body]]`: merges the fields that one file gives for a body into those of earlier files.
//!
//! In: the TOML table, and the drafts of the bodies read so far. Out: the changed draft, and problems in the shared list. A field of a later file replaces the
//! same field. Photometry, motion, rotation, clouds and mesh are replaced as a whole; maps, sources and estimates one by one. A value that is missing or
//! refused is `None`.

use super::fields::{
    ALLOWED_NAME, each_component, finite, invented_part, is_file_name, is_name, optional_percent, optional_word, optional_word_with_line,
    read_map, required_number, required_word, with_line,
};
use super::table::{SourceLine, TableReader, WithLine};
use super::{BodyKind, Clouds, Estimates, InventedRelief, Maps, MeanElements, Motion, Photometry, Rotation, ShapeModel};
use std::collections::{BTreeMap, BTreeSet};

/// What [`is_colour`] accepts, for messages.
const ALLOWED_COLOUR: &str = "three numbers from 0 to 100, not all below 1e-6";

/// Whether a colour can be scaled to luminance 1, which needs a luminance clearly above 0.
fn is_colour(rgb: &[f64; 3]) -> bool {
    each_component(|x| (0.0..=100.0).contains(&x))(rgb) && rgb.iter().any(|x| *x >= 1e-6)
}

fn required_fraction(table: &mut TableReader, field: &'static str) -> Option<f64> {
    required_number(table, field, "a number from 0 to 1", |x| (0.0..=1.0).contains(&x))
}

fn required_pole_dec_deg(table: &mut TableReader) -> Option<f64> {
    required_number(table, "pole_dec_deg", "degrees from -90 to 90", |x| x.abs() <= 90.0)
}

/// The fields that every body needs (`parent`: every body but a star).
const NEEDED_FIELDS: [&str; 9] =
    ["name", "kind", "parent", "radii_km", "geometric_albedo", "colour_linear_srgb", "photometry", "motion", "rotation"];

/// The fields of one body as read so far; see [`Body`](super::Body). `source_line`: where the body is first described. `given`: those of [`NEEDED_FIELDS`] that
/// a file gives, also with a value that was refused. `former_names`: the names that later files have replaced. `sources`: citations by topic.
pub(super) struct BodyDraft {
    pub source_line: SourceLine,
    pub given: BTreeSet<&'static str>,
    pub name: Option<WithLine<String>>,
    pub former_names: Vec<WithLine<String>>,
    pub aliases: Option<WithLine<Vec<String>>>,
    pub kind: Option<WithLine<BodyKind>>,
    pub parent: Option<WithLine<String>>,
    pub radii_km: Option<WithLine<[f64; 3]>>,
    pub gm_km3_s2: Option<f64>,
    pub geometric_albedo: Option<f64>,
    pub bond_albedo: Option<f64>,
    pub clear_sky_albedo: Option<f64>,
    pub clear_sky_colour: Option<[f64; 3]>,
    pub invented_relief: Option<InventedRelief>,
    pub colour: Option<[f64; 3]>,
    pub photometry: Option<Photometry>,
    pub maps: Maps,
    pub clouds: Option<Clouds>,
    pub mesh: Option<WithLine<ShapeModel>>,
    pub motion: Option<WithLine<Motion>>,
    pub rotation: Option<WithLine<Rotation>>,
    pub sources: BTreeMap<String, String>,
    pub estimates: Estimates,
}

/// The values of the field `model` of `photometry`.
#[derive(Clone, Copy)]
enum PhotometryWord {
    Emissive,
    Lambert,
    LommelSeeliger,
    LunarLambert,
    OrenNayar,
}

fn photometry(mut table: TableReader) -> Option<Photometry> {
    let words = [
        ("emissive", PhotometryWord::Emissive),
        ("lambert", PhotometryWord::Lambert),
        ("lommel-seeliger", PhotometryWord::LommelSeeliger),
        ("lunar-lambert", PhotometryWord::LunarLambert),
        ("oren-nayar", PhotometryWord::OrenNayar),
    ];
    let result = match required_word(&mut table, "model", &words)? {
        PhotometryWord::Emissive => {
            let allowed = "three numbers from -1 to 2 (red, green, blue)";
            let u1 = table.required("u1", allowed, each_component(|x| (-1.0..=2.0).contains(&x)));
            let u2 = table.required("u2", allowed, each_component(|x| (-1.0..=2.0).contains(&x)));
            u1.zip(u2).map(|(u1, u2)| Photometry::Emissive { u1: u1.value, u2: u2.value })
        }
        PhotometryWord::Lambert => Some(Photometry::Lambert),
        PhotometryWord::LommelSeeliger => Some(Photometry::LommelSeeliger),
        PhotometryWord::LunarLambert => {
            required_fraction(&mut table, "lunar_weight").map(|lunar_weight| Photometry::LunarLambert { lunar_weight })
        }
        PhotometryWord::OrenNayar => required_number(&mut table, "roughness_deg", "degrees from 0 to 60", |x| (0.0..=60.0).contains(&x))
            .map(|roughness_deg| Photometry::OrenNayar { roughness_deg }),
    };
    table.finish();
    result
}

/// The values of the field `theory` of `motion`, one for each variant of [`Motion`].
#[derive(Clone, Copy)]
enum MotionWord {
    Planetary,
    GalileanL12,
    Tass17,
    MeanElements,
}

fn motion(mut table: TableReader) -> Option<Motion> {
    let words = [
        ("planetary", MotionWord::Planetary),
        ("galilean-l12", MotionWord::GalileanL12),
        ("tass17", MotionWord::Tass17),
        ("mean-elements", MotionWord::MeanElements),
    ];
    let result = match required_word(&mut table, "theory", &words)? {
        MotionWord::Planetary => Some(Motion::Planetary),
        MotionWord::GalileanL12 => table
            .required("index", "0 Io, 1 Europa, 2 Ganymede or 3 Callisto", |i: &usize| *i < 4)
            .map(|l| Motion::GalileanL12 { index: l.value }),
        MotionWord::Tass17 => table
            .required("index", "0 Mimas, 1 Enceladus, 2 Tethys, 3 Dione, 4 Rhea, 5 Titan, 6 Iapetus or 7 Hyperion", |i: &usize| *i < 8)
            .map(|l| Motion::Tass17 { index: l.value }),
        MotionWord::MeanElements => mean_elements(&mut table).map(Motion::MeanElements),
    };
    table.finish();
    result
}

/// The allowed precession periods of [`MeanElements`], for messages.
const ALLOWED_PERIOD: &str = "Julian years, at least 1e-6 of either sign, or 0 for none";

/// Reads the elements of `motion`; the pole is that of the elements' frame. The ranges of rates and lengths are far wider than those of any body. Beyond
/// them, a position could overflow and become NaN.
fn mean_elements(table: &mut TableReader) -> Option<MeanElements> {
    let any = |_| true;
    let is_period = |x: f64| x == 0.0 || x.abs() >= 1e-6;
    let pole_ra_deg = required_number(table, "pole_ra_deg", "degrees", any);
    let pole_dec_deg = required_pole_dec_deg(table);
    let epoch_jd_tt = required_number(table, "epoch_jd_tt", "a Julian date from -1e8 to 1e8", |x| x.abs() <= 1e8);
    let semi_major_axis_km = required_number(table, "semi_major_axis_km", "kilometres above 0, below 1e15", |x| x > 0.0 && x < 1e15);
    let eccentricity = required_number(table, "eccentricity", "a number from 0 to below 1", |x| (0.0..1.0).contains(&x));
    let inclination_deg = required_number(table, "inclination_deg", "degrees from 0 to 180", |x| (0.0..=180.0).contains(&x));
    let node_deg = required_number(table, "node_deg", "degrees", any);
    let argument_of_periapsis_deg = required_number(table, "argument_of_periapsis_deg", "degrees", any);
    let mean_anomaly_deg = required_number(table, "mean_anomaly_deg", "degrees", any);
    let mean_motion_deg_day = required_number(table, "mean_motion_deg_day", "degrees a day above 0, at most 1e6", |x| x > 0.0 && x <= 1e6);
    let node_period_yr = required_number(table, "node_period_yr", ALLOWED_PERIOD, is_period);
    let argument_period_yr = required_number(table, "argument_period_yr", ALLOWED_PERIOD, is_period);
    let allowed_quadratic = "degrees per Julian century squared from -1e6 to 1e6, 0 if left out";
    let quadratic = table.optional::<f64>("longitude_quadratic_deg_cy2", allowed_quadratic, |v| v.abs() <= 1e6);
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

/// The values of the field `model` of `rotation`, one for each variant of [`Rotation`]. `Fixed`: the pole is fixed, the body rotates.
#[derive(Clone, Copy)]
enum RotationWord {
    EarthIau2006,
    Pck,
    Synchronous,
    Fixed,
}

fn rotation(mut table: TableReader) -> Option<Rotation> {
    let words = [
        ("earth-iau2006", RotationWord::EarthIau2006),
        ("pck", RotationWord::Pck),
        ("synchronous", RotationWord::Synchronous),
        ("fixed", RotationWord::Fixed),
    ];
    let result = match required_word(&mut table, "model", &words)? {
        RotationWord::EarthIau2006 => Some(Rotation::EarthIau2006),
        RotationWord::Pck => Some(Rotation::Pck),
        RotationWord::Synchronous => Some(Rotation::Synchronous),
        RotationWord::Fixed => {
            let pole_ra_deg = required_number(&mut table, "pole_ra_deg", "degrees", |_| true);
            let pole_dec_deg = required_pole_dec_deg(&mut table);
            let w0_deg = required_number(&mut table, "w0_deg", "degrees", |_| true);
            let w_deg_day = required_number(&mut table, "w_deg_day", "degrees a day from -1e6 to 1e6", |x| x.abs() <= 1e6);
            match (pole_ra_deg, pole_dec_deg, w0_deg, w_deg_day) {
                (Some(pole_ra_deg), Some(pole_dec_deg), Some(w0_deg), Some(w_deg_day)) => {
                    Some(Rotation::Fixed { pole_ra_deg, pole_dec_deg, w0_deg, w_deg_day })
                }
                _ => None,
            }
        }
    };
    table.finish();
    result
}

fn clouds(mut table: TableReader) -> Option<Clouds> {
    let height_km = required_number(&mut table, "height_km", "kilometres above 0, at most 1000", |x| x > 0.0 && x <= 1000.0);
    let albedo = required_fraction(&mut table, "albedo");
    let clear_texel = required_fraction(&mut table, "clear_texel");
    let closed_texel = required_number(&mut table, "closed_texel", "a number above clear_texel, at most 1", |x| {
        x <= 1.0 && clear_texel.is_none_or(|clear| x > clear)
    });
    let is_albedo = false;
    let map = read_map(table, is_albedo)?;
    Some(Clouds { map, height_km: height_km?, albedo: albedo?, clear_texel: clear_texel?, closed_texel: closed_texel? })
}

fn mesh(mut table: TableReader) -> Option<WithLine<ShapeModel>> {
    let source_line = table.source_line.clone();
    let file = table.required::<String>("file", "the name of a .obj file without folders", |f| {
        f.to_lowercase().ends_with(".obj") && f.len() > 4 && is_file_name(f)
    });
    let scale_km = table.optional("scale_km", "kilometres above 0, below 1e7", |x: &f64| *x > 0.0 && *x < 1e7);
    let mut flag = |field, default| table.optional::<bool>(field, "true or false", |_| true).map_or(default, |l| l.value);
    let (two_sided, has_map_alpha, uses_vertex_colours) = (flag("two_sided", false), flag("alpha", false), flag("vertex_colours", true));
    let invented = invented_part(&mut table);
    // The source is for people who read the file.
    let _ = table.optional::<String>("source", "a string", |_| true);
    table.finish();
    let scale_km = scale_km.map_or(1.0, |l| l.value);
    let value = ShapeModel { file: file?.value, scale_km, two_sided, has_map_alpha, uses_vertex_colours, invented };
    Some(WithLine { value, source_line })
}

fn maps(mut table: TableReader) -> Maps {
    let mut map = |field| table.section(field).and_then(|t| read_map(t, field == "albedo"));
    let found = Maps { albedo: map("albedo"), normal: map("normal"), specular: map("specular"), night: map("night") };
    table.finish();
    found
}

fn estimates(mut table: TableReader) -> Estimates {
    let found = Estimates {
        albedo_percent: optional_percent(&mut table, "albedo_percent"),
        colour_percent: optional_percent(&mut table, "colour_percent"),
    };
    table.finish();
    found
}

/// Reads one `[[body]]` table and merges it into the draft of the same body, if there is one. Returns the id; `None` without a valid one.
pub(super) fn body(mut table: TableReader, drafts: &mut BTreeMap<i32, BodyDraft>) -> Option<WithLine<i32>> {
    let given = NEEDED_FIELDS.into_iter().filter(|field| table.has(field)).collect();
    let name = table.optional("name", ALLOWED_NAME, is_name);
    let source_line = table.source_line.clone();
    if let Some(name) = &name {
        table.set_message_prefix(&name.value);
    }
    let id = table.required("id", "a NAIF code above 9", |i: &i32| *i > 9);
    if let (None, Some(earlier_name)) = (&name, id.as_ref().and_then(|id| drafts.get(&id.value)?.name.clone())) {
        table.set_message_prefix(&earlier_name.value);
    }
    let mut draft = BodyDraft {
        source_line,
        given,
        name,
        former_names: Vec::new(),
        aliases: table.optional("aliases", "a list of names", |names: &Vec<String>| names.iter().all(is_name)),
        kind: optional_word_with_line(
            &mut table,
            "kind",
            &[
                ("star", BodyKind::Star),
                ("planet", BodyKind::Planet),
                ("dwarf-planet", BodyKind::DwarfPlanet),
                ("moon", BodyKind::Moon),
                ("asteroid", BodyKind::Asteroid),
            ],
        ),
        parent: table.optional("parent", "the name of a body", |_: &String| true),
        radii_km: table.optional("radii_km", "three lengths in km, above 0 and below 1e7", each_component(|x| x > 0.0 && x < 1e7)),
        gm_km3_s2: table.optional("gm_km3_s2", "a number from 0", |v| finite(v) && *v >= 0.0).map(|l| l.value),
        geometric_albedo: table.optional("geometric_albedo", "a number from 0 to 2", |v| (0.0..=2.0).contains(v)).map(|l| l.value),
        bond_albedo: table.optional("bond_albedo", "a number from 0 to 1", |v| (0.0..=1.0).contains(v)).map(|l| l.value),
        invented_relief: optional_word(
            &mut table,
            "invented_relief",
            &[("none", InventedRelief::None), ("craters", InventedRelief::Craters), ("hills", InventedRelief::Hills)],
        ),
        clear_sky_albedo: table.optional("clear_sky_albedo", "a number from 0 to 2", |v| (0.0..=2.0).contains(v)).map(|l| l.value),
        clear_sky_colour: table.optional("clear_sky_colour_linear_srgb", ALLOWED_COLOUR, is_colour).map(|l| l.value),
        colour: table.optional("colour_linear_srgb", ALLOWED_COLOUR, is_colour).map(|l| l.value),
        photometry: table.section("photometry").and_then(photometry),
        maps: table.section("maps").map(maps).unwrap_or_default(),
        clouds: table.section("clouds").and_then(clouds),
        mesh: table.section("mesh").and_then(mesh),
        motion: table.section("motion").and_then(|table| with_line(table, motion)),
        rotation: table.section("rotation").and_then(|table| with_line(table, rotation)),
        sources: table.strings("sources"),
        estimates: table.section("estimates").map(estimates).unwrap_or_default(),
    };
    table.finish();
    let id = id?;
    if let Some(earlier) = drafts.remove(&id.value) {
        // An estimated error belongs to the value given in the same file. If this file replaces the value, the earlier error is dropped.
        let estimate = |new: Option<f64>, is_value_new: bool, earlier: Option<f64>| new.or(earlier.filter(|_| !is_value_new));
        draft.estimates = Estimates {
            albedo_percent: estimate(draft.estimates.albedo_percent, draft.geometric_albedo.is_some(), earlier.estimates.albedo_percent),
            colour_percent: estimate(draft.estimates.colour_percent, draft.colour.is_some(), earlier.estimates.colour_percent),
        };
        // Missing fields are reported where the body is first described.
        draft.source_line = earlier.source_line;
        draft.given.extend(earlier.given);
        draft.former_names = earlier.former_names;
        if draft.name.is_some() {
            draft.former_names.extend(earlier.name);
        } else {
            draft.name = earlier.name;
        }
        draft.aliases = draft.aliases.or(earlier.aliases);
        draft.kind = draft.kind.or(earlier.kind);
        draft.parent = draft.parent.or(earlier.parent);
        draft.radii_km = draft.radii_km.or(earlier.radii_km);
        draft.gm_km3_s2 = draft.gm_km3_s2.or(earlier.gm_km3_s2);
        draft.geometric_albedo = draft.geometric_albedo.or(earlier.geometric_albedo);
        draft.bond_albedo = draft.bond_albedo.or(earlier.bond_albedo);
        draft.invented_relief = draft.invented_relief.or(earlier.invented_relief);
        draft.clear_sky_albedo = draft.clear_sky_albedo.or(earlier.clear_sky_albedo);
        draft.clear_sky_colour = draft.clear_sky_colour.or(earlier.clear_sky_colour);
        draft.colour = draft.colour.or(earlier.colour);
        draft.photometry = draft.photometry.or(earlier.photometry);
        draft.maps = Maps {
            albedo: draft.maps.albedo.or(earlier.maps.albedo),
            normal: draft.maps.normal.or(earlier.maps.normal),
            specular: draft.maps.specular.or(earlier.maps.specular),
            night: draft.maps.night.or(earlier.maps.night),
        };
        draft.clouds = draft.clouds.or(earlier.clouds);
        draft.mesh = draft.mesh.or(earlier.mesh);
        draft.motion = draft.motion.or(earlier.motion);
        draft.rotation = draft.rotation.or(earlier.rotation);
        draft.sources = earlier.sources.into_iter().chain(draft.sources).collect();
    }
    drafts.insert(id.value, draft);
    Some(id)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The smallest f64 times the weight of red is 0: scaled to luminance 1, such a colour would be infinite.
    #[test]
    fn a_colour_without_luminance_is_no_colour() {
        assert!(is_colour(&[1e-6, 0.0, 0.0]) && is_colour(&[0.3, 0.2, 0.1]));
        for wrong in [[5e-324, 0.0, 0.0], [0.0; 3], [-1.0, 1.0, 1.0], [101.0, 0.0, 0.0], [f64::NAN, 1.0, 1.0]] {
            assert!(!is_colour(&wrong), "{wrong:?}");
        }
    }
}
