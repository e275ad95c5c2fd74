//! A view as text: a link, or what a file keeps as JSON.
//!
//! In: a [`Sight`], or a text. Out: the text, or the sight that it restores. Always: what is written down restores the view to the last bit; a text
//! may leave fields out, which are then those that the window begins with: the body that the eye is at, else the Earth; now; the lit side at 3.5
//! radii; who stands on the ground looks south. It reads no file.

use super::first::first_view;
use super::interface::SessionPlaces;
use super::sight::{FOV_LEAST_DEG, FOV_MOST_DEG, Sight, standing};
use crate::catalog::NaifId;
use crate::scene::effects::EffectOverrides;
use crate::session::Session;
use crate::time::Instant;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// What links begin with.
pub const SCHEME: &str = "orrery://view?";

/// Whether this is meant as a link, whatever it is worth.
pub fn is_link(text: &str) -> bool {
    text.trim().get(.."orrery:".len()).is_some_and(|scheme| scheme.eq_ignore_ascii_case("orrery:"))
}

/// What a link asks for: of one as it was written, and of one that a system has put into another form (`Orrery://view/?…`).
fn query_of(link: &str) -> Option<&str> {
    let (place, query) = link.trim().split_once('?').unwrap_or((link.trim(), ""));
    let place = place.trim_end_matches('/');
    SCHEME.trim_end_matches('?').eq_ignore_ascii_case(place).then_some(query)
}

/// The view that a link or a file's text keeps. `now`: the time of one that tells none.
///
/// # Errors
/// One line that names the field, or what no view can have.
pub fn restored(text: &str, session: &Session, now: Instant) -> Result<Sight, String> {
    let told = if is_link(text) { Told::of_link(text) } else { Told::of_json(text) }?;
    let usual = first_view(session.catalog(), &SessionPlaces(session), told.target()?, told.time()?.unwrap_or(now))?;
    let sight = told.over(&usual)?;
    // What no view can have is found now, not with each picture.
    let request = sight.request(session.catalog(), session.ephemeris(), 64, 64)?;
    session.scene(&request).map_err(|e| e.to_string())?;
    Ok(sight)
}

impl Sight {
    /// `orrery://view?target=699&eye.kind=orbit&…`: every field of the value by its path.
    pub fn to_link(&self) -> String {
        let mut pairs = Vec::new();
        flatten("", &serde_json::to_value(self).unwrap_or_default(), &mut pairs);
        format!("{SCHEME}{}", pairs.iter().map(|(k, v)| format!("{k}={}", escaped(v))).collect::<Vec<_>>().join("&"))
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

/// The fields that a text tells.
struct Told(Map<String, Value>);

impl Told {
    fn of_link(link: &str) -> Result<Self, String> {
        let query = query_of(link).ok_or_else(|| format!("a link begins with {SCHEME}"))?;
        let mut root = Value::Object(Map::new());
        for pair in query.split('&').filter(|p| !p.is_empty()) {
            let (path, text) = pair.split_once('=').ok_or_else(|| format!("`{pair}`: write field=value"))?;
            let text = unescaped(text).ok_or_else(|| format!("`{pair}`: broken %-escape"))?;
            // A field that is text says so by not being a JSON scalar.
            let value = serde_json::from_str(&text).unwrap_or(Value::String(text));
            let mut at = &mut root;
            for step in path.split('.') {
                let map = at.as_object_mut().ok_or_else(|| format!("`{path}` stands below a plain value"))?;
                at = map.entry(step).or_insert_with(|| Value::Object(Map::new()));
            }
            *at = value;
        }
        Ok(Self(root.as_object().cloned().unwrap_or_default()))
    }

    fn of_json(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map(Self).map_err(|e| e.to_string())
    }

    /// The body that the view is of.
    fn target(&self) -> Result<NaifId, String> {
        let eye_body = self.0.get("eye").and_then(|eye| eye.get("body"));
        let target = read("target", self.0.get("target"))?;
        Ok(target.or(read("eye.body", eye_body)?).unwrap_or(NaifId::EARTH))
    }

    /// `tdb_s`, or `time` as people write it.
    fn time(&self) -> Result<Option<Instant>, String> {
        let seconds: Option<f64> = read("tdb_s", self.0.get("tdb_s"))?;
        let written: Option<String> = read("time", self.0.get("time"))?;
        match (seconds, written) {
            (Some(_), Some(_)) => Err("time and tdb_s tell the same: leave one out".into()),
            (Some(s), None) => Ok(Some(Instant::from_tdb_seconds_past_j2000(s))),
            (None, Some(text)) => Instant::parse(&text).map(Some).map_err(|e| format!("time: {e}")),
            (None, None) => Ok(None),
        }
    }

    /// The view; what is not told is as in `usual`.
    fn over(self, usual: &Sight) -> Result<Sight, String> {
        let mut whole = object_of(usual);
        for (name, value) in self.0 {
            let value = match value {
                Value::Object(told) if name == "eye" => Value::Object(eye_over(told, usual)),
                value => value,
            };
            // The written time is in `usual`.
            if name != "time" {
                whole.insert(name, value);
            }
        }
        let sight: Sight = serde_json::from_value(Value::Object(whole)).map_err(|e| e.to_string())?;
        EffectOverrides::parse(&sight.effects).map_err(|e| e.to_string())?;
        let finite = sight.tdb_s.is_finite() && sight.roll_deg.is_finite() && (FOV_LEAST_DEG..=FOV_MOST_DEG).contains(&sight.fov_deg);
        if finite { Ok(sight) } else { Err(format!("fov_deg must be {FOV_LEAST_DEG} to {FOV_MOST_DEG}, times and angles numbers")) }
    }
}

fn read<T: DeserializeOwned>(name: &str, value: Option<&Value>) -> Result<Option<T>, String> {
    value.map(|v| serde_json::from_value(v.clone()).map_err(|e| format!("{name}: {e}"))).transpose()
}

/// The eye that a text tells: an orbit unless it says otherwise.
fn eye_over(told: Map<String, Value>, usual: &Sight) -> Map<String, Value> {
    let mut whole = match told.get("kind").and_then(Value::as_str) {
        None | Some("orbit") => object_of(&usual.eye),
        Some("ground") => object_of(&standing(usual.target, 0.0, 0.0)),
        Some(_) => Map::from_iter([("body".to_owned(), Value::from(usual.target.0))]),
    };
    whole.extend(told);
    whole
}

fn object_of(value: &impl serde::Serialize) -> Map<String, Value> {
    match serde_json::to_value(value) {
        Ok(Value::Object(map)) => map,
        _ => Map::new(),
    }
}

fn flatten(path: &str, value: &Value, out: &mut Vec<(String, String)>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(k, v)| {
            let below = if path.is_empty() { k.clone() } else { format!("{path}.{k}") };
            flatten(&below, v, out);
        }),
        Value::Null => {}
        // Text that reads as a JSON scalar keeps its quotes.
        Value::String(s) if serde_json::from_str::<Value>(s).is_err() => out.push((path.to_owned(), s.clone())),
        other => out.push((path.to_owned(), other.to_string())),
    }
}

fn escaped(text: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-_.~+,:[]".contains(&b);
    text.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

fn unescaped(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        (rest, _) = match (first, tail) {
            (b'%', [a, b, tail @ ..]) => {
                let hex = std::str::from_utf8(&[*a, *b]).ok().and_then(|h| u8::from_str_radix(h, 16).ok())?;
                (tail, bytes.push(hex))
            }
            (b'%', _) => return None,
            _ => (tail, bytes.push(*first)),
        };
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::sight::Eye;
    use glam::DVec3;

    fn sight() -> Sight {
        let time = Instant::from_tdb_seconds_past_j2000(765_894_000.123_456_7);
        let mut s = Sight::around(NaifId(699), DVec3::new(1.0, -2.0, 0.7) * 2e5, 60_268.0, DVec3::new(0.08, 0.07, 0.99), time);
        s.effects = "+eclipse=linear,-rings".into();
        s.exposure_stops = Some(-1.25);
        s
    }

    /// Another view than those that are written here.
    fn usual() -> Sight {
        let time = Instant::from_tdb_seconds_past_j2000(5.0);
        Sight::around(NaifId::MOON, DVec3::new(0.0, 6e3, 1e3), 1737.4, DVec3::Z, time)
    }

    fn of_link(link: &str) -> Result<Sight, String> {
        Told::of_link(link)?.over(&usual())
    }

    #[test]
    fn links_and_files_restore_the_view_to_the_last_bit() {
        let eyes = [
            sight().eye,
            Eye::Ground {
                body: NaifId::EARTH,
                latitude_deg: -33.3,
                longitude_deg: 0.1 + 0.2,
                height_km: 0.0017,
                azimuth_deg: 270.0,
                altitude_deg: 5.0,
            },
            Eye::Centre { body: NaifId::EARTH },
            Eye::Free { body: NaifId::MOON, offset_km: DVec3::new(1e9, 1.0 / 3.0, 0.0), forward: DVec3::X, up: DVec3::Z },
        ];
        for eye in eyes {
            let sight = Sight { eye, ..sight() };
            assert_eq!(of_link(&sight.to_link()).as_ref(), Ok(&sight), "{}", sight.to_link());
            assert_eq!(Told::of_json(&sight.to_json()).and_then(|told| told.over(&usual())), Ok(sight));
        }
        let link = sight().to_link();
        assert!(link.contains("target=699&"), "{link}");
        for form in [link.replacen("orrery://view?", "Orrery://VIEW/?", 1), format!(" {link}\n")] {
            assert!(is_link(&form) && of_link(&form) == Ok(sight()), "{form}");
        }
        assert!(!is_link("orrery.json") && !is_link("or"));
    }

    #[test]
    fn what_a_link_leaves_out_is_as_the_window_begins() {
        assert_eq!(of_link("orrery://view"), Ok(usual()));
        assert_eq!(of_link("orrery://view?fov_deg=3"), Ok(Sight { fov_deg: 3.0, ..usual() }));
        let Ok(Sight { eye: Eye::Orbit { distance_radii: 9.0, azimuth_deg, .. }, .. }) = of_link("orrery://view?eye.distance_radii=9")
        else {
            panic!("an orbit at 9 radii")
        };
        assert!(matches!(usual().eye, Eye::Orbit { azimuth_deg: usual, .. } if usual == azimuth_deg));
        let ground = of_link("orrery://view?eye.kind=ground&eye.latitude_deg=51.5").map(|s| s.eye);
        assert_eq!(ground, Ok(standing(NaifId::MOON, 51.5, 0.0)));
        let centre = of_link("orrery://view?eye.kind=centre&eye.body=399").map(|s| s.eye);
        assert_eq!(centre, Ok(Eye::Centre { body: NaifId::EARTH }));
    }

    #[test]
    fn the_body_and_the_time_of_a_link_are_found_first() {
        let told = |query: &str| Told::of_link(&format!("orrery://view?{query}")).expect(query);
        assert_eq!(told("").target(), Ok(NaifId::EARTH));
        assert_eq!(told("eye.body=301").target(), Ok(NaifId::MOON));
        assert_eq!(told("target=599&eye.body=301").target(), Ok(NaifId(599)));
        assert_eq!(told("").time(), Ok(None));
        assert_eq!(told("tdb_s=7.5").time(), Ok(Some(Instant::from_tdb_seconds_past_j2000(7.5))));
        let eclipse = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
        assert_eq!(told("time=2024-04-08T18:17:16Z").time(), Ok(Some(eclipse)));
        for (bad, names) in [("time=noon", "time"), ("time=noon&tdb_s=1", "leave one out"), ("tdb_s=now", "tdb_s")] {
            let why = told(bad).time().expect_err(bad);
            assert!(why.contains(names) && !why.contains('\n'), "{bad}: {why}");
        }
        assert!(told("target=jupiter").target().is_err_and(|why| why.contains("target")));
    }

    #[test]
    fn broken_links_are_refused_in_one_line() {
        let good = sight().to_link();
        for (bad, names) in [
            ("https://x".to_owned(), "orrery://"),
            (good.replace("view?", "look?"), "orrery://"),
            (good.replace("target", "aim"), "aim"),
            (good.replace("fov_deg=45.0", "fov_deg=0"), "fov_deg"),
            (good.replace("eye.kind=orbit", "eye.kind=perch"), "perch"),
            (good.replace("%3D", "%3"), "escape"),
            (good.replace("-rings", "-wings"), "wings"),
            (format!("{good}&target.x=1"), "target"),
            ("orrery://view?eye=3".into(), "3"),
            ("orrery://view?eye.kind=free".into(), "offset_km"),
            ("orrery://view?tdb_s=1e999".into(), "1e999"),
        ] {
            let why = of_link(&bad).expect_err(&bad);
            assert!(why.contains(names) && !why.contains('\n'), "{bad}: {why}");
        }
        for bad in ["", "[1]", "{\"target\":", "7"] {
            assert!(Told::of_json(bad).is_err_and(|why| !why.contains('\n')), "{bad}");
        }
    }
}
