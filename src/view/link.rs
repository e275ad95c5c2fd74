//! A view as text: a link, or what a file keeps as JSON.
//!
//! In: a [`ViewState`], or a text. Out: the text, or the sight that it restores. Always: what is written down restores the view to the last bit; a text
//! may name bodies or give their codes, and may leave fields out, which are then those that the window begins with: the body that the eye is at, else the Earth;
//! now; the lit side at 3.5 radii; who stands on the ground looks south. A text that no view can have is refused with all its faults. It reads no file.

use crate::catalog::{Catalog, NaifId};
use crate::session::Session;
use crate::time::Instant;
use crate::view::app::initial_view::initial_view;
use crate::view::app::places::SessionPlaces;
use crate::view::app::view_state::{CameraPose, ViewState, standing};
use crate::wording::did_you_mean;
use glam::DVec3;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// What links begin with.
pub const SCHEME: &str = "orrery://view?";

/// Fields of a view that its text may have and its defaults do not write.
const UNWRITTEN: [&str; 2] = ["time", "paused"];
/// A text of more bytes is no view: those that are written have some 600.
const MOST_BYTES: usize = 65_536;
/// Faults that are listed; of each so many characters.
const MOST_FAULTS: usize = 20;
const FAULT_CHARACTERS: usize = 200;

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
/// One line that names each field that cannot be read, or what no view can have.
pub fn restored(text: &str, session: &Session, now: Instant) -> Result<ViewState, String> {
    let catalog = session.catalog();
    let mut told = PartialView::of(text);
    told.name_bodies(catalog);
    let target = told.target();
    let time = told.time().unwrap_or(now);
    let usual = initial_view(catalog, &SessionPlaces(session), target, time)?;
    let view = told.over(&usual, catalog)?;
    // What fields say together, and what the ephemeris knows, is found now, not with each picture.
    let request = view.request(catalog, session.ephemeris(), 64, 64)?;
    session.scene(&request).map_err(|e| e.to_string())?;
    Ok(view)
}

impl ViewState {
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

/// The fields that a text tells, and what is wrong with it.
struct PartialView {
    fields: Map<String, Value>,
    faults: Vec<String>,
}

impl PartialView {
    fn of(text: &str) -> Self {
        if text.len() > MOST_BYTES {
            Self::refused(format!("too long for a view: {} bytes, the limit is {MOST_BYTES}", text.len()))
        } else if is_link(text) {
            Self::of_link(text)
        } else {
            Self::of_json(text)
        }
    }

    fn refused(why: String) -> Self {
        let mut told = Self { fields: Map::new(), faults: Vec::new() };
        told.fault(why);
        told
    }

    /// Texts come from anywhere: a fault is of one line and of no more than can be read.
    fn fault(&mut self, why: String) {
        let plain = |c: char| if c.is_control() { '\u{fffd}' } else { c };
        let mut line: String = why.chars().take(FAULT_CHARACTERS).map(plain).collect();
        if line.len() < why.len() && why.chars().count() > FAULT_CHARACTERS {
            line.push('…');
        }
        self.faults.push(line);
    }

    fn of_link(link: &str) -> Self {
        let Some(query) = query_of(link) else { return Self::refused(format!("a link starts with {SCHEME}")) };
        let mut told = Self { fields: Map::new(), faults: Vec::new() };
        for pair in query.split('&').filter(|p| !p.is_empty()) {
            if let Err(why) = told.take_pair(pair) {
                told.fault(why);
            }
        }
        told
    }

    fn take_pair(&mut self, pair: &str) -> Result<(), String> {
        let (path, text) = pair.split_once('=').ok_or_else(|| format!("`{}`: write field=value", brief(pair)))?;
        let text = unescaped(text).ok_or_else(|| format!("`{}`: invalid %-escape", brief(pair)))?;
        // A field that is text says so by not being a JSON scalar.
        let value = serde_json::from_str(&text).unwrap_or(Value::String(text));
        let Some((above, name)) = path.split_once('.') else {
            if self.fields.get(path).is_some_and(Value::is_object) {
                return Err(format!("`{}` is both a value and a group of fields", brief(path)));
            }
            self.fields.insert(path.to_owned(), value);
            return Ok(());
        };
        if name.contains('.') {
            return Err(format!("`{}`: fields are nested one level deep", brief(path)));
        }
        let below = self.fields.entry(above).or_insert_with(|| Value::Object(Map::new()));
        let map = below.as_object_mut().ok_or_else(|| format!("`{}`: the field above it is a value, not a group", brief(path)))?;
        map.insert(name.to_owned(), value);
        Ok(())
    }

    fn of_json(text: &str) -> Self {
        match serde_json::from_str(text) {
            Ok(fields) => Self { fields, faults: Vec::new() },
            Err(e) => Self::refused(e.to_string()),
        }
    }

    /// Puts codes where bodies are named. One that the catalog does not have is a fault, and is left out.
    fn name_bodies(&mut self, catalog: &Catalog) {
        let mut faults = Vec::new();
        let code = |field: &str, value: &Value| match value {
            Value::String(name) => catalog.named(name).map(|body| body.id).map_err(|e| format!("{field}: {e}")),
            other => match serde_json::from_value(other.clone()).map(NaifId) {
                Ok(id) if catalog.body(id).is_some() => Ok(id),
                Ok(id) => Err(format!("{field}: no body has the code {}", id.0)),
                Err(_) => Err(format!("{field} {other}: write a body's name or its NAIF code")),
            },
        };
        let mut put = |field: &str, map: &mut Map<String, Value>, name: &str| {
            let Some(value) = map.get(name) else { return };
            match code(field, value) {
                Ok(id) => {
                    map.insert(name.to_owned(), Value::from(id.0));
                }
                Err(why) => {
                    map.remove(name);
                    faults.push(why);
                }
            }
        };
        put("target", &mut self.fields, "target");
        if let Some(Value::Object(eye)) = self.fields.get_mut("eye") {
            put("eye.body", eye, "body");
        }
        faults.into_iter().for_each(|why| self.fault(why));
    }

    /// The body that the view is of, once bodies have codes.
    fn target(&self) -> NaifId {
        let of = |value: Option<&Value>| value.and_then(|v| serde_json::from_value(v.clone()).ok()).map(NaifId);
        of(self.fields.get("target")).or(of(self.fields.get("eye").and_then(|eye| eye.get("body")))).unwrap_or(NaifId::EARTH)
    }

    /// `tdb_s`, or `time` as people write it.
    fn time(&mut self) -> Option<Instant> {
        let (seconds, written) = (self.fields.get("tdb_s").cloned(), self.fields.remove("time"));
        if seconds.is_some() && written.is_some() {
            self.fault("time and tdb_s are two forms of one value: leave one out".into());
        }
        if let Some(written) = written {
            let read = read::<String>("time", &written).and_then(|text| Instant::parse(&text).map_err(|e| format!("time: {e}")));
            return read.map_err(|why| self.fault(why)).ok();
        }
        // Whether it is a number is asked with the other fields.
        read("tdb_s", &seconds?).ok().map(Instant::from_tdb_seconds_past_j2000)
    }

    /// The view; what is not told is as in `usual`, an orbit. The written time is in that already.
    fn over(mut self, usual: &ViewState, catalog: &Catalog) -> Result<ViewState, String> {
        let fields = std::mem::take(&mut self.fields);
        let mut whole = object_of(usual);
        for (name, value) in fields {
            match value {
                Value::Object(told) if name == "eye" => {
                    let eye = self.eye_over(told, usual);
                    whole.extend(eye.map(|eye| (name, Value::Object(eye))));
                }
                value => self.put::<ViewState>("", &mut whole, &name, value),
            }
        }
        let view: Option<ViewState> = serde_json::from_value(Value::Object(whole)).map_err(|e| self.fault(e.to_string())).ok();
        // Where a field could not be read its usual value stands, which has no fault.
        view.iter().flat_map(|view| view.faults(catalog)).for_each(|why| self.fault(why));
        match (view, self.faults.as_slice()) {
            (Some(view), []) => Ok(view),
            (_, [one]) => Err(one.clone()),
            (_, all) => {
                let left_out = if all.len() > MOST_FAULTS { "; …" } else { "" };
                Err(format!("{} faults: {}{left_out}", all.len(), all[..all.len().min(MOST_FAULTS)].join("; ")))
            }
        }
    }

    /// Puts a field into the whole of a `T`, if that can be read with it.
    fn put<T: DeserializeOwned>(&mut self, above: &str, whole: &mut Map<String, Value>, name: &str, value: Value) {
        let before = whole.insert(name.to_owned(), value);
        if let Err(e) = serde_json::from_value::<T>(Value::Object(whole.clone())) {
            match before {
                Some(before) => whole.insert(name.to_owned(), before),
                None => whole.remove(name),
            };
            let why = Some(e.to_string()).filter(|why| !why.starts_with("unknown field")).unwrap_or_else(|| {
                let known = whole.keys().map(String::as_str).chain(UNWRITTEN.into_iter().filter(|_| above.is_empty()));
                let hint = did_you_mean(name, known).map_or(String::new(), |hint| format!("; {hint}"));
                format!("no such field{hint}")
            });
            self.fault(format!("{above}{name}: {why}"));
        }
    }

    /// The eye that a text tells: an orbit unless it says otherwise.
    fn eye_over(&mut self, mut told: Map<String, Value>, usual: &ViewState) -> Option<Map<String, Value>> {
        let body = usual.target;
        let kind = told.remove("kind").unwrap_or_else(|| "orbit".into());
        let mut whole = match kind.as_str() {
            Some("orbit") => object_of(&usual.eye),
            Some("ground") => object_of(&standing(body, 0.0, 0.0)),
            Some("centre") => object_of(&CameraPose::Centre { body }),
            Some("free") => {
                for name in ["offset_km", "forward", "up"].into_iter().filter(|name| !told.contains_key(*name)) {
                    self.fault(format!("eye.{name} is missing: a free camera has no default"));
                }
                object_of(&CameraPose::Free { body, offset_km: DVec3::X, forward: DVec3::X, up: DVec3::Z })
            }
            _ => {
                self.fault(format!("eye.kind {kind}: one of orbit, ground, centre, free"));
                return None;
            }
        };
        for (name, value) in told {
            self.put::<CameraPose>("eye.", &mut whole, &name, value);
        }
        Some(whole)
    }
}

/// The beginning of what someone wrote, for a message that has to say more.
fn brief(text: &str) -> String {
    const CHARACTERS: usize = 60;
    let mut all = text.chars();
    let begun: String = all.by_ref().take(CHARACTERS).collect();
    if all.next().is_some() { begun + "…" } else { begun }
}

/// A value, or why it is none, with its field's name.
fn read<T: DeserializeOwned>(field: &str, value: &Value) -> Result<T, String> {
    serde_json::from_value(value.clone()).map_err(|e| format!("{field}: {e}"))
}

fn object_of(value: &impl Serialize) -> Map<String, Value> {
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
    use crate::scene::effects::EffectOverrides;
    use crate::scene::request::{Quality, ToneMap};
    use crate::view::app::view_state::CameraPose;
    use glam::DVec3;

    fn view() -> ViewState {
        let time = Instant::from_tdb_seconds_past_j2000(765_894_000.123_456_7);
        let mut s = ViewState::around(NaifId(699), DVec3::new(1.0, -2.0, 0.7) * 2e5, 60_268.0, DVec3::new(0.08, 0.07, 0.99), time);
        s.effects = EffectOverrides::parse("+eclipse=linear,-rings").expect("effects");
        s.exposure_stops = Some(-1.25);
        s
    }

    /// Another view than those that are written here.
    fn usual() -> ViewState {
        let time = Instant::from_tdb_seconds_past_j2000(5.0);
        ViewState::around(NaifId::MOON, DVec3::new(0.0, 6e3, 1e3), 1737.4, DVec3::Z, time)
    }

    fn catalog() -> &'static Catalog {
        static CATALOG: std::sync::OnceLock<Catalog> = std::sync::OnceLock::new();
        CATALOG.get_or_init(Catalog::embedded)
    }

    fn over_usual(mut told: PartialView) -> Result<ViewState, String> {
        told.name_bodies(catalog());
        told.over(&usual(), catalog())
    }

    fn of_link(link: &str) -> Result<ViewState, String> {
        over_usual(PartialView::of_link(link))
    }

    #[test]
    fn links_and_files_restore_the_view_to_the_last_bit() {
        let eyes = [
            view().eye,
            CameraPose::Ground {
                body: NaifId::EARTH,
                latitude_deg: -33.3,
                longitude_deg: 0.1 + 0.2,
                height_km: 0.0017,
                azimuth_deg: 270.0,
                altitude_deg: 5.0,
            },
            CameraPose::Centre { body: NaifId::EARTH },
            CameraPose::Free { body: NaifId::MOON, offset_km: DVec3::new(1e9, 1.0 / 3.0, 0.0), forward: DVec3::X, up: DVec3::Z },
        ];
        for (eye, paused) in eyes.into_iter().zip([None, Some(true), Some(false), Some(true)]) {
            let view = ViewState { eye, paused, ..view() };
            assert_eq!(of_link(&view.to_link()).as_ref(), Ok(&view), "{}", view.to_link());
            assert_eq!(over_usual(PartialView::of_json(&view.to_json())), Ok(view));
        }
        let link = view().to_link();
        assert!(link.contains("target=699&"), "{link}");
        for form in [link.replacen("orrery://view?", "Orrery://VIEW/?", 1), format!(" {link}\n")] {
            assert!(is_link(&form) && of_link(&form) == Ok(view()), "{form}");
        }
        assert!(!is_link("orrery.json") && !is_link("or"));
    }

    #[test]
    fn what_a_link_leaves_out_is_as_the_window_begins() {
        assert_eq!(of_link("orrery://view"), Ok(usual()));
        assert_eq!(of_link("orrery://view?fov_deg=3"), Ok(ViewState { fov_deg: 3.0, ..usual() }));
        let Ok(ViewState { eye: CameraPose::Orbit { distance_radii: 9.0, azimuth_deg, .. }, .. }) =
            of_link("orrery://view?eye.distance_radii=9")
        else {
            panic!("an orbit at 9 radii")
        };
        assert!(matches!(usual().eye, CameraPose::Orbit { azimuth_deg: usual, .. } if usual == azimuth_deg));
        let ground = of_link("orrery://view?eye.kind=ground&eye.latitude_deg=51.5").map(|s| s.eye);
        assert_eq!(ground, Ok(standing(NaifId::MOON, 51.5, 0.0)));
        let centre = of_link("orrery://view?eye.kind=centre&eye.body=399").map(|s| s.eye);
        assert_eq!(centre, Ok(CameraPose::Centre { body: NaifId::EARTH }));
    }

    #[test]
    fn the_body_and_the_time_of_a_link_are_found_first() {
        let told = |query: &str| {
            let mut told = PartialView::of_link(&format!("orrery://view?{query}"));
            told.name_bodies(catalog());
            told
        };
        assert_eq!(told("").target(), NaifId::EARTH);
        assert_eq!(told("eye.body=301").target(), NaifId::MOON);
        assert_eq!(told("target=599&eye.body=301").target(), NaifId(599));
        assert_eq!(told("").time(), None);
        assert_eq!(told("tdb_s=7.5").time(), Some(Instant::from_tdb_seconds_past_j2000(7.5)));
        let eclipse = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
        assert_eq!(told("time=2024-04-08T18:17:16Z").time(), Some(eclipse));
        for (bad, names) in [("time=noon", "time"), ("time=noon&tdb_s=1", "leave one out"), ("time=3", "time")] {
            let mut told = told(bad);
            assert!(told.time().is_none() && told.faults.iter().any(|why| why.contains(names)), "{bad}: {:?}", told.faults);
        }
    }

    /// Every body, by its name, its name in capitals, each of its aliases and its code, where it is looked at and where it carries the eye.
    #[test]
    fn bodies_are_named_or_given_by_code() {
        for body in catalog().bodies() {
            let names = [body.name.clone(), body.name.to_uppercase(), body.id.0.to_string()];
            for name in names.iter().chain(&body.aliases) {
                let link = format!("orrery://view?target={}&eye.body={}", escaped(name), escaped(name));
                let view = of_link(&link).expect(&link);
                assert_eq!((view.target, view.eye.body()), (body.id, body.id), "{link}");
                let json = format!("{{\"target\": {}}}", Value::from(name.as_str()));
                assert!(
                    name.parse::<i32>().is_ok() || over_usual(PartialView::of_json(&json)).is_ok_and(|s| s.target == body.id),
                    "{json}"
                );
            }
        }
        for bad in ["target=jupitre", "target=", "eye.body=planet%20nine", "target=earth-moon%20barycenter", "target=1.5", "target=true"] {
            let why = of_link(&format!("orrery://view?{bad}")).expect_err(bad);
            let field = bad.split('=').next().unwrap_or_default();
            assert!(why.starts_with(field) && !why.contains('\n'), "{bad}: {why}");
        }
    }

    /// As programs of earlier versions wrote them.
    #[test]
    fn names_of_earlier_versions_are_read() {
        let old = of_link("orrery://view?tone_map=plain&pixels=shaded&quality=reference&effects=-rings").expect("a view");
        let effects = EffectOverrides::parse("-rings").expect("effects");
        assert_eq!(old, ViewState { tone_map: ToneMap::Plain, quality: Quality::Reference, effects, ..usual() });
        assert!(old.to_link().contains("tone_map=clipped&") && old.to_link().contains("pixels=final&"), "{}", old.to_link());
        assert_eq!(of_link("orrery://view?tone_map=film"), Ok(usual()));
    }

    #[test]
    fn slips_in_a_link_are_told_with_what_may_have_been_meant() {
        for (slip, meant) in [
            ("target=satrun", "`Saturn`"),
            ("eye.body=jupitr", "`Jupiter`"),
            ("targte=599", "`target`"),
            ("tiem=now", "`time`"),
            ("pasued=true", "`paused`"),
            ("eye.latitud_deg=3&eye.kind=ground", "`latitude_deg`"),
            ("effects=%2Beclips", "`eclipse`"),
        ] {
            let why = of_link(&format!("orrery://view?{slip}")).expect_err(slip);
            assert!(why.contains("did you mean") && why.contains(meant), "{slip}: {why}");
        }
        assert!(of_link("orrery://view?qqqq=1").is_err_and(|why| !why.contains("did you mean")), "nothing is near");
    }

    #[test]
    fn broken_links_are_refused_in_one_line() {
        let good = view().to_link();
        for (bad, names) in [
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
            ("orrery://view?tdb_s=now".into(), "tdb_s"),
            ("orrery://view?eye.latitude_deg=3".into(), "latitude_deg"),
            (format!("orrery://view?{}=1", "a.".repeat(30_000)), "deep"),
            (format!("orrery://view?{}", "a=1&".repeat(30_000)), "bytes"),
            ("orrery://view?quality=be%0Ast".into(), "quality"),
        ] {
            let why = over_usual(PartialView::of(&bad)).expect_err(names);
            assert!(why.contains(names) && !why.contains('\n') && why.len() < 1000, "{}: {why}", brief(&bad));
        }
        assert!(of_link("https://x").is_err_and(|why| why.contains("orrery://")));
        for bad in ["", "[1]", "{\"target\":", "7"] {
            assert!(over_usual(PartialView::of_json(bad)).is_err_and(|why| !why.contains('\n')), "{bad}");
        }
    }

    /// Any few of these faults together are all told, each once, by the field's name.
    #[test]
    fn all_faults_of_a_link_are_listed() {
        let faults = [
            ("target=jupitre", "jupitre"),
            ("aim=3", "aim"),
            ("fov_deg=500", "fov_deg"),
            ("roll_deg=left", "roll_deg"),
            ("effects=%2Bwings", "wings"),
            ("tone_map=sepia", "sepia"),
            ("pixels=colour", "colour"),
            ("quality=best", "best"),
            ("exposure_stops=900", "exposure_stops"),
            ("paused=maybe", "paused"),
            ("eye.distance_radii=far", "eye.distance_radii"),
            ("eye.azimuth=3", "azimuth"),
            ("eye.body=nowhere", "nowhere"),
            ("bloom", "bloom"),
            ("orbits=%zz", "orbits"),
        ];
        for chosen in (1_u32..1 << faults.len()).filter(|bits| bits.count_ones() == 2 || bits.count_ones() > 13) {
            let of_these = |k: &usize| chosen & (1 << k) != 0;
            let pairs: Vec<&str> = (0..faults.len()).filter(of_these).map(|k| faults[k].0).collect();
            let link = format!("orrery://view?{}", pairs.join("&"));
            let why = of_link(&link).expect_err(&link);
            assert!(why.starts_with(&format!("{} faults: ", pairs.len())), "{link}: {why}");
            for (k, (_, name)) in faults.iter().enumerate() {
                assert_eq!(why.contains(name), of_these(&k), "{link}: `{name}` in {why}");
            }
        }
        let many: String = (0..500).map(|k| format!("f{k}=1&")).collect();
        let why = of_link(&format!("orrery://view?{many}")).expect_err("500 fields");
        assert!(why.starts_with("500 faults: ") && why.ends_with('…') && why.len() < 6000, "{why}");
    }
}
