//! Texts of the module layers below the window have translations: reasons in scenes by their message ids, texts of the shipped catalogs by their names.

use crate::support::sweep;
use crate::view::interface::session;
use crate::view::marked_texts::Scan;
use orrery::catalog::NaifId;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Layers, Position, Purpose, Quality, ViewRequest};
use orrery::time::Instant;
use orrery::view::language::{self, Language, catalog_entry_text, catalog_text, message_text, reason_text};
use std::collections::BTreeSet;

/// Bodies that differ in what they have: air, clouds, rings, a shape model, an invented map.
const BODIES: [&str; 14] =
    ["Sun", "Mercury", "Venus", "Earth", "Moon", "Mars", "Phobos", "Jupiter", "Io", "Saturn", "Titan", "Iapetus", "Triton", "Vesta"];

/// Every reason has a message, in scenes of many bodies and all moments, by day and night, near and far, with effects switched on and off.
#[test]
fn reasons_of_scenes_are_messages() {
    language::set(Language::MarkedEnglish);
    let mut scan = Scan::new();
    let catalog = session().catalog();
    let time = Instant::parse("2024-04-08T18:30:00Z").expect("a time");
    let named = BODIES.map(|name| catalog.bodies().iter().find(|body| body.name == name).expect(name));
    let targets =
        named.iter().map(|body| (body.id, time)).chain(catalog.moments().iter().filter_map(|m| Some((catalog.body(m.target)?.id, m.time))));
    let mut effects = BTreeSet::new();
    for (k, (target, time)) in targets.enumerate().filter(|(k, _)| sweep::runs(*k, 4)) {
        for (n, distance_radii) in [Some(1.001), Some(3.0), Some(400.0)].into_iter().enumerate() {
            let overrides =
                ["", "+eclipse=linear,+atmosphere=vertex", "-clouds,-eclipse,-atmosphere", "+atmosphere=table,+planet-shine,+ring-shine"]
                    [(k + n) % 4];
            let request = ViewRequest {
                position: Position::AboveTarget { towards: (target != NaifId::SUN && k % 2 == 0).then_some(NaifId::SUN), distance_radii },
                width: 96,
                height: 64,
                quality: [Quality::Draft, Quality::Standard][k % 2],
                effects: EffectOverrides::parse(overrides).expect("effects"),
                layers: if n == 0 { Layers::default() } else { Layers::ALL },
                purpose: if k % 3 == 2 { Purpose::Linear { floor: 1e-6 } } else { Purpose::Display },
                ..ViewRequest::of(target, time)
            };
            let Ok(scene) = session().scene(&request) else { continue };
            let mut reasons = vec![reason_text(&scene.exposure.reason)];
            for decision in scene.bodies.iter().flat_map(|body| &body.decisions).chain(&scene.sky_decisions) {
                effects.insert(decision.effect);
                reasons.push(reason_text(&decision.description()));
            }
            reasons.sort();
            reasons.dedup();
            scan.check(&format!("{target:?}"), reasons);
        }
    }
    let (min_effects, min_reasons) = if sweep::in_full() { (36, 2001) } else { (20, 201) };
    assert!(effects.len() >= min_effects && scan.checked >= min_reasons, "{} effects, {} reasons", effects.len(), scan.checked);
    assert!(scan.errors.is_empty(), "{} of {} texts: {:#?}", scan.errors.len(), scan.checked, scan.errors);
    language::set(Language::English);
}

/// The texts of moments, tours and estimates in the shipped catalogs have messages.
#[test]
fn texts_of_catalogs_are_messages() {
    language::set(Language::MarkedEnglish);
    let mut scan = Scan::new();
    let catalog = session().catalog();
    let mut texts: Vec<String> = Vec::new();
    for moment in catalog.moments() {
        texts.push(catalog_text("moment", &moment.name).into_owned());
        texts.push(catalog_entry_text("moment", &moment.name, "about", &moment.about).into_owned());
    }
    for body in catalog.bodies() {
        texts.extend(body.estimate_notes().iter().map(message_text));
        let species = body.atmosphere.iter().flat_map(|air| &air.species);
        texts.extend(species.map(|species| catalog_text("species", &species.name).into_owned()));
    }
    texts.extend(orrery::catalog::cities::all().iter().map(|city| catalog_text("country", city.country).into_owned()));
    for (title, about, text) in orrery_catalogs::TOURS {
        let tour: serde_json::Value = serde_json::from_str(text).expect("JSON");
        texts.extend([catalog_text("tour", title), catalog_entry_text("tour", title, "about", about)].map(Into::into));
        for (k, stop) in tour["stops"].as_array().expect("stops").iter().enumerate() {
            let stop_text = stop["text"].as_str().expect("a text");
            texts.push(catalog_entry_text("tour", title, &(k + 1).to_string(), stop_text).into_owned());
        }
    }
    assert!(texts.len() > 100, "{} texts", texts.len());
    scan.check("catalogs", texts);
    assert!(scan.errors.is_empty(), "{:#?}", scan.errors);
    language::set(Language::English);
}
